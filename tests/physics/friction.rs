//! Friction between yarn and projectile against closed forms: the impulse of one contact, a block that comes
//! to rest, a sphere that is made to roll, and what friction must never do: add energy, momentum or turning,
//! or depend on the order of the nodes.

use fabric_kernel::Form;
use fabric_kernel::internals::candidate::StepInputs;
use fabric_kernel::internals::records::{Candidate, Tangential};
use fabric_kernel::internals::solve::solve;
use fabric_kernel::pose::{self, Vector};
use fabric_kernel::{AttachmentKind, Shape, Symmetry};
use fabric_kernel::{Body, Inertia, Motion};
use fabric_tests::reference::{V3, add, cross, dot, length, rest_positions, scale, sub, turn};
use fabric_tests::{close, positions, rough, sim_of, small_sheet};
use proptest::prelude::*;

/// A sphere that meets one held node with the velocity V across the line of centres and W along it, and turns
/// at the rate w, is sticking if mu W >= 2/7 of its slip, and then rolls: it takes 2/7 of the slip as
/// velocity. Else the impulse across is mu M W.
#[test]
fn a_sphere_on_one_held_node_slides_or_rolls_as_a_rigid_body_does() {
    let sheet = small_sheet(2, 0.0);
    let (mass, radius) = (sheet.projectile.mass, sheet.projectile.radius);
    let inertia = 0.4 * mass * radius * radius;
    for (normal, across) in [
        ([0.0, 0.0, 1.0], [0.6, 0.8, 0.0]),
        ([0.6, 0.0, 0.8], [0.0, 1.0, 0.0]),
        ([0.48, 0.36, 0.8], [0.8, -0.6, -0.36]),
    ] {
        let across = scale(
            sub(across, scale(normal, dot(across, normal))),
            1.0 / length(sub(across, scale(normal, dot(across, normal)))),
        );
        let axis = cross(normal, across);
        for (v, w, rate) in [
            (10.0, 40.0, 0.0),
            (40.0, 40.0, 0.0),
            (0.0, 40.0, 1500.0),
            (0.0, 40.0, 9000.0),
            (-20.0, 40.0, -3000.0),
            (30.0, 40.0, -30.0 / 6.35e-3),
        ] {
            for mu in [0.01, 0.1, 0.5, 10.0] {
                let mut scene = rough(sheet, mu);
                let body = &mut scene.projectile;
                body.position = sub(rest_positions(&sheet)[0], scale(normal, radius));
                body.velocity = add(scale(normal, w), scale(across, v));
                body.angular_velocity = scale(axis, rate);
                let mut sim = sim_of(&scene);
                let first = sim.energy().unwrap().projectile_kinetic;
                sim.step().unwrap();
                // The point of contact R n moves at w x R n = rate R (axis x n) = rate R across.
                let slip = v + rate * radius;
                let stick = 2.0 / 7.0 * mass * slip;
                let impulse = if stick.abs() <= mu * mass * w { stick } else { (mu * mass * w).copysign(slip) };
                let after = sim.projectile().unwrap();
                let (v_after, rate_after) = (v - impulse / mass, rate - impulse * radius / inertia);
                assert!(length(sub(after.velocity, scale(across, v_after))) < 1e-12 * w, "{mu} {v} {rate}: {after:?}");
                assert!(
                    length(sub(after.angular_velocity, scale(axis, rate_after))) < 1e-11 * w / radius,
                    "{mu} {v} {rate}"
                );
                let energy = sim.energy().unwrap();
                let turning = 0.5 * mass * v_after * v_after + 0.5 * inertia * rate_after * rate_after;
                let along = 0.5 * mass * w * w;
                close(energy.contact_loss, along, 1e-12);
                assert!((energy.friction - (first - along - turning)).abs() < 1e-12 * first);
                assert!(energy.residual.abs() < 1e-13 * first);
                assert!((energy.support_work - (first - turning)).abs() < 1e-12 * first);
                let taken = add(scale(normal, mass * w), scale(across, impulse));
                assert!(length(sub(sim.support().unwrap().total, taken)) < 1e-12 * mass * w);
                assert!(length(sim.momentum_residual().unwrap()) < 1e-13 * mass * w);
                assert_eq!(sim.counters().unconverged, 0);
            }
        }
    }
}

