//! The paper's results as numbers: D. Powell, T. I. Zohdi, "Attachment mode performance of network-modeled ballistic fabric
//! shielding", Composites Part B 40 (2009) 451-460.
//!
//! After the first failure the model is chaotic, so every macro point is an ensemble of runs. Runs are kept in runs.jsonl
//! (jobs.rs): a study that is broken off goes on where it was. paper.json says which runs make which point; `python3 -m reports
//! paper` compares them with the paper's claims and draws the figures, without a run.

mod jobs;
mod micro;
mod plan;
mod vtk;

use crate::effort::{self, Effort};
use crate::machine::Wall;
use crate::picture::{self, Picture};
use crate::{Result, report, say};
use clap::{Args, ValueEnum};
use jobs::{Job, Runs};
use plan::{Point, Yarn};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Options of `paper`.
#[derive(Args)]
pub struct Options {
    /// Only this figure of the paper, or the map of the open question; may be given several times.
    #[arg(long, value_name = "NAME")]
    figure: Vec<Chosen>,
    #[command(flatten)]
    flags: effort::Flags,
    /// Also write one run (3 in sheet, corners, 40 J) as a series of sheets, which the report makes a VTK series for ParaView.
    #[arg(long)]
    vtk: bool,
    /// Do no runs: take what the kept ones give; the report says how many are missing.
    #[arg(long, conflicts_with = "smoke")]
    kept: bool,
    /// Folder of the numbers and the kept runs.
    #[arg(long, value_name = "DIR", default_value = "target/study/paper")]
    out: PathBuf,
}

/// A figure on the command line.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Chosen {
    #[value(name = "3")]
    Fig3,
    #[value(name = "5")]
    Fig5,
    #[value(name = "6")]
    Fig6,
    #[value(name = "9")]
    Fig9,
    #[value(name = "10")]
    Fig10,
    #[value(name = "11")]
    Fig11,
    #[value(name = "12")]
    Fig12,
    #[value(name = "13")]
    Fig13,
    #[value(name = "14")]
    Fig14,
    #[value(name = "15")]
    Fig15,
    #[value(name = "16")]
    Fig16,
    #[value(name = "17")]
    Fig17,
    #[value(name = "18")]
    Fig18,
    #[value(name = "19")]
    Fig19,
    #[value(name = "20")]
    Fig20,
    /// The open question: uniform over stochastic yarn at the corners, over everything the paper leaves open.
    Map,
}

/// paper.json: what was computed, and which kept runs it is.
#[derive(Serialize)]
struct Index {
    smoke: bool,
    /// The figures that were asked for; none: all.
    figures: Vec<String>,
    /// What is left out against the full study, in words.
    left_out: Option<String>,
    /// Runs that were wanted and have not been done.
    missing: usize,
    energies: &'static [f64],
    velocities: &'static [f64],
    map_energies: &'static [f64],
    history_energies: [f64; 2],
    washers: Vec<&'static str>,
    points: Vec<Ensemble>,
    /// Deformed sheets: those of one run stand together, in the order of their times.
    pictures: Vec<Picture>,
    /// The frames of the VTK series.
    frames: Vec<Picture>,
}

/// A point: what was done, and the keys of its runs in runs.jsonl.
#[derive(Serialize)]
struct Ensemble {
    sheet: &'static str,
    attachment: &'static str,
    washer: &'static str,
    yarn: &'static str,
    impact_j: f64,
    impact_m_per_s: f64,
    keys: Vec<String>,
}

impl Ensemble {
    fn of(point: &Point, effort: Effort, runs: &Runs) -> Ensemble {
        Ensemble {
            sheet: point.sheet.name(),
            attachment: plan::attachment_name(point.attachment),
            washer: plan::WASHERS[point.washer].name,
            yarn: point.yarn.name(),
            impact_j: point.energy(),
            impact_m_per_s: point.scene(effort, 0).projectile.velocity[2],
            keys: runs.keys(point),
        }
    }
}

/// What is computed.
struct Study<'a> {
    options: &'a Options,
    effort: Effort,
}

