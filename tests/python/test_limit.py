"""Statistics of the ballistic limit against answers known from books, in closed form, or by symmetry."""

import json
import math
import re

import numpy
import pytest
import scipy.optimize
import scipy.stats
from fabric_kernel import checks, designs, limit
from fabric_kernel.likelihood import LARGEST, LINKS, LOGIT, PROBIT, firth, held, maximum, possible, possible_ratio, ratio
from fabric_kernel.v50 import LimitTest, Unknown, v50


def groups(*rows):
    """Velocities and results, (1, shots), from (velocity, through, shots)."""
    velocities = numpy.concatenate([numpy.full(count, float(v)) for v, _, count in rows])
    through = numpy.concatenate([numpy.arange(count) < hits for _, hits, count in rows])
    return velocities[None], through[None]


def random_test(seed, shots=20, mu=100.0, sigma=5.0):
    random = numpy.random.default_rng(seed)
    velocities = mu + 2 * sigma * random.uniform(-1, 1, shots)
    return velocities, velocities > random.normal(mu, sigma, shots)


def test_a_share_that_falls_is_named_and_one_that_grows_is_not():
    velocities, through = groups((350, 8, 8), (450, 1, 8), (600, 8, 8))
    assert "does not grow with the velocity" in limit.falling(velocities[0], through[0])
    assert limit.falling(*(one[0] for one in groups((350, 1, 8), (450, 4, 8), (600, 8, 8)))) == ""
    assert limit.falling([100.0], [True]) == ""


def test_false_alarms_are_no_more_than_stated():
    tests, alarms = 400, {}
    random = numpy.random.default_rng(1)
    for sigma in (2.0, 20.0, 1e6):
        limits = 100.0 + sigma * random.standard_normal((tests, 20))
        fixed = random.uniform(70.0, 130.0, (tests, 20))
        neyer = designs.simulate(designs.Neyer(80.0, 120.0, 5.0), 20, limits)
        for name, (v, y) in {"fixed": (fixed, fixed > limits), "Neyer": neyer}.items():
            alarms[name, sigma] = sum(bool(limit.falling(v[k], y[k], seed=k)) for k in range(tests))
    most = scipy.stats.binom.ppf(0.999, tests, limit.FALSE_ALARM)
    assert max(alarms.values()) <= most, alarms


def test_a_published_fit():
    # Beetles and carbon disulphide: C. I. Bliss, Ann. Appl. Biol. 22 (1935) 134; fits: A. J. Dobson, An Introduction to
    # Generalized Linear Models, 2nd edition (2002), section 7.3: intercept and slope -60.72, 34.27 (logit) and -34.94, 19.73
    # (probit).
    beetles = groups(
        (1.6907, 6, 59),
        (1.7242, 13, 60),
        (1.7552, 18, 62),
        (1.7842, 28, 56),
        (1.8113, 52, 63),
        (1.8369, 53, 59),
        (1.8610, 61, 62),
        (1.8839, 60, 60),
    )
    for link, intercept, slope in ((LOGIT, -60.72, 34.27), (PROBIT, -34.94, 19.73)):
        found = maximum(*beetles, link)
        assert 1 / found.sigma[0] == pytest.approx(slope, rel=0, abs=0.005)
        assert -found.mu[0] / found.sigma[0] == pytest.approx(intercept, rel=0, abs=0.005)


def test_two_velocities_have_a_closed_form():
    # Two parameters for two shares: each group is fitted alone. Firth's shares for the logit are (hits + 1/2)/(shots + 1).
    for low, high in (((2, 7), (5, 6)), ((0, 3), (3, 3))):
        test = groups((90, *low), (110, *high))
        for link in (LOGIT, PROBIT):
            shares = []
            for hits, shots in (low, high):
                cost = lambda z: (
                    -float(hits * link.log_share(z) + (shots - hits) * link.log_share(-z) + 0.5 * numpy.log(link.information(z)))
                )
                z = scipy.optimize.minimize_scalar(cost, bounds=(-9, 9), method="bounded", options={"xatol": 1e-10}).x
                if link is LOGIT:
                    assert float(link.share(z)) == pytest.approx((hits + 0.5) / (shots + 1), rel=0, abs=5e-7)
                shares.append(z)
            sigma = 20 / (shares[1] - shares[0])
            found = firth(*test, link)
            assert found.sigma[0] == pytest.approx(sigma, rel=0, abs=5e-5)
            assert found.mu[0] == pytest.approx(90 - shares[0] * sigma, rel=0, abs=5e-5)
    found = maximum(*groups((90, 2, 7), (110, 5, 6)), LOGIT)
    sigma = 20 / (math.log(5 / 1) - math.log(2 / 5))
    assert found.sigma[0] == pytest.approx(sigma, rel=0, abs=5e-9)
    assert found.mu[0] == pytest.approx(90 - math.log(2 / 5) * sigma, rel=0, abs=5e-7)


