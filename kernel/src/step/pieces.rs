//! Pieces of the sheet: nodes that live segments join, and whether they are joined to a support.
//!
//! Method: disjoint sets, each named by the smallest number of its nodes.
//! Limits: without `track_detachment` no piece is known to be loose.
//! Reference: R. E. Tarjan, J. ACM 22 (1975) 215.

use crate::ground::lanes::CacheLine;
use crate::ground::planes::{self, Axis, CHUNK, Chunk, HOT_PLANES, STIFFNESS};
use crate::memory::arrays::{Arrays, RowArrays};
use crate::memory::network::Network;
use crate::scene::features::Feature;
use crate::scene::parts::AttachmentKind;
use crate::sheet::clamp::slid_by;

/// Connected components of the sheet, for one query.
pub(crate) struct Pieces {
    /// Number of the piece that holds the supports.
    support: Option<usize>,
    /// Whether every node is labelled with the number of its piece.
    labelled: bool,
    /// Whether the sheet counts as held where it is not labelled, as one piece.
    held: bool,
}

impl Pieces {
    /// Finds them. `has_failed`: whether a segment has. Before the first failure all nodes are one piece,
    /// which clamps may have let go of; later, without labels, none is known to be loose.
    pub fn of(network: &mut Network<'_>, has_failed: bool) -> Pieces {
        let layout = network.layout;
        let several = has_failed || layout.is_stack() || network.have_clamps_let_go();
        let labelled = several && layout.has(Feature::Detachment);
        let support = if labelled { join_nodes(network) } else { None };
        let held = network.scene.attachment.kind != AttachmentKind::Free || !layout.has(Feature::Detachment);
        Pieces { support, labelled, held }
    }

    /// The number of the piece that a node belongs to.
    pub fn of_node(&self, network: &Network<'_>, i: usize, j: usize) -> usize {
        let label = CacheLine::words_of(network.arrays.shared).get(j * network.layout.nodes_x + i);
        label.filter(|_| self.labelled).map_or(0, |&label| label as usize)
    }

    /// Whether a piece is joined to a support.
    pub fn hold(&self, piece: usize) -> bool {
        if self.labelled { self.support == Some(piece) } else { self.held }
    }
}

/// Whether no live segment ends at a node: then it flies straight.
pub(super) fn is_alone(network: &Network<'_>, i: usize, j: usize) -> bool {
    let before = |axis: Axis, i: Option<usize>, j: Option<usize>| match (i, j) {
        (Some(i), Some(j)) => is_live(network, axis, i, j),
        _ => false,
    };
    !(is_live(network, Axis::Horizontal, i, j)
        || before(Axis::Horizontal, network.layout.x.before(i), Some(j))
        || is_live(network, Axis::Vertical, i, j)
        || before(Axis::Vertical, Some(i), j.checked_sub(1)))
}

/// Whether the segment that starts at node (i, j) has not failed.
pub(super) fn is_live(network: &Network<'_>, axis: Axis, i: usize, j: usize) -> bool {
    is_live_in(planes::row(network.arrays.rows.hot, network.layout.chunks, j), axis, i)
}

/// [`is_live`] of the segment that starts at column i of a row.
fn is_live_in(row: &[Chunk<HOT_PLANES>], axis: Axis, i: usize) -> bool {
    planes::get(row, STIFFNESS + axis as usize, i).is_some_and(|stiffness| stiffness > 0.0)
}

/// Labels every node with the smallest number of a node that live segments join it to. All fixed nodes count
/// as joined. Gives the label of the fixed nodes, if there are any.
pub(super) fn join_nodes(network: &mut Network<'_>) -> Option<usize> {
    let (nx, ny, chunks) = (network.layout.nodes_x, network.layout.nodes_y, network.layout.chunks);
    let grip = network.clamps.grip;
    let Arrays { rows: RowArrays { hot, runs, clamps, .. }, shared, .. } = &mut network.arrays;
    let mut sets = Components::new(CacheLine::words(shared).get_mut(..nx * ny).unwrap_or_default());
    join_live_segments(&mut sets, hot, chunks, [nx, ny]);
    if network.layout.x.is_closed() {
        let last = nx.saturating_sub(1);
        let joined = (0..ny).filter(|&j| is_live_in(planes::row(hot, chunks, j), Axis::Horizontal, last));
        joined.for_each(|j| sets.join(j * nx, j * nx + last));
    }
    // All fixed nodes into one component.
    let mut support = None;
    for (j, run) in runs.iter().enumerate() {
        for i in (run[0]..run[1]).chain(run[2]..run[3]).map(|i| i as usize) {
            if slid_by(clamps, j * chunks + i / CHUNK, i % CHUNK) >= grip {
                continue;
            }
            let k = j * nx + i;
            match support {
                None => support = Some(k),
                Some(first) => sets.join(first, k),
            }
        }
    }
    sets.flatten();
    support.map(|k| sets.find(k))
}

