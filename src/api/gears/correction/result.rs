//! Changes of machine settings, and whether the machine answered as predicted.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    blocks::{Blocks, Subject},
    figures::{SidedFiguresBody, outside_limits, removes_crowning},
    include::CorrectionInclude,
    other_flank::{self, OtherFlankBody},
    request::{self, Job, Read, SettingsUsedName},
    same_nodes::Measured,
    sensitivity::Level,
    target::{AimBody, AimName},
    teeth::{self, SidedTeethBody},
};
use crate::api::{
    built::Built,
    faults::{Faults, is_within, pointer_of},
    fits::{answer::FitResultBody, canonical},
    gears::{
        deviations::registration::IndistinguishableBody,
        evaluation::request::{DirectionName, ReferenceName},
        figure_limits,
        requirements::RequirementsBody,
    },
    json::{gather::gathered, location::escape, writer::whole},
    measurand::side::SideName,
    problem::{Problem, ProblemCode},
    warning::WarningBody,
};
use flankfit_engine::{
    estimation::FitError,
    gear::correction::{Change, Correction, Flank, LeftAlone, Limit, Predicted, SettingsUsed, Solution, Trust},
    numerics::check,
};

/// What is to be changed, and what is expected of it.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Correction)]
pub struct CorrectionBody<'a> {
    /// UUIDv7 of the record that it is kept as; in the answer to the request that made it.
    pub id: Option<Uuid>,
    /// Numbers of the iterations whose nodes it is made for; left out where there is no iteration.
    pub iterations: Option<Vec<u32>>,
    /// The flanks that they are of, the left one first; left out where no iteration says it.
    pub flanks: Option<Vec<SideName>>,
    /// Of a gear: the teeth of each flank, and how much they differ.
    pub teeth: Option<SidedTeethBody>,
    /// What was aimed at.
    pub target: AimBody,
    /// Whether the mean of the deviations was taken for measured; where it was not, what all nodes
    /// (of a trace) have in common is left aside.
    pub absolute: bool,
    /// Which settings were changed.
    pub settings_used: SettingsUsedName,
    /// The share of their limits within which figures need no correction; left out with `all`.
    pub keep_within: Option<f64>,
    /// In the order of the request, or of the machine.
    pub settings: Vec<SettingChangeBody>,
    /// Figures of the flank before, as wanted and as predicted, against the limits that the job
    /// requires; left out with a `matrix` and where the nodes do not tell them.
    pub figures: Option<SidedFiguresBody>,
    /// What the changes do to the other flank; of the correction of an iteration by a machine.
    pub other_flank: Option<OtherFlankBody>,
    /// Direction in which the figures count. Present with a machine, like the next three.
    pub direction: Option<DirectionName>,
    /// Length that slopes refer to.
    pub reference: Option<ReferenceName>,
    /// Length that profile slopes are over.
    pub profile_reference_length_mm: Option<f64>,
    /// Length that helix slopes are over.
    pub helix_reference_length_mm: Option<f64>,
    /// Settings whose effects nearly cancel on these nodes.
    pub indistinguishable: Vec<IndistinguishableBody>,
    pub predicted: PredictedBody,
    /// How λ* came about; left out where the request says how to regularise.
    pub trust: Option<TrustBody>,
    /// The fit of all settings that may be changed, without limits, as `POST /v1/fits` answers it:
    /// the sensitivity matrix is the measurement matrix, the wanted change of each deviation the
    /// height. Present when `result` was included.
    pub result: Option<FitResultBody<'a>>,
    /// The fit of the settings that stay free, where some are at their limits. Present when
    /// `result` was included.
    pub limited_result: Option<FitResultBody<'a>>,
    /// What to know about the answer; empty where there is nothing to say.
    pub warnings: Vec<WarningBody>,
}

/// What becomes of a setting.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SettingChange)]
pub struct SettingChangeBody {
    /// The setting.
    pub name: String,
    /// Unit of the change, such as `µm` or `′` (minutes of arc).
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// To be added to the setting.
    pub change: f64,
    /// What it would be without increments; left out without one. Errors are of this.
    pub unrounded: Option<f64>,
    /// What is asked for without limits; left out where it is the same.
    pub unlimited: Option<f64>,
    /// Of noise and errors of the sensitivity (`response_uncertainty`) together: how far the change
    /// lies from what this regularised correction is on average, once in three times further. What
    /// regularisation takes away on average is not in it but in `bias_bound`: what is wanted lies
    /// within the sum of both two times in three or more, where its norm is within that of the
    /// bound (docs/explanation/mathematics.md). Left out at a limit and without degrees of freedom.
    pub std_error: Option<f64>,
    /// The part of errors of the sensitivity in it.
    pub response_std_error: Option<f64>,
    /// Sharp bound on what regularisation takes away, if the changes that are wanted have at most
    /// the norm `result.bias.coefficient_norm_limit` (its source stands beside it); where that is
    /// `limits`, no more than the way from the change to its farther limit. Left out at a limit.
    pub bias_bound: Option<f64>,
    /// Whether it stands at a limit.
    pub limited: bool,
    /// Whether the change was rounded to a multiple of the increment.
    pub rounded: bool,
    /// Whether it was to stay as it is.
    pub fixed: bool,
    /// Why it is left alone; left out where it is changed, fixed or undetermined.
    pub left: Option<LeftName>,
    /// Whether the deviations say nothing about the setting (see `absolute`), or nothing that other
    /// settings do not explain as well, as of a twist where one profile and one helix cross. It
    /// stays as it is, or goes no further than its limits ask for.
    pub undetermined: bool,
}

