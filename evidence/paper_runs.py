"""The runs behind the paper's figures, and what is read off them.

A point is an ensemble of runs that differ in their seed, or, with uniform yarn, in the last digits of the impact velocity. A run
ends when the projectile is arrested or has exited; a mirror-symmetric sheet when detached at the latest: torn off evenly at all
corners, it wraps the sphere and flies with it.
"""

import math
from typing import NamedTuple

import numpy
from fabric_kernel import Scene, Simulation
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from .statistics import Estimate, mean
from .study import FULL, QUICK, SMOKE, clock

CORNERS, TWO_SIDES, FOUR_SIDES = "corners", "two sides", "four sides"
KINDS = {TWO_SIDES: "two_sides", FOUR_SIDES: "four_sides", CORNERS: "four_corners"}
# The order in which tables and plots show them.
ATTACHMENTS = [TWO_SIDES, FOUR_SIDES, CORNERS]
# Every segment draws its own modulus and damage rate; all take the mean, and rounding decides which corner fails first; the same,
# kept mirror-symmetric by planes; every woven yarn draws once.
STOCHASTIC, UNIFORM = "stochastic", "uniform"
SYMMETRIC, WOVEN = "uniform, mirror-symmetric", "stochastic, one sample per yarn"
SMALL, LARGE = "3 in, sphere", "10 in, cylinder"
# Impact energies on the 3 in sheet, those of the map of the open question, about the limit at the corners, those of its washers
# that are not the preset ones, and those of the histories (Figs 15 to 17), J; velocities on the 10 in sheet, m/s; of each the
# full, the quick and the smoke list.
ENERGIES = {FULL: (2.5, 5.0, 7.5, 10.0, 15.0, 20.0, 40.0, 80.0, 160.0, 320.0), QUICK: (10.0, 20.0, 160.0), SMOKE: (20.0, 160.0)}
MAP_ENERGIES = {FULL: (5.0, 7.5, 10.0, 12.5, 15.0, 20.0), QUICK: (10.0,), SMOKE: (20.0,)}
OTHER_ENERGIES, HISTORY_ENERGIES = (10.0, 15.0), (20.0, 160.0)
VELOCITIES = {FULL: (40.0, 60.0, 80.0, 100.0, 140.0, 200.0), QUICK: (100.0, 200.0), SMOKE: (100.0, 200.0)}
# Runs of a point on either sheet.
RUNS = {FULL: {SMALL: 10, LARGE: 3}, QUICK: {SMALL: 3, LARGE: 1}, SMOKE: {SMALL: 2, LARGE: 2}}
# Distance of a washer's centre from both edges and its radius, m: that of the preset, and the other readings of the paper's text.
WASHERS = {
    "preset: c 7.62, r 5.715 mm": (7.62e-3, 5.715e-3),
    "larger: c 12.7, r 9.525 mm": (12.7e-3, 9.525e-3),
    "smaller: c 7.62, r 2.9 mm": (7.62e-3, 2.9e-3),
    "quarter disc: c 0, r 5.715 mm": (0.0, 5.715e-3),
    "quarter disc: c 0, r 9.5 mm": (0.0, 9.5e-3),
}
PRESET = next(iter(WASHERS))
# Most steps of a run on the 10 in sheet in quick form: one run at the corners would take a third of all the time, and that the
# sheet is torn off is seen before. Nodes along a side of the tiny sheets.
LARGE_QUICK_STEPS, SMOKE_NODES = 80_000, 35
# Time between two samples of a history while the impact is young, and later, s.
FINE, COARSE, FINE_UNTIL = 2e-6, 10e-6, 200e-6
# Lines of the undeformed grid from an attachment within which a failure counts as there; radii of the projectile likewise from
# the centre.
ATTACHMENT_ZONE, CENTRE_ZONE = 5.0, 2.0
# Time from the first failure until the places of failure are counted, s; failed segments closer than so many spacings are one
# place.
SPREAD, PLACE = 10e-6, 5.0


def number(value):
    """2.5, 10: without needless zeros."""
    return f"{value:g}"


