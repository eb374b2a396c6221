//! Where a candidate of a stack stands among those of its column.

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
