"""The examples of examples/coupling, and what drive prescribed owes its host."""

import math
import unittest

from host import ARCHIVES, OK, PRESCRIBED, RADIUS, SPHERE, Host

ARCHIVE = ARCHIVES[2]
import rollback  # noqa: E402
import two_shields  # noqa: E402
from driven_shield import Shield  # noqa: E402
from sphere import MASS, Body  # noqa: E402


class Rollback(unittest.TestCase):
    def test_a_repeated_pass_with_the_same_guess_changes_nothing(self):
        def twice(shield, body, t, h, memory):
            memory["state"] = shield.save(memory.get("state"))
            first = shield.step(t, h, body)
            shield.restore(memory["state"])
            again = shield.step(t, h, body)
            self.assertEqual(again, first)
            body.pushed(again, h, memory["dt"])

        self.assertEqual(rollback.run(ARCHIVE, 5e-6, twice, 1e-4), rollback.run(ARCHIVE, 5e-6, rollback.sequential, 1e-4))


class TwoShields(unittest.TestCase):
    def test_the_balances_close_over_both(self):
        balances = two_shields.fly(ARCHIVE)
        self.assertEqual(balances["outcome.exited"], [True, True])
        self.assertLess(balances["outcome.exited_time"][0], balances["outcome.first_contact_time"][1])
        self.assertGreater(min(balances["contact.work"]), 10.0)
        self.assertLess(abs(balances["interface residual"]), 1e-5)
        self.assertLess(balances["momentum residual"], 1e-12)
        # The tilted sheet pushes the fragment along its normal, which turning about x has given a part along y.
        self.assertGreater(abs(balances["contact.impulse"][1][1]), 0.1 * abs(balances["contact.impulse"][1][2]))

    def test_a_shield_out_of_reach_changes_no_bit(self):
        alone = two_shields.fly(ARCHIVE, two_shields.SHEETS[:1], end=3e-5)
        beside = two_shields.fly(ARCHIVE, end=3e-5)
        self.assertEqual([alone["velocity"], alone["lost"]], [beside["velocity"], beside["lost"]])
        self.assertEqual(beside["contact.work"][1], 0.0)

    def test_a_moved_and_tilted_sheet_gives_the_same_impact(self):
        """Turned by 90 degrees about x and moved: the same impact along another axis, until rounding is amplified."""
        half, place = math.sqrt(0.5), [0.1, -0.2, 0.3]
        plain = two_shields.fly(ARCHIVE, [{}], end=2e-5)
        body = Body([place[0], place[1] + RADIUS + 1e-4, place[2]], [0.0, -two_shields.SPEED, 0.0])
        shield = Shield(
            ARCHIVE,
            {
                **SPHERE,
                "drive": PRESCRIBED,
                "projectile.mass": 0.0,
                "projectile.start.position": body.position,
                "projectile.start.velocity": body.velocity,
                "sheet.position": place,
                "sheet.orientation": [half, half, 0.0, 0.0],
            },
        )
        force, dt = [0.0] * 3, shield.get("time_step.seconds")
        for k in range(40):
            force = shield.step(k * two_shields.H, two_shields.H, body, [f / MASS for f in force])
            body.pushed(force, two_shields.H, dt)
        self.assertAlmostEqual(-body.velocity[1] / plain["velocity"][2], 1.0, 9)
        self.assertAlmostEqual(shield.get("contact.work") / plain["contact.work"][0], 1.0, 7)
        shield.close()


class Interface(unittest.TestCase):
    """40 J through the 3 in sheet."""

    def test_energy_until_exit(self):
        """The fabric's own balance within 1 % of the impact energy, and the host's loss against the work of contact."""
        values = {**SPHERE, "projectile.start.position[3]": rollback.START[2], "projectile.start.velocity[3]": rollback.SPEED}
        host, worst = Host(2, values), 0.0
        for k in range(60):
            host.run(k, k + 1, 5e-6)
            worst = max(worst, abs(host.get("energy.residual")))
            if host.get("outcome.exited"):
                break
        self.assertTrue(host.get("outcome.exited"))
        lost = 40.0 - 0.5 * MASS * sum(v * v for v in host.get("state.velocity"))
        print(
            f"\n  energy.residual at most {worst:.1e} J, loss {lost:.4f} J, contact work {host.get('contact.work'):.4f} J",
            end=" ",
        )
        self.assertLess(worst, 0.01 * 40.0)
        self.assertLess(abs(lost - host.get("contact.work")), 1e-9 * 40.0)

    def test_force_peak_and_cumulative_sums(self):
        """force_peak as in the free run; impulse and work are the sums of what the steps gave."""
        values = {**SPHERE, "projectile.start.position[3]": rollback.START[2], "projectile.start.velocity[3]": rollback.SPEED}
        free = Host(2, values).run(0, 50, 1e-6)
        expected = free.get("contact.force_peak")
        host, body, dt = Host(2, {**values, "drive": PRESCRIBED}), Body(rollback.START, [0.0, 0.0, rollback.SPEED]), 2e-8
        impulse = [0.0] * 3
        for k in range(50):
            host.set(projectile__position=body.position, projectile__velocity=body.velocity)
            self.assertEqual(host.step(k * 1e-6, 1e-6), OK)
            force = host.get("contact.force_mean")
            impulse = [a + f * 1e-6 for a, f in zip(impulse, force)]
            body.pushed(force, 1e-6, dt)
        for a, b in zip(impulse, host.get("contact.impulse")):
            self.assertLess(abs(a - b), 1e-12 * abs(impulse[2]))
        self.assertAlmostEqual(body.velocity[2] - rollback.SPEED, host.get("contact.impulse")[2] / MASS, 10)
        peak = host.get("contact.force_peak")
        print(f"\n  force_peak {peak:.0f} N, free {expected:.0f} N", end=" ")
        self.assertLess(max(peak / expected, expected / peak), 1.2)
