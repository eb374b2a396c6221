//! Several steps in one block, for a sheet that does not stay in the caches: a row takes all steps of the
//! block within a few rows' work, so that it comes from memory once and not once a step.
//!
//! Method: a row can take a step as soon as the row above it has taken the one before. So rows are stepped in
//! a skewed order: where row r takes the first step of the block, row r - s takes step s; with viscosity,
//! whose moments reach one row further (M17), row r - 2 s. Rows below the body take all steps in this order;
//! then the rows that the body may reach take them one by one, with contact and all else that belongs to a
//! step; then those above. Each row has the neighbours and the forces from below that it has in single steps,
//! and the pulls on the supports are summed in the order of single steps: the bits are the same.
//! With bands the order is another one (`bands/block.rs`), without viscosity.
//! Limits: one ply, velocity Verlet, nothing that takes two passes or looks at the whole sheet between two
//! steps (`Layout::block_steps`); every row awake; no fixed node within the body's reach. Otherwise, and for
//! what is left of less than a block, single steps are taken. The surface of the body crosses less than a
//! spacing in a step, so what it may reach in a block is known; a row beyond [`APPROACH`] that comes so near
//! within a block, at some 2e4 m/s, is a lost state. After a failure in a block rows may be ahead of the step
//! that is counted, and another failure of the same block may be reported than single steps would have met
//! first; nothing but counters and the digest can be read then.
//! Reference: G. Wellein, G. Hager, T. Zeiser, M. Wittmann, H. Fehske, Proc. 33rd IEEE Int. Computer Software
//! and Applications Conf. (2009) 579 (wavefront parallelization).

use crate::contact::search::{Gathered, Search};
use crate::ground::error::Failure;
use crate::ground::lanes::InstructionSet;
use crate::ground::planes::{CARRY_PLANES, CHUNK};
use crate::ground::ranges::range_of;
use crate::memory::arrays::Noted;
use crate::memory::layout::Layout;
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::places::rest_offset;
use crate::sheet::segments::Report;
use crate::step::explicit;

/// How far a row beyond the body's reach may come nearer within a block, spacings.
const APPROACH: f64 = 8.0;

/// How many steps a block has with these instructions. The wider they are, the more a sweep waits for memory.
pub(crate) fn block_steps(layout: &Layout, instructions: InstructionSet) -> usize {
    let pays = matches!(instructions, InstructionSet::Avx512 | InstructionSet::Avx2);
    if pays { layout.block_steps as usize } else { 1 }
}

/// Takes a block of steps, if `most` steps allow one now: how many, or 0.
#[inline(never)]
pub(crate) fn step_block(system: &mut System<'_>, most: u64) -> Result<u64, Failure> {
    match &Block::plan(system, most) {
        Some(block) => block.take(system).map(|()| block.steps as u64),
        None => Ok(0),
    }
}

/// What lies where in a block.
#[derive(Clone, Copy)]
pub(crate) struct Block {
    /// Rows [first, end) that the body may reach.
    pub near: [usize; 2],
    pub steps: usize,
    pub rows: usize,
    /// By how many rows a step lags the one before.
    pub lag: usize,
    reach: Reach,
}

/// From where to where along a column the body may reach within a block.
#[derive(Clone, Copy)]
struct Reach {
    /// The ends, m.
    low: f64,
    high: f64,
    /// Spacing of the nodes along x, m, the unit of displacements.
    h: f64,
    /// Spacing of the rows at rest in units of h.
    rise: f64,
    nodes_y: u32,
}

