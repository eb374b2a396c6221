"""Ballistic limit of the packs of Twaron CT612 that were shot at with the chisel-nosed fragment of .22.

Input is yarn data alone: areal density and thickness of a layer from the table itself, fibre "PPTA, regular" of
data/measured/fibres.toml before weaving; linear density and count were not seen, so the yarns are spaced as those of Kevlar KM2
S706, which is a choice.

Method: the mean limit of hits, with the viscosity of real fabrics, with a bar for one yarn, for two and for half a yarn, on a
sheet 160 mm wide held on four sides; with one yarn a bar also 102 mm wide, and as a surface without thickness. With half a yarn a
bar the network is graded. The plies of a pack are bonded into one network, whose thickness is that of them all.
Limits: bonded plies are hit at once and cannot part; no friction, no slip; how the packs were held was not seen.
"""

import itertools
import math
import tomllib
from typing import NamedTuple

import scipy.stats
from fabric_kernel import drawing

from . import page
from .comparison import Comparison, Point, mean_of
from .hits import BISECTION, GRADED, limit, sheet, shot
from .statistics import Estimate, deviation, mean
from .study import FULL, TOP
from .viscosity import VISCOUS, viscous

# Width of the sheet in short form, m; time after which an impact is given up, s.
NARROW, LONGEST = 0.04, 2e-3
# Yarns a bar, with or without the thickness, width, m, and hits.
NETWORKS = ((1.0, True, 0.16, 5), (2.0, True, 0.16, 5), (1.0, True, 0.102, 5), (1.0, False, 0.16, 1), (0.5, True, 0.16, 5))
# Areal density at which the measured ladder bends, kg/m².
BREAK = 5.0
ORDER = (
    "network; pairs; in the measured order; with the whole interval; pairs not distinguished; Kendall's tau, all pairs"
).split("; ")
# Half of the 38 m/s that MIL-STD-662F allows between the shots that a V50 is the mean of; the source of the ladder gives no
# interval.
V50_INTERVAL = 19.0
# Count of the yarn of S706, 1/m, as data/fabrics/kevlar_km2_s706.toml has it.
COUNT = 34 / 0.0254


class Pack(NamedTuple):
    """density: of a ply, kg/m2; thickness: of all plies, m; measured: V50, m/s."""

    plies: int
    density: float
    thickness: float
    measured: float

    def scene(self, bar, thick, width):
        fibre = next(row for row in toml("fibres")["fibre"] if row["name"] == "PPTA, regular")
        fabric = {
            "name": "kevlar_km2_s706",
            "modulus": 1e9 * fibre["modulus_gpa"],
            "failure_strain": 1e-2 * fibre["failure_strain_percent"],
            "linear_density": 0.5 * self.density / COUNT,
            "fibre_density": 1e3 * fibre["density_g_per_cm3"],
            "thickness": self.thickness / self.plies if thick else 0.0,
        }
        fragment = {"projectile": {"shape": "fsp", "calibre": ".22"}, "sheet.plies": self.plies, "slack_balance": True}
        return sheet(fabric, width, bar).replace(fragment | viscous(VISCOUS))


def toml(name):
    return tomllib.loads((TOP / f"data/measured/{name}.toml").read_text())


def packs():
    return [
        Pack(row["layers"], row["areal_density_kg_per_m2"] / row["layers"], 1e-3 * row["thickness_mm"], float(row["v50_m_per_s"]))
        for row in toml("twaron_ct612_v50")["v50"]
    ]


def measured(job):
    scene, guess, hit = job
    return limit(scene, guess, hit, LONGEST)


def compared(study):
    full = study.effort == FULL
    shot_at = packs() if full else packs()[:1]
    networks = [(pack, *network) for network in NETWORKS[: 5 if full else 2] for pack in shot_at]
    if not full:
        networks = [(*network[:3], NARROW, 2) for network in networks]
    jobs, rows = [], []
    for pack, bar, thick, width, hits in networks:
        scene, guess = pack.scene(bar, thick, width), 0.9 * pack.measured
        scene = shot(scene, guess, 0).graded(GRADED) if bar < 1.0 else scene
        jobs += [(scene, guess, hit) for hit in range(hits)]
    limits = iter(study.each(measured, jobs, "packs"))
    for pack, bar, thick, width, hits in networks:
        own = [next(limits) for _ in range(hits)]
        row = {"yarns a bar": bar, "width mm": 1e3 * width, "thickness mm": 1e3 * pack.thickness if thick else 0.0}
        row |= {"plies": pack.plies, "areal density kg/m2": pack.plies * pack.density, "hits": len(own), "limit m/s": mean(own)}
        rows.append(row | {"limit m/s: deviation": deviation(own), "measured V50 m/s": pack.measured})
    study.write("packs", rows)
    return judged(study, rows)


