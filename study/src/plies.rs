//! What several plies do: ballistic limit and absorbed energy against their number, and many thin plies against one thick one.
//!
//! A steel sphere of 0.69 g and 5.556 mm hits a pack of Kevlar KM2 S706, 60 mm square and held at four sides, with the viscosity of
//! real fabrics and a bar for two yarns. "Bonded" is one network with the mass and the section of all plies, "separate" a network for each, a
//! gap apart, which push on each other. Parts:
//!
//! | part | question |
//! |---|---|
//! | number | 1 to 62 plies, bonded and separate |
//! | gap | ten plies at gaps from 0 to 1 mm |
//! | turned | crimped plies (0.65 % warp, 0.25 % weft, as Kevlar 49 fabric in validation/kevlar49_strength.toml) alike, and every other one turned by 90 degrees |
//! | draws | drawn strengths (Weibull, shape and gauge length of Kevlar 49 yarn): one draw for all plies, and one for each |
//!
//! The energy is taken well above the limit, at one velocity for all forms. Hits of an ensemble differ by place and seed.
//! Limits: the waves come back from the edges of so small a sheet within 12 us: a bonded pack of ten stands 251, 281 and 301 m/s with a width of
//! 45, 60 and 101 mm, and with a bar for one yarn 1 to 2 % less; ten separate plies 3 to 4 % less; the plies lie exactly on each other, yarn on yarn.
//! `python3 -m reports plies` makes means with intervals of it, and docs/tables/plies.md; the measured packs are in `validate/packs.rs`.

use crate::effort::{self, Effort};
use crate::hits::{each, impact, limit, shot};
use crate::progress::Progress;
use crate::table::{Cell, Table};
use crate::validate::{named, sheet};
use crate::{Result, report, say};
use clap::Args;
use fabric::{Scene, Shape, StrengthDraw};
use std::path::PathBuf;

/// Options of `plies`.
#[derive(Args)]
pub struct Options {
    #[command(flatten)]
    flags: effort::Flags,
    /// Only these parts.
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Part>,
    /// Folder for plies_PART.csv.
    #[arg(long, value_name = "DIR", default_value = "target/study/plies")]
    out: PathBuf,
}

/// A part of the study.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Part {
    Number,
    Gap,
    Turned,
    Draws,
}

impl Part {
    const ALL: [Part; 4] = [Part::Number, Part::Gap, Part::Turned, Part::Draws];

    fn name(self) -> &'static str {
        match self {
            Part::Number => "number",
            Part::Gap => "gap",
            Part::Turned => "turned",
            Part::Draws => "draws",
        }
    }
}

/// How the plies are joined.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    Bonded,
    Separate,
    Turned,
}

impl Form {
    fn name(self) -> &'static str {
        match self {
            Form::Bonded => "bonded",
            Form::Separate => "separate",
            Form::Turned => "separate, every other one turned",
        }
    }
}

/// Time after which an impact is given up, s.
const LONGEST: f64 = 1e-3;
/// Radius of the sphere, m, and its mass, kg.
const SPHERE: (f64, f64) = (2.778e-3, 6.9e-4);
/// Width of a sheet, m, and bar, yarn spacings.
const WIDTH: f64 = 0.06;
const BAR: f64 = 2.0;
/// Plies, and a velocity near the ballistic limit or above it, m/s.
const NUMBERS: [(u32, f64); 7] =
    [(1, 105.0), (2, 140.0), (5, 210.0), (10, 295.0), (20, 420.0), (40, 590.0), (62, 720.0)];
/// Between two plies, m: less than the thickness of a fabric, which was not seen, as they lie close.
const GAP: f64 = 1e-4;
const GAPS: [f64; 5] = [0.0, 3e-5, 1e-4, 3e-4, 1e-3];
/// Plies of the parts besides the number.
const SOME: usize = 3;
/// Crimp of warp and weft.
const CRIMP: [f64; 2] = [0.0065, 0.0025];
/// Weibull shape and gauge length, m, of drawn strengths: fabrics/kevlar_49_yarn.toml.
const STRENGTH: (f64, f64) = (14.74, 0.05);

/// A pack to be shot at.
struct Pack {
    part: Part,
    form: Form,
    plies: u32,
    gap: f64,
    /// Where the search for its ballistic limit starts, m/s; the energy is taken at 1.5 times it.
    guess: f64,
}

impl Pack {
    fn scene(&self, smoke: bool) -> Result<Scene> {
        let mut textile = named("kevlar_km2_s706")?;
        if self.part == Part::Turned {
            [textile.warp.crimp, textile.weft.crimp] = CRIMP;
        }
        let mut scene = sheet(&textile, if smoke { 0.02 } else { WIDTH }, BAR)?;
        let body = &mut scene.projectile;
        (body.shape, body.radius, body.mass) = (Shape::Sphere, SPHERE.0, SPHERE.1);
        match self.form {
            Form::Bonded => scene.sheet.plies = self.plies,
            Form::Separate | Form::Turned => (scene.stack.plies, scene.stack.gap) = (self.plies, self.gap),
        }
        scene.stack.turned = self.form == Form::Turned;
        if self.part == Part::Draws {
            let yarn = &mut scene.yarn;
            (yarn.stochastic, yarn.strength_draw) = (true, StrengthDraw::Weibull);
            (yarn.weibull_shape, yarn.weibull_gauge_length) = STRENGTH;
        }
        Ok(scene)
    }
}

