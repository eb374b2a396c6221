"""The ballistic limit with its interval: V01, V50 and V99 from shots that were stopped or went through.

Estimate: maximum likelihood, or Firth's penalised likelihood where results do not overlap. No estimate where all results are
alike or where the faster shots did not go through more often, nor of a share whose estimate is negative or outside of its
interval.
Interval: a velocity belongs to it if the ratio of Firth's penalised likelihoods, at the best fit and with this velocity held, is
not rarer than the confidence allows. How rare it is comes from simulated tests of the same design with as many shots against a
fabric that has this velocity (and the sigma that fits it best), not from chi squared, which promises too much for few shots and
for shots that are chosen from the results. Intervals may have no end on one side or on both; below FEWEST shots only that of V50
is told.
Velocities that are all greater by s have the interval that is greater by s, but for a bracket, whose design supposes that no
limit is negative, so that their standard deviation is at most a third of V50: a note says where this gives an end.
docs/tables/v50.md has the coverage.
Profile: the plain profile-likelihood interval of the textbooks, for comparison.
Alike: if all results are alike there is still a bound without any model: if m shots faster than t were all stopped, a fabric that
lets a share p through at t does that with a probability below (1 - p)^m.
Limits: the distribution is taken as known; its wrong choice moves V01 and V99, hardly V50. Simulated quantiles are interpolated
between tests at whole steps of the design's scale, each from `tests` simulated tests.
Reference: B. T. Neyer, in: Proc. 16th Int. Pyrotechnics Seminar (1991), for the likelihood ratio; D. Firth, Biometrika 80 (1993)
27; J. P. Lambert and G. H. Jonas, BRL Report 1852 (1976); MIL-STD-662F (1997).
"""

import dataclasses
import math
from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple

import numpy
import scipy  # Its parts are loaded where they are used.
from numpy.typing import ArrayLike

from . import checks, designs
from .checks import Array
from .likelihood import LARGEST, LINKS, ends, firth, maximum, possible, possible_ratio, ratio
from .record import record

SHARES = (0.01, 0.5, 0.99)
FEWEST = 10
"""Shots from which on other shares than 50 % are reported: with 6 shots 95 % intervals of V01 hold it in 71 to 100 % of simulated
tests, with 10 in 91 % or more (docs/tables/v50.md)."""
FREE = 5
"""Shots at different velocities that went through from which on the power of residual velocities is fitted."""
BAD = 0.05
"""Error of a fit of residual velocities, over its limit, above which the fit is bad."""


class Interval(NamedTuple):
    """m/s. An end that the shots do not give is infinite."""

    low: float
    high: float

    def __str__(self) -> str:
        low, high = (f"{end:.1f}" if math.isfinite(end) else None for end in self)
        if low and high:
            return f"[{low}, {high}]"
        return f"above {low}" if low else f"below {high}" if high else "no bound"


@record
class Fit:
    """One test."""

    link: Annotated[str, "probit or logit"]
    confidence: Annotated[float, "of the intervals"]
    shots: Annotated[int, "number of shots"]
    through: Annotated[int, "shots that went through"]
    method: Annotated[str, "maximum likelihood, Firth or none"]
    mu: Annotated[float, "V50, m/s; NaN if there is no estimate"]
    sigma: Annotated[float, "scale of F, m/s"]
    deviation: Annotated[float, "standard deviation of single limits, m/s"]
    shares: Annotated[tuple[float, ...], "shares that velocities are given for"]
    velocities: Annotated[tuple[float, ...], "at which these shares go through, m/s; NaN where not known"]
    intervals: Annotated[tuple[Interval, ...], "of velocities, m/s"]
    assumed: Annotated[tuple[bool, ...], "whether an end of the interval is assumed (`LARGEST`), or open"]
    profile: Annotated[tuple[Interval, ...], "plain profile-likelihood intervals"]
    notes: Annotated[tuple[str, ...], "what the reader must know"]


