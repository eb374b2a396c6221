"""One yarn hit across its middle, against the similarity solution: strain behind the longitudinal front, the speeds of both
waves, and the velocity at which the yarn breaks at once.

Closed forms: J. C. Smith, F. L. McCrackin, H. F. Schiefer, Textile Research Journal 28 (1958) 288. For a yarn whose force is E A
e, with the strain e and c = sqrt(E/rho), the impact velocity is V = c sqrt(2 e sqrt(e (1 + e)) - e^2), the longitudinal wave runs
at c along the yarn, the kink at c (sqrt(e (1 + e)) - e) in the laboratory. The model's force is N = E A U (U^2 - 1)/2, which is
larger by 1.5 e: `viscosity.transverse` has its jump conditions. The verdict is against the model's own law; how far it is from
the other stands beside it.

Method: a strip of two rows of nodes; each row is one yarn with half the mass of the fabric's nodes, which is that of a yarn by
itself, and the weft between the rows stays at rest. A lying cylinder whose velocity is prescribed, of the node spacing's radius,
strikes it across. From half of the time on, until the longitudinal front is near the held ends, the mean strain is taken between
0.2 and 0.4 of the way to the front, where the first contact no longer shows; the speeds are slopes of least-squares lines.
"""

import math
from typing import NamedTuple

import numpy
from fabric_kernel import Scene, Simulation, drawing
from fabric_kernel.drawing import Series
from scipy.optimize import brentq

from . import page
from .comparison import Comparison, Point, about, exact
from .study import FULL
from .viscosity import NONE, PLATEAU, TRAVEL, VISCOUS, least, lying, smith, transverse, viscosity_name, viscous

YARNS = ("zylon_as_500_35", "kevlar_km2_s706")
# Impact velocities, m/s, and those at which the spacing is changed; bars, in yarn spacings.
SPEEDS, REFINED, BARS = (50.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0), (100.0, 300.0, 600.0), (4.0, 2.0, 0.5)
# Allowed error of the strain at the fabric's spacing; samples in the second half of the time.
TOLERANCE, SAMPLES = 1e-2, 24


class Strip(NamedTuple):
    """A yarn that is hit: half of its length and a bar, in yarn spacings; radius of the cylinder likewise, at least a bar."""

    name: str
    half: float
    bar: float
    viscosity: tuple
    radius: float

    def scene(self, speed):
        scene = Scene("sheet_3in_sphere", fabric={"name": self.name})
        spacing = scene["sheet.spacing"]
        # One of the two yarns that meet at a node.
        sheet = {
            "nodes_x": 2 * int(self.half / self.bar) + 1,
            "nodes_y": 2,
            "spacing": spacing * self.bar,
            "node_mass": scene["sheet.node_mass"] * (0.5 * self.bar),
            "thickness": 0.0,
        }
        body = lying(self.radius * spacing, speed, length=4.0 * (spacing * self.bar))
        return scene.replace({"sheet": sheet, "attachment.kind": "two_sides"} | body | viscous(self.viscosity))


def smith_linear(strain):
    """Smith's relation for a force that is linear in the strain: V/c."""
    return math.sqrt(2.0 * strain * math.sqrt(strain * (1.0 + strain)) - strain * strain)


def linear_strain(over_c):
    """Strain behind the front at V/c."""
    return brentq(lambda strain: smith_linear(strain) - over_c, 0.0, 1.0, xtol=1e-15)


def wave_speed(scene):
    """Wave speed of a straight yarn at small strain, m/s; the mass of a yarn by itself."""
    return math.sqrt(scene["yarn.modulus_mean"] * scene["sheet.yarn_area"] / (scene["sheet.node_mass"] / scene["sheet.spacing"]))


def waves(scene, speed):
    """Strain, speed of the longitudinal front along the yarn at rest and of the kink in the laboratory, m/s, of the model's law,
    and Smith's."""
    stretch, own = smith(scene, speed)
    c = wave_speed(scene)
    strain = linear_strain(speed / c)
    return (stretch - 1.0, own.front, own.kink), (strain, c, c * (math.sqrt(strain * (1.0 + strain)) - strain))


