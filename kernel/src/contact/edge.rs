//! Nodes that the body gets past beside an edge within a step.
//!
//! Method: the plane that a gap is linearised to goes on beyond an edge, and would press nodes that the body
//! never meets. Such nodes are set aside, and come back into the solve if the rates that it leaves the body
//! make them meet ([`EdgeTest`]); fixed ones that are before two faces wait for the impulses on the others.
//! Limits: a node whose way takes more planes than a few counts as met; after some rounds all are, as if
//! there were no edge.
//! Reference: J. E. Kelley, J. Soc. Indust. Appl. Math. 8 (1960) 703 (cutting planes).

use crate::body::pose::{self, Vector};
use crate::body::projectile::{self, Body, Twist};
use crate::body::shape::Solid;
use crate::contact::candidate::Solved;
use crate::ground::math;
use crate::memory::arrays::Contacts;
use crate::memory::network::Network;
use crate::memory::records::Candidate;

/// Solves of a step in which the body may meet more of the nodes that were set aside.
const MOST_ROUNDS: u32 = 8;

/// Planes that are tried along the way of a node past a body; a way that needs more counts as a hit.
const MOST_PLANES: u32 = 8;

/// A node no deeper than this part of the spacing touches, rounding aside.
pub(crate) const TOUCHING: f64 = 1e-9;

/// The body at both ends of a step in which it keeps its rates, for nodes that may get past one of its edges.
pub struct EdgeTest<'s> {
    solid: &'s Solid,
    start: Body,
    end: Body,
}

