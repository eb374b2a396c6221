"""How the velocity of the next shot is chosen, for many tests at once.

A design has a centre and a scale (m/s), which say where and how finely its shots lie, `start(tests)`, and `next(velocities,
through)`, which gives the next velocity of each test from its shots so far, (tests, shots).

Both begin with a guess or, without one, with a bracket: the velocity is doubled while every shot is stopped and halved while
every one goes through; then both results give the guess. No velocity is below half of the slowest before it.
Neyer: halve the range until the highest stopped shot and the lowest that went through are nearer than the guess of sigma, then
shoot where Fisher's information grows most. As long as results do not overlap, mu is taken in the middle of the gap and sigma as
the guess, which shrinks by 0.8 at each shot.
ThreePhase: (1) find both results, then an overlap, and strengthen it; (2) shoot where Fisher's information grows most; (3) if
asked, approach the velocity of one share by the Robbins-Monro-Joseph procedure.
Plan: the velocities are given.
Limits: the first phase of ThreePhase widens its range by 1.5 guesses of sigma times 1, 3, 6, ...; the paper gives the first steps
only.
Reference: B. T. Neyer, Technometrics 36 (1994) 61; C. F. J. Wu and Y. Tian, J. Statist. Planning and Inference 149 (2014) 1;
V. R. Joseph, Biometrika 91 (2004) 461.
"""

import math
from typing import Any

import numpy
import scipy  # Its parts are loaded where they are used.

from . import checks
from .checks import Array
from .likelihood import LARGEST, LINKS, Link, ends, information, maximum

# Where the next shot may lie, in units of sigma from mu.
GRID = numpy.linspace(-3.0, 3.0, 241)
ALIKE = 12
"""So many shots with one result, and nothing else, end a test."""
FACTOR = 2.0
"""Factor of the velocity from one shot of a bracket to the next."""
DEVIATION = 0.05
"""Guess of the standard deviation of single limits over V50, where none is given."""


def most_informative(velocities: Array, mu: Array, sigma: Any, link: Link) -> Array:
    """The velocity that makes the determinant of Fisher's information largest, to sigma/40."""
    z = (velocities - mu[:, None]) / sigma[:, None]
    aa, ab, bb = information(z, z, link)[:3]
    # The determinant grows by the new shot's part times this square form.
    growth = link.information(GRID) * (bb[:, None] - 2 * GRID * ab[:, None] + GRID**2 * aa[:, None])
    return mu + GRID[growth.argmax(axis=-1)] * sigma


class Refined:
    """Estimate at the maximum of the likelihood, which is kept within the range of the shots."""

    def __init__(self, tests: int, link: Any) -> None:
        self.link, self.mu, self.sigma = link, numpy.full(tests, numpy.nan), numpy.zeros(tests)

    def next(self, velocities: Array, through: Array, rows: Any) -> Array:
        velocities, through = velocities[rows], through[rows]
        slowest, fastest = velocities.min(axis=-1), velocities.max(axis=-1)
        mu, sigma, _ = maximum(velocities, through, self.link, (self.mu[rows], self.sigma[rows]))
        known = numpy.isfinite(mu)
        self.mu[rows], self.sigma[rows] = mu, numpy.where(known, sigma, 0.0)
        mu = numpy.clip(numpy.where(known, mu, 0.5 * (slowest + fastest)), slowest, fastest)
        return most_informative(
            velocities, mu, numpy.where(known, numpy.minimum(sigma, fastest - slowest), fastest - slowest), self.link
        )


