//! The caller's memory, carved into blocks, and the access to nodes and segments in them.

use crate::ground::error::{Code, Error};
use crate::ground::lanes::CacheLine;
use crate::ground::planes::{
    CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, ITERATE_PLANES, MARK_PLANES, PUSH_PLANES, RATE_PLANES,
    STRENGTH_PLANES, VISCOUS_PLANES, YARN_PLANES,
};
use crate::memory::layout::{
    BLOCK_STEPS, CANDIDATE_REALS, COLUMN_REALS, Layout, PACE_REALS, PULL_REALS, TANGENTIAL_REALS, TOUCH_REALS,
};
use crate::scene::features::Feature;
use crate::sheet::grading::LINE_PLANES;

/// Refuses memory that is too short for a scene of these sizes.
pub(crate) fn check(memory: &[CacheLine], layout: &Layout) -> Result<(), Error> {
    let (have, need) = (memory.len(), layout.lines());
    if have < need { Err(Error::new(Code::ShortBuffer, "memory", have as f64, need as f64)) } else { Ok(()) }
}

/// The caller's memory, carved.
pub(crate) struct Blocks<'a> {
    /// Rows of [ux uy uz vx vy vz kh kv].
    pub hot: &'a mut [Chunk<HOT_PLANES>],
    /// Rows of the largest q beyond critical, horizontal and vertical; `planes.rs` says what they hold before.
    pub history: &'a mut [Chunk<HISTORY_PLANES>],
    /// Rows of [kh kv lambda_h lambda_v] of stochastic yarn.
    pub yarn: &'a mut [Chunk<YARN_PLANES>],
    /// Rows of the critical stretches of drawn strength, horizontal and vertical.
    pub strength: &'a mut [Chunk<STRENGTH_PLANES>],
    /// Rows of the toe's marks, horizontal and vertical.
    pub marks: &'a mut [Chunk<MARK_PLANES>],
    /// The theta rule's rows (`theta.rs` names their planes).
    pub iterate: &'a mut [Chunk<ITERATE_PLANES>],
    /// Rows of what viscosity changes of the velocities.
    pub pushes: &'a mut [Chunk<PUSH_PLANES>],
    /// Work row of viscosity.
    pub viscous: &'a mut [Chunk<VISCOUS_PLANES>],
    /// Rows of the logarithms of the rate, horizontal and vertical.
    pub logarithms: &'a mut [Chunk<RATE_PLANES>],
    /// Energy that viscosity and rate have taken of each row in the present pass, in units of m (h/dt)^2.
    pub taken: &'a mut [f64],
    /// Constants of a row of nodes of a graded network, chunk by chunk of its columns (`grading.rs`).
    pub columns: &'a mut [Chunk<LINE_PLANES>],
    /// The same of a column of nodes.
    pub lines: &'a mut [Chunk<LINE_PLANES>],
    /// Of a stack (`contact/stack`), as all up to `slots`: velocities along z before the sweep.
    pub before: &'a mut [[f64; CHUNK]],
    /// A column of facing nodes.
    pub column: &'a mut [[f64; COLUMN_REALS]],
    /// What the plies do to each candidate.
    pub touches: &'a mut [[f64; TOUCH_REALS]],
    /// How far each candidate's impulse along the surface goes in a sweep: a part of the way that it last wanted to go, and that way, N s; with friction.
    pub paces: &'a mut [[f64; PACE_REALS]],
    /// Awake rows [first, end) of each ply.
    pub awake: &'a mut [[u32; 2]],
    /// The last candidate found so far in each column.
    pub last: &'a mut [u32],
    /// Of each candidate: the next one in its column; twice its ply, and 1 more if it leads the column.
    pub links: &'a mut [[u32; 2]],
    pub carry: &'a mut [Chunk<CARRY_PLANES>],
    /// Of steps in blocks (`waves.rs`): the carried forces of each step.
    pub carries: &'a mut [Chunk<CARRY_PLANES>],
    /// The pulls of the fixed nodes of each row, step by step.
    pub pulls: &'a mut [[f64; PULL_REALS]],
    pub kept: &'a mut [[f64; 3]],
    /// Least and greatest displacement of each row, along y and then along x, as `ranges.rs` keeps them; along x only where contact
    /// asks for it.
    pub ranges: &'a mut [[u32; 4]],
    pub candidates: &'a mut [[f64; CANDIDATE_REALS]],
    /// The candidates' tangential parts, where there is friction.
    pub tangential: &'a mut [[f64; TANGENTIAL_REALS]],
    /// The theta rule's phi/dt of the candidates.
    pub gaps_over_dt: &'a mut [f64],
    pub runs: &'a mut [[u32; 4]],
    /// Nodes with an impulse since the last outcome test.
    pub flags: &'a mut [u32],
    pub labels: &'a mut [u32],
    pub candidate_nodes: &'a mut [u32],
}

