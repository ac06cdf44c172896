//! Request of a correction of machine settings.

use std::{collections::BTreeMap, ops::Range};

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    blocks::{Block, Blocks, How},
    chosen::{OfTeeth, held_by_fits},
    include::{CorrectionInclude, CorrectionIncludeName},
    result::CorrectionResultBody,
    same_nodes::Measured,
    sensitivity::{Level, SensitivityBody},
    target::{AimBody, AimName, TargetBody, Wanted},
};
use crate::api::{
    faults::Faults,
    gears::{
        evaluation::request::figure_terms,
        figure_limits::{self, Spanned},
        requirements::RequirementsBody,
    },
    json::location::escape,
};
use flankfit_engine::{
    estimation::spec::{Regularization, Scaling},
    gear::{
        Gear,
        correction::{
            CorrectionSpec, DEFAULT_KEEP_WITHIN, DEFAULT_RESPONSE_UNCERTAINTY, Damping, Flank, HeldFigure,
            ResponseErrors, Scatter, Setting, SettingsUsed,
        },
        evaluation::flank_surface::{FigureTerms, FlankFigures},
        tooth,
    },
};

/// A correction of machine settings, from the deviations (µm) at the nodes of an iteration, or for
/// a gear from the means of each flank over its teeth. Lists with an entry for each node of a gear
/// begin with the left flank.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = CorrectionRequest)]
pub struct CorrectionRequestBody {
    pub sensitivity: SensitivityBody,
    /// Limits by the names of the settings; a setting that is not named has no limits.
    pub limits: Option<BTreeMap<String, LimitsBody>>,
    /// True if the mean of the deviations is measured, as with a thickness. Traces and flanks that
    /// were aligned with the nominal flank have no such datum: the common part of all nodes is then
    /// ignored, and settings that change all nodes nearly equally are `undetermined`. Default true
    /// with `matrix`, false with `machine` and if each trace has its own zero.
    pub absolute: Option<bool>,
    /// Number of the trace of each node, for profiles and helices with a zero each: the common part
    /// of the nodes of a trace is then ignored, and a setting that changes the nodes of every trace
    /// nearly equally is `undetermined`. By default the `trace_lengths` of the iteration's heights,
    /// as after an import. Not with `absolute`.
    pub trace: Option<Vec<usize>>,
    /// Weight of each node. By default the weights of the iteration.
    pub weight: Option<Vec<f64>>,
    /// Target: `design`, `limits`, `nominal`, or `{"deviation_um": […]}`, a deviation for each
    /// node. By default the job's design if it has one, else the middle of its limits if crownings
    /// or the twist have limits, else the unmodified flank. With a `matrix` the places of the nodes
    /// are not known: the target is 0 or the given deviations.
    pub target: Option<TargetBody>,
    /// Settings that are changed. Default `needed` where a figure of the flank has limits, else
    /// `all`.
    pub settings_used: Option<SettingsUsed>,
    /// With `needed`: the share of its limits, about the middle, within which a figure needs no
    /// correction. Default 0.7.
    #[schema(minimum = 0, maximum = 1)]
    pub keep_within: Option<f64>,
    /// Standard deviation of a measured deviation. By default that of the residuals of the flank's
    /// surface of second order, or else of the settings.
    #[schema(exclusive_minimum = 0)]
    pub noise_sigma_um: Option<f64>,
    /// Standard uncertainty of an entry of the sensitivity matrix, relative to it. Default 0.02.
    #[schema(minimum = 0, maximum = 1)]
    pub response_uncertainty: Option<f64>,
    /// Correlation of the errors of the sensitivity matrix. Default `independent`.
    pub response_errors: Option<ResponseErrors>,
    /// By default spectral with the λ* that follows from `noise_sigma_um` and
    /// `response_uncertainty`, so that repeated corrections converge.
    pub regularization: Option<Regularization>,
    pub scaling: Option<Scaling>,
    /// Limit of the settings' norm that bias bounds hold for, in columns of unit length. By default
    /// the norm that `limits` allow if every setting has both, else an estimate from the deviations
    /// (√n τ, see `result.bias`); with `regularization` that of the least-squares estimate.
    #[schema(exclusive_minimum = 0)]
    pub coefficient_norm_limit: Option<f64>,
    /// For the correction of a gear: the teeth whose mean is corrected, as far as they were
    /// measured. By default all that were measured since the last correction.
    #[schema(min_items = 1)]
    pub teeth: Option<Vec<String>>,
    /// Additional parts of the response.
    pub include: Option<Vec<CorrectionIncludeName>>,
}

