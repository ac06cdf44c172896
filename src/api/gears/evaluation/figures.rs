//! The figures of a flank's second-order surface on the wire.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::conformity::ConformityBody;
use flankfit_engine::estimation::result::IntervalKind;
use flankfit_engine::gear::evaluation::{
    TraceFigures,
    flank_surface::{Figure, FlankSurface},
    within,
};

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
    /// 4 c_uv of the surface: how much more the profile slope is at the end of great z than at that
    /// of small z, over the whole evaluation ranges, by the sign asked for. On traces `twists` hold
    /// another figure of that name, between the sections that were measured.
    pub twist_um: FigureBody,
}

/// What the traces of a flank have in common, in µm over the evaluation range. A figure that they
/// do not tell is left out.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TraceSurfaceFigures)]
pub struct TraceFiguresBody {
    /// In the middle of the flank; only with `traces_share_zero`.
    pub mean_um: Option<FigureBody>,
    /// From root to tip in the middle of the width (without `twist_um` in the sections of the
    /// profiles); positive where material grows towards the tip.
    pub profile_slope_um: Option<FigureBody>,
    /// Over the width half-way between root and tip (without `twist_um` on the diameters of the
    /// helices), by the sign asked for.
    pub helix_slope_um: Option<FigureBody>,
    /// Positive where material stands out half-way between root and tip.
    pub profile_crowning_um: Option<FigureBody>,
    /// Positive where material stands out half-way between the ends.
    pub helix_crowning_um: Option<FigureBody>,
    /// 4 c_uv of the surface: slope at the tip minus slope at the root of helices over the
    /// **whole** evaluation ranges, from all traces together, with the sign of helix slopes.
    /// `twists` hold another figure of that name: the difference of two traces, between the
    /// sections that were measured.
    pub twist_um: Option<FigureBody>,
}

/// A figure with what is known of its error.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FlankFigure)]
pub struct FigureBody {
    /// The figure itself, in the unit that the name of its field ends in.
    pub value: f64,
    /// Standard error, by the noise that the residuals show or that was given; left out where
    /// neither tells it.
    pub std_error: Option<f64>,
    /// The one that takes a λ* for given which the nodes chose, and is too small.
    pub conditional_std_error: Option<f64>,
    /// Most by which regularisation moves it on average, for coefficients within the norm limit of
    /// the fit (`bias.coefficient_norm_limit`).
    pub bias_bound: f64,
    /// Without regularisation.
    pub least_squares: f64,
    /// Confidence interval of the true figure at `level`, `[low, high]`: of a regularised surface
    /// about least squares, unless a norm limit was given. Left out as `std_error` is.
    #[schema(min_items = 2, max_items = 2)]
    pub interval: Option<[f64; 2]>,
    pub interval_kind: Option<IntervalKind>,
    /// Of Student's distribution that the interval is of; left out where the noise is known.
    pub degrees_of_freedom: Option<f64>,
    /// Whether the estimate itself lies within its limits (`tolerance_limits`); there where the
    /// figure has some and is not extrapolated (`range_not_covered`).
    pub within: Option<bool>,
    /// There where `within` is and the figure has an interval.
    pub conformity: Option<ConformityBody>,
}

impl From<Figure> for FigureBody {
    fn from(figure: Figure) -> Self {
        let Figure { value, std_error, conditional_std_error, bias_bound, least_squares, limits, inference } = figure;
        FigureBody {
            value,
            std_error,
            conditional_std_error,
            bias_bound,
            least_squares,
            interval: inference.map(|one| one.interval),
            interval_kind: inference.map(|one| one.kind),
            degrees_of_freedom: inference.map(|one| one.about.student.freedom()).filter(|freedom| freedom.is_finite()),
            within: within(value, limits),
            conformity: inference.and_then(|one| one.conformity).map(Into::into),
        }
    }
}

impl From<TraceFigures> for TraceFiguresBody {
    fn from(figures: TraceFigures) -> Self {
        TraceFiguresBody {
            mean_um: figures.mean.map(Into::into),
            profile_slope_um: figures.profile_slope.map(Into::into),
            helix_slope_um: figures.helix_slope.map(Into::into),
            profile_crowning_um: figures.profile_crowning.map(Into::into),
            helix_crowning_um: figures.helix_crowning.map(Into::into),
            twist_um: figures.twist.map(Into::into),
        }
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
