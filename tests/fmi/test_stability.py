"""The rows of `fabric stability` but for motion given by hand: the kernel's bits, or its failure in the same words.

The cases come from `fabric stability --fmu-cases FILE` (FILE: target/fmu/stability.json; `cargo xtask test` writes it).
"""

import json
import unittest

from host import ERROR, TARGET, WARNING, Host

FILE = TARGET / "fmu" / "stability.json"


def number(value):
    """JSON has no NaN and no infinity: those are texts."""
    if isinstance(value, list):
        return [number(x) for x in value]
    return float(value) if isinstance(value, str) else value


class Stability(unittest.TestCase):
    def test_every_row_ends_as_in_the_kernel(self):
        cases = json.loads(FILE.read_text())
        self.assertGreater(len(cases), 50)
        for name, case in cases.items():
            for version in (2, 3):
                with self.subTest(version=version, case=name):
                    host = Host(version)
                    getattr(self, case["expected"])(host, case)
                    host.close()

    def start(self, host, case):
        status = host.initialise({name: number(value) for name, value in case["values"].items()})
        if status <= WARNING and any(case["force"]):
            host.set(external__force=case["force"])
        return status

    def failed(self, host, case):
        self.assertLessEqual(self.start(host, case), WARNING, host.log)
        self.assertEqual(host.step(0.0, case["h"]), ERROR)
        self.assertTrue(host.said(case["text"]), host.log)
        self.assertEqual(host.get("status"), 2)

    def runs(self, host, case):
        self.assertLessEqual(self.start(host, case), WARNING, host.log)
        self.assertLessEqual(host.step(0.0, case["h"]), WARNING, host.log)
        self.assertEqual({name: host.get(name) for name in case["outputs"]}, case["outputs"])


class Indicators(unittest.TestCase):
    """What a host watches while it runs."""

    def test_they_tell_sound_from_unsound(self):
        from host import FOUR_SIDES, RADIUS, SMALL

        sound = {**SMALL, "yarn.stochastic": False}
        for version in (2, 3):
            host = Host(version, {**sound, "time_step.seconds": 2e-8}).run(0, 60, 1e-6)
            impact = 0.5 * host.get("projectile.mass") * 100.0**2
            self.assertAlmostEqual(host.get("step.fraction"), 2e-8 / 5.289994e-8, 6)
            self.assertLess(abs(host.get("energy.residual")), 0.01 * impact)
            self.assertLess(host.get("momentum.residual"), 1e-12 * host.get("projectile.mass") * 100.0)
            self.assertEqual(host.get("contact.unconverged"), 0)
            self.assertLess(host.get("fabric.worst_penetration"), 1e-12 * RADIUS)
            self.assertGreater(host.get("fabric.max_stretch"), 1.01)
            self.assertLess(host.get("fabric.max_stretch"), 1.05)
            finer = Host(version, {**sound, "time_step.seconds": 1e-8}).run(0, 60, 1e-6)
            self.assertLess(abs(finer.get("energy.residual")), 0.5 * abs(host.get("energy.residual")))
            host.close(), finer.close()
            # A slab over the whole sheet: only rounding is left of many solves, which is no lack of convergence.
            slab = {
                **sound, "attachment.kind": FOUR_SIDES, "projectile.shape": 3, "projectile.mass": 0.05,
                "projectile.size": [0.04, 0.04, 0.004], "projectile.start.position[3]": -0.002,
                "projectile.start.velocity[3]": 50.0,
            }  # fmt: skip
            host = Host(version, slab).run(0, 1, 1e-4)
            self.assertEqual(host.get("contact.unconverged"), 0)
            host.close()
            # A sphere that wedges between supports: a solve ends at the cap, and the host sees it.
            wedged = {**sound, "sheet.nodes_x": 15, "sheet.nodes_y": 15, "projectile.start.velocity[3]": 60.0}
            host = Host(version, wedged).run(0, 60, 1e-6)
            self.assertGreater(host.get("contact.unconverged"), 0)
            host.close()


if __name__ == "__main__":
    unittest.main()
