"""Outputs in Initialization Mode: computed when they are read, and dependent on what the model description says."""

import contextlib
import itertools
import math

from fmpy.fmi1 import FMICallException
from host import ERROR, FOUR_CORNERS, FOUR_SIDES, OK, PRESCRIBED, SPHERE, WARNING, Host, size_of
from test_description import stated, tree

H = 1e-6
TAUT = {**SPHERE, "yarn.draw": 1, "sheet.pre_strain": [1e-3, 1e-3]}
TINY = {"sheet.nodes_x": 21, "sheet.nodes_y": 21}
# Radius of a ring of 21 spacings of the default scene.
RING = 0.0762 / 105 / (2.0 * math.sin(math.pi / 21))
TURNED = [math.cos(0.2), math.sin(0.2), 0.0, 0.0]
# Scenes in which every known is read; the bodies lie 1 mm and more before a sheet of 21 x 21 nodes.
SCENES = [
    {
        **TINY,
        "time_step.seconds": 0.0,
        "yarn.rate_modulus": 0.01,
        "yarn.rate_stretch": 0.01,
        "yarn.rate_reference": 1.0,
        "yarn.rate_limit": 1e4,
    },
    {
        **TAUT,
        **TINY,
        "weft.modulus_mean": 1.4e11,
        "weft.modulus_sd": 1e9,
        "weft.damage_slope": 7.91e-9,
        "weft.damage_intercept": -878.46,
        "weft.damage_sd": 8.0,
        "weft.critical_stretch": 1.04,
        "yarn.strength_draw": 1,
    },
    {
        **SPHERE,
        **TINY,
        "stack.plies": 3,
        "stack.gap": 2e-4,
        "back.plies": 1,
        "ply.first": 1,
        "contact.friction": 0.2,
        "projectile.start.angular_velocity[2]": 5.0,
        "sheet.crimp": [1e-3, 2e-3],
        "attachment.hold": 100.0,
    },
    {
        **TINY,
        "projectile.shape": 5,
        "projectile.start.position[3]": -0.1,
        "projectile.start.orientation": [0.5, 0.5, -0.5, 0.5],
        "sheet.orientation": TURNED,
        "sheet.position": [1e-3, 2e-3, 3e-3],
        "attachment.kind": FOUR_CORNERS,
        "attachment.disc_inset": 1e-3,
        "attachment.disc_radius": 8e-4,
        "slack_balance": True,
    },
    {
        **SPHERE,
        **TINY,
        "projectile.shape": 4,
        "projectile.faces.count": 4,
        "projectile.moments": [1e-6, 1e-6, 1e-6],
        "drive": PRESCRIBED,
        "projectile.faces.planes": [0.0] * 64,
        "projectile.start.position[3]": -0.1,
        "attachment.kind": FOUR_SIDES,
        "sheet.grading.largest": 4,
        "sheet.grading.run": 1,
        "sheet.grading.half_width": [2e-3, 2e-3],
    },
    {**SPHERE, **TINY, "integrator.kind": 1, "rotation_rule.kind": 1, "symmetry.mirror_x": True, "yarn.stochastic": False},
    {**SPHERE, **TINY, "sheet.radius": 0.05},
    {**SPHERE, **TINY, "sheet.radius": RING, "sheet.closed": True, "projectile.start.position[3]": -0.02},
    {
        **SPHERE,
        **TINY,
        "sheet.radius": RING,
        "sheet.closed": True,
        "casing.radius": 0.9 * RING,
        "casing.window_angle": [0.3, 1.0],
        "casing.window_place": [1e-3, 2e-3],
        "projectile.start.position[3]": -0.02,
    },
]
corner = 1.0 / math.sqrt(3.0)
for face, signs in enumerate([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]):
    SCENES[4]["projectile.faces.planes"][4 * face : 4 * face + 4] = [sign * corner for sign in signs] + [5e-3]


