"""What other tools do that FMPy's low-level classes do not: signals that start at zero, ports that stay unconnected, all start
values written back, steps shorter than an internal step, warnings as failures, enumerations passed over."""

import unittest

from host import OK, PRESCRIBED, RADIUS, SMALL, Host, hosts

H = 1e-6
MOTION = [f"projectile.{name}" for name in ("position", "velocity", "orientation", "angular_velocity")]
DRIVEN = {**SMALL, "drive": PRESCRIBED, "projectile.start.velocity[3]": 60.0, "projectile.start.angular_velocity[3]": 200.0}


class Steps(unittest.TestCase):
    """A host in which anything but OK stops the simulation."""

    def step(self, host, t, h):
        self.assertEqual(host.status_of_step(t, h), OK, host.log)

    def test_all_start_values_written_back_give_the_same_bits(self):
        for version in (2, 3):
            plain, writes = Host(version), Host(version)
            texts = {v.name: v.start for v in writes.variables.values() if v.causality in ("parameter", "input")}
            self.assertEqual({name for name, start in texts.items() if start is None}, set())
            read = {"Real": float, "Float64": float, "Boolean": lambda text: text == "true"}
            values = {
                name: [read.get(writes.variables[name].type, int)(word) for word in start.split()]
                for name, start in texts.items()
            }
            small = {"sheet.nodes_x": 41, "sheet.nodes_y": 41}
            self.assertEqual(plain.initialise(small), OK)
            self.assertEqual(writes.initialise({**values, **small}), OK, writes.log)
            self.assertEqual(writes.run(0, 40, H).image(), plain.run(0, 40, H).image())
            self.assertGreater(plain.get("contact.work"), 0.1)

    def test_signals_at_zero_in_the_first_step(self):
        """A master that starts all signals at zero, then drives: no step is refused, and the run is that of a host which drives
        at once."""
        ends = []
        for late in (False, True):
            host, x = Host(2, DRIVEN), [0.0, 0.0, -RADIUS - 1e-5]
            for k in range(20):
                motion = [x, [0.0, 0.0, 60.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 200.0]]
                for name, value in zip(MOTION, motion):
                    host.try_set(name, [0.0] * len(value) if late and k == 0 else value)
                self.step(host, k * H, H)
                self.assertLess(host.get("interface.gap"), 1e-7)
                x = [0.0, 0.0, x[2] + 60.0 * H]
            ends.append((host.get("contact.work"), host.get("contact.impulse[3]")))
        for a, b in zip(*ends):
            self.assertAlmostEqual(a / b, 1.0, 9)

    def test_what_is_not_connected_flies_on(self):
        """Nothing connected at all: the body flies from its start under the mean force of the last step, and turns on."""
        free = Host(2, {**DRIVEN, "drive": 0}).run(0, 20, H)
        for host in hosts(DRIVEN):
            for k in range(20):
                self.step(host, k * H, H)
            self.assertAlmostEqual(host.get("contact.work") / free.get("contact.work"), 1.0, 1)
            self.assertAlmostEqual(host.get("state.velocity")[2] / free.get("state.velocity")[2], 1.0, 3)
            self.assertAlmostEqual(host.get("state.angular_velocity")[2], 200.0, 6)
            self.assertAlmostEqual(host.get("state.orientation")[3], 0.5 * 200.0 * 20 * H, 6)

    def test_an_unconnected_orientation_beside_a_driven_position(self):
        host = Host(2, DRIVEN)
        for k in range(10):
            host.set(projectile__position=[0.0, 0.0, -RADIUS - 1e-5 + 60.0 * k * H], projectile__velocity=[0.0, 0.0, 60.0])
            self.step(host, k * H, H)
        self.assertAlmostEqual(host.get("state.angular_velocity")[2], 200.0, 6)
        self.assertAlmostEqual(host.get("state.orientation")[3], 0.5 * 200.0 * 10 * H, 6)

    def test_zero_is_a_place_like_any_other_once_the_host_drives(self):
        host = Host(2, DRIVEN)
        host.set(projectile__position=[0.0, 0.0, -RADIUS - 1e-5], projectile__velocity=[0.0, 0.0, 60.0])
        self.step(host, 0.0, H)
        host.set(projectile__position=[0.0] * 3, projectile__velocity=[0.0] * 3)
        self.assertNotEqual(host.status_of_step(H, H), OK)
        self.assertTrue(host.said("from where the fabric has the body"))

    def test_a_remainder_of_a_step_leaves_the_outputs_as_they_are(self):
        """As left over by rounding at the end of a run, and steps much shorter than an internal one."""
        for version in (2, 3):
            for drive in (0, PRESCRIBED):
                host = Host(version, {**DRIVEN, "drive": drive})
                for k in range(10):
                    self.step(host, k * H, H)
                before = host.outputs()
                self.assertNotEqual(before["contact.force_mean"][2], 0.0)
                self.step(host, 10 * H, 7e-20)
                self.assertEqual(host.outputs(), before)
                self.step(host, 10 * H, 1e-9)
                self.assertEqual(host.outputs(), before)

    def test_masters_that_round_their_steps_differently_read_the_same_means(self):
        """A mean is over the internal steps, not over the host's idea of a step."""
        for drive in (0, PRESCRIBED):
            means = []
            for step in (
                lambda k: (k * H, H),
                lambda k: (k * H, (k + 1) * H - k * H),
                lambda k: (k * 1e-6 * (1 + 1e-13), 1.0000001e-6),
            ):
                host = Host(3, {**DRIVEN, "drive": drive})
                for k in range(10):
                    self.step(host, *step(k))
                means.append((host.get("contact.force_mean"), host.get("contact.torque_mean")))
            if drive == 0:
                self.assertEqual(means[1], means[0])
                self.assertEqual(means[2], means[0])
            self.assertNotEqual(means[0][0][2], 0.0)
