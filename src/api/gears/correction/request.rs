//! What a correction of machine settings is asked for.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    include::{CorrectionInclude, CorrectionIncludeName},
    iteration_nodes::{self, Coordinates, Flank},
};
use crate::{
    api::{
        faults::Faults,
        fits::{
            reader::fields,
            spec::request::{RegularizationBody, ScalingName},
        },
        json::{
            error::ReadError,
            fields::{Fields, read_rows},
            part::read_part,
            place::escape,
            present::present,
        },
        measurand::{axes::AxesBody, profile_axis::ProfileAxisName, side::SideName},
    },
    jobs::{Measurand, side_name},
};
use flankfit_engine::{
    estimation::{Nodes, spec::Scaling},
    fault::{Fault, words::entries},
    gear::{
        Gear, Side,
        correction::{
            CorrectionSpec, DEFAULT_RESPONSE_UNCERTAINTY, Damping, ResponseErrors, Setting,
            fault::{MachineFaults, MachineField},
            machine::{Machine, Ranges},
        },
    },
};

// Declared for the document; `read` reads it.
/// A correction of machine settings, by the deviations (µm) that the nodes of an iteration hold.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = CorrectionRequest)]
pub struct CorrectionRequestBody {
    pub sensitivity: SensitivityBody,
    /// By the names of the settings; a setting that is not named may go anywhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<BTreeMap<String, LimitsBody>>,
    /// Whether the mean of the deviations is measured, as thickness is. Traces and flanks that were
    /// laid into the nominal one have no such datum: then what all nodes have in common is left
    /// aside, and settings that change all nodes nearly alike come back `undetermined`. Default
    /// true with `matrix`, false with `machine` and wherever traces have a zero each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absolute: Option<bool>,
    /// For each node the number of the trace that it belongs to, where profiles and helices were
    /// measured that have a zero each: what the nodes of a trace have in common is left aside then,
    /// and a setting that changes the nodes of every trace nearly alike comes back `undetermined`.
    /// By default what `trace_lengths` of the iteration's heights say, as after an import. Without
    /// `absolute`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trace: Option<Vec<u32>>,
    /// For each node. By default the weights of the iteration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<Vec<f64>>,
    /// The deviations that are wanted. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_um: Option<Vec<f64>>,
    /// Standard deviation of a measured deviation. By default from the residuals.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub noise_sigma_um: Option<f64>,
    /// Standard uncertainty of an entry of the sensitivity matrix, relative to it. Default 0.02.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 1)]
    pub response_uncertainty: Option<f64>,
    /// How errors of the sensitivity matrix hang together. Default `independent`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub response_errors: Option<ResponseErrorsName>,
    /// By default spectral with the λ* that `noise_sigma_um` and `response_uncertainty` speak for,
    /// so that repeated corrections converge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regularization: Option<RegularizationBody>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scaling: Option<ScalingName>,
    /// Limit of the settings' norm that bias bounds hold for, in columns of unit length. By default
    /// the norm that `limits` allow where every setting has both, else what the deviations speak
    /// for (√n τ, see `result.bias`); with `regularization` that of the least-squares estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub coefficient_norm_limit: Option<f64>,
    /// What is answered only when asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub include: Option<Vec<CorrectionIncludeName>>,
}

