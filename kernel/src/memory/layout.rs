//! Sizes of a scene: nodes, rows, plies, segments, candidates, and what has to be kept of them. `arrays.rs`
//! counts the memory.

use crate::ground::error::{Code, Error};
use crate::ground::lanes::CacheLine;
use crate::ground::planes::{self, Axis, CARRY_PLANES, CHUNK, Chunk, HOT_PLANES, PAST_PLANES};
use crate::scene::features::{Feature, Features};
use crate::sheet::columns::COLUMN_PLANES;
use crate::sheet::symmetry::Line;

/// Hot rows of more numbers than this do not stay in a core's own caches from one step to the next, so that
/// steps pay in blocks: 4 MiB.
const OWN_CACHE_REALS: usize = (4 << 20) / 8;
/// Hot rows of more numbers than this do not stay in any cache, so that a pass fetches them from memory: 12
/// MiB, less than half of what the cores of a server share.
const CACHED_REALS: usize = (12 << 20) / 8;

/// Most steps of a block (`step/blocks.rs`); a divisor of the steps between two tests of outcomes.
pub(crate) const BLOCK_STEPS: u32 = 8;

/// Most bands a sheet can be cut into.
pub const MAX_BANDS: u32 = 32;

/// Sizes of a scene's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Nodes modelled along x: of a mirrored sheet only its half, of a graded network its own.
    pub nodes_x: usize,
    /// Rows of nodes modelled, ply by ply.
    pub nodes_y: usize,
    /// Separate plies.
    pub plies: usize,
    /// A row of nodes.
    pub x: Line,
    /// A column of nodes of one ply.
    pub y: Line,
    /// The first row of nodes beyond the middle of the sheet.
    pub upper: usize,
    /// Chunks in a row.
    pub chunks: usize,
    /// Features that the scene has in addition to a plain sheet.
    pub has: Features,
    /// Steps of a block that there is memory for, 4 or 8, and 1 where steps are taken one by one
    /// (`step/blocks.rs`).
    pub block_steps: u32,
    /// Whether impulses on the supports are summed.
    pub supports: bool,
    /// Greatest number of contact candidates: every node, if the scene does not ask for fewer.
    pub candidates: usize,
    pub(super) reals: usize,
    pub(super) words: usize,
    pub(super) image_words: usize,
}

impl Layout {
    /// No sheet: a place for the sizes of a scene.
    pub(crate) const NOTHING: Layout = Layout {
        nodes_x: 0,
        nodes_y: 0,
        plies: 1,
        x: Line { nodes: 0, mirrored: false, closed: false },
        y: Line { nodes: 0, mirrored: false, closed: false },
        upper: 0,
        chunks: 0,
        has: Features::NONE,
        block_steps: 1,
        supports: false,
        candidates: 0,
        reals: 0,
        words: 0,
        image_words: 0,
    };

    /// [`Layout::block_steps`]: more than 1 for a sheet that exceeds a core's own caches, of one ply without
    /// mirror planes and without what takes more than one pass or looks at the whole sheet between two steps.
    /// Half of the most with viscosity, with which a step reaches twice as many rows, which are to stay in
    /// the caches, and where the caches that cores share are quick to give a row back.
    pub(super) fn find_block_steps(&self) -> Option<u32> {
        use Feature::*;
        let options = [Theta, Slack, Rate, Grading, Casing].iter().any(|&feature| self.has(feature));
        let plain = self.plies == 1 && !(options || self.x.is_mirrored() || self.y.is_mirrored());
        let reals = self.nodes_y.checked_mul(self.chunks)?.checked_mul(CHUNK * HOT_PLANES)?;
        let pays = Blocks.is_built() && plain && reals > OWN_CACHE_REALS;
        let most = if self.has(Viscosity) || reals <= CACHED_REALS { BLOCK_STEPS / 2 } else { BLOCK_STEPS };
        Some(if pays { most } else { 1 })
    }

    /// Length of the memory that a simulation takes, in lines of 64 bytes.
    pub fn lines(&self) -> usize {
        self.shared_lines() + self.lines_of_reals() + self.words.div_ceil(CacheLine::WORDS)
    }

