"""`fabric compare A.toml B.toml ...`: shields side by side, ranked, and which of their differences are beyond their error.

Method: the limit of each shield as `fabric v50` finds it; shot k of each has the same samples (yarns, place within a mesh). The
interval of ln of the ratio of two limits combines their calibrated intervals (MOVER); it takes no account of what the samples
have in common, so that it is rather too wide. Its p is that of Student's t, of n - 2 degrees of freedom for n shots each.
With --at the shares stopped at one velocity are compared, by shots with the same samples of which one alone was stopped (exact
test of McNemar). p are corrected for the number of pairs by Holm's method.
A difference is said if the corrected p is below 1 - confidence, and with the network's shifts of both limits added its interval
still excludes 0. With own tests another line says whether it exceeds the scatter of shields, too.
Limits: of the model alone; docs/validation.md says what it ranks.
Reference: G. Y. Zou, A. Donner, Statist. Med. 27 (2008) 1693; S. Holm, Scand. J. Statist. 6 (1979) 65; Q. McNemar, Psychometrika
12 (1947) 153.
"""

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy
import scipy  # Its parts are loaded where they are used.

from . import batch, checks, limit, network, results, shields, window
from ._kernel import PRESETS, Scene
from .about import CAVEAT, COMPARED, attachments, described, ending, folder, goes_on, of_others, options, positive
from .compared import model_error
from .ensembles import Workers, vary
from .family import Corrected, OwnTests
from .files import Place, apart, csv_of, filled, shown, titled, written
from .notes import Note
from .page import Page, notebook, printed
from .record import record
from .runs import scene_of
from .textile import areal_density

WRITTEN = "report.html", "compare.svg", "compare.csv", "pairs.csv", "compare.json"
MOST_PAIRS = 15
"""Pairs that a report lists; of more only neighbours in the ranking, and pairs.csv has all."""


@record
class Shield:
    """One shield. With a velocity that was asked for, `value` and `interval` are the share stopped there, percent."""

    name: Annotated[str, "name"]
    areal_density: Annotated[float, "kg/m²"]
    value: Annotated[float, "V50, m/s; NaN if there is none"]
    interval: Annotated[limit.Interval, "of value"]
    why: Annotated[str, "there is no limit"]
    window: Annotated[bool, "slower shots go through while faster ones are stopped"]
    shift: Annotated[network.Shift | None, "of the limit by bars half as long"]
    corrected: Annotated[Corrected | None, "limit as own tests correct it"]
    against: Annotated[str, "of the model against tests"]
    shots: Annotated[int, "number of shots"]
    node_steps: Annotated[float, "cost"]
    cautions: Annotated[tuple[Note, ...], "what the reader must know first"]
    notes: Annotated[tuple[str, ...], "of the test"]


@record
class Pair:
    """Two shields, the better one first."""

    first: Annotated[str, "better shield"]
    second: Annotated[str, "other shield"]
    percent: Annotated[float, "limit of the first over that of the second, less 1; or difference of shares"]
    interval: Annotated[limit.Interval, "of percent"]
    p: Annotated[float, "corrected by Holm"]
    verdict: Annotated[str, "whether the network or own tests change what p says"]
    differs: Annotated[bool, "whether the difference is beyond its error"]
    shots: Annotated[float, "shots of each that such a difference needs; NaN where it differs, or is not known"]
    node_steps: Annotated[float, "cost of both"]


