//! Share of noise in a trace, separated from what is systematic.
//!
//! Crowning, reliefs and waviness are the flank's: measured again they come again. So the noise is
//! not the scatter about a mean line but that of contrasts which no smooth curve moves: third
//! differences `(1, −3, 3, −1)/√20` of neighbouring samples, and of means over blocks of
//! neighbouring samples. For independent noise both have the variance σ² (that of blocks times
//! their length); noise whose neighbours go together, as filters leave it, shows in the blocks, and
//! the greater of the two counts. Contrasts above four times what is usual are corners and
//! outliers of the flank, not noise, and are left out.
//!
//! What goes together over more than 1/64 of the samples, and every error that is the same all
//! along a trace (alignment, drift, temperature), cannot be separated from the flank and is not in
//! this number.

use super::spacing::Spacing;
use flankfit_estimation::inference::Inferred;
use flankfit_numerics::{cancel::Asking, distribution::Student, quantiles::median};

/// Fewest contrasts that tell a noise.
pub(crate) const FEWEST_CONTRASTS: usize = 8;
/// Blocks of the trace at least.
const BLOCKS: usize = 64;
/// Median of squares of a standard normal variable.
const MEDIAN_SQUARE: f64 = 0.454_936_423_119_572_8;
/// Contrasts overlap: so many say as much as an independent one. 1 + 2 (ρ₁² + ρ₂² + ρ₃²)
/// with the correlations −15/20, 6/20 and −1/20 of contrasts one, two and three samples apart.
const OVERLAP: f64 = 2.31;
/// Greater contrasts are no noise, in standard deviations.
const CUT: f64 = 4.0;

/// A variance that was estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EstimatedVariance {
    pub value: f64,
    /// Degrees of freedom of the χ² that is spread about its mean as much (Satterthwaite).
    pub freedom: f64,
}

impl EstimatedVariance {
    /// Returns the variance of the sum of independent variables.
    pub(crate) fn sum(parts: impl Iterator<Item = EstimatedVariance> + Clone) -> Self {
        let value: f64 = parts.clone().map(|part| part.value).sum();
        let spread: f64 = parts.clone().map(|part| part.value * part.value / part.freedom).sum();
        // without noise all that is known is how much there was to tell it by
        let freedom = if spread > 0.0 { value * value / spread } else { parts.map(|part| part.freedom).sum() };
        EstimatedVariance { value, freedom }
    }

    /// An estimate whose variance this is.
    pub(crate) fn about(&self, value: f64) -> Inferred {
        let student = Student::new(self.freedom.max(1.0));
        Inferred { value, std_error: self.value.sqrt(), student, ..Inferred::default() }
    }
}

/// Variance of a sample as far as means and slopes feel it; `None` where the samples are too few to
/// tell.
pub(crate) fn noise(u: &[f64], deviation: &[f64], spacing: &Spacing) -> Option<EstimatedVariance> {
    let single = variance(u, deviation, spacing, 1)?;
    let block = u.len() / BLOCKS;
    let blocks = if block > 1 { variance(u, deviation, spacing, block) } else { None };
    Some(blocks.filter(|blocks| blocks.value > single.value).unwrap_or(single))
}

/// Mean square of the contrasts of blocks of so many samples, per sample.
fn variance(u: &[f64], deviation: &[f64], spacing: &Spacing, block: usize) -> Option<EstimatedVariance> {
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
    Some(EstimatedVariance { value: sum / count, freedom: count / OVERLAP })
}
