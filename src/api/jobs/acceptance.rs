//! Objections to accepting a flank.

use serde::Deserialize;

use crate::{
    api::{
        faults::Faults,
        gears::{
            fit_figures::{FitFiguresBody, missing},
            plausibility::IMPLAUSIBLE_UNIT,
            requirements::RequirementsBody,
        },
        measurand::axes::AxesBody,
    },
    jobs::{Job, Measurand},
};
use flankfit_engine::estimation::inference::ConformityVerdict;

/// Code of the warning of a fit with suspected gross errors.
const OUTLIERS_SUSPECTED: &str = "outliers_suspected";

/// Stored JSON documents of a flank that is about to be accepted.
#[derive(Clone, Copy, Debug, Default)]
pub struct Kept<'a> {
    /// Figures and result of the chosen fit.
    pub figures: Option<&'a str>,
    pub result: &'a str,
    /// The latest stored evaluation and pitches.
    pub evaluation: Option<&'a str>,
    pub pitch: Option<&'a str>,
}

/// The part of an answer that is examined.
#[derive(Deserialize)]
struct Warned {
    #[serde(default)]
    warnings: Vec<Coded>,
}

#[derive(Deserialize)]
struct Coded {
    code: String,
}

/// Whether a job has limits that figures of fits are compared with.
pub fn has_limits(job: &Job) -> bool {
    RequirementsBody::of(job).is_some_and(|required| required.tolerance_limits.is_some())
}

/// Refuses to accept a flank of a job with limits if its figures cannot be computed.
pub fn refuse_unknown(job: &Job, of: &Measurand) -> Result<(), Faults> {
    let axes = AxesBody::of(of).map_err(|why| Faults::one("/decision", why))?;
    let missing = missing(&axes, of.flank, job.gear.is_some());
    if missing.is_empty() {
        return Ok(());
    }
    let mut faults = Faults::default();
    for (_, how) in missing {
        faults.push("/decision", format!("the job has limits, but there are no figures to compare with them: {how}"));
    }
    Err(faults)
}

/// Returns the objections because of which accepting needs a reason; empty if there are none.
/// CPU-bound.
pub fn objections(kept: Kept<'_>) -> Result<Vec<String>, serde_json::Error> {
    let mut all = Vec::new();
    if let Some(figures) = kept.figures {
        let figures: FitFiguresBody = serde_json::from_str(figures)?;
        for (name, figure) in figures.figures.named() {
            let Some(conformity) = figure.and_then(|one| Some((one.value, one.conformity?))) else {
                continue;
            };
            let (value, conformity) = conformity;
            if conformity.verdict == ConformityVerdict::DoesNotConform {
                let [low, high] = conformity.limits;
                let outside = (low - value).max(value - high);
                all.push(format!("{name}_um is outside its limits {low:.2} … {high:.2} µm by {outside:.2} µm"));
            }
        }
        if figures.warnings.iter().any(|warning| warning.code == IMPLAUSIBLE_UNIT) {
            all.push("its units are implausible".to_owned());
        }
    }
    let result: Warned = serde_json::from_str(kept.result)?;
    if result.warnings.iter().any(|warning| warning.code == OUTLIERS_SUSPECTED) {
        all.push("some of its nodes are suspected of gross errors".to_owned());
    }
    let told = serde_json::to_string(&ConformityVerdict::DoesNotConform)?;
    for (what, result) in [("evaluation", kept.evaluation), ("pitches", kept.pitch)] {
        if result.is_some_and(|result| result.contains(&told)) {
            all.push(format!("a figure of its {what} does not conform"));
        }
    }
    Ok(all)
}
