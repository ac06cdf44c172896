//! Changes of machine settings, and their expected effect.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    blocks::{Blocks, Subject},
    figures::{SidedBody, TargetFiguresBody, outside_limits, removes_crowning},
    include::CorrectionInclude,
    other_flank::{self, OtherFlankBody},
    request::{self, CorrectionRequestBody, Job, Read},
    same_nodes::Measured,
    sensitivity::Level,
    target::{AimBody, AimName},
    teeth::{self, TeethBody},
};
use crate::{
    api::{
        built::Built,
        faults::{Faults, is_within, pointer_of},
        fits::{answer::FitResultBody, canonical},
        gears::figure_limits,
        json::{
            location::escape,
            raw::Raw,
            value::read_json,
            writer::{NotFinite, whole},
        },
        problem::{Problem, ProblemCode},
        warning::WarningBody,
    },
    jobs::Record,
};
use flankfit_engine::{
    estimation::{FitError, FitResult},
    gear::{
        Side,
        correction::{Change, Correction, Flank, Indistinguishable, Predicted, SettingsUsed, Solution, Trust},
        evaluation::flank_surface::Reference,
        trace::Direction,
    },
    numerics::check,
};

/// Changes of machine settings, and their expected effect.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CorrectionResult)]
pub struct CorrectionResultBody {
    /// Numbers of the iterations whose nodes it is made for; absent without an iteration.
    pub iterations: Option<Vec<u32>>,
    /// Their flanks, the left one first; absent if no iteration has one.
    pub flanks: Option<Vec<Side>>,
    /// For a gear: the teeth of each flank, and how much they differ.
    pub teeth: Option<SidedBody<TeethBody>>,
    /// The target.
    pub target: AimBody,
    /// True if the mean of the deviations counts as measured; otherwise the common part of all
    /// nodes (of a trace) is ignored.
    pub absolute: bool,
    /// Settings that were changed.
    pub settings_used: SettingsUsed,
    /// The share of their limits within which figures need no correction; absent with `all`.
    pub keep_within: Option<f64>,
    /// In the order of the request, or of the machine.
    pub settings: Vec<Change>,
    /// Figures of the flank before the correction, target and prediction, with the limits of the
    /// job; absent with a `matrix` and if the nodes do not determine them.
    pub figures: Option<SidedBody<TargetFiguresBody>>,
    /// Effect of the changes on the other flank; for the correction of an iteration by a machine.
    pub other_flank: Option<OtherFlankBody>,
    /// Direction of the figures. Present with a machine, like the next three fields.
    pub direction: Option<Direction>,
    /// Length that slopes refer to.
    pub reference: Option<Reference>,
    /// Length that profile slopes refer to.
    pub profile_reference_length_mm: Option<f64>,
    /// Length that helix slopes refer to.
    pub helix_reference_length_mm: Option<f64>,
    /// Settings whose effects nearly cancel on these nodes.
    pub indistinguishable: Vec<Indistinguishable>,
    pub predicted: Predicted,
    /// Origin of λ*; absent if the request has `regularization`.
    pub trust: Option<Trust>,
    /// The fit of all settings that may be changed, without limits, in the form of `POST /v1/fits`:
    /// the sensitivity matrix is the measurement matrix, the wanted change of each deviation the
    /// height. Present when `result` was included.
    #[schema(value_type = Option<FitResultBody<'static>>)]
    pub result: Option<Raw<FitResultBody<'static>>>,
    /// The fit of the settings that remain free, if some are at their limits. Present when `result`
    /// was included.
    #[schema(value_type = Option<FitResultBody<'static>>)]
    pub limited_result: Option<Raw<FitResultBody<'static>>>,
    /// Warnings of the correction and its fits, these with `at`.
    pub warnings: Vec<WarningBody>,
}

/// Computes a correction: what is stored of it, and the requested parts of its result. Processor
/// work.
pub fn build(text: &[u8], subject: &Subject<'_>) -> Result<(Built, CorrectionInclude, Vec<u8>), Problem> {
    let Subject { level, ref measured, gear, requirements, .. } = *subject;
    let request: CorrectionRequestBody = read_json(text)?;
    let read = request.read(measured, level, gear, Job::Requires(requirements)).map_err(Problem::invalid)?;
    let Read { spec, aim, nodes } = read;
    refuse_implausible(measured, &nodes)?;
    let names: Vec<String> = spec.settings.iter().map(|setting| setting.name.clone()).collect();
    let correction = Correction::new(spec).map_err(|found| Problem::invalid(placed(&found, &names)))?;
    let solution = correction.solve().map_err(refused)?;
    let figures = &correction.spec().figures;
    let mut warnings: Vec<WarningBody> = Vec::new();
    if aim == AimName::Nominal && request.target.is_none() {
        warnings.extend(removes_crowning(figures));
    }
    warnings.extend(outside_limits(figures, &solution));
    for flank in nodes.blocks.iter().filter_map(|block| block.flank.as_ref()) {
        let uncovered = requirements.map(|required| figure_limits::of(&request::spanned(flank), required).1);
        warnings.extend(uncovered.iter().flatten().map(WarningBody::from));
    }
    if level == Level::Gear {
        warnings.extend(teeth::warnings(&nodes));
    }
    let flank = nodes.blocks.first().and_then(|block| block.flank.as_ref());
    let mut iterations: Vec<u32> = nodes.blocks.iter().flat_map(|block| block.numbers.iter().copied()).collect();
    iterations.sort_unstable();
    let flanks: Vec<Side> = nodes.blocks.iter().filter_map(|block| block.side).collect();
    let body = CorrectionResultBody {
        iterations: Some(iterations),
        flanks: (!flanks.is_empty()).then_some(flanks),
        teeth: (level == Level::Gear).then(|| teeth::of(&nodes)),
        other_flank: other_flank::of(&request, subject, &nodes, &solution),
        ..CorrectionResultBody::new(&correction, &solution, (aim, flank), warnings, &canonical::request_sha256(text))
            .map_err(Problem::not_finite)?
    };
    let built = Built { method: nodes.method.to_owned(), result: body.text()? };
    let include = request.include();
    Ok((built, include, include.of_result(body).text()?))
}

