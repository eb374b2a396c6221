//! Where nodes lie along a line of the fabric: at every crossing, or, of a graded network, at some
//! (`grading.rs`).
//!
//! Method: within the fine part every crossing is a node. Outwards follow bars of 2, 4, 8 ... segments; the
//! last one takes what is left to the edge, if that is less than one and a half of its size.
//! Reference: docs/model.md, "Graded networks".

use crate::ground::math;
use crate::ground::planes::Axis;
use crate::scene::features::Feature;
use crate::scene::parts::Scene;
use core::ops::Range;

/// Offset of a node from the middle of its line, in node spacings; exactly antisymmetric.
pub fn rest_offset(index: usize, nodes: u32) -> f64 {
    f64::from(index as u32) - 0.5 * (nodes as f64 - 1.0)
}

/// Which crossings of one line of the fabric are nodes of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Places {
    /// Crossings of the fabric along the line, at least 2.
    pub crossings: u32,
    /// First and last crossing of the fine part, in which every crossing is a node.
    pub fine: [u32; 2],
    /// Bars of one size before the next.
    run: u32,
    /// Segments of the longest bar; at most 1: no grading.
    largest: u32,
}

impl Places {
    /// Nodes along a direction: a row of them, or a column.
    pub fn of(scene: &Scene, axis: Axis) -> Places {
        let (grading, h, direction) = (&scene.sheet.grading, scene.spacing(axis), axis as usize);
        let crossings = match axis {
            Axis::Horizontal => scene.sheet.nodes_x,
            Axis::Vertical => scene.sheet.nodes_y,
        };
        let last = crossings.saturating_sub(1);
        let (centre, half) = (grading.centre[direction], grading.half_width[direction]);
        // Counted from both ends by one formula, so that a fine part in the middle is symmetric to the bit.
        let before = |centre: f64| (math::max(0.5 * f64::from(last) + (centre - half) / h, 0.0) as u32).min(last);
        let first = before(centre);
        let end = last - before(-centre);
        Places { crossings, fine: [first, end], run: grading.run, largest: grading.largest }
    }

    /// Along x and along y.
    pub fn both(scene: &Scene) -> [Places; 2] {
        [Axis::Horizontal, Axis::Vertical].map(|axis| Places::of(scene, axis))
    }

    /// Number of nodes.
    pub fn nodes(&self) -> u32 {
        let [first, last] = self.fine;
        if self.largest <= 1 || !Feature::Grading.is_built() {
            return self.crossings;
        }
        let bars =
            self.outwards(first, u32::MAX).0 + self.outwards(self.crossings.saturating_sub(1 + last), u32::MAX).0;
        bars + (last - first) + 1
    }

    /// The crossing at which node k lies.
    pub fn crossing(&self, k: u32) -> u32 {
        let [first, last] = self.fine;
        if self.largest <= 1 {
            return k;
        }
        let before = self.outwards(first, u32::MAX).0;
        if k < before {
            first - self.outwards(first, before - k).1
        } else if k - before <= last - first {
            first + (k - before)
        } else {
            last + self.outwards(self.crossings.saturating_sub(1 + last), k - before - (last - first)).1
        }
    }

    /// The number of bars from the fine part outwards to an edge `distance` segments away, at most `most`,
    /// and how far they reach. Bars of 2, 4, ... segments; the last takes what is left, if that is less than
    /// one and a half.
    fn outwards(&self, distance: u32, most: u32) -> (u32, u32) {
        let (mut left, mut bars, mut size) = (distance, 0, 2);
        while bars < most && 2 * left >= 3 * size {
            let fit = (2 * left - 3 * size) / (2 * size).max(1) + 1;
            let wanted = if size < self.largest { fit.min(self.run) } else { fit };
            let taken = wanted.min(most - bars);
            (bars, left) = (bars + taken, left - taken * size);
            size = if size < self.largest { 2 * size } else { size };
        }
        if bars < most && left > 0 {
            (bars, left) = (bars + 1, 0);
        }
        (bars, distance - left)
    }

    /// Offset of node k from the middle of the line, in node spacings of the fabric; exactly antisymmetric.
    pub fn offset(&self, k: usize) -> f64 {
        rest_offset(self.crossing(k as u32) as usize, self.crossings)
    }

    /// The first node beyond the middle of the line.
    pub fn upper(&self) -> usize {
        self.first(|k| 2 * self.crossing(k) >= self.crossings) as usize
    }

    /// Nodes whose offset from the middle of the line lies between two, in node spacings.
    pub(crate) fn within(&self, low: f64, high: f64) -> Range<usize> {
        self.first(|k| self.offset(k as usize) >= low) as usize..self.first(|k| self.offset(k as usize) > high) as usize
    }

    /// The first node of a property that all after it have, too: found in halves, for a line may be long.
    pub(crate) fn first(&self, has: impl Fn(u32) -> bool) -> u32 {
        let (mut first, mut end) = (0, self.nodes());
        while first < end {
            let middle = first + (end - first) / 2;
            if has(middle) {
                end = middle;
            } else {
                first = middle + 1;
            }
        }
        first
    }

    /// Segments before and after node k; 1 beyond the ends of the line.
    pub(crate) fn around(&self, k: usize) -> [u32; 2] {
        let (k, here) = (k as u32, self.crossing(k as u32));
        let before = k.checked_sub(1).map_or(1, |k| here - self.crossing(k));
        let after = if here + 1 < self.crossings { self.crossing(k + 1) - here } else { 1 };
        [before, after]
    }

    /// The yarns that run across node k, and the share of each in it: 1, or 1/2 for one midway to the next
    /// node.
    pub(crate) fn yarns(&self, k: usize) -> impl Iterator<Item = (u32, f64)> + use<> {
        let (here, [before, after]) = (self.crossing(k as u32), self.around(k));
        (here - before / 2..=here + after / 2).map(move |yarn| {
            let midway = 2 * here == 2 * yarn + before || 2 * yarn == 2 * here + after;
            (yarn, if midway { 0.5 } else { 1.0 })
        })
    }
}

impl Scene {
    /// Nodes of the network along x and y: those of the fabric, without grading.
    pub fn network(&self) -> [u32; 2] {
        Places::both(self).map(|places| places.nodes())
    }
}
