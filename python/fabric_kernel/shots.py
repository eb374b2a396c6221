"""Shots one after the other, as a design chooses their velocities."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy
import scipy  # Its parts are loaded where they are used.

from . import checks, designs
from .shooter import Unknown

Shoot = Callable[[float, int], tuple[bool, float]]
"""Shoots with a velocity (m/s) and the number of the shot, from 0: whether the fabric stopped it, and the residual velocity
(m/s). The number alone decides what is drawn for the shot."""
UNKNOWN = 3
"""So many unknown shots in turn end a test."""


class Shot(NamedTuple):
    """Velocity, m/s, whether the fabric stopped it, and residual velocity, m/s, 0 if stopped."""

    velocity: float
    stopped: bool
    residual: float

    def words(self) -> str:
        return "stopped" if self.stopped else f"through with {self.residual:.2f} m/s"


def share_within(through: int, unknown: int, shots: int, confidence: float) -> tuple[float, float]:
    """The exact (Clopper-Pearson) interval of the share of so many shots that goes through; those of unknown end count as stopped
    for its lower end and as through for the upper one. 0 to 1 without shots."""
    exact = lambda count: scipy.stats.binomtest(count, shots).proportion_ci(confidence, method="exact")
    return (float(exact(through).low), float(exact(through + unknown).high)) if shots else (0.0, 1.0)


def shot_of(shoot: Shoot, velocity: float, number: int) -> Shot:
    """A shot with what `shoot` found. Raises ValueError for a result that is neither stopped nor through, or without a residual
    velocity."""
    stopped, residual = shoot(velocity, number)
    if checks.results("shoot", [stopped], 1)[0]:
        return Shot(velocity, True, 0.0)
    return Shot(velocity, False, float(checks.numbers("shoot: residual", [residual], zero=True)[0]))


def shots_of(
    shoot: Shoot, design: Any, shots: int, say: Callable[[str], None], enough: Callable[[list[Shot]], bool] = lambda made: False
) -> tuple[list[Shot], list[str]]:
    """The shots of a test, at most so many, until there are `enough`; which were left out, and why there are fewer than were
    asked for."""
    made: list[Shot] = []
    left_out: list[str] = []
    in_turn = 0
    design.start(1)
    while len(made) < shots and not enough(made):
        velocities = numpy.array([[shot.velocity for shot in made]], float).reshape(1, -1)
        through = numpy.array([[not shot.stopped for shot in made]], bool).reshape(1, -1)
        alike = made and through.all() == through.any() and not isinstance(design, designs.Plan)
        if alike and len(made) == designs.ALIKE:
            ended = (
                f"{len(made)} shots with one result, from {velocities.min():.4g} to {velocities.max():.4g} m/s, ended the test "
                f"without a V50."
            )
            return made, [*left_out, ended]
        # An unknown shot is shot again with the next draw.
        if not in_turn:
            velocity = float(design.next(velocities, through)[0])
        if not velocity > 0.0:
            ended = (
                f"The design asked for {velocity:.4g} m/s as shot {len(made) + 1}, which cannot be shot: the test ended "
                f"before it."
            )
            return made, [*left_out, ended]
        try:
            made.append(shot_of(shoot, velocity, len(made) + len(left_out)))
        except Unknown as unknown:
            left_out.append(f"Left out: {unknown}.")
            say(left_out[-1])
            in_turn += 1
            if in_turn < UNKNOWN:
                continue
            if not alike:
                raise
            return made, [*left_out, "The test ended without a V50, as all known results are alike."]
        in_turn = 0
        before = ", kept from before" if getattr(shoot, "was_kept", False) else ""
        say(f"shot {len(made)} of {shots}: {velocity:.2f} m/s, {made[-1].words()}{before}")
    return made, left_out
