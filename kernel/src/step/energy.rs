//! The balance of energy and momentum, computed only when asked for.
//!
//! Method: second-order audit of the staggered scheme. Kinetic energy from the stored half-step velocities,
//! strain and dissipated energy as means of the states at t_{n-1} and t_n. Dissipation is a state function of
//! alpha, so nothing is accumulated but contact loss, what friction, viscosity and rate take, work and
//! impulses. Integer-time kinetic energy would carry a first-order bias in contact.
//! Limits: second order in dt; a slackened sheet gains energy at the stiffness jump at U = 1 (docs/model.md).
//! Reference: docs/model.md, "Energy balance".

use crate::body::pose::Vector;
use crate::body::projectile::Body;
use crate::ground::error::{Code, Error, Failure};
use crate::ground::lanes::{self, Job, Lane};
use crate::ground::planes::{self, Axis, CHUNK, SPEED_X, X};
use crate::memory::network::{Network, SegmentView};
use crate::memory::state::State;
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::direction::{Direction, PlyDirections};
use crate::sheet::neighbours::Around;
use crate::step::readout::around;
use crate::sweep::moments;
use crate::yarn::law::{self, Segment};
use crate::yarn::rate::RateLaw;

/// Energies (M15), J.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Energy {
    /// Kinetic energy of the projectile, translation and rotation, J; 0 if its mass is unknown.
    pub projectile_kinetic: f64,
    /// Kinetic energy of the fabric, J.
    pub fabric_kinetic: f64,
    /// Strain energy of the yarns, J.
    pub strain: f64,
    /// Energy dissipated by rupture, J.
    pub dissipated: f64,
    /// Kinetic energy lost in impacts of nodes on the projectile, J.
    pub contact_loss: f64,
    /// Work of the projectile on the fabric: the energy absorbed, J.
    pub contact_work: f64,
    /// Work of the external load on the projectile, J.
    pub external_work: f64,
    /// Residual of the energy balance, J; in a sound run below 1 % of the kinetic energy at impact.
    pub residual: f64,
    /// Energy that the viscosity of the yarn and its dependence on the rate of strain have dissipated, J.
    pub viscous: f64,
    /// Energy dissipated by friction between yarn and projectile, J.
    pub friction: f64,
    /// Kinetic energy lost where separate plies meet, J.
    pub ply_loss: f64,
    /// Work of the projectile on fixed nodes, J: the part of `contact_work` that the fabric did not get. It
    /// is dissipated, and part of `contact_loss` and `friction`.
    pub support_work: f64,
    /// Kinetic energy lost where nodes of a ring meet its case, J.
    pub casing_loss: f64,
    /// Energy dissipated in clamps in which held nodes have slid, J.
    pub attachment: f64,
    /// Energy from nothing, J: by how much what contact impulses dissipate together would have fallen, over
    /// all steps. Part of `residual`; in a sound run below 1e-3 of the kinetic energy at impact.
    pub gained: f64,
}

/// Energy from nothing that a sound run has at most, over the kinetic energy at impact: above the 5e-5 that
/// the staggered scheme leaves in plies that fail.
pub const MOST_GAINED: f64 = 1e-3;

/// (M15) The energies, with a full pass over the sheet. Commits nothing.
pub(crate) fn energy(system: &System<'_>) -> Result<Energy, Failure> {
    let System { network, state, .. } = system;
    system.sound()?;
    let sums = &state.sums;
    let prescribed = !network.scene.is_free();
    let (fabric_kinetic, strain, dissipated) = energy_of_rows(network, state.sums.loaded, [0, network.layout.nodes_y]);
    let projectile_kinetic = state.body.kinetic_energy(&network.model.inertia);
    let viscous = sums.viscous + moments::uncounted_dissipation(network);
    let total = fabric_kinetic
        + strain
        + dissipated
        + viscous
        + sums.friction
        + sums.ply_loss
        + sums.loss
        + sums.casing.loss
        + sums.clamps.dissipated;
    let residual = if prescribed {
        total - sums.work - sums.first_energy
    } else {
        total + projectile_kinetic - sums.external_work - sums.first_energy
    };
    Ok(Energy {
        projectile_kinetic,
        fabric_kinetic,
        strain,
        dissipated,
        contact_loss: sums.loss,
        contact_work: sums.work,
        external_work: sums.external_work,
        residual,
        viscous,
        friction: sums.friction,
        ply_loss: sums.ply_loss,
        support_work: sums.support_work,
        casing_loss: sums.casing.loss,
        attachment: sums.clamps.dissipated,
        gained: sums.gained,
    })
}

