"""Bits equal to those of Rust: digests of scenes that tests/golden pins, through every way of making, stepping and copying a
simulation."""

import os
import pathlib
import pickle
import re
import threading

import fabric_kernel as fk
import numpy
import pytest
from fabric_kernel.network import graded

PINS = dict(re.findall(r"^golden (\w+) (\w+)$", (pathlib.Path(__file__).parents[1] / "golden/pins").read_text(), re.MULTILINE))
SMALL = {"sheet": {"nodes_x": 41, "nodes_y": 41}, "yarn": {"stochastic": False}}
PLIES = {
    "sheet": {"nodes_x": 31, "nodes_y": 29, "yarn_area_y": 0.8e-7},
    "stack": {"plies": 4, "gap": 2.5e-4, "turned": True},
    "weft.critical_stretch": 1.025,
    "yarn": {"viscosity_linear": 0.06, "viscosity_bending": 0.06},
    "projectile.velocity": [0.0, 0.0, 220.0],
}
SECTOR = {
    "sheet": {"nodes_x": 121, "nodes_y": 121},
    "projectile": {"velocity": [20.0, 10.0, 400.0], "angular_velocity": [200.0, -2000.0, 0.0]},
}


def assert_pin(simulation, name):
    assert simulation.digest == PINS[name]


def after(scene, steps):
    simulation = fk.Simulation(scene)
    simulation.step(steps)
    return simulation


def test_sphere():
    assert_pin(after(fk.Scene(), 4500), "sheet_3in_sphere")


def test_sector():
    assert_pin(after(fk.Scene("turbine_disc_sector", SECTOR), 2000), "disc_sector")


def test_a_capsule_is_done_again(tmp_path):
    scene = fk.Scene("sheet_3in_sphere", SMALL, projectile={"velocity": [0, 0, 120]})
    file = tmp_path / "run.capsule"
    simulation = fk.Simulation(scene, capsule=file)
    simulation.set_external_load([0.0, 1.0, 0.0])
    simulation.run(["exited"], 300)
    image = simulation.save()
    simulation.step(100)
    simulation.restore(image)
    simulation.step(20)
    digest = simulation.digest
    with pytest.raises(OSError, match="another simulation writes this capsule"):
        fk.Simulation(scene, capsule=file)
    if (child := os.fork()) == 0:
        del simulation
        os._exit(0)
    os.waitpid(child, 0)
    cut = fk.replay(file)
    assert (cut["same"], cut["whole"]) == (True, False), "as a crash leaves it"
    del simulation
    found = fk.replay(file)
    assert (found["same"], found["whole"], found["digest"], found["calls"]) == (True, True, digest, 6)
    file.write_bytes(file.read_bytes()[:-30])
    assert not fk.replay(file)["whole"]
    file.write_bytes(b"{}")
    with pytest.raises(fk.Refused, match="not a capsule"):
        fk.replay(file)


def test_plies_from_a_file_and_another_process():
    scene = fk.Scene(**PLIES)
    assert fk.Scene.parse(scene.to_toml()) == scene
    assert_pin(after(pickle.loads(pickle.dumps(scene)), 1200), "sphere_through_turned_plies")


def test_prescribed_on_two_paths():
    body = {"shape": "cylinder", "radius": 4e-3, "length": 9e-3, "mass": 0.0, "position": [1e-3, -5e-4, -6.2e-3]}
    body |= {"velocity": [15.0, -10.0, 350.0], "orientation": [0.96, 0.28, 0.0, 0.0]}
    body |= {"angular_velocity": [800.0, 0.0, -1500.0]}
    scene = fk.Scene(
        sheet={"nodes_x": 45, "nodes_y": 38},
        seed=0xFEED,
        drive="prescribed",
        projectile=body,
        attachment={"kind": "four_sides"},
        unread={"attachment.disc_inset": 2e-3, "attachment.disc_radius": 2e-3},
    )
    simulation = fk.Simulation(scene)
    for z, speed, orientation, steps in [
        (-1.9e-3, 250.0, [0.96, 0.28, 0.0, 0.0], 700),
        (0.6e-3, 200.0, [0.96, 0.2, 0.0, -0.2], 500),
    ]:
        rates = [200.0, 100.0, -500.0]
        simulation.follow([1.2e-3, -6e-4, z], [5.0, 0.0, speed], orientation, rates, path_steps=steps)
    assert_pin(simulation, "prescribed_cylinder_on_two_paths")


def test_saved_and_restored():
    first, second = (after(fk.Scene(**SMALL), steps) for steps in (1000, 20))
    image = first.save()
    second.restore(image)
    assert second.step_count == 1000
    second.step(2000)
    assert_pin(second, "uniform_sphere_through_failure")
    with pytest.raises(fk.Refused) as refused:
        fk.Simulation(fk.Scene()).restore(image)
    assert refused.value.code == "ImageOfAnotherScene"


