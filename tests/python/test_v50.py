"""The ballistic limit of a scene: shots that can be repeated, kept shots, and the command."""

import json
import math
import pickle
import re
import resource
import subprocess
import sys
from unittest import mock

import fabric_kernel as fk
import pytest
from commands import called
from fabric_kernel import Refused, Scene, fly, results, vary
from fabric_kernel.about import attachments, cautions
from fabric_kernel.designs import Plan
from fabric_kernel.notes import Note
from fabric_kernel.v50 import Shooter, Unknown, at, main, v50


def small_scene():
    return Scene("sheet_3in_sphere", sheet={"nodes_x": 41, "nodes_y": 41}, projectile={"velocity": [0.0, 0.0, 50.0]})


def test_a_shot_is_that_of_its_number():
    shoot = Shooter(small_scene(), seed=3, point=None)
    stopped, residual = shoot(70.0, 2)
    row = fly(vary(small_scene(), 3, seed=3, speed=70.0)[2], until=Shooter.UNTIL, steps=1_000_000)
    assert (stopped, residual) == (row.stopped, row.speed)
    assert (
        shoot.notes()[-1]
        == f"The viscosity of the yarn dissipated {100 * row.viscous / row.absorbed:.0f} % of the absorbed energy."
    )
    assert shoot.warnings() == []
    # Within a mesh about the middle: another point, the same for each call.
    about = Shooter(small_scene(), seed=3)
    assert about(70.0, 2) == about(70.0, 2)
    assert about(70.0, 2) != about(70.0, 1)


def test_a_shot_ends_when_it_is_decided():
    decided, ended = Shooter(small_scene(), seed=3), Shooter(small_scene(), seed=3, to_the_end=True)
    assert (decided(70.0, 2)[0], ended(70.0, 2)[0]) == (False, False)
    (row,), (whole,) = decided.made.values(), ended.made.values()
    assert (row["outcome"], "through" in whole["outcome"]) == ("through", False)
    assert row["steps"] < whole["steps"]
    assert "1 of 1 shots that went through ended when held yarn could not stop them" in " ".join(decided.notes())


def test_the_report_says_what_is_not_to_be_trusted():
    shoot = Shooter(small_scene(), seed=3)
    shoot(70.0, 0), shoot(70.0, 1)
    row = list(shoot.made.values())[1]
    assert (row["unconverged"], row["ply_penetration"], row["beyond_fine"]) == (0, 0.0, 0)
    row["unconverged"] = row["steps"] // 4
    assert re.search(r"^In 1 of 2 runs more than 1 % of the steps .* at most 25 %\)", shoot.warnings()[0])


def test_the_report_names_sharp_edges_of_fast_shots():
    flat = Scene(
        "sheet_3in_sphere",
        sheet={"nodes_x": 31, "nodes_y": 31},
        fabric={"name": "kevlar_km2_s706"},
        projectile={"shape": "cylinder", "length": 0.005},
    )
    for scene, velocity, named in [(flat, 400.0, True), (flat, 100.0, False), (small_scene(), 400.0, False)]:
        shoot = Shooter(scene)
        shoot(velocity, 0)
        assert any("edges are rounded by half the thickness" in note for note in shoot.warnings()) == named


def test_too_few_steps_are_an_error_that_names_the_shot():
    with pytest.raises(RuntimeError, match="shot 1 at 70 m/s: timeout after 10 steps"):
        Shooter(small_scene(), steps=10)(70.0, 0)


def test_the_command_goes_on_where_it_was(tmp_path):
    words = ("--low", "20", "--high", "60", "--deviation", "2")
    first, test = answered(tmp_path, small_scene(), *words, "--shots", "4")
    kept = (tmp_path / "out/runs.jsonl").read_text()
    second, test = answered(tmp_path, small_scene(), *words, "--shots", "6")
    # The four shots are not shot again, and two are new; and 15 below and above the limit each time.
    again = (tmp_path / "out/runs.jsonl").read_text()
    assert again.startswith(kept)
    assert [len(kept.splitlines()), len(again.splitlines())] == [34, 66]
    shots = [line.replace("of 4:", "of 6:") + ", kept from before" for line in first.splitlines()[:4]]
    assert shots == second.splitlines()[:4]
    assert "kept" not in second.splitlines()[4]
    assert len(test["shots"]) == 6


