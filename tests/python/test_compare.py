"""Shields side by side: differences and their errors against closed forms, the shift of the network, and the command."""

import json
import math
import sys
from dataclasses import replace

import numpy
import pytest
import scipy.stats
from commands import called
from fabric_kernel import PRESETS, Scene, Shooter, ensembles, network, program, results, shields, v50
from fabric_kernel.limit import Interval
from fabric_kernel.shots import Shot
from test_own_tests import found as own_tests_of
from test_own_tests import pack, small

compare = sys.modules["fabric_kernel.compare"]


def shield(name, value, half, shift=None, corrected=None):
    """A shield whose interval is value x e^±half, of 20 shots."""
    ends = Interval(value * math.exp(-half), value * math.exp(half))
    return compare.Shield(name, 1.0, value, ends, "", False, shift, corrected, "", 20, 1e9, (), ())


def test_the_difference_of_two_limits_is_that_of_independent_logarithms():
    (pair,) = compare.of_limits([shield("a", 220.0, 0.03), shield("b", 200.0, 0.04)], 0.95, None)
    middle, half = math.log(1.1), 0.05
    assert pair.percent == pytest.approx(10.0)
    assert pair.interval == pytest.approx([100 * math.expm1(middle - half), 100 * math.expm1(middle + half)])
    assert pair.p == pytest.approx(2 * scipy.stats.t.sf(scipy.stats.t.ppf(0.975, 36) * middle / half, 36))
    assert pair.node_steps == 2e9
    # A limit without an end on one side is not distinguished, nor one without an interval.
    open_below = replace(shield("a", 220.0, 0.03), interval=Interval(-math.inf, 230.0))
    (pair,) = compare.decided(compare.of_limits([open_below, shield("b", 200.0, 0.04)], 0.95, None), 0.95)
    assert (pair.p, pair.verdict) == (1.0, "not distinguished")


def test_holm_corrects_for_the_number_of_pairs():
    assert compare.holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert compare.holm([0.6, 0.5]) == [1.0, 1.0]
    assert compare.holm([]) == []


def test_no_false_differences_among_equal_shields():
    random, wrong = numpy.random.default_rng(1), 0
    for _ in range(300):  # Ten shields alike, whose limits scatter as their intervals say.
        shields = [shield(f"{k}", 200.0 * math.exp(0.02 * random.standard_normal()), 0.02 * 1.96) for k in range(10)]
        ranked = sorted(shields, key=lambda one: -one.value)
        wrong += any(pair.differs for pair in compare.decided(compare.of_limits(ranked, 0.95, None), 0.95))
    assert wrong <= 0.08 * 300


def test_a_difference_must_exceed_the_shift_of_the_network_and_the_scatter_of_own_tests():
    same, other = network.Shift(-5.0, Interval(-6.0, -4.0), 8), network.Shift(-15.0, Interval(-25.0, -5.0), 8)
    corrected = compare.Corrected(1.0, Interval(0.9, 1.1), "")
    for shift, verdict, differs in ((same, "differs", True), (other, "not beyond the shift of the network", False)):
        pairs = compare.of_limits([shield("a", 220.0, 0.03, shift), shield("b", 200.0, 0.03, same)], 0.95, None)
        (pair,) = compare.decided(pairs, 0.95)
        assert (pair.verdict, pair.differs) == (verdict, differs)
        assert pair.differs == math.isnan(pair.shots)
    own = own_tests_of([0.1, 0.12, 0.08])  # 2 % of scatter, of which a new shield's interval has 4.3.
    for value, words in ((220.0, "not beyond"), (300.0, "differs; beyond")):
        pair = compare.of_limits(
            [shield("a", value, 0.01, None, corrected), shield("b", 200.0, 0.01, None, corrected)], 0.95, own
        )
        assert words in compare.decided(pair, 0.95)[0].verdict


