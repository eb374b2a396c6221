"""A sheet that is hit, over time, as an animated GIF.

`movie(scene, "movie.gif")` runs a scene and writes it, as `fabric run --movie` does.
"""

import pathlib
from collections.abc import Sequence
from typing import Any

import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from . import drawing, sheets
from ._kernel import Scene, Simulation
from .files import Place
from .runs import UNTIL, named, stepped

MOST_PICTURES = 48


def movie(
    scene: Scene,
    path: Place = "movie.gif",
    *,
    until: Sequence[str] | str = UNTIL,
    steps: int = 100_000,
    every: int = 64,
    seconds: float = 6.0,
) -> None:
    """Runs a scene to one of the outcomes, for at most so many steps, and writes a GIF that lasts so many seconds.

    A sheet is kept every `every` steps; where they are too many every second one is given up. Raises Refused for a scene that
    cannot be simulated, ValueError for a projectile that is not drawn, Failed if the computation cannot go on."""
    if every < 1:
        raise ValueError(f"every: must be at least 1; it is {every}")
    until, simulation = named(until), Simulation(scene)
    kept, stride = [sheets.Sheet(simulation)], every
    for _ in stepped(simulation, until, steps, lambda: stride):
        kept.append(sheets.Sheet(simulation))
        if len(kept) > 2 * MOST_PICTURES:
            kept, stride = kept[::2], 2 * stride
    written(kept, pathlib.Path(path), seconds)


def colours() -> Any:
    """The colours that all pictures of a movie share: cloth and body in more and less light, and greys."""
    cloth = [
        light * numpy.array(sheets.STRAIN(k / 27)[:3]) for k in range(28) for light in (0.7, 0.8, 0.87, 0.93, 0.98, 1.02, 1.08)
    ]
    body = [light * sheets.STEEL for light in numpy.linspace(0.5, 1.3, 10)]
    return numpy.clip([*cloth, *body, *([k / 15] * 3 for k in range(16))], 0, 1)


@drawing.styled
def written(frames: Any, path: Place, seconds: float = 6.0) -> None:
    """The oblique view of some sheets, one behind the other."""
    frames = [frames[k] for k in numpy.unique(numpy.linspace(0, len(frames) - 1, MOST_PICTURES).round().astype(int))]
    axis = drawing.new()[1]
    frames[-1].draw_oblique(axis)
    (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
    images: list[Any] = []
    for sheet in frames:
        # As much room in every picture as the last one needs.
        figure, axis = drawing.new(6.4, 5.2 * (high - low) / (right - left) + 0.5)
        sheet.draw_oblique(axis, meshes=1.0)
        axis.set(xlim=(left, right), ylim=(low, high))
        sheets.bar(figure, axis, sheet, "strain (%)")
        figure.suptitle(f"{1e6 * sheet.time:.0f} µs, {sheet.failed()} failed segments", fontsize=10)
        figure.set_dpi(100)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        images.append(Image.fromarray(numpy.asarray(canvas.buffer_rgba())[..., :3].copy()))
    palette = Image.new("P", (1, 1))
    palette.putpalette([int(255 * part) for colour in colours() for part in colour])
    images = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    pause = max(40, round(1e3 * seconds / len(images) / 10) * 10)
    pathlib.Path(path).parent.mkdir(parents=True, exist_ok=True)
    images[0].save(
        path, save_all=True, append_images=images[1:], duration=[pause] * (len(images) - 1) + [1500], loop=0, optimize=True
    )
