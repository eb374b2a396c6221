"""Friction between yarn and projectile: means with 95 % intervals of absorbed energy and ballistic limit against the coefficient."""

import math

from . import page
from .statistics import Estimate, standard_error


def report(folder, docs=None):
    impacts, limits = page.rows_of(folder / "friction.csv"), page.rows_of(folder / "friction_limits.csv")
    text = NOTES + "\n" + verdicts(limits)
    for case in dict.fromkeys(row["case"] for row in impacts):
        own = [row for row in impacts if row["case"] == case]
        searched = [row for row in limits if row["case"] == case]
        text += f"\n## {case[0].upper()}{case[1:]}\n"
        text += "\nBallistic limit:\n\n" + limit_table(searched) if searched else ""
        text += "\nAbove the limit:\n\n" + impact_table(own)
    print(text)
    if docs:
        page.write_table(docs, "friction", "Friction against its coefficient", "fabric-study friction` and `python3 -m reports friction --docs docs", text)


NOTES = (
    "Means with 95 % intervals (Student's t) over runs that differ by the seed and by where in a cell of the network the sphere strikes. "
    "Absorbed: work of the sphere on the fabric. Rubbed: what of it friction turned into heat. A run ends when the sphere has exited or after 0.6 ms; "
    "after the first failure steps are halved. The ballistic limit of each run is found by bisection to 1 %, which its interval counts. "
    "Residual: the largest of these runs, of the impact energy. "
    "Unconverged: contact solves of one of these runs, at most, that ended at their largest number of sweeps. "
    "Published is the effect of friction between yarns, about +10 % on the ballistic limit (validation/effects.toml); "
    "here the projectile rubs, and the yarns do not, so a verdict says only whether the sizes are alike.\n"
)
# "About +10 %", as far as the round number tells.
PUBLISHED = (5.0, 15.0)
# Width of a bisection for a ballistic limit, in parts of it.
BISECTION = 0.01


def groups(rows, *keys):
    found = {}
    for row in rows:
        found.setdefault(tuple(float(row[key]) for key in keys), []).append(row)
    return found


def shown(found, digits):
    """A value with its interval."""
    if not math.isfinite(found.low):
        return f"{found.value:.{digits}f}"
    return f"{found.value:.{digits}f} [{found.low:.{digits}f}, {found.high:.{digits}f}]"


def numbers(rows, key):
    return [float(row[key]) for row in rows]


def change(values, without, resolution=0.0):
    """Of a mean over that without friction, %; runs of the same number are no pairs beyond the first failure."""
    mean = lambda numbers: sum(numbers) / len(numbers)
    error = lambda numbers: standard_error(numbers, resolution) / mean(numbers)
    ratio = mean(values) / mean(without)
    spread = ratio * math.hypot(error(values), error(without))
    return Estimate.of_error(100 * (ratio - 1), 100 * spread, min(len(values), len(without)) - 1)


def verdicts(limits):
    """The ballistic limit with the published coefficients, 0.1 to 0.3, over that without friction."""
    lines = []
    for case in dict.fromkeys(row["case"] for row in limits):
        own = [row for row in limits if row["case"] == case]
        found = {friction: numbers(rows, "limit m/s") for (friction,), rows in groups(own, "friction").items()}
        for friction in (0.1, 0.2, 0.3):
            if friction in found:
                value = change(found[friction], found[0.0], BISECTION)
                lines.append([f"{case}: limit with {friction:g} over 0", shown(value, 1), "about +10 %, read as 5 to 15 %", value.verdict(PUBLISHED)])
    return page.markdown(["comparison", "change, % [95 %]", "published", "verdict"], lines)


def limit_table(rows):
    found = groups(rows, "friction")
    without = numbers(found[(0.0,)], "limit m/s")
    lines = []
    for (friction,), own in found.items():
        limits = numbers(own, "limit m/s")
        lines.append([f"{friction:g}", shown(Estimate.mean(limits, BISECTION), 1), "" if friction == 0 else shown(change(limits, without, BISECTION), 1), len(limits)])
    return page.markdown(["coefficient", "limit, m/s", "against 0, %", "runs"], lines)


def impact_table(rows):
    lines = []
    found = groups(rows, "impact velocity m/s", "friction")
    for (velocity, friction), own in found.items():
        absorbed = numbers(own, "absorbed J")
        without = numbers(found[(velocity, 0.0)], "absorbed J")
        lines.append([
            f"{velocity:.0f}", f"{float(own[0]['impact J']):.1f}", f"{friction:g}", shown(Estimate.mean(absorbed), 2),
            "" if friction == 0 else shown(change(absorbed, without), 1), f"{sum(numbers(own, 'rubbed J')) / len(own):.2f}",
            shown(Estimate.mean(numbers(own, "velocity m/s")), 1),
            f"{max(map(abs, numbers(own, 'residual %'))):.2f}", f"{max(numbers(own, 'unconverged')):.0f}",
        ])  # fmt: skip
    return page.markdown(["velocity, m/s", "energy, J", "coefficient", "absorbed, J", "against 0, %", "rubbed, J", "velocity after, m/s", "residual, %", "unconverged"], lines)
