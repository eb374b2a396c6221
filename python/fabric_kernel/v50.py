"""The ballistic limit of a scene: shots chosen one after the other, the fit, its intervals and a report.

`v50` works with any function that shoots; `Shooter` makes one from a scene; `fabric v50 scene.toml` is both as a command.
How velocities are chosen stands in `designs.py`, what is made of the results in `limit.py`, how often its intervals hold the
truth in docs/tables/v50.md.
"""

import argparse
import contextlib
import copy
import dataclasses
import functools
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy

from . import checks, designs, limit, network, results, window
from ._kernel import Refused, Scene
from .about import cautions, command, described, finished, of_a_scene, own_tests_of, positive
from .compared import model_error
from .family import Corrected, OwnTests
from .files import Place, csv_of, titled, written
from .likelihood import LINKS
from .notes import Note
from .page import Page, notebook, printed
from .record import record
from .sensitivity import Sensitivity
from .shooter import Shooter, Unknown
from .shots import Shoot, Shot, share_within, shot_of, shots_of
from .textile import axes
from .window import Window

ENOUGH = 8
"""Shots before an interval is looked at."""
AT_IGNORES = set("design low high deviation plan aim last link tests simulated sensitivity within no-network".split())
"""Options that --at would not read."""


@record
class LimitTest:
    """A finished test. `v50` and `interval` are its result, `text` and `write` report it, `plot.limit` draws it."""

    title: Annotated[str, "title of reports"]
    design: Annotated[str, "how the velocities were chosen"]
    seeds: Annotated[str, "seeds of shots and simulated tests"]
    shots: Annotated[tuple[Shot, ...], "shots that are fitted"]
    fit: Annotated[limit.Fit, "fit with its intervals"]
    average: Annotated[limit.Average, "V50 of MIL-STD-662F"]
    residual: Annotated[limit.Residual, "curve of the residual velocities"]
    notes: Annotated[tuple[str, ...], "what was shot at, and how"]
    about: Annotated[tuple[str, ...], "what was shot at"] = ()
    against: Annotated[str, "how far the model may be off, where a scene was shot at"] = ""
    cautions: Annotated[tuple[str, ...], "what the reader must know first"] = ()
    sensitivity: Annotated[Sensitivity | None, "changes of the limit"] = None
    doubt: Annotated[str, "that slower shots went through, or faster ones were stopped"] = ""
    ladder: Annotated[tuple[Shot, ...], "below and above the limit, which are not fitted"] = ()
    window: Annotated[Window | None, "then there is no fit"] = None
    warnings: Annotated[tuple[Note, ...], "decisive ones of the shots"] = ()
    corrected: Annotated[Corrected | None, "V50 as own tests have it"] = None
    shift: Annotated[network.Shift | None, "of the limit by bars half as long"] = None
    within: Annotated[float, "half of the interval that was asked for, over V50"] = math.nan
    groups: Annotated[str, "of residual velocities"] = ""

    @property
    def v50(self) -> float:
        """Velocity at which half of the shots go through, m/s; NaN if there is none."""
        return self.velocity(0.5)

    def velocity(self, share: float = 0.5) -> float:
        """Velocity at which a share of the fit goes through, m/s; NaN if it is not known."""
        return self.fit.velocities[self.place(share)]

    def interval(self, share: float = 0.5) -> limit.Interval:
        """Interval of `velocity`, m/s."""
        return self.fit.intervals[self.place(share)]

    def place(self, share: float) -> int:
        if share not in self.fit.shares:
            checks.refuse("share", f"one of {', '.join(f'{one:g}' for one in self.fit.shares)}", share)
        return self.fit.shares.index(share)

    def kept(self) -> str:
        """Whether the interval and the network keep what was asked for; empty if nothing was."""
        if math.isnan(self.within):
            return ""
        asked, half = f"{100 * self.within:.2g} %", self.half() / self.v50
        if self.window or not math.isfinite(half) or half > self.within:
            return (
                f"Not within {asked}: {self.fit.shots} shots leave {100 * half:.2g} %."
                if math.isfinite(half)
                else f"Not within {asked}."
            )
        if self.shift and not self.shift.interval.low <= 100 * self.within >= -self.shift.interval.high:
            return f"Not within {asked}: bars half as long change the limit by {self.shift.text()} %."
        if self.shift and max(abs(end) for end in self.shift.interval) <= 100 * self.within:
            return f"Within {asked} after {self.fit.shots} shots, and with bars half as long."
        what = "the shift of the network is not known to be" if self.shift else "the network was not looked at"
        return f"Within {asked} after {self.fit.shots} shots, of chance alone: {what}{' so small' * bool(self.shift)}."

    def half(self) -> float:
        """Farther end of the interval of V50 from it, m/s; infinite without one."""
        return max((abs(end - self.v50) for end in self.interval()), default=math.inf)

    def answer(self) -> list[str]:
        """The limit, decisive warnings, how far the model may be off, and the first cautions, a line each."""
        fit, lines = self.fit, [self.window.sentence()] if self.window else []
        for share, value, interval in zip(fit.shares, fit.velocities, fit.intervals):
            if share == 0.5 and not self.window:
                bounded = f"{interval} m/s" if any(math.isfinite(end) for end in interval) else "not bounded by these shots"
                number = f"{value:.1f} m/s, {100 * fit.confidence:g} % interval {bounded}" if math.isfinite(value) else bounded
                lines.append(f"V50 {number}, of the model alone.")
        if self.shift and not self.window:
            percent = f"{self.shift.percent:+.0f}" if math.isfinite(self.shift.percent) else "not known"
            shifted = f"{percent} %, interval {self.shift.text()} % ({self.shift.shots} shots)."
            lines.append(f"Network: bars half as long change it by {shifted} {self.shift.advice()}".strip())
        lines.append(self.kept())
        if self.corrected and not self.window:
            lines.append(self.corrected.words)
        width = self.sensitivity.sentence() if self.sensitivity else ""
        lines += [
            self.doubt,
            *self.warnings,
            self.groups,
            self.residual.note if self.residual.is_bad() else "",
            self.against,
            width,
        ]
        return [*filter(None, lines), *self.cautions[1 if width else 0 : 2]]

    @classmethod
    def read(cls, path: Place) -> "LimitTest":
        """The test of a test.json, or of the folder that has it."""
        path = Path(path)
        return results.read(cls, path / "test.json" if path.is_dir() else path)

    def __repr__(self) -> str:
        return f"<LimitTest {self.title!r}, {len(self.shots)} shots: {' '.join(self.answer()[:1]) or 'no limit'}>"

    def _repr_html_(self) -> str:
        return notebook(self.title, self.answer(), self.heading(), self.rows())

    def heading(self) -> tuple[str, ...]:
        return ("", "m/s", f"{100 * self.fit.confidence:g} % interval, m/s", "plain profile likelihood, m/s")

    def every_shot(self) -> tuple[tuple[str, ...], list[tuple[int | str, ...]]]:
        """Heading and rows."""
        rows: list[tuple[int | str, ...]] = [
            (k, f"{s.velocity:.2f}", "stopped" if s.stopped else "through", f"{s.residual:.2f}")
            for k, s in enumerate((*self.shots, *self.ladder), 1)
        ]
        return ("shot", "m/s", "result", "residual m/s"), rows

    def rows(self) -> list[tuple[str, str, str, str]]:
        """For each share: its name, estimate, interval and, where results overlap, the plain profile-likelihood interval, m/s."""
        fit = self.fit
        value = lambda x: f"{x:.1f}" if math.isfinite(x) else "none"
        # The likelihood of the textbooks has another estimate than Firth's.
        plain = fit.method != "Firth"
        return [
            (limit.name(share), value(x), str(interval), str(profile) if plain else "none")
            for share, x, interval, profile in zip(fit.shares, fit.velocities, fit.intervals, fit.profile)
        ]

    def sentences(self) -> list[str]:
        """What the numbers are and what the reader must know of them."""
        fit, average, residual = self.fit, self.average, self.residual
        lines = [*self.about, self.seeds, f"Design: {self.design}.", f"{fit.shots} shots, {fit.through} went through."]
        if fit.method != "none":
            method = "maximum likelihood" if fit.method == "maximum likelihood" else "Firth's penalised likelihood"
            lines.append(
                f"Fit: {fit.link}, {method}: V50 {fit.mu:.2f} m/s, standard deviation of single limits {fit.deviation:.2f} m/s."
            )
        if math.isfinite(average.value):
            words = f"{average.value:.1f} m/s from {average.shots} shots within {average.spread:.1f} m/s"
            lines.append(f"Average after MIL-STD-662F, for comparison: {words}.")
        else:
            lines.append("Average after MIL-STD-662F, for comparison: none; no group of shots lies near enough.")
        if math.isfinite(residual.limit):
            lines.append(
                f"Residual velocity after Lambert and Jonas: a (v^p - v_l^p)^(1/p) with v_l {residual.limit:.1f} m/s, a "
                f"{residual.a:.3f}, p {residual.p:.2f}, error {residual.error:.1f} m/s; stopped shots are censored at 0."
            )
        note = "" if residual.is_bad() else residual.note
        return lines + [note for note in (*self.cautions[2:], note, *fit.notes, *self.notes) if note]

    def text(self) -> str:
        """Design, seeds, every shot, fit and intervals, for the terminal."""
        lines = [self.title, "", *self.answer(), "", printed(self.heading(), self.rows()), *self.sentences(), ""]
        if self.sensitivity:
            lines += [printed(self.sensitivity.heading(), self.sensitivity.rows()), *self.sensitivity.notes, ""]
        return "\n".join([*lines, printed(*self.every_shot())])

    def write(self, folder: Place) -> list[str]:
        """report.html (everything inside), plot.svg, shots.csv and test.json, each whole or as it was before; their names. Raises
        OSError with the name of the file, as where the disk is full."""
        folder = Path(folder)
        from . import plot

        shots = [(k, shot.velocity, int(shot.stopped), shot.residual) for k, shot in enumerate((*self.shots, *self.ladder), 1)]
        written(folder / "shots.csv", csv_of(("shot", "velocity_m_per_s", "stopped", "residual_m_per_s"), shots))
        plot.limit(self, folder / "plot.svg")
        if self.sensitivity:
            plot.tornado(self.sensitivity, folder / "sensitivity.svg")
            heading = ("variant", "change_percent", "low_percent", "high_percent", "shots")
            written(
                folder / "sensitivity.csv", csv_of(heading, [list(vars(one).values())[1:6] for one in self.sensitivity.changes])
            )
        results.save(self, folder / "test.json")
        written(
            folder / "report.html",
            self.page((folder / "plot.svg").read_bytes(), (folder / "sensitivity.svg").read_bytes() if self.sensitivity else b""),
        )
        names = ["report.html", "plot.svg", "shots.csv", "test.json"]
        return [*names, "sensitivity.svg", "sensitivity.csv"] if self.sensitivity else names

    def page(self, picture: bytes, tornado: bytes = b"") -> str:
        """The report as one HTML file, with the pictures of the limit and of the sensitivity as SVG."""
        page = Page(self.title)
        page.answer(self.answer())
        page.picture(picture, ".svg")
        page.table(self.heading(), self.rows())
        if self.sensitivity:
            page.section("Sensitivity of the limit")
            page.picture(tornado, ".svg")
            page.table(self.sensitivity.heading(), self.sensitivity.rows())
            for note in self.sensitivity.notes:
                page.text(note)
        page.fold("What was shot, how, and what to know of it")
        for line in self.sentences():
            page.text(line)
        page.text(
            "The interval is calibrated by simulated tests of the same design. The plain profile likelihood is that of the "
            "textbooks; with few "
            "shots it holds the truth less often than it says. There is none where the results do not overlap."
        )
        page.table(*self.every_shot())
        return page.html()


