"""The ballistic limit of a scene: shots that can be repeated, kept shots, and the command."""

import contextlib
import importlib.util
import io
import json
import pathlib
import tempfile
import unittest
from unittest import mock

from fabric_kernel.v50 import main, Shooter

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

    def test_a_bad_argument_is_told_in_one_line(self):
        with tempfile.TemporaryDirectory() as name:
            path = pathlib.Path(name) / "scene.toml"
            path.write_text(self.scene().text())
            for words, told in ((["--low", "60", "--high", "20"], "low"), (["--design", "plan"], "velocities"), (["--shots", "0"], "shots"),
                (["--aim", "0.01"], "--aim goes with --design three-phase"), (["--design", "three-phase", "--last", "3"], "--aim")):
                with contextlib.redirect_stderr(io.StringIO()) as errors, self.assertRaises(SystemExit) as left:
                    main([str(path), *words, "--out", name])
                self.assertEqual(left.exception.code, 1)
                self.assertIn(told, errors.getvalue())
                self.assertEqual(len(errors.getvalue().splitlines()), 1)
                self.assertFalse((pathlib.Path(name) / "runs.jsonl").exists())

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

    def test_an_interrupt_tells_how_to_go_on(self):
        with tempfile.TemporaryDirectory() as name, mock.patch("fabric_kernel.v50.v50", side_effect=KeyboardInterrupt):
            errors = io.StringIO()
            with contextlib.redirect_stderr(errors), self.assertRaises(SystemExit) as left:
                main(["sheet_3in_sphere", "--out", name])
        self.assertEqual(left.exception.code, 130)
        self.assertIn("the same command goes on", errors.getvalue())


if __name__ == "__main__":
    unittest.main()
