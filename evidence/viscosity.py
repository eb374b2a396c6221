"""Overshoot of the undamped network, and what viscosity leaves of it: the strain behind the front of a sudden transverse impact,
and the velocity that breaks a strip, against the closed form; what viscosity does to whole impacts.

Closed form: transverse impact on a long yarn (J. C. Smith, F. L. McCrackin, H. F. Schiefer, Textile Research Journal 28 (1958)
288) with the model's own law. N = A_0 U S grows faster than U, so the longitudinal front is a shock, and its speed depends on the
strain: see `transverse`. No stretch lies above that behind the front. N is largest at the critical stretch U_c, so the yarn
breaks at the velocity that belongs to U = U_c.

Method: a strip two yarns wide and as long as the 10 in sheet, its ends held, whole at the start, struck across its middle by a
lying cylinder whose velocity is prescribed. Both yarns move alike and the segments between them stay at their rest length, so
each row of nodes is one yarn that carries the whole mass of its nodes. A run ends before the front has reached the ends. The
strain of every segment is read after every step. Refinement puts 2, 4 or 8 segments where there was one: the same yarn area, law
and mass per length. The breaking velocity is searched upwards in strides of 1 % of the closed form's, the last stride by
bisection to 1 m/s: beyond it there may be velocities that do not break the strip again, because the peaks grow unsteadily.

Limits: a cylinder is no point. It is wrapped first: in contact over x = sqrt(2 R V t) on each side (small slopes), the yarn is
longer by x^3/(6 R^2), and what it draws in, V sqrt(V t/(2 R)), grows to the closed form's V^2/(2 k) at t = R V/(2 k^2), when the
contact becomes slower than the kink with its k m/s: 1 to 4 us for R = 6.35 mm. The strain is never above the closed form's.

Whole impacts: those of drawn yarn run until the body is arrested or has exited; runs differ by the seed. The slack sheet, of
uniform yarn, is stepped for a fixed time; its runs differ by 1e-12 in the impact velocity.
"""

import math
from typing import NamedTuple

from fabric_kernel import Scene, Simulation, drawing
from fabric_kernel.drawing import Series
from fabric_kernel.search import bisected
from scipy.optimize import brentq

from . import page
from .cases import DEFAULT, ROUNDING, segments
from .statistics import deviation, mean
from .study import FULL, SMOKE

# Yarn spacings on each side of the impact; how far the front may come; yarn spacings on each side that count as near the contact.
HALF, TRAVEL, NEAR = 175, 0.95, 20
# Where the mean behind the front is taken, in parts of the way the front has come: beyond the kink.
PLATEAU = (0.2, 0.4)
# Allowed error of that mean under the thin cylinder; with bending viscosity under the thick one, of the velocity that breaks the
# strip and of the largest strain at PICTURE m/s.
TOLERANCE, BREAKS, LARGEST = 1e-2, 0.05, 0.03
SPEEDS, PICTURE = (100.0, 400.0, 800.0), 400.0
# Linear, quadratic, bending. The second is the usual one of explicit codes, which acts along the yarn alone; the third is that of
# real fabrics.
NONE, VISCOUS = (0.0, 0.0, 0.0), (0.06, 1.5, 0.06)
VISCOSITIES = (NONE, (0.06, 1.5, 0.0), VISCOUS)
# How long the slack sheet is stepped, and after which time an impact is given up, s.
SLACK, LONGEST = 1.2e-3, 4e-3
MEASURES = ["absorbed J", "velocity m/s", "peak N", "failed %", "viscous loss, % of impact energy", "energy residual, % of it"]


def viscous(viscosity):
    return {f"yarn.viscosity_{kind}": part for kind, part in zip(("linear", "quadratic", "bending"), viscosity)}


def viscosity_name(viscosity):
    return "none" if tuple(viscosity) == NONE else "{:g}, {:g}, {:g}".format(*viscosity)


class Transverse(NamedTuple):
    """Impact velocity that belongs to a stretch, speed of the longitudinal front along the yarn at rest and of the kink in the
    laboratory, m/s."""

    speed: float
    front: float
    kink: float


def transverse(scene, stretch):
    """The similarity solution with the model's law, undamaged: N = A_0 U S with S = E (U^2 - 1)/2, of a yarn with mu = m/h kg/m,
    one node's mass in each segment. The front runs at sqrt(N/(mu (U - 1))), and behind it the yarn moves inwards at w = sqrt(N (U
    - 1)/mu). The kink runs at U c_t - w with c_t = sqrt(N/(mu U)), and V^2 = (U c_t)^2 - (U c_t - w)^2."""
    mu = scene["sheet.node_mass"] / scene["sheet.spacing"]
    pull = scene["sheet.yarn_area"] * stretch * scene["yarn.modulus_mean"] * 0.5 * (stretch * stretch - 1.0)
    inward = math.sqrt(pull * (stretch - 1.0) / mu)
    running = stretch * math.sqrt(pull / (mu * stretch))
    speed = math.sqrt(running * running - (running - inward) * (running - inward))
    return Transverse(speed, inward / (stretch - 1.0) if stretch > 1.0 else math.nan, running - inward)


