"""One ply: ballistic limits of the network beside those of a reference with resolved yarns, and when a projectile opens a window.

Reference: evidence/resolved, yarns as curves in space that touch, slip and rub (its cloth.rs has method and limits); its closed
forms are `cargo test --release -p fabric-resolved -- --nocapture`. Network: the package, with a bar between two crossings, flat
and with sheet.crimp.
Both have the same yarns, supports, body, viscosity and place of hit. Each limit is bisected to 3 m/s: the middle of the fastest
shot that was stopped and the slowest that went through. A limit is by windowing if no yarn broke in that slowest shot.
Limits: no scatter of strength; one place of hit is one sample beyond the first failure. Thickness and width of yarns are
assumptions (THICKNESS, WIDTH).
"""

import json
import math
import os
import subprocess

from fabric_kernel import Simulation, drawing
from fabric_kernel.search import bisected

from . import page
from .hits import bracket, impact, sheet
from .study import FULL, TOP

# Raised when the reference computes something else: kept runs are then made anew.
MODEL = 1
PROGRAM = TOP / "target/resolved/release/resolved"
# Half the thickness of the ply and the width of a yarn of Kevlar KM2 S706, m: not read in any source, so assumptions. Those of
# another textile have the same ratio to the root of the area of its yarn, unless its file gives them.
THICKNESS, WIDTH, AREA = 0.115e-3, 0.55e-3, 4.63e-8
# Width of the bracket, m/s, and the stride towards it.
BRACKET, STRIDE = 3.0, 1.15
# Place of a hit, from a crossing, in spacings; a little off, as an exactly symmetric hit is a case of its own.
PLACES = {"crossing": (0.03, 0.02), "yarn": (0.53, 0.02), "window": (0.53, 0.52)}
SPHERE = {"radius": 2.778e-3, "mass": 6.9e-4, "length": 0.0}
CYLINDER = {"radius": 2.73e-3, "mass": 1.1e-3, "length": 6e-3}
KEVLAR, ZYLON = "kevlar_km2_s706", "zylon_as_500_35"
STRAIGHT, CRIMPED = {"pinned": 1, "crimped": 0}, {"pinned": 1, "crimped": 1}
# Time step over the stable one.
STEP = 0.75
# Time after which a shot is given up, s.
LONGEST = 1.5e-3


def rubbing(yarns, body):
    return {"friction": yarns, "body_friction": body}


def variants():
    return {"pinned, straight": STRAIGHT, "pinned, crimped": CRIMPED} | {
        f"mu = mu_s = {mu}": rubbing(mu, mu) for mu in (0.1, 0.2, 0.3)
    }


def crimp(thickness, spacing):
    """Crimp of the reference's yarns, as cloth.rs has it."""
    slope = math.pi * 0.5 * thickness / spacing
    return slope**2 / 4 - 3 * slope**4 / 64


def section(scene):
    """Thickness and width of the yarns of a flat scene, m: of its fabric, or assumed."""
    root, known = math.sqrt(scene["sheet.yarn_area"] / AREA), scene.weave()
    return 0.5 * known.get("thickness", 2.0 * THICKNESS * root), known.get("width", WIDTH * root)


def free_crimp(thickness, spacing):
    """The part of it that both directions can give up at once: yarns stay a thickness apart at crossings, and go straight from
    one to the next."""
    return (1 + crimp(thickness, spacing)) / math.hypot(1.0, thickness / spacing) - 1


CRIMPS = {"flat": None, "crimp": crimp, "free crimp": free_crimp}


