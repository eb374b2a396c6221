"""Tries what this folder holds, with nothing else of the project: python3 smoke.py

Each part must give the same bits as the others where they compute the same. The first failure ends it.
"""

import functools
import hashlib
import http.server
import json
import pathlib
import platform
import subprocess
import sys
import tarfile
import tempfile
import threading
import time
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
STEPS = 4000

# The paper's 3 in sheet and its sphere at 80 m/s: the digest of the state after these steps.
PROGRAM = r"""
#include <fabric_kernel.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

int main(void)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    scene.projectile.velocity[2] = 80.0;
    uint64_t bytes = 0, digest = 0;
    fk_memory_size(&scene, &bytes);
    fk_sim *sim = NULL;
    fk_fault fault = {0};
    if (fk_init(malloc(bytes), bytes, &scene, &sim, &fault, sizeof fault) != FK_OK || fk_advance(sim, STEPS) != FK_OK) {
        puts(fault.text);
        return 1;
    }
    fk_digest(sim, &digest);
    printf("%016" PRIx64 "\n", digest);
    return 0;
}
"""
PROJECT = """
cmake_minimum_required(VERSION 3.16)
project(smoke C)
find_package(fabric_kernel 0.1 REQUIRED)
foreach(kind static shared)
  add_executable(${kind} smoke.c)
  target_link_libraries(${kind} PRIVATE fabric_kernel::${kind})
endforeach()
"""
# The same scene for the FMUs, whose projectile starts 1 mm before the sheet.
PARAMETERS = {
    "sheet.nodes_x": 105, "sheet.nodes_y": 105, "attachment.kind": 1, "projectile.shape": 0, "projectile.mass": 0.0084,
    "projectile.start.position[3]": -0.00735,
}  # fmt: skip


def main():
    if sys.prefix == sys.base_prefix:
        return in_a_new_environment()
    for part in (sums, wheel, library, fmus, capsule, page, bills):
        start = time.perf_counter()
        said = part()
        print(f"{part.__name__}: {said} ({time.perf_counter() - start:.1f} s)", flush=True)
    print("7 passed, 0 failed")


def in_a_new_environment():
    """Runs this program again where nothing is installed but the wheel with what it depends on, and FMPy."""
    with tempfile.TemporaryDirectory() as folder:
        run(sys.executable, "-m", "venv", folder)
        python = pathlib.Path(folder, "bin/python")
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", only(f"*_{platform.machine()}.whl"), "fmpy")
        sys.exit(subprocess.run([python, __file__], check=False).returncode)


def run(*words, **options):
    """What a program prints; it must end well."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, **options)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))} failed:\n{done.stdout}{done.stderr}")
    return done.stdout.strip()


def only(pattern):
    (path,) = HERE.glob(pattern)
    return path


def sums():
    named = [line.split(maxsplit=1)[1] for line in (HERE / "SHA256SUMS").read_text().splitlines()]
    assert sorted([*named, "SHA256SUMS"]) == sorted(path.name for path in HERE.iterdir()), "a file without a sum"
    run("sha256sum", "--check", "--strict", "SHA256SUMS", cwd=HERE)
    return f"{len(named)} files have their sums"


@functools.cache
def digest():
    import fabric_kernel as fk

    simulation = fk.Simulation(fk.Scene("sheet_3in_sphere", projectile={"velocity": [0, 0, 80]}))
    simulation.step(STEPS)
    return simulation.digest


def wheel():
    return f"digest {digest()} after {STEPS} steps"


def library():
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        with tarfile.open(only("*-linux-gnu.tar.gz")) as archive:
            archive.extractall(work, filter="data")
        (prefix,) = work.iterdir()
        (work / "smoke.c").write_text(PROGRAM.replace("STEPS", str(STEPS)))
        (work / "CMakeLists.txt").write_text(PROJECT)
        run("cmake", "-S", work, "-B", work / "build", f"-DCMAKE_PREFIX_PATH={prefix}")
        run("cmake", "--build", work / "build")
        flags = run("pkg-config", "--cflags", "--libs", "fabric_kernel", env={"PKG_CONFIG_PATH": str(prefix / "lib/pkgconfig"), "PATH": "/usr/bin:/bin"})
        run("cc", work / "smoke.c", "-o", work / "program", *flags.split(), f"-Wl,-rpath,{prefix}/lib")
        for program in ("build/static", "build/shared", "program"):
            printed = run(work / program)
            assert printed == digest(), f"{program} prints {printed} instead of the wheel's {digest()}"
    return "CMake with the static and the shared library, and pkg-config: the wheel's digest"


def fmus():
    import fmpy
    from fmpy.validation import validate_fmu

    ends = []
    for version in "23":
        archive = str(only(f"*-fmi{version}.fmu"))
        assert not validate_fmu(archive), validate_fmu(archive)
        names = {variable.name for variable in fmpy.read_model_description(archive).modelVariables}
        position = {} if "projectile.start.position[3]" in names else {"projectile.start.position": [0.0, 0.0, -0.00735]}
        starts = {name: value for name, value in PARAMETERS.items() if name in names} | position
        result = fmpy.simulate_fmu(archive, stop_time=250e-6, output_interval=1e-6, start_values=starts, output=["contact.work", "energy.residual"])
        ends.append(result[-1].tolist())
    assert ends[0] == ends[1] and ends[0][1] > 1.0, f"FMI 2.0 and 3.0 differ: {ends}"
    return f"FMPy finds both valid, and they give the same bits: {ends[0][1]:.2f} J absorbed"


def capsule():
    import fabric_kernel as fk

    found = fk.replay(HERE / "demo.capsule")
    assert found["same"] and found["whole"], found
    return f"same bits: {found['calls']} calls, {found['step']} steps, the last digest {found['digest']}"


def page():
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=HERE)
    handler.log_message = lambda *_: None
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with urllib.request.urlopen(f"http://127.0.0.1:{server.server_port}/index.html") as answer:
            served = hashlib.sha256(answer.read()).hexdigest()
        server.shutdown()
    assert f"{served}  index.html" in (HERE / "SHA256SUMS").read_text(), "the page is served with other bytes"
    return f"served with the bytes of its sum, {served[:16]}..."


def bills():
    parts = [part for path in sorted(HERE.glob("*.cdx.json")) for part in json.loads(path.read_text())["components"]]
    nameless = {part["name"] for part in parts if not part.get("licenses")}
    assert parts and not nameless, f"no licence is given of {nameless}"
    return f"{len(parts)} entries, each with its licence"


if __name__ == "__main__":
    main()
