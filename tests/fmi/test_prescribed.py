"""Drive prescribed against free: pointwise before the first failure, as an ensemble afterwards."""

import math

from host import DISCARD, OK, PRESCRIBED, RADIUS, SMALL, SPHERE, Host

MASS = 8.4e-3


def case(speed):
    """The 3 in sheet, four sides held, the sphere a hundredth of a millimetre before it."""
    return {**SPHERE, "projectile.start.position[3]": -RADIUS - 1e-5, "projectile.start.velocity[3]": speed}


def free(values, h, end, until=lambda host: False):
    """Velocity and work along z after each step, and the host; ends early when `until` says so."""
    host, rows = Host(2, values), {}
    for k in range(round(end / h)):
        host.run(k, k + 1, h)
        if until(host):
            break
        rows[k + 1] = (host.get("state.velocity[3]"), host.get("contact.work"))
    return rows, host


def driven(values, h, end, version=2, exact=False):
    """A host in a few lines: the FMU steps first, then the body under the mean force of the same interval.

    The FMU's impulses act at the start of each internal step, so the body's position gains F/2m h (h + dt), not F/2m h h. A host
    that leaves dt out (`exact` false) is half an internal step late: an error of first order in dt, whatever h is.
    """
    host = Host(version, {**values, "drive": PRESCRIBED})
    late = host.get("time_step.seconds") if exact else 0.0
    x, v, rows = host.get("projectile.start.position"), host.get("projectile.start.velocity"), {}
    for k in range(round(end / h)):
        host.set(projectile__position=x, projectile__velocity=v)
        status = host.step(k * h, h)
        assert status == OK, (status, host.log)
        force = host.get("contact.force_mean")
        x = [p + u * h + 0.5 * f / MASS * h * (h + late) for p, u, f in zip(x, v, force)]
        v = [u + f / MASS * h for u, f in zip(v, force)]
        rows[k + 1] = (v[2], host.get("contact.work"))
    return rows, host


