//! Impulse contact of the nodes with the rigid projectile, equal and opposite on it. Restitution zero; friction (`friction.rs`) if asked for.
//! A fixed node is a node of infinite mass: its support takes the impulse, and what the body loses there is lost.
//!
//! Method: for every candidate node (gap phi < h at t_n) an impulse lambda >= 0 along the outward normal n, complementary to
//! the gap rate phi/dt + n.(v - V' - w' x r) >= 0 at the end of the step (0 in place of phi/dt for a node already inside),
//! solved together by projected Gauss-Seidel in node order from lambda = 0. The gap of a convex body is convex, so the node
//! stays outside; no position is projected and no energy is put into the yarns.
//! Nodes that the body gets past beside an edge within the step are left out ([`Passage`]); fixed ones that are before two faces wait
//! for the impulses on the others.
//! What sweeps do not settle goes on in `newton.rs`.
//! Limits: penetration-free for converged solves (others are counted, with what is left over, and never add energy: impulses that
//! would are all scaled back). A prescribed body passes through fixed nodes: neither gives way.
//! Rotation makes the non-penetration second order in dt.
//! Reference: J. J. Moreau, in: Nonsmooth Mechanics and Applications (1988); M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235.

use crate::body::pose::{self, Vector};
use crate::body::projectile::{self, Body, Inertia};
use crate::body::shape::{self, Solid};
use crate::contact::candidate::{Candidate, Found, Solved};
use crate::contact::friction::{self, Tangential};
use crate::contact::newton::{Newton, STIFF};
use crate::ground::error::Failure;
use crate::ground::lanes::{self, InstructionSet, Job, Lane};
use crate::ground::math;
use crate::ground::planes::{self, Axis, CHUNK, Chunk, HOT_PLANES};
use crate::ground::ranges::{NOT_KEPT, end_of_range, range_of, spread};
use crate::memory::blocks::Blocks;
use crate::memory::layout::{CANDIDATE_REALS, TANGENTIAL_REALS};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::scene::parts::{Scene, Symmetry};
use crate::sheet::grading::{LINE_PLANES, Net, PLACE};
use crate::sheet::places::{Places, rest_offset};
use crate::sheet::weave::{in_runs, meets_runs};
use core::ops::Range;

/// Sweeps after which a solve goes on with Newton's method, or ends in a stack of plies.
pub const MAX_SWEEPS: u32 = 200;
/// Impulses found in sweeps after which it does so earlier, but not before so many sweeps: a pass of Newton's method over many candidates brings more.
pub const MAX_UPDATES: usize = 200_000;
/// See [`MAX_UPDATES`].
pub const LEAST_SWEEPS: u32 = 20;

/// What rounding can leave of a gap rate, in parts of the speeds that it is the difference of: nine times half a last place,
/// three of n.V, three of arm.w, and one each of the impulse, of the speed it gives and of the difference. The number of nodes
/// does not enter: impulses this small no longer change the velocity of a body that is heavier than a few nodes.
const ROUNDING: f64 = 1e-15;

/// What rounding can leave of a gap, in parts of the places that it is the difference of: half a last place from each of node, body and their
/// difference, three of the turn into the body's axes, and two of the distance from a face.
const PLACES: f64 = 4.0 * f64::EPSILON;

/// A candidate whose gap grows faster than this part of the speed of the body's surface takes no impulse, unless the body gives way
/// to the others that far.
const OUT_OF_REACH: f64 = 0.01;

/// Solves of a step in which the body may meet more of the nodes that were let pass.
const MOST_ROUNDS: u32 = 8;

/// Planes that are tried along the way of a node past a body; a way that needs more counts as a hit.
const MOST_PLANES: u32 = 8;

/// A node no deeper than this part of the spacing touches, rounding aside.
pub(crate) const TOUCHING: f64 = 1e-9;

/// The body as the search for candidates sees it.
pub struct Search<'s> {
    solid: &'s Solid,
    body: &'s Body,
    /// Half extents of the box about the body and the margin, m.
    half: [f64; 3],
    /// Square of the radius about the body's centre beyond which nothing is a candidate, m^2.
    reach2: f64,
    margin: f64,
    instructions: InstructionSet,
}

impl<'s> Search<'s> {
    /// Prepares a search for nodes closer than `margin` (the node spacing, m).
    #[inline(never)] // What it needs must not add to the stack of the search.
    pub fn new(solid: &'s Solid, body: &'s Body, margin: f64, instructions: InstructionSet) -> Search<'s> {
        // A little more than the margin, so that rounding never hides a candidate; the exact test follows.
        let half = solid.half_extents(&body.orientation).map(|extent| extent + margin * (1.0 + 1e-9));
        let reach = (solid.reach() + margin) * (1.0 + 1e-9);
        Search { solid, body, half, reach2: reach * reach, margin, instructions }
    }

    /// Columns, rows and plies of the flat sheet outside which no node is in the body's box.
    #[inline(never)] // It must not add to the stack of the search for overlaps.
    pub(crate) fn box_at_rest(&self, scene: &Scene, places: &[Places; 2]) -> [Range<usize>; 3] {
        // In spacings rounding is another: a little more again.
        let ends = |k: usize, h: f64| {
            let half = self.half[k] * (1.0 + 1e-9);
            [(self.body.position[k] - half) / h, (self.body.position[k] + half) / h]
        };
        let ([h_x, h_y], gap, plies) = (scene.spacings(), scene.stack.gap, scene.stack.plies as usize);
        let [[left, right], [bottom, top]] = [ends(0, h_x), ends(1, h_y)];
        let behind = if gap > 0.0 {
            let [first, last] = ends(2, gap).map(|end| math::max(end, 0.0) as usize);
            first..last.saturating_add(1).min(plies)
        } else {
            0..plies
        };
        [places[0].within(left, right), places[1].within(bottom, top), behind]
    }

    /// Whether the plane of the flat sheet cuts the body's box.
    fn meets_plane(&self) -> bool {
        math::abs(self.body.position.z) <= self.half[2]
    }

    /// Whether the body reaches beyond the fine part of a graded network. Beyond the edge of the sheet nothing is coarse.
    #[inline(never)] // It must not add to the stack of the sweep.
    fn is_beyond_fine(&self, scene: &Scene) -> bool {
        let axes = [(0, Axis::Horizontal), (1, Axis::Vertical)];
        axes.into_iter().zip(Places::both(scene)).any(|((k, axis), places)| {
            let ([first, last], h) = (places.fine, scene.spacing(axis));
            let (x, reach) = (self.body.position[k], self.half[k] - self.margin);
            let place = |crossing: u32| rest_offset(crossing as usize, places.crossings) * h;
            (first > 0 && x - reach < place(first)) || (last + 1 < places.crossings && x + reach > place(last))
        })
    }

    /// What many nodes are tested against at once; `h`: the spacing, m.
    pub(crate) fn neighbourhood(&self, h: f64) -> Neighbourhood<'_> {
        // In spacings rounding is another: a little more again.
        let slack = 1.0 + 1e-9;
        let (centre, half) = ([0, 1].map(|k| self.body.position[k] / h), [0, 1].map(|k| self.half[k] / h * slack));
        Neighbourhood { search: self, h, centre, half }
    }

    /// Gap of any point, m.
    #[inline(never)] // It must not add to the stack of the search for overlaps.
    pub fn gap(&self, x: &Vector) -> f64 {
        let r = x - self.body.position;
        let turns = self.solid.feels_torque();
        let r = if turns { pose::into_body(&self.body.orientation, &r) } else { r };
        self.solid.gap(&r).distance
    }

    /// Gap, normal in the sheet's frame and arm in body axes of the point `x`, if it is a candidate.
    pub fn candidate(&self, x: &Vector) -> Option<(f64, Vector, Vector)> {
        let r = x - self.body.position;
        let outside = |k: usize| r[k] > self.half[k] || r[k] < -self.half[k];
        if outside(0) || outside(1) || outside(2) || r.norm_squared() > self.reach2 {
            return None;
        }
        self.candidate_at(&r)
    }

    /// The same of a point inside the box and the ball, `r` from the body's centre.
    #[inline(always)] // Most of its time would be the way of its answer through memory.
    fn candidate_at(&self, r: &Vector) -> Option<(f64, Vector, Vector)> {
        if let Solid::Sphere { radius } = self.solid {
            // A sphere needs no body axes: its gap depends on the distance alone.
            let gap = shape::sphere_gap(r, *radius);
            return (gap.distance < self.margin).then_some((gap.distance, gap.normal, Vector::zeros()));
        }
        let q = &self.body.orientation;
        let r_body = pose::into_body(q, r);
        let gap = self.solid.gap(&r_body);
        (gap.distance < self.margin)
            .then(|| (gap.distance, pose::out_of_body(q, &gap.normal), r_body.cross(&gap.normal)))
    }
}

/// The body's box and the ball about it.
pub(crate) struct Neighbourhood<'s> {
    search: &'s Search<'s>,
    h: f64,
    /// Centre and half extents of the box in the sheet's plane, spacings.
    centre: [f64; 2],
    half: [f64; 2],
}

/// The nodes of a chunk as the body sees them.
struct Offsets {
    /// From the body's centre, m; of nodes beyond the box or the ball they may be others.
    r: [[f64; CHUNK]; 3],
    /// How far beyond the box and the ball, not above 0 inside.
    beyond: [f64; CHUNK],
}