/// What a unit of each setting does to each node: as a matrix, or by a machine for cylindrical
/// gears that is known here.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Sensitivity)]
pub struct SensitivityBody {
    /// Names of the settings, with `matrix`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settings: Option<Vec<String>>,
    /// Units of the settings, with `matrix`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Vec<String>>,
    /// µm per unit: a row for each node in the order posted (of a grid row by row, missing ones
    /// too), an entry for each setting.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matrix: Option<Vec<Vec<f64>>>,
    /// In place of a matrix. Nodes then have u along the profile and v = z, and the job has a gear.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineName>,
    /// With `machine`: the flank that was measured. By default that of the iteration, and `left`
    /// (warning `flank_assumed`) where it tells none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flank: Option<SideName>,
    /// With `machine`: what u of the nodes is. By default what the iteration's axes say, else
    /// `roll_length`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile_axis: Option<ProfileAxisName>,
    /// With `machine`: what crownings refer to. By default what the nodes span.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile_diameter_range_mm: Option<[f64; 2]>,
    /// Range in z over which angle and crowning of the helix are meant, `[from, to]`. By default
    /// that of the nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub helix_range_mm: Option<[f64; 2]>,
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

/// A machine that grinds cylindrical gears. Deviations are along the normal, + = material left
/// standing; s is +1 on left and −1 on right flanks, u and v run from −1 to 1 over the ranges from
/// root to tip and along z. docs/machine-settings.md has a figure of each setting.
///
/// | setting | unit | a positive change | what the flank gets |
/// |---|---|---|---|
/// | `profile_angle` | arcmin | greater normal pressure angle of the tool | less material at the tip on both flanks: f_Hα falls |
/// | `helix_angle` | arcmin | signed helix angle grows (as `helix_angle_deg`, right hand above 0) | f_Hβ (DIN) grows on both flanks of gears of either hand |
/// | `profile_crowning` | µm | more removed at root and tip | −u²: C_α grows by as much |
/// | `helix_crowning` | µm | more removed at both ends | −v² (form), −v_t² at the place of the worm (generating, with a natural twist on helical gears): C_β grows |
/// | `twist` | µm | generating only: worm shifted along a dressed profile | uv/4 on both flanks: 4c_uv grows by as much |
/// | `tooth_thickness` | µm | thicker tooth | ½ cos α_n on both flanks: no slope, no crowning |
/// | `infeed` | µm | form only: wheel away from the gear's axis | material on both flanks, more towards the tip |
/// | `tool_axis_offset` | µm | tool to the left (−x) in its gap | material on left flanks, the same off right flanks |
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Machine)]
pub enum MachineName {
    /// With a worm that rolls with the gear.
    GeneratingGrinding,
    /// With a wheel of the shape of the gap.
    FormGrinding,
}

impl From<MachineName> for Machine {
    fn from(name: MachineName) -> Self {
        match name {
            MachineName::GeneratingGrinding => Machine::GeneratingGrinding,
            MachineName::FormGrinding => Machine::FormGrinding,
        }
    }
}

const KEYS: [&str; 13] = [
    "sensitivity",
    "limits",
    "absolute",
    "trace",
    "weight",
    "target_um",
    "noise_sigma_um",
    "response_uncertainty",
    "response_errors",
    "regularization",
    "scaling",
    "coefficient_norm_limit",
    "include",
];

/// A request that has been read.
pub struct Read {
    /// The contract's name of the sensitivity.
    pub method: &'static str,
    pub asked: CorrectionSpec,
    /// The flank that the nodes lie on, where the sensitivity is that of a machine.
    pub flank: Option<Flank>,
    /// Nobody said which flank it is.
    pub flank_assumed: bool,
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
    let fields = Fields::of_request(text, &KEYS, &mut faults)?;
    let spec = fields::read(&fields.without("include"), None, &mut faults);
    let include: Option<Vec<CorrectionIncludeName>> = part(&fields, "include", &mut faults);
    let include = CorrectionInclude::of(&include.unwrap_or_default());
    let limits: Option<BTreeMap<String, LimitsBody>> = part(&fields, "limits", &mut faults);
    let absolute: Option<bool> = part(&fields, "absolute", &mut faults);
    let trace: Option<Vec<u32>> = part(&fields, "trace", &mut faults);
    let weight: Option<Vec<f64>> = part(&fields, "weight", &mut faults);
    let target: Option<Vec<f64>> = part(&fields, "target_um", &mut faults);
    let noise_sigma: Option<f64> = part(&fields, "noise_sigma_um", &mut faults);
    let response: Option<f64> = part(&fields, "response_uncertainty", &mut faults);
    let factor = AxesBody::of(measurand).deviation_factor();
    let factor = factor.map_err(|why| faults.push("/sensitivity", why)).unwrap_or(1.0);
    let errors: Option<ResponseErrorsName> = part(&fields, "response_errors", &mut faults);
    let known = fields
        .required("sensitivity", "", &mut faults)
        .and_then(|slice| sensitivity(slice, nodes, measurand, gear, &mut faults).or_else(|| none(&mut faults)));
    let (Some(spec), Some(mut known)) = (spec, known) else { return Ok(Err(faults)) };
    for (name, limits) in limits.iter().flatten() {
        let LimitsBody { min, max, increment, fixed } = *limits;
        match known.settings.iter_mut().find(|setting| setting.name == *name) {
            Some(setting) => {
                (setting.min, setting.max, setting.increment) = (min, max, increment);
                setting.fixed = fixed.unwrap_or(false);
            }
            None => {
                let names: Vec<String> = known.settings.iter().map(|setting| format!("`{}`", setting.name)).collect();
                let detail = format!("there is no such setting; there are {}", names.join(", "));
                faults.push(format!("/limits/{}", escape(name)), detail);
            }
        }
    }
    let traces = match trace {
        Some(trace) => Some(trace.into_iter().map(|trace| trace as usize).collect()),
        None => AxesBody::of(measurand).traces(),
    };
    if let Some(flank) = &mut known.flank {
        flank.traces.clone_from(&traces);
    }
    let damping =
        if fields.get("regularization").is_some() { Damping::Given(spec.regularization) } else { Damping::default() };
    let asked = CorrectionSpec {
        weight: weight.or_else(|| iteration_nodes::weights(nodes)),
        target,
        damping,
        scaling: if fields.get("scaling").is_some() { spec.scaling } else { Scaling::UnitLength },
        noise_sigma,
        coefficient_norm_limit: spec.coefficient_norm_limit,
        response_uncertainty: response.unwrap_or(DEFAULT_RESPONSE_UNCERTAINTY),
        absolute: absolute.unwrap_or(known.flank.is_none() && traces.is_none()),
        traces,
        response_errors: errors.map_or_else(ResponseErrors::default, Into::into),
        include: include.fit,
        ..CorrectionSpec::new(iteration_nodes::deviations(nodes, factor), known.matrix, known.settings)
    };
    Ok(faults.into_result(Read {
        method: known.name,
        asked,
        flank: known.flank,
        flank_assumed: known.flank_assumed,
        include,
    }))
}

