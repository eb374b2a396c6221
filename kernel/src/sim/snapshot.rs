//! Snapshot images and the digest.
//!
//! An image is a sequence of little-endian 64-bit words, as `memory/image.rs` lists them. No pointers, no
//! `usize`, no padding: the same bytes on every target. A digest is a hash of the words before the checksum.
//! Limits: an image fits only the scene it was made with (`fingerprint.rs`).
//! The checksum finds every change of a single word; it is no protection against forgery.

use crate::ground::error::{Code, Error};
use crate::ground::hash::Hash;
use crate::memory::image::{self, HEADER_WORDS};
use crate::memory::state::Visitor;
use crate::memory::system::System;
use crate::sim::fingerprint::fingerprint;

const MAGIC: u64 = u64::from_le_bytes(*b"FABRSNAP");
/// Version of the image's format; changes whenever its content or meaning does.
pub const FORMAT: u64 = 1;

/// Hashes words, and writes them into bytes as far as there are any.
struct Writer<'b> {
    chunks: core::slice::IterMut<'b, [u8; 8]>,
    hash: Hash,
}

impl Writer<'_> {
    fn word(&mut self, word: u64) {
        self.hash.word(word);
        if let Some(chunk) = self.chunks.next() {
            *chunk = word.to_le_bytes();
        }
    }

    /// Every word of an image before its checksum. Returns their hash.
    fn words_of(&mut self, system: &System<'_>) -> u64 {
        header(system).into_iter().for_each(|word| self.word(word));
        let mut state = system.state;
        state.visit(system.layout.has, self);
        let rows = &system.arrays.rows;
        let numbers = rows.numbers();
        for j in 0..system.layout.nodes_y {
            rows.been_slack.get(j).into_iter().for_each(|&bits| self.word(u64::from(bits)));
            image::traverse(&system.layout, j, |place| {
                self.word(numbers[place.array as usize].get(place.at).map_or(0, |number| number.to_bits()));
            });
        }
        system.arrays.flags.iter().for_each(|&flags| self.word(u64::from(flags)));
        self.hash.value()
    }
}

impl Visitor for Writer<'_> {
    fn count(&mut self, value: &mut u64) {
        self.word(*value);
    }
    fn real(&mut self, value: &mut f64) {
        self.word(value.to_bits());
    }
}

/// Writes the image into the first bytes of `image`. Commits nothing.
pub(crate) fn save(system: &System<'_>, image: &mut [u8]) -> Result<(), Error> {
    system.sound()?;
    let needed = system.layout.snapshot_bytes();
    let Some(image) = image.get_mut(..needed) else {
        return Err(Error::new(Code::ShortBuffer, "image", image.len() as f64, needed as f64));
    };
    let (chunks, _) = image.as_chunks_mut::<8>();
    let mut writer = Writer { chunks: chunks.iter_mut(), hash: Hash::default() };
    let checksum = writer.words_of(system);
    writer.word(checksum);
    Ok(())
}

/// A hash of the whole state, row-major and unpadded. Commits nothing.
pub(crate) fn digest(system: &System<'_>) -> u64 {
    Writer { chunks: [].iter_mut(), hash: Hash::default() }.words_of(system)
}

pub(super) fn header(system: &System<'_>) -> [u64; HEADER_WORDS] {
    [MAGIC, FORMAT, fingerprint(&system.scene, system.model.limits.dt), system.layout.snapshot_bytes() as u64 / 8]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::image::frame_words;
    use crate::tests::{saved, sim, torn_by_a_sphere, word_of};

    #[test]
    fn an_image_begins_with_its_name_version_scene_and_length() {
        let scene = torn_by_a_sphere();
        let sim = sim(&scene);
        let image = saved(&sim);
        assert_eq!(&image[..8], b"FABRSNAP");
        assert_eq!(word_of(&image, 1), FORMAT);
        assert_eq!(word_of(&image, 2), fingerprint(&scene, sim.step_limits().dt));
        assert_eq!(8 * word_of(&image, 3), image.len() as u64);
        // Then the scalar state; a word a row; 6 numbers and 2 moments a node; history, energy error and
        // given, last strain and viscous stress a segment; a bit a node in words of 32, a checksum.
        let words = frame_words(sim.layout().has) + 21 + 8 * 441 + 5 * (2 * 20 * 21) + 441_usize.div_ceil(32);
        assert_eq!(image.len(), 8 * words);
    }
}