def v50(
    shoot: Shoot | Scene | str,
    design: designs.Neyer | designs.ThreePhase | designs.Plan | None = None,
    shots: int = 20,
    *,
    link: str = "probit",
    confidence: float = 0.95,
    tests: int = 1000,
    seed: int = 1,
    title: str = "Ballistic limit",
    seeds: str = "",
    about: Sequence[str] = (),
    say: Callable[[str], None] | None = None,
    beside: bool = True,
    own_tests: OwnTests | None = None,
    within: float | None = None,
    shifted: bool = False,
) -> LimitTest:
    """Ballistic limit with its interval: shoots, fits and returns the test.

    A shot of unknown end is left out, which the report says, and repeated with the next samples; the third in turn ends it.

    Parameters
    ----------
    shoot : callable, Scene or str
        Shots: a `Shooter`, a function of a velocity, m/s, and the number of the shot, or a scene.
    design : Neyer, ThreePhase or Plan, optional
        Chooses the velocities; default: Neyer's design about the velocity of the scene. It ends a test
        after twelve shots with one result, with the bound that they give.
    shots : int
        Number of shots.
    link : str
        Law of single limits, "probit" or "logit".
    confidence : float
        Confidence of the intervals.
    tests : int
        Simulated tests behind each interval; 0: chi squared.
    seed : int
        Seed of the simulated tests.
    title, seeds, about : str, str, sequence of str
        For the report: title, words about the samples, and what was shot at.
    say : callable, optional
        Receives a line after each shot.
    beside : bool
        Whether slower and faster shots are made, too: where these contradict one limit there is none.
    own_tests : OwnTests, optional
        Own firing tests that correct V50 of a `Shooter`'s scene.
    within : float, optional
        Half of the interval of V50 over V50 that ends the test.
    shifted : bool
        Whether the shift of the limit by bars half as long is computed, which takes twice the time.

    Raises
    ------
    ValueError
        An argument is wrong; the message begins with its name.
    Refused
        The scene cannot be simulated.
    """
    checks.whole("shots", shots, 1)
    if isinstance(shoot, (Scene, str)):
        shoot = Shooter(shoot, seed=seed)
    if design is None and isinstance(shoot, Shooter):
        design = designs.Neyer.bracketed(math.hypot(*shoot.scene["projectile.velocity"]), link=link)
    elif design is None:
        checks.refuse("design", "given beside a function that shoots", design)
    limit.asked(link, confidence, tests)
    if isinstance(design, designs.Plan) and shots > len(design.velocities):
        raise ValueError(f"shots: the plan has {len(design.velocities)} velocities; shots are {shots}")
    if within is not None and not 0.0 < within <= 0.5:
        checks.refuse("within", "above 0 and at most 50 %", f"{100 * within:g} %")
    enough = functools.partial(narrow, within, design, link, confidence, tests, seed) if within else lambda made: False
    made, notes = shots_of(shoot, design, shots, say or (lambda line: None), enough)
    if not made:
        raise ValueError(f"design: {notes[0]}")
    v = numpy.array([shot.velocity for shot in made])
    y = numpy.array([not shot.stopped for shot in made])
    found = limit.fit(v, y, link, confidence, design=design, tests=tests, seed=seed)
    simulated = "Intervals: chi squared, not calibrated."
    if tests:
        simulated = f"Intervals: {tests} simulated tests at each point of the calibration, seed {seed}."
    residual = limit.residual_fit(v, y, numpy.array([shot.residual for shot in made]))
    average, chosen, hole, doubt = limit.standard_average(v, y), design.words(), None, ""
    ladder: list[Any] = []
    if beside:

        def shot(velocity: float) -> bool | None:
            try:
                ladder.append(shot_of(shoot, velocity, len(made) + len(notes) + len(ladder)))
            except Unknown as unknown:
                notes.append(f"Left out: {unknown}.")
                return None
            say and say(f"{'below' if velocity < v.mean() else 'above'} the limit: {velocity:.2f} m/s, {ladder[-1].words()}")
            return not ladder[-1].stopped

        hole, doubt, note = window.shot_beside(shot, v, y, confidence, seed)
        chosen += f". {note[:-1]}" if ladder else ""
    passed = [shot for shot in (*made, *ladder) if not shot.stopped]
    groups = window.groups([shot.velocity for shot in passed], [shot.residual for shot in passed])
    if hole:
        found, average = limit.withheld(found), limit.Average(math.nan, 0, math.nan)
        residual = limit.Residual(math.nan, math.nan, math.nan, math.nan, "")
        hole = dataclasses.replace(hole, near_held=window.near_held(shoot.flown, hole)) if isinstance(shoot, Shooter) else hole
    drawn = seeds or (shoot.drawn() if isinstance(shoot, Shooter) else "")
    words = f"{drawn} {simulated}".strip()
    against = ""
    first: tuple[str, ...] = ()
    decisive: tuple[Note, ...] = ()
    corrected, moved = None, None
    if isinstance(shoot, Shooter):
        shot_at = [scene for scene, _ in shoot.flown]  # Without those with bars half as long.
        if shifted and math.isfinite(found.mu):
            try:
                moved = network.shift(shoot, made, found.mu, found.deviation, confidence=confidence, say=say)
            except (Refused, Unknown) as refused:
                decisive = (Note(f"Network: the shift was not computed: {refused}.", "network", {}),)
        scaled = axes(shoot.scene)
        notes += [*shoot.notes(), *([scaled.words(found.mu)] if scaled else [])]
        middle = found.shares.index(0.5)
        value, interval = found.velocities[middle], found.intervals[middle]
        about = about or described(shoot.scene)
        against = model_error(shot_at, confidence).sentence(interval.low, interval.high)
        first, decisive = cautions(shoot.scene), (*shoot.warnings(), *decisive)
        if moved and (moved.is_small() or moved.advice()):  # Found, where a note on the scene only guesses.
            decisive = tuple(note for note in decisive if note.kind != "coarse_network")
        corrected = own_tests.corrected(shot_at, value, *interval) if own_tests else None
        against = "" if corrected and math.isfinite(corrected.value) else against
    shots_made, told = tuple(made), (tuple(notes), tuple(about), against, first)
    last: Any = (doubt, tuple(ladder), hole, decisive, corrected, moved, math.nan if within is None else within, groups)
    return LimitTest(title, chosen, words, shots_made, found, average, residual, *told, None, *last)


