//! Geometry of the sheet at rest by column and by row: the one table that the sweep, contact and the
//! read-outs use for flat, graded and curved sheets, and the constants of segments and nodes that follow from
//! it.
//!
//! Method: a row of nodes has one line of constants, chunk by chunk of its columns, where the columns differ
//! (graded network, curved sheet, of which each ply has its own); a graded network has a second line for its
//! rows. Without a line all columns are alike. A width of 1, a natural length of 1 and a rest vector without
//! a part along z are exact factors and terms, so one expression serves all.
//! Limits: a curved sheet is not graded.
//! Reference: docs/model.md, "Graded networks" and "Curved sheets and rings".

use crate::ground::lanes::{Lane, Splat, at};
use crate::ground::planes::{self, Axis, CHUNK, Chunk};
use crate::scene::features::Feature;
use crate::yarn::law::{Rest, RestLanes, RestSplats};
use core::hint::black_box;

/// Planes of a line of nodes and of the segments that begin at them.
pub const COLUMN_PLANES: usize = 10;
// Planes that the sweep reads.
/// Rest vector of the segment to the next node, along the line (x of a curved sheet), spacings.
pub const CHORD: usize = 0;
/// Rest vector of the segment to the next node, along z, spacings.
pub const CHORD_Z: usize = 1;
/// 1/l^2 with the natural length l of the segment to the next node, spacings.
pub const INVERSE_SQUARE: usize = 2;
/// 1 over the width of the node.
pub const INVERSE_WIDTH: usize = 3;
// Planes of contact and of the read-outs.
/// Rest place along the line, spacings: from the middle of a flat sheet along its line, from the axis of a
/// curved one along x.
pub const PLACE: usize = 4;
/// Rest place along z, spacings from the axis of a curved sheet.
pub const PLACE_Z: usize = 5;
/// Normal of the sheet at rest along x; 0 after the last node.
pub const NORMAL_X: usize = 6;
/// Normal of the sheet at rest along z; 0 after the last node.
pub const NORMAL_Z: usize = 7;
/// Width of the node, yarns.
pub const WIDTH: usize = 8;
/// Segments of the fabric in series in the bar to the next node.
pub const SEGMENTS: usize = 9;

/// Planes that the sweep reads, the first ones.
const SWEPT_PLANES: usize = 4;

/// Constants of eight columns that the sweep reads.
pub type Columns = Chunk<SWEPT_PLANES>;

/// Columns that are not read.
const UNREAD: Columns = [[1.0; CHUNK]; SWEPT_PLANES];

/// Sets constants, each with its plane, of column i of a line.
pub(crate) fn set<const N: usize>(line: &mut [Chunk<COLUMN_PLANES>], i: usize, constants: [(usize, f64); N]) {
    for (plane, constant) in constants {
        planes::set(line, plane, i, constant);
    }
}

/// Lines of constants of the rows of a ply. Both are empty in a flat sheet without grading.
#[derive(Clone, Copy, Default)]
pub struct Net<'a> {
    /// Constants of the columns, chunk by chunk; of all plies of a curved sheet, or of one of them.
    pub columns: &'a [Chunk<COLUMN_PLANES>],
    /// Constants of the rows of a graded network; else empty.
    pub lines: &'a [Chunk<COLUMN_PLANES>],
}

impl<'a> Net<'a> {
    /// Whether they are of a flat sheet without grading.
    #[inline]
    pub fn is_flat(&self) -> bool {
        self.columns.is_empty() || !(Feature::Grading.is_built() || Feature::Curved.is_built())
    }

    /// Columns of a curved sheet; empty of a flat one. A graded network has lines of rows, too.
    #[inline]
    pub fn hoop(&self) -> &'a [Chunk<COLUMN_PLANES>] {
        if Feature::Curved.is_built() && self.lines.is_empty() { self.columns } else { &[] }
    }

    /// Nodes of the fabric that node (i, j) stands for.
    #[inline]
    pub fn share(&self, i: usize, j: usize) -> f64 {
        self.column_share(i) * self.row_share(j)
    }

    /// Width of the nodes of column i.
    #[inline]
    pub fn column_share(&self, i: usize) -> f64 {
        planes::get(self.columns, WIDTH, i).unwrap_or(1.0)
    }

    /// Width of the nodes of row j.
    #[inline]
    pub fn row_share(&self, j: usize) -> f64 {
        planes::get(self.lines, WIDTH, j).unwrap_or(1.0)
    }

    /// Whether the bars from the nodes of chunk c of row j are single segments of single yarns, as all of a
    /// flat sheet are without grading; false of a curved sheet.
    pub fn is_fine(&self, c: usize, j: usize) -> bool {
        let Some(columns) = self.columns.get(c) else { return true };
        [SEGMENTS, WIDTH].into_iter().all(|plane| {
            columns[plane].iter().all(|&number| number == 1.0) && planes::get(self.lines, plane, j) == Some(1.0)
        })
    }

    /// 1 over the widths of column i and of row j of a graded network.
    pub fn inverse_widths(&self, i: usize, j: usize) -> Option<[f64; 2]> {
        Some([planes::get(self.columns, INVERSE_WIDTH, i)?, planes::get(self.lines, INVERSE_WIDTH, j)?])
    }

    /// Bar from node (i, j) of a graded network: segments in series, and yarns in parallel. None without
    /// grading.
    pub fn bar(&self, axis: Axis, i: usize, j: usize) -> Option<[f64; 2]> {
        let (along, k, across, line) = match axis {
            Axis::Horizontal => (self.columns, i, self.lines, j),
            Axis::Vertical => (self.lines, j, self.columns, i),
        };
        Some([planes::get(along, SEGMENTS, k)?, planes::get(across, WIDTH, line)?])
    }
}

