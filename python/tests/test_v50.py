"""The ballistic limit of a scene: shots that can be repeated, kept shots, and the command."""

import contextlib
import importlib.util
import io
import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

from fabric_kernel.v50 import Shooter, Unknown, main

# The statistics need no kernel, this does.
BUILT = importlib.util.find_spec("fabric_kernel._kernel") is not None


@unittest.skipUnless(BUILT, "the kernel is not built")
class OfAScene(unittest.TestCase):
    def scene(self):
        from fabric_kernel import Scene

        return Scene("sheet_3in_sphere", sheet={"nodes_x": 41, "nodes_y": 41}, projectile={"velocity": [0.0, 0.0, 50.0]})

    def test_a_shot_is_that_of_its_number(self):
        from fabric_kernel import fly, vary

        shoot = Shooter(self.scene(), seed=3, point=None)
        stopped, residual = shoot(70.0, 2)
        row = fly(vary(self.scene(), 3, seed=3, speed=70.0)[2], until=Shooter.UNTIL, steps=1_000_000)
        self.assertEqual((stopped, residual), (row["stopped"], row["speed"]))
        self.assertEqual(shoot.notes()[-1], f"The viscosity of the yarn took {100 * row['viscous'] / row['absorbed']:.0f} % of the absorbed energy.")
        self.assertEqual([note for note in shoot.notes() if "converge" in note], [])
        # Within a mesh about the middle: another point, the same for each call.
        about = Shooter(self.scene(), seed=3)
        self.assertEqual(about(70.0, 2), about(70.0, 2))
        self.assertNotEqual(about(70.0, 2), about(70.0, 1))

    def test_a_shot_ends_when_it_is_decided(self):
        decided, ended = Shooter(self.scene(), seed=3), Shooter(self.scene(), seed=3, to_the_end=True)
        self.assertEqual((decided(70.0, 2)[0], ended(70.0, 2)[0]), (False, False))
        (row,), (whole,) = decided.made.values(), ended.made.values()
        self.assertEqual((row["outcome"], "through" in whole["outcome"]), ("through", False))
        self.assertLess(row["steps"], whole["steps"])
        self.assertIn("1 of 1 shots that went through ended when held yarn did not stop them any more", " ".join(decided.notes()))

    def test_the_report_says_what_is_not_to_be_trusted(self):
        shoot = Shooter(self.scene(), seed=3)
        shoot(70.0, 0), shoot(70.0, 1)
        row = list(shoot.made.values())[1]
        self.assertEqual((row["unconverged"], row["ply_penetration"], row["beyond_fine"]), (0, 0.0, 0))
        row["unconverged"] = row["steps"] // 4
        self.assertRegex(shoot.notes()[0], r"^In 1 of 2 runs more than 1 % of the steps .* at most 25 %\)")

    def test_the_report_names_sharp_edges_of_fast_shots(self):
        from fabric_kernel import Scene

        flat = Scene("sheet_3in_sphere", sheet={"nodes_x": 31, "nodes_y": 31}, fabric={"name": "kevlar_km2_s706"}, projectile={"shape": "cylinder", "length": 0.005})
        for scene, velocity, named in [(flat, 400.0, True), (flat, 100.0, False), (self.scene(), 400.0, False)]:
            shoot = Shooter(scene)
            shoot(velocity, 0)
            self.assertEqual(any("edges are sharp" in note for note in shoot.notes()), named)

    def test_too_few_steps_are_an_error_that_names_the_shot(self):
        with self.assertRaisesRegex(RuntimeError, "shot 1 at 70 m/s: timeout after 10 steps"):
            Shooter(self.scene(), steps=10)(70.0, 0)

    def test_the_command_goes_on_where_it_was(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "scene.toml").write_text(self.scene().text())
            words = [str(folder / "scene.toml"), "--low", "20", "--high", "60", "--deviation", "2", "--tests", "0", "--out", str(folder / "out")]
            with contextlib.redirect_stdout(io.StringIO()) as first:
                main([*words, "--shots", "4"])
            kept = (folder / "out/runs.jsonl").read_text()
            with contextlib.redirect_stdout(io.StringIO()) as second:
                main([*words, "--shots", "6"])
            # The four shots are not shot again, and two are new.
            again = (folder / "out/runs.jsonl").read_text()
            self.assertTrue(again.startswith(kept))
            self.assertEqual([len(kept.splitlines()), len(again.splitlines())], [4, 6])
            shots = [line.replace("of 4:", "of 6:") + ", kept from before" for line in first.getvalue().splitlines()[:4]]
            self.assertEqual(shots, second.getvalue().splitlines()[:4])
            self.assertNotIn("kept", second.getvalue().splitlines()[4])
            self.assertEqual(len(json.loads((folder / "out/test.json").read_text())["shots"]), 6)

    def said(self, scene, *words):
        """What the command prints for a scene, and what it writes, as numbers."""
        with tempfile.TemporaryDirectory() as name:
            path = pathlib.Path(name) / "scene.toml"
            path.write_text(scene.text())
            with contextlib.redirect_stdout(io.StringIO()) as said:
                main([str(path), "--tests", "0", "--out", name, *words])
            return said.getvalue(), json.loads((pathlib.Path(name) / "test.json").read_text())

    def test_the_first_command_answers_from_any_velocity(self):
        found = []
        for first in (5.0, 50.0, 500.0):
            said, test = self.said(self.scene().replace({"projectile.velocity": (0.0, 0.0, first)}))
            self.assertEqual(test["shots"][0]["velocity"], first)
            self.assertLessEqual([shot["stopped"] for shot in test["shots"][:7]].count(test["shots"][0]["stopped"]), 6)
            low, high = (test["fit"]["intervals"][1][end] for end in ("low", "high"))
            self.assertLess(low, test["fit"]["mu"])
            self.assertLess(test["fit"]["mu"], high)
            self.assertIn(f"steps by a factor of 2 from {first:g} m/s", said)
            found.append((low, high))
        # They are intervals of one V50.
        self.assertLess(max(low for low, _ in found), min(high for _, high in found))

    def test_a_sheet_that_always_stops_and_one_that_never_does(self):
        sheet = {"nodes_x": 31, "nodes_y": 31}
        # A ball that is larger than the sheet rests on the nodes that are held.
        never = self.scene().replace({"projectile.radius": 0.05, "projectile.mass": 1.0}, sheet=sheet)
        said, test = self.said(never, "--steps", "20000")
        self.assertTrue(all(shot["stopped"] for shot in test["shots"]))
        self.assertIn("without a V50", said)
        fastest = max(shot["velocity"] for shot in test["shots"])
        self.assertRegex(said, f"V99  none +above {fastest:.1f}")
        # A heavy body goes through at any velocity.
        heavy = self.scene().replace({"projectile.mass": 1e6}, sheet=sheet)
        said, test = self.said(heavy, "--steps", "40000")
        self.assertFalse(any(shot["stopped"] for shot in test["shots"]))
        self.assertIn("without a V50", said)
        slowest = min(shot["velocity"] for shot in test["shots"])
        self.assertRegex(said, f"V01  none +below {slowest:.1f}")

    def test_a_velocity_that_the_time_step_refuses_ends_a_bracket(self):
        from fabric_kernel import Refused

        shoot = Shooter(self.scene())
        with self.assertRaisesRegex(Unknown, "shot 2 at 1e[+]06 m/s: projectile.velocity"):
            shoot(1e6, 1)
        # The first one is the scene's own.
        with self.assertRaises(Refused):
            shoot(1e6, 0)

    def test_the_report_says_what_is_drawn(self):
        uniform = {"yarn.stochastic": False}
        weibull = {"yarn.strength_draw": "weibull"}
        for changes, told in (({}, "yarns drawn for each"), (uniform, "the same yarns in each"), (uniform | weibull, "yarns drawn for each")):
            scene = self.scene().replace(changes)
            self.assertIn(f"seed 4, {told}", Shooter(scene, seed=4).drawn())
        self.assertIn("as the scene says", Shooter(self.scene(), point=None).drawn())
        said, test = self.said(self.scene().replace(uniform), "--design", "plan", "--plan", "200")
        self.assertIn("the same yarns in each, as the scene draws none", said)
        self.assertNotIn("yarns drawn", said + test["seeds"])

    def test_a_report_that_cannot_be_written_is_an_error_and_not_half_there(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            words = [sys.executable, "-m", "fabric_kernel.v50", "sheet_3in_sphere", "--design", "plan", "--plan", "200", "--tests", "0", "--out", name]
            subprocess.run(words, check=True, capture_output=True)
            before = {path.name: path.read_bytes() for path in folder.iterdir()}
            (folder / "test.json").unlink()
            # A file may not be larger than a part of the picture, as on a disk that is full.
            small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (len(before["plot.svg"]) // 2,) * 2)
            done = subprocess.run([*words, "--confidence", "0.9"], capture_output=True, text=True, preexec_fn=small)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, r"^error: .*File too large: '.*plot\.svg'\n$")
            after = {path.name: path.read_bytes() for path in folder.iterdir()}
            self.assertEqual(after, {key: value for key, value in before.items() if key != "test.json"})

    def test_a_bad_argument_is_told_in_one_line(self):
        with tempfile.TemporaryDirectory() as name:
            path = pathlib.Path(name) / "scene.toml"
            path.write_text(self.scene().text())
            for words, told in ((["--low", "60", "--high", "20"], "low"), (["--design", "plan"], "velocities"), (["--shots", "0"], "shots"),
                (["--low", "60"], "--low, --high: one goes with the other"),
                (["--aim", "0.01"], "--aim goes with --design three-phase"), (["--design", "three-phase", "--last", "3"], "--aim")):
                with contextlib.redirect_stderr(io.StringIO()) as errors, self.assertRaises(SystemExit) as left:
                    main([str(path), *words, "--out", name])
                self.assertEqual(left.exception.code, 1)
                self.assertIn(told, errors.getvalue())
                self.assertEqual(len(errors.getvalue().splitlines()), 1)
                self.assertFalse((pathlib.Path(name) / "runs.jsonl").exists())

    def test_a_scene_without_a_velocity(self):
        with tempfile.TemporaryDirectory() as name:
            path = pathlib.Path(name) / "scene.toml"
            path.write_text(self.scene().replace({"projectile.velocity": (0.0, 0.0, 0.0)}).text())
            with contextlib.redirect_stderr(io.StringIO()) as errors, self.assertRaises(SystemExit) as left:
                main([str(path), "--out", name])
            self.assertEqual((left.exception.code, errors.getvalue()[:40]), (1, "error: projectile.velocity: must not be "))

    def test_a_velocity_that_is_not_positive_and_a_file_that_is_not_there(self):
        for words, told in ((["sheet_3in_sphere", "--low", "-1"], "--low: must be a number above 0; it is -1"), (["no.toml"], "no.toml: No such file")):
            with contextlib.redirect_stderr(io.StringIO()) as errors, self.assertRaises(SystemExit):
                main(words)
            self.assertIn(told, errors.getvalue().splitlines()[-1])

    def test_a_report_says_what_was_shot_at(self):
        with tempfile.TemporaryDirectory() as name:
            words = ["sheet_10in_cylinder", "--design", "plan", "--plan", "200", "--tests", "0", "--out", name]
            with contextlib.redirect_stdout(io.StringIO()) as said:
                main(words)
            page = (pathlib.Path(name) / "report.html").read_text()
            for text in ("sheet_10in_cylinder, ", "held: two sides", "Projectile: ", "mass ", "scene ", "Not validated"):
                self.assertIn(text, said.getvalue())
                self.assertIn(text, page)

    def test_a_page_begins_with_the_answer(self):
        from fabric_kernel import Scene
        from fabric_kernel.designs import Plan
        from fabric_kernel.v50 import v50

        for scene, own, others in (
            (self.scene(), "that of the source paper", "On Cunniff's axes"),
            (Scene("sheet_3in_sphere", fabric={"name": "kevlar_km2_s706"}, sheet={"nodes_x": 31, "nodes_y": 31}), "On Cunniff's axes", "that of the source paper"),
        ):
            test = v50(Shooter(scene), Plan([200.0]), 1, tests=0)
            page = test.page(b"<svg/>")
            places = [page.index(words) for words in (
                "V50 not bounded by these shots", "Of the model against tests", "a sheet of this width", "<details>", "Projectile:", own,
            )]
            self.assertEqual(places, sorted(places))
            self.assertNotIn(others, page)
            self.assertIn("not drawn: fragment, fabric, support, attitude, angle of impact", page)

    def test_an_interrupt_tells_how_to_go_on(self):
        with tempfile.TemporaryDirectory() as name, mock.patch("fabric_kernel.v50.v50", side_effect=KeyboardInterrupt):
            errors = io.StringIO()
            with contextlib.redirect_stderr(errors), self.assertRaises(SystemExit) as left:
                main(["sheet_3in_sphere", "--out", name])
        self.assertEqual(left.exception.code, 130)
        self.assertIn("the same command goes on", errors.getvalue())
