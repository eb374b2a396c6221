//! The caller's memory: too short, too long, dirty.

use fabric::{CacheLine, Code, Scene, Sim};
use fabric_tests::{Buffers, small_sheet};
use std::mem::MaybeUninit;

/// What memory holds before.
const SEVENS: CacheLine = CacheLine([7.5; 8]);

fn scene() -> Scene {
    let mut scene = small_sheet(19, 200.0);
    scene.yarn.stochastic = true;
    scene
}

fn digest_of(memory: &mut [CacheLine]) -> u64 {
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
    memory.lines.fill(SEVENS);
    let refused = Sim::new_in(&mut MaybeUninit::uninit(), &too_fast, &mut memory.lines).err();
    assert_eq!(refused.map(|error| error.code), Some(Code::ProjectileTooFast));
    assert!(memory.lines.iter().all(|&line| line == SEVENS));
    let mut place = MaybeUninit::uninit();
    let sim = Sim::new_in(&mut place, &scene, &mut memory.lines).unwrap();
    sim.advance(500).unwrap();
    assert_eq!(sim.digest(), digest_of(&mut Buffers::of(&scene).lines));
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
        let need = good.lines.len();
        let mut lines = vec![SEVENS; need + GUARD];
        for short in lengths(need) {
            let error = Sim::new(&scene, &mut lines[..short]).err().unwrap();
            assert_eq!((error.code, error.field), (Code::ShortBuffer, "memory"));
            assert!(lines.iter().all(|&line| line == SEVENS));
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

        let need = sim.layout().band_lines(2).unwrap();
        let mut scratch = vec![SEVENS; need + GUARD];
        for short in lengths(need) {
            let error = sim.bands(&mut scratch[..short], 2, 0).err().unwrap();
            assert_eq!((error.code, error.field), (Code::ShortBuffer, "scratch"));
            assert!(scratch.iter().all(|&line| line == SEVENS));
            tried += 1;
        }
        assert_eq!(sim.digest(), digest);
    }
    println!("figure 10: {tried} short buffers in Rust, {tried} refused with nothing written");
}

#[test]
fn longer_and_dirty_memory_gives_the_same_bits() {
    let mut clean = Buffers::of(&scene());
    let need = clean.lines.len();
    let expected = digest_of(&mut clean.lines);
    // A line of NaN with all bits set is u32::MAX where integers are kept.
    for dirt in [f64::NAN, f64::NEG_INFINITY, 1e300, f64::from_bits(u64::MAX)] {
        let mut lines = vec![CacheLine([dirt; 8]); 3 * need];
        assert_eq!(digest_of(&mut lines[..need]), expected);
        assert_eq!(digest_of(&mut lines), expected);
        // The same memory again, as the last run left it.
        assert_eq!(digest_of(&mut lines), expected);
    }
}

/// Nothing is written outside the part that the layout asks for.
#[test]
fn memory_beyond_the_layout_is_not_touched() {
    let need = Buffers::of(&scene()).lines.len();
    let mut lines = vec![SEVENS; need + 8];
    digest_of(&mut lines);
    assert!(lines[need..].iter().all(|&line| line == SEVENS));
}
