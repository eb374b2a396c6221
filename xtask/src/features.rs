//! The kernel's cargo features: that it builds without any of them.

use crate::tools::{Outcome, asked, cargo, of_kernel};

/// Sets of features that are more than one and less than all: the kernel's Cargo.toml says what each is for.
const SETS: [&str; 2] = ["paper", "real"];

/// Builds the kernel with nothing, with each feature left out, and with sets that a host may use, and runs the pinned scenes of the
/// first and the last of these. The steps before have done so with all features.
pub fn every_feature_set() -> Outcome {
    let check = |set: &str| {
        println!("  {}", if set.is_empty() { "nothing" } else { set });
        let few = ["check", "--quiet", "--package", "fabric-kernel", "--no-default-features", "--features", set];
        cargo(&few).map_err(|message| format!("features {set:?}: {message}"))
    };
    let listed = asked("xtask-tables", &["features"])?;
    let names: Vec<_> = listed.lines().filter(|name| !name.is_empty()).collect();
    for left_out in &names {
        let others: Vec<_> = names.iter().filter(|name| *name != left_out).copied().collect();
        check(&others.join(","))?;
    }
    for set in [""].iter().chain(&SETS) {
        let tests = ["test", "--quiet", "--package", "fabric-tests", "--test", "golden", "--no-default-features"];
        cargo(&[&tests[..], &["--features", &of_kernel(set)]].concat())?;
    }
    println!(
        "figure 15: each of {} features left out, nothing, and {} build without a warning; pinned scenes of the last {} pass",
        names.len(),
        SETS.join(" and "),
        1 + SETS.len()
    );
    Ok(())
}
