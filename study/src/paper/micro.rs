//! The micro scale (Figs 3, 5, 6): fibrils to yarn law, over a population of yarns.

use crate::machine::Clock;
use crate::{Result, say};
use fabric::calibrate::{self, Fit, FittedLaw};
use fabric::fibril::{Bundle, BundleYarn};
use serde::Serialize;
use std::path::Path;

/// Seed of the population.
const SEED: u64 = 1;
/// A multiple of the stretch just below, or just beyond, a rupture.
const JUST: f64 = 1e-9;

/// A yarn of the population: a row of yarns.csv.
#[derive(Serialize)]
struct Yarn {
    modulus_gpa: f64,
    damage_rate: f64,
    /// Of the law with the damage rate alone, root mean square over the grid.
    misfit: f64,
}

/// A fitted law alpha = A (exp(-rate (U - U_c)) - B).
#[derive(Serialize)]
struct Law {
    damage_rate: f64,
    a: f64,
    b: f64,
}

impl Law {
    fn of(fit: &FittedLaw) -> Law {
        Law { damage_rate: fit.damage_rate, a: fit.a, b: fit.b }
    }
}

/// micro.json.
#[derive(Serialize)]
struct Micro {
    fibrils: u32,
    critical_stretch: f64,
    /// Expected mean and standard deviation of a yarn's modulus, GPa, by quadrature over the Gaussian.
    expected_modulus_gpa: [f64; 2],
    /// Work to rupture, MJ/m^3: of an aligned yarn, and of misaligned ones.
    aligned_work: f64,
    work: Vec<f64>,
    /// Stress that a yarn keeps just beyond the critical stretch, over the stress just below.
    aligned_left: f64,
    left: Vec<f64>,
    /// Processor time of drawing and fitting all yarns on one core, s.
    seconds: f64,
    /// Stress in GPa over the stretch: the aligned yarn, and three misaligned ones.
    stresses: Vec<Vec<[f64; 2]>>,
    /// alpha of the first yarn over the stretch, and the laws fitted to it with one and with three constants.
    staircase: Vec<[f64; 2]>,
    laws: [Law; 2],
}

/// Draws and fits the population on one core; writes yarns.csv and micro.json.
pub fn compute(count: u64, out: &Path) -> Result<()> {
    let bundle = Bundle::zylon();
    let critical = bundle.critical_stretch;
    let mut memory = vec![0.0; BundleYarn::reals(&bundle)];
    let refused = "the bundle has no fibril";
    let mut table = csv::Writer::from_path(out.join("yarns.csv"))?;
    let mut seconds = 0.0;
    for number in 0..count {
        let clock = Clock::start();
        let yarn = BundleYarn::draw(&bundle, SEED, number, &mut memory).ok_or(refused)?;
        let law = calibrate::fit(&yarn, critical, Fit::Rate);
        let modulus_gpa = 1e-9 * yarn.modulus(1.0);
        seconds += clock.seconds();
        table.serialize(Yarn { modulus_gpa, damage_rate: law.damage_rate, misfit: law.misfit })?;
    }
    table.flush()?;
    let (mut work, mut left, mut stresses) = (Vec::new(), Vec::new(), Vec::new());
    let straight = Bundle { offset_sd: 0.0, ..bundle };
    let aligned = BundleYarn::draw(&straight, SEED, 0, &mut memory).ok_or(refused)?;
    let aligned_work = 1e-6 * aligned.work_to_rupture();
    let aligned_left = aligned.stress(critical + JUST) / aligned.stress(critical - JUST);
    // The stress jumps: both values at the critical stretch are there.
    let stretches = [1.0, critical - JUST, critical + JUST, 1.08];
    stresses.push(stretches.map(|u| [u, 1e-9 * aligned.stress(u)]).to_vec());
    for number in 0..count.min(1000) {
        let yarn = BundleYarn::draw(&bundle, SEED, number, &mut memory).ok_or(refused)?;
        work.push(1e-6 * yarn.work_to_rupture());
        left.push(yarn.stress(critical + JUST) / yarn.stress(critical - JUST));
        if number < 3 {
            let stretches = (0..=1600).map(|k| 1.0 + 0.08 * k as f64 / 1600.0);
            stresses.push(stretches.map(|u| [u, 1e-9 * yarn.stress(u)]).collect());
        }
    }
    let yarn = BundleYarn::draw(&bundle, SEED, 0, &mut memory).ok_or(refused)?;
    let mut staircase = vec![[1.025, 1.0]];
    for k in 0..bundle.fibrils as usize {
        let Some(u) = yarn.rupture_stretch(k) else { break };
        staircase.push([u, yarn.alpha(u - JUST)]);
        staircase.push([u, yarn.alpha(u + JUST)]);
    }
    let (mean, fibril_sd) = bundle.expected_modulus();
    let micro = Micro {
        fibrils: bundle.fibrils,
        critical_stretch: critical,
        expected_modulus_gpa: [1e-9 * mean, 1e-9 * fibril_sd / f64::from(bundle.fibrils).sqrt()],
        aligned_work,
        work,
        aligned_left,
        left,
        seconds,
        stresses,
        staircase,
        laws: [Fit::Rate, Fit::RateAndConstants].map(|fit| Law::of(&calibrate::fit(&yarn, critical, fit))),
    };
    std::fs::write(out.join("micro.json"), serde_json::to_string(&micro)? + "\n")?;
    say::line(format_args!(
        "micro scale: {count} yarns of {} fibrils drawn and fitted in {seconds:.2} s on one core",
        bundle.fibrils
    ));
    Ok(())
}
