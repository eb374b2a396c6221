//! Outcomes: arrested, detached, exited, passed, through, rebounded. They latch with their step and are never
//! acted upon: the physics goes on.
//!
//! Method: tested when the step count is a multiple of 64; *attachment_failed* is latched by `explicit.rs` at
//! the end of a force window. All others but "passed" need a first contact.
//! Nodes joined to a support are found by joining nodes over live segments into components (union by smaller
//! number). "Detached" asks whether any node touched in the last 64 steps is joined to a support. "Exited"
//! asks what can still act on the body: the held part of the sheet must lie behind or beside its flight, and
//! loose pieces in its way must move with it. "Through" asks whether what has slowed the body lately, over
//! the rest of its way past the held yarn, is little against its energy. All but "detached" are judged along
//! one normal of the sheet, from the side of the body to the other ([`Course`]): the same end of contact is
//! "exited" for a body that moves along it, and "rebounded" for one that does not. Held yarn of a curved
//! sheet swings back along the radius.
//! Limits: the body is taken to fly on straight (under its present load), and so are the nodes. A body that
//! comes to a ring from outside has exited once it is within and clear of that half of the wall, or beyond
//! the other half. Without `track_detachment` nothing is known to be loose once a segment has failed: then no
//! node at all may be in the way.
//! Reference: docs/model.md, "Outcomes"; R. E. Tarjan, J. ACM 22 (1975) 215 (disjoint sets).

use crate::body::pose::{Vector, into_body};
use crate::ground::lanes::CacheLine;
use crate::ground::math;
use crate::ground::planes::{self, Axis, CHUNK, Chunk, HOT_PLANES, STIFFNESS};
use crate::memory::arrays::{Arrays, RowArrays};
use crate::memory::system::System;
use crate::memory::watch::Outcome;
use crate::scene::features::Feature;
use crate::scene::parts::AttachmentKind;
use crate::sheet::clamp::has_let_go;
use crate::sheet::ring::{self, Hoop, from_axis};

/// Steps between two tests.
pub const TEST_INTERVAL: u64 = 64;
/// "Exited" beside loose pieces: over a travel of R the work may change by this part of it or, if that is
/// more, by what one node takes that the body meets at its present speed; and what the pieces can still take
/// may be four times as much.
pub const SETTLED_PART: f64 = 0.0025;
/// "Through": the body's energy must be so many times what the held yarn ahead would take if it went on to
/// resist as lately. Chosen, with the other numbers of [`is_through`], on 1,160 shots, and checked on others:
/// docs/tables/through.md.
const THROUGH_MARGIN: f64 = 3.0;
/// Least travel between two tests of "through", in spacings and in R: over less, resistance is that of single
/// nodes. Chosen as [`THROUGH_MARGIN`].
const TRAVEL: [f64; 2] = [0.5, 1.0 / 16.0];
/// Travel at the velocity of first contact, in R, whose time is enough between two tests of "through": a torn
/// sheet swings back in it. Chosen as [`THROUGH_MARGIN`].
const SWING_BACK: f64 = 0.75;
/// Depth of held yarn in what the body sweeps, in R, from which it is in the way, and step along the body by
/// which that is searched. Chosen as [`THROUGH_MARGIN`].
const IN_THE_WAY: f64 = 0.25;
/// Work that loose pieces in the way may still exchange with a body that has exited, in units of
/// [`settling`]. See [`SETTLED_PART`].
const EXCHANGE: f64 = 4.0;

/// The body as it flies on when nothing touches it.
struct Flight {
    position: Vector,
    velocity: Vector,
    /// Acceleration by the present external load, m/s^2.
    acceleration: Vector,
    /// Half extents along the sheet's axes as it lies now, m.
    extents: [f64; 3],
    /// Distance from the centre to the farthest surface point, m.
    reach: f64,
    /// Speed of that point by turning, m/s.
    turning: f64,
}

impl Flight {
    /// Whether the body leaves a box for good: along some axis it lies beyond it, moves away faster than
    /// anything in the box, and no load pulls it back. A body that turns faster than it moves away must lie
    /// beyond it in any orientation.
    fn leaves(&self, region: &Region) -> bool {
        [(self.extents, self.turning), ([self.reach; 3], 0.0)].iter().any(|(extents, turning)| {
            (0..3).any(|k| {
                let (x, v, a) = (self.position[k], self.velocity[k], self.acceleration[k]);
                let above = x - extents[k] > region.high[k] && v - turning > region.fastest[k] && a >= 0.0;
                let below = x + extents[k] < region.low[k] && v + turning < region.slowest[k] && a <= 0.0;
                above || below
            })
        })
    }

    /// Whether a point lies behind the whole body, in any orientation, and no load turns the body back to it.
    fn has_behind(&self, position: &Vector) -> bool {
        let behind = (position - self.position).dot(&self.velocity) < -self.reach * self.velocity.norm();
        behind && self.acceleration.dot(&self.velocity) >= 0.0
    }

    /// Whether a point lies before the body's centre.
    fn has_ahead(&self, position: &Vector) -> bool {
        (position - self.position).dot(&self.velocity) > 0.0
    }

