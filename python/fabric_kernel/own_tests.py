"""`fabric tests FILE.csv`: one's own firing tests against the model (`family.py`), from a table of V50s or of single shots."""

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy
import scipy  # Its parts are loaded where they are used.

from . import batch, checks, limit, shields
from ._kernel import Scene
from .about import OWN, ending, folder, goes_on, of_others, options
from .designs import Plan
from .ensembles import Workers
from .family import WRITTEN, Measured, OwnTests, error_of, judged
from .files import Place, apart, shown

MOST = 3.0
"""Ratio of measured and computed limit, alone or over that of the other tests, beyond which a number is in doubt."""
SHOTS_OF = ("v50", "plus_minus", "sigma", "velocity", "stopped", "residual")
"""Columns that are no parameters of a scene."""


def number(path: Path, row: int, name: str, cell: str) -> float:
    """A velocity of the table, m/s or with its unit."""
    try:
        value = float(cell)
    except ValueError:
        try:
            value = math.hypot(*Scene().replace({"aim.speed": cell})["projectile.velocity"])
        except (ValueError, TypeError) as error:
            comma = ", with a decimal point" if "," in cell else ""
            said = f"{path}: row {row}: {name}: must be a number{comma}, m/s, or one with its unit; it is {cell}"
            raise ValueError(said) from error
    if not (value > 0.0 and math.isfinite(value)):
        raise ValueError(f"{path}: row {row}: {name}: must be greater than 0; it is {cell}")
    return value


def table(path: Path) -> list[tuple[int, dict[str, str]]]:
    """Number and cells of each row of a table of own tests."""
    rows = batch.rows_of(path)
    names = list(rows[0][1])
    if "scene" not in names or ("v50" in names) == ({"velocity", "stopped"} <= set(names)):
        wanted = "a column scene, and either v50 (with plus_minus or sigma) or velocity and stopped"
        raise ValueError(f"{path}: must have {wanted}; it has {', '.join(names)}")
    if {"plus_minus", "sigma"} <= set(names):
        raise ValueError(f"{path}: has plus_minus and sigma: one of them is needed")
    return rows


def read(path: Path) -> tuple[list[Measured], list[Scene]]:
    """Measured limit and scene of each shield of a table. Raises ValueError with the row."""
    found: dict[str, tuple[Scene, list[tuple[int, dict[str, str]]]]] = {}
    rows = table(path)
    bases: dict[str, Scene] = {}
    for row, cells in rows:
        file = cells["scene"]
        own = {name: cell for name, cell in cells.items() if name not in ("scene", *SHOTS_OF) and cell}
        name = ", ".join(
            [shown(file).removesuffix(".toml"), *(f"{key.removeprefix('sheet.')} {cell}" for key, cell in own.items())]
        )
        if name not in found:
            try:
                if file not in bases:
                    beside = path.parent / file
                    bases[file] = Scene.read(beside if beside.exists() else file)
                found[name] = batch.changed(bases[file], own), []
            except (ValueError, TypeError, KeyError, OSError) as wrong:
                said = f"there is no scene {file}" if isinstance(wrong, FileNotFoundError) else str(wrong).strip("'")
                raise ValueError(f"{path}: row {row}: {said}") from wrong
        found[name][1].append((row, cells))
    measured = []
    for name, (_, its) in found.items():
        row, cells = its[0]
        if "v50" in cells:
            if len(its) > 1:
                raise ValueError(f"{path}: row {its[1][0]}: {name} is there twice: give one V50 for each shield")
            value, error = number(path, row, "v50", cells["v50"]), 0.0
            if cells.get("plus_minus"):
                error = number(path, row, "plus_minus", cells["plus_minus"]) / value / float(scipy.special.ndtri(0.975))
            elif cells.get("sigma"):
                error = number(path, row, "sigma", cells["sigma"]) / value
            measured.append(Measured(name, value, error))
        else:
            measured.append(fitted(path, name, its))
    if len(measured) < 2:
        said = f"has one test, {measured[0].name}" if measured else "has no test"
        raise ValueError(f"{path}: {said}: two shields or more are needed; without them the package's error of the model holds")
    return measured, [scene for scene, _ in found.values()]


def fitted(path: Path, name: str, rows: Sequence[tuple[int, dict[str, str]]]) -> Measured:
    """V50 of the single shots of a shield."""
    words = {"1": True, "true": True, "yes": True, "stopped": True, "0": False, "false": False, "no": False, "through": False}
    v, through = [], []
    for row, cells in rows:
        said = cells["stopped"].lower()
        if said not in words:
            raise ValueError(f"{path}: row {row}: stopped: must be 1 or 0, yes or no; it is {cells['stopped'] or 'empty'}")
        v.append(number(path, row, "velocity", cells["velocity"]))
        through.append(not words[said])
    found = limit.fit(v, through, shares=(0.5,), design=Plan(v))
    error = error_of(*found.intervals[0])
    if not (math.isfinite(found.velocities[0]) and math.isfinite(error)):
        raise ValueError(f"{path}: {name}: no V50 from its {len(v)} shots: {found.notes[0] if found.notes else 'no interval'}")
    return Measured(name, found.velocities[0], error)


