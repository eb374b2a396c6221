//! Which scene an image is of: a hash of the time step and of every number that the scene reads.
//!
//! Limits: three are left out by design: the projectile's motion at the start, for an image holds the present
//! one, `contact_capacity`, for it fits whatever room there is, and how the step was asked for and checked
//! ([`crate::fields::Image::Never`]). What is not read counts where it always has
//! ([`crate::fields::Image::Always`]).

use crate::ground::hash::Hash;
use crate::scene::fields;
use crate::scene::parts::Scene;

/// A hash of the scene and of the step in use: the words of the table (`fields/table.rs`), as each row says.
pub fn fingerprint(scene: &Scene, dt: f64) -> u64 {
    let mut hash = Hash::default();
    fields::fingerprint_words(scene, dt, &mut |word| hash.word(word));
    hash.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parts::{Draw, Integrator, RotationRule, Symmetry};

    /// So an image of a scene without them fits, whether or not its program knew of them.
    #[test]
    fn an_option_in_use_adds_its_words_at_the_end() {
        let print = |change: &dyn Fn(&mut Scene)| {
            let mut scene = Scene::sheet_3in_sphere();
            change(&mut scene);
            fingerprint(&scene, 1e-7)
        };
        let plain = print(&|_| ());
        let check = |change: &dyn Fn(&mut Scene), words: &[u64]| {
            let mut hash = Hash(plain);
            words.iter().for_each(|&word| hash.word(word));
            assert_eq!(print(change), hash.value(), "{words:x?}");
        };
        check(&|s| s.yarn.draw = Draw::Yarn, &[0x1_0001]);
        for (mirror_x, mirror_y, word) in [(true, false, 0x2_0001), (false, true, 0x2_0002), (true, true, 0x2_0003)] {
            check(&|s| s.symmetry = Symmetry { mirror_x, mirror_y }, &[word]);
        }
        check(&|s| s.integrator = Integrator::THETA, &[0x3_0000, 0.5_f64.to_bits(), 1e-10_f64.to_bits(), 500]);
        check(&|s| s.rotation_rule = RotationRule::theta(1.0), &[0x4_0000, 1.0_f64.to_bits()]);
        check(&|s| s.slack_balance = true, &[0x6_0001]);
        check(&|s| s.yarn.viscosity_linear = 0.06, &[0x8_0000, 0.06_f64.to_bits()]);
        check(&|s| s.yarn.viscosity_quadratic = 1.5, &[0x8_0001, 1.5_f64.to_bits()]);
        check(&|s| s.yarn.viscosity_bending = 0.06, &[0x8_0002, 0.06_f64.to_bits()]);
        let with_rate = |s: &mut Scene| {
            (s.yarn.rate_modulus, s.yarn.rate_reference, s.yarn.rate_limit) = (0.125, 30.0, 170.0);
        };
        let bits = [0.125_f64, 30.0, 170.0].map(f64::to_bits);
        check(&with_rate, &[0x67_0000, bits[0], bits[1], bits[2]]);
        // Several at once, in the order in which they came.
        check(&|s| (s.yarn.draw, s.slack_balance) = (Draw::Yarn, true), &[0x1_0001, 0x6_0001]);
    }
}
