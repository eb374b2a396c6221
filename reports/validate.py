"""The model against closed forms and measurements: verdicts by the rule of statistics.py, tables and pictures of docs/validation.md."""

import json
import math
import pathlib
import shutil
import tomllib
from typing import NamedTuple

from . import page, plot
from .error_time import read, shown
from .friction import BISECTION
from .plot import Series
from .statistics import Estimate, verdict_of_all

# Areal density at which the measured ladder bends, kg/m².
BREAK = 5.0
# Half of the 38 m/s that MIL-STD-662F allows between the shots that a V50 is the mean of; the source of the ladder gives no interval.
V50_INTERVAL = 19.0
PICTURES = ["yarn", "spacing", "packs"]
COMMAND = "fabric-study validate{}` and `python3 -m reports validate --docs docs"
RULE = (
    'A row\'s quantity is computed with its 95 % interval and compared with the range that is allowed. "Agrees" if the whole interval of '
    'every point lies inside, "does not" if all of one point\'s lies outside, otherwise "cannot be told". What is deterministic has no '
    "interval. The column of points names the worst one, the farthest from the middle of its range in widths of the range.\n\n"
)


class Point(NamedTuple):
    """One comparison: name, value of the model, allowed range."""

    name: str
    ours: Estimate
    allowed: tuple

    @property
    def verdict(self):
        return self.ours.verdict(self.allowed)

    @property
    def off(self):
        low, high = self.allowed
        return abs(self.ours.value - 0.5 * (low + high)) / (high - low)


class Comparison(NamedTuple):
    """A row of the first table. digits: of the numbers."""

    what: str
    kind: str
    allowed: str
    points: list
    digits: int
    lacks: str = ""

    @property
    def verdict(self):
        return verdict_of_all([point.verdict for point in self.points])

    def row(self):
        worst = max(self.points, key=lambda point: point.off if math.isfinite(point.off) else math.inf)
        return [self.what, self.kind, self.allowed, f"{len(self.points)}; {worst.name}: {worst.ours.text(self.digits)}", self.verdict, self.lacks]


def exact(value):
    return Estimate.exact(value)


def about(middle, part):
    """The range of a value and so many parts of it to both sides."""
    return middle * (1 - part), middle * (1 + part)


def mean_of(row, name, resolution=0.0):
    """A mean from its column, that of its deviation and the number of hits; resolution: of each value, in parts of it."""
    value, count = row[name], row["hits"]
    error = math.hypot(row[f"{name}: deviation"] / math.sqrt(count), resolution * value / math.sqrt(12))
    return Estimate.of_error(value, error, count - 1) if count > 1 else Estimate(value, -math.inf, math.inf)


def report(folder, docs=None):
    effort = json.loads((folder / "validate.json").read_text())["effort"]
    comparisons, text = [], ""
    for name, (title, write) in PARTS.items():
        rows = [{key: read(value) for key, value in row.items()} for row in page.rows_of(folder / f"{name}.csv", needed=False)]
        if rows:
            found, part = write(folder, rows)
            comparisons += [comparison for comparison in found if comparison.points]
            text += f"\n## {title}\n\n{part}"
    heading = ["comparison", "with", "allowed", "points; the worst", "verdict", "what the model lacks"]
    verdicts = page.markdown(heading, [comparison.row() for comparison in comparisons], 6)
    print(page.printed(heading[:5], [comparison.row()[:5] for comparison in comparisons]))
    print(text)
    if docs:
        page.write_table(docs, "validation", "The model against closed forms and measurements", COMMAND.format(effort), RULE + verdicts + text)
        for name in PICTURES:
            if (folder / f"{name}.svg").exists():
                (docs / "images").mkdir(parents=True, exist_ok=True)
                shutil.copy(folder / f"{name}.svg", docs / "images" / f"validation_{name}.svg")


def table(rows, columns, text=1):
    """columns: (heading, key or function, digits)."""
    of = lambda row, key: key(row) if callable(key) else row[key]
    return page.markdown([heading for heading, *_ in columns], [[shown(of(row, key), digits) for _, key, digits in columns] for row in rows], text)


def same(names, digits):
    return [(name, name, digits) for name in names]


def error(name):
    """Of a wave's quantity, in %."""
    return lambda row: 100 * (row[name] / row[f"exact {name}"] - 1)


