//! What follows from a gear's data.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    gears::{gear::GearBody, notice::NoticeBody},
    json::{value::read_json, writer},
    problem::Problem,
};
use flankfit_engine::gear::{
    Geometry,
    geometry::{Arc, Balls, Span, Usable},
};

/// A gear.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = GearGeometryRequest)]
pub struct GeometryRequestBody {
    pub gear: GearBody,
}

/// Derived quantities (ISO 21771). Diameters and thicknesses are positive, on internal gears too;
/// what a gear has not got is left out.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearGeometry)]
pub struct GeometryBody {
    /// d = z m_n / cos β.
    pub reference_diameter_mm: f64,
    /// d_b = d cos α_t.
    pub base_diameter_mm: f64,
    /// d ± 2 x m_n.
    pub shifted_diameter_mm: f64,
    /// As given, or with an addendum of (1 + x) m_n.
    pub tip_diameter_mm: f64,
    /// As given, or as the tool's addendum says.
    pub root_diameter_mm: f64,
    /// What the rack tool cuts.
    pub generated_root_diameter_mm: Option<f64>,
    /// Where the involute really starts: the end of fillet or undercut.
    pub form_diameter_mm: f64,
    /// Where it ends: the tip, or the point of a pointed tooth.
    pub tip_form_diameter_mm: f64,
    /// Where the flanks of a tooth would meet.
    pub pointed_diameter_mm: Option<f64>,
    /// Roll length at the form diameter, where the involute ends towards the root.
    pub form_roll_length_mm: f64,
    /// Roll length at the tip form diameter, where the involute ends towards the tip.
    pub tip_form_roll_length_mm: f64,
    /// The part of the flank that is involute and really there; left out where none is.
    pub usable_profile: Option<UsableProfileBody>,
    /// m_t = m_n / cos β.
    pub transverse_module_mm: f64,
    /// α_t, at the reference diameter.
    pub transverse_pressure_angle_deg: f64,
    /// β_b, never negative; the hand is that of the gear.
    pub base_helix_angle_deg: f64,
    /// inv α_t = tan α_t − α_t, rad.
    pub involute: f64,
    /// p_t, on the reference circle.
    pub transverse_pitch_mm: f64,
    /// p_n = π m_n.
    pub normal_pitch_mm: f64,
    /// p_x; left out for spur gears, which have none.
    pub axial_pitch_mm: Option<f64>,
    /// Height of one turn of the helix.
    pub lead_mm: Option<f64>,
    /// p_bt, on the base circle.
    pub transverse_base_pitch_mm: f64,
    /// p_bn, at right angles to the flanks.
    pub normal_base_pitch_mm: f64,
    /// On the reference circle, in the transverse section.
    pub tooth_thickness_mm: f64,
    /// On the reference cylinder, across the helix.
    pub normal_tooth_thickness_mm: f64,
    /// Transverse width of a tooth space on the reference circle.
    pub space_width_mm: f64,
    /// Normal width of a tooth space on the reference cylinder.
    pub normal_space_width_mm: f64,
    /// 0 where the tooth is pointed.
    pub tip_thickness_mm: f64,
    /// Normal thickness of a tooth at its tip; 0 and less would be a pointed tooth.
    pub normal_tip_thickness_mm: f64,
    /// Transverse thickness of a tooth on the base circle.
    pub base_thickness_mm: f64,
    /// ψ, on the reference circle.
    pub half_tooth_angle_deg: f64,
    /// h, half the difference of tip and root diameter.
    pub tooth_depth_mm: f64,
    /// z_n, teeth of the spur gear that a helical gear resembles in its normal section.
    pub virtual_teeth: f64,
    /// The smallest profile shift without undercut by the rack tool.
    pub least_profile_shift_coefficient: Option<f64>,
    /// Whether the tool cuts into the involute near the root.
    pub undercut: bool,
    pub span: Option<SpanBody>,
    pub balls: Option<BallsBody>,
    /// What to know about the gear: undercut, a pointed tip and the like; empty where there is
    /// nothing to say.
    pub warnings: Vec<NoticeBody>,
}

/// The involute that is there, its root end first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = UsableProfile)]
pub struct UsableProfileBody {
    /// `[root end, tip end]`.
    #[schema(min_items = 2, max_items = 2)]
    pub diameters_mm: [f64; 2],
    /// The same as roll lengths.
    #[schema(min_items = 2, max_items = 2)]
    pub roll_lengths_mm: [f64; 2],
}

/// Span measurement over k teeth (internal spur gears: spaces).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SpanMeasurement)]
pub struct SpanBody {
    /// k, the number of teeth (of internal gears: spaces) that are spanned.
    pub teeth: u32,
    /// W_k.
    pub length_mm: f64,
    /// Diameter on which the measuring faces touch the flanks.
    pub contact_diameter_mm: f64,
    /// The least face width with which a helical gear can be measured so.
    pub least_face_width_mm: f64,
    /// Whether it can be measured: the contact lies on the usable flank and the face is wide
    /// enough.
    pub feasible: bool,
}

