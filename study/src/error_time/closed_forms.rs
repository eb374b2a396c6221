//! Closed forms: the tumbling body, the quartic oscillator, the long yarn under transverse impact. Each row has the error of
//! the kernel against mathematics. The physics tests assert the same with tighter words; here the errors stand beside the step.

use super::{Cell, Effort, Table, integrator_name, theta, with_step};
use crate::Result;
use crate::memory::Buffers;
use fabric::projectile::{Body, Inertia, Motion};
use fabric::shape::Solid;
use fabric::{Drive, Integrator, RotationRule, Scene, Sim, TimeStep};
use std::path::Path;

/// False if a closed form is missed.
pub fn run(effort: Effort, out: &Path) -> Result<bool> {
    let mut sound = true;
    let mut table = Table::new(&["case", "method", "step", "quantity", "exact", "relative error", "allowed"]);
    rotation(&mut table);
    oscillator(&mut table)?;
    let speeds: &[f64] = if effort == Effort::Smoke { &[100.0] } else { &[50.0, 100.0, 400.0] };
    let fractions: &[f64] = if effort == Effort::Full { &[0.4, 0.2] } else { &[0.4] };
    for &speed in speeds {
        for &fraction in fractions {
            long_yarn(&mut table, speed, fraction)?;
        }
    }
    for row in &table.rows {
        if let (Cell::Number(error), Cell::Number(allowed)) = (&row[5], &row[6]) {
            sound &= error.abs() <= *allowed;
        }
    }
    println!("closed forms: {}", if sound { "all met" } else { "NOT all met" });
    table.write(&out.join("closed_forms.csv"))?;
    Ok(sound)
}

/// A row; `allowed` is empty where only the error is shown.
fn add(table: &mut Table, names: [&str; 3], quantity: &str, exact: f64, error: f64, allowed: Option<f64>) {
    let mut row: Vec<Cell> = names.into_iter().map(Cell::text).collect();
    row.extend([Cell::text(quantity), Cell::Number(exact), Cell::Number(error)]);
    row.push(allowed.map_or(Cell::text(""), |allowed| Cell::Number(allowed)));
    table.add(row);
}

/// Moments (1, 2, 3), rates (1, 0, 1): w = (cn, sn, dn)(t | m = 1/3), here at t = 10 s.
fn rotation(table: &mut Table) {
    let exact = [-0.921069998444, 0.389397044115, 0.974400660583];
    for (rule, name) in [(RotationRule::Midpoint, "midpoint"), (RotationRule::Theta(0.5), "theta rule, theta 1/2")] {
        let mut before: Option<f64> = None;
        for division in [10, 20, 40, 80] {
            let w = tumbled(rule, 1.0 / f64::from(division), 10 * division);
            let error = crate::event::length([w[0] - exact[0], w[1] - exact[1], w[2] - exact[2]]);
            let energy = (w[0] * w[0] + 2.0 * w[1] * w[1] + 3.0 * w[2] * w[2]) / 4.0 - 1.0;
            let step = format!("1/{division} s");
            let names = ["tumbling body, 10 s", name, &step];
            add(
                table,
                names,
                "angular velocity",
                crate::event::length(exact),
                error / crate::event::length(exact),
                None,
            );
            if let Some(before) = before {
                // Order 2 to within 0.1, as an error of the order.
                add(table, names, "order of convergence", 2.0, (before / error).log2() / 2.0 - 1.0, Some(0.05));
            }
            let allowed = (rule == RotationRule::Midpoint).then_some(1e-13);
            add(table, names, "kinetic energy", 2.0, energy, allowed);
            before = Some(error);
        }
    }
}

fn tumbled(rule: RotationRule, dt: f64, steps: u32) -> [f64; 3] {
    let solid = Solid::Cylinder { radius: 1.0, half_length: 1.0 };
    let mut inertia = Inertia::of(&solid, 1.0, true);
    inertia.moments = [1.0, 2.0, 3.0].into();
    let mut body = Body::of(&Motion {
        position: [0.0; 3],
        velocity: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: [1.0, 0.0, 1.0],
    });
    for _ in 0..steps {
        body.drift(&solid, &inertia, rule, dt);
    }
    body.angular_velocity.into()
}

fn small_sheet(nodes: u32, velocity: f64) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nodes, nodes);
    scene.yarn.stochastic = false;
    scene.projectile.velocity = [0.0, 0.0, velocity];
    scene
}

