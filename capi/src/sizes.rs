//! Structures that may grow: the host says the size of each as it was compiled, in the first word of a scene and beside the
//! pointer of any other, and a host compiled against an older, shorter one is served as before.
//!
//! How to add a field: at the end, without a gap (a structure has no padding and ends on a multiple of 8 bytes). A host may give any whole
//! number of words from those of the first release to the present ones. A scene grows by rows at the end of the table
//! `fabric_kernel::fields::FIELDS`. `fk_motion` is part of `fk_path`, `fk_threads` of `fk_textile`: they can never grow.

use crate::types::*;
use fabric_host::{Input, Output};
use fabric_kernel::{Code, Error, Scene};

/// A structure that hosts of several ages know.
///
/// # Safety
/// It is `repr(C)` and any bits are a value: it has integers, floating-point numbers and arrays of them only, and no padding.
pub(crate) unsafe trait Structure: Copy {
    /// Name for faults.
    const NAME: &'static str;
    /// Size in the first release, bytes, which is the start of the present structure. It never changes.
    const FIRST: usize;
}

/// Structures, each with its first size.
macro_rules! structures {
    ($($name:ident: $first:expr),* $(,)?) => {$(
        // SAFETY: a structure of `types.rs`, all of which are as asked; that none has padding is tested (tests/c/abi).
        unsafe impl Structure for $name {
            const NAME: &'static str = stringify!($name);
            const FIRST: usize = $first;
        }
    )*};
}
structures! {
    fk_scene: size_of::<fk_scene>(),
    fk_fault: 240,
    fk_motion: 104,
    fk_path: 120,
    fk_step_limits: 24,
    fk_grid: 40,
    fk_contact: 72,
    fk_support: 120,
    fk_energy: 96,
    fk_fabric: 16,
    fk_counters: 104,
    fk_outcome: 128,
    fk_textile: 120,
    fk_ply: 32,
    fk_capsule: 56,
    fk_replayed: 80,
    fk_slip: 56,
}

/// The size of a host's structure, if this library knows it.
fn known_size<T: Structure>(size: u64) -> Result<usize, Error> {
    let (present, word) = (size_of::<T>(), size_of::<u64>());
    const { assert!(size_of::<u64>() <= T::FIRST && T::FIRST <= size_of::<T>()) }
    let known =
        usize::try_from(size).ok().filter(|size| (T::FIRST..=present).contains(size) && size.is_multiple_of(word));
    let filled = if size == 0 && T::NAME == "fk_scene" { "fk_scene_default, which fills it" } else { "" };
    known.ok_or(Error { with: filled, ..Error::new(Code::StructSize, T::NAME, size as f64, present as f64) })
}

/// Refuses null and misaligned structures.
fn usable<T: Structure>(pointer: *const T) -> Result<(), Error> {
    if pointer.is_null() {
        return Err(Error::plain(Code::NullPointer, T::NAME));
    }
    if !pointer.is_aligned() {
        return Err(Error::plain(Code::Misaligned, T::NAME));
    }
    Ok(())
}

/// Reads a structure of the size given; what a shorter one lacks is 0.
pub(crate) fn read<T: Structure + Default>(given: &Input<T>, size: u64) -> Result<T, Error> {
    let pointer = given.pointer();
    usable(pointer)?;
    let (size, mut value) = (known_size::<T>(size)?, T::default());
    // SAFETY: not null and aligned; the host vouches for as many initialised bytes as it says. Of a size that is known they are at
    // most those of T, and the start of a T on both sides, where any bits are a value.
    unsafe { core::ptr::copy_nonoverlapping(pointer.cast::<u8>(), (&raw mut value).cast::<u8>(), size) };
    Ok(value)
}

/// Reads a structure that is to be changed where it is.
#[cfg(feature = "capsule")]
pub(crate) fn read_to_change<T: Structure + Default>(place: &Output<T>, size: u64) -> Result<T, Error> {
    read(&to_read(place), size)
}

/// A place that is to be changed, to be read before.
fn to_read<T>(place: &Output<T>) -> Input<T> {
    // SAFETY: the host vouches for an initialised structure to be changed, as for one that is only read.
    unsafe { Input::given(place.pointer()) }
}

/// The size that a scene says it has. `words`: its words, of which the first must be usable.
fn size_of_scene(words: &Input<u64>) -> u64 {
    words.elements(1).and_then(|words| words.first()).map_or(0, |size| *size)
}

/// The words of a scene.
fn words_of(scene: &Input<fk_scene>) -> Input<u64> {
    // SAFETY: a structure of whole words; the host vouches for the first, its size, and for as many initialised bytes as that says. No
    // more are looked at.
    unsafe { Input::given(scene.pointer().cast()) }
}

