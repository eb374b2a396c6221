//! Saved states: copies of an instance in memory, and their form as bytes.
//!
//! A state holds everything of [`Kept`] and the kernel's snapshot image. As bytes: little-endian 64-bit
//! words, no pointers:
//! magic, version, token, length, the words of `Kept`, the image, a checksum. Another process on another
//! machine can restore it.

use crate::instance::{Instance, Running, Trouble};
use crate::kept::{Kept, Phase, Saved};
use crate::log::{Status, line};
use crate::starts::Starts;
use crate::table::EVENTS;
use fabric_capsule::Call;
use fabric_kernel::Hash;
use fabric_kernel::Sim;
use fabric_kernel::fields::SLOTS;

const MAGIC: u64 = u64::from_le_bytes(*b"FABRFMUS");
/// Version of the bytes' meaning.
const FORMAT: u64 = 3;
const HEADER_WORDS: usize = 4;
/// Words of `Kept` (tested against the traversal).
const KEPT_WORDS: usize = 1 + SLOTS + 13 + 12 + 3 + 6 + 2 + 2 + 2;
const FRAME_BYTES: usize = 8 * (HEADER_WORDS + KEPT_WORDS + 1);

impl Instance {
    /// Copies the present state. A state given by the host is written over, if its memory is large enough.
    pub fn save(&mut self, given: *mut Saved) -> Result<*mut Saved, Status> {
        let image = self.begun().map_or(0, |running| running.sim.snapshot_bytes());
        if let Some(failure) = self.begun().and_then(|running| running.sim.failure()) {
            return Err(self.refuse(failure.code().words()));
        }
        let reused = self.states.find(given);
        if reused.is_none() && !given.is_null() {
            return Err(self.no_state());
        }
        let pointer = if reused.is_some_and(|saved| saved.room() >= image) {
            given
        } else {
            let Some(saved) = self.states.add(&self.kept, image, true) else { return Err(self.out_of_memory(image)) };
            let pointer = saved.pointer();
            self.states.remove(given);
            pointer
        };
        if let Some(saved) = self.states.find_mut(pointer) {
            saved.kept = self.kept;
            saved.image = image;
            // Until the image is wholly ours it is one to be loaded with every check.
            saved.from_bytes = true;
            if image > 0
                && let Some(running) = &self.running
                && let Err(error) = running.sim.save(saved.image_mut())
            {
                return Err(self.refuse(&error.text()));
            }
            saved.from_bytes = false;
        }
        Ok(pointer)
    }

    /// Frees a state of this instance.
    pub fn free(&mut self, saved: *mut Saved) -> Result<(), Status> {
        if saved.is_null() || self.states.remove(saved) { Ok(()) } else { Err(self.no_state()) }
    }

    /// Refuses a state.
    fn no_state(&self) -> Status {
        self.refuse("not a state of this instance")
    }

    /// Puts the instance into a saved state. On an error nothing has changed.
    pub fn restore(&mut self, saved: *const Saved) -> Result<(), Status> {
        let saved = self.states.find(saved).ok_or_else(|| self.no_state())?;
        let (kept, from_bytes, image) = (saved.kept, saved.from_bytes, saved.image());
        if image.is_empty() {
            self.capsule.end(None);
            self.running = None;
            self.restored(&kept);
            return Ok(());
        }
        let scene = *kept.parameters.scene();
        let load = |sim: &mut Sim<'_>| if from_bytes { sim.load(image) } else { sim.load_kept(image) };
        let loaded = match &mut self.running {
            Some(running) if *running.sim.scene() == scene => {
                load(&mut running.sim).map(|()| self.capsule.note(&running.sim, &Call::Load(image)))
            }
            _ => match Running::new(&scene) {
                Ok(mut running) => load(&mut running.sim).map(|()| {
                    // A capsule has one scene.
                    self.capsule.end(None);
                    self.running = Some(running);
                }),
                Err(Trouble::Refused(error)) => Err(error),
                Err(Trouble::OutOfMemory(bytes)) => return Err(self.out_of_memory(bytes)),
            },
        };
        loaded.map_err(|error| self.refuse(&error.text()))?;
        self.restored(&kept);
        Ok(())
    }

    /// Bytes of a state of this instance.
    pub fn serialized_size(&self, saved: *const Saved) -> Result<usize, Status> {
        let saved = self.states.find(saved).ok_or_else(|| self.no_state())?;
        Ok(FRAME_BYTES + saved.image)
    }

    /// Writes a state into bytes.
    pub fn serialize(&self, saved: *const Saved, bytes: &mut [u8]) -> Result<(), Status> {
        let saved = self.states.find(saved).ok_or_else(|| self.no_state())?;
        let (mut kept, image) = (saved.kept, saved.image());
        let total = FRAME_BYTES + image.len();
        let Some(bytes) = bytes.get_mut(..total) else {
            let have = bytes.len();
            let text = line(format_args!("serialized state: the buffer has {have} bytes, needed are {total}"));
            return Err(self.refuse(&text));
        };
        let mut words = bytes.as_chunks_mut::<8>().0.iter_mut();
        let mut hash = Hash::default();
        let mut write = |word: u64| {
            hash.word(word);
            if let Some(place) = words.next() {
                *place = word.to_le_bytes();
            }
            word
        };
        for word in [MAGIC, FORMAT, Starts::read().map_or(0, |starts| starts.token), total as u64] {
            write(word);
        }
        visit(&mut kept, &mut write);
        for word in image.as_chunks::<8>().0 {
            write(u64::from_le_bytes(*word));
        }
        let checksum = hash.value();
        if let Some(place) = words.next() {
            *place = checksum.to_le_bytes();
        }
        Ok(())
    }

