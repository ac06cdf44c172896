//! A simulated closed loop, as it is answered.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

/// Result of the simulation.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ClosedLoop)]
pub struct ClosedLoopResultBody {
    /// The seed that was used: the same seed gives the same runs.
    pub seed: u64,
    /// Condition of JᵀJ, in the units of the request; absent where settings are linearly dependent.
    pub condition: Option<f64>,
    /// One run for each correction method, all on the same machine.
    pub runs: Vec<ClosedLoopRunBody>,
}

/// One correction method.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ClosedLoopRun)]
pub struct ClosedLoopRunBody {
    /// Method of the corrections, such as `least_squares`, or the regularisation and its criterion.
    pub strategy: String,
    /// The stored job.
    pub job_id: Option<Uuid>,
    /// Measurements: the first one, and one after each correction.
    pub rounds: Vec<ClosedLoopRoundBody>,
}

/// A measurement and the correction that followed from it.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ClosedLoopRound)]
pub struct ClosedLoopRoundBody {
    /// Number of the iteration.
    pub iteration: u32,
    /// Root mean square of the measured deviations, µm.
    pub rms_measured_um: f64,
    /// Root mean square of the deviations without noise over all nodes, µm; known in a simulation
    /// only.
    pub rms_true_um: f64,
    /// Root mean square predicted by the correction, µm; absent after the last measurement.
    pub rms_predicted_um: Option<f64>,
    /// The changes of the settings.
    pub changes: Option<Vec<f64>>,
}
