"""The component for WebAssembly: it does what the native library does, call by call and bit by bit, and states go from one to the
other."""

import hashlib
import pathlib
import zipfile

import fmpy
import pytest
from component import FILE, interfaces
from fmpy.fmi1 import FMICallException
from host import ARCHIVES, DISCARD, ERROR, OK, PRESCRIBED, SMALL, Host, opened
from lxml import etree

H = 1e-6
TINY = {**SMALL, "sheet.nodes_x": 21, "sheet.nodes_y": 21}
NAN = float("nan")
OWN = FILE.format("FabricShield")
MANIFESTS = ["extra/org.modelica.fmi-ls-wasm/manifest.xml", "extra/org.modelica.fmi-ls-wasm/fmi-ls-manifest.xml"]

with zipfile.ZipFile(ARCHIVES[3]) as packed:
    NAMES = packed.namelist()


def reached(state, component):
    """An instance in a state of FMI 3.0, with event mode."""
    host = Host(3, events=True, early=False, component=component)
    host.begin(TINY) if state != "instantiated" else None
    if state in ("instantiated", "initialization"):
        return host
    assert host.attempt(host.fmu.exitInitializationMode) == OK
    if state != "event":
        host.fmu.enterStepMode()
        assert host.step(0.0, H) == OK
    if state == "discarded":
        host.set(**{"external.force": [NAN, 0.0, 0.0]})
        assert host.step(H, H) == DISCARD
    if state == "failed":
        # More than a yarn can bear in a step.
        host.set(**{"external.force": [0.0, 0.0, 1e12]})
        assert host.step(H, 100 * H) == ERROR
    if state == "terminated":
        host.fmu.terminate()
    return host


STATES = ["instantiated", "initialization", "event", "step", "discarded", "failed", "terminated"]
# What a host may call, good and bad.
CALLS = {
    "enter initialization": lambda host: host.fmu.enterInitializationMode(startTime=0.0, stopTime=1e-3),
    "stop before start": lambda host: host.fmu.enterInitializationMode(startTime=0.0, stopTime=-1.0),
    "exit initialization": lambda host: host.fmu.exitInitializationMode(),
    "event mode": lambda host: host.fmu.enterEventMode(),
    "update": lambda host: host.fmu.updateDiscreteStates(),
    "step mode": lambda host: host.fmu.enterStepMode(),
    "step": lambda host: host.fmu.doStep(H, H),
    "step from elsewhere": lambda host: host.fmu.doStep(5 * H, H),
    "step backwards": lambda host: host.fmu.doStep(H, -H),
    "terminate": lambda host: host.fmu.terminate(),
    "reset": lambda host: host.fmu.reset(),
    "restore": lambda host: host.restore(host.save()),
    "log all": lambda host: host.fmu.setDebugLogging(True, ["logAll"]),
    "log what is unknown": lambda host: host.fmu.setDebugLogging(True, ["logNothing"]),
    "time": lambda host: host.fmu.getFloat64([0]),
    "no variable": lambda host: host.fmu.getFloat64([99999]),
    "another type": lambda host: host.fmu.getInt32([0]),
    "an output": lambda host: host.get("contact.work"),
    "status": lambda host: host.get("status"),
    "an outcome": lambda host: host.get("outcome.exited"),
    "a count": lambda host: host.get("sheet.nodes_x"),
    "set an output": lambda host: host.try_set("contact.work", 1.0),
    "set a parameter": lambda host: host.try_set("sheet.nodes_x", 31),
    "set it out of range": lambda host: host.try_set("sheet.nodes_x", -5),
    "set a choice": lambda host: host.try_set("attachment.kind", 0),
    "set a choice that is none": lambda host: host.try_set("attachment.kind", 9),
    "set a flag": lambda host: host.try_set("stop_on_event", True),
    "set an input": lambda host: host.try_set("external.force", [0.0, 1.0, 0.0]),
    "too few numbers": lambda host: host.fmu.setFloat64([host.variables["external.force"].valueReference], [1.0]),
}
REFERENCES = {
    "float32": [1.0],
    "int8": [1],
    "int16": [1],
    "uint8": bytes([1]),
    "uint16": [1],
    "uint32": [1],
    "uint64": [1],
    "string": ["x"],
    "binary": [b"x"],
    "clock": [True],
}
ABSENT = {
    "enter-configuration-mode": [],
    "exit-configuration-mode": [],
    "evaluate-discrete-states": [],
    "get-number-of-variable-dependencies": [333],
    "get-variable-dependencies": [333],
    "get-directional-derivative": [[333], [150], [1.0]],
    "get-adjoint-derivative": [[333], [150], [1.0]],
    "get-interval-decimal": [[1]],
    "get-interval-fraction": [[1]],
    "get-shift-decimal": [[1]],
    "get-shift-fraction": [[1]],
    "set-interval-decimal": [[1], [1.0]],
    "set-interval-fraction": [[1], []],
    "set-shift-decimal": [[1], [1.0]],
    "set-shift-fraction": [[1], []],
    "set-input-derivatives": [[], [1.0]],
    "get-output-derivatives": [[]],
}


