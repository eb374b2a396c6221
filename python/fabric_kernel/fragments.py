"""Fragment tables: how likely a fragment goes through a shield, by velocity, attitude and impact point, and what it keeps.

Each cell is a number of shots that differ by what a real shot does not control either: the draws of the yarn, and where within
one mesh of the network about the point the centre flies. A shot is one sample of a chaotic model; a cell states the interval that
its shots allow.
"""

import argparse
import functools
import itertools
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Unpack

import numpy

from . import checks, lookup, results, window
from ._kernel import Scene
from .about import CAVEAT, cautions, command, described, finished, of_a_scene, own_tests_of, positive
from .compared import model_error
from .ensembles import Options, ensemble, vary, within_mesh
from .family import OwnTests
from .files import Place, shown, titled, written
from .notes import ModelWarning, Note
from .page import Page
from .record import record
from .runs import DECIDED, UNTIL, scene_of, with_attrs, with_units
from .shots import share_within

if TYPE_CHECKING:
    import pandas


def bracket(
    shield: Scene,
    attitudes: Mapping[str, str | Sequence[float]],
    points: Sequence[tuple[float, float]] = ((0.0, 0.0),),
    *,
    count: int = 5,
    seed: int = 1,
    keep: Place | None = None,
    on: Any = None,
) -> list[float]:
    """Velocities for `fragment_map`, m/s, from 0.8 of the lowest to 1.25 of the highest limit of one shot at each attitude and
    point:
    slow shots are stopped and fast ones go through.

    The search begins with the velocity of the scene. Raises ValueError if no limit is found."""
    from .sensitivity import limits

    speed = math.hypot(*shield["projectile.velocity"])
    if not speed > 0.0:
        raise ValueError("projectile.velocity: must not be zero: it is the first velocity and the direction of the shots")
    shield.check()
    points, attitudes = list(points), {name: checks.listed(attitude) for name, attitude in attitudes.items()}
    for point in points:
        shield.aimed(point)
    jobs = [[shield, 0, seed, speed, attitude, None, tuple(point)] for attitude in attitudes.values() for point in points]
    found = [limit for limit, *_ in limits(jobs, keep=keep, on=on, name="bracket") if limit]
    if not found:
        raise ValueError(f"velocities: no limit was found near {speed:g} m/s, the velocity of the scene: give velocities")
    return [float(f"{velocity:.3g}") for velocity in numpy.geomspace(0.8 * min(found), 1.25 * max(found), count)]


def named(attitudes: Mapping[str, str | Sequence[float]]) -> None:
    """Raises ValueError for attitudes without a name, or with one that says something else."""
    for name, attitude in attitudes.items() or [("", None)]:
        if not isinstance(name, str) or not name.strip() or (name == "random" and not isinstance(attitude, str)):
            checks.refuse(
                "attitudes", 'one or more, by a name each; "random" is the name of every orientation', f"{name!r}: {attitude!r}"
            )