    /// Whether a node that flies on straight never comes within the body's reach.
    fn misses(&self, position: &Vector, velocity: &Vector) -> bool {
        let (r, v) = (position - self.position, velocity - self.velocity);
        let (x, u) = ((*position).into(), (*velocity).into());
        // A load that drives the two further apart all the time leaves the straight flight as the nearer one.
        if r.dot(&self.acceleration) > 0.0 || v.dot(&self.acceleration) > 0.0 {
            return self.leaves(&Region { low: x, high: x, slowest: u, fastest: u });
        }
        let (distance2, reach2, approach) = (r.norm_squared(), self.reach * self.reach, -r.dot(&v));
        // The least squared distance is r^2 - (r.v)^2/v^2.
        distance2 > reach2 && (approach <= 0.0 || (distance2 - reach2) * v.norm_squared() > approach * approach)
    }
}

/// A box about nodes, m, and the range of their velocities, m/s.
#[derive(Clone, Copy)]
struct Region {
    low: [f64; 3],
    high: [f64; 3],
    slowest: [f64; 3],
    fastest: [f64; 3],
}

impl Region {
    const EMPTY: Region = Region { low: [f64::MAX; 3], high: [f64::MIN; 3], slowest: [0.0; 3], fastest: [0.0; 3] };

    fn include(&mut self, x: &Vector) {
        for k in 0..3 {
            self.low[k] = math::min(x[k], self.low[k]);
            self.high[k] = math::max(x[k], self.high[k]);
        }
    }

    fn include_velocity(&mut self, v: &Vector) {
        for k in 0..3 {
            self.slowest[k] = math::min(v[k], self.slowest[k]);
            self.fastest[k] = math::max(v[k], self.fastest[k]);
        }
    }

    /// The box with its mirror images about the planes across axis k, from that at 0 to that at `last`.
    fn mirror(&mut self, k: usize, last: f64) {
        let beyond = self.high[k] - last;
        let far = math::max(-self.low[k], beyond);
        (self.low[k], self.high[k]) = (-far, last + far);
    }
}

/// Connected components of the sheet, for one query.
pub(crate) struct Pieces {
    /// Number of the piece that holds the supports.
    support: Option<usize>,
    /// Whether every node is labelled with the number of its piece.
    labelled: bool,
    /// Without labels: whether the sheet, one piece, counts as held.
    held: bool,
}

impl Pieces {
    /// Whether a piece is joined to a support.
    pub(crate) fn hold(&self, piece: usize) -> bool {
        if self.labelled { self.support == Some(piece) } else { self.held }
    }
}

/// State of the loose pieces near the body's way.
struct Loose {
    /// Some may meet the body: they are flagged.
    in_the_way: bool,
    /// Pieces ahead are on average no faster than the body.
    are_overtaken: bool,
    /// Pieces behind are on average no slower.
    pursue: bool,
}

/// Sums of weights and of weighted numbers over nodes.
struct WeightedSum {
    weight: f64,
    sum: f64,
}

impl WeightedSum {
    const NOTHING: WeightedSum = WeightedSum { weight: 0.0, sum: 0.0 };

    fn add(&mut self, weight: f64, number: f64) {
        self.weight += weight;
        self.sum += weight * number;
    }
}

/// Tests every outcome that has not latched. Called every 64 steps.
pub(crate) fn test_outcomes(system: &mut System<'_>) {
    let (step, work, velocity) = (system.state.step, system.state.sums.work, system.state.body.velocity);
    if system.state.watch.first.is_none() {
        if !system.state.watch.has(Outcome::Passed) && has_passed(system) {
            system.state.watch.latch(Outcome::Passed, step, work);
        }
    } else {
        if !system.state.watch.has(Outcome::Detached) && contact_is_detached(system) {
            system.state.watch.latch(Outcome::Detached, step, work);
        }
        let course = course(system);
        if system.layout.has(Feature::Through)
            && !system.state.watch.has(Outcome::Through)
            && is_through(system, &course)
        {
            system.state.watch.latch(Outcome::Through, step, work);
        }
        let settled = pass_checkpoint(system);
        let goes_on = velocity.dot(&course.normal) > 0.0;
        if course.direction == Vector::zeros() {
            // At rest since before the first contact: nothing has been stopped.
        } else if !goes_on && (course.within_ring || velocity.dot(&course.direction) <= 0.0) {
            system.state.watch.latch(Outcome::Arrested, step, work);
        }
        let crosses = goes_on || course.around.is_some_and(|radius| has_crossed(system, &course, radius));
        let end = if crosses { Outcome::Exited } else { Outcome::Rebounded };
        if !system.state.watch.has(end)
            && course.direction != Vector::zeros()
            && contact_is_over(system, &course, settled)
        {
            system.state.watch.latch(end, step, work);
        }
    }
    system.arrays.flags.fill(0);
}

/// Directions in the sheet's frame by which an outcome is judged.
struct Course {
    /// Unit direction of the velocity just before the first contact; zero as long as a body at rest has none.
    direction: Vector,
    /// Unit normal of the sheet at rest where the body is now, from the side from which it came to the other.
    /// The direction of flight where the sheet has no sides: for a body that hits the edge of a flat sheet in
    /// its plane, or on the axis of a ring.
    normal: Vector,
    /// The body came from inside of a curved sheet's circle.
    within_ring: bool,
    /// The circle's radius, m, if the body came from outside of it.
    around: Option<f64>,
}

/// Part of the contact impulse that is along z at least if a body hits a face of a flat sheet, not its edge;
/// and part of its velocity before first contact at least by which the side is known from which it came.
const FACE_HIT: f64 = 0.1;