def yarn(folder, rows):
    quantities = {"strain %": 4, "front m/s": 0, "kink m/s": 0}
    fabric = [row for row in rows if row["yarns a bar"] == 1]
    comparisons = []
    for viscosity in dict.fromkeys(row["viscosity"] for row in rows):
        own = [row for row in fabric if row["viscosity"] == viscosity and row["strain %"] == row["strain %"]]
        for name, what in (("strain %", "strain behind the front"), ("front m/s", "longitudinal wave"), ("kink m/s", "transverse wave")):
            points = [Point(f"{row['yarn']} at {row['impact m/s']:.0f} m/s", exact(row[name] / row[f"exact {name}"]), about(1, 0.01)) for row in own]
            comparisons.append(Comparison(f"one yarn hit across, viscosity {viscosity}: {what} over theory", "theory", "± 1 %", points, 4))
    series = []
    for name in dict.fromkeys(row["yarn"] for row in fabric):
        own = [row for row in fabric if row["yarn"] == name]
        plain = [row for row in own if row["viscosity"] == "none"]
        series += [
            Series(f"{name}: the model's law", [(row["impact m/s"], row["exact strain %"]) for row in plain], "line"),
            Series(f"{name}: Smith, linear in the strain", [(row["impact m/s"], row["linear strain %"]) for row in plain], "dashed"),
            *(Series(f"{name}: network, viscosity {v}", [(row["impact m/s"], row["strain %"]) for row in own if row["viscosity"] == v], "points")
              for v in dict.fromkeys(row["viscosity"] for row in own)),
        ]
    plot.draw(folder / "yarn.svg", "One yarn hit across: strain behind the longitudinal front", "impact velocity (m/s)", "strain (%)", series)
    columns = [*same(["yarn", "viscosity"], None), ("impact m/s", "impact m/s", 0)]
    for name, digits in quantities.items():
        columns += [(name, name, digits), ("theory", f"exact {name}", digits), ("off %", error(name), 3), ("linear theory", f"linear {name}", digits)]
    text = table(fabric, columns, 2) + "\nAn empty row: the yarn broke.\n"
    if len(fabric) < len(rows):
        text += "\nError of the strain in % with longer and shorter bars, and the order of convergence between the last two:\n\n" + orders(rows)
    return comparisons, text


def orders(rows):
    bars = sorted({row["yarns a bar"] for row in rows}, reverse=True)
    keys = dict.fromkeys((row["yarn"], row["viscosity"], row["impact m/s"]) for row in rows if row["yarns a bar"] != 1)
    lines = []
    for key in keys:
        errors = {row["yarns a bar"]: error("strain %")(row) for row in rows if (row["yarn"], row["viscosity"], row["impact m/s"]) == key}
        last, finest = errors[bars[-2]], errors[bars[-1]]
        # An error of some 1e-5 is that of the reading.
        order = f"{math.log2(last / finest):.2f}" if last * finest > 0 and abs(last) > 0.01 else ""
        lines.append([key[0], key[1], f"{key[2]:.0f}", *(shown(errors[bar], 3) for bar in bars), order])
    return page.markdown(["yarn", "viscosity", "impact m/s", *(f"{bar:g} yarns a bar" for bar in bars), "order"], lines, 2)


def critical(folder, rows):
    """Two comparisons for each viscosity: a cylinder larger than a bar, and one as thin, whose kink is no longer than the bar."""
    comparisons = []
    for viscosity, thin in [(row["viscosity"], thin) for row in rows for thin in (False, True)]:
        title = f"critical velocity of a yarn, viscosity {viscosity}{', a cylinder as thin as a bar' if thin else ''}, over theory"
        points = [
            Point(f"{row['yarn']}, R = {row['cylinder R spacings']:.0f} spacings, {row['yarns a bar']:g} yarns a bar", exact(row["critical m/s"] / row["exact m/s"]), about(1, 0.05))
            for row in rows if row["viscosity"] == viscosity and (row["cylinder R spacings"] <= row["yarns a bar"]) == thin
        ]
        if not points or any(known.what == title for known in comparisons):
            continue
        lacks = "shorter bars at the kink" if viscosity != "none" else "damping: the noise of the kink breaks the yarn early"
        comparisons.append(Comparison(title, "theory", "± 5 %", points, 3, lacks if thin or viscosity == "none" else ""))
    columns = [*same(["yarn", "viscosity"], None), *same(["yarns a bar", "cylinder R spacings"], 1), *same(["critical m/s", "exact m/s"], 0)]
    columns += [("over theory", lambda row: row["critical m/s"] / row["exact m/s"], 3), ("linear theory m/s", "linear m/s", 0)]
    return comparisons, table(rows, columns, 2)


