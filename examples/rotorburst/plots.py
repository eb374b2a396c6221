"""The pictures of a run: time histories, and the deformed sheet."""

import csv

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize

from balances import went_through
from fragment import rotation

BLUE, RED, GREEN, ORANGE, GREY = "#1f5a94", "#b8322a", "#3c7d4a", "#d98a1f", "#6b7280"
STRAIN = LinearSegmentedColormap.from_list("strain", ["#9ebdd9", "#f4e38b", "#f28e2b", "#d7191c"])
SPACING = 0.0254 / 35.0  # of the nodes at rest, m: all cases have the paper's mesh
DAMAGED = 0.5 * (1.03**2 - 1.0)  # strain from which the paper's yarn is damaged; the colours end there
BEHIND = "#1f2937"  # what is seen through a hole

plt.rcParams.update(
    {
        "font.size": 10,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "#e5e7eb",
        "axes.axisbelow": True,
        "axes.edgecolor": "#4b5563",
        "legend.frameon": False,
        "savefig.dpi": 160,
        "savefig.bbox": "tight",
    }
)


def read_history(path):
    """Columns of history.csv by name."""
    with open(path, newline="") as file:
        lines = list(csv.reader(file))
    return dict(zip(lines[0], np.array(lines[1:], dtype=float).T))


class Times:
    """The coupled part of a history, in microseconds since first contact, and marks for the events."""

    def __init__(self, history, results):
        self.zero = results["first_contact"] if results["first_contact"] >= 0.0 else results["start"]
        self.rows = history["time"] > results["start"]
        self.t = 1e6 * (history["time"][self.rows] - self.zero)
        self.history = history
        self.through = went_through(results)
        self.marks = []
        if "detached" in results:
            self.marks.append((1e6 * (results["detached"]["time"] - self.zero), "detached"))
        elif self.through:
            work = self.column("contact.work")
            self.marks.append((self.t[work >= 0.99 * work.max()][0], "99 % absorbed"))
        self.marks.append((1e6 * (results["end_time"] - self.zero), results["end"]))

    def column(self, name):
        return self.history[name][self.rows]

    def axes(self, label):
        """A figure with time along x."""
        figure, axes = plt.subplots(figsize=(7.2, 3.6))
        axes.set(xlabel="time since first contact / µs", ylabel=label, xlim=(min(self.t[0], 0.0), self.t[-1] * 1.02))
        if self.through and len(self.marks) == 2:
            axes.axvspan(self.marks[0][0], axes.get_xlim()[1], color="#f3f4f6", zorder=0)
            axes.text(0.995, 0.5, "after perforation", rotation=90, ha="right", va="center", transform=axes.transAxes, color=GREY, fontsize=8)
        for time, name in self.marks:
            axes.axvline(time, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)))
            axes.annotate(name, (time, 1.0), (0, 2), xycoords=("data", "axes fraction"), textcoords="offset points",
                          ha="center", va="bottom", fontsize=9, color=GREY)  # fmt: skip
        return figure, axes


def save(figure, path):
    figure.savefig(path)
    plt.close(figure)


def velocity(times, path):
    figure, axes = times.axes("velocity along the flight / (m/s)")
    v = times.column("velocity[3]")
    axes.plot(times.t, v, color=BLUE)
    axes.annotate(f"{v[-1]:.2f} m/s", (times.t[-1], v[-1]), (-24, 6), textcoords="offset points", ha="right", color=BLUE)
    save(figure, path)


def force(times, path, step):
    figure, axes = times.axes("force on the fragment / kN")
    axes.plot(times.t, -1e-3 * times.column("contact.force_mean[3]"), color=RED, linewidth=0.9,
              label=f"mean over a communication step of {1e6 * step:g} µs")  # fmt: skip
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper right")
    save(figure, path)


def energies(times, path):
    figure, axes = times.axes("energy / J")
    parts = [("energy.kinetic", "kinetic energy of the sheet", BLUE), ("energy.strain", "strain energy", GREEN),
             ("energy.dissipated", "dissipated by rupture", RED), ("energy.contact_loss", "lost in nodal impacts", ORANGE)]  # fmt: skip
    axes.plot(times.t, times.column("contact.work"), color="black", linewidth=1.6, label="absorbed (work of the fragment)")
    for name, label, colour in parts:
        axes.plot(times.t, times.column(name), color=colour, label=label)
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, fontsize=9)
    save(figure, path)


def damage(times, path):
    figure, axes = times.axes("failed segments")
    axes.plot(times.t, times.column("fabric.failed_segments"), color=RED, drawstyle="steps-post")
    axes.set_ylim(bottom=0.0)
    save(figure, path)


