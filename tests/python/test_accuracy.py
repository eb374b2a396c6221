"""`fabric accuracy`: errors, orders and recommendations of invented shots of a known law, and the command on a small sheet."""

import json
import math
import sys
from unittest import mock

import fabric_kernel as fk
import numpy
import pytest
from commands import called
from fabric_kernel.accuracy import Accuracy, Setting, accuracy, difference

module = sys.modules["fabric_kernel.accuracy"]


def scene(speed=60.0):
    return fk.Scene("sheet_3in_sphere", sheet={"nodes_x": 49, "nodes_y": 49}, projectile={"velocity": [0.0, 0.0, speed]})


def invented(slope=0.02, order=1.0, scatter=0.0, apart=0.0, failed=True, law=None, off=0.0):
    """In place of shots: 10 J (1 + slope bars^order) or a law of the bars, times 1 + off where graded, a scatter that pairs
    share, and one that they do not; 8/bars^3 s a shot."""
    law = law or (lambda bars: 10.0 * (1.0 + slope * bars**order))

    def each(work, jobs, **_):
        found = {}
        for key, (one, base, shot, *_) in jobs.items():
            bars = one["sheet.spacing"] / base["sheet.spacing"]
            random = numpy.random.default_rng([shot, round(1000 * bars), round(1000 * one["time_step.fraction"])])
            common = scatter * numpy.random.default_rng(shot).standard_normal()
            value = (
                law(bars) * (1.0 + off * (one["sheet.grading.largest"] > 1)) * (1.0 + common + apart * random.standard_normal())
            )
            cost = 1e-3 * (0.4 / one["time_step.fraction"]) / bars**3
            found[key] = {
                "value": value,
                "stopped": False,
                "failed": failed,
                "node_steps": 1e9 * cost,
                "seconds": cost,
                "rows": [],
            }
        return found

    return mock.patch.object(module.ensembles, "each", each)


def test_an_error_that_is_known_is_found_and_its_order():
    with invented(slope=0.022, scatter=0.03, failed=False):
        found = accuracy(scene(), budget=1e6, bars=module.BARS[:5])
    rows = {row.setting: row for row in found.rows}
    for bars in (4.0, 2.0, 1.0, 0.5):
        exact = 100.0 * ((1.0 + 0.022 * bars) / (1.0 + 0.022 * 0.25) - 1.0)
        row = rows[Setting(bars)]
        assert row.error == pytest.approx(exact, rel=0.02)
        assert row.interval.low < exact < row.interval.high
    # Bars of a quarter are 0.55 % off the limit of fine ones.
    assert "at the order 1" in found.shift
    assert float(found.shift.split("by another ")[1].split(" %")[0]) == pytest.approx(-0.55, abs=0.03)
    # Bars of 2, 1 and 1/2 are 4.4, 2.2 and 1.1 % off it, of the finest network run only 3.8, 1.6 and 0.55 %.
    assert [one.row and one.row.setting.bars for one in found.choices] == [2.0, 0.5, None]


def test_the_ladder_ends_once_an_error_is_kept_and_the_cheapest_is_taken():
    with invented(slope=0.001, failed=False):
        found = accuracy(scene(), 1.0, budget=1e6)
    assert {row.setting.bars for row in found.rows} == {4.0, 2.0}
    assert found.recommended == Setting(4.0, 0.5)
    assert found.choices[0].runs == 1
    assert fk.Scene.parse(found.recommended_scene)["time_step.fraction"] == 0.5


def test_two_networks_that_agree_by_chance_are_not_believed_where_segments_fail():
    chance = lambda bars: 10.0 if bars > 1.5 else 8.0 * (1.0 + 0.02 * bars)
    with invented(law=chance):
        found = accuracy(scene(), 5.0, budget=1e6)
    assert found.recommended.bars == 1.0
    assert min(row.setting.bars for row in found.rows) == 0.25
    with invented(law=chance, failed=False):
        assert accuracy(scene(), 5.0, budget=1e6).recommended.bars == 4.0


def test_scatter_asks_for_more_shots_and_what_they_cannot_resolve_is_said():
    with invented(slope=0.0, apart=0.02):
        found = accuracy(scene(), 2.0, budget=1e6)
        assert max(row.shots for row in found.rows) > module.FEWEST
        assert found.choices[0].row.bound() < 2.0
        # The mean of so many shots, with the end of the interval, keeps the error.
        deviation = 100.0 * found.rows[-1].deviation / found.rows[-1].mean
        assert found.choices[0].runs >= (1.96 * deviation) ** 2 / 4.0 * 0.5
        none = accuracy(scene(), 0.05, budget=1e6)
    assert none.choices[0].row is None
    assert none.recommended_scene == ""
    assert "needed" in none.answer()[0] or "finer network" in none.answer()[0]


