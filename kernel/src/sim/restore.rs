//! Takes a snapshot image back.
//!
//! Method: loading is all or nothing. The whole image is checked before anything is changed: its header and
//! checksum, and that every value is one that a simulation can have. A second pass takes the values.
//! Limits: an image that is kept in the caller's memory may be taken without a look at its checksum.

use crate::body::pose::Vector;
use crate::ground::error::{Code, Error};
use crate::ground::hash::Hash;
use crate::ground::planes::{self, Axis, CHUNK, MOMENT, VISCOUS_STRESS};
use crate::memory::layout::HEADER_WORDS;
use crate::memory::state::{COUNT_MAX, State, Visitor};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::clamp::LET_GO;
use crate::sheet::slack::GIVEN;
use crate::sheet::weave::in_runs;
use crate::sim::snapshot::header;
use crate::sim::start::LARGEST_STRETCH;
use crate::step::explicit;
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

/// Puts the simulation into the state of an image made with the same scene, on any target. Clears a failure.
/// On an error nothing has changed.
pub(crate) fn load(system: &mut System<'_>, image: &[u8]) -> Result<(), Error> {
    let body = body_of(system, image)?;
    let mut hash = Hash::default();
    body.iter().for_each(|word| hash.word(u64::from_le_bytes(*word)));
    let checksum = image.last_chunk().map_or(0, |word| u64::from_le_bytes(*word));
    if hash.value() != checksum {
        return Err(malformed(0.0, 0.0));
    }
    restore(system, body)
}

/// [`load`] without a look at the checksum.
pub(crate) fn load_kept(system: &mut System<'_>, image: &[u8]) -> Result<(), Error> {
    let body = body_of(system, image)?;
    restore(system, body)
}

/// The words of an image before its checksum, if it is one of this scene.
fn body_of<'b>(system: &System<'_>, image: &'b [u8]) -> Result<&'b [[u8; 8]], Error> {
    let needed = system.layout.snapshot_bytes();
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
    state.visit(system.layout.has, &mut reader);
    let arrays = reader.chunks.as_slice();
    if !reader.sound || !plausible(&state) || !arrays_sound(system, arrays) {
        return Err(Error::plain(Code::ImageInvalid, "image"));
    }

    // Second pass: take them.
    system.state = state;
    let mut words = arrays;
    // After a failure nothing is taken for granted.
    let failed = system.failure.is_some();
    system.refill(|system, j| read_row(system, j, &mut words) | failed);
    explicit::start_forces(system);
    for (flags, &word) in system.arrays.flags.iter_mut().zip(words) {
        *flags = u64::from_le_bytes(word) as u32;
    }
    Ok(())
}

/// Looks at the words of the arrays: motion whose energy is finite, histories such as there are, fixed nodes
/// at rest, flags 32 bits wide.
fn arrays_sound(system: &System<'_>, mut words: &[[u8; 8]]) -> bool {
    // A segment breaks long before: only one that was broken beforehand has such a history.
    let largest = twice_strain_at(LARGEST_STRETCH);
    let possible = -LARGEST_MOTION..=LARGEST_MOTION;
    let (across, layout) = (system.layout.x.segments(), system.layout);
    let (slack, drawn) = (system.layout.has(Feature::Slack), system.layout.has(Feature::Strength));
    let clamps = layout.has(Feature::Clamps);
    let mut sound = true;
    for (j, run) in system.arrays.rows.runs.iter().enumerate() {
        let strength = planes::row(system.arrays.rows.strength, system.layout.chunks, j);
        let verticals = layout.has_verticals(j);
        if slack {
            let Some((&been_slack, rest)) = words.split_first() else { return false };
            sound &= u64::from_le_bytes(been_slack) <= 3;
            words = rest;
        }
        for i in 0..system.layout.nodes_x {
            let Some((node, rest)) = words.split_first_chunk::<6>() else { return false };
            let node = node.map(real);
            let moves = node[3..].iter().fold(false, |moves, &v| moves | (v != 0.0));
            sound &= node.iter().fold(true, |sound, x| sound & possible.contains(x))
                & !(moves && in_runs(run, i) && !clamps);
            words = rest;
            sound &= !clamps || words.first().is_some_and(|&slid| real(slid) >= 0.0 && real(slid) <= LET_GO);
            words = words.get(usize::from(clamps)..).unwrap_or_default();
            let viscous = layout.has(Feature::Viscosity);
            sound &= takes_numbers(&mut words, if viscous { 2 } else { 0 });
            for (axis, exists) in [(Axis::Horizontal, i < across), (Axis::Vertical, verticals)] {
                if !exists {
                    continue;
                }
                // Of a segment without damage, and the least of one with it.
                let (whole, critical) = if drawn {
                    let own = planes::get(strength, axis as usize, i).map_or(0.0, twice_strain_at);
                    (own, own)
                } else {
                    (0.0, system.direction(axis, j).critical)
                };
                let Some((&q, rest)) = words.split_first() else { return false };
                let q = real(q);
                sound &= (q == whole) | (q == FAILED) | ((q > critical) & (q <= largest));
                words = rest;
                sound &= takes_numbers(&mut words, if slack { 2 } else { 0 });
                sound &= takes_numbers(&mut words, if viscous { 2 } else { 0 });
            }
        }
    }
    sound && words.iter().all(|flags| u64::from_le_bytes(*flags) <= u64::from(u32::MAX))
}

