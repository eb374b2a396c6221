//! The caller's memory, carved into blocks, and the access to nodes and segments in them.

use crate::energy::SegmentView;
use crate::error::{Code, Error};
use crate::layout::{
    self, ALIGN_REALS, CANDIDATE_REALS, CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, ITERATE_PLANES, Layout,
    MARK_PLANES, YARN_PLANES,
};
use crate::pose::Vector;
use crate::sim::{Memory, Sim};
use crate::sweep::{self, Axis, YarnRow};
use crate::symmetry::Line;
use crate::toe::NO_TOE;
use crate::weave;

/// The caller's memory, carved.
pub(crate) struct Blocks<'a> {
    /// Rows of [ux uy uz vx vy vz kh kv].
    pub hot: &'a mut [Chunk<HOT_PLANES>],
    /// Rows of the largest q beyond critical, horizontal and vertical.
    pub history: &'a mut [Chunk<HISTORY_PLANES>],
    /// Rows of [kh kv lambda_h lambda_v] of stochastic yarn.
    pub yarn: &'a mut [Chunk<YARN_PLANES>],
    /// Rows of the toe's marks, horizontal and vertical.
    pub marks: &'a mut [Chunk<MARK_PLANES>],
    /// The theta rule's rows (`theta.rs` names their planes).
    #[cfg_attr(not(feature = "implicit"), expect(dead_code, reason = "empty in a build without the theta rule"))]
    pub iterate: &'a mut [Chunk<ITERATE_PLANES>],
    pub carry: &'a mut [Chunk<CARRY_PLANES>],
    pub kept: &'a mut [[f64; 3]],
    /// Least and greatest y displacement of each row.
    pub ranges: &'a mut [[f64; 2]],
    pub candidates: &'a mut [[f64; CANDIDATE_REALS]],
    /// The theta rule's phi/dt of the candidates.
    pub gap_rates: &'a mut [f64],
    pub runs: &'a mut [[u32; 4]],
    /// Nodes with an impulse since the last outcome test.
    pub flags: &'a mut [u32],
    pub labels: &'a mut [u32],
    pub candidate_nodes: &'a mut [u32],
}

impl<'a> Blocks<'a> {
    /// No memory.
    pub(crate) const fn nothing() -> Blocks<'a> {
        Blocks {
            hot: &mut [],
            history: &mut [],
            yarn: &mut [],
            marks: &mut [],
            iterate: &mut [],
            carry: &mut [],
            kept: &mut [],
            ranges: &mut [],
            candidates: &mut [],
            gap_rates: &mut [],
            runs: &mut [],
            flags: &mut [],
            labels: &mut [],
            candidate_nodes: &mut [],
        }
    }

    /// Cuts memory that has been found to be enough.
    pub(crate) fn carve(memory: Memory<'a>, layout: &Layout) -> Result<Blocks<'a>, Error> {
        let Memory { reals, words } = memory;
        let short = Error::new(Code::ShortBuffer, "memory.reals", reals.len() as f64, layout.reals() as f64);
        let skip = reals.as_ptr().align_offset(8 * ALIGN_REALS);
        let mut reals = Carver(reals);
        let mut words = Carver(words);
        let (nx, ny, row) = (layout.nodes_x, layout.nodes_y, layout.chunks * CHUNK);
        let watched = |count: usize| if layout.track_detachment { count } else { 0 };
        let implicit = |count: usize| if layout.implicit { count } else { 0 };
        let carved = (|| {
            reals.take(skip)?;
            Some(Blocks {
                hot: chunked(reals.take(layout.y.stored() * HOT_PLANES * row)?),
                history: chunked(reals.take(ny * HISTORY_PLANES * row)?),
                yarn: chunked(reals.take(if layout.stochastic { ny * YARN_PLANES * row } else { 0 })?),
                marks: chunked(reals.take(if layout.toe { ny * MARK_PLANES * row } else { 0 })?),
                iterate: chunked(reals.take(implicit(layout.y.stored() * ITERATE_PLANES * row))?),
                carry: chunked(reals.take(CARRY_PLANES * row)?),
                kept: reals.take(3 * nx)?.as_chunks_mut().0,
                ranges: reals.take(2 * ny)?.as_chunks_mut().0,
                candidates: reals.take(layout.candidates * CANDIDATE_REALS)?.as_chunks_mut().0,
                gap_rates: reals.take(implicit(layout.candidates))?,
                runs: words.take(4 * ny)?.as_chunks_mut().0,
                flags: words.take(watched(layout.nodes().div_ceil(32)))?,
                labels: words.take(watched(layout.nodes()))?,
                candidate_nodes: words.take(layout.candidates)?,
            })
        })();
        carved.ok_or(short)
    }
}

