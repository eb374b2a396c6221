"""Ensembles: many runs, on the cores of this machine or on a Dask cluster, kept as they come.

A run is a function of its scene alone, to the bit, so the table does not depend on the order of the runs, on the number or the
kind of workers, or on how often the ensemble was killed and resumed.
"""

import collections
import functools
import hashlib
import json
import logging
import math
import multiprocessing
import numbers
import os
import platform
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, TypedDict

import numpy
from tqdm.auto import tqdm

from . import _kernel, checks
from ._kernel import Scene
from .files import Place, naming
from .notes import Note, warn
from .runs import STEPS, UNTIL, doubts, flown, named, scene_of, with_attrs
from .textile import spacings

if TYPE_CHECKING:
    import distributed
    import pandas

Workers: TypeAlias = "int | str | distributed.Client | distributed.deploy.Cluster | None"
"""Number of processes, or Dask scheduler."""


class Frozen(Protocol):
    """Frozen distribution of scipy.stats."""

    def rvs(self, *, random_state: numpy.random.Generator) -> float: ...


Distribution: TypeAlias = float | Sequence[object] | Frozen | None
"""A number, a sequence of which each element is equally likely, or a frozen distribution of scipy.stats."""


class Options(TypedDict, total=False):
    """Keyword arguments of `ensemble`."""

    keep: Place | None
    on: Workers
    until: Sequence[str] | str
    steps: int
    batch: int
    progress: bool | None


PATIENCE = 3
"""So many times in a row a worker may die before a run has come to its end."""
MOST_KEPT = 2**32
"""Bytes of a file of kept results, some four million."""
LONGEST_LINE = 2**16
"""Bytes of one of its lines, most of which have some 1000."""
LOG = logging.getLogger("fabric_kernel")
BUILD = hashlib.sha256(Path(_kernel.__file__).read_bytes()).hexdigest()
"""What tells one build of the kernel from another: their bits may differ, whatever their version says."""


class ClusterLost(RuntimeError):
    """The cluster or the local workers are gone. What was kept is not lost: the same call goes on from there."""


def ensemble(
    scenes: Iterable[Scene | str],
    *,
    keep: Place | None = None,
    on: Workers = None,
    until: Sequence[str] | str = UNTIL,
    steps: int = STEPS,
    batch: int = 1,
    progress: bool | None = None,
) -> "pandas.DataFrame":
    """Runs every scene, and returns a table in their order.

    A row has the `key` of its run, the parameters in which the scenes differ, and the fields of `Flight`. It warns
    (`ModelWarning`) where results are in doubt, or where runs of different scenes are equal.

    Parameters
    ----------
    scenes : iterable of Scene or str
        Scenes, or names of presets or scene files.
    keep : path, optional
        File that receives each result as it comes, a line of JSON each. What is in it is not run again. A result belongs to a
        scene, `until`, `steps` and one build of the package.
    on : int, str, Client or Cluster, optional
        Number of processes, or Dask scheduler; default: a process for each core.
    until : str or sequence of str
        Outcomes that end a run.
    steps : int
        Most steps of a run.
    batch : int
        Runs that a worker gets at a time; a task should take a second or so on a large cluster.
    progress : bool, optional
        Whether to show a progress bar; default: on a terminal; elsewhere a line of the log each half minute.

    Raises
    ------
    Refused
        A scene cannot be simulated; `field` names what is wrong.
    ClusterLost
        The workers are gone; what was kept is not lost.
    """
    if isinstance(scenes, (Scene, str)):
        raise TypeError("scenes: must be a list of scenes; of one scene it is [scene]")
    if batch < 1:
        raise ValueError(f"batch: must be at least 1; it is {batch}")
    every, until = [scene_of(one) for one in scenes], named(until)
    keys = [run_key(scene, until, steps) for scene in every]
    work = functools.partial(_fly, until=until, steps=steps)
    rows = each(work, dict(zip(keys, every)), keep=keep, on=on, batch=batch, progress=progress)
    different = dict(zip(keys, every))
    warn(doubts(list(different.values()), [rows[key] for key in different]) + _repeats(list(rows.values())))
    return _table(keys, every, rows)


