//! The bits of a run depend on the scene and the number of steps alone, not on how the calls are made. Nearly every scene here
//! runs past its first failures, where any difference of rounding would grow.

use crate::golden;
use fabric::{CacheLine, Drive, InstructionSet, Integrator, Motion, Path, Scene, Sim, TimeStep};
use fabric_tests::options::{self, Mix};
use fabric_tests::{Buffers, damage, positions, small_sheet, tilted_cylinder, velocities};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::OnceLock;

const STEPS: u64 = 400;

/// Scenes that hold every pair of options that goes together, how their plain runs end, and the pairs that do not.
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
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    mix.start(&mut sim).unwrap();
    way(&mut sim);
    assert_eq!(sim.step_count(), STEPS);
    let (failed, touched) = (sim.counters().failed_segments > 0, sim.outcomes().first_contact.is_some());
    End { digest: sim.digest(), failed, touched }
}

/// Bits of positions and velocities, and the projectile, after a plain run. (A digest is also of what is not motion.)
fn end_of(scene: &Scene) -> ([Vec<u64>; 2], Motion) {
    let mut memory = Buffers::of(scene);
    let mut sim = memory.sim(scene);
    sim.advance(1000).unwrap();
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

/// Every pair of options that the kernel takes is in a mix, and all of them are run in each of the ways below.
#[test]
fn the_mixes_hold_every_pair_of_options() {
    let (mixes, apart) = mixed();
    let covered: BTreeSet<_> = mixes.iter().flat_map(|(mix, _)| mix.pairs()).collect();
    let sizes = options::GROUPS.iter().map(|group| group.len());
    let options = sizes.clone().sum::<usize>();
    let pairs = (options * options - sizes.map(|size| size * size).sum::<usize>()) / 2;
    let failed = mixes.iter().filter(|(_, end)| end.failed).count();
    println!(
        "figure 7b: {options} options, {} of {pairs} pairs in {} scenes, {failed} past first failure; {} pairs are refused: {apart:?}",
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
            sim.advance_until(fabric::OutcomeSet::NONE, 11.min(STEPS - sim.step_count())).unwrap();
        }
    });
}

#[test]
fn bands_are_alike() {
    same_bits(|_, sim| {
        let mut scratch = vec![CacheLine([f64::NAN; 8]); sim.layout().band_lines(3).unwrap_or(0)];
        if sim.scene().integrator == Integrator::VERLET {
            let bands = sim.bands(&mut scratch, 3, 0).unwrap();
            while bands.steps() < STEPS {
                (0..3).rev().for_each(|band| _ = bands.pass(band).unwrap());
            }
        } else {
            sim.advance(STEPS).unwrap();
        }
    });
}

#[test]
fn read_outs_change_nothing() {
    same_bits(|_, sim| {
        let mut image = vec![0; sim.snapshot_bytes()];
        while sim.step_count() < STEPS {
            sim.advance(7.min(STEPS - sim.step_count())).unwrap();
            let _ = (sim.energy(), sim.fabric(), sim.support(), sim.contact(), sim.projectile(), sim.outcomes());
            let _ = (sim.momentum_residual(), sim.counters(), sim.digest(), sim.save(&mut image));
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
    uniform.yarn.stochastic = false;
    // The step of drawn yarn may differ by rounding.
    uniform.time_step = TimeStep::seconds(uniform.step_limits().unwrap().dt);
    let mut drawn = uniform;
    drawn.yarn.stochastic = true;
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
            let mut memory = Buffers::of(&scene);
            memory.lines.fill(CacheLine([f64::NAN; 8]));
            let mut other = memory.sim(&scene);
            other.load(&image).unwrap();
            let mut again = vec![0; other.snapshot_bytes()];
            other.save(&mut again).unwrap();
            assert_eq!(again, image);
            assert_eq!((other.digest(), other.counters().failed_segments), here);
            other.advance(STEPS - at).unwrap();

            // Into the same simulation, after it went elsewhere.
            sim.advance(99).unwrap();
            sim.load(&image).unwrap();
            assert_eq!(sim.digest(), here.0);
            sim.advance(STEPS - at).unwrap();
            assert_eq!(sim.digest(), other.digest(), "{:?}", mix.names());
            sim.load_kept(&image).unwrap();
            assert_eq!(sim.digest(), here.0);
            sim.advance(STEPS - at).unwrap();
        });
    }
}