/// Takes so many words off the front. Whether they are numbers that a fabric can have.
fn takes_numbers(words: &mut &[[u8; 8]], count: usize) -> bool {
    let Some((numbers, rest)) = words.split_at_checked(count) else { return false };
    *words = rest;
    numbers.iter().all(|&word| (-LOST..=LOST).contains(&real(word)))
}

/// Takes the words of row j, which are sound, off the front. Returns whether a history has changed.
fn read_row(system: &mut System<'_>, j: usize, words: &mut &[[u8; 8]]) -> bool {
    let mut changed = false;
    let (nx, chunks) = (system.layout.nodes_x, system.layout.chunks);
    let (across, layout) = (system.layout.x.segments(), system.layout);
    let row = planes::row_mut(system.arrays.rows.hot, chunks, j);
    let history = planes::row_mut(system.arrays.rows.history, chunks, j);
    let owed = planes::row_mut(system.arrays.rows.owed, chunks, j);
    if let Some(been_slack) = system.arrays.rows.been_slack.get_mut(j) {
        let Some((&word, rest)) = words.split_first() else { return true };
        (*been_slack, *words) = (u64::from_le_bytes(word) as u32, rest);
    }
    let past = planes::row_mut(system.arrays.rows.past, chunks, j);
    let slid = system.arrays.rows.slid.get_mut(j * chunks..(j + 1) * chunks).unwrap_or_default();
    let verticals = layout.has_verticals(j);
    for (c, (hot, history)) in row.iter_mut().zip(history).enumerate() {
        #[allow(clippy::needless_range_loop)] // The lane is a place in several planes.
        for lane in 0..CHUNK.min(nx.saturating_sub(c * CHUNK)) {
            let i = c * CHUNK + lane;
            let Some((node, rest)) = words.split_first_chunk::<6>() else { return true };
            *words = rest;
            for (plane, &word) in hot.iter_mut().zip(node) {
                plane[lane] = real(word);
            }
            if let Some(slid) = slid.get_mut(c) {
                let Some((&word, rest)) = words.split_first() else { return true };
                (slid[lane], *words) = (real(word), rest);
            }
            if let Some(past) = past.get_mut(c) {
                let Some(([x, y], rest)) = words.split_first_chunk() else { return true };
                (past[MOMENT][lane], past[MOMENT + 1][lane]) = (real(*x), real(*y));
                *words = rest;
            }
            for (axis, exists) in [(0, i < across), (1, verticals)] {
                if !exists {
                    continue;
                }
                let Some((&largest, rest)) = words.split_first() else { return true };
                let largest = real(largest);
                changed |= history[axis][lane] != largest;
                history[axis][lane] = largest;
                *words = rest;
                if let Some(owed) = owed.get_mut(c) {
                    let Some(([energy, given], rest)) = words.split_first_chunk() else { return true };
                    (owed[axis][lane], owed[GIVEN + axis][lane]) = (real(*energy), real(*given));
                    *words = rest;
                }
                if let Some(past) = past.get_mut(c) {
                    let Some(([twice_strain, stress], rest)) = words.split_first_chunk() else { return true };
                    (past[axis][lane], past[VISCOUS_STRESS + axis][lane]) = (real(*twice_strain), real(*stress));
                    *words = rest;
                }
            }
        }
    }
    changed
}

/// A word of an image as a number.
#[inline(always)]
fn real(word: [u8; 8]) -> f64 {
    f64::from_bits(u64::from_le_bytes(word))
}

