"""Scenes and simulations of the kernel. All numbers are in SI units; vectors and quaternions (scalar first) in the host's frame."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

import numpy
from numpy.typing import ArrayLike, NDArray

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
_Vector = Sequence[float]

VERSION: str
"""Version of the kernel; another version may give other bits."""
PRESETS: list[str]
"""Names of the presets."""

class Refused(ValueError):
    """What was asked for cannot be; nothing has changed."""

    field: str
    """The parameter or argument, e.g. "projectile.mass"; empty if no single one is to blame."""
    other: str
    """The parameter that it does not go with, or that the limit follows from; else empty."""
    code: str
    """The reason, as `fabric::Code` names it; "BadValue" for an unknown name or a value of the wrong type."""
    value: float
    """The number found, 0 where none applies."""
    limit: float
    """The limit that it crosses, 0 where none applies."""

class Failed(RuntimeError):
    """The computation cannot go on. Every call repeats it until `reset` or `restore`."""

    code: str

class Parameter(TypedDict):
    name: str
    shape: tuple[int, ...]
    unit: str
    least: float
    greatest: float
    choices: tuple[str, ...]
    about: str

def parameters() -> list[Parameter]:
    """Every parameter of a scene."""

class Scene:
    """Everything that defines a simulation. It never changes, can be compared and pickled, and is small.

    A preset, and what differs from it: `Scene("sheet_3in_sphere", seed=7, projectile={"velocity": [0, 0, 80]})`, or with the whole
    names `Scene("sheet_3in_sphere", {"projectile.velocity": [0, 0, 80]})`. The names are those of scene files, `fabric` included.
    Whether the values are of the right type is checked here, whether they can be simulated by `check` and `Simulation`.

    Raises Refused with the name.
    """

    def __init__(self, preset: str = ..., parameters: Mapping[str, Any] | None = None, /, **more: Any) -> None: ...
    @staticmethod
    def read(path: str | os.PathLike[str]) -> Scene:
        """The scene of a TOML file."""

    @staticmethod
    def parse(text: str) -> Scene:
        """The scene of a TOML file's text."""

    def replace(self, parameters: Mapping[str, Any] | None = None, /, **more: Any) -> Scene:
        """The same with other values."""

    def aimed(
        self, point: Sequence[float] = ..., *, velocity: _Vector | None = None, orientation: Sequence[float] | None = None
    ) -> Scene:
        """The same with the projectile against the sheet, so that its centre flies through `point`.

        The point (m) is given in the sheet's plane from its middle. The projectile touches the first ply in its way with its
        foremost point; with a velocity askew the centre reaches the plane beside that. A point more than a mesh beside the sheet is
        refused.
        """

    def check(self) -> None:
        """Refuses, in some milliseconds, what `Simulation` would refuse, with the same exception.

        Of more than 8192 drawn segments, or nodes under the projectile, so many are looked at: what another one alone forbids is found
        by `Simulation`. Raises MemoryError if the machine has less memory than the scene takes.
        """

    def values(self) -> dict[str, Any]:
        """Every parameter by its name."""

    def text(self) -> str:
        """The scene as a TOML file, with every parameter and its meaning."""

    def unlikely_body(self) -> str | None:
        """What must be said of a projectile that is too heavy or too light for its size, as in a wrong unit; None otherwise."""

    def sharp_edges(self, speed: float) -> str | None:
        """What a report must say of a projectile with flat faces that flies at this speed, m/s; None if it is slow or round."""

    def __getitem__(self, name: str) -> Any: ...
    def __eq__(self, other: object) -> bool: ...

class StepLimits(TypedDict):
    dt: float
    dt_crit: float
    step_max: float

class Projectile(TypedDict):
    position: Vector
    velocity: Vector
    orientation: Quaternion
    angular_velocity: Vector

class Contact(TypedDict):
    work: float
    """Work of the projectile on the fabric, J."""
    loss: float
    force_peak: float
    impulse: Vector
    angular_impulse: Vector

class Support(TypedDict):
    total: Vector
    attachments: tuple[Vector, Vector, Vector, Vector]

class Energy(TypedDict):
    projectile_kinetic: float
    fabric_kinetic: float
    strain: float
    dissipated: float
    viscous: float
    friction: float
    ply_loss: float
    contact_loss: float
    contact_work: float
    support_work: float
    """Work of the projectile on held nodes, J: the part of `contact_work` that the fabric did not get."""
    external_work: float
    halving: float
    residual: float

class Ply(TypedDict):
    kinetic: float
    strain: float
    dissipated: float
    failed_segments: int

class Fabric(TypedDict):
    max_deflection: float
    max_stretch: float

