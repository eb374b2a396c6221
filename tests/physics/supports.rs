//! Supports are obstacles: a fixed node takes the impulse that stops a free body, and its attachment records
//! it.

use fabric_kernel::{AttachmentKind, Code, Drive, Integrator, Scene, Sim, Symmetry};
use fabric_tests::reference::{V3, add, dot, length, rest_positions, scale, sub};
use fabric_tests::{close, image_of, memory_of, positions, sim_of, small_sheet, stepped, tilted_cylinder};

/// The preset sphere before the node of this number, touching it from the direction of `normal`, at a
/// velocity.
fn sphere_at(scene: &Scene, node: usize, normal: V3, velocity: V3) -> Scene {
    let mut scene = *scene;
    let centre = sub(rest_positions(&scene)[node], scale(normal, scene.projectile.radius));
    (scene.projectile.position, scene.projectile.velocity) = (centre, velocity);
    scene
}

/// The sphere's velocity loses exactly its part along the line of centres, at once, and the support takes M n
/// (n.V).
#[test]
fn one_fixed_node_takes_the_normal_velocity() {
    let sheet = small_sheet(2, 0.0);
    for normal in [[0.0, 0.0, 1.0], [0.48, 0.36, 0.8], [0.6, 0.0, 0.8]] {
        for integrator in [Integrator::VERLET, Integrator::THETA] {
            let velocity = [3.0, -20.0, 99.5];
            let scene = Scene { integrator, ..sphere_at(&sheet, 0, normal, velocity) };
            let mass = scene.projectile.mass;
            let mut sim = sim_of(&scene);
            sim.step().unwrap();
            let into = dot(normal, velocity);
            let lost = 0.5 * mass * into * into;
            let after = sub(velocity, scale(normal, into));
            assert!(length(sub(sim.projectile().unwrap().velocity, after)) < 1e-13 * into);
            let (contact, support) = (sim.contact().unwrap(), sim.support().unwrap());
            assert!(length(sub(support.total, scale(normal, mass * into))) < 1e-13 * mass * into);
            // The first node belongs to the lower side, the attachment with the number 2.
            assert_eq!(support.attachments[2], support.total);
            assert!(length(add(contact.impulse, support.total)) < 1e-13 * mass * into);
            close(contact.loss, lost, 1e-13);
            close(contact.work, lost, 1e-13);
            close(sim.energy().unwrap().support_work, lost, 1e-13);
            assert!(sim.energy().unwrap().residual.abs() < 1e-13 * lost);
            assert!(length(sim.momentum_residual().unwrap()) < 1e-14 * mass * into);
            assert_eq!((sim.counters().contacts, sim.counters().unconverged), (1, 0));
            // It slides off, and never into a node.
            sim.advance(3000).unwrap();
            assert!(sim.counters().worst_penetration < 1e-12 * scene.projectile.radius);
        }
    }
}

/// Five times five nodes, the sides held: the sphere meets the middle one, and the supports get nothing of
/// its work. The same from the side of a held one: all of the work goes there. A saved state holds it, and
/// the digest knows it.
#[test]
fn work_on_supports_is_told_apart_from_work_on_the_fabric() {
    let sheet = small_sheet(5, 0.0);
    for (node, normal, on_supports) in [(12, [0.0, 0.0, 1.0], false), (2, [0.0, 0.6, 0.8], true)] {
        let scene = sphere_at(&sheet, node, normal, [0.0, 0.0, 50.0]);
        let (mass, m) = (scene.projectile.mass, scene.sheet.node_mass);
        let (mut sim, mut other) = (sim_of(&scene), sim_of(&scene));
        sim.step().unwrap();
        let into = 50.0 * normal[2];
        // With restitution zero a node at rest takes M m/(M + m) of V, the support all that goes into it.
        let given = if on_supports { mass * into } else { mass * m / (mass + m) * into };
        let work = given * (into - 0.5 * given / mass);
        let energy = sim.energy().unwrap();
        close(energy.contact_work, work, 1e-13);
        close(energy.support_work, if on_supports { work } else { 0.0 }, 1e-13);
        other.load(&image_of(&sim)).unwrap();
        assert_eq!((other.energy().unwrap(), other.digest()), (energy, sim.digest()));
    }
}