class Snapshots:
    """What the kernel's example `snapshots` wrote."""

    def __init__(self, path):
        values = np.fromfile(path, dtype="<f8")
        self.nx, self.ny, count = (int(x) for x in values[:3])
        nodes, along = self.nx * self.ny, (self.nx - 1) * self.ny
        size = 8 + 3 * nodes + along + self.nx * (self.ny - 1)
        self.pictures = []
        for k in range(count):
            part = values[3 + k * size : 3 + (k + 1) * size]
            alpha = part[8 + 3 * nodes :]
            self.pictures.append(
                {
                    "time": part[0],
                    "position": part[1:4],
                    "orientation": part[4:8],
                    "nodes": part[8 : 8 + 3 * nodes].reshape(self.ny, self.nx, 3),
                    "alpha_x": alpha[:along].reshape(self.ny, self.nx - 1),
                    "alpha_y": alpha[along:].reshape(self.ny - 1, self.nx),
                }
            )
        self.outcome, *self.velocity, self.absorbed, self.failed = values[3 + count * size :]


VIEW = np.radians(28.0)  # elevation of the eye above the sheet; it looks along +y
EYE = np.array([0.0, -np.cos(VIEW), np.sin(VIEW)])
LIGHT = np.array([-0.5, -0.35, 0.8]) / np.linalg.norm([-0.5, -0.35, 0.8])


def sheet(snapshots, results, path):
    """Four oblique views of the whole sheet, seen from the side the fragment leaves by."""
    half, depth = 0.5e3 * SPACING * (snapshots.nx - 1), 0.5e3 * SPACING * np.sin(VIEW) * (snapshots.ny - 1)
    # The fragment is where the sheet is deepest; what is torn off may fly out of the picture.
    outlines = np.concatenate([outline for picture in snapshots.pictures for outline, _ in fragment_faces(picture, results["body"])])
    heights = [-depth, depth, *projected(outlines)[:, 1]]
    low, high = min(heights) - 0.06 * depth, max(heights) + 0.06 * depth
    width = 5.2
    figure, grid = plt.subplots(2, 2, figsize=(2 * width + 1.0, 2 * (width * (high - low) / (2.04 * half) + 0.35)),
                                layout="constrained")  # fmt: skip
    zero = max(results["first_contact"] - results["start"], 0.0)
    for axes, picture in zip(grid.flat, snapshots.pictures):
        draw_sheet(axes, picture, results["body"])
        axes.set(xlim=(-1.04 * half, 1.04 * half), ylim=(low, high), aspect="equal", xticks=[], yticks=[], facecolor=BEHIND)
        axes.spines[:].set_visible(False)
        axes.set_title(f"{1e6 * (picture['time'] - zero):.0f} µs after first contact", fontsize=10)
    bar = figure.colorbar(ScalarMappable(Normalize(0.0, 100.0 * DAMAGED), STRAIN), ax=grid, shrink=0.6, aspect=28, pad=0.01, extend="max")
    bar.set_label("Green-Lagrange strain of what still holds / % (above: damage)")
    bar.outline.set_visible(False)
    save(figure, path)


def projected(points):
    """Screen coordinates, mm: x to the right, y into the depth, z upwards."""
    points = 1e3 * np.asarray(points)
    return np.stack([points[..., 0], np.sin(VIEW) * points[..., 1] + np.cos(VIEW) * points[..., 2]], axis=-1)


