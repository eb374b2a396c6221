"""How often `fabric accuracy` keeps the error that it was asked for: random scenes, whose recommended settings are shot anew.

Method: sheets of three fabrics, 15 to 25 mm wide, one to 20 bonded plies, at most a tenth of the width thick; spheres,
cylinders, cubes and fragment simulators of steel. Each is asked for 1, 2 and 5 % of the largest deflection below the limit, in
hits that stop and fail nothing (a stopped body absorbs its own energy, whatever the settings), and for 5 % of the absorbed energy
above it, in hits that go through. The mean of the recommended number of shots, with other samples, is compared with that on a
network twice as fine and at half the step, and where that is no finer than half a bar, on one four times as fine.
Limits: the network is not finer than bars of half the scene's; the error of the reference is at most about a quarter of what is
asked for, and counts against the recommendation.
"""

import math
import pathlib
import tempfile

import numpy
import scipy.stats
from fabric_kernel import Scene, ensembles
from fabric_kernel.accuracy import Setting, accuracy
from fabric_kernel.runs import DECIDED, STEPS, UNTIL, flown
from fabric_kernel.sensitivity import crossing

from .page import markdown
from .study import clock

FABRICS = ("kevlar_km2_s706", "zylon_as_500_35", "powell_zohdi_2009")
BARS, WIDTHS, SIZES = (4.0, 2.0, 1.0, 0.5), (15.0, 25.0), (4.0, 8.0)
"""Networks; width of the sheet and size of a body, mm."""
ASKED = (("deflection", 1.0), ("deflection", 2.0), ("deflection", 5.0), ("absorbed", 5.0))
OTHER = 10**6
"""Added to the seed of a scene for the samples of what is judged and, twice, of what it is judged by."""
SCENES = 200
NAMES = {"deflection": "deflection below the limit", "absorbed": "absorbed energy above it"}
SHOTS = (4, 24)
"""Fewest and most shots of a reference."""


def body(random):
    """A steel body at random: table [projectile] of a scene file."""
    kind, size = random.choice(["sphere", "cylinder", "box", "fsp"]), random.uniform(*SIZES)
    text = {
        "sphere": f'diameter = "{size:.3f} mm"\nmaterial = "steel"',
        "cylinder": f'diameter = "{size:.3f} mm"\nlength = "{size * random.uniform(0.5, 2.0):.3f} mm"\nmaterial = "steel"',
        "box": f'size = ["{size:.3f} mm", "{size:.3f} mm", "{size:.3f} mm"]\nmaterial = "steel"',
        "fsp": 'calibre = ".22"',
    }
    return kind, f'shape = "{kind}"\n{text[kind]}'


def drawn(number):
    """Words for a random scene, and the scene."""
    random = numpy.random.default_rng(number)
    fabric = random.choice(FABRICS)
    while True:
        plies, width = int(random.integers(1, 21)), random.uniform(*WIDTHS)
        kind, projectile = body(random)
        text = f'fabric = "{fabric}"\nslack_balance = true\n[sheet]\nwidth = "{width:.2f} mm"\nplies = {plies}\n'
        scene = Scene.parse(f'{text}[projectile]\n{projectile}\n[aim]\nspeed = "{40.0 * math.sqrt(plies):.1f} m/s"\n')
        # Cloth is thin: at most a tenth of its width.
        if plies * scene["sheet.thickness"] < 0.1 * 1e-3 * width - scene["sheet.spacing"] / 10.0:
            return f"{plies} x {fabric}, {width:.0f} mm, {kind}", scene, random


def at(scene, speed):
    return scene.replace({"projectile.velocity": [0.0, 0.0, speed]})


def speeds(scene, random):
    """A velocity below the limit at which nothing fails, and one above it, m/s."""
    coarse = Setting(2.0).scene(scene)
    limit = crossing(scene["projectile.velocity"][2], lambda one: flown(at(coarse, one), DECIDED, STEPS)["stopped"] is not True)
    below, above = limit * random.uniform(0.3, 0.7), limit * random.uniform(1.2, 2.0)
    for _ in range(6):
        row = flown(at(scene, below), UNTIL, STEPS)
        if row["stopped"] and not row["failed_segments"]:
            break
        below *= 0.7
    for _ in range(6):
        if flown(at(scene, above), UNTIL, STEPS)["stopped"] is False:
            break
        above *= 1.3
    return below, above


def shot(scene, base, quantity, count, seed):
    """What so many shots give that differ as those of `fabric accuracy`, and how many have failed segments."""
    rows = [
        flown(one, UNTIL, 8 * STEPS)
        for one in ensembles.vary(scene, count, seed=seed, point=ensembles.within_mesh(base, (0.0, 0.0)))
    ]
    name = "max_deflection" if quantity == "deflection" else quantity
    return [row[name] for row in rows if row["stopped"] is not None], sum(row["failed_segments"] > 0 for row in rows)


