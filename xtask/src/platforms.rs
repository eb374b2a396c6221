//! The FMU's library for every platform, from one source: how it is built.

use crate::targets::{BINDER, FROM_LINUX, FROM_MACOS, LIBSYSTEM, MACOS, TARGETS, Target};
use crate::tools::{Outcome, anyhow, asked, bail, ensure, finish, left_out, said, sh, shell, target, version};
use std::path::{Path, PathBuf};
use xshell::Cmd;

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

/// Builds the wanted libraries, and says what was left out and why.
pub fn build(targets: Targets) -> Outcome<Vec<Library>> {
    let host = host()?;
    compile(&target(), &own(), &[])?;
    let mut built = vec![Library { platform: host, path: target().join("ship").join(host.library()) }];
    if targets == Targets::Host {
        return Ok(built);
    }
    let cross = target().join("cross");
    let mut wanted = Vec::new();
    for platform in platforms().filter(|platform| platform.triple != host.triple) {
        match compiler(platform) {
            Ok(compiler) => wanted.push((platform, compiler)),
            Err(reason) => left_out(&format!("FMU for {}", platform.fmu[0]), &reason.to_string()),
        }
    }
    // Targets of one compiler are built side by side.
    for now in wanted.chunk_by(|(_, one), (_, other)| one == other) {
        let platforms: Vec<_> = now.iter().map(|(platform, _)| *platform).collect();
        compile(&cross, &now[0].1, &platforms)?;
        let path = |platform: &Target| cross.join(platform.triple).join("ship").join(platform.library());
        built.extend(platforms.into_iter().map(|platform| Library { platform, path: path(platform) }));
    }
    Ok(built)
}

fn platforms() -> impl Iterator<Item = &'static Target> {
    TARGETS.iter().filter(|target| !target.extension.is_empty())
}

const ON_MACOS: bool = cfg!(target_os = "macos");

pub fn host() -> Outcome<&'static Target> {
    let machine = std::env::consts::ARCH;
    let system = if ON_MACOS { "darwin" } else { std::env::consts::OS };
    platforms()
        .find(|platform| platform.triple.starts_with(machine) && platform.triple.contains(system))
        .ok_or_else(|| anyhow!("no FMU platform is defined for {machine} with {system}"))
}

