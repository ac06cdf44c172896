//! The marginal likelihood of a model whose coefficients have Zellner's prior `N(0, g σ² (XᵀX)⁻¹)`.
//!
//! With `whole` the sum of squares of the heights (about their mean if there is a constant with a
//! flat prior), `rss` what the model leaves of it, p coefficients and m degrees of freedom of
//! `whole`, −2 ln L is, less what is common to all models,
//!
//! `m ln(rss + S/(1 + g)) + p ln(1 + g)`, `S = whole − rss`, σ² at its maximum,
//!
//! and `(rss + S/(1 + g))/σ² + p ln(1 + g)` where σ is given. Greatest at `1 + g = max(F, 1)`, F
//! the ratio of mean squares (George and Foster, Biometrika 87, 2000; Liang et al., Journal of the
//! American Statistical Association 103, 2008). It depends neither on the basis nor on the scaling
//! of columns.

/// −2 ln L, less what all models have in common; −∞ where nothing is left of the heights.
pub(crate) fn g_prior(whole: f64, rss: f64, p: f64, m: f64, given: Option<f64>) -> f64 {
    let explained = (whole - rss).max(0.0);
    if p == 0.0 {
        return given.map_or_else(|| m * whole.ln(), |variance| whole / variance);
    }
    let within = given.unwrap_or_else(|| if m > p { rss / (m - p) } else { f64::INFINITY });
    let ratio = (explained / p / within).max(1.0);
    let left = rss + explained / ratio;
    p * ratio.ln() + given.map_or_else(|| m * left.ln(), |variance| left / variance)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No g on a grid is likelier than the closed form's.
    #[test]
    fn the_closed_form_is_the_maximum() {
        for (whole, rss, p, m, given) in
            [(9.0, 2.0, 3.0, 20.0, None), (9.0, 8.5, 3.0, 20.0, None), (50.0, 12.0, 4.0, 30.0, Some(0.3))]
        {
            let least = (0..20_000)
                .map(|k| {
                    let ratio = (k as f64 * 5e-4).exp();
                    let left: f64 = rss + (whole - rss) / ratio;
                    p * ratio.ln() + given.map_or_else(|| m * left.ln(), |variance| left / variance)
                })
                .fold(f64::INFINITY, f64::min);
            let found = g_prior(whole, rss, p, m, given);
            assert!((found - least).abs() < 1e-4, "{found} {least}");
        }
    }
}
