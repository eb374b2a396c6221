"""Error over run time: work-precision diagrams, Pareto fronts, and the tables behind docs/accuracy.md."""

import json
import math
import shutil

from . import front, page, plot
from .plot import Series

NODE_STEPS = "node-steps (force evaluations)"
# Pictures that docs/accuracy.md shows.
PICTURES = [
    "smooth_position_steps", "overshoot_strain", "four_uniform_absorbed_steps", "four_uniform_velocity_steps", "four_uniform_residual_steps",
    "corners_uniform_absorbed_steps", "coupling_velocity", "coupling_more_velocity", "coupling_interface", "runs_absorbed_steps",
]


def report(folder, docs=None):
    about = json.loads((folder / "error-time.json").read_text())
    command = f"fabric-study error-time{about['effort']}` and `python3 -m reports error-time --docs docs"
    seconds = f"CPU seconds are {about['clock']} of one thread on {about['machine']}; everything else is the same to the bit on every machine.\n\n"
    for name, (title, write) in PARTS.items():
        rows = [{key: read(value) for key, value in row.items()} for row in page.rows_of(folder / f"{name}.csv", needed=False)]
        if not rows:
            continue
        text = write(folder, rows)
        print(f"\n{title}\n\n{text}")
        if docs:
            page.write_table(docs, f"accuracy_{name}", title, command, (seconds if "CPU" in text else "") + text)
    for name in PICTURES if docs else []:
        if (folder / f"{name}.svg").exists():
            (docs / "images").mkdir(parents=True, exist_ok=True)
            shutil.copy(folder / f"{name}.svg", docs / "images" / f"accuracy_{name}.svg")


def read(text):
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text or math.nan


def shown(value, digits):
    """digits: of a fixed number; "e2" for a power of ten with two; None for words."""
    if isinstance(value, str) or not math.isfinite(value):
        return value if isinstance(value, str) else ""
    return page.power(value, int(digits[1:])) if isinstance(digits, str) else f"{value:.{digits}f}"


def table(rows, columns, text=1):
    """columns: (heading, key or function, digits)."""
    of = lambda row, key: key(row) if callable(key) else row[key]
    heading = [heading for heading, *_ in columns]
    return page.markdown(heading, [[shown(of(row, key), digits) for _, key, digits in columns] for row in rows], text)


def same(names, digits):
    return [(name, name, digits) for name in names]


def lines(rows, name, x, y):
    """A series for each name, in the order of the rows."""
    found = {}
    for row in rows:
        found.setdefault(name(row) if callable(name) else row[name], []).append((x(row) if callable(x) else row[x], y(row)))
    return [Series(name, points) for name, points in found.items()]


def smooth(folder, rows):
    for case, file in (("no damage", "smooth"), ("first damage", "smooth_damage")):
        own = [row for row in rows if row["case"] == case]
        for quantity, key, label in (
            ("position", "position error m", "largest position error (m)"), ("energy", "energy error", "energy error over the initial energy")
        ):
            for clock, x, axis in (("steps", "node-steps", NODE_STEPS), ("seconds", lambda row: 1e-3 * row["CPU ms"], "processor time (s)")):
                title = f"Smooth phase, {case}: 0.7 to 1/32 dt_crit"
                plot.errors(folder / f"{file}_{quantity}_{clock}.svg", title, axis, label, lines(own, "integrator", x, lambda row: row[key]))
    columns = [
        ("integrator", "integrator", None), ("dt/dt_crit", "dt/dt_crit", 3), ("node-steps", "node-steps", "e2"),
        ("position error m", "position error m", "e2"), ("order", "order", 2), ("energy error", "energy error", "e1"),
    ]
    parts = []
    for integrator in ("Verlet", "theta, tolerance 1e-10"):
        for quantity, key, cases in (("position", "order", ("no damage", "first damage")), ("energy", "order of energy", ("no damage",))):
            orders = [row[key] for row in rows if row["integrator"] == integrator and row["case"] in cases and row["dt/dt_crit"] < 0.45 and row[key] == row[key]]
            parts.append(f"{integrator}, {quantity}: {min(orders):.3f} to {max(orders):.3f}")
    return table([row for row in rows if row["case"] == "no damage"], columns) + f"\nObserved order below 0.45 dt_crit: {'; '.join(parts)}.\n"


