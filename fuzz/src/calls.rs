//! C calls in any order with odd arguments, against a model.
//!
//! The model of a simulation is one in Rust that takes the same steps, and a little bookkeeping: whether bands have it, what
//! failure is latched, what fk_get_fault should say. It predicts the status of every call; after every call the state must be
//! the model's, bit for bit, so that a refused call that changed anything is found at once.

use crate::bytes::Bytes;
use crate::memory::{Block, at, from, into, nowhere, to};
use crate::scene::{Get, bytes_of, digest, empty, is_failure};
use crate::small;
use fabric::{CacheLine, Code, Error, Failure, Layout, Motion, OutcomeSet, Path, Scene, Sim};
use fabric_capi::calls::*;
use fabric_capi::types::*;
use fabric_capi::{Input, Lent, Output, ToChange, ToLookAt, fk_sim};
use std::ptr::{null, null_mut};

const NULL: i32 = Code::NullPointer.number();
const MISALIGNED: i32 = Code::Misaligned.number();
const SIZE: i32 = Code::StructSize.number();
const LENGTH: i32 = Code::WrongLength.number();
const SHORT: i32 = Code::ShortBuffer.number();
const TURN: i32 = Code::BandOutOfTurn.number();
const STARTED: i32 = Code::AlreadyStarted.number();
const MOVED: i32 = Code::MovedBlock.number();
/// Most calls of one input.
const MOST_CALLS: usize = 24;

/// The bands that have a simulation.
struct InBands {
    of: u32,
    /// Bits of the bands called in this pass.
    claimed: u32,
    /// What the last pass failed with.
    failed: Option<i32>,
    _scratch: Block,
}

/// A simulation in C and its model.
struct Slot {
    handle: *mut fk_sim,
    block: Block,
    twin: Sim<'static>,
    _memory: Block,
    bands: Option<InBands>,
    /// What fk_get_fault says.
    last: i32,
    /// The model's digest before the call.
    before: u64,
}

/// The number of a call's result.
fn number<E: Into<Error>>(result: Result<(), E>) -> i32 {
    result.map_or_else(|error| error.into().code.number(), |()| FK_OK)
}

/// A simulation in Rust in memory of its own.
fn twin(scene: &Scene) -> Result<(Sim<'static>, Block), Error> {
    let layout = Layout::of(scene)?;
    let memory = Block::new(layout.bytes());
    // SAFETY: a block of this length, aligned, filled, and kept as long as the simulation.
    let lines = unsafe { std::slice::from_raw_parts_mut(memory.start().cast::<CacheLine>(), layout.lines()) };
    Ok((Sim::new(scene, lines)?, memory))
}

/// An argument that may be odd: where it is, the memory that keeps it, and the status that it must give if it is.
struct Given<T> {
    pointer: *mut T,
    /// What is said to be its size, or an array's length.
    size: u64,
    kept: Block,
    refused: Option<i32>,
}

/// A structure: sound, null, misaligned, or of an unknown size.
fn structure<T: Copy>(bytes: &mut Bytes, value: T) -> Given<T> {
    let (size, kind) = (size_of::<T>(), bytes.below(16));
    let kept = Block::new(size + if kind == 14 { 8 } else { 0 });
    let sound = size as u64;
    // SAFETY: room for the structure at its start, or 4 bytes behind it.
    let pointer = unsafe { kept.start().add(if kind == 14 { 4 } else { 0 }).cast::<T>() };
    // SAFETY: as above.
    unsafe { pointer.write_unaligned(value) };
    match kind {
        13 => Given { pointer: null_mut(), size: sound, kept, refused: Some(NULL) },
        14 => Given { pointer, size: sound, kept, refused: Some(MISALIGNED) },
        15 => {
            let size = bytes.odd_count(sound);
            Given { pointer, size, kept, refused: (size != sound).then_some(SIZE) }
        }
        _ => Given { pointer, size: sound, kept, refused: None },
    }
}

