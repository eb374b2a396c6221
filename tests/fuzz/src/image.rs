//! Snapshot images made of any bytes: refused with the target unchanged, or a valid state.

use crate::bytes::Bytes;
use crate::small;
use fabric_kernel::Hash;
use fabric_kernel::{CacheLine, Code, Drive, Layout, Motion, Path, Sim};

/// Words of an image's header.
const HEADER_WORDS: usize = 4;

/// A step or a leg of a path, as the body is driven; a failure is the fuzzer's good luck.
fn go(sim: &mut Sim, bytes: &mut Bytes, steps: u64) {
    if sim.scene().drive == Drive::Free {
        let _ = sim.advance(steps);
        return;
    }
    let Ok(Motion { position, velocity, orientation, angular_velocity }) = sim.projectile() else { return };
    let seconds = 2.0 * steps as f64 * sim.step_limits().dt;
    let end = [0, 1, 2].map(|k| position[k] + seconds * velocity[k]);
    let path = Path {
        first: sim.step_count(),
        steps: 2 * steps,
        end: Motion { position: end, velocity, orientation, angular_velocity },
    };
    // Now and then left off half way: the image then holds a path to go on along.
    let _ = sim.follow(&path, if bytes.once_in(2) { steps } else { 2 * steps });
}

/// Overwrites some words, as the bytes say.
fn edit(image: &mut [u8], bytes: &mut Bytes) {
    let (words, _) = image.as_chunks_mut::<8>();
    let most = words.len();
    for _ in 0..bytes.below(6) {
        let place = (bytes.byte() as usize + 256 * bytes.below(4)) % most;
        let old = u64::from_le_bytes(words[place]);
        let new = match bytes.below(6) {
            0 => old ^ 1 << bytes.below(64),
            1 => bytes.odd_count(old),
            2 => u64::from_le_bytes(words[bytes.below(most.min(256))]),
            3 => bytes.below(4) as u64,
            _ => bytes.odd(f64::from_bits(old)).to_bits(),
        };
        words[place] = new.to_le_bytes();
    }
}

/// Gives a whole image its right checksum, as a forger would.
pub(crate) fn forge(image: &mut [u8]) {
    let (words, _) = image.as_chunks_mut::<8>();
    if let Some((checksum, body)) = words.split_last_mut() {
        let mut hash = Hash::default();
        body.iter().for_each(|word| hash.word(u64::from_le_bytes(*word)));
        *checksum = hash.value().to_le_bytes();
    }
}

/// The target. Past the first check is an image that is accepted.
pub fn run(data: &[u8]) -> bool {
    let mut bytes = Bytes::new(data);
    let scene = small::scene(&mut bytes);
    let Ok(layout) = Layout::of(&scene) else { return false };
    let mut memory = vec![CacheLine::ZERO; layout.lines()];
    let Ok(mut sim) = Sim::new(&scene, &mut memory) else { return false };
    let steps = bytes.below(12) as u64;
    go(&mut sim, &mut bytes, steps);
    let mut sound = vec![0; sim.snapshot_bytes()];
    if sim.save(&mut sound).is_err() {
        return false;
    }
    let sound_digest = sim.digest();
    go(&mut sim, &mut bytes, 2);

    let mut image = sound.clone();
    let kind = bytes.byte();
    match kind % 16 {
        0 => {
            // Any bytes, after the right header or not.
            let from = if bytes.once_in(2) { 8 * HEADER_WORDS } else { 0 };
            image[from..].iter_mut().for_each(|byte| *byte = bytes.byte());
        }
        1 => {
            let length = bytes.word() as usize % (2 * image.len());
            image.resize(length, bytes.byte());
        }
        _ => edit(&mut image, &mut bytes),
    }
    let forged = kind >= 64;
    if forged {
        forge(&mut image);
    }

    let (before, counters, failure) = (sim.digest(), sim.counters(), sim.failure());
    let taken = sim.load(&image);
    if let Err(error) = taken {
        assert!(matches!(error.code, Code::ImageMalformed | Code::ImageOfAnotherScene | Code::ImageInvalid));
        assert!(image != sound, "a sound image refused");
        assert_eq!((sim.digest(), sim.counters(), sim.failure()), (before, counters, failure));
    } else {
        assert!(forged || image == sound, "an altered image accepted");
        assert_eq!(sim.failure(), None);
        // What follows a flag that is 0 is not taken over; all else is, and what is saved loads to the
        // same bits.
        let (mut saved, digest) = (vec![0; image.len()], sim.digest());
        assert_eq!(sim.save(&mut saved), Ok(()));
        assert!(image != sound || saved == image, "not the state of the image");
        assert_eq!(sim.load(&saved), Ok(()));
        assert_eq!(sim.digest(), digest);
        look(&mut sim);
        let before = sim.step_count();
        let steps = 1 + bytes.below(8) as u64;
        let result = sim.advance(steps);
        assert_eq!(result.err(), sim.failure());
        if result.is_ok() {
            assert_eq!(sim.step_count(), before + steps);
            look(&mut sim);
        } else {
            assert_eq!(sim.step(), result);
            assert_eq!(sim.save(&mut saved).map_err(|error| error.code), result.map_err(|failure| failure.code()));
        }
    }
    // From any state back to the sound one.
    assert_eq!(sim.load(&sound), Ok(()));
    assert_eq!(sim.digest(), sound_digest);
    taken.is_ok()
}

/// Read-outs that pass over the sheet; positions, velocities and damage.
pub(crate) fn look(sim: &mut Sim) -> [Vec<f64>; 3] {
    let (mut places, mut segments) = (vec![0.0; 3 * sim.layout().nodes()], vec![0.0; sim.layout().segments()]);
    let mut speeds = places.clone();
    assert!(sim.energy().is_ok() && sim.fabric().is_ok() && sim.momentum_residual().is_ok());
    assert!(sim.copy_positions(&mut places).is_ok() && sim.copy_velocities(&mut speeds).is_ok());
    assert!(sim.copy_stretch(&mut segments).is_ok() && sim.copy_damage(&mut segments).is_ok());
    sim.outcomes();
    [places, speeds, segments]
}
