"""Graded networks against the whole fabric: whole impacts until the body is arrested or has exited, at corners also detached.

On the 3 in sheet runs differ by the seed of drawn yarn, the same seeds for every network; on the 10 in preset by 1e-12 in the
impact velocity. The error of a network is that of its mean against the mean of the fabric. "Open" is what the runs leave open of
it, two standard errors: of the differences of equal seeds, or of both means. The chaos floor is the deviation of the fabric's own
runs.

Real fabrics, whose yarn is viscous, have half a yarn a bar: impacts above the limit, of the same hits with every network. Their
ballistic limits are compared by the likelihood of a shift (fabric_kernel/network.py), as bars half as long are.
"""

import math

from fabric_kernel import Scene, Shooter, Simulation, drawing
from fabric_kernel.designs import Neyer
from fabric_kernel.network import shift_of
from fabric_kernel.shots import Shot, shots_of
from fabric_kernel.textile import spacings

from . import page
from .cases import ROUNDING, node_steps
from .hits import shot
from .mesh import scene_of
from .statistics import deviation, mean
from .study import FULL, SMOKE, clock
from .viscosity import sphere

# Time after which a run is given up, s.
LONGEST = 4e-3
# Networks: the fabric; as the kernel chooses it for an error; (half-width of the fine part in spacings, most yarns of a bar, bars
# of each size).
FABRIC = "fabric"
SMALL = (FABRIC, 0.01, 0.03, (20.0, 2, 4), (20.0, 4, 4))
LARGE = (FABRIC, 0.01, 0.03, (40.0, 8, 4), (40.0, 2, 4))
# Real fabrics: plies, body, velocity above the limit, m/s. Yarns a bar, width of the sheet, m, and hits; others in short form.
HITS = ((12, "fragment simulator", 600.0), (28, "fragment simulator", 760.0), (1, "sphere", 150.0))
FINE, SHORT = (0.5, 0.16, 4), (2.0, 0.1, 2)
# Limits: width of the sheet, m, shots of the whole network, those of graded ones, and the guess over the velocity.
NARROW, WHOLE, GRADED, BELOW = 0.1, 20, 40, 0.75


def network_name(network):
    if network == FABRIC:
        return network
    return (
        f"automatic, {100 * network:g} %"
        if isinstance(network, float)
        else "fine to {:g} h, up to {}, {} of each".format(*network)
    )


def with_network(scene, network):
    if network == FABRIC:
        return scene
    if isinstance(network, float):
        return scene.graded(network)
    half, largest, run = network
    return scene.replace(
        {"sheet.grading": {"largest": largest, "run": run, "centre": [0, 0], "half_width": [half * h for h in spacings(scene)]}}
    )


def cases(effort):
    """(name, scene, runs, whether they differ by the seed, networks)."""
    on = lambda name, kind, energy, runs: (f"3 in, {name}, {energy} J", sphere(kind, energy, effort == SMOKE), runs, True, SMALL)
    if effort == SMOKE:
        return [on("four sides", "four_sides", 40, 2)]
    runs = 20 if effort == FULL else 4
    found = [on("four sides", "four_sides", energy, runs) for energy in (10, 40, 160)] + [on("two sides", "two_sides", 40, runs)]
    if effort == FULL:
        found += [on("two sides", "two_sides", energy, runs) for energy in (10, 160)] + [on("corners", "four_corners", 40, 10)]
        found.append(("10 in preset", Scene("sheet_10in_cylinder"), 20, False, LARGE))
    return found


def measured(scene):
    """Absorbed energy, J, velocity, m/s, force evaluations, seconds, nodes, and energy residual, % of the energy at impact; None
    if it did not end in time."""
    simulation = Simulation(scene, warns=False)
    rows, columns = simulation.positions().shape[:2]
    end = ["arrested", "exited"] + ["detached"] * (scene["attachment.kind"] == "four_corners")
    steps, first = int(LONGEST / simulation.step_limits()["dt"]), simulation.energy()["projectile_kinetic"]
    start = clock()
    if simulation.run(end, steps) == steps:
        return None
    seconds = clock() - start
    return [
        simulation.contact()["work"],
        simulation.projectile()["velocity"][2],
        node_steps(simulation),
        seconds,
        f"{columns} x {rows}",
        100 * simulation.energy()["residual"] / first,
    ]


def shots_at_limit(job):
    """Shots of a sensitivity test about the guess of the limit, m/s."""
    scene, guess, count = job
    return shots_of(Shooter(scene), Neyer(0.8 * guess, 1.2 * guess, 0.03 * guess), count, lambda line: None)[0]