class Point(NamedTuple):
    """impact: J on the 3 in sheet, m/s on the 10 in sheet."""

    sheet: str
    attachment: str
    yarn: str
    impact: float
    washer: str = PRESET

    def scene(self, effort, k):
        """The scene of run k, k from 0."""
        scene = Scene("sheet_3in_sphere" if self.sheet == SMALL else "sheet_10in_cylinder")
        changes, scale = {"attachment.kind": KINDS[self.attachment]}, 1.0
        if effort == SMOKE:
            scale = (SMOKE_NODES - 1) / (scene["sheet.nodes_x"] - 1)
            changes |= {"sheet.nodes_x": SMOKE_NODES, "sheet.nodes_y": SMOKE_NODES}
        if self.attachment == CORNERS:
            discs = (
                WASHERS[self.washer] if self.sheet == SMALL else (scene["attachment.disc_inset"], scene["attachment.disc_radius"])
            )
            changes |= dict(zip(("attachment.disc_inset", "attachment.disc_radius"), (scale * part for part in discs)))
        speed = math.sqrt(2.0 * self.impact / scene["projectile.mass"]) if self.sheet == SMALL else self.impact
        if self.yarn in (STOCHASTIC, WOVEN):
            changes |= {"seed": k + 1} | ({"yarn.draw": "yarn"} if self.yarn == WOVEN else {})
        else:
            changes |= {
                "yarn.stochastic": False,
                "symmetry.mirror_x": self.yarn == SYMMETRIC,
                "symmetry.mirror_y": self.yarn == SYMMETRIC,
            }
            speed *= 1.0 + k * 1e-12
        return scene.replace(changes | {"projectile.velocity": [0.0, 0.0, speed]})

    def steps(self, effort):
        """Most steps of a run; one that these end is a timeout."""
        if effort == SMOKE:
            return 5_000
        if self.sheet == LARGE:
            return LARGE_QUICK_STEPS if effort == QUICK else 120_000
        # These end when detached at the latest, within about 1 ms.
        return 50_000 if self.yarn == SYMMETRIC else 100_000


def points(effort):
    """Every ensemble, once."""
    found = [Point(LARGE, kind, STOCHASTIC, velocity) for kind in ATTACHMENTS for velocity in VELOCITIES[effort]]
    found += [
        Point(SMALL, kind, yarn, energy) for yarn in (STOCHASTIC, UNIFORM) for kind in ATTACHMENTS for energy in ENERGIES[effort]
    ]
    # How failure begins in mirror-symmetric clamped sheets.
    found += [Point(SMALL, kind, SYMMETRIC, energy) for kind in (TWO_SIDES, FOUR_SIDES) for energy in HISTORY_ENERGIES]
    for washer in washers(effort):
        # All energies for the preset washers, which alone are tried with one sample per yarn too.
        energies = [energy for energy in MAP_ENERGIES[effort] if washer == PRESET or effort != FULL or energy in OTHER_ENERGIES]
        yarns = [STOCHASTIC, UNIFORM, SYMMETRIC] + [WOVEN] * (effort != QUICK and washer == PRESET)
        found += [Point(SMALL, CORNERS, yarn, energy, washer) for yarn in yarns for energy in energies]
    return list(dict.fromkeys(found))


def washers(effort):
    return list(WASHERS)[: 5 if effort == FULL else 2]


def left_out(effort):
    """What is left out against the full study, in words."""
    if effort == FULL:
        return "Ten runs a point on the 3 in sheet."
    lacking = lambda lists: ", ".join(number(value) for value in lists[FULL] if value not in lists[effort])
    tiny = f"A smoke test: sheets of {SMOKE_NODES} x {SMOKE_NODES} nodes; nothing here says anything about the paper."
    shape = f"Runs on the 10 in sheet end after {LARGE_QUICK_STEPS} steps at the latest." if effort == QUICK else tiny
    return (
        f"{shape} Left out against the full study: impact energies {lacking(ENERGIES)} J on the 3 in sheet, velocities "
        f"{lacking(VELOCITIES)} m/s on the 10 in sheet. In the map of the open question: energies {lacking(MAP_ENERGIES)} J, "
        f"one sample per yarn, and all washers but the first {len(washers(effort))}. Runs per point: {RUNS[effort][SMALL]} "
        f"instead of 10 on the 3 in sheet, {RUNS[effort][LARGE]} instead of 3 on the 10 in sheet."
    )


