//! Capsules made of any bytes: refused by name, or replayed to an end without a panic; a sound one gives the
//! same bits.

use crate::bytes::Bytes;
use crate::small;
use fabric_capsule::{Call, Capsule, Log, Replay, Seen};
use fabric_kernel::{CacheLine, Hash, Layout, Scene, Sim};

/// Most nodes and steps of what is replayed.
const MOST: u64 = 2000;

/// A capsule of a few calls, and its scene.
fn written(bytes: &mut Bytes) -> Option<(Scene, Vec<u8>)> {
    let scene = small::scene(bytes);
    let mut memory = vec![CacheLine::ZERO; Layout::of(&scene).ok()?.lines()];
    let mut sim = Sim::new(&scene, &mut memory).ok()?;
    let mut file = Vec::new();
    let mut log = Log::begin(&mut sim, bytes.below(4) as u64, |piece: &[u8]| {
        file.extend_from_slice(piece);
        true
    });
    let mut image = vec![0; sim.snapshot_bytes()];
    for _ in 0..bytes.below(6) {
        let steps = bytes.below(9) as u64;
        let load = [bytes.odd(1.0), bytes.odd(0.0), bytes.odd(-2.0)];
        // What is refused is not written.
        let _ = match bytes.below(5) {
            0 => log.run(&mut sim, &Call::ExternalLoad(load, [0.0; 3])),
            1 => log.run(&mut sim, &Call::Reset),
            2 => sim.save(&mut image).and_then(|()| log.run(&mut sim, &Call::Load(&image))),
            _ => log.run(&mut sim, &Call::Advance(steps)),
        };
    }
    log.end(&sim);
    Some((scene, file))
}

/// Puts the right checks after the records, as a forger would.
fn forge(file: &mut [u8]) {
    let (mut hash, mut at) = (Hash::default(), 12);
    file.iter().take(at).for_each(|byte| hash.word(u64::from(*byte)));
    while let Some(length) = file.get(at + 1..at + 5).and_then(|length| length.first_chunk()) {
        let end = at + 5 + u32::from_le_bytes(*length) as usize;
        let Some(record) = file.get(at..end) else { return };
        record.iter().for_each(|byte| hash.word(u64::from(*byte)));
        let Some(check) = file.get_mut(end..end + 8) else { return };
        check.copy_from_slice(&hash.value().to_le_bytes());
        at = end + 8;
    }
}

/// Whether a replay comes to its end with the same bits; None of one that would take long, or has no
/// simulation.
fn replayed(file: &[u8]) -> Option<bool> {
    let capsule = Capsule::open(file).ok()?;
    let scene = capsule.scene().ok()?;
    let layout = Layout::of(&scene).ok()?;
    if layout.nodes() as u64 > MOST || capsule.steps > MOST || capsule.room() as u64 > MOST {
        return None;
    }
    let mut memory = vec![CacheLine::ZERO; layout.lines()];
    let mut sim = Sim::new(&scene, &mut memory).ok()?;
    let (mut replay, mut room) = (Replay::default(), vec![0.0; capsule.room()]);
    loop {
        match replay.next(&capsule, &mut sim, &mut room, 5) {
            Ok(Seen::More) => {}
            Ok(Seen::Same) => return Some(true),
            Err(_) => return Some(false),
        }
    }
}

/// The target. Past the first check is a capsule that is replayed.
pub fn run(data: &[u8]) -> bool {
    let mut bytes = Bytes::new(data);
    let Some((scene, mut file)) = written(&mut bytes) else { return false };
    let sound = Capsule::open(&file).map(|capsule| (capsule.scene() == Ok(scene), capsule.ended));
    assert_eq!(sound, Ok((true, true)), "a capsule that cannot be read, or is of another scene");
    assert_eq!(replayed(&file), Some(true), "not the same bits");
    for _ in 0..bytes.below(4) {
        let place = bytes.word() as usize % file.len();
        file[place] = bytes.byte();
    }
    if bytes.once_in(3) {
        file.truncate(bytes.word() as usize % file.len());
    }
    if !bytes.once_in(4) {
        forge(&mut file);
    }
    replayed(&file);
    true
}
