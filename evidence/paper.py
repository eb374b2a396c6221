"""Every figure of D. Powell, T. I. Zohdi, "Attachment mode performance of network-modeled ballistic fabric shielding", Composites
Part B 40 (2009) 451-460, that is a computation, beside what the paper says: report.html, and the tables of claims and verdicts.

After the first failure the model is chaotic, so every point is an ensemble: stochastic yarn with different seeds, uniform yarn
with impact velocities V0 (1 + k 1e-12). Figures 9, 11 and the right part of Fig. 3 are experiments without data in the paper; the
deformed sheets of Figs 10 and 12 are seen with `fabric run examples/scenes/sheet_10in_cylinder.toml --movie`.
"""

import math
from types import SimpleNamespace

import numpy
from fabric_kernel import drawing, yarn_of_fibrils, yarns_of_fibrils
from fabric_kernel.drawing import Series

from . import claims, page
from .paper_runs import (
    ATTACHMENTS,
    CORNERS,
    FOUR_SIDES,
    LARGE,
    SMALL,
    STOCHASTIC,
    SYMMETRIC,
    TWO_SIDES,
    UNIFORM,
    VELOCITIES,
    WOVEN,
    Runs,
    number,
)
from .statistics import Estimate, arrest_limit
from .study import SMOKE, clock

# Seed of the population of yarns; a multiple of the stretch just below, or just beyond, a rupture.
SEED, JUST = 1, 1e-9

RULE = (
    'Rule of the verdicts: a claim is read as a range that a quantity must lie in (column "read as"). '
    "The rows on where, in which order and at how many places sheets fail were worded after first results. "
    'A claim "agrees" if the whole 95 % interval lies inside the range. It "does not" if none of it does; otherwise it is '
    '"undecided". A claim about several energies or attachments agrees if all do, and does not if one does not. '
    "The intervals are not corrected for their number: of twenty true claims about one quantity each, one may come out wrong."
)
QUESTION = (
    "The paper says that uniform yarn over-predicts about twofold near the ballistic limit of the sheet held at its corners. "
    "It does not say where the washers of the 3 in sheet sit, how large they are, and whether its uniform sheet stayed "
    "symmetric. Nor does it say which energy is read and when, or whether a segment or a whole yarn gets a sample. The energy "
    "is what the projectile has lost (absorbed), or what rupture has dissipated (the work done by the yarn), or that with the "
    "strain energy. Below, the ratio uniform over stochastic under every combination of these readings, with its 95 % "
    "interval; in brackets how many of the uniform and of the stochastic runs were arrested. Where runs are arrested their "
    "absorbed energy is capped at the impact energy, so the ratio alone understates a difference; the ballistic limits are "
    "compared as well. A sheet that has not torn off by the end of its run is read at the end; the reading at 400 µs takes the "
    "end of runs that were over before. Mirror-symmetric sheets are read when detached at the latest: torn off evenly at all "
    "corners, they wrap the sphere and fly with it."
)
LIMITS = (
    "Runs arrested, of all runs at an impact energy; a run that its step limit ended does not count as arrested. The limit is "
    "the energy at which half of the runs are arrested (Spearman-Kärber, with the spacing of the energies in its 95 % interval). "
    "It needs an energy at which all are arrested and one at which none is."
)


def answer(study):
    micro = micro_scale(300 if study.effort == SMOKE else 10_000)
    runs = Runs(study)
    found = claims.of_micro(micro) + claims.of_attachments(runs) + claims.of_uniform(runs) + claims.of_map(runs)
    for claim in found:
        texts = [check.text() for check in claim.checks]
        print(
            f"{claim.verdict:15} {claim.claim}: "
            f"{f'{texts[0]}; and {len(texts) - 1} more' if len(texts) > 2 else '; '.join(texts)}"
        )
    study.write("points", point_rows(runs))
    report(study, runs, micro, found)
    text = f"{runs.scope}\n\n{RULE}\n\n{page.markdown(claims.HEADING, [claim.row() for claim in found], 6)}"
    study.table("paper_claims", "The paper's claims, and our answers", text)
    limits = page.markdown(*limits_table(runs), 2)
    text = f"{runs.scope}\n\n{QUESTION}\n\n{page.markdown(*map_table(runs), 4)}\n## Ballistic limits\n\n{LIMITS}\n\n{limits}"
    study.table("paper_map", "The map of the open question", text)


