"""`fabric residual scene.toml`: the residual velocity over the impact velocity, with the curves of Recht and Ipson and of Lambert
and Jonas.

Method: the limit is bracketed by a factor of two and halved to a tenth; the other shots go from 0.97 to `fastest` limits, denser
near it.
v_r = a (v^p - v_l^p)^(1/p), with p = 2 (Recht and Ipson, where a stands for the mass that goes along) and with p free (Lambert
and Jonas), by maximum likelihood, stopped shots censored at 0.
Intervals: bootstrap of the shots. As many shots are drawn from those made, with repetition, and fitted again; the deviations from
the best fit are enlarged by sqrt(n/(n - k)) t/z for the k numbers fitted to n shots. No limit lies above the velocity from which
on every shot went through, if the best fit does not. A bootstrap with a normal error about the curve would hold the
limit in 22 to 45 % only, as single limits scatter and the curve is steep there.
Limits: few shots lie near the limit, so its interval is too narrow: of 40 invented sets 32 hold it where 95 % is asked for
(tests/python/test_residual.py).
Reference: R. F. Recht, T. W. Ipson, J. Appl. Mech. 30 (1963) 384; J. P. Lambert, G. H. Jonas, BRL Report 1852 (1976).
"""

import dataclasses
import functools
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, Unpack

import numpy
import scipy  # Its parts are loaded where they are used.

from . import checks, limit, results, window
from ._kernel import Scene
from .about import cautions, command, described, finished, of_a_scene, own_tests_of, positive
from .compared import model_error
from .family import Corrected, OwnTests
from .files import Place, csv_of, titled, written
from .page import Page, notebook, printed
from .record import record
from .runs import scene_of
from .shooter import Options, Shooter, Unknown
from .shots import Shot, shot_of
from .window import Window

RESAMPLES = 200
"""Refitted sets of shots behind an interval."""


@record
class Fitted:
    """One curve: the best fit, and (resamples, 3) refitted limits, a and p."""

    name: Annotated[str, "name of the curve"]
    best: Annotated[limit.Residual, "best fit"]
    refits: Annotated[numpy.ndarray, "(resamples, 3) limits (m/s), a and p of refitted shots"]
    confidence: Annotated[float, "of the intervals"]

    def ends(self, values: Any) -> Any:
        return numpy.quantile(values, [0.5 - 0.5 * self.confidence, 0.5 + 0.5 * self.confidence], axis=0)

    def band(self, velocities: Any) -> Any:
        """Lower and upper end of the curve at some velocities, m/s."""
        return self.ends(numpy.array([limit.lambert_jonas(velocities, *one) for one in self.refits]))

    def rows(self) -> list[tuple[str, ...]]:
        """Name, unit-bearing quantity, value, interval."""
        rows = []
        for k, (quantity, value, digits) in enumerate(
            (("limit v_l, m/s", self.best.limit, 1), ("a", self.best.a, 3), ("p", self.best.p, 2))
        ):
            low, high = self.ends(self.refits[:, k])
            interval = "held" if low == high else f"[{low:.{digits}f}, {high:.{digits}f}]"
            rows.append((self.name, quantity, f"{value:.{digits}f}", interval))
        return [*rows, (self.name, "error, m/s", f"{self.best.error:.1f}", "")]


@record
class Curve:
    """Residual velocities and what was fitted to them. `text` and `write` report it, `plot.residual` draws it."""

    title: Annotated[str, "title of reports"]
    shots: Annotated[tuple[Shot, ...], "also those below the limit, which are not fitted"]
    fits: Annotated[tuple[Fitted, ...], "none if fewer than three shots went through at different velocities"]
    confidence: Annotated[float, "of the intervals"]
    answer: Annotated[tuple[str, ...], "what was found, in sentences"]
    notes: Annotated[tuple[str, ...], "what was shot at, and how"]
    window: Annotated[Window | None, "velocities below the limit at which shots go through"] = None
    corrected: Annotated[tuple[Corrected, ...], "limits of the fits as own tests have them"] = ()

    def __repr__(self) -> str:
        return f"<Curve {self.title!r}, {len(self.shots)} shots: {self.answer[0]}>"

    def _repr_html_(self) -> str:
        return notebook(self.title, self.answer, self.heading(), self.rows())

    def heading(self) -> tuple[str, ...]:
        return ("curve", "quantity", "value", f"{100 * self.confidence:g} % interval")

    def every_shot(self) -> Any:
        return ("impact m/s", "residual m/s"), [(f"{shot.velocity:.2f}", f"{shot.residual:.2f}") for shot in self.shots]

    def rows(self) -> Any:
        return [row for fit in self.fits for row in fit.rows()]

    def text(self) -> str:
        tables = [printed(self.heading(), self.rows()), printed(*self.every_shot())]
        return "\n".join([self.title, "", *self.answer, "", *tables, *self.notes]) + "\n"

    def plain(self) -> dict[str, Any]:
        """Answer, curves and shots as numbers and words."""
        keys, curves = ("limit", "a", "p"), []
        for fit in self.fits:
            low, high = (dict(zip(keys, map(float, end))) for end in fit.ends(fit.refits))
            curves.append({"curve": fit.name, **vars(fit.best), "low": low, "high": high})
        return {"answer": self.answer, "curves": curves, "shots": self.shots, "corrected": self.corrected}

    def write(self, folder: Place) -> list[str]:
        """report.html (everything inside), residual.svg, .csv and .json; their names. Raises OSError with that of a file."""
        from . import plot

        folder, shots = Path(folder), [(shot.velocity, int(shot.stopped), shot.residual) for shot in self.shots]
        plot.residual(self, folder / "residual.svg")
        written(folder / "residual.csv", csv_of(("velocity_m_per_s", "stopped", "residual_m_per_s"), shots))
        results.save(self, folder / "residual.json")
        page = Page(self.title)
        page.answer(self.answer)
        page.figure(folder / "residual.svg", "")
        page.table(self.heading(), self.rows(), (1, 3))
        page.fold("What was shot, and what to know of it")
        for note in self.notes:
            page.text(note)
        page.table(*self.every_shot())
        written(folder / "report.html", page.html())
        return ["report.html", "residual.svg", "residual.csv", "residual.json"]


