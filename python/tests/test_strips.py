"""How reports/strips.py pulls strips, where the answer is known."""

import importlib.util
import math
import pathlib
import sys
import unittest

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).parents[2]))
from reports import strips  # noqa: E402

BUILT = importlib.util.find_spec("fabric_kernel._kernel") is not None


@unittest.skipUnless(BUILT, "the kernel is not built")
class Strips(unittest.TestCase):
    def test_alike_yarns_bear_the_law_up_to_their_strength(self):
        pull = strips.Pull(strips.strip(0.008, 0.03, **{"yarn.strength_draw": "none"}))
        scene = pull.scene
        critical, crimp = scene["yarn.critical_stretch"], scene["sheet.crimp"][0]
        self.assertLess(numpy.abs(pull.critical - critical).max(), 1e-12)
        nominal = lambda stretch: 0.5 * scene["yarn.modulus_mean"] * stretch * (stretch**2 - 1)
        load, rests = pull.to(1.01 * (1 + crimp) - 1)
        stress = load / (scene["sheet.yarn_area"] * scene["sheet.nodes_y"])
        self.assertTrue(rests)
        self.assertAlmostEqual(stress / nominal(1.01), 1.0, delta=1e-9)
        strength, restless = pull.strength()
        self.assertEqual(restless, 0)
        self.assertAlmostEqual(strength / nominal(critical), 1.0, delta=0.002)

    def test_a_strip_breaks_from_its_weakest_segment_on(self):
        pull = strips.Pull(strips.strip(0.008, 0.03, seed=5))
        along = (pull.scene["sheet.nodes_x"] - 1) * pull.scene["sheet.nodes_y"]
        weakest = int(pull.critical[:along].argmin())
        crimp = pull.scene["sheet.crimp"][0]
        for part, breaks in [(1 - 1e-5, False), (1.002, True)]:
            pull.to(pull.critical[weakest] * part * (1 + crimp) - 1)
            self.assertEqual((pull.stretches == 2.0).any(), breaks)
            self.assertEqual(pull.stretches[weakest] == 2.0, breaks)

    def test_a_yarn_among_rigid_ones(self):
        # w'' = w^3 with w' = -strain at the cut; the load is 1 + w'/strain.
        s = numpy.linspace(0, 40, 4001)
        slope = strips.STRAIN * (strips.rigid(s) - 1)
        far = -math.sqrt(math.sqrt(2) * -slope[-1])
        w = -far + numpy.cumsum(-0.5 * (slope[1:] + slope[:-1])[::-1])[::-1] * (s[1] - s[0])
        second = numpy.diff(slope)[1:] / (s[1] - s[0])
        self.assertAlmostEqual(slope[0], -strips.STRAIN)
        self.assertLess(numpy.abs(second - w[:-1] ** 3).max(), 1e-3 * second.max() + 1e-5)

    def test_a_longer_gauge_makes_weaker_flaws(self):
        # Small strains: stress goes with (L/h)^(1/m).
        self.assertAlmostEqual(strips.longer(0.05, 10.0, 1e15, 1e6, 1.1e6) / (0.05 * 1.1**10), 1.0, delta=1e-6)


if __name__ == "__main__":
    unittest.main()
