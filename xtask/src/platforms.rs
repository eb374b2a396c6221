//! The FMU's library for every platform, from one source: how it is built, and what it may ask of its host and offer to it.

use crate::tools::{self, Outcome, output};
use object::{NameOrOrdinal, Object, ObjectSection};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// One platform.
pub struct Platform {
    /// Name of the target in Rust.
    pub triple: &'static str,
    /// Folder of its binary in an archive of FMI 2.0. The standard has no name of its own for Arm and takes that of FMI 3.0.
    pub fmi2: &'static str,
    /// Folder of its binary in an archive of FMI 3.0.
    pub fmi3: &'static str,
    /// Name that cargo gives the library.
    built: &'static str,
    /// How its file name ends in the archives.
    pub extension: &'static str,
    /// Links for it on other platforms; and the Debian package that has it.
    linker: [&'static str; 2],
}

/// Every platform that an archive can hold.
pub const PLATFORMS: [Platform; 3] = [
    Platform {
        triple: "x86_64-unknown-linux-gnu",
        fmi2: "linux64",
        fmi3: "x86_64-linux",
        built: "libfabric_shield.so",
        extension: "so",
        linker: ["x86_64-linux-gnu-gcc", "gcc-x86-64-linux-gnu"],
    },
    Platform {
        triple: "x86_64-pc-windows-gnu",
        fmi2: "win64",
        fmi3: "x86_64-windows",
        built: "fabric_shield.dll",
        extension: "dll",
        linker: ["x86_64-w64-mingw32-gcc", "gcc-mingw-w64-x86-64"],
    },
    Platform {
        triple: "aarch64-unknown-linux-gnu",
        fmi2: "aarch64-linux",
        fmi3: "aarch64-linux",
        built: "libfabric_shield.so",
        extension: "so",
        linker: ["aarch64-linux-gnu-gcc", "gcc-aarch64-linux-gnu"],
    },
];

/// Which platforms are wanted.
#[derive(Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Targets {
    /// Only the platform that this runs on.
    #[default]
    Host,
    /// Every platform whose tools are installed.
    All,
}

/// A built library.
pub struct Library {
    /// For which platform.
    pub platform: &'static Platform,
    /// Its file.
    pub path: PathBuf,
}

/// Builds the wanted libraries from the checkout in `source` into `target`, checks each, and says what was left out and why.
/// `scene`: the words of the start values (`fmu/src/starts.rs`).
pub fn build(source: &Path, target: &Path, targets: Targets, scene: Option<&str>) -> Result<Vec<Library>, String> {
    let host = host()?;
    compile(source, &["--target-dir", &target.to_string_lossy()], &own(), &[], scene)?;
    let mut built = vec![Library { platform: host, path: target.join("ship").join(host.built) }];
    if targets == Targets::All {
        let cross = target.join("cross");
        let mut wanted = Vec::new();
        for platform in PLATFORMS.iter().filter(|platform| platform.triple != host.triple) {
            match compiler(platform) {
                Ok(compiler) => wanted.push((platform, compiler)),
                Err(reason) => println!("  {}: skipped, {reason}", platform.fmi2),
            }
        }
        // Those with the same compiler are built side by side.
        while let Some((_, compiler)) = wanted.first().cloned() {
            let (now, later): (Vec<_>, Vec<_>) = wanted.into_iter().partition(|(_, other)| *other == compiler);
            let platforms: Vec<_> = now.into_iter().map(|(platform, _)| platform).collect();
            compile(source, &["--target-dir", &cross.to_string_lossy()], &compiler, &platforms, scene)?;
            built.extend(platforms.into_iter().map(|platform| Library {
                platform,
                path: cross.join(platform.triple).join("ship").join(platform.built),
            }));
            wanted = later;
        }
    }
    let mut functions = BTreeSet::new();
    for library in &built {
        let (exported, said) = check(library).map_err(|what| format!("{}: {what}", library.path.display()))?;
        println!("  {}: {said}", library.platform.fmi2);
        if library.platform.extension == "so" {
            println!("figure 26: {}: {}", library.platform.fmi2, said.rsplit(' ').next().unwrap_or_default());
        }
        if !functions.is_empty() && functions != exported {
            return Err(format!("{} does not export what the others do", library.path.display()));
        }
        functions = exported;
    }
    Ok(built)
}

/// The platform that this program runs on.
pub fn host() -> Result<&'static Platform, String> {
    let (machine, system) = (std::env::consts::ARCH, std::env::consts::OS);
    PLATFORMS
        .iter()
        .find(|platform| platform.triple.starts_with(machine) && platform.triple.contains(system))
        .ok_or(format!("no FMU platform is defined for {machine} with {system}"))
}

