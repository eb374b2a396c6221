//! The macro figures: which points they need, their plots and their tables.

use super::html::{Figure, Page};
use super::jobs::{Record, Runs, Sample};
use super::plan::{self, ATTACHMENTS, Effort, Impact, PICTURE_VELOCITY, Point, Sheet, Yarn, attachment_name};
use super::sheets;
use super::statistics::Estimate;
use crate::Result;
use crate::plots::{Axes, Plot, Series, Style};
use fabric::AttachmentKind::{FourCorners, FourSides, TwoSides};
use serde::Serialize;
use std::path::Path;

/// Points of Figs 14 to 20: the 3 in sheet with one yarn.
pub fn small_points(effort: Effort, yarn: Yarn) -> Vec<Point> {
    let points = ATTACHMENTS.iter().flat_map(|&attachment| {
        effort.energies().iter().map(move |&energy| plan::small(effort, attachment, yarn, energy))
    });
    points.collect()
}

/// Points on how failure begins in mirror-symmetric clamped sheets.
pub fn mirrored_points(effort: Effort) -> Vec<Point> {
    let points = [TwoSides, FourSides].into_iter().flat_map(|attachment| {
        plan::HISTORY_ENERGIES.map(|energy| plan::small(effort, attachment, Yarn::Symmetric, energy))
    });
    points.collect()
}

/// Points of Fig 13: the 10 in sheet.
pub fn large_points(effort: Effort) -> Vec<Point> {
    let points = ATTACHMENTS.iter().flat_map(|&attachment| {
        effort.velocities().iter().map(move |&velocity| plan::large(effort, attachment, velocity))
    });
    points.collect()
}

/// Points of Figs 10 and 12: one run for each attachment.
pub fn picture_points(effort: Effort) -> Vec<Point> {
    let point = |&attachment| Point { runs: 1, ..plan::large(effort, attachment, PICTURE_VELOCITY) };
    ATTACHMENTS.iter().map(point).collect()
}

/// A series of ensemble means with 95 % intervals over the impact.
fn means(runs: &Runs, name: &str, points: &[Point], value: impl Fn(&Record) -> f64 + Copy) -> Series {
    let mut series = Series::new(name, Style::Marked, Vec::new());
    for point in points {
        let values = runs.values(point, value);
        if values.is_empty() {
            continue;
        }
        let mean = Estimate::mean(&values);
        let x = match point.impact {
            Impact::Energy(energy) => energy,
            Impact::Velocity(velocity) => velocity,
        };
        series.points.push((x, mean.value));
        series.bars.push((mean.low, mean.high));
    }
    series
}

fn of(points: &[Point], attachment: fabric::AttachmentKind) -> Vec<Point> {
    points.iter().filter(|point| point.attachment == attachment).copied().collect()
}

/// Residual velocity, m/s: 0 if the projectile was arrested (it is then pushed back).
pub fn residual(record: &Record) -> f64 {
    if record.arrested { 0.0 } else { record.residual_velocity }
}

/// Fig 13: residual velocity over impact velocity.
pub fn figure_13(out: &Path, runs: &Runs, effort: Effort) -> Result<Figure> {
    let points = large_points(effort);
    let mut series: Vec<Series> =
        ATTACHMENTS.iter().map(|&kind| means(runs, attachment_name(kind), &of(&points, kind), residual)).collect();
    let last = effort.velocities().iter().copied().fold(0.0, f64::max);
    series.push(Series::new("no fabric", Style::Dashed, vec![(0.0, 0.0), (last, last)]));
    Plot {
        title: "10 in sheet, cylinder: residual against initial velocity",
        x: "initial velocity (m/s)",
        y: "residual velocity (m/s)",
        axes: Axes::FromZero,
        series,
        marks: Vec::new(),
    }
    .write(&out.join("figure_13.svg"))?;
    let caption = format!(
        "Fig. 13. The paper does not say how this sheet is held, so all three attachments are shown. Mean of {} seeds with 95 % \
         interval; 0 where the projectile is arrested. Where a run ended by its step limit (column \"timeouts\"), the torn sheet still \
         clings to the cylinder and slows it a little more.",
        effort.runs(Sheet::Large)
    );
    Figure::svg(out, "figure_13.svg", caption)
}

