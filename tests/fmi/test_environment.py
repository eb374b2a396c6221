"""The host's floating-point environment, in a C host against the official headers (those that FMPy brings)."""

import pathlib
import platform
import subprocess
import tempfile
import unittest

import fmpy
from host import library, opened


@unittest.skipUnless(platform.machine() == "x86_64", "the C host sets x86's control register")
class Environment(unittest.TestCase):
    def test_a_changed_environment_changes_no_bit_and_comes_back(self):
        description, _ = opened(2)
        headers = pathlib.Path(fmpy.__file__).parent / "c-code"
        with tempfile.TemporaryDirectory() as built:
            program = pathlib.Path(built, "environment")
            source = pathlib.Path(__file__).with_name("environment.c")
            # -O0: the compiler must not move the steps' arguments across the change.
            subprocess.run(["cc", "-O0", f"-I{headers}", source, "-o", program, "-ldl"], check=True)
            run = subprocess.run([program, library(2), description.guid], check=True, capture_output=True, text=True)
        usual, *changed = run.stdout.split()
        self.assertEqual(changed, [usual] * 5)
        self.assertGreater(float.fromhex(usual), 0.0)
