//! One run of a scene: table, history, and the sheet at the end. `fabric-report` draws them.

use crate::event::{self, Summary};
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::picture::{self, Series};
use crate::progress::Progress;
use crate::{Result, report, say, threads};
use clap::Args;
use fabric::outputs::{OUTPUTS, Readings};
use fabric::{Energy, Outcome, OutcomeSet, Scene, Sim, StepCheck};
use fabric_capsule::{Call, File, Log};
use fabric_scene::{notes, textile};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Options of `run`.
#[derive(Args)]
#[command(
    after_help = "Exit status: 0 after an outcome, or after the steps with `--until none`; 3 if the steps ended the run before an \
                        outcome came; 1 after a failure; 2 for what is refused."
)]
pub struct Options {
    #[arg(value_name = "SCENE", help = crate::scene_help())]
    scene: PathBuf,
    /// Folder for history.csv, summary.json, summary.txt and the last sheet [default: target/fabric/SCENE].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Outcomes that end the run: arrested, detached, exited, passed, rebounded, through (which sets `track_through`); `none`: it goes on for its steps.
    #[arg(long, value_name = "OUTCOME,...", value_delimiter = ',', default_value = "arrested,exited,passed,rebounded", value_parser = wanted)]
    until: Vec<Option<Outcome>>,
    /// Most steps; a run that these end says TIMEOUT, and has exit status 3.
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,
    /// Steps between two rows of the history.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..))]
    sample: u64,
    /// Keep sheets on the way, of which `fabric-report` makes an animation, movie.gif.
    #[arg(long)]
    movie: bool,
    /// Keep sheets on the way, of which `fabric-report` makes a series for ParaView, vtk/run.pvd.
    #[arg(long)]
    vtk: bool,
    /// Threads that step the sheet, a band of rows each; the bits do not depend on them. Pays from some 200 x 200 nodes on,
    /// on cores that are free.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(fabric::MAX_BANDS)))]
    threads: u32,
    /// Also write a capsule of the run, which `fabric replay` does again.
    #[arg(long, value_name = "FILE")]
    capsule: Option<PathBuf>,
}

/// Calls between two digests of a capsule, each of `--sample` steps.
const DIGESTS: u64 = 100;

/// An outcome on the command line; None for `none`.
fn wanted(name: &str) -> std::result::Result<Option<Outcome>, String> {
    let found = Outcome::ALL.into_iter().find(|outcome| outcome.name() == name);
    let names = Outcome::ALL.map(|outcome| outcome.name()).join(", ");
    if found.is_some() || name == "none" { Ok(found) } else { Err(format!("there are {names} and none")) }
}

/// Exit status of a run that its steps ended.
const TIMEOUT: u8 = 3;

/// Columns of history.csv behind step, time and the mean force since the row before; SI units, host's axes. Which output of the kernel
/// each shows: a name with braces is that of three, along x, y and z.
const COLUMNS: [(&str, &str); 22] = [
    ("position_{}_m", "projectile.position"),
    ("velocity_{}_m_per_s", "projectile.velocity"),
    ("angular_velocity_{}_rad_per_s", "projectile.angular_velocity"),
    ("force_{}_n", "contact.impulse"),
    ("contact_work_j", "contact.work"),
    ("contact_loss_j", "contact.loss"),
    ("projectile_kinetic_j", "energy.projectile_kinetic"),
    ("fabric_kinetic_j", "energy.fabric_kinetic"),
    ("strain_j", "energy.strain"),
    ("dissipated_j", "energy.dissipated"),
    ("viscous_j", "energy.viscous"),
    ("friction_j", "energy.friction"),
    ("ply_loss_j", "energy.ply_loss"),
    ("support_work_j", "energy.support_work"),
    ("casing_loss_j", "energy.casing_loss"),
    ("attachment_j", "energy.attachment"),
    ("energy_residual_j", "energy.residual"),
    ("momentum_residual_n_s", "momentum.residual"),
    ("failed_segments", "counters.failed_segments"),
    ("contacts", "counters.contacts"),
    ("max_deflection_m", "fabric.max_deflection"),
    ("max_stretch", "fabric.max_stretch"),
];

