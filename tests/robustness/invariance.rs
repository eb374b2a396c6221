//! The bits of a run depend on the scene and the number of steps alone, not on how the calls are made. Nearly
//! every scene here runs past its first failures, where any difference of rounding would grow.

use crate::bands::in_turn;
use fabric_kernel::internals::layout::MAX_BANDS;
use fabric_kernel::{CacheLine, Drive, InstructionSet, Integrator, Motion, Path, Scene, Sim, TimeStep};
use fabric_tests::options::{self, Mix};
use fabric_tests::{
    damage, drawn, golden, image_of, memory_of, positions, sim_of, small_sheet, stepped, tilted_cylinder, velocities,
};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::OnceLock;

const STEPS: u64 = 400;

/// Scenes that hold every pair of options that goes together, how their plain runs end, and the pairs that do
/// not.
type Mixed = (Vec<(Mix, End)>, Vec<[&'static str; 2]>);

fn mixed() -> &'static Mixed {
    static MIXED: OnceLock<Mixed> = OnceLock::new();
    MIXED.get_or_init(|| {
        let plain = |mix: Mix| {
            let end = run(&mix, |sim| sim.advance(STEPS).unwrap());
            (mix, end)
        };
        let (mixes, apart) = options::mixes();
        (mixes.into_par_iter().map(plain).collect(), apart)
    })
}

#[derive(PartialEq)]
struct End {
    digest: u64,
    failed: bool,
    touched: bool,
}

/// How a mix ends that has been started and run in some way.
fn run(mix: &Mix, way: impl Fn(&mut Sim<'_>)) -> End {
    let scene = mix.scene();
    let mut sim = sim_of(&scene);
    mix.start(&mut sim).unwrap();
    way(&mut sim);
    assert_eq!(sim.step_count(), STEPS);
    let (failed, touched) = (sim.counters().failed_segments > 0, sim.outcomes().first_contact.is_some());
    End { digest: sim.digest(), failed, touched }
}

/// Bits of positions and velocities, and the projectile, after a plain run. (A digest is also of what is not
/// motion.)
fn end_of(scene: &Scene) -> ([Vec<u64>; 2], Motion) {
    let sim = stepped(scene, 1000);
    assert!(sim.counters().failed_segments > 0);
    let nodes = [positions(&sim), velocities(&sim)];
    let bits = nodes.map(|motion| motion.as_flattened().iter().map(|x| x.to_bits()).collect());
    (bits, sim.projectile().unwrap())
}

/// Runs every mix in a special way and compares with the plain run.
#[track_caller]
fn same_bits(special: impl Fn(&Mix, &mut Sim<'_>) + Sync) {
    let (mixes, _) = mixed();
    let unlike = |(mix, plain): &&(Mix, End)| run(mix, |sim| special(mix, sim)) != *plain;
    let other: Vec<_> = mixes.par_iter().filter(unlike).map(|(mix, _)| mix.names()).collect();
    assert!(other.is_empty(), "{} of {}: {other:#?}", other.len(), mixes.len());
}

/// Every pair of options that the kernel takes is in a mix, and all of them are run in each of the ways
/// below.
#[test]
fn the_mixes_hold_every_pair_of_options() {
    let (mixes, apart) = mixed();
    let covered: BTreeSet<_> = mixes.iter().flat_map(|(mix, _)| mix.pairs()).collect();
    let sizes = options::GROUPS.iter().map(|group| group.len());
    let options = sizes.clone().sum::<usize>();
    let pairs = (options * options - sizes.map(|size| size * size).sum::<usize>()) / 2;
    let failed = mixes.iter().filter(|(_, end)| end.failed).count();
    println!(
        "figure 7: {options} options, {} of {pairs} pairs in {} scenes, {failed} past first failure; {} pairs are refused: {apart:?}",
        covered.len(),
        mixes.len(),
        apart.len()
    );
    assert_eq!(covered.len() + apart.len(), pairs);
    assert!(mixes.iter().all(|(_, end)| end.touched) && 2 * failed > mixes.len());
    assert!(apart.iter().flatten().all(|name| apart.iter().filter(|pair| pair.contains(name)).count() < options / 2));
}

#[test]
fn any_split_of_the_steps_is_alike() {
    same_bits(|_, sim| {
        sim.step_every_row();
        sim.advance(STEPS).unwrap();
    });
    same_bits(|_, sim| (0..STEPS).for_each(|_| sim.step().unwrap()));
    same_bits(|_, sim| {
        let mut batch = 1;
        while sim.step_count() < STEPS {
            sim.advance(batch.min(STEPS - sim.step_count())).unwrap();
            sim.advance(0).unwrap();
            batch = batch * 5 % 97;
        }
    });
    same_bits(|_, sim| {
        while sim.step_count() < STEPS {
            sim.advance_until(fabric_kernel::OutcomeSet::NONE, 11.min(STEPS - sim.step_count())).unwrap();
        }
    });
}

#[test]
fn bands_are_alike() {
    for (of, set) in [1, 2, 3, 5, MAX_BANDS].into_iter().zip(InstructionSet::ALL.into_iter().cycle()) {
        same_bits(|_, sim| {
            // One that this machine lacks leaves the widest.
            let _ = sim.use_instructions(set);
            if sim.scene().integrator == Integrator::VERLET {
                in_turn(sim, of, STEPS / 3).unwrap();
                sim.advance(10).unwrap();
                in_turn(sim, of, STEPS - sim.step_count()).unwrap();
            } else {
                sim.advance(STEPS).unwrap();
            }
        });
    }
}

/// One call sweeps a large stack in several runs of rows, bands sweep it ply by ply. At rest rows are left
/// out at first.
#[test]
fn plies_swept_in_runs_move_as_in_bands() {
    let mut plain = small_sheet(65, 300.0);
    (plain.stack.plies, plain.stack.gap, plain.track_support) = (5, 5e-5, true);
    let mut viscous = plain;
    let yarn = &mut viscous.yarn;
    (yarn.viscosity_linear, yarn.viscosity_quadratic, yarn.viscosity_bending) = (0.06, 1.5, 0.06);
    for scene in [plain, viscous, Scene { slack_balance: true, ..viscous }] {
        let mut banded = sim_of(&scene);
        in_turn(&mut banded, 3, 1500).unwrap();
        assert!(banded.counters().failed_segments > 0 && banded.energy().unwrap().ply_loss > 0.0);
        assert_eq!(stepped(&scene, 1500).digest(), banded.digest());
    }
}

#[test]
fn read_outs_change_nothing() {
    same_bits(|_, sim| {
        while sim.step_count() < STEPS {
            sim.advance(7.min(STEPS - sim.step_count())).unwrap();
            let _ = (sim.energy(), sim.fabric(), sim.support(), sim.contact(), sim.projectile(), sim.outcomes());
            let _ = (sim.momentum_residual(), sim.counters(), sim.digest(), image_of(sim));
            let _ = (positions(sim), velocities(sim), damage(sim));
        }
    });
}

#[test]
fn watching_supports_and_detachment_changes_no_motion() {
    for scene in [small_sheet(21, 250.0), tilted_cylinder(17, 0.3, 500.0), golden::sphere_through_turned_plies()] {
        let motion = |watched| end_of(&Scene { track_support: watched, track_detachment: watched, ..scene });
        assert_eq!(motion(true), motion(false));
    }
}

/// Yarn that is drawn, but without scatter, is uniform yarn.
#[test]
fn drawing_without_scatter_changes_no_motion() {
    let mut uniform = small_sheet(21, 250.0);
    // The step of drawn yarn may differ by rounding.
    uniform.time_step = TimeStep::seconds(uniform.step_limits().unwrap().dt);
    let mut drawn = drawn(uniform);
    (drawn.yarn.modulus_sd, drawn.yarn.damage_sd) = (0.0, 0.0);
    assert_eq!(end_of(&uniform), end_of(&drawn));
}

#[test]
fn instruction_sets_change_nothing() {
    for set in InstructionSet::ALL {
        same_bits(|_, sim| {
            // One that this machine lacks is refused and leaves the widest.
            assert_eq!(sim.use_instructions(set).is_ok(), set.available());
            sim.advance(STEPS).unwrap();
        });
    }
}

#[test]
fn a_reset_starts_afresh() {
    same_bits(|mix, sim| {
        let started = sim.digest();
        sim.advance(300).unwrap();
        sim.reset();
        mix.start(sim).unwrap();
        assert_eq!(sim.digest(), started);
        sim.advance(STEPS).unwrap();
    });
}

#[test]
fn saving_and_loading_in_the_middle_goes_on_alike() {
    // Before contact, during it, at an outcome test, after failures.
    for at in [0, 64, 333] {
        same_bits(|mix, sim| {
            sim.advance(at).unwrap();
            let mut image = vec![0xa5; sim.snapshot_bytes() + 3];
            sim.save(&mut image).unwrap();
            assert_eq!(image.split_off(sim.snapshot_bytes()), [0xa5; 3], "no more than its bytes");
            let here = (sim.digest(), sim.counters().failed_segments);

            // Into a fresh one in dirty memory, not started; saving again gives the same bytes.
            let scene = mix.scene();
            let mut memory = vec![CacheLine([f64::NAN; 8]); memory_of(&scene).len()];
            let mut other = Sim::new(&scene, &mut memory).unwrap();
            other.load(&image).unwrap();
            assert_eq!(image_of(&other), image);
            assert_eq!((other.digest(), other.counters().failed_segments), here);
            other.advance(STEPS - at).unwrap();

            // Into the same simulation, after it went elsewhere.
            sim.advance(99).unwrap();
            sim.load(&image).unwrap();
            assert_eq!(sim.digest(), here.0);
            sim.advance(9).unwrap();
            sim.load_kept(&image).unwrap();
            assert_eq!(sim.digest(), here.0);
            sim.advance(STEPS - at).unwrap();
            assert_eq!(sim.digest(), other.digest(), "{:?}", mix.names());
        });
    }
}

/// In memory that is longer than needed and holds what other runs left there, and in turns with another
/// simulation.
#[test]
fn other_memory_and_other_simulations_change_nothing() {
    // Each place holds a number once and a NaN once.
    for [a, b] in [[f64::NAN, 1e300], [f64::NEG_INFINITY, f64::from_bits(u64::MAX)]] {
        same_bits(|mix, sim| {
            let scene = mix.scene();
            let need = memory_of(&scene).len();
            let dirt = CacheLine([a, b, a, b, a, b, a, b]);
            let mut lines = vec![dirt; need + 100];
            let mut other = Sim::new(&scene, &mut lines).unwrap();
            mix.start(&mut other).unwrap();
            while sim.step_count() < STEPS {
                sim.advance(7.min(STEPS - sim.step_count())).unwrap();
                other.advance(3).unwrap();
            }
            other.advance(STEPS - other.step_count()).unwrap();
            assert_eq!(sim.digest(), other.digest(), "{:?}", mix.names());
            assert!(lines[need..].iter().all(|line| line.0.map(f64::to_bits) == dirt.0.map(f64::to_bits)));
        });
    }
}

/// A path driven in one call or in single steps. (A mix has a path, too.)
#[test]
fn any_split_of_a_path_is_alike() {
    for scene in [small_sheet(21, 200.0), tilted_cylinder(21, 0.3, 200.0)] {
        let scene = Scene { drive: Drive::Prescribed, ..scene };
        let way = 250.0 * STEPS as f64 * scene.step_limits().unwrap().dt;
        let [x, y, z] = scene.projectile.position;
        let end = Motion {
            position: [x + 0.1 * way, y, z + way],
            velocity: [0.0, 50.0, 220.0],
            orientation: [0.99, 0.0, (1.0f64 - 0.99 * 0.99).sqrt(), 0.0],
            angular_velocity: [0.0, 100.0, 0.0],
        };
        let path = Path { first: 0, steps: STEPS, end };
        let (mut whole, mut split) = (sim_of(&scene), sim_of(&scene));
        whole.follow(&path, STEPS).unwrap();
        (0..STEPS).for_each(|_| split.follow(&path, 1).unwrap());
        assert!(whole.counters().failed_segments > 0);
        assert_eq!(whole.digest(), split.digest());
    }
}
