//! How much of a trace is noise, told from what is systematic.
//!
//! Crowning, reliefs and waviness are the flank's: measured again they come again. So the noise is
//! not the scatter about a mean line but that of contrasts which no smooth curve moves: third
//! differences `(1, −3, 3, −1)/√20` of neighbouring samples, and of means over blocks of
//! neighbouring samples. For independent noise both have the variance σ² (that of blocks times
//! their length); noise whose neighbours go together, as filters leave it, shows in the blocks, and
//! the greater of the two counts. Contrasts beyond four times what is usual are corners and
//! outliers of the flank, not noise, and are left out.
//!
//! What goes together over more than 1/64 of the samples, and every error that is the same all
//! along a trace (alignment, drift, temperature), cannot be told from the flank and is not in this
//! number.

use super::spacing::Spacing;
use crate::numerics::{cancel::Asking, quantiles::median};

/// Fewest contrasts that tell a noise.
pub(crate) const FEWEST_CONTRASTS: usize = 8;
/// Blocks of the trace at least.
const BLOCKS: usize = 64;
/// Median of squares of a standard normal variable.
const MEDIAN_SQUARE: f64 = 0.454_936_423_119_572_8;
/// Contrasts beyond are no noise, in standard deviations.
const CUT: f64 = 4.0;

/// Standard deviation of a sample as far as means and slopes feel it; `None` where the samples are
/// too few to tell.
pub(crate) fn noise(u: &[f64], deviation: &[f64], spacing: &Spacing) -> Option<f64> {
    let single = variance(u, deviation, spacing, 1)?;
    let block = u.len() / BLOCKS;
    let blocks = if block > 1 { variance(u, deviation, spacing, block) } else { None };
    Some(single.max(blocks.unwrap_or(0.0)).sqrt())
}

/// Mean square of the contrasts of blocks of so many samples, per sample.
fn variance(u: &[f64], deviation: &[f64], spacing: &Spacing, block: usize) -> Option<f64> {
    let means: Vec<f64> = deviation.chunks_exact(block).map(|chunk| chunk.iter().sum::<f64>() / block as f64).collect();
    let mut squares = Vec::with_capacity(means.len());
    for (i, four) in means.windows(4).enumerate().asking(10) {
        if !spacing.crosses(u[i * block], u[(i + 4) * block - 1]) {
            let contrast = four[0] - 3.0 * four[1] + 3.0 * four[2] - four[3];
            squares.push(contrast * contrast * block as f64 / 20.0);
        }
    }
    if squares.len() < FEWEST_CONTRASTS {
        return None;
    }
    let usual = median(&mut squares.clone()) / MEDIAN_SQUARE;
    // of rounded numbers more than half may be 0
    let limit = if usual > 0.0 { CUT * CUT * usual } else { f64::INFINITY };
    let (count, sum) =
        squares.iter().filter(|s| **s <= limit).fold((0.0, 0.0), |(count, sum), square| (count + 1.0, sum + square));
    Some(sum / count)
}