def smith(scene, speed):
    """The closed form at an impact velocity, at most that of U_c: stretch behind the front and speeds."""
    most = scene["yarn.critical_stretch"]
    reached = transverse(scene, most).speed <= speed
    stretch = most if reached else brentq(lambda stretch: transverse(scene, stretch).speed - speed, 1.0, most, xtol=1e-15)
    return stretch, transverse(scene, stretch)


def lying(radius, speed, **more):
    """A cylinder along y that touches the sheet, moved by its host."""
    body = {
        "shape": "cylinder",
        "radius": radius,
        "length": 12.7e-3,
        "position": [0, 0, -radius],
        "velocity": [0, 0, speed],
        "orientation": [math.sqrt(0.5), math.sqrt(0.5), 0, 0],
    }
    return {"drive": "prescribed", "projectile": body | more}


class Strip(NamedTuple):
    """Radius of the cylinder, m; segments in a yarn spacing; dt over dt_crit; node mass over the preset's."""

    viscosity: tuple
    radius: float
    refinement: int
    step: float = DEFAULT
    mass: float = 1.0

    def scene(self, speed):
        scene = Scene("sheet_3in_sphere", lying(self.radius, speed), attachment={"kind": "two_sides"}, yarn={"stochastic": False})
        sheet = {"nodes_x": 2 * HALF * self.refinement + 1, "nodes_y": 2, "spacing": scene["sheet.spacing"] / self.refinement}
        sheet["node_mass"] = scene["sheet.node_mass"] * (self.mass / self.refinement)
        return scene.replace({"sheet": sheet, "time_step.fraction": self.step} | viscous(self.viscosity))

    def row(self):
        return {
            "viscosity": viscosity_name(self.viscosity),
            "cylinder R mm": 1e3 * self.radius,
            "segments in a spacing": self.refinement,
        }


def steps_of(scene, simulation, speed):
    """Steps until the front is near the held ends."""
    length = 0.5 * (scene["sheet.nodes_x"] - 1) * scene["sheet.spacing"]
    return int(TRAVEL * length / smith(scene, speed)[1].front / simulation.step_limits()["dt"])


def strains(job):
    """Strains of a strip: mean behind the front at the end, largest at any time near the contact and anywhere, yarn spacings
    between the last segments with 90 % and with 10 % of the closed form's strain at the end, and the profile then, mm and %."""
    strip, speed = Strip(*job[0]), job[1]
    scene = strip.scene(speed)
    simulation = Simulation(scene, warns=False)
    # One yarn's half: from the middle to the held end.
    half, near, largest_near, largest = HALF * strip.refinement, NEAR * strip.refinement, 1.0, 1.0
    for _ in range(steps_of(scene, simulation, speed)):
        simulation.step()
        yarn = simulation.stretch()[half : 2 * half]
        largest_near, largest = max(largest_near, yarn[:near].max()), max(largest, yarn.max())
    start, end = (int(part * TRAVEL * half) for part in PLATEAU)
    exact = smith(scene, speed)[0] - 1.0
    last = lambda part: max((k for k, stretch in enumerate(yarn) if stretch - 1.0 > part * exact), default=0)
    profile = [[1e3 * (k + 0.5) * scene["sheet.spacing"], 100 * float(stretch - 1)] for k, stretch in enumerate(yarn)]
    found = {"mean": float((yarn[start:end] - 1).mean()), "near": float(largest_near - 1), "anywhere": float(largest - 1)}
    return found | {"front": (last(0.1) - last(0.9)) / strip.refinement, "profile": profile if strip.refinement <= 4 else []}


def breaking(job):
    """Least velocities at which a segment is damaged and at which one fails, m/s."""
    strip = Strip(*job)
    scene = strip.scene(0.0)
    exact = transverse(scene, scene["yarn.critical_stretch"]).speed
    damage = least(strip, 0.5 * exact, exact, failure=False)
    # What fails is damaged before.
    return [damage, least(strip, damage, exact, failure=True)]


def least(strip, high, exact, failure):
    """Least velocity at which a strip is damaged or fails, m/s: upwards from `high` in strides of 1 % of the closed form's, the
    last one by bisection to 1 m/s, as the peaks grow unsteadily."""
    while not hurts(strip, high, failure):
        high += 0.01 * exact
    return bisected(high - 0.01 * exact, high, lambda speed: hurts(strip, speed, failure), width=1.0)[1]


def hurts(strip, speed, failure):
    """Whether a segment has failed, or is damaged, before the front is near the ends."""
    scene = strip.scene(speed)
    simulation = Simulation(scene, warns=False)
    simulation.run([], steps_of(scene, simulation, speed), failed=1)
    failed = simulation.counters()["failed_segments"] > 0
    return failed or (not failure and bool((simulation.damage() < 1.0).any()))


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


