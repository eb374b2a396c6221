//! Starts: the projectile's first motion, and sheets that a host has moved or damaged before the first step.

use crate::body::path;
use crate::body::pose::Vector;
use crate::body::projectile::Body;
use crate::body::shape::Solid;
use crate::contact::edge::TOUCHING;
use crate::contact::search::Search;
use crate::ground::error::{Code, Error, finite};
use crate::ground::planes::{self, Axis};
use crate::memory::layout::Layout;
use crate::memory::model::{Model, start_motion};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::scene::parts::{Scene, StepLimits};
use crate::sheet::places::Places;
use crate::sheet::ring::Hoop;
use crate::sheet::step_limit::LOOKED_AT;
use crate::sheet::weave::{self, in_runs};
use crate::step::energy;
use crate::step::one_step;
use crate::sweep::forces;
use crate::yarn::law::twice_strain_at;

/// Largest stretch that a segment may be given beforehand; its square is far from overflow.
pub(crate) const LARGEST_STRETCH: f64 = 1e100;
/// Largest displacement, in spacings, and velocity, in spacings a step, that a sheet may be given: its energy
/// is a number then. The first step may find it lost (see [`crate::yarn::law::LOST`]).
const LARGEST_GIVEN_MOTION: f64 = 1e30;

impl Scene {
    /// Refuses in a bounded time, some milliseconds, what [`Sim::new`](crate::Sim::new) refuses, but for the
    /// memory that is handed over. The answer is the same, unless more than 8192 segments are drawn or nodes
    /// lie under the projectile: only so many are looked at then, evenly spread, and what another one alone
    /// forbids is found by [`Sim::new`](crate::Sim::new).
    ///
    /// # Errors
    /// Errors of [`Sim::new`](crate::Sim::new).
    pub fn check_start(&self) -> Result<(), Error> {
        Layout::of(self)?;
        check_body(self, self.limits_of_a_sample()?, LOOKED_AT)
    }
}

/// Refuses a start of the projectile that the checks of the scene let pass. Looks for at most so many nodes
/// under the projectile.
///
/// # Errors
/// Too fast for the step, too heavy for its energy to be a number, not symmetric, or overlapping a node.
#[inline(never)]
pub(crate) fn check_body(scene: &Scene, limits: StepLimits, most: u64) -> Result<(), Error> {
    let solid = Solid::of_scene(scene);
    let body = place_body(scene, &Model::of(scene, limits, &solid), &solid)?;
    refuse_overlap(scene, &solid, &body, most)
}

/// Every how many columns, rows and plies are looked at, so that these are some `most` nodes.
fn strides(counts: [u64; 3], most: u64) -> [usize; 3] {
    let [columns, rows, plies] = counts;
    let excess = columns.saturating_mul(rows).saturating_mul(plies).div_ceil(most.max(1)).max(1);
    let along = excess.isqrt().min(columns).max(1);
    let up = excess.div_ceil(along).min(rows).max(1);
    [along, up, excess.div_ceil(along.saturating_mul(up).max(1))]
        .map(|stride| usize::try_from(stride).unwrap_or(usize::MAX))
}

/// The projectile where the scene places it, in the sheet's frame. Refuses a speed or a symmetry that does
/// not suit the scene.
pub(crate) fn place_body(scene: &Scene, model: &Model, solid: &Solid) -> Result<Body, Error> {
    let motion = path::into_sheet(&model.pose, &start_motion(scene));
    model.check_speed(&motion)?;
    let mut body = Body::of(&motion);
    if Feature::Mirrors.is_built() {
        scene.symmetry.align(solid, &mut body, scene.sheet.spacing)?;
    }
    Ok(body)
}

/// Rounding aside, a node that does more than touch is inside.
fn overlaps(scene: &Scene, gap: f64) -> bool {
    gap < -TOUCHING * scene.sheet.spacing
}

