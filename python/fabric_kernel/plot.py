"""Plots in one style: histories, sheets, residual velocities, limits and maps. The same numbers give the same bytes.

Each returns a figure of matplotlib, and writes it if `path` is given (its ending says the kind: svg, png, pdf).
"""

import itertools
import math
import re
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib.ticker
import numpy
from matplotlib.figure import Figure

from . import sheets
from .drawing import COLOURS, below, new, saved, styled
from .files import Place
from .likelihood import LINKS
from .window import slower

if TYPE_CHECKING:
    import pandas


@styled
def history(
    rows: "pandas.DataFrame", path: Place | None = None, *, title: str = "", marks: Sequence[tuple[float, str]] = ()
) -> Figure:
    """Rows of `fabric_kernel.history`: velocity of the projectile, force on it, largest deflection of held cloth, and where the
    absorbed energy is, over time. marks: time (s) and name of events."""
    marks, (figure, panels) = list(marks), new(8.5, 11.0, rows=4, sharex=True)
    energies = {
        "absorbed": "absorbed",
        "fabric_kinetic": "fabric kinetic",
        "strain": "strain",
        "dissipated": "dissipated by rupture",
        "viscous": "dissipated by viscosity",
        "friction": "friction",
        "ply_loss": "lost where plies meet",
        "casing_loss": "lost on the case",
        "attachment": "dissipated in clamps",
        "contact_loss": "contact loss",
        "energy_residual": "residual",
    }
    for panel, columns, label in (
        (panels[0], {f"velocity_{axis}": f"along {axis}" for axis in "zxy"}, "velocity (m/s)"),
        (panels[1], {f"force_{axis}": f"along {axis}" for axis in "zxy"}, "mean force between samples (N)"),
        (panels[2], {"max_deflection": "largest"}, "deflection (m)"),
        (panels[3], energies, "energy (J)"),
    ):
        for at, _ in marks:
            panel.axvline(1e6 * at, color="#969696", linewidth=1, linestyle="--")
        for number, (name, words) in enumerate(columns.items()):
            panel.plot(1e6 * rows["time"], rows[name], color=COLOURS[number], label=words)
        panel.set_ylabel(label)
        panel.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
    for at, name in marks:
        panels[0].text(
            1e6 * at,
            0.99,
            f"{name} ",
            transform=panels[0].get_xaxis_transform(),
            ha="right",
            va="top",
            fontsize=8,
            color="#5a5a5a",
        )
    panels[0].set_title(title)
    panels[3].set_xlabel("time (µs)")
    return saved(figure, path)


def sheet(simulation: Any, path: Place | None = None, *, title: str = "") -> Figure:
    """A simulation's sheet as it is now, coloured by strain, with its projectile; of a stack the first ply. Raises ValueError for
    a projectile that is not drawn."""
    now = sheets.Sheet(simulation)
    return sheets.picture(now, path, title or f"{1e6 * now.time:.1f} µs, {now.failed()} failed segments")


def profile(simulation: Any, path: Place | None = None, *, title: str = "") -> Figure:
    """The back face of a simulation as it is now, of a stack that of its last ply: deflection along both yarns under the
    projectile."""
    now = sheets.Sheet(simulation, simulation.scene["stack.plies"] - 1)
    return sheets.profile(now, path, title or f"back face at {1e6 * now.time:.1f} µs")


@styled
def tornado(found: Any, path: Place | None = None) -> Figure:
    """The change of a limit by each variant, with its interval; the largest above."""
    rows = [one for one in found.changes if math.isfinite(one.percent)][::-1]
    figure, axis = new(height=1.2 + 0.4 * len(rows))
    places = range(len(rows))
    axis.barh(
        places, [one.percent for one in rows], color=[COLOURS[0] if one.percent > 0 else COLOURS[1] for one in rows], height=0.62
    )
    ends = [[max(0.0, sign * (getattr(one, end) - one.percent)) for one in rows] for end, sign in (("low", -1), ("high", 1))]
    reach = 1.3 * max((abs(one.percent) for one in rows), default=1.0) + 2.0
    # An end that is not known runs out of the picture.
    axis.errorbar(
        [one.percent for one in rows],
        places,
        xerr=numpy.minimum(ends, 4 * reach),
        fmt="none",
        color=COLOURS[6],
        capsize=3,
        linewidth=1,
    )
    for end, sign, mark in (("low", -1, "<"), ("high", 1, ">")):
        beyond = [place for place, one in zip(places, rows) if sign * getattr(one, end) > reach]
        axis.plot([sign * 0.985 * reach] * len(beyond), beyond, mark, color=COLOURS[6])
    axis.set_yticks(places, ["\n".join(textwrap.wrap(one.variant, 32)) for one in rows], fontsize=9)
    axis.axvline(0.0, color="#888888", linewidth=1)
    axis.set(xlim=(-reach, reach), xlabel=f"change of the limit of {found.limit:.1f} m/s (%)")
    axis.grid(visible=False, axis="y")
    return saved(figure, path)