impl Neighbourhood<'_> {
    /// Whether no node of a row at y0 is in the box: of all the displacement along y lies in `range`, which holds 0.
    #[inline]
    pub(crate) fn misses_row(&self, y0: f64, [low, high]: [f64; 2]) -> bool {
        let ([_, y], [_, half]) = (self.centre, self.half);
        // One end decides, because the other one is no nearer than the row's own place.
        if y0 < y { y0 + high < y - half } else { y0 + low > y + half }
    }

    /// Chunks [first, end) of a row of `count` outside which no node is in the box: of a node in column i at x0 + i + u, or of a graded
    /// network in its place, the displacement u lies in `range`.
    fn chunks(&self, x0: f64, columns: &[Chunk<LINE_PLANES>], [low, high]: [f64; 2], count: usize) -> [usize; 2] {
        let ([x, _], [half, _]) = (self.centre, self.half);
        let (from, to) = (x - half - high, x + half - low);
        if !columns.is_empty() {
            let first = columns.partition_point(|chunk| chunk[PLACE][CHUNK - 1] < from);
            return [first, columns.partition_point(|chunk| chunk[PLACE][0] <= to)];
        }
        // What lies before the first column becomes 0.
        let chunk = |place: f64| (((place - x0) / CHUNK as f64) as usize).min(count);
        [chunk(from), chunk(to) + 1]
    }

    /// The first of the chunks [from, end) of a row with a node in the box and the ball, and where its nodes are.
    /// `columns`: those of a graded network; `first`: rest place of the row's first node, spacings.
    fn next(
        &self,
        row: &[Chunk<HOT_PLANES>],
        columns: &[Chunk<LINE_PLANES>],
        chunks: [usize; 2],
        first: [f64; 3],
        offsets: &mut Offsets,
    ) -> Option<usize> {
        lanes::dispatch(self.search.instructions, Near { near: self, row, columns, chunks, first, offsets })
    }
}

/// [`Neighbourhood::next`] as a job for the lanes.
struct Near<'a> {
    near: &'a Neighbourhood<'a>,
    columns: &'a [Chunk<LINE_PLANES>],
    row: &'a [Chunk<HOT_PLANES>],
    chunks: [usize; 2],
    first: [f64; 3],
    offsets: &'a mut Offsets,
}

impl Job for Near<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lane>(self) -> Option<usize> {
        const COLUMNS: [f64; CHUNK] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let Search { body, half, reach2, .. } = self.near.search;
        let (centre, [a, b, c]) = (&body.position, *half);
        let centre = [L::splat(centre.x), L::splat(centre.y), L::splat(centre.z)];
        let half = [L::splat(a), L::splat(b), L::splat(c)];
        let (zero, h, reach2) = (L::splat(0.0), L::splat(self.near.h), L::splat(*reach2));
        let [x0, y0, z0] = self.first;
        let [from, end] = self.chunks;
        let part = self.row.get(from..end.min(self.row.len())).unwrap_or(&[]);
        let Offsets { r: [out_x, out_y, out_z], beyond: out } = self.offsets;
        for (c, [x, y, z, ..]) in (from..).zip(part) {
            // Offsets in a line are halves, so that no sum of them is rounded.
            let (columns, column) = match self.columns.get(c) {
                Some(columns) => (&columns[PLACE], 0.0),
                None => (&COLUMNS, x0 + (c * CHUNK) as f64),
            };
            let mut near = false;
            for g in 0..CHUNK / L::WIDTH {
                let from_centre =
                    |place: L, u: &[f64; CHUNK], k: usize| place.add(L::load(&L::groups(u)[g])).mul(h).sub(centre[k]);
                let beyond_axis = |r: L, k: usize| r.max(zero.sub(r)).sub(half[k]);
                let rx = from_centre(L::load(&L::groups(columns)[g]).add(L::splat(column)), x, 0);
                let beyond_x = beyond_axis(rx, 0);
                if !zero.sub(beyond_x).any_not_below(zero) {
                    // Most of a row lies to one side, and nothing more is asked of nodes beyond the box.
                    beyond_x.store(&mut L::groups_mut(out)[g]);
                    continue;
                }
                let (ry, rz) = (from_centre(L::splat(y0), y, 1), from_centre(L::splat(z0), z, 2));
                let beyond_box = beyond_x.max(beyond_axis(ry, 1)).max(beyond_axis(rz, 2));
                let beyond_ball = rx.mul(rx).add(ry.mul(ry)).add(rz.mul(rz)).sub(reach2);
                let beyond = beyond_box.max(beyond_ball);
                rx.store(&mut L::groups_mut(out_x)[g]);
                ry.store(&mut L::groups_mut(out_y)[g]);
                rz.store(&mut L::groups_mut(out_z)[g]);
                beyond.store(&mut L::groups_mut(out)[g]);
                near |= zero.sub(beyond).any_not_below(zero);
            }
            if near {
                return Some(c);
            }
        }
        None
    }
}

/// The body at both ends of a pass in which it keeps its rates, for nodes that may get past one of its edges.
pub struct Passage<'s> {
    solid: &'s Solid,
    start: Body,
    end: Body,
}

