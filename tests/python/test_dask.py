"""Ensembles on a Dask cluster: a real scheduler and workers on this machine, some of which are killed."""

import hashlib
import os
import pathlib
import platform
import shutil
import socket
import subprocess
import sys
import unittest

import fabric_kernel as fk
from commands import InFolder, wait_for
from fabric_kernel import _kernel
from fabric_kernel.ensembles import kept
from test_ensembles import FORTY as SCENES
from test_ensembles import forty, lines

# A worker of one thread.
ONE = ["--nthreads", "1", "--no-dashboard", "--no-nanny", "--death-timeout", "60"]


class Dask(InFolder):
    def setUp(self):
        super().setUp()
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
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def ensemble_in_the_background(self):
        """The same call in a process of its own, so that this one can watch its file."""
        script = self.folder / "call.py"
        script.write_text(CALL)
        return subprocess.Popen([sys.executable, script, self.address, self.keep], stderr=subprocess.PIPE, text=True)

    def test_a_worker_that_is_killed_loses_nothing(self):
        call = self.ensemble_in_the_background()
        wait_for(lambda: lines(self.keep) >= 5)
        self.workers[0].kill()
        self.assertLess(lines(self.keep), len(SCENES))
        _, said = call.communicate(timeout=120)
        self.assertEqual(call.returncode, 0, said)
        self.assertEqual(lines(self.keep), len(SCENES))
        self.assertTrue(fk.ensemble(SCENES, keep=self.keep).equals(forty()))
        # A client of the caller's own, and tasks of several runs.
        from distributed import Client

        with Client(self.address) as client:
            self.assertTrue(fk.ensemble(SCENES, on=client, batch=7).equals(forty()))

    def test_a_scheduler_that_is_lost(self):
        call = self.ensemble_in_the_background()
        wait_for(lambda: lines(self.keep) >= 5)
        self.scheduler.kill()
        _, said = call.communicate(timeout=120)
        self.assertEqual(call.returncode, 1, said)
        left = lines(self.keep)
        self.assertLess(left, len(SCENES))
        self.assertIn(f"ClusterLost: the scheduler {self.address} is lost after {left} of 40 runs; they are in {self.keep}", said)
        table = fk.ensemble(SCENES, keep=self.keep)
        self.assertEqual(lines(self.keep), len(SCENES))
        self.assertTrue(table.equals(forty()))

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
        self.addCleanup(client.close)
        client.wait_for_workers(count, timeout=60)
        return client

    def test_a_worker_of_another_build_is_refused_by_its_address(self):
        for worker in self.workers:
            worker.kill()
            worker.wait()
        _, build = self.with_another_build()
        client = self.workers_of(1)
        with self.assertRaisesRegex(
            RuntimeError, f"the worker tcp://.* has another build of fabric_kernel: its library is {build[:16]}"
        ):
            fk.ensemble(SCENES, on=client, keep=self.keep)
        self.assertEqual(lines(self.keep), 0)

    def test_a_worker_of_another_build_that_comes_later_is_refused_in_its_first_task(self):
        call = self.ensemble_in_the_background()
        wait_for(lambda: lines(self.keep) >= 2)
        _, build = self.with_another_build()
        _, said = call.communicate(timeout=120)
        if call.returncode == 0:
            self.skipTest("the others were done before it came")
        self.assertIn(f"has another build of fabric_kernel: its library is {build[:16]}", said)
        self.assertIn(f"the worker on {platform.node()}", said)
        # What was kept came from the others.
        rows = dict(kept(self.keep))
        table = forty().set_index("key")
        self.assertGreater(len(rows), 0)
        for key, row in rows.items():
            self.assertEqual(row["digest"], table.loc[key, "digest"])

    def test_a_refused_scene_is_refused_here(self):
        bad = SCENES[0].replace({"projectile.mass": -1.0})
        with self.assertRaises(fk.Refused) as refused:
            fk.ensemble([*SCENES[:3], bad], on=self.address)
        self.assertEqual(refused.exception.field, "projectile.mass")


class NoScheduler(unittest.TestCase):
    def test_no_scheduler_at_the_address(self):
        import dask

        nobody = "there is no scheduler at tcp://127.0.0.1:1 after 0 of 40 runs"
        impatient = dask.config.set({"distributed.comm.timeouts.connect": "1s"})
        with impatient, self.assertRaisesRegex(fk.ClusterLost, nobody):
            fk.ensemble(SCENES, on="tcp://127.0.0.1:1")


CALL = """
import sys
import fabric_kernel as fk
scenes = fk.vary(fk.Scene(sheet={"nodes_x": 41, "nodes_y": 41}), 40, seed=2)
fk.ensemble(scenes, on=sys.argv[1], keep=sys.argv[2])
"""
