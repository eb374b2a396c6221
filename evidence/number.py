"""How many runs a mean needs: its statistical error against its cost, at the default step.

Uniform yarn: runs that differ by 1e-12 in the impact velocity (the chaos floor), and by 1e-6: what happens before the first
failure is then another thing to the same extent as with another step, and the first failures may come in another order.
Stochastic yarn: runs with different seeds, which is what a user of the scatter takes. The error of a mean of n is the deviation
over sqrt(n).
"""

import math

from fabric_kernel import drawing, page

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
    drawing.errors(
        study.folder / "runs_absorbed_steps.svg",
        "Statistical error of the mean absorbed energy, 40 J",
        "node-steps of all runs together",
        "standard error of the mean (%)",
        series,
    )
    study.picture("runs_absorbed_steps.svg", "accuracy_runs_absorbed_steps.svg")
    columns = [*page.same(["case", "what differs"], None), ("runs", "runs", 0)]
    for heading, _, digits in MEASURES:
        columns += [(heading, heading, digits), ("deviation %", f"{heading}: deviation %", 3)]
    study.table("accuracy_runs_summary", "Number of runs in a mean", page.table(rows, columns, 2))
