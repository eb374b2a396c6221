//! The caller's memory: too short, too long, dirty, oddly aligned.

use fabric::{Code, Memory, Scene, Sim};
use fabric_tests::{Buffers, small_sheet};

fn scene() -> Scene {
    let mut scene = small_sheet(19, 200.0);
    scene.yarn.stochastic = true;
    scene
}

fn digest_of(memory: Memory<'_>) -> u64 {
    let mut sim = Sim::new(&scene(), memory).unwrap();
    sim.advance(500).unwrap();
    assert!(sim.counters().failed_segments > 0);
    sim.digest()
}

#[test]
fn short_memory_is_refused_and_not_written() {
    let scene = scene();
    let Buffers { mut reals, mut words } = Buffers::of(&scene);
    reals.fill(7.5);
    words.fill(75);
    let (n, m) = (reals.len(), words.len());
    for (short_reals, short_words, field) in [
        (n - 1, m, "memory.reals"),
        (0, m, "memory.reals"),
        (n, m - 1, "memory.words"),
        (n, 0, "memory.words"),
        (0, 0, "memory.reals"),
    ] {
        let memory = Memory { reals: &mut reals[..short_reals], words: &mut words[..short_words] };
        let error = Sim::new(&scene, memory).err().unwrap();
        assert_eq!((error.code, error.field), (Code::ShortBuffer, field));
    }
    assert!(reals.iter().all(|&x| x == 7.5) && words.iter().all(|&x| x == 75));
}

#[test]
fn longer_dirty_and_misaligned_memory_gives_the_same_bits() {
    let scene = scene();
    let mut clean = Buffers::of(&scene);
    let (n, m) = (clean.reals.len(), clean.words.len());
    let expected = digest_of(clean.memory());
    for offset in 0..8 {
        for dirt in [f64::NAN, f64::NEG_INFINITY, 1e300] {
            let mut reals = vec![dirt; n + offset];
            let mut words = vec![u32::MAX; m + offset];
            let memory = Memory { reals: &mut reals[offset..], words: &mut words[offset..] };
            assert_eq!(digest_of(memory), expected, "offset {offset}");
        }
    }
    let mut reals = vec![f64::NAN; 3 * n];
    let mut words = vec![u32::MAX; 3 * m];
    assert_eq!(digest_of(Memory { reals: &mut reals, words: &mut words }), expected);
    // The same memory again, as the last run left it.
    assert_eq!(digest_of(Memory { reals: &mut reals, words: &mut words }), expected);
}

/// Nothing is written outside the part that the layout asks for.
#[test]
fn memory_beyond_the_layout_is_not_touched() {
    let scene = scene();
    let Buffers { reals, words } = Buffers::of(&scene);
    let (n, m) = (reals.len(), words.len());
    let mut reals = vec![7.5; n + 64];
    let mut words = vec![75; m + 64];
    digest_of(Memory { reals: &mut reals[..n + 64], words: &mut words[..m + 64] });
    assert!(reals[n..].iter().all(|&x| x == 7.5) && words[m..].iter().all(|&x| x == 75));
}
