//! What of a correction is answered only when asked for. Kept is all of it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{json::merge::without, problem::Problem};
use flankfit_engine::estimation::spec;

/// What is answered only when asked for; each name only adds to the answer, and one that stands
/// twice counts once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = CorrectionInclude)]
pub enum CorrectionIncludeName {
    /// What is predicted of each node, and what was measured there.
    Nodes,
    /// The fits of the settings, `result` and `limited_result`.
    Result,
    /// Of those fits, as in `POST /v1/fits`: one residual per counted node.
    Residuals,
    /// Of those fits: the collinearity matrices and the weights of near dependencies.
    Collinearity,
    /// Of those fits: condition, bias and error along λ*.
    LambdaCurve,
    /// Of those fits: the matrix B.
    MatrixB,
    /// Of those fits: the coefficients along k; for ridge.
    RidgeTrace,
}

/// What of a kept correction is answered only when asked for; each name only adds to the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = KeptCorrectionInclude)]
pub enum StoredIncludeName {
    /// What is predicted of each node, what was measured there, and what the request says node by
    /// node.
    Nodes,
    /// The fits of the settings, `result` and `limited_result`.
    Result,
}

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CorrectionInclude {
    pub nodes: bool,
    pub result: bool,
    /// Of the fits.
    pub fit: spec::Include,
}

impl CorrectionInclude {
    pub fn of(names: &[CorrectionIncludeName]) -> Self {
        use CorrectionIncludeName as Name;
        let has = |name| names.contains(&name);
        let fit = spec::Include {
            residuals: has(Name::Residuals),
            collinearity: has(Name::Collinearity),
            lambda_curve: has(Name::LambdaCurve),
            matrix_b: has(Name::MatrixB),
            ridge_trace: has(Name::RidgeTrace),
            ..spec::Include::default()
        };
        // what adds to the fits brings them along
        CorrectionInclude { nodes: has(Name::Nodes), result: has(Name::Result) || fit != spec::Include::default(), fit }
    }

    pub fn of_stored(names: &[StoredIncludeName]) -> Self {
        let has = |name| names.contains(&name);
        let (nodes, result) = (has(StoredIncludeName::Nodes), has(StoredIncludeName::Result));
        CorrectionInclude { nodes, result, ..CorrectionInclude::default() }
    }

    /// Of a whole correction what is answered.
    pub fn of_result(self, whole: &str) -> Result<String, Problem> {
        let mut paths: Vec<&[&str]> = Vec::new();
        if !self.nodes {
            let target: &[&str] = &["target", "deviation_um"];
            paths.extend([target, &["predicted", "deviation_um"], &["predicted", "uncertainty_um"]]);
        }
        if !self.result {
            paths.extend([&["result"][..], &["limited_result"]]);
        }
        without(whole, &paths).map_err(Problem::internal)
    }

    /// Of a whole request what is answered.
    pub fn of_request(self, whole: &str) -> Result<String, Problem> {
        let paths: &[&[&str]] = if self.nodes {
            &[]
        } else {
            &[&["sensitivity", "matrix"], &["trace"], &["weight"], &["target", "deviation_um"]]
        };
        without(whole, paths).map_err(Problem::internal)
    }
}
