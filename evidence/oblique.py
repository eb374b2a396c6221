"""How often the outcome "through" is wrong in oblique hits, of bodies that spin and rub, each run on to its end after "through"
has come.

Steel fragments and disc sectors hit 31 x 31 nodes of Kevlar KM2, four sides held, from any side and in any attitude.
The velocity along the normal is drawn evenly about the limit, times the root of 1 g over the mass; otherwise as `through`.
"""

import math

import numpy
from fabric_kernel import Scene

from .through import SEED, row_of, shot, tabled

SHEET = {"fabric": {"name": "kevlar_km2_s706"}, "sheet": {"nodes_x": 31, "nodes_y": 31}}
STEEL = 7800.0
# Name, shape, angles from the normal in degrees, most friction, most spin in rad/s, normal velocities of 1 g in m/s, shots.
SETS = (
    ("box at 35°", "box", (35, 35), 0.0, 0.0, (20, 34), 500),
    ("box at 35°, rubbing and spinning", "box", (35, 35), 0.3, 1000.0, (20, 36), 500),
    ("disc sector at 22°, rubbing and spinning", "sector", (22, 22), 0.3, 4000.0, (32, 62), 500),
    ("sphere at 20 to 60°, rubbing", "sphere", (20, 60), 0.3, 0.0, (20, 42), 500),
    ("any of them at 0 to 70°, rubbing and spinning", "any", (0, 70), 0.3, 3000.0, (20, 40), 500),
)


def unit(random, count):
    vector = random.normal(size=count)
    return vector / numpy.linalg.norm(vector)


def body_of(shape, random):
    """A projectile without its motion."""
    if shape == "box":
        size = random.uniform(3e-3, 6e-3) * random.uniform(0.7, 1.3, 3)
        return {"shape": "box", "size": size.tolist(), "mass": STEEL * float(size.prod())}
    if shape == "sector":
        inner, outer, angle, thickness = random.uniform((3.2e-3, 9e-3, 0.8, 3e-3), (4.8e-3, 13e-3, 2.2, 5e-3)).tolist()
        sector = {"inner_radius": inner, "outer_radius": outer, "angle": angle, "thickness": thickness}
        return {"shape": "disc_sector", "sector": sector, "mass": float(random.uniform(2e-3, 8e-3))}
    radius = float(random.uniform(2e-3, 4e-3))
    return {"shape": "sphere", "radius": radius, "mass": STEEL * 4 / 3 * math.pi * radius**3}


def scene_of(k, shape, angles, friction, spin, velocities):
    random = numpy.random.default_rng([SEED, k])
    body = body_of(("box", "sector", "sphere")[k % 3] if shape == "any" else shape, random)
    angle, towards = math.radians(random.uniform(*angles)), float(random.uniform(0.0, 2 * math.pi))
    speed = float(random.uniform(*velocities)) * math.sqrt(1e-3 / body["mass"]) / math.cos(angle)
    rate = (random.uniform(0.0, spin) * unit(random, 3)).tolist() if spin else [0.0] * 3
    body |= {"orientation": unit(random, 4).tolist(), "angular_velocity": rate}
    aim = {"speed": speed, "angle": angle, "towards": towards, "point": random.uniform(-1e-3, 1e-3, 2).tolist()}
    rubs = {"contact": {"friction": float(random.uniform(0.05, friction))}} if friction else {}
    return Scene(**SHEET, **rubs, projectile=body, aim=aim, seed=k)


def answer(study):
    jobs = [(name, scene_of(k, *how)) for name, *how, shots in SETS for k in range(1, 1 + study.of(shots, shots // 10, 1))]
    done = study.each(shot, [scene for _, scene in jobs])
    rows = [
        row_of(name, velocities, [(job[1], one) for job, one in zip(jobs, done) if job[0] == name])
        for name, *_, velocities, _ in SETS
    ]
    return tabled(
        study, rows, done, "oblique", "The outcome through in oblique hits", "Velocities are those along the normal of 1 g."
    )
