"""The ballistic limit of a scene: shots chosen one after the other, the fit, its intervals and a report.

`v50` works with any function that shoots; `Shooter` makes one from a scene; `fabric v50 scene.toml` is both as a command.
How velocities are chosen stands in `designs.py`, what is made of the results in `limit.py`, how often its intervals hold the
truth in docs/tables/v50.md.
"""

import functools
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy
import scipy  # Its parts are loaded where they are used.

from . import checks, designs, limit, results, window
from ._kernel import Scene
from .about import cautions, command, described, of_a_scene, positive
from .files import Place, csv_of, written
from .likelihood import LINKS
from .model_error import model_error
from .page import Page, notebook, printed
from .sensitivity import Sensitivity
from .shooter import Shooter, Unknown
from .textile import axes
from .window import Window

Shoot = Callable[[float, int], tuple[bool, float]]
"""Shoots with a velocity (m/s) and the number of the shot, from 0: whether the fabric stopped it, and the residual velocity
(m/s). The number alone decides what is drawn for the shot."""
UNKNOWN = 3
"""So many unknown shots in turn end a test."""


class Shot(NamedTuple):
    velocity: float  # m/s
    stopped: bool
    residual: float  # m/s, 0 if stopped


class Test(NamedTuple):
    """A finished test. `text` and `write` report it, `plot.limit` draws it."""

    title: str
    design: str
    seeds: str
    shots: tuple[Shot, ...]
    fit: limit.Fit
    average: limit.Average
    residual: limit.Residual
    notes: tuple[str, ...]
    about: tuple[str, ...] = ()  # what was shot at
    against: str = ""  # how far the model may be off, where a scene was shot at
    cautions: tuple[str, ...] = ()  # what the reader must know first
    sensitivity: Sensitivity | None = None
    doubt: str = ""  # that slower shots went through
    below: tuple[Shot, ...] = ()  # of the ladder below the limit, which are not fitted
    window: Window | None = None  # then there is no fit

    def answer(self) -> list[str]:
        """The limit, how far the model may be off, and the first cautions, a line each."""
        fit, lines = self.fit, [*filter(None, [self.window.sentence() if self.window else "", self.doubt])]
        for share, value, interval in zip(fit.shares, fit.velocities, fit.intervals):
            if share == 0.5 and not self.window:
                bounded = f"{interval} m/s" if any(math.isfinite(end) for end in interval) else "not bounded by these shots"
                number = f"{value:.1f} m/s, {100 * fit.confidence:g} % interval {bounded}" if math.isfinite(value) else bounded
                lines.append(f"V50 {number}, of the model alone.")
        width = self.sensitivity.sentence() if self.sensitivity else ""
        return [*lines, *filter(None, [self.against]), *([width] if width else self.cautions[:1]), *self.cautions[1:2]]

    @classmethod
    def read(cls, path: Place) -> "Test":
        """The test of a test.json, or of the folder that has it."""
        path = Path(path)
        return results.read(cls, path / "test.json" if path.is_dir() else path)

    def __repr__(self) -> str:
        return f"<Test {self.title!r}, {len(self.shots)} shots: {' '.join(self.answer()[:1]) or 'no limit'}>"

    def _repr_html_(self) -> str:
        return notebook(self.title, self.answer(), self.heading(), self.rows())

    def heading(self) -> tuple[str, ...]:
        return ("", "m/s", f"{100 * self.fit.confidence:g} % interval, m/s", "plain profile likelihood, m/s")

    def every_shot(self) -> tuple[tuple[str, ...], list[tuple[int | str, ...]]]:
        """Heading and rows."""
        rows: list[tuple[int | str, ...]] = [
            (k, f"{s.velocity:.2f}", "stopped" if s.stopped else "through", f"{s.residual:.2f}")
            for k, s in enumerate((*self.shots, *self.below), 1)
        ]
        return ("shot", "m/s", "result", "residual m/s"), rows

    def rows(self) -> list[tuple[str, str, str, str]]:
        """For each share: its name, estimate, interval and the plain profile-likelihood interval, m/s."""
        fit = self.fit
        value = lambda x: f"{x:.1f}" if math.isfinite(x) else "none"
        return [
            (limit.name(share), value(x), str(interval), str(profile))
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
                f"{residual.a:.3f}, "
                f"p {residual.p:.2f}, error {residual.error:.1f} m/s; stopped shots are censored at 0."
            )
        return lines + [note for note in (*self.cautions[2:], residual.note, *fit.notes, *self.notes) if note]

    def text(self) -> str:
        """Design, seeds, every shot, fit and intervals, for the terminal."""
        lines = [self.title, "", *self.answer(), "", printed(self.heading(), self.rows()), *self.sentences(), ""]
        if self.sensitivity:
            lines += [printed(self.sensitivity.heading(), self.sensitivity.rows()), *self.sensitivity.notes, ""]
        return "\n".join([*lines, printed(*self.every_shot())])

    def write(self, folder: Place) -> None:
        """report.html (everything inside), plot.svg, shots.csv and test.json, each whole or as it was before. Raises OSError with
        the name of the file, as where the disk is full."""
        folder = Path(folder)
        from . import plot

        shots = [(k, shot.velocity, int(shot.stopped), shot.residual) for k, shot in enumerate((*self.shots, *self.below), 1)]
        written(folder / "shots.csv", csv_of(("shot", "velocity_m_per_s", "stopped", "residual_m_per_s"), shots))
        plot.limit(self, folder / "plot.svg")
        if self.sensitivity:
            plot.tornado(self.sensitivity, folder / "sensitivity.svg")
            heading = ("variant", "change_percent", "low_percent", "high_percent", "shots")
            written(folder / "sensitivity.csv", csv_of(heading, [one[1:6] for one in self.sensitivity.changes]))
        results.save(self, folder / "test.json")
        written(
            folder / "report.html",
            self.page((folder / "plot.svg").read_bytes(), (folder / "sensitivity.svg").read_bytes() if self.sensitivity else b""),
        )

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
            "shots it holds the truth less often than it says."
        )
        page.table(*self.every_shot())
        return page.html()


