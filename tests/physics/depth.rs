//! How deep nodes get into a body without friction: a search over random scenes.

use fabric_kernel::internals::shape::Solid;
use fabric_kernel::{AttachmentKind, Drive, Grading, Projectile, Scene, Sector, Shape, Stack, TimeStep, pose};
use fabric_tests::reference::{V3, add, dot, length, scale, sub};
use fabric_tests::{number, positions, sim_of, small_sheet, tetrahedron, velocities};
use std::ops::Range;

/// A body of any shape, size, mass, attitude, velocity and spin just before a sheet that is held in any way.
fn drawn(k: u64) -> Scene {
    let draw = |m: u64| number(1000 * k + m);
    let between = |m: u64, low: f64, high: f64| low + (high - low) * draw(m);
    let log = |m: u64, low: f64, high: f64| low * (high / low).powf(draw(m));
    let mut scene = small_sheet(25, 0.0);
    let h = scene.sheet.spacing;
    let base = Projectile { mass: log(0, 1e-5, 3e-2), ..scene.projectile };
    let size = [log(1, 2.01, 14.0) * h, log(2, 2.01, 14.0) * h, log(3, 2.01, 14.0) * h];
    let radius = log(4, 1.01, 8.0) * h;
    let body = match k % 5 {
        0 => Projectile { shape: Shape::Box, size, ..base },
        1 => Projectile { shape: Shape::Cylinder, radius, length: size[2], ..base },
        2 => Projectile { shape: Shape::HemisphericalCylinder, radius, length: size[2].max(radius), ..base },
        3 => {
            let moments = [1.2 * base.mass * radius * radius; 3];
            Projectile { shape: Shape::Polyhedron, faces: tetrahedron(radius), moments, ..base }
        }
        _ => {
            let sector = Sector { inner_radius: 2.0 * h, outer_radius: 9.0 * h, angle: 1.1, thickness: size[2] };
            Projectile { shape: Shape::DiscSector, sector, ..base }
        }
    };
    scene.attachment.kind =
        [AttachmentKind::FourSides, AttachmentKind::TwoSides, AttachmentKind::Free][(3.0 * draw(5)) as usize];
    if draw(6) < 0.3 {
        // It would pass through fixed nodes.
        (scene.drive, scene.attachment.kind) = (Drive::Prescribed, AttachmentKind::Free);
    }
    if draw(7) < 0.2 {
        scene.sheet.grading = Grading { largest: 4, run: 2, half_width: [6.0 * h; 2], ..scene.sheet.grading };
    }
    let extra = draw(8);
    scene.slack_balance = extra < 0.2;
    scene.time_step = TimeStep::fraction(between(9, 0.1, 0.5));
    let orientation = pose::normalised([draw(10) - 0.5, draw(11) - 0.5, draw(12) - 0.5, draw(13) - 0.5]);
    if draw(25) < 0.3 {
        scene.sheet.thickness = log(26, 0.02, 3.0) * h;
    }
    let reach = Solid::of(&body).reach();
    let speed = log(14, 10.0, 600.0);
    let (way, turn) = ([draw(15) - 0.5, draw(16) - 0.5, draw(17)], [draw(18) - 0.5, draw(19) - 0.5, draw(20) - 0.5]);
    let [way_length, turn_length] = [way, turn].map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt());
    // A third does not spin; the others up to three times as fast at their rim as they fly.
    let spin = if draw(21) < 0.33 { 0.0 } else { log(22, 0.01, 3.0) * speed / reach };
    let ahead = Solid::of(&body).support(&pose::into_body(&orientation, &[0.0, 0.0, 1.0].into()));
    scene.projectile = Projectile {
        orientation: pose::components(&orientation),
        velocity: way.map(|x| x * speed / way_length),
        angular_velocity: turn.map(|x| x * spin / turn_length),
        position: [
            between(23, -12.0, 12.0) * h,
            between(24, -12.0, 12.0) * h,
            -ahead - 0.5 * scene.sheet.thickness - 1e-6 * h,
        ],
        ..body
    };
    scene
}

/// What a run shows.
struct Found {
    /// Deepest penetration over the spacing.
    depth: f64,
    /// The sum over the steps of |w| dt times (|V| + |w| reach) dt, over the spacing.
    bent: f64,
}