/// Limits of the change of a setting, in its unit.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = SettingLimits)]
pub struct LimitsBody {
    /// Least change, usually below 0.
    pub min: Option<f64>,
    /// Greatest change.
    pub max: Option<f64>,
    /// Step of the control: the change is a multiple of it, and predicted figures are those of the
    /// rounded changes.
    #[schema(exclusive_minimum = 0)]
    pub increment: Option<f64>,
    /// True if the setting stays as it is; not with the other fields.
    pub fixed: Option<bool>,
}

/// A request that has been read.
pub struct Read {
    pub spec: CorrectionSpec,
    /// Kind of the target; its deviations are those of the spec.
    pub aim: AimName,
    /// The nodes that the correction is made for.
    pub nodes: Blocks,
}

/// Requirements that a request is read with.
#[derive(Clone, Copy)]
pub enum Job<'a> {
    /// Those of the job now.
    Requires(Option<&'a RequirementsBody>),
    /// Those that a stored correction was made with.
    Kept(&'a CorrectionResultBody),
}

impl<'a> Job<'a> {
    fn requirements(self) -> Option<&'a RequirementsBody> {
        match self {
            Job::Requires(requirements) => requirements,
            Job::Kept(_) => None,
        }
    }

    /// Returns direction and reference lengths of the figures.
    fn terms(self) -> FigureTerms {
        match self {
            Job::Kept(kept) => figure_terms(kept.direction, kept.reference),
            Job::Requires(requirements) => requirements.map(RequirementsBody::figure_terms).unwrap_or_default(),
        }
    }
}

impl CorrectionRequestBody {
    pub fn include(&self) -> CorrectionInclude {
        CorrectionInclude::of(self.include.as_deref().unwrap_or_default())
    }

    /// Checks the request for the iterations `measured`, and the gear of their job.
    pub fn read(
        &self,
        measured: &[&Measured],
        level: Level,
        gear: Option<&Gear>,
        job: Job<'_>,
    ) -> Result<Read, Faults> {
        let mut faults = Faults::default();
        if self.settings_used == Some(SettingsUsed::All) && self.keep_within.is_some() {
            faults.push("/keep_within", "it belongs to `settings_used`: \"needed\"; omit it");
        }
        let chosen = chosen(self.teeth.as_deref(), measured, level, &mut faults);
        let how =
            How { sensitivity: &self.sensitivity, level, gear, absolute: self.absolute, trace: self.trace.as_deref() };
        let nodes = chosen.and_then(|chosen| Blocks::read(&chosen, how, &mut faults));
        let Some(mut nodes) = nodes else { return Err(faults) };
        limit(&mut nodes.settings, self.limits.iter().flatten(), &mut faults);
        nodes.blocks.iter_mut().filter_map(|block| block.flank.as_mut()).for_each(|flank| flank.terms = job.terms());
        if self.weight.is_some() {
            nodes.blocks.iter_mut().for_each(|block| block.chosen.clear());
        }
        let (deviation, weight) = (nodes.deviation(), self.weight.clone().or_else(|| nodes.weight()));
        // lists of another length are refused where the correction is checked
        let fits = weight.as_ref().is_none_or(|weight| weight.len() == deviation.len())
            && nodes.traces.as_ref().is_none_or(|traces| traces.len() == deviation.len());
        let parts = parts(&nodes.blocks, weight.as_deref(), fits, job);
        let aim = match job {
            Job::Kept(kept) => Some((again(kept, &mut nodes.settings), SettingsUsed::All)),
            Job::Requires(requirements) => self.aim(&parts, requirements, &mut faults),
        };
        let Some((aim, used)) = aim else { return Err(faults) };
        let of_means = level == Level::Gear;
        // of a measured deviation; a mean has less
        let share = if of_means { (nodes.most_teeth() as f64).sqrt() } else { 1.0 };
        let noise_sigma = self.noise_sigma_um.map(|sigma| sigma / share).or_else(|| noise_of(&parts));
        let mut spec = CorrectionSpec {
            weight: weight.clone(),
            target: aim.deviation_um,
            damping: self.regularization.clone().map_or_else(Damping::default, Damping::Given),
            scaling: self.scaling.unwrap_or(Scaling::UnitLength),
            noise_sigma,
            coefficient_norm_limit: self.coefficient_norm_limit,
            response_uncertainty: self.response_uncertainty.unwrap_or(DEFAULT_RESPONSE_UNCERTAINTY),
            absolute: nodes.absolute,
            traces: nodes.traces.clone(),
            flank_zeros: nodes.flank_zeros,
            scatter: if of_means { nodes.scatter(&[]) } else { Scatter::default() },
            response_errors: self.response_errors.unwrap_or_default(),
            used,
            keep_within: self.keep_within.unwrap_or(DEFAULT_KEEP_WITHIN),
            include: self.include().fit,
            ..CorrectionSpec::new(deviation, nodes.matrix.clone(), nodes.settings.clone())
        };
        let target_fits = spec.target.as_ref().is_none_or(|target| target.len() == spec.deviation.len());
        if target_fits && matches!(job, Job::Requires(_)) {
            spec.figures = parts.iter().flat_map(|part| part.held(&spec)).collect();
        }
        for j in (0..spec.settings.len()).filter(|&j| nodes.settings[j].twists) {
            spec.settings[j].hidden = parts.iter().all(|part| !part.shows_twist(&spec, j));
        }
        drop(parts);
        faults.into_result(Read { spec, aim: aim.kind, nodes })
    }