@styled
def residual(curve: Any, path: Place | None = None) -> Figure:
    """Residual over impact velocity, with the curves that were fitted and the bands of their intervals."""
    figure, axis = new()
    v, out, through = (numpy.array([shot[k] for shot in curve.shots]) for k in (0, 2, 1))
    through = ~through.astype(bool)
    grid = numpy.linspace(0.95 * v.min(), 1.02 * v.max(), 600)
    for fit, colour, words in zip(curve.fits, COLOURS, ("Recht and Ipson", "Lambert and Jonas")):
        if math.isfinite(fit.best.limit):
            axis.fill_between(grid, *fit.band(grid), color=colour, alpha=0.15, linewidth=0)
            axis.plot(grid, fit.best.curve(grid), color=colour, label=f"{words}, with its {100 * curve.confidence:g} % band")
    axis.plot(v[through], out[through], "o", color=COLOURS[6], label="through")
    axis.plot(v[~through], out[~through], "o", color=COLOURS[6], fillstyle="none", label="stopped")
    axis.set(title=curve.title, xlabel="impact velocity (m/s)", ylabel="residual velocity (m/s)", ylim=(-0.02 * v.max(), None))
    axis.legend(loc="upper left")
    return saved(figure, path)


@styled
def compare(found: Any, path: Place | None = None) -> Figure:
    """Limits of shields with their intervals above their areal densities; of a table of parameters over the one with most values,
    a line for each value of the others."""
    name = "V50 (m/s)" if math.isnan(found.at) else f"stopped at {found.at:g} m/s (%)"
    known = [one for one in found.shields if math.isfinite(one.value)]
    count, lines = len(found.shields), lines_of_table(found) if found.axes else []
    width = 5.6 if lines else max(5.6, 2.6 + 0.9 * count)
    figure, (upper, lower) = new(width, 5.6, rows=2, sharex=True, gridspec_kw={"height_ratios": [2.2, 1.0]})
    low, high = min((one.value for one in known), default=0.0), max((one.value for one in known), default=1.0)
    far = 0.5 * high + 1.0  # An end that is not known runs out of the picture.
    error = lambda one: [[min(one.value - one.interval.low, far)], [min(one.interval.high - one.value, far)]]
    for number, (label, column, its) in enumerate(lines):
        colour = COLOURS[number % len(COLOURS)]
        upper.plot([x for x, _ in its], [one.value for _, one in its], color=colour, label=label)
        lower.plot([x for x, _ in its], [one.areal_density for _, one in its], marker="o", color=colour)
        # Side by side, as intervals of lines near each other hide one another.
        aside = 0.012 * (number - 0.5 * (len(lines) - 1)) * (its[-1][0] - its[0][0])
        for x, one in its:
            upper.errorbar(x + aside, one.value, yerr=error(one), fmt="o", color=colour, capsize=3)
        lower.set_xlabel(column)
    if lines and len(at := sorted({x for *_, its in lines for x, _ in its})) <= 12:
        lower.set_xticks(at)
    if not lines:
        places = {one.name: k for k, one in enumerate(found.shields)}
        for k, one in enumerate(one for one in known if one.shift):
            ends = [one.value * (1.0 + 0.01 * min(max(end, -50.0), 50.0)) for end in one.shift.interval]
            named = None if k else "with bars half as long"
            upper.plot([places[one.name] + 0.15] * 2, ends, color="#b0b0b0", linewidth=5, label=named, solid_capstyle="butt")
        for k, one in enumerate(known):
            named = None if k else f"model, {100 * found.confidence:g} %"
            upper.errorbar(places[one.name], one.value, yerr=error(one), fmt="o", color=COLOURS[0], capsize=4, label=named)
        for k, one in enumerate(one for one in known if one.corrected and math.isfinite(one.corrected.value)):
            it, named = one.corrected, None if k else "with own tests"
            ends = [[it.value - it.interval.low], [it.interval.high - it.value]]
            upper.errorbar(places[one.name] - 0.15, it.value, yerr=ends, fmt="s", color=COLOURS[1], capsize=4, label=named)
            low, high = min(low, it.interval.low), max(high, it.interval.high)
        lower.bar(range(count), [one.areal_density for one in found.shields], color=COLOURS[5], width=0.5)
        names = ["\n".join(textwrap.wrap(Path(one.name).name, 16)) for one in found.shields]
        lower.set_xticks(range(count), names, fontsize=9)
        for axis in (upper, lower):
            axis.grid(visible=False, axis="x")
    spread, (bottom, top) = max(high - low, 0.1 * high), upper.get_ylim()
    upper.set_ylim(max(bottom, low - 1.5 * spread, 0.0), min(top, high + 1.5 * spread))
    upper.set(title=found.title, ylabel=f"{name}, {100 * found.confidence:g} % intervals" if lines else name)
    lower.set(ylabel="kg/m²", ylim=(0.0, None))
    below(figure, upper)
    return saved(figure, path)