/// A compiler for a target.
#[derive(Clone, PartialEq)]
pub struct Compiler {
    cargo: OsString,
    /// Only where it is not the one that this cargo comes with.
    rustc: Option<PathBuf>,
    /// It has no compiled `core` for the target but the source of it.
    build_core: bool,
}

impl Compiler {
    /// Cargo, told to use this compiler; options that the kind of compiler needs come with [`Compiler::options`].
    pub fn command(&self) -> Command {
        let mut command = Command::new(&self.cargo);
        if let Some(rustc) = &self.rustc {
            command.env_remove("RUSTUP_TOOLCHAIN").env("RUSTC", rustc);
        }
        if self.build_core {
            // Not stable: this variable allows it, for these libraries only.
            command.env("RUSTC_BOOTSTRAP", "1");
        }
        command
    }

    /// Options behind cargo's subcommand.
    pub fn options(&self) -> &'static [&'static str] {
        if self.build_core { &["-Zbuild-std=core"] } else { &[] }
    }
}

/// The compiler that built this program, for this platform.
pub fn own() -> Compiler {
    let cargo = crate::tools::cargo_program();
    Compiler { cargo, rustc: None, build_core: false }
}

/// A compiler for another platform: ours if it has the target (`rustup target add`), else ours or the distribution's with the
/// source of `core` (`rustup component add rust-src`; Debian: rustc-web, cargo-web and rust-web-src).
fn compiler(platform: &Platform) -> Result<Compiler, String> {
    let [linker, package] = platform.linker;
    if Command::new(linker).arg("--version").output().is_err() {
        return Err(format!("{linker} is missing (Debian: {package})"));
    }
    compiler_for(platform.triple)
}

