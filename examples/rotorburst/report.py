"""Draws the plots of a run and writes report.html, one file that needs no other.

    python report.py results

Reads what rotorburst.py wrote, and the same of a second run with more plies in the folder `pack`, if that is there. The package
fabric_kernel opens the states that the FMU saved, for the pictures of the sheet.
"""

import json
import pathlib
import sys

import numpy as np
import pandas
from balances import answer, plies_of, result_rows, went_through
from fabric_kernel import Scene, Simulation, drawing, page, sheets

ZYLON = "Zylon AS, 500 denier, 35 yarns an inch, by its data sheet (data/fabrics/zylon_as_500_35.toml)"
PAPER = "the yarn of Powell and Zohdi (2009)"
CAVEAT = (
    "Not yet the numbers of a real fabric: the yarn area of the source paper is about 3.7 times too large for its mass. "
    "The yarn is as much too stiff and strong. Calibrate the area before using absolute numbers."
)
PICTURES = (
    "the whole sheet from the side the fragment leaves by, coloured by strain until it fails. The fragment is dashed where the "
    "sheet hides it."
)
# Plots over time: file, label, columns of history.csv with their names and factors, caption.
PLOTS = [
    ("velocity", "velocity along the flight (m/s)", {"velocity[3]": ("velocity", 1.0)}, "Velocity of the fragment."),
    (
        "force",
        "force on the fragment (kN)",
        {"contact.force_mean[3]": ("mean over a communication step", -1e-3)},
        "Force on the fragment against its flight. A flat end sweeps up its nodes within the first step: an impulse, whose "
        "mean force depends on the time over which it is taken.",
    ),
    (
        "energies",
        "energy (J)",
        {
            "contact.work": ("absorbed (work of the fragment)", 1.0),
            "energy.kinetic": ("kinetic energy of the sheet", 1.0),
            "energy.strain": ("strain energy", 1.0),
            "energy.dissipated": ("dissipated by rupture", 1.0),
            "energy.contact_loss": ("lost in nodal impacts", 1.0),
        },
        "Energy the fabric has absorbed, and where it is.",
    ),
    (
        "failed_segments",
        "failed segments",
        {"fabric.failed_segments": ("failed", 1.0)},
        "Yarn segments that have lost all stiffness.",
    ),
]
MEANING = (
    "After the first failed segment the model is chaotic: a change of the speed in the 13th digit changes the pattern of "
    "failure. One run is one sample; residual velocity, absorbed energy and failed segments are to be compared as ensembles, "
    "over seeds or over slightly changed speeds. The same run on another machine gives the same FMU bits for the same inputs.",
    "Not modelled: friction between yarns, bending, slip of yarns at crossings and clamps, interchange of crimp, deformation "
    "of the fragment. Options that this run does not use are friction on the fragment and dependence on strain rate{}.",
    "The host's drag is that of a body flying straight; lift and tumbling drag are left out.",
)
BALANCES = (
    "The host's own bookkeeping against the FMU's outputs at the end of the run. Gravity and drag are taken out of the host's "
    "side. The difference in energy is the error of the coupling at this communication step; the shield's own energy balance "
    "shows the error of its time step."
)


def saved(folder, results):
    """The sheet in each state that the FMU saved; of a stack its last ply."""
    preset, fabric, changes = results["scene"]
    text = f'preset = "{preset}"\n' + (f'[fabric]\nname = "{fabric}"' if fabric else "")
    simulation = Simulation(Scene.parse(text).replace(changes), warns=False)
    size = len(simulation.save())
    for k in range(len(results["pictures"])):
        # The kernel's image stands at the end of the FMU's state, before a checksum of 8 bytes.
        simulation.restore((folder / f"state-{k}.bin").read_bytes()[-8 - size : -8])
        yield sheets.Sheet(simulation, results["plies"] - 1)
    assert simulation.counters()["failed_segments"] == results["outputs"]["fabric.failed_segments"], (
        "the last state is not the run's end"
    )


@drawing.styled
def draw(runs):
    """The pictures of all runs, on one scale."""
    figures = []
    for folder, results in runs:
        drawn, contact = list(saved(folder, results)), results["first_contact"]
        figure, panels = drawing.new(11.0, 8.4, 2, 2, sharex=True, sharey=True)
        limits = []
        for panel, sheet, time in zip(panels.flat, drawn, results["pictures"]):
            sheet.draw_oblique(panel)
            limits.append([*panel.get_xlim(), *panel.get_ylim()])
            panel.set_title(f"{1e6 * (time - contact):.0f} µs after first contact", fontsize=10)
        sheets.bar(figure, panels, drawn[-1], "strain (%)")
        figures.append((folder, figure, panels[0, 0], np.array(limits)))
    left, low = np.min([limits.min(0)[[0, 2]] for *_, limits in figures], axis=0)
    right, high = np.max([limits.max(0)[[1, 3]] for *_, limits in figures], axis=0)
    for folder, figure, panel, _ in figures:
        panel.set(xlim=(left, right), ylim=(low, high))
        # Panels as high as what they show, with room for titles; the bar of colours takes a tenth of the width.
        figure.set_figheight(0.9 * 11.0 * (high - low) / (right - left) + 0.8)
        drawing.save(figure, folder / "sheet.png")