def strength(folder, rows):
    points, lines = [], []
    for row in rows:
        ours = Estimate.of_error(row["scale MPa"], row["standard error MPa"], row["samples"] - 1)
        point = Point(f"{row['sample']}, MPa", ours, about(row["measured MPa"], 0.03))
        points.append(point)
        lines.append([
            row["sample"], ours.text(0), f"{row['measured MPa']:.0f}", f"{100 * (row['scale MPa'] / row['measured MPa'] - 1):+.1f}", point.verdict,
            f"{row['shape']:.1f}", f"{row['measured shape']:.1f}",
        ])
    heading = ["", "Weibull scale, model MPa [95 %]", "measured MPa", "off %", "verdict", "shape, model", "measured shape"]
    lacks = "two numbers of the input are the line through the six"
    return [Comparison("Weibull scale of Kevlar 49 yarn at six gauge lengths", "measurement", "± 3 %", points, 0, lacks)], page.markdown(heading, lines)


def rate(folder, rows):
    comparisons, lines = [], []
    for name, unit, digits in (("modulus", "GPa", 1), ("strength", "MPa", 0)):
        measured = f"measured {unit}"
        points = [Point(f"{row['rate 1/s']:.0f}/s, {unit}", exact(row[f"{name} {unit}"]), about(row[measured], 0.1)) for row in rows]
        comparisons.append(Comparison(f"{name} of Kevlar 49 fabric at three rates of strain", "measurement", "± 10 %", points, digits, "the lowest and the highest rate are input; one is a test"))
        for row, point in zip(rows, points):
            value, deviation = row[measured], row[f"{measured}: deviation"]
            lines.append([
                f"{name}, {row['rate 1/s']:.0f}/s", f"{point.ours.value:.{digits}f} {unit}", f"{value:.0f} ± {deviation:.0f} {unit}",
                f"{100 * (point.ours.value / value - 1):+.1f}", f"{(point.ours.value - value) / deviation:+.1f}", point.verdict,
            ])
    return comparisons, page.markdown(["", "model", "measured, ± one deviation", "off %", "off, deviations", "verdict"], lines)


def cone(folder, rows):
    jump = [Point(f"{row['impact m/s']:.0f} m/s", exact(row["front m/s"] / row["jump condition m/s"]), about(1, 0.05)) for row in rows]
    strip = [Point(f"{row['impact m/s']:.0f} m/s", exact(row["front m/s"] / row["strip m/s"]), about(1, 0.05)) for row in rows]
    comparisons = [
        Comparison("front of the pyramid of a sheet, along the yarns, over the jump condition", "theory", "± 5 %", jump, 3),
        Comparison("the same over Smith's relation with doubled mass", "theory of a line, not of a point", "± 5 %", strip, 3, "nothing: the theory leaves out that hit yarns drag the crossing ones"),
    ]
    columns = [("impact m/s", "impact m/s", 0), ("failed segments", "failed segments", 0), ("strain before the front %", "strain before the front %", 3), ("with doubled mass %", "strip strain %", 3)]
    columns += [("front m/s", "front m/s", 0), ("jump condition m/s", "jump condition m/s", 0), ("doubled mass m/s", "strip m/s", 0)]
    columns += [("along the diagonal, of that along the yarns", lambda row: row["diagonal front m/s"] / row["front m/s"], 2)]
    return comparisons, table(rows, columns)


