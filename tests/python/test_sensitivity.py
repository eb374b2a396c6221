"""The change of a limit with what was chosen, and the pictures of the package."""

import csv
import io
import math
import re

import matplotlib
import numpy
import pytest
import scipy.stats
from commands import called
from fabric_kernel import PRESETS, Scene, Simulation, history, plot
from fabric_kernel.movie import movie
from fabric_kernel.sensitivity import WIDTH, crossing, interval, variants
from fabric_kernel.sheets import outline
from fabric_kernel.textile import areal_density, presented_area, sides
from fabric_kernel.v50 import LimitTest, main
from PIL import Image


def small_scene(**sheet):
    body = {"radius": 2.778e-3, "mass": 6.9e-4}
    return Scene(
        "sheet_3in_sphere", fabric={"name": "kevlar_km2_s706"}, sheet={"nodes_x": 41, "nodes_y": 41} | sheet, projectile=body
    ).aimed()


def test_a_crossing_is_found_from_both_sides_and_far_away():
    for limit in (20.0, 95.0, 100.0, 105.0, 700.0):
        assert abs(math.log(crossing(100.0, lambda velocity: velocity > limit) / limit)) < 0.5 * math.log(WIDTH) + 1e-09
    assert math.isnan(crossing(100.0, lambda velocity: False))


def test_the_interval_is_that_of_student_and_not_below_the_bisection():
    mean, _, high = interval([0.1, 0.2, 0.3])
    half = scipy.stats.t.ppf(0.975, 2) * 0.1 / math.sqrt(3)
    assert mean == pytest.approx(100 * math.expm1(0.2), rel=0, abs=5e-8)
    assert high == pytest.approx(100 * math.expm1(0.2 + half), rel=0, abs=5e-8)
    _, _low, high = interval([0.0, 0.0, 0.0])
    assert high == pytest.approx(100 * math.expm1(scipy.stats.t.ppf(0.975, 2) * math.log(WIDTH) / math.sqrt(18)), rel=0, abs=5e-8)
    assert interval([0.1])[1:] == (-math.inf, math.inf)


def test_every_variant_differs_by_what_it_says_and_can_be_simulated():
    scene = small_scene()
    found = variants(scene)
    assert len(found) == 14
    thick = [found[f"thickness of the cloth: {how}"] for how in ("half", "double")]
    assert [one["sheet.thickness"] / scene["sheet.thickness"] for one in thick] == [0.5, 2.0]
    # The body keeps its distance from the cloth.
    ends = [-one["projectile.position"][2] - 0.5 * one["sheet.thickness"] for one in thick]
    assert ends == pytest.approx([2.778e-3, 2.778e-3])
    assert not [name for name in variants(scene.replace({"sheet.thickness": 0.0})) if name.startswith("thickness")]
    for name, other in found.items():
        other.check()
        assert other != scene, name
    coarse = next(other for name, other in found.items() if name.startswith("spacing"))
    assert areal_density(coarse) == pytest.approx(areal_density(scene), rel=0, abs=5e-8)
    assert sides(coarse)[0] == pytest.approx(sides(scene)[0], rel=0, abs=5e-8)
    narrow = next(other for name, other in found.items() if name.startswith("width"))
    assert sides(narrow)[0] / sides(scene)[0] == pytest.approx(math.sqrt(0.5), rel=0, abs=0.02)
    flat = scene.replace(projectile={"shape": "cylinder", "length": 5e-3}).aimed()
    turned = variants(flat)["attitude: turned by 90 degrees about x"]
    turned.check()
    assert turned["projectile.position"][2] + 0.5 * scene["sheet.thickness"] == pytest.approx(-2.778e-3, rel=0, abs=5e-8)
    for size, how in (
        ((0.01, 0.02, 0.03), "90 degrees about x"),
        ((0.01, 0.02, 0.02), "90 degrees about y"),
        ((0.01, 0.01, 0.01), "45 degrees about x"),
    ):
        box = scene.replace(projectile={"shape": "box", "size": size}).aimed()
        other = variants(box)[f"attitude: turned by {how}"]
        other.check()
        assert presented_area(other) / presented_area(box) != pytest.approx(1.0, rel=0, abs=5e-4)
    for body in (flat, flat.replace({"projectile.shape": "hemispherical_cylinder"})):
        along_x = body.aimed(orientation=[math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0])
        assert "attitude: turned by 90 degrees about y" in variants(along_x)
    holds = [other["attachment.hold"] for name, other in found.items() if name.startswith("hold of the attachments")]
    strength = scene.replace({"attachment.hold": "1 of the yarn"})["attachment.hold"]
    for hold, part in zip(holds, (0.7, 0.4, 0.15), strict=True):
        assert hold / strength == pytest.approx(part, rel=0, abs=5e-8)
    weak = scene.replace({"attachment.hold": 20.0})
    assert next(other for name, other in variants(weak).items() if name.startswith("spacing"))["attachment.hold"] == 40.0
    assert not [name for name in variants(scene.replace({"attachment.kind": "free"})) if name.startswith("hold")]
    dry = scene.replace({f"yarn.viscosity_{kind}": 0.0 for kind in ("linear", "quadratic", "bending")})
    assert "viscosity of the yarn: that of real fabrics" in variants(dry)


