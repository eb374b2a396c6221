"""Whole impacts: the preset sphere at 40 J on the 3 in sheet, every attachment, uniform and stochastic yarn; error over cost.

The error of a setting is that of its ensemble mean against velocity Verlet at 0.05 dt_crit on the full network. Runs of an
ensemble differ by 1e-12 in the impact velocity; a stochastic sheet is the same one (seed 1) in all of them. A run ends when the
sphere is arrested or has exited, at the corners when the last yarn from the sphere to a support is gone: whether the torn sheet
pulls once more is up to rounding. Runs there are long and scatter much: fewer of them, and the reference is at 0.1 dt_crit. Steps
above 0.5 dt_crit, which the kernel refuses, are run unchecked, to show why.

Cost is counted in node-steps: evaluations of the force on a node, one a step with velocity Verlet, one an iteration with the
theta rule. They are the same on every machine; seconds of processor time stand beside them. Rows of nodes that the wave has not
reached are counted though skipped.

A coarser network has one node for a block of nodes: its bars have so many times the spacing and the area, its nodes the mass of a
block, so mass, stiffness and strength per width stay. What does not stay: the energy to break a yarn grows with the bar, and
shorter waves are lost.
"""

import math
from typing import NamedTuple

from fabric_kernel import Failed, Scene, Simulation, drawing, page

from . import front
from .statistics import deviation, mean
from .study import FULL, QUICK, SMOKE, clock

# Energy of the sphere, J; by which velocities of an ensemble differ: large against rounding, small against everything else; steps
# of the kernel.
ENERGY, ROUNDING, DEFAULT, LARGEST = 40.0, 1e-12, 0.4, 0.5
# Time after which a run is given up, s.
LONGEST = 2e-3
QUARTER = "quarter"


class Case(NamedTuple):
    name: str
    kind: str
    stochastic: bool

    @property
    def end(self):
        return ["arrested", "exited"] + ["detached"] * (self.kind == "four_corners")


CASES = [
    Case(f"{held}, {yarn}", kind, yarn == "stochastic")
    for held, kind in (("four sides", "four_sides"), ("two sides", "two_sides"), ("corners", "four_corners"))
    for yarn in ("uniform", "stochastic")
]


class Setting(NamedTuple):
    """step: dt over dt_crit of its own network. tolerance: of the theta rule, in node spacings; None: velocity Verlet. network:
    QUARTER, or nodes of the fabric along a side for one of the network's. balanced: with slack_balance."""

    step: float
    tolerance: float | None = None
    network: str | int = 1
    balanced: bool = False

    def family(self):
        """The line it belongs to in a plot."""
        parts = [integrator_name(self.tolerance)] + ["slack balance"] * self.balanced
        return ", ".join(
            parts + ["quarter"] * (self.network == QUARTER) + ([f"{self.network} h"] if self.network in (2, 4) else [])
        )

    def guess(self):
        """Cost, so that long runs start first."""
        share = 0.3 if self.network == QUARTER else self.network**-3
        return share * (20 if self.tolerance else 1) * (1.5 if self.balanced else 1) / self.step


def integrator_name(tolerance):
    return f"theta, tolerance {tolerance:.0e}".replace("e-0", "e-") if tolerance else "Verlet"


def integrator(tolerance):
    return {"integrator.kind": "theta", "integrator.tolerance": tolerance} if tolerance else {}


def checked(step):
    """The step check that allows this part of dt_crit."""
    return {"step_check": "none" if step > LARGEST else "refuse"}


