//! Structures that may grow: each starts with its own size as the host was compiled, and a host compiled against an older,
//! shorter one is served as before.
//!
//! How to add a field: at the end, without a gap (a structure has no padding and ends on a multiple of 8 bytes, so its size
//! changes whenever its fields do), and put the size so far into `OLDER`. Nothing else. `fk_motion` is part of `fk_path` and
//! can never grow.

use crate::types::*;
use fabric::{Code, Error, Scene};

/// A structure that starts with its own size.
pub(crate) trait Structure: Copy {
    /// Name for faults.
    const NAME: &'static str;
    /// Sizes of earlier releases, bytes. Each is the start of the present structure.
    const OLDER: &'static [usize];
    /// What a host sees whose structure is shorter: its part of this. Of input the rest is the default.
    fn default() -> Self;
}

impl Structure for fk_scene {
    const NAME: &'static str = "fk_scene";
    const OLDER: &'static [usize] = &[];
    fn default() -> Self {
        const DEFAULT: Scene = Scene::sheet_10in_cylinder();
        fk_scene::of(&DEFAULT)
    }
}

/// Structures whose default is zero, each with its older sizes.
macro_rules! zero_by_default {
    ($($name:ident: $older:expr),* $(,)?) => {$(
        impl Structure for $name {
            const NAME: &'static str = stringify!($name);
            const OLDER: &'static [usize] = &$older;
            fn default() -> Self {
                // SAFETY: integers, floating-point numbers and arrays of them, for which zero is a value.
                unsafe { core::mem::zeroed() }
            }
        }
    )*};
}
zero_by_default! {
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

/// The size of a host's structure, if this library knows it.
pub(crate) fn known_size<T: Structure>(size: u64) -> Result<usize, Error> {
    let present = size_of::<T>();
    let mut known = T::OLDER.iter().copied().chain([present]);
    let unknown = Error::new(Code::StructSize, T::NAME, size as f64, present as f64);
    known.find(|&known| known as u64 == size).ok_or(unknown)
}

/// Refuses null, misaligned and unknown-sized structures; the size of this one.
///
/// # Safety
/// `pointer` is null or points to a readable structure.
pub(crate) unsafe fn known<T: Structure>(pointer: *const T) -> Result<usize, Error> {
    usable(pointer)?;
    // SAFETY: every structure starts with its 64-bit size.
    known_size::<T>(unsafe { pointer.cast::<u64>().read() })
}

/// Refuses null and misaligned structures.
pub(crate) fn usable<T: Structure>(pointer: *const T) -> Result<(), Error> {
    if pointer.is_null() {
        return Err(Error::plain(Code::NullPointer, T::NAME));
    }
    if !pointer.is_aligned() {
        return Err(Error::plain(Code::Misaligned, T::NAME));
    }
    Ok(())
}

/// Reads a structure; what a shorter one lacks is the default.
///
/// # Safety
/// As for [`known`].
pub(crate) unsafe fn read<T: Structure>(pointer: *const T) -> Result<T, Error> {
    let mut value = T::default();
    // SAFETY: the caller's promise.
    unsafe { read_into(pointer, &mut value)? };
    Ok(value)
}

/// Reads a structure over what is there, which stays where the structure is shorter.
///
/// # Safety
/// As for [`known`].
unsafe fn read_into<T: Structure>(pointer: *const T, value: &mut T) -> Result<(), Error> {
    // SAFETY: the caller's promise. `size` bytes, at most those of T, are the start of a T on both sides. The size field then
    // says `size`; nothing reads it again.
    unsafe {
        let size = known(pointer)?;
        core::ptr::copy_nonoverlapping(pointer.cast::<u8>(), (&raw mut *value).cast::<u8>(), size);
    }
    Ok(())
}

/// Reads a scene. Not inlined: the structure it goes through takes a kilobyte of stack, which is free again afterwards.
///
/// # Safety
/// As for [`known`].
#[inline(never)]
pub(crate) unsafe fn read_scene(pointer: *const fk_scene) -> Result<Scene, Error> {
    let mut given = <fk_scene as Structure>::default();
    // SAFETY: the caller's promise.
    unsafe { read_into(pointer, &mut given)? };
    given.scene()
}

/// Writes a structure that the caller has given its size, as far as it goes. The size stays the caller's.
///
/// # Safety
/// As for [`known`], and writable.
pub(crate) unsafe fn put<T: Structure>(pointer: *mut T, value: T) -> Result<(), Error> {
    // SAFETY: the caller's promise; the size is the one that was found.
    unsafe { put_part(pointer, known(pointer)?, value) };
    Ok(())
}

/// Writes the first `size` bytes of a structure, its size field too.
///
/// # Safety
/// `pointer` is aligned and points to `size` writable bytes; `size` came from [`known_size`].
pub(crate) unsafe fn put_part<T: Structure>(pointer: *mut T, size: usize, value: T) {
    // SAFETY: the caller's promise; `size` is at least 8 and at most the size of T.
    unsafe {
        core::ptr::copy_nonoverlapping((&raw const value).cast::<u8>(), pointer.cast::<u8>(), size);
        pointer.cast::<u64>().write(size as u64);
    }
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

    impl Structure for Grown {
        const NAME: &'static str = "grown";
        const OLDER: &'static [usize] = &[16, 24];
        fn default() -> Self {
            Grown { struct_size: 32, a: 1.0, b: 2.0, c: [3, 4] }
        }
    }

    #[test]
    fn an_older_host_is_read_with_defaults_and_written_no_further_than_it_knows() {
        let given = Grown { struct_size: 16, a: 10.0, b: 20.0, c: [30, 40] };
        // SAFETY: structures of this test.
        unsafe {
            assert_eq!(read(&given), Ok(Grown { struct_size: 16, a: 10.0, b: 2.0, c: [3, 4] }));
            let given = Grown { struct_size: 24, ..given };
            assert_eq!(read(&given), Ok(Grown { struct_size: 24, c: [3, 4], ..given }));
            let given = Grown { struct_size: 32, ..given };
            assert_eq!(read(&given), Ok(given));

            let news = Grown { struct_size: 32, a: -1.0, b: -2.0, c: [5, 6] };
            let mut host = Grown { struct_size: 24, ..given };
            assert_eq!(put(&mut host, news), Ok(()));
            assert_eq!(host, Grown { struct_size: 24, c: [30, 40], ..news });
        }
    }

    #[test]
    fn sizes_in_between_and_beyond_are_refused() {
        for size in [0, 8, 15, 17, 25, 31, 33, 40, u64::MAX] {
            let given = Grown { struct_size: size, a: 0.0, b: 0.0, c: [0; 2] };
            // SAFETY: a structure of this test.
            let error = unsafe { read(&given) }.unwrap_err();
            assert_eq!((error.code, error.field, error.limit), (Code::StructSize, "grown", 32.0));
        }
    }
}
