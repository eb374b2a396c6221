//! Memory of exactly the bytes asked for, so that AddressSanitizer sees one too many, filled with a pattern;
//! and memory as a host hands it over.

use fabric_capi::{Input, Output};
use std::alloc::{Layout, alloc, dealloc, handle_alloc_error};

/// What fresh memory is filled with.
pub const FILL: u8 = 0xa5;

/// A block of bytes, aligned to 64.
pub struct Block {
    start: *mut u8,
    layout: Layout,
}

impl Block {
    /// A block of `bytes` bytes.
    pub fn new(bytes: usize) -> Block {
        let layout = Layout::from_size_align(bytes.max(1), 64).expect("the harness asks for little memory");
        // SAFETY: the size is not zero.
        let start = unsafe { alloc(layout) };
        if start.is_null() {
            handle_alloc_error(layout);
        }
        // SAFETY: just allocated with this size.
        unsafe { start.write_bytes(FILL, layout.size()) };
        Block { start, layout }
    }

    /// First byte.
    pub fn start(&self) -> *mut u8 {
        self.start
    }

    /// Length.
    pub fn bytes(&self) -> usize {
        self.layout.size()
    }

    /// Whether nothing has been written to it.
    pub fn untouched(&self) -> bool {
        // SAFETY: initialised bytes that nothing else uses during this call.
        let bytes = unsafe { std::slice::from_raw_parts(self.start, self.bytes()) };
        // One comparison of the block with itself, a byte further on: a loop would be slow under
        // instrumentation.
        bytes[0] == FILL && bytes[1..] == bytes[..bytes.len() - 1]
    }
}

impl Drop for Block {
    fn drop(&mut self) {
        // SAFETY: allocated with this layout.
        unsafe { dealloc(self.start, self.layout) }
    }
}

/// What a host reads from an array.
///
/// # Safety
/// As of [`Input::given`]: the array outlives the call that this is handed to. So of the others below.
pub(crate) unsafe fn from<T>(values: &[T]) -> Input<T> {
    // SAFETY: the caller's promise.
    unsafe { Input::given(values.as_ptr()) }
}

/// What a host has written into an array.
pub(crate) unsafe fn to<T>(values: &mut [T]) -> Output<T> {
    // SAFETY: the caller's promise.
    unsafe { Output::given(values.as_mut_ptr()) }
}

/// What a host reads from one place.
pub(crate) unsafe fn at<T>(value: &T) -> Input<T> {
    // SAFETY: the caller's promise.
    unsafe { Input::given(value) }
}

/// What a host has written into one place.
pub(crate) unsafe fn into<T>(value: &mut T) -> Output<T> {
    // SAFETY: the caller's promise.
    unsafe { Output::given(value) }
}

/// No place.
pub(crate) fn nowhere<T>() -> Output<T> {
    // SAFETY: null is never followed.
    unsafe { Output::given(std::ptr::null_mut()) }
}
