"""How the ballistic limit of a scene changes with what was chosen or is not known: `fabric v50 SCENE --sensitivity`.

Method: a few shots each have their own yarns and impact point, and their own limit. For each variant of the scene the limit of
the same shots is found: strides from the limit of the scene itself, each twice as long as the one before, until it lies between
two velocities, then bisection to WIDTH; then a third of the ladder of `window.py` below 0.9 of it, which the shots share: what
goes through there has no limit; a shot without a known end is shot again half of WIDTH faster. The change is the mean of the
logarithms of variant over scene, with Student's interval over the shots, in which the width of the bisection counts as an error
that is evenly distributed.
Cost: in node-steps that of the limits of the scene itself times the nodes and the time step of each variant. The command spends
at most ten times the test: where the scene's own network would cost more, the changes are those of a network of bars of two
yarns, an eighth of the cost.
Limits: one change at a time; three shots give wide intervals; where the model is chaotic, bisection finds one of several
crossings.
"""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy
import scipy  # Its parts are loaded where they are used.

from . import ensembles
from ._kernel import Scene
from .record import record
from .runs import flown
from .search import bisected
from .shooter import Shooter
from .textile import spacings, strength
from .window import ladder

WIDTH, STRIDE = 1.03, 1.08
"""Ratio of velocities at which bisection ends, and that of the first stride."""
SHOTS, CONFIDENCE = 3, 0.95
MOST_STRIDES = 6
TIMES = 10.0
"""Node-steps that it may take, over those of the test."""
HOLDS = 0.7, 0.4, 0.15
"""Forces at which attachments slip, over that at which a bar breaks."""
COARSE = "spacing of the network: twice, with bars of two yarns"


def variants(scene: Scene) -> dict[str, Scene]:
    """The scene of each change, by what is changed and how; what does not apply to a scene is left out."""
    value, found = scene.to_dict(), {}

    def add(what: Any, how: Any, changes: Any) -> None:
        found[f"{what}: {how}"] = scene.replace(changes)

    nodes = {name: value[f"sheet.{name}"] for name in ("nodes_x", "nodes_y")}
    scaled = lambda part: {f"sheet.{name}": round((count - 1) * part) + 1 for name, count in nodes.items()}
    if not value["sheet.grading.largest"]:
        for part in (math.sqrt(0.5), math.sqrt(2.0)):
            changes = scaled(part)
            add(
                "width of the sheet",
                " x ".join(f"{1e3 * (count - 1) * h:.4g}" for count, h in zip(changes.values(), spacings(scene))) + " mm",
                changes,
            )
        parts = ("sheet", "back") if value["back.plies"] else ("sheet",)
        grown = [
            f"{part}.{name}"
            for part in parts
            for name in ("spacing", "spacing_y", "yarn_area", "yarn_area_y")
            if value.get(f"{part}.{name}")
        ]
        grown += ["attachment.hold"] if value["attachment.hold"] else []
        coarse = (
            scaled(0.5)
            | {name: 2.0 * value[name] for name in grown}
            | {f"{part}.node_mass": 4.0 * value[f"{part}.node_mass"] for part in parts}
        )
        what, how = COARSE.split(": ")
        add(what, how, coarse)
    if value["time_step.seconds"]:
        add("time step", "half", {"time_step.seconds": 0.5 * value["time_step.seconds"]})
    else:
        add(
            "time step",
            f"{0.5 * value['time_step.fraction']:g} of the critical",
            {"time_step.fraction": 0.5 * value["time_step.fraction"]},
        )
    viscosity = {f"yarn.viscosity_{kind}": value[f"yarn.viscosity_{kind}"] for kind in ("linear", "quadratic", "bending")}
    if any(viscosity.values()):
        add("viscosity of the yarn", "half", {name: 0.5 * number for name, number in viscosity.items()})
    else:
        add("viscosity of the yarn", "that of real fabrics", dict(zip(viscosity, (0.06, 1.5, 0.06))))
    for how, part in (("half", 0.5), ("double", 2.0)) if value["sheet.thickness"] else ():
        add("thickness of the cloth", how, {"sheet.thickness": part * value["sheet.thickness"]})
    add("crimp", "1 % more", {"sheet.crimp": [part + 0.01 for part in value["sheet.crimp"]]})
    add(
        "failure strain",
        "10 % more",
        {
            name: 1.0 + 1.1 * (value[name] - 1.0)
            for name in (
                "yarn.critical_stretch",
                "weft.critical_stretch",
                *(["back.critical_stretch"] if value["back.plies"] else []),
            )
            if value[name]
        },
    )
    add(
        "friction on the projectile",
        f"{value['contact.friction'] + 0.2:g}",
        {"contact.friction": value["contact.friction"] + 0.2},
    )
    other = "two_sides" if value["attachment.kind"] == "four_sides" else "four_sides"
    add("support", other.replace("_", " "), {"attachment.kind": other})
    for part in HOLDS if value["attachment.kind"] != "free" else ():
        hold = part * value["sheet.yarn_area"] * strength(scene)
        add("hold of the attachments", f"{part:g} of a bar's strength, {hold:.4g} N", {"attachment.hold": hold})
    if value["projectile.shape"] != "sphere":
        degrees, axis, orientation = turn(scene)
        found[f"attitude: turned by {degrees} degrees about {axis}"] = scene.aimed((0.0, 0.0), orientation=orientation)
    return found