def fragment_map(
    shield: Scene | str,
    *,
    velocities: Sequence[float],
    attitudes: Mapping[str, str | Sequence[float]],
    points: Sequence[tuple[float, float]] = ((0.0, 0.0),),
    shots: int = 20,
    seed: int = 1,
    confidence: float = 0.95,
    **options: Unpack[Options],
) -> "pandas.DataFrame":
    """Shoots the projectile of a scene at its sheet over velocities, attitudes and impact points.

    Parameters
    ----------
    shield : Scene or str
        Scene, or the name of a preset or a scene file.
    velocities : sequence of float
        Velocities, m/s, in the direction that the projectile has.
    attitudes : mapping
        By a name each a unit quaternion, scalar first, or "random": every orientation is equally likely.
    points : sequence of pairs of float
        Points where the centre meets the plane of the sheet, m from the middle.
    shots : int
        Shots of each cell.
    seed : int
        Seed of yarns and impact points.
    confidence : float
        Confidence of the intervals.
    options : optional
        Options of `ensemble`; a shot ends when it is decided (`runs.DECIDED`) without `until`.

    Returns
    -------
    pandas.DataFrame
        A row for each cell: `velocity`, `attitude`, `point_x`, `point_y`; `shots`, of which `through`, `stopped`, `missed`
        (without contact) and `unknown`; `perforation`, the share of those known that went through, with its exact interval from
        `low` to `high` (an unknown end may have been either); means `residual_speed` (m/s), `residual_kinetic` (J) of those
        that went through, `absorbed` and `viscous` (J) of all known, each with its standard deviation, `..._sd`.

    Raises
    ------
    ValueError
        An argument is wrong; the message begins with its name.
    Refused
        The scene cannot be simulated.
    """

    from .extras import pandas

    shield = scene_of(shield)
    checks.whole("shots", shots, 1)
    checks.confident(confidence)
    velocities, points = checks.listed(velocities), list(points)
    checks.numbers("velocities", velocities)
    attitudes = {name: checks.listed(attitude) for name, attitude in attitudes.items()}
    named(attitudes)
    for twice in (*checks.twice("velocities", velocities), *checks.twice("points", list(map(tuple, points)))):
        warnings.warn(ModelWarning(twice, "given_twice"), stacklevel=2)
    velocities, points = list(dict.fromkeys(velocities)), list(dict.fromkeys((x, y) for x, y in points))
    for point in points:
        shield.aimed(point)
    cells = list(itertools.product(velocities, attitudes, points))
    scenes = []
    for number, (velocity, attitude, point) in enumerate(cells):
        cell_seed = seed * 1_000_003 + number
        scenes += vary(
            shield, shots, seed=cell_seed, speed=velocity, point=within_mesh(shield, point), attitude=attitudes[attitude]
        )
    options.setdefault("until", DECIDED)
    shot = ensemble(scenes, **options)
    rows = []
    for number, (velocity, attitude, (x, y)) in enumerate(cells):
        runs = shot.iloc[number * shots : (number + 1) * shots]
        known = runs[runs["stopped"].notna()]
        through = known[~known["stopped"].astype(bool)]
        missed = int((runs["outcome"] == "passed").sum())
        hits = shots - missed
        unknown = hits - len(known)
        least, most = share_within(len(through), unknown, hits, confidence)
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
    return with_attrs(pandas.DataFrame(rows))


def lines_of(table: "pandas.DataFrame") -> Any:
    """Lines of a map, one for each attitude and impact point: both, and velocity and result of each shot of known end."""
    for (attitude, x, y), cells in table.sort_values("velocity").groupby(["attitude", "point_x", "point_y"], sort=False):
        results = numpy.repeat(numpy.tile([True, False], len(cells)), cells[["through", "stopped"]].to_numpy().ravel())
        yield (attitude, (x, y)), numpy.repeat(cells["velocity"].to_numpy(), cells["through"] + cells["stopped"]), results


def below(
    table: "pandas.DataFrame", attitudes: Mapping[str, str | Sequence[float]], shot: Callable[..., "pandas.DataFrame"]
) -> "pandas.DataFrame":
    """A map of the ladder below the limit of each attitude and impact point of a map (`window.py`). shot: `fragment_map` with all
    but velocities, attitudes and points, one shot a rung."""
    from .extras import pandas

    rungs = [(of, window.ladder(velocities, results, 0.95)) for of, velocities, results in lines_of(table) if len(results)]
    return pandas.concat(
        [
            table.iloc[:0],
            *(
                shot(velocities=list(v), attitudes={name: attitudes[name]}, points=[point])
                for (name, point), v in rungs
                if len(v)
            ),
        ]
    )