def test_a_shot_has_the_numbers_of_its_run():
    one, row = scene(20.0), fk.fly(fk.vary(scene(20.0), 1, seed=1)[0])
    for quantity, value in (("deflection", row.max_deflection), ("absorbed", row.absorbed), ("speed", 0.0)):
        found = module.shot_of([one, one, 0, 1, quantity, None, 20.0, 100_000, True])
        assert (found["value"], found["stopped"]) == (value, True)


def test_the_interval_of_a_mean_difference_holds_it_as_often_as_it_says():
    random, held = numpy.random.default_rng(5), 0
    for _ in range(2000):
        common = random.normal(10.0, 1.0, 6)
        pairs = list(zip(common + random.normal(0.3, 0.2, 6), common))
        _, ends = difference(pairs, 0.95)
        mean = 100.0 / float(numpy.mean([other for _, other in pairs]))
        held += ends.low <= 0.3 * mean <= ends.high
    assert held / 2000 == pytest.approx(0.95, abs=0.02)
    assert math.isnan(difference([], 0.95)[0])
    assert difference([(1.0, 1.0)] * 3, 0.95) == (0.0, (0.0, 0.0))


def test_a_budget_ends_the_ladder_and_one_too_small_is_refused():
    with invented(slope=0.02):
        found = accuracy(scene(), budget=0.5, on=1)
        assert min(row.setting.bars for row in found.rows) > 0.25
        assert any("ended the ladder" in line for line in found.answer())
        with pytest.raises(ValueError, match=r"budget: must be at least \d+ s for two settings"):
            accuracy(scene(), budget=1e-5, on=1)


def test_what_cannot_be_is_refused_by_name():
    for changes, told in (
        ({"error": 0.0}, "error: must be above 0 and at most 50 %"),
        ({"error": 51.0}, "error"),
        ({"quantity": "colour"}, "quantity: must be one of absorbed, speed, deflection, limit"),
        ({"shots": 1}, "shots"),
        ({"budget": 0.0}, "budget"),
    ):
        with pytest.raises(ValueError, match=told):
            accuracy(scene(), **changes)
    with pytest.raises(ValueError, match="scene: drive is prescribed"):
        accuracy(scene().replace(drive="prescribed"))
    with pytest.raises(ValueError, match="projectile.velocity: must not be zero"):
        accuracy(scene().replace({"projectile.velocity": (0.0, 0.0, 0.0)}))


def test_the_command_writes_what_it_says_and_goes_on(tmp_path):
    words = ("--error", "20 %", "--shots", "3", "--budget", "5 min", "--json")
    said, errors, code = called(tmp_path, module.main, scene(), *words)
    assert code == 0, errors
    answer = json.loads(said)
    assert answer["choices"][0]["error"] == 20.0
    out = tmp_path / "out"
    names = {path.name for path in out.iterdir()}
    assert {"report.html", "accuracy.svg", "accuracy.csv", "accuracy.json", "runs.jsonl"} <= names
    kept = (out / "runs.jsonl").read_bytes()
    again, _, _ = called(tmp_path, module.main, scene(), *words)
    assert (out / "runs.jsonl").read_bytes() == kept
    assert json.loads(again) == answer
    found = Accuracy.read(out)
    assert found.text().startswith("Error over run time of ")
    assert fk.Scene.read(str(out / "accurate.toml"))["sheet.nodes_x"] <= 49
    for wrong, told in (("0", "--error: must be a number of percent above 0"), ("much", "--error: must be a number of percent")):
        _, errors, code = called(tmp_path, module.main, scene(), "--error", wrong, out=wrong)
        assert (code, told in errors) == (2, True), errors


def test_a_graded_network_is_tried_where_it_has_fewer_nodes():
    ply = fk.Scene.parse("""preset = "sheet_3in_sphere"
            fabric = { name = "kevlar_km2_s706" }
            sheet.width = "80 mm"
            projectile = { diameter = "5.556 mm", material = "steel" }
            aim.speed = "150 m/s" """)
    assert module.size(Setting(1.0, graded=True).scene(ply)) < 0.5 * module.size(ply)
    # Grading of one ply errs by so much; the whole network is shot at the coarsest one and at the scene's bars.
    for off, kept in ((0.001, True), (0.03, False)):
        with invented(slope=0.001, off=off, failed=False):
            found = accuracy(ply, 2.0, budget=1e6)
            networks = [row.setting for row in found.rows if row.setting.is_network()]
            graded = [one.bars for one in networks if one.graded]
            both = [one.bars for one in networks if not one.graded and one.bars in graded]
            assert both == [bars for bars in graded if bars in (graded[0], 1.0)]
            assert bool(found.choices[0].row) == kept
    with invented(slope=0.001, off=0.03):
        # Not where the aim or the attitude is not that of the middle, nor if asked not to.
        for how in ("as_aimed", "whole"):
            assert not any(row.setting.graded for row in accuracy(ply, 1.0, budget=1e6, **{how: True}).rows)
