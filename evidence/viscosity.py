"""What viscosity does to whole impacts: energy absorbed and taken, failed segments, and the energy that slack sheets gain.

Impacts of drawn yarn run until the body is arrested or has exited; runs differ by the seed. The slack sheet, of uniform yarn, is
stepped for a fixed time; its runs differ by 1e-12 in the impact velocity.
"""

import math

from fabric_kernel import Scene, Simulation, page

from .cases import ROUNDING, segments
from .overshoot import VISCOSITIES, viscosity_name, viscous
from .statistics import deviation, mean
from .study import FULL, SMOKE

# How long the slack sheet is stepped, and after which time an impact is given up, s.
SLACK, LONGEST = 1.2e-3, 4e-3
MEASURES = ["absorbed J", "velocity m/s", "peak N", "failed %", "viscous loss, % of impact energy", "energy residual, % of it"]


def sphere(kind, energy, smoke):
    scene = Scene("sheet_3in_sphere", {"attachment.kind": kind}, sheet={"nodes_x": 41, "nodes_y": 41} if smoke else {})
    return scene.replace({"projectile.velocity": [0, 0, math.sqrt(2 * energy / scene["projectile.mass"])]})


def cases(effort):
    """(name, scene, time, s, if it is not to end with an outcome, runs)."""
    few = 8 if effort == FULL else 2
    found = [("3 in, four sides, 40 J", sphere("four_sides", 40.0, effort == SMOKE), None, few)]
    if effort == SMOKE:
        return found
    found.append(("3 in, two sides, 40 J", sphere("two_sides", 40.0, False), None, few))
    found.append(
        (
            "3 in, four sides, 10 J, slack for 1.2 ms",
            sphere("four_sides", 10.0, False).replace({"yarn.stochastic": False}),
            SLACK,
            2,
        )
    )
    if effort == FULL:
        large = Scene("sheet_10in_cylinder")
        found += [
            (f"10 in, two sides, {speed} m/s", large.replace({"projectile.velocity": [0, 0, speed]}), None, 4)
            for speed in (100, 200)
        ]
    return found


def measured(job):
    """The measures of a run."""
    scene, time, k = job
    if scene["yarn.stochastic"]:
        scene = scene.replace(seed=scene["seed"] + k)
    else:
        scene = scene.replace({"projectile.velocity": [0, 0, scene["projectile.velocity"][2] * (1 + k * ROUNDING)]})
    simulation = Simulation(scene, warns=False)
    first = simulation.energy()["projectile_kinetic"]
    simulation.run([] if time else ["arrested", "exited"], int((time or LONGEST) / simulation.step_limits()["dt"]))
    contact, energy, failed = simulation.contact(), simulation.energy(), simulation.counters()["failed_segments"]
    found = [contact["work"], simulation.projectile()["velocity"][2], contact["force_peak"], 100 * failed / segments(scene)]
    return found + [100 * energy["viscous"] / first, 100 * energy["residual"] / first]


def answer(study):
    wanted = [
        (name, viscosity, scene.replace(viscous(viscosity)), time, runs)
        for name, scene, time, runs in cases(study.effort)
        for viscosity in VISCOSITIES
    ]
    found = iter(study.each(measured, [(scene, time, k) for _, _, scene, time, runs in wanted for k in range(runs)]))
    rows = []
    for name, viscosity, _, _, runs in wanted:
        columns = list(zip(*(next(found) for _ in range(runs))))
        row = {"case": name, "viscosity": viscosity_name(viscosity), "runs": runs} | dict(zip(MEASURES, map(mean, columns)))
        rows.append(row | {"absorbed J: deviation %": 100 * deviation(columns[0]) / row["absorbed J"]})
    study.write("viscosity", rows)
    columns = [
        ("case", "case", None),
        ("viscosity", "viscosity", None),
        ("runs", "runs", 0),
        ("absorbed J", "absorbed J", 2),
        ("deviation %", "absorbed J: deviation %", 1),
    ]
    study.table(
        "accuracy_viscosity",
        "Viscosity in whole impacts",
        page.table(rows, columns + page.same(["velocity m/s"], 1) + page.same(["peak N"], 0) + page.same(MEASURES[3:], 2)),
    )