def lines_of_table(found: Any) -> list[tuple[str, str, list[tuple[float, Any]]]]:
    """Lines of a table of parameters: label, name of the parameter along x, and x and shield; nothing without a number."""
    cells = {name: dict(zip(pairs[::2], pairs[1::2])) for name, *pairs in found.axes}
    first = next(iter(cells.values()))
    number = re.compile(r"[-+]?\d*\.?\d+(e[-+]?\d+)?")
    names = [name for name in first if all(number.match(row[name]) for row in cells.values())]
    if not names:
        return []
    along = max(names, key=lambda name: len({row[name] for row in cells.values()}))
    unit = number.sub("", first[along], 1).strip()
    lines: dict[str, list[tuple[float, Any]]] = {}
    for one in found.shields:
        if math.isfinite(one.value):
            row = cells[one.name]
            label = ", ".join(f"{name} {cell}" for name, cell in row.items() if name != along)
            x: Any = number.match(row[along])
            lines.setdefault(label or "limit", []).append((float(x[0]), one))
    column = f"{along} ({unit})" if unit else along
    return [(label, column, sorted(its, key=lambda one: one[0])) for label, its in sorted(lines.items())]


@styled
def own_tests(found: Any, path: Place | None = None) -> Figure:
    """Measured over computed limit of each own test over areal density, with the factor and its interval for another shield."""
    figure, axis = new(height=4.4)
    x, ratio = [one.areal_density for one in found.tests], numpy.exp([one.e() for one in found.tests])
    error = numpy.expm1([1.96 * math.hypot(one.measured_error, one.computed_error) for one in found.tests]) * ratio
    half, b = found.pool.half(0.0, found.confidence), found.pool.b
    axis.axhspan(math.exp(b - half), math.exp(b + half), color=COLOURS[0], alpha=0.15, linewidth=0)
    axis.axhline(
        math.exp(b), color=COLOURS[0], label=f"factor {math.exp(b):.3f}, {100 * found.confidence:g} % for another shield"
    )
    axis.axhline(1.0, color="#888888", linewidth=1, linestyle="--", label="model")
    axis.errorbar(x, ratio, yerr=error, fmt="o", color=COLOURS[6], capsize=3, label="own tests, 95 % of test and computation")
    for one, place, height in zip(found.tests, x, ratio):
        axis.annotate(
            Path(one.name).name, (place, height), xytext=(6, 5), textcoords="offset points", fontsize=8, color="#5a5a5a"
        )
    axis.margins(x=0.15)
    axis.set(title=found.title, xlabel="areal density (kg/m²)", ylabel="measured V50 / computed V50")
    below(figure, axis)
    return saved(figure, path)