/// The course of a body that has been in contact.
fn course(system: &mut System<'_>) -> Course {
    let velocity = system.state.body.velocity;
    let direction = system.state.watch.direction(&velocity);
    let impulse = system.state.sums.impulse;
    let mut course = Course { direction, normal: direction, within_ring: false, around: None };
    if let Some(hoop) = Hoop::of(&system.scene) {
        let start = start_in_sheet(system);
        let radius = hoop.radius * system.scene.sheet.spacing;
        course.within_ring = from_axis(&start.into()).norm() < radius;
        course.around = (!course.within_ring).then_some(radius);
        let outwards = from_axis(&system.state.body.position);
        let distance = outwards.norm();
        if distance > 0.0 {
            course.normal = if course.within_ring { outwards } else { -outwards } / distance;
        }
    } else if math::abs(impulse.z) > FACE_HIT * impulse.norm() {
        // A body in the plane of the sheet has been pushed to the side from which it came; another one may
        // have hit a held edge since.
        let across = if math::abs(direction.z) > FACE_HIT { direction.z } else { -impulse.z };
        course.normal = Vector::new(0.0, 0.0, if across > 0.0 { 1.0 } else { -1.0 });
    }
    course
}

/// Where the body started, in the sheet's frame, m.
fn start_in_sheet(system: &System<'_>) -> [f64; 3] {
    system.model.pose.point_in(system.scene.projectile.position)
}

/// Whether a body that leaves a circle outwards has come through it: straight back along its flight it leaves
/// the circle in the half that is across from where it entered.
fn has_crossed(system: &System<'_>, course: &Course, radius: f64) -> bool {
    let (x, v) = (from_axis(&system.state.body.position), from_axis(&system.state.body.velocity));
    let (product, square) = (x.dot(&v), v.norm_squared());
    let root = product * product - square * (x.norm_squared() - radius * radius);
    root > 0.0 && (x * square - v * (product - math::sqrt(root))).dot(&course.direction) > 0.0
}

/// At the end of a forward travel of R: whether the work has settled since its start. None elsewhere.
fn pass_checkpoint(system: &mut System<'_>) -> Option<bool> {
    let settling = settling(system);
    let (watch, sums, position) = (&mut system.state.watch, &system.state.sums, system.state.body.position);
    let travel = (position - watch.checkpoint).dot(&watch.first?.direction);
    if travel < system.solid.radius() {
        return None;
    }
    let change = sums.work - watch.checkpoint_work;
    let settled = math::abs(change) <= settling;
    watch.checkpoint = position;
    watch.checkpoint_work = sums.work;
    watch.checkpoint_impulses = sums.impulses;
    Some(settled)
}

/// Whether nothing that could act on the body is in its way, or only loose pieces that take no more.
fn contact_is_over(system: &mut System<'_>, course: &Course, settled: Option<bool>) -> bool {
    let beside_debris = settled == Some(true);
    // Without a node at the body the end of the travel need not be awaited.
    (beside_debris || system.state.sums.contacts == 0) && way_is_clear(system, course, beside_debris)
}

/// Whether held yarn will not stop the body any more. Asked when it has moved on by half a spacing and by
/// R/16, or for the time in which it moved by 3/4 R before the first contact: long enough for the torn sheet
/// to swing back. What it has lost since, taken over the way to go, must be small against the energy of its
/// motion along the normal, and it must not fly mainly sideways, where it meets yarn beside its way.
fn is_through(system: &mut System<'_>, course: &Course) -> bool {
    let (body, normal) = (system.state.body, &course.normal);
    let (place, speed) = (body.position.dot(normal), body.velocity.dot(normal));
    let forward = 2.0 * speed > body.velocity.norm() && system.state.force.dot(normal) >= 0.0;
    let whole = system.failed_segments == 0;
    let (watch, radius) = (&mut system.state.watch, system.solid.radius());
    let (travel, mean_speed) = (place - watch.travel_start, 0.5 * (watch.travel_speed + speed));
    let energy = watch.first.map_or(0.0, |first| first.kinetic_energy);
    let first_speed = math::sqrt(2.0 * energy * system.model.inertia.inverse_mass);
    let is_near = travel < math::max(TRAVEL[0] * system.scene.sheet.spacing, TRAVEL[1] * radius);
    if !whole && is_near && travel * first_speed < SWING_BACK * radius * mean_speed {
        return false;
    }
    let lost = math::max(watch.travel_speed * watch.travel_speed - speed * speed, 0.0);
    (watch.travel_start, watch.travel_speed) = (place, speed);
    let held = system.scene.attachment.kind != AttachmentKind::Free;
    if whole || !(forward && held && system.scene.is_free()) {
        return false;
    }
    let Some(ahead) = way_past_held(system, normal) else { return false };
    // A body that is no sphere may turn an edge into what is ahead.
    let (turns, reach) = (system.solid.feels_torque(), system.solid.reach());
    let way = if turns { reach } else { ahead };
    !(turns && ahead > 0.0) && speed * speed * travel > THROUGH_MARGIN * lost * way
}