def _shots(shoot: Shoot, design: Any, shots: int, say: Callable[[str], None]) -> tuple[list[Shot], list[str]]:
    """The shots of a test, which shots were left out, and why there are fewer than were asked for."""
    made: list[Shot] = []
    left_out: list[str] = []
    in_turn = 0
    design.start(1)
    while len(made) < shots:
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
            stopped, residual = shoot(velocity, len(made) + len(left_out))
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
        made.append(Shot(velocity, bool(stopped), 0.0 if stopped else float(residual)))
        before = ", kept from before" if getattr(shoot, "was_kept", False) else ""
        say(
            f"shot {len(made)} of {shots}: {velocity:.2f} m/s, "
            + ("stopped" if stopped else f"through with {residual:.2f} m/s")
            + before
        )
    return made, left_out


def v50(
    shoot: Shoot,
    design: designs.Neyer | designs.ThreePhase | designs.Plan,
    shots: int,
    *,
    link: str = "probit",
    confidence: float = 0.95,
    tests: int = 1000,
    seed: int = 1,
    title: str = "Ballistic limit",
    seeds: str = "",
    about: Sequence[str] = (),
    say: Callable[[str], None] | None = None,
    below: bool = True,
) -> Test:
    """Shoots, fits and returns the test.

    - `shoot`: a shot that is Unknown is left out, which the report says, and shot again with the next draw; the third in turn
      ends the test: with the bound of the shots so far if all are alike, else by raising it;
    - `design`: chooses the velocities; one that is not positive ends the test, which says so. Neyer's and the three-phase design
      end it after twelve shots with one result, with the bound that they give;
    - `link`: "probit" or "logit", the law of single limits;
    - `below`: whether slower shots are made before the limit is told (`window.py`): where these or others contradict one limit
      there is none;
    - `tests`, `seed`: simulated tests behind each interval, and the seed of the simulations; 0 tests: chi squared instead;
    - `seeds`: words about the draws of the shots, for the report; `about`: what was shot at, likewise; `say`: receives a line
      after each shot.

    Raises ValueError with the name of the argument; what `shoot` raises is passed on.
    """
    checks.whole("shots", shots, 1)
    limit.asked(link, confidence, tests)
    if isinstance(design, designs.Plan) and shots > len(design.velocities):
        raise ValueError(f"shots: the plan has {len(design.velocities)} velocities; shots are {shots}")
    made, notes = _shots(shoot, design, shots, say or (lambda line: None))
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
    slower: list[Any] = []
    if below:

        def shot(velocity: float) -> bool | None:
            number = len(made) + len(notes) + len(slower)
            try:
                stopped, left = shoot(velocity, number)
            except Unknown as unknown:
                notes.append(f"Left out: {unknown}.")
                return None
            slower.append(Shot(velocity, bool(stopped), 0.0 if stopped else float(left)))
            say and say(f"below the limit: {velocity:.2f} m/s, " + ("stopped" if stopped else f"through with {left:.2f} m/s"))
            return not stopped

        hole, doubt, note = window.shot_below(shot, v, y, confidence, seed)
        chosen += f". {note[:-1]}" if slower else ""
    if hole:
        found, average = limit.withheld(found), limit.Average(math.nan, 0, math.nan)
        residual = limit.Residual(math.nan, math.nan, math.nan, math.nan, "")
        hole = hole._replace(near_held=window.near_held(shoot.flown, hole)) if isinstance(shoot, Shooter) else hole
    drawn = seeds or (shoot.drawn() if isinstance(shoot, Shooter) else "")
    words = f"{drawn} {simulated}".strip()
    against = ""
    first: tuple[str, ...] = ()
    if isinstance(shoot, Shooter):
        scaled = axes(shoot.scene)
        notes += [*shoot.notes(), *([scaled.words(found.mu)] if scaled else [])]
        interval = next(interval for share, interval in zip(found.shares, found.intervals) if share == 0.5)
        about = about or described(shoot.scene)
        against, first = (
            model_error([scene for scene, _ in shoot.flown], confidence).sentence(interval.low, interval.high),
            cautions(shoot.scene),
        )
    shots_made, told = tuple(made), (tuple(notes), tuple(about), against, first)
    return Test(title, chosen, words, shots_made, found, average, residual, *told, None, doubt, tuple(slower), hole)


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


