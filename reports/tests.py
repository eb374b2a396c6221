"""`python3 -m unittest reports.tests`: statistics, verdicts and sheets against values known from books or by hand."""

import base64
import math
import pathlib
import shutil
import tempfile
import unittest
from xml.etree import ElementTree

import numpy

from . import claims, friction, front, page, run, sheets, validate
from .statistics import AGREES, CANNOT_BE_TOLD, DOES_NOT, Estimate, arrest_limit, student, verdict_of_all, verdict_of_any


def interval(low, high):
    return Estimate(0.5 * (low + high), low, high)


class Statistics(unittest.TestCase):
    def test_interval_of_a_known_sample(self):
        # 1 to 10: mean 5.5, standard deviation 3.02765, half width 2.262 sd/sqrt(10) = 2.1658.
        mean = Estimate.mean(range(1, 11))
        self.assertEqual(mean.value, 5.5)
        self.assertAlmostEqual(mean.high, 7.6659, 4)
        self.assertEqual(Estimate.mean([3.0]).high, math.inf)
        self.assertEqual(Estimate.mean([10.0] * 3), Estimate.exact(10.0))
        # Three equal values in steps of 3 %: 10 x 0.03/sqrt(12) = 0.0866 times 4.3027.
        self.assertAlmostEqual(Estimate.mean([10.0] * 3, 0.03).high, 10.3726, 4)
        self.assertAlmostEqual(student(math.inf), 1.95996, 5)

    def test_ratio_of_known_samples(self):
        # Equal sizes and equal relative errors s: 2 (n - 1) degrees of freedom, half width of the logarithm t s sqrt(2).
        ratio = Estimate.ratio([18.0, 20.0, 22.0], [9.0, 10.0, 11.0])
        self.assertEqual(ratio.value, 2.0)
        self.assertAlmostEqual(math.log(ratio.high / 2), 2.7764 * 0.1 / math.sqrt(3) * math.sqrt(2), 5)
        self.assertAlmostEqual(ratio.low * ratio.high, 4.0)
        self.assertEqual(Estimate.ratio([2.0, 2.0], [1.0, 1.0]), Estimate.exact(2.0))
        self.assertEqual(Estimate.ratio([0.0, 0.0], [1.0, 1.0]), Estimate.exact(0.0))
        self.assertTrue(math.isnan(Estimate.ratio([0.0, 0.0], [0.0, 0.0]).value))

    def test_share_of_known_counts(self):
        # Wilson: for none of n the interval ends at z^2/(n + z^2); 5 of 10: 0.2366 to 0.7634.
        z = student(math.inf)
        self.assertAlmostEqual(Estimate.share(0, 10).high, z * z / (10 + z * z))
        self.assertAlmostEqual(Estimate.share(5, 10).low, 0.2366, 4)
        self.assertEqual([Estimate.share(k, 10).verdict((0.5, 1.0)) for k in (10, 0, 5)], [AGREES, DOES_NOT, CANNOT_BE_TOLD])
        self.assertEqual(Estimate.share(0, 0).verdict((0.5, 1.0)), CANNOT_BE_TOLD)

    def test_ballistic_limit_of_known_counts(self):
        limit = lambda *arrested: arrest_limit([(2.0 * k, count, 10) for k, count in enumerate(arrested)])
        # All arrested at 2 J, none at 4 J: 3 J, and no better than the spacing. Half at 2 J: 2 J.
        self.assertEqual(limit(10, 10, 0, 0).value, 3.0)
        self.assertAlmostEqual(limit(10, 10, 0, 0).high - 3, 1.95996 * 2 / math.sqrt(12), 4)
        self.assertEqual(limit(10, 5, 0).value, 2.0)
        # 3 and 5 of 10 are pooled to 4 and 4.
        self.assertEqual(limit(10, 3, 5, 0), limit(10, 4, 4, 0))
        self.assertEqual([limit(9, 5, 0), limit(10, 5, 1), arrest_limit([])], [None] * 3)

    def test_verdicts_follow_the_interval(self):
        found = [interval(*ends).verdict((1.5, 2.5)) for ends in ((1.6, 2.4), (0.9, 1.4), (1.4, 1.6))]
        self.assertEqual(found, [AGREES, DOES_NOT, CANNOT_BE_TOLD])
        self.assertEqual([verdict_of_all([AGREES, CANNOT_BE_TOLD]), verdict_of_all(found), verdict_of_all([])], [CANNOT_BE_TOLD, DOES_NOT, CANNOT_BE_TOLD])
        self.assertEqual([verdict_of_any(found), verdict_of_any([DOES_NOT, CANNOT_BE_TOLD]), verdict_of_any([])], [AGREES, CANNOT_BE_TOLD, CANNOT_BE_TOLD])


