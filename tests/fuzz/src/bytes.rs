//! Decoding of a fuzzer's bytes. Bytes that have run out are zeros, so that every byte string means
//! something.

use arbitrary::Unstructured;

/// Numbers that break careless code.
#[rustfmt::skip]
const ODD: [f64; 24] = [
    0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE, 5e-324, -5e-324, 1e-310, f64::MAX, f64::MIN, f64::EPSILON,
    1.0, -1.0, 0.5, 2.0, 1e-300, 1e-150, 1e-12, 1e12, 1e100, 1e154, 1e300, -1e300,
];

/// The bytes not used so far.
pub struct Bytes<'a>(Unstructured<'a>);

impl<'a> Bytes<'a> {
    /// From the start.
    pub fn new(data: &'a [u8]) -> Bytes<'a> {
        Bytes(Unstructured::new(data))
    }

    /// Whether all have been used.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        self.0.arbitrary().unwrap_or(0)
    }

    /// The next 8 bytes.
    pub fn word(&mut self) -> u64 {
        self.0.arbitrary().unwrap_or(0)
    }

    /// A number below `end`, which is at most 256, from one byte.
    pub fn below(&mut self, end: usize) -> usize {
        self.byte() as usize % end
    }

    /// true in one of `times` cases; not when the bytes have run out.
    pub fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == times - 1
    }

    /// One of some.
    pub fn choose<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// A factor in [1/2, 2).
    pub fn factor(&mut self) -> f64 {
        let byte = self.byte();
        (1.0 + f64::from(byte % 128) / 128.0) * if byte < 128 { 1.0 } else { 0.5 }
    }

    /// A number that may be anything: odd, any bits, or the given one made a little different.
    pub fn odd(&mut self, usual: f64) -> f64 {
        match self.below(8) {
            0..3 => self.choose(&ODD),
            3 => f64::from_bits(self.word()),
            4 => -usual,
            5 => usual * (1.0 + f64::EPSILON),
            6 => usual * self.choose(&[1e-9, 1e-3, 1e-1, 10.0, 1e3, 1e9]),
            _ => usual * self.factor(),
        }
    }

    /// A whole number that may be anything.
    pub fn odd_count(&mut self, usual: u64) -> u64 {
        match self.below(6) {
            0 => usual.wrapping_sub(1),
            1 => usual.wrapping_add(1),
            2 => self.choose(&[0, 1, 2, 31, 32, 33, 1 << 20, u32::MAX as u64, 1 << 52, 1 << 53, 1 << 63, u64::MAX]),
            3 => self.word(),
            4 => usual.wrapping_mul(2),
            _ => u64::from(self.byte()),
        }
    }
}
