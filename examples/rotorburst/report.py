"""Draws the plots of a run and writes report.html, one file that needs no other.

    python report.py results

Reads what rotorburst.py wrote, and snapshots.bin of the kernel's example `snapshots` if it is there; the same of a second run with
more plies in the folder `pack`, if that is there.
"""

import base64
import html
import json
import pathlib
import sys

import numpy as np
import plots
from balances import result_rows, went_through

STYLE = """
body { font: 16px/1.55 system-ui, sans-serif; color: #1f2937; max-width: 62rem; margin: 2.5rem auto; padding: 0 1.25rem; }
h1 { font-size: 1.75rem; line-height: 1.2; margin-bottom: .3rem; }
h2 { font-size: 1.2rem; margin-top: 2.4rem; border-bottom: 1px solid #d1d5db; padding-bottom: .25rem; }
p.lead { color: #4b5563; margin-top: 0; }
.card { border-left: .4rem solid #6b7280; background: #f3f4f6; border-radius: .4rem; padding: .7rem 1.1rem; }
.card b { display: block; font-size: 1.35rem; } .through { border-color: #b8322a; } .stopped { border-color: #3c7d4a; }
.card p { margin: .2rem 0; } p.caveat { border: 1px solid #d98a1f; border-radius: .4rem; padding: .7rem 1.1rem; }
details { border-top: 1px solid #d1d5db; padding: .5rem 0; } summary { font-weight: 600; cursor: pointer; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; }
td, th { padding: .3rem .8rem .3rem 0; border-bottom: 1px solid #e5e7eb; text-align: left; vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)); gap: 1rem; }
figure { margin: 1rem 0; } img { width: 100%; } figcaption { font-size: .85rem; color: #4b5563; }
@media (max-width: 40rem) { table { display: block; overflow-x: auto; } }
pre { background: #f3f4f6; border-radius: .4rem; padding: .7rem .9rem; white-space: pre-wrap; font-size: .85rem; }
"""


def figure(path, caption):
    """An embedded picture."""
    data = base64.b64encode(path.read_bytes()).decode()
    caption = html.escape(caption)
    return f'<figure><img alt="{caption}" src="data:image/png;base64,{data}"><figcaption>{caption}</figcaption></figure>'


def table(rows, numbers=(), header=None):
    """Rows of texts; the columns `numbers` are set flush right."""
    kind = [' class="number"' if k in numbers else "" for k in range(len(rows[0]))]

    def line(cells, tag):
        return "<tr>" + "".join(f"<{tag}{c}>{html.escape(str(x).strip())}</{tag}>" for x, c in zip(cells, kind)) + "</tr>"

    return "<table>" + (line(header, "th") if header else "") + "".join(line(row, "td") for row in rows) + "</table>"


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


