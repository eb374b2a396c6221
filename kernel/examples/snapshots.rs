//! Runs an impact with the kernel moving the projectile itself, and writes the sheet at some times.
//!
//! ```text
//! cargo run --release -p fabric-kernel --example snapshots -- IMPACT OUT
//! ```
//! IMPACT is a text of lines `name value...` as examples/rotorburst writes it: which sheet and how many bonded plies; a disc sector's dimensions and mass, if it
//! is not the paper's projectile; number and gap of separate plies; its motion when it comes near the sheet; the times of the pictures and the latest end, s. OUT is a
//! file of little-endian f64 numbers: nodes along x and y, number of pictures; then for each picture: its time, position (3) and
//! orientation (4) of the projectile, positions of the nodes (3 each) and alpha of the segments (1 whole, 0 failed); then how it
//! ended: outcome (0 arrested, 2 exited, 3 passed, -1 none of these), velocity (3) and absorbed energy then, and the number of failed
//! segments.

use fabric::{AttachmentKind, CacheLine, Layout, Outcome, Scene, Sector, Shape, Sim, Stack, TimeStep};
use std::collections::HashMap;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [impact, out] = arguments.as_slice() else {
        return Err("arguments: IMPACT OUT".into());
    };
    let text = std::fs::read_to_string(impact)?;
    let lines: Lines = text.lines().filter_map(|line| line.split_once(' ')).collect();
    let scene = scene_of(&lines)?;
    let layout = Layout::of(&scene)?;
    let mut memory = vec![CacheLine::ZERO; layout.lines()];
    let mut sim = Sim::new(&scene, &mut memory)?;

    let dt = sim.step_limits().dt;
    let pictures: [f64; 4] = numbers(&lines, "pictures")?;
    let [end] = numbers(&lines, "end")?;
    let mut values = vec![f64::from(scene.sheet.nodes_x), f64::from(scene.sheet.nodes_y), pictures.len() as f64];
    let mut ending = None;
    for picture in pictures {
        let step = fabric::math::round(picture / dt) as u64;
        watch(&mut sim, step, &mut ending)?;
        sim.advance(step.saturating_sub(sim.step_count()))?;
        let body = sim.projectile()?;
        values.push(sim.time());
        values.extend(body.position);
        values.extend(body.orientation);
        let (mut positions, mut alpha) = (vec![0.0; 3 * layout.nodes()], vec![0.0; layout.segments()]);
        sim.copy_positions(&mut positions)?;
        sim.copy_damage(&mut alpha)?;
        // Of a stack the last ply, which the projectile leaves by.
        values.extend(&positions[positions.len() - positions.len() / layout.plies..]);
        values.extend(&alpha[alpha.len() - alpha.len() / layout.plies..]);
    }
    watch(&mut sim, fabric::math::round(end / dt) as u64, &mut ending)?;
    values.extend(ending.unwrap_or(ending_of(&sim, -1.0)?));
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    Ok(std::fs::write(out, bytes)?)
}

/// Outcome, velocity, absorbed energy, failed segments.
type Ending = [f64; 6];

fn ending_of(sim: &Sim, outcome: f64) -> Result<Ending, fabric::Failure> {
    let velocity = sim.projectile()?.velocity;
    Ok([outcome, velocity[0], velocity[1], velocity[2], sim.contact()?.work, sim.counters().failed_segments as f64])
}

/// Goes on to step `last`, or to where the projectile has stopped or left if that comes first: that is the ending.
fn watch(sim: &mut Sim, last: u64, ending: &mut Option<Ending>) -> Result<(), fabric::Failure> {
    if ending.is_some() {
        return Ok(());
    }
    let ends = [Outcome::Arrested, Outcome::Exited, Outcome::Passed];
    let mask = ends.iter().copied().collect::<fabric::OutcomeSet>();
    sim.advance_until(mask, last.saturating_sub(sim.step_count()))?;
    let latched = sim.outcomes().mask;
    if let Some(&outcome) = ends.iter().find(|outcome| latched.has(**outcome)) {
        *ending = Some(ending_of(sim, outcome as u32 as f64)?);
    }
    Ok(())
}

/// The rest of each line, by its first word.
type Lines<'a> = HashMap<&'a str, &'a str>;

fn word<'a>(lines: &Lines<'a>, name: &str) -> Result<&'a str, String> {
    lines.get(name).copied().ok_or(format!("{name} is missing"))
}

fn numbers<const N: usize>(lines: &Lines, name: &str) -> Result<[f64; N], Box<dyn Error>> {
    let values: Vec<f64> = word(lines, name)?.split(' ').map(str::parse).collect::<Result<_, _>>()?;
    values.try_into().map_err(|_| format!("{name}: {N} numbers are needed").into())
}

/// The scene of an impact: sheet and projectile, in the motion given.
fn scene_of(lines: &Lines) -> Result<Scene, Box<dyn Error>> {
    let mut scene = match word(lines, "sheet")? {
        "10in" => Scene::sheet_10in_cylinder(),
        "3in" => Scene::sheet_3in_sphere(),
        other => return Err(format!("sheet {other} is unknown").into()),
    };
    if lines.contains_key("sector") {
        let [inner_radius, outer_radius, angle, thickness] = numbers(lines, "sector")?;
        scene.projectile.shape = Shape::DiscSector;
        scene.projectile.sector = Sector { inner_radius, outer_radius, angle, thickness };
        [scene.projectile.mass] = numbers(lines, "mass")?;
    }
    scene.attachment.kind = match word(lines, "attachment")? {
        "two_sides" => AttachmentKind::TwoSides,
        "four_sides" => AttachmentKind::FourSides,
        "four_corners" => AttachmentKind::FourCorners,
        other => return Err(format!("attachment {other} is unknown").into()),
    };
    if lines.contains_key("stack") {
        let [plies, gap] = numbers(lines, "stack")?;
        scene.stack = Stack { plies: plies as u32, gap, turned: false };
    }
    scene.sheet.plies = word(lines, "plies")?.parse()?;
    scene.seed = word(lines, "seed")?.parse()?;
    let [dt] = numbers(lines, "dt")?;
    scene.time_step = TimeStep::seconds(dt);
    scene.projectile.position = numbers(lines, "position")?;
    scene.projectile.velocity = numbers(lines, "velocity")?;
    scene.projectile.orientation = numbers(lines, "orientation")?;
    scene.projectile.angular_velocity = numbers(lines, "angular_velocity")?;
    Ok(scene)
}
