//! Outcomes: arrested, detached, exited, passed, through, rebounded. They latch with their step and are never
//! acted upon: the physics goes on.
//!
//! Method: tested when the step count is a multiple of 64; *attachment_failed* is latched by `explicit.rs` at
//! the end of a force window. All others but "passed" need a first contact.
//! "Detached" asks whether any node touched in the last 64 steps is joined to a support (`pieces.rs`).
//! "Exited" asks what can still act on the body (`flight.rs`): the held part of the sheet must lie behind or
//! beside its flight, and loose pieces in its way must move with it. "Through" asks whether what has slowed
//! the body lately, over the rest of its way past the held yarn, is little against its energy. All but
//! "detached" are judged along one normal of the sheet, from the side of the body to the other ([`Course`]):
//! the same end of contact is "exited" for a body that moves along it, and "rebounded" for one that does not.
//! Held yarn of a curved sheet swings back along the radius.
//! Limits: the body is taken to fly on straight (under its present load), and so are the nodes. A body that
//! comes to a ring from outside has exited once it is within and clear of that half of the wall, or beyond
//! the other half. Without `track_detachment` nothing is known to be loose once a segment has failed: then no
//! node at all may be in the way.
//! Reference: docs/model.md, "Outcomes".

use crate::body::pose::{Vector, into_body};
use crate::ground::lanes::CacheLine;
use crate::ground::math;
use crate::ground::planes::Axis;
use crate::memory::system::System;
use crate::memory::watch::Outcome;
use crate::scene::features::Feature;
use crate::scene::parts::AttachmentKind;
use crate::sheet::ring::{self, Hoop, from_axis};
use crate::step::flight::{Flight, Region};
use crate::step::pieces::{Pieces, is_alone, is_live, join_nodes};

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
    let pieces = Pieces::of(system);
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
        if apart || !pieces.hold(pieces.of_node(system, i, j)) {
            continue;
        }
        if tumbles {
            return None;
        }
        // The least gap of the body's part behind the node, by steps of R/4, in which it changes by no more
        // than that.
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
    let flight = Flight::of(system);
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
    // The nodes of a curved sheet have been mirrored themselves.
    let swings = system.scene.attachment.kind != AttachmentKind::Free && !system.layout.has(Feature::Curved);
    for (k, mirrored) in [symmetry.mirror_x, symmetry.mirror_y, swings].into_iter().enumerate() {
        if mirrored {
            region.mirror(k, if k == 2 { system.scene.stack_height() } else { 0.0 });
        }
    }
}

/// Whether nothing of the sheet will act on the body any more if it flies on as it does. `beside_debris`:
/// loose pieces in its way are allowed if they have next to nothing to exchange with it.
fn way_is_clear(system: &mut System<'_>, course: &Course, beside_debris: bool) -> bool {
    let flight = Flight::of(system);
    if course.around.is_none() && whole_yarn_is_in_the_way(system, &flight) {
        return false;
    }
    let pieces = Pieces::of(system);
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
        for i in (0..system.layout.nodes_x).filter(|&i| pieces.hold(pieces.of_node(system, i, j))) {
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
        let piece = pieces.of_node(system, i, j);
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
        let piece = pieces.of_node(system, i, j);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::scene::parts::Shape;
    use crate::tests::{sheet, sim};
    use std::vec::Vec;

    #[test]
    fn the_rows_nearest_to_the_body_come_first() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.projectile.position[1] = 7.3 * scene.sheet.spacing;
        let sim = sim(&scene);
        let (system, flight) = (&sim.system, Flight::of(&sim.system));
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
                let flight = Flight::of(&sim.system);
                let in_the_way = whole_yarn_is_in_the_way(&sim.system, &flight);
                let pieces = Pieces::of(&mut sim.system);
                let mut held = Held::NOTHING;
                for (i, j) in sim.system.nodes() {
                    if pieces.hold(pieces.of_node(&sim.system, i, j)) {
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
}
