//! The start values: the scene that an instance has if its host sets nothing.
//!
//! It is the 10 in sheet, or the scene that `cargo xtask fmu --scene FILE` was given. That command hands the scene over when the
//! library is compiled, in the environment variables `FABRIC_FMU_NAME` and `FABRIC_FMU_SCENE`, the second 16 hexadecimal digits for each number of the kernel's table
//! ([`fabric::fields::FIELDS`]), in its order.

use fabric::Scene;
use fabric::fields::{FIELDS, SLOTS};

/// Name of the model: FabricShield, or that of a scene of its own.
pub const NAME: &str = match option_env!("FABRIC_FMU_NAME") {
    None => crate::MODEL_IDENTIFIER,
    Some(name) => name,
};

/// The scene as words; None for the 10 in sheet.
const WORDS: Option<[u64; SLOTS]> = match option_env!("FABRIC_FMU_SCENE") {
    None => None,
    Some(text) => Some(words(text.as_bytes())),
};

/// Reads the words; a text that is not of them does not compile.
const fn words(text: &[u8]) -> [u64; SLOTS] {
    assert!(text.len() == 16 * SLOTS, "FABRIC_FMU_SCENE is not a scene of this version");
    let (mut words, mut k) = ([0; SLOTS], 0);
    while k < text.len() {
        let digit = match text[k] {
            digit @ b'0'..=b'9' => digit - b'0',
            digit @ b'a'..=b'f' => digit - b'a' + 10,
            _ => panic!("FABRIC_FMU_SCENE has something else than hexadecimal digits"),
        };
        words[k / 16] = words[k / 16] << 4 | digit as u64;
        k += 1;
    }
    words
}

/// Distance of the projectile's nose from the sheet at the start, m.
pub const STAND_OFF: f64 = 1e-3;

/// Time step of the 10 in sheet, s. A round number: communication steps then end at whole internal steps.
pub const TIME_STEP: f64 = 2e-8;

/// The scene of the start values.
pub fn scene() -> Scene {
    let mut scene = Scene::sheet_10in_cylinder();
    scene.time_step.seconds = TIME_STEP;
    scene.projectile.position[2] -= STAND_OFF;
    if let Some(words) = WORDS {
        let mut words = words.iter();
        for field in FIELDS {
            for element in 0..field.size() {
                // The command has checked that the words are a scene.
                let _ = words.next().map(|word| field.set_word(&mut scene, element, *word));
            }
        }
    }
    scene
}
