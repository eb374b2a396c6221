//! Constants derived from a scene once, and the checks of a motion against them.

use crate::body::path::{self, Track};
use crate::body::pose::{Pose, Vector};
use crate::body::projectile::{Inertia, Motion};
use crate::body::shape::Solid;
use crate::ground::error::{Code, Error};
use crate::ground::math;
use crate::ground::planes::Axis;
use crate::scene::parts::{Scene, StepLimits};

/// A body faster than so many spacings a step is lost: what its impulses leave of the nodes is no fabric (see
/// [`crate::yarn::law::LOST`]).
const LOST_SPEED: f64 = 1e30;

/// Constants derived from the scene.
pub(crate) struct Model {
    pub limits: StepLimits,
    pub pose: Pose,
    /// Distance of the projectile's farthest surface point from its centre of mass, m.
    pub reach: f64,
    pub inertia: Inertia,
    /// Mass of a node of the front fabric, all bonded plies, kg.
    pub node_mass: f64,
    /// Mass of a node of the back fabric over that.
    pub back_share: f64,
    /// h/dt, m/s.
    pub unit_speed: f64,
    /// Air between neighbouring plies where they rest, spacings.
    pub gap: f64,
    /// Distance of their middle surfaces where they rest, spacings.
    pub pitch: f64,
    /// m h/dt, N s.
    pub unit_impulse: f64,
    /// m (h/dt)^2, J.
    pub unit_energy: f64,
    /// Volume of a horizontal segment of the front fabric, A_0 l, all bonded plies, m^3.
    pub segment_volume: f64,
    /// Steps in a force window.
    pub window_steps: u64,
}

impl Model {
    /// No constants: a place for those of a scene.
    pub(crate) const NOTHING: Model = Model {
        limits: StepLimits { dt: 0.0, dt_crit: 0.0, step_max: 0.0 },
        pose: Pose::IDENTITY,
        reach: 0.0,
        inertia: Inertia::NOTHING,
        node_mass: 0.0,
        back_share: 1.0,
        unit_speed: 0.0,
        gap: 0.0,
        pitch: 0.0,
        unit_impulse: 0.0,
        unit_energy: 0.0,
        segment_volume: 0.0,
        window_steps: 1,
    };

    /// Constants of a scene. `solid`: the projectile's.
    pub(crate) fn of(scene: &Scene, limits: StepLimits, solid: &Solid) -> Model {
        let (h, dt) = (scene.sheet.spacing, limits.dt);
        let node_mass = scene.lumped_mass();
        let window = math::round(scene.force_window / dt);
        let mut inertia = Inertia::of(solid, scene.projectile.mass, scene.is_free());
        if scene.contact.friction > 0.0 {
            inertia.feel_friction();
        }
        Model {
            limits,
            pose: Pose::of_sheet(&scene.sheet),
            reach: solid.reach(),
            inertia,
            node_mass,
            back_share: if scene.back.plies > 0 { scene.back.node_mass / scene.sheet.node_mass } else { 1.0 },
            unit_speed: h / dt,
            gap: if scene.stack.plies > 1 { scene.stack.gap / h } else { 0.0 },
            pitch: scene.ply_gap() / h,
            unit_impulse: node_mass * h / dt,
            unit_energy: node_mass * (h / dt) * (h / dt),
            segment_volume: scene.lumped_area() * (h / scene.rest_stretch(Axis::Horizontal)),
            window_steps: if window >= 1.0 { window as u64 } else { 1 },
        }
    }

    /// Whether surface points cross a node spacing in a step, or the body turns more than half a radian.
    pub(crate) fn too_fast(&self, speed: f64, rate: f64) -> bool {
        let turning = if self.inertia.turns { rate } else { 0.0 };
        let within = self.surface_speed(speed, rate) < self.unit_speed && self.limits.dt * turning <= 0.5;
        !within
    }

    /// The refusal of a motion that is too fast. It names the largest step, s, with which it is not.
    fn too_fast_error(&self, field: &'static str, speed: f64, rate: f64) -> Error {
        let crossing = self.unit_speed * self.limits.dt / self.surface_speed(speed, rate);
        let turning = 0.5 / rate;
        let largest = if self.inertia.turns && turning < crossing { turning } else { crossing };
        // A few roundings less: the bound itself is too fast, and the number is to be of use as it stands.
        Error::new(Code::ProjectileTooFast, field, speed, largest * (1.0 - 8.0 * f64::EPSILON))
    }

    /// Whether a body is so fast that its impulses on the nodes leave no state that is one.
    pub(crate) fn loses_body(&self, speed: f64, rate: f64) -> bool {
        let within = self.surface_speed(speed, rate) <= LOST_SPEED * self.unit_speed;
        !within
    }

    /// The speed that no point of the body's surface exceeds, m/s.
    fn surface_speed(&self, speed: f64, rate: f64) -> f64 {
        // A body that does not turn may be of any size: 0 times an infinite reach is no number.
        let turns = self.inertia.turns && rate != 0.0;
        speed + if turns { rate * self.reach } else { 0.0 }
    }

    /// Whether the body's kinetic energy at this rate and any accepted speed is too large for a number.
    fn energy_overflows(&self, rate: f64) -> bool {
        let spin = self.inertia.moments * (1.0 + rate * rate);
        let largest = self.inertia.mass * self.unit_speed * self.unit_speed + spin.x + spin.y + spin.z;
        !largest.is_finite()
    }

    pub(crate) fn check_speed(&self, motion: &Motion) -> Result<(), Error> {
        let (speed, rate) = (math::length(motion.velocity), math::length(motion.angular_velocity));
        if self.too_fast(speed, rate) {
            return Err(self.too_fast_error("projectile.velocity", speed, rate));
        }
        if self.energy_overflows(rate) {
            return Err(Error::new(Code::OutOfRange, "projectile.mass", self.inertia.mass, 0.0));
        }
        Ok(())
    }

    /// Speed bound of a path: the derivative of the cubic lies in the hull of its ends and
    /// 3 (P1 - P0)/T - V0 - V1.
    pub(crate) fn check_track(&self, track: &Track) -> Result<(), Error> {
        let duration = track.steps as f64 * self.limits.dt;
        let (start, end) = (&track.start, &track.end);
        let chord = (end.position - start.position) * (3.0 / duration);
        let rotation = path::rotation_vector(&(start.orientation.conjugate() * end.orientation)) * (3.0 / duration);
        let speeds = [start.velocity, end.velocity, chord - start.velocity - end.velocity];
        let rates =
            [start.angular_velocity, end.angular_velocity, rotation - start.angular_velocity - end.angular_velocity];
        let largest = |vectors: [Vector; 3]| {
            vectors.iter().map(|v| math::length([v.x, v.y, v.z])).fold(0.0, |a, b| math::max(b, a))
        };
        let (speed, rate) = (largest(speeds), largest(rates));
        if self.too_fast(speed, rate) {
            return Err(self.too_fast_error("path.velocity", speed, rate));
        }
        if self.energy_overflows(rate) {
            return Err(Error::new(Code::OutOfRange, "path.angular_velocity", rate, 0.0));
        }
        Ok(())
    }
}

/// The projectile's motion at the start, host's frame.
pub(crate) fn start_motion(scene: &Scene) -> Motion {
    let body = &scene.projectile;
    Motion {
        position: body.position,
        velocity: body.velocity,
        orientation: body.orientation,
        angular_velocity: body.angular_velocity,
    }
}