/// Distance ahead of the body's centre along the normal, m, of held yarn that it may still touch; 0 if there
/// is none. None if some is in its way, deeper within what the body sweeps by moving on than R/4; or if the
/// body may turn an edge into some, because it turns faster than it moves on.
fn way_past_held(system: &mut System<'_>, normal: &Vector) -> Option<f64> {
    let pieces = pieces(system);
    let (body, solid) = (&system.state.body, &system.solid);
    let (margin, reach, mut way) = (IN_THE_WAY * solid.radius(), solid.reach(), 0.0);
    let speed = body.velocity.norm();
    let direction = if speed > 0.0 { body.velocity / speed } else { *normal };
    // Yarn behind the centre can push a convex body only on, unless it rubs.
    let rubs = system.layout.has(Feature::Friction);
    let tumbles = (solid.feels_torque() || rubs) && body.angular_velocity.norm() * reach > body.velocity.dot(normal);
    let nearest = if tumbles || rubs { -reach } else { 0.0 };
    for (i, j) in system.nodes() {
        let from_centre = system.position(i, j) - body.position;
        let ahead = from_centre.dot(&direction);
        let beside = from_centre - direction * ahead;
        let apart = ahead <= nearest || beside.norm() > reach + margin;
        if apart || !pieces.hold(piece(system, &pieces, i, j)) {
            continue;
        }
        if tumbles {
            return None;
        }
        // Of what of the body lies behind the node, by steps of R/4, in which the gap changes by no more than
        // that.
        let (mut along, mut gap) = (-reach, f64::MAX);
        while along <= math::min(ahead, reach) {
            let place = into_body(&body.orientation, &(beside + direction * along));
            gap = math::min(solid.gap(&place).distance, gap);
            along += margin;
        }
        if gap < -margin {
            return None;
        }
        way = if gap < margin { math::max(from_centre.dot(normal) - nearest, way) } else { way };
    }
    Some(way)
}

/// The body has missed the sheet and is on its other side, or will be where it flies.
fn has_passed(system: &System<'_>) -> bool {
    let start = start_in_sheet(system);
    let [x, y] = system.scene.half_size();
    let (mut low, mut high) = ([-x, -y, 0.0], [x, y, system.scene.stack_height()]);
    let is_curved = system.layout.has(Feature::Curved);
    if is_curved {
        let counts = [system.layout.chunks, system.layout.nodes_x];
        [[low[0], low[2]], [high[0], high[2]]] =
            ring::box_at_rest(system.arrays.columns, counts, system.scene.sheet.spacing);
    }
    let flight = flight(system);
    if !system.scene.is_free() {
        // Only its host knows how it goes on; that it has got past the sheet's box is a fact.
        let axes = if is_curved { 0..3 } else { 2..3 };
        return axes.into_iter().any(|k| {
            let (from, x, extent) = (start[k], flight.position[k], flight.extents[k]);
            (from < low[k] && x > high[k] + extent) || (from > high[k] && x < low[k] - extent)
        });
    }
    let mut region = Region { low, high, ..Region::EMPTY };
    for j in (0..system.layout.plies).flat_map(|ply| system.awake_of(ply)[0]..system.awake_of(ply)[1]) {
        for i in 0..system.layout.nodes_x {
            // A sheet set in motion by the host may be faster than the body.
            region.include(&system.position(i, j));
            region.include_velocity(&system.velocity(i, j));
        }
    }
    add_images(system, &mut region);
    // A flat sheet divides space: a body that leaves it on its own side has not passed it.
    let back = flight.velocity.z
        * (if start[2] < low[2] {
            1.0
        } else if start[2] > high[2] {
            -1.0
        } else {
            0.0
        })
        < 0.0;
    let returns = back && !is_curved;
    !returns && flight.leaves(&region)
}

/// Adds what mirror planes leave out of a box, and where a held sheet swings back to.
fn add_images(system: &System<'_>, region: &mut Region) {
    let symmetry = system.scene.symmetry;
    // Of a curved sheet the nodes themselves have been mirrored.
    let swings = system.scene.attachment.kind != AttachmentKind::Free && !system.layout.has(Feature::Curved);
    for (k, mirrored) in [symmetry.mirror_x, symmetry.mirror_y, swings].into_iter().enumerate() {
        if mirrored {
            region.mirror(k, if k == 2 { system.scene.stack_height() } else { 0.0 });
        }
    }
}

fn flight(system: &System<'_>) -> Flight {
    let (body, solid) = (&system.state.body, &system.solid);
    let free = system.scene.is_free();
    Flight {
        position: body.position,
        velocity: body.velocity,
        acceleration: if free { system.state.force * system.model.inertia.inverse_mass } else { Vector::zeros() },
        extents: solid.half_extents(&body.orientation),
        reach: solid.reach(),
        turning: if solid.feels_torque() { body.angular_velocity.norm() * solid.reach() } else { 0.0 },
    }
}

/// Whether nothing of the sheet will act on the body any more if it flies on as it does. `beside_debris`:
/// loose pieces in its way are allowed if they have next to nothing to exchange with it.
fn way_is_clear(system: &mut System<'_>, course: &Course, beside_debris: bool) -> bool {
    let flight = flight(system);
    if course.around.is_none() && whole_yarn_is_in_the_way(system, &flight) {
        return false;
    }
    let pieces = pieces(system);
    if !held_is_clear(system, &pieces, &flight, course) {
        return false;
    }
    let loose = loose_pieces(system, &pieces, &flight);
    if loose.pursue {
        return false;
    }
    if !loose.in_the_way && !loose.are_overtaken {
        return true;
    }
    beside_debris && exchange(system, &pieces, &flight, &loose) <= EXCHANGE * settling(system)
}

