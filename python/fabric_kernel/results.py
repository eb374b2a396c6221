"""Results as JSON: what a command has found is written as numbers and words, and read back by `fabric report`."""

import dataclasses
import json
import math
import typing
from pathlib import Path
from typing import Any

import numpy

from .files import reading, written
from .limit import Interval
from .notes import Note


def plain(value: Any) -> Any:
    """A result as JSON has it: null where a number is not finite, an object for what has names, a list for what has elements."""
    if dataclasses.is_dataclass(value):
        value = vars(value)
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Note):
        value = {"kind": value.kind, "text": value.text, "numbers": value.numbers}
    if isinstance(value, dict):
        return {str(name): plain(one) for name, one in value.items()}
    if isinstance(value, (list, tuple, numpy.ndarray)):
        return [plain(one) for one in value]
    if isinstance(value, numpy.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def restored(kind: Any, value: Any) -> Any:
    """A value of this type, of what `plain` made of it."""
    if kind is float:
        return math.nan if value is None else float(value)
    if kind is Note:
        return kind(**value)
    if kind is numpy.ndarray:
        return numpy.array(value)
    if typing.get_origin(kind) is tuple:
        return tuple(restored(typing.get_args(kind)[0], one) for one in value)
    if kind is Interval:
        return kind(*(end if value[name] is None else value[name] for name, end in (("low", -math.inf), ("high", math.inf))))
    if isinstance(kind, type) and (dataclasses.is_dataclass(kind) or hasattr(kind, "_fields")):
        kinds = typing.get_type_hints(kind)
        return kind(**{name: restored(kinds[name], one) for name, one in value.items()})
    others = [one for one in typing.get_args(kind) if one is not type(None)]
    return None if value is None else restored(others[0], value) if others else value


def save(result: Any, path: Path) -> None:
    written(path, json.dumps(plain(result), indent=1) + "\n")


def read(kind: Any, path: Path) -> Any:
    """The result of this type that is saved in a file."""
    with reading(path):
        return restored(kind, json.loads(path.read_bytes()))
