//! The answer to a correction.

use super::{
    damping::Trust,
    gain::Gain,
    limits::{Fitted, Limit, fit_free, least_change, positions},
    needed::{Unchanged, left_alone},
    problem::{Correction, Setting, SettingsUsed},
    rounding::rounded,
};
use crate::warning::Warning;
use flankfit_estimation::{FitError, FitResult, Unconverged, result::NormLimitSource};
use flankfit_numerics::cancel::Asking;
#[cfg(feature = "contract")]
use flankfit_numerics::contract::with_gaps;

/// Change of a setting.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = SettingChange)
)]
pub struct Change {
    /// The setting.
    pub name: String,
    /// Unit of the change, such as `µm` or `′` (minutes of arc).
    #[cfg_attr(feature = "contract", serde(default, skip_serializing_if = "String::is_empty"))]
    pub unit: String,
    /// Δ, to be added to the setting.
    pub change: f64,
    /// Change before rounding to the increment; absent without one. Standard errors refer to it.
    pub unrounded: Option<f64>,
    /// Change of the fit without limits, 0 where it is fixed or undetermined; absent if it is the
    /// same.
    pub unlimited: Option<f64>,
    /// Standard error of the change from noise and errors of the sensitivity
    /// (`response_uncertainty`) together, about the mean of this regularised correction. It
    /// excludes the bias of regularisation, which `bias_bound` limits: the ideal change lies within
    /// the sum of both in two cases of three or more, if its norm is within that of the bound
    /// (docs/explanation/mathematics.md). Absent at a limit and without degrees of freedom.
    pub std_error: Option<f64>,
    /// Part of it that is due to errors of the sensitivity.
    pub response_std_error: Option<f64>,
    /// Sharp bound on the bias of regularisation, if the ideal changes have at most the norm
    /// `result.bias.coefficient_norm_limit` in the scaled columns (its source is next to it). If
    /// the source is `limits`, at most the distance from the unrounded change to its farther limit.
    /// Absent at a limit.
    pub bias_bound: Option<f64>,
    /// True if it was stopped at a limit.
    pub limited: bool,
    /// True if it was rounded to a multiple of the increment.
    pub rounded: bool,
    /// True if it was fixed by the request.
    pub fixed: bool,
    /// Reason for not changing it; absent if it is changed, fixed or undetermined.
    pub unchanged: Option<Unchanged>,
    /// True if the deviations do not determine the setting (see `absolute`), or other settings have
    /// the same effect, as for a twist with only one profile and one helix. It is not changed, or
    /// only as far as its limits require.
    pub undetermined: bool,
}

/// Settings whose effects nearly cancel on these nodes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Indistinguishable {
    /// Names of the settings, the leading one first.
    pub names: Vec<String>,
    /// √(λₙ/λᵢ) of the direction; absent where it is infinite: they depend on each other exactly.
    pub condition_index: Option<f64>,
    /// The same in words.
    pub sentence: String,
}

/// The flank after the correction, if the machine follows the sensitivity, by the nodes
/// that take part. Where deviations have no datum, root mean squares and amounts are about the
/// mean.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = PredictedFlank)
)]
pub struct Predicted {
    /// Weighted root mean square of the predicted deviations less their target.
    pub rms_um: f64,
    /// Largest amount of the predicted deviations less their target.
    pub max_um: f64,
    /// Weighted root mean square before the correction, likewise.
    pub rms_before_um: f64,
    /// Largest amount before the correction, likewise.
    pub max_before_um: f64,
    /// Predicted deviation d + JΔ of every node in the order posted; `null` where undefined.
    /// Present when `nodes` was included.
    #[cfg_attr(
        feature = "contract",
        serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "with_gaps"),
        schema(value_type = Vec<Option<f64>>)
    )]
    pub deviation_um: Vec<f64>,
    /// Standard uncertainty of the change at each node due to independent errors η of the entries
    /// of the sensitivity: η √Σ (J_kj Δ_j)². Present when `nodes` was included.
    #[cfg_attr(
        feature = "contract",
        serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "with_gaps"),
        schema(value_type = Vec<Option<f64>>)
    )]
    pub uncertainty_um: Vec<f64>,
}

