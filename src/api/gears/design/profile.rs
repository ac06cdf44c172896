//! The transverse section of teeth, and what a tool of any profile envelops.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{flank::TEXT_OF_NUMBER, geometry};
use crate::api::{
    contract::Pair,
    faults::Faults,
    gears::gear::GearBody,
    json::{value::read_json, writer::whole},
    problem::{Problem, Room},
    shapes::places::Values,
    warning::WarningBody,
};
use flankfit_engine::gear::{
    Geometry,
    generation::{
        Polar,
        envelope::{Envelope, Motion, ToolPoint, ToolProfile},
        tooth::{MOST_TOOTH_POINTS, Steps, Tooth},
    },
};

/// A gear, and the resolution of its section.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = GearProfileRequest)]
pub struct ProfileRequestBody {
    pub gear: GearBody,
    pub steps: Option<Steps>,
    /// True to return the section of the whole gear too. Default false.
    pub whole_gear: Option<bool>,
}

/// Closed polygons, counterclockwise, the first point not once more; mm.
#[skip_serializing_none]
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = GearProfile)]
pub struct ProfileAnswerBody {
    /// The tooth at the top, closed along the root circle below it.
    #[schema(value_type = Vec<[f64; 2]>)]
    pub tooth: Values,
    /// Its left flank from the root circle to the tip.
    #[schema(value_type = Vec<[f64; 2]>)]
    pub left_flank: Values,
    /// All teeth; of an internal gear the border of the hole.
    #[schema(value_type = Option<Vec<[f64; 2]>>)]
    pub whole_gear: Option<Values>,
    /// Those of `POST /v1/gears/geometry`: undercut, a pointed tip, an assumed tool.
    pub warnings: Vec<WarningBody>,
}

/// Profile of a tool, and its motion with the gear.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = EnvelopeRequest)]
pub struct EnvelopeRequestBody {
    pub tool: ToolProfileBody,
    pub motion: Motion,
    /// Radii of the gear between which the envelope is computed.
    #[schema(min_items = 2, max_items = 2)]
    pub radius_range_mm: [f64; 2],
    /// Radii, ascending, at which the resulting flank is returned.
    #[schema(max_items = 10000)]
    pub radii_mm: Option<Vec<f64>>,
}

/// Points of a tool's profile from its tip along the flank that cuts the left flank of the gear's
/// tooth at the top, mm. For a rack: along the pitch line from the middle of the gear's tooth (so
/// that the tool lies at negative values), and outwards from the pitch line. For a pinion: x and y
/// from its own centre, the gear's tooth below it (−y), for an internal gear above it.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ToolProfile)]
pub struct ToolProfileBody {
    /// `[x, y]` of each point, mm, in the order described above.
    #[schema(value_type = Vec<Pair>)]
    pub points: Vec<[f64; 2]>,
    /// Interpolation between the points. Default `polyline`.
    pub through: Option<ThroughName>,
    /// Number of steps in each interval. Default 20.
    #[schema(minimum = 1)]
    pub steps: Option<usize>,
}

/// Interpolation between the points of a tool's profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ToolInterpolation)]
pub enum ThroughName {
    Polyline,
    /// A cubic spline over the chord length.
    Spline,
}

/// The envelope of the tool, and the resulting flank.
#[skip_serializing_none]
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = ToolEnvelope)]
pub struct EnvelopeBody {
    /// Points (x, y) of the envelope on the left flank of the tooth at the top, in the order of the
    /// tool; a new branch begins after points without contact.
    #[schema(value_type = Vec<Vec<[f64; 2]>>)]
    pub branches: Vec<Values>,
    /// Half the angle of the resulting tooth at each requested radius; `null` where the tool does
    /// not cut.
    pub half_angle_deg: Option<Vec<Option<f64>>>,
}

/// Bytes of a point until it is written: itself, as it is made and as it is written, and its text.
const POINT: usize = 3 * 2 * size_of::<f64>() + 2 * TEXT_OF_NUMBER;

