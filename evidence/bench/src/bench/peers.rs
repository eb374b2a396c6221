//! Other programs on the same grid with the same sphere, in rounds with the kernel: time over the kernel's,
//! round by round.
//!
//! Every peer is a process that takes the first steps, says what it has reached, and waits for rounds; see
//! evidence/bench/peers. It reports its own CPU time. A peer that cannot be built, installed or run is named
//! among what is missing.

use super::Bench;
use super::programs::{folder, output, python, top};
use super::rows::Row;
use super::sheets::{self, Case, Way};
use crate::Result;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::report::median;
use fabric_kernel::{InstructionSet, Scene};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// A program to compare with.
pub struct Peer {
    /// Name in tables.
    pub name: &'static str,
    /// How it differs from the kernel.
    pub differs: &'static str,
    /// Largest sheet it is given: some need kilobytes a node.
    largest: u32,
    command: fn() -> Result<Command>,
    last_argument: &'static str,
}

/// All peers.
pub const PEERS: [Peer; 4] = [
    Peer {
        name: "plain C",
        differs: "the same law, damage, samples and contact (one Gauss-Seidel sweep); no root and no division per segment; no supports, no outcomes, no ledger",
        largest: 2000,
        command: plain_c,
        last_argument: "careful",
    },
    Peer {
        name: "plain C, textbook",
        differs: "as above, but each segment takes the root and the divisions of the textbook formula",
        largest: 2000,
        command: plain_c,
        last_argument: "textbook",
    },
    Peer {
        name: "NVIDIA Warp",
        differs: "own kernels on its CPU device, the same law, damage, samples and contact; no supports, no outcomes, no ledger",
        largest: 1000,
        command: || python_peer("warp_net.py"),
        last_argument: "",
    },
    Peer {
        name: "LAMMPS",
        differs: "harmonic bonds: linear, also in compression; no damage, one modulus for all; penalty contact with a sphere of constant speed",
        largest: 350,
        command: || python_peer("lammps_net.py"),
        last_argument: "",
    },
];

fn plain_c() -> Result<Command> {
    let program = folder("peers")?.join("plain");
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "-O3", "-march=native", "-ffp-contract=off", "-o"]).arg(&program);
    output(compiler.arg(top().join("evidence/bench/peers/plain.c")).arg("-lm"))?;
    Ok(Command::new(program))
}

fn python_peer(script: &str) -> Result<Command> {
    let mut command = Command::new(python()?);
    command.arg(top().join("evidence/bench/peers").join(script));
    // LAMMPS finds its MPI library there; Warp keeps its compiled kernels here; one thread for all.
    command
        .env("LD_LIBRARY_PATH", folder("peers")?.join("venv/lib"))
        .env("WARP_CACHE_PATH", folder("peers")?.join("warp"));
    command.env("OMP_NUM_THREADS", "1").env("PYTHONDONTWRITEBYTECODE", "1");
    Ok(command)
}

/// A peer that is ready for rounds.
struct Running {
    peer: &'static Peer,
    child: Child,
    input: ChildStdin,
    lines: BufReader<ChildStdout>,
    deflection: f64,
    times: Vec<f64>,
}