/// Why a setting is left alone that might be changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = LeftAlone)]
pub enum LeftName {
    /// Its change is not distinguishable from none: less than three standard errors.
    NotDistinguishable,
    /// Every figure that it moves lies well within its limits, with a guard band.
    WithinLimits,
}

/// The flank after the correction, if the machine answers as the sensitivity says. Of the nodes
/// that take part.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = PredictedFlank)]
pub struct PredictedBody {
    /// Root mean square of the predicted deviations.
    pub rms_um: f64,
    /// Largest amount of the predicted deviations.
    pub max_um: f64,
    /// Root mean square of the deviations before the correction.
    pub rms_before_um: f64,
    /// Largest amount of the deviations before the correction.
    pub max_before_um: f64,
    /// Of every node in the order posted; `null` where undefined. Present when `nodes` was
    /// included.
    pub deviation_um: Option<Vec<Option<f64>>>,
    /// Standard uncertainty of the change at each node that the uncertainty of the sensitivity
    /// leaves. Present when `nodes` was included.
    pub uncertainty_um: Option<Vec<Option<f64>>>,
}

/// How far the sensitivity is trusted, in columns of unit length.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SensitivityTrust)]
pub struct TrustBody {
    /// The smallest eigenvalue that is trusted.
    pub lambda_star: f64,
    /// The share that the uncertainty of the sensitivity has in it.
    pub from_response: f64,
    /// The share of the noise; left out where it is not known.
    pub from_noise: Option<f64>,
    /// How many directions have smaller eigenvalues.
    pub damped: usize,
    /// The most that an error of the response is multiplied with.
    pub gain: f64,
}

/// Computes a correction: the whole of it, and what of it is asked for. Processor work.
pub fn build(text: &[u8], subject: &Subject<'_>) -> Result<(Built, CorrectionInclude), Problem> {
    let Subject { level, ref measured, gear, requirements, .. } = *subject;
    let read = request::read(text, measured, level, gear, Job::Requires(requirements))?;
    let read = read.map_err(Problem::invalid)?;
    let Read { spec, aim, aim_assumed, nodes, include } = read;
    refuse_implausible(measured, &nodes)?;
    let names: Vec<String> = spec.settings.iter().map(|setting| setting.name.clone()).collect();
    let correction = Correction::new(spec).map_err(|found| Problem::invalid(placed(&found, &names)))?;
    let solution = correction.solve().map_err(refused)?;
    let spec = correction.asked();
    let flank = nodes.blocks.first().and_then(|block| block.flank.as_ref());
    let mut warnings = Vec::new();
    if aim == AimName::Nominal && aim_assumed {
        warnings.extend(removes_crowning(&spec.figures));
    }
    warnings.extend(outside_limits(&spec.figures, &solution));
    let flanks = nodes.blocks.iter().filter_map(|block| block.flank.as_ref()).zip(std::iter::repeat(requirements));
    let uncovered = |(flank, required): (&Flank, Option<&RequirementsBody>)| {
        required.map(|required| figure_limits::of(&request::spanned(flank), required).1).unwrap_or_default()
    };
    warnings.extend(flanks.flat_map(uncovered).map(|found| WarningBody::from(&found)));
    let about = About { other_flank: other_flank::of(text, subject, &nodes, &solution)?, ..About::new(level, &nodes) };
    if level == Level::Gear {
        warnings.extend(teeth::warnings(&nodes));
    }
    let asked = Asked { correction: &correction, aim, flank, about, warnings };
    let result = write(&solution, asked, &canonical::request_sha256(text))?;
    Ok((Built { method: nodes.method.to_owned(), result }, include))
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

/// The engine's faults by places in the request, where limits stand under the names of settings.
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

/// What was asked for, and what is to be said beside the solution.
pub struct Asked<'a> {
    pub correction: &'a Correction,
    pub aim: AimName,
    /// Of the direction and the reference lengths.
    pub flank: Option<&'a Flank>,
    pub about: About,
    pub warnings: Vec<WarningBody>,
}

