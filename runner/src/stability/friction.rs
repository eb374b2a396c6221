//! Friction up to its largest coefficient: askew, spinning, light, on supports, moved by the host.

use super::flight::{Ended, Flight, changed, ending, turned, uniform};
use super::{Answer, Case};
use fabric::{AttachmentKind, Drive, Outcome, Scene, Shape};

/// All rows of this theme.
pub fn rows() -> Vec<Case> {
    let flights = [spheres(), bodies()];
    flights.into_iter().flatten().map(|flight| flight.case("Friction")).chain([beyond()]).collect()
}

/// With friction, moving along x as fast as along z, and spinning.
fn rubbing(scene: Scene, coefficient: f64, spin: f64) -> Scene {
    changed(scene, |scene| {
        scene.contact.friction = coefficient;
        scene.projectile.velocity[0] = scene.projectile.velocity[2];
        scene.projectile.angular_velocity = [0.0, 0.6 * spin, 0.8 * spin];
    })
}

/// The end, what was rubbed away, the spin and the sweeps.
fn told(end: &Ended<'_>) -> String {
    let summary = end.summary;
    let (sweeps, unconverged) = (summary.most_sweeps, summary.unconverged);
    format!("{}, {:.2} J rubbed away, {sweeps} sweeps, {unconverged} unconverged", ending(end), summary.friction)
}

fn spheres() -> Vec<Flight> {
    let rounding = 1e-12 * 6.35e-3;
    let mut flights: Vec<Flight> = [1e-6, 0.1, 1.0, 10.0]
        .into_iter()
        .map(|coefficient| Flight {
            text: Box::new(told),
            ..Flight::new(
                format!("sphere askew, spinning at 50 000 rad/s, coefficient {coefficient}"),
                "sound, none inside",
                rubbing(uniform(41, 100.0), coefficient, 5e4),
                6000,
                move |end| end.sound() && end.outside(rounding) && end.summary.friction > 0.0,
            )
        })
        .collect();
    flights.push(Flight {
        text: Box::new(told),
        ..Flight::new(
            "sphere of 15 nodes' mass, coefficient 10",
            "balances close, none inside",
            changed(rubbing(uniform(41, 60.0), 10.0, 1e4), |scene| scene.projectile.mass = 1e-6),
            6000,
            move |end| end.closed() && end.outside(rounding) && end.summary.unconverged < end.summary.steps / 100,
        )
    });
    // A fixed node takes 2/7 of the surface's speed R w along x out of the sphere, which then rolls.
    let spun = changed(uniform(2, 1.0), |scene| {
        scene.contact.friction = 10.0;
        let half = scene.half_size();
        scene.projectile.position = [half[0], half[1], -scene.projectile.radius];
        scene.projectile.angular_velocity = [0.0, 1000.0, 0.0];
    });
    let rolls = -6.35e-3 * 1000.0 / 3.5;
    flights.push(Flight {
        until: &[Outcome::Arrested],
        text: Box::new(|end| format!("v_x = {:.6} m/s", end.summary.residual_velocity[0])),
        ..Flight::new(
            "sphere pressed and spun on a fixed node, coefficient 10",
            format!("v_x = {rolls:.6} m/s to 1e-9 (closed form)"),
            spun,
            1,
            move |end| Ended::near(end.summary.residual_velocity[0], rolls, 1e-9) && end.sound(),
        )
    });
    flights
}

fn bodies() -> Vec<Flight> {
    let brick = changed(uniform(41, 100.0), |scene| {
        scene.projectile.shape = Shape::Box;
        scene.projectile.size = [0.01, 0.012, 0.014];
        scene.projectile.position[2] = -0.0106;
    });
    let brick = turned(brick, [1.0, 0.6, 0.0], 0.7);
    let free = changed(brick, |scene| scene.attachment.kind = AttachmentKind::Free);
    let drum = changed(uniform(41, 60.0), |scene| {
        scene.drive = Drive::Prescribed;
        scene.projectile.shape = Shape::Cylinder;
        scene.projectile.length = 0.02;
    });
    let drum = turned(drum, [1.0, 0.0, 0.0], 0.5 * core::f64::consts::PI);
    let clamped = changed(brick, |scene| {
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (3, 3);
    });
    let row = |name: &str, scene: Scene, spin: f64, few: bool| {
        let expected = if few { "sound" } else { "balances close; solves on supports may stay unconverged" };
        Flight {
            text: Box::new(told),
            ..Flight::new(name, expected, rubbing(scene, 10.0, spin), 3000, move |end| {
                end.closed() && end.summary.friction > 0.0 && !(few && end.summary.unconverged > 0)
            })
        }
    };
    vec![
        row("box on a corner, spinning, coefficient 10", brick, 5e3, true),
        row("the same on a free sheet", free, 5e3, true),
        row("drum that the host presses in while it turns, coefficient 10", drum, 2e4, true),
        row("box on a corner on a 3 x 3 sheet with eight fixed nodes, coefficient 10", clamped, 5e3, false),
    ]
}

/// The range ends at 10.
fn beyond() -> Case {
    let check = || {
        let refused = |coefficient: f64| {
            let scene = changed(uniform(2, 1.0), |scene| scene.contact.friction = coefficient);
            scene.check().err().is_some_and(|error| error.field == "contact.friction")
        };
        let (below, above, inside) = (refused(-1e-300), refused(10.0_f64.next_up()), refused(10.0));
        Ok(Answer::plain(format!("refused: {below}, {above}; 10: {inside}"), below && above && !inside))
    };
    Case {
        theme: "Friction",
        name: "a coefficient below 0 or above 10".to_string(),
        expected: "refused by name".to_string(),
        long: false,
        check: Box::new(check),
    }
}
