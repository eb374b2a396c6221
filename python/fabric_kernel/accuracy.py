"""`fabric accuracy SCENE`: error of a scene over its run time, and the cheapest settings that keep an error asked for.

Method: a ladder of networks, from bars four times as long as the scene's down to an eighth, graded where that has fewer nodes,
then time steps and slack_balance at one of them; every setting is shot with the same samples (yarns, place within a mesh of the
scene). The error of a setting is its mean less that of the finest network, in parts of the latter, with the interval of the
paired differences (Student's t). At the coarsest graded network and at the scene's bars the whole one is shot, too, and the
difference counts. The recommendation is the setting with the least processor time for n shots whose error, with the end of its
interval and the chance of n shots (root of the sum of squares), lies within what is asked; no network between it and the finest
may err more, and the finest has bars at most half as long. The finest network errs, too, which is added: by as much as the last
halving moved the mean, which at order one is what all further ones would; where segments fail, by as much as either of the last
two halvings did. With an error asked for the ladder ends once there is one, and shots are added where only their scatter stands
in the way. If three networks agree on an order of convergence, the limit of fine bars is extrapolated.
Limits: what is finer than the finest network run is not seen. After the first failure runs are chaotic, and pairs scatter like
two samples: what the shots cannot resolve is said.
"""

import dataclasses
import itertools
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy
import scipy  # Its parts are loaded where they are used.

from . import checks, ensembles, network, results
from ._kernel import Refused, Scene, Simulation
from .about import CAVEAT, command, described, finished, of_a_scene
from .files import Place, csv_of, filled, titled, written
from .limit import Interval
from .page import Page, notebook, power, printed
from .record import record
from .runs import STEPS, UNTIL, doubts, flown, scene_of
from .sensitivity import crossing, nodes
from .shooter import Shooter, Unknown

BARS, STEP_PARTS = (4.0, 2.0, 1.0, 0.5, 0.25, 0.125), (0.2, 0.5)
"""Lengths of bars over the scene's; time steps over the stable one besides the scene's."""
FEWEST, MOST = 8, 64
"""Shots of a setting at first, and at most."""
COSTLY = 0.25
"""Length of bars over the scene's below which a network gets half of the shots at first: they take most of the time."""
ASKED = (5.0, 2.0, 1.0)
"""Errors, percent, for which settings are recommended if none is asked for."""
MOSTLY = 0.5
"""Share of stopped shots above which the absorbed energy says little."""
ROUNDING = 1e-12
"""Part of the velocity by which shots differ where a scene draws nothing."""
QUANTITIES = {
    "absorbed": ("absorbed energy", "J"),
    "speed": ("speed left", "m/s"),
    "deflection": ("largest deflection", "m"),
    "limit": ("ballistic limit", "m/s"),
}


@record
class Setting:
    """Length of bars over the scene's; time step over the stable one, 0 for the scene's own; whether with slack_balance, and fine
    about the middle alone (`network.graded`)."""

    bars: Annotated[float, "length of bars over the scene's"]
    step: Annotated[float, "time step over the stable one; 0: the scene's own"] = 0.0
    balanced: Annotated[bool, "whether with slack_balance"] = False
    graded: Annotated[bool, "whether fine about the middle alone"] = False

    def is_network(self) -> bool:
        """Whether the network alone differs from the scene's."""
        return not (self.step or self.balanced)

    def scene(self, scene: Scene) -> Scene:
        """The scene so. Raises Refused for a network that cannot be divided or joined so."""
        changes: dict[str, Any] = {}
        if self.bars != 1.0:
            changes["sheet.yarns_per_bar"] = self.bars
        if self.step:
            changes |= {"time_step.fraction": self.step, "time_step.seconds": 0.0}
        elif seconds := scene["time_step.seconds"]:
            changes["time_step.seconds"] = seconds * self.bars
        if self.balanced:
            changes["slack_balance"] = True
        found = scene.replace(changes) if changes else scene
        found.check()
        return found.replace(network.graded(found.aimed((0.0, 0.0)), network.OF_LIMITS)) if self.graded else found


