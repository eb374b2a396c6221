//! `cargo xtask demo`: a rotorburst fragment, flown by a host in Python, hits the fabric FMU, one ply of it
//! and a pack that stops it; tables, plots and a report come out.

use crate::platforms::Targets;
use crate::tools::{Outcome, bail, python, said, sh, target};
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
    let out = target().join(folder);
    let python = std::thread::scope(|scope| {
        // The pictures of the sheet are made with the package, which compiles beside FMU and flight.
        let package = scope.spawn(crate::wheel::installed);
        crate::fmu::packed(Targets::Host, false)?;
        let python = python()?;
        let fmu = target().join("fmu/FabricShield-fmi2.fmu");
        let fly = |out: &Path, plies: &str| -> Outcome {
            let flight = sh!("{python} {PROGRAMS}/rotorburst.py --case {case} --plies {plies} --fmu {fmu} --out {out}");
            Ok(flight.run()?)
        };
        said("Flying the fragment at one ply and at the pack", || {
            std::thread::scope(|scope| {
                let other = scope.spawn(|| fly(&out.join("pack"), pack));
                fly(&out, "1")?;
                other.join().unwrap_or_else(|_| bail!("the flight at the pack broke off"))
            })
        })?;
        package.join().unwrap_or_else(|_| bail!("the build of the package broke off"))
    })?;
    said("Drawing the report", || Ok(sh!("{python} {PROGRAMS}/report.py {out}").run()?))
}
