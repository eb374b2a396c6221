//! Contact: no node enters the projectile, impulses only push, and a solve never adds kinetic energy.

use fabric_kernel::{AttachmentKind, Scene, Shape};
use fabric_tests::reference::{V3, add, dot, fixed_nodes, forces, length, nose, rest_positions, scale, sub, turn_back};
use fabric_tests::{close, damage, drawn, positions, sim_of, small_sheet, stepped};

/// Outward distance of a point from the projectile's surface, m: each shape as the intersection of slabs,
/// tubes and balls (exact near the surface of one of them, too small beyond edges and rims, exact in sign
/// everywhere).
pub(crate) fn gap(scene: &Scene, body: &fabric_kernel::Motion, x: V3) -> f64 {
    let r = sub(x, body.position);
    let local = turn_back(body.orientation, r);
    let side = local[0].hypot(local[1]) - scene.projectile.radius;
    match scene.projectile.shape {
        Shape::Sphere => length(r) - scene.projectile.radius,
        Shape::Cylinder => side.max(local[2].abs() - 0.5 * scene.projectile.length),
        Shape::HemisphericalCylinder => {
            let z = local[2] - nose(scene);
            let cap = length([local[0], local[1], z]) - scene.projectile.radius;
            let end = -z - (scene.projectile.length - scene.projectile.radius);
            end.max(if z > 0.0 { cap } else { side })
        }
        Shape::Box => (0..3).map(|k| local[k].abs() - 0.5 * scene.projectile.size[k]).fold(f64::NEG_INFINITY, f64::max),
        Shape::DiscSector => panic!("given here by its faces"),
        Shape::Polyhedron => {
            let faces = scene.projectile.faces.in_use().iter();
            faces.map(|&[a, b, c, distance]| dot([a, b, c], local) - distance).fold(f64::NEG_INFINITY, f64::max)
        }
    }
}

/// Steps a scene and checks every step; returns the deepest penetration met, m.
pub(crate) fn checked_run(scene: &Scene, steps: u64) -> f64 {
    let m = scene.sheet.node_mass;
    let fixed = fixed_nodes(scene);
    let mut sim = sim_of(scene);
    let dt = sim.step_limits().dt;
    let h = scene.sheet.spacing;
    let mut v: Vec<V3> = vec![[0.0; 3]; fixed.len()];
    let mut x = rest_positions(scene);
    let mut deepest: f64 = 0.0;
    for _ in 0..steps {
        let pulls = forces(scene, &x, &damage(&sim));
        let (body_before, energy_before) = (sim.projectile().unwrap(), sim.energy().unwrap().projectile_kinetic);
        sim.step().unwrap();
        let (now, body) = (positions(&sim), sim.projectile().unwrap());
        let (mut change, mut total) = (sim.energy().unwrap().projectile_kinetic - energy_before, energy_before);
        for k in (0..x.len()).filter(|&k| !fixed[k]) {
            let free = add(v[k], scale(pulls[k], dt / m));
            let after = scale(sub(now[k], x[k]), 1.0 / dt);
            change += 0.5 * m * (dot(after, after) - dot(free, free));
            total += 0.5 * m * dot(after, after);
            let push = scale(sub(after, free), m);
            if length(push) > 1e-9 * m * length(body.velocity) {
                assert!(gap(scene, &body_before, x[k]) < h, "only candidates are pushed");
                if scene.projectile.shape == Shape::Sphere {
                    let normal = scale(sub(x[k], body_before.position), 1.0 / length(sub(x[k], body_before.position)));
                    assert!(dot(push, normal) > 0.999_999 * length(push), "impulses push along the outward normal");
                }
            }
            deepest = deepest.max(-gap(scene, &body, now[k]));
            v[k] = after;
        }
        // KE after contact less KE before it, both bodies together.
        assert!(change <= 1e-12 * total, "contact added {change:e} J of {total:e}");
        x = now;
    }
    assert_eq!(sim.counters().unconverged, 0);
    // The kernel looks at the start of a step, so the last depth is counted in the next one.
    sim.step().unwrap();
    let counted = sim.counters().worst_penetration;
    assert!(deepest <= counted * (1.0 + 1e-6) + 1e-15, "{deepest:e} {counted:e}");
    deepest
}

/// phi >= -1e-12 R at every node and step: the gap of a convex body is convex along a step.
#[test]
fn no_node_enters_the_sphere_and_contact_never_adds_energy() {
    let mut scene = drawn(small_sheet(25, 150.0));
    scene.projectile.velocity = [20.0, -10.0, 150.0];
    let deepest = checked_run(&scene, 1000);
    assert!(deepest <= 1e-12 * scene.projectile.radius, "{deepest:e}");
}

/// A flat-ended cylinder, spinning or not, flush on a free sheet that its end covers: V' = V M/(M + N m), the
/// work is N m V' times the mean of V and V', and from then on the nodes ride with nothing but rounding to be
/// solved.
#[test]
fn nodes_that_ride_on_a_spinning_cylinder_leave_nothing_unsolved() {
    for spin in [0.0, 300.0, 3000.0, 30_000.0] {
        let mut scene = Scene::sheet_10in_cylinder();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (9, 9);
        scene.attachment.kind = AttachmentKind::Free;
        scene.yarn.stochastic = false;
        scene.projectile.velocity = [0.0, 0.0, 100.0];
        scene.projectile.angular_velocity = [0.0, 0.0, spin];
        let sim = stepped(&scene, 2000);
        assert_eq!(sim.counters().unconverged, 0, "{spin}");
        let sheet = 81.0 * scene.sheet.node_mass;
        let after = 100.0 * scene.projectile.mass / (scene.projectile.mass + sheet);
        close(sim.contact().unwrap().work, sheet * after * 0.5 * (100.0 + after), 1e-12);
    }
}