def at(
    shoot: Shooter, velocity: float, shots: int, confidence: float, say: Callable[[str], None] | None = None
) -> dict[str, Any]:
    """Whether shots at one velocity, m/s, are stopped: how many of how many went through, and the exact (Clopper-Pearson)
    interval of the share."""
    checks.numbers("velocity", [velocity])
    checks.whole("shots", shots, 1), checks.confident(confidence)
    through = []
    for shot in range(shots):
        stopped, residual = shoot(velocity, shot)
        through.append(not stopped)
        if say:
            say(
                f"shot {shot + 1}: "
                + ("stopped" if stopped else f"through with {residual:.2f} m/s")
                + f"; {sum(through)} of {shot + 1} went through"
            )
    low, high = scipy.stats.binomtest(sum(through), shots).proportion_ci(confidence, method="exact")
    return {
        "velocity": velocity,
        "shots": shots,
        "through": sum(through),
        "share": sum(through) / shots,
        "low": low,
        "high": high,
        "confidence": confidence,
    }


def shooter(given: Any, scene: Scene, to_the_end: bool = False) -> Shooter:
    """Shots at a scene as the options say."""
    return Shooter(
        scene,
        seed=given.seed,
        point=None if given.as_aimed else (0.0, 0.0),
        attitude=given.attitude,
        keep=given.out / "runs.jsonl",
        steps=given.steps,
        to_the_end=to_the_end,
    )