/// A row of history.csv.
struct Sample {
    step: u64,
    time: f64,
    energy: Energy,
    /// Of each column three numbers, or one and zeros.
    values: Vec<[f64; 3]>,
}

impl Sample {
    fn of(sim: &mut Sim<'_>) -> Result<Sample> {
        let mut readings = Readings::default();
        let mut read = |(_, name): (&str, &str)| {
            let output = OUTPUTS.iter().find(|output| output.name == name).ok_or(format!("no output {name}"))?;
            let [x, y, z, ..] = readings.read(sim, output)?;
            Ok([x, y, z])
        };
        let values = COLUMNS.into_iter().map(&mut read).collect::<Result<_>>()?;
        Ok(Sample { step: sim.step_count(), time: sim.time(), energy: readings.energy(sim)?, values })
    }
}

/// Writes history.csv.
fn write_history(path: &Path, history: &[Sample]) -> Result<()> {
    let mut writer = csv::Writer::from_path(path)?;
    let names = COLUMNS.iter().flat_map(|(name, _)| match name.split_once("{}") {
        Some((before, after)) => ["x", "y", "z"].map(|axis| format!("{before}{axis}{after}")).to_vec(),
        None => vec![name.to_string()],
    });
    writer.write_record(["step", "time_s"].map(String::from).into_iter().chain(names))?;
    let mut before = &history[0];
    for sample in history {
        let since = sample.time - before.time;
        let mut row = vec![json!(sample.step), json!(sample.time)];
        for (((name, output), now), before) in COLUMNS.iter().zip(&sample.values).zip(&before.values) {
            match *output {
                "contact.impulse" if since > 0.0 => row.extend([0, 1, 2].map(|k| json!((now[k] - before[k]) / since))),
                "contact.impulse" => row.extend([json!(0.0), json!(0.0), json!(0.0)]),
                _ if name.contains("{}") => row.extend(now.map(|value| json!(value))),
                _ if output.starts_with("counters") => row.push(json!(now[0] as u64)),
                _ => row.push(json!(now[0])),
            }
        }
        writer.serialize(row)?;
        before = sample;
    }
    Ok(writer.flush()?)
}

/// Name of a scene by its file; one of dots alone would be another folder.
fn name_of(file: &Path) -> String {
    let name = file.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    if name.chars().all(|letter| letter == '.') { "scene".to_string() } else { name }
}

/// Makes the folder of the results.
fn make(out: &Path) -> Result<()> {
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()).into())
}

/// Finds out before the work whether that can be done. Leaves no empty folder behind, for the run may be stopped.
fn try_to_make(out: &Path) -> Result<()> {
    let there = out.is_dir();
    make(out)?;
    if !there {
        std::fs::remove_dir(out)?;
    }
    Ok(())
}