class Sheets(unittest.TestCase):
    """Two plies of 3 x 2 nodes as study/src/picture.rs keeps them: of the second the first segment along x has failed, the last along y
    is half."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        nodes = numpy.array([[x, y, 0] for y in (0, 1) for x in (0, 1, 2)], "<f4")
        head = numpy.array([5e-6, *(0, 0, 9), *(1, 0, 0, 0)], "<f8")
        stretch = numpy.array([9, 1, 1.01, 1, 1, 1, 1.03], "<f4")
        alpha = bytes([0, 255, 255, 255, 255, 255, 128])
        singles = [nodes, nodes, nodes, 10 * nodes, stretch, stretch]
        (self.folder / "sheet.bin").write_bytes(b"".join([head.tobytes(), *(part.tobytes() for part in singles), bytes(range(1, 8)), alpha]))
        corners = [[[x, y, z] for x in (0, 1)] for y in (0, 1) for z in (8, 9)]
        self.about = {"file": "sheet.bin", "nodes": [3, 2], "plies": 2, "mirrored": [0, 0], "outline": corners, "half_size_m": [1, 0.5], "critical_strain": 0.03, "sphere_m": 0.0}
        self.sheet = sheets.Sheet(self.folder, self.about, ply=1)

    def test_every_number_is_read_in_its_place(self):
        sheet = self.sheet
        self.assertEqual((sheet.time, list(sheet.centre), sheet.failed()), (5e-6, [0, 0, 9], 1))
        self.assertEqual(sheet.segments.tolist(), [[0, 1], [1, 2], [3, 4], [4, 5], [0, 3], [1, 4], [2, 5]])
        self.assertEqual((sheet.positions[5].tolist(), sheet.velocities[5].tolist()), ([2, 1, 0], [20, 10, 0]))
        self.assertAlmostEqual(sheet.stretch[6], 1.03, 6)
        self.assertEqual([round(alpha, 2) for alpha in sheet.alpha], [0, 1, 1, 1, 1, 1, 0.5])

    def test_a_mesh_with_a_failed_segment_is_a_hole_with_loose_yarns(self):
        self.assertEqual(self.sheet.whole().tolist(), [[False, True]])
        self.assertEqual(self.sheet.covered().tolist(), [False, True, False, True, False, True, True])
        [(corners, colours)] = self.sheet.cloth()
        self.assertEqual(corners[0].tolist(), [[1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0]])
        # Of its four nodes two touch the segment at the critical strain, one that at a third of it.
        self.assertTrue(numpy.allclose(colours, sheets.STRAIN((2 + 1 / 3) / 4)[:3], atol=0.01))

    def test_the_hull_of_a_box_has_its_faces(self):
        faces, _ = self.sheet.body()
        self.assertEqual(len(faces), 12)

    def test_vtk_has_damage_stretch_and_velocity(self):
        sheets.vtk_series(self.folder, [self.about])
        names = [part.get("file") for part in ElementTree.parse(self.folder / "vtk/run.pvd").iter("DataSet")]
        self.assertEqual(names, ["projectile_0000.vtp", "sheet_0000_0.vtp", "sheet_0000_1.vtp"])
        arrays = {array.get("Name"): array for array in ElementTree.parse(self.folder / "vtk" / names[2]).iter("DataArray")}
        numbers = lambda name: numpy.frombuffer(base64.b64decode(arrays[name].text)[4:], "<f4")
        self.assertTrue(numpy.allclose(numbers("damage"), 1 - self.sheet.alpha))
        self.assertTrue(numpy.allclose(numbers("stretch"), self.sheet.stretch))
        self.assertTrue(numpy.allclose(numbers("velocity").reshape(-1, 3), self.sheet.velocities))


class Claims(unittest.TestCase):
    def test_a_claim_is_refuted_by_one_counterexample_and_says_which(self):
        checks = [claims.Check("a", interval(1.1, 1.2), claims.MORE), claims.Check("b", interval(0.8, 0.9), claims.MORE)]
        claim = claims.Claim("P3", "more", "above 1", checks)
        self.assertEqual((claim.verdict, claim.why()), (DOES_NOT, "1 of 2 inside; outside: b"))
        self.assertEqual(claims.Claim("P3", "more", "above 1", checks, whole=verdict_of_any).verdict, AGREES)

    def test_two_or_four_points_in_most_runs(self):
        verdict = lambda *counts: claims.two_or_four(counts).verdict(claims.MOST)
        self.assertEqual(verdict(2, 4, 2, 2, 4, 2, 2, 2, 4, 2), AGREES)
        self.assertEqual(verdict(1, 1, 3, 1, 8, 1, 1, 5, 1, 1), DOES_NOT)
        self.assertEqual([verdict(2, 1, 4, 3), verdict()], [CANNOT_BE_TOLD] * 2)


class Validate(unittest.TestCase):
    def test_slope_of_a_ladder_bends_where_the_measured_one_does(self):
        row = lambda density, limit, measured: {"areal density kg/m2": density, "limit m/s": limit, "limit m/s: deviation": 0.0, "hits": 3, "measured V50 m/s": measured}
        rows = [row(7.5, 700.0, 700.0), row(5.0, 600.0, 620.0), row(2.5, 450.0, 438.0), row(4.5, 1.0, 585.0)]
        below, above = validate.slope_points(rows)
        self.assertEqual([round(below.ours.value, 9), round(above.ours.value, 9)], [60.0, 40.0])
        self.assertAlmostEqual(sum(below.allowed) / 2, 72.8)
        self.assertAlmostEqual(above.allowed[1] - above.allowed[0], 2 * math.sqrt(2) * 19 / 2.5)
        self.assertEqual(validate.slope_points(rows[:1]), [])

    def test_a_comparison_is_as_good_as_its_worst_point(self):
        point = lambda name, low, high: validate.Point(name, interval(low, high), validate.about(100, 0.1))
        good, bad, wide = point("a", 95, 105), point("b", 111, 120), point("c", 85, 95)
        row = lambda *points: validate.Comparison("x", "theory", "", list(points), 0).row()
        self.assertEqual(row(good)[4], AGREES)
        self.assertEqual((row(good, wide)[4], row(good, bad, wide)[4]), (CANNOT_BE_TOLD, DOES_NOT))
        self.assertIn("3; b:", row(good, bad, wide)[3])

    def test_a_mean_has_the_error_of_its_hits_and_of_the_bisection(self):
        row = {"limit": 100.0, "limit: deviation": 0.0, "hits": 4}
        self.assertEqual(validate.mean_of(row, "limit"), Estimate.exact(100.0))
        # Student's 3.182 for three degrees of freedom times 1/sqrt(12).
        self.assertAlmostEqual(validate.mean_of(row, "limit", 0.01).high, 100.9187, 3)


class Friction(unittest.TestCase):
    def test_a_verdict_is_of_the_published_coefficients(self):
        rows = [{"case": "pack", "friction": f"{friction}", "limit m/s": limit} for friction, limit in ((0.0, 100.0), (0.1, 102.0), (0.3, 110.0), (0.5, 150.0)) for _ in range(9)]
        lines = friction.verdicts(rows).splitlines()[2:]
        self.assertEqual([line.split(" | ")[0] for line in lines], ["| pack: limit with 0.1 over 0", "| pack: limit with 0.3 over 0"])
        self.assertEqual([line.split(" | ")[3].strip(" |") for line in lines], [DOES_NOT, AGREES])

    def test_the_worst_balance_and_the_most_unconverged_solves_are_told(self):
        row = {"impact velocity m/s": 100, "friction": 0, "impact J": 5, "absorbed J": 1, "rubbed J": 0, "velocity m/s": 90}
        table = friction.impact_table([row | {"residual %": 0.1, "unconverged": 7}, row | {"residual %": -0.2, "unconverged": 3}])
        self.assertTrue(table.endswith("| 0.20 | 7 |\n"), table)


class Run(unittest.TestCase):
    def test_every_ply_has_its_fabric_and_its_energies(self):
        ply = {"failed_segments": 3, "kinetic": 1.0, "strain": 2.0, "dissipated": 3.0}
        summary = {"plies": [ply | {"fabric": "one", "turned": False}, ply | {"fabric": "two", "turned": True}]}
        heading, rows = run.ply_table(summary)
        self.assertEqual(rows, [[1, "one", "no", 3, "1.0000", "2.0000", "3.0000"], [2, "two", "yes", 3, "1.0000", "2.0000", "3.0000"]])
        self.assertEqual(len(heading), len(rows[0]))


class Front(unittest.TestCase):
    def setting(self, step, cost, absorbed, residual):
        row = {"family": "Verlet", "dt_over_dt_crit": step, "accepted": step <= 0.5, "default": step == 0.4, "plain": True, "full_network": True}
        row |= {"toe": False, "runs": 8.0, "node_steps": cost, "cpu_seconds": cost}
        row |= {name: 1.0 for name in front.MEASURES} | {f"{name}_deviation": 0.0 for name in front.MEASURES}
        return row | {"absorbed": absorbed, "absorbed_deviation": 0.01, "residual": residual}

    def test_the_front_counts_no_error_below_the_resolution(self):
        # Reference 1 and deviation 0.01: means of eight runs resolve 0.01.
        judged = front.Judged([
            self.setting(0.05, 8.0, 1.0, 0.0), self.setting(0.1, 4.0, 1.001, 0.01), self.setting(0.2, 2.0, 1.004, 0.1),
            self.setting(0.4, 1.0, 1.02, 1.0), self.setting(0.3, 1.5, 1.03, 0.5), self.setting(0.7, 0.5, 1.0, 0.0),
        ])
        self.assertAlmostEqual(judged.resolution["absorbed"], 0.01)
        on = lambda name: [name in row["fronts"][0] for row in judged.rows]
        self.assertEqual(on("absorbed"), [False, False, True, True, False, False])
        # The energy residual tells them apart.
        self.assertEqual(on("all"), [False, True, True, True, True, False])
        self.assertEqual([front.marks(row, 0) for row in judged.rows[::5]], ["reference", ""])

    def test_the_choice_is_the_cheapest_that_meets_the_wish(self):
        judged = front.Judged([self.setting(0.05, 8.0, 1.0, 0.0), self.setting(0.2, 2.0, 1.004, 0.1), self.setting(0.4, 1.0, 1.015, 1.0)])
        found = {wanted: best and (best[0]["dt_over_dt_crit"], best[1]) for wanted, best in front.choice(judged)}
        # 0.05: one run at 0.4; 0.01: (0.01^2 - 0.005^2) leaves room for the spread of two runs at 0.2.
        self.assertEqual((found[0.05], found[0.01], found[0.001]), ((0.4, 1), (0.2, 2), None))


class Page(unittest.TestCase):
    def test_numbers_are_short(self):
        self.assertEqual([page.significant(x) for x in (1234.5, 12.345, 1.2345, 0.012345, 0.0)], ["1234", "12.3", "1.23", "0.0123", "0.0000"])
        self.assertEqual([page.power(x, 1) for x in (0.00123, 12.3)], ["1.2e-3", "1.2e1"])