impl Block {
    /// The block that may begin now; None for single steps: beyond `most` steps, if the body may reach a
    /// fixed node or half of the rows, or if a force window of attachments that slip ends within it.
    #[inline(never)]
    pub fn plan(system: &System<'_>, most: u64) -> Option<Block> {
        let (steps, rows) = (system.block_steps, system.layout.nodes_y);
        // So that outcomes are tested after a block.
        let is_due = steps > 1 && most >= steps as u64 && system.state.step.is_multiple_of(steps as u64);
        // What the attachments take in a block is booked at its end, too late for a window that ends within
        // it.
        let window = system.model.window_steps.max(1);
        let is_cut = system.layout.has(Feature::Clamps) && system.state.step % window + steps as u64 > window;
        if !is_due || is_cut || system.rows_to_step(0) != [0, rows] {
            return None;
        }
        let (body, h) = (&system.state.body, system.scene.sheet.spacing);
        // Its surface crosses less than a spacing in a step (`Model::too_fast`).
        let margin = system.scene.largest_spacing() + steps as f64 * h;
        let [_, half, _] = system.solid.half_extents(&body.orientation).map(|extent| extent + margin * (1.0 + 1e-9));
        let (low, high) = (body.position.y - half, body.position.y + half);
        let rise = system.directions.front.vertical.rest.spacing;
        let reach = Reach { low, high, h, rise, nodes_y: system.scene.sheet.nodes_y };
        let range = |j: usize| system.arrays.rows.ranges.get(j).copied().unwrap_or_default();
        let comes_near = |&j: &usize| reach.meets(j, range(j), APPROACH * h);
        let near = match ((0..rows).find(comes_near), (0..rows).rev().find(comes_near)) {
            (Some(first), Some(last)) => [first, last + 1],
            _ => [0, 0],
        };
        let [first, end] = near;
        let search = Search::new(&system.solid, body, margin, system.instructions);
        let is_held = (first..end).any(|j| {
            let [a, b, c, d] = system.arrays.rows.runs.get(j).copied().unwrap_or([0; 4]);
            (a..b).chain(c..d).any(|i| search.candidate(&system.position(i as usize, j)).is_some())
        });
        let lag = if system.layout.has(Feature::Viscosity) { 2 } else { 1 };
        (!is_held && 2 * (end - first + lag * steps) <= rows).then_some(Block { near, steps, rows, lag, reach })
    }

    /// Takes the steps.
    fn take(&self, system: &mut System<'_>) -> Result<(), Failure> {
        begin(system);
        let [below, above] = self.skewed();
        self.step_away(system, below)?;
        for step in 0..self.steps {
            self.step_near(system, step)?;
        }
        self.step_away(system, above)?;
        end(system);
        Ok(())
    }

    /// The numbers [first, end) of the waves below and above the body: row r - lag s takes step s where r is
    /// the number.
    fn skewed(&self) -> [[usize; 2]; 2] {
        let ([bottom, end], last) = (self.near, self.lag * (self.steps - 1));
        [[0, bottom], [end + last, self.rows + last]]
    }

    /// Rows [first, end), those that the body may reach among them, that take a step after all of the wave
    /// below.
    fn rows_near(&self, step: usize) -> [usize; 2] {
        let ([bottom, end], steps, lag) = (self.near, self.steps, self.lag);
        [bottom.saturating_sub(lag * step), (end + lag * (steps - 1 - step)).min(self.rows)]
    }

    /// All steps of the rows away from the body.
    #[inline(never)]
    fn step_away(&self, system: &mut System<'_>, [first, end]: [usize; 2]) -> Result<(), Failure> {
        for r in first..end {
            for step in 0..self.steps {
                let Some(j) = r.checked_sub(self.lag * step).filter(|&j| j < self.rows) else { continue };
                let report = explicit::sweep_in_block(system, step, [j, j + 1]);
                let range = system.arrays.rows.ranges.get(j).copied().unwrap_or_default();
                if report.non_finite || self.is_met(step, j, range) {
                    return Err(Failure::NonFinite);
                }
                system.failed_segments += report.newly_failed;
            }
        }
        Ok(())
    }

    /// A step of the rows that the body may reach.
    #[inline(never)]
    fn step_near(&self, system: &mut System<'_>, step: usize) -> Result<(), Failure> {
        let (gathered, rows) = (self.look_ahead(system)?, self.rows_near(step));
        let report = explicit::sweep_in_block(system, step, rows);
        self.close_near(system, step, rows, &gathered, report)
    }

    /// The candidates of the next step near the body, or why there can be none.
    pub fn look_ahead(&self, system: &mut System<'_>) -> Result<Gathered, Failure> {
        explicit::look_ahead(system, self.near)
    }

    /// What is left of a step near the body after its sweep of rows [first, end). What follows the last step
    /// is left to do.
    #[inline(never)]
    pub fn close_near(
        &self,
        system: &mut System<'_>,
        step: usize,
        [first, end]: [usize; 2],
        gathered: &Gathered,
        report: Report,
    ) -> Result<(), Failure> {
        explicit::finish_step(system, gathered, report)?;
        let ranges = system.arrays.rows.ranges.get(first..end).unwrap_or_default();
        if (first..end).zip(ranges).any(|(j, range)| self.is_met(step, j, *range)) {
            return Err(Failure::NonFinite);
        }
        if step + 1 < self.steps {
            explicit::end_step(system);
        }
        Ok(())
    }

    /// Whether a row that was to be beyond the body's reach is not after a step, before the last one.
    pub fn is_met(&self, step: usize, j: usize, range: [u32; 4]) -> bool {
        let [near, beyond] = self.near;
        !(near..beyond).contains(&j) && step + 1 < self.steps && self.reach.meets(j, range, 0.0)
    }
}

