"""Ballistic limit against areal density: packs of Kevlar KM2 S706, and the packs of Twaron CT612 that were shot at.

Axes: P. M. Cunniff, 18th International Symposium on Ballistics (1999): V50/(U*)^(1/3) over A_d A_p/m_p, with the areal density
A_d, the presented area A_p and the mass m_p of the projectile, and U* = (strength x failure strain)/(2 density) x
sqrt(modulus/density). Input is yarn data alone. Twaron:
areal density of a layer from the table itself, fibre "PPTA, regular" of data/measured/fibres.toml before weaving; linear density
and count were not seen, so the yarns are spaced as those of S706, which is a choice.

Method: the limit of five hits each, with the viscosity of real fabrics, with a bar for one yarn and with one for two, a sheet 160
mm wide held on four sides, and the fragment as a flat-ended cylinder of its diameter and mass. All plies are bonded, that is,
lumped into one network; the packs that were shot at also separate, a network for each ply, with a bar for two yarns, three hits,
and a sheet 80 mm wide, as it takes long; beside it stands the same bonded.
Limits: bonded plies are hit at once and cannot part; the gap between separate ones is a choice; no friction, no slip; how the
packs were held was not seen.
"""

import itertools
import math
import tomllib
from typing import NamedTuple

import scipy.stats
from fabric_kernel import drawing, page
from fabric_kernel.drawing import Series
from fabric_kernel.textile import cunniff_velocity

from .comparison import Comparison, Point, about, mean_of
from .hits import BISECTION, limit, sheet
from .overshoot import VISCOUS, viscous
from .statistics import Estimate, deviation, mean
from .study import FULL, TOP

# Plies of S706; widths of a sheet, m: bonded alone, beside separate, in short form; bars, yarn spacings; gap between separate
# plies, m, a choice.
PLIES, WIDTHS, BARS, GAP = (1, 5, 14, 28, 42), (0.16, 0.08, 0.03), (1.0, 2.0), 1e-4
# Time after which an impact is given up, s; on separate plies five times what the fragment needs to stop or to get through.
# Steel, kg/m^3.
LONGEST, STEEL = {"bonded": 2e-3, "separate": 3e-4}, 7850.0
# Areal density at which the measured ladder bends, kg/m².
BREAK = 5.0
ORDER = (
    "network; pairs; in the measured order; with the whole interval; pairs not distinguished; Kendall's tau, all pairs"
).split("; ")
# Half of the 38 m/s that MIL-STD-662F allows between the shots that a V50 is the mean of; the source of the ladder gives no
# interval.
V50_INTERVAL = 19.0
# Linear density of the yarn of S706, kg/m, and its count, 1/m, as data/fabrics/kevlar_km2_s706.toml has them; density of both
# fibres, kg/m^3.
KM2, COUNT, FIBRE = 600 * 1e-3 / 9000.0, 34 / 0.0254, 1.44e3


class Pack(NamedTuple):
    """density: of the yarn, kg/m; measured: V50, m/s, NaN if there is none."""

    name: str
    plies: int
    density: float
    measured: float

    def fabric(self):
        if self.name != "Twaron CT612":
            return {"name": "kevlar_km2_s706"}
        fibre = next(row for row in toml("fibres")["fibre"] if row["name"] == "PPTA, regular")
        yarn = {
            "modulus": 1e9 * fibre["modulus_gpa"],
            "failure_strain": 1e-2 * fibre["failure_strain_percent"],
            "linear_density": self.density,
        }
        return yarn | {"name": "kevlar_km2_s706", "fibre_density": 1e3 * fibre["density_g_per_cm3"]}

    def areal_density(self):
        """Mass of a ply for each area, kg/m^2."""
        return self.density * COUNT + self.density * COUNT

    def scene(self, form, bar, width, radius, mass):
        many = {"stack.plies": self.plies, "stack.gap": GAP} if form == "separate" else {"sheet.plies": self.plies}
        body = {"shape": "cylinder", "radius": radius, "mass": mass, "length": mass / (STEEL * math.pi * radius * radius)}
        return sheet(self.fabric(), width, bar).replace(many | {"projectile": body} | viscous(VISCOUS))


def toml(name):
    return tomllib.loads((TOP / f"data/measured/{name}.toml").read_text())


def packs():
    ladder = toml("twaron_ct612_v50")["v50"]
    shot_at = [
        Pack(
            "Twaron CT612", row["layers"], 0.5 * row["areal_density_kg_per_m2"] / row["layers"] / COUNT, float(row["v50_m_per_s"])
        )
        for row in ladder
    ]
    return [Pack("Kevlar KM2 S706", plies, KM2, math.nan) for plies in PLIES], shot_at


