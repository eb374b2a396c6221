"""Convergence in the spacing: absorbed energy and ballistic limit of one sheet with bars of 4, 2, 1 and 1/2 yarn spacings.

A bar stands for as many yarns side by side as it is spacings long, so mass, stiffness and strength of the sheet stay. What need
not stay is the energy that it takes to break a yarn. Beyond the critical stretch a bar of the length h carries N_c exp(-lambda (U
- U_c)), so it opens by about h/lambda while it breaks, and its softening takes N_c h/lambda: with a constant lambda half the
  length takes half the energy. lambda proportional to h,
lambda = lambda_0 h/h_0, keeps force over opening and with it that energy (Z. P. Bazant, B. H. Oh, Materials and Structures 16
(1983) 155: crack band).
The elastic energy of the breaking bar, N_c e_c h/2, is taken too and is proportional to h in any case; with lambda_0 = 2303 and
e_c = 3.55 % it is forty times the softening.

Scene: Kevlar KM2 S706, 50.8 mm square, four sides held; a steel sphere of 6.35 mm, which is larger than the longest bar. Hits
differ by their place in a cell. The energy is that at twice a velocity near the limit; the same for all spacings.
"""

import math

from fabric_kernel import drawing
from fabric_kernel.drawing import Series

from . import page
from .comparison import Comparison, Point, about, mean_of
from .hits import BISECTION, impact, limit, sheet, shot
from .statistics import Estimate, deviation, mean
from .study import FULL
from .viscosity import NONE, VISCOUS, viscosity_name, viscous

# Width of the sheet, m; time after which an impact is given up, s; a steel sphere.
WIDTH, LONGEST, SPHERE = 0.0508, 2e-3, {"projectile.shape": "sphere", "projectile.radius": 3.175e-3, "projectile.mass": 1.05e-3}
# Bars, yarn spacings; the finest, for the energy alone, which is quick at a high velocity, and the sheet that gets it.
BARS, FINEST, FINE_SHEET = (4.0, 2.0, 1.0, 0.5), 0.25, 1
# Plies lumped into one network, where the search for a limit starts and where the energy is taken, m/s, damage rate of a bar of
# one spacing.
SHEETS = ((1, 50.0, 100.0, 2302.6), (10, 200.0, 400.0, 2302.6), (10, 200.0, 400.0, 230.0))


def measured(job):
    """Absorbed energy, J, ballistic limit, m/s, energy residual, %."""
    scene, guess, fast, hit, searched = job
    found = impact(shot(scene, fast, hit), LONGEST)
    return [found["absorbed"], limit(scene, guess, hit, LONGEST) if searched else math.nan, 100 * found["residual"]]


def compared(study):
    full = study.effort == FULL
    networks = []
    for k, (plies, guess, fast, rate) in enumerate(SHEETS if full else SHEETS[:1]):
        for viscosity in (NONE, VISCOUS) if full else (VISCOUS,):
            for scaled in (False, True):
                bars = (BARS if full else BARS[:2]) + ((FINEST,) if k == FINE_SHEET and not scaled else ())
                networks += [(plies, guess, fast, rate, viscosity, scaled, bar) for bar in bars]
    hits, scenes = range(4 if full else 2), []
    for plies, _, _, rate, viscosity, scaled, bar in networks:
        more = {"sheet.plies": plies, "yarn.damage_intercept": rate * (bar if scaled else 1.0)}
        scenes.append(sheet({"name": "kevlar_km2_s706"}, WIDTH, bar).replace(SPHERE | more | viscous(viscosity)))
    # Long runs first.
    order = sorted(((n, hit) for n in range(len(networks)) for hit in hits), key=lambda job: networks[job[0]][-1])
    jobs = [(scenes[n], networks[n][1], networks[n][2], hit, networks[n][-1] > FINEST) for n, hit in order]
    found, rows = dict(zip(order, study.each(measured, jobs, "spacing"))), []
    for n, (plies, _, _, rate, viscosity, scaled, bar) in enumerate(networks):
        absorbed, limits, residuals = zip(*(found[n, hit] for hit in hits))
        row = {"plies": plies, "viscosity": viscosity_name(viscosity), "damage rate": rate}
        row |= {"damage rate and length": "in proportion" if scaled else "constant"}
        row |= {"yarns a bar": bar, "hits": len(hits), "absorbed J": mean(absorbed), "absorbed J: deviation": deviation(absorbed)}
        rows.append(
            row | {"limit m/s": mean(limits), "limit m/s: deviation": deviation(limits), "energy residual %": mean(residuals)}
        )
    study.write("spacing", rows)
    return converged(study, rows)


def converged(study, rows):
    found, series = {}, []
    networks = lambda row: (row["plies"], row["viscosity"], row["damage rate"], row["damage rate and length"])
    for key in dict.fromkeys(map(networks, rows)):
        own = [row for row in rows if networks(row) == key]
        plies, viscosity, damage_rate, length = key
        base = next((row for row in own if row["yarns a bar"] == 1), None)
        for column, what, resolution in (("limit m/s", "ballistic limit", BISECTION), ("absorbed J", "absorbed energy", 0.0)):
            for row in own if base else []:
                # Bars as long as the sphere's radius are shown, not judged.
                if row["yarns a bar"] < 4 and row is not base and row[column] == row[column]:
                    ratio = Estimate.quotient(mean_of(row, column, resolution), mean_of(base, column, resolution))
                    name = f"{plies:.0f} plies, damage rate {damage_rate:.0f} {length}, {row['yarns a bar']:g} yarns a bar"
                    found.setdefault((what, viscosity), []).append(Point(name, ratio, about(1, 0.1)))
        if length == "constant":
            damping = "no viscosity" if viscosity == "none" else "viscous"
            name = f"{plies:.0f} pl{'y' if plies == 1 else 'ies'}, damage rate {damage_rate:.0f}, {damping}"
            series.append(
                Series(name, [(row["yarns a bar"], row["absorbed J"] / (base or own[-1])["absorbed J"]) for row in own])
            )
    lacks = lambda viscosity: "damping: noise chooses which bars fail first" if viscosity == "none" else ""
    comparisons = [
        Comparison(
            f"{what} of a sheet over that with one yarn a bar, viscosity {viscosity}",
            "itself",
            "± 10 %",
            points,
            2,
            lacks(viscosity),
        )
        for (what, viscosity), points in found.items()
    ]
    drawing.draw(
        study.folder / "spacing.svg",
        "Absorbed energy at about twice the ballistic limit",
        "yarns per bar",
        "energy / energy with one yarn per bar",
        sorted(series, key=lambda line: -len(line.points)),
        "logarithmic x",
    )
    study.picture("spacing.svg", "validation_spacing.svg")
    value = lambda name, digits: (
        lambda row: (
            f"{row[name]:.{digits}f} ± {row[name + ': deviation'] / math.sqrt(row['hits']):.{digits}f}"
            if row[name] == row[name]
            else ""
        )
    )
    columns = [
        ("plies", 0),
        *page.same(["viscosity"], None),
        ("damage rate of one yarn a bar", "damage rate", 0),
        ("with the length of a bar", "damage rate and length", None),
    ]
    columns += [
        ("yarns a bar", 2),
        ("hits", 0),
        ("absorbed J", value("absorbed J", 2), None),
        ("limit m/s", value("limit m/s", 1), None),
        ("energy residual %", 2),
    ]
    return (
        comparisons,
        "## Convergence in the spacing\n\n" + page.table(rows, columns, 4) + "\n±: standard error of the mean.\n",
        True,
    )
