"""Each function of both versions in each state, as calls/states.inc has it, and bad arguments; the host's
floating-point environment.

The programs are built against the official headers (those that FMPy brings) and linked with the library itself.
"""

import pathlib
import platform
import shutil
import subprocess
import tempfile
import unittest

import fmpy
from host import library, opened

HEADERS = pathlib.Path(fmpy.__file__).parent / "c-code"
SOURCES = pathlib.Path(__file__).parent / "calls"


def build(source, version, folder, *options):
    """Builds a C host that is linked with the FMU's library; returns the program."""
    program = pathlib.Path(folder, pathlib.Path(source).stem)
    warnings = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["cc", *warnings, f"-I{HEADERS}", source, library(version), *options, "-o", program], check=True)
    return program


class Calls(unittest.TestCase):
    def check(self, *under):
        for version in (2, 3):
            token = opened(version)[0].guid
            with tempfile.TemporaryDirectory() as folder:
                program = build(SOURCES / f"calls{version}.c", version, folder, "-g")
                run = subprocess.run([*under, program, token], capture_output=True, text=True)
            print(f"\nfigure 24: FMI {version}.0: {run.stdout.strip()}", flush=True)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_every_call_in_every_state(self):
        self.check()

    @unittest.skipUnless(shutil.which("valgrind"), "valgrind is not installed")
    def test_no_byte_is_misread_or_lost(self):
        self.check("valgrind", "--quiet", "--leak-check=full", "--error-exitcode=9")

    @unittest.skipUnless(platform.machine() == "x86_64", "the C host sets x86's control register")
    def test_a_changed_environment_changes_no_bit_and_comes_back(self):
        with tempfile.TemporaryDirectory() as folder:
            # -O0: the compiler must not move the steps' arguments across the change.
            program = build(pathlib.Path(__file__).with_name("environment.c"), 2, folder, "-O0")
            run = subprocess.run([program, opened(2)[0].guid], check=True, capture_output=True, text=True)
        usual, *changed = run.stdout.split()
        self.assertEqual(changed, [usual] * 5)
        self.assertGreater(float.fromhex(usual), 0.0)