/// Fig 14: absorbed over impact energy.
pub fn figure_14(out: &Path, runs: &Runs, effort: Effort) -> Result<Vec<Figure>> {
    let points = small_points(effort, Yarn::Stochastic);
    let mut figures = Vec::new();
    for (file, value, when) in [
        (
            "figure_14.svg",
            (|record: &Record| record.at_detached()) as fn(&Record) -> f64,
            "when the last contact lost its supports",
        ),
        ("figure_14_end.svg", |record: &Record| record.absorbed, "when the projectile was arrested or had left"),
    ] {
        let series = ATTACHMENTS.iter().map(|&kind| means(runs, attachment_name(kind), &of(&points, kind), value));
        Plot {
            title: &format!("3 in sheet, sphere: energy absorbed {when}"),
            x: "impact energy (J)",
            y: "absorbed energy (J)",
            axes: Axes::LogarithmicX,
            series: series.collect(),
            marks: Vec::new(),
        }
        .write(&out.join(file))?;
        let caption = format!(
            "Fig. 14, read {when}. Stochastic yarn, mean of {} seeds with 95 % interval. Below the ballistic limit everything is absorbed.",
            effort.runs(Sheet::Small)
        );
        figures.push(Figure::svg(out, file, caption)?);
    }
    Ok(figures)
}

/// Figs 15 to 17: energies over time, mean of the ensemble.
pub fn histories(out: &Path, runs: &Runs, effort: Effort, number: u32) -> Result<Vec<Figure>> {
    let kind = match number {
        15 => FourCorners,
        16 => TwoSides,
        _ => FourSides,
    };
    let mut figures = Vec::new();
    for energy in plan::HISTORY_ENERGIES {
        let point = plan::small(effort, kind, Yarn::Stochastic, energy);
        let records = runs.of(&point);
        if records.is_empty() {
            continue;
        }
        // A common grid; a run that has ended keeps its last values.
        let mut ends: Vec<f64> = records.iter().map(|record| record.time).collect();
        ends.sort_by(f64::total_cmp);
        let end = ends[ends.len() / 2];
        let grid: Vec<f64> = (0..=200).map(|k| end * k as f64 / 200.0).collect();
        let mean = |name: &str, style: Style, value: fn(&Sample) -> f64| {
            let at =
                |t: f64| records.iter().map(|record| at_time(record, t, value)).sum::<f64>() / records.len() as f64;
            Series::new(name, style, grid.iter().map(|&t| (1e6 * t, at(t))).collect())
        };
        let file = format!("figure_{number}_{energy}J.svg");
        Plot {
            title: &format!("3 in sheet, {}, {energy} J: where the energy is", attachment_name(kind)),
            x: "time (µs)",
            y: "energy (J)",
            axes: Axes::FromZero,
            series: vec![
                mean("lost by the projectile", Style::Line, |sample| sample.lost),
                mean("fabric kinetic", Style::Line, |sample| sample.kinetic),
                mean("strain", Style::Line, |sample| sample.strain),
                mean("dissipated by rupture", Style::Line, |sample| sample.dissipated),
                mean("contact loss", Style::Dashed, |sample| sample.loss),
            ],
            marks: Vec::new(),
        }
        .write(&out.join(&file))?;
        let caption = format!(
            "Fig. {number}, {energy} J: mean of {} runs up to their median end. Largest fabric kinetic energy {} J, largest strain \
             energy {} J (means of the runs' own largest values, 95 % interval).",
            records.len(),
            Estimate::mean(&runs.values(&point, |record| record.peak_kinetic)).text(2),
            Estimate::mean(&runs.values(&point, |record| record.peak_strain)).text(2),
        );
        figures.push(Figure::svg(out, &file, caption)?);
    }
    Ok(figures)
}

fn at_time(record: &Record, t: f64, value: fn(&Sample) -> f64) -> f64 {
    match record.history.iter().position(|sample| sample.t >= t) {
        None => record.history.last().map_or(0.0, value),
        Some(0) => record.history.first().map_or(0.0, value),
        Some(k) => {
            let (a, b) = (&record.history[k - 1], &record.history[k]);
            value(a) + (value(b) - value(a)) * (t - a.t) / (b.t - a.t)
        }
    }
}

