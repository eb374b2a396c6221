//! The cases that are stepped, and how one is timed: every way to step it in turn, from the same image, round
//! by round.

use super::Bench;
use super::rows::{Row, SINGLE_STEPS};
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::{Result, threads};
use fabric_kernel::{AttachmentKind, InstructionSet, Scene, Sim, Stack, StrengthDraw};
use fabric_scene::textile;
use std::time::Instant;

/// A sheet that is stepped.
pub struct Case {
    /// Name in tables.
    pub name: &'static str,
    /// What is simulated.
    pub scene: Scene,
    /// What is done before the first step.
    pub start: fn(&mut Sim<'_>) -> Result<()>,
    /// Steps before the measured ones.
    pub before: u64,
}

impl Case {
    /// Nodes along each side.
    pub fn size(&self) -> u32 {
        self.scene.sheet.nodes_x
    }
}

/// A way to step: it changes the time, not the bits.
#[derive(Clone, Copy)]
pub struct Way {
    /// Instruction set.
    pub instructions: InstructionSet,
    /// Threads.
    pub threads: u32,
    /// Whether a sheet beyond the caches takes one step at a time, too, on one thread.
    pub single_steps: bool,
}

impl Way {
    /// The name of a case that is stepped this way.
    fn case(self, name: &str) -> String {
        if self.single_steps { format!("{name}{SINGLE_STEPS}") } else { name.to_string() }
    }
}

/// The numbers of threads that are measured.
pub const THREADS: [u32; 2] = [1, 2];

/// How long to measure.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Rounds through all ways.
    pub rounds: usize,
    /// Node-steps in one round: long against the clock, short against a coffee.
    pub node_steps: u64,
}

/// Steps a simulation one way.
pub fn advance(sim: &mut Sim<'_>, way: Way, steps: u64) -> Result<()> {
    sim.use_instructions(way.instructions)?;
    if way.single_steps {
        return (0..steps).try_for_each(|_| Ok(sim.step()?));
    }
    threads::advance_until(sim, fabric_kernel::OutcomeSet::NONE, steps, way.threads)??;
    Ok(())
}

/// The hot pass alone: a sheet in motion, nothing that touches it, nothing tracked.
pub fn sweep(size: u32) -> Case {
    let mut scene = held(size);
    scene.projectile.position[2] = -1.0;
    scene.projectile.velocity = [0.0; 3];
    (scene.track_support, scene.track_detachment) = (false, false);
    // All of the sheet moves from the first step on: a large one need not be stepped for long.
    let before = (200_000_000 / (u64::from(size) * u64::from(size))).clamp(50, 1000).next_multiple_of(8);
    Case { name: "sweep", scene, start: |sim| throw(sim, 20.0), before }
}

/// A case of another sheet.
fn other(mut case: Case, change: fn(&mut Scene)) -> Result<Case> {
    change(&mut case.scene);
    Ok(case)
}

/// Unlike directions and crimp.
fn crimped(scene: &mut Scene) {
    (scene.sheet.spacing_y, scene.sheet.crimp) = (1.2 * scene.sheet.spacing, [0.001, 0.003]);
}

/// Damped along the yarns.
fn viscous(scene: &mut Scene) {
    (scene.yarn.viscosity_linear, scene.yarn.viscosity_quadratic) = (0.06, 1.5);
}

/// A ring of that many nodes around.
fn ring(scene: &mut Scene) {
    scene.sheet.closed = true;
    scene.sheet.radius = scene.closed_radius();
}

/// A case of the paper's sheet with a sheet of Kevlar KM2, style S706, in its place: viscous, as textiles
/// are. The sphere comes at 150 m/s.
pub fn of_kevlar(case: Case, name: &'static str) -> Result<Case> {
    let named = textile::all()?.into_iter().find(|named| named.name == "kevlar_km2_s706").ok_or("no textile KM2")?;
    let mut scene = case.scene;
    scene.set_textile(&named.textile)?;
    // The sphere of the preset touches the mid-surface: here it touches the face.
    scene.projectile.position[2] -= 0.5 * scene.sheet.thickness;
    scene.projectile.velocity[2] = scene.projectile.velocity[2].min(150.0);
    Ok(Case { name, scene, ..case })
}

/// Twelve bonded plies of that fabric under a steel body with edges, at 300 m/s.
fn edged(name: &'static str, body: &str, size: u32) -> Result<Case> {
    let cloth = format!("fabric = \"kevlar_km2_s706\"\nsheet = {{ nodes_x = {size}, nodes_y = {size}, plies = 12 }}");
    let scene = fabric_scene::parse(&format!("{cloth}\nprojectile = {{ {body} }}\naim.speed = \"300 m/s\""))?;
    Ok(Case { name, scene, start: |_| Ok(()), before: 1000 })
}

/// A case of so many nodes along each side.
type OfSize = fn(u32) -> Result<Case>;