def turn(scene: Scene) -> tuple[int, str, tuple[float, ...]]:
    """By how many degrees and about which axis the body is turned, and its orientation then: by 90 about x or y, but by 45 about
    x, an edge ahead, where these map it onto itself, as a cube."""
    # Only here, as it loads matplotlib.
    from .sheets import outline, turned

    w, x, y, z = scene["projectile.orientation"]
    try:
        own = numpy.concatenate(outline(scene))
    except ValueError:  # A hemispherical cylinder is not drawn; its axis tells as much.
        own = numpy.array([[0.0, 0.0, 1.0]])
    looks = lambda orientation: turned(numpy.array(orientation), own)
    for degrees, axis in ((90, "x"), (90, "y"), (45, "x")):
        c, s = math.cos(math.radians(0.5 * degrees)), math.sin(math.radians(0.5 * degrees))
        about_x, about_y = (
            (c * w - s * x, c * x + s * w, c * y - s * z, c * z + s * y),
            (c * w - s * y, c * x + s * z, c * y + s * w, c * z - s * x),
        )
        orientation = about_x if axis == "x" else about_y
        apart = scipy.spatial.distance.cdist(looks(orientation), looks((w, x, y, z))).min(axis=1).max()
        if apart > 1e-6 * numpy.abs(own).max():
            break
    return degrees, axis, orientation


def nodes(scene: Scene) -> int:
    """Nodes of a scene, whose cost is nodes times steps."""
    return scene["sheet.nodes_x"] * scene["sheet.nodes_y"] * scene["stack.plies"]


def crossing(guess: float, through: Callable[[float], bool]) -> float:
    """A velocity at which `through` begins, to WIDTH; NaN if none lies within MOST_STRIDES strides of the guess."""
    first, stride, velocity = through(guess), STRIDE, guess
    for _ in range(MOST_STRIDES):
        before, velocity = velocity, velocity / stride if first else velocity * stride
        if through(velocity) != first:
            low, high = bisected(min(before, velocity), max(before, velocity), through, ratio=WIDTH)
            return math.sqrt(low * high)
        stride *= stride
    return math.nan


def limit_of(job: list[Any]) -> tuple[float | None, int, float | None]:
    """The limit of one shot of a scene, m/s, the node-steps of its search, and the lowest velocity below the limit at which it
    goes through, as in a window, None if it never does. The limit is None if there is none, a window lies below, or a shot's end
    is not known. job: scene, number of the shot, seed, guess, attitude, steps, point."""
    scene, shot, seed, guess, attitude, steps, point = job
    shooter, cost = Shooter(scene, seed=seed, attitude=attitude, steps=steps, point=point), 0

    def through(velocity: Any) -> Any:
        nonlocal cost
        # At the very limit a body may hang in the yarns beyond all steps.
        for faster in (1.0, math.sqrt(WIDTH)):
            one = ensembles.vary(scene, shot + 1, seed=seed, speed=faster * velocity, point=shooter.mesh, attitude=attitude)[shot]
            row = flown(one, shooter.UNTIL, shooter.steps)
            cost += row["steps"] * nodes(scene)
            if row["stopped"] is not None:
                return not row["stopped"]
        raise ArithmeticError

    try:
        found = crossing(guess, through)
        # In the last tenth a chaotic model has other crossings.
        below = ladder([0.9 * found], [False], CONFIDENCE)[shot % SHOTS :: SHOTS] if math.isfinite(found) else ()
        lowest = next((float(velocity) for velocity in below if through(float(velocity))), None)
    except (ArithmeticError, ValueError):  # Among them a velocity that is refused as too fast for the time step.
        return None, cost, None
    return found if math.isfinite(found) and not lowest else None, cost, lowest


