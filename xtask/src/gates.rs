//! What the shipped libraries must not contain, looked up in the linked libraries themselves and in their source. Each gate
//! prints its row of docs/reliability.md ("figure N: ...").

use crate::stack;
use crate::tools::{Outcome, cargo, output, read, target, top};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind};
use std::path::{Path, PathBuf};

/// All gates on the two libraries.
pub fn run() -> Outcome {
    let without_theta = code(&linked("capi-lib", "libfabric_kernel.so", &["--no-default-features"])?)?;
    let [kernel, fmu] =
        [linked("capi-lib", "libfabric_kernel.so", &[])?, linked("fmu-lib", "libfabric_shield.so", &[])?];
    println!("figure 1: 0 in libfabric_kernel, 0 in the FMU: both link although no panic handler exists");
    undefined(&kernel, &FROM_HOST)?;
    undefined(&fmu, &crate::platforms::FROM_LINUX)?;
    println!(
        "figure 2: 0 beyond {} in libfabric_kernel; 0 beyond {} in the FMU",
        FROM_HOST.join(", "),
        crate::platforms::FROM_LINUX.join(", ")
    );
    unsafe_blocks()?;
    features_remove_code(&without_theta, &code(&kernel)?)?;
    if cfg!(target_arch = "x86_64") {
        return stacks(&kernel);
    }
    println!("  the stack is measured on x86-64 only: left out");
    Ok(())
}

/// Links a library in which the panic handler calls a function that does not exist: it links only if no panic can be reached
/// from any exported function. It keeps its symbols, and the compiler notes the frame of each function, which changes no code
/// (but is not a stable feature: hence the variable). Calls of its own functions do not go through the table of symbols.
fn linked(package: &str, library: &str, options: &[&str]) -> Result<PathBuf, String> {
    let folder = target().join("gate");
    let status = std::process::Command::new(crate::tools::cargo_program())
        .args(["rustc", "--quiet", "--profile", "ship", "--package", package, "--lib", "--crate-type", "cdylib"])
        .args(options)
        .args(["--features", "gate", "--config", "profile.ship.strip=false", "--target-dir"])
        .arg(&folder)
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTFLAGS", "-Zemit-stack-sizes -Clink-arg=-Wl,-z,defs,-Bsymbolic -Clink-arg=-lc")
        .current_dir(top())
        .status()
        .map_err(|error| format!("cannot start cargo: {error}"))?;
    if !status.success() {
        return Err(format!("a panic can be reached in {package} (the linker names the function that needs it)"));
    }
    Ok(folder.join("ship").join(library))
}

/// What the kernel's C library may ask of its host.
const FROM_HOST: [&str; 4] = ["memcpy", "memmove", "memset", "memcmp"];

/// The C library may ask its host for these and nothing else, besides the weak names of the linker's start-up code.
pub fn undefined_in_kernel(library: &Path) -> Outcome {
    undefined(library, &FROM_HOST)
}

fn undefined(library: &Path, allowed: &[&str]) -> Outcome {
    let listed = output("nm", &["-D", "--undefined-only", &library.to_string_lossy()])?;
    let names = listed.lines().filter(|line| !line.contains(" w ")).filter_map(|line| line.split_whitespace().last());
    let strangers: Vec<_> =
        names.map(|name| name.split('@').next().unwrap_or(name)).filter(|name| !allowed.contains(name)).collect();
    if strangers.is_empty() { Ok(()) } else { Err(format!("{} wants {strangers:?}", library.display())) }
}

/// Machine code of a library.
struct Code {
    /// Bytes.
    bytes: u64,
    /// Symbols of the theta rule.
    theta: usize,
}

/// What a library holds that has kept its symbols.
fn code(library: &Path) -> Result<Code, String> {
    let data = std::fs::read(library).map_err(|error| format!("{}: {error}", library.display()))?;
    let file = object::File::parse(&*data).map_err(|error| format!("{}: {error}", library.display()))?;
    let text = file.sections().filter(|section| section.kind() == SectionKind::Text);
    // Mangled names hold the path of modules, each with its length before it.
    let of_theta = |name: &str| name.contains("6fabric5theta");
    Ok(Code {
        bytes: text.map(|section| section.size()).sum(),
        theta: file.symbols().filter(|symbol| symbol.name().is_ok_and(of_theta)).count(),
    })
}

