//! What is kept of a candidate in a stack in addition, as it lies in the scratch block.

use crate::memory::layout::{PACE_REALS, SPRING_REALS, TOUCH_REALS};

/// What the plies do to a candidate.
#[derive(Clone, Copy, Default)]
pub(super) struct Touch {
    /// Velocity along z that impulses give its node, m/s.
    pub lift: f64,
    /// Compliance in addition to its column's along z, 1/kg.
    pub give: f64,
    /// 1/m of its node, 1/kg.
    pub own: f64,
    /// Normal impulse before the column was solved last, N s.
    pub last: f64,
    /// For the candidate that leads a column, whether impulses along the surface have changed since the
    /// column was solved.
    pub stale: bool,
    /// What the body gives way by across the normal, with friction, 1/kg.
    pub slide: f64,
    /// The outward normal in the axes of its column.
    pub normal: [f64; 3],
}

impl Touch {
    pub fn read(slot: &[f64; TOUCH_REALS]) -> Touch {
        let [lift, give, own, last, stale, slide, x, y, z] = *slot;
        Touch { lift, give, own, last, stale: stale != 0.0, slide, normal: [x, y, z] }
    }

    pub fn write(&self, slot: &mut [f64; TOUCH_REALS]) {
        let (stale, [x, y, z]) = (f64::from(u8::from(self.stale)), self.normal);
        *slot = [self.lift, self.give, self.own, self.last, stale, self.slide, x, y, z];
    }

    /// Changes the velocity along z alone.
    pub fn set_lift([lift, ..]: &mut [f64; TOUCH_REALS], to: f64) {
        *lift = to;
    }
}

/// No candidate, among the numbers of candidates in the scratch block.
pub(super) const NONE: u32 = u32::MAX;

/// The number of a candidate, unless it is [`NONE`].
pub(super) fn number(c: u32) -> Option<usize> {
    (c != NONE).then_some(c as usize)
}

/// Where a candidate stands among those of its column.
#[derive(Clone, Copy, Default)]
pub(super) struct Link {
    /// The candidate of the same column that comes next.
    pub next: Option<usize>,
    /// The ply of its node.
    pub ply: usize,
    /// Whether it leads the column.
    pub leads: bool,
}

impl Link {
    pub fn read(&[next, ply_and_leads]: &[u32; 2]) -> Link {
        Link { next: number(next), ply: (ply_and_leads / 2) as usize, leads: ply_and_leads % 2 != 0 }
    }

    pub fn write(&self, slot: &mut [u32; 2]) {
        *slot = [self.next.map_or(NONE, |c| c as u32), 2 * self.ply as u32 + u32::from(self.leads)];
    }
}

/// How far a candidate's impulse along the surface goes in a sweep.
#[derive(Clone, Copy)]
pub(super) struct Pace {
    /// A part of the way that it wants to go.
    pub part: f64,
    /// The way that it wanted to go last, N s.
    pub way: [f64; 2],
}

impl Pace {
    /// All the way, before it has gone any.
    pub const FULL: Pace = Pace { part: 1.0, way: [0.0; 2] };

    pub fn read(&[part, p, q]: &[f64; PACE_REALS]) -> Pace {
        Pace { part, way: [p, q] }
    }

    pub fn write(&self, slot: &mut [f64; PACE_REALS]) {
        let [p, q] = self.way;
        *slot = [self.part, p, q];
    }
}

/// Impulses of a candidate along its normal and its tangents, N s, as linear functions of the change of its
/// node's velocity along z, m/s.
#[derive(Clone, Copy, Default)]
pub(super) struct Spring {
    /// Impulses without a change.
    pub base: [f64; 3],
    /// For each m/s, kg.
    pub slope: [f64; 3],
    /// Impulses before a step, N s.
    pub before: [f64; 3],
    /// What it changes of the impulse on its node without a change, and takes of it with one, in units of the
    /// column.
    pub push: f64,
    pub grip: f64,
}

impl Spring {
    pub fn read(&[a, b, c, d, e, f, g, h, i, push, grip]: &[f64; SPRING_REALS]) -> Spring {
        Spring { base: [a, b, c], slope: [d, e, f], before: [g, h, i], push, grip }
    }

    pub fn write(&self, slot: &mut [f64; SPRING_REALS]) {
        let ([a, b, c], [d, e, f], [g, h, i]) = (self.base, self.slope, self.before);
        *slot = [a, b, c, d, e, f, g, h, i, self.push, self.grip];
    }
}