/// Runs, prints and writes. Returns how it ended.
pub fn run(options: &Options) -> Result<ExitCode> {
    let mut scene = fabric_scene::read(&options.scene)?;
    let until: Vec<Outcome> = options.until.iter().flatten().copied().collect();
    scene.track_through |= until.contains(&Outcome::Through);
    let name = name_of(&options.scene);
    let out = options.out.clone().unwrap_or_else(|| Path::new("target/fabric").join(&name));
    let doubt = notes::unlikely_body(&scene).map_or(String::new(), |note| format!("; {note}"));
    let refused =
        |error: Box<dyn std::error::Error>| format!("{}: {}{doubt}", options.scene.display(), crate::in_words(&*error));
    let mut buffers = Buffers::of(&scene).map_err(|error| refused(with_its_memory(&scene, error)))?;
    let mut sim = buffers.sim(&scene).map_err(|error| refused(error.into()))?;
    try_to_make(&out)?;

    let mask: OutcomeSet = until.iter().copied().collect();
    let wall = Instant::now();
    let mut series = if options.movie || options.vtk { Some(Series::new(&out, options.sample)?) } else { None };
    let (history, stepping, failure) = advance(&mut sim, mask, options, &name, &mut series)?;
    make(&out)?;
    write_history(&out.join("history.csv"), &history)?;
    if let Some(failure) = failure {
        say::aside(format_args!("error: the run failed at step {}: {failure}", sim.counters().steps));
        return Ok(ExitCode::FAILURE);
    }

    let mut summary = Summary::of(&sim, mask, history[0].energy.projectile_kinetic)?;
    let mut file = fabric_scene::table_of(&fabric_scene::text_of(&options.scene)?)?;
    let [front, back] = textile::names(&textile::of(&file));
    for (number, ply) in summary.plies.iter_mut().enumerate() {
        let name = if number < scene.front_plies() as usize { &front } else { &back };
        if let Some(name) = name {
            ply.fabric = format!("{name}: {}", ply.fabric);
        }
    }
    let ns = 1e9 * stepping / (sim.step_count().max(1) * sim.layout().nodes() as u64) as f64;
    let clock = match options.threads {
        1 => crate::machine::CLOCK_NAME.to_string(),
        threads => format!("wall time, {threads} threads"),
    };
    let stepping = format!("{ns:.2} ns per node-step ({clock})");
    let text = table(&name, &scene, &sim, &summary, wall.elapsed().as_secs_f64(), stepping);
    let text = if summary.plies.is_empty() { text } else { format!("{text}\n\n{}", plies(&summary)) };
    say::line(format_args!("{text}"));
    summary.warnings = warnings(&scene, &sim, &summary);
    summary.warnings.extend(fabric_scene::derived::unplaced(&file, &scene));
    if fabric_scene::takes_automatic_grading(&mut file) && !scene.is_graded() {
        summary.warnings.push(format!(
            "sheet.grading = \"automatic\" left the network whole: for an error of {} % no row of this sheet can be left out, or it is held \
             at its corners (docs/model.md, \"Graded networks\")",
            100.0 * fabric_scene::AUTOMATIC_GRADING
        ));
    }
    for warning in &summary.warnings {
        say::aside(format_args!("warning: {warning}"));
    }
    let warned: String = summary.warnings.iter().map(|warning| format!("\nwarning: {warning}\n")).collect();
    std::fs::write(out.join("summary.txt"), text + "\n" + &warned)?;
    std::fs::write(out.join("summary.json"), serde_json::to_string_pretty(&summary)? + "\n")?;
    picture::keep(&out.join(picture::LAST), &sim)?;
    let sheet = picture::describe(name, &scene)?;
    std::fs::write(out.join("sheet.json"), serde_json::to_string(&sheet)? + "\n")?;
    let frames = series.map_or(Ok(Vec::new()), |series| series.end(&sim))?;
    // The sheets on the way, and what is to be made of them.
    let kept = json!({ "movie": options.movie, "vtk": options.vtk, "frames": frames });
    std::fs::write(out.join("frames.json"), format!("{kept}\n"))?;
    say::line(format_args!("{}", report::written(&out, "run")));
    let ended = until.is_empty() || sim.outcomes().mask.has(mask);
    Ok(if ended { ExitCode::SUCCESS } else { ExitCode::from(TIMEOUT) })
}

/// Adds to a refusal of too many nodes the memory that they would take, 233 bytes each at the default capacity of contact.
fn with_its_memory(scene: &Scene, error: Box<dyn std::error::Error>) -> Box<dyn std::error::Error> {
    let refused = error.downcast_ref::<fabric::Error>().is_some_and(|error| error.code == fabric::Code::TooManyNodes);
    let nodes = f64::from(scene.sheet.nodes_x) * f64::from(scene.sheet.nodes_y) * f64::from(scene.stack.plies);
    if refused { format!("{error}; they would take some {:.0} GB of memory", 233e-9 * nodes).into() } else { error }
}

