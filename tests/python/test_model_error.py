"""The error of the model against tests: coverage with invented data, what counts as compared, and where the numbers come from."""

import math
import pathlib
import re
from unittest import mock

import numpy
import pytest
import scipy.stats
from fabric_kernel import Scene, residual, vary
from fabric_kernel.compared import compared, factor, left_out, model_error
from fabric_kernel.designs import Plan
from fabric_kernel.ensembles import within_mesh
from fabric_kernel.runs import LOST
from fabric_kernel.textile import areal_density, axes, cunniff_velocity, presented_area
from fabric_kernel.v50 import Shooter, v50

TOP = pathlib.Path(__file__).parents[2]
SETS = 2000


def held(series, members, alike, mean, seed):
    """How many of SETS invented data sets give a factor that holds a new comparison. alike: the part of the variance that the
    members of a series share; the new comparison is one of a new series."""
    random = numpy.random.default_rng(seed)
    count = 0
    for _ in range(SETS):
        shared = random.standard_normal(series + 1)[:, None] * math.sqrt(alike)
        errors = 0.1 * (mean + shared + random.standard_normal((series + 1, members)) * math.sqrt(1.0 - alike))
        count += abs(errors[-1, 0]) <= math.log(factor(list(errors[:-1])))
    return count


def test_coverage_is_exact_where_series_are_one_number():
    low, high = scipy.stats.binom.interval(0.999, SETS, 0.95)
    for series in (1, 2, 5):
        count = held(series, 5, 1.0, 0.0, series)
        assert low <= count <= high, (series, count)


def test_coverage_is_never_below():
    least = scipy.stats.binom.interval(0.999, SETS, 0.95)[0]
    for series in (1, 3):
        for alike in (0.0, 0.5, 1.0):
            for mean in (0.0, 0.5, 1.0, 3.0):
                count = held(series, 5, alike, mean, 100 * series + round(10 * (alike + mean)))
                assert count >= least, (series, alike, mean)


def test_more_cases_of_one_series_do_not_narrow_the_band():
    assert factor([[0.1, -0.1]]) == pytest.approx(factor([[0.1, -0.1] * 50]), rel=0, abs=5e-13)
    assert math.log(factor([[0.1]])) == pytest.approx(12.706 * 0.1, rel=0, abs=5e-4)
    assert factor([[0.1], [0.1]]) < factor([[0.1]])
    assert factor([]) == math.inf


def test_the_numbers_are_those_of_the_tables():
    tables = [(TOP / f"docs/tables/{name}.md").read_text().splitlines() for name in ("validation", "strips")]
    packs, strips = compared("limit"), compared("strength")
    assert [len(packs), len(strips)] == [1, 1]
    for case in packs[0].cases:
        plies = case.name.split()[0]
        rows = [line for line in tables[0] if re.search(rf"^\| [\d.]+ \| \d+ \| [\d.]+ \| {plies} \|", line)]
        found = [re.search(rf" {value} [\[(]", row) for value, row in zip(case.computed, rows, strict=True)]
        assert all(found) and len(found) == 5
        assert all(f"| {case.measured} ± " in row for row in rows)
    for case in strips[0].cases[:4]:
        assert any(f"| {case.name} | {case.measured} |" in line and f"| {case.computed[0]} [" in line for line in tables[1])
    assert f"100/s, MPa: {strips[0].cases[4].computed[0]} [" in "".join(tables[0])


def test_each_case_left_out_lies_within_what_the_others_give():
    rows = left_out(compared())
    assert len(rows) == 5
    assert all(within for *_, within in rows)


def a_pack(plies, mass=1.1e-3):
    return Scene(
        "sheet_3in_sphere",
        fabric={"name": "kevlar_km2_s706"},
        sheet={"plies": plies, "nodes_x": 138, "nodes_y": 138},
        projectile=dict(shape="fsp", mass=mass, diameter=5.46e-3),
    ).aimed(velocity=[0, 0, 500])


def a_ply():
    return a_pack(1).replace(projectile={"shape": "cylinder", "radius": 2.73e-3, "length": 6e-3, "mass": 1.1e-3})


