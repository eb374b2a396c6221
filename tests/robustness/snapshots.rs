//! Images that are cut, altered or forged are refused, and the simulation stays as it was. (`inputs` tells
//! which numbers make an image one of another scene.)

use fabric_kernel::{Code, Hash, Scene, Sim};
use fabric_tests::{between_supports, drawn, image_of, sim_of, small_sheet};

/// A small scene whose image holds damage, contact, a load and an outcome test.
fn scene() -> Scene {
    drawn(between_supports(small_sheet(5, 200.0), 1.0))
}

/// A simulation of it past failure, its image, and another one that is to take images.
fn driven() -> (Sim<'static>, Vec<u8>, Sim<'static>) {
    let mut sim = sim_of(&scene());
    sim.set_external_load([0.1, 0.2, 0.3], [0.0; 3]).unwrap();
    sim.advance(200).unwrap();
    assert!(sim.counters().failed_segments > 0);
    let image = image_of(&sim);
    (sim, image, sim_of(&scene()))
}

/// Replaces a word and makes the checksum right again.
pub fn forged(image: &[u8], word: usize, value: u64) -> Vec<u8> {
    let mut image = image.to_vec();
    image[8 * word..8 * word + 8].copy_from_slice(&value.to_le_bytes());
    let end = image.len() - 8;
    let mut hash = Hash::default();
    for chunk in image[..end].as_chunks::<8>().0 {
        hash.word(u64::from_le_bytes(*chunk));
    }
    image[end..].copy_from_slice(&hash.value().to_le_bytes());
    image
}

#[test]
fn every_truncation_is_refused() {
    let (_, image, mut target) = driven();
    target.advance(20).unwrap();
    let before = target.digest();
    for length in 0..image.len() {
        let error = target.load(&image[..length]).unwrap_err();
        assert_eq!((error.code, error.field), (Code::ImageMalformed, "image"));
    }
    let longer: Vec<u8> = image.iter().copied().chain([0; 8]).collect();
    assert_eq!(target.load(&longer).unwrap_err().code, Code::ImageMalformed);
    assert_eq!(target.digest(), before);
    println!("figure 11: {} truncations, {} refused", image.len(), image.len());
    target.load(&image).unwrap();
}

#[test]
fn every_flipped_bit_is_refused() {
    let (_, mut image, mut target) = driven();
    let before = target.digest();
    for bit in 0..8 * image.len() {
        image[bit / 8] ^= 1 << (bit % 8);
        let code = target.load(&image).unwrap_err().code;
        let expected = if (8..24).contains(&(bit / 8)) { Code::ImageOfAnotherScene } else { Code::ImageMalformed };
        assert_eq!(code, expected, "bit {bit}");
        image[bit / 8] ^= 1 << (bit % 8);
    }
    assert_eq!(target.digest(), before);
    println!("figure 11: {} single-bit flips, {} refused", 8 * image.len(), 8 * image.len());
    target.load(&image).unwrap();
}

/// Another magic, version, scene or number of words, with the right checksum.
#[test]
fn forged_headers_are_refused() {
    let (_, image, mut target) = driven();
    let before = target.digest();
    let word = |k: usize| u64::from_le_bytes(*image[8 * k..].first_chunk().unwrap());
    let mut tried = 0;
    let codes = [Code::ImageMalformed, Code::ImageOfAnotherScene, Code::ImageOfAnotherScene, Code::ImageMalformed];
    for (k, code) in codes.into_iter().enumerate() {
        for other in [0, u64::MAX, word(k) + 1, word(k) - 1, word(k).swap_bytes()] {
            assert_eq!(target.load(&forged(&image, k, other)).unwrap_err().code, code, "word {k} = {other:x}");
            assert_eq!(target.digest(), before);
            tried += 1;
        }
    }
    println!("figure 11: {tried} forged headers, {tried} refused");
}

#[test]
fn forged_images_are_refused_or_harmless() {
    let (_, image, mut target) = driven();
    assert_eq!(forged(&image, 4, 200), image, "the step count is word 4");
    let (mut refused, mut valid) = (0, 0);
    let words = image.len() / 8 - 1;
    for word in 4..words {
        for value in [f64::NAN.to_bits(), f64::INFINITY.to_bits(), f64::MAX.to_bits(), u64::MAX, 2] {
            target.reset();
            let before = target.digest();
            match target.load(&forged(&image, word, value)) {
                Ok(()) => {
                    // A value that a simulation can have: such a state can be saved and loaded like any
                    // other, and whatever it does, it says so and does not panic.
                    let (taken, again) = (target.digest(), image_of(&target));
                    target.reset();
                    target.load(&again).unwrap();
                    assert_eq!(target.digest(), taken, "word {word}");
                    valid += 1;
                    let advanced = target.advance(130);
                    assert_eq!(advanced.err(), target.failure());
                    let _ = (target.energy(), target.outcomes(), target.counters(), target.fabric());
                }
                Err(error) => {
                    assert_eq!(error.code, Code::ImageInvalid, "word {word}");
                    assert_eq!(target.digest(), before);
                    refused += 1;
                }
            }
        }
    }
    println!("figure 11: {} forged values, {refused} refused, {valid} valid states", refused + valid);
    // NaN and infinity in every real number, at the least.
    assert!(refused > 2 * (words - 40), "{refused}");
}

/// An image that never left the program is taken without its checksum, but only if a simulation can have what
/// it holds.
#[test]
fn a_kept_image_is_refused_for_all_but_its_checksum() {
    let (sim, image, mut target) = driven();
    let before = target.digest();
    let words = image.len() / 8 - 1;
    for word in 0..words {
        let mut bad = image.clone();
        bad[8 * word..8 * word + 8].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(target.load_kept(&bad).is_err(), "word {word}");
        assert_eq!(target.digest(), before);
    }
    for length in [0, 8, 32, 8 * words, image.len() - 1] {
        assert_eq!(target.load_kept(&image[..length]).unwrap_err().code, Code::ImageMalformed);
    }
    let mut other = image.clone();
    other[8 * words] ^= 1;
    assert_eq!(target.load(&other).unwrap_err().code, Code::ImageMalformed);
    target.load_kept(&other).unwrap();
    assert_eq!(target.digest(), sim.digest());
}