def narrow(within: float, design: Any, link: str, confidence: float, tests: int, seed: int, made: Sequence[Shot]) -> bool:
    """Whether the interval of V50 of these shots is so narrow; the calibrated one is looked at once chi squared says so."""
    v, y = numpy.array([shot.velocity for shot in made]), numpy.array([not shot.stopped for shot in made])
    if len(made) < ENOUGH or y.all() or not y.any():
        return False
    for simulated in dict.fromkeys((0, tests)):
        # A design knows where its own test stands.
        fit = limit.fit(v, y, link, confidence, [0.5], design=copy.deepcopy(design), tests=simulated, seed=seed)
        if not max(abs(end - fit.velocities[0]) for end in fit.intervals[0]) <= within * fit.velocities[0]:
            return False
    return True


def width(text: str, given: Any, scene: Scene) -> float:
    """Part of V50, of `2 %` or of a speed over the guess of the limit, which is else the speed of the scene."""
    part, number = text.strip(), math.nan
    for unit, size in (("%", 100.0), ("m/s", given.low or math.hypot(*scene["projectile.velocity"]))):
        if part.endswith(unit):
            with contextlib.suppress(argparse.ArgumentTypeError):
                number = positive(part.removesuffix(unit).strip()) / size
    if math.isnan(number):
        raise ValueError(f"--within: must be a part of V50 or a speed, as 2 % or 10 m/s; it is {text}")
    return number