/// Held part of the sheet, as far as it has been looked at.
struct Held {
    /// The box about it.
    region: Region,
    /// Whether all of it lies behind the body and stays there; true of nothing.
    behind: bool,
}

impl Held {
    const NOTHING: Held = Held { region: Region::EMPTY, behind: true };

    fn include(&mut self, system: &System<'_>, flight: &Flight, i: usize, j: usize) {
        let x = system.position(i, j);
        self.region.include(&x);
        if system.layout.has(Feature::Curved) {
            self.region.include(&swung_back(system, i, j));
        }
        if system.scene.attachment.kind == AttachmentKind::Free {
            self.region.include_velocity(&system.velocity(i, j));
        }
        self.behind = self.behind && !flight.has_ahead(&x) && flight.misses(&x, &system.velocity(i, j));
    }

    /// Whether the held part lies behind the body and stays there, or the body leaves the box about it for
    /// good. A part that is not clear stays so, whatever is included.
    fn is_clear(&self, system: &System<'_>, flight: &Flight) -> bool {
        if self.behind {
            return true;
        }
        let mut region = self.region;
        add_images(system, &mut region);
        flight.leaves(&region)
    }
}

/// Where a node of a curved sheet is that has swung back through its circle.
fn swung_back(system: &System<'_>, i: usize, j: usize) -> Vector {
    let (x, deflection) = (system.position(i, j), system.deflection(i, j) * system.scene.sheet.spacing);
    let outwards = from_axis(&x);
    x - outwards * (2.0 * deflection / math::max(outwards.norm(), f64::MIN_POSITIVE))
}

/// Whether all that is held is clear of the body: of a ring that it enters from outside, of the half which it
/// meets first.
fn held_is_clear(system: &System<'_>, pieces: &Pieces, flight: &Flight, course: &Course) -> bool {
    let mut held = Held::NOTHING;
    let enters = course.around.is_some() && flight.velocity.dot(&course.normal) > 0.0;
    rows_from(system, flight).all(|j| {
        for i in (0..system.layout.nodes_x).filter(|&i| pieces.hold(piece(system, pieces, i, j))) {
            if !(enters && from_axis(&system.position(i, j)).dot(&course.direction) > 0.0) {
                held.include(system, flight, i, j);
            }
        }
        held.is_clear(system, flight)
    })
}

/// Whether yarn along x near the body that is whole from a fixed node on, and so is held, is not clear of it:
/// the usual case while the body is in the sheet, found without joining nodes.
fn whole_yarn_is_in_the_way(system: &System<'_>, flight: &Flight) -> bool {
    let mut held = Held::NOTHING;
    if system.layout.has(Feature::Clamps) {
        return false; // A run of held nodes may have gaps.
    }
    // Farther away whole yarn is seldom in the way, and looking at it would take as long as joining all
    // nodes.
    let near = |j: &usize| distance(system, flight, *j) <= 2.0 * flight.reach;
    rows_from(system, flight).take_while(near).any(|j| {
        let live = |i: usize| is_live(system, Axis::Horizontal, i, j);
        let [_, left_end, right, right_end] =
            system.arrays.rows.runs.get(j).map_or([0; 4], |run| run.map(|i| i as usize));
        let mut whole = left_end;
        while left_end > 0 && whole < system.layout.nodes_x && live(whole - 1) {
            held.include(system, flight, whole, j);
            whole += 1;
        }
        for i in (whole..right).rev().take_while(|&i| right < right_end && live(i)) {
            held.include(system, flight, i, j);
        }
        !held.is_clear(system, flight)
    })
}

/// All rows, those at rest nearest to the body first, from either side in turn: what is in its way is most
/// likely there.
fn rows_from(system: &System<'_>, flight: &Flight) -> impl Iterator<Item = usize> + use<> {
    let rows = system.layout.nodes_y;
    let by_distance = |a: &usize, b: &usize| distance(system, flight, *a).total_cmp(&distance(system, flight, *b));
    let nearest = (0..rows).min_by(by_distance).unwrap_or(0);
    let both = (0..rows).flat_map(move |d| [nearest.checked_add(d), nearest.checked_sub(d + 1)]);
    both.flatten().filter(move |&j| j < rows)
}

/// Distance of a row at rest from the body's centre along y, m.
fn distance(system: &System<'_>, flight: &Flight, j: usize) -> f64 {
    math::abs(system.rest(0, j)[1] * system.scene.sheet.spacing - flight.position[1])
}

/// Looks for loose pieces in the body's way and flags them.
fn loose_pieces(system: &mut System<'_>, pieces: &Pieces, flight: &Flight) -> Loose {
    system.arrays.flags.fill(0);
    let (mut ahead, mut behind, mut in_the_way) = (WeightedSum::NOTHING, WeightedSum::NOTHING, false);
    for (i, j) in system.nodes() {
        let piece = piece(system, pieces, i, j);
        if pieces.hold(piece) {
            continue;
        }
        let (x, v) = (system.position(i, j), system.velocity(i, j));
        let (node_ahead, node_behind) = (flight.has_ahead(&x), flight.has_behind(&x));
        let piece_ahead = lies_ahead(system, piece, flight);
        let weight = system.share(i, j);
        if piece_ahead && !is_alone(system, i, j) {
            ahead.add(weight, v.dot(&flight.velocity));
        }
        if node_behind {
            behind.add(weight, v.dot(&flight.velocity));
        }
        if node_ahead != piece_ahead || !(node_behind || flight.misses(&x, &v)) {
            in_the_way = true;
            system.set_flag(piece);
        }
    }
    let own = flight.velocity.norm_squared();
    Loose {
        in_the_way,
        are_overtaken: ahead.weight > 0.0 && ahead.sum <= ahead.weight * own,
        pursue: behind.weight > 0.0 && behind.sum >= behind.weight * own,
    }
}

