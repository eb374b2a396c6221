"""How often the intervals of a ballistic limit hold the truth: simulated tests of fabrics that are known.

Method: the design and the method of analysis know nothing of the fabric but the guess. The results depend only on how far the
guess is off in units of the fabric's sigma, not on sigma/mu: a fabric with a sigma of 2 % and one of 10 % are the same test in
another unit (tests/python/test_limit.py). The guess is a V50 of 500 m/s and a standard deviation of 25 m/s; the fabrics lie
beside it. A test without a fit counts as held, as its interval has no end.

Tests without a guess: the presets and the textiles of data/fabrics/ are shot from a tenth, once and ten times their limit, which
a few shots find first, 20 times, and 30 where the interval of V50 is not bounded by 20; and the same is simulated.
"""

import math

import numpy
from fabric_kernel import Scene, designs, limit
from fabric_kernel.likelihood import LINKS, maximum, possible, possible_ratio, ratio
from fabric_kernel.limit import FEWEST, Calibration, fit
from fabric_kernel.v50 import Shooter, v50

from .page import markdown
from .study import FULL

MU, DEVIATION = 500.0, 25.0
SHARES = (0.01, 0.5, 0.99)
COUNTS = (6, 8, 10, 15, 20, 30, 60)
# How far the guess of V50 is off, in standard deviations of the fabric, and the guess of that deviation over the true one.
GUESSES = ((0, 1), (1, 1), (2, 1), (0, 0.5), (-2, 0.5), (0, 2), (2, 2))
# Quantiles of chi squared with one degree of freedom.
CHI = 3.841458820694124
# Of tests without a guess: first velocities over the limit; shots; simulated tests behind an interval; standard deviations of the
# simulated fabrics, in that of the guess.
STARTS, TRIED, TESTS, WIDTHS = (0.1, 1.0, 10.0), (20, 30), 400, (0.5, 1.0, 2.0)


