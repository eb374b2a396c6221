"""Every figure of D. Powell, T. I. Zohdi, Composites Part B 40 (2009) 451-460, that is a computation, beside what the paper says."""

import json
import math
from types import SimpleNamespace

import numpy

from evidence import page, plot
from . import claims, sheets
from evidence.plot import Series
from .runs import ATTACHMENTS, CORNERS, FOUR_SIDES, LARGE, SMALL, STOCHASTIC, SYMMETRIC, TWO_SIDES, UNIFORM, WOVEN, Runs, number
from evidence.statistics import Estimate, arrest_limit, mean

RULE = (
    'Rule of the verdicts: a claim is read as a range that a quantity must lie in (column "read as"; the rows on where, in which order '
    'and at how many places sheets fail were worded after first results). "Agrees" if the whole 95 % interval lies inside the range, '
    '"does not" if none of it does, otherwise "cannot be told". A claim about several energies or attachments agrees if all do, and '
    "does not if one does not. The intervals are not corrected for their number: of twenty true claims about one quantity each, one may "
    "come out wrong."
)
QUESTION = (
    "The paper says that uniform yarn over-predicts about twofold near the ballistic limit of the sheet held at its corners. It does not "
    "say where the washers of the 3 in sheet sit, how large they are, whether its uniform sheet stayed symmetric, which energy is read "
    "and when, or whether a segment or a whole yarn gets a draw. The energy is what the projectile has lost (absorbed), or what rupture "
    "has dissipated (the work done by the yarn), or that with the strain energy. Below, the ratio uniform over stochastic under every "
    "combination of these readings, with its 95 % interval; in brackets how many of the uniform and of the stochastic runs were "
    "arrested. Where runs are arrested their absorbed energy is capped at the impact energy, so the ratio alone understates a "
    "difference; the ballistic limits are compared as well. A sheet that has not torn off by the end of its run is read at the end; the "
    "reading at 400 µs takes the end of runs that were over before. Mirror-symmetric sheets are read when detached at the latest: torn "
    "off evenly at all corners, they wrap the sphere and fly with it."
)
LIMITS = (
    "Runs arrested, of all runs at an impact energy; a run that its step limit ended does not count as arrested. The limit is the energy "
    "at which half of the runs are arrested (Spearman-Kärber, with the spacing of the energies in its 95 % interval); it needs an energy "
    "at which all are arrested and one at which none is."
)


def report(folder, docs=None):
    runs, micro = Runs(folder), micro_scale(folder)
    found = []
    if runs.wants("3", "5", "6"):
        found += claims.of_micro(micro)
    if runs.wants("14", "15", "16", "17"):
        found += claims.of_attachments(runs)
    if runs.wants("18", "19", "20"):
        found += claims.of_uniform(runs)
    if runs.wants("map"):
        found += claims.of_map(runs)
    for claim in found:
        texts = [check.text() for check in claim.checks]
        ours = f"{texts[0]}; and {len(texts) - 1} more" if len(texts) > 2 else "; ".join(texts)
        print(f"{claim.verdict:15} {claim.claim}: {ours}")

    html = page.Page("Powell and Zohdi (2009), reproduced")
    introduction(html, runs)
    if found:
        html.section("Claims and answers")
        html.text(RULE)
        html.table(claims.HEADING, [claim.row() for claim in found], (1, 2, 3, 4, 5))
    micro_section(html, runs, micro, folder)
    macro_sections(html, runs, folder)
    points_csv(runs, folder / "points.csv")
    if runs.frames:
        sheets.vtk_series(folder, runs.frames)
    html.write(folder / "report.html")
    if docs:
        command = "python3 -m reports paper --docs docs"
        text = f"{runs.scope()}\n\n{RULE}\n\n{page.markdown(claims.HEADING, [claim.row() for claim in found], 6)}"
        page.write_table(docs, "paper_claims", "The paper's claims, and our answers", command, text)
        limits = page.markdown(*limits_table(runs), 2)
        text = f"{runs.scope()}\n\n{QUESTION}\n\n{page.markdown(*map_table(runs), 4)}\n## Ballistic limits\n\n{LIMITS}\n\n{limits}"
        page.write_table(docs, "paper_map", "The map of the open question", command, text)