def draw_sheet(axes, picture, body):
    """The fragment (dashed where it is hidden), what of the sheet is behind it, and what is before it: cells of four segments that
    hold as shaded faces, coloured by their most strained segment; damaged or loose segments as lines."""
    nodes, along, up = picture["nodes"], picture["alpha_x"] > 0.0, picture["alpha_y"] > 0.0
    whole = along[:-1] & along[1:] & up[:, :-1] & up[:, 1:]
    corners = np.stack([nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]], axis=2)[whole]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    shade = 0.1 + 1.05 * np.abs(normals @ LIGHT)
    strain_x, strain_y = (share_of_damaging(np.diff(nodes, axis=axis)) for axis in (1, 0))
    most = np.maximum.reduce([strain_x[:-1], strain_x[1:], strain_y[:, :-1], strain_y[:, 1:]])[whole]
    colours = np.clip(shade[:, None] * STRAIN(most)[:, :3], 0.0, 1.0)
    before = is_before(corners.mean(axis=1), picture, body)
    for part, layer in [(~before, 1), (before, 4)]:
        order = np.argsort(corners[part].mean(axis=1) @ EYE, kind="stable")
        faces = projected(corners[part])[order]
        axes.add_collection(PolyCollection(faces, facecolors=colours[part][order], edgecolors="face", linewidths=0.6, zorder=layer))

    bordering = np.pad(whole, 1)
    single_x = along & ~(bordering[:-1, 1:-1] | bordering[1:, 1:-1])
    single_y = up & ~(bordering[1:-1, :-1] | bordering[1:-1, 1:])
    for alpha, strain, single, a, b in [
        (picture["alpha_x"], strain_x, single_x, nodes[:, :-1], nodes[:, 1:]),
        (picture["alpha_y"], strain_y, single_y, nodes[:-1], nodes[1:]),
    ]:
        damaged = (alpha > 0.0) & (alpha < 0.999)
        drawn = single | damaged
        lines = np.stack([projected(a[drawn]), projected(b[drawn])], axis=1)
        colours = STRAIN(strain[drawn])
        widths = np.where(damaged[drawn], 1.8, 0.5)
        before = is_before(0.5 * (a[drawn] + b[drawn]), picture, body)
        for part, layer in [(~before, 2), (before, 5)]:
            axes.add_collection(LineCollection(lines[part], colors=colours[part], linewidths=widths[part], zorder=layer))

    for outline, colour in fragment_faces(picture, body):
        axes.fill(*projected(outline).T, facecolor=colour, edgecolor="#111827", linewidth=0.6, zorder=3)
        axes.fill(*projected(outline).T, fill=False, edgecolor="#111827", linewidth=0.5, linestyle=(0, (2, 3)), alpha=0.6, zorder=6)


def share_of_damaging(segments):
    """Green-Lagrange strain of segments, over that from which the yarn is damaged."""
    return 0.5 * ((segments**2).sum(axis=2) / SPACING**2 - 1.0) / DAMAGED


def is_before(points, picture, body):
    """Whether points of the sheet are nearer to the eye than the fragment: outside of a face that the eye sees."""
    away = points - picture["position"]
    if body["shape"] == "sphere":
        return away @ EYE > 0.0
    if body["shape"] == "disc sector":
        turn, corners = rotation(picture["orientation"]), np.array(body["corners"])
        edges = np.roll(corners, -1, axis=0) - corners
        outward = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
        normals = np.vstack([np.pad(outward, ((0, 0), (0, 1))), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]]) @ turn.T
        reach = np.append((outward * corners).sum(axis=1), [0.5 * body["thickness"]] * 2)
        seen = normals @ EYE > 0.0
        return (away @ normals[seen].T > reach[seen] - 5e-4).any(axis=-1)
    nose = away @ rotation(picture["orientation"])[:, 2] > 0.5 * body["length"] - 5e-4
    return nose | (away[..., 1] < 0.0)


def fragment_faces(picture, body):
    """Outline of the fragment as polygons in space, with colours, the farthest first: a sphere's disc, a cylinder's side and ends, a prism's faces."""
    circle = np.linspace(0.0, 2.0 * np.pi, 73)
    centre = picture["position"]
    if body["shape"] == "disc sector":
        turn = rotation(picture["orientation"])
        rim, half = np.array(body["corners"]) @ turn[:, :2].T, 0.5 * body["thickness"] * turn[:, 2]
        near, far = centre + rim + half, centre + rim - half
        sides = [np.array([near[k - 1], near[k], far[k], far[k - 1]]) for k in range(len(rim))]
        faces = sorted([near, far, *sides], key=lambda face: face.mean(axis=0) @ EYE)
        return [(face, "#d1d5db" if len(face) > 4 else "#9ca3af") for face in faces]
    radius = body["radius"]
    if body["shape"] == "sphere":
        up = np.array([0.0, np.sin(VIEW), np.cos(VIEW)])
        ring = np.outer(np.cos(circle), [1.0, 0.0, 0.0]) + np.outer(np.sin(circle), up)
        return [(centre + radius * ring, "#9ca3af")]
    turn = rotation(picture["orientation"])
    axis = turn[:, 2]
    across = np.cross(axis, EYE)
    across *= radius / np.linalg.norm(across)
    half = 0.5 * body["length"] * axis
    ring = radius * (np.outer(np.cos(circle), turn[:, 0]) + np.outer(np.sin(circle), turn[:, 1]))
    near = half if axis @ EYE > 0.0 else -half
    side = np.array([centre + half + across, centre + half - across, centre - half - across, centre - half + across])
    return [(centre - near + ring, "#6b7280"), (side, "#9ca3af"), (centre + near + ring, "#d1d5db")]