fn part<T: serde::de::DeserializeOwned>(fields: &Fields<'_>, key: &str, faults: &mut Faults) -> Option<T> {
    fields.get(key).and_then(|slice| read_part(slice, &format!("/{key}"), faults))
}

/// What has no value has a fault.
fn none<T>(faults: &mut Faults) -> Option<T> {
    if faults.is_empty() {
        faults.push("/sensitivity", "it cannot be read");
    }
    None
}

struct Known {
    name: &'static str,
    settings: Vec<Setting>,
    matrix: Vec<f64>,
    flank: Option<Flank>,
    flank_assumed: bool,
}

fn sensitivity(
    slice: &[u8],
    nodes: &Nodes,
    measurand: &Measurand,
    gear: Option<&Gear>,
    faults: &mut Faults,
) -> Option<Known> {
    const AT: &str = "/sensitivity";
    const MATRIX: [&str; 3] = ["settings", "units", "matrix"];
    const MACHINE: [&str; 5] = ["machine", "flank", "profile_axis", "profile_diameter_range_mm", "helix_range_mm"];
    let fields = Fields::of_part(slice, AT, &[&MATRIX[..], &MACHINE[..]].concat(), faults)?;
    let before = faults.count();
    let (mine, strangers) =
        if fields.get("machine").is_some() { ("machine", &MATRIX[..]) } else { ("matrix", &MACHINE[1..]) };
    for key in strangers.iter().filter(|key| fields.get(key).is_some()) {
        faults.push(format!("{AT}/{key}"), format!("it does not belong to a `{mine}`"));
    }
    if faults.count() > before {
        return None;
    }
    if mine == "machine" { of_machine(&fields, nodes, measurand, gear, faults) } else { of_matrix(&fields, faults) }
}

fn of_matrix(fields: &Fields<'_>, faults: &mut Faults) -> Option<Known> {
    const AT: &str = "/sensitivity";
    let names = fields.required("settings", AT, faults);
    let matrix = fields.required("matrix", AT, faults);
    let names: Vec<String> = read_part(names?, "/sensitivity/settings", faults)?;
    let units: Option<Vec<String>> = match fields.get("units") {
        Some(slice) => Some(read_part(slice, "/sensitivity/units", faults)?),
        None => None,
    };
    if let Some(units) = units.as_ref().filter(|units| units.len() != names.len()) {
        faults.push("/sensitivity/units", format!("{} for {} settings", entries(units.len()), names.len()));
        return None;
    }
    let (matrix, lengths) = read_rows(matrix?, "/sensitivity/matrix", faults)?;
    let before = faults.count();
    for (k, length) in lengths.iter().enumerate().filter(|(_, length)| **length != names.len()) {
        faults.push(format!("/sensitivity/matrix/{k}"), format!("{} for {} settings", entries(*length), names.len()));
    }
    let unit = |j: usize| units.as_ref().map_or("", |units| &units[j]).to_owned();
    let settings = names.into_iter().enumerate().map(|(j, name)| Setting::free(name, unit(j))).collect();
    (faults.count() == before).then_some(Known { name: "matrix", settings, matrix, flank: None, flank_assumed: false })
}

