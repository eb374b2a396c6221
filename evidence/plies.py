"""What several plies do: ballistic limit and absorbed energy against their number, and many thin plies against one thick one.

A steel sphere of 0.69 g and 5.556 mm hits a pack of Kevlar KM2 S706, 60 mm square and held at four sides, with the viscosity of
real fabrics and a bar for two yarns. "Bonded" is one network with the mass and the section of all plies, "separate" a network for
each, a gap apart, which push on each other. The energy is taken well above the limit, at one velocity for all forms. Hits of an
ensemble differ by place and seed.
Limits: the waves come back from the edges of so small a sheet within 12 us: a bonded pack of ten stands 251, 281 and 301 m/s with
a width of 45, 60 and 101 mm, and with a bar for one yarn 1 to 2 % less; ten separate plies 3 to 4 % less; the plies lie exactly
on each other, yarn on yarn.
The measured packs are in packs.py.
"""

import math

from fabric_kernel import Scene, drawing
from fabric_kernel.drawing import Series

from . import friction, page
from .hits import BISECTION, impact, limit, sheet, shot
from .statistics import Estimate
from .study import SMOKE

# Time after which an impact is given up, s.
LONGEST = 1e-3
# Width of a sheet, m, and bar, yarn spacings.
WIDTH, BAR = 0.06, 2.0
# Plies, and a velocity near the ballistic limit or above it, m/s.
NUMBERS = ((1, 105.0), (2, 140.0), (5, 210.0), (10, 295.0), (20, 420.0), (40, 590.0), (62, 720.0))
# Between two plies, m: less than the thickness of a fabric, which was not seen, as they lie close.
GAP, GAPS = 1e-4, (0.0, 3e-5, 1e-4, 3e-4, 1e-3)
# Crimp of warp and weft, as Kevlar 49 fabric in data/measured/kevlar49_strength.toml.
CRIMP = {"warp": {"crimp": 0.0065}, "weft": {"crimp": 0.0025}}
# Strengths of Kevlar 49 yarn, data/fabrics/kevlar_49_yarn.toml.
DRAWN = {"yarn.stochastic": True, "yarn.strength_draw": "weibull", "yarn.weibull_shape": 14.74, "yarn.weibull_gauge_length": 0.05}
BONDED, SEPARATE, TURNED = "bonded", "separate", "separate, every other one turned"
# Published: two to four thin plies take over 7 % more energy than one thick one of the same mass (data/measured/effects.toml).
THIN_MORE = (7.0, math.inf)
# Plies turned against one another absorb 14 to 15 % more; half a percent for the rounding.
TURNED_MORE = (13.5, 15.5)
# Parts whose plies have their assumed thickness and lie on each other (arrangement.py).
THICK = ("number, thick", "turned, thick")
TITLES = {
    "number": "Number of plies",
    "gap": "Gap between ten plies",
    "turned": "Ten crimped plies, alike and every other one turned by 90 degrees",
    "draws": "Ten plies of sampled strength: one sample for all (bonded), and one for each",
}
NOTES = (
    "Means with 95 % intervals (Student's t) over hits that differ by their place in a cell, and by the seed where strengths "
    "are sampled. The ballistic limit of each hit is found by bisection to 1 %, which its interval counts; its energy is that "
    "of the sphere at this velocity. Bonded: one network with the mass and the section of all plies. Separate: a network for "
    "each ply, 0.1 mm apart where nothing else is said. Absorbed: work of the sphere on the fabric at the velocity of the "
    "column before it. Depth: the farthest that facing nodes of two plies were through each other, which they may be beside a "
    "hole. Unconverged: contact solves of the fastest of these runs that ended at their largest number of sweeps.\n"
)


