"""Ensembles: one table, bit for bit, whatever the workers, the order and the accidents."""

import contextlib
import dataclasses
import functools
import json
import math
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import unittest.mock
import warnings

import fabric_kernel as fk
import numpy
import pandas
import pytest
import scipy.stats
from commands import called, wait_for
from fabric_kernel import limit, plot
from fabric_kernel.ensembles import MOST_KEPT, each, kept
from fabric_kernel.fragments import answer, main
from fabric_kernel.runs import UNTIL
from fabric_kernel.shooter import Shooter, Unknown

BASE = fk.Scene(sheet={"nodes_x": 41, "nodes_y": 41})
SCENES = fk.vary(BASE, 12, seed=1, speed=scipy.stats.uniform(30.0, 60.0), point=(scipy.stats.norm(0.0, 1e-4), 0.0))
# Processes that are killed take a little longer.
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


@pytest.fixture(scope="module")
def table():
    return fk.ensemble(SCENES, on=1)


def assert_same(table, other):
    assert table.equals(other)
    assert list(table.columns) == list(other.columns)


def test_a_row_is_the_run_of_its_scene(table):
    for index in (0, 7):
        row = json.loads(json.dumps(dataclasses.asdict(fk.fly(SCENES[index]))))
        own = table.iloc[index]
        assert {name: own[name] for name in ("digest", "speed", "absorbed", "outcome")}.items() - row.items() == set()
        assert own["seed"] == SCENES[index]["seed"]
        assert own["projectile.velocity[2]"] == SCENES[index]["projectile.velocity"][2]
    assert table["key"].nunique() == len(SCENES)
    balance = table["impact_energy"] - table["residual_kinetic"] - table["absorbed"]
    assert balance.abs().max() < 1e-09
    deepest = fk.history(SCENES[0], every=128)["max_deflection"].max()
    assert table["max_deflection"][0] == pytest.approx(deepest, rel=0, abs=1e-12)
    assert table.attrs["units"]["max_deflection"] == "m"


def test_other_work_is_kept_too(tmp_path):
    keep = tmp_path / "work.jsonl"
    assert each(divided, {"a": 2, "b": 4}, keep=keep, on=2) == {"a": 0.5, "b": 0.25}
    # What is kept is not done again: a job under a kept key is not even looked at.
    assert each(divided, {"b": 0, "c": 8}, keep=keep, on=1) == {"b": 0.25, "c": 0.125}
    with pytest.raises(ZeroDivisionError):
        each(divided, {"d": 0}, keep=keep, on=1)
    assert len(keep.read_text().splitlines()) == 3


def test_workers_order_and_batches(table):
    for workers, batch in [(2, 1), (5, 5)]:
        assert_same(fk.ensemble(SCENES, on=workers, batch=batch), table)
    order = numpy.random.default_rng(3).permutation(len(SCENES))
    shuffled = fk.ensemble([SCENES[k] for k in order])
    assert_same(shuffled.iloc[numpy.argsort(order)].reset_index(drop=True), table)
    twice = fk.ensemble([SCENES[0], SCENES[1], SCENES[0]])
    assert list(twice["digest"]) == [table["digest"][k] for k in (0, 1, 0)]


def test_an_iterator_is_the_list_of_what_it_gives(tmp_path):
    keep, until = tmp_path / "runs.jsonl", ["exited", "arrested"]
    table = fk.ensemble(iter(SCENES[:2]), until=iter(until), keep=keep)
    assert_same(fk.ensemble(SCENES[:2], until=until), table)
    assert_same(fk.ensemble(SCENES[:2], until=until[::-1], keep=keep), table)
    assert lines(keep) == 2
    assert_same(fk.ensemble(SCENES[:1], until="exited"), fk.ensemble(SCENES[:1], until=["exited"]))
    assert fk.fly(SCENES[0], until=iter(["exited"])) == fk.fly(SCENES[0], until="exited")
    assert fk.history(SCENES[0], until=iter(until)).equals(fk.history(SCENES[0], until=until))
    assert fk.vary(BASE, 3, seed=1, point=iter((1e-3, 0.0))) == fk.vary(BASE, 3, seed=1, point=(1e-3, 0.0))
    cells = {"attitudes": {"a": (1.0, 0.0, 0.0, 0.0)}, "shots": 2}
    mapped = fk.fragment_map(BASE, velocities=iter([90.0]), points=zip([0.0], [0.0]), **cells)
    assert_same(fk.fragment_map(BASE, velocities=[90.0], points=[(0.0, 0.0)], **cells), mapped)
    v, through = [60.0, 70.0, 80.0, 90.0], [False, True, False, True]
    of_lists = limit.fit(v, through, shares=[0.5], tests=0)
    assert limit.fit(iter(v), iter(through), shares=iter([0.5]), tests=0) == of_lists


