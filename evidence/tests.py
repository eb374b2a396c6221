"""`pytest evidence/tests.py`: statistics, verdicts and methods against values known from books or by hand."""

import base64
import json
import math
from xml.etree import ElementTree

import numpy
import pytest
import scipy.stats
from fabric_kernel import Scene, Simulation, sheets

from . import (
    claims,
    comparison,
    coverage,
    friction,
    hits,
    packs,
    page,
    paper_runs,
    short,
    strength,
    strips,
    study,
    viscosity,
    yarn,
)
from .statistics import AGREES, DOES_NOT, UNDECIDED, Estimate, arrest_limit, student, verdict_of_all, verdict_of_any


def interval(low, high):
    return Estimate(0.5 * (low + high), low, high)


def halved(job):
    scene, factor = job
    return factor * scene["projectile.mass"]


def test_a_job_is_done_once_and_an_answer_says_what_made_it(tmp_path):
    scene = Scene()
    for factors in ([0.5], [0.5, 2.0]):
        asked = study.Study("friction", "quick", tmp_path)
        found = asked.each(halved, [(scene, factor) for factor in factors])
        assert found == [factor * 0.0084 for factor in factors]
    assert len(asked.kept.read_text().splitlines()) == 2
    asked.write("numbers", [{"a": 1.5, "b": math.nan}])
    assert (asked.folder / "numbers.csv").read_text().split() == ["a,b", "1.5,"]
    origin = json.loads((asked.folder / "numbers.json").read_text())
    assert (origin["command"], origin["scenes"]) == ("python -m evidence friction --quick", [study.scene_hash(scene)])
    assert not study.Study("friction", study.SMOKE, tmp_path).kept.exists()


def test_a_page_shows_a_part_and_the_file_has_all():
    rows = [["neyer", "probit", shots, "sd x 1", *"abcde"] for shots in ("6", "7", "8", "10")]
    heading = ["design", "link", "shots", "guess", *(f"c{k}" for k in range(4, 9))]
    text = f"## First\n\n{page.markdown(heading, rows)}\nWords.\n\n## Second\n\n{page.markdown(heading, rows[:1])}"
    shown, files = short.shortened("v50", text)
    assert "| neyer | probit | 6 | sd x 1 | a | b | c |\n" in shown
    assert "| 7 |" not in shown
    assert shown.endswith("Whole tables: [v50_1.csv](v50_1.csv).\n")
    lines = files["v50_1.csv"].splitlines()
    assert [len(lines), lines[2][:20], lines[5][:12]] == [6, "First,neyer,probit,7", "Second,neyer"]
    shown, files = short.shortened("validation", "| yarn | viscosity |\n| --- | --- |\n| a | none |\n", "Title")
    assert (shown, files) == (
        "In [validation_1.csv](validation_1.csv).\n",
        {"validation_1.csv": "table,yarn,viscosity\nTitle,a,none\n"},
    )
    assert short.shortened("strips", "| a |\n") == ("| a |\n", {})


def test_a_threshold_is_found_from_guesses_below_at_and_above_it():
    for guess in (10.0, 99.0, 100.0, 101.0, 1e4):
        found = hits.bracketed(guess, lambda velocity: velocity > 100.0)
        assert abs(found / 100 - 1) < 0.5 * (hits.WIDTH - 1) + 1e-4


def test_hits_strike_at_places_of_the_middle_cell():
    scene = Scene("sheet_10in_cylinder")
    places = {hits.shot(scene, 50.0, hit)["projectile.position"][:2] for hit in range(20)}
    assert len(places) == 20
    assert max(abs(x) for place in places for x in place) < 0.5 * scene["sheet.spacing"]
    # The first outputs of the reference program for the seed 0.
    assert [hits.splitmix64(k * 0x9E3779B97F4A7C15 % 2**64) for k in (0, 1)] == [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4]


def test_intervals_hold_the_truth():
    # 100 tests with 15 shots: 95 % within what a binomial does in all but 1 of 10 000 cases.
    case = coverage.Case("Neyer", "probit", 15)
    for part, plain in zip(*case.run(1, 1, 100, seed=2)):
        assert scipy.stats.binomtest(round(100 * part), 100, 0.95).pvalue > 1e-4
        assert plain < part