def test_shares_at_one_velocity_are_compared_by_the_shots_in_which_they_differ():
    through = {"a": [False] * 9 + [True, None], "b": [True] * 8 + [False, True, True]}
    a, b = shield("a", 90.0, 0.1), shield("b", 20.0, 0.1)
    (pair,) = compare.of_shares([a, b], through, 0.95)
    assert pair.percent == pytest.approx(80.0)
    assert pair.p == pytest.approx(2 * 0.5**8)
    assert pair.interval.low < 80.0 < pair.interval.high <= 100.0
    assert compare.of_shares([a, b], {"a": [True], "b": [True]}, 0.95)[0].p == 1.0
    found = compare.Comparison("", 100.0, 0.95, (a, replace(b, value=90.0)), (), (), (), ())
    assert found.answer()[0].startswith("Most stopped at 100 m/s: a and b, 90 %")


def test_the_first_line_has_the_corrected_limit():
    its = compare.Corrected(242.0, Interval(220.0, 264.0), "With 3 own tests: 242.0 m/s.")
    shields = shield("a", 220.0, 0.03, None, its), shield("b", 200.0, 0.03)
    found = compare.Comparison("", math.nan, 0.95, shields, (), (), (), ())
    assert found.answer()[0] == (
        "Highest limit: a, V50 242.0 m/s, 95 % interval [220.0, 264.0] m/s, as own tests correct it; of the model alone 220.0 "
        "m/s, 95 % interval [213.5, 226.7] m/s."
    )
    outside = replace(its, value=math.nan)
    assert "of the model." in replace(found, shields=(replace(shields[0], corrected=outside),)).answer()[0]


def shots_at(random, middle, scatter, velocities):
    limits = middle * numpy.exp(scatter * random.standard_normal(len(velocities)))
    return [Shot(float(v), bool(v < one), 0.0) for v, one in zip(velocities, limits)]


@pytest.mark.parametrize(("shift", "scatter"), [(0.0, 0.03), (-0.15, 0.02), (0.1, 0.06)])
def test_the_shift_of_a_network_holds_the_truth(shift, scatter):
    random, held, sign = numpy.random.default_rng(3), 0, 0
    for _ in range(60):
        coarse = shots_at(random, 200.0, scatter, 200.0 * numpy.exp(scatter * random.uniform(-2, 2, 20)))
        fine = shots_at(random, 200.0 * (1 + shift), scatter, 200.0 * (1 + shift) * numpy.exp(scatter * random.uniform(-2, 2, 8)))
        found = network.shift_of(coarse, fine, 200.0)
        held += found.interval.low <= 100 * shift <= found.interval.high
        sign += found.percent * shift >= 0.0
    assert held >= 0.9 * 60
    assert sign >= 0.95 * 60


def test_what_is_advised_of_the_network_is_what_was_found(monkeypatch):
    body = {"shape": "box", "size": [3e-3, 3e-3, 3e-3], "mass": 0.21e-3, "velocity": [0, 0, 60.0]}
    scene = Scene("sheet_3in_sphere", fabric="kevlar_km2_s706", projectile=body)
    scene = scene.replace({"sheet.width": "20 mm", "sheet.yarns_per_bar": 2}).aimed()
    kinds = lambda test: [note.kind for note in test.warnings]
    shifts = {"small": (-3.0, 2.0, False), "large": (-20.0, -8.0, False), "not known": (-12.0, 9.0, True)}
    for low, high, warned in shifts.values():
        found = network.Shift(0.5 * (low + high), Interval(low, high), 8)
        monkeypatch.setattr(network, "shift", lambda *_, found=found, **__: found)
        test = v50(scene, shots=8, tests=0, beside=False, shifted=True)
        assert ("coarse_network" in kinds(test)) == warned
        assert ("Take them: half of sheet.yarns_per_bar." in test.answer()[1]) == (high < -5.0)
        one = compare.with_limit("a", [scene], shields.Tested(test, 1.0, 1.0), None)
        assert any("Bars half as long change the limit." in note for note in one.cautions) == (high < -5.0)
    assert "coarse_network" in kinds(v50(scene, shots=8, tests=0, beside=False))