def expected_strain(nodes):
    """Energy of a square sheet of uniform yarn that is held stretched by 1e-3 both ways: Green-Lagrange strain, natural
    length."""
    host = Host(3)
    spacing, area, modulus = (host.get(name) for name in ("sheet.spacing", "sheet.yarn_area", "yarn.modulus_mean"))
    return 2 * nodes * (nodes - 1) * 0.5 * modulus * area * spacing / 1.001 * (0.5 * (1.001**2 - 1.0)) ** 2


def test_a_taut_sheet(version):
    host = Host(version)
    assert host.begin({**TAUT, "yarn.stochastic": False}) == OK
    energy = host.get("energy.strain")
    print(f"\nFMI {host.version}: energy.strain {energy:.4f} J, fabric.max_stretch {host.get('fabric.max_stretch'):.4f}", end="")
    print(
        f", ply.strain[1] {host.get('ply.strain')[0]:.4f} J, step.fraction {host.get('step.fraction'):.3f}", end=" ", flush=True
    )
    assert abs(energy / expected_strain(105) - 1.0) < 5e-10
    assert abs(host.get("fabric.max_stretch") - 1.001) < 5e-13
    assert host.get("ply.strain") == [energy] + [0.0] * 7
    assert 0.1 < host.get("step.fraction") <= 0.5


def test_they_are_those_of_the_first_point(version):
    """Bit by bit, and reading them changes neither a saved state nor the run; a parameter that is set after it counts."""
    for scene in SCENES:
        plain, host = Host(version), Host(version)
        assert plain.begin(scene) == OK
        assert host.begin({**scene, "seed": 77}) == OK, host.log
        host.outputs()
        assert host.try_set("seed", 1) == OK
        read = host.outputs()
        assert host.image() == plain.image()
        for each in (plain, host):
            assert each.attempt(each.fmu.exitInitializationMode) == OK, each.log
            assert each.outputs() == read
        assert host.run(0, 5, H).image() == plain.run(0, 5, H).image()


def test_a_scene_that_is_none_yet_has_no_outputs(version):
    host = Host(version)
    spacing = float(host.variables["sheet.spacing"].start)
    assert host.begin({**SPHERE, "sheet.spacing": 0.0}) == OK
    assert host.attempt(host.read, [host.variables["energy.strain"]]) == ERROR
    assert host.said("sheet.spacing: must be greater than zero; it is 0"), host.log
    assert host.get("sheet.spacing") == 0.0
    assert host.try_set("sheet.spacing", spacing) == OK
    assert host.get("energy.strain") == 0.0
    assert host.attempt(host.fmu.exitInitializationMode) == OK


def test_a_state_of_initialisation_can_be_restored(version):
    host = Host(version)
    host.begin(TAUT)
    energy, state = host.get("energy.strain"), host.save()
    host.set(seed=5)
    assert host.get("energy.strain") != energy
    assert host.restore(state) == OK
    assert host.get("energy.strain") == energy
    assert host.attempt(host.fmu.exitInitializationMode) == OK
    assert host.restore(state) == OK
    assert host.try_set("seed", 5) == OK


def others(variable, value):
    """Seven values near one of an input or parameter."""
    if variable.type == "Boolean":
        return [1 - value] * 7
    if variable.type in ("Integer", "Int32", "Enumeration"):
        return [value + 1, value + 2, value - 1, 0, 1, 2, 3]
    return [1.01 * value, 0.99 * value, value + 4e-4, value - 1e-3, value + 0.02, value + 1.0, 0.5 * value + 1e-9]


def reader(host):
    """A function that reads every output: a list of numbers by the name of each variable."""
    outputs = [v for v in host.variables.values() if v.causality == "output"]
    groups = {kind: [v for v in outputs if v.type == kind] for kind in {v.type for v in outputs}}

    def read():
        found = {}
        for group in groups.values():
            values = iter(host.read(group))
            found |= {v.name: list(itertools.islice(values, size_of(v))) for v in group}
        return found

    return read


