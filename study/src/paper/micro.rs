//! The micro scale (Figs 3, 5, 6): fibrils to yarn law, over a population of yarns.

use super::html::Figure;
use super::statistics::Estimate;
use crate::machine::Clock;
use crate::plots::{Axes, Plot, Series, Style};
use crate::{Result, report};
use fabric::calibrate::{self, Fit, FittedLaw, Regression};
use fabric::fibril::{Bundle, BundleYarn};
use serde::Serialize;
use std::path::Path;

/// Seed of the population.
const SEED: u64 = 1;
/// Dots in the scatter plot: more hide one another.
const DOTS: usize = 2000;

/// A yarn of the population.
#[derive(Clone, Copy, Serialize)]
struct Yarn {
    modulus_gpa: f64,
    damage_rate: f64,
    misfit: f64,
}

/// Everything the micro scale gave.
pub struct Micro {
    bundle: Bundle,
    yarns: Vec<Yarn>,
    /// Mean modulus, GPa.
    pub modulus: Estimate,
    /// Standard deviation of the modulus, GPa.
    pub modulus_sd: Estimate,
    /// Mean damage rate.
    pub rate: Estimate,
    /// Slope of the regression line, 1/GPa.
    pub slope: Estimate,
    /// Its value at zero modulus.
    pub intercept: Estimate,
    /// Standard deviation about it.
    pub residual: Estimate,
    /// Work to rupture of misaligned yarns, MJ/m^3.
    pub work: Estimate,
    /// The same of an aligned yarn, MJ/m^3.
    pub aligned_work: f64,
    /// Stress that an aligned yarn keeps just beyond the critical stretch, over the stress just below.
    pub aligned_left: f64,
    /// The same for the mean of misaligned yarns.
    pub misaligned_left: Estimate,
    /// Processor time of drawing and fitting all yarns on one core, s.
    pub seconds: f64,
}

/// A multiple of the stretch just below, or just beyond, a rupture.
const JUST: f64 = 1e-9;

/// Draws and fits the population on one core.
pub fn compute(count: u64) -> Result<Micro> {
    let bundle = Bundle::zylon();
    let critical = bundle.critical_stretch;
    let mut memory = vec![0.0; BundleYarn::reals(&bundle)];
    let refused = "the bundle has no fibril";
    let mut yarns = Vec::with_capacity(count as usize);
    let mut regression = Regression::default();
    let (mut work, mut left) = (Vec::new(), Vec::new());
    let clock = Clock::start();
    for number in 0..count {
        let yarn = BundleYarn::draw(&bundle, SEED, number, &mut memory).ok_or(refused)?;
        let law = calibrate::fit(&yarn, critical, Fit::Rate);
        let modulus_gpa = 1e-9 * yarn.modulus(1.0);
        regression.add(modulus_gpa, law.damage_rate);
        yarns.push(Yarn { modulus_gpa, damage_rate: law.damage_rate, misfit: law.misfit });
    }
    let seconds = clock.seconds();
    for number in 0..count.min(1000) {
        let yarn = BundleYarn::draw(&bundle, SEED, number, &mut memory).ok_or(refused)?;
        work.push(1e-6 * yarn.work_to_rupture());
        left.push(yarn.stress(critical + JUST) / yarn.stress(critical - JUST));
    }
    let straight = Bundle { offset_sd: 0.0, ..bundle };
    let aligned = BundleYarn::draw(&straight, SEED, 0, &mut memory).ok_or(refused)?;
    let aligned_work = 1e-6 * aligned.work_to_rupture();
    let aligned_left = aligned.stress(critical + JUST) / aligned.stress(critical - JUST);

    let n = count as f64;
    let (modulus, rate) = regression.means();
    let (modulus_sd, rate_sd) = regression.deviations();
    let (slope, intercept, residual) = regression.line();
    let spread = modulus_sd * (n - 1.0).sqrt();
    Ok(Micro {
        bundle,
        yarns,
        modulus: Estimate::of_error(modulus, modulus_sd / n.sqrt(), n - 1.0),
        modulus_sd: Estimate::large_sample_deviation(modulus_sd, count),
        rate: Estimate::of_error(rate, rate_sd / n.sqrt(), n - 1.0),
        slope: Estimate::of_error(slope, residual / spread, n - 2.0),
        intercept: Estimate::of_error(intercept, residual * (1.0 / n + (modulus / spread).powi(2)).sqrt(), n - 2.0),
        residual: Estimate::large_sample_deviation(residual, count - 1),
        work: Estimate::mean(&work),
        aligned_work,
        aligned_left,
        misaligned_left: Estimate::mean(&left),
        seconds,
    })
}

