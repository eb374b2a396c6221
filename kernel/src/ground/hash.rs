//! The hash of scenes, states and images: FNV-1a over words, with a fold. No protection against an attacker.

/// A running 64-bit hash over words, FNV-1a with a fold; each step is a bijection, so changing one word
/// always shows.
#[derive(Clone, Copy, Debug)]
pub struct Hash(pub(crate) u64);

impl Default for Hash {
    fn default() -> Hash {
        Hash(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    /// Takes one word in.
    pub fn word(&mut self, word: u64) {
        let h = (self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        self.0 = h ^ (h >> 29);
    }

    /// Takes a number's bits in.
    pub fn real(&mut self, value: f64) {
        self.word(value.to_bits());
    }

    /// The hash so far.
    pub fn value(self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::Hash;

    /// The checksum is part of the format: images made elsewhere must fit.
    #[test]
    fn the_hash_multiplies_and_folds() {
        let (mut hash, mut expected) = (Hash::default(), 14_695_981_039_346_656_037_u128);
        for word in [0, 1, u64::MAX, 0x0123_4567_89ab_cdef] {
            hash.word(word);
            // FNV's prime, which is odd; then the upper 35 bits once more as the lowest: no two words lead to
            // one value.
            let product = (expected ^ u128::from(word)) * ((1 << 40) + 435) % (1 << 64);
            expected = product ^ (product / (1 << 29));
            assert_eq!(u128::from(hash.value()), expected);
        }
    }
}