def test_the_profile_of_two_velocities_has_a_closed_form():
    # If the slower of two velocities is that of the share p, the faster group is fitted alone, or has p too.
    for hits, share, there in ((4, 0.1, 4 / 5), (1, 0.5, 0.5)):
        test = groups((90, 1, 6), (110, hits, 5))
        level, _ = held(*test, LOGIT, numpy.array([90.0]), LOGIT.quantile(share), 0.0)
        expected = math.log(share) + 5 * math.log(1 - share) + hits * math.log(there) + (5 - hits) * math.log(1 - there)
        assert level[0] == pytest.approx(expected, rel=0, abs=5e-7)


def test_results_that_do_not_overlap_are_a_step():
    v, y = groups((90, 0, 2), (100, 0, 1), (104, 1, 1), (110, 2, 2))
    found = maximum(v, y, PROBIT)
    assert (found.mu[0], found.sigma[0], found.level[0]) == (102.0, 0.0, 0.0)
    at = numpy.array([101.0, 103.9, 99.0])
    value, sigma = ratio(found.level, numpy.repeat(v, 3, 0), numpy.repeat(y, 3, 0), PROBIT, at, 0.0, 0.0)
    assert (value[0], value[1], sigma[0]) == (0.0, 0.0, 0.0)
    assert value[2] > 0.0
    # Two results at the velocity of the step.
    tied = maximum(*groups((90, 0, 2), (100, 1, 3), (110, 2, 2)), PROBIT)
    assert tied.level[0] == pytest.approx(math.log(1 / 3) + 2 * math.log(2 / 3), rel=0, abs=5e-8)
    assert tied.sigma[0] == 0.0


def test_no_fabric_of_a_bracket_has_limits_below_zero():
    v, y = random_test(5, mu=100.0)
    level = possible(v[None], y[None], PROBIT, LARGEST)
    assert level[0] == firth(v[None], y[None], PROBIT).level[0]
    at = numpy.array([-1.0, 30.0])
    value, sigma = possible_ratio(numpy.repeat(level, 2), v[None], y[None], PROBIT, at, PROBIT.quantile(0.01), LARGEST)
    assert value[0] == math.inf
    mu = 30.0 - PROBIT.quantile(0.01) * sigma[1]
    assert sigma[1] <= mu / 3 * (1 + 1e-09)


def test_slower_shots_that_go_through_more_often_give_no_fit():
    test = groups((90, 2, 3), (110, 1, 3))
    assert math.isnan(maximum(*test, PROBIT).mu[0])
    assert maximum(*test, PROBIT).level[0] == pytest.approx(6 * math.log(0.5), rel=0, abs=5e-8)
    assert math.isnan(firth(*test, PROBIT).mu[0])


def test_mirrored_shots_give_the_mirrored_fit():
    v, y = random_test(3)
    for link in LINKS.values():
        for method in (maximum, firth):
            one, other = method(v[None], y[None], link), method(200 - v[None], ~y[None], link)
            assert one.mu[0] == pytest.approx(200 - other.mu[0], rel=0, abs=5e-7)
            assert one.sigma[0] == pytest.approx(other.sigma[0], rel=0, abs=5e-7)


def test_shots_far_away_change_nothing():
    # Shots at ten, five, three and two times V50 that went through, as at the start of a bracket, tell nothing about a fabric
    # with a standard deviation of 3 %. From the middle of all shots the search ended at a sigma of several hundred m/s.
    far = numpy.array([1000.0, 500.0, 300.0, 200.0])
    for seed in range(6):
        v, y = random_test(seed, shots=20, sigma=3.0)
        more = numpy.append(far, v)[None], numpy.append([True] * 4, y)[None]
        for link in (PROBIT, LOGIT):
            for penalty, method in ((0.0, maximum), (1.0, firth)):
                alone, all_of_them = method(v[None], y[None], link), method(*more, link)
                assert alone.mu[0] == pytest.approx(all_of_them.mu[0], rel=0, abs=5e-6)
                assert alone.sigma[0] == pytest.approx(all_of_them.sigma[0], rel=0, abs=5e-6)
                at, q = numpy.array([98.0, 101.0]), 0.3
                one, other = (
                    held(numpy.tile(x, (2, 1)), numpy.tile(z, (2, 1)), link, at, q, penalty, 10.0)[0] for x, z in ((v, y), more)
                )
                assert numpy.allclose(one, other, atol=0.0001), (one, other)


