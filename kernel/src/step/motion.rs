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
use crate::memory::system::System;

/// Refuses a body whose motion, or a sum over its impulses, is no number, before anyone reads it.
pub(crate) fn refuse_lost_body(system: &System<'_>) -> Result<(), Failure> {
    let (body, sums) = (&system.state.body, &system.state.sums);
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
    let lost = system.model.loses_body(math::length([v.x, v.y, v.z]), math::length([w.x, w.y, w.z]));
    if finite && !lost { Ok(()) } else { Err(Failure::NonFinite) }
}

/// A prescribed body on a path (M13): sets its rates for this step and returns its pose at the step's end.
/// After a path it coasts with the rates the path ended with.
pub(crate) fn prescribe_twist(system: &mut System<'_>) -> Option<(Vector, nalgebra::Quaternion<f64>)> {
    if system.scene.is_free() {
        return None;
    }
    let state = &mut system.state;
    let track = &state.track;
    let end = track.first + track.steps;
    if track.steps == 0 || state.step >= end {
        if track.steps > 0 && state.step == end {
            state.body.velocity = track.end.velocity;
            state.body.angular_velocity = track.end.angular_velocity;
        }
        return None;
    }
    let dt = system.model.limits.dt;
    let elapsed = (state.step - track.first) as f64 + 1.0;
    let (position, orientation) = track.pose(elapsed, dt);
    state.body.velocity = (position - state.body.position) / dt;
    state.body.angular_velocity = path::cayley_rate(&state.body.orientation, &orientation, dt);
    Some((position, orientation))
}

/// Refuses a body whose motion is not finite, or that [`Model::too_fast`] refuses.
///
/// [`Model::too_fast`]: crate::memory::model::Model::too_fast
pub(crate) fn refuse_too_fast(system: &System<'_>) -> Result<(), Failure> {
    let body = &system.state.body;
    let (v, w) = (body.velocity, body.angular_velocity);
    let (speed, rate) = (math::length([v.x, v.y, v.z]), math::length([w.x, w.y, w.z]));
    if !(speed.is_finite() && rate.is_finite()) {
        return Err(Failure::NonFinite);
    }
    if system.model.too_fast(speed, rate) { Err(Failure::TooFast) } else { Ok(()) }
}

/// The external load on the body during a step.
pub(crate) fn load_body(system: &mut System<'_>) {
    let (force, torque, dt) = (system.state.force, system.state.torque, system.model.limits.dt);
    if system.scene.is_free() {
        let body = &mut system.state.body;
        body.velocity += force * (dt * system.model.inertia.inverse_mass);
        if system.model.inertia.turns {
            let twist = pose::into_body(&body.orientation, &(torque * dt));
            body.angular_velocity += twist.component_mul(&system.model.inertia.inverse_moments);
        }
    }
}

/// The external load's work and impulse during a step.
pub(crate) fn add_load(system: &mut System<'_>, before: &Body) {
    let (force, torque, dt) = (system.state.force, system.state.torque, system.model.limits.dt);
    if system.scene.is_free() {
        let mean = (before.velocity + system.state.body.velocity) * 0.5;
        let mut work = force.dot(&mean) * dt;
        if system.model.inertia.turns {
            let spin = (before.angular_velocity + system.state.body.angular_velocity) * 0.5;
            work += pose::into_body(&before.orientation, &torque).dot(&spin) * dt;
        }
        system.state.sums.external_work += work;
        system.state.sums.external_impulse += force * dt;
    }
}

/// Moves the body by its velocity, or to the place and orientation `target`.
pub(crate) fn move_body(system: &mut System<'_>, target: Option<(Vector, nalgebra::Quaternion<f64>)>) {
    let dt = system.model.limits.dt;
    let state = &mut system.state;
    match (system.scene.is_free(), target) {
        (true, _) => state.body.drift(&system.model.inertia, system.scene.rotation_rule, dt),
        (false, Some((position, orientation))) => {
            state.body.position = position;
            state.body.orientation = orientation;
        }
        (false, None) => {
            state.body.position += state.body.velocity * dt;
            if system.model.inertia.turns {
                let w = state.body.angular_velocity;
                state.body.orientation = projectile::cayley_turn(&state.body.orientation, &w, dt);
            }
        }
    }
}
