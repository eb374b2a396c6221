//! A run of rows and what sweeping it takes: the whole sheet's, or one band's.

use crate::body::pose::Vector;
use crate::ground::lanes::{self, Job, Lane};
use crate::ground::math;
use crate::ground::planes::{self, CARRY_PLANES, CHUNK, Chunk, HOT_PLANES, SPEED_X, SPEED_Z};
use crate::ground::ranges::{NOT_KEPT, end_of_range, spread};
use crate::memory::arrays::{Arrays, RowArrays, StepScratch};
use crate::memory::layout::Layout;
use crate::scene::features::Feature;
use crate::sheet::clamp::{self, ClampedRow};
use crate::sheet::columns::{COLUMN_PLANES, Net};
use crate::sheet::ghosts::{place_ghost_column, place_ghost_speeds};
use crate::sheet::neighbours::own;
use crate::sheet::places::rest_offset;
use crate::sweep::accounts::DissipationOfRow;
use crate::sweep::effects::EffectState;
use crate::sweep::moments::{Last, ViscousRows};
use crate::sweep::on_casing::OnCasing;
use crate::sweep::pass::{Pass, Row};
use crate::sweep::segments::Report;
use crate::sweep::slack::SlackBalance;
use crate::sweep::terms::Terms;
use core::mem::take;

/// Neighbouring rows with all that belongs to them, to be swept from the lowest up.
pub(crate) struct Rows<'r> {
    /// Number of the first row.
    pub first: usize,
    /// Their ply.
    pub ply: usize,
    /// Arrays of these rows, but for `past`.
    pub own: RowArrays<'r>,
    /// The row above the last, not swept yet; empty above the top row.
    pub above: &'r [Chunk<HOT_PLANES>],
    /// Past and moments of viscosity.
    pub viscous: ViscousRows<'r>,
    /// Columns and rows of a graded network, columns of a curved sheet.
    pub net: Net<'r>,
    /// Vertical forces from the row below the first.
    pub carry: &'r mut [Chunk<CARRY_PLANES>],
    /// Displacements of the fixed nodes of a row.
    pub kept: &'r mut [[f64; 3]],
    /// Reactions of the two runs of fixed nodes of each row, in units of m h/dt; empty where no reaction is
    /// requested.
    pub reactions: &'r mut [[[f64; 3]; 2]],
}

impl<'r> Rows<'r> {
    /// Rows [first, end) of the whole sheet; None if a block is shorter than the layout says. `in_block`: the
    /// step of a block.
    pub fn of(
        arrays: &'r mut Arrays<'_>,
        layout: &Layout,
        [first, end]: [usize; 2],
        ply: usize,
        in_block: Option<usize>,
    ) -> Option<Rows<'r>> {
        // A stack, whose plies are swept in turn, some rows each.
        let is_begun = arrays.awake.get(ply).is_some_and(|rows| first > rows[0] as usize);
        let step = in_block.unwrap_or(0);
        let noted = step * layout.nodes_y;
        let [mut own, mut above] = arrays.rows.split(layout, [first, end], step)?;
        // The row above is of the next ply.
        if layout.is_stack() && layout.ply_and_row(end).1 == 0 {
            (above.hot, above.past) = Default::default();
        }
        let viscous = ViscousRows {
            past: take(&mut own.past),
            above: planes::row_mut(above.past, layout.chunks, 0),
            // They were found for the row below.
            moments_found: [is_begun || in_block.is_some() && first > 0, false],
        };
        let StepScratch { carries, reactions } = StepScratch::of(arrays.shared, layout);
        Some(Rows {
            first,
            ply,
            above: planes::row(above.hot, layout.chunks, 0),
            viscous,
            net: Net { columns: layout.columns_of(arrays.columns, ply), lines: arrays.lines },
            carry: planes::row_mut(carries, layout.chunks, in_block.unwrap_or(ply)),
            kept: arrays.kept,
            reactions: if layout.supports {
                reactions.get_mut(noted + first..noted + end)?
            } else {
                Default::default()
            },
            own,
        })
    }
}