/// Largest change of the work by the loose pieces in the way, J: V sqrt(2 m E) with their mass m and their
/// kinetic energy E seen from the body.
fn exchange(system: &System<'_>, pieces: &Pieces, flight: &Flight, loose: &Loose) -> f64 {
    let (mut mass, mut energy) = (0.0, 0.0);
    for (i, j) in system.nodes() {
        let piece = piece(system, pieces, i, j);
        let overtaken = || {
            loose.are_overtaken && lies_ahead(system, piece, flight) && !pieces.hold(piece) && !is_alone(system, i, j)
        };
        if system.has_flag(piece) || overtaken() {
            let node_mass = system.share(i, j) * (system.model.node_mass * system.mass_share_of_row(j));
            mass += node_mass;
            energy += 0.5 * node_mass * (system.velocity(i, j) - flight.velocity).norm_squared();
        }
    }
    flight.velocity.norm() * math::sqrt(2.0 * mass * energy)
}

/// Whether a piece, by the node with its smallest number, lies before the body's centre.
fn lies_ahead(system: &System<'_>, piece: usize, flight: &Flight) -> bool {
    let (i, j) = system.layout.column_and_row(piece);
    flight.has_ahead(&system.position(i, j))
}

/// Finds what hangs together. Before the first failure all nodes are one piece; later, without labels, none
/// is known to be loose.
pub(crate) fn pieces(system: &mut System<'_>) -> Pieces {
    let several = system.failed_segments > 0 || system.layout.is_stack();
    let labelled = several && system.layout.has(Feature::Detachment);
    let support = if labelled { join_nodes(system) } else { None };
    let held = system.scene.attachment.kind != AttachmentKind::Free || !system.layout.has(Feature::Detachment);
    Pieces { support, labelled, held }
}

/// The number of the piece that a node belongs to.
pub(crate) fn piece(system: &System<'_>, pieces: &Pieces, i: usize, j: usize) -> usize {
    let label = CacheLine::words_of(system.arrays.shared).get(j * system.layout.nodes_x + i);
    label.filter(|_| pieces.labelled).map_or(0, |&label| label as usize)
}

/// Whether no live segment ends at a node: then it flies straight.
fn is_alone(system: &System<'_>, i: usize, j: usize) -> bool {
    let before = |axis: Axis, i: Option<usize>, j: Option<usize>| match (i, j) {
        (Some(i), Some(j)) => is_live(system, axis, i, j),
        _ => false,
    };
    !(is_live(system, Axis::Horizontal, i, j)
        || before(Axis::Horizontal, system.layout.x.before(i), Some(j))
        || is_live(system, Axis::Vertical, i, j)
        || before(Axis::Vertical, Some(i), j.checked_sub(1)))
}

/// Whether the segment that starts at node (i, j) has not failed.
fn is_live(system: &System<'_>, axis: Axis, i: usize, j: usize) -> bool {
    is_live_in(planes::row(system.arrays.rows.hot, system.layout.chunks, j), axis, i)
}

/// [`is_live`] of the segment that starts at column i of a row.
fn is_live_in(row: &[Chunk<HOT_PLANES>], axis: Axis, i: usize) -> bool {
    planes::get(row, STIFFNESS + axis as usize, i).is_some_and(|stiffness| stiffness > 0.0)
}

/// Whether some node was touched since the last test, some node is fixed, and no live path joins any two of
/// them.
fn contact_is_detached(system: &mut System<'_>) -> bool {
    let can_be = system.layout.has(Feature::Detachment) && system.scene.attachment.kind != AttachmentKind::Free;
    let watched = can_be && system.failed_segments > 0;
    if !watched || system.arrays.flags.iter().all(|&f| f == 0) || held_by_a_straight_yarn(system) {
        return false;
    }
    let Some(support) = join_nodes(system) else { return false };
    let labels = CacheLine::words_of(system.arrays.shared).iter().take(system.layout.nodes());
    let mut touched = labels.enumerate().filter(|(k, _)| system.has_flag(*k));
    !touched.any(|(_, &label)| label as usize == support)
}

/// Labels every node with the smallest number of a node that live segments join it to. All fixed nodes count
/// as joined. Gives the label of the fixed nodes, if there are any.
fn join_nodes(system: &mut System<'_>) -> Option<usize> {
    let (nx, ny, chunks) = (system.layout.nodes_x, system.layout.nodes_y, system.layout.chunks);
    let grip = system.directions.grip;
    let Arrays { rows: RowArrays { hot, runs, slid, .. }, shared, .. } = &mut system.arrays;
    let mut sets = Components::new(CacheLine::words(shared).get_mut(..nx * ny).unwrap_or_default());
    join_live_segments(&mut sets, hot, chunks, [nx, ny]);
    if system.layout.x.is_closed() {
        let last = nx.saturating_sub(1);
        let joined = (0..ny).filter(|&j| is_live_in(planes::row(hot, chunks, j), Axis::Horizontal, last));
        joined.for_each(|j| sets.join(j * nx, j * nx + last));
    }
    // All fixed nodes into one component.
    let mut support = None;
    for (j, run) in runs.iter().enumerate() {
        for i in (run[0]..run[1]).chain(run[2]..run[3]).map(|i| i as usize) {
            if has_let_go(slid, j * chunks + i / CHUNK, i % CHUNK, grip) {
                continue;
            }
            let k = j * nx + i;
            match support {
                None => support = Some(k),
                Some(first) => sets.join(first, k),
            }
        }
    }
    sets.flatten();
    support.map(|k| sets.find(k))
}