#[cfg(test)]
impl Block {
    /// A block of some steps and rows, for tests of what is stepped when.
    pub fn of_rows(near: [usize; 2], steps: usize, rows: usize) -> Block {
        Block {
            near,
            steps,
            rows,
            lag: 1,
            reach: Reach { low: 0.0, high: 0.0, h: 1.0, rise: 1.0, nodes_y: rows as u32 },
        }
    }
}

impl Reach {
    /// Whether row j, displaced by `range`, comes as near as `slack`, m.
    fn meets(&self, j: usize, [lowest, highest, ..]: [u32; 4], slack: f64) -> bool {
        let [lowest, highest] = range_of([lowest, highest]);
        let rest = rest_offset(j, self.nodes_y) * self.rise;
        (rest + highest) * self.h >= self.low - slack && (rest + lowest) * self.h <= self.high + slack
    }
}

/// Begins a block.
pub(crate) fn begin(system: &mut System<'_>) {
    Noted::of(system.arrays.shared, &system.layout).carries.fill([[0.0; CHUNK]; CARRY_PLANES]);
}

/// Ends a block whose last step is swept.
pub(crate) fn end(system: &mut System<'_>) {
    system.set_awake(0, [0, system.layout.nodes_y]);
    for step in 0..system.block_steps {
        explicit::add_dissipation(system, 0, [0, system.layout.nodes_y], step);
        explicit::add_pulls(system, 0, [0, system.layout.nodes_y], step);
        if system.layout.has(Feature::Clamps) {
            explicit::add_clamp_work(system, 0, [0, system.layout.nodes_y], step);
        }
    }
    explicit::end_step(system);
}

#[cfg(test)]
mod tests {
    use crate::ground::lanes::InstructionSet;
    use crate::ground::random::splitmix64;
    use crate::memory::layout::BLOCK_STEPS;
    use crate::scene::features::Feature;
    use crate::scene::parts::{AttachmentKind, Draw, Drive, StrengthDraw};
    use crate::tests::{saved, sheet, sim};
    use crate::{CacheLine, Failure, Outcome, Scene, Sim};
    use std::vec;
    use std::vec::Vec;

    const STEPS: u64 = BLOCK_STEPS as u64;

    /// Gives a small sheet what one beyond the caches has.
    fn allow_blocks(sim: &mut Sim<'_>) {
        let (rows, steps) = (sim.system.layout.nodes_y, BLOCK_STEPS as usize);
        let taken = if sim.layout().takes_energy() { vec![0.0; steps * rows] } else { Vec::new() };
        sim.system.arrays.rows.taken = taken.leak();
        let clamped = if sim.layout().has(Feature::Clamps) { vec![0.0; steps * rows] } else { Vec::new() };
        sim.system.arrays.rows.clamped = clamped.leak();
        (sim.system.layout.block_steps, sim.system.block_steps) = (BLOCK_STEPS, steps);
        sim.system.arrays.shared = vec![CacheLine::ZERO; sim.system.layout.shared_lines()].leak();
    }

    /// The paper's sphere on 61 x 141 nodes.
    fn sphere() -> Scene {
        sheet(61, 141)
    }

    /// Takes steps in bands, which are called in another order in each pass. Returns how many blocks were
    /// taken.
    fn advance_in_bands(sim: &mut Sim<'_>, of: u32, steps: u64) -> u64 {
        let mut scratch = vec![CacheLine::ZERO; sim.layout().band_lines(of).unwrap()];
        let bands = sim.bands(&mut scratch, of, steps).unwrap();
        let mut blocks = 0;
        while bands.steps() < steps && bands.failure().is_none() {
            let (before, turn) = (bands.steps(), bands.passes());
            for band in 0..of {
                let band = (band + turn as u32) % of;
                let result = bands.pass(if turn % 2 == 0 { band } else { of - 1 - band });
                assert_eq!(result.is_ok(), bands.failure().is_none());
            }
            blocks += u64::from(bands.steps() > before + 1);
        }
        blocks
    }

    /// Takes steps in blocks where they are allowed. Returns how many blocks were taken.
    fn advance_in_blocks(sim: &mut Sim<'_>, steps: u64) -> u64 {
        let (mut blocks, mut left) = (0, steps);
        while left > 0 {
            let taken = super::step_block(&mut sim.system, left).unwrap();
            blocks += taken / STEPS;
            if taken == 0 {
                sim.step().unwrap();
            }
            left -= taken.max(1);
        }
        blocks
    }

