//! Left and right flanks on the wire.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use flankfit_engine::gear::Side;

/// A flank of a tooth that points up, seen with the axis towards the viewer; on internal gears too,
/// where the tooth at the top points down and the left flank lies at negative x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = FlankSide)]
pub enum SideName {
    Left,
    Right,
}

impl From<SideName> for Side {
    fn from(name: SideName) -> Self {
        match name {
            SideName::Left => Side::Left,
            SideName::Right => Side::Right,
        }
    }
}

impl From<Side> for SideName {
    fn from(side: Side) -> Self {
        match side {
            Side::Left => SideName::Left,
            Side::Right => SideName::Right,
        }
    }
}