/// A free node under the sphere is taken along by mu times the normal impulse, or wholly; the sphere is
/// turned by the reaction.
#[test]
fn a_free_node_takes_mu_times_the_normal_impulse_or_goes_along() {
    for (mu, v) in [(0.2, 50.0), (0.2, 15.0), (0.9, 50.0), (10.0, 50.0)] {
        let mut scene = rough(small_sheet(9, 0.0), mu);
        scene.projectile.velocity = [0.6 * v, -0.8 * v, 60.0];
        let (mass, radius, node) = (scene.projectile.mass, scene.projectile.radius, scene.sheet.node_mass);
        let mut sim = sim_of(&scene);
        let before = positions(&sim)[40];
        sim.step().unwrap();
        let normal = 60.0 / (1.0 / node + 1.0 / mass);
        let stick = v / (1.0 / node + 1.0 / mass + radius * radius / (0.4 * mass * radius * radius));
        let across = stick.min(mu * normal);
        let moved = scale(sub(positions(&sim)[40], before), 1.0 / sim.step_limits().dt);
        assert!(length(sub(moved, [0.6 * across / node, -0.8 * across / node, normal / node])) < 1e-9);
        let w = sim.projectile().unwrap().angular_velocity;
        // The reaction -across (0.6, -0.8, 0) acts at (0, 0, R).
        let rate = across * radius / (0.4 * mass * radius * radius);
        assert!(length(sub(w, [-0.8 * rate, -0.6 * rate, 0.0])) < 1e-9 * rate);
        assert_eq!(sim.counters().contacts, 1);
    }
}

/// A block of 1 kg under the load M g, on four held nodes or on a taut sheet that it covers, comes to rest
/// after V^2/(2 mu g), to half a step of its way, and stays. The heat is its kinetic energy. The block is
/// flat and does not tip.
#[test]
fn a_block_stops_where_coulomb_says() {
    let (g, speed) = (1e4, 0.5);
    for (nodes, mu) in [(2, 0.1), (2, 0.3), (5, 0.3)] {
        let mut scene = rough(small_sheet(nodes, 0.0), mu);
        scene.sheet.pre_strain = [0.01; 2];
        scene.sheet.node_mass *= 1e4;
        let h = scene.sheet.spacing;
        let body = &mut scene.projectile;
        (body.shape, body.size, body.mass) = (Shape::Box, [8.0 * h, 8.0 * h, 2.0 * h], 1.0);
        (body.position, body.velocity) = ([0.0, 0.0, -h], [0.8 * speed, -0.6 * speed, 0.0]);
        let mut sim = sim_of(&scene);
        sim.set_external_load([0.0, 0.0, g], [0.0; 3]).unwrap();
        let (dt, time, way) = (sim.step_limits().dt, speed / (mu * g), 0.5 * speed * speed / (mu * g));
        sim.advance((0.5 * time / dt) as u64).unwrap();
        // Each step takes mu g dt.
        let left = speed - mu * g * sim.time();
        assert!(length(sub(sim.projectile().unwrap().velocity, [0.8 * left, -0.6 * left, 0.0])) < 1e-8 * speed);
        sim.advance((0.6 * time / dt) as u64).unwrap();
        let end = sim.projectile().unwrap();
        let off = length(sub(end.position, [0.8 * way, -0.6 * way, -h]));
        assert!(off < 0.51 * speed * dt, "{nodes} {mu}: {off:e} of {way:e}");
        assert!(length(end.velocity) < 1e-9 * speed && length(end.angular_velocity) < 1e-6, "{end:?}");
        let energy = sim.energy().unwrap();
        close(energy.friction, 0.5 * speed * speed, 1e-8);
        assert!(energy.residual.abs() < 1e-8 * energy.friction);
        sim.advance(500).unwrap();
        assert!(length(sub(sim.projectile().unwrap().position, end.position)) < 1e-12);
    }
}

