//! What a correction of one flank does to the other one.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    blocks::{Block, Blocks, How, Subject},
    chosen::{held_by_fits, of_teeth},
    figures::{SidedFiguresBody, TargetFiguresBody},
    request::{CorrectionMembers, limits_of},
    sensitivity::Level,
    target::Wanted,
};
use crate::api::{
    faults::Faults,
    json::{error::ReadError, members::of_request},
    measurand::side::SideName,
};
use flankfit_engine::gear::{
    Side,
    correction::{CorrectionSpec, HeldFigure, Solution},
};

/// The flank beside the corrected one, as the settings that both have in common change it.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = OtherFlank)]
pub struct OtherFlankBody {
    pub flank: SideName,
    /// Its newest iteration; left out where it was not measured.
    pub iteration: Option<u32>,
    /// Its figures before and as predicted, with the limits that the job requires; the target is
    /// the job's.
    pub figures: Option<TargetFiguresBody>,
    /// Why there are no figures.
    pub not_predicted: Option<String>,
}

/// What the solution for one flank does to the other one; `None` of a matrix, which does not say
/// it, and of a gear.
pub(super) fn of(
    text: &[u8],
    subject: &Subject<'_>,
    nodes: &Blocks,
    solution: &Solution,
) -> Result<Option<OtherFlankBody>, ReadError> {
    let flank = nodes.blocks.first().and_then(|block| block.flank.as_ref());
    let (Some(flank), Level::Iteration) = (flank, subject.level) else { return Ok(None) };
    let other = match flank.side {
        Side::Left => Side::Right,
        Side::Right => Side::Left,
    };
    let body = OtherFlankBody { flank: other, iteration: None, figures: None, not_predicted: None };
    let Some(measured) = subject.other else {
        let why = "it was not measured; settings of both flanks change it as well".to_owned();
        return Ok(Some(OtherFlankBody { not_predicted: Some(why), ..body }));
    };
    let mut faults = Faults::default();
    let held = held(text, subject, solution, &mut faults)?;
    let figures = held.map(|(figures, change)| SidedFiguresBody::new(&figures, &change));
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
    Ok(Some(OtherFlankBody { iteration: Some(measured.number), figures, not_predicted: why, ..body }))
}

/// Figures as settings move them, and the changes of these settings.
type Moved = (Vec<HeldFigure>, Vec<f64>);

/// The figures of the other flank and what changes them.
fn held(
    text: &[u8],
    subject: &Subject<'_>,
    solution: &Solution,
    faults: &mut Faults,
) -> Result<Option<Moved>, ReadError> {
    // faults of the request would have been found before
    let members: CorrectionMembers<'_> = of_request(text, &mut Faults::default())?;
    let (Some(slice), Some(measured)) = (members.sensitivity.required_text(faults), subject.other) else {
        return Ok(None);
    };
    let how = How { slice, level: Level::OtherFlank, gear: subject.gear, absolute: None, trace: None };
    let Some(nodes) = Blocks::read(&[measured], how, faults) else { return Ok(None) };
    let Some(block) = nodes.blocks.into_iter().next() else { return Ok(None) };
    let Block { flank: Some(mut flank), mean, chosen, .. } = block else { return Ok(None) };
    flank.terms = subject.requirements.map(|required| required.figure_terms()).unwrap_or_default();
    let limits = limits_of(&flank, subject.requirements);
    let wanted = Wanted {
        flank: Some(&flank),
        deviation: &mean.deviation,
        weight: mean.weight.as_deref(),
        limits,
        requirements: subject.requirements,
    };
    let Some(aim) = wanted.target(None, faults) else { return Ok(None) };
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
    Ok(Some((held_by_fits(flank.held(&spec, limits), &of_teeth(&flank, &chosen)), change)))
}
