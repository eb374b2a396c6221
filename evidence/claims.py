"""The claims of the paper and what the ensembles say of each. Every verdict is computed by the rule of statistics.py: the 95 %
interval of ours lies inside the range that the claim allows ("agrees"), outside ("does not"), or across its edge ("cannot be
told"). Ranges are fixed here, beside the claim."""

import functools
import math
from typing import NamedTuple

from .paper_runs import ATTACHMENTS, CORNERS, FOUR_SIDES, STOCHASTIC, SYMMETRIC, TWO_SIDES, UNIFORM, WOVEN, number
from .statistics import AGREES, DOES_NOT, UNDECIDED, Estimate, verdict_of_all, verdict_of_any

CLOSE = 1.5  # "Close", "similar": at most this factor apart. The paper's other factors are 2 and 3.
THREEFOLD, TWO_TO_FOUR, TWOFOLD = (2.0, 4.0), (2.0, 4.0), (1.5, 2.5)  # "about three times", "two to four times", "about twofold"
SLIGHTLY = (1.0, 1.2)  # "slightly over-predicts"
FOUR, ONE_OR_TWO = (3.5, 4.5), (0.5, 2.5)  # mean numbers that round to "four" and to "one or two"
MOST = (0.5, 1.0)  # "in most runs"
MORE, LESS, SIMILAR = (1.0, math.inf), (0.0, 1.0), (1 / CLOSE, CLOSE)
LOW, HIGH = (2.5, 5.0, 7.5, 10.0), (80.0, 160.0, 320.0)  # impact energies that count as low and as high, J
ABOUT_LIMIT = (5.0, 7.5, 10.0, 15.0, 20.0)  # about the ballistic limit of sheets held at their corners, J
APART = 10.0  # µs between events that follow one another rather than happen together: the coarse pause between samples
FIXED_TIME = 400e-6  # of the reading at a fixed time, s


class Check(NamedTuple):
    """One quantity that a claim speaks of. name: empty if the claim says what it is."""

    name: str
    ours: Estimate
    allowed: tuple
    digits: int = 2

    def verdict(self):
        return self.ours.verdict(self.allowed)

    def text(self):
        ours = self.ours.text(self.digits)
        return f"{self.name}: {ours}" if self.name else ours


class Claim:
    """A claim with its answer. allows: what it allows, in words; whole: how the checks' verdicts make the claim's."""

    def __init__(self, part, claim, allows, checks, note="", whole=verdict_of_all, verdict=None):
        self.part, self.claim, self.allows, self.checks, self.note = part, claim, allows, checks, note
        self.verdict = verdict or whole([check.verdict() for check in checks])

    def why(self):
        """The sentence behind the verdict, made from the checks."""
        parts, count = [], len(self.checks)
        for verdict, word in ((AGREES, "inside"), (DOES_NOT, "outside"), (UNDECIDED, "across the edge")):
            names = [check.name for check in self.checks if check.verdict() == verdict]
            if names and len(names) == count:
                parts.append(f"all {count} {word}" if count > 1 else word)
            elif names:
                parts.append(f"{len(names)} of {count} {word}" if verdict == AGREES else f"{word}: {', '.join(names)}")
        return "; ".join((parts or ["no points"]) + [self.note] * bool(self.note))

    def row(self):
        return [self.part, self.claim, self.allows, "\n".join(check.text() for check in self.checks), self.verdict, self.why()]


def adder(claims):
    """A function that makes a claim of P3 and adds it."""
    return lambda *words, **more: claims.append(Claim("P3", *words, **more))


HEADING = ["", "claim", "read as", "ours [95 % interval]", "verdict", "why"]


