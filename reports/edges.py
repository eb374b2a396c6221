"""From which velocity on bars break at once under a flat face with a sharp edge, beside a sphere of the same radius.

Method: the velocity is bisected, to 3 %, at which a segment fails within 6 us of the first contact. Sheets of 60 mm held on four sides, a
bar for each yarn, the flat-ended cylinder as long as wide and the sphere of equal mass, hit beside a node; plies are bonded.
Limit: one hit each; the node spacing decides, too (docs/validation.md, "Spacing").
"""

import multiprocessing
import os

from evidence import page

RADIUS, TIME, WIDTH, STRIDE = 2.8e-3, 6e-6, 0.06, 1.03
FABRICS, MASSES, PLIES = ("kevlar_km2_s706", "zylon_as_500_35"), (1.1e-3, 8.4e-3), (1, 20)


def breaks(case, velocity):
    """Whether a segment fails in time."""
    import fabric_kernel as fk

    fabric, viscous, mass, plies, shape = case
    body = {"shape": shape, "radius": RADIUS, "length": 2 * RADIUS, "mass": mass, "velocity": [0, 0, velocity]}
    scene = fk.Scene("sheet_3in_sphere", fabric={"name": fabric}, projectile=body)
    h = scene["sheet.spacing"]
    nodes = round(WIDTH / h) + 1
    viscosity = {} if viscous else {f"yarn.viscosity_{kind}": 0.0 for kind in ("linear", "quadratic", "bending")}
    scene = scene.replace({"sheet.nodes_x": nodes, "sheet.nodes_y": nodes, "sheet.plies": plies} | viscosity)
    # It touches the sheet at the start.
    simulation = fk.Simulation(scene.aimed((0.2 * h, 0.3 * h)))
    simulation.step(round(TIME / simulation.step_limits["dt"]))
    return simulation.counters()["failed_segments"] > 0


def threshold(case):
    low, high = 100.0, 1200.0
    while high / low > STRIDE:
        middle = (low * high) ** 0.5
        low, high = (low, middle) if breaks(case, middle) else (middle, high)
    return (low * high) ** 0.5


def report(folder, docs=None):
    rows = [(fabric, viscous, mass, plies) for fabric in FABRICS for viscous in (True, False) for mass in MASSES for plies in PLIES]
    with multiprocessing.Pool(os.cpu_count()) as pool:
        found = pool.map(threshold, [(*row, shape) for row in rows for shape in ("cylinder", "sphere")], chunksize=1)
    lines = [
        [fabric, "default" if viscous else "none", f"{1e3 * mass:g}", plies, f"{flat:.0f}", f"{round_:.0f}", f"{100 * (round_ / flat - 1):+.0f}"]
        for (fabric, viscous, mass, plies), flat, round_ in zip(rows, found[::2], found[1::2])
    ]
    heading = ["fabric", "viscosity", "mass g", "bonded plies", "flat-ended cylinder m/s", "sphere m/s", "the sphere's above it by %"]
    text = f"Velocities from which on a bar breaks within {1e6 * TIME:g} µs of the contact, to {100 * (STRIDE - 1):.0f} %.\n\n" + page.markdown(heading, lines, 2)
    print(text)
    if docs:
        page.write_table(docs, "edges", "Bars that break at once under a flat face and under a sphere", "python3 -m reports edges --docs docs", text)