impl Blocks<'_> {
    /// Lets two candidates change places.
    pub(crate) fn swap_candidates(&mut self, a: usize, b: usize) {
        swap(self.candidates, a, b);
        swap(self.candidate_nodes, a, b);
        swap(self.gap_rates, a, b);
    }
}

/// Lets two items change places, where both are.
fn swap<T>(items: &mut [T], a: usize, b: usize) {
    if a < items.len() && b < items.len() {
        items.swap(a, b);
    }
}

/// Cuts pieces off the front of a slice.
struct Carver<'a, T>(&'a mut [T]);

impl<'a, T> Carver<'a, T> {
    fn take(&mut self, count: usize) -> Option<&'a mut [T]> {
        let (piece, rest) = core::mem::take(&mut self.0).split_at_mut_checked(count)?;
        self.0 = rest;
        Some(piece)
    }
}

/// Numbers as chunks of P planes.
fn chunked<const P: usize>(reals: &mut [f64]) -> &mut [Chunk<P>] {
    reals.as_chunks_mut().0.as_chunks_mut().0
}
/// Whether column i lies in one of a row's fixed runs.
pub(crate) fn in_runs(run: &[u32; 4], i: usize) -> bool {
    let i = i as u32;
    (run[0] <= i && i < run[1]) || (run[2] <= i && i < run[3])
}