/// Noise of a measured deviation of weight 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// σ, µm.
    pub sigma: f64,
    /// Degrees of freedom that it was estimated from; `None` where the caller knows it.
    pub freedom: Option<usize>,
}

/// A correction of the settings, with its errors and what it should leave.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// One entry for each setting, in the order of the request.
    pub settings: Vec<Change>,
    /// Near dependencies between the columns of J, the worst first.
    pub indistinguishable: Vec<Indistinguishable>,
    /// The flank after the correction.
    pub predicted: Predicted,
    /// −∂c_k/∂d_k of each node, 0 where it takes no part: how far the predicted change c = JΔ
    /// follows the noise of the node's own deviation.
    pub leverage: Vec<f64>,
    /// `None` without degrees of freedom.
    pub noise: Option<Noise>,
    /// How λ* came about, where uncertainty chose it.
    pub trust: Option<Trust>,
    /// The fit of the settings that are changed, without limits; of all that may be changed where
    /// all of them are left alone.
    pub fit: FitResult,
    /// The fit of the free settings, where some are at their limits and some are not.
    pub limited_fit: Option<FitResult>,
    /// Warnings that the fits do not give.
    pub warnings: Vec<Warning>,
}

/// How far what is wanted of a setting can lie from the change Δ, where the bounds of `fit` take
/// all that is wanted to be within the limits.
///
/// The ball of radius r holds the box of the limits and more: settings that can hardly be
/// distinguished may be far out of the box in it, and their sharp bound b with them. *Capping b
/// loses nothing.* Let w be wanted, `min ≤ w ≤ max`, and Δ the change of a free setting, which is
/// within the limits as well. Then `|w − Δ| ≤ c = max(Δ − min, max − Δ)`. With s the random error,
/// w is in `Δ ± (s + min(b, c))` whenever it is in `Δ ± (s + b)`: for b ≤ c the two are one, else
/// the former has every w that the limits allow. ∎ Where r comes from elsewhere, nobody has said
/// that w keeps to the limits, and there is no such c.
fn furthest_wanted(setting: &Setting, change: f64, fit: &FitResult) -> f64 {
    match (fit.bias.coefficient_norm_limit_source, setting.min, setting.max) {
        (NormLimitSource::Limits, Some(min), Some(max)) => (change - min).max(max - change),
        _ => f64::INFINITY,
    }
}

const NOT_CONVERGED: FitError = FitError::NotConverged(Unconverged::Sensitivity);

