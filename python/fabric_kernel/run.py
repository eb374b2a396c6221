"""`fabric run SCENE`: one impact; a table, history.csv, summary.json, pictures and report.html."""

import argparse
import csv
import gzip
import io
import json
import math
import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tqdm

from . import about as scenes
from . import batch, page, runs
from ._kernel import PRESETS, Failed, Scene, Simulation
from .about import SUMMARY
from .ensembles import scaled
from .files import apart, naming, reading, shown, written
from .textile import spacings

TIMEOUT = 3
"""Exit status of a run that its steps ended."""
OUTCOMES = ("arrested", "detached", "exited", "passed", "rebounded", "through", "none")
SUFFIX = {"s": "_s", "m": "_m", "m/s": "_m_per_s", "rad/s": "_rad_per_s", "N": "_n", "J": "_j"}
COLUMNS = (
    "step time position_x position_y position_z velocity_x velocity_y velocity_z angular_velocity_x angular_velocity_y "
    "angular_velocity_z force_x force_y force_z absorbed contact_loss projectile_kinetic fabric_kinetic strain dissipated "
    "viscous friction ply_loss support_work casing_loss attachment energy_residual momentum_residual_n_s failed_segments "
    "contacts max_deflection max_stretch"
).split()
"""Columns of history.csv, without their units."""
PICTURES = ("report.html", "sheet.png", "plies.png", "damage.png", "profile.svg", "history.svg")
FILES = ("history.csv", "scene.toml", "state.gz", "movie.gif", "vtk/run.pvd")
SIDES = ("side -x", "side +x", "side -y", "side +y")
CORNERS = ("corner -x -y", "corner +x -y", "corner -x +y", "corner +x +y")
MOST_FRAMES = 120


class Frames:
    """Sheets on the way: of the first ply for a movie, of all as VTK files. Of too many, every second one is given up."""

    def __init__(self, out: Path, movie: bool, vtk: bool) -> None:
        self.folder, self.movie, self.vtk = out / "vtk", movie, vtk
        self.kept: list[tuple[Any, float, list[str]]] = []
        self.calls, self.stride = 0, 1

    def keep(self, simulation: Simulation) -> None:
        """Keeps the sheet as it is now; after many calls only in each second, fourth, ... one."""
        self.calls += 1
        if (self.movie or self.vtk) and (self.calls - 1) % self.stride == 0:
            self.add(simulation)
        if len(self.kept) > MOST_FRAMES:
            for file in [file for _, _, gone in self.kept[1::2] for file in gone]:
                (self.folder / file).unlink()
            self.kept, self.stride = self.kept[::2], 2 * self.stride

    def add(self, simulation: Simulation) -> None:
        from . import sheets  # Only where pictures are made, as it loads matplotlib.

        plies = [sheets.Sheet(simulation, ply) for ply in range(simulation.scene["stack.plies"] if self.vtk else 1)]
        step, files = simulation.step_count, []
        if self.vtk:
            files = [f"projectile_{step:08}.vtp", *(f"sheet_{step:08}_{ply}.vtp" for ply in range(len(plies)))]
            self.folder.mkdir(parents=True, exist_ok=True)
            plies[0].vtk_of_body(self.folder / files[0])
            for sheet, file in zip(plies, files[1:]):
                sheet.vtk(self.folder / file)
        self.kept.append((plies[0] if self.movie else None, simulation.time, files))

    def write(self, out: Path, simulation: Simulation) -> list[str]:
        """Adds the sheet at the end; movie.gif and vtk/run.pvd, and their names."""
        if self.kept and self.kept[-1][1] != simulation.time:
            self.add(simulation)
        if self.movie:
            from . import movie

            movie.written([sheet for sheet, _, _ in self.kept], out / "movie.gif")
        if self.vtk:
            from . import sheets

            sheets.vtk_series(self.folder / "run.pvd", [(time, files) for _, time, files in self.kept])
        return ["movie.gif"] * self.movie + ["vtk/run.pvd"] * self.vtk


