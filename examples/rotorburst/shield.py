"""The fabric shield as an FMU (FMI 2.0, drive prescribed), through FMPy's low-level interface."""

import shutil
import tempfile

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.ssd import read_ssv

PRESCRIBED = 1
DISC_SECTOR = 5
ATTACHMENTS = {"two_sides": 0, "four_sides": 1, "four_corners": 2, "free": 3}

MOTION = ["position", "velocity", "orientation", "angular_velocity"]
INPUTS = [f"projectile.{name}" for name in [*MOTION, "acceleration"]]
REAL_OUTPUTS = [
    "contact.force_mean", "contact.torque_mean", "contact.force_peak", "contact.impulse", "contact.angular_impulse",
    "contact.work", "support.impulse", "support.attachment_impulse", "energy.kinetic", "energy.strain",
    "energy.dissipated", "energy.viscous", "energy.contact_loss", "energy.casing_loss", "energy.residual", "momentum.residual", "fabric.max_deflection",
    "fabric.max_stretch", "fabric.failed_segments", "contact.unconverged", "ply.failed_segments", "ply.kinetic",
    "ply.strain", "ply.dissipated", "outcome.first_contact_time", "outcome.detached_time",
]  # fmt: skip
# Each stays true once it has happened; it has its time beside it.
BOOLEAN_OUTPUTS = [f"outcome.{name}" for name in ("first_contact", "arrested", "detached", "exited", "passed")]


def read_parameters(path):
    """The numbers of a parameter set (.ssv) by name."""
    kinds = {"Real": float, "Integer": int, "Boolean": "true".__eq__}
    return {parameter.name: kinds[parameter.type](parameter.value) for parameter in read_ssv(str(path)).parameters}


class Shield:
    """One instance of the FMU. Parameters go in by name; one call sets all inputs, one gets all outputs."""

    def __init__(self, archive, parameters):
        description = fmpy.read_model_description(archive)
        self._folder = fmpy.extract(archive, tempfile.mkdtemp(prefix="fabric-shield-"))
        self._variables = {variable.name: variable for variable in description.modelVariables}
        self._inputs = self._references(INPUTS)
        self._reals = self._references(REAL_OUTPUTS)
        self._booleans = self._references(BOOLEAN_OUTPUTS)
        self._start = self._references([f"projectile.start.{name}" for name in MOTION])
        self._fmu = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=self._folder,
            instanceName="shield",
        )
        self._fmu.instantiate()
        setters = {"Real": self._fmu.setReal, "Boolean": self._fmu.setBoolean}
        for name, value in {"drive": PRESCRIBED, **parameters}.items():
            variable = self._variables[name]
            setters.get(variable.type, self._fmu.setInteger)([variable.valueReference], [value])

    def initialise(self, t, fragment):
        """Builds the sheet, with the fragment where it is now, at time t."""
        self._fmu.setReal(self._start, np.concatenate(motions(fragment)))
        self._fmu.setupExperiment(startTime=t)
        self._fmu.enterInitializationMode()
        self._fmu.exitInitializationMode()

    def step(self, t, h, fragment, acceleration):
        """One communication step: what the fragment does to the sheet, and the sheet to the fragment, from t to t + h.

        `acceleration` is the host's guess of the fragment's acceleration over this step.
        """
        self._fmu.setReal(self._inputs, np.concatenate([*motions(fragment), acceleration]))
        self._fmu.doStep(t, h)

    def outputs(self):
        """Every output by name: a number, 0 or 1 for a truth value, or an array for a vector."""
        values = list(self._fmu.getReal(self._reals)) + list(self._fmu.getBoolean(self._booleans))
        result = {}
        for name in REAL_OUTPUTS + BOOLEAN_OUTPUTS:
            size = len(self._elements(name))
            result[name] = values[0] if size == 1 else np.array(values[:size])
            values = values[size:]
        return result

    def close(self):
        """Ends the simulation and frees the instance."""
        self._fmu.terminate()
        self._fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _elements(self, name):
        """FMI 2.0 has no arrays: the elements of `name` are `name[1]`, `name[2]`, ..., or `name[1,1]`, `name[1,2]`, ..."""
        if name in self._variables:
            return [self._variables[name]]
        return [variable for key, variable in self._variables.items() if key.startswith(name + "[")]

    def _references(self, names):
        return [variable.valueReference for name in names for variable in self._elements(name)]


def motions(fragment):
    """Its vectors in the order of MOTION."""
    return [fragment.position, fragment.velocity, fragment.orientation, fragment.angular_velocity()]
