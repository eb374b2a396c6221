//! The scalar state of a simulation: everything a snapshot holds in addition to the node and segment arrays.

use crate::body::path::Track;
use crate::body::pose::Vector;
use crate::body::projectile::Body;
use crate::ground::math;
use crate::memory::watch::{FirstContact, Latch, Watch};
use crate::scene::features::{Feature, Features};
use crate::scene::parts::{AttachmentKind, Symmetry};
use crate::sheet::symmetry;
use crate::sheet::weave::ATTACHMENTS;
use nalgebra::Quaternion;

/// Table of the sums: name, kind, and condition on which an image holds it, with meaning and unit; in the
/// order of images.
macro_rules! sums {
    ($features:ident; $($(#[$meaning:meta])* $sum:ident: $kind:ty, $kept:expr;)*) => {
        /// Running sums and extremes. Vectors in the sheet's frame.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Sums {
            $($(#[$meaning])* pub $sum: $kind,)*
        }

        impl Sums {
            /// Sums before the first step.
            pub const NOTHING: Sums = Sums { $($sum: <$kind as Sum>::ZERO,)* };

            /// Shows the sums that an image holds to a visitor.
            fn visit(&mut self, $features: Features, visitor: &mut dyn Visitor) {
                $(if $kept {
                    self.$sum.visit(visitor);
                })*
            }
        }
    };
}

sums! { features;
    /// Impulse of contact on the projectile, N s.
    impulse: Vector, true;
    /// Angular impulse of contact on the projectile about its moving centre of mass, N m s.
    angular_impulse: Vector, true;
    /// Work of the projectile on the fabric, J.
    work: f64, true;
    /// Kinetic energy lost in restitution-zero impacts, J.
    loss: f64, true;
    /// Impulse of the external load, N s.
    external_impulse: Vector, true;
    /// Work of the external load, J.
    external_work: f64, true;
    /// Impulse of sheet and projectile on each attachment, in units of m h/dt.
    support: [Vector; ATTACHMENTS], true;
    /// Impulse on the projectile in the running force window, N s.
    window: Vector, true;
    /// Largest mean force over a window so far, N.
    force_peak: f64, true;
    /// Deepest penetration met, fixed nodes in a prescribed body among them, m.
    worst_penetration: f64, true;
    /// Nodal impulses so far.
    impulses: u64, true;
    /// Nodes with an impulse in the last step.
    contacts: u64, true;
    /// Contact solves that ran out of sweeps.
    unconverged: u64, true;
    /// Most sweeps of one solve.
    most_sweeps: u64, true;
    /// Most candidates of one step.
    most_candidates: u64, true;
    /// Work of the projectile on fixed nodes, J.
    support_work: f64, true;
    /// Energy the audit starts from, J.
    first_energy: f64, true;
    /// Momentum the audit starts from, N s.
    first_momentum: Vector, true;
    /// Largest residual of the laws in solves that ran out of sweeps, m/s.
    contact_residual: f64, true;
    /// Iterations of the theta rule, all steps together.
    iterations: u64, features.has(Feature::Theta);
    /// Most iterations of one step.
    most_iterations: u64, features.has(Feature::Theta);
    /// Energy that viscosity and rate have dissipated, J.
    viscous: f64, features.dissipate();
    /// Steps since the load began: since the first contact, or since motion was given by hand; 0 before.
    /// Counted for yarn that depends on the rate.
    loaded: u64, features.has(Feature::Rate);
    /// Energy rubbed away between nodes and projectile, J.
    friction: f64, features.has(Feature::Friction);
    /// Kinetic energy lost where plies meet, J.
    ply_loss: f64, features.has(Feature::Plies);
    /// Deepest that facing nodes of two plies have been through each other, m.
    ply_penetration: f64, features.has(Feature::Plies);
    /// Steps in which the body met the sheet beyond the fine part of a graded network.
    beyond_fine: u64, features.has(Feature::Grading);
    /// Energy by which what contact impulses dissipate together would have fallen, J, in all steps.
    gained: f64, features.share_losses();
    /// Case under a ring.
    casing: CasingSums, features.has(Feature::Casing);
    /// Attachments that slip.
    clamps: ClampSums, features.has(Feature::Clamps);
    /// Energy that clamps have dissipated in this step on nodes that contact then pushed, J; 0 between steps.
    work_of_pushed: f64, false;
}

/// Sums of attachments that slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClampSums {
    /// Energy dissipated in slipping clamps, J.
    pub dissipated: f64,
    /// Impulse on each attachment when the running force window began, in units of m h/dt.
    pub window_support: [Vector; ATTACHMENTS],
    /// Mean force on each attachment over the last window, N.
    pub support_force: [f64; ATTACHMENTS],
    /// Step at which each attachment let go; 0: it has not.
    pub let_go: [u64; ATTACHMENTS],
}

/// Sums of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CasingSums {
    /// Impulse of the sheet on its case, in units of m h/dt.
    pub impulse: Vector,
    /// Kinetic energy lost on the case, J.
    pub loss: f64,
}

/// Kind of a sum.
trait Sum {
    /// Sum of nothing.
    const ZERO: Self;

    /// Shows its numbers to a visitor.
    fn visit(&mut self, visitor: &mut dyn Visitor);
}

impl Sum for f64 {
    const ZERO: f64 = 0.0;

    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.real(self);
    }
}