def test_what_was_not_compared_gets_no_band():
    within = model_error(a_pack(20))
    assert within.factor > 1.2
    low, high = within.band(400.0, 420.0)
    assert low < 400.0 / 1.16
    assert high > 420.0 * 1.16
    assert re.search(r"^Of the model against tests: \[\d+, \d+\] m/s; within a factor of", within.sentence(400.0, 420.0))
    for scene, told in (
        (a_ply(), "here: 0.178 kg/m² (one ply)"),
        (a_pack(20, 5e-3), "here: 5 g"),
        (a_pack(20).replace({"attachment.kind": "two_sides"}), "here: two sides held"),
        (a_pack(20).replace({"sheet.nodes_x": 51}), "102 to 160 mm wide; here: 37.4 x 102 mm wide"),
        (a_pack(20).replace({"sheet.thickness": 0.0}), "here: a surface without"),
        (a_pack(20).replace({"yarn.modulus_mean": 140e9}), "a yarn of 54 to 96 GPa; here: 140 GPa"),
        (a_pack(20).replace({"yarn.critical_stretch": 1.1}), "fails at 2.62 to 4.67 %; here: 10 %"),
        (a_pack(20).replace({"projectile.shape": "sphere"}), "a polyhedron; here: a sphere"),
        (a_pack(20).aimed(velocity=[300, 0, 300]), "here: an angle of impact of 45 degrees"),
        (a_pack(20).aimed(orientation=[0.6, 0.8, 0, 0]), "an attitude of at most 5 degrees; here: an attitude of 74 degrees"),
    ):
        error = model_error(scene)
        assert math.isnan(error.factor)
        assert error.band(1.0, 2.0) is None
        assert repr(error).startswith("<ModelError: unknown; ")
        assert told in error.sentence(1.0, 2.0)
        unknown = "no test of one ply" if told.endswith("(one ply)") else "so the error is unknown"
        assert unknown in error.sentence(1.0, 2.0)


def test_whatever_is_drawn_or_listed_is_compared():
    pack = a_pack(20).aimed()
    for drawn, told in (
        ({"attitude": "random"}, "here: an attitude of "),
        ({"tilt": 0.3}, "here: an attitude of 17 degrees: so"),
        ({"tilt": [0.0, 0.3]}, "an attitude of 17 degrees"),
        ({"point": (0.02, 0.0)}, "51 mm or more from an edge; here: 31.2 mm"),
        ({"parameters": {"projectile.mass": [1.1e-3, 2e-3]}}, "here: 2 g"),
        ({"attitude": [0.6, 0.8, 0, 0]}, "an attitude of 74 degrees"),
    ):
        error = model_error(vary(pack, 8, seed=1, **drawn))
        assert math.isnan(error.factor), drawn
        assert told in error.words
    assert math.isfinite(model_error(vary(pack, 8, seed=1, tilt=0.05, point=within_mesh(pack, (0.0, 0.0)))).factor)
    # Nor does one ply stand beside resolved yarns that were hit otherwise.
    ply = a_ply().aimed()
    assert "no test of one ply" in model_error(ply).words
    assert "so the error is unknown" in model_error(vary(ply, 8, seed=1, attitude="random")).words
    for scene, confidence, name in (([], 0.95, "scene"), (pack, 1.0, "confidence")):
        with pytest.raises(ValueError, match=f"^{name}: must be"):
            model_error(scene, confidence)
    with mock.patch(
        "fabric_kernel.shooter.flown",
        return_value={
            "stopped": True,
            "speed": 0.0,
            "steps": 1,
            "impact_energy": 1.0,
            "outcome": "arrested",
            "max_deflection": 1.0,
        }
        | dict.fromkeys(("absorbed", "unconverged", "energy_residual", "beyond_fine", "gained", *LOST), 0),
    ):
        for attitude, told in ((None, "within a factor of"), ("random", "here: an attitude of")):
            shoot = Shooter(pack, attitude=attitude)
            assert told in v50(shoot, Plan([500.0] * 3), 3, tests=0).against
            assert told in " ".join(residual(pack, [500.0] * 3, attitude=attitude).answer)


def test_the_numbers_of_cunniffs_axes():
    body = {"shape": "cylinder", "radius": 2.73e-3, "length": 6e-3, "mass": 1.1e-3}
    scene = a_pack(21).replace(projectile=body)
    assert areal_density(scene) / 21 == pytest.approx(2 * 600e-3 / 9000 * 34 / 0.0254, rel=0, abs=5e-7)
    assert presented_area(scene) == pytest.approx(math.pi * 2.73e-3**2, rel=0, abs=5e-13)
    side = scene.replace({"projectile.orientation": [math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0]})
    assert presented_area(side) == pytest.approx(2 * 2.73e-3 * 6e-3, rel=0, abs=5e-11)
    found = axes(scene)
    assert found.velocity == pytest.approx(
        cunniff_velocity(0.5 * 84.62e9 * 1.0355 * (1.0355**2 - 1), 0.0355, 84.62e9, 1440.0), rel=0, abs=5e-4
    )
    assert found.ratio == pytest.approx(areal_density(scene) * math.pi * 2.73e-3**2 / 1.1e-3, rel=0, abs=5e-10)
    assert axes(Scene("sheet_3in_sphere")) is None