def impacts(study):
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
    columns = [("case", None), ("viscosity", None), ("runs", 0), ("absorbed J", 2), ("deviation %", "absorbed J: deviation %", 1)]
    study.table(
        "accuracy_viscosity",
        "Viscosity in whole impacts",
        page.table(rows, columns + page.same(["velocity m/s"], 1) + page.same(["peak N"], 0) + page.same(MEASURES[3:], 2)),
    )


def answer(study):
    preset = Scene("sheet_3in_sphere")
    thin, thick, smoke = preset["sheet.spacing"], preset["projectile.radius"], study.effort == SMOKE
    refinements = study.of((1, 2, 4, 8), (1, 4), (1,))
    strips = [
        Strip(v, radius, refinement)
        for v in VISCOSITIES[: 1 if smoke else 3]
        for radius in (thin, thick)
        for refinement in refinements
    ]
    jobs = [(strip, speed) for strip in strips for speed in ((PICTURE,) if smoke else SPEEDS)]
    rows, profiles, sound = [], {}, True
    for (strip, speed), found in zip(jobs, study.each(strains, jobs, "strains")):
        exact = smith(strip.scene(speed), speed)[0] - 1.0
        if strip.radius == thin and strip.viscosity == NONE:
            sound &= abs(found["mean"] / exact - 1) < TOLERANCE
        if strip.radius == thick and strip.viscosity == VISCOUS and speed == PICTURE:
            sound &= abs(found["anywhere"] / exact - 1) < LARGEST
        rows.append(
            strip.row()
            | {
                "impact m/s": speed,
                "Smith: U - 1 %": 100 * exact,
                "mean behind the front %": 100 * found["mean"],
                "largest near the contact %": 100 * found["near"],
                "largest anywhere %": 100 * found["anywhere"],
                "front, spacings": found["front"],
            }
        )
        shown = strip.refinement in {NONE: (1, 4), VISCOUS: (4,)}.get(strip.viscosity, ())
        if strip.radius == thin and speed == PICTURE and shown:
            profiles[
                f"{strip.refinement} segment{'s' * (strip.refinement > 1)} per spacing{', viscous' * (strip.viscosity != NONE)}"
            ] = found["profile"]
    study.write("overshoot_strain", rows)
    draw(study, thin, profiles)
    if study.effort == FULL:
        strips += [Strip(NONE, thin, 1, 0.1), Strip(NONE, thin, 4, 0.1), Strip(NONE, thin, 1, DEFAULT, 0.5)]
    velocities = []
    for strip, found in zip(strips, study.each(breaking, strips, "breaking velocities")):
        exact = transverse(strip.scene(0.0), preset["yarn.critical_stretch"]).speed
        if strip.radius == thick and strip.viscosity == VISCOUS:
            sound &= all(abs(velocity / exact - 1) < BREAKS for velocity in found)
        velocities.append(
            strip.row()
            | {
                "dt/dt_crit": strip.step,
                "node mass": strip.mass,
                "Smith m/s": exact,
                "first damage m/s": found[0],
                "first failure m/s": found[1],
            }
        )
    study.write("overshoot_breaking", velocities)
    tables(study, rows, velocities)
    impacts(study)
    return sound


def draw(study, thin, profiles):
    # The closed form: level to the front.
    length, strain = 1e3 * HALF * thin, 100 * (smith(Strip(NONE, thin, 1).scene(PICTURE), PICTURE)[0] - 1)
    series = [Series(name, points, "line") for name, points in profiles.items()]
    series.append(Series("Smith", [(0, strain), (TRAVEL * length, strain), (TRAVEL * length, 0), (length, 0)], "dashed"))
    drawing.draw(
        study.folder / "overshoot_strain.svg",
        f"Strip hit at 400 m/s by a cylinder of {1e3 * thin:.2f} mm",
        "distance from the middle at rest (mm)",
        "strain U − 1 (%)",
        series,
        "from zero",
    )
    study.picture("overshoot_strain.svg", "accuracy_overshoot_strain.svg")


def tables(study, rows, velocities):
    strip = [("viscosity", None), ("cylinder R mm", 2), ("segments in a spacing", 0)]
    smith_, near, anywhere = "Smith: U - 1 %", "largest near the contact %", "largest anywhere %"
    columns = strip + [("impact m/s", 0)] + page.same([smith_, "mean behind the front %"], 4)
    for name in (near, anywhere):
        columns += [(name, name, 4), ("over Smith", lambda row, name=name: row[name] / row[smith_], 2)]
    study.table(
        "accuracy_overshoot_strain",
        "Overshoot: strains of a strip struck across its middle",
        page.table(rows, columns + [("front, 10 to 90 %, spacings", "front, spacings", 1)]),
    )
    columns = strip + page.same(["dt/dt_crit", "node mass", "Smith m/s"], 1)
    for name in ("first damage m/s", "first failure m/s"):
        columns += [(name, name, 0), ("over Smith", lambda row, name=name: row[name] / row["Smith m/s"], 2)]
    study.table("accuracy_overshoot_breaking", "Overshoot: velocities that break the strip", page.table(velocities, columns))
