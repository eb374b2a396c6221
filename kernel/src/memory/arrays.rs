//! The caller's memory: what it holds, in one list from which it is counted and cut. All sizes are found here, with checked arithmetic.
//! `planes.rs` says how rows lie in memory.

use crate::ground::error::{Code, Error};
use crate::ground::lanes::CacheLine;
use crate::ground::planes::{
    Axis, CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, ITERATE_PLANES, OWED_PLANES, PAST_PLANES,
    STRENGTH_PLANES, YARN_PLANES,
};
use crate::memory::layout::{
    CANDIDATE_REALS, COLUMN_REALS, Layout, PACE_REALS, SPRING_REALS, TANGENTIAL_REALS, TOUCH_REALS,
};
use crate::scene::features::{Feature, Features};
use crate::scene::parts::Scene;
use crate::sheet::columns::COLUMN_PLANES;
use crate::sheet::places::Places;
use crate::sheet::symmetry::Line;

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
            supports: scene.track_support || Features::of(scene).has(Feature::Clamps),
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
        layout.image_words = layout.count_image()?;
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

/// The caller's memory, cut into arrays.
pub(crate) struct Arrays<'a> {
    /// Rows of [ux uy uz vx vy vz kh kv].
    pub hot: &'a mut [Chunk<HOT_PLANES>],
    /// Rows of the largest q beyond critical, horizontal and vertical; `planes.rs` says what they hold before.
    pub history: &'a mut [Chunk<HISTORY_PLANES>],
    /// Rows of [kh kv lambda_h lambda_v] of stochastic yarn.
    pub yarn: &'a mut [Chunk<YARN_PLANES>],
    /// Rows of the critical stretches of drawn strength, horizontal and vertical.
    pub strength: &'a mut [Chunk<STRENGTH_PLANES>],
    /// Rows of what slack segments owe: `planes.rs` names the planes.
    pub owed: &'a mut [Chunk<OWED_PLANES>],
    /// The theta rule's rows (`theta.rs` names their planes).
    pub iterate: &'a mut [Chunk<ITERATE_PLANES>],
    /// Rows of what viscosity keeps of the last pass: `planes.rs` names the planes.
    pub past: &'a mut [Chunk<PAST_PLANES>],
    /// Energy that viscosity and rate have taken of each row in the present pass, or in each step of a block, in units of m (h/dt)^2.
    pub taken: &'a mut [f64],
    /// Constants of the columns (`columns.rs`), chunk by chunk: one line of a graded network, one of each ply of a curved sheet.
    pub columns: &'a mut [Chunk<COLUMN_PLANES>],
    /// Constants of the rows of a graded network.
    pub lines: &'a mut [Chunk<COLUMN_PLANES>],
    /// Of a ring on a case, of each row in the present pass: sums of its pushes along x and z and of the energy that it takes, by columns of
    /// a chunk, in units of m h/dt and m (h/dt)^2.
    pub pushed: &'a mut [[[f64; CHUNK]; 3]],
    /// And its push on every node, spacings a pass.
    pub pushes: &'a mut [[f64; CHUNK]],
    /// Largest impulse of the clamp on each node in a step, spacings/step times its mass; constant.
    pub holds: &'a mut [[f64; CHUNK]],
    /// Distance that each held node has slid, spacings.
    pub slid: &'a mut [[f64; CHUNK]],
    /// Energy that the clamps of each row dissipate in the present pass, or in each step of a block, in units of m (h/dt)^2.
    pub clamped: &'a mut [f64],
    /// Of a stack (`contact/joint.rs`), as all up to `links`: velocities across the sheet before the sweep.
    pub before: &'a mut [[f64; CHUNK]],
    /// A column of facing nodes.
    pub column: &'a mut [[f64; COLUMN_REALS]],
    /// What the plies do to each candidate.
    pub touches: &'a mut [[f64; TOUCH_REALS]],
    /// How far each candidate's impulse along the surface goes in a sweep: a part of the way that it last wanted to go, and that way, N s; with friction.
    pub paces: &'a mut [[f64; PACE_REALS]],
    /// Impulses of each candidate as functions of its node's velocity, and those before a step of Newton's method; with friction in a stack.
    pub springs: &'a mut [[f64; SPRING_REALS]],
    /// Awake rows [first, end) of each ply.
    pub awake: &'a mut [[u32; 2]],
    /// The last candidate found so far in each column.
    pub last: &'a mut [u32],
    /// Of each candidate: the next one in its column; twice its ply, and 1 more if it leads the column.
    pub links: &'a mut [[u32; 2]],
    /// What a step or a block of steps ([`Noted`]) and a look at what hangs together (a label for every node) use in turn.
    pub shared: &'a mut [CacheLine],
    pub kept: &'a mut [[f64; 3]],
    /// Least and greatest displacement of each row, along y and then along x, as `ranges.rs` keeps them; along x only where contact
    /// asks for it.
    pub ranges: &'a mut [[u32; 4]],
    /// Of each row the bits of the directions in which a segment has been slack.
    pub been_slack: &'a mut [u32],
    pub candidates: &'a mut [[f64; CANDIDATE_REALS]],
    /// The candidates' tangential parts, where there is friction.
    pub tangential: &'a mut [[f64; TANGENTIAL_REALS]],
    /// The theta rule's phi/dt of the candidates.
    pub gaps_over_dt: &'a mut [f64],
    pub runs: &'a mut [[u32; 4]],
    /// Nodes with an impulse since the last outcome test.
    pub flags: &'a mut [u32],
    pub candidate_nodes: &'a mut [u32],
}

