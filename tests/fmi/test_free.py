"""Drive free: the same bits whatever the version, the step size and the neighbours."""

import math

from host import ERROR, OK, OUTPUTS, SMALL, Host, hosts

END = 4e-5  # s; the sheet is torn by then
DT = 2e-8  # s; the internal step


def test_both_versions_give_the_same_bits():
    results = []
    for host in hosts(SMALL):
        rows = [host.outputs()]
        for k in range(40):
            host.run(k, k + 1, 1e-6)
            rows.append(host.outputs())
        results.append(rows)
    assert results[0] == results[1]
    assert results[0][-1]["contact.work"] > 1.0


def test_times_summed_up_are_accepted():
    """A hundred thousand steps."""
    host, t, h = Host(2, SMALL, stop=1e-4), 0.0, 1e-9
    for _ in range(100000):
        assert host.step(t, h) == OK
        t += h
    other = Host(2, SMALL).run(0, 100, 1e-6)
    assert t != 100000 * h
    assert host.get("state.position") == other.get("state.position")
    assert host.step(t, 1e-6) == ERROR
    assert host.said("stop time")


def test_every_step_and_way_of_counting_time_gives_the_same_bits():
    """As masters do it: products, sums, whole nanoseconds, differences of times, and a start far from zero. Step means differ
    by nature."""

    def products(k, h, start):
        return start + k * h, h

    def differences(k, h, start):
        return start + k * h, (start + (k + 1) * h) - (start + k * h)

    def nanoseconds(k, h, start):
        whole = round(h * 1e9)
        return (round(start * 1e9) + k * whole) * 1e-9, whole * 1e-9

    def sums(k, h, start):
        t = start
        for _ in range(k):
            t += h
        return t, h

    for version in (2, 3):
        results = []
        for start in (0.0, 10.0, -1000.0):
            for counted in (products, differences, nanoseconds, sums):
                for h in (1e-7, 5e-7, 1e-6, 1e-5) if start == 0.0 else (1e-7, 1e-6):
                    host = Host(version, SMALL, start=start, stop=start + END)
                    for k in range(round(END / h)):
                        assert host.step(*counted(k, h, start)) == OK, (start, counted.__name__, h, k, host.log)
                    results.append({name: host.get(name) for name in OUTPUTS if not name.endswith(("_time", "_mean"))})
        for result in results[1:]:
            assert result == results[0]


def test_odd_and_tiny_steps():
    for h, steps in [(3.3e-8, 300), (1e-9, 2000), (2e-8, 500)]:
        host, total, ticks = Host(3, SMALL), [0.0] * 3, 0
        for k in range(steps):
            assert host.step(k * h, h) == OK
            # The mean is over the internal steps; without any it stays as it was.
            taken = math.floor((k * h + h) / DT + 0.5) - ticks
            ticks += taken
            total = [a + f * taken * DT for a, f in zip(total, host.get("contact.force_mean"))]
        impulse = host.get("contact.impulse")
        size = sum(x * x for x in impulse) ** 0.5
        assert max(abs(a - b) for a, b in zip(total, impulse)) <= 1e-12 * max(size, 1e-30)


def test_the_impulse_is_the_change_of_momentum():
    host = Host(2, SMALL).run(0, 40, 1e-6)
    mass, v = host.get("projectile.mass"), host.get("state.velocity")
    change = mass * (v[2] - 100.0)
    assert abs(host.get("contact.impulse")[2] - change) < 1e-9 * abs(change)


def test_reset_and_interleaved_instances(version):
    plain = Host(version, SMALL).run(0, 30, 1e-6)
    expected = plain.image()
    plain.fmu.reset()
    plain.initialise(SMALL)
    plain.run(0, 30, 1e-6)
    assert plain.image() == expected
    first, second = Host(version, SMALL), Host(version, {**SMALL, "seed": 2})
    for k in range(30):
        first.run(k, k + 1, 1e-6)
        second.run(k, k + 1, 1e-6)
    assert first.image() == expected
    assert second.image() != expected
