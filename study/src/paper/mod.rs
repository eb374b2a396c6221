//! The paper's results, each as a figure beside its claim: D. Powell, T. I. Zohdi, "Attachment mode performance of
//! network-modeled ballistic fabric shielding", Composites Part B 40 (2009) 451-460.
//!
//! After the first failure the model is chaotic, so every macro point is an ensemble with its 95 % interval, and verdicts are
//! computed from intervals (statistics.rs). Runs are kept in runs.jsonl (jobs.rs): a study that is broken off goes on
//! where it was, and the report can be written again without a run.

mod claims;
mod figures;
mod html;
mod jobs;
mod map;
mod micro;
mod plan;
mod sheets;
mod statistics;
mod vtk;

use crate::Result;
use crate::machine::Wall;
use clap::{Args, ValueEnum};
use html::{Figure, Page};
use jobs::{Job, Runs};
use plan::{Effort, Point, Yarn};
use std::path::{Path, PathBuf};

/// Options of `paper`.
#[derive(Args)]
pub struct Options {
    /// Only this figure of the paper, or the map of the open question; may be given several times.
    #[arg(long, value_name = "NAME")]
    figure: Vec<Chosen>,
    /// Fewer points and runs: about three minutes on 2 quiet cores instead of an hour. The report says what is left out.
    #[arg(long)]
    quick: bool,
    /// Tiny sheets: seconds, to see that everything works.
    #[arg(long, conflicts_with = "quick")]
    smoke: bool,
    /// Also write one run (3 in sheet, corners, 40 J) as a VTK series that ParaView opens, to DIR/vtk/run.pvd.
    #[arg(long)]
    vtk: bool,
    /// Folder of the report, the tables, the plots and the kept runs.
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

const TITLE: &str = "Powell and Zohdi (2009), reproduced";

const RULE: &str = "Rule of the verdicts: a claim is read as a range that a quantity must lie in (column \"read as\"; the \
    rows on where, in which order and at how many places sheets fail were worded after first results). \"Agrees\" if the whole 95 % interval lies inside the range, \"does not\" if none of it does, otherwise \"cannot be told\". A claim \
    about several energies or attachments agrees if all do, and does not if one does not. The intervals are not corrected for \
    their number: of twenty true claims about one quantity each, one may come out wrong.";

/// What is computed and shown.
struct Study<'a> {
    options: &'a Options,
    effort: Effort,
}

impl Study<'_> {
    /// Whether any of these figures is wanted.
    fn wants(&self, figures: &[Chosen]) -> bool {
        self.options.figure.is_empty() || figures.iter().any(|figure| self.options.figure.contains(figure))
    }

    /// Every point that the wanted figures need.
    fn points(&self) -> Vec<Point> {
        use Chosen::*;
        let mut points = Vec::new();
        if self.wants(&[Fig10, Fig12]) {
            points.extend(figures::picture_points(self.effort));
        }
        if self.wants(&[Fig13]) {
            points.extend(figures::large_points(self.effort));
        }
        if self.wants(&[Fig14, Fig15, Fig16, Fig17, Fig18, Fig19, Fig20]) {
            points.extend(figures::small_points(self.effort, Yarn::Stochastic));
        }
        if self.wants(&[Fig18, Fig19, Fig20]) {
            points.extend(figures::small_points(self.effort, Yarn::Uniform));
            points.extend(figures::mirrored_points(self.effort));
        }
        if self.wants(&[Map]) {
            points.extend(map::points(self.effort));
        }
        points
    }

    /// The claims that the wanted figures answer.
    fn claims(&self, micro: &micro::Micro, runs: &Runs) -> Vec<claims::Claim> {
        use Chosen::*;
        let mut claims = Vec::new();
        if self.wants(&[Fig3, Fig5, Fig6]) {
            claims.extend(claims::of_micro(micro));
        }
        if self.wants(&[Fig14, Fig15, Fig16, Fig17]) {
            claims.extend(claims::of_attachments(runs, self.effort));
        }
        if self.wants(&[Fig18, Fig19, Fig20]) {
            claims.extend(claims::of_uniform(runs, self.effort));
        }
        if self.wants(&[Map]) {
            claims.extend(claims::of_map(runs, self.effort));
        }
        claims
    }

    /// The runs of these points; those of the pictures keep their sheets.
    fn jobs(&self, points: &[Point]) -> Vec<Job> {
        let mut jobs = Vec::new();
        if self.wants(&[Chosen::Fig10, Chosen::Fig12]) {
            let times = |point: &Point| sheets::times(self.effort, point.attachment);
            let points = figures::picture_points(self.effort);
            jobs.extend(points.iter().map(|point| point.job(self.effort, 0, times(point))));
        }
        for point in points {
            jobs.extend((0..point.runs).map(|k| point.job(self.effort, k, &[])));
        }
        jobs
    }
}