def stress(yarn, stretches):
    """Second Piola-Kirchhoff stress, GPa, of a yarn that is pulled monotonically."""
    alpha = numpy.concatenate([[1.0], yarn["alpha"]])[numpy.searchsorted(yarn["ruptures"], stretches)]
    return 1e-9 * yarn["modulus"] * alpha * 0.5 * (numpy.square(stretches) - 1)


def micro_scale(count):
    """A population of yarns drawn and fitted on one core, summed up; the work of a thousand of them, MJ/m^3, and the stress just
    beyond the critical stretch over that just below."""
    begin = clock()
    moduli, rates, misfits = yarns_of_fibrils(SEED, count).T
    micro = SimpleNamespace(seconds=clock() - begin, moduli=1e-9 * moduli, rates=rates, misfit=misfits.mean())
    yarns = [yarn_of_fibrils(SEED, k) for k in range(min(count, 1000))]
    micro.aligned, micro.yarns = yarn_of_fibrils(SEED, 0, straight=True), yarns[:3]
    micro.aligned_work, micro.aligned_left = 1e-6 * micro.aligned["work"], micro.aligned["left"]
    micro.work, micro.left = (
        Estimate.mean([scale * yarn[name] for yarn in yarns]) for name, scale in (("work", 1e-6), ("left", 1.0))
    )
    modulus, sd = micro.moduli.mean(), micro.moduli.std(ddof=1)
    slope, intercept = numpy.polyfit(micro.moduli, micro.rates, 1)
    residual, spread = (
        math.sqrt(((micro.rates - slope * micro.moduli - intercept) ** 2).sum() / (count - 2)),
        sd * math.sqrt(count - 1),
    )
    micro.modulus, micro.modulus_sd = Estimate.mean(micro.moduli), Estimate.large_sample_deviation(sd, count)
    micro.rate = Estimate.mean(micro.rates)
    micro.slope = Estimate.of_error(slope, residual / spread, count - 2)
    micro.intercept = Estimate.of_error(intercept, residual * math.sqrt(1 / count + (modulus / spread) ** 2), count - 2)
    micro.residual = Estimate.large_sample_deviation(residual, count - 1)
    return micro


READINGS = {
    "absorbed when detached, J": lambda run: run.at_detached(),
    "absorbed at the end, J": lambda run: run.absorbed,
    "residual velocity, m/s": lambda run: run.residual(),
    "peak fabric kinetic, J": lambda run: run.peak_kinetic,
    "peak strain, J": lambda run: run.peak_strain,
    "failed segments": lambda run: run.failed,
    "energy residual, part of the impact energy": lambda run: abs(run.audit),
}


def point_rows(runs):
    """A row for each ensemble: means with the ends of their 95 % intervals, least and greatest."""
    rows = []
    for point, ensemble in runs.by_point.items():
        row = {"sheet": point.sheet, "attachment": point.attachment, "washer": point.washer, "yarn": point.yarn}
        row |= {"impact, J or m/s": point.impact}
        row |= {
            "runs": len(ensemble),
            "arrested": sum(run.arrested for run in ensemble),
            "timeouts": sum(run.timeout for run in ensemble),
        }
        for name, value in READINGS.items():
            values = [value(run) for run in ensemble]
            row |= dict(
                zip(
                    (name, f"{name}: low", f"{name}: high", f"{name}: least", f"{name}: greatest"),
                    (*Estimate.mean(values), min(values), max(values)),
                )
            )
        rows.append(row)
    return rows