def each(
    work: Callable[[Any], Any],
    jobs: Mapping[str, Any],
    *,
    keep: Place | None = None,
    on: Workers = None,
    batch: int = 1,
    progress: bool | None = None,
    name: str | None = None,
) -> dict[str, Any]:
    """Does any work as `ensemble` flies scenes: what `work`, a function of a module, gives for each job, by the key of the job.

    A result is what JSON makes of it, in a line of at most LONGEST_LINE bytes. What `keep` has under a key is not done again, so
    a key names everything that its result depends on (BUILD, too). `name`: of the progress bar; for the rest see `ensemble`.
    """
    rows: dict[str, Any] = {}
    if keep is not None:
        rows = {key: row for key, row in kept(Path(keep)) if key in jobs}
    left = [(key, job) for key, job in jobs.items() if key not in rows]
    tasks = [left[first : first + batch] for first in range(0, len(left), batch)]
    hidden, told = None if progress is None else not progress, time.monotonic()
    lines = progress is None and not sys.stderr.isatty()
    with tqdm(total=len(jobs), initial=len(rows), unit="run", desc=name, disable=hidden) as bar:
        try:
            for results in _results(functools.partial(_work, BUILD, work), tasks, on):
                if keep is not None:
                    append(Path(keep), results)
                rows.update((key, json.loads(line)) for key, line in results)
                bar.update(len(results))
                if lines and time.monotonic() - told > 30.0:
                    told = time.monotonic()
                    LOG.info("%s: %d of %d", name or "runs", len(rows), len(jobs))
        except ClusterLost as lost:
            where = f"; they are in {keep}: the same call goes on from there" if keep is not None else ""
            raise ClusterLost(f"{lost} after {len(rows)} of {len(jobs)} runs{where}") from lost.__cause__
    return rows


def run_key(scene: Scene, until: Sequence[str] | str = UNTIL, steps: int = STEPS) -> str:
    """Names a run: equal keys mean equal results."""
    everything = json.dumps([BUILD, sorted(named(until)), steps, scene.to_dict()], sort_keys=True)
    return hashlib.sha256(everything.encode()).hexdigest()[:32]


def _work(build: str, work: Callable[[Any], Any], task: list[tuple[str, Any]]) -> list[tuple[str, str]]:
    """What a worker does: key and line of each job. Lines, because the file and the table then have the same numbers."""
    if build != BUILD:
        raise RuntimeError(_other_build(f"the worker on {platform.node()}", BUILD, build))
    return [(key, json.dumps(work(job))) for key, job in task]


def _fly(scene: Scene, until: Sequence[str], steps: int) -> dict[str, Any]:
    try:
        return flown(scene, until, steps)
    except ValueError as refused:
        refused.add_note(f"the scene: {scene!r}")
        raise


def _other_build(worker: str, its: str, own: str) -> str:
    return (
        f"{worker} has another build of fabric_kernel: its library is {its[:16]}, that of the caller {own[:16]} (starts of "
        f"SHA-256)"
    )


def cores() -> int:
    """Cores that this process may use."""
    count = os.process_cpu_count() if hasattr(os, "process_cpu_count") else len(os.sched_getaffinity(0))
    return count or 1


def _build() -> str:
    return BUILD


def _results(work: Any, tasks: list[list[Any]], on: Any) -> Iterator[list[tuple[str, str]]]:
    """The results of the tasks, as they come."""
    if not tasks:
        return iter(())
    if on is None or isinstance(on, int):
        return _locally(work, tasks, on or cores())
    return _on_cluster(work, tasks, on)


def _locally(work: Any, tasks: list[list[Any]], workers: int) -> Iterator[list[tuple[str, str]]]:
    """In processes of this machine. If one of them dies all are replaced, and what had not come is run again."""
    waiting, losses = dict(enumerate(tasks)), 0
    while waiting:
        pool = ProcessPoolExecutor(min(workers, len(waiting)), initializer=_begin)
        try:
            futures = {pool.submit(work, task): number for number, task in waiting.items()}
            for future in as_completed(futures):
                result = future.result()
                del waiting[futures[future]]
                losses = 0
                yield result
        except BrokenProcessPool as broken:
            losses += 1
            if losses > PATIENCE:
                raise ClusterLost(f"a local worker died {losses} times in a row, the last time") from broken
        finally:
            pool.shutdown(cancel_futures=True)


