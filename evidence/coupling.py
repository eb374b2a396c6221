"""A projectile moved by its host: coupling schemes over the communication step H, against the integrated run.

The host holds the sphere's position and velocity. Every H it gives the fabric a path to where it expects the sphere to be, takes
back the impulses of the contact, and moves the sphere by them. A scheme is
- the force it uses: the mean over H, or the last internal step's ("inst");
- the path: C1, a cubic from the pose and rate the fabric now has to those expected at t + H; or "jump", where the fabric is put
  right within the first internal step and then moves on as expected;
- the expectation: with the last force's acceleration ("acc"), or with the velocity alone ("vel");
- the update: impulses act at the start of internal steps, so x += V H + F/(2M) H (H + dt) is exact for a constant force; "plain"
  leaves out the dt;
- passes: with a rollback, the fabric is put back and H repeated with the force just found.

Measures: the velocity at 50 us, before any segment fails, against the integrated run, deterministic; the absorbed energy of the
ensemble; the interface energy error, which is what the host's sphere lost less the work done on the fabric.
"""

import math
from typing import NamedTuple

from fabric_kernel import Simulation

from . import page
from .cases import CASES, ROUNDING, node_steps, scene_of
from .statistics import deviation, mean
from .study import SMOKE, clock

# Internal step, s: that of the FMU. Communication steps in internal steps: 1e-7 ... 1e-5 s. Internal steps to 50 us, and most of
# a run.
DT, EXCHANGES, EARLY, LONGEST = 2e-8, (5, 25, 50, 250, 500), 2500, 40_000
END = ["arrested", "exited"]


class Scheme(NamedTuple):
    """rollbacks: repetitions of H with the force just found."""

    name: str
    mean_force: bool
    jump: bool
    accelerated: bool
    plain: bool = False
    rollbacks: int = 0


SCHEMES = [
    *(
        Scheme(f"{force} {path} {expected}", force == "mean", path == "jump", expected == "acc")
        for force in ("mean", "inst")
        for path in ("C1", "jump")
        for expected in ("acc", "vel")
    ),
    Scheme("mean C1 acc, plain", True, False, True, plain=True),
    Scheme("mean C1 acc, 1 rollback", True, False, True, rollbacks=1),
    Scheme("mean C1 acc, 2 rollbacks", True, False, True, rollbacks=2),
    Scheme("mean C1 vel, 1 rollback", True, False, False, rollbacks=1),
]


class Sphere(NamedTuple):
    """The sphere as its host holds it."""

    position: tuple
    velocity: tuple
    mass: float

    def after(self, force, time, dt):
        """After `time` under a constant force whose impulses act at the start of steps of `dt` (0: all the time)."""
        acceleration = [f / self.mass for f in force]
        position = [x + (v * time + 0.5 * a * time * (time + dt)) for x, v, a in zip(self.position, self.velocity, acceleration)]
        return Sphere(tuple(position), tuple(v + a * time for v, a in zip(self.velocity, acceleration)), self.mass)


def measured(job):
    """One run, integrated by the kernel if there is no scheme."""
    scene, scheme, exchange = job
    simulation = Simulation(scene.replace({"drive": "prescribed"} if scheme else {}), warns=False)
    begin, early = clock(), math.nan
    if not scheme:
        simulation.step(EARLY)
        early = simulation.projectile()["velocity"][2]
        simulation.run(END, LONGEST)
        velocity, cost = simulation.projectile()["velocity"][2], node_steps(simulation)
    else:
        early, velocity, cost = coupled(scene, simulation, Scheme(*scheme), exchange)
    seconds, contact, mass = clock() - begin, simulation.contact(), scene["projectile.mass"]
    # The sphere moves along z but for rounding.
    start = 0.5 * mass * scene["projectile.velocity"][2] ** 2
    lost = start - 0.5 * mass * velocity * velocity
    found = dict(
        early=early, velocity=velocity, absorbed=lost, interface=(lost - contact["work"]) / start, peak=contact["force_peak"]
    )
    return found | {"node_steps": cost, "seconds": seconds, "ended": any(name in simulation.outcomes() for name in END)}