MISSING = "the archive has no component: cargo xtask fmu --targets all names what is missing"
pytestmark = pytest.mark.skipif(OWN not in NAMES, reason=MISSING)


def test_it_needs_the_hosts_logger_and_nothing_of_wasi():
    wanted = [["callbacks", "types"], ["co-simulation", "common"]]
    found = interfaces(pathlib.Path(opened(3)[1], OWN))
    assert found == [[f"fmi:fmi3/{name}@3.0.0" for name in names] for names in wanted]


def test_the_manifests_follow_the_schema():
    schema = pathlib.Path(fmpy.__file__).parent / "schema/fmi3/fmi3LayeredStandardManifest.xsd"
    for name in MANIFESTS:
        with zipfile.ZipFile(ARCHIVES[3]) as packed:
            root = etree.fromstring(packed.read(name))
        etree.XMLSchema(etree.parse(str(schema))).assertValid(root)
        assert root.get("{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-name") == "org.modelica.fmi-ls-wasm"


def test_every_call_in_every_state_as_the_library_does_it():
    compared = 0
    for state in STATES:
        for name, call in CALLS.items():
            both = []
            for component in (False, True):
                host, status, answer = reached(state, component), OK, None
                try:
                    answer = call(host) or 0
                except FMICallException as refused:
                    status = refused.status
                values = {} if state == "failed" else {name: host.get(name) for name in ("state.position", "status")}
                both.append((status, answer, host.log, repr(values)))
            assert both[1] == both[0], (state, name)
            compared += 1
    print(f"\n{compared} calls in {len(STATES)} states: status, values and log are those of the library", flush=True)


def test_what_is_not_offered_is_refused_and_logged():
    host = reached("step", True)
    for kind, values in REFERENCES.items():
        assert host.fmu.call(f"get-{kind}", []) == (b"" if kind == "uint8" else [])
        assert host.fmu.call(f"set-{kind}", [], values[:0]) is None
        for name, *arguments in ((f"get-{kind}", [1]), (f"set-{kind}", [1], values)):
            assert host.attempt(host.fmu.call, name, *arguments) == ERROR, name
            assert "not supported" in host.log[-1][2]
    for name, arguments in ABSENT.items():
        assert host.attempt(host.fmu.call, name, *arguments) == ERROR, name
        assert host.log[-1][2] == f"fmi3{name.title().replace('-', '')}: not supported"
    assert host.fmu.named == "test"


def test_a_wrong_token_is_refused():
    with pytest.raises(FMICallException):
        Host(3, token="{FabricShield-0000000000000}", component=True)


def test_events_and_digests_are_those_of_the_library():
    for values in (SMALL, {**SMALL, "projectile.start.velocity[3]": 20.0}, {**SMALL, "stop_on_event": True}):
        runs = []
        for component in (False, True):
            host, t, told = Host(3, values, events=True, component=component), 0.0, []
            while t < 250 * H - 1e-12 and not (told and told[-1][1]):
                assert host.step(t, min(H, 250 * H - t)) == OK
                t = host.last[3]
                if host.last[0]:
                    host.fmu.enterEventMode()
                    told.append((*host.last, tuple(host.fmu.updateDiscreteStates()), repr(host.outputs())))
                    host.fmu.enterStepMode()
            runs.append((told, host.log, host.image()))
        assert len(runs[0][0]) > 1
        assert runs[1] == runs[0]
        print(f"\n{len(told)} events, state {hashlib.sha256(runs[1][2]).hexdigest()[:16]} in both", end=" ", flush=True)


def test_a_prescribed_body_gives_the_same_bits():
    images = []
    for component in (False, True):
        host = Host(3, {**SMALL, "drive": PRESCRIBED}, component=component)
        position, velocity = host.get("projectile.start.position"), host.get("projectile.start.velocity")
        for k in range(30):
            at = [x + v * k * H for x, v in zip(position, velocity)]
            host.set(projectile__position=at, projectile__velocity=velocity)
            assert host.step(k * H, H) == OK, host.log
        host.set(projectile__orientation=[2.0, 0.0, 0.0, 0.0])
        assert host.step(30 * H, H) == DISCARD
        images.append((host.image(), host.log))
    assert images[1] == images[0]


def test_states_go_from_the_library_to_the_component_and_back():
    native, component = Host(3, SMALL).run(0, 10, H), Host(3, component=True)
    assert component.restore(native.image()) == OK, component.log
    assert component.image() == native.image()
    back = Host(3)
    assert back.restore(back.state_of(component.run(10, 20, H).image())) == OK, back.log
    assert back.run(20, 30, H).image() == native.run(10, 30, H).image()
    assert component.run(20, 30, H).image() == native.image()
    data = native.image()
    for bad in (b"", data[:-8], data[:100] + bytes([data[100] ^ 1]) + data[101:]):
        assert component.restore(bad) == ERROR
        assert component.said("needed are" if len(bad) == len(data) - 8 else "altered, or none")
    assert component.image() == data


def test_instances_do_not_disturb_each_other():
    one, other = Host(3, SMALL, component=True), Host(3, TINY, component=True)
    for k in range(10):
        one.run(k, k + 1, H), other.run(k, k + 1, H)
    assert one.image() == Host(3, SMALL).run(0, 10, H).image()
