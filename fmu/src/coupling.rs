//! Drive `prescribed`: where the projectile should be at the end of a communication step.
//!
//! Method: the host's pose at the communication point is carried on with its velocity, angular velocity and
//! acceleration to the time of the step's last tick. The acceleration is the host's if it gives one, else
//! last mean force over mass, else 0. The kernel then leads the body there on a path without jumps in pose or
//! rate.
//! Tools start signals at zero and leave ports unconnected. As long as position and velocity have been
//! nothing but zero, the body flies on from where the fabric has it; with a quaternion of zeros it turns on
//! as it does.
//! Reference: docs/model.md, "Prescribed projectile"; M. Arnold, in: Co-simulation (2010).

use crate::parameters::Parameters;
use fabric_kernel::Solid;
use fabric_kernel::exponential;
use fabric_kernel::pose::{self, Vector};
use fabric_kernel::{Motion, Path, Sim, math};

/// Part of the node spacing beyond which the pose is refused: nodes would be jumped over.
const REFUSE: f64 = 1.0;

/// Times of a step, s, counted from its communication point.
pub struct Times {
    /// Time of the fabric's present tick.
    pub now: f64,
    /// Time of the step's last tick.
    pub end: f64,
}

/// A path to follow.
pub struct Plan {
    /// For the kernel.
    pub path: Path,
    /// The body's motion at the communication point, ports that are not connected filled in.
    pub body: Motion,
    /// How far its surface lay from where the fabric has it, m.
    pub gap: f64,
    /// Whether the host has ever given a position or velocity.
    pub driven: bool,
    /// Whether the host's quaternion was only nearly of unit length.
    pub normalised: bool,
}

/// Why a step is refused.
pub enum Refusal {
    /// The input that cannot be used, and why.
    Input(&'static str, &'static str),
    /// Distance of the pose from where the fabric has the body, and both positions, m.
    TooFar(f64, [[f64; 3]; 2]),
}

/// Refuses NaN, infinities and quaternions that are neither of unit length nor zero. True if the quaternion
/// needed normalising.
pub fn check_inputs(motion: &Motion) -> Result<bool, Refusal> {
    finite("projectile.position", &motion.position)?;
    finite("projectile.velocity", &motion.velocity)?;
    finite("projectile.orientation", &motion.orientation)?;
    finite("projectile.angular_velocity", &motion.angular_velocity)?;
    let q = motion.orientation;
    if q == [0.0; 4] {
        return Ok(false);
    }
    let off = math::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) - 1.0;
    if !(off < 1e-3 && off > -1e-3) {
        return Err(Refusal::Input("projectile.orientation", "not a unit quaternion"));
    }
    // A few roundings need no word.
    Ok(!(off < 1e-12 && off > -1e-12))
}

/// Refuses NaN and infinities.
pub fn finite(field: &'static str, values: &[f64]) -> Result<(), Refusal> {
    if values.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Refusal::Input(field, "not a finite number")) }
}

/// The path of one communication step of `ticks` > 0 internal steps. `force` is the last mean force, N;
/// `driven`: whether the host has given a position or velocity before.
pub fn plan(
    inputs: &Parameters,
    sim: &Sim,
    times: &Times,
    ticks: u64,
    force: [f64; 3],
    driven: bool,
) -> Result<Plan, Refusal> {
    let mut body = inputs.body;
    let normalised = check_inputs(&body)?;
    let given = inputs.acceleration;
    finite("projectile.acceleration", &given)?;
    let mass = inputs.scene().projectile.mass;
    let acceleration = if given != [0.0; 3] {
        given
    } else if mass > 0.0 {
        force.map(|f| f / mass)
    } else {
        [0.0; 3]
    };

    let fabric = sim.projectile().map_err(|_| Refusal::Input("", "the simulation has failed"))?;
    let unconnected = carried(&fabric, acceleration, -times.now);
    let driven = driven || body.position != [0.0; 3] || body.velocity != [0.0; 3];
    if !driven {
        (body.position, body.velocity) = (unconnected.position, unconnected.velocity);
    }
    if body.orientation == [0.0; 4] {
        (body.orientation, body.angular_velocity) = (unconnected.orientation, unconnected.angular_velocity);
    }
    let expected = carried(&body, acceleration, times.now);
    let gap = distance(&expected, &fabric, inputs);
    if gap.is_nan() || gap / inputs.scene().sheet.spacing > REFUSE {
        return Err(Refusal::TooFar(gap, [expected.position, fabric.position]));
    }
    let path = Path { first: sim.step_count(), steps: ticks, end: carried(&body, acceleration, times.end) };
    Ok(Plan { path, body, gap, driven, normalised })
}

/// A motion carried on by `t` at constant acceleration and angular velocity.
fn carried(motion: &Motion, acceleration: [f64; 3], t: f64) -> Motion {
    let (p, v, a) = (motion.position, motion.velocity, acceleration);
    let [wx, wy, wz] = motion.angular_velocity;
    let turn = exponential(&(Vector::new(wx, wy, wz) * t));
    Motion {
        position: [
            p[0] + (v[0] + 0.5 * a[0] * t) * t,
            p[1] + (v[1] + 0.5 * a[1] * t) * t,
            p[2] + (v[2] + 0.5 * a[2] * t) * t,
        ],
        velocity: [v[0] + a[0] * t, v[1] + a[1] * t, v[2] + a[2] * t],
        orientation: pose::components(&(turn * pose::normalised(motion.orientation))),
        angular_velocity: motion.angular_velocity,
    }
}

/// How far surface points of the two bodies are apart at most, m.
fn distance(a: &Motion, b: &Motion, inputs: &Parameters) -> f64 {
    let (p, q) = (a.position, b.position);
    let apart = math::length([p[0] - q[0], p[1] - q[1], p[2] - q[2]]);
    let solid = Solid::of(&inputs.scene().projectile);
    if !inputs.scene().projectile_turns() {
        return apart;
    }
    // |q0 - q1| = 2 sin(angle/4); q and -q are the same orientation.
    let (u, v) = (a.orientation, b.orientation);
    let gap = |sign: f64| {
        let d = [u[0] - sign * v[0], u[1] - sign * v[1], u[2] - sign * v[2], u[3] - sign * v[3]];
        math::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[3] * d[3])
    };
    let (same, opposite) = (gap(1.0), gap(-1.0));
    apart + 2.0 * (if same < opposite { same } else { opposite }) * solid.reach()
}
