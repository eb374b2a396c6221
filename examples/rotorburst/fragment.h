/* A rigid fragment in free flight, six degrees of freedom: fragment.py in C, for the host in C and for the fragment's own FMU.

   Axes: x and y in the plane of the sheet, y up, z along the flight. Units are SI. Quaternions are scalar first and turn body
   vectors into world vectors; the body's z axis is the fragment's axis. */
#ifndef FRAGMENT_H
#define FRAGMENT_H

typedef struct {
    double radius;           /* m */
    double length;           /* along the axis, m; 0 for a sphere, else a flat-ended cylinder */
    double mass;             /* kg */
    double drag_coefficient; /* of the frontal area pi radius^2 */
} fragment_body;

/* Rotation is kept as angular momentum in world axes, so that an angular impulse is simply added. */
typedef struct {
    fragment_body body;
    double position[3];         /* centre of mass, m */
    double velocity[3];         /* m/s */
    double orientation[4];      /* unit quaternion */
    double angular_momentum[3]; /* about the centre of mass, N m s */
} fragment;

/* Its front `distance` before the plane z = 0, flying along z; `spin` about its axis, rad/s, axis tilted by `tilt`, rad. */
fragment fragment_launched(const fragment_body *body, double distance, double speed, double spin, double tilt);

/* z of the foremost point, m. */
double fragment_front(const fragment *f);

/* World axes, rad/s. */
void fragment_angular_velocity(const fragment *f, double rate[3]);

/* Gravity and quadratic drag, N. Lift and the drag of a tumbling body are left out. */
void fragment_own_force(const fragment *f, double force[3]);

/* Moves on by `h` under its own force and the shield's mean force and torque: the impulses are exact. The shield's impulses act
   at the start of each of its internal steps `tick`, s, so they move the fragment F/2m h (h + tick). */
void fragment_step(fragment *f, double h, const double own[3], const double force[3], const double torque[3], double tick);

/* The quaternion `a` of a rotation vector, rad, times `b`: first b, then the rotation. */
void fragment_turned(const double turn[3], const double b[4], double result[4]);

#endif
