"""The pyramid behind the transverse wave of a sheet that is hit at a point, against theory.

Two theories. Jump condition: the front of the pyramid is a kink of each yarn, whatever the waves before it have done. With the
strain just before it, U - 1, the tension N there and the mass per length mu = m/h of a yarn with what it carries of the crossing
yarns, the kink runs at U sqrt(N/(mu U)) relative to the yarn, which itself moves inwards. In a plain weave of equal yarns mu is
twice that of a yarn. Strip: Smith's relation with mu doubled, which is exact for a sheet that is hit along a line, and is used
for points too (D. Roylance, A. Wilde, G. Tocci, Textile Research Journal 43 (1973) 34). At a point the hit yarns also drag the
crossing ones, so the strain is not uniform: how far the strip is off is a result, not an error.

Method: Kevlar KM2 S706, 801 x 801 yarns of which a quarter is modelled, hit at its centre by a sphere so heavy that its velocity
stays, until the longitudinal front is near the edge. The front is where the deflection is 1 % of the deepest; its speed is the
slope over the second half of the time.
Strain and inward velocity are means over ten segments that begin four before it.
Limit: the kink is some spacings wide, and the strain before it is still falling outwards.
"""

import math

import numpy
from fabric_kernel import Simulation

from . import page
from .comparison import Comparison, Point, about, exact
from .hits import sheet
from .study import FULL
from .viscosity import VISCOUS, smith, viscous
from .yarn import slope

# Impact velocities, m/s; radius of the sphere, m, and its mass, kg; where the front is, in parts of the deepest deflection.
SPEEDS, SPHERE, FRONT = (50.0, 75.0, 100.0, 150.0), (3.175e-3, 1.0), 0.01
# Segments from the front to where strain and inward velocity are taken, and their number; samples.
BEFORE, COUNT, SAMPLES = 4, 10, 16


def scene_of(half, speed):
    scene = sheet({"name": "kevlar_km2_s706"}, 1.0, 1.0)
    body = {"radius": SPHERE[0], "mass": SPHERE[1], "position": [0, 0, -SPHERE[0]], "velocity": [0, 0, speed]}
    more = {
        "sheet.nodes_x": 2 * half + 1,
        "sheet.nodes_y": 2 * half + 1,
        "symmetry": {"mirror_x": True, "mirror_y": True},
        "projectile": body,
    }
    return scene.replace(more | viscous(VISCOUS))


def place(points):
    """The first node, counted from the centre outwards, whose deflection is below the front's, and the distance where it falls
    below, m."""
    r, z = numpy.hypot(points[:, 0], points[:, 1]), points[:, 2]
    level = FRONT * z[0]
    k = int(numpy.argmax(z < level))
    return k, float(r[k - 1] + (r[k] - r[k - 1]) * (z[k - 1] - level) / (z[k - 1] - z[k]))


def pyramid(job):
    """Strain before the front along the yarns, its speed along the yarns and along the diagonal, what the jump condition gives
    for the first, m/s, and the failed segments."""
    half, speed = job
    scene = scene_of(half, speed)
    simulation, h = Simulation(scene, warns=False), scene["sheet.spacing"]
    steps = int(0.9 * half * h / smith(scene, speed)[1].front / simulation.step_limits()["dt"])
    strains, jumps, places, times = [], [], ([], []), []
    for sample in range(1, SAMPLES + 1):
        simulation.step(steps // 2 + steps * sample // (2 * SAMPLES) - simulation.step_count)
        # Nodes from the centre, which is the last one.
        nodes, velocities = simulation.positions()[::-1, ::-1], simulation.velocities()[::-1, ::-1]
        k, along = place(nodes[0])
        places[0].append(along)
        places[1].append(place(numpy.diagonal(nodes).T)[1])
        times.append(simulation.time)
        a, b = nodes[0, k + BEFORE], nodes[0, k + BEFORE + COUNT]
        stretch = math.hypot(a[0] - b[0], a[2] - b[2]) / (COUNT * h)
        inward = velocities[0, k + BEFORE : k + BEFORE + COUNT + 1, 0].mean()
        pull = scene["sheet.yarn_area"] * scene["yarn.modulus_mean"] * 0.5 * stretch * (stretch * stretch - 1.0)
        strains.append(stretch - 1.0)
        jumps.append(stretch * math.sqrt(pull / (scene["sheet.node_mass"] / h * stretch)) - inward)
    front = [slope(times, along) for along in places]
    return {
        "strain": float(numpy.mean(strains)),
        "front": front,
        "jump": float(numpy.mean(jumps)),
        "failed": simulation.counters()["failed_segments"],
    }


def compared(study):
    full, rows = study.effort == FULL, []
    half, speeds = (400, SPEEDS) if full else (150, SPEEDS[1:3])
    for speed, found in zip(speeds, study.each(pyramid, [(half, speed) for speed in speeds], "cone")):
        stretch, strip = smith(scene_of(half, speed), speed)
        row = {"impact m/s": speed, "failed segments": found["failed"], "strain before the front %": 100 * found["strain"]}
        row |= {"front m/s": found["front"][0], "jump condition m/s": found["jump"], "diagonal front m/s": found["front"][1]}
        rows.append(row | {"strip strain %": 100 * (stretch - 1.0), "strip m/s": strip.kink})
    study.write("cone", rows)
    jump = [
        Point(f"{row['impact m/s']:.0f} m/s", exact(row["front m/s"] / row["jump condition m/s"]), about(1, 0.05)) for row in rows
    ]
    strip = [Point(f"{row['impact m/s']:.0f} m/s", exact(row["front m/s"] / row["strip m/s"]), about(1, 0.05)) for row in rows]
    comparisons = [
        Comparison("front of the pyramid of a sheet, along the yarns, over the jump condition", "theory", "± 5 %", jump, 3),
        Comparison(
            "the same over Smith's relation with doubled mass",
            "theory of a line, not of a point",
            "± 5 %",
            strip,
            3,
            "nothing: the theory leaves out that hit yarns drag the crossing ones",
        ),
    ]
    columns = [
        ("impact m/s", 0),
        ("failed segments", 0),
        ("strain before the front %", 3),
        ("with doubled mass %", "strip strain %", 3),
    ]
    columns += [("front m/s", 0), ("jump condition m/s", 0), ("doubled mass m/s", "strip m/s", 0)]
    columns += [("along the diagonal, of that along the yarns", lambda row: row["diagonal front m/s"] / row["front m/s"], 2)]
    return comparisons, "## The pyramid of a sheet hit at a point\n\n" + page.table(rows, columns), True