impl Micro {
    /// Number of yarns.
    pub fn count(&self) -> usize {
        self.yarns.len()
    }

    /// Misfit of the one-parameter law, root mean square over the grid, mean over all yarns.
    pub fn misfit(&self) -> f64 {
        report::mean(&self.yarns.iter().map(|yarn| yarn.misfit).collect::<Vec<_>>())
    }

    /// Writes yarns.csv.
    pub fn write(&self, out: &Path) -> Result<()> {
        let mut writer = csv::Writer::from_path(out.join("yarns.csv"))?;
        for yarn in &self.yarns {
            writer.serialize(yarn)?;
        }
        Ok(writer.flush()?)
    }

    /// Fig 3 left: stress over stretch; and the staircase of alpha with the fitted laws.
    pub fn figure_3(&self, out: &Path) -> Result<Vec<Figure>> {
        let critical = self.bundle.critical_stretch;
        let mut memory = vec![0.0; BundleYarn::reals(&self.bundle)];
        let straight = Bundle { offset_sd: 0.0, ..self.bundle };
        let refused = "the bundle has no fibril";
        let grid =
            |from: f64, to: f64, points: u32| (0..=points).map(move |k| from + (to - from) * k as f64 / points as f64);
        let mut series = Vec::new();
        {
            let aligned = BundleYarn::draw(&straight, SEED, 0, &mut memory).ok_or(refused)?;
            // The stress jumps: both values at the critical stretch are drawn.
            let stretches = [1.0, critical - JUST, critical + JUST, 1.08];
            let points = stretches.map(|u| (u, 1e-9 * aligned.stress(u)));
            series.push(Series::new("aligned fibrils", Style::Line, points.to_vec()));
        }
        for number in 0..3 {
            let yarn = BundleYarn::draw(&self.bundle, SEED, number, &mut memory).ok_or(refused)?;
            let points = grid(1.0, 1.08, 1600).map(|u| (u, 1e-9 * yarn.stress(u))).collect();
            series.push(Series::new(format!("misaligned, yarn {}", number + 1), Style::Line, points));
        }
        Plot {
            title: "Stress of one yarn under displacement control",
            x: "stretch of the yarn",
            y: "second Piola-Kirchhoff stress (GPa)",
            axes: Axes::FromZero,
            series,
            marks: Vec::new(),
        }
        .write(&out.join("figure_3.svg"))?;

        let yarn = BundleYarn::draw(&self.bundle, SEED, 0, &mut memory).ok_or(refused)?;
        let end = yarn.last_rupture();
        let mut staircase = vec![(1.025, 1.0)];
        for k in 0..self.bundle.fibrils as usize {
            let Some(u) = yarn.rupture_stretch(k) else { break };
            staircase.push((u, yarn.alpha(u - JUST)));
            staircase.push((u, yarn.alpha(u + JUST)));
        }
        let law = |fit: &FittedLaw| {
            let alpha = |u: f64| fit.a * ((-fit.damage_rate * (u - critical)).exp() - fit.b);
            grid(critical, end, 300).map(|u| (u, alpha(u).max(0.0))).collect::<Vec<_>>()
        };
        let one = calibrate::fit(&yarn, critical, Fit::Rate);
        let three = calibrate::fit(&yarn, critical, Fit::RateAndConstants);
        Plot {
            title: "Rupture sequence of one yarn and the fitted law",
            x: "stretch of the yarn",
            y: "damage variable α",
            axes: Axes::FromZero,
            series: vec![
                Series::new(format!("{} fibrils", self.bundle.fibrils), Style::Line, staircase),
                Series::new(format!("λ = {:.1}", one.damage_rate), Style::Line, law(&one)),
                Series::new(
                    format!("λ = {:.1}, A = {:.3}, B = {:.4}", three.damage_rate, three.a, three.b),
                    Style::Dashed,
                    law(&three),
                ),
            ],
            marks: Vec::new(),
        }
        .write(&out.join("figure_3_staircase.svg"))?;
        Ok(vec![
            Figure::svg(
                out,
                "figure_3.svg",
                format!(
                    "Fig. 3 left. An aligned yarn loses all load at once; misaligned fibrils break one after another. Work to rupture: \
                     aligned {:.1} MJ/m³, misaligned {} MJ/m³ (mean of 1000 yarns, 95 % interval).",
                    self.aligned_work,
                    self.work.text(2)
                ),
            )?,
            Figure::svg(
                out,
                "figure_3_staircase.svg",
                format!(
                    "The same rupture sequence as a staircase of α, with the paper's one-parameter law exp(−λ(U − U_c)) and, dashed, \
                     the law with A and B free. The paper's law misses the staircase by {:.3} (root mean square, mean of all \
                     yarns): early damage comes too slowly.",
                    self.misfit()
                ),
            )?,
            Figure::no_data("Fig. 3 right is an experiment: no data in the paper."),
        ])
    }