def changed(before, now):
    """The outputs that differ by more than rounding in the sheet's axes, where vectors are turned to and back."""

    def vector(values, name):
        return [abs(x) for other, numbers in values.items() if other.partition("[")[0] == name.partition("[")[0] for x in numbers]

    names = [name for name in now if now[name] != before[name]]
    return {
        name
        for name in names
        if max(abs(x - y) for x, y in zip(now[name], before[name])) > 1e-12 * max(vector(before, name) + vector(now, name))
    }


def found_of(host, knowns):
    """Sets one known after the other to other values and back: outputs that change, with what changes them; values taken of
    each known."""
    read, found, taken = reader(host), {}, dict.fromkeys(knowns, 0)
    before = read()
    for known in knowns:
        value = host.get(known)
        elements = value if isinstance(value, list) else [value]
        for place, other in itertools.product({0, len(elements) - 1}, range(7)):
            values = [*elements]
            values[place] = others(host.variables[known], elements[place])[other]
            if host.try_set(known, values) <= WARNING:
                with contextlib.suppress(FMICallException):  # a scene that is none
                    now = read()
                    taken[known] += values != elements
                    for output in changed(before, now):
                        found.setdefault(output, set()).add(known)
                assert host.try_set(known, elements) == OK
    return found, taken


def compare(allowed, found):
    """What changes an output is stated, and what is stated changes it."""
    wrong = {
        name: sorted(known - allowed[name])
        for name, known in found.items()
        if allowed[name] is not None and known - allowed[name]
    }
    idle = {
        name: sorted(known - found.get(name, set()))
        for name, known in allowed.items()
        if known and known - found.get(name, set())
    }
    assert (wrong, idle) == ({}, {})
    # Where all are stated there are some; of arrays at the first element.
    assert [
        name
        for name, known in allowed.items()
        if known is None and name.partition("[")[0] + "[1]" not in found and name not in found
    ] == []


def test_initial_values_depend_on_what_is_stated(version):
    allowed, found, taken = stated(tree(version), version, "InitialUnknowns"), {}, {}
    for scene in SCENES:
        host = Host(version)
        assert host.begin(scene) == OK, host.log
        knowns = [v.name for v in host.variables.values() if v.causality in ("input", "parameter")]
        some, counts = found_of(host, knowns)
        for output, names in some.items():
            found.setdefault(output, set()).update(names)
        taken = {known: taken.get(known, 0) + count for known, count in counts.items()}
    assert [known for known, count in taken.items() if count == 0] == []
    compare(allowed, found)
    print(f"\nFMI {version}: {sum(taken.values())} values of {len(taken)} knowns; ", end="")
    print(
        f"{sum(known is None for known in allowed.values())} outputs depend on all, {sum(map(bool, allowed.values()))} "
        f"on those named",
        end=" ",
        flush=True,
    )


def test_the_initial_values_do_not_depend_on_the_start_time(version):
    values = []
    for start in (0.0, 1.0):
        host = Host(version)
        host.begin(TAUT, start=start)
        values.append(host.outputs())
    assert values[0] == values[1]


def test_a_time_that_numbers_do_not_resolve_is_refused(version):
    host = Host(version)
    assert host.initialise(TAUT, start=1e12) == ERROR
    assert host.said("start time: near 1e12 s numbers are farther apart than an internal step"), host.log
    host = Host(version)
    assert host.initialise(TAUT, start=1e3) == OK
    assert (host.step(1e3, 1e-14), host.step(1e3, 1e-6)) == (ERROR, OK)
    assert host.said("doStep: t + h is t"), host.log


def test_outputs_depend_at_once_on_what_is_stated(version):
    allowed, found = stated(tree(version), version, "Outputs"), {}
    for drive in (0, PRESCRIBED):
        scene = {**SCENES[2], "stack.plies": 11, "sheet.crimp": [0.0, 0.0], "projectile.start.velocity[3]": 900.0, "drive": drive}
        host = Host(version, scene).run(0, 20, H)
        knowns = [v.name for v in host.variables.values() if v.causality == "input" or v.variability == "tunable"]
        some, taken = found_of(host, knowns)
        assert min(taken.values()) > 0
        for output, names in some.items():
            found.setdefault(output, set()).update(names)
    compare(allowed, found)
