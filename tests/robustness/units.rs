//! No result depends on the units of length, mass and time: a scene with all its numbers given in other
//! units, powers of two times the old ones, ends with the same bits, and its outcomes come at the same steps.

use fabric_kernel::fields::FIELDS;
use fabric_kernel::{AttachmentKind, Outcome, Scene};
use fabric_tests::{golden, positions, sim_of, small_sheet, speed, stepped, velocities};
use rayon::prelude::*;

/// Powers of two for length, mass and time.
const UNITS: [[i32; 3]; 2] = [[-9, 15, 11], [-7, -13, -6]];

/// Exponents of length, mass and time of an SI unit.
fn dimension(unit: &str) -> [i32; 3] {
    match unit {
        "1" | "rad" => [0, 0, 0],
        "m" => [1, 0, 0],
        "m2" => [2, 0, 0],
        "m/s" => [1, 0, -1],
        "rad/s" | "1/s" => [0, 0, -1],
        "kg" => [0, 1, 0],
        "kg.m2" => [2, 1, 0],
        "Pa" => [-1, 1, -2],
        "1/Pa" => [1, -1, 2],
        "s" => [0, 0, 1],
        "N" => [1, 1, -2],
        other => panic!("the unit {other}"),
    }
}

/// How many new units an old one is.
fn factor(units: [i32; 3], unit: &str) -> f64 {
    let exponents = dimension(unit);
    (0..3).map(|k| 2.0_f64.powi(units[k] * exponents[k])).product()
}

fn in_units(scene: &Scene, units: [i32; 3]) -> Scene {
    let mut scene = *scene;
    for field in FIELDS {
        let Some(quantity) = field.quantity else { continue };
        for element in 0..field.size() {
            // A plane of a polyhedron is a normal and a distance.
            let unit = if field.name == "projectile.faces.planes" && element % 4 == 3 { "m" } else { quantity.unit };
            let value = factor(units, unit) * f64::from_bits(field.word(&mut scene, element));
            field.set_word(&mut scene, element, value.to_bits()).unwrap();
        }
    }
    scene
}

