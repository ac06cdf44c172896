//! Measured points or deviations of a flank, and what is asked of them.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::borders::BordersBody;
use crate::api::{
    faults::{Faults, moved},
    fits::{reader::fields, spec::request::FitFields},
    gears::{
        design::modification::{ModificationBody, ModificationRangeBody},
        gear::GearBody,
    },
    json::{
        error::ReadError,
        members::{of_object, of_request},
        numbers::read_rows_of_heights,
        request::request,
    },
    warning::WarningBody,
};
use flankfit_engine::{
    estimation::FitSpec,
    gear::{
        Gear, Side,
        deviation::{FootlessPoints, MeasuredPoint, Measurement, Topography},
        registration::Motion,
        trace::Direction,
    },
    geometry::space::Vector,
    numerics::{Rows, check},
    words::{Shown, entries},
};

request! {
    /// Points measured on a gear (`points`), or deviations of one flank on a grid (`grid`).
    #[schema(as = GearDeviationsRequest)]
    pub struct DeviationsRequestBody as DeviationsMembers {
        /// Optional if the points belong to a job that has it.
        optional gear: GearBody,
        /// `[x, y, z]` of each point, mm; `null` where undefined. The tooth at the top (+y) in z =
        /// 0 is tooth 1.
        #[schema(max_items = 2_000_000)]
        optional points: Vec<Option<[f64; 3]>>,
        /// The tooth of each point, counted clockwise from 1 as the viewer sees it. By default the
        /// nearest; a registration then returns the rotation up to whole pitches (warning
        /// `rotation_modulo_pitch`). With `teeth` and `flanks` it finds any rotation of the full
        /// circle.
        optional teeth: Vec<u32>,
        /// The flank of each point. By default the nearest, after a registration that of the
        /// registered part.
        optional flanks: Vec<Side>,
        optional grid: DeviationGridBody,
        /// Modifications of the involute, superposed: deviations refer to the modified flank.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        required modifications: Vec<ModificationBody>,
        optional modification_range: ModificationRangeBody,
        /// Radius of the ball whose centres `points` are; 0 if they lie on the surface. Default 0.
        #[schema(minimum = 0)]
        optional probe_radius_mm: f64,
        /// Direction of the deviations. Default `normal`.
        optional direction: Direction,
        /// Greatest distance of a point from its flank. By default a quarter of the base pitch, at
        /// most 2 mm.
        #[schema(exclusive_minimum = 0)]
        optional reach_mm: f64,
        /// Use of points that belong to no flank. Default `refuse`.
        optional strays: FootlessPoints,
        optional borders: BordersBody,
        /// Best fit of the part to the nominal gear before its deviations are computed. `points`
        /// may be turned by any angle, and off centre by up to two modules if shifts are free: the
        /// start of the fit is searched.
        optional registration: RegistrationRequestBody,
        /// For the registration.
        flatten fit: FitFields,
    }
}

request! {
    /// Deviations where roll lengths (or diameters) and z cross.
    #[serde(deny_unknown_fields)]
    #[schema(as = DeviationGrid)]
    pub struct DeviationGridBody as DeviationGridMembers {
        /// Tooth, counted clockwise from 1, the tooth at the top. By default that of the iteration
        /// of the record, else 1.
        optional tooth: u32,
        required flank: Side,
        /// Ascending; either these …
        optional roll_length_mm: Vec<f64>,
        /// … or these.
        optional diameter_mm: Vec<f64>,
        /// Ascending.
        required z_mm: Vec<f64>,
        /// Deviations from the unmodified involute. A row for each roll length; `null` where
        /// undefined.
        required deviation_um: Vec<Vec<Option<f64>>>,
    }
}

/// Rigid motions of the part that are estimated and undone.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = RegistrationRequest)]
pub struct RegistrationRequestBody {
    /// Free motions.
    #[schema(min_items = 1, max_items = 6)]
    pub motions: Vec<Motion>,
    /// z of the point about which the axis tilts. By default the middle of the nodes.
    pub pivot_z_mm: Option<f64>,
}

/// A request, read and checked, all but what needs the gear.
pub struct CheckedDeviations {
    pub gear: Option<Gear>,
    pub hand_assumed: Option<WarningBody>,
    pub given: Given,
    pub modifications: Vec<ModificationBody>,
    pub modification_range: Option<ModificationRangeBody>,
    pub direction: Direction,
    pub borders: Option<BordersBody>,
    pub registration: Option<(Vec<Motion>, Option<f64>)>,
    pub spec: FitSpec,
}

/// Data that deviations are computed from.
pub enum Given {
    Points { touches: Vec<MeasuredPoint>, measurement: Measurement },
    Grid(DeviationGrid),
}

impl Given {
    /// How many nodes are given.
    pub fn count(&self) -> usize {
        match self {
            Given::Points { touches, .. } => touches.len(),
            Given::Grid(grid) => grid.deviation.values().len(),
        }
    }
}

/// A grid, read, all but what needs the gear.
pub struct DeviationGrid {
    pub tooth: Option<u32>,
    flank: Side,
    roll_length: Option<Vec<f64>>,
    diameter: Option<Vec<f64>>,
    z: Vec<f64>,
    deviation: Rows,
}