def plots(folder, results):
    """One picture for each of PLOTS, of the time during which host and shield are coupled."""
    rows = pandas.read_csv(folder / "history.csv")
    rows, zero = (
        rows[rows["time"] > results["start"]],
        results["first_contact"] if results["first_contact"] >= 0.0 else results["start"],
    )
    events = [(results["end_time"], results["end"])]
    if "detached" in results:
        events.append((results["detached"]["time"], "detached"))
    elif went_through(results):
        work = rows["contact.work"]
        events.append((rows["time"][work >= 0.99 * work.max()].iloc[0], "99 % absorbed"))
    marks, times = [(1e6 * (time - zero), name) for time, name in events], 1e6 * (rows["time"] - zero)
    for name, label, columns, _ in PLOTS:
        series = [
            drawing.Series(words, list(zip(times, scale * rows[column])), "line") for column, (words, scale) in columns.items()
        ]
        drawing.draw(
            folder / f"{name}.svg",
            "",
            "time since first contact (µs)",
            label,
            series,
            "linear" if name == "velocity" else "from zero",
            marks=marks,
        )


def parameter_rows(results):
    """What was simulated."""
    options, body = results["options"], results["body"]
    width = {350: "10 in", 105: "3 in"}[results["nodes"][0]]
    if body["shape"] == "disc sector":
        size = (
            f"{np.degrees(body['angle']):.0f} degrees, radii {1e3 * body['inner_radius']:g} and {1e3 * body['outer_radius']:g} "
            f"mm, "
        )
        size += f"{1e3 * body['thickness']:g} mm thick"
    else:
        size = f"{1e3 * body['radius']:.2f} mm radius"
    if body["shape"] == "cylinder":
        size += f", {1e3 * body['length']:.1f} mm long, flat ends"
    return [
        (
            "Sheet",
            f"{width}, {plies(results)} of {' x '.join(map(str, results['nodes']))} nodes, {results['segments']} yarn "
            f"segments, held at {options['attachment'].replace('_', ' ')}, {fabric(results)}, seed {options['seed']}",
        ),
        ("Fragment", f"{body['shape']}, {1e3 * body['mass']:.1f} g, {size}"),
        (
            "Flight",
            f"{options['speed']:g} m/s at {options['standoff']:g} m before the sheet; gravity, quadratic drag (coefficient "
            f"{body['drag_coefficient']:g}); spin {options['spin']:g} rad/s about the axis, tilt {options['tilt']:g} degrees",
        ),
        (
            "Coupling",
            "FMI 2.0 co-simulation, drive prescribed: FMU first, host second, step-mean force and torque; communication step "
            f"{1e6 * options['step']:g} µs, internal step {1e6 * results['scene'][2]['time_step.seconds']:g} µs",
        ),
    ]


def plies(results):
    return plies_of(results["options"]["plies"], results["plies"])


def fabric(results):
    return ZYLON if results["scene"][1] else PAPER


def main():
    folder = pathlib.Path(sys.argv[1])
    runs = [
        (place, json.loads((place / "results.json").read_text()))
        for place in (folder, folder / "pack")
        if (place / "results.json").exists()
    ]
    results, html = runs[0][1], page.Page("A rotorburst fragment against a fabric shield")
    plots(folder, results)
    html.text(
        f"A {results['body']['shape']} of {1e3 * results['body']['mass']:.1f} g at {results['impact_speed']:.0f} m/s against a "
        f"sheet held at {results['options']['attachment'].replace('_', ' ')}, of {fabric(results)}: a host flies the fragment, "
        "an FMU holds the fabric."
    )
    for _, run in runs:
        html.answer(answer(run))
    if fabric(results) == PAPER:
        html.text(CAVEAT)
    draw(runs)
    for place, run in runs:
        html.figure(place / "sheet.png", f"{plies(run)}: {PICTURES}")
    html.section(f"The event, {plies(results)}")
    for name, _, _, caption in PLOTS:
        html.figure(folder / f"{name}.svg", caption)
    html.section("What these numbers mean")
    for text in MEANING:
        html.text(text.format(", and separate plies" if results["plies"] == 1 else ""))
    after = ", after perforation" if went_through(results) else ""
    html.fold("What was simulated")
    html.table(["", ""], parameter_rows(results), (1,))
    html.fold("All results")
    html.table(["", ""], [(name, value.replace(" us", " µs")) for name, value in result_rows(results)], (1,))
    outputs = results["outputs"]
    if results["plies"] > 1:
        names = ["ply.failed_segments", "ply.kinetic", "ply.strain", "ply.dissipated"]
        html.fold(f"Each ply at the end{after}")
        rows = [[k, *(f"{outputs[name][k]:.4g}" for name in names)] for k in range(min(results["plies"], 8))]
        html.table(["ply", "failed segments", "kinetic, J", "strain, J", "dissipated, J"], rows)
    html.fold(f"Balances between host and shield, at the end of the run{after}")
    html.text(BALANCES)
    rows = [
        (
            name,
            entry["unit"],
            f"{entry['ours']:.6g}",
            f"{entry['theirs']:.6g}",
            f"{entry['difference']:.2e}",
            f"{entry['relative']:.1e}",
            entry["scale"],
        )
        for name, entry in results["balances"].items()
    ]
    html.table(["balance", "unit", "one side", "other side", "difference", "relative", "to"], rows, (6,))
    html.fold("How to run it again")
    options = "".join(f" --{name} {value}" for name, value in results["options"].items())
    html.text("cargo xtask demo; or, with the environment and the FMU that it has made:")
    html.text(
        "target/venv/bin/python examples/rotorburst/rotorburst.py --fmu target/fmu/FabricShield-fmi2.fmu "
        f"--out results{options} and then target/venv/bin/python examples/rotorburst/report.py results"
    )
    html.write(folder / "report.html")


if __name__ == "__main__":
    main()
