//! How far a sensitivity matrix is trusted: λ* of a correction that is to be repeated.
//!
//! The machine responds with `G = J + E`, not with J. Along the direction Vᵢ of the settings
//! (unit-length columns, singular value σᵢ, filter factor fᵢ) a correction is divided by σᵢ/fᵢ, so
//! what E adds comes back multiplied: settings that are off by e are off by `(I − V F Σ⁻¹ Uᵀ G) e`
//! after the correction, and this shrinks from round to round in the directions that are corrected
//! when
//!
//! `max(fᵢ/σᵢ) ‖E‖ < 1`  (small gain).
//!
//! Plain least squares has 1/σ₁ there: with one direction that J hardly knows, settings grow at
//! every round. Both schemes of the matrix B have `max(fᵢ/σᵢ) ≤ 1/√λ*`, and of all filters with
//! that bound the *exact* scheme, `fᵢ = min(1, σᵢ/√λ*)`, takes away least. So λ*, the assumed
//! minimal eigenvalue, is what the smallest trusted eigenvalue is: `‖E‖²`. When entries of J are
//! known to the relative standard uncertainty η, columns of length 1 give `‖E‖ ≤ ‖E‖_F`, `‖E‖_F² ≈
//! η² Σλᵢ = η² n`, however their errors hang together.
//!
//! Noise σ of the deviations enters alike: settings of the size that these deviations speak for
//! have `τ² = ‖P y‖²/Σλᵢ` in each direction (P y the part of the heights that J reaches), and a
//! direction says more about settings than about noise when `λᵢ > σ²/τ²`. Together
//!
//! `λ* = Σλᵢ (η² + σ²/‖P y‖²)`, at most λₙ.
//!
//! It depends on J's uncertainty and on the size of noise against the deviations, never on the
//! estimate along small directions, which is what criteria that look at residuals or at a plug-in
//! mean squared error must trust. For the same reason bias bounds do not take the norm of that
//! estimate for the size of what is wanted, but √n τ, or what the limits of the settings allow; and
//! the plug-in mean squared error is not held against λ*.

use flankfit_estimation::{
    FitResult,
    spec::{Count, DEFAULT_CONDITION_LIMIT, Parameter, Regularization, Scheme},
};

/// η unless the caller knows better: a machine follows a calculated sensitivity within some per
/// cent. For a handful of settings this leaves directions up to a condition index of about 30
/// alone, Belsley's rule.
pub const DEFAULT_RESPONSE_UNCERTAINTY: f64 = 0.02;

/// How a correction is regularised.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Damping {
    /// The spectral scheme *exact* with λ* from the uncertainty of J and the noise; where settings
    /// depend on each other exactly, the directions of eigenvalues of at least λ* (truncated
    /// singular value decomposition).
    #[default]
    Uncertainty,
    /// A regularisation of the caller's choice.
    Given(Regularization),
}

/// Trust in the sensitivity, in columns of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = SensitivityTrust)
)]
pub struct Trust {
    /// λ*, the smallest eigenvalue that is trusted: the sum of the two parts below, at most the
    /// largest eigenvalue.
    pub lambda_star: f64,
    /// Part of the uncertainty of the sensitivity: Σλᵢ η².
    pub from_response: f64,
    /// Part of the noise, Σλᵢ σ²/‖P y‖²; absent where no σ is known or no deviation is within
    /// reach.
    pub from_noise: Option<f64>,
    /// Number of directions with smaller eigenvalues.
    pub damped: usize,
    /// Greatest factor by which an error of the response is multiplied: 1/√λ*.
    pub gain: f64,
}

/// λ* from a plain least-squares fit of heights with `square` = Σ w y²; `None` where nothing limits
/// the trust.
pub(super) fn trust(plain: &FitResult, square: f64, eta: f64, sigma: Option<f64>) -> Option<Trust> {
    let lambda = &plain.spectrum.eigenvalues;
    let total: f64 = lambda.iter().sum();
    let largest = lambda.last().copied()?;
    let reached = square - plain.residuals.least_squares_rss;
    let from_response = total * eta * eta;
    let from_noise = sigma
        .or(plain.residuals.sigma)
        .filter(|_| reached > 0.0)
        .map(|sigma| total * (sigma * sigma / reached))
        .filter(|x| x.is_finite());
    let lambda_star = (from_response + from_noise.unwrap_or(0.0)).min(largest);
    if !(lambda_star > 0.0) {
        return None;
    }
    let damped = lambda.iter().filter(|l| **l < lambda_star).count();
    Some(Trust { lambda_star, from_response, from_noise, damped, gain: 1.0 / lambda_star.sqrt() })
}

/// The regularisation that is asked for, given the plain fit.
pub(super) fn regularization(plain: &FitResult, trust: Option<Trust>) -> Regularization {
    let full = plain.spectrum.rank == plain.spectrum.eigenvalues.len();
    match trust {
        Some(trust) if full => Regularization::Spectral {
            scheme: Scheme::Exact,
            count: Count::Given(trust.damped),
            condition_limit: DEFAULT_CONDITION_LIMIT,
            lambda_star: Parameter::Fixed(trust.lambda_star),
        },
        Some(trust) => {
            let kept = plain.spectrum.eigenvalues.len() - trust.damped;
            Regularization::TruncatedSvd { rank: kept.clamp(1, plain.spectrum.rank.max(1)) }
        }
        None if full => Regularization::None,
        None => Regularization::TruncatedSvd { rank: plain.spectrum.rank.max(1) },
    }
}