/// Reads a scene. Not inlined: what it takes of the stack is free again afterwards.
#[inline(never)]
pub(crate) fn read_scene(given: &Input<fk_scene>) -> Result<Scene, Error> {
    usable(given.pointer())?;
    let words = words_of(given);
    let size = known_size::<fk_scene>(size_of_scene(&words))?;
    fk_scene::scene(words.elements(size / size_of::<u64>()).unwrap_or_default())
}

/// Changes a scene where it is; of an older, shorter one as far as it goes. Nothing is written if the change is refused.
#[inline(never)]
pub(crate) fn change_scene(
    place: &mut Output<fk_scene>,
    change: impl FnOnce(&mut Scene) -> Result<(), Error>,
) -> Result<(), Error> {
    let given = to_read(place);
    let mut scene = read_scene(&given);
    let scene = scene.as_mut().map_err(|error| *error)?;
    change(scene)?;
    put_scene(place, size_of_scene(&words_of(&given)), scene)
}

/// Writes a scene as far as the host's structure, of this size, goes, word by word: a copy would take a kilobyte of stack. The scene
/// is not changed. Not inlined: the stack gate knows by its name what it calls.
#[inline(never)]
pub(crate) fn put_scene(place: &mut Output<fk_scene>, size: u64, scene: &mut Scene) -> Result<(), Error> {
    usable(place.pointer())?;
    let words = known_size::<fk_scene>(size)? / size_of::<u64>();
    // SAFETY: not null and aligned, a structure of whole words; the host vouches for as many bytes as it says.
    let mut place: Output<u64> = unsafe { Output::given(place.pointer().cast()) };
    if let Some((first, numbers)) = place.elements(words).and_then(<[u64]>::split_first_mut) {
        *first = size;
        fk_scene::fill(numbers, scene);
    }
    Ok(())
}

/// A place for a structure, found usable and of a size that this library knows.
pub(crate) struct Part<'h, T> {
    place: &'h mut Output<T>,
    size: usize,
}

impl<'h, T: Structure> Part<'h, T> {
    /// Refuses null, misaligned and unknown-sized structures.
    pub(crate) fn of(place: &'h mut Output<T>, size: u64) -> Result<Part<'h, T>, Error> {
        usable(place.pointer())?;
        Ok(Part { size: known_size::<T>(size)?, place })
    }

    /// Writes a structure as far as the host's goes.
    pub(crate) fn put(self, value: &T) {
        let (from, to) = ((&raw const *value).cast::<u8>(), self.place.pointer().cast::<u8>());
        // SAFETY: not null and aligned; the host vouches for `size` bytes, which are at most those of T. They are only written.
        unsafe { core::ptr::copy_nonoverlapping(from, to, self.size) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A structure that has grown twice: `b` came second, `c` third.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    struct Grown {
        a: f64,
        b: f64,
        c: [u32; 2],
    }

    // SAFETY: as asked: two numbers and two halves of a third.
    unsafe impl Structure for Grown {
        const NAME: &'static str = "grown";
        const FIRST: usize = 8;
    }

    /// A structure of this size read as a host's, and what the host has after another has been written over it.
    fn read_and_put(mut host: Grown, size: u64, news: Grown) -> (Result<Grown, Error>, Result<Grown, Error>) {
        // SAFETY: the structure of this function, at least as long as any size that is known.
        let (given, mut place) = unsafe { (Input::given(&raw const host), Output::given(&raw mut host)) };
        let read = read(&given, size);
        (read, Part::of(&mut place, size).map(|part| part.put(&news)).map(|()| host))
    }

    #[test]
    fn an_older_host_is_read_with_zeros_and_written_no_further_than_it_knows() {
        let (given, news) = (Grown { a: 10.0, b: 20.0, c: [30, 40] }, Grown { a: -1.0, b: -2.0, c: [5, 6] });
        let written = Grown { a: -1.0, ..given };
        assert_eq!(read_and_put(given, 8, news), (Ok(Grown { b: 0.0, c: [0, 0], ..given }), Ok(written)));
        let written = Grown { c: [30, 40], ..news };
        assert_eq!(read_and_put(given, 16, news), (Ok(Grown { c: [0, 0], ..given }), Ok(written)));
        assert_eq!(read_and_put(given, 24, news), (Ok(given), Ok(news)));
    }

    #[test]
    fn sizes_in_between_and_beyond_are_refused() {
        for size in [0, 7, 9, 17, 23, 25, 32, u64::MAX] {
            let (read, written) = read_and_put(Grown::default(), size, Grown::default());
            for error in [read.unwrap_err(), written.unwrap_err()] {
                assert_eq!((error.code, error.field, error.limit), (Code::StructSize, "grown", 24.0));
            }
        }
        // A scene of zeros.
        assert_eq!(known_size::<fk_scene>(0).unwrap_err().with, "fk_scene_default, which fills it");
    }
}
