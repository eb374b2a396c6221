//! Structures that may grow: each starts with its own size as the host was compiled, and a host compiled against an older,
//! shorter one is served as before.
//!
//! How to add a field: at the end, without a gap (a structure has no padding and ends on a multiple of 8 bytes, so its size
//! changes whenever its fields do), and put the size so far into `OLDER`. Nothing else. `fk_motion` is part of `fk_path` and
//! can never grow.

use crate::types::*;
use fabric::{Code, Error, Scene};
use fabric_host::{Input, Output};

/// A structure that starts with its own size.
///
/// # Safety
/// It is `repr(C)`, its first field is a `u64`, and any bits are a value: it has integers, floating-point numbers and arrays of
/// them only, and no padding. (Its sizes, `OLDER` among them, are checked where they are used.)
pub(crate) unsafe trait Structure: Copy {
    /// Name for faults.
    const NAME: &'static str;
    /// Sizes of earlier releases, bytes. Each is the start of the present structure.
    const OLDER: &'static [usize];
}

/// Whether a structure's older sizes, bytes, grow from that of its first field to less than the present one.
const fn growing(older: &[usize], present: usize) -> bool {
    let (mut older, mut least) = (older, size_of::<u64>());
    while let [size, later @ ..] = older {
        if *size < least {
            return false;
        }
        (older, least) = (later, *size + 1);
    }
    least <= present
}

/// A structure that the host fills.
pub(crate) trait Filled: Structure {
    /// What stands for the fields that a shorter structure lacks.
    fn default() -> Self;
}

/// Structures, each with its older sizes.
macro_rules! structures {
    ($($name:ident: $older:expr),* $(,)?) => {$(
        // SAFETY: a structure of `types.rs`, all of which are as asked; that none has padding is tested (tests/c/abi/layout.inc).
        unsafe impl Structure for $name {
            const NAME: &'static str = stringify!($name);
            const OLDER: &'static [usize] = &$older;
        }
    )*};
}
structures! {
    fk_scene: [],
    fk_fault: [],
    fk_motion: [],
    fk_path: [],
    fk_step_limits: [],
    fk_grid: [],
    fk_contact: [],
    fk_support: [],
    fk_energy: [],
    fk_fabric: [],
    fk_counters: [],
    fk_outcome: [],
}

impl Filled for fk_scene {
    fn default() -> Self {
        const DEFAULT: Scene = Scene::sheet_10in_cylinder();
        fk_scene::of(&DEFAULT)
    }
}

impl Filled for fk_path {
    fn default() -> Self {
        let (position, velocity, angular_velocity) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let end = fk_motion { struct_size: 0, position, velocity, orientation: [0.0; 4], angular_velocity };
        fk_path { struct_size: 0, first: 0, steps: 0, end }
    }
}

/// The size of a host's structure, if this library knows it.
pub(crate) fn known_size<T: Structure>(size: u64) -> Result<usize, Error> {
    let present = size_of::<T>();
    const { assert!(growing(T::OLDER, size_of::<T>())) }
    let mut known = T::OLDER.iter().copied().chain([present]);
    let unknown = Error::new(Code::StructSize, T::NAME, size as f64, present as f64);
    known.find(|&known| known as u64 == size).ok_or(unknown)
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

/// Reads a structure; what a shorter one lacks is the default.
pub(crate) fn read<T: Filled>(given: &Input<T>) -> Result<T, Error> {
    let mut value = T::default();
    read_into(given, &mut value)?;
    Ok(value)
}

/// Reads a structure over what is there, which stays where the structure is shorter.
fn read_into<T: Structure>(given: &Input<T>, value: &mut T) -> Result<(), Error> {
    let pointer = given.pointer();
    usable(pointer)?;
    // SAFETY: not null and aligned; the host vouches for its first field, the size, and for as many initialised bytes as that says.
    // Of a size that is known they are at most those of T, and the start of a T on both sides, where any bits are a value. The size
    // field then says `size`; nothing reads it again.
    unsafe {
        let size = known_size::<T>(pointer.cast::<u64>().read())?;
        core::ptr::copy_nonoverlapping(pointer.cast::<u8>(), (&raw mut *value).cast::<u8>(), size);
    }
    Ok(())
}

/// Reads a scene. Not inlined: the structure it goes through takes a kilobyte of stack, which is free again afterwards.
#[inline(never)]
pub(crate) fn read_scene(given: &Input<fk_scene>) -> Result<Scene, Error> {
    let mut value = fk_scene::default();
    read_into(given, &mut value)?;
    value.scene()
}

/// A place for a structure, found usable and of a size that this library knows.
pub(crate) struct Part<'h, T> {
    place: &'h mut Output<T>,
    size: usize,
}

