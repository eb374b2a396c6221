//! `cargo xtask digests`: the same scenes (tests/digests/scenes.h) by the same library on every target,
//! compared in bits with tests/golden/pins.

use crate::platforms;
use crate::targets::{self, BOARD as BOARD_TRIPLE, HARD, Tool, WASM};
use crate::tools::{
    Context as _, Outcome, anyhow, asked, bail, ensure, finish, first_found, found, left_out, sh, shell, step_left_out,
    target,
};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};
use xshell::Cmd;

#[derive(clap::Args, Default)]
pub struct Options {
    /// Run only these (comma-separated names of the table); one that cannot run is then an error.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub targets: Vec<String>,
    /// Leave out those of --targets that cannot run here, and say why: for `cargo xtask test`.
    #[arg(skip)]
    pub only_available: bool,
}

struct Program {
    name: &'static str,
    library: Linked,
    options: &'static [&'static str],
    /// Files that make the program with digests.c, and libraries.
    sources: &'static [&'static str],
    runner: Runner,
}

/// The library that a target links.
#[derive(Clone, Copy, PartialEq)]
enum Linked {
    /// As it ships for this machine.
    Shipped,
    /// For this machine, with the function that chooses vector instructions.
    Choosing,
    /// As it ships, for a target of Rust with options of its own.
    Of(&'static str, &'static str),
}

