"""Scenes in parameter sets, and what the FMU says of plies, the graded network and the energy balance."""

import re
import zipfile

import fabric_kernel as fk
import fmpy
from host import ARCHIVES, ERROR, EXAMPLES, OK, OUTPUTS, SMALL, Host, filled, hosts, parameter_set


def test_the_archive_has_the_parameter_sets_of_the_examples():
    files = sorted((EXAMPLES / "parameters").glob("*.ssv"))
    assert [file.stem for file in files] == [
        "ring_40in",
        "sheet_3in_sphere",
        "three_plies",
        "turbine_disc_sector",
        "zylon_as_500_35",
    ]
    with zipfile.ZipFile(ARCHIVES[2]) as archive:
        for file in files:
            assert archive.read(f"documentation/parameters/{file.name}") == file.read_bytes()


def test_each_parameter_set_is_a_sound_scene():
    for name, shape, mass in [
        ("sheet_3in_sphere", 0, 8.4e-3),
        ("three_plies", 0, 8.4e-3),
        ("turbine_disc_sector", 4, 0.118),
        ("ring_40in", 5, 0.118),
    ]:
        for host in hosts(parameter_set(name)):
            assert host.get("projectile.shape") == shape
            assert abs(host.get("projectile.mass") - mass) < 5e-4
            assert host.status_of_step(0.0, 1e-7) == OK


def test_single_plies_are_told_from_one_on():
    of_plies = [name for name in OUTPUTS if name.startswith("ply.")]
    told = {}
    for version in (2, 3):
        host = Host(
            version,
            {**parameter_set("three_plies"), "sheet.nodes_x": 41, "sheet.nodes_y": 41, "projectile.start.velocity[3]": 300.0},
        )
        host.run(0, 40, 1e-6)
        rows = {name: host.get(name) for name in of_plies}
        for name, values in rows.items():
            assert (len(values), values[3:]) == (8, [0.0] * 5), name
        for part in ("kinetic", "strain", "dissipated"):
            assert rows[f"ply.{part}"][2] > 0.0
            assert abs(sum(rows[f"ply.{part}"]) - host.get(f"energy.{part}")) < 5e-10
        assert sum(rows["ply.failed_segments"]) == host.get("fabric.failed_segments")
        assert rows["ply.failed_segments"][0] > 0
        assert host.get("fabric.ply_penetration") >= 0.0
        # From another ply on, at once; and nothing beyond the last.
        for first in (1, 3, 999):
            assert host.try_set("ply.first", first) == OK
            assert {name: host.get(name) for name in of_plies} == {
                name: (values[first:] + [0.0] * 8)[:8] for name, values in rows.items()
            }
        for first in (-1, 1000):
            assert host.try_set("ply.first", first) == ERROR
        told[version] = rows
        # A single sheet is its own ply 0.
        host = Host(version, {**parameter_set("sheet_3in_sphere"), "sheet.nodes_x": 41, "sheet.nodes_y": 41}).run(0, 40, 1e-6)
        assert host.get("ply.strain") == [host.get("energy.strain")] + [0.0] * 7
        assert host.get("ply.failed_segments")[0] == host.get("fabric.failed_segments")
    assert told[2] == told[3]


def test_a_hit_beyond_the_fine_part_is_counted_and_told_once():
    for x, beside in [(0.0, False), (4e-3, True)]:
        counts = []
        for version in (2, 3):
            host = Host(
                version,
                {
                    **SMALL,
                    "sheet.nodes_x": 61,
                    "sheet.nodes_y": 61,
                    "sheet.grading.largest": 8,
                    "sheet.grading.run": 1,
                    "sheet.grading.half_width": [7e-3, 7e-3],
                    "projectile.start.position[1]": x,
                },
            )
            host.run(0, 40, 1e-6)
            counts.append(host.get("contact.beyond_fine"))
            told = [text for _, _, text in host.log if text.startswith("contact.beyond_fine: the projectile met the sheet")]
            assert len(told) == int(beside), host.log
        assert counts[0] == counts[1]
        assert (counts[0] > 0) == beside


def test_an_open_energy_balance_is_told_once_and_when_it_opens():
    mass, speed = 4e-5, 60.0
    for version in (2, 3):
        host = Host(
            version, {**SMALL, "sheet.crimp": [0.006, 0.006], "projectile.mass": mass, "projectile.start.velocity[3]": speed}
        )
        opened = False
        for k in range(40):
            host.run(k, k + 1, 2e-5)
            opened |= abs(host.get("energy.residual")) > 0.01 * 0.5 * mass * speed**2
            told = [line[:2] for line in host.log if line[2].startswith("energy.residual: more than 1 % of the impact energy")]
            assert told == [(1, "logStatusWarning")] * opened, (k, host.log)
        assert opened


def test_energy_from_nothing_is_told_once_after_an_open_balance_too():
    """A turning box that rubs on slack cloth, with twice the largest time step."""
    body = {"shape": "box", "size": [4e-3, 4e-3, 2e-3], "mass": 1e-3, "velocity": [20.0, 0.0, 20.0]}
    body |= {"orientation": [0.9, 0.3, 0.2, 0.2449489742783178], "angular_velocity": [2000.0, 1000.0, 0.0]}
    sheet, fraction = {"nodes_x": 61, "nodes_y": 61}, {"fraction": 1.0}
    scene = fk.Scene(sheet=sheet, time_step=fraction, step_check="none", contact={"friction": 0.5}, projectile=body)
    scene = scene.replace({"yarn.stochastic": False}).aimed()
    for version in (2, 3):
        host = Host(version, {}, archive=filled(version, scene, "Rubbing")).run(0, 10, 1e-5)
        assert host.get("energy.gained") > 1e-3 * 0.5 * 1e-3 * 2 * 20.0**2
        told = [(status, kind, text.partition(":")[0]) for status, kind, text in host.log if text.startswith("energy.")]
        warned = [(1, "logStatusWarning", f"energy.{name}") for name in ("residual", "gained")]
        assert told == warned, host.log


def test_the_example_of_the_page_runs():
    with zipfile.ZipFile(ARCHIVES[2]) as archive:
        page = archive.read("documentation/index.html").decode()
    code = re.search(r"<pre>(import fmpy.*?)</pre>", page, re.DOTALL)[1]
    assert "stop_time=0.0006" in code
    short = code.replace("FabricShield-fmi2.fmu", str(ARCHIVES[2])).replace("stop_time=0.0006", "stop_time=2e-5")
    namespace = {}
    exec(short.replace("print(rows[-1])", ""), namespace)
    assert float(namespace["rows"][-1]["contact.work"]) > 0.0
    # Start values that it shows for the two versions.
    shown = [eval(text) for text in re.findall(r"<code>(?:start_values=)?(\{&?.*?\})</code>", page)]
    assert len(shown) == 2
    for version, values in zip((2, 3), shown):
        rows = fmpy.simulate_fmu(
            str(ARCHIVES[version]),
            stop_time=1e-6,
            start_values=values,
            output=["contact.work", "state.velocity[3]"[: None if version == 2 else -3]],
        )
        assert abs(float(rows[-1][-1] if version == 2 else rows[-1][-1][2]) - 80.0) < 5e-7