def of_micro(micro):
    """Claims about the micro scale (P1, P2, and Fig. 3 of P3)."""

    def one(part, claim, ours, centre, tolerance, digits):
        check = Check("", ours, (centre - tolerance, centre + tolerance), digits)
        return Claim(part, claim, f"{number(centre)} ± {number(tolerance)}", [check])

    more = Estimate(*(end / micro.aligned_work for end in micro.work))
    return [
        one("P1", "Mean modulus of a yarn, GPa", micro.modulus, 140.21, 0.06, 3),
        one("P1", "Standard deviation of the modulus, GPa", micro.modulus_sd, 2.04, 0.05, 3),
        one("P2", "Slope of λ over E, 1/GPa", micro.slope, 7.91, 0.25, 3),
        one("P2", "λ at E = 0", micro.intercept, -878.46, 35.0, 1),
        one("P2", "Standard deviation of λ about the line", micro.residual, 8.35, 0.5, 3),
        one("P2", "Mean λ", micro.rate, 230.6, 1.0, 2),
        Claim(
            "P3",
            "An aligned yarn breaks suddenly, misaligned ones do not (Fig. 3)",
            "stress kept just beyond U_c: aligned 0, misaligned more than half",
            [Check("aligned", Estimate.exact(micro.aligned_left), (0.0, 0.0), 3), Check("misaligned", micro.left, (0.5, 1.0), 3)],
        ),
        Claim(
            "P3",
            "A misaligned yarn absorbs more (Fig. 3)",
            "ratio above 1",
            [Check("work to rupture, misaligned/aligned", more, MORE, 3)],
            "the law with the paper's fitted λ absorbs 86.6 MJ/m³, between the two",
        ),
    ]


def attachments_ratio(runs, above, below, energy, value, allowed):
    """Ratio of one quantity between two attachments, stochastic yarn."""
    ours = Estimate.ratio(*(runs.values(kind, STOCHASTIC, energy, value) for kind in (above, below)))
    return Check(f"{above}/{below} at {number(energy)} J", ours, allowed)


def yarns_ratio(runs, kind, above, below, energy, value, allowed, digits=2):
    """Ratio of one quantity between two yarns."""
    ours = Estimate.ratio(*(runs.values(kind, yarn, energy, value) for yarn in (above, below)))
    return Check(f"{kind}, {number(energy)} J", ours, allowed, digits)