def report(study, runs, micro, found):
    """report.html, with all figures."""
    html, folder = page.Page("Powell and Zohdi (2009), reproduced"), study.folder

    def figure(name, caption, title, x, y, lines, *axes, **more):
        drawing.draw(folder / f"{name}.svg", title, x, y, lines, *axes, **more)
        html.figure(folder / f"{name}.svg", caption)

    html.text(runs.scope)
    audits = sorted(abs(run.audit) for run in runs.all)
    html.text(
        f"{len(runs.all)} runs, {sum(run.cpu for run in runs.all):.0f} s of processor time. The energy balance closes to "
        f"{100 * float(numpy.median(audits)):.2f} % of the impact energy in the median and {100 * audits[-1]:.1f} % in the "
        "worst run. That is a torn sheet that flutters for long. Loose fabric gains energy at the default step; the projectile "
        "does not notice."
    )
    html.section("Claims and answers")
    html.text(RULE)
    html.table(claims.HEADING, [claim.row() for claim in found], (1, 2, 3, 4, 5))
    html.section("Fibrils to yarn law (Figs 3, 5, 6)")
    fibrils(figure, micro)
    html.section("Residual against initial velocity (Fig. 13)")
    lines = [
        means(runs, kind, STOCHASTIC, VELOCITIES[study.effort], lambda run: run.residual(), kind, LARGE) for kind in ATTACHMENTS
    ]
    last = max(VELOCITIES[study.effort])
    figure(
        "figure_13",
        "The paper does not say how this sheet is held, so all three attachments are shown; 0 where the projectile is arrested.",
        "10 in sheet, cylinder: residual against initial velocity",
        "initial velocity (m/s)",
        "residual velocity (m/s)",
        [*lines, Series("no fabric", [(0, 0), (last, last)], "dashed")],
        "from zero",
    )
    html.section("Absorbed energy and attachment (Fig. 14)")
    energy_axes = "impact energy (J)", "absorbed energy (J)"
    for file, when, value in (
        ("figure_14", "when the last contact lost its supports", lambda run: run.at_detached()),
        ("figure_14_end", "when the projectile was arrested or had left", lambda run: run.absorbed),
    ):
        lines = [means(runs, kind, STOCHASTIC, runs.energies, value, kind) for kind in ATTACHMENTS]
        caption = f"Fig. 14, read {when}. Below the ballistic limit everything is absorbed."
        figure(file, caption, f"3 in sheet, sphere: energy absorbed {when}", *energy_axes, lines, "logarithmic x")
    html.section("Energy histories (Figs 15 to 17)")
    for fig, kind in ((15, CORNERS), (16, TWO_SIDES), (17, FOUR_SIDES)):
        for energy in runs.history_energies:
            name, caption = (
                f"3 in sheet, {kind}, {number(energy)} J: where the energy is",
                f"Fig. {fig}: mean of the runs up to their median end.",
            )
            lines = history(runs.of(kind, STOCHASTIC, energy))
            figure(f"figure_{fig}_{number(energy)}J", caption, name, "time (µs)", "energy (J)", lines, "from zero")
    html.section("Uniform against stochastic yarn (Figs 18 to 20)")
    for fig, kind in ((18, CORNERS), (19, TWO_SIDES), (20, FOUR_SIDES)):
        lines = [means(runs, kind, yarn, runs.energies, lambda run: run.at_detached(), yarn) for yarn in (STOCHASTIC, UNIFORM)]
        title = f"3 in sheet, {kind}: uniform against stochastic yarn, when detached"
        figure(f"figure_{fig}", f"Fig. {fig}.", title, *energy_axes, lines, "logarithmic x")
    html.section("The open question: uniform yarn at the corners, near the limit")
    html.text(QUESTION)
    for file, uniform, reading in (
        ("map_whole", UNIFORM, "detached"),
        ("map_symmetric", SYMMETRIC, "detached"),
        ("map_dissipated", SYMMETRIC, "dissipated, detached"),
    ):
        caption, levels = (
            "95 % intervals; points are shifted sideways a little so that they do not overlap.",
            [("no difference", 1.0), ("twofold", 2.0)],
        )
        title, lines = f"{uniform} over stochastic yarn, read: {reading}", ratios(runs, uniform, reading)
        figure(file, caption, title, energy_axes[0], "ratio of energies", lines, "from zero", levels=levels)
    html.table(*map_table(runs), (1, 2, 3))
    html.heading("Ballistic limits")
    html.text(LIMITS)
    html.table(*limits_table(runs), (1,))
    html.heading("Every point")
    of = lambda row, name: Estimate(row[name], row[f"{name}: low"], row[f"{name}: high"]).text(2)
    names = ["sheet", "attachment", "washer", "yarn", "impact, J or m/s", "runs", "arrested", "timeouts"]
    html.table(
        [*names, *READINGS],
        [[*(row[name] for name in names), *(of(row, name) for name in READINGS)] for row in point_rows(runs)],
        (1, 2, 3),
    )
    html.write(folder / "report.html")


