"""One ply: whether a projectile may part the yarns, which the network cannot show, and its limit beside that of resolved yarns.

A window is a hole through which the projectile passes without breaking a yarn. Criterion: a body of radius R between yarns with
spacing h and thickness t, half of the ply's, touches them where its surface is inclined by asin((h/2)/(R + t/2)); friction
between yarns and on the body together hold them there if mu + mu_s is at least (h/2)/(R + t/2). It is a hypothesis that the
resolved yarns of `python -m evidence oneply` were compared with:
docs/validation.md, "One ply", has the points on either side. It is not sharp: some of them parted up to MARGIN times that sum.
Limits: tested with spheres that hit a window of one ply of Kevlar KM2 S706, at the widths of comparisons.toml. It takes no
account of width, place and velocity: below the needed friction yarns may break first, on small sheets and at a crossing. A flat
face counts with the radius of the whole face.
No source with the friction of a fabric is available.
"""

import math
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

from ._kernel import Scene
from .textile import of_the_paper, spacings

FRICTION = (0.1, 0.3)
"""Between yarns, where the fabric of the scene has none: said of aramid fabrics, from memory, without a source."""
THICKNESS = 1.068
"""Thickness of the ply over the root of the area of a yarn, where the fabric has none: that of the resolved yarns, an
assumption."""
MARGIN = 1.2
"""Above so many times the needed friction none of the resolved yarns parted; between 1 and this some did, at 102 mm and above the
limit."""


class Windowing(NamedTuple):
    """needed: sum of the coefficients between yarns and on the body that the criterion asks for; there: that sum, lowest and
    highest."""

    needed: float
    there: tuple[float, float]

    def sentence(self) -> str:
        """For a report: on which side of the criterion the scene is, and where that was tested."""
        low, high = self.there
        found = f"{low:.2g}" if low == high else f"{low:.2g} to {high:.2g}"
        side = "the yarns should stay together under the projectile"
        if low < MARGIN * self.needed:
            likely = "is likely to" if high < self.needed else "may"
            side = f"the projectile {likely} part the yarns and pass without breaking one, at a velocity far below this limit"
        widths = " and ".join(f"{width:g}" for width in reference()["criterion_width_mm"])
        return (
            f"One ply: {side}: the coefficients of friction between yarns and on the projectile are together {found}, and the "
            f"criterion asks for {self.needed:.2g}. Of resolved yarns, computed at {widths} mm only, none parted from "
            f"{MARGIN:g} times that on (docs/validation.md, One ply)."
        )


def reference() -> dict[str, Any]:
    """What was compared with resolved yarns."""
    return tomllib.loads((Path(__file__).parent / "comparisons.toml").read_text("utf-8"))["reference"]


def windowing(scene: Scene) -> Windowing | None:
    """Whether a window may open in a scene of one ply; None of several plies or a body that is neither sphere nor cylinder.

    Of the fabric's thickness and friction (`scene.weave()`); THICKNESS and FRICTION stand for what is unknown."""
    given, shape = scene.weave(), scene["projectile.shape"]
    if scene["sheet.plies"] * scene["stack.plies"] != 1 or not (shape == "sphere" or "cylinder" in shape):
        return None
    # A bar of the network may stand for several yarns.
    of_bars = max(spacings(scene))
    spacing = given.get("spacing", of_bars)
    thickness = given.get("thickness", THICKNESS * math.sqrt(scene["sheet.yarn_area"] * spacing / of_bars))
    low, high = (given["friction"],) * 2 if "friction" in given else FRICTION
    needed = 0.5 * spacing / (scene["projectile.radius"] + 0.25 * thickness)
    body = scene["contact.friction"]
    return Windowing(needed, (low + body, high + body))


def beside_reference(scene: Scene) -> str:
    """What is known of the error of one ply without a test: the network's limit over that of resolved yarns; nothing of several
    plies, of the paper's yarn, of another support than four sides, and of other bodies than spheres and cylinders."""
    if windowing(scene) is None or of_the_paper(scene) or scene["attachment.kind"] != "four_sides":
        return ""
    found = reference()
    ratios = [case["network"] / case["resolved"] for case in found["case"]]
    return (
        f"no test of one ply is available; compared with yarns that slip, with friction {found['friction'][0]:g} to "
        f"{found['friction'][1]:g}, the limit is off by {100 * (min(ratios) - 1):+.0f} to {100 * (max(ratios) - 1):+.0f} % "
        f"({len(ratios)} cases, computed and not measured), where no window opens."
    )
