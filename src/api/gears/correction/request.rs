//! What a correction of machine settings is asked for.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    include::{CorrectionInclude, CorrectionIncludeName},
    iteration_nodes,
    sensitivity::{self, Corrected, SensitivityBody},
    target::{AimBody, AimName, TargetBody, Wanted},
};
use crate::{
    api::{
        faults::Faults,
        fits::{
            reader::fields,
            spec::request::{FitFieldsMembers, RegularizationBody, ScalingName},
        },
        gears::requirements::RequirementsBody,
        json::{
            error::ReadError,
            location::escape,
            members::{Members, of_request},
            present::present,
            request::request,
        },
        measurand::axes::AxesBody,
    },
    jobs::Measurand,
};
use flankfit_engine::{
    estimation::{Nodes, spec::Scaling},
    gear::{
        Gear,
        correction::{
            CorrectionSpec, DEFAULT_KEEP_WITHIN, DEFAULT_RESPONSE_UNCERTAINTY, Damping, Flank, ResponseErrors, Setting,
            SettingsUsed,
        },
        evaluation::flank_surface::{FigureTerms, figure_limits},
    },
};

request! {
    /// A correction of machine settings, by the deviations (µm) that the nodes of an iteration
    /// hold.
    #[schema(as = CorrectionRequest)]
    pub struct CorrectionRequestBody as CorrectionMembers {
        required sensitivity: SensitivityBody,
        /// By the names of the settings; a setting that is not named may go anywhere.
        optional limits: BTreeMap<String, LimitsBody>,
        /// Whether the mean of the deviations is measured, as thickness is. Traces and flanks that
        /// were laid into the nominal one have no such datum: then what all nodes have in common is
        /// left aside, and settings that change all nodes nearly alike come back `undetermined`.
        /// Default true with `matrix`, false with `machine` and wherever traces have a zero each.
        optional absolute: bool,
        /// For each node the number of the trace that it belongs to, where profiles and helices
        /// were measured that have a zero each: what the nodes of a trace have in common is left
        /// aside then, and a setting that changes the nodes of every trace nearly alike comes back
        /// `undetermined`. By default what `trace_lengths` of the iteration's heights say, as after
        /// an import. Without `absolute`.
        optional trace: Vec<u32>,
        /// For each node. By default the weights of the iteration.
        optional weight: Vec<f64>,
        /// What is wanted: `design`, `limits`, `nominal`, or `{"deviation_um": […]}`, a deviation
        /// for each node. By default the job's design where it has one, else the middle of its
        /// limits where crownings or the twist have some, else the unmodified flank. A `matrix`
        /// does not say where on a flank the nodes lie: it aims at 0 or at what is given.
        optional target: TargetBody,
        /// Which settings are changed. Default `needed` where a figure of the flank has limits,
        /// else `all`.
        optional settings_used: SettingsUsedName,
        /// With `needed`: the share of its limits, about the middle, within which a figure needs no
        /// correction. Default 0.7.
        #[schema(minimum = 0, maximum = 1)]
        optional keep_within: f64,
        /// Standard deviation of a measured deviation. By default from the residuals.
        #[schema(exclusive_minimum = 0)]
        optional noise_sigma_um: f64,
        /// Standard uncertainty of an entry of the sensitivity matrix, relative to it. Default
        /// 0.02.
        #[schema(minimum = 0, maximum = 1)]
        optional response_uncertainty: f64,
        /// How errors of the sensitivity matrix hang together. Default `independent`.
        optional response_errors: ResponseErrorsName,
        /// By default spectral with the λ* that `noise_sigma_um` and `response_uncertainty` speak
        /// for, so that repeated corrections converge.
        optional regularization: RegularizationBody,
        optional scaling: ScalingName,
        /// Limit of the settings' norm that bias bounds hold for, in columns of unit length. By
        /// default the norm that `limits` allow where every setting has both, else what the
        /// deviations speak for (√n τ, see `result.bias`); with `regularization` that of the
        /// least-squares estimate.
        #[schema(exclusive_minimum = 0)]
        optional coefficient_norm_limit: f64,
        /// What is answered only when asked for.
        optional include: Vec<CorrectionIncludeName>,
    }
}

/// How a setting may be changed, in its unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = SettingLimits)]
pub struct LimitsBody {
    /// Least change, usually below 0.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Greatest change.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// Step of the control: the change is a multiple of it, and predicted figures are those of the
    /// rounded changes.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub increment: Option<f64>,
    /// Whether the setting stays as it is; without the others then.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub fixed: Option<bool>,
}

