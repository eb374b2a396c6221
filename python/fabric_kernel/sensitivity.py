"""How the ballistic limit of a scene changes with what was chosen or is not known: `fabric-v50 SCENE --sensitivity`.

Method: a few shots each have their own yarns and impact point, and their own limit. For each variant of the scene the limit of the same
shots is found: strides from the limit of the scene itself, each twice as long as the one before, until it lies between two velocities, then
bisection to WIDTH. The change is the mean of the logarithms of variant over scene, with Student's interval over the shots, in which the
width of the bisection counts as an error that is evenly distributed.
Cost: in node-steps that of the limits of the scene itself times the nodes and the time step of each variant; the command takes two shots
where three would cost more than ten times the test.
Limits: one change at a time; three shots give wide intervals; where the model is chaotic, bisection finds one of several crossings.
"""

import functools
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy
import scipy.special
import scipy.stats

from . import ensembles
from ._kernel import Scene
from .runs import flown
from .textile import spacings
from .v50 import Shooter

if TYPE_CHECKING:
    import matplotlib.figure

WIDTH, STRIDE = 1.03, 1.08
"""Ratio of velocities at which bisection ends, and that of the first stride."""
SHOTS, CONFIDENCE = 3, 0.95
MOST_STRIDES = 6


def variants(scene: Scene) -> dict[str, tuple[str, Scene]]:
    """What is changed, how, and the scene of it; what does not apply to a scene is left out."""
    value, found = scene.values(), {}

    def add(what, how, changes):
        found[f"{what}: {how}"] = what, scene.replace(changes)

    nodes = {name: value[f"sheet.{name}"] for name in ("nodes_x", "nodes_y")}
    scaled = lambda part: {f"sheet.{name}": round((count - 1) * part) + 1 for name, count in nodes.items()}
    if not value["sheet.grading.largest"]:
        for part in (math.sqrt(0.5), math.sqrt(2.0)):
            changes = scaled(part)
            add("width of the sheet", " x ".join(f"{1e3 * (count - 1) * h:.4g}" for count, h in zip(changes.values(), spacings(scene))) + " mm", changes)
        parts = ("sheet", "back") if value["back.plies"] else ("sheet",)
        grown = [f"{part}.{name}" for part in parts for name in ("spacing", "spacing_y", "yarn_area", "yarn_area_y") if value.get(f"{part}.{name}")]
        coarse = scaled(0.5) | {name: 2.0 * value[name] for name in grown} | {f"{part}.node_mass": 4.0 * value[f"{part}.node_mass"] for part in parts}
        add("spacing of the network", "twice, with bars of two yarns", coarse)
    if value["time_step.seconds"]:
        add("time step", "half", {"time_step.seconds": 0.5 * value["time_step.seconds"]})
    else:
        add("time step", f"{0.5 * value['time_step.fraction']:g} of the critical", {"time_step.fraction": 0.5 * value["time_step.fraction"]})
    viscosity = {f"yarn.viscosity_{kind}": value[f"yarn.viscosity_{kind}"] for kind in ("linear", "quadratic", "bending")}
    if any(viscosity.values()):
        add("viscosity of the yarn", "half", {name: 0.5 * number for name, number in viscosity.items()})
    else:
        add("viscosity of the yarn", "that of real fabrics", dict(zip(viscosity, (0.06, 1.5, 0.06))))
    add("crimp", "1 % more", {"sheet.crimp": [part + 0.01 for part in value["sheet.crimp"]]})
    add("failure strain", "10 % more", {
        name: 1.0 + 1.1 * (value[name] - 1.0)
        for name in ("yarn.critical_stretch", "weft.critical_stretch", *(["back.critical_stretch"] if value["back.plies"] else []))
        if value[name]
    })  # fmt: skip
    add("friction on the projectile", f"{value['contact.friction'] + 0.2:g}", {"contact.friction": value["contact.friction"] + 0.2})
    other = "two_sides" if value["attachment.kind"] == "four_sides" else "four_sides"
    add("support", other.replace("_", " "), {"attachment.kind": other})
    if value["projectile.shape"] != "sphere":
        (w, x, y, z), half = value["projectile.orientation"], math.sqrt(0.5)
        turned = tuple(half * part for part in (w - x, x + w, y - z, z + y))
        found["attitude: turned by 90 degrees about x"] = "attitude", scene.aimed((0.0, 0.0), orientation=turned)
    return found


def nodes(scene: Scene) -> int:
    """Of a scene, whose cost is nodes times steps."""
    return scene["sheet.nodes_x"] * scene["sheet.nodes_y"] * scene["stack.plies"]


def crossing(guess: float, through: Callable[[float], bool]) -> float:
    """A velocity at which `through` begins, to WIDTH; NaN if none lies within MOST_STRIDES strides of the guess."""
    first, stride, velocity = through(guess), STRIDE, guess
    for _ in range(MOST_STRIDES):
        before, velocity = velocity, velocity / stride if first else velocity * stride
        if through(velocity) != first:
            low, high = sorted((before, velocity))
            while high > WIDTH * low:
                middle = math.sqrt(low * high)
                low, high = (low, middle) if through(middle) else (middle, high)
            return math.sqrt(low * high)
        stride *= stride
    return math.nan


def limit_of(job: list) -> tuple[float | None, int]:
    """The limit of one shot of a scene, m/s, and the node-steps of its search; None if it has no limit, or a shot's end is not known. job:
    scene, number of the shot, seed, guess, attitude, steps, point."""
    scene, shot, seed, guess, attitude, steps, point = job
    shooter, cost = Shooter(scene, seed=seed, attitude=attitude, steps=steps, point=point), 0

    def through(velocity):
        nonlocal cost
        one = ensembles.vary(scene, shot + 1, seed=seed, speed=velocity, point=shooter.mesh, attitude=attitude)[shot]
        row = flown(one, shooter.UNTIL, shooter.steps)
        cost += row["steps"] * nodes(scene)
        if row["stopped"] is None:
            raise ArithmeticError
        return not row["stopped"]

    try:
        found = crossing(guess, through)
    except (ArithmeticError, ValueError):  # Among them a velocity that is refused as too fast for the time step.
        return None, cost
    return found if math.isfinite(found) else None, cost


