//! Ballistic limit against areal density: packs of Kevlar KM2 S706, and the packs of Twaron CT612 that were shot at.
//!
//! Axes: P. M. Cunniff, 18th International Symposium on Ballistics (1999): V50/(U*)^(1/3) over A_d A_p/m_p, with the areal density A_d,
//! the presented area A_p and the mass m_p of the projectile, and U* = (strength x failure strain)/(2 density) x sqrt(modulus/density).
//! Input is yarn data alone. Twaron: areal density of a layer from the table itself, fibre "PPTA, regular" of validation/fibres.toml
//! before weaving; linear density and count were not seen, so the yarns are spaced as those of S706, which is a choice.
//!
//! Method: the limit of five hits each, with the viscosity of real fabrics, with a bar for one yarn and with one for two, a sheet 160 mm
//! wide held on four sides, and the fragment as a flat-ended cylinder of its diameter and mass. All plies are bonded, that is, lumped
//! into one network; the packs that were shot at also separate, a network for each ply, with a bar for two yarns, three hits, and a
//! sheet 80 mm wide, as it takes long; beside it stands the same bonded.
//! Limits: bonded plies are hit at once and cannot part; the gap between separate ones is a choice; no friction, no slip; how the packs
//! were held was not seen.

use super::{LONGEST, named, sheet};
use crate::error_time::overshoot::{VISCOUS, with_viscosity};
use crate::hits::{each, limit};
use crate::progress::Progress;
use crate::table::{Cell, Table};
use crate::{Result, report};
use fabric::{Scene, Shape, Textile};
use std::path::Path;
use toml::Value;

const FIBRES: &str = include_str!("../../../validation/fibres.toml");
const LADDER: &str = include_str!("../../../validation/twaron_ct612_v50.toml");
/// The fibre of the ladder.
const PPTA: &str = "PPTA, regular";
/// Plies of S706.
const PLIES: [u32; 5] = [1, 5, 14, 28, 42];
/// Widths of a sheet, m: bonded alone, and bonded beside separate.
const WIDTH: f64 = 0.16;
const SMALL_WIDTH: f64 = 0.08;
/// Bars, yarn spacings.
const BARS: [f64; 2] = [1.0, 2.0];
/// Hits of bonded and of separate packs; gap between separate plies, m, a choice; bars of theirs, yarn spacings.
const HITS: [u64; 2] = [5, 3];
const GAP: f64 = 1e-4;
const SEPARATE_BAR: f64 = 2.0;
/// Time after which an impact on separate plies is given up, s: five times what the fragment needs to stop or to get through.
const LONGEST_SEPARATE: f64 = 3e-4;
/// Density of the fragment's steel, kg/m^3.
const STEEL: f64 = 7850.0;

/// A pack to be shot at.
#[derive(Clone, Copy)]
struct Pack {
    name: &'static str,
    textile: Textile,
    plies: u32,
    /// V50 as measured, m/s; NaN if there is none.
    measured: f64,
}

/// A number of a table, whole or not.
fn number(table: &Value, key: &str) -> Result<f64> {
    let value = table.get(key).ok_or_else(|| format!("validation: no {key}"))?;
    let whole = value.as_integer().map(|whole| whole as f64);
    Ok(value.as_float().or(whole).ok_or_else(|| format!("validation: {key} is not a number"))?)
}

/// (U*)^(1/3), m/s.
fn cunniff(strength: f64, strain: f64, modulus: f64, density: f64) -> f64 {
    (0.5 * strength * strain / density * (modulus / density).sqrt()).cbrt()
}

/// The textile with the fibre of a row of fibres.toml, before weaving.
fn of_fibre(name: &str, mut textile: Textile) -> Result<Textile> {
    let file: Value = FIBRES.parse::<toml::Table>()?.into();
    let rows = file["fibre"].as_array().ok_or("fibres.toml: [[fibre]]")?;
    let row = rows.iter().find(|row| row["name"].as_str() == Some(name)).ok_or("fibres.toml: no such fibre")?;
    textile.fibre_density = 1e3 * number(row, "density_g_per_cm3")?;
    textile.modulus = 1e9 * number(row, "modulus_gpa")?;
    textile.failure_strain = 1e-2 * number(row, "failure_strain_percent")?;
    Ok(textile)
}

fn packs(quick: bool) -> Result<(Vec<Pack>, Value)> {
    let km2 = named("kevlar_km2_s706")?;
    let mut packs = Vec::new();
    for plies in PLIES {
        packs.push(Pack { name: "Kevlar KM2 S706", textile: km2, plies, measured: f64::NAN });
    }
    let ladder: Value = LADDER.parse::<toml::Table>()?.into();
    for row in ladder["v50"].as_array().ok_or("[[v50]]")? {
        let (layers, density) = (number(row, "layers")?, number(row, "areal_density_kg_per_m2")?);
        let mut textile = of_fibre(PPTA, km2)?;
        for threads in [&mut textile.warp, &mut textile.weft] {
            threads.linear_density = 0.5 * density / layers / threads.count;
        }
        packs.push(Pack { name: "Twaron CT612", textile, plies: layers as u32, measured: number(row, "v50_m_per_s")? });
    }
    if quick {
        packs.drain(..PLIES.len());
        packs.truncate(1);
    }
    Ok((packs, ladder["projectile"].clone()))
}

