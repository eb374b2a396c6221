//! Graded networks: bars that stand for several yarns and crossings carry the mass, the tension and the waves
//! of what they replace.
//! (Their balances are in `balances`.)

use crate::plies::{another, stacked, with_back};
use fabric_kernel::{AttachmentKind, Drive, Grading, Integrator, Projectile, Scene, Shape, Sim};
use fabric_tests::reference::length;
use fabric_tests::{
    as_proposed, close, damage, drawn, positions, rated, rough, set_off, sim_of, small_sheet, stepped, velocities,
    without_projectile,
};

/// Fine within `half` spacings of the middle, then `run` bars of 2, 4 ... up to `largest` yarns.
pub(crate) fn graded(mut scene: Scene, half: f64, largest: u32, run: u32) -> Scene {
    let half_width = scene.spacings().map(|h| half * h);
    scene.sheet.grading = Grading { largest, run, half_width, ..scene.sheet.grading };
    scene
}

/// Positions, velocities and damage, all that nodes and segments are, and dissipated energies, J.
type State = (Vec<[f64; 3]>, Vec<[f64; 3]>, Vec<f64>, [f64; 3]);

fn state_after(scene: &Scene, steps: u64) -> State {
    let sim = stepped(scene, steps);
    let energy = sim.energy().unwrap();
    (positions(&sim), velocities(&sim), damage(&sim), [energy.viscous, energy.friction, energy.attachment])
}

/// No grading, bars of one yarn, and a fine part as large as the sheet are the fabric, to the bit.
#[test]
fn a_network_of_single_yarns_is_the_fabric_to_the_bit() {
    let mut scenes = [drawn(small_sheet(41, 150.0)); 9];
    scenes[1].slack_balance = true;
    (scenes[2].sheet.spacing_y, scenes[2].sheet.crimp) = (9e-4, [0.0, 0.004]);
    scenes[3].yarn.strength_draw = fabric_kernel::StrengthDraw::Weibull;
    (scenes[4].integrator, scenes[4].projectile.velocity[2]) = (Integrator::THETA, 600.0);
    scenes[5] = rough(as_proposed(Scene { slack_balance: true, ..scenes[5] }), 0.3);
    (scenes[6], scenes[7].attachment.hold) = (rated(as_proposed(scenes[6]), 1700.0), 20.0);
    scenes[7].projectile.velocity[2] = 300.0;
    scenes[8] = with_back(stacked(rough(as_proposed(scenes[2]), 0.3), 2, 1e-4), 1, another);
    for (k, scene) in scenes.into_iter().enumerate() {
        let steps = if k == 4 { 400 } else { 2000 };
        let whole = state_after(&scene, steps);
        assert!(whole.2.iter().any(|alpha| *alpha < 1.0), "{k}");
        assert!(k < 5 || whole.3.iter().sum::<f64>() > 0.0, "{k}");
        for grading in [graded(scene, 3.0, 1, 4), graded(scene, 20.0, 4, 4)] {
            assert!(state_after(&grading, steps) == whole, "{k} {:?}", grading.sheet.grading);
        }
    }
}

/// Nodes hold the mass of the fabric and bars its section: a sheet that moves as a whole has its kinetic
/// energy, one that is stretched evenly its strain energy, and no force on the nodes inside.
#[test]
fn mass_and_section_are_those_of_the_fabric() {
    for (nodes, half, largest, run, centre) in [
        (60, 5.0, 8, 2, 0.0),
        (61, 0.0, 64, 1, 0.0),
        (45, 3.0, 4, 1, 8.3e-3),
        (33, 40.0, 2, 1, 0.0),
        (50, 0.2, 2, 3, -1.0),
    ] {
        let mut whole = without_projectile(small_sheet(nodes, 0.0));
        (whole.sheet.nodes_y, whole.sheet.spacing_y) = (nodes + 7, 8e-4);
        whole.attachment.kind = AttachmentKind::Free;
        let mut part = graded(whole, half, largest, run);
        part.sheet.grading.centre = [centre, -0.5 * centre];
        let kinetic = |scene: &Scene| {
            let mut sim = sim_of(scene);
            set_off(&mut sim, |_, x| [x, [3.0, -4.0, 5.0]]);
            sim.energy().unwrap().fabric_kinetic
        };
        let mass = whole.sheet.node_mass * f64::from(nodes * (nodes + 7));
        close(kinetic(&whole), 25.0 * mass, 1e-12);
        close(kinetic(&part), 25.0 * mass, 1e-12);
        let strain = |scene: Scene| {
            let scene = Scene { integrator: Integrator::THETA, ..scene };
            stretched(&scene).energy().unwrap().strain
        };
        close(strain(part), strain(whole), 1e-12);
        let mut sim = stretched(&part);
        sim.step().unwrap();
        let (nx, ny) = (sim.layout().nodes_x, sim.layout().nodes_y);
        assert!(nx < nodes as usize || half == 40.0);
        let v = velocities(&sim);
        for k in (2..ny - 2).flat_map(|j| (2..nx - 2).map(move |i| j * nx + i)) {
            assert!(v[k].iter().all(|v| v.abs() < 1e-9), "{:?}", v[k]);
        }
    }
}

