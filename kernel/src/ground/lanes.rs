//! One lane trait over plain Rust, SSE2, AVX2 and AVX-512, and the choice between them.
//!
//! Method: the hot pass is written once, generic over [`Lane`]; every instance does the same IEEE operations
//! on each number, so all give the same bits. The instruction set is found once, when a simulation is made,
//! and never changes a result.
//! Limits: elsewhere than x86-64 the plain Rust lane is used; the compiler may vectorise it.
//! With the folder `step/bands` this is the only place of the kernel with unsafe code.
#![allow(unsafe_code)]

use crate::ground::math;
use crate::ground::planes::{CHUNK, Chunk};
use nalgebra::Vector3;

/// One cache line of the caller's memory, aligned to 64 bytes. Its content does not matter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct CacheLine(pub [f64; CacheLine::REALS]);

impl CacheLine {
    /// Numbers of 64 bits in a line.
    pub const REALS: usize = 8;
    /// Integers of 32 bits in a line.
    pub const WORDS: usize = 16;
    /// A line to fill new memory with.
    pub const ZERO: CacheLine = CacheLine([0.0; CacheLine::REALS]);

    /// Lines as real numbers.
    pub(crate) fn reals(lines: &mut [CacheLine]) -> &mut [f64] {
        let (start, count) = (lines.as_mut_ptr().cast::<f64>(), Self::REALS * lines.len());
        // SAFETY: a line is its eight numbers without padding, and the slice is given up for the one that is
        // made.
        unsafe { core::slice::from_raw_parts_mut(start, count) }
    }

    /// Lines as integers, to be read.
    pub(crate) fn words_of(lines: &[CacheLine]) -> &[u32] {
        // SAFETY: a line is 64 bytes without padding, of which any bits are integers.
        unsafe { core::slice::from_raw_parts(lines.as_ptr().cast(), Self::WORDS * lines.len()) }
    }

    /// Lines as integers.
    pub(crate) fn words(lines: &mut [CacheLine]) -> &mut [u32] {
        let (start, count) = (lines.as_mut_ptr().cast::<u32>(), Self::WORDS * lines.len());
        // SAFETY: a line is 64 bytes without padding, of which any bits are integers, and later again real
        // numbers; the slice is given up for the one that is made.
        unsafe { core::slice::from_raw_parts_mut(start, count) }
    }
}

/// Item of an array in memory: a number, an array of items, or a record (`records!`).
///
/// # Safety
/// An item is NUMBERS numbers of its kind without padding, and any numbers of that kind are an item.
pub(crate) unsafe trait Item: Copy + 'static {
    /// Kind of its numbers.
    type Number: 'static;
    /// Numbers of an item.
    const NUMBERS: usize;

    /// Numbers as items. Numbers left over are in none.
    fn of(numbers: &mut [Self::Number]) -> &mut [Self] {
        let (start, count) = (numbers.as_mut_ptr().cast::<Self>(), numbers.len().checked_div(Self::NUMBERS));
        // SAFETY: an item is its numbers, aligned as they are, and the slice is given up for the one that is
        // made.
        unsafe { core::slice::from_raw_parts_mut(start, count.unwrap_or(0)) }
    }
}

// SAFETY: one number.
unsafe impl Item for f64 {
    type Number = f64;
    const NUMBERS: usize = 1;
}

// SAFETY: one number.
unsafe impl Item for u32 {
    type Number = u32;
    const NUMBERS: usize = 1;
}

// SAFETY: an array has no padding between its items.
unsafe impl<I: Item, const N: usize> Item for [I; N] {
    type Number = I::Number;
    const NUMBERS: usize = N * I::NUMBERS;
}

// SAFETY: nalgebra's vector is `#[repr(C)]` over the array of its three numbers.
unsafe impl Item for Vector3<f64> {
    type Number = f64;
    const NUMBERS: usize = 3;
}

/// Bytes of an item.
pub(crate) const fn bytes<I: Item>() -> usize {
    size_of::<I>()
}

