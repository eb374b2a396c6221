//! `cargo xtask demo`: a rotorburst fragment, flown by a host in Python, hits the fabric FMU, one ply of it
//! and a pack that stops it; tables, plots and a report come out.

use crate::platforms::Targets;
use crate::tools::{self, Outcome};
use std::path::Path;

#[derive(clap::Args)]
pub struct Options {
    /// The 3 in sheet and a disc sector of half the size instead of the 10 in sheet: some seconds instead of
    /// a minute; writes target/demo-quick instead of target/demo.
    #[arg(long)]
    pub quick: bool,
}

/// The programs that it runs.
pub const PROGRAMS: &str = "examples/rotorburst";

pub fn run(options: &Options) -> Outcome {
    crate::needs::demo()?;
    // The pack: bonded plies that stopped the fragment at each of four speeds close together, found by hand.
    let (folder, case, pack) = if options.quick { ("demo-quick", "small", "8") } else { ("demo", "disc", "16") };
    let out = tools::target().join(folder);
    let text = |path: &Path| path.to_string_lossy().into_owned();
    let program = |name: &str| text(&tools::top().join(PROGRAMS).join(name));
    let python = std::thread::scope(|scope| {
        // The pictures of the sheet are made with the package, which compiles beside FMU and flight.
        let package = scope.spawn(crate::wheel::installed);
        crate::fmu::packed(Targets::Host, false)?;
        let python = tools::python()?;
        let fmu = text(&tools::target().join("fmu/FabricShield-fmi2.fmu"));
        let fly = |out: &Path, plies: &str| {
            let run = ["--case", case, "--plies", plies, "--fmu", &fmu, "--out", &text(out)];
            tools::run(&python, &[&[&*program("rotorburst.py")], &run[..]].concat())
        };
        tools::said("Flying the fragment at one ply and at the pack", || {
            std::thread::scope(|scope| {
                let other = scope.spawn(|| fly(&out.join("pack"), pack));
                fly(&out, "1").and(other.join().unwrap_or_else(|_| Err("the flight at the pack broke off".into())))
            })
        })?;
        package.join().unwrap_or_else(|_| Err("the build of the package broke off".into()))
    })?;
    tools::said("Drawing the report", || tools::run(&python, &[&program("report.py"), &text(&out)]))
}
