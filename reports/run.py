"""One run of a scene: velocity, force and energies over time, and the sheet at the end."""

import json

from . import page, plot, sheets


def report(folder, docs=None):
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
        ("absorbed", "contact_work_j"), ("fabric kinetic", "fabric_kinetic_j"), ("strain", "strain_j"),
        ("dissipated by rupture", "dissipated_j"), ("taken by viscosity", "viscous_j"), ("friction", "friction_j"), ("lost where plies meet", "ply_loss_j"), ("contact loss", "contact_loss_j"), ("residual", "energy_residual_j"),
    ]
    draw("energies.svg", "where the absorbed energy is", "energy (J)", [(words, key, 1) for words, key in energies])
    plies = [sheets.Sheet(folder, about, ply) for ply in range(about["plies"])]
    sheet, failed = plies[0], sum(ply.failed() for ply in plies)
    sheets.picture(sheet, folder / "sheet.png", f"{name}: {'first ply' if plies[1:] else 'sheet'} at {1e6 * sheet.time:.1f} µs, {sheet.failed()} failed segments")
    if plies[1:]:
        sheets.picture_of_stack(plies, folder / "plies.png", f"{name}: {len(plies)} plies at {1e6 * sheet.time:.1f} µs, {failed} failed segments")
    print(f"written: {folder}: velocity.svg, force.svg, energies.svg, sheet.png{', plies.png' if plies[1:] else ''}")