/// What was measured of it.
#[derive(Default)]
pub struct About {
    pub iterations: Vec<u32>,
    pub flanks: Vec<SideName>,
    pub teeth: Option<SidedTeethBody>,
    pub other_flank: Option<OtherFlankBody>,
}

impl About {
    fn new(level: Level, nodes: &Blocks) -> Self {
        let mut iterations: Vec<u32> = nodes.blocks.iter().flat_map(|block| block.numbers.iter().copied()).collect();
        iterations.sort_unstable();
        About {
            iterations,
            flanks: nodes.blocks.iter().filter_map(|block| block.side).collect(),
            teeth: (level == Level::Gear).then(|| SidedTeethBody::new(nodes)),
            other_flank: None,
        }
    }
}

/// Returns the whole of it as JSON, `nodes` and `result` too; `digest` is that of the request.
pub fn write(solution: &Solution, asked: Asked<'_>, digest: &str) -> Result<Vec<u8>, Problem> {
    let Asked { correction, aim, flank, about, warnings: more } = asked;
    let About { iterations, flanks, teeth, other_flank } = about;
    let spec = correction.asked();
    let Solution { settings, indistinguishable, predicted, trust, fit, limited_fit, warnings, leverage: _, noise: _ } =
        solution;
    let change: Vec<f64> = settings.iter().map(|setting| setting.change).collect();
    let (settings_used, keep_within) = match spec.used {
        SettingsUsed::All => (SettingsUsedName::All, None),
        SettingsUsed::Needed { keep_within } => (SettingsUsedName::Needed, Some(keep_within)),
    };
    let indistinguishable = indistinguishable.iter().map(|group| IndistinguishableBody {
        names: group.names.clone(),
        condition_index: group.condition_index,
        sentence: group.sentence.clone(),
    });
    let [profile_reference_length_mm, helix_reference_length_mm] =
        flank.map(|flank| flank.references().map(Some)).unwrap_or_default();
    let body = CorrectionBody {
        id: None,
        iterations: (!iterations.is_empty()).then_some(iterations),
        flanks: (!flanks.is_empty()).then_some(flanks),
        teeth,
        target: AimBody { kind: aim, deviation_um: spec.target.clone() },
        absolute: spec.absolute,
        settings_used,
        keep_within,
        settings: settings.iter().map(SettingChangeBody::from).collect(),
        figures: (!spec.figures.is_empty()).then(|| SidedFiguresBody::new(&spec.figures, &change)),
        other_flank,
        direction: flank.map(|flank| flank.terms.direction),
        reference: flank.map(|flank| flank.terms.reference),
        profile_reference_length_mm,
        helix_reference_length_mm,
        indistinguishable: indistinguishable.collect(),
        predicted: predicted.into(),
        trust: trust.map(TrustBody::from),
        result: Some(FitResultBody::new(fit, None, digest.to_owned())),
        limited_result: limited_fit.as_ref().map(|fit| FitResultBody::new(fit, None, digest.to_owned())),
        warnings: warnings.iter().map(WarningBody::from).chain(more).collect(),
    };
    whole(&body).map(gathered).map_err(Problem::not_finite)
}

impl From<&Change> for SettingChangeBody {
    fn from(change: &Change) -> Self {
        SettingChangeBody {
            name: change.name.clone(),
            unit: change.unit.clone(),
            change: change.change,
            unrounded: change.unrounded,
            unlimited: Some(change.unlimited)
                .filter(|unlimited| *unlimited != change.unrounded.unwrap_or(change.change)),
            std_error: change.std_error,
            response_std_error: change.response_std_error,
            bias_bound: change.bias_bound,
            limited: matches!(change.limited, Some(Limit::Min | Limit::Max)),
            rounded: change.unrounded.is_some(),
            fixed: change.fixed,
            left: change.left.map(|left| match left {
                LeftAlone::NotDistinguishable => LeftName::NotDistinguishable,
                LeftAlone::WithinLimits => LeftName::WithinLimits,
            }),
            undetermined: change.undetermined,
        }
    }
}

impl From<&Predicted> for PredictedBody {
    fn from(predicted: &Predicted) -> Self {
        let defined = |list: &[f64]| list.iter().map(|x| Some(*x).filter(|x| x.is_finite())).collect();
        PredictedBody {
            rms_um: predicted.rms,
            max_um: predicted.max,
            rms_before_um: predicted.rms_before,
            max_before_um: predicted.max_before,
            deviation_um: Some(defined(&predicted.deviation)),
            uncertainty_um: Some(defined(&predicted.uncertainty)),
        }
    }
}

impl From<Trust> for TrustBody {
    fn from(trust: Trust) -> Self {
        let Trust { lambda_star, from_response, from_noise, damped, gain } = trust;
        TrustBody { lambda_star, from_response, from_noise, damped, gain }
    }
}