def compare(joule, dt, end, until):
    """Largest errors of velocity over V0 and of work over KE0 by step size, at common times."""
    speed = math.sqrt(2.0 * joule / MASS)
    values = {**case(speed), "time_step.seconds": dt}
    reference, _ = free(values, 1e-7, end, until)
    last = max(reference) // 100 * 100
    print(f"\n  {joule} J, dt {dt:.0e} s, to {last * 1e-7:.1e} s, V {reference[last][0]:.3f} m/s", end="")
    result = {}
    for exact in (False, True):
        for per in (1, 10, 100):
            rows, _host = driven(values, per * 1e-7, last * 1e-7, exact=exact)
            common = range(100, last + 1, 100)
            velocity = max(abs(rows[k // per][0] - reference[k][0]) for k in common) / speed
            work = max(abs(rows[k // per][1] - reference[k][1]) for k in common) / joule
            result[exact, per] = (velocity, work)
            host_is = "exact" if exact else "late "
            print(f"\n  {host_is} host, H {per * 1e-7:.0e} s: velocity {velocity:.1e} V0, work {work:.1e} KE0", end="")
    order = math.log10(result[True, 100][0] / result[True, 1][0]) / 2.0
    print(f"\n  order in H from 1e-7 to 1e-5 s: {order:.2f}")
    return result, order


def test_before_the_first_failure():
    failed = lambda host: host.get("fabric.failed_segments") > 0
    result, order = compare(40.0, 2e-8, 3e-4, failed)
    for exact in (False, True):
        assert result[exact, 1][0] < 1e-5
        assert result[exact, 1][1] < 1e-4
    assert order >= 1.0


def test_to_arrest():
    stopped = lambda host: host.get("state.velocity[3]") <= 0.0
    result, order = compare(5.0, 2e-8, 4e-4, stopped)
    assert result[True, 1][0] < 1e-5
    assert result[True, 1][1] < 1e-4
    assert order >= 1.0


def test_the_whole_event_lies_within_the_ensemble():
    speed, end = math.sqrt(2.0 * 40.0 / MASS), 2.5e-4
    absorbed = []
    for k in range(8):
        _rows, host = free(case(speed * (1.0 + k * 1e-12)), 1e-5, end)
        absorbed.append(host.get("contact.work"))
        status = host.get("status")
    mean = sum(absorbed) / 8
    spread = max(absorbed) - min(absorbed)
    deviation = math.sqrt(sum((a - mean) ** 2 for a in absorbed) / 7)
    _, host = driven(case(speed), 1e-7, end, exact=True)
    work, residual = host.get("contact.work"), host.get("interface.residual")
    print(f"\n  40 J, absorbed: 8 runs {mean:.4f} J, range {spread:.4f} J, standard deviation {deviation:.4f} J, status {status}")
    print(f"  prescribed at H = 1e-7 s: {work:.4f} J, interface residual {residual:.2e} J")
    assert abs(work - mean) < 2.0 * deviation
    assert abs(residual) < 1e-6 * 40.0


def test_both_versions_give_the_same_bits():
    values = {**SMALL, "projectile.start.velocity[3]": 60.0}
    results = []
    for version in (2, 3):
        rows, host = driven(values, 1e-6, 3e-5, version)
        results.append((rows, host.outputs()))
    assert results[0] == results[1]


def test_a_host_that_does_not_slow_down_is_warned_of_once(version):
    host = Host(version, {**SMALL, "projectile.start.velocity[3]": 60.0, "projectile.mass": 1e-3, "drive": PRESCRIBED})
    for k in range(100):
        host.set(projectile__position=[0.0, 0.0, -RADIUS - 1e-5 + 60.0 * k * 1e-6], projectile__velocity=[0.0, 0.0, 60.0])
        assert host.status_of_step(k * 1e-6, 1e-6) == OK
        open_by = abs(host.get("interface.residual")) > 0.01 * 0.5 * 1e-3 * 60.0**2
        told = [line[:2] for line in host.log if line[2].startswith("interface.residual: host and fabric differ")]
        assert told == [(1, "logStatusWarning")] * open_by
    assert open_by


def test_bad_input_is_discarded_and_nothing_changes():
    place, speed = [0.0, 0.0, -RADIUS - 1e-5], [0.0, 0.0, 60.0]
    good = {"projectile.position": place, "projectile.velocity": speed, "projectile.orientation": [1.0, 0.0, 0.0, 0.0]}
    bad = [
        ("projectile.position", [0.0, math.nan, 0.0]),  # `test_inputs` has all that are no numbers
        ("projectile.orientation", [1.1, 0.0, 0.0, 0.0]),
        ("projectile.position", [0.0, 0.0, 1e-3]),  # a teleport
        ("projectile.velocity", [0.0, 0.0, 1e6]),
    ]
    for version in (2, 3):
        results = []
        for disturbed in (False, True):
            host = Host(version, {**SMALL, "projectile.start.velocity[3]": 60.0, "drive": PRESCRIBED})
            for name, value in good.items():
                host.try_set(name, value)
            for k in range(10):
                here = {**good, "projectile.position": [0.0, 0.0, place[2] + 60.0 * k * 1e-6]}
                if disturbed:
                    for name, value in bad:
                        usual = host.get(name)
                        host.try_set(name, value)
                        assert host.step(k * 1e-6, 1e-6) == DISCARD, (name, value, host.log)
                        assert name in host.log[-1][2]
                        host.try_set(name, usual)
                for name, value in here.items():
                    host.try_set(name, value)
                assert host.step(k * 1e-6, 1e-6) == OK
            results.append(host.outputs())
        assert results[0] == results[1]


def test_a_pose_slightly_off_is_shown_and_nothing_else():
    host = Host(2, {**SMALL, "drive": PRESCRIBED})
    host.set(projectile__position=[0.0, 1e-4, -RADIUS - 1e-5], projectile__velocity=[0.0, 0.0, 100.0])
    assert host.status_of_step(0.0, 1e-6) == OK
    assert abs(host.get("interface.gap") - 1e-4) < 5e-13
    assert [text for status, _, text in host.log if status != OK] == []
    host.set(projectile__position=[0.0, 1e-3, -RADIUS - 1e-5])
    assert host.step(1e-6, 1e-6) == DISCARD
    assert host.said("m from where the fabric has the body, (0, 1e-4, -6.26e-3) m; the limit is sheet.spacing, 7.25"), host.log


def test_a_quaternion_of_nearly_unit_length_is_taken_without_a_warning():
    """A host that integrates one gives such in every step: it is normalised, and said once, to a host that wants events."""
    for logging in (False, True):
        host = Host(2, {**SMALL, "drive": PRESCRIBED}, logging_on=logging)
        before = len(host.log)
        for k in range(3):
            turned = [1.0 + 1e-6, 0.0, 0.0, 0.0]
            velocity = [0.0, 0.0, 100.0]
            host.set(
                projectile__position=host.get("state.position"), projectile__velocity=velocity, projectile__orientation=turned
            )
            assert host.status_of_step(k * 1e-6, 1e-6) == OK
        said = [text for status, _, text in host.log[before:] if "normalised" in text]
        assert len(said) == (1 if logging else 0), host.log
        assert {status for status, _, _ in host.log[before:]} - {OK} == set()
