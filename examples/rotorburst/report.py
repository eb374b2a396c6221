"""Draws the plots of a run and writes report.html, one file that needs no other.

    python report.py results

Reads what rotorburst.py wrote, and the same of a second run with more plies in the folder `pack`, if that is there. The pictures of the sheet are of the
same impact with the kernel moving the fragment, by the package fabric_kernel.
"""

import json
import pathlib
import sys

import numpy as np
import pandas
from balances import result_rows, went_through
from fabric_kernel import Scene, Simulation, page, plot, sheets

ENDS = ["arrested", "exited", "passed", "rebounded"]
CAVEAT = (
    "Not yet the numbers of a real fabric: the yarn area of the source paper is about 3.7 times too large for its mass, so the yarn is as much too "
    "stiff and strong: calibrate the area before using absolute numbers."
)
PICTURES = (
    "the whole sheet from the side the fragment leaves by, coloured by strain until it fails. The fragment is dashed where the sheet hides it."
)
# Plots over time: file, label, columns of history.csv with their names and factors, caption.
PLOTS = [
    ("velocity", "velocity along the flight (m/s)", {"velocity[3]": ("velocity", 1.0)}, "Velocity of the fragment."),
    ("force", "force on the fragment (kN)", {"contact.force_mean[3]": ("mean over a communication step", -1e-3)},
     "Force on the fragment against its flight. A flat end sweeps up its nodes within the first step: an impulse, whose mean force depends on the "
     "time over which it is taken."),
    ("energies", "energy (J)", {
        "contact.work": ("absorbed (work of the fragment)", 1.0), "energy.kinetic": ("kinetic energy of the sheet", 1.0), "energy.strain": ("strain energy", 1.0),
        "energy.dissipated": ("dissipated by rupture", 1.0), "energy.contact_loss": ("lost in nodal impacts", 1.0),
    }, "Energy the fabric has absorbed, and where it is."),
    ("failed_segments", "failed segments", {"fabric.failed_segments": ("failed", 1.0)}, "Yarn segments that have lost all stiffness."),
]  # fmt: skip
MEANING = (
    "After the first failed segment the model is chaotic: a change of the speed in the 13th digit changes the pattern of failure. One run is one draw; "
    "residual velocity, absorbed energy and failed segments are to be compared as ensembles, over seeds or over slightly changed speeds. The same run on "
    "another machine gives the same FMU bits for the same inputs.",
    "Not modelled: friction between yarns, bending, slip of yarns at crossings and clamps, interchange of crimp, deformation of the fragment. Options that "
    "this run does not use are friction on the fragment and dependence on strain rate{}.",
    "The host's drag is that of a body flying straight; lift and tumbling drag are left out.",
)
REPEATED = (
    "The FMU gives no node positions: the pictures are of the reference run of the same impact with the kernel moving the fragment itself, without gravity "
    "and drag during contact. The two runs are the same up to the coupling error until the first segment fails. From then on rounding decides which "
    "segment fails next, so they differ as two runs of the same set-up differ:"
)
BALANCES = (
    "The host's own bookkeeping against the FMU's outputs at the end of the run. Gravity and drag are taken out of the host's side. The difference in "
    "energy is the error of the coupling at this communication step; the shield's own energy balance shows the error of its time step."
)