def micro_scale(folder):
    """The population of yarns, summed up."""
    micro = SimpleNamespace(**json.loads((folder / "micro.json").read_text()))
    rows = page.rows_of(folder / "yarns.csv")
    micro.moduli, micro.rates, misfits = (numpy.array([float(row[key]) for row in rows]) for key in ("modulus_gpa", "damage_rate", "misfit"))
    n, modulus, sd = len(rows), micro.moduli.mean(), micro.moduli.std(ddof=1)
    slope, intercept = numpy.polyfit(micro.moduli, micro.rates, 1)
    residual = math.sqrt(((micro.rates - slope * micro.moduli - intercept) ** 2).sum() / (n - 2))
    spread = sd * math.sqrt(n - 1)
    micro.modulus, micro.modulus_sd = Estimate.mean(micro.moduli), Estimate.large_sample_deviation(sd, n)
    micro.rate, micro.misfit = Estimate.mean(micro.rates), misfits.mean()
    micro.slope = Estimate.of_error(slope, residual / spread, n - 2)
    micro.intercept = Estimate.of_error(intercept, residual * math.sqrt(1 / n + (modulus / spread) ** 2), n - 2)
    micro.residual = Estimate.large_sample_deviation(residual, n - 1)
    micro.work, micro.left = Estimate.mean(micro.work), Estimate.mean(micro.left)
    return micro


def introduction(html, runs):
    html.text(
        "D. Powell, T. I. Zohdi, Attachment mode performance of network-modeled ballistic fabric shielding, Composites Part B 40 (2009) "
        "451-460. Every figure of the paper that is a computation, computed anew, beside what the paper says of it."
    )
    html.text(
        "The model is chaotic after the first yarn fails: single runs prove nothing. Every point is the mean of an ensemble with its 95 % "
        "interval (Student's t): stochastic yarn with different seeds, uniform yarn with impact velocities V0 (1 + k 1e-12)."
    )
    if runs.left_out:
        html.text(runs.left_out)
    if runs.missing:
        html.text(runs.lacking())
    audits = sorted(abs(run.audit) for run in runs.all)
    late = {}
    for run in runs.all:
        if run.timeout:
            point = run.name.rsplit(", run ", 1)[0]
            late[point] = late.get(point, 0) + 1
    text = "; ".join(f"{point} ({count})" for point, count in sorted(late.items())) or "none"
    if audits:
        html.text(
            f"{len(runs.all)} runs, {sum(run.cpu for run in runs.all):.0f} s of processor time. The energy balance closes to "
            f"{100 * float(numpy.median(audits)):.2f} % of the impact energy in the median and {100 * audits[-1]:.1f} % in the worst run, which is "
            "a torn sheet that flutters for long: loose fabric gains energy at the default step, the projectile does not notice. Runs that "
            f"their step limit ended (TIMEOUT): {text}."
        )