def coupled(scene, simulation, scheme, exchange):
    """The host moves the sphere. Returns its velocity at 50 us and at the end, and the force evaluations."""
    sphere = Sphere(scene["projectile.position"], scene["projectile.velocity"], scene["projectile.mass"])
    dt, force, early, cost, nodes = 0.0 if scheme.plain else DT, (0.0, 0.0, 0.0), math.nan, 0, simulation.positions()[..., 0].size
    while simulation.step_count < LONGEST and not any(name in simulation.outcomes() for name in END):
        image = simulation.save() if scheme.rollbacks else None
        for repeat in range(scheme.rollbacks + 1):
            if repeat:
                simulation.restore(image)
            # Without the acceleration only a repetition knows the force.
            force = follow(simulation, sphere, force if scheme.accelerated or repeat else (0.0, 0.0, 0.0), scheme, exchange, dt)
            cost += exchange * nodes
        sphere = sphere.after(force, exchange * DT, dt)
        if simulation.step_count == EARLY:
            early = sphere.velocity[2]
    return early, sphere.velocity[2], cost


def follow(simulation, sphere, expected, scheme, exchange, dt):
    """One communication step of the fabric; the force on the sphere that the host will use."""
    first, before, done = simulation.step_count, simulation.contact()["impulse"], int(scheme.jump)
    if scheme.jump:
        simulation.follow(*sphere.after(expected, DT, dt)[:2], path_steps=1, first=first)
    end, path = sphere.after(expected, exchange * DT, dt)[:2], {"path_steps": exchange - done, "first": first + done}
    simulation.follow(*end, **path, steps=exchange - done - 1)
    nearly = simulation.contact()["impulse"]
    simulation.follow(*end, **path, steps=1)
    since, time = (before, exchange * DT) if scheme.mean_force else (nearly, DT)
    return tuple((b - a) / time for a, b in zip(since, simulation.contact()["impulse"]))


def answer(study):
    runs, exchanges = study.of(4, 2, 1), EXCHANGES[study.of(0, 2, 4) :]
    scenes = [scene_of(CASES[0], study.effort == SMOKE, k * ROUNDING).replace({"time_step.seconds": DT}) for k in range(runs)]
    # The integrated run first; then every scheme and H.
    ways = [(None, 0), *((scheme, exchange) for exchange in exchanges for scheme in SCHEMES)]
    found, rows = iter(study.each(measured, [(scene, *way) for way in ways for scene in scenes])), []
    for scheme, exchange in ways:
        own = [next(found) for _ in scenes]
        of = lambda name: [run[name] for run in own]
        error = lambda name: deviation(of(name)) / math.sqrt(runs)
        row = {"scheme": scheme.name if scheme else "integrated", "H s": exchange * DT if scheme else math.nan, "runs": runs}
        row |= {"ended": sum(of("ended"))}
        row |= {"V(50 us) error m/s": mean(of("early")) - (rows[0]["early"] if rows else mean(of("early")))}
        row |= {"early": mean(of("early")), "interface energy error % of KE0": 100 * mean(of("interface"))}
        row |= {"absorbed J": mean(of("absorbed")), "absorbed: standard error": error("absorbed")}
        row |= {"velocity m/s": mean(of("velocity")), "velocity: standard error": error("velocity"), "peak N": mean(of("peak"))}
        rows.append(row | {"node-steps": mean(of("node_steps")), "CPU s": min(of("seconds"))})
    study.write("coupling", rows)
    draw(study, rows[1:])
    spread = lambda name, unit: lambda row: f"{row[f'{name} {unit}']:.3f} ± {row[f'{name}: standard error']:.3f}"
    ended = lambda row: f"{row['runs']}" if row["ended"] == row["runs"] else f"{row['ended']} of {row['runs']} end"
    columns = [("scheme", None), ("H s", "e0"), ("runs", ended, None), ("V(50 us) error m/s", "e2")]
    columns += [("interface energy error % of KE0", "e1"), ("absorbed J", spread("absorbed", "J"), None)]
    columns += [("velocity m/s", spread("velocity", "m/s"), None), ("peak N", 1), ("node-steps", "e2"), ("CPU s", 2)]
    study.table("accuracy_coupling", "A projectile moved by its host", page.table(rows, columns))


def draw(study, rows):
    names = [scheme.name for scheme in SCHEMES]
    velocity = "velocity", "velocity at 50 µs", "error (m/s)", "V(50 us) error m/s"
    interface = "interface", "interface energy", "interface energy error (% of KE0)", "interface energy error % of KE0"
    for part, (measure, what, label, key), chosen in (
        ("", velocity, names[:6]),
        ("_more", velocity, names[:2] + names[8:]),
        ("", interface, names[:6]),
    ):
        series = page.lines([row for row in rows if row["scheme"] in chosen], "scheme", "H s", lambda row: abs(row[key]))
        file = f"coupling{part}_{measure}.svg"
        page.errors(study.folder / file, f"Sphere moved by a host, 40 J: {what}", "communication step H (s)", label, series)
    study.picture("coupling_velocity.svg", "accuracy_coupling_velocity.svg")
