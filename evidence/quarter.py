"""The quarter model against the whole sheet, point by point until the first segment fails. Beyond, the whole sheet leaves
symmetry by rounding.

Contact amplifies rounding too, long before the first failure: nodes that leave and meet the projectile at slightly other steps.
So a second whole sheet stands beside the quarter, whose impact velocity differs by 1e-12: what the two whole sheets differ by, no
comparison can do better.
"""

from fabric_kernel import Simulation, page

from .cases import CASES, ROUNDING, scene_of
from .study import SMOKE

# Steps at which the sheets are compared, as long as nothing has failed.
LOOKS = (400, 1000, 2000, 3000, 4000, 5500, 7000)
# Allowed difference of a position at the first look, when contact has not yet amplified rounding, in node spacings.
TOLERANCE = 1e-9


def compared(job):
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
        rows.append(
            {
                "case": name,
                "step": look,
                "time us": 1e6 * whole.time,
                "position: quarter, whole (h)": apart(quarter),
                "position: whole, V0 by 1e-12 (h)": apart(other),
                "velocity: quarter, whole (m/s)": slower(quarter),
                "velocity: whole, V0 by 1e-12 (m/s)": slower(other),
            }
        )
    return rows


def answer(study):
    jobs = []
    for case in [case for case in CASES if not case.stochastic][: study.of(3, 3, 1)]:
        ways = ((0.0, False), (0.0, True), (ROUNDING, False))
        jobs.append((case.name, *(scene_of(case, study.effort == SMOKE, *way) for way in ways)))
    rows = sum(study.each(compared, jobs), [])
    study.write("quarter", rows)
    columns = [("case", "case", None), ("step", "step", 0), ("time us", "time us", 1), *page.same(list(rows[0])[3:], "e1")]
    study.table("accuracy_quarter", "Quarter against whole sheet, before the first failure", page.table(rows, columns))
    return all(row["position: quarter, whole (h)"] < TOLERANCE for row in rows if row["step"] == LOOKS[0])
