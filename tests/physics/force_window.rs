//! The peak force: the largest mean over windows of `force_window`, and before the first is full the mean
//! over the time elapsed.

use fabric_kernel::{Scene, Sim};
use fabric_tests::{close, sim_of, small_sheet};

/// A sheet of 21 x 21 hit at 100 m/s, with so long a window, in steps.
fn scene(steps: u64) -> Scene {
    let mut scene = small_sheet(21, 100.0);
    scene.force_window = steps as f64 * scene.step_limits().unwrap().dt;
    scene
}

/// Length of the impulse on the projectile so far, N s.
fn impulse(sim: &Sim<'_>) -> f64 {
    let [x, y, z] = sim.contact().unwrap().impulse;
    x.hypot(y).hypot(z)
}

/// A window longer than the run: the read-out is the mean force so far, not zero without a word.
#[test]
fn a_run_shorter_than_the_window_has_its_mean_force() {
    for window in [1_000_000, 300] {
        let scene = scene(window);
        let mut sim = sim_of(&scene);
        assert_eq!(sim.contact().unwrap().force_peak, 0.0, "no time has elapsed");
        for _ in 0..300 {
            sim.step().unwrap();
            close(sim.contact().unwrap().force_peak, impulse(&sim) / sim.time(), 1e-12);
        }
        assert!(sim.contact().unwrap().force_peak > 10.0);
    }
}

/// From the first full window on it is the largest of the windows' means; reading it earlier has changed no
/// bit.
#[test]
fn after_the_first_window_the_largest_of_their_means_counts() {
    let scene = scene(50);
    let (mut sim, mut unread) = (sim_of(&scene), sim_of(&scene));
    let (mut peak, mut before, mut means) = (0.0_f64, [0.0; 3], Vec::new());
    for step in 1..=2000 {
        sim.step().unwrap();
        let contact = sim.contact().unwrap();
        if step % 50 == 0 {
            let [x, y, z] = [0, 1, 2].map(|k| contact.impulse[k] - before[k]);
            let mean = x.hypot(y).hypot(z) / scene.force_window;
            (peak, before) = (peak.max(mean), contact.impulse);
            means.push(mean);
        }
        if step >= 50 {
            assert!((contact.force_peak - peak).abs() < 1e-9 * peak, "{step}");
        }
    }
    assert!(means[0] < 0.9 * peak && *means.last().unwrap() < peak);
    unread.advance(2000).unwrap();
    assert_eq!(sim.digest(), unread.digest());
    assert_eq!(sim.contact().unwrap(), unread.contact().unwrap());
}
