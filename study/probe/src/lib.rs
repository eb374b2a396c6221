//! Small libraries around the kernel, for `fabric-study lean`: without features the smallest useful one (sphere, uniform yarn,
//! explicit steps), with features what else a library may use. The linker keeps what is called, and only that is measured.
#![no_std]
#![allow(unsafe_code)] // Only the exported names.

use fabric::{Error, Layout, Memory, Scene, Sim};

#[cfg(not(feature = "bare"))]
extern crate std;

#[cfg(feature = "bare")]
mod bare {
    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        loop {
            core::hint::spin_loop();
        }
    }

    // The precompiled core library names this symbol. Hidden and never called.
    #[cfg(target_os = "linux")]
    core::arch::global_asm!(".weak rust_eh_personality", ".hidden rust_eh_personality", "rust_eh_personality:");
}

/// Places for a sheet of 21 x 21 nodes.
const REALS: usize = 16_384;
const WORDS: usize = 4_096;

fn scene(nodes: u32, speed: f64) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nodes, nodes);
    scene.yarn.stochastic = false;
    (scene.track_support, scene.track_detachment) = (false, false);
    scene.projectile.velocity = [0.0, 0.0, speed];
    scene
}

/// Runs a scene on the stack and reads something off it; NaN if it is refused.
fn run(scene: &Scene, steps: u64, read: impl FnOnce(&mut Sim<'_>) -> Result<f64, Error>) -> f64 {
    let (mut reals, mut words) = ([0.0; REALS], [0; WORDS]);
    let fits = |layout: &Layout| layout.reals() <= REALS && layout.words() <= WORDS;
    if !Layout::of(scene).is_ok_and(|layout| fits(&layout)) {
        return f64::NAN;
    }
    let result = Sim::new(scene, Memory { reals: &mut reals, words: &mut words }).and_then(|mut sim| {
        sim.advance(steps)?;
        read(&mut sim)
    });
    result.unwrap_or(f64::NAN)
}

/// Residual velocity of the sphere.
#[unsafe(no_mangle)]
pub extern "C" fn probe_smallest(nodes: u32, speed: f64, steps: u64) -> f64 {
    run(&scene(nodes, speed), steps, |sim| Ok(sim.projectile()?.velocity[2]))
}

/// What the balances of energy and momentum do not close by.
#[cfg(feature = "energies")]
#[unsafe(no_mangle)]
pub extern "C" fn probe_energies(nodes: u32, speed: f64, steps: u64) -> f64 {
    run(&scene(nodes, speed), steps, |sim| Ok(sim.energy()?.residual + sim.momentum_residual()?[2]))
}

/// Saves, steps on, puts back.
#[cfg(feature = "snapshots")]
#[unsafe(no_mangle)]
pub extern "C" fn probe_snapshots(nodes: u32, speed: f64, steps: u64) -> f64 {
    let mut image = [0; 65_536];
    run(&scene(nodes, speed), steps, |sim| {
        let bytes = sim.snapshot_bytes();
        sim.save(&mut image)?;
        sim.advance(steps)?;
        sim.load(image.get(..bytes).unwrap_or(&[]))?;
        Ok(sim.projectile()?.velocity[2])
    })
}

/// The sphere moved by its host.
#[cfg(feature = "host")]
#[unsafe(no_mangle)]
pub extern "C" fn probe_host(nodes: u32, speed: f64, steps: u64) -> f64 {
    let mut scene = scene(nodes, speed);
    scene.drive = fabric::Drive::Prescribed;
    run(&scene, 0, |sim| {
        let mut end = sim.projectile()?;
        end.position[2] += speed * steps as f64 * sim.step_limits().dt;
        sim.follow(&fabric::Path { first: 0, steps, end }, steps)?;
        Ok(sim.contact()?.work)
    })
}

/// The same by the theta rule.
#[cfg(feature = "implicit")]
#[unsafe(no_mangle)]
pub extern "C" fn probe_implicit(nodes: u32, speed: f64, steps: u64) -> f64 {
    let mut scene = scene(nodes, speed);
    scene.integrator = fabric::Integrator::Theta(fabric::ThetaRule::default());
    run(&scene, steps, |sim| Ok(sim.projectile()?.velocity[2]))
}

/// A yarn from its fibrils, and its fitted law.
#[cfg(feature = "micro")]
#[unsafe(no_mangle)]
pub extern "C" fn probe_micro(seed: u64, number: u64) -> f64 {
    use fabric::calibrate::{Fit, fit};
    use fabric::fibril::{Bundle, BundleYarn};
    let mut memory = [0.0; 4_096];
    let bundle = Bundle::zylon();
    BundleYarn::draw(&bundle, seed, number, &mut memory)
        .map_or(f64::NAN, |yarn| fit(&yarn, 1.03, Fit::Rate).damage_rate)
}