impl Rows<'_> {
    /// The hot pass over these rows, with fixed nodes put back and their reactions noted.
    #[inline(always)] // The rows themselves then take no stack.
    pub fn sweep(&mut self, terms: &Terms<'_>) -> Report {
        let (layout, chunks) = (terms.layout, terms.layout.chunks);
        if layout.x.has_ghost() {
            self.place_ghosts(layout);
        }
        let Rows { first, ply, above, own, viscous, carry, kept, reactions, .. } = self;
        let RowArrays { hot, history, yarn, strength, before, dissipated, ranges, runs, clamps, .. } = own;
        let RowArrays { energy_error, been_slack, case_impulse_of_row, case_impulse, clamped, .. } = own;
        let (first, ply, above) = (*first, *ply, *above);
        let (pass, is_viscous) = (terms.pass(self.net, ply), layout.has(Feature::Viscosity));
        // Whether nodes stand for several.
        let several = layout.x.is_mirrored() || layout.y.is_mirrored() || layout.has(Feature::Grading);
        let (weighed, mut report, rows) = (several.then_some(&pass.net), Report::default(), ranges.len());
        for (k, (range, run)) in ranges.iter_mut().zip(&**runs).enumerate() {
            let j = first + k;
            if is_viscous {
                if k == 0 {
                    viscous.find_moments(&pass, terms, [ply, first, 0], [hot, above], dissipated);
                }
                // The row needs those of the row above it.
                viscous.find_moments(&pass, terms, [ply, first, k + 1], [hot, above], dissipated);
            }
            let Some((below, next)) = hot.split_at_mut_checked((k + 1) * chunks) else { return Report::LOST };
            let row = planes::row_mut(below, chunks, k);
            let above = if k + 1 < rows { planes::row(next, chunks, 0) } else { above };
            // None but of a stack.
            if let Some(before) = before.get_mut(k * chunks..(k + 1) * chunks) {
                lanes::dispatch(terms.instructions, Keep { hot: row, before, columns: pass.net.hoop() });
            }
            let row_of_clamps = planes::row_mut(clamps, chunks, k);
            let clamps = ClampedRow { row: row_of_clamps, clamps: &terms.clamps, columns: pass.net.columns };
            let mut fixed = FixedNodes { run, kept, clamps };
            fixed.keep(row);
            let yarn = terms.yarn_row(yarn, strength, k, ply);
            let history = planes::row_mut(history, chunks, k);
            let mut counted = layout.has_effects().then(|| DissipationOfRow::of(layout, &pass, j));
            if layout.x.is_mirrored()
                && layout.has(Feature::Rate)
                && let Some(counted) = &mut counted
            {
                counted.relax_last(&pass, j, [row, above]);
            }
            let mut last = Last::default();
            let mut job = Row { pass: &pass, j, row: &mut *row, history, above, carry, yarn: &yarn, effects: None };
            if let Some(counted) = &mut counted {
                let viscosity = if is_viscous {
                    let (row, of_last) = viscous.row(layout, (k, rows, first));
                    last = of_last;
                    Some(row)
                } else {
                    None
                };
                let keeps = been_slack.get(k).copied().unwrap_or(0);
                let is_slack = layout.has(Feature::Slack) && keeps != 0;
                let slack = is_slack.then(|| SlackBalance::of(planes::row_mut(energy_error, chunks, k), keeps));
                // Whole rows of a ring are held, or none of it.
                let on_casing = if run[0] == run[1] {
                    let nodes = case_impulse.get_mut(k * chunks..(k + 1) * chunks);
                    case_under(terms, &pass, j, case_impulse_of_row.get_mut(k), nodes)
                } else {
                    None
                };
                job.effects = Some(EffectState { viscosity, slack, on_casing, dissipation: &mut counted.sums });
            }
            let (met, reach) = job.step();
            report = report.merged(met);
            let (of_row, work) = fixed.end_row(terms, weighed, j, row, (range, reach));
            if let Some(reactions) = reactions.get_mut(k) {
                *reactions = of_row;
            }
            if let Some(clamped) = clamped.get_mut(k) {
                *clamped = work;
            }
            if let Some((dissipated, counted)) = dissipated.get_mut(k).zip(counted.as_mut()) {
                if is_viscous && layout.x.is_mirrored() {
                    let of_last = viscous.taken_of_last(layout, k, &last);
                    let parts = pass.net.parts(layout.nodes_x - 1);
                    counted.of_last = [0, 1].map(|axis| counted.of_last[axis] + parts[axis] * of_last[axis]);
                }
                // `find_moments` has stored the part of the moments.
                *dissipated = counted.total(layout) + if is_viscous { *dissipated } else { 0.0 };
            }
        }
        report
    }

    /// The image columns, with velocities for viscosity and slack segments.
    fn place_ghosts(&mut self, layout: &Layout) {
        for row in self.own.hot.chunks_exact_mut(layout.chunks.max(1)) {
            place_ghost_column(row, layout.x);
        }
        if layout.reads_ghost_speeds() {
            place_ghost_speeds(self.own.hot, layout.chunks, layout.x);
        }
    }
}

