"""What a scene is as an engineer names it: areal density, presented area, and the numbers of Cunniff's axes.

Cunniff's axes: V50/(U*)^(1/3) over A_d A_p/m_p, with areal density A_d, presented area A_p and mass m_p of the projectile, and
U* = (strength x failure strain)/(2 density) x sqrt(modulus/density) of the fibre.
Limits: of a fabric with a weft of its own the yarn along x counts; strength is that of the model's law at its critical stretch.
The published curve is not drawn, as its coefficients could not be read in a source.
Reference: P. M. Cunniff, 18th International Symposium on Ballistics (1999).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy
from numpy.typing import ArrayLike

from ._kernel import Scene


def spacings(scene: Scene) -> tuple[float, float]:
    """Between nodes along x and along y, m."""
    return scene["sheet.spacing"], scene["sheet.spacing_y"] or scene["sheet.spacing"]


def sides(scene: Scene) -> tuple[float, float]:
    """Sides of the sheet along x and along y, m; with mirror planes of the part that is modelled."""
    along_x, along_y = spacings(scene)
    return (scene["sheet.nodes_x"] - 1) * along_x, (scene["sheet.nodes_y"] - 1) * along_y


def areal_density(scene: Scene) -> float:
    """Mass of all plies for each area, kg/m²."""
    back = scene["back.plies"]
    masses = (scene["stack.plies"] - back) * scene["sheet.node_mass"] + back * scene["back.node_mass"]
    return scene["sheet.plies"] * masses / math.prod(spacings(scene))


def in_axes(orientation: Sequence[float], vector: ArrayLike) -> numpy.ndarray:
    """A vector of the host in the axes that the quaternion (w, u) turns into the host's: v + 2 w (v x u) + 2 u x (u x v)."""
    (w, *u), v = orientation, numpy.asarray(vector, float)
    once = 2.0 * numpy.cross(v, u)
    return v + w * once + numpy.cross(once, u)


def from_edge(scene: Scene) -> float:
    """Least distance from an edge at which the flight meets the plane of a flat sheet, m; of one that moves along it, NaN."""
    offset = numpy.subtract(scene["projectile.position"], scene["sheet.position"])
    (x, y, z), (u, v, w) = (in_axes(scene["sheet.orientation"], vector) for vector in (offset, scene["projectile.velocity"]))
    half = [0.5 * side for side in sides(scene)]
    return min(half[0] - abs(x - u * z / w), half[1] - abs(y - v * z / w)) if w else math.nan


def presented_area(scene: Scene) -> float | None:
    """Area of a sphere, a cylinder or a box, as it flies, m²; None of another shape."""
    shape, velocity = scene["projectile.shape"], numpy.array(scene["projectile.velocity"])
    radius, speed = scene["projectile.radius"], float(numpy.linalg.norm(velocity))
    if shape == "sphere":
        return math.pi * radius * radius
    if shape not in ("cylinder", "box") or not speed > 0.0:
        return None
    along = numpy.abs(in_axes(scene["projectile.orientation"], velocity) / speed)
    if shape == "cylinder":
        return float(
            math.pi * radius * radius * along[2] + 2.0 * radius * scene["projectile.length"] * math.hypot(along[0], along[1])
        )
    x, y, z = scene["projectile.size"]
    return float(y * z * along[0] + x * z * along[1] + x * y * along[2])


def of_the_paper(scene: Scene) -> bool:
    """Whether the yarn is that of the presets, which is too stiff and strong for its mass."""
    names = ("yarn.modulus_mean", "yarn.critical_stretch", "sheet.node_mass", "sheet.yarn_area")
    paper = Scene()
    return all(scene[name] == paper[name] for name in names)


def cunniff_velocity(strength: float, strain: float, modulus: float, density: float) -> float:
    """(U*)^(1/3), m/s, of a fibre in SI units."""
    return math.cbrt(0.5 * strength * strain / density * math.sqrt(modulus / density))


class Axes(NamedTuple):
    """Place of a scene on Cunniff's axes."""

    velocity: float  # (U*)^(1/3), m/s
    ratio: float  # A_d A_p/m_p

    def words(self, v50: float) -> str:
        """One sentence for a report; v50 in m/s, NaN if there is none."""
        scaled = f", V50/(U*)^(1/3) {v50 / self.velocity:.3f}" if math.isfinite(v50) else ""
        return (
            f"On Cunniff's axes (1999): (U*)^(1/3) {self.velocity:.0f} m/s, from the yarn of the scene; A_d A_p/m_p "
            f"{self.ratio:.4f}{scaled}. "
            "The published curve is not given beside it: no source with its coefficients is available."
        )


def strength(scene: Scene) -> float:
    """Stress at which the yarn along x breaks by its law, Pa."""
    stretch = scene["yarn.critical_stretch"]
    return 0.5 * scene["yarn.modulus_mean"] * stretch * (stretch * stretch - 1.0)


def axes(scene: Scene) -> Axes | None:
    """The numbers of Cunniff's axes; None for a shape without a presented area, and for the paper's yarn, which is no real
    fibre."""
    area, (along_x, along_y), (crimp_x, crimp_y) = presented_area(scene), spacings(scene), scene["sheet.crimp"]
    if area is None or of_the_paper(scene):
        return None
    section, modulus, stretch = scene["sheet.yarn_area"], scene["yarn.modulus_mean"], scene["yarn.critical_stretch"]
    volume = section * along_x * (1.0 + crimp_x) + (scene["sheet.yarn_area_y"] or section) * along_y * (1.0 + crimp_y)
    density = scene["sheet.node_mass"] / volume
    velocity = cunniff_velocity(strength(scene), stretch - 1.0, modulus, density)
    return Axes(velocity, areal_density(scene) * area / scene["projectile.mass"])
