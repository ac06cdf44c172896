//! Response of an evaluation of traces.

use std::ops::Deref;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::request::EvaluationSettingsBody;
use crate::api::warning::WarningBody;
use flankfit_engine::gear::evaluation::Evaluation;

/// Evaluated traces, their means over the teeth, twists and surfaces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearEvaluation)]
pub struct EvaluationBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub result: Evaluation,
    /// Settings of the evaluation, with every default filled in.
    pub evaluation: EvaluationSettingsBody,
    /// Warnings.
    pub warnings: Vec<WarningBody>,
}

impl EvaluationBody {
    /// Creates the response with the warnings of the result.
    pub fn new(result: Evaluation, evaluation: EvaluationSettingsBody) -> Self {
        let warnings = result.warnings.iter().map(WarningBody::from).collect();
        EvaluationBody { result, evaluation, warnings }
    }

    /// Adds the design lines of the traces; lines of zeros are left out.
    pub fn with_designs(mut self, lines: impl IntoIterator<Item = Option<Vec<f64>>>) -> Self {
        for (trace, line) in self.result.traces.iter_mut().zip(lines) {
            trace.design_um = line.filter(|line| line.iter().any(|x| *x != 0.0));
        }
        self
    }
}

impl Deref for EvaluationBody {
    type Target = Evaluation;

    fn deref(&self) -> &Evaluation {
        &self.result
    }
}