/// Which of the settings that may be changed are changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = SettingsUsed)]
pub enum SettingsUsedName {
    /// From plain least squares of all settings on, they are left alone one after the other, the
    /// cheapest first, while every figure that all of them bring or leave within its limits stays
    /// there (with the guard band of a conformity), and where leaving one alone adds less than 9σ²
    /// to the weighted sum of squares, or every figure that it moves stays within `keep_within` of
    /// its limits. Those that remain are solved again.
    Needed,
    /// All of them.
    All,
}

/// How errors of a sensitivity matrix hang together, for the standard errors of the changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ResponseErrors)]
pub enum ResponseErrorsName {
    /// Each entry has one of its own: they average out over many nodes.
    Independent,
    /// Each setting has one, as a scale that is wrong: its whole column is too large or too small
    /// by the same share.
    PerSetting,
}

impl From<ResponseErrorsName> for ResponseErrors {
    fn from(name: ResponseErrorsName) -> Self {
        match name {
            ResponseErrorsName::Independent => ResponseErrors::Independent,
            ResponseErrorsName::PerSetting => ResponseErrors::PerSetting,
        }
    }
}

/// A request that has been read.
pub struct Read {
    /// The contract's name of the sensitivity.
    pub method: &'static str,
    pub spec: CorrectionSpec,
    /// What is aimed at; its deviations are those of the spec.
    pub aim: AimName,
    /// Nobody said what to aim at.
    pub aim_assumed: bool,
    /// The flank that the nodes lie on, where the sensitivity is that of a machine.
    pub flank: Option<Flank>,
    pub include: CorrectionInclude,
}

/// What a request is read with beside the nodes.
#[derive(Clone, Copy)]
pub enum Job<'a> {
    /// What the job requires now.
    Requires(Option<&'a RequirementsBody>),
    /// What it required when the correction was kept.
    Kept(&'a Kept),
}

/// What became of the requirements of the job in a kept correction.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    pub target: Option<Vec<f64>>,
    /// Direction and reference lengths of the figures.
    pub terms: FigureTerms,
    /// Names of the settings that were left alone.
    pub left: Vec<String>,
}

/// Reads a request for the nodes of an iteration, which are of `measurand`, and the gear of its
/// job.
pub fn read(
    text: &[u8],
    nodes: &Nodes,
    measurand: &Measurand,
    gear: Option<&Gear>,
    job: Job<'_>,
) -> Result<Result<Read, Faults>, ReadError> {
    let mut faults = Faults::default();
    let members: CorrectionMembers<'_> = of_request(text, &mut faults)?;
    let asked = Asked::read(&members, &mut faults);
    let (regularized, scaled) = (members.regularization.is_given(), members.scaling.is_given());
    let fit = FitFieldsMembers {
        regularization: members.regularization,
        scaling: members.scaling,
        coefficient_norm_limit: members.coefficient_norm_limit,
        ..FitFieldsMembers::at("")
    };
    let fit = fields::read(&fit, None, &mut faults);
    let include = CorrectionInclude::of(&members.include.read(&mut faults).unwrap_or_default());
    let limits = members.limits.read(&mut faults);
    let absolute = members.absolute.read(&mut faults);
    let trace = members.trace.read(&mut faults);
    let weight = members.weight.read(&mut faults);
    let noise_sigma = members.noise_sigma_um.read(&mut faults);
    let response = members.response_uncertainty.read(&mut faults);
    let axes = AxesBody::of(measurand).map_err(|why| faults.push("/sensitivity", why)).unwrap_or_default();
    let factor = axes.deviation_factor();
    let factor = factor.map_err(|why| faults.push("/sensitivity", why)).unwrap_or(1.0);
    let errors = members.response_errors.read(&mut faults);
    let sensitivity = members.sensitivity.required_text(&mut faults).and_then(|slice| {
        let iteration = Corrected { nodes, measurand, axes: &axes, gear };
        sensitivity::read(slice, iteration, &mut faults).or_else(|| none(&mut faults))
    });
    let (Some(fit), Some(mut sensitivity)) = (fit, sensitivity) else { return Ok(Err(faults)) };
    limit(&mut sensitivity.settings, &limits.unwrap_or_default(), &mut faults);
    let traces = match trace {
        Some(trace) => Some(trace.into_iter().map(|trace| trace as usize).collect()),
        None => axes.traces(),
    };
    let requirements = match job {
        Job::Requires(requirements) => requirements,
        Job::Kept(_) => None,
    };
    if let Some(flank) = &mut sensitivity.flank {
        flank.traces.clone_from(&traces);
        flank.terms = match job {
            Job::Kept(kept) => kept.terms,
            Job::Requires(_) => requirements.map(RequirementsBody::figure_terms).unwrap_or_default(),
        };
    }
    let deviation = iteration_nodes::deviations(nodes, factor);
    let weight = weight.or_else(|| iteration_nodes::weights(nodes));
    // lists of another length are refused where the correction is checked
    let fits = weight.as_ref().is_none_or(|weight| weight.len() == deviation.len())
        && traces.as_ref().is_none_or(|traces: &Vec<usize>| traces.len() == deviation.len());
    let flank = sensitivity.flank.as_ref().filter(|_| fits);
    let limits = flank.zip(requirements.and_then(|requirements| requirements.tolerance_limits));
    let limits = limits.map(|(flank, limits)| {
        let ranges = [flank.ranges.profile, flank.ranges.helix];
        figure_limits(&flank.gear, flank.terms, ranges, &limits.of(flank.side))
    });
    let limits = limits.unwrap_or_default();
    let aim_assumed = matches!(asked.target, Some(None));
    let aim = match job {
        Job::Kept(kept) => Some((kept.again(&mut sensitivity.settings), SettingsUsed::All)),
        Job::Requires(_) => {
            let wanted = Wanted { flank, deviation: &deviation, weight: weight.as_deref(), limits, requirements };
            asked.aim(&wanted, &mut faults)
        }
    };
    let Some((aim, used)) = aim else { return Ok(Err(faults)) };
    let damping = if regularized { Damping::Given(fit.regularization) } else { Damping::default() };
    let spec = CorrectionSpec {
        weight,
        target: aim.deviation_um,
        damping,
        scaling: if scaled { fit.scaling } else { Scaling::UnitLength },
        noise_sigma,
        coefficient_norm_limit: fit.coefficient_norm_limit,
        response_uncertainty: response.unwrap_or(DEFAULT_RESPONSE_UNCERTAINTY),
        absolute: absolute.unwrap_or(sensitivity.flank.is_none() && traces.is_none()),
        traces,
        response_errors: errors.map_or_else(ResponseErrors::default, Into::into),
        used,
        include: include.fit,
        ..CorrectionSpec::new(deviation, sensitivity.matrix, sensitivity.settings)
    };
    let target_fits = spec.target.as_ref().is_none_or(|target| target.len() == spec.deviation.len());
    let figures = flank.filter(|_| target_fits && matches!(job, Job::Requires(_)));
    let figures = figures.map(|flank| flank.held(&spec, limits)).unwrap_or_default();
    let spec = CorrectionSpec { figures, ..spec };
    Ok(faults.into_result(Read {
        method: sensitivity.name,
        spec,
        aim: aim.kind,
        aim_assumed,
        flank: sensitivity.flank,
        include,
    }))
}