/// Figs 18 to 20: uniform against stochastic yarn.
pub fn uniform_against_stochastic(out: &Path, runs: &Runs, effort: Effort, number: u32) -> Result<Figure> {
    let kind = match number {
        18 => FourCorners,
        19 => TwoSides,
        _ => FourSides,
    };
    let series = [Yarn::Stochastic, Yarn::Uniform]
        .map(|yarn| means(runs, yarn.name(), &of(&small_points(effort, yarn), kind), |record| record.at_detached()));
    let file = format!("figure_{number}.svg");
    Plot {
        title: &format!("3 in sheet, {}: uniform against stochastic yarn", attachment_name(kind)),
        x: "impact energy (J)",
        y: "absorbed energy when detached (J)",
        axes: Axes::LogarithmicX,
        series: series.into(),
        marks: Vec::new(),
    }
    .write(&out.join(&file))?;
    let caption = format!(
        "Fig. {number}. Mean of {} runs with 95 % interval: stochastic yarn with different seeds, uniform yarn with impact velocities \
         that differ by 1e-12.",
        effort.runs(Sheet::Small)
    );
    Figure::svg(out, &file, caption)
}

/// Figs 10 and 12: deformed sheets.
pub fn pictures(page: &mut Page, out: &Path, effort: Effort) -> Result<()> {
    for point in picture_points(effort) {
        let job = point.job(effort, 0, sheets::times(effort, point.attachment));
        if !job.has_pictures(out) {
            continue;
        }
        page.heading(&format!("{}, seed 1", point.name()));
        let (mut views, mut maps) = (Vec::new(), Vec::new());
        for &time in job.pictures {
            let sheet = sheets::read(&sheets::path(out, &job.key(), time), &job.scene)?;
            let side = format!("{:.0} µs, from the side: {:.0} mm deep", 1e6 * sheet.time, 1e3 * sheet.deflection());
            views.push(Figure::png(&sheet.side_view(&job.scene)?, side));
            let map = format!("{:.0} µs, damage: {} segments failed", 1e6 * sheet.time, sheet.failed());
            maps.push(Figure::png(&sheet.damage_map(&job.scene)?, map));
        }
        page.panels(&views);
        page.panels(&maps);
    }
    Ok(())
}

/// A row of points.csv. Energies in J, velocities in m/s, 95 % intervals of the mean; "range" is that of the runs.
#[derive(Serialize)]
pub struct Row {
    sheet: &'static str,
    attachment: &'static str,
    washer: &'static str,
    yarn: &'static str,
    impact_j: f64,
    impact_m_per_s: f64,
    runs: usize,
    arrested: usize,
    timeouts: usize,
    absorbed_at_detached: f64,
    absorbed_at_detached_low: f64,
    absorbed_at_detached_high: f64,
    absorbed_at_detached_least: f64,
    absorbed_at_detached_greatest: f64,
    absorbed_at_end: f64,
    absorbed_at_end_low: f64,
    absorbed_at_end_high: f64,
    absorbed_at_end_least: f64,
    absorbed_at_end_greatest: f64,
    residual_velocity: f64,
    residual_velocity_low: f64,
    residual_velocity_high: f64,
    peak_fabric_kinetic: f64,
    peak_fabric_kinetic_low: f64,
    peak_fabric_kinetic_high: f64,
    peak_strain: f64,
    peak_strain_low: f64,
    peak_strain_high: f64,
    failed_segments: f64,
    worst_energy_residual_percent: f64,
}

/// Least and greatest.
fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
}