class Guess:
    """V50 lies probably between low and high, and the standard deviation of single limits is about sigma, m/s."""

    name: str
    known: bool
    first: float | None = None
    """First velocity of a bracket, m/s; None with a guess."""
    largest = math.inf
    """Largest standard deviation of single limits over V50; limited with a bracket, whose factors suppose that no limit is
    negative."""

    def __init__(self, low: float, high: float, sigma: float, link: str = "probit") -> None:
        if not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise ValueError("low, high: low must be below high")
        if not (sigma > 0 and math.isfinite(sigma)):
            raise ValueError("sigma: must be positive")
        self.low, self.high, self.sigma, self.link = float(low), float(high), float(sigma), LINKS[link]
        self.centre, self.scale = 0.5 * (self.low + self.high), self.sigma

    @classmethod
    def bracketed(cls, first: Any, sigma: Any = None, link: str = "probit", **options: Any) -> Any:
        """The design without a guess of V50: it brackets from this velocity, m/s. sigma: None: DEVIATION of the middle of the
        bracket."""
        if not (first > 0 and math.isfinite(first)):
            raise ValueError(f"first: must be positive; it is {first:g}")
        design = cls(
            0.5 * first, 1.5 * first, DEVIATION * first / LINKS[link].deviation if sigma is None else sigma, link, **options
        )
        design.first, design.known, design.largest = float(first), sigma is not None, LARGEST
        return design

    def words(self) -> str:
        if self.first is None:
            return f"{self.name}, V50 guessed between {self.low:g} and {self.high:g} m/s, standard deviation {self.sigma:g} m/s"
        guess = f"{self.sigma:g} m/s" if self.known else f"{100 * DEVIATION:g} % of the middle of the bracket"
        steps = f"steps by a factor of {FACTOR:g} from {self.first:g} m/s until both results had come"
        return f"{steps}, then {self.name}, standard deviation guessed as {guess}"

    @property
    def opening(self) -> Any:
        """The first velocity."""
        raise NotImplementedError

    def choose(self, velocities: Array, through: Array) -> Array:
        """The next velocity of each test."""
        raise NotImplementedError

    def start(self, tests: int) -> None:
        self.guess = numpy.full(tests, self.sigma)
        self.open = numpy.full(tests, self.first is not None and not self.known)
        self.refined = Refined(tests, self.link)

    def next(self, velocities: Array, through: Array) -> Array:
        if not velocities.shape[1]:
            return numpy.full(len(velocities), self.opening)
        return numpy.maximum(self.choose(velocities, through), 0.5 * velocities.min(axis=-1))

    def widened(self, velocities: Array, through: Array, up: Any, down: Any) -> Any:
        """The next velocity of each test, NaN where both results have come. up, down: as far as the design goes with its
        guess."""
        hits, shots = through.sum(axis=-1), velocities.shape[1]
        if self.first is not None:
            up, down = FACTOR * velocities.max(axis=-1), velocities.min(axis=-1) / FACTOR
            stopped, passed = ends(velocities, through)
            closed = self.open & (hits > 0) & (hits < shots)
            self.guess[closed] = DEVIATION * 0.5 * (stopped + passed)[closed] / self.link.deviation
            self.open &= ~closed
        return numpy.where(hits == 0, up, numpy.where(hits == shots, down, numpy.nan))

    def middle(self, velocities: Array, through: Array) -> Any:
        """About where the fabric's mu lies, and a unit for its sigma, m/s, for the calibration of one test."""
        if self.first is None or through.all() or not through.any():
            return self.centre, self.scale
        middle = 0.5 * float(sum(ends(velocities, through)))
        return middle, self.sigma if self.known else DEVIATION * middle / self.link.deviation


class Neyer(Guess):
    """Neyer's D-optimal design of a test; `Neyer.bracketed(first)` is the one without a guess of V50.

    Parameters
    ----------
    low, high : float
        Velocities, m/s, between which V50 probably lies.
    sigma : float
        Guess of the standard deviation of single limits, m/s.
    link : str
        Law of single limits, "probit" or "logit".
    """

    name = "Neyer's D-optimal design"

    @property
    def opening(self) -> Any:
        return self.centre

    def choose(self, velocities: Array, through: Array) -> Array:
        slowest, fastest = velocities.min(axis=-1), velocities.max(axis=-1)
        sigma = self.guess
        up = numpy.maximum(numpy.maximum(0.5 * (self.high + fastest), fastest + 2 * sigma), 2 * fastest - slowest)
        down = numpy.minimum(numpy.minimum(0.5 * (self.low + slowest), slowest - 2 * sigma), 2 * slowest - fastest)
        new = self.widened(velocities, through, up, down)
        both = numpy.isnan(new)
        stopped, passed = ends(velocities, through)
        gap = numpy.where(both, passed - stopped, 0.0)
        wide = both & (gap > sigma)
        new[wide] = 0.5 * (stopped[wide] + passed[wide])
        near = both & (gap >= 0) & ~wide
        if near.any():
            spread = numpy.minimum(sigma, fastest - slowest)[near]
            new[near] = most_informative(velocities[near], 0.5 * (stopped[near] + passed[near]), spread, self.link)
            self.guess[near] *= 0.8
        overlap = both & (gap < 0)
        if overlap.any():
            new[overlap] = self.refined.next(velocities, through, overlap)
        return new


