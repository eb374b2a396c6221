//! A block of steps on one thread, in the order of `step/schedule.rs`, and what it has in common with one in
//! bands.
//!
//! Limits: after a failure in a block rows may be ahead of the step that is counted, and another failure of
//! the same block may be reported than single steps would have met first; nothing but counters and the digest
//! can be read then.
//! Reference: docs/model.md, "Steps in blocks".

use crate::contact::search::Gathered;
use crate::ground::error::Failure;
use crate::ground::planes::{CARRY_PLANES, CHUNK};
use crate::memory::arrays::StepScratch;
use crate::memory::network::Network;
use crate::memory::system::System;
use crate::step::one_step;
use crate::step::schedule::Block;
use crate::step::whole;
use crate::sweep::accounts;
use crate::sweep::segments::Report;

/// Takes a block of steps, if `most` steps allow one now: how many, or 0.
#[inline(never)]
pub(crate) fn step_block(system: &mut System<'_>, most: u64) -> Result<u64, Failure> {
    let Some(block) = &Block::plan(system, most, 0) else { return Ok(0) };
    zero_carried_forces(&mut system.network);
    step_away(system, block, false)?;
    (0..block.steps).try_for_each(|step| step_near(system, block, step))?;
    step_away(system, block, true)?;
    end(system);
    Ok(block.steps as u64)
}

/// A step of the rows that the body may reach.
#[inline(never)]
fn step_near(system: &mut System<'_>, block: &Block, step: usize) -> Result<(), Failure> {
    let gathered = one_step::look_ahead(system, block.near)?;
    let report = whole::sweep_in_block(&mut system.network, system.state.sums.loaded, step, block.rows_near(step));
    end_near(system, block, step, &gathered, report)
}

/// Sweeps the rows away from the body, below it or above it, in all steps of a block.
fn step_away(system: &mut System<'_>, block: &Block, is_above: bool) -> Result<(), Failure> {
    let tile = block.tile(0, is_above);
    for r in tile.wavefronts() {
        for step in 0..block.steps {
            let Some(j) = tile.row(r, step) else { continue };
            let report = whole::sweep_in_block(&mut system.network, system.state.sums.loaded, step, [j, j + 1]);
            let range = system.network.arrays.rows.ranges.get(j).copied().unwrap_or_default();
            if report.non_finite || block.is_met(step, j, range) {
                return Err(Failure::NonFinite);
            }
            system.failed_segments += report.newly_failed;
        }
    }
    Ok(())
}

/// Carried forces of every step of a block, set to zero.
pub(crate) fn zero_carried_forces(network: &mut Network<'_>) {
    StepScratch::of(network.arrays.shared, &network.layout).carries.fill([[0.0; CHUNK]; CARRY_PLANES]);
}

/// Rest of a step near the body after its sweep, but for what follows the last step.
pub(crate) fn end_near(
    system: &mut System<'_>,
    block: &Block,
    step: usize,
    gathered: &Gathered,
    report: Report,
) -> Result<(), Failure> {
    let [first, end] = block.rows_near(step);
    one_step::apply_contact_and_move_body(system, gathered, report)?;
    if block.are_met(step, first, system.network.arrays.rows.ranges.get(first..end).unwrap_or_default()) {
        return Err(Failure::NonFinite);
    }
    if step + 1 < block.steps {
        one_step::count_step(system);
    }
    Ok(())
}

/// Ends a block whose last step is swept.
pub(crate) fn end(system: &mut System<'_>) {
    let rows = [0, system.network.layout.nodes_y];
    system.network.set_awake(0, rows);
    for step in 0..system.network.block_steps {
        accounts::add_sweep(&mut system.network, &mut system.state.sums, 0, rows, step);
    }
    one_step::count_step(system);
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
        let (rows, steps) = (sim.system.network.layout.nodes_y, BLOCK_STEPS as usize);
        let dissipated = if sim.layout().dissipates() { vec![0.0; steps * rows] } else { Vec::new() };
        sim.system.network.arrays.rows.dissipated = dissipated.leak();
        let clamped = if sim.layout().has(Feature::Clamps) { vec![0.0; steps * rows] } else { Vec::new() };
        sim.system.network.arrays.rows.clamped = clamped.leak();
        (sim.system.network.layout.block_steps, sim.system.network.block_steps) = (BLOCK_STEPS, steps);
        sim.system.network.arrays.shared = vec![CacheLine::ZERO; sim.system.network.layout.shared_lines()].leak();
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
            let (before, passes) = (bands.steps(), bands.passes());
            for band in 0..of {
                let band = (band + passes as u32) % of;
                let result = bands.pass(if passes % 2 == 0 { band } else { of - 1 - band });
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
            assert_eq!(advance_in_bands(&mut banded, of, at_once), taken, "{of} bands");
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
        let (mut slid, mut failed, mut viscous) = (0, 0, 0);
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
            if scene.attachment.kind == AttachmentKind::Free {
                (scene.attachment.hold, scene.attachment.grip, scene.attachment.strength) = (0.0, 0.0, 0.0);
            }
            let [mut single, mut blocked] = [sim(&scene), sim(&scene)];
            if k % 2 == 0 {
                single.step_every_row();
                blocked.step_every_row();
            }
            allow_blocks(&mut blocked);
            for call in 0..12 {
                let steps = 1 + number(20 + call) % 90;
                (0..steps).for_each(|_| single.step().unwrap());
                if (k + call) % 3 == 0 {
                    let taken = advance_in_bands(&mut blocked, 1 + (call % 7) as u32, steps);
                    blocks += taken;
                    viscous += if single.layout().has(Feature::Viscosity) { taken } else { 0 };
                } else {
                    blocks += advance_in_blocks(&mut blocked, steps);
                }
                assert_eq!(single.digest(), blocked.digest(), "scene {k}, call {call}");
                assert_eq!(single.counters(), blocked.counters());
                let image = saved(&blocked);
                blocked.load(&image).unwrap();
            }
            slid += usize::from(single.energy().unwrap().attachment > 0.0);
            failed += single.counters().failed_segments;
        }
        assert!(blocks > 1000 && viscous > 100 && slid > 2 && failed > 100, "{blocks} {viscous} {slid} {failed}");
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
        assert_eq!(super::Block::plan(&sim.system, STEPS, 0).unwrap().near, [55, 106]);
    }

    /// No row is near the body then.
    #[test]
    fn a_sheet_beside_the_body_has_the_bits_of_single_steps() {
        for bending in [0.0, 0.06] {
            let mut scene = sphere();
            (scene.yarn.viscosity_bending, scene.attachment.kind) = (bending, AttachmentKind::Free);
            scene.projectile.position[1] = 141.0 * scene.sheet.spacing;
            let mut sims = [(); 4].map(|()| sim(&scene));
            for sim in &mut sims {
                let mut positions = vec![0.0; 3 * sim.layout().nodes()];
                sim.copy_positions(&mut positions).unwrap();
                let number = |k: usize| splitmix64(k as u64) as f64 / u64::MAX as f64 - 0.5;
                let velocities: Vec<f64> = (0..positions.len()).map(|k| 20.0 * number(k)).collect();
                sim.set_motion(&positions, &velocities).unwrap();
                sim.step_every_row();
            }
            let [single, others @ ..] = &mut sims;
            (0..64).for_each(|_| single.step().unwrap());
            for (of, other) in (0..).zip(others) {
                allow_blocks(other);
                let taken = if of == 0 { advance_in_blocks(other, 64) } else { advance_in_bands(other, of, 64) };
                assert_eq!((taken, other.digest()), (64 / STEPS, single.digest()), "{bending} {of}");
            }
        }
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
