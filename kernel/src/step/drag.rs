//! Drag: a force on the projectile against its velocity.
//!
//! Method: before contact v becomes v - c v dt/M; the work counts as that of the external load.
//! Limits: c dt << M; no torque.
//! Reference: Stokes's law.

use crate::memory::system::System;

/// Slows the body during dt.
#[inline(never)]
pub(crate) fn slow(system: &mut System<'_>, dt: f64) {
    let (before, body) = (system.state.body.velocity, &mut system.state.body);
    body.velocity -= before * (system.scene.contact.drag * dt * system.model.inertia.inverse_mass);
    let force = before * -system.scene.contact.drag;
    system.state.sums.external_work += force.dot(&((before + body.velocity) * 0.5)) * dt;
    system.state.sums.external_impulse += force * dt;
}
