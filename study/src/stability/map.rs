//! The map: time step against impact velocity on a small sheet, by the energy that the step creates.

use super::flight::{scale, unchecked, uniform};
use crate::Result;
use crate::memory::Buffers;
use crate::progress::Progress;
use fabric::Outcome;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// Nodes of the sheet along a side.
pub const NODES: u32 = 41;
/// Time every run lasts, s.
pub const TIME: f64 = 150e-6;
const FRACTIONS: [f64; 13] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2];
const SPEEDS: [f64; 11] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0];
/// Steps above this part of dt_crit are refused.
const LIMIT: f64 = fabric::scene::STEP_MAX_FRACTION;

/// One run of the map.
#[derive(Clone, Serialize)]
pub struct Cell {
    /// dt over dt_crit.
    pub fraction: f64,
    /// Impact velocity, m/s.
    pub speed: f64,
    /// Energy residual over the impact energy; infinite if the run ended in a failure.
    pub energy: f64,
    /// Energy absorbed over the impact energy.
    pub absorbed: f64,
    /// Segments that failed.
    pub failed_segments: u64,
    /// What became of the projectile.
    pub outcome: &'static str,
}

/// How much energy a run made or lost.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Class {
    /// Below 1 % of the impact energy.
    Sound,
    /// 1 to 10 %.
    Creep,
    /// Above.
    Garbage,
}

impl Cell {
    /// By the size of the energy residual.
    pub fn class(&self) -> Class {
        match self.energy.abs() {
            part if part < 0.01 => Class::Sound,
            part if part < 0.1 => Class::Creep,
            _ => Class::Garbage,
        }
    }

    /// Whether the step is one that is accepted.
    pub fn allowed(&self) -> bool {
        self.fraction <= LIMIT
    }
}

/// Steps and velocities to run; every second one in a coarse map.
pub fn cells(coarse: bool) -> Vec<(f64, f64)> {
    let stride = if coarse { 2 } else { 1 };
    let speeds = SPEEDS.into_iter().step_by(stride);
    speeds.flat_map(|speed| FRACTIONS.into_iter().step_by(stride).map(move |fraction| (fraction, speed))).collect()
}

/// Runs them all.
pub fn compute(cells: &[(f64, f64)]) -> Result<Vec<Cell>> {
    let progress = Progress::new("stability map", cells.len() as u64);
    let run = |&(fraction, speed): &(f64, f64)| {
        let cell = cell(fraction, speed).map_err(|error| error.to_string());
        progress.add(1, || format!("{fraction} dt_crit, {speed} m/s"));
        cell
    };
    let cells: std::result::Result<Vec<Cell>, String> = cells.par_iter().map(run).collect();
    progress.finish();
    Ok(cells?)
}

fn cell(fraction: f64, speed: f64) -> Result<Cell> {
    let scene = unchecked(uniform(NODES, speed), fraction);
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let start = scale(&sim)?;
    let steps = (TIME / sim.step_limits().dt) as u64;
    if sim.advance(steps).is_err() {
        let failed_segments = sim.counters().failed_segments;
        return Ok(Cell { fraction, speed, energy: f64::INFINITY, absorbed: 0.0, failed_segments, outcome: "faulted" });
    }
    let (energy, found) = (sim.energy()?, sim.outcomes());
    let latched = |outcome: Outcome| found.mask & outcome.bit() != 0;
    let outcome = if latched(Outcome::Exited) {
        "exited"
    } else if latched(Outcome::Arrested) {
        "arrested"
    } else {
        "in contact"
    };
    Ok(Cell {
        fraction,
        speed,
        energy: energy.residual / start,
        absorbed: energy.contact_work / start,
        failed_segments: sim.counters().failed_segments,
        outcome,
    })
}

/// The numbers.
pub fn write_csv(cells: &[Cell], path: &Path) -> Result<()> {
    let mut writer = csv::Writer::from_path(path)?;
    cells.iter().try_for_each(|cell| writer.serialize(cell))?;
    Ok(writer.flush()?)
}

const FONT: &str = "sans-serif";
const INK: RGBColor = RGBColor(60, 60, 60);
const CELL_W: i32 = 62;
const CELL_H: i32 = 38;
const LEFT: i32 = 96;
const TOP: i32 = 64;

