"""Scenes and simulations of the kernel. All numbers are in SI units; vectors and quaternions (scalar first) in the host's
frame."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

import numpy
import xarray
from numpy.typing import ArrayLike, NDArray

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
_Vector = Sequence[float]

VERSION: str
"""Version of the kernel; another version may give other bits."""
PRESETS: list[str]
"""Names of the presets."""

class Refused(ValueError):
    """The request cannot be met; nothing has changed."""

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

class FibrilYarn(TypedDict):
    modulus: float
    """Modulus of the whole yarn, Pa."""
    work: float
    """Work to rupture, J/m^3."""
    left: float
    """Stress just beyond the critical stretch over that just below."""
    critical_stretch: float
    laws: tuple[tuple[float, float, float], tuple[float, float, float]]
    """Damage rate, A and B of the law fitted with A = 1 and B = 0, and with all three free."""
    expected_modulus: tuple[float, float]
    """Mean and standard deviation of the population, Pa, by quadrature."""
    ruptures: NDArray[numpy.float64]
    """Stretches at which the fibrils break, in turn."""
    alpha: NDArray[numpy.float64]
    """Damage variable just beyond each."""

def yarn_of_fibrils(seed: int, number: int, *, straight: bool = False) -> FibrilYarn:
    """Yarn `number` of the population `seed`: a bundle of the paper's fibrils, pulled until it breaks; `straight`: of aligned
    ones."""

def yarns_of_fibrils(seed: int, count: int) -> NDArray[numpy.float64]:
    """Modulus, Pa, fitted damage rate and its misfit of each of the first yarns of a population: an array (count, 3)."""

class Scene:
    """Everything that defines a simulation. It never changes, can be compared, hashed and pickled, and is small.

    A preset, and what differs from it: `Scene("sheet_3in_sphere", seed=7, projectile={"velocity": [0, 0, 80]})`, or with the
    whole names `Scene("sheet_3in_sphere", {"projectile.velocity": [0, 0, 80]})`. Names and values are those of scene files
    (data/fabrics/README.md):
    `Scene(fabric="kevlar_km2_s706", sheet={"width": "102 mm"}, projectile={"diameter": "5.56 mm", "material": "steel"},
    aim={"angle": "30 deg"})`.
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
        """Scene with other values."""

    def aimed(
        self, point: Sequence[float] = ..., *, velocity: _Vector | None = None, orientation: Sequence[float] | None = None
    ) -> Scene:
        """Scene with the projectile against the sheet, so that its centre flies through `point`.

        The point (m) is given in the sheet's plane from its middle. The projectile touches the first ply in its way with its
        foremost point; with a velocity askew the centre reaches the plane beside that. A point more than a mesh beside the sheet
        is refused.
        """

    def graded(self, error: float) -> Scene:
        """Scene with the graded network that the kernel chooses for this error of the absorbed energy, 0.005 to 0.1; whole if
        that leaves no node out, or if the sheet is held at its corners."""

    def check(self) -> None:
        """Refuses, in some milliseconds, what `Simulation` would refuse, with the same exception.

        Of more than 8192 drawn segments, or nodes under the projectile, so many are looked at: what another one alone forbids is
        found by `Simulation`. Raises MemoryError if the machine has less memory than the scene takes.
        """

    def to_dict(self) -> dict[str, Any]:
        """Every parameter by its name."""

    def words(self) -> list[int]:
        """Every number of the scene as 64 bits, in the order of `parameters`."""

    def to_toml(self) -> str:
        """The scene as a TOML file, with its fabrics, its projectile's material and their sources, every parameter and its
        meaning."""

    @property
    def fabrics(self) -> tuple[str | None, str | None]:
        """Names of the fabrics of the sheet and of its last plies, as they were given; None for one without a name."""

    @property
    def label(self) -> str:
        """Name of the fabric of the sheet, or of the preset that it is of."""

    @property
    def material(self) -> str | None:
        """Material of the projectile, if its mass follows from it."""

    def weave(self) -> dict[str, float]:
        """For the sheet's fabric the "thickness" of the ply and "width" of a yarn in it, m, and the "friction" between yarns,
        as far as its table gives them, and the larger "spacing" of its yarns, m; what is missing is unknown."""

    def features(self) -> dict[str, str]:
        """Features of the kernel that the scene needs, with the field that asks for each."""

    @property
    def remarks(self) -> list[str]:
        """What the reader of the scene's file must know: a projectile that no one has placed, a network that was not graded."""

    def held(self) -> list[tuple[int, int, int]]:
        """Held nodes of each ply: row, first column, and column after the last."""

    def unlikely_body(self) -> str | None:
        """What must be said of a projectile that is too heavy or too light for its size, as in a wrong unit; None otherwise."""

    def sharp_edges(self, speed: float) -> str | None:
        """What a report must say of a projectile with flat faces that flies at this speed, m/s; None if it is slow or round, or
        the cloth thick."""

    def loose_and_thick(self) -> str | None:
        """What a report must say of loose plies with a thickness."""

    def coarse_network(self) -> str | None:
        """What a report must say of a network too coarse for the flat front of the projectile, with the yarns a bar to take; None
        if it is fine enough."""

    def __getitem__(self, name: str) -> Any: ...
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...