@record
class Comparison:
    """Shields, ranked. `text` and `write` report them."""

    title: Annotated[str, "title of reports"]
    at: Annotated[float, "velocity, m/s; NaN: limits"]
    confidence: Annotated[float, "of the intervals"]
    shields: Annotated[tuple[Shield, ...], "the best first"]
    pairs: Annotated[tuple[Pair, ...], "every two shields"]
    axes: Annotated[tuple[tuple[str, ...], ...], "of a table of parameters: name, parameters and their cells of each shield"]
    cautions: Annotated[tuple[str, ...], "what the reader must know first"]
    notes: Annotated[tuple[str, ...], "what was shot at, and how"]

    def unit(self) -> str:
        return "m/s" if math.isnan(self.at) else "%"

    def answer(self) -> list[str]:
        percent, best = f"{100 * self.confidence:g} %", self.shields[0]
        of_model = f"{best.value:.1f} m/s, {percent} interval {best.interval} m/s"
        if math.isnan(best.value):
            lines = [f"No shield has a limit: {best.name}: {best.why}"]
        elif math.isnan(self.at):
            lines = [f"Highest limit: {best.name}, V50 {of_model}, of the model."]
            if best.corrected and math.isfinite(best.corrected.value):
                it = best.corrected
                lines = [
                    f"Highest limit: {best.name}, V50 {it.value:.1f} m/s, {percent} interval {it.interval} m/s, as own tests "
                    f"correct it; of the model alone {of_model}."
                ]
        else:
            names = [one.name for one in self.shields if one.value == best.value]
            names[3:] = [f"{len(names) - 3} more"] * (len(names) > 3)
            stopped = f"{' and '.join(names)}, {best.value:.0f} %, {percent} interval {best.interval} %"
            lines = [f"Most stopped at {self.at:g} m/s: {stopped}."]
        if self.pairs:
            unit = "%" if math.isnan(self.at) else "points"
            by = lambda pair: f"{pair.percent:.0f} {unit} [{pair.interval.low:.0f}, {pair.interval.high:.0f}]"
            beyond = [f"{pair.first} over {pair.second} by {by(pair)}" for pair in neighbours(self) if pair.differs]
            beyond[3:] = ["..."] * (len(beyond) > 3)
            count = f"{sum(pair.differs for pair in self.pairs)} of {len(self.pairs)}"
            level = f"Holm, {100 * (1 - self.confidence):.2g} % in all"
            lines.append(f"Differences beyond their error ({level}): {'; '.join([count, *beyond])}.")
        alike = [pair for pair in neighbours(self) if not pair.differs]
        if alike:
            others = f"; and {len(alike) - 3} more neighbours" if len(alike) > 3 else ""
            lines.append(f"Not distinguished: {'; '.join(f'{pair.first} and {pair.second}' for pair in alike[:3])}{others}.")
        # Sentences about several shields once; of the others the best one's, and the report has all.
        said = [
            one.corrected.words if one.corrected and math.isfinite(one.corrected.value) else one.against for one in self.shields
        ]
        lines.append(said[0] if len(set(said)) == 1 else f"{best.name}: {said[0]} Each of the others is below.")
        return [*lines, *self.cautions]

    def heading(self) -> tuple[str, ...]:
        value = "V50, m/s" if math.isnan(self.at) else f"stopped at {self.at:g} m/s, %"
        own = ("with own tests, m/s",) if any(one.corrected for one in self.shields) else ()
        network = ("network, %",) if math.isnan(self.at) else ()
        return ("shield", "kg/m²", value, f"{100 * self.confidence:g} % interval", *network, *own, "shots", "1e9 node-steps")

    def rows(self) -> list[tuple[str, ...]]:
        own, rows = any(one.corrected for one in self.shields), []
        for one in self.shields:
            it = one.corrected
            said = f"{it.value:.1f} {it.interval}" if it and math.isfinite(it.value) else "do not hold"
            value = f"{one.value:.1f}" if math.isfinite(one.value) else "none"
            shift = [one.shift.text() if one.shift else "not computed"] * math.isnan(self.at)
            cost = str(one.shots), f"{1e-9 * one.node_steps:.3g}"
            rows.append((one.name, f"{one.areal_density:.3g}", value, str(one.interval), *shift, *([said] if own else []), *cost))
        return rows

    def pair_heading(self) -> tuple[str, ...]:
        what = "limit, %" if math.isnan(self.at) else "stopped, points"
        return ("first", "second", f"difference of {what}", "interval", "p (Holm)", "verdict", "shots needed", "1e9 node-steps")

    def pair_rows(self) -> list[tuple[str, ...]]:
        pairs = self.pairs if len(self.pairs) <= MOST_PAIRS else neighbours(self)
        p = lambda pair: f"{pair.p:.2g}" if pair.p > 1e-4 else "< 0.0001"
        bounds = lambda ends: ", ".join(f"{end:+.1f}" if math.isfinite(end) else "no bound" for end in ends)
        return [
            (
                *(pair.first, pair.second, f"{pair.percent:+.1f}", f"[{bounds(pair.interval)}]", p(pair), pair.verdict),
                *(f"{pair.shots:.0f}" if math.isfinite(pair.shots) else "", f"{1e-9 * pair.node_steps:.3g}"),
            )
            for pair in pairs
        ]

    def __repr__(self) -> str:
        return f"<Comparison of {len(self.shields)} shields: {self.answer()[0]}>"

    def _repr_html_(self) -> str:
        return notebook(self.title, self.answer(), self.heading(), self.rows())

    def text(self) -> str:
        tables = [printed(self.heading(), self.rows()), printed(self.pair_heading(), self.pair_rows())]
        return "\n".join([self.title, "", *self.answer(), "", *tables, *self.notes]) + "\n"

    def write(self, place: Place) -> None:
        """report.html (everything inside), compare.svg, compare.csv, pairs.csv and compare.json."""
        from . import plot

        out = Path(place)
        plot.compare(self, out / "compare.svg")
        unit = "m_per_s" if math.isnan(self.at) else "percent"
        heading = (
            f"shield areal_density_kg_per_m2 value_{unit} low_{unit} high_{unit} network_low_percent network_high_percent".split()
        )
        own = "corrected_m_per_s corrected_low_m_per_s corrected_high_m_per_s shots node_steps".split()
        no = (math.nan,) * 2
        rows = [
            (
                *(one.name, one.areal_density, one.value, *one.interval, *(one.shift.interval if one.shift else no)),
                *((one.corrected.value, *one.corrected.interval) if one.corrected else (math.nan, *no)),
                *(one.shots, one.node_steps),
            )
            for one in self.shields
        ]
        written(out / "compare.csv", csv_of([*heading, *own], [[filled(one) for one in row] for row in rows]))
        pairs = [
            (
                pair.first,
                pair.second,
                pair.percent,
                *pair.interval,
                pair.p,
                pair.verdict,
                pair.differs,
                pair.shots,
                pair.node_steps,
            )
            for pair in self.pairs
        ]
        heading = (
            "first second difference_percent low_percent high_percent p_holm verdict differs shots_needed node_steps".split()
        )
        written(out / "pairs.csv", csv_of(heading, [[filled(one) for one in row] for row in pairs]))
        results.save(self, out / "compare.json")
        page = Page(self.title)
        page.answer(self.answer())
        page.figure(out / "compare.svg", "")
        page.table(self.heading(), self.rows())
        page.section("Pairs")
        page.table(self.pair_heading(), self.pair_rows(), (1, 5))
        page.fold("What was shot at, how, and what to know of it")
        for note in self.notes:
            page.text(note)
        for one in self.shields:
            page.heading(one.name)
            for note in dict.fromkeys([*([one.corrected.words] if one.corrected else []), one.against, *one.notes]):
                page.text(note)
        written(out / "report.html", page.html())


