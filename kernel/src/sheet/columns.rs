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
use crate::yarn::law::{NONE, Rest, RestLanes, RestSplats};
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
#[derive(Clone, Copy)]
pub struct Columns<'a> {
    swept: &'a Chunk<SWEPT_PLANES>,
    /// Widths of the nodes, and segments of the bars from them.
    shares: &'a Chunk<2>,
}

impl<'a> Columns<'a> {
    /// Chunk of a line; None after its last.
    #[inline(always)]
    fn of(line: &'a [Chunk<COLUMN_PLANES>], chunk: usize) -> Option<Columns<'a>> {
        let columns = line.get(chunk)?;
        Some(Columns { swept: columns.first_chunk()?, shares: columns.last_chunk()? })
    }
}

/// Columns that are not read.
pub(crate) const UNREAD: Columns<'_> = Columns { swept: &[[1.0; CHUNK]; SWEPT_PLANES], shares: &[[1.0; CHUNK]; 2] };

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

    /// Segments of the bar upwards from row j.
    #[inline]
    pub fn row_segments(&self, j: usize) -> f64 {
        planes::get(self.lines, SEGMENTS, j).unwrap_or(1.0)
    }

    /// Energies of the bars from column i along x and y over those of a segment, where the row's are 1.
    pub fn parts(&self, i: usize) -> [f64; 2] {
        let segments = planes::get(self.columns, SEGMENTS, i).filter(|_| !self.lines.is_empty()).unwrap_or(1.0);
        [segments * segments, self.column_share(i)]
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
pub struct Bars<'a, L> {
    /// Bars along x and along y at rest, the direction of each in a flat sheet first.
    pub rests: [RestLanes<L>; 2],
    /// Widths of the nodes; None where all are 1.
    pub widths: Option<Widths<'a>>,
    /// Shares of them; None where all are 1.
    pub shares: Option<Shares<'a>>,
}

impl<L: Lane> Bars<'_, L> {
    /// Number of each bar of an axis, of all its segments where `one` is that of one.
    #[inline(always)]
    pub fn of_all(&self, axis: Axis, one: L) -> L {
        match &self.shares {
            Some(shares) => one.mul(shares.segments(axis)),
            None => one,
        }
    }
}

/// Widths of the nodes of a lane group, in memory: a register would be taken from the segments.
#[derive(Clone, Copy)]
pub struct Widths<'a> {
    columns: &'a Chunk<SWEPT_PLANES>,
    row: &'a Splat,
    group: usize,
}

impl Widths<'_> {
    /// 1 over the widths of the columns and of the row.
    #[inline(always)]
    pub fn inverse<L: Lane>(widths: Option<Self>) -> Option<[L; 2]> {
        let Widths { columns, row, group } = widths?;
        Some([at(columns, INVERSE_WIDTH, group), row.lanes()])
    }
}

/// Segments and yarns that bars and nodes of a lane group of a graded network stand for, in memory.
#[derive(Clone, Copy)]
pub struct Shares<'a> {
    columns: &'a Chunk<2>,
    row: &'a Splat,
    group: usize,
}

impl Shares<'_> {
    /// Segments in series in the bars along an axis.
    #[inline(always)]
    pub fn segments<L: Lane>(&self, axis: Axis) -> L {
        match axis {
            Axis::Horizontal => at(self.columns, SEGMENTS - WIDTH, self.group),
            Axis::Vertical => self.row.lanes(),
        }
    }

    /// Widths of the columns, yarns.
    #[inline(always)]
    pub fn width<L: Lane>(&self) -> L {
        at(self.columns, 0, self.group)
    }
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
    fn columns(&self, _chunk: usize) -> Columns<'_> {
        UNREAD
    }

    /// Whether bars and nodes of a chunk are those of [`Plain`].
    #[inline(always)]
    fn is_plain(&self, _chunk: usize) -> bool {
        false
    }

    /// Constants of lane group g of a chunk.
    fn bars<'c, L: Lane>(&'c self, columns: Columns<'c>, g: usize) -> Bars<'c, L>;

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
    fn bars<'c, L: Lane>(&'c self, _: Columns<'c>, _: usize) -> Bars<'c, L> {
        Bars { rests: [Rest::PLAIN.lanes(), Rest::PLAIN.lanes()], widths: None, shares: None }
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
    fn bars<'c, L: Lane>(&'c self, _: Columns<'c>, _: usize) -> Bars<'c, L> {
        Bars { rests: [self.0[0].lanes(), self.0[1].lanes()], widths: None, shares: None }
    }
}

/// Constants of a row that all its columns share.
struct OfRow {
    /// q_0 along x.
    twice_strain: Splat,
    /// Bars upwards.
    upwards: RestSplats,
    /// 1 over the width of the row.
    inverse_width: Splat,
}

impl OfRow {
    /// Constants of row j.
    #[inline(always)]
    fn of(net: &Net<'_>, [x, y]: [&Rest; 2], j: usize) -> OfRow {
        let of_row = |plane| planes::get(net.lines, plane, j);
        let upwards = match (of_row(CHORD), of_row(INVERSE_SQUARE)) {
            (Some(spacing), Some(inverse_square)) => Rest { spacing, inverse_square, ..*y },
            _ => *y,
        };
        OfRow {
            twice_strain: Splat::of(x.twice_strain),
            upwards: RestSplats::of(&upwards),
            inverse_width: Splat::of(of_row(INVERSE_WIDTH).unwrap_or(1.0)),
        }
    }

