"""Kevlar 49 fabric pulled at three rates of strain, against the published moduli and strengths.

Method: two nodes 25 mm apart, so heavy that they part at a constant rate; the pull of the segment between them follows from what
it takes of their speed. Modulus: secant at 0.5 % of strain. Strength: the largest nominal stress. Input: modulus and strength at
the lowest and at the highest rate of data/measured/kevlar49_strength.toml, which give the growth by e-fold; so only the rate
between them is a test, and the outer two check the law.
Limit: crimp is left out, as the published modulus is that of the stretched fabric.
"""

import math

import numpy
from fabric_kernel import Scene, Simulation
from scipy.optimize import brentq

from . import page, strength
from .comparison import Comparison, Point, about, exact

# Allowed error; gauge length, m, and mass of a node, kg; strain at which the modulus is read, strain at the end, and steps until
# then.
TOLERANCE, LENGTH, MASS, SECANT, PULL, STEPS = 0.1, 0.025, 1e4, 0.005, 0.025, 5000


def twice_strain_at(stress, modulus):
    """U^2 - 1 at which the nominal stress E U (U^2 - 1)/2 has this value."""
    return brentq(lambda q: 0.5 * modulus * math.sqrt(1.0 + q) * q - stress, 0.0, 0.2, xtol=1e-15)


def cell(slow, fast):
    """Four nodes, free, of yarn that has the lowest and the highest of the measured rates."""
    modulus, strain = zip(
        *(
            (1e9 * row["modulus_gpa"][0], twice_strain_at(1e6 * row["strength_mpa"][0], 1e9 * row["modulus_gpa"][0]))
            for row in (slow, fast)
        )
    )
    folds = math.log(fast["per_second"] / slow["per_second"])
    return Scene(
        "sheet_3in_sphere",
        sheet={"nodes_x": 2, "nodes_y": 2, "spacing": LENGTH, "node_mass": MASS},
        attachment={"kind": "free"},
        projectile={"radius": 2.0 * LENGTH, "mass": 2.0 * MASS, "position": [0, 0, -1.0], "velocity": [0, 0, 0]},
        yarn={
            "stochastic": False,
            "modulus_mean": modulus[0],
            "critical_stretch": math.sqrt(1.0 + strain[0]),
            "damage_slope": 0.0,
            "damage_intercept": 2302.6,
            "rate_reference": float(slow["per_second"]),
            "rate_limit": float(fast["per_second"]),
            "rate_modulus": (modulus[1] / modulus[0] - 1.0) / folds,
            "rate_stretch": (strain[1] / strain[0] - 1.0) / folds,
        },
    )


def pulled(job):
    """Modulus and strength, Pa, at this rate of strain, 1/s."""
    scene, rate = job
    simulation = Simulation(scene.replace({"time_step.seconds": PULL / rate / STEPS}), warns=False)
    x, v = simulation.positions(), numpy.zeros((2, 2, 3))
    v[..., 0] = rate * x[..., 0]
    simulation.set_motion(x, v)
    modulus, largest, before, dt = None, 0.0, v[0, 1, 0], simulation.step_limits()["dt"]
    for _ in range(STEPS):
        x = simulation.positions()
        strain = (x[0, 1, 0] - x[0, 0, 0]) / LENGTH - 1.0
        simulation.step()
        now = simulation.velocities()[0, 1, 0]
        stress, before = MASS * (before - now) / dt / scene["sheet.yarn_area"], now
        if strain > SECANT and modulus is None:
            modulus = stress / strain
        largest = max(largest, stress)
    return [float(modulus), float(largest)]


def compared(study):
    data = strength.measured("rate")
    scene, rows = cell(data[0], data[-1]), []
    for row, (modulus, stress) in zip(data, study.each(pulled, [(scene, row["per_second"]) for row in data], "rate")):
        found = {"rate 1/s": row["per_second"], "modulus GPa": 1e-9 * modulus, "strength MPa": 1e-6 * stress}
        for unit, (value, spread) in (("GPa", row["modulus_gpa"]), ("MPa", row["strength_mpa"])):
            found |= {f"measured {unit}": value, f"measured {unit}: deviation": spread}
        rows.append(found)
    study.write("rate", rows)
    off = lambda row, name, unit: abs(row[f"{name} {unit}"] / row[f"measured {unit}"] - 1)
    sound = all(off(row, "modulus", "GPa") < TOLERANCE and off(row, "strength", "MPa") < TOLERANCE for row in rows)
    comparisons, lines = [], []
    for name, unit, digits in (("modulus", "GPa", 1), ("strength", "MPa", 0)):
        measured = f"measured {unit}"
        points = [
            Point(f"{row['rate 1/s']:.0f}/s, {unit}", exact(row[f"{name} {unit}"]), about(row[measured], 0.1)) for row in rows
        ]
        comparisons.append(
            Comparison(
                f"{name} of Kevlar 49 fabric at three rates of strain",
                "measurement",
                "± 10 %",
                points,
                digits,
                "the lowest and the highest rate are input; one is a test",
            )
        )
        for row, point in zip(rows, points):
            value, deviation = row[measured], row[f"{measured}: deviation"]
            lines.append(
                [
                    f"{name}, {row['rate 1/s']:.0f}/s",
                    f"{point.ours.value:.{digits}f} {unit}",
                    f"{value:.0f} ± {deviation:.0f} {unit}",
                    f"{100 * (point.ours.value / value - 1):+.1f}",
                    f"{(point.ours.value - value) / deviation:+.1f}",
                    point.verdict,
                ]
            )
    text = "## Modulus and strength at three rates of strain\n\n" + page.markdown(
        ["", "model", "measured, ± one deviation", "off %", "off, deviations", "verdict"], lines
    )
    return comparisons, text, sound