def neighbours(found: Comparison) -> list[Pair]:
    """Pairs that are next to each other in the ranking."""
    by = {(pair.first, pair.second): pair for pair in found.pairs}
    names = [one.name for one in found.shields]
    return [by[pair] for pair in itertools.pairwise(names) if pair in by]


def difference(*terms: tuple[float, float, float]) -> tuple[float, float, float]:
    """Sum of independent estimates and its interval, from value, lower and upper end of each (MOVER)."""
    value = sum(term[0] for term in terms)
    below, above = (math.sqrt(sum((term[0] - term[k]) ** 2 for term in terms)) for k in (1, 2))
    return value, value - below, value + above


def minus(term: tuple[float, float, float]) -> tuple[float, float, float]:
    return -term[0], -term[2], -term[1]


def holm(p: Sequence[float]) -> list[float]:
    """p corrected for their number."""
    order, most, found = numpy.argsort(p), 0.0, [0.0] * len(p)
    for rank, k in enumerate(order):
        most = max(most, min(1.0, (len(p) - rank) * p[k]))
        found[k] = most
    return found


def logs(value: float, low: float, high: float) -> tuple[float, float, float]:
    log = lambda x: math.log(x) if 0.0 < x < math.inf else math.copysign(math.inf, x)
    return log(value), log(low), log(high)


