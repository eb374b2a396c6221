//! At how many crossings the yarns would slip, which the network pins; computed only when asked for.
//!
//! Method: F_w and F_f are what the two segments of the warp and of the weft together do to a node. Pinned,
//! both yarns move alike, so each is given |F_w - F_f|/2 by the other, of which the part in the plane of the
//! two counts. Friction and adhesion give f_0 + mu N at most. With tension the yarns press on each other
//! because they wind: the heights of their waves add up to the thickness D of the ply, and each turns by
//! twice its height over the spacing, so 2 T_w d_w/h_x = 2 T_f d_f/h_y = N, d_w + d_f = D, and with one
//! spacing h and Theta = D/h: N = 2 Theta T_w T_f/(T_w + T_f). On the body the outer yarn also presses with
//! its own force across the plane; the network does not know which one it is, so the mean of both counts.
//! Limits: of forces while pinned, so it says where slip begins, not how far it goes; yarns of equal mass; a
//! bar is one yarn, and coarse parts of a graded network are left out; without viscosity, what slack yarns
//! owe, and friction on the body; not of curved sheets.
//! Reference: F. T. Peirce, J. Textile Inst. 28 (1937) T45 (Theta); evidence/resolved/README.md.

use crate::body::pose::Vector;
use crate::contact::search::Search;
use crate::ground::error::{Error, not_negative, positive};
use crate::ground::math;
use crate::ground::planes::Axis;
use crate::memory::network::Network;
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sweep::forces::forces_from;

/// Distances from the projectile, in spacings, within which crossings are counted.
const NEAR: [f64; 3] = [5.0, 10.0, f64::INFINITY];

/// Gap below which a node is on the body, spacings.
const ON_BODY: f64 = 1e-3;

/// Crossings that would slip. Of three numbers each counts within 5 and within 10 spacings of the projectile
/// along the sheet, and in the whole sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Slip {
    /// Crossings that are not held by a support.
    pub crossings: [u64; 3],
    /// Crossings at which pinning takes more than friction and adhesion give.
    pub slipping: [u64; 3],
    /// Largest force in the plane that pinning takes at a crossing, N.
    pub largest: f64,
}

/// Effect of one yarn at a crossing: its force on the node, N, mean tension, N, and a vector along it.
struct YarnAtNode {
    force: Vector,
    tension: f64,
    along: Vector,
}

/// Counts, with a pass over the sheet. Commits nothing.
pub(crate) fn slip(system: &System<'_>, thickness: f64, friction: f64, adhesion: f64) -> Result<Slip, Error> {
    system.sound()?;
    positive("thickness", thickness)?;
    not_negative("friction", friction)?;
    not_negative("adhesion", adhesion)?;
    let System { network, solid, state, .. } = system;
    if network.layout.has(Feature::Curved) {
        return Err(Error::beside("slip", "sheet.radius"));
    }
    let (h, place) = (network.scene.sheet.spacing, state.body.position);
    let adhesion = adhesion * f64::from(network.scene.sheet.plies);
    let mut found = Slip::default();
    let search = Search::new(solid, &state.body, h, h);
    for (i, j) in network.nodes() {
        let Some([pinning_force, normal]) = crossing(network, &search, state.sums.loaded, thickness, [i, j]) else {
            continue;
        };
        let [x, y, _] = network.rest(i, j);
        let distance = math::length([x - place.x / h, y - place.y / h, 0.0]);
        let weight = network.layout.node_weight(i, j) as u64;
        for (k, most) in NEAR.into_iter().enumerate() {
            if distance <= most {
                found.crossings[k] += weight;
                found.slipping[k] += if pinning_force > adhesion + friction * normal { weight } else { 0 };
            }
        }
        found.largest = math::max(pinning_force, found.largest);
    }
    Ok(found)
}

/// The force in the plane that pinning takes at a node, and that by which the yarns press on each other, N;
/// None where it is no crossing of two yarns.
fn crossing(
    network: &Network<'_>,
    search: &Search<'_>,
    loaded: u64,
    thickness: f64,
    [i, j]: [usize; 2],
) -> Option<[f64; 2]> {
    if network.is_fixed(i, j) {
        return None;
    }
    let warp = yarn(network, loaded, Axis::Horizontal, [i, j], network.layout.x.before(i).map(|before| [before, j]))?;
    let weft = yarn(network, loaded, Axis::Vertical, [i, j], j.checked_sub(1).map(|before| [i, before]))?;
    let across = warp.along.cross(&weft.along);
    let length = math::length(across.into());
    if length <= 0.0 {
        return None;
    }
    let (across, pinning) = (across / length, (warp.force - weft.force) * 0.5);
    let pinning_force = math::length((pinning - across * pinning.dot(&across)).into());
    let [h_x, h_y] = network.scene.spacings();
    let (warp_part, weft_part) = (warp.tension / h_x, weft.tension / h_y);
    let sum = warp_part + weft_part;
    let mut normal = if sum > 0.0 { 2.0 * thickness * warp_part * weft_part / sum } else { 0.0 };
    if search.gap(&network.position(i, j)) <= ON_BODY * h_x {
        normal += 0.5 * (math::abs(warp.force.dot(&across)) + math::abs(weft.force.dot(&across)));
    }
    Some([pinning_force, normal])
}