    /// Lines of these for the scratch of a step (`arrays.rs`), or the labels of the nodes when outcomes are
    /// tested: less than the hot rows, which have been counted.
    pub(crate) fn shared_lines(&self) -> usize {
        let labels = if self.has(Feature::Detachment) { self.nodes() } else { 0 };
        let noted: usize = self.step_scratch().iter().sum();
        noted.div_ceil(CacheLine::REALS).max(labels.div_ceil(CacheLine::WORDS))
    }

    /// Numbers of carried forces and of reactions that a step or a block of steps notes.
    pub(super) fn step_scratch(&self) -> [usize; 2] {
        let reactions = if self.supports { 6 * self.nodes_y * self.block_steps as usize } else { 0 };
        [self.carried_rows() * self.chunks * CHUNK * CARRY_PLANES, reactions]
    }

    /// Whether columns have constants of their own: those of a graded network or of a curved sheet.
    pub(super) fn has_columns(&self) -> bool {
        self.has(Feature::Grading) || self.has(Feature::Curved)
    }

    /// Lines of constants of columns, one of each ply.
    pub(super) fn lines_of_columns(&self) -> usize {
        if self.has_columns() { self.plies } else { 1 }
    }

    /// Candidates that there is memory for. The case below a node is one, too.
    pub(super) fn contacts(&self) -> Option<usize> {
        self.candidates.checked_mul(if self.has(Feature::Casing) { 2 } else { 1 })
    }

    /// Rows of carried forces: one for each ply, or for each step of a block.
    pub(crate) fn carried_rows(&self) -> usize {
        self.plies.max(self.block_steps as usize)
    }

    /// Lines of these that hold real numbers; the integers lie after them.
    pub(crate) fn lines_of_reals(&self) -> usize {
        self.reals.div_ceil(CacheLine::REALS)
    }

    /// Length of the memory that stepping in `of` bands takes in addition, in lines of 64 bytes.
    ///
    /// # Errors
    /// More bands than [`MAX_BANDS`], or none; the theta rule, which cannot be stepped in bands; more memory
    /// than a slice can hold, which wide sheets may need on targets of 32 bits.
    pub fn band_lines(&self, of: u32) -> Result<usize, Error> {
        if self.has(Feature::Theta) {
            return Err(Error::plain(Code::NotInBands, "integrator.kind"));
        }
        if !(1..=MAX_BANDS).contains(&of) {
            return Err(Error::new(Code::OutOfRange, "of", f64::from(of), f64::from(MAX_BANDS)));
        }
        // What has been found to fit bounds a band, some ten rows of the sheet, and not all bands.
        let lines =
            (of as usize).checked_mul(self.reals_of_a_band()).map(|reals| reals.div_ceil(CacheLine::REALS)).filter(
                |lines| lines.checked_mul(size_of::<CacheLine>()).is_some_and(|bytes| bytes <= isize::MAX as usize),
            );
        lines.ok_or(Error::plain(Code::TooManyNodes, "of"))
    }

    /// Rows of what viscosity keeps in the scratch of a band: two at each of its ends, and in each step of a
    /// block the row above a gap.
    pub(crate) fn viscous_rows_of_a_band(&self) -> [usize; 2] {
        if self.has(Feature::Viscosity) { [4, self.block_steps_of_a_band()] } else { [0; 2] }
    }

    /// Steps of a block whose rows a band keeps.
    pub(crate) fn block_steps_of_a_band(&self) -> usize {
        if self.block_steps > 1 { self.block_steps as usize } else { 0 }
    }

    /// Numbers of one band: a row above it, forces from below it, both of every step of a block, too, copies
    /// of viscosity's at its ends, its fixed nodes; whole cache lines.
    pub(crate) fn reals_of_a_band(&self) -> usize {
        let (rows, [at_cuts, above_gap]) = (1 + self.block_steps_of_a_band(), self.viscous_rows_of_a_band());
        self.chunks * CHUNK * (rows * (HOT_PLANES + CARRY_PLANES) + (at_cuts + above_gap) * PAST_PLANES)
            + (3 * self.nodes_x).next_multiple_of(CacheLine::REALS)
    }

    /// Bytes of memory in all.
    pub fn bytes(&self) -> usize {
        size_of::<CacheLine>() * self.lines()
    }

    /// Bytes of a snapshot image.
    pub fn snapshot_bytes(&self) -> usize {
        8 * self.image_words
    }

