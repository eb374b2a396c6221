"""A family of shields by one's own firing tests: how far the model is off for them, and what that says of another shield.

Method: e_k = ln(measured/computed) of each shield. e_k = b + s z_k + errors of test and computation, which are known: one-way
random effects, s by DerSimonian and Laird, b with the error q of Hartung and Knapp. The limit of a new shield is computed x
exp(b); its interval has Student's t of n - 1 degrees of freedom and the variance (n + 1) q² + c². With tests of equal error
(n + 1) q² is (1 + 1/n) times the variance of the e_k; c is the error of its own computation.
The errors of the tests are not subtracted from that variance: with s² + q² for n q² + q² the interval holds 84 to 94 % of new
shields where scatter and errors are alike (`python -m evidence own_tests`).
Trend: the weighted slope of e over ln of areal density, computed limit and mass, by Student's test at TREND each; with one,
nothing is offered beyond the tests. Leave-one-out: the measured limit of each shield against the interval of the others.
Family: a scene that `model_error` would take as compared with these tests, of about the same spacing and with plies lumped or
separate as theirs.
Limits: the tests are taken as a sample of the family; nothing is fitted in the model.
Reference: R. DerSimonian, N. Laird, Controlled Clinical Trials 7 (1986) 177; J. Hartung, G. Knapp, Statist. Med. 20 (2001) 3875;
J. P. T. Higgins, S. G. Thompson, D. J. Spiegelhalter, J. R. Statist. Soc. A 172 (2009) 137.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy
import scipy  # Its parts are loaded where they are used.

from . import limit, results
from ._kernel import Scene
from .compared import Series, ahead, merged
from .ensembles import BUILD
from .files import Place, csv_of, written
from .page import Page, notebook, printed
from .record import record
from .textile import areal_density, from_edge, sides, spacings

FILE, TREND = "own_tests.json", 0.05
"""File of own tests in their folder; level of the tests of a trend."""
WRITTEN = "report.html", "own_tests.svg", "own_tests.csv", FILE


class Measured(NamedTuple):
    name: str
    value: float  # V50, m/s
    error: float  # its standard error, of ln v


@record
class Tested:
    """One shield that was shot at."""

    name: Annotated[str, "name"]
    measured: Annotated[float, "V50, m/s"]
    measured_error: Annotated[float, "standard error of ln v"]
    computed: Annotated[float, "m/s"]
    computed_error: Annotated[float, "standard error of ln v"]
    areal_density: Annotated[float, "kg/m²"]
    mass: Annotated[float, "of the projectile, kg"]

    def e(self) -> float:
        return math.log(self.measured / self.computed)


@record
class Left:
    """One shield against the interval that the others give."""

    name: Annotated[str, "name"]
    percent: Annotated[float, "measured over predicted"]
    low: Annotated[float, "m/s"]
    high: Annotated[float, "m/s"]
    inside: Annotated[bool, "whether the measured limit lies within"]


@record
class Corrected:
    """Limit of a shield as own tests correct it, m/s; NaN where they do not hold."""

    value: Annotated[float, "limit, m/s; NaN where the tests do not hold"]
    interval: Annotated[limit.Interval, "m/s"]
    words: Annotated[str, "a sentence of it"]


@record
class Pooled:
    """Mean of some e, its error q, and the scatter s among shields."""

    b: Annotated[float, "mean of ln(measured/computed)"]
    q: Annotated[float, "standard error of b"]
    s: Annotated[float, "scatter among shields"]
    tests: Annotated[int, "number of shields"]

    def half(self, own: float = 0.0, confidence: float = 0.95) -> float:
        """Half of the interval of ln(measured/computed) of another shield, whose computed limit has this standard error."""
        t = float(scipy.special.stdtrit(self.tests - 1, 0.5 + 0.5 * confidence))
        return t * math.sqrt((self.tests + 1) * self.q**2 + own**2)


def pooled(e: Sequence[float], errors: Sequence[float]) -> Pooled:
    """One-way random effects of two values or more, with the standard error of each."""
    values, v, n = numpy.asarray(e, float), numpy.square(errors), len(e)
    # An error that is not known counts as scatter.
    w = 1.0 / v if (v > 0.0).all() else numpy.ones(n)
    q = float(w @ (values - w @ values / w.sum()) ** 2)
    known = n - 1 if (v > 0.0).all() else float((v * (1.0 - w / w.sum())).sum())
    scatter = max(0.0, (q - known) / float(w.sum() - w @ w / w.sum()))
    w = 1.0 / (scatter + v) if (scatter + v > 0.0).all() else numpy.ones(n)
    b = float(w @ values / w.sum())
    return Pooled(b, math.sqrt(float(w @ (values - b) ** 2) / ((n - 1) * float(w.sum()))), math.sqrt(scatter), n)


def pool_of(tests: Sequence[Tested]) -> Pooled:
    return pooled([one.e() for one in tests], [math.hypot(one.measured_error, one.computed_error) for one in tests])


def trends(tests: Sequence[Tested]) -> list[str]:
    """Quantities over which e has a trend, by a regression with the weights of the pool."""
    found, pool = [], pool_of(tests)
    variances = numpy.array([pool.s**2 + one.measured_error**2 + one.computed_error**2 for one in tests])
    w = 1.0 / variances if (variances > 0.0).all() else numpy.ones(len(tests))
    e = numpy.array([one.e() for one in tests]) - pool.b
    for name, values in (
        ("areal density", [one.areal_density for one in tests]),
        ("velocity", [one.computed for one in tests]),
        ("mass", [one.mass for one in tests]),
    ):
        if len(tests) > 2 and max(values) > 1.01 * min(values):
            x = numpy.log(values) - numpy.average(numpy.log(values), weights=w)
            spread = float(w @ x**2)
            slope = float(w @ (x * e)) / spread
            left = float(w @ (e - slope * x) ** 2) / (len(tests) - 2)
            p = 2.0 * float(scipy.special.stdtr(len(tests) - 2, -abs(slope) * math.sqrt(spread / left))) if left > 0.0 else 0.0
            found += [f"{name} (p {p:.1g})"] if p < TREND else []
    return found


@record
class OwnTests:
    """Own tests against the model. `corrected` is what they say of another shield; `write` reports them."""

    title: Annotated[str, "title of reports"]
    tests: Annotated[tuple[Tested, ...], "each shield"]
    pool: Annotated[Pooled, "mean and scatter of ln(measured/computed)"]
    confidence: Annotated[float, "of the intervals"]
    trends: Annotated[tuple[str, ...], "quantities over which the ratio has a trend"]
    left_out: Annotated[tuple[Left, ...], "none of two tests"]
    about: Annotated[dict[str, Any], "ranges of the tests, as comparisons.toml has them"]
    network: Annotated[dict[str, Any], "spacings, m, and whether plies are separate"]
    build: Annotated[str, "SHA-256 of the kernel's library"]
    said: Annotated[tuple[str, ...], "shields that are left out, and doubts of computed limits"] = ()

    @classmethod
    def read(cls, path: Place) -> "OwnTests":
        """Own tests of a folder that `fabric tests` has written."""
        path = Path(path)
        if not (path / FILE).exists():
            raise ValueError(f"--tests: {path} has no {FILE}: fabric tests FILE.csv --out {path} writes it")
        return results.read(cls, path / FILE)

    def factor(self) -> str:
        half = self.pool.half(0.0, self.confidence)
        low, high = math.exp(self.pool.b - half), math.exp(self.pool.b + half)
        return f"{math.exp(self.pool.b):.3f} [{low:.3f}, {high:.3f}]"

    def lacks(self, scene: Scene) -> list[tuple[str, str]]:
        """Why a scene is none of the family of the tests: what they have, and what it has; nothing if it is."""
        found = Series(self.title, (), self.about).lacks(scene, exact=bool(self.trends))
        least, most = self.network["spacing_mm"]
        if not all(least / 1.1 <= 1e3 * h <= 1.1 * most for h in spacings(scene)):
            found.append((f"nodes {least:.3g} to {most:.3g} mm apart", f"{1e3 * max(spacings(scene)):.3g} mm apart"))
        if plies(scene) not in self.network["plies"]:
            found.append((" or ".join(self.network["plies"]), plies(scene)))
        return found

    def corrected(self, scenes: Sequence[Scene], value: float, low: float, high: float) -> Corrected:
        """A computed limit with its interval, m/s, as the tests correct it; scenes: all that were shot at."""
        count = len(self.tests)
        if any(self.lacks(scene) for scene in scenes):
            return Corrected(math.nan, limit.Interval(-math.inf, math.inf), self.of_velocities(scenes))
        own = error_of(low, high, self.confidence)
        if not math.isfinite(value) or not math.isfinite(own):
            words = f"Own tests ({count}): measured over computed is {self.factor()}; here no limit has an interval to multiply."
            return Corrected(math.nan, limit.Interval(-math.inf, math.inf), words)
        half, middle = self.pool.half(own, self.confidence), value * math.exp(self.pool.b)
        interval = limit.Interval(middle * math.exp(-half), middle * math.exp(half))
        words = (
            f"With {count} own tests: {middle:.1f} m/s, {100 * self.confidence:g} % interval {interval} m/s, the computed limit "
            f"x {math.exp(self.pool.b):.3f}.{self.badly()}"
        )
        return Corrected(middle, interval, words)

    def badly(self) -> str:
        """That one factor does not describe the tests, for a sentence that multiplies by it; empty if it does."""
        return (
            f" But their ratio has a trend with {' and '.join(self.trends)}, which one factor leaves out." if self.trends else ""
        )

    def of_velocities(self, scenes: Sequence[Scene]) -> str:
        """What the tests say of velocities at which a share goes through, in a sentence."""
        missing = [lack for scene in scenes if (lack := self.lacks(scene))]
        if missing:
            return f"Own tests ({len(self.tests)}) do not hold here: they have {merged(missing)}."
        return (
            f"With {len(self.tests)} own tests: each share belongs to the velocity given x {self.factor()} "
            f"({100 * self.confidence:g} %); the velocities themselves are of the model alone."
        )

    def answer(self) -> list[str]:
        count, e = len(self.tests), [100 * math.expm1(one.e()) for one in self.tests]
        lines = [
            f"Measured over computed: {self.factor()} ({100 * self.confidence:g} % for another shield of this family), from "
            f"{count} own tests, {min(e):+.0f} to {max(e):+.0f} %."
        ]
        percent, side = 100.0 * math.expm1(-self.pool.b), "high, which is unsafe" if self.pool.b < 0.0 else "low, which is safe"
        lines[0] += f" On average the model's limits are {abs(percent):.0f} % too {side}." if abs(percent) >= 0.5 else ""
        inside = sum(one.inside for one in self.left_out)
        if self.left_out:
            misses = ", ".join(f"{one.name} ({one.percent:+.0f} %)" for one in self.left_out if not one.inside)
            lines.append(
                f"Leave one out: {inside} of {count} lie inside the interval that the others give"
                f"{f'; outside: {misses}' if misses else ''}."
            )
        else:
            lines.append("Leave one out needs three tests: two say little.")
        if self.trends:
            lines.append(
                f"Trend of the ratio with {' and '.join(self.trends)}: one factor describes these tests badly, and none is "
                "offered beyond them."
            )
        elif count > 2:
            lines.append("No trend of the ratio with areal density, velocity or mass was found at 5 %.")
        if sum(one.computed_error > one.measured_error for one in self.tests) > 0.5 * count:
            lines.append("The computed limits are less certain than the measured ones: more --shots narrow the interval.")
        return [*lines, *self.said]

    def heading(self) -> tuple[str, ...]:
        return ("shield", "kg/m²", "measured, m/s", "computed, m/s", "ratio", "of the others, m/s", "off, %", "inside")

    def rows(self) -> list[tuple[str, ...]]:
        """Each shield with its ratio, and what the others say of it."""
        rows: list[tuple[str, ...]] = []
        z, left = float(scipy.special.ndtri(0.5 + 0.5 * self.confidence)), {one.name: one for one in self.left_out}
        off = lambda value, error: f"{value:.0f}" + (f" ± {z * error * value:.0f}" if error else "")
        for one in self.tests:
            its = left.get(one.name)
            said = (
                (f"[{its.low:.0f}, {its.high:.0f}]", f"{its.percent:+.0f}", "yes" if its.inside else "no") if its else ("",) * 3
            )
            limits = off(one.measured, one.measured_error), off(one.computed, one.computed_error)
            rows.append((one.name, f"{one.areal_density:.3g}", *limits, f"{math.exp(one.e()):.3f}", *said))
        return rows

    def notes(self) -> list[str]:
        support, shape = (", ".join(self.about[name]).replace("_", " ") for name in ("support", "shape"))
        ends = lambda name: " to ".join(dict.fromkeys(f"{end:.3g}" for end in self.about[name]))
        density = " to ".join(dict.fromkeys(f"{end['areal_density_kg_per_m2']:.3g}" for end in self.about["case"]))
        return [
            f"Family: {density} kg/m², {ends('width_mm')} mm wide, {support} held; a {shape} of {ends('mass_g')} g; yarn of "
            f"{ends('modulus_gpa')} GPa that fails at {ends('failure_strain_percent')} %; {' or '.join(self.network['plies'])}, "
            f"nodes {ends_of(self.network['spacing_mm'])} mm apart.",
            f"Scatter among shields, without the errors of test and computation: {100 * self.pool.s:.1f} %.",
            "The factor multiplies a computed limit; nothing in the model is changed. It holds for limits computed with the "
            "same network and options as those of the tests.",
        ]

    def __repr__(self) -> str:
        return f"<OwnTests {self.title!r}: {self.answer()[0]}>"

    def _repr_html_(self) -> str:
        return notebook(self.title, self.answer(), self.heading(), self.rows())

    def text(self) -> str:
        return "\n".join([self.title, "", *self.answer(), "", printed(self.heading(), self.rows()), *self.notes()]) + "\n"

    def write(self, place: Place) -> None:
        """report.html (everything inside), own_tests.svg, .csv and .json."""
        from . import plot

        out = Path(place)
        plot.own_tests(self, out / "own_tests.svg")
        heading = ("shield", "measured_m_per_s", "measured_log_error", "computed_m_per_s", "computed_log_error")
        rows = [(*vars(one).values(), math.exp(one.e())) for one in self.tests]
        written(out / "own_tests.csv", csv_of((*heading, "areal_density_kg_per_m2", "mass_kg", "ratio"), rows))
        results.save(self, out / FILE)
        page = Page(self.title)
        page.answer(self.answer())
        page.figure(out / "own_tests.svg", "")
        page.table(self.heading(), self.rows())
        for note in self.notes():
            page.text(note)
        written(out / "report.html", page.html())


def ends_of(values: Sequence[float]) -> str:
    return " to ".join(dict.fromkeys(f"{value:.3g}" for value in values))


def plies(scene: Scene) -> str:
    return "one ply or lumped plies" if scene["stack.plies"] == 1 else "separate plies"


def error_of(low: float, high: float, confidence: float = 0.95) -> float:
    """Standard error of ln v of an interval, m/s."""
    if not 0.0 < low <= high < math.inf:
        return math.inf
    return 0.5 * math.log(high / low) / float(scipy.special.ndtri(0.5 + 0.5 * confidence))


def family(scenes: Sequence[Scene]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Ranges of some scenes as comparisons.toml has those of a series, and their networks."""
    ends = lambda values: [min(values), max(values)]
    kinds = lambda name: sorted({str(scene[name]) for scene in scenes})
    densities = ends([areal_density(scene) for scene in scenes])
    straight = [
        ahead(scene, part)
        for scene in scenes
        for part in ("sheet.orientation", *(["projectile.orientation"] if scene["projectile.shape"] != "sphere" else []))
    ]
    about = {
        "tolerance": 0.01,
        "case": [{"areal_density_kg_per_m2": end} for end in densities],
        "mass_g": ends([1e3 * scene["projectile.mass"] for scene in scenes]),
        "support": kinds("attachment.kind"),
        "shape": kinds("projectile.shape"),
        "width_mm": ends([1e3 * side for scene in scenes for side in sides(scene)]),
        "modulus_gpa": ends([1e-9 * scene["yarn.modulus_mean"] for scene in scenes]),
        "failure_strain_percent": ends([100 * (scene["yarn.critical_stretch"] - 1) for scene in scenes]),
        "radius_mm": ends([1e3 * scene["sheet.radius"] for scene in scenes]),
        "degrees": ends(straight),
        "thick": sorted({bool(scene["sheet.thickness"]) for scene in scenes}),
        # A shot passes within half a mesh of where its scene says.
        "edge_mm": 1e3 * min(from_edge(scene) - 0.5 * max(spacings(scene)) for scene in scenes),
    }
    network = {
        "spacing_mm": ends([1e3 * h for scene in scenes for h in spacings(scene)]),
        "plies": sorted({plies(scene) for scene in scenes}),
    }
    return about, network


def judged(
    measured: Sequence[Measured],
    scenes: Sequence[Scene],
    computed: Sequence[tuple[float, float]],
    title: str = "Own tests",
    confidence: float = 0.95,
) -> OwnTests:
    """Own tests of measured limits and computed ones, (m/s, standard error of ln v)."""
    tests = tuple(
        Tested(one.name, one.value, one.error, *its, areal_density(scene), scene["projectile.mass"])
        for one, scene, its in zip(measured, scenes, computed)
    )
    if all(scenes[0].replace({"seed": one["seed"]}) == one for one in scenes[1:]):
        raise ValueError("tests: all are of one shield, so that they have no range: give tests of different shields")
    left = []
    for one in tests if len(tests) > 2 else ():
        others = pool_of([other for other in tests if other is not one])
        half, middle = others.half(one.computed_error, confidence), one.computed * math.exp(others.b)
        inside = abs(math.log(one.measured / middle)) <= half
        ends = middle * math.exp(-half), middle * math.exp(half)
        left.append(Left(one.name, 100 * (one.measured / middle - 1), *ends, inside))
    return OwnTests(title, tests, pool_of(tests), confidence, tuple(trends(tests)), tuple(left), *family(scenes), BUILD)
