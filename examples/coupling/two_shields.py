"""One fragment, two shields in series: two instances of the FMU, each with its own place, tilt and plies.

    python two_shields.py ../../target/fmu/FabricShield-fmi2.fmu

Every step both shields get the fragment's motion, step, and the fragment moves under the sum of their mean forces. The second
sheet stands 5 cm behind the first, is tilted by 20 degrees and has two plies. `projectile.mass` is 0, "not known": a shield could
only compare its own work with the whole loss of the fragment, so the host sums them itself.
"""

import math
import sys

from driven_shield import PRESCRIBED, Shield, parameter_set
from sphere import MASS, RADIUS, Body

SPEED = 250.0  # m/s
H = 5e-7  # s
END = 6e-4  # s
TILT = math.radians(20.0)
SHEETS = [
    {"sheet.position": [0.0, 0.0, 0.0]},
    {
        "sheet.position": [0.0, 0.0, 0.05],
        "sheet.orientation": [math.cos(TILT / 2), math.sin(TILT / 2), 0.0, 0.0],
        "sheet.plies": 2,
    },
]


def fly(archive, sheets=SHEETS, speed=SPEED, h=H, end=END):
    """The balances after the flight: a dictionary of numbers, and one of lists with an entry per shield."""
    body = Body([0.0, 0.0, -RADIUS - 1e-4], [0.0, 0.0, speed])
    common = {
        **parameter_set("sheet_3in_sphere"),
        "drive": PRESCRIBED,
        "projectile.mass": 0.0,
        "projectile.start.position": body.position,
        "projectile.start.velocity": body.velocity,
    }
    shields = [Shield(archive, {**common, **sheet}) for sheet in sheets]
    dt, energy, force = shields[0].get("time_step.seconds"), body.kinetic_energy(), [0.0] * 3
    for k in range(round(end / h)):
        expected = [f / MASS for f in force]  # the last sum of forces; a shield by itself knows only its own
        forces = [shield.step(k * h, h, body, expected) for shield in shields]
        force = [sum(parts) for parts in zip(*forces)]
        body.pushed(force, h, dt)
        if all(any(shield.get(f"outcome.{end}") for end in ("arrested", "exited", "passed", "rebounded")) for shield in shields):
            break
    names = (
        "outcome.exited outcome.first_contact_time outcome.exited_time contact.work contact.impulse contact.force_peak"
    ).split()
    balances = {name: [shield.get(name) for shield in shields] for name in [*names, "fabric.failed_segments"]}
    balances["velocity"] = body.velocity
    balances["lost"] = energy - body.kinetic_energy()
    balances["interface residual"] = (balances["lost"] - sum(balances["contact.work"])) / energy
    change = [MASS * (v - v0) for v, v0 in zip(body.velocity, [0.0, 0.0, speed])]
    impulse = [sum(parts) for parts in zip(*balances["contact.impulse"])]
    balances["momentum residual"] = max(abs(a - b) for a, b in zip(change, impulse)) / (MASS * speed)
    for shield in shields:
        shield.close()
    return balances


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    for name, value in fly(sys.argv[1]).items():
        print(f"{name:24} {value}")
