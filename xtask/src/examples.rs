//! The C and C++ examples, built outside the project as a user would, and what the C++ header costs over C.

use crate::chosts::{library, prefix};
use crate::digests::pins;
use crate::tools::{Context as _, Outcome, cargo_tool, cmake, emptied, ensure, found, needs, sh, shell, target};
use std::path::Path;

/// Copies the examples elsewhere, builds them with CMake against the installed library, with the shared and
/// the static one, and compares the last line that each prints with tests/golden/pins.
pub fn run() -> Outcome {
    needs(&["cmake", "g++"])?;
    crate::chosts::installed()?;
    let folder = emptied(target().join("examples"))?;
    sh!("cp -r examples/CMakeLists.txt examples/c examples/cpp {folder}").run()?;
    let build = folder.join("build");
    let said = cmake(&folder, &build, &prefix())?;
    ensure!(!said.contains("warning"), "the examples do not build cleanly:\n{said}");
    for (name, wanted) in pins("example")? {
        for program in [name.clone(), format!("{name}_static")] {
            // One run of the long example is enough.
            if program == "monte_carlo_static" {
                continue;
            }
            let printed = sh!("{build}/{program}").read()?;
            let last = printed.lines().last().unwrap_or_default();
            ensure!(last == wanted, "{program} ends with \"{last}\" instead of \"{wanted}\" (tests/golden/pins)");
        }
        println!("  {name}: {wanted}");
    }
    capsule(&build)?;
    threads(&build)?;
    cost()
}

/// The example with a capsule: what one program writes another one replays.
fn capsule(build: &Path) -> Outcome {
    let file = build.join("run.capsule");
    let written = sh!("{build}/capsule {file}").read()?;
    let replayed = sh!("{build}/capsule_static {file} replay").read()?;
    println!("  capsule: {written}");
    let equal = written.starts_with("same bits") && replayed == written;
    ensure!(equal, "a capsule is replayed as {replayed} instead of {written}");
    Ok(())
}

/// The example with threads: for any number of them the pinned digest of the same scene.
fn threads(build: &Path) -> Outcome {
    let (_, wanted) = pins("host")?.pop().unwrap_or_default();
    for threads in ["1", "2", "3", "5"] {
        let printed = sh!("{build}/threads {threads}").read()?;
        ensure!(printed == wanted, "threads {threads} prints {printed} instead of {wanted}");
    }
    println!("  threads, 1, 2, 3 and 5 of them: {wanted}");
    Ok(())
}

/// Calls of the library in tests/cpp/cost.c.
const CALLS: u64 = 2000;

/// Cost of one loop in C and in C++ under callgrind: at most two instructions a call more.
fn cost() -> Outcome {
    if !found(&["valgrind"], "instructions of the C++ header") {
        return Ok(());
    }
    let folder = emptied(target().join("hosts/cost"))?;
    let count = |compiler: &str, standard: &str, source: &str| -> Outcome<u64> {
        let (program, library) = (folder.join(compiler), library());
        let counts = program.with_extension("counts");
        sh!("{compiler} {standard} -O2 -DNDEBUG -Iinclude {source} {library} -o {program}").run()?;
        let mut least = u64::MAX;
        // Where the stack begins depends on the length of arguments and environment, and on it what copies
        // cost: 32 bytes apart or not.
        for shift in ["x", "xxxxxxxxxxxxxxxxx"] {
            let options = ["--quiet", "--tool=callgrind", "--toggle-collect=measured"];
            sh!("valgrind {options...} --callgrind-out-file={counts} {program} {shift}").ignore_stdout().run()?;
            let counts = shell().read_file(&counts)?;
            let total = counts.lines().find_map(|line| line.strip_prefix("totals: "));
            least = least.min(total.context("callgrind prints no totals")?.trim().parse()?);
        }
        Ok(least)
    };
    let c = count("gcc", "-std=c11", "tests/cpp/cost.c")?;
    let cpp = count("g++", "-std=c++17", "tests/cpp/cost.cpp")?;
    println!("  instructions of {CALLS} calls: C {c}, C++ {cpp}");
    let allowed = c + 2 * CALLS;
    ensure!(c > 0 && cpp <= allowed, "the C++ header costs more than {allowed}");
    Ok(())
}

/// `cargo deny`: licences, sources and bans of every dependency.
pub fn deny() -> Outcome {
    Ok(cargo_tool("cargo-deny")?.args(["--offline", "check", "bans", "licenses", "sources"]).run()?)
}
