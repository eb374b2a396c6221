//! Notes that go with the numbers of a shot: every report takes it from here.

use crate::density::{LIGHTEST, density};
use fabric_kernel::math::sqrt;
use fabric_kernel::pose::{Vector, into_body, normalised};
use fabric_kernel::{Energy, Error, Form, MOST_GAINED, Scene, Shape, Sim, Solid};

/// Part of the velocity at which a yarn breaks at once from which sharp edges are named. Bars at the edge of
/// a flat face were seen to break within 6 us from 0.31 of it on (`python -m evidence edges`).
const NAMED_FROM: f64 = 0.25;

/// A sentence on the edges of a projectile with flat faces that flies as the scene says, but at this speed,
/// m/s; none if it is slow, or if the cloth rounds them with half its thickness by a bar's length or more.
pub fn sharp_edges(scene: &Scene, speed: f64) -> Option<String> {
    let (part, radius) = (speed / breaking_velocity(scene), 0.5 * scene.thickness());
    let is_round = scene.projectile.shape == Shape::Sphere || is_nose_first(scene) || radius >= scene.largest_spacing();
    if part < NAMED_FROM || is_round {
        return None;
    }
    Some(format!(
        "the projectile has flat faces, whose edges are rounded by half the thickness of the cloth alone, {:.2} mm: less than a bar. At {speed:.0} m/s, \
         {part:.2} of the velocity at which a yarn that is hit across breaks at once, bars at an edge may break within microseconds. \
         From which velocity on depends on the node spacing and the place of the hit (docs/validation.md, \"Spacing\")",
        1e3 * radius
    ))
}

/// Nodes under the flat front of a projectile from which on a network is fine enough
/// (`python -m evidence mesh`).
const NODES_UNDER_FLAT: f64 = 10.0;

/// A sentence on a network that is too coarse for the flat front of the projectile, with the yarns a bar
/// to take. `yarn_spacing`: of the fabric, m, where it is known.
pub fn coarse_network(scene: &Scene, yarn_spacing: Option<f64>) -> Option<String> {
    let ([h_x, h_y], front) = (scene.spacings(), flat_front(scene));
    let nodes = front / (h_x * h_y);
    if front == 0.0 || nodes >= NODES_UNDER_FLAT {
        return None;
    }
    let factor = sqrt(nodes / NODES_UNDER_FLAT);
    let bars = |h: f64| format!("sheet.yarns_per_bar = {:.2}", scene.largest_spacing() / h * factor);
    let finer = yarn_spacing.map_or_else(|| format!("{factor:.2} times the sheet.yarns_per_bar"), bars);
    Some(format!(
        "the flat front of the projectile, {:.1} mm\u{b2}, covers {nodes:.1} nodes: with fewer than {NODES_UNDER_FLAT} the limit \
         depends on the network by more than 5 %. Take {finer} (docs/validation.md, \"Spacing\")",
        1e6 * front
    ))
}

/// Area of the flat faces ahead of the projectile, within 10 degrees of its flight, m^2; 0 of a round front.
fn flat_front(scene: &Scene) -> f64 {
    const AHEAD: f64 = 0.985;
    let body = &scene.projectile;
    let q = normalised(body.orientation);
    let flight = into_body(&q, &Vector::from(body.velocity));
    let along = |n: [f64; 3]| n[0] * flight.x + n[1] * flight.y + n[2] * flight.z >= AHEAD * flight.norm();
    let disc = core::f64::consts::PI * body.radius * body.radius;
    match Solid::of(body).form {
        _ if flight.norm() == 0.0 => 0.0,
        Form::Polyhedron(solid) => solid.face_areas().filter(|(n, _)| along((*n).into())).map(|(_, area)| area).sum(),
        Form::Cylinder { .. } if along([0.0, 0.0, 1.0]) || along([0.0, 0.0, -1.0]) => disc,
        Form::HemisphericalCylinder { .. } if along([0.0, 0.0, -1.0]) => disc,
        _ => 0.0,
    }
}

