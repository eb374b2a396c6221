//! Viscosity of taut yarn against closed forms: the decay of single modes, the step limit, nothing from slack
//! yarn, and the energy balance of an impact.

use crate::balances::angular_momentum;
use crate::grading::graded;
use crate::stability::growth;
use fabric_kernel::internals::law::Viscosity;
use fabric_kernel::{AttachmentKind, Scene, TimeStep};
use fabric_tests::reference::{cross, length, sub};
use fabric_tests::{
    as_proposed, close, positions, set_off, sim_of, small_sheet, tilted_cylinder, velocities, viscous,
    without_projectile,
};

/// A sheet without projectile held at this strain.
fn pre_strained(nodes: u32, strain: f64) -> Scene {
    let mut scene = without_projectile(small_sheet(nodes, 0.0));
    scene.sheet.pre_strain = [strain; 2];
    scene
}

/// c dt/h of segments of natural length h/(1 + strain).
fn courant(scene: &Scene, dt: f64) -> f64 {
    let sheet = &scene.sheet;
    let stiffness = scene.yarn.modulus_mean * sheet.yarn_area / (sheet.spacing / (1.0 + sheet.pre_strain[0]));
    dt * (stiffness / sheet.node_mass).sqrt()
}

/// (M16) The force of a segment of stretch U whose ends move apart at the rate r: b_1 mu c h r U^2 + b_2 mu
/// (h r)^2 U^3, the second part while it is stretched. In units of m, h and dt: mu c h = sqrt(2 kk), mu h^2 =
/// 1.
#[test]
fn the_viscous_force_is_that_of_the_formula() {
    let (b1, b2, kk) = (0.06, 1.5, 0.08_f64);
    let viscosity = Viscosity::of([b1, b2, 0.0], kk, 0.06).lanes::<f64>();
    for (u, r) in [(1.0001, 1e-6), (1.02, 1e-3), (1.02, 1e-2), (1.02, -1e-5), (1.05, 0.02)] {
        let (twice_strain, growth) = (u * u - 1.0, 2.0 * u * r);
        let with_viscosity = viscosity.twice_strain(twice_strain, growth);
        let force = kk * with_viscosity * u;
        let quadratic = if r > 0.0 { b2 * r * r * u.powi(3) } else { 0.0 };
        close(force, kk * twice_strain * u + b1 * (2.0 * kk).sqrt() * r * u * u + quadratic, 1e-14);
    }
}

/// One free node between four, displaced by little along `axis`. Its scheme is x_{n+1} - 2 x_n + x_{n-1} +
/// Omega^2 x_n + K (x_n - x_{n-1}) = 0, so D_n = x_{n+1} x_{n-1} - x_n^2 falls by the factor 1 - K in every
/// step, whatever Omega.
fn decay(scene: &Scene, axis: usize) -> f64 {
    let mut sim = sim_of(scene);
    set_off(&mut sim, |k, mut x| {
        x[axis] += if k == 4 { 1e-7 * scene.sheet.spacing } else { 0.0 };
        [x, [0.0; 3]]
    });
    let mut places = Vec::new();
    for _ in 0..20 {
        sim.step().unwrap();
        places.push(positions(&sim)[4][axis] / scene.sheet.spacing * 1e7);
    }
    let d = |n: usize| places[n + 1] * places[n - 1] - places[n] * places[n];
    (d(15) / d(5)).powf(0.1)
}

#[test]
fn a_node_between_four_decays_as_the_scheme_says() {
    let strain = 0.01_f64;
    for [linear, bending] in [[0.0, 0.0], [0.2, 0.0], [0.0, 0.05], [0.06, 0.06]] {
        // Alone, and of two yarns each way between bars of two segments, which have the force of one and no
        // moment.
        for (nodes, width, moments) in [(3, 1.0, 8.0), (5, 2.0, 0.0)] {
            let scene = graded(viscous(pre_strained(nodes, strain), [linear, 0.0, bending]), 0.0, 2, 1);
            let c = courant(&scene, scene.step_limits().unwrap().dt);
            // Two segments along x of which each resists by C b_1 U^2; across the sheet a moment in each of
            // the two yarns, by 4 C b_3.
            let along = 2.0 * c * linear * (1.0 + strain).powi(2) / width;
            close(decay(&scene, 0), 1.0 - along, 1e-5);
            close(decay(&scene, 1), 1.0 - along, 1e-5);
            close(decay(&scene, 2), 1.0 - moments * c * bending, 1e-5);
        }
    }
}