/// Steps until an outcome or the step limit. Returns the history, the seconds spent in stepping, and a failure if one came.
fn advance(
    sim: &mut Sim<'_>,
    mask: OutcomeSet,
    options: &Options,
    name: &str,
    series: &mut Option<Series>,
) -> Result<(Vec<Sample>, f64, Option<fabric::Failure>)> {
    let progress = Progress::new(&format!("{name}, of the step limit"), options.steps);
    let mut history = vec![Sample::of(sim)?];
    let mut stepping = 0.0;
    let mut failure = None;
    let new = |path: &PathBuf| File::new(path).map_err(|error| format!("--capsule {}: {error}", path.display()));
    let mut capsule = options.capsule.as_ref().map(new).transpose()?.map(|file| Log::begin(sim, DIGESTS, file));
    while sim.step_count() < options.steps && !sim.outcomes().mask.has(mask) {
        if let Some(series) = series {
            series.keep(sim)?;
        }
        let steps = options.sample.min(options.steps - sim.step_count());
        // One thread's CPU time says nothing about several.
        let (wall, clock) = (Instant::now(), Clock::start());
        let result = threads::advance_until(sim, mask, steps, options.threads)?;
        stepping += if options.threads == 1 { clock.seconds() } else { wall.elapsed().as_secs_f64() };
        if let Some(capsule) = &mut capsule {
            capsule.note(&Call::Advance(result.unwrap_or(steps)), sim);
        }
        match result {
            Err(met) => {
                failure = Some(met);
                break;
            }
            Ok(taken) => {
                let sample = Sample::of(sim)?;
                let (t, v) = (1e6 * sample.time, fabric::math::length(sim.projectile()?.velocity));
                let absorbed = sample.energy.contact_work;
                progress.add(taken, || format!("{t:.1} us  {v:.1} m/s  {absorbed:.2} J absorbed"));
                let [start, last] = [0, history.len() - 1].map(|k| history[k].energy);
                if let Some(text) = open_balance(sim, &start, &last, &sample.energy)? {
                    say::aside(format_args!("warning: {text}"));
                }
                history.push(sample);
            }
        }
    }
    progress.finish();
    if let Some(mut capsule) = capsule {
        capsule.end(sim);
        if !capsule.is_whole() {
            return Err("--capsule: it could not be written to its end".into());
        }
    }
    Ok((history, stepping, failure))
}

/// What is said when the energies cease to add up to 1 % of the impact energy.
fn open_balance(sim: &Sim<'_>, start: &Energy, last: &Energy, now: &Energy) -> Result<Option<String>> {
    let text = |energy: &Energy| notes::open_balance(sim, start.projectile_kinetic, energy.residual);
    Ok(if text(last)?.is_some() { None } else { text(now)? })
}

