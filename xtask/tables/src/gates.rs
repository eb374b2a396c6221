//! What the shipped libraries must not contain, looked up in the linked libraries themselves and in their
//! source. Each gate prints its row of docs/reliability.md ("figure N: ...").

use crate::stack;
use fabric_kernel::FEATURES;
use fabric_tests::golden::SCENES;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind};
use std::path::{Path, PathBuf};
use xtask::targets::{FROM_HOST, FROM_LINUX, undefined};
use xtask::tools::{Context as _, Outcome, ensure, sh, shell, sources, target};

/// All gates on the two libraries.
pub fn run() -> Outcome {
    let few = kernel("")?;
    let bare = code(&few)?;
    let [kernel, fmu] = [kernel("default,capsule")?, linked("fmu-lib", "libfabric_shield.so", &[])?];
    println!("figure 1: 0 in libfabric_kernel, 0 in the FMU: both link although no panic handler exists");
    undefined(&kernel, &FROM_HOST)?;
    undefined(&fmu, &FROM_LINUX)?;
    println!(
        "figure 2: 0 beyond {} in libfabric_kernel; 0 beyond {} in the FMU",
        FROM_HOST.join(", "),
        FROM_LINUX.join(", ")
    );
    unsafe_blocks()?;
    features_remove_code(&bare, &code(&kernel)?)?;
    if cfg!(target_arch = "x86_64") {
        println!("  without any feature:");
        stacks(&few)?;
        println!("  with all:");
        return stacks(&kernel);
    }
    println!("  the stack is measured on x86-64 only: left out");
    Ok(())
}

/// Links a library in which the panic handler calls a function that does not exist: it links only if no panic
/// can be reached from any exported function. It keeps its symbols, and the compiler notes the frame of each
/// function, which changes no code (but is not a stable feature: hence the variable). Calls of its own
/// functions do not go through the table of symbols.
fn linked(package: &str, library: &str, options: &[&str]) -> Outcome<PathBuf> {
    let folder = target().join("gate");
    let command = sh!("cargo rustc --quiet --profile ship --package {package} --lib --crate-type cdylib {options...}");
    let command = command.args(["--features", "gate", "--config", "profile.ship.strip=false", "--target-dir"]);
    let flags = "-Zemit-stack-sizes -Clink-arg=-Wl,-z,defs,-Bsymbolic -Clink-arg=-lc";
    let reached = || format!("a panic can be reached in {package} (the linker names the function that needs it)");
    command.arg(&folder).env("RUSTC_BOOTSTRAP", "1").env("RUSTFLAGS", flags).run().with_context(reached)?;
    Ok(folder.join("ship").join(library))
}

/// libfabric_kernel with this feature of the kernel only, none if it is empty, or `default,capsule`, which is
/// all.
pub fn kernel(feature: &str) -> Outcome<PathBuf> {
    linked("capi-lib", "libfabric_kernel.so", &["--no-default-features", "--features", &of_kernel(feature)])
}

/// A feature of the kernel as a command of cargo for another package names it.
pub fn of_kernel(feature: &str) -> String {
    if feature.is_empty() { String::new() } else { format!("fabric-kernel/{feature}") }
}

pub struct Code {
    pub bytes: u64,
    /// Modules of [`LEFT_OUT`] of which it has a symbol.
    modules: Vec<&'static str>,
}

/// Modules that belong to one feature, as mangled names hold them: each part with its length before it.
const LEFT_OUT: [&str; 6] =
    ["4step5theta", "5sweep7moments", "4step5bands", "4step6blocks", "4step4slip", "7contact5stack"];
/// Machine code of the library before features could be left out, bytes; without any it is to be at most a
/// third of that.
const ALWAYS_BUILT: u64 = 648_073;

/// What a library holds that has kept its symbols.
pub fn code(library: &Path) -> Outcome<Code> {
    let data = shell().read_binary_file(library)?;
    let file = object::File::parse(&*data).with_context(|| library.display().to_string())?;
    let text = file.sections().filter(|section| section.kind() == SectionKind::Text);
    let names: Vec<&str> = file.symbols().filter_map(|symbol| symbol.name().ok()).collect();
    let held = |module: &&str| names.iter().any(|name| name.contains(&format!("13fabric_kernel{module}")));
    Ok(Code { bytes: text.map(|section| section.size()).sum(), modules: LEFT_OUT.into_iter().filter(held).collect() })
}

/// Features that are left out make the library smaller and take their modules along.
fn features_remove_code(bare: &Code, all: &Code) -> Outcome {
    println!("figure 6: machine code of libfabric_kernel {} bytes, without any feature {}", all.bytes, bare.bytes);
    let found = &all.modules;
    ensure!(found == &LEFT_OUT, "libfabric_kernel has symbols of {found:?} only: this gate looks for wrong names");
    ensure!(bare.modules.is_empty(), "libfabric_kernel without features still holds {:?}", bare.modules);
    ensure!(3 * bare.bytes <= ALWAYS_BUILT, "more than a third is left without features");
    Ok(())
}

/// The folder and the file of the kernel that may have unsafe code.
const UNSAFE_IN_KERNEL: [&str; 2] = ["kernel/src/step/bands/", "kernel/src/ground/lanes.rs"];
/// Unsafe blocks that the two interfaces may have.
const UNSAFE_AT_MOST: usize = 40;