def test_interval_of_a_known_sample():
    # 1 to 10: mean 5.5, standard deviation 3.02765, half width 2.262 sd/sqrt(10) = 2.1658.
    mean = Estimate.mean(range(1, 11))
    assert mean.value == 5.5
    assert abs(mean.high - 7.6659) < 5e-5
    assert Estimate.mean([3.0]).high == math.inf
    assert Estimate.mean([10.0] * 3) == Estimate.exact(10.0)
    # Three equal values in steps of 3 %: 10 x 0.03/sqrt(12) = 0.0866 times 4.3027.
    assert abs(Estimate.mean([10.0] * 3, 0.03).high - 10.3726) < 5e-5
    assert abs(student(math.inf) - 1.95996) < 5e-6


def test_ratio_of_known_samples():
    # Equal sizes and equal relative errors s: 2 (n - 1) degrees of freedom, half width of the logarithm t s sqrt(2).
    ratio = Estimate.ratio([18.0, 20.0, 22.0], [9.0, 10.0, 11.0])
    assert ratio.value == 2.0
    assert abs(math.log(ratio.high / 2) - 2.7764 * 0.1 / math.sqrt(3) * math.sqrt(2)) < 5e-6
    assert abs(ratio.low * ratio.high - 4.0) < 5e-8
    assert Estimate.ratio([2.0, 2.0], [1.0, 1.0]) == Estimate.exact(2.0)
    assert Estimate.ratio([0.0, 0.0], [1.0, 1.0]) == Estimate.exact(0.0)
    assert math.isnan(Estimate.ratio([0.0, 0.0], [0.0, 0.0]).value)


def test_share_of_known_counts():
    # Wilson: for none of n the interval ends at z^2/(n + z^2); 5 of 10: 0.2366 to 0.7634.
    z = student(math.inf)
    assert abs(Estimate.share(0, 10).high - z * z / (10 + z * z)) < 5e-8
    assert abs(Estimate.share(5, 10).low - 0.2366) < 5e-5
    assert [Estimate.share(k, 10).verdict((0.5, 1.0)) for k in (10, 0, 5)] == [AGREES, DOES_NOT, UNDECIDED]
    assert Estimate.share(0, 0).verdict((0.5, 1.0)) == UNDECIDED


def test_ballistic_limit_of_known_counts():
    limit = lambda *arrested: arrest_limit([(2.0 * k, count, 10) for k, count in enumerate(arrested)])
    # All arrested at 2 J, none at 4 J: 3 J, and no better than the spacing. Half at 2 J: 2 J.
    assert limit(10, 10, 0, 0).value == 3.0
    assert abs(limit(10, 10, 0, 0).high - 3 - 1.95996 * 2 / math.sqrt(12)) < 5e-5
    assert limit(10, 5, 0).value == 2.0
    # 3 and 5 of 10 are pooled to 4 and 4.
    assert limit(10, 3, 5, 0) == limit(10, 4, 4, 0)
    assert [limit(9, 5, 0), limit(10, 5, 1), arrest_limit([])] == [None] * 3


def test_verdicts_follow_the_interval():
    found = [interval(*ends).verdict((1.5, 2.5)) for ends in ((1.6, 2.4), (0.9, 1.4), (1.4, 1.6))]
    assert found == [AGREES, DOES_NOT, UNDECIDED]
    assert [verdict_of_all([AGREES, UNDECIDED]), verdict_of_all(found), verdict_of_all([])] == [UNDECIDED, DOES_NOT, UNDECIDED]
    assert [verdict_of_any(found), verdict_of_any([DOES_NOT, UNDECIDED]), verdict_of_any([])] == [AGREES, UNDECIDED, UNDECIDED]