fn table(name: &str, scene: &Scene, sim: &Sim<'_>, summary: &Summary, wall: f64, stepping: String) -> String {
    let Summary { limits, motion, contact, support, energy, counters, .. } = summary;
    let mut rows = Vec::new();
    let mut row = |what: &str, value: String| rows.push(vec![what.to_string(), value]);
    let vector = |v: [f64; 3], digits: usize| format!("{:.digits$}  {:.digits$}  {:.digits$}", v[0], v[1], v[2]);
    row("nodes, segments", format!("{} x {}, {}", scene.sheet.nodes_x, scene.sheet.nodes_y, scene.segments()));
    if scene.symmetry != fabric::Symmetry::default() {
        let [nx, ny] = [sim.layout().nodes_x, sim.layout().nodes_y];
        row("  modelled, the rest mirrored", format!("{nx} x {ny}"));
    }
    if scene.is_graded() {
        let [nx, ny] = [sim.layout().nodes_x, sim.layout().nodes_y];
        row("  nodes of the graded network", format!("{nx} x {ny}"));
    }
    if scene.stack.plies > 1 {
        let turned = if scene.stack.turned { ", every other one turned by 90 degrees" } else { "" };
        row(
            "separate plies",
            format!("{}, {} mm apart{turned}", scene.stack.plies, report::shortest(1e3 * scene.stack.gap)),
        );
        let mut first = 0;
        for plies in summary.plies.chunk_by(|one, next| one.fabric == next.fabric) {
            let next = first + plies.len();
            row(&format!("  fabric of plies {} to {next}", first + 1), plies[0].fabric.clone());
            first = next;
        }
    }
    row("projectile", projectile(&scene.projectile));
    if scene.contact.friction > 0.0 {
        row("coefficient of friction on the projectile", report::shortest(scene.contact.friction));
    }
    row("time step", format!("{:.4e} s = {:.3} dt_crit", limits.dt, limits.dt / limits.dt_crit));
    let viscosity = scene.viscosity();
    if viscosity != [0.0; 3] {
        row("viscosity of the yarn: linear, quadratic, bending", viscosity.map(|part| format!("{part:.4}")).join("  "));
    }
    row("ended by", format!("{} at {:.1} us, step {}", summary.ended_by, 1e6 * summary.time, counters.steps));
    row("kinetic energy at the start", format!("{:.4} J", summary.initial_kinetic_energy));
    row("residual velocity x, y, z", format!("{} m/s", vector(motion.velocity, 3)));
    if sim.scene().projectile.shape != fabric::Shape::Sphere {
        row("residual angular velocity", format!("{} rad/s", vector(motion.angular_velocity, 2)));
    }
    for latched in &summary.outcomes {
        let value = format!("{:.4} J at {:.1} us", latched.absorbed, 1e6 * latched.time);
        row(&format!("absorbed when {}", latched.outcome), value);
    }
    row("absorbed at the end", format!("{:.4} J", contact.work));
    row("  of it by held nodes", format!("{:.4} J", energy.support_work));
    let window = format!("peak force (mean over {:.2} us)", 1e6 * scene.force_window.min(summary.time));
    row(&window, format!("{:.1} N", contact.force_peak));
    row("failed segments", counters.failed_segments.to_string());
    row("impulse on the supports", format!("{} mN s", vector(support.total.map(|x| 1e3 * x), 3)));
    for (index, impulse) in support.attachments.iter().enumerate().filter(|(_, impulse)| **impulse != [0.0; 3]) {
        let place = attachment_name(scene.attachment.kind, index);
        row(&format!("  {place}"), format!("{} mN s", vector(impulse.map(|x| 1e3 * x), 3)));
    }
    let held =
        [energy.fabric_kinetic, energy.strain, energy.dissipated, energy.viscous, energy.friction, energy.contact_loss];
    let held = held.map(|energy| format!("{energy:.4}")).join("  ");
    row("fabric kinetic, strain, dissipated, viscous, friction, contact loss", format!("{held} J"));
    let percent = 100.0 * summary.open_part();
    if scene.stack.plies > 1 {
        row("lost where plies meet", format!("{:.4} J", energy.ply_loss));
    }
    if scene.casing.radius != 0.0 {
        row("impulse on the case", format!("{} mN s", vector(support.casing.map(|x| 1e3 * x), 3)));
        row("lost on the case", format!("{:.4} J", energy.casing_loss));
    }
    if scene.attachment.hold != 0.0 {
        row("dissipated in clamps", format!("{:.4} J", energy.attachment));
    }
    row("energy residual", format!("{:.3e} J = {percent:.4} % of the start", energy.residual));
    row("momentum residual", format!("{:.3e} N s", summary.momentum_residual));
    row("worst penetration", format!("{:.3e} m", counters.worst_penetration));
    if scene.stack.plies > 1 {
        row("deepest overlap of two plies", format!("{:.3e} m", counters.ply_penetration));
    }
    row("digest", summary.digest.clone());
    let (bytes, nodes) = (sim.layout().bytes(), sim.layout().nodes());
    row("memory", format!("{bytes} bytes, {:.1} per node", bytes as f64 / nodes as f64));
    row("wall time", format!("{wall:.2} s with history and read-outs"));
    row("stepping", stepping);
    report::table(&[name, "value"], &rows)
}

