"""Sheets of a simulation at one time: pictures, and files for ParaView."""

import base64
from collections.abc import Sequence
from typing import Any

import numpy
import scipy  # Its parts are loaded where they are used.
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from . import drawing
from ._kernel import Scene, Simulation
from .checks import Array
from .files import Place, written
from .textile import sides

# Dark red for failed, over orange, to yellow for the first damage.
DAMAGE = LinearSegmentedColormap.from_list("damage", ["#8c0014", "#f06e14", "#f5c83c"])
YARN = "#5a6e8c"
# From yarn without load, linen, to dark red: the colours of the web page.
STRAIN = LinearSegmentedColormap.from_list("strain", ["#d6d3cb", "#f2cf5b", "#f28e2b", "#d1352b", "#6b0f2e"])
STEEL = numpy.array([0.36, 0.47, 0.56])
# Plies in turn, so that neighbours can be told apart.
PLIES = ["#1f4e79", "#6fa8dc"]
# The oblique view: turned by so much about z, seen from so far above the sheet, rad; the light comes from the left, above.
TURN, ABOVE = 0.53, 0.52
LIGHT = numpy.array([-0.55, -0.35, 0.76]) / numpy.linalg.norm([-0.55, -0.35, 0.76])
# Meshes drawn along a side, at most: where all of several are whole they are drawn as one.
MOST_MESHES = 130