def scene_of(case, setting, faster, smoke):
    """The scene whose velocity is higher by this part of it."""
    scene = Scene("sheet_3in_sphere", sheet={"nodes_x": 41, "nodes_y": 41} if smoke else {})
    speed = math.sqrt(2.0 * ENERGY / scene["projectile.mass"])
    changes = {
        "attachment.kind": case.kind,
        "yarn.stochastic": case.stochastic,
        "projectile.velocity": [0.0, 0.0, speed * (1.0 + faster)],
    }
    changes |= (
        integrator(setting.tolerance)
        | checked(setting.step)
        | {"time_step.fraction": setting.step, "slack_balance": setting.balanced}
    )
    if setting.network == QUARTER:
        changes |= {"symmetry.mirror_x": True, "symmetry.mirror_y": True}
    elif (factor := setting.network) > 1:
        changes |= {f"sheet.nodes_{axis}": (scene[f"sheet.nodes_{axis}"] - 1) // factor + 1 for axis in "xy"}
        changes |= {
            f"sheet.{name}": scene[f"sheet.{name}"] * factor**power
            for name, power in (("spacing", 1), ("yarn_area", 1), ("node_mass", 2))
        }
    return scene.replace(changes)


def node_steps(simulation):
    """Evaluations of the forces on nodes so far."""
    counters, nodes = simulation.counters(), simulation.positions()[..., 0].size
    return (counters["iterations"] or counters["steps"]) * nodes


def segments(scene):
    nx, ny = scene["sheet.nodes_x"], scene["sheet.nodes_y"]
    return ((nx - 1) * ny + (ny - 1) * nx) * scene["stack.plies"]


def impact(job):
    """Runs until one of the outcomes. values: the measures in J, m/s, N, us, % of the segments, % of KE0; trouble: why there are
    none."""
    scene, end = job[:2]
    simulation = Simulation(scene, warns=False)
    start = simulation.energy()["projectile_kinetic"]
    steps = int(LONGEST / simulation.step_limits()["dt"])
    begin, trouble = clock(), None
    try:
        simulation.run(end, steps)
        trouble = "TIMEOUT" if simulation.step_count >= steps else None
    except Failed as failed:
        trouble = failed.code
    seconds = clock() - begin
    found = {"node_steps": node_steps(simulation), "seconds": seconds, "trouble": trouble}
    if trouble:
        return found
    contact, failed = simulation.contact(), simulation.counters()["failed_segments"]
    values = [contact["work"], simulation.projectile()["velocity"][2], contact["force_peak"], 1e6 * simulation.time]
    values += [100.0 * failed / segments(scene), 100.0 * simulation.energy()["residual"] / start]
    return found | {"values": dict(zip(front.MEASURES, values))}


def settings(case, effort):
    """(setting, runs) of a case, the reference first."""
    corners, full = case.kind == "four_corners", effort == FULL
    runs, few = {FULL: (6 if corners else 10, 2), QUICK: (3, 2), SMOKE: (2, 1)}[effort]
    steps = {FULL: [] if corners else [0.05], QUICK: [], SMOKE: [0.2, 0.4]}[effort]
    steps += [] if effort == SMOKE else [0.1, 0.2, 0.3, 0.4, 0.5]
    steps += [0.6, 0.7] if full and not corners else []
    found = [(Setting(step), runs) for step in steps]
    for step in (0.2, 0.4, 0.5) if full else (0.4,):
        networks = [2, 4] if case.stochastic else [QUARTER, 2, 4]
        found += [(Setting(step, network=network), runs) for network in networks]
    found += [(Setting(step, balanced=True), runs) for step in ((0.2, 0.3, 0.4, 0.5) if full and not corners else (0.4,))]
    # The theta rule costs ten times as much: where it is compared, and one point elsewhere.
    implicit = [(0.4, 1e-6)] if case == CASES[0] or (full and case in CASES[1:3]) else []
    if full and case == CASES[0]:
        implicit = [(0.2, 1e-6), (0.4, 1e-4), (0.4, 1e-6), (0.4, 1e-10), (0.5, 1e-6), (0.7, 1e-6)]
    return found + [(Setting(step, tolerance), few) for step, tolerance in implicit]


def answer(study):
    cases = CASES[: study.of(6, 3, 1)]
    wanted = [(case, setting, runs) for case in cases for setting, runs in settings(case, study.effort)]
    jobs = sorted(
        ((n, k) for n, (_, _, runs) in enumerate(wanted) for k in range(runs)), key=lambda job: -wanted[job[0]][1].guess()
    )
    smoke = study.effort == SMOKE
    found = study.each(
        impact, [(scene_of(wanted[n][0], wanted[n][1], k * ROUNDING, smoke), wanted[n][0].end, k) for n, k in jobs]
    )
    rows, text, judged_cases = [], FRONT, {}
    for n, (case, setting, _) in enumerate(wanted):
        own = [run for (m, _), run in sorted(zip(jobs, found), key=lambda pair: pair[0]) if m == n]
        rows.append(summed_up(case, setting, own))
    study.write("impact", rows)
    for case in cases:
        judged = judged_cases[case.name] = front.Judged([row for row in rows if row["case"] == case.name])
        text += f"## 40 J, {case.name}\n\n{impact_table(judged)}\n{front.verdict(judged)}\n\n{choice_table(judged)}\n"
    study.table("accuracy_impact", "Whole impacts", text)
    draw(judged_cases, study.folder / "front.svg")
    study.picture("front.svg", "front.svg")


def summed_up(case, setting, runs):
    """The row of a setting."""
    good = [run["values"] for run in runs if not run["trouble"]]
    row = {
        "case": case.name,
        "family": setting.family(),
        "dt_over_dt_crit": setting.step,
        "accepted": setting.step <= LARGEST,
        "default": setting == Setting(DEFAULT),
        "plain": setting == Setting(setting.step),
        "full_network": setting.network == 1,
        "runs": len(good),
        "node_steps": mean([run["node_steps"] for run in runs]),
        "cpu_seconds": min(run["seconds"] for run in runs),
        "trouble": " ".join(run["trouble"] for run in runs if run["trouble"]),
    }
    for name in front.MEASURES:
        values = [run[name] for run in good]
        row |= {name: mean(values), f"{name}_deviation": deviation(values)}
    return row


FRONT = (
    "*front*: on the Pareto front of cost and the error of A absorbed energy, V velocity, P peak force, X exit time, F failed "
    "segments, "
    "E energy residual; * on that of all measures together. An error below the resolution of the means is shown as < and counts "
    "as the "
    "resolution. The second table of a case has the cheapest setting for a wanted error of the absorbed energy.\n\n"
)


def impact_table(judged):
    def name(row):
        trouble = f" [{len(row['trouble'].split())} x {row['trouble'].split()[0]}]" if row["trouble"] else ""
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

    columns = [
        ("setting", name, None),
        ("dt/dt_crit", "dt_over_dt_crit", 2),
        ("runs", "runs", 0),
        ("node-steps", "node_steps", "e2"),
        ("CPU s", "cpu_seconds", 3),
    ]
    for heading, measure, digits in (("absorbed J", "absorbed", 3), ("velocity m/s", "velocity", 3), ("peak N", "force", 1)):
        columns += [(heading, value(measure, digits), None), ("error %", error(measure), None)]
    columns += [
        (heading, value(measure, digits), None)
        for heading, measure, digits in (
            ("exit us", "exit", 1),
            ("failed %", "failed", 2),
            ("energy residual % of KE0", "residual", 4),
        )
    ]
    columns += [
        ("front by node-steps", lambda row: front.marks(row, 0), None),
        ("by seconds", lambda row: front.marks(row, 1), None),
    ]
    return page.table(judged.rows, columns)


def choice_table(judged):
    heading = (
        "wanted error of absorbed energy, take, dt/dt_crit, runs, node-steps in all, CPU s in all, expected error, "
        "energy residual % of KE0"
    ).split(", ")
    rows = []
    for wanted, found in front.choice(judged):
        percent = f"{100 * wanted:g} %"
        if found:
            row, runs, error = found
            cost = [page.power(runs * row["node_steps"], 1), f"{runs * row['cpu_seconds']:.2f}"]
            got = [f"{100 * error:.2f} %", f"{row['residual']:.4f}"]
            rows.append([percent, row["family"], f"{row['dt_over_dt_crit']:.2f}", runs, *cost, *got])
        else:
            rows.append([percent, "below what these ensembles can show", *[""] * 6])
    return page.markdown(heading, rows, 2)


KINDS = {
    "Verlet": "velocity Verlet",
    "Verlet, slack balance": "the same with slack_balance",
    "Verlet, quarter": "a quarter of the sheet",
    "Verlet, 2 h": "bars of two yarns",
    "Verlet, 4 h": "bars of four yarns",
}


def draw(cases, path):
    """Error of the absorbed energy over time, a panel for each case. A family of settings is a line, the default a star."""
    rows = (len(cases) + 1) // 2
    figure, panels = drawing.new(5.6, 0.6 + 1.8 * rows, min(len(cases), 2), rows, sharex=True, sharey=True, squeeze=False)
    for axis, (name, judged) in zip(panels.flat, cases.items()):
        counted = lambda row: (row["cpu_seconds"], 100 * max(row["error"]["absorbed"], row["resolution"]["absorbed"]))
        shown = [row for row in judged.rows if front.competes(row)]
        for number, (family, words) in enumerate([*KINDS.items(), ("theta", "theta rule")]):
            points = sorted(
                counted(row)
                for row in shown
                if row["family"] == family or (family == "theta" and row["family"].startswith(family))
            )
            style = drawing.STYLES["points" if family == "theta" else "marked"] | {"markersize": 3.5, "linewidth": 1.0}
            if points:
                axis.plot(*zip(*points), color=drawing.COLOURS[number], label=words, **style)
        axis.plot(
            *zip(*(counted(row) for row in judged.rows if row["default"])),
            "*",
            color="black",
            markersize=11,
            label="default",
            zorder=3,
        )
        axis.axhline(
            100 * judged.resolution["absorbed"], color="#969696", linewidth=1, linestyle="--", label="resolution of the means"
        )
        axis.set(xscale="log", yscale="log")
        axis.set_title(name, fontsize=10)
    for axis in panels[-1]:
        axis.set_xlabel("processor time of a run (s)")
    figure.supylabel("error of the mean absorbed energy (%)", fontsize=10)
    drawing.below(figure, panels.flat[0])
    drawing.save(figure, path)