    /// Fig 5: histogram of the yarns' moduli.
    pub fn figure_5(&self, out: &Path) -> Result<Figure> {
        let (mean, sd) = (self.modulus.value, self.modulus_sd.value);
        let width = 0.25;
        let first = ((mean - 4.5 * sd) / width).floor();
        let bins = (9.0 * sd / width).ceil() as usize;
        let mut counts = vec![0_u32; bins];
        for yarn in &self.yarns {
            let bin = yarn.modulus_gpa / width - first;
            if bin >= 0.0 && (bin as usize) < bins {
                counts[bin as usize] += 1;
            }
        }
        let mut outline = Vec::new();
        for (k, &count) in counts.iter().enumerate() {
            let left = width * (first + k as f64);
            outline.extend([(left, 0.0), (left, count as f64), (left + width, count as f64), (left + width, 0.0)]);
        }
        let total = self.yarns.len() as f64 * width;
        let density = |x: f64, mean: f64, sd: f64| {
            total / (sd * std::f64::consts::TAU.sqrt()) * (-0.5 * ((x - mean) / sd).powi(2)).exp()
        };
        let xs = (0..=200).map(|k| width * (first + bins as f64 * k as f64 / 200.0));
        let normal = xs.map(|x| (x, density(x, 140.21, 2.04))).collect();
        Plot {
            title: &format!("Young's modulus of {} yarns", self.yarns.len()),
            x: "modulus (GPa)",
            y: "yarns in 0.25 GPa",
            axes: Axes::FromZero,
            series: vec![
                Series::new("yarns", Style::Line, outline),
                Series::new("paper: normal, 140.21 ± 2.04", Style::Dashed, normal),
            ],
            marks: Vec::new(),
        }
        .write(&out.join("figure_5.svg"))?;
        let (exact, fibril_sd) = self.bundle.expected_modulus();
        let caption = format!(
            "Fig. 5. Mean {} GPa, standard deviation {} GPa (paper: 140.21 and 2.04). Without sampling error, by quadrature over the \
             Gaussian: {:.3} and {:.3} GPa.",
            self.modulus.text(3),
            self.modulus_sd.text(3),
            1e-9 * exact,
            1e-9 * fibril_sd / (self.bundle.fibrils as f64).sqrt()
        );
        Figure::svg(out, "figure_5.svg", caption)
    }

    /// Fig 6: damage rate against modulus with the regression line.
    pub fn figure_6(&self, out: &Path) -> Result<Figure> {
        let dots: Vec<(f64, f64)> =
            self.yarns.iter().take(DOTS).map(|yarn| (yarn.modulus_gpa, yarn.damage_rate)).collect();
        let (low, high) =
            (self.modulus.value - 4.0 * self.modulus_sd.value, self.modulus.value + 4.0 * self.modulus_sd.value);
        let line = |slope: f64, intercept: f64| [low, high].map(|x| (x, slope * x + intercept)).to_vec();
        Plot {
            title: "Damage rate against modulus",
            x: "modulus (GPa)",
            y: "damage rate λ",
            axes: Axes::Linear,
            series: vec![
                Series::new(format!("{} yarns", dots.len()), Style::Dots, dots.clone()),
                Series::new("regression line", Style::Line, line(self.slope.value, self.intercept.value)),
                Series::new("the paper's line", Style::Dashed, line(7.91, -878.46)),
            ],
            marks: Vec::new(),
        }
        .write(&out.join("figure_6.svg"))?;
        let caption = format!(
            "Fig. 6. The first {} of {} yarns. Regression over all: λ = {} E/GPa + {}, standard deviation about the line {} \
             (paper: 7.91, −878.46, 8.35). Drawing and fitting took {:.2} s on one core.",
            dots.len(),
            self.yarns.len(),
            self.slope.text(3),
            self.intercept.text(1),
            self.residual.text(2),
            self.seconds
        );
        Figure::svg(out, "figure_6.svg", caption)
    }
}
