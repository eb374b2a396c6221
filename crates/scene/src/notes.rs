//! Notes that go with the numbers of a shot: every report takes it from here.

use crate::density::{LIGHTEST, density};
use fabric_kernel::math::sqrt;
use fabric_kernel::{Error, Scene, Shape, Sim, Solid};

/// Part of the velocity at which a yarn breaks at once from which sharp edges are named. Bars at the edge of
/// a flat face were seen to break within 6 us from 0.31 of it on (docs/tables/edges.md).
const NAMED_FROM: f64 = 0.25;

/// A sentence on the sharp edges of a projectile with flat faces that flies as the scene says, but at this
/// speed, m/s; none if it is slow.
pub fn sharp_edges(scene: &Scene, speed: f64) -> Option<String> {
    let part = speed / breaking_velocity(scene);
    if part < NAMED_FROM || scene.projectile.shape == Shape::Sphere || is_nose_first(scene) {
        return None;
    }
    Some(format!(
        "the projectile has flat faces, whose edges are sharp, as the model has no radius for them. At {speed:.0} m/s, {part:.2} of the velocity \
         at which a yarn that is hit across breaks at once, bars at an edge may break within microseconds, in packs of many plies, too. \
         From which velocity on depends on the node spacing and the place of the hit (docs/validation.md, \"Spacing\")"
    ))
}

/// Densities of solid bodies, kg/m3: osmium has 22,590.
const DENSITIES: [f64; 2] = [500.0, 25_000.0];

/// A sentence on a projectile that is too heavy or too light for its size, or reaches farther from its centre
/// than the sheet is across: most likely a length in mm or a mass in g. A polyhedron is lighter than the
/// sphere around it.
pub fn unlikely_body(scene: &Scene) -> Option<String> {
    let (body, density) = (&scene.projectile, density(&scene.projectile));
    let least = if body.shape == Shape::Polyhedron { LIGHTEST } else { DENSITIES[0] };
    let word = if density < least { "light" } else { "heavy" };
    let ([half_x, half_y], reach) = (scene.half_size(), Solid::of(body).reach());
    let across = 2.0 * sqrt(half_x * half_x + half_y * half_y);
    if !(body.mass.is_finite() && reach.is_finite()) {
        // The kernel refuses it.
        return None;
    }
    if body.mass > 0.0 && (least..=DENSITIES[1]).contains(&density) && reach > across {
        return Some(format!(
            "a projectile that reaches {:.3} mm from its centre is larger than the sheet, which is {:.3} mm across; a number without a unit is in m, \
             so write \"5 mm\"",
            1e3 * reach,
            1e3 * across
        ));
    }
    (body.mass > 0.0 && !(least..=DENSITIES[1]).contains(&density)).then(|| {
        let [mass, reach, density] = [1e3 * body.mass, 1e3 * reach, 1e-3 * density];
        format!(
            "a projectile of {mass:.3} g that reaches {reach:.3} mm from its centre is too {word} for its size. It has {density:.3} g/cm3, and \
             solid bodies have 0.5 to 25. A number without a unit is in m or kg, so write \"5 mm\" or \"16 g\""
        )
    })
}

/// Part of the impact energy by which the energy balance may be open.
const OPEN: f64 = 0.01;

/// Why a balance is open, and what helps.
pub const SLACK_CHANGES: &str = "yarn that goes slack and taut changes the energy. Take \
                              slack_balance = true (docs/model.md, \"Slack and taut\")";

/// What is said where the energy residual exceeds 1 % of the impact energy: none of a body without energy.
/// `impact_energy` and `residual`, J.
///
/// # Errors
/// The simulation has failed.
pub fn open_balance(sim: &Sim<'_>, impact_energy: f64, residual: f64) -> Result<Option<String>, Error> {
    if impact_energy == 0.0 || residual.abs() <= OPEN * impact_energy {
        return Ok(None);
    }
    let (at, open) = (1e6 * sim.time(), 100.0 * residual / impact_energy);
    if residual < 0.0 && sim.scene().casing.radius != 0.0 {
        return Ok(Some(format!(
            "at {at:.1} us the energy residual is {open:.1} % of the impact energy: what nodes lose on the case is counted to second \
             order in the time step. Take half of time_step.fraction (docs/model.md, \"Curved sheets and rings\")"
        )));
    }
    let mut stretches = vec![0.0; sim.layout().segments()];
    sim.copy_stretch(&mut stretches)?;
    let slack = stretches.iter().filter(|&&stretch| stretch < 1.0 - 1e-9).count() as f64 / stretches.len() as f64;
    Ok(Some(format!(
        "at {at:.1} us the energy residual is {open:.1} % of the impact energy. {:.0} % of the segments are slack: {SLACK_CHANGES}",
        100.0 * slack
    )))
}