/// A scene, which says its size itself.
fn scene_structure(bytes: &mut Bytes, scene: &Scene) -> Given<fk_scene> {
    let given = structure(bytes, fk_scene::of(*scene));
    if !given.pointer.is_null() {
        // SAFETY: the structure's first word.
        unsafe { given.pointer.cast::<u64>().write_unaligned(given.size) };
    }
    given
}

/// An array of numbers as long as is asked for, or not; null; misaligned.
fn array(bytes: &mut Bytes, values: &[f64]) -> Given<f64> {
    let (kind, wanted) = (bytes.below(16), values.len());
    let length = if kind == 13 { bytes.below(2 * wanted.min(100) + 2) } else { wanted };
    let kept = Block::new(8 * length.max(wanted) + 8 * usize::from(kind == 14));
    // SAFETY: room for the numbers at its start, or 4 bytes behind it.
    let pointer = unsafe {
        kept.start().cast::<f64>().copy_from_nonoverlapping(values.as_ptr(), wanted);
        kept.start().add(if kind == 14 { 4 } else { 0 }).cast::<f64>()
    };
    let size = if kind == 15 { u64::MAX / bytes.choose(&[1, 2, 8]) } else { length as u64 };
    match kind {
        12 => Given { pointer: null_mut(), size, kept, refused: Some(NULL) },
        14 => Given { pointer, size, kept, refused: Some(MISALIGNED) },
        _ => Given { pointer, size, kept, refused: (size != wanted as u64).then_some(LENGTH) },
    }
}

impl Slot {
    /// The handle for a call that changes the simulation.
    fn to_change(&self) -> ToChange {
        // SAFETY: a live handle, whose block and scratch the slot keeps; one thread makes all calls.
        unsafe { ToChange::given(self.handle) }
    }

    /// The handle for a call that looks.
    fn to_look_at(&self) -> ToLookAt {
        // SAFETY: as above.
        unsafe { ToLookAt::given(self.handle) }
    }

    /// What a call on the sound handle is refused with whatever else it says. `lives`: a latched failure does not stop it.
    fn stopped(&self, lives: bool) -> Option<i32> {
        if self.bands.is_some() {
            return Some(TURN);
        }
        self.twin.failure().filter(|_| !lives).map(|failure| failure.code().number())
    }

    /// The status of a call with an array of `n` numbers that must come before the first step.
    fn before_start(
        &mut self,
        given: &Given<f64>,
        n: usize,
        model: impl FnOnce(&mut Sim<'static>) -> Result<(), Error>,
    ) -> i32 {
        let refused = given.refused.filter(|&status| status != LENGTH || given.size > 1 << 40);
        self.stopped(false).or(refused).unwrap_or_else(|| match self.twin.step_count() {
            0 if given.size == n as u64 => number(model(&mut self.twin)),
            0 => LENGTH,
            _ => STARTED,
        })
    }

    /// The state in C is the model's.
    fn check(&self) {
        // SAFETY: a live handle; structures of this function.
        unsafe {
            if let Some(bands) = &self.bands {
                let (mut passes, mut steps, mut outcomes) = (0, 0, 0);
                let places = (into(&mut passes), into(&mut steps), into(&mut outcomes));
                assert_eq!(fk_bands_progress(self.to_look_at(), places.0, places.1, places.2), FK_OK);
                assert!(steps <= passes && outcomes < 16 && (bands.failed.is_none() || passes > 0));
                assert_eq!(digest(self.handle), Err(TURN));
                return;
            }
            let expected = self.twin.failure().map_or_else(|| Ok(self.twin.digest()), |f| Err(f.code().number()));
            assert_eq!(digest(self.handle), expected);
            let (mut counters, mut fault): (fk_counters, fk_fault) = (empty(), empty());
            assert_eq!(fk_get_counters(self.to_look_at(), into(&mut counters), bytes_of::<fk_counters>()), FK_OK);
            assert_eq!(fk_get_fault(self.to_look_at(), into(&mut fault), bytes_of::<fk_fault>()), FK_OK);
            let ours = self.twin.counters();
            assert_eq!((counters.steps, counters.failed_segments), (ours.steps, ours.failed_segments));
            assert_eq!(fault.status, self.last);
            assert!((fault.text[0] == 0) == (fault.status == FK_OK) && fault.text.contains(&0));
        }
    }
}

/// Where an input stands.
struct Player<'d> {
    bytes: Bytes<'d>,
    slots: [Option<Slot>; 2],
    /// Images saved so far, and altered ones.
    images: Vec<Vec<u8>>,
    path: Option<Path>,
    stepped: bool,
}