Row = dict[str, Any]


def flown(
    scene: Scene, until: Sequence[str], steps: int, every: int, *, frames: Frames, say: Any, capsule: Path | None
) -> tuple[Simulation, list[Row], str]:
    """The simulation at its end, a row of its history for every `every` steps, and the text of the failure that ended it, if one
    did."""
    rows: list[Row] = []
    with naming(capsule or "capsule"):
        simulation, failure = Simulation(scene, capsule=capsule), ""

    def look() -> None:
        frames.keep(simulation)
        rows.append(runs.sample(simulation, rows[-1] if rows else None))
        rows[-1]["momentum_residual_n_s"] = math.hypot(*simulation.momentum_residual())

    look()
    try:
        for _ in runs.stepped(simulation, until, steps, lambda: every):
            look()
            say(simulation)
    except Failed as failed:
        failure = f"the run failed at step {simulation.counters()['steps']}: {failed}"
    return simulation, rows, failure


def history_csv(rows: list[Row]) -> str:
    """The text of history.csv: SI units, host's axes."""

    def named(column: str) -> str:
        unit = next((unit for unit, begins in runs.UNITS.items() if any(column.startswith(begin) for begin in begins)), "")
        return column + SUFFIX.get(unit, "")

    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(named(column) for column in COLUMNS)
    writer.writerows([row[column] for column in COLUMNS] for row in rows)
    return text.getvalue()


def plies_of(simulation: Simulation, names: tuple[str | None, str | None]) -> list[Row]:
    """Fabric of each ply of a stack, and what the ply holds; nothing of a single sheet."""
    scene = simulation.scene
    count, back = scene["stack.plies"], scene["back.plies"]
    if count == 1:
        return []
    rows = []
    h_x, h_y = spacings(scene)
    for ply in range(count):
        last = ply >= count - back
        mass, modulus = (
            (scene["back.node_mass"], scene["back.modulus_mean"])
            if last
            else (scene["sheet.node_mass"], scene["yarn.modulus_mean"])
        )
        strain = scene["back.critical_stretch" if last else "yarn.critical_stretch"] - 1.0
        density = mass * scene["sheet.plies"] / (h_x * h_y)
        fabric = f"{density:.3f} kg/m2, {1e-9 * modulus:.1f} GPa, fails from {100 * strain:.2f} %"
        name = names[1 if last else 0]
        row = {"fabric": f"{name}: {fabric}" if name else fabric, "turned": bool(scene["stack.turned"] and ply % 2)}
        rows.append(row | dict(simulation.ply(ply)))
    return rows


def summary_of(
    name: str, simulation: Simulation, rows: list[Row], until: Sequence[str], plies: list[Row], remarks: list[str]
) -> dict[str, Any]:
    """summary.json: SI units, host's axes. The same on every machine, bit by bit."""
    come, scene = simulation.outcomes(), simulation.scene
    ended = " and ".join(outcome for outcome in come if outcome in until) or "TIMEOUT"
    summary = {
        "scene": name,
        "ended_by": ended,
        "steps": simulation.step_count,
        "time": simulation.time,
        "impact_energy": rows[0]["projectile_kinetic"],
        "step_limits": simulation.step_limits(),
        "outcomes": come,
        "projectile": simulation.projectile(),
        "contact": simulation.contact(),
        "support": simulation.support(),
        "energy": simulation.energy(),
        "fabric": simulation.fabric(),
        "counters": simulation.counters(),
        "max_deflection": max(row["max_deflection"] for row in rows),
        "momentum_residual": math.hypot(*simulation.momentum_residual()),
        "plies": plies,
        "digest": simulation.digest,
    }
    row = {"outcome": ended.lower(), "absorbed": summary["contact"]["work"], "max_deflection": summary["max_deflection"]}
    row |= {"impact_energy": summary["impact_energy"], "energy_residual": summary["energy"]["residual"]}
    return summary | {"warnings": [*remarks, *runs.doubts([scene], [summary["counters"] | summary["energy"] | row])]}