/// A path driven in one call, in single steps, in uneven pieces, and across a save and load.
#[test]
fn any_split_of_a_path_is_alike() {
    for mut scene in [small_sheet(21, 200.0), tilted_cylinder(21, 0.3, 200.0)] {
        scene.drive = Drive::Prescribed;
        let dt = scene.step_limits().unwrap().dt;
        let way = 250.0 * STEPS as f64 * dt;
        let start = scene.projectile.position;
        let end = Motion {
            position: [start[0] + 0.1 * way, start[1], start[2] + way],
            velocity: [0.0, 50.0, 220.0],
            orientation: [0.99, 0.0, (1.0f64 - 0.99 * 0.99).sqrt(), 0.0],
            angular_velocity: [0.0, 100.0, 0.0],
        };
        let path = Path { first: 0, steps: STEPS, end };
        let run = |special: &dyn Fn(&mut Sim<'_>)| {
            let mut memory = Buffers::of(&scene);
            let mut sim = memory.sim(&scene);
            special(&mut sim);
            assert_eq!(sim.step_count(), STEPS);
            assert!(sim.counters().failed_segments > 0);
            sim.digest()
        };
        let whole = run(&|sim| sim.follow(&path, STEPS).unwrap());
        assert_eq!(whole, run(&|sim| (0..STEPS).for_each(|_| sim.follow(&path, 1).unwrap())));
        assert_eq!(
            whole,
            run(&|sim| {
                sim.follow(&path, 123).unwrap();
                // Stepping goes along the path too.
                sim.advance(77).unwrap();
                let mut image = vec![0; sim.snapshot_bytes()];
                sim.save(&mut image).unwrap();
                sim.reset();
                sim.load(&image).unwrap();
                sim.follow(&path, STEPS - 200).unwrap();
            })
        );
    }
}

// ---- The golden scenes -----------------------------------------------------------------------------------------------