def reference(base, setting, finer, step, quantity, scatter, asked, seed):
    """Mean and its standard error, both in the unit of the quantity, and shots with failed segments: bars so much finer, at half
    the step."""
    fine = Setting(setting.bars / finer, 0.5 * step, setting.balanced).scene(base)
    count = math.ceil(min(max((4.0 * scatter / asked) ** 2, SHOTS[0]), SHOTS[1]))
    values, failed = shot(fine, base, quantity, count, seed)
    return float(numpy.mean(values)), float(numpy.std(values, ddof=1) / math.sqrt(len(values))), failed


def judged(number):
    """What came of each request for a random scene."""
    words, scene, random = drawn(number)
    try:
        below, above = speeds(scene, random)
    except ValueError as refused:
        return [{"scene": words, "why": str(refused)}]
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for quantity, asked in ASKED:
            base = at(scene, above if quantity == "absorbed" else below)
            row = {"scene": words, "quantity": quantity, "asked": asked, "speed": base["projectile.velocity"][2], "why": ""}
            start = clock()
            try:
                keep = pathlib.Path(folder) / "runs.jsonl"
                given = accuracy(base, asked, quantity=quantity, bars=BARS, budget=1e6, keep=keep, on=1, progress=False)
            except ValueError as refused:
                found.append(row | {"why": str(refused)})
                continue
            choice = given.choices[0]
            row |= {"why": choice.why, "seconds": clock() - start, "shots": max(one.shots for one in given.rows)}
            if (best := choice.row) is not None:
                scatter = 100.0 * max(one.deviation / abs(one.mean) for one in given.rows)
                own, failed = shot(best.setting.scene(base), base, quantity, choice.runs, OTHER + number)
                row |= {"bars": best.setting.bars, "step": best.step, "runs": choice.runs, "own": float(numpy.mean(own))}
                for finer in (2.0, 4.0):
                    if best.setting.bars / finer >= BARS[-1]:
                        told = (base, best.setting, finer, best.step, quantity, scatter, asked, 2 * OTHER + number)
                        true, error, more = reference(*told)
                        off = {"error": 100.0 * (row["own"] / true - 1.0), "deviation": 100.0 * error / true}
                        row |= {f"{name}_{finer:g}": value for name, value in off.items()}
                        failed += more
                row["failed"] = failed
            found.append(row)
    return found


def cell(rows, finer):
    """Of requests: how many kept the error, their share with its interval, and the largest error, percent."""
    off = [(row["asked"], abs(row[f"error_{finer}"])) for row in rows if f"error_{finer}" in row]
    if not off:
        return ["0 of 0", "", ""]
    inside = sum(error <= asked for asked, error in off)
    ends = scipy.stats.binomtest(inside, len(off)).proportion_ci()
    share = f"{100 * inside / len(off):.1f} [{100 * ends.low:.1f}, {100 * ends.high:.1f}]"
    return [f"{inside} of {len(off)}", share, f"{max(error for _, error in off):.1f}"]


def answer(study, scenes=None):
    scenes = scenes or study.of(SCENES, 12, 1)
    found = study.each(judged, list(range(scenes)), "kept")
    rows = [row for one in found for row in one if "quantity" in row]
    keys = list(dict.fromkeys(key for row in rows for key in row))
    study.write("kept", [{key: row.get(key, math.nan) for key in keys} for row in rows])
    heading = ["asked for", "scenes", "recommended"]
    heading += [
        f"{what}, {times} times as fine" for times in ("two", "four") for what in ("kept", "share, %", "largest error, %")
    ]
    lines = []
    for quantity, asked in (*ASKED, ("all", 0.0)):
        own = [row for row in rows if quantity == "all" or (row["quantity"], row["asked"]) == (quantity, asked)]
        name = quantity if quantity == "all" else f"{asked:g} % of {NAMES[quantity]}"
        lines.append([name, len(own), sum("error_2" in row for row in own), *cell(own, 2), *cell(own, 4)])
    missed = [row for row in rows for finer in (2, 4) if abs(row.get(f"error_{finer}", 0.0)) > row["asked"]]
    words = [
        f"- {row['scene']}, {row['speed']:.0f} m/s, {row['asked']:g} % of {NAMES[row['quantity']]}: bars of {row['bars']:g}, "
        + ", ".join(f"{row[f'error_{finer}']:+.1f} %" for finer in (2, 4) if f"error_{finer}" in row)
        for row in {id(row): row for row in missed}.values()
    ]
    refused = sum("quantity" not in row for one in found for row in one)
    torn = sum(row.get("failed", 0) > 0 for row in rows if row["quantity"] == "deflection")
    text = (
        f"The first {scenes} of {SCENES} random scenes, {refused} of them refused; {torn} recommendations below the limit had "
        "shots that failed segments.\n*kept*: the mean of the recommended shots, of other samples, differs from that of a "
        "network so much finer, at half the step, by no more than was asked for. The error of the reference is at most about "
        "a quarter of that.\n\n"
    )
    text += f"{markdown(heading, lines)}\n"
    text += "## Missed\n\n" + ("\n".join(words) or "None.") + "\n"
    study.table("accuracy_kept", "How often an error that was asked for is kept", text)