impl<'a> Blocks<'a> {
    /// No memory.
    pub(crate) const fn nothing() -> Blocks<'a> {
        Blocks {
            hot: &mut [],
            history: &mut [],
            yarn: &mut [],
            strength: &mut [],
            marks: &mut [],
            iterate: &mut [],
            pushes: &mut [],
            viscous: &mut [],
            logarithms: &mut [],
            taken: &mut [],
            columns: &mut [],
            lines: &mut [],
            before: &mut [],
            column: &mut [],
            touches: &mut [],
            paces: &mut [],
            awake: &mut [],
            last: &mut [],
            links: &mut [],
            carry: &mut [],
            carries: &mut [],
            pulls: &mut [],
            kept: &mut [],
            ranges: &mut [],
            candidates: &mut [],
            tangential: &mut [],
            gaps_over_dt: &mut [],
            runs: &mut [],
            flags: &mut [],
            labels: &mut [],
            candidate_nodes: &mut [],
        }
    }

    /// Cuts memory that has been found to be enough.
    pub(crate) fn carve(memory: &'a mut [CacheLine], layout: &Layout) -> Result<Blocks<'a>, Error> {
        let short = Error::new(Code::ShortBuffer, "memory", memory.len() as f64, layout.lines() as f64);
        let Some((reals, words)) = memory.split_at_mut_checked(layout.lines_of_reals()) else { return Err(short) };
        let (mut reals, mut words) = (Carver(CacheLine::reals(reals)), Carver(CacheLine::words(words)));
        let (nx, ny, row) = (layout.nodes_x, layout.nodes_y, layout.chunks * CHUNK);
        let watched = |count: usize| if layout.has(Feature::Detachment) { count } else { 0 };
        let implicit = |count: usize| if layout.has(Feature::Theta) { count } else { 0 };
        let graded = |count: usize| if layout.has(Feature::Grading) { count * CHUNK * LINE_PLANES } else { 0 };
        let viscous = |count: usize| if layout.has(Feature::Viscosity) { count } else { 0 };
        let stack = |count: usize| if layout.is_stack() { count } else { 0 };
        let waves = |count: usize| if layout.in_waves { BLOCK_STEPS * count } else { 0 };
        let rough = |count: usize| if layout.has(Feature::Friction) { count } else { 0 };
        let carved = (|| {
            Some(Blocks {
                hot: chunked(reals.take(layout.stored_rows() * HOT_PLANES * row)?),
                history: chunked(reals.take(ny * HISTORY_PLANES * row)?),
                yarn: chunked(reals.take(if layout.has_constants() { ny * YARN_PLANES * row } else { 0 })?),
                strength: chunked(reals.take(if layout.has(Feature::Strength) {
                    ny * STRENGTH_PLANES * row
                } else {
                    0
                })?),
                marks: chunked(reals.take(if layout.has(Feature::Toe) { ny * MARK_PLANES * row } else { 0 })?),
                iterate: chunked(reals.take(implicit(layout.stored_rows() * ITERATE_PLANES * row))?),
                pushes: chunked(reals.take(viscous(ny * PUSH_PLANES * row))?),
                viscous: chunked(reals.take(viscous(VISCOUS_PLANES * row))?),
                logarithms: chunked(reals.take(if layout.has(Feature::Rate) { ny * RATE_PLANES * row } else { 0 })?),
                columns: chunked(reals.take(graded(layout.chunks))?),
                lines: chunked(reals.take(graded(ny.div_ceil(CHUNK)))?),
                carry: chunked(reals.take(CARRY_PLANES * row)?),
                carries: chunked(reals.take(waves(CARRY_PLANES * row))?),
                kept: reals.take(3 * nx)?.as_chunks_mut().0,
                taken: reals.take(if layout.takes_energy() { ny } else { 0 })?,
                candidates: reals.take(layout.candidates * CANDIDATE_REALS)?.as_chunks_mut().0,
                before: reals.take(stack(ny * row))?.as_chunks_mut().0,
                column: reals.take(stack(layout.plies * COLUMN_REALS))?.as_chunks_mut().0,
                touches: reals.take(stack(layout.candidates * TOUCH_REALS))?.as_chunks_mut().0,
                paces: reals.take(rough(stack(layout.candidates * PACE_REALS)))?.as_chunks_mut().0,
                tangential: reals.take(rough(layout.candidates * TANGENTIAL_REALS))?.as_chunks_mut().0,
                gaps_over_dt: reals.take(implicit(layout.candidates))?,
                pulls: reals.take(waves(PULL_REALS * ny))?.as_chunks_mut().0,
                runs: words.take(4 * ny)?.as_chunks_mut().0,
                ranges: words.take(4 * ny)?.as_chunks_mut().0,
                flags: words.take(watched(layout.nodes().div_ceil(32)))?,
                labels: words.take(watched(layout.nodes()))?,
                candidate_nodes: words.take(layout.candidates)?,
                awake: words.take(stack(2 * layout.plies))?.as_chunks_mut().0,
                last: words.take(stack(nx * layout.y.modelled()))?,
                links: words.take(stack(2 * layout.candidates))?.as_chunks_mut().0,
            })
        })();
        carved.ok_or(short)
    }
}

impl Blocks<'_> {
    /// Lets two candidates change places.
    pub(crate) fn swap_candidates(&mut self, a: usize, b: usize) {
        swap(self.candidates, a, b);
        swap(self.candidate_nodes, a, b);
        swap(self.tangential, a, b);
        swap(self.gaps_over_dt, a, b);
    }
}

/// Lets two items change places, where both are.
fn swap<T>(items: &mut [T], a: usize, b: usize) {
    if a < items.len() && b < items.len() {
        items.swap(a, b);
    }
}

/// Cuts pieces off the front of a slice.
struct Carver<'a, T>(&'a mut [T]);

impl<'a, T> Carver<'a, T> {
    fn take(&mut self, count: usize) -> Option<&'a mut [T]> {
        let (piece, rest) = core::mem::take(&mut self.0).split_at_mut_checked(count)?;
        self.0 = rest;
        Some(piece)
    }
}

/// Numbers as chunks of P planes.
fn chunked<const P: usize>(reals: &mut [f64]) -> &mut [Chunk<P>] {
    reals.as_chunks_mut().0.as_chunks_mut().0
}
