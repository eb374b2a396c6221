"""The host's model: a rigid fragment in free flight, six degrees of freedom.

Axes: x and y in the plane of a flat sheet, y along the axis of a ring, x up, z along the flight. Units are SI. Quaternions are
scalar first and turn body vectors into world vectors; the body's z axis is the fragment's axis.
"""

import dataclasses
import math

import numpy as np

GRAVITY = np.array([-9.81, 0.0, 0.0])  # m/s2
ZERO = np.zeros(3)
AIR_DENSITY = 1.225  # kg/m3


@dataclasses.dataclass(frozen=True)
class Body:
    """What does not change: a sphere or a flat-ended cylinder."""

    shape: str  # "sphere" or "cylinder"
    radius: float  # m
    length: float  # m, along the axis
    mass: float  # kg
    drag_coefficient: float  # of the frontal area pi radius^2

    @property
    def frontal_area(self):
        """m2."""
        return math.pi * self.radius**2

    @property
    def moments(self):
        """Principal moments of inertia, kg m2."""
        if self.shape == "sphere":
            return np.full(3, 0.4 * self.mass * self.radius**2)
        across = self.mass * (3.0 * self.radius**2 + self.length**2) / 12.0
        return np.array([across, across, 0.5 * self.mass * self.radius**2])

    @property
    def start(self):
        """Orientation at the launch, before the tilt: axis along the flight."""
        return np.array([1.0, 0.0, 0.0, 0.0])

    def support(self, direction):
        """How far the body reaches from its centre of mass along a unit direction in body axes, m."""
        if self.shape == "sphere":
            return self.radius
        along = min(abs(direction[2]), 1.0)
        return 0.5 * self.length * along + self.radius * math.sqrt(1.0 - along**2)


@dataclasses.dataclass(frozen=True)
class DiscSector:
    """A sector of a turbine disc: body x outward along its middle, body z along the disc's axis; the shield's shape of that
    name."""

    inner_radius: float  # m, of the bore
    outer_radius: float  # m, of the rim
    angle: float  # rad
    thickness: float  # m
    mass: float  # kg
    drag_coefficient: float  # of the area of the rim seen from ahead
    shape: str = "disc sector"

    @property
    def frontal_area(self):
        """m2."""
        return 2.0 * self.outer_radius * math.sin(0.5 * self.angle) * self.thickness

    @property
    def corners(self):
        """Corners of the cross-section, counter-clockwise about its centre of mass, m: eight chords of the rim, one bore."""
        turns = np.concatenate([[0.5, -0.5], np.linspace(-0.5, 0.5, 9)]) * self.angle
        radii = np.array([self.inner_radius] * 2 + [self.outer_radius] * 9)
        corners = radii[:, None] * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        a, b = corners, np.roll(corners, -1, axis=0)
        twice_area = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
        return corners - ((a + b) * twice_area[:, None]).sum(axis=0) / (3.0 * twice_area.sum())

    @property
    def moments(self):
        """Principal moments of inertia of the homogeneous prism, kg m2, by sums over the edges of its cross-section."""
        a, b = self.corners, np.roll(self.corners, -1, axis=0)
        twice_area = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
        xx, yy = ((a * a + a * b + b * b) * twice_area[:, None]).sum(axis=0) / (6.0 * twice_area.sum())
        zz = self.thickness**2 / 12.0
        return self.mass * np.array([yy + zz, xx + zz, xx + yy])

    @property
    def start(self):
        """Orientation at the launch, before the tilt: the rim ahead, the disc's axis along y."""
        return np.array([0.5, -0.5, -0.5, -0.5])

    def support(self, direction):
        """How far the body reaches from its centre of mass along a unit direction in body axes, m."""
        return float(max(self.corners @ direction[:2])) + 0.5 * self.thickness * abs(direction[2])


