//! Effect of the correction of one flank on the other one.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    blocks::{Block, Blocks, How, Subject},
    chosen::{held_by_fits, of_teeth},
    figures::{SidedBody, TargetFiguresBody},
    request::{CorrectionRequestBody, limits_of},
    sensitivity::Level,
    target::Wanted,
};
use crate::api::faults::Faults;
use flankfit_engine::gear::{
    Side,
    correction::{CorrectionSpec, HeldFigure, Solution},
};

/// The flank that was not corrected, as the common settings change it.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = OtherFlank)]
pub struct OtherFlankBody {
    pub flank: Side,
    /// Its newest iteration; absent if it was not measured.
    pub iteration: Option<u32>,
    /// Its figures before and predicted, with the limits of the job; the target is that of the job.
    pub figures: Option<TargetFiguresBody>,
    /// Reason why there are no figures.
    pub not_predicted: Option<String>,
}

/// Returns the effect of the solution for one flank on the other one; `None` of a matrix, which
/// does not say it, and of a gear.
pub(super) fn of(
    request: &CorrectionRequestBody,
    subject: &Subject<'_>,
    nodes: &Blocks,
    solution: &Solution,
) -> Option<OtherFlankBody> {
    let flank = nodes.blocks.first().and_then(|block| block.flank.as_ref());
    let (Some(flank), Level::Iteration) = (flank, subject.level) else { return None };
    let other = match flank.side {
        Side::Left => Side::Right,
        Side::Right => Side::Left,
    };
    let body = OtherFlankBody { flank: other, iteration: None, figures: None, not_predicted: None };
    let Some(measured) = subject.other else {
        let why = "it was not measured; settings for both flanks change it too".to_owned();
        return Some(OtherFlankBody { not_predicted: Some(why), ..body });
    };
    let mut faults = Faults::default();
    let held = held(request, subject, solution, &mut faults);
    let figures = held.map(|(figures, change)| SidedBody::of(&figures, &change));
    let figures = figures.and_then(|figures| match other {
        Side::Left => figures.left,
        Side::Right => figures.right,
    });
    let why = match (&figures, measured.implausible(), faults.list().first()) {
        (Some(_), None, _) => None,
        (_, Some(why), _) => Some(why.to_owned()),
        (None, None, Some(fault)) => Some(fault.detail.clone()),
        (None, None, None) => Some("its nodes do not determine slopes and crownings".to_owned()),
    };
    let figures = figures.filter(|_| why.is_none());
    Some(OtherFlankBody { iteration: Some(measured.number), figures, not_predicted: why, ..body })
}

/// Figures as settings move them, and the changes of these settings.
type Moved = (Vec<HeldFigure>, Vec<f64>);

/// Returns the figures of the other flank and what changes them.
fn held(
    request: &CorrectionRequestBody,
    subject: &Subject<'_>,
    solution: &Solution,
    faults: &mut Faults,
) -> Option<Moved> {
    let sensitivity = &request.sensitivity;
    let how = How { sensitivity, level: Level::OtherFlank, gear: subject.gear, absolute: None, trace: None };
    let nodes = Blocks::read(&[subject.other?], how, faults)?;
    let Block { flank, mean, chosen, .. } = nodes.blocks.into_iter().next()?;
    let mut flank = flank?;
    flank.terms = subject.requirements.map(|required| required.figure_terms()).unwrap_or_default();
    let limits = limits_of(&flank, subject.requirements);
    let wanted = Wanted {
        flank: Some(&flank),
        deviation: &mean.deviation,
        weight: mean.weight.as_deref(),
        limits,
        requirements: subject.requirements,
    };
    let aim = wanted.target(None, faults)?;
    let change = |name: &str| {
        let same = solution.settings.iter().find(|setting| setting.name == name);
        same.map_or(0.0, |setting| setting.change)
    };
    let change = nodes.settings.iter().map(|setting| change(&setting.name)).collect();
    let spec = CorrectionSpec {
        weight: mean.weight,
        target: aim.deviation_um,
        absolute: false,
        ..CorrectionSpec::new(mean.deviation, nodes.matrix, nodes.settings)
    };
    Some((held_by_fits(flank.held(&spec, limits), &of_teeth(&flank, &chosen)), change))
}