@record
class Change:
    """Change of the limit by one change of the scene."""

    what: Annotated[str, "quantity that is changed"]
    variant: Annotated[str, "the change"]
    percent: Annotated[float, "of the limit; NaN if not found"]
    low: Annotated[float, "interval, percent"]
    high: Annotated[float, "its upper end, percent"]
    shots: Annotated[int, "whose limit was found with and without the change"]
    window: Annotated[float, "lowest velocity, m/s, at which a shot goes through below its limit"] = math.nan

    def interval(self, digits: Any) -> Any:
        return f"[{self.low:+.{digits}f}, {self.high:+.{digits}f}]" if math.isfinite(self.low) else "(no bound)"


@record
class Sensitivity:
    """Changes of a limit."""

    limit: Annotated[float, "of the shots of the scene itself, m/s"]
    changes: Annotated[tuple[Change, ...], "the largest first"]
    notes: Annotated[tuple[str, ...], "how the changes were found"]

    def heading(self) -> tuple[str, ...]:
        return ("change", f"limit, %, from {self.limit:.1f} m/s", f"{100 * CONFIDENCE:g} % interval, %", "shots")

    def rows(self) -> Any:
        digits = lambda one: (
            f"{one.percent:+.1f}"
            if math.isfinite(one.percent)
            else f"window at {one.window:.4g} m/s"
            if math.isfinite(one.window)
            else "none"
        )
        return [(one.variant, digits(one), one.interval(1), str(one.shots)) for one in self.changes]

    def sentence(self) -> str:
        """What changes the limit most, whatever it is, and what the width and the network do, for the head of a report."""
        known = [one for one in self.changes if math.isfinite(one.percent)]
        told = lambda one: f"{one.percent:+.0f} % {one.interval(0)} with {one.variant.split(': ')[1]}"
        holes = ", ".join(f"{one.variant} ({one.window:.4g} m/s)" for one in self.changes if math.isfinite(one.window))
        lines = [f"No single limit, as slower shots go through while faster ones are stopped, with {holes}."] if holes else []
        lines += [f"Of {len(known)} changes the largest is that of the {known[0].what}, {told(known[0])}."] if known else []
        for what in ("width of the sheet", COARSE.split(": ")[0]):
            if these := " and ".join(told(one) for one in known if one.what == what):
                lines.append(f"The {what} changes the limit by {these}.")
        return " ".join(lines)


