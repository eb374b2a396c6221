"""Fragment tables: how likely a fragment goes through a shield, by velocity, attitude and impact point, and what it keeps.

Each cell is a number of shots that differ by what a real shot does not control either: the draws of the yarn, and where within one
mesh of the network about the point the centre flies. A shot is one sample of a chaotic model; a cell states the interval that its
shots allow.
"""

import argparse
import io
import itertools
import os
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._kernel import Scene
from .about import SCENE_HELP, cautions, described, noted, positive, scene_named
from .ensembles import ensemble, vary
from .files import written
from .model_error import model_error
from .runs import DECIDED, UNTIL

if TYPE_CHECKING:
    import matplotlib.figure
    import pandas

CONFIDENCE = 0.95
"""Of the intervals, if nothing else is asked for."""


def fragment_map(
    shield: Scene,
    *,
    velocities: Sequence[float],
    attitudes: Mapping[str, str | Sequence[float]],
    points: Sequence[tuple[float, float]] = ((0.0, 0.0),),
    shots: int = 20,
    seed: int = 1,
    confidence: float = CONFIDENCE,
    **options: Any,
) -> "pandas.DataFrame":
    """Shoots the projectile of a scene at its sheet and returns a table with a row for each velocity, attitude and impact point.

    - `velocities`: m/s, in the direction that the projectile has in the scene;
    - `attitudes`: by a name each, a unit quaternion (scalar first), or "random": every orientation is equally likely;
    - `points`: where the centre meets the plane of the sheet, m from the middle;
    - `shots`: of each cell; other `options` are those of `ensemble` (`keep`, `on`, ...), but a shot ends when it is decided, at
      `runs.DECIDED`, if `until` does not say otherwise.

    Columns: `velocity`, `attitude`, `point_x`, `point_y`; `shots`, of which `through`, `stopped`, `missed` (passed without contact) and
    `unknown` (none of these came, or the computation failed); `perforation`, the share that went through of those known, with its
    interval from `low` to `high` (exact, Clopper and Pearson, of those not missed; a shot of unknown end may have ended either way);
    `residual_speed` (m/s) and `residual_kinetic` (J), the means of those that went through, and `absorbed` and `viscous` (J; what the
    viscosity of the yarn took of it), of all known, each with its standard deviation, `..._sd`.

    Raises Refused, with the name of the argument, for a point beside the sheet or an impossible attitude.
    """
    import pandas
    import scipy.stats

    if shots < 1:
        raise ValueError(f"shots: must be at least 1; it is {shots}")
    for point in points:
        shield.aimed(point)
    cells = list(itertools.product(velocities, attitudes, points))
    spacings = [shield["sheet.spacing"], shield["sheet.spacing_y"] or shield["sheet.spacing"]]
    scenes = []
    for number, (velocity, attitude, point) in enumerate(cells):
        about = tuple(scipy.stats.uniform(middle - 0.5 * h, h) for middle, h in zip(point, spacings))
        orientation = attitudes[attitude]
        cell_seed = seed * 1_000_003 + number
        scenes += vary(shield, shots, seed=cell_seed, speed=velocity, point=about, attitude=orientation)
    results = ensemble(scenes, **{"until": DECIDED} | options)
    rows = []
    for number, (velocity, attitude, (x, y)) in enumerate(cells):
        runs = results.iloc[number * shots : (number + 1) * shots]
        known = runs[runs["stopped"].notna()]
        through = known[~known["stopped"].astype(bool)]
        missed = int((runs["outcome"] == "passed").sum())
        hits = shots - missed
        unknown = hits - len(known)
        least, most = 0.0, 1.0
        if hits:
            least = scipy.stats.binomtest(len(through), hits).proportion_ci(confidence, method="exact").low
            most = scipy.stats.binomtest(len(through) + unknown, hits).proportion_ci(confidence, method="exact").high
        row = {"velocity": velocity, "attitude": attitude, "point_x": x, "point_y": y, "shots": shots}
        row |= {"through": len(through), "stopped": len(known) - len(through), "missed": missed, "unknown": unknown}
        row |= {"perforation": len(through) / len(known) if len(known) else None, "low": least, "high": most}
        for column, of, name in (
            ("speed", through, "residual_speed"),
            ("residual_kinetic", through, "residual_kinetic"),
            ("absorbed", known, "absorbed"),
            ("viscous", known, "viscous"),
        ):
            row |= {name: of[column].astype(float).mean(), f"{name}_sd": of[column].astype(float).std()}
        rows.append(row)
    return pandas.DataFrame(rows)