/// A run in which the body goes on by 12 spacings, or until several solves have run out of sweeps: faces that
/// bed on supports are not looked for here.
fn run(scene: &Scene) -> Found {
    let mut sim = sim_of(scene);
    let (dt, reach) = (sim.step_limits().dt, Solid::of(&scene.projectile).reach());
    let steps = 12.0 * scene.sheet.spacing / (length(scene.projectile.velocity) * dt);
    let mut bent = 0.0;
    for _ in 0..(steps as u64).clamp(200, 4000) {
        if sim.step().is_err() || sim.counters().unconverged > 2 || sim.counters().most_sweeps > 500 {
            break;
        }
        let motion = sim.projectile().unwrap();
        let spin = length(motion.angular_velocity);
        bent += spin * dt * (length(motion.velocity) + spin * reach) * dt;
    }
    let (depth, h) = (sim.counters().worst_penetration, scene.sheet.spacing);
    Found { depth: depth / h, bent: bent / h }
}

/// Without friction and where solves converge, a node gets into a body by no more than turning bends its way
/// in each step. The gap is closed along the plane that the step begins with; while the body turns by |w| dt
/// a node slides along that plane by at most (|V| + |v| + |w| r) dt, so that its depth grows by at most the
/// product. Nothing pushes it out again: the products add up. The node's own speed |v| is at most some twice
/// that of the body's surface. A body that does not turn is entered by no more than what counts as touching,
/// 1e-9 h.
fn search(scenes: Range<u64>) {
    let (mut deepest, mut most, mut count) = (Found { depth: 0.0, bent: 0.0 }, 0.0_f64, 0);
    for k in scenes {
        let scene = drawn(k);
        if scene.check().is_err() {
            continue;
        }
        let found = run(&scene);
        let bound = 3.0 * found.bent + 1.001e-9;
        assert!(found.depth <= bound, "{k}: {:e} h is not within {bound:e} h", found.depth);
        (most, count) = (most.max(found.depth / bound), count + 1);
        if found.depth > deepest.depth {
            println!("scene {k}: {:.2e} h, bent {:.2e} h", found.depth, found.bent);
            deepest = found;
        }
    }
    println!("{count} scenes: at most {:.2e} h, and {most:.2} of the bound", deepest.depth);
    assert!(deepest.depth > 1e-5);
}

#[test]
fn nodes_get_in_by_what_turning_bends_their_way() {
    search(0..60);
}

#[test]
#[ignore = "minutes; cargo xtask verify runs it"]
fn a_longer_search_for_deep_nodes() {
    search(0..1500);
}

/// A sphere of any size, mass and velocity just before two to five plies, on each other or not, held in any
/// way.
fn stack(k: u64) -> Scene {
    let draw = |m: u64| number(7_000_000 + 1000 * k + m);
    let log = |m: u64, low: f64, high: f64| low * (high / low).powf(draw(m));
    let mut scene = small_sheet(31, 0.0);
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (25 + (16.0 * draw(2)) as u32, 25 + (16.0 * draw(3)) as u32);
    let h = scene.sheet.spacing;
    let gap = if draw(4) < 0.4 { 0.0 } else { log(5, 1e-4, 0.5) * h };
    scene.stack = Stack { plies: 2 + (4.0 * draw(1)) as u32, gap, turned: false };
    scene.attachment.kind =
        [AttachmentKind::FourSides, AttachmentKind::TwoSides, AttachmentKind::Free][(3.0 * draw(6)) as usize];
    (scene.yarn.stochastic, scene.time_step) = (draw(7) < 0.5, TimeStep::fraction(0.1 + 0.4 * draw(8)));
    let (radius, speed) = (log(9, 1.01, 12.0) * h, log(10, 10.0, 300.0));
    let tilt = if draw(11) < 0.5 { 0.0 } else { draw(12) };
    let body = &mut scene.projectile;
    (body.radius, body.mass) = (radius, log(13, 1e-5, 0.3));
    body.velocity = [speed * tilt.sin(), 0.0, speed * tilt.cos()];
    body.position = [10.0 * (draw(14) - 0.5) * h, 10.0 * (draw(15) - 0.5) * h, -radius - 1e-6 * h];
    scene
}

/// A body that does not turn is entered by no more than what counts as touching, by no ply of a stack either:
/// neither by a little in every step, nor where impulses bring nodes of a column to face each other or take
/// them apart, as in the last scenes.
fn search_stacks(scenes: impl IntoIterator<Item = u64>) {
    for k in scenes {
        let scene = stack(k);
        let (mut sim, h) = (sim_of(&scene), scene.sheet.spacing);
        let steps = 12.0 * h / (length(scene.projectile.velocity) * sim.step_limits().dt);
        sim.advance((steps as u64).clamp(200, 2000)).unwrap();
        let counters = sim.counters();
        assert_eq!(counters.unconverged, 0, "{k}");
        assert!(counters.worst_penetration <= 1e-9 * h, "{k}: {:e} h", counters.worst_penetration / h);
    }
}

