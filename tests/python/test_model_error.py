"""The error of the model against tests: coverage with invented data, what counts as compared, and where the numbers come from."""

import math
import pathlib
import unittest
from unittest import mock

import numpy
import scipy.stats
from fabric_kernel import Scene, vary
from fabric_kernel.designs import Plan
from fabric_kernel.ensembles import within_mesh
from fabric_kernel.model_error import compared, factor, left_out, model_error
from fabric_kernel.residual import residual_curve
from fabric_kernel.textile import areal_density, axes, cunniff_velocity, presented_area
from fabric_kernel.v50 import Shooter, v50

TOP = pathlib.Path(__file__).parents[2]
SETS = 2000


def held(series, members, alike, mean, seed):
    """How many of SETS invented data sets give a factor that holds a new comparison. alike: the part of the variance that the
    members of a series share; the new comparison is one of a new series."""
    random = numpy.random.default_rng(seed)
    count = 0
    for _ in range(SETS):
        shared = random.standard_normal(series + 1)[:, None] * math.sqrt(alike)
        errors = 0.1 * (mean + shared + random.standard_normal((series + 1, members)) * math.sqrt(1.0 - alike))
        count += abs(errors[-1, 0]) <= math.log(factor(list(errors[:-1])))
    return count


class ModelError(unittest.TestCase):
    def test_coverage_is_exact_where_series_are_one_number(self):
        low, high = scipy.stats.binom.interval(0.999, SETS, 0.95)
        for series in (1, 2, 5):
            count = held(series, 5, 1.0, 0.0, series)
            self.assertTrue(low <= count <= high, (series, count))

    def test_coverage_is_never_below(self):
        least = scipy.stats.binom.interval(0.999, SETS, 0.95)[0]
        for series in (1, 3):
            for alike in (0.0, 0.5, 1.0):
                for mean in (0.0, 0.5, 1.0, 3.0):
                    count = held(series, 5, alike, mean, 100 * series + round(10 * (alike + mean)))
                    self.assertGreaterEqual(count, least, (series, alike, mean))

    def test_more_cases_of_one_series_do_not_narrow_the_band(self):
        self.assertAlmostEqual(factor([[0.1, -0.1]]), factor([[0.1, -0.1] * 50]), places=12)
        self.assertAlmostEqual(math.log(factor([[0.1]])), 12.706 * 0.1, places=3)
        self.assertLess(factor([[0.1], [0.1]]), factor([[0.1]]))
        self.assertEqual(factor([]), math.inf)

    def test_the_numbers_are_those_of_the_tables(self):
        tables = [(TOP / f"docs/tables/{name}.md").read_text().splitlines() for name in ("validation", "strips")]
        packs, strips = compared("limit"), compared("strength")
        self.assertEqual([len(packs), len(strips)], [1, 1])
        for case in packs[0].cases:
            density = next(one["areal_density_kg_per_m2"] for one in packs[0].about["case"] if one["name"] == case.name)
            plies = case.name.split()[0]
            rows = [line for line in tables[0] if line.startswith("| Twaron CT612 |") and f"| {plies} | {density:.2f} |" in line]
            self.assertEqual([f" {value} [" in row for value, row in zip(case.computed, rows, strict=True)], [True] * 4)
            self.assertTrue(all(f"| {case.measured} ± " in row for row in rows))
        for case in strips[0].cases[:4]:
            self.assertTrue(
                any(f"| {case.name} | {case.measured} |" in line and f"| {case.computed[0]} [" in line for line in tables[1])
            )
        self.assertIn(f"100/s, MPa: {strips[0].cases[4].computed[0]} [", "".join(tables[0]))

    def test_each_case_left_out_lies_within_what_the_others_give(self):
        rows = left_out(compared())
        self.assertEqual(len(rows), 5)
        self.assertTrue(all(within for *_, within in rows))

    def pack(self, plies, mass=1.1e-3):
        body = {
            "shape": "cylinder",
            "radius": 2.73e-3,
            "length": 6e-3,
            "mass": mass,
            "position": [0, 0, -3e-3],
            "velocity": [0, 0, 500],
        }
        return Scene(
            "sheet_3in_sphere",
            fabric={"name": "kevlar_km2_s706"},
            sheet={"plies": plies, "nodes_x": 121, "nodes_y": 121},
            projectile=body,
        )

    def test_what_was_not_compared_gets_no_band(self):
        within = model_error(self.pack(20))
        self.assertGreater(within.factor, 1.2)
        low, high = within.band(400.0, 420.0)
        self.assertLess(low, 400.0 / 1.16)
        self.assertGreater(high, 420.0 * 1.16)
        self.assertRegex(within.sentence(400.0, 420.0), r"^Of the model against tests: \[\d+, \d+\] m/s; within a factor of")
        for scene, told in (
            (self.pack(1), "here: 0.178 kg/m² (one ply)"),
            (self.pack(20, 5e-3), "here: 5 g"),
            (self.pack(20).replace({"attachment.kind": "two_sides"}), "here: two sides held"),
            (self.pack(20).replace({"sheet.nodes_x": 51}), "80 to 160 mm wide; here: 37.4 x 89.6 mm wide"),
            (self.pack(20).replace({"yarn.modulus_mean": 140e9}), "a yarn of 54 to 96 GPa; here: 140 GPa"),
            (self.pack(20).replace({"yarn.critical_stretch": 1.1}), "fails at 2.62 to 4.67 %; here: 10 %"),
            (self.pack(20).replace({"projectile.shape": "sphere"}), "a cylinder; here: a sphere"),
            (self.pack(20).aimed(velocity=[300, 0, 300]), "here: an angle of impact of 45 degrees"),
            (
                self.pack(20).aimed(orientation=[0.6, 0.8, 0, 0]),
                "an attitude of at most 5 degrees; here: an attitude of 74 degrees",
            ),
        ):
            error = model_error(scene)
            self.assertTrue(math.isnan(error.factor))
            self.assertIsNone(error.band(1.0, 2.0))
            self.assertIn(told, error.sentence(1.0, 2.0))
            unknown = "no test of one ply" if told.endswith("(one ply)") else "so the error is unknown"
            self.assertIn(unknown, error.sentence(1.0, 2.0))

    def test_whatever_is_drawn_or_listed_is_compared(self):
        pack = self.pack(20).aimed()
        for drawn, told in (
            ({"attitude": "random"}, "here: an attitude of "),
            ({"tilt": 0.3}, "here: an attitude of 17 degrees: so"),
            ({"tilt": [0.0, 0.3]}, "an attitude of 17 degrees"),
            ({"point": (0.02, 0.0)}, "40 mm or more from an edge; here: 24.8 mm"),
            ({"parameters": {"projectile.mass": [1.1e-3, 2e-3]}}, "here: 2 g"),
            ({"attitude": [0.6, 0.8, 0, 0]}, "an attitude of 74 degrees"),
        ):
            error = model_error(vary(pack, 8, seed=1, **drawn))
            self.assertTrue(math.isnan(error.factor), drawn)
            self.assertIn(told, error.words)
        self.assertTrue(math.isfinite(model_error(vary(pack, 8, seed=1, tilt=0.05, point=within_mesh(pack, (0.0, 0.0)))).factor))
        # Nor does one ply stand beside resolved yarns that were hit otherwise.
        ply = self.pack(1).aimed()
        self.assertIn("no test of one ply", model_error(ply).words)
        self.assertIn("so the error is unknown", model_error(vary(ply, 8, seed=1, attitude="random")).words)
        for scene, confidence, name in (([], 0.95, "scene"), (pack, 1.0, "confidence")):
            with self.assertRaisesRegex(ValueError, f"^{name}: must be"):
                model_error(scene, confidence)
        with mock.patch(
            "fabric_kernel.v50.flown",
            return_value={"stopped": True, "speed": 0.0, "absorbed": 0.0, "steps": 1, "initial_kinetic": 1.0}
            | dict.fromkeys(("unconverged", "energy_residual", "beyond_fine"), 0),
        ):
            for attitude, told in ((None, "within a factor of"), ("random", "here: an attitude of")):
                shoot = Shooter(pack, attitude=attitude)
                self.assertIn(told, v50(shoot, Plan([500.0] * 3), 3, tests=0).against)
                self.assertIn(told, " ".join(residual_curve(pack, [500.0] * 3, attitude=attitude).answer))

    def test_the_numbers_of_cunniffs_axes(self):
        scene = self.pack(21)
        self.assertAlmostEqual(areal_density(scene) / 21, 2 * 600e-3 / 9000 * 34 / 0.0254, places=6)
        self.assertAlmostEqual(presented_area(scene), math.pi * 2.73e-3**2, places=12)
        side = scene.replace({"projectile.orientation": [math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0]})
        self.assertAlmostEqual(presented_area(side), 2 * 2.73e-3 * 6e-3, places=10)
        found = axes(scene)
        self.assertAlmostEqual(
            found.velocity, cunniff_velocity(0.5 * 84.62e9 * 1.0355 * (1.0355**2 - 1), 0.0355, 84.62e9, 1440.0), places=3
        )
        self.assertAlmostEqual(found.ratio, areal_density(scene) * math.pi * 2.73e-3**2 / 1.1e-3, places=9)
        self.assertIsNone(axes(Scene("sheet_3in_sphere")))
