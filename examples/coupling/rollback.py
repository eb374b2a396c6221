"""Three ways to couple a host's body to the shield, and what each costs in accuracy.

    python rollback.py ../../target/fmu/FabricShield-fmi2.fmu

parallel    both sides step at once: the body moves under the force of the step before
sequential  the shield steps first: the body moves under the force of the same step
rollback    the step is made twice: its first pass tells the acceleration, then the shield goes back and steps again with it

The case is the 3 in sheet, four sides held, sphere, 40 J. The reference is the FMU itself in drive `free`.
"""

import math
import sys

from driven_shield import FREE, PRESCRIBED, Shield, parameter_set
from sphere import MASS, RADIUS, Body

SPEED = math.sqrt(2.0 * 40.0 / MASS)  # m/s
START = [0.0, 0.0, -RADIUS - 1e-5]
EARLY = 5e-5  # s; no segment has failed by then
END = 2.5e-4  # s; the sphere has gone through by then
STEPS = [1e-7, 1e-6, 5e-6, 1e-5]


def parallel(shield, body, t, h, memory):
    force = shield.step(t, h, body)
    body.pushed(memory.get("force", [0.0] * 3), h, memory["dt"])
    memory["force"] = force


def sequential(shield, body, t, h, memory):
    body.pushed(shield.step(t, h, body), h, memory["dt"])


def rollback(shield, body, t, h, memory):
    memory["state"] = shield.save(memory.get("state"))
    first = shield.step(t, h, body)
    shield.restore(memory["state"])
    body.pushed(shield.step(t, h, body, [f / MASS for f in first]), h, memory["dt"])


def run(archive, h, scheme, end=END):
    """Speed at EARLY, m/s, and at the end the energy that the body lost and the shield's account of it, J."""
    start = {"projectile.start.position": START, "projectile.start.velocity": [0.0, 0.0, SPEED]}
    shield = Shield(archive, {**parameter_set("sheet_3in_sphere"), **start, "drive": PRESCRIBED if scheme else FREE})
    body, memory, early = Body(START, [0.0, 0.0, SPEED]), {"dt": shield.get("time_step.seconds")}, None
    for k in range(round(end / h)):
        if scheme:
            scheme(shield, body, k * h, h, memory)
        else:
            shield.fmu.doStep(k * h, h)
            body.position, body.velocity = shield.get("state.position"), shield.get("state.velocity")
        if k + 1 == round(EARLY / h):
            early = body.velocity[2]
    lost, work = 0.5 * MASS * SPEED**2 - body.kinetic_energy(), shield.get("contact.work")
    shield.close()
    return early, lost, work


def table(archive, steps=STEPS):
    """Rows: scheme, H, error of the speed at EARLY over the impact speed, interface residual at the end over KE0."""
    energy = 0.5 * MASS * SPEED**2
    reference = run(archive, 1e-6, None, EARLY)[0]
    rows = []
    for scheme in (parallel, sequential, rollback):
        for h in steps:
            early, lost, work = run(archive, h, scheme)
            rows.append((scheme.__name__, h, abs(early - reference) / SPEED, (lost - work) / energy))
    return rows


def markdown(rows):
    lines = [
        "| scheme | H, s | error of the speed at 50 µs, of V0 | interface residual at the end, of KE0 |",
        "|---|---|---|---|",
    ]
    lines += [f"| {name} | {h:.0e} | {error:.1e} | {residual:+.1e} |" for name, h, error, residual in rows]
    return "\n".join(lines)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    print(markdown(table(sys.argv[1])))