@styled
def limit(test: Any, path: Place | None = None) -> Figure:
    """The share that goes through over velocity, with a band that joins the intervals, and the residual velocities."""
    fit, law = test.fit, LINKS[test.fit.link]
    velocities = numpy.array([shot.velocity for shot in test.shots])
    every = [*test.shots, *test.ladder]
    stopped = numpy.array([shot.stopped for shot in every])
    fitted = numpy.arange(len(every)) < len(test.shots)
    at, residuals = numpy.array([[shot.velocity, shot.residual] for shot in every]).T
    slow = numpy.zeros(len(every), bool)
    slow[~stopped] = slower(at[~stopped], residuals[~stopped])
    # A bracket may begin far away: what lies within a factor of two of V50 is drawn, if there is a V50.
    near = (velocities >= 0.5 * fit.mu) & (velocities <= 2.0 * fit.mu)
    drawn = numpy.append(velocities[near] if near.sum() > 1 else velocities, at[~fitted])
    margin = 0.15 * float(numpy.ptp(drawn)) or 0.1 * abs(float(drawn[0])) or 1.0
    left, right = max(0.0, float(drawn.min()) - margin), float(drawn.max()) + margin
    lost = int(((at < left) | (at > right)).sum())
    outside = f" ({lost} shots lie outside)" if lost else ""
    figure, (upper, lower) = new(height=6.6, rows=2, sharex=True)
    if fit.method != "none":
        quantiles = law.quantile(numpy.array(fit.shares))
        far = 10 * (right - left)
        low, high = (numpy.clip(side, left - far, right + far) for side in zip(*fit.intervals))
        z = numpy.linspace(quantiles.min(), quantiles.max(), 201)
        share = law.share(z)
        label = f"{100 * fit.confidence:g} %, joined between V01, V50 and V99"
        band = [numpy.interp(z, quantiles, side) for side in (low, high)]
        upper.fill_betweenx(share, *band, color="#0072b2", alpha=0.2, linewidth=0, label=label)
        upper.plot(fit.mu + z * fit.sigma, share, color="#0072b2", label=f"{fit.link}, {fit.method}")
    kinds = [(~stopped & ~slow, "o", "#d55e00", "full", "through"), (stopped, "o", "#464646", "none", "stopped")]
    kinds += [(slow, "s", "#cc79a7", "full", "through, of the slower group")] * bool(slow.any())
    for panel, heights in ((upper, numpy.where(stopped, 0.0, 1.0)), (lower, residuals)):
        for chosen, marker, colour, fill, label in kinds:
            own, other = chosen & fitted, chosen & ~fitted
            panel.plot(at[own], heights[own], marker, color=colour, fillstyle=fill, label=label)
            panel.plot(at[other], heights[other], "v", color=colour, fillstyle=fill, label="not fitted" if other.any() else None)
        panel.grid(color="#e3e3e3")
        panel.set_axisbelow(True)
    if math.isfinite(test.residual.limit):
        grid = numpy.linspace(left, right, 400)
        lower.plot(grid, test.residual.curve(grid), color="#009e73", label="Lambert and Jonas")
    upper.set(xlim=(left, right), ylabel="share that goes through", title=test.title)
    lower.set_ylim(top=1.15 * max(float(residuals[(at >= left) & (at <= right)].max(initial=0.0)), 1.0))
    lower.set(xlabel=f"impact velocity (m/s){outside}", ylabel="residual velocity (m/s)")
    below(figure, upper, lower)
    return saved(figure, path)


@styled
def accuracy(found: Any, path: Place | None = None) -> Figure:
    """Error over processor time of a shot, as `accuracy_on` draws it."""
    figure, axis = new(height=4.2)
    accuracy_on(axis, found)
    axis.set_xlim(min(row.seconds for row in found.rows) / 1.5, max(row.seconds for row in found.rows) * 2.5)
    for one in found.choices:
        axis.text(1.0, one.error, f"{one.error:g} %", transform=axis.get_yaxis_transform(), fontsize=8, va="bottom", ha="right")
    words = {"absorbed": "absorbed energy", "speed": "speed left", "deflection": "deflection", "limit": "limit"}[found.quantity]
    axis.set(xlabel="processor time of a shot (s)", ylabel=f"error of the mean {words} (%)")
    figure.suptitle("\n".join(textwrap.wrap(found.title, 56)), fontsize=11)
    below(figure, axis)
    return saved(figure, path)


