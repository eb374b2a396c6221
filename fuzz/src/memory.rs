//! Memory of exactly the bytes asked for, so that AddressSanitizer sees one too many, filled with a pattern.

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

    /// Its first byte.
    pub fn start(&self) -> *mut u8 {
        self.start
    }

    /// Its length.
    pub fn bytes(&self) -> usize {
        self.layout.size()
    }

    /// Whether nothing has been written to it.
    pub fn untouched(&self) -> bool {
        // SAFETY: initialised bytes that nothing else uses during this call.
        let bytes = unsafe { std::slice::from_raw_parts(self.start, self.bytes()) };
        // One comparison of the block with itself, a byte further on: a loop would be slow under instrumentation.
        bytes[0] == FILL && bytes[1..] == bytes[..bytes.len() - 1]
    }
}

impl Drop for Block {
    fn drop(&mut self) {
        // SAFETY: allocated with this layout.
        unsafe { dealloc(self.start, self.layout) }
    }
}