@record
class Row:
    """One setting and what its shots gave."""

    setting: Annotated[Setting, "what was computed with"]
    step: Annotated[float, "time step over the stable one"]
    balanced: Annotated[bool, "whether with slack_balance"]
    shots: Annotated[int, "shots of known end"]
    unknown: Annotated[int, "shots of unknown end"]
    mean: Annotated[float, "mean of the quantity, in its unit"]
    deviation: Annotated[float, "standard deviation of single shots, in that unit"]
    error: Annotated[float, "error of the mean, percent; NaN of the finest network"]
    interval: Annotated[Interval, "interval of the error, percent"]
    stopped: Annotated[int, "shots that were stopped"]
    failed: Annotated[int, "shots in which segments failed"]
    nodes: Annotated[int, "nodes of the network"]
    node_steps: Annotated[float, "node-steps of a shot"]
    seconds: Annotated[float, "processor time of a shot, s"]

    def bound(self) -> float:
        """Largest error that the shots leave, percent."""
        return max(abs(end) for end in self.interval)

    def name(self) -> str:
        length = {0.5: "1/2", 0.25: "1/4", 0.125: "1/8"}.get(self.setting.bars, f"{self.setting.bars:g}")
        return f"{length}, {self.step:.2g}{', balanced' * self.setting.balanced}{', graded' * self.setting.graded}"


@record
class Choice:
    """Settings that keep an error."""

    error: Annotated[float, "error that is asked for, percent"]
    row: Annotated[Row | None, "setting that keeps it; None if none does"]
    runs: Annotated[int, "runs whose mean keeps it"]
    why: Annotated[str, "why no setting keeps it; empty where one does"]


@record
class Accuracy:
    """Error over run time. `text` and `write` report it."""

    title: Annotated[str, "title of reports"]
    quantity: Annotated[str, "what the errors are of"]
    confidence: Annotated[float, "of the intervals"]
    rows: Annotated[tuple[Row, ...], "each setting, the coarse first"]
    choices: Annotated[tuple[Choice, ...], "cheapest settings that keep an error"]
    shift: Annotated[str, "what halving the bars of the finest network but one did"]
    cautions: Annotated[tuple[str, ...], "what the reader must know first"]
    notes: Annotated[tuple[str, ...], "what was shot at, and how"]
    recommended: Annotated[Setting | None, "setting of the first choice; None if none keeps the error"] = None
    recommended_scene: Annotated[str, "scene file with that setting, TOML; empty without"] = ""

    def networks(self) -> list[Row]:
        """Rows of its networks, coarse to fine."""
        return of_ladder(self.rows)

    def answer(self) -> list[str]:
        lines, (words, _) = [], QUANTITIES[self.quantity]
        for one in self.choices:
            if row := one.row:
                runs = f"{one.runs} shot{'s' * (one.runs > 1)}"
                balance = f"{' and slack_balance' * row.setting.balanced}{' and a graded network' * row.setting.graded}"
                lines.append(
                    f"{one.error:g} % of the {words}: bars of {row.setting.bars:g} times the scene's, a step of {row.step:.2g} "
                    f"of the stable one{balance}; the mean of {runs}, {one.runs * row.seconds:.3g} s of a processor."
                )
            else:
                lines.append(f"{one.error:g} % of the {words}: no setting was seen to keep it: {one.why}")
        return [*lines, self.shift, *self.cautions]

    def heading(self) -> tuple[str, ...]:
        words, unit = QUANTITIES[self.quantity]
        error = f"error, %, {100 * self.confidence:g} % interval"
        return (
            "bars, step",
            f"{words}, {unit}",
            "scatter, %",
            error,
            "shots",
            "stopped",
            "nodes",
            "node-steps",
            "seconds a shot",
        )

    def table(self) -> list[tuple[str, ...]]:
        """Rows of the table, as words."""
        found: list[tuple[str, ...]] = []
        for row in self.rows:
            ends = ", ".join(f"{end:+.2f}" if math.isfinite(end) else "no bound" for end in row.interval)
            error = f"{row.error:+.2f} [{ends}]" if math.isfinite(row.error) else "finest"
            shots = f"{row.shots}{f' ({row.unknown} unknown)' if row.unknown else ''}"
            mean = f"{row.mean:.4g}", f"{100 * row.deviation / abs(row.mean) if row.mean else math.nan:.2g}"
            cost = str(row.nodes), power(row.node_steps, 1), f"{row.seconds:.3g}"
            found.append((row.name(), *mean, error, shots, str(row.stopped), *cost))
        return found

    def __repr__(self) -> str:
        return f"<Accuracy {self.title!r}: {self.answer()[0]}>"

    def _repr_html_(self) -> str:
        return notebook(self.title, self.answer(), self.heading(), self.table())

    def text(self) -> str:
        return "\n".join([self.title, "", *self.answer(), "", printed(self.heading(), self.table()), *self.notes]) + "\n"

    def write(self, place: Place) -> list[str]:
        """report.html, accuracy.svg, accuracy.csv, accuracy.json and, with a recommendation, accurate.toml; their names."""
        from . import plot

        out, words = (
            Path(place),
            "bars graded step slack_balance shots unknown mean deviation error_percent low_percent high_percent",
        )
        heading = [*words.split(), *"stopped failed nodes node_steps seconds".split()]
        values = [(row, list(vars(row).values())) for row in self.rows]
        rows = [(row.setting.bars, row.setting.graded, row.step, *its[2:8], *row.interval, *its[9:]) for row, its in values]
        written(out / "accuracy.csv", csv_of(heading, [[filled(one) for one in row] for row in rows]))
        plot.accuracy(self, out / "accuracy.svg")
        results.save(self, out / "accuracy.json")
        page = Page(self.title)
        page.answer(self.answer())
        page.figure(out / "accuracy.svg", "")
        page.table(self.heading(), self.table())
        page.fold("What was shot, how, and what to know of it")
        for note in self.notes:
            page.text(note)
        written(out / "report.html", page.html())
        names = ["report.html", "accuracy.svg", "accuracy.csv", "accuracy.json"]
        if self.recommended_scene:
            written(out / "accurate.toml", self.recommended_scene)
            names.append("accurate.toml")
        return names

    @classmethod
    def read(cls, path: Place) -> "Accuracy":
        """What a file accuracy.json has, or that of a folder."""
        path = Path(path)
        return results.read(cls, path / "accuracy.json" if path.is_dir() else path)