def fibrils(figure, micro):
    critical, count = micro.aligned["critical_stretch"], len(micro.moduli)
    ends, grid = [1.0, critical - JUST, critical + JUST, 1.08], 1 + 0.08 * numpy.arange(1601) / 1600
    lines = [Series("aligned fibrils", list(zip(ends, stress(micro.aligned, ends))), "line")]
    lines += [
        Series(f"misaligned, yarn {k}", list(zip(grid, stress(yarn, grid))), "line") for k, yarn in enumerate(micro.yarns, 1)
    ]
    figure(
        "figure_3",
        "Fig. 3 left. An aligned yarn loses all load at once; misaligned fibrils break one after another. Work to rupture: "
        f"aligned {micro.aligned_work:.1f} MJ/m³, misaligned {micro.work.text(2)} MJ/m³.",
        "Stress of one yarn under displacement control",
        "stretch of the yarn",
        "second Piola-Kirchhoff stress (GPa)",
        lines,
        "from zero",
    )
    first = micro.yarns[0]
    stairs = list(zip(numpy.repeat(first["ruptures"], 2), numpy.repeat(numpy.concatenate([[1.0], first["alpha"]]), 2)[1:-1]))
    stretches, lines = numpy.linspace(critical, first["ruptures"][-1], 301), [Series("fibrils", [(1.025, 1.0), *stairs], "line")]
    for (rate, a, b), name, style in zip(first["laws"], ("λ = {:.1f}", "λ = {:.1f}, A = {:.3f}, B = {:.4f}"), ("line", "dashed")):
        alpha = numpy.maximum(a * (numpy.exp(-rate * (stretches - critical)) - b), 0)
        lines.append(Series(name.format(rate, a, b), list(zip(stretches, alpha)), style))
    figure(
        "figure_3_staircase",
        "The same rupture sequence as a staircase of α, with the paper's one-parameter law exp(−λ(U − U_c)) and, dashed, the "
        "law with A and B "
        f"free. The paper's law misses the staircase by {micro.misfit:.3f} (root mean square, mean of all yarns).",
        "Rupture sequence of one yarn and the fitted law",
        "stretch of the yarn",
        "damage variable α",
        lines,
        "from zero",
    )
    centre, sd, width = micro.modulus.value, micro.modulus_sd.value, 0.25
    edges = numpy.arange(math.floor((centre - 4.5 * sd) / width), math.ceil((centre + 4.5 * sd) / width) + 1) * width
    outline = list(zip(numpy.repeat(edges, 2)[1:-1], numpy.repeat(numpy.histogram(micro.moduli, edges)[0], 2)))
    normal = [
        (x, count * width / (2.04 * math.sqrt(math.tau)) * math.exp(-0.5 * ((x - 140.21) / 2.04) ** 2))
        for x in numpy.linspace(edges[0], edges[-1], 201)
    ]
    expected = [1e-9 * value for value in first["expected_modulus"]]
    figure(
        "figure_5",
        f"Fig. 5. Mean {micro.modulus.text(3)} GPa, standard deviation {micro.modulus_sd.text(3)} GPa (paper: 140.21 and 2.04). "
        f"Without sampling error, by "
        "quadrature over the Gaussian: {:.3f} and {:.3f} GPa.".format(*expected),
        f"Young's modulus of {count} yarns",
        "modulus (GPa)",
        "yarns in 0.25 GPa",
        [Series("yarns", outline, "line"), Series("paper: normal, 140.21 ± 2.04", normal, "dashed")],
        "from zero",
    )
    dots = list(zip(micro.moduli, micro.rates))[:2000]  # More hide one another.
    line = lambda slope, intercept: [(x, slope * x + intercept) for x in (centre - 4 * sd, centre + 4 * sd)]
    figure(
        "figure_6",
        f"Fig. 6. Regression over all: λ = {micro.slope.text(3)} E/GPa + {micro.intercept.text(1)}, standard deviation about "
        f"the line {micro.residual.text(2)} "
        f"(paper: 7.91, −878.46, 8.35). Drawing and fitting took {micro.seconds:.2f} s on one core.",
        "Damage rate against modulus",
        "modulus (GPa)",
        "damage rate λ",
        [
            Series(f"{len(dots)} yarns", dots, "dots"),
            Series("regression line", line(micro.slope.value, micro.intercept.value), "line"),
            Series("the paper's line", line(7.91, -878.46), "dashed"),
        ],
    )