/// What each ply of a stack holds.
fn plies(summary: &Summary) -> String {
    let row = |(number, ply): (usize, &event::InPly)| {
        let energies = [ply.kinetic, ply.strain, ply.dissipated].map(|energy| format!("{energy:.4}"));
        [vec![(number + 1).to_string(), ply.failed_segments.to_string()], energies.to_vec()].concat()
    };
    let rows: Vec<_> = summary.plies.iter().enumerate().map(row).collect();
    report::table(
        &["ply, from the side that is hit", "failed segments", "kinetic, J", "strain, J", "dissipated, J"],
        &rows,
    )
}

/// Shape and the dimensions that it reads.
fn projectile(body: &fabric::Projectile) -> String {
    let millimetres = |x: f64| report::shortest(1e3 * x);
    let shape = match body.shape {
        fabric::Shape::Sphere => format!("sphere, radius {} mm", millimetres(body.radius)),
        fabric::Shape::Box => format!("box, {} mm", body.size.map(millimetres).join(" x ")),
        fabric::Shape::Polyhedron => format!("polyhedron of {} faces", body.faces.in_use().len()),
        fabric::Shape::DiscSector => {
            let fabric::internals::parts::Sector { inner_radius, outer_radius, angle, thickness } = body.sector;
            let [inner, outer, thickness] = [inner_radius, outer_radius, thickness].map(millimetres);
            let degrees = report::shortest(angle.to_degrees());
            format!("disc sector, radii {inner} and {outer} mm, {degrees} degrees, {thickness} mm thick")
        }
        fabric::Shape::Cylinder | fabric::Shape::HemisphericalCylinder => {
            let name = if body.shape == fabric::Shape::Cylinder { "cylinder" } else { "hemispherical cylinder" };
            format!("{name}, radius {}, length {} mm", millimetres(body.radius), millimetres(body.length))
        }
    };
    format!("{shape}, {} g", report::shortest(1e3 * body.mass))
}

/// What the numbers alone do not say loudly enough.
fn warnings(scene: &Scene, sim: &Sim<'_>, summary: &Summary) -> Vec<String> {
    let mut found = Vec::from_iter(notes::unlikely_body(scene));
    if sim.step_count() > 0 && summary.ended_by == "TIMEOUT" && sim.contact().is_ok_and(|contact| contact.work == 0.0) {
        found.push("the projectile never touched the sheet: look at its position and velocity".to_string());
    }
    if scene.step_check == StepCheck::None {
        found.push(
            "the time step was not checked: above 0.5 dt_crit the results are wrong, although they may look plausible"
                .to_string(),
        );
    }
    if summary.open_part().abs() > 0.01 {
        found.push(format!("the energy balance does not close within 1 % of the impact energy: {}", notes::SLACK_ADDS));
    }
    if summary.counters.unconverged > 0 {
        let share = 100.0 * summary.counters.unconverged as f64 / summary.counters.steps.max(1) as f64;
        let advice = if share < 1.0 {
            "below 1 % of the steps this may be left so"
        } else {
            "compare with a run of half the step, less friction or a gap between the plies before you rely on this one"
        };
        found.push(format!(
            "{} contact solves, {share:.2} % of the steps, were given up: their impulses are inexact, although they \
             keep momentum and add no energy; {advice} (docs/model.md, \"Friction\")",
            summary.counters.unconverged
        ));
    }
    if summary.counters.beyond_fine > 0 {
        found.push(format!(
            "for {} steps the projectile met the sheet beyond the fine part of the graded network, where nodes may be too far apart to feel \
             it: move sheet.grading.centre or enlarge half_width",
            summary.counters.beyond_fine
        ));
    }
    found.extend(notes::sharp_edges(scene, fabric::math::length(scene.projectile.velocity)));
    let [nx, ny] = [sim.layout().nodes_x, sim.layout().y.modelled()];
    let free = |j: usize| {
        let fixed: u32 = fabric::internals::weave::fixed_runs(scene, j).iter().map(|run| run[1] - run[0]).sum();
        (fixed as usize) < nx
    };
    if !(0..ny).any(free) {
        found.push("every node is fixed: there is nothing to hit".to_string());
    }
    found
}

