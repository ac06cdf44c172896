//! Requirements of the flanks of a job.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    evaluation::{
        band::{self, KBandBody},
        request::{EvaluationSettingsBody, figure_terms},
    },
    flank_design::DesignBody,
};
use crate::{
    api::{faults::Faults, warning::WarningBody},
    jobs::Job,
};
use flankfit_engine::gear::{
    Gear, Side,
    evaluation::{
        Against, SidedLimits,
        flank_surface::{FigureTerms, Reference},
        pitch_limits::PitchLimits,
    },
    tolerance::Tolerances,
    trace::Direction,
};

/// Requirements of the flanks of a job. Evaluations of its iterations are compared with them unless
/// they have limits or bands of their own. Later changes do not affect stored results.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Requirements, example = json!({
    "tolerance_limits": {"class": 6, "profile_crowning_um": [2, 8], "left": {"helix_slope_um": [-6, 2]}},
    "pitch_limits": {"runout_um": [0, 15]},
    "design": {"profile_crowning_um": 5, "helix_crowning_um": 4},
    "k_bands": [{"kind": "helix", "upper": [[0, 2], [15, 2]], "lower": [[0, -10], [7.5, -3], [15, -10]]}]
}))]
pub struct RequirementsBody {
    /// Class and limits of figures.
    pub tolerance_limits: Option<SidedLimits>,
    /// Limits of pitch deviations and run-out. Without a class, that of `tolerance_limits` applies.
    pub pitch_limits: Option<PitchLimits>,
    /// Target of corrections. Limits apply to the flank, not to its distance from the design.
    pub design: Option<DesignBody>,
    /// Direction of the figures of flanks (fits, surfaces of topographies, corrections) and of
    /// their limits. Default `normal`. Evaluations of traces are transverse, as in ISO 1328-1.
    pub direction: Option<Direction>,
    /// Length that slopes of flanks refer to. Default `reference_length`.
    pub reference: Option<Reference>,
    /// Bands that traces must lie in; at most 20, with at most 4,000 points in all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false, max_items = 20)]
    pub k_bands: Vec<KBandBody>,
}

impl RequirementsBody {
    /// Returns the requirements of a job.
    pub fn of(job: &Job) -> Option<Self> {
        job.requirements.as_deref().and_then(Self::stored)
    }

    /// Those that are stored with a job; were they damaged, the job would still be shown.
    pub fn stored(document: &str) -> Option<Self> {
        serde_json::from_str(document).ok()
    }

    /// Returns the direction and the reference lengths of the figures of flanks.
    pub fn figure_terms(&self) -> FigureTerms {
        figure_terms(self.direction, self.reference)
    }

    /// Takes the place of what an evaluation says nothing of its own about. What does not go with
    /// the gear is left aside, and said so.
    pub fn fill(&self, evaluation: &mut EvaluationSettingsBody, gear: &Gear, helix: bool) -> Vec<WarningBody> {
        let mut notices = Vec::new();
        if let (None, Some(mut limits)) = (evaluation.tolerance_limits, self.tolerance_limits) {
            let refused = [Side::Left, Side::Right].map(|side| limits.of(side).class_refused(gear, helix));
            if let Some(why) = refused.into_iter().flatten().next() {
                limits.class = None;
                notices.push(class_left_aside(&why));
            }
            if evaluation.against == Some(Against::Design) && limits != limits.about_design() {
                limits = limits.about_design();
                notices.push(aside(
                    "the job's limits of slopes, crownings and twist: they apply to the flank, not to its distance \
                      from the design",
                ));
            }
            evaluation.tolerance_limits = Some(limits);
        }
        if evaluation.k_bands.is_none() && !self.k_bands.is_empty() {
            let (bands, others): (Vec<_>, Vec<_>) =
                self.k_bands.iter().cloned().partition(|band| band.on(gear, "").is_ok());
            if !others.is_empty() {
                let count = others.len();
                notices.push(aside(&format!(
                    "{count} of the job's bands: they have places where the gear has no involute"
                )));
            }
            evaluation.k_bands = Some(bands);
        }
        notices
    }

    /// Likewise the limits of pitches.
    pub fn fill_pitch(&self, asked: &mut Option<PitchLimits>, gear: &Gear) -> Option<WarningBody> {
        if asked.is_some() {
            return None;
        }
        let mut limits = self.pitch_limits.unwrap_or_default();
        limits.class = limits.class.or(self.tolerance_limits.and_then(|limits| limits.class));
        let refused = limits.class_refused(&Tolerances::new(gear));
        if refused.is_some() {
            limits.class = None;
        }
        *asked = Some(limits).filter(|limits| *limits != PitchLimits::default());
        refused.as_deref().map(class_left_aside)
    }

    /// Refuses requirements that are impossible for any gear, and a design that is impossible for
    /// `gear`.
    pub fn check(&self, gear: Option<&Gear>, at: &str, faults: &mut Faults) {
        if let Some(limits) = &self.tolerance_limits {
            faults.append(Faults::of_engine(&format!("{at}/tolerance_limits"), &limits.check()));
        }
        if let Some(limits) = &self.pitch_limits {
            faults.append(Faults::of_engine(&format!("{at}/pitch_limits"), &limits.check()));
        }
        if let Some(design) = &self.design {
            design.check(gear, &format!("{at}/design"), faults);
        }
        band::check_all(&self.k_bands, &format!("{at}/k_bands"), faults);
        let without = self.k_bands.iter().position(KBandBody::is_about_design);
        if let Some(k) = without.filter(|_| self.design.is_none()) {
            faults.push(format!("{at}/k_bands/{k}/against"), "there is no `design`: add one");
        }
    }
}

/// Returns the warning about a required class that limits nothing on the gear.
pub fn class_left_aside(why: &str) -> WarningBody {
    aside(&format!("the class that the job requires: {why}"))
}

/// Returns the warning about a requirement that is left aside.
pub fn aside(what: &str) -> WarningBody {
    WarningBody::new("requirement_left_aside", what)
}