/// Refuses a start in which a node of the flat sheet lies inside the projectile; a fixed one may lie in a
/// prescribed body, with which it has no contact. Looks at the nodes in the body's box, of more than `most`
/// at some.
#[inline(never)]
fn refuse_overlap(scene: &Scene, solid: &Solid, body: &Body, most: u64) -> Result<(), Error> {
    let h_y = scene.spacing(Axis::Vertical);
    let places = Places::both(scene);
    let search = Search::new(solid, body, scene.sheet.spacing, scene.largest_spacing());
    let (movable, [columns, rows, plies]) = (scene.is_free(), search.box_at_rest(scene, &places));
    let (columns, plies) = if Feature::Curved.is_in(scene) {
        (0..places[0].nodes() as usize, 0..scene.stack.plies as usize)
    } else {
        (columns, plies)
    };
    let [along, up, through] = strides([&columns, &rows, &plies].map(|range| range.len() as u64), most);
    for j in rows.step_by(up.max(1)) {
        let y = places[1].offset(j) * h_y;
        let [[a, b], [c, d]] = if movable { [[0; 2]; 2] } else { weave::runs_among(scene, &places, j) };
        for i in columns.clone().step_by(along.max(1)).filter(|&i| movable || !in_runs(&[a, b, c, d], i)) {
            for ply in plies.clone().step_by(through.max(1)) {
                let [x, z] = place_at_rest(scene, &places[0], i, ply);
                let gap = search.gap(&Vector::new(x, y, z));
                if overlaps(scene, gap) {
                    return Err(Error::new(Code::InitialOverlap, "projectile.position", gap, 0.0));
                }
            }
        }
    }
    Ok(())
}

/// Where a column of a ply rests along x and z, m.
#[inline(never)] // Off the stack of its caller.
fn place_at_rest(scene: &Scene, columns: &Places, i: usize, ply: usize) -> [f64; 2] {
    let (h, off) = (scene.sheet.spacing, ply as f64 * scene.ply_gap());
    let Some(hoop) = Hoop::of(scene) else { return [columns.offset(i) * h, off] };
    hoop.place(i).map(|place| place * (h * (1.0 + off / scene.sheet.radius)))
}

/// See [`Sim::set_motion`](crate::Sim::set_motion).
pub(crate) fn set_motion(system: &mut System<'_>, positions: &[f64], velocities: &[f64]) -> Result<(), Error> {
    refuse_if_started(system)?;
    check_numbers("positions", positions, 3 * system.network.layout.nodes())?;
    check_numbers("velocities", velocities, 3 * system.network.layout.nodes())?;
    let (points, _) = positions.as_chunks::<3>();
    let (speeds, _) = velocities.as_chunks::<3>();
    let (h, margin) = (system.network.scene.sheet.spacing, system.network.scene.largest_spacing());
    let search = Search::new(&system.solid, &system.state.body, h, margin);
    for (k, (point, velocity)) in points.iter().zip(speeds).enumerate() {
        let (i, j) = system.network.layout.column_and_row(k);
        let fixed = system.network.is_fixed(i, j);
        if let Some(&moves) = velocity.iter().find(|&&v| fixed && v != 0.0) {
            return Err(Error::new(Code::OutOfRange, "velocities", moves, 0.0));
        }
        let x = Vector::from(system.network.model.pose.point_in(*point));
        let meets = !fixed || system.network.scene.is_free();
        let near = if meets { search.candidate(&x) } else { None };
        if let Some((gap, _, _)) = near.filter(|(gap, _, _)| overlaps(&system.network.scene, *gap)) {
            return Err(Error::new(Code::InitialOverlap, "positions", gap, 0.0));
        }
        let v = Vector::from(system.network.model.pose.vector_in(*velocity));
        let units =
            [("positions", x, system.network.scene.sheet.spacing), ("velocities", v, system.network.model.unit_speed)];
        for (field, vector, unit) in units {
            let limit = LARGEST_GIVEN_MOTION * unit;
            if let Some(&beyond) = vector.iter().find(|&component| !(-limit..=limit).contains(component)) {
                return Err(Error::new(Code::OutOfRange, field, beyond, limit));
            }
            if let Some(off) = leaves_plane(system, i, j, &vector, unit) {
                return Err(Error::new(Code::NotSymmetric, field, off, 0.0));
            }
        }
    }
    let nodes_of_ply = system.network.layout.nodes_x * system.network.layout.y.modelled();
    let height = |k: usize, point: &[f64; 3]| {
        let [_, _, height] = system
            .network
            .column_axes(system.network.layout.column_and_row(k).0, system.network.model.pose.point_in(*point));
        height
    };
    for (k, (below, above)) in points.iter().zip(points.iter().skip(nodes_of_ply)).enumerate() {
        // Rounding aside, a node lies a thickness or more above the one that it faces below.
        let gap = height(k, above) - height(k, below) - system.network.scene.thickness();
        if system.network.layout.is_stack() && overlaps(&system.network.scene, gap) {
            return Err(Error::new(Code::PliesOverlap, "positions", gap, 0.0));
        }
    }
    for (k, (point, velocity)) in points.iter().zip(speeds).enumerate() {
        let (i, j) = system.network.layout.column_and_row(k);
        let x = system.network.model.pose.point_in(*point);
        let v = system.network.model.pose.vector_in(*velocity);
        let rest = system.network.rest(i, j);
        let mut u = [x[0] / h - rest[0], x[1] / h - rest[1], x[2] / h - rest[2]];
        let mut v = v.map(|v| v / system.network.model.unit_speed);
        for (axis, on_plane) in on_planes(system, i, j).into_iter().enumerate() {
            if on_plane {
                (u[axis], v[axis]) = (0.0, 0.0);
            }
        }
        system.network.set_node(i, j, u, v);
    }
    system.state.sums.loaded = 1;
    system.rebuild_derived();
    one_step::start_forces(&mut system.network);
    // The explicit scheme stores the velocity at t_{-1/2}: back by half a step with the forces at t_0.
    if !system.network.layout.has(Feature::Theta) {
        for (i, j) in system.network.nodes() {
            if !system.network.is_fixed(i, j) {
                let (u, v) = system.network.node(i, j);
                let a = forces::acceleration(&system.network, system.state.sums.loaded, false, i, j);
                system.network.set_node(i, j, u, [v[0] - 0.5 * a[0], v[1] - 0.5 * a[1], v[2] - 0.5 * a[2]]);
            }
        }
    }
    energy::start_audit(&mut system.network, &mut system.state);
    Ok(())
}

