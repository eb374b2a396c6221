/* A rigid fragment in free flight, six degrees of freedom: fragment.py in C, for the fragment's own FMU.

   Axes: x and y in the plane of the sheet, y up, z along the flight. Units are SI. Quaternions are scalar first and turn body
   vectors into world vectors; the body's axes are the principal axes of inertia. */
#ifndef FRAGMENT_H
#define FRAGMENT_H

typedef struct {
    double mass;             /* kg */
    double moments[3];       /* principal moments of inertia along the body's axes, kg m2 */
    double drag_coefficient; /* of the frontal area */
    double frontal_area;     /* m2 */
} fragment_body;

/* Rotation is kept as angular momentum in world axes, so that an angular impulse is simply added. */
typedef struct {
    fragment_body body;
    double position[3];         /* centre of mass, m */
    double velocity[3];         /* m/s */
    double orientation[4];      /* unit quaternion */
    double angular_momentum[3]; /* about the centre of mass, N m s */
} fragment;

/* A body in motion; the angular velocity is in world axes, rad/s. */
fragment fragment_in_motion(const fragment_body *body, const double position[3], const double velocity[3], const double orientation[4],
                            const double angular_velocity[3]);

/* In world axes, rad/s. */
void fragment_angular_velocity(const fragment *f, double rate[3]);

/* Gravity and quadratic drag, N. Lift and the drag of a tumbling body are left out. */
void fragment_own_force(const fragment *f, double force[3]);

/* Moves on by `h` under its own force and the shield's mean force and torque: the impulses are exact. The shield's impulses act
   at the start of each of its internal steps `tick`, s, so they move the fragment F/2m h (h + tick). */
void fragment_step(fragment *f, double h, const double own[3], const double force[3], const double torque[3], double tick);

#endif
