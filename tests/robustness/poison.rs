//! A poisoned state never goes on in silence. The one way to put a number into a state that no simulation has
//! is an image with its checksum made right: NaN, infinities, impossible histories and motion whose energy
//! would not be finite are refused by load, so nothing of them is ever read out or stepped.

use crate::snapshots::forged;
use fabric_kernel::{Code, Scene, Sim, StrengthDraw};
use fabric_tests::{between_supports, drawn, golden, image_of, rough, small_sheet, stepped, viscous};

/// What is poisoned.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Entry {
    Displacement,
    Velocity,
    History,
}

/// Words of the image that hold each entry of each node: (node, entry, word).
fn entries(sim: &Sim<'_>, image: &[u8]) -> Vec<(usize, Entry, usize)> {
    let layout = sim.layout();
    let (nx, ny) = (layout.nodes_x, layout.nodes_y);
    let across = layout.x.segments();
    let slack = layout.has(fabric_kernel::Feature::Slack);
    let (kept, row) = if slack { (3, 1) } else { (1, 0) };
    let flags = if layout.has(fabric_kernel::Feature::Detachment) { layout.nodes().div_ceil(32) } else { 0 };
    let mut word = image.len() / 8 - 1 - flags - 6 * layout.nodes() - kept * layout.segments() - row * ny;
    let mut entries = Vec::new();
    for k in 0..nx * ny {
        word += if k % nx == 0 { row } else { 0 };
        for entry in [Entry::Displacement, Entry::Velocity] {
            (0..3).for_each(|component| entries.push((k, entry, word + component)));
            word += 3;
        }
        for exists in [k % nx < across, layout.has_verticals(k / nx)] {
            if exists {
                entries.push((k, Entry::History, word));
                word += kept;
            }
        }
    }
    assert_eq!(word + flags + 1, image.len() / 8);
    entries
}

#[test]
fn a_poisoned_state_is_refused() {
    let stochastic = drawn(between_supports(small_sheet(13, 250.0), 3.0));
    let balanced = Scene { slack_balance: true, ..between_supports(small_sheet(13, 200.0), 3.0) };
    let viscous = viscous(Scene { slack_balance: false, ..balanced }, [0.06, 0.0, 0.06]);
    let mut stack = stochastic;
    (stack.stack.plies, stack.stack.gap) = (2, 2e-4);
    let mut theta = golden::drawn_yarns_by_the_theta_rule();
    (theta.sheet.nodes_x, theta.sheet.nodes_y) = (17, 13);
    // Small enough to pass between the supports.
    (theta.projectile.radius, theta.projectile.length) = (2e-3, 4.5e-3);
    theta.projectile.position[2] = -3.1e-3;
    let (mut tried, mut refused) = (0, 0);
    let mut taken = Vec::new();
    let mut strength = stochastic;
    strength.yarn.strength_draw = StrengthDraw::Weibull;
    for (name, scene, steps) in [
        ("stochastic", stochastic, 60),
        ("strength", strength, 60),
        ("slack balance", balanced, 400),
        ("viscous", viscous, 60),
        ("friction", rough(stochastic, 0.3), 60),
        ("stack", stack, 60),
        ("theta", theta, 60),
    ] {
        let mut sim = stepped(&scene, steps);
        while sim.counters().contacts == 0 {
            assert!(sim.step_count() < 2 * steps, "{name}");
            sim.step().unwrap();
        }
        let image = image_of(&sim);
        let before = sim.digest();
        // First, last and middle node, and all others: some are fixed, some in contact, some have failed
        // segments.
        for (node, entry, word) in entries(&sim, &image) {
            for poison in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300] {
                tried += 1;
                match sim.load(&forged(&image, word, poison.to_bits())) {
                    Err(error) => {
                        assert_eq!(error.code, Code::ImageInvalid);
                        assert_eq!(sim.digest(), before, "the state is untouched");
                        refused += 1;
                    }
                    Ok(()) => {
                        taken.push(format!("{name}: {entry:?} of node {node}: {poison:e}"));
                        sim.load(&image).unwrap();
                    }
                }
            }
        }
    }
    println!("figure 21: {tried} poisoned entries, {refused} refused by load, {} taken", taken.len());
    assert!(taken.is_empty(), "{} of {tried}:\n{}", taken.len(), taken[..taken.len().min(30)].join("\n"));
}