def design_named(name: str, velocity: float, shots: int, given: Any) -> designs.Neyer | designs.ThreePhase | designs.Plan:
    """The design of the command. Without a guess of V50 it brackets from the velocity of the scene."""
    if name == "plan":
        return designs.Plan(given.plan)
    kind: Any = designs.Neyer if name == "neyer" else designs.ThreePhase
    last = (
        {"aim": given.aim, "last": given.last if given.last is not None else shots // 3, "shots": shots}
        if name == "three-phase"
        else {}
    )
    sigma = None if given.deviation is None else given.deviation / LINKS[given.link].deviation
    if (given.low is None) != (given.high is None):
        raise ValueError("--low, --high: one goes with the other")
    if given.low is None:
        if not velocity > 0.0:
            raise ValueError("projectile.velocity: must not be zero: it is the first velocity and the direction of the shots")
        return kind.bracketed(velocity, sigma, given.link, **last)
    middle = 0.5 * (given.low + given.high)
    return kind(given.low, given.high, sigma or designs.DEVIATION * middle / LINKS[given.link].deviation, given.link, **last)


@record
class Share:
    """What `at` finds of shots at one velocity. `write` reports it."""

    title: Annotated[str, "title of reports"]
    velocity: Annotated[float, "m/s"]
    shots: Annotated[tuple[Shot, ...], "of known end"]
    unknown: Annotated[int, "shots that neither stopped nor went through"]
    through: Annotated[int, "shots that went through"]
    share: Annotated[float, "of the known that went through; NaN without one"]
    low: Annotated[float, "interval: the unknown count as stopped below and as through above"]
    high: Annotated[float, "upper end: the unknown count as through"]
    confidence: Annotated[float, "of the interval"]
    answer: Annotated[tuple[str, ...], "what was found, in sentences"]
    notes: Annotated[tuple[str, ...], "what was shot at, and how"]

    def every_shot(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Heading and rows."""
        return ("shot", "result"), [(str(k), shot.words()) for k, shot in enumerate(self.shots, 1)]

    def text(self) -> str:
        return "\n".join(["", *self.answer, *self.notes])

    def write(self, folder: Place) -> list[str]:
        """report.html and at.json, each whole or as it was before; their names."""
        results.save(self, Path(folder) / "at.json")
        page = Page(self.title)
        page.answer(self.answer)
        page.table(*self.every_shot())
        page.fold("What was shot, and what to know of it")
        for note in self.notes:
            page.text(note)
        written(Path(folder) / "report.html", page.html())
        return ["report.html", "at.json"]


def at(
    shoot: Shoot,
    velocity: float,
    shots: int,
    confidence: float = 0.95,
    say: Callable[[str], None] | None = None,
    *,
    title: str = "Share that goes through",
    about: Sequence[str] = (),
) -> Share:
    """Whether shots at one velocity, m/s, are stopped: how many of how many went through, and the exact (Clopper-Pearson)
    interval of the share. A shot of unknown end counts as stopped for its lower end and as through for the upper one. A Shooter
    whose shots are all alike shoots one, which is the result."""
    checks.numbers("velocity", [velocity])
    checks.whole("shots", shots, 1), checks.confident(confidence)
    alike = isinstance(shoot, Shooter) and not shoot.samples()
    made: list[Shot] = []
    notes: list[str] = []
    for shot in range(1 if alike else shots):
        try:
            made.append(shot_of(shoot, velocity, shot))
            line = f"shot {shot + 1}: {made[-1].words()}"
        except Unknown as why:
            notes.append(line := f"Unknown: {why}.")
        if say:
            say(f"{line}; {sum(not one.stopped for one in made)} of {shot + 1} went through")
    through, known, every = sum(not one.stopped for one in made), len(made), len(made) + len(notes)
    share = through / known if known else math.nan
    low, high = (share, share) if alike and known else share_within(through, len(notes), every, confidence)
    unknown = f", {len(notes)} of unknown end" if notes else ""
    percent = (f"{100 * share:.0f} %" + (" of the others" if notes else "")) if known else "no share"
    answer = [
        f"At {velocity:g} m/s {through} of {every} shots went through{unknown}: {percent}, {100 * confidence:g} % interval "
        f"[{100 * low:.1f}, {100 * high:.1f}] %, of the model alone."
    ]
    if alike and known:
        answer = [f"At {velocity:g} m/s: {made[0].words()}. The scene samples nothing, so this is the result of every shot."]
    if isinstance(shoot, Shooter):
        first = cautions(shoot.scene)
        against = model_error([scene for scene, _ in shoot.flown], confidence).sentence()
        answer += [*shoot.warnings(), against, *first[:2]]
        notes = [*(about or described(shoot.scene)), shoot.drawn(), *first[2:], *notes, *shoot.notes()]
    found = (velocity, tuple(made), every - known, through, share, low, high, confidence)
    return Share(title, *found, tuple(map(str, answer)), tuple(notes))


def shooter(given: Any, scene: Scene) -> Shooter:
    """Shots at a scene as the options say."""
    return Shooter(
        scene,
        seed=given.seed,
        point=None if given.as_aimed else (0.0, 0.0),
        attitude=given.attitude,
        keep=given.out / "runs.jsonl",
        steps=given.steps,
        to_the_end=given.to_the_end,
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """The command `fabric v50`."""
    about = "The ballistic limit of the projectile and the sheet of a scene, with its interval."
    files = (
        "report.html, plot.svg, shots.csv, test.json, runs.jsonl; with --at report.html, at.json, runs.jsonl; with --sensitivity "
        "also sensitivity.svg, sensitivity.csv, sensitivity.jsonl"
    )
    parser = of_a_scene("v50", about, files)
    add = parser.add_argument_group("what is found").add_argument
    add(
        "--at",
        type=positive,
        metavar="V",
        help="no limit: the share of 20 (or --shots) shots at this velocity, m/s, that goes through",
    )
    add("--within", metavar="WIDTH", help='shots until each end of the interval is so near V50, e.g. "2 %%" or "10 m/s"')
    add("--confidence", type=float, default=0.95, help="default: %(default)s")
    changed = "width, spacing, time step, viscosity, crimp, strength, friction, support, hold of the attachments, attitude"
    add("--sensitivity", action="store_true", help=f"also how the limit changes with {changed}")
    add("--no-network", action="store_true", help="no shots with bars half as long, which take twice the time of the others")
    own_tests_of(parser)
    add = parser.add_argument_group("how many shots, at which velocities").add_argument
    add("--shots", type=int, help="default: 20, with --within at most 100, or all of the plan")
    add("--design", choices=("neyer", "three-phase", "plan"), default="neyer", help="default: %(default)s")
    add("--low", type=positive, help="guess: V50 is probably above this, m/s; default: no guess, the shots bracket it")
    add("--high", type=positive, help="guess: V50 is probably below this, m/s")
    add(
        "--deviation",
        type=positive,
        help="guess of the standard deviation of single limits, m/s; default: 5 %% of the middle of guess or bracket",
    )
    add("--plan", type=positive, nargs="+", default=[], metavar="V", help="velocities, m/s, for --design plan")
    add("--aim", type=float, help="share whose velocity the last shots of the three-phase design approach, e.g. 0.01")
    add("--last", type=int, help="how many shots that are; default: a third")
    add = parser.add_argument_group("the fit").add_argument
    add("--link", choices=tuple(LINKS), default="probit", help="law of single limits; default: %(default)s")
    add("--simulated", type=int, default=1000, help="simulated tests behind the intervals, 0: chi squared; default: %(default)s")
    add = parser.add_argument_group("each shot").add_argument
    add("--steps", type=int, help="most steps of a shot; default: ten times those of an ensemble")
    add("--to-the-end", action="store_true", help="go on after it is decided that a shot goes through, until it has exited")
    add("--attitude", choices=("random",), help="every orientation is equally likely; default: that of the scene")
    add("--as-aimed", action="store_true", help="fly as the scene says, not through a random point within one mesh")
    given = parser.parse_args(arguments)
    ignored = {word.partition("=")[0][2:] for word in (sys.argv[1:] if arguments is None else arguments)} & AT_IGNORES
    if given.at is not None and ignored:
        parser.exit(2, f"error: --{min(ignored)}: goes without --at, which finds no limit\n")
    for design, names in {"three-phase": ("aim", "last"), "plan": ("plan",)}.items():
        for name in names:
            if given.design != design and getattr(given, name) not in (None, []):
                parser.exit(2, f"error: --{name} goes with --design {design} only\n")
    if given.last is not None and given.aim is None:
        parser.exit(2, "error: --last goes with --aim only\n")

    with command(parser, given) as (scene, fabric):
        own = OwnTests.read(given.tests) if given.tests else None
        if given.at is not None:
            count, say = 20 if given.shots is None else given.shots, functools.partial(print, flush=True)
            told: Any = {"title": f"Share that goes through, {titled(given.scene)}", "about": described(scene, fabric)}
            given.answer = at(shooter(given, scene), given.at, count, given.confidence, say, **told)
            written_now = given.answer.write(given.out)
            print(given.answer.text())
            finished(given, [*written_now, "runs.jsonl"])
            return
        shots = (
            given.shots if given.shots is not None else len(given.plan) if given.design == "plan" else 100 if given.within else 20
        )
        plan = design_named(given.design, math.hypot(*scene["projectile.velocity"]), shots, given)
        shoot = shooter(given, scene)
        test = v50(
            shoot,
            plan,
            shots,
            link=given.link,
            confidence=given.confidence,
            tests=given.simulated,
            own_tests=own,
            within=None if given.within is None else width(given.within, given, scene),
            shifted=not given.no_network,
            say=functools.partial(print, flush=True),
            title=f"Ballistic limit of {titled(given.scene)}",
            about=described(scene, fabric),
            seeds=shoot.drawn(),
        )
        if given.sensitivity and math.isfinite(test.fit.mu):
            from .sensitivity import sensitivity

            found = sensitivity(shoot, test.fit.mu, keep=given.out / "sensitivity.jsonl")
            test = dataclasses.replace(test, sensitivity=found)
        given.answer = test
        written_now = test.write(given.out)
        print("", test.text(), sep="\n")
        finished(given, [*written_now, "runs.jsonl"])
    if test.window or (test.sensitivity and any(math.isfinite(one.window) for one in test.sensitivity.changes)):
        parser.exit(window.STATUS)


if __name__ == "__main__":
    main()
