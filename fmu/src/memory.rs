//! Memory from the C library: one block at a time, zeroed, freed when dropped.

use core::ffi::c_void;
use core::ptr::{self, NonNull};

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(block: *mut c_void);
}

/// Zeroed memory for one `T` and `extra` bytes behind it, or None. Free with [`release`].
pub fn allocate<T>(extra: usize) -> Option<NonNull<T>> {
    let bytes = size_of::<T>().checked_add(extra)?;
    // SAFETY: calloc takes any size; what it returns is aligned for every type of ours (checked in tests).
    NonNull::new(unsafe { calloc(1, bytes) }.cast())
}

/// Gives back a block of [`allocate`].
///
/// # Safety
/// The pointer came from [`allocate`] and is not used again.
pub unsafe fn release<T>(block: NonNull<T>) {
    // SAFETY: the caller's promise.
    unsafe { free(block.as_ptr().cast()) }
}

/// The memory of one simulation. Empty until it is needed.
pub struct Block {
    start: *mut c_void,
    reals: usize,
    words: usize,
}

impl Block {
    /// No memory.
    pub const EMPTY: Block = Block { start: ptr::null_mut(), reals: 0, words: 0 };

    /// Memory for so many numbers and integers, or None.
    pub fn new(reals: usize, words: usize) -> Option<Block> {
        let bytes = reals.checked_mul(8)?.checked_add(words.checked_mul(4)?)?;
        // SAFETY: calloc takes any size.
        let start = unsafe { calloc(bytes.max(1), 1) };
        (!start.is_null()).then_some(Block { start, reals, words })
    }

    /// The block as a simulation's memory.
    ///
    /// # Safety
    /// Called once per block, and the block outlives what is returned.
    pub unsafe fn carve(&mut self) -> fabric::Memory<'static> {
        if self.start.is_null() {
            return fabric::Memory { reals: &mut [], words: &mut [] };
        }
        let reals = self.start.cast::<f64>();
        // SAFETY: the block holds `reals` numbers and behind them `words` integers, zeroed and aligned by calloc; the two
        // parts do not overlap, and the caller promises to hold no others.
        unsafe {
            let words = reals.add(self.reals).cast::<u32>();
            fabric::Memory {
                reals: core::slice::from_raw_parts_mut(reals, self.reals),
                words: core::slice::from_raw_parts_mut(words, self.words),
            }
        }
    }
}

impl Drop for Block {
    fn drop(&mut self) {
        // SAFETY: null or a block of calloc that nobody else frees.
        unsafe { free(self.start) }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn calloc_aligns_everything_we_keep() {
        assert!(align_of::<crate::instance::Instance>() <= 16);
        assert!(align_of::<crate::state::Saved>() <= 16);
    }
}
