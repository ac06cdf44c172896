//! The second-order surface of a flank's deviations.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    conformity::ToleranceLimitsBody,
    figures::FiguresBody,
    request::{DeviationSignName, DirectionName, ReferenceName, SignName, figure_terms},
};
use crate::api::{
    built::Built,
    faults::{Faults, is_within, pointer_of},
    fits::{answer::FitResultBody, canonical, reader::fields, spec::request::FitFields},
    gears::{gear::GearBody, notice::NoticeBody, plausibility::implausible_flank},
    json::{
        gather::gathered,
        members::of_request,
        numbers::{Numbers, read_heights},
        request::request,
        writer::whole,
    },
    measurand::{profile_axis::ProfileAxisName, side::SideName},
    problem::Problem,
};
use flankfit_engine::{
    estimation::FitError,
    gear::{
        Gear,
        evaluation::{
            flank_surface::{Border, FlankNodes, FlankSurface, SurfaceSettings, flank_surface},
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
        required flank: SideName,
        /// What `profile` is. Default `roll_length`.
        optional profile_axis: ProfileAxisName,
        /// mm; roll angles in degrees. Of a grid ascending.
        required profile: Vec<f64>,
        /// Of a grid ascending.
        required z_mm: Vec<f64>,
        /// Rows of numbers (grid) or numbers (scattered nodes), positive where material stands out
        /// unless `deviation_sign` says otherwise; `null` where undefined.
        #[schema(value_type = Vec<serde_json::Value>)]
        required deviation_um: Vec<serde_json::Value>,
        /// Evaluation range in the unit of `profile`. By default what the nodes span.
        #[schema(min_items = 2, max_items = 2)]
        optional profile_range: [f64; 2],
        /// Evaluation range in z, `[from, to]`. By default what was measured.
        #[schema(min_items = 2, max_items = 2)]
        optional helix_range_mm: [f64; 2],
        optional border_percent: BorderPercentBody,
        /// The sign of slopes and twist. Default `din`.
        optional sign: SignName,
        /// Default `material`, which is what `din` means for a whole flank too; helix slope and
        /// twist are answered by `sign`.
        optional deviation_sign: DeviationSignName,
        /// Direction in which deviations were taken, figures and form are given, and limits count.
        /// Default `normal`.
        optional direction: DirectionName,
        /// Length that slopes refer to. Default `reference_length`.
        optional reference: ReferenceName,
        /// What the figures must lie within. Limits of form and total deviations are of traces, and
        /// refused here.
        optional tolerance_limits: ToleranceLimitsBody,
        /// Whether deviations far below or above those of any gear are given in µm all the same.
        /// Until then `implausible_unit` warns of them, and figures are held against no limits.
        /// Default false.
        optional accept_units: bool,
        /// How is fitted; by default by plain least squares.
        flatten fit: FitFields,
    }
}

/// What is cut off the evaluation range at each edge, in percent. Default 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
#[schema(as = BorderPercent)]
pub struct BorderPercentBody {
    /// At the end of small diameters (of internal gears: of great ones), in percent of the
    /// profile's roll length.
    pub root: f64,
    /// At the tip end, in percent of the profile's roll length.
    pub tip: f64,
    /// At the end of small z.
    pub toe: f64,
    /// At the end of great z.
    pub heel: f64,
}

/// Figures of the second-order surface of a flank, in µm, and what the surface leaves over. Slopes
/// are over their reference lengths, the other figures over the trimmed range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FlankSurface)]
pub struct FlankSurfaceBody<'a> {
    #[serde(flatten)]
    #[schema(inline)]
    pub figures: FiguresBody,
    /// Direction in which figures and form count.
    pub direction: DirectionName,
    /// Length that the profile slope refers to.
    pub profile_reference_length_mm: f64,
    /// Length that the helix slope refers to.
    pub helix_reference_length_mm: f64,
    pub form: FlankFormBody,
    /// What u = ∓1 and v = ∓1 stand for, after trimming.
    #[schema(min_items = 2, max_items = 2)]
    pub roll_length_range_mm: [f64; 2],
    /// The evaluated part of the width.
    #[schema(min_items = 2, max_items = 2)]
    pub z_range_mm: [f64; 2],
    pub nodes: FlankNodesBody,
    /// What is to be known of the nodes and of the range; those of the fit are `result.warnings`.
    /// After `range_not_covered` figures are held against no limits: the nodes that the border
    /// leaves cover less than three quarters of the range.
    pub warnings: Vec<NoticeBody>,
    /// The fit, as `POST /v1/fits` answers it: u and v over [-1, 1].
    pub result: FitResultBody<'a>,
}