def answered(tmp_path, scene, *words, out="out"):
    """What the command prints for a scene, and what it writes, as numbers."""
    said, errors, code = called(tmp_path, main, scene, "--simulated", "0", "--no-network", *words, out=out)
    assert code == 0, errors
    return said, json.loads((tmp_path / out / "test.json").read_text())


def test_the_first_command_answers_from_any_velocity(tmp_path):
    found = []
    for first in (5.0, 50.0, 500.0):
        said, test = answered(tmp_path, small_scene().replace({"projectile.velocity": (0.0, 0.0, first)}), out=f"{first}")
        assert test["shots"][0]["velocity"] == first
        assert [shot["stopped"] for shot in test["shots"][:7]].count(test["shots"][0]["stopped"]) <= 6
        low, high = (test["fit"]["intervals"][1][end] for end in ("low", "high"))
        assert low < test["fit"]["mu"]
        assert test["fit"]["mu"] < high
        assert f"steps by a factor of 2 from {first:g} m/s" in said
        found.append((low, high))
    # They are intervals of one V50.
    assert max(low for low, _ in found) < min(high for _, high in found)


def test_a_sheet_that_always_stops_and_one_that_never_does(tmp_path):
    # A ball that is larger than the sheet rests on the nodes that are held; a heavy body goes through at any velocity.
    for changes, steps, stops, last, bound in (
        ({"projectile.radius": 0.05, "projectile.mass": 1.0}, "20000", True, max, "V99  none +above"),
        ({"projectile.mass": 1e6}, "40000", False, min, "V01  none +below"),
    ):
        scene = small_scene().replace(changes, sheet={"nodes_x": 31, "nodes_y": 31})
        said, test = answered(tmp_path, scene, "--steps", steps, out=steps)
        assert {shot["stopped"] for shot in test["shots"]} == {stops}
        assert "without a V50" in said
        assert re.search(f"{bound} {last(shot['velocity'] for shot in test['shots']):.1f}", said)


def test_a_velocity_that_the_time_step_refuses_ends_a_bracket():
    shoot = Shooter(small_scene())
    with pytest.raises(Unknown, match="shot 2 at 1e[+]06 m/s: projectile.velocity"):
        shoot(1e6, 1)
    # The first one is the scene's own.
    with pytest.raises(Refused):
        shoot(1e6, 0)


def test_the_report_says_what_is_drawn(tmp_path):
    uniform = {"yarn.stochastic": False}
    weibull = {"yarn.strength_draw": "weibull"}
    for changes, told in (
        ({}, "yarns sampled for each"),
        (uniform, "the same yarns in each"),
        (uniform | weibull, "yarns sampled for each"),
    ):
        scene = small_scene().replace(changes)
        assert f"seed 4, {told}" in Shooter(scene, seed=4).drawn()
    assert "as the scene says" in Shooter(small_scene(), point=None).drawn()
    said, test = answered(tmp_path, small_scene().replace(uniform), "--design", "plan", "--plan", "200")
    assert "the same yarns in each, as the scene samples none" in said
    assert "yarns drawn" not in said + test["seeds"]