def pack(part, form, plies, gap, smoke):
    """A pack and its sphere."""
    fabric = {"name": "kevlar_km2_s706"}
    fabric |= {"thickness": Scene("sheet_3in_sphere", fabric=fabric)["sheet.thickness"]} if part in THICK else {}
    scene = sheet(fabric | (CRIMP if part.startswith("turned") else {}), 0.02 if smoke else WIDTH, BAR)
    many = {"sheet.plies": plies} if form == BONDED else {"stack.plies": plies, "stack.gap": gap, "stack.turned": form == TURNED}
    sphere = {"projectile.shape": "sphere", "projectile.radius": 2.778e-3, "projectile.mass": 6.9e-4}
    return scene.replace(sphere | many | (DRAWN if part == "draws" else {}))


def separate(plies, smoke):
    """A pack of so many separate plies, GAP apart, and its sphere."""
    return pack("number", SEPARATE, plies, GAP, smoke)


def packs(part, smoke):
    """(form, (plies, velocity), gap) of a part."""
    numbers, some = (NUMBERS[:2], NUMBERS[1]) if smoke else (NUMBERS, NUMBERS[3])
    if part in THICK:
        forms = (SEPARATE, TURNED) if part.startswith("turned") else (BONDED, SEPARATE)
        return [(form, number, 0.0) for form in forms for number in ([some] if TURNED in forms else numbers[1:4])]
    if part == "number":
        # A single ply is both.
        return [(BONDED, number, 0.0) for number in numbers] + [(SEPARATE, number, GAP) for number in numbers[1:]]
    if part == "gap":
        return [(SEPARATE, some, gap) for gap in GAPS]
    return [(SEPARATE, some, GAP), (TURNED, some, GAP)] if part == "turned" else [(BONDED, some, 0.0), (SEPARATE, some, GAP)]


def measured(job):
    """The limit of a hit, and what it gives at 1.5 times the guess."""
    scene, guess, hit = job
    return limit(scene, guess, hit, LONGEST), impact(shot(scene, 1.5 * guess, hit), LONGEST)


def answer(study):
    parts = {part: rows_of(study, part) for part in TITLES}
    text = NOTES + "\n" + verdicts(parts)
    for name, rows in parts.items():
        text += f"\n## {TITLES[name]}\n\n{table(rows)}"
    study.table("plies", "Several plies", text)
    draw(parts["number"], study.folder / "plies.svg")
    study.picture("plies.svg", "plies.svg")
    return max(abs(row["residual %"]) for rows in parts.values() for row in rows) < 1


def rows_of(study, part):
    smoke = study.effort == SMOKE
    # Longest jobs first.
    wanted = sorted(packs(part, smoke), key=lambda one: -one[1][0])
    jobs, rows = [], []
    for form, (plies, guess), gap in wanted:
        scene, speed = pack(part, form, plies, gap, smoke), 1.5 * guess
        density = plies * scene["sheet.node_mass"] / (scene["sheet.spacing"] * scene["sheet.spacing"])
        energy = 0.5 * scene["projectile.mass"] * speed * speed
        for hit in range(study.of(6, 3, 2)):
            jobs.append((scene, guess, hit))
            row = {"form": form, "plies": plies, "gap mm": 1e3 * gap, "areal density kg/m2": density, "run": hit}
            rows.append(row | {"impact velocity m/s": speed, "impact J": energy})
    for row, (stands, fast) in zip(rows, study.each(measured, jobs, f"plies: {part}")):
        row |= {"limit m/s": stands, "absorbed J": fast["absorbed"], "velocity m/s": fast["velocity"]}
        row |= {"failed segments": fast["failed"], "residual %": 100 * fast["residual"], "unconverged": fast["unconverged"]}
        row["ply penetration mm"] = 1e3 * fast["ply_penetration"]
    study.write(f"plies_{part}", rows)
    return rows


def energies(rows):
    """Energy of the sphere at each hit's limit, in parts of that at 1 m/s."""
    return [limit * limit for limit in friction.numbers(rows, "limit m/s")]