class Watched:
    """A simulation with what is seen on its way."""

    def __init__(self, scene):
        self.scene, self.simulation = scene, Simulation(scene, warns=False)
        self.mirrored = scene["symmetry.mirror_x"]
        self.until = ["arrested", "exited"] + ["detached"] * self.mirrored
        self.rows, self.columns = self.simulation.positions().shape[:2]
        self.first = self.places = None
        self.torn, self.seen = [None] * 4, 0

    def over(self):
        return any(name in self.simulation.outcomes() for name in self.until)

    def failed(self):
        return self.simulation.counters()["failed_segments"]

    def middles(self):
        """Middles of the failed segments in the undeformed sheet, in spacings from its centre; of a mirrored sheet of the part
        that is modelled. A mirrored line has one segment more, from its last node to an image."""
        numbers = numpy.nonzero(self.simulation.damage() <= 0)[0]
        return middles(numbers, self.columns, self.rows, self.scene["sheet.nodes_x"], self.scene["sheet.nodes_y"], self.mirrored)

    def advance(self, steps):
        """So many steps; finds out on the way when the first segments fail, and at how many places some time later."""
        simulation, end = self.simulation, self.simulation.step_count + steps
        if not self.first:
            simulation.run(self.until, steps, failed=1)
            if self.failed():
                self.first = simulation.time, len(with_images(self.middles(), self.mirrored))
        while self.first and self.places is None and simulation.step_count < end and not self.over():
            left = (self.first[0] + SPREAD - simulation.time) / simulation.step_limits()["dt"]
            simulation.run(self.until, min(max(int(left) - 1, 1), end - simulation.step_count))
            if simulation.time >= self.first[0] + SPREAD:
                self.places = count_groups(with_images(self.middles(), self.mirrored))
        simulation.run(self.until, end - simulation.step_count)

    def look_for_torn(self, corners):
        """Notes the time for each corner that is no longer joined to the largest whole piece of the sheet."""
        if self.failed() == self.seen or None not in self.torn:
            return
        self.seen, nodes = self.failed(), self.rows * self.columns
        node = numpy.arange(nodes).reshape(self.rows, self.columns)
        ends = numpy.concatenate(
            [numpy.stack([a.ravel(), b.ravel()]) for a, b in ((node[:, :-1], node[:, 1:]), (node[:-1], node[1:]))], axis=1
        )
        ends = ends[:, self.simulation.damage() > 0]
        _, labels = connected_components(coo_array((numpy.ones(ends.shape[1], "i1"), ends), shape=(nodes, nodes)), directed=False)
        largest = numpy.bincount(labels).argmax()
        self.torn = [
            self.simulation.time if time is None and labels[corner] != largest else time
            for time, corner in zip(self.torn, corners)
        ]

    def where_failed(self):
        """Failed segments near an attachment and near the centre, by the middles in the undeformed sheet, and corners with one
        nearby."""
        h, (x, y) = self.scene["sheet.spacing"], self.scene["sheet.spacing"] * self.middles().T
        edge_x, edge_y = (0.5 * h * (self.scene[f"sheet.nodes_{axis}"] - 1) - abs(at) for axis, at in (("x", x), ("y", y)))
        zone, kind = ATTACHMENT_ZONE * h, self.scene["attachment.kind"]
        near = edge_x <= zone if kind == "two_sides" else (edge_x <= zone) | (edge_y <= zone)
        if kind == "four_corners":
            inset = self.scene["attachment.disc_inset"]
            near = numpy.hypot(edge_x - inset, edge_y - inset) <= self.scene["attachment.disc_radius"] + zone
        centre = numpy.hypot(x, y) <= CENTRE_ZONE * self.scene["projectile.radius"]
        near &= ~centre
        corners = len(set(zip(x[near] > 0, y[near] > 0))) if kind == "four_corners" else 0
        return [int(near.sum()), int(centre.sum())], corners


