"""How far the model may be off: from published tests that it was compared with, comparisons.toml, to a factor for a new one.

Method: e = ln(computed/measured) of each case. The e of one series of tests are not independent, so a series counts once: m_k is
the mean of e² in it, over all cases with the model's network, the first, and s² the mean of the m_k of the K series. A new
comparison lies within exp(± t s), with Student's t of K degrees of freedom. The spread is about no error, and no computed number
is corrected.
Where the e of a series are one number and have mean 0 this holds the new one with exactly the confidence; where they differ
within a series, or have another mean, more often (tests/python/test_model_error.py).
Limits: one series of limits was found, so that t is 12.7 for 95 %. The e contain the errors of the tests and of the computed
limits.
What counts as compared is a choice: a flat sheet with an areal density within that of the series, its support and shape, a
fragment from half to 1.1 times its mass, its widths, hit no nearer to an edge than half of the least, moduli and failure strains
within a third, and flight and axis within 5 degrees of the normal. Of many shots each must be so; nothing is said of the rest.
"""

import math
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy

from . import checks
from ._kernel import Scene
from .oneply import beside_reference, reference
from .record import record
from .runs import scene_of
from .textile import areal_density, from_edge, in_axes, sides

LIGHTEST, HEAVIEST = 0.5, 1.1
"""Masses of a fragment, over that of a series, that count as compared."""
STRAIGHT = 5.0
"""Degrees: angle of impact and attitude that count as compared."""
ALIKE = 4.0 / 3.0
"""Factor within which modulus and failure strain of a yarn count as compared."""


def ends(values: Any) -> tuple[float, float]:
    """Least and most of one number or several."""
    return float(numpy.min(values)), float(numpy.max(values))


def about_as(numbers: Any) -> tuple[float, float]:
    return ends(numbers)[0] / ALIKE, ends(numbers)[1] * ALIKE


def ahead(scene: Scene, orientation: str) -> float:
    """Degrees between the flight and the axis z, either way, of the sheet or the projectile."""
    along = numpy.abs(in_axes(scene[orientation], scene["projectile.velocity"]))
    return math.degrees(math.atan2(math.hypot(along[0], along[1]), along[2]))


class Case(NamedTuple):
    name: str
    measured: float
    computed: tuple[float, ...]  # with each network; the first is the model's

    def errors(self) -> list[float]:
        return [math.log(self.computed[0] / self.measured)]


