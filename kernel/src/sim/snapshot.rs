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
use crate::scene::features::Feature;
use crate::sim::fingerprint::fingerprint;
use crate::sim::simulation::Sim;

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
        state.visit(system.network.layout.has, self);
        let rows = &system.network.arrays.rows;
        let numbers = rows.numbers();
        for j in 0..system.network.layout.nodes_y {
            rows.been_slack.get(j).into_iter().for_each(|&bits| self.word(u64::from(bits)));
            image::traverse(&system.network.layout, j, |place| {
                self.word(numbers[place.array as usize].get(place.at).map_or(0, |number| number.to_bits()));
            });
        }
        system.network.arrays.flags.iter().for_each(|&flags| self.word(u64::from(flags)));
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

impl Sim<'_> {
    /// Bytes of a snapshot image of this simulation.
    pub fn snapshot_bytes(&self) -> usize {
        self.system.network.layout.snapshot_bytes()
    }

    /// Writes the image into the first [`Sim::snapshot_bytes`] bytes of `image`. Commits nothing. Needs the
    /// feature `snapshot`.
    pub fn save(&self, image: &mut [u8]) -> Result<(), Error> {
        Feature::Snapshot.needed_by("image")?;
        self.system.sound()?;
        let (given, needed) = (image.len(), self.snapshot_bytes());
        let image = image.get_mut(..needed);
        let image = image.ok_or(Error::new(Code::ShortBuffer, "image", given as f64, needed as f64))?;
        let (chunks, _) = image.as_chunks_mut::<8>();
        let mut writer = Writer { chunks: chunks.iter_mut(), hash: Hash::default() };
        let checksum = writer.words_of(&self.system);
        writer.word(checksum);
        Ok(())
    }

    /// A hash of the whole state: equal digests mean equal bits. Row-major and unpadded, so independent of
    /// instruction set and number of threads. Commits nothing.
    pub fn digest(&self) -> u64 {
        Writer { chunks: [].iter_mut(), hash: Hash::default() }.words_of(&self.system)
    }
}

pub(super) fn header(system: &System<'_>) -> [u64; HEADER_WORDS] {
    [
        MAGIC,
        FORMAT,
        fingerprint(&system.network.scene, system.network.model.limits.dt),
        system.network.layout.snapshot_bytes() as u64 / 8,
    ]
}
