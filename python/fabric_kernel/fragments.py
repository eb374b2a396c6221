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


def draw_map(table: "pandas.DataFrame", path: str | os.PathLike[str] | None = None, about: Sequence[str] = ()) -> "matplotlib.figure.Figure":
    """Draws a table of `fragment_map`: `plot.map`."""
    from . import plot

    return plot.map(table, path, about)


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
