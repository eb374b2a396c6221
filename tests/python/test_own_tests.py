"""Own firing tests: the statistics against closed forms, published limits, the family, tables, and the commands."""

import json
import math
import sys
from dataclasses import replace

import numpy
import pytest
import scipy.stats
from commands import called
from fabric_kernel import Scene, ensembles, family, fragments, limit, program, shields, v50
from fabric_kernel.compared import compared
from fabric_kernel.designs import Plan
from fabric_kernel.family import Measured, judged, pooled, trends


def main_of(name):
    return sys.modules[f"fabric_kernel.{name}"].main


def pack(plies=14, **changes):
    body = {"shape": "cylinder", "radius": 2.73e-3, "length": 5.985e-3, "mass": 1.1e-3, "velocity": [0, 0, 300.0]}
    scene = Scene("sheet_3in_sphere", fabric={"name": "kevlar_km2_s706", "thickness": 0}, projectile=body)
    return scene.replace({"sheet.width": "80 mm", "sheet.yarns_per_bar": 2, "sheet.plies": plies} | changes).aimed()


def found(errors, plies=(14, 20, 24, 28, 34), confidence=0.95):
    """Own tests of packs whose measured limit is e^error times the computed one of 100 m/s a ply."""
    scenes = [pack(count) for count in plies[: len(errors)]]
    measured = [Measured(f"{n}", 100.0 * n * math.exp(e), 0.0) for n, e in zip(plies, errors)]
    return judged(measured, scenes, [(100.0 * n, 0.01) for n in plies[: len(errors)]], confidence=confidence)


def test_the_pool_is_that_of_the_textbook():
    e, n = [0.10, 0.02, -0.03, 0.08], 4
    half = scipy.stats.t.ppf(0.975, 3) * numpy.std(e, ddof=1) * math.sqrt(1 + 1 / n)
    for error in (0.0, 0.02):  # Errors that are all alike change nothing but the scatter.
        found = pooled(e, [error] * n)
        assert found.b == pytest.approx(numpy.mean(e))
        assert found.half() == pytest.approx(half)
        assert found.s == pytest.approx(math.sqrt(numpy.var(e, ddof=1) - error**2))
    assert found.half(0.05) == pytest.approx(math.hypot(half, scipy.stats.t.ppf(0.975, 3) * 0.05))
    # DerSimonian and Laird by hand: w = 1/v, Q = 8, C = 500; s² = (Q - 1)/C; then b with 1/(s² + v).
    v = numpy.array([0.001, 0.001])
    two = pooled([0.0, 2.0 * math.sqrt(0.004)], numpy.sqrt(v))
    assert two.s**2 == pytest.approx((8.0 - 1.0) / 1000.0)
    uneven = pooled([0.0, 0.1, 0.1], [0.5, 0.01, 0.01])
    assert 0.095 < uneven.b < 0.1
    assert tuple(vars(pooled([0.1, 0.1], [0.0, 0.0])).values()) == (pytest.approx(0.1), 0.0, 0.0, 2)


def published(network):
    """Own tests of the five packs as one network of the package's comparisons has them."""
    (series,) = compared()
    plies = [round(case["areal_density_kg_per_m2"] / 0.1785) for case in series.about["case"]]
    measured = [Measured(case.name, case.measured, 0.0) for case in series.cases]
    return judged(measured, [pack(count) for count in plies], [(case.computed[network], 0.0) for case in series.cases])


def test_five_published_packs_each_from_the_other_four():
    narrow = published(2)
    assert [round(one.percent) for one in narrow.left_out] == [-2, 0, 4, 1, -3]
    assert all(one.inside for one in narrow.left_out)
    assert math.exp(narrow.pool.half()) == pytest.approx(1.066, abs=0.001)
    assert narrow.trends == ()
    assert "5 of 5" in narrow.answer()[1]
    surface = published(3)
    assert [one.name for one in surface.left_out if not one.inside] == ["21 layers"]
    assert [name.split(" (")[0] for name in surface.trends] == ["areal density", "velocity"]
    assert "beyond them" in surface.answer()[2]


@pytest.mark.parametrize(("n", "scatter"), [(2, 0.02), (4, 0.05), (8, 0.15)])
def test_how_often_the_interval_holds_a_new_shield(n, scatter):
    random, held = numpy.random.default_rng(n), 0
    for _ in range(500):
        b = random.uniform(-0.2, 0.2)
        pool = pooled(b + scatter * random.standard_normal(n) + 0.03 * random.standard_normal(n), [0.03] * n)
        held += abs(b + scatter * random.standard_normal() - pool.b) <= pool.half()
    assert held >= 0.92 * 500  # 95 % less three standard errors; with errors larger than the scatter more.