def print_at(given: Any, scene: Scene) -> dict[str, Any]:
    """The answer of --at: a line, and at.json."""
    shoot = shooter(given, scene)
    found = at(
        shoot, given.at, 20 if given.shots is None else given.shots, given.confidence, functools.partial(print, flush=True)
    )
    written(given.out / "at.json", json.dumps(found, indent=1) + "\n")
    print(
        f"\nAt {found['velocity']:g} m/s {found['through']} of {found['shots']} shots went through: "
        f"{100 * found['share']:.0f} %, "
        f"{100 * found['confidence']:g} % interval [{100 * found['low']:.1f}, {100 * found['high']:.1f}] %, of the model alone."
    )
    print(*[model_error([scene]).sentence(), *cautions(scene), *shoot.notes(), shoot.drawn()], sep="\n")
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    """The command `fabric v50`."""
    about = "The ballistic limit of the projectile and the sheet of a scene, with its interval."
    parser = of_a_scene("v50", about, "report.html, plot.svg, shots.csv, test.json, runs.jsonl")
    parser.add_argument("--design", choices=("neyer", "three-phase", "plan"), default="neyer", help="default: %(default)s")
    parser.add_argument(
        "--at",
        type=positive,
        metavar="V",
        help="no limit: the share of 20 (or --shots) shots at this velocity, m/s, that goes through",
    )
    parser.add_argument("--shots", type=int, help="default: 20, or all of the plan")
    parser.add_argument(
        "--low", type=positive, help="guess: V50 is probably above this, m/s; default: no guess, the shots bracket it"
    )
    parser.add_argument("--high", type=positive, help="guess: V50 is probably below this, m/s")
    parser.add_argument(
        "--deviation",
        type=positive,
        help="guess of the standard deviation of single limits, m/s; default: 5 %% of the middle of guess or bracket",
    )
    parser.add_argument("--plan", type=positive, nargs="+", default=[], metavar="V", help="velocities, m/s, for --design plan")
    parser.add_argument(
        "--aim", type=float, help="share whose velocity the last shots of the three-phase design approach, e.g. 0.01"
    )
    parser.add_argument("--last", type=int, help="how many shots that are; default: a third")
    parser.add_argument("--link", choices=tuple(LINKS), default="probit", help="law of single limits; default: %(default)s")
    parser.add_argument("--confidence", type=float, default=0.95, help="default: %(default)s")
    parser.add_argument(
        "--tests", type=int, default=1000, help="simulated tests behind the intervals, 0: chi squared; default: %(default)s"
    )
    parser.add_argument("--steps", type=int, help="most steps of a shot; default: ten times those of an ensemble")
    parser.add_argument(
        "--to-the-end", action="store_true", help="go on after it is decided that a shot goes through, until it has exited"
    )
    parser.add_argument("--attitude", choices=("random",), help="every orientation is equally likely; default: that of the scene")
    parser.add_argument(
        "--as-aimed", action="store_true", help="fly as the scene says, not through a random point within one mesh"
    )
    changed = "width, spacing, time step, viscosity, crimp, strength, friction, support, hold of the attachments, attitude"
    parser.add_argument("--sensitivity", action="store_true", help=f"also how the limit changes with {changed}")
    given = parser.parse_args(arguments)
    for design, names in {"three-phase": ("aim", "last"), "plan": ("plan",)}.items():
        for name in names:
            if given.design != design and getattr(given, name) not in (None, []):
                parser.exit(2, f"error: --{name} goes with --design {design} only\n")
    if given.last is not None and given.aim is None:
        parser.exit(2, "error: --last goes with --aim only\n")

    with command(parser, given) as (scene, fabric):
        if given.at is not None:
            given.answer = print_at(given, scene)
            return
        shots = given.shots if given.shots is not None else len(given.plan) if given.design == "plan" else 20
        plan = design_named(given.design, math.hypot(*scene["projectile.velocity"]), shots, given)
        shoot = shooter(given, scene, to_the_end=given.to_the_end)
        test = v50(
            shoot,
            plan,
            shots,
            link=given.link,
            confidence=given.confidence,
            tests=given.tests,
            say=functools.partial(print, flush=True),
            title=f"Ballistic limit of {given.scene}",
            about=described(scene, fabric),
            seeds=shoot.drawn(),
        )
        if given.sensitivity and math.isfinite(test.fit.mu):
            from .sensitivity import sensitivity

            found = sensitivity(shoot, test.fit.mu, keep=given.out / "sensitivity.jsonl")
            test = test._replace(sensitivity=found)
        print()
        print(test.text())
        test.write(given.out)
        given.answer = test
        print(f"written to {given.out}: report.html, plot.svg, shots.csv, test.json, runs.jsonl")
    if test.window or (test.sensitivity and any(math.isfinite(one.window) for one in test.sensitivity.changes)):
        parser.exit(window.STATUS)


if __name__ == "__main__":
    main()