    /// Runs a scene in single steps and, `at_once` steps a call, in blocks, without and with bands. Returns
    /// how many blocks were taken and how many segments failed.
    fn same_bits(scene: &Scene, set: InstructionSet, steps: u64, at_once: u64) -> (u64, u64) {
        let mut all = [sim(scene), sim(scene), sim(scene)];
        for sim in &mut all {
            sim.use_instructions(set).unwrap();
            sim.step_every_row();
        }
        let [mut single, mut blocked, mut banded] = all;
        allow_blocks(&mut blocked);
        allow_blocks(&mut banded);
        let mut blocks = 0;
        while single.step_count() < steps {
            (0..at_once).for_each(|_| single.step().unwrap());
            let taken = advance_in_blocks(&mut blocked, at_once);
            blocks += taken;
            let of = 1 + (single.step_count() / at_once % 11) as u32;
            let in_bands = if single.layout().has(Feature::Viscosity) { 0 } else { taken };
            assert_eq!(advance_in_bands(&mut banded, of, at_once), in_bands, "{of} bands");
            let here = (single.digest(), single.counters());
            assert_eq!(here, (blocked.digest(), blocked.counters()), "step {}", single.step_count());
            assert_eq!(here, (banded.digest(), banded.counters()), "{of} bands");
        }
        (blocks, single.counters().failed_segments)
    }

