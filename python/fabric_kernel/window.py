"""Windows beside a ballistic limit: velocities at which shots go through although faster ones are stopped, or are stopped
although slower ones go through.

Ladder: after a test one shot in the middle of each of n equal parts from FROM times the V01 estimate up to it, with n = 3
ceil(ln(1 - c)/ln(1/2)); and as many from the V99 estimate up to TO times it.
A window in which every shot goes through is missed only if it is narrower than a part; one a third as wide as the ladder, in
which half of the shots go through, holds n/3 of them and is missed with a probability of at most 1 - c.
Window: the shots contradict a share that grows if so many of the ladder went through, or one of all shots, as a law of the shots
of the test, or of all faster ones (Firth's fit to FEWEST or more, with WIDER times its scatter, as few shots tell it badly) lets
through in less than RARE of tests; or if all of those were stopped; or if the pairs of all shots contradict it (`limit.falling`).
Stops above are perforations below of the same shots seen from the other end: results and the order of velocities are turned.
Limits: one shot a rung, so a rare perforation or stop is missed.
tests/python/test_window.py measures how often shots without a window are said to have one.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any

import numpy
import scipy  # Its parts are loaded where they are used.
from numpy.typing import ArrayLike

from . import checks, limit, runs
from ._kernel import Scene
from .likelihood import PROBIT, firth
from .record import record

FROM, TO, WIDER, RARE, FEWEST = 0.3, 1.4, 2.0, 0.005, 8
NO_LIMIT, STATUS = "no_single_limit", 4
"""Code of a note of a window, and exit status of a command that found one."""
APART, FEW = 2.0, 8
"""Gap between two groups over the wider one; each has one of so many shots."""


@record
class Window:
    """Velocities, m/s, below the limit at which shots go through. A test that has one has no single limit."""

    lowest: Annotated[float, "slowest shot that went through"]
    stopped: Annotated[float, "the fastest that is slower than it: up to here all were stopped; 0 if there is none"]
    fastest: Annotated[float, "the fastest that was stopped"]
    through: Annotated[int, "shots that went through below that"]
    faster: Annotated[int, "stopped shots that are faster than the slowest that went through"]
    near_held: Annotated[float, "share of the failed segments of both that lie within three spacings of a held node"] = math.nan

    def sentence(self) -> str:
        below = f"every slower shot, up to {self.stopped:.4g} m/s, was stopped" if self.stopped else "no slower shot was stopped"
        cause = (
            f" Yarns broke at the clamps first: {100 * self.near_held:.0f} % of the failed segments lie within three spacings "
            f"of a held node."
            if self.near_held >= runs.CLAMPS
            else ""
        )
        return (
            "No single limit: the share that goes through does not grow with the velocity. The slowest shot that went through "
            f"had {self.lowest:.4g} m/s, {below}, and {self.faster} faster shots were stopped, up to {self.fastest:.4g} "
            f"m/s.{cause}"
        )


def ladder(velocities: ArrayLike, through: ArrayLike, confidence: float) -> numpy.ndarray:
    """Velocities to shoot below a limit, m/s; none where no shot was stopped: then there is nothing that a slower one could
    contradict."""
    v, y = limit.checked(velocities, through)
    if y.all():
        return numpy.empty(0)
    fit = firth(v[None], y[None], PROBIT)
    mu, top = float(fit.mu[0]), float(v.min())
    if 0.0 < mu < math.inf:  # Of few shots far above the limit it may be below 0, and then says nothing.
        # A scatter that few shots tell as too large must not leave a gap below the limit.
        top = min(max(mu + PROBIT.quantile(0.01) * float(fit.sigma[0]), 0.5 * mu), float(v[~y].max()))
    return top * (FROM + (1.0 - FROM) * parts(confidence))


def parts(confidence: float) -> numpy.ndarray:
    """Middles of the parts of a ladder, of its length."""
    count = 3 * math.ceil(math.log(1.0 - checks.confident(confidence)) / math.log(0.5))
    return (numpy.arange(count) + 0.5) / count


def ladder_above(velocities: ArrayLike, through: ArrayLike, confidence: float) -> numpy.ndarray:
    """Velocities to shoot above a limit, m/s; none where all results are alike: then there is no limit."""
    v, y = limit.checked(velocities, through)
    if y.all() or not y.any():
        return numpy.empty(0)
    fit = firth(v[None], y[None], PROBIT)
    mu, first = float(fit.mu[0]), float(v.max())
    if 0.0 < mu < math.inf:
        first = max(min(mu + PROBIT.quantile(0.99) * float(fit.sigma[0]), 1.5 * mu), float(v[y].min()))
    return first * (1.0 + (TO - 1.0) * parts(confidence))


def looked_at(rungs: Sequence[float], passed: Sequence[bool], confidence: float) -> tuple[str, str]:
    """What a ladder found, and what it would have missed: a doubt, which is empty if every shot was stopped, and a note."""
    width = (rungs[-1] - rungs[0]) / max(len(rungs) - 1, 1)
    note = (
        f"Below it {len(rungs)} shots from {rungs[0]:.4g} to {rungs[-1]:.4g} m/s, one each {width:.3g} m/s, "
        f"{'were stopped' if not any(passed) else f'of which {sum(passed)} went through'}. A window in which every shot goes "
        f"through is missed only if it is narrower than that. One of {len(rungs) * width / 3:.3g} m/s, in which half do, is "
        f"missed with a probability of at most {100 * (1 - confidence):.3g} %."
    )
    slowest = min((velocity for velocity, through in zip(rungs, passed) if through), default=math.nan)
    doubt = (
        f"{sum(passed)} of {len(rungs)} shots below the estimate of V01 went through, the slowest with {slowest:.4g} m/s: the "
        f"limit scatters more than this fit says."
    )
    return doubt if any(passed) else "", note


def shot_beside(
    shoot: Callable[[float], bool | None],
    velocities: ArrayLike,
    through: ArrayLike,
    confidence: float,
    seed: int = 1,
    above: bool = True,
) -> tuple[Window | None, str, str]:
    """Shoots the ladders below and, if asked, above some shots: the window, a doubt and a note. shoot: with a velocity, m/s,
    returns whether it went through, None if that is not known. With a window below nothing is shot above."""
    went = lambda steps: [(float(v), passed) for v in steps if (passed := shoot(float(v))) is not None]
    split: Callable[[Any], tuple[list[float], list[bool]]] = lambda made: ([v for v, _ in made], [passed for _, passed in made])
    below = went(ladder(velocities, through, confidence))
    found = window(velocities, through, *split(below), seed)
    doubt, note = looked_at(*split(below), confidence) if below else ("", "No shot was made below.")
    if above and not found and (made := went(ladder_above(velocities, through, confidence))):
        found = window(velocities, through, *split(below + made), seed)
        stopped = [velocity for velocity, passed in made if not passed]
        said = f"of which {len(stopped)} were stopped, the fastest with {max(stopped):.4g} m/s" if stopped else "went through"
        note += f" Above it {len(made)} shots up to {made[-1][0]:.4g} m/s {said}."
        if stopped:
            doubt += (
                f"{' ' if doubt else ''}{len(stopped)} of {len(made)} shots above the estimate of V99 were stopped, the fastest "
                f"with {max(stopped):.4g} m/s: the limit scatters more than this fit says."
            )
    return found, "" if found else doubt, note


def slower(velocities: ArrayLike, residuals: ArrayLike) -> numpy.ndarray:
    """Shots that went through and lost much more energy than the others, of two groups; none where there is one group.

    The gap between the groups is at least APART times as wide as either, and each has a shot in FEW or more."""
    v, left = numpy.asarray(velocities, float), numpy.asarray(residuals, float)
    taken = v * v - left * left
    ordered, least = numpy.sort(taken), max(3, math.ceil(len(v) / FEW))
    for k in range(least, len(v) - least + 1):
        if ordered[k] - ordered[k - 1] > APART * max(numpy.ptp(ordered[:k]), numpy.ptp(ordered[k:])):
            return taken >= ordered[k]
    return numpy.zeros(len(v), bool)


def groups(velocities: ArrayLike, residuals: ArrayLike) -> str:
    """Sentence where residual velocities fall into two groups (`slower`), as where some shots are caught by many yarns and others
    cut through; empty otherwise."""
    left, slow = numpy.asarray(residuals, float), slower(velocities, residuals)
    if not slow.any():
        return ""
    ends = lambda part: f"{left[part].min():.4g} to {left[part].max():.4g} m/s"
    return (
        f"Residual velocities fall into two groups: {(~slow).sum()} shots left with {ends(~slow)} and {slow.sum()} with "
        f"{ends(slow)}, so that two ways of perforation are mixed."
    )


def near_held(shots: Sequence[tuple[Scene, Mapping[str, Any]]], found: Window) -> float:
    """Share of the failed segments that lie within three spacings of a held node, of what went through below a stopped shot or
    was stopped above one that went through; shots: scenes and rows of `fly`."""
    rows = [
        row
        for scene, row in shots
        if row.get("failed_near_held") is not None
        and (
            math.hypot(*scene["projectile.velocity"]) >= found.lowest
            if row["stopped"]
            else math.hypot(*scene["projectile.velocity"]) <= found.fastest
        )
    ]
    failed = sum(row["failed_segments"] for row in rows)
    return sum(row["failed_near_held"] for row in rows) / failed if failed else math.nan


def window(
    velocities: ArrayLike, through: ArrayLike, rungs: ArrayLike = (), passed: ArrayLike = (), seed: int = 1
) -> Window | None:
    """The window of the shots of a test, m/s, and of the ladder below it; None if they do not contradict a share that grows with
    the velocity."""
    own, results = limit.checked(velocities, through)
    v, y = limit.checked([*own, *numpy.ravel(rungs)], [*results, *numpy.ravel(passed)])
    if not (y.any() and v[y].min() < v[~y].max(initial=0.0)):
        return None

    def contradicted(own: numpy.ndarray, results: numpy.ndarray, v: numpy.ndarray, y: numpy.ndarray) -> bool:
        slow = any(too_many(v[v > one], y[v > one], numpy.full(len(v), one), 1) for one in numpy.unique(v[y]))
        ladder = (v < numpy.median(own)) & (numpy.arange(len(v)) >= len(own))
        return slow or too_many(own, results, v[ladder], int(y[ladder].sum()))

    if not (contradicted(own, results, v, y) or contradicted(-own, ~results, -v, ~y) or limit.falling(v, y, seed)):
        return None
    lowest, fastest = float(v[y].min()), float(v[~y].max())
    return Window(
        lowest,
        float(v[~y & (v < lowest)].max(initial=0.0)),
        fastest,
        int((y & (v < fastest)).sum()),
        int((~y & (v > lowest)).sum()),
    )


def too_many(v: numpy.ndarray, y: numpy.ndarray, slower: numpy.ndarray, through: int) -> bool:
    """Whether so many of the slower shots are too many for a law of these: so many or more, where so few are expected
    (Poisson)."""
    if not through or len(v) < FEWEST:
        return False
    if not y.any():
        return True
    fit = firth(v[None], y[None], PROBIT)
    return bool(scipy.special.gammainc(through, PROBIT.share((slower - fit.mu[0]) / (WIDER * fit.sigma[0])).sum()) < RARE)