def test_the_share_at_a_velocity_has_its_exact_interval(tmp_path):
    found = at(lambda velocity, shot: (shot % 4 > 0, 5.0), 80.0, 20, 0.95)
    # Clopper and Pearson for 5 of 20: quantiles of the beta distributions (5, 16) and (6, 15).
    assert (found.through, len(found.shots), found.share) == (5, 20, 0.25)
    assert found.low == pytest.approx(0.08657, rel=0, abs=5e-5)
    assert found.high == pytest.approx(0.49105, rel=0, abs=5e-5)
    said, errors, code = called(tmp_path, main, small_scene(), "--at", "300", "--shots", "3")
    assert (code, errors) == (0, "")
    assert "At 300 m/s 3 of 3 shots went through: 100 %, 95 % interval [29.2, 100.0] %" in said
    assert json.loads((tmp_path / "out" / "at.json").read_text())["through"] == 3
    assert "At 300 m/s 3 of 3" in (tmp_path / "out" / "report.html").read_text()
    # As the report advises.
    said, _, code = called(tmp_path, main, small_scene(), "--at", "300", "--shots", "3", "--to-the-end", out="end")
    assert (code, "--to-the-end" in said) == (0, False)
    _, errors, code = called(tmp_path, main, small_scene(), "--at", "300", "--simulated", "1000", out="none")
    assert (code, errors) == (2, "error: --simulated: goes without --at, which finds no limit\n")


def test_a_share_of_shots_that_are_alike_is_one_result_and_an_unknown_shot_loses_no_other():
    alike = small_scene().replace({"yarn.stochastic": False})
    one = at(Shooter(alike, point=None), 300.0, 20)
    assert (len(one.shots), one.share, one.low, one.high) == (1, 1.0, 1.0, 1.0)
    assert "this is the result of every shot" in one.answer[0]
    assert len(at(Shooter(alike), 300.0, 2).shots) == 2

    def shoot(velocity, shot):
        if shot == 1:
            raise Unknown("shot 2")
        return shot == 0, 5.0

    found = at(shoot, 80.0, 4)
    assert (found.through, found.unknown, found.share) == (2, 1, 2 / 3)
    # The unknown shot stopped: 2 of 4, quantile 0.025 of beta (2, 3); through: 3 of 4, quantile 0.975 of beta (4, 1).
    assert (found.low, found.high) == pytest.approx((0.06759, 0.975 ** (1 / 4)), rel=0, abs=5e-5)


@pytest.mark.parametrize(
    "result", [(None, 0.0), (math.nan, 0.0), ("stopped", 0.0), (False, math.nan), (False, None), (False, -1.0)]
)
def test_a_result_that_is_neither_stopped_nor_through_is_refused(result):
    for shots in (lambda shoot: v50(shoot, Plan([60.0, 70.0]), 2, tests=0), lambda shoot: at(shoot, 60.0, 2)):
        with pytest.raises(ValueError, match="^shoot.*must be"):
            shots(lambda velocity, shot: result)


def test_a_report_that_cannot_be_written_is_an_error_and_not_half_there(tmp_path):
    words = f"-m fabric_kernel.program v50 sheet_3in_sphere --design plan --plan 200 --simulated 0 --out {tmp_path}".split()
    subprocess.run([sys.executable, *words], check=True, capture_output=True)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    (tmp_path / "test.json").unlink()
    # A file may not be larger than a part of the picture, as on a disk that is full.
    small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (len(before["plot.svg"]) // 2,) * 2)
    done = subprocess.run([sys.executable, *words, "--confidence", "0.9"], capture_output=True, text=True, preexec_fn=small)
    assert done.returncode == 1
    assert re.search(r"^error: .*plot\.svg: File too large\n$", done.stderr)
    after = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert after == {key: value for key, value in before.items() if key != "test.json"}


def test_a_bad_argument_is_told_in_one_line(tmp_path):
    at_rest = small_scene().replace({"projectile.velocity": (0.0, 0.0, 0.0)})
    for scene, words, told in (
        (small_scene(), ["--low", "60", "--high", "20"], "low"),
        (small_scene(), ["--design", "plan"], "velocities"),
        (small_scene(), ["--shots", "0"], "shots"),
        (small_scene(), ["--low", "60"], "--low, --high: one goes with the other"),
        (small_scene(), ["--within", "much %"], "--within: must be a part of V50 or a speed"),
        (small_scene(), ["--aim", "0.01"], "--aim goes with --design three-phase"),
        (small_scene(), ["--design", "three-phase", "--last", "3"], "--aim"),
        (at_rest, [], "error: projectile.velocity: must not be "),
        ("no.toml", [], "no.toml: No such file"),
    ):
        _, errors, code = called(tmp_path, main, scene, *words, out=told)
        assert (code, len(errors.splitlines())) == (2, 1), errors
        assert told in errors
        assert not (tmp_path / told / "runs.jsonl").exists()
    # argparse tells the usage, too.
    assert "--low: must be a number above 0; it is -1" in called(tmp_path, main, small_scene(), "--low", "-1")[1]


def test_a_report_says_what_was_shot_at(tmp_path):
    said, _ = answered(tmp_path, "sheet_10in_cylinder", "--design", "plan", "--plan", "200")
    page = (tmp_path / "out/report.html").read_text()
    for text in ("sheet_10in_cylinder, ", "held: two sides", "Projectile: ", "mass ", "scene ", "Not validated"):
        assert text in said
        assert text in page


def test_a_page_begins_with_the_answer():
    for scene, own, others in (
        (small_scene(), "that of the source paper", "On Cunniff's axes"),
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
                "hold every yarn without limit (no hold is set",
                "<details>",
                "Projectile:",
                own,
            )
        ]
        assert places == sorted(places)
        assert others not in page
        assert "not varied: fragment, fabric, support, attitude, angle of impact" in page


