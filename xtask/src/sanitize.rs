//! `cargo xtask sanitize`: the library's tests in Rust under AddressSanitizer, those with threads under
//! ThreadSanitizer.

use crate::tools::{Outcome, ensure, sh, shell, target};

/// A sanitizer, the tests that run under it, and a program in which it must find what is wrong.
struct Sanitizer {
    name: &'static str,
    tests: &'static [&'static [&'static str]],
    wrong: &'static str,
    finding: &'static str,
}

const SANITIZERS: [Sanitizer; 2] = [
    Sanitizer {
        name: "address",
        tests: &[
            &["-p", "fabric-kernel", "--lib", "--features", "micro,internals"],
            &["-p", "fabric-host", "-p", "fabric-capi", "-p", "fabric-fmu", "-p", "fabric-fuzz", "--lib", "--tests"],
            &["-p", "fabric-tests", "--test", "robustness", "--test", "golden"],
        ],
        wrong: "fn main() { let x = vec![1_u8; 8]; println!(\"{}\", unsafe { *std::hint::black_box(x.as_ptr()).add(8) }); }",
        finding: "heap-buffer-overflow",
    },
    Sanitizer {
        name: "thread",
        tests: &[&["-p", "fabric-tests", "--test", "robustness", "--", "--test-threads=1", "bands::"]],
        wrong: "static mut X: u64 = 0; fn add() { for _ in 0..1000 { unsafe { X += 1 } } } \
                fn main() { let other = std::thread::spawn(add); add(); other.join().unwrap(); }",
        finding: "data race",
    },
];

/// The test harness hands over results through a channel of the standard library.
const NOT_OURS: &str = "race:test::event::CompletedTest\n";

/// Runs both. The standard library is as it comes, for its source is not part of the compiler: only what is
/// compiled here is watched.
pub fn run() -> Outcome {
    let (platform, folder) = (sh!("rustc --print host-tuple").read()?, target().join("sanitize"));
    let known = folder.join("known");
    shell().write_file(&known, NOT_OURS)?;
    for Sanitizer { name, tests, wrong, finding } in SANITIZERS {
        let flags = format!("-Zsanitizer={name} -Cunsafe-allow-abi-mismatch=sanitizer");
        awake(&flags, wrong, finding)?;
        for tests in tests.iter().copied() {
            println!("{name}: {}", tests.join(" "));
            // With --target build scripts and macros are compiled without it.
            let command = sh!("cargo test --quiet --target {platform} --target-dir {folder} {tests...}");
            // A sanitizer is no stable feature of the compiler.
            let command = command.env("RUSTC_BOOTSTRAP", "1").env("RUSTFLAGS", &flags);
            // Tests let go of memory with `leak` for their simulations; the library allocates none.
            let command = command.env("ASAN_OPTIONS", "detect_leaks=0");
            command.env("TSAN_OPTIONS", format!("suppressions={}", known.display())).run()?;
        }
        println!("figure 29: {name} sanitizer: 0 findings");
    }
    Ok(())
}

/// A wrong program, compiled in the same way, is found out.
fn awake(flags: &str, wrong: &str, finding: &str) -> Outcome {
    let folder = target().join("sanitize");
    let (source, program, flags) = (folder.join("wrong.rs"), folder.join("wrong"), flags.split(' '));
    shell().write_file(&source, wrong)?;
    let compiler = sh!("rustc --edition=2021 -Astatic_mut_refs {flags...} {source} -o {program}");
    compiler.env("RUSTC_BOOTSTRAP", "1").run()?;
    let ended = sh!("{program}").ignore_status().output()?;
    let said = String::from_utf8_lossy(&ended.stderr);
    let found = !ended.status.success() && said.contains(finding);
    ensure!(found, "the sanitizer finds no {finding} in a wrong program: {said}");
    Ok(())
}
