//! What a correction of machine settings is asked for.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    include::{CorrectionInclude, CorrectionIncludeName},
    iteration_nodes::{self, Flank},
    sensitivity::{self, Corrected, SensitivityBody},
};
use crate::{
    api::{
        faults::Faults,
        fits::{
            reader::fields,
            spec::request::{FitFieldsMembers, RegularizationBody, ScalingName},
        },
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
        correction::{CorrectionSpec, DEFAULT_RESPONSE_UNCERTAINTY, Damping, ResponseErrors},
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
        /// The deviations that are wanted. Default 0.
        optional target_um: Vec<f64>,
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
    /// The flank that the nodes lie on, where the sensitivity is that of a machine.
    pub flank: Option<Flank>,
    pub include: CorrectionInclude,
}

/// Reads a request for the nodes of an iteration, which are of `measurand`, and the gear of its
/// job.
pub fn read(
    text: &[u8],
    nodes: &Nodes,
    measurand: &Measurand,
    gear: Option<&Gear>,
) -> Result<Result<Read, Faults>, ReadError> {
    let mut faults = Faults::default();
    let members: CorrectionMembers<'_> = of_request(text, &mut faults)?;
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
    let target = members.target_um.read(&mut faults);
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
    for (name, limits) in limits.iter().flatten() {
        let LimitsBody { min, max, increment, fixed } = *limits;
        match sensitivity.settings.iter_mut().find(|setting| setting.name == *name) {
            Some(setting) => {
                (setting.min, setting.max, setting.increment) = (min, max, increment);
                setting.fixed = fixed.unwrap_or(false);
            }
            None => {
                let names: Vec<String> =
                    sensitivity.settings.iter().map(|setting| format!("`{}`", setting.name)).collect();
                let detail = format!("there is no such setting; there are {}", names.join(", "));
                faults.push(format!("/limits/{}", escape(name)), detail);
            }
        }
    }
    let traces = match trace {
        Some(trace) => Some(trace.into_iter().map(|trace| trace as usize).collect()),
        None => axes.traces(),
    };
    if let Some(flank) = &mut sensitivity.flank {
        flank.traces.clone_from(&traces);
    }
    let damping = if regularized { Damping::Given(fit.regularization) } else { Damping::default() };
    let spec = CorrectionSpec {
        weight: weight.or_else(|| iteration_nodes::weights(nodes)),
        target,
        damping,
        scaling: if scaled { fit.scaling } else { Scaling::UnitLength },
        noise_sigma,
        coefficient_norm_limit: fit.coefficient_norm_limit,
        response_uncertainty: response.unwrap_or(DEFAULT_RESPONSE_UNCERTAINTY),
        absolute: absolute.unwrap_or(sensitivity.flank.is_none() && traces.is_none()),
        traces,
        response_errors: errors.map_or_else(ResponseErrors::default, Into::into),
        include: include.fit,
        ..CorrectionSpec::new(iteration_nodes::deviations(nodes, factor), sensitivity.matrix, sensitivity.settings)
    };
    Ok(faults.into_result(Read { method: sensitivity.name, spec, flank: sensitivity.flank, include }))
}

/// What has no value has a fault.
fn none<T>(faults: &mut Faults) -> Option<T> {
    if faults.is_empty() {
        faults.push("/sensitivity", "it cannot be read");
    }
    None
}