class Repeated:
    """The same impact with the kernel moving the fragment: sheets on the way, of a stack the last ply, and how it ended."""

    def __init__(self, results):
        preset, changes = results["scene"]
        self.simulation, self.ending, self.sheets = Simulation(Scene(preset, changes), warns=False), None, []
        for time in results["pictures"]:
            self.go_on(time)
            self.sheets.append(sheets.Sheet.of(self.simulation, results["plies"] - 1))
        self.go_on(results["options"]["limit"] if not self.ending else 0.0)
        self.ending = self.ending or self.now("time limit")

    def now(self, end):
        simulation = self.simulation
        return end, simulation.projectile()["velocity"][2], simulation.contact()["work"], simulation.counters()["failed_segments"]

    def go_on(self, time):
        """To a time after the start, with a look at the ending on the way."""
        simulation, step = self.simulation, round(time / self.simulation.step_limits["dt"])
        if not self.ending:
            simulation.run(ENDS, max(step - simulation.step_count, 0))
            self.ending = next((self.now(end) for end in ENDS if end in simulation.outcomes()), None)
        simulation.run([], max(step - simulation.step_count, 0))

    @plot.styled
    def draw(self, path, zero):
        # As much room for all as the last one needs.
        figure, panels = plot.new(11.0, 8.4, 2, 2, sharex=True, sharey=True)
        for panel, sheet in zip(panels.flat, self.sheets):
            sheet.draw_oblique(panel)
            panel.set_title(f"{1e6 * (sheet.time - zero):.0f} µs after first contact", fontsize=10)
        sheets.bar(figure, panels, self.sheets[-1], "strain (%)")
        plot.save(figure, path)


def plots(folder, results):
    """One picture for each of PLOTS, of the time during which host and shield are coupled."""
    rows = pandas.read_csv(folder / "history.csv")
    rows, zero = rows[rows["time"] > results["start"]], results["first_contact"] if results["first_contact"] >= 0.0 else results["start"]
    events = [(results["end_time"], results["end"])]
    if "detached" in results:
        events.append((results["detached"]["time"], "detached"))
    elif went_through(results):
        work = rows["contact.work"]
        events.append((rows["time"][work >= 0.99 * work.max()].iloc[0], "99 % absorbed"))
    marks, times = [(1e6 * (time - zero), name) for time, name in events], 1e6 * (rows["time"] - zero)
    for name, label, columns, _ in PLOTS:
        series = [plot.Series(words, list(zip(times, scale * rows[column])), "line") for column, (words, scale) in columns.items()]
        plot.draw(folder / f"{name}.svg", "", "time since first contact (µs)", label, series, "linear" if name == "velocity" else "from zero", marks=marks)


def parameter_rows(results):
    """What was simulated."""
    options, body = results["options"], results["body"]
    width = {350: "10 in", 105: "3 in"}[results["nodes"][0]]
    if body["shape"] == "disc sector":
        size = f"{np.degrees(body['angle']):.0f} degrees, radii {1e3 * body['inner_radius']:g} and {1e3 * body['outer_radius']:g} mm, "
        size += f"{1e3 * body['thickness']:g} mm thick"
    else:
        size = f"{1e3 * body['radius']:.2f} mm radius"
    if body["shape"] == "cylinder":
        size += f", {1e3 * body['length']:.1f} mm long, flat ends"
    return [
        ("Sheet", f"{width}, {plies_of(results)} of {' x '.join(map(str, results['nodes']))} nodes, {results['segments']} yarn "
         f"segments, held at {options['attachment'].replace('_', ' ')}, the yarn of Powell and Zohdi (2009), stochastic, seed {options['seed']}"),
        ("Fragment", f"{body['shape']}, {1e3 * body['mass']:.1f} g, {size}"),
        ("Flight", f"{options['speed']:g} m/s at {options['standoff']:g} m before the sheet; gravity, quadratic drag (coefficient "
         f"{body['drag_coefficient']:g}); spin {options['spin']:g} rad/s about the axis, tilt {options['tilt']:g} degrees"),
        ("Coupling", f"FMI 2.0 co-simulation, drive prescribed: FMU first, host second, step-mean force and torque; "
         f"communication step {1e6 * options['step']:g} µs, internal step 0.02 µs"),
    ]  # fmt: skip


def plies_of(results):
    """How many plies, and how they are connected."""
    bonded, separate = results["options"]["plies"], results["plies"]
    if separate > 1:
        return f"{separate} separate plies" + (f" of {bonded} bonded ones each" if bonded > 1 else "")
    return f"{bonded} bonded plies" if bonded > 1 else "1 ply"