    /// Number of nodes modelled.
    pub fn nodes(&self) -> usize {
        self.nodes_x * self.nodes_y
    }

    /// Column and row (i, j) of a node by its number, row by row.
    #[inline]
    pub fn column_and_row(&self, node: usize) -> (usize, usize) {
        // At least 1, so that no division by zero has to be compiled in.
        let nx = self.nodes_x.max(1);
        (node % nx, node / nx)
    }

    /// Place of a node by its number: column and row of the sheet, ply.
    #[inline]
    pub(crate) fn place(&self, node: usize) -> [usize; 3] {
        let (i, j) = self.column_and_row(node);
        let (ply, row) = self.ply_and_row(j);
        [i, row, ply]
    }

    /// Place of the first of the chunks with the nodes at column i of a row of the sheet, in all plies, and
    /// how far the next one is from it.
    #[inline]
    pub(crate) fn stacked(&self, i: usize, row: usize) -> [usize; 2] {
        [row * self.chunks + i / CHUNK, self.y.modelled() * self.chunks]
    }

    /// Number of segments modelled, those from the last node before a mirror plane to its image included.
    pub fn segments(&self) -> usize {
        self.x.segments() * self.nodes_y + self.nodes_x * self.y.segments() * self.plies
    }

    /// Calls `each` with the direction of every segment and the node where it starts, in the order of their
    /// numbers.
    pub(crate) fn for_each_segment(&self, mut each: impl FnMut(Axis, usize, usize)) {
        let all = (0..self.plies).flat_map(|ply| [(Axis::Horizontal, ply), (Axis::Vertical, ply)]);
        for (axis, ply) in all {
            let [first, end] = self.rows_of(ply);
            let columns = if axis == Axis::Horizontal { self.x.segments() } else { self.nodes_x };
            for j in (first..end).filter(|&j| axis == Axis::Horizontal || self.has_verticals(j)) {
                (0..columns).for_each(|i| each(axis, i, j));
            }
        }
    }

    /// Rows of the hot block: those modelled, and the ghost row beyond the plane y = 0.
    pub(crate) fn stored_rows(&self) -> usize {
        self.nodes_y + usize::from(self.y.is_mirrored())
    }

    /// Whether the hot rows are too large for the caches, so that a pass has to fetch them from memory.
    pub(crate) fn exceeds_caches(&self) -> bool {
        self.nodes_y * self.chunks * CHUNK * HOT_PLANES > CACHED_REALS
    }

    /// Whether the scene has a feature, and this build, too.
    #[inline(always)] // As `Features::has`.
    pub const fn has(&self, feature: Feature) -> bool {
        self.has.has(feature)
    }

