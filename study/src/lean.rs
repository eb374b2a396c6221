//! A scene pays only for what it uses: bytes per node, time per node-step and machine code, each with and without.
//!
//! Memory comes from the layout. Times are the least of several rounds that alternate between the two forms, and start from the
//! same image every time. Machine code is the `.text` section of small libraries (study/probe) and of the C library, built by
//! cargo as they ship but with their symbols; a feature that is left out must make it smaller and take its symbols along.
//! Where both forms compute the same motion their positions must be the same bits.

use crate::machine::{self, Clock};
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, bench, report};
use clap::Args;
use fabric::{AttachmentKind, Drive, Error, Integrator, Layout, Scene, Shape, Sim, Symmetry, ThetaRule, TimeStep};
use object::{Object, ObjectSection, ObjectSymbol};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Options of `lean`.
#[derive(Args)]
pub struct Options {
    /// Fewer rounds and only the machine code that a check needs.
    #[arg(long)]
    quick: bool,
    /// The same as --quick, with one round: does it work?
    #[arg(long)]
    smoke: bool,
    /// Measure no machine code: no builds.
    #[arg(long)]
    no_code: bool,
    /// Only the machine code.
    #[arg(long, conflicts_with = "no_code")]
    only_code: bool,
    /// Folder for lean.json.
    #[arg(long, value_name = "DIR", default_value = "target/study/lean")]
    out: PathBuf,
}

/// One form of a scene.
struct Form {
    scene: Scene,
    /// What is done before the first step.
    start: fn(&mut Sim<'_>) -> Result<()>,
    /// Steps before the measured ones.
    before: u64,
    /// Steps measured.
    steps: u64,
    /// What is done after each step.
    each: fn(&mut Sim<'_>) -> Result<()>,
}

/// A scene with and without something.
struct Pair {
    what: &'static str,
    without: Form,
    with: Form,
    /// Whether both compute the same motion, so that positions must agree to the bit.
    same_motion: bool,
}

/// What was measured of a form.
#[derive(Clone, Serialize)]
struct Measured {
    /// At the size measured, and at 350 x 350 nodes.
    bytes_per_node: f64,
    bytes_per_node_large: f64,
    ns_per_node_step: f64,
}

/// One row of lean.json. Nodes are those of the whole sheet, also of one that is mirrored.
#[derive(Serialize)]
struct Row {
    what: &'static str,
    without: Measured,
    with: Measured,
    /// None where the two compute different motions.
    same_bits: Option<bool>,
}

/// A library's machine code.
#[derive(Serialize)]
struct Code {
    library: String,
    text_bytes: u64,
    /// Symbols of the theta rule. (The fibrils' functions are all taken up by their one caller.)
    theta_symbols: usize,
}

/// Everything in the JSON file.
#[derive(Serialize)]
struct Report {
    machine: String,
    clock: &'static str,
    rows: Vec<Row>,
    code: Vec<Code>,
}

/// Measures, prints and writes. False if bits differ that must agree, or a feature that is left out leaves code behind.
pub fn run(options: &Options) -> Result<bool> {
    std::fs::create_dir_all(&options.out)?;
    let rounds = match (options.smoke, options.quick) {
        (true, _) => 1,
        (_, true) => 5,
        _ => 15,
    };
    let rows = if options.only_code { Vec::new() } else { rows(rounds)? };
    let code = if options.no_code { Vec::new() } else { code(options.smoke || options.quick)? };
    let report = Report { machine: machine::processor(), clock: machine::CLOCK_NAME, rows, code };
    std::fs::write(options.out.join("lean.json"), serde_json::to_string_pretty(&report)? + "\n")?;
    Ok(print(&report))
}

fn nothing(_: &mut Sim<'_>) -> Result<()> {
    Ok(())
}

/// A flat sheet thrown along z.
fn thrown(sim: &mut Sim<'_>) -> Result<()> {
    bench::throw(sim, 20.0)
}

/// Asks for all energies.
fn energies(sim: &mut Sim<'_>) -> Result<()> {
    sim.energy()?;
    Ok(())
}

/// Stretches the sheet evenly, both ways: in balance, so that it stays.
fn stretched(sim: &mut Sim<'_>, stretch: f64) -> Result<()> {
    let mut positions = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut positions)?;
    positions.iter_mut().for_each(|x| *x *= stretch);
    let velocities = vec![0.0; positions.len()];
    sim.set_motion(&positions, &velocities)?;
    Ok(())
}

/// The sheet alone: 105 x 105 nodes, uniform yarn, four sides held, nothing tracked, the sphere far away.
fn sheet() -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    scene.yarn.stochastic = false;
    scene.attachment.kind = AttachmentKind::FourSides;
    scene.projectile.position[2] = -1.0;
    scene.projectile.velocity = [0.0; 3];
    (scene.track_support, scene.track_detachment) = (false, false);
    scene
}