/// The sheet at rest, 1 % longer along x and 2 % along y.
fn stretched(scene: &Scene) -> Sim<'static> {
    let mut sim = sim_of(scene);
    set_off(&mut sim, |_, x| [[1.01 * x[0], 1.02 * x[1], x[2]], [0.0; 3]]);
    sim
}

/// Before the first failure the theta rule and velocity Verlet agree, on a graded network as on any.
#[test]
fn the_theta_rule_agrees() {
    let scene = graded(small_sheet(45, 30.0), 9.0, 4, 1);
    let at = |integrator| {
        let mut scene = Scene { integrator, ..scene };
        scene.time_step = fabric_kernel::TimeStep::seconds(5e-9);
        state_after(&scene, 2000).0
    };
    let h = scene.sheet.spacing;
    for (a, b) in at(Integrator::VERLET).into_iter().zip(at(Integrator::THETA)) {
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 2e-4 * h), "{a:?} {b:?}");
    }
}

/// A strip held taut, along which a Gaussian wave with the standard deviation sigma, spacings, runs to the
/// right from x = -150 h:
/// longitudinal (axis 0) or across the sheet (2). Place and displacement of its middle row after `time` s,
/// spacings.
fn wave(scene: &Scene, sigma: f64, axis: usize, time: f64) -> Vec<(f64, f64)> {
    let (h, mut sim) = (scene.sheet.spacing, sim_of(scene));
    let rest: Vec<[f64; 3]> = positions(&sim);
    let columns = sim.layout().nodes_x;
    let middle = (sim.layout().nodes_y / 2) * columns;
    let speed = wave_speed(scene, axis);
    let shape = |x: f64| 1e-3 * (-0.5 * ((x / h + 150.0) / sigma).powi(2)).exp();
    let slope = |x: f64| -(x / h + 150.0) / (sigma * sigma) * shape(x);
    set_off(&mut sim, |k, place| {
        let (mut moved, mut velocity) = (place, [0.0; 3]);
        moved[axis] += shape(place[0]) * h;
        let held = k % columns == 0 || k % columns == columns - 1;
        velocity[axis] = if held { 0.0 } else { -speed * slope(place[0]) };
        [moved, velocity]
    });
    sim.advance((time / sim.step_limits().dt).round() as u64).unwrap();
    let now = positions(&sim);
    (0..columns).map(|i| (rest[middle + i][0] / h, (now[middle + i][axis] - rest[middle + i][axis]) / h)).collect()
}

/// Speed of small waves in yarns held at the strain p: c sqrt((3 U^2 - 1)/2) along them, c sqrt((U^2 - 1)/2)
/// across, per rest length.
fn wave_speed(scene: &Scene, axis: usize) -> f64 {
    let sheet = &scene.sheet;
    let stretch = 1.0 + sheet.pre_strain[0];
    // Natural length h/U, so k = E A U/h; the flat sheet's spacing is h.
    let stiffness = scene.yarn.modulus_mean * sheet.yarn_area * stretch / sheet.spacing;
    let square = stretch * stretch;
    let tangent = if axis == 0 { 0.5 * (3.0 * square - 1.0) } else { 0.5 * (square - 1.0) };
    sheet.spacing * (stiffness * tangent / sheet.node_mass).sqrt()
}

/// A wave that runs from single yarns into bars of two goes on at its speed; what comes back is 0.2 % of its
/// height if its standard deviation is 10 spacings, and falls with the square of the spacing over its length.
/// With viscosity, which takes more of a wave in longer bars, not more comes back.
#[test]
fn waves_run_through_a_grading_step() {
    let mut scene = without_projectile(small_sheet(601, 0.0));
    (scene.sheet.nodes_y, scene.attachment.kind) = (5, AttachmentKind::TwoSides);
    scene.sheet.pre_strain = [0.01, 0.0];
    scene.yarn.critical_stretch = 1.05;
    let h = scene.sheet.spacing;
    for (axis, damped) in [(0, false), (2, false), (0, true), (2, true)] {
        let scene = if damped { as_proposed(scene) } else { scene };
        let time = 300.0 * h / wave_speed(&scene, axis);
        let mut echoes = Vec::new();
        for sigma in [10.0, 20.0] {
            let measure = |largest: u32| {
                let mut scene = graded(scene, 0.0, largest, 1_000_000);
                if largest > 1 {
                    // Fine to the left of x = 0, the wave's start with it.
                    scene.sheet.grading.centre[0] = -150.0 * h;
                    scene.sheet.grading.half_width = [150.0 * h, 1e-2];
                }
                let line = wave(&scene, sigma, axis, time);
                let peak = line.iter().copied().fold((0.0, 0.0), |a: (f64, f64), b| if b.1 > a.1 { b } else { a });
                // The echo lies about -150 h again.
                let echo = line.iter().filter(|(x, _)| *x < -60.0).fold(0.0, |a: f64, (_, u)| a.max(u.abs()));
                (peak, echo / 1e-3)
            };
            let ((_, _), none) = measure(1);
            let ((place, height), echo) = measure(2);
            println!(
                "axis {axis}, sigma {sigma} h: arrives at {place} with {height:e}, echo {echo:e}, without step {none:e}"
            );
            assert!(
                (place - 150.0).abs() <= 2.0 && (damped || (height / 1e-3 - 1.0).abs() < 6e-3),
                "{place} {height:e}"
            );
            assert!(damped || none < 4e-4);
            echoes.push(echo);
        }
        assert!(echoes[0] < 2.5e-3 && (damped || echoes[1] < echoes[0] / 3.5), "{echoes:?}");
    }
}

