//! Measured points, or centres of a probe ball, become deviations.
//!
//! The centre of a ball that touches the flank lies one radius along the normal above the
//! touching point, so compensation is a subtraction from the normal distance.

use super::{
    Deviations, Direction, Foot, NoFoot, Node, Reference,
    foot::{foot, normal},
};
use crate::Side;
use flankfit_geometry::space::Vector;
use flankfit_numerics::{cancel::Asking, check::Faults, words::Shown};

/// No coordinate is larger, mm.
const MOST_COORDINATE: f64 = 1e7;

/// A measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredPoint {
    /// A point of the surface or the centre of the ball, mm; NaN in any coordinate: undefined.
    pub point: Vector,
    /// From 1, clockwise; `None`: the nearest.
    pub tooth: Option<u32>,
    /// `None`: the nearest, or the one that `normal` indicates.
    pub side: Option<Side>,
    /// Roughly the normal out of the material, of any length; it distinguishes the flanks of a
    /// tooth or of a gap.
    pub normal: Option<Vector>,
}

impl MeasuredPoint {
    /// A point of which only the place is known.
    pub fn anywhere(point: Vector) -> Self {
        MeasuredPoint { point, tooth: None, side: None, normal: None }
    }
}

/// Use of points without a flank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = StrayPoints)
)]
pub enum FootlessPoints {
    /// The request is refused, and names every one of them.
    #[default]
    Refuse,
    /// They count as undefined and are listed.
    Undefined,
}

/// How points were measured and what is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// mm; 0 for points of the surface.
    pub ball_radius: f64,
    /// Line along which deviations are to be taken.
    pub direction: Direction,
    /// How far from its flank a point may lie, mm. By default a quarter of the normal base pitch,
    /// at most [`Measurement::MOST_REACH`]; above half of it a point belongs to another tooth.
    pub reach: Option<f64>,
    /// Treatment of points without a foot.
    pub strays: FootlessPoints,
}

impl Default for Measurement {
    /// Points of the surface, deviations along the normal.
    fn default() -> Self {
        Measurement { ball_radius: 0.0, direction: Direction::Normal, reach: None, strays: FootlessPoints::Refuse }
    }
}

impl Measurement {
    /// Default of `reach` for large teeth, mm.
    pub const MOST_REACH: f64 = 2.0;

    /// The `reach` that holds, mm.
    pub fn reach(&self, reference: &Reference) -> f64 {
        self.reach.unwrap_or_else(|| Self::MOST_REACH.min(0.25 * normal_base_pitch(reference)))
    }

    fn check(&self, reference: &Reference) -> Result<(), Faults> {
        let mut faults = Faults::default();
        if !(self.ball_radius >= 0.0 && self.ball_radius <= 1e3) {
            let radius = Shown(self.ball_radius);
            faults.push("probe_radius_mm", format_args!("{radius} is not a radius of 0 to 1000 mm"));
        }
        if let Some(reach) = self.reach {
            let most = 0.5 * normal_base_pitch(reference);
            if !(reach > 0.0 && reach <= most) {
                let reach = Shown(reach);
                faults.push(
                    "reach_mm",
                    format_args!("{reach} is not above 0 and up to half the base pitch, {most:.4} mm"),
                );
            }
        }
        faults.into_result(())
    }
}

/// Distance between corresponding flanks of neighbouring teeth, mm.
fn normal_base_pitch(reference: &Reference) -> f64 {
    reference.gear.base_pitch() * reference.gear.base_helix_angle().cos()
}