/// A mode is stable while Omega^2 + 2 K < 4: of the chequerboard in the plane K = 4 C b_1 U^2, across it K =
/// 32 C b_3. The sheet of 31 nodes reaches it within 1 %. The largest step that the kernel takes, which
/// allows for both in one mode, lies below.
#[test]
fn the_limit_of_a_viscous_sheet_is_where_the_formula_says() {
    let strain = 0.02_f64;
    for [linear, bending] in [[0.8, 0.0], [0.0, 0.15], [0.3, 0.1]] {
        let scene = viscous(pre_strained(31, strain), [linear, 0.0, bending]);
        let scene = Scene { time_step: TimeStep::fraction(0.05), ..scene };
        let u2 = (1.0 + strain).powi(2);
        let c = courant(&scene, 1.0);
        // K over dt.
        let limit = |omega2: f64, k: f64| ((k * k + 4.0 * omega2).sqrt() - k) / omega2;
        let in_plane = limit(c * c * (2.0 * (3.0 * u2 - 1.0) + 2.0 * (u2 - 1.0)), c * 4.0 * linear * u2);
        let limit = in_plane.min(limit(c * c * 4.0 * (u2 - 1.0), c * 32.0 * bending));
        assert!(growth(&scene, 1.0, 0.98 * limit, 4000) < 100.0, "{linear} {bending}");
        assert!(growth(&scene, 1.0, 1.02 * limit, 1500) > 1e6, "{linear} {bending}");
        let limits = scene.step_limits().unwrap();
        assert!(limits.step_max < limit && limits.step_max > 0.4 * limit);
        if linear < 0.5 {
            assert!(limits.step_max < 0.5 * limits.dt_crit, "{linear} {bending}");
        }
    }
}

#[test]
fn what_viscosity_proposes_takes_the_default_step() {
    for scene in [Scene::sheet_3in_sphere(), Scene::sheet_10in_cylinder()] {
        assert_eq!(as_proposed(scene).step_limits().unwrap(), scene.step_limits().unwrap());
    }
}

/// A sheet that is nowhere taut moves with viscosity as it does without, bit for bit.
#[test]
fn slack_yarn_has_no_viscosity() {
    let mut scene = without_projectile(small_sheet(15, 0.0));
    scene.attachment.kind = AttachmentKind::Free;
    let run = |scene: &Scene| {
        let mut sim = sim_of(scene);
        let speed = |k: usize| 3.0 * (1.7 * k as f64).sin();
        set_off(&mut sim, |k, x| [[0.97 * x[0], 0.96 * x[1], 0.0], [0, 1, 2].map(|axis| speed(3 * k + axis))]);
        sim.advance(100).unwrap();
        let energy = sim.energy().unwrap();
        assert_eq!((energy.strain, energy.viscous), (0.0, 0.0));
        (positions(&sim), velocities(&sim))
    };
    assert_eq!(run(&scene), run(&as_proposed(scene)));
}

/// A crimped sheet, taut and slack all the time, gains energy before anything fails; viscous, as textiles
/// are, it does not.
#[test]
fn viscosity_stops_the_energy_gain_of_crimped_sheets() {
    let residual = |scene: Scene| {
        let mut scene = Scene { time_step: TimeStep::fraction(0.4), ..scene };
        scene.sheet.crimp = [0.01; 2];
        let mut sim = sim_of(&scene);
        sim.advance((0.6e-3 / sim.step_limits().dt) as u64).unwrap();
        assert_eq!(sim.counters().failed_segments, 0);
        sim.energy().unwrap().residual / (0.5 * scene.projectile.mass * scene.projectile.velocity[2].powi(2))
    };
    let sheet = small_sheet(41, 12.0);
    let (without, with) = (residual(sheet), residual(as_proposed(sheet)));
    println!("crimped sheet: residual over KE0 {without:e} without viscosity, {with:e} with");
    assert!(without > 0.003 && with.abs() < 0.1 * without, "{without:e} {with:e}");
}

/// Angular momentum of a free sheet that a tilted cylinder strikes, and of one struck far from its middle,
/// over what was exchanged about the origin. The viscosity along the yarn acts along the line between two
/// nodes, so it is exact; the moment resists the turning of a kinked yarn too, which costs a thousandth.
#[test]
fn the_moment_alone_touches_angular_momentum_and_little() {
    let off = |viscosity: [f64; 3], far: bool| {
        let mut scene = viscous(if far { small_sheet(41, 60.0) } else { tilted_cylinder(31, 0.4, 60.0) }, viscosity);
        scene.attachment.kind = AttachmentKind::Free;
        if far {
            scene.projectile.radius = 3e-3;
            scene.projectile.position = [6e-3, 4e-3, -3.1e-3];
        }
        let mut sim = sim_of(&scene);
        let first = angular_momentum(&sim);
        sim.advance(3000).unwrap();
        let contact = sim.contact().unwrap();
        let given = if far {
            length(cross(scene.projectile.position, contact.impulse))
        } else {
            length(contact.angular_impulse)
        };
        assert!(sim.counters().failed_segments == 0 && given > 1e-7, "{given:e}");
        length(sub(angular_momentum(&sim), first)) / given
    };
    for far in [false, true] {
        let (along, with_moment) = (off([0.06, 1.5, 0.0], far), off([0.06, 1.5, 0.06], far));
        println!(
            "viscous sheet, angular momentum over what was exchanged: {along:.1e} along the yarn, {with_moment:.1e} with the moment"
        );
        // A sphere that slides on a sheet leaves 3e-10 by itself, without viscosity too.
        assert!(along < 1e-9 && with_moment < 0.005, "{along:e} {with_moment:e}");
    }
}