impl<'h, T: Structure> Part<'h, T> {
    /// Refuses null, misaligned and unknown-sized structures; this one says its size itself.
    pub(crate) fn of(place: &'h mut Output<T>) -> Result<Part<'h, T>, Error> {
        usable(place.pointer())?;
        // SAFETY: not null and aligned; the host vouches for the first field, the size, which it has set.
        let size = unsafe { place.pointer().cast::<u64>().read() };
        Part::of_size(place, size)
    }

    /// The same of a structure whose size the host gives beside it.
    pub(crate) fn of_size(place: &'h mut Output<T>, size: u64) -> Result<Part<'h, T>, Error> {
        usable(place.pointer())?;
        Ok(Part { size: known_size::<T>(size)?, place })
    }

    /// Writes a structure as far as the host's goes. Its size is that of the host.
    pub(crate) fn put(self, value: T) {
        let pointer = self.place.pointer();
        // SAFETY: not null and aligned; the host vouches for `size` bytes, which are at least 8 and at most those of T. They are
        // only written.
        unsafe {
            core::ptr::copy_nonoverlapping((&raw const value).cast::<u8>(), pointer.cast::<u8>(), self.size);
            pointer.cast::<u64>().write(self.size as u64);
        }
    }
}

/// Writes a structure that the caller has given its size, as far as it goes.
pub(crate) fn put<T: Structure>(place: &mut Output<T>, value: T) -> Result<(), Error> {
    Part::of(place)?.put(value);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A structure that has grown twice: `b` came second, `c` third.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Grown {
        struct_size: u64,
        a: f64,
        b: f64,
        c: [u32; 2],
    }

    // SAFETY: as asked: one u64, then two numbers and two halves of a third.
    unsafe impl Structure for Grown {
        const NAME: &'static str = "grown";
        const OLDER: &'static [usize] = &[16, 24];
    }

    impl Filled for Grown {
        fn default() -> Self {
            Grown { struct_size: 32, a: 1.0, b: 2.0, c: [3, 4] }
        }
    }

    /// A structure read as a host's, and the same after another has been written over it.
    fn read_and_put(mut host: Grown, news: Grown) -> (Result<Grown, Error>, Result<Grown, Error>) {
        // SAFETY: the structure of this function, longer than it may say that it is.
        let (given, mut place) = unsafe { (Input::given(&raw const host), Output::given(&raw mut host)) };
        (read(&given), put(&mut place, news).map(|()| host))
    }

    #[test]
    fn an_older_host_is_read_with_defaults_and_written_no_further_than_it_knows() {
        let given = Grown { struct_size: 16, a: 10.0, b: 20.0, c: [30, 40] };
        let news = Grown { struct_size: 32, a: -1.0, b: -2.0, c: [5, 6] };
        let written = Grown { struct_size: 16, a: -1.0, ..given };
        assert_eq!(read_and_put(given, news), (Ok(Grown { b: 2.0, c: [3, 4], ..given }), Ok(written)));
        let given = Grown { struct_size: 24, ..given };
        let written = Grown { struct_size: 24, c: [30, 40], ..news };
        assert_eq!(read_and_put(given, news), (Ok(Grown { c: [3, 4], ..given }), Ok(written)));
        let given = Grown { struct_size: 32, ..given };
        assert_eq!(read_and_put(given, news), (Ok(given), Ok(news)));
    }

    #[test]
    fn older_sizes_grow_from_the_first_field_to_the_present() {
        assert!(growing(&[], 8) && growing(&[8], 16) && growing(&[16, 24], 32));
        for older in [[0, 24], [7, 24], [24, 24], [24, 16], [24, 32], [24, 40]] {
            assert!(!growing(&older, 32), "{older:?}");
        }
    }

    #[test]
    fn sizes_in_between_and_beyond_are_refused() {
        for size in [0, 8, 15, 17, 25, 31, 33, 40, u64::MAX] {
            let given = Grown { struct_size: size, a: 0.0, b: 0.0, c: [0; 2] };
            let (read, written) = read_and_put(given, given);
            for error in [read.unwrap_err(), written.unwrap_err()] {
                assert_eq!((error.code, error.field, error.limit), (Code::StructSize, "grown", 32.0));
            }
        }
    }
}
