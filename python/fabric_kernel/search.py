"""Bisection: the one search for a velocity at which something begins."""

import math
from collections.abc import Callable


def bisected(
    low: float, high: float, begins: Callable[[float], bool], *, ratio: float = 0.0, width: float = 0.0
) -> tuple[float, float]:
    """Two velocities, of which the faster `begins`, at most `width` apart, or with `ratio` at most that ratio. `low` does not and
    `high` does; where results are not monotonic one of the crossings is found."""
    while high > ratio * low if ratio else high - low > width:
        middle = math.sqrt(low * high) if ratio else 0.5 * (low + high)
        low, high = (low, middle) if begins(middle) else (middle, high)
    return low, high