/// Answers a request for a section, as far as there is `room` for its points. Processor work.
pub fn answer(text: &[u8], room: Room) -> Result<Vec<u8>, Problem> {
    let body: ProfileRequestBody = read_json(text)?;
    let gear = body.gear.checked("/gear").map_err(Problem::invalid)?;
    let steps = body.steps.unwrap_or_default();
    // a tooth, its left flank once more, and all teeth where they are wanted
    let teeth = if body.whole_gear == Some(true) { gear.data().teeth as usize } else { 0 };
    let points = steps.points().saturating_mul(teeth.saturating_add(2));
    // more are refused in any case
    if points <= 2 * MOST_TOOTH_POINTS {
        room(points * POINT)?;
    }
    let tooth = Tooth::new(&gear, steps).map_err(Problem::invalid)?;
    let flank: Vec<[f64; 2]> = tooth.flank().iter().map(|place| place.point(1.0, 0.0)).collect();
    // no coordinate is −0
    let plain =
        |points: &[[f64; 2]]| Values { width: 2, flat: points.as_flattened().iter().map(|x| x + 0.0).collect() };
    let body = ProfileAnswerBody {
        tooth: plain(&tooth.closed()),
        left_flank: plain(&flank),
        whole_gear: (body.whole_gear == Some(true)).then(|| plain(&tooth.gear())),
        warnings: geometry::warnings(&body.gear, &Geometry::of(&gear)),
    };
    whole(&body).map_err(Problem::not_finite)
}

/// Answers a request for an envelope, as far as there is `room` for the tool's points and those
/// that they touch. Processor work.
pub fn envelope(text: &[u8], room: Room) -> Result<Vec<u8>, Problem> {
    let body: EnvelopeRequestBody = read_json(text)?;
    let mut faults = Faults::default();
    let positive = |pointer: &str, radius: f64, faults: &mut Faults| {
        if !(radius > 0.0 && radius <= 1e6) {
            faults.push(pointer, "a radius above 0 mm (and up to a kilometre)");
        }
    };
    match body.motion {
        Motion::Rack { pitch_radius } => positive("/motion/pitch_radius_mm", pitch_radius, &mut faults),
        Motion::Pinion { tool_pitch_radius, gear_pitch_radius, internal } => {
            positive("/motion/tool_pitch_radius_mm", tool_pitch_radius, &mut faults);
            positive("/motion/gear_pitch_radius_mm", gear_pitch_radius, &mut faults);
            if internal && tool_pitch_radius >= gear_pitch_radius {
                faults.push(
                    "/motion/tool_pitch_radius_mm",
                    "the tool rolls inside the gear: its radius is the smaller one",
                );
            }
        }
    }
    let [least, most] = body.radius_range_mm;
    if !(0.0 <= least && least < most && most <= 1e6) {
        faults.push("/radius_range_mm", "not an ascending range of radii");
    }
    for (k, pair) in body.radii_mm.iter().flat_map(|radii| radii.windows(2)).enumerate() {
        if !(pair[0] < pair[1]) {
            faults.push(format!("/radii_mm/{}", k + 1), "the radii do not ascend");
        }
    }
    let steps = body.tool.steps.unwrap_or(20);
    // each point of the tool may touch one; those tried in between are counted when they are there
    let points = ToolProfile::most_points(body.tool.points.len(), steps);
    room(points * (size_of::<ToolPoint>() + size_of::<Polar>()))?;
    let made = match body.tool.through.unwrap_or(ThroughName::Polyline) {
        ThroughName::Polyline => ToolProfile::polyline(&body.tool.points, steps),
        ThroughName::Spline => ToolProfile::spline(&body.tool.points, steps),
    };
    let profile = made.map_err(|more| faults.append(Faults::of_engine("/tool/points", &more))).ok();
    let Some(profile) = faults.into_result(profile).map_err(Problem::invalid)? else {
        return Err(Problem::internal("a tool's profile without a fault is none"));
    };
    let envelope = Envelope::of(&profile, body.motion, [least, most])
        .map_err(|fault| Problem::invalid(Faults::one("/motion", fault.to_string())))?;
    let touched: usize = envelope.branches.iter().map(Vec::len).sum();
    let radii = body.radii_mm.as_ref().map_or(0, Vec::len);
    room((touched + radii) * POINT)?;
    let half_angles = |radii: &Vec<f64>| envelope.boundary(radii).into_iter().map(|angle| angle.map(f64::to_degrees));
    let points = |branch: &Vec<Polar>| Values {
        width: 2,
        flat: branch.iter().flat_map(|place| place.point(1.0, 0.0)).collect(),
    };
    let body = EnvelopeBody {
        branches: envelope.branches.iter().map(points).collect(),
        half_angle_deg: body.radii_mm.as_ref().map(|radii| half_angles(radii).collect()),
    };
    whole(&body).map_err(Problem::not_finite)
}
