"""What the first velocity of a test without a guess does to its V50.

Shot: the presets and the textiles of data/fabrics/, from a tenth, once and ten times their limit, which a few shots find first;
20 shots, and 30 where the interval of V50 is not bounded by 20.
Simulated: how often the intervals of such tests hold the truth, as `coverage.py` does it for tests with a guess.
"""

import math

from fabric_kernel import Scene, designs, limit
from fabric_kernel.page import markdown
from fabric_kernel.v50 import Shooter, v50

from .coverage import DEVIATION, MU, Case, percent
from .study import FULL

STARTS = (0.1, 1.0, 10.0)
SHOTS = (20, 30)
# Simulated tests behind an interval of the table.
TESTS = 400
# Standard deviations of the simulated fabrics, in that of the guess, 5 % of V50.
WIDTHS = (0.5, 1.0, 2.0)


def scenes():
    """By their names in the table. The sheets are small, and Kevlar 49 has a weave that is chosen here."""
    small = {"nodes_x": 51, "nodes_y": 51}
    found = {"sheet_3in_sphere": Scene()}
    weave = {"linear_density": {"value": 1420, "unit": "denier"}, "count": {"value": 17, "unit": "1/in"}}
    for textile in ("kevlar_49_yarn", "kevlar_km2_s706", "powell_zohdi_2009", "zylon_as_500_35"):
        found[textile] = Scene(fabric={"name": textile} | (weave if textile == "kevlar_49_yarn" else {}), sheet=small)
    return found | {"sheet_10in_cylinder": Scene("sheet_10in_cylinder", sheet=small)}


def shot(job):
    """Rows of the table, one for each start."""
    name, scene, starts, tests = job
    shoot = Shooter(scene)
    first = v50(shoot, designs.Neyer.bracketed(math.hypot(*scene["projectile.velocity"])), 8, tests=0)
    about = float(f"{first.fit.mu:.2g}")
    rows = []
    for start in starts:
        design = designs.Neyer.bracketed(start * about)
        for shots in SHOTS:
            test = v50(shoot, design, shots, tests=0)
            velocities, through = [one.velocity for one in test.shots], [not one.stopped for one in test.shots]
            found = limit.fit(velocities, through, design=design, shares=(0.5,), tests=tests)
            if all(math.isfinite(end) for end in found.intervals[0]) and not found.assumed[0]:
                break
        bracket = next(k for k in range(1, shots + 1) if len(set(through[:k])) == 2 or k == shots)
        found_by = f"{found.mu:.1f}; {found.intervals[0]}; {found.deviation:.1f}"
        rows.append(f"{name}; {start * about:g}; {bracket}; {shots}; {found_by}".split("; "))
    return rows


def simulated(job):
    """Rows of the table of coverages, one for each standard deviation."""
    shots, start, tests = job
    case, rows = Case(start, "probit", shots), []
    for width in WIDTHS:
        held, plain = case.run(0, 1.0 / width, tests, 1)
        rows.append([f"{start:g}", str(shots), f"{100 * width * DEVIATION / MU:g}", *percent(held), *percent(plain)])
    return rows


def answer(study):
    full = study.effort == FULL
    starts, tests, simulations = (STARTS, TESTS, 1000) if full else (STARTS[1:2], 20, 20)
    tried = list(scenes().items())[slice(None) if full else slice(1, 2)]
    shots = sum(study.each(shot, [(name, scene, starts, tests) for name, scene in tried]), [])
    coverage = sum(
        study.each(
            simulated, [(shots, start, simulations) for shots in SHOTS[: 2 if full else 1] for start in starts], "simulated"
        ),
        [],
    )
    heading = (
        "scene; first velocity, m/s; shots to the bracket; shots; V50, m/s; 95 % interval, m/s; standard deviation, m/s"
    ).split("; ")
    plain = "start over V50; shots; standard deviation, % of V50; V01; V50; V99; plain V01; plain V50; plain V99".split("; ")
    study.table(
        "v50_bracket",
        "Tests without a guess",
        (
            "Each test begins with a tenth, once or ten times the limit, which 8 shots from the scene's own 100 m/s found "
            "before.\n"
            "It has 20 shots, or 30 if an end of the interval of V50 is not given by 20.\n"
            "The 3 in preset is as it is; the other sheets have 51 x 51 nodes, so that the limits are theirs and not those of "
            "larger ones.\n"
            f"The projectile of a textile is that of the 3 in preset; intervals are from {tests} simulated tests.\n"
            "Kevlar 49 has a weave that was chosen for this table: 1420 denier, 17 per inch.\n\n"
            f"{markdown(heading, shots)}\n"
            f"## Coverage\n\nPercent of {simulations} simulated tests whose 95 % interval holds the truth (probit); its "
            f"standard error is {100 * math.sqrt(0.95 * 0.05 / simulations):.1f} percentage points.\n"
            '"Plain": the profile likelihood with chi squared.\n\n'
            f"{markdown(plain, coverage)}"
        ),
    )
