//! Values of inputs and parameters as the host set them, and the scene they make.

use crate::table::{COUNT, Id, Kind, OFFSETS, Role, SLOTS, STARTS, VARIABLES, Variable};
use fabric::pose::into_body;
use fabric::pose::{self, Vector};
use fabric::shape::Solid;
use fabric::{AttachmentKind, Drive, Motion, Scene, Shape, TimeStep};

/// Distance of the projectile's nose from the sheet if no position is given, m.
const STAND_OFF: f64 = 1e-3;

/// Inputs and parameters: numbers in table order. Integers, choices and truth values are kept as whole numbers.
#[derive(Clone, Copy)]
pub struct Parameters {
    values: [f64; SLOTS],
    /// Which variables the host has set itself; a preset leaves those alone.
    given: [bool; COUNT],
}

impl Default for Parameters {
    fn default() -> Parameters {
        Parameters { values: STARTS, given: [false; COUNT] }
    }
}

impl Parameters {
    /// All elements of an input or parameter; empty for outputs.
    pub fn get(&self, id: Id) -> &[f64] {
        let first = OFFSETS.get(id as usize).copied().unwrap_or(0);
        let end = OFFSETS.get(id as usize + 1).copied().unwrap_or(0);
        self.values.get(first..end).unwrap_or(&[])
    }

    /// The only element.
    pub fn scalar(&self, id: Id) -> f64 {
        self.get(id).first().copied().unwrap_or(0.0)
    }

    /// A vector.
    pub fn vector(&self, id: Id) -> [f64; 3] {
        self.get(id).first_chunk().copied().unwrap_or([0.0; 3])
    }

    /// A quaternion.
    pub fn quaternion(&self, id: Id) -> [f64; 4] {
        self.get(id).first_chunk().copied().unwrap_or([0.0; 4])
    }

    /// A truth value.
    pub fn flag(&self, id: Id) -> bool {
        self.scalar(id) != 0.0
    }

    /// The host moves the projectile.
    pub fn host_driven(&self) -> bool {
        self.scalar(Id::Mode) == 1.0
    }

    /// Whether a value may be set: within the range of the table, and one of the choices. Real parameters are checked when
    /// initialisation ends, by the kernel, whose words say more, and then by [`Parameters::out_of_range`].
    pub fn acceptable(variable: &Variable, value: f64) -> bool {
        let [least, greatest] = variable.limits();
        variable.kind == Kind::Real || (least <= value && value <= greatest)
    }

