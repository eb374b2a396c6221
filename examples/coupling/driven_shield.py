"""One fabric shield: an instance of the FMU (FMI 2.0, drive prescribed) behind names, through FMPy's low-level interface."""

import pathlib
import shutil
import tempfile

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.ssd import read_ssv

FREE, PRESCRIBED = range(2)


def parameter_set(name):
    """The values of a parameter set of the examples, e.g. sheet_3in_sphere."""
    file = pathlib.Path(__file__).parents[1] / "parameters" / f"{name}.ssv"
    read = {"Real": float, "Integer": int, "Boolean": "true".__eq__}
    return {parameter.name: read[parameter.type](parameter.value) for parameter in read_ssv(str(file)).parameters}


class Shield:
    """Variables are read and set by name; a vector is a list, or what can be made one."""

    def __init__(self, archive, parameters, start=0.0):
        description = fmpy.read_model_description(str(archive))
        self._folder = tempfile.mkdtemp(prefix="fabric-shield-")
        fmpy.extract(str(archive), self._folder)
        self._variables = {variable.name: variable for variable in description.modelVariables}
        self._elements = {}
        self.fmu = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=self._folder,
            instanceName="shield",
        )
        self.fmu.instantiate()
        for name, value in parameters.items():
            self.set(name, value)
        self.fmu.setupExperiment(startTime=start)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def _of(self, name):
        """Kind and value references. FMI 2.0 has no arrays: the elements of `name` are `name[1]`, `name[2]`, ..."""
        if name not in self._elements:
            found = [v for key, v in self._variables.items() if key == name or key.startswith(name + "[")]
            self._elements[name] = (found[0].type, [v.valueReference for v in found])
        return self._elements[name]

    def set(self, name, value):
        kind, references = self._of(name)
        setter = {"Real": self.fmu.setReal, "Boolean": self.fmu.setBoolean}.get(kind, self.fmu.setInteger)
        setter(references, list(value) if hasattr(value, "__len__") else [value])

    def get(self, name):
        kind, references = self._of(name)
        getter = {"Real": self.fmu.getReal, "Boolean": self.fmu.getBoolean}.get(kind, self.fmu.getInteger)
        values = list(getter(references))
        return values[0] if len(values) == 1 else values

    def step(self, t, h, body, acceleration=(0.0, 0.0, 0.0)):
        """From t to t + h with the body as it is at t; the mean force on it, N. A zero acceleration leaves the guess to the
        FMU."""
        self.set("projectile.position", body.position)
        self.set("projectile.velocity", body.velocity)
        self.set("projectile.acceleration", acceleration)
        self.fmu.doStep(t, h)
        return self.get("contact.force_mean")

    def save(self, state=None):
        """The present state; a state saved before is written over, which costs no memory."""
        if state is None:
            return self.fmu.getFMUstate()
        self.fmu.fmi2GetFMUstate(self.fmu.component, state)
        return state

    def restore(self, state):
        self.fmu.setFMUstate(state)

    def close(self):
        """Ends the simulation; saved states are freed with the instance."""
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)
