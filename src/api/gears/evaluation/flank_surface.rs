//! The second-order surface of a flank's deviations.

use serde::Serialize;
use utoipa::ToSchema;

use super::request::figure_terms;
use crate::api::{
    built::Built,
    faults::{Faults, is_within, pointer_of},
    fits::{answer::FitResultBody, canonical, reader::fields, spec::request::FitFields},
    gears::{gear::GearBody, plausibility::implausible_flank},
    json::{
        gather::gathered,
        members::of_request,
        numbers::{Numbers, read_heights},
        request::request,
        writer::whole,
    },
    problem::Problem,
    warning::WarningBody,
};
use flankfit_engine::{
    estimation::FitError,
    gear::{
        Gear, ProfileAxis, Side,
        evaluation::{
            SidedLimits,
            flank_surface::{Border, FlankNodes, FlankSurface, Reference, SurfaceSettings, flank_surface},
            settings::{DeviationSign, SlopeSign},
        },
        trace::Direction,
    },
    words::entries,
};

request! {
    /// Deviations over a flank: on a grid (`deviation_um` is a row for each `profile`), or one for
    /// each node.
    #[schema(as = FlankSurfaceRequest)]
    pub struct FlankSurfaceRequestBody as FlankSurfaceMembers {
        required gear: GearBody,
        required flank: Side,
        /// Quantity of `profile`. Default `roll_length`.
        optional profile_axis: ProfileAxis,
        /// mm; roll angles in degrees. Ascending for a grid.
        required profile: Vec<f64>,
        /// Ascending for a grid.
        required z_mm: Vec<f64>,
        /// Rows of numbers (grid) or numbers (scattered nodes), positive where material protrudes
        /// unless `deviation_sign` says otherwise; `null` where undefined.
        #[schema(value_type = Vec<serde_json::Value>)]
        required deviation_um: Vec<serde_json::Value>,
        /// Evaluation range in the unit of `profile`. By default the range of the nodes.
        #[schema(min_items = 2, max_items = 2)]
        optional profile_range: [f64; 2],
        /// Evaluation range in z, `[from, to]`. By default the range of the nodes.
        #[schema(min_items = 2, max_items = 2)]
        optional helix_range_mm: [f64; 2],
        optional border_percent: Border,
        /// The sign of slopes and twist. Default `din`.
        optional sign: SlopeSign,
        /// Default `material`, which for a whole flank is the same as `din`. Helix slope and twist
        /// are returned in `sign`.
        optional deviation_sign: DeviationSign,
        /// Direction of deviations, figures, form and limits. Default `normal`.
        optional direction: Direction,
        /// Length that slopes refer to. Default `reference_length`.
        optional reference: Reference,
        /// Limits of the figures. Limits of form and total deviations apply to traces and are
        /// refused here.
        optional tolerance_limits: SidedLimits,
        /// Confirms that the deviations are in µm although they are far below or above those of any
        /// gear. Otherwise there is a warning `implausible_unit`, and figures are not compared with
        /// limits. Default false.
        optional accept_units: bool,
        /// How is fitted; by default by plain least squares.
        flatten fit: FitFields,
    }
}

/// Second-order surface of a flank with its fit.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = FlankSurface)]
pub struct FlankSurfaceBody<'a> {
    #[serde(flatten)]
    #[schema(inline)]
    pub surface: &'a FlankSurface,
    /// Warnings about the nodes and the range; those about the fit are `result.warnings`. With
    /// `range_not_covered` figures are not compared with limits: the nodes within the border cover
    /// less than three quarters of the range.
    pub warnings: Vec<WarningBody>,
    /// The fit, as returned by `POST /v1/fits`: u and v over [-1, 1].
    pub result: FitResultBody<'a>,
}