impl Correction {
    /// Computes the changes of the settings. Pure; the same input gives the same bits.
    ///
    /// ```
    /// use flankfit_estimation::spec::Regularization;
    /// use flankfit_gear::correction::{CorrectionSpec, Correction, Damping, Setting};
    ///
    /// // Deviations of 2 + 0.5 k µm at five nodes; an infeed that shifts all of them by 1 µm, an
    /// // angle that tilts them by 1 µm from node to node. Undone by −2 and −0.5.
    /// let deviation: Vec<f64> = (0..5).map(|k| 2.0 + 0.5 * f64::from(k)).collect();
    /// let matrix: Vec<f64> = (0..5).flat_map(|k| [1.0, f64::from(k)]).collect();
    /// let settings = vec![Setting::free("infeed", "µm"), Setting::free("angle", "µm per node")];
    /// let damping = Damping::Given(Regularization::None);
    /// let asked = CorrectionSpec { damping, ..CorrectionSpec::new(deviation, matrix, settings) };
    /// let solution = Correction::new(asked)?.solve()?;
    /// let changes: Vec<f64> = solution.settings.iter().map(|setting| setting.change).collect();
    /// assert!((changes[0] + 2.0).abs() < 1e-9 && (changes[1] + 0.5).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn solve(&self) -> Result<Solution, FitError> {
        let n = self.asked.settings.len();
        // fixed settings stay, and those that nothing is said about go no further than they must
        let mut unlimited = vec![0.0; n];
        self.undetermined.iter().for_each(|&j| unlimited[j] = least_change(&self.asked.settings[j]));
        let all = fit_free(self, &self.open, &unlimited)?;
        let indistinguishable = Self::indistinguishable(&all.result);
        let left = match self.asked.used {
            SettingsUsed::All => vec![None; n],
            SettingsUsed::Needed => {
                let sigma = self.noise(&all.result).map(|noise| noise.sigma);
                left_alone(self, &unlimited, sigma, self.asked.keep_within).ok_or(NOT_CONVERGED)?
            }
        };
        let used: Vec<usize> = self.open.iter().copied().filter(|&j| left[j].is_none()).collect();
        let Fitted { result: fit, trust } = match used.len() {
            some if some == self.open.len() || some == 0 => all,
            _ => fit_free(self, &used, &unlimited)?,
        };
        used.iter().zip(&fit.coefficients).for_each(|(&j, coefficient)| unlimited[j] = coefficient.value);
        let pinned: Vec<Option<f64>> = (0..n).map(|j| (!used.contains(&j)).then_some(unlimited[j])).collect();
        let standing = positions(self, &unlimited, &pinned)?;
        let mut warnings = Vec::new();
        if !standing.settled {
            warnings.push(Warning::LimitsNotSettled);
        }
        let change = rounded(self, &used, &standing.change)?;
        let limited_fit = standing.fitted.map(|fitted| fitted.result);
        let free: Vec<usize> = used.iter().copied().filter(|&j| standing.at[j].is_none()).collect();
        let of_free = limited_fit.as_ref().unwrap_or(&fit);
        let noise = self.noise(of_free);
        let gain = match free.is_empty() {
            true => None,
            false => Some(Gain::new(self, &free, of_free).ok_or(NOT_CONVERGED)?),
        };
        let leverage = gain.as_ref().map_or_else(|| vec![0.0; self.asked.deviation.len()], Gain::leverage);
        let errors =
            noise.zip(gain).map(|(noise, gain)| self.errors(of_free, noise, &gain, &standing.change, &leverage));
        let mut settings = self.changes(of_free, errors.as_deref(), &standing.change, &standing.at, &unlimited, &left);
        for (setting, change) in settings.iter_mut().zip(change.iter().flatten()) {
            setting.change = *change;
        }
        for setting in &mut settings {
            let same = setting.unrounded.unwrap_or(setting.change);
            setting.unlimited = setting.unlimited.filter(|unlimited| *unlimited != same);
        }
        let predicted = self.predict(change.as_ref().unwrap_or(&standing.change));
        self.warn(&settings, &fit, &mut warnings);
        Ok(Solution { settings, indistinguishable, predicted, leverage, noise, trust, fit, limited_fit, warnings })
    }

    fn noise(&self, fit: &FitResult) -> Option<Noise> {
        // every mean that was taken off is a degree of freedom less than the fit knows
        let (fitted, lost) = (fit.residuals.degrees_of_freedom, self.lost());
        let estimated = || {
            let (sigma, freedom) = (fit.residuals.sigma?, fitted.checked_sub(lost).filter(|freedom| *freedom > 0)?);
            Some(Noise { sigma: sigma * (fitted as f64 / freedom as f64).sqrt(), freedom: Some(freedom) })
        };
        let noise = self.asked.noise_sigma.map(|sigma| Noise { sigma, freedom: None }).or_else(estimated)?;
        Some(Noise { sigma: noise.sigma.max(self.asked.scatter.node), ..noise })
    }

    /// Standard deviations of the free settings, of noise and errors of J together and of those of
    /// J alone.
    fn errors(
        &self,
        fit: &FitResult,
        noise: Noise,
        gain: &Gain<'_>,
        change: &[f64],
        leverage: &[f64],
    ) -> Vec<[f64; 2]> {
        let residuals = &fit.residuals;
        let of_response = gain.response_rss(change, leverage);
        let (sigma, misfit) = match noise.freedom {
            None => {
                let random = noise.sigma * noise.sigma * residuals.degrees_of_freedom as f64 + of_response;
                (noise.sigma, if residuals.rss > random { 1.0 - random / residuals.rss } else { 0.0 })
            }
            // what remains is taken for noise; it holds the errors of single entries of J too, and
            // they count once
            Some(freedom) => {
                let left = ((residuals.least_squares_rss - of_response) / freedom.max(1) as f64).max(0.0).sqrt();
                (left.max(self.asked.scatter.node), 0.0)
            }
        };
        let errors = gain.errors(change, misfit);
        let both =
            |((own, response), scatter): ((&f64, &f64), f64)| [(sigma * own).max(scatter).hypot(*response), *response];
        errors.noise.iter().zip(&errors.response).zip(gain.scatter()).map(both).collect()
    }

    fn changes(
        &self,
        fit: &FitResult,
        errors: Option<&[[f64; 2]]>,
        change: &[f64],
        at: &[Option<Limit>],
        unlimited: &[f64],
        unchanged: &[Option<Unchanged>],
    ) -> Vec<Change> {
        let mut of_free = fit.coefficients.iter().enumerate();
        self.asked
            .settings
            .iter()
            .enumerate()
            .map(|(j, setting)| {
                let open = self.open.contains(&j) && unchanged[j].is_none();
                let own = if at[j].is_none() && open { of_free.next() } else { None };
                let [std_error, response_std_error] = match own.zip(errors) {
                    Some(((place, _), errors)) => errors[place].map(Some),
                    None => [None; 2],
                };
                let undetermined = self.undetermined.contains(&j);
                let moved = undetermined && change[j] != 0.0;
                Change {
                    name: setting.name.clone(),
                    unit: setting.unit.clone(),
                    change: change[j],
                    unlimited: Some(if undetermined { 0.0 } else { unlimited[j] }),
                    std_error,
                    response_std_error,
                    bias_bound: own.map(|(_, found)| found.bias_bound.min(furthest_wanted(setting, change[j], fit))),
                    limited: at[j].is_some() || moved,
                    unrounded: setting.increment.filter(|_| open).map(|_| change[j]),
                    rounded: open && setting.increment.is_some(),
                    fixed: setting.fixed,
                    unchanged: unchanged[j],
                    undetermined,
                }
            })
            .collect()
    }

    /// The flank after the change `change` of the settings.
    pub fn predict(&self, change: &[f64]) -> Predicted {
        let asked = &self.asked;
        let eta = asked.response_uncertainty;
        let (mut deviation_um, mut uncertainty_um) = (Vec::new(), Vec::new());
        for (k, d) in asked.deviation.iter().enumerate().asking(2 * change.len()) {
            let (mut moved, mut square) = (0.0, 0.0);
            for ((j, given), c) in self.row(k).iter().zip(self.given_row(k)).zip(change) {
                moved += j * c;
                square += (given * c) * (given * c);
            }
            deviation_um.push(d + moved);
            uncertainty_um.push(eta * square.sqrt());
        }
        let [rms_um, max_um] = self.size(&deviation_um);
        let [rms_before_um, max_before_um] = self.size(&asked.deviation);
        Predicted { rms_um, max_um, rms_before_um, max_before_um, deviation_um, uncertainty_um }
    }

    /// Weighted root mean square and largest modulus about the target, over the nodes that take
    /// part.
    fn size(&self, deviation: &[f64]) -> [f64; 2] {
        let (mut sum, mut weight, mut max) = (0.0, 0.0, 0.0f64);
        for &k in &self.counted {
            let left = deviation[k] - self.target(k) - self.level(k);
            sum += self.weight(k) * left * left;
            weight += self.weight(k);
            max = max.max(left.abs());
        }
        [(sum / weight).sqrt(), max]
    }
}
