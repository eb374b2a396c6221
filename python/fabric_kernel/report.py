"""`fabric-report FOLDER`: the pictures and the page of a run, of which `fabric run` has written the numbers into the folder: velocity, force
and energies over time, and the sheet at the end."""

import argparse
import json
import math
import pathlib
import re

import pandas

from . import about as about_scenes
from . import movie, page, plot, sheets
from .runs import STOPPED

UNITS = dict.fromkeys(("dt", "time", "force_window"), "s") | {"peak_force": "N", "initial_momentum": "N s", "momentum_residual": "N s"}
UNITS |= dict.fromkeys(("ply_penetration", "worst_penetration", "max_deflection"), "m")
UNITS |= dict.fromkeys((
    "initial_kinetic_energy", "absorbed", "support_work", "fabric_kinetic", "strain", "dissipated", "viscous", "friction", "ply_loss", "casing_loss", "attachment", "contact_loss",
    "energy_residual",
), "J")  # fmt: skip


def report(folder):
    """Draws everything into the folder; OSError where a file is missing."""
    folder = pathlib.Path(folder)
    summary, about = json.loads((folder / "summary.json").read_text()), json.loads((folder / "sheet.json").read_text())
    name = about["name"]
    rows = pandas.read_csv(folder / "history.csv")
    # Named as by `fabric_kernel.history`, without the units.
    rows.columns = [re.sub(r"_(s|m|m_per_s|rad_per_s|n|j)$", "", column) for column in rows.columns]
    rows = rows.rename(columns={"contact_work": "work", "energy_residual": "residual"})
    marks = [(latched["time"], latched["outcome"]) for latched in summary["outcomes"]]
    summary["max_deflection"] = float(rows["max_deflection"].max())
    plot.history(rows, folder / "history.svg", title=name, marks=marks)
    plies = [sheets.Sheet(folder, about, ply) for ply in range(about["plies"])]
    sheet, failed = plies[0], sum(ply.failed() for ply in plies)
    at = f"{name}: {'first ply' if plies[1:] else 'sheet'} at {1e6 * sheet.time:.1f} µs, {sheet.failed()} failed segments"
    pictures = [("sheet.png", at)]
    sheets.picture(sheet, folder / "sheet.png", at)
    kept = json.loads((folder / "frames.json").read_text())
    frames = [about | {"file": file} for file in kept["frames"]]
    if kept["movie"]:
        movie.written([sheets.Sheet(folder, one) for one in frames], folder / "movie.gif")
        pictures.append(("movie.gif", "The same from the start."))
    if kept["vtk"]:
        sheets.vtk_series(folder, frames)
    if plies[1:]:
        all_of_them = f"{name}: {len(plies)} plies at {1e6 * sheet.time:.1f} µs, {failed} failed segments"
        sheets.picture_of_stack(plies, folder / "plies.png", all_of_them)
        pictures.append(("plies.png", all_of_them))
    sheets.damage_map(sheet, folder / "damage.png", f"{name}: damage on the undeformed grid (node numbers)")
    sheets.profile(plies[-1], folder / "profile.svg", f"{name}: back face at {1e6 * sheet.time:.1f} µs")
    html = page.Page(f"{name}: {summary['ended_by']} at {1e6 * summary['time']:.1f} µs")
    speed = math.hypot(*summary["residual_velocity"])
    html.answer([
        f"{summary['ended_by'].capitalize()}: {speed:.4g} m/s left, {summary['absorbed']:.4g} J of {summary['initial_kinetic_energy']:.4g} J absorbed; held cloth "
        f"deflected by at most {1e3 * summary['max_deflection']:.3g} mm.",
        *summary.get("warnings", []), f"One run of the model with its draws. {about_scenes.CAVEAT}",
    ])  # fmt: skip
    for file, caption in [
        *pictures, ("damage.png", "Damage on the undeformed grid, seen along the line of flight; held nodes in grey."),
        ("profile.svg", "Deflection of the back face at the end, along both yarns under the projectile."),
        ("history.svg", "Velocity of the projectile, mean force on it between samples, largest deflection, and where the absorbed energy is."),
    ]:
        html.figure(folder / file, caption)
    html.fold("All numbers")
    if not any(latched["outcome"] in STOPPED for latched in summary["outcomes"]):
        html.text("Energies and penetrations are those of the end of the run: where the projectile went through, they hold what torn cloth did after it, too.")
    unit = lambda key: f", {UNITS[key]}" if key in UNITS else ""
    html.table(["", ""], [[key.replace("_", " ") + unit(key), value] for key, value in summary.items() if not isinstance(value, (list, dict))], (1,))
    if plies[1:]:
        html.section("Plies")
        html.table(*ply_table(summary), (1, 2))
    html.write(folder / "report.html")


def ply_table(summary):
    """What each ply is and holds, from the front."""
    heading = ["ply, from the side that is hit", "fabric", "turned by 90°", "failed segments", "kinetic, J", "strain, J", "dissipated, J"]
    energies = lambda ply: [f"{ply[key]:.4f}" for key in ("kinetic", "strain", "dissipated")]
    return heading, [[k + 1, ply["fabric"], "yes" if ply["turned"] else "no", ply["failed_segments"], *energies(ply)] for k, ply in enumerate(summary["plies"])]


def main(arguments=None):
    """The command `fabric-report`."""
    parser = argparse.ArgumentParser(prog="fabric-report", description="The pictures and the page of a run of `fabric run`.")
    parser.add_argument("folder", type=pathlib.Path, help="what `fabric run` has written")
    given = parser.parse_args(arguments)
    try:
        report(given.folder)
    except OSError as error:
        parser.exit(1, f"error: {error}; `fabric run SCENE --out {given.folder}` writes it\n")


if __name__ == "__main__":
    main()