def middles(numbers, columns, rows, nodes_x, nodes_y, mirrored):
    across = columns if mirrored else columns - 1
    along = numbers < across * rows
    rest = numpy.where(along, numbers, numbers - across * rows)
    width = numpy.where(along, across, columns)
    x, y = rest % width - 0.5 * (nodes_x - 1), rest // width - 0.5 * (nodes_y - 1)
    return numpy.stack([x + 0.5 * along, y + 0.5 * ~along], axis=1)


def with_images(places, mirrored):
    """These places with their mirror images, each once."""
    if mirrored:
        places = numpy.concatenate([places * [i, j] for i in (1, -1) for j in (1, -1)]) + 0.0
    return numpy.unique(places, axis=0)


def count_groups(places):
    """Number of groups whose members are joined by distances of at most PLACE."""
    if not len(places):
        return 0
    pairs = cKDTree(places).query_pairs(PLACE, output_type="ndarray")
    return int(connected_components(coo_array((numpy.ones(len(pairs)), pairs.T), shape=(len(places),) * 2), directed=False)[0])


def corners_of(scene):
    """The node under the middle of each washer, which is held."""
    nx, ny, k = scene["sheet.nodes_x"], scene["sheet.nodes_y"], round(scene["attachment.disc_inset"] / scene["sheet.spacing"])
    return [j * nx + i for j in (k, ny - 1 - k) for i in (k, nx - 1 - k)]


def flown(job):
    """A run: its record. Energies in J, times in s; cpu: processor time, the only entry that differs from run to run."""
    scene, most = job
    begin, watched = clock(), Watched(scene)
    simulation, whole = watched.simulation, not watched.mirrored
    corners = (
        corners_of(scene)
        if whole and scene["attachment.kind"] == "four_corners" and scene["projectile.shape"] == "sphere"
        else None
    )
    dt, energy, history = simulation.step_limits()["dt"], simulation.energy(), []
    start = energy["projectile_kinetic"]

    def sample():
        energy = simulation.energy()
        values = [energy[name] for name in ("contact_work", "fabric_kinetic", "strain", "dissipated", "contact_loss")]
        # Six digits are more than a plot shows.
        history.append([round(simulation.time, 10), *(round(value, 6) for value in values)])

    sample()
    while simulation.step_count < most and not watched.over():
        pause = FINE if simulation.time < FINE_UNTIL else COARSE
        watched.advance(min(max(round(pause / dt), 1), most - simulation.step_count))
        sample()
        if corners:
            watched.look_for_torn(corners)
    if watched.first and watched.places is None:
        watched.places = count_groups(with_images(watched.middles(), watched.mirrored))
    outcomes, (failed_at, failed_corners) = simulation.outcomes(), watched.where_failed() if whole else ([0, 0], 0)
    detached = outcomes.get("detached")
    first = watched.first and {"time": watched.first[0], "segments": watched.first[1], "places": watched.places}
    columns = dict(zip(("t", "lost", "kinetic", "strain", "dissipated", "loss"), zip(*history)))
    return {
        "arrested": "arrested" in outcomes,
        "timeout": not watched.over(),
        "time": simulation.time,
        "energy": start,
        "absorbed": simulation.contact()["work"],
        "detached": detached and [detached["time"], detached["work"]],
        "residual_velocity": simulation.projectile()["velocity"][2],
        "peak_kinetic": max(columns["kinetic"]),
        "peak_strain": max(columns["strain"]),
        "failed": watched.failed(),
        "failed_at": failed_at,
        "failed_corners": failed_corners,
        "first_failure": first,
        "torn": watched.torn,
        "audit": simulation.energy()["residual"] / start,
        "cpu": round(clock() - begin, 3),
        "history": columns,
    }


