//! How the machine answered, in figures and in words.

/// Response of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = MachineVerdict)
)]
pub enum Verdict {
    /// The 99.7 % interval of the response ratio contains 1 and excludes 0.5.
    AsPredicted,
    /// The interval lies below 1: a part of the predicted change came.
    Weaker,
    /// The interval contains 0 and excludes 0.5: hardly any of the predicted change came.
    NoResponse,
    /// The interval lies above 1: more than the predicted change came.
    Stronger,
    /// The measured change is no multiple of the predicted one; `not_entered` names settings that
    /// seem not to have been changed.
    Different,
    /// The interval contains 0.5 and 1: noise or the uncertainty of the sensitivity are too large
    /// for the predicted change.
    Undecided,
}

/// Setting whose change seems not to have been entered.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct NotEntered {
    /// Name of the setting.
    pub setting: String,
    /// Realised share of the change that this setting was predicted to make, if all other settings
    /// responded as predicted.
    pub response_ratio: f64,
    /// Standard error of the share.
    pub response_ratio_std_error: f64,
}

/// Prediction and measurement, over the nodes that are defined before, predicted and after and have
/// a weight above 0.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Answer {
    /// Number of nodes compared.
    pub nodes: usize,
    /// Root mean square of the deviations that the correction was made for, all nodes with equal
    /// weight; here and below about the means where deviations have no datum.
    pub rms_before_um: f64,
    /// Root mean square of the deviations predicted for the changes that were entered, here and
    /// below: those of `applied`, else those of the correction.
    pub rms_predicted_um: f64,
    /// Root mean square of the deviations that were measured after it.
    pub rms_measured_um: f64,
    /// Root mean square of predicted minus before.
    pub rms_predicted_change_um: f64,
    /// Root mean square of measured minus predicted.
    pub rms_difference_um: f64,
    /// Expected value of it by noise and the uncertainty of the sensitivity: √(mean (2σ²/w + u²)).
    pub rms_expected_difference_um: f64,
    /// β̂, the realised share of the predicted change, without the part that comes from the noise
    /// of the first measurement through the correction; absent if the verdict is `undecided` and
    /// its standard error above a third (1 and 0 could not be distinguished).
    pub response_ratio: Option<f64>,
    /// Standard error of the ratio from the noise of both measurements and from errors of the
    /// sensitivity that are common to a setting.
    pub response_ratio_std_error: Option<f64>,
    /// `[low, high]` of the realised share, at 0.95 by that standard error (Student's t if the
    /// noise was estimated). It is conservative: coverage was 0.97 or more in simulated corrections
    /// (docs/explanation/intervals.md).
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub response_ratio_interval: Option<[f64; 2]>,
    /// χ² of measured minus predicted, relative to noise and errors of the sensitivity.
    pub chi_squared: f64,
    /// Quantile of 0.999 that it is compared with; where σ was estimated, that of F times the
    /// number of nodes.
    pub chi_squared_limit: f64,
    /// Verdict of the comparison.
    pub verdict: Verdict,
    /// Settings without whose change the measurement is explained, where nothing else explains it
    /// as well; more than one where they cannot be distinguished.
    #[cfg_attr(feature = "contract", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub not_entered: Vec<NotEntered>,
    /// The verdict in words.
    pub sentence: String,
}

impl Answer {
    /// The verdict in words.
    pub(super) fn in_words(&self) -> String {
        let Answer { rms_difference_um: difference, rms_expected_difference_um: expected, .. } = self;
        let came = self
            .response_ratio
            .map_or(String::new(), |ratio| format!(", {:.0} % of the predicted change was realised", 100.0 * ratio));
        let how = match self.verdict {
            Verdict::AsPredicted => "The machine responded as predicted".to_owned(),
            Verdict::Weaker => "The machine responded more weakly than predicted".to_owned(),
            Verdict::NoResponse => "The machine did not respond".to_owned(),
            Verdict::Stronger => "The machine responded more strongly than predicted".to_owned(),
            Verdict::Different if self.not_entered.is_empty() => {
                "The machine responded differently than predicted".to_owned()
            }
            Verdict::Different => {
                let names: Vec<String> = self.not_entered.iter().map(|one| format!("`{}`", one.setting)).collect();
                format!("The machine responded as if {} had not been changed", names.join(" or "))
            }
            Verdict::Undecided => {
                return format!(
                    "The measurement cannot show the machine's response: a change of {:.3} µm rms was predicted, \
                     noise and the uncertainty of the sensitivity allow a difference of {expected:.3} µm between \
                     measured and predicted, and it is {difference:.3} µm{came}.",
                    self.rms_predicted_change_um
                );
            }
        };
        format!("{how}: measured and predicted differ by {difference:.3} µm rms, {expected:.3} µm are expected{came}.")
    }
}