class ThreePhase(Guess):
    """aim: the share whose velocity the last shots approach; last: how many of `shots` they are."""

    name = "three-phase design"

    def __init__(
        self, low: float, high: float, sigma: Any, link: Any = "probit", aim: Any = None, last: int = 0, shots: int = 0
    ) -> None:
        super().__init__(low, high, sigma, link)
        if aim is not None and not (0 < aim < 1 and 0 < last < shots):
            raise ValueError("aim, last: a share between 0 and 1, and fewer last shots than shots")
        self.aim, self.first_of_last = aim, shots - last if aim is not None else math.inf
        # The procedure works with the normal quantile.
        self.quantile: Any = None if aim is None else float(scipy.special.ndtri(aim))

    def words(self) -> str:
        aim = "" if self.aim is None else f", its last shots aim at the velocity of {100 * self.aim:g} % through"
        return super().words() + aim

    def start(self, tests: int) -> None:
        super().start(tests)
        # Shots that are already decided.
        self.waiting = numpy.full((tests, 2), numpy.nan)
        # Shots beside the gap with this guess, and the side of the first of them.
        self.beside, self.side = numpy.zeros(tests, int), numpy.ones(tests)
        self.strengthened = numpy.zeros(tests, bool)
        self.variance: Any = None
        self.unit: Any = None

    @property
    def opening(self) -> Any:
        return self.centre if self.first is not None else 0.75 * self.low + 0.25 * self.high

    def choose(self, velocities: Array, through: Array) -> Array:
        tests, shots = velocities.shape
        low, high = self.low, self.high
        if shots == 1 and self.first is None:
            return numpy.full(tests, 0.25 * low + 0.75 * high)
        if shots >= max(2, self.first_of_last):
            return self.approach(velocities, through)
        hits, guess = through.sum(axis=-1), self.guess
        # Both results.
        further = 0.75 * self.sigma * (shots - 1) * shots
        new = self.widened(velocities, through, high + further, low - further)
        if shots == 2 and self.first is None:
            self.waiting[through[:, 0] & ~through[:, 1]] = [low - 3 * self.sigma, high + 3 * self.sigma]
        decided = numpy.isnan(new) & ~numpy.isnan(self.waiting[:, 0])
        new[decided] = self.waiting[decided, 0]
        self.waiting[decided, 0], self.waiting[decided, 1] = self.waiting[decided, 1], numpy.nan
        # An overlap.
        stopped, passed = ends(velocities, through)
        both = (hits > 0) & (hits < shots)
        gap = numpy.where(both, passed - stopped, 0.0)
        middle = numpy.where(both, 0.5 * (stopped + passed), 0.0)
        free = numpy.isnan(new) & (gap >= 0)
        again = free & (self.beside == 2)
        guess[again] *= 2 / 3
        self.beside[again] = 0
        wide = free & (gap >= 1.5 * guess) & (self.beside == 0)
        new[wide] = middle[wide]
        near = free & ~wide
        first = near & (self.beside == 0)
        self.side[first] = numpy.where(2 * hits[first] < shots, 1.0, -1.0)
        side = numpy.where(self.beside == 1, -self.side, self.side)
        new[near] = numpy.where(side > 0, passed + 0.3 * guess, stopped - 0.3 * guess)[near]
        self.beside[near] += 1
        # Strengthen it.
        free = numpy.isnan(new) & ~self.strengthened
        self.strengthened |= free
        one = free & (-gap >= guess)
        new[one] = middle[one]
        two = free & ~one
        new[two], self.waiting[two, 0] = (middle + 0.5 * guess)[two], (middle - 0.5 * guess)[two]
        free = numpy.isnan(new)
        if free.any():
            new[free] = self.refined.next(velocities, through, free)
        return new

    def approach(self, velocities: Array, through: Array) -> Any:
        """Robbins, Monro and Joseph, in units of the standard deviation that is known when it begins."""
        if self.variance is None:
            slowest, fastest = velocities.min(axis=-1), velocities.max(axis=-1)
            mu, sigma, _ = maximum(velocities, through, self.link)
            deviation = self.link.quantile(scipy.special.ndtr(1.0))
            known = sigma > 0
            self.unit = numpy.minimum(numpy.where(known, sigma * deviation, self.guess), fastest - slowest)
            mu = numpy.clip(numpy.where(numpy.isfinite(mu), mu, self.centre), slowest, fastest)
            z = (velocities - mu[:, None]) / self.unit[:, None]
            aa, _, bb, determinant, _ = information(z, z, LINKS["probit"])
            variance = (bb + self.quantile**2 * aa) / determinant
            # Wu and Tian keep the first uncertainty between 3 and 5 standard deviations in 95 %.
            self.variance = numpy.clip(variance, (3 / 1.96) ** 2, (5 / 1.96) ** 2)
            return mu + self.quantile * self.unit
        slope = 0.5
        root = numpy.sqrt(1 + slope**2 * self.variance)
        expected = scipy.special.ndtr(self.quantile / root)
        density = numpy.exp(-0.5 * (self.quantile / root) ** 2) / math.sqrt(2 * math.pi)
        gain = slope * self.variance * density / (root * expected * (1 - expected))
        self.variance = self.variance - gain**2 * expected * (1 - expected)
        return velocities[:, -1] - gain * (through[:, -1] - expected) * self.unit


class Plan:
    """Velocities that are given, m/s."""

    name, largest = "given plan", math.inf

    def __init__(self, velocities: Any) -> None:
        self.velocities = checks.numbers("velocities", velocities)
        self.centre = float(self.velocities.mean())
        self.scale = float(numpy.ptp(self.velocities)) / 6 or 0.01 * self.centre

    def words(self) -> str:
        return f"{self.name} of {len(self.velocities)} velocities"

    def start(self, tests: int) -> None:
        pass

    def next(self, velocities: Array, through: Array) -> Array:
        return numpy.full(len(velocities), self.velocities[velocities.shape[1]])

    def middle(self, velocities: Array, through: Array) -> Any:
        return self.centre, self.scale


def simulate(design: Any, shots: int, limits: Any) -> Any:
    """Tests against fabrics whose single limits are given, (tests, shots): velocities and whether they went through."""
    design.start(len(limits))
    velocities, through = numpy.empty(limits.shape), numpy.empty(limits.shape, bool)
    for shot in range(shots):
        velocities[:, shot] = design.next(velocities[:, :shot], through[:, :shot])
        through[:, shot] = velocities[:, shot] > limits[:, shot]
    return velocities, through
