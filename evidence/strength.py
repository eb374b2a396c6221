"""Kevlar 49 yarn pulled slowly at six gauge lengths, against the published Weibull scales. Strips of fabric: strips.py.

Method: a row of segments as long as the gauge, each segment with a strength of its own, is held at a uniform stretch and stepped
once; bisection finds the stretch at which its weakest segment gives way. Shape and scale of many samples follow from deviation
and mean of the logarithms:
m = pi/(sqrt(6) deviation), ln scale = mean + gamma/m. Input: data/fabrics/kevlar_49_yarn.toml, the strength at 50 mm and the
shape, two numbers that are a line through the six scales of yarn; so this tests the size effect.
Limit: 17 yarns an inch is a choice, as no count could be cited; a chain does not depend on it.
"""

import math
import tomllib

import numpy
from fabric_kernel import Scene, Simulation

from . import page
from .comparison import Comparison, Point, about
from .statistics import Estimate, deviation, mean
from .study import FULL, TOP

# Allowed error of a Weibull scale; samples of a job.
TOLERANCE, BATCH = 0.03, 50


def measured(table):
    """The rows of a table of data/measured/kevlar49_strength.toml."""
    return tomllib.loads((TOP / "data/measured/kevlar49_strength.toml").read_text())[table]


def rows_of(length, seed):
    """A free sheet of this length and of two rows, the least number, out of reach of the projectile."""
    yarn = {"linear_density": {"value": 1420, "unit": "denier"}, "count": {"value": 17, "unit": "1/in"}, "crimp": 0.0}
    scene = Scene("sheet_3in_sphere", fabric={"name": "kevlar_49_yarn", "warp": yarn, "weft": yarn, "thickness": 0.0})
    nodes = math.floor(length / scene["sheet.spacing"] + 0.5) + 1
    away = {"projectile.position": [0, 0, -1.0], "projectile.velocity": [0, 0, 0]}
    return scene.replace(away | {"sheet.nodes_x": nodes, "sheet.nodes_y": 2, "attachment.kind": "free", "seed": seed})


def strengths(job):
    """Logarithms of the nominal stress at which yarns give way, Pa."""
    length, seeds = job
    return [math.log(of_yarn(rows_of(length, seed))) for seed in seeds]


def of_yarn(scene):
    simulation = Simulation(scene, warns=False)
    rest, still, segments = simulation.positions(), numpy.zeros_like(simulation.positions()), scene["sheet.nodes_x"] - 1
    low, high = 1.0, 1.1
    for _ in range(14):
        middle = 0.5 * (low + high)
        simulation.reset()
        simulation.set_motion(rest * [middle, 1.0, 1.0], still)
        simulation.step()
        # All segments of the first row, which is the yarn.
        low, high = (middle, high) if (simulation.damage()[:segments] == 1.0).all() else (low, middle)
    return 0.5 * scene["yarn.modulus_mean"] * low * (low * low - 1.0)


def weibull(logarithms):
    """Shape, scale and the scale's standard error of Weibull samples with these logarithms; the error is that of the location of
    a Gumbel distribution by moments, 1.108/m over the root of the number."""
    shape = math.pi / (math.sqrt(6) * deviation(logarithms))
    scale = math.exp(mean(logarithms) + numpy.euler_gamma / shape)
    return shape, scale, scale * 1.108 / shape / math.sqrt(len(logarithms))


def compared(study):
    yarns, chains = measured("yarn"), 500 if study.effort == FULL else 30
    jobs = [
        (1e-3 * yarn["gauge_length_mm"], list(range(first, min(first + BATCH, chains))))
        for yarn in yarns
        for first in range(0, chains, BATCH)
    ]
    found, rows = iter(study.each(strengths, jobs, "strength")), []
    for yarn in yarns:
        shape, scale, error = weibull(sum((next(found) for _ in range(0, chains, BATCH)), []))
        row = {"sample": f"{yarn['gauge_length_mm']:.0f} mm", "samples": chains, "scale MPa": 1e-6 * scale}
        row |= {"standard error MPa": 1e-6 * error}
        rows.append(row | {"shape": shape, "measured MPa": yarn["scale_mpa"], "measured shape": yarn["shape"]})
    study.write("strength", rows)
    sound = study.effort != FULL or all(abs(row["scale MPa"] / row["measured MPa"] - 1) < TOLERANCE for row in rows)
    points, lines = [], []
    for row in rows:
        ours = Estimate.of_error(row["scale MPa"], row["standard error MPa"], row["samples"] - 1)
        point = Point(f"{row['sample']}, MPa", ours, about(row["measured MPa"], 0.03))
        points.append(point)
        off = f"{100 * (row['scale MPa'] / row['measured MPa'] - 1):+.1f}"
        shapes = [f"{row['shape']:.1f}", f"{row['measured shape']:.1f}"]
        lines.append([row["sample"], ours.text(0), f"{row['measured MPa']:.0f}", off, point.verdict, *shapes])
    heading = ["", "Weibull scale, model MPa [95 %]", "measured MPa", "off %", "verdict", "shape, model", "measured shape"]
    lacks = "two numbers of the input are the line through the six"
    text = "## Strength at six gauge lengths\n\n" + page.markdown(heading, lines)
    return (
        [Comparison("Weibull scale of Kevlar 49 yarn at six gauge lengths", "measurement", "± 3 %", points, 0, lacks)],
        text,
        sound,
    )
