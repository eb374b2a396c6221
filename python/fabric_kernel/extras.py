"""Libraries that the extras of the package bring: `from .extras import pandas`."""

import importlib
import importlib.util
import sys
from typing import Any

EXTRAS = {"matplotlib": "plots", "PIL": "plots", "pandas": "tables", "distributed": "cluster", "xarray": "fields"}
"""Extra of each library."""


def found(name: str) -> None:
    """Raises ModuleNotFoundError that names the extra if a library is missing; does not load it."""
    if (sys.modules[name] if name in sys.modules else importlib.util.find_spec(name)) is None:
        raise ModuleNotFoundError(f"{name} is missing: pip install 'fabric-kernel[{EXTRAS[name]}]'", name=name)


def loaded(name: str) -> Any:
    """Module of the package that needs matplotlib."""
    found("matplotlib")
    return importlib.import_module(f"{__package__}.{name}")


def __getattr__(name: str) -> Any:
    if name not in EXTRAS:
        raise AttributeError(name)
    found(name)
    return importlib.import_module(name)
