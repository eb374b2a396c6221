//! Outcomes: arrested, detached, exited, passed, through, rebounded. They latch with their step and are never
//! acted upon: the physics goes on.
//!
//! Method: tested when the step count is a multiple of 64; *attachment_failed* is latched by `one_step.rs` at
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
use crate::body::projectile::Body;
use crate::body::shape::Solid;
use crate::ground::lanes::CacheLine;
use crate::ground::math;
use crate::ground::planes::Axis;
use crate::memory::model::Model;
use crate::memory::network::Network;
use crate::memory::state::State;
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
/// `python -m evidence through`.
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
    let System { network, solid, state, failed_segments, .. } = system;
    let has_failed = *failed_segments > 0;
    let (step, work, velocity) = (state.step, state.sums.work, state.body.velocity);
    if state.watch.first.is_none() {
        if !state.watch.has(Outcome::Passed) && has_passed(network, solid, state) {
            state.watch.latch(Outcome::Passed, step, work);
        }
    } else {
        if !state.watch.has(Outcome::Detached) && contact_is_detached(network, has_failed) {
            state.watch.latch(Outcome::Detached, step, work);
        }
        let course = course(network, state);
        if network.layout.has(Feature::Through)
            && !state.watch.has(Outcome::Through)
            && is_through(network, solid, state, has_failed, &course)
        {
            state.watch.latch(Outcome::Through, step, work);
        }
        let settling = settling(&network.model, state);
        let settled = pass_checkpoint(state, solid.radius(), settling);
        let goes_on = velocity.dot(&course.normal) > 0.0;
        if course.direction == Vector::zeros() {
            // At rest since before the first contact: nothing has been stopped.
        } else if !goes_on && (course.within_ring || velocity.dot(&course.direction) <= 0.0) {
            state.watch.latch(Outcome::Arrested, step, work);
        }
        let crosses = goes_on || course.around.is_some_and(|radius| has_crossed(&state.body, &course, radius));
        let end = if crosses { Outcome::Exited } else { Outcome::Rebounded };
        if !state.watch.has(end)
            && course.direction != Vector::zeros()
            && contact_is_over(network, solid, state, has_failed, &course, settled)
        {
            state.watch.latch(end, step, work);
        }
    }
    network.arrays.flags.fill(0);
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
fn course(network: &Network<'_>, state: &mut State) -> Course {
    let velocity = state.body.velocity;
    let direction = state.watch.direction(&velocity);
    let impulse = state.sums.impulse;
    let mut course = Course { direction, normal: direction, within_ring: false, around: None };
    if let Some(hoop) = Hoop::of(&network.scene) {
        let start = start_in_sheet(network);
        let radius = hoop.radius * network.scene.sheet.spacing;
        course.within_ring = from_axis(&start.into()).norm() < radius;
        course.around = (!course.within_ring).then_some(radius);
        let outwards = from_axis(&state.body.position);
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
fn start_in_sheet(network: &Network<'_>) -> [f64; 3] {
    network.model.pose.point_in(network.scene.projectile.position)
}

/// Whether a body that leaves a circle outwards has come through it: straight back along its flight it leaves
/// the circle in the half that is across from where it entered.
fn has_crossed(body: &Body, course: &Course, radius: f64) -> bool {
    let (x, v) = (from_axis(&body.position), from_axis(&body.velocity));
    let (product, square) = (x.dot(&v), v.norm_squared());
    let root = product * product - square * (x.norm_squared() - radius * radius);
    root > 0.0 && (x * square - v * (product - math::sqrt(root))).dot(&course.direction) > 0.0
}

/// Whether the work has settled, to `settling`, J, over a forward travel of R that ends now. None if none
/// does.
fn pass_checkpoint(state: &mut State, radius: f64, settling: f64) -> Option<bool> {
    let (watch, sums, position) = (&mut state.watch, &state.sums, state.body.position);
    let travel = (position - watch.checkpoint).dot(&watch.first?.direction);
    if travel < radius {
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
fn contact_is_over(
    network: &mut Network<'_>,
    solid: &Solid,
    state: &State,
    has_failed: bool,
    course: &Course,
    settled: Option<bool>,
) -> bool {
    let beside_debris = settled == Some(true);
    // Without a node at the body the end of the travel need not be awaited.
    (beside_debris || state.sums.contacts == 0)
        && way_is_clear(network, solid, state, has_failed, course, beside_debris)
}

/// Whether held yarn will not stop the body any more. Asked when it has moved on by half a spacing and by
/// R/16, or for the time in which it moved by 3/4 R before the first contact: long enough for the torn sheet
/// to swing back. What it has lost since, taken over the way to go, must be small against the energy of its
/// motion along the normal, and it must not fly mainly sideways, where it meets yarn beside its way.
fn is_through(network: &mut Network<'_>, solid: &Solid, state: &mut State, has_failed: bool, course: &Course) -> bool {
    let (body, normal) = (state.body, &course.normal);
    let (place, speed) = (body.position.dot(normal), body.velocity.dot(normal));
    let forward = 2.0 * speed > body.velocity.norm() && state.force.dot(normal) >= 0.0;
    let (watch, radius) = (&mut state.watch, solid.radius());
    let (travel, mean_speed) = (place - watch.travel_start, 0.5 * (watch.travel_speed + speed));
    let energy = watch.first.map_or(0.0, |first| first.kinetic_energy);
    let first_speed = math::sqrt(2.0 * energy * network.model.inertia.inverse_mass);
    let is_near = travel < math::max(TRAVEL[0] * network.scene.sheet.spacing, TRAVEL[1] * radius);
    if has_failed && is_near && travel * first_speed < SWING_BACK * radius * mean_speed {
        return false;
    }
    let lost = math::max(watch.travel_speed * watch.travel_speed - speed * speed, 0.0);
    (watch.travel_start, watch.travel_speed) = (place, speed);
    let held = network.scene.attachment.kind != AttachmentKind::Free;
    if !(has_failed && forward && held && network.scene.is_free()) {
        return false;
    }
    let pieces = Pieces::of(network, has_failed);
    let Some(ahead) = way_past_held(network, &pieces, solid, &body, normal) else { return false };
    // A body that is no sphere may turn an edge into what is ahead.
    let (turns, reach) = (solid.feels_torque(), solid.reach());
    let way = if turns { reach } else { ahead };
    !(turns && ahead > 0.0) && speed * speed * travel > THROUGH_MARGIN * lost * way
}

/// Distance ahead of the body's centre along the normal, m, of held yarn that it may still touch; 0 if there
/// is none. None if some is in its way, deeper within what the body sweeps by moving on than R/4; or if the
/// body may turn an edge into some, because it turns faster than it moves on.
fn way_past_held(network: &Network<'_>, pieces: &Pieces, solid: &Solid, body: &Body, normal: &Vector) -> Option<f64> {
    let (margin, reach, mut way) = (IN_THE_WAY * solid.radius(), solid.reach(), 0.0);
    let speed = body.velocity.norm();
    let direction = if speed > 0.0 { body.velocity / speed } else { *normal };
    // Yarn behind the centre can push a convex body only on, unless it rubs.
    let rubs = network.layout.has(Feature::Friction);
    let tumbles = (solid.feels_torque() || rubs) && body.angular_velocity.norm() * reach > body.velocity.dot(normal);
    let nearest = if tumbles || rubs { -reach } else { 0.0 };
    for (i, j) in network.nodes() {
        let from_centre = network.position(i, j) - body.position;
        let ahead = from_centre.dot(&direction);
        let beside = from_centre - direction * ahead;
        let apart = ahead <= nearest || beside.norm() > reach + margin;
        if apart || !pieces.hold(pieces.of_node(network, i, j)) {
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
fn has_passed(network: &Network<'_>, solid: &Solid, state: &State) -> bool {
    let start = start_in_sheet(network);
    let [x, y] = network.scene.half_size();
    let (mut low, mut high) = ([-x, -y, 0.0], [x, y, network.scene.stack_height()]);
    let is_curved = network.layout.has(Feature::Curved);
    if is_curved {
        let counts = [network.layout.chunks, network.layout.nodes_x];
        [[low[0], low[2]], [high[0], high[2]]] =
            ring::box_at_rest(network.arrays.columns, counts, network.scene.sheet.spacing);
    }
    let flight = Flight::of(network, solid, state);
    if !network.scene.is_free() {
        // Only its host knows how it goes on; that it has got past the sheet's box is a fact.
        let axes = if is_curved { 0..3 } else { 2..3 };
        return axes.into_iter().any(|k| {
            let (from, x, extent) = (start[k], flight.position[k], flight.extents[k]);
            (from < low[k] && x > high[k] + extent) || (from > high[k] && x < low[k] - extent)
        });
    }
    let mut region = Region { low, high, ..Region::EMPTY };
    for j in (0..network.layout.plies).flat_map(|ply| network.awake_of(ply)[0]..network.awake_of(ply)[1]) {
        for i in 0..network.layout.nodes_x {
            // A sheet set in motion by the host may be faster than the body.
            region.include(&network.position(i, j));
            region.include_velocity(&network.velocity(i, j));
        }
    }
    add_images(network, &mut region);
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
fn add_images(network: &Network<'_>, region: &mut Region) {
    let symmetry = network.scene.symmetry;
    // The nodes of a curved sheet have been mirrored themselves.
    let swings = network.scene.attachment.kind != AttachmentKind::Free && !network.layout.has(Feature::Curved);
    for (k, mirrored) in [symmetry.mirror_x, symmetry.mirror_y, swings].into_iter().enumerate() {
        if mirrored {
            region.mirror(k, if k == 2 { network.scene.stack_height() } else { 0.0 });
        }
    }
}

/// Whether nothing of the sheet will act on the body any more if it flies on as it does. `beside_debris`:
/// loose pieces in its way are allowed if they have next to nothing to exchange with it.
fn way_is_clear(
    network: &mut Network<'_>,
    solid: &Solid,
    state: &State,
    has_failed: bool,
    course: &Course,
    beside_debris: bool,
) -> bool {
    let flight = Flight::of(network, solid, state);
    if course.around.is_none() && whole_yarn_is_in_the_way(network, &flight) {
        return false;
    }
    let pieces = Pieces::of(network, has_failed);
    if !held_is_clear(network, &pieces, &flight, course) {
        return false;
    }
    let loose = loose_pieces(network, &pieces, &flight);
    if loose.pursue {
        return false;
    }
    if !loose.in_the_way && !loose.are_overtaken {
        return true;
    }
    beside_debris && exchange(network, &pieces, &flight, &loose) <= EXCHANGE * settling(&network.model, state)
}

/// Held part of the sheet, as far as it has been looked at.
struct Held {
    /// Box about it.
    region: Region,
    /// Whether all of it lies behind the body and stays there; true of nothing.
    behind: bool,
}

impl Held {
    const NOTHING: Held = Held { region: Region::EMPTY, behind: true };

    fn include(&mut self, network: &Network<'_>, flight: &Flight, i: usize, j: usize) {
        let x = network.position(i, j);
        self.region.include(&x);
        if network.layout.has(Feature::Curved) {
            self.region.include(&swung_back(network, i, j));
        }
        if network.scene.attachment.kind == AttachmentKind::Free {
            self.region.include_velocity(&network.velocity(i, j));
        }
        self.behind = self.behind && !flight.has_ahead(&x) && flight.misses(&x, &network.velocity(i, j));
    }

    /// Whether the held part lies behind the body and stays there, or the body leaves the box about it for
    /// good. A part that is not clear stays so, whatever is included.
    fn is_clear(&self, network: &Network<'_>, flight: &Flight) -> bool {
        if self.behind {
            return true;
        }
        let mut region = self.region;
        add_images(network, &mut region);
        flight.leaves(&region)
    }
}

/// Where a node of a curved sheet is that has swung back through its circle.
fn swung_back(network: &Network<'_>, i: usize, j: usize) -> Vector {
    let (x, deflection) = (network.position(i, j), network.deflection(i, j) * network.scene.sheet.spacing);
    let outwards = from_axis(&x);
    x - outwards * (2.0 * deflection / math::max(outwards.norm(), f64::MIN_POSITIVE))
}

/// Whether all that is held is clear of the body: of a ring that it enters from outside, of the half which it
/// meets first.
fn held_is_clear(network: &Network<'_>, pieces: &Pieces, flight: &Flight, course: &Course) -> bool {
    let mut held = Held::NOTHING;
    let enters = course.around.is_some() && flight.velocity.dot(&course.normal) > 0.0;
    rows_from(network, flight).all(|j| {
        for i in (0..network.layout.nodes_x).filter(|&i| pieces.hold(pieces.of_node(network, i, j))) {
            if !(enters && from_axis(&network.position(i, j)).dot(&course.direction) > 0.0) {
                held.include(network, flight, i, j);
            }
        }
        held.is_clear(network, flight)
    })
}

/// Whether yarn along x near the body that is whole from a fixed node on, and so is held, is not clear of it:
/// the usual case while the body is in the sheet, found without joining nodes.
fn whole_yarn_is_in_the_way(network: &Network<'_>, flight: &Flight) -> bool {
    let mut held = Held::NOTHING;
    // Farther away whole yarn is seldom in the way, and looking at it would take as long as joining all
    // nodes.
    let near = |j: &usize| distance(network, flight, *j) <= 2.0 * flight.reach;
    rows_from(network, flight).take_while(near).any(|j| {
        let live = |i: usize| is_live(network, Axis::Horizontal, i, j);
        // A clamp may have let go of it.
        let holds = |i: usize| network.is_fixed(i, j);
        let [_, left_end, right, right_end] =
            network.arrays.rows.runs.get(j).map_or([0; 4], |run| run.map(|i| i as usize));
        let mut whole = left_end;
        while left_end > 0 && holds(left_end - 1) && whole < network.layout.nodes_x && live(whole - 1) {
            held.include(network, flight, whole, j);
            whole += 1;
        }
        for i in (whole..right).rev().take_while(|&i| right < right_end && holds(right) && live(i)) {
            held.include(network, flight, i, j);
        }
        !held.is_clear(network, flight)
    })
}

/// All rows, those at rest nearest to the body first, from either side in turn: what is in its way is most
/// likely there.
fn rows_from(network: &Network<'_>, flight: &Flight) -> impl Iterator<Item = usize> + use<> {
    let rows = network.layout.nodes_y;
    let by_distance = |a: &usize, b: &usize| distance(network, flight, *a).total_cmp(&distance(network, flight, *b));
    let nearest = (0..rows).min_by(by_distance).unwrap_or(0);
    let both = (0..rows).flat_map(move |d| [nearest.checked_add(d), nearest.checked_sub(d + 1)]);
    both.flatten().filter(move |&j| j < rows)
}

/// Distance of a row at rest from the body's centre along y, m.
fn distance(network: &Network<'_>, flight: &Flight, j: usize) -> f64 {
    math::abs(network.rest(0, j)[1] * network.scene.sheet.spacing - flight.position[1])
}

/// Looks for loose pieces in the body's way and flags them.
fn loose_pieces(network: &mut Network<'_>, pieces: &Pieces, flight: &Flight) -> Loose {
    network.arrays.flags.fill(0);
    let (mut ahead, mut behind, mut in_the_way) = (WeightedSum::NOTHING, WeightedSum::NOTHING, false);
    for (i, j) in network.nodes() {
        let piece = pieces.of_node(network, i, j);
        if pieces.hold(piece) {
            continue;
        }
        let (x, v) = (network.position(i, j), network.velocity(i, j));
        let (node_ahead, node_behind) = (flight.has_ahead(&x), flight.has_behind(&x));
        let piece_ahead = lies_ahead(network, piece, flight);
        let weight = network.share(i, j);
        if piece_ahead && !is_alone(network, i, j) {
            ahead.add(weight, v.dot(&flight.velocity));
        }
        if node_behind {
            behind.add(weight, v.dot(&flight.velocity));
        }
        if node_ahead != piece_ahead || !(node_behind || flight.misses(&x, &v)) {
            in_the_way = true;
            network.set_flag(piece);
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
fn exchange(network: &Network<'_>, pieces: &Pieces, flight: &Flight, loose: &Loose) -> f64 {
    let (mut mass, mut energy) = (0.0, 0.0);
    for (i, j) in network.nodes() {
        let piece = pieces.of_node(network, i, j);
        let overtaken = || {
            loose.are_overtaken && lies_ahead(network, piece, flight) && !pieces.hold(piece) && !is_alone(network, i, j)
        };
        if network.has_flag(piece) || overtaken() {
            let node_mass = network.share(i, j) * (network.model.node_mass * network.mass_share_of_row(j));
            mass += node_mass;
            energy += 0.5 * node_mass * (network.velocity(i, j) - flight.velocity).norm_squared();
        }
    }
    flight.velocity.norm() * math::sqrt(2.0 * mass * energy)
}

/// Whether a piece, by the node with its smallest number, lies before the body's centre.
fn lies_ahead(network: &Network<'_>, piece: usize, flight: &Flight) -> bool {
    let (i, j) = network.layout.column_and_row(piece);
    flight.has_ahead(&network.position(i, j))
}

/// Whether some node was touched since the last test, and no live path joins one to a node that is held.
fn contact_is_detached(network: &mut Network<'_>, has_failed: bool) -> bool {
    let can_be = network.layout.has(Feature::Detachment) && network.scene.attachment.kind != AttachmentKind::Free;
    let watched = can_be && (has_failed || network.have_clamps_let_go());
    if !watched || network.arrays.flags.iter().all(|&f| f == 0) || held_by_a_straight_yarn(network) {
        return false;
    }
    let Some(support) = join_nodes(network) else { return true };
    let labels = CacheLine::words_of(network.arrays.shared).iter().take(network.layout.nodes());
    let mut touched = labels.enumerate().filter(|(k, _)| network.has_flag(*k));
    !touched.any(|(_, &label)| label as usize == support)
}

/// Whether live segments run straight from a touched node to a fixed one: the usual case, found without
/// joining nodes.
fn held_by_a_straight_yarn(network: &Network<'_>) -> bool {
    let (nx, ny) = (network.layout.nodes_x, network.layout.nodes_y);
    let live = |axis: Axis, i: usize, j: usize| is_live(network, axis, i, j);
    let fixed = |i: usize, j: usize| network.is_fixed(i, j);
    let held = |i: usize, j: usize| {
        // Left, right, down and up, as far as the yarn is whole.
        (0..i).rev().map_while(|i| live(Axis::Horizontal, i, j).then_some((i, j))).any(|(i, j)| fixed(i, j))
            || (i + 1..nx).map_while(|i| live(Axis::Horizontal, i - 1, j).then_some((i, j))).any(|(i, j)| fixed(i, j))
            || (0..j).rev().map_while(|j| live(Axis::Vertical, i, j).then_some((i, j))).any(|(i, j)| fixed(i, j))
            || (j + 1..ny).map_while(|j| live(Axis::Vertical, i, j - 1).then_some((i, j))).any(|(i, j)| fixed(i, j))
    };
    let words = network.arrays.flags.iter().enumerate().filter(|(_, word)| **word != 0);
    words
        .flat_map(|(w, _)| 32 * w..32 * (w + 1))
        .filter(|&k| network.has_flag(k))
        .map(|k| network.layout.column_and_row(k))
        .any(|(i, j)| held(i, j))
}

/// Largest change of the work with which it counts as final, J.
fn settling(model: &Model, state: &State) -> f64 {
    let part = SETTLED_PART * math::abs(state.sums.work);
    math::max(part, model.node_mass * state.body.velocity.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::ground::planes::{self, STIFFNESS};
    use crate::memory::watch::FirstContact;
    use crate::scene::parts::Shape;
    use crate::tests::{AT_REST, network, sheet, sim};
    use std::vec::Vec;

    /// State with a body at a place, m, with a velocity, m/s.
    fn state(position: [f64; 3], velocity: [f64; 3]) -> State {
        let body = Body { position: position.into(), velocity: velocity.into(), ..Body::of(&AT_REST) };
        State::at_start(body)
    }

    /// [`state`] after a first contact at this velocity along z, m/s.
    fn in_contact(network: &Network<'_>, position: [f64; 3], velocity: [f64; 3], first_speed: f64) -> State {
        let mut state = state(position, velocity);
        let kinetic_energy = 0.5 * network.model.inertia.mass * first_speed * first_speed;
        state.watch.first = Some(FirstContact { step: 0, direction: Vector::z(), kinetic_energy });
        state
    }

    /// Cuts all segments from or to the nodes in a disc about a place, spacings.
    fn cut(network: &mut Network<'_>, place: [f64; 2], radius: f64) {
        let layout = network.layout;
        layout.for_each_segment(|axis, i, j| {
            let end = if axis == Axis::Horizontal { (i + 1, j) } else { (i, j + 1) };
            let is_in = |(i, j): (usize, usize)| {
                let [x, y, _] = network.rest(i, j);
                (x - place[0]) * (x - place[0]) + (y - place[1]) * (y - place[1]) < radius * radius
            };
            if is_in((i, j)) || is_in(end) {
                let row = planes::row_mut(network.arrays.rows.hot, layout.chunks, j);
                planes::set(row, STIFFNESS + axis as usize, i, 0.0);
            }
        });
    }

    #[test]
    fn the_rows_nearest_to_the_body_come_first() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.projectile.position[1] = 7.3 * scene.sheet.spacing;
        let (network, _, solid) = network(&scene);
        let flight = Flight::of(&network, &solid, &state(scene.projectile.position, [0.0; 3]));
        let mut rows: Vec<usize> = rows_from(&network, &flight).collect();
        assert_eq!(rows[..4], [59, 58, 60, 57], "the middle one is 52");
        let off = |j: usize| (network.position(0, j).y - flight.position.y).abs();
        for &j in &rows {
            assert!((distance(&network, &flight, j) - off(j)).abs() < 1e-15);
        }
        rows.sort_unstable();
        assert_eq!(rows, Vec::from_iter(0..network.layout.nodes_y));
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
                let flight = Flight::of(&sim.system.network, &sim.system.solid, &sim.system.state);
                let in_the_way = whole_yarn_is_in_the_way(&sim.system.network, &flight);
                let pieces = Pieces::of(&mut sim.system.network, sim.system.failed_segments > 0);
                let mut held = Held::NOTHING;
                for (i, j) in sim.system.network.nodes() {
                    if pieces.hold(pieces.of_node(&sim.system.network, i, j)) {
                        held.include(&sim.system.network, &flight, i, j);
                    }
                }
                let clear = held.is_clear(&sim.system.network, &flight);
                assert!(!(in_the_way && clear), "step {}", sim.system.state.step);
                let course = course(&sim.system.network, &mut sim.system.state);
                assert_eq!(held_is_clear(&sim.system.network, &pieces, &flight, &course), clear);
                *(if in_the_way { &mut found } else { &mut not_found }) += 1;
            }
        }
        assert!(found > 50 && not_found > 50, "{found} {not_found}");
    }

    /// A sheet at rest with a round hole of radius `hole`, and a sphere or a cylinder of that radius and
    /// length whose centre is `behind` its plane: R = 5 mm.
    fn way_through(shape: Shape, hole: f64, behind: f64) -> Option<f64> {
        let mut scene = sheet(41, 41);
        (scene.projectile.shape, scene.projectile.radius, scene.projectile.length) = (shape, 5e-3, 20e-3);
        let (mut network, _, solid) = network(&scene);
        cut(&mut network, [0.0; 2], hole / scene.sheet.spacing);
        let (pieces, body) = (Pieces::of(&mut network, hole > 0.0), state([0.0, 0.0, -behind], [0.0; 3]).body);
        way_past_held(&network, &pieces, &solid, &body, &Vector::z())
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

    /// The body has moved on by 1 mm and has 2 mm to go: it is through if the loss of its squared speed on
    /// that way is less than 1/6 of what is left.
    #[test]
    fn a_body_is_through_if_it_has_three_times_the_energy_that_is_asked_of_it() {
        let mut scene = sheet(41, 41);
        (scene.projectile.radius, scene.track_through) = (5e-3, true);
        let (mut network, _, solid) = network(&scene);
        cut(&mut network, [0.0; 2], 4.5e-3 / scene.sheet.spacing);
        for (lost, expected) in [(0.166, true), (0.167, false)] {
            let speed = 80.0;
            let mut state = in_contact(&network, [0.0, 0.0, -2e-3], [0.0, 0.0, speed], 100.0);
            (state.watch.travel_start, state.watch.travel_speed) = (-3e-3, speed * math::sqrt(1.0 + lost));
            let course = course(&network, &mut state);
            assert_eq!(is_through(&mut network, &solid, &mut state, true, &course), expected, "{lost}");
            assert_eq!((state.watch.travel_start, state.watch.travel_speed), (-2e-3, speed));
            // Not asked again before it has moved on.
            assert!(!is_through(&mut network, &solid, &mut state, true, &course));
        }
    }

    #[test]
    fn contact_is_detached_once_no_touched_node_is_joined_to_a_support() {
        let mut scene = sheet(21, 21);
        scene.track_detachment = true;
        let (mut network, _, _) = network(&scene);
        let touched = 10 * 21 + 10;
        assert!(!contact_is_detached(&mut network, true), "nothing is touched");
        network.set_flag(touched);
        assert!(!contact_is_detached(&mut network, true));
        for (i, j) in [(9, 10), (11, 10), (10, 9)] {
            let [x, y, _] = network.rest(i, j);
            cut(&mut network, [x, y], 0.5);
            assert!(!contact_is_detached(&mut network, true), "up the yarn is whole");
        }
        let [x, y, _] = network.rest(10, 14);
        cut(&mut network, [x, y], 0.5);
        // Four rows up the yarn hangs on its neighbours.
        assert!(!contact_is_detached(&mut network, true));
        for (i, j) in [(9, 11), (11, 11), (9, 12), (11, 12), (9, 13), (11, 13)] {
            let [x, y, _] = network.rest(i, j);
            cut(&mut network, [x, y], 0.5);
        }
        assert!(contact_is_detached(&mut network, true));
        network.set_flag(2 * 21 + 2);
        assert!(!contact_is_detached(&mut network, true));
    }

    #[test]
    fn a_body_has_passed_a_sheet_when_it_leaves_it_behind() {
        let mut scene = sheet(21, 21);
        scene.projectile.position[2] = -0.05;
        let (network, _, solid) = network(&scene);
        let [x, _] = scene.half_size();
        let beside = x + 2.0 * scene.projectile.radius;
        for (place, speed, expected) in [
            ([beside, 0.0, -0.03], 100.0, false),
            ([beside, 0.0, 0.03], 100.0, true),
            ([beside, 0.0, 0.03], -100.0, false),
            ([beside, 0.0, -0.06], -100.0, false),
        ] {
            let state = state(place, [0.0, 0.0, speed]);
            assert_eq!(has_passed(&network, &solid, &state), expected, "{place:?} {speed}");
        }
    }

    #[test]
    fn work_has_settled_if_it_hardly_changes_over_a_travel_of_r() {
        let (network, _, solid) = network(&sheet(21, 21));
        let radius = solid.radius();
        for (change, expected) in [(0.9, true), (1.1, false)] {
            let mut state = in_contact(&network, [0.0; 3], [0.0, 0.0, 1e-3], 100.0);
            state.sums.work = 40.0;
            let part = settling(&network.model, &state);
            assert!((part - SETTLED_PART * 40.0).abs() < 1e-12);
            (state.watch.checkpoint_work, state.body.position.z) = (40.0 - change * part, 0.99 * radius);
            assert_eq!(pass_checkpoint(&mut state, radius, part), None);
            state.body.position.z = 1.01 * radius;
            assert_eq!(pass_checkpoint(&mut state, radius, part), Some(expected));
            assert_eq!((state.watch.checkpoint, state.watch.checkpoint_work), (state.body.position, 40.0));
        }
    }

    /// Flights along x and across it over a circle of radius 1 m, entered at its left end.
    #[test]
    fn a_body_has_crossed_a_circle_if_it_entered_on_the_other_side() {
        let course = Course { direction: Vector::x(), normal: Vector::x(), within_ring: false, around: Some(1.0) };
        for (position, velocity, expected) in [
            ([1.5, 0.0, 0.0], [50.0, 0.0, 0.0], true),
            ([-1.5, 0.0, 0.0], [-50.0, 0.0, 0.0], false),
            ([1.5, 0.0, 1.1], [50.0, 0.0, 0.0], false),
        ] {
            let body = state(position, velocity).body;
            assert_eq!(has_crossed(&body, &course, 1.0), expected, "{position:?}");
        }
    }
}