def accuracy_on(axis: Any, found: Any, named: bool = True) -> None:
    """Error over processor time of a shot, marks for the networks and for what else was tried at one of them; what is recommended
    is a star, and what is asked for is dashed. An error below its interval is drawn at the end of the interval, as an arrow that
    points down. The scene as it is has a ring. named: whether settings have their names beside them, and axes more ticks."""
    shown = [row for row in found.rows if math.isfinite(row.error)]
    kinds = {
        "bars of other lengths": (networks := [row for row in found.networks() if row in shown]),
        "other steps": [row for row in shown if row.setting.step],
        "slack balance": [row for row in shown if row.setting.balanced],
        "not graded": [row for row in shown if row.setting.is_network() and row not in networks],
    }
    high = lambda row: abs(row.error) if row.interval.low * row.interval.high > 0.0 else row.bound()
    for number, (label, rows) in enumerate(kinds.items()):
        seen = [row for row in rows if row.interval.low * row.interval.high > 0.0]
        hidden = [row for row in rows if row not in seen and math.isfinite(row.bound()) and row.bound() > 0.0]
        line = [(row.seconds, high(row)) for row in rows if row in seen or row in hidden] if number == 0 else []
        axis.plot([x for x, _ in line], [y for _, y in line], color=COLOURS[number], linewidth=0.7)
        for row in seen:
            axis.plot([row.seconds] * 2, sorted(abs(end) for end in row.interval), color=COLOURS[number], linewidth=1)
        for some, marker, words in ((seen, "o", label), (hidden, "v", f"{label}: below this")):
            style = {"color": COLOURS[number], "fillstyle": "full" if some is seen else "none", "label": words if some else None}
            axis.plot([row.seconds for row in some], [high(row) for row in some], marker, **style)
        for row in (*seen, *hidden) if named else ():
            place = {"xytext": (5, 4), "textcoords": "offset points", "fontsize": 8, "color": "#464646"}
            axis.annotate(row.name(), (row.seconds, high(row)), **place)
    for one in found.choices:
        axis.axhline(one.error, color="#969696", linestyle="--", linewidth=1)
        if one.row and math.isfinite(one.row.bound()):
            axis.plot(one.row.seconds, max(high(one.row), 1e-9), "*", color="black", markersize=11, zorder=3)
    own = [row for row in networks if row.setting.bars == 1.0 and math.isfinite(row.bound())]
    ring = {"color": "black", "fillstyle": "none", "markersize": 11, "label": "bars of the scene"}
    axis.plot([row.seconds for row in own], [high(row) for row in own], "o", **ring)
    axis.plot([], [], "*", color="black", markersize=9, label="recommended")
    finest = next((row for row in found.rows if not math.isfinite(row.error)), None)
    if finest:
        axis.axvline(finest.seconds, color="#969696", linestyle=":", linewidth=1, label=f"finest: {finest.name()}")
    axis.set(xscale="log", yscale="log")
    for side in (axis.xaxis, axis.yaxis):
        side.set_major_locator(matplotlib.ticker.LogLocator(subs=(1.0, 2.0, 5.0) if named else (1.0,)))
        side.set_minor_locator(matplotlib.ticker.NullLocator())
        side.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda value, _: f"{value:g}"))


@styled
def map(table: "pandas.DataFrame", path: Place | None = None, about: Sequence[str] = ()) -> Figure:
    """A table of `fragment_map`: for each impact point the probability of perforation with its interval, and the kinetic energy
    that is left, over velocity and attitude. `about`: lines that say what was shot at."""
    points = list(dict.fromkeys(zip(table["point_x"], table["point_y"])))
    attitudes, velocities = list(dict.fromkeys(table["attitude"])), sorted(set(table["velocity"]))
    size = (max(1.6 + 0.78 * len(velocities) * len(points), 5.6), 1.6 + 1.0 * len(attitudes) + (1.3 if about else 0.0))
    figure, panels = new(*size, columns=len(points), rows=2, squeeze=False)
    most = table["residual_kinetic"].max()
    for column, (x, y) in enumerate(points):
        here = table[(table["point_x"] == x) & (table["point_y"] == y)]
        cells = {(row.attitude, row.velocity): row for row in here.itertuples()}
        for panel, name, top in ((panels[0][column], "perforation", 1.0), (panels[1][column], "residual_kinetic", most)):
            numbers = [[getattr(cells[a, v], name) for v in velocities] for a in attitudes]
            image = panel.imshow(numbers, vmin=0.0, vmax=top, cmap="YlOrRd", aspect="auto", origin="lower")
            for (i, attitude), (j, velocity) in itertools.product(enumerate(attitudes), enumerate(velocities)):
                cell = cells[attitude, velocity]
                if name == "perforation":
                    text = f"{cell.through}/{cell.shots}\n{100 * cell.low:.0f} to {100 * cell.high:.0f} %"
                else:
                    text = f"{cell.residual_kinetic:.3g} J" if cell.through else "none"
                dark = (numbers[i][j] or 0.0) > 0.6 * top
                panel.text(j, i, text, ha="center", va="center", fontsize=8, color="white" if dark else "black")
            panel.set_xticks(range(len(velocities)), [f"{v:g}" for v in velocities])
            panel.set_yticks(range(len(attitudes)), attitudes)
            panel.set_xlabel("velocity (m/s)")
            panel.set_title(f"at ({1e3 * x:g}, {1e3 * y:g}) mm", fontsize=9)
            label = "share through (1)" if name == "perforation" else "mean energy left (J)"
            if column == len(points) - 1:
                figure.colorbar(image, ax=panel, label=label)
    if about:
        width = int(14.0 * size[0])
        figure.suptitle("\n".join(part for line in about for part in textwrap.wrap(line, width)), fontsize=7)
    return saved(figure, path)