def overshoot_strain(folder, rows):
    profiles = [{key: value if key == "viscosity" else float(value) for key, value in row.items()} for row in page.rows_of(folder / "overshoot_profile.csv")]
    name = lambda row: f"network, segments in a spacing: {row['segments in a spacing']:.0f}, viscosity: {row['viscosity']}" if row["segments in a spacing"] else "Smith"
    found = [line._replace(style="dashed" if line.name == "Smith" else "line") for line in lines(profiles, name, "distance mm", lambda row: row["strain %"])]
    thin = rows[0]["cylinder R mm"]
    plot.draw(
        folder / "overshoot_strain.svg", f"Strip struck at 400 m/s by a cylinder of {thin:.2f} mm, when the front is near the held end",
        "distance from the middle, of the yarn at rest (mm)", "U - 1 (%)", found, "from zero",
    )
    columns = [("viscosity", "viscosity", None), ("cylinder R mm", "cylinder R mm", 2), ("segments in a spacing", "segments in a spacing", 0), ("impact m/s", "impact m/s", 0)]
    near, anywhere = "largest near the contact %", "largest anywhere %"
    smith = "Smith: U - 1 %"
    columns += [(smith, smith, 4), ("mean behind the front %", "mean behind the front %", 4)]
    columns += [(near, near, 4), ("over Smith", lambda row: row[near] / row[smith], 2), (anywhere, anywhere, 4), ("over Smith", lambda row: row[anywhere] / row[smith], 2)]
    columns += [("front, 10 to 90 %, spacings", "front, spacings", 1)]
    return table(rows, columns)


def overshoot_breaking(folder, rows):
    columns = [("viscosity", "viscosity", None), ("cylinder R mm", "cylinder R mm", 2), ("segments in a spacing", "segments in a spacing", 0), ("dt/dt_crit", "dt/dt_crit", 1), ("node mass", "node mass", 1)]
    columns += [("Smith m/s", "Smith m/s", 1)]
    for name in ("first damage m/s", "first failure m/s"):
        columns += [(name, name, 0), ("over Smith", lambda row, name=name: row[name] / row["Smith m/s"], 2)]
    return table(rows, columns)


def viscosity(folder, rows):
    columns = [("case", "case", None), ("viscosity", "viscosity", None), ("runs", "runs", 0), ("absorbed J", "absorbed J", 2), ("deviation %", "absorbed J: deviation %", 1)]
    columns += same(["velocity m/s"], 1) + same(["peak N"], 0) + same(["failed %", "taken by viscosity %", "residual %"], 2)
    return table(rows, columns)


def grading(folder, rows):
    with_open = lambda name: lambda row: f"{row[name + ': error %']:.2f} ± {row[name + ': open %']:.2f}"
    columns = [("case", "case", None), ("network", "network", None), ("nodes", "nodes", None), ("runs", "runs", 0), ("absorbed J", "absorbed J", 2)]
    columns += [("deviation %", "absorbed: deviation %", 2), ("error %", with_open("absorbed"), None)]
    columns += [("velocity m/s", "velocity m/s", 2), ("deviation %", "velocity: deviation %", 2), ("error %", with_open("velocity"), None)]
    return table(rows, columns + [("node-steps", "node-steps", "e2"), ("times fewer", "times fewer", 1), ("times faster", "times faster", 1)])


def pointwise(folder, rows):
    distances = ["V0 by 1e-12: largest so far (h)", "mirrored: largest so far (h)", "root mean square now (h)", "velocity so far, of V0", "work so far, of KE0"]
    return table(rows, [("case", "case", None), ("step", "step", 0), ("time us", "time us", 1), ("slack segments %", "slack segments %", 0), *same(distances, "e1")])