def design_of(name, link, shots):
    """A design whose guess is a V50 of MU and a standard deviation of DEVIATION, or, by a number, one that brackets from so many
    MU."""
    if not isinstance(name, str):
        return designs.Neyer.bracketed(name * MU, link=link)
    low, high, sigma = MU - 4 * DEVIATION, MU + 4 * DEVIATION, DEVIATION / LINKS[link].deviation
    if name == "Neyer":
        return designs.Neyer(low, high, sigma, link)
    if name == "three-phase":
        return designs.ThreePhase(low, high, sigma, link)
    if name == "three-phase to V01":
        return designs.ThreePhase(low, high, sigma, link, aim=0.01, last=shots // 2, shots=shots)
    # Evenly spaced over 3 guessed deviations on both sides.
    return designs.Plan(MU + 3 * DEVIATION * numpy.linspace(-1, 1, shots))


class Case:
    """Simulated tests of one design, with the calibration that they share."""

    def __init__(self, name, link, shots, law=None):
        self.name, self.link, self.shots, self.law = name, link, shots, law or link
        # The design stays and the fabric moves: one calibration for all guesses.
        self.design = design_of(name, link, shots)
        self.calibration = Calibration(self.design, shots, link, shares=SHARES, about=(MU, DEVIATION / LINKS[link].deviation))

    def run(self, shift, part, tests, seed):
        """For each share the part of the tests whose interval holds the truth: calibrated, and plain profile likelihood."""
        deviation = DEVIATION / part
        mu = MU - shift * deviation
        law, link = LINKS[self.law], LINKS[self.link]
        random = numpy.random.default_rng([seed, self.shots, round(8 * part), shift + 8])
        scale = deviation / law.deviation
        limits = mu + scale * law.sample(random, (tests, self.shots))
        velocities, through = designs.simulate(self.design, self.shots, limits)
        best, level = maximum(velocities, through, link), possible(velocities, through, link, self.design.largest)
        held, plain = [], []
        for number, share in enumerate(SHARES):
            truth = numpy.full(tests, mu + scale * float(law.quantile(share)))
            quantile = self.calibration.quantiles[number]
            value, sigma = possible_ratio(level, velocities, through, link, truth, quantile, self.design.largest)
            known = numpy.isfinite(value)
            allowed = numpy.full(tests, math.inf)
            allowed[known] = self.calibration.allowed(truth[known], sigma[known], numpy.full(known.sum(), number))
            held.append(float(numpy.mean(~known | (value <= allowed))))
            plain.append(
                float(numpy.mean(~known | (ratio(best.level, velocities, through, link, truth, quantile, 0.0)[0] <= CHI)))
            )
        return held, plain

    def widths(self, tests, seed):
        """With the right guess: median width of each interval in standard deviations; infinite where an end is open in half of
        the tests."""
        law = LINKS[self.link]
        random = numpy.random.default_rng([seed, self.shots, 77])
        limits = MU + DEVIATION / law.deviation * law.sample(random, (tests, self.shots))
        velocities, through = designs.simulate(self.design, self.shots, limits)
        found = [fit(v, y, self.link, shares=SHARES, calibration=self.calibration) for v, y in zip(velocities, through)]
        widths = numpy.array([[(one.high - one.low) / DEVIATION for one in test.intervals] for test in found])
        return numpy.median(widths, axis=0)


def percent(parts):
    return [f"{100 * part:.1f}" for part in parts]


def cases(few=False):
    """Design, fitted link, shots, and the fabric's law."""
    if few:
        return [("Neyer", "probit", shots, law) for shots, law in ((10, "probit"), (15, "probit"), (20, "probit"), (20, "logit"))]
    right = [(name, link, shots, link) for name in ("Neyer", "three-phase") for link in LINKS for shots in COUNTS]
    right += [(name, "probit", shots, "probit") for name in ("three-phase to V01", "plan") for shots in (20, 60)]
    return right + [("Neyer", link, shots, law) for law, link in (("logit", "probit"), ("probit", "logit")) for shots in (20, 60)]


def result(job):
    """Everything about one case."""
    name, link, shots, law, tests = job
    case, seed = Case(name, link, shots, law), 1
    guesses = GUESSES if law == link else GUESSES[:1]
    runs = [case.run(shift, part, tests, seed) for shift, part in guesses]
    return {"runs": runs, "median": list(case.widths(max(20, tests // 20), seed)) if law == link else []}


def tables(found):
    """The tables, and the list of all coverages."""
    words = lambda shift, part: f"{shift:+d} sd, sd x {part:g}" if shift else f"sd x {part:g}"
    heading = ["design", "link", "shots", "guess off", "V01", "V50", "V99", "plain V01", "plain V50", "plain V99"]
    rows, wide, wrong, everything = [], [], [], []
    for (name, link, shots, law), one in found.items():
        if law != link:
            wrong.append([law, link, str(shots), *percent(one["runs"][0][0]), *percent(one["runs"][0][1])])
            continue
        for (shift, part), (held, plain) in zip(GUESSES, one["runs"]):
            rows.append([name, link, str(shots), words(shift, part), *percent(held), *percent(plain)])
            everything += [(shots, name, link, words(shift, part), *three) for three in zip(SHARES, held, plain)]
        wide.append([name, link, str(shots), *(f"{width:.1f}" if math.isfinite(width) else "open" for width in one["median"])])
    return (
        (heading, rows),
        (["design", "link", "shots", "V01", "V50", "V99"], wide),
        (["truth", "fitted", "shots", *heading[4:]], wrong),
        everything,
    )


def summary(everything, tests):
    """What is missed, with its figure. The error of a coverage itself is 0.7 percentage points in 1000 tests."""
    lines = []
    for low, high in ((6, 8), (10, 10), (15, 15), (20, 60)):
        here = [row for row in everything if low <= row[0] <= high]
        if not here:
            continue
        inside = sum(0.93 <= row[5] <= 0.97 for row in here)
        least, most = min(here, key=lambda row: row[5]), max(here, key=lambda row: row[5])
        shots = f"{low} shots" if low == high else f"{low} to {high} shots"
        at = lambda row: f"{100 * row[5]:.1f} % (V{100 * row[4]:02.0f}, {row[1]}, {row[2]}, {row[0]} shots, {row[3]})"
        below, above = sum(row[5] < 0.93 for row in here), sum(row[5] > 0.97 for row in here)
        lines.append(
            f"- {shots}: {inside} of {len(here)} coverages lie between 93 and 97 %, {below} below, {above} above; the smallest "
            f"is {at(least)}, "
            f"the largest {at(most)}. The plain profile likelihood holds the truth in {100 * min(row[6] for row in here):.1f} to "
            f"{100 * max(row[6] for row in here):.1f} %."
        )
    error = 100 * math.sqrt(0.95 * 0.05 / tests)
    return "\n".join(lines) + f"\n\nEach coverage is from {tests} tests: its standard error is {error:.1f} percentage points.\n"


def scenes():
    """By their names in the table. The sheets are small, and Kevlar 49 has a weave that is chosen here."""
    small = {"nodes_x": 51, "nodes_y": 51}
    found = {"sheet_3in_sphere": Scene()}
    weave = {"linear_density": {"value": 1420, "unit": "denier"}, "count": {"value": 17, "unit": "1/in"}}
    for textile in ("kevlar_49_yarn", "kevlar_km2_s706", "powell_zohdi_2009", "zylon_as_500_35"):
        found[textile] = Scene(fabric={"name": textile} | (weave if textile == "kevlar_49_yarn" else {}), sheet=small)
    return found | {"sheet_10in_cylinder": Scene("sheet_10in_cylinder", sheet=small)}


def shot(job):
    """Rows of the table, one for each start."""
    name, scene, starts, tests = job
    shoot = Shooter(scene)
    first = v50(shoot, designs.Neyer.bracketed(math.hypot(*scene["projectile.velocity"])), 8, tests=0)
    about = float(f"{first.fit.mu:.2g}")
    rows = []
    for start in starts:
        design = designs.Neyer.bracketed(start * about)
        for shots in TRIED:
            test = v50(shoot, design, shots, tests=0)
            velocities, through = [one.velocity for one in test.shots], [not one.stopped for one in test.shots]
            found = limit.fit(velocities, through, design=design, shares=(0.5,), tests=tests)
            if all(math.isfinite(end) for end in found.intervals[0]) and not found.assumed[0]:
                break
        bracket = next(k for k in range(1, shots + 1) if len(set(through[:k])) == 2 or k == shots)
        found_by = f"{found.mu:.1f}; {found.intervals[0]}; {found.deviation:.1f}"
        rows.append(f"{name}; {start * about:g}; {bracket}; {shots}; {found_by}".split("; "))
    return rows


def simulated(job):
    """Rows of the table of coverages, one for each standard deviation."""
    shots, start, tests = job
    case, rows = Case(start, "probit", shots), []
    for width in WIDTHS:
        held, plain = case.run(0, 1.0 / width, tests, 1)
        rows.append([f"{start:g}", str(shots), f"{100 * width * DEVIATION / MU:g}", *percent(held), *percent(plain)])
    return rows


def bracketing(study):
    full = study.effort == FULL
    starts, tests, simulations = (STARTS, TESTS, 1000) if full else (STARTS[1:2], 20, 20)
    tried = list(scenes().items())[slice(None) if full else slice(1, 2)]
    shots = sum(study.each(shot, [(name, scene, starts, tests) for name, scene in tried]), [])
    coverage = sum(
        study.each(
            simulated, [(shots, start, simulations) for shots in TRIED[: 2 if full else 1] for start in starts], "simulated"
        ),
        [],
    )
    heading = (
        "scene; first velocity, m/s; shots to the bracket; shots; V50, m/s; 95 % interval, m/s; standard deviation, m/s"
    ).split("; ")
    plain = "start over V50; shots; standard deviation, % of V50; V01; V50; V99; plain V01; plain V50; plain V99".split("; ")
    study.table(
        "v50_bracket",
        "Tests without a guess",
        (
            "Each test begins with a tenth, once or ten times the limit, which 8 shots from the scene's own 100 m/s found "
            "before.\n"
            "It has 20 shots, or 30 if an end of the interval of V50 is not given by 20.\n"
            "The 3 in preset is as it is; the other sheets have 51 x 51 nodes, so that the limits are theirs and not those of "
            "larger ones.\n"
            f"The projectile of a textile is that of the 3 in preset; intervals are from {tests} simulated tests.\n"
            "Kevlar 49 has a weave that was chosen for this table: 1420 denier, 17 per inch.\n\n"
            f"{markdown(heading, shots)}\n"
            f"## Coverage\n\nPercent of {simulations} simulated tests whose 95 % interval holds the truth (probit); its "
            f"standard error is {100 * math.sqrt(0.95 * 0.05 / simulations):.1f} percentage points.\n"
            '"Plain": the profile likelihood with chi squared.\n\n'
            f"{markdown(plain, coverage)}"
        ),
    )


def answer(study):
    tests, wanted = study.of(1000, 100, 10), cases(few=study.effort != FULL)
    found = dict(zip(wanted, study.each(result, [(*case, tests) for case in wanted])))
    main_table, widths, wrong, everything = tables(found)
    study.table(
        "v50",
        "Coverage of the intervals of the ballistic limit",
        (
            "Percent of simulated tests whose 95 % interval holds the truth.\n"
            '"Guess off": how far the guess of V50 lies from the truth, in standard deviations of the fabric, and the guessed '
            "standard deviation "
            "over the true one.\n"
            '"Plain": the profile likelihood with chi squared.\n'
            '"Three-phase to V01": the second half of its shots approaches V01.\n'
            '"Plan": velocities evenly spaced over three guessed deviations on both sides.\n\n'
            f"Below {FEWEST} shots no V01 and V99 are reported: their rows are what such intervals would hold.\n\n"
            f"{summary(everything, tests)}\n{markdown(*main_table, 2)}\n"
            "## Width\n\n"
            "Median width of the 95 % interval in standard deviations of the fabric, with the right guess; open: an end is not "
            "bounded "
            "in half of the tests or more.\n\n"
            f"{markdown(*widths, 2)}\n"
            f"## Wrong law\n\nThe fabric's law is not the fitted one: what that costs (Neyer, right guess).\n\n"
            f"{markdown(*wrong, 2)}"
        ),
    )
    bracketing(study)
