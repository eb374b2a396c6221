"""What the first velocity of a test without a guess does to its V50: `python3 -m fabric_kernel.bracketing --keep FOLDER --docs docs`.

Shot: the presets and the textiles of fabrics/, from a tenth, once and ten times their limit, which a few shots find first; 20 shots, and
30 where the interval of V50 is not bounded by 20. The command takes some half an hour on one core, goes on where it was stopped, and writes
docs/tables/v50_bracket.md.
Simulated: how often the intervals of such tests hold the truth, as `coverage.py` does it for tests with a guess.
"""

import argparse
import json
import math
import pathlib

from . import Scene, designs, limit
from .coverage import DEVIATION, MU, Case, percent
from .files import written
from .page import markdown, write_table
from .v50 import Shooter, v50

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


def shot(name, scene, keep):
    """Three rows of the table."""
    shoot = Shooter(scene, keep=keep / f"{name}.jsonl")
    first = v50(shoot, designs.Neyer.bracketed(math.hypot(*scene["projectile.velocity"])), 8, tests=0)
    about = float(f"{first.fit.mu:.2g}")
    rows = []
    for start in STARTS:
        design = designs.Neyer.bracketed(start * about)
        for shots in SHOTS:
            test = v50(shoot, design, shots, tests=0)
            velocities, through = [one.velocity for one in test.shots], [not one.stopped for one in test.shots]
            found = limit.fit(velocities, through, design=design, shares=(0.5,), tests=TESTS)
            if all(math.isfinite(end) for end in found.intervals[0]) and not found.assumed[0]:
                break
        bracket = next(k for k in range(1, shots + 1) if len(set(through[:k])) == 2 or k == shots)
        rows.append([name, f"{start * about:g}", str(bracket), str(shots), f"{found.mu:.1f}", found.intervals[0].text(), f"{found.deviation:.1f}"])
        print(", ".join(rows[-1]), flush=True)
    return rows


def simulated(tests=1000):
    """Rows of the table of coverages."""
    rows = []
    for shots in SHOTS:
        for start in STARTS:
            case = Case(start, "probit", shots)
            for width in WIDTHS:
                held, plain = case.run(0, 1.0 / width, tests, 1)
                rows.append([f"{start:g}", str(shots), f"{100 * width * DEVIATION / MU:g}", *percent(held), *percent(plain)])
                print(", ".join(rows[-1]), flush=True)
    return rows


def kept(path, compute):
    """What is in the file, or what is computed and put there."""
    if not path.exists():
        written(path, json.dumps(compute()))
    return json.loads(path.read_text())


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m fabric_kernel.bracketing", description=__doc__.split("\n\n")[0])
    parser.add_argument("--keep", type=pathlib.Path, required=True, help="folder that keeps what has been computed; the same call goes on from there")
    parser.add_argument("--docs", type=pathlib.Path, help="folder of documents: writes tables/v50_bracket.md there, else prints")
    given = parser.parse_args(arguments)
    shots = [row for name, scene in scenes().items() for row in kept(given.keep / f"{name}.json", lambda: shot(name, scene, given.keep))]
    coverage = kept(given.keep / "simulated.json", simulated)
    heading = ["scene", "first velocity, m/s", "shots to the bracket", "shots", "V50, m/s", "95 % interval, m/s", "standard deviation, m/s"]
    plain = ["start over V50", "shots", "standard deviation, % of V50", "V01", "V50", "V99", "plain V01", "plain V50", "plain V99"]
    text = (
        "Each test begins with a tenth, once or ten times the limit, which 8 shots from the scene's own 100 m/s found before.\n"
        "It has 20 shots, or 30 if an end of the interval of V50 is not given by 20.\n"
        "The 3 in preset is as it is; the other sheets have 51 x 51 nodes, so that the limits are theirs and not those of larger ones.\n"
        f"The projectile of a textile is that of the 3 in preset; intervals are from {TESTS} simulated tests.\n"
        "Kevlar 49 has a weave that was chosen for this table: 1420 denier, 17 per inch.\n\n"
        f"{markdown(heading, shots)}\n"
        "## Coverage\n\nPercent of 1000 simulated tests whose 95 % interval holds the truth (probit); its standard error is 0.7 percentage points.\n"
        "\"Plain\": the profile likelihood with chi squared.\n\n"
        f"{markdown(plain, coverage)}"
    )
    if given.docs:
        command = "python3 -m fabric_kernel.bracketing --keep target/bracketing --docs docs"
        write_table(given.docs, "v50_bracket", "Tests without a guess", command, text)
    else:
        print(text)


if __name__ == "__main__":
    main()
