"""Arguments of functions, checked: a ValueError names the argument, what is accepted, and what it is."""

import collections
import math
import numbers as kinds
from collections.abc import Iterator, Sequence
from typing import Any, NoReturn

import numpy
from numpy.typing import NDArray

Array = NDArray[Any]


def refuse(name: str, accepted: str, value: object) -> NoReturn:
    text = value if isinstance(value, str) else repr(value)
    raise ValueError(f"{name}: must be {accepted}; it is {text if len(text) < 80 else text[:77] + '...'}")


def listed(values: Any) -> Any:
    """An iterator as a list, which may be walked twice; all else as it is."""
    return list(values) if isinstance(values, Iterator) else values


def numbers(name: str, values: Any, *, zero: bool = False, count: int | None = None) -> Array:
    """A list of numbers, all finite and above 0, or 0 too; as many as `count` if that is given."""
    try:
        found = numpy.asarray(listed(values), float)
    except (TypeError, ValueError):
        refuse(name, "a list of numbers", values)
    if found.ndim != 1 or not len(found) or count not in (None, len(found)):
        refuse(name, f"a list of {count or 'one or more'} numbers", f"an array of shape {found.shape}")
    for number, one in enumerate(found.tolist()):
        if not (one > 0.0 or (zero and one == 0.0)) or one == math.inf:
            refuse(f"{name}[{number}]", "a finite number, 0 or above" if zero else "a finite number above 0", one)
    return found


def results(name: str, values: Any, count: int) -> numpy.ndarray:
    """Whether each shot went through, as an array of bool: nothing else than True and False, 1 and 0 says that."""
    found = numpy.asarray(listed(values), object)
    if found.shape != (count,):
        refuse(name, f"a list of {count} results, one for each velocity", f"an array of shape {found.shape}")
    for number, one in enumerate(found):
        if not isinstance(one, (kinds.Real, numpy.bool_)) or one not in (0, 1):
            refuse(f"{name}[{number}]", "True or False, or 1 or 0", one)
    return found.astype(bool)


def whole(name: str, value: Any, least: int) -> int:
    """A whole number that is no smaller than this."""
    if isinstance(value, bool) or not isinstance(value, kinds.Integral) or value < least:
        refuse(
            name,
            f"at least {least}" if isinstance(value, kinds.Real) and value < least else f"a whole number, at least {least}",
            value,
        )
    return int(value)


def confident(value: Any) -> float:
    """A confidence."""
    if not isinstance(value, kinds.Real) or not 0.5 <= float(value) < 1:
        refuse("confidence", "from 0.5 to below 1", value)
    return float(value)


def rank(confidence: float, tests: int, name: str = "tests") -> int:
    """k so that one more test of n alike lies above the k-th smallest with a probability of at most 1 - confidence: all n + 1
    ranks are equally likely, so k = ceil(confidence (n + 1)), and n is at least confidence/(1 - confidence)."""
    confident(confidence)
    least = math.ceil(confidence / (1 - confidence) - 1e-9)
    if whole(name, tests, 0) < least:
        refuse(name, f"at least {least} for a confidence of {confidence:g}", tests)
    return math.ceil(confidence * (tests + 1) - 1e-9)


def twice(name: str, values: Sequence[Any]) -> list[str]:
    """A sentence for each value that is given more than once."""
    return [
        f"{name}: {value} is given {count} times and shot once."
        for value, count in collections.Counter(values).items()
        if count > 1
    ]