def lines_of(scene: Scene, summary: dict[str, Any]) -> list[tuple[str, str]]:
    """The table that is printed: what, value."""
    energy, counters, contact, support = summary["energy"], summary["counters"], summary["contact"], summary["support"]
    vector = lambda values, digits=3: "  ".join(f"{value + 0.0:.{digits}f}" for value in values)
    joules = lambda value: f"{value + 0.0:.4f} J"
    limits, stack = summary["step_limits"], scene["stack.plies"] > 1
    rows = [
        ("time step", f"{limits['dt']:.4e} s = {limits['dt'] / limits['dt_crit']:.3f} dt_crit"),
        ("sheet held", scene["attachment.kind"].replace("_", " ")),
        ("ended by", f"{summary['ended_by']} at {1e6 * summary['time']:.1f} us, step {summary['steps']}"),
        ("velocity left x, y, z", f"{vector(summary['projectile']['velocity'])} m/s"),
    ]
    if scene["projectile.shape"] != "sphere":
        rows.append(("angular velocity left", f"{vector(summary['projectile']['angular_velocity'], 2)} rad/s"))
    rows += [
        (f"absorbed when {name}", f"{joules(latch['work'])} at {1e6 * latch['time']:.1f} us")
        for name, latch in summary["outcomes"].items()
    ]
    rows += [
        ("absorbed, of the impact energy", f"{joules(contact['work'])} of {joules(summary['impact_energy'])}"),
        ("  kinetic energy of the fabric", joules(energy["fabric_kinetic"])),
        ("  strain energy", joules(energy["strain"])),
        ("  dissipated by rupture", joules(energy["dissipated"])),
        ("  dissipated by viscosity", joules(energy["viscous"])),
        ("  dissipated by friction", joules(energy["friction"])),
        ("  lost in contact", joules(energy["contact_loss"])),
        ("  work on held nodes", joules(energy["support_work"])),
    ]
    rows += [("  lost where plies meet", joules(energy["ply_loss"]))] * stack
    rows += [("  lost on the case", joules(energy["casing_loss"]))] * bool(scene["casing.radius"])
    rows += [("  dissipated in clamps", joules(energy["attachment"]))] * bool(scene["attachment.hold"])
    rows += [
        (f"peak force, mean over {1e6 * min(scene['force_window'], summary['time']):.2f} us", f"{contact['force_peak']:.1f} N"),
        ("failed segments", str(counters["failed_segments"])),
        ("largest deflection", f"{1e3 * summary['max_deflection']:.3f} mm"),
        ("impulse on the supports", f"{vector([1e3 * part for part in support['total']])} mN s"),
    ]
    names = CORNERS if scene["attachment.kind"] == "four_corners" else SIDES
    rows += [
        (f"  {name}", f"{vector([1e3 * part for part in one])} mN s")
        for name, one in zip(names, support["attachments"])
        if any(one)
    ]
    part = energy["residual"] / summary["impact_energy"] if summary["impact_energy"] else 0.0
    return [
        *rows,
        ("energy residual", f"{energy['residual']:.3e} J = {100 * part:.4f} % of the impact energy"),
        ("momentum residual", f"{summary['momentum_residual']:.3e} N s"),
        ("digest", summary["digest"]),
    ]


def table_of_plies(plies: list[Row]) -> tuple[list[str], list[list[Any]]]:
    """Heading and rows of what each ply is and holds, from the front."""
    heading = (
        "ply, from the side that is hit; fabric; turned by 90°; failed segments; kinetic, J; strain, J; dissipated, J"
    ).split("; ")
    energies = lambda ply: [f"{ply[key]:.4f}" for key in ("kinetic", "strain", "dissipated")]
    return heading, [
        [k + 1, ply["fabric"], "yes" if ply["turned"] else "no", ply["failed_segments"], *energies(ply)]
        for k, ply in enumerate(plies)
    ]