def micro_section(html, runs, micro, out):
    if not runs.wants("3", "5", "6"):
        return
    html.section("Fibrils to yarn law (Figs 3, 5, 6)")
    if runs.wants("3"):
        names = ["aligned fibrils", *(f"misaligned, yarn {k}" for k in (1, 2, 3))]
        plot.draw(
            out / "figure_3.svg", "Stress of one yarn under displacement control", "stretch of the yarn",
            "second Piola-Kirchhoff stress (GPa)", [Series(name, points, "line") for name, points in zip(names, micro.stresses)], "from zero",
        )
        html.figure(
            out / "figure_3.svg",
            "Fig. 3 left. An aligned yarn loses all load at once; misaligned fibrils break one after another. Work to rupture: aligned "
            f"{micro.aligned_work:.1f} MJ/m³, misaligned {micro.work.text(2)} MJ/m³ (mean of 1000 yarns, 95 % interval).",
        )
        stretches = numpy.linspace(micro.critical_stretch, micro.staircase[-1][0], 301)
        lines = [Series(f"{micro.fibrils} fibrils", micro.staircase, "line")]
        for law, constants, style in zip(micro.laws, ("", ", A = {a:.3f}, B = {b:.4f}"), ("line", "dashed")):
            alpha = numpy.maximum(law["a"] * (numpy.exp(-law["damage_rate"] * (stretches - micro.critical_stretch)) - law["b"]), 0)
            lines.append(Series(f"λ = {law['damage_rate']:.1f}" + constants.format(**law), list(zip(stretches, alpha)), style))
        plot.draw(
            out / "figure_3_staircase.svg", "Rupture sequence of one yarn and the fitted law", "stretch of the yarn", "damage variable α",
            lines, "from zero",
        )
        html.figure(
            out / "figure_3_staircase.svg",
            "The same rupture sequence as a staircase of α, with the paper's one-parameter law exp(−λ(U − U_c)) and, dashed, the law with "
            f"A and B free. The paper's law misses the staircase by {micro.misfit:.3f} (root mean square, mean of all yarns): early damage "
            "comes too slowly.",
        )
        html.no_data("Fig. 3 right is an experiment: no data in the paper.")
    centre, sd = micro.modulus.value, micro.modulus_sd.value
    if runs.wants("5"):
        width, count = 0.25, len(micro.moduli)
        edges = numpy.arange(math.floor((centre - 4.5 * sd) / width), math.ceil((centre + 4.5 * sd) / width) + 1) * width
        heights, _ = numpy.histogram(micro.moduli, edges)
        outline = list(zip(numpy.repeat(edges, 2)[1:-1], numpy.repeat(heights, 2)))
        grid = numpy.linspace(edges[0], edges[-1], 201)
        normal = count * width / (2.04 * math.sqrt(math.tau)) * numpy.exp(-0.5 * ((grid - 140.21) / 2.04) ** 2)
        plot.draw(
            out / "figure_5.svg", f"Young's modulus of {count} yarns", "modulus (GPa)", "yarns in 0.25 GPa",
            [Series("yarns", outline, "line"), Series("paper: normal, 140.21 ± 2.04", list(zip(grid, normal)), "dashed")], "from zero",
        )
        html.figure(
            out / "figure_5.svg",
            f"Fig. 5. Mean {micro.modulus.text(3)} GPa, standard deviation {micro.modulus_sd.text(3)} GPa (paper: 140.21 and 2.04). Without "
            "sampling error, by quadrature over the Gaussian: {:.3f} and {:.3f} GPa.".format(*micro.expected_modulus_gpa),
        )
    if runs.wants("6"):
        dots = list(zip(micro.moduli, micro.rates))[:2000]  # More hide one another.
        line = lambda slope, intercept: [(x, slope * x + intercept) for x in (centre - 4 * sd, centre + 4 * sd)]
        plot.draw(
            out / "figure_6.svg", "Damage rate against modulus", "modulus (GPa)", "damage rate λ",
            [
                Series(f"{len(dots)} yarns", dots, "dots"), Series("regression line", line(micro.slope.value, micro.intercept.value), "line"),
                Series("the paper's line", line(7.91, -878.46), "dashed"),
            ],
        )
        html.figure(
            out / "figure_6.svg",
            f"Fig. 6. The first {len(dots)} of {len(micro.moduli)} yarns. Regression over all: λ = {micro.slope.text(3)} E/GPa + "
            f"{micro.intercept.text(1)}, standard deviation about the line {micro.residual.text(2)} (paper: 7.91, −878.46, 8.35). Drawing and "
            f"fitting took {micro.seconds:.2f} s on one core.",
        )


def means(name, points, x, value):
    """A series of ensemble means with 95 % intervals."""
    estimates = [(point[x], Estimate.mean([value(run) for run in point["runs"]])) for point in points if point["runs"]]
    return Series(name, [(at, mean.value) for at, mean in estimates], bars=[(mean.low, mean.high) for _, mean in estimates])


