//! `cargo xtask sanitize`: the library's tests in Rust under AddressSanitizer, those with threads under
//! ThreadSanitizer.

use crate::tools::{Outcome, cargo_program, make_folder, output, target, top, wait, write};
use std::process::Command;

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
    let platform = output("rustc", &["--print", "host-tuple"])?;
    for Sanitizer { name, tests, wrong, finding } in SANITIZERS {
        let flags = format!("-Zsanitizer={name} -Cunsafe-allow-abi-mismatch=sanitizer");
        awake(&flags, wrong, finding)?;
        let known = target().join("sanitize/known");
        write(&known, NOT_OURS)?;
        for tests in tests {
            println!("{name}: {}", tests.join(" "));
            let mut command = Command::new(cargo_program());
            // A sanitizer is no stable feature of the compiler. With --target build scripts and macros are
            // compiled without it.
            command.env("RUSTC_BOOTSTRAP", "1").env("RUSTFLAGS", &flags);
            command.args(["test", "--quiet", "--target", platform.trim()]);
            // Tests let go of memory with `leak` for their simulations; the library allocates none.
            command.env("ASAN_OPTIONS", "detect_leaks=0");
            command.env("TSAN_OPTIONS", format!("suppressions={}", known.display()));
            command.arg("--target-dir").arg(target().join("sanitize")).args(*tests).current_dir(top());
            wait(&mut command)?;
        }
        println!("figure 29: {name} sanitizer: 0 findings");
    }
    Ok(())
}

/// A wrong program, compiled in the same way, is found out.
fn awake(flags: &str, wrong: &str, finding: &str) -> Outcome {
    let folder = make_folder(target().join("sanitize"))?;
    let (source, program) = (folder.join("wrong.rs"), folder.join("wrong"));
    write(&source, wrong)?;
    let mut compiler = Command::new("rustc");
    compiler.env("RUSTC_BOOTSTRAP", "1").args(["--edition=2021", "-Astatic_mut_refs"]).args(flags.split(' '));
    crate::tools::finish(compiler.arg(&source).arg("-o").arg(&program))?;
    match output(&program, &[]) {
        Err(said) if said.contains(finding) => Ok(()),
        Err(said) => Err(format!("the sanitizer says of a wrong program only: {said}")),
        Ok(_) => Err(format!("the sanitizer finds no {finding} in a wrong program")),
    }
}