/// Joins the ends of every live segment of so many nodes.
fn join_live_segments(sets: &mut Components<'_>, hot: &[Chunk<HOT_PLANES>], chunks: usize, [nx, ny]: [usize; 2]) {
    let mut below: &[Chunk<HOT_PLANES>] = &[];
    for j in 0..ny {
        let row = planes::row(hot, chunks, j);
        let mut from_below = false;
        for i in 0..nx {
            let k = j * nx + i;
            let from_left = i > 0 && is_live_in(row, Axis::Horizontal, i - 1);
            if from_left {
                sets.join(k - 1, k);
            }
            // Most often the other three sides of the cell have joined the two ends already.
            let joined = from_below && from_left && is_live_in(below, Axis::Horizontal, i - 1);
            from_below = is_live_in(below, Axis::Vertical, i);
            if from_below && !joined {
                sets.join(k - nx, k);
            }
        }
        below = row;
    }
}

/// Whether live segments run straight from a touched node to a fixed one: the usual case, found without
/// joining nodes.
fn held_by_a_straight_yarn(system: &System<'_>) -> bool {
    let (nx, ny) = (system.layout.nodes_x, system.layout.nodes_y);
    let live = |axis: Axis, i: usize, j: usize| is_live(system, axis, i, j);
    let fixed = |i: usize, j: usize| system.is_fixed(i, j);
    let held = |i: usize, j: usize| {
        // Left, right, down and up, as far as the yarn is whole.
        (0..i).rev().map_while(|i| live(Axis::Horizontal, i, j).then_some((i, j))).any(|(i, j)| fixed(i, j))
            || (i + 1..nx).map_while(|i| live(Axis::Horizontal, i - 1, j).then_some((i, j))).any(|(i, j)| fixed(i, j))
            || (0..j).rev().map_while(|j| live(Axis::Vertical, i, j).then_some((i, j))).any(|(i, j)| fixed(i, j))
            || (j + 1..ny).map_while(|j| live(Axis::Vertical, i, j - 1).then_some((i, j))).any(|(i, j)| fixed(i, j))
    };
    let words = system.arrays.flags.iter().enumerate().filter(|(_, word)| **word != 0);
    words
        .flat_map(|(w, _)| 32 * w..32 * (w + 1))
        .filter(|&k| system.has_flag(k))
        .map(|k| system.layout.column_and_row(k))
        .any(|(i, j)| held(i, j))
}

/// Largest change of the work with which it counts as final, J.
fn settling(system: &System<'_>) -> f64 {
    let part = SETTLED_PART * math::abs(system.state.sums.work);
    math::max(part, system.model.node_mass * system.state.body.velocity.norm_squared())
}

/// Disjoint sets over the nodes, in caller's memory.
pub struct Components<'a> {
    labels: &'a mut [u32],
}