impl<'a> Arrays<'a> {
    /// No memory.
    pub(crate) const fn nothing() -> Arrays<'a> {
        Arrays {
            hot: &mut [],
            history: &mut [],
            yarn: &mut [],
            strength: &mut [],
            owed: &mut [],
            iterate: &mut [],
            past: &mut [],
            taken: &mut [],
            columns: &mut [],
            lines: &mut [],
            pushed: &mut [],
            pushes: &mut [],
            holds: &mut [],
            slid: &mut [],
            clamped: &mut [],
            before: &mut [],
            column: &mut [],
            touches: &mut [],
            springs: &mut [],
            paces: &mut [],
            awake: &mut [],
            last: &mut [],
            links: &mut [],
            shared: &mut [],
            kept: &mut [],
            ranges: &mut [],
            been_slack: &mut [],
            candidates: &mut [],
            tangential: &mut [],
            gaps_over_dt: &mut [],
            runs: &mut [],
            flags: &mut [],
            candidate_nodes: &mut [],
        }
    }

    /// Cuts memory that has been found to be enough.
    #[inline(never)]
    pub(crate) fn carve(&mut self, memory: &'a mut [CacheLine], layout: &Layout) -> Result<(), Error> {
        let short = short("memory", memory.len(), layout.lines());
        let Some((reals, rest)) = memory.split_at_mut_checked(layout.lines_of_reals()) else { return Err(short) };
        let Some((shared, words)) = rest.split_at_mut_checked(layout.shared_lines()) else { return Err(short) };
        let (mut reals, mut words) = (Carver::of(CacheLine::reals(reals)), Carver::of(CacheLine::words(words)));
        self.cut(&mut reals, &mut words, layout).ok_or(short)?;
        self.shared = shared;
        Ok(())
    }

    /// Numbers and words that they have.
    #[inline(never)]
    fn count(layout: &Layout) -> Option<[usize; 2]> {
        let (mut reals, mut words) = (Carver::counting(), Carver::counting());
        Arrays::nothing().cut(&mut reals, &mut words, layout)?;
        Some([reals.taken, words.taken])
    }

    /// The list: of each array whether the scene needs it, and the factors of its length.
    #[inline(never)]
    fn cut(&mut self, reals: &mut Carver<'a, f64>, words: &mut Carver<'a, u32>, layout: &Layout) -> Option<()> {
        use Feature::{Casing, Clamps, Curved, Detachment, Friction, Grading, Slack, Strength, Theta, Viscosity};
        let (nx, rows, row, candidates) = (layout.nodes_x, layout.nodes_y, layout.chunks, layout.candidates);
        let has = |feature| layout.has(feature);
        // The case behind a node is a candidate, too.
        let candidates = if has(Casing) { candidates.checked_mul(2)? } else { candidates };
        let steps = layout.block_steps as usize;
        let lines = if has(Curved) { layout.plies } else { 1 };
        let mut real = |needed, factors| reals.take(needed, factors);
        *self = Arrays {
            hot: chunked(real(true, [layout.stored_rows(), row, CHUNK * HOT_PLANES])?),
            history: chunked(real(true, [rows, row, CHUNK * HISTORY_PLANES])?),
            yarn: chunked(real(layout.has_constants(), [rows, row, CHUNK * YARN_PLANES])?),
            strength: chunked(real(has(Strength), [rows, row, CHUNK * STRENGTH_PLANES])?),
            owed: chunked(real(has(Slack), [rows, row, CHUNK * OWED_PLANES])?),
            iterate: chunked(real(has(Theta), [layout.stored_rows(), row, CHUNK * ITERATE_PLANES])?),
            past: chunked(real(has(Viscosity), [layout.stored_rows(), row, CHUNK * PAST_PLANES])?),
            columns: chunked(real(has(Grading) || has(Curved), [lines, row, CHUNK * COLUMN_PLANES])?),
            lines: chunked(real(has(Grading), [1, rows.div_ceil(CHUNK), CHUNK * COLUMN_PLANES])?),
            shared: &mut [],
            kept: real(true, [1, layout.kept_nodes(), 3])?.as_chunks_mut().0,
            taken: real(layout.takes_energy(), [1, steps, rows])?,
            candidates: real(true, [1, candidates, CANDIDATE_REALS])?.as_chunks_mut().0,
            pushed: real(has(Casing), [rows, 3, CHUNK])?.as_chunks_mut().0.as_chunks_mut().0,
            pushes: real(has(Casing), [rows, row, CHUNK])?.as_chunks_mut().0,
            holds: real(has(Clamps), [rows, row, CHUNK])?.as_chunks_mut().0,
            slid: real(has(Clamps), [rows, row, CHUNK])?.as_chunks_mut().0,
            clamped: real(has(Clamps), [1, steps, rows])?,
            before: real(layout.is_stack(), [rows, row, CHUNK])?.as_chunks_mut().0,
            column: real(layout.is_stack(), [1, layout.plies, COLUMN_REALS])?.as_chunks_mut().0,
            touches: real(layout.is_stack(), [1, candidates, TOUCH_REALS])?.as_chunks_mut().0,
            springs: real(layout.is_stack() && has(Friction), [1, candidates, SPRING_REALS])?.as_chunks_mut().0,
            paces: real(layout.is_stack() && has(Friction), [1, candidates, PACE_REALS])?.as_chunks_mut().0,
            tangential: real(has(Friction), [1, candidates, TANGENTIAL_REALS])?.as_chunks_mut().0,
            gaps_over_dt: real(has(Theta), [1, 1, candidates])?,
            runs: words.take(true, [1, rows, 4])?.as_chunks_mut().0,
            ranges: words.take(true, [1, rows, 4])?.as_chunks_mut().0,
            been_slack: words.take(has(Slack), [1, 1, rows])?,
            flags: words.take(has(Detachment), [1, 1, layout.nodes().div_ceil(32)])?,
            candidate_nodes: words.take(true, [1, 1, candidates])?,
            awake: words.take(layout.is_stack(), [1, layout.plies, 2])?.as_chunks_mut().0,
            last: words.take(layout.is_stack(), [1, nx, layout.y.modelled()])?,
            links: words.take(layout.is_stack(), [1, candidates, 2])?.as_chunks_mut().0,
        };
        Some(())
    }
}

