"""The balances between host and shield: what the fragment lost, the shield must have got; and the table of results."""

import numpy as np

INTERFACE = "Interface, energy: loss of the fragment | contact.work"
SHIELD = "Shield, energy: contact.work | kinetic + strain + dissipated + viscous + lost in contact and on the case"
PARTS = ["kinetic", "strain", "dissipated", "viscous", "contact_loss", "casing_loss"]


class Ledger:
    """Sums of the fragment's own forces (gravity, drag), and the fragment as it was at the start."""

    def __init__(self, fragment):
        self.momentum = fragment.momentum()
        self.angular_momentum = fragment.angular_momentum.copy()
        self.energy = fragment.kinetic_energy()
        self.own_impulse = np.zeros(3)  # N s
        self.own_work = 0.0  # J

    def close(self, fragment, outputs, impact_energy):
        """The balances: for each what one side says, what the other says, the difference and the quantity it is measured by."""
        given = fragment.momentum() - self.momentum - self.own_impulse
        turned = fragment.angular_momentum - self.angular_momentum
        lost = self.energy - fragment.kinetic_energy() + self.own_work
        impulse, angular = outputs["contact.impulse"], outputs["contact.angular_impulse"]
        work = outputs["contact.work"]
        held = sum(outputs[f"energy.{part}"] for part in PARTS)
        size = np.linalg.norm

        def entry(unit, ours, theirs, difference, scale, scale_name):
            relative = float(difference / scale) if scale > 0.0 else 0.0
            return {
                "unit": unit,
                "ours": float(ours),
                "theirs": float(theirs),
                "difference": float(difference),
                "relative": relative,
                "scale": scale_name,
            }

        return {
            "Interface, momentum: change of the fragment's | contact.impulse": entry(
                "N s", size(given), size(impulse), size(given - impulse), size(impulse), "impulse"
            ),
            "Interface, angular momentum: change of the fragment's | contact.angular_impulse": entry(
                "N m s", size(turned), size(angular), size(turned - angular), size(angular), "angular impulse"
            ),
            INTERFACE: entry("J", lost, work, lost - work, impact_energy, "energy at impact"),
            SHIELD: entry("J", work, held, outputs["energy.residual"], impact_energy, "energy at impact"),
            "Shield, momentum: contact.impulse | fabric + supports (difference: momentum.residual)": entry(
                "N s",
                size(impulse),
                size(impulse) - outputs["momentum.residual"],
                outputs["momentum.residual"],
                size(impulse),
                "impulse",
            ),
        }


def went_through(results):
    """Whether the fragment left the sheet behind."""
    return results["end"] in ("exited", "passed")


def plies_of(bonded, separate):
    """How many plies, and how they are connected."""
    if separate > 1:
        return f"{separate} separate plies" + (f" of {bonded} bonded ones each" if bonded > 1 else "")
    return f"{bonded} bonded plies" if bonded > 1 else "1 ply"


def answer(results):
    """The answer of a run: stopped or not, the residual velocity, the absorbed energy."""
    through, stopped, detached = went_through(results), results["end"] in ("arrested", "rebounded"), results.get("detached")
    verdict = "went through" if through else "stopped" if stopped else "not decided when the time was over"
    absorbed = detached["absorbed"] if through and detached else results["outputs"]["contact.work"]
    lines = [
        f"{plies_of(results['options']['plies'], results['plies'])}: {verdict}",
        f"Residual velocity along the flight: {0.0 if stopped else results['velocity'][2]:.1f} m/s of "
        f"{results['impact_speed']:.1f} m/s.",
        f"Absorbed energy: {absorbed:.1f} J of {results['impact_energy']:.1f} J.",
    ]
    if stopped:
        sideways, spin = np.hypot(*results["velocity"][:2]), np.linalg.norm(results["angular_velocity"])
        lines += [
            f"Largest deflection of the sheet: {1e3 * results['outputs']['fabric.max_deflection']:.1f} mm.",
            f"Left in the fragment as it turns back: {sideways:.0f} m/s sideways and {spin:.0f} rad/s of spin.",
        ]
    else:
        lines.append(f"Failed yarn segments: {results['outputs']['fabric.failed_segments']:.0f} of {results['segments']}.")
    if results["options"]["plies"] > 1:
        lines.append("The plies are one network (sheet.plies): none of them moves apart from the others.")
    return lines


