"""The ballistic limit of a scene: shots that can be repeated, kept shots, and the command."""

import json
import resource
import subprocess
import sys
from unittest import mock

from commands import InFolder
from fabric_kernel import Refused, Scene, fly, vary
from fabric_kernel.about import attachments, cautions
from fabric_kernel.designs import Plan
from fabric_kernel.v50 import Shooter, Unknown, at, main, v50


class OfAScene(InFolder):
    def scene(self):
        return Scene("sheet_3in_sphere", sheet={"nodes_x": 41, "nodes_y": 41}, projectile={"velocity": [0.0, 0.0, 50.0]})

    def test_a_shot_is_that_of_its_number(self):
        shoot = Shooter(self.scene(), seed=3, point=None)
        stopped, residual = shoot(70.0, 2)
        row = fly(vary(self.scene(), 3, seed=3, speed=70.0)[2], until=Shooter.UNTIL, steps=1_000_000)
        self.assertEqual((stopped, residual), (row["stopped"], row["speed"]))
        self.assertEqual(
            shoot.notes()[-1],
            f"The viscosity of the yarn dissipated {100 * row['viscous'] / row['absorbed']:.0f} % of the absorbed energy.",
        )
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
        self.assertIn("1 of 1 shots that went through ended when held yarn could not stop them", " ".join(decided.notes()))

    def test_the_report_says_what_is_not_to_be_trusted(self):
        shoot = Shooter(self.scene(), seed=3)
        shoot(70.0, 0), shoot(70.0, 1)
        row = list(shoot.made.values())[1]
        self.assertEqual((row["unconverged"], row["ply_penetration"], row["beyond_fine"]), (0, 0.0, 0))
        row["unconverged"] = row["steps"] // 4
        self.assertRegex(shoot.notes()[0], r"^In 1 of 2 runs more than 1 % of the steps .* at most 25 %\)")

    def test_the_report_names_sharp_edges_of_fast_shots(self):
        flat = Scene(
            "sheet_3in_sphere",
            sheet={"nodes_x": 31, "nodes_y": 31},
            fabric={"name": "kevlar_km2_s706"},
            projectile={"shape": "cylinder", "length": 0.005},
        )
        for scene, velocity, named in [(flat, 400.0, True), (flat, 100.0, False), (self.scene(), 400.0, False)]:
            shoot = Shooter(scene)
            shoot(velocity, 0)
            self.assertEqual(any("edges are sharp" in note for note in shoot.notes()), named)

    def test_too_few_steps_are_an_error_that_names_the_shot(self):
        with self.assertRaisesRegex(RuntimeError, "shot 1 at 70 m/s: timeout after 10 steps"):
            Shooter(self.scene(), steps=10)(70.0, 0)

    def test_the_command_goes_on_where_it_was(self):
        words = ("--low", "20", "--high", "60", "--deviation", "2")
        first, test = self.said(self.scene(), *words, "--shots", "4")
        kept = (self.folder / "out/runs.jsonl").read_text()
        second, test = self.said(self.scene(), *words, "--shots", "6")
        # The four shots are not shot again, and two are new; and 15 below the limit each time.
        again = (self.folder / "out/runs.jsonl").read_text()
        self.assertTrue(again.startswith(kept))
        self.assertEqual([len(kept.splitlines()), len(again.splitlines())], [19, 36])
        shots = [line.replace("of 4:", "of 6:") + ", kept from before" for line in first.splitlines()[:4]]
        self.assertEqual(shots, second.splitlines()[:4])
        self.assertNotIn("kept", second.splitlines()[4])
        self.assertEqual(len(test["shots"]), 6)

    def said(self, scene, *words, out="out"):
        """What the command prints for a scene, and what it writes, as numbers."""
        said, errors, code = self.ran(main, scene, "--tests", "0", *words, out=out)
        self.assertEqual(code, 0, errors)
        return said, json.loads((self.folder / out / "test.json").read_text())

    def test_the_first_command_answers_from_any_velocity(self):
        found = []
        for first in (5.0, 50.0, 500.0):
            said, test = self.said(self.scene().replace({"projectile.velocity": (0.0, 0.0, first)}), out=f"{first}")
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
        # A ball that is larger than the sheet rests on the nodes that are held; a heavy body goes through at any velocity.
        for changes, steps, stops, last, bound in (
            ({"projectile.radius": 0.05, "projectile.mass": 1.0}, "20000", True, max, "V99  none +above"),
            ({"projectile.mass": 1e6}, "40000", False, min, "V01  none +below"),
        ):
            scene = self.scene().replace(changes, sheet={"nodes_x": 31, "nodes_y": 31})
            said, test = self.said(scene, "--steps", steps, out=steps)
            self.assertEqual({shot["stopped"] for shot in test["shots"]}, {stops})
            self.assertIn("without a V50", said)
            self.assertRegex(said, f"{bound} {last(shot['velocity'] for shot in test['shots']):.1f}")

    def test_a_velocity_that_the_time_step_refuses_ends_a_bracket(self):
        shoot = Shooter(self.scene())
        with self.assertRaisesRegex(Unknown, "shot 2 at 1e[+]06 m/s: projectile.velocity"):
            shoot(1e6, 1)
        # The first one is the scene's own.
        with self.assertRaises(Refused):
            shoot(1e6, 0)

    def test_the_report_says_what_is_drawn(self):
        uniform = {"yarn.stochastic": False}
        weibull = {"yarn.strength_draw": "weibull"}
        for changes, told in (
            ({}, "yarns sampled for each"),
            (uniform, "the same yarns in each"),
            (uniform | weibull, "yarns sampled for each"),
        ):
            scene = self.scene().replace(changes)
            self.assertIn(f"seed 4, {told}", Shooter(scene, seed=4).drawn())
        self.assertIn("as the scene says", Shooter(self.scene(), point=None).drawn())
        said, test = self.said(self.scene().replace(uniform), "--design", "plan", "--plan", "200")
        self.assertIn("the same yarns in each, as the scene samples none", said)
        self.assertNotIn("yarns drawn", said + test["seeds"])

    def test_the_share_at_a_velocity_has_its_exact_interval(self):
        found = at(lambda velocity, shot: (shot % 4 > 0, 5.0), 80.0, 20, 0.95)
        # Clopper and Pearson for 5 of 20: quantiles of the beta distributions (5, 16) and (6, 15).
        self.assertEqual((found["through"], found["shots"], found["share"]), (5, 20, 0.25))
        self.assertAlmostEqual(found["low"], 0.08657, 4)
        self.assertAlmostEqual(found["high"], 0.49105, 4)
        said, errors, code = self.ran(main, self.scene(), "--at", "300", "--shots", "3")
        self.assertEqual((code, errors), (0, ""))
        self.assertIn("At 300 m/s 3 of 3 shots went through: 100 %, 95 % interval [29.2, 100.0] %", said)
        self.assertEqual(json.loads((self.folder / "out" / "at.json").read_text())["through"], 3)

    def test_a_report_that_cannot_be_written_is_an_error_and_not_half_there(self):
        words = [
            sys.executable,
            "-m",
            "fabric_kernel.v50",
            "sheet_3in_sphere",
            "--design",
            "plan",
            "--plan",
            "200",
            "--tests",
            "0",
            "--out",
            self.folder,
        ]
        subprocess.run(words, check=True, capture_output=True)
        before = {path.name: path.read_bytes() for path in self.folder.iterdir()}
        (self.folder / "test.json").unlink()
        # A file may not be larger than a part of the picture, as on a disk that is full.
        small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (len(before["plot.svg"]) // 2,) * 2)
        done = subprocess.run([*words, "--confidence", "0.9"], capture_output=True, text=True, preexec_fn=small)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"^error: .*File too large: '.*plot\.svg'\n$")
        after = {path.name: path.read_bytes() for path in self.folder.iterdir()}
        self.assertEqual(after, {key: value for key, value in before.items() if key != "test.json"})

    def test_a_bad_argument_is_told_in_one_line(self):
        at_rest = self.scene().replace({"projectile.velocity": (0.0, 0.0, 0.0)})
        for scene, words, told in (
            (self.scene(), ["--low", "60", "--high", "20"], "low"),
            (self.scene(), ["--design", "plan"], "velocities"),
            (self.scene(), ["--shots", "0"], "shots"),
            (self.scene(), ["--low", "60"], "--low, --high: one goes with the other"),
            (self.scene(), ["--aim", "0.01"], "--aim goes with --design three-phase"),
            (self.scene(), ["--design", "three-phase", "--last", "3"], "--aim"),
            (at_rest, [], "error: projectile.velocity: must not be "),
            ("no.toml", [], "no.toml: No such file"),
        ):
            _, errors, code = self.ran(main, scene, *words, out=told)
            self.assertEqual((code, len(errors.splitlines())), (2, 1), errors)
            self.assertIn(told, errors)
            self.assertFalse((self.folder / told / "runs.jsonl").exists())
        # argparse tells the usage, too.
        self.assertIn("--low: must be a number above 0; it is -1", self.ran(main, self.scene(), "--low", "-1")[1])

    def test_a_report_says_what_was_shot_at(self):
        said, _ = self.said("sheet_10in_cylinder", "--design", "plan", "--plan", "200")
        page = (self.folder / "out/report.html").read_text()
        for text in ("sheet_10in_cylinder, ", "held: two sides", "Projectile: ", "mass ", "scene ", "Not validated"):
            self.assertIn(text, said)
            self.assertIn(text, page)

    def test_a_page_begins_with_the_answer(self):
        for scene, own, others in (
            (self.scene(), "that of the source paper", "On Cunniff's axes"),
            (
                Scene("sheet_3in_sphere", fabric={"name": "kevlar_km2_s706"}, sheet={"nodes_x": 31, "nodes_y": 31}),
                "On Cunniff's axes",
                "that of the source paper",
            ),
        ):
            test = v50(Shooter(scene), Plan([200.0]), 1, tests=0)
            page = test.page(b"<svg/>")
            places = [
                page.index(words)
                for words in (
                    "V50 not bounded by these shots",
                    "Of the model against tests",
                    "a sheet of this width",
                    "hold every yarn without limit (hold 0 N",
                    "<details>",
                    "Projectile:",
                    own,
                )
            ]
            self.assertEqual(places, sorted(places))
            self.assertNotIn(others, page)
            self.assertIn("not varied: fragment, fabric, support, attitude, angle of impact", page)

    def test_a_report_says_what_was_assumed_of_the_attachments(self):
        scene = Scene("sheet_3in_sphere", fabric={"name": "kevlar_km2_s706"}, sheet={"nodes_x": 31, "nodes_y": 31})
        slips = scene.replace(attachment={"hold": "0.4 of the yarn", "grip": "10 mm", "strength": "500 N"})
        for one, words in (
            (scene, "without limit (hold 0 N; a bar breaks at 146.6 N); none fails as a whole."),
            (
                slips,
                "slip at 58.63 N a bar, 0.40 of the 146.6 N at which it breaks, with 10 mm of yarn in the grip; each fails at "
                "500 N.",
            ),
            (scene.replace({"attachment.kind": "free"}), "No attachments"),
        ):
            self.assertIn(words, attachments(one))
            self.assertEqual(attachments(one), cautions(one)[1])

    def test_an_interrupt_tells_how_to_go_on(self):
        with mock.patch("fabric_kernel.v50.v50", side_effect=KeyboardInterrupt):
            _, errors, code = self.ran(main, "sheet_3in_sphere")
        self.assertEqual(code, 130)
        self.assertIn("the same command goes on", errors)
