//! A fitted deviation surface in a gear cell's words: slopes, crownings and twist over the fitted
//! domain.
//!
//! With s and t the two axes mapped to [-1, 1] (Litvin's second-order surface), c the coefficients
//! of the surface's second-order part there: profile slope 2 c_s, helix slope 2 c_t, profile
//! crowning −c_ss, helix crowning −c_tt and twist 4 c_st. They are read off nine heights of the
//! surface, each at the middle of the other axis, so any degree up to (2, 2) gives them exactly.

use crate::api::fits::answer::result::FitResultBody;

/// All in the unit of the heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlankForm {
    pub profile_slope: f64,
    pub helix_slope: f64,
    pub profile_crowning: f64,
    pub helix_crowning: f64,
    pub twist: f64,
}

impl FlankForm {
    /// Of a surface in raw powers of u (profile) and v (face); none for any other fit.
    pub fn of(fit: &FitResultBody) -> Option<Self> {
        let domain = fit.domain.as_ref()?;
        let ([u0, u1], [v0, v1]) = (domain.u?, domain.v?);
        let height = |s: f64, t: f64| -> Option<f64> {
            let u = (u0 + u1) / 2.0 + s * (u1 - u0) / 2.0;
            let v = (v0 + v1) / 2.0 + t * (v1 - v0) / 2.0;
            fit.coefficients.iter().try_fold(0.0, |sum, coefficient| {
                let [p, q] = coefficient.powers.as_deref()?.try_into().ok()?;
                Some(sum + coefficient.value * power(u, p)? * power(v, q)?)
            })
        };
        let middle = height(0.0, 0.0)?;
        let (root, tip) = (height(-1.0, 0.0)?, height(1.0, 0.0)?);
        let (near, far) = (height(0.0, -1.0)?, height(0.0, 1.0)?);
        Some(FlankForm {
            profile_slope: tip - root,
            helix_slope: far - near,
            profile_crowning: middle - (root + tip) / 2.0,
            helix_crowning: middle - (near + far) / 2.0,
            twist: height(1.0, 1.0)? - height(1.0, -1.0)? - height(-1.0, 1.0)? + height(-1.0, -1.0)?,
        })
    }

    /// Names beside values, in the order in which a gear inspection sheet has them.
    pub fn rows(&self) -> [(&'static str, f64); 5] {
        [
            ("profile slope f_Hα", self.profile_slope),
            ("helix slope f_Hβ", self.helix_slope),
            ("profile crowning C_α", self.profile_crowning),
            ("helix crowning C_β", self.helix_crowning),
            ("twist S", self.twist),
        ]
    }
}

fn power(x: f64, exponent: usize) -> Option<f64> {
    Some(x.powi(i32::try_from(exponent).ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_known_surface_gives_its_own_figures() {
        // On [-1, 1]²: 1 + 2u + 3v − 4u² − 5v² + 1.5uv.
        let coefficient = |powers: [usize; 2], value: f64| json!({"term": "", "powers": powers, "value": value, "least_squares": value, "bias_bound": 0.0});
        let fit: FitResultBody = serde_json::from_value(json!({
            "coefficients": [
                coefficient([0, 0], 1.0), coefficient([0, 1], 3.0), coefficient([0, 2], -5.0),
                coefficient([1, 0], 2.0), coefficient([1, 1], 1.5), coefficient([2, 0], -4.0)
            ],
            "domain": {"u": [-1.0, 1.0], "v": [-1.0, 1.0]},
            "spectrum": {"eigenvalues": [], "rank": 6, "regularized": {"eigenvalues": []}},
            "regularization": {"type": "none", "filter_factors": [], "choices": []},
            "bias": {"norm": 0.0, "sharp_bound": 0.0, "coefficient_norm_limit": 0.0,
                "coefficient_norm_limit_source": "estimate"},
            "collinearity": {"columns": [], "near_dependencies": []},
            "residuals": {"count": 9, "degrees_of_freedom": 3, "rss": 0.0, "rms": 0.0, "least_squares_rss": 0.0},
            "numerics": {"arithmetic": "double", "correct_digits": 15.0},
            "warnings": [],
            "provenance": {"engine": "", "input_sha256": ""}
        }))
        .unwrap();
        let form = FlankForm::of(&fit).unwrap();
        assert_eq!(form.rows().map(|(_, value)| value), [4.0, 6.0, 4.0, 5.0, 6.0]);
    }
}