def test_a_verdict_is_of_the_published_coefficients():
    rows = [
        {"case": "pack", "friction": coefficient, "limit m/s": limit}
        for coefficient, limit in ((0.0, 100.0), (0.1, 102.0), (0.3, 110.0), (0.5, 150.0))
        for _ in range(9)
    ]
    lines = friction.verdicts(rows).splitlines()[2:]
    assert [line.split(" | ")[0] for line in lines] == ["| pack: limit with 0.1 over 0", "| pack: limit with 0.3 over 0"]
    assert [line.split(" | ")[3].strip(" |") for line in lines] == [DOES_NOT, AGREES]


def test_the_worst_balance_and_the_most_unconverged_solves_are_told():
    row = {"impact velocity m/s": 100, "friction": 0, "impact J": 5, "absorbed J": 1, "friction J": 0, "velocity m/s": 90}
    table = friction.impact_table([row | {"residual %": 0.1, "unconverged": 7}, row | {"residual %": -0.2, "unconverged": 3}])
    assert table.endswith("| 0.20 | 7 |\n"), table


def test_slope_of_a_ladder_bends_where_the_measured_one_does():
    row = lambda density, limit, measured: {
        "areal density kg/m2": density,
        "limit m/s": limit,
        "limit m/s: deviation": 0.0,
        "hits": 3,
        "measured V50 m/s": measured,
    }
    rows = [row(7.5, 700.0, 700.0), row(5.0, 600.0, 620.0), row(2.5, 450.0, 438.0), row(4.5, 1.0, 585.0)]
    below, above = packs.slope_points(rows)
    assert [round(below.ours.value, 9), round(above.ours.value, 9)] == [60.0, 40.0]
    assert abs(sum(below.allowed) / 2 - 72.8) < 5e-8
    assert abs(above.allowed[1] - above.allowed[0] - 2 * math.sqrt(2) * 19 / 2.5) < 5e-8
    assert packs.slope_points(rows[:1]) == []


def test_a_comparison_is_as_good_as_its_worst_point():
    point = lambda name, low, high: comparison.Point(name, interval(low, high), comparison.about(100, 0.1))
    good, bad, wide = point("a", 95, 105), point("b", 111, 120), point("c", 85, 95)
    row = lambda *points: comparison.Comparison("x", "theory", "", list(points), 0).row()
    assert row(good)[4] == AGREES
    assert (row(good, wide)[4], row(good, bad, wide)[4]) == (UNDECIDED, DOES_NOT)
    assert "3; b:" in row(good, bad, wide)[3]


def test_a_mean_has_the_error_of_its_hits_and_of_the_bisection():
    row = {"limit": 100.0, "limit: deviation": 0.0, "hits": 4}
    assert comparison.mean_of(row, "limit") == Estimate.exact(100.0)
    # Student's 3.182 for three degrees of freedom times 1/sqrt(12).
    assert abs(comparison.mean_of(row, "limit", 0.01).high - 100.9187) < 5e-4


def test_transverse_impact_on_the_papers_yarn():
    # From N = 472.7 N at U = 1.03 and 8.98e-5 kg/m.
    for mass, breaks, strain in ((1.0, 1300.8, 6.217e-3), (0.5, 1839.6, 3.907e-3)):
        for refinement in (1, 8):
            scene = viscosity.Strip(viscosity.NONE, 6.35e-3, refinement, 0.4, mass).scene(400.0)
            assert abs(viscosity.transverse(scene, 1.03).speed - breaks) <= 0.1
            assert abs(viscosity.smith(scene, 400.0)[0] - 1 - strain) <= 1e-6


def test_the_strip_is_a_yarn():
    scene = viscosity.Strip(viscosity.NONE, 6.35e-3, 1).scene(400.0)
    simulation, h = Simulation(scene), scene["sheet.spacing"]
    simulation.step(300)
    one, other = simulation.positions()
    assert abs(other - one - [0, h, 0]).max() < 1e-12 * h


def test_smiths_relation():
    # e = 0.04: 2 x 0.04 x sqrt(0.04 x 1.04) - 0.0016 = 0.0147169, its root 0.1213132.
    assert abs(yarn.smith_linear(0.04) - 0.1213132) <= 1e-6
    assert abs(yarn.linear_strain(yarn.smith_linear(0.03)) - 0.03) <= 1e-12
    # For small strains the law of the model is the linear one: to first order they differ by 1.5 e in the force.
    own, linear = yarn.waves(yarn.Strip("kevlar_km2_s706", 100.0, 1.0, viscosity.NONE, 1.0).scene(10.0), 10.0)
    assert all(abs(a / b - 1) < 3 * linear[0] for a, b in zip(own, linear))


