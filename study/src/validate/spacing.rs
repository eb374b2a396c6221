//! Convergence in the spacing: absorbed energy and ballistic limit of one sheet with bars of 4, 2, 1 and 1/2 yarn spacings.
//!
//! A bar stands for as many yarns side by side as it is spacings long, so mass, stiffness and strength of the sheet stay. What need
//! not stay is the energy that it takes to break a yarn. Beyond the critical stretch a bar of the length h carries
//! N_c exp(-lambda (U - U_c)), so it opens by about h/lambda while it breaks, and its softening takes N_c h/lambda: with a constant
//! lambda half the length takes half the energy. lambda proportional to h, lambda = lambda_0 h/h_0, keeps force over opening and with
//! it that energy (Z. P. Bazant, B. H. Oh, Materials and Structures 16 (1983) 155: crack band). The elastic energy of the breaking bar,
//! N_c e_c h/2, is taken too and is proportional to h in any case; with lambda_0 = 2303 and e_c = 3.55 % it is forty times the softening.
//!
//! Scene: Kevlar KM2 S706, 50.8 mm square, four sides held, one ply; a steel sphere of 6.35 mm, which is larger than the longest bar.
//! Hits differ by their place in a cell. The energy is that at twice a velocity near the limit; the same for all spacings.

use super::{LONGEST, named, sheet};
use crate::error_time::overshoot::{VISCOUS, viscosity_name, with_viscosity};
use crate::hits::{each, impact, limit, shot};
use crate::progress::Progress;
use crate::table::{Cell, Table};
use crate::{Result, report};
use fabric::{Scene, Shape};
use std::path::Path;

/// Width of the sheet, m.
const WIDTH: f64 = 0.0508;
/// Radius of the sphere, m, and its mass, kg: steel of 7830 kg/m^3.
const SPHERE: (f64, f64) = (3.175e-3, 1.05e-3);
/// Bars, yarn spacings.
const BARS: [f64; 4] = [4.0, 2.0, 1.0, 0.5];
/// The finest, for the energy alone, which is quick at a high velocity: of this sheet of the list.
const FINEST: (f64, usize) = (0.25, 1);
/// Sheets: plies lumped into one network, where the search for a limit starts and where the energy is taken, m/s, damage rate of a
/// bar of one yarn spacing.
const SHEETS: [Sheet; 3] = [
    Sheet { plies: 1, guess: 50.0, fast: 100.0, damage_rate: 2302.6 },
    Sheet { plies: 10, guess: 200.0, fast: 400.0, damage_rate: 2302.6 },
    Sheet { plies: 10, guess: 200.0, fast: 400.0, damage_rate: 230.0 },
];

#[derive(Clone, Copy)]
struct Sheet {
    plies: u32,
    guess: f64,
    fast: f64,
    damage_rate: f64,
}

/// How the damage rate depends on the length of a bar.
#[derive(Clone, Copy, PartialEq)]
enum Rate {
    /// Not.
    Fixed,
    /// In proportion.
    Scaled,
}

/// A network of the sheet.
#[derive(Clone, Copy)]
struct Network {
    sheet: Sheet,
    viscosity: [f64; 3],
    rate: Rate,
    bar: f64,
}

impl Network {
    fn scene(&self) -> Result<Scene> {
        let textile = named("kevlar_km2_s706")?;
        let mut scene = with_viscosity(sheet(&textile, WIDTH, self.bar)?, self.viscosity);
        scene.yarn.damage_intercept = self.sheet.damage_rate * if self.rate == Rate::Scaled { self.bar } else { 1.0 };
        scene.sheet.plies = self.sheet.plies;
        let body = &mut scene.projectile;
        (body.shape, body.radius, body.mass) = (Shape::Sphere, SPHERE.0, SPHERE.1);
        Ok(scene)
    }
}

/// Runs and writes.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let hits = if quick { 2 } else { 4 };
    let bars = if quick { &BARS[..2] } else { &BARS };
    let viscosities = if quick { vec![VISCOUS] } else { vec![[0.0; 3], VISCOUS] };
    let mut networks = Vec::new();
    for (k, sheet) in SHEETS.into_iter().enumerate().take(if quick { 1 } else { SHEETS.len() }) {
        for &viscosity in &viscosities {
            for rate in [Rate::Fixed, Rate::Scaled] {
                let finest = (k == FINEST.1 && rate == Rate::Fixed).then_some(FINEST.0);
                let bars = bars.iter().copied().chain(finest);
                networks.extend(bars.map(|bar| Network { sheet, viscosity, rate, bar }));
            }
        }
    }
    // Long runs first.
    let mut jobs: Vec<(usize, u64)> = (0..networks.len()).flat_map(|k| (0..hits).map(move |hit| (k, hit))).collect();
    jobs.sort_by(|a, b| networks[a.0].bar.total_cmp(&networks[b.0].bar));
    let progress = Progress::new("spacing", jobs.len() as u64);
    let found = each(&jobs, |&(k, hit)| {
        let scene = networks[k].scene()?;
        let fast = impact(&shot(&scene, networks[k].sheet.fast, hit), LONGEST)?;
        let coarse = networks[k].bar > FINEST.0;
        let limit = if coarse { limit(&scene, networks[k].sheet.guess, hit, LONGEST)? } else { f64::NAN };
        progress.add(1, || format!("{} yarns a bar", networks[k].bar));
        Ok([fast.absorbed, limit, 100.0 * fast.residual])
    })?;
    progress.finish();
    let mut table = Table::new(&[
        "plies",
        "viscosity",
        "damage rate",
        "damage rate and length",
        "yarns a bar",
        "hits",
        "absorbed J",
        "absorbed J: deviation",
        "limit m/s",
        "limit m/s: deviation",
        "energy residual %",
    ]);
    for (k, network) in networks.iter().enumerate() {
        let own: Vec<&[f64; 3]> =
            jobs.iter().zip(&found).filter(|(job, _)| job.0 == k).map(|(_, values)| values).collect();
        let column = |index: usize| -> Vec<f64> { own.iter().map(|values| values[index]).collect() };
        let rate = if network.rate == Rate::Scaled { "in proportion" } else { "constant" };
        let mut row = vec![
            Cell::Number(f64::from(network.sheet.plies)),
            Cell::text(viscosity_name(network.viscosity)),
            Cell::Number(network.sheet.damage_rate),
            Cell::text(rate),
        ];
        row.extend([network.bar, own.len() as f64].map(Cell::Number));
        for index in [0, 1] {
            row.extend([report::mean(&column(index)), report::deviation(&column(index))].map(Cell::Number));
        }
        row.push(Cell::Number(report::mean(&column(2))));
        table.add(row);
    }
    table.write(&out.join("spacing.csv"))
}
