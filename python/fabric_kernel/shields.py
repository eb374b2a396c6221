"""Ballistic limits of several shields, each as `fabric v50` finds it, side by side on cores or on a Dask cluster.

A shield is a task; on this machine each of its shots is kept in a file, so that what was stopped continues.
"""

import dataclasses
import hashlib
import itertools
import json
import math
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import tqdm

from . import ensembles, network, results
from ._kernel import Scene
from .about import described, scene_hash
from .files import Place
from .record import record
from .sensitivity import nodes
from .shooter import Shooter, Unknown
from .v50 import LimitTest, v50

LADDER = 30
"""Shots beside a limit, of `window.shot_beside`, for the length of the progress bar."""


@record
class Tested:
    """Limit of a shield, and what it took."""

    test: Annotated[LimitTest, "result of `v50`"]
    node_steps: Annotated[float, "cost"]
    seconds: Annotated[float, "of the processor, for what was not kept"]


def limit_of(job: list[Any]) -> Any:
    """The limit of a shield, as JSON. job: scene, shots, seed, attitude, confidence, whether with the network's shift, file."""
    scene, shots, seed, attitude, confidence, shifted, keep = job
    start, shoot = time.process_time(), Shooter(scene, seed=seed, attitude=attitude, keep=keep)
    test = v50(shoot, shots=shots, confidence=confidence, about=described(scene), shifted=shifted)
    cost = float(sum(row["steps"] * nodes(one) for one, row in shoot.flown))
    return results.plain(Tested(test, cost, time.process_time() - start))


def shares_of(job: list[Any]) -> Any:
    """Whether each shot of a shield at one velocity goes through, None where not known; node-steps, seconds and warnings. job:
    scene, shots, seed, attitude, velocity, file of the shots."""
    scene, shots, seed, attitude, velocity, keep = job
    start, shoot = time.process_time(), Shooter(scene, seed=seed, attitude=attitude, keep=keep)
    through: list[bool | None] = []
    for shot in range(shots):
        try:
            through.append(not shoot(velocity, shot)[0])
        except Unknown:
            through.append(None)
    cost = float(sum(row["steps"] * nodes(one) for one, row in shoot.flown))
    return [through, cost, time.process_time() - start, results.plain(shoot.warnings())]


def done(
    work: Any,
    scenes: Mapping[str, Scene],
    options: Sequence[Any],
    shots: int,
    folder: Place | None,
    on: Any,
    progress: bool | None,
) -> list[Any]:
    """What `work` gives for each shield with these options; kept in the folder. shots: most of a shield, for the progress bar."""
    for name, scene in scenes.items():
        try:
            scene.check()
            if not math.hypot(*scene["projectile.velocity"]) > 0.0:
                raise ValueError("projectile.velocity: must not be zero: it is the first velocity and the direction of the shots")
        except ValueError as refused:
            raise ValueError(f"{name}: {refused}") from refused
    local, jobs, keys = on is None or isinstance(on, int), {}, {}
    # What takes longest goes first.
    for name, scene in sorted(scenes.items(), key=lambda one: -nodes(one[1])):
        everything = json.dumps([ensembles.BUILD, work.__name__, *options, scene.to_dict()], sort_keys=True)
        key = keys[name] = hashlib.sha256(everything.encode()).hexdigest()[:32]
        keep = Path(folder) / "shots" / f"{scene_hash(scene)}.jsonl" if folder is not None and local else None
        jobs[key] = [scene, *options, keep]
    if len(jobs) < len(scenes):
        one, other = next(pair for pair in itertools.combinations(scenes, 2) if keys[pair[0]] == keys[pair[1]])
        raise ValueError(f"{other}: is the same scene as {one}")
    kept = None if folder is None else Path(folder) / "runs.jsonl"
    if not local or folder is None:
        found = ensembles.each(work, jobs, keep=kept, on=on, progress=progress, name="shields")
    else:
        ended = threading.Event()
        with tqdm.tqdm(total=shots * len(jobs), unit="shot", disable=None if progress is None else not progress) as bar:

            def watch() -> None:
                said = time.monotonic()
                while not ended.wait(0.5):
                    made = sum(path.read_bytes().count(b"\n") for *_, path in jobs.values() if path.exists())
                    bar.update(min(made, bar.total) - bar.n)
                    if progress is None and not sys.stderr.isatty() and time.monotonic() - said > 30.0:
                        said = time.monotonic()
                        ensembles.LOG.info("%d of about %d shots", made, shots * len(jobs))

            watcher = threading.Thread(target=watch, daemon=True)
            watcher.start()
            try:
                found = ensembles.each(work, jobs, keep=kept, on=on, progress=False)
                bar.update(bar.total - bar.n)
            finally:
                ended.set()
                watcher.join()
    return [found[keys[name]] for name in scenes]


def limits(
    scenes: Mapping[str, Scene],
    *,
    shots: int = 20,
    seed: int = 1,
    attitude: str | None = None,
    confidence: float = 0.95,
    shifted: bool = True,
    folder: Place | None = None,
    on: Any = None,
    progress: bool | None = None,
) -> list[Tested]:
    """Limits of shields by their names, in their order. shifted: with the shift of the network."""
    most = shots + LADDER + shifted * network.SHOTS
    found = done(limit_of, scenes, [shots, seed, attitude, confidence, shifted], most, folder, on, progress)
    made = [results.restored(Tested, one) for one in found]
    return [
        dataclasses.replace(one, test=dataclasses.replace(one.test, title=f"Ballistic limit of {name}"))
        for name, one in zip(scenes, made)
    ]