/// Linear momentum that the balance does not close by, N s, host's axes. Commits nothing.
pub(crate) fn momentum_residual(system: &System<'_>) -> Result<[f64; 3], Failure> {
    let System { network, state, .. } = system;
    system.sound()?;
    let sums = &state.sums;
    let mut balance = momentum(network, &state.body) - sums.first_momentum - sums.external_impulse;
    if !network.scene.is_free() {
        // The body's reaction is the load the fabric received.
        balance += sums.impulse;
    }
    for support in sums.support.iter().chain([&sums.casing.impulse]) {
        balance += support * network.model.unit_impulse;
    }
    Ok(network.model.pose.vector_out(balance.into()))
}

/// Starts the audit, and what viscosity keeps, from the present state.
pub(crate) fn start_audit(network: &mut Network<'_>, state: &mut State) {
    moments::start(network);
    let (kinetic, strain, dissipated) = energy_of_rows(network, state.sums.loaded, [0, network.layout.nodes_y]);
    let mut energy = kinetic + strain + dissipated;
    if network.scene.is_free() {
        energy += state.body.kinetic_energy(&network.model.inertia);
    }
    state.sums.first_energy = energy;
    state.sums.first_momentum = momentum(network, &state.body);
}

/// Momentum of the fabric, and of the projectile where it is free, N s, sheet's frame.
fn momentum(network: &Network<'_>, body: &Body) -> Vector {
    let (nx, ny, chunks) = (network.layout.nodes_x, network.layout.nodes_y, network.layout.chunks);
    let mut total = Vector::zeros();
    for j in 0..ny {
        let row = planes::row(network.arrays.rows.hot, chunks, j);
        let weighted = |plane: usize, i: usize| Some(planes::get(row, plane, i)? * network.share(i, j));
        let sum = |plane: usize| -> f64 { (0..nx).filter_map(|i| weighted(plane, i)).sum() };
        total += Vector::new(sum(3), sum(4), sum(5)) * network.mass_share_of_row(j);
    }
    let mut momentum = total.component_mul(&network.scene.symmetry.force_mask()) * network.model.unit_impulse;
    if network.scene.is_free() {
        momentum += body.velocity * network.model.inertia.mass;
    }
    momentum
}

/// Failed segments and energies of one ply of a stack.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Ply {
    /// Segments with alpha = 0 (M5) in the forces of the last step.
    pub failed_segments: u64,
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Strain energy, J.
    pub strain: f64,
    /// Energy dissipated by rupture, J.
    pub dissipated: f64,
}

/// Failed segments and energies of a ply, with a pass over its rows. Commits nothing.
pub(crate) fn ply(network: &Network<'_>, loaded: u64, ply: u32) -> Result<Ply, Error> {
    let plies = network.layout.plies;
    if ply as usize >= plies {
        return Err(Error::new(Code::OutOfRange, "ply", f64::from(ply), plies as f64 - 1.0));
    }
    let rows = network.layout.rows_of(ply as usize);
    let (kinetic, strain, dissipated) = energy_of_rows(network, loaded, rows);
    Ok(Ply { failed_segments: network.count_failed(rows), kinetic, strain, dissipated })
}

/// Kinetic, strain and dissipated energy of rows [first, end), J, after `loaded` steps of load. Summed row by
/// row, rows in order.
fn energy_of_rows(network: &Network<'_>, loaded: u64, [first, end]: [usize; 2]) -> (f64, f64, f64) {
    let (mut kinetic, mut strain, mut dissipated) = (0.0, 0.0, 0.0);
    // Before and now, along x and along y.
    let rates = [Axis::Horizontal, Axis::Vertical]
        .map(|axis| [network.rate_law_before(axis, loaded), network.rate_law(axis, loaded)]);
    for j in first..end {
        let share = network.mass_share_of_row(j);
        kinetic += share * squared_velocities(network, j);
        let (row_strain, row_dissipated) = yarns_of_row(network, &rates, j);
        kinetic += share * slack_balance_correction(network, loaded, j);
        strain += share * row_strain;
        dissipated += row_dissipated;
    }
    let unit = network.model.unit_energy;
    (0.5 * unit * kinetic, unit * strain, dissipated * network.model.segment_volume)
}