def of_limits(ranked: Sequence[Shield], confidence: float, own: OwnTests | None) -> list[Pair]:
    """Every pair of shields that have a limit."""
    pairs: list[Pair] = []
    both = list(itertools.combinations([one for one in ranked if math.isfinite(one.value)], 2))
    for first, second in both:
        ends = logs(first.value, *first.interval), minus(logs(second.value, *second.interval))
        value, low, high = difference(*ends)
        shots = min(first.shots, second.shots)
        degrees = max(2 * shots - 4, 1)
        quantile = float(scipy.special.stdtrit(degrees, 0.5 + 0.5 * confidence))
        p = 2.0 * float(scipy.special.stdtr(degrees, -quantile * abs(value) / (value - low))) if value > low else 1.0
        moved = [one.shift for one in (first, second)]
        verdict, beyond = "", True
        if all(moved):
            terms = [logs(*(1.0 + 0.01 * part for part in (one.percent, *one.interval))) for one in moved if one]
            beyond = difference(*ends, terms[0], minus(terms[1]))[1] > 0.0
            verdict = "" if beyond else "not beyond the shift of the network"
        if own and all(one.corrected and math.isfinite(one.corrected.value) for one in (first, second)):
            half = math.sqrt(2.0) * own.pool.half(0.0, own.confidence) * math.sqrt(own.pool.tests / (own.pool.tests + 1.0))
            real = difference((value, low, high), (0.0, -half, half))[1] > 0.0
            verdict += f"{'; ' if verdict else ''}{'' if real else 'not '}beyond the scatter of own tests"
        percent = [100.0 * math.expm1(one) for one in (value, low, high)]
        # As if none of the others differed.
        strictest = float(
            scipy.special.ndtri(1.0 - 0.5 * (1.0 - confidence) / len(both)) / scipy.special.ndtri(0.5 + 0.5 * confidence)
        )
        needed = shots * (strictest * (value - low) / value) ** 2 if value > 0.0 else math.nan
        cost = first.node_steps + second.node_steps
        pairs.append(Pair(first.name, second.name, percent[0], limit.Interval(*percent[1:]), p, verdict, beyond, needed, cost))
    return pairs


def of_shares(ranked: Sequence[Shield], through: Mapping[str, Sequence[bool | None]], confidence: float) -> list[Pair]:
    """Every pair of shields by their shots at one velocity."""
    pairs = []
    for first, second in itertools.combinations(ranked, 2):
        known = [(a, b) for a, b in zip(through[first.name], through[second.name]) if a is not None and b is not None]
        better, worse = sum(b and not a for a, b in known), sum(a and not b for a, b in known)
        p = float(scipy.stats.binomtest(better, better + worse, 0.5).pvalue) if better + worse else 1.0
        n = max(len(known), 1)
        # Interval of Bonett and Price (2012) for paired shares.
        one, other = (better + 1) / (n + 2), (worse + 1) / (n + 2)
        half = float(scipy.special.ndtri(0.5 + 0.5 * confidence)) * math.sqrt((one + other - (one - other) ** 2) / (n + 2))
        ends = limit.Interval(*(100.0 * numpy.clip([one - other - half, one - other + half], -1.0, 1.0)).tolist())
        cost = first.node_steps + second.node_steps
        percent = 100.0 * (better - worse) / n
        pairs.append(Pair(first.name, second.name, percent, ends, p, "", True, math.nan, cost))
    return pairs


