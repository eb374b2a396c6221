"""What a host watches while it runs."""

from host import FOUR_SIDES, RADIUS, SMALL, Host


def test_they_tell_sound_from_unsound():
    sound = {**SMALL, "yarn.stochastic": False}
    for version in (2, 3):
        host = Host(version, {**sound, "time_step.seconds": 2e-8}).run(0, 60, 1e-6)
        impact = 0.5 * host.get("projectile.mass") * 100.0**2
        assert abs(host.get("step.fraction") - 2e-8 / 5.289994e-8) < 5e-7
        assert host.get("step.seconds") == 2e-8
        follows = Host(version, {**sound, "time_step.seconds": 0.0, "time_step.fraction": 0.25})
        assert abs(follows.get("step.seconds") / (0.25 * 5.289994e-8) - 1.0) < 5e-7
        assert abs(host.get("energy.residual")) < 0.01 * impact
        assert host.get("momentum.residual") < 1e-12 * host.get("projectile.mass") * 100.0
        assert host.get("contact.unconverged") == 0
        assert host.get("fabric.worst_penetration") < 1e-12 * RADIUS
        assert host.get("fabric.max_stretch") > 1.01
        assert host.get("fabric.max_stretch") < 1.05
        finer = Host(version, {**sound, "time_step.seconds": 1e-8}).run(0, 60, 1e-6)
        assert abs(finer.get("energy.residual")) < 0.5 * abs(host.get("energy.residual"))
        # A slab over the whole sheet: only rounding is left of many solves, which is no lack of convergence.
        slab = {
            **sound,
            "attachment.kind": FOUR_SIDES,
            "projectile.shape": 3,
            "projectile.mass": 0.05,
            "projectile.size": [0.04, 0.04, 0.004],
            "projectile.start.position[3]": -0.002,
            "projectile.start.velocity[3]": 50.0,
        }
        host = Host(version, slab).run(0, 1, 1e-4)
        assert host.get("contact.unconverged") == 0
        # A sphere that wedges between supports: a solve ends at the cap, and the host sees it.
        wedged = {**sound, "sheet.nodes_x": 15, "sheet.nodes_y": 15, "projectile.start.velocity[3]": 60.0}
        host = Host(version, wedged).run(0, 60, 1e-6)
        assert host.get("contact.unconverged") > 0
