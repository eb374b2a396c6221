"""The component for WebAssembly in an archive of FMI 3.0, run by wasmtime behind the names of FMPy's class for the native
library."""

from functools import partialmethod

from fmpy.fmi1 import FMICallException
from wasmtime import Config, Engine, Store
from wasmtime.component import Component, Linker

PACKAGE, VERSION = "fmi:fmi3", "3.0.0"
RESOURCE = "co-simulation-instance"
STATUS = ["ok", "warning", "discard", "error", "fatal"]
FILE = "binaries/wasm32-wasip2/{}.wasm"

_engine = Engine(Config())
_compiled = {}


def compiled(path):
    """The component in a file, which is compiled once."""
    if path not in _compiled:
        _compiled[path] = Component.from_file(_engine, str(path))
    return _compiled[path]


def interfaces(path):
    """Names of what a component imports and exports."""
    return [sorted(names) for names in (compiled(path).type.imports(_engine), compiled(path).type.exports(_engine))]


class Slave:
    """One instance in a component of its own."""

    def __init__(self, path, log):
        self.store, self.log = Store(_engine), log
        linker = Linker(_engine)
        with linker.root() as root:
            root.add_instance(f"{PACKAGE}/types@{VERSION}").close()
            with root.add_instance(f"{PACKAGE}/callbacks@{VERSION}") as callbacks:
                callbacks.add_func("log-message", self._say)
        self.instance = linker.instantiate(self.store, compiled(path))
        self.exports = self.instance.get_export_index(self.store, f"{PACKAGE}/co-simulation@{VERSION}")
        self.found = {}
        self.component = None

    def _say(self, _store, name, status, category, message):
        self.named = name
        self.log(None, STATUS.index(status), category.encode(), message.encode())

    def plain(self, name, *arguments, kind="[method]"):
        """What a function returns."""
        if name not in self.found:
            index = self.instance.get_export_index(self.store, f"{kind}{RESOURCE}.{name}", self.exports)
            self.found[name] = self.instance.get_func(self.store, index)
        function = self.found[name]
        return function(self.store, *([] if kind == "[static]" else [self.component]), *arguments)

    def call(self, name, *arguments):
        """Call with None for success; as FMPy does it, all but that and a warning raises."""
        result = self.plain(name, *arguments)
        if isinstance(result, str) and STATUS.index(result) > 1:
            raise FMICallException(function=name, status=STATUS.index(result))
        return None if isinstance(result, str) else result

    def instantiate(self, token, loggingOn, eventModeUsed, earlyReturnAllowed):
        named = ("test", token, False, loggingOn, eventModeUsed, earlyReturnAllowed, [])
        self.component = self.plain("instantiate-co-simulation", *named, kind="[static]")
        if self.component is None:
            raise FMICallException(function="instantiate-co-simulation", status=3)

    def setDebugLogging(self, loggingOn, categories):
        self.call("set-debug-logging", loggingOn, categories)

    def enterInitializationMode(self, startTime=0.0, stopTime=None):
        self.call("enter-initialization-mode", None, startTime, stopTime)

    def doStep(self, t, h):
        end = self.call("do-step", t, h, True)
        names = ("event-handling-needed", "terminate-simulation", "early-return", "last-successful-time")
        return tuple(getattr(end, name) for name in names)

    def updateDiscreteStates(self):
        names = (
            "new-discrete-states-needed terminate-simulation nominals-of-continuous-states-changed "
            "values-of-continuous-states-changed next-event-time-defined next-event-time"
        ).split()
        end = self.call("update-discrete-states")
        return tuple(getattr(end, name) for name in names)

    def getFMUState(self):
        return self.call("get-fmu-state")

    def setFMUState(self, state):
        self.call("set-fmu-state", state)

    def freeFMUState(self, state):
        """A state is bytes, nothing else."""

    serializeFMUState = deserializeFMUState = staticmethod(bytes)

    def fmi3FreeInstance(self, component):
        component.drop(self.store)

    def _get(self, kind, references, nValues=None):
        return self.call(f"get-{kind}", list(references))

    def _set(self, kind, of, references, values):
        self.call(f"set-{kind}", list(references), [of(value) for value in values])

    exitInitializationMode = partialmethod(call, "exit-initialization-mode")
    enterEventMode, enterStepMode = partialmethod(call, "enter-event-mode"), partialmethod(call, "enter-step-mode")
    terminate, reset = partialmethod(call, "terminate"), partialmethod(call, "reset")
    getFloat64, setFloat64 = partialmethod(_get, "float64"), partialmethod(_set, "float64", float)
    getInt32, setInt32 = partialmethod(_get, "int32"), partialmethod(_set, "int32", int)
    getInt64, setInt64 = partialmethod(_get, "int64"), partialmethod(_set, "int64", int)
    getBoolean, setBoolean = partialmethod(_get, "boolean"), partialmethod(_set, "boolean", bool)