def decided(pairs: Sequence[Pair], confidence: float) -> tuple[Pair, ...]:
    """Pairs with corrected p and verdicts; of those that may differ."""
    found = []
    for pair, p in zip(pairs, holm([pair.p for pair in pairs])):
        differs = p < 1.0 - confidence and pair.differs
        said = "differs" if differs else "not distinguished" if p >= 1.0 - confidence else ""
        verdict = "; ".join(filter(None, [said, pair.verdict]))
        found.append(dataclasses.replace(pair, p=p, verdict=verdict, differs=differs, shots=math.nan if differs else pair.shots))
    return tuple(found)


def unlike(scenes: Sequence[Scene]) -> str:
    """What the shields differ in that the model was not seen to rank, in a sentence; empty if there is nothing."""
    kinds = {
        "yarn": lambda scene: tuple(f"{scene[f'yarn.{name}']:.3g}" for name in ("modulus_mean", "critical_stretch")),
        "arrangement of plies": lambda scene: (scene["stack.plies"] > 1, scene["stack.turned"], scene["back.plies"] > 0),
        "support": lambda scene: (scene["attachment.kind"], scene["attachment.hold"]),
        "projectile": lambda scene: (scene["projectile.shape"], f"{scene['projectile.mass']:.3g}"),
    }
    found = [name for name, kind in kinds.items() if len({kind(scene) for scene in scenes}) > 1]
    if not found:
        return ""
    return (
        f"The shields differ in {', '.join(found)}: the model was compared with tests for areal densities of one fabric only "
        "(docs/validation.md), so that this ranking is of the model alone."
    )


def named(scenes: "Sequence[Scene | str] | Mapping[str, Scene]") -> dict[str, Scene]:
    """Scenes by their names. Raises ValueError for one without, or fewer than two."""
    if isinstance(scenes, Mapping):
        found = dict(scenes)
    else:
        found = {}
        for number, one in enumerate(scenes, 1):
            name = titled(one).removesuffix(".toml") if isinstance(one, str) else f"shield {number}"
            name = shown(one).removesuffix(".toml") if name in found and isinstance(one, str) else name
            if name in found:
                raise ValueError(f"scenes: {one} is there twice")
            found[name] = scene_of(one)
    if len(found) < 2:
        raise ValueError(f"scenes: two or more are needed, or a table with --batch; there are {len(found)}")
    return found