/// The same for any target, whatever links for it.
pub fn compiler_for(triple: &str) -> Result<Compiler, String> {
    let ours = std::env::var_os("RUSTC").map_or("rustc".into(), PathBuf::from);
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

/// Major and minor number in a text like "rustc 1.96.0 (...)".
fn version(text: &str) -> Option<(u32, u32)> {
    let number = text.split_whitespace().find(|word| word.starts_with(|c: char| c.is_ascii_digit()))?;
    let mut parts = number.split('.').map(|part| part.parse().ok());
    Some((parts.next()??, parts.next()??))
}

/// Builds the library in its shipped form, for this platform if `others` names none.
fn compile(source: &Path, place: &[&str], compiler: &Compiler, others: &[&Platform], scene: Option<&str>) -> Outcome {
    let mut command = compiler.command();
    match scene {
        Some(words) => command.env("FABRIC_FMU_SCENE", words),
        None => command.env_remove("FABRIC_FMU_SCENE"),
    };
    command
        .args(["build", "--quiet", "--locked", "--profile", "ship", "-p", "fmu-lib", "--features", "bare"])
        .args(place)
        .args(compiler.options())
        .current_dir(source);
    for platform in others {
        command.args(["--target", platform.triple]);
        let variable = |what: &str| format!("CARGO_TARGET_{}_{what}", platform.triple.to_uppercase().replace('-', "_"));
        if std::env::var_os(variable("LINKER")).is_none() {
            command.env(variable("LINKER"), platform.linker[0]);
        }
        if platform.extension == "dll" {
            // The same source gives the same bytes, whenever it is built.
            command.env(variable("RUSTFLAGS"), "-Clink-arg=-Wl,--no-insert-timestamp");
        }
    }
    let status = command.status().map_err(|error| format!("cannot start cargo: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("building fmu-lib failed ({status})")) }
}

/// What a library of ours may ask of Linux, besides the weak names of the linker's start-up code.
pub const FROM_LINUX: [&str; 8] = ["calloc", "free", "memcpy", "memmove", "memset", "memcmp", "bcmp", "strlen"];
/// The libraries it may ask of Windows; what of them depends on the linker's own start-up code, mathematics excepted.
const FROM_WINDOWS: [&str; 2] = ["KERNEL32.dll", "msvcrt.dll"];
const MATHEMATICS: [&str; 12] =
    ["exp", "log", "pow", "sqrt", "sin", "cos", "tan", "acos", "asin", "atan", "atan2", "floor"];
/// Number of functions: 34 of FMI 2.0 for co-simulation and 75 of FMI 3.0.
const FUNCTIONS: usize = 109;
/// Newest version of the GNU C library whose symbols may be used.
const GLIBC: (u32, u32) = (2, 17);

/// The exported functions, and a line about the library; an error if it exports or imports what it should not.
fn check(library: &Library) -> Result<(BTreeSet<String>, String), String> {
    let data = std::fs::read(&library.path).map_err(|error| error.to_string())?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let name = |name: NameOrOrdinal<&[u8]>| match name {
        NameOrOrdinal::Name(name) => text(name),
        NameOrOrdinal::Ordinal(number) => format!("number {number}"),
    };
    let file = object::File::parse(&*data).map_err(|error| error.to_string())?;
    let mut exported = BTreeSet::new();
    for export in file.exports().map_err(|error| error.to_string())? {
        exported.insert(name(export.map_err(|error| error.to_string())?.name()));
    }
    if exported.len() != FUNCTIONS || !exported.iter().all(|name| name.starts_with("fmi2") || name.starts_with("fmi3"))
    {
        return Err(format!("exports {} symbols instead of the {FUNCTIONS} functions: {exported:?}", exported.len()));
    }
    let windows = library.platform.extension == "dll";
    let mut needs = BTreeSet::new();
    for import in file.imports().map_err(|error| error.to_string())? {
        let import = import.map_err(|error| error.to_string())?;
        let (wanted, from) = (name(import.name()), text(import.library()));
        let allowed = if windows {
            FROM_WINDOWS.contains(&&*from) && !MATHEMATICS.contains(&&*wanted)
        } else {
            import.is_weak() || FROM_LINUX.contains(&&*wanted)
        };
        if !allowed {
            return Err(format!("imports {wanted} {from}"));
        }
        if windows {
            needs.insert(from);
        }
    }
    let mut floor = None;
    if !windows {
        // The table of strings has the names of the libraries it needs, and of the versions of their symbols.
        let strings = file.section_by_name(".dynstr").and_then(|section| section.data().ok()).unwrap_or_default();
        for word in strings.split(|&byte| byte == 0).map(text) {
            if let Some(number) = word.strip_prefix("GLIBC_") {
                floor = floor.max(version(number));
            } else if word.contains(".so") && word != library.platform.built {
                // Some linkers note the library's own name.
                needs.insert(word);
            }
        }
        if floor.is_none_or(|floor| floor > GLIBC) || !needs.iter().eq(["libc.so.6"]) {
            return Err(format!(
                "needs {needs:?} with symbols of version {floor:?}, allowed is libc.so.6 up to {GLIBC:?}"
            ));
        }
    }
    let needs = needs.into_iter().collect::<Vec<_>>().join(", ");
    let symbols = floor.map_or(String::new(), |(major, minor)| format!(" {major}.{minor}"));
    Ok((exported, format!("{} bytes, {FUNCTIONS} functions exported, needs {needs}{symbols}", data.len())))
}

/// Builds everything again in another folder; every library must have the same bytes.
pub fn reproduced(libraries: &[Library], targets: Targets) -> Result<(PathBuf, Vec<Library>), String> {
    let elsewhere = tools::target().join("elsewhere");
    let copy = elsewhere.join("a-copy-of-the-checkout");
    let _ = std::fs::remove_dir_all(&elsewhere);
    for name in output("git", &["ls-files", "--cached", "--others", "--exclude-standard"])?.lines() {
        let (from, to) = (tools::top().join(name), copy.join(name));
        let folder = to.parent().unwrap_or(&copy);
        tools::make_folder(folder.to_path_buf())?;
        std::fs::copy(&from, &to).map_err(|error| format!("{}: {error}", from.display()))?;
    }
    let again = build(&copy, &elsewhere.join("target"), targets, None)?;
    for (one, other) in libraries.iter().zip(&again) {
        let read = |path: &Path| std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()));
        if read(&one.path)? != read(&other.path)? {
            return Err(format!("{} and {} differ", one.path.display(), other.path.display()));
        }
    }
    Ok((copy, again))
}

#[cfg(test)]
mod tests {
    use super::version;

    #[test]
    fn versions_are_read_and_ordered() {
        assert_eq!(version("rustc 1.96.0 (6b00bc388 2026-06-23) (built from a source tarball)"), Some((1, 96)));
        assert_eq!(version("rustc 1.63.0"), Some((1, 63)));
        assert_eq!(version("2.14"), Some((2, 14)));
        assert!(version("2.2.5") < version("2.14"));
        assert_eq!(version("PRIVATE"), None);
    }
}