def test_what_is_kept_is_not_run_again(table, tmp_path):
    keep = tmp_path / "runs.jsonl"
    fk.ensemble(SCENES[:5], keep=keep)
    # The mark shows where a result comes from; the next line was cut off when the writer was killed.
    kept = keep.read_text().splitlines(keepends=True)
    marked = kept[2].replace('"failure": null', '"failure": "kept"')
    keep.write_text("".join([*kept[:2], marked, kept[3], kept[4][:-20]]))
    table = fk.ensemble(SCENES, keep=keep, on=2)
    assert lines(keep) == len(SCENES)
    assert table["failure"].notna().sum() == 1
    table["failure"] = None
    assert_same(table.astype(table.dtypes), table)
    keep.write_text("something else\n")
    with pytest.raises(ValueError, match="line 1 is not a result"):
        fk.ensemble(SCENES, keep=keep)


def test_what_is_no_file_of_results_is_left_alone(tmp_path):
    keep = tmp_path / "notes.txt"
    for text in ("one line without an end", "x" * 200_000, '{"key": "a", "row": 1'):
        keep.write_text(text)
        if text.startswith("{"):
            assert list(kept(keep)) == []
            assert keep.read_text() == ""
        else:
            with pytest.raises(ValueError, match="notes.txt: line 1 is not a result of an ensemble"):
                fk.ensemble(SCENES[:1], keep=keep)
            assert keep.read_text() == text
    with pytest.raises(ValueError, match="is not a file"):
        fk.ensemble(SCENES[:1], keep=tmp_path)
    with pytest.raises(ValueError, match="/dev/zero: is not a file"):
        fk.ensemble(SCENES[:1], keep="/dev/zero")
    with keep.open("wb") as file:
        file.truncate(MOST_KEPT + 1)
    with pytest.raises(ValueError, match="has 4294967297 bytes, and kept results may have 4294967296"):
        fk.ensemble(SCENES[:1], keep=keep)


def begun(tmp_path, script=KILLED, **options):
    """The ensemble of the forty in another process, and the file that it writes."""
    keep = tmp_path / "runs.jsonl"
    (tmp_path / "script.py").write_text(script)
    return subprocess.Popen([sys.executable, tmp_path / "script.py", keep], stderr=subprocess.PIPE, text=True, **options), keep


def test_a_full_disk_is_told_and_loses_nothing(table, tmp_path):
    keep = tmp_path / "runs.jsonl"
    fk.ensemble(SCENES[:1], keep=keep)
    first = keep.read_text()
    process, _ = begun(tmp_path, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2 * len(first),) * 2))
    _, said = process.communicate(timeout=120)
    assert process.returncode == 1
    assert re.search(r"File too large: '.*runs\.jsonl'", said.splitlines()[-1])
    assert keep.read_text().startswith(first)
    assert_same(fk.ensemble(SCENES, keep=keep), table)