def compare(
    scenes: "Sequence[Scene | str] | Mapping[str, Scene]",
    *,
    at: float | None = None,
    shots: int = 20,
    seed: int = 1,
    attitude: str | None = None,
    confidence: float = 0.95,
    own_tests: OwnTests | None = None,
    network: bool = True,
    axes: Sequence[Sequence[str]] = (),
    keep: Place | None = None,
    on: Workers = None,
    progress: bool | None = None,
    title: str = "Shields compared",
) -> Comparison:
    """Limits of shields with their intervals, ranked, and which of them differ beyond their error.

    Parameters
    ----------
    scenes : sequence or mapping of Scene or str
        Two shields or more, or shields by their names.
    at : float, optional
        Velocity, m/s: compare the shares stopped there instead of the limits.
    shots : int
        Shots of each shield.
    seed : int
        Seed of yarns and impact points.
    attitude : str, optional
        As for `vary`.
    confidence : float
        Confidence of the intervals, and of all differences together.
    own_tests : OwnTests, optional
        Own firing tests that correct the limits.
    network : bool
        Whether the shift by bars half as long is computed.
    axes : sequence of sequence of str
        Cells of a table of parameters, for the plot.
    keep : path, optional
        Folder of kept results.
    on : int, str, Client or Cluster, optional
        Number of processes, or Dask scheduler; default: a process for each core.
    progress : bool, optional
        Whether to show a progress bar; default: on a terminal.
    title : str
        Title of reports.

    Raises
    ------
    ValueError
        An argument is wrong; the message begins with its name.
    Refused
        The scene cannot be simulated.
    """
    checks.whole("shots", shots, 6 if at is None else 1)
    checks.confident(confidence)
    every = named(scenes)
    flown = {name: vary(scene, shots, seed=seed, attitude=attitude) if attitude else [scene] for name, scene in every.items()}
    through: dict[str, list[bool | None]] = {}
    made, seconds = [], 0.0
    if at is not None:
        checks.numbers("at", [at])
        found = shields.done(shields.shares_of, every, [shots, seed, attitude, at], shots, keep, on, progress)
        for name, (went, cost, took, warnings) in zip(every, found):
            through[name], seconds = went, seconds + took
            made.append(shot_at(name, flown[name], at, went, cost, [Note(**one) for one in warnings], confidence))
    else:
        tested = shields.limits(
            every,
            shots=shots,
            seed=seed,
            attitude=attitude,
            confidence=confidence,
            shifted=network,
            folder=keep,
            on=on,
            progress=progress,
        )
        made = [with_limit(name, flown[name], one, own_tests) for name, one in zip(every, tested)]
        seconds = sum(one.seconds for one in tested)
    ranked = tuple(sorted(made, key=lambda one: -one.value if math.isfinite(one.value) else math.inf))
    pairs = of_limits(ranked, confidence, own_tests) if at is None else of_shares(ranked, through, confidence)
    warned: dict[str, list[tuple[str, Note]]] = {}
    for shield in ranked:
        for caution in shield.cautions:
            warned.setdefault(caution.kind, []).append((shield.name, caution))
    where = lambda its: "" if len(its) == len(ranked) else f"{'; '.join(name for name, _ in its)}: "
    worst = lambda its: max((note for _, note in its), key=lambda note: note.numbers.get("most") or 0.0)
    cautions = [unlike(list(every.values())), *(f"{where(its)}{worst(its)}" for its in warned.values())]
    notes = [
        f"Shot k of each shield has the samples of seed {seed} and number k. Cost of a pair: node-steps of both shields; now "
        f"computed: {seconds:.0f} s of a processor.",
        "Shots needed: of each shield, if the difference is as found and its interval narrows with the root of the shots.",
        f"With own tests ({own_tests.title}): the computed limit times one factor; all else is of the model alone."
        if own_tests
        else "",
        CAVEAT,
    ]
    said = tuple(filter(None, cautions)), tuple(filter(None, notes))
    rows = tuple(tuple(map(str, one)) for one in axes)
    return Comparison(title, math.nan if at is None else at, confidence, ranked, decided(pairs, confidence), rows, *said)


def coded(**texts: str) -> list[Note]:
    """Notes by their kinds; none of an empty text."""
    return [Note(text, kind, {}) for kind, text in texts.items() if text]


def with_limit(name: str, scenes: Sequence[Scene], one: shields.Tested, own: OwnTests | None) -> Shield:
    """A shield by its limit."""
    test, fit = one.test, one.test.fit
    value, ends = test.v50, test.interval()
    why = "" if math.isfinite(value) else test.answer()[0]
    corrected = own.corrected(scenes, value, ends.low, ends.high) if own else None
    advice = test.shift.advice() if test.shift else ""
    of_network = f"Bars half as long change the limit. {advice}" if advice else ""
    found = coded(no_limit=why, doubt=test.doubt), test.warnings, coded(network=of_network, attachments=attachments(scenes[0]))
    cautions = tuple(itertools.chain(*found))
    about = test.against, fit.shots, one.node_steps, cautions, (*test.sentences(), *test.cautions)
    return Shield(name, areal_density(scenes[0]), value, ends, why, test.window is not None, test.shift, corrected, *about)


def shot_at(
    name: str,
    scenes: Sequence[Scene],
    at: float,
    went: Sequence[bool | None],
    cost: float,
    warnings: Sequence[Note],
    confidence: float,
) -> Shield:
    """A shield by the share stopped at a velocity."""
    known = [one for one in went if one is not None]
    if not known:
        raise ValueError(f"{name}: no shot at {at:g} m/s has a known end")
    share = scipy.stats.binomtest(len(known) - sum(known), len(known)).proportion_ci(confidence, method="exact")
    value, ends = 100.0 - 100.0 * sum(known) / len(known), limit.Interval(100.0 * share.low, 100.0 * share.high)
    left = f"{len(went) - len(known)} shots without a known end are left out." if len(known) < len(went) else ""
    cautions = (*coded(unknown=left), *warnings, *coded(attachments=attachments(scenes[0])))
    about = model_error(scenes, confidence).sentence(), len(known), cost, cautions, described(scenes[0])
    return Shield(name, areal_density(scenes[0]), value, ends, "", False, None, None, *about)