def sensitivity(
    shoot: Shooter, guess: float, *, shots: int = SHOTS, keep: Path | None = None, on: object = None, progress: bool | None = None
) -> Sensitivity:
    """How the limit that a Shooter has tested (`v50`) changes with each of `variants`. guess: that limit, m/s; keep, on,
    progress: as for
    `ensemble`. The coarse network, and then fewer shots, are taken if more than TIMES the node-steps of the test are expected.

    Raises ValueError without shots, Refused if the scene cannot be simulated; a variant that cannot is left out, which the notes
    say."""
    if not shoot.made:
        raise ValueError("shoot: has no shots yet: test it with v50 first")
    scene, seed, attitude = shoot.scene, shoot.seed, shoot.attitude
    test = sum(row["steps"] for row in shoot.made.values()) * nodes(scene)
    # A variant whose shots take much longer than those of the test would take longer than all others.
    steps = min(shoot.steps, 3 * max(row["steps"] for row in shoot.made.values()))
    notes, spent, rows = [], [], []
    windows: dict[Any, Any] = {}

    def sound(base: Any) -> Any:
        left_out = ("attitude" if attitude else "-", COARSE if base is not scene else "-")
        changed = {name: other for name, other in variants(base).items() if not name.startswith(left_out)}
        for name in list(changed):
            try:
                changed[name].check()
            except ValueError as refused:
                notes.append(f"{name}: left out: {refused}.")
                del changed[name]
        return changed

    finer = lambda of: max(
        scene["time_step.fraction"] / of["time_step.fraction"], scene["time_step.seconds"] / (of["time_step.seconds"] or 1.0)
    )

    def found(asked: Any) -> Any:
        """The limits by (name, shot) of each (name, scene, shot, guess), as far as they have one."""
        jobs = [[of, shot, seed, near, attitude, round(steps * finer(of)), (0.0, 0.0)] for _, of, shot, near in asked]
        results = limits(jobs, keep=keep, on=on, progress=progress, name="sensitivity")
        spent.append(sum(cost for _, cost, _ in results))
        for (name, *_), (_, _, lowest) in zip(asked, results):
            if lowest:
                windows[name] = min(lowest, windows.get(name, math.inf))
        return {(name, shot): limit for (name, _, shot, _), (limit, *_) in zip(asked, results) if limit}

    def row(name: str, limits: Any, own: Any) -> None:
        logarithms = [
            math.log(limits[name, shot] / own["", shot]) for shot in range(shots) if (name, shot) in limits and ("", shot) in own
        ]
        values = interval([] if name in windows else logarithms)
        rows.append(Change(name.split(": ")[0], name, *values, len(logarithms), windows.get(name, math.nan)))

    changed, base = sound(scene), scene
    own = found([("", scene, shot, float(guess)) for shot in range(shots)])
    mean = float(numpy.mean(list(own.values()))) if own else math.nan
    # The limits of variants lie farther from the guess: 1.6 times as costly a node-step for the 3 in preset and one ply of
    # Kevlar.
    expected = lambda: 1.7 * spent[-1] * sum(nodes(other) / nodes(base) * finer(other) for other in changed.values())
    if sum(spent) + expected() > TIMES * test and COARSE in changed:
        base = changed[COARSE]
        coarse = found([(COARSE, base, shot, own.get(("", shot), float(guess))) for shot in range(shots)])
        row(COARSE, coarse, own)
        changed, own = sound(base), {("", shot): limit for (_, shot), limit in coarse.items()}
        notes.append(
            "All other changes are found in the network of bars of two yarns: with that of the scene they would take longer."
        )
    asked = shots
    while asked > 1 and sum(spent) + expected() * asked / shots > TIMES * test:
        asked -= 1
    limits_of = found(
        [(name, changed[name], shot, limit) for name in changed for (_, shot), limit in own.items() if shot < asked]
    )
    for name in changed:
        row(name, limits_of, own)
    if scene["projectile.shape"] != "sphere":
        notes.append(
            "Spacing: bars of two yarns may be on the unsafe side for a body with edges or corners, which break single yarns "
            "(docs/v50.md)."
        )
    rows.sort(key=lambda one: -abs(one.percent) if math.isfinite(one.percent) else math.inf)
    notes += [
        f"They are changes from {mean:.1f} m/s, the mean limit of {len(own)} single shots, each found by bisection in its own "
        f"yarns and point. The {guess:.1f} m/s of the test are fitted to many shots with one velocity each.",
        f"Changes are of the limits of those of {asked} shots that have one with and without the change (the last column), "
        f"each found to {100 * (WIDTH - 1):.0f} %, one change at a time.",
        f"The changes took {sum(spent) / test:.1f} times the node-steps of the test.",
    ]
    return Sensitivity(mean, tuple(rows), tuple(notes))


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
    centre, low, high = (100 * math.expm1(end) for end in (mean, mean - half, mean + half))
    return centre, low, high


def limits(jobs: Sequence[list[Any]], **options: Any) -> list[tuple[float | None, int, float | None]]:
    """`limit_of` each job; the options are those of `ensembles.each`."""
    keys = [f"limit, cost and window {ensembles.run_key(job[0])} {job[1:]}" for job in jobs]
    results = ensembles.each(limit_of, dict(zip(keys, jobs)), **options)
    return [results[key] for key in keys]