impl Study<'_> {
    /// Whether any of these figures is wanted.
    fn wants(&self, figures: &[Chosen]) -> bool {
        self.options.figure.is_empty() || figures.iter().any(|figure| self.options.figure.contains(figure))
    }

    fn figures(&self) -> Vec<String> {
        let name = |figure: &Chosen| Some(figure.to_possible_value()?.get_name().to_string());
        self.options.figure.iter().filter_map(name).collect()
    }

    /// Every point that the wanted figures need.
    fn points(&self) -> Vec<Point> {
        use Chosen::*;
        let mut points = Vec::new();
        if self.wants(&[Fig10, Fig12]) {
            points.extend(plan::picture_points(self.effort));
        }
        if self.wants(&[Fig13]) {
            points.extend(plan::large_points(self.effort));
        }
        if self.wants(&[Fig14, Fig15, Fig16, Fig17, Fig18, Fig19, Fig20]) {
            points.extend(plan::small_points(self.effort, Yarn::Stochastic));
        }
        if self.wants(&[Fig18, Fig19, Fig20]) {
            points.extend(plan::small_points(self.effort, Yarn::Uniform));
            points.extend(plan::mirrored_points(self.effort));
        }
        if self.wants(&[Map]) {
            points.extend(plan::map_points(self.effort));
        }
        points
    }

    /// The runs whose sheets are kept for pictures.
    fn pictured(&self) -> Vec<Job> {
        if !self.wants(&[Chosen::Fig10, Chosen::Fig12]) {
            return Vec::new();
        }
        let job = |point: Point| point.job(self.effort, 0, plan::picture_times(self.effort, point.attachment));
        plan::picture_points(self.effort).into_iter().map(job).collect()
    }

    /// The runs of these points; those of the pictures keep their sheets.
    fn jobs(&self, points: &[Point]) -> Vec<Job> {
        let mut jobs = self.pictured();
        for point in points {
            jobs.extend((0..point.runs).map(|k| point.job(self.effort, k, &[])));
        }
        jobs
    }

    fn pictures(&self, out: &Path) -> Result<Vec<Picture>> {
        let mut pictures = Vec::new();
        for job in self.pictured().iter().filter(|job| job.has_pictures(out)) {
            for &time in job.pictures {
                let file = jobs::picture_file(&job.key(), time);
                pictures.push(picture::describe(out, file, job.name.clone(), &job.scene)?);
            }
        }
        Ok(pictures)
    }
}

/// Computes what is missing, and writes.
pub fn run(options: &Options) -> Result<bool> {
    let wall = Wall::start();
    let effort = options.flags.effort();
    let out = &options.out;
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    if effort == Effort::Smoke && jobs::path_of_runs(out).exists() {
        // A smoke test that takes kept runs would test nothing.
        std::fs::remove_file(jobs::path_of_runs(out))?;
    }
    let study = Study { options, effort };
    micro::compute(effort.yarns(), out)?;
    let points = study.points();
    let runs = Runs::complete(out, effort, study.jobs(&points), options.kept)?;
    let index = Index {
        smoke: effort == Effort::Smoke,
        figures: study.figures(),
        left_out: effort.left_out(),
        missing: runs.missing,
        energies: effort.energies(),
        velocities: effort.velocities(),
        map_energies: effort.map_energies(),
        history_energies: plan::HISTORY_ENERGIES,
        washers: plan::WASHERS[..effort.washers()].iter().map(|washer| washer.name).collect(),
        points: points.iter().map(|point| Ensemble::of(point, effort, &runs)).collect(),
        pictures: study.pictures(out)?,
        frames: if options.vtk { vtk::series(out, effort)? } else { Vec::new() },
    };
    std::fs::write(out.join("paper.json"), serde_json::to_string(&index)? + "\n")?;
    say::line(format_args!(
        "{} runs done, {} taken from {}; {:.0} s",
        runs.done,
        runs.kept,
        jobs::path_of_runs(out).display(),
        wall.seconds()
    ));
    say::line(format_args!("{}", report::written(out, "paper")));
    Ok(true)
}