    /// The first Real parameter that is not a number within its range, though the scene may not read it.
    pub fn out_of_range(&self) -> Option<&'static Variable> {
        VARIABLES.iter().find(|variable| {
            let [least, greatest] = variable.limits();
            let within = |value: &f64| value.is_finite() && least <= *value && *value <= greatest;
            variable.kind == Kind::Real && variable.role == Role::Fixed && !self.get(variable.id).iter().all(within)
        })
    }

    /// Sets one element. A new preset brings along everything the host has not set.
    pub fn set(&mut self, id: Id, element: usize, value: f64) {
        if let (Some(&first), Some(given)) = (OFFSETS.get(id as usize), self.given.get_mut(id as usize))
            && let Some(place) = self.values.get_mut(first.saturating_add(element))
        {
            *place = value;
            *given = true;
        }
        if id == Id::Preset {
            self.take_preset();
        }
    }

    fn take_preset(&mut self) {
        let base = self.base();
        for variable in VARIABLES {
            if let Some(values) = of_scene(&base, variable.id)
                && !self.is_given(variable.id)
            {
                let first = OFFSETS.get(variable.id as usize).copied().unwrap_or(0);
                let places = self.values.iter_mut().skip(first).take(variable.size());
                places.zip(values).for_each(|(place, value)| *place = value);
            }
        }
    }

    fn is_given(&self, id: Id) -> bool {
        self.given.get(id as usize).copied().unwrap_or(false)
    }

    fn base(&self) -> Scene {
        if self.scalar(Id::Preset) == 1.0 { Scene::sheet_3in_sphere() } else { Scene::sheet_10in_cylinder() }
    }

    /// The motion the host gives.
    pub fn motion(&self) -> Motion {
        Motion {
            position: self.vector(Id::Position),
            velocity: self.vector(Id::Velocity),
            orientation: self.quaternion(Id::Orientation),
            angular_velocity: self.vector(Id::AngularVelocity),
        }
    }

    /// Puts the projectile in front of the sheet if the host has given no position.
    pub fn place_projectile(&mut self) {
        if self.is_given(Id::Position) {
            return;
        }
        let scene = self.scene();
        let sheet = pose::normalised(scene.sheet.orientation);
        let body = pose::normalised(scene.projectile.orientation);
        let ahead = into_body(&(sheet.conjugate() * body), &Vector::new(0.0, 0.0, 1.0));
        let nose = Solid::of(&scene.projectile).support(&ahead);
        let place = pose::Pose::of_sheet(&scene.sheet).point_out([0.0, 0.0, -(nose + STAND_OFF)]);
        if !place.iter().all(|x| x.is_finite()) {
            return; // the orientation or the size is to blame, and the kernel will say so
        }
        let first = OFFSETS.get(Id::Position as usize).copied().unwrap_or(0);
        self.values.iter_mut().skip(first).zip(place).for_each(|(value, place)| *value = place);
    }

    /// The scene these values make, with the projectile in the given motion. The kernel checks it.
    pub fn scene(&self) -> Scene {
        let mut scene = self.base();
        let count = |id| self.scalar(id) as u32;
        let sheet = &mut scene.sheet;
        sheet.nodes_x = count(Id::NodesX);
        sheet.nodes_y = count(Id::NodesY);
        sheet.spacing = self.scalar(Id::Spacing);
        sheet.node_mass = self.scalar(Id::NodeMass);
        sheet.yarn_area = self.scalar(Id::YarnArea);
        sheet.plies = count(Id::Plies);
        sheet.position = self.vector(Id::SheetPosition);
        sheet.orientation = self.quaternion(Id::SheetOrientation);
        scene.attachment.kind = match count(Id::AttachmentKind) {
            0 => AttachmentKind::TwoSides,
            1 => AttachmentKind::FourSides,
            2 => AttachmentKind::FourCorners,
            _ => AttachmentKind::Free,
        };
        scene.attachment.disc_inset = self.scalar(Id::DiscInset);
        scene.attachment.disc_radius = self.scalar(Id::DiscRadius);
        let yarn = &mut scene.yarn;
        yarn.modulus_mean = self.scalar(Id::ModulusMean);
        yarn.modulus_sd = self.scalar(Id::ModulusSd);
        yarn.damage_slope = self.scalar(Id::DamageSlope);
        yarn.damage_intercept = self.scalar(Id::DamageIntercept);
        yarn.damage_sd = self.scalar(Id::DamageSd);
        yarn.critical_stretch = self.scalar(Id::CriticalStretch);
        yarn.alpha_fail = self.scalar(Id::AlphaFail);
        yarn.stochastic = self.flag(Id::Stochastic);
        let motion = self.motion();
        let body = &mut scene.projectile;
        body.shape = match count(Id::Shape) {
            0 => Shape::Sphere,
            1 => Shape::Cylinder,
            2 => Shape::HemisphericalCylinder,
            _ => Shape::Box,
        };
        body.radius = self.scalar(Id::Radius);
        body.length = self.scalar(Id::Length);
        body.mass = self.scalar(Id::Mass);
        body.size = self.vector(Id::Size);
        body.position = motion.position;
        body.velocity = motion.velocity;
        body.orientation = motion.orientation;
        body.angular_velocity = motion.angular_velocity;
        scene.drive = if self.host_driven() { Drive::Prescribed } else { Drive::Free };
        scene.seed = u64::from(count(Id::Seed));
        scene.time_step = TimeStep::seconds(self.scalar(Id::Dt));
        scene.force_window = self.scalar(Id::ForceWindow);
        scene.track_detachment = self.flag(Id::TrackDetachment);
        scene
    }

    /// Passes every number through `word`, which returns what to keep: one traversal for writing and reading an image.
    pub fn visit(&mut self, word: &mut impl FnMut(u64) -> u64) {
        for value in &mut self.values {
            *value = f64::from_bits(word(value.to_bits()));
        }
        for given in &mut self.given {
            *given = word(u64::from(*given)) != 0;
        }
    }
}