/// Counts unsafe blocks in the source. That each has its SAFETY line is clippy's to see
/// (`undocumented_unsafe_blocks`).
fn unsafe_blocks() -> Outcome {
    let (mut kernel, mut interfaces) = (0, 0);
    for (path, text) in sources(&["kernel/src", "capi", "fmu", "crates/host"])? {
        let count = text.lines().filter(|line| !line.trim_start().starts_with("//")).map(blocks).sum::<usize>();
        if path.starts_with("kernel/") {
            let may = count == 0 || UNSAFE_IN_KERNEL.iter().any(|place| path.starts_with(place));
            ensure!(may, "{path} has unsafe code; only {UNSAFE_IN_KERNEL:?} may");
            kernel += count;
        } else {
            interfaces += count;
        }
    }
    println!(
        "figure 4: {kernel} blocks in {}, {interfaces} in C interface, FMU and host",
        UNSAFE_IN_KERNEL.join(" and ")
    );
    ensure!(interfaces <= UNSAFE_AT_MOST, "at most {UNSAFE_AT_MOST} are allowed there");
    Ok(())
}

/// Unsafe blocks that begin in a line.
fn blocks(line: &str) -> usize {
    line.split("unsafe").skip(1).filter(|rest| rest.trim_start().starts_with('{') || rest.trim().is_empty()).count()
}

/// A machine whose memory holds a sheet has as much.
const STACK_AT_MOST: u64 = 8192;

/// The deepest chain of calls from each function of the C interface.
fn stacks(library: &Path) -> Outcome {
    let chains = stack::chains(library)?;
    let shown = |chain: &stack::Chain| {
        let frames: Vec<_> = chain.frames.iter().map(|(name, frame)| format!("{} {frame}", short(name))).collect();
        frames.join(" + ")
    };
    for chain in &chains {
        println!("  {:6} bytes of stack: {}", chain.bytes, shown(chain));
    }
    let deepest = chains.first().context("the library exports no function")?;
    let within = chains.iter().filter(|chain| chain.bytes <= STACK_AT_MOST).count();
    println!(
        "figure 27: {} bytes in {} ({}); {within} of {} functions need at most {STACK_AT_MOST}; no recursion",
        deepest.bytes,
        deepest.entry,
        shown(deepest),
        chains.len()
    );
    ensure!(deepest.bytes <= STACK_AT_MOST, "more than {STACK_AT_MOST} bytes of stack");
    Ok(())
}

/// The last two parts of a name, without what it is generic over.
fn short(name: &str) -> String {
    let (mut plain, mut depth) = (String::new(), 0);
    for letter in name.trim_start_matches('<').replace(">::", "::").chars() {
        match letter {
            '<' => depth += 1,
            '>' => depth -= 1,
            _ if depth == 0 => plain.push(letter),
            _ => {}
        }
    }
    let parts: Vec<_> = plain.split("::").filter(|part| !part.is_empty()).collect();
    parts[parts.len().saturating_sub(2)..].join("::")
}

/// Sets of features that are more than one and less than all: the kernel's Cargo.toml says what each is for.
pub const SETS: [&str; 2] = ["paper", "real"];

/// Pinned scenes that are also run by a build of just the features that each asks for, as
/// `fabric scene --features` lists them.
const JUST_ENOUGH: [&str; 5] = [
    "sphere_that_rubs",
    "sphere_through_turned_plies",
    "cylinder_on_a_graded_sheet",
    "drawn_yarns_by_the_theta_rule",
    "disc_sector",
];

/// Builds the kernel with nothing, with each feature left out, and with sets that a host may use, and runs
/// the pinned scenes of the first and the last of these. The steps before have done so with all features.
pub fn every_feature_set() -> Outcome {
    let names = names();
    for left_out in &names {
        let others = names.iter().filter(|name| *name != left_out).copied().collect::<Vec<_>>().join(",");
        println!("  {others}");
        sh!("cargo check --quiet --package fabric-kernel --no-default-features --features {others}").run()?;
    }
    for set in [""].iter().chain(&SETS) {
        golden(set, "")?;
    }
    for (name, scene, ..) in SCENES.iter().filter(|(name, ..)| JUST_ENOUGH.contains(name)) {
        let asked = FEATURES.iter().filter(|record| record.asked_by(&scene()).is_some());
        let features = asked.map(|record| record.name).collect::<Vec<_>>().join(",");
        println!("  {name}: {features}");
        golden(&features, name)?;
    }
    println!(
        "figure 15: each of {} features left out, nothing, and {} build without a warning; pinned scenes of the last {} pass, \
         and {} by builds of just their features",
        names.len(),
        SETS.join(" and "),
        1 + SETS.len(),
        JUST_ENOUGH.len()
    );
    Ok(())
}

/// The golden tests by a kernel of these features. `runs`: a scene that must not be left out.
fn golden(features: &str, runs: &str) -> Outcome {
    let features = features.split(',').map(of_kernel).collect::<Vec<_>>().join(",");
    let tests = sh!("cargo test --quiet --package fabric-tests --test golden --no-default-features");
    Ok(tests.args(["--features", &features]).env("FABRIC_RUNS", runs).run()?)
}

/// The cargo features of the kernel, each once.
pub fn names() -> Vec<&'static str> {
    let mut names: Vec<_> = FEATURES.iter().map(|record| record.name).collect();
    names.sort_unstable();
    names.dedup();
    names
}

#[cfg(test)]
mod tests {
    use super::{blocks, short};

    #[test]
    fn blocks_are_counted_and_functions_are_not() {
        assert_eq!(blocks("let x = unsafe { f() } + unsafe { g() };"), 2);
        assert_eq!(blocks("pub unsafe extern \"C\" fn f() {"), 0);
        assert_eq!(blocks("#[unsafe(no_mangle)]"), 0);
        assert_eq!(blocks("        unsafe {"), 1);
    }

    #[test]
    fn names_are_shortened() {
        assert_eq!(short("<fabric_kernel::sim::Sim>::pass"), "Sim::pass");
        assert_eq!(short("fabric_host::float::call::<(), fabric_capi::calls::fk_reset>"), "float::call");
    }
}