def network(fabric, width, body, place, kind, friction=0.0):
    """The scene of the network, at rest on the sheet; a velocity is given to each shot."""
    # A surface: mesh.py has what the thickness of one ply changes.
    scene = sheet({"name": fabric}, width, 1.0)
    spacing = scene["sheet.spacing"]
    if CRIMPS[kind]:
        crimped = {"crimp": CRIMPS[kind](section(scene)[0], spacing)}
        scene = sheet({"name": fabric, "warp": crimped, "weft": crimped}, width, 1.0)
    shape = {"projectile.shape": "cylinder" if body["length"] else "sphere"} | (
        {"projectile.length": body["length"]} if body["length"] else {}
    )
    scene = scene.replace(
        shape | {"projectile.radius": body["radius"], "projectile.mass": body["mass"], "projectile.velocity": [0.0, 0.0, 50.0]}
    )
    scene = scene.replace({"contact.friction": friction})
    # A crossing is at the middle, or half a spacing from it.
    even = 0.0 if scene["sheet.nodes_x"] % 2 else 0.5
    return scene.aimed([(part + even) * spacing for part in PLACES[place]])


def resolved(fabric, width, body, place, more, pieces=3):
    """The arguments of the reference."""
    scene = sheet({"name": fabric}, width, 1.0)
    thickness, yarn = section(scene)
    x, y = PLACES[place]
    return (
        {
            "spacing": scene["sheet.spacing"],
            "pieces": pieces,
            "yarns": scene["sheet.nodes_x"] - 2,
            "stiffness": scene["yarn.modulus_mean"] * scene["sheet.yarn_area"],
            "line_mass": scene["sheet.node_mass"] / (2 * scene["sheet.spacing"]),
            "critical_stretch": scene["yarn.critical_stretch"],
            "damage_rate": scene["yarn.damage_intercept"] + scene["yarn.damage_slope"] * scene["yarn.modulus_mean"],
            "thickness": thickness,
            "width": yarn,
            "x": x,
            "y": y,
            "longest": LONGEST,
            "step": STEP,
        }
        | body
        | more
    )


def built():
    """Builds the reference for this processor; its bits do not depend on that."""
    command = ["cargo", "build", "--release", "--quiet", "--package", "fabric-resolved", "--target-dir", str(PROGRAM.parents[1])]
    subprocess.run(command, cwd=TOP, check=True, env=os.environ | {"RUSTFLAGS": "-C target-cpu=native"})