impl Arrays<'_> {
    /// Lets two candidates change places.
    pub(crate) fn swap_candidates(&mut self, a: usize, b: usize) {
        swap(self.candidates, a, b);
        swap(self.candidate_nodes, a, b);
        swap(self.tangential, a, b);
        swap(self.gaps_over_dt, a, b);
    }
}

/// What a step notes.
pub(crate) struct Noted<'r> {
    /// The vertical forces that are carried upwards: a row for each ply, of steps in blocks (`step/blocks.rs`) for each step.
    pub carries: &'r mut [Chunk<CARRY_PLANES>],
    /// What the sheet pulls at both runs of fixed nodes of each row, in units of m h/dt; of steps in blocks one step after the other.
    pub pulls: &'r mut [[[f64; 3]; 2]],
}

impl<'r> Noted<'r> {
    /// In the lines that [`Arrays`] share for it.
    pub fn of(shared: &'r mut [CacheLine], layout: &Layout) -> Noted<'r> {
        let carries = layout.carried_rows() * layout.chunks * CHUNK * CARRY_PLANES;
        let (carries, pulls) = CacheLine::reals(shared).split_at_mut_checked(carries).unwrap_or_default();
        let pulls = if layout.supports { pulls } else { &mut [] };
        Noted { carries: chunked(carries), pulls: pulls.as_chunks_mut().0.as_chunks_mut().0 }
    }
}

/// Lets two items change places, where both are.
fn swap<T>(items: &mut [T], a: usize, b: usize) {
    if a < items.len() && b < items.len() {
        items.swap(a, b);
    }
}

/// Cuts pieces off the front of a slice, or only counts them.
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

    /// As many items as the product of these factors, none if they are not needed; nothing while counting. None: there are not so many.
    fn take(&mut self, needed: bool, factors: [usize; 3]) -> Option<&'a mut [T]> {
        let count = if needed { factors[0].checked_mul(factors[1])?.checked_mul(factors[2])? } else { 0 };
        self.taken = self.taken.checked_add(count)?;
        let cut = if self.counts { 0 } else { count };
        let (piece, rest) = core::mem::take(&mut self.rest).split_at_mut_checked(cut)?;
        self.rest = rest;
        Some(piece)
    }
}

/// Numbers as chunks of P planes.
fn chunked<const P: usize>(reals: &mut [f64]) -> &mut [Chunk<P>] {
    reals.as_chunks_mut().0.as_chunks_mut().0
}
