//! Failures latch: every call but reset, load and the counters says the same until then.

use fabric::{Code, Drive, Failure, Motion, Path, Scene, Sim, Status, StepAfterFailure, StepCheck, TimeStep};
use fabric_tests::{Buffers, between_supports, positions, small_sheet, without_projectile};

/// Asserts that the failure is latched everywhere, then that a load and a reset clear it.
fn latched(sim: &mut Sim<'_>, failure: Failure, image: &[u8]) {
    let code = failure.code();
    assert_eq!(sim.failure(), Some(failure));
    assert_eq!(sim.outcomes().status, Status::Faulted);
    let steps = sim.counters().steps;
    for _ in 0..2 {
        assert_eq!(sim.step(), Err(failure));
        assert_eq!(sim.advance(3), Err(failure));
        assert_eq!(sim.advance_until(fabric::OutcomeSet::from_bits(15), 3), Err(failure));
    }
    assert_eq!(sim.projectile().unwrap_err(), failure);
    assert_eq!(sim.contact().unwrap_err(), failure);
    assert_eq!(sim.support().unwrap_err(), failure);
    assert_eq!(sim.fabric().unwrap_err(), failure);
    assert_eq!(sim.energy().unwrap_err(), failure);
    assert_eq!(sim.momentum_residual().unwrap_err(), failure);
    let mut nodes = vec![7.5; 3 * sim.layout().nodes()];
    let mut segments = vec![7.5; sim.layout().segments()];
    assert_eq!(sim.copy_positions(&mut nodes).unwrap_err().code, code);
    assert_eq!(sim.copy_velocities(&mut nodes).unwrap_err().code, code);
    assert_eq!(sim.copy_damage(&mut segments).unwrap_err().code, code);
    assert_eq!(sim.copy_stretch(&mut segments).unwrap_err().code, code);
    assert!(nodes.iter().chain(&segments).all(|&x| x == 7.5));
    let mut buffer = vec![0xa5; sim.snapshot_bytes()];
    assert_eq!(sim.save(&mut buffer).unwrap_err().code, code);
    assert!(buffer.iter().all(|&b| b == 0xa5));
    assert_eq!(sim.set_external_load([0.0; 3], [0.0; 3]).unwrap_err().code, code);
    assert_eq!(sim.set_motion(&nodes, &nodes).unwrap_err().code, code);
    assert_eq!(sim.set_largest_stretch(&segments).unwrap_err().code, code);
    let end = Motion {
        position: [0.0; 3],
        velocity: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: [0.0; 3],
    };
    assert_eq!(sim.follow(&Path { first: steps, steps: 1, end }, 1).unwrap_err().code, code);
    assert_eq!(sim.counters().steps, steps);

    // A bad image does not clear it, a good one does, and so does a reset.
    assert!(sim.load(&image[1..]).is_err());
    assert_eq!(sim.failure(), Some(failure));
    sim.load(image).unwrap();
    assert_eq!(sim.failure(), None);
    sim.step().unwrap();
}

fn image_of(sim: &Sim<'_>) -> Vec<u8> {
    let mut image = vec![0; sim.snapshot_bytes()];
    sim.save(&mut image).unwrap();
    image
}

/// A huge external load makes the projectile faster than a spacing per step: the next step says so.
#[test]
fn a_huge_load_is_too_fast() {
    let scene = between_supports(small_sheet(9, 50.0), 1.0);
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    sim.advance(10).unwrap();
    let image = image_of(&sim);
    sim.set_external_load([0.0, 0.0, 1e12], [0.0; 3]).unwrap();
    assert_eq!(sim.advance(10), Err(Failure::TooFast));
    assert!(sim.step_count() > 10);
    latched(&mut sim, Failure::TooFast, &image);
    sim.reset();
    assert_eq!((sim.failure(), sim.step_count()), (None, 0));
    sim.advance(100).unwrap();
}

/// A load that overflows the velocity is not finite.
#[test]
fn an_overflowing_load_is_not_finite() {
    let scene = small_sheet(9, 50.0);
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let image = image_of(&sim);
    sim.set_external_load([f64::MAX, 0.0, 0.0], [0.0; 3]).unwrap();
    let failure = sim.advance(10).unwrap_err();
    assert!(matches!(failure, Failure::NonFinite | Failure::TooFast), "{failure:?}");
    latched(&mut sim, failure, &image);
}

/// A load whose body throws the nodes it touches beyond all bounds: told by the step itself, not by the next.
#[test]
fn a_load_that_leaves_no_fabric_is_told_in_its_own_step() {
    let scene = small_sheet(9, 50.0);
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    sim.advance(10).unwrap();
    let image = image_of(&sim);
    assert!(sim.contact().unwrap().work > 0.0);
    sim.set_external_load([0.0, 0.0, 1e150], [0.0; 3]).unwrap();
    assert_eq!(sim.step(), Err(Failure::NonFinite));
    latched(&mut sim, Failure::NonFinite, &image);
}

/// A torque that overflows the spin: told by the step itself, before anyone reads a body that is nowhere.
#[test]
fn an_overflowing_torque_is_not_finite_in_its_own_step() {
    let mut scene = small_sheet(9, 50.0);
    scene.projectile.shape = fabric::Shape::Cylinder;
    scene.projectile.position[2] = -0.05;
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let image = image_of(&sim);
    sim.set_external_load([0.0; 3], [f64::MAX, 0.0, 0.0]).unwrap();
    assert_eq!(sim.step(), Err(Failure::NonFinite));
    latched(&mut sim, Failure::NonFinite, &image);
}

