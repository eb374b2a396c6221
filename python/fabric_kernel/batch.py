"""`fabric run SCENE --batch FILE.csv`: a run for each row of a table, whose columns are parameters of the scene."""

import contextlib
import csv
import io
import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._kernel import Scene
from .ensembles import ensemble
from .files import written
from .runs import with_units

if TYPE_CHECKING:
    import pandas

SHOWN = {"outcome": "outcome", "speed": "speed m/s", "absorbed": "absorbed J", "failed_segments": "failed"}
"""Results in the printed table, and their headings; batch.csv has all."""


def value(text: str) -> Any:
    """A cell: a number, true or false, an array or a table as JSON writes it; all else is a name, or a number with its unit."""
    if text.lower() in ("true", "false"):  # A spreadsheet writes TRUE.
        return text.lower() == "true"
    kinds: tuple[Any, ...] = (json.loads,) if text[0] in "[{" else (int, float)
    for kind in kinds:
        with contextlib.suppress(ValueError, RecursionError):
            return kind(text)
    return text


def is_vector(scene: Scene, name: str) -> bool:
    with contextlib.suppress(KeyError):
        return isinstance(scene[name], tuple)
    return False


def changed(scene: Scene, cells: dict[str, str]) -> Scene:
    """The scene with the values of a row; projectile.velocity[2] is an element of a vector."""
    values: dict[str, Any] = {}
    for name, cell in cells.items():
        element = re.fullmatch(r"(.+)\[([0-9])\]", name)
        parts = name.split(".")
        whole = {element[1]} if element else {".".join(parts[:end]) for end in range(1, len(parts))}
        if both := whole & set(cells):
            raise ValueError(f"{name}: give it or the whole of {both.pop()}")
        if element is None or not is_vector(scene, element[1]):
            values[name] = value(cell)
        else:
            vector = list(values.get(element[1], scene[element[1]]))
            if int(element[2]) >= len(vector):
                raise ValueError(f"{name}: {element[1]} has {len(vector)} elements, from 0 on")
            vector[int(element[2])] = value(cell)
            values[element[1]] = vector
    return scene.replace(values)


def rows_of(path: Path) -> list[tuple[int, dict[str, str]]]:
    """Number, from 1 on, and cells of each row of a table. Raises ValueError for what is no table."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
        lines = [[cell.strip() for cell in row] for row in csv.reader(io.StringIO(text, newline=""), strict=True)]
    except (UnicodeDecodeError, csv.Error) as error:
        kind = f"no CSV: {error}" if isinstance(error, csv.Error) else "no text in UTF-8; a spreadsheet writes it as CSV UTF-8"
        raise ValueError(f"{path}: {kind}") from error
    names = lines[0] if lines else []
    commas = "columns are separated by commas, and numbers have decimal points"
    if other := next((mark for mark in (";", "\t") if any(mark in name for name in names)), ""):
        raise ValueError(f"{path}: {commas}; the first line has {'a semicolon' if other == ';' else 'a tab'}")
    if twice := [name for name in names if name and names.count(name) > 1]:
        raise ValueError(f"{path}: a column is there twice: {twice[0]}")
    rows = [(number, cells) for number, cells in enumerate(lines[1:], 1) if any(cells)]  # A spreadsheet writes empty ones.
    for number, cells in rows:
        if len(cells) != len(names):
            raise ValueError(f"{path}: row {number}: {len(names)} cells are needed, and there are {len(cells)}: {commas}")
        if any(cell and not name for name, cell in zip(names, cells)):
            raise ValueError(f"{path}: row {number}: a cell is in a column without a name")
    if not rows:
        raise ValueError(f"{path}: has no row; the first line names the columns, as parameters of the scene")
    return [(number, dict(zip(names, cells))) for number, cells in rows]


def scenes_of(scene: Scene, path: Path) -> list[Scene]:
    """A scene for each row; raises ValueError with the number of the row if one is refused."""
    scenes = []
    for number, cells in rows_of(path):
        try:
            scenes.append(changed(scene, {name: cell for name, cell in cells.items() if cell}))
            scenes[-1].check()
        except (ValueError, TypeError, KeyError) as error:
            raise ValueError(f"{path}: row {number}: {str(error).strip(chr(39))}") from error
    return scenes


def flown(scene: Scene, path: Path, out: Path, until: list[str], steps: int) -> "pandas.DataFrame":
    """Flies every row; `out` receives batch.csv and runs.jsonl, from which the same call goes on."""
    scenes = scenes_of(scene, path)
    table = ensemble(scenes, keep=out / "runs.jsonl", until=until, steps=steps)
    written(out / "batch.csv", with_units(table).to_csv(index=False))
    return table


def text(table: "pandas.DataFrame") -> str:
    """The parameters that differ and the main results, a line for each row, in blocks of 100 columns."""
    changed = list(table.columns[1 : list(table.columns).index("outcome")])
    names = {name: f"{name} {table.attrs['units'].get(name, '')}".strip() for name in changed} | SHOWN
    rows = table[list(names)].rename(columns=names).set_axis(range(1, len(table) + 1))
    return str(rows.to_string(float_format="{:.5g}".format, line_width=100)) + "\n"
