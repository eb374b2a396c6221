"""Ensembles on a Dask cluster: a real scheduler and workers on this machine, some of which are killed."""

import contextlib
import hashlib
import os
import pathlib
import platform
import shutil
import socket
import subprocess
import sys

import fabric_kernel as fk
import pytest
from commands import called, wait_for
from fabric_kernel import _kernel, results
from fabric_kernel.ensembles import kept
from test_ensembles import FORTY as SCENES
from test_ensembles import forty, lines
from test_own_tests import small

compare = sys.modules["fabric_kernel.compare"]
# A worker of one thread.
ONE = ["--nthreads", "1", "--no-dashboard", "--no-nanny", "--death-timeout", "60"]


class Cluster:
    """A scheduler and two workers; `processes` ends them."""

    def __init__(self, folder, processes):
        self.folder, self.processes = folder, processes
        self.keep = self.folder / "runs.jsonl"
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        self.scheduler = self.start("scheduler", "--host", self.address, "--dashboard-address", "127.0.0.1:0")
        self.workers = [self.start("worker", self.address, *ONE, "--local-directory", str(self.folder)) for _ in range(2)]

    def start(self, *arguments, path=""):
        with (self.folder / "log").open("a") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]],
                stdout=log,
                stderr=log,
                env=os.environ | {"PYTHONPATH": path},
            )
        self.processes.callback(process.wait)
        self.processes.callback(process.kill)
        return process

    def ensemble_in_the_background(self):
        """Call in a process of its own, so that this one can watch its file."""
        script = self.folder / "call.py"
        script.write_text(CALL)
        return subprocess.Popen([sys.executable, script, self.address, self.keep], stderr=subprocess.PIPE, text=True)

    def with_another_build(self):
        """A worker whose library differs by a byte."""
        package = pathlib.Path(fk.__file__).parent
        shutil.copytree(
            package, self.folder / "other/fabric_kernel", ignore=shutil.ignore_patterns("__pycache__"), dirs_exist_ok=True
        )
        library = next((self.folder / "other/fabric_kernel").glob("_kernel*" + pathlib.Path(_kernel.__file__).suffix))
        library.write_bytes(library.read_bytes() + b"x")
        build = hashlib.sha256(library.read_bytes()).hexdigest()
        return self.start(
            "worker", self.address, *ONE, "--local-directory", str(self.folder), path=str(self.folder / "other")
        ), build

    def workers_of(self, count):
        """A client that knows so many workers."""
        from distributed import Client

        client = Client(self.address)
        self.processes.callback(client.close)
        client.wait_for_workers(count, timeout=60)
        return client


@pytest.fixture
def cluster(tmp_path):
    with contextlib.ExitStack() as processes:
        yield Cluster(tmp_path, processes)


def test_a_worker_that_is_killed_loses_nothing(cluster):
    call = cluster.ensemble_in_the_background()
    wait_for(lambda: lines(cluster.keep) >= 5)
    cluster.workers[0].kill()
    assert lines(cluster.keep) < len(SCENES)
    _, said = call.communicate(timeout=120)
    assert call.returncode == 0, said
    assert lines(cluster.keep) == len(SCENES)
    assert fk.ensemble(SCENES, keep=cluster.keep).equals(forty())
    # A client of the caller's own, and tasks of several runs.
    from distributed import Client

    with Client(cluster.address) as client:
        assert fk.ensemble(SCENES, on=client, batch=7).equals(forty())


def test_a_scheduler_that_is_lost(cluster):
    call = cluster.ensemble_in_the_background()
    wait_for(lambda: lines(cluster.keep) >= 5)
    cluster.scheduler.kill()
    _, said = call.communicate(timeout=120)
    assert call.returncode == 1, said
    left = lines(cluster.keep)
    assert left < len(SCENES)
    assert f"ClusterLost: the scheduler {cluster.address} is lost after {left} of 40 runs; they are in {cluster.keep}" in said
    table = fk.ensemble(SCENES, keep=cluster.keep)
    assert lines(cluster.keep) == len(SCENES)
    assert table.equals(forty())


def test_a_worker_of_another_build_is_refused_by_its_address(cluster):
    for worker in cluster.workers:
        worker.kill()
        worker.wait()
    _, build = cluster.with_another_build()
    client = cluster.workers_of(1)
    with pytest.raises(
        RuntimeError, match=f"the worker tcp://.* has another build of fabric_kernel: its library is {build[:16]}"
    ):
        fk.ensemble(SCENES, on=client, keep=cluster.keep)
    assert lines(cluster.keep) == 0


def test_a_worker_of_another_build_that_comes_later_is_refused_in_its_first_task(cluster):
    call = cluster.ensemble_in_the_background()
    wait_for(lambda: lines(cluster.keep) >= 2)
    _, build = cluster.with_another_build()
    _, said = call.communicate(timeout=120)
    if call.returncode == 0:
        pytest.skip("the others were done before it came")
    assert f"has another build of fabric_kernel: its library is {build[:16]}" in said
    assert f"the worker on {platform.node()}" in said
    # What was kept came from the others.
    rows = dict(kept(cluster.keep))
    table = forty().set_index("key")
    assert len(rows) > 0
    for key, row in rows.items():
        assert row["digest"] == table.loc[key, "digest"]


def test_a_refused_scene_is_refused_here(cluster):
    bad = SCENES[0].replace({"projectile.mass": -1.0})
    with pytest.raises(fk.Refused) as refused:
        fk.ensemble([*SCENES[:3], bad], on=cluster.address)
    assert refused.value.field == "projectile.mass"


def test_shields_are_compared_on_a_cluster_as_they_are_here(cluster, tmp_path):
    files = [str(tmp_path / f"p{plies}.toml") for plies in (1, 2, 3)]
    for plies, file in zip((1, 2, 3), files):
        pathlib.Path(file).write_text(small(plies).to_toml())
    words = "--shots", "6", "--no-network"
    _, errors, code = called(tmp_path, compare.main, *files, *words, "--on", cluster.address)
    assert (code, "error" in errors) == (0, False)
    assert lines(tmp_path / "out/runs.jsonl") == 3
    assert called(tmp_path, compare.main, *files, *words, out="here")[2] == 0
    found, here = (results.read(compare.Comparison, tmp_path / folder / "compare.json") for folder in ("out", "here"))
    assert (found.shields, found.pairs) == (here.shields, here.pairs)


def test_no_scheduler_at_the_address():
    import dask

    nobody = "there is no scheduler at tcp://127.0.0.1:1 after 0 of 40 runs"
    impatient = dask.config.set({"distributed.comm.timeouts.connect": "1s"})
    with impatient, pytest.raises(fk.ClusterLost, match=nobody):
        fk.ensemble(SCENES, on="tcp://127.0.0.1:1")


CALL = """
import sys
import fabric_kernel as fk
scenes = fk.vary(fk.Scene(sheet={"nodes_x": 41, "nodes_y": 41}), 40, seed=2)
fk.ensemble(scenes, on=sys.argv[1], keep=sys.argv[2])
"""
