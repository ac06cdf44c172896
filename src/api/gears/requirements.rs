//! What the flanks of a job must be like.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    evaluation::{
        band::{self, KBandBody},
        conformity::ToleranceLimitsBody,
        request::EvaluationSettingsBody,
    },
    notice::NoticeBody,
};
use crate::api::faults::Faults;
use flankfit_engine::gear::{Gear, Side};

/// What the flanks of a job must be like. Evaluations of its iterations are held against it unless
/// they bring limits or bands of their own; what was answered keeps what it was held against.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Requirements, example = json!({
    "tolerance_limits": {"class": 6, "profile_crowning_um": [2, 8], "left": {"helix_slope_um": [-6, 2]}},
    "k_bands": [{"kind": "helix", "upper": [[0, 2], [15, 2]], "lower": [[0, -10], [7.5, -3], [15, -10]]}]
}))]
pub struct RequirementsBody {
    /// Class and limits of figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance_limits: Option<ToleranceLimitsBody>,
    /// Bands that traces must lie in; at most 20.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false, max_items = 20)]
    pub k_bands: Vec<KBandBody>,
}

impl RequirementsBody {
    /// Those that are stored with a job; were they damaged, the job would still be shown.
    pub fn stored(document: &str) -> Option<Self> {
        serde_json::from_str(document).ok()
    }

    /// Takes the place of what an evaluation says nothing of its own about. What does not go with
    /// the gear is left aside, and said so.
    pub fn fill(self, evaluation: &mut EvaluationSettingsBody, gear: &Gear, helix: bool) -> Vec<NoticeBody> {
        let mut notices = Vec::new();
        let mut aside = |what: String| notices.push(NoticeBody::new("requirement_left_aside", &what));
        if let (None, Some(mut limits)) = (evaluation.tolerance_limits, self.tolerance_limits) {
            let refused = [Side::Left, Side::Right].map(|side| limits.of(side).class_refused(gear, helix));
            if let Some(why) = refused.into_iter().flatten().next() {
                limits.class = None;
                aside(format!("the class that the job requires: {why}"));
            }
            evaluation.tolerance_limits = Some(limits);
        }
        if evaluation.k_bands.is_none() && !self.k_bands.is_empty() {
            let (bands, others): (Vec<_>, Vec<_>) =
                self.k_bands.into_iter().partition(|band| band.on(gear, "").is_ok());
            if !others.is_empty() {
                let count = others.len();
                aside(format!("{count} of the job's bands: they have places where the gear has no involute"));
            }
            evaluation.k_bands = Some(bands);
        }
        notices
    }

    /// Refuses what is no requirement on any gear.
    pub fn check(&self, at: &str, faults: &mut Faults) {
        if let Some(limits) = &self.tolerance_limits {
            limits.check(&format!("{at}/tolerance_limits"), faults);
        }
        band::check_all(&self.k_bands, &format!("{at}/k_bands"), faults);
    }
}