/// A cylinder pressed, tilted and rough, on 20 held and 15 free nodes, and a heavy spinning box on 18 held
/// ones: sweeps alone go on for thousands. The work of a step is bounded, what is given up is little and
/// told, and nothing adds energy.
#[test]
fn rough_bodies_on_held_nodes_take_bounded_work() {
    let sheet = |nodes_x: u32, nodes_y: u32, kind: AttachmentKind, mu: f64| {
        let mut scene = rough(small_sheet(nodes_x, 0.0), mu);
        (scene.sheet.nodes_y, scene.attachment.kind) = (nodes_y, kind);
        scene
    };
    let mut cylinder = sheet(7, 5, AttachmentKind::FourSides, 3.0);
    let h = cylinder.sheet.spacing;
    let body = &mut cylinder.projectile;
    (body.shape, body.mass) = (Shape::Cylinder, 0.018759612970823906);
    (body.radius, body.length) = (h * 5.101832945487887, h * 5.1528512749427655);
    let (tilt, about) = (-0.00987817214876796_f64, 2.0055268654656966_f64);
    let depth = 0.5 * body.length * tilt.cos() + body.radius * tilt.sin().abs();
    body.position = [h * -0.5803977212212148, h * 0.6054260561343963, -depth - 1e-7];
    let s = (0.5 * tilt).sin();
    body.orientation = [(0.5 * tilt).cos(), about.cos() * s, about.sin() * s, 0.0];
    body.velocity = [5.829415115433759, -7.5254063275155625, 5.675672637649035];
    let pressed = [-1254.1103775405097, -1469.2389470268174, 6869.836669155276].map(|a| body.mass * a);
    let mut heavy = sheet(2, 9, AttachmentKind::TwoSides, 10.0);
    let body = &mut heavy.projectile;
    (body.shape, body.mass) = (Shape::Box, 2.6008495286409983);
    body.size = [h * 2.6493015911893947, h * 11.285420814498876, h * 5.494853010174837];
    body.position = [h * -0.4162907473594295, h * 0.5312216250863044, -0.5 * body.size[2] - 1e-7];
    body.velocity = [16.03659830802169, 27.15930307208612, 24.921404282881];
    body.angular_velocity =
        [18.49493818290126, -8.176871162230308, 23.659603130702063].map(|speed| speed / (h * 9.50017475488001));
    for (scene, force) in [(cylinder, pressed), (heavy, [0.0; 3])] {
        let mut sim = sim_of(&scene);
        sim.set_external_load(force, [0.0; 3]).unwrap();
        let first = sim.energy().unwrap().projectile_kinetic;
        sim.advance(200).unwrap();
        let (counters, energy) = (sim.counters(), sim.energy().unwrap());
        println!(
            "rough on held nodes: {} sweeps, {} of 200 given up, off by {:e} m/s",
            counters.most_sweeps, counters.unconverged, counters.contact_residual
        );
        assert!(counters.most_sweeps <= 300, "{counters:?}");
        assert!(counters.unconverged <= 2 && (counters.unconverged > 0) == (counters.contact_residual > 0.0));
        assert!(energy.residual < 1e-12 * (first + energy.external_work.abs()), "{energy:?}");
    }
}

/// A body, and nodes under it of which some are held, in random places with random normals and speeds.
#[derive(Clone, Debug)]
struct Crowd {
    inertia: Inertia,
    body: Body,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    place: V3,
    normal: V3,
    velocity: V3,
    gap_over_dt: f64,
    held: bool,
}