impl Sum for u64 {
    const ZERO: u64 = 0;

    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.count(self);
    }
}

impl Sum for Vector {
    const ZERO: Vector = ZERO;

    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.vector(self);
    }
}

impl<T: Sum, const N: usize> Sum for [T; N] {
    const ZERO: [T; N] = [T::ZERO; N];

    fn visit(&mut self, visitor: &mut dyn Visitor) {
        self.iter_mut().for_each(|sum| sum.visit(visitor));
    }
}

impl Sum for ClampSums {
    const ZERO: ClampSums =
        ClampSums { dissipated: 0.0, window_support: Sum::ZERO, support_force: Sum::ZERO, let_go: Sum::ZERO };

    fn visit(&mut self, visitor: &mut dyn Visitor) {
        self.dissipated.visit(visitor);
        self.window_support.visit(visitor);
        self.support_force.visit(visitor);
        self.let_go.visit(visitor);
    }
}

impl Sum for CasingSums {
    const ZERO: CasingSums = CasingSums { impulse: Sum::ZERO, loss: 0.0 };

    fn visit(&mut self, visitor: &mut dyn Visitor) {
        self.impulse.visit(visitor);
        self.loss.visit(visitor);
    }
}

/// Rounding of what the impulses of a step dissipate, over the work of the projectile so far.
const ROUNDING: f64 = 1e-12;

const ZERO: Vector = Vector::new(0.0, 0.0, 0.0);

/// No count of steps, impulses or nodes gets beyond this: a real number still holds it exactly, and sums
/// cannot overflow.
pub const COUNT_MAX: u64 = 1 << 53;

/// Scalar state at step count n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Step count n; the time is n dt.
    pub step: u64,
    /// The projectile.
    pub body: Body,
    /// External force on it, N, sheet's frame.
    pub force: Vector,
    /// External torque on it, N m, sheet's frame.
    pub torque: Vector,
    /// Path being followed (prescribed body).
    pub track: Track,
    /// Sums and extremes.
    pub sums: Sums,
    /// Outcome tests.
    pub watch: Watch,
}

impl State {
    /// The state at rest before the first step.
    pub const fn at_start(body: Body) -> State {
        State {
            step: 0,
            body,
            force: ZERO,
            torque: ZERO,
            track: Track { first: 0, steps: 0, start: body, end: body },
            sums: Sums::NOTHING,
            watch: Watch::NOTHING,
        }
    }

    /// Shows every number to a visitor, which may read or replace it: one traversal serves saving, loading
    /// and the digest.
    pub fn visit(&mut self, features: Features, visitor: &mut dyn Visitor) {
        visitor.count(&mut self.step);
        visit_body(&mut self.body, visitor);
        visitor.vector(&mut self.force);
        visitor.vector(&mut self.torque);
        visitor.count(&mut self.track.first);
        visitor.count(&mut self.track.steps);
        visit_body(&mut self.track.start, visitor);
        visit_body(&mut self.track.end, visitor);
        self.sums.visit(features, visitor);
        visit_watch(&mut self.watch, features, visitor);
    }
}

impl Sums {
    /// Energies dissipated by impulses on nodes, J: by the projectile, friction, plies, a case, clamps.
    pub fn losses(&mut self) -> [&mut f64; 5] {
        [&mut self.loss, &mut self.friction, &mut self.ply_loss, &mut self.casing.loss, &mut self.clamps.dissipated]
    }

    /// Splits what the impulses of a step have dissipated so that no part falls: friction that turns a slip
    /// around, say, is part of the loss on the projectile. What is dissipated in all by less than nothing is
    /// no dissipation but energy from nothing, which stays in the residual. `before`: losses before the step.
    pub fn share_losses(&mut self, before: [f64; 5]) {
        let falls = |sums: &mut Sums| {
            let parts = sums.losses().into_iter().zip(before);
            parts.fold(0.0, |sum, (part, before)| sum + math::max(before - *part, 0.0))
        };
        let mut owed = falls(self);
        if owed > ROUNDING * math::abs(self.work) {
            for (part, before) in self.losses().into_iter().zip(before) {
                *part = math::max(*part, before);
            }
            for (part, before) in self.losses().into_iter().zip(before) {
                let given = math::min(owed, *part - before);
                (*part, owed) = (*part - given, owed - given);
            }
            self.gained += owed;
        }
    }