/// A golden scene as the golden tests run it; the largest for fewer steps.
#[derive(Clone, Copy)]
struct Golden {
    name: &'static str,
    scene: fn() -> Scene,
    steps: u64,
    /// What is done before the first step.
    prepare: fn(&mut Sim<'_>),
    /// Paths that a prescribed body follows.
    paths: fn() -> Vec<Path>,
}

#[rustfmt::skip]
fn golden_scenes() -> Vec<Golden> {
    let plain = |name, scene, steps| Golden { name, scene, steps, prepare: |_| (), paths: Vec::new };
    vec![
        plain("sheet_3in_sphere", Scene::sheet_3in_sphere, 2000),
        plain("sheet_10in_cylinder", Scene::sheet_10in_cylinder, 150),
        plain("uniform_sphere", golden::uniform_sphere, 3000),
        plain("sphere_on_softened_yarn", golden::sphere_on_softened_yarn, 3000),
        plain("sphere_on_drawn_strength", golden::sphere_on_drawn_strength, 3000),
        plain("taut_warp_and_crimped_weft", golden::taut_warp_and_crimped_weft, 3000),
        plain("uniform_sphere_in_halves", golden::uniform_sphere_in_halves, 3000),
        plain("tumbling_cylinder_on_corners", golden::tumbling_cylinder_on_corners, 2000),
        plain("free_plies_in_a_turned_frame", golden::free_plies_in_a_turned_frame, 1500),
        plain("damage_law_with_offset", golden::damage_law_with_offset, 2000),
        plain("quarter_under_a_cylinder", golden::quarter_under_a_cylinder, 2500),
        plain("drawn_yarns_by_the_theta_rule", golden::drawn_yarns_by_the_theta_rule, 1200),
        plain("tumbling_bullet", golden::tumbling_bullet, 2000),
        plain("box_on_a_corner", golden::box_on_a_corner, 1500),
        plain("disc_sector", golden::disc_sector, 600),
        Golden {
            prepare: |sim| {
                golden::pre_damage_and_stretch(sim);
                sim.set_external_load([0.5, -0.25, 2000.0], [0.0; 3]).unwrap();
            },
            ..plain("loaded_sphere_on_a_prepared_sheet", golden::uniform_sphere, 1500)
        },
        Golden { paths: || golden::two_paths().to_vec(), ..plain("prescribed_cylinder_on_two_paths", golden::prescribed_cylinder, 1200) },
    ]
}

impl Golden {
    fn start<'a>(&self, memory: &'a mut [CacheLine]) -> Sim<'a> {
        let mut sim = Sim::new(&(self.scene)(), memory).unwrap();
        (self.prepare)(&mut sim);
        sim
    }

    /// Steps until a count with `advance`, which takes so many steps, entering each path where it begins.
    fn run(&self, sim: &mut Sim<'_>, until: u64, mut advance: impl FnMut(&mut Sim<'_>, u64)) {
        let paths = (self.paths)();
        while sim.step_count() < until {
            let now = sim.step_count();
            if let Some(path) = paths.iter().find(|path| path.first == now) {
                sim.follow(path, 0).unwrap();
            }
            let next = paths.iter().map(|path| path.first).filter(|&first| first > now).fold(until, u64::min);
            advance(sim, next - now);
        }
    }

    fn finish(&self, sim: &mut Sim<'_>) {
        self.run(sim, self.steps, |sim, steps| sim.advance(steps).unwrap());
    }

    fn digest_in(&self, memory: &mut [CacheLine]) -> u64 {
        let mut sim = self.start(memory);
        self.finish(&mut sim);
        sim.digest()
    }

    /// The digest after a run that is special from its start on.
    fn special(&self, run: impl Fn(&mut Sim<'_>)) -> u64 {
        let mut memory = Buffers::of(&(self.scene)());
        let mut sim = self.start(&mut memory.lines);
        run(&mut sim);
        assert_eq!(sim.step_count(), self.steps);
        sim.digest()
    }

    fn dirty(&self, more: usize) -> Buffers {
        let need = Buffers::of(&(self.scene)()).lines.len();
        Buffers { lines: vec![CacheLine([f64::NAN; 8]); need + more] }
    }

    fn rows_at_rest_stepped(&self) -> u64 {
        self.special(|sim| {
            sim.step_every_row();
            self.finish(sim);
        })
    }

    fn in_many_calls(&self) -> u64 {
        self.special(|sim| {
            self.run(sim, self.steps / 2, |sim, steps| (0..steps).for_each(|_| sim.step().unwrap()));
            let mut batch = 1;
            self.run(sim, self.steps, |sim, steps| {
                sim.advance(batch.min(steps)).unwrap();
                batch = batch * 5 % 97;
            });
        })
    }

    fn saved_and_loaded(&self) -> u64 {
        let mut memory = Buffers::of(&(self.scene)());
        let mut sim = self.start(&mut memory.lines);
        self.run(&mut sim, self.steps / 2 + 1, |sim, steps| sim.advance(steps).unwrap());
        let mut image = vec![0; sim.snapshot_bytes()];
        sim.save(&mut image).unwrap();
        // Into a fresh one, which has not been prepared.
        let mut other_memory = self.dirty(0);
        let mut other = other_memory.sim(&(self.scene)());
        other.load(&image).unwrap();
        self.finish(&mut other);
        other.digest()
    }

    fn in_dirty_memory(&self) -> u64 {
        self.digest_in(&mut self.dirty(0).lines)
    }

    fn in_longer_memory(&self) -> u64 {
        self.digest_in(&mut self.dirty(1000).lines)
    }

    /// The bits of the draws in another order, and of the run after it.
    fn drawn_in_another_order(&self) -> u64 {
        let scene = (self.scene)();
        let count = scene.segments();
        let draw = |number| scene.draw_segment(number).unwrap();
        let in_order: Vec<_> = (0..count).map(draw).collect();
        // A stride without a common factor with the count goes through all numbers.
        let stride = (count / 3..).find(|&stride| stride % 2 == 1 && common(stride, count) == 1).unwrap();
        for k in 0..count {
            let number = k * stride % count;
            assert_eq!(draw(number), in_order[number as usize], "segment {number}");
        }
        self.digest_in(&mut Buffers::of(&scene).lines)
    }

    /// In turns with another golden scene, a few steps each.
    fn interleaved(&self, other: &Golden) -> u64 {
        let (mut memory, mut other_memory) = (Buffers::of(&(self.scene)()), Buffers::of(&(other.scene)()));
        let (mut sim, mut second) = (self.start(&mut memory.lines), other.start(&mut other_memory.lines));
        while sim.step_count() < self.steps {
            let until = self.steps.min(sim.step_count() + 7);
            self.run(&mut sim, until, |sim, steps| sim.advance(steps).unwrap());
            let until = other.steps.min(second.step_count() + 1);
            other.run(&mut second, until, |sim, steps| sim.advance(steps).unwrap());
        }
        sim.digest()
    }

    fn in_bands(&self, of: u32) -> u64 {
        self.special(|sim| {
            self.run(sim, self.steps, |sim, steps| {
                let mut scratch = vec![CacheLine([f64::NAN; 8]); sim.layout().band_lines(of).unwrap()];
                let bands = sim.bands(&mut scratch, of, 0).unwrap();
                while bands.steps() < steps {
                    (0..of).rev().for_each(|band| _ = bands.pass(band).unwrap());
                }
            });
        })
    }
}

