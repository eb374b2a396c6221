"""`python3 -m unittest reports.tests`: verdicts and sheets against values known from books or by hand."""

import base64
import math
import pathlib
import shutil
import tempfile
import unittest
from xml.etree import ElementTree

import numpy

from . import claims, run, sheets
from evidence.statistics import AGREES, CANNOT_BE_TOLD, DOES_NOT, Estimate, verdict_of_any


def interval(low, high):
    return Estimate(0.5 * (low + high), low, high)


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


class Run(unittest.TestCase):
    def test_every_ply_has_its_fabric_and_its_energies(self):
        ply = {"failed_segments": 3, "kinetic": 1.0, "strain": 2.0, "dissipated": 3.0}
        summary = {"plies": [ply | {"fabric": "one", "turned": False}, ply | {"fabric": "two", "turned": True}]}
        heading, rows = run.ply_table(summary)
        self.assertEqual(rows, [[1, "one", "no", 3, "1.0000", "2.0000", "3.0000"], [2, "two", "yes", 3, "1.0000", "2.0000", "3.0000"]])
        self.assertEqual(len(heading), len(rows[0]))
