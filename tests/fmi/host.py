"""A host for the tests: one way to drive both FMUs through FMPy's low-level classes, by variable names.

A call that the FMU refuses does not raise: it returns the status, and what the FMU said is in `log`.
"""

import atexit
import ctypes
import math
import os
import pathlib
import shutil
import sys
import tempfile
import weakref
from xml.etree import ElementTree

import fmpy
from component import FILE, Slave
from fmpy import fmi2, fmi3
from fmpy.fmi1 import FMICallException

OK, WARNING, DISCARD, ERROR = range(4)
PRESCRIBED = 1
TWO_SIDES, FOUR_SIDES, FOUR_CORNERS, FREE = range(4)
RADIUS = 6.35e-3
TOP = pathlib.Path(__file__).parents[2]
EXAMPLES = TOP / "examples"

TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", TOP / "target"))
ARCHIVES = {version: TARGET / "fmu" / f"FabricShield-fmi{version}.fmu" for version in (2, 3)}
sys.path.insert(0, str(EXAMPLES / "coupling"))

from driven_shield import parameter_set  # noqa: E402

# The 3 in sheet and the sphere, 1 mm before it.
SPHERE = parameter_set("sheet_3in_sphere")
# A small sheet under the sphere, which starts a hundredth of a millimetre before it.
SMALL = {**SPHERE, "sheet.nodes_x": 41, "sheet.nodes_y": 41, "projectile.start.position[3]": -RADIUS - 1e-5}

# What the two versions must agree on bit by bit.
OUTPUTS = [
    variable.get("name")
    for variable in ElementTree.parse(TOP / "modelDescription" / "fmi3.xml").iter()
    if variable.get("causality") == "output"
]

# FMPy's own logger keeps one receiver for all instances. The FMU always passes "%s" and one text, so this receives it; on Linux
# a variadic argument travels like any other.
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p)

_opened = {}
_filled = {}


