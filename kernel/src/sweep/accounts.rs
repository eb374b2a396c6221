//! Energy that viscosity and the rate of strain dissipate in a row in a step, in units of m (h/dt)^2, and
//! the sums that a sweep adds up: this energy, reactions of supports and case, and what clamps dissipate.
//!
//! Method: each row keeps its own sums; they are added up lowest row first, so that they do not depend on
//! bands and blocks.
//! Reference: docs/model.md, "Energy balance".

use crate::body::pose::Vector;
use crate::ground::planes::{self, Axis, CHUNK, Chunk, HOT_PLANES, STIFFNESS};
use crate::memory::arrays::{RowArrays, StepScratch};
use crate::memory::layout::Layout;
use crate::memory::network::Network;
use crate::memory::state::Sums;
use crate::scene::features::Feature;
use crate::sheet::weave;
use crate::sweep::pass::Pass;
use crate::sweep::segments::Dissipation;

/// Energy that viscosity and rate dissipate in one row in one step.
pub(crate) struct DissipationOfRow {
    /// Units of the horizontal and the vertical segments: 1/4 l^2 times the row's weight.
    units: [f64; 2],
    pub sums: Dissipation,
    /// Energy of the last segments along x and y in the sums of a mirrored row, over 1/4 l^2.
    pub of_last: [f64; 2],
}

impl DissipationOfRow {
    /// Account of no row.
    const NONE: DissipationOfRow = DissipationOfRow { units: [0.0; 2], sums: Dissipation::NONE, of_last: [0.0; 2] };

    /// Empty account of row j.
    #[inline(always)]
    pub fn of(layout: &Layout, Pass { directions: along, net, .. }: &Pass<'_>, j: usize) -> DissipationOfRow {
        if !layout.dissipates() {
            return DissipationOfRow::NONE;
        }
        let unit = |length: f64| 0.25 * length * length;
        let (x, y) = (unit(along.horizontal.rest.length * along.radius_ratio), unit(along.vertical.rest.length));
        let mut units = [layout.y.node_weight(j) * x, layout.y.segment_weight(j) * y];
        if Feature::Grading.is_built() && !net.lines.is_empty() {
            let segments = net.row_segments(j);
            units = [units[0] * net.row_share(j), units[1] * (segments * segments)];
        }
        DissipationOfRow {
            units,
            sums: Dissipation { share: units[1] / units[0], ..Dissipation::NONE },
            ..DissipationOfRow::NONE
        }
    }

    /// Notes what relaxation will take of the last segments of a mirrored row.
    pub fn relax_last(&mut self, pass: &Pass<'_>, j: usize, [row, above]: [&[Chunk<HOT_PLANES>]; 2]) {
        let last = pass.x.modelled() - 1;
        let parts = pass.net.parts(last);
        let place = |row: &[Chunk<HOT_PLANES>], i: usize| {
            row.get(i / CHUNK).map_or([0.0; 3], |chunk| planes::displacement(chunk, i % CHUNK))
        };
        let [x, y, z] = place(row, last);
        for (axis, [a, b, c]) in [(Axis::Horizontal, place(row, last + 1)), (Axis::Vertical, place(above, last))] {
            let direction = pass.directions.along(axis);
            let [segments, _] = pass.net.bar(axis, last, j).unwrap_or([1.0; 2]);
            let q: f64 =
                direction.rest.in_series(segments).lanes().twice_strain(axis.segment_axes([a - x, b - y, c - z]));
            let stiffness = planes::get(row, STIFFNESS + axis as usize, last).unwrap_or(0.0);
            let rate = direction.rate.at(pass.rates.time).splats().lanes();
            self.of_last[axis as usize] =
                parts[axis as usize] * pass.rates.relaxing * rate.relaxing(stiffness, rate.beyond(q));
        }
    }