def quarter(folder, rows):
    differences = [key for key in rows[0] if key.startswith(("position", "velocity"))]
    return table(rows, [("case", "case", None), ("step", "step", 0), ("time us", "time us", 1), *same(differences, "e1")])


def impact(folder, rows):
    cases, text = {}, ""
    for row in rows:
        cases.setdefault(row["case"], []).append(row)
    for case, own in cases.items():
        judged = front.Judged(own)
        pictures(folder, case, judged)
        text += f"## 40 J, {case}\n\n{impact_table(judged)}\n{front.verdict(judged)}\n\n{choice_table(judged)}\n"
    return FRONT + text


FRONT = (
    "*front*: on the Pareto front of cost and the error of A absorbed energy, V velocity, P peak force, X exit time, F failed segments, "
    "E energy residual; * on that of all measures together. An error below the resolution of the means is shown as < and counts as the "
    "resolution. The second table of a case has the cheapest setting for a wanted error of the absorbed energy.\n\n"
)


def impact_table(judged):
    def name(row):
        trouble = f" [{len(row['trouble'].split())} x {row['trouble'].split()[0]}]" if isinstance(row["trouble"], str) else ""
        return row["family"] + " (default)" * row["default"] + " (refused)" * (not row["accepted"]) + trouble

    def value(measure, digits):
        def text(row):
            error = row[measure + "_deviation"] / math.sqrt(row["runs"]) if row["runs"] else math.nan
            return f"{row[measure]:.{digits}f} ± {error:.{digits}f}" if row["runs"] else "-"
        return text

    def error(measure):
        def text(row):
            error, floor = 100 * row["error"][measure], 100 * row["resolution"][measure]
            return "-" if math.isnan(error) else f"< {floor:.2f}" if error < floor else f"{error:.2f}"
        return text

    columns = [("setting", name, None), ("dt/dt_crit", "dt_over_dt_crit", 2), ("runs", "runs", 0), ("node-steps", "node_steps", "e2"), ("CPU s", "cpu_seconds", 3)]
    for heading, measure, digits in (("absorbed J", "absorbed", 3), ("velocity m/s", "velocity", 3), ("peak N", "force", 1)):
        columns += [(heading, value(measure, digits), None), ("error %", error(measure), None)]
    columns += [(heading, value(measure, digits), None) for heading, measure, digits in (("exit us", "exit", 1), ("failed %", "failed", 2), ("energy residual % of KE0", "residual", 4))]
    columns += [("front by node-steps", lambda row: front.marks(row, 0), None), ("by seconds", lambda row: front.marks(row, 1), None)]
    return table(judged.rows, columns)


def choice_table(judged):
    heading = ["wanted error of absorbed energy", "take", "dt/dt_crit", "runs", "node-steps in all", "CPU s in all", "expected error", "energy residual % of KE0"]
    rows = []
    for wanted, found in front.choice(judged):
        percent = f"{100 * wanted:g} %"
        if found:
            row, runs, error = found
            rows.append([
                percent, row["family"], f"{row['dt_over_dt_crit']:.2f}", runs, page.power(runs * row["node_steps"], 1),
                f"{runs * row['cpu_seconds']:.2f}", f"{100 * error:.2f} %", f"{row['residual']:.4f}",
            ])
        else:
            rows.append([percent, "below what these ensembles can show", *[""] * 6])
    return page.markdown(heading, rows, 2)


def pictures(folder, case, judged):
    for measure in front.MEASURES:
        error = lambda row: 100 * row["error"][measure]
        label = "energy residual (% of KE0)" if measure == "residual" else "error of the mean (%)"
        levels = [("chaos floor, one run", 100 * judged.floor[measure]), ("resolution of the means", 100 * judged.resolution[measure])]
        for number, (clock, cost, axis) in enumerate((
            ("steps", "node_steps", "node-steps of one run (force evaluations)"), ("seconds", "cpu_seconds", "processor time of one run (s)")
        )):
            shown_rows = [row for row in judged.rows if not row["reference"]]
            best = sorted((row[cost], error(row)) for row in shown_rows if measure in row["fronts"][number])
            series = [Series("Pareto front", best, "line")] + lines(shown_rows, "family", cost, error)
            series.append(Series("default", [(row[cost], error(row)) for row in judged.rows if row["default"]]))
            title = f"40 J, {case}: error of the {front.WORDS[measure]}"
            path = folder / f"{judged.rows[0]['file']}_{measure}_{clock}.svg"
            plot.errors(path, title, axis, label, series, levels[:1] if measure == "residual" else levels)