/// Bytes that are no image, or not an unchanged one.
fn malformed(value: f64, limit: f64) -> Error {
    Error::new(Code::ImageMalformed, "image", value, limit)
}

/// Scalar values beyond being finite: unit quaternions, a path that covers the present step and a load that
/// began before it.
fn plausible(state: &State) -> bool {
    let unit = |q: &nalgebra::Quaternion<f64>| {
        let squared = q.w * q.w + q.i * q.i + q.j * q.j + q.k * q.k;
        squared > 0.99 && squared < 1.01
    };
    let track = &state.track;
    let path = track.steps == 0 || track.first <= state.step;
    let still = |v: &Vector| v.iter().all(|x| x.is_finite());
    state.loaded <= state.step + 1
        && unit(&state.body.orientation)
        && unit(&track.start.orientation)
        && unit(&track.end.orientation)
        && path
        && still(&state.body.velocity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::projectile::{Body, Motion};
    use crate::ground::error::Failure;
    use crate::memory::layout::{STATE_WORDS, frame_words};
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
        let (critical, first) = (sim.system.directions.front.horizontal.critical, sim.digest());
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
        // displacements, three velocities, and for each segment that starts there its history, what it owes
        // and what it gave.
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
                for owed in [1, 2] {
                    check(at + owed, (-1e-9_f64).to_bits(), true);
                    check(at + owed, f64::NAN.to_bits(), false);
                }
                at += 3;
            }
        }
        // One word of flags for 20 nodes, and the checksum.
        check(at, u64::from(u32::MAX), true);
        check(at, u64::from(u32::MAX) + 1, false);
        assert_eq!(8 * (at + 2), image.len());
        // The last bit of a number, a count or a flag is seen by the digest, but in what would tell of the
        // first contact (step, direction, energy), of four outcomes (step, work) and of a rebound (work),
        // were there any.
        let seen = (HEADER_WORDS..frame_words(layout.has) - 1).filter(|&at| {
            sim.load(&forged(&image, at, word_of(&image, at) ^ 1)).unwrap();
            sim.digest() != first
        });
        assert_eq!(seen.count(), STATE_WORDS - (1 + 3 + 1) - 4 * 2 - 1);
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

    #[test]
    fn an_image_of_a_sheet_damaged_everywhere_brings_back_its_stiffness() {
        let scene = torn_by_a_sphere();
        let [mut first, mut other] = [sim(&scene), sim(&scene)];
        first.set_largest_stretch(&std::vec![1.031; first.layout().segments()]).unwrap();
        other.load(&saved(&first)).unwrap();
        first.advance(100).unwrap();
        other.advance(100).unwrap();
        assert_eq!(other.digest(), first.digest());
    }

    /// A simulation goes on from an image as it did from there: one just made, one of other damage, and one
    /// that has failed, whose arrays may hold anything.
    #[test]
    fn an_image_brings_back_the_whole_simulation() {
        let scene = torn_by_a_sphere();
        let ahead = 100;
        let [mut first, mut second, mut sim] = [sim(&scene), sim(&scene), sim(&scene)];
        let images = [0, 400, 400, 400, 400].map(|steps| {
            first.advance(steps).unwrap();
            (saved(&first), first.digest(), first.counters().failed_segments)
        });
        let later = [ahead, 400, 400, 400, 400].map(|steps| {
            second.advance(steps).unwrap();
            second.digest()
        });
        let failed_segments = [0, 3, 4].map(|k: usize| images[k].2);
        assert!(failed_segments[0] == 0 && failed_segments.is_sorted_by(|a, b| a < b), "{failed_segments:?}");
        for failed in [false, true] {
            for k in [4, 0, 3, 4, 4] {
                if failed {
                    sim.system.failure = Some(Failure::NonFinite);
                    // What follows from the histories.
                    sim.system
                        .arrays
                        .rows
                        .hot
                        .iter_mut()
                        .for_each(|chunk| chunk[6..].as_flattened_mut().fill(f64::NAN));
                }
                let (image, digest, failed_segments) = &images[k];
                sim.load(image).unwrap();
                assert_eq!((sim.digest(), sim.counters().failed_segments), (*digest, *failed_segments));
                assert!(saved(&sim) == *image);
                sim.advance(ahead).unwrap();
                assert_eq!(sim.digest(), later[k], "{failed} {k}");
            }
        }
    }
}
