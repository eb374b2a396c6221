"""Each function of both versions in each state, as calls/states.inc has it, and bad arguments; the host's
floating-point environment.

The programs are built against the official headers (those that FMPy brings) and linked with the library itself.
"""

import pathlib
import platform
import shutil
import subprocess

import fmpy
import pytest
from host import library, opened

HEADERS = pathlib.Path(fmpy.__file__).parent / "c-code"
SOURCES = pathlib.Path(__file__).parent / "calls"


def build(source, version, folder, *options):
    """Builds a C host that is linked with the FMU's library; returns the program."""
    program = pathlib.Path(folder, pathlib.Path(source).stem)
    warnings = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["cc", *warnings, f"-I{HEADERS}", source, library(version), *options, "-o", program], check=True)
    return program


VALGRIND = ["valgrind", "--quiet", "--leak-check=full", "--error-exitcode=9"]
needs_valgrind = pytest.mark.skipif(not shutil.which("valgrind"), reason="valgrind is not installed")


@pytest.mark.parametrize("under", [[], pytest.param(VALGRIND, marks=needs_valgrind)])
def test_every_call_in_every_state(version, under, tmp_path):
    """With valgrind: no byte is misread or lost."""
    program = build(SOURCES / f"calls{version}.c", version, tmp_path, "-g")
    run = subprocess.run([*under, program, opened(version)[0].guid], capture_output=True, text=True)
    print(f"\nfigure 24: FMI {version}.0: {run.stdout.strip()}", flush=True)
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the C host sets x86's control register")
def test_a_changed_environment_changes_no_bit_and_comes_back(tmp_path):
    # -O0: the compiler must not move the steps' arguments across the change.
    program = build(pathlib.Path(__file__).with_name("environment.c"), 2, tmp_path, "-O0")
    run = subprocess.run([program, opened(2)[0].guid], check=True, capture_output=True, text=True)
    usual, *changed = run.stdout.split()
    assert changed == [usual] * 5
    assert float.fromhex(usual) > 0.0
