//! Fits that leave nothing but rounding.
//!
//! Where most nodes lie on one surface, or there are no more nodes than coefficients, residuals are
//! rounding errors, and so is any scale that is made of them: 1e-31 would look like a deviation.
//! Such a scale is 0, there are no standard errors, and a warning says how many nodes lie on the
//! surface.

use super::super::result::Warning;

/// Scale below this share of the largest height is rounding.
pub(super) const EXACT: f64 = 1e-14;

/// Residuals up to here lie on the surface; `largest` is the largest height (times √weight).
pub(super) fn rounding(largest: f64) -> f64 {
    64.0 * EXACT * largest
}

/// The warning about an exact fit.
pub(super) fn warning(on: usize, m: usize) -> Warning {
    Warning::ExactFit { on_surface: on, nodes: m }
}

/// A scale and the results that depend on it.
pub(super) struct Settled {
    /// Scale of the residuals; `None` if it is not determined.
    pub scale: Option<f64>,
    /// τ.
    pub dispersion: Option<f64>,
    /// 1 on the surface and 0 off it, where the fit is exact.
    pub weights: Option<Vec<f64>>,
}

/// Checks whether `scale` and `dispersion` are more than rounding of the `residuals` of `n`
/// coefficients.
pub(super) fn settled(
    scale: Option<f64>,
    dispersion: Option<f64>,
    residuals: &[f64],
    n: usize,
    largest: f64,
    warnings: &mut Vec<Warning>,
) -> Settled {
    let (m, edge) = (residuals.len(), rounding(largest));
    let on = residuals.iter().filter(|r| r.abs() <= edge).count();
    let is_rounding = |spread: Option<f64>| spread.is_some_and(|s| s <= EXACT * largest);
    // Most nodes that the coefficients leave free lie on the surface. A scale need not show it:
    // that of a likelihood is a mean over all nodes, which outliers alone can determine.
    let most = 2 * on > m + n;
    if on == m || most || is_rounding(scale) || is_rounding(dispersion) {
        warnings.push(warning(on, m));
        let weights = residuals.iter().map(|r| f64::from(u8::from(r.abs() <= edge))).collect();
        return Settled { scale: Some(0.0), dispersion: None, weights: Some(weights) };
    }
    if scale.is_none() {
        warnings.push(Warning::NoScale);
    }
    Settled { scale, dispersion: dispersion.filter(|_| scale.is_some()), weights: None }
}
