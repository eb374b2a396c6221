"""Ensembles on a Dask cluster: a real scheduler and workers on this machine, some of which are killed."""

import pathlib
import socket
import subprocess
import sys
import tempfile
import unittest

import fabric_kernel as fk
from test_ensembles import FORTY as SCENES
from test_ensembles import forty, lines, wait_for


class Dask(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.keep = self.folder / "runs.jsonl"
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        self.scheduler = self.start("scheduler", "--host", self.address, "--dashboard-address", "127.0.0.1:0")
        one = ["--nthreads", "1", "--no-dashboard", "--no-nanny", "--death-timeout", "60", "--local-directory", str(self.folder)]
        self.workers = [self.start("worker", self.address, *one) for _ in range(2)]

    def start(self, *arguments):
        with (self.folder / "log").open("a") as log:
            process = subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]], stdout=log, stderr=log)  # fmt: skip
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

    def test_a_refused_scene_is_refused_here(self):
        bad = SCENES[0].replace({"projectile.mass": -1.0})
        with self.assertRaises(fk.Refused) as refused:
            fk.ensemble([*SCENES[:3], bad], on=self.address)
        self.assertEqual(refused.exception.field, "projectile.mass")


class NoScheduler(unittest.TestCase):
    def test_no_scheduler_at_the_address(self):
        import dask

        with dask.config.set({"distributed.comm.timeouts.connect": "1s"}):
            with self.assertRaisesRegex(fk.ClusterLost, "there is no scheduler at tcp://127.0.0.1:1 after 0 of 40 runs"):
                fk.ensemble(SCENES, on="tcp://127.0.0.1:1")


CALL = """
import sys
import fabric_kernel as fk
scenes = fk.vary(fk.Scene(sheet={"nodes_x": 41, "nodes_y": 41}), 40, seed=2)
fk.ensemble(scenes, on=sys.argv[1], keep=sys.argv[2])
"""

if __name__ == "__main__":
    unittest.main()