/// Case under row j of a ring, with the sums of its impulses on the row and the impulse on each node.
fn case_under<'a>(
    terms: &Terms<'a>,
    pass: &Pass<'a>,
    j: usize,
    impulse_of_row: Option<&'a mut [[f64; CHUNK]; 3]>,
    impulse: Option<&'a mut [[f64; CHUNK]]>,
) -> Option<OnCasing<'a>> {
    let case = terms.directions.case()?;
    let rest = rest_offset(terms.layout.ply_and_row(j).1, terms.layout.y.nodes);
    let place_y = rest * pass.directions.vertical.rest.spacing;
    Some(OnCasing { case, columns: pass.net.columns, place_y, impulse_of_row: impulse_of_row?, impulse: impulse? })
}

/// Fixed nodes of a row during its sweep.
struct FixedNodes<'a> {
    /// Two runs of columns [first, end).
    run: &'a [u32; 4],
    /// Displacements before the sweep.
    kept: &'a mut [[f64; 3]],
    /// Clamps that hold them, where these may slip.
    clamps: ClampedRow<'a>,
}

impl FixedNodes<'_> {
    /// Remembers where they are.
    #[inline(always)]
    fn keep(&mut self, row: &[Chunk<HOT_PLANES>]) {
        if self.clamps.may_slip() {
            clamp::keep_velocities(self.clamps.row, row, self.run);
        }
        let run = self.run;
        for columns in [run[0]..run[1], run[2]..run[3]] {
            for i in columns.map(|i| i as usize) {
                let (Some([x, y, z, ..]), Some(kept)) = (row.get(i / CHUNK), self.kept.get_mut(i)) else { break };
                *kept = [x[i % CHUNK], y[i % CHUNK], z[i % CHUNK]];
            }
        }
    }

    /// After the sweep of row j: puts them back and notes how far the row reaches, which is `reach` along y.
    /// Returns the reaction of each run, and the energy that clamps dissipate, m (h/dt)^2. `weighed`: where
    /// nodes stand for several.
    #[inline(always)]
    fn end_row(
        &mut self,
        terms: &Terms<'_>,
        weighed: Option<&Net<'_>>,
        j: usize,
        row: &mut [Chunk<HOT_PLANES>],
        (range, reach): (&mut [u32; 4], [f64; 2]),
    ) -> ([[f64; 3]; 2], f64) {
        if self.clamps.may_slip() {
            return self.slide_row(terms, weighed, j, row, (range, reach));
        }
        let reactions = match weighed {
            Some(net) => {
                let of_row = net.row_share(j);
                let weight = |i| terms.layout.node_weight(i, j) * (net.column_share(i) * of_row);
                restore_fixed(row, self.kept, self.run, weight)
            }
            None => restore_fixed(row, self.kept, self.run, |_| 1.0),
        };
        note_range(terms, row, range, reach);
        (reactions, 0.0)
    }

    /// [`FixedNodes::end_row`] where clamps may slip.
    #[cold]
    #[inline(never)]
    fn slide_row(
        &mut self,
        terms: &Terms<'_>,
        weighed: Option<&Net<'_>>,
        j: usize,
        row: &mut [Chunk<HOT_PLANES>],
        (range, [mut low, mut high]): (&mut [u32; 4], [f64; 2]),
    ) -> ([[f64; 3]; 2], f64) {
        let FixedNodes { run, kept, clamps } = self;
        let (mut reactions, mut work) = ([Vector::zeros(); 2], 0.0);
        for (reaction, columns) in reactions.iter_mut().zip([run[0]..run[1], run[2]..run[3]]) {
            for i in columns.map(|i| i as usize) {
                if !clamps.holds_node(i) {
                    continue;
                }
                let (Some(place), Some(chunk)) = (kept.get(i), row.get_mut(i / CHUNK)) else { break };
                let lane = i % CHUNK;
                let weight = weighed.map_or(1.0, |net| terms.layout.node_weight(i, j) * net.share(i, j));
                let Some(slide) = clamps.slide(i, planes::velocity(chunk, lane)) else { break };
                for plane in 0..3 {
                    chunk[plane][lane] = place[plane] + slide.velocity[plane];
                    chunk[SPEED_X + plane][lane] = slide.velocity[plane];
                }
                (low, high) = (math::min(chunk[1][lane], low), math::max(chunk[1][lane], high));
                *reaction += Vector::from(slide.impulse) * weight;
                work += weight * slide.work;
            }
        }
        note_range(terms, row, range, [low, high]);
        (reactions.map(|reaction| reaction.into()), work)
    }
}

