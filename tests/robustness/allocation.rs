//! The kernel takes no memory of its own: an allocator that counts sees nothing between set-up and the last
//! image.

use fabric_kernel::{CacheLine, Layout, Outcome, Scene, Sim};
use fabric_tests::{drawn, memory_of, small_sheet, tilted_cylinder};
use std::alloc::{GlobalAlloc, Layout as Block, System};
use std::cell::Cell;

/// The system's allocator, counting the requests of each thread.
struct Counting;

thread_local! {
    static REQUESTS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // A thread that ends may ask after its counter is gone.
    let _ = REQUESTS.try_with(|requests| requests.set(requests.get() + 1));
}

// SAFETY: every request is handed on to the system's allocator as it came.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, block: Block) -> *mut u8 {
        count();
        // SAFETY: as the caller promised.
        unsafe { System.alloc(block) }
    }

    unsafe fn dealloc(&self, at: *mut u8, block: Block) {
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(at, block) }
    }

    unsafe fn realloc(&self, at: *mut u8, block: Block, size: usize) -> *mut u8 {
        count();
        // SAFETY: as the caller promised.
        unsafe { System.realloc(at, block, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Requests of this thread while something runs.
fn requests(work: impl FnOnce()) -> u64 {
    let before = REQUESTS.with(Cell::get);
    work();
    REQUESTS.with(Cell::get) - before
}

/// Everything a host does in the life of a simulation.
fn whole_life(scene: &Scene, memory: &mut [CacheLine], image: &mut [u8], numbers: &mut [f64]) {
    scene.check().unwrap();
    let layout = Layout::of(scene).unwrap();
    let mut sim = Sim::new(scene, memory).unwrap();
    sim.advance(200).unwrap();
    sim.save(image).unwrap();
    sim.advance_until(Outcome::Exited, 600).unwrap();
    sim.load(image).unwrap();
    sim.advance(100).unwrap();
    sim.energy().unwrap();
    sim.fabric().unwrap();
    sim.contact().unwrap();
    sim.support().unwrap();
    sim.momentum_residual().unwrap();
    sim.copy_positions(&mut numbers[..3 * layout.nodes()]).unwrap();
    sim.copy_velocities(&mut numbers[..3 * layout.nodes()]).unwrap();
    sim.copy_damage(&mut numbers[..layout.segments()]).unwrap();
    let _ = sim.digest();
    sim.set_external_load([1.0, 0.0, 0.0], [0.0; 3]).unwrap();
    sim.step().unwrap();
    sim.reset();
    sim.step().unwrap();
}

#[test]
fn nothing_is_allocated() {
    assert!(requests(|| drop(std::hint::black_box(vec![0; 9]))) > 0, "the allocator counts");
    let implicit = Scene { integrator: fabric_kernel::Integrator::THETA, ..small_sheet(19, 100.0) };
    let scenes = [drawn(small_sheet(19, 200.0)), implicit, tilted_cylinder(21, 0.4, 100.0)];
    let mut total = 0;
    for scene in &scenes {
        let mut memory = memory_of(scene);
        let layout = Layout::of(scene).unwrap();
        let (mut image, mut numbers) = (vec![0; layout.snapshot_bytes()], vec![0.0; 3 * layout.nodes()]);
        total += requests(|| whole_life(scene, &mut memory, &mut image, &mut numbers));
        // A refusal makes a text, on the stack.
        let mut refused = *scene;
        refused.projectile.mass = f64::NAN;
        total += requests(|| assert!(refused.check().is_err_and(|error| error.text().contains("mass"))));
    }
    println!("figure 3: {total} in whole lives of {} simulations and in refusals", scenes.len());
    assert_eq!(total, 0);
}