/// The picture: a cell for each run, coloured by class, with its residual in percent; refused steps are hatched.
pub fn draw(cells: &[Cell], path: &Path) -> Result<()> {
    let columns = distinct(cells.iter().map(|cell| cell.fraction));
    let rows = distinct(cells.iter().map(|cell| cell.speed));
    let (width, height) = (CELL_W * columns.len() as i32, CELL_H * rows.len() as i32);
    let size = ((LEFT + width + 30) as u32, (TOP + height + 150) as u32);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE).map_err(text)?;
    let put = |words: String, x: i32, y: i32, size: i32, side: HPos| {
        let style = (FONT, size).into_text_style(&root).color(&INK).pos(Pos::new(side, VPos::Center));
        root.draw(&Text::new(words, (x, y), style)).map_err(text)
    };
    let title = format!(
        "Energy that the time step creates: {NODES} x {NODES} nodes, four sides held, 8.4 g sphere, {:.0} us",
        1e6 * TIME
    );
    put(title, LEFT, 24, 18, HPos::Left)?;
    put("residual of the energy balance in % of the impact energy".to_string(), LEFT, 46, 14, HPos::Left)?;
    for cell in cells {
        let (Some(i), Some(j)) = (place(&columns, cell.fraction), place(&rows, cell.speed)) else { continue };
        // Fast ones at the top.
        let (x, y) = (LEFT + CELL_W * i, TOP + height - CELL_H * (j + 1));
        let colour = match cell.class() {
            Class::Sound => RGBColor(168, 216, 185),
            Class::Creep => RGBColor(246, 214, 120),
            Class::Garbage => RGBColor(235, 140, 110),
        };
        let corners = [(x, y), (x + CELL_W, y + CELL_H)];
        root.draw(&Rectangle::new(corners, colour.filled())).map_err(text)?;
        if !cell.allowed() {
            hatch(&root, corners)?;
        }
        root.draw(&Rectangle::new(corners, WHITE.stroke_width(2))).map_err(text)?;
        put(percent(cell.energy), x + CELL_W / 2, y + CELL_H / 2 - 6, 13, HPos::Center)?;
        let sign = match (cell.outcome, cell.failed_segments) {
            ("arrested", 0) => "arrested",
            ("exited", _) => "through",
            (_, 0) => "whole",
            _ => "torn",
        };
        put(sign.to_string(), x + CELL_W / 2, y + CELL_H / 2 + 9, 10, HPos::Center)?;
    }
    let allowed = columns.iter().filter(|&&fraction| fraction <= LIMIT).count() as i32;
    let border = vec![(LEFT + CELL_W * allowed, TOP - 8), (LEFT + CELL_W * allowed, TOP + height + 30)];
    root.draw(&PathElement::new(border, BLACK.stroke_width(3))).map_err(text)?;
    for (i, fraction) in columns.iter().enumerate() {
        put(fraction.to_string(), LEFT + CELL_W * i as i32 + CELL_W / 2, TOP + height + 16, 14, HPos::Center)?;
    }
    for (j, speed) in rows.iter().enumerate() {
        put(speed.to_string(), LEFT - 10, TOP + height - CELL_H * j as i32 - CELL_H / 2, 14, HPos::Right)?;
    }
    put("m/s".to_string(), LEFT - 10, TOP - 12, 14, HPos::Right)?;
    let foot = TOP + height + 40;
    put("dt / dt_crit".to_string(), LEFT + width / 2, foot, 15, HPos::Center)?;
    put(
        "refused from here on: 0.5 dt_crit is the largest step".to_string(),
        LEFT + CELL_W * allowed + 8,
        foot + 22,
        13,
        HPos::Left,
    )?;
    let keys = [
        (RGBColor(168, 216, 185), "sound: below 1 %"),
        (RGBColor(246, 214, 120), "energy creep: 1 to 10 %"),
        (RGBColor(235, 140, 110), "garbage: above 10 %"),
    ];
    for (k, (colour, words)) in keys.into_iter().enumerate() {
        let (x, y) = (LEFT + 220 * k as i32, foot + 46);
        root.draw(&Rectangle::new([(x, y), (x + 26, y + 18)], colour.filled())).map_err(text)?;
        put(words.to_string(), x + 34, y + 9, 13, HPos::Left)?;
    }
    let words = "through: the sphere has left; arrested: stopped, no yarn failed; whole: under way, no yarn failed; torn: under way or stopped, yarns failed";
    put(words.to_string(), LEFT, foot + 86, 12, HPos::Left)?;
    root.present().map_err(text)
}

/// Thin lines across a cell.
fn hatch(
    root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    [(x, y), (right, bottom)]: [(i32, i32); 2],
) -> Result<()> {
    let (w, h) = (right - x, bottom - y);
    for start in (8..w + h).step_by(8) {
        let from = (x + start.min(w), y + (start - w).max(0));
        let to = (x + (start - h).max(0), y + start.min(h));
        root.draw(&PathElement::new(vec![from, to], RGBColor(255, 255, 255).mix(0.6).stroke_width(2))).map_err(text)?;
    }
    Ok(())
}

/// A part as percent with about two figures.
fn percent(part: f64) -> String {
    let percent = 100.0 * part;
    match percent.abs() {
        size if !size.is_finite() => "fault".to_string(),
        size if size < 0.01 => "0.00".to_string(),
        size if size < 1.0 => format!("{percent:+.2}"),
        size if size < 10.0 => format!("{percent:+.1}"),
        size if size < 1e5 => format!("{percent:+.0}"),
        _ => format!("{percent:+.0e}"),
    }
}

/// Every value once, in rising order.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

fn place(values: &[f64], value: f64) -> Option<i32> {
    values.iter().position(|&x| x == value).map(|place| place as i32)
}

fn text<E: std::fmt::Display>(error: E) -> Box<dyn std::error::Error> {
    error.to_string().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_follow_the_size_of_the_residual() {
        let cell =
            |energy| Cell { fraction: 0.4, speed: 1.0, energy, absorbed: 0.0, failed_segments: 0, outcome: "exited" };
        let class = |energy| cell(energy).class();
        assert_eq!([class(0.009), class(-0.02), class(0.2)], [Class::Sound, Class::Creep, Class::Garbage]);
        assert_eq!(class(f64::INFINITY), Class::Garbage);
        assert_eq!([0.00001, 0.0042, -0.031, 7.0].map(percent), ["0.00", "+0.42", "-3.1", "+700"]);
        assert_eq!(cells(true).len(), 42);
    }
}
