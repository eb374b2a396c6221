"""Impact of rigid fragments on ballistic fabric: single runs, ensembles on one machine or many, ballistic limits.

`docs/python.md` of the project shows how it is used and what it can be trusted with.
All numbers are in SI units.
"""

from ._kernel import PRESETS, VERSION, Failed, Refused, Scene, Simulation, parameters, replay, yarn_of_fibrils, yarns_of_fibrils
from .accuracy import accuracy
from .compare import compare
from .designs import Neyer
from .ensembles import ClusterLost, ensemble, vary
from .fragments import fragment_map
from .model_error import model_error
from .own_tests import own_tests
from .residual import residual
from .runs import fly, history
from .shooter import Shooter
from .v50 import v50

__version__ = VERSION
__all__ = [
    "PRESETS",
    "VERSION",
    "ClusterLost",
    "Failed",
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
