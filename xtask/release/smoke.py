"""Tries what this folder holds, with nothing else of the project: python3 smoke.py

Where two parts compute the same, they must give the same bits. The first failure ends it.
"""

import functools
import hashlib
import http.server
import json
import pathlib
import platform
import shutil
import subprocess
import sys
import tarfile
import tempfile
import threading
import time
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent

# The paper's 3 in sheet and its sphere at 80 m/s: a digest of the state after 4000 steps.
PROGRAM = r"""
#include <fabric_kernel.h>
#include <stdio.h>
#include <stdlib.h>

int main(void)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    scene.projectile.velocity[2] = 80.0;
    uint64_t bytes = 0, digest = 0;
    fk_memory_size(&scene, &bytes);
    fk_sim *sim = NULL;
    int failed = fk_init(malloc(bytes), bytes, &scene, &sim, NULL, 0) || fk_advance(sim, 4000) || fk_digest(sim, &digest);
    printf("%016llx\n", (unsigned long long)digest);
    return failed;
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
# This scene for the FMUs, but for the place of the projectile.
STARTS = {"sheet.nodes_x": 105, "sheet.nodes_y": 105, "attachment.kind": 1, "projectile.shape": 0, "projectile.mass": 0.0084}


def run(*words, **options):
    """What a program prints; it must end well."""
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False, **options)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))} failed:\n{done.stdout}{done.stderr}")
    return done.stdout.strip()


def only(pattern):
    (path,) = HERE.glob(pattern)
    return path


def sums(_):
    named = [line.split()[1] for line in (HERE / "SHA256SUMS").read_text().splitlines()]
    assert sorted([*named, "SHA256SUMS"]) == sorted(path.name for path in HERE.iterdir()), "a file has no sum"
    run("sha256sum", "--check", "--strict", "SHA256SUMS", cwd=HERE)
    return f"{len(named)} files have their sums"


def wheel_and_library(work):
    import fabric_kernel as fk

    simulation = fk.Simulation(fk.Scene("sheet_3in_sphere", projectile={"velocity": [0, 0, 80]}))
    simulation.step(4000)
    with tarfile.open(only("*-linux-gnu.tar.gz")) as archive:
        archive.extractall(work, filter="data")
    (prefix,) = work.iterdir()
    (work / "smoke.c").write_text(PROGRAM)
    (work / "CMakeLists.txt").write_text(PROJECT)
    run("cmake", "-S", work, "-B", work / "build", f"-DCMAKE_PREFIX_PATH={prefix}")
    run("cmake", "--build", work / "build")
    flags = run("env", f"PKG_CONFIG_PATH={prefix}/lib/pkgconfig", "pkg-config", "--cflags", "--libs", "fabric_kernel")
    run("cc", work / "smoke.c", "-o", work / "build/pkg-config", *flags.split(), f"-Wl,-rpath,{prefix}/lib")
    printed = [run(work / "build" / name) for name in ("static", "shared", "pkg-config")]
    assert printed == 3 * [simulation.digest], f"the libraries print {printed}, the wheel {simulation.digest}"
    return f"the wheel, CMake with both libraries and pkg-config give the same bits: {simulation.digest}"


def fmus(_):
    import fabric_kernel as fk
    import fmpy
    from fabric_kernel import fmu
    from fmpy.validation import validate_fmu

    ends, filled = [], []
    for version, place in (
        ("2", {"projectile.start.position[3]": -0.00735}),
        ("3", {"projectile.start.position": [0, 0, -0.00735]}),
    ):
        archive = str(only(f"*-fmi{version}.fmu"))
        assert not validate_fmu(archive), validate_fmu(archive)
        result = fmpy.simulate_fmu(
            archive, stop_time=250e-6, output_interval=1e-6, start_values=STARTS | place, output=["contact.work"]
        )
        ends.append(float(result["contact.work"][-1]))
        with tempfile.TemporaryDirectory() as folder:
            mine = pathlib.Path(folder, "Mine.fmu")
            mine.write_bytes(fmu.filled(archive, fk.Scene("sheet_3in_sphere"), "Mine")[1])
            filled.append(
                float(
                    fmpy.simulate_fmu(str(mine), stop_time=50e-6, output_interval=1e-6, output=["contact.work"])["contact.work"][
                        -1
                    ]
                )
            )
    assert filled[0] == filled[1] > 0.1, f"filled with a scene, FMI 2.0 and 3.0 differ: {filled} J"
    assert ends[0] == ends[1] > 1.0, f"FMI 2.0 and 3.0 differ: {ends} J"
    return f"FMPy finds no error, and both give the same bits: {ends[0]:.2f} J absorbed"


def capsule(_):
    import fabric_kernel as fk

    found = fk.replay(HERE / "demo.capsule")
    assert found["same"] and found["whole"], found
    return f"the wheel replays it with the same bits: {found['calls']} calls, {found['step']} steps, {found['digest']}"


def source_of_the_wheel(work):
    if not shutil.which("cargo"):
        return "not tried, which needs Rust"
    import fabric_kernel as fk

    run(sys.executable, "-m", "venv", work / "source")
    run(work / "source/bin/pip", "--quiet", "install", "--no-compile", only("fabric_kernel-*[0-9].tar.gz"))
    program = "import fabric_kernel as fk; s = fk.Simulation(fk.Scene('sheet_3in_sphere')); s.step(1000); print(s.digest)"
    simulation = fk.Simulation(fk.Scene("sheet_3in_sphere"))
    simulation.step(1000)
    printed = run(work / "source/bin/python", "-c", program)
    assert printed == simulation.digest, f"built from source it prints {printed}, the wheel {simulation.digest}"
    return f"it builds, and gives the wheel's bits: {printed}"


def page(_):
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=HERE)
    http.server.SimpleHTTPRequestHandler.log_message = lambda *_: None
    with http.server.HTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with urllib.request.urlopen(f"http://127.0.0.1:{server.server_port}/index.html") as answer:
            served = hashlib.sha256(answer.read()).hexdigest()
        server.shutdown()
    assert f"{served}  index.html" in (HERE / "SHA256SUMS").read_text(), "the page is served with other bytes"
    return f"it is served with the bytes of its sum, {served[:16]}..."


def bills_of_materials(_):
    parts = [part for path in HERE.glob("*.cdx.json") for part in json.loads(path.read_text())["components"]]
    without = {part["name"] for part in parts if not part.get("licenses")}
    assert parts and not without, f"no licence is given of {without}"
    return f"{len(parts)} entries, each with its licence"


def main():
    with tempfile.TemporaryDirectory() as folder:
        if sys.argv[1:] != ["--inside"]:
            # Where nothing is installed but the wheel with what it depends on, and FMPy.
            run(sys.executable, "-m", "venv", folder)
            wheel = f"{only(f'*_{platform.machine()}.whl')}[plots,tables]"
            run(f"{folder}/bin/pip", "--quiet", "install", "--no-compile", wheel, "fmpy")
            sys.exit(subprocess.run([f"{folder}/bin/python", __file__, "--inside"], check=False).returncode)
        for part in (sums, wheel_and_library, source_of_the_wheel, fmus, capsule, page, bills_of_materials):
            start = time.perf_counter()
            print(
                f"{part.__name__.replace('_', ' ')}: {part(pathlib.Path(folder))} ({time.perf_counter() - start:.1f} s)",
                flush=True,
            )


if __name__ == "__main__":
    main()