def opened(version, archive=None):
    """Model description and folder of an archive, which is unpacked once; FabricShield's if none is named."""
    archive = str(archive or ARCHIVES[version])
    if archive not in _opened:
        folder = tempfile.mkdtemp(prefix="fabric-fmu-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        fmpy.extract(archive, folder)
        _opened[archive] = (fmpy.read_model_description(archive), folder)
    return _opened[archive]


def filled(version, scene, name):
    """The archive of a scene, as `fabric fmu` makes it of FabricShield's."""
    from fabric_kernel import fmu

    if (version, name) not in _filled:
        folder = tempfile.mkdtemp(prefix="fabric-fmu-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        _filled[version, name] = pathlib.Path(folder, f"{name}.fmu")
        _filled[version, name].write_bytes(fmu.filled(ARCHIVES[version], scene, name)[1])
    return _filled[version, name]


def library(version):
    """The binary in an archive that this machine runs."""
    name = fmpy.platform if version == 2 and fmpy.platform_tuple == "x86_64-linux" else fmpy.platform_tuple
    return pathlib.Path(opened(version)[1], "binaries", name, "FabricShield.so")


def size_of(variable):
    """How many numbers it holds."""
    return math.prod(int(dimension.start) for dimension in variable.dimensions or ())


def freed(fmu, version, _logger):
    """Frees an instance, with the logger that it may call till then."""
    getattr(fmu, f"fmi{version}FreeInstance")(fmu.component)


class Host:
    """One instance, freed with this object. With `values` it is initialised at once and must accept them."""

    def __init__(
        self,
        version,
        values=None,
        start=0.0,
        stop=None,
        token=None,
        events=False,
        early=None,
        logging_on=True,
        archive=None,
        component=False,
        log=None,
    ):
        log = self.log = [] if log is None else log
        say = lambda _environment, status, category, message: log.append((status, category.decode(), message.decode()))
        self.version = version
        description, folder = opened(version, archive)
        self.variables = {variable.name: variable for variable in description.modelVariables}
        arguments = dict(
            guid=token or (description.guid if version == 2 else description.instantiationToken),
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=folder,
            instanceName="test",
        )
        self.events = events
        if version == 2:
            self.fmu = fmi2.FMU2Slave(**arguments)
            callbacks = fmi2.fmi2CallbackFunctions()
            self.logger = LOGGER(
                lambda environment, _name, status, category, _format, message: say(environment, status, category, message)
            )
            callbacks.logger = ctypes.cast(self.logger, fmi2.fmi2CallbackLoggerTYPE)
            callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmi2.calloc)
            callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmi2.free)
            self.fmu.instantiate(callbacks=callbacks, loggingOn=logging_on)
        elif component:
            # This FMU in WebAssembly.
            self.fmu = Slave(pathlib.Path(folder, FILE.format(description.modelName)), say)
            self.fmu.instantiate(arguments["guid"], logging_on, events, events if early is None else early)
        else:
            self.fmu = fmi3.FMU3Slave(**arguments)
            self.fmu.instantiate(
                logMessage=say, loggingOn=logging_on, eventModeUsed=events, earlyReturnAllowed=events if early is None else early
            )
        weakref.finalize(self, freed, self.fmu, version, getattr(self, "logger", None))
        if values is not None:
            status = self.initialise(values, start, stop)
            assert status <= WARNING, (status, self.log)

    def attempt(self, function, *arguments, **named):
        """Status of a call."""
        try:
            function(*arguments, **named)
        except FMICallException as refused:
            return refused.status
        return OK

    def said(self, text):
        """Whether the FMU has logged this."""
        return any(text in message for _, _, message in self.log)

    def initialise(self, values, start=0.0, stop=None):
        status = self.begin(values, start, stop)
        if status > WARNING:
            return status
        status = self.attempt(self.fmu.exitInitializationMode)
        if status <= WARNING and self.events:
            self.fmu.enterStepMode()
        return status

    def begin(self, values, start=0.0, stop=None):
        """Sets parameters and enters initialisation."""
        for name, value in self.whole(values).items():
            status = self.try_set(name, value)
            if status > WARNING:
                return status
        if self.version == 2:
            self.fmu.setupExperiment(startTime=start, stopTime=stop)
            return self.attempt(self.fmu.enterInitializationMode)
        return self.attempt(self.fmu.enterInitializationMode, startTime=start, stopTime=stop)

    def whole(self, values):
        """Values as for FMI 2.0, for FMI 3.0 with whole vectors instead of elements: `name[3]` in the start value of `name`."""
        if self.version == 2:
            return values
        found = {}
        for name, value in values.items():
            vector, _, place = name.partition("[")
            if place:
                start = found.setdefault(vector, [float(x) for x in self.variables[vector].start.split()])
                *row, column = [int(index) - 1 for index in place[:-1].split(",")]
                columns = int(self.variables[vector].dimensions[-1].start)
                start[sum(row) * columns + column] = value
            else:
                found[name] = value
        return found

    def _elements(self, name):
        if name in self.variables:
            return [self.variables[name]]
        return [v for v in self.variables.values() if v.name.startswith(name + "[")]

    def _function(self, verb, variables):
        """What sets or gets variables of one type."""
        kind = variables[0].type
        return getattr(self.fmu, verb + (kind if kind != "Enumeration" else "Integer" if self.version == 2 else "Int64"))

    def try_set(self, name, value):
        """Status of setting a variable, a list for arrays."""
        values = list(value) if isinstance(value, (list, tuple)) else [value]
        elements = self._elements(name)
        return self.attempt(self._function("set", elements), [v.valueReference for v in elements], values)

    def set(self, **values):
        for name, value in values.items():
            status = self.try_set(name.replace("__", "."), value)
            assert status <= WARNING, (name, self.log)

    def get(self, name):
        """A number, or the list of an array's elements row by row."""
        elements = self._elements(name)
        values = self.read(elements)
        values = [int(value) if elements[0].type == "Boolean" else value for value in values]
        return values[0] if len(values) == 1 else values

    def read(self, variables):
        """Values of variables of one type, one after the other. Raises if the FMU refuses."""
        count = {} if self.version == 2 else {"nValues": sum(map(size_of, variables))}
        return list(self._function("get", variables)([v.valueReference for v in variables], **count))

    def outputs(self):
        return {name: self.get(name) for name in OUTPUTS}

    def step(self, t, h):
        """Status of a step; for FMI 3.0 also (event, terminate, early, time) in `last`."""
        try:
            self.last = self.fmu.doStep(t, h)
        except FMICallException as refused:
            return refused.status
        return OK

    def status_of_step(self, t, h):
        """What the step function itself returns: FMPy takes a warning as success."""
        if self.version == 2:
            return self.fmu.dll.fmi2DoStep(ctypes.c_void_p(self.fmu.component), ctypes.c_double(t), ctypes.c_double(h), 1)
        flags = [ctypes.byref(ctypes.c_bool()) for _ in range(3)]
        return self.fmu.dll.fmi3DoStep(
            ctypes.c_void_p(self.fmu.component),
            ctypes.c_double(t),
            ctypes.c_double(h),
            ctypes.c_bool(True),
            *flags,
            ctypes.byref(ctypes.c_double()),
        )

    def run(self, first, end, h):
        """Steps number first to end - 1 of size h, from time first h on."""
        for k in range(first, end):
            status = self.step(k * h, h)
            assert status <= WARNING, (status, self.log)
        return self

    def save(self):
        return self.fmu.getFMUstate() if self.version == 2 else self.fmu.getFMUState()

    def restore(self, state):
        return self.attempt(self.fmu.setFMUstate if self.version == 2 else self.fmu.setFMUState, state)

    def free(self, state):
        return self.attempt(self.fmu.freeFMUstate if self.version == 2 else self.fmu.freeFMUState, state)

    def bytes_of(self, state):
        """The state as bytes."""
        return bytes(self.fmu.serializeFMUstate(state) if self.version == 2 else self.fmu.serializeFMUState(state))

    def state_of(self, data):
        return self.fmu.deSerializeFMUstate(data) if self.version == 2 else self.fmu.deserializeFMUState(data)

    def image(self):
        """The present state as bytes: equal bytes mean equal bits everywhere."""
        state = self.save()
        data = self.bytes_of(state)
        self.free(state)
        return data


def hosts(*arguments, **named):
    """One instance of each version after the other."""
    return (Host(version, *arguments, **named) for version in (2, 3))