def shoot(arguments, velocity, *more):
    """One shot of the reference."""
    words = [f"{key}={value!r}" for key, value in arguments.items()]
    done = subprocess.run([PROGRAM, *words, f"velocity={velocity!r}", *more], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def measured(job):
    """The limit of one job: {"scene" or "reference", "guess"}; the shots in their order."""
    shots = []

    def through(velocity):
        if "scene" in job:
            found = impact(job["scene"].replace({"projectile.velocity": [0.0, 0.0, velocity]}), LONGEST)
            shots.append(
                {"speed": velocity, "through": found["through"], "residual": found["residual"], "broken_bars": found["failed"]}
            )
        else:
            found = shoot(job["reference"], velocity)
            passed = found["end"] == "through" or (found["end"] != "arrested" and found["velocity"] > 0.05 * velocity)
            shots.append(found | {"speed": velocity, "through": passed})
        return shots[-1]["through"]

    low, high = bisected(*bracket(job["guess"], through, STRIDE), through, width=BRACKET)
    slowest = next(shot for shot in shots if shot["speed"] == high)
    return {
        "limit": 0.5 * (low + high),
        "bracket": high - low,
        "slowest": slowest,
        "worst": max(abs(shot["residual"]) for shot in shots),
        "shots": shots,
    }


def of_radius(times):
    return SPHERE | {"radius": SPHERE["radius"] * times, "mass": SPHERE["mass"] * times**3}


# Friction between yarns and on the body, radius over that of the sphere, width, m, about the limit, m/s: hits on a window.
WINDOWS = [
    *((mu, 0.0, 1.0, 0.051, guess) for mu, guess in ((0.1, 60.0), (0.05, 34.0), (0.15, 75.0), (0.2, 70.0), (0.0, 24.0))),
    *((0.0, mu, 1.0, 0.051, guess) for mu, guess in ((0.1, 60.0), (0.2, 75.0))),
    (0.05, 0.05, 1.0, 0.051, 60.0),
    *(
        (mu, body, 0.5, 0.051, guess)
        for mu, body, guess in ((0.1, 0.0, 30.0), (0.2, 0.0, 45.0), (0.3, 0.0, 80.0), (0.2, 0.2, 120.0))
    ),
    *((mu, 0.0, 2.0, 0.051, guess) for mu, guess in ((0.0, 20.0), (0.05, 28.0), (0.075, 34.0))),
    (0.07, 0.07, 1.0, 0.051, 75.0),
    (0.14, 0.0, 1.0, 0.051, 75.0),
    (0.1, 0.1, 0.5, 0.051, 60.0),
]


# Width, m, force at which a yarn end slips in its clamp, N, about the limit, m/s.
CLAMPS = [
    (0.051, 20.0, 175.0),
    (0.051, 40.0, 110.0),
    (0.051, 60.0, 80.0),
    (0.06, 20.0, 190.0),
    (0.06, 40.0, 125.0),
    (0.06, 60.0, 95.0),
]


# Single hits likewise on a window of a sheet of 102 mm, with their velocity, m/s: whether a window opens needs no limit. The
# first are below the criterion, the others above.
HITS = [
    *((0.05, 0.05, 1.0, 75.0), (0.1, 0.0, 1.0, 75.0), (0.05, 0.0, 1.0, 60.0), (0.0, 0.1, 1.0, 60.0), (0.2, 0.0, 0.5, 75.0)),
    *((mu, body, 1.0, 140.0) for mu, body in ((0.14, 0.0), (0.0, 0.2), (0.07, 0.07), (0.1, 0.1), (0.2, 0.2))),
    *((mu, body, 1.0, 140.0) for mu, body in ((0.16, 0.0), (0.18, 0.0), (0.09, 0.09), (0.2, 0.0))),
    *((mu, 0.0, 0.5, speed) for mu, speed in ((0.3, 140.0), (0.3, 250.0), (0.36, 250.0), (0.4, 250.0))),
]


def hit(job):
    """One shot of the reference: {"reference", "velocity", "model"}."""
    return shoot(job["reference"], job["velocity"])


def hits():
    """The jobs of HITS."""
    references = [resolved(KEVLAR, 0.102, of_radius(times), "window", rubbing(mu, body)) for mu, body, times, _ in HITS]
    return [{"reference": reference, "velocity": one[-1], "model": MODEL} for reference, one in zip(references, HITS)]


def text_of_hits(found):
    ends = ["stopped" if shot["end"] == "arrested" else f"{shot['velocity']:.0f}" for shot in found]
    broken = [
        f"{shot['broken_yarns']:.0f}" + (" (window)" if end != "stopped" and shot["broken_yarns"] == 0 else "")
        for end, shot in zip(ends, found)
    ]
    lines = [
        [*numbers, end, yarns, f"{100 * shot['residual']:.2f}"] for numbers, end, yarns, shot in zip(HITS, ends, broken, found)
    ]
    heading = ["mu", "mu_s", "radius", "velocity, m/s", "after, m/s", "broken", "residual, %"]
    return "\n## Single hits on a window, 102 mm\n\n" + page.markdown(heading, lines)


def jobs(full):
    """(labels, job) of the network and of the reference; those of least use last."""
    found = []

    def add(part, name, width, place, body, guess, more, fabric=KEVLAR, pieces=3):
        label = {"part": part, "case": name, "fabric": fabric, "width": width, "place": place, "pieces": pieces}
        found.append((label, {"reference": resolved(fabric, width, body, place, more, pieces), "guess": guess, "model": MODEL}))

    def nets(part, width, place, body, guess, fabric=KEVLAR, frictions=(0.0, 0.1, 0.2, 0.3)):
        for name in CRIMPS:
            for friction in frictions if name != "free crimp" else frictions[:1]:
                label = dict(
                    part=part, case=f"network, {name}, mu_s = {friction}", fabric=fabric, width=width, place=place, pieces=1
                )
                found.append((label, {"scene": network(fabric, width, body, place, name, friction), "guess": guess}))

    guesses = {0.051: 65.0, 0.06: 78.0, 0.102: 125.0}
    if not full:
        nets("limits", 0.012, "crossing", SPHERE, 25.0, frictions=(0.0, 0.1))
        for name in list(variants())[::2]:
            add("limits", name, 0.012, "crossing", SPHERE, 20.0, variants()[name])
        return found

    def limits(width, place, names):
        nets("limits", width, place, SPHERE, guesses[width])
        for name in names:
            add(
                "limits",
                name,
                width,
                place,
                SPHERE,
                guesses[width] * (1.0 if name == "pinned, straight" else 1.15),
                variants()[name],
            )

    every = list(variants())
    limits(0.051, "crossing", every)
    limits(0.051, "window", every)
    limits(0.051, "yarn", every)
    limits(0.06, "crossing", every)
    for width, hold, guess in CLAMPS:
        add("clamps", f"pinned, straight, {hold:g} N", width, "crossing", SPHERE, guess, STRAIGHT | {"clamp": hold})
        label = found[-1][0] | {"case": f"network, flat, {hold:g} N", "pieces": 1}
        found.append(
            (
                label,
                {"scene": network(KEVLAR, width, SPHERE, "crossing", "flat").replace({"attachment.hold": hold}), "guess": guess},
            )
        )
    add("clamps", "mu = mu_s = 0.2, 20 N", 0.051, "crossing", SPHERE, 90.0, rubbing(0.2, 0.2) | {"clamp": 20.0})
    for mu, pieces in ((0.1, 4), (0.2, 4), (0.3, 4), (0.2, 6)):
        add("limits", f"mu = mu_s = {mu}", 0.051, "crossing", SPHERE, 75.0, rubbing(mu, mu), pieces=pieces)
    for mu, body, times, width, guess in WINDOWS:
        add("windows", f"mu {mu:g}, mu_s {body:g}, radius {times:g}", width, "window", of_radius(times), guess, rubbing(mu, body))
    add("windows", "mu 0.05, mu_s 0, radius 1", 0.051, "crossing", SPHERE, 60.0, rubbing(0.05, 0.0))
    for mu, guess in ((0.1, 60.0), (0.05, 46.0)):
        add("windows", f"mu {mu:g}, mu_s 0, radius 1", 0.051, "window", SPHERE, guess, rubbing(mu, 0.0), pieces=4)
    limits(0.102, "crossing", every)
    for name, body, fabric, guess in (("cylinder", CYLINDER, KEVLAR, 60.0), ("Zylon", SPHERE, ZYLON, 70.0)):
        nets(name, 0.051, "crossing", body, guess, fabric, (0.0, 0.2))
        for case in (every[0], every[3]):
            add(name, case, 0.051, "crossing", body, guess, variants()[case], fabric)
    return found


def drawn(study):
    """A window without a broken yarn beside a tear: what is near the hole, seen along the flight, while the body is in it."""
    import matplotlib.patches
    import numpy

    width, spacing = 0.012 if study.effort != FULL else 0.051, sheet({"name": KEVLAR}, 0.051, 1.0)["sheet.spacing"]
    figure, plots = drawing.new(7, 4.2, 2)
    shots = (
        ("friction 0.05 between yarns, none on the sphere", rubbing(0.05, 0.0), "window", 75e-6),
        ("friction 0.2 and 0.2", rubbing(0.2, 0.2), "crossing", 125e-6),
    )
    for axes, (name, more, place, time) in zip(plots, shots):
        file = study.folder / f"{place}.txt"
        found = shoot(resolved(KEVLAR, width, SPHERE, place, more) | {"longest": time}, 85.0, f"shape={file}")
        nodes = numpy.loadtxt(file)
        for yarn in range(int(nodes[-1, 0]) + 1):
            own = 1e3 * nodes[nodes[:, 0] == yarn]
            whole = own[:, 4] > 0.0
            # Behind a broken bar the line has a gap.
            x, y = (numpy.insert(own[:, k], numpy.flatnonzero(~whole) + 1, numpy.nan) for k in (1, 2))
            warp = yarn <= nodes[-1, 0] // 2
            axes.plot(x, y, color="tab:blue" if warp else "tab:orange", linewidth=2.2, alpha=0.85)
        axes.add_patch(
            matplotlib.patches.Circle(
                [1e3 * part * spacing for part in PLACES[place]], 1e3 * SPHERE["radius"], fill=False, linestyle="--"
            )
        )
        axes.set(xlim=(-7, 7), ylim=(-7, 7), aspect="equal", xlabel="x (mm)", ylabel="y (mm)")
        axes.set_title(
            f"{name}: {found['broken_yarns']:.0f} yarns broken,\n85 m/s before, {found['velocity']:.0f} m/s after "
            f"{1e6 * time:.0f} µs",
            fontsize=10,
        )
    drawing.save(figure, study.folder / "oneply.png")
    study.picture("oneply.png", "oneply.png")


def slipped():
    """Crossings near the hit whose pinning takes more than friction gives, in the network, beside those that slipped by a tenth
    of a spacing till then in the reference."""
    lines, scene = [], network(KEVLAR, 0.051, SPHERE, "crossing", "flat")
    for time in (60e-6, 120e-6):
        simulation = Simulation(scene.replace({"projectile.velocity": [0.0, 0.0, 60.0]}), warns=False)
        simulation.run((), round(time / simulation.step_limits()["dt"]))
        for mu in (0.1, 0.2, 0.3):
            near, around, whole = simulation.slip(2.0 * section(scene)[0], mu)["slipping"]
            found = shoot(resolved(KEVLAR, 0.051, SPHERE, "crossing", rubbing(mu, 0.0)) | {"longest": time}, 60.0)
            lines.append(
                [f"{1e6 * time:.0f}", mu, near, f"{found['slipped_5']:.0f}", around, f"{found['slipped_10']:.0f}", whole]
            )
    heading = "time, µs; mu; within 5 spacings, network; resolved; within 10, network; resolved; whole sheet, network".split("; ")
    return "\n## Where crossings slip: 51 mm, 60 m/s, no friction on the sphere\n\n" + page.markdown(heading, lines)


def heights(study):
    """Interchange of crimp in pinned yarns: of the heights of both waves at a crossing, the part that the yarn through the hit
    has."""
    import numpy

    file = study.folder / "heights.txt"
    shoot(resolved(KEVLAR, 0.051, SPHERE, "crossing", CRIMPED) | {"longest": 120e-6}, 60.0, f"shape={file}")
    nodes = numpy.loadtxt(file)
    yarns = (int(nodes[-1, 0]) + 1) // 2
    # z at the crossings of each yarn; a yarn ends 3 bars beyond its last crossing.
    z = numpy.array([nodes[nodes[:, 0] == yarn][3 : 3 + 3 * yarns : 3, 3] for yarn in range(2 * yarns)])
    warp, weft = (abs(z[k, 1:-1] - 0.5 * (z[k, :-2] + z[k, 2:])) for k in (slice(0, yarns), slice(yarns, None)))
    middle, near = yarns // 2, numpy.r_[8:17, -16:-7]
    part = numpy.mean(
        [warp[middle, middle - 1 + k] / (warp[middle, middle - 1 + k] + weft[middle + k, middle - 1]) for k in near]
    )
    return (
        "\nInterchange of crimp, pinned, 51 mm, 60 m/s, after 120 µs, 8 to 16 spacings from the hit: "
        f"the yarn through it has {part:.2f} of the height of both waves at a crossing; 0.50 at rest.\n"
    )


NOTES = """Limits in m/s by bisection to 3 m/s, four sides held, one place of hit each.
Pieces: bars between two crossings; 1 is the network.
Broken: yarns with a broken bar in the slowest shot that went through; 0 is a window.
Slip: the farthest that a crossing moved along a yarn in that shot, in spacings.
Residual: the largest of the balance of energy in these shots, of the impact energy.
Thickness and width of the yarns are assumed (evidence/oneply.py); mu is friction between yarns, mu_s on the projectile.
"""
TITLES = {
    "limits": "Kevlar KM2 S706, sphere",
    "clamps": "Clamps that slip above a force",
    "windows": "Hits on a window",
    "cylinder": "Flat-ended cylinder",
    "Zylon": "Zylon AS, 500 denier, 35 x 35",
}


def clamped(rows):
    """The network beside the reference, both with pinned crossings and the same force at which yarn ends slip; the reference's
    other rows after them."""
    found, lines = {(row["width"], row["case"]): row for row in rows}, []
    for width, hold, _ in CLAMPS:
        net, own = (found.pop((width, f"{name}, {hold:g} N")) for name in ("network, flat", "pinned, straight"))
        off = 100 * (net["limit"] / own["limit"] - 1)
        limits = f"{own['limit']:.1f} {net['limit']:.1f} {off:+.1f} {100 * own['worst']:.2f} {100 * net['worst']:.2f}"
        lines.append(f"{hold:g} {1e3 * width:.0f} {limits}".split())
    table = page.markdown(
        ["slips at, N", "width, mm", "resolved, m/s", "network, m/s", "off, %", "residual, %", "network's, %"], lines
    )
    return table + "".join(
        f"\nResolved, {1e3 * width:.0f} mm, {case}: {row['limit']:.1f} m/s.\n" for (width, case), row in found.items()
    )


def text_of(rows):
    text = NOTES
    for part, title in TITLES.items():
        own = [row for row in rows if row["part"] == part]
        if part == "clamps" and own:
            text += f"\n## {title}\n\n" + clamped(own)
            continue
        lines = []
        for row in sorted(own, key=lambda row: (row["width"], row["place"])):
            window = "" if row["broken"] is None else f"{row['broken']:.0f}" + (" (window)" if row["broken"] == 0 else "")
            slip = "" if row["slip"] is None else f"{row['slip']:.2f}"
            first = [f"{1e3 * row['width']:.0f}", row["place"], row["case"], row["pieces"], f"{row['limit']:.1f}"]
            lines.append([*first, window, slip, f"{100 * row['worst']:.2f}"])
        if lines:
            text += f"\n## {title}\n\n" + page.markdown(
                ["width, mm", "place", "case", "pieces", "limit, m/s", "broken", "slip", "residual, %"], lines
            )
    return text


def ratios(rows):
    """Ratios of the network, pinned and with friction on the body, over the reference with friction: {flat or crimp: [...]}."""
    key = lambda row: (row["part"], row["fabric"], row["width"], row["place"])
    found = {"flat": [], "crimp": []}
    for row in rows:
        if row["case"].startswith("mu = mu_s = ") and row["pieces"] == 3:
            for kind, values in found.items():
                name = f"network, {kind}, mu_s = {row['case'].split()[-1]}"
                values += [
                    row["limit"] and other["limit"] / row["limit"]
                    for other in rows
                    if other["case"] == name and key(other) == key(row)
                ]
    return found


def answer(study):
    built()
    wanted = jobs(study.effort == FULL)
    rows = []
    for (label, _), one in zip(wanted, study.each(measured, [job for _, job in wanted])):
        slowest = one["slowest"]
        more = {"broken": slowest.get("broken_yarns"), "slip": slowest.get("slip"), "worst": one["worst"]}
        rows.append(label | {"limit": one["limit"], "bracket": one["bracket"]} | more)
    study.write("oneply", [{key: "" if value is None else value for key, value in row.items()} for row in rows])
    told = "; ".join(
        f"{kind} {min(values):.2f} to {max(values):.2f} ({len(values)} cases)" for kind, values in ratios(rows).items() if values
    )
    text = text_of(rows) + (text_of_hits(study.each(hit, hits())) + slipped() + heights(study) if study.effort == FULL else "")
    study.table(
        "oneply",
        "One ply: network and resolved yarns",
        f"{text}\nNetwork over resolved yarns, at the same friction on the body: {told}.\n",
    )
    drawn(study)
    return max(row["worst"] for row in rows if row["pieces"] > 1) < 0.02
