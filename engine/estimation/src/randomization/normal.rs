//! Normal random numbers that are the same on every machine.
//!
//! ChaCha8 (a fixed, portable algorithm) gives the bits, seeded from the study's seed; every
//! repetition has a stream of its own, so that what it draws does not depend on who computed what
//! before. Marsaglia's polar method turns them into normal numbers with square roots, which are
//! exact everywhere, and one logarithm, which is a library's own instead of the platform's.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{RngCore, SeedableRng},
};

/// A stream of standard normal numbers.
pub struct Normals {
    generator: ChaCha8Rng,
    spare: Option<f64>,
}

impl Normals {
    /// Stream number `stream` of `seed`.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Normals { generator, spare: None }
    }

    /// Uniform in (−1, 1), of 53 bits.
    fn symmetric(&mut self) -> f64 {
        const UNIT: f64 = 1.0 / (1u64 << 52) as f64;
        (self.generator.next_u64() >> 11) as f64 * UNIT - 1.0
    }

    /// The next number.
    pub fn draw(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let (a, b) = (self.symmetric(), self.symmetric());
            let square = a * a + b * b;
            if square < 1.0 && square > 0.0 {
                let factor = (-2.0 * libm::log(square) / square).sqrt();
                self.spare = Some(b * factor);
                return a * factor;
            }
        }
    }

    /// The next `count` numbers.
    pub fn take(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.draw()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_reproducible_and_distinct() {
        let first = Normals::new(7, 3).take(5);
        assert_eq!(first, Normals::new(7, 3).take(5));
        assert_ne!(first, Normals::new(7, 4).take(5));
        assert_ne!(first, Normals::new(8, 3).take(5));
    }

    #[test]
    fn moments_are_those_of_the_normal_distribution() {
        let n = 200_000;
        let mut moments = [0.0; 4];
        let mut inside = 0;
        for x in Normals::new(1, 0).take(n) {
            (0..4).for_each(|k| moments[k] += x.powi(k as i32 + 1) / n as f64);
            inside += usize::from(x.abs() < 1.0);
        }
        // four standard errors
        let within = |got: f64, want: f64, deviation: f64| (got - want).abs() < 4.0 * deviation / (n as f64).sqrt();
        assert!(within(moments[0], 0.0, 1.0) && within(moments[1], 1.0, 2f64.sqrt()), "{moments:?}");
        assert!(within(moments[2], 0.0, 15f64.sqrt()) && within(moments[3], 3.0, 96f64.sqrt()), "{moments:?}");
        assert!(within(inside as f64 / n as f64, 0.682_689_492, 0.465));
    }
}
