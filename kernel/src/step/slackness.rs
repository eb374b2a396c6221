//! Search for rows with slack segments: from then on a row keeps the energy errors of its segments
//! (`sweep/slack.rs`).
//!
//! Method: every 16 steps each row that is stepped is tested, direction by direction; a direction that has
//! been slack once stays noted.
//! Limits: a segment that is slack between two searches alone is not found.
//! Reference: docs/model.md, "Slack and taut".

use crate::ground::lanes;
use crate::ground::planes::{self, Axis};
use crate::memory::network::Network;
use crate::sheet::columns::{Geometry, Table};
use crate::sheet::energy_error::bit;
use crate::sheet::ghosts::place_ghost_column;
use crate::sweep::slack::FindSlack;

/// The bits of a row in which both directions have been slack.
const ALL: u32 = bit(Axis::Horizontal) | bit(Axis::Vertical);

/// Searches the rows that are stepped and have not been slack in both directions.
pub(crate) fn search(network: &mut Network<'_>) {
    let (chunks, line) = (network.layout.chunks, network.layout.x);
    if network.layout.y.is_mirrored() {
        network.place_ghost_row();
    }
    for ply in 0..network.layout.plies {
        let [first, end] = network.rows_to_step(ply);
        for j in first..end {
            if network.arrays.rows.been_slack.get(j) == Some(&ALL) {
                continue;
            }
            if line.has_ghost() {
                place_ghost_column(planes::row_mut(network.arrays.rows.hot, chunks, j), line);
            }
            let along = network.directions_of_row(j);
            // Above the top row of a ply the stiffnesses are 0.
            let job = FindSlack {
                row: planes::row(network.arrays.rows.hot, chunks, j),
                above: planes::row(network.arrays.rows.hot, chunks, j + 1),
                geometry: Table::of(&network.net(ply), along.rests(), j),
            };
            let found = lanes::dispatch(network.instructions, job);
            if let Some(been_slack) = network.arrays.rows.been_slack.get_mut(j) {
                *been_slack |= found;
            }
        }
    }
}
