//! Values of inputs and parameters as the host set them, and the scene they make.

use crate::table::{DEFAULT_TIME_STEP, Id, Kind, MOST_ELEMENTS, Role, VARIABLES, Variable};
use core::slice::from_mut;
use fabric::fields::FIELDS;
use fabric::pose::into_body;
use fabric::pose::{self, Vector};
use fabric::shape::Solid;
use fabric::{Drive, Motion, Scene};

/// Distance of the projectile's nose from the sheet if no position is given, m.
const STAND_OFF: f64 = 1e-3;

/// Inputs and parameters: a scene, and what the FMU adds.
#[derive(Clone, Copy)]
pub struct Parameters {
    scene: Scene,
    /// Which of the scene's parameters the host has set itself; a preset leaves those alone.
    given: [bool; FIELDS.len()],
    /// projectile.acceleration, m/s^2.
    pub acceleration: [f64; 3],
    /// external.force, N.
    pub force: [f64; 3],
    /// external.torque, N m.
    pub torque: [f64; 3],
    preset: f64,
    stop_on_event: f64,
    log_level: f64,
}

impl Default for Parameters {
    fn default() -> Parameters {
        Parameters {
            scene: preset(0.0),
            given: [false; FIELDS.len()],
            acceleration: [0.0; 3],
            force: [0.0; 3],
            torque: [0.0; 3],
            preset: 0.0,
            stop_on_event: 0.0,
            log_level: 2.0,
        }
    }
}

/// The scene of a preset: the kernel's, but with a time step in seconds, and the projectile 1 mm before the sheet.
fn preset(number: f64) -> Scene {
    let mut scene = match number as u32 {
        1 => Scene::sheet_3in_sphere(),
        3 => Scene::turbine_disc_sector(),
        _ => Scene::sheet_10in_cylinder(),
    };
    scene.time_step.seconds = DEFAULT_TIME_STEP;
    scene.projectile.position[2] -= STAND_OFF;
    scene
}

impl Parameters {
    /// The scene these values make, with the projectile in the motion that the host gives. The kernel checks it.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The numbers of an input or setting of the FMU's own.
    fn own(&mut self, id: Id) -> &mut [f64] {
        match id {
            Id::Acceleration => &mut self.acceleration,
            Id::ExternalForce => &mut self.force,
            Id::ExternalTorque => &mut self.torque,
            Id::Preset => from_mut(&mut self.preset),
            Id::StopOnEvent => from_mut(&mut self.stop_on_event),
            Id::LogLevel => from_mut(&mut self.log_level),
            _ => &mut [],
        }
    }

    /// All elements of an input or parameter. Integers, choices and truth values are whole numbers.
    pub fn get(&mut self, variable: &Variable, values: &mut [f64; MOST_ELEMENTS]) {
        if let Some(field) = variable.field() {
            for (element, value) in values.iter_mut().enumerate().take(field.size()) {
                *value = field.value_of(field.word(&mut self.scene, element));
            }
        } else {
            values.iter_mut().zip(self.own(variable.id)).for_each(|(value, own)| *value = *own);
        }
    }

    /// Whether an outcome ends the simulation.
    pub fn stop_on_event(&self) -> bool {
        self.stop_on_event != 0.0
    }

    /// How much is logged.
    pub fn log_level(&self) -> u8 {
        self.log_level as u8
    }

    /// The host moves the projectile.
    pub fn prescribed(&self) -> bool {
        self.scene.drive == Drive::Prescribed
    }

    /// Whether a value may be set: one of the choices; of an Integer not below 0. The scene's numbers are checked when
    /// initialisation ends, by the kernel, whose words say more, and then by [`Parameters::out_of_range`].
    pub fn acceptable(variable: &Variable, value: f64) -> bool {
        let [least, greatest] = variable.limits();
        match (variable.kind, variable.field()) {
            (Kind::Real, _) => true,
            (Kind::Integer, Some(_)) => value >= 0.0,
            _ => least <= value && value <= greatest,
        }
    }

