"""The cases of tests/inputs/cases that an FMU's parameters and inputs can express: each refused with its exact words, or
accepted.

An FMU holds its host to the min and max of the model description also where the scene does not read a parameter. A case beyond
them that the kernel would not refuse, or not so soon, must be refused as out of range.
"""

import math
import pathlib
import struct

from host import DISCARD, ERROR, PRESCRIBED, SMALL, SPHERE, WARNING, Host

FILE = pathlib.Path(__file__).parents[1] / "inputs" / "cases"
# Larger sheets would take the memory.
NODES = 100
# What the kernel's scene does not have; other tests try it.
MOTION = [f"projectile.{name}" for name in ("position", "velocity", "orientation", "angular_velocity")]
OWN = {*MOTION, "stop_on_event", "capsule", "ply.first", "projectile.acceleration", "external.force", "external.torque"}


def number(bits):
    return struct.unpack(">d", bytes.fromhex(bits))[0]


def named(field):
    """The kernel's motion of the body is the FMU's motion at the start."""
    return field.replace("projectile.", "projectile.start.", 1) if field.split("[")[0] in MOTION else field


def read():
    """Words of the codes, the changes that make each sound scene, and the cases."""
    texts, bases, cases = {0: ""}, {}, []
    for line in FILE.read_text().splitlines():
        kind, *words = line.split()
        if kind == "text":
            texts[int(words[0])] = line.split(maxsplit=2)[2]
        elif kind == "set":
            bases.setdefault(words[0], []).append((named(words[1]), number(words[2])))
        elif kind == "case":
            base, name, bits, code, field = words
            cases.append((base, named(name), number(bits), int(code), named(field)))
    return texts, bases, cases


def limits(variable):
    """Least and greatest value of the model description."""
    if variable.type == "Enumeration":
        numbers = [int(item.value) for item in variable.declaredType.items]
        return min(numbers), max(numbers)
    least, greatest = (getattr(variable, end) or getattr(variable.declaredType, end, None) for end in ("min", "max"))
    return float(least or "-inf"), float(greatest or "inf")


def test_every_case_is_answered_exactly():
    texts, bases, cases = read()
    for version in (2, 3):
        host = Host(version)
        names, references, tried, wrong = set(), {}, 0, []
        for base, name, value, code, field in cases:
            variable = variable_of(host, name)
            if not expressible(variable, value):
                continue
            if name.startswith("sheet.nodes") and code == 0 and value > NODES:
                continue
            names.add(name.split("[")[0])
            tried += 1
            words = f"{field}: {texts[code]}" if code else ""
            least, greatest = limits(variable)
            inside = math.isfinite(value) and least <= value <= greatest
            # What no scene can be given is refused at once; the rest when initialisation ends, with the kernel's words first.
            choice = variable.type == "Integer" and ": 0 " in variable.description
            at_once = choice or variable.type == "Enumeration" or (variable.type in ("Integer", "Int32") and value < 0)
            if not inside and (at_once or (code == 0 and variable.causality == "parameter")):
                words = f"{name.split('[')[0]}: out of range"
            said = answer(host, bases[base], name, value, references)
            if not (said.startswith(words) if words else said == ""):
                wrong.append(f"FMI {version} {base} {name} = {value}: {said!r}, not {words!r}")
        print(f"figure 8: {tried} cases in FMI {version}.0, {tried - len(wrong)} exact")
        assert wrong == []
        assert tried > 1000
        adjustable = {v.name.split("[")[0] for v in host.variables.values() if v.causality in ("parameter", "input")}
        assert adjustable - names == OWN


def variable_of(host, name):
    return host._elements(name.split("[")[0])[0]


def expressible(variable, value):
    if variable.type == "Boolean":
        return value in (0.0, 1.0)
    return variable.type in ("Real", "Float64") or value < 2**31


def put(host, name, value):
    """Status of setting a number, one element of an array if it has an index; and what it was."""
    name, *indices = name.replace("]", "").split("[")
    variable = variable_of(host, name)
    whole = host.get(name)
    if indices:
        # Rows of faces have four numbers.
        element = sum(int(index) * size for index, size in zip(reversed(indices), (1, 4)))
        changed = [*whole[:element], value, *whole[element + 1 :]]
    else:
        changed = value if variable.type in ("Real", "Float64") else bool(value) if variable.type == "Boolean" else int(value)
    return host.try_set(name, changed), whole


def start(host, sets):
    """A new life of the instance, with these numbers set."""
    host.fmu.reset()
    host.log.clear()
    host.begin(SPHERE)
    for name, value in sets:
        assert put(host, name, value)[0] <= WARNING, (name, value, host.log)


def answer(host, sets, name, value, references):
    """What the FMU says about a number, nothing if it takes it. A refused one must leave no trace."""
    start(host, sets)
    status, good = put(host, name, value)
    if status <= WARNING:
        status = host.attempt(host.fmu.exitInitializationMode)
    if status <= WARNING:
        return ""
    assert (status, len(host.log)) == (ERROR, 1), host.log
    said = host.log[0][2]
    # With the number put right the state is that of an instance that never saw it.
    array = name.split("[")[0]
    assert host.try_set(array, good) == 0
    assert host.attempt(host.fmu.exitInitializationMode) <= WARNING, host.log
    image, key = host.image(), (tuple(sets), array)
    if key not in references:
        start(host, sets)
        assert host.try_set(array, good) == 0
        assert host.attempt(host.fmu.exitInitializationMode) <= WARNING
        references[key] = host.image()
    assert image == references[key], (name, value)
    return said


def test_inputs_that_are_no_numbers_are_discarded():
    motion = ["position", "velocity", "orientation", "angular_velocity", "acceleration"]
    inputs = {0: ["external.force", "external.torque"], PRESCRIBED: [f"projectile.{name}" for name in motion]}
    tried = 0
    for version in (2, 3):
        for drive, names in inputs.items():
            host = Host(version, {**SMALL, "drive": drive}).run(0, 3, 1e-6)
            for name in names:
                good = host.get(name)
                assert host.try_set(name, good) == 0
                before = host.image()
                for element in range(len(good)):
                    for bad in (math.nan, math.inf, -math.inf):
                        host.log.clear()
                        assert host.try_set(name, [bad if k == element else x for k, x in enumerate(good)]) == 0
                        assert host.step(3e-6, 1e-6) == DISCARD, (name, element, bad)
                        assert host.said(name), host.log
                        assert host.try_set(name, good) == 0
                        assert host.image() == before
                        tried += 1
    print(f"figure 8: {tried} inputs in FMI, {tried} discarded")