fn of_machine(
    fields: &Fields<'_>,
    nodes: &Nodes,
    measurand: &Measurand,
    gear: Option<&Gear>,
    faults: &mut Faults,
) -> Option<Known> {
    let asked = |key: &str| fields.get(key).map(|slice| (slice, format!("/sensitivity/{key}")));
    let (slice, at) = asked("machine")?;
    let machine: Machine = read_part::<MachineName>(slice, &at, faults)?.into();
    let side: Option<Side> = match asked("flank") {
        Some((slice, at)) => Some(read_part::<SideName>(slice, &at, faults)?.into()),
        None => None,
    };
    let axis: Option<ProfileAxisName> = match asked("profile_axis") {
        Some((slice, at)) => Some(read_part(slice, &at, faults)?),
        None => None,
    };
    let before = faults.count();
    if let (Some(asked), Some(measured)) = (side, measurand.flank)
        && asked != measured
    {
        let detail = format!("the iteration is of {}, not of the {} one", measurand.words(), side_name(asked));
        faults.push("/sensitivity/flank", detail);
    }
    let coordinates = coordinates(axis, &AxesBody::of(measurand), faults);
    let coordinates = coordinates.filter(|_| faults.count() == before)?;
    let flank_assumed = side.is_none() && measurand.flank.is_none();
    let side = side.or(measurand.flank).unwrap_or(Side::Left);
    let diameters: Option<[f64; 2]> = match asked("profile_diameter_range_mm") {
        Some((slice, at)) => Some(read_part(slice, &at, faults)?),
        None => None,
    };
    let helix: Option<[f64; 2]> = match asked("helix_range_mm") {
        Some((slice, at)) => Some(read_part(slice, &at, faults)?),
        None => None,
    };
    let Some(gear) = gear else {
        faults.push("/sensitivity/machine", "the job has no `gear`, whose flanks the machine would grind");
        return None;
    };
    let places = iteration_nodes::places(nodes, gear, side, coordinates).map_err(|more| faults.append(more)).ok()?;
    let mut ranges: Ranges = iteration_nodes::ranges(&places, gear);
    if let Some(diameters) = diameters {
        match diameters.map(|diameter| gear.roll_length(diameter)) {
            [Some(low), Some(high)] => ranges.profile = [low, high],
            _ => {
                faults.push("/sensitivity/profile_diameter_range_mm", "a diameter lies below the base circle");
                return None;
            }
        }
    }
    ranges.helix = helix.unwrap_or(ranges.helix);
    let asked = [diameters.is_some(), helix.is_some()];
    let found = machine.sensitivity(gear, &places, ranges).map_err(|more| faults.append(placed(&more, asked)));
    let flank = Some(Flank { gear: gear.clone(), side, places, ranges, traces: None });
    let found = found.ok()?;
    Some(Known { name: machine.name(), settings: found.settings, matrix: found.matrix, flank, flank_assumed })
}

/// What u and v of the iteration are: by what is asked, else by its axes, else roll lengths and z
/// in mm.
fn coordinates(asked: Option<ProfileAxisName>, axes: &AxesBody, faults: &mut Faults) -> Option<Coordinates> {
    let told = axes.profile().map_err(|why| faults.push("/sensitivity/machine", why)).ok()?;
    let v = axes.along().map_err(|why| faults.push("/sensitivity/machine", why)).ok()?;
    match (asked, told) {
        (Some(asked), Some((told, _))) if asked != told => {
            let detail = format!("u of the iteration is `{}`, as its axes say", told.name());
            faults.push("/sensitivity/profile_axis", detail);
            None
        }
        (_, Some((profile, u))) => Some(Coordinates { profile, u, v }),
        (asked, None) => Some(Coordinates { profile: asked.unwrap_or_default(), u: 1.0, v }),
    }
}

/// Faults of a machine's sensitivity by places in the request, one for each place; `asked` says
/// which ranges are in it.
fn placed(found: &MachineFaults, [profile, helix]: [bool; 2]) -> Faults {
    let mut faults = Faults::default();
    let nodes = found.list().iter().filter(|fault| fault.field.is_of_nodes()).count();
    for Fault { field, reason } in found.list() {
        let pointer = match field {
            MachineField::ProfileRange if profile => "/sensitivity/profile_diameter_range_mm",
            MachineField::HelixRange if helix => "/sensitivity/helix_range_mm",
            field if field.is_of_nodes() => "/sensitivity/profile_axis",
            // the nodes themselves have no such range
            _ => "/sensitivity/machine",
        };
        if faults.list().iter().any(|there| there.pointer == pointer) {
            continue;
        }
        let more = if field.is_of_nodes() && nodes > 1 {
            let count = found.count() - (found.list().len() - nodes);
            format!("{count} nodes of the iteration have no place on the flank; the first: {reason}")
        } else {
            reason.to_string()
        };
        faults.push(pointer, more);
    }
    faults
}