/// The sheet with the sphere in it: at 300 m/s, taken up after 1000 steps.
fn hit() -> Scene {
    let mut scene = sheet();
    let start = Scene::sheet_3in_sphere().projectile;
    scene.projectile = fabric::Projectile { velocity: [0.0, 0.0, 300.0], ..start };
    scene
}

/// A projectile in flight past a sheet of 9 nodes: the body alone.
fn flight(shape: Shape) -> Scene {
    let mut scene = sheet();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (3, 3);
    scene.projectile.shape = shape;
    scene.projectile.velocity = [1.0, 2.0, -30.0];
    scene
}

/// The rows of "what a scene leaves out".
fn pairs() -> Vec<Pair> {
    let moving = |scene: Scene| Form { scene, start: thrown, before: 100, steps: 400, each: nothing };
    let struck = |scene: Scene| Form { scene, start: nothing, before: 1000, steps: 400, each: nothing };
    let flying = |scene: Scene| Form { scene, start: nothing, before: 10, steps: 20_000, each: nothing };
    let taut = |start| Form { scene: sheet(), start, before: 10, steps: 200, each: nothing };
    let pair = |what, without, with, same_motion| Pair { what, without, with, same_motion };
    let (smooth, impact) = (sheet(), hit());
    // Drawn segments that all come out as the mean: the same motion at the price of stochastic yarn.
    let mut drawn = smooth;
    drawn.yarn.stochastic = true;
    (drawn.yarn.modulus_sd, drawn.yarn.damage_sd) = (0.0, 0.0);
    let quarter = Scene { symmetry: Symmetry { mirror_x: true, mirror_y: true }, ..smooth };
    let theta = Scene { integrator: Integrator::Theta(ThetaRule::default()), ..smooth };
    let early =
        |each_row: fn(&mut Sim<'_>) -> Result<()>| Form { start: each_row, before: 1, steps: 50, ..struck(impact) };
    let every_row: fn(&mut Sim<'_>) -> Result<()> = |sim| {
        sim.step_every_row();
        Ok(())
    };
    let prescribed = Scene { drive: Drive::Prescribed, ..flight(Shape::Sphere) };
    vec![
        pair(
            "turning projectile (a cylinder in flight; time per step)",
            flying(flight(Shape::Sphere)),
            flying(flight(Shape::Cylinder)),
            true,
        ),
        pair("stochastic yarn", moving(smooth), moving(drawn), true),
        pair(
            "segments beyond U_c (a sheet taut at 1.029, at 1.031)",
            taut(|sim| stretched(sim, 1.029)),
            taut(|sim| stretched(sim, 1.031)),
            false,
        ),
        pair("rows that the wave has not reached (first 50 steps)", early(nothing), early(every_row), true),
        pair("the mirrored three quarters", moving(quarter), moving(smooth), true),
        pair("toe of slack yarn", struck(impact), struck(Scene { slack_toe: 0.02, ..impact }), false),
        pair("theta rule", moving(smooth), moving(theta), false),
        pair(
            "integration of the body (in flight; time per step)",
            flying(prescribed),
            flying(flight(Shape::Sphere)),
            true,
        ),
        pair("energies after every step", struck(impact), Form { each: energies, ..struck(impact) }, true),
        pair("support impulses", struck(impact), struck(Scene { track_support: true, ..impact }), true),
        pair("detachment watched", struck(impact), struck(Scene { track_detachment: true, ..impact }), true),
        pair(
            "everything: smallest and fullest scene",
            struck(impact),
            Form { each: energies, ..struck(fullest()) },
            false,
        ),
    ]
}

/// Stochastic yarn, a turning projectile, everything watched.
fn fullest() -> Scene {
    let mut scene = hit();
    let radius = scene.projectile.radius;
    scene.yarn.stochastic = true;
    (scene.track_support, scene.track_detachment) = (true, true);
    // A cylinder a little shorter than the sphere, of its mass.
    (scene.projectile.shape, scene.projectile.length) = (Shape::Cylinder, 1.5 * radius);
    scene.projectile.position[2] = -0.75 * radius;
    scene
}

fn rows(rounds: usize) -> Result<Vec<Row>> {
    let pairs = pairs();
    let progress = Progress::new("lean", (pairs.len() * rounds) as u64);
    let mut rows = Vec::new();
    for pair in &pairs {
        rows.push(measure(pair, rounds, &progress)?);
    }
    progress.finish();
    Ok(rows)
}

/// Both forms, in turn.
fn measure(pair: &Pair, rounds: usize, progress: &Progress) -> Result<Row> {
    // The same step for both: the drawn sheet's may differ by rounding.
    let dt = pair.without.scene.step_limits()?.dt.min(pair.with.scene.step_limits()?.dt);
    let scenes = [&pair.without, &pair.with].map(|form| Scene { time_step: TimeStep::Seconds(dt), ..form.scene });
    let [mut first, mut second] = [Buffers::of(&scenes[0])?, Buffers::of(&scenes[1])?];
    let mut sims = [first.sim(&scenes[0])?, second.sim(&scenes[1])?];
    let mut images = Vec::new();
    for (sim, form) in sims.iter_mut().zip([&pair.without, &pair.with]) {
        (form.start)(sim)?;
        sim.advance(form.before)?;
        let mut image = vec![0; sim.snapshot_bytes()];
        sim.save(&mut image)?;
        images.push(image);
    }
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..rounds {
        for (k, form) in [&pair.without, &pair.with].into_iter().enumerate() {
            sims[k].load(&images[k])?;
            let clock = Clock::start();
            // One call a step in both forms.
            for _ in 0..form.steps {
                sims[k].step()?;
                (form.each)(&mut sims[k])?;
            }
            let sheet = &form.scene.sheet;
            let in_flight = sheet.nodes_x == 3;
            let nodes = if in_flight { 1.0 } else { f64::from(sheet.nodes_x) * f64::from(sheet.nodes_y) };
            times[k].push(1e9 * clock.seconds() / (form.steps as f64 * nodes));
        }
        progress.add(1, || pair.what.to_string());
    }
    let measured = |k: usize| -> std::result::Result<Measured, Error> {
        let layout = Layout::of(&scenes[k])?;
        let nodes = f64::from(scenes[k].sheet.nodes_x) * f64::from(scenes[k].sheet.nodes_y);
        let mut large = scenes[k];
        (large.sheet.nodes_x, large.sheet.nodes_y) = (350, 350);
        Ok(Measured {
            bytes_per_node: layout.bytes() as f64 / nodes,
            bytes_per_node_large: Layout::of(&large)?.bytes() as f64 / (350.0 * 350.0),
            ns_per_node_step: report::least(&times[k]),
        })
    };
    Ok(Row {
        what: pair.what,
        without: measured(0)?,
        with: measured(1)?,
        same_bits: if pair.same_motion { Some(same_positions(&sims[0], &sims[1])?) } else { None },
    })
}

/// Whether the nodes that both model, and the projectile, are at the same place to the bit.
fn same_positions(a: &Sim<'_>, b: &Sim<'_>) -> Result<bool> {
    let positions = |sim: &Sim<'_>| -> Result<Vec<f64>> {
        let mut x = vec![0.0; 3 * sim.layout().nodes()];
        sim.copy_positions(&mut x)?;
        Ok(x)
    };
    let (x, y) = (positions(a)?, positions(b)?);
    let (columns, others) = (a.layout().nodes_x, b.layout().nodes_x);
    let (common, rows) = (columns.min(others), a.layout().nodes_y.min(b.layout().nodes_y));
    let row = |x: &[f64], columns: usize, j: usize| -> Vec<u64> {
        x[3 * j * columns..3 * (j * columns + common)].iter().map(|x| x.to_bits()).collect()
    };
    let sheets = (0..rows).all(|j| row(&x, columns, j) == row(&y, others, j));
    let place = |sim: &Sim<'_>| -> Result<[u64; 3]> { Ok(sim.projectile()?.position.map(f64::to_bits)) };
    Ok(sheets && place(a)? == place(b)?)
}