impl<'s> Passage<'s> {
    /// The passage of a body with these rates, over `dt`, s.
    pub fn new(solid: &'s Solid, body: &Body, dt: f64) -> Passage<'s> {
        let position = body.position + body.velocity * dt;
        let orientation = projectile::cayley_turn(&body.orientation, &body.angular_velocity, dt);
        Passage { solid, start: *body, end: Body { position, orientation, ..*body } }
    }

    /// Whether a node that goes straight from `x` to `y` gets past an edge, although the plane that its gap is linearised to at
    /// `x` would press it.
    ///
    /// A face that is curved (by no radius below R) ends as far above its own plane as way^2/2R: what presses by less is of second
    /// order, as what turning bends the way by, and no edge.
    pub fn is_past_an_edge(&self, x: &Vector, y: &Vector, touching: f64) -> bool {
        let (first, last) = (at(&self.start, x), at(&self.end, y));
        let (from, way) = (self.solid.gap(&first), last - first);
        let depth = -(from.distance + from.normal.dot(&way));
        depth * (2.0 * self.solid.radius()) > way.dot(&way) && self.stays_outside(x, y, touching)
    }

    /// Whether a node at `x` is before two faces that meet at an edge: impulses on other nodes may decide which of them it meets.
    pub fn starts_before_an_edge(&self, x: &Vector, touching: f64) -> bool {
        self.solid.is_before_an_edge(&at(&self.start, x), -touching)
    }

    /// Depth of a node at `y` at the end, m; negative outside.
    fn depth_at_end(&self, y: &Vector) -> f64 {
        -self.solid.gap(&at(&self.end, y)).distance
    }

    /// Whether a node that goes straight from `x` to `y` stays outside. Down to the depth `touching`, m, it only touches.
    ///
    /// The whole body lies behind the plane of the gap at any point: the way is safe until it gets behind that plane, where the next
    /// plane is taken. All are taken lower by what counts as touching: nodes below a flat face lie in its plane but for rounding, and
    /// so do those that come under it next.
    pub fn stays_outside(&self, x: &Vector, y: &Vector, touching: f64) -> bool {
        let (first, last) = (at(&self.start, x), at(&self.end, y));
        let (way, mut gone) = (last - first, 0.0);
        for _ in 0..MOST_PLANES {
            let gap = self.solid.gap(&(first + way * gone));
            let (height, rise) = (gap.distance + touching, gap.normal.dot(&way));
            if height < 0.0 {
                return false;
            }
            if height + rise * (1.0 - gone) >= 0.0 {
                return true;
            }
            gone -= height / rise;
        }
        false
    }
}

/// A point in the axes of a body, from its centre.
fn at(body: &Body, x: &Vector) -> Vector {
    pose::into_body(&body.orientation, &(x - body.position))
}

/// (M8) Finds the impulses of all candidates. `body` carries the velocities before contact; `node_mass`: that of a free node, kg.
/// A node of a graded network stands for several of this mass, which move alike: its impulse is that on one of them.
/// `effective_mass` and `impulse` of the candidates are set here.
/// Behind mirror planes the images of a node get the images of its impulse: what they do together to the body is `weight`
/// times the part of one that the planes leave.
pub fn solve(
    candidates: &mut [[f64; CANDIDATE_REALS]],
    body: &Body,
    inertia: &Inertia,
    node_mass: f64,
    symmetry: Symmetry,
) -> Solved {
    finished::<false>(candidates, &mut [], 0.0, body, inertia, node_mass, symmetry)
}

/// The same with friction (M21) of this coefficient. `tangential`: one for each candidate.
pub fn solve_with_friction(
    candidates: &mut [[f64; CANDIDATE_REALS]],
    tangential: &mut [[f64; TANGENTIAL_REALS]],
    coefficient: f64,
    body: &Body,
    inertia: &Inertia,
    node_mass: f64,
    symmetry: Symmetry,
) -> Solved {
    finished::<true>(candidates, tangential, coefficient, body, inertia, node_mass, symmetry)
}

/// Sweeps, and where they do not settle, Newton's method from there.
fn finished<const FRICTION: bool>(
    candidates: &mut [[f64; CANDIDATE_REALS]],
    tangential: &mut [[f64; TANGENTIAL_REALS]],
    coefficient: f64,
    body: &Body,
    inertia: &Inertia,
    node_mass: f64,
    symmetry: Symmetry,
) -> Solved {
    let (solved, settled) = sweeps::<FRICTION>(candidates, tangential, coefficient, body, inertia, node_mass, symmetry);
    if solved.converged {
        return solved;
    }
    let mut newton = Newton { candidates, tangential, coefficient, inertia, node_mass, symmetry, stiff: STIFF };
    let mut solved = newton.finish(solved, settled);
    if !solved.converged {
        solved = scale_back(newton.candidates, newton.tangential, body, inertia, node_mass, solved);
        solved.residual = newton.residual(&solved);
    }
    solved
}

/// The sweeps of both solves: without friction the compiler leaves out what belongs to it. Returns also the change of speed in a sweep below
/// which a solve has settled, m/s.
#[inline(never)] // It must not add to the stack of what follows.
fn sweeps<const FRICTION: bool>(
    candidates: &mut [[f64; CANDIDATE_REALS]],
    tangential: &mut [[f64; TANGENTIAL_REALS]],
    coefficient: f64,
    body: &Body,
    inertia: &Inertia,
    node_mass: f64,
    symmetry: Symmetry,
) -> (Solved, f64) {
    let (push_mask, twist_mask) = (symmetry.force_mask(), symmetry.torque_mask());
    let whole = symmetry == Symmetry::default();
    let alone = |c: &Candidate| whole && c.weight == 1.0;
    let push = |c: &Candidate| {
        if alone(c) { c.normal } else { c.normal.component_mul(&push_mask) * c.images() }
    };
    let twist = |c: &Candidate| {
        if alone(c) { c.arm } else { c.arm.component_mul(&twist_mask) * c.images() }
    };
    let mut velocity = body.velocity;
    let mut rate = body.angular_velocity;
    let inverse_node_mass = 1.0 / node_mass;
    // A body that does not turn, now or by contact (a sphere), needs no arms: what they give is exactly zero.
    let turns = rate != Vector::zeros() || inertia.inverse_moments != Vector::zeros();
    let plain_mass = 1.0 / (inverse_node_mass + inertia.inverse_mass);
    let effective_mass = |c: &Candidate| {
        if !turns && alone(c) {
            return plain_mass;
        }
        let turning = c.arm.dot(&twist(c).component_mul(&inertia.inverse_moments));
        let moving = if whole { c.images() } else { c.normal.dot(&push(c)) };
        let give = if c.is_fixed() { 0.0 } else { inverse_node_mass } + inertia.inverse_mass * moving + turning;
        if give > 0.0 { 1.0 / give } else { 0.0 }
    };
    let closing = |c: &Candidate, velocity: &Vector, rate: &Vector| {
        if turns { c.gap_rate(velocity, rate) } else { c.approach - c.normal.dot(velocity) }
    };
    let (mut fastest, mut farthest, mut most_images, mut supported) = (0.0, 0.0, 0.0, false);
    for (k, slot) in candidates.iter_mut().enumerate() {
        let c = Candidate::read(slot);
        supported |= c.is_fixed();
        most_images = math::max(c.images(), most_images);
        let gap_rate = closing(&c, &velocity, &rate);
        fastest = math::max(math::abs(gap_rate), fastest);
        if turns {
            let arm = c.arm.dot(&c.arm);
            farthest = math::max(arm, farthest);
        }
        if FRICTION && let Some(place) = tangential.get_mut(k) {
            let mut t = Tangential::read(place);
            let own = if c.is_fixed() { 0.0 } else { inverse_node_mass };
            t.begin(inertia, own, symmetry, c.images());
            for (slip, arm) in t.slip(&velocity, &rate).into_iter().zip(t.arms) {
                fastest = math::max(math::abs(slip), fastest);
                farthest = math::max(arm.dot(&arm), farthest);
            }
            t.write(place);
        }
        // Until the solve begins, the place of the mass holds the gap rate.
        let [.., kept, impulse] = slot;
        (*kept, *impulse) = (gap_rate, 0.0);
    }
    // The speeds that a gap rate is the difference of.
    let moving = length(&velocity) + math::sqrt(farthest) * length(&rate);
    let (relative, rounding) = (1e-14 * fastest, ROUNDING * moving);
    let tolerance = node_mass * math::max(relative, rounding);
    // A node whose gap grows is left out, as long as what all changes of the impulses together can do to the body, however they
    // add up, changes the speed of its surface by less than that: it would take no impulse.
    let follows = most_images * (inertia.inverse_mass + farthest * inertia.inverse_moments.max());
    let mut out_of_reach = if FRICTION { f64::INFINITY } else { OUT_OF_REACH * moving };
    // Of what is out of reach the mass is 0, so that no sweep changes it.
    let set_masses = |candidates: &mut [[f64; CANDIDATE_REALS]], out_of_reach: f64| {
        for slot in candidates {
            let c = Candidate::read(slot);
            let [.., mass, _] = slot;
            *mass = if c.effective_mass > out_of_reach { 0.0 } else { effective_mass(&c) };
        }
    };
    set_masses(candidates, out_of_reach);
    let (mut sweeps, mut converged, mut changes) = (0, false, 0.0);
    let most = LEAST_SWEEPS.max(MAX_SWEEPS.min((MAX_UPDATES / candidates.len().max(1)) as u32));
    while sweeps < most && !converged {
        let mut largest_change = 0.0;
        for (k, slot) in candidates.iter_mut().enumerate() {
            let mut c = Candidate::read(slot);
            if !FRICTION && c.effective_mass == 0.0 {
                continue;
            }
            if c.impulse > 0.0 {
                c.approach += if supported && c.is_fixed() { 0.0 } else { c.impulse / node_mass };
            }
            let gap_rate = closing(&c, &velocity, &rate);
            let trial = c.impulse - gap_rate * c.effective_mass;
            let impulse = math::max(trial, 0.0);
            let change = impulse - c.impulse;
            if change != 0.0 {
                velocity -= push(&c) * (change * inertia.inverse_mass);
                if turns {
                    rate -= twist(&c).component_mul(&inertia.inverse_moments) * change;
                }
                let [.., place] = slot;
                *place = impulse;
                let mut size = math::abs(change);
                changes += size;
                if supported && c.is_fixed() {
                    // A change of speed is what counts, and here the mass that changes it is the body's.
                    size *= node_mass / c.effective_mass;
                }
                largest_change = math::max(size, largest_change);
            }
            if FRICTION && let Some(place) = tangential.get_mut(k) {
                let mut t = Tangential::read(place);
                let own = if c.is_fixed() { 0.0 } else { inverse_node_mass };
                let [s0, s1] = t.slip(&velocity, &rate);
                let [p, q] = t.impulse;
                let next = t.next([s0 + p * own, s1 + q * own], coefficient * impulse);
                let change = [next[0] - p, next[1] - q];
                if change != [0.0; 2] {
                    velocity -= t.push(change).component_mul(&push_mask) * (c.images() * inertia.inverse_mass);
                    let twist = t.twist(change).component_mul(&twist_mask) * c.images();
                    rate -= twist.component_mul(&inertia.inverse_moments);
                    t.impulse = next;
                    t.write(place);
                    let mut size = math::max(math::abs(change[0]), math::abs(change[1]));
                    if c.is_fixed() {
                        size *= node_mass / t.effective_mass;
                    }
                    largest_change = math::max(size, largest_change);
                }
            }
        }
        sweeps += 1;
        converged = largest_change <= tolerance;
        let followed = changes * follows < 0.9 * out_of_reach;
        if out_of_reach < f64::INFINITY && !followed {
            // Once more from the start, with all of them.
            (out_of_reach, sweeps, converged) = (f64::INFINITY, 0, false);
            set_masses(candidates, out_of_reach);
            (velocity, rate) = (body.velocity, body.angular_velocity);
            candidates.iter_mut().for_each(|[.., impulse]| *impulse = 0.0);
        }
    }
    if !converged {
        set_masses(candidates, f64::INFINITY);
    }
    let solved = Solved { sweeps, converged, velocity, angular_velocity: rate, residual: 0.0 };
    (solved, tolerance / node_mass)
}

/// Impulses that were given up on, scaled back until they add no energy: a cone holds every part of what it holds.
#[inline(never)] // As above.
fn scale_back(
    candidates: &mut [[f64; CANDIDATE_REALS]],
    tangential: &mut [[f64; TANGENTIAL_REALS]],
    body: &Body,
    inertia: &Inertia,
    node_mass: f64,
    solved: Solved,
) -> Solved {
    let (dv, dw) = (solved.velocity - body.velocity, solved.angular_velocity - body.angular_velocity);
    let (mut before, mut change) = (0.0, 0.0);
    if inertia.inverse_mass > 0.0 {
        change = inertia.mass * dv.dot(&dv) + dw.component_mul(&inertia.moments).dot(&dw);
    }
    for (k, slot) in candidates.iter().enumerate() {
        let c = Candidate::read(slot);
        // With the gap's part of the speed this is an upper bound.
        let mut work = c.impulse * c.gap_rate(&body.velocity, &body.angular_velocity);
        let mut squared = c.impulse * c.impulse;
        if let Some(t) = tangential.get(k).map(Tangential::read) {
            let [p, q] = t.impulse;
            work += t.work(t.slip(&body.velocity, &body.angular_velocity));
            squared += p * p + q * q;
        }
        before += c.images() * work;
        if !c.is_fixed() {
            change += c.images() * squared / node_mass;
        }
    }
    let part = friction::part_without_gain(before, change);
    if part == 1.0 {
        return solved;
    }
    for (k, slot) in candidates.iter_mut().enumerate() {
        friction::scale(slot, tangential.get_mut(k), part);
    }
    let velocity = body.velocity + dv * part;
    let angular_velocity = body.angular_velocity + dw * part;
    Solved { velocity, angular_velocity, ..solved }
}

fn length(v: &Vector) -> f64 {
    math::length([v.x, v.y, v.z])
}

/// What lies under the projectile at t_n.
#[derive(Clone, Copy, Default)]
pub(crate) struct Gathered {
    /// Candidates noted.
    pub count: usize,
    /// Deepest penetration of any, m; 0 if none is inside.
    pub deepest: f64,
    /// Whether the body meets the sheet beyond the fine part of a graded network.
    pub is_beyond_fine: bool,
}

/// Copies the nodes closer than a spacing, the larger one, to the projectile. A prescribed body and a fixed node cannot give way to each other: such
/// nodes are no candidates, and their depth is noted alone. Only rows [first, end) are looked at.
pub(crate) fn gather(system: &mut System<'_>, [first_row, end_row]: [usize; 2]) -> Result<Gathered, Failure> {
    let h = system.scene.sheet.spacing;
    let margin = system.scene.largest_spacing();
    let search = Search::new(&system.solid, &system.state.body, margin, system.instructions);
    let (rise, pile) = (system.directions.front.vertical.rest.spacing, system.model.gap);
    let (nx, chunks) = (system.layout.nodes_x, system.layout.chunks);
    let (unit_speed, dt, layout) = (system.model.unit_speed, system.model.pass_dt, &system.layout);
    let (nodes_x, nodes_y) = (system.scene.sheet.nodes_x, system.scene.sheet.nodes_y);
    let free_body = system.scene.is_free();
    let stands_alone = !layout.has(Feature::Grading) && system.scene.symmetry == Symmetry::default();
    let body = &system.state.body;
    let Blocks { hot, ranges, candidates, tangential, candidate_nodes, runs, columns, lines, .. } = &mut system.blocks;
    let net = Net { columns, lines };
    let near = search.neighbourhood(h);
    let mut slots = candidates.iter_mut().zip(candidate_nodes.iter_mut());
    let (mut count, mut deepest) = (0, 0.0);
    let mut offsets = Offsets { r: [[0.0; CHUNK]; 3], beyond: [0.0; CHUNK] };
    // Offsets are exact: those of a row follow from its first.
    let x0 = rest_offset(0, nodes_x);
    for (j, [low, high, left, right]) in ranges.iter_mut().enumerate().take(end_row).skip(first_row) {
        let (ply, row_of_ply) = layout.ply_and_row(j);
        let y0 = rest_offset(row_of_ply, nodes_y) * rise;
        let y0 = if layout.has(Feature::Grading) { planes::get(net.lines, PLACE, j).unwrap_or(y0) } else { y0 };
        if near.misses_row(y0, range_of([*low, *high])) {
            *left = NOT_KEPT;
            continue;
        }
        let z0 = ply as f64 * pile;
        let run = runs.get(j).copied().unwrap_or([0; 4]);
        let row = planes::row(hot, chunks, j);
        let first = [x0, y0, z0];
        if *left == NOT_KEPT {
            // From here on the sweep keeps it.
            [*left, *right] = spread(row, system.instructions).map(end_of_range);
        }
        let [mut from, end] = near.chunks(x0, net.columns, range_of([*left, *right]), chunks);
        while from < end
            && let Some(c) = near.next(row, net.columns, [from, end], first, &mut offsets)
        {
            from = c + 1;
            let Some(chunk) = row.get(c) else { break };
            let held = meets_runs(&run, [c * CHUNK, from * CHUNK]);
            #[allow(clippy::needless_range_loop)] // The lane is a place in several planes.
            for lane in 0..CHUNK {
                let i = c * CHUNK + lane;
                if offsets.beyond[lane] > 0.0 || i >= nx {
                    continue;
                }
                let r = Vector::new(offsets.r[0][lane], offsets.r[1][lane], offsets.r[2][lane]);
                let Some((gap, normal, arm)) = search.candidate_at(&r) else { continue };
                deepest = math::max(-gap, deepest);
                let fixed = held && in_runs(&run, i);
                if fixed && !free_body {
                    continue;
                }
                let Some((slot, node)) = slots.next() else { return Err(Failure::ContactCapacity) };
                let v = Vector::new(chunk[3][lane], chunk[4][lane], chunk[5][lane]);
                let weight = if stands_alone { 1.0 } else { layout.node_weight(i, j) * net.share(i, j) };
                // With no velocity so far: see `Found`.
                let found = Candidate {
                    displacement: [chunk[0][lane], chunk[1][lane], chunk[2][lane]],
                    normal,
                    arm,
                    weight: if fixed { -weight } else { weight },
                    speed_before: normal.dot(&v) * unit_speed,
                    approach: math::max(gap, 0.0) / dt,
                    effective_mass: 0.0,
                    impulse: 0.0,
                };
                found.write(slot);
                *node = (j * nx + i) as u32;
                if let Some(place) = tangential.get_mut(count) {
                    Tangential::at(&r, &normal, &(v * unit_speed), body).write(place);
                }
                count += 1;
            }
        }
    }
    let is_beyond_fine =
        layout.has(Feature::Grading) && (count > 0 || search.meets_plane()) && search.is_beyond_fine(&system.scene);
    Ok(Gathered { count, deepest, is_beyond_fine })
}

/// Makes candidates of the nodes found, with the velocities that the sweep left them.
#[inline(never)] // It must not add to the stack of the solve.
pub(crate) fn complete_candidates(system: &mut System<'_>, count: usize) {
    let (nx, chunks, unit_speed) = (system.layout.nodes_x, system.layout.chunks, system.model.unit_speed);
    let Blocks { hot, candidates, candidate_nodes, tangential, .. } = &mut system.blocks;
    // They come row by row: one division for each row is enough.
    let (mut start, mut row) = (0, planes::row(hot, chunks, 0));
    let slots = candidates.get_mut(..count).unwrap_or(&mut []);
    let mut places = tangential.iter_mut();
    for (slot, &node) in slots.iter_mut().zip(candidate_nodes.iter()) {
        let node = node as usize;
        let mut i = node.wrapping_sub(start);
        if i >= nx {
            let (column, j) = system.layout.column_and_row(node);
            (i, start, row) = (column, node - column, planes::row(hot, chunks, j));
        }
        let lane = i % CHUNK;
        let Some(chunk) = row.get(i / CHUNK) else { break };
        let v = Vector::new(chunk[3][lane], chunk[4][lane], chunk[5][lane]);
        Found::read(slot).with_velocity(&v, unit_speed).write(slot);
        if let Some(place) = places.next() {
            Tangential::read(place).with_velocity(&(v * unit_speed)).write(place);
        }
    }
}

/// Puts behind the others the candidates that get past an edge of the body, if both go on freely: the plane that a gap is
/// linearised to goes on beyond the edge, and would press nodes that the body never meets. Returns how many are left.
/// `deepest`: what gathering found, m.
#[inline(never)] // As above.
pub(crate) fn let_pass(system: &mut System<'_>, count: usize, deepest: f64) -> usize {
    if !system.solid.feels_torque() {
        // A sphere has no edge.
        return count;
    }
    let body = &system.state.body;
    let touching = TOUCHING * system.scene.sheet.spacing;
    let held_touching = math::max(2.0 * deepest, touching);
    let passage = Passage::new(&system.solid, body, system.model.pass_dt);
    let (mut c, mut kept) = (0, count);
    while c < kept {
        let candidate = system.blocks.candidates.get(c).map(Candidate::read);
        let passes = candidate.is_some_and(|candidate| {
            let pressed = candidate.gap_rate(&body.velocity, &body.angular_velocity) < 0.0;
            let [x, y] = if pressed || candidate.is_fixed() { free_way(system, c) } else { [Vector::zeros(); 2] };
            let waits = candidate.is_fixed() && passage.starts_before_an_edge(&x, held_touching);
            waits || pressed && passage.is_past_an_edge(&x, &y, touching)
        });
        if passes {
            kept -= 1;
            system.blocks.swap_candidates(c, kept);
        } else {
            c += 1;
        }
    }
    kept
}

/// Where a candidate's node is at the pass's start and, without an impulse, at its end, m.
fn free_way(system: &System<'_>, c: usize) -> [Vector; 2] {
    let (Some(slot), Some(&node)) = (system.blocks.candidates.get(c), system.blocks.candidate_nodes.get(c)) else {
        return [Vector::zeros(); 2];
    };
    let (i, j) = system.layout.column_and_row(node as usize);
    let ([x, y, z], [ux, uy, uz]) = (system.rest(i, j), Candidate::read(slot).displacement);
    let (from, way) = (Vector::new(x + ux, y + uy, z + uz), system.free_velocity(i, j));
    [from * system.scene.sheet.spacing, (from + way) * system.scene.sheet.spacing]
}

/// The impulses of the candidates, whose approach is known: of the first `kept`, and of those behind them that the body
/// meets after all, because impulses have changed its rates. `solve_first` finds those of the first so many. Returns how many there are now.
#[inline(never)] // Of plies it must not add to the stack of a single sheet.
pub(crate) fn solve_contact(
    system: &mut System<'_>,
    mut kept: usize,
    count: usize,
    solve_first: impl Fn(&mut System<'_>, usize) -> Solved,
) -> (Solved, usize) {
    for _ in 0..MOST_ROUNDS {
        let solved = solve_first(system, kept);
        if kept == count {
            return (solved, kept);
        }
        let alone = kept;
        kept = meets_after_all(system, &solved, kept, count);
        if kept == alone {
            return (solved, kept);
        }
    }
    // Enough of it: all of them, as if there were no edge.
    (solve_first(system, count), count)
}

/// Takes in those of the candidates from `alone` on that the body meets with the rates that a solve has left it. Returns how many there are now.
#[inline(never)] // It must not add to the stack of the solve.
fn meets_after_all(system: &mut System<'_>, solved: &Solved, alone: usize, count: usize) -> usize {
    let body = Body { velocity: solved.velocity, angular_velocity: solved.angular_velocity, ..system.state.body };
    let touching = TOUCHING * system.scene.sheet.spacing;
    let passage = Passage::new(&system.solid, &body, system.model.pass_dt);
    let held_touching = math::max(2.0 * deepest_support(system, &passage, alone), touching);
    let mut kept = alone;
    for c in alone..count {
        let [x, y] = free_way(system, c);
        let held = system.blocks.candidates.get(c).is_some_and(|slot| Candidate::read(slot).is_fixed());
        if !passage.stays_outside(&x, &y, if held { held_touching } else { touching }) {
            system.blocks.swap_candidates(c, kept);
            kept += 1;
        }
    }
    kept
}

/// Depth at the pass's end of the deepest of the first `kept` candidates that is held, m; 0 if none is inside. Turning has brought the
/// nodes below a flat face so deep; one beside them, no farther away than they are from each other, at most twice as deep.
fn deepest_support(system: &System<'_>, passage: &Passage<'_>, kept: usize) -> f64 {
    let mut deepest = 0.0;
    for (c, slot) in system.blocks.candidates.iter().enumerate().take(kept) {
        if Candidate::read(slot).is_fixed() {
            let [_, y] = free_way(system, c);
            let depth = passage.depth_at_end(&y);
            deepest = math::max(depth, deepest);
        }
    }
    deepest
}

/// The impulses of the first `count` candidates of a single sheet.
pub(crate) fn solve_first(system: &mut System<'_>, count: usize) -> Solved {
    let slots = system.blocks.candidates.get_mut(..count).unwrap_or(&mut []);
    let (body, model, symmetry) = (&system.state.body, &system.model, system.scene.symmetry);
    if !system.layout.has(Feature::Friction) {
        return solve(slots, body, &model.inertia, model.node_mass, symmetry);
    }
    let tangential = system.blocks.tangential.get_mut(..count).unwrap_or(&mut []);
    let coefficient = system.scene.contact.friction;
    solve_with_friction(slots, tangential, coefficient, body, &model.inertia, model.node_mass, symmetry)
}

/// The body's rates after contact, and what the solve took.
pub(crate) fn set_rates(system: &mut System<'_>, solved: &Solved) {
    system.state.body.velocity = solved.velocity;
    system.state.body.angular_velocity = solved.angular_velocity;
    if solved.sweeps as u64 > system.state.sums.most_sweeps {
        system.state.sums.most_sweeps = solved.sweeps as u64;
    }
    if !solved.converged {
        let places = length(&system.state.body.position) + system.model.reach;
        let sums = &mut system.state.sums;
        // Gaps are differences of places: what rounding of these can do to a speed is no lack of convergence.
        sums.unconverged += u64::from(solved.residual > PLACES * places / system.model.pass_dt);
        sums.contact_residual = math::max(solved.residual, sums.contact_residual);
    }
}

/// Moves the touched nodes and sums impulse, angular impulse, work and loss. What a fixed node takes goes to its support,
/// and the work done there, which moves nothing, is lost. Work is impulse times the mean of the rates
/// before and after, for a free and a prescribed body alike: the two then agree to second order.
#[inline(never)] // As above.
pub(crate) fn book_contact(system: &mut System<'_>, count: usize, before: &Body) {
    let body = system.state.body;
    let mean_velocity = (before.velocity + body.velocity) * 0.5;
    let mean_rate = (before.angular_velocity + body.angular_velocity) * 0.5;
    let mut impulse_sum = Vector::zeros();
    let mut arm_sum = Vector::zeros();
    let (mut work, mut loss, mut rubbed, mut held, mut touched) = (0.0, 0.0, 0.0, 0.0, 0);
    let (nx, chunks, implicit) = (system.layout.nodes_x, system.layout.chunks, system.layout.has(Feature::Theta));
    // They come row by row: what a row needs is done once for each.
    let (mut start, mut j, mut share, mut woken) = (0, 0, system.mass_share_of_row(0), usize::MAX);
    for c in 0..count {
        let (Some(slot), Some(&node)) = (system.blocks.candidates.get(c), system.blocks.candidate_nodes.get(c)) else {
            break;
        };
        let [.., impulse] = *slot;
        if impulse <= 0.0 {
            continue;
        }
        let candidate = Candidate::read(slot);
        let normal = candidate.normal;
        let mut i = (node as usize).wrapping_sub(start);
        if i >= nx {
            (i, j) = system.layout.column_and_row(node as usize);
            (start, share) = (node as usize - i, system.mass_share_of_row(j));
        }
        let mut push = normal * (impulse / (system.model.unit_impulse * share));
        let rubbing = system.blocks.tangential.get(c).map(Tangential::read);
        if let Some(t) = &rubbing {
            push += t.push(t.impulse) * (1.0 / (system.model.unit_impulse * share));
            impulse_sum -= t.push(t.impulse) * candidate.images();
            arm_sum -= t.twist(t.impulse) * candidate.images();
            let done = t.work(t.surface_speed(&mean_velocity, &mean_rate)) * candidate.images();
            work += done;
            rubbed += done;
        }
        if let Some(flags) = system.blocks.flags.get_mut(node as usize / 32) {
            *flags |= 1 << (node % 32);
        }
        let body_speed = normal.dot(&mean_velocity) + candidate.arm.dot(&mean_rate);
        // What all images of the node give; without mirror planes it is the node's own.
        let given = impulse * candidate.images();
        impulse_sum -= normal * given;
        arm_sum -= candidate.arm * given;
        work += given * body_speed;
        touched += 1;
        if candidate.is_fixed() {
            system.load_support(i, j, &(push * share));
            loss += given * body_speed;
            let along = rubbing.map_or(0.0, |t| t.work(t.surface_speed(&mean_velocity, &mean_rate)));
            held += given * body_speed + along * candidate.images();
            continue;
        }
        let lane = i % CHUNK;
        let Some(chunk) = planes::row_mut(system.blocks.hot, chunks, j).get_mut(i / CHUNK) else { break };
        let v = [chunk[3][lane] + push.x, chunk[4][lane] + push.y, chunk[5][lane] + push.z];
        let mut u = [chunk[0][lane], chunk[1][lane], chunk[2][lane]];
        if !implicit {
            let from = candidate.displacement;
            u = [from[0] + v[0], from[1] + v[1], from[2] + v[2]];
        } // The theta rule has put the node in its place already.
        (chunk[0][lane], chunk[1][lane], chunk[2][lane]) = (u[0], u[1], u[2]);
        (chunk[3][lane], chunk[4][lane], chunk[5][lane]) = (v[0], v[1], v[2]);
        widen(system, j, u);
        if woken != j {
            system.wake(j);
            woken = j;
        }
        // From t_{n-1/2} to t_{n+1/2}; with the theta rule's velocities, all at t_n, across the impulse alone.
        let speed_after = if implicit {
            candidate.speed_before + normal.dot(&push) * system.model.unit_speed
        } else {
            normal.dot(&Vector::from(v)) * system.model.unit_speed
        };
        loss -= given * (0.5 * (candidate.speed_before + speed_after) - body_speed);
        if let Some(t) = &rubbing {
            let [p, q] = t.along(&(Vector::from(v) * system.model.unit_speed));
            let [p_before, q_before] = t.speed_before;
            rubbed -= t.work([0.5 * (p_before + p), 0.5 * (q_before + q)]) * candidate.images();
        }
        if system.layout.has(Feature::Viscosity) {
            // The sweep has booked the viscous push as if the node went on with the velocity before the impulse.
            let pushes = planes::row(system.blocks.pushes, system.layout.chunks, j);
            let viscous = [0, 1, 2].map(|plane| planes::get(pushes, plane, i).unwrap_or(0.0));
            let crossed = 0.5 * push.dot(&Vector::from(viscous)) * system.layout.node_weight(i, j);
            system.state.sums.viscous -= crossed * (system.model.unit_energy * share);
        }
    }
    system.state.sums.contacts = touched;
    if touched == 0 {
        return;
    }
    impulse_sum.component_mul_assign(&system.scene.symmetry.force_mask());
    arm_sum.component_mul_assign(&system.scene.symmetry.torque_mask());
    if system.state.watch.first.is_none() {
        let energy = before.kinetic_energy(&system.model.inertia);
        system.state.watch.note_contact(system.state.step, before, energy);
    }
    let sums = &mut system.state.sums;
    sums.impulses += touched;
    sums.impulse += impulse_sum;
    sums.window += impulse_sum;
    if system.model.inertia.turns {
        sums.angular_impulse += pose::out_of_body(&before.orientation, &arm_sum);
    }
    sums.work += work;
    sums.loss += loss;
    sums.friction += rubbed;
    sums.support_work += held;
}

/// Notes that a row holds a node with this displacement.
fn widen(system: &mut System<'_>, j: usize, [x, y, _]: [f64; 3]) {
    if let Some([low, high, left, right]) = system.blocks.ranges.get_mut(j) {
        widen_range([low, high], y);
        if *left != NOT_KEPT {
            widen_range([left, right], x);
        }
    }
}

fn widen_range([low, high]: [&mut u32; 2], displacement: f64) {
    let end = end_of_range(displacement);
    if f32::from_bits(end) < f32::from_bits(*low) {
        *low = end;
    } else if f32::from_bits(end) > f32::from_bits(*high) {
        *high = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::pose;
    use crate::body::projectile::Motion;
    use crate::scene::parts::{Projectile, Scene, Shape};
    use std::vec::Vec;

    fn sphere() -> (Solid, Inertia, Body) {
        let scene = Scene::sheet_3in_sphere();
        let solid = Solid::of(&scene.projectile);
        let inertia = Inertia::of(&solid, scene.projectile.mass, true);
        let motion = Motion {
            position: [0.0; 3],
            velocity: [0.0, 0.0, 100.0],
            orientation: [1.0, 0.0, 0.0, 0.0],
            angular_velocity: [0.0; 3],
        };
        (solid, inertia, Body::of(&motion))
    }

    fn slot(normal: Vector, approach: f64) -> [f64; CANDIDATE_REALS] {
        let mut slot = [0.0; CANDIDATE_REALS];
        let candidate = Candidate { normal, approach, weight: 1.0, ..Candidate::read(&slot) };
        candidate.write(&mut slot);
        slot
    }

    #[test]
    fn one_node_head_on_sticks_to_the_body() {
        let (_, inertia, body) = sphere();
        let mass = 6.52e-8;
        let mut slots = [slot(Vector::new(0.0, 0.0, 1.0), 0.0)];
        let solved = solve(&mut slots, &body, &inertia, mass, Symmetry::default());
        let expected = 100.0 * inertia.mass / (inertia.mass + mass);
        assert!(solved.converged);
        assert!((solved.velocity.z / expected - 1.0).abs() < 1e-14);
        assert!((slots[0][CANDIDATE_REALS - 1] - mass * expected).abs() < 1e-12 * mass * expected);
    }

    #[test]
    fn a_receding_node_feels_nothing() {
        let (_, inertia, body) = sphere();
        let mut slots = [slot(Vector::new(0.0, 0.0, 1.0), 150.0)];
        let solved = solve(&mut slots, &body, &inertia, 6.52e-8, Symmetry::default());
        assert_eq!(solved.velocity, body.velocity);
        assert_eq!(slots[0][CANDIDATE_REALS - 1], 0.0);
    }

    #[test]
    fn complementarity_of_many_nodes() {
        let (_, inertia, body) = sphere();
        let mut slots: [[f64; CANDIDATE_REALS]; 40] = core::array::from_fn(|k| {
            let angle = 0.02 * k as f64;
            slot(Vector::new(math::sin(angle), 0.0, math::cos(angle)), 3.0 * k as f64)
        });
        let mass = 6.52e-8;
        let solved = solve(&mut slots, &body, &inertia, mass, Symmetry::default());
        assert!(solved.converged && solved.sweeps < 10);
        for c in slots.iter().map(Candidate::read) {
            let gap_rate = c.approach + c.impulse / mass - c.normal.dot(&solved.velocity);
            assert!(c.impulse >= 0.0 && gap_rate > -1e-10);
            assert!(c.impulse == 0.0 || gap_rate.abs() < 1e-10);
        }
    }

    /// Numbers from -1 to 1 without visible order.
    fn number(k: u64) -> f64 {
        2.0 * (crate::ground::random::splitmix64(k) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    }

    #[test]
    fn the_box_of_the_search_ends_a_spacing_beyond_the_body() {
        let (solid, _, mut body) = sphere();
        body.position = Vector::new(0.0, 0.2, 0.0);
        let h = 7.26e-4;
        let search = Search::new(&solid, &body, h, InstructionSet::Scalar);
        let near = search.neighbourhood(h);
        for (share, inside) in [(0.999, true), (1.0, true), (1.001, false)] {
            let end = share * (solid.radius() + h);
            for (y0, range) in [(end, [0.0, 1.0]), (end + h, [-h, 0.0]), (-end, [-1.0, 0.0]), (-end - h, [0.0, h])] {
                assert_eq!(!near.misses_row((0.2 + y0) / h, range.map(|u| u / h)), inside);
            }
        }
        assert!(!near.misses_row(0.2 / h, [0.0; 2]));
        // Up to a spacing away a node is a candidate, along the axes of the box too.
        for way in [Vector::x(), Vector::y(), Vector::z()] {
            for (away, found) in [(1.0 - 1e-11, true), (1.0 + 1e-8, false)] {
                let x = body.position + way * (solid.radius() + away * h);
                assert_eq!(search.candidate(&x).is_some(), found, "{way:?}");
            }
        }
    }

    #[test]
    fn candidates_are_the_points_nearer_than_a_spacing() {
        let (margin, q) = (1e-3, pose::normalised([0.8, 0.3, -0.2, 0.5]));
        // A rotation matrix has the turned axes as its columns.
        let axes = [Vector::x(), Vector::y(), Vector::z()].map(|axis| pose::rotate(&q, &axis));
        let turned = |v: &Vector| axes[0] * v.x + axes[1] * v.y + axes[2] * v.z;
        for shape in [Shape::Sphere, Shape::Cylinder, Shape::HemisphericalCylinder, Shape::Box] {
            let projectile =
                Projectile { shape, radius: 5e-3, length: 0.02, ..Scene::sheet_10in_cylinder().projectile };
            let solid = Solid::of(&Projectile { size: [0.01, 0.014, 0.02], ..projectile });
            let body = Body { position: Vector::new(0.01, -0.02, 0.03), orientation: q, ..sphere().2 };
            let search = Search::new(&solid, &body, margin, InstructionSet::Scalar);
            let (mut found, size) = (0, 1.2 * (solid.reach() + margin));
            for k in 0..20_000 {
                let r = Vector::new(number(3 * k), number(3 * k + 1), number(3 * k + 2)) * size;
                let gap = solid.gap(&Vector::new(axes[0].dot(&r), axes[1].dot(&r), axes[2].dot(&r)));
                let candidate = search.candidate(&(body.position + r));
                // Beyond the corner of a box its planes are nearer than the box: what is out of reach does not count.
                let near = gap.distance < margin && r.norm() < solid.reach() + margin;
                assert_eq!(candidate.is_some(), near, "{shape:?} {gap:?}");
                if let Some((distance, normal, arm)) = candidate {
                    found += 1;
                    let outward = turned(&gap.normal);
                    assert!((distance - gap.distance).abs() < 1e-16 && (normal - outward).norm() < 1e-13);
                    // The moment of a unit force along the normal.
                    assert!((turned(&arm) - r.cross(&outward)).norm() < 1e-15);
                }
            }
            assert!(found > 1000, "{found}");
        }
    }

    /// Before an edge of a box both its planes are nearer than the edge itself, which is more than a spacing away.
    #[test]
    fn a_point_farther_than_a_spacing_from_an_edge_is_no_candidate() {
        let (h, n) = (1e-3, math::sqrt(0.5));
        let projectile = Projectile { shape: Shape::Box, size: [0.01; 3], ..Scene::sheet_10in_cylinder().projectile };
        let solid = Solid::of(&projectile);
        // An eighth of a turn about one axis points an edge along the two others.
        for (about, axes) in [(Vector::x(), [1, 2]), (Vector::y(), [2, 0]), (Vector::z(), [0, 1])] {
            let (half_cosine, half_sine) = (math::sqrt(0.5 * (1.0 + n)), math::sqrt(0.5 * (1.0 - n)));
            let turn = about * half_sine;
            let q = pose::normalised([half_cosine, turn.x, turn.y, turn.z]);
            let body = Body { position: Vector::new(0.02, -0.01, 0.03), orientation: q, ..sphere().2 };
            let search = Search::new(&solid, &body, h, InstructionSet::Scalar);
            for (k, sign) in axes.into_iter().flat_map(|k| [(k, 1.0), (k, -1.0)]) {
                for (away, found) in [(0.9, true), (1.1, false), (1.3, false)] {
                    let mut r = Vector::zeros();
                    r[k] = sign * (0.01 * n + away * h);
                    let planes = solid.gap(&pose::into_body(&q, &r)).distance;
                    assert!((planes - n * away * h).abs() < 1e-16 && r.norm() < solid.reach());
                    assert_eq!(search.candidate(&(body.position + r)).is_some(), found, "{about:?} {k} {sign} {away}");
                }
            }
        }
    }

    #[test]
    fn the_next_chunk_is_the_first_with_a_node_in_the_box_and_the_ball() {
        let (solid, _, mut body) = sphere();
        let (h, first) = (1e-3, [-40.0, 2.0, 0.0]);
        body.position = Vector::new(0.0123, -0.004, 0.002);
        let half = (solid.radius() + h) / h;
        let (mut hits, mut misses, mut left_out) = (0, 0, 0);
        for k in 0..400 {
            let row: Vec<Chunk<HOT_PLANES>> = (0..10)
                .map(|c| {
                    core::array::from_fn(|plane| {
                        core::array::from_fn(|i| {
                            [3.0, 40.0, 40.0, 0.0][plane.min(3)]
                                * number(((k * 10 + c) * 8 + i as u64) * 8 + plane as u64)
                        })
                    })
                })
                .collect();
            // With the slack of the search a node has to be well inside or outside for this to be certain; all of them are.
            let inside = |c: usize| -> [bool; CHUNK] {
                core::array::from_fn(|i| {
                    let x = [first[0] + (c * CHUNK + i) as f64 + row[c][0][i], first[1] + row[c][1][i], row[c][2][i]];
                    let r: [f64; 3] = core::array::from_fn(|k| x[k] - body.position[k] / h);
                    r.iter().map(|x| x * x).sum::<f64>() <= half * half
                })
            };
            let set = InstructionSet::Scalar;
            let range = spread(&row, set);
            // The same of a graded network whose columns are as far from each other.
            let mut columns = [[[0.0; CHUNK]; LINE_PLANES]; 10];
            for (i, place) in columns.iter_mut().flat_map(|planes| &mut planes[PLACE]).enumerate() {
                *place = first[0] + i as f64;
            }
            for columns in [&[], &columns[..]] {
                let search = Search::new(&solid, &body, h, set);
                let [start, end] = search.neighbourhood(h).chunks(first[0], columns, range, row.len());
                for c in (0..10).filter(|c| !(start..end).contains(c)) {
                    left_out += 1;
                    assert_eq!(inside(c), [false; CHUNK]);
                }
            }
            for from in 0..=10 {
                let expected = (from..10).find(|&c| inside(c) != [false; CHUNK]);
                if expected.is_some() {
                    hits += 1
                } else {
                    misses += 1
                }
                for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
                    let search = Search::new(&solid, &body, h, set);
                    let mut offsets = Offsets { r: [[0.0; CHUNK]; 3], beyond: [0.0; CHUNK] };
                    let found = search.neighbourhood(h).next(&row, &[], [from, 10], first, &mut offsets);
                    assert_eq!(found, expected, "{set:?}");
                    let Some(c) = found else { continue };
                    assert_eq!(offsets.beyond.map(|x| x <= 0.0), inside(c));
                    let near = (0..CHUNK).filter(|&i| offsets.beyond[i] <= 0.0);
                    for (i, k) in near.flat_map(|i| [(i, 0), (i, 1), (i, 2)]) {
                        let rest = [first[0] + (c * CHUNK + i) as f64, first[1], first[2]];
                        assert_eq!(offsets.r[k][i], (rest[k] + row[c][k][i]) * h - body.position[k], "{set:?}");
                    }
                    assert_eq!(spread(&row, set), range);
                }
            }
        }
        assert!(hits > 200 && misses > 200 && left_out > 400, "{hits} {misses} {left_out}");
    }

    /// A turning rod of the mass of `nodes` nodes of a gram.
    fn rod(nodes: f64, movable: bool) -> (Inertia, Body) {
        let solid = Solid::of(&Scene::sheet_10in_cylinder().projectile);
        let body = Body {
            velocity: Vector::new(3.0, -2.0, 80.0),
            angular_velocity: Vector::new(400.0, -700.0, 250.0),
            ..sphere().2
        };
        (Inertia::of(&solid, nodes * NODE, movable), body)
    }
    const NODE: f64 = 1e-3;

    fn armed(normal: Vector, arm: Vector, weight: f64, approach: f64) -> [f64; CANDIDATE_REALS] {
        let mut slot = [0.0; CANDIDATE_REALS];
        let candidate = Candidate { normal, arm, weight, approach, ..Candidate::read(&slot) };
        candidate.write(&mut slot);
        slot
    }

    fn close(value: f64, expected: f64, relative: f64) {
        assert!((value - expected).abs() <= relative * expected.abs(), "{value:e} is not {expected:e}");
    }

    #[test]
    fn one_node_off_the_axis_takes_the_impulse_of_rigid_body_mechanics() {
        let (normal, arm) = (Vector::new(0.48, -0.6, 0.64), Vector::new(4e-3, -0.011, 7e-3));
        for (movable, turning) in [(true, true), (true, false), (false, true), (false, false)] {
            let (inertia, mut body) = rod(5.0, movable);
            if !turning {
                body.angular_velocity = Vector::zeros();
            }
            let mut slots = [armed(normal, arm, 1.0, -7.0)];
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            let closing = normal.dot(&body.velocity) + arm.dot(&body.angular_velocity) + 7.0;
            let (mass, moments) = (5.0 * NODE, inertia.moments);
            let give = if movable { 1.0 / mass + arm.component_mul(&arm).component_div(&moments).sum() } else { 0.0 };
            let impulse = closing / (1.0 / NODE + give);
            let found = Candidate::read(&slots[0]);
            assert!(solved.converged && solved.sweeps <= 3 && closing > 0.0);
            close(found.impulse, impulse, 1e-13);
            close(found.effective_mass, 1.0 / (1.0 / NODE + give), 1e-14);
            let taken = if movable { impulse } else { 0.0 };
            assert!((solved.velocity - (body.velocity - normal * (taken / mass))).norm() < 1e-11);
            let rate = body.angular_velocity - arm.component_div(&moments) * taken;
            assert!((solved.angular_velocity - rate).norm() < 1e-9);
        }
    }

    #[test]
    fn a_node_and_its_images_are_one_node_with_mirror_planes() {
        // Across the plane x = 0 a normal changes the sign of x, an arm, as every moment, those of y and z.
        let [across_x, across_y] = [Vector::new(-1.0, 1.0, 1.0), Vector::new(1.0, -1.0, 1.0)];
        for (mirror_x, mirror_y) in [(true, false), (false, true), (true, true)] {
            let symmetry = Symmetry { mirror_x, mirror_y };
            let (inertia, mut body) = rod(3.0, true);
            body.velocity.component_mul_assign(&symmetry.force_mask());
            body.angular_velocity.component_mul_assign(&symmetry.torque_mask());
            let nodes = |k: u64| {
                let normal = Vector::new(0.5 * number(4 * k), 0.5 * number(4 * k + 1), 1.0).normalize();
                (normal, Vector::new(0.01, 0.008, 0.0) * number(4 * k + 2), 50.0 * number(4 * k + 3))
            };
            let (mut whole, mut part) = (Vec::new(), Vec::new());
            for (normal, arm, approach) in (0..6).map(nodes) {
                let mut images = Vec::from([(normal, arm)]);
                for (mirrored, across) in [(mirror_x, across_x), (mirror_y, across_y)] {
                    if mirrored {
                        let more = images.iter().map(|(n, a)| (n.component_mul(&across), -a.component_mul(&across)));
                        images.extend(more.collect::<Vec<_>>());
                    }
                }
                part.push(armed(normal, arm, images.len() as f64, approach));
                whole.extend(images.iter().map(|(normal, arm)| armed(*normal, *arm, 1.0, approach)));
            }
            // Alone, a node and its images are solved at once.
            let mut alone = [part[0]];
            assert!(solve(&mut alone, &body, &inertia, NODE, symmetry).sweeps <= 3);
            let of_whole = solve(&mut whole, &body, &inertia, NODE, Symmetry::default());
            let of_part = solve(&mut part, &body, &inertia, NODE, symmetry);
            assert!(of_whole.converged && of_part.converged);
            assert!((of_whole.velocity - of_part.velocity).norm() < 1e-9);
            assert!((of_whole.angular_velocity - of_part.angular_velocity).norm() < 1e-7);
            let images = whole.len() / part.len();
            assert!(part.iter().any(|slot| slot[CANDIDATE_REALS - 1] > 0.0));
            for (image, slot) in whole.iter().enumerate() {
                let (impulse, expected) = (slot[CANDIDATE_REALS - 1], part[image / images][CANDIDATE_REALS - 1]);
                assert!((impulse - expected).abs() < 1e-10 * NODE * 80.0 + 1e-14);
            }
        }
    }

    /// Twenty nodes of one normal, their speeds along it within `spread`, m/s, before a body of the mass of `share` nodes.
    fn crowd(share: f64, spread: f64) -> (Vec<[f64; CANDIDATE_REALS]>, Solved, Body, Inertia) {
        let (inertia, mut body) = rod(share, true);
        body.angular_velocity = Vector::zeros();
        let mut slots: Vec<_> = (0..20).map(|k| armed(Vector::z(), Vector::zeros(), 1.0, spread * number(k))).collect();
        let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
        (slots, solved, body, inertia)
    }

    #[test]
    fn a_fixed_node_does_not_give_way() {
        let (normal, arm) = (Vector::new(0.48, -0.6, 0.64), Vector::new(4e-3, -0.011, 7e-3));
        let fixed = |slot: [f64; CANDIDATE_REALS]| {
            let mut held = slot;
            Candidate { weight: -1.0, ..Candidate::read(&slot) }.write(&mut held);
            held
        };
        for movable in [true, false] {
            let (inertia, body) = rod(5.0, movable);
            let mut slots = [fixed(armed(normal, arm, 1.0, 7.0)), armed(-normal, -arm, 1.0, 0.0)];
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            let surface = |v: &Vector, w: &Vector| normal.dot(v) + arm.dot(w);
            let closing = surface(&body.velocity, &body.angular_velocity) - 7.0;
            let give = arm.component_mul(&arm).component_div(&inertia.moments).sum() + 1.0 / (5.0 * NODE);
            let found = Candidate::read(&slots[0]);
            if movable {
                close(found.impulse, closing / give, 1e-13);
                close(surface(&solved.velocity, &solved.angular_velocity), 7.0, 1e-13);
            } else {
                // Two that do not give way: no impulse makes sense, and none is found.
                assert_eq!((found.impulse, found.effective_mass, solved.velocity), (0.0, 0.0, body.velocity));
            }
            assert!(solved.converged && solved.sweeps <= 3 && closing > 0.0);
        }
    }

    #[test]
    fn complementarity_on_a_body_that_turns() {
        let (mut pushed, mut let_go, mut given_up) = (0, 0, 0);
        for k in 0..3000 {
            let draw = |m: u64| number(64 * k + m);
            let (inertia, body) = rod(math::exp(3.0 * draw(60)) * 3.0, true);
            let mut slots: [_; 6] = core::array::from_fn(|node| {
                let draw = |m: u64| draw(8 * node as u64 + m);
                let normal = Vector::new(draw(0), draw(1), 1.0 + draw(2)).normalize();
                let arm = Vector::new(0.02 * draw(3), 0.02 * draw(4), 0.006 * draw(5));
                armed(normal, arm, 1.0, 60.0 * draw(6))
            });
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            if !solved.converged {
                given_up += 1;
                continue;
            }
            for c in slots.iter().map(Candidate::read) {
                let surface = c.normal.dot(&solved.velocity) + c.arm.dot(&solved.angular_velocity);
                let gap_rate = c.approach + c.impulse / NODE - surface;
                assert!(c.impulse >= 0.0 && gap_rate > -1e-10, "{k} {gap_rate:e}");
                assert!(c.impulse == 0.0 || gap_rate < 1e-10, "{k} {gap_rate:e}");
                pushed += usize::from(c.impulse > 0.0);
                let_go += usize::from(c.impulse == 0.0);
            }
        }
        assert!(pushed > 1000 && let_go > 1000 && given_up < 10, "{pushed} {let_go} {given_up}");
    }

    /// A light body that a node throws back at ten times its speed meets a node that went away too fast for it before.
    #[test]
    fn a_body_that_is_thrown_back_meets_what_was_out_of_its_reach() {
        let (inertia, mut body) = rod(0.01, true);
        (body.velocity, body.angular_velocity) = (Vector::z(), Vector::zeros());
        let up = armed(Vector::z(), Vector::zeros(), 1.0, -10.0);
        let far = armed(-Vector::z(), Vector::zeros(), 1.0, 3.0);
        for mut slots in [[up, far], [far, up]] {
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            assert!(
                solved.velocity.z < -2.5 && slots.iter().all(|slot| Candidate::read(slot).impulse > 0.0),
                "{solved:?}"
            );
        }
    }

    #[test]
    fn nodes_out_of_reach_change_no_bit() {
        for k in 0..200 {
            let draw = |m: u64| number(100 * k + m);
            // A light body gives way so far that all are solved, a heavy one does not.
            let heavy = k % 2 == 1;
            let (inertia, body) = rod(if heavy { 1e5 } else { 100.0 }, true);
            // The first one sets the tolerance: it is the farthest.
            let mut near: Vec<_> = Vec::from([armed(Vector::x(), Vector::zeros(), 1.0, 1e4)]);
            let mut all = near.clone();
            for node in 0..12 {
                let draw = |m: u64| draw(8 * node + m);
                let normal = Vector::new(draw(0), draw(1), 1.0 + draw(2)).normalize();
                let arm = Vector::new(0.02 * draw(3), 0.02 * draw(4), 0.006 * draw(5));
                near.push(armed(normal, arm, 1.0, 60.0 * draw(6)));
                // Its gap grows at 5 m/s, or faster.
                let surface = normal.dot(&body.velocity) + arm.dot(&body.angular_velocity);
                let leaving =
                    if heavy { armed(normal, arm, 1.0, surface + 5.0) } else { armed(-normal, arm, 1.0, 900.0) };
                all.extend([leaving, near[near.len() - 1]]);
            }
            let alone = solve(&mut near, &body, &inertia, NODE, Symmetry::default());
            let among = solve(&mut all, &body, &inertia, NODE, Symmetry::default());
            assert_eq!(alone, among);
            let left_out = all.iter().filter(|slot| Candidate::read(slot).effective_mass == 0.0).count();
            assert!(!heavy || left_out >= 13, "{left_out}");
            let pushed = |slots: &[[f64; CANDIDATE_REALS]]| -> Vec<f64> {
                slots.iter().map(|slot| Candidate::read(slot).impulse).filter(|impulse| *impulse > 0.0).collect()
            };
            assert_eq!(pushed(&near), pushed(&all));
        }
    }

    #[test]
    fn a_heavy_body_takes_a_crowd_along() {
        let (slots, solved, body, inertia) = crowd(100.0, 30.0);
        assert!(solved.converged);
        // All stick: one velocity, that of the common momentum.
        let momentum: f64 = slots.iter().map(|slot| NODE * Candidate::read(slot).approach).sum();
        let common = (inertia.mass * body.velocity.z + momentum) / (inertia.mass + 20.0 * NODE);
        close(solved.velocity.z, common, 1e-13);
        for c in slots.iter().map(Candidate::read) {
            assert!((c.approach + c.impulse / NODE - common).abs() < 1e-11);
        }
    }

    /// A body of a hundredth of a node's mass among twenty nodes: sweeps pass its velocity on from node to node for long.
    #[test]
    fn what_sweeps_do_not_finish_newtons_method_does() {
        let (slots, solved, body, inertia) = crowd(0.01, 0.01);
        assert!(solved.converged && solved.sweeps > MAX_SWEEPS && solved.sweeps < MAX_SWEEPS + 20, "{solved:?}");
        assert!(solved.residual <= 1e-13 * body.velocity.z);
        let energy = |speed: f64, nodes: f64| 0.5 * inertia.mass * speed * speed + 0.5 * NODE * nodes;
        let nodes = |after: f64| -> f64 {
            let speed = |c: Candidate| c.approach + after * c.impulse / NODE;
            slots.iter().map(|slot| speed(Candidate::read(slot)) * speed(Candidate::read(slot))).sum()
        };
        assert!(energy(solved.velocity.z, nodes(1.0)) <= energy(body.velocity.z, nodes(0.0)));
    }

    /// Fixed nodes whose normals differ by little: each sweep leaves cos^2 of their angle of an error. A body that moves against both stops along
    /// them, and keeps what is across them.
    #[test]
    fn a_body_in_a_narrow_wedge_of_fixed_nodes_stops() {
        for angle in [0.3, 1e-2, 1e-4] {
            let (inertia, mut body) = rod(5.0, true);
            (body.velocity, body.angular_velocity) = (Vector::new(2.0, -7.0, 40.0), Vector::zeros());
            let held =
                |angle: f64| armed(Vector::new(math::sin(angle), 0.0, math::cos(angle)), Vector::zeros(), -1.0, 0.0);
            // Between them the body is pressed from both sides along x.
            let mut slots = [held(angle), held(-angle)];
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            assert!(solved.converged && solved.sweeps <= MAX_SWEEPS + 100, "{angle}: {solved:?}");
            let [left, right] = slots.map(|slot| Candidate::read(&slot));
            let surfaces = [&left, &right].map(|c| c.normal.dot(&solved.velocity));
            let presses = 40.0 * math::sin(angle) > 2.0 * math::cos(angle);
            assert!(surfaces.iter().all(|speed| *speed < 1e-9), "{angle}: {surfaces:?}");
            if presses {
                assert!(solved.velocity.x.abs() < 1e-8 && solved.velocity.z.abs() < 1e-9, "{angle}: {solved:?}");
            }
            assert!((solved.velocity.y + 7.0).abs() < 1e-12 && left.impulse > 0.0);
        }
    }

    /// Nodes that already move as the body's surface does, but for rounding: nothing is left to be solved.
    #[test]
    fn what_rounding_leaves_is_no_lack_of_convergence() {
        for (k, nodes) in (0..400).zip([1, 4, 20, 100].into_iter().cycle()) {
            let draw = |m: u64| number(10_000 * k + m);
            let (mut inertia, mut body) = rod(10.0 * f64::from(nodes), true);
            body.velocity = Vector::new(draw(0), draw(1), draw(2)) * 100.0;
            body.angular_velocity = Vector::new(draw(3), draw(4), draw(5)) * 3000.0;
            if k % 3 == 0 {
                inertia = rod(1e5 * f64::from(nodes), true).0;
            }
            let riding = |node: u64| {
                let draw = |m: u64| draw(8 * node + m);
                let normal = Vector::new(draw(0), draw(1), 1.0 + draw(2)).normalize();
                let arm = Vector::new(6e-3 * draw(3), 6e-3 * draw(4), 0.019).cross(&normal);
                armed(normal, arm, 1.0, normal.dot(&body.velocity) + arm.dot(&body.angular_velocity))
            };
            let mut slots: Vec<_> = (1..=nodes as u64).map(riding).collect();
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            assert!(solved.converged && solved.sweeps <= 3, "{k}: {} sweeps", solved.sweeps);
            assert!((solved.velocity - body.velocity).norm() <= 1e-13 * body.velocity.norm());
        }
    }

    #[test]
    fn one_node_on_a_sphere_is_solved_at_once() {
        // A sphere of three nodes' mass that does not turn; alone, and with its three images behind two planes: then the body
        // takes the impulse along z four times over.
        let (solid, _, body) = sphere();
        let inertia = Inertia::of(&solid, 3.0 * NODE, true);
        let normal = Vector::new(0.48, -0.6, 0.64);
        let planes = Symmetry { mirror_x: true, mirror_y: true };
        for (symmetry, images, moved) in
            [(Symmetry::default(), 1.0, normal), (planes, 4.0, Vector::new(0.0, 0.0, 0.64))]
        {
            let mut slots = [armed(normal, Vector::zeros(), images, -7.0)];
            let solved = solve(&mut slots, &body, &inertia, NODE, symmetry);
            let give = 1.0 / NODE + images * normal.dot(&moved) / (3.0 * NODE);
            let impulse = (0.64 * 100.0 + 7.0) / give;
            let found = Candidate::read(&slots[0]);
            assert!(solved.converged && solved.sweeps <= 2, "{solved:?}");
            close(found.effective_mass, 1.0 / give, 1e-14);
            close(found.impulse, impulse, 1e-13);
            assert!((solved.velocity - (body.velocity - moved * (images * impulse / (3.0 * NODE)))).norm() < 1e-12);
        }
    }
}