/// Name of an attachment by its number.
fn attachment_name(kind: fabric::AttachmentKind, index: usize) -> &'static str {
    let names = match kind {
        fabric::AttachmentKind::FourCorners => ["corner -x -y", "corner +x -y", "corner -x +y", "corner +x +y"],
        _ => ["side -x", "side +x", "side -y", "side +y"],
    };
    names[index]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::Buffers;

    #[test]
    fn solves_at_their_limit_come_with_their_share_and_advice() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (11, 11);
        let mut buffers = Buffers::of(&scene).unwrap();
        let sim = buffers.sim(&scene).unwrap();
        let mut summary = Summary::of(&sim, fabric::OutcomeSet::NONE, 0.0).unwrap();
        assert!(warnings(&scene, &sim, &summary).is_empty());
        (summary.counters.steps, summary.counters.unconverged) = (1000, 4);
        let warned = warnings(&scene, &sim, &summary).concat();
        assert!(
            warned.starts_with("4 contact solves, 0.40 % of the steps") && warned.contains("may be left so"),
            "{warned}"
        );
        summary.counters.unconverged = 40;
        let warned = warnings(&scene, &sim, &summary).concat();
        assert!(warned.contains("4.00 % of the steps") && warned.contains("half the step"), "{warned}");
    }

    #[test]
    fn a_projectile_that_never_touched_the_sheet_is_named() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (11, 11);
        for (distance, contact) in [(0.0, true), (1.0, false)] {
            scene.projectile.position[2] -= distance;
            let mut buffers = Buffers::of(&scene).unwrap();
            let mut sim = buffers.sim(&scene).unwrap();
            sim.advance(200).unwrap();
            let summary = Summary::of(&sim, fabric::OutcomeSet::NONE, 0.0).unwrap();
            let warned = warnings(&scene, &sim, &summary).concat();
            assert_eq!(warned.contains("never touched"), !contact, "{distance}: {warned}");
        }
    }

    #[test]
    fn an_open_balance_is_told_once_with_its_cause() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y, scene.sheet.crimp) = (11, 11, [0.01; 2]);
        let mut buffers = Buffers::of(&scene).unwrap();
        let sim = buffers.sim(&scene).unwrap();
        let start = sim.energy().unwrap();
        let sample = |open: f64| Energy { residual: open * start.projectile_kinetic, ..start };
        let told = |last: f64, now: f64| open_balance(&sim, &start, &sample(last), &sample(now)).unwrap();
        assert_eq!(told(0.0, 0.009), None);
        assert_eq!(told(0.02, 0.03), None);
        let text = told(0.005, 0.64).unwrap();
        assert!(text.contains("open by 64.0 %") && text.contains("100 % of the segments are slack"), "{text}");
    }

    #[test]
    fn memory_is_of_the_nodes_that_are_there() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y, scene.stack.plies, scene.stack.gap) = (11, 11, 3, 1e-4);
        let mut buffers = Buffers::of(&scene).unwrap();
        let sim = buffers.sim(&scene).unwrap();
        let summary = Summary::of(&sim, fabric::OutcomeSet::NONE, 0.0).unwrap();
        let text = table("plies", &scene, &sim, &summary, 0.0, String::new());
        let per_node = format!("{:.1} per node", sim.layout().bytes() as f64 / 363.0);
        assert!(text.contains(&per_node), "{text}");
    }
}
