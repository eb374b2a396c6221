//! The caller's memory: what it holds, in one list from which it is counted and cut. All sizes are found
//! here, with checked arithmetic. `planes.rs` says how rows lie in memory.

use crate::ground::error::{Code, Error};
use crate::ground::lanes::{CacheLine, Item};
use crate::ground::planes::{
    Axis, CARRY_PLANES, CHUNK, Chunk, ENERGY_ERROR_PLANES, HISTORY_PLANES, HOT_PLANES, ITERATE_PLANES, PAST_PLANES,
    STRENGTH_PLANES, YARN_PLANES,
};
use crate::memory::image;
use crate::memory::layout::Layout;
use crate::memory::records::{Candidate, Node, PlyContact, PlyFriction, Pool, Tangential};
use crate::scene::features::{Feature, Features};
use crate::scene::parts::Scene;
use crate::sheet::clamp::{self, CLAMP_PLANES, Clamps};
use crate::sheet::columns::COLUMN_PLANES;
use crate::sheet::places::Places;
use crate::sheet::symmetry::Line;
use crate::sheet::weave::in_runs;
use core::ops::Range;

impl Layout {
    /// Sizes for a scene, which is checked first.
    pub fn of(scene: &Scene) -> Result<Layout, Error> {
        scene.check()?;
        Layout::of_sound(scene)
    }

    /// Sizes for a scene that has been checked.
    pub(crate) fn of_sound(scene: &Scene) -> Result<Layout, Error> {
        // Nodes are numbered by u32 where contact and detachment note them.
        let numbered = |layout: &Layout| u32::try_from(layout.nodes()).is_ok();
        Layout::compute(scene).filter(numbered).ok_or(Error::new(
            Code::TooManyNodes,
            "sheet.nodes_x",
            scene.sheet.nodes_x as f64 * scene.sheet.nodes_y as f64 * scene.stack.plies as f64,
            u32::MAX.into(),
        ))
    }

    #[inline(never)]
    pub(super) fn compute(scene: &Scene) -> Option<Layout> {
        let [across, up] = scene.network();
        let x = Line { nodes: across, mirrored: scene.symmetry.mirror_x, closed: scene.sheet.closed };
        let y = Line { nodes: up, mirrored: scene.symmetry.mirror_y, closed: false };
        let plies = scene.stack.plies as usize;
        let (nodes_x, nodes_y) = (x.modelled(), y.modelled().checked_mul(plies)?);
        let nodes = nodes_x.checked_mul(nodes_y)?;
        let mut layout = Layout {
            nodes_x,
            nodes_y,
            plies,
            x,
            y,
            upper: 0,
            chunks: x.stored().div_ceil(CHUNK),
            has: Features::of(scene),
            block_steps: 1,
            supports: scene.track_support || Feature::Clamps.is_in(scene),
            candidates: match scene.contact_capacity {
                0 => nodes,
                most => nodes.min(most as usize),
            },
            reals: 0,
            words: 0,
            image_words: 0,
        };
        layout.block_steps = layout.find_block_steps()?;
        [layout.reals, layout.words] = Arrays::count(&layout)?;
        layout.image_words = image::words(&layout)?;
        // Neither memory nor image may exceed what a slice can hold.
        for (count, bytes) in [(layout.lines(), size_of::<CacheLine>()), (layout.image_words, 8)] {
            if count.checked_mul(bytes)? > isize::MAX as usize {
                return None;
            }
        }
        layout.upper = Places::of(scene, Axis::Vertical).upper();
        Some(layout)
    }
}

/// Refuses memory that is too short for a scene of these sizes.
pub(crate) fn check(memory: &[CacheLine], layout: &Layout) -> Result<(), Error> {
    let (have, need) = (memory.len(), layout.lines());
    if have < need { Err(short("memory", have, need)) } else { Ok(()) }
}

/// The refusal of so many lines, where as many are needed: lengths in bytes.
pub(crate) fn short(field: &'static str, have: usize, need: usize) -> Error {
    let [have, need] = [have, need].map(|lines| (lines * size_of::<CacheLine>()) as f64);
    Error::new(Code::ShortBuffer, field, have, need)
}