def test_the_held_maximum_reaches_the_free_one():
    v, y = random_test(4)
    for link in LINKS.values():
        for penalty, method in ((0.0, maximum), (1.0, firth)):
            best = method(v[None], y[None], link)
            quantile = float(link.quantile(0.9))
            value, sigma = ratio(best.level, v[None], y[None], link, best.mu + quantile * best.sigma, quantile, penalty)
            assert value[0] < 1e-06
            assert sigma[0] / best.sigma[0] == pytest.approx(1.0, rel=0, abs=5e-4)


def test_the_unit_of_velocity_does_not_matter():
    v, y = random_test(6)
    one, other = limit.fit(v, y, tests=40), limit.fit(3.28084 * v, y, tests=40)
    for mine, its in zip((*one.velocities, *sum(one.intervals, ())), (*other.velocities, *sum(other.intervals, ()))):
        assert 3.28084 * mine / its == pytest.approx(1.0, rel=0, abs=5e-6)


def test_velocities_that_are_all_greater_have_the_interval_that_is_greater_by_as_much():
    for seed, shots in enumerate((5, 6, 8, 20)):
        v, y = random_test(seed, shots)
        ends = [numpy.array(limit.fit(v + shift, y, tests=20).intervals[1]) - shift for shift in (0.0, 50.0, 2000.0)]
        # No end is told below 0.
        ends = [numpy.where(ends[1] == -math.inf, -math.inf, end) for end in ends]
        assert numpy.allclose(ends[0], ends[1], atol=0.001) and numpy.allclose(ends[1], ends[2], atol=0.001), (shots, ends)


def test_an_interval_needs_enough_simulations():
    v, y = random_test(8)
    for tests, confidence, least in ((1, 0.95, 19), (18, 0.95, 19), (20, 0.999, 999), (-1, 0.95, 0), (99.5, 0.95, 0)):
        with pytest.raises(ValueError, match=f"tests: must be (at least|a whole number, at least) {least}"):
            limit.fit(v, y, confidence=confidence, tests=tests)
    # Refused before a shot.
    with pytest.raises(ValueError, match="tests: must be at least 19 for a confidence of 0.95"):
        v50(lambda velocity, shot: pytest.fail("shot"), designs.Neyer(80, 120, 5), 20, tests=1)
    # The rank of one more number among n is above k in at most 1 - confidence.
    for confidence, tests in ((0.95, 19), (0.95, 1000), (0.9, 35), (0.999, 999)):
        assert (tests + 1 - checks.rank(confidence, tests)) / (tests + 1) <= 1 - confidence + 1e-12


def test_only_v50_is_told_of_few_shots():
    for shots, told in ((9, [False, True, False]), (10, [True] * 3)):
        v, y = random_test(1, shots)
        found = limit.fit(v, y, tests=40)
        assert [math.isfinite(value) for value in found.velocities] == told
        assert [tuple(interval) == (-math.inf, math.inf) for interval in found.intervals][::2] == [not told[0]] * 2
        assert ("V01, V99: not reported below 10 shots, of which there are 9" in " ".join(found.notes)) == (shots == 9)


def test_intervals_hold_the_estimate_and_end_where_the_ratio_is_chi_squared():
    v, y = random_test(7, shots=60)
    found = limit.fit(v, y, tests=0)
    chi = scipy.stats.chi2.ppf(0.95, 1)
    for value, interval, profile, share in zip(found.velocities, found.intervals, found.profile, found.shares):
        assert interval.low < value < interval.high
        quantile = PROBIT.quantile(share)
        best = maximum(v[None], y[None], PROBIT).level
        for end in profile:
            assert ratio(best, v[None], y[None], PROBIT, numpy.array([end]), quantile, 0.0)[0][0] == pytest.approx(
                chi, rel=0, abs=5e-4
            )
        level = firth(v[None], y[None], PROBIT).level
        for end in interval:
            assert ratio(level, v[None], y[None], PROBIT, numpy.array([end]), quantile, 1.0)[0][0] == pytest.approx(
                chi, rel=0, abs=5e-4
            )