/// What a run says: speed along z, m/s, deepest penetration over the spacing, largest residuals of energy and
/// momentum over what the projectile brought.
struct Told {
    speed: f64,
    depth: f64,
    energy: f64,
    momentum: f64,
}

fn run(scene: &Scene, steps: u64) -> Told {
    let (mass, first) = (scene.projectile.mass, scene.projectile.velocity);
    let mut sim = sim_of(scene);
    let (mut energy, mut momentum): (f64, f64) = (0.0, 0.0);
    for _ in 0..steps / 100 {
        sim.advance(100).unwrap();
        energy = energy.max(sim.energy().unwrap().residual.abs() / (0.5 * mass * dot(first, first)));
        momentum = momentum.max(length(sim.momentum_residual().unwrap()) / (mass * length(first)));
    }
    let counters = sim.counters();
    assert_eq!(counters.unconverged, 0);
    let depth = counters.worst_penetration / scene.sheet.spacing;
    Told { speed: sim.projectile().unwrap().velocity[2], depth, energy, momentum }
}

/// On a corner and on an edge, on a node, between two and askew: the sphere stops or slides off, and enters
/// nothing.
#[test]
fn a_sphere_does_not_pass_through_a_clamped_edge_or_corner() {
    for kind in [AttachmentKind::FourSides, AttachmentKind::TwoSides] {
        for off in [0.0, 0.5, 0.3] {
            for at_corner in [true, false] {
                let mut scene = small_sheet(31, 99.5);
                scene.attachment.kind = kind;
                let (half, off) = (scene.half_size()[0], off * scene.sheet.spacing);
                let [x, y] = if at_corner { [off - half, -half] } else { [-half, off] };
                scene.projectile.position = [x, y, -scene.projectile.radius - 1e-6];
                let told = run(&scene, 6000);
                let name = format!("{kind:?} {off} {at_corner}");
                assert!(told.speed < 1.0 && told.depth < 1e-12, "{name}: {} {:e}", told.speed, told.depth);
                assert!(told.energy < 1e-12 && told.momentum < 1e-12, "{name}: {:e} {:e}", told.energy, told.momentum);
            }
        }
    }
}

/// A flat-ended cylinder, flush on a clamped edge: stopped; turning: entered to first order in the step only,
/// as by free nodes.
#[test]
fn a_cylinder_does_not_pass_through_a_clamped_edge() {
    let mut scene = tilted_cylinder(31, 0.0, 100.0);
    scene.projectile.position[0] = -scene.half_size()[0];
    let flush = run(&scene, 4000);
    assert!(flush.speed.abs() < 1e-9 && flush.depth < 1e-10, "{:e} {:e}", flush.speed, flush.depth);
    scene.projectile.angular_velocity = [500.0, 300.0, 1000.0];
    for told in [flush, run(&scene, 4000)] {
        assert!(told.speed < 1.0 && told.depth < 1e-4, "{} {:e}", told.speed, told.depth);
        assert!(told.energy < 1e-12 && told.momentum < 1e-12, "{:e} {:e}", told.energy, told.momentum);
    }
}

/// A sphere larger than the sheet breaks its middle and wedges between the supports, which take its momentum,
/// whatever the scheme.
#[test]
fn a_sphere_larger_than_the_sheet_is_stopped_by_its_supports() {
    let base = small_sheet(15, 60.0);
    let theta = Integrator::THETA;
    for scene in [
        base,
        small_sheet(15, 300.0),
        Scene { slack_balance: true, ..base },
        Scene { integrator: theta, ..base },
        Scene { symmetry: Symmetry { mirror_x: true, mirror_y: false }, ..base },
        Scene { symmetry: Symmetry { mirror_x: true, mirror_y: true }, ..base },
    ] {
        let sim = stepped(&scene, 5000);
        let (speed, counters) = (scene.projectile.velocity[2], sim.counters());
        let impulse = scene.projectile.mass * speed;
        let name = format!("{speed} {:?} {:?}", scene.integrator, scene.symmetry);
        assert!(sim.projectile().unwrap().velocity[2].abs() < 0.02 * speed && counters.failed_segments > 20, "{name}");
        assert!(counters.worst_penetration < 1e-12 * scene.projectile.radius && counters.unconverged <= 1, "{name}");
        assert!((sim.support().unwrap().total[2] / impulse - 1.0).abs() < 0.02, "{name}");
        assert!(length(sim.momentum_residual().unwrap()) < 1e-12 * impulse, "{name}");
        assert!(sim.energy().unwrap().residual.abs() < 1e-3 * sim.contact().unwrap().work, "{name}");
    }
}