/// The cases whose instructions are counted.
pub const COUNTED: [(&str, OfSize); 15] = [
    ("sweep", |size| Ok(sweep(size))),
    ("fabric", |size| other(sweep(size), crimped)),
    ("slack", |size| {
        other(sweep(size), |scene| {
            crimped(scene);
            scene.slack_balance = true;
        })
    }),
    ("graded", |size| {
        // As many nodes: the fine part covers the sheet.
        other(sweep(size), |scene| {
            let half_width = scene.half_size().map(|half| 2.0 * half);
            scene.sheet.grading = fabric_kernel::Grading { largest: 2, half_width, ..scene.sheet.grading };
        })
    }),
    ("viscous", |size| {
        other(sweep(size), |scene| {
            viscous(scene);
            scene.yarn.viscosity_bending = 0.06;
        })
    }),
    ("rate", |size| {
        other(sweep(size), |scene| {
            let yarn = &mut scene.yarn;
            (yarn.rate_modulus, yarn.rate_stretch, yarn.rate_reference, yarn.rate_limit) = (0.13, 0.16, 30.0, 170.0);
        })
    }),
    ("ring", |size| other(sweep(size), ring)),
    ("cased ring", |size| {
        other(sweep(size), |scene| {
            ring(scene);
            viscous(scene);
            scene.casing.radius = scene.sheet.radius;
        })
    }),
    ("KM2 sweep", |size| of_kevlar(sweep(size), "KM2 sweep")),
    ("run", |size| Ok(whole_run(size))),
    ("KM2 run", |size| of_kevlar(whole_run(size), "KM2 run")),
    ("strength", |size| other(whole_run(size), |scene| scene.yarn.strength_draw = StrengthDraw::Weibull)),
    ("plies", |size| Ok(plies(size))),
    ("FSP run", |size| edged("FSP run", "shape = \"fsp\", calibre = \".22\"", size)),
    ("cube run", |size| {
        edged("cube run", "shape = \"box\", size = [\"5 mm\", \"5 mm\", \"5 mm\"], material = \"steel\"", size)
    }),
];

/// The whole run: the preset's sphere at 300 m/s, taken up when contact is wide and the first segments fail
/// or are about to.
pub fn whole_run(size: u32) -> Case {
    let mut scene = held(size);
    scene.projectile.velocity = [0.0, 0.0, 300.0];
    Case { name: "run", scene, start: |_| Ok(()), before: 1000 }
}

/// Shot through five plies 0.1 mm apart, all of which touch when the steps are counted.
pub fn plies(size: u32) -> Case {
    let mut case = whole_run(size);
    (case.name, case.scene.stack) = ("plies", Stack { plies: 5, gap: 1e-4, turned: false });
    case
}

/// Damage everywhere: the preset hit at 400 m/s, taken up when most of the sheet is damaged or has failed.
pub fn dense(size: u32) -> Case {
    let mut scene = held(size);
    scene.projectile.velocity = [0.0, 0.0, 400.0];
    Case { name: "dense", scene, start: |_| Ok(()), before: 4000 }
}

/// The preset's sheet with another number of nodes, four sides held.
fn held(size: u32) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (size, size);
    scene.attachment.kind = AttachmentKind::FourSides;
    scene
}

/// Gives a flat sheet the velocity `speed` cos(pi x/2a) cos(pi y/2b), m/s, along z.
fn throw(sim: &mut Sim<'_>, speed: f64) -> Result<()> {
    let mut positions = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut positions)?;
    let [a, b] = sim.scene().half_size();
    let mut velocities = vec![0.0; positions.len()];
    for (x, v) in positions.chunks_exact(3).zip(velocities.chunks_exact_mut(3)) {
        // Exactly 0 on the held edge, where the cosine only almost is.
        let inside = x[0].abs() < 0.999_999 * a && x[1].abs() < 0.999_999 * b;
        let half_turn = std::f64::consts::FRAC_PI_2;
        v[2] = if inside { speed * (half_turn * x[0] / a).cos() * (half_turn * x[1] / b).cos() } else { 0.0 };
    }
    sim.set_motion(&positions, &velocities)?;
    Ok(())
}

/// A simulation that has taken the steps before the measured ones, and its image. From here on rows at rest
/// are stepped too, so that no figure depends on how far the wave has come.
pub fn prepare<'a>(case: &Case, buffers: &'a mut Buffers) -> Result<(Sim<'a>, Vec<u8>)> {
    let mut sim = buffers.sim(&case.scene)?;
    (case.start)(&mut sim)?;
    sim.advance(case.before)?;
    sim.step_every_row();
    let mut image = vec![0; sim.snapshot_bytes()];
    sim.save(&mut image)?;
    Ok((sim, image))
}

/// Steps of one burst, and bursts of one round: a small sheet repeats the same steps.
fn steps_and_bursts(nodes: u64, effort: Effort) -> (u64, u64) {
    // Some blocks of a sheet beyond the caches.
    let steps = (effort.node_steps / nodes).clamp(32, 400) / 8 * 8;
    (steps, (effort.node_steps / (steps * nodes)).max(1))
}

/// Times all ways in turn.
pub fn measure(bench: &mut Bench, case: &Case) -> Result<()> {
    let mut buffers = Buffers::of(&case.scene)?;
    let (mut sim, image) = prepare(case, &mut buffers)?;
    let nodes = sim.layout().nodes() as u64;
    let (steps, bursts) = steps_and_bursts(nodes, bench.effort);
    // Single steps are another way only where there are blocks.
    let ways: Vec<Way> =
        bench.ways.iter().copied().filter(|way| !way.single_steps || sim.layout().block_steps > 1).collect();
    let mut times = vec![Vec::new(); ways.len()];
    let mut digests = vec![0; ways.len()];
    for _ in 0..bench.effort.rounds {
        for (k, way) in ways.iter().enumerate().filter(|(_, way)| way.instructions.available()) {
            let mut seconds = 0.0;
            for _ in 0..bursts {
                sim.load(&image)?;
                let (thread, wall) = (Clock::start(), Instant::now());
                advance(&mut sim, *way, steps)?;
                seconds += if way.threads == 1 { thread.seconds() } else { wall.elapsed().as_secs_f64() };
            }
            times[k].push(1e9 * seconds / (bursts * steps * nodes) as f64);
            digests[k] = sim.digest();
        }
    }
    for ((way, times), digest) in ways.iter().zip(&times).zip(digests) {
        let row = Row::of(&way.case(case.name), case.size(), way.instructions.name(), way.threads, times);
        bench.report.rows.push(if times.is_empty() { row } else { row.ending_in(digest) });
    }
    Ok(())
}