    /// Makes a state from bytes. Anything but an unchanged image of the same build is refused.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<*mut Saved, Status> {
        let malformed = "serialized state: altered, or none";
        let (words, _) = bytes.as_chunks::<8>();
        let header = [0, 1, 2, 3].map(|k| words.get(k).map(|word| u64::from_le_bytes(*word)));
        if header[0] != Some(MAGIC) {
            return Err(self.refuse(malformed));
        }
        if let Some(needed) = header[3].filter(|&needed| needed != bytes.len() as u64) {
            let have = bytes.len();
            return Err(self.refuse(&line(format_args!("serialized state: it has {have} bytes, needed are {needed}"))));
        }
        let Some((checksum, body)) = words.split_last().filter(|_| bytes.len() >= FRAME_BYTES) else {
            return Err(self.refuse(malformed));
        };
        let mut at = body.iter().map(|word| u64::from_le_bytes(*word)).skip(4);
        if header[1] != Some(FORMAT) || header[2] != Some(Starts::read().map_or(0, |starts| starts.token)) {
            return Err(self.refuse("serialized state: of another version"));
        }
        let mut hash = Hash::default();
        body.iter().for_each(|word| hash.word(u64::from_le_bytes(*word)));
        if hash.value() != u64::from_le_bytes(*checksum) {
            return Err(self.refuse(malformed));
        }
        let mut kept = self.kept;
        if !visit(&mut kept, &mut |_| at.next().unwrap_or(0)) {
            return Err(self.refuse(malformed));
        }
        let image = bytes.len() - FRAME_BYTES;
        let Some(saved) = self.states.add(&kept, image, true) else { return Err(self.out_of_memory(image)) };
        for (place, word) in saved.image_mut().as_chunks_mut::<8>().0.iter_mut().zip(at) {
            *place = word.to_le_bytes();
        }
        Ok(saved.pointer())
    }
}

/// Passes every word of `kept` through `word`, which returns what to keep: one traversal for writing and
/// reading.
/// False if a word makes no sense.
fn visit(kept: &mut Kept, word: &mut impl FnMut(u64) -> u64) -> bool {
    let number = word(kept.phase as u32 as u64);
    let Some(phase) = Phase::ALL.into_iter().find(|&phase| phase as u32 as u64 == number) else { return false };
    kept.phase = phase;
    if !kept.parameters.visit(word) {
        return false;
    }
    let mut real = |value: &mut f64| *value = f64::from_bits(word(value.to_bits()));
    real(&mut kept.start_time);
    real(&mut kept.stop_time);
    real(&mut kept.time);
    kept.force_mean.iter_mut().for_each(&mut real);
    kept.torque_mean.iter_mut().for_each(&mut real);
    real(&mut kept.interface_residual);
    real(&mut kept.interface_gap);
    let mut known = true;
    for flag in [&mut kept.terminated, &mut kept.driven] {
        let number = word(u64::from(*flag));
        known &= number <= 1;
        *flag = number == 1;
    }
    for number in [&mut kept.shown.status, &mut kept.shown.happened] {
        let kept = word(u64::from(*number));
        known &= kept < 1 << EVENTS;
        *number = kept as u32;
    }
    known
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kept::States;
    use crate::log::{Log, Logger};
    use core::ptr;

    #[test]
    fn the_traversal_has_the_stated_length() {
        let mut instance = Instance::new(Log::new(Logger::Two(None), ptr::null_mut(), c"", false));
        let mut words = 0;
        assert!(visit(&mut instance.kept, &mut |word| {
            words += 1;
            word
        }));
        assert_eq!(words, KEPT_WORDS);
    }

    #[test]
    fn states_are_found_reused_and_freed() {
        let mut instance = Instance::new(Log::new(Logger::Two(None), ptr::null_mut(), c"", false));
        let first = instance.save(ptr::null_mut()).unwrap();
        let second = instance.save(ptr::null_mut()).unwrap();
        assert_eq!(instance.save(first).unwrap(), first);
        let mut bytes = std::vec![0; instance.serialized_size(second).unwrap()];
        assert_eq!(instance.serialize(second, &mut bytes), Ok(()));
        assert!(instance.deserialize(&bytes).is_ok());
        bytes[40] ^= 1;
        assert!(instance.deserialize(&bytes).is_err());
        assert_eq!(instance.free(first), Ok(()));
        assert_eq!(instance.free(first), Err(Status::Error));
        assert_eq!(instance.restore(second), Ok(()));
    }

    #[test]
    fn many_states_are_freed_in_a_small_stack() {
        let thread = std::thread::Builder::new().stack_size(1 << 17).spawn(|| {
            let instance = Instance::new(Log::new(Logger::Two(None), ptr::null_mut(), c"", false));
            let mut states = States::default();
            assert!((0..20_000).all(|_| states.add(&instance.kept, 8, false).is_some()));
        });
        assert!(thread.unwrap().join().is_ok());
    }
}
