//! C calls in any order with odd numbers, against a model.
//!
//! The model of a simulation is one in Rust that takes the same steps, and a little bookkeeping: whether
//! bands have it, what failure is latched, what fk_get_fault should say. It predicts the status of every
//! call; after every call the state must be the model's, bit for bit, so that a refused call that changed
//! anything is found at once. Pointers, sizes and handles that are wrong are tried in tests/c/host.c.

use crate::bytes::Bytes;
use crate::memory::{Block, at, from, into, nowhere, to};
use crate::scene::{bytes_of, digest, empty, got, is_failure};
use crate::small;
use fabric_capi::calls::*;
use fabric_capi::types::*;
use fabric_capi::{Input, Lent, Output, ToChange, ToLookAt, fk_sim};
use fabric_kernel::{CacheLine, Code, Error, Failure, Layout, Motion, OutcomeSet, Path, Scene, Sim};
use std::fmt::Debug;
use std::ptr::null_mut;

const TURN: i32 = Code::BandOutOfTurn.number();
const STARTED: i32 = Code::AlreadyStarted.number();
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
    _block: Block,
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

    /// What a call on the sound handle is refused with whatever else it says. `lives`: a latched failure does
    /// not stop it.
    fn stopped(&self, lives: bool) -> Option<i32> {
        if self.bands.is_some() {
            return Some(TURN);
        }
        self.twin.failure().filter(|_| !lives).map(|failure| failure.code().number())
    }

    /// The status of a call that must come before the first step.
    fn before_start(&mut self, model: impl FnOnce(&mut Sim<'static>) -> Result<(), Error>) -> i32 {
        self.stopped(false).unwrap_or_else(|| match self.twin.step_count() {
            0 => number(model(&mut self.twin)),
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
                assert!(steps <= passes && outcomes < 128 && (bands.failed.is_none() || passes > 0));
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
struct Caller<'d> {
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
    let mut caller = Caller { bytes, slots: [None, None], images: Vec::new(), path: None, stepped: false };
    caller.init(0);
    for _ in 0..MOST_CALLS {
        if caller.bytes.is_empty() {
            break;
        }
        let place = usize::from(caller.bytes.once_in(8));
        match caller.slots[place].take() {
            None => caller.init(place),
            Some(mut slot) => {
                let lives = caller.call(&mut slot);
                caller.stepped |= slot.twin.step_count() > 0;
                if lives {
                    slot.check();
                    caller.slots[place] = Some(slot);
                }
            }
        }
    }
    // What bands are left with is completed, as a host must.
    for slot in caller.slots.iter_mut().flatten() {
        caller.stepped |= slot.twin.step_count() > 0;
        if slot.bands.is_some() {
            slot.end_bands();
            slot.check();
        }
    }
    caller.stepped
}

impl Caller<'_> {
    /// fk_init of a scene that may be refused.
    fn init(&mut self, place: usize) {
        let scene = small::scene(&mut self.bytes);
        let (given, made) = (fk_scene::of(scene), twin(&scene));
        let (mut size, mut handle, mut fault) = (0, null_mut(), empty::<fk_fault>());
        // SAFETY: structures and numbers of this function; the block is as long as it is said to be.
        unsafe {
            let sized = fk_memory_size(at(&given), into(&mut size));
            assert_eq!(sized, number(Layout::of(&scene).map(|_| ())));
            let block = Block::new(size.max(64) as usize);
            let lent = Lent::given(block.start().cast());
            let status = fk_init(lent, size, at(&given), into(&mut handle), into(&mut fault), bytes_of::<fk_fault>());
            assert_eq!(status, made.as_ref().map_or_else(|error| error.code.number(), |_| FK_OK));
            let Ok((twin, memory)) = made else {
                assert!(handle.is_null() && block.untouched() && fault.status == status);
                return;
            };
            let slot = Slot { handle, _block: block, twin, _memory: memory, bands: None, last: FK_OK, before: 0 };
            slot.check();
            self.slots[place] = Some(slot);
        }
    }

    /// One call on a simulation. false: the host lets go of it.
    fn call(&mut self, slot: &mut Slot) -> bool {
        slot.before = slot.twin.digest();
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
        let expected = slot.stopped(false).unwrap_or_else(|| number(slot.twin.follow(&path, steps)));
        // SAFETY: a live handle and a structure of this function.
        let status = unsafe { fk_follow(slot.to_change(), at(&path), bytes_of::<Path>(), steps) };
        assert_eq!(status, expected);
        slot.note(status);
    }

    fn load_force(&mut self, slot: &mut Slot) {
        let bytes = &mut self.bytes;
        let mut load = [0.0; 6];
        for _ in 0..bytes.below(3) {
            load[bytes.below(6)] = bytes.odd(10.0);
        }
        let (force, torque) = ([load[0], load[1], load[2]], [load[3], load[4], load[5]]);
        let expected = slot.stopped(false).unwrap_or_else(|| number(slot.twin.set_external_load(force, torque)));
        // SAFETY: a live handle, and arrays of three.
        let status = unsafe { fk_set_external_load(slot.to_change(), from(&force), from(&torque)) };
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
        let expected = slot.before_start(|twin| twin.set_motion(&positions, &velocities));
        let (x, v) = (exactly(&positions), exactly(&velocities));
        // SAFETY: a live handle, and arrays of this function of the length said.
        let status = unsafe {
            let [x, v] = [&x, &v].map(|values| Input::given(values.start().cast()));
            fk_set_motion(slot.to_change(), x, v, n as u64)
        };
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
        let expected = slot.before_start(|twin| twin.set_largest_stretch(&stretches));
        let given = exactly(&stretches);
        // SAFETY: a live handle and an array of this function.
        let status = unsafe { fk_set_largest_stretch(slot.to_change(), Input::given(given.start().cast()), n as u64) };
        assert_eq!(status, expected);
        slot.note(status);
    }

    fn save(&mut self, slot: &mut Slot) {
        let kept = Block::new(slot.twin.snapshot_bytes());
        let expected = slot.stopped(false).unwrap_or(FK_OK);
        // SAFETY: a live handle and a block of this length.
        unsafe {
            let status = fk_state_save(slot.to_look_at(), Output::given(kept.start()), kept.bytes() as u64);
            assert_eq!(status, expected);
            if status == FK_OK {
                let image = std::slice::from_raw_parts(kept.start(), kept.bytes()).to_vec();
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
        let expected = slot.stopped(true).unwrap_or_else(|| number(slot.twin.load(&image)));
        // SAFETY: a live handle and an array of this length.
        let status = unsafe { fk_state_load(slot.to_change(), from(&image), image.len() as u64) };
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
            let scratch = Block::new(size as usize);
            // What the cut needs is looked at before a latched failure, after which there is no size.
            let in_use = slot.bands.is_some().then_some(TURN);
            let expected = in_use.or(lines.err().map(|error| error.code.number())).unwrap_or(sized);
            let status = fk_bands_begin(slot.to_change(), of, 100, Lent::given(scratch.start().cast()), size);
            let short = Code::ShortBuffer.number();
            assert!(status == expected || sized != FK_OK && lines.is_ok() && status == short, "{status} {expected}");
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

    /// A structure of results: the model's, to the bit.
    fn get(&mut self, slot: &mut Slot) {
        let kind = self.bytes.below(10);
        let (stopped, handle, last) = (slot.stopped(kind >= 8), slot.handle, slot.last);
        let twin = &mut slot.twin;
        // SAFETY: a live handle.
        unsafe {
            let sim = || ToLookAt::given(handle);
            match kind {
                0 => same(stopped, got(sim(), fk_get_step_limits), || sound(twin.step_limits())),
                1 => {
                    same(stopped, got(sim(), fk_get_grid).map(|grid| grid.plies), || sound(twin.layout().plies as u64))
                }
                2 => same(stopped, got(sim(), fk_get_projectile), || twin.projectile()),
                3 => same(stopped, got(sim(), fk_get_contact), || twin.contact()),
                4 => same(stopped, got(sim(), fk_get_support), || twin.support()),
                5 => same(stopped, got(sim(), fk_get_energy), || twin.energy()),
                6 => same(stopped, got(ToChange::given(handle), fk_get_fabric), || twin.fabric()),
                7 => {
                    let mask = got(sim(), fk_get_outcome).map(|outcome| outcome.mask);
                    same(stopped, mask, || sound(twin.outcomes().mask.bits()));
                }
                8 => same(stopped, got(sim(), fk_get_counters), || sound(twin.counters())),
                _ => same(stopped, got(sim(), fk_get_fault).map(|fault| fault.status), || sound(last)),
            }
        }
    }

    /// An array of results.
    fn copy(&mut self, slot: &Slot) {
        let (nodes, segments) = (3 * slot.twin.layout().nodes(), slot.twin.layout().segments());
        let kind = self.bytes.below(4);
        let mut values = vec![7.0; if kind < 2 { nodes } else { segments }];
        let mut ours = values.clone();
        let stopped = slot.stopped(false);
        let call = [fk_copy_positions, fk_copy_velocities, fk_copy_damage, fk_copy_stretch][kind];
        let model = [Sim::copy_positions, Sim::copy_velocities, Sim::copy_damage, Sim::copy_stretch][kind];
        // SAFETY: a live handle and an array of this function.
        let status = unsafe { call(slot.to_look_at(), to(&mut values), values.len() as u64) };
        assert_eq!(status, stopped.unwrap_or_else(|| number(model(&slot.twin, &mut ours))));
        assert_eq!(values, ours);
    }

    /// Single numbers, and structures that take some.
    fn get_numbers(&mut self, slot: &Slot) {
        let (stopped, twin) = (slot.stopped(false), &slot.twin);
        let expected = stopped.unwrap_or(FK_OK);
        let (mut count, mut seconds, mut residual) = (0, 0.0, [0.0; 3]);
        let (mut slip, mut ply) = (empty::<fk_slip>(), empty::<fk_ply>());
        let plies = twin.layout().plies as u32;
        // SAFETY: a live handle, and numbers.
        unsafe {
            let sim = || slot.to_look_at();
            let status = fk_get_slip(sim(), 2e-4, 0.1, 0.0, into(&mut slip), bytes_of::<fk_slip>());
            same(stopped, found(status, slip), || twin.slip(2e-4, 0.1, 0.0));
            for number in [0, plies - 1, plies] {
                let status = fk_get_ply(sim(), number, into(&mut ply), bytes_of::<fk_ply>());
                same(stopped, found(status, ply), || twin.ply(number));
            }
            let status = fk_get_time(sim(), into(&mut count), into(&mut seconds));
            same(stopped, found(status, (count, seconds)), || sound((twin.step_count(), twin.time())));
            let status = fk_state_size(sim(), into(&mut count));
            same(stopped, found(status, count), || sound(twin.snapshot_bytes() as u64));
            assert_eq!(fk_digest(sim(), into(&mut count)), expected);
            let status = fk_get_momentum_residual(sim(), to(&mut residual));
            same(stopped, found(status, residual), || twin.momentum_residual());
            let of = if slot.bands.is_some() { FK_OK } else { TURN };
            assert_eq!(fk_bands_progress(sim(), into(&mut count), nowhere(), nowhere()), of);
        }
    }
}

/// What a call in C found, or its status.
fn found<T>(status: i32, value: T) -> Result<T, i32> {
    if status == FK_OK { Ok(value) } else { Err(status) }
}

/// What the model always has.
fn sound<T>(value: T) -> Result<T, Error> {
    Ok(value)
}

/// Asserts that a call in C found what the model has; if something stops the call, that it says what.
#[track_caller]
fn same<T: PartialEq + Debug, E: Into<Error>>(
    stopped: Option<i32>,
    in_c: Result<T, i32>,
    model: impl FnOnce() -> Result<T, E>,
) {
    let model = || model().map_err(|error| error.into().code.number());
    assert_eq!(in_c, stopped.map_or_else(model, Err));
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
