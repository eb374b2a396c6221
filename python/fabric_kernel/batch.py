"""`fabric run SCENE --batch FILE.csv`: a run for each row of a table, whose columns are parameters of the scene."""

import csv
import re
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import page
from ._kernel import Scene
from .ensembles import ensemble
from .files import written

if TYPE_CHECKING:
    import pandas

SHOWN = {"outcome": "outcome", "speed": "speed m/s", "absorbed": "absorbed J", "failed_segments": "failed"}
"""Results in the printed table, and their headings; batch.csv has all."""


def value(text: str) -> Any:
    """A cell: a number, true or false as TOML writes it; all else is a name, or a number with its unit."""
    try:
        return tomllib.loads(f"cell = {text}")["cell"]
    except tomllib.TOMLDecodeError:
        return text


def changed(scene: Scene, cells: dict[str, str]) -> Scene:
    """The scene with the values of a row. An empty cell keeps the scene's; projectile.velocity[2] is an element of a vector."""
    values: dict[str, Any] = {}
    for name, cell in cells.items():
        if cell.strip():
            element = re.fullmatch(r"(.+)\[(\d)\]", name)
            if element:
                vector = list(values.get(element[1], scene[element[1]]))
                if int(element[2]) >= len(vector):
                    raise ValueError(f"{name}: {element[1]} has {len(vector)} elements, from 0 on")
                vector[int(element[2])] = value(cell)
                values[element[1]] = vector
            else:
                values[name] = value(cell)
    return scene.replace(values)


def scenes_of(scene: Scene, path: Path) -> list[Scene]:
    """A scene for each row; raises ValueError with the number of the row, from 1 on, if one is refused."""
    with path.open(newline="") as file:
        table = csv.DictReader(file, strict=True)
        names, scenes = table.fieldnames or [], []
        if len(set(names)) < len(names):
            raise ValueError(f"{path}: a column is there twice: {', '.join(names)}")
        for number, row in enumerate(table, 1):
            try:
                if None in row or None in row.values():
                    raise ValueError(f"{len(names)} cells are needed")
                scenes.append(changed(scene, row))
                scenes[-1].check()
            except (ValueError, TypeError, KeyError) as error:
                raise ValueError(f"{path}: row {number}: {str(error).strip(chr(39))}") from error
    if not scenes:
        raise ValueError(f"{path}: has no row; the first line names parameters of the scene, each other one is a run")
    return scenes


def flown(scene: Scene, path: Path, out: Path, until: list[str], steps: int) -> "pandas.DataFrame":
    """Flies every row; `out` receives batch.csv and runs.jsonl, from which the same call goes on."""
    scenes = scenes_of(scene, path)
    table = ensemble(scenes, keep=out / "runs.jsonl", until=until, steps=steps)
    written(out / "batch.csv", table.to_csv(index=False))
    return table


WIDTH = 100
"""Columns of the printed table; parameters for which there is no room are in batch.csv only."""


def text(table: "pandas.DataFrame") -> str:
    """The parameters that differ and the main results, a line for each row."""
    changed = list(table.columns[1 : list(table.columns).index("outcome")])
    while True:
        heads = ["row", *(f"{name} {table.attrs['units'].get(name, '')}".strip() for name in changed), *SHOWN.values()]
        cells = table[[*changed, *SHOWN]].itertuples(index=False)
        rows = [[row, *(f"{cell:.5g}" if isinstance(cell, float) else cell for cell in one)] for row, one in enumerate(cells, 1)]
        printed = page.printed(heads, rows)
        if not changed or printed.index("\n") <= WIDTH:
            return printed
        changed.pop()