/// A sentence on loose plies that have a thickness: only the first meets the projectile.
pub fn loose_and_thick(scene: &Scene) -> Option<String> {
    (scene.stack.plies > 1 && scene.thickness() > 0.0).then(|| {
        "loose plies with a thickness push on each other along z only, so that the first is torn aside and ten absorb 70 % less. \
         Take sheet.thickness = 0 (docs/validation.md, \"Several plies\")"
            .to_string()
    })
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

/// What is said where energy comes from nothing, or the energy residual exceeds 1 % of the impact energy, J:
/// none of a body without energy.
///
/// # Errors
/// The simulation has failed.
pub fn open_balance(sim: &Sim<'_>, impact_energy: f64, energy: &Energy) -> Result<Option<String>, Error> {
    let (residual, gained) = (energy.residual, energy.gained > MOST_GAINED * impact_energy);
    if impact_energy == 0.0 || !gained && residual.abs() <= OPEN * impact_energy {
        return Ok(None);
    }
    let (at, open) = (1e6 * sim.time(), 100.0 * residual / impact_energy);
    if gained {
        return Ok(Some(format!(
            "at {at:.1} us contact has given {:.1} % of the impact energy that came from nowhere (energy.gained): the outcome is not \
             to be trusted. Take half of time_step.fraction; if that does not help, plies have been torn out of their order on the case",
            100.0 * energy.gained / impact_energy
        )));
    }
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

    #[test]
    fn loose_plies_are_surfaces_unless_they_are_given_a_thickness() {
        let of = |fabric: &str| {
            crate::parse(&format!("preset = \"sheet_3in_sphere\"\nfabric = {fabric}\nstack.plies = 3")).unwrap()
        };
        let [surfaces, thick] =
            ["\"kevlar_km2_s706\"", "{ name = \"kevlar_km2_s706\", thickness = \"0.2 mm\" }"].map(of);
        assert_eq!([surfaces.sheet.thickness, thick.sheet.thickness], [0.0, 2e-4]);
        let radius = surfaces.projectile.radius;
        assert!((surfaces.projectile.position[2] + radius).abs() < 1e-15, "touches the surface");
        assert_eq!([surfaces, thick].map(|scene| loose_and_thick(&scene).is_some()), [false, true]);
    }

    /// Kevlar KM2 S706: e = 0.0355 and c = 7666 m/s, so 7666 sqrt(2 x 0.0355 x 0.191731 - 0.00126025) = 852
    /// m/s.
    #[test]
    fn a_flat_face_is_named_from_a_quarter_of_the_breaking_velocity_on() {
        let mut scene = crate::parse("preset = \"sheet_10in_cylinder\"\n[fabric]\nname = \"kevlar_km2_s706\"").unwrap();
        assert!(coarse_network(&scene, None).is_none());
        assert!((breaking_velocity(&scene) - 852.0).abs() < 0.1, "{}", breaking_velocity(&scene));
        assert_eq!(sharp_edges(&scene, 212.0), None);
        assert!(sharp_edges(&scene, 366.0).unwrap().contains("At 366 m/s, 0.43 of the velocity"));
        scene.sheet.plies = 10;
        assert_eq!(sharp_edges(&scene, 366.0), None, "rounded by 1.3 mm");
        (scene.sheet.plies, scene.projectile.shape) = (1, Shape::Sphere);
        assert_eq!(sharp_edges(&scene, 366.0), None);
    }

    /// Cube of 4 mm: 16 mm^2 over bars 0.747 mm apart are 28.7 nodes, over those of two yarns 7.2.
    #[test]
    fn a_network_too_coarse_for_a_flat_front_names_its_yarns_a_bar() {
        let scene = |bar: u32| {
            let text = format!(
                "fabric = \"kevlar_km2_s706\"\nsheet.yarns_per_bar = {bar}\naim.speed = 300\n[projectile]\nshape = \"box\"\nsize = [4e-3, 4e-3, 4e-3]\n"
            );
            crate::parse(&text).unwrap()
        };
        let h = scene(1).sheet.spacing;
        assert_eq!(coarse_network(&scene(1), Some(h)), None);
        let said = coarse_network(&scene(2), Some(h)).unwrap();
        // 2 sqrt(7.17/10)
        assert!(said.contains("16.0 mm\u{b2}, covers 7.2 nodes") && said.contains("yarns_per_bar = 1.69"), "{said}");
        let mut tilted = scene(2);
        tilted.projectile.orientation = [0.9, 0.3, 0.3, 0.1];
        assert_eq!(coarse_network(&tilted, None), None);
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