class StepLimits(TypedDict):
    dt: float
    dt_crit: float
    step_max: float

class Slip(TypedDict):
    # Crossings that no support holds: within 5 and within 10 spacings of the projectile, and in the whole sheet
    crossings: tuple[int, int, int]
    slipping: tuple[int, int, int]  # Those of them at which pinning takes more than friction and adhesion give
    largest: float  # N: Largest force in the plane that pinning takes at a crossing

# Made by `cargo xtask fmu` of the kernel's outputs; do not edit.
class Contact(TypedDict):
    # N: Largest mean force over consecutive windows of force_window; until the first is full the mean force over the time elapsed
    force_peak: float
    impulse: Vector  # N.s: Impulse on the projectile since the start
    angular_impulse: Vector  # N.m.s: Angular impulse on the projectile about its moving centre of mass since the start
    work: float  # J: Work of the projectile on the fabric since the start: the energy absorbed
    loss: float  # J: Kinetic energy lost when nodes are swept up by the projectile

class Counters(TypedDict):
    steps: int  # Steps taken
    failed_segments: int  # Number of failed segments
    worst_penetration: float  # m: Deepest penetration of a node into the projectile so far
    ply_penetration: float  # m: Deepest way of a node through the one that it faces in the next of separate plies so far
    contacts: int  # Nodes with a contact impulse in the last step
    unconverged: int  # Contact solves that were given up
    # m/s: Greatest speed by which a contact has failed its law in a solve that was given up; 0 if all converged
    contact_residual: float
    most_sweeps: int  # Most Gauss-Seidel sweeps of one contact solve, passes of Newton's method included
    most_candidates: int  # Most candidate nodes of one step
    candidate_capacity: int  # Places for candidate nodes
    iterations: int  # Iterations of the theta rule; 0 with velocity Verlet
    most_iterations: int  # Most iterations of one step
    # Steps in which the projectile met the sheet beyond the fine part of a graded network, where nodes may be too far apart to
    # feel it: 0 in a run that is to be trusted
    beyond_fine: int

class Energy(TypedDict):
    projectile_kinetic: float  # J: Kinetic energy of the projectile; 0 if its mass is unknown
    fabric_kinetic: float  # J: Kinetic energy of the fabric
    strain: float  # J: Strain energy of the yarns
    dissipated: float  # J: Energy dissipated by rupture
    contact_loss: float  # J: The same as contact.loss
    viscous: float  # J: Energy dissipated by viscosity and rate dependence of the yarn
    friction: float  # J: Energy dissipated by friction between yarn and projectile
    ply_loss: float  # J: Kinetic energy lost where separate plies meet
    contact_work: float  # J: The same as contact.work
    support_work: float  # J: Work of the projectile on held nodes: the part of contact.work that the fabric did not get
    casing_loss: float  # J: Kinetic energy lost where nodes of a ring meet its case
    attachment: float  # J: Energy dissipated in clamps in which held nodes have slid
    gained: float  # J: Energy from nothing, in energy.residual
    external_work: float  # J: Work of the external load on the projectile
    residual: float  # J: Residual of the energy balance

class Fabric(TypedDict):
    # m: Largest distance from the sheet's plane of a node that is still joined to a support (of any node of a free sheet)
    max_deflection: float
    max_stretch: float  # Largest stretch of a segment that has not failed

class Ply(TypedDict):
    failed_segments: int  # Failed segments of single plies, from ply.first on; 0 for a ply that there is not
    kinetic: float  # J: Kinetic energy of single plies, likewise
    strain: float  # J: Strain energy of single plies, likewise
    dissipated: float  # J: Energy dissipated by rupture in single plies, likewise