class Sheet:
    """A sheet as it is now, of a stack one ply. positions: m, one row a node, and velocities likewise; segments: the two nodes of
    each; stretch, and alpha, 0 only where it has failed, of each."""

    def __init__(self, simulation: Any, ply: int = 0) -> None:
        scene, body, positions = simulation.scene, simulation.projectile(), simulation.positions()
        self.scene = scene
        plies = scene["stack.plies"]
        nx, ny = positions.shape[1], positions.shape[0] // plies
        self.nodes, self.radius, self.closed, self.held = (nx, ny), scene["sheet.radius"], scene["sheet.closed"], scene.held()
        self.half_size, self.critical_strain = [0.5 * side for side in sides(scene)], scene["yarn.critical_stretch"] - 1.0
        self.sphere = scene["projectile.radius"] if scene["projectile.shape"] == "sphere" else 0.0
        # Those that the kernel counts: alpha is 0 already where one fails in the next step.
        self.failed_segments: int = simulation.ply(ply)["failed_segments"]
        self.thickness = scene["sheet.thickness"] * scene["sheet.plies"]
        self.time, self.centre = simulation.time, numpy.array(body["position"])
        of_ply = lambda nodes: nodes.reshape(plies, nx * ny, 3)[ply].astype("f4").astype(float)
        self.positions, self.velocities = of_ply(positions), of_ply(simulation.velocities())
        # A mirrored line has one segment more, to an image, and so has a closed one, to its first node; it is not drawn.
        along_x, along_y = nx - 1 + (scene["symmetry.mirror_x"] or self.closed), ny - 1 + scene["symmetry.mirror_y"]
        node = numpy.arange(nx * ny).reshape(ny, nx)
        pairs = [(node[:, :-1], node[:, 1:]), (node[:-1], node[1:])]
        self.segments = numpy.concatenate([numpy.stack([a.ravel(), b.ravel()], 1) for a, b in pairs])
        self.stretch, self.alpha = (
            self.drawn(values.reshape(plies, -1)[ply], along_x, along_y) for values in (simulation.stretch(), simulation.damage())
        )
        self.outline = [self.centre + turned(numpy.array(body["orientation"]), line) for line in outline(scene)]

    def drawn(self, values: Array, along_x: Any, along_y: Any) -> Any:
        """Numbers of segments, those that are drawn."""
        nx, ny = self.nodes
        across, along = values[: along_x * ny].reshape(ny, along_x), values[along_x * ny :].reshape(along_y, nx)
        return numpy.concatenate([across[:, : nx - 1].ravel(), along[: ny - 1].ravel()])

    def failed(self) -> int:
        return self.failed_segments

    def deflection(self) -> float:
        """Largest deflection of a node that is still near the sheet's body, m: debris may be anywhere."""
        depths = numpy.sort(numpy.abs(self.heights()))
        return float(depths[len(depths) - 1 - len(depths) // 500])

    def heights(self) -> Array:
        """Deflection of each node from the sheet's plane or circle, m."""
        return numpy.hypot(self.positions[:, 0], self.positions[:, 2]) - self.radius if self.radius else self.positions[:, 2]

    def profiles(self) -> Any:
        """The two yarns through the node nearest to the projectile: direction, place along the sheet at rest and deflection of
        each node, m; NaN between the two nodes of a failed segment."""
        nx, ny = self.nodes
        j, i = divmod(int(numpy.linalg.norm(self.positions - self.centre, axis=1).argmin()), nx)
        node, across = numpy.arange(nx * ny).reshape(ny, nx), (nx - 1) * ny
        for name, nodes, alpha, half in (
            ("x", node[j], self.alpha[:across].reshape(ny, nx - 1)[j], self.half_size[0]),
            ("y", node[:, i], self.alpha[across:].reshape(ny - 1, nx)[:, i], self.half_size[1]),
        ):
            torn = numpy.flatnonzero(alpha == 0) + 1
            yield (
                name,
                *(numpy.insert(one, torn, numpy.nan) for one in (numpy.linspace(-half, half, len(nodes)), self.heights()[nodes])),
            )

    def lines(self, points: Array, chosen: Any) -> Any:
        return points[self.segments[chosen]]

    def draw_oblique(self, axis: Any, meshes: float = 0.88, near: Any = True) -> None:
        """The sheet as a lit surface, coloured by strain, with the torn yarns at its holes, and the projectile, dashed where it
        is hidden; z is up. meshes: how bright the lines between meshes are; near: of a curved sheet what is near the
        projectile."""
        faces: list[Any] = []
        colours: Any = []
        depths: list[Any] = []
        for corners, colour in [*self.cloth(), self.body()]:
            normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
            normals /= numpy.maximum(numpy.linalg.norm(normals, axis=1), 1e-30)[:, None]
            # Cloth has two sides, the body one.
            towards = (
                numpy.abs(normals @ LIGHT)
                if len(corners[0]) == 4
                else numpy.maximum(normals @ LIGHT * outward(corners, normals, self.centre), 0)
            )
            light = 0.62 + 0.5 * towards
            screen = oblique(corners)
            faces.extend(screen[..., :2])
            colours.append(numpy.clip(light[:, None] * colour, 0, 1))
            # The body lies behind the cloth that touches it, although its faces are of another size.
            mesh = 2e3 * self.half_size[0] / min(max(self.nodes), self.most_meshes())
            depths.append(screen[..., 2].mean(1) + (0 if len(corners[0]) == 4 else 1.5 * mesh))
        order = numpy.argsort(-numpy.concatenate(depths), kind="stable")
        colours = numpy.concatenate(colours)[order]
        axis.add_collection(
            PolyCollection(
                [faces[k] for k in order], facecolors=colours, edgecolors=meshes * colours, linewidths=0.3, rasterized=True
            )
        )
        # Yarns at the edge of a hole, and loose ones, which no whole mesh has drawn.
        loose = (self.alpha > 0) & ~self.covered()
        lines = oblique(self.positions)[:, :2][self.segments[loose]]
        axis.add_collection(
            LineCollection(lines, colors=0.6 * STRAIN(self.strain(loose))[:, :3], linewidths=0.7, rasterized=True)
        )
        silhouette = oblique(self.body()[0].reshape(-1, 3))[:, :2]
        silhouette = silhouette[scipy.spatial.ConvexHull(silhouette).vertices]
        axis.fill(*silhouette.T, fill=False, edgecolor="#1c2f40", linewidth=0.8, linestyle=(0, (3, 3)), alpha=0.7)
        if self.radius:
            self.frame(axis, near)
            return
        half = [0.5 * side for side in numpy.ptp(oblique(self.corners())[:, :2], axis=0)]
        low, high = -half[1], max(half[1], *(oblique(line)[:, 1].max() for line in self.outline))
        axis.set(xlim=(-1.03 * half[0], 1.03 * half[0]), ylim=(1.03 * low, 1.03 * min(high, 2.2 * half[1])), aspect="equal")
        axis.set_axis_off()

    def frame(self, axis: Any, near: Any) -> None:
        """Shows all of a curved sheet, or six reaches of the projectile about the place that it hits."""
        screen = oblique(self.places())[:, :2]
        low, high = screen.min(0), screen.max(0)
        if near:
            reach = 1e3 * max(numpy.linalg.norm(line - self.centre, axis=1).max() for line in self.outline)
            middle = screen[
                numpy.linalg.norm(
                    self.places() - self.radius / numpy.hypot(*self.centre[[0, 2]]) * self.centre * [1, 0, 1], axis=1
                ).argmin()
            ]
            low, high = numpy.maximum(low, middle - 6 * reach), numpy.minimum(high, middle + [6 * reach, 4 * reach])
        # A body that has left is shown as far as the sheet is high.
        high[1] = max(high[1], min(oblique(numpy.concatenate(self.outline))[:, 1].max(), high[1] + 0.4 * (high[1] - low[1])))
        margin = 0.03 * (high - low).max()
        axis.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
        axis.set_axis_off()

    def places(self) -> Any:
        """Where the nodes of a curved sheet rest, m."""
        half = self.half_size[1]
        angles, along = self.angles(), numpy.linspace(-half, half, self.nodes[1])
        ring = self.radius * numpy.stack([numpy.sin(angles), 0 * angles, numpy.cos(angles)], 1)
        return (ring[None] + numpy.stack([0 * along, along, 0 * along], 1)[:, None]).reshape(-1, 3)

    def angles(self) -> Any:
        """Angles of the columns of a curved sheet about its axis, rad: the spacing is a chord."""
        nx = self.nodes[0]
        return (numpy.arange(nx) - 0.5 * (nx - 1)) * 2 * numpy.arcsin(self.half_size[0] / (nx - 1) / self.radius)

    def most_meshes(self) -> Any:
        """A curved sheet is drawn from near."""
        return 6 * MOST_MESHES if self.radius else MOST_MESHES

    def corners(self) -> Any:
        """Corners of the sheet at rest, m; with its mirror images."""
        x, y = self.half_size
        return numpy.array([[i * x, j * y, 0.0] for i in (-1, 1) for j in (-1, 1)])

    def strain(self, chosen: Any) -> Any:
        """Strain of some segments over that at which the yarn begins to fail."""
        return (self.stretch[chosen] - 1) / self.critical_strain

    def whole(self) -> Any:
        """Whether all four segments of each mesh are alive."""
        nx, ny = self.nodes
        across, along = (
            (self.alpha[: (nx - 1) * ny] > 0).reshape(ny, nx - 1),
            (self.alpha[(nx - 1) * ny :] > 0).reshape(ny - 1, nx),
        )
        return across[:-1] & across[1:] & along[:, :-1] & along[:, 1:]

    def covered(self) -> Any:
        """Whether a whole mesh is beside each segment."""
        whole = numpy.pad(self.whole(), 1)
        across, along = whole[:-1, 1:-1] | whole[1:, 1:-1], whole[1:-1, :-1] | whole[1:-1, 1:]
        return numpy.concatenate([across.ravel(), along.ravel()])

    def cloth(self) -> Any:
        """Corners of the whole meshes, m, with their colours: those that are drawn one by one, and those that are drawn
        together."""
        (nx, ny), whole = self.nodes, self.whole()
        node = self.positions.reshape(ny, nx, 3)
        strain = numpy.zeros(nx * ny)
        for side in (0, 1):
            numpy.maximum.at(strain, self.segments[self.alpha > 0, side], self.strain(self.alpha > 0))
        strain = strain.reshape(ny, nx)
        step = -(-max(self.nodes) // self.most_meshes())
        rows, columns = (ny - 1) // step, (nx - 1) // step
        blocks = whole[: rows * step, : columns * step].reshape(rows, step, columns, step).all((1, 3))
        single = whole.copy()
        single[: rows * step, : columns * step] &= ~blocks.repeat(step, 0).repeat(step, 1)
        if self.radius and self.closed:
            # Across the joint of a ring, whose segments are not kept.
            j = numpy.nonzero(whole[:, 0] & whole[:, -1])[0]
            ends = [(j, j * 0 + nx - 1), (j, j * 0), (j + 1, j * 0), (j + 1, j * 0 + nx - 1)]
            yield numpy.stack([node[end] for end in ends], 1), STRAIN(numpy.mean([strain[end] for end in ends], 0))[:, :3]
        for chosen, stride in ((single, 1), (blocks, step)) if step > 1 else ((whole, 1),):
            j, i = stride * numpy.array(numpy.nonzero(chosen))
            ends = [(j, i), (j, i + stride), (j + stride, i + stride), (j + stride, i)]
            if len(j):
                yield numpy.stack([node[end] for end in ends], 1), STRAIN(numpy.mean([strain[end] for end in ends], 0))[:, :3]

    def body(self) -> Any:
        """Faces of the projectile, the hull of its lines, or of points all over a sphere; m, with their colours. It is drawn a
        little smaller than it is: between the nodes that touch it the cloth is drawn straight, and would lie within it."""
        points = numpy.concatenate(self.outline)
        if self.sphere > 0:
            k = numpy.arange(900) + 0.5
            z, turn = 1 - 2 * k / 900, numpy.pi * (1 + 5**0.5) * k
            points = self.centre + self.sphere * numpy.stack(
                [numpy.sqrt(1 - z * z) * numpy.cos(turn), numpy.sqrt(1 - z * z) * numpy.sin(turn), z], 1
            )
        faces = self.centre + 0.98 * (points[scipy.spatial.ConvexHull(points).simplices] - self.centre)
        return faces, numpy.broadcast_to(STEEL, (len(faces), 3))

    def section(self) -> Any:
        """The yarn along x that is nearest to the middle: its segments as lines in x and z, mm, and their damage."""
        nx, ny = self.nodes
        first = (ny // 2) * (nx - 1)
        chosen = slice(first, first + nx - 1)
        return 1e3 * self.positions[:, [0, 2]][self.segments[chosen]], self.alpha[chosen]

    def draw_thickness(self, axis: Any) -> None:
        """The whole yarns of the section, as wide as the cloth is thick."""
        lines, alpha = self.section()
        along = lines[alpha > 0, 1] - lines[alpha > 0, 0]
        off = 0.5e3 * self.thickness * numpy.stack([-along[:, 1], along[:, 0]], 1) / numpy.hypot(*along.T)[:, None]
        ends = numpy.stack([lines[alpha > 0] + side * off[:, None] for side in (1, -1)], 1)
        axis.add_collection(PolyCollection(list(numpy.concatenate([ends[:, 0], ends[:, 1, ::-1]], 1)), facecolors="#dddddd"))

    def draw_damage(self, axis: Any) -> None:
        """Damage on the undeformed grid, seen along the line of flight; held nodes in grey."""
        grid, (nx, ny) = self.grid(), self.nodes
        axis.plot(*grid[[0, nx - 1, nx * ny - 1, nx * ny - nx, 0]].T, color="#bbbbbb", linewidth=0.8)
        wide = numpy.array([[-0.4], [0.4]]) * (grid[1] - grid[0])
        held = [grid[[row * nx + first, row * nx + end - 1]] + wide for row, first, end in self.held if row < ny]
        axis.add_collection(LineCollection(held, colors="#787878", linewidths=1.6))
        for chosen in ((self.alpha < 1) & (self.alpha > 0), self.alpha == 0):
            lines = LineCollection(self.lines(grid, chosen), colors=DAMAGE(self.alpha[chosen]), linewidths=1.3, rasterized=True)
            axis.add_collection(lines)
        for name, alpha in [("slightly damaged", 0.95), ("half", 0.5), ("failed", 0.0)]:
            axis.plot([], [], color=DAMAGE(alpha), linewidth=2.5, label=name)
        half = 0.51 * max(numpy.ptp(grid, axis=0))
        axis.set(xlim=(-half, half), ylim=(-half, half), aspect="equal", xlabel="x (mm)", ylabel="y (mm)")

    def grid(self) -> Array:
        """Places of the nodes along both yarns of the undeformed sheet, from its middle, (nodes, 2), mm."""
        rest = Simulation(self.scene, warns=False).positions()
        across, along = (numpy.linalg.norm(numpy.diff(line, axis=0), axis=1) for line in (rest[0], rest[: self.nodes[1], 0]))
        x, y = (1e3 * (numpy.append(0.0, numpy.cumsum(steps)) - 0.5 * steps.sum()) for steps in (across, along))
        return numpy.stack(numpy.meshgrid(x, y), -1).reshape(-1, 2)

    def vtk(self, path: Place) -> None:
        """The sheet as VTK PolyData; failed segments are kept (hide them with a threshold on alpha)."""
        offsets = 2 * numpy.arange(1, len(self.segments) + 1)
        cells = {"alpha": self.alpha, "damage": 1 - self.alpha, "stretch": self.stretch}
        poly_data(path, self.positions, self.segments.ravel(), offsets, cells, {"velocity": self.velocities})

    def vtk_of_body(self, path: Place) -> None:
        """The projectile's outline likewise."""
        points = numpy.concatenate(self.outline)
        poly_data(path, points, numpy.arange(len(points)), numpy.cumsum([len(line) for line in self.outline]), {})


def outline(scene: Scene) -> Any:
    """Lines on the surface of the projectile of a scene, m, in its own axes."""
    shape, radius = scene["projectile.shape"], scene["projectile.radius"]
    round_about = numpy.linspace(0.0, 2.0 * numpy.pi, 49)
    ring = numpy.stack([numpy.cos(round_about), numpy.sin(round_about), 0.0 * round_about], 1)
    if shape == "sphere":
        return [radius * ring[:, order] for order in ([0, 1, 2], [0, 2, 1], [2, 0, 1])]
    if shape == "cylinder":
        face, half = radius * ring, 0.5 * scene["projectile.length"]
    elif shape == "box":
        x, y, z = 0.5 * numpy.array(scene["projectile.size"])
        face, half = numpy.array([[x, y, 0.0], [-x, y, 0.0], [-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0]]), z
    elif shape == "disc_sector":
        inner, outer, angle, thickness = (
            scene[f"projectile.sector.{name}"] for name in ("inner_radius", "outer_radius", "angle", "thickness")
        )
        middle = 4.0 * numpy.sin(0.5 * angle) / (3.0 * angle) * (outer**3 - inner**3) / (outer**2 - inner**2)
        arc = numpy.linspace(-0.5 * angle, 0.5 * angle, 25)
        bow = numpy.stack([numpy.cos(arc), numpy.sin(arc), 0.0 * arc], 1)
        face, half = numpy.concatenate([outer * bow, inner * bow[::-1], outer * bow[:1]]) - [middle, 0.0, 0.0], 0.5 * thickness
    elif shape == "polyhedron":
        planes = numpy.array(scene["projectile.faces.planes"])[: scene["projectile.faces.count"]]
        corners = scipy.spatial.HalfspaceIntersection(planes * [1.0, 1.0, 1.0, -1.0], numpy.zeros(3)).intersections
        lines = []
        for *normal, distance in planes:
            face = corners[numpy.abs(corners @ normal - distance) < 1e-6 * distance]
            first = numpy.cross(normal, numpy.eye(3)[numpy.abs(normal).argmin()])
            angles = numpy.arctan2((face - face.mean(0)) @ numpy.cross(normal, first), (face - face.mean(0)) @ first)
            face = face[numpy.argsort(angles)]
            lines.append(numpy.concatenate([face, face[:1]]))
        return lines
    else:
        # A hemisphere at +z, on a shank: (c²/2 − R²/4)/(c + 2R/3) from its centre to the centre of mass.
        shank = scene["projectile.length"] - radius
        nose = (0.5 * shank**2 - 0.25 * radius**2) / (shank + radius / 1.5)
        bows = [radius * ring[:25, order] + [0.0, 0.0, nose] for order in ([0, 2, 1], [2, 0, 1])]
        rims = [radius * ring + [0.0, 0.0, z] for z in (nose - shank, nose)]
        return [*bows, *rims, *(numpy.stack([rims[0][k], rims[1][k]]) for k in range(0, 48, 6))]
    ends = [face + [0.0, 0.0, z] for z in (-half, half)]
    return [*ends, *(numpy.stack([ends[0][k], ends[1][k]]) for k in range(0, len(face), max(1, len(face) // 8)))]


def turned(q: Any, points: Array) -> Array:
    """Points turned by a quaternion q = (w, u): x + 2 w (u x x) + 2 u x (u x x)."""
    once = 2 * numpy.cross(q[1:], points)
    return points + q[0] * once + numpy.cross(q[1:], once)


def outward(corners: Array, normals: Array, centre: Any) -> Any:
    """1 where a normal points away from the centre, else -1."""
    return numpy.sign(((corners[:, 0] - centre) * normals).sum(1))


def oblique(points: Array) -> Array:
    """On the screen, mm: to the right, upward, and away from the eye."""
    x, y, z = numpy.moveaxis(1e3 * points, -1, 0)
    right, away = numpy.cos(TURN) * x + numpy.sin(TURN) * y, numpy.cos(TURN) * y - numpy.sin(TURN) * x
    return numpy.stack(
        [right, numpy.sin(ABOVE) * away + numpy.cos(ABOVE) * z, numpy.cos(ABOVE) * away - numpy.sin(ABOVE) * z], -1
    )


def poly_data(path: Place, points: Array, connectivity: Array, offsets: Array, cell_data: Any, point_data: Any = None) -> None:
    """Reference: VTK file formats, XML, inline binary data (a count of bytes and the little-endian data, in base64)."""

    def array(name: str, values: Any, components: int = 1) -> Any:
        kind, values = ("Float32", "<f4") if numpy.asarray(values).dtype.kind == "f" else ("Int32", "<i4"), numpy.asarray(values)
        data = values.astype(kind[1]).tobytes()
        text = base64.b64encode(numpy.uint32(len(data)).tobytes() + data).decode()
        return f'<DataArray type="{kind[0]}" Name="{name}" NumberOfComponents="{components}" format="binary">{text}</DataArray>\n'

    cells = "".join(array(name, values) for name, values in cell_data.items())
    nodes = "".join(array(name, values, 3) for name, values in (point_data or {}).items())
    written(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt32">\n'
        "<PolyData>"
        f'<Piece NumberOfPoints="{len(points)}" NumberOfLines="{len(offsets)}">\n<PointData>{nodes}</PointData>\n'
        f"<CellData>{cells}</CellData>\n"
        f"<Points>{array('Points', points, 3)}</Points>\n"
        f"<Lines>{array('connectivity', connectivity)}{array('offsets', offsets)}</Lines>\n"
        "</Piece></PolyData></VTKFile>\n",
    )


def vtk_series(path: Place, frames: Any) -> None:
    """run.pvd: the time of each frame, and its files, those of the projectile and of every ply."""
    lines = [
        f'<DataSet timestep="{time}" part="{part}" file="{name}"/>' for time, names in frames for part, name in enumerate(names)
    ]
    text = "\n".join(lines)
    written(
        path, f'<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0"><Collection>\n{text}\n</Collection></VTKFile>\n'
    )


def bar(figure: Figure, axis: Any, sheet: Sheet, label: str = "strain (%), up to where the yarn begins to fail") -> None:
    """What the colours of the oblique view mean."""
    percent = Normalize(0, 100 * sheet.critical_strain)
    figure.colorbar(ScalarMappable(percent, STRAIN), ax=axis, shrink=0.6, aspect=24, pad=0.02, label=label).outline.set_visible(
        False
    )


@drawing.styled
def picture(sheet: Sheet, path: Place | None, title: str) -> Any:
    """One large picture of the sheet."""
    if sheet.radius:
        return picture_of_curve(sheet, path, title)
    figure, axis = drawing.new(10.5, 7.2)
    sheet.draw_oblique(axis)
    bar(figure, axis, sheet)
    axis.set_title(title)
    return drawing.saved(figure, path)


@drawing.styled
def profile(sheet: Sheet, path: Place | None, title: str) -> Any:
    """The back face, cut along both yarns under the projectile."""
    figure, axis = drawing.new(8.5, 4.2)
    for number, (name, places, heights) in enumerate(sheet.profiles()):
        axis.plot(1e3 * places, 1e3 * heights, color=drawing.COLOURS[number], label=f"along {name}")
    axis.set(title=title, xlabel="place along the sheet at rest (mm)", ylabel="deflection (mm)")
    axis.legend()
    return drawing.saved(figure, path)


def picture_of_curve(sheet: Sheet, path: Place | None, title: str) -> Any:
    """A curved sheet where it is hit and as a whole, a section along its middle row, and its failures on the sheet unrolled."""
    figure, ((near, whole), (section, unrolled)) = drawing.new(12.6, 9.4, 2, 2)
    sheet.draw_oblique(near)
    sheet.draw_oblique(whole, near=False)
    bar(figure, near, sheet, "strain (%)")
    whole.set_title("the whole sheet", fontsize=10)
    sheet.draw_thickness(section)
    lines, alpha = sheet.section()
    section.add_collection(LineCollection(lines[alpha > 0], colors=YARN, linewidths=1.2))
    section.add_collection(
        LineCollection(1e3 * sheet.places()[:, [0, 2]].reshape(*sheet.nodes[::-1], 2)[:1], colors="#bbbbbb", linewidths=0.8)
    )
    for line in sheet.outline:
        section.plot(1e3 * line[:, 0], 1e3 * line[:, 2], color="black", linewidth=0.9)
    reach, (x, _, z) = (
        1e3 * max(numpy.linalg.norm(line - sheet.centre, axis=1).max() for line in sheet.outline),
        1e3 * sheet.centre,
    )
    section.set(
        xlim=(x - 4 * reach, x + 4 * reach), ylim=(z - 3 * reach, z + 2 * reach), aspect="equal", xlabel="x (mm)", ylabel="z (mm)"
    )
    section.set_title("section: the middle row of nodes, grey at rest", fontsize=10)
    angles = numpy.degrees(sheet.angles())
    along = 1e3 * numpy.linspace(-sheet.half_size[1], sheet.half_size[1], sheet.nodes[1])
    grid = numpy.stack([numpy.tile(angles, sheet.nodes[1]), numpy.repeat(along, sheet.nodes[0])], 1)
    for chosen in ((sheet.alpha < 1) & (sheet.alpha > 0), sheet.alpha == 0):
        unrolled.add_collection(LineCollection(sheet.lines(grid, chosen), colors=DAMAGE(sheet.alpha[chosen]), linewidths=1.6))
    for name, alpha in [("damaged", 0.95), ("failed", 0.0)]:
        unrolled.plot([], [], color=DAMAGE(alpha), linewidth=2.5, label=name)
    middle, wide = numpy.degrees(numpy.arctan2(x, z)), numpy.degrees(4e-3 * reach / sheet.radius)
    unrolled.set(
        xlim=(middle - wide, middle + wide),
        ylim=(along[0], along[-1]),
        xlabel="angle about the axis (degrees)",
        ylabel="y, along the axis (mm)",
    )
    unrolled.set_title(f"unrolled: {sheet.failed()} failed segments", fontsize=10)
    unrolled.legend(loc="upper right", fontsize=8)
    section.grid(False)
    figure.suptitle(title)
    return drawing.saved(figure, path)


@drawing.styled
def damage_map(sheet: Sheet, path: Place, title: str) -> None:
    """Damage on the undeformed sheet: the part in which segments failed, or are damaged, at least a third of the sheet."""
    figure, axis = drawing.new(7.2, 7.2)
    sheet.draw_damage(axis)
    axis.set(title=title)
    grid = sheet.grid()
    failed = sheet.alpha == 0
    places = grid[sheet.segments[failed if failed.any() else sheet.alpha < 1].ravel()]
    if len(places):
        middle = 0.5 * (places.max(0) + places.min(0))
        half = 0.55 * max(*numpy.ptp(places, axis=0), max(numpy.ptp(grid, axis=0)) / 3)
        axis.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    drawing.below(figure, axis)
    axis.grid(False)
    drawing.save(figure, path)


@drawing.styled
def picture_of_stack(sheets: Sequence[Sheet], path: Place, title: str) -> None:
    """Picture of separate plies: a section along x through the middle, and how many segments failed in each."""
    figure, (left, right) = drawing.new(12.6, 6.4, 2)
    for number, sheet in enumerate(sheets):
        sheet.draw_thickness(left)
        lines, alpha = sheet.section()
        live, damaged = alpha > 0, (alpha > 0) & (alpha < 1)
        left.add_collection(LineCollection(lines[live], colors=PLIES[number % len(PLIES)], linewidths=0.6))
        left.add_collection(LineCollection(lines[damaged], colors=DAMAGE(alpha[damaged]), linewidths=1.4))
    for line in sheets[0].outline:
        left.plot(1e3 * line[:, 0], 1e3 * line[:, 2], color="black", linewidth=0.9)
    half = 1e3 * sheets[0].half_size[0]
    ends = [1e3 * sheet.deflection() for sheet in sheets] + [1e3 * line[:, 2].max() for line in sheets[0].outline]
    low = min(0.0, *(1e3 * line[:, 2].min() for line in sheets[0].outline))
    left.set(
        xlim=(-half, half),
        ylim=(low - 1, max(ends) + 1),
        aspect="equal",
        xlabel="x (mm)",
        ylabel="z, along the line of flight (mm)",
    )
    left.set(title="section: the middle yarn of each ply")
    right.barh(range(1, len(sheets) + 1), [sheet.failed() for sheet in sheets], color=YARN, height=0.8)
    right.set(xlabel="failed segments", ylabel="ply, from the side that is hit", title="failed segments of each ply")
    left.grid(False)
    figure.suptitle(title)
    drawing.save(figure, path)
