//! Momentum and energy balances, from read-outs and plain formulas rather than from the kernel's own ledger.

use fabric::{AttachmentKind, Scene, Sim};
use fabric_tests::reference::{
    V3, add, cross, dot, fixed_nodes, forces, length, moments, projectile_energy, rest_positions, scale, sub, turn,
    turn_back,
};
use fabric_tests::{Buffers, close, damage, positions, small_sheet, speed, sphere_on_3in, tilted_cylinder, velocities};

/// A free sheet, N = 41, 40 J: no force from outside, so the momentum of projectile and sheet together is constant. Nodal
/// velocities at t_n and at t_{n-1/2} have the same sum because the yarns' forces cancel pairwise.
#[test]
fn a_free_sheet_keeps_momentum() {
    let mut scene = small_sheet(41, speed(40.0, 8.4e-3));
    scene.attachment.kind = AttachmentKind::Free;
    scene.yarn.stochastic = true;
    let (m, mass) = (scene.sheet.node_mass, scene.projectile.mass);
    let first = scale(scene.projectile.velocity, mass);
    let mut sim = sim_of(&scene);
    let mut worst: f64 = 0.0;
    for _ in 0..30 {
        sim.advance(100).unwrap();
        let fabric = velocities(&sim).iter().fold([0.0; 3], |sum, v| add(sum, scale(*v, m)));
        let motion = sim.projectile().unwrap();
        let total = add(fabric, scale(motion.velocity, mass));
        worst = worst.max(length(sub(total, first)) / length(first));
        assert!(length(sim.momentum_residual().unwrap()) < 1e-12 * length(first));
        assert_eq!(motion.angular_velocity, [0.0; 3], "a frictionless sphere never turns");
    }
    println!("figure 17: free sheet and sphere: {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}

/// Angular momentum of a free sheet and a tumbling cylinder about the origin is constant to rounding too: impulses are equal
/// and opposite at the same points. Positions and velocities are those at t_n, the projectile's place that at t_{n-1/2}.
#[test]
fn a_free_sheet_and_a_cylinder_keep_angular_momentum() {
    let mut scene = tilted_cylinder(31, 0.4, 60.0);
    scene.attachment.kind = AttachmentKind::Free;
    let mut sim = sim_of(&scene);
    let first = angular_momentum(&sim);
    sim.advance(2000).unwrap();
    let given = length(sim.contact().unwrap().angular_impulse);
    let off = length(sub(angular_momentum(&sim), first)) / given;
    println!("figure 17: free sheet and cylinder, angular momentum over what was exchanged: {off:.1e}");
    assert!(given > 1e-7 && off < 1e-12, "{off:e} of {given:e} N m s");
}

/// Angular momentum of projectile and free nodes about the origin, N m s.
pub(crate) fn angular_momentum(sim: &Sim<'_>) -> V3 {
    let scene = sim.scene();
    let (m, mass, inertia) = (scene.sheet.node_mass, scene.projectile.mass, moments(scene));
    let body = sim.projectile().unwrap();
    let w = turn_back(body.orientation, body.angular_velocity);
    let spin = turn(body.orientation, [inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2]]);
    let place = sub(body.position, scale(body.velocity, 0.5 * sim.step_limits().dt));
    let nodes = positions(sim).into_iter().zip(velocities(sim));
    nodes.fold(add(spin, cross(place, scale(body.velocity, mass))), |sum, (x, v)| add(sum, cross(x, scale(v, m))))
}

/// Projectile + nodes + impulse on the supports, for every way to hold the sheet, through failure, in each component.
#[test]
fn supports_take_what_projectile_and_sheet_lose() {
    for kind in [AttachmentKind::TwoSides, AttachmentKind::FourSides, AttachmentKind::FourCorners] {
        let mut scene = sphere_on_3in(kind, 60.0, true);
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (51, 45);
        (scene.attachment.disc_inset, scene.attachment.disc_radius) = (3e-3, 2.5e-3);
        scene.projectile.velocity[0] = 7.0;
        let (m, mass) = (scene.sheet.node_mass, scene.projectile.mass);
        let first = scale(scene.projectile.velocity, mass);
        let mut sim = sim_of(&scene);
        let mut worst: f64 = 0.0;
        for _ in 0..40 {
            sim.advance(100).unwrap();
            let fabric = half_step_momentum(&mut sim, m);
            let support = sim.support().unwrap();
            let total = add(add(fabric, scale(sim.projectile().unwrap().velocity, mass)), support.total);
            let off = length(sub(total, first)) / length(first);
            worst = worst.max(off);
            assert!(off < 1e-12, "{kind:?}: {off:e}");
            assert!(length(sim.momentum_residual().unwrap()) < 1e-12 * length(first));
            let sum = support.attachments.into_iter().fold([0.0; 3], add);
            assert!(length(sub(sum, support.total)) <= 1e-15 * length(support.total));
        }
        assert!(sim.counters().failed_segments > 0);
        println!("figure 17: {kind:?}, supports counted, through failure: {worst:.1e}");
    }
}

/// Momentum of the nodes at t_{n-1/2}, from the way they make in the step to come: taken from a loaded copy, so that the
/// simulation stays where it is.
pub(crate) fn half_step_momentum(sim: &mut Sim<'_>, m: f64) -> V3 {
    // v_{n-1/2} of fixed nodes is 0; of the others v_n minus half a kick with the forces at t_n.
    let scene = *sim.scene();
    let dt = sim.step_limits().dt;
    let pulls = forces(&scene, &positions(sim), &damage(sim));
    let fixed = fixed_nodes(&scene);
    let mut sum = [0.0; 3];
    for ((v, pull), fixed) in velocities(sim).iter().zip(pulls).zip(fixed) {
        if !fixed {
            sum = add(sum, sub(scale(*v, m), scale(pull, 0.5 * dt)));
        }
    }
    sum
}

/// A sheet stretched evenly pulls on its supports with one yarn force N = A_0 U S for every yarn that ends there.
#[test]
fn a_stretched_sheet_pulls_its_supports_with_the_yarn_force() {
    let mut scene = fabric_tests::without_projectile(small_sheet(9, 0.0));
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (11, 8);
    let mut sim = sim_of(&scene);
    let stretch = 1.01;
    let x: Vec<f64> = positions(&sim).iter().flatten().map(|x| stretch * x).collect();
    sim.set_motion(&x, &vec![0.0; x.len()]).unwrap();
    sim.advance(500).unwrap();
    let force = scene.sheet.yarn_area * stretch * scene.yarn.modulus_mean * 0.5 * (stretch * stretch - 1.0);
    let [left, right, bottom, top] = sim.support().unwrap().attachments;
    let t = sim.time();
    // Corner nodes count to bottom and top: six yarns end on the left, eleven at the bottom.
    close(left[0], 6.0 * force * t, 1e-9);
    close(right[0], -6.0 * force * t, 1e-9);
    close(bottom[1], 11.0 * force * t, 1e-9);
    close(top[1], -11.0 * force * t, 1e-9);
    assert!(velocities(&sim).iter().all(|v| length(*v) < 1e-6), "in equilibrium");
}

/// The work-energy identity of every step, contact included:
/// KE_{n+1/2} - KE_{n-1/2} = sum over nodes of dt F_n.(v_{n-1/2} + v_{n+1/2})/2 - contact loss of the step.
/// Half-step velocities come from positions, forces from plain formulas; only the loss is the kernel's, and the contact
/// impulses on the nodes, m (v_{n+1/2} - v_{n-1/2}) - dt F_n, are checked against it: they act on candidates only, push
/// outward, and are opposite to what the projectile and the kernel's sums received.
pub(crate) fn work_energy_identity(scene: &Scene, steps: u64) -> f64 {
    let m = scene.sheet.node_mass;
    let mass = scene.projectile.mass;
    let fixed = fixed_nodes(scene);
    let mut sim = sim_of(scene);
    let dt = sim.step_limits().dt;
    sim.step().unwrap();
    let mut before = (positions(&sim), vec![[0.0; 3]; fixed.len()], sim.projectile().unwrap(), sim.contact().unwrap());
    let rest = rest_positions(scene);
    before.1 = before.0.iter().zip(&rest).map(|(a, b)| scale(sub(*a, *b), 1.0 / dt)).collect();
    let mut worst: f64 = 0.0;
    for _ in 0..steps {
        let (x, v_before, body_before, contact_before) = &before;
        let pulls = forces(scene, x, &damage(&sim));
        sim.step().unwrap();
        let (now, body, contact) = (positions(&sim), sim.projectile().unwrap(), sim.contact().unwrap());
        let v: Vec<V3> = now.iter().zip(x).map(|(a, b)| scale(sub(*a, *b), 1.0 / dt)).collect();

        let (mut gain, mut work, mut kinetic, mut impulse, mut given) = (0.0, 0.0, 0.0, [0.0; 3], 0.0);
        for k in (0..x.len()).filter(|&k| !fixed[k]) {
            gain += 0.5 * m * (dot(v[k], v[k]) - dot(v_before[k], v_before[k]));
            kinetic += 0.5 * m * dot(v[k], v[k]);
            let mean = scale(add(v[k], v_before[k]), 0.5);
            work += dt * dot(pulls[k], mean);
            let push = sub(scale(sub(v[k], v_before[k]), m), scale(pulls[k], dt));
            given += dot(push, mean);
            impulse = add(impulse, push);
        }
        let (energy_before, energy) = (projectile_energy(scene, body_before), projectile_energy(scene, &body));
        let total = kinetic + energy;
        gain += energy - energy_before;
        let loss = contact.loss - contact_before.loss;
        worst = worst.max((gain - work + loss).abs() / total);
        // Pieces: what the body lost is the kernel's work; what the nodes got is that less the loss.
        let done = contact.work - contact_before.work;
        assert!((energy_before - energy - done).abs() < 1e-12 * total);
        assert!((given - (done - loss)).abs() < 1e-12 * total);
        let body_gain = scale(sub(body.velocity, body_before.velocity), mass);
        let momentum = mass * length(body.velocity) + m * v.iter().map(|v| length(*v)).sum::<f64>();
        assert!(length(add(impulse, body_gain)) < 1e-12 * momentum);
        assert!(length(sub(sub(contact.impulse, contact_before.impulse), body_gain)) < 1e-12 * momentum);
        before = (now, v, body, contact);
    }
    worst
}

#[test]
fn work_energy_identity_of_every_step_with_a_sphere_through_failure() {
    let mut scene = small_sheet(21, 120.0);
    scene.yarn.stochastic = true;
    let worst = work_energy_identity(&scene, 700);
    println!("figure 16b: sphere through failure: {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn work_energy_identity_of_every_step_with_a_turning_cylinder() {
    let mut scene = tilted_cylinder(21, 0.35, 80.0);
    scene.projectile.angular_velocity = [300.0, -500.0, 2000.0];
    let worst = work_energy_identity(&scene, 700);
    println!("figure 16b: turning cylinder: {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}