/// What runs a target's program.
#[derive(Clone, Copy, PartialEq)]
enum Runner {
    /// This machine, an x86-64 with Linux.
    Machine,
    /// This machine if its processor has a feature, by the name that Linux gives it.
    MachineWith(&'static str),
    /// This machine where it can, else the target's runner.
    MachineOrOther,
    /// The target's runner.
    Other,
}

/// The host's own setting must not matter (crates/host/src/float.rs).
const ROUNDING_UP: &[&str] = &["-static", "-DROUNDING=FE_UPWARD"];
const HOSTED: &[&str] = &["-lm"];
const BOARD: &[&str] = &["examples/cortex-m7/board.c"];
#[rustfmt::skip]
const BOARD_OPTIONS: &[&str] = &[
    "-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-ffreestanding", "-nostdlib",
    "-Iexamples/cortex-m7", "-Texamples/cortex-m7/an500.ld", "-Wl,--gc-sections,--no-warn-execstack",
];
#[rustfmt::skip]
const FREESTANDING: &[&str] = &[
    "-ffreestanding", "-nostdlib", "-static", "-fno-builtin", "-fno-stack-protector", "-fno-tree-loop-distribute-patterns",
    "-Wl,--gc-sections",
];
#[rustfmt::skip]
const TARGETS: [Program; 12] = [
    Program { name: "x86-64-scalar", library: Linked::Choosing, options: &["-DINSTRUCTIONS=0"], sources: HOSTED, runner: Runner::Machine },
    Program { name: "x86-64-sse2", library: Linked::Choosing, options: &["-DINSTRUCTIONS=1"], sources: HOSTED, runner: Runner::Machine },
    Program { name: "x86-64-avx2", library: Linked::Choosing, options: &["-DINSTRUCTIONS=2"], sources: HOSTED, runner: Runner::MachineWith("avx2") },
    Program { name: "x86-64-avx512", library: Linked::Choosing, options: &["-DINSTRUCTIONS=3"], sources: HOSTED, runner: Runner::MachineWith("avx512f") },
    Program { name: "x86-64-freestanding", library: Linked::Shipped, options: FREESTANDING, sources: &[], runner: Runner::Machine },
    Program { name: "i686", library: Linked::Of("i686-unknown-linux-gnu", ""), options: ROUNDING_UP, sources: HOSTED, runner: Runner::MachineOrOther },
    Program { name: "aarch64", library: Linked::Of("aarch64-unknown-linux-gnu", ""), options: ROUNDING_UP, sources: HOSTED, runner: Runner::Other },
    Program { name: "riscv64", library: Linked::Of("riscv64gc-unknown-linux-gnu", ""), options: &["-static", "-no-pie"], sources: HOSTED, runner: Runner::Other },
    Program { name: "cortex-m7-soft", library: Linked::Of(BOARD_TRIPLE, ""), options: BOARD_OPTIONS, sources: BOARD, runner: Runner::Other },
    Program { name: "cortex-m7-hard", library: Linked::Of(BOARD_TRIPLE, HARD), options: BOARD_OPTIONS, sources: BOARD, runner: Runner::Other },
    Program { name: "wasm32", library: Linked::Of(WASM, ""), options: &["--target=wasm32", "-ffreestanding"], sources: &[], runner: Runner::Other },
    Program { name: "win64", library: Linked::Of(WINDOWS, ""), options: &[], sources: HOSTED, runner: Runner::Other },
];

/// The board of the Cortex-M7, with a console and nothing else.
#[rustfmt::skip]
const QEMU_BOARD: [&str; 14] = [
    "-M", "mps2-an500", "-cpu", "cortex-m7", "-nographic", "-monitor", "none", "-serial", "none",
    "-chardev", "stdio,id=out", "-semihosting-config", "enable=on,target=native,chardev=out", "-kernel",
];

const WINDOWS: &str = "x86_64-pc-windows-gnu";

impl Program {
    fn compiler(&self) -> Outcome<Tool> {
        match self.library {
            Linked::Of(triple, _) => Ok(targets::of(triple)?.compiler),
            Linked::Shipped | Linked::Choosing => Ok(Tool(&["gcc"], "gcc libc6-dev")),
        }
    }
}

/// `cargo xtask test`: some of the targets, those of them that can run here.
pub fn short() -> Outcome {
    let targets = WITH_EVERY_CHANGE.map(str::to_string).to_vec();
    run(&Options { targets, only_available: true })
}

/// Targets that run with every change: 32 bits, a machine without an operating system and one without a
/// processor. The tests of the kernel compare the instruction sets of x86-64.
const WITH_EVERY_CHANGE: [&str; 4] = ["x86-64-freestanding", "i686", "cortex-m7-hard", "wasm32"];

/// What became of a target.
enum Fate {
    /// Cannot run here; why, and what would help.
    Skipped(String),
    /// What it printed, what ran it, and for how long.
    Ran { lines: Vec<(String, String)>, by: String, seconds: f64 },
}

/// Builds, runs and compares; prints the table. Any difference is an error.
pub fn run(options: &Options) -> Outcome {
    let wanted =
        |target: &&Program| options.targets.is_empty() || options.targets.iter().any(|name| name == target.name);
    if let Some(unknown) = options.targets.iter().find(|name| TARGETS.iter().all(|target| target.name != *name)) {
        let names: Vec<_> = TARGETS.iter().map(|target| target.name).collect();
        bail!("there is no target {unknown}; there are {}", names.join(", "));
    }
    let pins = pins("scene")?;
    let targets: Vec<&Program> = TARGETS.iter().filter(wanted).collect();
    let libraries = build(&targets)?;
    let mut results = Vec::new();
    for target in targets {
        let result = match ready(target) {
            Ok(()) => tried(target, &libraries).context(target.name)?,
            Err(reason) => Fate::Skipped(reason.to_string()),
        };
        results.push((target.name, result));
    }
    report(&pins, &results)?;
    match libraries.iter().find(|built| built.0 == FIRMWARE) {
        Some((_, path)) if found(&["make"], "examples/cortex-m7") => firmware(path)?,
        Some(_) => {}
        None => left_out("examples/cortex-m7", "as cortex-m7-hard"),
    }
    let skipped = results.iter().find(|(_, result)| matches!(result, Fate::Skipped(_)));
    if let (Some((name, _)), false, false) = (skipped, options.targets.is_empty(), options.only_available) {
        bail!("{name} was asked for and cannot run here");
    }
    if skipped.is_some() && results.iter().all(|(_, fate)| matches!(fate, Fate::Skipped(_))) {
        return step_left_out("no target could run");
    }
    Ok(())
}

/// The library that the firmware of examples/cortex-m7 links.
const FIRMWARE: Linked = Linked::Of(BOARD_TRIPLE, HARD);

/// Builds and runs the firmware of examples/cortex-m7 by its makefile; its digest must be that of the same
/// file on this machine, also if it rounds and flushes otherwise. Prints the figures of docs/embedding.md.
fn firmware(library: &Path) -> Outcome {
    let folder = target().join("digests").join("programs");
    let make = |what: &[&str]| {
        let make = sh!("make --silent -f examples/cortex-m7/Makefile LIBRARY={library} BUILD={folder}");
        output_within(make.args(what), Duration::from_secs(900))
    };
    let rounding_up = "CC=arm-none-eabi-gcc tests/digests/rounding.c -Wl,--wrap=main";
    make(&["--always-make", rounding_up])?;
    let otherwise = make(&["run"])?;
    make(&["--always-make"])?;
    let board = make(&["run"])?;
    let (here, shipped) = (folder.join("firmware-here.exe"), build_one(Linked::Shipped)?);
    let sources = ["examples/cortex-m7/main.c", "tests/digests/board_hosted.c"];
    sh!("gcc -O2 -std=c11 -Iinclude -Iexamples/cortex-m7 {sources...} {shipped} -o {here}").run()?;
    let here = output_within(sh!("{here}"), Duration::from_secs(60))?;
    let sizes = sh!("arm-none-eabi-size {folder}/firmware.elf").read()?;
    let sizes: Vec<u64> =
        sizes.lines().nth(1).unwrap_or_default().split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [text, data, bss, ..] = sizes[..] else { bail!("arm-none-eabi-size printed no sizes") };
    let digest = |printed: &str| lines(printed).into_iter().find(|(name, _)| name == "digest");
    let equal = digest(&board).is_some() && digest(&board) == digest(&here);
    ensure!(equal, "examples/cortex-m7 prints\n{board}and on this machine\n{here}");
    let equal = digest(&otherwise) == digest(&board);
    ensure!(equal, "examples/cortex-m7 prints\n{board}and if it rounds upwards and flushes\n{otherwise}");
    let counted = board.lines().last().unwrap_or_default();
    let (flash, ram) = (text + data, data + bss);
    println!("examples/cortex-m7: digest as on this machine, flash {flash} bytes, RAM {ram} bytes, {counted}");
    Ok(())
}

/// Whether everything that a target needs is here; if not, what is missing and how to get it.
fn ready(target: &Program) -> Outcome {
    let machine = cfg!(all(target_arch = "x86_64", target_os = "linux"));
    let possible = machine || matches!(target.library, Linked::Of(..));
    ensure!(possible, "this machine is not an x86-64 with Linux");
    if let Runner::MachineWith(feature) = target.runner {
        ensure!(has(feature), "the processor of this machine has no {feature}");
    }
    target.compiler()?.found()?;
    let Linked::Of(triple, _) = target.library else { return Ok(()) };
    if target.runner == Runner::Other || !machine {
        targets::of(triple)?.runner.found()?;
    }
    if triple == WASM {
        let _ = wasm_linker()?;
    }
    platforms::compiler_for(triple).map(|_| ())
}

/// Whether this machine's processor has some instructions.
fn has(feature: &str) -> bool {
    let list = shell().read_file("/proc/cpuinfo").unwrap_or_default();
    let flags = list.lines().find(|line| line.starts_with("flags")).unwrap_or_default();
    flags.split_whitespace().any(|word| word == feature)
}

/// The linker for WebAssembly: LLVM's, or the one that rustup's compilers have.
fn wasm_linker() -> Outcome<Cmd<'static>> {
    if let Some(program) = first_found(&["wasm-ld"]) {
        return Ok(sh!("{program}"));
    }
    let of_rust = asked(sh!("rustc --print sysroot")).and_then(|sysroot| {
        let machines = shell().read_dir(Path::new(&sysroot).join("lib/rustlib")).ok()?;
        machines.into_iter().map(|machine| machine.join("bin/rust-lld")).find(|path| path.exists())
    });
    let linker = of_rust.context("wasm-ld is missing (Debian: lld; or the rustc of rustup, which has rust-lld)")?;
    Ok(sh!("{linker} -flavor wasm"))
}