impl<'a> Components<'a> {
    /// Every node by itself.
    pub fn new(labels: &'a mut [u32]) -> Components<'a> {
        for (k, label) in labels.iter_mut().enumerate() {
            *label = k as u32;
        }
        Components { labels }
    }

    /// The representative of a node's component.
    pub fn find(&mut self, node: usize) -> usize {
        let mut k = node;
        loop {
            let Some(&parent) = self.labels.get(k) else { return node };
            if parent as usize == k {
                return k;
            }
            let grandparent = self.labels.get(parent as usize).copied().unwrap_or(parent);
            if let Some(label) = self.labels.get_mut(k) {
                *label = grandparent;
            }
            k = grandparent as usize;
        }
    }

    /// Gives every node the number of its component's representative.
    pub fn flatten(&mut self) {
        // A representative has the smallest number of its component, so those before are done.
        for k in 0..self.labels.len() {
            let root = self.find(k) as u32;
            if let Some(label) = self.labels.get_mut(k) {
                *label = root;
            }
        }
    }

    /// Joins two nodes' components.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        let (small, large) = if a < b { (a, b) } else { (b, a) };
        if let Some(label) = self.labels.get_mut(large) {
            *label = small as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::ground::planes::CHUNK;
    use crate::ground::random::splitmix64;
    use crate::scene::parts::Shape;
    use crate::tests::{sheet, sim};
    use std::vec::Vec;

    #[test]
    fn the_rows_nearest_to_the_body_come_first() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.projectile.position[1] = 7.3 * scene.sheet.spacing;
        let sim = sim(&scene);
        let (system, flight) = (&sim.system, flight(&sim.system));
        let mut rows: Vec<usize> = rows_from(system, &flight).collect();
        assert_eq!(rows[..4], [59, 58, 60, 57], "the middle one is 52");
        let off = |j: usize| (system.position(0, j).y - flight.position.y).abs();
        for &j in &rows {
            assert!((distance(system, &flight, j) - off(j)).abs() < 1e-15);
        }
        rows.sort_unstable();
        assert_eq!(rows, Vec::from_iter(0..system.layout.nodes_y));
    }

    /// A body that is not clear of a part of the held sheet must not be clear of the whole.
    #[test]
    fn whole_yarn_in_the_way_is_never_clear() {
        let (mut found, mut not_found) = (0, 0);
        for (kind, seed) in
            [(AttachmentKind::TwoSides, 1), (AttachmentKind::FourSides, 2), (AttachmentKind::TwoSides, 3)]
        {
            let mut scene = sheet(41, 41);
            (scene.attachment.kind, scene.seed) = (kind, seed);
            scene.projectile.velocity[2] = 60.0;
            let mut sim = sim(&scene);
            for _ in 0..300 {
                sim.advance(TEST_INTERVAL).unwrap();
                let flight = flight(&sim.system);
                let in_the_way = whole_yarn_is_in_the_way(&sim.system, &flight);
                let pieces = pieces(&mut sim.system);
                let mut held = Held::NOTHING;
                for (i, j) in sim.system.nodes() {
                    if pieces.hold(piece(&sim.system, &pieces, i, j)) {
                        held.include(&sim.system, &flight, i, j);
                    }
                }
                let clear = held.is_clear(&sim.system, &flight);
                assert!(!(in_the_way && clear), "step {}", sim.system.state.step);
                let course = course(&mut sim.system);
                assert_eq!(held_is_clear(&sim.system, &pieces, &flight, &course), clear);
                *(if in_the_way { &mut found } else { &mut not_found }) += 1;
            }
        }
        assert!(found > 50 && not_found > 50, "{found} {not_found}");
    }

    /// A sheet at rest with a round hole of radius `hole`, and a sphere or a cylinder of that radius and
    /// length whose centre is `behind` its plane: R = 5 mm.
    fn way_through(shape: Shape, hole: f64, behind: f64) -> Option<f64> {
        let mut scene = sheet(41, 41);
        let body = &mut scene.projectile;
        (body.shape, body.radius, body.length, body.position[2]) = (shape, 5e-3, 20e-3, -10e-3);
        let mut sim = sim(&scene);
        let at = |k: usize| [k % 41, k / 41].map(|i| (i as f64 - 20.0) * scene.sheet.spacing);
        let in_hole = |k: usize| at(k).iter().map(|x| x * x).sum::<f64>() < hole * hole;
        let ends = (0..40 * 41).map(|s| (s / 40 * 41 + s % 40, 1)).chain((0..41 * 40).map(|s| (s, 41)));
        let stretch = |(k, next): (usize, usize)| if in_hole(k) || in_hole(k + next) { 1.5 } else { 1.0 };
        sim.set_largest_stretch(&ends.map(stretch).collect::<Vec<_>>()).unwrap();
        sim.system.state.body.position = Vector::new(0.0, 0.0, -behind);
        way_past_held(&mut sim.system, &Vector::new(0.0, 0.0, 1.0))
    }

    #[test]
    fn the_way_past_held_yarn_is_that_to_the_rim_of_the_hole() {
        assert_eq!(way_through(Shape::Sphere, 0.0, 2e-3), None, "a whole sheet");
        assert_eq!(way_through(Shape::Sphere, 3e-3, 2e-3), None, "a hole of 0.6 R");
        assert_eq!(way_through(Shape::Sphere, 4.5e-3, 2e-3), Some(2e-3), "a hole of 0.9 R");
        assert_eq!(way_through(Shape::Sphere, 8e-3, 2e-3), Some(0.0), "a rim out of reach");
        assert_eq!(way_through(Shape::Sphere, 0.0, -1e-6), Some(0.0), "a sheet behind the centre");
        assert_eq!(way_through(Shape::Cylinder, 3e-3, 9e-3), None, "in the way of the flat end");
        assert_eq!(way_through(Shape::Cylinder, 5e-3, 9e-3), Some(9e-3), "beside the shank");
    }

    #[test]
    fn live_segments_join_their_ends_whatever_has_failed() {
        let ([nx, ny], chunks) = ([19, 17], 3);
        for case in 0..200 {
            // Nearly whole, in pieces, dust.
            let threshold = [u64::MAX / 50, u64::MAX / 2, u64::MAX / 4 * 3][case % 3];
            let draw = |k: usize| splitmix64((case * 10_000 + k) as u64) > threshold;
            let mut hot = std::vec![[[0.0; CHUNK]; HOT_PLANES]; chunks * ny];
            for k in 0..nx * ny {
                let (i, j) = (k % nx, k / nx);
                let chunk = &mut hot[j * chunks + i / CHUNK];
                chunk[STIFFNESS][i % CHUNK] = f64::from(draw(2 * k));
                chunk[STIFFNESS + 1][i % CHUNK] = f64::from(draw(2 * k + 1));
            }
            let mut plainly = std::vec![0; nx * ny];
            let mut sets = Components::new(&mut plainly);
            for k in 0..nx * ny {
                let (i, j) = (k % nx, k / nx);
                if i + 1 < nx && draw(2 * k) {
                    sets.join(k, k + 1);
                }
                if j + 1 < ny && draw(2 * k + 1) {
                    sets.join(k, k + nx);
                }
            }
            sets.flatten();
            let mut labels = std::vec![0; nx * ny];
            let mut sets = Components::new(&mut labels);
            join_live_segments(&mut sets, &hot, chunks, [nx, ny]);
            sets.flatten();
            assert_eq!(labels, plainly, "case {case}");
        }
    }
}
