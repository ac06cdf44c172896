//! Draws that a seed decides, the same on every machine.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{RngCore, SeedableRng},
};

pub struct Rng(ChaCha8Rng);

impl Rng {
    /// The draws of request `index` of batch `batch`.
    pub fn of(seed: u64, batch: u64, index: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed ^ batch.rotate_left(20));
        generator.set_stream(index);
        Rng(generator)
    }

    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Below `count`; 0 of none.
    pub fn below(&mut self, count: usize) -> usize {
        if count == 0 { 0 } else { (self.bits() % count as u64) as usize }
    }

    pub fn within(&mut self, low: usize, high: usize) -> usize {
        low + self.below(high + 1 - low)
    }

    /// True in `parts` of 100.
    pub fn percent(&mut self, parts: usize) -> bool {
        self.below(100) < parts
    }

    pub fn pick<'a, T>(&mut self, items: &'a [T]) -> Option<&'a T> {
        items.get(self.below(items.len()))
    }

    /// One of what is written here.
    pub fn one<T: Copy, const N: usize>(&mut self, items: [T; N]) -> T {
        items[self.below(N)]
    }
}
