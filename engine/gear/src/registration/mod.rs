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

/// What is asked for.
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

/// One of the free motions.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Which motion.
    pub motion: Motion,
    /// µm or µrad.
    pub value: f64,
    /// Where the fit began: its coefficients, and what regularisation damps, count from there. 0
    /// but for parts that lie far off.
    pub start: f64,
    /// `None` for a motion that the points do not determine.
    pub std_error: Option<f64>,
    /// Sharp bound on what regularisation moved, given the limit of the coefficients' norm; `None`
    /// for a motion that the points do not determine.
    pub bias_bound: Option<f64>,
    /// Whether these points tell it from the other free motions.
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

/// The answer.
#[derive(Clone, Debug)]
pub struct Registration {
    /// The free motions in the order of [`Motion::ALL`].
    pub motions: Vec<Moved>,
    /// How the part lies: all motions together.
    pub pose: Pose,
    /// √mean of the squared deviations that take part, µm, in their direction.
    pub rms_before: f64,
    /// The same with the part carried back.
    pub rms_after: f64,
    /// Steps of the iteration.
    pub iterations: usize,
    /// Whether the last step was within the tolerance.
    pub converged: bool,
    /// Near dependencies between the free motions.
    pub indistinguishable: Vec<Indistinguishable>,
    /// The last fit; its coefficients are [`columns::Column`]s, its heights and residuals normal
    /// deviations.
    pub fit: FitResult,
    /// Plain least squares with a column for every motion (spectrum, collinearity), where the fit
    /// has fewer.
    pub every_motion: Option<FitResult>,
    /// Which node each row of the fit belongs to.
    pub rows: Vec<usize>,
    /// The deviations of the part carried back, in the order of the nodes.
    pub deviations: Deviations,
    /// What the fit does not say.
    pub warnings: Vec<Warning>,
}