def fabrics(study):
    """Table and picture of real fabrics."""
    bar, width, hits = FINE if study.effort == FULL else SHORT
    counts = (WHOLE, GRADED) if study.effort == FULL else (8, 8)
    cases, networks = HITS[2 if study.effort == SMOKE else 0 :], (FABRIC, 0.005, 0.01, 0.03)
    pairs = [(case, network) for case in cases for network in networks]
    jobs, searches = [], []
    for (plies, body, velocity), network in pairs:
        scene = scene_of(plies, body, True, bar, width)
        jobs += [with_network(shot(scene, velocity, hit), network) for hit in range(hits)]
        narrow = with_network(shot(scene_of(plies, body, True, bar, NARROW), velocity, 0), network)
        searches.append((narrow, BELOW * velocity, counts[network != FABRIC]))
    found = iter(study.each(measured, jobs, "fabrics"))
    tests = iter(study.each(shots_at_limit, searches, "limits"))
    rows, (figure, axis) = [], drawing.new(4.2, 3.0)
    count = lambda nodes: math.prod(int(side) for side in nodes.split(" x "))
    for (plies, body, velocity), network in pairs:
        own = list(zip(*(next(found) for _ in range(hits))))
        made = [Shot(*one) for one in next(tests)]
        if network == FABRIC:
            whole, of_whole = own, made
        row = {
            "case": f"{plies} {'plies' if plies > 1 else 'ply'}, {body}, {velocity:g} m/s",
            "network": network_name(network),
            "nodes": own[4][0],
        }
        row |= {"absorbed J": mean(own[0]), "residual %": mean(own[5])}
        row |= {"absorbed" + part: value for part, value in compared(own[0], whole[0], True).items()}
        moved = shift_of(of_whole, made, BELOW * velocity)
        row |= {"limit: error %": moved.percent, "limit: low %": moved.interval.low, "limit: high %": moved.interval.high}
        row |= {"nodes, times fewer": count(whole[4][0]) / count(own[4][0])}
        rows.append(row | {"CPU s": mean(own[3]), "times faster": mean(whole[3]) / mean(own[3])})
    study.write("grading_fabrics", rows)
    for name in dict.fromkeys(row["case"] for row in rows):
        graded = [row for row in rows if row["case"] == name][1:]
        errors, opens = ([row["absorbed: " + part] for row in graded] for part in ("error %", "open %"))
        axis.errorbar([row["times faster"] for row in graded], errors, opens, marker="o", label=name)
    axis.axhspan(-0.5, 0.5, color="0.92", zorder=0)
    axis.set(xlabel="times faster than the whole network", ylabel="error of absorbed energy, %")
    drawing.below(figure, axis)
    drawing.save(figure, study.folder / "grading.svg")
    study.picture("grading.svg", "grading.svg")
    columns = [*page.same(["case", "network", "nodes"], None), ("absorbed J", 2)]
    columns += [("error %", with_open("absorbed"), None), ("residual %", 3)]
    columns.append(("limit, error %", of_limit, None))
    columns += [*page.same(["nodes, times fewer", "times faster"], 1), ("CPU s", 2)]
    text = (
        page.table(rows, columns) + f"\n{hits} hits. Limits: {1e3 * NARROW:.0f} mm wide; {counts[0]} shots of the whole network, "
    )
    text += f"{counts[1]} of each other.\n"
    study.table("accuracy_grading_fabrics", "Graded networks of real fabrics, half a yarn a bar", text)


def of_limit(row):
    found = (row[f"limit: {part} %"] for part in ("error", "low", "high"))
    return "" if row["network"] == FABRIC else "{:+.1f} [{:+.1f}, {:+.1f}]".format(*found)


def with_open(name):
    return lambda row: f"{row[name + ': error %']:.2f} ± {row[name + ': open %']:.2f}"


def compared(own, reference, paired):
    """Deviation of the runs, error against the reference and what is open of it, in % of the reference's mean."""
    variance = lambda values: deviation(values) ** 2 / len(values)
    spread = variance([a - b for a, b in zip(own, reference)]) if paired else variance(own) + variance(reference)
    of = mean(reference)
    return {
        ": deviation %": 100 * deviation(own) / of,
        ": error %": 100 * (mean(own) / of - 1),
        ": open %": 100 * 2 * math.sqrt(spread) / of,
    }


def answer(study):
    jobs, places = [], []
    for case in cases(study.effort):
        name, scene, runs, seeds, networks = case
        for network in networks:
            graded, velocity = with_network(scene, network), scene["projectile.velocity"][2]
            faster = [[0, 0, velocity * (1 + k * ROUNDING)] for k in range(runs)]
            changes = [{"seed": scene["seed"] + k} if seeds else {"projectile.velocity": faster[k]} for k in range(runs)]
            jobs += [graded.replace(change) for change in changes]
            places.append((name, seeds, network, runs))
    found, rows = iter(study.each(measured, jobs)), []
    for name, seeds, network, runs in places:
        own = [next(found) for _ in range(runs)]
        if network == FABRIC:
            fabric = own
        # Runs that ended with every network.
        pairs = [pair for pair in zip(own, fabric) if None not in pair]
        columns, references = (list(zip(*side)) for side in zip(*pairs))
        row = {"case": name, "network": network_name(network), "nodes": columns[4][0], "runs": len(pairs)}
        for index, what, unit in ((0, "absorbed", "J"), (1, "velocity", "m/s")):
            row |= {f"{what} {unit}": mean(columns[index])}
            row |= {what + part: value for part, value in compared(columns[index], references[index], seeds).items()}
        for index, what, gain in ((2, "node-steps", "times fewer"), (3, "CPU s", "times faster")):
            row |= {what: mean(columns[index]), gain: mean(references[index]) / mean(columns[index])}
        rows.append(row)
    study.write("grading", rows)
    columns = [*page.same(["case", "network", "nodes"], None), ("runs", 0)]
    for what, unit in (("absorbed", "J"), ("velocity", "m/s")):
        columns += [
            (f"{what} {unit}", f"{what} {unit}", 2),
            ("deviation %", f"{what}: deviation %", 2),
            ("error %", with_open(what), None),
        ]
    columns += [("node-steps", "e2"), *page.same(["times fewer", "times faster"], 1)]
    study.table("accuracy_grading", "Graded networks against the whole fabric", page.table(rows, columns))
    fabrics(study)