class Run:
    """What a run gave."""

    def __init__(self, record):
        self.__dict__.update(record)
        self.history = {key: numpy.array(values) for key, values in record["history"].items()}
        self.torn = sorted(time for time in record["torn"] if time is not None)

    def sampled(self, key, time):
        """Between samples; the last one if the run was over before."""
        return float(numpy.interp(time, self.history["t"], self.history[key]))

    def at_detached(self):
        """Energy absorbed when the last contact lost its supports; at the end if it never did."""
        return self.detached[1] if self.detached else self.absorbed

    def dissipated_at_detached(self):
        return self.sampled("dissipated", self.detached[0] if self.detached else math.inf)

    def yarn_work_at_detached(self):
        """Strain energy and energy dissipated by rupture."""
        return self.dissipated_at_detached() + self.sampled("strain", self.detached[0] if self.detached else math.inf)

    def dissipated_at_end(self):
        return float(self.history["dissipated"][-1])

    def largest_yarn_work(self):
        return float((self.history["strain"] + self.history["dissipated"]).max())

    def absorbed_at(self, time):
        """At the end if the run was over before."""
        return self.sampled("lost", time) if time <= self.history["t"][-1] else self.absorbed

    def left(self):
        """Kinetic energy that the projectile keeps."""
        return self.energy - self.absorbed

    def share_at_attachments(self):
        """Part of the failed segments that lie near an attachment; NaN if none failed."""
        return self.failed_at[0] / self.failed if self.failed else math.nan

    def share_at_centre(self):
        return self.failed_at[1] / self.failed if self.failed else math.nan

    def residual(self):
        """Residual velocity, m/s: 0 if the projectile was arrested (it is then pushed back)."""
        return 0.0 if self.arrested else self.residual_velocity


class Runs:
    """All that was computed."""

    def __init__(self, study):
        self.effort, self.points = study.effort, points(study.effort)
        self.energies, self.map_energies, self.history_energies = (
            ENERGIES[self.effort],
            MAP_ENERGIES[self.effort],
            HISTORY_ENERGIES,
        )
        self.washers, self.scope = washers(self.effort), left_out(self.effort)
        wanted = [
            (point, point.scene(self.effort, k), point.steps(self.effort))
            for point in self.points
            for k in range(RUNS[self.effort][point.sheet])
        ]
        # The longest first, so that no core idles at the end: nodes, a quarter of them where it is mirrored.
        cost = lambda scene: -scene["sheet.nodes_x"] * scene["sheet.nodes_y"] * (0.25 if scene["symmetry.mirror_x"] else 1.0)
        wanted.sort(key=lambda job: cost(job[1]))
        self.by_point = {point: [] for point in self.points}
        for (point, *_), record in zip(wanted, study.each(flown, [job[1:] for job in wanted])):
            self.by_point[point].append(Run(record))
        self.all = [run for ensemble in self.by_point.values() for run in ensemble]

    def of(self, attachment, yarn, impact, washer=PRESET, sheet=SMALL):
        """The runs of an ensemble; none if it was not computed."""
        return self.by_point.get(Point(sheet, attachment, yarn, impact, washer), [])

    def values(self, attachment, yarn, energy, value):
        return [value(run) for run in self.of(attachment, yarn, energy)]

    def mean_of(self, attachment, yarn, energy, value):
        """Mean of a number of the runs; those for which it is not defined are left out."""
        return Estimate.mean([x for x in self.values(attachment, yarn, energy, value) if math.isfinite(x)])

    def energies_among(self, wanted):
        return [energy for energy in self.energies if energy in wanted]

    def goes_through(self, attachment, yarn, energy):
        """Whether more than half of the runs are not arrested."""
        return mean(self.values(attachment, yarn, energy, lambda run: run.arrested)) < 0.5

    def uncapped(self, *ensembles):
        """Energies at which no run of these ensembles is arrested: there nothing is capped."""
        free = lambda energy: all(
            self.of(*ensemble, energy) and not any(run.arrested for run in self.of(*ensemble, energy)) for ensemble in ensembles
        )
        return [energy for energy in self.energies if free(energy)]