/// What a preset's scene says about a parameter (in the first elements), or None if it has no say.
pub fn of_scene(scene: &Scene, id: Id) -> Option<[f64; 4]> {
    let (sheet, yarn, body) = (&scene.sheet, &scene.yarn, &scene.projectile);
    let value = match id {
        Id::Shape => body.shape as u32 as f64,
        Id::Radius => body.radius,
        Id::Length => body.length,
        Id::Mass => body.mass,
        Id::NodesX => sheet.nodes_x as f64,
        Id::NodesY => sheet.nodes_y as f64,
        Id::Spacing => sheet.spacing,
        Id::NodeMass => sheet.node_mass,
        Id::YarnArea => sheet.yarn_area,
        Id::Plies => sheet.plies as f64,
        Id::AttachmentKind => scene.attachment.kind as u32 as f64,
        Id::DiscInset => scene.attachment.disc_inset,
        Id::DiscRadius => scene.attachment.disc_radius,
        Id::ModulusMean => yarn.modulus_mean,
        Id::ModulusSd => yarn.modulus_sd,
        Id::DamageSlope => yarn.damage_slope,
        Id::DamageIntercept => yarn.damage_intercept,
        Id::DamageSd => yarn.damage_sd,
        Id::CriticalStretch => yarn.critical_stretch,
        Id::AlphaFail => yarn.alpha_fail,
        Id::Stochastic => f64::from(u8::from(yarn.stochastic)),
        Id::Seed => scene.seed as f64,
        Id::ForceWindow => scene.force_window,
        Id::TrackDetachment => f64::from(u8::from(scene.track_detachment)),
        Id::Size => {
            let [a, b, c] = body.size;
            return Some([a, b, c, 0.0]);
        }
        Id::SheetOrientation => return Some(sheet.orientation),
        Id::SheetPosition => {
            let [x, y, z] = sheet.position;
            return Some([x, y, z, 0.0]);
        }
        _ => return None,
    };
    Some([value, 0.0, 0.0, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_leaves_what_the_host_has_set() {
        let mut parameters = Parameters::default();
        parameters.set(Id::Spacing, 0, 1e-3);
        parameters.set(Id::Preset, 0, 1.0);
        assert_eq!(parameters.scalar(Id::NodesX), 105.0);
        assert_eq!(parameters.scalar(Id::Spacing), 1e-3);
        parameters.set(Id::AttachmentKind, 0, 0.0);
        assert_eq!(parameters.scene().attachment.kind, AttachmentKind::TwoSides);
    }

    #[test]
    fn the_default_position_is_one_millimetre_before_the_sheet() {
        let mut parameters = Parameters::default();
        parameters.place_projectile();
        // Exactly the start value: a host that sets it gets the same bits as one that does not.
        assert_eq!(parameters.get(Id::Position), VARIABLES[Id::Position as usize].start);
        assert!((parameters.vector(Id::Position)[2] + 0.02005).abs() < 1e-15);
        parameters.set(Id::Preset, 0, 1.0);
        parameters.place_projectile();
        assert!((parameters.vector(Id::Position)[2] + 7.35e-3).abs() < 1e-15);
        // The nose of a hemispherical cylinder, whose centre of mass is not in its middle.
        parameters.set(Id::Shape, 0, 2.0);
        parameters.set(Id::Length, 0, 6.35e-3);
        parameters.place_projectile();
        assert!((parameters.vector(Id::Position)[2] + 1e-3 + 0.625 * 6.35e-3).abs() < 1e-15);
        // A box on its edge.
        parameters.set(Id::Shape, 0, 3.0);
        let eighth = core::f64::consts::PI / 8.0;
        parameters.set(Id::Orientation, 0, fabric::math::cos(eighth));
        parameters.set(Id::Orientation, 1, fabric::math::sin(eighth));
        parameters.place_projectile();
        let diagonal = 0.0127 * core::f64::consts::FRAC_1_SQRT_2;
        assert!((parameters.vector(Id::Position)[2] + 1e-3 + diagonal).abs() < 1e-15);
        let scene = parameters.scene();
        assert_eq!(scene.sheet, Scene::sheet_3in_sphere().sheet);
        assert_eq!(scene.yarn, Scene::sheet_3in_sphere().yarn);
        assert_eq!(scene.attachment, Scene::sheet_3in_sphere().attachment);
    }
}