/// The deviation of every point. Points with a coordinate that is NaN are undefined; one above 1e7
/// mm is an error.
///
/// ```
/// use flankfit_gear::{
///     Gear, GearData, Side,
///     deviation::{MeasuredPoint, Measurement, Reference, measure},
///     involute::Flank,
/// };
///
/// // A point 5 µm out of the material of a left flank.
/// let gear = Gear::new(GearData::spur(52, 1.0))?;
/// let place = Flank::new(&gear, Side::Left).at(9.0, 4.0);
/// let touch = MeasuredPoint::anywhere(place.point + 5e-3 * place.normal);
/// let found = measure(&Reference::new(&gear), &[touch], &Measurement::default())?;
/// assert!((found.nodes[0].deviation - 5.0).abs() < 1e-6);
/// assert!((found.nodes[0].roll_length - 9.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure(
    reference: &Reference,
    touches: &[MeasuredPoint],
    measurement: &Measurement,
) -> Result<Deviations, Faults> {
    measurement.check(reference)?;
    let reach = measurement.reach(reference);
    let mut faults = Faults::default();
    let mut strays = Vec::new();
    let mut nodes = Vec::with_capacity(touches.len());
    for (index, touch) in touches.iter().enumerate().asking(5000) {
        let undefined = Node {
            tooth: touch.tooth.unwrap_or(0),
            side: touch.side.unwrap_or(Side::Left),
            roll_length: f64::NAN,
            z: f64::NAN,
            deviation: f64::NAN,
            within: true,
        };
        if let Some(message) = touch.tooth.and_then(|tooth| reference.gear.no_such_tooth(tooth)) {
            faults.push(format_args!("teeth[{index}]"), message);
        } else if touch.point.iter().any(|x| x.abs() > MOST_COORDINATE) {
            let most = Shown(MOST_COORDINATE);
            faults.push(format_args!("points[{index}]"), format_args!("a coordinate exceeds {most} mm"));
        } else if !touch.point.iter().any(|x| x.is_nan()) {
            let found = nearest(reference, touch, measurement.ball_radius, reach)
                .and_then(|foot| reference.node(&foot, measurement.direction));
            match (found, measurement.strays) {
                (Ok(node), _) => {
                    nodes.push(node);
                    continue;
                }
                (Err(stray), FootlessPoints::Refuse) => faults.push(format_args!("points[{index}]"), stray),
                (Err(stray), FootlessPoints::Undefined) => strays.push((index, stray)),
            }
        }
        nodes.push(undefined);
    }
    faults.into_result(Deviations {
        direction: measurement.direction,
        ball_radius: measurement.ball_radius,
        nodes,
        strays,
    })
}

/// The foot within reach, on the nearer flank where none is named; of two errors that of the nearer
/// flank.
fn nearest(reference: &Reference, touch: &MeasuredPoint, ball: f64, reach: f64) -> Result<Foot, NoFoot> {
    let gear = reference.gear;
    let on = |side| {
        let found = foot(gear, side, touch.tooth, &touch.point, ball)?;
        let Foot { tooth, roll_length, z, .. } = found;
        match touch.normal {
            Some(given) if given.dot(&normal(gear, tooth, side, roll_length, z)) <= 0.0 => {
                Err(NoFoot::Against { tooth, side })
            }
            _ => within_reach(reference, found, reach),
        }
    };
    let Some(side) = touch.side else {
        return match (on(Side::Left), on(Side::Right)) {
            (Ok(left), Ok(right)) => Ok(if right.distance.abs() < left.distance.abs() { right } else { left }),
            (Err(NoFoot::Far { distance: left, .. }), Err(far @ NoFoot::Far { distance: right, .. }))
                if right.abs() < left.abs() =>
            {
                Err(far)
            }
            (Ok(foot), _) | (_, Ok(foot)) => Ok(foot),
            (Err(stray), _) => Err(stray),
        };
    };
    on(side)
}

/// Refuses feet that are far, or outside tip and root where the gear's data name these circles.
fn within_reach(reference: &Reference, foot: Foot, reach: f64) -> Result<Foot, NoFoot> {
    let Foot { distance, tooth, side, roll_length, .. } = foot;
    if !(distance.abs() <= reach) {
        return Err(NoFoot::Far { distance, reach, tooth, side });
    }
    let gear = reference.gear;
    let (diameter, outward) = (gear.diameter(roll_length), gear.outward());
    let circles = [(gear.data().tip_diameter, outward, true), (gear.data().root_diameter, -outward, false)];
    for (circle, beyond, tip) in circles {
        if let Some(circle) = circle
            && 0.5 * beyond * (diameter - circle) > reach
        {
            return Err(NoFoot::OffTooth { diameter, circle, tip, reach });
        }
    }
    Ok(foot)
}
