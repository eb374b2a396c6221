#include "fragment.h"

#include <math.h>
#include <string.h>

static const double GRAVITY = -9.81;     /* along x, m/s2 */
static const double AIR_DENSITY = 1.225; /* kg/m3 */

static double length_of(const double v[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/* Matrix of a unit quaternion: its columns are the body's axes. */
static void rotation(const double q[4], double turn[3][3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double rows[3][3] = {
        {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
        {2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)},
        {2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)},
    };
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) turn[i][j] = rows[i][j];
}

/* The quaternion `a` of a rotation vector, rad, times `b`: first b, then the rotation. */
static void turned(const double turn[3], const double b[4], double result[4])
{
    const double angle = length_of(turn), factor = angle == 0.0 ? 0.0 : sin(0.5 * angle) / angle;
    const double a[4] = {cos(0.5 * angle), turn[0] * factor, turn[1] * factor, turn[2] * factor};
    const double product[4] = {
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + b[0] * a[1] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + b[0] * a[2] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + b[0] * a[3] + a[1] * b[2] - a[2] * b[1],
    };
    for (int k = 0; k < 4; k++) result[k] = product[k];
}

/* Angular velocity at an orientation and an angular momentum. */
static void rate_of(const fragment_body *body, const double orientation[4], const double momentum[3], double rate[3])
{
    double turn[3][3], inside[3];
    rotation(orientation, turn);
    for (int j = 0; j < 3; j++)
        inside[j] = (turn[0][j] * momentum[0] + turn[1][j] * momentum[1] + turn[2][j] * momentum[2]) / body->moments[j];
    for (int i = 0; i < 3; i++) rate[i] = turn[i][0] * inside[0] + turn[i][1] * inside[1] + turn[i][2] * inside[2];
}

fragment fragment_in_motion(const fragment_body *body, const double position[3], const double velocity[3], const double orientation[4],
                            const double rate[3])
{
    fragment f = {*body, {0.0}, {0.0}, {0.0}, {0.0}};
    double turn[3][3];
    memcpy(f.position, position, sizeof f.position);
    memcpy(f.velocity, velocity, sizeof f.velocity);
    memcpy(f.orientation, orientation, sizeof f.orientation);
    rotation(orientation, turn);
    for (int j = 0; j < 3; j++) {
        const double inside = body->moments[j] * (turn[0][j] * rate[0] + turn[1][j] * rate[1] + turn[2][j] * rate[2]);
        for (int i = 0; i < 3; i++) f.angular_momentum[i] += turn[i][j] * inside;
    }
    return f;
}

void fragment_angular_velocity(const fragment *f, double rate[3]) { rate_of(&f->body, f->orientation, f->angular_momentum, rate); }

void fragment_own_force(const fragment *f, double force[3])
{
    const double drag = -0.5 * AIR_DENSITY * f->body.drag_coefficient * f->body.frontal_area * length_of(f->velocity);
    for (int k = 0; k < 3; k++) force[k] = drag * f->velocity[k];
    force[0] += f->body.mass * GRAVITY;
}

void fragment_step(fragment *f, double h, const double own[3], const double force[3], const double torque[3], double tick)
{
    /* The rotation is the midpoint rule for q' = w q/2 at the angular momentum in the middle of the step. */
    double rate[3], halfway[4], middle[3], turn[3], length = 0.0;
    fragment_angular_velocity(f, rate);
    for (int k = 0; k < 3; k++) {
        const double from_own = own[k] / f->body.mass, from_shield = force[k] / f->body.mass;
        f->position[k] += f->velocity[k] * h + 0.5 * from_own * h * h + 0.5 * from_shield * h * (h + tick);
        f->velocity[k] += (from_own + from_shield) * h;
        middle[k] = f->angular_momentum[k] + 0.5 * h * torque[k];
        f->angular_momentum[k] += h * torque[k];
        turn[k] = 0.5 * h * rate[k];
    }
    turned(turn, f->orientation, halfway);
    rate_of(&f->body, halfway, middle, rate);
    for (int k = 0; k < 3; k++) turn[k] = h * rate[k];
    turned(turn, f->orientation, f->orientation);
    for (int k = 0; k < 4; k++) length += f->orientation[k] * f->orientation[k];
    for (int k = 0; k < 4; k++) f->orientation[k] /= sqrt(length);
}
