//! The FMU's library for every platform, from one source: how it is built.

use crate::targets::{BINDER, FROM_LINUX, FROM_MACOS, LIBSYSTEM, MACOS, TARGETS, Target};
use crate::tools::{self, Outcome, output, version};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

#[derive(Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Targets {
    /// Only the platform that this runs on.
    #[default]
    Host,
    /// Every platform whose tools are installed.
    All,
}

pub struct Library {
    pub platform: &'static Target,
    pub path: PathBuf,
}

/// Builds the wanted libraries from the checkout in `source` into `target`, and says what was left out and
/// why.
pub fn build(source: &Path, target: &Path, targets: Targets) -> Result<Vec<Library>, String> {
    let host = host()?;
    compile(source, target, &own(), &[])?;
    let mut built = vec![Library { platform: host, path: target.join("ship").join(host.library()) }];
    if targets == Targets::All {
        let cross = target.join("cross");
        let mut wanted = Vec::new();
        for platform in platforms().filter(|platform| platform.triple != host.triple) {
            match compiler(platform) {
                Ok(compiler) => wanted.push((platform, compiler)),
                Err(reason) => tools::left_out(&format!("FMU for {}", platform.fmu[0]), &reason),
            }
        }
        // Targets of one compiler are built side by side.
        while let Some((_, compiler)) = wanted.first().cloned() {
            let (now, later): (Vec<_>, Vec<_>) = wanted.into_iter().partition(|(_, other)| *other == compiler);
            let platforms: Vec<_> = now.into_iter().map(|(platform, _)| platform).collect();
            compile(source, &cross, &compiler, &platforms)?;
            built.extend(platforms.into_iter().map(|platform| Library {
                platform,
                path: cross.join(platform.triple).join("ship").join(platform.library()),
            }));
            wanted = later;
        }
    }
    Ok(built)
}

fn platforms() -> impl Iterator<Item = &'static Target> {
    TARGETS.iter().filter(|target| !target.extension.is_empty())
}

const ON_MACOS: bool = cfg!(target_os = "macos");

pub fn host() -> Result<&'static Target, String> {
    let machine = std::env::consts::ARCH;
    let system = if ON_MACOS { "darwin" } else { std::env::consts::OS };
    platforms()
        .find(|platform| platform.triple.starts_with(machine) && platform.triple.contains(system))
        .ok_or(format!("no FMU platform is defined for {machine} with {system}"))
}

#[derive(Clone, PartialEq)]
pub struct Compiler {
    cargo: OsString,
    /// Only where it is not the one that this cargo comes with.
    rustc: Option<PathBuf>,
    /// It has no compiled `core` for the target but the source of it.
    build_core: bool,
}

impl Compiler {
    /// Cargo, told to use this compiler; options that the kind of compiler needs come with
    /// [`Compiler::options`].
    pub fn command(&self) -> Command {
        self.told_to(Command::new(&self.cargo))
    }

    /// A program that calls cargo, told to use this compiler. Where that has no standard library for the
    /// target but its source, the library is built along.
    pub fn lent_to(&self, program: Command) -> Command {
        let mut program = self.told_to(program);
        program.env("CARGO", &self.cargo);
        if self.build_core {
            program.env("CARGO_UNSTABLE_BUILD_STD", "std,panic_unwind");
        }
        program
    }

    fn told_to(&self, mut command: Command) -> Command {
        if let Some(rustc) = &self.rustc {
            command.env_remove("RUSTUP_TOOLCHAIN").env("RUSTC", rustc);
        }
        if self.build_core {
            // Not stable: this variable allows it, for these libraries only.
            command.env("RUSTC_BOOTSTRAP", "1");
        }
        command
    }

    /// Options after cargo's subcommand.
    pub fn options(&self) -> Option<String> {
        self.options_with("core")
    }

    /// Options for a program that needs these libraries of Rust.
    pub fn options_with(&self, libraries: &str) -> Option<String> {
        self.build_core.then(|| format!("-Zbuild-std={libraries}"))
    }
}

/// The compiler that built this program, for this platform.
pub fn own() -> Compiler {
    let cargo = crate::tools::cargo_program();
    Compiler { cargo, rustc: None, build_core: false }
}

/// A compiler for another platform: ours if it has the target (`rustup target add`), else ours or the
/// distribution's with the source of `core` (`rustup component add rust-src`; Debian: rustc-web, cargo-web
/// and rust-web-src).
fn compiler(platform: &Target) -> Result<Compiler, String> {
    if Command::new(linker(platform)).arg("--version").output().is_err() {
        return Err(platform.compiler.missing());
    }
    let (triple, compiler) = (platform.triple, compiler_for(platform.triple)?);
    if platform.extension == "dylib" && compiler != own() {
        // Debian's has no rust-objcopy, with which rustc strips these libraries.
        return Err(format!("this Rust has no target {triple} (`rustup target add {triple}`)"));
    }
    Ok(compiler)
}

/// What links for another platform: a program that is installed, or for macOS the one that lies beside our
/// compiler's libraries.
fn linker(platform: &Target) -> PathBuf {
    let name = platform.compiler.0[0];
    let besides = beside_our_compiler(name).ok().filter(|_| platform.extension == "dylib");
    besides.unwrap_or(name.into())
}

/// A program that rustup puts beside our compiler's libraries.
pub fn beside_our_compiler(name: &str) -> Result<PathBuf, String> {
    let libraries = output(our_rustc(), &["--print", "target-libdir"])?;
    let program = Path::new(libraries.trim()).with_file_name("bin").join(name);
    if program.exists() { Ok(program) } else { Err(format!("{name} is missing; rustup's compilers bring it")) }
}