def measured(job):
    scene, guess, hit, longest = job
    return limit(scene, guess, hit, longest)


def compared(study):
    full, (others, shot_at), fragment = study.effort == FULL, packs(), toml("twaron_ct612_v50")["projectile"]
    radius, mass = 0.5e-3 * fragment["diameter_mm"], 1e-3 * fragment["mass_g"]
    shot_at = shot_at if full else shot_at[:1]
    networks = [(pack, "bonded", bar, WIDTHS[0]) for bar in BARS for pack in others + shot_at] if full else []
    networks += [(pack, form, 2.0, WIDTHS[1 if full else 2]) for form in ("bonded", "separate") for pack in shot_at]
    scenes = [pack.scene(form, bar, width, radius, mass) for pack, form, bar, width in networks]
    hits = lambda form: range((5 if form == "bonded" else 3) if full else 2)
    # Longest jobs first.
    order = [(n, hit) for n, network in enumerate(networks) for hit in hits(network[1])]
    order.sort(key=lambda job: (networks[job[0]][1] == "bonded", -networks[job[0]][0].plies))
    # Near the trend of the measurements.
    guess = lambda pack: 300.0 * max(math.sqrt(pack.plies * pack.areal_density()), 0.3)
    jobs = [(scenes[n], guess(networks[n][0]), hit, LONGEST[networks[n][1]]) for n, hit in order]
    found, rows = dict(zip(order, study.each(measured, jobs, "packs"))), []
    for n, ((pack, form, bar, width), scene) in enumerate(zip(networks, scenes)):
        limits, density = [found[n, hit] for hit in hits(form)], pack.plies * pack.areal_density()
        modulus, stretch = scene["yarn.modulus_mean"], scene["yarn.critical_stretch"]
        axis = cunniff_velocity(0.5 * modulus * stretch * (stretch * stretch - 1.0), stretch - 1.0, modulus, FIBRE)
        rows.append(
            {
                "pack": pack.name,
                "form": form,
                "yarns a bar": bar,
                "width mm": 1e3 * width,
                "plies": pack.plies,
                "areal density kg/m2": density,
                "A_d A_p/m_p": density * math.pi * radius * radius / mass,
                "(U*)^(1/3) m/s": axis,
                "hits": len(limits),
                "limit m/s": mean(limits),
                "limit m/s: deviation": deviation(limits),
                "measured V50 m/s": pack.measured,
            }
        )
    study.write("packs", rows)
    return judged(study, rows)