/// Refuses iterations whose units are implausible.
fn refuse_implausible(measured: &[&Measured], nodes: &Blocks) -> Result<(), Problem> {
    let used = |one: &&&Measured| nodes.blocks.iter().any(|block| block.numbers.contains(&one.number));
    for one in measured.iter().filter(used) {
        if let Some(why) = one.implausible() {
            let detail = format!("Iteration {}: {why}.", one.number);
            return Err(Problem::new(ProblemCode::ImplausibleUnit, detail));
        }
    }
    Ok(())
}

/// Converts the engine's errors to places in the request, where limits are under the names of
/// settings.
fn placed(found: &check::Faults, names: &[String]) -> Faults {
    let of_setting = |path: &str| {
        let (setting, limit) = path.strip_prefix("limits[")?.split_once("].")?;
        let name = names.get(setting.parse::<usize>().ok()?)?;
        Some(format!("/limits/{}/{limit}", escape(name)))
    };
    Faults::placed(found, |path| of_setting(path).unwrap_or_else(|| pointer_of(path)))
}

/// A fit that was refused, by places in the request.
fn refused(error: FitError) -> Problem {
    let place = |path: &str| match path {
        // the deviations of an iteration have been fitted before
        _ if is_within(path, &["nodes.y"]) => "/target".to_owned(),
        _ if is_within(path, &["nodes.weight"]) => "/weight".to_owned(),
        _ if is_within(path, &["nodes", "model"]) => "/sensitivity".to_owned(),
        _ => pointer_of(path),
    };
    Problem::of_fit(error, place)
}

impl CorrectionResultBody {
    /// Creates the whole answer without what was measured; `warnings` follow those of the solution,
    /// and `digest` is that of the request.
    pub fn new(
        correction: &Correction,
        solution: &Solution,
        (aim, flank): (AimName, Option<&Flank>),
        warnings: Vec<WarningBody>,
        digest: &str,
    ) -> Result<Self, NotFinite> {
        let spec = correction.spec();
        let change: Vec<f64> = solution.settings.iter().map(|setting| setting.change).collect();
        let [profile_reference_length_mm, helix_reference_length_mm] =
            flank.map(|flank| flank.references().map(Some)).unwrap_or_default();
        let mut warnings: Vec<WarningBody> = solution.warnings.iter().map(WarningBody::from).chain(warnings).collect();
        let mut raw = |fit: &FitResult, at: &str| {
            let body = FitResultBody::new(fit, None, digest.to_owned());
            warnings.extend(body.warnings.iter().map(|one| WarningBody { at: Some(at.to_owned()), ..one.clone() }));
            body.text().map(|text| Raw::from(String::from_utf8_lossy(&text)))
        };
        Ok(CorrectionResultBody {
            iterations: None,
            flanks: None,
            teeth: None,
            target: AimBody { kind: aim, deviation_um: spec.target.clone() },
            absolute: spec.absolute,
            settings_used: spec.used,
            keep_within: Some(spec.keep_within).filter(|_| spec.used == SettingsUsed::Needed),
            settings: solution.settings.clone(),
            figures: (!spec.figures.is_empty()).then(|| SidedBody::of(&spec.figures, &change)),
            other_flank: None,
            direction: flank.map(|flank| flank.terms.direction),
            reference: flank.map(|flank| flank.terms.reference),
            profile_reference_length_mm,
            helix_reference_length_mm,
            indistinguishable: solution.indistinguishable.clone(),
            predicted: solution.predicted.clone(),
            trust: solution.trust,
            result: Some(raw(&solution.fit, "/result")?),
            limited_result: solution.limited_fit.as_ref().map(|fit| raw(fit, "/limited_result")).transpose()?,
            warnings,
        })
    }

    /// Reads the correction of a record.
    pub fn of(record: &Record) -> Result<Self, Problem> {
        serde_json::from_str(&record.draft.result).map_err(Problem::internal)
    }

    /// Returns the JSON text.
    pub fn text(&self) -> Result<Vec<u8>, Problem> {
        whole(self).map_err(Problem::not_finite)
    }
}