def of_table(scene: Scene, path: Path) -> tuple[dict[str, Scene], list[list[str]]]:
    """Scenes of a table of parameters by what their rows say, and the axes of the plot."""
    scenes, rows = batch.scenes_of(scene, path), [row for _, row in batch.rows_of(path)]
    names = [", ".join(f"{name.removeprefix('sheet.')} {cell}" for name, cell in row.items() if cell) for row in rows]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ValueError(f"{path}: {twice} is there twice")
    return dict(zip(names, scenes)), [[name, *(part for pair in row.items() for part in pair)] for name, row in zip(names, rows)]


def main(arguments: Sequence[str] | None = None) -> None:
    """The command `fabric compare`."""
    ends = (
        "Exit status: 0; 4 if a shield has no single limit, as slower shots go through while faster ones are stopped; 1 after a "
        "failure; 2 for what is refused."
    )
    parser = options("compare", "Shields side by side: their limits, ranked, and which differ beyond their error.", ends)
    add = parser.add_argument
    add("scenes", nargs="+", metavar="scene", help=f"scene files, or presets: {', '.join(PRESETS)}")
    add("--at", type=positive, metavar="V", help="no limits: the shares that are stopped at this velocity, m/s")
    add("--batch", type=Path, metavar="FILE.csv", help="a shield for each row, of one scene, as `fabric run` has it")
    add("--tests", type=Path, metavar="FOLDER", help="own tests, of `fabric tests`, that correct the limits")
    add("--no-network", action="store_true", help="no limits with bars half as long, which take twice the shots' time")
    add("--shots", type=int, default=20, help="of each shield; default: %(default)s")
    add("--seed", type=int, default=1, help="of yarns and impact points; default: %(default)s")
    add("--attitude", choices=("random",), help="every orientation is equally likely; default: that of the scene")
    add("--confidence", type=float, default=0.95, help="default: %(default)s")
    add("--on", help="number of processes, or the address of a Dask scheduler")
    add(
        "--out",
        type=Path,
        default=Path("compare"),
        help="folder for report.html, compare.svg, .csv and .json, pairs.csv, runs.jsonl; default: %(default)s",
    )
    given = parser.parse_args(arguments)
    with ending(parser, given), folder(given.out):
        given.kept = goes_on(given.out / "shots")
        of_others(given.out, COMPARED)
        apart([*given.scenes, given.batch], [given.out / name for name in (*WRITTEN, "runs.jsonl")])
        own = OwnTests.read(given.tests) if given.tests else None
        if own and given.at is not None:
            raise ValueError("--tests: corrects limits, and goes without --at")
        scenes: Any = given.scenes
        axes: list[list[str]] = []
        title = "Shields compared"
        if given.batch:
            if len(scenes) > 1:
                raise ValueError(f"--batch: takes one scene, whose parameters the rows change; there are {len(scenes)}")
            title = f"Shields of {titled(scenes[0])} compared"
            scenes, axes = of_table(Scene.read(scenes[0]), given.batch)
        found = given.answer = compare(
            scenes,
            at=given.at,
            shots=given.shots,
            seed=given.seed,
            attitude=given.attitude,
            confidence=given.confidence,
            own_tests=own,
            network=not given.no_network,
            axes=axes,
            keep=given.out,
            on=int(given.on) if given.on and given.on.isdigit() else given.on,
            title=title,
        )
        found.write(given.out)
        print(found.text())
        print(f"written to {given.out}: {', '.join(WRITTEN)}, runs.jsonl")
    if any(one.window for one in found.shields):
        parser.exit(window.STATUS)
