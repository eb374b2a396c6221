"""Hits of an ensemble: where they strike, what an impact ends with, and the ballistic limit of each, found by bisection.

Hits differ by where in a cell of the network the projectile's axis strikes, which a shot does not control, and by the seed of
what is drawn.
Each hit has a limit of its own, between arrest and perforation; their mean stands for V50 and Student's interval for its error.
A shot of a search ends when it is decided that the projectile goes through ("through", docs/v50.md), others when it has.
Limit: beyond the first failure the model is chaotic, so the limit of one hit is one sample; bisection finds one of its crossings.
"""

import math

from fabric_kernel import Scene, Simulation
from fabric_kernel.runs import STOPPED
from fabric_kernel.search import bisected
from fabric_kernel.textile import spacings

# Stride of the search for an arrest below and a perforation above, and width at which bisection ends, in parts of the velocity.
STRIDE, WIDTH = 1.25, 1.01
# That width as a resolution.
BISECTION = 0.01
# Error of the absorbed energy for which fine networks are graded: their limits are compared by `python -m evidence grading`.
GRADED = 0.005
ENDS = ("arrested", "exited", "detached", "rebounded")


def splitmix64(x):
    """One step of that sequence, as the kernel mixes its keys."""
    mask = 2**64 - 1
    z = (x + 0x9E3779B97F4A7C15) & mask
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
    return z ^ (z >> 31)


def sheet(fabric, width, bar):
    """A square sheet of a textile, so many metres wide and held on four sides, with a bar for so many yarns: mass, stiffness and
    strength per width are those of the textile. Both directions must be alike. Without a thickness of its own it is a surface."""
    scene = Scene("sheet_3in_sphere", fabric={"thickness": 0.0} | fabric)
    spacing = scene["sheet.spacing"] * bar
    nodes = math.floor(width / spacing + 0.5) + 1
    return scene.replace(
        {
            "sheet.spacing": spacing,
            "sheet.yarn_area": scene["sheet.yarn_area"] * bar,
            "sheet.node_mass": scene["sheet.node_mass"] * (bar * bar),
            "sheet.nodes_x": nodes,
            "sheet.nodes_y": nodes,
            "attachment.kind": "four_sides",
        }
    )


def shot(scene, velocity, hit):
    """The scene with this velocity, its projectile against the sheet at a place in the middle cell that `hit` draws, as other
    draws."""
    point = [((splitmix64(2 * hit + k) >> 11) / 2**53 - 0.5) * h for k, h in enumerate(spacings(scene))]
    return scene.replace({"seed": scene["seed"] + hit, "projectile.velocity": [0.0, 0.0, velocity]}).aimed(point)


def impact(scene, longest):
    """Runs an impact to its outcome; after so many seconds it is given up.

    absorbed, rubbed: work on the fabric, and what friction took of it, J; velocity along z, m/s; through: of a run that was given
    up, whether the projectile still moves on with 5 % of its velocity; residual: of the energy balance, in parts of the impact
    energy.
    """
    simulation = Simulation(scene, warns=False)
    ends = (*ENDS, "through") if scene["track_through"] else ENDS
    simulation.run(ends, int(longest / simulation.step_limits()["dt"]))
    first, velocity, outcomes = scene["projectile.velocity"][2], simulation.projectile()["velocity"][2], simulation.outcomes()
    energy, counters = simulation.energy(), simulation.counters()
    return {
        "absorbed": energy["contact_work"],
        "rubbed": energy["friction"],
        "velocity": velocity,
        "through": not any(name in outcomes for name in STOPPED)
        if any(name in outcomes for name in ends)
        else velocity > 0.05 * first,
        "failed": counters["failed_segments"],
        "residual": energy["residual"] / (0.5 * scene["projectile.mass"] * first * first),
        "unconverged": counters["unconverged"],
        "ply_penetration": counters["ply_penetration"],
    }


def limit(scene, guess, hit, longest):
    """The ballistic limit of one hit, m/s: strides from the guess until it lies between two velocities, then bisection of the
    logarithm."""
    scene = scene.replace({"track_through": True})
    return bracketed(guess, lambda velocity: impact(shot(scene, velocity, hit), longest)["through"])


def bracket(guess, through, stride):
    """Two velocities a stride apart of which the faster goes through, m/s."""
    low = guess
    while through(low):
        low /= stride
    high = low * stride
    while low >= guess and not through(high):
        low, high = high, high * stride
    return low, high


def between(low, high, through, width):
    """Where a velocity between these two begins to go through, m/s, to half of this width, a ratio: bisection of the
    logarithm."""
    low, high = bisected(low, high, through, ratio=width)
    return math.sqrt(low * high)


def bracketed(guess, through):
    """Limit from a guess, to half of WIDTH."""
    return between(*bracket(guess, through, STRIDE), through, WIDTH)