def of_attachments(runs):
    """Claims about the attachments (P3, Figs 14 to 17)."""
    ratios = lambda pairs, energies, value, allowed: [
        attachments_ratio(runs, *pair, energy, value, allowed) for energy in energies for pair in pairs
    ]
    named = lambda name, kind, energy, value, allowed: Check(
        f"{name}, {number(energy)} J", runs.mean_of(kind, STOCHASTIC, energy, value), allowed
    )
    pairs = [(CORNERS, TWO_SIDES), (CORNERS, FOUR_SIDES), (TWO_SIDES, FOUR_SIDES)]
    most, least = pairs[:2], [(TWO_SIDES, CORNERS), (TWO_SIDES, FOUR_SIDES)]
    low, high = runs.energies_among(LOW), runs.energies_among(HIGH)
    slow, fast = runs.history_energies
    perforated = runs.uncapped(*((kind, STOCHASTIC) for kind in ATTACHMENTS))
    readings = [("read when detached", lambda run: run.at_detached()), ("read when arrested or gone", lambda run: run.absorbed)]
    everywhere = "at every energy at which nothing is arrested"
    add = adder(claims := [])
    for reading, value in readings:
        add(
            f"All three attachments absorb about the same at low energy ({reading})",
            f"ratios within a factor {CLOSE}, up to 10 J",
            ratios(pairs, low, value, SIMILAR),
            "where all runs are arrested the ratio is 1 by itself",
        )
    for reading, value in readings:
        add(f"Corners absorb most at the high end ({reading})", "ratios above 1, from 80 J", ratios(most, high, value, MORE))
    for reading, value in readings:
        add(f"Two sides absorb least ({reading})", f"ratios below 1, {everywhere}", ratios(least, perforated, value, LESS))
    kinetic = lambda run: run.peak_kinetic
    rest = ratios(most, [energy for energy in high if energy != fast], kinetic, THREEFOLD)
    add(
        "Kinetic energy of the fabric at corners is about three times that of the others (Figs 15-17)",
        f"ratios of the largest values in {number(THREEFOLD[0])} to {number(THREEFOLD[1])}, at {number(fast)} J",
        ratios(most, [fast], kinetic, THREEFOLD),
        "elsewhere " + ", ".join(check.text() for check in rest) if rest else "",
    )
    add(
        "Strain energy is similar for all attachments (Figs 15-17)",
        f"ratios of the largest values within a factor {CLOSE}, at {number(slow)} and {number(fast)} J",
        ratios(pairs, runs.history_energies, lambda run: run.peak_strain, SIMILAR),
    )
    shares = [
        ("strain/kinetic", lambda run: run.peak_strain / run.peak_kinetic, "largest strain energy"),
        (
            "strain and dissipated/kinetic",
            lambda run: run.largest_yarn_work() / run.peak_kinetic,
            "largest sum of strain energy and energy dissipated by rupture",
        ),
    ]
    for kind, figure in ((FOUR_SIDES, 17), (TWO_SIDES, 16)):
        for name, value, what in shares:
            checks = [named(name, kind, energy, value, MORE) for energy in runs.uncapped((kind, STOCHASTIC))]
            add(
                f"{kind.capitalize()}: most energy goes into strain (Fig. {figure}; {what})",
                f"{what} over largest kinetic energy of the fabric above 1, {everywhere}",
                checks,
            )
    # "Two sides give more kinetic energy than four": whose, the wording leaves open.
    both = runs.uncapped((TWO_SIDES, STOCHASTIC), (FOUR_SIDES, STOCHASTIC))
    for whose, what, value in (
        ("the fabric's", "largest kinetic energy of the fabric", kinetic),
        (
            "the fabric's, as a part of what it absorbs",
            "largest kinetic energy of the fabric over the energy absorbed at the end",
            lambda run: run.peak_kinetic / run.absorbed,
        ),
        ("what the projectile keeps", "kinetic energy of the projectile at the end", lambda run: run.left()),
    ):
        add(
            f"Two sides give more kinetic energy than four ({whose})",
            f"{what}: ratio above 1, {everywhere}",
            ratios([(TWO_SIDES, FOUR_SIDES)], both, value, MORE),
        )
    # Where and in which order the sheets fail.
    at = runs.history_energies
    add(
        "Sheets held at corners fail at the attachments",
        "more than half of the failed segments within 5 yarns of a washer",
        [named("share at the washers", CORNERS, e, lambda run: run.share_at_attachments(), (0.5, 1.0)) for e in at],
    )
    torn = ", ".join(named("corners torn", CORNERS, e, lambda run: len(run.torn), (0, 4)).text() for e in at)
    for which, later, claim in (
        ("first and last", -1, "Corners do not fail all at once"),
        ("first and second", 1, "Corners fail one by one"),
    ):
        gap = lambda run: 1e6 * (run.torn[later] - run.torn[0]) if len(run.torn) > 1 else math.nan
        add(
            claim,
            f"{which} corner that tears off more than {number(APART)} µs apart",
            [named("µs apart", CORNERS, e, gap, (APART, math.inf)) for e in at],
            torn,
        )
    for kind in (FOUR_SIDES, TWO_SIDES):
        text = lambda e, value: runs.mean_of(kind, STOCHASTIC, e, value).text(2)
        note = ", ".join(
            f"at {number(e)} J {text(e, lambda run: run.share_at_centre())} at the centre and "
            f"{text(e, lambda run: run.share_at_attachments())} at the attachments"
            for e in at
        )
        if kind == TWO_SIDES:
            note += "; the tear runs through the middle from one free edge to the other"
        more = lambda run: run.share_at_centre() - run.share_at_attachments()
        add(
            f"Clamped sheets fail at the centre, {kind}",
            "a larger share of the failed segments within 2 radii of the projectile from the centre than within 5 yarns of "
            "the clamps",
            [named("difference of the shares", kind, e, more, (0.0, 1.0)) for e in at],
            note,
        )
    return claims


# What "strain energy" may be.
STRAINS = [
    ("its largest value", lambda run: run.peak_strain),
    ("strain and dissipated, when detached", lambda run: run.yarn_work_at_detached()),
]
STRAIN_CLAIM = "Strain energy is two to four times larger in uniform sheets than in stochastic ones ({})"


