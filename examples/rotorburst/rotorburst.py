"""An engine-rotorburst fragment flies into a fabric shield: this program is the host, the shield is an FMU.

    python rotorburst.py --fmu ../../target/fmu/FabricShield-fmi2.fmu --out results

Far from the sheet the host flies the fragment alone, in large steps. Close to it both go on in communication steps of 1e-6 s: the
FMU first, with the fragment's motion at the start of the step; then the host, with the mean force and torque that the FMU
measured.
Writes history.csv and results.json.
"""

import argparse
import csv
import json
import math
import pathlib
import time

import balances
import numpy as np
from fragment import Body, DiscSector, Fragment
from shield import ATTACHMENTS, DISC_SECTOR, MOTION, Shield, motions, parameter_set

# The sheet and the fragment that strikes it: width of the sheet in inches, its usual attachment, the fragment. A third of a small
# turbine disc (drag of a cube: S. F. Hoerner, Fluid-Dynamic Drag, 1965) on a sheet of 10 in of Zylon, the same at half the size
# on one of 3 in, the paper's two sheets with its projectiles, and three separate plies of the 3 in sheet; first of all the ring
# of 40 in with the sector of 10 in.
CASES = {
    "ring": (40, "free", DiscSector(0.015, 0.04, 2.0 * math.pi / 3.0, 0.01, 0.118, 1.05)),
    "disc": (10, "four_sides", DiscSector(0.015, 0.04, 2.0 * math.pi / 3.0, 0.01, 0.118, 1.05)),
    "small": (3, "four_sides", DiscSector(0.0075, 0.02, 2.0 * math.pi / 3.0, 0.005, 0.01475, 1.05)),
    "10in": (10, "two_sides", Body("cylinder", 6.35e-3, 38.1e-3, 0.037, 0.9)),
    "3in": (3, "four_sides", Body("sphere", 6.35e-3, 12.7e-3, 0.0084, 0.47)),
    "plies": (3, "four_sides", Body("sphere", 6.35e-3, 12.7e-3, 0.0084, 0.47)),
}
SECTOR = ["inner_radius", "outer_radius", "angle", "thickness"]
NODES = {40: (1155, 88), 10: (350, 350), 3: (105, 105)}
PRESETS = {40: "ring_40in", 10: "sheet_10in_cylinder", 3: "sheet_3in_sphere"}
# parameter set of a real fabric, and the cases of it; the others have the paper's yarn
ZYLON, REAL = "zylon_as_500_35", ["disc", "small"]
RING = parameter_set("ring_40in")["sheet.radius"]  # m
ENDS = ["arrested", "exited", "passed", "rebounded"]  # outcomes that end the run
NEAR = 0.5e-3  # distance from the face of the sheet at which the FMU joins in, m
FLIGHT_STEP = 1e-4  # largest step of the host alone, s
INTERNAL_STEPS = {40: 1e-7, 10: 2e-8, 3: 2e-8}  # the FMU's time steps, s
REAL_STEP = 3.125e-8  # the same with Zylon, which is less stiff
MOST_STATES = 24  # saved of the shield in memory


class States:
    """States of the shield on the way; where there are too many, every second one is given up."""

    def __init__(self, shield):
        self.shield, self.kept, self.every = shield, [], 1

    def look(self, k, t):
        """After communication step k."""
        if k % self.every == 0:
            self.kept.append((t, self.shield.save()))
        if len(self.kept) > MOST_STATES:
            for _, state in self.kept[1::2]:
                self.shield.fmu.freeFMUstate(state)
            del self.kept[1::2]
            self.every *= 2

    def write(self, folder, times):
        """Files of the states nearest to these times and of the present one; their times."""
        chosen = sorted({min(self.kept, key=lambda kept: abs(kept[0] - time))[0] for time in times[:-1]} - {times[-1]})
        states = [*(dict(self.kept)[time] for time in chosen), self.shield.save()]
        for k, state in enumerate(states):
            (folder / f"state-{k}.bin").write_bytes(self.shield.fmu.serializeFMUstate(state))
        return [*chosen, times[-1]]


def fly(fragment, near, ledger, rows):
    """Flies the fragment to the distance `near` from the middle of the sheet, without the FMU. Returns the time."""
    t = 0.0
    rows.append(row(t, fragment))
    while fragment.front() < -near:
        if fragment.velocity[2] <= 0.0:
            raise SystemExit("the fragment never reaches the sheet")
        h = min(FLIGHT_STEP, (-near - fragment.front()) / fragment.closing() + 1e-7)
        force = fragment.own_force()
        ledger.own_work += own_step(fragment, h, force)
        ledger.own_impulse += force * h
        t += h
        rows.append(row(t, fragment))
    return t


