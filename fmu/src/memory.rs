//! Memory from the C library, or as a component for WebAssembly from its own allocator: one block at a time,
//! zeroed, freed when dropped.

use core::ffi::c_void;
use core::ops::{Deref, DerefMut};
use core::ptr::NonNull;
use fabric_kernel::CacheLine;

#[cfg(not(target_family = "wasm"))]
mod library {
    use super::c_void;

    unsafe extern "C" {
        safe fn calloc(count: usize, size: usize) -> *mut c_void;
        fn free(block: *mut c_void);
    }

    /// So many zeroed bytes, aligned for every type of ours; null if there is no memory.
    pub fn take(bytes: usize) -> *mut c_void {
        calloc(1, bytes)
    }

    /// # Safety
    /// A block of `take` of so many bytes, not used again.
    pub unsafe fn give_back(block: *mut c_void, _bytes: usize) {
        // SAFETY: from calloc, as the caller promises.
        unsafe { free(block) }
    }
}

#[cfg(target_family = "wasm")]
mod library {
    extern crate alloc;

    use super::c_void;
    use alloc::boxed::Box;
    use alloc::vec::Vec;
    use core::ptr;

    pub fn take(bytes: usize) -> *mut c_void {
        let (mut words, count) = (Vec::<u64>::new(), bytes.div_ceil(8));
        if words.try_reserve_exact(count).is_err() {
            return ptr::null_mut();
        }
        words.resize(count, 0);
        Box::leak(words.into_boxed_slice()).as_mut_ptr().cast()
    }

    /// # Safety
    /// A block of `take` of so many bytes, not used again.
    pub unsafe fn give_back(block: *mut c_void, bytes: usize) {
        // SAFETY: words from a box, as many.
        drop(unsafe { Box::from_raw(ptr::slice_from_raw_parts_mut(block.cast::<u64>(), bytes.div_ceil(8))) });
    }
}

/// A value in a block of its own, with bytes after it. Dropped, the value is dropped and the block freed.
pub struct Owned<T> {
    /// Taken: aligned for every type of ours (checked in [`Owned::new`]), with `size_of::<T>() + extra`
    /// bytes.
    start: NonNull<T>,
    extra: usize,
}

impl<T> Owned<T> {
    /// A value and `extra` zeroed bytes after it; None if there is no memory.
    pub fn new(value: T, extra: usize) -> Option<Owned<T>> {
        // What every calloc aligns to, those of 32-bit machines too.
        const { assert!(align_of::<T>() <= 8) }
        let bytes = size_of::<T>().checked_add(extra)?;
        let start = NonNull::new(library::take(bytes.max(1)).cast::<T>())?;
        // SAFETY: a fresh block, large enough and aligned.
        unsafe { start.write(value) };
        Some(Owned { start, extra })
    }

    /// A value that [`Owned::into_pointer`] has let go of.
    ///
    /// # Safety
    /// The pointer came from there, with no bytes after the value, and is not used again.
    pub const unsafe fn from_pointer(start: NonNull<T>) -> Owned<T> {
        Owned { start, extra: 0 }
    }

    /// Lets go of the value: whoever has the pointer sees to it from now on.
    pub fn into_pointer(self) -> *mut T {
        core::mem::ManuallyDrop::new(self).start.as_ptr()
    }

    /// Where the value is.
    pub fn pointer(&self) -> *mut T {
        self.start.as_ptr()
    }

    /// The value and the bytes after it.
    pub fn parts(&self) -> (&T, &[u8]) {
        // SAFETY: ours alone; the value was written and the bytes zeroed when it was made.
        unsafe { (self.start.as_ref(), core::slice::from_raw_parts(self.start.add(1).as_ptr().cast(), self.extra)) }
    }

    /// As [`Owned::parts`], to change.
    pub fn parts_mut(&mut self) -> (&mut T, &mut [u8]) {
        let behind = self.start.as_ptr().wrapping_add(1).cast();
        // SAFETY: as above; the two do not overlap.
        unsafe { (self.start.as_mut(), core::slice::from_raw_parts_mut(behind, self.extra)) }
    }
}

impl<T> Deref for Owned<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.parts().0
    }
}

impl<T> DerefMut for Owned<T> {
    fn deref_mut(&mut self) -> &mut T {
        self.parts_mut().0
    }
}

impl<T> Drop for Owned<T> {
    fn drop(&mut self) {
        // SAFETY: a value that is not used again, in a block of so many bytes that nobody else frees.
        unsafe {
            self.start.drop_in_place();
            library::give_back(self.start.as_ptr().cast(), (size_of::<T>() + self.extra).max(1));
        }
    }
}

/// The memory of one simulation.
pub struct Block {
    /// All of it after a value of no size that has the alignment of a number.
    bytes: Owned<[f64; 0]>,
    lines: usize,
}

impl Block {
    /// Memory for so many lines, or None.
    pub fn new(lines: usize) -> Option<Block> {
        // One line more: where the first starts is found in carve().
        let bytes = lines.checked_add(1)?.checked_mul(size_of::<CacheLine>())?;
        Some(Block { bytes: Owned::new([], bytes)?, lines })
    }

    /// The block as a simulation's memory.
    ///
    /// # Safety
    /// Called once per block, and the block outlives what is returned.
    pub unsafe fn carve(&mut self) -> &'static mut [CacheLine] {
        let start = self.bytes.pointer().cast::<u8>();
        let skip = start.align_offset(align_of::<CacheLine>()).min(size_of::<CacheLine>());
        // SAFETY: the block holds a line more than these, zeroed by calloc, and the caller promises to hold
        // no others.
        unsafe { core::slice::from_raw_parts_mut(start.add(skip).cast::<CacheLine>(), self.lines) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_and_the_bytes_behind_it_are_dropped_once() {
        let counter = std::rc::Rc::new(());
        let mut owned = Owned::new(counter.clone(), 5).unwrap();
        owned.parts_mut().1[4] = 7;
        assert_eq!(owned.parts().1, [0, 0, 0, 0, 7]);
        assert_eq!(std::rc::Rc::strong_count(&*owned), 2);
        drop(owned);
        assert_eq!(std::rc::Rc::strong_count(&counter), 1);
        assert!(Owned::new(counter, usize::MAX).is_none());
    }
}