def runs_summary(folder, rows):
    every = [{key: read(value) for key, value in row.items()} for row in page.rows_of(folder / "runs.csv")]
    name = lambda row: f"{row['case']}, {row['what differs']}"
    found = lines(every, name, "node-steps in all", lambda row: row["absorbed: standard error %"])
    plot.errors(
        folder / "runs_absorbed_steps.svg", "40 J: statistical error of the mean absorbed energy", "node-steps of all runs together",
        "standard error of the mean (%)", found,
    )
    columns = [*same(["case", "what differs"], None), ("runs", "runs", 0)]
    for name, digits in (("absorbed J", 3), ("velocity m/s", 3), ("peak N", 1), ("failed %", 2)):
        columns += [(name, name, digits), ("deviation %", name + ": deviation %", 3)]
    return table(rows, columns, 2)


def coupling(folder, rows):
    integrated, rest = rows[0], rows[1:]
    names = list(dict.fromkeys(row["scheme"] for row in rest))
    floor = 200 * math.sqrt(2) * integrated["absorbed: standard error"] / integrated["absorbed J"]
    for part, chosen in (("", names[:6]), ("_more", names[:2] + names[8:])):
        own = [row for row in rest if row["scheme"] in chosen]
        for measure, what, label, value, levels in (
            ("velocity", "error of the velocity at 50 us", "error (m/s)", lambda row: abs(row["V(50 us) error m/s"]), []),
            ("interface", "energy lost between host and fabric", "interface energy error (% of KE0)", lambda row: abs(row["interface energy error % of KE0"]), []),
            (
                "absorbed", "error of the absorbed energy", "error of the mean (%)", lambda row: 100 * abs(row["absorbed J"] / integrated["absorbed J"] - 1),
                [("resolution of the means", floor)],
            ),
        ):
            path = folder / f"coupling{part}_{measure}.svg"
            plot.errors(path, f"Host-driven sphere, 40 J: {what}", "communication step H (s)", label, lines(own, "scheme", "H s", value), levels)
    spread = lambda name: lambda row: f"{row[name + (' J' if name == 'absorbed' else ' m/s')]:.3f} ± {row[name + ': standard error']:.3f}"
    ended = lambda row: f"{row['runs']:.0f}" if row["ended"] == row["runs"] else f"{row['ended']:.0f} of {row['runs']:.0f} end"
    return table(rows, [
        ("scheme", "scheme", None), ("H s", "H s", "e0"), ("runs", ended, None), ("V(50 us) error m/s", "V(50 us) error m/s", "e2"),
        ("interface energy error % of KE0", "interface energy error % of KE0", "e1"), ("absorbed J", spread("absorbed"), None),
        ("velocity m/s", spread("velocity"), None), ("peak N", "peak N", 1), ("node-steps", "node-steps", "e2"), ("CPU s", "CPU s", 2),
    ])


PARTS = {
    "smooth": ("Smooth phase", smooth),
    "overshoot_strain": ("Overshoot: strains of a strip struck across its middle", overshoot_strain),
    "viscosity": ("Viscosity in whole impacts", viscosity),
    "overshoot_breaking": ("Overshoot: velocities that break the strip", overshoot_breaking),
    "grading": ("Graded networks against the whole fabric", grading),
    "pointwise": ("Point by point before the first failure", pointwise),
    "quarter": ("Quarter against whole sheet, before the first failure", quarter),
    "impact": ("Whole impacts", impact),
    "runs_summary": ("Number of runs in a mean", runs_summary),
    "coupling": ("A projectile moved by its host", coupling),
}
