"""The fabric shield as an FMU: that of examples/coupling, with the fragment's rotation and all that the report shows."""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "coupling"))

import driven_shield

parameter_set = driven_shield.parameter_set
DISC_SECTOR = 5
ATTACHMENTS = {"two_sides": 0, "four_sides": 1, "four_corners": 2, "free": 3}

MOTION = ["position", "velocity", "orientation", "angular_velocity"]
# Each outcome stays true once it has happened; it has its time beside it.
OUTPUTS = [
    "contact.force_mean",
    "contact.torque_mean",
    "contact.force_peak",
    "contact.impulse",
    "contact.angular_impulse",
    "contact.work",
    "support.impulse",
    "support.attachment_impulse",
    "energy.kinetic",
    "energy.strain",
    "energy.dissipated",
    "energy.viscous",
    "energy.contact_loss",
    "energy.casing_loss",
    "energy.residual",
    "momentum.residual",
    "fabric.max_deflection",
    "fabric.max_stretch",
    "fabric.failed_segments",
    "contact.unconverged",
    "ply.failed_segments",
    "ply.kinetic",
    "ply.strain",
    "ply.dissipated",
    "outcome.first_contact_time",
    "outcome.detached_time",
    *(f"outcome.{name}" for name in ("first_contact", "arrested", "detached", "exited", "passed", "rebounded")),
]


class Shield(driven_shield.Shield):
    """The sheet of some parameters, built at time t with the fragment where it is."""

    def __init__(self, archive, parameters, t, fragment):
        start = {f"projectile.start.{name}": value for name, value in zip(MOTION, motions(fragment))}
        super().__init__(archive, {**parameters, **start, "drive": driven_shield.PRESCRIBED}, t)

    def step(self, t, h, fragment, acceleration):
        """One communication step: what the fragment does to the sheet, and the sheet to the fragment, from t to t + h.

        `acceleration` is the host's guess of the fragment's acceleration over this step.
        """
        self.set("projectile.orientation", fragment.orientation)
        self.set("projectile.angular_velocity", fragment.angular_velocity())
        super().step(t, h, fragment, acceleration)

    def outputs(self):
        """Every output by name: a number, 0 or 1 for a truth value, or an array for a vector."""
        found = {name: self.get(name) for name in OUTPUTS}
        return {name: np.array(value) if isinstance(value, list) else value for name, value in found.items()}


def motions(fragment):
    """Vectors of the fragment in the order of MOTION."""
    return [fragment.position, fragment.velocity, fragment.orientation, fragment.angular_velocity()]
