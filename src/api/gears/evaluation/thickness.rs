//! Tooth thickness from the places of contact of a file of curves.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use flankfit_engine::formats::klingelnberg::{Spread, Thickness};

/// Span and dimension over balls around the gear.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ToothThickness)]
pub struct ToothThicknessBody {
    /// k of W_k.
    pub span_teeth: usize,
    /// W_k.
    pub span_mm: ThicknessSpreadBody,
    /// Of the balls of M_dK.
    pub ball_diameter_mm: Option<f64>,
    /// M_dK: over two balls in opposite spaces, or nearly opposite ones of an odd number of teeth.
    pub over_balls_mm: Option<ThicknessSpreadBody>,
    /// x_E, the generating profile shift coefficient that follows from the mean W_k.
    pub profile_shift: f64,
}

/// A length over all places around the gear.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ThicknessSpread)]
pub struct ThicknessSpreadBody {
    /// Arithmetic mean.
    pub mean: f64,
    /// The least.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
}

impl From<Thickness> for ToothThicknessBody {
    fn from(found: Thickness) -> Self {
        let spread = |Spread { mean, least, greatest }: Spread| ThicknessSpreadBody { mean, least, greatest };
        ToothThicknessBody {
            span_teeth: found.teeth,
            span_mm: spread(found.span),
            ball_diameter_mm: found.ball,
            over_balls_mm: found.over_balls.map(spread),
            profile_shift: found.profile_shift,
        }
    }
}