def shot_of(job: list[Any]) -> dict[str, Any]:
    """One shot: `value` (None if its end is not known), whether it was stopped, whether segments failed, node-steps, seconds,
    rows of `fly`. job: scene, scene whose mesh is aimed at, number of the shot, seed, quantity, attitude, guess of a limit,
    steps, whether as aimed."""
    scene, base, shot, seed, quantity, attitude, guess, steps, as_aimed = job
    shoot = Shooter(scene, seed=seed, attitude=attitude, steps=10 * steps, point=None)
    shoot.mesh = None if as_aimed else ensembles.within_mesh(base, (0.0, 0.0))
    start, cost, value = time.process_time(), 0, None  # Once modules are loaded.
    stopped = failed = False
    if quantity == "limit":
        try:
            found = crossing(
                guess, lambda velocity: not shoot(velocity * (1.0 if shoot.samples() else 1.0 + shot * ROUNDING), shot)[0]
            )
            value = found if math.isfinite(found) else None
        except (Unknown, ValueError):
            value = None
        rows = [row for _, row in shoot.flown]
        cost = sum(row["steps"] for row in rows)
    else:
        faster = None if shoot.samples() else math.hypot(*scene["projectile.velocity"]) * (1.0 + shot * ROUNDING)
        drawn = ensembles.vary(scene, shot + 1, seed=seed, speed=faster, point=shoot.mesh, attitude=attitude)[shot]
        rows = [row := flown(drawn, UNTIL, steps)]
        cost, stopped, failed = row["steps"], bool(row["stopped"]), row["failed_segments"] > 0
        if row["stopped"] is not None:
            value = 0.0 if quantity == "speed" and stopped else row["max_deflection" if quantity == "deflection" else quantity]
    spent = time.process_time() - start
    told = {"value": value, "stopped": stopped, "failed": failed, "node_steps": cost * size(scene)}
    return told | {"seconds": spent, "rows": rows}


def size(scene: Scene) -> int:
    """Nodes of the network, of a graded one those that it has."""
    whole = scene["sheet.grading.largest"] < 2
    return nodes(scene) if whole else int(Simulation(scene, warns=False).positions()[..., 0].size)


class Budget(RuntimeError):
    """What is left of the time does not suffice."""


