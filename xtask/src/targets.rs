//! Every target of Rust, other than this machine's own, that something of the project is built for: what
//! compiles and links for it, what runs its programs here, and where an FMU has its library.

use crate::tools::{Context as _, Outcome, ensure, first_found, sh};
use std::path::Path;

pub struct Target {
    pub triple: &'static str,
    pub compiler: Tool,
    pub runner: Tool,
    /// Folders of its library in archives of FMI 2.0 and 3.0. FMI 2.0 has names of its own only for x86
    /// (darwin64 too is x86-64) and takes those of FMI 3.0 for other processors (FMI 2.0.5, 2.3).
    pub fmu: [&'static str; 2],
    /// How a shared library ends; empty where no FMU is built.
    pub extension: &'static str,
    /// The Python package is built for it.
    pub wheel: bool,
    /// Every change is checked on it where its tools are.
    pub checked: bool,
}

/// A program under any of its names, and its packages of Debian and Ubuntu.
#[derive(Clone, Copy)]
pub struct Tool(pub &'static [&'static str], pub &'static str);

impl Tool {
    /// Name of the tool here, or what is missing and how to get it.
    pub fn found(self) -> Outcome<&'static str> {
        first_found(self.0).with_context(|| self.missing())
    }

    /// That it is missing, and how to get it.
    pub fn missing(self) -> String {
        let from = if self.1.is_empty() { "none; rustup's compilers bring it" } else { self.1 };
        format!("{} is missing (Debian: {from})", self.0[0])
    }
}

impl Target {
    /// Name that cargo gives the FMU's library.
    pub fn library(&self) -> String {
        let prefix = if self.extension == "dll" { "" } else { "lib" };
        format!("{prefix}fabric_shield.{}", self.extension)
    }
}

#[rustfmt::skip]
const NOTHING: Target = Target { triple: "", compiler: NONE, runner: NONE, fmu: ["", ""], extension: "", wheel: false, checked: false };
const NONE: Tool = Tool(&[], "");
/// Links for macOS; `platforms.rs` looks for it where rustup puts it.
const RUST_LLD: Tool = Tool(&["rust-lld"], "");

#[rustfmt::skip]
pub const TARGETS: &[Target] = &[
    Target { triple: "x86_64-unknown-linux-gnu", compiler: Tool(&["x86_64-linux-gnu-gcc"], "gcc-x86-64-linux-gnu"), fmu: ["linux64", "x86_64-linux"], extension: "so", wheel: true, ..NOTHING },
    Target { triple: "x86_64-pc-windows-gnu", compiler: Tool(&["x86_64-w64-mingw32-gcc"], "gcc-mingw-w64-x86-64"), runner: Tool(&["wine64", "wine", "/usr/lib/wine/wine64"], "wine64"), fmu: ["win64", "x86_64-windows"], extension: "dll", checked: true, ..NOTHING },
    Target { triple: "aarch64-unknown-linux-gnu", compiler: Tool(&["aarch64-linux-gnu-gcc"], "gcc-aarch64-linux-gnu libc6-dev-arm64-cross"), runner: Tool(&["qemu-aarch64-static"], "qemu-user-static"), fmu: ["aarch64-linux", "aarch64-linux"], extension: "so", wheel: true, checked: true },
    Target { triple: "x86_64-apple-darwin", compiler: RUST_LLD, fmu: ["darwin64", "x86_64-darwin"], extension: "dylib", ..NOTHING },
    Target { triple: "aarch64-apple-darwin", compiler: RUST_LLD, fmu: ["aarch64-darwin", "aarch64-darwin"], extension: "dylib", ..NOTHING },
    // Not gcc-multilib, which cannot be installed beside the compiler for aarch64.
    Target { triple: "i686-unknown-linux-gnu", compiler: Tool(&["i686-linux-gnu-gcc"], "gcc-i686-linux-gnu libc6-dev-i386-cross"), runner: Tool(&["qemu-i386-static"], "qemu-user-static"), checked: true, ..NOTHING },
    Target { triple: "riscv64gc-unknown-linux-gnu", compiler: Tool(&["riscv64-linux-gnu-gcc"], "gcc-riscv64-linux-gnu libc6-dev-riscv64-cross"), runner: Tool(&["qemu-riscv64-static"], "qemu-user-static"), ..NOTHING },
    Target { triple: "thumbv7em-none-eabihf", compiler: Tool(&["arm-none-eabi-gcc"], "gcc-arm-none-eabi"), runner: Tool(&["qemu-system-arm"], "qemu-system-arm"), checked: true, ..NOTHING },
    Target { triple: "wasm32-unknown-unknown", compiler: Tool(&["clang"], "clang"), runner: Tool(&["node"], "nodejs"), checked: true, ..NOTHING },
];

pub fn of(triple: &str) -> Outcome<&'static Target> {
    TARGETS.iter().find(|target| target.triple == triple).with_context(|| format!("targets.rs has no {triple}"))
}

/// What a library of ours may ask of the C library of Linux and macOS, apart from the weak names of
/// Linux's start-up code.
pub const FROM_LINUX: [&str; 8] = ["calloc", "free", "memcpy", "memmove", "memset", "memcmp", "bcmp", "strlen"];
/// What it may ask of macOS too: the compiler calls these in place of some calls of memset.
pub const FROM_MACOS: [&str; 3] = ["bzero", "__bzero", "memset_pattern16"];
/// The library of macOS that has them, and its function that binds a function at its first call.
pub const LIBSYSTEM: &str = "/usr/lib/libSystem.B.dylib";
pub const BINDER: &str = "dyld_stub_binder";
/// Oldest macOS that loads it: the first for Arm.
pub const MACOS: (u32, u32) = (11, 0);

/// What the kernel's C library may ask of its host.
pub const FROM_HOST: [&str; 4] = ["memcpy", "memmove", "memset", "memcmp"];

/// A library may ask its host for these and nothing else, apart from the weak names of the linker's start-up
/// code.
pub fn undefined(library: &Path, allowed: &[&str]) -> Outcome {
    let listed = sh!("nm -D --undefined-only {library}").read()?;
    let names = listed.lines().filter(|line| !line.contains(" w ")).filter_map(|line| line.split_whitespace().last());
    let strangers: Vec<_> =
        names.map(|name| name.split('@').next().unwrap_or(name)).filter(|name| !allowed.contains(name)).collect();
    ensure!(strangers.is_empty(), "{} wants {strangers:?}", library.display());
    Ok(())
}

/// The targets of Rust that are linked or run in a way of their own.
pub const BOARD: &str = "thumbv7em-none-eabihf";
pub const WASM: &str = "wasm32-unknown-unknown";
/// For the library on a Cortex-M7 with double precision: the target alone assumes single precision.
pub const HARD: &str = "-Ctarget-cpu=cortex-m7 -Ctarget-feature=+fp-armv8d16";
