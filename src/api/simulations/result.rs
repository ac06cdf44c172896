//! A simulated closed loop, as it is answered.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

/// What became of the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ClosedLoop)]
pub struct ClosedLoopResultBody {
    /// The seed that was used: the same one gives the same runs.
    pub seed: u64,
    /// Condition of JᵀJ, as posted; left out where settings depend on each other exactly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// One for each way to correct, all from the same machine.
    pub runs: Vec<ClosedLoopRunBody>,
}

/// One way to correct.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ClosedLoopRun)]
pub struct ClosedLoopRunBody {
    /// How corrections were computed, such as `least_squares`, or the regularisation and its
    /// criterion.
    pub strategy: String,
    /// Where it is kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job_id: Option<Uuid>,
    /// Measurements: the first one, and one after each correction.
    pub rounds: Vec<ClosedLoopRoundBody>,
}

/// A measurement and the correction that followed from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ClosedLoopRound)]
pub struct ClosedLoopRoundBody {
    /// Number of the iteration.
    pub iteration: u32,
    /// Of the nodes that were measured.
    pub rms_measured_um: f64,
    /// Without noise, over all nodes: only a simulation knows.
    pub rms_true_um: f64,
    /// What the correction promised; left out after the last measurement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_predicted_um: Option<f64>,
    /// The changes of the settings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub changes: Option<Vec<f64>>,
}