/// Table of the arrays: name, item, condition on which it is kept, how many, with meaning and unit. `rows`
/// have [steps, rows, items a row]. `$then` takes the table: [`Arrays`] with its counting, cutting and rows
/// [first, end) follow from it, and the rows of bands.
macro_rules! arrays {
    ($then:ident) => {
        $then! { layout;
            rows {
                /// Displacement, spacings, velocity, spacings a step, and stiffness of the two segments that
                /// begin at each node.
                hot: [Chunk<HOT_PLANES>], true, [1, layout.stored_rows(), layout.chunks];
                /// Largest q beyond critical of each segment; `planes.rs` says what it is before.
                history: [Chunk<HISTORY_PLANES>], true, [1, layout.nodes_y, layout.chunks];
                /// Undamaged stiffness and damage rate of each segment.
                yarn: [Chunk<YARN_PLANES>], layout.has_constants(), [1, layout.nodes_y, layout.chunks];
                /// Critical stretch of each segment.
                strength: [Chunk<STRENGTH_PLANES>], layout.has(Feature::Strength), [1, layout.nodes_y, layout.chunks];
                /// Energy error and last stress of each segment that may be slack.
                energy_error: [Chunk<ENERGY_ERROR_PLANES>], layout.has(Feature::Slack), [1, layout.nodes_y, layout.chunks];
                /// Guess and accelerations of the theta rule, spacings and steps.
                iterate: [Chunk<ITERATE_PLANES>], layout.has(Feature::Theta), [1, layout.stored_rows(), layout.chunks];
                /// Twice the strain and viscous stress of each segment in the last step, moments of each
                /// node.
                past: [Chunk<PAST_PLANES>], layout.has(Feature::Viscosity), [1, layout.stored_rows(), layout.chunks];
                /// Impulse of the case on each row, components x and z, and energy dissipated by it, per
                /// lane; m h/dt, m (h/dt)^2.
                case_impulse_of_row: [[[f64; CHUNK]; 3]], layout.has(Feature::Casing), [1, layout.nodes_y, 1];
                /// Impulse of the case on each node, spacings a step times its mass.
                case_impulse: [[f64; CHUNK]], layout.has(Feature::Casing), [1, layout.nodes_y, layout.chunks];
                /// Clamp of each node (`sheet/clamp.rs`).
                clamps: [Chunk<CLAMP_PLANES>], layout.has(Feature::Clamps), [1, layout.nodes_y, layout.chunks];
                /// Velocity of each node normal to the sheet before the sweep, spacings/step.
                before: [[f64; CHUNK]], layout.is_stack(), [1, layout.nodes_y, layout.chunks];
                /// Energy that viscosity and rate dissipate in each row in a step, m (h/dt)^2.
                dissipated: [f64], layout.dissipates(), [layout.block_steps as usize, layout.nodes_y, 1];
                /// Energy that the clamps of each row dissipate in a step, m (h/dt)^2.
                clamped: [f64], layout.has(Feature::Clamps), [layout.block_steps as usize, layout.nodes_y, 1];
                /// Fixed nodes of each row: two runs of columns [first, end).
                runs: [[u32; 4]], true, [1, layout.nodes_y, 1];
                /// Least and greatest displacement of each row, along y and then along x, as `ranges.rs`
                /// keeps them; along x only where contact asks for it.
                ranges: [[u32; 4]], true, [1, layout.nodes_y, 1];
                /// Bits of the directions in which a segment of each row has been slack.
                been_slack: [u32], layout.has(Feature::Slack), [1, layout.nodes_y, 1];
            }
            others {
                /// Constants of the columns (`columns.rs`) of a graded network or a curved sheet: a line of
                /// each ply.
                columns: [Chunk<COLUMN_PLANES>], layout.has_columns(), [1, layout.lines_of_columns(), layout.chunks];
                /// Constants of the rows of all plies of a graded network (`columns.rs`).
                lines: [Chunk<COLUMN_PLANES>], layout.has(Feature::Grading), [1, 1, layout.nodes_y.div_ceil(CHUNK)];
                /// Displacements of the fixed nodes of a row during its sweep, and velocities where clamps
                /// slip; spacings and steps.
                kept: [[f64; 3]], true, [1, 1, layout.nodes_x];
                /// Nodes with an impulse since the last outcome test, a bit each.
                flags: [u32], layout.has(Feature::Detachment), [1, 1, layout.nodes().div_ceil(32)];
                /// Awake rows [first, end) of each ply.
                awake: [[u32; 2]], layout.is_stack(), [1, 1, layout.plies];
            }
            contacts {
                /// Candidates for contact.
                candidates: [Candidate], true, [1, 1, layout.contacts()?];
                /// Friction of each candidate.
                tangential: [Tangential], layout.has(Feature::Friction), [1, 1, layout.contacts()?];
                /// Gaps of the candidates over dt in the theta rule, m/s.
                gaps_over_dt: [f64], layout.has(Feature::Theta), [1, 1, layout.contacts()?];
                /// Contacts of a stack, sorted by column (`contact/by_column.rs`).
                of_plies: [PlyContact], layout.is_stack(), [1, 1, layout.contacts()?];
                /// Friction of each of them.
                ply_friction: [PlyFriction], layout.is_stack() && layout.has(Feature::Friction), [1, 1, layout.contacts()?];
                /// Candidate that leads the column at each place.
                leaders: [u32], layout.is_stack(), [1, layout.nodes_x, layout.y.modelled()];
                /// End in `of_plies` of the column that each candidate leads.
                ends: [u32], layout.is_stack(), [1, 1, layout.contacts()?];
                /// Column of facing nodes (`contact/column.rs`).
                nodes_of_column: [Node], layout.is_stack(), [1, 1, layout.plies];
                /// Pools of the column, first come first.
                pools: [Pool], layout.is_stack(), [1, 1, layout.plies];
                /// Velocities of eight columns across the sheet, with gaps added up, ply by ply
                /// (`contact/separate.rs`), spacings/step.
                speeds_of_columns: [[f64; CHUNK]], layout.is_stack(), [1, 1, layout.plies];
                /// Velocities with which each of them ends, spacings/step.
                ends_of_columns: [[f64; CHUNK]], layout.is_stack(), [1, 1, layout.plies];
            }
        }
    };
}
pub(crate) use arrays;