/// Declares records: structures that lie in memory as the list of their fields, each an item.
macro_rules! records {
    ($($(#[$about:meta])* pub struct $name:ident { $($(#[$meaning:meta])* pub $field:ident: $kind:ty,)* })*) => {$(
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[repr(C)]
        pub struct $name {
            $($(#[$meaning])* pub $field: $kind,)*
        }

        // SAFETY: every field is an item, in the order of the list, and any bits are its numbers; the
        // assertion finds padding.
        #[allow(unsafe_code)]
        unsafe impl $crate::ground::lanes::Item for $name {
            type Number = f64;
            const NUMBERS: usize = size_of::<$name>() / 8;
        }
        const _: () = assert!(size_of::<$name>() == $($crate::ground::lanes::bytes::<$kind>() +)* 0);
        const _: () = assert!(size_of::<$name>().is_multiple_of(8));
    )*};
}
pub(crate) use records;

/// A set of vector instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum InstructionSet {
    /// Plain Rust, written for pairs of numbers; the compiler makes of it what the target has.
    Scalar = 0,
    /// Two at a time (every x86-64).
    Sse2 = 1,
    /// Four at a time.
    Avx2 = 2,
    /// Eight at a time.
    Avx512 = 3,
}

/// Whether this build has the sets that only some machines of the target have.
pub const WIDER: bool = cfg!(feature = "vectors");

impl InstructionSet {
    /// All sets, narrowest first.
    pub const ALL: [InstructionSet; 4] =
        [InstructionSet::Scalar, InstructionSet::Sse2, InstructionSet::Avx2, InstructionSet::Avx512];

    /// Whether this machine has it.
    pub fn available(self) -> bool {
        match self {
            // On x86-64 it is for tests.
            InstructionSet::Scalar => cfg!(any(not(target_arch = "x86_64"), feature = "internals")),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse2 => true,
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => WIDER && has_avx2::get(),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => WIDER && has_avx512::get(),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// Whether the target has faster sets, which nearly every machine of today has: less code is compiled for
    /// it.
    pub(crate) fn is_slow(self) -> bool {
        cfg!(target_arch = "x86_64") && WIDER && matches!(self, InstructionSet::Scalar | InstructionSet::Sse2)
    }

    /// The widest set this machine has.
    pub fn widest() -> InstructionSet {
        InstructionSet::ALL.into_iter().rev().find(|set| set.available()).unwrap_or(InstructionSet::Scalar)
    }

    /// Name for tables.
    pub fn name(self) -> &'static str {
        match self {
            InstructionSet::Scalar => "scalar",
            InstructionSet::Sse2 => "sse2",
            InstructionSet::Avx2 => "avx2",
            InstructionSet::Avx512 => "avx512",
        }
    }
}

#[cfg(target_arch = "x86_64")]
cpufeatures::new!(has_avx2, "avx2");
#[cfg(target_arch = "x86_64")]
cpufeatures::new!(has_avx512, "avx512f");

/// WIDTH numbers side by side. Every method acts on each by itself.
pub trait Lane: Copy {
    /// WIDTH numbers in memory.
    type Group: AsRef<[f64]> + AsMut<[f64]>;
    /// Numbers in a group; divides 8.
    const WIDTH: usize;
    /// A group of zeros.
    const ZEROS: Self::Group;
    /// Eight numbers cut into groups.
    fn groups(numbers: &[f64; CHUNK]) -> &[Self::Group];
    /// Eight numbers cut into groups, to be changed.
    fn groups_mut(numbers: &mut [f64; CHUNK]) -> &mut [Self::Group];
    /// One number in every lane.
    fn splat(x: f64) -> Self;
    /// From memory.
    fn load(group: &Self::Group) -> Self;
    /// Into memory.
    fn store(self, group: &mut Self::Group);
    /// Sum.
    fn add(self, other: Self) -> Self;
    /// Difference.
    fn sub(self, other: Self) -> Self;
    /// Product.
    fn mul(self, other: Self) -> Self;
    /// Quotient.
    fn div(self, other: Self) -> Self;
    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// The greater; `other` if either is NaN or both are zeros.
    fn max(self, other: Self) -> Self;
    /// The smaller; `other` if either is NaN or both are zeros.
    fn min(self, other: Self) -> Self;
    /// Whether any number is not below the limit; NaN is not below anything.
    fn any_not_below(self, limit: Self) -> bool;
    /// Whether any number of either is not below the limit of its own: one branch for both.
    #[inline(always)]
    fn any_not_below_either(both: [Self; 2], limits: [Self; 2]) -> bool {
        both[0].any_not_below(limits[0]) | both[1].any_not_below(limits[1])
    }
    /// Whether any number is above the limit, or NaN.
    fn any_above(self, limit: Self) -> bool;
    /// Zero in place of numbers whose size is below the limit; NaN stays.
    fn or_zero_below(self, limit: Self) -> Self;
    /// The right-hand neighbours of a group that is not the last of the eight, from memory.
    fn load_right(numbers: &[f64; CHUNK], group: usize) -> Self;
    /// The right-hand neighbours: the group without its first number, followed by the first of `next`.
    fn right_of(self, next: Self) -> Self;
    /// The left-hand neighbours: the last number of `previous`, and the group without its last.
    fn left_of(self, previous: Self) -> Self;
}

/// Numbers in memory as groups of a lane.
macro_rules! in_groups {
    ($width:literal) => {
        type Group = [f64; $width];
        const WIDTH: usize = $width;
        const ZEROS: [f64; $width] = [0.0; $width];
        #[inline(always)]
        fn groups(numbers: &[f64; CHUNK]) -> &[[f64; $width]] {
            numbers.as_chunks().0
        }
        #[inline(always)]
        fn groups_mut(numbers: &mut [f64; CHUNK]) -> &mut [[f64; $width]] {
            numbers.as_chunks_mut().0
        }
    };
}

/// A single number: for read-outs, which share the hot pass's formulas.
impl Lane for f64 {
    in_groups!(1);
    #[inline(always)]
    fn splat(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn load(group: &[f64; 1]) -> f64 {
        group[0]
    }
    #[inline(always)]
    fn store(self, group: &mut [f64; 1]) {
        group[0] = self;
    }
    #[inline(always)]
    fn add(self, other: f64) -> f64 {
        self + other
    }
    #[inline(always)]
    fn sub(self, other: f64) -> f64 {
        self - other
    }
    #[inline(always)]
    fn mul(self, other: f64) -> f64 {
        self * other
    }
    #[inline(always)]
    fn div(self, other: f64) -> f64 {
        self / other
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        math::sqrt(self)
    }
    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn min(self, other: f64) -> f64 {
        if self < other { self } else { other }
    }
    #[inline(always)]
    #[allow(clippy::neg_cmp_op_on_partial_ord)] // NaN must count as not below.
    fn any_not_below(self, limit: f64) -> bool {
        !(self < limit)
    }
    #[inline(always)]
    #[allow(clippy::neg_cmp_op_on_partial_ord)] // NaN must count as above.
    fn any_above(self, limit: f64) -> bool {
        !(self <= limit)
    }
    #[inline(always)]
    fn or_zero_below(self, limit: f64) -> f64 {
        if self < limit && self > -limit { 0.0 } else { self }
    }
    #[inline(always)]
    fn load_right(numbers: &[f64; CHUNK], group: usize) -> f64 {
        numbers[group + 1]
    }
    #[inline(always)]
    fn right_of(self, next: f64) -> f64 {
        next
    }
    #[inline(always)]
    fn left_of(self, previous: f64) -> f64 {
        previous
    }
}

/// A pair of numbers in plain Rust. Faster than one at a time: compilers pair the operations up, and the loop
/// is half as long.
impl Lane for [f64; 2] {
    in_groups!(2);
    #[inline(always)]
    fn splat(x: f64) -> Self {
        [x; 2]
    }
    #[inline(always)]
    fn load(group: &[f64; 2]) -> Self {
        *group
    }
    #[inline(always)]
    fn store(self, group: &mut [f64; 2]) {
        *group = self;
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        [self[0] + other[0], self[1] + other[1]]
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        [self[0] - other[0], self[1] - other[1]]
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        [self[0] * other[0], self[1] * other[1]]
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        [self[0] / other[0], self[1] / other[1]]
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(math::sqrt)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        [if self[0] > other[0] { self[0] } else { other[0] }, if self[1] > other[1] { self[1] } else { other[1] }]
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        [if self[0] < other[0] { self[0] } else { other[0] }, if self[1] < other[1] { self[1] } else { other[1] }]
    }
    #[inline(always)]
    #[allow(clippy::neg_cmp_op_on_partial_ord)] // NaN must count as not below.
    fn any_not_below(self, limit: Self) -> bool {
        !(self[0] < limit[0]) | !(self[1] < limit[1])
    }
    #[inline(always)]
    #[allow(clippy::neg_cmp_op_on_partial_ord)] // NaN must count as above.
    fn any_above(self, limit: Self) -> bool {
        !(self[0] <= limit[0]) | !(self[1] <= limit[1])
    }
    #[inline(always)]
    fn or_zero_below(self, limit: Self) -> Self {
        [self[0].or_zero_below(limit[0]), self[1].or_zero_below(limit[1])]
    }
    #[inline(always)]
    fn load_right(numbers: &[f64; CHUNK], group: usize) -> Self {
        [numbers[2 * group + 1], numbers[2 * group + 2]]
    }
    #[inline(always)]
    fn right_of(self, next: Self) -> Self {
        [self[1], next[0]]
    }
    #[inline(always)]
    fn left_of(self, previous: Self) -> Self {
        [previous[1], self[0]]
    }
}

/// A lane group of a plane.
#[inline(always)]
pub(crate) fn at<L: Lane, const P: usize>(chunk: &Chunk<P>, plane: usize, g: usize) -> L {
    L::load(&L::groups(&chunk[plane])[g])
}

/// A number eight times, as all lanes read it at once.
#[derive(Clone, Copy)]
pub struct Splat([f64; CHUNK]);

impl Splat {
    /// The number.
    #[inline(always)]
    pub fn of(number: f64) -> Splat {
        Splat([number; CHUNK])
    }

    /// A lane group of it.
    #[inline(always)]
    pub fn lanes<L: Lane>(&self) -> L {
        L::load(&L::groups(&self.0)[0])
    }
}

/// Does something with each lane group of a chunk. Written out, so that every place in the chunk is a
/// constant. No lane that is run with it has another width than 2, 4 or 8.
macro_rules! each_group {
    ($lane:ty, |$group:ident| $body:expr) => {{
        let $group = 0;
        $body;
        if <$lane>::WIDTH < CHUNK {
            let $group = 1;
            $body;
        }
        if <$lane>::WIDTH < CHUNK / 2 {
            let $group = 2;
            $body;
            let $group = 3;
            $body;
        }
    }};
}
pub(crate) use each_group;

/// Work that is written once for all lanes.
pub trait Job {
    /// Result.
    type Output;
    /// Does it with one kind of lane. Must be `#[inline(always)]`, so that it is compiled for the instruction
    /// set.
    fn run<L: Lane>(self) -> Self::Output;
}

/// Does a job with an instruction set; with that of every machine of the target if this one, or this build,
/// lacks it.
#[inline]
pub fn dispatch<J: Job>(set: InstructionSet, job: J) -> J::Output {
    #[cfg(target_arch = "x86_64")]
    return match set {
        // SAFETY: available() has just found the instructions on this machine.
        InstructionSet::Avx512 if set.available() => unsafe { x86::avx512(job) },
        // SAFETY: as above.
        InstructionSet::Avx2 if set.available() => unsafe { x86::avx2(job) },
        InstructionSet::Scalar if set.available() => run::<[f64; 2], J>(job),
        _ => run::<core::arch::x86_64::__m128d, J>(job),
    };
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = set;
        run::<[f64; 2], J>(job)
    }
}

/// Asks for the chunk that lies `ahead` chunks after this one in memory: a hint, which changes nothing. Does
/// nothing where the target has no such hint.
#[inline(always)]
pub fn fetch<const P: usize>(chunk: &Chunk<P>, ahead: usize) {
    #[cfg(target_arch = "x86_64")]
    for plane in 0..P {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let line = (&raw const *chunk).wrapping_add(ahead).cast::<i8>().wrapping_add(plane * size_of::<CacheLine>());
        // SAFETY: every x86-64 has the instruction, and it takes any address: it reads and writes nothing
        // that the program can see.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (chunk, ahead);
}

/// Does a job with lanes that every machine of the target has. Not inlined: the stack of one kind must not
/// add to that of another.
#[inline(never)]
fn run<L: Lane, J: Job>(job: J) -> J::Output {
    job.run::<L>()
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    //! The lanes of x86-64. Their methods are inlined into `avx2` and `avx512`, where the instructions are
    //! enabled, and are reached through [`super::dispatch`] only, which has found the instructions on the
    //! machine.

    use super::{Job, Lane};
    use crate::ground::planes::CHUNK;
    use core::arch::x86_64::*;

    #[target_feature(enable = "avx2")]
    pub fn avx2<J: Job>(job: J) -> J::Output {
        job.run::<__m256d>()
    }

    #[target_feature(enable = "avx512f")]
    pub fn avx512<J: Job>(job: J) -> J::Output {
        job.run::<__m512d>()
    }

    /// Declares a lane: its width, the instructions that memory and the methods with two operands take, and
    /// the other methods.
    macro_rules! lane {
        ($lane:ty, $width:literal, [$splat:ident, $load:ident, $store:ident, $sqrt:ident],
            [$($method:ident = $instruction:ident),*], { $($other:tt)* }) => {
            impl Lane for $lane {
                in_groups!($width);
                #[inline(always)]
                fn splat(x: f64) -> Self {
                    // SAFETY: run only where the lane's instructions are enabled; in all its methods.
                    unsafe { $splat(x) }
                }
                #[inline(always)]
                fn load(group: &[f64; $width]) -> Self {
                    // SAFETY: the group holds WIDTH numbers.
                    unsafe { $load(group.as_ptr()) }
                }
                #[inline(always)]
                fn store(self, group: &mut [f64; $width]) {
                    // SAFETY: the group holds WIDTH numbers.
                    unsafe { $store(group.as_mut_ptr(), self) }
                }
                #[inline(always)]
                fn load_right(numbers: &[f64; CHUNK], group: usize) -> Self {
                    // A group of eight is the last of the eight, and never asked.
                    let first = if $width == CHUNK { 0 } else { $width * group + 1 };
                    let right = &numbers[first..first + $width];
                    // SAFETY: the slice holds WIDTH numbers.
                    unsafe { $load(right.as_ptr()) }
                }
                #[inline(always)]
                fn sqrt(self) -> Self {
                    // SAFETY: as in `splat`.
                    unsafe { $sqrt(self) }
                }
                $(#[inline(always)]
                fn $method(self, other: Self) -> Self {
                    // SAFETY: as in `splat`.
                    unsafe { $instruction(self, other) }
                })*
                $($other)*
            }
        };
    }

    lane!(
        __m128d,
        2,
        [_mm_set1_pd, _mm_loadu_pd, _mm_storeu_pd, _mm_sqrt_pd],
        [add = _mm_add_pd, sub = _mm_sub_pd, mul = _mm_mul_pd, div = _mm_div_pd, max = _mm_max_pd, min = _mm_min_pd],
        {
            #[inline(always)]
            fn any_not_below(self, limit: Self) -> bool {
                // SAFETY: SSE2 is part of x86-64; in all methods of this lane.
                unsafe { _mm_movemask_pd(_mm_cmpnlt_pd(self, limit)) != 0 }
            }
            #[inline(always)]
            fn any_above(self, limit: Self) -> bool {
                // SAFETY: as above.
                unsafe { _mm_movemask_pd(_mm_cmpnle_pd(self, limit)) != 0 }
            }
            #[inline(always)]
            fn or_zero_below(self, limit: Self) -> Self {
                // SAFETY: as above.
                unsafe {
                    let size = _mm_andnot_pd(_mm_set1_pd(-0.0), self);
                    _mm_and_pd(self, _mm_cmpnlt_pd(size, limit))
                }
            }
            #[inline(always)]
            fn right_of(self, next: Self) -> Self {
                // SAFETY: as above.
                unsafe { _mm_shuffle_pd::<0b01>(self, next) }
            }
            #[inline(always)]
            fn left_of(self, previous: Self) -> Self {
                // SAFETY: as above.
                unsafe { _mm_shuffle_pd::<0b01>(previous, self) }
            }
        }
    );

    lane!(
        __m256d,
        4,
        [_mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_sqrt_pd],
        [
            add = _mm256_add_pd,
            sub = _mm256_sub_pd,
            mul = _mm256_mul_pd,
            div = _mm256_div_pd,
            max = _mm256_max_pd,
            min = _mm256_min_pd
        ],
        {
            #[inline(always)]
            fn any_not_below(self, limit: Self) -> bool {
                // SAFETY: run only inside `avx2`; all methods of this lane.
                unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_NLT_UQ>(self, limit)) != 0 }
            }
            #[inline(always)]
            fn any_not_below_either([a, b]: [Self; 2], limits: [Self; 2]) -> bool {
                // SAFETY: as above.
                unsafe {
                    let (a, b) =
                        (_mm256_cmp_pd::<_CMP_NLT_UQ>(a, limits[0]), _mm256_cmp_pd::<_CMP_NLT_UQ>(b, limits[1]));
                    _mm256_movemask_pd(_mm256_or_pd(a, b)) != 0
                }
            }
            #[inline(always)]
            fn any_above(self, limit: Self) -> bool {
                // SAFETY: as above.
                unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_NLE_UQ>(self, limit)) != 0 }
            }
            #[inline(always)]
            fn or_zero_below(self, limit: Self) -> Self {
                // SAFETY: as above.
                unsafe {
                    let size = _mm256_andnot_pd(_mm256_set1_pd(-0.0), self);
                    _mm256_and_pd(self, _mm256_cmp_pd::<_CMP_NLT_UQ>(size, limit))
                }
            }
            #[inline(always)]
            fn right_of(self, next: Self) -> Self {
                // SAFETY: as above. [a2 a3 b0 b1], then [a1 a2 a3 b0].
                unsafe { _mm256_shuffle_pd::<0b0101>(self, _mm256_permute2f128_pd::<0x21>(self, next)) }
            }
            #[inline(always)]
            fn left_of(self, previous: Self) -> Self {
                // SAFETY: as above. [p2 p3 a0 a1], then [p3 a0 a1 a2].
                unsafe { _mm256_shuffle_pd::<0b0101>(_mm256_permute2f128_pd::<0x21>(previous, self), self) }
            }
        }
    );

    lane!(
        __m512d,
        8,
        [_mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_sqrt_pd],
        [
            add = _mm512_add_pd,
            sub = _mm512_sub_pd,
            mul = _mm512_mul_pd,
            div = _mm512_div_pd,
            max = _mm512_max_pd,
            min = _mm512_min_pd
        ],
        {
            #[inline(always)]
            fn any_not_below(self, limit: Self) -> bool {
                // SAFETY: run only inside `avx512`; all methods of this lane.
                unsafe { _mm512_cmp_pd_mask::<_CMP_NLT_UQ>(self, limit) != 0 }
            }
            #[inline(always)]
            fn any_above(self, limit: Self) -> bool {
                // SAFETY: as above.
                unsafe { _mm512_cmp_pd_mask::<_CMP_NLE_UQ>(self, limit) != 0 }
            }
            #[inline(always)]
            fn or_zero_below(self, limit: Self) -> Self {
                // SAFETY: as above.
                unsafe { _mm512_maskz_mov_pd(_mm512_cmp_pd_mask::<_CMP_NLT_UQ>(_mm512_abs_pd(self), limit), self) }
            }
            #[inline(always)]
            fn right_of(self, next: Self) -> Self {
                // SAFETY: as above.
                unsafe {
                    _mm512_castsi512_pd(_mm512_alignr_epi64::<1>(_mm512_castpd_si512(next), _mm512_castpd_si512(self)))
                }
            }
            #[inline(always)]
            fn left_of(self, previous: Self) -> Self {
                // SAFETY: as above.
                unsafe {
                    _mm512_castsi512_pd(_mm512_alignr_epi64::<7>(
                        _mm512_castpd_si512(self),
                        _mm512_castpd_si512(previous),
                    ))
                }
            }
        }
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number and integer of some lines is another place in them, and all of them are reached.
    #[test]
    fn lines_are_numbers_and_integers() {
        let mut lines = [CacheLine::ZERO; 3];
        assert_eq!((size_of::<CacheLine>(), align_of::<CacheLine>()), (64, 64));
        CacheLine::reals(&mut lines).iter_mut().enumerate().for_each(|(k, number)| *number = k as f64);
        assert_eq!(lines.map(|line| line.0[7]), [7.0, 15.0, 23.0]);
        let words = CacheLine::words(&mut lines);
        assert_eq!(words.len(), 48);
        words.fill(0);
        assert!(lines.iter().all(|line| line.0 == [0.0; 8]));
    }

    records! {
        /// Record of two integers, a vector and two pairs.
        pub struct Mixed {
            /// Integers.
            pub integers: [u32; 2],
            /// Vector.
            pub vector: Vector3<f64>,
            /// Pairs.
            pub pairs: [[f64; 2]; 2],
        }
    }

    /// Fields of a record are the numbers in the order of its list, and back; numbers left over are in none.
    #[test]
    fn records_are_their_numbers_in_order() {
        let mut numbers: [f64; 19] = core::array::from_fn(|k| k as f64);
        let records = Mixed::of(&mut numbers);
        assert_eq!(records.len(), 2);
        assert_eq!(records[0].integers, [0; 2]);
        let second = Mixed {
            integers: records[1].integers,
            vector: Vector3::new(9.0, 10.0, 11.0),
            pairs: [[12.0, 13.0], [14.0, 15.0]],
        };
        assert_eq!(records[1], second);
        records[0].vector.z = -3.0;
        assert_eq!((numbers[3], numbers[18]), (-3.0, 18.0));
    }

    const A: [f64; 8] = [0.1, -2.0, 3.0, f64::NAN, 5.0, -0.0, 7.0, 1e300];
    const B: [f64; 8] = [1.0, 20.0, -30.0, 4.0, f64::NAN, 0.0, 0.7, 1e300];

    /// Every operation on two rows of eight, number by number, as bits.
    struct Everything;
    impl Job for Everything {
        type Output = [[u64; 8]; 10];
        #[inline(always)]
        fn run<L: Lane>(self) -> Self::Output {
            let mut out = [[0.0; 8]; 10];
            let (a, b) = (L::groups(&A), L::groups(&B));
            for k in 0..a.len() {
                let next = L::load(a.get(k + 1).unwrap_or(&b[0]));
                let previous = L::load(if k > 0 { &a[k - 1] } else { &b[b.len() - 1] });
                let (a, b) = (L::load(&a[k]), L::load(&b[k]));
                let sides = [a.right_of(next), a.left_of(previous)];
                let kept = a.or_zero_below(b);
                let results = [
                    a.add(b),
                    a.sub(b),
                    a.mul(b),
                    a.div(b),
                    a.mul(a).sqrt(),
                    a.max(b),
                    a.min(b),
                    sides[0],
                    sides[1],
                    kept,
                ];
                for (slot, result) in out.iter_mut().zip(results) {
                    result.store(&mut L::groups_mut(slot)[k]);
                }
            }
            out.map(|row| row.map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }))
        }
    }

    #[test]
    fn all_lanes_agree_bit_for_bit() {
        let scalar = Everything.run::<f64>();
        for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
            assert_eq!(dispatch(set, Everything), scalar, "{}", set.name());
        }
    }

    /// Whether any number is (not below, above) 1.
    struct Found([f64; 8]);
    impl Job for Found {
        type Output = (bool, bool);
        #[inline(always)]
        fn run<L: Lane>(self) -> (bool, bool) {
            let limit = L::splat(1.0);
            let groups = L::groups(&self.0);
            let not_below = groups.iter().any(|group| L::load(group).any_not_below(limit));
            let above = groups.iter().any(|group| L::load(group).any_above(limit));
            (not_below, above)
        }
    }

    #[test]
    fn a_large_or_missing_number_is_found_in_every_place() {
        for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
            assert_eq!(dispatch(set, Found([0.5; 8])), (false, false));
            for place in 0..8 {
                for (bad, above) in [(1.0, false), (f64::NAN, true), (f64::INFINITY, true), (1.5, true)] {
                    let mut row = [0.5; 8];
                    row[place] = bad;
                    assert_eq!(dispatch(set, Found(row)), (true, above), "{} {place} {bad}", set.name());
                }
            }
        }
    }
}
