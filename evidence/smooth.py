"""The smooth phase: error of positions and energy against a run at dt_crit/256, and the order.

A flat 21 x 21 sheet on four held sides is thrown along z; there is no contact. Both integrators solve the same equations, so both
are compared with the same run of velocity Verlet. The second case ends before the first segment fails, at 24 dt_crit.
"""

import math

import numpy
from fabric_kernel import Scene, Simulation

from . import page
from .cases import node_steps
from .study import SMOKE

# Name, velocity at the middle, m/s, end in units of dt_crit.
CASES = (("no damage", 150.0, 80.0), ("first damage", 1300.0, 24.0))
FRACTIONS = (0.7, 0.5, 0.4, 0.3, 0.25, 0.125, 0.0625, 0.05, 0.03125)
# The last tolerance is the one at which the theta rule's own order shows.
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
REFERENCE = 1 / 256
# Step over dt_crit that the kernel accepts.
LARGEST = 0.5
# Range in which the observed order must lie, below ASYMPTOTIC dt_crit.
ORDER, ASYMPTOTIC = (1.9, 2.1), 0.45


def integrator_name(tolerance):
    return f"theta, tolerance {tolerance:.0e}".replace("e-0", "e-") if tolerance else "Verlet"


def thrown(job):
    """A run whose step is the nearest to a fraction of dt_crit that ends exactly at the case's time."""
    speed, time, tolerance, fraction = job
    theta = {"integrator.kind": "theta", "integrator.tolerance": tolerance} if tolerance else {}
    still = {"yarn.stochastic": False, "projectile.position": [0, 0, -1.0], "projectile.velocity": [0, 0, 0]}
    scene = Scene("sheet_3in_sphere", still | {"sheet.nodes_x": 21, "sheet.nodes_y": 21} | theta)
    dt_crit, steps = Simulation(scene).step_limits()["dt_crit"], math.ceil(time / fraction)
    dt = time * dt_crit / steps
    check = "none" if dt > LARGEST * dt_crit else "refuse"
    simulation = Simulation(scene.replace({"time_step.seconds": dt, "step_check": check}), warns=False)
    positions = simulation.positions()
    velocities, half = numpy.zeros_like(positions), 0.5 * 20 * scene["sheet.spacing"]
    for x, v in zip(positions.reshape(-1, 3), velocities.reshape(-1, 3)):
        # Exactly 0 on the held edge, where the cosine only almost is.
        if max(abs(x[0]), abs(x[1])) < 0.999999 * half:
            v[2] = speed * math.cos(0.5 * math.pi * x[0] / half) * math.cos(0.5 * math.pi * x[1] / half)
    simulation.set_motion(positions, velocities)
    energy = simulation.energy()
    simulation.step(steps)
    residual = abs(simulation.energy()["residual"] / (energy["fabric_kinetic"] + energy["strain"]))
    return {
        "positions": simulation.positions().ravel().tolist(),
        "residual": residual,
        "dt": dt / dt_crit,
        "steps": steps,
        "node_steps": node_steps(simulation),
    }


def answer(study):
    tolerances = (1e-6, 1e-10) if study.effort == SMOKE else TOLERANCES
    ways = [(None, REFERENCE)] + [(tolerance, fraction) for tolerance in (None, *tolerances) for fraction in FRACTIONS]
    found = iter(study.each(thrown, [(speed, time, *way) for _, speed, time in CASES for way in ways]))
    rows = []
    for case, *_ in CASES:
        exact = numpy.reshape(next(found)["positions"], (-1, 3))
        for tolerance, fraction in ways[1:]:
            run, before = next(found), rows[-1] if fraction != FRACTIONS[0] else None
            apart = float(numpy.linalg.norm(numpy.reshape(run["positions"], (-1, 3)) - exact, axis=1).max())
            order = lambda name, now: (
                math.log(before[name] / now) / math.log(before["dt/dt_crit"] / run["dt"]) if before else math.nan
            )
            row = {"case": case, "integrator": integrator_name(tolerance), "dt/dt_crit": run["dt"], "steps": run["steps"]}
            row |= {"node-steps": run["node_steps"], "position error m": apart, "order": order("position error m", apart)}
            rows.append(row | {"energy error": run["residual"], "order of energy": order("energy error", run["residual"])})
    study.write("smooth", rows)
    plain = [row for row in rows if row["case"] == "no damage"]
    page.errors(
        study.folder / "smooth_position_steps.svg",
        "Smooth motion, steps of 0.7 to 1/32 dt_crit",
        "node-steps (force evaluations)",
        "largest position error (m)",
        page.lines(plain, "integrator", "node-steps", lambda row: row["position error m"]),
    )
    study.picture("smooth_position_steps.svg", "accuracy_smooth_position_steps.svg")
    words, sound = verdict(rows)
    columns = [
        *page.same(["integrator"], None),
        *page.same(["dt/dt_crit"], 3),
        *page.same(["node-steps", "position error m"], "e2"),
    ]
    columns += [("order", 2), ("energy error", "e1")]
    study.table(
        "accuracy_smooth", "Smooth phase", page.table(plain, columns) + f"\nObserved order below {ASYMPTOTIC} dt_crit: {words}.\n"
    )
    return sound


def verdict(rows):
    """The range of the orders of either integrator, and whether all are 2. That of the energy is asked for without damage only:
    with it, the error changes sign as segments pass the critical stretch."""
    parts, sound = [], True
    for name in (integrator_name(None), integrator_name(TOLERANCES[-1])):
        for quantity, key, cases in (("position", "order", 2), ("energy", "order of energy", 1)):
            own = [row for row in rows if row["integrator"] == name and row["case"] in [case for case, *_ in CASES[:cases]]]
            orders = [row[key] for row in own if row["dt/dt_crit"] < ASYMPTOTIC and row[key] == row[key]]
            sound &= ORDER[0] <= min(orders) and max(orders) <= ORDER[1]
            parts.append(f"{name}, {quantity}: {min(orders):.3f} to {max(orders):.3f}")
    return "; ".join(parts), sound
