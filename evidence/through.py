"""How often the outcome "through" is wrong: shots near the ballistic limit, each run on to its end after "through" has come.

Sheets: velocities are drawn evenly from a range about V50, yarns, impact points and attitudes as for `fabric v50`.
Oblique hits: steel fragments and disc sectors, which spin and rub, hit 31 x 31 nodes of Kevlar KM2, four sides held, from any
side and in any attitude; the velocity along the normal is drawn evenly about the limit, times the root of 1 g over the mass.
A shot is wrong if "through" has come and the projectile is arrested or rebounds later.
The change of speed is that between "through" and the end, in parts of the impact velocity; one that moves on after MOST steps
ends there.
Limit: what the numbers of the rule were chosen on, 1,160 other shots at these sheets, is not part of the table.
"""

import math

import numpy
import scipy.stats
from fabric_kernel import Scene, Simulation, vary
from fabric_kernel.ensembles import within_mesh
from fabric_kernel.runs import STOPPED, UNTIL

from . import page
from .study import SMOKE, clock

SEED = 2026
# Most steps of a shot.
MOST = 200_000
SMALL = {"nodes_x": 51, "nodes_y": 51}
KM2 = {"name": "kevlar_km2_s706"}
WEAVE = {"linear_density": {"value": 1420, "unit": "denier"}, "count": {"value": 17, "unit": "1/in"}}
CUBE = {"shape": "box", "size": [0.0106, 0.0106, 0.0106]}
# Name, scene, slowest and fastest shot in m/s, shots, attitude.
SHEETS = (
    ("3 in preset", Scene("sheet_3in_sphere"), (45.7, 47.4), 200, None),
    ("Kevlar KM2", Scene(fabric=KM2, sheet=SMALL), (17.8, 18.3), 400, None),
    ("Kevlar 49", Scene(fabric={"name": "kevlar_49_yarn"} | WEAVE, sheet=SMALL), (22.0, 27.0), 500, None),
    ("Powell and Zohdi", Scene(fabric={"name": "powell_zohdi_2009"}, sheet=SMALL), (15.0, 18.0), 350, None),
    ("Zylon AS", Scene(fabric={"name": "zylon_as_500_35"}, sheet=SMALL), (22.5, 25.0), 350, None),
    ("10 in preset, small", Scene("sheet_10in_cylinder", sheet=SMALL), (12.8, 13.8), 40, None),
    ("KM2, three plies", Scene(fabric=KM2, sheet=SMALL, stack={"plies": 3, "gap": 1e-4}), (31.0, 34.0), 40, None),
    ("KM2, cube, any attitude", Scene(fabric=KM2, sheet=SMALL, projectile=CUBE), (16.5, 22.0), 60, "random"),
    ("KM2, friction 0.2", Scene(fabric=KM2, sheet=SMALL, contact={"friction": 0.2}), (18.7, 19.7), 60, None),
)
STEEL = 7800.0
# Name, shape, angles from the normal in degrees, most friction, most spin in rad/s, normal velocities of 1 g in m/s, shots.
SETS = (
    ("box at 35°", "box", (35, 35), 0.0, 0.0, (20, 34), 500),
    ("box at 35°, rubbing and spinning", "box", (35, 35), 0.3, 1000.0, (20, 36), 500),
    ("disc sector at 22°, rubbing and spinning", "sector", (22, 22), 0.3, 4000.0, (32, 62), 500),
    ("sphere at 20 to 60°, rubbing", "sphere", (20, 60), 0.3, 0.0, (20, 42), 500),
    ("any of them at 0 to 70°, rubbing and spinning", "any", (0, 70), 0.3, 3000.0, (20, 40), 500),
)


def shot(scene):
    """Steps and processor seconds until "through" or an end, and until the end; the speeds at both, m/s."""
    simulation, start = Simulation(scene.replace({"track_through": True}), warns=False), clock()
    look = lambda: (simulation.step_count, clock() - start, float(numpy.linalg.norm(simulation.projectile()["velocity"])))
    simulation.run((*UNTIL, "through"), MOST)
    decided = look()
    simulation.run(UNTIL, MOST - simulation.step_count)
    return {"outcomes": list(simulation.outcomes()), "decided": decided, "end": look()}


