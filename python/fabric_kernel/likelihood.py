"""The likelihood of shots that were stopped or went through, for many tests at once.

Method: a shot at velocity v goes through with probability F((v - mu)/sigma). F is the normal distribution (probit) or the
logistic one (logit), mu is V50, and the velocity at which a share p goes through is mu + F^-1(p) sigma. A higher velocity never
helps the fabric:
sigma >= 0, where 0 is a step and infinite means that velocity does not matter. The logarithm of the likelihood is concave in
(-mu/sigma, 1/sigma), so that Newton's method with halved steps finds its maximum.
Where results do not overlap (every shot that was stopped was slower than every one that went through) the maximum is a step.
Firth's penalty, half the logarithm of the determinant of Fisher's information, makes it finite.
Limits: no prior knowledge but that single limits are positive, no velocity that is known with an error, one distribution without
two kinds of failure.
Shapes: velocities and results are (tests, shots); what is returned has one value for each test.
Reference: M. J. Silvapulle, J. R. Statist. Soc. B 43 (1981) 310, for when the maximum exists; D. Firth, Biometrika 80 (1993) 27;
G. Heinze and M. Schemper, Statistics in Medicine 21 (2002) 2409.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy
import scipy  # Its parts are loaded where they are used.

from .checks import Array


class Link(NamedTuple):
    """A distribution of single limits, symmetric about 0."""

    name: str
    deviation: float  # standard deviation of F
    quantile: Callable[..., Any]  # F^-1(p)
    share: Callable[..., Any]  # F(z)
    log_share: Callable[..., Any]  # log F(z)
    hazard: Callable[..., Any]  # F'(z)/F(z), from z and log F(z)
    curvature: Callable[..., Any]  # -(log F)''(z), from z and the hazard
    information: Callable[..., Any]  # F'(z)^2/(F(z) F(-z)): what one shot tells about z (Fisher)
    information_slope: Callable[..., Any]  # d log(information)/dz
    sample: Callable[..., Any]  # single limits, from a random generator and a shape


def normal_hazard(z: Array, log_share: Array) -> Array:
    return numpy.exp(-0.5 * z * z - log_share) / numpy.sqrt(2 * numpy.pi)


def normal_information(z: Array) -> Array:
    return numpy.exp(-z * z - scipy.special.log_ndtr(z) - scipy.special.log_ndtr(-z)) / (2 * numpy.pi)


def normal_information_slope(z: Array) -> Array:
    up, down = scipy.special.log_ndtr(z), scipy.special.log_ndtr(-z)
    return -2 * z - normal_hazard(z, up) + normal_hazard(z, down)


PROBIT = Link(
    name="probit",
    deviation=1.0,
    quantile=lambda share: scipy.special.ndtri(share),
    share=lambda z: scipy.special.ndtr(z),
    log_share=lambda z: scipy.special.log_ndtr(z),
    hazard=normal_hazard,
    curvature=lambda z, hazard: hazard * (z + hazard),
    information=normal_information,
    information_slope=normal_information_slope,
    sample=lambda random, shape: random.standard_normal(shape),
)
LOGIT = Link(
    name="logit",
    deviation=numpy.pi / numpy.sqrt(3),
    quantile=lambda share: scipy.special.logit(share),
    share=lambda z: scipy.special.expit(z),
    log_share=lambda z: scipy.special.log_expit(z),
    hazard=lambda z, log_share: scipy.special.expit(-z),
    curvature=lambda z, hazard: hazard * (1 - hazard),
    information=lambda z: scipy.special.expit(z) * scipy.special.expit(-z),
    information_slope=lambda z: -numpy.tanh(0.5 * z),
    sample=lambda random, shape: random.logistic(size=shape),
)
LARGEST = 1 / 3
"""Largest standard deviation of single limits over V50 that is thought possible in a test whose design multiplies and halves
velocities, as no limit is negative. Elsewhere any is possible: `largest` is infinite."""

LINKS = {link.name: link for link in (PROBIT, LOGIT)}


def ends(velocities: Array, through: Array) -> Any:
    """The highest velocity that was stopped (-inf if none) and the lowest that went through (inf if none)."""
    stopped = numpy.where(through, -numpy.inf, velocities).max(axis=-1)
    return stopped, numpy.where(through, velocities, numpy.inf).min(axis=-1)


def bernoulli(hits: Array, shots: int, share: Any) -> Any:
    """Log likelihood of so many hits if all shots had one probability."""
    return scipy.special.xlogy(hits, share) + scipy.special.xlogy(shots - hits, 1 - share)


class Maximum(NamedTuple):
    """Where the likelihood is highest. mu and sigma are NaN where the faster shots did not go through more often."""

    mu: numpy.ndarray
    sigma: numpy.ndarray
    level: numpy.ndarray  # logarithm of what was made largest


def rises(velocities: Array, through: Array) -> Array:
    """Whether the shots that went through were faster on average than those that were stopped: then sigma is finite."""
    count = velocities.shape[-1]
    hits = through.sum(axis=-1)
    above = numpy.where(through, velocities, 0.0).sum(axis=-1)
    below = velocities.sum(axis=-1) - above
    return (hits > 0) & (hits < count) & (above * (count - hits) > below * hits + 1e-12 * numpy.abs(velocities).sum(axis=-1))


def maximum(velocities: Array, through: Array, link: Link, near: Any = None) -> Any:
    """The maximum of the likelihood with sigma >= 0. near: mu and sigma from where to search (NaN or 0 where unknown), for the
    choice of the next shot, which needs few digits."""
    velocities, through = numpy.asarray(velocities, float), numpy.asarray(through, bool)
    count, hits = velocities.shape[-1], through.sum(axis=-1)
    stopped, passed = ends(velocities, through)
    rising = rises(velocities, through)
    mu = numpy.full(hits.shape, numpy.nan)
    sigma, level = mu.copy(), bernoulli(hits, count, hits / count)
    step = rising & (stopped <= passed)
    mu[step], sigma[step], level[step] = 0.5 * (stopped[step] + passed[step]), 0.0, 0.0
    tied = step & (stopped == passed)
    if tied.any():
        # Both results at the velocity of the step.
        here = velocities[tied] == stopped[tied, None]
        there, all_there = (here & through[tied]).sum(axis=-1), here.sum(axis=-1)
        level[tied] = bernoulli(there, all_there, there / all_there)
    rows = rising & ~step
    if rows.any():
        mu[rows], sigma[rows], level[rows] = newton(
            velocities[rows], through[rows], link, 0.0, near and (near[0][rows], near[1][rows])
        )
    return Maximum(mu, sigma, level)


def firth(velocities: Array, through: Array, link: Link, largest: float = numpy.inf) -> Any:
    """The maximum of the penalised likelihood, if there is one among the fabrics that are thought possible: finite also where
    results do not overlap."""
    velocities, through = numpy.asarray(velocities, float), numpy.asarray(through, bool)
    rows = rises(velocities, through)
    mu = numpy.full(rows.shape, numpy.nan)
    sigma, level = mu.copy(), mu.copy()
    if rows.any():
        mu[rows], sigma[rows], level[rows] = newton(velocities[rows], through[rows], link, 1.0)
    # With few shots, or some that lie far away, there may be two maxima, one with a sigma as large as all of them. The level
    # is that of the higher, and the estimate that with the smaller sigma; both of possible fabrics, if there are.
    middle, width = numpy.median(velocities, axis=-1), core(velocities)
    impossible = (
        link.deviation * sigma > largest * numpy.maximum(mu, 0.0) if largest < numpy.inf else numpy.zeros(rows.shape, bool)
    )
    far = numpy.flatnonzero(rows & (impossible | (sigma > width) | (numpy.ptp(velocities, axis=-1) > 4.0 * width)))
    if len(far):
        v = velocities[far]
        start = numpy.minimum(0.25 * width[far], 0.5 * largest / link.deviation * middle[far])
        other = newton(v, through[far], link, 1.0, (middle[far], start), largest)
        better = (other[1] > 0) & (impossible[far] | (other[1] < numpy.minimum(sigma[far], 0.99 * width[far])))
        level[far] = numpy.where(better & impossible[far], other[2], numpy.fmax(level[far], other[2]))
        mu[far[better]], sigma[far[better]] = (values[better] for values in other[:2])
    # The penalty can turn a slope that hardly rises.
    flat = ~(sigma > 0)
    mu[flat], sigma[flat], level[flat] = numpy.nan, numpy.nan, numpy.nan
    return Maximum(mu, sigma, level)


def information(z: Array, x: Array, link: Link) -> Any:
    """Fisher's information of z = a + b x, summed over the shots: its three elements, the determinant, and each shot's part."""
    part = link.information(z)
    aa, ab, bb = part.sum(axis=-1), (part * x).sum(axis=-1), (part * x * x).sum(axis=-1)
    return aa, ab, bb, aa * bb - ab * ab, part


def newton(velocities: Array, through: Array, link: Link, penalty: float, near: Any = None, largest: Any = numpy.inf) -> Any:
    """mu, sigma and log likelihood (with the penalty, if it is 1) by Newton's method in z = a + b x with halved steps, from
    `near`, the mu and sigma of each, if that is given; with the penalty then among the fabrics that are thought possible, or with
    a sigma of at most the core of the shots."""
    centre, spread = velocities.mean(axis=-1), velocities.std(axis=-1)
    all_x = (velocities - centre[:, None]) / spread[:, None]
    sign = numpy.where(through, 1.0, -1.0)
    a, b = numpy.zeros(len(all_x)), numpy.full(len(all_x), 1.0 - penalty)
    if near:
        known = near[1] > 0
        a[known] = (centre - near[0])[known] / near[1][known]
        b[known] = spread[known] / near[1][known]

    bounded = bool(near and penalty)
    if bounded:
        # Within first a + slope b <= bound: z at the velocity 0, or 1/sigma.
        first, slope, bound = 0.0, numpy.full(len(spread), -1.0), -spread / core(velocities)
        if largest < numpy.inf:
            first, slope, bound = 1.0, -centre / spread, numpy.full(len(spread), -link.deviation / largest)

    def value(x: Array, s: Array, rows: Any, a: Array, b: Array) -> Any:
        z = a[:, None] + b[:, None] * x
        log_likelihood = link.log_share(s * z).sum(axis=-1)
        if not penalty:
            return log_likelihood
        with numpy.errstate(divide="ignore", invalid="ignore"):
            level = log_likelihood + 0.5 * numpy.log(information(z, x, link)[3])
        return numpy.where(first * a + slope[rows] * b <= bound[rows], level, -numpy.inf) if bounded else level

    active = numpy.arange(len(all_x))
    level = value(all_x, sign, active, a, b)
    for _ in range(200):
        x, s = all_x[active], sign[active]
        z = a[active, None] + b[active, None] * x
        hazard = link.hazard(s * z, link.log_share(s * z))
        score = s * hazard
        if penalty:
            # Fisher's scoring with the slope of the penalty.
            aa, ab, bb, determinant, part = information(z, x, link)
            leverage = part * (bb[:, None] - 2 * ab[:, None] * x + aa[:, None] * x * x) / determinant[:, None]
            score = score + 0.5 * leverage * link.information_slope(z)
        else:
            part = link.curvature(s * z, hazard)
            aa, ab, bb = part.sum(axis=-1), (part * x).sum(axis=-1), (part * x * x).sum(axis=-1)
            determinant = aa * bb - ab * ab
        ga, gb = score.sum(axis=-1), (score * x).sum(axis=-1)
        da, db = (bb * ga - ab * gb) / determinant, (aa * gb - ab * ga) / determinant
        gain = da * ga + db * gb
        # No shot moves by more than two standard deviations in a step, and a far one by no more than its distance besides.
        step = 1.0 / numpy.maximum(1.0, (numpy.abs(da[:, None] + db[:, None] * x) / (2.0 + numpy.abs(z))).max(axis=-1))
        for _ in range(40):
            new_a, new_b = a[active] + step * da, b[active] + step * db
            new = value(x, s, active, new_a, new_b)
            worse = ~(new >= level[active] - 1e-12 * numpy.abs(level[active]))
            if not worse.any():
                break
            step[worse] *= 0.5
        a[active], b[active], level[active] = new_a, new_b, new
        # Steps that are halved to nothing end at the bound.
        active = active[(gain > (1e-6 if near and not penalty else 1e-11)) & ((step > 1e-6) | (not bounded))]
        if not len(active):
            break
    if penalty:
        # In the unit of the velocities: 1/sigma is b/spread.
        level = level + numpy.log(spread)
    with numpy.errstate(divide="ignore", invalid="ignore"):
        return centre - a / b * spread, spread / b, level


def core(velocities: Array) -> Any:
    """The range of the shots, or twice that of the half of them about the median if that is less: those of a bracket may lie far
    away."""
    middle = numpy.median(velocities, axis=-1, keepdims=True)
    width, half = numpy.ptp(velocities, axis=-1), numpy.median(numpy.abs(velocities - middle), axis=-1)
    return numpy.where(half > 0.0, numpy.minimum(4.0 * half, width), width)


GOLDEN = 0.5 * (5**0.5 - 1)


def held(velocities: Array, through: Array, link: Link, at: Any, quantile: Any, penalty: float, largest: Any = numpy.inf) -> Any:
    """The highest log likelihood (with Firth's penalty, if it is 1) when the velocity `at` has the quantile F^-1(p), and its
    sigma.

    By golden section in the logarithm of 1/sigma, in which it has one maximum. at: one for each test. largest: sigma is no
    larger.
    Without the penalty a step has sigma 0."""
    velocities, through, at = numpy.broadcast_arrays(velocities, through, numpy.asarray(at, float)[:, None])
    at, quantile = at[:, 0], numpy.broadcast_to(quantile, at.shape[:1])[:, None]
    reach = numpy.abs(velocities - at[:, None]).max(axis=-1)
    width = numpy.minimum(reach, core(velocities))
    x = (velocities - at[:, None]) / reach[:, None]
    sign = numpy.where(through, 1.0, -1.0)

    def value(log_b: Any) -> Any:
        z = quantile + numpy.exp(log_b)[:, None] * x
        result = link.log_share(sign * z).sum(axis=-1)
        if penalty:
            determinant = information(z, x, link)[3]
            result = result + 0.5 * numpy.log(numpy.maximum(determinant, 1e-300)) + numpy.log(reach)
        return result

    low = numpy.log(numpy.maximum(1e-3, reach / largest))
    high = numpy.maximum(numpy.log(30.0 * velocities.shape[-1] * reach / width), low + 1.0)
    # A few values first: far from the maximum the determinant vanishes and tells no direction.
    grid = numpy.linspace(low, high, 16)
    values = numpy.array([value(log_b) for log_b in grid])
    best = numpy.clip(values.argmax(axis=0), 1, len(grid) - 2)
    rows = numpy.arange(len(at))
    left, right = grid[best - 1, rows], grid[best + 1, rows]
    inner = right - GOLDEN * (right - left)
    outer = left + GOLDEN * (right - left)
    f_inner, f_outer = value(inner), value(outer)
    for _ in range(11):
        lower = f_inner > f_outer
        left, right = numpy.where(lower, left, inner), numpy.where(lower, outer, right)
        new = numpy.where(lower, right - GOLDEN * (right - left), left + GOLDEN * (right - left))
        f_new = value(new)
        inner, outer = numpy.where(lower, new, outer), numpy.where(lower, inner, new)
        f_inner, f_outer = numpy.where(lower, f_new, f_outer), numpy.where(lower, f_inner, f_new)
    log_b = numpy.where(f_inner > f_outer, inner, outer)
    # The parabola through what is left gives the last digits.
    step = 0.5 * (right - left)
    below, here, above = value(log_b - step), numpy.maximum(f_inner, f_outer), value(log_b + step)
    bend = below - 2 * here + above
    curved = bend < 0
    shift = numpy.where(curved, numpy.clip(0.5 * (below - above) / numpy.where(curved, bend, -1.0), -1.0, 1.0), 0.0)
    log_b = numpy.maximum(low, log_b + shift * step)
    level = value(log_b)
    log_b, level = numpy.where(values[0] > level, low, log_b), numpy.maximum(level, values[0])
    level = numpy.maximum(level, here)
    sigma = reach / numpy.exp(log_b)
    if not penalty:
        # Velocity does not matter, and every shot agrees with a step.
        level = numpy.maximum(level, link.log_share(sign * quantile).sum(axis=-1))
        step = (sign * x >= 0).all(axis=-1)
        level = numpy.where(step, numpy.where(x == 0, link.log_share(sign * quantile), 0.0).sum(axis=-1), level)
        sigma = numpy.where(step, 0.0, sigma)
    return level, sigma


def ratio(best: Any, velocities: Array, through: Array, link: Link, at: Any, quantile: Any, penalty: float) -> Any:
    """Twice the logarithm of the likelihood ratio of the best fit, of that level, to the best with `at` as the velocity of this
    quantile; and the sigma of the latter. NaN where there is no fit."""
    level, sigma = held(velocities, through, link, at, quantile, penalty)
    return numpy.maximum(0.0, 2 * (best - level)), sigma


def possible(velocities: Array, through: Array, link: Link, largest: float) -> Any:
    """The level of Firth's maximum among the fabrics whose standard deviation is at most this part of V50. NaN where there is no
    fit."""
    found = firth(velocities, through, link, largest)
    level = found.level.copy()
    if largest == numpy.inf:
        return level
    beyond = link.deviation * found.sigma > 0.9 * largest * found.mu
    if beyond.any():
        # Then it may lie where the two are in this proportion: the velocity 0 has this quantile.
        bound = held(velocities[beyond], through[beyond], link, numpy.zeros(beyond.sum()), -link.deviation / largest, 1.0)[0]
        level[beyond] = numpy.where(
            link.deviation * found.sigma[beyond] > largest * found.mu[beyond], bound, numpy.fmax(level[beyond], bound)
        )
    return level


def possible_ratio(best: Any, velocities: Array, through: Array, link: Link, at: Any, quantile: Any, largest: float) -> Any:
    """`ratio` with Firth's penalty among the same fabrics; `best` from `possible`. Infinite where no such fabric has this
    velocity."""
    if largest == numpy.inf:
        return ratio(best, velocities, through, link, at, quantile, 1.0)
    at = numpy.asarray(at, float)
    quantile = numpy.broadcast_to(quantile, at.shape)
    # mu is at - quantile sigma.
    proportion = link.deviation / largest + quantile
    positive = at > 0
    most = numpy.where(proportion > 0, numpy.where(positive, at, 1.0) / numpy.where(proportion > 0, proportion, 1.0), numpy.inf)
    level, sigma = held(velocities, through, link, at, quantile, 1.0, most)
    return numpy.where(positive, numpy.maximum(0.0, 2 * (best - level)), numpy.inf), sigma