def test_killed_and_resumed(tmp_path):
    process, keep = begun(tmp_path, start_new_session=True)
    wait_for(lambda: lines(keep) >= 3)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    before = lines(keep)
    assert before < 40
    table = fk.ensemble(FORTY, keep=keep)
    assert lines(keep) == 40
    assert_same(table, forty())


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_workers_end_with_their_parent(tmp_path, method):
    start = f"    import multiprocessing; multiprocessing.set_start_method('{method}')\n    scenes"
    script = KILLED.replace("    scenes", start).replace("keep=", "progress=False, keep=")
    process, keep = begun(tmp_path, script, start_new_session=True)
    wait_for(lambda: lines(keep) >= 2)
    workers = processes_of(process.pid)
    assert len(workers) >= 3
    process.kill()
    wait_for(lambda: process.poll() is not None and not processes_of(process.pid), seconds=30.0)
    process.communicate()
    keep.unlink()


def test_a_local_worker_that_dies(tmp_path):
    process, keep = begun(tmp_path)
    wait_for(lambda: lines(keep) >= 3)
    children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    os.kill(int(children[0]), signal.SIGKILL)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 0, said
    assert lines(keep) == 40
    assert_same(fk.ensemble(FORTY, keep=keep), forty())


def test_a_scene_that_is_refused_is_shown():
    bad = BASE.replace({"projectile.mass": -1.0})
    with pytest.raises(fk.Refused) as refused:
        fk.ensemble([*SCENES[:2], bad], on=2)
    assert refused.value.field == "projectile.mass"
    assert "'projectile.mass': -1.0" in "".join(refused.value.__notes__)


def test_a_run_that_fails_is_a_row():
    table = fk.ensemble([BASE, BASE.replace(contact_capacity=1)])
    assert list(table["outcome"]) == ["exited", "failed"]
    assert table["failure"][1] == "ContactCapacity"
    assert math.isnan(table["speed"][1])


def test_energy_that_slack_yarn_adds_is_told_while_a_run_goes_on():
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
        assert len(seen) == int(warns), seen
        assert all("the energy residual is 1." in text and "segments are slack" in text for _, text in seen), seen
        assert simulation.energy()["residual"] > 0.01 * initial
        ends.append((simulation.digest, seen and seen[0][1]))
    assert ends[0] == ends[1]
    assert ends[0][0] == ends[2][0]
    with pytest.warns(RuntimeWarning, match="^at .* us the energy residual is"):
        fk.fly(gains, steps=8000)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        fk.ensemble([gains], on=1, steps=8000)
    assert len([one for one in told if issubclass(one.category, RuntimeWarning)]) == 1, told


class Gaining:
    """A simulation whose contact gives a hundredth of the impact energy from nothing."""

    def __init__(self, scene, **options):
        self.simulation = fk.Simulation(scene, **options)
        self.energy = lambda: self.simulation.energy() | {"gained": 0.42}

    def __getattr__(self, name):
        return getattr(self.simulation, name)


def test_energy_from_nothing_leaves_the_outcome_unknown_and_is_a_decisive_warning():
    scene = BASE.replace(projectile={"mass": 8.4e-3, "velocity": [0.0, 0.0, 100.0]})
    with unittest.mock.patch("fabric_kernel.runs.Simulation", Gaining):
        with pytest.warns(RuntimeWarning, match="^Contact has given energy from nothing .*at most 1 % of the impact energy"):
            row = fk.fly(scene, until="exited")
        assert (row.outcome, row.stopped, row.gained) == ("exited", None, 0.42)
        with pytest.raises(Unknown):
            Shooter(scene)(100.0, 0)
    assert fk.fly(scene, until="exited").stopped is False


def test_a_run_warns_of_energy_from_nothing_after_an_open_balance_too():
    """A turning box that rubs on slack cloth, with twice the largest time step."""
    body = {"shape": "box", "size": [4e-3, 4e-3, 2e-3], "mass": 1e-3, "velocity": [20.0, 0.0, 20.0]}
    body |= {"orientation": [0.9, 0.3, 0.2, 0.2449489742783178], "angular_velocity": [2000.0, 1000.0, 0.0]}
    sheet, fraction = {"nodes_x": 61, "nodes_y": 61}, {"fraction": 1.0}
    rubs = fk.Scene(sheet=sheet, time_step=fraction, step_check="none", contact={"friction": 0.5}, projectile=body).aimed()
    simulation = fk.Simulation(rubs.replace({"yarn.stochastic": False}))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        simulation.run("exited", 2000)
    parts = ("the energy residual is", "of the impact energy that came from nowhere (energy.gained)")
    assert [part in str(one.message) for part, one in zip(parts, told, strict=True)] == [True, True]