/// A smooth motion of a taut sheet: the error against the fabric falls with the square of the bars.
#[test]
fn a_graded_sheet_converges_to_the_fabric() {
    let mut scene = without_projectile(small_sheet(129, 0.0));
    scene.sheet.pre_strain = [0.01, 0.01];
    scene.yarn.critical_stretch = 1.05;
    let half = scene.half_size()[0];
    let centre = |scene: &Scene| {
        let mut sim = sim_of(scene);
        let rest = positions(&sim);
        let wave = |x: f64| (0.5 * std::f64::consts::PI * x / half).cos();
        let edge = |x: [f64; 3]| x[0].abs().max(x[1].abs()) > half * (1.0 - 1e-9);
        set_off(&mut sim, |_, x| [x, [0.0, 0.0, if edge(x) { 0.0 } else { 2.0 * wave(x[0]) * wave(x[1]) }]]);
        sim.advance(4000).unwrap();
        let now = positions(&sim);
        // The node in the middle.
        let k = rest.iter().position(|x| x[0].abs() + x[1].abs() < 1e-9).unwrap();
        now[k][2]
    };
    let fabric = centre(&scene);
    let errors = [2, 4, 8].map(|largest| (centre(&graded(scene, 0.0, largest, 1)) / fabric - 1.0).abs());
    println!("{fabric:e} m, errors {errors:?}");
    assert!(errors[2] < 1e-2 && errors[0] < errors[1] / 3.0 && errors[1] < errors[2] / 3.0, "{errors:?}");
}

/// A hit beside the fine part is told, and keeps momentum and energy.
#[test]
fn a_hit_beside_the_fine_part_is_counted() {
    let scene = graded(small_sheet(61, 100.0), 10.0, 8, 1);
    let plies = rough(stacked(scene, 3, 1e-4), 0.3);
    let spinning = Scene { projectile: Projectile { angular_velocity: [0.0, 9e3, 0.0], ..plies.projectile }, ..plies };
    for (scene, x, beside) in
        [(scene, 0.0, false), (scene, 4e-3, true), (scene, 0.018, true), (plies, 4e-3, true), (spinning, 0.018, true)]
    {
        let mut scene = scene;
        scene.projectile.position[0] = x;
        let sim = stepped(&scene, 2000);
        assert_eq!(sim.counters().beyond_fine > 0, beside, "{x}");
        let momentum = scene.projectile.mass * scene.projectile.velocity[2];
        let (energy, off) = (sim.energy().unwrap(), length(sim.momentum_residual().unwrap()) / momentum);
        assert!(off < 1e-12 && energy.residual.abs() < 1e-2 * energy.contact_work, "{x} {off:e} {energy:?}");
    }
}

/// Bars of 64 yarns, and a fine part of a single segment: the largest accepted step is stable, with a body
/// that a host moves.
#[test]
fn the_step_limit_is_that_of_the_fabric() {
    for (half, largest, run) in [(10.0, 64, 1), (0.3, 64, 1), (0.3, 2, 1), (4.0, 16, 2)] {
        let mut scene = graded(without_projectile(small_sheet(200, 0.0)), half, largest, run);
        let fabric = Scene {
            sheet: fabric_kernel::Sheet { grading: Grading { largest: 0, ..scene.sheet.grading }, ..scene.sheet },
            ..scene
        };
        assert_eq!(scene.step_limits().unwrap(), fabric.step_limits().unwrap());
        scene.sheet.pre_strain = [0.02, 0.02];
        scene.time_step = fabric_kernel::TimeStep::fraction(0.5);
        (scene.drive, scene.projectile.shape) = (Drive::Prescribed, Shape::Sphere);
        let mut sim = sim_of(&scene);
        let nx = sim.layout().nodes_x;
        let middle = (sim.layout().nodes_y / 2) * nx + nx / 2;
        set_off(&mut sim, |k, x| [x, [0.0, 0.0, if k == middle { 1.0 } else { 0.0 }]]);
        let first = sim.energy().unwrap();
        sim.advance(5000).unwrap();
        let last = sim.energy().unwrap();
        assert!(last.residual.abs() < 1e-2 * first.fabric_kinetic, "{half} {largest}: {last:?} {first:?}");
    }
}
