//! A capsule that was written is replayed with the same bits; what was altered is found where it is; broken bytes are refused by name. Hostile ones: tests/fuzz/src/capsule.rs.

use fabric_capsule::{Broken, Call, Capsule, Difference, Log, Replay, Seen, What};
use fabric_kernel::{CacheLine, Layout, Motion, Outcome, Path, Scene, Sim};

fn scene() -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (21, 17);
    scene.projectile.velocity = [0.0, 0.0, 120.0];
    scene.yarn.stochastic = true;
    scene
}

fn simulation(scene: &Scene) -> Sim<'static> {
    let memory = vec![CacheLine::ZERO; Layout::of(scene).unwrap().lines()];
    Sim::new(scene, memory.leak()).unwrap()
}

/// Bytes of a capsule of every call that a free body can have.
fn written(stride: u64) -> Vec<u8> {
    let mut sim = simulation(&scene());
    let mut bytes = Vec::new();
    let mut log = Log::begin(&mut sim, stride, |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        true
    });
    let segments = sim.layout().segments();
    let mut nodes = vec![0.0; 3 * sim.layout().nodes()];
    log.run(&mut sim, &Call::LargestStretch(&vec![1.01; segments])).unwrap();
    sim.copy_positions(&mut nodes).unwrap();
    let still = vec![0.0; nodes.len()];
    log.run(&mut sim, &Call::Motion(&nodes, &still)).unwrap();
    log.run(&mut sim, &Call::Advance(70)).unwrap();
    log.run(&mut sim, &Call::ExternalLoad([0.0, 0.0, -3.0], [0.0, 1e-4, 0.0])).unwrap();
    let taken = sim.advance_until(Outcome::Arrested | Outcome::Exited, 300).unwrap();
    log.note(&Call::Advance(taken), &sim);
    let mut image = vec![0; sim.snapshot_bytes()];
    sim.save(&mut image).unwrap();
    assert!(log.run(&mut sim, &Call::Load(&image[..9])).is_err(), "refused, so not written");
    log.run(&mut sim, &Call::Advance(50)).unwrap();
    log.run(&mut sim, &Call::Load(&image)).unwrap();
    log.run(&mut sim, &Call::Advance(10)).unwrap();
    log.run(&mut sim, &Call::Reset).unwrap();
    log.run(&mut sim, &Call::Advance(128)).unwrap();
    log.end(&sim);
    assert!(log.is_whole());
    bytes
}

/// Replays in pieces of `most` steps: what was done, and the first difference.
fn replayed(capsule: &Capsule<'_>, scene: &Scene, most: u64) -> (Replay, Option<Difference>) {
    let (mut sim, mut replay) = (simulation(scene), Replay::default());
    let mut room = vec![0.0; capsule.room()];
    loop {
        match replay.next(capsule, &mut sim, &mut room, most) {
            Ok(Seen::More) => (),
            Ok(Seen::Same) => return (replay, None),
            Err(difference) => return (replay, Some(difference)),
        }
    }
}

#[test]
fn every_call_is_replayed_with_the_same_bits() {
    for (stride, digests) in [(1, 12), (3, 5), (1000, 2)] {
        let bytes = written(stride);
        let capsule = Capsule::open(&bytes).unwrap();
        assert_eq!(
            (capsule.scene().unwrap(), capsule.calls, capsule.stride, capsule.ended),
            (scene(), 10, stride, true)
        );
        assert_eq!(capsule.version, fabric_kernel::VERSION);
        for most in [1, 17, u64::MAX] {
            let (replay, difference) = replayed(&capsule, &scene(), most);
            assert_eq!(
                (difference, replay.calls, replay.digests),
                (None, 10, digests),
                "stride {stride}, {most} steps"
            );
            assert_eq!(replay.steps, capsule.steps);
        }
    }
}

#[test]
fn clamps_that_slip_and_let_go_are_replayed() {
    let mut scene = scene();
    (scene.attachment.hold, scene.attachment.grip, scene.attachment.strength) = (100.0, 3e-4, 1e3);
    let (mut sim, mut bytes) = (simulation(&scene), Vec::new());
    let mut log = Log::begin(&mut sim, 5, |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        true
    });
    (0..9).for_each(|_| log.run(&mut sim, &Call::Advance(100)).unwrap());
    log.end(&sim);
    assert!(sim.energy().unwrap().attachment > 0.0 && sim.outcomes().mask.has(Outcome::AttachmentFailed));
    let capsule = Capsule::open(&bytes).unwrap();
    assert_eq!((capsule.scene().unwrap(), replayed(&capsule, &scene, 17).1), (scene, None));
    scene.attachment.hold = 101.0;
    assert!(replayed(&capsule, &scene, 17).1.is_some(), "another hold is another simulation");
}