/// Steps and work of the outcomes, energies, the work, and all motion of nodes and body, in the old units.
#[derive(Debug, PartialEq)]
struct Results {
    outcomes: Vec<(&'static str, u64, u64)>,
    energies: Vec<u64>,
    motion: Vec<u64>,
}

fn results(scene: &Scene, units: [i32; 3], steps: u64) -> Results {
    let scene = in_units(scene, units);
    let sim = stepped(&scene, steps);
    let energy = 1.0 / (factor(units, "kg.m2") * factor(units, "1/s") * factor(units, "1/s"));
    let (length, velocity) = (1.0 / factor(units, "m"), 1.0 / factor(units, "m/s"));
    let latched = Outcome::ALL.into_iter().zip(sim.outcomes().latched);
    let outcomes = latched.filter_map(|(outcome, latch)| {
        latch.map(|latch| (outcome.name(), latch.step, (latch.work * energy).to_bits()))
    });
    let parts = sim.energy().unwrap();
    let energies = [
        parts.projectile_kinetic,
        parts.strain,
        parts.dissipated,
        parts.contact_loss,
        parts.contact_work,
        parts.residual,
    ];
    let body = sim.projectile().unwrap();
    let places = positions(&sim).into_iter().chain([body.position]).flatten().map(|x| x * length);
    let speeds = velocities(&sim).into_iter().chain([body.velocity]).flatten().map(|v| v * velocity);
    Results {
        outcomes: outcomes.collect(),
        energies: energies.map(|part| (part * energy).to_bits()).to_vec(),
        motion: places.chain(speeds).map(f64::to_bits).collect(),
    }
}

/// A light sphere against a free sheet of thin yarn, slowly: it goes on with the sheet in tow.
fn light_and_slow() -> Scene {
    let mut scene = small_sheet(21, 24.0);
    (scene.attachment.kind, scene.projectile.mass) = (AttachmentKind::Free, 1e-4 / 64.0);
    scene.sheet.node_mass /= 64.0;
    scene.sheet.yarn_area /= 64.0;
    scene
}

fn scenes() -> Vec<(&'static str, Scene, u64)> {
    let mut missed = small_sheet(21, 100.0);
    missed.projectile.position[0] = 0.05;
    let mut torn = small_sheet(31, speed(80.0, 8.4e-3));
    torn.attachment.kind = AttachmentKind::FourCorners;
    (torn.attachment.disc_inset, torn.attachment.disc_radius) = (2e-3, 2e-3);
    (torn.projectile.radius, torn.projectile.position[2]) = (3e-3, -3e-3);
    let mut askew = small_sheet(31, 10.0);
    (askew.projectile.velocity[0], askew.projectile.position[0]) = (17.0, -3e-3);
    let mut clamped = small_sheet(31, 60.0);
    let attachment = &mut clamped.attachment;
    (attachment.hold, attachment.grip, attachment.strength) = (20.0, 1e-3, 100.0);
    let mut thick = golden::box_on_a_corner();
    (thick.sheet.thickness, thick.projectile.position[2]) = (4e-4, thick.projectile.position[2] - 2e-4);
    let by_outcome = [
        ("thick", thick, 1500),
        ("rebounds", askew, 30_000),
        ("slips and lets go", clamped, 3000),
        ("exits", small_sheet(31, speed(40.0, 8.4e-3)), 9000),
        ("goes through", Scene { track_through: true, ..small_sheet(31, speed(40.0, 8.4e-3)) }, 9000),
        ("is arrested", small_sheet(31, speed(0.2, 8.4e-3)), 20_000),
        ("passes", missed, 8000),
        ("tears the sheet off", torn, 6000),
        ("light and slow", light_and_slow(), 20_000),
    ];
    let golden = golden::SCENES.iter().skip(2).map(|&(name, scene, steps, ..)| (name, scene(), steps));
    by_outcome.into_iter().chain(golden).collect()
}

#[test]
fn no_result_depends_on_the_units() {
    let scenes = scenes();
    let runs: Vec<_> = scenes
        .par_iter()
        .map(|(name, scene, steps)| {
            let own = results(scene, [0; 3], *steps);
            let other = UNITS.into_iter().map(|units| (units, results(scene, units, *steps)));
            let unlike: Vec<_> = other
                .filter(|(_, results)| *results != own)
                .map(|(units, results)| (units, results.outcomes))
                .collect();
            (*name, own.outcomes, unlike)
        })
        .collect();
    let of_outcomes = runs.iter().flat_map(|(_, outcomes, _)| outcomes.iter().map(|(name, ..)| *name));
    for outcome in Outcome::ALL {
        assert!(of_outcomes.clone().any(|name| name == outcome.name()), "{outcome:?}");
    }
    let unlike: Vec<_> = runs.iter().filter(|(.., unlike)| !unlike.is_empty()).collect();
    println!(
        "figure 7c: {} scenes in {} units of length, mass and time, {} unlike",
        runs.len(),
        UNITS.len(),
        unlike.len()
    );
    assert!(unlike.is_empty(), "{unlike:?}");
}

/// Long after the exit the work is what it was then.
#[test]
fn a_light_and_slow_sphere_exits_with_its_final_work() {
    let scene = light_and_slow();
    let mut sim = sim_of(&scene);
    sim.advance_until(Outcome::Exited, 1_000_000).unwrap();
    let work = sim.contact().unwrap().work;
    assert!(sim.outcomes().mask.has(Outcome::Exited));
    sim.advance(25_000).unwrap();
    let later = sim.contact().unwrap().work;
    println!(
        "{work:.4e} J at the exit in step {}, {later:.4e} J later, of {:.1e} J",
        sim.outcomes().latched[2].unwrap().step,
        0.5 * scene.projectile.mass * 24.0 * 24.0
    );
    fabric_tests::close(work, later, 0.01);
}