#[test]
fn stacks_stay_out_of_a_sphere() {
    search_stacks((0..40).chain([791, 827, 909]));
}

#[test]
#[ignore = "minutes; cargo xtask verify runs it"]
fn a_longer_search_for_deep_plies() {
    search_stacks(0..4000);
}

/// What impulses took from the energy falls where they give some back: forces press a node on again that
/// leaves the body in that step.
///
/// With the gap rates g of the nodes that are pressed, before and after, the loss is -lambda (g + g')/2.
/// After it g' = -phi/dt <= 0, and g' = g + K + W lambda with what forces add in the step, K = n.a dt, and
/// the matrix W of rates for impulses, which has at least 1/m on its diagonal beyond the compliance of the
/// body. So the loss is at least (lambda K + lambda W lambda)/2, and that nowhere below
/// -m K^2/8 summed over the free nodes that are pressed. Below a flat face of a body that does not turn, g
/// was 0 already: there it never falls.
fn falls(scenes: Range<u64>) {
    let (mut count, mut most, mut worst, mut straight) = (0, 0.0_f64, [0.0_f64; 2], 0);
    for k in scenes {
        let mut scene = drawn(k);
        // One mass and one step for all; what is flat has edges.
        (scene.sheet.grading, scene.sheet.thickness) = (small_sheet(2, 0.0).sheet.grading, 0.0);
        if scene.check().is_err() {
            continue;
        }
        let mut sim = sim_of(&scene);
        let (dt, kinetic) = (sim.step_limits().dt, sim.energy().unwrap().projectile_kinetic);
        let flat = matches!(scene.projectile.shape, Shape::Box | Shape::Polyhedron);
        let goes_straight = flat && scene.drive == Drive::Prescribed && scene.projectile.angular_velocity == [0.0; 3];
        // This run a step later, for the rare steps in which the loss falls.
        let mut later = sim_of(&scene);
        let (mut before, mut fallen) = (0.0, 0.0);
        let steps = 12.0 * scene.sheet.spacing / (length(scene.projectile.velocity) * dt);
        for _ in 0..(steps as u64).clamp(200, 4000) {
            if sim.step().is_err() || sim.counters().unconverged > 0 {
                break;
            }
            let loss = sim.contact().unwrap().loss;
            let fall = before - loss;
            let last = if fall > 0.0 { positions(&later) } else { Vec::new() };
            later.advance(sim.step_count() - 1 - later.step_count()).unwrap();
            if fall > 0.0 {
                let mut bound = 1e-14 * kinetic;
                let (x, v, next) = (positions(&later), velocities(&later), positions(&sim));
                for (((a, b), c), v) in last.iter().zip(&x).zip(&next).zip(&v) {
                    // Velocities half a step before and after; half of what forces add is in those at t_n.
                    let [was, is]: [V3; 2] = [scale(sub(*b, *a), 1.0 / dt), scale(sub(*c, *b), 1.0 / dt)];
                    let added = scale(sub(*v, was), 2.0);
                    let pushed = sub(is, add(was, added));
                    let along = dot(added, pushed) / length(pushed).max(1e-300);
                    if length(pushed) > 1e-7 {
                        bound += 0.125 * scene.sheet.node_mass * along * along;
                    }
                }
                assert!(fall <= bound, "{k}: {fall:e} J, not within {bound:e} J");
                assert!(!goes_straight || fall <= 1e-14 * kinetic, "{k}: {fall:e} J");
                (fallen, worst[0]) = (fallen + fall, worst[0].max(fall / bound));
            }
            before = loss;
        }
        (count, straight) = (count + 1, straight + u32::from(goes_straight));
        if fallen / kinetic > most {
            (most, worst[1]) = (fallen / kinetic, fallen / before);
        }
    }
    println!(
        "{count} scenes, {straight} straight: falls add up to {most:.1e} of the kinetic energy, {:.1e} of the loss, {:.2} of the bound",
        worst[1], worst[0]
    );
    assert!(most > 1e-6 && straight > 0);
}

#[test]
fn the_loss_falls_by_no_more_than_forces_press_nodes_on_again() {
    falls(0..40);
}

#[test]
#[ignore = "minutes; cargo xtask verify runs it"]
fn a_longer_search_for_a_loss_that_falls() {
    falls(0..1500);
}
