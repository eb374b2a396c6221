//! The projectile's part of a step: prescribed rates, external load, motion, and the refusal of a body that
//! is too fast or lost.
//!
//! Method: a free body takes the impulse of its load, F dt, before contact, and drifts with the velocity
//! after contact (`body/projectile.rs`). A prescribed body has the mean rates of the step from its path
//! (`body/path.rs`), and so ends at the path's pose. Work of the load is force times the mean of the
//! velocities before and after the step.
//! Limits: the load is constant in a step. In a step a body turns by less than half a radian, and no point of
//! its surface crosses a spacing.
//! Reference: docs/model.md, "Prescribed projectile"; L. Verlet, Phys. Rev. 159 (1967) 98.

use crate::body::path;
use crate::body::pose::{self, Vector};
use crate::body::projectile::{self, Body};
use crate::ground::error::Failure;
use crate::ground::math;
use crate::memory::model::Model;
use crate::memory::network::Network;
use crate::memory::state::State;

/// Refuses a body whose motion, or a sum over its impulses, is no number, before anyone reads it.
pub(crate) fn refuse_lost_body(model: &Model, state: &State) -> Result<(), Failure> {
    let (body, sums) = (&state.body, &state.sums);
    let vectors = [
        &body.position,
        &body.velocity,
        &body.angular_velocity,
        &sums.impulse,
        &sums.angular_impulse,
        &sums.external_impulse,
    ];
    let finite = vectors.iter().all(|vector| vector.iter().all(|x| x.is_finite()))
        && body.orientation.coords.iter().all(|x| x.is_finite())
        && [sums.work, sums.loss, sums.friction, sums.external_work, sums.viscous].iter().all(|x| x.is_finite());
    let (v, w) = (body.velocity, body.angular_velocity);
    let lost = model.loses_body(math::length([v.x, v.y, v.z]), math::length([w.x, w.y, w.z]));
    if finite && !lost { Ok(()) } else { Err(Failure::NonFinite) }
}

/// A prescribed body on a path (M13): sets its rates for this step and returns its pose at the step's end.
/// After a path it coasts with the rates the path ended with.
pub(crate) fn prescribe_twist(network: &Network<'_>, state: &mut State) -> Option<(Vector, nalgebra::Quaternion<f64>)> {
    if network.scene.is_free() {
        return None;
    }
    let track = &state.track;
    let end = track.first + track.steps;
    if track.steps == 0 || state.step >= end {
        if track.steps > 0 && state.step == end {
            state.body.velocity = track.end.velocity;
            state.body.angular_velocity = track.end.angular_velocity;
        }
        return None;
    }
    let dt = network.model.limits.dt;
    let elapsed = (state.step - track.first) as f64 + 1.0;
    let (position, orientation) = track.pose(elapsed, dt);
    state.body.velocity = (position - state.body.position) / dt;
    state.body.angular_velocity = path::cayley_rate(&state.body.orientation, &orientation, dt);
    Some((position, orientation))
}

/// Refuses a body whose motion is not finite, or that [`Model::too_fast`] refuses.
///
/// [`Model::too_fast`]: crate::memory::model::Model::too_fast
pub(crate) fn refuse_too_fast(model: &Model, body: &Body) -> Result<(), Failure> {
    let (v, w) = (body.velocity, body.angular_velocity);
    let (speed, rate) = (math::length([v.x, v.y, v.z]), math::length([w.x, w.y, w.z]));
    if !(speed.is_finite() && rate.is_finite()) {
        return Err(Failure::NonFinite);
    }
    if model.too_fast(speed, rate) { Err(Failure::TooFast) } else { Ok(()) }
}

/// The external load on the body during a step.
pub(crate) fn load_body(network: &Network<'_>, state: &mut State) {
    let (force, torque, dt) = (state.force, state.torque, network.model.limits.dt);
    if network.scene.is_free() {
        let body = &mut state.body;
        body.velocity += force * (dt * network.model.inertia.inverse_mass);
        if network.model.inertia.turns {
            let twist = pose::into_body(&body.orientation, &(torque * dt));
            body.angular_velocity += twist.component_mul(&network.model.inertia.inverse_moments);
        }
    }
}

/// The external load's work and impulse during a step.
pub(crate) fn add_load(network: &Network<'_>, state: &mut State, before: &Body) {
    let (force, torque, dt) = (state.force, state.torque, network.model.limits.dt);
    if network.scene.is_free() {
        let mean = (before.velocity + state.body.velocity) * 0.5;
        let mut work = force.dot(&mean) * dt;
        if network.model.inertia.turns {
            let spin = (before.angular_velocity + state.body.angular_velocity) * 0.5;
            work += pose::into_body(&before.orientation, &torque).dot(&spin) * dt;
        }
        state.sums.external_work += work;
        state.sums.external_impulse += force * dt;
    }
}

/// Moves the body by its velocity, or to the place and orientation `target`.
pub(crate) fn move_body(network: &Network<'_>, state: &mut State, target: Option<(Vector, nalgebra::Quaternion<f64>)>) {
    let dt = network.model.limits.dt;
    match (network.scene.is_free(), target) {
        (true, _) => state.body.drift(&network.model.inertia, network.scene.rotation_rule, dt),
        (false, Some((position, orientation))) => {
            state.body.position = position;
            state.body.orientation = orientation;
        }
        (false, None) => {
            state.body.position += state.body.velocity * dt;
            if network.model.inertia.turns {
                let w = state.body.angular_velocity;
                state.body.orientation = projectile::cayley_turn(&state.body.orientation, &w, dt);
            }
        }
    }
}