def of_uniform(runs):
    """Claims about uniform against stochastic yarn (P3, Figs 18 to 20)."""
    add = adder(claims := [])
    for kind in (FOUR_SIDES, TWO_SIDES):
        energies = runs.uncapped((kind, STOCHASTIC), (kind, UNIFORM))
        add(
            f"Uniform yarn over-predicts slightly, {kind}",
            f"ratio in {number(SLIGHTLY[0])} to {number(SLIGHTLY[1])}, at every energy at which nothing is arrested",
            [yarns_ratio(runs, kind, UNIFORM, STOCHASTIC, e, lambda run: run.at_detached(), SLIGHTLY, 3) for e in energies],
        )
    slow, fast = runs.history_energies
    for what, value in STRAINS:
        add(
            STRAIN_CLAIM.format(what),
            f"ratio in 2 to 4, at {number(slow)} and {number(fast)} J",
            [yarns_ratio(runs, kind, UNIFORM, STOCHASTIC, e, value, TWO_TO_FOUR) for kind in ATTACHMENTS for e in (slow, fast)],
        )
    return claims + of_corners(runs) + of_points(runs)


def of_corners(runs):
    """At how many corners sheets fail near the limit. A sheet that does not fail says nothing of it."""
    readings = [
        (
            "torn off",
            "mean number of corners that tear off, of the sheets of which one does",
            lambda run: len(run.torn) or math.nan,
        ),
        (
            "segments fail nearby",
            "mean number of corners with a failed segment within 5 yarns of the washer, of the sheets that fail there",
            lambda run: run.failed_corners or math.nan,
        ),
    ]
    add, energies = adder(claims := []), runs.energies_among(ABOUT_LIMIT)
    for yarn, saying, allowed in (
        (UNIFORM, "Near the limit uniform sheets fail at all four corners", FOUR),
        (STOCHASTIC, "Near the limit stochastic sheets fail at one or two corners", ONE_OR_TWO),
    ):
        limit = [energy for energy in energies if runs.goes_through(CORNERS, yarn, energy)][:1]
        for how, what, value in readings:
            texts = []
            for energy in energies:
                all_runs = runs.of(CORNERS, yarn, energy)
                arrested = sum(run.arrested for run in all_runs)
                texts.append(
                    f"at {number(energy)} J {runs.mean_of(CORNERS, yarn, energy, value).text(1)}, {arrested} of {len(all_runs)} "
                    f"arrested"
                )
            if yarn == UNIFORM:
                texts[-1:] = [text + "; a mirror-symmetric sheet fails at all four or at none" for text in texts[-1:]]
            add(
                f"{saying} ({how})",
                f"{what}: {allowed[0]} to {allowed[1]}, at the first impact energy at which more than half of the runs are "
                f"not arrested",
                [Check(f"{yarn}, {number(energy)} J", runs.mean_of(CORNERS, yarn, energy, value), allowed) for energy in limit],
                "; ".join(texts),
            )
    return claims


def two_or_four(counts):
    """The share of the runs whose number is two or four."""
    return Estimate.share(sum(count in (2, 4) for count in counts), len(counts))


def of_points(runs):
    """At how many points uniform clamped sheets fail."""
    add = adder(claims := [])
    for yarn, sheet in ((UNIFORM, "whole sheet"), (SYMMETRIC, "mirror-symmetric sheet")):
        for how, key, what in (
            ("segments that fail first", "segments", "segments that fail first, within one step of one another"),
            ("places", "places", "places that lie more than 5 yarns apart, 10 µs after the first failure"),
        ):
            checks, means = [], []
            for kind in (TWO_SIDES, FOUR_SIDES):
                for energy in runs.history_energies:
                    counts = [run.first_failure[key] for run in runs.of(kind, yarn, energy) if run.first_failure]
                    name = f"{kind}, {number(energy)} J"
                    means.append(f"{name} {Estimate.mean(counts).text(1)}")
                    checks.append(Check(name, two_or_four(counts), MOST))
            add(
                f"Uniform clamped sheets fail at two or four points ({how}, {sheet})",
                f"two or four {what}: in more than half of the runs",
                checks,
                f"mean number: {', '.join(means)}",
            )
    return claims


