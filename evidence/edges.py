"""From which velocity on bars break at once under a flat face with a sharp edge, beside a sphere of the same radius.

Method: the velocity is bisected, to 3 %, at which a segment fails within 6 us of the first contact. Sheets of 60 mm held on four
sides, a bar for each yarn, the flat-ended cylinder as long as wide and the sphere of equal mass, hit beside a node; plies are
bonded.
Limit: one hit each; the node spacing decides, too (docs/validation.md, "Spacing").
"""

from fabric_kernel import Scene, Simulation

from . import page
from .hits import between
from .study import FULL
from .viscosity import NONE, viscous

RADIUS, TIME, WIDTH, STRIDE = 2.8e-3, 6e-6, 0.06, 1.03
FABRICS, MASSES, PLIES = ("kevlar_km2_s706", "zylon_as_500_35"), (1.1e-3, 8.4e-3), (1, 20)


def scene_of(fabric, without, mass, plies, shape):
    body = {"shape": shape, "radius": RADIUS, "mass": mass} | ({"length": 2 * RADIUS} if shape == "cylinder" else {})
    scene = Scene("sheet_3in_sphere", fabric={"name": fabric}, projectile=body)
    nodes = round(WIDTH / scene["sheet.spacing"]) + 1
    return scene.replace(
        {"sheet.nodes_x": nodes, "sheet.nodes_y": nodes, "sheet.plies": plies} | (viscous(NONE) if without else {})
    )


def breaks(scene, velocity):
    """Whether a segment fails in time. The body touches the sheet at the start."""
    h = scene["sheet.spacing"]
    simulation = Simulation(scene.replace({"projectile.velocity": [0, 0, velocity]}).aimed((0.2 * h, 0.3 * h)), warns=False)
    simulation.run([], round(TIME / simulation.step_limits()["dt"]), failed=1)
    return simulation.counters()["failed_segments"] > 0


def threshold(scene):
    return between(100.0, 1200.0, lambda velocity: breaks(scene, velocity), STRIDE)


def answer(study):
    full = study.effort == FULL
    rows = [
        (fabric, without, mass, plies)
        for fabric in FABRICS[: 2 if full else 1]
        for without in (False, True)
        for mass in MASSES
        for plies in PLIES[: 2 if full else 1]
    ]
    found = study.each(threshold, [scene_of(*row, shape) for row in rows for shape in ("cylinder", "sphere")])
    names = ["fabric", "without viscosity", "mass kg", "plies", "flat m/s", "sphere m/s"]
    study.write("edges", [dict(zip(names, (*row, flat, ball))) for row, flat, ball in zip(rows, found[::2], found[1::2])])
    lines = [
        [fabric, "none" if without else "default", f"{1e3 * mass:g}", plies]
        + f"{flat:.0f} {round_:.0f} {100 * (round_ / flat - 1):+.0f}".split()
        for (fabric, without, mass, plies), flat, round_ in zip(rows, found[::2], found[1::2])
    ]
    heading = "fabric, viscosity, mass g, bonded plies, flat-ended cylinder m/s, sphere m/s, the sphere's above it by %".split(
        ", "
    )
    text = (
        f"Velocities from which on a bar breaks within {1e6 * TIME:g} µs of the contact, to {100 * (STRIDE - 1):.0f} %.\n\n"
        + page.markdown(heading, lines, 2)
    )
    study.table("edges", "Bars that break at once under a flat face and under a sphere", text)
