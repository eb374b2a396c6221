//! Failures latch: every call but reset, load and the counters says the same until then.

use fabric_kernel::Failure::{self, *};
use fabric_kernel::{Code, Drive, Integrator, OutcomeSet, Path, Scene, Shape, Sim, Status, StepCheck, TimeStep};
use fabric_tests::{AT_REST, between_supports, image_of, positions, set_off, sim_of, small_sheet, without_projectile};

/// How a failure comes about.
pub struct Case {
    name: &'static str,
    pub scene: Scene,
    /// Steps before it is brought about.
    before: u64,
    bring: fn(&mut Sim<'_>),
    pub failure: Failure,
    /// Whether the next step is to tell it, or one of the next five thousand.
    at_once: bool,
}

impl Case {
    /// Runs into the failure. One that a step finds before it has moved anything leaves the state of its
    /// start.
    pub fn run(&self) -> (Sim<'static>, Vec<u8>) {
        let mut sim = sim_of(&self.scene);
        sim.advance(self.before).unwrap();
        let image = image_of(&sim);
        (self.bring)(&mut sim);
        let (mut digest, start) = (sim.digest(), sim.step_count());
        let failure = loop {
            if let Err(failure) = sim.step() {
                break failure;
            }
            assert!(!self.at_once && sim.step_count() < start + 5000, "{}: should fail", self.name);
            digest = sim.digest();
        };
        assert_eq!(failure, self.failure, "{}", self.name);
        if matches!(failure, ContactCapacity | NotConverged) {
            assert_eq!(sim.digest(), digest, "{}: the state is that of the step's start", self.name);
        }
        (sim, image)
    }
}

/// The sheet of 9 x 9 nodes at rest, but for one that is put there along z, in spacings, or has this
/// velocity, m/s.
fn flung(sim: &mut Sim<'_>, place: f64, speed: f64) {
    let z = place * sim.scene().sheet.spacing;
    set_off(sim, |k, x| if k == 30 { [[x[0], x[1], z], [0.0, 0.0, speed]] } else { [x, [0.0; 3]] });
    let energy = sim.energy().unwrap();
    assert!(energy.strain.is_finite() && energy.residual.is_finite(), "{energy:?}");
    // It is a state like any other.
    let given = image_of(sim);
    sim.load(&given).unwrap();
}

/// Room for one node under the projectile. One is near the surface at the nose, and more only later: a small
/// sphere seen from a corner of the lattice.
fn crowded() -> Scene {
    let mut scene = small_sheet(21, 100.0);
    (scene.contact_capacity, scene.projectile.position[2]) = (1, -6.35e-3 - 8.0e-4);
    scene
}

pub fn cases() -> Vec<Case> {
    let sheet = small_sheet(9, 50.0);
    let mut cylinder = sheet;
    (cylinder.projectile.shape, cylinder.projectile.position[2]) = (Shape::Cylinder, -0.05);
    let theta = Scene {
        integrator: Integrator::THETA,
        step_check: StepCheck::None,
        time_step: TimeStep::fraction(1.0),
        ..small_sheet(21, 100.0)
    };
    let case = |name, scene, before, failure, at_once, bring| Case { name, scene, before, bring, failure, at_once };
    vec![
        case("a huge load", between_supports(sheet, 1.0), 10, TooFast, false, |sim| {
            sim.set_external_load([0.0, 0.0, 1e12], [0.0; 3]).unwrap();
        }),
        case("a load that overflows the velocity", sheet, 0, NonFinite, false, |sim| {
            sim.set_external_load([f64::MAX, 0.0, 0.0], [0.0; 3]).unwrap();
        }),
        // The body throws the nodes that it touches beyond all bounds.
        case("a load that leaves no fabric", sheet, 10, NonFinite, true, |sim| {
            assert!(sim.contact().unwrap().work > 0.0);
            sim.set_external_load([0.0, 0.0, 1e150], [0.0; 3]).unwrap();
        }),
        case("a torque that overflows the spin", cylinder, 0, NonFinite, true, |sim| {
            sim.set_external_load([0.0; 3], [f64::MAX, 0.0, 0.0]).unwrap();
        }),
        case("too little room", crowded(), 0, ContactCapacity, false, |_| ()),
        case(
            "too little room under a prescribed body",
            Scene { drive: Drive::Prescribed, ..crowded() },
            0,
            ContactCapacity,
            false,
            |sim| {
                sim.follow(&Path { first: 0, steps: 5000, end: AT_REST }, 0).unwrap();
            },
        ),
        // A step of dt_crit does not converge for long.
        case("the theta rule at dt_crit", theta, 0, NotConverged, false, |_| ()),
        case("a node far away", sheet, 0, NonFinite, true, |sim| flung(sim, 0.99e30, 0.0)),
        case("a node far away at the other side", sheet, 0, NonFinite, true, |sim| flung(sim, -0.99e30, 0.0)),
        case("a node less far away", sheet, 0, NonFinite, true, |sim| flung(sim, 1e26, 0.0)),
        case("a node that flies off", sheet, 0, NonFinite, false, |sim| flung(sim, 0.0, 1e34)),
    ]
}

#[test]
fn every_failure_is_told_and_latched() {
    for case in cases() {
        println!("{}", case.name);
        let (mut sim, image) = case.run();
        latched(&mut sim, case.failure, &image);
    }
}

/// Asserts that the failure is latched everywhere, then that a load and a reset clear it.
fn latched(sim: &mut Sim<'_>, failure: Failure, image: &[u8]) {
    let code = failure.code();
    assert_eq!((sim.failure(), sim.outcomes().status), (Some(failure), Status::Faulted));
    let steps = sim.counters().steps;
    for _ in 0..2 {
        assert_eq!(sim.step(), Err(failure));
        assert_eq!(sim.advance(3), Err(failure));
        assert_eq!(sim.advance_until(OutcomeSet::from_bits(15), 3), Err(failure));
    }
    assert_eq!(sim.projectile().unwrap_err(), failure);
    assert_eq!(sim.contact().unwrap_err(), failure);
    assert_eq!(sim.support().unwrap_err(), failure);
    assert_eq!(sim.fabric().unwrap_err(), failure);
    assert_eq!(sim.energy().unwrap_err(), failure);
    assert_eq!(sim.momentum_residual().unwrap_err(), failure);
    let mut nodes = vec![7.5; 3 * sim.layout().nodes()];
    let mut segments = vec![7.5; sim.layout().segments()];
    let mut buffer = vec![0xa5; sim.snapshot_bytes()];
    let path = Path { first: steps, steps: 1, end: AT_REST };
    for refused in [
        sim.copy_positions(&mut nodes),
        sim.copy_velocities(&mut nodes),
        sim.copy_damage(&mut segments),
        sim.copy_stretch(&mut segments),
        sim.save(&mut buffer),
        sim.set_external_load([0.0; 3], [0.0; 3]),
        sim.set_motion(&nodes, &nodes),
        sim.set_largest_stretch(&segments),
        sim.follow(&path, 1),
    ] {
        assert_eq!(refused.unwrap_err().code, code);
    }
    assert!(nodes.iter().chain(&segments).all(|&x| x == 7.5) && buffer.iter().all(|&b| b == 0xa5));
    assert_eq!(sim.counters().steps, steps);

    // A bad image does not clear it, a good one does, and so does a reset.
    assert!(sim.load(&image[1..]).is_err());
    assert_eq!(sim.failure(), Some(failure));
    let mut fresh = sim_of(sim.scene());
    fresh.load(image).unwrap();
    sim.load(image).unwrap();
    assert_eq!((sim.failure(), sim.step()), (None, fresh.step()));
    assert_eq!(sim.digest(), fresh.digest());
    sim.reset();
    assert_eq!((sim.failure(), sim.step_count()), (None, 0));
    sim.step().unwrap();
}

/// Positions beyond 1e30 spacings, and velocities like them, are refused at once.
#[test]
fn motion_beyond_all_fabric_is_refused() {
    let mut sim = sim_of(&small_sheet(9, 50.0));
    let (image, limit) = (image_of(&sim), 1e30 * sim.scene().sheet.spacing);
    let (x, rest) = (positions(&sim).as_flattened().to_vec(), vec![0.0; 3 * 81]);
    let with = |values: &[f64], far: f64| {
        let mut values = values.to_vec();
        values[3 * 30 + 2] = far;
        values
    };
    for far in [1.01 * limit, -1.01 * limit, 1e300, f64::MAX] {
        let error = sim.set_motion(&with(&x, far), &rest).unwrap_err();
        assert_eq!((error.code, error.field, error.value), (Code::OutOfRange, "positions", far));
    }
    assert_eq!(sim.set_motion(&x, &with(&rest, 1e200)).unwrap_err().field, "velocities");
    assert_eq!(image_of(&sim), image);
}

/// Far too long a step blows up a sheet that never breaks, B < 0. Whatever it passes through on its way to
/// the failure is a state that an image keeps and load takes, with energies that are numbers.
#[test]
fn a_sheet_that_blows_up_keeps_to_numbers_until_it_fails() {
    let mut scene = without_projectile(small_sheet(9, 0.0));
    scene.step_check = StepCheck::None;
    (scene.yarn.damage_a, scene.yarn.damage_b) = (0.5, -1.0);
    for fraction in [3.0, 30.0, 300.0] {
        scene.time_step = TimeStep::fraction(fraction);
        let mut sim = sim_of(&scene);
        set_off(&mut sim, |k, x| [x.map(|x| 1.05 * x), [0.0, 0.0, if k == 40 { 100.0 } else { 0.0 }]]);
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
        assert!(failure == NonFinite && largest > 1e10, "{fraction}: {failure:?} at stretch {largest:e}");
    }
}