# Which energy is read in the map, and when: first what the projectile has lost, then what rupture has dissipated, last what the
# yarn has taken up, as strain or by rupture.
READINGS = {
    "detached": lambda run: run.at_detached(),
    "arrested or left": lambda run: run.absorbed,
    "400 µs": lambda run: run.absorbed_at(FIXED_TIME),
    "dissipated, detached": lambda run: run.dissipated_at_detached(),
    "dissipated, arrested or left": lambda run: run.dissipated_at_end(),
    "strain and dissipated, detached": lambda run: run.yarn_work_at_detached(),
}


class Cell(NamedTuple):
    """One ratio of the map."""

    washer: str
    uniform: str
    stochastic: str
    reading: str
    energy: float
    ratio: Estimate
    arrested: tuple

    def name(self):
        return f"{self.washer}; {self.uniform} / {self.stochastic}; {self.reading}; {number(self.energy)} J"

    def text(self):
        return self.ratio.text(2) + (f" ({self.arrested[0]}/{self.arrested[1]})" if any(self.arrested) else "")


@functools.cache
def cells(runs):
    """Every ratio, in a fixed order: washers, yarns, readings, energies."""
    found = []
    for washer in runs.washers:
        for above in (UNIFORM, SYMMETRIC):
            for below in (STOCHASTIC, WOVEN):
                for reading, value in READINGS.items():
                    for energy in runs.map_energies:
                        pair = [runs.of(CORNERS, yarn, energy, washer) for yarn in (above, below)]
                        ratio = (
                            Estimate.ratio(*([value(run) for run in part] for part in pair))
                            if all(pair)
                            else Estimate.exact(math.nan)
                        )
                        # Where nothing fails, nothing is dissipated.
                        if math.isfinite(ratio.value):
                            arrested = tuple(sum(run.arrested for run in part) for part in pair)
                            found.append(Cell(washer, above, below, reading, energy, ratio, arrested))
    return found


def of_map(runs):
    """The open question (P3, Fig. 18): over the plain reading, and over the whole map."""
    every = cells(runs)
    allows = f"ratio in {TWOFOLD[0]} to {TWOFOLD[1]} at some energy near the limit"
    plain = lambda uniform, reading: [
        Check(f"{number(cell.energy)} J", cell.ratio, TWOFOLD)
        for cell in every
        if cell[:4] == (runs.washers[0], uniform, STOCHASTIC, reading)
    ]
    checks = [Check(cell.name(), cell.ratio, TWOFOLD) for cell in every]
    verdicts = [check.verdict() for check in checks]
    inside, outside, across = (verdicts.count(verdict) for verdict in (AGREES, DOES_NOT, UNDECIDED))
    add = adder(claims := [])
    add(
        "Uniform yarn over-predicts about twofold near the limit, corners (absorbed energy; preset washers, whole sheet, "
        "one sample per segment, when detached)",
        allows,
        plain(UNIFORM, "detached"),
        whole=verdict_of_any,
    )
    add(
        'The same, dissipated energy ("work done by the yarn") of the mirror-symmetric sheet, when detached',
        allows,
        plain(SYMMETRIC, "dissipated, detached"),
        whole=verdict_of_any,
    )
    # Only the greatest ratios are worth a line in the table.
    add(
        "The same under some reading of what the paper leaves open (the map; its three greatest ratios)",
        allows,
        sorted(checks, key=lambda check: -check.ours.value)[:3],
        f"of {len(every)} ratios {inside} lie inside, {outside} outside, {across} across an edge",
        verdict=verdict_of_any(verdicts),
    )
    for what, value in STRAINS:
        add(
            STRAIN_CLAIM.format(what + "; mirror-symmetric uniform sheet, near the limit"),
            "ratio in 2 to 4",
            [yarns_ratio(runs, CORNERS, SYMMETRIC, STOCHASTIC, e, value, TWO_TO_FOUR) for e in runs.map_energies],
        )
    return claims