/// A library and its file.
type Built = (Linked, PathBuf);

/// Builds the libraries of all targets that can run, two at a time. Each has a folder of its own, so the
/// builds do not wait for one another.
fn build(targets: &[&Program]) -> Outcome<Vec<Built>> {
    let mut wanted = Vec::new();
    for target in targets {
        if ready(target).is_ok() && !wanted.contains(&target.library) {
            wanted.push(target.library);
        }
    }
    let waiting = Mutex::new(wanted.into_iter());
    let next = || waiting.lock().ok()?.next();
    let worker = || -> Outcome<Vec<Built>> {
        std::iter::from_fn(next).map(|library| Ok((library, build_one(library)?))).collect()
    };
    std::thread::scope(|scope| {
        let other = scope.spawn(worker);
        let mut done = worker()?;
        done.extend(other.join().map_err(|_| anyhow!("a build broke off"))??);
        Ok(done)
    })
}

/// One library, in the profile that ships, and its file.
fn build_one(library: Linked) -> Outcome<PathBuf> {
    let folder = target().join("digests");
    match library {
        Linked::Shipped => Ok(crate::install::build()?.join("libfabric_kernel.a")),
        Linked::Choosing => {
            platforms::library(None, "", &["--features", "bare,choose-instructions"], &folder.join("choosing"))
        }
        Linked::Of(triple, flags) => {
            let kind = if flags.is_empty() { "" } else { "-with-options" };
            platforms::library(Some(triple), flags, &["--features", "bare"], &folder.join(format!("{triple}{kind}")))
        }
    }
}

