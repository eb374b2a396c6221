"""How often the interval of own firing tests holds another shield: invented families of shields that are known.

Method: a family has a bias of ±20 % and a scatter among its shields; its tests have errors of 3 %, which are given. Areal
densities lie at random, evenly in ln, from 2.5 to 7.5 kg/m²; V50 is 300 m/s times their root. With a trend the bias rises by
TREND over that range. The new shield is one more of the family, without an error of its test.
"Subtracted": the same with s² + q² for the variance, as a prediction interval of a meta-analysis has it.
"""

import math

import numpy
import scipy.special
import scipy.stats
from fabric_kernel.family import Tested, pool_of, trends

from .page import markdown

BIAS, ERROR, TREND, RANGE = 0.2, 0.03, 0.2, (2.5, 7.5)
COUNTS, SCATTERS = range(2, 11), (0.02, 0.05, 0.15)


def result(job):
    """Shares of new shields inside, without and with errors subtracted, share of families with a trend, and median factor."""
    n, scatter, trend, families = job
    random, rows = numpy.random.default_rng([n, round(1000 * scatter), round(1000 * trend)]), []
    t = float(scipy.special.stdtrit(n - 1, 0.975))
    for _ in range(families):
        x = random.uniform(0.0, 1.0, n + 1)
        true = random.uniform(-BIAS, BIAS) + trend * x + scatter * random.standard_normal(n + 1)
        density = RANGE[0] * (RANGE[1] / RANGE[0]) ** x
        computed = 300.0 * numpy.sqrt(density)
        measured = computed * numpy.exp(true + ERROR * random.standard_normal(n + 1))
        tests = [Tested("", *map(float, (measured[k], ERROR, computed[k], 0.0, density[k], 1e-3))) for k in range(n)]
        pool = pool_of(tests)
        off = abs(true[-1] - pool.b)
        rows.append((off <= pool.half(), off <= t * math.hypot(pool.s, pool.q), bool(trends(tests)), math.exp(pool.half())))
    inside, subtracted, found, factor = zip(*rows)
    return [*(float(numpy.mean(one)) for one in (inside, subtracted, found)), float(numpy.median(factor))]


def answer(study):
    families = study.of(1000, 200, 10)
    cases = [(n, scatter, trend) for trend in (0.0, TREND) for scatter in SCATTERS for n in COUNTS]
    found = dict(zip(cases, study.each(result, [(*case, families) for case in cases])))
    text = ""
    for trend, title in ((0.0, "Without a trend"), (TREND, f"The ratio rises by {100 * math.expm1(TREND):.0f} % over the range")):
        rows = []
        for n in COUNTS:
            own = [found[n, scatter, trend] for scatter in SCATTERS]
            cells = [f"{100 * one[k]:.1f}" for one in own for k in (0, 1)] + [f"{one[3]:.2f}" for one in own]
            rows.append([n, *cells, *(f"{100 * one[2]:.0f}" if n > 2 else "" for one in own)])
        names = [f"{100 * scatter:.0f} %" for scatter in SCATTERS]
        heading = [f"{name} {what}" for name in names for what in ("inside", "subtracted")]
        heading += [f"{name} {what}" for what in ("factor", "trend") for name in names]
        text += f"## {title}\n\n{markdown(['tests', *heading], rows)}\n"
    least = {trend: min(one[0] for case, one in found.items() if case[2] == trend) for trend in (0.0, TREND)}
    most = max(one[1] for case, one in found.items() if not case[2] and case[1] < 0.1)
    worst = min(one[1] for case, one in found.items() if not case[2])
    error = 100 * math.sqrt(0.95 * 0.05 / families)
    study.table(
        "own_tests",
        "Coverage of the intervals that own firing tests give",
        "Percent of new shields inside the 95 % interval, by the number of tests and the scatter; the median factor; "
        "percent of families in which a trend is reported.\n"
        f"At least {100 * least[0.0]:.1f} % are inside without a trend, {100 * least[TREND]:.1f} % with one. With errors "
        f"subtracted {100 * worst:.1f} to {100 * most:.1f} % are, where the scatter is 2 or 5 %.\n"
        f"Each number is from {families} families: its standard error is {error:.1f} percentage points.\n\n{text}",
    )
    # So few, of all cases together, in one of a thousand studies of intervals that hold 95 %.
    few = scipy.stats.binom.ppf(1e-3 / (len(SCATTERS) * len(COUNTS)), families, 0.95) / families
    return least[0.0] >= few