def test_a_large_test_agrees_with_the_standard_error():
    # 2000 shots, half at mu - sigma and half at mu + sigma: Fisher's information of mu is known.
    shots = groups((95, 159, 1000), (105, 841, 1000))
    found = limit.fit(shots[0][0], shots[1][0], tests=0)
    error = found.sigma / math.sqrt(2000 * float(PROBIT.information(1.0)))
    assert found.mu == pytest.approx(100.0, rel=0, abs=5e-7)
    assert found.profile[1].high - 100.0 == pytest.approx(1.96 * error, rel=0, abs=0.02 * error)
    assert found.intervals[1].high - 100.0 == pytest.approx(1.96 * error, rel=0, abs=0.02 * error)


def test_the_order_in_which_the_calibration_is_asked_changes_nothing():
    design = designs.Neyer(80, 120, 5)
    one, other = (limit.Calibration(design, 12, tests=50) for _ in range(2))
    first = [one.node(0, 0), one.node(1, -1)]
    second = [other.node(1, -1), other.node(0, 0)][::-1]
    assert (numpy.array(first) == numpy.array(second)).all()


def test_the_error_of_the_simulated_tests_is_stated():
    """Shots in another order are simulated with other random numbers; ends scatter by no more than is stated, nor far less."""
    v = numpy.array([85.0, 90.0, 93.0, 96.0, 98.0, 100.0, 101.0, 103.0, 105.0, 108.0, 112.0, 118.0])
    through = [0, 0, 0, 0, 1, 0, 1, 0, 1, 1, 1, 1]
    fits = []
    for seed in range(6):
        order = numpy.random.default_rng(seed).permutation(len(v))
        fits.append(limit.fit(v[order], numpy.array(through)[order], shares=[0.5], tests=100))
    stated = [[float(x) for x in re.findall(r"[\d.]+", fit.notes[0].partition(": ")[2])[:2]] for fit in fits]
    scatter = numpy.std([fit.intervals[0] for fit in fits], axis=0, ddof=1) / numpy.mean(stated, axis=0)
    assert (scatter > 0.1).all() and (scatter < 1.5).all(), (scatter, stated)
    # Firth's estimate lies outside of the interval of the textbooks, which has another.
    step = v50(lambda velocity, shot: (velocity < 105.0, 5.0), designs.Plan(v), len(v), tests=0, beside=False)
    assert (step.fit.method, [row[3] for row in step.rows()]) == ("Firth", ["none"] * 3)


def test_only_the_error_of_the_guess_matters():
    # Standard deviations of 2 and 5 % of V50, the same random numbers: the same tests, moved.
    nodes = []
    for middle in (1250.0, 500.0):
        calibration = limit.Calibration(designs.Neyer(middle - 100, middle + 100, 25), 20, tests=200)
        nodes.append([calibration.node(0, 0), calibration.node(1, -1)])
    assert numpy.allclose(nodes[0], nodes[1], atol=0.001), nodes


def test_an_interval_of_few_shots_is_wider_than_chi_squared_promises():
    design = designs.Neyer(80, 120, 5)
    calibration = limit.Calibration(design, 12, tests=200)
    # Where the guess of sigma is far too small most shots are spent on the way.
    assert (calibration.node(0, 4) > 3.84).all()


def test_bounds_of_shots_that_are_all_alike():
    none = (-math.inf, math.inf)
    for shots, through, bounds, told in (
        # 0.5^6 < 0.025 < 0.5^5: the sixth fastest; 0.01 < 0.025: the fastest; 0.99^10 is no evidence.
        (10, False, [none, (104.0, math.inf), (109.0, math.inf)], "All 10 shots were stopped"),
        (10, True, [(-math.inf, 100.0), (-math.inf, 105.0), none], "All 10 shots went through"),
        (1, True, [(-math.inf, 100.0), none, none], "The one shot"),
    ):
        found = limit.fit(100.0 + numpy.arange(shots), [through] * shots)
        assert ([tuple(x) for x in found.intervals], found.method, found.through) == (bounds, "none", shots * through)
        assert told in found.notes[0]


def test_wrong_way_round():
    found = limit.fit([90.0, 100.0, 110.0], [True, True, False])
    assert set(found.intervals) == {(-math.inf, math.inf)}
    assert "no fit" in found.notes[0]


def test_no_overlap_says_so_and_bounds_little():
    found = limit.fit([90.0, 100.0, 104.0, 110.0], [False, False, True, True], tests=100)
    assert found.method == "Firth"
    assert "do not overlap" in found.notes[0]
    assert found.intervals[1].low < 100
    assert found.intervals[1].high > 104
    interval, profile = found.intervals[1], found.profile[1]
    assert interval.high - interval.low > profile.high - profile.low


