//! The toe: a softened start of the yarn law for segments that have been slack, against the energy creep of a rattling sheet.
//!
//! Method: after the first failure a segment that is found slack, at t_n and at t_{n-1}, is marked for good. With e its
//! Green-Lagrange strain and t = min(e/eps, 1) its stress is alpha E e t (2 - t): it sets in without a jump of stiffness and is
//! the law's own from eps on, so also where it can be damaged. Neither state counts strain energy, so nothing jumps in the
//! ledger at the mark. A mark is the alpha of that moment less 1, from which the energy of later rupture follows.
//! Limits: it changes the yarn law, though only of yarn that has been slack; its tangent modulus is at most 4/3 E, so the step
//! must be smaller by sqrt(3/4). Marking before the first failure would soften yarn that the wave has yet to load.
//! Reference: docs/model.md, "The toe".

use crate::blocks::place_image_column;
use crate::energy::SegmentView;
use crate::lanes::{self, Job, Lane};
use crate::layout::{self, CHUNK, Chunk, HOT_PLANES, MARK_PLANES};
use crate::sim::Sim;
use crate::sweep::{self, Axis};
use crate::yarn;

/// Mark of a segment without a toe; those with one have marks in [-1, 0].
pub const NO_TOE: f64 = 1.0;
/// Every so many steps slack segments are looked for.
pub const MARK_INTERVAL: u64 = 16;

/// A toe of a certain width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toe {
    /// eps, a Green-Lagrange strain; 0 = no toe.
    pub width: f64,
    /// 1/(2 eps): from q = 2 e to e/eps; 0 without toe.
    slope: f64,
}

impl Toe {
    /// No toe.
    pub(crate) const NONE: Toe = Toe { width: 0.0, slope: 0.0 };

    /// A toe of the width eps, or none.
    pub fn of(width: f64) -> Toe {
        Toe { width, slope: if width > 0.0 { 0.5 / width } else { 0.0 } }
    }

    /// What the toe leaves of a segment's stiffness at q = U^2 - 1: t (2 - t), exactly 1 beyond eps and without a mark.
    #[inline(always)]
    pub fn factor<L: Lane>(&self, q: L, mark: L) -> L {
        let t = q.max(L::splat(0.0)).mul(L::splat(self.slope)).max(mark).min(L::splat(1.0));
        t.mul(L::splat(2.0).sub(t))
    }

    /// Strain energy over that without toe, alpha E e^2/2, at a strain e > 0.
    pub fn stored_share(&self, strain: f64) -> f64 {
        if strain < self.width {
            let t = strain / self.width;
            t * (4.0 / 3.0 - 0.5 * t)
        } else {
            let t = self.width / strain;
            1.0 - t * t / 6.0
        }
    }

    /// Energy density, J/m^3, that rupture dissipates less than without toe while alpha falls by `fall`: beyond eps the strain
    /// energy is less by alpha E eps^2/12.
    pub fn saved(&self, modulus: f64, fall: f64) -> f64 {
        modulus * fall * self.width * self.width / 12.0
    }
}

impl SegmentView {
    /// alpha when the segment got its toe, if it has one.
    pub fn alpha_when_marked(&self) -> Option<f64> {
        (self.mark <= 0.0).then_some(1.0 + self.mark)
    }
}

impl Sim<'_> {
    /// No segment has a toe.
    pub(crate) fn clear_marks(&mut self) {
        self.blocks.marks.fill([[NO_TOE; CHUNK]; MARK_PLANES]);
    }

    /// Marks the segments that are slack at t_n and were at t_{n-1}.
    pub(crate) fn mark_slack(&mut self) {
        let [first, end] = self.rows_to_step();
        let (chunks, line) = (self.layout.chunks, self.layout.x);
        if line.mirrored {
            (first..end).for_each(|j| place_image_column(layout::row_mut(self.blocks.hot, chunks, j), line));
        }
        if self.layout.y.mirrored {
            self.place_image_row();
        }
        for j in first..end {
            let mut from = 0;
            while let Some(found) = self.next_slack(j, from) {
                from = found + 1;
                for i in found * CHUNK..from * CHUNK {
                    self.mark_if_slack(Axis::Horizontal, i, j);
                    self.mark_if_slack(Axis::Vertical, i, j);
                }
            }
        }
    }

    /// The next chunk of row j, from one on, with a segment that is slack at t_n and has no mark.
    fn next_slack(&self, j: usize, from: usize) -> Option<usize> {
        let chunks = self.layout.chunks;
        let (row, above) = (layout::row(self.blocks.hot, chunks, j), layout::row(self.blocks.hot, chunks, j + 1));
        lanes::dispatch(
            self.instructions,
            NextSlack { row, above, marks: layout::row(self.blocks.marks, chunks, j), from },
        )
    }

    fn mark_if_slack(&mut self, axis: Axis, i: usize, j: usize) {
        let Some(segment) = self.segment(axis, i, j).filter(|s| s.alpha_when_marked().is_none() && s.is_slack()) else {
            return;
        };
        let alpha = self.model.law.alpha(segment.damage_rate, segment.history);
        let row = layout::row_mut(self.blocks.marks, self.layout.chunks, j);
        if let Some(slot) = layout::get_mut(row, axis as usize, i) {
            *slot = alpha - 1.0;
        }
    }
}

/// The search of [`Sim::next_slack`] as a job for the lanes. Most segments have their mark or are taut.
struct NextSlack<'a> {
    row: &'a [Chunk<HOT_PLANES>],
    above: &'a [Chunk<HOT_PLANES>],
    marks: &'a [Chunk<MARK_PLANES>],
    from: usize,
}

impl Job for NextSlack<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lane>(self) -> Option<usize> {
        let one = L::splat(1.0);
        for (c, (chunk, [mark_h, mark_v])) in self.row.iter().zip(self.marks).enumerate().skip(self.from) {
            let behind = displacement::<L>(self.row.get(c + 1), 0);
            for g in 0..CHUNK / L::WIDTH {
                let here = displacement::<L>(Some(chunk), g);
                let next = if g + 1 < CHUNK / L::WIDTH { displacement(Some(chunk), g + 1) } else { behind };
                let d = [
                    here[0].right_of(next[0]).sub(here[0]),
                    here[1].right_of(next[1]).sub(here[1]),
                    here[2].right_of(next[2]).sub(here[2]),
                ];
                // A mark is 1 or at most 0: U^2 is below it where a segment is slack that has none.
                if L::load(&L::groups(mark_h)[g]).any_above(yarn::twice_strain(d).add(one)) {
                    return Some(c);
                }
                let Some(over) = self.above.get(c) else { continue };
                let over = displacement::<L>(Some(over), g);
                let d = [over[0].sub(here[0]), over[1].sub(here[1]), over[2].sub(here[2])];
                if L::load(&L::groups(mark_v)[g]).any_above(yarn::twice_strain(sweep::vertical_axes(d)).add(one)) {
                    return Some(c);
                }
            }
        }
        None
    }
}

/// Displacement of a lane group of nodes, zero where there is none.
#[inline(always)]
fn displacement<L: Lane>(chunk: Option<&Chunk<HOT_PLANES>>, g: usize) -> [L; 3] {
    match chunk {
        Some([x, y, z, ..]) => [L::load(&L::groups(x)[g]), L::load(&L::groups(y)[g]), L::load(&L::groups(z)[g])],
        None => [L::splat(0.0); 3],
    }
}