impl Running {
    /// Starts a peer and waits until its first steps are done.
    fn start(peer: &'static Peer, case: &Case, dt: f64, segments: &Path) -> Result<Running> {
        let mut command = (peer.command)()?;
        command.args([case.size().to_string(), case.before.to_string()]).arg(segments);
        command.args(numbers(&case.scene, dt).map(|number| format!("{number:e}")));
        if !peer.last_argument.is_empty() {
            command.arg(peer.last_argument);
        }
        let log = folder("peers")?.join(format!("{}.log", peer.name.replace([' ', ','], "_")));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(std::fs::File::create(&log)?);
        let mut child = command.spawn().map_err(|error| format!("cannot start: {error}"))?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("no pipes".into());
        };
        let mut running =
            Running { peer, child, input, lines: BufReader::new(output), deflection: 0.0, times: Vec::new() };
        loop {
            let line = running.line().map_err(|error| {
                let said = std::fs::read_to_string(&log).unwrap_or_default();
                format!("{error}: {}", said.lines().last().unwrap_or(""))
            })?;
            // A library may greet first.
            if let Some(rest) = line.strip_prefix("ready ") {
                running.deflection = rest.split(' ').next().unwrap_or("").parse()?;
                return Ok(running);
            }
        }
    }

    fn line(&mut self) -> Result<String> {
        let mut line = String::new();
        if self.lines.read_line(&mut line)? == 0 {
            return Err("ended early".into());
        }
        Ok(line.trim().to_string())
    }

    /// Takes steps; CPU seconds.
    fn round(&mut self, steps: u64) -> Result<f64> {
        writeln!(self.input, "{steps}")?;
        self.input.flush()?;
        Ok(self.line()?.parse()?)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It would end by itself when its input does; nobody needs to wait for that.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a peer is told, SI units: see plain.c.
fn numbers(scene: &Scene, dt: f64) -> [f64; 11] {
    let (sheet, yarn, body) = (&scene.sheet, &scene.yarn, &scene.projectile);
    [
        sheet.spacing,
        sheet.node_mass,
        sheet.yarn_area,
        dt,
        body.radius,
        body.mass,
        body.velocity[2],
        yarn.critical_stretch,
        yarn.damage_a,
        yarn.damage_b,
        yarn.alpha_fail,
    ]
}

/// Modulus and damage rate of every segment, as doubles.
fn write_segments(scene: &Scene, path: &Path) -> Result<()> {
    let mut bytes = Vec::new();
    for number in 0..scene.segments() {
        let segment = scene.draw_segment(number)?;
        bytes.extend(segment.modulus.to_le_bytes());
        bytes.extend(segment.damage_rate.to_le_bytes());
    }
    Ok(std::fs::write(path, bytes)?)
}

/// One size, all peers.
pub fn measure(bench: &mut Bench, size: u32) -> Result<()> {
    let Bench { effort, few_peers, report, .. } = bench;
    let case = sheets::whole_run(size);
    let mut buffers = Buffers::of(&case.scene)?;
    let (mut sim, image) = sheets::prepare(&case, &mut buffers)?;
    let deflection = sim.fabric()?.max_deflection;
    let segments = folder("peers")?.join(format!("segments-{size}.bin"));
    write_segments(&case.scene, &segments)?;

    let mut running = Vec::new();
    for peer in PEERS.iter().filter(|peer| size <= peer.largest && (!*few_peers || peer.name.starts_with("plain C"))) {
        match Running::start(peer, &case, sim.step_limits().dt, &segments) {
            Ok(peer) => running.push(peer),
            Err(error) => report.missing.push(format!("{} at {size} x {size}: {error}", peer.name)),
        }
    }
    let nodes = sim.layout().nodes() as u64;
    let steps = (effort.node_steps / 4 / nodes).clamp(10, 400);
    let node_steps = (steps * nodes) as f64;
    let way = Way { instructions: InstructionSet::widest(), threads: 1, single_steps: false };
    let mut ours = Vec::new();
    for _ in 0..effort.rounds {
        // Before and after the peers, so that a drift of the machine meets both.
        let mut time = || -> Result<f64> {
            sim.load(&image)?;
            let clock = Clock::start();
            sheets::advance(&mut sim, way, steps)?;
            Ok(1e9 * clock.seconds() / node_steps)
        };
        let before = time()?;
        for peer in &mut running {
            let seconds = peer.round(steps).map_err(|error| format!("{}: {error}", peer.peer.name))?;
            peer.times.push(1e9 * seconds / node_steps);
        }
        ours.push(0.5 * (before + time()?));
    }
    let kernel = Row::of("peers: the kernel", size, way.instructions.name(), 1, &ours).ending_in(sim.digest());
    report.rows.push(Row { deflection: Some(deflection), ..kernel });
    for Running { peer, times, deflection, .. } in &running {
        let ratios: Vec<f64> = times.iter().zip(&ours).map(|(theirs, ours)| theirs / ours).collect();
        report.rows.push(Row {
            deflection: Some(*deflection),
            differs: Some(peer.differs),
            times_slower: Some(median(&ratios)),
            ..Row::of(&format!("peers: {}", peer.name), size, "compiled", 1, times)
        });
    }
    Ok(())
}