def measured(job):
    """Quantities of the network; NaN if the yarn breaks."""
    strip, speed = Strip(*job[0]), job[1]
    scene = strip.scene(speed)
    (strain, front, _), _ = waves(scene, speed)
    simulation, h, half = Simulation(scene, warns=False), scene["sheet.spacing"], scene["sheet.nodes_x"] // 2
    steps = int(TRAVEL * half * h / front / simulation.step_limits()["dt"])
    means, fronts, kinks, times = [], [], [], []
    for sample in range(1, SAMPLES + 1):
        simulation.step(steps // 2 + steps * sample // (2 * SAMPLES) - simulation.step_count)
        yarn = simulation.stretch()[half : 2 * half] - 1.0
        start, end = (int(part * front * simulation.time / h) for part in PLATEAU)
        means.append(yarn[start:end].mean())
        last = int(numpy.nonzero(yarn > 0.5 * strain)[0].max(initial=0))
        fronts.append((last + 0.5 + (yarn[last] - 0.5 * strain) / (yarn[last] - yarn[last + 1])) * h)
        kinks.append(kink(simulation.positions()[0, half:]))
        times.append(simulation.time)
    if simulation.counters()["failed_segments"]:
        return [math.nan] * 3
    return [float(numpy.mean(means)), slope(times, fronts), slope(times, kinks)]


def kink(nodes):
    """Where the kink is, m: the yarn inside it is straight, and the line through its middle part meets z = 0 there."""
    depth, z = nodes[0, 2], nodes[:, 2]
    inside = nodes[(z > 0.25 * depth) & (z < 0.75 * depth)]
    return inside[:, 0].mean() - inside[:, 2].mean() * slope(inside[:, 2], inside[:, 0])


def slope(x, y):
    """Slope of the least-squares line."""
    x, y = numpy.asarray(x) - numpy.mean(x), numpy.asarray(y) - numpy.mean(y)
    return float((x * y).sum() / (x * x).sum())


def critical(job):
    """Least velocity at which the yarn breaks before the front is near its ends, m/s, searched from half of the closed form's
    on."""
    strip = Strip(*job)
    scene = strip.scene(0.0)
    closed = transverse(scene, scene["yarn.critical_stretch"]).speed
    return least(strip, 0.5 * closed, closed, failure=True)


def compared(study):
    full, jobs, searches = study.effort == FULL, [], []
    half = 1600.0 if full else 800.0
    for name in YARNS:
        for viscosity in (NONE, VISCOUS):
            jobs += [(Strip(name, half, 1.0, viscosity, 1.0), speed) for speed in (SPEEDS if full else REFINED)]
            if full:
                jobs += [(Strip(name, half, bar, viscosity, bar), speed) for bar in BARS for speed in REFINED]
                searches += [Strip(name, 175.0, bar, viscosity, radius) for radius in (1.0, 8.0) for bar in (1.0, 0.5)]
    rows, sound = [], True
    for (strip, speed), found in zip(jobs, study.each(measured, jobs, "yarn")):
        own, linear = waves(strip.scene(speed), speed)
        broken = math.isnan(found[0]) and strip.viscosity == NONE
        sound &= strip.bar != 1.0 or broken or abs(found[0] / own[0] - 1) < TOLERANCE
        row = {"yarn": strip.name, "viscosity": viscosity_name(strip.viscosity), "yarns a bar": strip.bar, "impact m/s": speed}
        for prefix, (strain, front, kink_) in (("", found), ("exact ", own), ("linear ", linear)):
            row |= {f"{prefix}strain %": 100 * strain, f"{prefix}front m/s": front, f"{prefix}kink m/s": kink_}
        rows.append(row)
    study.write("yarn", rows)
    comparisons, text = waves_text(study, rows)
    text = f"## One yarn hit across\n\n{text}"
    velocities = []
    for strip, velocity in zip(searches, study.each(critical, searches, "critical velocity")):
        scene = strip.scene(0.0)
        stretch = scene["yarn.critical_stretch"]
        row = {"yarn": strip.name, "viscosity": viscosity_name(strip.viscosity), "yarns a bar": strip.bar}
        row |= {"cylinder R spacings": strip.radius, "critical m/s": velocity, "exact m/s": transverse(scene, stretch).speed}
        velocities.append(row | {"linear m/s": wave_speed(scene) * smith_linear(stretch - 1.0)})
    if velocities:
        study.write("critical", velocities)
        more, its_text = critical_text(velocities)
        comparisons, text = comparisons + more, f"{text}\n## Critical velocity of a yarn\n\n{its_text}"
    return comparisons, text, sound


def error(name):
    """Error of a wave's quantity, %."""
    return lambda row: 100 * (row[name] / row[f"exact {name}"] - 1)


def waves_text(study, rows):
    quantities = {"strain %": 4, "front m/s": 0, "kink m/s": 0}
    fabric = [row for row in rows if row["yarns a bar"] == 1]
    comparisons = []
    for viscosity in dict.fromkeys(row["viscosity"] for row in rows):
        own = [row for row in fabric if row["viscosity"] == viscosity and row["strain %"] == row["strain %"]]
        for name, what in (
            ("strain %", "strain behind the front"),
            ("front m/s", "longitudinal wave"),
            ("kink m/s", "transverse wave"),
        ):
            points = [
                Point(f"{row['yarn']} at {row['impact m/s']:.0f} m/s", exact(row[name] / row[f"exact {name}"]), about(1, 0.01))
                for row in own
            ]
            comparisons.append(
                Comparison(f"one yarn hit across, viscosity {viscosity}: {what} over theory", "theory", "± 1 %", points, 4)
            )
    series = []
    for name in dict.fromkeys(row["yarn"] for row in fabric):
        own = [row for row in fabric if row["yarn"] == name]
        name = name.split("_")[0].capitalize()
        plain = [row for row in own if row["viscosity"] == "none"]
        series += [
            Series(f"{name}: law of the model", [(row["impact m/s"], row["exact strain %"]) for row in plain], "line"),
            Series(f"{name}: Smith, linear", [(row["impact m/s"], row["linear strain %"]) for row in plain], "dashed"),
            *(
                Series(
                    f"{name}: network{', viscous' * (v != 'none')}",
                    [(row["impact m/s"], row["strain %"]) for row in own if row["viscosity"] == v],
                    "points",
                )
                for v in dict.fromkeys(row["viscosity"] for row in own)
            ),
        ]
    drawing.draw(
        study.folder / "yarn.svg",
        "One yarn hit across: strain after the longitudinal front",
        "impact velocity (m/s)",
        "strain (%)",
        series,
    )
    study.picture("yarn.svg", "validation_yarn.svg")
    columns = [*page.same(["yarn", "viscosity"], None), ("impact m/s", 0)]
    for name, digits in quantities.items():
        columns += [
            (name, name, digits),
            ("theory", f"exact {name}", digits),
            ("off %", error(name), 3),
            ("linear theory", f"linear {name}", digits),
        ]
    text = page.table(fabric, columns, 2) + "\nAn empty row: the yarn broke.\n"
    if len(fabric) < len(rows):
        text += (
            "\nError of the strain in % with longer and shorter bars, and the order of convergence between the last two:\n\n"
            + orders(rows)
        )
    return comparisons, text


def orders(rows):
    bars = sorted({row["yarns a bar"] for row in rows}, reverse=True)
    keys = dict.fromkeys((row["yarn"], row["viscosity"], row["impact m/s"]) for row in rows if row["yarns a bar"] != 1)
    lines = []
    for key in keys:
        errors = {
            row["yarns a bar"]: error("strain %")(row)
            for row in rows
            if (row["yarn"], row["viscosity"], row["impact m/s"]) == key
        }
        last, finest = errors[bars[-2]], errors[bars[-1]]
        # An error of some 1e-5 is that of the reading.
        order = f"{math.log2(last / finest):.2f}" if last * finest > 0 and abs(last) > 0.01 else ""
        lines.append([key[0], key[1], f"{key[2]:.0f}", *(page.shown(errors[bar], 3) for bar in bars), order])
    return page.markdown(["yarn", "viscosity", "impact m/s", *(f"{bar:g} yarns a bar" for bar in bars), "order"], lines, 2)


def critical_text(rows):
    """Two comparisons for each viscosity: a cylinder larger than a bar, and one as thin, whose kink is no longer than the bar."""
    comparisons = []
    for viscosity, thin in [(row["viscosity"], thin) for row in rows for thin in (False, True)]:
        title = (
            f"critical velocity of a yarn, viscosity {viscosity}{', a cylinder as thin as a bar' if thin else ''}, over theory"
        )
        points = [
            Point(
                f"{row['yarn']}, R = {row['cylinder R spacings']:.0f} spacings, {row['yarns a bar']:g} yarns a bar",
                exact(row["critical m/s"] / row["exact m/s"]),
                about(1, 0.05),
            )
            for row in rows
            if row["viscosity"] == viscosity and (row["cylinder R spacings"] <= row["yarns a bar"]) == thin
        ]
        if not points or any(known.what == title for known in comparisons):
            continue
        lacks = "shorter bars at the kink" if viscosity != "none" else "damping: the noise of the kink breaks the yarn early"
        comparisons.append(Comparison(title, "theory", "± 5 %", points, 3, lacks if thin or viscosity == "none" else ""))
    columns = [
        *page.same(["yarn", "viscosity"], None),
        *page.same(["yarns a bar", "cylinder R spacings"], 1),
        *page.same(["critical m/s", "exact m/s"], 0),
    ]
    columns += [("over theory", lambda row: row["critical m/s"] / row["exact m/s"], 3), ("linear theory m/s", "linear m/s", 0)]
    return comparisons, page.table(rows, columns, 2)
