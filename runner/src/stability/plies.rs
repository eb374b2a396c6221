//! Separate plies: on each other, a thousand, turned, from one end to the other at 1000 m/s, and through each other at the start.

use super::flight::{Ended, Flight, changed, ending, uniform};
use super::{Answer, Case};
use crate::memory::Buffers;
use fabric::{AttachmentKind, Code, Outcome, Scene, Shape};

/// All rows of this theme.
pub fn rows() -> Vec<Case> {
    flights().into_iter().map(|flight| flight.case("Plies")).chain([crossing(), beyond()]).collect()
}

/// A stack of so many plies.
fn stacked(scene: Scene, plies: u32, gap: f64) -> Scene {
    changed(scene, |scene| (scene.stack.plies, scene.stack.gap) = (plies, gap))
}

/// The end, what meeting plies lost, the sweeps, and how deep plies were through each other.
fn told(end: &Ended<'_>) -> String {
    let (summary, counters) = (end.summary, end.sim.counters());
    let deepest = 1e3 * counters.ply_penetration;
    format!("{}, {} unconverged, plies {deepest:.1e} mm deep", ending(end), summary.unconverged)
}

fn flights() -> Vec<Flight> {
    let spacing = 7.26e-4;
    // Candidates of one column are soft by a millionth of a node's give (`contact/joint.rs`), which nothing takes back: a millionth of the way on
    // which their impulses would send their nodes alone in a step each. An arrest takes that of the body's whole momentum.
    let (soft, soft_at_arrest) = (1e-6 * spacing, 2e-6 * spacing);
    let whole = move |end: &Ended<'_>| end.sim.counters().ply_penetration < 1e-12 * spacing;
    let row = |name: &str, expected: &str, scene: Scene, check: Box<dyn Fn(&Ended<'_>) -> bool + Sync + Send>| Flight {
        text: Box::new(told),
        ..Flight::new(name, expected, scene, 20_000, check)
    };
    let drawn = |scene: Scene| changed(scene, |scene| scene.yarn.stochastic = true);
    let askew = changed(drawn(stacked(uniform(31, 60.0), 4, 5e-5)), |scene| {
        scene.stack.turned = true;
        scene.sheet.crimp = [0.01, 0.002];
        // Without it a crimped sheet gains energy.
        (scene.yarn.viscosity_linear, scene.yarn.viscosity_quadratic, scene.yarn.viscosity_bending) = (0.06, 1.5, 0.06);
        scene.projectile.velocity[0] = 30.0;
    });
    // A cylinder of 8 mm and 4 g with its rim first.
    let fragment = changed(drawn(stacked(uniform(21, 1000.0), 62, 1e-4)), |scene| {
        let body = &mut scene.projectile;
        (body.shape, body.radius, body.length, body.mass) = (Shape::Cylinder, 3e-3, 8e-3, 4e-3);
    });
    let fragment = super::flight::turned(fragment, [1.0, 0.3, 0.0], 0.5);
    vec![
        row(
            "five plies of drawn yarn on each other, gap 0, 40 J (N = 31)",
            "sound, none inside by 1e-6 h, plies fail one by one",
            drawn(stacked(uniform(31, 97.59), 5, 0.0)),
            Box::new(move |end| end.sound() && end.outside(soft) && end.summary.failed_segments > 0),
        ),
        row(
            "the same, 1 J, before the first failure",
            "arrested, sound, none inside by 2e-6 h, no ply in another",
            drawn(stacked(uniform(31, 15.43), 5, 0.0)),
            Box::new(move |end| {
                end.only(Outcome::Arrested) && end.sound() && end.outside(soft_at_arrest) && whole(end)
            }),
        ),
        Flight {
            until: &[],
            ..row(
                "1000 free plies of 2 x 2 nodes, 0.01 mm apart, 100 m/s",
                "sound, momentum to 1e-12, none inside by 1e-6 h, no ply in another",
                changed(stacked(uniform(2, 100.0), 1000, 1e-5), |scene| scene.attachment.kind = AttachmentKind::Free),
                Box::new(move |end| end.sound() && end.balances.momentum < 1e-12 && end.outside(soft) && whole(end)),
            )
        },
        row(
            "1000 held plies of 2 x 2 nodes, gap 0, 100 m/s",
            "arrested, sound, none inside by 1e-6 h, more than 99 % of the 42 J lost",
            stacked(uniform(2, 100.0), 1000, 0.0),
            Box::new(move |end| {
                end.only(Outcome::Arrested) && end.sound() && end.outside(soft) && end.summary.absorbed > 0.99 * 42.0
            }),
        ),
        row(
            "four crimped plies, every other one turned, hit askew",
            "sound, none inside by 1e-3 h",
            askew,
            Box::new(move |end| end.sound() && end.outside(1e-3 * spacing)),
        ),
        Flight {
            long: true,
            ..row(
                "cylinder with its rim first through 62 plies at 1000 m/s (N = 21)",
                "exits, balances close, under 1 % of the solves at the cap",
                fragment,
                Box::new(|end| {
                    let few = end.summary.unconverged < end.summary.steps / 100;
                    end.latched(Outcome::Exited) && end.closed() && few && end.outside(end.turning_allows())
                }),
            )
        },
    ]
}

