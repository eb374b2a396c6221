//! Every committed input once more, without libFuzzer: the corpora, and what once broke something (`regressions`).

use fabric_fuzz::TARGETS;
use std::path::Path;

/// Runs every file of a folder through a target; counts them, and those that stepped a simulation.
fn replay(folder: &Path, run: fn(&[u8]) -> bool) -> (usize, usize) {
    let (mut all, mut deep) = (0, 0);
    for entry in std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.unwrap().path();
        let data = std::fs::read(&path).unwrap();
        println!("{}", path.display()); // shown if it fails
        all += 1;
        deep += usize::from(run(&data));
    }
    (all, deep)
}

#[test]
fn corpora_and_regressions() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (name, run) in TARGETS {
        let (all, deep) = replay(&top.join("corpus").join(name), *run);
        println!("{name}: {all} inputs, {deep} of them stepped a simulation");
        assert!(all >= 20 && 4 * deep >= all, "{name}: {deep} of {all} inputs stepped a simulation");
        let regressions = top.join("regressions").join(name);
        if regressions.exists() {
            replay(&regressions, *run);
        }
    }
}

#[test]
fn random_bytes() {
    for (name, run) in TARGETS {
        // A linear congruential generator: any bytes will do.
        let mut state = 1_u64;
        let mut byte = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        };
        let mut deep = 0;
        for _ in 0..500 {
            let length = byte() as usize;
            let data: Vec<u8> = (0..length).map(|_| byte()).collect();
            deep += usize::from(run(&data));
        }
        println!("{name}: 500 random inputs, {deep} of them stepped a simulation");
        assert!(deep >= 100, "{name}: {deep}");
    }
}
