"""Comparisons of the model with closed forms and measurements, each a range that is allowed, with the rule of statistics.py."""

import math
from typing import NamedTuple

from . import page
from .statistics import Estimate, verdict_of_all

RULE = (
    "A row's quantity is computed with its 95 % interval and compared with the range that is allowed. "
    'It "agrees" if the whole interval of every point lies inside. It "does not" if all of one point\'s lies outside. '
    'Otherwise it is "undecided". What is deterministic has no interval. '
    "The column of points names the worst one, the farthest from the middle of its range in widths of the range.\n\n"
)
HEADING = ["comparison", "with", "allowed", "points; the worst", "verdict", "what the model lacks"]


class Point(NamedTuple):
    """One comparison: name, value of the model, allowed range."""

    name: str
    ours: Estimate
    allowed: tuple

    @property
    def verdict(self):
        return self.ours.verdict(self.allowed)

    @property
    def off(self):
        low, high = self.allowed
        return abs(self.ours.value - 0.5 * (low + high)) / (high - low)


class Comparison(NamedTuple):
    """A row of the first table. digits: of the numbers."""

    what: str
    kind: str
    allowed: str
    points: list
    digits: int
    lacks: str = ""

    @property
    def verdict(self):
        return verdict_of_all([point.verdict for point in self.points])

    def row(self):
        worst = max(self.points, key=lambda point: point.off if math.isfinite(point.off) else math.inf)
        return [
            self.what,
            self.kind,
            self.allowed,
            f"{len(self.points)}; {worst.name}: {worst.ours.text(self.digits)}",
            self.verdict,
            self.lacks,
        ]


def exact(value):
    return Estimate.exact(value)


def about(middle, part):
    """The range of a value and so many parts of it to both sides."""
    return middle * (1 - part), middle * (1 + part)


def mean_of(row, name, resolution=0.0):
    """A mean from its column, that of its deviation and the number of hits; resolution: of each value, in parts of it."""
    value, count = row[name], row["hits"]
    error = math.hypot(row[f"{name}: deviation"] / math.sqrt(count), resolution * value / math.sqrt(12))
    return Estimate.of_error(value, error, count - 1) if count > 1 else Estimate(value, -math.inf, math.inf)


def verdicts(comparisons):
    """The first table, and the same for the terminal."""
    rows = [comparison.row() for comparison in comparisons if comparison.points]
    return page.markdown(HEADING, rows, 6), page.printed(HEADING[:5], [row[:5] for row in rows])


def alone(study, part):
    """Answers one question of the validation: its verdicts, and its table."""
    comparisons, text, sound = part.compared(study)
    print(verdicts(comparisons)[1], text, sep="\n")
    return sound
