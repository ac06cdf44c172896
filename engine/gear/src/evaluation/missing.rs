//! Stretches where samples are missing: longer than the trace's own spacing, short of a hole or
//! not.
//!
//! A trace may be sampled evenly and thinly, or more densely where its flank bends: the spacing
//! that counts is that of the neighbourhood. Where so few samples stand together that most
//! distances are long, those are the spacing.

use flankfit_numerics::cancel::Asking;

/// Share of the evaluation range that a distance without missing samples may be. The standard's
/// cut-off of 1/30 leaves no wave that could hide in it.
pub(crate) const HIDES_NOTHING: f64 = 0.01;
/// Multiple of three quarters of the neighbouring distances at which samples are missing.
pub(crate) const MISSING_DISTANCES: f64 = 3.0;
/// Distances on either side that are looked at.
const BESIDE: usize = 8;
/// Rounding of positions.
const ROUNDING: f64 = 1e-9;

/// Which of the distances of neighbouring places are stretches with missing samples.
pub(super) fn missing(distances: &[f64], range: f64) -> Vec<bool> {
    let is_missing = |(k, distance): (usize, &f64)| {
        *distance > HIDES_NOTHING * range * (1.0 + ROUNDING) && {
            let before = &distances[k.saturating_sub(BESIDE)..k];
            let behind = &distances[k + 1..distances.len().min(k + 1 + BESIDE)];
            let mut near = [before, behind].concat();
            near.sort_by(f64::total_cmp);
            let upper = near.get((3 * near.len()).div_ceil(4).saturating_sub(1));
            upper.is_some_and(|upper| *distance > MISSING_DISTANCES * upper * (1.0 + ROUNDING))
        }
    };
    distances.iter().enumerate().asking(5).map(is_missing).collect()
}