def row_of(name, velocities, done):
    """done: the scenes of a sheet and their shots."""
    shots = [one for _, one in done]
    has = lambda outcome: [one for one in shots if outcome in one["outcomes"]]
    stopped, through = [one for one in shots if set(STOPPED) & set(one["outcomes"])], has("through")
    impact = lambda scene: float(numpy.linalg.norm(scene["projectile.velocity"]))
    change = [100 * (one["end"][2] - one["decided"][2]) / impact(scene) for scene, one in done if one in through] or [0.0]
    spent = lambda which, k: sum(one[which][k] for one in shots)
    return {
        "sheet": name,
        "velocities": "{:g} to {:g}".format(*velocities),
        "shots": len(shots),
        "stopped": len(stopped),
        "through": len(through),
        "wrong": sum(one in stopped for one in through),
        "missed": sum("through" not in one["outcomes"] for one in has("exited")),
        "not ended": sum(not any(end in one["outcomes"] for end in UNTIL) for one in shots),
        "least change": round(min(change), 2) + 0.0,
        "mean change": round(float(numpy.mean(change)), 2) + 0.0,
        "most change": round(max(change), 2) + 0.0,
        "steps ratio": spent("end", 0) / spent("decided", 0),
        "CPU ratio": spent("end", 1) / spent("decided", 1),
    }


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


def oblique(k, shape, angles, friction, spin, velocities):
    random = numpy.random.default_rng([SEED, k])
    body = body_of(("box", "sector", "sphere")[k % 3] if shape == "any" else shape, random)
    angle, towards = math.radians(random.uniform(*angles)), float(random.uniform(0.0, 2 * math.pi))
    speed = float(random.uniform(*velocities)) * math.sqrt(1e-3 / body["mass"]) / math.cos(angle)
    rate = (random.uniform(0.0, spin) * unit(random, 3)).tolist() if spin else [0.0] * 3
    body |= {"orientation": unit(random, 4).tolist(), "angular_velocity": rate}
    aim = {"speed": speed, "angle": angle, "towards": towards, "point": random.uniform(-1e-3, 1e-3, 2).tolist()}
    rubs = {"contact": {"friction": float(random.uniform(0.05, friction))}} if friction else {}
    return Scene(fabric=KM2, sheet={"nodes_x": 31, "nodes_y": 31}, **rubs, projectile=body, aim=aim, seed=k)


def answer(study):
    jobs = []
    for name, scene, velocities, count, attitude in SHEETS:
        mesh, speed = within_mesh(scene, (0.0, 0.0)), scipy.stats.uniform(velocities[0], velocities[1] - velocities[0])
        scenes = vary(scene, study.of(count, count // 20, 1), seed=SEED, speed=speed, point=mesh, attitude=attitude)
        jobs += [(k / count, name, one) for k, one in enumerate(scenes)]
    jobs.sort(key=lambda job: job[0])  # What has been done when it is stopped is of every sheet.
    hits = [(k, name, oblique(k, *how)) for name, *how, n in SETS for k in range(1, 1 + study.of(n, n // 10, 1))]
    named = [(sheet[0], sheet[2]) for sheet in SHEETS], [(one[0], one[5]) for one in SETS]
    told = "Sheets but the first have 51 x 51 nodes.", "Velocities are those along the normal of 1 g."
    titles = "The outcome through", "The outcome through in oblique hits"
    return min(tabled(study, *one) for one in zip(("through", "oblique"), titles, (jobs, hits), named, told))


def tabled(study, name, title, jobs, named, sheets):
    """Shoots, writes numbers and table; whether no shot is wrong."""
    shots = study.each(shot, [one for _, _, one in jobs], name)
    rows = [row_of(of, v, [(job[2], one) for job, one in zip(jobs, shots) if job[1] == of]) for of, v in named]
    study.write(name, rows)
    columns = [("sheet", None), ("velocities, m/s", "velocities", None)]
    columns += [(column, column, 0) for column in ("shots", "stopped", "through", "wrong", "missed", "not ended")]
    columns += [(f"{column}, %", column, 2) for column in ("least change", "mean change", "most change")]
    columns += [("steps to the end over those decided", "steps ratio", 1), ("CPU s likewise", "CPU ratio", 1)]
    known = sum("through" in one["outcomes"] and any(end in one["outcomes"] for end in UNTIL) for one in shots)
    total, wrong = sum(row["shots"] for row in rows), sum(row["wrong"] for row in rows)
    bound = 100 * scipy.stats.binomtest(wrong, known).proportion_ci(0.95, method="exact").high if known else 100.0
    text = (
        f'"Wrong" of {total} shots: {wrong}. Of {known} in which "through" came and that came to an end, the share that is '
        f"wrong is below {bound:.2f} % "
        '(exact, the upper end of a 95 % interval).\n"Missed": exited without "through"; "not ended": neither stopped nor '
        "exited after "
        f'{MOST} steps. {sheets}\nThe change is that of speed between "through" and the end, in parts of the impact velocity.\n\n'
    )
    study.table(name, title, text + page.table(rows, columns, 2))
    return wrong == 0 or study.effort == SMOKE