#[derive(Clone, PartialEq)]
pub struct Compiler {
    /// Cargo and its compiler, where they are not those that this program was built with.
    other: Option<[&'static str; 2]>,
    /// It has no compiled `core` for the target but the source of it.
    build_core: bool,
}

impl Compiler {
    /// A program that calls cargo, told to use this compiler. Where that has no standard library for the
    /// target but its source, the library is built along.
    pub fn lent_to(&self, program: Cmd<'static>) -> Cmd<'static> {
        let program = self.told_to(program);
        if self.build_core { program.env("CARGO_UNSTABLE_BUILD_STD", "std,panic_unwind") } else { program }
    }

    fn told_to(&self, mut program: Cmd<'static>) -> Cmd<'static> {
        if let Some([cargo, rustc]) = self.other {
            program = program.env_remove("RUSTUP_TOOLCHAIN").env("RUSTC", rustc).env("CARGO", cargo);
        }
        // Not stable: this variable allows it, for these libraries only.
        if self.build_core { program.env("RUSTC_BOOTSTRAP", "1") } else { program }
    }

    /// Cargo, told to use this compiler; options that the kind of compiler needs come with
    /// [`Compiler::options`].
    pub fn command(&self, subcommand: &str) -> Cmd<'static> {
        let cargo = self.other.map_or("cargo", |[cargo, _]| cargo);
        self.told_to(sh!("{cargo} {subcommand} --quiet --locked --profile ship"))
    }

    /// Options after cargo's subcommand for a program that needs these libraries of Rust.
    pub fn options(&self, libraries: &str) -> Option<String> {
        self.build_core.then(|| format!("-Zbuild-std={libraries}"))
    }
}

/// The compiler that built this program, for this platform.
pub fn own() -> Compiler {
    Compiler { other: None, build_core: false }
}

/// A compiler for another platform: ours if it has the target (`rustup target add`), else ours or the
/// distribution's with the source of `core` (`rustup component add rust-src`; Debian: rustc-web, cargo-web
/// and rust-web-src).
fn compiler(platform: &Target) -> Outcome<Compiler> {
    let linker = linker(platform);
    ensure!(asked(sh!("{linker} --version").ignore_status()).is_some(), platform.compiler.missing());
    let (triple, compiler) = (platform.triple, compiler_for(platform.triple)?);
    // Debian's has no rust-objcopy, with which rustc strips these libraries.
    let strips = platform.extension != "dylib" || compiler == own();
    ensure!(strips, "this Rust has no target {triple} (`rustup target add {triple}`)");
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
pub fn beside_our_compiler(name: &str) -> Outcome<PathBuf> {
    let rustc = our_rustc();
    let libraries = sh!("{rustc} --print target-libdir").read()?;
    let program = Path::new(&libraries).with_file_name("bin").join(name);
    ensure!(program.exists(), "{name} is missing; rustup's compilers bring it");
    Ok(program)
}

fn our_rustc() -> PathBuf {
    std::env::var_os("RUSTC").map_or("rustc".into(), PathBuf::from)
}

/// Compiler for any target, whatever links for it.
pub fn compiler_for(triple: &str) -> Outcome<Compiler> {
    let ours = our_rustc();
    if asked(sh!("{ours} --print target-libdir --target {triple}")).is_some_and(|at| Path::new(&at).exists()) {
        return Ok(own());
    }
    for (rustc, other) in [(ours, None), (DEBIANS[1].into(), Some(DEBIANS))] {
        let Some(root) = asked(sh!("{rustc} --print sysroot")) else { continue };
        let has_source = Path::new(&root).join("lib/rustlib/src/rust/library/core").exists();
        let new_enough = asked(sh!("{rustc} --version")).is_some_and(|text| version(&text) >= version(MINIMUM));
        if has_source && new_enough {
            return Ok(Compiler { other, build_core: true });
        }
    }
    bail!(
        "no Rust {MINIMUM} or newer has the target {triple} or the source of its core library (`rustup target add {triple}`; \
         Debian: rustc-web cargo-web rust-web-src)"
    )
}

/// Cargo and compiler of the distribution.
const DEBIANS: [&str; 2] = ["/usr/bin/cargo", "/usr/bin/rustc"];
/// Oldest compiler that is known to build the project.
const MINIMUM: &str = env!("CARGO_PKG_RUST_VERSION");

/// Builds the library in its shipped form into `folder`, for this platform if `others` names none.
fn compile(folder: &Path, compiler: &Compiler, others: &[&Target]) -> Outcome {
    let mut command = compiler.command("build").args(["-p", "fmu-lib", "--features", "bare"]);
    command = command.arg("--target-dir").arg(folder).args(compiler.options("core"));
    let host = [host()?];
    let platforms = if others.is_empty() { &host } else { others };
    for platform in platforms {
        let variable = |what: &str| format!("CARGO_TARGET_{}_{what}", platform.triple.to_uppercase().replace('-', "_"));
        if !others.is_empty() {
            command = command.args(["--target", platform.triple]);
            if std::env::var_os(variable("LINKER")).is_none() {
                command = command.env(variable("LINKER"), linker(platform));
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
            command = command.env("MACOSX_DEPLOYMENT_TARGET", format!("{}.{}", MACOS.0, MACOS.1));
            if !others.is_empty() {
                // The linker makes the library's number (LC_UUID) from all that it writes: without -S and
                // -x that has names of folders and local symbols, which are stripped later.
                flags += " -Clinker-flavor=ld64.lld -Clink-arg=-S -Clink-arg=-x";
            }
            if !ON_MACOS {
                command = command.env("SDKROOT", stub(folder)?);
            }
        }
        command = command.env(variable("RUSTFLAGS"), flags);
    }
    let names: Vec<_> = platforms.iter().map(|one| one.fmu[0]).collect();
    said(&format!("Compiling the FMU's library for {}", names.join(", ")), || Ok(command.run()?))
}

/// What the linker needs to know of macOS where Apple's tools are missing: the names of the functions that
/// the library may ask for.
fn stub(target: &Path) -> Outcome<PathBuf> {
    let top = target.join("macos");
    let names = FROM_LINUX.iter().chain(&FROM_MACOS).map(|name| format!("_{name}, ")).collect::<String>();
    let text = format!(
        "--- !tapi-tbd\ntbd-version: 4\ntargets: [ x86_64-macos, arm64-macos ]\ninstall-name: '{LIBSYSTEM}'\nexports:\n  \
         - targets: [ x86_64-macos, arm64-macos ]\n    symbols: [ {names}{BINDER} ]\n...\n"
    );
    shell().write_file(top.join("usr/lib/libSystem.tbd"), text)?;
    Ok(top)
}

/// The library of a target, or of this machine, with these options of cargo and a folder of its own.
pub fn library(triple: Option<&str>, flags: &str, options: &[&str], folder: &Path) -> Outcome<PathBuf> {
    let compiler = triple.map_or_else(|| Ok(own()), compiler_for)?;
    let mut command = compiler.command("rustc").args(["-p", "capi-lib", "--lib", "--crate-type", "staticlib"]);
    command = command.args(options).args(compiler.options("core")).arg("--target-dir").arg(folder);
    if let Some(triple) = triple {
        command = command.args(["--target", triple]);
    }
    if !flags.is_empty() {
        command = command.env("RUSTFLAGS", flags);
    }
    let platform = triple.unwrap_or("this platform");
    said(&format!("Compiling the C library for {platform} {flags}"), || finish(command))?;
    Ok(folder.join(triple.unwrap_or("")).join("ship").join("libfabric_kernel.a"))
}