/// The target.
pub fn run(data: &[u8]) -> bool {
    let bytes = Bytes::new(data);
    let mut player = Player { bytes, slots: [None, None], images: Vec::new(), path: None, stepped: false };
    player.init(0);
    for _ in 0..MOST_CALLS {
        if player.bytes.is_empty() {
            break;
        }
        let place = usize::from(player.bytes.once_in(8));
        match player.slots[place].take() {
            None => player.init(place),
            Some(mut slot) => {
                let lives = player.call(&mut slot);
                player.stepped |= slot.twin.step_count() > 0;
                if lives {
                    slot.check();
                    player.slots[place] = Some(slot);
                }
            }
        }
    }
    // What bands are left with is completed, as a host must.
    for slot in player.slots.iter_mut().flatten() {
        player.stepped |= slot.twin.step_count() > 0;
        if slot.bands.is_some() {
            slot.end_bands();
            slot.check();
        }
    }
    player.stepped
}

impl Player<'_> {
    /// fk_init, with anything odd.
    fn init(&mut self, place: usize) {
        let bytes = &mut self.bytes;
        let scene = small::scene(bytes);
        // Most of them with nothing odd: the calls that follow need a simulation.
        let mut nothing = Bytes::new(&[]);
        let bytes = if bytes.once_in(4) { bytes } else { &mut nothing };
        let given = scene_structure(bytes, &scene);
        let mut size = 0;
        let sound = fk_scene::of(scene);
        // SAFETY: structures and numbers of this function; the block is as long as it is said to be.
        unsafe {
            let sized = fk_memory_size(at(&sound), into(&mut size));
            let ours = Layout::of(&scene);
            assert_eq!(sized, number(ours.map(|_| ())));
            let odd = bytes.below(32);
            let block = Block::new(size.max(64) as usize + if odd == 28 { 8 } else { 0 });
            let mut length = size;
            let mut memory = block.start();
            let mut refused = None;
            match odd {
                28 => memory = memory.add(1 + usize::from(bytes.byte()) % 8),
                29 => {
                    length = u64::from(bytes.byte()) * size / 256;
                    refused = Some(SHORT);
                }
                30 => memory = null_mut(),
                _ => {}
            }
            let mut handle = null_mut();
            let out = if odd == 31 { null_mut() } else { &raw mut handle };
            let fault = structure(bytes, fk_fault::of(&Error::plain(Code::NullPointer, "")));
            let fault_null = fault.pointer.is_null();

            let made = twin(&scene);
            let expected = fault
                .refused
                .filter(|_| !fault_null)
                .or((odd == 30 || odd == 31).then_some(NULL))
                .or(given.refused)
                .or((sized != FK_OK).then_some(sized))
                .or(refused)
                .unwrap_or(made.as_ref().map_or_else(|error| error.code.number(), |_| FK_OK));
            let status = fk_init(
                Lent::given(memory.cast()),
                length,
                Input::given(given.pointer),
                Output::given(out),
                Output::given(fault.pointer),
                fault.size,
            );
            assert_eq!(status, expected);
            if status != FK_OK {
                assert!(handle.is_null() && block.untouched());
                assert!(fault.refused.is_some() || (*fault.pointer).status == status);
                return;
            }
            let Ok((twin, memory)) = made else { unreachable!() };
            let slot = Slot { handle, block, twin, _memory: memory, bands: None, last: FK_OK, before: 0 };
            slot.check();
            self.slots[place] = Some(slot);
        }
    }

    /// One call on a simulation. false: the host lets go of it.
    fn call(&mut self, slot: &mut Slot) -> bool {
        slot.before = slot.twin.digest();
        // A handle that is none, is not aligned, or is that of a copied block: nothing is looked at.
        match self.bytes.below(32) {
            29 => self.on_no_handle(null_mut(), NULL),
            // SAFETY: inside the block.
            30 => self.on_no_handle(unsafe { slot.handle.cast::<u8>().add(8).cast() }, MOVED),
            31 => {
                let copy = Block::new(slot.block.bytes());
                // SAFETY: two blocks of this length.
                unsafe { copy.start().copy_from_nonoverlapping(slot.block.start(), copy.bytes()) };
                self.on_no_handle(copy.start().cast(), MOVED);
            }
            _ => {}
        }
        match self.bytes.below(24) {
            0..5 => self.advance(slot),
            5 => self.advance_until(slot),
            6..8 => self.follow(slot),
            8 => self.load_force(slot),
            9 => self.set_motion(slot),
            10 => self.set_stretch(slot),
            11 => {
                let expected = if slot.bands.is_some() { TURN } else { FK_OK };
                // SAFETY: a live handle.
                assert_eq!(unsafe { fk_reset(slot.to_change()) }, expected);
                if expected == FK_OK {
                    slot.twin.reset();
                    slot.last = FK_OK;
                }
            }
            12 => self.save(slot),
            13..15 => self.load(slot),
            15 => self.bands_begin(slot),
            16..18 => self.bands_pass(slot),
            18 => slot.end_bands(),
            19..21 => self.get(slot),
            21 => self.copy(slot),
            22 => self.get_numbers(slot),
            _ => return slot.bands.is_some() || !self.bytes.once_in(4),
        }
        true
    }

    /// Calls on what is not a live handle.
    fn on_no_handle(&mut self, handle: *mut fk_sim, expected: i32) {
        let mut number = 0;
        let mut image = [0; 8];
        let zero = [0.0; 3];
        // SAFETY: null, or readable memory as large as a handle; structures and arrays of this function.
        let status = unsafe {
            let (to_change, to_look_at) = (|| ToChange::given(handle), || ToLookAt::given(handle));
            match self.bytes.below(16) {
                0 => fk_step(to_change()),
                1 => fk_advance(to_change(), u64::MAX),
                2 => fk_advance_until(to_change(), 15, u64::MAX, nowhere()),
                3 => fk_follow(to_change(), Input::given(null()), 0, 1),
                4 => fk_set_external_load(to_change(), from(&zero), from(&zero)),
                5 => fk_set_motion(to_change(), Input::given(null()), Input::given(null()), 0),
                6 => fk_set_largest_stretch(to_change(), Input::given(null()), 0),
                7 => fk_reset(to_change()),
                8 => fk_state_save(to_look_at(), to(&mut image), 8),
                9 => fk_state_load(to_change(), from(&image), 8),
                10 => fk_bands_begin(to_change(), 2, 0, Lent::given(null_mut()), 0),
                11 => fk_bands_pass(to_look_at(), 0, nowhere()),
                12 => fk_bands_end(to_change()),
                13 => fk_bands_progress(to_look_at(), nowhere(), nowhere(), nowhere()),
                14 => fk_get_fault(to_look_at(), into(&mut empty()), bytes_of::<fk_fault>()),
                _ => fk_digest(to_look_at(), into(&mut number)),
            }
        };
        assert_eq!(status, expected);
    }

    /// A few steps; after a failure, which ends the call at once, any number.
    fn steps(&mut self, slot: &Slot) -> u64 {
        let few = match self.bytes.below(16) {
            15 => 70,
            steps => steps as u64 % 6,
        };
        if slot.stopped(false).is_some() { self.bytes.odd_count(few) } else { few }
    }

    fn advance(&mut self, slot: &mut Slot) {
        let steps = self.steps(slot);
        let one = steps == 1 && self.bytes.once_in(2);
        let expected = slot.stopped(false).unwrap_or_else(|| number(slot.twin.advance(steps)));
        // SAFETY: a live handle.
        let status = unsafe { if one { fk_step(slot.to_change()) } else { fk_advance(slot.to_change(), steps) } };
        assert_eq!(status, expected);
        slot.note(status);
    }

    fn advance_until(&mut self, slot: &mut Slot) {
        let (steps, mask) = (self.steps(slot), u32::from(self.bytes.byte()));
        let mut taken = u64::MAX;
        let place = if self.bytes.once_in(4) { null_mut() } else { &raw mut taken };
        let ours = match slot.stopped(false) {
            Some(status) => Err(status),
            None => {
                slot.twin.advance_until(OutcomeSet::from_bits(mask), steps).map_err(|failure| failure.code().number())
            }
        };
        // SAFETY: a live handle, and a number or null.
        let status = unsafe { fk_advance_until(slot.to_change(), mask, steps, Output::given(place)) };
        assert_eq!(status, ours.err().unwrap_or(FK_OK));
        assert_eq!(taken, if place.is_null() { u64::MAX } else { ours.unwrap_or(u64::MAX) });
        slot.note(status);
    }

    fn follow(&mut self, slot: &mut Slot) {
        let bytes = &mut self.bytes;
        let repeated = self.path.filter(|_| bytes.once_in(3));
        let path = repeated.unwrap_or_else(|| {
            let mut path = Path { first: slot.twin.step_count(), steps: 1 + bytes.below(8) as u64, end: ahead(slot) };
            let end = &mut path.end;
            match bytes.below(12) {
                6 => path.first = bytes.odd_count(path.first),
                7 => path.steps = bytes.odd_count(path.steps),
                8 => end.position[bytes.below(3)] = bytes.odd(1e-3),
                9 => end.velocity[bytes.below(3)] = bytes.odd(100.0),
                10 => end.orientation[bytes.below(4)] = bytes.odd(0.5),
                11 => end.angular_velocity[bytes.below(3)] = bytes.odd(1e4),
                _ => {}
            }
            path
        });
        self.path = Some(path);
        let steps = if bytes.once_in(4) { bytes.odd_count(path.steps) } else { path.steps };
        // A long path is sound, and takes as long as asked for.
        let steps = if steps > 64 && steps <= path.steps { 8 } else { steps };
        let given = structure(bytes, path);
        let expected = slot.stopped(false).or(given.refused).unwrap_or_else(|| number(slot.twin.follow(&path, steps)));
        // SAFETY: a live handle and a structure of this function.
        let status = unsafe { fk_follow(slot.to_change(), Input::given(given.pointer), given.size, steps) };
        assert_eq!(status, expected);
        slot.note(status);
    }

    fn load_force(&mut self, slot: &mut Slot) {
        let bytes = &mut self.bytes;
        let mut load = [0.0; 6];
        for _ in 0..bytes.below(3) {
            load[bytes.below(6)] = bytes.odd(10.0);
        }
        let null_one = bytes.below(16);
        let pointer = |k: usize| if null_one == 14 + k { null() } else { load[3 * k..].as_ptr() };
        let (force, torque) = ([load[0], load[1], load[2]], [load[3], load[4], load[5]]);
        let expected = slot.stopped(false).unwrap_or_else(|| match null_one {
            14.. => NULL,
            _ => number(slot.twin.set_external_load(force, torque)),
        });
        // SAFETY: a live handle, and arrays of three or null.
        let status =
            unsafe { fk_set_external_load(slot.to_change(), Input::given(pointer(0)), Input::given(pointer(1))) };
        assert_eq!(status, expected);
        slot.note(status);
    }

    fn set_motion(&mut self, slot: &mut Slot) {
        let bytes = &mut self.bytes;
        let n = 3 * slot.twin.layout().nodes();
        let (mut positions, mut velocities) = (vec![0.0; n], vec![0.0; n]);
        let _ = slot.twin.copy_positions(&mut positions);
        for _ in 0..bytes.below(4) {
            let k = bytes.below(n.min(256));
            match bytes.below(4) {
                0 => velocities[k] = bytes.odd(10.0),
                1 => positions[k] = bytes.odd(positions[k]),
                _ => positions[k] += 1e-4 * bytes.factor(),
            }
        }
        let x = array(bytes, &positions);
        // As long as is said; a length that no array can have is refused before it is read.
        velocities.resize(if x.size > 1 << 40 { n } else { x.size as usize }, 0.0);
        let expected = slot.before_start(&x, n, |twin| twin.set_motion(&positions, &velocities));
        let v = exactly(&velocities);
        // SAFETY: a live handle, and arrays of this function of the length said, or refused before they are read.
        let status =
            unsafe { fk_set_motion(slot.to_change(), Input::given(x.pointer), Input::given(v.start().cast()), x.size) };
        assert_eq!(status, expected);
        slot.note(status);
    }

    fn set_stretch(&mut self, slot: &mut Slot) {
        let bytes = &mut self.bytes;
        let n = slot.twin.layout().segments();
        let mut stretches = vec![1.0; n];
        for _ in 0..bytes.below(4) {
            stretches[bytes.below(n.min(256))] = bytes.odd(1.03);
        }
        let given = array(bytes, &stretches);
        let expected = slot.before_start(&given, n, |twin| twin.set_largest_stretch(&stretches));
        // SAFETY: a live handle and an array of this function.
        let status = unsafe { fk_set_largest_stretch(slot.to_change(), Input::given(given.pointer), given.size) };
        assert_eq!(status, expected);
        slot.note(status);
    }

    fn save(&mut self, slot: &mut Slot) {
        let bytes = &mut self.bytes;
        let size = slot.twin.snapshot_bytes();
        let length = match bytes.below(8) {
            6 => bytes.byte() as usize * size / 256,
            7 => size + 8,
            _ => size,
        };
        let null_image = bytes.once_in(16);
        let kept = Block::new(length);
        let expected = slot.stopped(false).unwrap_or(if null_image {
            NULL
        } else if length < size {
            SHORT
        } else {
            FK_OK
        });
        let image = if null_image { null_mut() } else { kept.start() };
        // SAFETY: a live handle and a block of this length.
        unsafe {
            assert_eq!(fk_state_save(slot.to_look_at(), Output::given(image), length as u64), expected);
            if expected == FK_OK {
                let image = std::slice::from_raw_parts(kept.start(), size).to_vec();
                assert!(slot.twin.load(&image).is_ok(), "the image of a sound simulation");
                self.images.push(image);
            } else {
                assert!(kept.untouched());
            }
        }
    }

    fn load(&mut self, slot: &mut Slot) {
        let bytes = &mut self.bytes;
        let Some(mut image) = self.images.get(bytes.below(self.images.len().max(1))).cloned() else { return };
        match bytes.below(8) {
            6 => {
                let length = bytes.byte() as usize * image.len() / 256;
                image.truncate(length);
            }
            7 => {
                let place = bytes.word() as usize % image.len();
                image[place] ^= bytes.byte();
            }
            _ => {}
        }
        let null_image = bytes.once_in(16);
        let expected =
            slot.stopped(true).unwrap_or_else(|| if null_image { NULL } else { number(slot.twin.load(&image)) });
        let pointer = if null_image { null() } else { image.as_ptr() };
        // SAFETY: a live handle and an array of this length.
        let status = unsafe { fk_state_load(slot.to_change(), Input::given(pointer), image.len() as u64) };
        assert_eq!(status, expected);
        slot.note(status);
    }

    fn bands_begin(&mut self, slot: &mut Slot) {
        let bytes = &mut self.bytes;
        let of = if bytes.once_in(8) { bytes.odd_count(4) as u32 } else { 1 + bytes.below(5) as u32 };
        let lines = slot.twin.layout().band_lines(of);
        let mut size = 0;
        // SAFETY: a live handle; scratch as long as is said.
        unsafe {
            let sized = slot.stopped(false).unwrap_or(number(lines.map(|_| ())));
            assert_eq!(fk_bands_size(slot.to_look_at(), of, into(&mut size)), sized);
            let odd = bytes.below(16);
            let length = if odd == 15 { size.saturating_sub(1 + u64::from(bytes.byte())) } else { size };
            let scratch = Block::new(length as usize + if odd == 14 { 8 } else { 0 });
            let pointer = match odd {
                13 => null_mut(),
                14 => scratch.start().add(1 + length as usize % 8),
                _ => scratch.start(),
            };
            // What the cut needs is looked at before a latched failure.
            let in_use = slot.bands.is_some().then_some(TURN);
            let expected = in_use.or(lines.err().map(|error| error.code.number())).unwrap_or(match odd {
                13 => NULL,
                15 if sized == FK_OK => SHORT,
                _ => sized,
            });
            let status = fk_bands_begin(slot.to_change(), of, 100, Lent::given(pointer.cast()), length);
            if sized == FK_OK || in_use.is_some() || lines.is_err() {
                assert_eq!(status, expected);
            } else {
                // After a failure there is no size: any of these.
                assert!([NULL, SHORT, sized].contains(&status));
            }
            if status == FK_OK {
                slot.bands = Some(InBands { of, claimed: 0, failed: None, _scratch: scratch });
            }
        }
    }

    fn bands_pass(&mut self, slot: &mut Slot) {
        // Some bands of a pass, or the whole of one.
        let (first, count) = (self.bytes.below(8) as u32, if self.bytes.once_in(2) { 8 } else { 1 });
        for band in (0..count).map(|k| (first + k) % 8) {
            let mut last = 7;
            // SAFETY: a live handle and a number.
            let status = unsafe { fk_bands_pass(slot.to_look_at(), band, into(&mut last)) };
            let Some(bands) = &mut slot.bands else {
                assert_eq!((status, last), (TURN, 7));
                continue;
            };
            if band >= bands.of {
                assert_eq!(status, Code::OutOfRange.number());
            } else if let Some(failed) = bands.failed {
                assert_eq!(status, failed);
            } else if bands.claimed >> band & 1 == 1 {
                assert_eq!(status, TURN);
            } else {
                bands.claimed |= 1 << band;
                let complete = bands.claimed == u32::MAX >> (32 - bands.of);
                if complete {
                    bands.claimed = 0;
                }
                if status == FK_OK {
                    assert_eq!(last, u32::from(complete));
                } else {
                    assert!(complete && is_failure(status), "fk_bands_pass: {status}");
                    bands.failed = Some(status);
                }
            }
        }
    }

    /// A structure of results.
    fn get(&mut self, slot: &Slot) {
        fn one<H, T: Copy>(bytes: &mut Bytes, slot: &Slot, lives: bool, handle: H, call: Get<H, T>) {
            let given = structure(bytes, empty::<T>());
            // SAFETY: initialised bytes of a block of this length.
            let content = || unsafe { std::slice::from_raw_parts(given.kept.start(), given.kept.bytes()) }.to_vec();
            let before = content();
            let expected = slot.stopped(lives).or(given.refused).unwrap_or(FK_OK);
            // SAFETY: a live handle and a structure of this function.
            assert_eq!(unsafe { call(handle, Output::given(given.pointer), given.size) }, expected);
            assert!(expected == FK_OK || content() == before, "written by a refused call");
        }
        let bytes = &mut self.bytes;
        match bytes.below(10) {
            0 => one(bytes, slot, false, slot.to_look_at(), fk_get_step_limits),
            1 => one(bytes, slot, false, slot.to_look_at(), fk_get_grid),
            2 => one(bytes, slot, false, slot.to_look_at(), fk_get_projectile),
            3 => one(bytes, slot, false, slot.to_look_at(), fk_get_contact),
            4 => one(bytes, slot, false, slot.to_look_at(), fk_get_support),
            5 => one(bytes, slot, false, slot.to_look_at(), fk_get_energy),
            6 => one(bytes, slot, false, slot.to_change(), fk_get_fabric),
            7 => one(bytes, slot, false, slot.to_look_at(), fk_get_outcome),
            8 => one(bytes, slot, true, slot.to_look_at(), fk_get_counters),
            _ => one(bytes, slot, true, slot.to_look_at(), fk_get_fault),
        }
    }

    /// An array of results.
    fn copy(&mut self, slot: &Slot) {
        let (nodes, segments) = (3 * slot.twin.layout().nodes(), slot.twin.layout().segments());
        let bytes = &mut self.bytes;
        let kind = bytes.below(4);
        let given = array(bytes, &vec![7.0; if kind < 2 { nodes } else { segments }]);
        let expected = slot.stopped(false).or(given.refused).unwrap_or(FK_OK);
        let call = [fk_copy_positions, fk_copy_velocities, fk_copy_damage, fk_copy_stretch][kind];
        // SAFETY: a live handle and an array of this function.
        assert_eq!(unsafe { call(slot.to_look_at(), Output::given(given.pointer), given.size) }, expected);
    }

    /// Single numbers.
    fn get_numbers(&mut self, slot: &Slot) {
        let stopped = slot.stopped(false);
        let some = !self.bytes.once_in(3);
        let (mut count, mut seconds, mut residual) = (0, 0.0, [0.0; 3]);
        let place = if some { &raw mut count } else { null_mut() };
        let needed = stopped.unwrap_or(if some { FK_OK } else { NULL });
        let three = if some { residual.as_mut_ptr() } else { null_mut() };
        let mut slip = empty::<fk_slip>();
        let curved = slot.twin.scene().sheet.radius != 0.0;
        let counted = stopped.unwrap_or(if curved { Code::DoesNotGoWith.number() } else { FK_OK });
        // SAFETY: a live handle, and numbers or null.
        unsafe {
            let out = Output::given(&raw mut slip);
            assert_eq!(fk_get_slip(slot.to_look_at(), 2e-4, 0.1, 0.0, out, size_of::<fk_slip>() as u64), counted);
            assert!((0..3).all(|k| slip.slipping[k] <= slip.crossings[k]));
            assert_eq!(
                fk_get_time(slot.to_look_at(), Output::given(place), into(&mut seconds)),
                stopped.unwrap_or(FK_OK)
            );
            assert_eq!(fk_state_size(slot.to_look_at(), Output::given(place)), needed);
            assert_eq!(fk_digest(slot.to_look_at(), Output::given(place)), needed);
            assert_eq!(fk_get_momentum_residual(slot.to_look_at(), Output::given(three)), needed);
            let of = if slot.bands.is_some() { FK_OK } else { TURN };
            assert_eq!(fk_bands_progress(slot.to_look_at(), Output::given(place), nowhere(), nowhere()), of);
        }
    }
}

