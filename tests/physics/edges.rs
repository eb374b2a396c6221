//! Edges of the body: nodes that it gets past within a step feel nothing, and nodes that it meets are caught
//! none the less. (That none gets in, whatever the shape and motion, is searched for in `depth`.)

use fabric_kernel::Solid;
use fabric_kernel::{AttachmentKind, ContactLaw, Drive, Integrator, Projectile, Scene, Shape, TimeStep};
use fabric_tests::{cuboid_faces, sim_of, small_sheet};

/// Bodies with a flat front across z, and how far they reach along y and along z from the centre of mass, m.
fn fronts() -> [(Projectile, f64, f64); 4] {
    let base = small_sheet(41, 0.0).projectile;
    let (a, c, r) = (8e-3, 5e-3, 6.35e-3);
    let cuboid = Projectile { shape: Shape::Box, size: [0.05, 2.0 * a, 2.0 * c], ..base };
    let faces = cuboid_faces([0.025, a, c]);
    let half_spaces = Projectile { shape: Shape::Polyhedron, faces, moments: [1e-6; 3], ..cuboid };
    let cylinder = Projectile { shape: Shape::Cylinder, radius: r, length: 2.0 * c, ..base };
    // The flat end ahead: turned by half a turn about x.
    let bullet = Projectile {
        shape: Shape::HemisphericalCylinder,
        radius: r,
        length: 0.02,
        orientation: [0.0, 1.0, 0.0, 0.0],
        ..base
    };
    let behind = Solid::of(&bullet).support(&[0.0, 0.0, -1.0].into());
    [(cuboid, a, c), (half_spaces, a, c), (cylinder, r, c), (bullet, r, behind)]
}

/// The body beside the free upper edge of a sheet: its front `below` the sheet's plane, its side `beside` the
/// last row, m.
fn beside(front: &(Projectile, f64, f64), below: f64, beside: f64, velocity: [f64; 3]) -> Scene {
    let (body, across, ahead) = *front;
    let mut scene = small_sheet(41, 0.0);
    scene.attachment.kind = AttachmentKind::TwoSides;
    let position = [0.0, scene.half_size()[1] + across + beside, -ahead - below];
    scene.projectile = Projectile { position, velocity, ..body };
    scene
}

/// Work on the sheet, J, by a body in 30 steps of 0.4 dt_crit, or in as much time with another step.
fn work(scene: &Scene, fraction: f64) -> f64 {
    let scene = Scene { time_step: TimeStep::fraction(fraction), ..*scene };
    let mut sim = sim_of(&scene);
    sim.advance((30.0 * 0.4 / fraction) as u64).unwrap();
    assert!(sim.counters().worst_penetration < 1e-12 * scene.projectile.radius);
    sim.contact().unwrap().work
}

/// Side of the body a micrometre away from the last row, its front flush with the sheet: the body flies past
/// and touches nothing. Its front's plane goes through the row within a step; a sphere's tangent planes, and
/// all sides, do not.
#[test]
fn a_flush_body_flies_past_the_edge_of_a_sheet() {
    for front in fronts() {
        for fraction in [0.4, 0.1, 0.05] {
            for below in [1.03e-6, 2e-6, 4e-6] {
                let scene = beside(&front, below, 1e-6, [0.0, 0.0, 200.0]);
                let theta = Integrator::THETA;
                let rough = ContactLaw { friction: 1.0 };
                for scene in [
                    scene,
                    Scene { drive: Drive::Prescribed, ..scene },
                    Scene { integrator: theta, ..scene },
                    Scene { contact: rough, ..scene },
                ] {
                    assert_eq!(work(&scene, fraction), 0.0, "{:?} {fraction} {below}", front.0.shape);
                }
            }
        }
    }
}

/// The last row before the front, by half a micrometre: the body flies off sideways at 100 m/s before its
/// front is there, at 200 m/s, or it is not off in time and takes the row along.
#[test]
fn a_body_clears_an_edge_in_time_or_meets_it() {
    for front in fronts() {
        for fraction in [0.4, 0.1] {
            // Off after 5 ns, there after 10 ns or after 2.5 ns.
            let flies = |below: f64| work(&beside(&front, below, -5e-7, [0.0, 100.0, 200.0]), fraction);
            assert_eq!(flies(2e-6), 0.0, "{:?} {fraction}", front.0.shape);
            assert!(flies(5e-7) > 1e-5, "{:?} {fraction}", front.0.shape);
        }
    }
}

/// Edge as before, and a support at the body's other side that stops it from flying off: the node that would
/// have been passed is caught in the same step.
#[test]
fn a_body_that_is_kept_from_flying_off_meets_the_node() {
    let theta = Integrator::THETA;
    for (integrator, held) in [(Integrator::VERLET, true), (Integrator::VERLET, false), (theta, true), (theta, false)] {
        let mut scene = Scene { integrator, ..small_sheet(3, 0.0) };
        let a = 4e-3;
        scene.projectile = Projectile { shape: Shape::Box, size: [2.0 * a; 3], ..scene.projectile };
        (scene.projectile.position, scene.projectile.velocity) = ([0.0, 0.0, 0.1], [0.0, 100.0, 200.0]);
        let mut sim = sim_of(&scene);
        sim.set_largest_stretch(&[2.0; 12]).unwrap();
        let mut x = [[1.0, 0.0, 0.0]; 9];
        x[4] = [0.0, 5e-7 - a, 0.1 + a + 2e-6];
        x[7] = if held { [0.0, a, 0.1] } else { x[7] };
        sim.set_motion(x.as_flattened(), &[0.0; 27]).unwrap();
        sim.advance(2).unwrap();
        let (velocity, counters) = (sim.projectile().unwrap().velocity, sim.counters());
        assert_eq!(velocity[1] < 1e-9, held);
        assert_eq!(velocity[2] < 200.0, held);
        // The hit turns the body a little.
        assert!(counters.worst_penetration < 1e-12, "{:e}", counters.worst_penetration);
    }
}

/// A box that falls with an edge on a row of nodes is pushed along the mean of the two faces that are equally
/// near, and so neither aside nor around, on the row to rounding and beside it in proportion.
#[test]
fn a_box_with_its_edge_on_a_row_of_nodes_falls_straight() {
    let aside = |offset: f64| {
        let mut scene = small_sheet(31, 30.0);
        let (half, h) = (0.125 * std::f64::consts::PI, scene.sheet.spacing);
        let body = &mut scene.projectile;
        (body.shape, body.size, body.mass) = (Shape::Box, [12.0 * h, 8.0 * h, 8.0 * h], 5e-3);
        body.orientation = [half.cos(), half.sin(), 0.0, 0.0];
        body.position = [0.0, offset * h, -4.0 * 2f64.sqrt() * h - 1e-3 * h];
        let mut sim = sim_of(&scene);
        sim.advance(1500).unwrap();
        let motion = sim.projectile().unwrap();
        assert!(sim.counters().failed_segments == 0 && motion.velocity[2] < 29.9, "{motion:?}");
        (motion.velocity[1] / motion.velocity[2]).abs() + (motion.angular_velocity[0] * h / motion.velocity[2]).abs()
    };
    let (on, beside) = (aside(0.0), aside(1e-9));
    assert!(on < 1e-9 && beside < 1e-6, "{on:e} {beside:e}");
}