/// Answers a request; `own` is the gear of the job that the nodes belong to. Processor work.
pub fn build(text: &[u8], own: Option<&Gear>) -> Result<Built, Problem> {
    let mut faults = Faults::default();
    let members: FlankSurfaceMembers<'_> = of_request(text, &mut faults)?;
    let gear = members.gear.read(&mut faults);
    let gear = gear.and_then(|gear| gear.checked("/gear").map_err(|more| faults.append(more)).ok()).or(own.cloned());
    if gear.is_none() && !members.gear.is_given() {
        faults.push_missing("/gear", "required");
    }
    let side = members.flank.required(&mut faults);
    let profile = members.profile.required(&mut faults);
    let z = members.z_mm.required(&mut faults);
    let posted = members.deviation_um.required_with(&mut faults, read_heights);
    let axis = members.profile_axis.read(&mut faults).unwrap_or_default();
    let border = members.border_percent.read(&mut faults).unwrap_or_default();
    let sign = members.sign.read(&mut faults);
    let given = members.deviation_sign.read(&mut faults);
    let direction = members.direction.read(&mut faults);
    let reference = members.reference.read(&mut faults);
    let profile_range = members.profile_range.optional(&mut faults).flatten();
    let helix_range = members.helix_range_mm.optional(&mut faults).flatten();
    let limits = members.tolerance_limits.read(&mut faults).unwrap_or_default();
    let accept_units = members.accept_units.read(&mut faults).unwrap_or_default();
    let spec = fields::read(&members.fit, None, &mut faults);
    let (Some(gear), Some(side), Some(profile), Some(z), Some(posted), Some(spec)) =
        (gear, side, profile, z, posted, spec)
    else {
        return Err(Problem::invalid(faults));
    };
    let Numbers { values: deviation, rows, .. } = posted;
    check_rows(rows.as_deref().unwrap_or_default(), z.len(), &mut faults);
    for found in [limits.check(), limits.check_for_surface()] {
        faults.append(Faults::of_engine("/tolerance_limits", &found));
    }
    faults.into_result(()).map_err(Problem::invalid)?;
    let implausible = (!accept_units).then(|| implausible_flank(axis, &profile, &z, &deviation, &gear)).flatten();
    let profile: Vec<f64> = profile.into_iter().map(|x| axis.requested(x)).collect();
    let profile_range = profile_range.map(|range: [f64; 2]| range.map(|x| axis.requested(x)));
    let nodes = FlankNodes { axis, profile: &profile, z: &z, deviation: &deviation, valid: None, grid: rows.is_some() };
    let terms = figure_terms(direction, reference);
    let settings = SurfaceSettings {
        side,
        profile_range,
        helix_range,
        border,
        given: given.map_or(DeviationSign::Material, Into::into),
        direction: terms.direction,
        terms,
        sign: sign.map_or(SlopeSign::Din, Into::into),
        limits: if implausible.is_some() { Default::default() } else { limits.of(side) },
        spec,
    };
    let found = flank_surface(&gear, &nodes, &settings).map_err(refused)?;
    let body = FlankSurfaceBody {
        surface: &found,
        warnings: found.warnings.iter().map(WarningBody::from).chain(implausible).collect(),
        result: FitResultBody::new(&found.result, None, canonical::request_sha256(text)),
    };
    let result = whole(&body).map(gathered).map_err(Problem::not_finite)?;
    Ok(Built { method: "second_order_surface".to_owned(), result })
}

/// Refuses rows of another length than z.
fn check_rows(lengths: &[usize], columns: usize, faults: &mut Faults) {
    for (i, length) in lengths.iter().enumerate().filter(|(_, length)| **length != columns) {
        faults.push(format!("/deviation_um/{i}"), format!("{} for {columns} z", entries(*length)));
    }
}

/// A refused fit, by places in the request.
fn refused(error: FitError) -> Problem {
    Problem::of_fit(error, |path| match path {
        _ if is_within(path, &["nodes", "model"]) => "/deviation_um".to_owned(),
        _ => pointer_of(path),
    })
}
