//! The place of a flank that is nearest to a measured point.

use crate::{
    Gear, Side,
    deviation::{
        Foot, MeasuredPoint,
        foot::{foot, normal},
    },
};
use flankfit_geometry::space::Vector;

/// The nearest foot on the flanks that a point may belong to.
pub(super) fn nearest(gear: &Gear, touch: &MeasuredPoint, ball: f64) -> Option<Foot> {
    let on = |side: Side| {
        let found = foot(gear, side, touch.tooth, &touch.point, ball).ok()?;
        let along = |given: Vector| given.dot(&normal(gear, found.tooth, side, found.roll_length, found.z)) > 0.0;
        touch.normal.is_none_or(along).then_some(found)
    };
    match touch.side {
        Some(side) => on(side),
        None => match (on(Side::Left), on(Side::Right)) {
            (Some(left), Some(right)) if right.distance.abs() < left.distance.abs() => Some(right),
            (left, right) => left.or(right),
        },
    }
}