def test_the_estimate_of_few_shots_is_a_possible_fabric():
    # Eight shots of a bracket: V50 was said to be -1.4 m/s, with the interval [19.0, 40.2].
    velocities = [100.0, 50.0, 25.0, 37.5, 31.25, 28.125, 26.5625, 23.3]
    found = limit.fit(velocities, [True, True, False, True, True, True, True, False], tests=0)
    assert found.method == "Firth"
    assert 20.0 < found.mu < 30.0, found
    assert found.deviation <= found.mu / 3
    assert found.intervals[1].low < found.mu < found.intervals[1].high


def test_an_estimate_outside_of_its_interval_is_not_known():
    # 30 shots whose share hardly grows, as of a mixture of attitudes: V01 was 52.0 m/s with the interval [74.8, 213.8].
    shots = groups((150, 3, 10), (300, 5, 10), (450, 7, 10))
    found = limit.fit(shots[0][0], shots[1][0], tests=0)
    assert found.deviation > found.mu / 3
    assert math.isnan(found.velocities[0]), found
    assert found.intervals[1].low < found.velocities[1] < found.intervals[1].high
    assert "more than a third of V50" in " ".join(found.notes)
    assert "are left out: V01" in " ".join(found.notes)


def test_any_few_shots_give_ordered_intervals():
    random = numpy.random.default_rng(11)
    for _ in range(60):
        shots = int(random.integers(1, 8))
        velocities = numpy.round(random.normal(100, 10, shots), int(random.integers(-1, 3)))
        through = random.random(shots) < 0.5
        found = limit.fit(velocities, through, str(random.choice(["probit", "logit"])), tests=20 if shots == 5 else 0)
        for interval in (*found.intervals, *found.profile):
            assert interval.low < interval.high
        if found.method != "none":
            for value, interval in zip(found.velocities, found.intervals):
                assert math.isnan(value) or interval.low <= value <= interval.high
            assert found.sigma > 0.0


def test_bad_arguments_are_named():
    for arguments, name in (
        (([], []), "velocities"),
        (([1.0, math.nan], [True, False]), "velocities"),
        (([1.0, 2.0], [True]), "through"),
    ):
        with pytest.raises(ValueError, match=name):
            limit.fit(*arguments)
    with pytest.raises(ValueError, match="link"):
        limit.fit([1.0, 2.0], [False, True], "cauchy")
    with pytest.raises(ValueError, match="confidence"):
        limit.fit([1.0, 2.0], [False, True], confidence=1.5)
    v, y, r = (
        [50.0, 52.0, 54.0, 56.0, 58.0, 60.0],
        [0, 1, 0, True, numpy.int64(1), numpy.True_],
        [0.0, 9.0, math.nan, 20.0, 25.0, 30.0],
    )
    assert limit.fit(v, y, tests=0).through == 4
    calls = (
        lambda v, y: limit.fit(v, y, tests=0),
        limit.falling,
        limit.standard_average,
        lambda v, y: limit.residual_fit(v, y, r),
    )
    for call in calls:
        call(v, y)
        for one in (math.nan, None, "0", "P", 2, 0.5, -1):
            with pytest.raises(ValueError, match=r"^through\[5\]: must be True or False, or 1 or 0; it is "):
                call(v, [*y[:5], one])
        for one in (math.nan, math.inf, -60.0, 0.0, "fast"):
            with pytest.raises(ValueError, match=r"^velocities.*: must be a "):
                call([*v[:5], one], y)
        for velocities, results in (([v], [y]), ([], []), (v, y[:5]), (v, [y]), (v[:5], y)):
            with pytest.raises(ValueError, match="^(velocities|through): must be a list of "):
                call(velocities, results)
    for arguments, name in (
        ({"residuals": [*r[:5], -1.0]}, r"residuals\[5\]"),
        ({"residuals": r[:5]}, "residuals"),
        ({"residuals": [math.nan] * 6}, r"residuals\[1\]"),
        ({"power": -1.0}, "power"),
        ({"power": math.nan}, "power"),
    ):
        with pytest.raises(ValueError, match=f"^{name}: must be"):
            limit.residual_fit(v, y, **{"residuals": r} | arguments)
    for shares in ((), (0.5, 1.0), (math.nan,), 0.5):
        with pytest.raises(ValueError, match="^shares"):
            limit.fit(v, y, shares=shares)
    with pytest.raises(ValueError, match="sigma"):
        designs.Neyer(1, 2, 0)
    with pytest.raises(ValueError, match="low"):
        designs.ThreePhase(2, 1, 1)


