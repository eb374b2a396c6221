"""How far two runs of one problem stay together point by point, before the first failure.

Three runs of each scene: as it is; with an impact velocity higher by 1e-12; mirrored in the plane x = 0, which is the same
problem with its sums in another order. The hit is off the centre, so that no symmetry hides a difference. All three are correct:
what they differ by, no comparison of two programs can do better. A segment has no stiffness below its rest length, so a node
between slack segments is held by nothing, and contact and the return of tension come at slightly other times: there differences
grow. How much of the sheet is slack stands beside them.
"""

import math

import numpy
from fabric_kernel import Scene, Simulation, page

from .cases import ROUNDING

# Steps between two comparisons, steps that get a row (the last comparison gets one too), steps after which a scene is given up.
STRIDE, ROWS, LONGEST = 200, (400, 1000, 2000, 4000, 8000), 16000
# Allowed distance of a node at the first row, in node spacings: the wave has just come to the edges.
TOLERANCE = 1e-9
# Place of the hit, in node spacings from the centre.
HIT = (0.31, 0.17)
HELD = (("four sides", "four_sides"), ("two sides", "two_sides"), ("corners", "four_corners"), ("free", "free"))
DISTANCES = [
    "V0 by 1e-12: largest so far (h)",
    "mirrored: largest so far (h)",
    "root mean square now (h)",
    "velocity so far, of V0",
    "work so far, of KE0",
]


def compared(job):
    """The rows of one scene."""
    name, kind, energy = job
    scene = Scene("sheet_3in_sphere", {"attachment.kind": kind, "yarn.stochastic": False})
    h, position = scene["sheet.spacing"], scene["projectile.position"]
    x, y, speed = HIT[0] * h, HIT[1] * h, math.sqrt(2.0 * energy / scene["projectile.mass"])
    of = lambda x, speed: Simulation(
        scene.replace({"projectile.position": [x, y, position[2]], "projectile.velocity": [0, 0, speed]}), warns=False
    )
    runs = [of(x, speed), of(x, speed * (1 + ROUNDING)), of(-x, speed)]
    rows, most, last = [], numpy.zeros(4), None
    for step in range(STRIDE, LONGEST + 1, STRIDE):
        for run in runs:
            run.step(STRIDE)
        if any(run.counters()["failed_segments"] for run in runs):
            break
        own = runs[0].positions()
        images = [runs[1].positions(), runs[2].positions()[:, ::-1] * [-1, 1, 1]]
        apart = [numpy.linalg.norm(own - image, axis=2) / h for image in images]
        change = lambda read, scale: max(abs(read(run) - read(runs[0])) for run in runs[1:]) / scale
        now = [
            *(distance.max() for distance in apart),
            change(lambda run: run.projectile()["velocity"][2], speed),
            change(lambda run: run.contact()["work"], energy),
        ]
        most = numpy.maximum(most, now)
        squares = max(math.sqrt((distance**2).mean()) for distance in apart)
        slack = 100 * float((runs[0].stretch() < 1 - 1e-9).mean())
        row = {"case": f"{name}, {energy:g} J", "step": step, "time us": 1e6 * runs[0].time, "slack segments %": slack}
        row |= dict(zip(DISTANCES, map(float, [*most[:2], squares, *most[2:]])))
        rows, last = ([*rows, row], None) if step in ROWS else (rows, row)
    return rows + [last] * (last is not None)


def answer(study):
    energies, held = study.of((5.0, 10.0, 40.0), (40.0,), (40.0,)), HELD[: study.of(4, 4, 1)]
    rows = sum(study.each(compared, [(*sheet, energy) for sheet in held for energy in energies]), [])
    study.write("pointwise", rows)
    columns = [
        ("case", "case", None),
        ("step", "step", 0),
        ("time us", "time us", 1),
        ("slack segments %", "slack segments %", 0),
        *page.same(DISTANCES, "e1"),
    ]
    study.table("accuracy_pointwise", "Point by point before the first failure", page.table(rows, columns))
    return all(row[name] < TOLERANCE for row in rows if row["step"] <= ROWS[0] for name in DISTANCES[:2])