    /// Line of a ply among those of all, see [`Net`](crate::sheet::columns::Net).
    #[inline]
    pub(crate) fn columns_of<'a>(&self, lines: &'a [Chunk<COLUMN_PLANES>], ply: usize) -> &'a [Chunk<COLUMN_PLANES>] {
        if self.lines_of_columns() > 1 { planes::row(lines, self.chunks, ply) } else { lines }
    }

    /// Whether there are several plies.
    pub fn is_stack(&self) -> bool {
        self.has(Feature::Plies)
    }

    /// Rows [first, end) of a ply.
    pub fn rows_of(&self, ply: usize) -> [usize; 2] {
        let rows = self.y.modelled();
        [ply * rows, (ply + 1) * rows]
    }

    /// The ply of a row, and the row's number in it.
    #[inline]
    pub fn ply_and_row(&self, j: usize) -> (usize, usize) {
        if !self.is_stack() {
            return (0, j);
        }
        // At least 1, so that no division by zero has to be compiled in.
        let rows = self.y.modelled().max(1);
        (j / rows, j % rows)
    }

    /// Whether segments go upwards from row j.
    #[inline]
    pub fn has_verticals(&self, j: usize) -> bool {
        let (ply, row) = self.ply_and_row(j);
        row < self.y.segments() && ply < self.plies
    }

    /// Whether velocities of ghost columns are read: for moments of viscosity and for the slack balance.
    pub(crate) fn reads_ghost_speeds(&self) -> bool {
        self.has(Feature::Viscosity) || self.has(Feature::Slack)
    }

    /// Whether viscosity or the rate dissipates energy.
    pub fn dissipates(&self) -> bool {
        self.has.dissipate()
    }

    /// Whether anything but elasticity and damage acts in the sweep.
    pub(crate) fn has_effects(&self) -> bool {
        self.dissipates() || self.has(Feature::Slack) || self.has(Feature::Casing)
    }

    /// Whether segments have constants of their own: drawn ones, those of a graded network, or those of plies
    /// with radii of their own.
    pub fn has_constants(&self) -> bool {
        self.has(Feature::Drawn) || self.has(Feature::Grading) || self.has(Feature::Curved) && self.is_stack()
    }

    /// Multiplicity of node (i, j) in the whole sheet. Of a graded network `System::share` has its mass,
    /// too.
    pub fn node_weight(&self, i: usize, j: usize) -> f64 {
        self.x.node_weight(i) * self.y.node_weight(j)
    }

    /// Multiplicity of the segment that starts at node (i, j) in the whole sheet.
    pub fn segment_weight(&self, axis: Axis, i: usize, j: usize) -> f64 {
        match axis {
            Axis::Horizontal => self.x.segment_weight(i) * self.y.node_weight(j),
            Axis::Vertical => self.x.node_weight(i) * self.y.segment_weight(j),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::ground::lanes::Item;
    use crate::ground::planes::{
        ENERGY_ERROR_PLANES, HISTORY_PLANES, ITERATE_PLANES, PAST_PLANES, STRENGTH_PLANES, YARN_PLANES,
    };
    use crate::memory::image::frame_words;
    use crate::memory::records::{Candidate, Tangential};

    #[test]
    fn bytes_per_node_of_the_large_sheet() {
        let mut scene = Scene::sheet_10in_cylinder();
        let stochastic = Layout::of(&scene).unwrap();
        assert_eq!((stochastic.chunks, stochastic.nodes(), stochastic.segments()), (44, 122_500, 244_300));
        scene.track_support = false;
        // What steps in blocks note has room where the nodes have their labels; without them six numbers a
        // row and step, and three a column and step.
        assert_eq!(stochastic.bytes(), Layout::of(&scene).unwrap().bytes());
        scene.track_detachment = false;
        let noted = |scene: &Scene| Layout::of(scene).unwrap().shared_lines();
        assert_eq!(noted(&scene), 4 * 3 * 44);
        scene.track_support = true;
        assert_eq!(noted(&scene), 4 * (3 * 44 + 6 * 350 / 8) + 2);
        scene.track_detachment = true;
        // A place for every node as a candidate takes 120; or room for what wraps the cylinder, and half as
        // much again.
        for (stochastic, capacity, most) in
            [(true, 0, 237.0), (false, 0, 205.0), (true, 7250, 124.1), (false, 7250, 92.1)]
        {
            (scene.yarn.stochastic, scene.contact_capacity) = (stochastic, capacity);
            let bytes = Layout::of(&scene).unwrap().bytes() as f64 / 122_500.0;
            assert!(bytes <= most, "{bytes} of {most}");
        }
    }

    #[test]
    fn sheets_that_exceed_the_caches() {
        let mut scene = Scene::sheet_3in_sphere();
        // 64 bytes a node, rows in whole chunks of eight: 255 rows of 256 nodes are 3.98 MiB, 257 of 264 are
        // 4.1 MiB; 439 of 440 are 11.8 MiB, 447 of 448 are 12.2 MiB.
        for (nodes, exceeds, steps) in [(255, false, 1), (257, false, 4), (439, false, 4), (447, true, 8)] {
            (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nodes, nodes);
            let layout = Layout::of(&scene).unwrap();
            assert_eq!((layout.exceeds_caches(), layout.block_steps), (exceeds, steps));
        }
        // Three bands keep a row and its forces, and both of eight steps; then the fixed nodes in whole cache
        // lines.
        let reals: usize = 3 * (9 * 56 * 8 * (HOT_PLANES + CARRY_PLANES) + 1344);
        assert_eq!(Layout::of(&scene).unwrap().band_lines(3).unwrap(), reals.div_ceil(8));
        // Seven steps more: carried forces of 56 chunks and six numbers a row of each, to the next line. With
        // slack balance a step is taken alone.
        scene.track_detachment = false;
        let blocks = Layout::of(&scene).unwrap();
        scene.slack_balance = true;
        let single = Layout::of(&scene).unwrap();
        let energy_error = 447 * 56 * 8 * ENERGY_ERROR_PLANES;
        assert_eq!(single.block_steps, 1);
        assert_eq!(single.reals - blocks.reals, energy_error);
        let more = 7 * (56 * 8 * CARRY_PLANES + 6 * 447);
        assert!((8 * (blocks.shared_lines() - single.shared_lines())).abs_diff(more) < 8);
    }

    /// 9 x 5 nodes, uniform yarn, at most 10 candidates: two chunks, 16 columns, a row.
    fn tiny() -> Scene {
        let mut scene = crate::tests::sheet(9, 5);
        (scene.yarn.stochastic, scene.track_detachment, scene.track_support) = (false, false, false);
        scene.contact_capacity = 10;
        scene
    }

    #[test]
    fn memory_counted_by_hand() {
        let layout = Layout::of(&tiny()).unwrap();
        // Segments: 8 in each of 5 rows, 4 in each of 9 columns.
        assert_eq!((layout.nodes(), layout.segments(), layout.chunks), (45, 40 + 36, 2));
        // Displacements, velocities, stiffness and history of 5 rows; three numbers a column; the candidates.
        // Words: eight a row. Carried forces of a row, in whole lines.
        let rows = 5 * 16 * (HOT_PLANES + HISTORY_PLANES) + 3 * 9;
        assert_eq!((layout.reals, layout.words), (rows + 10 * Candidate::NUMBERS, 8 * 5));
        assert_eq!(layout.shared_lines(), 2 * CARRY_PLANES);
        assert_eq!(layout.lines(), layout.reals.div_ceil(8) + 3 + 6);
        assert_eq!(layout.bytes(), 64 * layout.lines());
        let frame = frame_words(layout.has);
        assert_eq!(layout.snapshot_bytes(), 8 * (6 * 45 + 76 + frame));
        // Three bands: for each a row above it, carried forces, its fixed nodes in whole cache lines.
        let reals: usize = 3 * (16 * (HOT_PLANES + CARRY_PLANES) + 32);
        assert_eq!(layout.band_lines(3).unwrap(), reals.div_ceil(8));
    }

    #[test]
    fn what_options_add() {
        let plain = Layout::of(&tiny()).unwrap();
        let with = |change: &dyn Fn(&mut Scene)| {
            let mut scene = tiny();
            change(&mut scene);
            let more = Layout::of(&scene).unwrap();
            (more.reals - plain.reals, more.words - plain.words, more.image_words - plain.image_words)
        };
        assert_eq!(with(&|scene| scene.yarn.stochastic = true), (5 * 16 * YARN_PLANES, 0, 0));
        let drawn = |scene: &mut Scene| scene.yarn.strength_draw = crate::StrengthDraw::Weibull;
        assert_eq!(with(&drawn), (5 * 16 * STRENGTH_PLANES, 0, 0));
        // A word for each row; of the image two for each of 76 segments, too.
        assert_eq!(with(&|scene| scene.slack_balance = true), (5 * 16 * ENERGY_ERROR_PLANES, 5, 5 + 2 * 76));
        // Past of 5 rows, what each takes; of the image two words for each of 76 segments and 45 nodes, and
        // one more.
        let viscous = |scene: &mut Scene| scene.yarn.viscosity_bending = 0.06;
        assert_eq!(with(&viscous), (5 * 16 * PAST_PLANES + 5, 0, 2 * (76 + 45) + 1));
        // The energy of each row; two words of the image.
        let rate = |scene: &mut Scene| {
            (scene.yarn.rate_modulus, scene.yarn.rate_reference, scene.yarn.rate_limit) = (0.1, 30.0, 170.0);
        };
        assert_eq!(with(&rate), (5, 0, 2));
        // The tangential parts of 10 candidates; two words of the image.
        let friction = |scene: &mut Scene| scene.contact.friction = 0.3;
        assert_eq!(with(&friction), (10 * Tangential::NUMBERS, 0, 2));
        // A bit for every node: 45 in two words. Their labels are in the lines that carried forces have;
        // reactions need 30 numbers more.
        assert_eq!(with(&|scene| scene.track_detachment = true), (0, 2, 2));
        let shared = |labels, reactions| {
            let mut scene = tiny();
            (scene.track_detachment, scene.track_support) = (labels, reactions);
            Layout::of(&scene).unwrap().shared_lines()
        };
        assert_eq!(
            [shared(false, false), shared(true, false), shared(false, true), shared(true, true)],
            [6, 6, 10, 10]
        );
        assert_eq!(with(&|scene| scene.contact_capacity = 15), (5 * Candidate::NUMBERS, 0, 0));
        // More than all 45 nodes cannot come.
        assert_eq!(with(&|scene| scene.contact_capacity = u32::MAX), (35 * Candidate::NUMBERS, 0, 0));
        let theta = |scene: &mut Scene| scene.integrator = crate::scene::parts::Integrator::THETA;
        assert_eq!(with(&theta), (5 * 16 * ITERATE_PLANES + 10, 0, 2));
    }

    #[test]
    fn mirrored_rows_have_an_image_row() {
        let mut scene = tiny();
        scene.symmetry.mirror_y = true;
        let layout = Layout::of(&scene).unwrap();
        // Rows 0 to 2 and the image of row 1; the columns have a segment from each of the three.
        assert_eq!((layout.nodes(), layout.segments()), (27, 3 * 8 + 3 * 9));
        let rows = 16 * (4 * HOT_PLANES + 3 * HISTORY_PLANES) + 3 * 9;
        assert_eq!(layout.reals, rows + 10 * Candidate::NUMBERS);
    }

    /// Nodes are numbered by u32: one more would be taken for another.
    #[test]
    #[cfg(target_pointer_width = "64")]
    fn as_many_nodes_as_have_numbers() {
        let mut scene = tiny();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (1 << 16, (1 << 16) - 1);
        assert!(Layout::of(&scene).is_ok());
        scene.sheet.nodes_y += 1;
        let error = Layout::of(&scene).unwrap_err();
        assert_eq!((error.code, error.limit), (Code::TooManyNodes, f64::from(u32::MAX)));
    }

    /// A scene's check refuses so many nodes before; on a machine of 32 bits it does not need to be so many.
    #[test]
    #[cfg(target_pointer_width = "64")]
    fn memory_ends_where_slices_end() {
        let of = |nodes_x: u32, nodes_y: u32| {
            let mut scene = tiny();
            (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nodes_x, nodes_y);
            Layout::compute(&scene)
        };
        // 80 bytes a node, and few more: 2^62.3, 2^63.3 and 2^64.3 of them, and more nodes than can be
        // counted.
        assert!(of(1 << 27, 1 << 29).is_some());
        assert_eq!([of(1 << 28, 1 << 29), of(1 << 29, 1 << 29), of(u32::MAX, u32::MAX)], [None; 3]);
    }

    #[test]
    fn weights_count_the_whole_sheet() {
        for (nodes, mirror_x, mirror_y) in [([9, 6], true, false), ([9, 6], false, true), ([8, 7], true, true)] {
            let mut scene = tiny();
            (scene.sheet.nodes_x, scene.sheet.nodes_y) = nodes.into();
            scene.symmetry = crate::scene::parts::Symmetry { mirror_x, mirror_y };
            let layout = Layout::of(&scene).unwrap();
            let sum = |weight: &dyn Fn(usize, usize) -> f64, end: [usize; 2]| -> f64 {
                (0..end[1]).flat_map(|j| (0..end[0]).map(move |i| (i, j))).map(|(i, j)| weight(i, j)).sum()
            };
            let [nx, ny] = nodes.map(f64::from);
            let (across, up) = (layout.x.segments(), layout.y.segments());
            assert_eq!(sum(&|i, j| layout.node_weight(i, j), [layout.nodes_x, layout.nodes_y]), nx * ny);
            let horizontal = sum(&|i, j| layout.segment_weight(Axis::Horizontal, i, j), [across, layout.nodes_y]);
            let vertical = sum(&|i, j| layout.segment_weight(Axis::Vertical, i, j), [layout.nodes_x, up]);
            assert_eq!((horizontal, vertical), ((nx - 1.0) * ny, nx * (ny - 1.0)));
        }
    }
}