impl Row {
    /// The row of a point.
    pub fn of(runs: &Runs, point: &Point) -> Row {
        let records = runs.of(point);
        let values = |value: fn(&Record) -> f64| runs.values(point, value);
        let mean = |value: fn(&Record) -> f64| Estimate::mean(&values(value));
        let (detached, end) = (mean(Record::at_detached), mean(|record| record.absorbed));
        let (detached_range, end_range) =
            (range(&values(Record::at_detached)), range(&values(|record| record.absorbed)));
        let (velocity, kinetic, strain) =
            (mean(residual), mean(|record| record.peak_kinetic), mean(|record| record.peak_strain));
        let scene = point.scene(Effort::Full, 0);
        Row {
            sheet: if point.sheet == Sheet::Small { "3 in, sphere" } else { "10 in, cylinder" },
            attachment: attachment_name(point.attachment),
            washer: if point.attachment == FourCorners && point.sheet == Sheet::Small {
                plan::WASHERS[point.washer].name
            } else {
                ""
            },
            yarn: point.yarn.name(),
            impact_j: point.energy(),
            impact_m_per_s: scene.projectile.velocity[2],
            runs: records.len(),
            arrested: records.iter().filter(|record| record.arrested).count(),
            timeouts: records.iter().filter(|record| record.timeout).count(),
            absorbed_at_detached: detached.value,
            absorbed_at_detached_low: detached.low,
            absorbed_at_detached_high: detached.high,
            absorbed_at_detached_least: detached_range.0,
            absorbed_at_detached_greatest: detached_range.1,
            absorbed_at_end: end.value,
            absorbed_at_end_low: end.low,
            absorbed_at_end_high: end.high,
            absorbed_at_end_least: end_range.0,
            absorbed_at_end_greatest: end_range.1,
            residual_velocity: velocity.value,
            residual_velocity_low: velocity.low,
            residual_velocity_high: velocity.high,
            peak_fabric_kinetic: kinetic.value,
            peak_fabric_kinetic_low: kinetic.low,
            peak_fabric_kinetic_high: kinetic.high,
            peak_strain: strain.value,
            peak_strain_low: strain.low,
            peak_strain_high: strain.high,
            failed_segments: records.iter().map(|record| record.failed as f64).sum::<f64>() / records.len() as f64,
            worst_energy_residual_percent: 100.0 * records.iter().map(|r| r.audit.abs()).fold(0.0, f64::max),
        }
    }
}

/// A table of points: absorbed energy with interval and range, residual velocity, peaks, arrests.
pub fn table(page: &mut Page, runs: &Runs, points: &[Point]) {
    let name = points.first().map_or(String::new(), |point| {
        let sheet = if point.sheet == Sheet::Small { "3 in" } else { "10 in" };
        format!("{sheet}, {} yarn", point.yarn.name())
    });
    let heading = [
        name.as_str(),
        "runs",
        "arrested",
        "timeouts",
        "absorbed, detached (J)",
        "range",
        "absorbed, end (J)",
        "range",
        "residual (m/s)",
        "peak fabric kinetic (J)",
        "peak strain (J)",
        "failed",
    ];
    let rows: Vec<Vec<String>> = points
        .iter()
        .filter(|point| !runs.of(point).is_empty())
        .map(|point| {
            let values = |value: fn(&Record) -> f64| runs.values(point, value);
            let mean = |value: fn(&Record) -> f64| Estimate::mean(&values(value)).text(2);
            let spread = |value: fn(&Record) -> f64| {
                let (low, high) = range(&values(value));
                format!("{low:.2} to {high:.2}")
            };
            let row = Row::of(runs, point);
            let impact = match point.impact {
                Impact::Energy(energy) => format!("{energy} J"),
                Impact::Velocity(velocity) => format!("{velocity} m/s"),
            };
            vec![
                format!("{}, {impact}", attachment_name(point.attachment)),
                row.runs.to_string(),
                row.arrested.to_string(),
                row.timeouts.to_string(),
                mean(Record::at_detached),
                spread(Record::at_detached),
                mean(|record| record.absorbed),
                spread(|record| record.absorbed),
                Estimate::mean(&values(residual)).text(1),
                mean(|record| record.peak_kinetic),
                mean(|record| record.peak_strain),
                format!("{:.0}", row.failed_segments),
            ]
        })
        .collect();
    page.table(&heading, &[], &rows);
}

/// Writes points.csv and runs.csv.
pub fn write(out: &Path, runs: &Runs, points: &[Point]) -> Result<()> {
    let mut writer = csv::Writer::from_path(out.join("points.csv"))?;
    for point in points.iter().filter(|point| !runs.of(point).is_empty()) {
        writer.serialize(Row::of(runs, point))?;
    }
    Ok(writer.flush()?)
}
