"""Impact of rigid fragments on ballistic fabric: single runs, ensembles on one machine or many, ballistic limits.

`docs/python.md` of the project shows how it is used and what it can be trusted with.
All numbers are in SI units.
"""

from typing import Any

from . import extras
from ._kernel import PRESETS, VERSION, Failed, Refused, Scene, Simulation, parameters, replay, yarn_of_fibrils, yarns_of_fibrils
from .accuracy import accuracy
from .compare import compare
from .compared import model_error
from .designs import Neyer
from .ensembles import ClusterLost, ensemble, vary
from .fields import to_xarray
from .fragments import fragment_map
from .notes import ModelWarning
from .own_tests import own_tests
from .residual import residual
from .runs import Flight, fly, history
from .shooter import Shooter
from .v50 import v50

Simulation.to_xarray = to_xarray  # type: ignore[method-assign, assignment]
__version__ = VERSION
__all__ = [
    "PRESETS",
    "VERSION",
    "ClusterLost",
    "Failed",
    "Flight",
    "ModelWarning",
    "Neyer",
    "Refused",
    "Scene",
    "Shooter",
    "Simulation",
    "accuracy",
    "compare",
    "ensemble",
    "fly",
    "fragment_map",
    "history",
    "model_error",
    "own_tests",
    "parameters",
    "replay",
    "residual",
    "v50",
    "vary",
    "yarn_of_fibrils",
    "yarns_of_fibrils",
]


def __getattr__(name: str) -> Any:
    """Modules that draw, once they are asked for."""
    if name not in ("movie", "plot", "sheets"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return extras.loaded(name)
