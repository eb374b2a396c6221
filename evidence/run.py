"""One run of a scene, of which `fabric run` has written the numbers: velocity, force and energies over time, and the sheet at the end; all is
written into its folder."""

import json

from . import page, plot
from . import sheets


def answer(study):
    folder = study.folder = study.source
    history = [{name: float(value) for name, value in row.items()} for row in page.rows_of(folder / "history.csv")]
    summary, about = json.loads((folder / "summary.json").read_text()), json.loads((folder / "sheet.json").read_text())
    marks = [(1e6 * latched["time"], latched["outcome"]) for latched in summary["outcomes"]]
    name = about["name"]

    def draw(file, title, y, columns):
        lines = [plot.Series(words, [(1e6 * row["time_s"], sign * row[key]) for row in history], "line") for words, key, sign in columns]
        plot.draw(folder / file, f"{name}: {title}", "time (µs)", y, lines, marks=marks)

    axes = lambda key, first, sign: [(first, key.format("z"), sign), ("along x", key.format("x"), 1), ("along y", key.format("y"), 1)]
    draw("velocity.svg", "velocity of the projectile", "velocity (m/s)", axes("velocity_{}_m_per_s", "along z", 1))
    draw("force.svg", "force on the projectile, mean between samples", "force (N)", axes("force_{}_n", "against z", -1))
    energies = [
        ("absorbed", "contact_work_j"), ("of it by held nodes", "support_work_j"), ("fabric kinetic", "fabric_kinetic_j"), ("strain", "strain_j"),
        ("dissipated by rupture", "dissipated_j"), ("taken by viscosity", "viscous_j"), ("friction", "friction_j"), ("lost where plies meet", "ply_loss_j"), ("contact loss", "contact_loss_j"), ("residual", "energy_residual_j"),
    ]
    draw("energies.svg", "where the absorbed energy is", "energy (J)", [(words, key, 1) for words, key in energies])
    plies = [sheets.Sheet(folder, about, ply) for ply in range(about["plies"])]
    sheet, failed = plies[0], sum(ply.failed() for ply in plies)
    at = f"{name}: {'first ply' if plies[1:] else 'sheet'} at {1e6 * sheet.time:.1f} µs, {sheet.failed()} failed segments"
    pictures = [("sheet.png", at)]
    sheets.picture(sheet, folder / "sheet.png", at)
    kept = json.loads((folder / "frames.json").read_text())
    frames = [about | {"file": file} for file in kept["frames"]]
    if kept["movie"]:
        sheets.movie(folder, frames, folder / "movie.gif")
        pictures.append(("movie.gif", "The same from the start."))
    if kept["vtk"]:
        sheets.vtk_series(folder, frames)
    if plies[1:]:
        all_of_them = f"{name}: {len(plies)} plies at {1e6 * sheet.time:.1f} µs, {failed} failed segments"
        sheets.picture_of_stack(plies, folder / "plies.png", all_of_them)
        pictures.append(("plies.png", all_of_them))
    sheets.damage_map(sheet, folder / "damage.png", f"{name}: damage on the undeformed grid (node numbers)")
    html = page.Page(f"{name}: {summary['ended_by']} at {1e6 * summary['time']:.1f} µs")
    for file, caption in [
        *pictures, ("damage.png", "Damage on the undeformed grid, seen along the line of flight; held nodes in grey."),
        ("velocity.svg", "Velocity of the projectile."), ("force.svg", "Force on the projectile, mean between samples."), ("energies.svg", "Where the absorbed energy is."),
    ]:
        html.figure(folder / file, caption)
    if summary.get("warnings"):
        html.section("Warnings")
        html.table([""], [[warning] for warning in summary["warnings"]])
    html.section("Numbers")
    html.table(["", ""], [[key.replace("_", " "), value] for key, value in summary.items() if not isinstance(value, (list, dict))], (1,))
    if plies[1:]:
        html.section("Plies")
        html.table(*ply_table(summary), (1, 2))
    html.write(folder / "report.html")


def ply_table(summary):
    """What each ply is and holds, from the front."""
    heading = ["ply, from the side that is hit", "fabric", "turned by 90°", "failed segments", "kinetic, J", "strain, J", "dissipated, J"]
    energies = lambda ply: [f"{ply[key]:.4f}" for key in ("kinetic", "strain", "dissipated")]
    return heading, [[k + 1, ply["fabric"], "yes" if ply["turned"] else "no", ply["failed_segments"], *energies(ply)] for k, ply in enumerate(summary["plies"])]
