"""Ensembles: one table, bit for bit, whatever the workers, the order and the accidents."""

import contextlib
import functools
import json
import math
import os
import pathlib
import resource
import signal
import subprocess
import sys
import unittest.mock
import warnings

import fabric_kernel as fk
import numpy
import pandas
import scipy.stats
from commands import InFolder, wait_for
from fabric_kernel import plot
from fabric_kernel.ensembles import MOST_KEPT, each, kept
from fabric_kernel.fragments import answer, main
from fabric_kernel.runs import UNTIL

BASE = fk.Scene(sheet={"nodes_x": 41, "nodes_y": 41})
SCENES = fk.vary(BASE, 12, seed=1, speed=scipy.stats.uniform(30.0, 60.0), point=(scipy.stats.norm(0.0, 1e-4), 0.0))
# Those that are killed take a little longer.
FORTY = fk.vary(BASE, 40, seed=2)


@functools.cache
def forty():
    """The table of the forty."""
    return fk.ensemble(FORTY)


KILLED = """
import sys
import fabric_kernel as fk
if __name__ == "__main__":
    scenes = fk.vary(fk.Scene(sheet={"nodes_x": 41, "nodes_y": 41}), 40, seed=2)
    fk.ensemble(scenes, keep=sys.argv[1], on=2)
"""


def lines(path):
    return path.read_text().count("\n") if path.exists() else 0


def processes_of(session):
    """Processes of a session that have not ended."""
    found = []
    for path in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, _, its = path.read_text().rpartition(")")[2].split()[:4]
            if int(its) == session and state not in "ZX":
                found.append(int(path.parent.name))
    return found


def divided(job):
    return 1 / job