def test_a_trend_is_found_and_none_is_not():
    steady, rising = found([0.02, -0.02, 0.01, -0.01, 0.0]), found([0.0, 0.05, 0.1, 0.13, 0.2])
    assert steady.trends == ()
    assert trends(rising.tests) == list(rising.trends) != []
    # With equal weights that of the textbook; a shield of which the test says little makes no trend.
    line = scipy.stats.linregress(numpy.log([one.areal_density for one in rising.tests]), [one.e() for one in rising.tests])
    assert rising.trends[0] == f"areal density (p {line.pvalue:.1g})"
    doubtful = [replace(one, measured_error=0.2 if one is steady.tests[0] else 0.01) for one in steady.tests]
    assert trends([replace(one, measured=0.8 * one.measured) if one is doubtful[0] else one for one in doubtful]) == []
    # Without a trend masses from half to 1.1 times count, with one only those of the tests.
    lighter = pack(20, **{"projectile.mass": 0.8e-3})
    assert steady.lacks(lighter) == []
    assert rising.lacks(lighter) != []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"sheet.plies": 12}, "kg/m²"),
        ({"sheet.plies": 40}, "kg/m²"),
        ({"projectile.mass": 2e-3}, "2 g"),
        ({"attachment.kind": "two_sides"}, "two sides held"),
        ({"sheet.width": "102 mm"}, "mm wide"),
        ({"sheet.yarns_per_bar": 0.5}, "mm apart"),
        ({"yarn.modulus_mean": 200e9}, "200 GPa"),
        ({"yarn.critical_stretch": 1.1}, "10 %"),
        ({"sheet.plies": 1, "stack.plies": 20}, "separate plies"),
        ({"projectile.shape": "sphere"}, "a sphere"),
        ({"sheet.thickness": 1e-4}, "cloth with a thickness"),
        ({"projectile.velocity": [100.0, 0.0, 300.0]}, "18 degrees"),
    ],
)
def test_what_is_no_family_keeps_the_error_of_the_package(changes, words):
    own = found([0.1, 0.12, 0.08])
    scene = pack(20).replace(changes)
    assert own.lacks(pack(20)) == []
    assert any(words in here for _, here in own.lacks(scene))
    corrected = own.corrected([pack(20), scene], 500.0, 490.0, 510.0)
    assert math.isnan(corrected.value)
    assert words in corrected.words


def test_a_corrected_limit_can_be_multiplied_by_hand():
    own = found([0.1, 0.12, 0.08])
    corrected = own.corrected([pack(20)], 500.0, 490.0, 510.0)
    assert corrected.value == pytest.approx(500.0 * math.exp(own.pool.b))
    half = own.pool.half(0.5 * math.log(510 / 490) / 1.959964)
    assert corrected.interval == pytest.approx((corrected.value * math.exp(-half), corrected.value * math.exp(half)))
    assert f"x {math.exp(own.pool.b):.3f}" in corrected.words
    assert "no limit" in own.corrected([pack(20)], math.nan, -math.inf, math.inf).words


GOOD = "scene,v50\na.toml,100\nb.toml,200\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("scene,v50\na.toml,100\nnone.toml,200\n", "row 2: there is no scene none.toml"),
        (GOOD.replace("200", "0"), "row 2: v50: must be greater than 0; it is 0"),
        (GOOD.replace("200", "-5"), "row 2: v50: must be greater than 0; it is -5"),
        (GOOD.replace("200", "fast"), "row 2: v50: must be a number, m/s"),
        (GOOD.replace("200", "nan"), "row 2: v50: must be greater than 0"),
        ("scene,v50\na.toml,100\n", "has one test, a: two shields or more are needed"),
        ("scene,v50\n", "has no row"),
        ("", "has no row"),
        ("v50\n1\n", "must have a column scene"),
        ("scene,v50\na.toml,100\ncopy.toml,200\n", "all are of one shield"),
        ("scene,v50\na.toml,100\na.toml,200\n", "row 2: a is there twice"),
        ("scene,v50,v50\na.toml,100,100\n", "a column is there twice: v50"),
        ("scene,v50\na.toml,100,3\n", "row 1: 2 cells are needed, and there are 3: columns are separated by commas"),
        ("scene;v50\na.toml;100,5\n", "columns are separated by commas, and numbers have decimal points; the first"),
        ("scene\tv50\na.toml\t100\n", "the first line has a tab"),
        ('scene,v50\na.toml,"100,5"\nb.toml,200\n', "row 1: v50: must be a number, with a decimal point"),
        ("scene,v50,velocity,stopped\na.toml,1,1,1\n", "either v50"),
        ("scene,v50,plus_minus,sigma\na.toml,1,1,1\n", "one of them is needed"),
        ("scene,v50,no.such\na.toml,100,1\n", "row 1: unknown key `no.such`"),
        ('scene,v50\na.toml,"100\n', "no CSV: unexpected end of data"),
        (
            "scene,velocity,stopped\na.toml,100,1\na.toml,110,1\nb.toml,90,1\n",
            "a: no V50 from its 2 shots: All 2 shots were stopped",
        ),
        ("scene,velocity,stopped\na.toml,100,maybe\n", "row 1: stopped: must be 1 or 0, yes or no; it is maybe"),
        ("scene,velocity,stopped\na.toml,,1\n", "row 1: velocity: must be"),
    ],
)
def test_bad_tables_are_one_line(tmp_path, text, words):
    for name, plies in (("a", 14), ("b", 20), ("copy", 14)):
        (tmp_path / f"{name}.toml").write_text(pack(plies).to_toml())
    (tmp_path / "own.csv").write_text(text)
    said, errors, code = called(tmp_path, main_of("own_tests"), str(tmp_path / "own.csv"))
    assert (said, code, errors.count("\n")) == ("", 2, 1)
    assert words in errors
    assert not (tmp_path / "out").exists()


