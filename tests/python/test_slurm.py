"""Ensembles and ballistic limits on SLURM: a controller and two nodes on this machine, of which a job is cancelled and a node set
down.

Left out where SLURM (Debian: slurm-wlm) or dask-jobqueue is not installed.
"""

import contextlib
import importlib.util
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import threading

import fabric_kernel as fk
import pytest
from commands import wait_for
from fabric_kernel.designs import Neyer
from fabric_kernel.v50 import Shooter, v50

SCENES = fk.vary(fk.Scene(sheet={"nodes_x": 41, "nodes_y": 41}), 60, seed=1, speed=80.0)
PROGRAMS = ("munged", "slurmctld", "slurmd", "scontrol", "scancel", "squeue", "sbatch")
MISSING = [name for name in PROGRAMS if not shutil.which(name)] + (
    [] if importlib.util.find_spec("dask_jobqueue") else ["dask-jobqueue"]
)
pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)}")
CONFIGURATION = """ClusterName=here
SlurmctldHost={host}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
SlurmctldPort={ports[0]}
StateSaveLocation={folder}/state
SlurmctldPidFile={folder}/slurmctld.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdPidFile={folder}/%n.pid
SlurmdLogFile={folder}/%n.log
SlurmdSpoolDir={folder}/spool-%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmdParameters=config_overrides
MpiDefault=none
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1 RealMemory=4000
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1 RealMemory=4000
PartitionName=all Nodes=ALL Default=YES State=UP
"""


def free_ports(count):
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


def said(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def jobs(node=None):
    """Numbers of the jobs that run, on a node if it is named."""
    rows = [line.split() for line in said("squeue", "--noheader", "--format", "%i %N", "--states", "RUNNING").splitlines()]
    return [number for number, *where in rows if node is None or where == [node]]


@pytest.fixture(scope="module")
def folder():
    """Where a controller and two nodes live."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name, contextlib.ExitStack() as processes:
        folder = pathlib.Path(name)
        nodes(folder, processes)
        yield folder


def nodes(folder, processes):
    folder.chmod(0o755)
    (folder / "munge").mkdir(mode=0o755)
    (folder / "state").mkdir()
    key, conf = folder / "key", folder / "slurm.conf"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o400)
    user = said("id", "--user", "--name").strip()
    conf.write_text(CONFIGURATION.format(host=socket.gethostname().split(".")[0], user=user, folder=folder, ports=free_ports(3)))
    os.environ["SLURM_CONF"] = str(conf)
    places = [f"--{name}={folder}/munge/{name}" for name in ("socket", "pid-file", "log-file", "seed-file")]
    daemons = [
        ["munged", "--foreground", "--force", f"--key-file={key}", *places],
        ["slurmctld", "-D"],
        ["slurmd", "-D", "-N", "n1"],
        ["slurmd", "-D", "-N", "n2"],
    ]
    for daemon in daemons:
        process = subprocess.Popen(daemon, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        processes.callback(process.wait)
        processes.callback(process.terminate)
        if daemon[0] == "munged":
            wait_for(lambda: (folder / "munge/socket").exists())
    idle = ["sinfo", "--noheader", "--format", "%A"]
    wait_for(lambda: subprocess.run(idle, capture_output=True, text=True, check=False).stdout.strip() == "0/2")


def slurm(folder):
    from dask_jobqueue import SLURMCluster

    folder = str(folder)
    return SLURMCluster(
        cores=1,
        processes=1,
        memory="1GB",
        walltime="00:10:00",
        interface="lo",
        local_directory=folder,
        log_directory=folder,
        python=sys.executable,
        scheduler_options={"dashboard_address": None},
    )


def test_a_cancelled_job_and_a_lost_node_lose_nothing(folder):
    keep, alone = folder / "runs.jsonl", fk.ensemble(SCENES, on=1, progress=False)
    lines = lambda: len(keep.read_text().splitlines()) if keep.exists() else 0
    with slurm(folder) as cluster:
        cluster.adapt(minimum_jobs=2, maximum_jobs=2, interval="500ms")
        wait_for(lambda: len(jobs()) == 2)
        answers = []
        call = threading.Thread(target=lambda: answers.append(fk.ensemble(SCENES, on=cluster, keep=keep, progress=False)))
        call.start()
        wait_for(lambda: lines() >= 5)
        said("scancel", jobs("n1")[0])
        before = lines()
        wait_for(lambda: lines() > before)
        said("scontrol", "update", "nodename=n2", "state=down", "reason=test")
        assert lines() < len(SCENES)
        call.join(120)
        said("scontrol", "update", "nodename=n2", "state=resume")
    print(f"\nSLURM: {lines()} rows of {len(SCENES)} runs, one job cancelled and one node down", end=" ", flush=True)
    assert lines() == len(SCENES)
    assert answers and answers[0].equals(alone), "the rows are those of one process"


def test_a_limit_is_a_task_for_each_scene(folder):
    from distributed import Client

    def limit(scene):
        return v50(Shooter(scene, seed=1), Neyer.bracketed(40.0), shots=6).fit.velocities

    with slurm(folder) as cluster, Client(cluster) as client:
        cluster.scale(jobs=2)
        assert client.gather(client.map(limit, SCENES[:2])) == [limit(scene) for scene in SCENES[:2]]