def report(
    out: Path, summary: dict[str, Any], simulation: Simulation, rows: Any, lines: list[tuple[str, str]], extra: list[str]
) -> None:
    """The pictures, and report.html with all of them."""
    from . import plot, sheets
    from .extras import pandas

    name, ended = summary["scene"], summary["ended_by"]
    marks = [(latch["time"], outcome) for outcome, latch in summary["outcomes"].items()]
    plot.history(pandas.DataFrame(rows), out / "history.svg", title=name, marks=marks)
    plies = [sheets.Sheet(simulation, ply) for ply in range(simulation.scene["stack.plies"])]
    sheet, failed, stack = plies[0], sum(ply.failed() for ply in plies), len(plies) > 1
    at = f"{name}: {'first ply' if stack else 'sheet'} at {1e6 * sheet.time:.1f} µs, {sheet.failed()} failed segments"
    pictures = [("sheet.png", at), *(("movie.gif", "The same from the start.") for file in extra if file == "movie.gif")]
    sheets.picture(sheet, out / "sheet.png", at)
    if stack:
        of_all = f"{name}: {len(plies)} plies at {1e6 * sheet.time:.1f} µs, {failed} failed segments"
        sheets.picture_of_stack(plies, out / "plies.png", of_all)
        pictures.append(("plies.png", of_all))
    sheets.damage_map(sheet, out / "damage.png", f"{name}: damage on the undeformed sheet")
    sheets.profile(plies[-1], out / "profile.svg", f"{name}: back face at {1e6 * sheet.time:.1f} µs")
    html = page.Page(f"{name}: {ended} at {1e6 * summary['time']:.1f} µs")
    html.answer(
        [
            f"{ended.capitalize()}: {math.hypot(*summary['projectile']['velocity']):.4g} m/s left, "
            f"{summary['contact']['work']:.4g} J of {summary['impact_energy']:.4g} J "
            f"absorbed; held cloth deflected by at most {1e3 * summary['max_deflection']:.3g} mm.",
            *filter(None, [runs.at_clamps(simulation)]),
            *summary["warnings"],
            f"One run of the model, with one sample of what is random. {scenes.CAVEAT}",
        ]
    )
    for file, caption in [
        *pictures,
        ("damage.png", "Damage on the undeformed sheet about what failed, seen along the line of flight; held nodes in grey."),
        ("profile.svg", "Deflection of the back face at the end, along both yarns under the projectile."),
        (
            "history.svg",
            "Velocity of the projectile, mean force on it between samples, largest deflection, and where the absorbed energy is.",
        ),
    ]:
        html.figure(out / file, caption)
    html.fold("All numbers")
    if not any(outcome in runs.STOPPED for outcome in summary["outcomes"]):
        html.text(
            "Energies are those of the end of the run: where the projectile went through, they hold what torn cloth did after "
            "it, too."
        )
    for sentence in scenes.described(simulation.scene):
        html.text(sentence)
    html.table(["", ""], lines, (1,))
    if stack:
        html.section("Plies")
        html.table(*table_of_plies(summary["plies"]), (1, 2))
    written(out / "report.html", html.html())