def test_tables_as_other_programs_write_them(tmp_path):
    for name, plies in (("a", 14), ("b", 20)):
        (tmp_path / f"{name}.toml").write_text(pack(plies).to_toml())
    table = tmp_path / "own.csv"
    table.write_bytes("\ufeffscene, v50 ,plus_minus\r\na.toml,400 ft/s,10\r\n,,\r\n\r\nb.toml,200,\r\n".encode())
    measured, scenes = sys.modules["fabric_kernel.own_tests"].read(table)
    assert measured == [("a", pytest.approx(121.92), pytest.approx(10 / 121.92 / 1.959964)), ("b", 200.0, 0.0)]
    assert scenes == [pack(14), pack(20)]
    v, stopped = [95, 98, 99, 101, 100, 102, 103, 97, 104, 96], [1, 1, 1, 0, 1, 0, 0, 1, 0, 1]
    shots = "".join(f"a.toml,{plies},{a},{b},\n" for plies in (14, 20) for a, b in zip(v, stopped))
    table.write_text(f"scene,sheet.plies,velocity,stopped,residual\n{shots}")
    measured, scenes = sys.modules["fabric_kernel.own_tests"].read(table)
    assert scenes == [pack(14), pack(20)]
    assert [one.name for one in measured] == ["a, plies 14", "a, plies 20"]
    assert measured[0].value == pytest.approx(100.5, abs=0.3)
    assert 0.001 < measured[0].error < 0.02


def invented(limits):
    """What `shields.limits` gives for shields with these limits, m/s."""

    def given(names, **_):
        made = []
        for name, value in zip(names, limits):
            v = [value * (0.97 + 0.004 * k) for k in range(16)]
            shot = lambda velocity, _, value=value: (velocity < value * (1.0 + 0.001 * (round(velocity) % 9 - 4)), 10.0)
            made.append(shields.Tested(v50(shot, Plan(v), 16, tests=0, beside=False, title=name), 1.0, 1.0))
        return made

    return given


def test_a_ratio_beyond_three_is_asked_about(tmp_path, monkeypatch):
    for name, plies in (("a", 14), ("b", 20)):
        (tmp_path / f"{name}.toml").write_text(pack(plies).to_toml())
    monkeypatch.setattr(shields, "limits", invented([400.0, 450.0]))
    (tmp_path / "own.csv").write_text("scene,v50\na.toml,0.41\nb.toml,470\n")
    said, errors, code = called(tmp_path, main_of("own_tests"), str(tmp_path / "own.csv"))
    assert (said, code) == ("", 2)
    assert "a ratio of 0.001. Are number and unit right?" in errors
    assert called(tmp_path, main_of("own_tests"), str(tmp_path / "own.csv"), "--any-ratio")[2] == 0


