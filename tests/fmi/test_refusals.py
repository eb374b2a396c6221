"""Bad parameters and calls: status Error, a log line that names the field or the function, and nothing changed."""

import resource

from host import DISCARD, ERROR, FOUR_CORNERS, OK, PRESCRIBED, RADIUS, SMALL, Host

NAN = float("nan")

# Parameters that must be refused, and what the log says beside the words that `test_inputs` compares. Each is put on top of
# SMALL.
REFUSED = [
    (
        {"time_step.seconds": 2.7e-8, "yarn.stochastic": False},
        "time_step.seconds: time step too large; the largest allowed is 2.644",
    ),
    ({"sheet.nodes_y": -5}, "sheet.nodes_y"),
    ({"yarn.damage_intercept": -1108.0}, "yarn.damage_intercept"),  # a damage rate of 1
    ({"projectile.shape": 3, "projectile.size": [1e-2, 1e-3, 1e-2]}, "projectile.size"),
    ({"projectile.shape": -1}, "projectile.shape"),
    ({"projectile.start.position": [0.0, 0.0, -RADIUS + 1e-4]}, "a node lies inside the projectile"),
    ({"projectile.start.velocity": [0.0, 0.0, 5e4]}, "in a step; the largest step for this motion is"),
    ({"attachment.kind": FOUR_CORNERS, "attachment.disc_inset": 1.0886e-3, "attachment.disc_radius": 4e-4}, "holds no node"),
    ({"attachment.kind": 9}, "attachment.kind: out of range; it is 9, must be at least 0 and at most 3"),
    ({"drive": 2}, "drive"),
    ({"contact.friction": 0.2, "integrator.kind": 1}, "contact.friction: does not go with another field: integrator.kind"),
]


def test_a_sheet_larger_than_the_memory_is_an_error_of_its_instance_alone():
    limits = resource.getrlimit(resource.RLIMIT_AS)
    for version in (2, 3):
        other, host = Host(version, SMALL), Host(version)
        resource.setrlimit(resource.RLIMIT_AS, (16 << 30, limits[1]))
        try:
            status = host.initialise({**SMALL, "sheet.nodes_x": 60000, "sheet.nodes_y": 60000})
        finally:
            resource.setrlimit(resource.RLIMIT_AS, limits)
        assert status == ERROR, host.log
        assert host.said("out of memory"), host.log
        other.run(0, 3, 1e-6)


def test_bad_parameters_are_named_and_may_be_corrected(version):
    plain = Host(version, SMALL).run(0, 3, 1e-6)
    expected = plain.outputs()
    for bad, named in REFUSED:
        host = Host(version)
        for name in bad:
            assert host._elements(name), name
        host.begin(SMALL)
        good = {name: host.get(name) for name in bad}
        statuses = [host.try_set(name, value) for name, value in bad.items()]
        if max(statuses) == OK:
            statuses.append(host.attempt(host.fmu.exitInitializationMode))
        assert max(statuses) == ERROR
        assert host.said(named), host.log
        assert [category for _, category, _ in host.log] == ["logStatusError"]
        # Nothing has changed: with the parameters put right the run is the undisturbed one.
        for name, value in good.items():
            assert host.try_set(name, value) == OK
        assert host.attempt(host.fmu.exitInitializationMode) == OK, host.log
        assert host.run(0, 3, 1e-6).outputs() == expected


def test_legal_extremes_are_accepted():
    for values in [
        {"attachment.kind": 3},
        {"projectile.start.velocity": [0.0, 0.0, 0.0]},
        {"projectile.start.velocity": [0.0, 0.0, 20000.0]},
        {"projectile.mass": 1e-6},
        {"sheet.nodes_x": 3, "sheet.nodes_y": 2},
        {"projectile.mass": 0.0, "drive": PRESCRIBED},
    ]:
        host = Host(2, {**SMALL, **values}).run(0, 5, 1e-6)
        assert host.get("interface.residual") == 0.0


def test_calls_in_the_wrong_state_are_named(version):
    """calls/states.inc has the statuses."""
    host = Host(version)
    assert host.step(0.0, 1e-6) == ERROR
    assert host.said("DoStep: not allowed")
    host.initialise(SMALL)
    for fixed in ("sheet.spacing", "drive", "seed", "yarn.stochastic"):
        assert host.try_set(fixed, host.get(fixed)) == ERROR
        assert fixed in host.log[-1][2]


def test_a_bad_load_is_discarded_and_a_failure_is_latched(version):
    host = Host(version, SMALL).run(0, 10, 1e-6)
    plain = Host(version, SMALL).run(0, 20, 1e-6)
    state = host.save()
    host.set(external__force=[0.0, NAN, 0.0])
    assert host.step(1e-5, 1e-6) == DISCARD
    assert host.said("external.force")
    host.set(external__force=[0.0, 0.0, 1e12])
    assert host.step(1e-5, 1e-6) == ERROR
    assert host.said("faster than a node spacing")
    # Read: what the host has set, and that it has failed. Not read: all that is computed.
    read = {name for name, v in host.variables.items() if v.causality != "output" or name == "status"}
    for name, variable in host.variables.items():
        status = host.attempt(host.read, [variable])
        assert status == (OK if name in read else ERROR), (version, name)
    assert host.said("energy.strain: "), host.log[-1]
    assert host.get("status") == 2
    assert host.step(1e-5, 1e-6) == ERROR
    assert host.restore(state) == OK
    assert host.run(10, 20, 1e-6).outputs() == plain.outputs()