#[test]
fn a_path_and_a_failure_are_replayed() {
    let mut scene = scene();
    (scene.drive, scene.yarn.stochastic) = (fabric_kernel::Drive::Prescribed, false);
    let mut sim = simulation(&scene);
    let mut bytes = Vec::new();
    let mut log = Log::begin(&mut sim, 2, |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        true
    });
    let start = sim.projectile().unwrap();
    let [x, y, z] = start.position;
    let end = Motion { position: [x, y, z + 100.0 * 120.0 * sim.step_limits().dt], ..start };
    log.run(&mut sim, &Call::Path(Path { first: 0, steps: 100, end }, 100)).unwrap();
    log.run(&mut sim, &Call::Advance(100)).unwrap();
    log.end(&sim);
    let capsule = Capsule::open(&bytes).unwrap();
    assert_eq!(replayed(&capsule, &scene, 7).1, None);

    // Too little room for the nodes under the body: a failure, at a step that the capsule has.
    scene = self::scene();
    scene.contact_capacity = 1;
    let mut sim = simulation(&scene);
    let mut bytes = Vec::new();
    let mut log = Log::begin(&mut sim, 1, |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        true
    });
    assert!(log.run(&mut sim, &Call::Advance(1000)).is_err());
    log.end(&sim);
    let capsule = Capsule::open(&bytes).unwrap();
    let (replay, difference) = replayed(&capsule, &scene, 5);
    assert_eq!((difference, replay.steps), (None, sim.step_count()));
    scene.contact_capacity = 0;
    let difference = replayed(&capsule, &scene, 5).1;
    assert!(matches!(difference, Some(Difference::Digest(..) | Difference::Status(_, 0))), "{difference:?}");
}

#[test]
fn another_simulation_differs_where_it_does() {
    let bytes = written(1);
    let capsule = Capsule::open(&bytes).unwrap();
    let other = Scene { seed: 2, ..scene() };
    let (replay, difference) = replayed(&capsule, &other, 64);
    assert!(matches!(difference, Some(Difference::Digest(..))) && replay.calls == 0, "a scene differs at its start");

    // One load is another: the state differs after the call, and at none before.
    let mut altered = bytes.clone();
    let load = (-3.0_f64).to_le_bytes();
    let place = altered.windows(8).position(|word| word == load).unwrap();
    altered[place..place + 8].copy_from_slice(&(-4.0_f64).to_le_bytes());
    checked_anew(&mut altered);
    let (replay, difference) = replayed(&Capsule::open(&altered).unwrap(), &scene(), 64);
    assert!(matches!(difference, Some(Difference::Digest(..))));
    assert_eq!((replay.calls, replay.equal_calls), (4, 3), "the fourth call is the first that differs");
}

/// Puts the right checks after the records, so that their contents are tested.
fn checked_anew(bytes: &mut [u8]) {
    let (mut hash, mut at) = (fabric_kernel::Hash::default(), 12);
    bytes[..at].iter().for_each(|byte| hash.word(u64::from(*byte)));
    while let Some(length) = bytes.get(at + 1..at + 5).and_then(|length| length.first_chunk()) {
        let end = at + 5 + u32::from_le_bytes(*length) as usize;
        let Some(record) = bytes.get(at..end) else { return };
        record.iter().for_each(|byte| hash.word(u64::from(*byte)));
        let Some(check) = bytes.get_mut(end..end + 8) else { return };
        check.copy_from_slice(&hash.value().to_le_bytes());
        at = end + 8;
    }
}

#[test]
fn broken_bytes_are_refused_by_name() {
    let bytes = written(4);
    let what = |bytes: &[u8]| Capsule::open(bytes).unwrap_err().what;
    assert_eq!(what(b""), What::NoCapsule);
    assert_eq!(what(b"{\"json\": 1}"), What::NoCapsule);
    let mut other = bytes.clone();
    other[8] = 2;
    assert_eq!(what(&other), What::OtherFormat(2));
    assert_eq!(what(&[&bytes[..], b"more"].concat()), What::Truncated);
    let end = bytes[bytes.len() - 21..].to_vec();
    let mut twice = [&bytes[..], &end].concat();
    checked_anew(&mut twice);
    assert_eq!(what(&twice), What::BehindTheEnd);

    // Any byte altered.
    for at in (12..bytes.len()).step_by(7) {
        let mut altered = bytes.clone();
        altered[at] ^= 0x10;
        assert!(matches!(what(&altered), What::Altered | What::Truncated | What::UnknownRecord(_)), "byte {at}");
    }
    // Cut anywhere: what is whole of it can be replayed.
    for length in (12..bytes.len()).step_by(97) {
        let Err(Broken { what, whole, .. }) = Capsule::open(&bytes[..length]) else { continue };
        assert_eq!(what, What::Truncated);
        if let Ok(capsule) = Capsule::open(&bytes[..whole]) {
            assert!(!capsule.ended);
            assert_eq!(replayed(&capsule, &scene(), u64::MAX).1, None);
        }
    }
}

#[test]
fn a_sink_that_is_full_ends_the_log() {
    let mut sim = simulation(&scene());
    let mut taken = Vec::new();
    let mut log = Log::begin(&mut sim, 1, |piece: &[u8]| {
        let fits = taken.len() + piece.len() <= 600;
        taken.extend_from_slice(if fits { piece } else { &[] });
        fits
    });
    while log.is_whole() {
        log.run(&mut sim, &Call::Advance(1)).unwrap();
    }
    let whole = Capsule::open(&taken).map_or_else(|broken| broken.whole, |_| taken.len());
    assert_eq!(replayed(&Capsule::open(&taken[..whole]).unwrap(), &scene(), 9).1, None);
}