class Series(NamedTuple):
    """Tests of one source. `about`: its entries in comparisons.toml."""

    name: str
    cases: tuple[Case, ...]
    about: dict[str, Any]

    def errors(self) -> list[float]:
        return [error for case in self.cases for error in case.errors()]

    def lacks(self, scene: Scene, *, exact: bool = False) -> list[tuple[str, str]]:
        """Why a scene is none of those that were compared: what they have, and what it has instead; nothing if it is. exact: a
        mass beyond those of the series is none, either."""
        found, density = [], areal_density(scene)
        least, most = ends([case["areal_density_kg_per_m2"] for case in self.about["case"]])
        near = 1.0 + self.about.get("tolerance", 1e-9)
        if not least <= density * near <= most * near * near:
            ply = " (one ply)" if scene["sheet.plies"] * scene["stack.plies"] == 1 else ""
            found.append((f"{least:.3g} to {most:.3g} kg/m²", f"{density:.3g} kg/m²{ply}"))
        mass, own = 1e3 * scene["projectile.mass"], ends(self.about["mass_g"])
        lightest, heaviest = (0.999, 1.001) if exact else (LIGHTEST, HEAVIEST)
        if not lightest * own[0] <= mass <= heaviest * own[1]:
            found.append((f"{lightest * own[0]:.3g} to {heaviest * own[1]:.3g} g", f"{mass:.3g} g"))
        if scene["attachment.kind"] not in (supports := numpy.ravel(self.about["support"])):
            found.append(
                (" or ".join(supports).replace("_", " ") + " held", scene["attachment.kind"].replace("_", " ") + " held")
            )
        for (least, most), here, text, unit in (
            (self.about["width_mm"], [1e3 * side for side in sides(scene)], "{} to {}", "mm wide"),
            (about_as(self.about["modulus_gpa"]), [1e-9 * scene["yarn.modulus_mean"]], "a yarn of {} to {}", "GPa"),
            (
                about_as(self.about["failure_strain_percent"]),
                [100 * (scene["yarn.critical_stretch"] - 1)],
                "a yarn that fails at {} to {}",
                "%",
            ),
        ):
            if not all(0.99 * least <= one <= 1.01 * most for one in here):
                has = " x ".join(f"{one:.3g}" for one in dict.fromkeys(here))
                found.append((f"{text.format(f'{least:.3g}', f'{most:.3g}')} {unit}", f"{has} {unit}"))
        curved = ends(self.about.get("radius_mm", 0.0))
        if not 0.99 * curved[0] <= 1e3 * scene["sheet.radius"] <= 1.01 * curved[1]:
            found.append(
                (f"a radius of {curved[0]:.4g} to {curved[1]:.4g} mm", f"one of {1e3 * scene['sheet.radius']:.4g} mm")
                if curved[1]
                else ("a flat sheet", "a curved one")
            )
        elif (
            1e3 * from_edge(scene) < 0.98 * (edge := self.about.get("edge_mm", 0.5 * ends(self.about["width_mm"])[0]))
            and not found
        ):
            found.append((f"{edge:.3g} mm or more from an edge", f"{1e3 * from_edge(scene):.3g} mm from an edge"))
        if bool(scene["sheet.thickness"]) not in self.about.get("thick", [True]):
            cloth = "a surface without thickness", "cloth with a thickness"
            found.append(cloth[::-1] if not scene["sheet.thickness"] else cloth)
        if scene["projectile.shape"] not in (shapes := numpy.ravel(self.about["shape"])):
            return [*found, (f"a {' or '.join(shapes)}".replace("_", " "), f"a {scene['projectile.shape']}".replace("_", " "))]
        straight, askew = ends(self.about.get("degrees", 0.0))
        for name, angle in (
            ("an angle of impact", ahead(scene, "sheet.orientation")),
            ("an attitude", ahead(scene, "projectile.orientation")),
        ):
            if angle > askew + STRAIGHT:
                found.append((f"{name} of at most {askew + STRAIGHT:g} degrees", f"{name} of {angle:.0f} degrees"))
            elif angle < straight - STRAIGHT:
                found.append((f"{name} of at least {straight - STRAIGHT:g} degrees", f"{name} of {angle:.0f} degrees"))
        return found


def compared(kind: str = "limit") -> list[Series]:
    """The series of a kind, "limit" or "strength"."""
    file = tomllib.loads((Path(__file__).parent / "comparisons.toml").read_text("utf-8"))
    return [
        Series(one["name"], tuple(Case(case["name"], case["measured"], tuple(case["computed"])) for case in one["case"]), one)
        for one in file["series"]
        if one["kind"] == kind
    ]


def factor(series: Sequence[Sequence[float]], confidence: float = 0.95) -> float:
    """The factor within which a new comparison lies, from ln(computed/measured) of the cases of each series; infinite without
    any."""
    import scipy.special  # Which workers need not load.

    if not series:
        return math.inf
    squares = [float(numpy.mean(numpy.square(errors))) for errors in series]
    t = float(scipy.special.stdtrit(len(series), 0.5 + 0.5 * confidence))
    with numpy.errstate(over="ignore"):
        return float(numpy.exp(t * math.sqrt(sum(squares) / len(squares))))


def left_out(series: Sequence[Series], confidence: float = 0.95) -> list[tuple[str, str, float, float, bool]]:
    """For each case its series, its name, the error that is largest (computed over measured), the factor that all other cases
    give, and whether the error lies within it."""
    rows = []
    for one in series:
        for case in one.cases:
            others = [[e for other in each.cases if other is not case for e in other.errors()] for each in series]
            found, worst = factor([errors for errors in others if errors], confidence), max(case.errors(), key=abs)
            rows.append((one.name, case.name, math.exp(worst), found, abs(worst) <= math.log(found)))
    return rows


