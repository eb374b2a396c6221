//! Takes a snapshot image back.
//!
//! Method: loading is all or nothing. The whole image is checked before anything is changed: its header and
//! checksum, and that every value is one that a simulation can have. A second pass takes the values.
//! Limits: an image that is kept in the caller's memory may be taken without a look at its checksum.

use crate::ground::error::{Code, Error};
use crate::ground::hash::Hash;
use crate::ground::planes::{self, Axis, SPEED_X};
use crate::memory::image::{self, Array, HEADER_WORDS, NumberPlace};
use crate::memory::network::Network;
use crate::memory::state::{COUNT_MAX, State, Visitor};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::clamp::{self, LET_GO};
use crate::sheet::weave::in_runs;
use crate::sim::simulation::Sim;
use crate::sim::snapshot::header;
use crate::sim::start::LARGEST_STRETCH;
use crate::step::one_step;
use crate::yarn::law::{FAILED, LOST, twice_strain_at};

/// Displacements and velocities of an image, in spacings and spacings a step: beyond this their energy need
/// not be finite. A simulation that has not failed stays far below (see [`crate::yarn::law::LOST`]).
const LARGEST_MOTION: f64 = 1e100;

/// Reads words from bytes and notes values that no simulation can have.
struct Reader<'b> {
    chunks: core::slice::Iter<'b, [u8; 8]>,
    sound: bool,
}

impl Reader<'_> {
    fn word(&mut self) -> u64 {
        match self.chunks.next() {
            Some(chunk) => u64::from_le_bytes(*chunk),
            None => {
                self.sound = false;
                0
            }
        }
    }

    fn finite(&mut self) -> f64 {
        let value = f64::from_bits(self.word());
        self.sound &= value.is_finite();
        value
    }
}

impl Visitor for Reader<'_> {
    fn count(&mut self, value: &mut u64) {
        *value = self.word();
        self.sound &= *value <= COUNT_MAX;
    }
    fn flag(&mut self, value: &mut u64) {
        *value = self.word();
        self.sound &= *value <= 1;
    }
    fn real(&mut self, value: &mut f64) {
        *value = self.finite();
    }
}

impl Sim<'_> {
    /// Puts the simulation into the state of an image made with the same scene, on any target. Clears a
    /// failure. On an error nothing has changed. Needs the feature `snapshot`.
    pub fn load(&mut self, image: &[u8]) -> Result<(), Error> {
        let body = body_of(&self.system, image)?;
        let mut hash = Hash::default();
        body.iter().for_each(|word| hash.word(u64::from_le_bytes(*word)));
        let checksum = image.last_chunk().map_or(0, |word| u64::from_le_bytes(*word));
        if hash.value() == checksum { restore(&mut self.system, body) } else { Err(malformed(0.0, 0.0)) }
    }

    /// [`Sim::load`] for an image that has not left this program since [`Sim::save`] wrote it: its checksum,
    /// which finds what happens to bytes on their way, is not looked at. Everything else is.
    pub fn load_kept(&mut self, image: &[u8]) -> Result<(), Error> {
        let body = body_of(&self.system, image)?;
        restore(&mut self.system, body)
    }
}

/// The words of an image before its checksum, if it is one of this scene.
fn body_of<'b>(system: &System<'_>, image: &'b [u8]) -> Result<&'b [[u8; 8]], Error> {
    Feature::Snapshot.needed_by("image")?;
    let needed = system.network.layout.snapshot_bytes();
    let header_bytes = image.get(..8 * HEADER_WORDS).ok_or(malformed(image.len() as f64, needed as f64))?;
    let mut found = Reader { chunks: header_bytes.as_chunks::<8>().0.iter(), sound: true };
    let [magic, format, print, words] = header(system);
    if found.word() != magic {
        return Err(malformed(0.0, 0.0));
    }
    if found.word() != format || found.word() != print {
        return Err(Error::plain(Code::ImageOfAnotherScene, "image"));
    }
    if found.word() != words || image.len() != needed {
        return Err(malformed(image.len() as f64, needed as f64));
    }
    let (_, body) = image.as_chunks::<8>().0.split_last().ok_or(malformed(0.0, needed as f64))?;
    Ok(body)
}