/// Dimension over two balls, between them on internal gears.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = DimensionOverBalls)]
pub struct BallsBody {
    /// Diameter of the balls, as asked for.
    pub ball_diameter_mm: f64,
    /// M_dK: over two balls in opposite spaces (of an odd number of teeth in those nearest to
    /// opposite).
    pub dimension_mm: f64,
    /// Diameter of the circle on which the centres of the balls lie.
    pub centre_diameter_mm: f64,
    /// Diameter on which the balls touch the flanks.
    pub contact_diameter_mm: f64,
    /// Whether the balls touch on the usable flank and stand out of the teeth.
    pub feasible: bool,
}

/// Answers a request.
pub fn answer(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let body: GeometryRequestBody = read_json(text)?;
    let gear = body.gear.checked("/gear").map_err(Problem::invalid)?;
    let geometry = Geometry::of(&gear);
    let warnings = warnings(&body.gear, &geometry);
    writer::whole(&GeometryBody::new(geometry, warnings)).map_err(Problem::not_finite)
}

/// What is unusual about a gear, and what its data leave open.
pub(in crate::api) fn warnings(body: &GearBody, geometry: &Geometry) -> Vec<NoticeBody> {
    let mut warnings: Vec<NoticeBody> = geometry.warnings.iter().map(NoticeBody::from).collect();
    warnings.extend(body.hand_assumed());
    warnings
}

impl GeometryBody {
    fn new(geometry: Geometry, warnings: Vec<NoticeBody>) -> Self {
        let Arc { transverse: tooth_thickness_mm, normal: normal_tooth_thickness_mm } = geometry.tooth_thickness;
        let Arc { transverse: space_width_mm, normal: normal_space_width_mm } = geometry.space_width;
        let Arc { transverse: tip_thickness_mm, normal: normal_tip_thickness_mm } = geometry.tip_thickness;
        GeometryBody {
            reference_diameter_mm: geometry.reference_diameter,
            base_diameter_mm: geometry.base_diameter,
            shifted_diameter_mm: geometry.shifted_diameter,
            tip_diameter_mm: geometry.tip_diameter,
            root_diameter_mm: geometry.root_diameter,
            generated_root_diameter_mm: geometry.generated_root_diameter,
            form_diameter_mm: geometry.root_form_diameter,
            tip_form_diameter_mm: geometry.tip_form_diameter,
            pointed_diameter_mm: geometry.pointed_diameter,
            form_roll_length_mm: geometry.roll_length_root_form,
            tip_form_roll_length_mm: geometry.roll_length_tip_form,
            usable_profile: geometry.usable.map(|Usable { diameters, roll_lengths }| UsableProfileBody {
                diameters_mm: diameters,
                roll_lengths_mm: roll_lengths,
            }),
            transverse_module_mm: geometry.transverse_module,
            transverse_pressure_angle_deg: geometry.transverse_pressure_angle.to_degrees(),
            base_helix_angle_deg: geometry.base_helix_angle.to_degrees(),
            involute: geometry.involute,
            transverse_pitch_mm: geometry.transverse_pitch,
            normal_pitch_mm: geometry.normal_pitch,
            axial_pitch_mm: geometry.axial_pitch,
            lead_mm: geometry.lead,
            transverse_base_pitch_mm: geometry.transverse_base_pitch,
            normal_base_pitch_mm: geometry.normal_base_pitch,
            tooth_thickness_mm,
            normal_tooth_thickness_mm,
            space_width_mm,
            normal_space_width_mm,
            tip_thickness_mm,
            normal_tip_thickness_mm,
            base_thickness_mm: geometry.base_thickness,
            half_tooth_angle_deg: geometry.half_tooth_angle.to_degrees(),
            tooth_depth_mm: geometry.tooth_depth,
            virtual_teeth: geometry.virtual_teeth,
            least_profile_shift_coefficient: geometry.least_profile_shift,
            undercut: geometry.undercut,
            span: geometry.span.map(SpanBody::from),
            balls: geometry.balls.map(BallsBody::from),
            warnings,
        }
    }
}

impl From<Span> for SpanBody {
    fn from(span: Span) -> Self {
        let Span { teeth, length, contact_diameter, least_face_width, feasible } = span;
        SpanBody {
            teeth,
            length_mm: length,
            contact_diameter_mm: contact_diameter,
            least_face_width_mm: least_face_width,
            feasible,
        }
    }
}

impl From<Balls> for BallsBody {
    fn from(balls: Balls) -> Self {
        let Balls { ball_diameter, dimension, centre_diameter, contact_diameter, feasible } = balls;
        BallsBody {
            ball_diameter_mm: ball_diameter,
            dimension_mm: dimension,
            centre_diameter_mm: centre_diameter,
            contact_diameter_mm: contact_diameter,
            feasible,
        }
    }
}