def answer(table: "pandas.DataFrame", slower: "pandas.DataFrame | None" = None) -> list[str]:
    """A sentence for each attitude and impact point of a map: up to which velocity none goes through, and from which on all;
    before it another one if the shots, or those of a ladder below them (`below`), contradict a share that grows with the
    velocity."""
    found, ladders = [], {of: shots for of, *shots in lines_of(slower)} if slower is not None else {}
    for of, velocities, through in lines_of(table):
        attitude, (x, y) = of
        where = f"{attitude} at ({1e3 * x:g}, {1e3 * y:g}) mm:"
        if not len(through):
            found.append(f"{where} no shot has a known end.")
            continue
        rungs, passed = ladders.get(of, ((), ()))
        hole = window.window(velocities, through, rungs, passed)
        slow, fast = (
            velocities[velocities < velocities[through].min(initial=math.inf)],
            velocities[velocities > velocities[~through].max(initial=0.0)],
        )
        at = lambda velocity, what: (
            f"{int((through == what)[velocities == velocity].sum())} of {int((velocities == velocity).sum())}"
        )
        low = (
            f"none of {len(slow)} shots goes through up to {slow.max():g} m/s"
            if len(slow)
            else f"{at(velocities.min(), True)} go through at {velocities.min():g} m/s already"
        )
        high = (
            f"all {len(fast)} do from {fast.min():g} m/s on"
            if len(fast)
            else f"{at(velocities.max(), False)} are stopped at {velocities.max():g} m/s still"
        )
        looked = window.looked_at(rungs, passed, 0.95) if len(rungs) else ()
        if hole:
            found.append(Note(f"{where} {hole.sentence()}", window.NO_LIMIT, vars(hole)))
        found += [f"{where} {line}" for line in (f"{low}, {high}.", *(line for line in looked if line and not hole))]
    return found


@record
class Map:
    """What `fabric fragments` finds: rows of `fragment_map`, and of the ladder below the limits. `write` reports it."""

    title: Annotated[str, "title of reports"]
    answer: Annotated[tuple[str, ...], "a sentence for each attitude and point"]
    cells: Annotated[tuple[dict[str, Any], ...], "rows of `fragment_map`"]
    below: Annotated[tuple[dict[str, Any], ...], "rows of the ladder below the limits"]
    about: Annotated[tuple[str, ...], "what was shot"]
    shot_at: Annotated[tuple[str, ...], "sheet, projectile and version"]

    def write(self, folder: Place) -> None:
        """report.html (everything inside), map.svg and fragments.json."""
        from . import plot
        from .extras import pandas

        folder, table = Path(folder), pandas.DataFrame(self.cells)
        table = with_attrs(table.astype({name: float for name in table if table[name].isna().any()}))
        results.save(self, folder / "fragments.json")
        plot.map(table, folder / "map.svg", (*self.shot_at, CAVEAT))
        page = Page(self.title)
        page.answer(self.answer)
        page.figure(folder / "map.svg", "")
        page.fold("What was shot, and each cell")
        for line in (*self.about, *self.shot_at):
            page.text(line)
        cell = lambda value: f"{value:.4g}" if isinstance(value, float) else value
        page.table(tuple(with_units(table).columns), [[cell(one) for one in row] for row in table.itertuples(index=False)])
        written(folder / "report.html", page.html())