def asked(measured: Sequence[Measured], computed: Sequence[float]) -> None:
    """Asks about a measured limit, m/s, that is beyond MOST times the computed one, or that ratio beyond MOST times the median of
    the others: a slip in one digit beside a model that is too high or too low. Raises ValueError."""
    ratios = numpy.array([one.value / value for one, value in zip(measured, computed)])
    others = numpy.array([numpy.median(numpy.delete(ratios, k)) for k in range(len(ratios))])
    for reference, words in ((numpy.ones(len(ratios)), ""), (others, ", and the others have {:.2g}")):
        off = numpy.abs(numpy.log(ratios / reference))
        if off.max() > math.log(MOST):
            k = int(off.argmax())
            raise ValueError(
                f"{measured[k].name}: measured {measured[k].value:.4g} m/s, computed {computed[k]:.4g} m/s: a ratio of "
                f"{ratios[k]:.2g}{words.format(others[k])}. Are number and unit right? If they are, give --any-ratio"
            )


def own_tests(
    path: Place,
    *,
    shots: int = 20,
    seed: int = 1,
    confidence: float = 0.95,
    any_ratio: bool = False,
    keep: Place | None = None,
    on: Workers = None,
    progress: bool | None = None,
) -> OwnTests:
    """Own firing tests against the model: each shield of a table is computed as `v50` does.

    Parameters
    ----------
    path : path
        CSV file with columns `scene` (a file beside the table, or a preset), any parameters, and `v50` with `plus_minus` (half of
        its 95 % interval) or `sigma` (its standard error), or `velocity` and `stopped` of single shots; m/s, or with a unit.
    shots : int
        Computed shots of each shield.
    seed : int
        Seed of yarns and impact points.
    confidence : float
        Confidence of the intervals.
    any_ratio : bool
        Whether ratios of measured and computed limits beyond MOST are accepted.
    keep : path, optional
        Folder of kept results.
    on : int, str, Client or Cluster, optional
        Number of processes, or Dask scheduler; default: a process for each core.
    progress : bool, optional
        Whether to show a progress bar; default: on a terminal.

    Raises
    ------
    ValueError
        A row or an argument is wrong, or fewer than two shields have a limit in the model.
    """
    checks.whole("shots", shots, 6)
    checks.confident(confidence)
    path = Path(path)
    measured, scenes = read(path)
    judged(measured, scenes, [(one.value, 0.0) for one in measured])  # Refused before the work.
    names = {one.name: scene for one, scene in zip(measured, scenes)}
    keeping: Any = {"folder": keep, "on": on, "progress": progress}
    found = shields.limits(names, shots=shots, seed=seed, confidence=confidence, shifted=False, **keeping)
    computed, used, notes = [], [], []
    decisive: dict[str, str] = {}
    for one, scene, its in zip(measured, scenes, found):
        value, error = its.test.v50, error_of(*its.test.interval(), confidence)
        notes += [f"{one.name}: {its.test.doubt}"] if its.test.doubt else []
        decisive = {warning.kind: f"{one.name}: {warning}" for warning in its.test.warnings} | decisive
        if not (math.isfinite(value) and math.isfinite(error)):
            notes.append(f"Left out: {one.name}: the model has no limit to compare with. {its.test.answer()[0]}")
            continue
        computed.append((value, error))
        used.append((one, scene))
    if len(used) < 2:
        raise ValueError(f"{path}: fewer than two shields have a limit in the model: {' '.join(notes)}")
    if not any_ratio:
        asked([one for one, _ in used], [value for value, _ in computed])
    tests = judged([one for one, _ in used], [scene for _, scene in used], computed, f"Own tests of {path.name}", confidence)
    return dataclasses.replace(tests, said=(*decisive.values(), *notes))


def main(arguments: Sequence[str] | None = None) -> None:
    """The command `fabric tests`."""
    about = "Own firing tests against the model: how far it is off for shields like these."
    parser = options("tests", about, "Exit status: 0; 1 after a failure; 2 for what is refused.")
    add = parser.add_argument
    add(
        "file",
        type=Path,
        help="CSV with the columns scene and any parameters; and v50 with plus_minus or sigma, or velocity and stopped; m/s",
    )
    add("--shots", type=int, default=20, help="of each computed limit; default: %(default)s")
    add("--seed", type=int, default=1, help="of yarns and impact points; default: %(default)s")
    add("--confidence", type=float, default=0.95, help="default: %(default)s")
    add("--any-ratio", action="store_true", help=f"accept a measured limit beyond {MOST:g} times the computed one")
    add("--on", help="number of processes, or the address of a Dask scheduler")
    add("--out", type=Path, default=Path("own"), help="folder for report.html, own_tests.*; default: %(default)s")
    given = parser.parse_args(arguments)
    with ending(parser, given), folder(given.out):
        given.kept = goes_on(given.out / "shots")
        of_others(given.out, OWN)
        apart([given.file], [given.out / name for name in (*WRITTEN, "runs.jsonl")])
        found = given.answer = own_tests(
            given.file,
            shots=given.shots,
            seed=given.seed,
            confidence=given.confidence,
            any_ratio=given.any_ratio,
            keep=given.out,
            on=int(given.on) if given.on and given.on.isdigit() else given.on,
        )
        found.write(given.out)
        print(found.text())
        print(f"written to {given.out}: {', '.join(WRITTEN)}\nuse: fabric v50 SCENE --tests {given.out}")