/// With room for one node under the projectile the second one is a failure, and the state is that of the step's start.
#[test]
fn too_little_contact_capacity_keeps_the_state() {
    let mut scene: Scene = small_sheet(21, 100.0);
    scene.contact_capacity = 1;
    // One node is near the surface at the nose, and more only later: a small sphere seen from a corner of the lattice.
    scene.projectile.position[2] = -6.35e-3 - 8.0e-4;
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let image = image_of(&sim);
    let mut before = sim.digest();
    let failure = loop {
        match sim.step() {
            Ok(()) => before = sim.digest(),
            Err(failure) => break failure,
        }
    };
    assert_eq!(failure, Failure::ContactCapacity);
    assert!(sim.step_count() > 10);
    assert_eq!(sim.digest(), before, "the state is that of the step's start");
    assert_eq!(sim.counters().candidate_capacity, 1);
    latched(&mut sim, Failure::ContactCapacity, &image);
}

/// The same with a body moved by the host.
#[test]
fn too_little_contact_capacity_keeps_the_state_of_a_prescribed_body() {
    let mut scene: Scene = small_sheet(21, 100.0);
    scene.contact_capacity = 1;
    scene.drive = Drive::Prescribed;
    scene.projectile.position[2] = -6.35e-3 - 8.0e-4;
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let end = Motion {
        position: [0.0; 3],
        velocity: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: [0.0; 3],
    };
    let path = Path { first: 0, steps: 5000, end };
    let mut before = sim.digest();
    while sim.follow(&path, 1).is_ok() {
        before = sim.digest();
    }
    assert_eq!(sim.failure(), Some(Failure::ContactCapacity));
    assert_eq!(sim.digest(), before, "the state is that of the step's start");
}

/// Positions beyond 1e30 spacings are refused; those short of it, with which no fabric is one, fail in the first step.
#[test]
fn positions_of_no_fabric_are_refused_or_found() {
    let scene = small_sheet(9, 50.0);
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let image = image_of(&sim);
    let (x, limit) = (positions(&sim).into_iter().flatten().collect::<Vec<f64>>(), 1e30 * scene.sheet.spacing);
    let v = vec![0.0; x.len()];
    let with = |far: f64| {
        let mut x = x.clone();
        x[3 * 30 + 2] = far;
        x
    };
    for far in [1.01 * limit, -1.01 * limit, 1e300, f64::MAX] {
        let error = sim.set_motion(&with(far), &v).unwrap_err();
        assert_eq!((error.code, error.field, error.value), (Code::OutOfRange, "positions", far));
        assert_eq!(image_of(&sim), image);
    }
    for far in [0.99 * limit, -0.99 * limit, 1e26 * scene.sheet.spacing] {
        sim.set_motion(&with(far), &v).unwrap();
        let energy = sim.energy().unwrap();
        assert!(energy.strain.is_finite() && energy.residual.is_finite(), "{energy:?}");
        let given = image_of(&sim);
        sim.load(&given).unwrap();
        assert_eq!(sim.step(), Err(Failure::NonFinite));
        latched(&mut sim, Failure::NonFinite, &image);
        sim.reset();
    }
}

/// Far too long a step blows up a sheet that never breaks, B < 0. Whatever it passes through on its way to the failure is a state
/// that an image keeps and load takes, with energies that are numbers.
#[test]
fn a_sheet_that_blows_up_keeps_to_numbers_until_it_fails() {
    let mut scene = without_projectile(small_sheet(9, 0.0));
    scene.step_check = StepCheck::None;
    (scene.yarn.damage_a, scene.yarn.damage_b) = (0.5, -1.0);
    for (fraction, after) in [3.0, 30.0, 300.0]
        .into_iter()
        .flat_map(|fraction| [(fraction, StepAfterFailure::Keep), (fraction, StepAfterFailure::Half)])
    {
        (scene.time_step, scene.step_after_failure) = (TimeStep::fraction(fraction), after);
        let mut memory = Buffers::of(&scene);
        let mut sim = memory.sim(&scene);
        let x: Vec<f64> = positions(&sim).into_iter().flatten().map(|x| 1.05 * x).collect();
        let mut v = vec![0.0; x.len()];
        v[3 * 40 + 2] = 100.0;
        sim.set_motion(&x, &v).unwrap();
        let mut largest = 0.0;
        let failure = loop {
            if let Err(failure) = sim.step() {
                break failure;
            }
            let energy = sim.energy().unwrap();
            assert!(energy.residual.is_finite(), "{fraction}: {energy:?}");
            largest = sim.fabric().unwrap().max_stretch;
            let (image, digest) = (image_of(&sim), sim.digest());
            assert_eq!(sim.load(&image), Ok(()), "{fraction} at step {}", sim.step_count());
            assert_eq!(sim.digest(), digest);
        };
        assert!(failure == Failure::NonFinite && largest > 1e10, "{fraction}: {failure:?} at stretch {largest:e}");
    }
}

/// The same through velocities: a node that flies off.
#[test]
fn velocities_of_no_fabric_are_found() {
    let scene = small_sheet(9, 50.0);
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let image = image_of(&sim);
    let x: Vec<f64> = positions(&sim).into_iter().flatten().collect();
    let mut v = vec![0.0; x.len()];
    v[3 * 30 + 2] = 1e200;
    assert_eq!(sim.set_motion(&x, &v).unwrap_err().field, "velocities");
    v[3 * 30 + 2] = 1e34;
    sim.set_motion(&x, &v).unwrap();
    assert_eq!(sim.advance(10), Err(Failure::NonFinite));
    latched(&mut sim, Failure::NonFinite, &image);
}
