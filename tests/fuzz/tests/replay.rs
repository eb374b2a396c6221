//! Every committed input once more, without libFuzzer: the corpora, an archive a target, and what once broke
//! something (`regressions`).

use fabric_fuzz::TARGETS;
use fabric_fuzz::bytes::Bytes;
use fabric_fuzz::small;
use fabric_kernel::FEATURES;
use std::path::Path;
use std::process::Command;

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
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("corpus").join(name);
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let archive = top.join("corpus").join(format!("{name}.tar.gz"));
        let unpacked = Command::new("tar").arg("-xzf").arg(archive).arg("-C").arg(&folder).status();
        assert!(unpacked.is_ok_and(|status| status.success()));
        let (all, deep) = replay(&folder, *run);
        println!("{name}: {all} inputs, {deep} of them stepped a simulation");
        assert!(all >= 20 && 4 * deep >= all, "{name}: {deep} of {all} inputs stepped a simulation");
        let regressions = top.join("regressions").join(name);
        if regressions.exists() {
            replay(&regressions, *run);
        }
    }
}

/// Random inputs, the same every time: a linear congruential generator, for any bytes will do.
fn random_inputs(count: usize) -> impl Iterator<Item = Vec<u8>> {
    let mut state = 1_u64;
    let mut byte = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    };
    (0..count).map(move |_| (0..byte()).map(|_| byte()).collect())
}

#[test]
fn random_bytes() {
    for (name, run) in TARGETS {
        let deep = random_inputs(4000).filter(|data| run(data)).count();
        println!("{name}: 4000 random inputs, {deep} of them stepped a simulation");
        assert!(deep >= 800, "{name}: {deep}");
    }
}

/// Tests that nearly all scenes do not get to would say nothing: with each feature some must run.
#[test]
fn random_scenes_have_every_feature() {
    let scenes = random_inputs(4000).map(|data| small::scene(&mut Bytes::new(&data)));
    let sound: Vec<_> = scenes.filter(|scene| scene.check_start().is_ok()).collect();
    for record in FEATURES.iter().filter(|record| record.built && !record.asked_by.is_empty()) {
        let count = sound.iter().filter(|scene| record.asked_by(scene).is_some()).count();
        println!("{:?}: {count} of {} scenes", record.feature, sound.len());
        assert!(count >= 20, "{:?}: {count}", record.feature);
    }
}
