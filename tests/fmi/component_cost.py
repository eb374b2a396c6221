"""What a communication step and a node-step cost in the component and in the native library: python tests/fmi/component_cost.py

Both are driven from Python, the component by wasmtime and the library by FMPy: a call without work tells what of a step is the host's.
The least of some runs is printed, in time of the processor."""

import os
import time

from host import SMALL, Host

TICK = 2e-8
RUNS = 7


def least(work, count):
    """Seconds of one of `count` times that `work` does."""
    times = []
    for _ in range(RUNS):
        start = time.process_time()
        work()
        times.append((time.process_time() - start) / count)
    return min(times)


def steps(host, count, ticks):
    """Does steps from where the host is."""
    for _ in range(count):
        assert host.step(host.t, ticks * TICK) == 0, host.log
        host.t = host.last[3]


def measured(component):
    """Seconds of a call without work, of a step of one tick of 6 x 6 nodes, and of a node-step of 105 x 105 nodes."""
    few = {**SMALL, "sheet.nodes_x": 6, "sheet.nodes_y": 6}
    many = {**SMALL, "sheet.nodes_x": 105, "sheet.nodes_y": 105}
    small, large = (Host(3, values, logging_on=False, component=component) for values in (few, many))
    small.t = large.t = 0.0
    call = least(lambda: [small.fmu.getFloat64([0]) for _ in range(500)], 500)
    step = least(lambda: steps(small, 500, 1), 500)
    steps(large, 1, 1000)  # until the waves have reached the sides
    node = least(lambda: steps(large, 1, 200), 200 * 105 * 105)
    return call, step, node


if __name__ == "__main__":
    native, component = measured(False), measured(True)
    names = ["a call without work, us", "a communication step of one tick, 6 x 6 nodes, us", "a node-step, 105 x 105 nodes, ns"]
    for name, one, other, unit in zip(names, native, component, (1e6, 1e6, 1e9)):
        print(f"{name}: library {one * unit:.2f}, component {other * unit:.2f}, {other / one:.2f} times as long")
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