/// Notes how far a row reaches, while it is at hand.
#[inline(always)]
fn note_range(terms: &Terms<'_>, row: &[Chunk<HOT_PLANES>], range: &mut [u32; 4], reach: [f64; 2]) {
    let [low, high, left, right] = range;
    (*low, *high) = (end_of_range(reach[0]), end_of_range(reach[1]));
    if *left != NOT_KEPT {
        [*left, *right] = spread(row, terms.instructions).map(end_of_range);
    }
}

/// Keeps the velocities across the sheet of a row, along the normals of its columns if it has some.
struct Keep<'a> {
    hot: &'a [Chunk<HOT_PLANES>],
    before: &'a mut [[f64; CHUNK]],
    columns: &'a [Chunk<COLUMN_PLANES>],
}

impl Job for Keep<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self) {
        let rows = self.before.iter_mut().zip(self.hot);
        if self.columns.is_empty() {
            return rows.for_each(|(before, chunk)| *before = chunk[SPEED_Z]);
        }
        for ((before, chunk), columns) in rows.zip(self.columns) {
            for (g, before) in L::groups_mut(before).iter_mut().enumerate() {
                own::<L>(chunk, SPEED_X, Some(columns), g)[2].store(before);
            }
        }
    }
}

/// Puts the fixed nodes of row j back to rest and returns the reaction of each run, in units of m
/// h/dt; beyond mirror planes that of all images together, before any is turned.
#[inline]
fn restore_fixed(
    row: &mut [Chunk<HOT_PLANES>],
    kept: &[[f64; 3]],
    run: &[u32; 4],
    weight: impl Fn(usize) -> f64,
) -> [[f64; 3]; 2] {
    let mut reactions = [Vector::zeros(); 2];
    for (reaction, columns) in reactions.iter_mut().zip([run[0]..run[1], run[2]..run[3]]) {
        for i in columns.map(|i| i as usize) {
            let (Some(chunk), Some(kept)) = (row.get_mut(i / CHUNK), kept.get(i)) else { break };
            let lane = i % CHUNK;
            *reaction += Vector::from(planes::velocity(chunk, lane)) * weight(i);
            for plane in 0..3 {
                chunk[plane][lane] = kept[plane];
                chunk[SPEED_X + plane][lane] = 0.0;
            }
        }
    }
    let [first, second] = reactions;
    [first.into(), second.into()]
}

#[cfg(test)]
mod tests {
    use crate::ground::lanes::InstructionSet;
    use crate::tests::{sheet, sim};
    use crate::{Failure, Sim};

    #[test]
    fn a_block_that_is_too_short_is_a_failure_and_no_row_that_stands_still() {
        let mut sim = sim(&sheet(21, 21));
        sim.step_every_row();
        sim.step().unwrap();
        sim.system.network.arrays.rows.history = &mut [];
        assert_eq!(sim.step(), Err(Failure::NonFinite));
    }

    /// The digest after a run in which segments fail, 41 x 41 nodes.
    fn run(prepare: impl FnOnce(&mut Sim<'_>)) -> u64 {
        let mut sim = sim(&sheet(41, 41));
        assert!(sim.system.network.directions.front.plain && !sim.system.network.fetches);
        prepare(&mut sim);
        sim.advance(3000).unwrap();
        assert!(sim.counters().failed_segments > 10);
        sim.digest()
    }

    /// The path of fabrics that are not plain is the general one: it gives a plain sheet the bits of its own.
    #[test]
    fn a_plain_sheet_moves_alike_on_both_paths() {
        assert_eq!(run(|_| ()), run(|sim| sim.system.network.directions.front.plain = false));
    }

    /// The path of sheets beyond the caches gives a small one the bits of its own.
    #[test]
    fn rows_fetched_from_memory_move_as_others_do() {
        for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
            let [near, far] = [false, true].map(|fetches| {
                run(|sim| {
                    sim.system.network.fetches = fetches;
                    sim.use_instructions(set).unwrap();
                })
            });
            assert_eq!(near, far, "{set:?}");
        }
    }
}