def test_threads_beside_each_other():
    simulations = [fk.Simulation(fk.Scene(**SMALL)) for _ in range(4)]
    threads = [threading.Thread(target=simulation.step, args=(3000,)) for simulation in simulations]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for simulation in simulations:
        assert_pin(simulation, "uniform_sphere_through_failure")


def test_histories_and_read_outs_change_nothing():
    simulation = fk.Simulation(fk.Scene(**SMALL))
    rows = fk.history(simulation, until=[], steps=3000, every=100)
    assert_pin(simulation, "uniform_sphere_through_failure")
    assert list(rows["step"]) == list(range(0, 3001, 100))
    # Newton's second law over the whole history.
    momentum = 8.4e-3 * (rows["velocity_z"].iloc[-1] - rows["velocity_z"].iloc[0])
    impulse = (rows["force_z"] * rows["time"].diff()).sum()
    assert momentum / impulse == pytest.approx(1.0, rel=0, abs=5e-11)


def test_a_motion_that_is_given():
    simulation = fk.Simulation(fk.Scene(**SMALL))
    positions, velocities = simulation.positions(), simulation.velocities()
    assert positions.shape == (41, 41, 3)
    spacing = fk.Scene()["sheet.spacing"]
    numpy.testing.assert_allclose(positions[3, 7], [(7 - 20) * spacing, (3 - 20) * spacing, 0.0], rtol=1e-12)
    simulation.set_motion(positions, velocities)
    velocities[20, 20, 2] = 5.0
    simulation.set_motion(positions, velocities)
    assert simulation.velocities()[20, 20, 2] == 5.0
    assert simulation.stretch().shape == (2 * 40 * 41,)
    simulation.set_largest_stretch(numpy.full(2 * 40 * 41, 1.05))
    assert simulation.damage().max() < 1.0
    # A refused motion names the array.
    velocities[0, 0, 0] = 1.0
    with pytest.raises(fk.Refused) as refused:
        simulation.set_motion(positions, velocities)
    assert refused.value.field == "velocities"


def test_it_stops_at_the_first_failed_segments():
    scene = fk.Scene(projectile={"velocity": [0, 0, 300]}, **SMALL)
    one, other = fk.Simulation(scene, warns=False), fk.Simulation(scene, warns=False)
    taken = one.run("exited", 100_000, failed=1)
    assert (taken, one.run([], 5, failed=1)) == (one.step_count, 0)
    other.step(taken - 1)
    assert other.counters()["failed_segments"] == 0
    other.step()
    failed = other.counters()["failed_segments"]
    assert failed > 0
    assert one.digest == other.digest
    # So many failed in that step, which are enough, too.
    assert fk.Simulation(scene, warns=False).run("exited", 100_000, failed=failed) == taken


def test_a_graded_network_is_that_of_a_file():
    large = fk.Scene("sheet_10in_cylinder")
    assert large.graded(0.01) == large.replace(sheet={"grading": "automatic"}) == large.replace(graded(large))
    assert graded(fk.Scene("sheet_3in_sphere")) == {}
    assert fk.Simulation(large.graded(0.03)).positions().size < fk.Simulation(large).positions().size
    with pytest.raises(fk.Refused):
        large.graded(0.5)


def test_yarns_of_fibrils():
    # The paper has 140.21 GPa, 2.04 GPa and a damage rate of 230.6.
    moduli, rates, _ = fk.yarns_of_fibrils(1, 2000).T
    assert 1e-9 * moduli.mean() == pytest.approx(140.21, rel=0, abs=0.15)
    assert 1e-9 * moduli.std() == pytest.approx(2.04, rel=0, abs=0.1)
    assert rates.mean() == pytest.approx(230.6, rel=0, abs=2.0)
    yarn, straight = fk.yarn_of_fibrils(1, 3), fk.yarn_of_fibrils(1, 3, straight=True)
    assert (yarn["modulus"], yarn["laws"][0][0]) == (moduli[3], rates[3])
    # Fibrils break in turn; aligned ones all at the critical stretch, with the strain energy E e^2/2 of 180 GPa.
    assert (numpy.diff(yarn["ruptures"]) > 0).all()
    assert yarn["alpha"][-1] == 0.0
    assert set(straight["alpha"]) == {0.0}
    assert straight["work"] / (0.5 * 180e9 * (0.5 * (1.03**2 - 1)) ** 2) == pytest.approx(1.0, rel=0, abs=1e-9)
    assert straight["critical_stretch"] == 1.03


def test_a_simulation_says_where_it_is():
    simulation = after(fk.Scene(**SMALL), 100)
    said = repr(simulation)
    assert said.startswith("<Simulation of Scene('sheet_3in_sphere', {")
    assert said.endswith(f"step 100, {1e6 * simulation.time:.4f} us>")
