//! The model against closed forms and published measurements, with the data of yarns and fabrics as its only input.
//!
//! | part | file |
//! |---|---|
//! | one yarn hit across, against Smith's relation; its critical velocity | `yarn.rs` |
//! | Kevlar 49 yarn at six gauge lengths, and fabric at three rates of strain | `strength.rs`, `rate.rs` |
//! | the pyramid behind the transverse wave of a sheet | `cone.rs` |
//! | convergence in the spacing of absorbed energy and ballistic limit | `spacing.rs` |
//! | ballistic limit against areal density, on Cunniff's axes and beside a measured ladder | `packs.rs` |
//!
//! `hits.rs` finds ballistic limits. `python3 -m reports validate` computes the verdicts from intervals, draws, and writes the
//! tables of docs/validation.md; the measurements are in validation/*.toml and the fabrics in fabrics/*.toml.

mod cone;
mod packs;
mod rate;
mod spacing;
mod strength;
mod yarn;

use crate::{Result, machine, report, say};
use clap::Args;
use fabric::{AttachmentKind, Scene, Textile};
use fabric_scene::textile;
use std::path::PathBuf;

/// Time after which an impact is given up, s.
const LONGEST: f64 = 2e-3;

/// Options of `validate`.
#[derive(Args)]
pub struct Options {
    /// Fewer and smaller runs: a check that everything works, within 20 seconds, not a result.
    #[arg(long)]
    quick: bool,
    /// Only these parts.
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Part>,
    /// Folder for the CSV files.
    #[arg(long, value_name = "DIR", default_value = "target/study/validate")]
    out: PathBuf,
}

/// A part of the study.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Part {
    Yarn,
    Strength,
    Rate,
    Cone,
    Spacing,
    Packs,
}

/// Runs the parts and writes. False if one yarn is not Smith's, or not as strong as measured.
pub fn run(options: &Options) -> Result<bool> {
    let (quick, out) = (options.quick, &options.out);
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let about = serde_json::json!({ "effort": if quick { " --quick" } else { "" } });
    std::fs::write(out.join("validate.json"), about.to_string())?;
    let wanted = |part: Part| options.only.is_empty() || options.only.contains(&part);
    let wall = machine::Wall::start();
    let mut sound = true;
    if wanted(Part::Yarn) {
        sound &= yarn::run(quick, out)?;
    }
    if wanted(Part::Strength) {
        sound &= strength::run(quick, out)?;
    }
    if wanted(Part::Rate) {
        sound &= rate::run(out)?;
    }
    if wanted(Part::Cone) {
        cone::run(quick, out)?;
    }
    if wanted(Part::Spacing) {
        spacing::run(quick, out)?;
    }
    if wanted(Part::Packs) {
        packs::run(quick, out)?;
    }
    say::line(format_args!("{:.0} s; {}", wall.seconds(), report::written(out, "validate")));
    Ok(sound)
}

/// A textile of the folder fabrics.
pub fn named(name: &str) -> Result<Textile> {
    let found = textile::all()?.into_iter().find(|named| named.name == name);
    Ok(found.ok_or_else(|| format!("no fabric {name}"))?.textile)
}

/// The rows of a table of validation/kevlar49_strength.toml.
fn measured_rows<T>(table: &str, read: impl Fn(&toml::Value) -> Option<T>) -> Result<Vec<T>> {
    let file: toml::Table = include_str!("../../validation/kevlar49_strength.toml").parse()?;
    let rows = file.get(table).and_then(toml::Value::as_array);
    let found = rows.and_then(|rows| rows.iter().map(read).collect());
    Ok(found.ok_or_else(|| format!("validation/kevlar49_strength.toml: [[{table}]]"))?)
}

/// A square sheet of the textile, so many metres wide and held on four sides, with a bar for so many yarns: mass, stiffness and
/// strength per width are those of the textile. Both directions must be alike.
pub fn sheet(textile: &Textile, width: f64, bar: f64) -> Result<Scene> {
    let mut scene = Scene::sheet_3in_sphere();
    scene.set_textile(textile)?;
    let sheet = &mut scene.sheet;
    sheet.spacing *= bar;
    sheet.yarn_area *= bar;
    sheet.node_mass *= bar * bar;
    let nodes = (width / sheet.spacing).round() as u32 + 1;
    (sheet.nodes_x, sheet.nodes_y) = (nodes, nodes);
    scene.attachment.kind = AttachmentKind::FourSides;
    Ok(scene)
}
