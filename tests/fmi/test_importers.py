"""One run in a C loop, in FMPy and in ecospy, in both versions: the same bits at every step size."""

import json
import pathlib
import subprocess
import sys

import fmpy
import pytest
from host import ARCHIVES, opened
from test_calls import build

OUTPUTS = "contact.work energy.kinetic energy.strain energy.contact_loss fabric.max_deflection contact.force_peak".split()
GRID = {"sheet.nodes_x": 41, "sheet.nodes_y": 41}
END = 6e-5  # s; the cylinder has torn the small sheet by then
STEPS = [(1e-7, 600), (1e-6, 60), (1e-5, 6)]


def ecos(version, h, steps):
    """Outputs after a run in ecospy, which adds up its time. It knows no FMI 3.0 arrays and enumerations; none is needed here."""
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("shield", str(ARCHIVES[version]))
        structure.add_parameter_set("grid", {f"shield::{name}": value for name, value in GRID.items()})
        with EcosSimulation(structure=structure, step_size=h) as simulation:
            simulation.init(parameter_set="grid")
            simulation.step(steps)
            values = [simulation.get_real(f"shield::{name}") for name in OUTPUTS]
            simulation.terminate()
    return values


def test_the_same_bits_everywhere(tmp_path):
    found, ecospy, loop = {}, "", build(pathlib.Path(__file__).with_name("loop.c"), 2, tmp_path)
    for h, steps in STEPS:
        run = subprocess.run([loop, opened(2)[0].guid, repr(h), str(steps)], check=True, capture_output=True, text=True)
        for version, line in zip((2, 3), run.stdout.splitlines()):
            found["C", version, h] = [float.fromhex(value) for value in line.split()]
        for version in (2, 3):
            rows = fmpy.simulate_fmu(
                str(ARCHIVES[version]),
                fmi_type="CoSimulation",
                start_values=GRID,
                output=OUTPUTS,
                stop_time=END,
                step_size=h,
                output_interval=h,
            )
            assert abs(rows[-1]["time"] - END) <= 1e-12
            found["FMPy", version, h] = [float(rows[-1][name]) for name in OUTPUTS]
            code = [sys.executable, __file__, str(version), repr(h), str(steps)]
            run = subprocess.run(code, capture_output=True, text=True)
            if run.returncode == 3:
                ecospy = "ecospy cannot be loaded (it needs libtbb12)"
                continue
            assert run.returncode == 0, run.stderr
            found["ecospy", version, h] = json.loads(run.stdout.splitlines()[-1])
    expected = found["C", 2, 1e-6]
    assert expected[0] > 1.0
    assert len(found) >= 12
    for name, values in found.items():
        assert values == expected, name
    print(f"\n  {len(found)} runs, contact work {expected[0]!r} J")
    hosts = sorted({name for name, *_ in found})
    print(f"figure 25: the same bits in {', '.join(hosts)}", flush=True)
    if ecospy:
        pytest.skip(ecospy)


if __name__ == "__main__":
    try:
        import ecospy  # noqa: F401
    except (ImportError, OSError):
        sys.exit(3)
    print("\n" + json.dumps(ecos(int(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3]))))