/// A pack of so many separate plies, [`GAP`] apart, and its sphere.
pub fn separate(plies: u32, smoke: bool) -> Result<Scene> {
    Pack { part: Part::Number, form: Form::Separate, plies, gap: GAP, guess: 0.0 }.scene(smoke)
}

/// All packs of a part.
fn packs(part: Part, smoke: bool) -> Vec<Pack> {
    let pack = |form: Form, (plies, guess): (u32, f64), gap: f64| Pack { part, form, plies, gap, guess };
    let numbers = if smoke { &NUMBERS[..2] } else { &NUMBERS };
    let some = if smoke { NUMBERS[1] } else { NUMBERS[SOME] };
    match part {
        Part::Number => {
            // A single ply is both.
            let separate = numbers[1..].iter().map(|&number| pack(Form::Separate, number, GAP));
            numbers.iter().map(|&number| pack(Form::Bonded, number, 0.0)).chain(separate).collect()
        }
        Part::Gap => GAPS.iter().map(|&gap| pack(Form::Separate, some, gap)).collect(),
        Part::Turned => [Form::Separate, Form::Turned].map(|form| pack(form, some, GAP)).into(),
        Part::Draws => [(Form::Bonded, 0.0), (Form::Separate, GAP)].map(|(form, gap)| pack(form, some, gap)).into(),
    }
}

/// Measures and writes. False if an energy balance does not close within 1 %.
pub fn run(options: &Options) -> Result<bool> {
    std::fs::create_dir_all(&options.out).map_err(|error| format!("{}: {error}", options.out.display()))?;
    let mut worst: f64 = 0.0;
    for part in Part::ALL {
        if options.only.is_empty() || options.only.contains(&part) {
            worst = worst.max(part_of(part, options)?);
        }
    }
    say::line(format_args!("largest energy residual: {:.3} % of the impact energy", 100.0 * worst));
    say::line(format_args!("{}", report::written(&options.out, "plies")));
    Ok(worst < 0.01)
}

/// One part. Returns the largest energy residual, in parts of the impact energy.
fn part_of(part: Part, options: &Options) -> Result<f64> {
    let effort = options.flags.effort();
    let packs = packs(part, effort == Effort::Smoke);
    let runs = match effort {
        Effort::Smoke => 2,
        Effort::Quick => 3,
        Effort::Full => 6,
    };
    let mut jobs: Vec<(usize, u64)> = (0..packs.len()).flat_map(|k| (0..runs).map(move |hit| (k, hit))).collect();
    // Those that take long first.
    jobs.sort_by_key(|job| std::cmp::Reverse(packs[job.0].plies));
    let progress = Progress::new(&format!("plies: {}", part.name()), jobs.len() as u64);
    let found = each(&jobs, |&(k, hit)| {
        let pack = &packs[k];
        let scene = pack.scene(effort == Effort::Smoke)?;
        let limit = limit(&scene, pack.guess, hit, LONGEST)?;
        let fast = impact(&shot(&scene, 1.5 * pack.guess, hit), LONGEST)?;
        progress.add(1, || format!("{} plies, {}", pack.plies, pack.form.name()));
        Ok((limit, fast))
    })?;
    progress.finish();
    let mut table = Table::new(&[
        "form",
        "plies",
        "gap mm",
        "areal density kg/m2",
        "run",
        "limit m/s",
        "impact velocity m/s",
        "impact J",
        "absorbed J",
        "velocity m/s",
        "failed segments",
        "residual %",
        "unconverged",
        "ply penetration mm",
    ]);
    let mut worst: f64 = 0.0;
    for (&(k, hit), (limit, fast)) in jobs.iter().zip(&found) {
        let (pack, scene) = (&packs[k], packs[k].scene(effort == Effort::Smoke)?);
        let (sheet, speed) = (&scene.sheet, 1.5 * pack.guess);
        let density = f64::from(pack.plies) * sheet.node_mass / (sheet.spacing * sheet.spacing);
        let energy = 0.5 * scene.projectile.mass * speed * speed;
        let mut row = vec![Cell::text(pack.form.name())];
        row.extend(
            [f64::from(pack.plies), 1e3 * pack.gap, density, hit as f64, *limit, speed, energy].map(Cell::Number),
        );
        row.extend([fast.absorbed, fast.velocity, fast.failed as f64, 100.0 * fast.residual].map(Cell::Number));
        row.extend([fast.unconverged as f64, 1e3 * fast.ply_penetration].map(Cell::Number));
        table.add(row);
        worst = worst.max(fast.residual.abs());
    }
    table.write(&options.out.join(format!("plies_{}.csv", part.name())))?;
    Ok(worst)
}
