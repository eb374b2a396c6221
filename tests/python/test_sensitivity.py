"""The change of a limit with what was chosen, and the pictures of the package."""

import csv
import io
import math
import re

import matplotlib
import numpy
import scipy.stats
from commands import InFolder
from fabric_kernel import PRESETS, Scene, Simulation, history, plot
from fabric_kernel.movie import movie
from fabric_kernel.sensitivity import WIDTH, crossing, interval, variants
from fabric_kernel.sheets import outline
from fabric_kernel.textile import areal_density, presented_area, sides
from fabric_kernel.v50 import main
from PIL import Image


class Sensitivity(InFolder):
    def scene(self, **sheet):
        body = {"radius": 2.778e-3, "mass": 6.9e-4, "position": [0.0, 0.0, -2.778e-3]}
        return Scene(
            "sheet_3in_sphere", fabric={"name": "kevlar_km2_s706"}, sheet={"nodes_x": 41, "nodes_y": 41} | sheet, projectile=body
        )

    def test_a_crossing_is_found_from_both_sides_and_far_away(self):
        for limit in (20.0, 95.0, 100.0, 105.0, 700.0):
            self.assertLess(
                abs(math.log(crossing(100.0, lambda velocity: velocity > limit) / limit)), 0.5 * math.log(WIDTH) + 1e-9
            )
        self.assertTrue(math.isnan(crossing(100.0, lambda velocity: False)))

    def test_the_interval_is_that_of_student_and_not_below_the_bisection(self):
        mean, _, high = interval([0.1, 0.2, 0.3])
        half = scipy.stats.t.ppf(0.975, 2) * 0.1 / math.sqrt(3)
        self.assertAlmostEqual(mean, 100 * math.expm1(0.2))
        self.assertAlmostEqual(high, 100 * math.expm1(0.2 + half))
        _, _low, high = interval([0.0, 0.0, 0.0])
        self.assertAlmostEqual(high, 100 * math.expm1(scipy.stats.t.ppf(0.975, 2) * math.log(WIDTH) / math.sqrt(18)))
        self.assertEqual(interval([0.1])[1:], (-math.inf, math.inf))

    def test_every_variant_differs_by_what_it_says_and_can_be_simulated(self):
        scene = self.scene()
        found = variants(scene)
        self.assertEqual(len(found), 12)
        for name, other in found.items():
            other.check()
            self.assertNotEqual(other, scene, name)
        coarse = next(other for name, other in found.items() if name.startswith("spacing"))
        self.assertAlmostEqual(areal_density(coarse), areal_density(scene))
        self.assertAlmostEqual(sides(coarse)[0], sides(scene)[0])
        narrow = next(other for name, other in found.items() if name.startswith("width"))
        self.assertAlmostEqual(sides(narrow)[0] / sides(scene)[0], math.sqrt(0.5), delta=0.02)
        flat = scene.replace(projectile={"shape": "cylinder", "length": 5e-3}).aimed()
        turned = variants(flat)["attitude: turned by 90 degrees about x"]
        turned.check()
        self.assertAlmostEqual(turned["projectile.position"][2], -2.778e-3)
        for size, how in (
            ((0.01, 0.02, 0.03), "90 degrees about x"),
            ((0.01, 0.02, 0.02), "90 degrees about y"),
            ((0.01, 0.01, 0.01), "45 degrees about x"),
        ):
            box = scene.replace(projectile={"shape": "box", "size": size}).aimed()
            other = variants(box)[f"attitude: turned by {how}"]
            other.check()
            self.assertNotAlmostEqual(presented_area(other) / presented_area(box), 1.0, places=3)
        for body in (flat, flat.replace({"projectile.shape": "hemispherical_cylinder"})):
            along_x = body.aimed(orientation=[math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0])
            self.assertIn("attitude: turned by 90 degrees about y", variants(along_x))
        holds = [other["attachment.hold"] for name, other in found.items() if name.startswith("hold of the attachments")]
        strength = scene.replace({"attachment.hold": "1 of the yarn"})["attachment.hold"]
        for hold, part in zip(holds, (0.7, 0.4, 0.15), strict=True):
            self.assertAlmostEqual(hold / strength, part)
        weak = scene.replace({"attachment.hold": 20.0})
        self.assertEqual(
            next(other for name, other in variants(weak).items() if name.startswith("spacing"))["attachment.hold"], 40.0
        )
        self.assertFalse([name for name in variants(scene.replace({"attachment.kind": "free"})) if name.startswith("hold")])
        dry = scene.replace({f"yarn.viscosity_{kind}": 0.0 for kind in ("linear", "quadratic", "bending")})
        self.assertIn("viscosity of the yarn: that of real fabrics", variants(dry))

    def test_the_command_shows_what_the_width_does_for_ten_times_the_node_steps_of_the_test(self):
        for shots in (10, 20, 40):
            with self.subTest(shots=shots):
                said, _, _ = self.ran(main, self.scene(), "--shots", str(shots), "--tests", "0", "--sensitivity", out=f"{shots}")
                folder = self.folder / f"{shots}"
                rows = list(csv.reader(io.StringIO((folder / "sensitivity.csv").read_text())))
                self.assertEqual(rows[0], ["variant", "change_percent", "low_percent", "high_percent", "shots"])
                self.assertEqual(len(rows), 13)
                change = {row[0]: [float(number) for number in row[1:]] for row in rows[1:]}
                wide = [change[name][0] for name in change if name.startswith("width")]
                self.assertLess(min(wide), -10.0)
                self.assertGreater(max(wide), 10.0)
                self.assertGreater(next(change[name][0] for name in change if name.startswith("failure strain")), 3.0)
                self.assertTrue(all(shots >= 2 and math.isfinite(low + high) for _, low, high, shots in change.values()))
                page = (folder / "report.html").read_text()
                found = re.search(r"The changes took ([\d.]+) times the node-steps of the test", page)
                self.assertLessEqual(float(found[1]), 10.0)
                for text in (said, page):
                    self.assertIn("The width of the sheet changes the limit by", text)
                    self.assertIn("The spacing of the network changes the limit by", text)
                    self.assertIn("They are changes from", text)
                    largest = max(change, key=lambda name: abs(change[name][0]))
                    self.assertRegex(text, f"Of 12 changes the largest is that of the {largest.split(': ')[0]}, [+-]")
                    # The head of a report says nothing of another fabric.
                    self.assertNotIn(
                        "Kevlar",
                        text.split("shots, ")[0].split("Sheet:")[0]
                        if text is said
                        else text.split("<details>")[0].split("</div>")[0],
                    )
                    self.assertTrue(shots == 20 or ("found in the network of bars of two yarns" in text) == (shots == 10))
                self.assertEqual(page.count("data:image/svg+xml"), 2)


