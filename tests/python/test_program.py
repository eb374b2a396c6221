"""The program `fabric`: how a run ends and what it leaves, mistakes on the command line and in scene files, a reader that has
gone."""

import contextlib
import csv
import io
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import tomllib
import unittest

import fabric_kernel as fk
from commands import InFolder
from fabric_kernel import program

SCENES = pathlib.Path(__file__).parents[2] / "examples" / "scenes"
PROGRAM = [sys.executable, "-m", "fabric_kernel.program"]
SMALL = 'preset = "sheet_3in_sphere"\nsheet = { nodes_x = 31, nodes_y = 31 }\n'
FAST = "projectile.velocity = [0.0, 0.0, 300.0]"


def ran(*words, **options):
    return subprocess.run([*PROGRAM, *map(str, words)], capture_output=True, text=True, **options)


class Run(InFolder):
    def test_the_exit_status_says_how_a_run_has_ended(self):
        for words, parameters, status, ended in [
            (["--until", "exited"], FAST, 0, "exited"),
            (["--until", "through"], FAST, 0, "through"),
            (["--steps", "64"], "", 3, "TIMEOUT"),
            (["--steps", "64", "--until", "none"], "", 0, "TIMEOUT"),
            (["--until", "detached", "--steps", "300"], FAST, 3, "TIMEOUT"),
            ([], "contact_capacity = 1", 1, None),
            ([], "projectile.mass = 0.0", 2, None),
        ]:
            with self.subTest(words=words, parameters=parameters):
                (self.folder / "shot.toml").write_text(SMALL + parameters)
                out = self.folder / f"out{status}{ended}"
                done = ran("run", self.folder / "shot.toml", "--no-report", "--out", out, *words)
                self.assertEqual(done.returncode, status, done.stderr)
                self.assertEqual((out / "history.csv").exists(), status != 2)
                if ended:
                    self.assertEqual(json.loads((out / "summary.json").read_text())["ended_by"], ended)

    def test_a_run_has_a_report_with_all_its_pictures_and_its_capsule_the_same_bits(self):
        (self.folder / "shot.toml").write_text(SMALL + "stack = { plies = 2, gap = 1e-4 }\n" + FAST)
        words = ["--movie", "--vtk", "--capsule", "shot.capsule", "--json"]
        done = ran("run", "shot.toml", *words, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        out = self.folder / "fabric-run" / "shot"
        pictures = {
            "report.html",
            "sheet.png",
            "plies.png",
            "damage.png",
            "profile.svg",
            "history.svg",
            "movie.gif",
            "history.csv",
            "summary.json",
            "vtk",
        }
        self.assertEqual({path.name for path in out.iterdir()}, pictures)
        summary = json.loads(done.stdout)
        self.assertEqual(summary, json.loads((out / "summary.json").read_text()))
        row = fk.fly(fk.Scene.read(self.folder / "shot.toml"))
        self.assertEqual(
            (summary["digest"], summary["steps"], summary["contact"]["work"]), (row["digest"], row["steps"], row["absorbed"])
        )
        self.assertEqual(sum(ply["failed_segments"] for ply in summary["plies"]), row["failed_segments"])
        with (out / "history.csv").open() as file:
            last = list(csv.DictReader(file))[-1]
        self.assertEqual(float(last["contact_work_j"]), row["absorbed"])
        replayed = ran("replay", self.folder / "shot.capsule")
        self.assertIn(row["digest"], replayed.stdout)
        cut = self.folder / "cut.capsule"
        cut.write_bytes((self.folder / "shot.capsule").read_bytes()[:-40])
        self.assertIn("cut off", ran("replay", cut).stdout)

    def test_a_run_that_is_stopped_leaves_nothing(self):
        (self.folder / "shot.toml").write_text(SMALL + "projectile.velocity = [0.0, 0.0, 0.0]")
        before = signal.signal(signal.SIGALRM, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        signal.setitimer(signal.ITIMER_REAL, 0.5)
        _, errors, code = self.ran(
            lambda words: program.main(["run", *words]), str(self.folder / "shot.toml"), "--steps", "1000000000"
        )
        self.assertEqual((code, errors), (130, "interrupted: nothing is written\n"))
        self.assertFalse((self.folder / "out").exists())

    def test_balances_of_scenes_with_friction_and_plies_close(self):
        for name in ("rough_sphere", "turned_plies", "hybrid_pack"):
            row = fk.fly(fk.Scene.read(SCENES / f"{name}.toml"))
            self.assertEqual(row["outcome"], "exited")
            self.assertLess(abs(row["energy_residual"]), 0.01 * row["initial_kinetic"], name)

    def test_results_stay_in_their_folder_whatever_the_scene_is_called(self):
        for file, name in [("..toml", "scene"), ("...toml", "scene"), ("a.b.toml", "a.b")]:
            with tempfile.TemporaryDirectory() as folder:
                (pathlib.Path(folder) / file).write_text(SMALL)
                done = ran("run", file, "--steps", "64", "--until", "none", "--no-report", cwd=folder)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(os.listdir(pathlib.Path(folder) / "fabric-run"), [name])


class Mistakes(InFolder):
    def test_those_in_a_scene_file_get_an_answer_that_helps(self):
        mistakes = tomllib.loads(pathlib.Path(__file__).with_name("mistakes.toml").read_text())["mistake"]
        self.assertGreaterEqual(len(mistakes), 30)
        for number, mistake in enumerate(mistakes):
            with self.subTest(mistake["file"]):
                code, said = self.answer(mistake["file"], number)
                self.assertTrue((code == 2 and said.startswith(f"error: {self.folder / 'mistake'}")) or "warning: " in said, said)
                self.assertNotIn("textile.", said)
                for part in mistake["gets"]:
                    self.assertIn(part, said)
                if "mended" in mistake:
                    code, said = self.answer(mistake["mended"], number)
                    self.assertNotEqual(code, 2, said)

    def answer(self, text, number):
        file = self.folder / f"mistake_{number}.toml"
        file.write_text(f'preset = "sheet_3in_sphere"\n{text}')
        _, said, code = self.ran(lambda words: program.main(["run", *words]), str(file), "--steps", "1", "--no-report")
        return code, said

    def test_those_on_the_command_line_get_one_line_and_status_2_and_nothing_is_written(self):
        (self.folder / "shot.toml").write_text(SMALL)
        (self.folder / "locked").write_text("a file")
        for words in [
            ["fly"],
            ["run"],
            ["run", "no_preset"],
            ["run", "none.toml"],
            ["run", "."],
            ["run", "shot.toml", "--steps", "0"],
            ["run", "shot.toml", "--steps", "many"],
            ["run", "shot.toml", "--sample", "-1"],
            ["run", "shot.toml", "--until", "stopped"],
            ["run", "shot.toml", "--until", ""],
            ["run", "shot.toml", "another.toml"],
            ["run", "shot.toml", "--out", "locked/out"],
            ["run", "shot.toml", "--capsule", "no/folder/capsule"],
            ["run", "shot.toml", "--colour"],
            ["v50", "shot.toml", "--confidence", "1.5"],
            ["v50", "shot.toml", "--shots", "0"],
            ["v50", "shot.toml", "--low", "fast", "--high", "90"],
            ["v50", "shot.toml", "--low", "50"],
            ["v50", "shot.toml", "--plan", "90"],
            ["residual", "shot.toml", "--shots", "2"],
            ["replay", "shot.toml"],
            ["replay", "none"],
            ["fabrics", "denim"],
            ["scene", "none.toml"],
            ["fragments", "shot.toml", "--attitudes", "a=1,0,0,0", "a=0,1,0,0"],
        ]:
            with (
                self.subTest(words),
                contextlib.chdir(self.folder),
                contextlib.redirect_stderr(io.StringIO()) as errors,
                contextlib.redirect_stdout(io.StringIO()),
            ):
                with self.assertRaises(SystemExit) as left:
                    program.main(words)
                lines = [line for line in errors.getvalue().splitlines() if not line.startswith(("usage: ", " "))]
                self.assertEqual((left.exception.code, len(lines)), (2, 1), errors.getvalue())
                self.assertIn("error: ", lines[0])
                self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["locked", "shot.toml"])

    def test_a_reader_that_has_gone_is_no_traceback(self):
        (self.folder / "shot.toml").write_text(SMALL)
        run = ["run", "shot.toml", "--steps", "64", "--until", "none", "--no-report"]
        for words in [run, ["fabrics"], ["fabrics", "kevlar_km2_s706"], ["scene", "sheet_3in_sphere"], ["scene"]]:
            reader, writer = os.pipe()
            os.close(reader)
            done = subprocess.run([*PROGRAM, *words], stdout=writer, stderr=subprocess.PIPE, text=True, cwd=self.folder)
            os.close(writer)
            self.assertEqual((done.returncode, done.stderr), (141, ""), words)


class Catalogue(unittest.TestCase):
    def test_a_printed_scene_is_the_scene(self):
        for preset in fk.PRESETS:
            self.assertEqual(fk.Scene.parse(ran("scene", preset).stdout), fk.Scene(preset))

    def test_features_are_those_that_the_scene_asks_for(self):
        said = ran("scene", "--features", SCENES / "kevlar_km2_s706.toml").stdout
        scene = fk.Scene.read(SCENES / "kevlar_km2_s706.toml")
        self.assertIn("viscosity", scene.features())
        self.assertTrue(all(name in said for pair in scene.features().items() for name in pair))
        self.assertNotIn("plies", said)
        self.assertEqual(fk.Scene("sheet_3in_sphere", yarn={"stochastic": False}, track_detachment=False).features(), {})

    def test_fabrics_are_listed_and_shown_with_their_sources(self):
        listed = ran("fabrics").stdout
        self.assertIn("kevlar_km2_s706", listed)
        self.assertLessEqual(max(map(len, listed.splitlines())), 140)
        self.assertIn("[fabric]", ran("fabrics", "kevlar_km2_s706").stdout)

    def test_former_names_work_and_say_the_new_one(self):
        former = pathlib.Path(sys.executable).parent / "fabric-v50"
        done = subprocess.run([former, "--help"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, "fabric-v50 is now: fabric v50\n"))
        self.assertIn("usage: fabric v50", done.stdout)


if __name__ == "__main__":
    unittest.main()