macro_rules! define {
    ($layout:ident;
     rows { $($(#[$meaning:meta])* $row:ident: [$item:ty], $kept:expr, [$steps:expr, $rows:expr, $width:expr];)* }
     others { $($(#[$about:meta])* $other:ident: [$kind:ty], $needed:expr, $length:expr;)* }
     contacts { $($(#[$says:meta])* $contact:ident: [$record:ty], $asked:expr, $places:expr;)* }) => {
        /// Arrays that have items for each row, of all rows or of rows [first, end).
        pub(crate) struct RowArrays<'a> {
            $($(#[$meaning])* pub $row: &'a mut [$item],)*
        }

        /// The caller's memory but for contacts, cut into arrays. One that the scene does not need has length
        /// 0.
        pub(crate) struct Arrays<'a> {
            pub rows: RowArrays<'a>,
            $($(#[$about])* pub $other: &'a mut [$kind],)*
            /// Memory shared by steps ([`StepScratch`]) and the search for connected components (a label for
            /// every node), in turn.
            pub shared: &'a mut [CacheLine],
        }

        /// The caller's memory for contacts, cut into arrays, which a step fills anew. One that the scene
        /// does not need has length 0.
        pub(crate) struct Contacts<'a> {
            $($(#[$says])* pub $contact: &'a mut [$record],)*
        }

        impl<'a> Contacts<'a> {
            /// No memory.
            pub(crate) const fn nothing() -> Contacts<'a> {
                Contacts { $($contact: &mut [],)* }
            }

            /// Cuts the arrays off the memory.
            fn cut(&mut self, memory: &mut Memory<'a>, $layout: &Layout) -> Option<()> {
                $(self.$contact = memory.take($asked, $places)?;)*
                Some(())
            }
        }

        /// Pointers to the arrays that have items for each row.
        #[derive(Clone, Copy)]
        pub(crate) struct RowPointers {
            $(pub $row: *mut [$item],)*
        }

        impl<'a> Arrays<'a> {
            /// No memory.
            pub(crate) const fn nothing() -> Arrays<'a> {
                let rows = RowArrays { $($row: &mut [],)* };
                Arrays { rows, $($other: &mut [],)* shared: &mut [] }
            }

            /// Cuts the arrays off the memory.
            fn cut(&mut self, memory: &mut Memory<'a>, $layout: &Layout) -> Option<()> {
                $(self.rows.$row = memory.take($kept, [$steps, $rows, $width])?;)*
                $(self.$other = memory.take($needed, $length)?;)*
                Some(())
            }
        }

        impl RowArrays<'_> {
            /// Rows [first, end) in a step of a block, the first one otherwise, and the rows above them.
            /// None: an array is shorter than the layout says.
            #[inline(always)]
            pub(crate) fn split(&mut self, $layout: &Layout, rows: [usize; 2], step: usize) -> Option<[RowArrays<'_>; 2]> {
                $(let $row = if $kept { part(self.$row, $layout.part([$steps, $width], rows, step))? } else { Default::default() };)*
                Some([RowArrays { $($row: $row.0,)* }, RowArrays { $($row: $row.1,)* }])
            }

            /// Pointers to the arrays.
            pub(crate) fn pointers(&mut self) -> RowPointers {
                RowPointers { $($row: self.$row,)* }
            }
        }
    };
}
arrays! { define }

impl RowArrays<'_> {
    /// Numbers of the arrays that an image holds, in the order of [`image::Array`].
    pub(crate) fn numbers(&self) -> [&[f64]; 5] {
        let (hot, past) = (self.hot.as_flattened().as_flattened(), self.past.as_flattened().as_flattened());
        let (history, energy_error) =
            (self.history.as_flattened().as_flattened(), self.energy_error.as_flattened().as_flattened());
        [hot, self.clamps.as_flattened().as_flattened(), past, history, energy_error]
    }

    /// Whether a node belongs to an attachment, which may have let go of it.
    pub fn is_attached(&self, [i, j]: [usize; 2]) -> bool {
        self.runs.get(j).is_some_and(|run| in_runs(run, i))
    }

    /// Whether a support holds a node in its place, or slides with it in the sheet.
    pub fn is_fixed(&self, layout: &Layout, clamps: &Clamps, [i, j]: [usize; 2]) -> bool {
        let slid = || clamp::slid_by(self.clamps, j * layout.chunks + i / CHUNK, i % CHUNK);
        self.is_attached([i, j]) && clamps.hold(slid())
    }

    /// Whether a node belongs to an attachment that may slip.
    pub fn is_clamped(&self, [i, j]: [usize; 2]) -> bool {
        clamp::at(self.clamps, 0).is_some() && self.is_attached([i, j])
    }

    /// [`RowArrays::numbers`], to be changed.
    pub(crate) fn numbers_mut(&mut self) -> [&mut [f64]; 5] {
        let (hot, past) =
            (self.hot.as_flattened_mut().as_flattened_mut(), self.past.as_flattened_mut().as_flattened_mut());
        let (history, energy_error) = (
            self.history.as_flattened_mut().as_flattened_mut(),
            self.energy_error.as_flattened_mut().as_flattened_mut(),
        );
        [hot, self.clamps.as_flattened_mut().as_flattened_mut(), past, history, energy_error]
    }
}

/// Items of a range, and those after it.
#[inline(always)]
fn part<T>(array: &mut [T], range: Range<usize>) -> Option<(&mut [T], &mut [T])> {
    let (before, after) = array.split_at_mut_checked(range.end)?;
    Some((before.get_mut(range.start..)?, after))
}

impl Layout {
    /// Items of rows [first, end) in a step of a block, the first one otherwise.
    #[inline(always)]
    pub(crate) fn part(&self, [steps, width]: [usize; 2], [first, end]: [usize; 2], step: usize) -> Range<usize> {
        let before = if step < steps { step * self.nodes_y } else { 0 };
        (before + first) * width..(before + end) * width
    }
}

impl<'a> Arrays<'a> {
    /// Cuts memory that has been found to be enough, for these arrays and the contacts.
    pub(crate) fn carve(
        &mut self,
        contacts: &mut Contacts<'a>,
        memory: &'a mut [CacheLine],
        layout: &Layout,
    ) -> Result<(), Error> {
        let short = short("memory", memory.len(), layout.lines());
        let memory = memory.get_mut(..layout.lines()).ok_or(short)?;
        let Some((reals, rest)) = memory.split_at_mut_checked(layout.lines_of_reals()) else { return Err(short) };
        let Some((shared, words)) = rest.split_at_mut_checked(layout.shared_lines()) else { return Err(short) };
        let (reals, words) = (Carver::of(CacheLine::reals(reals)), Carver::of(CacheLine::words(words)));
        let mut memory = Memory { reals, words };
        self.cut(&mut memory, layout).ok_or(short)?;
        contacts.cut(&mut memory, layout).ok_or(short)?;
        self.shared = shared;
        Ok(())
    }

    /// Numbers and words that they have.
    fn count(layout: &Layout) -> Option<[usize; 2]> {
        let mut memory = Memory { reals: Carver::counting(), words: Carver::counting() };
        Arrays::nothing().cut(&mut memory, layout)?;
        Contacts::nothing().cut(&mut memory, layout)?;
        Some([memory.reals.taken, memory.words.taken])
    }
}

/// Memory that is cut, or only counted.
struct Memory<'a> {
    reals: Carver<'a, f64>,
    words: Carver<'a, u32>,
}

impl<'a> Memory<'a> {
    /// As many items as the product of these factors, none if they are not kept; nothing while counting.
    /// Items of whole cache lines lie before others, so that all of them begin at one. None: there are not so
    /// many.
    fn take<I: Item<Number: Kind>>(&mut self, kept: bool, factors: [usize; 3]) -> Option<&'a mut [I]> {
        let count = if kept { factors.into_iter().try_fold(I::NUMBERS, usize::checked_mul)? } else { 0 };
        I::Number::carver(self).take(count, I::NUMBERS.is_multiple_of(CacheLine::REALS)).map(I::of)
    }
}

/// Kind of numbers in memory, with those of it that are left.
trait Kind: Sized {
    fn carver<'m, 'a>(memory: &'m mut Memory<'a>) -> &'m mut Carver<'a, Self>;
}

impl Kind for f64 {
    fn carver<'m, 'a>(memory: &'m mut Memory<'a>) -> &'m mut Carver<'a, f64> {
        &mut memory.reals
    }
}

impl Kind for u32 {
    fn carver<'m, 'a>(memory: &'m mut Memory<'a>) -> &'m mut Carver<'a, u32> {
        &mut memory.words
    }
}

impl Contacts<'_> {
    /// The first so many candidates.
    pub fn found(&self, count: usize) -> &[Candidate] {
        self.candidates.get(..count).unwrap_or(&[])
    }

    /// Lets two candidates change places.
    pub(crate) fn swap(&mut self, a: usize, b: usize) {
        swap(self.candidates, a, b);
        swap(self.tangential, a, b);
        swap(self.gaps_over_dt, a, b);
    }
}

/// Scratch of a step: carried forces and reactions.
pub(crate) struct StepScratch<'r> {
    /// The vertical forces that are carried upwards: a row for each ply, of steps in blocks
    /// (`step/blocks.rs`) for each step.
    pub carries: &'r mut [Chunk<CARRY_PLANES>],
    /// Reactions of both runs of fixed nodes of each row, in units of m h/dt; of steps in blocks
    /// one step after the other.
    pub reactions: &'r mut [[[f64; 3]; 2]],
}

impl<'r> StepScratch<'r> {
    /// In the lines that [`Arrays`] share for it.
    pub fn of(shared: &'r mut [CacheLine], layout: &Layout) -> StepScratch<'r> {
        let [carries, reactions] = layout.step_scratch();
        let (carries, rest) = CacheLine::reals(shared).split_at_mut_checked(carries).unwrap_or_default();
        StepScratch { carries: Item::of(carries), reactions: Item::of(rest.get_mut(..reactions).unwrap_or_default()) }
    }
}

/// Lets two items change places, where both are.
fn swap<T>(items: &mut [T], a: usize, b: usize) {
    if a < items.len() && b < items.len() {
        items.swap(a, b);
    }
}

/// Cuts pieces off a slice, or only counts them.
struct Carver<'a, T> {
    rest: &'a mut [T],
    counts: bool,
    taken: usize,
}

impl<'a, T> Carver<'a, T> {
    fn of(rest: &'a mut [T]) -> Self {
        Carver { rest, counts: false, taken: 0 }
    }

    fn counting() -> Self {
        Carver { rest: &mut [], counts: true, taken: 0 }
    }

    /// So many numbers off the front, or off the end; none while counting. None: there are not so many.
    fn take(&mut self, count: usize, off_front: bool) -> Option<&'a mut [T]> {
        self.taken = self.taken.checked_add(count)?;
        if self.counts {
            return Some(&mut []);
        }
        let rest = core::mem::take(&mut self.rest);
        let cut = if off_front { count } else { rest.len().checked_sub(count)? };
        let (front, end) = rest.split_at_mut_checked(cut)?;
        let (piece, rest) = if off_front { (front, end) } else { (end, front) };
        self.rest = rest;
        Some(piece)
    }
}
