"""Whole impacts that several questions share: the preset sphere at 40 J on the 3 in sheet, every attachment, uniform and
stochastic yarn.

Runs of an ensemble differ by 1e-12 in the impact velocity; a stochastic sheet is the same one (seed 1) in all of them. A run ends
when the sphere is arrested or has exited, at the corners when the last yarn from the sphere to a support is gone: whether the
torn sheet pulls once more is up to rounding.

Cost is counted in node-steps: evaluations of the force on a node, one a step with velocity Verlet, one an iteration with the
theta rule. They are the same on every machine. Rows of nodes that the wave has not reached are counted though skipped.
"""

import math
from typing import NamedTuple

from fabric_kernel import Failed, Scene, Simulation

# Energy of the sphere, J; by which velocities of an ensemble differ: large against rounding, small against everything else; step
# over dt_crit; time after which a run is given up, s.
ENERGY, ROUNDING, DEFAULT, LONGEST = 40.0, 1e-12, 0.4, 2e-3
MEASURES = ("absorbed", "velocity", "force", "failed")


class Case(NamedTuple):
    name: str
    kind: str
    stochastic: bool

    @property
    def end(self):
        return ["arrested", "exited"] + ["detached"] * (self.kind == "four_corners")


CASES = [
    Case(f"{held}, {yarn}", kind, yarn == "stochastic")
    for held, kind in (("four sides", "four_sides"), ("two sides", "two_sides"), ("corners", "four_corners"))
    for yarn in ("uniform", "stochastic")
]


def scene_of(case, smoke, faster=0.0, quarter=False):
    """The scene of a case, whose velocity is higher by this part of it; of the whole sheet or of a quarter."""
    scene = Scene("sheet_3in_sphere", sheet={"nodes_x": 41, "nodes_y": 41} if smoke else {})
    speed = math.sqrt(2.0 * ENERGY / scene["projectile.mass"])
    changes = {"attachment.kind": case.kind, "yarn.stochastic": case.stochastic, "time_step.fraction": DEFAULT}
    changes |= {f"symmetry.mirror_{axis}": quarter for axis in "xy"}
    return scene.replace(changes | {"projectile.velocity": [0.0, 0.0, speed * (1.0 + faster)]})


def node_steps(simulation):
    """Evaluations of the forces on nodes so far."""
    counters, nodes = simulation.counters(), simulation.positions()[..., 0].size
    return (counters["iterations"] or counters["steps"]) * nodes


def segments(scene):
    nx, ny = scene["sheet.nodes_x"], scene["sheet.nodes_y"]
    return ((nx - 1) * ny + (ny - 1) * nx) * scene["stack.plies"]


def impact(job):
    """Runs until one of the outcomes. values: the measures in J, m/s, N, % of the segments; trouble: why there are none."""
    scene, end = job[:2]
    simulation = Simulation(scene, warns=False)
    steps, trouble = int(LONGEST / simulation.step_limits()["dt"]), None
    try:
        simulation.run(end, steps)
        trouble = "TIMEOUT" if simulation.step_count >= steps else None
    except Failed as failed:
        trouble = failed.code
    found = {"node_steps": node_steps(simulation), "trouble": trouble}
    if trouble:
        return found
    contact, failed = simulation.contact(), simulation.counters()["failed_segments"]
    values = [contact["work"], simulation.projectile()["velocity"][2], contact["force_peak"], 100.0 * failed / segments(scene)]
    return found | {"values": dict(zip(MEASURES, values))}
