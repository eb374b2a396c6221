"""Windows below a limit: invented shots with and without them, what the ladder would miss, and what the commands say."""

import json
import math
import sys
from unittest import mock

import numpy
import scipy.stats
from commands import called
from fabric_kernel import Scene, designs, fragments, results, runs, sensitivity, window
from fabric_kernel.v50 import v50

limits, residual = (sys.modules[f"fabric_kernel.{name}"] for name in ("v50", "residual"))


def invented(low, high, share, deviation, seed=1):
    """Shoots at a fabric whose single limits are 492 m/s with this deviation, and that lets this share through from low to
    high."""
    random = numpy.random.default_rng(seed)
    own, luck = random.normal(492.0, deviation, 200), random.random(200)
    through = lambda v, k: v > own[k] or (low < v < high and luck[k] < share)
    return lambda velocity, shot: (not through(velocity, shot), 0.5 * velocity)


NEYER = designs.Neyer(400.0, 600.0, 20.0)


def test_a_window_leaves_no_limit():
    test = v50(invented(330.0, 390.0, 1.0, 10.0), NEYER, 20, tests=0)
    first = test.answer()[0]
    assert first.startswith("No single limit"), first
    through = [shot.velocity for shot in test.ladder if not shot.stopped]
    assert f"slowest shot that went through had {min(through):.4g} m/s" in first
    assert test.window.stopped == max(shot.velocity for shot in test.ladder if shot.velocity < min(through))
    assert math.isnan(test.fit.mu)
    assert math.isnan(test.average.value)
    assert math.isnan(test.residual.limit)
    assert "V50 4" not in test.text()
    assert results.plain(test)["window"]["lowest"] == min(through)
    assert results.plain(test)["fit"]["mu"] is None


def test_how_often_a_window_is_found_and_one_is_imagined():
    tests, found = 25, {}
    for name, (low, high, share, deviation) in {
        "wide": (330.0, 390.0, 1.0, 10.0),
        "half": (250.0, 352.0, 0.5, 10.0),
        "narrow": (340.0, 345.0, 1.0, 10.0),
        "none": (0.0, 0.0, 0.0, 10.0),
        "scatter": (0.0, 0.0, 0.0, 40.0),
    }.items():
        # Curves of residual velocities, which are most of the time, are not looked at.
        with mock.patch.object(limits.limit, "residual_fit"):
            found[name] = sum(
                v50(invented(low, high, share, deviation, seed), NEYER, 20, tests=0).window is not None for seed in range(tests)
            )
    assert found["wide"] == tests
    assert found["half"] >= scipy.stats.binom.ppf(0.001, tests, 0.95)
    assert found["narrow"] < tests
    assert max(found["none"], found["scatter"]) <= scipy.stats.binom.ppf(0.999, tests, 0.02)