    /// Adds a pull of the sheet or a push of the projectile, in units of m h/dt, to an attachment and its
    /// images to theirs.
    #[inline(always)] // Every row of every step comes here, and the rows of all bands in turn.
    pub fn add_to_support(&mut self, kind: AttachmentKind, attachment: usize, pull: &Vector, symmetry: Symmetry) {
        if symmetry != Symmetry::default() {
            return self.add_to_supports(kind, attachment, pull, symmetry);
        }
        if let Some(sum) = self.support.get_mut(attachment) {
            *sum += pull;
        }
    }

    fn add_to_supports(&mut self, kind: AttachmentKind, attachment: usize, pull: &Vector, symmetry: Symmetry) {
        for mirrored in symmetry.images() {
            if let Some(sum) = self.support.get_mut(symmetry::attachment_image(kind, attachment, mirrored)) {
                *sum += symmetry::mirrored(pull, mirrored);
            }
        }
    }
}

fn visit_body(body: &mut Body, visitor: &mut dyn Visitor) {
    visitor.vector(&mut body.position);
    let Quaternion { coords } = &mut body.orientation;
    for component in coords.iter_mut() {
        visitor.real(component);
    }
    visitor.vector(&mut body.velocity);
    visitor.vector(&mut body.angular_velocity);
}

fn visit_watch(watch: &mut Watch, features: Features, visitor: &mut dyn Visitor) {
    let (through, clamps) = (features.has(Feature::Through), features.has(Feature::Clamps));
    let none = FirstContact { step: 0, direction: Vector::zeros(), kinetic_energy: 0.0 };
    visit_option(&mut watch.first, none, visitor, |first, visitor| {
        visitor.count(&mut first.step);
        visitor.vector(&mut first.direction);
        visitor.real(&mut first.kinetic_energy);
    });
    visitor.vector(&mut watch.checkpoint);
    visitor.real(&mut watch.checkpoint_work);
    visitor.count(&mut watch.checkpoint_impulses);
    if through {
        visitor.real(&mut watch.travel_start);
        visitor.real(&mut watch.travel_speed);
    }
    let [arrested, detached, exited, passed, is_through, rebounded, let_go] = &mut watch.latched;
    let optional = through.then_some(is_through).into_iter().chain(clamps.then_some(let_go));
    for latch in [arrested, detached, exited, passed, rebounded].into_iter().chain(optional) {
        visit_option(latch, Latch { step: 0, work: 0.0 }, visitor, |latch, visitor| {
            visitor.count(&mut latch.step);
            visitor.real(&mut latch.work);
        });
    }
}

/// An option is a flag (0 or 1) and its content, which is there in either case.
fn visit_option<T: Copy>(
    option: &mut Option<T>,
    none: T,
    visitor: &mut dyn Visitor,
    content: impl Fn(&mut T, &mut dyn Visitor),
) {
    let mut flag = u64::from(option.is_some());
    let mut value = option.unwrap_or(none);
    visitor.flag(&mut flag);
    content(&mut value, visitor);
    *option = (flag == 1).then_some(value);
}

/// Sees every number of the state in a fixed order.
pub trait Visitor {
    /// A 64-bit count.
    fn count(&mut self, value: &mut u64);

    /// A flag, 0 or 1.
    fn flag(&mut self, value: &mut u64) {
        self.count(value);
    }

    /// A real number.
    fn real(&mut self, value: &mut f64);

    /// A vector, x first.
    fn vector(&mut self, value: &mut Vector) {
        for component in value.iter_mut() {
            self.real(component);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parts that fall are taken from the others, and only what all lose together is from nothing.
    #[test]
    fn losses_are_shared_so_that_none_falls() {
        let before = [4.0, 3.0, 2.0, 1.0, 0.0];
        for (changes, shared, gained) in [
            ([0.5, 0.25, 0.0, 0.0, 1.0], [0.5, 0.25, 0.0, 0.0, 1.0], 0.0),
            ([0.5, -0.25, 0.0, 0.0, 0.0], [0.25, 0.0, 0.0, 0.0, 0.0], 0.0),
            ([-0.5, 0.25, -0.25, 2.0, 0.0], [0.0, 0.0, 0.0, 1.5, 0.0], 0.0),
            ([0.25, -1.0, 0.0, 0.0, 0.25], [0.0; 5], 0.5),
        ] {
            let mut sums = Sums { work: 10.0, ..Sums::NOTHING };
            for (k, part) in sums.losses().into_iter().enumerate() {
                *part = before[k] + changes[k];
            }
            sums.share_losses(before);
            assert_eq!(sums.losses().map(|part| *part), [0, 1, 2, 3, 4].map(|k| before[k] + shared[k]));
            assert_eq!(sums.gained, gained);
        }
    }
}