/// Joins the ends of every live segment of so many nodes.
fn join_live_segments(sets: &mut Components<'_>, hot: &[Chunk<HOT_PLANES>], chunks: usize, [nx, ny]: [usize; 2]) {
    let mut below: &[Chunk<HOT_PLANES>] = &[];
    for j in 0..ny {
        let row = planes::row(hot, chunks, j);
        let mut from_below = false;
        for i in 0..nx {
            let k = j * nx + i;
            let from_left = i > 0 && is_live_in(row, Axis::Horizontal, i - 1);
            if from_left {
                sets.join(k - 1, k);
            }
            // Most often the other three sides of the cell have joined the two ends already.
            let joined = from_below && from_left && is_live_in(below, Axis::Horizontal, i - 1);
            from_below = is_live_in(below, Axis::Vertical, i);
            if from_below && !joined {
                sets.join(k - nx, k);
            }
        }
        below = row;
    }
}

/// Disjoint sets over the nodes, in caller's memory.
pub struct Components<'a> {
    labels: &'a mut [u32],
}

impl<'a> Components<'a> {
    /// Every node by itself.
    pub fn new(labels: &'a mut [u32]) -> Components<'a> {
        for (k, label) in labels.iter_mut().enumerate() {
            *label = k as u32;
        }
        Components { labels }
    }

    /// The representative of a node's component.
    pub fn find(&mut self, node: usize) -> usize {
        let mut k = node;
        loop {
            let Some(&parent) = self.labels.get(k) else { return node };
            if parent as usize == k {
                return k;
            }
            let grandparent = self.labels.get(parent as usize).copied().unwrap_or(parent);
            if let Some(label) = self.labels.get_mut(k) {
                *label = grandparent;
            }
            k = grandparent as usize;
        }
    }

    /// Gives every node the number of its component's representative.
    pub fn flatten(&mut self) {
        // A representative has the smallest number of its component, so those before are done.
        for k in 0..self.labels.len() {
            let root = self.find(k) as u32;
            if let Some(label) = self.labels.get_mut(k) {
                *label = root;
            }
        }
    }

    /// Joins two nodes' components.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        let (small, large) = if a < b { (a, b) } else { (b, a) };
        if let Some(label) = self.labels.get_mut(large) {
            *label = small as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::random::splitmix64;

    #[test]
    fn live_segments_join_their_ends_whatever_has_failed() {
        let ([nx, ny], chunks) = ([19, 17], 3);
        for case in 0..200 {
            // Nearly whole, in pieces, dust.
            let threshold = [u64::MAX / 50, u64::MAX / 2, u64::MAX / 4 * 3][case % 3];
            let draw = |k: usize| splitmix64((case * 10_000 + k) as u64) > threshold;
            let mut hot = std::vec![[[0.0; CHUNK]; HOT_PLANES]; chunks * ny];
            for k in 0..nx * ny {
                let (i, j) = (k % nx, k / nx);
                let chunk = &mut hot[j * chunks + i / CHUNK];
                chunk[STIFFNESS][i % CHUNK] = f64::from(draw(2 * k));
                chunk[STIFFNESS + 1][i % CHUNK] = f64::from(draw(2 * k + 1));
            }
            let mut plainly = std::vec![0; nx * ny];
            let mut sets = Components::new(&mut plainly);
            for k in 0..nx * ny {
                let (i, j) = (k % nx, k / nx);
                if i + 1 < nx && draw(2 * k) {
                    sets.join(k, k + 1);
                }
                if j + 1 < ny && draw(2 * k + 1) {
                    sets.join(k, k + nx);
                }
            }
            sets.flatten();
            let mut labels = std::vec![0; nx * ny];
            let mut sets = Components::new(&mut labels);
            join_live_segments(&mut sets, &hot, chunks, [nx, ny]);
            sets.flatten();
            assert_eq!(labels, plainly, "case {case}");
        }
    }
}