/// The yarn along an axis at a node; None where a bar stands for several yarns or segments.
fn yarn(
    network: &Network<'_>,
    loaded: u64,
    axis: Axis,
    [i, j]: [usize; 2],
    before: Option<[usize; 2]>,
) -> Option<YarnAtNode> {
    let unit = network.model.unit_impulse / network.model.limits.dt * network.mass_share_of_row(j);
    let mut yarn = YarnAtNode { force: Vector::zeros(), tension: 0.0, along: Vector::zeros() };
    for (start, sign) in [(Some([i, j]), 1.0), (before, -1.0)] {
        let Some([i, j]) = start else { continue };
        let Some(segment) = network.segment(axis, i, j) else { continue };
        if segment.bar != [1.0; 2] {
            return None;
        }
        let force = Vector::from(forces_from(network, loaded, false, i, j)?[axis as usize]) * unit;
        yarn.force += force * sign;
        yarn.tension += 0.5 * math::length(force.into());
        let mut along = Vector::from(segment.d);
        along[axis as usize] += segment.rest.spacing;
        yarn.along += along;
    }
    Some(yarn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parts::Scene;
    use crate::tests::{close, sheet, sim};

    /// One crossing in a given place among held ones, spacings unlike along x and y, and the sphere so many
    /// of them along x below it: forces to the right, left, up and down, N, by hand from (M3) and (M4); and
    /// the simulation.
    fn one_crossing(at: [f64; 3], strains: [f64; 2], gap: f64) -> ([[f64; 3]; 4], Scene, crate::Sim<'static>) {
        let mut scene = sheet(3, 3);
        (scene.sheet.spacing_y, scene.yarn.stochastic) = (1.3 * scene.sheet.spacing, false);
        scene.projectile.position[2] = -0.1;
        let mut sim = sim(&scene);
        let [h_x, h_y] = scene.spacings();
        for (i, j) in sim.system.network.nodes() {
            let [x, y] = [i as f64 - 1.0, (j as f64 - 1.0) * h_y / h_x];
            sim.system.network.set_node(i, j, [x * strains[0], y * strains[1], 0.0], [0.0; 3]);
        }
        sim.system.network.set_node(1, 1, at, [0.0; 3]);
        sim.system.state.body.position = Vector::new(at[0], at[1], at[2] - gap) * h_x;
        sim.system.state.body.position.z -= scene.projectile.radius;
        let stiffness = scene.yarn.modulus_mean * scene.sheet.yarn_area;
        let ends = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        let forces = ends.map(|[x, y]| {
            let rest = if x != 0.0 { h_x } else { h_y };
            let d =
                [x * h_x * (1.0 + strains[0]) - at[0] * h_x, y * h_y * (1.0 + strains[1]) - at[1] * h_x, -at[2] * h_x];
            let q = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / (rest * rest) - 1.0;
            d.map(|d| 0.5 * stiffness * q.max(0.0) * d / rest)
        });
        (forces, scene, sim)
    }

    #[test]
    fn a_crossing_slips_above_the_force_that_friction_gives() {
        let thickness = 0.2e-3;
        for (at, gap) in [([0.004, 0.0, 0.0], 10.0), ([0.0, 0.006, 0.0], 10.0), ([0.003, 0.0, 0.15], 0.0)] {
            let ([right, left, up, down], scene, sim) = one_crossing(at, [0.012, 0.02], gap);
            let [warp, weft] = [[right, left], [up, down]].map(|[a, b]| [0, 1, 2].map(|k| a[k] + b[k]));
            let [warp_tension, weft_tension] =
                [[right, left], [up, down]].map(|[a, b]| 0.5 * (math::length(a) + math::length(b)));
            let [h_x, h_y] = scene.spacings();
            // The heights d_w and d_f of the waves add up to the thickness, and both yarns press alike.
            let weft_height = thickness * (warp_tension / h_x) / (warp_tension / h_x + weft_tension / h_y);
            let mut normal = 2.0 * weft_tension * weft_height / h_y;
            close(2.0 * warp_tension * (thickness - weft_height) / h_x, normal, 1e-12);
            if gap == 0.0 {
                normal += 0.5 * (warp[2].abs() + weft[2].abs());
            }
            // The neighbours lie in the plane z = 0, opposite each other, so the plane of the yarns is that
            // one.
            let taken = 0.5 * math::length([warp[0] - weft[0], warp[1] - weft[1], 0.0]);
            assert!(taken > 0.1 && normal > 0.1, "{taken} {normal}");
            let count = |friction: f64, adhesion: f64| sim.slip(thickness, friction, adhesion).unwrap();
            let found = count(0.0, taken * 0.999_999);
            assert_eq!((found.crossings, found.slipping), ([1; 3], [1; 3]));
            close(found.largest, taken, 1e-9);
            assert_eq!(count(0.0, taken * 1.000_001).slipping, [0; 3]);
            assert_eq!(count(taken / normal * 0.999_999, 0.0).slipping, [1; 3]);
            assert_eq!(count(taken / normal * 1.000_001, 0.0).slipping, [0; 3]);
            assert_eq!(count(0.5 * taken / normal, 0.500_001 * taken).slipping, [0; 3]);
        }
    }

    #[test]
    fn crossings_are_counted_by_their_distance_and_with_their_images() {
        let mut scene = sheet(41, 41);
        scene.yarn.stochastic = false;
        let whole = sim(&scene).slip(1e-4, 0.1, 0.0).unwrap();
        // Places of a square lattice within 5 and 10 spacings of one of them.
        assert_eq!((whole.crossings, whole.slipping), ([81, 317, 39 * 39], [0; 3]));
        scene.symmetry = crate::scene::parts::Symmetry { mirror_x: true, mirror_y: true };
        assert_eq!(sim(&scene).slip(1e-4, 0.1, 0.0), Ok(whole));
        for (given, field) in
            [([0.0, 0.1, 0.0], "thickness"), ([1e-4, -0.1, 0.0], "friction"), ([1e-4, 0.1, f64::NAN], "adhesion")]
        {
            assert_eq!(sim(&scene).slip(given[0], given[1], given[2]).unwrap_err().field, field);
        }
    }
}