def judged(study, rows):
    lacks = "plies that part, friction, slip, rate, the pack's true boundary; fibre before weaving"
    comparisons, lines, series, slopes, orders = [], [], [], [], []
    kind = lambda row: (row["yarns a bar"], row["thickness mm"] > 0, row["width mm"])
    for bar, thick, width in dict.fromkeys(map(kind, rows)):
        own = [row for row in rows if kind(row) == (bar, thick, width)]
        points, limits = [], []
        for row in own:
            ours, measured, density = mean_of(row, "limit m/s", BISECTION), row["measured V50 m/s"], row["areal density kg/m2"]
            allowed = (measured - V50_INTERVAL, measured + V50_INTERVAL)
            points.append(Point(f"{density:.1f} kg/m², m/s", ours, allowed))
            limits.append((ours, measured))
            off = f"{100 * (ours.value / measured - 1):+.0f}"
            pack = [f"{bar:g}", f"{width:.0f}", f"{row['thickness mm']:.1f}", str(row["plies"]), f"{density:.1f}", ours.text(0)]
            lines.append([*pack, f"{measured:.0f} ± {V50_INTERVAL:.0f}", off, points[-1].verdict])
        name = f"{bar:g} yarn{'s' * (bar > 1)} a bar, {width:.0f} mm{'' if thick else ', without thickness'}"
        title = f"five packs of Twaron CT612, {name}"
        comparisons.append(Comparison(f"V50 of {title}", "measurement", f"± {V50_INTERVAL:.0f} m/s", points, 0, lacks))
        found = slope_points(own)
        if not orders:
            comparisons.append(Comparison(f"slope of the V50 of {title}", "measurement", "from ± 19 m/s", found, 0, lacks))
        orders.append(order(name, limits))
        slopes += [[name, one.name, one.ours.text(0), "{:.0f} to {:.0f}".format(*one.allowed), one.verdict] for one in found]
        ends = [(row["areal density kg/m2"], ours.value) for row, (ours, _) in zip(own, limits)]
        series.append((name, ends, [(ours.low, ours.high) for ours, _ in limits]))
    drawn(study, series, rows)
    heading = "yarns a bar; width, mm; thickness, mm; plies; kg/m²; model m/s [95 %]; measured m/s; off %; verdict".split("; ")
    text = page.markdown(heading, lines, 1)
    if slopes:
        text += "\nRise of the V50 with the areal density, m/s per kg/m²:\n\n"
        text += page.markdown(["network", "between", "model [95 %]", "measured", "verdict"], slopes, 1)
    text += f"\nPairs of packs whose measured V50 differ by more than the scatter, {math.sqrt(2) * V50_INTERVAL:.0f} m/s:\n\n"
    return comparisons, "## Ballistic limit of packs\n\n" + text + page.markdown(ORDER, orders, 1), True


def drawn(study, series, rows):
    """Limits over areal density: measured points and, thick, the model with one yarn a bar."""
    figure, axis = drawing.new()
    measured = sorted({(row["areal density kg/m2"], row["measured V50 m/s"]) for row in rows})
    axis.errorbar(*zip(*measured), V50_INTERVAL, fmt="ko", capsize=3, label="measured")
    for number, (name, points, bars) in enumerate(series):
        wide, x, y = 2.6 if not number else 0.9, *zip(*points)
        ends = [[y - low for y, (low, _) in zip(y, bars)], [high - y for y, (_, high) in zip(y, bars)]]
        style = {"marker": "o", "markersize": 2 * wide, "linewidth": wide, "elinewidth": 0.8, "capsize": 2}
        axis.errorbar(x, y, ends, color=drawing.COLOURS[number], label=name, **style)
    axis.set(xlabel="areal density (kg/m²)", ylabel="V50 (m/s)", ylim=(0, None))
    axis.set_title("Packs of Twaron CT612, fragment simulator of .22", fontsize=11)
    drawing.below(figure, axis)
    drawing.save(figure, study.folder / "packs.svg")
    study.picture("packs.svg", "validation_packs.svg")


def slope_points(rows):
    """Rise of V50 from the thinnest pack to that of BREAK, and from there to the thickest, m/s per kg/m²."""
    rows = sorted(rows, key=lambda row: row["areal density kg/m2"])
    middle = next((row for row in rows if row["areal density kg/m2"] == BREAK), None)
    points = []
    for low, high in [(rows[0], middle), (middle, rows[-1])] if middle else []:
        span = high["areal density kg/m2"] - low["areal density kg/m2"]
        ends = [mean_of(row, "limit m/s", BISECTION) for row in (low, high)]
        rise = Estimate(*(number / span for number in Estimate.difference(ends[1], ends[0])))
        measured = (high["measured V50 m/s"] - low["measured V50 m/s"]) / span
        allowed = math.sqrt(2) * V50_INTERVAL / span
        name = f"{low['areal density kg/m2']:g} and {high['areal density kg/m2']:g} kg/m²"
        points.append(Point(name, rise, (measured - allowed, measured + allowed)))
    return points


def order(name, packs):
    """A row: pairs of packs, (computed, measured) V50, that the measurements distinguish, and how many are in their order."""
    pairs = [pair for pair in itertools.permutations(packs, 2) if pair[0][1] - pair[1][1] > math.sqrt(2) * V50_INTERVAL]
    rises = [Estimate.difference(above, below) for (above, _), (below, _) in pairs]
    tau = scipy.stats.kendalltau([ours.value for ours, _ in packs], [measured for _, measured in packs]).statistic
    counts = len(pairs), sum(rise.value > 0 for rise in rises), sum(rise.low > 0 for rise in rises)
    return [name, *map(str, counts), str(math.comb(len(packs), 2) - len(pairs)), f"{tau:.2f}"]
