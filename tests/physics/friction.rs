//! Friction.
use fabric_tests::{Buffers, small_sheet};

#[test]
fn trial() {
    for mu in [0.0, 0.1, 0.3, 1.0, 10.0] {
        let mut scene = small_sheet(41, 120.0);
        scene.yarn.stochastic = true;
        scene.contact.friction = mu;
        scene.projectile.velocity = [30.0, 10.0, 120.0];
        let mut buffers = Buffers::of(&scene);
        let mut sim = buffers.sim(&scene);
        let first = sim.energy().unwrap().projectile_kinetic;
        for n in 0..4 {
            sim.advance(500).unwrap();
            let e = sim.energy().unwrap();
            let c = sim.counters();
            println!(
                "{mu} {n} work {:.4} friction {:.5} loss {:.5} residual {:.2e} mom {:?} sweeps {} unconv {} w {:?} failed {}",
                e.contact_work,
                e.friction,
                e.contact_loss,
                e.residual / first,
                sim.momentum_residual().unwrap(),
                c.most_sweeps,
                c.unconverged,
                sim.projectile().unwrap().angular_velocity,
                c.failed_segments
            );
        }
    }
}