class Ladder:
    """Shots of settings as they are made; the finest network is the reference."""

    def __init__(
        self,
        scene: Scene,
        quantity: str,
        seed: int,
        attitude: str | None,
        as_aimed: bool,
        whole: bool,
        guess: float,
        options: Any,
    ):
        self.scene, self.quantity, self.seed, self.attitude, self.guess = scene, quantity, seed, attitude, guess
        self.as_aimed = as_aimed or scene["symmetry.mirror_x"] or scene["symmetry.mirror_y"]
        self.whole = whole or bool(attitude) or self.as_aimed
        self.options, self.budget = options, math.inf
        self.began = time.monotonic()
        self.scenes: dict[Setting, Scene] = {}
        self.shots: dict[Setting, list[dict[str, Any]]] = {}
        self.cores = options["on"] if isinstance(options["on"], int) else ensembles.cores()
        self.own_step = scene["time_step.fraction"]
        if scene["time_step.seconds"]:
            limits = Simulation(scene, warns=False).step_limits()
            self.own_step = limits["dt"] / limits["dt_crit"]

    def left(self) -> float:
        return self.budget - (time.monotonic() - self.began)

    def shoot(self, setting: Setting, count: int) -> None:
        """Shots of a setting up to this number. Raises Refused, and Budget if they will take longer than is left."""
        if setting not in self.scenes:
            self.scenes[setting] = setting.scene(self.scene)
        scene, made = self.scenes[setting], self.shots.setdefault(setting, [])
        if count <= len(made):
            return
        if any(self.shots.values()) and self.expected(setting, count - len(made)) > self.left():
            raise Budget
        finer = max(1.0, 1.0 / setting.bars) * max(1.0, self.own_step / (setting.step or self.own_step))
        jobs = {}
        for shot in range(len(made), count):
            told = [shot, self.seed, self.quantity, self.attitude, self.guess, round(STEPS * finer), self.as_aimed]
            key = f"accuracy {ensembles.run_key(scene)} {ensembles.run_key(self.scene)} {told}"
            jobs[key] = [scene, self.scene, *told]
        found = ensembles.each(shot_of, jobs, name=f"bars {setting.bars:g}", **self.options)
        made += [found[key] for key in jobs]

    def cost(self, setting: Setting) -> float:
        """Seconds of a processor that a shot takes, from shots of the nearest setting made."""
        if made := self.shots.get(setting):
            return float(numpy.mean([one["seconds"] for one in made]))
        near = min(
            (one for one in self.shots if self.shots[one]), key=lambda one: abs(math.log(one.bars / setting.bars)), default=None
        )
        if near is None:
            return 0.0
        step = lambda one: one.step or self.own_step
        more = 1.5 if setting.balanced and not near.balanced else 1.0
        nodes = self.size(setting) / self.size(near)
        return self.cost(near) * nodes * near.bars / setting.bars * step(near) / step(setting) * more

    def size(self, setting: Setting) -> int:
        """Nodes of a network."""
        return size(self.scenes.setdefault(setting, setting.scene(self.scene)))

    def expected(self, setting: Setting, count: int) -> float:
        """Seconds that so many more shots will take."""
        return self.cost(setting) * max(count / self.cores, 1.0)

    def networks(self) -> list[Setting]:
        """The ladder that was shot, coarse to fine."""
        return ladder_of([one for one in self.shots if self.shots[one]])

    def rung(self, bars: float) -> Setting:
        """The network with these bars: graded where it can be and has fewer nodes then."""
        try:
            aimed = Setting(bars).scene(self.scene).aimed((0.0, 0.0))
            return Setting(bars, graded=not self.whole and bool(network.graded(aimed, network.OF_LIMITS)))
        except Refused:
            return Setting(bars)

    def rows(self, confidence: float) -> list[Row]:
        networks = self.networks()
        order = sorted(
            (one for one in self.shots if self.shots[one]), key=lambda one: (-one.bars, one.balanced, one.graded, one.step)
        )
        return [self.row(one, networks[-1], confidence) for one in order]

    def row(self, setting: Setting, finest: Setting, confidence: float) -> Row:
        made, reference = self.shots[setting], self.shots[finest]
        known = [one for one in made if one["value"] is not None]
        values = numpy.array([one["value"] for one in known])
        pairs = [(a["value"], b["value"]) for a, b in zip(made, reference) if None not in (a["value"], b["value"])]
        error, ends = difference(pairs, confidence) if setting != finest else (math.nan, Interval(-math.inf, math.inf))
        return Row(
            setting,
            setting.step or self.own_step,
            setting.balanced or self.scene["slack_balance"],
            len(known),
            len(made) - len(known),
            float(values.mean()) if known else math.nan,
            float(values.std(ddof=1)) if len(known) > 1 else math.nan,
            error,
            ends,
            sum(one["stopped"] for one in known),
            sum(one["failed"] for one in known),
            size(self.scenes[setting]),
            float(numpy.mean([one["node_steps"] for one in made])),
            float(numpy.mean([one["seconds"] for one in made])),
        )