/// The C library with and without the theta rule, and the probes: the smallest, with one thing more each, with everything.
fn code(few: bool) -> Result<Vec<Code>> {
    let capi = |features: &[&'static str]| ("capi-lib", "libfabric_kernel", [&["bare"], features].concat());
    let probe = |features: &[&'static str]| ("fabric-probe", "libfabric_probe", [&["bare"], features].concat());
    let mut libraries = vec![
        ("C library without implicit", capi(&[])),
        ("C library", capi(&["implicit"])),
        ("smallest: sphere, uniform yarn, explicit", probe(&[])),
        ("smallest + micro", probe(&["micro"])),
    ];
    if !few {
        libraries.push(("smallest + energies", probe(&["energies"])));
        libraries.push(("smallest + snapshots", probe(&["snapshots"])));
        libraries.push(("smallest + path of a host", probe(&["host"])));
        libraries.push(("smallest + implicit", probe(&["implicit"])));
        let all = ["energies", "snapshots", "host", "implicit", "micro"];
        libraries.push(("fullest: all of these", probe(&all)));
    }
    let progress = Progress::new("machine code", libraries.len() as u64);
    let mut found = Vec::new();
    for (name, (package, file, features)) in libraries {
        progress.add(0, || format!("building {name}"));
        let path = build(package, file, &features)?;
        found.push(read(name, &path)?);
        progress.add(1, || name.to_string());
    }
    progress.finish();
    Ok(found)
}

/// Builds a shared library as it ships, with its symbols, in a folder of its own; returns its path.
fn build(package: &str, file: &str, features: &[&str]) -> Result<PathBuf> {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| top.join("target"), PathBuf::from).join("lean");
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["rustc", "--quiet", "--profile", "ship", "--package", package, "--lib", "--crate-type", "cdylib"])
        .args(["--no-default-features", "--features", &features.join(","), "--target-dir"])
        .arg(&target)
        .env("CARGO_PROFILE_SHIP_STRIP", "none")
        .current_dir(top)
        .output()?;
    if !output.status.success() {
        return Err(format!("building {package}: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let extension = std::env::consts::DLL_EXTENSION;
    Ok(target.join("ship").join(format!("{file}.{extension}")))
}

fn read(name: &str, path: &Path) -> Result<Code> {
    let data = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let file = object::File::parse(&*data)?;
    let text = file.sections().filter(|section| section.kind() == object::SectionKind::Text);
    // Mangled names hold the path of modules, each with its length before it.
    let of_theta = |name: &str| name.contains("6fabric5theta");
    Ok(Code {
        library: name.to_string(),
        text_bytes: text.map(|section| section.size()).sum(),
        theta_symbols: file.symbols().filter(|symbol| symbol.name().is_ok_and(of_theta)).count(),
    })
}

/// Prints; whether everything is as it must be.
fn print(report: &Report) -> bool {
    let mut sound = true;
    println!("machine: {}; times are {}, the least of several", report.machine, report.clock);
    if !report.rows.is_empty() {
        let mut table = report::table(&[
            "what a scene leaves out",
            "bytes/node without (at 350 x 350)",
            "with",
            "ns/node-step without",
            "with",
            "same bits",
        ]);
        for row in &report.rows {
            sound &= row.same_bits != Some(false);
            table.add_row(vec![
                row.what.to_string(),
                format!("{:.1} ({:.1})", row.without.bytes_per_node, row.without.bytes_per_node_large),
                format!("{:.1} ({:.1})", row.with.bytes_per_node, row.with.bytes_per_node_large),
                format!("{:.2}", row.without.ns_per_node_step),
                format!("{:.2}", row.with.ns_per_node_step),
                row.same_bits.map_or("other motion", |same| if same { "yes" } else { "NO" }).to_string(),
            ]);
        }
        println!("{table}");
    }
    if !report.code.is_empty() {
        let mut table = report::table(&["library", "machine code, bytes", "theta symbols"]);
        for code in &report.code {
            let numbers = [code.text_bytes, code.theta_symbols as u64];
            let mut row = vec![code.library.clone()];
            row.extend(numbers.map(|number| number.to_string()));
            table.add_row(row);
        }
        println!("{table}");
        let mistakes = mistakes(&report.code);
        mistakes.iter().for_each(|mistake| println!("NOT as it must be: {mistake}"));
        sound &= mistakes.is_empty();
    }
    sound
}

/// What leaving a feature out did not do.
fn mistakes(code: &[Code]) -> Vec<String> {
    let of = |name: &str| code.iter().find(|code| code.library == name);
    let mut mistakes = Vec::new();
    for (without, with, theta) in [
        ("C library without implicit", "C library", true),
        ("smallest: sphere, uniform yarn, explicit", "smallest + micro", false),
        ("smallest: sphere, uniform yarn, explicit", "smallest + implicit", true),
    ] {
        let (Some(small), Some(large)) = (of(without), of(with)) else { continue };
        if small.text_bytes >= large.text_bytes {
            mistakes.push(format!("{without} is not smaller than {with}"));
        }
        if theta && small.theta_symbols != 0 {
            mistakes.push(format!("{without} holds symbols of the theta rule"));
        }
        if theta && large.theta_symbols == 0 {
            mistakes.push(format!("{with} holds no symbol of the theta rule: the search looks for the wrong names"));
        }
    }
    mistakes
}
