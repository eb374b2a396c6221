//! Snapshot images and the digest.
//!
//! An image is a sequence of little-endian 64-bit words: magic, format version, fingerprint of the scene,
//! number of words, scalar state, then node by node (row-major, unpadded) displacement and velocity and the
//! history of the segments that start there, with `slack_balance` what each owes and gave, and before a row
//! in which directions segments have been slack; with viscosity its moments at the node, and of a segment the
//! last strain and viscous stress; contact flags, and a checksum. No pointers, no `usize`, no padding: the
//! same bytes on every target.
//! Limits: an image fits only the scene it was made with (`fingerprint.rs`).
//! The checksum finds every change of a single word; it is no protection against forgery.

use crate::ground::error::{Code, Error};
use crate::ground::hash::Hash;
use crate::ground::planes::{self, CHUNK, MOMENT, PAST_PLANES, VISCOUS_STRESS};
use crate::memory::layout::{HEADER_WORDS, MARK_WORDS};
use crate::memory::state::Visitor;
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::slack::GIVEN;
use crate::sim::fingerprint::fingerprint;

const MAGIC: u64 = u64::from_le_bytes(*b"FABRSNAP");
/// Version of the image's format; changes whenever its content or meaning does.
pub const FORMAT: u64 = 1;

impl Visitor for Hash {
    fn count(&mut self, value: &mut u64) {
        self.word(*value);
    }
    fn real(&mut self, value: &mut f64) {
        self.word(value.to_bits());
    }
    fn mark(&mut self, value: &mut f64) {
        if *value != 0.0 {
            self.word(value.to_bits());
        }
    }
    fn mark_count(&mut self, value: &mut u64) {
        if *value != 0 {
            self.word(*value);
        }
    }
}

/// Writes words into bytes and hashes them.
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
    for word in header(system) {
        writer.word(word);
    }
    let mut state = system.state;
    state.visit(system.layout.has, &mut writer);
    each_word(system, &mut |word| writer.word(word));
    let checksum = writer.hash.value();
    writer.word(checksum);
    Ok(())
}

/// A hash of the whole state, row-major and unpadded. Commits nothing.
pub(crate) fn digest(system: &System<'_>) -> u64 {
    let mut hash = Hash::default();
    let [magic, format, scene, words] = header(system);
    for word in [magic, format, scene, words - MARK_WORDS as u64] {
        hash.word(word);
    }
    let mut state = system.state;
    state.visit(system.layout.has, &mut hash);
    each_word(system, &mut |word| hash.word(word));
    hash.value()
}

pub(super) fn header(system: &System<'_>) -> [u64; HEADER_WORDS] {
    [MAGIC, FORMAT, fingerprint(&system.scene, system.model.limits.dt), system.layout.snapshot_bytes() as u64 / 8]
}

/// Every word of the node, segment and flag arrays, in image order.
fn each_word(system: &System<'_>, word: &mut impl FnMut(u64)) {
    let (nx, ny, chunks) = (system.layout.nodes_x, system.layout.nodes_y, system.layout.chunks);
    let (across, layout) = (system.layout.x.segments(), system.layout);
    let bits = |number: Option<f64>| number.map_or(0, f64::to_bits);
    for j in 0..ny {
        let (row, history) =
            (planes::row(system.arrays.rows.hot, chunks, j), planes::row(system.arrays.rows.history, chunks, j));
        let owed = planes::row(system.arrays.rows.owed, chunks, j);
        system.arrays.rows.been_slack.get(j).into_iter().for_each(|&been_slack| word(u64::from(been_slack)));
        let past = planes::row(system.arrays.rows.past, chunks, j);
        let verticals = layout.has_verticals(j);
        for i in 0..nx {
            (0..6).for_each(|plane| word(bits(planes::get(row, plane, i))));
            if let Some(slid) = system.arrays.rows.slid.get(j * chunks + i / CHUNK) {
                word(slid[i % CHUNK].to_bits());
            }
            if system.layout.has(Feature::Viscosity) {
                (MOMENT..PAST_PLANES).for_each(|plane| word(bits(planes::get(past, plane, i))));
            }
            for (axis, exists) in [(0, i < across), (1, verticals)] {
                if exists {
                    word(bits(planes::get(history, axis, i)));
                }
                if exists && system.layout.has(Feature::Slack) {
                    word(bits(planes::get(owed, axis, i)));
                    word(bits(planes::get(owed, GIVEN + axis, i)));
                }
                if exists && system.layout.has(Feature::Viscosity) {
                    word(bits(planes::get(past, axis, i)));
                    word(bits(planes::get(past, VISCOUS_STRESS + axis, i)));
                }
            }
        }
    }
    system.arrays.flags.iter().for_each(|&flags| word(flags as u64));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::projectile::Body;
    use crate::memory::layout::frame_words;
    use crate::memory::state::State;
    use crate::scene::features::{FEATURES, Features};
    use crate::tests::{AT_REST, saved, sim, torn_by_a_sphere, word_of};

    struct Counter(usize);
    impl Visitor for Counter {
        fn count(&mut self, _: &mut u64) {
            self.0 += 1;
        }
        fn real(&mut self, _: &mut f64) {
            self.0 += 1;
        }
    }

    #[test]
    fn state_words_are_counted_right() {
        let each = FEATURES.iter().map(|record| Features::NONE.with(record.feature));
        let both = Features::NONE.with(Feature::Viscosity).with(Feature::Rate);
        for features in each.chain([Features::NONE, both]) {
            let mut counter = Counter(0);
            State::at_start(Body::of(&AT_REST)).visit(features, &mut counter);
            assert_eq!(HEADER_WORDS + counter.0 + 1, frame_words(features));
        }
    }

    #[test]
    fn an_image_begins_with_its_name_version_scene_and_length() {
        let scene = torn_by_a_sphere();
        let sim = sim(&scene);
        let image = saved(&sim);
        assert_eq!(&image[..8], b"FABRSNAP");
        assert_eq!(word_of(&image, 1), FORMAT);
        assert_eq!(word_of(&image, 2), fingerprint(&scene, sim.step_limits().dt));
        assert_eq!(8 * word_of(&image, 3), image.len() as u64);
        // Then the scalar state; a word a row; 6 numbers and 2 moments a node; history, what is owed and
        // given, last strain and viscous stress a segment; a bit a node in words of 32, a checksum.
        let words = frame_words(sim.layout().has) + 21 + 8 * 441 + 5 * (2 * 20 * 21) + 441_usize.div_ceil(32);
        assert_eq!(image.len(), 8 * words);
    }
}
