//! Closed forms for the parameter of ridge.
//!
//! In the scaled columns, with p numerically nonzero directions and σ² of the request or of the
//! residuals:
//! * `hkb`: `(p − 2) σ² / ‖Â‖²`, and `hkb_1975`: `p σ² / ‖Â‖²` (Hoerl, Kennard and Baldwin 1975;
//!   the first is the form that common software computes);
//! * `lawless_wang`: `(p − 2) σ² λ̄ / Σ λᵢ aᵢ²` with the mean eigenvalue λ̄ (Lawless and Wang
//!   1976). λ̄ is 1 on columns of unit length and m on standardised ones, which makes the estimate
//!   the same under both.

use super::{
    search::{Chosen, Place, Unavailable},
    spectral::Spectral,
};
use crate::spec::Criterion;

/// k of ridge by `criterion`, for coefficients `a` along the directions of `problem`.
pub(super) fn ridge_parameter(criterion: Criterion, problem: &Spectral, a: &[f64]) -> Result<Chosen, Unavailable> {
    let variance = problem.variance.ok_or(Unavailable::NoSigma)?;
    let nonzero = || problem.lambda.iter().zip(a).filter(|(lambda, _)| **lambda > 0.0);
    let p = nonzero().count() as f64;
    let norm: f64 = nonzero().map(|(_, a)| a * a).sum();
    let k = match criterion {
        Criterion::Hkb => (p - 2.0) * variance / norm,
        Criterion::Hkb1975 => p * variance / norm,
        Criterion::LawlessWang => {
            let mean = nonzero().map(|(lambda, _)| lambda).sum::<f64>() / p;
            (p - 2.0) * variance * mean / nonzero().map(|(lambda, a)| lambda * a * a).sum::<f64>()
        }
        _ => return Err(Unavailable::NoMinimiser),
    };
    if k > 0.0 && k.is_finite() {
        Ok(Chosen { lambda_star: k, interval: None, place: Place::Inside })
    } else if variance == 0.0 {
        // no noise: nothing to shrink, as the other criteria answer with the low end of their
        // search
        let low = super::search::range(problem, super::filter::Rule::Ridge)[0];
        Ok(Chosen { lambda_star: low, interval: None, place: Place::Inside })
    } else {
        Err(Unavailable::NoMinimiser)
    }
}