def judged(study, rows):
    lacks = {
        "bonded": "plies that part, friction, slip, rate, the pack's true boundary; fibre before weaving",
        "separate": "friction, slip, rate, the pack's true boundary, the gap of its plies; fibre before weaving",
    }
    comparisons, lines, series, slopes, orders = [], [], [], [], []
    kind = lambda row: (row["form"], row["yarns a bar"], row["width mm"])
    for form, bar, width in dict.fromkeys(map(kind, rows)):
        own = [row for row in rows if kind(row) == (form, bar, width)]
        points = []
        for row in own:
            ours, measured = mean_of(row, "limit m/s", BISECTION), row["measured V50 m/s"]
            words, verdict = "", ""
            if measured == measured:
                points.append(
                    Point(
                        f"{row['areal density kg/m2']:.1f} kg/m², m/s", ours, (measured - V50_INTERVAL, measured + V50_INTERVAL)
                    )
                )
                words, verdict = f"{measured:.0f} ± {V50_INTERVAL:.0f}", points[-1].verdict
            pack = f"{bar:g} {width:.0f} {row['plies']:.0f} {row['areal density kg/m2']:.2f}".split()
            off = f"{100 * (ours.value / measured - 1):+.0f}" if words else ""
            cunniff = f"{row['A_d A_p/m_p']:.4f} {ours.value / row['(U*)^(1/3) m/s']:.3f}".split()
            lines.append([row["pack"], form, *pack, ours.text(0), words, off, verdict, *cunniff])
        title = f"five packs of Twaron CT612, {form}, {bar:g} yarns a bar, {width:.0f} mm"
        comparisons.append(Comparison(f"V50 of {title}", "measurement", f"± {V50_INTERVAL:.0f} m/s", points, 0, lacks[form]))
        shot_at = [row for row in own if row["measured V50 m/s"] == row["measured V50 m/s"]]
        found = slope_points(shot_at)
        comparisons.append(Comparison(f"slope of the V50 of {title}", "measurement", "from ± 19 m/s", found, 0, lacks[form]))
        limits = [(mean_of(row, "limit m/s", BISECTION), row["measured V50 m/s"]) for row in shot_at]
        if found:
            orders.append(order(f"{form}, {bar:g} yarns a bar, {width:.0f} mm", limits))
        slopes += [
            [form, f"{bar:g}", f"{width:.0f}", one.name, one.ours.text(0), "{:.0f} to {:.0f}".format(*one.allowed), one.verdict]
            for one in found
        ]
        for name in dict.fromkeys(row["pack"] for row in own):
            line = [row for row in own if row["pack"] == name]
            scaled = [(row["A_d A_p/m_p"], mean_of(row, "limit m/s", BISECTION), row["(U*)^(1/3) m/s"]) for row in line]
            bars = [(ours.low / u, ours.high / u) for _, ours, u in scaled]
            series.append(
                Series(
                    f"{name.split()[0]}, {form}, {bar:g} yarn{'s' * (bar != 1)} per bar, {width:.0f} mm",
                    [(x, ours.value / u) for x, ours, u in scaled],
                    "marked",
                    bars,
                )
            )
    wide = [row for row in rows if row["width mm"] == rows[0]["width mm"]]
    both = [
        [row for row in wide if row["form"] == "bonded" and row["yarns a bar"] == bar]
        for bar in sorted({row["yarns a bar"] for row in wide})
    ]
    points = [
        Point(
            f"{fine['pack']}, {fine['plies']:.0f} plies",
            Estimate.quotient(mean_of(coarse, "limit m/s", BISECTION), mean_of(fine, "limit m/s", BISECTION)),
            about(1, 0.1),
        )
        for fine, coarse in zip(both[0], both[-1])
        if fine is not coarse
    ]
    comparisons.append(
        Comparison("ballistic limit of bonded packs with two yarns a bar over that with one", "itself", "± 10 %", points, 2)
    )
    measured = [row for row in rows if row["measured V50 m/s"] == row["measured V50 m/s"] and kind(row) == kind(rows[0])]
    points = [(row["A_d A_p/m_p"], row["measured V50 m/s"] / row["(U*)^(1/3) m/s"]) for row in measured]
    bars = [
        tuple((row["measured V50 m/s"] + side * V50_INTERVAL) / row["(U*)^(1/3) m/s"] for side in (-1, 1)) for row in measured
    ]
    series.append(Series("Twaron, measured", points, "points", bars))
    drawing.draw(
        study.folder / "packs.svg",
        "Ballistic limit on Cunniff's axes: Kevlar KM2 S706, Twaron CT612, fragment of 1.10 g",
        "areal density × presented area / mass",
        "V50 / (U*)^(1/3)",
        series,
        "from zero",
    )
    study.picture("packs.svg", "validation_packs.svg")
    heading = (
        "pack; form; yarns a bar; width, mm; plies; kg/m²; model m/s [95 %]; measured m/s; off %; verdict; A_d A_p/m_p; "
        "model V50/(U*)^(1/3)"
    ).split("; ")
    text = page.markdown(heading, lines, 2)
    if slopes:
        text += "\nRise of the V50 of Twaron CT612 with the areal density, m/s per kg/m²:\n\n" + page.markdown(
            ["form", "yarns a bar", "width, mm", "between", "model [95 %]", "measured", "verdict"], slopes, 1
        )
        scatter = math.sqrt(2) * V50_INTERVAL
        text += f"\nPairs of packs whose measured V50 differ by more than the scatter, {scatter:.0f} m/s:\n\n"
        text += page.markdown(ORDER, orders, 1)
    return (
        comparisons,
        "## Ballistic limit of packs\n\n" + text + "\n(U*)^(1/3) of the fibres of data/measured/fibres.toml:\n\n" + fibres(),
        True,
    )


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


def fibres():
    """Cunniff's velocity of each fibre, before weaving."""
    file, lines = toml("fibres"), []
    for fibre in file["fibre"]:
        velocity = cunniff_velocity(
            1e9 * fibre["strength_gpa"],
            1e-2 * fibre["failure_strain_percent"],
            1e9 * fibre["modulus_gpa"],
            1e3 * fibre["density_g_per_cm3"],
        )
        lines.append([fibre["name"], f"{velocity:.0f}", fibre.get("mark", file["mark"])])
    return page.markdown(["fibre", "m/s", "mark"], lines)