def test_results_that_are_not_to_be_trusted_are_told_once():
    # With so much friction some solves of plies that lie on each other do not converge.
    rubs = fk.Scene(
        fabric={"name": "kevlar_km2_s706", "thickness": 0},
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
    texts = [str(one.message) for one in told if issubclass(one.category, RuntimeWarning)]
    assert len(texts) == 3, texts
    share = table["unconverged"] / table["steps"]
    assert list(share > 0.01) == [True, False, False, False], table[["unconverged", "steps"]]
    assert list(table["beyond_fine"] > 0) == [False, True, False, False]
    assert list(table["ply_penetration"] > 0.0) == [True, False, False, False]
    assert texts[0].startswith("In 1 of 4 runs more than 1 % of the steps have a contact solve that did not converge"), texts
    assert f"at most {100 * share.max():.2g} %" in texts[0]
    assert texts[1].startswith("In 1 of 4 runs the projectile met the sheet beyond the fine part"), texts
    assert texts[2].startswith("In 1 of 4 runs the viscosity of the yarn takes more than half of the dissipated energy"), texts
    # One run says it too, and its simulation has the counter.
    with pytest.warns(RuntimeWarning, match="beyond the fine part"):
        row = fk.fly(beside, steps=600)
    simulation = fk.Simulation(beside)
    simulation.step(600)
    assert simulation.counters()["beyond_fine"] == row.beyond_fine


def test_a_scene_by_name_flies():
    assert fk.fly("sheet_3in_sphere", steps=50) == fk.fly(fk.Scene(), steps=50)
    assert fk.Simulation("sheet_3in_sphere").scene == fk.Scene()
    with pytest.raises(FileNotFoundError, match='no_preset: No such file, and no preset: .*"ring_40in"'):
        fk.fly("no_preset")


def test_runs_that_are_equal_because_nothing_is_drawn_are_told():
    cloth = fk.Scene(fabric={"name": "kevlar_km2_s706"}, sheet={"nodes_x": 31, "nodes_y": 31}).aimed()
    with pytest.warns(RuntimeWarning, match="^4 of 4 runs have the result of another run.*seed"):
        table = fk.ensemble(fk.vary(cloth, 4, seed=1), on=1, steps=300)
    assert (table["seed"].nunique(), table["absorbed"].nunique()) == (4, 1)
    assert table["absorbed"][0] > 0.0
    # Drawn yarn, a drawn point, a run asked for twice, and runs that meet nothing say nothing.
    far = cloth.replace({"projectile.position": (1.0, 0.0, -1.0)})
    with warnings.catch_warnings():
        warnings.filterwarnings("error", ".*the result of another run")
        fk.ensemble([*SCENES[:3], SCENES[0]], on=1, steps=300)
        fk.ensemble(fk.vary(cloth, 3, seed=1, point=(scipy.stats.norm(0.0, 1e-4), 0.0)), on=1, steps=300)
        fk.ensemble(fk.vary(far, 2, seed=1), on=1, steps=300)


def test_draws():
    longer = fk.vary(BASE, 15, seed=1, speed=scipy.stats.uniform(30.0, 60.0), point=(scipy.stats.norm(0.0, 1e-4), 0.0))
    assert longer[:12] == SCENES
    speeds = [math.hypot(*scene["projectile.velocity"]) for scene in longer]
    assert all(30.0 <= speed <= 90.0 for speed in speeds)
    assert len(set(speeds)) == 15
    cylinder = BASE.replace(projectile={"shape": "cylinder", "length": 0.02})
    tilted = fk.vary(cylinder, 9, seed=1, tilt=0.3, parameters={"projectile.mass": [0.01, 0.02]})
    for scene in tilted:
        _w, x, y, _z = scene["projectile.orientation"]
        # The body's axis, turned by 0.3 away from the velocity.
        assert 1.0 - 2.0 * (x * x + y * y) == pytest.approx(math.cos(0.3), rel=0, abs=5e-13)
        assert scene["projectile.mass"] in (0.01, 0.02)
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
        with pytest.raises(ValueError, match=f"^{name}: must be"):
            fk.vary(BASE, **{"count": 2, "seed": 1} | given)
    # Axes of bodies in any attitude are spread evenly: their heights are uniform in [-1, 1].
    random = fk.vary(cylinder, 400, seed=5, attitude="random")
    heights = [1.0 - 2.0 * (q[1] ** 2 + q[2] ** 2) for q in (scene["projectile.orientation"] for scene in random)]
    assert scipy.stats.kstest(heights, scipy.stats.uniform(-1.0, 2.0).cdf).pvalue > 0.01


def test_a_run_goes_on_with_the_torn_cloth():
    """A cylinder on Kevlar KM2 held on two sides carries cloth that is torn off and still slows it."""
    scene = fk.Scene(
        fabric={"name": "kevlar_km2_s706", "thickness": 0},
        sheet={"nodes_x": 61, "nodes_y": 61},
        attachment={"kind": "two_sides"},
        projectile={"shape": "cylinder", "radius": 4e-3, "length": 20e-3, "mass": 8.4e-3, "velocity": [0.0, 0.0, 80.0]},
    ).aimed()
    short = fk.fly(scene, until=[*UNTIL, "detached"])
    row = fk.fly(scene, steps=2 * short.steps)
    assert (short.outcome, short.stopped, short.time) == ("detached", False, short.detached)
    # However it ends, it ends later, and went through.
    assert (row.stopped, row.detached) == (False, short.detached)
    assert row.steps > short.steps
    assert row.speed != short.speed
    if row.steps == 2 * short.steps:
        assert row.outcome == "detached"


def test_what_cannot_be_drawn_or_run():
    with pytest.raises(ValueError, match="count"):
        fk.vary(BASE, -3, seed=1)
    with pytest.raises(ValueError, match="speed: must be greater than 0"):
        fk.vary(BASE, 1, seed=1, speed=-5.0)
    with pytest.raises(TypeError, match="scenes: must be a list"):
        fk.ensemble(BASE)


def test_a_miss_is_no_perforation():
    # Aimed at an edge and away from it: half of the shots pass.
    small = BASE.replace(projectile={"velocity": [0.0, 0.0, 50.0]})
    row = fk.fly(small.replace({"projectile.position": (0.1, 0.0, -0.01)}))
    assert (row.outcome, row.stopped) == ("passed", None)
    with pytest.raises(fk.Refused, match="point: .* lies beside the sheet") as refused:
        fk.fragment_map(BASE, velocities=[50.0], attitudes={"random": "random"}, points=[(15.0, 15.0)])
    assert refused.value.field == "point"
    rows = {"outcome": ["passed", "exited"], "stopped": [None, False], "speed": [50.0, 30.0]}
    rows |= {"residual_kinetic": [1.0, 0.5], "absorbed": [0.0, 0.5], "viscous": [0.0, 0.1]}
    with unittest.mock.patch("fabric_kernel.fragments.ensemble", return_value=pandas.DataFrame(rows)):
        cell = fk.fragment_map(BASE, velocities=[50.0], attitudes={"random": "random"}, shots=2).iloc[0]
    assert (cell["through"], cell["missed"], cell["unknown"], cell["perforation"]) == (1, 1, 0, 1.0)
    # One shot of one: 0.025 from below.
    assert cell["low"] == pytest.approx(0.025, rel=0, abs=5e-13)


def test_the_command(tmp_path):
    for words, told in (
        (["--velocities", "-5"], "must be a number above 0; it is -5"),
        (["--velocities", "50", "--attitudes", "side=1,2"], "must have 4 numbers"),
        (["--velocities", "50", "--points", "15,15"], "point: (15, 15) m lies beside the sheet"),
        (["--attitudes", "a=1,0,0,0", "a=0,1,0,0"], "--attitudes: must be a name given once each; it is a a"),
        (["--attitudes", "=1,0,0,0"], "attitudes: must be one or more, by a name each"),
        (["--attitudes", "random=1,0,0,0"], '"random" is the name of'),
    ):
        assert told in called(tmp_path, main, "sheet_3in_sphere", *words)[1].splitlines()[-1]
    said, _, _ = called(
        tmp_path, main, "sheet_3in_sphere", "--velocities", "200", "200", "--points", "0,0", "0,0", "--shots", "1", "--on", "1"
    )
    assert len((tmp_path / "out/table.csv").read_text().splitlines()) == 2
    for twice in ("velocities: 200.0 is given 2 times and shot once.", "points: (0.0, 0.0) is given 2 times and shot once."):
        assert twice in said
        assert twice in (tmp_path / "out/report.html").read_text()
    for text in (said, (tmp_path / "out/map.svg").read_text()):
        assert "Projectile: sphere" in text
        assert "Not validated" in text


def test_without_velocities_a_map_has_both_colours(tmp_path):
    said, _, _ = called(tmp_path, main, BASE, "--shots", "2")
    table = pandas.read_csv(tmp_path / "out/table.csv")
    assert "Velocities about the limits that were bracketed" in said
    assert "residual_speed_sd_m_per_s" in table.columns
    shares = list(table["perforation"])
    assert (len(shares), shares[0], shares[-1]) == (5, 0.0, 1.0)


def test_table_and_picture(tmp_path):
    cylinder = BASE.replace(projectile={"shape": "cylinder", "length": 0.01, "radius": 4e-3, "mass": 4e-3})
    attitudes = {"end on": (1.0, 0.0, 0.0, 0.0), "random": "random"}
    options = {"velocities": [2.0, 300.0], "attitudes": attitudes, "shots": 3, "steps": 40_000}
    table = fk.fragment_map(cylinder, keep=tmp_path / "runs.jsonl", **options)
    plot.map(table, tmp_path / "map.svg")
    assert (tmp_path / "map.svg").stat().st_size > 5000
    slow, fast = table[table["velocity"] == 2.0], table[table["velocity"] == 300.0]
    assert (list(slow["perforation"]), list(fast["perforation"])) == ([0.0, 0.0], [1.0, 1.0])
    # Exact intervals of 0 and 3 of 3, from the binomial distribution: 1 - 0.025^(1/3).
    numpy.testing.assert_allclose(slow["high"], 1.0 - 0.025 ** (1.0 / 3.0), rtol=1e-9)
    numpy.testing.assert_allclose(fast["low"], 0.025 ** (1.0 / 3.0), rtol=1e-9)
    assert (fast["residual_speed"] < 300.0).all()
    assert (fast["residual_speed_sd"] > 0.0).all()

    assert [line.partition(" mm: ")[2] for line in answer(table)] == 2 * [
        "none of 3 shots goes through up to 2 m/s, all 3 do from 300 m/s on."
    ]
    upside_down = table.assign(through=8 * table["stopped"], stopped=8 * table["through"])
    assert ["does not grow with the velocity" in line for line in answer(upside_down)] == [True, False, True, False]


def test_what_a_map_refuses_and_says():
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
        with pytest.raises(ValueError, match=f"^{name}.*: must be"):
            fk.fragment_map(BASE, **sound | given)
    with pytest.warns(RuntimeWarning, match="velocities: 200.0 is given 2 times"):
        assert len(fk.fragment_map(BASE, steps=10, **(sound | {"velocities": [200.0, 200.0]}))) == 1


def test_what_is_not_known_widens_the_interval():
    options = {"velocities": [100.0], "attitudes": {"as given": (1.0, 0.0, 0.0, 0.0)}, "shots": 2}
    table = fk.fragment_map(BASE, steps=10, **options)
    assert (table["unknown"][0], table["low"][0], table["high"][0]) == (2, 0.0, 1.0)
    assert answer(table) == ["as given at (0, 0) mm: no shot has a known end."]