/// See [`Sim::set_largest_stretch`](crate::Sim::set_largest_stretch).
pub(crate) fn set_largest_stretch(system: &mut System<'_>, stretches: &[f64]) -> Result<(), Error> {
    refuse_if_started(system)?;
    check_numbers("stretches", stretches, system.network.layout.segments())?;
    if let Some(&below) = stretches.iter().find(|&&x| x < 0.0) {
        return Err(Error::new(Code::OutOfRange, "stretches", below, 0.0));
    }
    if let Some(&above) = stretches.iter().find(|&&x| x > LARGEST_STRETCH) {
        return Err(Error::new(Code::OutOfRange, "stretches", above, LARGEST_STRETCH));
    }
    let (mut stretches, layout) = (stretches.iter(), system.network.layout);
    layout.for_each_segment(|axis, i, j| {
        let q = twice_strain_at(stretches.next().copied().unwrap_or(0.0));
        let strength = planes::row(system.network.arrays.rows.strength, layout.chunks, j);
        let whole = planes::get(strength, axis as usize, i).map(twice_strain_at);
        let critical = whole.unwrap_or(system.network.direction(axis, j).critical);
        let history = planes::row_mut(system.network.arrays.rows.history, layout.chunks, j);
        planes::set(history, axis as usize, i, if q > critical { q } else { whole.unwrap_or(0.0) });
    });
    system.rebuild_derived();
    one_step::start_forces(&mut system.network);
    energy::start_audit(&mut system.network, &mut system.state);
    Ok(())
}

/// Refuses an array that has not as many numbers as are needed.
pub(crate) fn check_length(field: &'static str, values: &[f64], needed: usize) -> Result<(), Error> {
    let found = values.len();
    if found == needed { Ok(()) } else { Err(Error::new(Code::WrongLength, field, found as f64, needed as f64)) }
}

/// Refuses an array of another length, or with a number that is not finite.
fn check_numbers(field: &'static str, values: &[f64], needed: usize) -> Result<(), Error> {
    check_length(field, values, needed)?;
    values.iter().try_for_each(|&x| finite(field, x))
}

/// Whether a node lies on the mirror planes x = 0 and y = 0.
fn on_planes(system: &System<'_>, i: usize, j: usize) -> [bool; 2] {
    [(system.network.layout.x, i), (system.network.layout.y, j)]
        .map(|(line, i)| line.is_mirrored() && line.node_weight(i) == 1.0)
}

/// The component of a position, m, or velocity, m/s, that takes a node off a mirror plane, beyond rounding of
/// its unit.
fn leaves_plane(system: &System<'_>, i: usize, j: usize, vector: &Vector, unit: f64) -> Option<f64> {
    let small = |value: f64| value <= 1e-9 * unit && value >= -1e-9 * unit;
    let across = vector.iter().zip(on_planes(system, i, j));
    across.filter(|(_, on_plane)| *on_plane).map(|(component, _)| *component).find(|&component| !small(component))
}

fn refuse_if_started(system: &System<'_>) -> Result<(), Error> {
    system.sound()?;
    if system.state.step == 0 { Ok(()) } else { Err(Error::plain(Code::AlreadyStarted, "")) }
}
