//! How the machine answered, in figures and in words.

/// How the machine answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = MachineVerdict)
)]
pub enum Verdict {
    /// As far as noise and the uncertainty of the sensitivity allow. With white noise 20 of 28,000
    /// simulated machines that were so were called anything else but `undecided`; waviness that
    /// does not repeat raises that rate (docs/reference/gears.md).
    AsPredicted,
    /// A part of the predicted change came.
    Weaker,
    /// More of the predicted change came.
    Stronger,
    /// What came is no multiple of what was predicted.
    Different,
    /// Noise or the uncertainty of the sensitivity are so great against the predicted change that
    /// an answer is not distinguishable from none.
    Undecided,
}

/// Predicted beside measured, over the nodes that are defined before and after and have a weight
/// above 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Nodes compared.
    pub nodes: usize,
    /// Root mean squares, µm, each node counting alike; about the means where deviations have no
    /// datum.
    pub before_rms: f64,
    /// Of p.
    pub predicted_rms: f64,
    /// Of d'.
    pub measured_rms: f64,
    /// Of p − d.
    pub predicted_change_rms: f64,
    /// Of d' − p.
    pub difference_rms: f64,
    /// What `difference_rms` is expected to be: √(mean (2σ²/w + u²)).
    pub expected_difference_rms: f64,
    /// β̂; `None` where it is not distinguishable from 0.
    pub response_ratio: Option<f64>,
    /// e.
    pub response_ratio_std_error: Option<f64>,
    /// Of 0.95, Student's where σ was estimated.
    pub response_ratio_interval: Option<[f64; 2]>,
    /// χ² = rᵀ S⁻¹ r of r = d' − p.
    pub chi_squared: f64,
    /// The 0.999 quantile that it is held against; where σ was estimated, that of F times the
    /// number of nodes.
    pub chi_squared_limit: f64,
    /// What follows from these figures.
    pub verdict: Verdict,
    /// The verdict in words, with the figures that it rests on.
    pub sentence: String,
}

impl Answer {
    /// The verdict in words.
    pub(super) fn in_words(&self) -> String {
        let Answer { difference_rms: difference, expected_difference_rms: expected, .. } = self;
        let came = self
            .response_ratio
            .map_or(String::new(), |ratio| format!(", {:.0} % of the predicted change came", 100.0 * ratio));
        let apart =
            format!("measured and predicted differ by {difference:.3} µm rms, {expected:.3} µm are expected{came}");
        match self.verdict {
            Verdict::AsPredicted => format!("The machine answered as predicted: {apart}."),
            Verdict::Weaker => format!("The machine answered more weakly than predicted: {apart}."),
            Verdict::Stronger => format!("The machine answered more strongly than predicted: {apart}."),
            Verdict::Different => format!("The machine answered differently: {apart}."),
            Verdict::Undecided => format!(
                "The measurement says nothing about the machine's answer: a change of {:.3} µm rms was predicted, \
                 noise and the uncertainty of the sensitivity let measured and predicted differ by {expected:.3} µm, \
                 and they differ by {difference:.3} µm.",
                self.predicted_change_rms
            ),
        }
    }
}
