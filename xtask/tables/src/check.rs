//! What the FMU's library of a platform may ask of its host, and offers to it.

use object::read::macho::{LoadCommandVariant, MachOFile64};
use object::{Endianness, NameOrOrdinal, Object, ObjectSection, macho};
use std::collections::BTreeSet;
use xtask::targets::{BINDER, FROM_LINUX, FROM_MACOS, LIBSYSTEM, MACOS, Target, of};
use xtask::tools::{Context as _, Outcome, ensure, shell, version};

/// The libraries it may ask of Windows; what of them depends on the linker's own start-up code, mathematics
/// excepted.
const FROM_WINDOWS: [&str; 2] = ["KERNEL32.dll", "msvcrt.dll"];
const MATHEMATICS: [&str; 12] =
    ["exp", "log", "pow", "sqrt", "sin", "cos", "tan", "acos", "asin", "atan", "atan2", "floor"];
/// Number of functions: 34 of FMI 2.0 for co-simulation and 75 of FMI 3.0.
const FUNCTIONS: usize = 109;
/// Newest version of the GNU C library whose symbols may be used.
const GLIBC: (u32, u32) = (2, 17);

/// Checks libraries, `TRIPLE=FILE` each: all export the same.
pub fn run(libraries: &[&str]) -> Outcome {
    let mut functions = BTreeSet::new();
    for library in libraries {
        let (triple, path) = library.split_once('=').context("TRIPLE=FILE is wanted")?;
        let platform = of(triple)?;
        let (exported, said) = check(platform, path).with_context(|| path.to_string())?;
        println!("  {}: {said}", platform.fmu[0]);
        ensure!(functions.is_empty() || functions == exported, "{path} does not export what the others do");
        functions = exported;
    }
    Ok(())
}

/// The exported functions, and a line about the library; an error if it exports or imports what it should
/// not.
fn check(platform: &Target, path: &str) -> Outcome<(BTreeSet<String>, String)> {
    let data = shell().read_binary_file(path)?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let name = |name: NameOrOrdinal<&[u8]>| match name {
        NameOrOrdinal::Name(name) => text(name),
        NameOrOrdinal::Ordinal(number) => format!("number {number}"),
    };
    let file = object::File::parse(&*data)?;
    let kind = platform.extension;
    // Names in C begin so in the files of macOS.
    let underscore = if kind == "dylib" { "_" } else { "" };
    let mut exported = BTreeSet::new();
    for export in file.exports()? {
        let export = name(export?.name());
        exported.insert(export.strip_prefix(underscore).unwrap_or(&export).to_string());
    }
    let fmi = exported.iter().filter(|name| name.starts_with("fmi2") || name.starts_with("fmi3")).count();
    ensure!([fmi, exported.len()] == [FUNCTIONS; 2], "exports not the {FUNCTIONS} functions but {exported:?}");
    let mut needs = BTreeSet::new();
    for import in file.imports()? {
        let import = import?;
        let (wanted, from) = (name(import.name()), text(import.library()));
        let allowed = match kind {
            "dll" => FROM_WINDOWS.contains(&&*from) && !MATHEMATICS.contains(&&*wanted),
            "dylib" => {
                let function = wanted.strip_prefix(underscore).unwrap_or_default();
                from == LIBSYSTEM
                    && (FROM_LINUX.contains(&function) || FROM_MACOS.contains(&function) || wanted == BINDER)
            }
            _ => import.is_weak() || FROM_LINUX.contains(&&*wanted),
        };
        ensure!(allowed, "imports {wanted} {from}");
        if kind != "so" {
            needs.insert(from);
        }
    }
    let mut floor = None;
    if let object::File::MachO64(file) = &file {
        check_macos(file, platform)?;
        floor = Some(MACOS);
    } else if kind == "so" {
        // The table of strings has the names of the libraries it needs, and of the versions of their symbols.
        let strings = file.section_by_name(".dynstr").and_then(|section| section.data().ok()).unwrap_or_default();
        for word in strings.split(|&byte| byte == 0).map(text) {
            if let Some(number) = word.strip_prefix("GLIBC_") {
                floor = floor.max(version(number));
            } else if word.contains(".so") && word != platform.library() {
                // Some linkers note the library's own name.
                needs.insert(word);
            }
        }
        let allowed = floor.is_some_and(|floor| floor <= GLIBC) && needs.iter().eq(["libc.so.6"]);
        ensure!(allowed, "needs {needs:?} with symbols of version {floor:?}, allowed is libc.so.6 up to {GLIBC:?}");
    }
    let needs = needs.into_iter().collect::<Vec<_>>().join(", ");
    let system = if kind == "so" { " of the GNU C library" } else { " of macOS" };
    let symbols = floor.map_or(String::new(), |(major, minor)| format!("{system} {major}.{minor}"));
    Ok((exported, format!("{} bytes, {FUNCTIONS} functions exported, needs {needs}{symbols}", data.len())))
}

/// Whether macOS would take the library: its oldest version, the name without a folder of ours, the library
/// it needs, and for Arm the signature that every program there must have, made by the linker without a key
/// ("ad hoc").
/// The layout of a signature: cs_blobs.h of Apple's XNU.
fn check_macos(file: &MachOFile64<Endianness>, platform: &Target) -> Outcome {
    let endian = file.endian();
    let (mut oldest, mut own_name, mut needs, mut signed) = (None, None, Vec::new(), false);
    let mut commands = file.macho_load_commands()?;
    while let Some(command) = commands.next()? {
        let name = |name| command.string(endian, name).map(|name| String::from_utf8_lossy(name).into_owned());
        match command.variant()? {
            LoadCommandVariant::BuildVersion(version, _) if version.platform.get(endian) == macho::PLATFORM_MACOS => {
                let packed = version.minos.get(endian).0;
                oldest = Some((packed >> 16, packed >> 8 & 0xff));
            }
            LoadCommandVariant::IdDylib(own) => own_name = name(own.dylib.name).ok(),
            LoadCommandVariant::Dylib(other) => needs.extend(name(other.dylib.name)),
            LoadCommandVariant::LinkeditData(place) if command.cmd() == macho::LC_CODE_SIGNATURE => {
                let start = place.dataoff.get(endian);
                let data = file.data().get(start as usize..).unwrap_or_default();
                let word = |at: u32| {
                    let bytes =
                        data.get(at as usize..).and_then(|data| data.first_chunk()).copied().unwrap_or_default();
                    u32::from_be_bytes(bytes)
                };
                // A set of blobs, the first of which lists the hashes of the pages: it must reach to where
                // the signature begins.
                let list = word(16);
                let adhoc = word(list.saturating_add(12)) & 2 != 0;
                signed = word(0) == 0xfade_0cc0
                    && word(list) == 0xfade_0c02
                    && adhoc
                    && word(list.saturating_add(32)) == start
                    && word(list.saturating_add(28)) == start.div_ceil(4096)
                    && data.len() == place.datasize.get(endian) as usize;
            }
            _ => {}
        }
    }
    let named = format!("@rpath/{}", platform.library());
    let right = oldest == Some(MACOS) && own_name.as_ref() == Some(&named) && needs == [LIBSYSTEM];
    ensure!(right, "calls itself {own_name:?}, is for macOS {oldest:?} and needs {needs:?}");
    ensure!(signed || !platform.triple.starts_with("aarch64"), "has no ad-hoc signature of all its pages");
    Ok(())
}