def reported(out: Path) -> dict[str, Any]:
    """Draws pictures and report of a run again, of the files in its folder, and returns its summary."""
    from .extras import pandas

    simulation = Simulation(Scene.read(out / "scene.toml"))
    with reading(out / SUMMARY):
        summary = json.loads((out / SUMMARY).read_bytes())
        steps, files, digest = summary["steps"], summary["files"], summary["digest"]
    with reading(out / "state.gz"):
        simulation.restore(gzip.decompress((out / "state.gz").read_bytes()))
    with reading(out / "history.csv"):
        rows = pandas.read_csv(out / "history.csv", float_precision="round_trip").set_axis(COLUMNS, axis=1)
        last = rows["step"].iloc[-1]
        if not (out / "history.csv").read_bytes().endswith(b"\n"):
            raise EOFError
    for name, is_of_it in (("state.gz", simulation.digest == digest), ("history.csv", last == steps)):
        if not is_of_it:
            raise ValueError(f"{out / name}: is of another run than {SUMMARY}")
    report(out, summary, simulation, rows, lines_of(simulation.scene, summary), files)
    return dict(summary)


def options() -> scenes.Parser:
    ends = (
        f"Exit status: 0 after an outcome, or after the steps with --until none; {TIMEOUT} if the steps ended the run; 1 after "
        f"a failure; 2 for what is refused."
    )
    parser = scenes.options("run", "One impact: a table, its history, pictures and a report.", ends)
    add = parser.add_argument
    add("scene", help=f"a scene file, or a preset: {', '.join(PRESETS)}")
    add("--out", type=Path, help="folder for report.html and all else; default: fabric-run/SCENE")
    add(
        "--until",
        type=outcomes,
        default=list(runs.UNTIL),
        metavar="OUTCOME,...",
        help=f"outcomes that end the run: {', '.join(OUTCOMES)}; default: {','.join(runs.UNTIL)}",
    )
    add("--speed", type=scenes.positive, metavar="V", help="of the projectile, m/s, in the direction of the scene")
    add("--seed", type=int, help="of the yarns' samples; default: that of the scene")
    add("--steps", type=at_least_one, default=runs.STEPS, help="most steps; default: %(default)s")
    add(
        "--sample",
        type=at_least_one,
        default=64,
        metavar="STEPS",
        help="steps between two rows of the history; default: %(default)s",
    )
    add("--movie", action="store_true", help="also movie.gif")
    add("--vtk", action="store_true", help="also a series for ParaView, vtk/run.pvd")
    add("--no-report", action="store_true", help="no pictures and no report: the table, history.csv and summary.json")
    add("--capsule", type=Path, metavar="FILE", help="also a capsule, which `fabric replay` does again")
    add(
        "--batch",
        type=Path,
        metavar="FILE.csv",
        help="a run for each row: the first line names parameters, as projectile.velocity[2]; writes batch.csv, which has each "
        "outcome, and runs.jsonl; exit status 0 whatever they are",
    )
    return parser


