//! xtask-binaries: what the commands ask of compiled libraries, and the archives that they pack.

mod check;
mod gates;
mod pack;
mod stack;

use xtask::tools::Outcome;

fn main() -> std::process::ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    xtask::tools::ended(run(&words.iter().map(String::as_str).collect::<Vec<_>>()))
}

fn run(words: &[&str]) -> Outcome {
    match words {
        ["gates"] => gates::run(),
        ["check", "--figures", libraries @ ..] => check::run(libraries, true),
        ["check", libraries @ ..] => check::run(libraries, false),
        ["pack", archive, entries @ ..] => pack::pack(archive, entries),
        // Machine code of libfabric_kernel with a feature, and the stack that it needs, bytes.
        ["kernel", feature] => {
            let library = gates::kernel(feature)?;
            let stack = stack::chains(&library)?.first().map_or(0, |chain| chain.bytes);
            println!("{} {stack}", gates::code(&library)?.bytes);
            Ok(())
        }
        ["archive", library] => {
            println!("{}", gates::of_archive(library.as_ref())?);
            Ok(())
        }
        _ => Err(format!("unknown: {words:?}")),
    }
}
