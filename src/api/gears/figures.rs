//! The figures of a flank's second-order surface on the wire.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::gear::evaluation::flank_surface::{Figure, FlankSurface};

/// What the deviations of a flank have in common, in µm over the evaluation range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SurfaceFigures)]
pub struct FiguresBody {
    /// In the middle of the flank.
    pub mean_um: FigureBody,
    /// From root to tip; positive where material grows towards the tip.
    pub profile_slope_um: FigureBody,
    /// Over the width, by the sign asked for.
    pub helix_slope_um: FigureBody,
    /// Positive where material stands out half-way between root and tip.
    pub profile_crowning_um: FigureBody,
    pub helix_crowning_um: FigureBody,
    /// 4 c_uv, by the sign asked for.
    pub twist_um: FigureBody,
}

/// A figure with what is known of its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FlankFigure)]
pub struct FigureBody {
    /// The figure itself, in the unit that the name of its field ends in.
    pub value: f64,
    /// Standard error, by the noise that the residuals show or that was given; left out where neither tells it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
    /// Most by which regularisation can have moved it.
    pub bias_bound: f64,
    /// Without regularisation.
    pub least_squares: f64,
}

impl From<Figure> for FigureBody {
    fn from(figure: Figure) -> Self {
        let Figure { value, std_error, bias_bound, least_squares } = figure;
        FigureBody { value, std_error, bias_bound, least_squares }
    }
}

impl From<&FlankSurface> for FiguresBody {
    fn from(surface: &FlankSurface) -> Self {
        FiguresBody {
            mean_um: surface.mean.into(),
            profile_slope_um: surface.profile_slope.into(),
            helix_slope_um: surface.helix_slope.into(),
            profile_crowning_um: surface.profile_crowning.into(),
            helix_crowning_um: surface.helix_crowning.into(),
            twist_um: surface.twist.into(),
        }
    }
}