def answer(results):
    """The answer of a run: stopped or not, the residual velocity, the absorbed energy."""
    through, stopped, detached = went_through(results), results["end"] in ("arrested", "rebounded"), results.get("detached")
    verdict = "went through" if through else "stopped" if stopped else "not decided when the time was over"
    absorbed = detached["absorbed"] if through and detached else results["outputs"]["contact.work"]
    lines = [
        f"{plies_of(results)}: {verdict}",
        f"Residual velocity along the flight: {0.0 if stopped else results['velocity'][2]:.1f} m/s of {results['impact_speed']:.1f} m/s.",
        f"Absorbed energy: {absorbed:.1f} J of {results['impact_energy']:.1f} J.",
    ]
    if stopped:
        sideways, spin = np.hypot(*results["velocity"][:2]), np.linalg.norm(results["angular_velocity"])
        lines += [
            f"Largest deflection of the sheet: {1e3 * results['outputs']['fabric.max_deflection']:.1f} mm.",
            f"Left in the fragment as it turns back: {sideways:.0f} m/s sideways and {spin:.0f} rad/s of spin.",
        ]
    else:
        lines.append(f"Failed yarn segments: {results['outputs']['fabric.failed_segments']:.0f} of {results['segments']}.")
    if results["options"]["plies"] > 1:
        lines.append("The plies are one network (sheet.plies): none of them moves apart from the others.")
    print(f"{lines[0]}. {' '.join(lines[1:3])}")
    return lines


def main():
    folder = pathlib.Path(sys.argv[1])
    runs = [(place, json.loads((place / "results.json").read_text())) for place in (folder, folder / "pack") if (place / "results.json").exists()]
    results, html = runs[0][1], page.Page("A rotorburst fragment against a fabric shield")
    plots(folder, results)
    html.text(
        f"A {results['body']['shape']} of {1e3 * results['body']['mass']:.1f} g at {results['impact_speed']:.0f} m/s against a sheet of the yarn of Powell and "
        f"Zohdi (2009), held at {results['options']['attachment'].replace('_', ' ')}: a host flies the fragment, an FMU holds the fabric."
    )
    for _, run in runs:
        html.answer(answer(run))
    html.text(CAVEAT)
    repeated = [Repeated(run) for _, run in runs]
    for (place, run), again in zip(runs, repeated):
        again.draw(place / "sheet.png", max(run["first_contact"] - run["start"], 0.0))
        html.figure(place / "sheet.png", f"{plies_of(run)}: {PICTURES}")
    html.section(f"The event, {plies_of(results)}")
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
    html.fold("The run of the pictures beside that of the numbers")
    html.text(REPEATED)
    own = results["end"], results["velocity"][2], outputs["contact.work"], outputs["fabric.failed_segments"]
    names = ("end", "residual velocity (z), m/s", "absorbed energy, J", "failed segments")
    shown = [[name, *(page.shown(value, digits) for value in both)] for name, digits, *both in zip(names, (None, 3, 3, 0), own, repeated[0].ending)]
    html.table(["", "co-simulation (this report)", "kernel alone"], shown)
    html.fold(f"Balances between host and shield, at the end of the run{after}")
    html.text(BALANCES)
    rows = [(name, entry["unit"], f"{entry['ours']:.6g}", f"{entry['theirs']:.6g}", f"{entry['difference']:.2e}", f"{entry['relative']:.1e}", entry["scale"])
            for name, entry in results["balances"].items()]  # fmt: skip
    html.table(["balance", "unit", "one side", "other side", "difference", "relative", "to"], rows, (6,))
    html.fold("How to run it again")
    html.text(
        "cargo xtask demo, or with the environment and the FMU that it has made: target/venv/bin/python examples/rotorburst/rotorburst.py --fmu "
        f"target/fmu/FabricShield-fmi2.fmu --out results{''.join(f' --{name} {value}' for name, value in results['options'].items())} and then "
        "target/venv/bin/python examples/rotorburst/report.py results"
    )
    html.write(folder / "report.html")


if __name__ == "__main__":
    main()
