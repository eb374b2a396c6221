"""Network of a scene: graded about the hit; and the shift of a ballistic limit with bars half as long.

Method: a few shots at the network with bars half as long, with the samples (yarns, places of hit) of the first shots of a test
and velocities chosen by Neyer's design about its limit. Both laws are normal in ln v with one scatter; the shift d of the mean
has the likelihood max over mean and scatter of L(coarse) L(fine, mean + d), and the interval in which twice its logarithm lies
within Student's t squared of the best.
Limits: velocities within a factor of REACH of the limit, in steps of FINEST; two networks show a shift, not that a third
would not show another.
Cost: a graded network with bars half as long takes about as long as the scene's own, a whole one at least eight times as long.
"""

import math
from collections.abc import Callable, Sequence
from typing import Annotated, Any

import numpy
import scipy  # Its parts are loaded where they are used.

from . import designs
from ._kernel import Refused, Scene
from .ensembles import vary
from .limit import Interval
from .record import record
from .shooter import Shooter
from .shots import Shot, shots_of

OF_LIMITS = 0.005
"""Error of the absorbed energy for which networks of limits are graded: these then err by at most 1 % (docs/accuracy.md)."""
SHOTS, REACH, FINEST = 8, 3.0, 0.002
"""Shots at the fine network; factor from the limit, and step of ln v, of the likelihood's grid."""
SMALL = 5.0
"""Percent from which on a note of the scene (`Scene.coarse_network`) names a network."""
SCATTERS = numpy.geomspace(0.004, 0.33, 14)
"""Standard deviations of ln v of single limits that the likelihood considers."""


@record
class Shift:
    """Change of the limit with bars half as long, percent. An end that the shots do not give is infinite."""

    percent: Annotated[float, "of the limit"]
    interval: Annotated[Interval, "percent"]
    shots: Annotated[int, "number of shots at the fine network"]

    def is_small(self) -> bool:
        return all(abs(end) <= SMALL for end in self.interval)

    def advice(self) -> str:
        """What to do where bars half as long change the limit; empty where they do not, or it is not known."""
        low, high = self.interval
        return "" if self.is_small() or low <= 0.0 <= high else "Take them: half of sheet.yarns_per_bar."

    def text(self) -> str:
        low, high = (f"{round(end):+d}" if math.isfinite(end) else "no bound" for end in self.interval)
        return f"[{low}, {high}]"


def halved(scene: Scene) -> Scene:
    """Scene with bars half as long, of the same fabric and size. Raises Refused for a network that cannot be divided."""
    fine = scene.replace({"sheet.yarns_per_bar": 0.5})
    if seconds := scene["time_step.seconds"]:
        fine = fine.replace({"time_step.seconds": 0.5 * seconds})
    fine.check()
    return fine


def graded(scene: Scene, error: float = 0.01) -> dict[str, Any]:
    """Keys and values with which `Scene.replace` grades a scene's network for an error of the absorbed energy, 0.005 to 0.1: fine
    where the body strikes, to a distance that follows from its size and the viscosity. None where the network stays whole.
    Raises Refused for an error out of range and for options that take whole networks only."""
    found = scene.graded(error)
    keys = [f"sheet.grading.{key}" for key in ("largest", "run", "centre", "half_width")]
    return {key: found[key] for key in keys} if found["sheet.grading.largest"] > 1 else {}


def graded_for(shoot: Shooter, scene: Scene, speed: float) -> Scene:
    """Scene with its network graded about the hits of a test at a speed, m/s; as it is where it must stay whole or is graded."""
    if scene["sheet.grading.largest"] > 1:
        return scene
    try:
        one = vary(scene, 1, seed=shoot.seed, speed=speed, point=shoot.mesh, attitude=shoot.attitude, tilt=shoot.tilt)[0]
        return scene.replace(graded(one, OF_LIMITS))
    except Refused:
        return scene


def likely(shots: Sequence[Shot], middle: float) -> numpy.ndarray:
    """Logarithm of the likelihood of shots, by mean of ln v (grid about the middle, m/s) and scatter."""
    steps = round(math.log(REACH) / FINEST)
    mean = math.log(middle) + FINEST * numpy.arange(-steps, steps + 1)
    v = numpy.log([shot.velocity for shot in shots])
    sign = numpy.array([-1.0 if shot.stopped else 1.0 for shot in shots])
    return scipy.special.log_ndtr(sign * (v - mean[:, None, None]) / SCATTERS[:, None]).sum(-1)


def shift_of(coarse: Sequence[Shot], fine: Sequence[Shot], limit: float, confidence: float = 0.95) -> Shift:
    """Shift of the limit, of shots at both networks; limit: of the coarse one, m/s."""
    of_coarse, of_fine = likely(coarse, limit), likely(fine, limit)
    count = len(of_coarse)
    shifts: Any = numpy.arange(-(count // 2), count // 2 + 1)
    best = numpy.array(
        [(of_coarse[max(0, -d) : count - max(0, d)] + of_fine[max(0, d) : count - max(0, -d)]).max() for d in shifts]
    )
    quantile = float(scipy.special.stdtrit(len(coarse) + len(fine) - 3, 0.5 + 0.5 * confidence))
    within = numpy.flatnonzero(2.0 * (best.max() - best) <= quantile * quantile)
    percent = 100.0 * numpy.expm1(FINEST * shifts)
    value = float(percent[numpy.flatnonzero(best > best.max() - 1e-9)].mean())
    low = float(percent[within[0]]) if within[0] else -math.inf
    high = float(percent[within[-1]]) if within[-1] < len(shifts) - 1 else math.inf
    return Shift(value, Interval(low, high), len(fine))


def shift(
    shoot: Shooter,
    shots: Sequence[Shot],
    limit: float,
    deviation: float,
    *,
    count: int = SHOTS,
    confidence: float = 0.95,
    say: Callable[[str], None] | None = None,
) -> Shift:
    """Shift of a limit by its network. shoot, shots: of the test; limit, deviation: its result, m/s. The finer network is graded
    where it can be. Shots are kept in the file of `shoot`. Raises Refused for a network that cannot be divided, Unknown where
    shots have no known end."""
    fine_scene = graded_for(shoot, halved(shoot.scene), limit)
    fine = Shooter(fine_scene, seed=shoot.seed, point=None, attitude=shoot.attitude, tilt=shoot.tilt, steps=2 * shoot.steps)
    fine.mesh, fine.keep, fine.rows, fine.until = shoot.mesh, shoot.keep, shoot.rows, shoot.until
    spread = max(deviation, 0.02 * limit)
    design = designs.Neyer(max(limit - 4.0 * spread, 0.5 * limit), limit + 4.0 * spread, spread)
    found = shift_of(shots, shots_of(fine, design, count, say or (lambda line: None))[0], limit, confidence)
    shoot.flown += fine.flown
    return found
