"""Rings: the wrap beside flat cloth, pre-tension, turns, the angle of impact, and convergence in the spacing.

Method: a ring of one ply of the preset's cloth, 0.2 m in radius and 0.12 m long, hit from inside by a steel sphere of 20 mm at
three places within a mesh, and its ballistic limit, bisected to 3 %; the preset `ring_40in` itself at three angles to the plane
of rotation, and with other bars.
Limit: turns are bonded plies; one velocity, one fabric. What a case does to a fragment before it is torn is not modelled.
"""

import math

from fabric_kernel import Scene, Simulation, drawing

from . import page
from .hits import between
from .statistics import mean
from .study import FULL

N, ROWS, PLACES, LONGEST = 433, 41, ((0.2, 0.3), (-0.3, 0.1), (0.45, -0.2)), 2.5e-3
STRAINS, TURNS, ANGLES, BARS = (0.0, 0.002, 0.005, 0.01, 0.016, 0.022), (1, 2, 4), (0.0, 15.0, 30.0), (1.5, 1.0, 0.75)
SPEED = 110.0  # m/s, above the limit of all
BALL = {
    "projectile.shape": "sphere",
    "projectile.radius": 0.01,
    "projectile.mass": 0.0329,
    "projectile.angular_velocity": [0, 0, 0],
}
KINDS = {
    "ring on a case with a window": {},
    "ring on a whole case": {"casing.window_angle": [0, 0]},
    "ring without a case": {"casing.radius": 0.0},
}
FLAT = {"sheet.radius": 0.0, "sheet.closed": False, "casing.radius": 0.0, "attachment.kind": "two_sides"}


def closed(h, nodes):
    return h / (2 * math.sin(math.pi / nodes))


def ring(changes, speed=SPEED, place=PLACES[0]):
    """The small ring, hit at a place in meshes."""
    scene = Scene("ring_40in")
    h = scene["sheet.spacing"]
    small = {
        "sheet.nodes_x": N,
        "sheet.nodes_y": ROWS,
        "sheet.plies": 1,
        "sheet.radius": closed(h, N),
        "casing.radius": closed(h, N),
    }
    changes = small | BALL | changes
    scene = scene.replace(
        changes | {"projectile.position": [0, 0, changes["sheet.radius"] - 0.011], "projectile.velocity": [0, 0, speed]}
    )
    return scene.aimed((place[0] * h, place[1] * h))


def coarser(bars):
    """The preset with so many times its yarns in a bar."""
    scene = Scene("ring_40in")
    h, sheet = (
        bars * scene["sheet.spacing"],
        {f"sheet.{name}": bars**power * scene[f"sheet.{name}"] for name, power in (("node_mass", 2), ("yarn_area", 1))},
    )
    nodes, rows = (round(scene[f"sheet.nodes_{axis}"] / bars) for axis in "xy")
    radius = closed(h, nodes)
    return scene.replace(
        sheet
        | {"sheet.spacing": h, "sheet.nodes_x": nodes, "sheet.nodes_y": rows, "sheet.radius": radius, "casing.radius": radius}
    )


def oblique(angle):
    """The preset's fragment on a path that leads off the plane of rotation, to the same place."""
    scene, turn = Scene("ring_40in"), math.radians(angle)
    (x, _, z), speed = scene["projectile.position"], scene["projectile.velocity"][2]
    return scene.replace(
        {
            "projectile.position": [x, -2e-3 * math.tan(turn), z],
            "projectile.velocity": [0, speed * math.sin(turn), speed * math.cos(turn)],
        }
    )


def flown(scene):
    """Absorbed energy, J, its part of the impact's, end, open energy, failed segments and time, s."""
    simulation = Simulation(scene, warns=False)
    first = simulation.energy()["projectile_kinetic"]
    simulation.run(["arrested", "exited", "passed"], round(LONGEST / simulation.step_limits()["dt"]))
    ends, energy = simulation.outcomes(), simulation.energy()
    work, failed = simulation.contact()["work"], simulation.counters()["failed_segments"]
    return [
        work,
        work / first,
        "exited" if "exited" in ends else "arrested" if "arrested" in ends else "neither",
        energy["residual"] / first,
        failed,
        simulation.time,
    ]


def limit(changes):
    """The velocity, m/s, from which on the sphere leaves the ring."""
    return between(15.0, 250.0, lambda velocity: flown(ring(changes, velocity))[2] == "exited", 1.03)