def ladder_of(settings: Sequence[Setting]) -> list[Setting]:
    """One network for each length of bars, coarse to fine: the graded one if there is one."""
    of_bars = {one.bars: one for one in sorted(settings, key=lambda one: one.graded) if one.is_network()}
    return [of_bars[bars] for bars in sorted(of_bars, reverse=True)]


def of_ladder(rows: Sequence[Row]) -> list[Row]:
    """Rows of its networks, coarse to fine."""
    found = {row.setting: row for row in rows if row.shots}
    return [found[one] for one in ladder_of(list(found))]


def difference(pairs: Sequence[tuple[float, float]], confidence: float) -> tuple[float, Interval]:
    """Mean of the first less that of the second of each pair, over the latter, and its interval, percent."""
    if not pairs:
        return math.nan, Interval(-math.inf, math.inf)
    first, second = numpy.array(pairs).T
    scale = 100.0 / abs(float(second.mean())) if second.mean() else math.inf
    apart, count = first - second, len(pairs)
    middle = float(apart.mean())
    if not apart.any():
        return 0.0, Interval(0.0, 0.0)
    if count == 1 or not math.isfinite(scale):
        return scale * middle, Interval(-math.inf, math.inf)
    half = float(scipy.special.stdtrit(count - 1, 0.5 + 0.5 * confidence) * apart.std(ddof=1) / math.sqrt(count))
    return scale * middle, Interval(scale * (middle - half), scale * (middle + half))


def unseen(rows: Sequence[Row]) -> float:
    """Error of the finest network, percent: what the last halving did, as if the order of convergence were one, and what grading
    did where it was seen. Where segments fail, two networks may agree by chance: the larger of the last two halvings, infinite of
    one."""
    networks = of_ladder(rows)
    apart = lambda one, other: 100.0 * abs(one.mean - other.mean) / abs(other.mean or math.nan)
    moved = [apart(one, other) for one, other in itertools.pairwise(networks)]
    whole = {row.setting.bars: row for row in rows if row.setting == Setting(row.setting.bars)}
    grading = next((apart(row, whole[row.setting.bars]) for row in networks[::-1] if row.setting.bars in whole), 0.0)
    if any(row.failed for row in networks):
        return grading + (max(moved[-2:]) if len(moved) > 1 else math.inf)
    return grading + (moved[-1] if moved else math.inf)


def chosen(rows: Sequence[Row], asked: float, confidence: float) -> Choice:
    """The setting with the least processor time that keeps an error, percent."""
    networks = of_ladder(rows)
    finest, costs, best, why, rest = networks[-1], math.inf, None, "", unseen(rows)
    z = float(scipy.special.ndtri(0.5 + 0.5 * confidence))
    # The scatter of few shots is uncertain itself: the largest of the networks counts.
    scatter = max((100.0 * row.deviation / abs(row.mean) for row in networks[-2:] if row.shots > 1 and row.mean), default=0.0)
    for row in rows:
        between = [other for other in networks if finest.setting.bars < other.setting.bars < row.setting.bars]
        steps = [other for other in rows if other.setting.bars == row.setting.bars and other.step < row.step]
        if row is finest or row.setting.bars < 2.0 * finest.setting.bars or row.unknown or not row.bound() + rest < asked:
            continue
        if any(abs(other.error) > asked for other in (*between, *steps)):
            continue
        runs = max(1, math.ceil((z * scatter) ** 2 / (asked**2 - (row.bound() + rest) ** 2)))
        if runs * row.seconds < costs:
            costs, best = runs * row.seconds, Choice(asked, row, runs, "")
    if best:
        return best
    others = [row for row in networks if row is not finest and math.isfinite(row.error)]
    near = [row for row in others if abs(row.error) + rest < asked]
    if near:
        row = near[-1]
        half = row.bound() - abs(row.error)
        needed = math.ceil(row.shots * (half / max(asked - abs(row.error) - rest, 1e-3 * asked)) ** 2)
        why = f"{row.shots} shots with bars of {row.setting.bars:g} leave {row.bound() + rest:.2g} % possible, and "
        why += f"some {needed} are needed." if needed < 10 * MOST else "only a finer network can decide."
    elif others:
        last = [f"{100.0 * one / abs(finest.mean or math.nan):+.2g}" for one in numpy.diff([row.mean for row in networks])][-2:]
        two = len(last) > 1 and any(row.failed for row in networks)
        why = f"the last two halvings of the bars move it by {' and '.join(last)} %" if two else ""
        why = why or f"the last halving of the bars moves it by {last[-1]} %, and further ones may by as much again"
        why += f"; a finer network is needed, {8 * finest.seconds:.3g} s a shot."
    else:
        why = "one network alone was run."
    return Choice(asked, None, 0, why)