fn tried(target: &Program, libraries: &[Built]) -> Outcome<Fate> {
    let (_, library) = libraries.iter().find(|built| built.0 == target.library).context("its library was not built")?;
    let program = link(target, library)?;
    let (printed, by, seconds) = execute(target, &program)?;
    Ok(Fate::Ran { lines: lines(&printed), by, seconds })
}

/// Compiles the C files and links them with the library.
fn link(target: &Program, library: &Path) -> Outcome<PathBuf> {
    let folder = shell().create_dir(self::target().join("digests").join("programs"))?;
    if matches!(target.library, Linked::Of(WASM, _)) {
        let program = folder.join("digests.wasm");
        link_module(target, library, &["print_digests".into()], &program)?;
        return Ok(program);
    }
    // Windows runs nothing without the ending; elsewhere it does not matter.
    let program = folder.join(format!("{}.exe", target.name));
    finish(compiled(target)?.args(target.sources).arg(library).arg("-o").arg(&program))?;
    Ok(program)
}

/// The compiler of digests.c for a target.
fn compiled(target: &Program) -> Outcome<Cmd<'static>> {
    let (compiler, options) = (target.compiler()?.found()?, target.options);
    let warnings = ["-Wall", "-Wextra", "-Werror"];
    let folders = ["-Iinclude", "-Itests/digests"];
    Ok(sh!("{compiler} -O2 -std=c11 {warnings...} {folders...} {options...} tests/digests/digests.c"))
}

/// A module for WebAssembly of digests.c and the library, with what it exports.
fn link_module(target: &Program, library: &Path, exports: &[String], program: &Path) -> Outcome {
    let object = program.with_extension("o");
    finish(compiled(target)?.arg("-c").arg("-o").arg(&object))?;
    let options = ["--no-entry", "--allow-undefined", "--gc-sections", "--strip-all"];
    let linker = wasm_linker()?.args(options).args(exports.iter().map(|name| format!("--export={name}")));
    finish(linker.arg(object).arg(library).arg("-o").arg(program)).map(|_| ())
}

/// The kernel for browsers, with vectors of two numbers, and the scenes of digests.c in it; an error says
/// which tool is missing.
pub fn module(program: &Path) -> Outcome {
    let target = wasm()?;
    ready(target)?;
    let library = build_one(Linked::Of(WASM, "-Ctarget-feature=+simd128"))?;
    let mut exports: Vec<String> = shell().read_file("tests/c/abi/symbols.txt")?.lines().map(str::to_string).collect();
    exports.extend(["print_digests".into(), "__heap_base".into()]);
    link_module(target, &library, &exports, program)
}

/// Whether [`module`] can be made here; if not, what is missing.
pub fn module_ready() -> Outcome {
    ready(wasm()?)
}