class Pictures(InFolder):
    def test_each_is_drawn_the_same_twice_and_leaves_the_settings_of_the_user(self):
        before = dict(matplotlib.rcParams)
        simulation = Simulation(Scene("sheet_3in_sphere", sheet={"nodes_x": 31, "nodes_y": 31}), warns=False)
        rows = history(simulation, steps=640)
        for number in (0, 1):
            plot.history(rows, self.folder / f"history{number}.svg", marks=[(1e-5, "detached")])
            plot.sheet(simulation, self.folder / f"sheet{number}.png")
            plot.profile(simulation, self.folder / f"profile{number}.svg")
        for kind in ("history0.svg", "sheet0.png", "profile0.svg"):
            self.assertEqual((self.folder / kind).read_bytes(), (self.folder / kind.replace("0", "1")).read_bytes())
        for preset in PRESETS:
            small = {"sheet": {"nodes_x": 61, "nodes_y": 61}}
            if preset == "ring_40in":
                small = {
                    "sheet": {"radius": 0.1, "nodes_y": 41},
                    "casing": {"radius": 0.1},
                    "projectile": {"position": [0, 0, 0.06]},
                }
            plot.sheet(Simulation(Scene(preset, small)), self.folder / "preset.png")
        self.assertEqual(before, dict(matplotlib.rcParams))

    def test_a_movie_has_pictures_of_the_whole_run(self):
        path = self.folder / "movie.gif"
        movie(Scene("sheet_3in_sphere", sheet={"nodes_x": 31, "nodes_y": 31}), path, steps=320, every=64)
        with Image.open(path) as pictures:
            self.assertEqual(pictures.n_frames, 6)

    def test_the_lines_of_every_body_enclose_it(self):
        for preset, farthest in (
            ("sheet_3in_sphere", 6.35e-3),
            ("sheet_10in_cylinder", None),
            ("turbine_disc_sector", None),
            ("ring_40in", None),
        ):
            points = numpy.concatenate(outline(Scene(preset)))
            reach = float(numpy.linalg.norm(points, axis=1).max())
            self.assertTrue(1e-3 < reach < 0.1)
            self.assertTrue(farthest is None or abs(reach - farthest) < 1e-9)
            self.assertTrue((points.min(0) < 0).all() and (points.max(0) > 0).all())