def verdicts(parts):
    """What is published of several plies beside what the model gives, for each form of the comparison."""
    found = []
    add = lambda *row: found.append(row)
    thin = "two to four thin plies against one thick: specific energy more than +7 %"
    if "number" in parts:
        by_number = friction.groups(parts["number"], "plies")
        of = lambda plies, form: [row for row in by_number.get((plies,), []) if row["form"] == form]
        for plies, _ in NUMBERS[1:]:
            bonded, separate = of(plies, "bonded"), of(plies, "separate")
            if bonded and separate:
                allowed = THIN_MORE if plies < 5 else None
                what = thin if allowed else ""
                add(
                    f"{plies:.0f} plies separate over bonded: energy at the limit",
                    what,
                    friction.change(energies(separate), energies(bonded), 2 * BISECTION),
                    allowed,
                )
                absorbed = [friction.numbers(rows, "absorbed J") for rows in (separate, bonded)]
                add(
                    f"{plies:.0f} plies separate over bonded: absorbed at {bonded[0]['impact velocity m/s']:.0f} m/s",
                    what,
                    friction.change(*absorbed),
                    allowed,
                )
    if "draws" in parts:
        bonded, separate = ([row for row in parts["draws"] if row["form"] == form] for form in ("bonded", "separate"))
        add(
            "own samples over one for all: energy at the limit",
            "",
            friction.change(energies(separate), energies(bonded), 2 * BISECTION),
            None,
        )
    if "turned" in parts:
        alike = [row for row in parts["turned"] if row["form"] == "separate"]
        turned = [row for row in parts["turned"] if row["form"] != "separate"]
        what = "plies turned against one another: absorbed energy +14 to +15 %"
        add(
            "every other ply turned: energy at the limit",
            what,
            friction.change(energies(turned), energies(alike), 2 * BISECTION),
            TURNED_MORE,
        )
        add(
            "every other ply turned: absorbed",
            what,
            friction.change(friction.numbers(turned, "absorbed J"), friction.numbers(alike, "absorbed J")),
            TURNED_MORE,
        )
    lines = [[name, value.text(1), what, value.verdict(allowed) if allowed else ""] for name, what, value, allowed in found]
    return page.markdown(["comparison", "change, % [95 %]", "published", "verdict"], lines) if lines else ""


def table(rows):
    lines = []
    for key, own in friction.groups(rows, "plies", "gap mm", "areal density kg/m2").items():
        for form in dict.fromkeys(row["form"] for row in own):
            hits = [row for row in own if row["form"] == form]
            plies, gap, density = key
            limits, absorbed = (
                Estimate.mean(friction.numbers(hits, "limit m/s"), BISECTION),
                Estimate.mean(friction.numbers(hits, "absorbed J")),
            )
            deepest, unconverged = max(friction.numbers(hits, "ply penetration mm")), max(friction.numbers(hits, "unconverged"))
            apart, depth = ("", "") if form == "bonded" else (f"{gap:g}", f"{deepest:.1e}")
            failed = f"{sum(friction.numbers(hits, 'failed segments')) / len(hits):.0f}"
            residual = f"{max(map(abs, friction.numbers(hits, 'residual %'))):.2f}"
            hit = [limits.text(1), f"{hits[0]['impact velocity m/s']:.0f}", absorbed.text(2), failed, residual]
            lines.append([form, f"{plies:.0f}", apart, f"{density:.2f}", len(hits), *hit, depth, f"{unconverged:.0f}"])
    lines.sort(key=lambda line: (float(line[1]), line[2]))
    heading = (
        "form; plies; gap, mm; kg/m²; hits; limit, m/s; hit at, m/s; absorbed, J; failed segments; residual, %; depth, mm; "
        "unconverged"
    ).split("; ")
    return page.markdown(heading, lines)


def draw(rows, path):
    series = []
    for form in ("bonded", "separate"):
        means = [
            (plies, Estimate.mean(friction.numbers(own, "limit m/s"), BISECTION))
            for (plies,), own in sorted(friction.groups([row for row in rows if row["form"] == form], "plies").items())
        ]
        series.append(
            Series(
                form, [(plies, limit.value) for plies, limit in means], "marked", [(limit.low, limit.high) for _, limit in means]
            )
        )
    drawing.draw(
        path, "Ballistic limit of Kevlar KM2 S706, sphere of 0.69 g", "plies", "ballistic limit (m/s)", series, "logarithmic x"
    )
