"""Plots in one style: histories, sheets, residual velocities, limits and maps. The same numbers give the same bytes.

Each returns a figure of matplotlib, and writes it if `path` is given (its ending says the kind: svg, png, pdf).
"""

import itertools
import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy
from matplotlib.figure import Figure

from . import sheets
from .drawing import COLOURS, below, new, saved, styled
from .files import Place
from .likelihood import LINKS

if TYPE_CHECKING:
    import pandas


@styled
def history(
    rows: "pandas.DataFrame", path: Place | None = None, *, title: str = "", marks: Sequence[tuple[float, str]] = ()
) -> Figure:
    """Rows of `fabric_kernel.history`: velocity of the projectile, force on it, largest deflection of held cloth, and where the
    absorbed energy is, over time. marks: time (s) and name of events."""
    figure, panels = new(8.5, 11.0, rows=4, sharex=True)
    energies = {
        "work": "absorbed",
        "fabric_kinetic": "fabric kinetic",
        "strain": "strain",
        "dissipated": "dissipated by rupture",
        "viscous": "dissipated by viscosity",
        "friction": "friction",
        "ply_loss": "lost where plies meet",
        "casing_loss": "lost on the case",
        "attachment": "dissipated in clamps",
        "contact_loss": "contact loss",
        "residual": "residual",
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


def limit(test: Any, path: Place | None = None) -> Figure:
    """The share that goes through over velocity, with a band that joins the intervals, and the residual velocities."""
    fit, law = test.fit, LINKS[test.fit.link]
    velocities = numpy.array([shot.velocity for shot in test.shots])
    stopped = numpy.array([shot.stopped for shot in test.shots])
    residuals = numpy.array([shot.residual for shot in test.shots])
    # A bracket may begin far away: what lies within a factor of two of V50 is drawn, if there is a V50.
    near = (velocities >= 0.5 * fit.mu) & (velocities <= 2.0 * fit.mu)
    drawn = velocities[near] if near.sum() > 1 else velocities
    margin = 0.15 * float(numpy.ptp(drawn)) or 0.1 * abs(float(drawn[0])) or 1.0
    left, right = max(0.0, float(drawn.min()) - margin), float(drawn.max()) + margin
    outside = f" ({len(velocities) - len(drawn)} shots lie outside)" if len(drawn) < len(velocities) else ""
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
    for panel, heights in ((upper, numpy.where(stopped, 0.0, 1.0)), (lower, residuals)):
        panel.plot(velocities[~stopped], heights[~stopped], "o", color="#d55e00", label="through")
        panel.plot(velocities[stopped], heights[stopped], "o", color="#464646", fillstyle="none", label="stopped")
        panel.grid(color="#e3e3e3")
        panel.set_axisbelow(True)
    if math.isfinite(test.residual.limit):
        grid = numpy.linspace(left, right, 400)
        lower.plot(grid, test.residual.curve(grid), color="#009e73", label="Lambert and Jonas")
    upper.set(xlim=(left, right), ylabel="share that goes through", title=test.title)
    lower.set_ylim(top=1.15 * max(float(residuals[(velocities >= left) & (velocities <= right)].max(initial=0.0)), 1.0))
    lower.set(xlabel=f"impact velocity (m/s){outside}", ylabel="residual velocity (m/s)")
    below(figure, upper, lower)
    return saved(figure, path)


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