def spacing(folder, rows):
    found, series = {}, []
    networks = lambda row: (row["plies"], row["viscosity"], row["damage rate"], row["damage rate and length"])
    for key in dict.fromkeys(map(networks, rows)):
        own = [row for row in rows if networks(row) == key]
        plies, viscosity, damage_rate, length = key
        base = next((row for row in own if row["yarns a bar"] == 1), None)
        for column, what, resolution in (("limit m/s", "ballistic limit", BISECTION), ("absorbed J", "absorbed energy", 0.0)):
            for row in own if base else []:
                # Bars as long as the sphere's radius are shown, not judged.
                if row["yarns a bar"] < 4 and row is not base and row[column] == row[column]:
                    ratio = Estimate.quotient(mean_of(row, column, resolution), mean_of(base, column, resolution))
                    name = f"{plies:.0f} plies, damage rate {damage_rate:.0f} {length}, {row['yarns a bar']:g} yarns a bar"
                    found.setdefault((what, viscosity), []).append(Point(name, ratio, about(1, 0.1)))
        if length == "constant":
            name = f"{plies:.0f} plies, damage rate {damage_rate:.0f}, viscosity {viscosity}"
            series.append(Series(name, [(row["yarns a bar"], row["absorbed J"] / (base or own[-1])["absorbed J"]) for row in own]))
    lacks = lambda viscosity: "damping: noise chooses which bars fail first" if viscosity == "none" else ""
    comparisons = [
        Comparison(f"{what} of a sheet over that with one yarn a bar, viscosity {viscosity}", "itself", "± 10 %", points, 2, lacks(viscosity))
        for (what, viscosity), points in found.items()
    ]
    plot.draw(
        folder / "spacing.svg", "Absorbed energy at about twice the ballistic limit", "yarns a bar", "over that with one yarn a bar",
        sorted(series, key=lambda line: -len(line.points)), "logarithmic x",
    )
    value = lambda name, digits: lambda row: f"{row[name]:.{digits}f} ± {row[name + ': deviation'] / math.sqrt(row['hits']):.{digits}f}" if row[name] == row[name] else ""
    columns = [("plies", "plies", 0), *same(["viscosity"], None), ("damage rate of one yarn a bar", "damage rate", 0), ("with the length of a bar", "damage rate and length", None)]
    columns += [("yarns a bar", "yarns a bar", 2), ("hits", "hits", 0), ("absorbed J", value("absorbed J", 2), None), ("limit m/s", value("limit m/s", 1), None), ("energy residual %", "energy residual %", 2)]
    return comparisons, table(rows, columns, 4) + "\n±: standard error of the mean.\n"


def packs(folder, rows):
    lacks = {
        "bonded": "plies that part, friction, slip, rate, the pack's true boundary; fibre before weaving",
        "separate": "friction, slip, rate, the pack's true boundary, the gap of its plies; fibre before weaving",
    }
    comparisons, lines, series, slopes = [], [], [], []
    kind = lambda row: (row["form"], row["yarns a bar"], row["width mm"])
    for form, bar, width in dict.fromkeys(map(kind, rows)):
        own = [row for row in rows if kind(row) == (form, bar, width)]
        points = []
        for row in own:
            ours, measured = mean_of(row, "limit m/s", BISECTION), row["measured V50 m/s"]
            words, verdict = "", ""
            if measured == measured:
                points.append(Point(f"{row['areal density kg/m2']:.1f} kg/m², m/s", ours, (measured - V50_INTERVAL, measured + V50_INTERVAL)))
                words, verdict = f"{measured:.0f} ± {V50_INTERVAL:.0f}", points[-1].verdict
            lines.append([
                row["pack"], form, f"{bar:g}", f"{width:.0f}", f"{row['plies']:.0f}", f"{row['areal density kg/m2']:.2f}", ours.text(0), words,
                f"{100 * (ours.value / measured - 1):+.0f}" if words else "", verdict, f"{row['A_d A_p/m_p']:.4f}", f"{ours.value / row['(U*)^(1/3) m/s']:.3f}",
            ])
        title = f"five packs of Twaron CT612, {form}, {bar:g} yarns a bar, {width:.0f} mm"
        comparisons.append(Comparison(f"V50 of {title}", "measurement", f"± {V50_INTERVAL:.0f} m/s", points, 0, lacks[form]))
        found = slope_points([row for row in own if row["measured V50 m/s"] == row["measured V50 m/s"]])
        comparisons.append(Comparison(f"slope of the V50 of {title}", "measurement", "from ± 19 m/s", found, 0, lacks[form]))
        slopes += [[form, f"{bar:g}", f"{width:.0f}", point.name, point.ours.text(0), f"{point.allowed[0]:.0f} to {point.allowed[1]:.0f}", point.verdict] for point in found]
        for name in dict.fromkeys(row["pack"] for row in own):
            line = [row for row in own if row["pack"] == name]
            scaled = [(row["A_d A_p/m_p"], mean_of(row, "limit m/s", BISECTION), row["(U*)^(1/3) m/s"]) for row in line]
            bars = [(ours.low / u, ours.high / u) for _, ours, u in scaled]
            series.append(Series(f"{name}, {form}, {bar:g} yarns a bar, {width:.0f} mm", [(x, ours.value / u) for x, ours, u in scaled], "marked", bars))
    wide = [row for row in rows if row["width mm"] == rows[0]["width mm"]]
    both = [[row for row in wide if row["form"] == "bonded" and row["yarns a bar"] == bar] for bar in sorted({row["yarns a bar"] for row in wide})]
    points = [
        Point(f"{fine['pack']}, {fine['plies']:.0f} plies", Estimate.quotient(mean_of(coarse, "limit m/s", BISECTION), mean_of(fine, "limit m/s", BISECTION)), about(1, 0.1))
        for fine, coarse in zip(both[0], both[-1]) if fine is not coarse
    ]
    comparisons.append(Comparison("ballistic limit of bonded packs with two yarns a bar over that with one", "itself", "± 10 %", points, 2))
    measured = [row for row in rows if row["measured V50 m/s"] == row["measured V50 m/s"] and kind(row) == kind(rows[0])]
    points = [(row["A_d A_p/m_p"], row["measured V50 m/s"] / row["(U*)^(1/3) m/s"]) for row in measured]
    bars = [tuple((row["measured V50 m/s"] + side * V50_INTERVAL) / row["(U*)^(1/3) m/s"] for side in (-1, 1)) for row in measured]
    series.append(Series("Twaron CT612, measured", points, "points", bars))
    plot.draw(
        folder / "packs.svg", "Ballistic limit on Cunniff's axes: fragment of 1.10 g", "areal density x presented area / mass of the fragment",
        "V50 / (U*)^(1/3)", series, "from zero",
    )
    heading = ["pack", "form", "yarns a bar", "width, mm", "plies", "kg/m²", "model m/s [95 %]", "measured m/s", "off %", "verdict", "A_d A_p/m_p", "model V50/(U*)^(1/3)"]
    text = page.markdown(heading, lines, 2)
    if slopes:
        text += "\nRise of the V50 of Twaron CT612 with the areal density, m/s per kg/m²:\n\n" + page.markdown(["form", "yarns a bar", "width, mm", "between", "model [95 %]", "measured", "verdict"], slopes, 1)
    return comparisons, text + "\n(U*)^(1/3) of the fibres of validation/fibres.toml:\n\n" + fibres()


