//! Values of inputs and parameters as the host set them, and the scene they make.

use crate::table::{Id, Kind, MOST_ELEMENTS, Role, VARIABLES, Variable};
use core::slice::from_mut;
use fabric_kernel::fields::FIELDS;
use fabric_kernel::{Drive, Motion, Scene};

/// Inputs and parameters: a scene, and what the FMU adds.
#[derive(Clone, Copy)]
pub struct Parameters {
    scene: Scene,
    /// The projectile's motion that the host gives in drive prescribed; all zero until it does.
    pub body: Motion,
    /// projectile.acceleration, m/s^2.
    pub acceleration: [f64; 3],
    /// external.force, N.
    pub force: [f64; 3],
    /// external.torque, N m.
    pub torque: [f64; 3],
    stop_on_event: f64,
    ply_first: f64,
    capsule: f64,
}

impl Parameters {
    /// A scene, and nothing from the host.
    pub fn of(scene: Scene) -> Parameters {
        Parameters {
            scene,
            body: Motion { position: [0.0; 3], velocity: [0.0; 3], orientation: [0.0; 4], angular_velocity: [0.0; 3] },
            acceleration: [0.0; 3],
            force: [0.0; 3],
            torque: [0.0; 3],
            stop_on_event: 0.0,
            ply_first: 0.0,
            capsule: 0.0,
        }
    }

    /// The scene that the parameters say. The kernel checks it.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The numbers of an input or setting of the FMU's own.
    fn own(&mut self, id: Id) -> &mut [f64] {
        match id {
            Id::Position => &mut self.body.position,
            Id::Velocity => &mut self.body.velocity,
            Id::Orientation => &mut self.body.orientation,
            Id::AngularVelocity => &mut self.body.angular_velocity,
            Id::Acceleration => &mut self.acceleration,
            Id::ExternalForce => &mut self.force,
            Id::ExternalTorque => &mut self.torque,
            Id::StopOnEvent => from_mut(&mut self.stop_on_event),
            Id::PlyFirst => from_mut(&mut self.ply_first),
            Id::Capsule => from_mut(&mut self.capsule),
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

    /// Whether a capsule is written.
    pub fn capsule(&self) -> bool {
        self.capsule != 0.0
    }

    /// The ply that the outputs of single plies begin with.
    pub fn ply_first(&self) -> u32 {
        self.ply_first as u32
    }

    /// The host moves the projectile.
    pub fn prescribed(&self) -> bool {
        self.scene.drive == Drive::Prescribed
    }

    /// Whether a value may be set: one of the choices; of an Integer not below 0. The scene's numbers are
    /// checked when initialisation ends, by the kernel, whose words say more, and then by
    /// [`Parameters::out_of_range`].
    pub fn acceptable(variable: &Variable, value: f64) -> bool {
        match (variable.kind, variable.field()) {
            (Kind::Real, _) => true,
            (Kind::Integer, Some(_)) => value >= 0.0,
            _ => variable.contains(value),
        }
    }

    /// The first parameter of the scene that is not a number within its range, though the scene may not read
    /// it, and the number.
    pub fn out_of_range(&mut self) -> Option<(&'static Variable, f64)> {
        VARIABLES.iter().filter(|variable| variable.role == Role::Fixed).find_map(|variable| {
            let mut values = [0.0; MOST_ELEMENTS];
            self.get(variable, &mut values);
            let within = |value: f64| value.is_finite() && variable.contains(value);
            values.into_iter().take(variable.size()).find(|value| !within(*value)).map(|value| (variable, value))
        })
    }

    /// Sets one element.
    pub fn set(&mut self, variable: &Variable, element: usize, value: f64) {
        if let Some(field) = variable.field() {
            // Whole numbers and choices are in their ranges: asked before with `acceptable`.
            let _ = field.set_word(&mut self.scene, element, field.word_of(value));
        } else if let Some(place) = self.own(variable.id).get_mut(element) {
            *place = value;
        }
    }

    /// The projectile's motion at the start.
    pub fn start(&self) -> Motion {
        let body = &self.scene.projectile;
        Motion {
            position: body.position,
            velocity: body.velocity,
            orientation: body.orientation,
            angular_velocity: body.angular_velocity,
        }
    }

    /// Passes every number through `word`, which returns what to keep: one traversal for writing and reading
    /// an image.
    /// False if a word makes no sense.
    pub fn visit(&mut self, word: &mut impl FnMut(u64) -> u64) -> bool {
        let mut known = true;
        for field in FIELDS {
            for element in 0..field.size() {
                let kept = word(field.word(&mut self.scene, element));
                known &= field.set_word(&mut self.scene, element, kept).is_ok();
            }
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
    use fabric_kernel::fields::Place;

    fn set(parameters: &mut Parameters, name: &str, element: usize, value: f64) {
        parameters.set(variable(name).unwrap(), element, value);
    }

    #[test]
    fn every_parameter_of_the_scene_is_a_variable_and_reaches_it() {
        for field in FIELDS {
            let known =
                VARIABLES.iter().find(|variable| variable.field().is_some_and(|own| own.name == field.name)).unwrap();
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
    fn a_value_that_no_scene_has_is_refused_when_initialisation_ends_or_before() {
        for field in FIELDS.iter().filter(|field| !matches!(field.place, Place::Reals(..))) {
            let known = variable(field.name).unwrap();
            assert!(!Parameters::acceptable(known, -1.0), "{}", field.name);
            let most = known.limits()[1];
            assert!(most <= f64::from(i32::MAX) && Parameters::acceptable(known, most), "{}", field.name);
        }
        let mut parameters = Parameters::default();
        assert!(parameters.out_of_range().is_none());
        set(&mut parameters, "projectile.moments", 1, f64::NAN);
        assert_eq!(parameters.out_of_range().map(|(variable, _)| variable.name), Some("projectile.moments"));
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
}