def test_the_standard_average():
    v = numpy.array([90.0, 95.0, 97.0, 96.0, 99.0, 105.0])
    y = numpy.array([False, False, False, True, True, True])
    # Three of each within 27 m/s.
    assert limit.standard_average(v, y) == limit.Average(97.0, 6, 15.0)
    # 90, 60 and 99, 130 lie too far apart for two of each.
    assert math.isnan(limit.standard_average([60.0, 90.0, 99.0, 130.0], [False, False, True, True]).value)


def test_residual_velocities_that_follow_the_curve():
    v = numpy.array([90.0, 95.0, 101.0, 104.0, 108.0, 115.0, 125.0, 140.0])
    through = v > 100.0
    found = limit.residual_fit(v, through, limit.lambert_jonas(v, 100.0, 0.9, 2.5))
    assert found.limit == pytest.approx(100.0, rel=0, abs=5e-3)
    assert found.a == pytest.approx(0.9, rel=0, abs=5e-4)
    assert found.p == pytest.approx(2.5, rel=0, abs=5e-3)
    few = limit.residual_fit(v[:5], through[:5], limit.lambert_jonas(v[:5], 100.0, 0.9, 2.0))
    assert few.limit == pytest.approx(100.0, rel=0, abs=5e-3)
    assert few.p == 2.0
    assert math.isnan(limit.residual_fit(v[:3], through[:3], v[:3]).limit)


def test_a_stopped_shot_above_the_limit_counts():
    v = numpy.array([101.0, 104.0, 108.0, 115.0, 125.0])
    r = limit.lambert_jonas(v, 100.0, 0.9, 2.0)
    free = limit.residual_fit(v, numpy.ones(5, bool), r)
    censored = limit.residual_fit(numpy.append(v, 112.0), numpy.append(numpy.ones(5, bool), False), numpy.append(r, 0.0))
    assert censored.error > 10 * free.error


def test_the_most_informative_velocities_are_those_of_the_books():
    # D-optimal for two parameters: mu +- 1.138 sigma (probit), +- 1.543 sigma (logit).
    for link, z in ((PROBIT, 1.138), (LOGIT, 1.543)):
        for side in (-1, 1):
            shots = numpy.array([[-z, z, -side * z]]) * 4 + 100
            found = designs.most_informative(shots, numpy.array([100.0]), numpy.array([4.0]), link)
            assert (found[0] - 100) / 4 == pytest.approx(side * z, rel=0, abs=0.026)


def walk(design, results):
    """The velocities for given results."""
    design.start(1)
    velocities = []
    for k in range(len(results) + 1):
        velocities.append(
            float(design.next(numpy.array([velocities]).reshape(1, -1), numpy.array([results[:k]], bool).reshape(1, -1))[0])
        )
    return velocities


def test_neyer_by_hand():
    design = designs.Neyer(80, 120, 5)
    # Middle; then up as far as half way to the end, two sigma, or the range again.
    assert walk(design, [0, 0, 0]) == [100.0, 110.0, 120.0, 140.0]
    assert walk(design, [1, 1, 1]) == [100.0, 90.0, 80.0, 60.0]
    # Halves while the gap is above sigma.
    assert walk(design, [0, 1]) == [100.0, 110.0, 105.0]


def test_a_bracket_by_hand():
    for kind in (designs.Neyer, designs.ThreePhase):
        # Twice the fastest or half the slowest, then the middle of the two.
        assert walk(kind.bracketed(100.0), [0, 0, 0]) == [100.0, 200.0, 400.0, 800.0]
        assert walk(kind.bracketed(100.0), [1, 1, 1]) == [100.0, 50.0, 25.0, 12.5]
        assert walk(kind.bracketed(100.0), [1, 1, 0, 0]) == [100.0, 50.0, 25.0, 37.5, 43.75]
    # The guess of sigma is 5 % of the middle of the bracket, 75 m/s: a gap of 6.25 is halved, one of 3.125 is not.
    path = walk(designs.Neyer.bracketed(100.0), [1, 0, 0, 0, 0, 0])
    assert path[2:6] == [75.0, 87.5, 93.75, 96.875]
    assert path[6] != 98.4375
    with pytest.raises(ValueError, match="first: must be positive"):
        designs.Neyer.bracketed(0.0)


