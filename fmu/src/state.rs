//! Saved states: copies of an instance in memory, and their form as bytes.
//!
//! A state holds everything of [`Kept`] and the kernel's snapshot image. As bytes: little-endian 64-bit words, no pointers:
//! magic, version, token, length, the words of `Kept`, the image, a checksum. Another process on another machine can restore it.

use crate::instance::{Instance, Kept, Phase, Running, Trouble};
use crate::log::Status;
use crate::memory;
use crate::table::{COUNT, SLOTS, TOKEN_HASH};
use core::ptr::{self, NonNull};
use fabric::Sim;
use fabric::snapshot::Hash;

const MAGIC: u64 = u64::from_le_bytes(*b"FABRFMUS");
/// Version of the bytes' meaning.
const FORMAT: u64 = 1;
const HEADER_WORDS: usize = 4;
/// Words of `Kept` (tested against the traversal).
const KEPT_WORDS: usize = SLOTS + COUNT + 1 + 13 + 3 + 1 + 9 + 1;
const FRAME_BYTES: usize = 8 * (HEADER_WORDS + KEPT_WORDS + 1);

/// A saved state. The kernel's image lies behind it in the same block.
pub struct Saved {
    next: *mut Saved,
    kept: Kept,
    /// Bytes of the image; 0 if there was no simulation yet.
    image: usize,
    /// Bytes there is room for.
    room: usize,
    /// Whether the image came as bytes from the host; else `save` wrote it.
    from_bytes: bool,
}

/// The states of an instance that its host holds; freed with it.
pub struct States(*mut Saved);

impl Default for States {
    fn default() -> States {
        States(ptr::null_mut())
    }
}

impl States {
    /// The state a host's pointer means, if it is one of this instance.
    fn find(&self, wanted: *const Saved) -> Option<NonNull<Saved>> {
        let mut at = self.0;
        while let Some(saved) = NonNull::new(at) {
            if saved.as_ptr().cast_const() == wanted {
                return Some(saved);
            }
            // SAFETY: the list holds only live blocks made by `add`.
            at = unsafe { saved.as_ref() }.next;
        }
        None
    }

    fn add(&mut self, kept: &Kept, image: usize, from_bytes: bool) -> Option<NonNull<Saved>> {
        let saved = memory::allocate::<Saved>(image)?;
        // SAFETY: a fresh block of the right size and alignment.
        unsafe { saved.write(Saved { next: self.0, kept: *kept, image, room: image, from_bytes }) };
        self.0 = saved.as_ptr();
        Some(saved)
    }

    /// Frees one state; false if it is none of this instance's.
    pub fn remove(&mut self, wanted: *mut Saved) -> bool {
        let Some(found) = self.find(wanted) else { return false };
        // SAFETY: found in the list, hence live.
        let next = unsafe { found.as_ref() }.next;
        if self.0 == wanted {
            self.0 = next;
        } else {
            let mut at = self.0;
            while let Some(mut before) = NonNull::new(at) {
                // SAFETY: the list holds only live blocks, and nothing else refers to them now.
                let before = unsafe { before.as_mut() };
                if before.next == wanted {
                    before.next = next;
                    break;
                }
                at = before.next;
            }
        }
        // SAFETY: made by `add`, and no longer in the list.
        unsafe { memory::release(found) };
        true
    }
}

impl Drop for States {
    fn drop(&mut self) {
        while !self.0.is_null() {
            self.remove(self.0);
        }
    }
}

/// The image behind a state.
///
/// # Safety
/// `saved` is live and nothing else refers to its image.
unsafe fn image_of<'a>(saved: NonNull<Saved>) -> &'a mut [u8] {
    // SAFETY: `add` made room for `room` >= `image` bytes behind the struct.
    unsafe {
        let length = (*saved.as_ptr()).image;
        core::slice::from_raw_parts_mut(saved.as_ptr().add(1).cast::<u8>(), length)
    }
}

impl Instance {
    /// Copies the present state. A state given by the host is written over, if its memory is large enough.
    pub fn save(&mut self, given: *mut Saved) -> Result<NonNull<Saved>, Status> {
        let image = self.running.as_ref().map_or(0, |running| running.sim.snapshot_bytes());
        if let Some(failure) = self.running.as_ref().and_then(|running| running.sim.failure()) {
            return Err(self.refuse(failure.code().text().to_str().unwrap_or("")));
        }
        let reused = if given.is_null() {
            None
        } else {
            Some(self.states.find(given).ok_or_else(|| self.refuse("not a state of this instance"))?)
        };
        let saved = match reused {
            // SAFETY: found in the list, hence live.
            Some(saved) if unsafe { saved.as_ref() }.room >= image => {
                // SAFETY: as above; nothing else refers to it.
                let state = unsafe { &mut *saved.as_ptr() };
                state.kept = self.kept;
                state.image = image;
                state.from_bytes = false;
                saved
            }
            _ => {
                let Some(saved) = self.states.add(&self.kept, image, false) else { return Err(self.out_of_memory()) };
                self.states.remove(given);
                saved
            }
        };
        if let Some(running) = &self.running {
            // SAFETY: live, and nothing else refers to its image.
            let bytes = unsafe { image_of(saved) };
            if let Err(error) = running.sim.save(bytes) {
                return Err(self.refuse(&error.text()));
            }
        }
        Ok(saved)
    }

    /// Frees a state of this instance.
    pub fn free(&mut self, saved: *mut Saved) -> Status {
        if saved.is_null() || self.states.remove(saved) {
            Status::Ok
        } else {
            self.refuse("not a state of this instance")
        }
    }

