"""The benchmark's sheet and sphere with NVIDIA Warp on the CPU: the same law, damage, draws, time step and contact.

Three kernels a step: every segment computes its force and damage, every node gathers its four and takes the impulse of the
sphere, the sphere moves. Arguments and output: see plain.c.
"""

import protocol
import warp as wp

wp.config.quiet = True
wp.config.enable_backward = False
wp.init()


@wp.func
def force(
    xa: wp.vec3d,
    xb: wp.vec3d,
    e: int,
    inverse: wp.float64,
    law: wp.array(dtype=wp.float64),
    k: wp.array(dtype=wp.float64),
    whole: wp.array(dtype=wp.float64),
    rate: wp.array(dtype=wp.float64),
    worst: wp.array(dtype=wp.float64),
):
    """Change of velocity that segment e gives its first node."""
    d = xb - xa
    q = wp.dot(d, d) * inverse - wp.float64(1.0)
    if q > worst[e]:
        alpha = law[1] * (wp.exp(-rate[e] * (wp.sqrt(wp.float64(1.0) + q) - law[0])) - law[2])
        alpha = wp.min(alpha, wp.float64(1.0))
        worst[e] = q
        if alpha <= law[3]:
            alpha = wp.float64(0.0)
            worst[e] = wp.float64(1.0e300)
        k[e] = alpha * whole[e]
    return d * (k[e] * wp.max(q, wp.float64(0.0)))


@wp.kernel(enable_backward=False)
def segments(
    n: int,
    inverse: wp.float64,
    law: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    k: wp.array(dtype=wp.float64),
    whole: wp.array(dtype=wp.float64),
    rate: wp.array(dtype=wp.float64),
    worst: wp.array(dtype=wp.float64),
    pull: wp.array(dtype=wp.vec3d),
):
    """The segments that start at a node: to the right (2 node) and up (2 node + 1)."""
    node = wp.tid()
    here = x[node]
    if node % n < n - 1:
        pull[2 * node] = force(here, x[node + 1], 2 * node, inverse, law, k, whole, rate, worst)
    if node // n < n - 1:
        pull[2 * node + 1] = force(here, x[node + n], 2 * node + 1, inverse, law, k, whole, rate, worst)


@wp.kernel(enable_backward=False)
def nodes(
    n: int,
    dt: wp.float64,
    h: wp.float64,
    radius: wp.float64,
    node_mass: wp.float64,
    body_mass: wp.float64,
    pull: wp.array(dtype=wp.vec3d),
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    body: wp.array(dtype=wp.float64),
    push: wp.array(dtype=wp.float64),
):
    """Kick, impulse of the sphere (body: place and speed along z), drift; the four sides are held."""
    node = wp.tid()
    i = node % n
    j = node // n
    if i > 0 and i < n - 1 and j > 0 and j < n - 1:
        p = x[node]
        u = v[node] + (pull[2 * node] - pull[2 * node - 2]) + (pull[2 * node + 1] - pull[2 * (node - n) + 1])
        r = p - wp.vec3d(wp.float64(0.0), wp.float64(0.0), body[0])
        r2 = wp.dot(r, r)
        if r2 < (radius + h) * (radius + h):
            distance = wp.sqrt(r2)
            normal = r / distance
            gap = wp.max(distance - radius, wp.float64(0.0))
            approach = gap / dt + wp.dot(normal, u) - normal[2] * body[1]
            if approach < wp.float64(0.0):
                impulse = -approach / (wp.float64(1.0) / node_mass + wp.float64(1.0) / body_mass)
                u = u + normal * (impulse / node_mass)
                wp.atomic_add(push, 0, -normal[2] * impulse / body_mass)
        v[node] = u
        x[node] = p + u * dt


@wp.kernel(enable_backward=False)
def sphere(dt: wp.float64, body: wp.array(dtype=wp.float64), push: wp.array(dtype=wp.float64)):
    """Takes all impulses and moves."""
    body[1] = body[1] + push[0]
    body[0] = body[0] + body[1] * dt
    push[0] = wp.float64(0.0)


def main():
    case = protocol.Case()
    n = case.n
    numpy = protocol.numpy
    device = "cpu"

    def array(values, dtype=wp.float64):
        return wp.array(values, dtype=dtype, device=device)

    def by_node(planes):
        """Numbers of the segments by the nodes they start from."""
        values = numpy.zeros((n, n, 2))
        values[:, :-1, 0] = planes[0]
        values[:-1, :, 1] = planes[1]
        return values.ravel()

    stiffness = case.area * case.dt / (2.0 * case.h * case.node_mass)
    whole = array(by_node(case.modulus) * stiffness)
    rate = array(by_node(case.rate))
    critical = (case.critical_stretch - 1.0) * (case.critical_stretch + 1.0)
    x = array(case.rest(), wp.vec3d)
    v = wp.zeros(n * n, dtype=wp.vec3d, device=device)
    k = wp.clone(whole)
    worst = array(numpy.full(2 * n * n, critical))
    pull = wp.zeros(2 * n * n, dtype=wp.vec3d, device=device)
    body = array([-case.radius, case.speed])
    push = wp.zeros(1, dtype=wp.float64, device=device)
    law = array([case.critical_stretch, case.a, case.b, case.alpha_fail])

    # Recorded once: replaying costs less than launching from Python.
    first = [n, 1.0 / (case.h * case.h), law, x, k, whole, rate, worst, pull]
    second = [n, case.dt, case.h, case.radius, case.node_mass, case.body_mass, pull, x, v, body, push]
    commands = [
        wp.launch(segments, dim=n * n, inputs=first, device=device, record_cmd=True),
        wp.launch(nodes, dim=n * n, inputs=second, device=device, record_cmd=True),
        wp.launch(sphere, dim=1, inputs=[case.dt, body, push], device=device, record_cmd=True),
    ]

    def advance(steps):
        for _ in range(steps):
            for command in commands:
                command.launch()

    advance(case.before)
    state = [x, v, k, worst, body]
    kept = [wp.clone(part) for part in state]

    def restore():
        for part, image in zip(state, kept):
            wp.copy(part, image)

    failed = int((k.numpy() == 0.0).sum() - (whole.numpy() == 0.0).sum())
    protocol.serve(float(numpy.abs(x.numpy()[:, 2]).max()), failed, restore, advance)


main()