class Ensembles(InFolder):
    @classmethod
    def setUpClass(cls):
        cls.table = fk.ensemble(SCENES, on=1)

    def assert_same(self, table, other):
        self.assertTrue(table.equals(other))
        self.assertEqual(list(table.columns), list(other.columns))

    def test_a_row_is_the_run_of_its_scene(self):
        for index in (0, 7):
            row = json.loads(json.dumps(fk.fly(SCENES[index])))
            own = self.table.iloc[index]
            self.assertEqual(
                {name: own[name] for name in ("digest", "speed", "absorbed", "outcome")}.items() - row.items(), set()
            )
            self.assertEqual(own["seed"], SCENES[index]["seed"])
            self.assertEqual(own["projectile.velocity[2]"], SCENES[index]["projectile.velocity"][2])
        self.assertEqual(self.table["key"].nunique(), len(SCENES))
        balance = self.table["initial_kinetic"] - self.table["residual_kinetic"] - self.table["absorbed"]
        self.assertLess(balance.abs().max(), 1e-9)
        deepest = fk.history(SCENES[0], every=128)["max_deflection"].max()
        self.assertAlmostEqual(self.table["max_deflection"][0], deepest, delta=1e-12)
        self.assertEqual(self.table.attrs["units"]["max_deflection"], "m")

    def test_other_work_is_kept_too(self):
        keep = self.folder / "work.jsonl"
        self.assertEqual(each(divided, {"a": 2, "b": 4}, keep=keep, on=2), {"a": 0.5, "b": 0.25})
        # What is kept is not done again: a job under a kept key is not even looked at.
        self.assertEqual(each(divided, {"b": 0, "c": 8}, keep=keep, on=1), {"b": 0.25, "c": 0.125})
        with self.assertRaises(ZeroDivisionError):
            each(divided, {"d": 0}, keep=keep, on=1)
        self.assertEqual(len(keep.read_text().splitlines()), 3)

    def test_workers_order_and_batches(self):
        for workers, batch in [(2, 1), (5, 5)]:
            self.assert_same(fk.ensemble(SCENES, on=workers, batch=batch), self.table)
        order = numpy.random.default_rng(3).permutation(len(SCENES))
        shuffled = fk.ensemble([SCENES[k] for k in order])
        self.assert_same(shuffled.iloc[numpy.argsort(order)].reset_index(drop=True), self.table)
        twice = fk.ensemble([SCENES[0], SCENES[1], SCENES[0]])
        self.assertEqual(list(twice["digest"]), [self.table["digest"][k] for k in (0, 1, 0)])

    def test_what_is_kept_is_not_run_again(self):
        keep = self.folder / "runs.jsonl"
        fk.ensemble(SCENES[:5], keep=keep)
        # The mark shows where a result comes from; the next line was cut off when the writer was killed.
        kept = keep.read_text().splitlines(keepends=True)
        marked = kept[2].replace('"failure": null', '"failure": "kept"')
        keep.write_text("".join([*kept[:2], marked, kept[3], kept[4][:-20]]))
        table = fk.ensemble(SCENES, keep=keep, on=2)
        self.assertEqual(lines(keep), len(SCENES))
        self.assertEqual(table["failure"].notna().sum(), 1)
        table["failure"] = None
        self.assert_same(table.astype(self.table.dtypes), self.table)
        keep.write_text("something else\n")
        with self.assertRaisesRegex(ValueError, "line 1 is not a result"):
            fk.ensemble(SCENES, keep=keep)

    def test_what_is_no_file_of_results_is_left_alone(self):
        keep = self.folder / "notes.txt"
        for text in ("one line without an end", "x" * 200_000, '{"key": "a", "row": 1'):
            keep.write_text(text)
            if text.startswith("{"):
                self.assertEqual(list(kept(keep)), [])
                self.assertEqual(keep.read_text(), "")
            else:
                with self.assertRaisesRegex(ValueError, "notes.txt: line 1 is not a result of an ensemble"):
                    fk.ensemble(SCENES[:1], keep=keep)
                self.assertEqual(keep.read_text(), text)
        with self.assertRaisesRegex(ValueError, "is not a file"):
            fk.ensemble(SCENES[:1], keep=self.folder)
        with self.assertRaisesRegex(ValueError, "/dev/zero: is not a file"):
            fk.ensemble(SCENES[:1], keep="/dev/zero")
        with keep.open("wb") as file:
            file.truncate(MOST_KEPT + 1)
        with self.assertRaisesRegex(ValueError, "has 4294967297 bytes, and kept results may have 4294967296"):
            fk.ensemble(SCENES[:1], keep=keep)

    def begun(self, script=KILLED, **options):
        """The ensemble of the forty in another process, and the file that it writes."""
        keep = self.folder / "runs.jsonl"
        (self.folder / "script.py").write_text(script)
        return subprocess.Popen(
            [sys.executable, self.folder / "script.py", keep], stderr=subprocess.PIPE, text=True, **options
        ), keep

    def test_a_full_disk_is_told_and_loses_nothing(self):
        keep = self.folder / "runs.jsonl"
        fk.ensemble(SCENES[:1], keep=keep)
        first = keep.read_text()
        process, _ = self.begun(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2 * len(first),) * 2))
        _, said = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 1)
        self.assertRegex(said.splitlines()[-1], r"File too large: '.*runs\.jsonl'")
        self.assertTrue(keep.read_text().startswith(first))
        self.assert_same(fk.ensemble(SCENES, keep=keep), self.table)

    def test_killed_and_resumed(self):
        process, keep = self.begun(start_new_session=True)
        wait_for(lambda: lines(keep) >= 3)
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        before = lines(keep)
        self.assertLess(before, 40)
        table = fk.ensemble(FORTY, keep=keep)
        self.assertEqual(lines(keep), 40)
        self.assert_same(table, forty())

    def test_workers_end_with_their_parent(self):
        for method in ("fork", "spawn", "forkserver"):
            with self.subTest(method):
                start = f"    import multiprocessing; multiprocessing.set_start_method('{method}')\n    scenes"
                script = KILLED.replace("    scenes", start).replace("keep=", "progress=False, keep=")
                process, keep = self.begun(script, start_new_session=True)
                wait_for(lambda: lines(keep) >= 2)
                workers = processes_of(process.pid)
                self.assertGreaterEqual(len(workers), 3)
                process.kill()
                wait_for(lambda: process.poll() is not None and not processes_of(process.pid), seconds=30.0)
                process.communicate()
                keep.unlink()

    def test_a_local_worker_that_dies(self):
        process, keep = self.begun()
        wait_for(lambda: lines(keep) >= 3)
        children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        os.kill(int(children[0]), signal.SIGKILL)
        _, said = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, said)
        self.assertEqual(lines(keep), 40)
        self.assert_same(fk.ensemble(FORTY, keep=keep), forty())

    def test_a_scene_that_is_refused_is_shown(self):
        bad = BASE.replace({"projectile.mass": -1.0})
        with self.assertRaises(fk.Refused) as refused:
            fk.ensemble([*SCENES[:2], bad], on=2)
        self.assertEqual(refused.exception.field, "projectile.mass")
        self.assertIn("'projectile.mass': -1.0", "".join(refused.exception.__notes__))

    def test_a_run_that_fails_is_a_row(self):
        table = fk.ensemble([BASE, BASE.replace(contact_capacity=1)])
        self.assertEqual(list(table["outcome"]), ["exited", "failed"])
        self.assertEqual(table["failure"][1], "ContactCapacity")
        self.assertTrue(math.isnan(table["speed"][1]))

    def test_energy_that_slack_yarn_adds_is_told_while_a_run_goes_on(self):
        gains = fk.Scene(sheet={"nodes_x": 31, "nodes_y": 31}, time_step={"fraction": 0.5}).replace(
            {"projectile.velocity": (0.0, 0.0, 40.0)}
        )
        ends = []
        for warns, stride in ((True, 8000), (True, 7), (False, 8000)):
            simulation = fk.Simulation(gains, warns=warns)
            initial, seen = simulation.energy()["projectile_kinetic"], []
            while simulation.step_count < 8000:
                with warnings.catch_warnings(record=True) as told:
                    warnings.simplefilter("always")
                    simulation.run("exited", min(stride, 8000 - simulation.step_count))
                seen += [(simulation.step_count, str(one.message)) for one in told]
            self.assertEqual(len(seen), int(warns), seen)
            self.assertTrue(all("the energy residual is 1." in text and "segments are slack" in text for _, text in seen), seen)
            self.assertGreater(simulation.energy()["residual"], 0.01 * initial)
            ends.append((simulation.digest, seen and seen[0][1]))
        self.assertEqual(ends[0], ends[1])
        self.assertEqual(ends[0][0], ends[2][0])
        with self.assertWarnsRegex(RuntimeWarning, "^at .* us the energy residual is"):
            fk.fly(gains, steps=8000)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            fk.ensemble([gains], on=1, steps=8000)
        self.assertEqual(len([one for one in told if one.category is RuntimeWarning]), 1, told)

    def test_results_that_are_not_to_be_trusted_are_told_once(self):
        # With so much friction some solves of plies that lie on each other do not converge.
        rubs = fk.Scene(
            fabric={"name": "kevlar_km2_s706"},
            sheet={"nodes_x": 31, "nodes_y": 31},
            stack={"plies": 5},
            contact={"friction": 10.0},
        )
        rubs = rubs.replace({"projectile.velocity": (0.0, 0.0, 400.0)}).aimed()
        # The fine part ends beside the projectile.
        grading = {"largest": 8, "run": 1, "half_width": [7e-3, 7e-3]}
        beside = BASE.replace(sheet={"nodes_x": 61, "nodes_y": 61, "grading": grading}).aimed((4e-3, 0.0))
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            table = fk.ensemble([rubs, beside, SCENES[0], SCENES[1]], on=2, steps=600)
        texts = [str(one.message) for one in told if one.category is RuntimeWarning]
        self.assertEqual(len(texts), 2, texts)
        share = table["unconverged"] / table["steps"]
        self.assertEqual(list(share > 0.01), [True, False, False, False], table[["unconverged", "steps"]])
        self.assertEqual(list(table["beyond_fine"] > 0), [False, True, False, False])
        self.assertEqual(list(table["ply_penetration"] > 0.0), [True, False, False, False])
        self.assertTrue(
            texts[0].startswith("In 1 of 4 runs more than 1 % of the steps have a contact solve that did not converge"), texts
        )
        self.assertIn(f"at most {100 * share.max():.2g} %", texts[0])
        self.assertTrue(texts[1].startswith("In 1 of 4 runs the projectile met the sheet beyond the fine part"), texts)
        # One run says it too, and its simulation has the counter.
        with self.assertWarnsRegex(RuntimeWarning, "beyond the fine part"):
            row = fk.fly(beside, steps=600)
        simulation = fk.Simulation(beside)
        simulation.step(600)
        self.assertEqual(simulation.counters()["beyond_fine"], row["beyond_fine"])

    def test_a_scene_by_name_flies_and_a_pipe_that_closes_ends_a_command_quietly(self):
        self.assertEqual(fk.fly("sheet_3in_sphere", steps=50), fk.fly(fk.Scene(), steps=50))
        self.assertRaisesRegex(FileNotFoundError, 'no_preset: No such file, and no preset: .*"ring_40in"', fk.fly, "no_preset")
        (self.folder / "scene.toml").write_text(BASE.text())
        call = [
            sys.executable,
            "-c",
            "from fabric_kernel.fragments import main; main()",
            "scene.toml",
            "--velocities",
            "90",
            "--shots",
            "1",
        ]
        with subprocess.Popen(call, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
            program.stdout.close()
            said = program.stderr.read()
        self.assertEqual((program.returncode, "roken" in said or "Traceback" in said), (141, False), said)

    def test_runs_that_are_equal_because_nothing_is_drawn_are_told(self):
        cloth = fk.Scene(fabric={"name": "kevlar_km2_s706"}, sheet={"nodes_x": 31, "nodes_y": 31}).aimed()
        with self.assertWarnsRegex(RuntimeWarning, "^4 of 4 runs have the result of another run.*seed"):
            table = fk.ensemble(fk.vary(cloth, 4, seed=1), on=1, steps=300)
        self.assertEqual((table["seed"].nunique(), table["absorbed"].nunique()), (4, 1))
        self.assertGreater(table["absorbed"][0], 0.0)
        # Drawn yarn, a drawn point, a run asked for twice, and runs that meet nothing say nothing.
        far = cloth.replace({"projectile.position": (1.0, 0.0, -1.0)})
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            fk.ensemble([*SCENES[:3], SCENES[0]], on=1, steps=300)
            fk.ensemble(fk.vary(cloth, 3, seed=1, point=(scipy.stats.norm(0.0, 1e-4), 0.0)), on=1, steps=300)
            fk.ensemble(fk.vary(far, 2, seed=1), on=1, steps=300)

    def test_draws(self):
        longer = fk.vary(BASE, 15, seed=1, speed=scipy.stats.uniform(30.0, 60.0), point=(scipy.stats.norm(0.0, 1e-4), 0.0))
        self.assertEqual(longer[:12], SCENES)
        speeds = [math.hypot(*scene["projectile.velocity"]) for scene in longer]
        self.assertTrue(all(30.0 <= speed <= 90.0 for speed in speeds) and len(set(speeds)) == 15)
        cylinder = BASE.replace(projectile={"shape": "cylinder", "length": 0.02})
        tilted = fk.vary(cylinder, 9, seed=1, tilt=0.3, parameters={"projectile.mass": [0.01, 0.02]})
        for scene in tilted:
            _w, x, y, _z = scene["projectile.orientation"]
            # The body's axis, turned by 0.3 away from the velocity.
            self.assertAlmostEqual(1.0 - 2.0 * (x * x + y * y), math.cos(0.3), places=12)
            self.assertIn(scene["projectile.mass"], (0.01, 0.02))
        for given, name in (
            ({"speed": []}, "speed"),
            ({"speed": "50"}, "speed"),
            ({"speed": scipy.stats.norm(50.0, math.inf)}, "speed"),
            ({"tilt": math.nan}, "tilt"),
            ({"point": ([], 0.0)}, "point"),
            ({"parameters": {"projectile.mass": []}}, "projectile.mass"),
            ({"count": -1}, "count"),
            ({"seed": -1}, "seed"),
            ({"parameters": {"projectile.mass": scipy.stats.norm(1.0, math.inf)}}, "projectile.mass"),
            ({"speed": 50.0, "parameters": {"projectile.velocity": (0.0, 0.0, 40.0)}}, "speed"),
            ({"attitude": "random", "parameters": {"projectile.orientation": (1.0, 0.0, 0.0, 0.0)}}, "attitude"),
        ):
            with self.assertRaisesRegex(ValueError, f"^{name}: must be"):
                fk.vary(BASE, **{"count": 2, "seed": 1} | given)
        # Axes of bodies in any attitude are spread evenly: their heights are uniform in [-1, 1].
        random = fk.vary(cylinder, 400, seed=5, attitude="random")
        heights = [1.0 - 2.0 * (q[1] ** 2 + q[2] ** 2) for q in (scene["projectile.orientation"] for scene in random)]
        self.assertGreater(scipy.stats.kstest(heights, scipy.stats.uniform(-1.0, 2.0).cdf).pvalue, 0.01)

    def test_a_run_goes_on_with_the_torn_cloth(self):
        """A cylinder on Kevlar KM2 held on two sides carries cloth that is torn off and still slows it."""
        scene = fk.Scene(
            fabric={"name": "kevlar_km2_s706"},
            sheet={"nodes_x": 61, "nodes_y": 61},
            attachment={"kind": "two_sides"},
            projectile={"shape": "cylinder", "radius": 4e-3, "length": 20e-3, "mass": 8.4e-3, "velocity": [0.0, 0.0, 80.0]},
        ).aimed()
        short = fk.fly(scene, until=[*UNTIL, "detached"])
        row = fk.fly(scene, steps=2 * short["steps"])
        self.assertEqual((short["outcome"], short["stopped"], short["time"]), ("detached", False, short["detached"]))
        # However it ends, it ends later, and went through.
        self.assertEqual((row["stopped"], row["detached"]), (False, short["detached"]))
        self.assertGreater(row["steps"], short["steps"])
        self.assertNotEqual(row["speed"], short["speed"])
        if row["steps"] == 2 * short["steps"]:
            self.assertEqual(row["outcome"], "detached")

    def test_what_cannot_be_drawn_or_run(self):
        with self.assertRaisesRegex(ValueError, "count"):
            fk.vary(BASE, -3, seed=1)
        with self.assertRaisesRegex(ValueError, "speed: must be greater than 0"):
            fk.vary(BASE, 1, seed=1, speed=-5.0)
        with self.assertRaisesRegex(TypeError, "scenes: must be a list"):
            fk.ensemble(BASE)


class Fragments(InFolder):
    def test_a_miss_is_no_perforation(self):
        # Aimed at an edge and away from it: half of the shots pass.
        small = BASE.replace(projectile={"velocity": [0.0, 0.0, 50.0]})
        row = fk.fly(small.replace({"projectile.position": (0.1, 0.0, -0.01)}))
        self.assertEqual((row["outcome"], row["stopped"]), ("passed", None))
        with self.assertRaisesRegex(fk.Refused, "point: .* lies beside the sheet") as refused:
            fk.fragment_map(BASE, velocities=[50.0], attitudes={"random": "random"}, points=[(15.0, 15.0)])
        self.assertEqual(refused.exception.field, "point")
        rows = {"outcome": ["passed", "exited"], "stopped": [None, False], "speed": [50.0, 30.0]}
        rows |= {"residual_kinetic": [1.0, 0.5], "absorbed": [0.0, 0.5], "viscous": [0.0, 0.1]}
        with unittest.mock.patch("fabric_kernel.fragments.ensemble", return_value=pandas.DataFrame(rows)):
            cell = fk.fragment_map(BASE, velocities=[50.0], attitudes={"random": "random"}, shots=2).iloc[0]
        self.assertEqual((cell["through"], cell["missed"], cell["unknown"], cell["perforation"]), (1, 1, 0, 1.0))
        # One shot of one: 0.025 from below.
        self.assertAlmostEqual(cell["low"], 0.025, places=12)

    def test_the_command(self):
        for words, told in (
            (["--velocities", "-5"], "must be a number above 0; it is -5"),
            (["--velocities", "50", "--attitudes", "side=1,2"], "must have 4 numbers"),
            (["--velocities", "50", "--points", "15,15"], "point: (15, 15) m lies beside the sheet"),
            (["--attitudes", "a=1,0,0,0", "a=0,1,0,0"], "--attitudes: must be a name given once each; it is a a"),
            (["--attitudes", "=1,0,0,0"], "attitudes: must be one or more, by a name each"),
            (["--attitudes", "random=1,0,0,0"], '"random" is the name of'),
        ):
            self.assertIn(told, self.ran(main, "sheet_3in_sphere", *words)[1].splitlines()[-1])
        said, _, _ = self.ran(
            main, "sheet_3in_sphere", "--velocities", "200", "200", "--points", "0,0", "0,0", "--shots", "1", "--on", "1"
        )
        self.assertEqual(len((self.folder / "out/table.csv").read_text().splitlines()), 2)
        for twice in ("velocities: 200.0 is given 2 times and shot once.", "points: (0.0, 0.0) is given 2 times and shot once."):
            self.assertIn(twice, said)
            self.assertIn(twice, (self.folder / "out/report.html").read_text())
        for text in (said, (self.folder / "out/map.svg").read_text()):
            self.assertIn("Projectile: sphere", text)
            self.assertIn("Not validated", text)

    def test_without_velocities_a_map_has_both_colours(self):
        said, _, _ = self.ran(main, BASE, "--shots", "2")
        table = pandas.read_csv(self.folder / "out/table.csv")
        self.assertIn("Velocities about the limits that were bracketed", said)
        self.assertIn("residual_speed_sd_m_per_s", table.columns)
        shares = list(table["perforation"])
        self.assertEqual((len(shares), shares[0], shares[-1]), (5, 0.0, 1.0))

    def test_table_and_picture(self):
        cylinder = BASE.replace(projectile={"shape": "cylinder", "length": 0.01, "radius": 4e-3, "mass": 4e-3})
        attitudes = {"end on": (1.0, 0.0, 0.0, 0.0), "random": "random"}
        options = {"velocities": [2.0, 300.0], "attitudes": attitudes, "shots": 3, "steps": 40_000}
        table = fk.fragment_map(cylinder, keep=self.folder / "runs.jsonl", **options)
        plot.map(table, self.folder / "map.svg")
        self.assertGreater((self.folder / "map.svg").stat().st_size, 5000)
        slow, fast = table[table["velocity"] == 2.0], table[table["velocity"] == 300.0]
        self.assertEqual((list(slow["perforation"]), list(fast["perforation"])), ([0.0, 0.0], [1.0, 1.0]))
        # Exact intervals of 0 and 3 of 3, from the binomial distribution: 1 - 0.025^(1/3).
        numpy.testing.assert_allclose(slow["high"], 1.0 - 0.025 ** (1.0 / 3.0), rtol=1e-9)
        numpy.testing.assert_allclose(fast["low"], 0.025 ** (1.0 / 3.0), rtol=1e-9)
        self.assertTrue((fast["residual_speed"] < 300.0).all() and (fast["residual_speed_sd"] > 0.0).all())

        self.assertEqual(
            [line.partition(" mm: ")[2] for line in answer(table)],
            2 * ["none of 3 shots goes through up to 2 m/s, all 3 do from 300 m/s on."],
        )
        upside_down = table.assign(through=8 * table["stopped"], stopped=8 * table["through"])
        self.assertEqual(["does not grow with the velocity" in line for line in answer(upside_down)], [True, False, True, False])

    def test_what_a_map_refuses_and_says(self):
        sound = {"velocities": [200.0], "attitudes": {"flat": (1.0, 0.0, 0.0, 0.0)}, "shots": 1}
        for given, name in (
            ({"velocities": []}, "velocities"),
            ({"velocities": [math.nan]}, "velocities"),
            ({"attitudes": {}}, "attitudes"),
            ({"shots": 0}, "shots"),
            ({"attitudes": {" ": "random"}}, "attitudes"),
            ({"attitudes": {"random": (1.0, 0.0, 0.0, 0.0)}}, "attitudes"),
            ({"confidence": 2.0}, "confidence"),
        ):
            with self.assertRaisesRegex(ValueError, f"^{name}.*: must be"):
                fk.fragment_map(BASE, **sound | given)
        with self.assertWarnsRegex(RuntimeWarning, "velocities: 200.0 is given 2 times"):
            self.assertEqual(len(fk.fragment_map(BASE, steps=10, **sound | {"velocities": [200.0, 200.0]})), 1)

    def test_what_is_not_known_widens_the_interval(self):
        options = {"velocities": [100.0], "attitudes": {"as given": (1.0, 0.0, 0.0, 0.0)}, "shots": 2}
        table = fk.fragment_map(BASE, steps=10, **options)
        self.assertEqual((table["unknown"][0], table["low"][0], table["high"][0]), (2, 0.0, 1.0))
        self.assertEqual(answer(table), ["as given at (0, 0) mm: no shot has a known end."])