def test_no_velocity_is_below_half_of_the_slowest():
    random = numpy.random.default_rng(12)
    for design in (
        designs.Neyer(60, 140, 5),
        designs.Neyer(1, 199, 60),
        designs.ThreePhase(60, 140, 5),
        designs.ThreePhase(1, 199, 60),
        designs.ThreePhase(60, 140, 30, aim=0.01, last=15, shots=30),
        designs.Neyer.bracketed(100.0),
        designs.ThreePhase.bracketed(100.0),
    ):
        # Results that are mostly "through", whatever the velocity.
        through = random.random((300, 30)) < random.choice([0.6, 0.9, 1.0], (300, 1))
        design.start(300)
        velocities = numpy.empty((300, 30))
        for shot in range(30):
            velocities[:, shot] = design.next(velocities[:, :shot], through[:, :shot])
            if shot:
                assert (velocities[:, shot] >= 0.5 * velocities[:, :shot].min(axis=1)).all()
        assert numpy.isfinite(velocities).all()


def test_any_first_velocity_finds_v50():
    # Single limits of 100 m/s with a known spread, from a hundredth to a hundred times of it.
    random = numpy.random.default_rng(13)
    for kind in (designs.Neyer, designs.ThreePhase):
        for start in (1.0, 10.0, 100.0, 1000.0, 10000.0):
            for deviation in (0.2, 3.0):
                velocities, through = designs.simulate(kind.bracketed(start), 30, random.normal(100.0, deviation, (2, 30)))
                for v, y in zip(velocities, through):
                    found = limit.fit(v, y, tests=0)
                    low, high = found.intervals[1]
                    assert 80.0 < low < found.mu < high < 125.0, (start, deviation, found)
                    assert high - low < 6.0 * max(deviation, 0.5), (start, deviation, found)


def test_neyer_is_symmetric():
    results = [0, 1, 0, 1, 1, 0, 0, 1, 0, 1]
    one = walk(designs.Neyer(80, 120, 5), results)
    other = walk(designs.Neyer(80, 120, 5), [1 - result for result in results])
    assert numpy.allclose(numpy.array(one) + other, 200.0, atol=1e-06)


def test_three_phases_by_hand():
    design = designs.ThreePhase(80, 120, 4)
    assert walk(design, [0, 0, 0, 0]) == [90.0, 110.0, 126.0, 138.0, 156.0]
    assert walk(design, [1, 1, 1]) == [90.0, 110.0, 74.0, 62.0]
    assert walk(design, [1, 0, 0])[2:] == [68.0, 132.0]
    # The gap of 20 is halved down to 5 < 1.5 * 4; then 0.3 * 4 beside it, first where the rarer result lies, then on the
    # other side, then two thirds of the guess, for which the gap is wide again.
    path = walk(design, [0, 1, 0, 1, 0, 1])
    assert numpy.allclose(path[2:], [100.0, 105.0, 100 - 1.2, 105 + 1.2, 102.5])
    beside = walk(design, [0, 1, 0, 0])
    assert beside[2:] == [100.0, 105.0, 111.2]
    # It was stopped: overlap of 1.2, strengthened half a sigma on both sides of its middle.
    after = walk(design, [0, 1, 0, 0, 0, 1])
    assert numpy.allclose(after[5:], [112.6, 108.6])


def test_the_last_shots_approach_their_share():
    random = numpy.random.default_rng(8)
    design = designs.ThreePhase(80, 120, 5, aim=0.1, last=25, shots=50)
    velocities, _ = designs.simulate(design, 50, random.normal(100, 5, (200, 50)))
    # V10 is 93.6.
    assert float(velocities[:, -1].mean()) == pytest.approx(100 - 1.2816 * 5, rel=0, abs=0.5)
    assert velocities[:, -1].std() < 3.0


def test_a_test_alone_is_the_same_as_among_others():
    random = numpy.random.default_rng(9)
    limits = random.normal(100, 5, (6, 25))
    for design in (designs.Neyer(80, 120, 5), designs.ThreePhase(80, 120, 5, aim=0.01, last=5, shots=25)):
        together, _ = designs.simulate(design, 25, limits)
        for k in range(6):
            assert numpy.allclose(designs.simulate(design, 25, limits[k : k + 1])[0][0], together[k], atol=1e-09)


LIMITS = numpy.random.default_rng(10).normal(100, 4, 60)


def shoot(velocity, shot):
    own = LIMITS[shot]
    return velocity <= own, 0.9 * math.sqrt(max(velocity**2 - own**2, 0.0))


