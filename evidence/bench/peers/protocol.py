"""What the peers in Python share: arguments as those of plain.c, and rounds on demand."""

import sys
import time

import numpy


class Case:
    """The sheet and the sphere, SI units."""

    def __init__(self):
        arguments = sys.argv[1:]
        self.n = int(arguments[0])
        self.before = int(arguments[1])
        drawn = numpy.fromfile(arguments[2]).reshape(-1, 2)
        horizontal = self.n * (self.n - 1)
        # [axis][row][column], one row or column less along the axis.
        self.modulus = [drawn[:horizontal, 0].reshape(self.n, -1), drawn[horizontal:, 0].reshape(-1, self.n)]
        self.rate = [drawn[:horizontal, 1].reshape(self.n, -1), drawn[horizontal:, 1].reshape(-1, self.n)]
        names = "h node_mass area dt radius body_mass speed critical_stretch a b alpha_fail".split()
        self.__dict__ |= dict(zip(names, map(float, arguments[3:14])))

    def rest(self):
        """Positions of the flat sheet, [node][3], rows along x."""
        place = (numpy.arange(self.n) - 0.5 * (self.n - 1)) * self.h
        x, y = numpy.meshgrid(place, place)
        return numpy.stack([x.ravel(), y.ravel(), numpy.zeros(self.n * self.n)], axis=1)


def serve(deflection, failed, restore, advance):
    """Says what the first steps gave; then, for every number on standard input, takes so many steps from the same state."""
    print(f"ready {deflection:.17g} {failed}", flush=True)
    for line in sys.stdin:
        steps = int(line)
        restore()
        start = time.process_time()
        advance(steps)
        print(f"{time.process_time() - start:.9g}", flush=True)
