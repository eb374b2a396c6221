"""Saved states: rollback in the middle of contact, in the same and in another process."""

import pathlib
import subprocess
import sys

import pytest
from fmpy.fmi1 import FMICallException
from host import OK, SMALL, Host, opened
from test_calls import build

CYLINDER = {"sheet.nodes_x": 41, "sheet.nodes_y": 41, "attachment.kind": 1, "projectile.start.position[3]": -0.01906}


@pytest.mark.parametrize("values", (SMALL, CYLINDER))
def test_rollback_during_contact(version, values):
    host = Host(version, values).run(0, 10, 1e-6)
    assert host.get("contact.work") > 0.0
    state = host.save()
    middle = host.bytes_of(state)
    end = host.run(10, 20, 1e-6).image()
    assert host.restore(state) == OK
    assert host.image() == middle
    assert host.run(10, 20, 1e-6).image() == end
    assert host.free(state) == OK


def test_another_process_goes_on_with_the_same_bits(version, tmp_path):
    host, before, after = Host(version, SMALL).run(0, 10, 1e-6), tmp_path / "before", tmp_path / "after"
    before.write_bytes(host.image())
    subprocess.run([sys.executable, __file__, str(version), before, after], check=True)
    assert after.read_bytes() == host.run(10, 20, 1e-6).image()


def test_an_image_of_one_version_goes_on_in_the_other():
    two, three = Host(2, SMALL).run(0, 10, 1e-6), Host(3)
    assert three.restore(three.state_of(two.image())) == OK
    assert three.run(10, 20, 1e-6).image() == two.run(10, 20, 1e-6).image()


def test_altered_bytes_are_refused(version):
    host = Host(version, SMALL).run(0, 5, 1e-6)
    data = host.image()

    def refused(bad, words):
        del host.log[:]
        with pytest.raises(FMICallException):
            host.state_of(bad)
        assert host.said(words), host.log

    for length in (0, 1, 8, 32, 100, len(data) // 2, len(data) - 8, len(data) - 1):
        refused(data[:length], "altered, or none" if length < 32 else f"it has {length} bytes, needed are {len(data)}")
    refused(data + bytes(8), f"it has {len(data) + 8} bytes, needed are {len(data)}")
    refused(b"x" * 64, "altered, or none")
    header = 4 * 8  # magic, version, token, length
    for place in [*range(header), *range(header, len(data), len(data) // 200)]:
        flipped = data[:place] + bytes([data[place] ^ (1 << place % 8)]) + data[place + 1 :]
        refused(flipped, "another version" if 8 <= place < 24 else "needed are" if 24 <= place < 32 else "altered, or none")
    assert host.image() == data
    assert host.restore(host.state_of(data)) == OK


def test_memory_is_used_again(tmp_path):
    program = build(pathlib.Path(__file__).with_name("memory.c"), 2, tmp_path)
    run = subprocess.run([program, opened(2)[0].guid], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    states, instances = map(int, run.stdout.split())
    print(f"\n  growth over 1000 saved states {states} kB, over 1000 instances {instances} kB", end=" ")
    assert max(states, instances) < 1024


def test_two_threads_do_not_disturb_each_other():
    import threading

    expected = Host(2, SMALL).run(0, 30, 1e-6).image()
    images = {}
    work = lambda k: images.setdefault(k, Host(2, SMALL).run(0, 30, 1e-6).image())
    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert [images[0], images[1]] == [expected] * 2


def test_a_state_from_before_initialisation():
    host = Host(2)
    state = host.save()
    host.initialise(SMALL)
    host.run(0, 5, 1e-6)
    assert host.restore(state) == OK
    host.initialise(SMALL)
    host.run(0, 5, 1e-6)


if __name__ == "__main__":
    # The other process: instantiates, restores without any initialisation, and steps on.
    host, (before, after) = Host(int(sys.argv[1])), map(pathlib.Path, sys.argv[2:])
    assert host.restore(host.state_of(before.read_bytes())) == OK, host.log
    after.write_bytes(host.run(10, 20, 1e-6).image())