def _begin() -> None:
    """A worker's start. Ctrl-C is for the caller; a worker that it reaches too ends without a word, and so does one whose parent
    is gone."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    parent: Any = multiprocessing.parent_process()
    threading.Thread(target=lambda: (parent.join(), os._exit(1)), daemon=True).start()


def _on_cluster(work: Any, tasks: list[list[Any]], on: Any) -> Iterator[list[tuple[str, str]]]:
    """On a Dask cluster, which gives the tasks of a worker that dies to the others. A worker with another build is refused: those
    that are there by their address before the first task, later ones by their first task."""
    from .extras import distributed

    mine = not isinstance(on, distributed.Client)
    try:
        client = distributed.Client(on) if mine else on
    except OSError as error:
        raise ClusterLost(f"there is no scheduler at {on}") from error
    try:
        for worker, build in client.run(_build, on_error="return").items():
            if isinstance(build, Exception) and not isinstance(build, OSError):
                raise RuntimeError(f"the worker {worker} cannot use this fabric_kernel: {build!r}") from build
            if isinstance(build, str) and build != BUILD:
                raise RuntimeError(_other_build(f"the worker {worker}", build, BUILD))
        futures = [client.submit(work, task, pure=False) for task in tasks]
        for future in distributed.as_completed(futures):
            yield future.result()
            future.release()
    except (distributed.CancelledError, distributed.comm.CommClosedError) as error:
        raise ClusterLost(f"the scheduler {on} is lost") from error
    except distributed.KilledWorker as error:
        raise ClusterLost(f"{error.allowed_failures + 1} workers died in the same run") from error
    finally:
        if mine:
            client.close()


def kept(path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Results of a file. A line that was cut off when its writer was killed is removed.

    Raises ValueError for what is no such file, or larger than MOST_KEPT.
    """
    if not path.exists():
        return
    if not path.is_file():
        raise ValueError(f"{path}: is not a file")
    size = path.stat().st_size
    if size > MOST_KEPT:
        raise ValueError(f"{path}: has {size} bytes, and kept results may have {MOST_KEPT}; keep the others in another file")
    with path.open("rb+") as file:
        whole, number = 0, 0
        while line := file.readline(LONGEST_LINE):
            number += 1
            if not line.endswith(b"\n") and whole + len(line) == size and line[:9] == b'{"key": "'[: len(line)]:
                file.truncate(whole)
                return
            whole += len(line)
            try:
                one = json.loads(line)
                yield one["key"], one["row"]
            except (ValueError, TypeError, KeyError):
                raise ValueError(f"{path}: line {number} is not a result of an ensemble") from None