def slope_points(rows):
    """Rise of V50 from the thinnest pack to that of BREAK, and from there to the thickest, m/s per kg/m²."""
    rows = sorted(rows, key=lambda row: row["areal density kg/m2"])
    middle = next((row for row in rows if row["areal density kg/m2"] == BREAK), None)
    points = []
    for low, high in [(rows[0], middle), (middle, rows[-1])] if middle else []:
        span = high["areal density kg/m2"] - low["areal density kg/m2"]
        ends = [mean_of(row, "limit m/s", BISECTION) for row in (low, high)]
        half = math.hypot(*(0.5 * (end.high - end.low) for end in ends)) / span
        value = (ends[1].value - ends[0].value) / span
        measured = (high["measured V50 m/s"] - low["measured V50 m/s"]) / span
        allowed = math.sqrt(2) * V50_INTERVAL / span
        name = f"{low['areal density kg/m2']:g} and {high['areal density kg/m2']:g} kg/m²"
        points.append(Point(name, Estimate(value, value - half, value + half), (measured - allowed, measured + allowed)))
    return points


def fibres():
    """Cunniff's velocity of each fibre, before weaving."""
    file = tomllib.loads((pathlib.Path(__file__).parent.parent / "validation" / "fibres.toml").read_text())
    lines = []
    for fibre in file["fibre"]:
        density, modulus = 1e3 * fibre["density_g_per_cm3"], 1e9 * fibre["modulus_gpa"]
        work = 1e9 * fibre["strength_gpa"] * 1e-2 * fibre["failure_strain_percent"] / (2 * density)
        lines.append([fibre["name"], f"{math.cbrt(work * math.sqrt(modulus / density)):.0f}", fibre.get("mark", file["mark"])])
    return page.markdown(["fibre", "m/s", "mark"], lines)


PARTS = {
    "yarn": ("One yarn hit across", yarn),
    "critical": ("Critical velocity of a yarn", critical),
    "strength": ("Strength at six gauge lengths", strength),
    "rate": ("Modulus and strength at three rates of strain", rate),
    "cone": ("The pyramid of a sheet hit at a point", cone),
    "spacing": ("Convergence in the spacing", spacing),
    "packs": ("Ballistic limit of packs", packs),
}