    /// Returns the target of all flanks, and which settings are changed.
    fn aim(
        &self,
        parts: &[Part<'_>],
        requirements: Option<&RequirementsBody>,
        faults: &mut Faults,
    ) -> Option<(AimBody, SettingsUsed)> {
        let limited = parts.iter().any(|part| part.limits.named().iter().any(|(_, limits)| limits.is_some()));
        let used = self.settings_used.unwrap_or(if limited { SettingsUsed::Needed } else { SettingsUsed::All });
        let aim = |part: &Part<'_>, faults: &mut Faults| {
            let Part { flank, deviation, limits, .. } = *part;
            let weight = part.weight.as_deref();
            Wanted { flank, deviation, weight, limits, requirements }.target(self.target.clone(), faults)
        };
        let aim = match parts {
            [one] => aim(one, faults)?,
            // given deviations are of all flanks
            [one, ..] if matches!(self.target, Some(TargetBody::Given(_))) => aim(one, faults)?,
            all => stacked(all, all.iter().map(|part| aim(part, faults)).collect::<Option<_>>()?),
        };
        Some((aim, used))
    }
}

/// Returns the iterations that are requested by their teeth.
fn chosen<'a>(
    teeth: Option<&[String]>,
    measured: &[&'a Measured],
    level: Level,
    faults: &mut Faults,
) -> Option<Vec<&'a Measured>> {
    let Some(names) = teeth else { return Some(measured.to_vec()) };
    if level != Level::Gear {
        faults.push("/teeth", "it belongs to the correction of a gear; this correction is for the iteration's tooth");
        return None;
    }
    let canonical = |name: &str| tooth::canonical(name).unwrap_or_else(|_| name.to_owned());
    let of = |one: &Measured| one.measurand.tooth.as_deref().map(canonical);
    let names: Vec<String> = names.iter().map(|name| canonical(name)).collect();
    let before = faults.count();
    for (k, name) in
        names.iter().enumerate().filter(|(_, name)| !measured.iter().any(|one| of(one).as_ref() == Some(name)))
    {
        let mut there: Vec<String> = measured.iter().filter_map(|one| of(one)).collect();
        there.sort_unstable();
        there.dedup();
        let there = if there.is_empty() { "none with a name".to_owned() } else { format!("`{}`", there.join("`, `")) };
        let detail = format!("tooth {name} was not measured since the last correction; measured were {there}");
        faults.push(format!("/teeth/{k}"), detail);
    }
    if names.is_empty() {
        faults.push("/teeth", "it names no tooth; omit it for all measured teeth");
    }
    let wanted = |one: &&&Measured| of(one).is_some_and(|name| names.contains(&name));
    (faults.count() == before).then(|| measured.iter().filter(wanted).copied().collect())
}

/// A flank of the correction with its limits, for its targets and figures.
pub struct Part<'a> {
    rows: Range<usize>,
    flank: Option<&'a Flank>,
    deviation: &'a [f64],
    weight: Option<Vec<f64>>,
    limits: FlankFigures<[f64; 2]>,
    /// Figures of the chosen fits.
    fitted: OfTeeth,
}

/// The flanks; without their places where lists do not fit the nodes.
fn parts<'a>(blocks: &'a [Block], weight: Option<&[f64]>, fits: bool, job: Job<'_>) -> Vec<Part<'a>> {
    let mut before = 0;
    let each = blocks.iter().map(|block| {
        let rows = before..before + block.mean.deviation.len();
        before = rows.end;
        let flank = block.flank.as_ref().filter(|_| fits);
        Part {
            flank,
            deviation: &block.mean.deviation,
            weight: weight.and_then(|weight| weight.get(rows.clone())).map(<[f64]>::to_vec),
            limits: flank.map(|flank| limits_of(flank, job.requirements())).unwrap_or_default(),
            fitted: block.fitted(),
            rows,
        }
    });
    each.collect()
}

