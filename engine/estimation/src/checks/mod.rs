//! Checks of the residuals: whether the errors are independent and of one variance, and the model
//! complete.
//!
//! Each test has false alarms at [`LEVEL`] if they are, whatever the places of the nodes:
//! * correlation along u and along v: the locally best invariant statistic with its exact moments
//!   ([`lines`]);
//! * variance that depends on the place: Koenker's studentised test ([`variance`]);
//! * lack of fit: F of the terms of the next order, and the score of a smooth Gaussian process
//!   ([`lack`]);
//! * nodes of low weight of a robust fit that lie together ([`clusters`]).
//!
//! The residuals are those of plain least squares times the roots of the weights, whitened where
//! errors are correlated; those of a robust fit are its scores, residuals times weights, which are
//! orthogonal to the columns as well. Regularisation, constraints and priors move the estimate, but
//! say nothing about the errors.

pub(crate) mod clusters;
pub(crate) mod lack;
pub(crate) mod lines;
pub(crate) mod serial;
pub(crate) mod sites;
pub(crate) mod variance;

#[cfg(test)]
mod tests;

pub(crate) use lines::OfGrid;

/// Rate of false alarms of a check.
pub(crate) const LEVEL: f64 = 0.01;
/// Standard deviations above the mean from which on a statistic can be significant.
const SUSPICIOUS: f64 = 1.8;
