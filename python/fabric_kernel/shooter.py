"""Shots at the sheet of a scene."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypedDict

import tqdm

from ._kernel import Refused, Scene
from .ensembles import Distribution, append, kept, run_key, vary, within_mesh
from .files import Place
from .notes import Note
from .runs import STEPS, doubts, flown, scene_of, where


class Unknown(RuntimeError):
    """A shot that was neither stopped nor went through."""


class Options(TypedDict, total=False):
    """Keyword arguments of a Shooter, without the seed."""

    point: tuple[float, float] | None
    attitude: str | Sequence[float] | None
    tilt: Distribution
    keep: Place | None
    steps: int | None
    to_the_end: bool


class Shooter:
    """Shoots the projectile of a scene at its sheet: `shoot(velocity, number)` gives whether it was stopped, and its speed left.

    What a real shot does not control is sampled anew for each: yarns, if the scene samples them, and where within one mesh about
    `point` the centre flies. A shot ends when it is arrested, has rebounded or exited, when held yarn does not stop it any more
    ("through"), or when its contact is with torn cloth only; in the last two cases its speed may still change a little
    (docs/v50.md, "Method"). A shot that neither stops nor goes through, misses the sheet, or is too fast for the time step after
    others that were not, raises Unknown, a RuntimeError.

    Parameters
    ----------
    scene : Scene or str
        Scene, or the name of a preset or a scene file.
    seed : int
        Seed of the samples.
    point : pair of float, optional
        Middle of the points of impact, m from the middle of the sheet; None: as the scene says.
    attitude, tilt : optional
        As for `vary`.
    keep : path, optional
        File that receives each shot; what is in it is not shot again.
    steps : int, optional
        Most steps of a shot; default: ten times those of `fly`.
    to_the_end : bool
        Whether a shot goes on after "through", until it has exited.
    """

    UNTIL = ("arrested", "detached", "exited", "passed", "rebounded", "through")

    def __init__(
        self,
        scene: Scene | str,
        *,
        seed: int = 1,
        point: tuple[float, float] | None = (0.0, 0.0),
        attitude: str | Sequence[float] | None = None,
        tilt: Distribution = None,
        keep: Place | None = None,
        steps: int | None = None,
        to_the_end: bool = False,
    ) -> None:
        scene = scene_of(scene)
        self.scene, self.seed, self.attitude, self.tilt = scene, seed, attitude, tilt
        self.steps = 10 * STEPS if steps is None else steps
        self.until = self.UNTIL[:-1] if to_the_end else self.UNTIL
        self.mesh = None if point is None else within_mesh(scene, point)
        self.keep = None if keep is None else Path(keep)
        self.rows = dict(kept(self.keep)) if self.keep is not None else {}
        self.was_kept = False
        """Whether the last shot was in the file."""
        self.made: dict[str, dict[str, Any]] = {}
        self.flown: list[tuple[Scene, dict[str, Any]]] = []

    def __call__(self, velocity: float, shot: int) -> tuple[bool, float]:
        one = vary(self.scene, shot + 1, seed=self.seed, speed=velocity, point=self.mesh, attitude=self.attitude, tilt=self.tilt)[
            shot
        ]
        key = run_key(one, self.until, self.steps)
        self.was_kept = key in self.rows
        if not self.was_kept:
            try:
                # On a terminal a shot of more than two seconds says where it is.
                with tqdm.tqdm(bar_format="{desc}", disable=None, leave=False, delay=2.0) as bar:
                    say = lambda simulation: bar.set_description_str(f"shot {shot + 1}: {where(simulation)}")
                    self.rows[key] = flown(one, self.until, self.steps, None if bar.disable else say)
            except Refused as refused:
                # For a scene that is sound at its own velocity.
                if shot and refused.field == "projectile.velocity":
                    raise Unknown(f"shot {shot + 1} at {velocity:.6g} m/s: {refused}") from refused
                raise
            if self.keep is not None:
                append(self.keep, [(key, json.dumps(self.rows[key]))])
        row = self.made[key] = self.rows[key]
        self.flown.append((one, row))
        if row["stopped"] is None:
            ended = f"{row['failure'] or row['outcome']} after {row['steps']} steps"
            raise Unknown(f"shot {shot + 1} at {velocity:.6g} m/s: {ended}: neither stopped nor through")
        return row["stopped"], row["speed"]

    def samples_yarns(self) -> bool:
        value = self.scene.to_dict()
        of_back = any(value[f"back.{name}"] for name in ("modulus_sd", "damage_sd", "weibull_shape"))
        return value["yarn.stochastic"] or value["yarn.strength_draw"] != "none" or bool(value["back.plies"] and of_back)

    def samples(self) -> bool:
        """Whether shots with one velocity differ."""
        return self.samples_yarns() or self.mesh is not None or self.attitude == "random" or self.tilt is not None

    def drawn(self) -> str:
        """What differs from shot to shot besides the velocity, in words."""
        yarn = "yarns sampled for each" if self.samples_yarns() else "the same yarns in each, as the scene samples none"
        where = "as the scene says" if self.mesh is None else "through a random point within one mesh of the middle"
        attitude = ", every orientation equally likely" if self.attitude == "random" else ""
        fixed = ["fragment", "fabric", "support"] + ([] if attitude else ["attitude"]) + ["angle of impact"]
        return f"Shots: seed {self.seed}, {yarn}, {where}{attitude}; not varied: {', '.join(fixed)}."

    def notes(self) -> list[str]:
        """What the reader of the shots made so far must know."""
        rows = [row for row in self.made.values() if row["stopped"] is not None]
        through = [row for row in rows if not row["stopped"]]
        torn = sum(row["outcome"] == "detached" for row in through)
        decided = sum("through" in row["outcome"] for row in through)
        absorbed = sum(row["absorbed"] for row in rows)
        notes = []
        if decided:
            notes.append(
                f"{decided} of {len(through)} shots that went through ended when held yarn could not stop them. Their residual "
                "velocities may still change a little (docs/v50.md); with --to-the-end they continue."
            )
        if torn:
            notes.append(
                f"{torn} of {len(through)} shots that went through ended when their contact was with torn cloth only. That "
                "cloth may still "
                "slow the projectile, so their residual velocities and the fitted curve are upper estimates (docs/v50.md)."
            )
        if absorbed > 0.0:
            notes.append(
                f"The viscosity of the yarn dissipated {100 * sum(row['viscous'] for row in rows) / absorbed:.0f} % of the "
                "absorbed energy."
            )
        return notes

    def warnings(self) -> list[Note]:
        """Decisive warnings of the shots made so far."""
        known = {id(row): (scene, row) for scene, row in self.flown if row["stopped"] is not None}
        return doubts([scene for scene, _ in known.values()], [row for _, row in known.values()])
