"""Impact of rigid fragments on ballistic fabric: single runs, ensembles on one machine or many, ballistic limits.

`docs/python.md` of the project shows how it is used and what it can be trusted with.
All numbers are in SI units.
"""

from ._kernel import PRESETS, VERSION, Failed, Refused, Scene, Simulation, parameters, replay, yarn_of_fibrils, yarns_of_fibrils
from .ensembles import ClusterLost, ensemble, vary
from .fragments import fragment_map
from .model_error import model_error
from .runs import fly, history

__version__ = VERSION
__all__ = [
    "PRESETS",
    "VERSION",
    "ClusterLost",
    "Failed",
    "Refused",
    "Scene",
    "Simulation",
    "ensemble",
    "fly",
    "fragment_map",
    "history",
    "model_error",
    "parameters",
    "replay",
    "vary",
    "yarn_of_fibrils",
    "yarns_of_fibrils",
]