/// Computes what is missing, writes and prints.
pub fn run(options: &Options) -> Result<bool> {
    let wall = Wall::start();
    let effort = if options.smoke {
        Effort::Smoke
    } else if options.quick {
        Effort::Quick
    } else {
        Effort::Full
    };
    let out = &options.out;
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    if options.smoke && jobs::path_of_runs(out).exists() {
        // A smoke test that takes kept runs would test nothing.
        std::fs::remove_file(jobs::path_of_runs(out))?;
    }
    let study = Study { options, effort };
    let micro = micro::compute(effort.yarns())?;
    println!(
        "micro scale: {} yarns of 350 fibrils drawn and fitted in {:.2} s on one core",
        micro.count(),
        micro.seconds
    );
    let points = study.points();
    let runs = Runs::complete(out, effort, study.jobs(&points))?;

    let mut page = Page::new(TITLE);
    introduction(&mut page, effort, &runs);
    let claims = study.claims(&micro, &runs);
    if !claims.is_empty() {
        page.section("Claims and answers");
        page.text(RULE);
        claims::table(&mut page, &claims);
        claims::print(&claims);
    }
    micro_section(&mut page, &study, &micro, out)?;
    macro_sections(&mut page, &study, &runs, out)?;
    figures::write(out, &runs, &points)?;
    if options.vtk {
        println!("written: {}", vtk::series(out, effort)?.display());
    }
    let path = out.join("report.html");
    page.write(&path, TITLE)?;
    println!(
        "{} runs done, {} taken from {}; {:.0} s, processor time of all runs {:.0} s",
        runs.done,
        runs.kept,
        jobs::path_of_runs(out).display(),
        wall.seconds(),
        runs.cpu()
    );
    println!("written: {}", path.display());
    Ok(true)
}

fn introduction(page: &mut Page, effort: Effort, runs: &Runs) {
    page.text(
        "D. Powell, T. I. Zohdi, Attachment mode performance of network-modeled ballistic fabric shielding, Composites Part B 40 \
         (2009) 451-460. Every figure of the paper that is a computation, computed anew, beside what the paper says of it.",
    );
    page.text(
        "The model is chaotic after the first yarn fails: single runs prove nothing. Every point is the mean of an ensemble with \
         its 95 % interval (Student's t): stochastic yarn with different seeds, uniform yarn with impact velocities V0 (1 + k 1e-12).",
    );
    if let Some(text) = effort.left_out() {
        page.text(&text);
    }
    let timeouts = runs.timeouts();
    page.text(&format!(
        "{} runs, {:.0} s of processor time. The energy balance closes to {:.2} % of the impact energy in the median and {:.1} % in the \
         worst run, which is a torn sheet that flutters for long: loose fabric gains energy at the default step, the projectile \
         does not notice. Runs that their step limit ended (TIMEOUT): {}.",
        runs.kept + runs.done,
        runs.cpu(),
        100.0 * runs.median_audit(),
        100.0 * runs.worst_audit(),
        if timeouts.is_empty() { "none".to_string() } else { timeouts.join("; ") }
    ));
}

fn micro_section(page: &mut Page, study: &Study<'_>, micro: &micro::Micro, out: &Path) -> Result<()> {
    use Chosen::{Fig3, Fig5, Fig6};
    if !study.wants(&[Fig3, Fig5, Fig6]) {
        return Ok(());
    }
    micro.write(out)?;
    page.section("Fibrils to yarn law (Figs 3, 5, 6)");
    if study.wants(&[Fig3]) {
        micro.figure_3(out)?.iter().for_each(|figure| page.figure(figure));
    }
    if study.wants(&[Fig5]) {
        page.figure(&micro.figure_5(out)?);
    }
    if study.wants(&[Fig6]) {
        page.figure(&micro.figure_6(out)?);
    }
    Ok(())
}

fn macro_sections(page: &mut Page, study: &Study<'_>, runs: &Runs, out: &Path) -> Result<()> {
    use Chosen::*;
    let effort = study.effort;
    if study.wants(&[Fig9]) {
        page.figure(&Figure::no_data("Fig. 9 is an experiment: no data in the paper."));
    }
    if study.wants(&[Fig11]) {
        page.figure(&Figure::no_data("Fig. 11 is an experiment: no data in the paper."));
    }
    if study.wants(&[Fig10, Fig12]) {
        page.section("Deformed 10 in sheets under the cylinder (Figs 10, 12)");
        figures::pictures(page, out, effort)?;
    }
    if study.wants(&[Fig13]) {
        page.section("Residual against initial velocity (Fig. 13)");
        page.figure(&figures::figure_13(out, runs, effort)?);
        figures::table(page, runs, &figures::large_points(effort));
    }
    if study.wants(&[Fig14]) {
        page.section("Absorbed energy and attachment (Fig. 14)");
        figures::figure_14(out, runs, effort)?.iter().for_each(|figure| page.figure(figure));
        figures::table(page, runs, &figures::small_points(effort, Yarn::Stochastic));
    }
    for (chosen, number) in [(Fig15, 15), (Fig16, 16), (Fig17, 17)] {
        if study.wants(&[chosen]) {
            page.section(&format!("Energy histories (Fig. {number})"));
            figures::histories(out, runs, effort, number)?.iter().for_each(|figure| page.figure(figure));
        }
    }
    for (chosen, number) in [(Fig18, 18), (Fig19, 19), (Fig20, 20)] {
        if study.wants(&[chosen]) {
            page.section(&format!("Uniform against stochastic yarn (Fig. {number})"));
            page.figure(&figures::uniform_against_stochastic(out, runs, effort, number)?);
        }
    }
    if study.wants(&[Fig18, Fig19, Fig20]) {
        figures::table(page, runs, &figures::small_points(effort, Yarn::Uniform));
    }
    if study.wants(&[Map]) {
        page.section("The open question: uniform yarn at the corners, near the limit");
        map::show(page, out, runs, effort)?;
    }
    Ok(())
}