/// Neither friction nor contact loss gives energy back: not where a spinning box lands on a held edge,
/// either, and its slip turns around within a step.
#[test]
fn friction_never_gives_energy_back() {
    let (mut lowest, mut fallen) = (0.0_f64, 0.0_f64);
    for k in 0..40 {
        let draw = |m: u64| fabric_tests::number(100 * k + m);
        let mut scene = rough(small_sheet(15, 20.0), 0.3);
        let h = scene.sheet.spacing;
        let body = &mut scene.projectile;
        (body.shape, body.size, body.mass) = (Shape::Box, [4.0 * h, 6.0 * h, 3.0 * h], 1e-3);
        body.orientation = pose::components(&pose::normalised([draw(0), draw(1) - 0.5, draw(2) - 0.5, draw(3) - 0.5]));
        body.angular_velocity = [4, 5, 6].map(|m| 4e4 * (draw(m) - 0.5));
        body.position = [7.0 * h, 10.0 * (draw(7) - 0.5) * h, -4.0 * h];
        let mut sim = sim_of(&scene);
        let first = sim.energy().unwrap();
        let brought = first.projectile_kinetic;
        let mut before = [0.0; 2];
        while sim.step_count() < 3000 && sim.counters().unconverged == 0 && sim.step().is_ok() {
            let energy = sim.energy().unwrap();
            let [loss, rubbed] = [energy.contact_loss - before[0], energy.friction - before[1]];
            fallen = fallen.max(-rubbed / brought);
            lowest = lowest.min(loss / brought);
            before = [energy.contact_loss, energy.friction];
        }
    }
    // Forces press nodes on again (`depth.rs`).
    assert!(fallen == 0.0 && lowest > -1e-5, "{fallen:e} {lowest:e}");
}

const NODE_MASS: f64 = 1e-3;

fn vectors(size: f64) -> impl Strategy<Value = V3> {
    [-size..size, -size..size, -size..size]
}

fn crowds(held: impl Strategy<Value = bool> + Clone, share: std::ops::Range<f64>) -> impl Strategy<Value = Crowd> {
    let node = (vectors(0.02), vectors(1.0), vectors(50.0), prop_oneof![Just(0.0), 0.0..20.0], held);
    let nodes = prop::collection::vec(node, 1..12);
    let body = (share, any::<bool>(), vectors(60.0), vectors(2000.0), vectors(1.0));
    (body, nodes).prop_map(|((share, round, velocity, rate, turn), nodes)| {
        let solid =
            if round { Form::Sphere { radius: 0.01 } } else { Form::Cylinder { radius: 0.006, half_length: 0.02 } };
        let mut inertia = Inertia::of(&solid.into(), share.exp() * NODE_MASS, true);
        inertia.feel_friction();
        let orientation = [1.0, turn[0], turn[1], turn[2]];
        let body = Body::of(&Motion { position: [0.0; 3], velocity, orientation, angular_velocity: rate });
        let nodes = nodes.into_iter().map(|(place, normal, velocity, gap_over_dt, held)| {
            let normal = [normal[0], normal[1], 1.2 + normal[2]];
            let velocity = if held { [0.0; 3] } else { velocity };
            Node { place, normal: scale(normal, 1.0 / length(normal)), velocity, gap_over_dt, held }
        });
        Crowd { inertia, body, nodes: nodes.collect() }
    })
}

/// What a solve of a crowd gave: body, impulses along the normal and across it.
struct Solution {
    converged: bool,
    velocity: V3,
    rate: V3,
    normal: Vec<f64>,
    across: Vec<V3>,
}

fn solved(crowd: &Crowd, coefficient: f64) -> Solution {
    let q = crowd.body.orientation;
    let mut candidates = Vec::new();
    let mut tangential = Vec::new();
    for node in &crowd.nodes {
        let (r, n, v) = (Vector::from(node.place), Vector::from(node.normal), Vector::from(node.velocity));
        candidates.push(Candidate {
            normal: n,
            arm: fabric_kernel::pose::into_body(&q, &r.cross(&n)),
            multiplicity: 1.0,
            held_by: u32::from(node.held),
            free_gap_rate: node.gap_over_dt + n.dot(&v),
            ..Candidate::default()
        });
        tangential.push(Tangential::at(&r, &n, &v, &crowd.body));
    }
    let given = StepInputs {
        body: &crowd.body,
        inertia: &crowd.inertia,
        node_mass: NODE_MASS,
        symmetry: Symmetry::default(),
        friction: coefficient,
    };
    let found = solve(&mut candidates, &mut tangential, &given);
    Solution {
        converged: found.converged,
        velocity: found.twist.velocity.into(),
        rate: found.twist.angular_velocity.into(),
        normal: candidates.iter().map(|c| c.impulse).collect(),
        across: tangential.iter().map(|t| t.as_vector(t.impulse).into()).collect(),
    }
}