def test_a_report_says_what_was_assumed_of_the_attachments():
    scene = Scene("sheet_3in_sphere", fabric={"name": "kevlar_km2_s706"}, sheet={"nodes_x": 31, "nodes_y": 31})
    slips = scene.replace(attachment={"hold": "0.4 of the yarn", "grip": "10 mm", "strength": "500 N"})
    for one, words in (
        (scene, "without limit (no hold is set; a bar breaks at 146.6 N); none fails as a whole."),
        (
            slips,
            "slip at 58.63 N a bar, 0.40 of the 146.6 N at which it breaks, with 10 mm of yarn in the grip; each fails at 500 N.",
        ),
        (scene.replace({"attachment.kind": "free"}), "No attachments"),
    ):
        assert words in attachments(one)
        assert attachments(one) == cautions(one)[1]


def test_an_interrupt_tells_how_to_go_on(tmp_path):
    def interrupted(shoot, *_, **__):
        shoot(300.0, 0)
        raise KeyboardInterrupt

    with mock.patch.object(sys.modules["fabric_kernel.v50"], "v50", side_effect=interrupted):
        _, errors, code = called(tmp_path, main, "sheet_3in_sphere")
    assert code == 130
    assert "the same command goes on" in errors


def test_a_scene_is_enough_and_results_have_names(tmp_path):
    (tmp_path / "scene.toml").write_text(small_scene().to_toml())
    test = fk.v50(str(tmp_path / "scene.toml"), shots=10, tests=0)
    assert test.shots == fk.v50(fk.Shooter(small_scene()), fk.Neyer.bracketed(test.shots[0].velocity), 10, tests=0).shots
    assert (test.v50, test.interval()) == (test.fit.velocities[1], test.fit.intervals[1])
    assert (test.velocity(0.01), test.interval(0.01)) == (test.fit.velocities[0], test.fit.intervals[0])
    with pytest.raises(ValueError, match=r"share: must be one of 0.01, 0.5, 0.99; it is 0.3"):
        test.interval(0.3)
    with pytest.raises(ValueError, match="design: must be given beside a function that shoots"):
        fk.v50(lambda velocity, shot: (True, 0.0))


def test_warnings_are_objects_that_are_saved_and_sent():
    note = fk.runs.doubts([small_scene().replace(step_check="none")], [vars(fk.fly(small_scene()))])[-1]
    assert (note.kind, note.numbers, note.text == note) == ("step_unchecked", {"runs": 1, "of": 1}, True)
    for again in (pickle.loads(pickle.dumps(note)), results.restored(Note, results.plain(note))):
        assert (again, again.kind, again.numbers) == (note, note.kind, note.numbers)
