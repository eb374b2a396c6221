//! The scalar state of a simulation: everything a snapshot holds in addition to the node and segment arrays.

use crate::body::path::Track;
use crate::body::pose::Vector;
use crate::body::projectile::Body;
use crate::memory::watch::{FirstContact, Latch, Watch};
use crate::scene::features::{Feature, Features};
use crate::scene::parts::{AttachmentKind, Symmetry};
use crate::sheet::symmetry;
use crate::sheet::weave::ATTACHMENTS;
use nalgebra::Quaternion;

/// Running sums and extremes. Vectors in the sheet's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sums {
    /// Impulse of contact on the projectile, N s.
    pub impulse: Vector,
    /// Angular impulse of contact on the projectile about its moving centre of mass, N m s.
    pub angular_impulse: Vector,
    /// Work of the projectile on the fabric, J.
    pub work: f64,
    /// Kinetic energy lost in restitution-zero impacts, J.
    pub loss: f64,
    /// Impulse of the external load, N s.
    pub external_impulse: Vector,
    /// Work of the external load, J.
    pub external_work: f64,
    /// Impulse of sheet and projectile on each attachment, in units of m h/dt.
    pub support: [Vector; ATTACHMENTS],
    /// Impulse of the sheet on its case, in units of m h/dt.
    pub casing: Vector,
    /// Kinetic energy lost on the case, J.
    pub casing_loss: f64,
    /// Impulse on the projectile in the running force window, N s.
    pub window: Vector,
    /// Largest mean force over a window so far, N.
    pub force_peak: f64,
    /// Deepest penetration met, fixed nodes in a prescribed body among them, m.
    pub worst_penetration: f64,
    /// Nodal impulses so far.
    pub impulses: u64,
    /// Nodes with an impulse in the last step.
    pub contacts: u64,
    /// Contact solves that ran out of sweeps.
    pub unconverged: u64,
    /// Most sweeps of one solve.
    pub most_sweeps: u64,
    /// Largest residual of the laws in solves that ran out of sweeps, m/s.
    pub contact_residual: f64,
    /// Most candidates of one step.
    pub most_candidates: u64,
    /// Steps in which the body met the sheet beyond the fine part of a graded network.
    pub beyond_fine: u64,
    /// Iterations of the theta rule, all steps together.
    pub iterations: u64,
    /// Most iterations of one step.
    pub most_iterations: u64,
    /// Energy that viscosity and rate have dissipated, J.
    pub viscous: f64,
    /// Energy rubbed away between nodes and projectile, J.
    pub friction: f64,
    /// Kinetic energy lost where plies meet, J.
    pub ply_loss: f64,
    /// Deepest that facing nodes of two plies have been through each other, m.
    pub ply_penetration: f64,
    /// Work of the projectile on fixed nodes, J.
    pub support_work: f64,
    /// Energy dissipated in slipping clamps, J.
    pub attachment: f64,
    /// Impulse on each attachment when the running force window began, in units of m h/dt.
    pub window_support: [Vector; ATTACHMENTS],
    /// Mean force on each attachment over the last window, N.
    pub support_force: [f64; ATTACHMENTS],
    /// Step at which each attachment let go; 0: it has not.
    pub let_go: [u64; ATTACHMENTS],
    /// Energy the audit starts from, J.
    pub first_energy: f64,
    /// Momentum the audit starts from, N s.
    pub first_momentum: Vector,
}

impl Sums {
    /// Sums before the first step.
    pub const NOTHING: Sums = Sums {
        impulse: ZERO,
        angular_impulse: ZERO,
        work: 0.0,
        loss: 0.0,
        external_impulse: ZERO,
        external_work: 0.0,
        support: [ZERO; ATTACHMENTS],
        casing: ZERO,
        casing_loss: 0.0,
        window: ZERO,
        force_peak: 0.0,
        worst_penetration: 0.0,
        impulses: 0,
        contacts: 0,
        unconverged: 0,
        most_sweeps: 0,
        contact_residual: 0.0,
        most_candidates: 0,
        beyond_fine: 0,
        iterations: 0,
        most_iterations: 0,
        viscous: 0.0,
        friction: 0.0,
        ply_loss: 0.0,
        ply_penetration: 0.0,
        support_work: 0.0,
        attachment: 0.0,
        window_support: [ZERO; ATTACHMENTS],
        support_force: [0.0; ATTACHMENTS],
        let_go: [0; ATTACHMENTS],
        first_energy: 0.0,
        first_momentum: ZERO,
    };
}

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
    /// Steps since the load began: since the first contact, or since motion was given by hand; 0 before.
    /// Counted for yarn that depends on the rate.
    pub loaded: u64,
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
            loaded: 0,
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
        self.sums.visit(visitor);
        if features.has(Feature::Theta) {
            visitor.count(&mut self.sums.iterations);
            visitor.count(&mut self.sums.most_iterations);
        }
        if features.dissipate() {
            visitor.real(&mut self.sums.viscous);
        }
        if features.has(Feature::Rate) {
            visitor.count(&mut self.loaded);
        }
        if features.has(Feature::Friction) {
            visitor.real(&mut self.sums.friction);
        }
        if features.has(Feature::Plies) {
            visitor.real(&mut self.sums.ply_loss);
            visitor.real(&mut self.sums.ply_penetration);
        }
        if features.has(Feature::Grading) {
            visitor.count(&mut self.sums.beyond_fine);
        }
        if features.has(Feature::Casing) {
            visitor.vector(&mut self.sums.casing);
            visitor.real(&mut self.sums.casing_loss);
        }
        if features.has(Feature::Clamps) {
            visitor.real(&mut self.sums.attachment);
            self.sums.window_support.iter_mut().for_each(|impulse| visitor.vector(impulse));
            self.sums.support_force.iter_mut().for_each(|force| visitor.real(force));
            self.sums.let_go.iter_mut().for_each(|step| visitor.count(step));
        }
        visit_watch(&mut self.watch, features, visitor);
    }
}

impl Sums {
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
        for turn in symmetry.images() {
            if let Some(sum) = self.support.get_mut(symmetry::attachment_image(kind, attachment, turn)) {
                *sum += symmetry::turned(pull, turn);
            }
        }
    }

    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.vector(&mut self.impulse);
        visitor.vector(&mut self.angular_impulse);
        visitor.real(&mut self.work);
        visitor.real(&mut self.loss);
        visitor.vector(&mut self.external_impulse);
        visitor.real(&mut self.external_work);
        for support in &mut self.support {
            visitor.vector(support);
        }
        visitor.vector(&mut self.window);
        visitor.real(&mut self.force_peak);
        visitor.real(&mut self.worst_penetration);
        visitor.count(&mut self.impulses);
        visitor.count(&mut self.contacts);
        visitor.count(&mut self.unconverged);
        visitor.count(&mut self.most_sweeps);
        visitor.count(&mut self.most_candidates);
        visitor.real(&mut self.support_work);
        visitor.real(&mut self.first_energy);
        visitor.vector(&mut self.first_momentum);
        visitor.real(&mut self.contact_residual);
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