    /// The first parameter of the scene that is not a number within its range, though the scene may not read it.
    pub fn out_of_range(&mut self) -> Option<&'static Variable> {
        VARIABLES.iter().find(|variable| {
            let ([least, greatest], mut values) = (variable.limits(), [0.0; MOST_ELEMENTS]);
            self.get(variable, &mut values);
            let within = |value: &f64| value.is_finite() && least <= *value && *value <= greatest;
            variable.role == Role::Fixed && !values.iter().take(variable.size()).all(within)
        })
    }

    /// Sets one element. A new preset brings along everything the host has not set.
    pub fn set(&mut self, variable: &Variable, element: usize, value: f64) {
        if let (Id::Scene(row), Some(field)) = (variable.id, variable.field()) {
            let known = field.set_word(&mut self.scene, element, field.word_of(value)).is_ok();
            if let Some(given) = self.given.get_mut(row) {
                *given |= known;
            }
        } else if let Some(place) = self.own(variable.id).get_mut(element) {
            *place = value;
        }
        if variable.id == Id::Preset {
            self.take_preset();
        }
    }

    fn take_preset(&mut self) {
        let mut before = core::mem::replace(&mut self.scene, preset(self.preset));
        for (field, _) in FIELDS.iter().zip(self.given).filter(|(_, given)| *given) {
            for element in 0..field.size() {
                let word = field.word(&mut before, element);
                let _ = field.set_word(&mut self.scene, element, word); // as it was set
            }
        }
    }

    /// The motion the host gives.
    pub fn motion(&self) -> Motion {
        let body = &self.scene.projectile;
        Motion {
            position: body.position,
            velocity: body.velocity,
            orientation: body.orientation,
            angular_velocity: body.angular_velocity,
        }
    }

    /// Puts the projectile in front of the sheet if the host has given no position.
    pub fn place_projectile(&mut self) {
        let position = |(field, given): (&fabric::fields::Field, &bool)| field.name == "projectile.position" && *given;
        if FIELDS.iter().zip(&self.given).any(position) {
            return;
        }
        let (sheet, body) = (&self.scene.sheet, &self.scene.projectile);
        let turned = pose::normalised(sheet.orientation).conjugate() * pose::normalised(body.orientation);
        let nose = Solid::of(body).support(&into_body(&turned, &Vector::new(0.0, 0.0, 1.0)));
        let place = pose::Pose::of_sheet(sheet).point_out([0.0, 0.0, -(nose + STAND_OFF)]);
        // If not, the orientation or the size is to blame, and the kernel will say so.
        if place.iter().all(|x| x.is_finite()) {
            self.scene.projectile.position = place;
        }
    }

    /// Passes every number through `word`, which returns what to keep: one traversal for writing and reading an image.
    /// False if a word makes no sense.
    pub fn visit(&mut self, word: &mut impl FnMut(u64) -> u64) -> bool {
        let mut known = true;
        for field in FIELDS {
            for element in 0..field.size() {
                let kept = word(field.word(&mut self.scene, element));
                known &= field.set_word(&mut self.scene, element, kept).is_ok();
            }
        }
        for given in &mut self.given {
            *given = word(u64::from(*given)) != 0;
        }
        for variable in &VARIABLES {
            for value in self.own(variable.id) {
                *value = f64::from_bits(word(value.to_bits()));
            }
        }
        known
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::variable;
    use fabric::AttachmentKind;
    use fabric::fields::Place;

    fn set(parameters: &mut Parameters, name: &str, element: usize, value: f64) {
        parameters.set(variable(name).unwrap(), element, value);
    }

    #[test]
    fn every_parameter_of_the_scene_is_a_variable_and_reaches_it() {
        for field in FIELDS {
            let known = variable(field.name).unwrap();
            assert_eq!((known.reference, known.shape), (field.fmi, field.shape()), "{}", field.name);
            for element in 0..field.size() {
                let (mut parameters, mut values) = (Parameters::default(), [0.0; MOST_ELEMENTS]);
                parameters.get(known, &mut values);
                let value = if field.is_real() { 1234.5 } else { 1.0 - values[element].min(1.0) };
                parameters.set(known, element, value);
                let mut expected = *Parameters::default().scene();
                field.set_word(&mut expected, element, field.word_of(value)).unwrap();
                assert!(expected != *Parameters::default().scene(), "{}", field.name);
                assert_eq!(*parameters.scene(), expected, "{}", field.name);
                parameters.get(known, &mut values);
                assert_eq!(values[element], value, "{}", field.name);
            }
        }
    }

    #[test]
    fn a_value_that_no_preset_has_is_refused_when_initialisation_ends_or_before() {
        for field in FIELDS.iter().filter(|field| !matches!(field.place, Place::Reals(..))) {
            let known = variable(field.name).unwrap();
            assert!(!Parameters::acceptable(known, -1.0), "{}", field.name);
            let most = known.limits()[1];
            assert!(most <= f64::from(i32::MAX) && Parameters::acceptable(known, most), "{}", field.name);
        }
        let mut parameters = Parameters::default();
        assert!(parameters.out_of_range().is_none());
        set(&mut parameters, "projectile.moments", 1, f64::NAN);
        assert_eq!(parameters.out_of_range().map(|variable| variable.name), Some("projectile.moments"));
    }

    #[test]
    fn start_values_lie_in_their_ranges() {
        let (mut starts, mut values) = (Parameters::default(), [0.0; MOST_ELEMENTS]);
        for variable in VARIABLES.iter().filter(|variable| !variable.role.is_output()) {
            starts.get(variable, &mut values);
            let [least, greatest] = variable.limits();
            assert!(values[..variable.size()].iter().all(|&x| least <= x && x <= greatest), "{}", variable.name);
        }
    }

    #[test]
    fn a_preset_leaves_what_the_host_has_set() {
        let mut parameters = Parameters::default();
        set(&mut parameters, "sheet.spacing", 0, 1e-3);
        set(&mut parameters, "preset", 0, 1.0);
        let sheet = Scene::sheet_3in_sphere().sheet;
        assert_eq!(parameters.scene().sheet, fabric::Sheet { spacing: 1e-3, ..sheet });
        set(&mut parameters, "attachment.kind", 0, 0.0);
        assert_eq!(parameters.scene().attachment.kind, AttachmentKind::TwoSides);
        set(&mut parameters, "preset", 0, 3.0);
        assert_eq!(parameters.scene().attachment.kind, AttachmentKind::TwoSides);
        assert_eq!(parameters.scene().projectile.shape, Scene::turbine_disc_sector().projectile.shape);
    }

    #[test]
    fn the_default_position_is_one_millimetre_before_the_sheet() {
        let mut parameters = Parameters::default();
        let start = parameters.scene().projectile.position;
        parameters.place_projectile();
        // Exactly the start value: a host that sets it gets the same bits as one that does not.
        assert_eq!(parameters.scene().projectile.position, start);
        assert_eq!(start[2], -(0.0381 / 2.0 + 1e-3));
        let height = |parameters: &mut Parameters| {
            parameters.place_projectile();
            parameters.scene().projectile.position[2]
        };
        set(&mut parameters, "preset", 0, 1.0);
        assert!((height(&mut parameters) + 7.35e-3).abs() < 1e-15);
        // The nose of a hemispherical cylinder, whose centre of mass is not in its middle.
        set(&mut parameters, "projectile.shape", 0, 2.0);
        set(&mut parameters, "projectile.length", 0, 6.35e-3);
        assert!((height(&mut parameters) + 1e-3 + 0.625 * 6.35e-3).abs() < 1e-15);
        // A box on its edge.
        set(&mut parameters, "projectile.shape", 0, 3.0);
        let eighth = core::f64::consts::PI / 8.0;
        set(&mut parameters, "projectile.orientation", 0, fabric::math::cos(eighth));
        set(&mut parameters, "projectile.orientation", 1, fabric::math::sin(eighth));
        let diagonal = 0.0127 * core::f64::consts::FRAC_1_SQRT_2;
        assert!((height(&mut parameters) + 1e-3 + diagonal).abs() < 1e-15);
    }
}
