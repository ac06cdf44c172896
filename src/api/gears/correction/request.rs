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
            reader::fields::{self, FitFieldsMembers},
            spec::request::{RegularizationBody, ScalingName},
        },
        json::{
            error::ReadError,
            members::{Members, of_object, of_request},
            place::escape,
            present::present,
            request::request,
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

request! {
    /// A correction of machine settings, by the deviations (µm) that the nodes of an iteration hold.
    #[schema(as = CorrectionRequest)]
    pub struct CorrectionRequestBody as CorrectionMembers {
        required sensitivity: SensitivityBody,
        /// By the names of the settings; a setting that is not named may go anywhere.
        optional limits: BTreeMap<String, LimitsBody>,
        /// Whether the mean of the deviations is measured, as thickness is. Traces and flanks that were
        /// laid into the nominal one have no such datum: then what all nodes have in common is left
        /// aside, and settings that change all nodes nearly alike come back `undetermined`. Default
        /// true with `matrix`, false with `machine` and wherever traces have a zero each.
        optional absolute: bool,
        /// For each node the number of the trace that it belongs to, where profiles and helices were
        /// measured that have a zero each: what the nodes of a trace have in common is left aside then,
        /// and a setting that changes the nodes of every trace nearly alike comes back `undetermined`.
        /// By default what `trace_lengths` of the iteration's heights say, as after an import. Without
        /// `absolute`.
        optional trace: Vec<u32>,
        /// For each node. By default the weights of the iteration.
        optional weight: Vec<f64>,
        /// The deviations that are wanted. Default 0.
        optional target_um: Vec<f64>,
        /// Standard deviation of a measured deviation. By default from the residuals.
        #[schema(exclusive_minimum = 0)]
        optional noise_sigma_um: f64,
        /// Standard uncertainty of an entry of the sensitivity matrix, relative to it. Default 0.02.
        #[schema(minimum = 0, maximum = 1)]
        optional response_uncertainty: f64,
        /// How errors of the sensitivity matrix hang together. Default `independent`.
        optional response_errors: ResponseErrorsName,
        /// By default spectral with the λ* that `noise_sigma_um` and `response_uncertainty` speak for,
        /// so that repeated corrections converge.
        optional regularization: RegularizationBody,
        optional scaling: ScalingName,
        /// Limit of the settings' norm that bias bounds hold for, in columns of unit length. By default
        /// the norm that `limits` allow where every setting has both, else what the deviations speak
        /// for (√n τ, see `result.bias`); with `regularization` that of the least-squares estimate.
        #[schema(exclusive_minimum = 0)]
        optional coefficient_norm_limit: f64,
        /// What is answered only when asked for.
        optional include: Vec<CorrectionIncludeName>,
    }
}

request! {
    /// What a unit of each setting does to each node: as a matrix, or by a machine for cylindrical
    /// gears that is known here.
    #[schema(as = Sensitivity)]
    pub struct SensitivityBody as SensitivityMembers {
        /// Names of the settings, with `matrix`.
        optional settings: Vec<String>,
        /// Units of the settings, with `matrix`.
        optional units: Vec<String>,
        /// µm per unit: a row for each node in the order posted (of a grid row by row, missing ones
        /// too), an entry for each setting.
        optional matrix: Vec<Vec<f64>>,
        /// In place of a matrix. Nodes then have u along the profile and v = z, and the job has a gear.
        optional machine: MachineName,
        /// With `machine`: the flank that was measured. By default that of the iteration, and `left`
        /// (warning `flank_assumed`) where it tells none.
        optional flank: SideName,
        /// With `machine`: what u of the nodes is. By default what the iteration's axes say, else
        /// `roll_length`.
        optional profile_axis: ProfileAxisName,
        /// With `machine`: what crownings refer to. By default what the nodes span.
        optional profile_diameter_range_mm: [f64; 2],
        /// Range in z over which angle and crowning of the helix are meant, `[from, to]`. By default
        /// that of the nodes.
        optional helix_range_mm: [f64; 2],
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
    let members: CorrectionMembers<'_> = of_request(text, &mut faults)?;
    let (regularized, scaled) = (members.regularization.is_given(), members.scaling.is_given());
    let fit = FitFieldsMembers {
        regularization: members.regularization,
        scaling: members.scaling,
        coefficient_norm_limit: members.coefficient_norm_limit,
        ..FitFieldsMembers::at("")
    };
    let spec = fields::read(fit, None, &mut faults);
    let include = CorrectionInclude::of(&members.include.read(&mut faults).unwrap_or_default());
    let limits = members.limits.read(&mut faults);
    let absolute = members.absolute.read(&mut faults);
    let trace = members.trace.read(&mut faults);
    let weight = members.weight.read(&mut faults);
    let target = members.target_um.read(&mut faults);
    let noise_sigma = members.noise_sigma_um.read(&mut faults);
    let response = members.response_uncertainty.read(&mut faults);
    let factor = AxesBody::of(measurand).deviation_factor();
    let factor = factor.map_err(|why| faults.push("/sensitivity", why)).unwrap_or(1.0);
    let errors = members.response_errors.read(&mut faults);
    let known = members
        .sensitivity
        .required_text(&mut faults)
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
    let damping = if regularized { Damping::Given(spec.regularization) } else { Damping::default() };
    let asked = CorrectionSpec {
        weight: weight.or_else(|| iteration_nodes::weights(nodes)),
        target,
        damping,
        scaling: if scaled { spec.scaling } else { Scaling::UnitLength },
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
    let members: SensitivityMembers<'_> = of_object(slice, AT, faults)?;
    let of_machine_only = [
        members.flank.name_if_given(),
        members.profile_axis.name_if_given(),
        members.profile_diameter_range_mm.name_if_given(),
        members.helix_range_mm.name_if_given(),
    ];
    let of_matrix_only =
        [members.settings.name_if_given(), members.units.name_if_given(), members.matrix.name_if_given()];
    let before = faults.count();
    let (kind, foreign) = match members.machine.is_given() {
        true => ("machine", &of_matrix_only[..]),
        false => ("matrix", &of_machine_only[..]),
    };
    for name in foreign.iter().flatten() {
        faults.push(format!("{AT}/{name}"), format!("it does not belong to a `{kind}`"));
    }
    if faults.count() > before {
        return None;
    }
    match members.machine.is_given() {
        true => of_machine(&members, nodes, measurand, gear, faults),
        false => of_matrix(&members, faults),
    }
}

fn of_matrix(members: &SensitivityMembers<'_>, faults: &mut Faults) -> Option<Known> {
    let names = members.settings.required_text(faults);
    let matrix = members.matrix.required_text(faults);
    names?;
    let names = members.settings.read(faults)?;
    let units = members.units.optional(faults)?;
    if let Some(units) = units.as_ref().filter(|units| units.len() != names.len()) {
        faults.push("/sensitivity/units", format!("{} for {} settings", entries(units.len()), names.len()));
        return None;
    }
    matrix?;
    let (matrix, lengths) = members.matrix.rows(faults)?;
    let before = faults.count();
    for (k, length) in lengths.iter().enumerate().filter(|(_, length)| **length != names.len()) {
        faults.push(format!("/sensitivity/matrix/{k}"), format!("{} for {} settings", entries(*length), names.len()));
    }
    let unit = |j: usize| units.as_ref().map_or("", |units| &units[j]).to_owned();
    let settings = names.into_iter().enumerate().map(|(j, name)| Setting::free(name, unit(j))).collect();
    (faults.count() == before).then_some(Known { name: "matrix", settings, matrix, flank: None, flank_assumed: false })
}

fn of_machine(
    members: &SensitivityMembers<'_>,
    nodes: &Nodes,
    measurand: &Measurand,
    gear: Option<&Gear>,
    faults: &mut Faults,
) -> Option<Known> {
    let machine: Machine = members.machine.read(faults)?.into();
    let side: Option<Side> = members.flank.optional(faults)?.map(Into::into);
    let axis = members.profile_axis.optional(faults)?;
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
    let diameters = members.profile_diameter_range_mm.optional(faults)?;
    let helix = members.helix_range_mm.optional(faults)?;
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