/// Energy of body and nodes with these rates (angular: body axes) and node velocities, J.
fn kinetic(crowd: &Crowd, velocity: V3, rate: V3, nodes: impl Iterator<Item = V3>) -> f64 {
    let i = crowd.inertia.moments;
    let spin = i.x * rate[0] * rate[0] + i.y * rate[1] * rate[1] + i.z * rate[2] * rate[2];
    0.5 * (crowd.inertia.mass * dot(velocity, velocity) + spin + NODE_MASS * nodes.map(|v| dot(v, v)).sum::<f64>())
}

/// The laws of contact and friction hold in what has converged; nothing adds energy, converged or not.
fn check(crowd: &Crowd, coefficient: f64) -> Result<bool, TestCaseError> {
    let found = solved(crowd, coefficient);
    let after: Vec<V3> = (crowd.nodes.iter().zip(found.normal.iter().zip(&found.across)))
        .map(|(node, (lambda, across))| {
            let push = add(scale(node.normal, *lambda), *across);
            if node.held { [0.0; 3] } else { add(node.velocity, scale(push, 1.0 / NODE_MASS)) }
        })
        .collect();
    let before = kinetic(
        crowd,
        crowd.body.velocity.into(),
        crowd.body.angular_velocity.into(),
        crowd.nodes.iter().map(|node| node.velocity),
    );
    let end = kinetic(crowd, found.velocity, found.rate, after.iter().copied());
    prop_assert!(
        end <= before * (1.0 + 1e-13),
        "{:e} of {before:e} gained, converged: {}",
        end - before,
        found.converged
    );
    let q = [crowd.body.orientation.w, crowd.body.orientation.i, crowd.body.orientation.j, crowd.body.orientation.k];
    for (k, node) in crowd.nodes.iter().enumerate() {
        let (lambda, across) = (found.normal[k], found.across[k]);
        prop_assert!(lambda >= 0.0 && length(across) <= coefficient * lambda * (1.0 + 1e-12));
        if !found.converged {
            continue;
        }
        let surface = add(found.velocity, cross(turn(q, found.rate), node.place));
        let relative = sub(after[k], surface);
        let gap_rate = node.gap_over_dt + dot(node.normal, relative);
        prop_assert!(gap_rate > -1e-9 && (lambda == 0.0 || gap_rate < 1e-9), "{gap_rate:e} {lambda:e}");
        let slip = sub(relative, scale(node.normal, dot(node.normal, relative)));
        // A speed is left over; the impulse that belongs to it is that of the mass that answers, the body's
        // where the node is held.
        let answering = if node.held { crowd.inertia.mass } else { NODE_MASS };
        let against = add(scale(slip, coefficient * lambda), scale(across, length(slip)));
        prop_assert!(
            length(against) < 1e-8 * answering * (1.0 + length(slip)) || length(slip) < 1e-9,
            "{slip:?} {across:?} {lambda}"
        );
    }
    Ok(found.converged)
}

proptest! {
    #![proptest_config(crate::random(2000))]

    #[test]
    fn random_contacts_obey_coulomb_and_gain_nothing(crowd in crowds(Just(false), 0.0..8.0), mu in 0.0..10.0) {
        check(&crowd, mu)?;
    }

    #[test]
    fn nor_do_those_of_held_nodes(crowd in crowds(any::<bool>(), 0.0..8.0), mu in 0.0..10.0) {
        check(&crowd, mu)?;
    }

    /// Free nodes, far lighter than the body; to rounding. (Coulomb's law may have several solutions for
    /// held or heavy ones.)
    #[test]
    fn the_order_of_the_nodes_does_not_matter(crowd in crowds(Just(false), 5.0..9.0), mu in 0.0..10.0, turn in 0..12usize) {
        prop_assert!(check(&crowd, mu)?, "not converged");
        let mut other = crowd.clone();
        other.nodes.reverse();
        let turn = turn % other.nodes.len();
        other.nodes.rotate_left(turn);
        let (a, b) = (solved(&crowd, mu), solved(&other, mu));
        prop_assert!(length(sub(a.velocity, b.velocity)) < 1e-10 * 60.0, "{:?} {:?}", a.velocity, b.velocity);
        prop_assert!(length(sub(a.rate, b.rate)) < 1e-10 * 2000.0, "{:?} {:?}", a.rate, b.rate);
    }
}