def _attitude(text: str) -> tuple[str, str | tuple[float, ...]]:
    """ "random", or NAME=W,X,Y,Z."""
    if text == "random":
        return text, text
    name, _, numbers = shown(text).partition("=")
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
    """The command `fabric fragments`."""
    what = "How likely the projectile of a scene goes through its sheet, by velocity, attitude and impact point."
    files = "report.html, table.csv, below.csv, fragments.json, map.svg, runs.jsonl; also bracket.jsonl, and table.h with --table"
    parser = of_a_scene("fragments", what, files)
    add = parser.add_argument
    add(
        "--velocities",
        type=positive,
        nargs="+",
        metavar="V",
        help="m/s; default: five about the limits, which are bracketed first",
    )
    add(
        "--attitudes",
        type=_attitude,
        nargs="+",
        default=[],
        metavar="NAME=W,X,Y,Z",
        help='unit quaternions with a name each, or "random"; default: that of the scene',
    )
    add("--points", type=_point, nargs="+", default=[(0.0, 0.0)], metavar="X,Y", help="m from the middle")
    add("--shots", type=int, default=20, help="of each cell")
    add("--to-the-end", action="store_true", help="go on after it is decided that a shot goes through, until it has exited")
    add(
        "--table",
        action="store_true",
        help=(
            "also write table.h, a table for a real-time host in C; its error is found by as many shots half way between the "
            "velocities"
        ),
    )
    add("--on", help="number of processes, or the address of a Dask scheduler")
    own_tests_of(parser)
    given = parser.parse_args(arguments)
    with command(parser, given) as (scene, fabric):
        own = OwnTests.read(given.tests) if given.tests else None
        checks.whole("shots", given.shots, 1)
        attitudes = dict(given.attitudes) or {"as given": scene["projectile.orientation"]}
        if len(attitudes) < len(given.attitudes):
            checks.refuse("--attitudes", "a name given once each", " ".join(name for name, _ in given.attitudes))
        named(attitudes)
        said_once = [*checks.twice("velocities", given.velocities or []), *checks.twice("points", given.points)]
        given.velocities, given.points = list(dict.fromkeys(given.velocities or [])), list(dict.fromkeys(given.points))
        on = int(given.on) if given.on and given.on.isdigit() else given.on
        velocities = given.velocities
        if given.table and velocities and len(set(velocities)) < 2:
            raise ValueError("--table: needs two velocities or more")
        if not velocities:
            velocities = bracket(scene, attitudes, given.points, seed=given.seed, keep=given.out / "bracket.jsonl", on=on)
            print(
                f"Velocities about the limits that were bracketed: {', '.join(f'{velocity:g}' for velocity in velocities)} m/s.",
                flush=True,
            )
        judged = [
            one
            for attitude in attitudes.values()
            for point in given.points
            for one in vary(scene, given.shots if attitude == "random" else 1, seed=given.seed, attitude=attitude, point=point)
        ]
        of = {"attitudes": attitudes, "points": given.points, "shots": given.shots}
        width, held, *others = cautions(scene)
        against, shot_at = [model_error(judged).sentence()], described(scene, fabric)
        against = [own.of_velocities(judged), *against] if own else against
        about = (*others, *said_once)
        print("\n".join([*against, width, held, *about, *shot_at]), flush=True)
        shot = functools.partial(
            fragment_map, scene, keep=given.out / "runs.jsonl", on=on, until=UNTIL if given.to_the_end else DECIDED
        )
        with warnings.catch_warnings(record=True) as doubts:
            warnings.simplefilter("always", ModelWarning)
            table = shot(velocities=velocities, seed=given.seed, **of)
        told = [doubt.message for doubt in doubts if doubt.category is ModelWarning]
        for doubt in told:
            warnings.warn(doubt, stacklevel=1)
        decisive = list(map(str, told))
        print(with_units(table).loc[:, :"high"].to_string(index=False))
        slower = below(table, attitudes, functools.partial(shot, shots=1, seed=given.seed + 2))
        lines = sorted(answer(table, slower), key=lambda line: not isinstance(line, Note))
        print(*lines, sep="\n", flush=True)
        written(given.out / "table.csv", with_units(table).to_csv(index=False))
        written(given.out / "below.csv", with_units(slower).to_csv(index=False))
        cells, rungs = (tuple(rows.to_dict("records")) for rows in (table, slower))
        given.answer = Map(
            f"Fragments of {titled(given.scene)}",
            (str(lines[0]), *decisive, *map(str, lines[1:]), *against, width, held),
            cells,
            rungs,
            about,
            shot_at,
        )
        given.answer.write(given.out)
        if given.table:
            said = lookup.error(
                table, shot(velocities=lookup.halfway(velocities), seed=given.seed + 1, **of), scene["projectile.mass"]
            )
            print(said)
            written(given.out / "table.h", lookup.c_header(table, "\n".join([*lines, *against, *about, *shot_at, said])))
        names = ["report.html", "table.csv", "below.csv", "fragments.json", "map.svg", "runs.jsonl"]
        finished(given, [*names, "table.h"] if given.table else names)
    if isinstance(lines[0], Note):
        parser.exit(window.STATUS)