def at_least_one(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number, at least 1; it is {text}")
    return int(text)


def outcomes(text: str) -> list[str]:
    names = text.split(",")
    for name in names:
        if name not in OUTCOMES:
            raise argparse.ArgumentTypeError(f"there are {', '.join(OUTCOMES)}; it is {name}")
    return [name for name in names if name != "none"]


def named(scene: str) -> str:
    """Name of a scene by its file; one of dots alone would be another folder."""
    name = shown(Path(scene).name.removesuffix(".toml"))
    return name if name.strip(".") else "scene"


def removed(out: Path, kept: set[str]) -> None:
    """Removes what an earlier run wrote into a folder that has its summary, but for these files of vtk/."""
    try:
        with reading(out / SUMMARY):
            is_of_a_run = {"digest", "files"} <= set(json.loads((out / SUMMARY).read_bytes()))
    except (OSError, ValueError):
        return
    for name in (SUMMARY, *PICTURES, *FILES) if is_of_a_run else ():
        (out / name).unlink(missing_ok=True)
    for path in (out / "vtk").glob("*_????????*.vtp") if is_of_a_run else ():
        if path.name not in kept:
            path.unlink()


def one(given: argparse.Namespace, scene: Scene, name: str, out: Path, remarks: list[str]) -> dict[str, Any]:
    """One run as the options say, and its summary. A failure is raised once history.csv is written."""
    frames = Frames(out, given.movie, given.vtk)
    with tqdm.tqdm(bar_format="{desc}", disable=not sys.stderr.isatty(), leave=False, delay=1.0) as bar:
        say = lambda simulation: bar.set_description_str(f"{name}: {runs.where(simulation)}")
        simulation, rows, failure = flown(
            scene, given.until, given.steps, given.sample, frames=frames, say=say, capsule=given.capsule
        )
    given.kept = out, f"{out} has a part of the files of this run"
    removed(out, {file for _, _, files in frames.kept for file in files})
    written(out / "history.csv", history_csv(rows))
    if failure:
        raise RuntimeError(failure)
    summary = summary_of(name, simulation, rows, given.until, plies_of(simulation, scene.fabrics), remarks)
    summary["files"] = ["history.csv", "scene.toml", "state.gz", *frames.write(out, simulation), SUMMARY]
    written(out / "scene.toml", simulation.scene.to_toml())
    written(out / "state.gz", gzip.compress(simulation.save(), 1, mtime=0))
    lines = lines_of(scene, summary)
    if not given.no_report:
        report(out, summary, simulation, rows, lines, summary["files"])
    written(out / SUMMARY, json.dumps(summary, indent=1) + "\n")
    about = [textwrap.fill(sentence, 100) for sentence in scenes.described(scene)[:2]]
    text = "\n".join([*about, "", page.printed([name, ""], lines)])
    if summary["plies"]:
        heading, cells = table_of_plies(summary["plies"])
        text += "\n" + page.printed(["ply", *heading[3:]], [row[:1] + row[3:] for row in cells])
    print(text, flush=True)
    for warning in summary["warnings"]:
        print(f"warning: {warning}", file=sys.stderr)
    print(f"written to {out}: {', '.join([*([] if given.no_report else PICTURES[:1]), *summary['files']])}", flush=True)
    return summary


def main(arguments: Sequence[str] | None = None) -> None:
    """The command `fabric run`."""
    parser = options()
    given = parser.parse_args(arguments)
    with scenes.ending(parser, given):
        scene = Scene.read(given.scene)
        remarks = scene.remarks
        if given.seed is not None:
            scene = scene.replace(seed=given.seed)
        if given.speed is not None:
            scene = scene.replace({"projectile.velocity": scaled(scene["projectile.velocity"], given.speed)})
        if "through" in given.until:
            scene = scene.replace(track_through=True)
        name = named(given.scene)
        out = given.out or Path("fabric-run") / name
        scene.check()
        if not out.parent.exists() and given.out:
            raise ValueError(f"--out: there is no folder {out.parent}")
        if given.batch:
            others = [name for name in ("movie", "vtk", "capsule") if getattr(given, name)]
            if others:
                raise ValueError(f"--batch: goes without --{others[0]}")
            apart([given.scene, given.batch], [out / "batch.csv", out / "runs.jsonl"])
            given.kept = scenes.goes_on(out / "runs.jsonl")
            with scenes.folder(out):
                table = batch.flown(scene, given.batch, out, given.until, given.steps)
            given.answer = table.to_dict("records")
            print(f"{batch.text(table)}written to {out}: batch.csv, runs.jsonl", flush=True)
            return
        files = [out / file for file in (SUMMARY, *PICTURES, *FILES)]
        apart([given.scene, given.capsule], files)
        apart([given.scene], [given.capsule] if given.capsule else [])
        scenes.of_others(out, SUMMARY)
        if kept := [given.capsule] * bool(given.capsule) + [out / "vtk"] * given.vtk:
            given.kept = kept[0], f"what there was until then is in {' and '.join(map(str, kept))}"
        with scenes.folder(out, *["numpy"] * given.no_report):
            given.answer = one(given, scene, name, out, remarks)
    if given.until and given.answer["ended_by"] == "TIMEOUT":
        parser.exit(TIMEOUT)
