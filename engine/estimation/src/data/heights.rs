//! Weighted sums over the heights.

use super::sample::Sample;
use flankfit_numerics::{Dd, cancel::Asking, lanes::LANES};

/// Weighted sums over the heights.
pub(crate) struct Heights {
    /// Σ w.
    pub weight: f64,
    /// Σ w (z − z̄)².
    pub about_mean: f64,
    /// Σ w z².
    pub about_zero: f64,
    /// max √w |z|.
    pub largest: f64,
    /// max |z|.
    pub largest_plain: f64,
}

/// Heights summed before a compensated total is touched.
const BLOCK: usize = 1024;

impl Heights {
    pub(crate) fn new(sample: &Sample) -> Self {
        let mut weight = Dd::ZERO;
        let (mut sum, mut squares, mut largest, mut largest_plain) = (Dd::ZERO, Dd::ZERO, 0.0f64, 0.0f64);
        over_blocks(sample, |z, w| {
            let mut lanes = [[0.0; LANES]; 5];
            for (z, w) in z.chunks(LANES).zip(w.chunks(LANES)) {
                for (k, (z, w)) in z.iter().zip(w).enumerate() {
                    lanes[0][k] += w;
                    lanes[1][k] += w * z;
                    lanes[2][k] += w * z * z;
                    lanes[3][k] = lanes[3][k].max(w * z * z);
                    lanes[4][k] = lanes[4][k].max(z.abs());
                }
            }
            weight += Dd::from(total(lanes[0]));
            sum += Dd::from(total(lanes[1]));
            squares += Dd::from(total(lanes[2]));
            largest = lanes[3].into_iter().fold(largest, f64::max);
            largest_plain = lanes[4].into_iter().fold(largest_plain, f64::max);
        });
        let mean = (sum / weight).to_f64();
        let mut about_mean = Dd::ZERO;
        over_blocks(sample, |z, w| {
            let mut lanes = [0.0; LANES];
            for (z, w) in z.chunks(LANES).zip(w.chunks(LANES)) {
                for (k, (z, w)) in z.iter().zip(w).enumerate() {
                    lanes[k] += w * (z - mean) * (z - mean);
                }
            }
            about_mean += Dd::from(total(lanes));
        });
        Heights {
            weight: weight.to_f64(),
            about_mean: about_mean.to_f64(),
            about_zero: squares.to_f64(),
            largest: largest.sqrt(),
            largest_plain,
        }
    }
}

fn total(lanes: [f64; LANES]) -> f64 {
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// Hands heights and weights on block by block, in order.
fn over_blocks(sample: &Sample, mut work: impl FnMut(&[f64], &[f64])) {
    let ones = [1.0; BLOCK];
    if let Some(heights) = sample.all_heights().filter(|_| !sample.weighted()) {
        heights.chunks(BLOCK).for_each(|block| work(block, &ones[..block.len()]));
        return;
    }
    let (mut z, mut w) = ([0.0; BLOCK], [1.0; BLOCK]);
    for start in (0..sample.count()).step_by(BLOCK).asking(10 * BLOCK) {
        let here = (sample.count() - start).min(BLOCK);
        for i in 0..here {
            (z[i], w[i]) = (sample.z(start + i), sample.w(start + i));
        }
        work(&z[..here], &w[..here]);
    }
}
