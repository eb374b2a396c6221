"""The binaries of all platforms in one archive: the same run gives the same bits, and a state saved on one goes on on another.

A platform is left out, with the reason, where its binary is not in the archive (`cargo xtask fmu --targets all` builds what it
has tools for) or where the tools to compile for it and to run it are missing.
"""

import os
import pathlib
import platform as machine
import shutil
import subprocess

import fmpy
import pytest
from host import TARGET, opened

WINE = shutil.which("wine64") or shutil.which("wine") or "/usr/lib/wine/wine64"
HEADERS = pathlib.Path(fmpy.__file__).parent / "c-code"
LOADER = pathlib.Path(__file__).with_name("loader.c")

# Folder in FMI 2.0 and 3.0, name of the library, C compiler, what runs a program; the Debian packages that have them.
PLATFORMS = {
    "linux64": (
        "x86_64-linux",
        "FabricShield.so",
        ["x86_64-linux-gnu-gcc"],
        ["qemu-x86_64-static"],
        "gcc-x86-64-linux-gnu qemu-user-static",
    ),
    "win64": ("x86_64-windows", "FabricShield.dll", ["x86_64-w64-mingw32-gcc"], [WINE], "gcc-mingw-w64-x86-64 wine64"),
    "aarch64-linux": (
        "aarch64-linux",
        "FabricShield.so",
        ["aarch64-linux-gnu-gcc"],
        ["qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu"],
        "gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user-static",
    ),
}

HERE = "linux64" if machine.machine() == "x86_64" else f"{machine.machine()}-linux"


class Loader:
    """A program compiled for a platform, and how it is run on an archive's binary."""

    def __init__(self, platform, folder):
        self.folder3, self.library, compiler, self.runner, packages = PLATFORMS[platform]
        if platform == HERE:
            compiler, self.runner = ["cc"], []
        self.folder2, self.program = platform, folder / f"loader-{platform}.exe"
        if not all((pathlib.Path(opened(v)[1]) / "binaries" / self.place(v)).exists() for v in (2, 3)):
            pytest.skip(f"{platform}: no binary in the archives; cargo xtask fmu --targets all says why")
        if not all(shutil.which(tool) for tool in compiler + self.runner[:1]):
            pytest.skip(f"{platform}: {compiler[0]} or {self.runner[:1]} is missing (Debian: {packages})")
        flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", f"-I{HEADERS}"]
        libraries = [] if platform == "win64" else ["-ldl"]
        subprocess.run([*compiler, *flags, LOADER, "-o", self.program, "-lm", *libraries], check=True)

    def place(self, version):
        return f"{self.folder2 if version == 2 else self.folder3}/{self.library}"

    def run(self, version, what, state, archive=None):
        """The printed lines of a run that saves its state halfway (`what` = save), or goes on from one (load)."""
        description, folder = opened(version, archive)
        token = description.guid if version == 2 else description.instantiationToken
        library = pathlib.Path(folder, "binaries", self.place(version).replace("FabricShield", description.modelName))
        environment = {**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(TARGET / "wine")}
        command = [*self.runner, self.program, str(version), library, token, what, state]
        run = subprocess.run(command, capture_output=True, text=True, env=environment)
        if run.returncode:
            raise AssertionError(f"{command}: {run.returncode}\n{run.stderr}")
        return run.stdout.splitlines()


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """The program of this machine; of each version what it printed and the file of its state."""
    folder = tmp_path_factory.mktemp("here")
    here, states = Loader(HERE, folder), {version: folder / f"{version}.state" for version in (2, 3)}
    return here, {version: (here.run(version, "save", state), state) for version, state in states.items()}


def test_both_versions_give_the_same_bits(runs):
    (two, of_two), (three, of_three) = runs[1].values()
    assert two == three
    assert len(two) == 7
    assert of_two.read_bytes() == of_three.read_bytes()


@pytest.mark.parametrize("platform", PLATFORMS)
def test_every_platform_gives_the_bits_of_this_one(runs, platform, tmp_path):
    here, done = runs
    there, state = Loader(platform, tmp_path), tmp_path / "state"
    for version, (expected, own) in done.items():
        lines = there.run(version, "save", state)
        print(f"\n  {platform}, FMI {version}.0: {lines[-1]}", end="")
        assert lines == expected, version
        assert state.read_bytes() == own.read_bytes(), version
        # A state saved here goes on there, and the other way round.
        assert there.run(version, "load", own) == here.run(version, "load", state) == expected[-4:], version
