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
    fn options_of_one_value_differ_by_their_names() {
        let print = |mirror_x, mirror_y, slack_balance, dt| {
            let symmetry = Symmetry { mirror_x, mirror_y };
            fingerprint(&Scene { symmetry, slack_balance, ..Scene::sheet_3in_sphere() }, dt)
        };
        let [x, y] = [print(true, false, false, 1e-7), print(false, true, false, 1e-7)];
        let [slack, slower] = [print(false, false, true, 1e-7), print(false, true, false, 2e-7)];
        assert!(x != y && y != slack && x != slack && y != slower);
    }
}