/// Velocity of Smith's relation for the critical strain of a yarn along x, m/s: c sqrt(2 e sqrt(e (1 + e)) -
/// e^2).
fn breaking_velocity(scene: &Scene) -> f64 {
    let [h_x, h_y] = scene.spacings();
    let (sheet, e) = (&scene.sheet, scene.yarn.critical_stretch - 1.0);
    // A node has the mass of both its yarns.
    let c = sqrt(scene.yarn.modulus_mean * sheet.yarn_area * (h_x + h_y) / sheet.node_mass);
    c * sqrt(2.0 * e * sqrt(e * (1.0 + e)) - e * e)
}

/// Whether a hemisphere is ahead: at +z of the body.
fn is_nose_first(scene: &Scene) -> bool {
    let body = &scene.projectile;
    let [w, x, y, z] = body.orientation;
    let axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z];
    let ahead: f64 = axis.iter().zip(body.velocity).map(|(axis, v)| axis * v).sum();
    body.shape == Shape::HemisphericalCylinder && ahead > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kevlar KM2 S706: e = 0.0355 and c = 7666 m/s, so 7666 sqrt(2 x 0.0355 x 0.191731 - 0.00126025) = 852
    /// m/s.
    #[test]
    fn a_flat_face_is_named_from_a_quarter_of_the_breaking_velocity_on() {
        let mut scene = crate::parse("preset = \"sheet_10in_cylinder\"\n[fabric]\nname = \"kevlar_km2_s706\"").unwrap();
        assert!((breaking_velocity(&scene) - 852.0).abs() < 0.1, "{}", breaking_velocity(&scene));
        assert_eq!(sharp_edges(&scene, 212.0), None);
        assert!(sharp_edges(&scene, 366.0).unwrap().contains("At 366 m/s, 0.43 of the velocity"));
        scene.projectile.shape = Shape::Sphere;
        assert_eq!(sharp_edges(&scene, 366.0), None);
    }

    /// The presets' bodies, and their like in mm or g.
    #[test]
    fn a_wrong_unit_of_the_projectile_is_named() {
        for (size, mass, said) in [(1.0, 1.0, ""), (1e3, 1.0, "too light"), (1.0, 1e3, "too heavy"), (1.0, 0.0, "")] {
            for mut scene in [Scene::sheet_3in_sphere(), Scene::sheet_10in_cylinder()] {
                scene.projectile.radius *= size;
                scene.projectile.length *= size;
                scene.projectile.mass *= mass;
                let found = unlikely_body(&scene).unwrap_or_default();
                assert!(found.contains(said) && found.is_empty() == said.is_empty(), "{size} {mass}: {found}");
            }
        }
    }

    #[test]
    fn a_bullet_has_an_edge_where_its_tail_is_ahead() {
        let mut scene = crate::parse("preset = \"sheet_10in_cylinder\"\n[fabric]\nname = \"kevlar_km2_s706\"").unwrap();
        (scene.projectile.shape, scene.projectile.velocity) = (Shape::HemisphericalCylinder, [0.0, 0.0, 1.0]);
        for (orientation, nose_first) in
            [([1.0, 0.0, 0.0, 0.0], true), ([0.0, 1.0, 0.0, 0.0], false), ([0.96, 0.0, 0.28, 0.0], true)]
        {
            scene.projectile.orientation = orientation;
            assert_eq!(sharp_edges(&scene, 366.0).is_none(), nose_first, "{orientation:?}");
        }
    }
}