def asked(confidence: float, resamples: int) -> None:
    """Raises ValueError for a confidence whose ends (1 ± confidence)/2 lie beyond the outermost of so many resamples: n >= (1 +
    c)/(1 - c)."""
    most = (resamples - 1) / (resamples + 1)
    if checks.confident(confidence) > most:
        checks.refuse("confidence", f"at most {most:.3f} with {resamples} resamples", confidence)


CURVES = (("Recht and Ipson", 2.0), ("Lambert and Jonas", None))
"""Names of the curves and their powers; None: fitted."""


def fits(shots: Sequence[Shot], confidence: float = 0.95, seed: int = 1, resamples: int = RESAMPLES) -> tuple[Fitted, ...]:
    """Both curves with their intervals; none where there are too few shots."""
    asked(confidence, resamples)
    v, through = numpy.array([shot.velocity for shot in shots]), numpy.array([not shot.stopped for shot in shots])
    on = v[v > v[~through].max(initial=0.0)].min(initial=math.inf)
    r, found = numpy.array([shot.residual for shot in shots]), []
    for name, power in CURVES:
        best = limit.residual_fit(v, through, r, power)
        if not math.isfinite(best.limit):
            return ()
        random, n, spare = numpy.random.default_rng(seed), len(v), max(len(v) - (3 if power else 4), 1)
        middle = numpy.array([best.limit, best.a, best.p])
        half = 0.5 + 0.5 * confidence
        wider = math.sqrt(n / spare) * float(scipy.special.stdtrit(spare, half) / scipy.special.ndtri(half))
        refits: Any = []
        held = None if power or len(numpy.unique(v[through])) >= limit.FREE else best.p
        while len(refits) < resamples:
            chosen = random.integers(0, n, n)
            again = limit.residual_fit(v[chosen], through[chosen], r[chosen], power or held, best)
            if math.isfinite(again.limit):
                refits.append(middle + wider * (numpy.array([again.limit, again.a, again.p]) - middle))
        refits = numpy.clip(refits, [0.0, 0.0, 1.0], [max(on, best.limit), 1.0, 10.0])
        found.append(Fitted(name, best, refits, confidence))
    return tuple(found)