def test_the_ladder_has_as_many_shots_as_the_confidence_needs():
    v, y = numpy.array([480.0, 500.0]).repeat(10), numpy.array([False, True]).repeat(10)
    for confidence, count in ((0.9, 12), (0.95, 15), (0.999, 30)):
        rungs = window.ladder(v, y, confidence)
        assert len(rungs) == count
        assert 0.5 ** (count // 3) <= 1.0 - confidence + 1e-12
        assert 0.25 * 480 < rungs[0] < 0.35 * 480 and 0.9 * 480 < rungs[-1] < 480.0, rungs
    assert "missed only if it is narrower than that. One of" in window.looked_at(rungs, [False] * 30, 0.95)[1]
    # Nothing is asked where no shot was stopped; where all were, the slowest counts.
    assert len(window.ladder(v, [True] * 20, 0.95)) == 0
    assert window.ladder(v, [False] * 20, 0.95)[-1] < 480.0
    # Shots far above the limit, of which a fit has its middle below 0.
    rungs = window.ladder([300, 150, 75, 37.5, 18.75, 28.125, 23.4375, 21.09375], [1, 1, 1, 1, 0, 1, 1, 1], 0.95)
    assert 0.0 < rungs[0] < rungs[-1] < 18.75


def test_one_shot_that_scatters_is_a_doubt_and_no_window():
    doubt, _note = window.looked_at([300.0, 400.0, 450.0], [False, False, True], 0.95)
    assert "1 of 3 shots below the estimate of V01 went through, the slowest with 450 m/s" in doubt
    assert window.window([480.0, 500.0, 520.0, 470.0] * 4, [False, True, True, True] * 4, [440.0], [False]) is None


def test_a_crossing_with_a_window_below_has_no_limit():
    scene = Scene("sheet_3in_sphere", sheet={"nodes_x": 31, "nodes_y": 31})
    for low, high in ((0.0, 0.0), (40.0, 60.0)):
        with mock.patch(
            "fabric_kernel.sensitivity.flown",
            lambda one, *_: {"steps": 1, "stopped": not ((v := one["projectile.velocity"][2]) > 100.0 or low < v < high)},
        ):
            found, _, lowest = sensitivity.limit_of([scene, 0, 1, 110.0, None, 100, (0.0, 0.0)])
        assert (found is None, lowest is None) == (low > 0.0, low == 0.0)
    change = sensitivity.Change("crimp", "crimp: 1 % more", *sensitivity.interval([]), 0, lowest or 50.0)
    found = sensitivity.Sensitivity(100.0, (change,), ())
    assert "window at" in found.rows()[0][1]
    assert found.sentence().startswith("No single limit")


def test_reports_begin_with_it_and_the_exit_status_says_it(tmp_path):
    through = lambda velocity: velocity > 100.0 or 50.0 < velocity < 65.0
    scene = Scene("sheet_3in_sphere", sheet={"nodes_x": 31, "nodes_y": 31}, projectile={"velocity": [0.0, 0.0, 95.0]})

    def flown(one, *_):
        v = one["projectile.velocity"][2]
        row = dict.fromkeys(("unconverged", "beyond_fine", "viscous", "energy_residual", "gained", *runs.LOST), 0.0) | {
            "outcome": "exited",
            "failure": None,
            "steps": 9,
        }
        return row | {
            "stopped": not through(v),
            "speed": 0.5 * v,
            "impact_energy": 1.0,
            "absorbed": 1.0,
            "failed_segments": 10,
            "failed_near_held": 8,
            "residual_kinetic": 0.1,
            "max_deflection": 1.0,
        }

    for module, main, words in (
        (limits, limits.main, ["--low", "90", "--high", "110", "--deviation", "2", "--simulated", "0"]),
        (residual, residual.main, ["--velocities", *(str(v) for v in range(90, 130, 3))]),
        (fragments, fragments.main, ["--velocities", "90", "95", "105", "110", "--shots", "4", "--on", "1"]),
    ):
        with mock.patch("fabric_kernel.shooter.flown", flown), mock.patch("fabric_kernel.ensembles.flown", flown):
            said, errors, code = called(tmp_path, main, scene, *words, out=module.__name__)
        assert code == window.STATUS, errors
        page = (tmp_path / module.__name__ / "report.html").read_text()
        first = page.split('class="answer"><p>')[1].split("</p>")[0]
        assert "No single limit" in first
        assert "No single limit" in said
        assert "Assumed of the attachments" in page.split("<details>")[0]
        if module is not fragments:
            assert "Yarns broke at the clamps first: 80" in first.replace("\xa0", " ")
    test = json.loads((tmp_path / "fabric_kernel.v50/test.json").read_text())
    assert 50.0 < test["window"]["lowest"] < 65.0
    assert test["fit"]["mu"] is None


def test_segments_that_failed_near_held_nodes_are_counted():
    # Pulled at 450 m/s the yarns of this aramid break at the clamps alone; under a slow heavy sphere they do not.
    aramid = Scene.parse("""preset = "sheet_3in_sphere"
            fabric.linear_density = "930 dtex"
            fabric.count = "8.5 /cm"
            fabric.fibre_density = "1.44 g/cm3"
            fabric.modulus = "90 GPa"
            fabric.failure_strain = "3.4 %"
            fabric.damage_rate = 2300
            sheet = { width = "75 mm", plies = 8 }
            projectile = { shape = "cylinder", diameter = "5.46 mm", mass = "1.1 g", length = "5.98 mm" }
            aim.speed = "450 m/s" """)
    row = runs.fly(aramid, until=runs.DECIDED)
    assert row.failed_segments > 0
    assert 0 <= row.failed_near_held <= row.failed_segments
    free = runs.fly(Scene("sheet_3in_sphere", sheet={"nodes_x": 61, "nodes_y": 61}), until=runs.DECIDED)
    assert not (free.failed_near_held > 0.5 * free.failed_segments)


def test_a_window_above_the_limit_leaves_none():
    def mixed(low, high, share):
        random = numpy.random.default_rng(2)
        own, luck = random.normal(492.0, 10.0, 200), random.random(200)
        stops = lambda v, k: v <= own[k] or (low < v < high and luck[k] < share)
        return lambda velocity, shot: (stops(velocity, shot), 0.5 * velocity)

    for low, high, share, is_found in ((550.0, 640.0, 1.0, True), (520.0, 700.0, 0.5, True), (0.0, 0.0, 0.0, False)):
        test = v50(mixed(low, high, share), NEYER, 20, tests=0)
        assert (test.window is not None) == is_found, (low, high, share)
        above = [shot.velocity for shot in test.ladder if shot.velocity > 520.0]
        assert 1.3 * min(above) < max(above) < 1.4 * min(above)
        if is_found:
            assert test.window.fastest > 540.0
            assert test.answer()[0].startswith("No single limit")
        else:
            assert "Above it 15 shots up to" in test.text()


def test_two_groups_of_residual_velocities_are_said():
    random = numpy.random.default_rng(1)
    v = random.uniform(500.0, 600.0, 24)
    taken = lambda energies: numpy.sqrt(v * v - energies)
    assert not window.groups(v, taken(random.uniform(1.0e5, 1.4e5, 24)))
    mixed = window.groups(v, taken(numpy.where(numpy.arange(24) % 3 > 0, 2.0e5, 0.5e5) + random.uniform(0.0, 2e4, 24)))
    assert mixed.startswith("Residual velocities fall into two groups: 8 shots left with")
    assert "and 16 with" in mixed
    assert not window.groups([500.0], [100.0])
    assert not window.groups([], [])