def test_a_test_from_the_first_shot_to_the_page(tmp_path):
    lines = []
    test = v50(shoot, designs.Neyer(80, 120, 5), 20, tests=100, say=lines.append, title="A < B")
    assert (len(lines), len(test.shots), len(test.ladder)) == (50, 20, 30)
    assert test.fit.intervals[1].low < 100 < test.fit.intervals[1].high
    text = test.text()
    for words in ("Neyer", "seed 1", "V01", "V50", "V99", "95 % interval", "MIL-STD-662F", "Lambert"):
        assert words in text
    assert sum(line.strip().startswith(f"{k} ") for k, line in zip(range(1, 51), text.splitlines()[-50:])) == 50
    test.write(tmp_path / "one")
    test.write(tmp_path / "two")
    page = (tmp_path / "one/report.html").read_text()
    assert "A &lt; B" in page
    assert 'src="plot' not in page
    assert page == (tmp_path / "two/report.html").read_text()
    assert len((tmp_path / "one/shots.csv").read_text().splitlines()) == 51
    assert json.loads((tmp_path / "one/test.json").read_text())["fit"]["mu"] == pytest.approx(test.fit.mu, rel=0, abs=5e-8)
    assert LimitTest.read(tmp_path / "one").text() == text
    assert repr(test).startswith("<LimitTest 'A < B', 20 shots: V50 ")
    assert "<table>" in test._repr_html_()
    (tmp_path / "one/test.json").write_text('{"title": 1}')
    with pytest.raises(ValueError, match="test.json: is cut off, or not as this version writes it"):
        LimitTest.read(tmp_path / "one")


def test_every_degenerate_test_has_a_report(tmp_path):
    for shoot, shots in (
        (lambda v, k: (True, 0.0), 1),
        (lambda v, k: (True, 0.0), 8),
        (lambda v, k: (False, v), 2),
        (lambda v, k: (v > 101, v), 3),
        (lambda v, k: (v < 101, 0.5 * v), 5),
    ):
        test = v50(shoot, designs.Neyer(80, 120, 5), shots, tests=20)
        assert test.fit.notes
        test.write(tmp_path)
        assert LimitTest.read(tmp_path / "test.json").text() == test.text()


def test_twelve_shots_that_are_alike_end_the_test_with_their_bound():
    for first, through, bound in ((100.0, False, (100.0 * 2**6, math.inf)), (100.0, True, (-math.inf, 100.0 / 2**6))):
        test = v50(lambda v, k: (not through, v), designs.Neyer.bracketed(first), 30, tests=20)
        assert [shot.velocity for shot in test.shots] == [first * 2.0 ** (-k if through else k) for k in range(12)]
        # 0.5^6 < 0.025 < 0.5^5: the sixth fastest, or the sixth slowest.
        assert tuple(test.fit.intervals[1]) == bound
        assert "ended the test without a V50" in test.notes[0]
    # With a guess that is far off, too; no velocity is zero or less.
    test = v50(lambda v, k: (False, v), designs.Neyer(60, 140, 5), 30, tests=20)
    assert [shot.velocity for shot in test.shots] == [100.0, 80.0, 60.0, *(60.0 / 2**k for k in range(1, 10))]


def test_a_shot_of_unknown_end_is_left_out():
    numbers = []

    def shoot(velocity, shot):
        numbers.append(shot)
        if velocity > 500.0 or shot in (0, 6):
            raise Unknown(f"shot {shot + 1}: timeout")
        return stopped(velocity), 0.0

    # This velocity again with the next draw; three in turn end a bracket with its bound.
    stopped = lambda velocity: True
    test = v50(shoot, designs.Neyer.bracketed(100.0), 20, tests=20)
    assert [shot.velocity for shot in test.shots] == [100.0, 200.0, 400.0]
    assert numbers[:7] == list(range(7))
    assert test.notes[:2] == ("Left out: shot 1: timeout.", "Left out: shot 5: timeout.")
    assert "without a V50, as all known results are alike" in test.notes[-1]
    stopped = lambda velocity: velocity < 150.0
    test = v50(shoot, designs.Neyer.bracketed(100.0), 20, tests=20)
    assert (len(test.shots), [note for note in test.notes if "Left out" in note][1]) == (20, "Left out: shot 7: timeout.")
    # Where nothing is known yet it is an error.
    with pytest.raises(Unknown):
        v50(shoot, designs.Neyer.bracketed(600.0), 20, tests=20)


def test_a_plan_is_shot_as_it_stands():
    plan = [90.0, 110.0, 95.0, 105.0]
    test = v50(shoot, designs.Plan(plan), 4, tests=20)
    assert [shot.velocity for shot in test.shots] == plan
    with pytest.raises(ValueError, match="shots"):
        v50(shoot, designs.Plan(plan), 5)