def test_bars_half_as_long_are_the_same_fabric():
    for name in PRESETS:
        scene = Scene(name).replace({"time_step.seconds": 1e-8})
        fine = network.halved(scene)
        assert fine["sheet.spacing"] == 0.5 * scene["sheet.spacing"]
        assert fine["time_step.seconds"] == 0.5e-8
    pack = Scene("sheet_3in_sphere", fabric={"name": "kevlar_km2_s706"}, sheet={"nodes_x": 201, "nodes_y": 201})
    assert network.graded_for(Shooter(pack), network.halved(pack), 200.0)["sheet.grading.largest"] > 1
    whole = network.halved(Scene("ring_40in"))  # A curved sheet is not graded.
    assert network.graded_for(Shooter(Scene("ring_40in"), point=None), whole, 200.0) == whole
    coarse = [Shot(v, v < 100.0, 9.0) for v in numpy.linspace(95.0, 105.0, 20)]
    one_sided = network.shift_of(coarse, [Shot(80.0, False, 9.0)] * 8, 100.0)
    assert one_sided.interval.low == -math.inf
    assert -25.0 < one_sided.interval.high < -15.0


def test_names_and_what_cannot_be_ranked():
    with pytest.raises(ValueError, match="two or more are needed"):
        compare.compare([pack()])
    with pytest.raises(ValueError, match="is there twice"):
        compare.compare(["sheet_3in_sphere", "sheet_3in_sphere"])
    with pytest.raises(ValueError, match="shield 2: is the same scene as shield 1"):
        compare.compare([pack(), pack()])
    assert compare.unlike([pack(14), pack(20)]) == ""
    assert "arrangement of plies, support" in compare.unlike(
        [pack(14), pack(1, **{"stack.plies": 14, "attachment.kind": "two_sides"})]
    )


def test_from_scenes_to_a_ranking(tmp_path, monkeypatch):
    for plies in (1, 2, 3):
        (tmp_path / f"p{plies}.toml").write_text(small(plies).to_toml())
    files = [str(tmp_path / f"p{plies}.toml") for plies in (1, 2, 3)]
    words = *files, "--shots", "10"
    said, errors, code = called(tmp_path, compare.main, *words)
    assert (code, "error" in errors) == (0, False)
    assert "Highest limit: p3, V50" in said
    report = (tmp_path / "out/report.html").read_text()
    read = results.read(compare.Comparison, tmp_path / "out/compare.json")
    assert [one.shift is not None for one in read.shields] == [True] * 3
    assert len((tmp_path / "out/pairs.csv").read_text().splitlines()) == 4
    program.main(["report", str(tmp_path / "out")])
    assert (tmp_path / "out/report.html").read_text() == report
    with monkeypatch.context() as patch:
        patch.setattr(ensembles, "_locally", None)  # What is kept is not computed again.
        said, _, code = called(tmp_path, compare.main, *words, "--json")
    assert code == 0
    assert [one["name"] for one in json.loads(said)["shields"]] == [one.name for one in read.shields]
    said, _, code = called(tmp_path, compare.main, *words, "--at", "60", out="at")
    assert code == 0
    assert "Most stopped at 60 m/s" in said


def test_a_table_of_parameters_is_one_plot(tmp_path):
    table = "sheet.plies,sheet.width\n1,20 mm\n2,20 mm\n1,26 mm\n2,26 mm\n"
    (tmp_path / "sweep.csv").write_text(table)
    words = "--batch", str(tmp_path / "sweep.csv"), "--shots", "8", "--no-network"
    said, errors, code = called(tmp_path, compare.main, small(1), *words)
    assert (code, "error" in errors) == (0, False)
    assert "plies 2, width 26 mm" in said
    assert "sheet.width 26 mm" in (tmp_path / "out/compare.svg").read_text()
    for bad, words in (
        (table + "1,20 mm\n", "is there twice"),
        (table.replace("2,26", "2,far"), "row 4: sheet.width"),
        ("sheet.plies\n1\n", "two or more are needed"),
    ):
        (tmp_path / "bad.csv").write_text(bad)
        said, errors, code = called(tmp_path, compare.main, small(1), "--batch", str(tmp_path / "bad.csv"), out="bad")
        assert (said, code, errors.count("\n")) == ("", 2, 1)
        assert words in errors
    assert called(tmp_path, compare.main, "sheet_3in_sphere", "sheet_10in_cylinder", "--batch", "none.csv")[2] == 2
    assert called(tmp_path, compare.main, "sheet_3in_sphere", "no_such.toml")[2] == 2