def append(path: Path, results: list[tuple[str, str]]) -> None:
    """Adds results to a file, each in one line, at once. Raises OSError with the path, as where the disk is full: what the file
    had before is not lost."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with naming(path), path.open("a") as file:
        file.write("".join(f'{{"key": "{key}", "row": {line}}}\n' for key, line in results))


def _repeats(rows: Sequence[Mapping[str, Any]]) -> list[Note]:
    """Says how many results of different scenes are equal. The digest differs with the scene, so it does not count; runs without
    contact may well be alike."""
    touched = [row for row in rows if row["absorbed"]]
    counts = collections.Counter(json.dumps({name: row[name] for name in row if name != "digest"}) for row in touched)
    alike = sum(count for count in counts.values() if count > 1)
    if not alike:
        return []
    text = (
        f"{alike} of {len(rows)} runs have the result of another run, to the bit: what their scenes differ by changes nothing. "
        "The seed changes nothing where yarn is not sampled (yarn.stochastic and yarn.strength_draw); vary something else, "
        "such as the impact point (`vary`)."
    )
    return [Note(text, "equal_runs", {"runs": alike, "of": len(rows)})]


def _table(keys: list[str], scenes: Sequence[Scene], rows: Mapping[str, dict[str, Any]]) -> "pandas.DataFrame":
    """The table: keys, the parameters that differ, and the results."""
    from .extras import pandas  # Half a second, which workers need not spend.

    values = [_flat(scene.to_dict()) for scene in scenes]
    names = {name: None for one in values for name in one}
    differ = [name for name in names if len({json.dumps(one.get(name)) for one in values}) > 1]
    return with_attrs(
        pandas.DataFrame([{"key": key} | {name: one.get(name) for name in differ} | rows[key] for key, one in zip(keys, values)])
    )


def _flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """Every number by its name, with its index if it is one of several."""
    flat: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, tuple):
            flat |= _flat({f"{name}[{k}]": element for k, element in enumerate(value)})
        else:
            flat[name] = value
    return flat


def vary(
    base: Scene | str,
    count: int,
    *,
    seed: int,
    speed: Distribution = None,
    point: tuple[Distribution, Distribution] | None = None,
    attitude: str | Sequence[float] | None = None,
    tilt: Distribution = None,
    parameters: Mapping[str, Distribution] | None = None,
) -> list[Scene]:
    """Scenes that differ from a scene by what is sampled for each; always by the seed of the yarn.

    A distribution is a number, a sequence of which each element is equally likely, or a frozen distribution of scipy.stats:
    `(40, 60)` is 40 or 60; `scipy.stats.uniform(40, 60)` is the range from 40 to 100. The samples of scene k depend on `seed` and
    k alone. With a point, an attitude or a tilt the projectile is placed against the sheet (`Scene.aimed`).

    Parameters
    ----------
    base : Scene or str
        Scene, or the name of a preset or a scene file.
    count : int
        Number of scenes.
    seed : int
        Seed of the samples.
    speed : distribution, optional
        Speed in the direction that the projectile has, m/s.
    point : pair of distributions, optional
        Point where its centre meets the plane of the sheet, m from the middle along x and y.
    attitude : str or (4,) sequence of float, optional
        "random": every orientation is equally likely; or a unit quaternion, scalar first.
    tilt : distribution, optional
        Angle, rad, by which the body is turned about an axis across its velocity, all of which are equally likely.
    parameters : mapping, optional
        Distributions of other parameters by their names.

    Raises
    ------
    ValueError
        An argument is wrong; the message begins with its name.
    Refused
        The scene cannot be simulated.
    """
    base = scene_of(base)
    checks.whole("count", count, 0)
    checks.whole("seed", seed, 0)
    for name, given, other in (("speed", speed, "velocity"), ("attitude", attitude, "orientation"), ("point", point, "position")):
        if given is not None and f"projectile.{other}" in (parameters or {}):
            checks.refuse(name, f"left out beside projectile.{other} among the parameters, of which it is a part", given)
    point, attitude, parameters = checks.listed(point), checks.listed(attitude), parameters or {}
    return [_drawn(base, numpy.random.default_rng([seed, k]), speed, point, attitude, tilt, parameters) for k in range(count)]


def within_mesh(scene: Scene, point: Sequence[float]) -> tuple[Distribution, Distribution]:
    """A `point` of `vary` anywhere within one mesh of the network about this one, m."""
    import scipy.stats

    return tuple(scipy.stats.uniform(middle - 0.5 * h, h) for middle, h in zip(point, spacings(scene)))


def _draw(name: str, distribution: Any, random: numpy.random.Generator, words: bool = False) -> Any:
    """A draw, which is a finite number; of a parameter, whose `words` the scene checks, anything that is no infinite one."""
    drawn = distribution
    if hasattr(distribution, "rvs"):
        drawn = float(distribution.rvs(random_state=random))
    elif not isinstance(distribution, (str, bytes)) and hasattr(distribution, "__len__"):
        drawn = distribution[int(random.integers(len(distribution)))] if len(distribution) else None
    number = isinstance(drawn, numbers.Real)
    if drawn is None or (number and not math.isfinite(drawn)) or (not number and not words):
        checks.refuse(
            name,
            "a finite number, a sequence of such, or a frozen distribution whose samples are finite",
            f"{distribution!r}, which gave {drawn!r}",
        )
    return drawn


def _drawn(
    base: Scene,
    random: numpy.random.Generator,
    speed: Distribution,
    point: tuple[Distribution, Distribution] | None,
    attitude: str | Sequence[float] | None,
    tilt: Distribution,
    parameters: Mapping[str, Distribution],
) -> Scene:
    changes: dict[str, Any] = {"seed": int(random.integers(2**53))}
    changes |= {name: _draw(name, parameters[name], random, words=True) for name in sorted(parameters)}
    scene = base.replace(changes)
    velocity = scene["projectile.velocity"]
    if speed is not None:
        velocity = scaled(velocity, _draw("speed", speed, random))
    if point is None and attitude is None and tilt is None:
        return scene.replace({"projectile.velocity": velocity})
    orientation = scene["projectile.orientation"]
    if isinstance(attitude, str):
        if attitude != "random":
            raise ValueError(f'attitude: must be "random" or a unit quaternion; it is "{attitude}"')
        four = random.standard_normal(4)
        orientation = tuple(float(x) for x in four / numpy.sqrt((four * four).sum()))
    elif attitude is not None:
        orientation = tuple(attitude)
    if tilt is not None:
        orientation = _turned(orientation, velocity, _draw("tilt", tilt, random), random.uniform(0.0, 2.0 * math.pi))
    place = tuple(_draw("point", along, random) for along in point) if point is not None else (0.0, 0.0)
    return scene.aimed(place, velocity=velocity, orientation=orientation)


def scaled(velocity: Sequence[float], speed: float) -> tuple[float, ...]:
    """A velocity of this size."""
    if not speed > 0.0:
        raise ValueError(f"speed: must be greater than 0; it is {speed:g}")
    length = math.hypot(*velocity)
    if length == 0.0:
        raise ValueError("speed: the projectile of the scene has no velocity, so no direction")
    return tuple(speed * (part / length) for part in velocity)


def _turned(orientation: Sequence[float], velocity: Sequence[float], angle: float, azimuth: float) -> tuple[float, ...]:
    """An orientation turned by an angle about the axis across the velocity that the azimuth tells."""
    v = numpy.asarray(velocity) / math.hypot(*velocity)
    across = numpy.cross(v, numpy.eye(3)[int(numpy.abs(v).argmin())])
    across /= math.hypot(*across)
    axis = math.cos(azimuth) * across + math.sin(azimuth) * numpy.cross(v, across)
    w, u = math.cos(0.5 * angle), math.sin(0.5 * angle) * axis
    own_w, own_u = orientation[0], numpy.asarray(orientation[1:])
    turned = w * own_u + own_w * u + numpy.cross(u, own_u)
    return (float(w * own_w - u @ own_u), *(float(x) for x in turned))