    /// Constants of lane group g of these columns, whose rest vectors along z are `chord_z`.
    #[inline(always)]
    fn bars<'c, L: Lane>(&'c self, columns: &'c Chunk<SWEPT_PLANES>, chord_z: L, g: usize) -> Bars<'c, L> {
        let chord = [at(columns, CHORD, g), chord_z];
        let (inverse_square, twice_strain) = (at(columns, INVERSE_SQUARE, g), self.twice_strain.lanes());
        let along = RestLanes { chord, twice_chord: chord, inverse_square, twice_strain };
        let widths = Some(Widths { columns, row: &self.inverse_width, group: g });
        Bars { rests: [along.rotated(chord), self.upwards.lanes()], widths, shares: None }
    }
}

/// Geometry of any row where nothing asks what its bars stand for.
pub struct Table<'a> {
    /// Line of the columns, empty where all are alike.
    columns: &'a [Chunk<COLUMN_PLANES>],
    /// Columns where all are alike.
    alike: Chunk<SWEPT_PLANES>,
    row: OfRow,
}

impl<'a> Geometry<'a> for Table<'a> {
    #[inline(always)]
    fn of(net: &Net<'a>, rests: [&Rest; 2], j: usize) -> Table<'a> {
        let [x, _] = rests;
        let alike = [x.spacing, 0.0, x.inverse_square, 1.0].map(|constant| [constant; CHUNK]);
        Table { columns: net.columns, alike, row: OfRow::of(net, rests, j) }
    }

    #[inline(always)]
    fn in_memory(&self) -> &Self {
        black_box(self)
    }

    #[inline(always)]
    fn columns(&self, chunk: usize) -> Columns<'_> {
        let swept = self.columns.get(chunk).and_then(|columns| columns.first_chunk()).unwrap_or(&self.alike);
        Columns { swept, ..UNREAD }
    }

    #[inline(always)]
    fn bars<'c, L: Lane>(&'c self, Columns { swept, .. }: Columns<'c>, g: usize) -> Bars<'c, L> {
        self.row.bars(swept, at(swept, CHORD_Z, g), g)
    }
}

/// Geometry of a row of a graded network of the paper's sheet without effects.
pub struct PartlyPlain<'a> {
    table: Table<'a>,
    /// First chunk of the fine part, and how many there are in this row.
    fine: [usize; 2],
}

impl<'a> Geometry<'a> for PartlyPlain<'a> {
    #[inline(always)]
    fn of(net: &Net<'a>, rests: [&Rest; 2], j: usize) -> Self {
        // Bars grow outwards only: between two nodes of width 1 all are single segments.
        let is_fine = |columns: &Chunk<COLUMN_PLANES>| columns[WIDTH][0] == 1.0 && columns[WIDTH][CHUNK - 1] == 1.0;
        let fine = match net.columns.iter().position(is_fine).zip(net.columns.iter().rposition(is_fine)) {
            Some((first, last)) if net.row_share(j) == 1.0 => [first, last + 1 - first],
            _ => [0, 0],
        };
        PartlyPlain { table: Table::of(net, rests, j), fine }
    }

    #[inline(always)]
    fn in_memory(&self) -> &Self {
        black_box(self)
    }

    #[inline(always)]
    fn columns(&self, chunk: usize) -> Columns<'_> {
        self.table.columns(chunk)
    }

    #[inline(always)]
    fn is_plain(&self, chunk: usize) -> bool {
        let [first, chunks] = self.fine;
        chunk.wrapping_sub(first) < chunks
    }

    #[inline(always)]
    fn bars<'c, L: Lane>(&'c self, columns: Columns<'c>, g: usize) -> Bars<'c, L> {
        self.table.bars(columns, g)
    }
}

/// Geometry of a row of a graded network.
pub struct Graded<'a> {
    /// Line of the columns.
    columns: &'a [Chunk<COLUMN_PLANES>],
    row: OfRow,
    /// Segments of the bars upwards.
    segments: Splat,
}

impl<'a> Geometry<'a> for Graded<'a> {
    #[inline(always)]
    fn of(net: &Net<'a>, rests: [&Rest; 2], j: usize) -> Self {
        Graded { columns: net.columns, row: OfRow::of(net, rests, j), segments: Splat::of(net.row_segments(j)) }
    }

    #[inline(always)]
    fn in_memory(&self) -> &Self {
        black_box(self)
    }

    #[inline(always)]
    fn columns(&self, chunk: usize) -> Columns<'_> {
        Columns::of(self.columns, chunk).unwrap_or(UNREAD)
    }

    #[inline(always)]
    fn bars<'c, L: Lane>(&'c self, columns: Columns<'c>, g: usize) -> Bars<'c, L> {
        let shares = Some(Shares { columns: columns.shares, row: &self.segments, group: g });
        Bars { shares, ..self.row.bars(columns.swept, L::splat(NONE), g) }
    }
}

/// Geometry of any row.
pub struct Any<'a> {
    table: Table<'a>,
    /// Line of the columns of a graded network; else empty.
    columns: &'a [Chunk<COLUMN_PLANES>],
    /// Segments of the bars upwards.
    segments: Splat,
}

impl<'a> Geometry<'a> for Any<'a> {
    #[inline(always)]
    fn of(net: &Net<'a>, rests: [&Rest; 2], j: usize) -> Self {
        let columns = if net.lines.is_empty() { &[] } else { net.columns };
        Any { table: Table::of(net, rests, j), columns, segments: Splat::of(net.row_segments(j)) }
    }

    #[inline(always)]
    fn columns(&self, chunk: usize) -> Columns<'_> {
        Columns::of(self.columns, chunk).unwrap_or(self.table.columns(chunk))
    }

    #[inline(always)]
    fn bars<'c, L: Lane>(&'c self, columns: Columns<'c>, g: usize) -> Bars<'c, L> {
        let shares = Some(Shares { columns: columns.shares, row: &self.segments, group: g });
        Bars { shares, ..self.table.bars(columns, g) }
    }
}
