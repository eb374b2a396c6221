"""Several plies: means with 95 % intervals of ballistic limit and absorbed energy against their number, bonded and separate."""

import math
import shutil

from . import page, plot
from .friction import BISECTION, change, groups, numbers, shown
from .plot import Series
from .statistics import Estimate

# Published: two to four thin plies take over 7 % more energy than one thick one of the same mass (validation/effects.toml).
THIN = (7.0, math.inf)
# Plies turned against one another absorb 14 to 15 % more; half a percent for the rounding.
TURNED = (13.5, 15.5)
TITLES = {
    "number": "Number of plies",
    "gap": "Gap between ten plies",
    "turned": "Ten crimped plies, alike and every other one turned by 90 degrees",
    "draws": "Ten plies of drawn strength: one draw for all (bonded), and one for each",
}
NOTES = (
    "Means with 95 % intervals (Student's t) over hits that differ by their place in a cell, and by the seed where strengths are drawn. "
    "The ballistic limit of each hit is found by bisection to 1 %, which its interval counts; its energy is that of the sphere at this velocity. "
    "Bonded: one network with the mass and the section of all plies. Separate: a network for each ply, 0.1 mm apart where nothing else is said. "
    "Absorbed: work of the sphere on the fabric at the velocity of the column before it. "
    "Depth: the farthest that facing nodes of two plies were through each other, which they may be beside a hole. "
    "Unconverged: contact solves of the fastest of these runs that ended at their largest number of sweeps.\n"
)


def report(folder, docs=None):
    parts = {}
    for name in TITLES:
        rows = page.rows_of(folder / f"plies_{name}.csv", needed=False)
        if rows:
            parts[name] = rows
    text = NOTES + "\n" + verdicts(parts)
    for name, rows in parts.items():
        text += f"\n## {TITLES[name]}\n\n{table(rows)}"
    print(text)
    if "number" in parts:
        draw(parts["number"], folder / "plies.svg")
    if docs:
        page.write_table(docs, "plies", "Several plies", "fabric-study plies` and `python3 -m reports plies --docs docs", text)
        if "number" in parts:
            (docs / "images").mkdir(parents=True, exist_ok=True)
            shutil.copy(folder / "plies.svg", docs / "images" / "plies.svg")


def energies(rows):
    """Energy of the sphere at each hit's limit, in parts of that at 1 m/s."""
    return [limit * limit for limit in numbers(rows, "limit m/s")]


def verdicts(parts):
    """What is published of several plies beside what the model gives, for each form of the comparison."""
    found = []
    thin = "two to four thin plies against one thick: specific energy more than +7 %"
    if "number" in parts:
        packs = groups(parts["number"], "plies")
        of = lambda plies, form: [row for row in packs.get((plies,), []) if row["form"] == form]
        for plies in (2.0, 5.0, 10.0, 20.0, 40.0, 62.0):
            bonded, separate = of(plies, "bonded"), of(plies, "separate")
            if bonded and separate:
                allowed = THIN if plies < 5 else None
                what = thin if allowed else ""
                found.append((f"{plies:.0f} plies separate over bonded: energy at the limit", what, change(energies(separate), energies(bonded), 2 * BISECTION), allowed))
                absorbed = [numbers(rows, "absorbed J") for rows in (separate, bonded)]
                found.append((f"{plies:.0f} plies separate over bonded: absorbed at {float(bonded[0]['impact velocity m/s']):.0f} m/s", what, change(*absorbed), allowed))
    if "draws" in parts:
        bonded, separate = ([row for row in parts["draws"] if row["form"] == form] for form in ("bonded", "separate"))
        found.append(("draws of their own over one for all: energy at the limit", "", change(energies(separate), energies(bonded), 2 * BISECTION), None))
    if "turned" in parts:
        alike = [row for row in parts["turned"] if row["form"] == "separate"]
        turned = [row for row in parts["turned"] if row["form"] != "separate"]
        what = "plies turned against one another: absorbed energy +14 to +15 %"
        found.append(("every other ply turned: energy at the limit", what, change(energies(turned), energies(alike), 2 * BISECTION), TURNED))
        found.append(("every other ply turned: absorbed", what, change(numbers(turned, "absorbed J"), numbers(alike, "absorbed J")), TURNED))
    lines = [[name, f"{shown(value, 1)}", what, value.verdict(allowed) if allowed else ""] for name, what, value, allowed in found]
    return page.markdown(["comparison", "change, % [95 %]", "published", "verdict"], lines) if lines else ""


def table(rows):
    lines = []
    for key, own in groups(rows, "plies", "gap mm", "areal density kg/m2").items():
        for form in dict.fromkeys(row["form"] for row in own):
            hits = [row for row in own if row["form"] == form]
            plies, gap, density = key
            limits, absorbed = Estimate.mean(numbers(hits, "limit m/s"), BISECTION), Estimate.mean(numbers(hits, "absorbed J"))
            deepest, unconverged = max(numbers(hits, "ply penetration mm")), max(numbers(hits, "unconverged"))
            lines.append([
                form, f"{plies:.0f}", "" if form == "bonded" else f"{gap:g}", f"{density:.2f}", len(hits), shown(limits, 1), f"{float(hits[0]['impact velocity m/s']):.0f}",
                shown(absorbed, 2), f"{sum(numbers(hits, 'failed segments')) / len(hits):.0f}", f"{max(map(abs, numbers(hits, 'residual %'))):.2f}",
                "" if form == "bonded" else f"{deepest:.1e}", f"{unconverged:.0f}",
            ])  # fmt: skip
    lines.sort(key=lambda line: (float(line[1]), line[2]))
    heading = ["form", "plies", "gap, mm", "kg/m²", "hits", "limit, m/s", "hit at, m/s", "absorbed, J", "failed segments", "residual, %", "depth, mm", "unconverged"]
    return page.markdown(heading, lines)


def draw(rows, path):
    series = []
    for form in ("bonded", "separate"):
        means = [(plies, Estimate.mean(numbers(own, "limit m/s"), BISECTION)) for (plies,), own in sorted(groups([row for row in rows if row["form"] == form], "plies").items())]
        series.append(Series(form, [(plies, limit.value) for plies, limit in means], "marked", [(limit.low, limit.high) for _, limit in means]))
    plot.draw(path, "Ballistic limit over the number of plies: Kevlar KM2 S706, sphere of 0.69 g", "plies", "ballistic limit (m/s)", series, "logarithmic x")
