//! What viscosity and the rate of strain take of a row in a pass, in units of m (h/dt)^2.

use crate::ground::planes::{self, Axis, CHUNK, Chunk, HOT_PLANES};
use crate::memory::layout::Layout;
use crate::sheet::direction::Along;
use crate::sheet::segments::Dissipation;
use crate::sheet::sweep::Pass;

/// Counts it.
pub(crate) struct DissipationOfRow {
    /// Units of the horizontal and the vertical segments: 1/4 l^2 times the row's weight.
    units: [f64; 2],
    pub sums: Dissipation,
    /// What the last segments along x and y have in the sums of a mirrored row, over 1/4 l^2.
    pub of_last: [f64; 2],
}

impl DissipationOfRow {
    /// Account of no row.
    const NONE: DissipationOfRow = DissipationOfRow { units: [0.0; 2], sums: Dissipation::NONE, of_last: [0.0; 2] };

    /// Nothing of row j yet.
    #[inline(always)]
    pub fn of(layout: &Layout, along: Along<'_>, j: usize) -> DissipationOfRow {
        if !layout.takes_energy() {
            return DissipationOfRow::NONE;
        }
        let lengths = [along.horizontal.rest.length * along.turn, along.vertical.rest.length];
        let [x, y] = lengths.map(|length| 0.25 * length * length);
        let units = [layout.y.node_weight(j) * x, layout.y.segment_weight(j) * y];
        DissipationOfRow {
            units,
            sums: Dissipation { share: units[1] / units[0], ..Dissipation::NONE },
            ..DissipationOfRow::NONE
        }
    }

    /// Notes what relaxation will take of the last segments of a mirrored row.
    #[inline(never)]
    pub fn relax_last(&mut self, pass: &Pass<'_>, [row, above]: [&[Chunk<HOT_PLANES>]; 2]) {
        let last = pass.x.modelled() - 1;
        let place = |row: &[Chunk<HOT_PLANES>], i: usize| {
            row.get(i / CHUNK).map_or([0.0; 3], |chunk| planes::displacement(chunk, i % CHUNK))
        };
        let [x, y, z] = place(row, last);
        for (axis, [a, b, c]) in [(Axis::Horizontal, place(row, last + 1)), (Axis::Vertical, place(above, last))] {
            let direction = pass.directions.along(axis);
            let q: f64 = direction.rest.twice_strain(axis.own_axes([a - x, b - y, c - z]));
            let stiffness = planes::get(row, 6 + axis as usize, last).unwrap_or(0.0);
            let rate = direction.rate.at(pass.rates.time).splats().lanes();
            self.of_last[axis as usize] = pass.rates.relaxing * rate.relaxing(stiffness, rate.beyond(q));
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