def test_shape_and_scale_of_a_known_sample():
    # Quantiles of a Weibull distribution of shape 10 and scale 2 in equal parts of the probability.
    parts = (numpy.arange(100_000) + 0.5) / 1e5
    shape, scale, _ = strength.weibull(numpy.log(2 * (-numpy.log(1 - parts)) ** 0.1))
    assert abs(shape / 10 - 1) <= 1e-3
    assert abs(scale / 2 - 1) <= 1e-4


def test_packs_weigh_and_are_as_thick_as_the_table_says():
    twaron = packs.packs()
    assert len(twaron) == 5
    for bar in (1.0, 2.0):
        scene = twaron[0].scene(bar, True, 0.03)
        density = 21 * scene["sheet.node_mass"] / scene["sheet.spacing"] ** 2
        assert abs(density - 2.5) <= 1e-12
        assert abs(21 * scene["sheet.thickness"] - 3.6e-3) <= 1e-15
    assert twaron[0].scene(1.0, False, 0.03)["sheet.thickness"] == 0.0


def test_segments_lie_where_they_should():
    at = lambda numbers, nodes, mirrored: paper_runs.middles(numpy.array(numbers), nodes, nodes, 5, 5, mirrored).tolist()
    assert at([0, 3, 4, 19], 5, False) == [[-1.5, -2.0], [1.5, -2.0], [-1.5, -1.0], [1.5, 2.0]]
    assert at([20, 24, 25, 39], 5, False) == [[-2.0, -1.5], [2.0, -1.5], [-2.0, -0.5], [2.0, 1.5]]
    # A quarter has 3 nodes and 3 segments a line, the last across the plane.
    assert at([0, 2, 3, 8, 9, 11, 17], 3, True) == [
        [-1.5, -2.0],
        [0.5, -2.0],
        [-1.5, -1.0],
        [0.5, 0.0],
        [-2.0, -1.5],
        [0.0, -1.5],
        [0.0, 0.5],
    ]


def test_places_of_failure():
    # Off both planes four places, on one of them two, on both one.
    images = paper_runs.with_images(numpy.array([[-20.5, -10.0], [-0.5, 0.0], [0.0, -0.5], [0.0, 0.0]]), True)
    assert len(images) == 4 + 2 + 2 + 1
    # Segments across a plane are modelled beside their image. Four alone, and those about the centre together.
    assert len(paper_runs.with_images(numpy.array([[-0.5, 0.0], [0.5, 0.0]]), True)) == 2
    assert paper_runs.count_groups(images) == 5
    # A chain of near ones is one place.
    assert paper_runs.count_groups(numpy.array([[0.0, 0.0], [8.0, 0.0], [4.0, 0.0], [14.0, 0.0]])) == 2
    assert paper_runs.count_groups(numpy.zeros((0, 2))) == 0


def test_onset_of_failure_is_seen_in_whole_and_mirrored_sheets():
    points = [
        paper_runs.Point(paper_runs.SMALL, paper_runs.FOUR_SIDES, yarn, 160.0)
        for yarn in (paper_runs.UNIFORM, paper_runs.SYMMETRIC)
    ]
    whole, mirrored = (paper_runs.flown((point.scene(study.SMOKE, 0), 5000))["first_failure"] for point in points)
    # Before the first failure a whole uniform sheet is symmetric but for rounding.
    assert abs(whole["time"] / mirrored["time"] - 1) <= 0.02
    assert mirrored["segments"] % 2 == 0
    assert min(whole["places"], mirrored["places"], whole["segments"]) >= 1


