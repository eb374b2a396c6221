//! Momentum and energy balances, from read-outs and plain formulas rather than from the kernel's own ledger.

use crate::fabrics::hit;
use crate::grading::graded;
use crate::plies::{another, stacked, with_back};
use fabric_kernel::{
    AttachmentKind, Drive, Energy, Grading, Integrator, Scene, Shape, Sim, StrengthDraw, Symmetry, TimeStep,
};
use fabric_tests::reference::{
    V3, add, cross, dot, fixed_nodes, forces, length, moments, projectile_energy, rest_positions, scale, sub, turn,
    turn_back,
};
use fabric_tests::{
    as_proposed, close, damage, drawn, positions, rated, rough, sim_of, small_sheet, speed, velocities, viscous,
};

/// Momentum of projectile and free nodes, N s.
pub(crate) fn linear_momentum(sim: &Sim<'_>) -> V3 {
    let (body, m) =
        (scale(sim.projectile().unwrap().velocity, sim.scene().projectile.mass), sim.scene().sheet.node_mass);
    velocities(sim).iter().fold(body, |sum, v| add(sum, scale(*v, m)))
}

/// Angular momentum of projectile and free nodes about the origin, N m s: with velocity Verlet the projectile's velocity is that half a step before.
pub(crate) fn angular_momentum(sim: &Sim<'_>) -> V3 {
    let scene = sim.scene();
    let (m, mass, inertia) = (scene.sheet.node_mass, scene.projectile.mass, moments(scene));
    let body = sim.projectile().unwrap();
    let w = turn_back(body.orientation, body.angular_velocity);
    let spin = turn(body.orientation, [inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2]]);
    let half = if scene.integrator == Integrator::VERLET { 0.5 * sim.step_limits().dt } else { 0.0 };
    let place = sub(body.position, scale(body.velocity, half));
    let nodes = positions(sim).into_iter().zip(velocities(sim));
    nodes.fold(add(spin, cross(place, scale(body.velocity, mass))), |sum, (x, v)| add(sum, cross(x, scale(v, m))))
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
    let worst = work_energy_identity(&drawn(small_sheet(21, 120.0)), 700);
    println!("figure 16b: sphere through failure: {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}

/// The sphere on a sheet of 41 x 41 at `speed`, m/s, that also rubs and spins if the coefficient is not 0.
fn impact(speed: f64, friction: f64) -> Scene {
    let mut scene = rough(small_sheet(41, speed), friction);
    if friction > 0.0 {
        scene.projectile.velocity = [0.5 * speed, -0.2 * speed, speed];
        scene.projectile.angular_velocity = [2000.0, 1000.0, -3000.0];
    }
    scene
}

/// A part of the energy, J.
type Part = fn(&Energy) -> f64;

/// What the balances do not close by before the first failure falls with the square of the step, whatever takes part.
#[test]
fn the_balances_of_an_impact_close_to_second_order() {
    let plies = stacked(small_sheet(31, 40.0), 4, 1e-4);
    let graded = graded(small_sheet(61, 40.0), 12.0, 8, 2);
    let cases: [(&str, Scene, f64, f64, Part, f64); 6] = [
        ("friction", impact(50.0, 0.4), 30e-6, 1e-4, |energy| energy.friction, 1e-3),
        ("viscous", as_proposed(impact(60.0, 0.0)), 30e-6, 1e-3, |energy| energy.viscous, 1e-4),
        ("rate", rated(impact(60.0, 0.0), 1700.0), 20e-6, 1e-5, |energy| energy.viscous, 1e-4),
        ("graded", graded, 30e-6, 1e-3, |energy| energy.strain, 1e-3),
        ("plies", plies, 12e-6, 1e-4, |energy| energy.ply_loss, 1e-6),
        ("rough plies", rough(plies, 0.3), 12e-6, 1e-4, |energy| energy.ply_loss, 1e-6),
    ];
    for (name, scene, time, limit, part, share) in cases {
        let off = |fraction: f64| {
            let scene = Scene { time_step: TimeStep::fraction(fraction), ..scene };
            let mut sim = sim_of(&scene);
            let first = sim.energy().unwrap().projectile_kinetic;
            sim.advance((time / sim.step_limits().dt) as u64).unwrap();
            let energy = sim.energy().unwrap();
            assert!(sim.counters().failed_segments == 0 && part(&energy) > share * first, "{name}: {energy:?}");
            energy.residual.abs() / first
        };
        let residuals = [0.4, 0.2, 0.1].map(off);
        println!("{name}: residual over KE0 at 0.4, 0.2, 0.1 dt_crit: {residuals:?}");
        assert!(residuals[0] < limit, "{name}: {residuals:?}");
        assert!(residuals[1] < 0.4 * residuals[0] && residuals[2] < 0.4 * residuals[1], "{name}: {residuals:?}");
        assert!(residuals[2] < residuals[0] / 8.0, "{name}: {residuals:?}");
    }
}

/// A sheet that is struck through, the steps of it, more segments than so many fail, and a part of the energy is more than a share.
type Torn = (&'static str, Scene, u64, u64, Part, f64);

fn torn() -> Vec<Torn> {
    let (plain, rubs, rate) = (impact(120.0, 0.0), impact(120.0, 0.4), rated(impact(120.0, 0.0), 1700.0));
    let with_fraction = |scene: Scene, fraction| Scene { time_step: TimeStep::fraction(fraction), ..scene };
    let balanced = |scene: Scene| Scene { slack_balance: true, ..scene };
    let mut rate_drawn = drawn(rate);
    rate_drawn.yarn.strength_draw = StrengthDraw::Weibull;
    let mut crimped = with_fraction(rate, 0.2);
    crimped.sheet.crimp = [0.003, 0.001];
    let mut prescribed = rubs;
    (prescribed.drive, prescribed.projectile.shape) = (Drive::Prescribed, Shape::Cylinder);
    prescribed.projectile.position[2] = -0.7 * prescribed.projectile.length;
    let mut weak = small_sheet(41, 80.0);
    let yarn = &mut weak.yarn;
    (yarn.strength_draw, yarn.weibull_shape, yarn.weibull_gauge_length) = (StrengthDraw::Weibull, 10.0, 0.01);
    let mut free = as_proposed(small_sheet(41, 1200.0));
    (free.attachment.kind, free.yarn.stochastic) = (AttachmentKind::Free, true);
    // Drawn yarn held by its sides, hit beside the middle.
    let mut graded = drawn(small_sheet(61, 200.0));
    graded.attachment.kind = AttachmentKind::TwoSides;
    let half_width = [10.0 * graded.sheet.spacing; 2];
    graded.sheet.grading = Grading { largest: 4, run: 2, centre: [3e-3, -2e-3], half_width };
    graded.projectile.position = [3e-3, -2e-3, -6.35e-3];
    let hybrid = with_back(stacked(small_sheet(31, 120.0), 3, 1e-4), 2, another);
    let quarter = Symmetry { mirror_x: true, mirror_y: true };
    let [friction, taken, dissipated]: [Part; 3] = [|e| e.friction, |e| e.viscous, |e| e.dissipated];
    let mut cases = vec![
        ("friction", rubs, 2500, 30, friction, 1e-2),
        ("friction, balanced", balanced(rubs), 2500, 30, friction, 1e-2),
        ("friction, viscous", viscous(rubs, [0.06, 0.0, 0.06]), 2500, 30, friction, 1e-2),
        ("friction, prescribed", prescribed, 2500, 30, friction, 1e-2),
        ("rate", rate, 2800, 20, taken, 1e-3),
        ("rate, drawn", rate_drawn, 2800, 20, taken, 1e-3),
        ("rate, viscous", viscous(rate, [0.06, 0.0, 0.06]), 2800, 20, taken, 1e-3),
        ("rate, crimped", crimped, 5600, 20, taken, 1e-3),
        ("viscous", as_proposed(plain), 4000, 50, taken, 1e-3),
        ("viscous, balanced", balanced(as_proposed(plain)), 4000, 50, taken, 1e-3),
        ("viscous, free", free, 1500, 10, taken, 1e-5),
        ("drawn strength", weak, 2500, 20, dissipated, 1e-2),
        ("quarter", Scene { symmetry: quarter, ..small_sheet(41, 95.0) }, 5000, 50, dissipated, 1e-3),
        ("graded", graded, 6000, 50, dissipated, 5e-4),
        // The supports of each ply take what its own mass asks for.
        ("hybrid pack, balanced", balanced(hybrid), 1500, 10, dissipated, 1e-4),
    ];
    for ((name, scene), slack_balance) in hit().into_iter().zip([false, true, true, false]) {
        let mut scene = with_fraction(Scene { slack_balance, ..scene }, 0.25);
        let sphere = scene.projectile.shape == Shape::Sphere;
        scene.projectile.velocity[2] = if sphere { speed(60.0, scene.projectile.mass) } else { 120.0 };
        cases.push((name, scene, 3600, 10, dissipated, 1e-3));
    }
    cases
}

/// Through failure energy closes to a percent and momentum to rounding; what is taken never comes back.
#[test]
fn the_balances_of_a_perforation_close() {
    for (name, scene, steps, failed, part, share) in torn() {
        let mut sim = sim_of(&scene);
        let first = sim.energy().unwrap().projectile_kinetic;
        let (momentum, mut taken) = (scene.projectile.mass * length(scene.projectile.velocity), 0.0);
        for _ in 0..20 {
            sim.advance(steps / 20).unwrap();
            let energy = sim.energy().unwrap();
            assert!(energy.viscous >= taken, "{name}");
            taken = energy.viscous;
        }
        let (energy, counters) = (sim.energy().unwrap(), sim.counters());
        let off = length(sim.momentum_residual().unwrap()) / momentum;
        println!("figure 17: {name}, through failure: {off:.1e}; residual {:.5} of KE0", energy.residual / first);
        assert!(counters.failed_segments > failed && part(&energy) > share * first, "{name}: {counters:?} {energy:?}");
        assert!(energy.residual.abs() < 0.01 * first && off < 1e-12, "{name}: {:e} {off:e}", energy.residual / first);
        if scene.drive == Drive::Free && scene.contact.friction == 0.0 {
            close(energy.projectile_kinetic + energy.contact_work, first, 1e-12);
        }
        assert_eq!((counters.unconverged, counters.beyond_fine), (0, 0), "{name}");
    }
}