/// Correction of the squared velocities of the half step to the mean of v_{n-3/2} v_{n-1/2} and v_{n-1/2}
/// v_{n+1/2}, contact aside: energy errors (M9) are exact for that mean. 0 without them.
#[inline(never)]
fn slack_balance_correction(network: &Network<'_>, loaded: u64, j: usize) -> f64 {
    let mut sum = 0.0;
    if network.layout.has(Feature::Slack) {
        for (i, axis) in (0..network.layout.nodes_x).flat_map(|i| [(i, Axis::Horizontal), (i, Axis::Vertical)]) {
            let Some(segment) = network.segment(axis, i, j) else { continue };
            let weight = network.layout.segment_weight(axis, i, j) * segment.bar[1];
            let growth = segment.growth_of_work(network.stiffness_now(&segment, loaded));
            sum -= 0.25 * weight * segment.rest.length * segment.rest.length * growth;
        }
    }
    sum
}

/// Sum of the squared velocities of a row, each component by itself, in units of (h/dt)^2 and of a node's
/// mass.
fn squared_velocities(network: &Network<'_>, j: usize) -> f64 {
    let (layout, mut sums) = (&network.layout, [0.0; 3]);
    let row = planes::row(network.arrays.rows.hot, layout.chunks, j);
    let weighted = layout.has(Feature::Grading) || layout.x.is_mirrored() || layout.y.is_mirrored();
    for (c, [_, _, _, vx, vy, vz, ..]) in row.iter().enumerate() {
        for (k, ((vx, vy), vz)) in vx.iter().zip(vy).zip(vz).enumerate().take(layout.nodes_x.saturating_sub(c * CHUNK))
        {
            let share = if weighted { network.share(c * CHUNK + k, j) } else { 1.0 };
            sums = [sums[0] + vx * vx * share, sums[1] + vy * vy * share, sums[2] + vz * vz * share];
        }
    }
    sums[0] + sums[1] + sums[2]
}

/// Strain energy of the segments that start in a row, in units of m (h/dt)^2, and energy that they have
/// dissipated, in J/m^3 times `segment_volume`. `rates`: before and now, along x and along y. Those of a
/// chunk of plain yarn without damage are found side by side; all are summed in one order.
#[inline(never)]
fn yarns_of_row(network: &Network<'_>, rates: &[[RateLaw; 2]; 2], j: usize) -> (f64, f64) {
    let layout = &network.layout;
    let ends = network.ends_of_segments(j);
    let plain = !(layout.has(Feature::Theta) || layout.has(Feature::Rate));
    let PlyDirections { horizontal, vertical, .. } = network.directions_of_row(j);
    let areas = [horizontal, vertical].map(|direction| direction.rest.length * direction.rest.length);
    let (mut strain, mut dissipated) = (0.0, 0.0);
    for (c, [across, up]) in planes::row(network.arrays.rows.history, layout.chunks, j).iter().enumerate() {
        let [mut along_x, mut along_y] = [[0.0; CHUNK]; 2];
        let mut whole = [false; 2];
        if plain && let Some(around) = around(network, c, j) {
            whole = [
                stored_in_chunk(network, &around, horizontal, (Axis::Horizontal, across), &mut along_x),
                stored_in_chunk(network, &around, vertical, (Axis::Vertical, up), &mut along_y),
            ];
        }
        for (k, (x, y)) in along_x.iter().zip(&along_y).enumerate() {
            let i = c * CHUNK + k;
            for (axis, a, stored) in [(Axis::Horizontal, 0, x), (Axis::Vertical, 1, y)] {
                if whole[a] && i < ends[a] {
                    strain += stored * areas[a];
                } else if i < ends[a] {
                    let (stored, lost) = weighted_energy(network, &rates[a], axis, i, j);
                    strain += stored;
                    dissipated += lost;
                }
            }
        }
    }
    (strain, dissipated)
}

