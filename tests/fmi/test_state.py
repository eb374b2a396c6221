"""Saved states: rollback in the middle of contact, in the same and in another process."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

from host import OK, SMALL, Host

CYLINDER = {
    "sheet.nodes_x": 41, "sheet.nodes_y": 41, "attachment.kind": 1,
    "projectile.position": [0.0, 0.0, -0.01906],
}  # fmt: skip


class State(unittest.TestCase):
    def test_rollback_during_contact(self):
        for version in (2, 3):
            for values in (SMALL, CYLINDER):
                with self.subTest(version=version, values=values):
                    host = Host(version, values).run(0, 10, 1e-6)
                    self.assertGreater(host.get("contact.work"), 0.0)
                    state = host.save()
                    middle = host.bytes_of(state)
                    end = host.run(10, 20, 1e-6).image()
                    self.assertEqual(host.restore(state), OK)
                    self.assertEqual(host.image(), middle)
                    self.assertEqual(host.run(10, 20, 1e-6).image(), end)
                    self.assertEqual(host.free(state), OK)
                    host.close()

    def test_another_process_goes_on_with_the_same_bits(self):
        for version in (2, 3):
            host = Host(version, SMALL).run(0, 10, 1e-6)
            with tempfile.TemporaryDirectory() as folder:
                before, after = pathlib.Path(folder, "before"), pathlib.Path(folder, "after")
                before.write_bytes(host.image())
                subprocess.run([sys.executable, __file__, str(version), before, after], check=True)
                self.assertEqual(after.read_bytes(), host.run(10, 20, 1e-6).image())
            host.close()

    def test_altered_bytes_are_refused(self):
        for version in (2, 3):
            host = Host(version, SMALL).run(0, 5, 1e-6)
            data = host.image()
            half = len(data) // 2
            flipped = data[:half] + bytes([data[half] ^ 4]) + data[half + 1 :]
            for bad in (data[:-8], data[:100], data + b"\0" * 8, flipped, b"x" * 64):
                with self.assertRaises(Exception):
                    host.state_of(bad)
            self.assertEqual(host.image(), data)
            self.assertEqual(host.restore(host.state_of(data)), OK)
            host.close()

    def test_memory_is_used_again(self):
        import resource
        from ctypes import byref

        host = Host(2, SMALL).run(0, 5, 1e-6)
        state = host.save()
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(1000):
            address = state.value
            host.fmu.fmi2GetFMUstate(host.fmu.component, byref(state))
            self.assertEqual(state.value, address)
        for _ in range(200):
            other = Host(2)
            other.close()
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, 4096)  # KiB
        host.close()

    def test_two_threads_do_not_disturb_each_other(self):
        import threading

        expected = Host(2, SMALL).run(0, 30, 1e-6).image()
        images = {}
        work = lambda k: images.setdefault(k, Host(2, SMALL).run(0, 30, 1e-6).image())
        threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        self.assertEqual([images[0], images[1]], [expected] * 2)

    def test_a_state_from_before_initialisation(self):
        host = Host(2)
        state = host.save()
        host.initialise(SMALL)
        host.run(0, 5, 1e-6)
        self.assertEqual(host.restore(state), OK)
        host.initialise(SMALL)
        host.run(0, 5, 1e-6)
        host.close()


def go_on(version, before, after):
    """The other process: instantiates, restores without any initialisation, and steps on."""
    host = Host(version)
    assert host.restore(host.state_of(pathlib.Path(before).read_bytes())) == OK, host.log
    pathlib.Path(after).write_bytes(host.run(10, 20, 1e-6).image())


if __name__ == "__main__":
    if len(sys.argv) == 4:
        go_on(int(sys.argv[1]), sys.argv[2], sys.argv[3])
    else:
        unittest.main()