def card(results):
    """The answer of a run: stopped or not, the residual velocity, the absorbed energy."""
    through, stopped, detached = went_through(results), results["end"] == "arrested", results.get("detached")
    answer = "went through" if through else "stopped" if stopped else "not decided when the time was over"
    absorbed = detached["absorbed"] if through and detached else results["outputs"]["contact.work"]
    lines = [
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
    print(f"{plies_of(results)}: {answer}. {' '.join(lines[:2])}")
    kind = "through" if through else "stopped" if stopped else ""
    return f'<div class="card {kind}"><b>{plies_of(results)}: {answer}</b>{"".join(f"<p>{line}</p>" for line in lines)}</div>'


def folded(title, *parts):
    """What a reader opens if needed."""
    return f"<details><summary>{title}</summary>{''.join(parts)}</details>"


def comparison(results, snapshots):
    """Co-simulated and integrated run side by side."""
    outcome = {0.0: "arrested", 2.0: "exited", 3.0: "passed"}.get(snapshots.outcome, "time limit")
    outputs = results["outputs"]
    rows = [
        ("end", results["end"], outcome),
        ("residual velocity (z), m/s", f"{results['velocity'][2]:.3f}", f"{snapshots.velocity[2]:.3f}"),
        ("absorbed energy, J", f"{outputs['contact.work']:.3f}", f"{snapshots.absorbed:.3f}"),
        ("failed segments", f"{outputs['fabric.failed_segments']:.0f}", int(snapshots.failed)),
    ]
    return table(rows, numbers=(1, 2), header=("", "co-simulation (this report)", "kernel alone"))


def main():
    folder = pathlib.Path(sys.argv[1])
    results = json.loads((folder / "results.json").read_text())
    times = plots.Times(plots.read_history(folder / "history.csv"), results)
    plots.velocity(times, folder / "velocity.png")
    plots.force(times, folder / "force.png", results["options"]["step"])
    plots.energies(times, folder / "energies.png")
    plots.damage(times, folder / "failed_segments.png")
    pack = folder / "pack"
    packed = json.loads((pack / "results.json").read_text()) if (pack / "results.json").exists() else None
    body, options = results["body"], results["options"]
    parts = [
        "<h1>A rotorburst fragment against a fabric shield</h1>",
        f'<p class="lead">A {body["shape"]} of {1e3 * body["mass"]:.1f} g at {results["impact_speed"]:.0f} m/s against a sheet of the '
        f"yarn of Powell and Zohdi (2009), held at {options['attachment'].replace('_', ' ')}: a host flies the fragment, an FMU holds the fabric.</p>",
        f'<div class="pair">{card(results)}{card(packed) if packed else ""}</div>',
        '<p class="caveat"><b>Not yet the numbers of a real fabric.</b> The yarn area of the source paper is about 3.7 times too large '
        "for its mass, so the yarn is as much too stiff and strong: calibrate the area before using absolute numbers.</p>",
    ]  # fmt: skip
    for place, run in [(folder, results)] + ([(pack, packed)] if packed else []):
        if (place / "snapshots.bin").exists():
            plots.sheet(plots.Snapshots(place / "snapshots.bin"), run, place / "sheet.png")
            parts.append(figure(place / "sheet.png", f"{plies_of(run)}: the whole sheet from the side the fragment leaves by, coloured by "
                                "strain until it fails; dark is what is behind it. The fragment is dashed where the sheet hides it."))  # fmt: skip
    parts += [
        f"<h2>The event, {plies_of(results)}</h2>",
        '<div class="pair">',
        figure(folder / "velocity.png", "Velocity of the fragment."),
        figure(folder / "force.png", "Force on the fragment against its flight. A flat end sweeps up its nodes within the first step: "
               "an impulse, whose mean force depends on the time over which it is taken."),
        figure(folder / "energies.png", "Energy the fabric has absorbed, and where it is."
               + (" After perforation (grey) the torn cloth goes on moving without it." if went_through(results) else "")),
        figure(folder / "failed_segments.png", "Yarn segments that have lost all stiffness."),
        "</div>",
    ]  # fmt: skip
    entries = results["balances"].items()
    balances = [(name, entry["unit"], f"{entry['ours']:.6g}", f"{entry['theirs']:.6g}", f"{entry['difference']:.2e}",
              f"{entry['relative']:.1e}", entry["scale"]) for name, entry in entries]  # fmt: skip
    after = ", after perforation" if went_through(results) else ""
    parts += [
        "<h2>What these numbers mean</h2>",
        "<ul><li>After the first failed segment the model is chaotic: a change of the speed in the 13th digit changes the pattern of "
        "failure. One run is one draw; residual velocity, absorbed energy and failed segments are to be compared as "
        "ensembles, over seeds or over slightly changed speeds. The same run on another machine gives the same FMU bits for the same "
        "inputs.</li>"
        "<li>Not modelled: friction between yarns, bending, slip of yarns at crossings and clamps, interchange of crimp, deformation of the "
        "fragment. Options that this run does not use are friction on the fragment and dependence on strain rate"
        f"{', and separate plies' if results['plies'] == 1 else ''}.</li>"
        "<li>The host's drag is that of a body flying straight; lift and tumbling drag are left out.</li></ul>",
        folded("What was simulated", table(parameter_rows(results))),
        folded("All results", table([(name.replace(" us", " µs"), value.replace(" us", " µs")) for name, value in result_rows(results)])),
    ]  # fmt: skip
    if results["plies"] > 1:
        names = ["ply.failed_segments", "ply.kinetic", "ply.strain", "ply.dissipated"]
        rows = [[k, *(f"{results['outputs'][name][k]:.4g}" for name in names)] for k in range(min(results["plies"], 8))]
        header = ("ply", "failed segments", "kinetic, J", "strain, J", "dissipated, J")
        parts.append(folded(f"Each ply at the end{after}", table(rows, numbers=(1, 2, 3, 4), header=header)))
    if (folder / "snapshots.bin").exists():
        parts.append(folded(
            "The run of the pictures beside that of the numbers",
            "<p>The FMU gives no node positions: the pictures are of the reference run of the same impact with the kernel moving the "
            "fragment itself, without gravity and drag during contact. The two runs are the same up to the coupling error until the first "
            "segment fails. From then on rounding decides which segment fails next, so they differ as two runs of the same set-up differ:</p>",
            comparison(results, plots.Snapshots(folder / "snapshots.bin")),
        ))  # fmt: skip
    parts += [
        folded(
            f"Balances between host and shield, at the end of the run{after}",
            "<p>The host's own bookkeeping against the FMU's outputs at the end of the run. Gravity and drag are taken out of the "
            "host's side. The difference in energy is the error of the coupling at this communication step; the shield's own energy "
            "balance shows the error of its time step.</p>",
            table(balances, numbers=(1, 2, 3, 4, 5), header=("balance", "unit", "one side", "other side", "difference", "relative", "to")),
        ),
        folded(
            "How to run it again",
            "<pre>cargo xtask demo\n\n"
            "# other cases, with the environment and the FMU that the demo has made:\n"
            "target/venv/bin/python examples/rotorburst/rotorburst.py --fmu target/fmu/FabricShield-fmi2.fmu \\\n"
            f"    --out results{shown_options(results)}\n"
            "target/venv/bin/python examples/rotorburst/report.py results</pre>",
        ),
    ]  # fmt: skip
    page = f"<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>Rotorburst fragment against a fabric shield</title><style>{STYLE}</style></head><body>\n"
    path = folder / "report.html"
    path.write_text(page + "\n".join(parts) + "\n</body></html>\n", encoding="utf-8")
    print(f"\nReport: {path}")


def shown_options(results):
    """The run's options as on a command line."""
    return "".join(f" --{name} {value}" for name, value in results["options"].items())


if __name__ == "__main__":
    main()
