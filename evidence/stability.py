"""Time step against impact velocity, by the energy that the step creates.

A small sheet of uniform yarn is hit by the 8.4 g sphere and stepped for the same time with every step, unchecked. What the
projectile does with it is the finding; extreme scenes whose outcome is known are tests, `tests/stability`.
"""

import math

from fabric_kernel import Failed, Scene, Simulation, drawing

from . import page

NODES, TIME = 41, 150e-6
FRACTIONS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2)
SPEEDS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)
LIMIT = 0.5  # Steps above this part of dt_crit are refused.
SIGNS = (
    "through: the sphere has left; arrested: stopped, no yarn failed; whole: under way, no yarn failed; "
    "torn: under way or stopped, yarns failed"
)
CLASSES = [(0.01, "#a8d8b9", "below 1 %"), (0.1, "#f6d678", "1 to 10 %"), (math.inf, "#eb8c6e", "above 10 %: unusable")]


def run(scene):
    """Energy residual over the impact energy, infinite after a failure; failed segments; what became of the projectile."""
    simulation = Simulation(scene, warns=False)
    impact = simulation.energy()["projectile_kinetic"]
    try:
        simulation.step(int(TIME / simulation.step_limits()["dt"]))
        energy, come = simulation.energy()["residual"] / impact, simulation.outcomes()
    except Failed:
        energy, come = math.inf, {}
    failed = simulation.counters()["failed_segments"]
    sign = "through" if "exited" in come else "torn" if failed else "arrested" if "arrested" in come else "whole"
    return {"energy": energy, "failed segments": failed, "projectile": sign}


def answer(study):
    fractions, speeds = (values[:: study.of(1, 2, 6)] for values in (FRACTIONS, SPEEDS))
    plain = Scene(
        "sheet_3in_sphere", {"sheet.nodes_x": NODES, "sheet.nodes_y": NODES, "yarn.stochastic": False, "step_check": "none"}
    )
    points = [(fraction, speed) for speed in speeds for fraction in fractions]
    found = study.each(
        run, [plain.replace({"time_step.fraction": fraction, "projectile.velocity": [0, 0, speed]}) for fraction, speed in points]
    )
    cells = [{"dt/dt_crit": fraction, "velocity m/s": speed, **cell} for (fraction, speed), cell in zip(points, found)]
    study.write("map", cells)
    for cell in cells:
        cell["class"] = next(
            number for number, (most, _, _) in enumerate(CLASSES) if abs(cell["energy"]) < most or most == math.inf
        )
    draw(cells, study.folder / "map.svg")
    study.picture("map.svg", "stability_map.svg")
    rows = [
        [f"{speed:g}", *(f"{percent(cell['energy'])} {cell['projectile']}" for cell in cells if cell["velocity m/s"] == speed)]
        for speed in speeds
    ]
    heading = ["velocity, m/s", *(f"{fraction:g} dt_crit" for fraction in fractions)]
    notes = f"Residual of the energy balance in % of the impact energy, and the projectile: {SIGNS}."
    study.table(
        "stability", "Time step against impact velocity", f"{in_words(cells)}\n\n{notes}\n\n{page.markdown(heading, rows)}"
    )


def in_words(cells):
    """The worst residual of each accepted step, and of the refused ones."""
    count = lambda allowed, *classes: sum((cell["dt/dt_crit"] <= LIMIT) == allowed and cell["class"] in classes for cell in cells)
    worst = lambda at: 100 * max((abs(cell["energy"]) for cell in cells if cell["dt/dt_crit"] == at), default=math.nan)
    steps = ", ".join(f"{worst(at):.2f} % at {at}" for at in (0.1, 0.2, 0.3, 0.4, 0.5) if not math.isnan(worst(at)))
    return (
        f"Of the {count(True, 0, 1, 2)} runs with a step that is accepted {count(True, 0)} are sound and {count(True, 1, 2)} "
        f"gain more than 1 % ({count(True, 2)} above 10 %); the worst of each step: {steps}. Of the {count(False, 0, 1, 2)} "
        f"runs beyond it {count(False, 0)} are sound, {count(False, 1)} gain 1 to 10 % and {count(False, 2)} are unusable."
    )


def percent(part):
    """About two figures."""
    value, size = 100 * part, abs(100 * part)
    if not math.isfinite(size):
        return "fault"
    if size < 0.01:
        return "0.00"
    return (
        f"{value:+.2f}"
        if size < 1
        else f"{value:+.1f}"
        if size < 10
        else f"{value:+.0f}"
        if size < 1e5
        else "+" * (value > 0) + page.power(value, 0)
    )


def draw(cells, path):
    """A cell for each run, coloured by class, with a residual above 1 % in percent; refused steps are right of a line."""
    columns, rows = (sorted({cell[key] for cell in cells}) for key in ("dt/dt_crit", "velocity m/s"))
    figure, axis = drawing.new(5.6, 1.8 + 0.28 * len(rows))
    patches = drawing.matplotlib.patches
    for cell in cells:
        # Fast ones at the top.
        x, y = columns.index(cell["dt/dt_crit"]), rows.index(cell["velocity m/s"])
        axis.add_patch(patches.Rectangle((x, y), 1, 1, facecolor=CLASSES[cell["class"]][1], edgecolor="white", linewidth=1.5))
        size = 100 * abs(cell["energy"])
        if cell["class"]:
            axis.text(x + 0.5, y + 0.48, f"{size:.0f}" if size < 100 else ">99", ha="center", va="center", fontsize=8)
    axis.axvline(sum(fraction <= LIMIT for fraction in columns), color="black", linewidth=2.5)
    axis.grid(False)
    axis.set(
        xlim=(0, len(columns)),
        ylim=(0, len(rows)),
        xlabel="time step / dt_crit (refused right of the line)",
        ylabel="impact velocity (m/s)",
    )
    axis.set_xticks([k + 0.5 for k in range(len(columns))], [f"{fraction:g}" for fraction in columns], fontsize=9)
    axis.set_yticks([k + 0.5 for k in range(len(rows))], [f"{speed:g}" for speed in rows])
    axis.tick_params(length=0)
    for spine in axis.spines.values():
        spine.set_visible(False)
    figure.suptitle("Energy that the time step creates, % of the impact energy", fontsize=11)
    keys = [patches.Patch(facecolor=colour, label=words) for _, colour, words in CLASSES]
    figure.legend(handles=keys, loc="outside lower center", ncols=3, fontsize=9, columnspacing=1.0, handlelength=1.2)
    drawing.save(figure, path)