/// Nothing is at hand that could give way between a prescribed body and a support: it passes, and the depth
/// says so.
#[test]
fn a_prescribed_body_passes_through_supports_and_is_told() {
    let mut scene = small_sheet(15, 60.0);
    scene.drive = Drive::Prescribed;
    let mut sim = sim_of(&scene);
    // The supports at the middles of the sides are met at a depth of R - sqrt(R^2 - 49 h^2).
    let (radius, near) = (scene.projectile.radius, 7.0 * scene.sheet.spacing);
    let depth = |time: f64| radius - (near * near + (radius - 60.0 * time) * (radius - 60.0 * time)).sqrt();
    let mut deepest: f64 = 0.0;
    for _ in 0..4000 {
        deepest = deepest.max(depth(sim.time()));
        sim.step().unwrap();
    }
    assert_eq!(sim.projectile().unwrap().velocity[2], 60.0);
    assert!(deepest > 1e-4, "{deepest:e}");
    close(sim.counters().worst_penetration, deepest, 1e-9);
    // It may start there, which a free body may not.
    // Beyond a corner only fixed nodes are inside the sphere.
    let (half, out) = (scene.half_size()[0], 0.5f64.sqrt() * (radius - 0.5 * scene.sheet.spacing));
    scene.projectile.position = [half + out, half + out, 0.0];
    sim_of(&scene).step().unwrap();
    let free = Scene { drive: Drive::Free, ..scene };
    let error = Sim::new(&free, &mut memory_of(&scene)).err().unwrap();
    assert_eq!((error.code, error.field), (Code::InitialOverlap, "projectile.position"));
    close(error.value, -0.5 * scene.sheet.spacing, 1e-9);
}

/// A fixed node set into a free body is refused; a body that meets the edge of a sheet that is held
/// displaced, stops there too.
#[test]
fn supports_that_are_displaced_are_met_where_they_are() {
    for integrator in [Integrator::VERLET, Integrator::THETA] {
        let mut scene = Scene { integrator, ..small_sheet(15, 99.5) };
        let (half, h) = (scene.half_size()[0], scene.sheet.spacing);
        // Ten spacings beside the sheet, and supports that are drawn out to there.
        scene.projectile.position = [0.0, half + 10.0 * h, -scene.projectile.radius - 1e-6];
        let mut sim = sim_of(&scene);
        let rest: Vec<V3> = positions(&sim);
        let moved = |z: f64| -> Vec<V3> {
            let top = rest.len() - 15;
            (rest.iter().enumerate()).map(|(k, x)| if k < top { *x } else { [x[0], x[1] + 10.0 * h, z] }).collect()
        };
        sim.set_largest_stretch(&vec![2.0; sim.layout().segments()]).unwrap();
        let error = sim.set_motion(moved(-2.0 * h).as_flattened(), &vec![0.0; 3 * rest.len()]).unwrap_err();
        assert_eq!((error.code, error.field), (Code::InitialOverlap, "positions"));
        sim.set_motion(moved(0.0).as_flattened(), &vec![0.0; 3 * rest.len()]).unwrap();
        sim.advance(1000).unwrap();
        let counters = sim.counters();
        assert!(sim.projectile().unwrap().velocity[2].abs() < 1e-12 && counters.worst_penetration < 1e-15);
        close(sim.support().unwrap().attachments[3][2], 99.5 * scene.projectile.mass, 1e-13);
    }
}
