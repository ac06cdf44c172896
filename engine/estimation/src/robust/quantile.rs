//! Regression quantiles (Koenker and Bassett 1978): ρ_τ(r) = r(τ − [r < 0]) in the unit of the
//! heights, so that a share τ of the nodes lies below the surface (but for those on it). The
//! solver, its certificate and the standard errors are those of [`super::least_absolute`].

use super::{
    least_absolute,
    outcome::{Measured, Outcome},
};
use crate::error::FitError;

pub(super) fn estimate(tau: f64, measured: &Measured) -> Result<Outcome, FitError> {
    least_absolute::solve(tau, 1.0 / 2.0, measured)
}