def convergence(rows: Sequence[Row], quantity: str) -> str:
    """What the last halving of the bars did, and where three networks agree on an order, what finer bars would give."""
    networks = of_ladder(rows)
    if len(networks) < 2:
        return ""
    before, last = networks[-2], networks[-1]
    low, high = (-end for end in before.interval[::-1])
    text = (
        f"From bars of {before.setting.bars:g} to {last.setting.bars:g} times the scene's the {QUANTITIES[quantity][0]} moves by "
    )
    text += f"{-before.error:+.2g} % [{low:+.2g}, {high:+.2g}]"
    if len(networks) > 2:
        one, other = networks[-3].mean - before.mean, before.mean - last.mean
        resolved = all(row.bound() < 2.0 * abs(row.error) for row in networks[-3:-1])
        if resolved and one * other > 0.0 and 0.5 <= (order := math.log2(one / other)) <= 4.0:
            rest = -100.0 * other / (2.0**order - 1.0) / last.mean
            return (
                f"{text}; at the order {order:.2g} of the last three networks finer bars would move it by another {rest:+.2g} %."
            )
    return f"{text}; what finer bars would do was not seen."


def accuracy(
    scene: Scene | str,
    error: float | None = None,
    *,
    quantity: str = "absorbed",
    shots: int = FEWEST,
    seed: int = 1,
    attitude: str | None = None,
    as_aimed: bool = False,
    whole: bool = False,
    budget: float = 300.0,
    bars: Sequence[float] = BARS,
    confidence: float = 0.95,
    keep: Place | None = None,
    on: ensembles.Workers = None,
    progress: bool | None = None,
    say: Callable[[str], None] | None = None,
    title: str = "",
) -> Accuracy:
    """Error of a scene over its run time, and the cheapest settings that keep an error.

    Parameters
    ----------
    scene : Scene or str
        Scene, or the name of a preset or a scene file.
    error : float, optional
        Error to keep, percent, above 0 and at most 50; default: a recommendation for each of 5, 2 and 1 %.
    quantity : str
        "absorbed" energy, "speed" left, largest "deflection" of held cloth, or ballistic "limit" of single shots.
    shots : int
        Shots of each setting at first, half as many of bars shorter than a quarter; with an error more where the scatter stands
        in the way.
    seed : int
        Seed of yarns and impact points.
    attitude : str, optional
        "random": every orientation is equally likely; default: that of the scene.
    as_aimed : bool
        Whether shots fly as the scene says, not through a random point within one mesh.
    budget : float
        Time, s, after which no setting begins that would not end within it.
    bars : sequence of float
        Lengths of bars over the scene's, the coarse first.
    whole : bool
        Whether no network is graded, as none is about a random attitude or a scene as it is aimed.
    confidence : float
        Confidence of the intervals.
    keep : path, optional
        File of kept results: what is in it is not computed again.
    on : int, str, Client or Cluster, optional
        Number of processes, or Dask scheduler; default: a process for each core.
    progress : bool, optional
        Whether to show a progress bar; default: on a terminal.
    say : callable, optional
        Receives a line for each setting.
    title : str
        Title of reports.

    Raises
    ------
    ValueError
        An argument is wrong; the message begins with its name.
    Refused
        The scene cannot be simulated.
    """
    scene = scene_of(scene)
    if quantity not in QUANTITIES:
        checks.refuse("quantity", f"one of {', '.join(QUANTITIES)}", quantity)
    if error is not None and not 0.0 < error <= 50.0:
        checks.refuse("error", "above 0 and at most 50 %", f"{error:g} %")
    if not budget > 0.0:
        checks.refuse("budget", "a time above 0", budget)
    checks.whole("shots", shots, 2), checks.confident(confidence)
    if scene["drive"] == "prescribed":
        raise ValueError("scene: drive is prescribed: a host moves the projectile, and only the host knows what it does")
    scene.check()
    speed, say = math.hypot(*scene["projectile.velocity"]), say or (lambda line: None)
    if not speed > 0.0:
        raise ValueError("projectile.velocity: must not be zero: nothing is hit")
    ladder = Ladder(scene, quantity, seed, attitude, as_aimed, whole, speed, {"keep": keep, "on": on, "progress": progress})
    notes, asked, ended = [], ASKED if error is None else (error,), ""

    def told(setting: Setting) -> None:
        networks = ladder.networks()
        row = ladder.row(setting, networks[-1], confidence)
        words, unit = QUANTITIES[quantity]
        say(f"bars {row.name()}: {words} {row.mean:.4g} {unit}, {row.shots} shots, {row.seconds:.3g} s each")

    def run(setting: Setting, count: int) -> bool:
        """Whether the shots could be made."""
        nonlocal ended
        try:
            ladder.shoot(setting, count)
        except Refused as refused:
            notes.append(f"Bars of {setting.bars:g} times the scene's are left out: {refused}.")
            return False
        except Budget:
            takes = ladder.expected(setting, count)
            shots_left = f"{count} shots with bars of {setting.bars:g} take another {takes:.0f} s"
            ended = f"The budget of {budget:g} s ended the ladder: {shots_left}."
            return False
        told(setting)
        return True

    found = lambda: [chosen(ladder.rows(confidence), one, confidence) for one in asked]

    def resolved() -> None:
        """More shots, where they cost less than finer bars."""
        while error is not None and not found()[0].row:
            networks = ladder.networks()
            rows = [ladder.row(one, networks[-1], confidence) for one in networks[:-1]]
            rest = unseen(ladder.rows(confidence))
            near = [row for row in rows if abs(row.error) + rest < error and row.setting.bars >= 2.0 * networks[-1].bars]
            if not near:
                return
            row = near[-1]
            half = row.bound() - abs(row.error)
            needed = row.shots * (half / max(error - abs(row.error) - rest, 0.1 * error)) ** 2
            count = max(row.shots + 2, min(2 * row.shots, math.ceil(needed)))
            if needed > MOST or count > MOST:
                return
            finer = ladder.rung(networks[-1].bars / 2.0)
            if (
                finer.bars in bars
                and ladder.expected(finer, row.shots) < (needed - row.shots) * ladder.cost(networks[-1]) / ladder.cores
            ):
                return
            for one in networks[-3:]:
                whole = {Setting(one.bars)} & ladder.shots.keys()
                if not all(run(other, count) for other in {one} | whole):
                    return

    ladder.budget = budget
    done, graded = 0, False
    for length in bars:
        setting = ladder.rung(length)
        if not done:  # One shot tells what the others cost.
            if not run(setting, 1):
                continue
            two = (ladder.cost(setting) * shots * 9.0) / ladder.cores
            if two > ladder.left():
                needed = math.ceil(1.3 * two + budget - ladder.left())
                raise ValueError(f"budget: must be at least {needed} s for two settings; it is {budget:g} s")
        if not run(setting, shots if length >= COSTLY else max(shots // 2, 2)):
            if ended:
                break
            continue
        if setting.graded and (length == 1.0 or not graded) and not run(Setting(length), shots):
            break
        graded |= setting.graded
        done += 1
        if done > 1 and error is not None:
            resolved()
            if found()[0].row:
                break
    if done < 2:
        raise ValueError(f"scene: fewer than two networks can be run: {' '.join([*notes, ended])}")
    # Time steps at the network that is recommended, else at the finest that costs no more than the scene's.
    rows = [one.row for one in found() if one.row]
    base = ladder.rung(rows[-1].setting.bars if rows else max(ladder.networks()[-2].bars, 1.0))
    steps = [dataclasses.replace(base, step=step) for step in STEP_PARTS if abs(step - ladder.own_step) > 0.01]
    steps += [] if scene["slack_balance"] or error is not None else [dataclasses.replace(base, balanced=True)]
    for one in steps:
        run(one, len(ladder.shots[base]))
    rows, choices = ladder.rows(confidence), tuple(found())
    own = next((one for one in (Setting(1.0), ladder.rung(1.0)) if ladder.shots.get(one)), ladder.networks()[-1])
    flights = [row for shot in ladder.shots[own] for row in shot["rows"]]
    cautions = list(map(str, doubts([ladder.scenes[own]] * len(flights), flights)))
    stopped, made = sum(row.stopped for row in rows), sum(row.shots for row in rows)
    if quantity == "absorbed" and stopped > MOSTLY * made:
        cautions.append(
            f"{stopped} of {made} shots were stopped and absorb the energy of the body, whatever the settings: ask for the limit "
            "or the deflection (--quantity limit, --quantity deflection), or shoot faster."
        )
    if ended:
        cautions.append(ended)
    notes += [
        *described(scene),
        f"Bars: length over the scene's; step: over the largest stable one. Every setting has the samples of seed {seed}: "
        + (
            "the scene as it is aimed."
            if ladder.as_aimed
            else "yarns as the scene samples them, and a place within one of its meshes."
        ),
        f"Errors are against the finest network, from pairs of shots with the same samples; {100 * confidence:g} % intervals.",
        "A recommendation allows for an error of the finest network as large as what the last halving of the bars did; where "
        "segments fail, as either of the last two.",
        "It also allows for what grading did to the network with the scene's bars, or the coarsest.",
        CAVEAT,
    ]
    pick = choices[0]
    best = pick.row.setting if pick.row else None
    told_of = (
        f"# Recommended by fabric accuracy for {asked[0]:g} % of the {QUANTITIES[quantity][0]}: the mean of {pick.runs} shots.\n"
    )
    toml = told_of + best.scene(scene).to_toml() if best else ""
    moved = convergence(rows, quantity)
    name = title or "Error over run time"
    return Accuracy(name, quantity, confidence, tuple(rows), choices, moved, tuple(cautions), tuple(notes), best, toml)


def percent(text: str) -> float:
    """An error of the command line: `2 %`, `2%` or `2`."""
    try:
        found = float(text.strip().removesuffix("%").strip())
    except ValueError:
        found = math.nan
    if not 0.0 < found <= 50.0:
        raise ValueError(f"--error: must be a number of percent above 0 and at most 50, as 2 %; it is {text}")
    return found


def seconds(text: str) -> float:
    """A time of the command line: `5 min`, `90 s`, `1 h`."""
    number, unit = text.strip(), 1.0
    for name, size in (("min", 60.0), ("s", 1.0), ("h", 3600.0)):
        if number.endswith(name):
            number, unit = number.removesuffix(name), size
            break
    try:
        return unit * float(number)
    except ValueError:
        raise ValueError(f"--budget: must be a time, as 5 min; it is {text}") from None


def main(arguments: Sequence[str] | None = None) -> None:
    """The command `fabric accuracy`."""
    about = "Error against run time of a scene, and the cheapest settings that keep an error."
    parser = of_a_scene("accuracy", about, "report.html, accuracy.svg, accuracy.csv, accuracy.json, accurate.toml, runs.jsonl")
    add = parser.add_argument
    add("--error", metavar="PERCENT", help='e.g. "2 %%": the ladder ends once a setting keeps it; default: all of the budget')
    add("--quantity", default="absorbed", help=f"one of {', '.join(QUANTITIES)}; default: %(default)s")
    add("--budget", default="5 min", help='time for it by the clock, e.g. "90 s", "5 min"; default: %(default)s')
    add("--shots", type=int, default=FEWEST, help="of each setting at first; default: %(default)s")
    add("--attitude", choices=("random",), help="every orientation is equally likely; default: that of the scene")
    add("--as-aimed", action="store_true", help="fly as the scene says, not through a random point within one mesh")
    add("--whole", action="store_true", help="do not grade networks; default: fine where the body strikes")
    add("--confidence", type=float, default=0.95, help="default: %(default)s")
    add("--on", help="number of processes, or the address of a Dask scheduler")
    given = parser.parse_args(arguments)
    with command(parser, given) as (scene, _):
        found = given.answer = accuracy(
            scene,
            None if given.error is None else percent(given.error),
            quantity=given.quantity,
            shots=given.shots,
            seed=given.seed,
            attitude=given.attitude,
            as_aimed=given.as_aimed,
            whole=given.whole,
            budget=seconds(given.budget),
            confidence=given.confidence,
            keep=given.out / "runs.jsonl",
            on=int(given.on) if given.on and given.on.isdigit() else given.on,
            say=lambda line: print(line, flush=True),
            title=f"Error over run time of {titled(given.scene)}",
        )
        names = found.write(given.out)
        print("", found.text(), sep="\n")
        finished(given, [*names, "runs.jsonl"])


if __name__ == "__main__":
    main()