/// Takes the state that the words of an image hold, if it is one that a simulation can have.
fn restore(system: &mut System<'_>, body: &[[u8; 8]]) -> Result<(), Error> {
    // First pass: every value is one a simulation can have.
    let mut reader = Reader { chunks: body.iter(), sound: true };
    (0..HEADER_WORDS).for_each(|_| _ = reader.word());
    let mut state = system.state;
    state.visit(system.network.layout.has, &mut reader);
    let rows = Reader { chunks: reader.chunks.clone(), sound: true };
    rows_are_sound(&system.network, &mut reader);
    if !reader.sound || !plausible(&state) {
        return Err(Error::plain(Code::ImageInvalid, "image"));
    }

    // Second pass: take them.
    system.state = state;
    let mut reader = rows;
    // After a failure nothing is taken for granted.
    let failed = system.failure.is_some();
    system.refill(|network, j| read_row(network, j, &mut reader) | failed);
    one_step::start_forces(&mut system.network);
    system.network.arrays.flags.iter_mut().for_each(|flags| *flags = reader.word() as u32);
    Ok(())
}

/// Looks at the words of rows and bits of contact.
fn rows_are_sound(network: &Network<'_>, reader: &mut Reader<'_>) {
    let mut sound = true;
    for j in 0..network.layout.nodes_y {
        if network.arrays.rows.been_slack.get(j).is_some() {
            sound &= reader.word() <= 3;
        }
        image::traverse(&network.layout, j, |place| {
            sound &= can_be(network, j, place, f64::from_bits(reader.word()));
        });
    }
    for _ in 0..network.arrays.flags.len() {
        sound &= reader.word() <= u64::from(u32::MAX);
    }
    reader.sound &= sound;
}

/// Whether a simulation can have a number: motion whose energy is finite, with held nodes at rest where they
/// do not slide; histories such as there are.
#[inline(always)]
fn can_be(network: &Network<'_>, j: usize, place: NumberPlace, number: f64) -> bool {
    match place.array {
        Array::Hot => {
            let held = || network.arrays.rows.runs.get(j).is_some_and(|run| in_runs(run, place.i));
            let moves = place.plane >= SPEED_X && number != 0.0;
            let slides = || clamp::at(network.arrays.rows.clamps, 0).is_some();
            number.abs() <= LARGEST_MOTION && !(moves && !slides() && held())
        }
        Array::Clamps => (-LARGEST_MOTION..=LARGEST_MOTION).contains(&number) || number == LET_GO,
        Array::Past | Array::EnergyError => number.abs() <= LOST,
        Array::History => {
            let axis = if place.plane == 0 { Axis::Horizontal } else { Axis::Vertical };
            // History of a segment without damage, and the least of one with it.
            let (whole, critical) = if network.layout.has(Feature::Strength) {
                let strength = planes::row(network.arrays.rows.strength, network.layout.chunks, j);
                let own = planes::get(strength, place.plane, place.i).map_or(0.0, twice_strain_at);
                (own, own)
            } else {
                (0.0, network.direction(axis, j).critical)
            };
            // A segment breaks long before: only one that was broken beforehand has such a history.
            let damaged = number > critical && number <= twice_strain_at(LARGEST_STRETCH);
            number == whole || number == FAILED || damaged
        }
    }
}