fn wasm() -> Outcome<&'static Program> {
    TARGETS.iter().find(|target| target.name == "wasm32").context("there is no target wasm32")
}

/// Runs a program: what it printed, what ran it, and for how long.
fn execute(target: &Program, program: &Path) -> Outcome<(String, String, f64)> {
    let other = match (target.runner, target.library) {
        // A kernel may be built without 32 bits.
        (Runner::MachineOrOther, _) if asked(sh!("{program}")).is_some() => None,
        (Runner::MachineOrOther | Runner::Other, Linked::Of(triple, _)) => Some(targets::of(triple)?),
        _ => None,
    };
    let by = other.map_or(Ok("this machine"), |target| target.runner.found())?;
    let command = other.map_or_else(|| sh!("{program}"), |target| on_runner(target.triple, by, program));
    let start = Instant::now();
    let printed = output_within(command, Duration::from_secs(900))?;
    Ok((printed, by.into(), start.elapsed().as_secs_f64()))
}

/// A program that another runs.
fn on_runner(triple: &str, runner: &str, program: &Path) -> Cmd<'static> {
    let command = sh!("{runner}");
    let command = match triple {
        BOARD_TRIPLE => command.args(QEMU_BOARD),
        WASM => command.arg("tests/digests/wasm.mjs"),
        WINDOWS => command.env("WINEDEBUG", "-all").env("WINEPREFIX", target().join("wine")),
        _ => command,
    };
    command.arg(program)
}

/// What a program prints; it is stopped if it takes too long. It must print less than a pipe holds.
fn output_within(command: Cmd, longest: Duration) -> Outcome<String> {
    let said = format!("`{command}`");
    let mut started = Command::from(command.ignore_stderr());
    let mut child = started.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().with_context(|| said.clone())?;
    let start = Instant::now();
    while child.try_wait()?.is_none() {
        if start.elapsed() > longest {
            child.kill()?;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = child.wait_with_output()?;
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    ensure!(output.status.success(), "{said} failed ({}): {printed}", output.status);
    Ok(printed)
}

/// Names and values of one kind in tests/golden/pins.
pub(crate) fn pins(kind: &str) -> Outcome<Vec<(String, String)>> {
    let pins = lines(&shell().read_file("tests/golden/pins")?);
    Ok(pins.iter().filter(|(of, _)| of == kind).flat_map(|(_, pin)| lines(pin)).collect())
}

/// Names and values of the lines of a text.
pub(crate) fn lines(text: &str) -> Vec<(String, String)> {
    let pair = |line: &str| line.split_once(' ').map(|(name, value)| (name.to_string(), value.trim().to_string()));
    text.lines().filter_map(pair).collect()
}

/// Prints the table; an error if any digest differs.
fn report(pins: &[(String, String)], results: &[(&str, Fate)]) -> Outcome {
    let heads: Vec<_> = pins.iter().map(|(name, _)| format!(" {name:>10}")).collect();
    println!("{:20}{}", "target", heads.concat());
    let (mut ran, mut different) = (0, Vec::new());
    for (name, fate) in results {
        match fate {
            Fate::Skipped(reason) => left_out(&format!("digests on {name}"), reason),
            Fate::Ran { lines, by, seconds } => {
                ran += 1;
                let cells: Vec<_> = pins
                    .iter()
                    .map(|pin| format!(" {:>10}", if lines.contains(pin) { "equal" } else { "DIFFERENT" }))
                    .collect();
                println!("{name:20}{}  {by}, {seconds:.1} s", cells.concat());
                if lines != pins {
                    let printed: Vec<_> = lines.iter().map(|(name, digest)| format!("  {name} {digest}\n")).collect();
                    different.push(format!("{name} prints\n{}", printed.concat()));
                }
            }
        }
    }
    let skipped = results.len() - ran;
    println!(
        "{ran} targets ran {} scenes each, {} of them with equal digests; {skipped} skipped",
        pins.len(),
        ran - different.len()
    );
    ensure!(different.is_empty(), "digests are not those of tests/golden/pins\n{}", different.concat());
    Ok(())
}