def answer(study):
    full = study.effort == FULL
    places, strains = PLACES[: 3 if full else 1], STRAINS[:: 1 if full else 6]
    shapes = {**KINDS, "flat strip of the same cloth, its ends held": FLAT}
    wraps = list(shapes.items())[:: 1 if full else 3]
    jobs = [ring(changes, place=place) for _, changes in wraps for place in places]
    jobs += [ring({"sheet.pre_strain": [strain, 0.0]}, place=place) for strain in strains for place in places]
    jobs += [oblique(angle) for angle in (ANGLES if full else ())] + [coarser(bars) for bars in (BARS if full else ())]
    found = iter(study.each(flown, jobs))
    turns = TURNS if full else TURNS[:1]
    # First and last, as that of the first is that of one turn.
    *limits, flat = study.each(limit, [{"sheet.plies": plies} for plies in turns] + [FLAT])
    bisected = {wraps[0][0]: f"{limits[0]:.1f}", wraps[-1][0]: f"{flat:.1f}"}
    several = lambda: [next(found) for _ in places]
    spread = lambda rows: (
        f"{mean([row[0] for row in rows]):.1f} ({min(row[0] for row in rows):.1f} to {max(row[0] for row in rows):.1f})"
    )
    worst = lambda rows: f"{100 * max((row[3] for row in rows), key=abs):+.2f}"
    parts, rows = [], []
    lines = [[name, spread(own := several()), bisected.get(name, ""), worst(own)] for name, _ in wraps]
    parts.append(
        "One ply as a wrap and flat, as long as the ring is around, 33 g sphere; absorbed at 110 m/s (least to greatest of the "
        "places).\n"
    )
    parts.append(page.markdown(["sheet", "absorbed J", "ballistic limit m/s", "energy residual %"], lines, 1))
    taut = [(strain, several()) for strain in strains]
    parts.append("\nHoop pre-tension of the ring on its case.\n")
    share = lambda own: f"{100 * mean([r[0] for r in own]) / mean([r[0] for r in taut[0][1]]):.0f}"
    lines = [[f"{100 * strain:g}", spread(own), share(own), worst(own)] for strain, own in taut]
    parts.append(page.markdown(["pre-strain %", "absorbed J", "of that without %", "energy residual %"], lines, 0))
    found_limits = list(zip(turns, limits))
    parts.append("\nTurns, as bonded plies: the limit, and the energy of the sphere at it a turn.\n")
    parts.append(
        page.markdown(
            ["turns", "ballistic limit m/s", "energy at it a turn J", "over that of one"],
            [
                [plies, f"{v:.1f}", f"{0.5 * 0.0329 * v * v / plies:.1f}", f"{(v / limits[0]) ** 2 / plies:.2f}"]
                for plies, v in found_limits
            ],
            0,
        )
    )
    if full:
        single = lambda row: [
            f"{row[0]:.0f}",
            f"{100 * row[1]:.0f}",
            row[2],
            row[4],
            f"{1e6 * row[5]:.0f}",
            f"{100 * row[3]:+.2f}",
        ]
        heading = ["absorbed J", "of the impact's %", "end", "failed segments", "at us", "energy residual %"]
        parts.append("\nThe preset, its fragment's path so far off the plane of rotation; one run each.\n")
        parts.append(page.markdown(["angle deg", *heading], [[f"{angle:g}", *single(next(found))] for angle in ANGLES], 0))
        parts.append("\nThe preset with other bars; one run each.\n")
        bars = [(4 * k, next(found)) for k in BARS]
        parts.append(page.markdown(["yarns in a bar", *heading], [[f"{k:g}", *single(row)] for k, row in bars], 0))
    rows = [{"pre-strain": strain, "absorbed J": r[0], "open": r[3]} for strain, own in taut for r in own]
    study.write("rings", rows)
    ends = [(100 * strain, mean([r[0] for r in own]), min(r[0] for r in own), max(r[0] for r in own)) for strain, own in taut]
    series = [drawing.Series("", [(x, y) for x, y, *_ in ends], bars=[(low, high) for *_, low, high in ends])]
    drawing.draw(
        study.folder / "rings.svg",
        "Energy that a ring absorbs, hit at 110 m/s",
        "hoop pre-strain (%)",
        "absorbed energy (J)",
        series,
        "from zero",
    )
    study.picture("rings.svg", "rings.svg")
    study.table("rings", "Rings", "\n".join(parts))