def macro_sections(html, runs, out):
    each = lambda sheet, attachment, yarn: [
        {"impact_j": e, "impact_m_per_s": v, "runs": runs.of(attachment, yarn, e, sheet=sheet)}
        for e, v in sorted({
            (point["impact_j"], point["impact_m_per_s"]) for point in runs.points
            if (point["sheet"], point["attachment"], point["yarn"], point["washer"]) == (sheet, attachment, yarn, runs.washers[0])
            and (sheet == LARGE or point["impact_j"] in runs.energies)
        })
    ]
    count = lambda sheet, yarn: max((len(point["runs"]) for kind in ATTACHMENTS for point in each(sheet, kind, yarn)), default=0)
    for figure in ("9", "11"):
        if runs.wants(figure):
            html.no_data(f"Fig. {figure} is an experiment: no data in the paper.")
    if runs.wants("10", "12"):
        html.section("Deformed 10 in sheets under the cylinder (Figs 10, 12)")
        pictures(html, runs, out)
    if runs.wants("13"):
        html.section("Residual against initial velocity (Fig. 13)")
        lines = [means(kind, each(LARGE, kind, STOCHASTIC), "impact_m_per_s", lambda run: run.residual()) for kind in ATTACHMENTS]
        last = max(runs.velocities)
        lines.append(Series("no fabric", [(0, 0), (last, last)], "dashed"))
        plot.draw(
            out / "figure_13.svg", "10 in sheet, cylinder: residual against initial velocity", "initial velocity (m/s)",
            "residual velocity (m/s)", lines, "from zero",
        )
        html.figure(
            out / "figure_13.svg",
            f"Fig. 13. The paper does not say how this sheet is held, so all three attachments are shown. Mean of {count(LARGE, STOCHASTIC)} seeds "
            'with 95 % interval; 0 where the projectile is arrested. Where a run ended by its step limit (column "timeouts"), the torn sheet '
            "still clings to the cylinder and slows it a little more.",
        )
        table(html, runs, "10 in, stochastic yarn", [(kind, f"{number(p['impact_m_per_s'])} m/s", p["runs"]) for kind in ATTACHMENTS for p in each(LARGE, kind, STOCHASTIC)])
    small = lambda yarn: [(kind, f"{number(p['impact_j'])} J", p["runs"]) for kind in ATTACHMENTS for p in each(SMALL, kind, yarn)]
    if runs.wants("14"):
        html.section("Absorbed energy and attachment (Fig. 14)")
        for file, when, value in (
            ("figure_14.svg", "when the last contact lost its supports", lambda run: run.at_detached()),
            ("figure_14_end.svg", "when the projectile was arrested or had left", lambda run: run.absorbed),
        ):
            lines = [means(kind, each(SMALL, kind, STOCHASTIC), "impact_j", value) for kind in ATTACHMENTS]
            plot.draw(out / file, f"3 in sheet, sphere: energy absorbed {when}", "impact energy (J)", "absorbed energy (J)", lines, "logarithmic x")
            html.figure(
                out / file,
                f"Fig. 14, read {when}. Stochastic yarn, mean of {count(SMALL, STOCHASTIC)} seeds with 95 % interval. Below the ballistic limit "
                "everything is absorbed.",
            )
        table(html, runs, "3 in, stochastic yarn", small(STOCHASTIC))
    for figure, kind in ((15, CORNERS), (16, TWO_SIDES), (17, FOUR_SIDES)):
        if runs.wants(str(figure)):
            html.section(f"Energy histories (Fig. {figure})")
            histories(html, runs, out, figure, kind)
    for figure, kind in ((18, CORNERS), (19, TWO_SIDES), (20, FOUR_SIDES)):
        if runs.wants(str(figure)):
            html.section(f"Uniform against stochastic yarn (Fig. {figure})")
            lines = [means(yarn, each(SMALL, kind, yarn), "impact_j", lambda run: run.at_detached()) for yarn in (STOCHASTIC, UNIFORM)]
            path = out / f"figure_{figure}.svg"
            plot.draw(path, f"3 in sheet, {kind}: uniform against stochastic yarn", "impact energy (J)", "absorbed energy when detached (J)", lines, "logarithmic x")
            html.figure(
                path,
                f"Fig. {figure}. Mean of {count(SMALL, UNIFORM)} runs with 95 % interval: stochastic yarn with different seeds, uniform yarn with "
                "impact velocities that differ by 1e-12.",
            )
    if runs.wants("18", "19", "20"):
        table(html, runs, "3 in, uniform yarn", small(UNIFORM))
    if runs.wants("map"):
        html.section("The open question: uniform yarn at the corners, near the limit")
        open_question(html, runs, out)