/// Returns the noise that second-order surfaces of the flanks leave, if every flank has one.
fn noise_of(parts: &[Part<'_>]) -> Option<f64> {
    let each = parts.iter().map(|part| part.flank?.noise(part.deviation, part.weight.as_deref()));
    let squares: Vec<f64> = each.map(|sigma| sigma.map(|sigma| sigma * sigma)).collect::<Option<_>>()?;
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// Returns the limits of a job for the figures of a flank.
pub fn limits_of(flank: &Flank, requirements: Option<&RequirementsBody>) -> FlankFigures<[f64; 2]> {
    requirements.map(|requirements| figure_limits::of(&spanned(flank), requirements).0).unwrap_or_default()
}

/// Returns the ranges of the nodes of a flank.
pub fn spanned(flank: &Flank) -> Spanned<'_> {
    let [a, b] = flank.ranges.profile;
    Spanned {
        gear: &flank.gear,
        side: flank.side,
        terms: flank.terms,
        ranges: [[a.min(b), a.max(b)], flank.ranges.helix],
        helix_reference: flank.references()[1],
    }
}

impl Part<'_> {
    /// Whether the nodes of the flank show the twist that setting j of `spec` makes on it.
    fn shows_twist(&self, spec: &CorrectionSpec, j: usize) -> bool {
        let acts = self.rows.clone().any(|k| spec.sensitivity.get(k * spec.settings.len() + j) != Some(&0.0));
        acts && self.flank.is_none_or(|flank| flank.shows_twist(self.deviation, self.weight.as_deref()))
    }

    /// The figures of the flank as the settings of `spec` move them.
    fn held(&self, spec: &CorrectionSpec) -> Vec<HeldFigure> {
        let Some(flank) = self.flank else { return Vec::new() };
        let (rows, columns) = (self.rows.clone(), spec.settings.len());
        let Some(sensitivity) = spec.sensitivity.get(rows.start * columns..rows.end * columns) else {
            return Vec::new();
        };
        let scatter = Scatter {
            columns: spec.scatter.columns.iter().map(|column| column[rows.clone()].to_vec()).collect(),
            ..spec.scatter.clone()
        };
        let own = CorrectionSpec {
            weight: self.weight.clone(),
            target: spec.target.as_ref().map(|target| target[rows].to_vec()),
            absolute: spec.absolute,
            scatter,
            ..CorrectionSpec::new(self.deviation.to_vec(), sensitivity.to_vec(), spec.settings.clone())
        };
        held_by_fits(flank.held(&own, self.limits), &self.fitted)
    }
}

/// The targets of flanks one behind the other.
fn stacked(parts: &[Part<'_>], aims: Vec<AimBody>) -> AimBody {
    let kind = aims.iter().map(|aim| aim.kind).find(|kind| *kind != AimName::Nominal).unwrap_or(AimName::Nominal);
    if kind == AimName::Nominal {
        return AimBody::NOMINAL;
    }
    let own = |(aim, part): (AimBody, &Part<'_>)| aim.deviation_um.unwrap_or_else(|| vec![0.0; part.rows.len()]);
    AimBody { kind, deviation_um: Some(aims.into_iter().zip(parts).flat_map(own).collect()) }
}

/// Returns the target of a stored correction; the settings that it left alone are fixed.
fn again(kept: &CorrectionResultBody, settings: &mut [Setting]) -> AimBody {
    let left = |name: &str| kept.settings.iter().any(|setting| setting.name == name && setting.unchanged.is_some());
    for setting in settings.iter_mut().filter(|setting| left(&setting.name)) {
        *setting = Setting { fixed: true, ..Setting::free(setting.name.clone(), setting.unit.clone()) };
    }
    AimBody { kind: AimName::Given, deviation_um: kept.target.deviation_um.clone() }
}

/// Gives the settings their limits.
fn limit<'a>(
    settings: &mut [Setting],
    limits: impl Iterator<Item = (&'a String, &'a LimitsBody)>,
    faults: &mut Faults,
) {
    for (name, limits) in limits {
        let LimitsBody { min, max, increment, fixed } = *limits;
        match settings.iter_mut().find(|setting| setting.name == *name) {
            Some(setting) => {
                (setting.min, setting.max, setting.increment) = (min, max, increment);
                setting.fixed = fixed.unwrap_or(false);
            }
            None => {
                let names: Vec<String> = settings.iter().map(|setting| format!("`{}`", setting.name)).collect();
                let detail = format!("there is no such setting; there are {}", names.join(", "));
                faults.push(format!("/limits/{}", escape(name)), detail);
            }
        }
    }
}
