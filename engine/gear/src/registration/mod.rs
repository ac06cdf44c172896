//! Registration: how the measured part lies in the nominal one, and the deviations without that.
//!
//! Deviations of a part that is displaced by small motions p are `d ≈ X p + form`, with the columns
//! X of [`columns`]; p is a fit of [`flankfit_estimation`], so regularisation, estimators, bias
//! bounds and collinearity are those of fits. Motions are not small enough to be linear to the last
//! digit: with the exact inverse motion ([`pose`]) the points are carried back, their deviations
//! d_k are taken anew at the pose p_k, and the whole p is fitted to `d_k + X_k p_k` (Gauss–Newton;
//! not its step, so that a regularised p stays regularised however often this is repeated). Columns
//! have the normals of the unmodified flank.
//!
//! Motions are those *of the part*: a part that was moved by p on purpose is answered with p. A
//! part that may lie anywhere begins where [`mod@start`] finds it.

mod answer;
pub mod columns;
mod misfit;
mod nearest;
mod part;
pub mod pose;
mod refine;
mod scan;
mod search;
mod solve;
pub mod start;
mod teeth;

pub use pose::{Motion, Pose};
pub use solve::{register, register_from};
pub use start::{Start, start};

use super::deviation::Deviations;
use crate::warning::Warning;
use flankfit_estimation::{FitResult, FitSpec};

/// Specification of a registration.
#[derive(Clone, Debug)]
pub struct Registering<'a> {
    /// Which motions are free, in any order.
    pub motions: &'a [Motion],
    /// z of the point about which the axis tilts, mm; by default the middle of the nodes that take
    /// part.
    pub pivot: Option<f64>,
    /// For each node, as in a fit; by default 1.
    pub weight: Option<&'a [f64]>,
    /// Model `linear`; everything else as in any fit. Heights are normal deviations in µm.
    pub spec: &'a FitSpec,
}

/// Motion of the part.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, utoipa::ToSchema),
    schema(as = PartMotion)
)]
pub struct Moved {
    /// The motion.
    pub motion: Motion,
    /// Displacement of the part, in `unit`.
    pub value: f64,
    /// Start of the fit, 0 except for parts displaced by more than a tenth of the module:
    /// coefficients of `result`, and their regularisation, refer to it.
    pub start: f64,
    /// `um` or `urad`.
    pub unit: &'static str,
    /// Standard error from the independent scatter of the points: it does not cover common
    /// displacements of all points of a flank, as by a pitch deviation (docs/reference/gears.md).
    /// Absent if the points do not determine the motion. If λ* was chosen by these points it is too
    /// small, as in any fit.
    pub std_error: Option<f64>,
    /// Sharp bound of the displacement by regularisation, given the limit of the coefficients'
    /// norm.
    pub bias_bound: Option<f64>,
    /// True if these points distinguish it from the other free motions.
    pub determined: bool,
}

/// Motions that these points do not tell apart well, or at all.
#[derive(Clone, Debug, PartialEq)]
pub struct Indistinguishable {
    /// These motions, the leading one first.
    pub motions: Vec<Motion>,
    /// √(λₙ/λᵢ); `None` where it is infinite.
    pub condition_index: Option<f64>,
    /// The same in words.
    pub sentence: String,
}

/// Motions of the part that were found; the deviations are those of the part carried back.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, utoipa::ToSchema))]
pub struct Registration {
    /// One entry for each free motion, in the order `x_shift`, `y_shift`, `axial_shift`, `x_tilt`,
    /// `y_tilt`, `rotation`.
    pub motions: Vec<Moved>,
    /// Position of the part: all motions together.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub pose: Pose,
    /// z of the point about which the axis tilts.
    pub pivot_z_mm: f64,
    /// Root mean square of the deviations as they were measured.
    pub rms_before_um: f64,
    /// Root mean square of the deviations after the part has been carried back.
    pub rms_after_um: f64,
    /// Number of linearisations.
    pub iterations: usize,
    /// True if the last step was within the tolerance.
    pub converged: bool,
    /// Motions that these points do not distinguish.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub indistinguishable: Vec<Indistinguishable>,
    /// The last fit; its coefficients are [`columns::Column`]s, its heights and residuals normal
    /// deviations.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub fit: FitResult,
    /// Plain least squares with a column for every motion (spectrum, collinearity), where the fit
    /// has fewer.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub every_motion: Option<FitResult>,
    /// Which node each row of the fit belongs to.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub rows: Vec<usize>,
    /// The deviations of the part carried back, in the order of the nodes.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub deviations: Deviations,
    /// Warnings that the fit does not give.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub warnings: Vec<Warning>,
}