def means(runs, kind, yarn, impacts, value, name, sheet=SMALL):
    """A series of ensemble means with 95 % intervals."""
    found = [(impact, Estimate.mean([value(run) for run in runs.of(kind, yarn, impact, sheet=sheet)])) for impact in impacts]
    return Series(name, [(at, mean.value) for at, mean in found], bars=[(mean.low, mean.high) for _, mean in found])


def history(ensemble):
    """Energies over time, mean of the ensemble on a common grid; a run that has ended keeps its last values."""
    grid = numpy.linspace(0, sorted(run.time for run in ensemble)[len(ensemble) // 2], 201)
    names = {
        "lost by the projectile": "lost",
        "fabric kinetic": "kinetic",
        "strain": "strain",
        "dissipated by rupture": "dissipated",
        "contact loss": "loss",
    }
    value = lambda key: numpy.mean([numpy.interp(grid, run.history["t"], run.history[key]) for run in ensemble], axis=0)
    return [Series(name, list(zip(1e6 * grid, value(key))), "dashed" if key == "loss" else "line") for name, key in names.items()]


def ratios(runs, uniform, reading):
    lines = []
    for place, washer in enumerate(runs.washers):
        chosen = [cell for cell in claims.cells(runs) if cell[:4] == (washer, uniform, STOCHASTIC, reading)]
        # Side by side, so that the error bars do not hide one another.
        lines.append(
            Series(
                washer,
                [(cell.energy + 0.12 * (place - 2), cell.ratio.value) for cell in chosen],
                bars=[(cell.ratio.low, cell.ratio.high) for cell in chosen],
            )
        )
    return lines


def map_table(runs):
    heading = ["washers", "uniform", "draw", "read", *(f"{number(energy)} J" for energy in runs.map_energies)]
    rows = {}
    for cell in claims.cells(runs):
        rows.setdefault(cell[:4], {})[cell.energy] = cell.text()
    words = lambda name: [
        name[0],
        "whole" if name[1] == UNIFORM else "symmetric",
        "segment" if name[2] == STOCHASTIC else "yarn",
        name[3],
    ]
    return heading, [words(name) + [texts.get(energy, "") for energy in runs.map_energies] for name, texts in rows.items()]


def limits_table(runs):
    """How many runs were arrested, and the limits."""
    # Figs 14 and 18 have more energies for the preset washers.
    energies = sorted({*runs.map_energies, *(energy for energy in runs.energies if energy < runs.map_energies[0])})
    heading = ["washers", "yarn", *(f"{number(energy)} J" for energy in energies), "limit (J)", "over stochastic"]
    rows = []
    for washer in runs.washers:
        below = None
        for yarn in (STOCHASTIC, WOVEN, UNIFORM, SYMMETRIC):
            ensembles = {energy: runs.of(CORNERS, yarn, energy, washer) for energy in energies}
            counts = {
                energy: (energy, sum(run.arrested for run in part), len(part)) for energy, part in ensembles.items() if part
            }
            if not counts:
                continue
            limit = arrest_limit(list(counts.values()))
            texts = ["{1}/{2}".format(*counts[energy]) if energy in counts else "" for energy in energies]
            over = Estimate.quotient(limit, below).text(2) if limit and below else ""
            rows.append([washer, yarn, *texts, limit.text(1) if limit else "not bracketed", over])
            below = limit if yarn == STOCHASTIC else below
    return heading, rows