def result_rows(results):
    """The results as (name, value) in words, for the terminal and the report."""
    outputs, energy, contact = results["outputs"], results["impact_energy"], results["first_contact"]

    def since(t):
        return f"{1e6 * (t - contact):.0f} us after first contact" if contact >= 0.0 else "no contact"

    absorbed = outputs["contact.work"]
    end = results["end"] + (": after perforation" if went_through(results) else "")
    detached = results.get("detached")
    rows = [
        ("Speed at the sheet", f"{results['impact_speed']:.3f} m/s ({energy:.2f} J)"),
        ("First contact", f"{1e3 * contact:.4f} ms after launch" if contact >= 0.0 else "none"),
        ("End of the run", f"{results['end']}, {since(results['end_time'])}"),
        ("Residual velocity (z)", f"{results['velocity'][2]:.3f} m/s"),
        (
            "Absorbed energy at detachment",
            f"{detached['absorbed']:.3f} J, {since(detached['time'])}" if detached else "not detached before the end of the run",
        ),
        (f"Absorbed energy at the end ({end})", f"{absorbed:.3f} J = {100.0 * absorbed / energy:.1f} %"),
        ("Peak force (mean over 1 us)", f"{1e-3 * outputs['contact.force_peak']:.2f} kN"),
        ("Failed segments", f"{outputs['fabric.failed_segments']:.0f} of {results['segments']}"),
        ("Largest deflection of what is still held", f"{1e3 * outputs['fabric.max_deflection']:.1f} mm"),
        ("Angular velocity at the end", vector(results["angular_velocity"], "rad/s", 1)),
        ("Impulse on the supports", vector(outputs["support.impulse"], "N s", 4)),
        (
            "Energies of the shield",
            ", ".join(f"{part.replace('_', ' ')} {outputs[f'energy.{part}']:.2f}" for part in PARTS) + " J",
        ),
    ]
    names = attachment_names(results["options"]["attachment"])
    each = np.reshape(outputs["support.attachment_impulse"], (-1, 3))
    rows += [(f"Impulse on {name}", vector(impulse, "N s", 4)) for name, impulse in zip(names, each)]
    steps, wall = results["internal_steps"], results["wall_time"]
    cost = 1e9 * wall / (steps * np.prod(results["nodes"]))
    for name, key in [("Interface residual", INTERFACE), ("Energy residual of the shield", SHIELD)]:
        entry = results["balances"][key]
        rows.append((name, f"{entry['difference']:.2e} J = {100.0 * entry['relative']:.1g} % of the energy at impact"))
    rows += [
        ("Steps", f"{results['steps']} communication steps, {steps} internal steps"),
        ("Wall time", f"{wall:.1f} s ({cost:.1f} ns per node and internal step, all read-outs included)"),
    ]
    return rows


def attachment_names(kind):
    """In the order of support.attachment_impulse."""
    if kind == "four_corners":
        return ["corner -x -y", "corner +x -y", "corner -x +y", "corner +x +y"]
    if kind == "free":
        return []
    sides = ["left side (-x)", "right side (+x)", "bottom side (-y)", "top side (+y)"]
    return sides[: 2 if kind == "two_sides" else 4]


def vector(values, unit, digits):
    """(x, y, z) unit, without minus signs before zeros."""
    return "(" + ", ".join(f"{round(x, digits) + 0.0:.{digits}f}" for x in values) + f") {unit}"


def print_results(results):
    """The answer and the table that end a run, at once: another run may print beside it."""
    rows = result_rows(results)
    width = max(len(name) for name, _ in rows)
    lines = answer(results)
    lines = [f"\n{lines[0]}. {' '.join(lines[1:])}", *(f"  {name:<{width}}  {value}" for name, value in rows)]
    lines += [
        "Balances between host and shield",
        f"  {'one side':>12} {'other side':>12} {'difference':>11} {'relative':>9}  unit   balance",
    ]
    for name, entry in results["balances"].items():
        lines.append(
            f"  {entry['ours']:12.6g} {entry['theirs']:12.6g} {entry['difference']:11.2e} {entry['relative']:9.1e}  "
            f"{entry['unit']:<5}  {name}"
        )
    print("\n".join(lines), flush=True)