class Calibration:
    """Quantiles of the likelihood ratio in simulated tests of one design.

    They depend on where mu and sigma of the fabric lie beside a centre and a scale, those of the design if no others are given.
    Simulated at whole steps (a step in mu is the larger of sigma and scale, a step in sigma is a factor 2) and when first needed;
    linear in between."""

    STEPS = 6

    def __init__(
        self,
        design: Any,
        shots: int,
        link: str = "probit",
        confidence: float = 0.95,
        shares: Any = SHARES,
        tests: int = 1000,
        seed: int = 1,
        about: Any = None,
    ) -> None:
        rank = checks.rank(confidence, checks.whole("tests", tests, 1))
        # The rank of the quantile, and one below by the standard deviation of its number of tests.
        off = max(1, round(math.sqrt(tests * confidence * (1 - confidence))))
        self.ranks = [rank - 1, rank - 1 - off]
        self.centre, self.scale = about or (design.centre, design.scale)
        self.design, self.shots, self.link, self.confidence = design, shots, LINKS[link], confidence
        self.quantiles = [float(self.link.quantile(share)) for share in shares]
        self.tests, self.seed = tests, seed
        self.known: dict[Any, Any] = {}

    def node(self, column: Any, row: Any) -> Any:
        """The quantile for each share where sigma is 2^row scales and mu `column` steps from the centre, and with its error."""
        if (column, row) not in self.known:
            sigma = self.scale * 2.0**row
            mu = self.centre + column * max(sigma, self.scale)
            # Random numbers of its own: the order in which nodes are asked for changes nothing.
            random = numpy.random.default_rng([self.seed, column + 1000, row + 1000])
            limits = mu + sigma * self.link.sample(random, (self.tests, self.shots))
            velocities, through = designs.simulate(self.design, self.shots, limits)
            # A corner beyond the possible fabrics is only there for the interpolation.
            largest = self.design.largest if self.link.deviation * sigma <= self.design.largest * mu else math.inf
            best, found = possible(velocities, through, self.link, largest), []
            for quantile in self.quantiles:
                truth = numpy.full(self.tests, mu + sigma * quantile)
                values = possible_ratio(best, velocities, through, self.link, truth, quantile, largest)[0]
                # Without a fit the interval has no end: it holds the truth.
                found.append(numpy.sort(numpy.nan_to_num(values))[self.ranks])
            self.known[column, row] = numpy.array(found)
        return self.known[column, row]

    def allowed(self, at: Any, sigma: Any, shares: Any, rank: int = 0) -> Any:
        """The ratio that is allowed to a fabric with this sigma which lets a share through at the velocity `at`; shares: their
        numbers. rank: 1 takes off a standard deviation of its error."""
        quantiles = numpy.array(self.quantiles)[shares]
        mu = at - quantiles * sigma
        rows = numpy.clip(numpy.log2(sigma / self.scale), -self.STEPS, self.STEPS)
        result = numpy.zeros(len(rows))
        for side in (0, 1):
            row = numpy.floor(rows).astype(int) + side
            part_row = 1 - numpy.abs(rows - row)
            step = self.scale * 2.0 ** numpy.maximum(row, 0)
            columns = numpy.clip((mu - self.centre) / step, -self.STEPS, self.STEPS)
            for other in (0, 1):
                column = numpy.floor(columns).astype(int) + other
                part = part_row * (1 - numpy.abs(columns - column))
                for k in numpy.flatnonzero(part > 0):
                    result[k] += part[k] * self.node(int(column[k]), int(row[k]))[shares[k], rank]
        return result


def alike(velocities: Array, through: Array, share: Any, confidence: float) -> Any:
    """The interval from shots of which all were stopped, or all went through."""
    miss = 0.5 * (1 - confidence)
    all_stopped = not through.any()
    rarity = 1 - share if all_stopped else share
    needed = math.ceil(math.log(miss) / math.log(rarity))
    ordered = numpy.sort(velocities)
    if needed > len(ordered):
        return Interval(-math.inf, math.inf)
    return Interval(float(ordered[-needed]), math.inf) if all_stopped else Interval(-math.inf, float(ordered[needed - 1]))


