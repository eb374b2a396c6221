"""Fields of a sheet as an xarray.Dataset."""

from typing import TYPE_CHECKING

import numpy

from ._kernel import Simulation

if TYPE_CHECKING:
    import xarray


def to_xarray(simulation: Simulation) -> "xarray.Dataset":
    """Fields of the sheet at this time.

    Parameters
    ----------
    simulation : Simulation
        Simulation at any step.

    Returns
    -------
    xarray.Dataset
        `position` (m) and `velocity` (m/s) over ply, row, column and axis; `damage` (1 whole, 0 failed) and `stretch` of the
        segments along x (`damage_x`: ply, row, segment_x) and y (`damage_y`: ply, segment_y, column). Attributes: `time` (s),
        `step`, `digest` and `scene`, the text of its file.
    """
    from .extras import xarray

    scene, positions = simulation.scene, simulation.positions()
    plies, columns = scene["stack.plies"], positions.shape[1]
    rows = positions.shape[0] // plies
    # A mirrored line has one segment more, to an image, and so has a closed one, to its first node.
    along_x = columns - 1 + (scene["symmetry.mirror_x"] or scene["sheet.closed"])
    nodes, names = ("ply", "row", "column"), {"axis": list("xyz")}
    fields: dict[str, tuple[tuple[str, ...], object, dict[str, str]]] = {
        "position": ((*nodes, "axis"), positions.reshape(plies, rows, columns, 3), {"units": "m"}),
        "velocity": ((*nodes, "axis"), simulation.velocities().reshape(plies, rows, columns, 3), {"units": "m/s"}),
    }
    for name, values in (("damage", simulation.damage()), ("stretch", simulation.stretch())):
        x, y = numpy.split(values.reshape(plies, -1), [along_x * rows], axis=1)
        fields[f"{name}_x"] = (("ply", "row", "segment_x"), x.reshape(plies, rows, along_x), {"units": "1"})
        fields[f"{name}_y"] = (("ply", "segment_y", "column"), y.reshape(plies, -1, columns), {"units": "1"})
    about = {"time": simulation.time, "step": simulation.step_count, "digest": simulation.digest, "scene": scene.to_toml()}
    return xarray.Dataset(fields, names, about)