class Change(NamedTuple):
    what: str
    variant: str
    percent: float  # of the limit; NaN if not found
    low: float  # interval, percent
    high: float
    shots: int  # whose limit was found with and without the change


class Sensitivity(NamedTuple):
    limit: float  # of the shots of the scene itself, m/s
    changes: tuple[Change, ...]  # the largest first
    notes: tuple[str, ...]
    cost: int = 0  # node-steps

    def heading(self):
        return ("change", f"limit, %, from {self.limit:.1f} m/s", f"{100 * CONFIDENCE:g} % interval, %", "shots")

    def rows(self):
        digits = lambda x: f"{x:+.1f}" if math.isfinite(x) else "none"
        interval = lambda one: f"[{one.low:+.1f}, {one.high:+.1f}]" if math.isfinite(one.low) else "no bound"
        return [(one.variant, digits(one.percent), interval(one), str(one.shots)) for one in self.changes]

    def sentence(self):
        """What the width does, for the head of a report."""
        wide = [one for one in self.changes if one.what == "width of the sheet" and math.isfinite(one.percent)]
        told = " and ".join(f"{one.percent:+.0f} % [{one.low:+.0f}, {one.high:+.0f}] with {one.variant.split(': ')[1]}" for one in wide)
        return f"The width of the sheet changes the limit by {told}." if wide else ""

    def draw(self, path=None) -> "matplotlib.figure.Figure":
        from . import plot

        return plot.tornado(self, path)


def sensitivity(
    scene: Scene, guess: float, *, shots: int = SHOTS, seed: int = 1, attitude: str | None = None, steps: int | None = None,
    most: float | None = None, keep: Path | None = None, on: object = None, progress: bool | None = None,
) -> Sensitivity:  # fmt: skip
    """How the limit changes with each of `variants`. guess: the limit of the scene, m/s; steps: most of a shot, after which its end counts
    as not known; most: node-steps, for which two shots are taken if more would cost so much; keep, on, progress: as for `ensemble`.

    Raises Refused if the scene cannot be simulated; a variant that cannot is left out, which the notes say."""
    changed, notes = variants(scene), []
    if attitude:
        changed.pop("attitude: turned by 90 degrees about x", None)
    for name in list(changed):
        try:
            changed[name][1].check()
        except ValueError as refused:
            notes.append(f"{name}: left out: {refused}.")
            del changed[name]
    done = functools.partial(limits, keep=keep, on=on, progress=progress, name="sensitivity")
    finer = lambda of: max(scene["time_step.fraction"] / of["time_step.fraction"], scene["time_step.seconds"] / (of["time_step.seconds"] or 1.0))
    job = lambda of, shot, near: [of, shot, seed, near, attitude, steps and round(steps * finer(of)), (0.0, 0.0)]
    own, costs = zip(*done([job(scene, shot, float(guess)) for shot in range(shots)]))
    # The limits of variants lie farther from the guess.
    weights = [1.5 * nodes(other) / nodes(scene) * finer(other) for _, other in changed.values()]
    while most is not None and shots > 2 and sum(costs[:shots]) * (1.0 + sum(weights)) > most:
        shots -= 1
    pairs = [(name, shot) for name in changed for shot in range(shots) if own[shot]]
    results = done([job(changed[name][1], shot, own[shot]) for name, shot in pairs])
    found = {pair: limit for pair, (limit, _) in zip(pairs, results)}
    rows = []
    for name, (what, _) in changed.items():
        logarithms = [math.log(found[name, shot] / own[shot]) for shot in range(shots) if found.get((name, shot))]
        rows.append(Change(what, name, *interval(logarithms), len(logarithms)))
    rows.sort(key=lambda one: -abs(one.percent) if math.isfinite(one.percent) else math.inf)
    mean = float(numpy.mean([one for one in own if one])) if any(own) else math.nan
    notes.append(
        f"Changes are of the limits of those of {shots} shots that have one with and without the change (the last column), each found to "
        f"{100 * (WIDTH - 1):.0f} %, one change at a time."
    )
    return Sensitivity(mean, tuple(rows), tuple(notes), sum(costs) + sum(cost for _, cost in results))


def interval(logarithms: Sequence[float]) -> tuple[float, float, float]:
    """Mean change and its interval, percent."""
    count = len(logarithms)
    if not count:
        return math.nan, -math.inf, math.inf
    mean = float(numpy.mean(logarithms))
    if count == 1:
        return 100 * math.expm1(mean), -math.inf, math.inf
    # Each limit lies evenly within WIDTH; two are compared.
    least = 2.0 * math.log(WIDTH) ** 2 / 12.0
    error = math.sqrt(max(float(numpy.var(logarithms, ddof=1)), least) / count)
    half = float(scipy.special.stdtrit(count - 1, 0.5 + 0.5 * CONFIDENCE)) * error
    return tuple(100 * math.expm1(end) for end in (mean, mean - half, mean + half))


def limits(jobs: Sequence[list], **options: object) -> list[tuple[float | None, int]]:
    """`limit_of` each job; the options are those of `ensembles.each`."""
    keys = [f"limit and cost {ensembles.run_key(job[0])} {job[1:]}" for job in jobs]
    results = ensembles.each(limit_of, dict(zip(keys, jobs)), **options)
    return [results[key] for key in keys]