/// One free node between four fixed ones, and the sphere at 1 m/s: the potential E A_0 z^4/(2 h^3). With V' = V M/(M + m),
/// z_max = [(M + m) V'^2 h^3/(E A_0)]^(1/4) after 1.3110287771 z_max/V' (the lemniscate constant); it leaves with -V'.
fn oscillator(table: &mut Table) -> Result<()> {
    for integrator in [Integrator::Verlet, theta(1e-10)] {
        for fraction in [0.4, 0.2, 0.1] {
            let mut scene = small_sheet(3, 1.0);
            scene.integrator = integrator;
            // A sphere that passes between the supports.
            scene.projectile.radius = scene.sheet.spacing;
            scene.projectile.position = [0.0, 0.0, -scene.sheet.spacing];
            let scene = with_step(scene, TimeStep::Fraction(fraction), fraction);
            let (m, mass, h) = (scene.sheet.node_mass, scene.projectile.mass, scene.sheet.spacing);
            let speed = mass / (mass + m);
            let stiffness = scene.yarn.modulus_mean * scene.sheet.yarn_area;
            let depth = ((mass + m) * speed * speed * h * h * h / stiffness).powf(0.25);
            let stretch = (1.0 + depth * depth / (h * h)).sqrt();
            let mut buffers = Buffers::of(&scene)?;
            let mut sim = buffers.sim(&scene)?;
            let (reached, time) = turning_point(&mut sim)?;
            let closure = sim.energy()?.residual / (0.5 * mass);
            let strain = sim.fabric()?.max_stretch - 1.0;
            sim.advance(2 * sim.step_count())?;
            let rebound = sim.projectile()?.velocity[2];
            let (name, step) = (integrator_name(integrator), format!("{fraction} dt_crit"));
            let names = ["quartic oscillator", &name, &step];
            // At a quarter of the default step the physics test's tolerances hold for either integrator.
            let at_last = |allowed: f64| (fraction == 0.1).then_some(allowed);
            let z = reached + scene.projectile.radius;
            add(table, names, "depth, m", depth, z / depth - 1.0, at_last(1e-6));
            let exact = 1.3110287771 * depth / speed;
            add(table, names, "time to rest, s", exact, time / exact - 1.0, at_last(1e-5));
            add(table, names, "largest U - 1", stretch - 1.0, strain / (stretch - 1.0) - 1.0, at_last(1e-6));
            add(table, names, "rebound, m/s", -speed, rebound / -speed - 1.0, at_last(1e-6));
            add(table, names, "energy balance at rest", 0.0, closure, None);
        }
    }
    Ok(())
}

/// Steps until the sphere stands still; its depth and the time, interpolated between steps.
fn turning_point(sim: &mut Sim<'_>) -> Result<(f64, f64)> {
    let dt = sim.step_limits().dt;
    loop {
        let before = sim.projectile()?;
        sim.step()?;
        let after = sim.projectile()?;
        if after.velocity[2] > 0.0 {
            continue;
        }
        // Impulses act at the start of a step, so a rate is constant over it and belongs to its middle, with either integrator:
        // the two steps meet at `before.position`.
        let slope = (after.velocity[2] - before.velocity[2]) / dt;
        let fraction = before.velocity[2] / (before.velocity[2] - after.velocity[2]) - 0.5;
        let depth = before.position[2] - 0.5 * slope * (fraction * dt) * (fraction * dt);
        return Ok((depth, sim.time() - dt + fraction * dt));
    }
}

/// Segments on each side of the impact: the front (18.3 km/s) does not reach the ends in 72 us.
const HALF: u32 = 1900;

/// Transverse impact on a long yarn with a given stretch behind the longitudinal front.
pub struct Transverse {
    /// Impact velocity that belongs to the stretch, m/s.
    pub speed: f64,
    /// Contact force, N.
    pub force: f64,
    /// Speed of the kink in the laboratory, m/s.
    pub kink: f64,
    /// Speed of the longitudinal front along the yarn at rest, m/s.
    pub front: f64,
}

/// The similarity solution of Smith, McCrackin and Schiefer (1958) with the model's law, undamaged: N = A_0 U S with
/// S = E (U^2 - 1)/2, of a yarn with mu = m/h kg/m, one node's mass in each segment. N grows faster than U, so the longitudinal
/// front is a shock: it runs at sqrt(N/(mu (U - 1))), and behind it the yarn moves inwards at w = sqrt(N (U - 1)/mu). The kink runs
/// at U c_t - w with c_t = sqrt(N/(mu U)); V^2 = (U c_t)^2 - (U c_t - w)^2; the contact force is 2 N V/(U c_t).
pub fn transverse(scene: &Scene, stretch: f64) -> Transverse {
    let mu = scene.sheet.node_mass / scene.sheet.spacing;
    let pull = scene.sheet.yarn_area * stretch * scene.yarn.modulus_mean * 0.5 * (stretch * stretch - 1.0);
    let inward = (pull * (stretch - 1.0) / mu).sqrt();
    let running = stretch * (pull / (mu * stretch)).sqrt();
    let speed = (running * running - (running - inward) * (running - inward)).sqrt();
    Transverse { speed, force: 2.0 * pull * speed / running, kink: running - inward, front: inward / (stretch - 1.0) }
}