/// A network of a pack.
#[derive(Clone, Copy)]
struct Network {
    pack: Pack,
    /// Yarns that a bar stands for.
    bar: f64,
    /// Width of the sheet, m.
    width: f64,
    /// Whether each ply has a network of its own.
    separate: bool,
}

/// The pack's sheet with the fragment before it.
fn scene(network: &Network, radius: f64, mass: f64) -> Result<Scene> {
    let Network { pack, bar, width, separate } = *network;
    let mut scene = with_viscosity(sheet(&pack.textile, width, bar)?, VISCOUS);
    if separate {
        (scene.stack.plies, scene.stack.gap) = (pack.plies, GAP);
    } else {
        scene.sheet.plies = pack.plies;
    }
    let body = &mut scene.projectile;
    (body.shape, body.radius, body.mass) = (Shape::Cylinder, radius, mass);
    body.length = mass / (STEEL * std::f64::consts::PI * radius * radius);
    Ok(scene)
}

/// Runs and writes.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let (packs, fragment) = packs(quick)?;
    let (radius, mass) = (0.5e-3 * number(&fragment, "diameter_mm")?, 1e-3 * number(&fragment, "mass_g")?);
    let bars = if quick { &[][..] } else { &BARS };
    let mut networks: Vec<Network> = Vec::new();
    for &bar in bars {
        networks.extend(packs.iter().map(|&pack| Network { pack, bar, width: WIDTH, separate: false }));
    }
    let width = if quick { 0.03 } else { SMALL_WIDTH };
    for separate in [false, true] {
        let shot_at = packs.iter().filter(|pack| pack.measured > 0.0);
        networks.extend(shot_at.map(|&pack| Network { pack, bar: SEPARATE_BAR, width, separate }));
    }
    let hits = |network: &Network| if quick { 2 } else { HITS[usize::from(network.separate)] };
    let mut jobs: Vec<(usize, u64)> = Vec::new();
    for (k, network) in networks.iter().enumerate() {
        jobs.extend((0..hits(network)).map(|hit| (k, hit)));
    }
    // Those that take long first.
    jobs.sort_by_key(|job| (!networks[job.0].separate, std::cmp::Reverse(networks[job.0].pack.plies)));
    let progress = Progress::new("packs", jobs.len() as u64);
    let found = each(&jobs, |&(k, hit)| {
        let network = &networks[k];
        let pack = &network.pack;
        // Near the trend of the measurements.
        let guess = 300.0 * (f64::from(pack.plies) * pack.textile.areal_density()).sqrt().max(0.3);
        let longest = if network.separate { LONGEST_SEPARATE } else { LONGEST };
        let found = limit(&scene(network, radius, mass)?, guess, hit, longest)?;
        progress.add(1, || format!("{}, {} plies", pack.name, pack.plies));
        Ok(found)
    })?;
    progress.finish();
    let mut table = Table::new(&[
        "pack",
        "form",
        "yarns a bar",
        "width mm",
        "plies",
        "areal density kg/m2",
        "A_d A_p/m_p",
        "(U*)^(1/3) m/s",
        "hits",
        "limit m/s",
        "limit m/s: deviation",
        "measured V50 m/s",
    ]);
    for (k, Network { pack, bar, width, separate }) in networks.iter().enumerate() {
        let own = jobs.iter().zip(&found).filter(|(job, _)| job.0 == k);
        let limits: &[f64] = &own.map(|(_, limit)| *limit).collect::<Vec<_>>();
        let density = f64::from(pack.plies) * pack.textile.areal_density();
        let (modulus, stretch) = (pack.textile.modulus, pack.textile.critical_stretch()?);
        let strength = 0.5 * modulus * stretch * (stretch * stretch - 1.0);
        let axis = cunniff(strength, stretch - 1.0, modulus, pack.textile.fibre_density);
        let ratio = density * std::f64::consts::PI * radius * radius / mass;
        let form = if *separate { "separate" } else { "bonded" };
        let mut row = vec![Cell::text(pack.name), Cell::text(form)];
        let values = [*bar, 1e3 * width, f64::from(pack.plies), density, ratio, axis, limits.len() as f64];
        row.extend(values.map(Cell::Number));
        row.extend([report::mean(limits), report::deviation(limits), pack.measured].map(Cell::Number));
        table.add(row);
    }
    table.write(&out.join("packs.csv"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// KM2 before weaving: 3.88 GPa x 0.0452/(2 x 1440) x sqrt(84.62e9/1440) = 4.668e8, its cube root 775.7.
    #[test]
    fn cunniffs_velocity_of_a_fibre() {
        assert!((cunniff(3.88e9, 0.0452, 84.62e9, 1440.0) - 775.7).abs() < 0.1);
    }

    /// The packs weigh what the table says.
    #[test]
    fn packs_weigh_what_was_shot_at() {
        let (packs, _) = packs(false).unwrap();
        let twaron: Vec<&Pack> = packs.iter().filter(|pack| pack.measured > 0.0).collect();
        assert_eq!(twaron.len(), 5);
        assert!((f64::from(twaron[0].plies) * twaron[0].textile.areal_density() - 2.5).abs() < 1e-12);
    }
}
