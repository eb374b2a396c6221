"""What other tools do that FMPy's low-level classes do not: signals that start at zero, ports that stay unconnected, all start
values written back, steps shorter than an internal step, warnings as failures, enumerations passed over."""

from host import OK, PRESCRIBED, RADIUS, SMALL, Host, hosts

H = 1e-6
MOTION = [f"projectile.{name}" for name in ("position", "velocity", "orientation", "angular_velocity")]
DRIVEN = {**SMALL, "drive": PRESCRIBED, "projectile.start.velocity[3]": 60.0, "projectile.start.angular_velocity[3]": 200.0}


def step(host, t, h):
    assert host.status_of_step(t, h) == OK, host.log


def test_all_start_values_written_back_give_the_same_bits(version):
    plain, writes = Host(version), Host(version)
    texts = {v.name: v.start for v in writes.variables.values() if v.causality in ("parameter", "input")}
    assert {name for name, start in texts.items() if start is None} == set()
    read = {"Real": float, "Float64": float, "Boolean": lambda text: text == "true"}
    values = {name: [read.get(writes.variables[name].type, int)(word) for word in start.split()] for name, start in texts.items()}
    small = {"sheet.nodes_x": 41, "sheet.nodes_y": 41}
    assert plain.initialise(small) == OK
    assert writes.initialise({**values, **small}) == OK, writes.log
    assert writes.run(0, 40, H).image() == plain.run(0, 40, H).image()
    assert plain.get("contact.work") > 0.1


def test_signals_at_zero_in_the_first_step():
    """A master that starts all signals at zero, then drives: no step is refused, and the run is that of a host which drives
    at once."""
    ends = []
    for late in (False, True):
        host, x = Host(2, DRIVEN), [0.0, 0.0, -RADIUS - 1e-5]
        for k in range(20):
            motion = [x, [0.0, 0.0, 60.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 200.0]]
            for name, value in zip(MOTION, motion):
                host.try_set(name, [0.0] * len(value) if late and k == 0 else value)
            step(host, k * H, H)
            assert host.get("interface.gap") < 1e-7
            x = [0.0, 0.0, x[2] + 60.0 * H]
        ends.append((host.get("contact.work"), host.get("contact.impulse[3]")))
    for a, b in zip(*ends):
        assert abs(a / b - 1.0) < 5e-10


def test_what_is_not_connected_flies_on():
    """Nothing connected at all: the body flies from its start under the mean force of the last step, and turns on."""
    free = Host(2, {**DRIVEN, "drive": 0}).run(0, 20, H)
    for host in hosts(DRIVEN):
        for k in range(20):
            step(host, k * H, H)
        assert abs(host.get("contact.work") / free.get("contact.work") - 1.0) < 5e-2
        assert abs(host.get("state.velocity")[2] / free.get("state.velocity")[2] - 1.0) < 5e-4
        assert abs(host.get("state.angular_velocity")[2] - 200.0) < 5e-7
        assert abs(host.get("state.orientation")[3] - 0.5 * 200.0 * 20 * H) < 5e-7


def test_an_unconnected_orientation_beside_a_driven_position():
    host = Host(2, DRIVEN)
    for k in range(10):
        host.set(projectile__position=[0.0, 0.0, -RADIUS - 1e-5 + 60.0 * k * H], projectile__velocity=[0.0, 0.0, 60.0])
        step(host, k * H, H)
    assert abs(host.get("state.angular_velocity")[2] - 200.0) < 5e-7
    assert abs(host.get("state.orientation")[3] - 0.5 * 200.0 * 10 * H) < 5e-7


def test_zero_is_a_place_like_any_other_once_the_host_drives():
    host = Host(2, DRIVEN)
    host.set(projectile__position=[0.0, 0.0, -RADIUS - 1e-5], projectile__velocity=[0.0, 0.0, 60.0])
    step(host, 0.0, H)
    host.set(projectile__position=[0.0] * 3, projectile__velocity=[0.0] * 3)
    assert host.status_of_step(H, H) != OK
    assert host.said("from where the fabric has the body")


def test_a_remainder_of_a_step_leaves_the_outputs_as_they_are(version):
    """As left over by rounding at the end of a run, and steps much shorter than an internal one."""
    for drive in (0, PRESCRIBED):
        host = Host(version, {**DRIVEN, "drive": drive})
        for k in range(10):
            step(host, k * H, H)
        before = host.outputs()
        assert before["contact.force_mean"][2] != 0.0
        step(host, 10 * H, 7e-20)
        assert host.outputs() == before
        step(host, 10 * H, 1e-9)
        assert host.outputs() == before


def test_masters_that_round_their_steps_differently_read_the_same_means():
    """A mean is over the internal steps, not over the host's idea of a step."""
    for drive in (0, PRESCRIBED):
        means = []
        for timed in (
            lambda k: (k * H, H),
            lambda k: (k * H, (k + 1) * H - k * H),
            lambda k: (k * 1e-6 * (1 + 1e-13), 1.0000001e-6),
        ):
            host = Host(3, {**DRIVEN, "drive": drive})
            for k in range(10):
                step(host, *timed(k))
            means.append((host.get("contact.force_mean"), host.get("contact.torque_mean")))
        if drive == 0:
            assert means[1] == means[0]
            assert means[2] == means[0]
        assert means[0][0][2] != 0.0
