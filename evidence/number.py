"""What rounding does: how far runs stay together before the first failure, the quarter against the whole sheet, and how many runs
a mean needs: its statistical error against its cost, at the default step.

Uniform yarn: runs that differ by 1e-12 in the impact velocity (the chaos floor), and by 1e-6: what happens before the first
failure is then another thing to the same extent as with another step, and the first failures may come in another order.
Stochastic yarn: runs with different seeds, which is what a user of the scatter takes. The error of a mean of n is the deviation
over sqrt(n).

Point by point, three runs of each scene: as it is; with an impact velocity higher by 1e-12; mirrored in the plane x = 0, which is
the same problem with its sums in another order. The hit is off the centre, so that no symmetry hides a difference. All three are
correct: what they differ by, no comparison of two programs can do better. A segment has no stiffness below its rest length, so a
node between slack segments is held by nothing, and contact and the return of tension come at slightly other times: there
differences grow. How much of the sheet is slack stands beside them.

Quarter: the quarter model against the whole sheet until the first segment fails, as the whole sheet then leaves symmetry by
rounding, beside a second whole sheet whose impact velocity differs by 1e-12.
"""

import math

import numpy
from fabric_kernel import Scene, Simulation, drawing

from . import page
from .cases import CASES, ROUNDING, impact, scene_of
from .statistics import deviation, mean
from .study import SMOKE

# Differs by the impact velocity, by multiples of this part of it, or by the seed.
NUDGE, SEED = 1e-6, "seed"
FULL_CASES = (
    (0, 64, ROUNDING),
    (0, 32, NUDGE),
    (1, 64, SEED),
    (2, 32, ROUNDING),
    (2, 32, NUDGE),
    (3, 32, SEED),
    (4, 16, ROUNDING),
    (5, 16, SEED),
)
QUICK_CASES = ((0, 12, ROUNDING), (0, 12, NUDGE), (1, 12, SEED))
MEASURES = (("absorbed J", "absorbed", 3), ("velocity m/s", "velocity", 3), ("peak N", "force", 1), ("failed %", "failed", 2))
# Steps between two comparisons, steps that get a row (the last comparison gets one too), steps after which a scene is given up.
STRIDE, ROWS, LAST = 200, (400, 1000, 2000, 4000, 8000), 16000
# Allowed distance of a node at the first row or look, in node spacings: the wave has just come to the edges, and contact has not
# yet amplified rounding.
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
# Steps at which the quarter is compared, as long as nothing has failed.
LOOKS = (400, 1000, 2000, 3000, 4000, 5500, 7000)


def points(job):
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
    for step in range(STRIDE, LAST + 1, STRIDE):
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


def pointwise(study):
    energies, held = study.of((5.0, 10.0, 40.0), (40.0,), (40.0,)), HELD[: study.of(4, 4, 1)]
    rows = sum(study.each(points, [(*sheet, energy) for sheet in held for energy in energies]), [])
    study.write("pointwise", rows)
    columns = [("case", None), ("step", 0), ("time us", 1), ("slack segments %", 0), *page.same(DISTANCES, "e1")]
    study.table("accuracy_pointwise", "Point by point before the first failure", page.table(rows, columns))
    return all(row[name] < TOLERANCE for row in rows if row["step"] <= ROWS[0] for name in DISTANCES[:2])


def looks(job):
    """The rows of a case; job: its name, and the scenes of the whole sheet, the quarter and the second whole sheet."""
    name, scenes, rows = job[0], job[1:], []
    whole, quarter, other = runs = [Simulation(scene, warns=False) for scene in scenes]
    # Nodes that both model: the quarter's are the first ones.
    apart = lambda run: (
        float(abs(whole.positions()[: run.positions().shape[0], : run.positions().shape[1]] - run.positions()).max())
        / scenes[0]["sheet.spacing"]
    )
    slower = lambda run: abs(run.projectile()["velocity"][2] - whole.projectile()["velocity"][2])
    for look in LOOKS:
        for run in runs:
            run.step(look - run.step_count)
        if any(run.counters()["failed_segments"] for run in runs):
            break
        row = {"case": name, "step": look, "time us": 1e6 * whole.time, "position: quarter, whole (h)": apart(quarter)}
        row |= {"position: whole, V0 by 1e-12 (h)": apart(other), "velocity: quarter, whole (m/s)": slower(quarter)}
        rows.append(row | {"velocity: whole, V0 by 1e-12 (m/s)": slower(other)})
    return rows


def quarter(study):
    jobs = []
    for case in [case for case in CASES if not case.stochastic][: study.of(3, 3, 1)]:
        ways = ((0.0, False), (0.0, True), (ROUNDING, False))
        jobs.append((case.name, *(scene_of(case, study.effort == SMOKE, *way) for way in ways)))
    rows = sum(study.each(looks, jobs), [])
    study.write("quarter", rows)
    columns = [("case", None), ("step", 0), ("time us", 1), *page.same(list(rows[0])[3:], "e1")]
    study.table("accuracy_quarter", "Quarter against whole sheet, before the first failure", page.table(rows, columns))
    return all(row["position: quarter, whole (h)"] < TOLERANCE for row in rows if row["step"] == LOOKS[0])


def answer(study):
    rows, series = [], []
    for index, count, differs in study.of(FULL_CASES, QUICK_CASES, ((0, 4, ROUNDING),)):
        case, name = CASES[index], "seed" if differs == SEED else f"V0 by {differs:.0e}".replace("e-0", "e-")
        scenes = [scene_of(case, study.effort == SMOKE, 0.0 if differs == SEED else k * differs) for k in range(count)]
        if differs == SEED:
            scenes = [scene.replace(seed=scene["seed"] + k) for k, scene in enumerate(scenes)]
        found = study.each(impact, [(scene, case.end, k) for k, scene in enumerate(scenes)], f"{case.name}, {name}")
        good = [run for run in found if not run["trouble"]]
        row, cost = {"case": case.name, "what differs": name, "runs": len(good)}, mean([run["node_steps"] for run in good])
        for heading, measure, _ in MEASURES:
            values = [run["values"][measure] for run in good]
            row |= {heading: mean(values), f"{heading}: deviation %": 100 * deviation(values) / mean(values)}
        rows.append(row)
        sizes = [2**k for k in range(int(math.log2(max(len(good), 1))) + 1)]
        series.append(
            drawing.Series(f"{case.name}, {name}", [(n * cost, row["absorbed J: deviation %"] / math.sqrt(n)) for n in sizes])
        )
    study.write("number", rows)
    page.errors(
        study.folder / "runs_absorbed_steps.svg",
        "Statistical error of the mean absorbed energy, 40 J",
        "node-steps of all runs together",
        "standard error of the mean (%)",
        series,
    )
    study.picture("runs_absorbed_steps.svg", "accuracy_runs_absorbed_steps.svg")
    columns = [*page.same(["case", "what differs"], None), ("runs", 0)]
    for heading, _, digits in MEASURES:
        columns += [(heading, heading, digits), ("deviation %", f"{heading}: deviation %", 3)]
    study.table("accuracy_runs_summary", "Number of runs in a mean", page.table(rows, columns, 2))
    return min(pointwise(study), quarter(study))