/// The mean strain energies of the segments along an axis from a chunk of nodes, with their history, as
/// [`segment_energy`] has them of plain yarn without damage; returns whether none of them is damaged.
#[inline(never)]
fn stored_in_chunk(
    network: &Network<'_>,
    around: &Around<'_>,
    direction: &Direction,
    (axis, history): (Axis, &[f64; CHUNK]),
    stored: &mut [f64; CHUNK],
) -> bool {
    lanes::dispatch(network.instructions, StoredInChunk { around, axis, direction, history, stored })
}

/// [`stored_in_chunk`] as a job for the lanes.
struct StoredInChunk<'a> {
    around: &'a Around<'a>,
    axis: Axis,
    direction: &'a Direction,
    history: &'a [f64; CHUNK],
    stored: &'a mut [f64; CHUNK],
}

impl Job for StoredInChunk<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lane>(self) -> bool {
        let StoredInChunk { around, axis, direction, history, stored } = self;
        let (rest, critical) = (direction.rest.lanes::<L>(), L::splat(direction.critical));
        let mut whole = true;
        for g in 0..CHUNK / L::WIDTH {
            let (d, v) = (around.of_axis::<L>(axis, X, g), around.of_axis::<L>(axis, SPEED_X, g));
            let now = rest.twice_strain(d);
            let before = rest.twice_strain([d[0].sub(v[0]), d[1].sub(v[1]), d[2].sub(v[2])]);
            let stiffness = around.stiffness::<L>(g)[axis as usize];
            let sum = law::strain_energy(stiffness, before).add(law::strain_energy(stiffness, now));
            L::splat(0.5).mul(sum).store(&mut L::groups_mut(stored)[g]);
            whole &= !(now.any_above(critical) || L::load(&L::groups(history)[g]).any_above(critical));
        }
        whole
    }
}

/// Energies of a segment by [`segment_energy`], times its multiplicity, in the units of [`yarns_of_row`].
#[inline(never)]
pub(crate) fn weighted_energy(
    network: &Network<'_>,
    rates: &[RateLaw; 2],
    axis: Axis,
    i: usize,
    j: usize,
) -> (f64, f64) {
    let Some(segment) = network.segment(axis, i, j) else { return (0.0, 0.0) };
    let (stored, lost) = segment_energy(network, rates, &segment);
    let [segments, yarns] = segment.bar;
    let weight = network.layout.segment_weight(axis, i, j) * yarns;
    let volume = network.direction_of(&segment).volume;
    (weight * (stored * (segment.rest.length * segment.rest.length)), weight * (lost * (volume * segments)))
}

/// Strain energy in units of m (h/dt)^2 over l^2 and dissipated energy density, J/m^3, as means over t_{n-1}
/// and t_n.
fn segment_energy(network: &Network<'_>, [rate_before, rate_now]: &[RateLaw; 2], segment: &SegmentView) -> (f64, f64) {
    let (before, now) = (segment.twice_strain_before(), segment.twice_strain());
    let direction = network.direction_of(segment);
    let seen = rate_now.seen_at(now);
    let fresh = direction.law.is_damaging(seen, segment.history);
    if segment.history <= direction.critical && !fresh {
        let stiffness = segment.stiffness;
        return (0.5 * (rate_before.stored(stiffness, before) + rate_now.stored(stiffness, now)), 0.0);
    }
    let law = network.law_of(segment);
    let [segments, _] = segment.bar;
    let modulus = segment.undamaged * (direction.modulus_per_stiffness * segments);
    let material = Segment { modulus, damage_rate: segment.damage_rate };
    let alpha_before = law.alpha(segment.damage_rate, segment.history);
    let alpha_now = if fresh { law.alpha(segment.damage_rate, seen) } else { alpha_before };
    let stored_before = rate_before.stored(segment.stiffness, before);
    let stored_now = rate_now.stored(alpha_now * segment.undamaged, now);
    let lost = law.dissipated(&material, alpha_before) + law.dissipated(&material, alpha_now);
    (0.5 * (stored_before + stored_now), 0.5 * lost)
}

