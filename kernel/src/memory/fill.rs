//! Contents of the arrays that follow from the scene, and those that follow from displacements, velocities
//! and histories.
//!
//! Method: both are filled from what they follow from, the first at a start, the others also whenever a state
//! is loaded or set; a step keeps these up to date by itself.

use crate::ground::error::Error;
use crate::ground::math;
use crate::ground::planes::{
    self, Axis, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, STIFFNESS, STRENGTH_PLANES, YARN_PLANES,
};
use crate::ground::ranges::{NOT_KEPT, end_of_range};
use crate::memory::layout::Layout;
use crate::memory::network::Network;
use crate::scene::features::Feature;
use crate::scene::parts::CRITICAL_STRETCH_MAX;
use crate::sheet::clamp::{self, SLID};
use crate::sheet::direction::PlyDirections;
use crate::sheet::energy_error::{self, NO_ENERGY_ERROR};
use crate::sheet::grading;
use crate::sheet::places::Places;
use crate::sheet::ring;
use crate::sheet::weave::{self, in_runs};
use crate::yarn::law::{self, Rest};

impl Network<'_> {
    /// Yarn constants, fixed runs, holds of clamps, constants of columns and rows. Of drawn strength the law
    /// becomes that of the weakest segment.
    pub fn fill_model(&mut self) -> Result<(), Error> {
        let (layout, places) = (self.layout, Places::both(&self.scene));
        for (j, run) in self.arrays.rows.runs.iter_mut().enumerate() {
            let [[a, b], [c, d]] = weave::runs_among(&self.scene, &places, layout.ply_and_row(j).1);
            *run = [a, b, c, d].map(|column| column.min(self.layout.nodes_x as u32));
        }
        if self.layout.has(Feature::Grading) {
            for (ply, line) in self.arrays.columns.chunks_exact_mut(self.layout.chunks.max(1)).enumerate() {
                let PlyDirections { horizontal, vertical, .. } = self.directions.of_ply(ply);
                grading::fill(line, 0, &places[0], &horizontal.rest, ply as f64 * self.model.pitch);
                grading::fill(self.arrays.lines, self.layout.rows_of(ply)[0], &places[1], &vertical.rest, 0.0);
            }
        }
        if let Some(hoop) = ring::Hoop::of(&self.scene) {
            for (ply, line) in self.arrays.columns.chunks_exact_mut(self.layout.chunks.max(1)).enumerate() {
                let along = self.directions.of_ply(ply);
                hoop.fill(line, &along.around(), along.radius_ratio);
            }
        }
        if clamp::at(self.arrays.rows.clamps, 0).is_some() {
            self.fill_holds();
        }
        let (Layout { nodes_x: nx, nodes_y: ny, chunks, .. }, strength) = (layout, layout.has(Feature::Strength));
        if !layout.has_constants() && !strength {
            return Ok(());
        }
        // Front and back fabric.
        let mut weakest = [CRITICAL_STRETCH_MAX; 2];
        self.arrays.rows.yarn.fill([[0.0; CHUNK]; YARN_PLANES]);
        self.arrays.rows.strength.fill([[CRITICAL_STRETCH_MAX; CHUNK]; STRENGTH_PLANES]);
        for j in 0..ny {
            let (ply, row_of_ply) = layout.ply_and_row(j);
            let before = ply as u64 * self.scene.segments_of_ply();
            let (along, back) = (self.directions.of_ply(ply), usize::from(self.directions.is_back(ply)));
            let row = planes::row_mut(self.arrays.rows.yarn, chunks, j);
            let strengths = planes::row_mut(self.arrays.rows.strength, chunks, j);
            let verticals = layout.has_verticals(j);
            for i in 0..nx {
                let exists = [(Axis::Horizontal, i < layout.x.segments()), (Axis::Vertical, verticals)];
                for (axis, _) in exists.into_iter().filter(|(_, exists)| *exists) {
                    let direction = along.along(axis);
                    let bar = self.scene.draw_bar(&places, before, axis, [i, row_of_ply])?;
                    let ratio = if axis == Axis::Horizontal { along.radius_ratio } else { 1.0 };
                    let stiffness = bar.modulus / (direction.modulus_per_stiffness * (bar.segments * ratio));
                    planes::set(row, axis as usize, i, stiffness);
                    planes::set(row, axis as usize + 2, i, bar.damage_rate);
                    planes::set(strengths, axis as usize, i, bar.critical_stretch);
                    weakest[back] = math::min(bar.critical_stretch, weakest[back]);
                }
            }
        }
        if strength {
            let [of_front, of_back] = weakest;
            self.directions.front.weaken(of_front);
            self.directions.back.weaken(of_back);
        }
        Ok(())
    }

    /// Largest impulse of the clamp on every held node in a step.
    fn fill_holds(&mut self) {
        let [nx, ny] = [self.layout.x.nodes as usize, self.layout.y.nodes as usize];
        let dt = self.model.limits.dt;
        let unit = self.model.unit_impulse / dt;
        let runs_of = |j: usize| self.arrays.rows.runs.get(j).copied().unwrap_or([0; 4]);
        for j in 0..self.layout.nodes_y {
            let ((ply, row), run) = (self.layout.ply_and_row(j), runs_of(j));
            let first = self.layout.rows_of(ply)[0];
            let whole = f64::from(self.scene.sheet.plies) * self.scene.attachment.hold / (unit * self.mass_share(ply));
            for columns in [[run[0], run[1]], [run[2], run[3]]] {
                for i in columns[0]..columns[1] {
                    // Nodes of the same column that the same disc holds.
                    let upper = row >= self.layout.upper;
                    let same = |other: usize| {
                        (other >= self.layout.upper) == upper && in_runs(&runs_of(first + other), i as usize)
                    };
                    let of_column = (0..self.layout.y.modelled()).filter(|&other| same(other)).count();
                    let net = self.net(ply);
                    let [across, up] = [net.column_share(i as usize), net.row_share(j)];
                    let yarns = clamp::yarns_ending(
                        &self.scene,
                        [i as usize, row],
                        [nx, ny],
                        (columns[1] - columns[0]) as usize,
                        of_column,
                        [across, up],
                    ) / (across * up);
                    let hold = if whole > 0.0 { whole * yarns } else { f64::MAX };
                    let place = j * self.layout.chunks + i as usize / CHUNK;
                    clamp::set_hold(self.arrays.rows.clamps, place, i as usize, hold);
                }
            }
        }
    }

    /// Sheet flat, at rest and whole.
    pub fn clear(&mut self) {
        self.arrays.rows.hot.fill([[0.0; CHUNK]; HOT_PLANES]);
        self.arrays.rows.history.fill([[0.0; CHUNK]; HISTORY_PLANES]);
        for (history, strength) in self.arrays.rows.history.iter_mut().zip(self.arrays.rows.strength.iter()) {
            *history = strength.map(|plane| plane.map(law::twice_strain_at));
        }
        self.arrays.flags.fill(0);
        self.arrays.rows.energy_error.fill(NO_ENERGY_ERROR);
        self.arrays.rows.clamps.iter_mut().for_each(|chunk| chunk[SLID] = [0.0; CHUNK]);
        for j in 0..self.arrays.rows.been_slack.len() {
            let PlyDirections { horizontal, vertical, .. } = self.directions_of_row(j);
            let slack = |rest: &Rest, axis: Axis| u32::from(rest.twice_strain < 0.0) * energy_error::bit(axis);
            let bits = slack(&horizontal.rest, Axis::Horizontal) | slack(&vertical.rest, Axis::Vertical);
            if let Some(been_slack) = self.arrays.rows.been_slack.get_mut(j) {
                *been_slack = bits;
            }
        }
    }

    /// Fills every row anew by `fill`, and what follows from it while it is at hand; [`System::refill`] says
    /// the rest.
    ///
    /// [`System::refill`]: crate::memory::system::System::refill
    pub fn refill(&mut self, mut fill: impl FnMut(&mut Self, usize) -> bool) {
        self.arrays.rows.before.fill([0.0; CHUNK]);
        self.arrays.rows.case_impulse_of_row.fill([[0.0; CHUNK]; 3]);
        self.arrays.rows.case_impulse.fill([0.0; CHUNK]);
        (0..self.layout.plies).for_each(|ply| self.set_awake(ply, [0, 0]));
        for j in 0..self.layout.nodes_y {
            if fill(self, j) {
                self.rebuild_stiffness(j);
            }
            if self.rebuild_range(j) {
                self.wake(j);
            }
        }
    }

    /// Stiffness of the segments that start in row j, from their histories.
    fn rebuild_stiffness(&mut self, j: usize) {
        let (chunks, ends) = (self.layout.chunks, self.ends_of_segments(j));
        let PlyDirections { horizontal: h, vertical: v, .. } = self.directions.of_ply(self.layout.ply_and_row(j).0);
        let uniform = [h.stiffness, v.stiffness, h.damage_rate, v.damage_rate];
        let uniform = uniform.map(|constant| [constant; CHUNK]);
        let shared = [h, v].map(|direction| [direction.law.critical_stretch; CHUNK]);
        let row = planes::row_mut(self.arrays.rows.hot, chunks, j);
        let history = planes::row(self.arrays.rows.history, chunks, j);
        let yarn = planes::row(self.arrays.rows.yarn, chunks, j);
        let strength = planes::row(self.arrays.rows.strength, chunks, j);
        for (c, (hot, history)) in row.iter_mut().zip(history).enumerate() {
            let yarn = yarn.get(c).unwrap_or(&uniform);
            let strength = strength.get(c).unwrap_or(&shared);
            for (k, direction) in [h, v].into_iter().enumerate() {
                let mut stiffness = yarn[k];
                stiffness.iter_mut().skip(ends[k].saturating_sub(c * CHUNK)).for_each(|none| *none = 0.0);
                let whole = history[k].iter().fold(true, |whole, &largest| whole & (largest <= direction.critical));
                if !whole {
                    let constants = yarn[k + 2].iter().zip(&strength[k]).zip(&history[k]);
                    for (stiffness, ((&damage_rate, &critical), &largest)) in stiffness.iter_mut().zip(constants) {
                        *stiffness *= direction.law.at(critical).alpha(damage_rate, largest);
                    }
                }
                hot[STIFFNESS + k] = stiffness;
            }
        }
    }

    /// Least and greatest y displacement of row j. Returns whether a node of it is not exactly at rest in its
    /// place.
    fn rebuild_range(&mut self, j: usize) -> bool {
        let row = planes::row(self.arrays.rows.hot, self.layout.chunks, j);
        let (mut low, mut high, mut moved) = ([0.0; CHUNK], [0.0; CHUNK], false);
        let mut take = |chunk: &Chunk<HOT_PLANES>| {
            for ((low, high), &y) in low.iter_mut().zip(&mut high).zip(&chunk[1]) {
                *low = math::min(y, *low);
                *high = math::max(y, *high);
            }
            moved |= chunk[..6].iter().flatten().fold(false, |moved, &x| moved | (x != 0.0));
        };
        let (whole, rest) = row.split_at_checked(self.layout.nodes_x / CHUNK).unwrap_or((row, &[]));
        whole.iter().for_each(&mut take);
        if let Some(mut last) = rest.first().copied() {
            // After the last node there may be an image.
            for plane in &mut last {
                plane.iter_mut().skip(self.layout.nodes_x % CHUNK).for_each(|place| *place = 0.0);
            }
            take(&last);
        }
        if let Some(range) = self.arrays.rows.ranges.get_mut(j) {
            let least = low.iter().fold(0.0, |least, &y| math::min(y, least));
            let greatest = high.iter().fold(0.0, |greatest, &y| math::max(y, greatest));
            *range = [end_of_range(least), end_of_range(greatest), NOT_KEPT, NOT_KEPT];
        }
        moved
    }

    /// Failed segments of rows [first, end) in the whole sheet.
    pub fn count_failed(&self, [first, end]: [usize; 2]) -> u64 {
        let mut failed = 0.0;
        for j in first..end {
            let ends = self.ends_of_segments(j);
            for (c, hot) in planes::row(self.arrays.rows.hot, self.layout.chunks, j).iter().enumerate() {
                for axis in [Axis::Horizontal, Axis::Vertical] {
                    let (stiffness, first) = (&hot[STIFFNESS + axis as usize], c * CHUNK);
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
}
