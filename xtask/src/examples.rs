//! The C and C++ examples, built outside the project as a user would, and what the C++ header costs over C.

use crate::chosts::prefix;
use crate::digests::pins;
use crate::tools::{Outcome, cargo_tool, cmake, emptied, found, needs, output, read, run as command, target, wait};
use std::path::Path;

/// Copies the examples elsewhere, builds them with CMake against the installed library, with the shared and
/// the static one, and compares the last line that each prints with tests/golden/pins.
pub fn run() -> Outcome {
    needs(&["cmake", "g++"])?;
    crate::chosts::installed()?;
    let folder = emptied(target().join("examples"))?;
    for source in ["CMakeLists.txt", "c", "cpp"] {
        command("cp", &["-r", &format!("examples/{source}"), &folder.to_string_lossy()])?;
    }
    let build = folder.join("build");
    let said = cmake(&folder, &build, &prefix())?;
    if said.contains("warning") {
        return Err(format!("the examples do not build cleanly:\n{said}"));
    }
    for (name, wanted) in pins("example")? {
        for program in [name.clone(), format!("{name}_static")] {
            // One run of the long example is enough.
            if program == "monte_carlo_static" {
                continue;
            }
            let printed = output(build.join(&program), &[])?;
            let last = printed.lines().last().unwrap_or_default();
            if last != wanted {
                return Err(format!("{program} ends with \"{last}\" instead of \"{wanted}\" (tests/golden/pins)"));
            }
        }
        println!("  {name}: {wanted}");
    }
    capsule(&build)?;
    threads(&build)?;
    cost()
}

/// The example with a capsule: what one program writes another one replays.
fn capsule(build: &Path) -> Outcome {
    let file = build.join("run.capsule").to_string_lossy().into_owned();
    let written = output(build.join("capsule"), &[&file])?;
    let replayed = output(build.join("capsule_static"), &[&file, "replay"])?;
    println!("  capsule: {}", written.trim());
    if written.starts_with("same bits") && replayed == written {
        Ok(())
    } else {
        Err(format!("a capsule is replayed as {replayed} instead of {written}"))
    }
}

/// The example with threads: for any number of them the pinned digest of the same scene.
fn threads(build: &Path) -> Outcome {
    let (_, wanted) = pins("host")?.pop().unwrap_or_default();
    for threads in ["1", "2", "3", "5"] {
        let printed = output(build.join("threads"), &[threads])?;
        if printed.trim() != wanted {
            return Err(format!("threads {threads} prints {printed} instead of {wanted}"));
        }
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
    let count = |compiler: &str, standard: &str, source: &str| -> Result<u64, String> {
        let program = folder.join(compiler).to_string_lossy().into_owned();
        let library = prefix().join("lib/libfabric_kernel.a").to_string_lossy().into_owned();
        command(compiler, &[standard, "-O2", "-DNDEBUG", "-Iinclude", source, &library, "-o", &program])?;
        let counts = format!("{program}.counts");
        let file = format!("--callgrind-out-file={counts}");
        let mut least = u64::MAX;
        // Where the stack begins depends on the length of arguments and environment, and on it what copies
        // cost: 32 bytes apart or not.
        for shift in ["x", "xxxxxxxxxxxxxxxxx"] {
            output("valgrind", &["--quiet", "--tool=callgrind", "--toggle-collect=measured", &file, &program, shift])?;
            let counts = read(&counts)?;
            let total = counts.lines().find_map(|line| line.strip_prefix("totals: "));
            let total = total.and_then(|total| total.trim().parse().ok()).ok_or("callgrind prints no totals")?;
            least = least.min(total);
        }
        Ok(least)
    };
    let c = count("gcc", "-std=c11", "tests/cpp/cost.c")?;
    let cpp = count("g++", "-std=c++17", "tests/cpp/cost.cpp")?;
    println!("  instructions of {CALLS} calls: C {c}, C++ {cpp}");
    let allowed = c + 2 * CALLS;
    if c > 0 && cpp <= allowed { Ok(()) } else { Err(format!("the C++ header costs more than {allowed}")) }
}

/// `cargo deny`: licences, sources and bans of every dependency.
pub fn deny() -> Outcome {
    wait(cargo_tool("cargo-deny")?.args(["--offline", "check", "bans", "licenses", "sources"]))
}