@pytest.mark.parametrize("shots", [10, 120])
def test_the_command_shows_what_the_width_does_for_ten_times_the_node_steps_of_the_test(tmp_path, shots):
    said, _, _ = called(tmp_path, main, small_scene(), "--shots", str(shots), "--simulated", "0", "--sensitivity", out=f"{shots}")
    folder = tmp_path / f"{shots}"
    rows = list(csv.reader(io.StringIO((folder / "sensitivity.csv").read_text())))
    assert rows[0] == ["variant", "change_percent", "low_percent", "high_percent", "shots"]
    assert len(rows) == 15
    change = {row[0]: [float(number) for number in row[1:]] for row in rows[1:]}
    wide = [change[name][0] for name in change if name.startswith("width")]
    assert min(wide) < -10.0
    assert max(wide) > 10.0
    assert next(change[name][0] for name in change if name.startswith("failure strain")) > 3.0
    # Of two sides there may be a window.
    known = {name: row for name, row in change.items() if math.isfinite(row[0])}
    assert set(change) - set(known) <= {"support: two sides"}
    assert all(shots >= 2 and math.isfinite(low + high) for _, low, high, shots in known.values())
    page = (folder / "report.html").read_text()
    found = re.search(r"The changes took ([\d.]+) times the node-steps of the test", page)
    assert float(found[1]) <= 10.0
    for text in (said, page):
        assert "The width of the sheet changes the limit by" in text
        assert "The spacing of the network changes the limit by" in text
        assert "They are changes from" in text
        largest = max(known, key=lambda name: abs(known[name][0]))
        assert re.search(f"Of {len(known)} changes the largest is that of the {largest.split(': ')[0]}, [+-]", text)
        # The head of a report says nothing of another fabric.
        assert "Kevlar" not in (
            text.split("shots, ")[0].split("Sheet:")[0] if text is said else text.split("<details>")[0].split("</div>")[0]
        )
        assert ("found in the network of bars of two yarns" in text) == (shots == 10)
    assert page.count("data:image/svg+xml") == 2
    assert LimitTest.read(folder).text() in said


def test_each_is_drawn_the_same_twice_and_leaves_the_settings_of_the_user(tmp_path):
    before = dict(matplotlib.rcParams)
    simulation = Simulation(Scene("sheet_3in_sphere", sheet={"nodes_x": 31, "nodes_y": 31}), warns=False)
    rows = history(simulation, steps=640)
    for number in (0, 1):
        plot.history(rows, tmp_path / f"history{number}.svg", marks=[(1e-5, "detached")])
        plot.sheet(simulation, tmp_path / f"sheet{number}.png")
        plot.profile(simulation, tmp_path / f"profile{number}.svg")
    for kind in ("history0.svg", "sheet0.png", "profile0.svg"):
        assert (tmp_path / kind).read_bytes() == (tmp_path / kind.replace("0", "1")).read_bytes()
    for preset in PRESETS:
        small = {"sheet": {"nodes_x": 61, "nodes_y": 61}}
        if preset == "ring_40in":
            small = {"sheet": {"radius": 0.1, "nodes_y": 41}, "casing": {"radius": 0.1}, "projectile": {"position": [0, 0, 0.06]}}
        plot.sheet(Simulation(Scene(preset, small)), tmp_path / "preset.png")
    assert before == dict(matplotlib.rcParams)


def test_a_movie_has_pictures_of_the_whole_run(tmp_path):
    path = tmp_path / "movie.gif"
    movie(Scene("sheet_3in_sphere", sheet={"nodes_x": 31, "nodes_y": 31}), path, steps=320, every=64)
    with Image.open(path) as pictures:
        assert pictures.n_frames == 6


def test_the_lines_of_every_body_enclose_it():
    for preset, farthest in (
        ("sheet_3in_sphere", 6.35e-3),
        ("sheet_10in_cylinder", None),
        ("turbine_disc_sector", None),
        ("ring_40in", None),
    ):
        points = numpy.concatenate(outline(Scene(preset)))
        reach = float(numpy.linalg.norm(points, axis=1).max())
        assert 0.001 < reach < 0.1
        assert farthest is None or abs(reach - farthest) < 1e-09
        assert (points.min(0) < 0).all()
        assert (points.max(0) > 0).all()
