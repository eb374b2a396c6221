"""The host's model in these examples: a sphere that only contact forces move."""

MASS = 8.4e-3  # kg
RADIUS = 6.35e-3  # m


class Body:
    """Position and velocity of the centre, SI units."""

    def __init__(self, position, velocity):
        self.position, self.velocity = list(position), list(velocity)

    def pushed(self, force, h, dt):
        """Moves on by h under a mean force over h, N.

        The FMU's impulses act at the start of each internal step dt, so the displacement is F/2m h (h + dt).
        """
        # (M14) of docs/model.md.
        self.position = [x + v * h + 0.5 * f / MASS * h * (h + dt) for x, v, f in zip(self.position, self.velocity, force)]
        self.velocity = [v + f / MASS * h for v, f in zip(self.velocity, force)]

    def kinetic_energy(self):
        return 0.5 * MASS * sum(v * v for v in self.velocity)
