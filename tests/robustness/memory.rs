//! The caller's memory: too short, or at another place. (`invariance` tries longer and dirty memory.)

use fabric_kernel::{CacheLine, Code, Scene, Sim};
use fabric_tests::{drawn, memory_of, sim_of, small_sheet, stepped};
use std::mem::MaybeUninit;

/// What memory holds before.
const SEVENS: CacheLine = CacheLine([7.5; 8]);

fn scene() -> Scene {
    drawn(small_sheet(19, 200.0))
}

/// Made in place or returned: the same simulation. A refusal leaves what the memory holds.
#[test]
fn a_simulation_made_in_its_place_is_the_same() {
    let scene = scene();
    let mut too_fast = scene;
    too_fast.projectile.velocity[2] = 1e6;
    let mut memory = memory_of(&scene);
    memory.fill(SEVENS);
    let refused = Sim::new_in(&mut MaybeUninit::uninit(), &too_fast, &mut memory).err();
    assert_eq!(refused.map(|error| error.code), Some(Code::ProjectileTooFast));
    assert!(memory.iter().all(|&line| line == SEVENS));
    let mut place = MaybeUninit::uninit();
    let sim = Sim::new_in(&mut place, &scene, &mut memory).unwrap();
    sim.advance(500).unwrap();
    assert_eq!(sim.digest(), stepped(&scene, 500).digest());
}

/// Memory, bands' scratch and images of every length below what is needed, of the smallest scene there is,
/// and of a usual one without one number, or without any: refused, and no byte written, inside or beside it.
#[test]
fn every_shorter_length_is_refused_and_nothing_is_written() {
    const GUARD: usize = 16;
    let mut tried = 0;
    for (scene, all) in [(small_sheet(2, 100.0), true), (scene(), false)] {
        let lengths = |need: usize| if all { (0..need).collect() } else { vec![0, need - 1] };
        let need = memory_of(&scene).len();
        let mut lines = vec![SEVENS; need + GUARD];
        for short in lengths(need) {
            let error = Sim::new(&scene, &mut lines[..short]).err().unwrap();
            assert_eq!((error.code, error.field), (Code::ShortBuffer, "memory"));
            assert!(lines.iter().all(|&line| line == SEVENS));
            tried += 1;
        }

        let mut sim = sim_of(&scene);
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
