"""What a communication step and a node-step cost in the component and in the native library: python tests/fmi/component_cost.py

Both are driven from Python, the component by wasmtime and the library by FMPy: a call without work tells what of a step is the host's.
The least of some runs is printed, in time of the processor."""

import os
import time

from host import SMALL, Host

TICK, RUNS = 2e-8, 7


def least(count, work):
    """Seconds of one of `count` times that `work` does in a run."""
    times = []
    for _ in range(RUNS):
        start = time.process_time()
        work()
        times.append((time.process_time() - start) / count)
    return min(times)


def measured(component):
    """Seconds of a call without work, of a step of one tick of 6 x 6 nodes, and of a node-step of 105 x 105 nodes."""

    def steps(host, count, ticks):
        for _ in range(count):
            assert host.step(host.last[3], ticks * TICK) == 0, host.log

    scenes = ({**SMALL, "sheet.nodes_x": nodes, "sheet.nodes_y": nodes} for nodes in (6, 105))
    few, many = (Host(3, scene, logging_on=False, component=component) for scene in scenes)
    few.last = many.last = (False, False, False, 0.0)
    steps(many, 1, 1000)  # until the waves have reached the sides
    call = least(500, lambda: [few.fmu.getFloat64([0]) for _ in range(500)])
    return call, least(500, lambda: steps(few, 500, 1)), least(200 * 105**2, lambda: steps(many, 1, 200))


if __name__ == "__main__":
    names = ["a call without work, us", "a communication step of one tick, 6 x 6 nodes, us", "a node-step, 105 x 105 nodes, ns"]
    for name, one, other, unit in zip(names, measured(False), measured(True), (1e6, 1e6, 1e9)):
        print(f"{name}: library {one * unit:.2f}, component {other * unit:.2f}, {other / one:.2f} times as long")
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