    #[test]
    fn blocks_give_the_bits_of_single_steps() {
        for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
            let (blocks, failed) = same_bits(&sphere(), set, 3200, 64);
            assert!(blocks > 350 && failed > 10, "{blocks} {failed}");
        }
    }

    /// Gives a scene one of some options.
    fn with_option(scene: &mut Scene, number: u64) {
        match number % 8 {
            0 => scene.yarn.strength_draw = StrengthDraw::Weibull,
            1 => (scene.attachment.hold, scene.attachment.grip, scene.attachment.strength) = (300.0, 1e-3, 2e4),
            2 if scene.attachment.kind == AttachmentKind::FourSides => {
                (scene.sheet.pre_strain, scene.yarn.draw) = ([0.004, 0.002], Draw::Yarn);
            }
            3 => scene.contact.friction = 0.2,
            4 => {
                scene.projectile = Scene::sheet_10in_cylinder().projectile;
                (scene.projectile.radius, scene.projectile.length) = (3e-3, 0.01);
                (scene.drive, scene.projectile.velocity) = (Drive::Prescribed, [0.0, 4.0, 600.0]);
                scene.projectile.angular_velocity = [2000.0, 500.0, -300.0];
            }
            5 => (scene.sheet.crimp, scene.yarn.stochastic) = ([0.002, 0.004], false),
            _ => {}
        }
    }

    /// Sheets, bodies, supports, options and calls at random, with an image saved and loaded on the way.
    #[test]
    fn blocks_give_the_bits_of_single_steps_in_random_scenes() {
        let mut blocks = 0;
        let (mut slid, mut failed) = (0, 0);
        for k in 0..60 {
            let number = |n: u64| splitmix64(100 * k + n);
            let part = |n: u64| number(n) as f64 / u64::MAX as f64;
            let mut scene = sphere();
            let (sheet, projectile) = (&mut scene.sheet, &mut scene.projectile);
            (sheet.nodes_x, sheet.nodes_y) = (17 + (number(0) % 40) as u32, 60 + (number(1) % 180) as u32);
            sheet.spacing_y = if number(2).is_multiple_of(3) { sheet.spacing * (0.7 + part(3)) } else { 0.0 };
            projectile.radius = sheet.spacing * (2.0 + 4.0 * part(4));
            let half = [sheet.nodes_x, sheet.nodes_y].map(|nodes| 0.5 * f64::from(nodes) * sheet.spacing);
            projectile.position = [(part(5) - 0.5) * half[0], (2.0 * part(6) - 1.0) * half[1], -projectile.radius];
            projectile.velocity = [40.0 * (part(7) - 0.5), 200.0 * (part(8) - 0.5), 150.0 + 200.0 * part(9)];
            scene.attachment.kind = match number(10) % 3 {
                0 => AttachmentKind::FourSides,
                1 => AttachmentKind::TwoSides,
                _ => AttachmentKind::Free,
            };
            scene.yarn.stochastic = number(11).is_multiple_of(2);
            (scene.track_support, scene.seed) = (!number(12).is_multiple_of(4), k);
            if number(13).is_multiple_of(3) {
                (scene.yarn.viscosity_quadratic, scene.yarn.viscosity_bending) = (1.5, 0.06);
            }
            with_option(&mut scene, number(14));
            let [mut single, mut blocked] = [sim(&scene), sim(&scene)];
            if k % 2 == 0 {
                single.step_every_row();
                blocked.step_every_row();
            }
            allow_blocks(&mut blocked);
            for call in 0..12 {
                let steps = 1 + number(20 + call) % 90;
                (0..steps).for_each(|_| single.step().unwrap());
                blocks += if (k + call) % 3 == 0 {
                    advance_in_bands(&mut blocked, 1 + (call % 7) as u32, steps)
                } else {
                    advance_in_blocks(&mut blocked, steps)
                };
                assert_eq!(single.digest(), blocked.digest(), "scene {k}, call {call}");
                assert_eq!(single.counters(), blocked.counters());
                let image = saved(&blocked);
                blocked.load(&image).unwrap();
            }
            slid += usize::from(single.energy().unwrap().attachment > 0.0);
            failed += single.counters().failed_segments;
        }
        assert!(blocks > 1000 && slid > 2 && failed > 100, "{blocks} {slid} {failed}");
    }

    /// The rows that come within a spacing of the sphere, eight that it may cross, and eight that rows may
    /// come nearer.
    #[test]
    fn the_rows_near_the_body_are_those_that_it_may_reach_in_a_block() {
        let mut scene = sphere();
        scene.projectile.position[1] = 10.2 * scene.sheet.spacing;
        scene.projectile.radius = 8.5 * scene.sheet.spacing;
        let mut sim = sim(&scene);
        sim.step_every_row();
        allow_blocks(&mut sim);
        // The middle of the sheet lies in row 70: 80.2 - 25.5 and 80.2 + 25.5.
        assert_eq!(super::Block::plan(&sim.system, STEPS).unwrap().near, [55, 106]);
    }

    #[test]
    fn no_block_is_taken_where_the_body_reaches_a_fixed_node() {
        let mut scene = sphere();
        scene.projectile.position[0] = 0.45 * 61.0 * scene.sheet.spacing;
        assert_eq!(same_bits(&scene, InstructionSet::widest(), 320, 64).0, 0);
    }

    #[test]
    fn a_run_ends_at_the_step_of_its_outcome() {
        let ends = |blocks: bool| {
            let mut sim = sim(&sphere());
            sim.step_every_row();
            if blocks {
                allow_blocks(&mut sim);
            }
            // From here on the first blocks could begin anywhere.
            sim.advance(3).unwrap();
            let steps = sim.advance_until(Outcome::Exited, 20_003).unwrap();
            (steps, sim.step_count(), sim.digest())
        };
        assert_eq!(ends(true), ends(false));
        assert!(ends(true).0 < 20_000);
    }

    /// A row that comes from beyond the rows that are stepped one by one would have been missed.
    #[test]
    fn a_row_that_strays_to_the_body_within_a_block_is_a_lost_state() {
        let scene = sphere();
        let mut sim = sim(&scene);
        sim.step_every_row();
        let nodes = sim.layout().nodes();
        let mut positions = vec![0.0; 3 * nodes];
        sim.copy_positions(&mut positions).unwrap();
        let speed = |spacings: f64| spacings * scene.sheet.spacing / sim.step_limits().dt;
        let moving = |spacings: f64| -> Vec<f64> {
            let mut velocities = vec![0.0; 3 * nodes];
            velocities[3 * (130 * 61 + 30) + 1] = -speed(spacings);
            velocities
        };
        let (slow, fast) = (moving(1.0), moving(9.0));
        sim.set_motion(&positions, &slow).unwrap();
        allow_blocks(&mut sim);
        assert_eq!(super::step_block(&mut sim.system, STEPS), Ok(STEPS));
        for of in [0, 1, 2] {
            sim.reset();
            sim.set_motion(&positions, &fast).unwrap();
            if of > 0 {
                advance_in_bands(&mut sim, of, STEPS);
            } else {
                assert_eq!(sim.advance(STEPS), Err(Failure::NonFinite));
            }
            assert_eq!((sim.failure(), sim.advance(1)), (Some(Failure::NonFinite), Err(Failure::NonFinite)), "{of}");
        }
    }

    #[test]
    fn a_failure_within_a_block_is_latched() {
        let mut scene = sphere();
        scene.contact_capacity = 1;
        let mut sim = sim(&scene);
        sim.step_every_row();
        allow_blocks(&mut sim);
        assert_eq!(sim.advance(640), Err(Failure::ContactCapacity));
        assert_eq!((sim.failure(), sim.step()), (Some(Failure::ContactCapacity), Err(Failure::ContactCapacity)));
        sim.reset();
        advance_in_bands(&mut sim, 2, 640);
        assert_eq!((sim.failure(), sim.step()), (Some(Failure::ContactCapacity), Err(Failure::ContactCapacity)));
    }
}