class Counters(TypedDict):
    steps: int
    failed_segments: int
    contacts: int
    unconverged: int
    most_sweeps: int
    most_candidates: int
    candidate_capacity: int
    iterations: int
    most_iterations: int
    beyond_fine: int
    """Steps, or halves of them, in which the projectile met the sheet beyond the fine part of a graded network: 0 in a run that is to
    be trusted."""
    worst_penetration: float
    ply_penetration: float
    contact_residual: float
    """Greatest speed by which a contact has failed its law in a solve that was given up, m/s; 0 if all converged."""

class Latch(TypedDict):
    step: int
    time: float
    work: float

class Simulation:
    """One impact. What it computes leaves the interpreter free for other threads; one thread at a time may use it.

    Raises Refused if the scene cannot be simulated, MemoryError if it takes more memory than there is.
    Steps warn (RuntimeWarning), once, when the energy balance is open by more than 1 % of the impact energy, unless `warns` is False;
    they look every 256 steps.
    """

    def __init__(self, scene: Scene, *, warns: bool = True) -> None: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def step_count(self) -> int: ...
    @property
    def time(self) -> float:
        """s."""

    @property
    def step_limits(self) -> StepLimits: ...
    @property
    def digest(self) -> str:
        """A hash of the whole state: equal digests mean equal bits."""

    @property
    def first_contact(self) -> int | None:
        """Step at whose start the first contact impulse acted; None before."""

    @property
    def failure(self) -> str | None:
        """The code of the latched failure, if there is one."""

    def step(self, steps: int = 1) -> None:
        """Takes so many steps."""

    def run(self, until: str | Sequence[str], steps: int) -> int:
        """Steps until one of the outcomes ("arrested", "detached", "exited", "passed") has come, or so many steps are taken.

        Returns the steps taken. Ctrl-C stops it between two steps.
        """

    def follow(
        self,
        position: _Vector,
        velocity: _Vector,
        orientation: Sequence[float] = ...,
        angular_velocity: _Vector = ...,
        *,
        path_steps: int,
        first: int | None = None,
        steps: int | None = None,
    ) -> None:
        """Moves a prescribed projectile along a path of `path_steps` steps that ends with this pose and these rates.

        The path starts at the step count `first`, the present one if none is given; of it `steps` are taken, all if none are given.
        """

    def reset(self) -> None:
        """Back to step 0. Clears a failure."""

    def set_external_load(self, force: _Vector, torque: _Vector = ...) -> None:
        """The force, N, and torque, N m, that act on a free projectile from now on."""

    def set_motion(self, positions: ArrayLike, velocities: ArrayLike) -> None:
        """Starts from positions, m, and velocities, m/s, of all nodes, in arrays of the shape that `positions()` gives, however they
        lie in memory. They are copied; whole numbers and smaller floats are converted, every other type is refused."""

    def set_largest_stretch(self, stretches: ArrayLike) -> None:
        """Gives every segment the largest stretch that it has had (at most 1: undamaged), in the order of `stretch()`."""

    def save(self) -> bytes:
        """The state. Any simulation of the same scene and version can be put into it."""

    def restore(self, image: bytes) -> None:
        """Back to a saved state, bit for bit. A failure is cleared."""

    def projectile(self) -> Projectile:
        """Pose at this time, and rates half a step before."""

    def contact(self) -> Contact: ...
    def support(self) -> Support:
        """Impulses on the supports, N s: together, and on each side (left, right, bottom, top) or corner."""

    def energy(self) -> Energy:
        """The energy balance, J."""

    def ply(self, ply: int) -> Ply:
        """What one ply of a stack holds, J."""

    def momentum_residual(self) -> Vector:
        """Momentum that the balance does not close by, N s."""

    def fabric(self) -> Fabric:
        """Largest deflection, m, and largest stretch."""

    def counters(self) -> Counters:
        """Counters; also after a failure."""

    def outcomes(self) -> dict[str, Latch]:
        """Step, time (s) and work (J) of each outcome that has come."""

    def positions(self) -> NDArray[numpy.float64]:
        """Positions of the nodes, m: an array (rows, columns, 3), the rows of several plies one behind the other.

        With mirror planes only the nodes that are modelled. The array is new and its own owner: nothing is copied afterwards.
        """

    def velocities(self) -> NDArray[numpy.float64]:
        """Velocities of the nodes, m/s, as `positions`."""

    def damage(self) -> NDArray[numpy.float64]:
        """Remaining part alpha of the stiffness of each segment, in the order of their numbers: 1 whole, 0 failed."""

    def stretch(self) -> NDArray[numpy.float64]:
        """Stretch of each segment, in the same order."""