@dataclasses.dataclass
class Fragment:
    """A body in motion. Rotation is kept as angular momentum in world axes, so that an angular impulse is simply added."""

    body: Body
    position: np.ndarray  # centre of mass, m
    velocity: np.ndarray  # m/s
    orientation: np.ndarray  # unit quaternion
    angular_momentum: np.ndarray  # about the centre of mass, N m s
    ring: float = 0.0  # radius of the ring that it flies into from inside, m; 0: the plane z = 0

    @staticmethod
    def burst(body, ring, distance, speed, angle=0.0):
        """A sector that left its disc on the axis of a ring, its rim ahead and `distance` before the ring: its spin is that of
        the disc, and its path leads `angle`, rad, off the plane of rotation, to the middle of the ring."""
        arm = body.outer_radius - body.support(np.array([1.0, 0.0, 0.0]))
        position = np.array([-arm, -distance * math.tan(angle), ring])
        velocity = speed * np.array([0.0, math.sin(angle), math.cos(angle)])
        fragment = Fragment(body, position, velocity, body.start, np.zeros(3), ring)
        fragment.angular_momentum = fragment.axis() * body.moments[2] * speed / arm
        fragment.position[2] -= distance + fragment.front()
        return fragment

    @staticmethod
    def launched(body, distance, speed, spin=0.0, tilt=0.0):
        """Fragment, front `distance` before the plane z = 0, flying along z; `spin` about its axis, rad/s, all tilted by `tilt`,
        rad."""
        orientation = product(exponential(np.array([tilt, 0.0, 0.0])), body.start)
        fragment = Fragment(body, np.zeros(3), np.array([0.0, 0.0, speed]), orientation, np.zeros(3))
        fragment.position[2] = -distance - fragment.reach()
        fragment.angular_momentum = fragment.axis() * body.moments[2] * spin
        return fragment

    def axis(self):
        """The body's z axis in world axes."""
        return rotation(self.orientation)[:, 2]

    def reach(self):
        """How far the front is ahead of the centre of mass along z, m."""
        return self.body.support(rotation(self.orientation)[2])

    def front(self):
        """z of the foremost point, or how far the farthest corner from the axis is beyond the ring, m."""
        if not self.ring:
            return self.position[2] + self.reach()
        x, _, z = self.position[:, None] + rotation(self.orientation)[:, :2] @ self.body.corners.T
        return float(np.hypot(x, z).max()) - self.ring

    def closing(self):
        """What the front is not faster than, m/s."""
        if not self.ring:
            return self.velocity[2]
        turning = np.linalg.norm(self.angular_velocity()) * np.hypot(*self.body.corners.T).max()
        return float(np.linalg.norm(self.velocity) + turning)

    def angular_velocity(self, orientation=None, angular_momentum=None):
        """World axes, rad/s."""
        turn = rotation(self.orientation if orientation is None else orientation)
        momentum = self.angular_momentum if angular_momentum is None else angular_momentum
        return turn @ ((turn.T @ momentum) / self.body.moments)

    def momentum(self):
        """kg m/s."""
        return self.body.mass * self.velocity

    def kinetic_energy(self):
        """Translation and rotation, J."""
        turning = self.angular_momentum @ self.angular_velocity()
        return 0.5 * self.body.mass * (self.velocity @ self.velocity) + 0.5 * turning

    def own_force(self):
        """Gravity and quadratic drag, N. Lift and the drag of a tumbling body are left out."""
        drag = (
            -0.5
            * AIR_DENSITY
            * self.body.drag_coefficient
            * self.body.frontal_area
            * np.linalg.norm(self.velocity)
            * self.velocity
        )
        return self.body.mass * GRAVITY + drag

    def step(self, h, own, force=ZERO, torque=ZERO, tick=0.0):
        """Moves on by `h` under its own force and the shield's mean force and torque: the impulses are exact.

        The shield's impulses act at the start of each of its internal steps `tick`, so they move the fragment tick/2 longer
        than a force spread evenly would: F/2m h (h + tick).

        The rotation is the midpoint rule for q' = w q/2 at the angular momentum in the middle of the step.
        """
        from_own, from_shield = own / self.body.mass, force / self.body.mass
        self.position = self.position + self.velocity * h + 0.5 * from_own * h**2 + 0.5 * from_shield * h * (h + tick)
        self.velocity = self.velocity + (from_own + from_shield) * h
        middle = self.angular_momentum + 0.5 * h * torque
        halfway = product(exponential(0.5 * h * self.angular_velocity()), self.orientation)
        turn = exponential(h * self.angular_velocity(halfway, middle))
        self.orientation = product(turn, self.orientation)
        self.orientation /= np.linalg.norm(self.orientation)
        self.angular_momentum = self.angular_momentum + h * torque


def exponential(turn):
    """Quaternion of a rotation vector, rad."""
    angle = np.linalg.norm(turn)
    if angle == 0.0:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return np.array([math.cos(0.5 * angle), *(turn * (math.sin(0.5 * angle) / angle))])


def product(a, b):
    """Quaternion product: first b, then a."""
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def rotation(q):
    """Matrix of a unit quaternion: its columns are the body's axes."""
    w, x, y, z = q
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