impl<'s> EdgeTest<'s> {
    /// Test of a body with these rates, over `dt`, s.
    pub fn new(solid: &'s Solid, body: &Body, dt: f64) -> EdgeTest<'s> {
        let position = body.position + body.velocity * dt;
        let orientation = projectile::cayley_turn(&body.orientation, &body.angular_velocity, dt);
        EdgeTest { solid, start: *body, end: Body { position, orientation, ..*body } }
    }

    /// Whether a node that goes straight from `x` to `y` gets past an edge, although the plane that its gap
    /// is linearised to at `x` would press it.
    ///
    /// A face that is curved (by no radius below R), or an edge that cloth rounds with half its thickness,
    /// ends as far above its own plane as way^2/2R: what presses by less is of second order, as what turning
    /// bends the way by, and no edge; nor is what rounding presses into a face of thick cloth.
    pub fn is_past_an_edge(&self, x: &Vector, y: &Vector, touching: f64) -> bool {
        let (first, last) = (at(&self.start, x), at(&self.end, y));
        if self.solid.gap(&last).distance < -touching {
            return false;
        }
        let (from, way) = (self.solid.gap(&first), last - first);
        let depth = -(from.distance + from.normal.dot(&way));
        depth > self.solid.least_depth(touching)
            && depth * (2.0 * self.solid.least_curvature_radius()) > way.dot(&way)
            && self.stays_outside(x, y, touching)
    }

    /// Whether a node at `x` is before two faces that meet at an edge: impulses on other nodes may decide
    /// which of them it meets.
    pub fn starts_before_an_edge(&self, x: &Vector, touching: f64) -> bool {
        self.solid.is_before_an_edge(&at(&self.start, x), -touching)
    }

    /// Depth of a node at `y` at the end, m; negative outside.
    fn depth_at_end(&self, y: &Vector) -> f64 {
        -self.solid.gap(&at(&self.end, y)).distance
    }

    /// Whether a node that goes straight from `x` to `y` stays outside. Down to the depth `touching`, m, it
    /// only touches.
    ///
    /// The whole body lies behind the plane of the gap at any point: the way is safe until it gets behind
    /// that plane, where the next plane is taken. All are taken lower by what counts as touching: nodes below
    /// a flat face lie in its plane but for rounding, and so do those that come under it next.
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

/// Candidates of a step that may get past an edge of the body.
pub(crate) struct Edges<'s, 'a> {
    pub network: &'s Network<'a>,
    pub solid: &'s Solid,
    /// The body, with its velocity before contact.
    pub body: &'s Body,
}

impl Edges<'_, '_> {
    /// Depth of a node that only touches, m.
    fn touching(&self) -> f64 {
        TOUCHING * self.network.scene.sheet.spacing
    }

    /// Puts after the others the candidates that get past an edge of the body, if both go on freely: the
    /// plane that a gap is linearised to goes on beyond the edge, and would press nodes that the body never
    /// meets. Returns how many are left. `deepest`: what gathering found, m.
    pub fn set_aside(&self, contacts: &mut Contacts<'_>, count: usize, deepest: f64) -> usize {
        // A sphere has no edge.
        if !self.solid.feels_torque() {
            return count;
        }
        let (touching, twist) = (self.touching(), self.body.twist());
        let held_touching = math::max(2.0 * deepest, touching);
        let test = EdgeTest::new(self.solid, self.body, self.network.model.limits.dt);
        let (mut c, mut kept) = (0, count);
        while c < kept {
            let passes = contacts.candidates.get(c).is_some_and(|candidate| {
                let pressed = candidate.gap_rate(&twist) < 0.0;
                let is_tested = pressed || candidate.is_fixed();
                let [x, y] = if is_tested { self.free_way(candidate) } else { [Vector::zeros(); 2] };
                let waits = candidate.is_fixed() && test.starts_before_an_edge(&x, held_touching);
                waits || pressed && test.is_past_an_edge(&x, &y, touching)
            });
            if passes {
                kept -= 1;
                contacts.swap(c, kept);
            } else {
                c += 1;
            }
        }
        kept
    }

    /// Places of a candidate's node at the step's start and, without an impulse, at its end, m.
    fn free_way(&self, candidate: &Candidate) -> [Vector; 2] {
        let (i, j) = self.network.layout.column_and_row(candidate.node as usize);
        let ([x, y, z], [ux, uy, uz]) = (self.network.rest(i, j), candidate.displacement);
        let (from, way) = (Vector::new(x + ux, y + uy, z + uz), self.network.free_velocity(i, j));
        [from, from + way].map(|place| place * self.network.scene.sheet.spacing)
    }

    /// The impulses of the candidates, whose free gap rate is known: of the first `kept`, and of those after
    /// them that the body meets after all, because impulses have changed its rates. `solve_first` finds those
    /// of the first so many. Returns how many there are now.
    pub fn solve_contact(
        &self,
        contacts: &mut Contacts<'_>,
        mut kept: usize,
        count: usize,
        solve_first: impl Fn(&mut Contacts<'_>, usize) -> Solved,
    ) -> (Solved, usize) {
        for _ in 0..MOST_ROUNDS {
            let (solved, alone) = (solve_first(contacts, kept), kept);
            if alone < count {
                kept = self.meets_after_all(contacts, &solved, alone, count);
            }
            if kept == alone {
                return (solved, kept);
            }
        }
        // Enough of it: all of them, as if there were no edge.
        (solve_first(contacts, count), count)
    }

    /// Takes in those of the candidates from `alone` on that the body meets with the rates that a solve has
    /// left it. Returns how many there are now.
    #[inline(never)]
    fn meets_after_all(&self, contacts: &mut Contacts<'_>, solved: &Solved, alone: usize, count: usize) -> usize {
        let Twist { velocity, angular_velocity } = solved.twist;
        let (body, touching) = (Body { velocity, angular_velocity, ..*self.body }, self.touching());
        let test = EdgeTest::new(self.solid, &body, self.network.model.limits.dt);
        let solved_ones = contacts.candidates.get(..alone).unwrap_or_default();
        let held_touching = math::max(2.0 * self.deepest_support(solved_ones, &test), touching);
        let mut kept = alone;
        for c in alone..count {
            let Some(candidate) = contacts.candidates.get(c) else { break };
            let [x, y] = self.free_way(candidate);
            if !test.stays_outside(&x, &y, if candidate.is_fixed() { held_touching } else { touching }) {
                contacts.swap(c, kept);
                kept += 1;
            }
        }
        kept
    }

    /// Depth at the step's end of the deepest of some candidates that is held, m; 0 if none is inside.
    /// Turning has brought the nodes below a flat face so deep; one beside them, no farther away than they
    /// are from each other, at most twice as deep.
    fn deepest_support(&self, candidates: &[Candidate], test: &EdgeTest<'_>) -> f64 {
        let held = candidates.iter().filter(|candidate| candidate.is_fixed());
        held.map(|candidate| test.depth_at_end(&self.free_way(candidate)[1])).fold(0.0, |a, b| math::max(b, a))
    }
}
