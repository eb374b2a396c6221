//! The caller's memory: too short, too long, dirty, oddly aligned.

use fabric::{Code, Memory, Scene, Sim};
use fabric_tests::{Buffers, small_sheet};
use std::mem::MaybeUninit;

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

/// Made in place or returned: the same simulation. A refusal leaves what the memory holds.
#[test]
fn a_simulation_made_in_its_place_is_the_same() {
    let scene = scene();
    let mut too_fast = scene;
    too_fast.projectile.velocity[2] = 1e6;
    let mut memory = Buffers::of(&scene);
    memory.reals.fill(7.5);
    let refused = Sim::new_in(&mut MaybeUninit::uninit(), &too_fast, memory.memory()).err();
    assert_eq!(refused.map(|error| error.code), Some(Code::ProjectileTooFast));
    assert!(memory.reals.iter().all(|&number| number == 7.5));
    let mut place = MaybeUninit::uninit();
    let sim = Sim::new_in(&mut place, &scene, memory.memory()).unwrap();
    sim.advance(500).unwrap();
    assert_eq!(sim.digest(), digest_of(Buffers::of(&scene).memory()));
}

/// Memory, bands' scratch and images of every length below what is needed, of the smallest scene there is, and of a usual one
/// without one number, or without any: refused, and no byte written, inside or beside it.
#[test]
fn every_shorter_length_is_refused_and_nothing_is_written() {
    const GUARD: usize = 16;
    let mut tried = 0;
    for (scene, all) in [(small_sheet(2, 100.0), true), (scene(), false)] {
        let lengths = |need: usize| if all { (0..need).collect() } else { vec![0, need - 1] };
        let mut good = Buffers::of(&scene);
        let (n, m) = (good.reals.len(), good.words.len());
        let (mut reals, mut words) = (vec![7.5; n + GUARD], vec![75; m + GUARD]);
        let enough = lengths(n).into_iter().map(|short| (short, m, "memory.reals"));
        let shorter = enough.chain(lengths(m).into_iter().map(|short| (n, short, "memory.words")));
        for (short_reals, short_words, field) in shorter.chain([(0, 0, "memory.reals")]) {
            let memory = Memory { reals: &mut reals[..short_reals], words: &mut words[..short_words] };
            let error = Sim::new(&scene, memory).err().unwrap();
            assert_eq!((error.code, error.field), (Code::ShortBuffer, field));
            assert!(reals.iter().all(|&x| x == 7.5) && words.iter().all(|&x| x == 75));
            tried += 1;
        }

        let mut sim = good.sim(&scene);
        let need = sim.snapshot_bytes();
        // Images may lie at any address: seven beside the usual one.
        let mut image = vec![0xa5; need + GUARD];
        let (length, shift) = (lengths(need), [0, 1, 2, 3, 4, 5, 6, 7]);
        for (short, at) in length.into_iter().flat_map(|short| shift.map(|at| (short, at))) {
            let error = sim.save(&mut image[at..at + short]).unwrap_err();
            assert_eq!((error.code, error.field), (Code::ShortBuffer, "image"));
            assert!(image.iter().all(|&byte| byte == 0xa5));
            tried += 1;
        }
        let digest = sim.digest();
        for at in shift {
            image.fill(0xa5);
            sim.save(&mut image[at..at + need]).unwrap();
            assert!(image[..at].iter().chain(&image[at + need..]).all(|&byte| byte == 0xa5));
            sim.reset();
            sim.load(&image[at..at + need]).unwrap();
            assert_eq!(sim.digest(), digest);
        }

        let need = sim.layout().band_reals(2).unwrap();
        let mut scratch = vec![7.5; need + GUARD];
        for short in lengths(need) {
            let error = sim.bands(&mut scratch[..short], 2).err().unwrap();
            assert_eq!((error.code, error.field), (Code::ShortBuffer, "scratch"));
            assert!(scratch.iter().all(|&x| x == 7.5));
            tried += 1;
        }
        assert_eq!(sim.digest(), digest);
    }
    println!("figure 10: {tried} short buffers in Rust, {tried} refused with nothing written");
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