RARE, FALSE_ALARM = 0.002, 0.01
"""`falling` names what is drawn no more often than RARE. The share that it draws from follows the chances of the shots, so it
doubts shots whose share grows with the velocity, or stays, somewhat more often than that, but at most in FALSE_ALARM
(tests/python/test_limit.py)."""


def checked(velocities: ArrayLike, through: ArrayLike) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Velocities, m/s, and whether the shots went through, as arrays. Raises ValueError that names the argument."""
    velocities = checks.numbers("velocities", velocities)
    return velocities, checks.results("through", through, len(velocities))


def falling(velocities: ArrayLike, through: ArrayLike, seed: int = 1, draws: int = 999) -> str:
    """A sentence if the shots contradict a share that grows with the velocity; else nothing. Raises ValueError that names the
    argument.

    Counted are the pairs in which the slower shot went through and the faster was stopped; there are too many if at most RARE of
    as many draws from the growing share that fits the shots best (isotonic regression) have so many."""
    checks.whole("draws", draws, 1)
    v, results = checked(velocities, through)
    results = results.astype(float)
    _, place, shots = numpy.unique(v, return_inverse=True, return_counts=True)
    share = scipy.optimize.isotonic_regression(numpy.bincount(place, results) / shots, weights=shots).x
    slower = (v[:, None] < v[None]).astype(float)
    pairs = lambda y: ((y @ slower) * (1.0 - y)).sum(-1)
    drawn = numpy.random.default_rng(seed).random((draws, len(v))) < share[place]
    rarity = (1 + int((pairs(drawn.astype(float)) >= pairs(results)).sum())) / (draws + 1)
    if rarity > RARE:
        return ""
    return (
        "The share that goes through does not grow with the velocity: a share that grows gives such shots in "
        f"{100 * rarity:.2g} % of tests. "
        "A limit and its interval mean little here: look at the shots, and shoot at lower velocities, too."
    )


def name(share: float) -> str:
    """V01, V50, V99."""
    return f"V{100 * share:04.1f}" if round(100 * share, 6) % 1 else f"V{100 * share:02.0f}"


def outer_ends(excess: Any, starts: Any, directions: Any, step: Any, reach: Any) -> Any:
    """Where `excess` (of an array of velocities, one for each end) is at most 0 for the last time away from the starts: inwards
    from `reach` in steps of a third, then by false position (Illinois). What is still at most 0 at `reach` has no end."""
    outside, inside = starts + directions * reach, starts.copy()
    f_outside, f_inside = excess(outside), numpy.full(len(starts), -1e-9)
    none = f_outside <= 0
    size, searched = reach / 1.5, ~none
    while searched.any() and size > 0.01 * step:
        at = numpy.where(searched, starts + directions * size, starts)
        value = excess(at)
        within = searched & (value <= 0)
        inside[within], f_inside[within] = at[within], value[within]
        searched &= ~within
        outside[searched], f_outside[searched] = at[searched], value[searched]
        size /= 1.5
    side = numpy.zeros(len(starts))
    for _ in range(40):
        # The value of an end that stays is halved again and again.
        weight_in, weight_out = f_inside * 0.5 ** numpy.maximum(side - 1, 0), f_outside * 0.5 ** numpy.maximum(-side - 1, 0)
        with numpy.errstate(divide="ignore", invalid="ignore"):
            at = (inside * weight_out - outside * weight_in) / (weight_out - weight_in)
        at = numpy.where(none | ~numpy.isfinite(at), 0.5 * (inside + outside), at)
        value = excess(at)
        beyond = value > 0
        outside, f_outside = numpy.where(beyond, at, outside), numpy.where(beyond, value, f_outside)
        inside, f_inside = numpy.where(beyond, inside, at), numpy.where(beyond, f_inside, value)
        side = numpy.where(beyond, numpy.maximum(side, 0) + 1, numpy.minimum(side, 0) - 1)
        if (none | (numpy.abs(value) < 1e-5) | (numpy.abs(outside - inside) < 1e-6 * step)).all():
            break
    return numpy.where(none, directions * numpy.inf, at)


def asked(link: str, confidence: float, tests: int) -> None:
    """Raises ValueError that names the argument which `fit` would refuse."""
    checks.confident(confidence)
    if link not in LINKS:
        checks.refuse("link", '"probit" or "logit"', link)
    if checks.whole("tests", tests, 0):
        checks.rank(confidence, tests)


def fit(
    velocities: ArrayLike,
    through: ArrayLike,
    link: str = "probit",
    confidence: float = 0.95,
    shares: Sequence[float] = SHARES,
    design: "designs.Neyer | designs.ThreePhase | designs.Plan | None" = None,
    tests: int = 1000,
    seed: int = 1,
    calibration: "Calibration | None" = None,
) -> Fit:
    """The fit of one test with its intervals.

    velocities, m/s, and through: in the order of the shots. design: the one that chose them; without it the velocities count as
    given beforehand. tests, seed: of the simulations behind the intervals; tests 0: chi squared instead, in milliseconds.
    calibration: one that was made before for this design, number of shots, link, confidence and shares.
    Raises ValueError that names the argument."""
    velocities, through = checked(velocities, through)
    asked(link, confidence, tests)
    shares = checks.numbers("shares", shares).tolist()
    if not all(share < 1 for share in shares):
        checks.refuse("shares", "between 0 and 1", shares)
    law, hits, count = LINKS[link], int(through.sum()), len(velocities)
    v, y = velocities[None], through[None]

    def without_fit(bounds: Any, note: Any) -> Any:
        nan, missing, assumed = math.nan, (math.nan,) * len(shares), (True,) * len(shares)
        every = tuple(shares)
        return Fit(link, confidence, count, hits, "none", nan, nan, nan, every, missing, bounds, assumed, bounds, (note,))

    if hits in (0, count):
        bounds = tuple(alike(velocities, through, share, confidence) for share in shares)
        which = f"All {count} shots" if count > 1 else "The one shot"
        what = "went through" if hits else "were stopped" if count > 1 else "was stopped"
        return without_fit(bounds, f"{which} {what}: no fit; the bounds need no model.")
    # Where no design is told, velocities that were given beforehand.
    design = design or (calibration.design if calibration else designs.Plan(velocities))
    largest = design.largest
    best, penalised = maximum(v, y, law), firth(v, y, law, largest)
    if not penalised.sigma[0] > 0:
        bounds = (Interval(-math.inf, math.inf),) * len(shares)
        return without_fit(bounds, "The faster shots did not go through more often: no fit, and no bound.")
    notes = []
    overlap = best.sigma[0] > 0
    mu, sigma = (float(x[0]) for x in ((best.mu, best.sigma) if overlap else (penalised.mu, penalised.sigma)))
    if not overlap:
        stopped, passed = (float(end[0]) for end in ends(v, y))
        notes.append(
            f"Results do not overlap (highest stopped {stopped:.6g} m/s, lowest through {passed:.6g} m/s): Firth's estimate; "
            "the sigma of the likelihood alone is 0."
        )
    chi = scipy.special.chdtri(1, 1 - confidence)
    if calibration is None and tests:
        calibration = Calibration(design, count, link, confidence, shares, tests, seed, design.middle(velocities, through))
    quantiles = numpy.array([float(law.quantile(share)) for share in shares])
    width = float(numpy.ptp(velocities))

    numbers, directions = numpy.repeat(numpy.arange(len(shares)), 2), numpy.tile([-1.0, 1.0], len(shares))
    q = quantiles[numbers]

    def intervals(centre: Any, scale: Any, excess: Any) -> Any:
        """Both ends of every share."""
        starts = centre + q * scale
        reach = 300 * (width + float(numpy.abs(starts - velocities.mean()).max()))
        return outer_ends(excess, starts, directions, 0.1 * width, reach)

    def plain(at: Any) -> Any:
        return ratio(best.level, v, y, law, at, q, 0.0)[0] - chi

    level = possible(v, y, law, largest)

    def calibrated(at: Any, rank: int = 0) -> Any:
        value, held_sigma = possible_ratio(level, v, y, law, at, q, largest)
        if not calibration:
            return value - chi
        # No quantile comes near this.
        near = value < 30.0
        allowed = numpy.zeros(len(at))
        allowed[near] = calibration.allowed(at[near], held_sigma[near], numbers[near], rank)
        return value - allowed

    # A fit beyond the possible fabrics: from the nearest of them.
    mu0, sigma0 = float(penalised.mu[0]), float(penalised.sigma[0])
    if law.deviation * sigma0 > largest * mu0:
        mu0 = float(velocities.mean())
        sigma0 = float(possible_ratio(level, v, y, law, numpy.array([mu0]), 0.0, largest)[1][0])
    if calibration and abs(math.log2(sigma0 / calibration.scale)) > calibration.STEPS - 1:
        scale = calibration.scale
        notes.append(
            f"The design's scale, {scale:.3g} m/s, is far from the sigma that was found: the intervals are extrapolated."
        )
    found = intervals(mu0, sigma0, calibrated)
    if calibration and 0.5 in shares:
        of_v50 = slice(2 * shares.index(0.5), 2 * shares.index(0.5) + 2)
        with numpy.errstate(invalid="ignore"):  # Ends that are not bounded.
            errors = numpy.abs(intervals(mu0, sigma0, lambda at: calibrated(at, 1)) - found)[of_v50]
        if finite := " and ".join(f"{error:.2g}" for error in errors if math.isfinite(error)):
            notes.append(f"Standard error of the ends of V50 by the simulated tests: {finite} m/s; four times as many halve it.")
    limited = numpy.zeros(len(found), bool)
    if largest < math.inf:
        held_sigma = possible_ratio(level, v, y, law, numpy.where(numpy.isfinite(found), found, 1.0), q, largest)[1]
        limited = numpy.isfinite(found) & (law.deviation * held_sigma > 0.99 * largest * (found - q * held_sigma))
        if limited.any():
            sides = {-1.0: "lower", 1.0: "upper"}
            which = ", ".join(f"{sides[directions[k]]} end of {name(shares[numbers[k]])}" for k in numpy.flatnonzero(limited))
            notes.append(
                f"Given not by the shots but by the assumption that the standard deviation is at most a third of V50: {which}. "
                f"More shots are needed."
            )
    told = [share == 0.5 or count >= FEWEST for share in shares]

    def bounded(ends: Any) -> Any:
        # No velocity is negative: such an end says nothing.
        pairs = zip(told, ends.reshape(-1, 2).tolist())
        return tuple(
            Interval(low if kept and low > 0 else -math.inf, high if kept and high > 0 else math.inf)
            for kept, (low, high) in pairs
        )

    calibrated_intervals = bounded(found)
    assumed = tuple(
        bool(one) or not all(map(math.isfinite, pair))
        for one, pair in zip([bool(pair.any()) for pair in limited.reshape(-1, 2)], calibrated_intervals)
    )
    profile = bounded(intervals(float(best.mu[0]), float(best.sigma[0]), plain))
    if not all(told):
        which = ", ".join(name(share) for share, kept in zip(shares, told) if not kept)
        notes.append(
            f"{which}: not reported below {FEWEST} shots, of which there are {count}: such intervals hold the truth less "
            "often than they say."
        )
    if any(math.isinf(end) for kept, pair in zip(told, calibrated_intervals) if kept for end in pair):
        notes.append("Some ends are not bounded by these shots; more shots, or slower and faster ones, bound them.")
    estimates = zip(told, mu + quantiles * sigma, calibrated_intervals)
    values = tuple(float(x) if kept and max(low, 0.0) <= x <= high else math.nan for kept, x, (low, high) in estimates)
    if law.deviation * sigma > LARGEST * mu:
        notes.append(
            f"The standard deviation that was found, {law.deviation * sigma:.3g} m/s, is more than a third of V50. A normal "
            "law does not describe such "
            "shots, as those of mixed attitudes. Use the share stopped at your velocity (docs/tutorial.md)."
        )
    which = ", ".join(name(share) for kept, share, value in zip(told, shares, values) if kept and math.isnan(value))
    if which:
        notes.append(f"Estimates that are negative or outside of their intervals are left out: {which}.")
    method = "maximum likelihood" if overlap else "Firth"
    sd, every, found = law.deviation * sigma, tuple(shares), calibrated_intervals
    return Fit(link, confidence, count, hits, method, mu, sigma, sd, every, values, found, assumed, profile, tuple(notes))


def withheld(fit: Fit) -> Fit:
    """A fit without its numbers, as of shots that have no single limit."""
    missing, open_ends = (math.nan,) * len(fit.shares), (Interval(-math.inf, math.inf),) * len(fit.shares)
    none: dict[str, Any] = dict.fromkeys(("mu", "sigma", "deviation"), math.nan) | dict.fromkeys(
        ("intervals", "profile"), open_ends
    )
    return dataclasses.replace(fit, method="none", velocities=missing, assumed=(True,) * len(fit.shares), notes=(), **none)


@record
class Average:
    """V50 as MIL-STD-662F averages it, m/s: NaN if no such group of shots exists."""

    value: Annotated[float, "m/s; NaN without such a group"]
    shots: Annotated[int, "number of shots of the group"]
    spread: Annotated[float, "of the group, m/s"]


def standard_average(velocities: ArrayLike, through: ArrayLike) -> Average:
    """MIL-STD-662F: the mean of as many of the fastest stopped shots as of the slowest that went through, 5, 3 or 2 of each,
    within 38, 27 or 18 m/s (125, 90, 60 ft/s): the largest such group. It has no interval and takes no account of sigma.
    The spreads were not compared with the text of the standard."""
    velocities, through = checked(velocities, through)
    stopped, passed = numpy.sort(velocities[~through])[::-1], numpy.sort(velocities[through])
    for each, allowed in ((5, 38.1), (3, 27.432), (2, 18.288)):
        if min(len(stopped), len(passed)) >= each:
            group = numpy.concatenate([stopped[:each], passed[:each]])
            if numpy.ptp(group) <= allowed:
                return Average(float(group.mean()), 2 * each, float(numpy.ptp(group)))
    return Average(math.nan, 0, math.nan)


@record
class Residual:
    """v_r = a (v^p - v_l^p)^(1/p) above v_l, m/s, with a normal error of standard deviation `error`. NaN if not fitted."""

    limit: Annotated[float, "v_l, m/s"]
    a: Annotated[float, "factor a"]
    p: Annotated[float, "power p"]
    error: Annotated[float, "standard deviation of a residual velocity, m/s"]
    note: Annotated[str, "why there is no curve, or why it is bad"]

    def is_bad(self) -> bool:
        """Whether it does not describe the shots: `note` says why."""
        return self.error > BAD * self.limit or not (1.001 < self.p < 9.99 or math.isnan(self.p))

    def curve(self, velocities: Any) -> Any:
        return lambert_jonas(numpy.asarray(velocities, float), self.limit, self.a, self.p)


def lambert_jonas(velocities: Any, limit: float, a: float, p: float) -> Any:
    # Relative to the velocity: large powers do not overflow.
    part = numpy.minimum(numpy.maximum(limit / numpy.maximum(velocities, 1e-300), 0.0), 1.0)
    return a * velocities * numpy.power(1 - numpy.power(part, p), 1 / p)


def residual_fit(
    velocities: ArrayLike, through: ArrayLike, residuals: ArrayLike, power: float | None = None, start: "Residual | None" = None
) -> Residual:
    """The fit of Lambert and Jonas to residual velocities, stopped shots censored at 0 (Tobit), by maximum likelihood.

    velocities, residuals: m/s; through: whether each shot went through, whose residual velocities alone count. a from 0 to 1 and
    p from 1 to 10. power: p is this and not fitted; 2 is the curve of Recht and Ipson. Without it p is 2 too if fewer than five
    shots went through at different velocities; nothing is fitted for fewer than three. start: where the search begins, for speed;
    else in eight places.
    `note` says what the reader must know: also that p lies at its bound, or that the error is above 5 % of the limit, where the
    curve does not describe the shots."""
    velocities, through = checked(velocities, through)
    if numpy.shape(residuals) == velocities.shape:
        residuals = numpy.where(through, residuals, 0.0)
    residuals = checks.numbers("residuals", residuals, zero=True, count=len(velocities))
    if power is not None and not 1.0 <= power <= 10.0:
        checks.refuse("power", "from 1 to 10, or None", power)
    different = len(numpy.unique(velocities[through]))
    if different < 3:
        note = "Fewer than three shots went through at different velocities: no fit of the residual velocities."
        return Residual(math.nan, math.nan, math.nan, math.nan, note)
    free, held = power is None and different >= FREE, power or 2.0
    scale = float(velocities.max())
    v, r = velocities / scale, residuals / scale
    least = 1e-5

    def cost(x: Array) -> Any:
        limit, a, p, error = x[0], x[1], x[2] if free else held, math.exp(x[-1])
        expected = lambert_jonas(v, limit, a, p)
        density = -0.5 * ((r - expected) / error) ** 2 - math.log(error) - 0.5 * math.log(2 * math.pi)
        return -float(numpy.where(through, density, scipy.special.log_ndtr(-expected / error)).sum())

    slow, fast = float(v[through].min()), float(v.max())
    starts = [
        (limit, 0.9, p, 0.05)
        for limit in (0.7 * slow, 0.95 * slow, slow, min(fast, 1.02 * slow))
        for p in ((2.0, 4.0) if free else (held,))
    ]
    if start is not None:
        starts = [(start.limit / scale, start.a, start.p, max(start.error / scale, 2 * least))]
    best: Any = None
    fine = 1.0 if start is None else 1e4
    for limit, a, p, error in starts:
        first = [limit, a, *([p] if free else []), math.log(error)]
        bounds = [(0.0, fast), (0.01, 1.0), *([(1.0, 10.0)] if free else []), (math.log(least), 0.0)]
        options = {"xatol": 1e-8 * fine, "fatol": 1e-10 * fine, "maxiter": 4000, "maxfev": 4000}
        found = scipy.optimize.minimize(cost, first, method="Nelder-Mead", bounds=bounds, options=options)
        if best is None or found.fun < best.fun:
            best = found
    limit, a, p, error = best.x[0] * scale, best.x[1], best.x[2] if free else held, math.exp(best.x[-1]) * scale
    notes = [] if free or power else ["p is 2 and not fitted: fewer than five shots went through at different velocities."]
    if free and not 1.001 < p < 9.99:
        notes.append(f"The fit of the residual velocities is bad: p is {p:.3g}, at its bound.")
    if error > BAD * limit:
        notes.append(
            f"The fit of the residual velocities is bad: its error, {error:.2g} m/s, is above {100 * BAD:g} % of its limit."
        )
    return Residual(float(limit), float(a), float(p), float(error), " ".join(notes))