/// What the surface leaves over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FlankForm)]
pub struct FlankFormBody {
    /// Greatest minus least of the remainder.
    pub peak_to_valley_um: f64,
    /// Root mean square of the remainder.
    pub rms_um: f64,
    /// Largest amount of the remainder.
    pub max_abs_um: f64,
}

/// Nodes by what became of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = FlankNodeCounts)]
pub struct FlankNodesBody {
    /// All nodes that were posted.
    pub posted: usize,
    /// Nodes without a deviation.
    pub missing: usize,
    /// Nodes outside the evaluation ranges.
    pub trimmed: usize,
    /// Nodes that the surface was fitted to.
    pub used: usize,
}

/// Answers a request; `own` is the gear of the job that the nodes belong to. Processor work.
pub fn build(text: &[u8], own: Option<&Gear>) -> Result<Built, Problem> {
    let mut faults = Faults::default();
    let members: FlankSurfaceMembers<'_> = of_request(text, &mut faults)?;
    let gear = members.gear.read(&mut faults);
    let gear = gear.and_then(|gear| gear.checked("/gear").map_err(|more| faults.append(more)).ok()).or(own.cloned());
    if gear.is_none() && !members.gear.is_given() {
        faults.push_missing("/gear", "missing");
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
    limits.check("/tolerance_limits", &mut faults);
    limits.check_for_surface("/tolerance_limits", &mut faults);
    faults.into_result(()).map_err(Problem::invalid)?;
    let implausible = (!accept_units).then(|| implausible_flank(axis, &profile, &z, &deviation, &gear)).flatten();
    let profile: Vec<f64> = profile.into_iter().map(|x| axis.value(x)).collect();
    let profile_range = profile_range.map(|range: [f64; 2]| range.map(|x| axis.value(x)));
    let nodes = FlankNodes {
        axis: axis.into(),
        profile: &profile,
        z: &z,
        deviation: &deviation,
        valid: None,
        grid: rows.is_some(),
    };
    let terms = figure_terms(direction, reference);
    let settings = SurfaceSettings {
        side,
        profile_range,
        helix_range,
        border: Border { root: border.root, tip: border.tip, toe: border.toe, heel: border.heel },
        given: given.map_or(DeviationSign::Material, Into::into),
        direction: terms.direction,
        terms,
        sign: sign.map_or(SlopeSign::Din, Into::into),
        limits: if implausible.is_some() { Default::default() } else { limits.of(side) },
        spec,
    };
    let found = flank_surface(&gear, &nodes, &settings).map_err(refused)?;
    let body = FlankSurfaceBody::new(&found, implausible, terms.direction, canonical::request_sha256(text));
    let result = whole(&body).map(gathered).map_err(Problem::not_finite)?;
    Ok(Built { method: "second_order_surface".to_owned(), result })
}

/// Rows of another length than z are faults.
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

impl<'a> FlankSurfaceBody<'a> {
    fn new(found: &'a FlankSurface, implausible: Option<NoticeBody>, direction: Direction, digest: String) -> Self {
        let [profile_reference_length_mm, helix_reference_length_mm] = found.references;
        FlankSurfaceBody {
            figures: FiguresBody::from(found),
            direction,
            profile_reference_length_mm,
            helix_reference_length_mm,
            form: FlankFormBody {
                peak_to_valley_um: found.remainder.peak_to_valley,
                rms_um: found.remainder.rms,
                max_abs_um: found.remainder.max_abs,
            },
            roll_length_range_mm: found.roll_lengths,
            z_range_mm: found.z,
            nodes: FlankNodesBody {
                posted: found.nodes.posted,
                missing: found.nodes.missing,
                trimmed: found.nodes.trimmed,
                used: found.nodes.used,
            },
            warnings: found.warnings.iter().map(NoticeBody::from).chain(implausible).collect(),
            result: FitResultBody::new(&found.result, None, digest),
        }
    }
}
