//! Pointers that a C host hands over: nothing vouches for them but the host's word.
//!
//! To C the types below are plain pointers. Rust makes one only with [`Input::given`] or [`Output::given`],
//! whose caller gives the promise; a C host gives it by calling, since the header and the FMI standard ask it
//! of every pointer: null, or so many elements as stand beside it (one if no number does; of a structure that
//! starts with its size so many bytes), of which nobody else changes anything during the call, and which
//! overlap no other place of the call. The number is not yet known when the type is made: who makes one
//! promises for every number that it will be used with. So an exported function that takes one is unsafe, and
//! asks for the promise still to hold. What trusts it stands here, once.

/// A place the host lets us read. Null may stand for nothing.
#[repr(transparent)]
pub struct Input<T>(*const T);

/// A place the host lets us write. Null may stand for nothing.
#[repr(transparent)]
pub struct Output<T>(*mut T);

impl<T> Input<T> {
    /// A pointer as a host would give it.
    ///
    /// # Safety
    /// The promise above, for every number of elements that [`Input::elements`] is asked for; what is there
    /// is a valid `T`.
    pub const unsafe fn given(pointer: *const T) -> Input<T> {
        Input(pointer)
    }

    /// The pointer itself, to look at.
    pub fn pointer(&self) -> *const T {
        self.0
    }

    /// The elements, whose number the host has given beside the pointer. None if it is null or misaligned, or
    /// if no memory could hold so many.
    pub fn elements(&self, count: usize) -> Option<&[T]> {
        // SAFETY: not null, aligned, of a length that a slice can have; the host vouches for so many values,
        // which nobody changes.
        holds(self.0, count).then(|| unsafe { core::slice::from_raw_parts(self.0, count) })
    }
}

impl<T> Output<T> {
    /// A pointer as a host would give it.
    ///
    /// # Safety
    /// The promise above, for every number of elements that [`Output::elements`] is asked for, and for one if
    /// [`Output::put`] is called; what is there is a valid `T`, or every bit pattern is one. It may be
    /// uninitialised where a call only writes, as every call does that is not documented to read the place
    /// first.
    pub const unsafe fn given(pointer: *mut T) -> Output<T> {
        Output(pointer)
    }

    /// The pointer itself, to look at.
    pub fn pointer(&self) -> *mut T {
        self.0
    }

    /// The elements, as [`Input::elements`].
    pub fn elements(&mut self, count: usize) -> Option<&mut [T]> {
        // SAFETY: not null, aligned, of a length that a slice can have; the host vouches for the memory,
        // which nobody else uses.
        // A host may not have initialised it: then nothing is read before it is written, and any bits are a
        // `T`.
        holds(self.0, count).then(|| unsafe { core::slice::from_raw_parts_mut(self.0, count) })
    }

    /// Writes one value, wherever the place is aligned to; false if there is none.
    pub fn put(&mut self, value: T) -> bool {
        if !self.0.is_null() {
            // SAFETY: not null; the host vouches for the memory.
            unsafe { self.0.write_unaligned(value) };
        }
        !self.0.is_null()
    }
}

/// Whether a pointer can be that of a slice.
fn holds<T>(pointer: *const T, count: usize) -> bool {
    let bytes = count.checked_mul(size_of::<T>());
    !pointer.is_null() && pointer.is_aligned() && bytes.is_some_and(|bytes| bytes <= isize::MAX as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_can_be_a_slice_becomes_one() {
        let numbers = [1.0, 2.0, 3.0];
        let start = numbers.as_ptr();
        // SAFETY: an array of this function; the other pointers are never read.
        let (all, none, askew) = unsafe {
            let askew = start.cast::<u8>().add(1).cast::<f64>();
            (Input::given(start), Input::<f64>::given(core::ptr::null()), Input::given(askew))
        };
        assert_eq!(all.elements(3), Some(numbers.as_slice()));
        assert_eq!(all.elements(isize::MAX as usize / 8 + 1), None);
        assert_eq!(all.elements(usize::MAX), None);
        assert_eq!((none.elements(3), askew.elements(1)), (None, None));
    }

    #[test]
    fn only_what_can_be_a_slice_is_written() {
        let mut numbers = [1.0, 2.0, 3.0];
        let start = numbers.as_mut_ptr();
        let mut bytes = [0_u8; 12];
        // SAFETY: an array of this function, eight bytes of another; the other pointers are never used.
        let (mut all, mut none, mut askew, mut apart) = unsafe {
            let askew = start.cast::<u8>().add(1).cast::<f64>();
            let apart = Output::given(bytes.as_mut_ptr().add(1).cast::<u64>());
            (Output::given(start), Output::<f64>::given(core::ptr::null_mut()), Output::given(askew), apart)
        };
        assert_eq!(all.elements(isize::MAX as usize / 8 + 1), None);
        assert_eq!(all.elements(usize::MAX), None);
        assert_eq!((none.elements(0), askew.elements(1)), (None, None));
        assert_eq!(none.elements(3), None);
        all.elements(3).unwrap().reverse();
        assert_eq!(numbers, [3.0, 2.0, 1.0]);
        // One value goes anywhere but to null.
        assert!(apart.put(u64::MAX) && !none.put(7.0));
        assert_eq!(bytes, [0, 255, 255, 255, 255, 255, 255, 255, 255, 0, 0, 0]);
    }
}