/// A feature that is left out makes the library smaller and takes its symbols along.
fn features_remove_code(without: &Code, with: &Code) -> Outcome {
    println!(
        "figure 6: machine code of libfabric_kernel {} bytes, without the theta rule {}",
        with.bytes, without.bytes
    );
    match (without.theta, with.theta) {
        (_, 0) => Err("libfabric_kernel has no symbol of the theta rule: this gate looks for the wrong names".into()),
        (0, _) if without.bytes < with.bytes => Ok(()),
        _ => Err("libfabric_kernel without the feature `implicit` still holds code of the theta rule".into()),
    }
}

/// The files of the kernel that may have unsafe code.
const UNSAFE_IN_KERNEL: [&str; 2] = ["kernel/src/step/bands.rs", "kernel/src/ground/lanes.rs"];
/// Unsafe blocks that the two interfaces may have.
const UNSAFE_AT_MOST: usize = 40;

/// Counts unsafe blocks in the source. That each has its SAFETY line is clippy's to see (`undocumented_unsafe_blocks`).
fn unsafe_blocks() -> Outcome {
    let (mut kernel, mut interfaces) = (0, 0);
    for (path, text) in sources(&["kernel/src", "capi", "fmu", "host"])? {
        let count = text.lines().filter(|line| !line.trim_start().starts_with("//")).map(blocks).sum::<usize>();
        if !path.starts_with("kernel/") {
            interfaces += count;
        } else if count > 0 && !UNSAFE_IN_KERNEL.contains(&&*path) {
            return Err(format!("{path} has unsafe code; only {UNSAFE_IN_KERNEL:?} may"));
        } else {
            kernel += count;
        }
    }
    println!(
        "figure 4: {kernel} blocks in {}, {interfaces} in C interface, FMU and host",
        UNSAFE_IN_KERNEL.join(" and ")
    );
    if interfaces <= UNSAFE_AT_MOST {
        return Ok(());
    }
    Err(format!("{interfaces} unsafe blocks in C interface, FMU and host; at most {UNSAFE_AT_MOST} are allowed"))
}

/// Unsafe blocks that begin in a line.
fn blocks(line: &str) -> usize {
    line.split("unsafe").skip(1).filter(|rest| rest.trim_start().starts_with('{') || rest.trim().is_empty()).count()
}

/// The committed files of Rust below these folders: path and text.
fn sources(folders: &[&str]) -> Result<Vec<(String, String)>, String> {
    let listed = output("git", &[&["ls-files", "--"], folders].concat())?;
    let wanted = listed.lines().filter(|path| path.ends_with(".rs"));
    wanted.map(|path| Ok((path.to_string(), read(top().join(path))?))).collect()
}

/// Stack that a call may need, bytes.
const STACK_AT_MOST: u64 = 4096;

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
    let deepest = chains.first().ok_or("the library exports no function")?;
    let within = chains.iter().filter(|chain| chain.bytes <= STACK_AT_MOST).count();
    println!(
        "figure 27: {} bytes in {} ({}); {within} of {} functions need at most {STACK_AT_MOST}; no recursion",
        deepest.bytes,
        deepest.entry,
        shown(deepest),
        chains.len()
    );
    if deepest.bytes <= STACK_AT_MOST { Ok(()) } else { Err(format!("more than {STACK_AT_MOST} bytes of stack")) }
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

/// Builds and tests the kernel with every set of its features, without a warning. The steps before have done so with all of them.
pub fn every_feature_set() -> Outcome {
    const SETS: [&str; 3] = ["", "micro", "implicit"];
    for set in SETS {
        let package = ["--quiet", "--package", "fabric-kernel", "--features", set];
        cargo(&[&["clippy"], &package[..], &["--all-targets", "--", "-D", "warnings"]].concat())?;
        cargo(&[&["test"], &package[..]].concat())?;
    }
    println!(
        "figure 15: {} of {} sets of features build without a warning and pass their tests, and that with all in the steps before",
        SETS.len(),
        SETS.len()
    );
    Ok(())
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
        assert_eq!(short("<fabric::sim::Sim>::pass"), "Sim::pass");
        assert_eq!(short("fabric_host::float::call::<(), fabric_capi::calls::fk_reset>"), "float::call");
    }
}