/// Takes the words of row j, which are sound. Returns whether a history has changed.
fn read_row(network: &mut Network<'_>, j: usize, reader: &mut Reader<'_>) -> bool {
    if let Some(been_slack) = network.arrays.rows.been_slack.get_mut(j) {
        *been_slack = reader.word() as u32;
    }
    let (mut changed, mut numbers) = (false, network.arrays.rows.numbers_mut());
    image::traverse(&network.layout, j, |place| {
        let read = f64::from_bits(reader.word());
        if let Some(number) = numbers[place.array as usize].get_mut(place.at) {
            changed |= place.array == Array::History && *number != read;
            *number = read;
        }
    });
    changed
}

/// Bytes that are no image, or not an unchanged one.
fn malformed(value: f64, limit: f64) -> Error {
    Error::new(Code::ImageMalformed, "image", value, limit)
}

/// Scalar values beyond being finite: unit quaternions, a path that covers the present step and a load that
/// began before it.
fn plausible(state: &State) -> bool {
    let State { track, body, step, sums, .. } = state;
    let is_unit = |q: &nalgebra::Quaternion<f64>| {
        let squared = q.w * q.w + q.i * q.i + q.j * q.j + q.k * q.k;
        squared > 0.99 && squared < 1.01
    };
    let turns = [body.orientation, track.start.orientation, track.end.orientation];
    let path = track.steps == 0 || track.first <= *step;
    sums.loaded <= step + 1 && turns.iter().all(is_unit) && path && body.velocity.iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::projectile::{Body, Motion};
    use crate::memory::image::frame_words;
    use crate::tests::{AT_REST, saved, sheet, sim, torn_by_a_sphere, word_of};
    use std::vec::Vec;

    #[test]
    fn only_unit_quaternions_finite_speeds_and_paths_begun_are_plausible() {
        let state = State::at_start(Body::of(&Motion { orientation: [0.5, -0.5, 0.5, -0.5], ..AT_REST }));
        assert!(plausible(&state));
        let quaternion = |k: usize, squared: f64| {
            // Unequal parts; part k makes up the length.
            let mut parts = [0.3, -0.4, 0.5, 0.6];
            parts[k] = 0.0;
            let others: f64 = parts.iter().map(|part| part * part).sum();
            parts[k] = crate::ground::math::sqrt(squared - others);
            crate::body::pose::quaternion(parts)
        };
        for k in 0..4 {
            for (squared, sound) in [(0.98, false), (0.991, true), (1.0, true), (1.009, true), (1.02, false)] {
                let (mut body, mut start, mut end) = (state, state, state);
                body.body.orientation = quaternion(k, squared);
                start.track.start.orientation = quaternion(k, squared);
                end.track.end.orientation = quaternion(k, squared);
                assert_eq!([body, start, end].map(|state| plausible(&state)), [sound; 3], "{k} {squared}");
            }
        }
        for (steps, first, step, sound) in [(0, 9, 5, true), (3, 4, 5, true), (3, 5, 5, true), (3, 6, 5, false)] {
            let mut path = state;
            (path.track.steps, path.track.first, path.step) = (steps, first, step);
            assert_eq!(plausible(&path), sound, "{steps} {first} {step}");
        }
        for k in 0..3 {
            let mut fast = state;
            fast.body.velocity[k] = f64::INFINITY;
            assert!(!plausible(&fast));
        }
    }

    /// An image with one word changed and its checksum made anew.
    fn forged(image: &[u8], at: usize, word: u64) -> Vec<u8> {
        let mut image = image.to_vec();
        image[8 * at..8 * at + 8].copy_from_slice(&word.to_le_bytes());
        let body = image.len() - 8;
        let mut hash = Hash::default();
        image[..body].as_chunks::<8>().0.iter().for_each(|chunk| hash.word(u64::from_le_bytes(*chunk)));
        image[body..].copy_from_slice(&hash.value().to_le_bytes());
        image
    }

    #[test]
    fn each_word_of_an_image_is_taken_where_a_simulation_can_have_it_and_refused_elsewhere() {
        let mut scene = sheet(5, 4);
        (scene.yarn.stochastic, scene.track_detachment, scene.slack_balance) = (false, true, true);
        scene.attachment.kind = crate::scene::parts::AttachmentKind::TwoSides;
        let mut sim = sim(&scene);
        let (layout, image) = (*sim.layout(), saved(&sim));
        let (critical, first) = (sim.system.network.directions.front.horizontal.critical, sim.digest());
        let mut check = |at: usize, word: u64, sound: bool| {
            let forged = forged(&image, at, word);
            let found = sim.load(&forged);
            assert_eq!(
                found,
                if sound { Ok(()) } else { Err(Error::plain(Code::ImageInvalid, "image")) },
                "{at} {word:x}"
            );
            if sound {
                assert!(saved(&sim) == forged, "what was taken comes out again: {at} {word:x}");
                assert_eq!(sim.digest() == first, forged == image, "digests distinguish states: {at} {word:x}");
            }
        };
        // The step count, and row by row whether it has been slack, and the nodes in order: three
        // displacements, three velocities, and for each segment that starts there its history, energy
        // error and correcting stress.
        for at in HEADER_WORDS..frame_words(layout.has) - 1 {
            check(at, f64::NAN.to_bits(), false);
        }
        // After the step count the body: position, and a quaternion no longer of unit length.
        check(HEADER_WORDS + 4, 2.0_f64.to_bits(), false);
        check(HEADER_WORDS, COUNT_MAX, true);
        check(HEADER_WORDS, COUNT_MAX + 1, false);
        let mut at = frame_words(layout.has) - 1;
        for (i, j) in (0..4).flat_map(|j| (0..5).map(move |i| (i, j))) {
            if i == 0 {
                check(at, 3, true);
                check(at, 4, false);
                at += 1;
            }
            for k in 0..6 {
                check(at + k, f64::NAN.to_bits(), false);
                check(at + k, f64::INFINITY.to_bits(), false);
                // Left and right side are fixed: they may be elsewhere, but not move.
                check(at + k, 1e-3_f64.to_bits(), k < 3 || (1..4).contains(&i));
            }
            at += 6;
            for _ in 0..usize::from(i < 4) + usize::from(j < 3) {
                for (q, sound) in [(0.0, true), (critical, false), (critical.next_up(), true), (-0.1, false)] {
                    check(at, q.to_bits(), sound);
                }
                check(at, f64::NAN.to_bits(), false);
                for energy_error in [1, 2] {
                    check(at + energy_error, (-1e-9_f64).to_bits(), true);
                    check(at + energy_error, f64::NAN.to_bits(), false);
                }
                at += 3;
            }
        }
        // One word of flags for 20 nodes, and the checksum.
        check(at, u64::from(u32::MAX), true);
        check(at, u64::from(u32::MAX) + 1, false);
        assert_eq!(8 * (at + 2), image.len());
        // The last bit of a number, a count or a flag is seen by the digest, but in what would tell of the
        // first contact (step, direction, energy) and of five outcomes (step, work), were there any.
        let state = HEADER_WORDS..frame_words(layout.has) - 1;
        let seen = state.clone().filter(|&at| {
            sim.load(&forged(&image, at, word_of(&image, at) ^ 1)).unwrap();
            sim.digest() != first
        });
        assert_eq!(seen.count(), state.len() - (1 + 3 + 1) - 5 * 2);
    }

    #[test]
    fn two_wrong_numbers_of_a_node_are_refused_as_one_is() {
        let mut sim = sim(&torn_by_a_sphere());
        // The first node is fixed: it may not move.
        let (image, node) = (saved(&sim), frame_words(sim.layout().has));
        for (first, second) in (0..6).flat_map(|second| (0..second).map(move |first| (first, second))) {
            for number in [f64::INFINITY, 1e-3] {
                let once = forged(&image, node + first, number.to_bits());
                let found = sim.load(&forged(&once, node + second, number.to_bits()));
                assert_eq!(found.is_ok(), number.is_finite() && second < 3, "{first} {second} {number}");
            }
        }
    }
}