def test_every_scene_is_sound_and_a_washer_holds_its_node():
    for point in paper_runs.points(study.FULL):
        scene = point.scene(study.FULL, 1)
        scene.check()
        if point.attachment == paper_runs.CORNERS and point.sheet == paper_runs.SMALL:
            inset, radius = paper_runs.WASHERS[point.washer]
            node, h = paper_runs.corners_of(scene)[0], scene["sheet.spacing"]
            assert math.hypot(node % 105 * h - inset, node // 105 * h - inset) < radius


def test_a_claim_is_refuted_by_one_counterexample_and_says_which():
    checks = [claims.Check("a", interval(1.1, 1.2), claims.MORE), claims.Check("b", interval(0.8, 0.9), claims.MORE)]
    claim = claims.Claim("P3", "more", "above 1", checks)
    assert (claim.verdict, claim.why()) == (DOES_NOT, "1 of 2 inside; outside: b")
    assert claims.Claim("P3", "more", "above 1", checks, whole=verdict_of_any).verdict == AGREES


def test_two_or_four_points_in_most_runs():
    verdict = lambda *counts: claims.two_or_four(counts).verdict(claims.MOST)
    assert verdict(2, 4, 2, 2, 4, 2, 2, 2, 4, 2) == AGREES
    assert verdict(1, 1, 3, 1, 8, 1, 1, 5, 1, 1) == DOES_NOT
    assert [verdict(2, 1, 4, 3), verdict()] == [UNDECIDED] * 2


def test_alike_yarns_bear_the_law_up_to_their_strength():
    pull = strips.Pull(strips.strip(0.008, 0.03, **{"yarn.strength_draw": "none"}))
    scene = pull.scene
    critical, crimp = scene["yarn.critical_stretch"], scene["sheet.crimp"][0]
    assert numpy.abs(pull.critical - critical).max() < 1e-12
    nominal = lambda stretch: 0.5 * scene["yarn.modulus_mean"] * stretch * (stretch**2 - 1)
    load, rests = pull.to(1.01 * (1 + crimp) - 1)
    stress = load / (scene["sheet.yarn_area"] * scene["sheet.nodes_y"])
    assert rests
    assert abs(stress / nominal(1.01) - 1.0) <= 1e-9
    strength, restless = pull.strength()
    assert restless == 0
    assert abs(strength / nominal(critical) - 1.0) <= 0.002


def test_a_strip_breaks_from_its_weakest_segment_on():
    pull = strips.Pull(strips.strip(0.008, 0.03, seed=5))
    along = (pull.scene["sheet.nodes_x"] - 1) * pull.scene["sheet.nodes_y"]
    weakest = int(pull.critical[:along].argmin())
    crimp = pull.scene["sheet.crimp"][0]
    for part, breaks in [(1 - 1e-5, False), (1.002, True)]:
        pull.to(pull.critical[weakest] * part * (1 + crimp) - 1)
        assert (pull.stretches == 2.0).any() == breaks
        assert (pull.stretches[weakest] == 2.0) == breaks


def test_a_yarn_among_rigid_ones():
    # w'' = w^3 with w' = -strain at the cut; the load is 1 + w'/strain.
    s = numpy.linspace(0, 40, 4001)
    slope = strips.STRAIN * (strips.rigid(s) - 1)
    far = -math.sqrt(math.sqrt(2) * -slope[-1])
    w = -far + numpy.cumsum(-0.5 * (slope[1:] + slope[:-1])[::-1])[::-1] * (s[1] - s[0])
    second = numpy.diff(slope)[1:] / (s[1] - s[0])
    assert abs(slope[0] - -strips.STRAIN) < 5e-8
    assert numpy.abs(second - w[:-1] ** 3).max() < 1e-3 * second.max() + 1e-5


def test_a_longer_gauge_makes_weaker_flaws():
    # Small strains: stress goes with (L/h)^(1/m).
    assert abs(strips.longer(0.05, 10.0, 1e15, 1e6, 1.1e6) / (0.05 * 1.1**10) - 1.0) <= 1e-6


class TwoPlies:
    """Two plies of 3 x 2 nodes with a box, turned by 90 degrees about z: of the second ply the first segment along x has failed,
    the last along y is half."""

    time = 5e-6
    nodes = numpy.array([[[x, y, 0] for x in (0, 1, 2)] for y in (0, 1)] * 2, float)
    positions, velocities = lambda self: self.nodes, lambda self: self.nodes * numpy.array([1, 1, 10, 10]).reshape(4, 1, 1)
    stretch, damage = (
        lambda self: numpy.tile([9, 1, 1.01, 1, 1, 1, 1.03], 2),
        lambda self: numpy.array([1.0] * 7 + [0, 1, 1, 1, 1, 1, 0.5]),
    )
    ply = lambda self, ply: {"failed_segments": int((self.damage().reshape(2, -1)[ply] == 0.0).sum())}
    projectile = lambda self: {"position": (0, 0, 9), "orientation": (0.5**0.5, 0, 0, 0.5**0.5)}

    class scene(dict):
        held = lambda self: []

    scene = scene(
        {
            "stack.plies": 2,
            "sheet.radius": 0.0,
            "sheet.thickness": 0.0,
            "sheet.plies": 1,
            "sheet.closed": False,
            "symmetry.mirror_x": False,
            "symmetry.mirror_y": False,
            "yarn.critical_stretch": 1.03,
            "sheet.nodes_x": 3,
            "sheet.nodes_y": 2,
            "sheet.spacing": 1.0,
            "sheet.spacing_y": 0.0,
            "projectile.shape": "box",
            "projectile.radius": 0.0,
            "projectile.size": (2.0, 2.0, 2.0),
        }
    )


@pytest.fixture
def sheet():
    return sheets.Sheet(TwoPlies(), ply=1)


def test_every_number_is_read_in_its_place(sheet):
    assert (sheet.time, list(sheet.centre), sheet.failed()) == (5e-6, [0, 0, 9], 1)
    assert numpy.allclose(sheet.outline[0][:2], [[-1, 1, 8], [-1, -1, 8]])
    assert sheet.segments.tolist() == [[0, 1], [1, 2], [3, 4], [4, 5], [0, 3], [1, 4], [2, 5]]
    assert (sheet.positions[5].tolist(), sheet.velocities[5].tolist()) == ([2, 1, 0], [20, 10, 0])
    assert abs(sheet.stretch[6] - 1.03) < 5e-7
    assert [round(alpha, 2) for alpha in sheet.alpha] == [0, 1, 1, 1, 1, 1, 0.5]


def test_a_mesh_with_a_failed_segment_is_a_hole_with_loose_yarns(sheet):
    assert sheet.whole().tolist() == [[False, True]]
    assert sheet.covered().tolist() == [False, True, False, True, False, True, True]
    [(corners, colours)] = sheet.cloth()
    assert corners[0].tolist() == [[1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0]]
    # Two of its four nodes touch the segment at the critical strain, one that at a third of it.
    assert numpy.allclose(colours, sheets.STRAIN((2 + 1 / 3) / 4)[:3], atol=0.01)


def test_the_hull_of_a_box_has_its_faces(sheet):
    faces, _ = sheet.body()
    assert len(faces) == 12


def test_vtk_has_damage_stretch_and_velocity(sheet, tmp_path):
    sheet.vtk(tmp_path / "sheet.vtp")
    sheets.vtk_series(tmp_path / "run.pvd", [(0.5, ["body.vtp", "sheet.vtp"])])
    assert [part.get("file") for part in ElementTree.parse(tmp_path / "run.pvd").iter("DataSet")] == ["body.vtp", "sheet.vtp"]
    arrays = {array.get("Name"): array for array in ElementTree.parse(tmp_path / "sheet.vtp").iter("DataArray")}
    numbers = lambda name: numpy.frombuffer(base64.b64decode(arrays[name].text)[4:], "<f4")
    assert numpy.allclose(numbers("damage"), 1 - sheet.alpha)
    assert numpy.allclose(numbers("stretch"), sheet.stretch)
    assert numpy.allclose(numbers("velocity").reshape(-1, 3), sheet.velocities)


def test_numbers_are_short():
    assert [page.significant(x) for x in (1234.5, 12.345, 1.2345, 0.012345, 0.0)] == ["1234", "12.3", "1.23", "0.0123", "0.0000"]
    assert [page.power(x, 1) for x in (0.00123, 12.3)] == ["1.2e-3", "1.2e1"]