/// Reads a request, all but what needs the gear.
pub fn read(text: &[u8], faults: &mut Faults) -> Result<Option<CheckedDeviations>, ReadError> {
    let members: DeviationsMembers<'_> = of_request(text, faults)?;
    let before = faults.count();
    let gear = members.gear.read(faults);
    let hand_assumed = gear.as_ref().and_then(GearBody::hand_assumed);
    let gear = gear.and_then(|gear| gear.checked("/gear").map_err(|more| faults.append(more)).ok());
    let direction = members.direction.read(faults).map_or(Direction::Normal, Into::into);
    let given = given(&members, direction, faults);
    let modifications = members.modifications.read(faults);
    let modification_range = members.modification_range.read(faults);
    let borders = members.borders.read(faults);
    let registration = members.registration.read(faults);
    let registration = registration.map(|body| (body.motions, body.pivot_z_mm));
    let unfit = (!members.registration.is_given()).then_some("it belongs to a `registration`, which fits");
    let spec = fields::read(&members.fit, unfit, faults);
    let (Some(given), Some(spec)) = (given, spec) else { return Ok(None) };
    Ok((faults.count() == before).then_some(CheckedDeviations {
        gear,
        hand_assumed,
        given,
        modifications: modifications.unwrap_or_default(),
        modification_range,
        direction,
        borders,
        registration,
        spec,
    }))
}

fn given(members: &DeviationsMembers<'_>, direction: Direction, faults: &mut Faults) -> Option<Given> {
    match (members.points.is_given(), members.grid.is_given()) {
        (true, false) => touches(members, faults).map(|touches| {
            let measurement = Measurement {
                ball_radius: members.probe_radius_mm.read(faults).unwrap_or(0.0),
                direction,
                reach: members.reach_mm.read(faults),
                strays: members.strays.read(faults).unwrap_or_default(),
            };
            Given::Points { touches, measurement }
        }),
        (false, true) => {
            let of_points = [
                members.teeth.name_if_given(),
                members.flanks.name_if_given(),
                members.probe_radius_mm.name_if_given(),
                members.reach_mm.name_if_given(),
                members.strays.name_if_given(),
            ];
            for name in of_points.into_iter().flatten() {
                faults.push(format!("/{name}"), "it belongs to `points`; a `grid` holds deviations already");
            }
            members.grid.optional_with(faults, DeviationGrid::read).map(Given::Grid)
        }
        (false, false) => {
            faults.push_missing("/points", "missing; give `points` or `grid`");
            None
        }
        (true, true) => {
            faults.push("/grid", "give `points` or `grid`, not both");
            None
        }
    }
}

fn touches(members: &DeviationsMembers<'_>, faults: &mut Faults) -> Option<Vec<MeasuredPoint>> {
    let points = members.points.optional(faults).flatten()?;
    let teeth = members.teeth.read(faults);
    let flanks = members.flanks.read(faults);
    if points.is_empty() {
        faults.push("/points", "there are no points");
        return None;
    }
    let before = faults.count();
    let lengths = [("/teeth", teeth.as_ref().map(Vec::len)), ("/flanks", flanks.as_ref().map(Vec::len))];
    for (pointer, length) in lengths {
        if let Some(length) = length.filter(|length| *length != points.len()) {
            faults.push(pointer, format!("{} for {} points", entries(length), points.len()));
        }
    }
    let each = points.iter().enumerate().map(|(k, point)| MeasuredPoint {
        point: point.map_or(Vector::repeat(f64::NAN), |[x, y, z]| Vector::new(x, y, z)),
        tooth: teeth.as_ref().and_then(|teeth| teeth.get(k)).copied(),
        side: flanks.as_ref().and_then(|flanks| flanks.get(k)).copied(),
        normal: None,
    });
    (faults.count() == before).then(|| each.collect())
}

impl DeviationGrid {
    fn read(text: &[u8], at: &str, faults: &mut Faults) -> Option<Self> {
        let before = faults.count();
        let members: DeviationGridMembers<'_> = of_object(text, at, faults)?;
        let tooth = members.tooth.read(faults);
        let flank = members.flank.required(faults);
        let (roll_length, diameter) = (members.roll_length_mm.read(faults), members.diameter_mm.read(faults));
        let z = members.z_mm.required(faults);
        let deviation = members.deviation_um.required_with(faults, read_rows_of_heights);
        let (Some(flank), Some(z), Some((values, lengths))) = (flank, z, deviation) else { return None };
        let deviation = Rows::new(values, lengths);
        (faults.count() == before).then_some(DeviationGrid { tooth, flank, roll_length, diameter, z, deviation })
    }

    /// Faults of the topography by their places in the request, whose profile may be given by
    /// diameters.
    pub fn placed(&self, faults: check::Faults) -> Faults {
        let profile = if self.diameter.is_some() { "/grid/diameter_mm" } else { "/grid/roll_length_mm" };
        Faults::placed(&faults.within("grid"), |path| moved(path, &[("grid.roll_length_mm", profile)]))
    }

    /// The topography, whose deviations are taken out, once its gear is known; `own` is the tooth
    /// of the iteration that it is kept with.
    pub fn take_topography(
        &mut self,
        gear: &Gear,
        direction: Direction,
        own: Option<u32>,
    ) -> Result<Topography, Faults> {
        let mut faults = Faults::default();
        let roll_length = match (&self.roll_length, &self.diameter) {
            (Some(lengths), None) => lengths.clone(),
            (None, Some(diameters)) => {
                let mut lengths = Vec::with_capacity(diameters.len());
                for (k, &diameter) in diameters.iter().enumerate() {
                    match gear.roll_length(diameter) {
                        Some(length) => lengths.push(length),
                        None => {
                            let detail = format!("{} mm lies below the base circle", Shown(diameter));
                            faults.push(format!("/grid/diameter_mm/{k}"), detail);
                        }
                    }
                }
                lengths
            }
            _ => {
                faults.push("/grid", "give either `roll_length_mm` or `diameter_mm`");
                Vec::new()
            }
        };
        faults.into_result(Topography {
            tooth: self.tooth.or(own.filter(|own| *own <= gear.data().teeth)).unwrap_or(1),
            side: self.flank,
            roll_length,
            z: self.z.clone(),
            deviation: std::mem::take(&mut self.deviation),
            direction,
        })
    }
}