impl Sim<'_> {
    // ---- Nodes and segments

    /// Rest place of a node in spacings.
    pub(crate) fn rest(&self, i: usize, j: usize) -> [f64; 2] {
        [weave::rest_offset(i, self.scene.sheet.nodes_x), weave::rest_offset(j, self.scene.sheet.nodes_y)]
    }

    /// Position at t_n in the sheet's frame, m.
    pub(crate) fn position(&self, i: usize, j: usize) -> Vector {
        let (u, _) = self.node(i, j);
        let (rest, h) = (self.rest(i, j), self.scene.sheet.spacing);
        Vector::new((rest[0] + u[0]) * h, (rest[1] + u[1]) * h, u[2] * h)
    }

    /// Displacement (spacings) and velocity (spacings per step) of a node.
    /// Behind a mirror plane: of its image.
    pub(crate) fn node(&self, i: usize, j: usize) -> ([f64; 3], [f64; 3]) {
        let ((i, turn_x), (j, turn_y)) = (self.layout.x.node(i), self.layout.y.node(j));
        let row = layout::row(self.blocks.hot, self.layout.chunks, j);
        let at = |plane: usize, turn: bool| {
            let value = layout::get(row, plane, i).unwrap_or(0.0);
            if turn { -value } else { value }
        };
        ([at(0, turn_x), at(1, turn_y), at(2, false)], [at(3, turn_x), at(4, turn_y), at(5, false)])
    }

    pub(crate) fn set_node(&mut self, i: usize, j: usize, u: [f64; 3], v: [f64; 3]) {
        let row = layout::row_mut(self.blocks.hot, self.layout.chunks, j);
        for (plane, value) in u.into_iter().chain(v).enumerate() {
            if let Some(slot) = layout::get_mut(row, plane, i) {
                *slot = value;
            }
        }
    }

    pub(crate) fn is_fixed(&self, i: usize, j: usize) -> bool {
        self.blocks.runs.get(j).is_some_and(|run| in_runs(run, i))
    }

    /// The segment that starts at node (i, j), if there is one.
    pub(crate) fn segment(&self, axis: Axis, i: usize, j: usize) -> Option<SegmentView> {
        let chunks = self.layout.chunks;
        let (i2, j2, exists) = match axis {
            Axis::Horizontal => (i + 1, j, i < self.layout.x.segments() && j < self.layout.nodes_y),
            Axis::Vertical => (i, j + 1, i < self.layout.nodes_x && j < self.layout.y.segments()),
        };
        if !exists {
            return None;
        }
        let ((u1, v1), (u2, v2)) = (self.node(i, j), self.node(i2, j2));
        let d = [u2[0] - u1[0], u2[1] - u1[1], u2[2] - u1[2]];
        let dv = [v2[0] - v1[0], v2[1] - v1[1], v2[2] - v1[2]];
        let (undamaged, damage_rate) = self.yarn_row(j).constants(axis, i);
        Some(SegmentView {
            axis,
            stiffness: layout::get(layout::row(self.blocks.hot, chunks, j), 6 + axis as usize, i)?,
            undamaged,
            damage_rate,
            history: layout::get(layout::row(self.blocks.history, chunks, j), axis as usize, i)?,
            mark: layout::get(layout::row(self.blocks.marks, chunks, j), axis as usize, i).unwrap_or(NO_TOE),
            d,
            // The theta rule's state is synchronous: its audit looks at t_n alone.
            d_before: if self.layout.implicit { d } else { [d[0] - dv[0], d[1] - dv[1], d[2] - dv[2]] },
        })
    }

    pub(crate) fn yarn_row(&self, j: usize) -> YarnRow<'_> {
        if self.layout.stochastic {
            YarnRow::Stochastic(layout::row(self.blocks.yarn, self.layout.chunks, j))
        } else {
            YarnRow::Uniform { stiffness: self.model.mean_stiffness, damage_rate: self.model.mean_damage_rate }
        }
    }

    /// Change of velocity per step that the yarns give a node at t_n, with damage up to t_n; nothing is committed.
    /// The same expressions in the same order as the sweep.
    pub(crate) fn acceleration(&self, i: usize, j: usize) -> [f64; 3] {
        let force = |axis: Axis, i: Option<usize>, j: Option<usize>| -> [f64; 3] {
            let (Some(i), Some(j)) = (i, j) else { return [0.0; 3] };
            let Some(segment) = self.segment(axis, i, j) else { return [0.0; 3] };
            let q = segment.twice_strain();
            let stiffness = if self.model.law.is_damaging(q, segment.history) {
                self.model.law.alpha(segment.damage_rate, q) * segment.undamaged
            } else {
                segment.stiffness
            };
            let stiffness = stiffness * self.model.toe.factor(q, segment.mark);
            segment.force(stiffness, q)
        };
        let right = force(Axis::Horizontal, Some(i), Some(j));
        let left = force(Axis::Horizontal, i.checked_sub(1), Some(j));
        let up = force(Axis::Vertical, Some(i), Some(j));
        let down = force(Axis::Vertical, Some(i), j.checked_sub(1));
        [
            sweep::node_sum(right[0], left[0], up[0], down[0]),
            sweep::node_sum(right[1], left[1], up[1], down[1]),
            sweep::node_sum(right[2], left[2], up[2], down[2]),
        ]
    }

    // ---- Filling the blocks

    /// Yarn constants and fixed runs.
    pub(crate) fn fill_model(&mut self) -> Result<(), Error> {
        for (j, run) in self.blocks.runs.iter_mut().enumerate() {
            let [[a, b], [c, d]] = weave::fixed_runs(&self.scene, j);
            *run = [a, b, c, d].map(|column| column.min(self.layout.nodes_x as u32));
        }
        if !self.layout.stochastic {
            return Ok(());
        }
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let (nodes_x, nodes_y) = (self.scene.sheet.nodes_x, self.scene.sheet.nodes_y);
        self.blocks.yarn.fill([[0.0; CHUNK]; YARN_PLANES]);
        for j in 0..ny {
            let row = layout::row_mut(self.blocks.yarn, chunks, j);
            for i in 0..nx {
                let horizontal = (i + 1 < nx).then(|| weave::horizontal_number(nodes_x, i, j));
                let vertical = (j + 1 < ny).then(|| weave::vertical_number(nodes_x, nodes_y, i, j));
                for (axis, number) in [horizontal, vertical].into_iter().enumerate() {
                    let Some(number) = number else { continue };
                    let segment = self.scene.draw_segment(number)?;
                    if let Some(slot) = layout::get_mut(row, axis, i) {
                        *slot = segment.modulus / self.model.modulus_per_stiffness;
                    }
                    if let Some(slot) = layout::get_mut(row, axis + 2, i) {
                        *slot = segment.damage_rate;
                    }
                }
            }
        }
        Ok(())
    }

    /// Sheet flat, at rest and whole.
    pub(crate) fn clear_state(&mut self) {
        self.blocks.hot.fill([[0.0; CHUNK]; HOT_PLANES]);
        self.blocks.history.fill([[0.0; CHUNK]; HISTORY_PLANES]);
        self.blocks.flags.fill(0);
        self.clear_marks();
        self.rebuild_derived();
    }

    /// Everything that follows from displacements, velocities and histories: stiffness planes, failed segments, row ranges,
    /// awake rows. Clears a failure.
    pub(crate) fn rebuild_derived(&mut self) {
        self.refill(|_, _| true);
    }

    /// [`Sim::rebuild_derived`], with every row filled anew before what follows from it, while it is at hand. `fill` returns
    /// whether a history of the row has changed; if not, its stiffnesses are still right.
    pub(crate) fn refill(&mut self, mut fill: impl FnMut(&mut Self, usize) -> bool) {
        self.failure = None;
        let mut awake: Option<[usize; 2]> = None;
        for j in 0..self.layout.nodes_y {
            if fill(self, j) {
                self.rebuild_stiffness(j);
            }
            if self.rebuild_range(j) {
                awake = Some([awake.map_or(j, |[first, _]| first), j + 1]);
            }
        }
        self.failed_segments = self.count_failed();
        self.awake = awake.unwrap_or([0, 0]);
        #[cfg(feature = "implicit")]
        self.start_iterates();
    }

    /// Stiffness of the segments that start in row j, from their histories.
    fn rebuild_stiffness(&mut self, j: usize) {
        let (law, model, chunks) = (self.model.law, &self.model, self.layout.chunks);
        let critical = model.critical;
        let uniform = [model.mean_stiffness, model.mean_stiffness, model.mean_damage_rate, model.mean_damage_rate];
        let uniform = uniform.map(|constant| [constant; CHUNK]);
        let ends = self.ends_of_segments(j);
        let row = layout::row_mut(self.blocks.hot, chunks, j);
        let history = layout::row(self.blocks.history, chunks, j);
        let yarn = layout::row(self.blocks.yarn, chunks, j);
        for (c, (hot, history)) in row.iter_mut().zip(history).enumerate() {
            let yarn = yarn.get(c).unwrap_or(&uniform);
            for k in 0..2 {
                let mut stiffness = yarn[k];
                stiffness.iter_mut().skip(ends[k].saturating_sub(c * CHUNK)).for_each(|none| *none = 0.0);
                let whole = history[k].iter().fold(true, |whole, &largest| whole & (largest <= critical));
                if !whole {
                    for ((stiffness, &damage_rate), &largest) in stiffness.iter_mut().zip(&yarn[k + 2]).zip(&history[k])
                    {
                        *stiffness *= law.alpha(damage_rate, largest);
                    }
                }
                hot[6 + k] = stiffness;
            }
        }
    }

    /// Horizontal and vertical segments of row j start before these columns.
    fn ends_of_segments(&self, j: usize) -> [usize; 2] {
        [self.layout.x.segments(), if j < self.layout.y.segments() { self.layout.nodes_x } else { 0 }]
    }

    /// Least and greatest y displacement of row j. Returns whether a node of it is not exactly at rest in its place.
    fn rebuild_range(&mut self, j: usize) -> bool {
        let row = layout::row(self.blocks.hot, self.layout.chunks, j);
        let (mut low, mut high, mut moved) = ([0.0; CHUNK], [0.0; CHUNK], false);
        let mut take = |chunk: &Chunk<HOT_PLANES>| {
            for ((low, high), &y) in low.iter_mut().zip(&mut high).zip(&chunk[1]) {
                *low = if y < *low { y } else { *low };
                *high = if y > *high { y } else { *high };
            }
            moved |= chunk[..6].iter().flatten().fold(false, |moved, &x| moved | (x != 0.0));
        };
        let (whole, rest) = row.split_at_checked(self.layout.nodes_x / CHUNK).unwrap_or((row, &[]));
        whole.iter().for_each(&mut take);
        if let Some(mut last) = rest.first().copied() {
            // Behind the last node there may be an image.
            for plane in &mut last {
                plane.iter_mut().skip(self.layout.nodes_x % CHUNK).for_each(|place| *place = 0.0);
            }
            take(&last);
        }
        if let Some(range) = self.blocks.ranges.get_mut(j) {
            let least = low.iter().fold(0.0, |least, &y| if y < least { y } else { least });
            *range = [least, high.iter().fold(0.0, |greatest, &y| if y > greatest { y } else { greatest })];
        }
        moved
    }

    /// Failed segments of the whole sheet.
    pub(crate) fn count_failed(&self) -> u64 {
        let mut failed = 0.0;
        for j in 0..self.layout.nodes_y {
            let ends = self.ends_of_segments(j);
            for (c, hot) in layout::row(self.blocks.hot, self.layout.chunks, j).iter().enumerate() {
                for axis in [Axis::Horizontal, Axis::Vertical] {
                    let (stiffness, first) = (&hot[6 + axis as usize], c * CHUNK);
                    if stiffness.iter().fold(true, |live, &k| live & (k != 0.0)) {
                        continue;
                    }
                    let segments = ends[axis as usize].saturating_sub(first);
                    for (lane, _) in stiffness.iter().enumerate().take(segments).filter(|(_, k)| **k == 0.0) {
                        failed += self.layout.segment_weight(axis, first + lane, j);
                    }
                }
            }
        }
        failed as u64
    }

    // ---- Images behind mirror planes

    /// Puts the row of images behind the plane y = 0 in its place.
    pub(crate) fn place_image_row(&mut self) {
        place_image_row(self.blocks.hot, self.layout.chunks, self.layout.y);
    }
}

/// The image column of one row, at rest: only displacements, the first three planes, are read.
pub(crate) fn place_image_column<const P: usize>(row: &mut [Chunk<P>], line: Line) {
    let place = line.modelled();
    let (node, _) = line.node(place);
    for (plane, sign) in [(0, -1.0), (1, 1.0), (2, 1.0)] {
        let value = layout::get(row, plane, node).unwrap_or(0.0);
        if let Some(slot) = layout::get_mut(row, plane, place) {
            *slot = sign * value;
        }
        if let Some(slot) = layout::get_mut(row, 3 + plane, place) {
            *slot = 0.0;
        }
    }
}

/// The image row of a block: only displacements, the first three planes, are read.
pub(crate) fn place_image_row<const P: usize>(block: &mut [Chunk<P>], chunks: usize, line: Line) {
    let place = line.modelled();
    let (node, _) = line.node(place);
    let Some((rows, images)) = block.split_at_mut_checked(place * chunks) else { return };
    for (from, to) in layout::row(rows, chunks, node).iter().zip(layout::row_mut(images, chunks, 0)) {
        to[0] = from[0];
        to[1] = from[1].map(|y| -y);
        to[2] = from[2];
    }
}
