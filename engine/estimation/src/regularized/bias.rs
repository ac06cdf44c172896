//! Bias of a regularisation: the observed bias and its bounds (Eqs. 50 and 51).
//!
//! Norms are of coefficient vectors in the scaled columns, where λ* acts. With `r ≥ ‖A‖`:
//! * observed: `‖D‖`, `D = Â − Â_B = Σ (1−fᵢ) aᵢ Vᵢ`;
//! * sharp: `‖D‖ ≤ r · max (1−fᵢ)`, attained, hence unimprovable from r alone;
//! * the paper's Ineq. 51, reading its undefined small number as `e = max cᵢ`. It holds for every L
//!   and n ≥ 2; for n = 1 it does not and is not given.

use crate::{
    selection::{Filtered, Rule},
    spectrum::Spectrum,
};

/// The three figures.
pub(super) struct Bias {
    pub norm: f64,
    pub sharp: f64,
    pub paper: Option<f64>,
    pub e: Option<f64>,
}

/// Bias of the estimate filtered by `filtered` (one for each direction) at `parameter`, given r.
pub(super) fn bias(spectrum: &Spectrum, rule: Rule, parameter: f64, filtered: &[Filtered], r: f64) -> Bias {
    let norm = spectrum.a.iter().zip(filtered).map(|(a, f)| (a * f.removed).powi(2)).sum::<f64>().sqrt();
    let sharp = r * filtered.iter().map(|f| f.removed).fold(0.0, f64::max);
    let coefficients: Option<Vec<f64>> =
        spectrum.lambda.iter().enumerate().map(|(i, &lambda)| rule.coefficient(i, lambda, parameter)).collect();
    let e = coefficients.map(|c| c.into_iter().fold(0.0, f64::max));
    let n = spectrum.lambda.len();
    let paper = e.filter(|_| n >= 2).and_then(|e| {
        if e == 0.0 {
            return Some(0.0);
        }
        // √( tr H e² λ₁² (1+e²) r² / (λ_min(H)² det(H)^{1/n}) ), by logarithms
        let trace: f64 = filtered.iter().map(|f| f.eigenvalue).sum();
        let least = filtered.iter().map(|f| f.eigenvalue).fold(f64::INFINITY, f64::min);
        let mean_log = filtered.iter().map(|f| f.eigenvalue.ln()).sum::<f64>() / n as f64;
        let log = 0.5 * (trace.ln() - mean_log) + e.ln() + spectrum.lambda[0].ln() + 0.5 * (e * e).ln_1p() - least.ln();
        let bound = log.exp() * r;
        bound.is_finite().then_some(bound)
    });
    Bias { norm, sharp, paper, e }
}

/// Sharp bound on each caller's coefficient: `r ‖ℓⱼᵀ V diag(1−f)‖`, `directions` holding `ℓⱼᵀV` in
/// its rows.
pub(super) fn per_coefficient(directions: &nalgebra::DMatrix<f64>, filtered: &[Filtered], r: f64) -> Vec<f64> {
    (0..directions.nrows())
        .map(|j| {
            r * filtered.iter().enumerate().map(|(i, f)| (directions[(j, i)] * f.removed).powi(2)).sum::<f64>().sqrt()
        })
        .collect()
}