    /// All of it.
    #[inline(always)]
    pub fn total(&self, layout: &Layout) -> f64 {
        let Dissipation { by_column, by_rupture, .. } = &self.sums;
        let (line, [x, y]) = (layout.x, self.units);
        let sum = by_column.iter().sum::<f64>();
        if !line.is_mirrored() {
            return x * (sum + by_rupture);
        }
        // All columns but the last are there twice.
        let last = layout.nodes_x.saturating_sub(1);
        let less = [2.0 - line.segment_weight(last), 2.0 - line.node_weight(last)];
        x * (2.0 * sum + by_rupture) - less[0] * x * self.of_last[0] - less[1] * y * self.of_last[1]
    }
}

/// Adds up what the sweep of the rows that are awake has dissipated, and the reactions of supports and case.
#[inline(never)]
pub(crate) fn add_awake(system: &mut Network<'_>, sums: &mut Sums) {
    for ply in 0..system.layout.plies {
        add_sweep(system, sums, ply, system.awake_of(ply), 0);
    }
}

/// Adds up what the sweep of rows [first, end) of a ply has dissipated in a step of a block, the first one
/// otherwise, and the reactions of supports and case.
#[inline(never)]
pub(crate) fn add_sweep(system: &mut Network<'_>, sums: &mut Sums, ply: usize, rows: [usize; 2], step: usize) {
    add_dissipated(system, sums, ply, rows, step);
    add_reactions(system, sums, ply, rows, step);
    add_case_impulses(system, sums, ply, rows);
}

/// Adds up what viscosity, the rate and clamps have dissipated in rows [first, end) of a ply in a step of a
/// block, the first one otherwise, lowest row first.
#[inline(never)]
fn add_dissipated(system: &mut Network<'_>, sums: &mut Sums, ply: usize, [first, end]: [usize; 2], step: usize) {
    let unit = system.model.unit_energy * system.mass_share(ply);
    let noted = step * system.layout.nodes_y;
    let RowArrays { dissipated, clamped, .. } = &system.arrays.rows;
    for (of_rows, sum) in [(dissipated, &mut sums.viscous), (clamped, &mut sums.clamps.dissipated)] {
        let of_rows = of_rows.get(noted + first..noted + end).unwrap_or_default();
        of_rows.iter().for_each(|of_row| *sum += unit * of_row);
    }
}

/// Adds up the impulses of the case on rows [first, end) of a ply and the energy dissipated by it, lowest row
/// first.
fn add_case_impulses(system: &mut Network<'_>, sums: &mut Sums, ply: usize, [first, end]: [usize; 2]) {
    let share = system.mass_share(ply);
    let unit = system.model.unit_energy * share;
    for push in system.arrays.rows.case_impulse_of_row.get_mut(first..end).unwrap_or_default() {
        // The next step may leave out a row.
        let [x, z, dissipated] = push.map(|sums| sums.iter().fold(0.0, |sum, part| sum + part));
        *push = [[0.0; CHUNK]; 3];
        sums.casing.impulse -= Vector::new(x, 0.0, z) * share;
        sums.casing.loss += unit * dissipated;
    }
}

/// Adds up the reactions of the fixed nodes of rows [first, end) of a ply in a step of a block, the first one
/// otherwise, lowest row first.
#[inline(never)]
fn add_reactions(system: &mut Network<'_>, sums: &mut Sums, ply: usize, [first, end]: [usize; 2], step: usize) {
    let share = system.scene.symmetry.share() * system.mass_share(ply);
    let Network { scene, layout, arrays, .. } = system;
    let ((kind, symmetry), [bottom, _]) = ((scene.attachment.kind, scene.symmetry), layout.rows_of(ply));
    let StepScratch { reactions, .. } = StepScratch::of(arrays.shared, layout);
    let reactions = reactions.get(step * layout.nodes_y..).and_then(|reactions| reactions.get(first..end));
    for (j, reactions) in reactions.into_iter().flatten().enumerate() {
        for (side, reaction) in reactions.iter().enumerate() {
            let at = weave::attachment_of(kind, layout.y.nodes, layout.upper, first - bottom + j, side);
            sums.add_to_support(kind, at, &(Vector::from(*reaction) * share), symmetry);
        }
    }
}