/// Numbers in memory of exactly their length.
fn exactly(values: &[f64]) -> Block {
    let kept = Block::new(8 * values.len());
    // SAFETY: a block of this length.
    unsafe { kept.start().cast::<f64>().copy_from_nonoverlapping(values.as_ptr(), values.len()) };
    kept
}

/// Where the body coasts to in four steps.
fn ahead(slot: &Slot) -> Motion {
    let still = Motion {
        position: [0.0; 3],
        velocity: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: [0.0; 3],
    };
    let motion = slot.twin.projectile().unwrap_or(still);
    let seconds = 4.0 * slot.twin.step_limits().dt;
    Motion { position: [0, 1, 2].map(|k| motion.position[k] + seconds * motion.velocity[k]), ..motion }
}

impl Slot {
    /// What fk_get_fault says after a call that changes the simulation.
    fn note(&mut self, status: i32) {
        if status != FK_OK && self.bands.is_none() {
            self.last = status;
            let same = self.twin.failure().is_some() || self.twin.digest() == self.before;
            assert!(same, "a refused call has changed the state");
        }
    }

    /// fk_bands_end; the model takes the steps that the bands have taken.
    fn end_bands(&mut self) {
        // SAFETY: a live handle, whose bands are in no call.
        let status = unsafe { fk_bands_end(self.to_change()) };
        if self.bands.take().is_none() {
            assert_eq!(status, TURN);
            return;
        }
        let mut counters: fk_counters = empty();
        let size = bytes_of::<fk_counters>();
        // SAFETY: a live handle and a structure of this function.
        let got = unsafe { fk_get_counters(self.to_look_at(), into(&mut counters), size) };
        assert_eq!(got, FK_OK);
        let taken = counters.steps - self.twin.step_count();
        assert_eq!(self.twin.advance(taken), Ok(()), "the steps of the bands, taken one by one");
        if status != FK_OK {
            let failure: Result<(), Failure> = self.twin.advance(1);
            assert_eq!(number(failure), status, "the failure of the bands");
            self.last = status;
        }
    }
}
