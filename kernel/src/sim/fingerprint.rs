//! Which scene an image is of: a hash of the time step and of every number that the scene reads, by name.
//!
//! Limits: numbers that are 0 do not count, so that images still fit once there is another option, which is
//! off. Left out by design are the projectile's motion at the start, for an image holds the present one,
//! `contact_capacity`, for it fits whatever room there is, and how the step was asked for and checked.

use crate::ground::hash::Hash;
use crate::scene::fields::FIELDS;
use crate::scene::parts::Scene;

/// A hash of the scene and of the step in use, s.
#[inline(never)]
pub fn fingerprint(scene: &Scene, dt: f64) -> u64 {
    let (mut hash, mut copy) = (Hash::default(), *scene);
    hash.real(dt);
    for field in FIELDS.iter().filter(|field| field.in_fingerprint) {
        let read = (field.read)(scene).min(field.size());
        if (0..read).any(|element| field.word(&mut copy, element) != 0) {
            field.name.bytes().for_each(|byte| hash.word(u64::from(byte)));
            (0..read).for_each(|element| hash.word(field.word(&mut copy, element)));
        }
    }
    hash.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parts::Symmetry;

    #[test]
    fn options_of_one_value_differ_by_their_names_and_one_that_is_off_does_not_count() {
        let print = |mirror_x, mirror_y, slack_balance, viscosity_bending| {
            let mut scene = Scene::sheet_3in_sphere();
            (scene.symmetry, scene.slack_balance) = (Symmetry { mirror_x, mirror_y }, slack_balance);
            scene.yarn.viscosity_bending = viscosity_bending;
            fingerprint(&scene, 1e-7)
        };
        let plain = print(false, false, false, 0.0);
        let others = [
            print(true, false, false, 0.0),
            print(false, true, false, 0.0),
            print(false, false, true, 0.0),
            print(false, false, false, 0.06),
            fingerprint(&Scene::sheet_3in_sphere(), 2e-7),
        ];
        for (k, other) in others.iter().enumerate() {
            assert!(*other != plain && !others[..k].contains(other), "{k}");
        }
        let mut unread = Scene::sheet_3in_sphere();
        (unread.weft.modulus_sd, unread.sheet.grading.run) = (1e9, 7);
        assert_eq!(fingerprint(&unread, 1e-7), plain, "numbers that are not read");
    }
}