/// What of a request the requirements of the job have a say in.
struct Asked {
    /// `None` where it is refused.
    target: Option<Option<TargetBody>>,
    used: Option<SettingsUsedName>,
    keep_within: Option<f64>,
}

impl Asked {
    fn read(members: &CorrectionMembers<'_>, faults: &mut Faults) -> Self {
        let target = members.target.optional(faults);
        let used = members.settings_used.read(faults);
        let keep_within = members.keep_within.read(faults);
        if used == Some(SettingsUsedName::All) && keep_within.is_some() {
            faults.push("/keep_within", "it belongs to `settings_used`: \"needed\"; leave it out");
        }
        Asked { target, used, keep_within }
    }

    /// The target, and which settings are changed.
    fn aim(self, wanted: &Wanted<'_>, faults: &mut Faults) -> Option<(AimBody, SettingsUsed)> {
        let limited = wanted.limits.named().iter().any(|(_, limits)| limits.is_some());
        let used = match self.used {
            Some(SettingsUsedName::All) => SettingsUsed::All,
            None if !limited => SettingsUsed::All,
            Some(SettingsUsedName::Needed) | None => {
                SettingsUsed::Needed { keep_within: self.keep_within.unwrap_or(DEFAULT_KEEP_WITHIN) }
            }
        };
        Some((wanted.target(self.target?, faults)?, used))
    }
}

impl Kept {
    /// The target that was aimed at; the settings that were left alone are fixed.
    fn again(&self, settings: &mut [Setting]) -> AimBody {
        for setting in settings.iter_mut().filter(|setting| self.left.contains(&setting.name)) {
            *setting = Setting { fixed: true, ..Setting::free(setting.name.clone(), setting.unit.clone()) };
        }
        AimBody { kind: AimName::Given, deviation_um: self.target.clone() }
    }
}

/// Gives the settings their limits.
fn limit(settings: &mut [Setting], limits: &BTreeMap<String, LimitsBody>, faults: &mut Faults) {
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

/// What has no value has a fault.
fn none<T>(faults: &mut Faults) -> Option<T> {
    if faults.is_empty() {
        faults.push("/sensitivity", "it cannot be read");
    }
    None
}
