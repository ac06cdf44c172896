//! −0 as 0: the digest does not tell them apart, so nothing else may.

/// −0 + 0 is +0; every other number stays.
pub fn unsigned_zero(value: f64) -> f64 {
    value + 0.0
}

pub fn unsigned_zeros(values: &[f64]) -> Vec<f64> {
    values.iter().copied().map(unsigned_zero).collect()
}
