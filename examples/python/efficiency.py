"""How well an ensemble uses its workers: measured on this machine, and on paper for a cluster of 1000.

A worker that only waits takes no processor, so a few processes can stand for many workers: what is measured then is the scheduler.
Run it with the package and its extra `dask` installed: python examples/python/efficiency.py
"""

import functools
import pickle
import statistics
import time

import fabric_kernel as fk
from fabric_kernel import ensembles

SHEET = {"nodes_x": 105, "nodes_y": 105}
RUNS = 24
ROUNDS = 3
WAITING = 1000
# Of a message from the scheduler to a worker and back, s: a guess for one network.
LATENCY = 2e-3


def wait(seconds, number):
    time.sleep(seconds)
    return [(f"{number:032x}", "x" * 700)]


def seconds(work):
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def main():
    from distributed import Client, LocalCluster, as_completed

    scenes = fk.vary(fk.Scene(sheet=SHEET), RUNS, seed=1, speed=80.0, point=(0.0, 0.0))
    fk.ensemble(scenes[:2], on=2, progress=False)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        fk.ensemble(scenes[:2], on=cluster, progress=False)
        # In turn, because what else the machine does changes with time.
        places = {"1 process": (1, 1), "2 processes": (2, 2), "2 Dask workers": (2, cluster)}
        times = {name: [] for name in ["alone", *places]}
        for _ in range(ROUNDS):
            times["alone"].append(seconds(lambda: [fk.fly(scene) for scene in scenes]))
            for name, (_, on) in places.items():
                times[name].append(seconds(lambda: fk.ensemble(scenes, on=on, progress=False)))
    taken = {name: statistics.median(each) for name, each in times.items()}
    alone = taken["alone"] / RUNS
    print(f"one run: {1e3 * alone:.0f} ms")
    for name, (workers, _) in places.items():
        rate = RUNS / taken[name]
        print(f"{name}: {rate:.2f} runs a second, efficiency {rate * alone / workers:.2f}")

    task = [(ensembles.run_key(scenes[0]), scenes[0])]
    work = functools.partial(ensembles._work, fk.VERSION, ensembles.UNTIL, ensembles.STEPS)
    there, back = len(pickle.dumps((work, task))), len(pickle.dumps(work(task)))
    print(f"bytes of a task of one run: {there} to the worker, {back} back")

    with LocalCluster(n_workers=2, threads_per_worker=WAITING // 2, dashboard_address=None) as cluster, Client(cluster) as client:

        def many(tasks, each):
            futures = [client.submit(wait, each, number, pure=False) for number in range(tasks)]
            for future in as_completed(futures):
                future.result()

        many(200, 0.0)
        overhead = seconds(lambda: many(2000, 0.0)) / 2000
        print(f"scheduler and client: {1e3 * overhead:.2f} ms for a task")
        for each in (1.0, 4.0):
            tasks = 3 * WAITING
            taken = seconds(lambda: many(tasks, each))
            ideal = tasks * each / WAITING
            print(f"{WAITING} workers that wait {each:g} s: {tasks / taken:.0f} tasks a second, efficiency {ideal / taken:.2f}")
    print(f"on paper, 1000 workers, {1e3 * LATENCY:g} ms latency, runs of {alone:.2f} s:")
    for batch in (1, 4, 16, 64):
        each = batch * alone
        rate = min(1000 / (each + LATENCY), 1.0 / overhead) * batch
        print(f"  batch {batch}: {rate:.0f} runs a second, efficiency {rate * alone / 1000:.2f}")


if __name__ == "__main__":
    main()
