"""Sheets that `fabric-study` has kept (study/src/picture.rs has the format): pictures, and files for ParaView."""

import base64

import numpy
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap

from . import plot

# Dark red for failed, over orange, to yellow for the first damage.
DAMAGE = LinearSegmentedColormap.from_list("damage", ["#8c0014", "#f06e14", "#f5c83c"])
YARN = "#5a6e8c"
# Plies in turn, so that neighbours can be told apart.
PLIES = ["#1f4e79", "#6fa8dc"]


class Sheet:
    """positions: m, one row a node; segments: the two nodes of each; alpha: of each, 0 only where it has failed. ply: of a stack."""

    def __init__(self, folder, about, ply=0):
        data = (folder / about["file"]).read_bytes()
        nx, ny = about["nodes"]
        self.about, self.nodes = about, (nx, ny)
        self.time = float(numpy.frombuffer(data, "<f8", 1)[0])
        self.positions = numpy.frombuffer(data, "<f4", 3 * nx * ny, 64 + 12 * nx * ny * ply).reshape(-1, 3).astype(float)
        node = numpy.arange(nx * ny).reshape(ny, nx)
        # A mirrored line has one segment more, to an image, which is not drawn.
        along_x, along_y = nx - 1 + about["mirrored"][0], ny - 1 + about["mirrored"][1]
        count, nodes = along_x * ny + along_y * nx, about["plies"] * nx * ny
        damage = numpy.frombuffer(data, "u1", count, 64 + 12 * nodes + count * ply) / 255.0
        across, along = damage[: along_x * ny].reshape(ny, along_x), damage[along_x * ny :].reshape(along_y, nx)
        pairs = [(node[:, :-1], node[:, 1:]), (node[:-1], node[1:])]
        self.segments = numpy.concatenate([numpy.stack([a.ravel(), b.ravel()], 1) for a, b in pairs])
        self.alpha = numpy.concatenate([across[:, : nx - 1].ravel(), along[: ny - 1].ravel()])
        self.outline = [numpy.array(line) for line in about["outline"]]

    def failed(self):
        return int((self.alpha == 0).sum())

    def deflection(self):
        """Largest deflection of a node that is still near the sheet's body, m: debris may be anywhere."""
        depths = numpy.sort(numpy.abs(self.positions[:, 2]))
        return float(depths[len(depths) - 1 - len(depths) // 500])

    def lines(self, points, chosen):
        return points[self.segments[chosen]]

    def draw_side(self, axis):
        """From the side: x to the right, z (the line of flight) upward, the same scale along both."""
        points = 1e3 * self.positions[:, [0, 2]]
        half = 1e3 * self.about["half_size_m"][0]
        axis.add_collection(LineCollection(self.lines(points, self.alpha > 0), colors=YARN, linewidths=0.3, alpha=0.25, rasterized=True))
        damaged = (self.alpha > 0) & (self.alpha < 1)
        colours = DAMAGE(self.alpha[damaged])
        axis.add_collection(LineCollection(self.lines(points, damaged), colors=colours, linewidths=0.8, rasterized=True))
        for line in self.outline:
            axis.plot(1e3 * line[:, 0], 1e3 * line[:, 2], color="black", linewidth=0.8)
        heights = [1e3 * line[:, 2] for line in self.outline]
        low = min([0.0, *(h.min() for h in heights)]) - 0.05 * half
        high = max([1e3 * self.deflection(), *(h.max() for h in heights)]) + 0.05 * half
        axis.set(xlim=(-1.03 * half, 1.03 * half), ylim=(low, high), aspect="equal")

    def draw_oblique(self, axis):
        """x to the right, y into the picture, z up; nearly all points and all of the projectile."""
        oblique = lambda x: 1e3 * numpy.stack([x[:, 0] + 0.35 * x[:, 1], 0.5 * x[:, 1] + x[:, 2]], 1)
        points, outline = oblique(self.positions), [oblique(line) for line in self.outline]
        # Every yarn, or as many as can be told apart.
        stride, columns = -(-max(self.nodes) // 110), self.nodes[0]
        first = self.segments[:, 0]
        number = numpy.where(self.segments[:, 1] - first == 1, first // columns, first % columns)
        shown = (self.alpha > 0) & (number % stride == 0)
        axis.add_collection(LineCollection(self.lines(points, shown), colors=YARN, linewidths=0.5, rasterized=True))
        damaged = (self.alpha > 0) & (self.alpha < 1)
        axis.add_collection(LineCollection(self.lines(points, damaged), colors=DAMAGE(self.alpha[damaged]), linewidths=1.2, rasterized=True))
        for line in outline:
            axis.plot(line[:, 0], line[:, 1], color="black", linewidth=0.9)
        cloud = numpy.concatenate([numpy.quantile(points, [0.005, 0.995], axis=0), *outline])
        middle, half = 0.5 * (cloud.max(0) + cloud.min(0)), 0.56 * max((cloud.max(0) - cloud.min(0)).max(), 1e-9)
        axis.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal")

    def section(self):
        """The yarn along x that is nearest to the middle: its segments as lines in x and z, mm, and their damage."""
        nx, ny = self.nodes
        first = (ny // 2) * (nx - 1)
        chosen = slice(first, first + nx - 1)
        return 1e3 * self.positions[:, [0, 2]][self.segments[chosen]], self.alpha[chosen]

    def draw_damage(self, axis):
        """Damage on the undeformed grid, seen along the line of flight; held nodes in grey."""
        nx, ny = self.nodes
        node = numpy.arange(nx * ny)
        grid = numpy.stack([node % nx, node // nx], 1).astype(float)
        axis.plot([0, nx - 1, nx - 1, 0, 0], [0, 0, ny - 1, ny - 1, 0], color="#bbbbbb", linewidth=0.8)
        held = [[(start - 0.4, row), (end - 0.6, row)] for row, start, end in self.about["held"]]
        axis.add_collection(LineCollection(held, colors="#787878", linewidths=1.0))
        for chosen in ((self.alpha < 1) & (self.alpha > 0), self.alpha == 0):
            lines = LineCollection(self.lines(grid, chosen), colors=DAMAGE(self.alpha[chosen]), linewidths=1.3, rasterized=True)
            axis.add_collection(lines)
        for name, alpha in [("slightly damaged", 0.95), ("half", 0.5), ("failed", 0.0)]:
            axis.plot([], [], color=DAMAGE(alpha), linewidth=2.5, label=name)
        side = max(nx, ny)
        axis.set(xlim=(-0.02 * side, 1.02 * side - 1), ylim=(-0.02 * side, 1.02 * side - 1), aspect="equal")

    def vtk(self, folder, number):
        """The sheet and the projectile's outline as VTK PolyData; failed segments are kept (hide them with a threshold on alpha),
        their stretch is a mere distance of two nodes."""
        ends = self.positions[self.segments]
        stretch = numpy.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / self.about["spacing_m"]
        names = f"sheet_{number:04}.vtp", f"projectile_{number:04}.vtp"
        offsets = 2 * numpy.arange(1, len(self.segments) + 1)
        poly_data(folder / names[0], self.positions, self.segments.ravel(), offsets, {"alpha": self.alpha, "stretch": stretch})
        points = numpy.concatenate(self.outline)
        poly_data(folder / names[1], points, numpy.arange(len(points)), numpy.cumsum([len(line) for line in self.outline]), {})
        return names


def poly_data(path, points, connectivity, offsets, cell_data):
    """Reference: VTK file formats, XML, inline binary data (a count of bytes and the little-endian data, in base64)."""

    def array(name, values, components=1):
        kind, values = ("Float32", "<f4") if numpy.asarray(values).dtype.kind == "f" else ("Int32", "<i4"), numpy.asarray(values)
        data = values.astype(kind[1]).tobytes()
        text = base64.b64encode(numpy.uint32(len(data)).tobytes() + data).decode()
        return f'<DataArray type="{kind[0]}" Name="{name}" NumberOfComponents="{components}" format="binary">{text}</DataArray>\n'

    cells = "".join(array(name, values) for name, values in cell_data.items())
    path.write_text(
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt32">\n<PolyData>'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfLines="{len(offsets)}">\n<CellData>{cells}</CellData>\n'
        f'<Points>{array("Points", points, 3)}</Points>\n<Lines>{array("connectivity", connectivity)}{array("offsets", offsets)}</Lines>\n'
        "</Piece></PolyData></VTKFile>\n"
    )


def vtk_series(folder, frames):
    """vtk/run.pvd lists the sheet and the projectile at each time."""
    out = folder / "vtk"
    out.mkdir(exist_ok=True)
    lines = []
    for number, about in enumerate(frames):
        sheet = Sheet(folder, about)
        for part, name in enumerate(sheet.vtk(out, number)):
            lines.append(f'<DataSet timestep="{sheet.time}" part="{part}" file="{name}"/>')
    text = "\n".join(lines)
    (out / "run.pvd").write_text(f'<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0"><Collection>\n{text}\n</Collection></VTKFile>\n')
    print(f"written: {out / 'run.pvd'}")


def picture(sheet, path, title):
    """Both pictures side by side."""
    figure, (left, right) = plot.new(12.6, 6.4, 2)
    sheet.draw_oblique(left)
    sheet.draw_damage(right)
    left.set(title="deformed, oblique view (mm)")
    right.set(title="damage on the undeformed grid (node numbers)")
    right.legend(loc="upper right", frameon=True, fontsize=8)
    for axis in (left, right):
        axis.grid(False)
    figure.suptitle(title)
    plot.save(figure, path)


def picture_of_stack(sheets, path, title):
    """Of separate plies a section along x through the middle, and how many segments failed in each."""
    figure, (left, right) = plot.new(12.6, 6.4, 2)
    for number, sheet in enumerate(sheets):
        lines, alpha = sheet.section()
        live, damaged = alpha > 0, (alpha > 0) & (alpha < 1)
        left.add_collection(LineCollection(lines[live], colors=PLIES[number % len(PLIES)], linewidths=0.6))
        left.add_collection(LineCollection(lines[damaged], colors=DAMAGE(alpha[damaged]), linewidths=1.4))
    for line in sheets[0].outline:
        left.plot(1e3 * line[:, 0], 1e3 * line[:, 2], color="black", linewidth=0.9)
    half = 1e3 * sheets[0].about["half_size_m"][0]
    ends = [1e3 * sheet.deflection() for sheet in sheets] + [1e3 * line[:, 2].max() for line in sheets[0].outline]
    low = min(0.0, *(1e3 * line[:, 2].min() for line in sheets[0].outline))
    left.set(xlim=(-half, half), ylim=(low - 1, max(ends) + 1), aspect="equal", xlabel="x (mm)", ylabel="z, along the line of flight (mm)")
    left.set(title="section: the middle yarn of each ply")
    right.barh(range(1, len(sheets) + 1), [sheet.failed() for sheet in sheets], color=YARN, height=0.8)
    right.set(xlabel="failed segments", ylabel="ply, from the side that is hit", title="failed segments of each ply")
    left.grid(False)
    figure.suptitle(title)
    plot.save(figure, path)