@pytest.mark.parametrize(("v50", "words"), [(1470, "a ratio of 2.9, and the others have 0.92."), (1600, "a ratio of 3.2")])
def test_a_slip_of_one_digit_is_asked_about(tmp_path, monkeypatch, v50, words):
    for name, plies in (("a", 14), ("b", 20), ("c", 26)):
        (tmp_path / f"{name}.toml").write_text(pack(plies).to_toml())
    (tmp_path / "own.csv").write_text(f"scene,v50\na.toml,410\nb.toml,{v50}\nc.toml,510\n")
    monkeypatch.setattr(shields, "limits", invented([450.0, 500.0, 550.0]))
    said, errors, code = called(tmp_path, main_of("own_tests"), str(tmp_path / "own.csv"))
    assert (said, code, errors.count("\n")) == ("", 2, 1)
    assert errors.startswith(f"error: b: measured {v50} m/s, computed 500")
    assert words in errors
    assert "give --any-ratio" in errors


def small(plies, width="20 mm"):
    return pack(14).replace({"sheet.plies": plies, "sheet.width": width, "projectile.velocity": [0.0, 0.0, 60.0]}).aimed()


def test_from_a_table_to_corrected_reports(tmp_path, monkeypatch):
    for plies in (1, 2, 3):
        (tmp_path / f"p{plies}.toml").write_text(small(plies).to_toml())
    (tmp_path / "own.csv").write_text("scene,v50\np1.toml,40\np2.toml,60\np3.toml,85\n")
    words = str(tmp_path / "own.csv"), "--shots", "8"
    said, errors, code = called(tmp_path, main_of("own_tests"), *words, out="own")
    assert (code, "error" in errors) == (0, False)
    assert "from 3 own tests" in said
    own = family.OwnTests.read(tmp_path / "own")
    assert own.title == "Own tests of own.csv"
    report = (tmp_path / "own/report.html").read_text()
    with monkeypatch.context() as patch:
        patch.setattr(ensembles, "_locally", None)  # What is kept is not computed again.
        said, _, code = called(tmp_path, main_of("own_tests"), *words, "--json", out="own")
    assert (code, json.loads(said)["pool"]["b"]) == (0, own.pool.b)
    program.main(["report", str(tmp_path / "own")])
    assert (tmp_path / "own/report.html").read_text() == report
    factor = f"x {math.exp(own.pool.b):.3f}"
    for main, options in (
        (main_of("v50"), ["--shots", "12", "--simulated", "0"]),
        (main_of("residual"), ["--shots", "14"]),
        (fragments.main, ["--velocities", "50", "80", "--shots", "3"]),
    ):
        said, _, _ = called(tmp_path, main, small(2), *options, "--tests", str(tmp_path / "own"), out=main.__module__)
        assert factor in said or f"x {own.factor()}" in said
        assert "3 own tests" in said
        assert "3 own tests" in (tmp_path / main.__module__ / "report.html").read_text()
    corrected = json.loads((tmp_path / "fabric_kernel.v50/test.json").read_text())["corrected"]
    assert corrected["value"] > 0.0
    said, _, _ = called(
        tmp_path, main_of("v50"), small(9), "--shots", "10", "--simulated", "0", "--tests", str(tmp_path / "own"), out="no"
    )
    assert "Own tests (3) do not hold here: they have 0.178 to 0.535 kg/m²; here: 1.61 kg/m²" in said
    _, errors, code = called(tmp_path, main_of("v50"), small(2), "--tests", str(tmp_path / "no_such"), out="none")
    assert (code, "fabric tests FILE.csv --out" in errors) == (2, True)
    assert called(tmp_path, main_of("v50"), small(2), "--at", "50", "--tests", str(tmp_path / "own"), out="at")[2] == 2


def test_a_shield_without_a_limit_is_left_out_and_said(tmp_path, monkeypatch):
    for name, plies in (("a", 14), ("b", 20), ("c", 26)):
        (tmp_path / f"{name}.toml").write_text(pack(plies).to_toml())
    (tmp_path / "own.csv").write_text("scene,v50\na.toml,350\nb.toml,400\nc.toml,450\n")
    every = invented([400.0, 450.0, 500.0])

    def limits(scenes, **options):
        found = every(scenes, **options)
        return [replace(found[0], test=replace(found[0].test, fit=limit.withheld(found[0].test.fit))), *found[1:]]

    monkeypatch.setattr(shields, "limits", limits)
    said, errors, code = called(tmp_path, main_of("own_tests"), str(tmp_path / "own.csv"))
    assert code == 0, errors
    assert "Left out: a: the model has no limit to compare with." in said
    assert "from 2 own tests" in said
    assert "On average the model's limits are 12 % too high, which is unsafe." in said
    (tmp_path / "own.csv").write_text("scene,v50\na.toml,350\nb.toml,400\n")
    _, errors, code = called(tmp_path, main_of("own_tests"), str(tmp_path / "own.csv"))
    assert (code, "fewer than two shields have a limit in the model: Left out: a" in errors) == (2, True)