/// Plies that a host puts through each other before the first step.
fn crossing() -> Case {
    let check = || {
        let scene = stacked(uniform(5, 0.0), 2, 1e-4);
        let scene = changed(scene, |scene| scene.projectile.position[2] = -1.0);
        let mut buffers = Buffers::of(&scene)?;
        let mut sim = buffers.sim(&scene)?;
        let mut positions = vec![0.0; 3 * sim.layout().nodes()];
        sim.copy_positions(&mut positions)?;
        let velocities = vec![0.0; positions.len()];
        let nodes = positions.len() / 6;
        // The middle node of the second ply just below the one that it faces.
        let middle = 3 * (nodes + nodes / 2) + 2;
        let before = sim.digest();
        positions[middle] -= 1.001e-4;
        let refused = sim.set_motion(&positions, &velocities).err();
        let kept = sim.digest() == before;
        positions[middle] += 0.002e-4;
        let accepted = sim.set_motion(&positions, &velocities).is_ok();
        let named = refused.is_some_and(|error| {
            error.code == Code::PliesOverlap && error.field == "positions" && (error.value + 1e-7).abs() < 1e-15
        });
        let text = refused.map_or("accepted".to_string(), |error| error.to_string());
        let happened =
            format!("{text}; state kept: {kept}; just above: {}", if accepted { "accepted" } else { "refused" });
        Ok(Answer::plain(happened, named && kept && accepted))
    };
    plain("plies through each other at the start", "refused with how far it lies below; just above accepted", check)
}

/// What a stack cannot be.
fn beyond() -> Case {
    let check = || {
        let field = |change: fn(&mut Scene)| {
            let scene = changed(stacked(uniform(5, 10.0), 3, 1e-3), change);
            scene.check().err().map_or("accepted", |error| error.field)
        };
        let found = [
            field(|scene| scene.stack.gap = -1e-300),
            field(|scene| scene.stack.plies = 1001),
            field(|scene| (scene.stack.turned, scene.sheet.spacing_y) = (true, 1e-3)),
            field(|scene| (scene.symmetry.mirror_x, scene.yarn.stochastic) = (true, false)),
            field(|_| {}),
        ];
        let wanted = ["stack.gap", "stack.plies", "stack.turned", "stack.plies", "accepted"];
        Ok(Answer::plain(found.join(", "), found == wanted))
    };
    let what = "a negative gap, 1001 plies, turned with unlike spacings, mirror planes, none of it";
    plain(what, "refused by name, the last accepted", check)
}

fn plain(name: &str, expected: &str, check: impl Fn() -> crate::Result<Answer> + Sync + Send + 'static) -> Case {
    Case { theme: "Plies", name: name.to_string(), expected: expected.to_string(), long: false, check: Box::new(check) }
}