/// The stretch behind the front at this impact velocity, at most the critical one, by bisection: the velocity grows with it.
pub fn stretch_at(scene: &Scene, speed: f64) -> f64 {
    let (mut low, mut high) = (1.0, scene.yarn.critical_stretch);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if transverse(scene, middle).speed < speed { low = middle } else { high = middle }
    }
    low
}

/// Transverse impact at `speed` on one long yarn against its similarity solution. Half a node's mass belongs to the yarn.
fn long_yarn(table: &mut Table, speed: f64, fraction: f64) -> Result<()> {
    // Three rows of which the outer ones and the ends are fixed; the vertical segments are failed beforehand.
    let mut scene = small_sheet(3, speed);
    scene.sheet.nodes_x = 2 * HALF + 1;
    scene.sheet.node_mass *= 0.5;
    scene.projectile.radius = scene.sheet.spacing;
    scene.projectile.position = [0.0, 0.0, -scene.sheet.spacing];
    scene.drive = Drive::Prescribed;
    let scene = with_step(scene, TimeStep::Fraction(fraction), fraction);
    let (h, nx) = (scene.sheet.spacing, scene.sheet.nodes_x as usize);
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let mut stretches = vec![1.0; sim.layout().segments()];
    stretches[3 * (nx - 1)..].fill(2.0);
    sim.set_largest_stretch(&stretches)?;

    let steps = (72e-6 / sim.step_limits().dt).round() as u64;
    // The second half of the time: means over it, and the line through the kink's places.
    sim.advance(steps / 2)?;
    let (first_impulse, first_time) = (sim.contact()?.impulse[2], sim.time());
    let middle = nx + nx / 2;
    let (mut strain, mut samples, mut kinks) = (0.0, 0.0, Vec::new());
    let mut flat = vec![0.0; 3 * sim.layout().nodes()];
    while sim.step_count() < steps {
        sim.advance(16)?;
        sim.copy_positions(&mut flat)?;
        let x = flat.as_chunks::<3>().0;
        // 60 segments between the kink (at most 108 segments out) and the front (900 segments out and more).
        let length: f64 = (middle + 200..middle + 260)
            .map(|k| crate::event::length([x[k + 1][0] - x[k][0], x[k + 1][1] - x[k][1], x[k + 1][2] - x[k][2]]))
            .sum();
        strain += length / (60.0 * h) - 1.0;
        // The yarn inside the kink is straight: the line through its middle part meets z = 0 at the kink.
        let depth = x[middle][2];
        let inside = x[middle..].iter().filter(|p| p[2] > 0.25 * depth && p[2] < 0.75 * depth);
        let part: Vec<_> = inside.map(|p| (p[0], p[2])).collect();
        let (mx, mz, slope) = line(&part);
        kinks.push((sim.time(), mx - mz / slope));
        samples += 1.0;
    }
    let force = (first_impulse - sim.contact()?.impulse[2]) / (sim.time() - first_time);

    let stretch = stretch_at(&scene, speed);
    let exact = transverse(&scene, stretch);
    let (name, step) = (format!("long yarn, {speed} m/s"), format!("{fraction} dt_crit"));
    let names = [&*name, "Verlet", &step];
    add(table, names, "strain U - 1", stretch - 1.0, strain / samples / (stretch - 1.0) - 1.0, Some(2e-3));
    add(table, names, "contact force, N", exact.force, force / exact.force - 1.0, Some(1e-2));
    add(table, names, "speed of the kink, m/s", exact.kink, line(&kinks).2 / exact.kink - 1.0, Some(1.5e-2));
    Ok(())
}

/// Means of x and y, and the slope of the least-squares line.
fn line(points: &[(f64, f64)]) -> (f64, f64, f64) {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let product: f64 = points.iter().map(|(x, y)| (x - mx) * (y - my)).sum();
    (mx, my, product / points.iter().map(|(x, _)| (x - mx) * (x - mx)).sum::<f64>())
}