/// The balance, entry by entry, from positions and damage at t_{n-1} and t_n and the formulas of the model.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sim;
    use crate::ground::math;
    use crate::scene::parts::{AttachmentKind, Drive, Scene, Shape, StrengthDraw};
    use crate::tests::{close, sheet, sim};
    use std::vec::Vec;

    /// 21 x 21 nodes, four sides held, uniform yarn, the preset sphere at 60 m/s.
    fn sphere() -> Scene {
        let mut scene = sheet(21, 21);
        scene.yarn.stochastic = false;
        (scene.track_support, scene.projectile.velocity) = (true, [0.0, 0.0, 60.0]);
        scene
    }

    /// A tumbling cylinder that tears drawn yarns, whose law has an offset and drops at once at the critical
    /// stretch.
    fn cylinder() -> Scene {
        let mut scene = sphere();
        (scene.yarn.stochastic, scene.yarn.damage_a, scene.yarn.damage_b) = (true, 0.95, 0.02);
        let (radius, length, tilt) = (6.35e-3, 0.0381, 0.35);
        let body = &mut scene.projectile;
        (body.shape, body.radius, body.length, body.mass) = (Shape::Cylinder, radius, length, 0.037);
        let lowest = 0.5 * length * math::cos(tilt) + radius * math::sin(tilt);
        (body.position, body.velocity) = ([0.0, 0.0, -lowest - 1e-6], [0.0, 0.0, 120.0]);
        (body.orientation, body.angular_velocity) =
            ([math::cos(0.5 * tilt), math::sin(0.5 * tilt), 0.0, 0.0], [300.0, -500.0, 2000.0]);
        scene
    }

    fn positions(sim: &Sim<'_>) -> Vec<Vector> {
        let mut flat = std::vec![0.0; 3 * sim.layout().nodes()];
        sim.copy_positions(&mut flat).unwrap();
        flat.as_chunks::<3>().0.iter().map(|x| Vector::from(*x)).collect()
    }

    fn damage(sim: &Sim<'_>) -> Vec<f64> {
        let mut alpha = std::vec![0.0; sim.layout().segments()];
        sim.copy_damage(&mut alpha).unwrap();
        alpha
    }

    /// The nodes of every segment: horizontal row by row, then vertical.
    fn ends(scene: &Scene) -> Vec<[usize; 2]> {
        let (nx, ny) = (scene.sheet.nodes_x as usize, scene.sheet.nodes_y as usize);
        let across = (0..ny).flat_map(|j| (0..nx - 1).map(move |i| [j * nx + i, j * nx + i + 1]));
        let up = (0..ny - 1).flat_map(|j| (0..nx).map(move |i| [j * nx + i, (j + 1) * nx + i]));
        across.chain(up).collect()
    }

    /// Strain and dissipated energy, J, of the sheet with these positions and damage.
    fn in_yarns(scene: &Scene, x: &[Vector], alpha: &[f64]) -> (f64, f64) {
        let (law, h) = (scene.damage_law(Axis::Horizontal), scene.sheet.spacing);
        let (mut strain, mut dissipated) = (0.0, 0.0);
        for (k, [from, to]) in ends(scene).into_iter().enumerate() {
            let (segment, volume) = (scene.draw_segment(k as u64).unwrap(), scene.lumped_area() * h);
            let stretch = (x[to] - x[from]).norm() / h;
            let green_lagrange = math::max(0.5 * (stretch * stretch - 1.0), 0.0);
            strain += volume * 0.5 * alpha[k] * segment.modulus * green_lagrange * green_lagrange;
            let own = law.at(scene.draw_critical_stretch(k as u64));
            dissipated += volume * own.dissipated(&segment, alpha[k]);
        }
        (strain, dissipated)
    }

    fn of_projectile(sim: &Sim<'_>) -> f64 {
        let (motion, mass) = (sim.projectile().unwrap(), sim.scene().projectile.mass);
        let (v, moments) = (Vector::from(motion.velocity), sim.system.network.model.inertia.moments);
        let q = crate::body::pose::quaternion(motion.orientation);
        let w = crate::body::pose::into_body(&q, &Vector::from(motion.angular_velocity));
        0.5 * mass * v.norm_squared() + 0.5 * w.component_mul(&moments).dot(&w)
    }

    #[test]
    fn every_entry_is_a_sum_over_nodes_or_segments() {
        let mut drawn = cylinder();
        (drawn.yarn.strength_draw, drawn.yarn.weibull_shape) = (StrengthDraw::Weibull, 6.0);
        [cylinder(), drawn].iter().for_each(entries_are_sums);
    }

    fn entries_are_sums(scene: &Scene) {
        let mut sim = sim(scene);
        let (m, dt) = (scene.sheet.node_mass, sim.step_limits().dt);
        let first = of_projectile(&sim);
        sim.set_external_load([40.0, -25.0, 300.0], [0.02, -0.03, 0.01]).unwrap();
        let (mut x, mut alpha) = (positions(&sim), damage(&sim));
        let (mut partly, mut broken) = (0, 0);
        for n in 0..900 {
            sim.step().unwrap();
            let (x_now, alpha_now) = (positions(&sim), damage(&sim));
            if n % 15 == 0 {
                let energy = sim.energy().unwrap();
                // The velocity is that between two positions; strain and dissipation are means of both.
                let kinetic: f64 = x_now.iter().zip(&x).map(|(a, b)| 0.5 * m * ((a - b) / dt).norm_squared()).sum();
                let (before, now) = (in_yarns(scene, &x, &alpha), in_yarns(scene, &x_now, &alpha_now));
                let (strain, dissipated) = (0.5 * (before.0 + now.0), 0.5 * (before.1 + now.1));
                // The sheet at rest is so but for the rounding of its positions.
                for (entry, sum) in
                    [(energy.fabric_kinetic, kinetic), (energy.strain, strain), (energy.dissipated, dissipated)]
                {
                    assert!((entry - sum).abs() <= 1e-9 * sum + 1e-15 * first, "{entry:e} is not {sum:e}");
                }
                close(energy.projectile_kinetic, of_projectile(&sim), 1e-12);
                let held = kinetic + strain + dissipated + energy.contact_loss;
                let residual = held + energy.projectile_kinetic - energy.external_work - first;
                assert!((energy.residual - residual).abs() < 1e-9 * first && energy.external_work != 0.0);
                let balance = Vector::from(sim.momentum_residual().unwrap());
                assert!(balance.norm() < 1e-11 * 0.037 * 120.0);
                partly += alpha_now.iter().filter(|alpha| **alpha > 0.0 && **alpha < 1.0).count();
                broken += alpha_now.iter().filter(|alpha| **alpha == 0.0).count();
            }
            (x, alpha) = (x_now, alpha_now);
        }
        assert!(partly > 10 && broken > 10, "{partly} {broken}");
    }

    #[test]
    fn the_audit_starts_with_what_is_there() {
        for drive in [Drive::Free, Drive::Prescribed] {
            let mut scene = sphere();
            (scene.drive, scene.attachment.kind) = (drive, AttachmentKind::Free);
            let mut sim = sim(&scene);
            let x = positions(&sim);
            sim.set_largest_stretch(&std::vec![1.034; sim.layout().segments()]).unwrap();
            let stretched: Vec<f64> = x.iter().flat_map(|x| [1.01 * x.x, 1.02 * x.y, x.z]).collect();
            let speeds: Vec<f64> = x.iter().flat_map(|x| [30.0 * x.y, 10.0, 200.0 * x.x]).collect();
            sim.set_motion(&stretched, &speeds).unwrap();
            let energy = sim.energy().unwrap();
            let held = energy.fabric_kinetic + energy.strain + energy.dissipated;
            assert!(energy.fabric_kinetic > 1e-6 && energy.strain > 1e-3 && energy.dissipated > 1e-3);
            assert!(energy.residual.abs() < 1e-12 * (held + energy.projectile_kinetic));
            let momentum = 441.0 * scene.sheet.node_mass * 10.0;
            assert!(Vector::from(sim.momentum_residual().unwrap()).norm() < 1e-12 * momentum);
        }
    }
}
