//! Start values: the scene that an instance has if its host sets nothing.
//!
//! The 10 in sheet, or the scene that `fabric fmu` has put into the library's file: the library has a
//! reserved block of data for it.
//! The program finds the block by its first two words, and fills in all words after the third.

use crate::parameters::Parameters;
use crate::token;
use core::hint::black_box;
use fabric_kernel::fields::SLOTS;
use fabric_kernel::{Hash, Scene};

/// Words of the block: its mark (2), layout, build, token, checksum, and those of the scene in the order of
/// the kernel's table.
type Words = [u64; 6 + SLOTS];

/// Mark of the block. No code compares it, so that it occurs in a file once.
const MARK: [u64; 2] = [u64::from_le_bytes(*b"FabricSc"), u64::from_le_bytes(*b"eneBlock")];

/// Version of the layout, and the number of the scene's words.
const LAYOUT: u64 = 1 << 32 | SLOTS as u64;

/// A word of an empty block. Not 0: a file may leave out data that is 0.
const EMPTY: u64 = u64::from_le_bytes(*b"no scene");

#[used]
static BLOCK: Words = {
    let mut block = [EMPTY; 6 + SLOTS];
    (block[0], block[1], block[2]) = (MARK[0], MARK[1], LAYOUT);
    block
};

/// Distance of the projectile's nose from the sheet at the start, m.
pub const STAND_OFF: f64 = 1e-3;

/// Time step of the 10 in sheet, s. A round number: communication steps then end at whole internal steps.
pub const TIME_STEP: f64 = 2e-8;

/// Start values of the library.
pub struct Starts {
    /// Scene of the start values.
    pub scene: Scene,
    /// Number of the token that a model description must have, below 2^52.
    pub token: u64,
}

impl Starts {
    /// Start values of the library as it is: the 10 in sheet.
    pub fn own() -> Starts {
        let mut scene = Scene::sheet_10in_cylinder();
        scene.time_step.seconds = TIME_STEP;
        scene.projectile.position[2] -= STAND_OFF;
        Starts { scene, token: token::hash(Parameters::of(scene)) }
    }

    /// Start values of the library in its file.
    ///
    /// # Errors
    /// Why the block is refused.
    pub fn read() -> Result<Starts, &'static str> {
        // Without it the compiler would take the value that it knows. tests/fmi/test_filled.py fails on a
        // platform where it does.
        Starts::of(black_box(&BLOCK))
    }

    fn of(block: &Words) -> Result<Starts, &'static str> {
        let starts = Starts::own();
        let [_, _, layout, build, token, checksum, words @ ..] = block;
        if [build, token, checksum] == [&EMPTY; 3] {
            return Ok(starts);
        }
        if (*layout, *build) != (LAYOUT, starts.token) {
            return Err("start values: the scene in the library is that of another version");
        }
        let mut hash = Hash::default();
        [build, token].into_iter().chain(words).for_each(|word| hash.word(*word));
        let (mut parameters, mut words) = (Parameters::of(starts.scene), words.iter());
        // Inputs and settings of the FMU, which the scene does not have, stay 0.
        let known = parameters.visit(&mut |_| words.next().copied().unwrap_or(0));
        if hash.value() != *checksum || !known {
            return Err("start values: the scene in the library is damaged");
        }
        Ok(Starts { scene: *parameters.scene(), token: *token })
    }
}

impl Default for Parameters {
    /// The start values. An instance of a block that is refused is not made.
    fn default() -> Parameters {
        Parameters::of(Starts::read().unwrap_or_else(|_| Starts::own()).scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabric_kernel::fields::FIELDS;

    /// The block of a scene as `fabric fmu` writes it.
    fn filled(mut scene: Scene) -> Words {
        let mut block = BLOCK;
        (block[3], block[4]) = (Starts::own().token, 77);
        let places = FIELDS.iter().flat_map(|field| (0..field.size()).map(move |element| (field, element)));
        block.iter_mut().skip(6).zip(places).for_each(|(word, (field, k))| *word = field.word(&mut scene, k));
        let mut hash = Hash::default();
        block[3..5].iter().chain(&block[6..]).for_each(|word| hash.word(*word));
        block[5] = hash.value();
        block
    }

    #[test]
    fn a_block_gives_its_scene_or_is_refused() {
        let (own, scene) = (Starts::own(), Scene::turbine_disc_sector());
        let empty = Starts::read().unwrap();
        assert_eq!((empty.scene, empty.token), (own.scene, own.token));
        let block = filled(scene);
        let starts = Starts::of(&block).unwrap();
        assert_eq!((starts.scene, starts.token), (scene, 77));
        for place in 2..block.len() {
            for bit in [0, 31, 63] {
                let mut damaged = block;
                damaged[place] ^= 1 << bit;
                let reason = Starts::of(&damaged).err().unwrap();
                assert_eq!(reason.ends_with("another version"), place < 4, "{place}: {reason}");
            }
        }
    }
}
