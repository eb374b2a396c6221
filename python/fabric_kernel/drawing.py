"""The style of all plots, and plots of plain points."""

import io
import math
import pathlib
import textwrap
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import matplotlib
import matplotlib.patches
import matplotlib.ticker
from matplotlib.figure import Figure

from .files import Place, written

# Colours that differ for colour-blind eyes too (Okabe and Ito), and more for crowded plots.
COLOURS = "#0072b2 #d55e00 #009e73 #cc79a7 #e69f00 #56b4e9 #464646 #823ca0 #785028 #96aa3c #000000".split()
STYLES: dict[str, dict[str, Any]] = {
    "line": {},
    "marked": {"marker": "o", "markersize": 5},
    "dashed": {"linestyle": (0, (5, 3))},
    "points": {"marker": "o", "linestyle": "none", "markersize": 5},
    "dots": {"marker": ".", "linestyle": "none", "markersize": 2, "alpha": 0.5},
}
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "fabric",
    "svg.fonttype": "none",
    "text.parse_math": False,
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 10,
    "axes.titlesize": 12,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.8,
    "axes.edgecolor": "#888888",
    "legend.frameon": False,
    "lines.linewidth": 1.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
Drawing = TypeVar("Drawing", bound=Callable[..., Any])


def styled(draws: Drawing) -> Drawing:
    """Decorates what draws in this style."""
    return matplotlib.rc_context(STYLE)(draws)


class Series(NamedTuple):
    """Points with a name for the legend. bars: lower and upper end of y at each point."""

    name: str
    points: list[Any]
    style: str = "marked"
    bars: list[Any] | None = None


def new(width: float = 5.6, height: float = 3.7, columns: int = 1, rows: int = 1, **more: Any) -> Any:
    """A figure with its panels; inches. In the default width letters can be read on a telephone."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(rows, columns, **more)


@styled
def save(figure: Figure, path: Place, **options: Any) -> None:
    """Writes a figure, whole or not at all."""
    path, picture = pathlib.Path(path), io.BytesIO()
    metadata = {"Date": None, "Creator": None} if path.suffix == ".svg" else None
    options = {"dpi": 110, "bbox_inches": "tight", "pad_inches": 0.15, **options}
    figure.savefig(picture, format=path.suffix.lstrip(".") or "png", metadata=metadata, **options)
    written(path, picture.getvalue())


def saved(figure: Figure, path: Place | None, **options: Any) -> Any:
    """The figure, written if there is a path."""
    if path is not None:
        save(figure, path, **options)
    return figure


@styled
def draw(path: Place, title: str, x: Any, y: Any, series: Any, axes: str = "linear", marks: Any = (), levels: Any = ()) -> None:
    """Writes one plot. axes: "linear"; "from zero" (y from 0); "logarithmic x" (a tick at every point of the first series, y from
    0); "logarithmic" (points that are not positive are left out). marks: (x, name) of events; levels: (name, y) of dashed
    lines."""
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
    axis.set(xlabel=x, ylabel=y)
    figure.suptitle("\n".join(textwrap.wrap(title, 56)), fontsize=11)
    if len(series) + len(levels) > 1:
        below(figure, axis)
    save(figure, path)


def below(figure: Figure, *panels: Any) -> None:
    """One legend of these panels below the plot, in as many columns as there is room for; the figure grows by its height."""
    handles = {label: handle for panel in panels for handle, label in zip(*panel.get_legend_handles_labels())}
    labels = list(handles)
    columns = max(1, min(3, int(72 * figure.get_figwidth() / (36 + 4.8 * max(len(label) for label in labels)))))
    figure.set_figheight(figure.get_figheight() + 0.19 * math.ceil(len(labels) / columns))
    figure.legend(list(handles.values()), labels, loc="outside lower center", ncols=columns, fontsize=9)
