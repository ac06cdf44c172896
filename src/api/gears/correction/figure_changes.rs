//! Figures of a flank before a correction and after, with their errors.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use flankfit_engine::gear::{
    correction::FigureChange,
    evaluation::flank_surface::{EstimatedFigure, FlankFigures},
};

/// Figures as `figures` has them, each left out where the nodes do not tell it.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FigureChanges)]
pub struct FigureChangesBody {
    /// f_Hα.
    pub profile_slope: Option<FigureChangeBody>,
    /// f_Hβ.
    pub helix_slope: Option<FigureChangeBody>,
    /// C_α.
    pub profile_crowning: Option<FigureChangeBody>,
    /// C_β.
    pub helix_crowning: Option<FigureChangeBody>,
    /// 4 c_uv of the surface.
    pub twist: Option<FigureChangeBody>,
}

/// A figure before, as predicted and as measured, by the chosen fits of the iterations as `figures`
/// has it, else over the nodes that are defined in all three.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FigureChange)]
pub struct FigureChangeBody {
    /// Of the deviations that the correction was made for.
    pub before: EstimatedFigureBody,
    /// What the correction predicted, in µm.
    pub predicted_um: f64,
    /// Of the deviations measured after it.
    pub measured: EstimatedFigureBody,
    /// Measured less before. The error is that of the differences node by node: form that both
    /// measurements share has no part in it.
    pub change: EstimatedFigureBody,
    /// Measured less predicted, likewise. An interval that holds 0 is no sign that the machine does
    /// anything else than was predicted.
    pub beyond_predicted: EstimatedFigureBody,
}

/// A figure with the error that the residuals of its own surface say.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EstimatedFigure)]
pub struct EstimatedFigureBody {
    /// In µm.
    pub value_um: f64,
    /// In µm; left out without degrees of freedom.
    pub std_error_um: Option<f64>,
    /// `[low, high]` of the true figure in µm, Student's at 0.95; left out without degrees of
    /// freedom.
    #[schema(min_items = 2, max_items = 2)]
    pub interval_um: Option<[f64; 2]>,
}

impl From<FlankFigures<FigureChange>> for FigureChangesBody {
    fn from(changes: FlankFigures<FigureChange>) -> Self {
        let FlankFigures { profile_slope, helix_slope, profile_crowning, helix_crowning, twist } =
            changes.map(FigureChangeBody::from);
        FigureChangesBody { profile_slope, helix_slope, profile_crowning, helix_crowning, twist }
    }
}

impl From<FigureChange> for FigureChangeBody {
    fn from(change: FigureChange) -> Self {
        FigureChangeBody {
            before: change.before.into(),
            predicted_um: change.predicted,
            measured: change.measured.into(),
            change: change.change.into(),
            beyond_predicted: change.beyond_predicted.into(),
        }
    }
}

impl From<EstimatedFigure> for EstimatedFigureBody {
    fn from(figure: EstimatedFigure) -> Self {
        EstimatedFigureBody { value_um: figure.value, std_error_um: figure.std_error, interval_um: figure.interval }
    }
}