def own_step(fragment, h, own, *from_shield):
    """One step of the host. Returns the work of the fragment's own forces: force times mean velocity is exact here."""
    before = fragment.velocity
    fragment.step(h, own, *from_shield)
    return h * own @ (0.5 * (before + fragment.velocity))


def couple(fragment, shield, ledger, rows, start, step, tick, limit, name):
    """Flies fragment and shield together until the fragment has stopped or left. Returns what was watched on the way, the outputs
    and the states."""
    seen = {"first_contact": -1.0, "end": "time limit"}
    past = 2.0 * fragment.reach()
    mean_force, shown, states = np.zeros(3), 0.0, States(shield)
    for k in range(round(limit / step)):
        own = fragment.own_force()
        shield.step(start + k * step, step, fragment, (mean_force + own) / fragment.body.mass)
        outputs = shield.outputs()
        mean_force = outputs["contact.force_mean"]
        torque = outputs["contact.torque_mean"]
        ledger.own_work += own_step(fragment, step, own, mean_force, torque, tick)
        ledger.own_impulse += own * step
        t = start + (k + 1) * step
        rows.append(row(t, fragment, outputs))
        states.look(k, t)
        if outputs["outcome.detached"] and "detached" not in seen:
            seen["detached"] = {"time": outputs["outcome.detached_time"], "absorbed": outputs["contact.work"]}
        ended = [name for name in ENDS if outputs[f"outcome.{name}"]]
        done = 1.0 if ended else max((k + 1) * step / limit, min(fragment.front() / past, 0.99))
        if done >= shown:
            text = f"{1e6 * (t - start):4.0f} us, {fragment.velocity[2]:6.2f} m/s, {outputs['fabric.failed_segments']:.0f} failed"
            print(f"{name}: {100 * done:3.0f} %, {text}", flush=True)
            shown = done // 0.05 * 0.05 + 0.05
        if ended:
            seen["end"] = ended[0]
            break
    seen["end_time"] = t
    if outputs["outcome.first_contact"]:
        seen["first_contact"] = outputs["outcome.first_contact_time"]
    seen["steps"] = k + 1
    return seen, outputs, states


def row(t, fragment, outputs=None):
    """One line of history.csv."""
    line = {"time": t, "kinetic_energy": fragment.kinetic_energy()}
    for name, value in {**dict(zip(MOTION, motions(fragment))), **(outputs or {})}.items():
        if np.ndim(value):
            line.update({f"{name}[{k + 1}]": x for k, x in enumerate(value)})
        else:
            line[name] = value
    return line


def write_history(path, rows):
    """Before the FMU joins in, its columns are 0."""
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[-1]), restval=0)
        writer.writeheader()
        writer.writerows(rows)


def scene_of(arguments, width, body):
    """The shield's parameters, as far as they are not its start values."""
    name = {"plies": "three_plies", "ring": "ring_40in"}.get(arguments.case, "sheet_3in_sphere")
    parameters = {} if width == 10 else parameter_set(name)
    if arguments.case in REAL:
        parameters |= parameter_set(ZYLON)
    if isinstance(body, DiscSector):
        sizes = {name: getattr(body, name) for name in SECTOR}
        parameters |= {"projectile.shape": DISC_SECTOR, **{f"projectile.sector.{name}": value for name, value in sizes.items()}}
    return parameters | {
        "attachment.kind": ATTACHMENTS[arguments.attachment],
        "seed": arguments.seed,
        "sheet.plies": arguments.plies,
        "time_step.seconds": REAL_STEP if arguments.case in REAL else INTERNAL_STEPS[width],
        "projectile.mass": body.mass,
        "capsule": arguments.capsule,
    }


def impact_of(arguments, parameters, fragment):
    """The shield's parameters as a scene of `fabric_kernel`: its preset and fabric, and what differs from these."""
    width, _, body = CASES[arguments.case]
    changes = {
        name: parameters[name]
        for name in ("seed", "sheet.plies", "time_step.seconds", "stack.plies", "stack.gap")
        if name in parameters
    }
    changes |= {"attachment.kind": arguments.attachment, "drive": "prescribed"}
    changes |= {f"projectile.{name}": value.tolist() for name, value in zip(MOTION, motions(fragment))}
    if isinstance(body, DiscSector):
        changes |= {"projectile.shape": "disc_sector", "projectile.mass": body.mass}
        changes |= {f"projectile.sector.{name}": getattr(body, name) for name in SECTOR}
    return PRESETS[width], ZYLON if arguments.case in REAL else None, changes