class Projectile(TypedDict):
    position: Vector  # m: Centre of mass of the body the fabric saw
    velocity: Vector  # m/s: Velocity of that body (half an internal step earlier)
    orientation: Quaternion  # Orientation of that body, scalar first
    angular_velocity: Vector  # rad/s: Angular velocity of that body, host's axes

class Support(TypedDict):
    total: Vector  # N.s: Impulse of the sheet on all its supports since the start
    # N.s: The same for each attachment: sides left (-x), right, bottom (-y), top; or corners (-x -y), (+x -y), (-x +y), (+x +y)
    attachments: tuple[Vector, Vector, Vector, Vector]
    # N: Mean force on each attachment over the last window of force_window; 0 before, and without a hold or a strength
    force: Quaternion
    let_go: Quaternion  # s: Time at which each attachment let go; 0: it has not
    casing: Vector  # N.s: The same for the case of a ring

# End of what is made.

class Latch(TypedDict):
    step: int
    time: float
    work: float

class Replayed(TypedDict):
    same: bool  # Whether the bits are the same
    difference: str | None  # Where the first difference is
    calls: int
    step: int
    digests: int  # Digests that were found equal
    digest: str  # At the end
    whole: bool  # Whether the capsule was ended by its program
    version: str  # Of the kernel that wrote it

class Named(TypedDict):
    name: str
    title: str
    text: str  # Its file, with the source of each number
    areal_density: float  # kg/m2; NaN for a yarn alone, as the next two
    spacing: float  # m: between yarns of the weft
    area: float  # m2: of fibre in a yarn of the warp
    wave_speed: float  # m/s
    critical_stretch: float

def fabrics() -> list[Named]:
    """The named fabrics."""

def replay(file: str | os.PathLike[str]) -> Replayed:
    """Does a capsule again (`Simulation(..., capsule=FILE)`), and compares the bits.

    Raises Refused if the file is no capsule, or altered.
    """

class Simulation:
    """One impact, of a scene, or of a preset or a file by its name. What it computes leaves the interpreter free for other
    threads; one thread at a time may use it.

    Raises Refused if the scene cannot be simulated, MemoryError if it takes more memory than there is.
    Steps warn (RuntimeWarning), once, when the energy residual exceeds 1 % of the impact energy, unless `warns` is False;
    they look every 256 steps.
    `capsule` is a file that gets every call which changes the simulation: `replay(FILE)` does them again and compares the bits.
    A single value is a property, a table or an array a call.
    """

    def __init__(self, scene: Scene | str, *, warns: bool = True, capsule: str | os.PathLike[str] | None = None) -> None: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def step_count(self) -> int: ...
    @property
    def time(self) -> float:
        """s."""

    @property
    def digest(self) -> str:
        """A hash of the whole state: equal digests mean equal bits."""

    @property
    def first_contact(self) -> int | None:
        """Step at whose start the first contact impulse acted; None before."""

    @property
    def failure(self) -> str | None:
        """The code of the latched failure, if there is one."""

    def step_limits(self) -> StepLimits: ...
    def step(self, steps: int = 1) -> None:
        """Takes so many steps."""

    def run(self, until: str | Sequence[str], steps: int, *, failed: int | None = None) -> int:
        """Steps until one of the outcomes ("arrested", "detached", "exited", "passed", "through", "rebounded") has come, or so
        many steps are taken; with
        `failed` one by one, and only until at least so many segments have failed.

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

        The path starts at the step count `first`, the present one if none is given; of it `steps` are taken, all if none are
        given.
        """

    def reset(self) -> None:
        """Back to step 0. Clears a failure."""

    def set_external_load(self, force: _Vector, torque: _Vector = ...) -> None:
        """The force, N, and torque, N m, that act on a free projectile from now on."""

    def set_motion(self, positions: ArrayLike, velocities: ArrayLike) -> None:
        """Starts from positions, m, and velocities, m/s, of all nodes, in arrays of the shape that `positions()` gives, however
        they lie in memory. They are copied; whole numbers and smaller floats are converted, every other type is refused."""

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

    def slip(self, thickness: float, friction: float, adhesion: float = 0.0) -> Slip:
        """At how many crossings yarns would slip, which the network pins (docs/validation.md, "Where crossings slip"). Not of
        curved sheets.

        thickness: of the ply, m, > 0. friction: coefficient between yarns, >= 0. adhesion: the force at a crossing without
        pressure, N, >= 0.
        Raises Refused if one is out of range."""

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

    def to_xarray(self) -> xarray.Dataset:
        """Fields of the sheet at this time (`fabric_kernel.fields`)."""