fn our_rustc() -> PathBuf {
    std::env::var_os("RUSTC").map_or("rustc".into(), PathBuf::from)
}

/// Compiler for any target, whatever links for it.
pub fn compiler_for(triple: &str) -> Result<Compiler, String> {
    let ours = our_rustc();
    let printed = |rustc: &Path, arguments: &[&str]| output(rustc, arguments).map(|text| text.trim().to_string());
    if printed(&ours, &["--print", "target-libdir", "--target", triple]).is_ok_and(|at| Path::new(&at).exists()) {
        return Ok(own());
    }
    let system = PathBuf::from("/usr/bin/rustc");
    for (rustc, cargo, named) in [(ours, own().cargo, None), (system.clone(), "/usr/bin/cargo".into(), Some(system))] {
        let Ok(root) = printed(&rustc, &["--print", "sysroot"]) else { continue };
        let has_source = Path::new(&root).join("lib/rustlib/src/rust/library/core").exists();
        let new_enough = printed(&rustc, &["--version"]).is_ok_and(|text| version(&text) >= version(MINIMUM));
        if has_source && new_enough {
            return Ok(Compiler { cargo, rustc: named, build_core: true });
        }
    }
    Err(format!(
        "no Rust {MINIMUM} or newer has the target {triple} or the source of its core library (`rustup target add {triple}`; \
         Debian: rustc-web cargo-web rust-web-src)"
    ))
}

/// Oldest compiler that is known to build the project.
const MINIMUM: &str = env!("CARGO_PKG_RUST_VERSION");

/// Builds the library in its shipped form into `target`, for this platform if `others` names none.
fn compile(source: &Path, target: &Path, compiler: &Compiler, others: &[&Target]) -> Outcome {
    let mut command = compiler.command();
    command
        .args(["build", "--quiet", "--locked", "--profile", "ship", "-p", "fmu-lib", "--features", "bare"])
        .arg("--target-dir")
        .arg(target)
        .args(compiler.options())
        .current_dir(source);
    let host = [host()?];
    for platform in if others.is_empty() { &host } else { others } {
        let variable = |what: &str| format!("CARGO_TARGET_{}_{what}", platform.triple.to_uppercase().replace('-', "_"));
        if !others.is_empty() {
            command.args(["--target", platform.triple]);
            if std::env::var_os(variable("LINKER")).is_none() {
                command.env(variable("LINKER"), linker(platform));
            }
        }
        // One source gives the same bytes, whenever and wherever it is built.
        let mut flags = match platform.extension {
            "dll" => "-Clink-arg=-Wl,--no-insert-timestamp".to_string(),
            // Without this the library's name for itself is where it was built.
            "dylib" => "-Crpath".to_string(),
            _ => continue,
        };
        if platform.extension == "dylib" {
            command.env("MACOSX_DEPLOYMENT_TARGET", format!("{}.{}", MACOS.0, MACOS.1));
            if !others.is_empty() {
                // The linker makes the library's number (LC_UUID) from all that it writes, and stripping
                // comes after it: without
                // -S and -x it would write names of folders and local symbols.
                flags += " -Clinker-flavor=ld64.lld -Clink-arg=-S -Clink-arg=-x";
            }
            if !ON_MACOS {
                command.env("SDKROOT", stub(target)?);
            }
        }
        command.env(variable("RUSTFLAGS"), flags);
    }
    let names: Vec<_> = if others.is_empty() { &host } else { others }.iter().map(|one| one.fmu[0]).collect();
    tools::said(&format!("Compiling the FMU's library for {}", names.join(", ")), || tools::wait(&mut command))
}

/// What the linker needs to know of macOS where Apple's tools are missing: the names of the functions that
/// the library may ask for.
fn stub(target: &Path) -> Result<PathBuf, String> {
    let top = target.join("macos");
    let file = top.join("usr/lib/libSystem.tbd");
    let names = FROM_LINUX.iter().chain(&FROM_MACOS).map(|name| format!("_{name}, ")).collect::<String>();
    let text = format!(
        "--- !tapi-tbd\ntbd-version: 4\ntargets: [ x86_64-macos, arm64-macos ]\ninstall-name: '{LIBSYSTEM}'\nexports:\n  \
         - targets: [ x86_64-macos, arm64-macos ]\n    symbols: [ {names}{BINDER} ]\n...\n"
    );
    tools::write(&file, text)?;
    Ok(top)
}

/// The library of a target, or of this machine, with these options of cargo and a folder of its own.
pub fn library(triple: Option<&str>, flags: &str, options: &[&str], folder: &Path) -> Result<PathBuf, String> {
    let compiler = triple.map_or_else(|| Ok(own()), compiler_for)?;
    let mut command = compiler.command();
    command
        .args(["rustc", "--quiet", "--locked", "--profile", "ship"])
        .args(["-p", "capi-lib", "--lib", "--crate-type", "staticlib"])
        .args(options)
        .args(compiler.options())
        .arg("--target-dir")
        .arg(folder)
        .current_dir(tools::top());
    if let Some(triple) = triple {
        command.args(["--target", triple]);
    }
    if !flags.is_empty() {
        command.env("RUSTFLAGS", flags);
    }
    let platform = triple.unwrap_or("this platform");
    tools::said(&format!("Compiling the C library for {platform} {flags}"), || tools::finish(&mut command))?;
    Ok(folder.join(triple.unwrap_or("")).join("ship").join("libfabric_kernel.a"))
}