/// Greatest common factor.
fn common(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common(b, a % b) }
}

#[test]
fn golden_scenes_are_invariant() {
    let all = golden_scenes();
    let of_scene = |(k, golden): (usize, &Golden)| {
        let mut memory = Buffers::of(&(golden.scene)());
        let mut sim = golden.start(&mut memory.lines);
        golden.finish(&mut sim);
        let (expected, failed) = (sim.digest(), sim.counters().failed_segments > 0);
        let ways = [
            ("rows at rest stepped", golden.rows_at_rest_stepped()),
            ("many calls", golden.in_many_calls()),
            ("saved and loaded", golden.saved_and_loaded()),
            ("dirty memory", golden.in_dirty_memory()),
            ("longer memory", golden.in_longer_memory()),
            ("drawn in another order", golden.drawn_in_another_order()),
            ("interleaved", golden.interleaved(&all[(k + 3) % all.len()])),
        ];
        let cut = (golden.scene)().integrator == Integrator::VERLET;
        let bands = [1, 2, 3, 5].into_iter().filter(|_| cut).map(|of| ("bands", golden.in_bands(of)));
        let alike = |ways: Vec<(&'static str, u64)>| {
            let other: Vec<_> = ways.iter().filter(|(_, digest)| *digest != expected).map(|(way, _)| *way).collect();
            (ways.len(), other)
        };
        (golden.name, failed, alike(ways.to_vec()), alike(bands.collect()))
    };
    let results: Vec<_> = all.par_iter().enumerate().map(of_scene).collect();
    let count = |of: fn(&(usize, Vec<&'static str>)) -> usize| {
        [
            results.iter().map(|(_, _, ways, _)| of(ways)).sum::<usize>(),
            results.iter().map(|(_, _, _, bands)| of(bands)).sum(),
        ]
    };
    let (tried, other) = (count(|(tried, _)| *tried), count(|(_, other)| other.len()));
    println!(
        "figure 7: {} scenes, {} past first failure, {} of {} invariances; {} of {} in bands of 1, 2, 3, 5",
        all.len(),
        results.iter().filter(|(_, failed, _, _)| *failed).count(),
        tried[0] - other[0],
        tried[0],
        tried[1] - other[1],
        tried[1]
    );
    assert_eq!(other, [0, 0], "{results:?}");
    assert_eq!(tried[0], 7 * all.len());
}