    /// Puts the instance into a saved state. On an error nothing has changed.
    pub fn restore(&mut self, saved: *const Saved) -> Status {
        let Some(saved) = self.states.find(saved) else { return self.refuse("not a state of this instance") };
        // SAFETY: found in the list, hence live; nothing else refers to it during this call.
        let (kept, from_bytes, image) =
            unsafe { ((*saved.as_ptr()).kept, (*saved.as_ptr()).from_bytes, &*image_of(saved)) };
        if image.is_empty() {
            self.running = None;
            self.restored(&kept);
            return Status::Ok;
        }
        let scene = kept.scene();
        let load = |sim: &mut Sim<'_>| if from_bytes { sim.load(image) } else { sim.load_kept(image) };
        let loaded = match &mut self.running {
            Some(running) if *running.sim.scene() == scene => load(&mut running.sim),
            _ => match Running::new(&scene) {
                Ok(mut running) => load(&mut running.sim).map(|()| self.running = Some(running)),
                Err(Trouble::Refused(error)) => Err(error),
                Err(Trouble::OutOfMemory) => return self.out_of_memory(),
            },
        };
        match loaded {
            Ok(()) => {
                self.restored(&kept);
                Status::Ok
            }
            Err(error) => self.refuse(&error.text()),
        }
    }

    /// Bytes of a state of this instance.
    pub fn serialized_size(&self, saved: *const Saved) -> Result<usize, Status> {
        let saved = self.states.find(saved).ok_or_else(|| self.refuse("not a state of this instance"))?;
        // SAFETY: found in the list, hence live.
        Ok(FRAME_BYTES + unsafe { saved.as_ref() }.image)
    }

    /// Writes a state into bytes.
    pub fn serialize(&self, saved: *const Saved, bytes: &mut [u8]) -> Status {
        let Some(saved) = self.states.find(saved) else { return self.refuse("not a state of this instance") };
        // SAFETY: found in the list, hence live; nothing else refers to it during this call.
        let (mut kept, image) = unsafe { ((*saved.as_ptr()).kept, &*image_of(saved)) };
        let total = FRAME_BYTES + image.len();
        let Some(bytes) = bytes.get_mut(..total) else { return self.refuse("serialized state: buffer too short") };
        let mut words = bytes.as_chunks_mut::<8>().0.iter_mut();
        let mut hash = Hash::default();
        let mut write = |word: u64| {
            hash.word(word);
            if let Some(place) = words.next() {
                *place = word.to_le_bytes();
            }
            word
        };
        for word in [MAGIC, FORMAT, TOKEN_HASH, total as u64] {
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
        Status::Ok
    }

    /// Makes a state from bytes. Anything but an unchanged image of the same build is refused.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<NonNull<Saved>, Status> {
        let malformed = "serialized state: malformed, truncated or altered";
        let (words, rest) = bytes.as_chunks::<8>();
        let Some((checksum, body)) = words.split_last().filter(|_| rest.is_empty() && bytes.len() >= FRAME_BYTES)
        else {
            return Err(self.refuse(malformed));
        };
        let mut at = body.iter().map(|word| u64::from_le_bytes(*word));
        let header = [at.next(), at.next(), at.next(), at.next()];
        if header[0] != Some(MAGIC) || header[3] != Some(bytes.len() as u64) {
            return Err(self.refuse(malformed));
        }
        if header[1] != Some(FORMAT) || header[2] != Some(TOKEN_HASH) {
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
        let Some(saved) = self.states.add(&kept, image, true) else { return Err(self.out_of_memory()) };
        // SAFETY: just made; nothing else refers to its image.
        let places = unsafe { image_of(saved) };
        for (place, word) in places.as_chunks_mut::<8>().0.iter_mut().zip(at) {
            *place = word.to_le_bytes();
        }
        Ok(saved)
    }
}

/// Passes every word of `kept` through `word`, which returns what to keep: one traversal for writing and reading.
/// False if a word makes no sense.
fn visit(kept: &mut Kept, word: &mut impl FnMut(u64) -> u64) -> bool {
    let number = word(kept.phase as u32 as u64);
    let Some(phase) = Phase::ALL.into_iter().find(|&phase| phase as u32 as u64 == number) else { return false };
    kept.phase = phase;
    kept.parameters.visit(word);
    let mut real = |value: &mut f64| *value = f64::from_bits(word(value.to_bits()));
    let start = &mut kept.start;
    start.position.iter_mut().for_each(&mut real);
    start.velocity.iter_mut().for_each(&mut real);
    start.orientation.iter_mut().for_each(&mut real);
    start.angular_velocity.iter_mut().for_each(&mut real);
    real(&mut kept.start_time);
    real(&mut kept.stop_time);
    real(&mut kept.time);
    kept.force_mean.iter_mut().for_each(&mut real);
    kept.torque_mean.iter_mut().for_each(&mut real);
    kept.force_expected.iter_mut().for_each(&mut real);
    real(&mut kept.interface_residual);
    let flag = word(u64::from(kept.terminated));
    kept.terminated = flag == 1;
    flag <= 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{Log, Logger};

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
        assert_eq!(instance.save(first.as_ptr()).unwrap(), first);
        let mut bytes = std::vec![0; instance.serialized_size(second.as_ptr()).unwrap()];
        assert_eq!(instance.serialize(second.as_ptr(), &mut bytes), Status::Ok);
        assert!(instance.deserialize(&bytes).is_ok());
        bytes[40] ^= 1;
        assert!(instance.deserialize(&bytes).is_err());
        assert_eq!(instance.free(first.as_ptr()), Status::Ok);
        assert_eq!(instance.free(first.as_ptr()), Status::Error);
        assert_eq!(instance.restore(second.as_ptr()), Status::Ok);
    }
}
