//! A small generator of reproducible numbers (splitmix64: Steele, Lea and Flood 2014).
//!
//! Stored fits name their seed, and are computed again bit by bit: another generator, or another
//! way to draw below a bound such as that of the `rand` crate, would change them.

/// Its whole state.
pub(super) struct SplitMix(u64);

impl SplitMix {
    pub(super) fn new(seed: u64) -> Self {
        SplitMix(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform on [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform below `end` > 0 (its bias, of order 2⁻⁶⁴·end, does not matter here).
    pub(super) fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.next()) * end as u128) >> 64) as usize
    }

    /// `count` different numbers below `end`, in random order; all of them when there are no more.
    pub(super) fn distinct(&mut self, count: usize, end: usize) -> Vec<usize> {
        let count = count.min(end);
        let mut chosen: Vec<usize> = Vec::with_capacity(count);
        if 4 * count > end {
            let mut all: Vec<usize> = (0..end).collect();
            for i in 0..count {
                let j = i + self.below(end - i);
                all.swap(i, j);
            }
            all.truncate(count);
            return all;
        }
        let mut seen = std::collections::HashSet::with_capacity(count);
        while chosen.len() < count {
            let k = self.below(end);
            if seen.insert(k) {
                chosen.push(k);
            }
        }
        chosen
    }
}
