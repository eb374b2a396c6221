"""A capsule in the host's log: `fabric replay` does again what the host did, and finds the same bits."""

import pathlib
import re
import subprocess
import sys

from host import OK, SMALL, Host

TOP = pathlib.Path(__file__).parents[2]
REPLAY = [sys.executable, "-m", "fabric_kernel.program", "replay"]


def replayed(host, file):
    """What is printed of the host's log, as a host would write it to a file."""
    file.write_text("".join(f"[{status}] {category}: {message}\n" for status, category, message in host.log))
    return subprocess.run([*REPLAY, str(file)], cwd=TOP, capture_output=True, text=True, check=False)


def test_steps_loads_and_a_rollback(version, tmp_path):
    host = Host(version, {**SMALL, "capsule": True}).run(0, 10, 1e-6)
    state = host.save()
    host.set(**({"external.force[2]": 0.5} if host.version == 2 else {"external.force": [0.0, 0.5, 0.0]}))
    host.run(10, 20, 1e-6)
    assert host.restore(state) == OK
    host.run(10, 14, 1e-6)
    log = tmp_path / "host.log"
    # As a crash leaves it, and ended.
    assert re.search(r"same bits: 49 calls, \d+ steps, 1 digests, .*\n.*its program did not end it", replayed(host, log).stdout)
    host.fmu.terminate()
    found = replayed(host, log)
    assert (found.returncode, found.stderr.count("error")) == (0, 0), found.stderr
    assert re.search(r"same bits: 49 calls, \d+ steps, 2 digests, .*[0-9a-f]{16}\n", found.stdout)
    size = sum(len(message) for _, category, message in host.log if category == "logCapsule")
    print(f"\nFMI {host.version}: {size} letters of capsule, the state of the rollback among them", end=" ", flush=True)


def test_none_unless_asked_for(version):
    host = Host(version, SMALL).run(0, 2, 1e-6)
    assert not host.said("capsule: ")