def picture_times(rows, start, seen):
    """Times that show the event: on the way to the greatest load, at its end, and at the end of the run."""
    coupled = [line for line in rows if "contact.work" in line]
    greatest = max(line["contact.work"] for line in coupled)
    loaded = next(line["time"] for line in coupled if line["contact.work"] >= 0.99 * greatest)
    contact = max(seen["first_contact"], start)
    return [contact + part * (loaded - contact) for part in (0.25, 0.6, 1.0)] + [seen["end_time"]]


def parsed():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmu", required=True, help="FabricShield-fmi2.fmu")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("results"), help="folder of the results")
    parser.add_argument("--case", choices=CASES, default="ring", help="sheet and fragment (default: %(default)s)")
    parser.add_argument(
        "--attachment", choices=ATTACHMENTS, help="how the sheet is held (default: four sides; the paper's sheets as there)"
    )
    parser.add_argument("--plies", type=int, help="plies bonded into one network, sheet.plies (default: 1; of the ring 5)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the yarns' scatter (default: %(default)s)")
    parser.add_argument("--speed", type=float, default=100.0, help="speed at the stand-off, m/s (default: %(default)s)")
    parser.add_argument("--standoff", type=float, default=0.3, help="distance flown before the sheet, m (default: %(default)s)")
    parser.add_argument(
        "--spin",
        type=float,
        default=300.0,
        help="spin about the axis, rad/s; in the ring that of the disc (default: %(default)s)",
    )
    parser.add_argument(
        "--tilt", type=float, default=0.0, help="angle of the axis to the flight path, degrees (default: %(default)s)"
    )
    parser.add_argument(
        "--angle",
        type=float,
        default=0.0,
        help="of the path in the ring to the plane of rotation, degrees (default: %(default)s)",
    )
    parser.add_argument("--step", type=float, default=1e-6, help="communication step, s; at most 1e-5 (default: %(default)s)")
    parser.add_argument(
        "--limit", type=float, default=2e-3, help="end of the coupled run at the latest, s (default: %(default)s)"
    )
    parser.add_argument("--capsule", action="store_true", help="also print the FMU's capsule, which `fabric replay` does again")
    arguments = parser.parse_args()
    arguments.attachment = arguments.attachment or CASES[arguments.case][1]
    arguments.plies = arguments.plies or (5 if arguments.case == "ring" else 1)
    return arguments


def main():
    arguments = parsed()
    arguments.out.mkdir(parents=True, exist_ok=True)
    width, _, body = CASES[arguments.case]
    (nx, ny), is_ring = NODES[width], arguments.case == "ring"
    if is_ring:
        fragment = Fragment.burst(body, RING, arguments.standoff, arguments.speed, math.radians(arguments.angle))
    else:
        fragment = Fragment.launched(body, arguments.standoff, arguments.speed, arguments.spin, np.radians(arguments.tilt))
    parameters = scene_of(arguments, width, body)
    plies, tick = parameters.get("stack.plies", 1), parameters["time_step.seconds"]
    began = time.perf_counter()
    ledger, rows = balances.Ledger(fragment), []
    half_thickness = 0.5 * arguments.plies * parameters.get("sheet.thickness", 0.0)
    start = fly(fragment, NEAR + half_thickness, ledger, rows)
    impact = impact_of(arguments, parameters, fragment)
    impact_energy, impact_speed = fragment.kinetic_energy(), float(np.linalg.norm(fragment.velocity))
    shield = Shield(arguments.fmu, parameters, start, fragment)
    name = balances.plies_of(arguments.plies, plies)
    seen, outputs, states = couple(fragment, shield, ledger, rows, start, arguments.step, tick, arguments.limit, name)
    wall = time.perf_counter() - began
    pictures = states.write(arguments.out, picture_times(rows, start, seen))
    shield.close()

    write_history(arguments.out / "history.csv", rows)
    results = {
        "options": {name: value for name, value in vars(arguments).items() if name not in ("fmu", "out")},
        "nodes": [nx, ny],
        "plies": plies,
        "segments": ((nx if is_ring else nx - 1) * ny + nx * (ny - 1)) * plies,
        "body": vars(body),
        "scene": impact,
        "pictures": pictures,
        "start": start,
        "impact_speed": impact_speed,
        "impact_energy": impact_energy,
        "internal_steps": round(seen["steps"] * arguments.step / tick),
        "velocity": fragment.velocity.tolist(),
        "angular_velocity": fragment.angular_velocity().tolist(),
        **seen,
        "wall_time": wall,
        "outputs": {name: value.tolist() if np.ndim(value) else value for name, value in outputs.items()},
        "balances": ledger.close(fragment, outputs, impact_energy),
    }
    (arguments.out / "results.json").write_text(json.dumps(results, indent=1))
    balances.print_results(results)


if __name__ == "__main__":
    main()