@record
class ModelError:
    """How far a computed limit may be off."""

    factor: Annotated[float, "measured over computed limit, either way; NaN where nothing alike was compared"]
    confidence: Annotated[float, "of the factor"]
    words: Annotated[str, "a sentence of it"]

    def __repr__(self) -> str:
        known = f"a factor of {self.factor:.3g} ({100 * self.confidence:g} %)" if math.isfinite(self.factor) else "unknown"
        return f"<ModelError: {known}; {self.words}>"

    def band(self, low: float, high: float) -> tuple[float, float] | None:
        """Range of a computed limit with its interval, m/s; None where nothing is known."""
        return (low / self.factor, high * self.factor) if math.isfinite(self.factor) else None

    def sentence(self, low: float = math.nan, high: float = math.nan) -> str:
        """One line for a report on a limit whose interval is given, m/s."""
        band = self.band(low, high)
        if band is None or not all(math.isfinite(end) for end in band):
            return f"Of the model against tests: {self.words}"
        return f"Of the model against tests: [{band[0]:.0f}, {band[1]:.0f}] m/s; {self.words}"


def merged(lacks: Sequence[Sequence[tuple[str, str]]]) -> str:
    """What some scenes lack, in words: of each lack the first scene that has it, and how many others do."""
    found: dict[str, list[str]] = {}
    for wanted, here in (one for lack in lacks for one in lack):
        found.setdefault(wanted, []).append(here)
    others = lambda here: f" and in {len(here) - 1} other shots" if len(set(here)) > 1 else ""
    return f"{', '.join(found)}; here: {', '.join(here[0] + others(here) for here in found.values())}"


def straight(scene: Scene) -> bool:
    """Whether flight and body are as those of the reference of one ply: straight on, of about its width and masses."""
    angles = [
        ahead(scene, "sheet.orientation"),
        *([] if scene["projectile.shape"] == "sphere" else [ahead(scene, "projectile.orientation")]),
    ]
    widths = [case["width_mm"] for case in reference()["case"]]
    near = all(0.99 * min(widths) <= 1e3 * side <= 1.01 * max(widths) for side in sides(scene))
    return near and max(angles) <= STRAIGHT and not scene["sheet.radius"]


def model_error(scene: Scene | str | Sequence[Scene | str], confidence: float = 0.95) -> ModelError:
    """How far the ballistic limit of a scene may be off, from the published limits that the model was compared with.

    Parameters
    ----------
    scene : Scene or str, or sequence of them
        Scene, or several, as of `vary`: every one must be alike what was compared.
    confidence : float
        Confidence of the factor.

    Raises
    ------
    ValueError
        An argument is wrong; the message begins with its name.
    Refused
        The scene cannot be simulated.
    """
    checks.confident(confidence)
    scenes = [scene_of(one) for one in ([scene] if isinstance(scene, (Scene, str)) else scene)]
    if not scenes:
        checks.refuse("scene", "a scene, or several", scene)
    every = [(one, [lack for each in scenes if (lack := one.lacks(each))]) for one in compared()]
    near = [one for one, lacks in every if not lacks]
    if not near:
        missing = "; or: ".join(dict.fromkeys(merged(lacks) for _, lacks in every))
        known = beside_reference(scenes[0]) if all(map(straight, scenes)) else ""
        return ModelError(
            math.nan, confidence, f"compared only with: {missing}{f'; {known}' if known else ': so the error is unknown.'}"
        )
    found = factor([one.errors() for one in near], confidence)
    errors = [100 * math.expm1(e) for one in near for e in one.errors()]
    series = (
        f"{len(near)} independent series of tests"
        if len(near) > 1
        else f"one series of tests, which counts once ({near[0].name})"
    )
    words = (
        f"within a factor of {found:.2g} in {100 * confidence:g} %, from {series}, where limits were off by {min(errors):+.0f} "
        f"to {max(errors):+.0f} %."
    )
    return ModelError(found, confidence, words)