/// Constants of the bars from a lane group and of its nodes.
pub struct Bars<L> {
    /// Bars along x and along y at rest, the direction of each in a flat sheet first.
    pub rests: [RestLanes<L>; 2],
    /// 1 over the widths of the columns and of the row; None where all are 1.
    pub inverse_widths: Option<[L; 2]>,
}

/// Geometry of a row at rest.
pub trait Geometry<'a> {
    /// Geometry of row j of a ply whose segments along x and along y lie so in a flat sheet. `net`: lines of
    /// the ply.
    fn of(net: &Net<'a>, rests: [&Rest; 2], j: usize) -> Self;

    /// Geometry whose constants stay in memory over a loop: in registers they would take those of the
    /// segments.
    #[inline(always)]
    fn in_memory(&self) -> &Self {
        self
    }

    /// Constants of the columns of a chunk, which [`Geometry::bars`] reads.
    #[inline(always)]
    fn columns(&self, _chunk: usize) -> &Columns {
        &UNREAD
    }

    /// Constants of lane group g of a chunk.
    fn bars<L: Lane>(&self, columns: &Columns, g: usize) -> Bars<L>;

    /// Numbers of the segments along x and along y, one number where both are the same in every row.
    #[inline(always)]
    fn both([along, upwards]: [f64; 2]) -> [f64; 2] {
        [along, upwards]
    }
}

/// Geometry of the paper's sheet: all segments lie at their natural length, 1.
pub struct Plain;

impl<'a> Geometry<'a> for Plain {
    #[inline(always)]
    fn of(_: &Net<'a>, _: [&Rest; 2], _: usize) -> Plain {
        Plain
    }

    #[inline(always)]
    fn bars<L: Lane>(&self, _: &Columns, _: usize) -> Bars<L> {
        Bars { rests: [Rest::PLAIN.lanes(), Rest::PLAIN.lanes()], inverse_widths: None }
    }

    #[inline(always)]
    fn both([along, _]: [f64; 2]) -> [f64; 2] {
        [along, along]
    }
}

/// Geometry of a flat sheet without grading.
pub struct Rests([RestSplats; 2]);

impl<'a> Geometry<'a> for Rests {
    #[inline(always)]
    fn of(_: &Net<'a>, [x, y]: [&Rest; 2], _: usize) -> Rests {
        Rests([RestSplats::of(x), RestSplats::of(y)])
    }

    #[inline(always)]
    fn in_memory(&self) -> &Self {
        black_box(self)
    }

    #[inline(always)]
    fn bars<L: Lane>(&self, _: &Columns, _: usize) -> Bars<L> {
        Bars { rests: [self.0[0].lanes(), self.0[1].lanes()], inverse_widths: None }
    }
}

/// Geometry of any row.
pub struct Table<'a> {
    /// Line of the columns, empty where all are alike.
    columns: &'a [Chunk<COLUMN_PLANES>],
    /// Columns where all are alike.
    alike: Columns,
    /// q_0 along x.
    twice_strain: Splat,
    /// Bars upwards.
    upwards: RestSplats,
    /// 1 over the width of the row.
    inverse_width: Splat,
}

impl<'a> Geometry<'a> for Table<'a> {
    #[inline(always)]
    fn of(net: &Net<'a>, [x, y]: [&Rest; 2], j: usize) -> Table<'a> {
        let of_row = |plane| planes::get(net.lines, plane, j);
        let upwards = match (of_row(CHORD), of_row(INVERSE_SQUARE)) {
            (Some(spacing), Some(inverse_square)) => Rest { spacing, inverse_square, ..*y },
            _ => *y,
        };
        Table {
            columns: net.columns,
            alike: [x.spacing, 0.0, x.inverse_square, 1.0].map(|constant| [constant; CHUNK]),
            twice_strain: Splat::of(x.twice_strain),
            upwards: RestSplats::of(&upwards),
            inverse_width: Splat::of(of_row(INVERSE_WIDTH).unwrap_or(1.0)),
        }
    }

    #[inline(always)]
    fn in_memory(&self) -> &Self {
        black_box(self)
    }

    #[inline(always)]
    fn columns(&self, chunk: usize) -> &Columns {
        self.columns.get(chunk).and_then(|columns| columns.first_chunk()).unwrap_or(&self.alike)
    }

    #[inline(always)]
    fn bars<L: Lane>(&self, columns: &Columns, g: usize) -> Bars<L> {
        let chord = [at(columns, CHORD, g), at(columns, CHORD_Z, g)];
        let (inverse_square, twice_strain) = (at(columns, INVERSE_SQUARE, g), self.twice_strain.lanes());
        let along = RestLanes { chord, twice_chord: chord, inverse_square, twice_strain };
        let inverse_widths = Some([at(columns, INVERSE_WIDTH, g), self.inverse_width.lanes()]);
        Bars { rests: [along.turned(chord), self.upwards.lanes()], inverse_widths }
    }
}