def pictures(html, runs, out):
    """Figs 10 and 12: a row of side views over a row of damage maps for each run."""
    by_run = {}
    for about in runs.pictures:
        by_run.setdefault(about["name"], []).append(sheets.Sheet(out, about))
    for number_of, (name, taken) in enumerate(by_run.items()):
        html.heading(name)
        figure, axes = plot.matplotlib.pyplot.subplots(2, len(taken), figsize=(12.6, 7.2), layout="constrained", height_ratios=[3, 4])
        for (above, below), sheet in zip(axes.T, taken):
            sheet.draw_side(above)
            sheet.draw_damage(below)
            above.set_title(f"{1e6 * sheet.time:.0f} µs, from the side: {1e3 * sheet.deflection():.0f} mm deep", fontsize=10)
            below.set_title(f"damage: {sheet.failed()} segments failed", fontsize=10)
            for axis in (above, below):
                axis.set_axis_off()
        path = out / f"figure_10_12_{number_of}.png"
        plot.save(figure, path)
        html.figure(path, "Yarns in grey blue, damaged ones yellow to red, failed ones dark red; held nodes grey.")


def histories(html, runs, out, figure, kind):
    """Figs 15 to 17: energies over time, mean of the ensemble on a common grid; a run that has ended keeps its last values."""
    for energy in runs.history_energies:
        ensemble = runs.of(kind, STOCHASTIC, energy)
        if not ensemble:
            continue
        grid = numpy.linspace(0, sorted(run.time for run in ensemble)[len(ensemble) // 2], 201)
        lines = []
        for name, key, style in (
            ("lost by the projectile", "lost", "line"), ("fabric kinetic", "kinetic", "line"), ("strain", "strain", "line"),
            ("dissipated by rupture", "dissipated", "line"), ("contact loss", "loss", "dashed"),
        ):
            values = numpy.mean([numpy.interp(grid, run.history["t"], run.history[key]) for run in ensemble], axis=0)
            lines.append(Series(name, list(zip(1e6 * grid, values)), style))
        path = out / f"figure_{figure}_{number(energy)}J.svg"
        plot.draw(path, f"3 in sheet, {kind}, {number(energy)} J: where the energy is", "time (µs)", "energy (J)", lines, "from zero")
        kinetic, strain = (Estimate.mean([getattr(run, key) for run in ensemble]).text(2) for key in ("peak_kinetic", "peak_strain"))
        html.figure(
            path,
            f"Fig. {figure}, {number(energy)} J: mean of {len(ensemble)} runs up to their median end. Largest fabric kinetic energy {kinetic} J, "
            f"largest strain energy {strain} J (means of the runs' own largest values, 95 % interval).",
        )


def table(html, runs, name, points):
    """Absorbed energy with interval and range, residual velocity, peaks, arrests."""
    heading = [
        name, "runs", "arrested", "timeouts", "absorbed, detached (J)", "range", "absorbed, end (J)", "range", "residual (m/s)",
        "peak fabric kinetic (J)", "peak strain (J)", "failed",
    ]
    rows = []
    for kind, impact, ensemble in points:
        if not ensemble:
            continue
        of = lambda value, digits=2: Estimate.mean([value(run) for run in ensemble]).text(digits)
        spread = lambda value: "{:.2f} to {:.2f}".format(min(map(value, ensemble)), max(map(value, ensemble)))
        detached, end = (lambda run: run.at_detached()), (lambda run: run.absorbed)
        rows.append([
            f"{kind}, {impact}", len(ensemble), sum(run.arrested for run in ensemble), sum(run.timeout for run in ensemble), of(detached),
            spread(detached), of(end), spread(end), of(lambda run: run.residual(), 1), of(lambda run: run.peak_kinetic),
            of(lambda run: run.peak_strain), f"{mean([run.failed for run in ensemble]):.0f}",
        ])
    html.table(heading, rows)


def points_csv(runs, path):
    """points.csv: energies in J, velocities in m/s, means with the ends of their 95 % intervals."""
    readings = {
        "absorbed_at_detached": lambda run: run.at_detached(), "absorbed_at_end": lambda run: run.absorbed, "residual_velocity": lambda run: run.residual(),
        "peak_fabric_kinetic": lambda run: run.peak_kinetic, "peak_strain": lambda run: run.peak_strain, "failed_segments": lambda run: run.failed,
        "energy_residual_part": lambda run: abs(run.audit),
    }
    columns = ["sheet", "attachment", "washer", "yarn", "impact_j", "impact_m_per_s"]
    with open(path, "w", newline="") as file:
        table = page.csv.writer(file)
        table.writerow([*columns, "runs", "arrested", "timeouts", *(f"{name}{end}" for name in readings for end in ("", "_low", "_high", "_least", "_greatest"))])
        for point in runs.points:
            ensemble = point["runs"]
            if ensemble:
                row = [point[column] for column in columns] + [len(ensemble), sum(run.arrested for run in ensemble), sum(run.timeout for run in ensemble)]
                for value in readings.values():
                    values = [value(run) for run in ensemble]
                    row += [*Estimate.mean(values), min(values), max(values)]
                table.writerow(row)


def open_question(html, runs, out):
    html.text(QUESTION)
    if not runs.left_out:
        html.text(
            "Left out: energies other than 10, 15 J for washers that are not the preset ones, and one draw per yarn for all washers but the "
            "preset ones."
        )
    every = claims.cells(runs)
    for file, uniform, reading, title in (
        ("map_whole.svg", UNIFORM, "detached", "Whole uniform sheet over stochastic, absorbed when detached"),
        ("map_symmetric.svg", SYMMETRIC, "detached", "Mirror-symmetric uniform sheet over stochastic, absorbed when detached"),
        ("map_dissipated.svg", SYMMETRIC, "dissipated, detached", "Mirror-symmetric uniform sheet over stochastic, dissipated when detached"),
    ):
        lines = []
        for place, washer in enumerate(runs.washers):
            chosen = [cell for cell in every if cell[:4] == (washer, uniform, STOCHASTIC, reading)]
            # Side by side, so that the error bars do not hide one another.
            points = [(cell.energy + 0.12 * (place - 2), cell.ratio.value) for cell in chosen]
            lines.append(Series(washer, points, bars=[(cell.ratio.low, cell.ratio.high) for cell in chosen]))
        levels = [("no difference", 1.0), ("twofold", 2.0)]
        plot.draw(out / file, title, "impact energy (J)", "ratio of energies", lines, "from zero", levels=levels)
        html.figure(out / file, f"{title}. 95 % intervals; points are shifted sideways a little to tell them apart.")
    html.table(*map_table(runs), (1, 2, 3))
    html.heading("Ballistic limits")
    html.text(LIMITS)
    html.table(*limits_table(runs), (1,))
    with open(out / "map.csv", "w", newline="") as file:
        table = page.csv.writer(file)
        table.writerow(["washer", "uniform", "stochastic", "read_at", "impact_j", "ratio", "ratio_low", "ratio_high", "uniform_arrested", "stochastic_arrested", "verdict"])
        table.writerows([*cell[:5], *cell.ratio, *cell.arrested, cell.ratio.verdict(claims.TWOFOLD)] for cell in every)


def map_table(runs):
    heading = ["washers", "uniform", "draw", "read", *(f"{number(energy)} J" for energy in runs.map_energies)]
    rows = {}
    for cell in claims.cells(runs):
        rows.setdefault(cell[:4], {})[cell.energy] = cell.text()
    words = lambda name: [name[0], "whole" if name[1] == UNIFORM else "symmetric", "segment" if name[2] == STOCHASTIC else "yarn", name[3]]
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
            counts = {energy: (energy, sum(run.arrested for run in part), len(part)) for energy, part in ensembles.items() if part}
            if not counts:
                continue
            limit = arrest_limit(list(counts.values()))
            texts = ["{1}/{2}".format(*counts[energy]) if energy in counts else "" for energy in energies]
            over = Estimate.quotient(limit, below).text(2) if limit and below else ""
            rows.append([washer, yarn, *texts, limit.text(1) if limit else "not bracketed", over])
            below = limit if yarn == STOCHASTIC else below
    return heading, rows