def residual(
    scene: Scene | str,
    velocities: Sequence[float] | None = None,
    *,
    shots: int = 24,
    fastest: float = 2.5,
    seed: int = 1,
    confidence: float = 0.95,
    title: str = "Residual velocity",
    about: Sequence[str] = (),
    say: Callable[[str], None] | None = None,
    own_tests: OwnTests | None = None,
    **options: Unpack[Options],
) -> Curve:
    """Residual over impact velocity, and both curves fitted to it.

    Parameters
    ----------
    scene : Scene or str
        Scene, or the name of a preset or a scene file.
    velocities : sequence of float, optional
        Velocities, m/s; default: `shots` of them, which bracket the limit and go up to `fastest` limits.
    shots : int
        Number of shots without `velocities`.
    fastest : float
        Highest velocity over the limit.
    seed : int
        Seed of yarns and impact points.
    confidence : float
        Confidence of the intervals.
    title, about : str, sequence of str
        Title of reports, and what was shot at.
    say : callable, optional
        Receives a line after each shot.
    own_tests : OwnTests, optional
        Own firing tests that correct the limits.
    options : optional
        Options of `Shooter`.

    Raises
    ------
    ValueError
        An argument is wrong; the message begins with its name.
    Refused
        The scene cannot be simulated.
    """
    scene = scene_of(scene)
    asked(confidence, RESAMPLES)
    checks.numbers("fastest", [fastest])
    if velocities is None:
        checks.whole("shots", shots, 10)
    else:
        velocities = checks.numbers("velocities", velocities).tolist()
    first = math.hypot(*scene["projectile.velocity"])
    if velocities is None and not first > 0.0:
        raise ValueError("projectile.velocity: must not be zero: it is the first velocity and the direction of the shots")
    made: list[Any] = []
    left_out: list[str] = []
    shoot = Shooter(scene, seed=seed, **options)

    def shot(velocity: float) -> bool | None:
        try:
            made.append(shot_of(shoot, velocity, len(made) + len(left_out)))
        except Unknown as unknown:
            left_out.append(f"Left out: {unknown}.")
            return None
        if say:
            say(f"shot {len(made)}: {velocity:.2f} m/s, {made[-1].words()}")
        return not made[-1].stopped

    if velocities is None:
        low, high, velocity = 0.0, math.inf, first
        while high > 1.1 * low and len(made) + len(left_out) < 12:
            if shot(velocity):
                high = min(high, velocity)
            else:
                low = max(low, velocity)
            velocity = 2.0 * low if high == math.inf else 0.5 * high if low == 0.0 else 0.5 * (low + high)
        if not 0.0 < low < high < math.inf:
            raise ValueError(f"projectile.velocity: no limit lies within 12 steps by a factor of two from {first:g} m/s")
        parts = numpy.linspace(0.0, 1.0, max(shots - len(made), 6)) ** 1.7
        velocities = [0.5 * (low + high) * (0.97 + (fastest - 0.97) * part) for part in parts]
    for velocity in velocities:
        shot(float(velocity))
    made.sort()
    hole, doubt, note, own = None, "", "", tuple(made)
    if own:
        results = [one.velocity for one in own], [not one.stopped for one in own]
        hole, doubt, note = window.shot_beside(shot, *results, confidence, seed, above=False)
        made.sort()
    found = () if hole else fits(own, confidence, seed)
    if hole:
        hole = dataclasses.replace(hole, near_held=window.near_held(shoot.flown, hole))
    percent, lines = f"{100 * confidence:g} %", []
    for fit in found:
        low, high = fit.ends(fit.refits[:, 0])
        lines.append(
            f"{fit.name}: limit {fit.best.limit:.1f} m/s, {percent} interval [{low:.1f}, {high:.1f}], of the model alone."
        )
    if not found and not hole:
        lines.append("Fewer than three shots went through at different velocities: no fit of the residual velocities.")
    bad = [f"{fit.name}: {fit.best.note}" for fit in found if fit.best.note]
    passed = [one for one in made if not one.stopped]
    bad += filter(None, [window.groups([one.velocity for one in passed], [one.residual for one in passed])])
    shot_at = [one for one, _ in shoot.flown] or [scene]
    corrected = tuple(own_tests.corrected(shot_at, fit.best.limit, *fit.ends(fit.refits[:, 0])) for fit in found if own_tests)
    lines += (
        [one.words for one in corrected[:1]]
        if len({one.words for one in corrected}) == 1
        else [f"{fit.name}: {one.words}" for fit, one in zip(found, corrected)]
    )
    lines = [hole.sentence()] if hole else lines
    against = model_error(shot_at, confidence).sentence()
    answer = [*lines, *filter(None, [doubt]), *bad, *shoot.warnings(), against, *cautions(scene)[:2]]
    notes = [*about, shoot.drawn(), *filter(None, [note]), *cautions(scene)[2:], *left_out, *shoot.notes()]
    return Curve(title, tuple(made), found, confidence, tuple(map(str, answer)), tuple(notes), hole, corrected)


def main(arguments: Sequence[str] | None = None) -> None:
    """The command `fabric residual`."""
    about = "The residual over the impact velocity of the projectile of a scene, with fitted curves."
    parser = of_a_scene("residual", about, "report.html, residual.svg, residual.csv, residual.json, runs.jsonl")
    add = parser.add_argument
    add(
        "--velocities",
        type=positive,
        nargs="+",
        metavar="V",
        help="m/s; default: the limit is bracketed, then from it up to --fastest limits",
    )
    add("--shots", type=int, default=24, help="default: %(default)s")
    add("--fastest", type=positive, default=2.5, help="largest velocity, in limits; default: %(default)s")
    add("--confidence", type=float, default=0.95, help="default: %(default)s")
    add("--attitude", choices=("random",), help="every orientation is equally likely; default: that of the scene")
    own_tests_of(parser)
    given = parser.parse_args(arguments)
    with command(parser, given) as (scene, fabric):
        own = OwnTests.read(given.tests) if given.tests else None
        curve = residual(
            scene,
            given.velocities,
            shots=given.shots,
            fastest=given.fastest,
            seed=given.seed,
            confidence=given.confidence,
            title=f"Residual velocity of {titled(given.scene)}",
            about=described(scene, fabric),
            say=functools.partial(print, flush=True),
            attitude=given.attitude,
            own_tests=own,
            keep=given.out / "runs.jsonl",
        )
        given.answer = curve.plain()
        names = curve.write(given.out)
        print("", curve.text(), sep="\n")
        finished(given, [*names, "runs.jsonl"])
    if curve.window:
        parser.exit(window.STATUS)
