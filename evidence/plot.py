"""Plots as SVG, all in one style. The same numbers give the same bytes."""

from typing import NamedTuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.patches
import matplotlib.pyplot
import matplotlib.ticker

# Colours that differ for colour-blind eyes too (Okabe and Ito), and more for crowded plots.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#464646", "#823ca0", "#785028", "#96aa3c", "#000000"]
STYLES = {
    "line": {},
    "marked": {"marker": "o", "markersize": 5},
    "dashed": {"linestyle": (0, (5, 3))},
    "points": {"marker": "o", "linestyle": "none", "markersize": 5},
    "dots": {"marker": ".", "linestyle": "none", "markersize": 2, "alpha": 0.5},
}
matplotlib.rcParams.update({
    "svg.hashsalt": "fabric", "svg.fonttype": "none", "font.sans-serif": ["DejaVu Sans"], "font.size": 10, "axes.titlesize": 12, "axes.grid": True, "axes.axisbelow": True,
    "grid.color": "#e3e3e3", "grid.linewidth": 0.8, "axes.edgecolor": "#888888", "legend.frameon": False, "lines.linewidth": 1.7,
    "axes.spines.top": False, "axes.spines.right": False,
})


class Series(NamedTuple):
    """Points with a name for the legend. bars: lower and upper end of y at each point."""

    name: str
    points: list
    style: str = "marked"
    bars: list = None


def new(width=9.8, height=5.6, columns=1):
    return matplotlib.pyplot.subplots(1, columns, figsize=(width, height), layout="constrained")


def save(figure, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    metadata = {"Date": None, "Creator": None} if path.suffix == ".svg" else None
    figure.savefig(path, metadata=metadata, dpi=110, bbox_inches="tight", pad_inches=0.15)
    matplotlib.pyplot.close(figure)


def draw(path, title, x, y, series, axes="linear", marks=(), levels=()):
    """Writes one plot. axes: "linear"; "from zero" (y from 0); "logarithmic x" (a tick at every point of the first series, y from
    0); "logarithmic" (points that are not positive are left out). marks: (x, name) of events; levels: (name, y) of dashed lines."""
    figure, axis = new()
    for number, line in enumerate(series):
        points = [point for point in line.points if axes != "logarithmic" or (point[0] > 0 and point[1] > 0)]
        colour, style = COLOURS[number % len(COLOURS)], STYLES[line.style]
        axis.plot([p[0] for p in points], [p[1] for p in points], color=colour, label=line.name, **style)
        for (px, py), (low, high) in zip(line.points, line.bars or []):
            if low > float("-inf") and high < float("inf"):
                axis.errorbar(px, py, [[py - low], [high - py]], color=colour, capsize=3, linewidth=1)
    for number, (name, level) in enumerate(levels, len(series)):
        axis.axhline(level, color=COLOURS[number % len(COLOURS)], label=name, **STYLES["dashed"])
    if axes == "logarithmic":
        axis.set(xscale="log", yscale="log")
    elif axes == "logarithmic x":
        axis.set_xscale("log")
        axis.xaxis.set_major_locator(matplotlib.ticker.FixedLocator([point[0] for point in series[0].points]))
        axis.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
        axis.xaxis.set_major_formatter("{x:g}")
    if axes in ("from zero", "logarithmic x"):
        axis.set_ylim(bottom=min(0, axis.dataLim.y0))
    for at, name in marks:
        axis.axvline(at, color="#969696", linewidth=1, linestyle="--")
        axis.text(at, 0.99, name + " ", transform=axis.get_xaxis_transform(), ha="right", va="top", fontsize=8, color="#5a5a5a")
    axis.set(title=title, xlabel=x, ylabel=y)
    if len(series) + len(levels) > 1:
        # Beside the plot, where it hides nothing.
        axis.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
    save(figure, path)


def lines(rows, name, x, y):
    """A marked series for each name, in the order of the rows; name and x: keys or functions of a row."""
    of, found = lambda row, key: key(row) if callable(key) else row[key], {}
    for row in rows:
        found.setdefault(of(row, name), []).append((of(row, x), y(row)))
    return [Series(name, points) for name, points in found.items()]


def errors(path, title, x, y, lines, levels=()):
    """A logarithmic plot of marked lines and dashed levels; nothing if no line has a positive point."""
    lines = [line for line in lines if any(px > 0 and py > 0 for px, py in line.points)]
    if lines:
        draw(path, title, x, y, lines, "logarithmic", levels=levels)
