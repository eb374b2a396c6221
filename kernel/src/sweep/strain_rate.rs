//! Dependence on the rate of strain within the sweep: stiffness of each segment at its mean rate, and what
//! relaxation and rupture dissipate.
//!
//! Method: the law of `yarn/rate.rs` at the time of the step. Most segments are slower than the reference
//! rate or faster than the highest, where the logarithm is constant; a lane group with a rate within takes
//! the exact law of each segment.
//! Limits: velocity Verlet.
//! Reference: docs/model.md, "Rate of strain".

use crate::ground::lanes::Lane;
use crate::ground::planes::Axis;
use crate::sheet::direction::PlyDirections;
use crate::sweep::segments::{Dissipation, Fall, Segments, Yarns};
use crate::yarn::rate::{RateLaw, RateSplats, Rates};

/// Dependence of the segments of a row on the rate of strain.
pub struct StrainRate<'a> {
    /// Laws along x and along y, at no time.
    laws: [&'a RateLaw; 2],
    /// Time of the pass, s.
    time: f64,
    /// Their constants at that time.
    constants: [RateSplats; 2],
    /// [`Rates::relaxing`].
    relaxing: f64,
}

impl<'a> StrainRate<'a> {
    /// Dependence of segments in these directions; None without.
    #[inline(always)]
    pub fn of(PlyDirections { horizontal, vertical, .. }: PlyDirections<'a>, rates: &Rates) -> Option<StrainRate<'a>> {
        if !horizontal.rate.depends() {
            return None;
        }
        let (laws, time) = ([&horizontal.rate, &vertical.rate], rates.time);
        let constants = [laws[0].at(time).splats(), laws[1].at(time).splats()];
        Some(StrainRate { laws, time, constants, relaxing: rates.relaxing })
    }

    /// Stiffening of a lane group of segments along x and of one along y, one by one.
    #[cold]
    fn stiffenings<L: Lane>(&self, q: [L; 2]) -> [L; 2] {
        let mut groups = [L::ZEROS; 2];
        for ((group, law), q) in groups.iter_mut().zip(&self.laws).zip(q) {
            q.store(group);
            let law = law.at(self.time);
            group.as_mut().iter_mut().for_each(|q| *q = law.stiffening(*q));
        }
        [L::load(&groups[0]), L::load(&groups[1])]
    }

    /// Factor of what [`StrainRate::act`] returns.
    #[inline(always)]
    pub fn relaxing<L: Lane>(&self) -> L {
        L::splat(self.relaxing)
    }

    /// Changes the stiffness of a lane group. Returns the energy dissipated by relaxation over
    /// [`StrainRate::relaxing`], along x and along y.
    #[inline(always)]
    pub fn act<L: Lane>(&self, segments: &mut Segments<L>) -> [L; 2] {
        let (Segments { q, before, stiffness, .. }, [of_x, of_y]) = (*segments, &self.constants);
        let (of_x, of_y) = (of_x.lanes::<L>(), of_y.lanes::<L>());
        let beyond = [of_x.beyond(q[0]), of_y.beyond(q[1])];
        // Before the damage of this step.
        let relaxing = [of_x.relaxing(before[0], beyond[0]), of_y.relaxing(before[1], beyond[1])];
        let is_within = of_x.within(beyond[0]).max(of_y.within(beyond[1])).any_above(L::splat(0.0));
        let factors =
            if is_within { self.stiffenings(q) } else { [of_x.stiffening(beyond[0]), of_y.stiffening(beyond[1])] };
        segments.relax([stiffness[0].mul(factors[0]), stiffness[1].mul(factors[1])]);
        relaxing
    }

    /// Adds what rupture dissipates beyond the law of the reference rate, which the balance counts
    /// (`step/energy.rs`).
    #[inline(always)]
    pub fn note_fall(&self, fall: &Fall<'_>, yarns: &Yarns<'_>, dissipation: &mut Dissipation) {
        fall.each(|column, axis, q, [before, now]| {
            let law = self.laws[axis as usize].at(self.time);
            let [along, upwards] = yarns.net.parts(column);
            let multiplicity = match axis {
                Axis::Horizontal => along * yarns.line.segment_weight(column),
                Axis::Vertical => dissipation.share * upwards * yarns.line.node_weight(column),
            };
            let dissipated = yarns.dissipated(axis, column, now) - yarns.dissipated(axis, column, before);
            dissipation.by_rupture += 4.0 * multiplicity * law.excess(q, law.seen_at(q)) * dissipated;
        });
    }
}