def draw_map(
    table: "pandas.DataFrame", path: str | os.PathLike[str] | None = None, about: Sequence[str] = ()
) -> "matplotlib.figure.Figure":
    """Draws a table of `fragment_map`: for each impact point the probability of perforation with its interval, and the kinetic
    energy that is left, over velocity and attitude. Writes it to `path` if one is given. `about`: lines that say what was shot at."""
    import matplotlib
    from matplotlib.figure import Figure

    points = list(dict.fromkeys(zip(table["point_x"], table["point_y"])))
    attitudes, velocities = list(dict.fromkeys(table["attitude"])), sorted(set(table["velocity"]))
    size = (max(1.6 + 1.15 * len(velocities) * len(points), 5.0), 2.2 + 1.3 * len(attitudes) + (1.2 if about else 0.0))
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(2, len(points), squeeze=False)
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
                    text = f"{cell.through}/{cell.shots}\n{cell.low:.2f} to {cell.high:.2f}"
                else:
                    text = f"{cell.residual_kinetic:.3g} J" if cell.through else "none"
                dark = (numbers[i][j] or 0.0) > 0.6 * top
                panel.text(j, i, text, ha="center", va="center", fontsize=8, color="white" if dark else "black")
            panel.set_xticks(range(len(velocities)), [f"{v:g}" for v in velocities])
            panel.set_yticks(range(len(attitudes)), attitudes)
            panel.set_xlabel("velocity, m/s")
            panel.set_title(f"at ({1e3 * x:g}, {1e3 * y:g}) mm", fontsize=9)
            label = "share through, and its interval" if name == "perforation" else "mean kinetic energy left, J"
            if column == len(points) - 1:
                figure.colorbar(image, ax=panel, label=label)
    if about:
        width = int(13.0 * size[0])
        figure.suptitle("\n".join(part for line in about for part in textwrap.wrap(line, width)), fontsize=7)
    if path is not None:
        picture, kind = io.BytesIO(), Path(path).suffix.lstrip(".") or "png"
        # The same table gives the same bytes.
        with matplotlib.rc_context({"svg.hashsalt": "fabric", "svg.fonttype": "none"}):
            figure.savefig(picture, format=kind, metadata={"Date": None} if kind == "svg" else None)
        written(path, picture.getvalue())
    return figure


def _attitude(text: str) -> tuple[str, str | tuple[float, ...]]:
    """ "random", or NAME=W,X,Y,Z."""
    if text == "random":
        return text, text
    name, _, numbers = text.partition("=")
    return name, _numbers(numbers, 4, text)


def _point(text: str) -> tuple[float, float]:
    x, y = _numbers(text, 2, text)
    return x, y


def _numbers(text: str, count: int, whole: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(number) for number in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != count:
        raise argparse.ArgumentTypeError(f"must have {count} numbers with commas between them; it is {whole}")
    return numbers


def main(arguments: Sequence[str] | None = None) -> None:
    """The command `fabric-fragments`."""
    parser = argparse.ArgumentParser(
        prog="fabric-fragments",
        description="How likely the projectile of a scene goes through its sheet, by velocity, attitude and impact point.",
    )
    parser.add_argument("scene", help=SCENE_HELP)
    parser.add_argument("--velocities", type=positive, nargs="+", required=True, metavar="V", help="m/s")
    parser.add_argument(
        "--attitudes", type=_attitude, nargs="+", default=[], metavar="NAME=W,X,Y,Z",
        help='unit quaternions with a name each, or "random"; default: that of the scene',
    )  # fmt: skip
    parser.add_argument("--points", type=_point, nargs="+", default=[(0.0, 0.0)], metavar="X,Y", help="m from the middle")
    parser.add_argument("--shots", type=int, default=20, help="of each cell")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--to-the-end", action="store_true", help="go on after it is decided that a shot goes through, until it has exited")
    parser.add_argument("--on", help="number of processes, or the address of a Dask scheduler")
    parser.add_argument("--out", type=Path, default=Path("fragments"), help="folder for table.csv, map.svg and runs.jsonl")
    given = parser.parse_args(arguments)
    try:
        scene, fabric = scene_named(given.scene)
        error = model_error(scene, CONFIDENCE).sentence()
        about = (error, *cautions(scene), *described(scene, fabric), *noted(scene, max(given.velocities)))
        print("\n".join(about))
        table = fragment_map(
            scene,
            velocities=given.velocities,
            attitudes=dict(given.attitudes) or {"as given": scene["projectile.orientation"]},
            points=given.points,
            shots=given.shots,
            seed=given.seed,
            keep=given.out / "runs.jsonl",
            until=UNTIL if given.to_the_end else DECIDED,
            on=int(given.on) if given.on and given.on.isdigit() else given.on,
        )
        print(table.to_string(index=False))
        written(given.out / "table.csv", table.to_csv(index=False))
        draw_map(table, given.out / "map.svg", about)
    except (ValueError, RuntimeError, OSError) as error:
        parser.exit(1, f"error: {error}\n")
    except KeyboardInterrupt:
        parser.exit(130, f"interrupted: what has ended is in {given.out / 'runs.jsonl'}, and the same command goes on from there\n")
    print(f"written to {given.out}: table.csv, map.svg, runs.jsonl")
