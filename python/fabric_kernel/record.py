"""Results: frozen dataclasses whose fields have a meaning and a unit, which `help` shows."""

import dataclasses
import inspect
from typing import TypeVar, dataclass_transform

Kind = TypeVar("Kind")


@dataclass_transform(frozen_default=True)
def record(kind: type[Kind]) -> type[Kind]:
    """Makes a frozen dataclass, and adds the meanings of its fields, which are `Annotated`, to its docstring.

    Parameters
    ----------
    kind : type
        Class with a docstring.
    """
    made = dataclasses.dataclass(frozen=True)(kind)
    fields = [f"{field.name}\n    {field.type.__metadata__[0]}" for field in dataclasses.fields(made)]  # type: ignore[arg-type, union-attr]
    made.__doc__ = "\n".join([inspect.getdoc(kind) or "", "", "Attributes", "----------", *fields])
    return made
