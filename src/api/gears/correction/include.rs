//! Parts of a correction that are returned only when requested. All of it is stored.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::result::CorrectionResultBody;
use crate::api::json::{
    cursor::{Syntax, Token},
    left_out::without,
    location::Location,
};
use flankfit_engine::estimation::spec;

/// Parts that are returned only when requested. A repeated name counts once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = CorrectionInclude)]
pub enum CorrectionIncludeName {
    /// Predicted and measured deviations of each node.
    Nodes,
    /// The fits of the settings, `result` and `limited_result`.
    Result,
    /// For these fits, as in `POST /v1/fits`: one residual per counted node.
    Residuals,
    /// For these fits: the collinearity matrices and the weights of near dependencies.
    Collinearity,
    /// For these fits: condition, bias and error along λ*.
    LambdaCurve,
    /// For these fits: the matrix B.
    MatrixB,
    /// For these fits: the coefficients along k; for ridge.
    RidgeTrace,
}

/// Parts of a stored correction that are returned only when requested; a repeated name counts once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = KeptCorrectionInclude)]
pub enum StoredIncludeName {
    /// Predicted and measured deviations of each node, and what the request has for each node:
    /// `trace`, `weight`, a `target` with `deviation_um`, and the `matrix` of `sensitivity`.
    Nodes,
    /// The fits of the settings, `result` and `limited_result`.
    Result,
}

/// Requested parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CorrectionInclude {
    pub nodes: bool,
    pub result: bool,
    /// Parts of the fits.
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

    /// Leaves out the parts of a correction that were not requested.
    pub fn of_result(self, mut whole: CorrectionResultBody) -> CorrectionResultBody {
        if !self.nodes {
            whole.target.deviation_um = None;
            (whole.predicted.deviation_um, whole.predicted.uncertainty_um) = (Vec::new(), Vec::new());
        }
        if !self.result {
            (whole.result, whole.limited_result) = (None, None);
        }
        whole
    }

    /// Leaves out the lists of a posted request that were not requested, and a target that is one.
    pub fn of_request(self, whole: &Arc<str>) -> Result<Arc<str>, Syntax> {
        if self.nodes {
            return Ok(whole.clone());
        }
        without(whole, |at, token| match at {
            Location::Member(Location::Root, "target") => token == Token::Object,
            Location::Member(Location::Root, "trace" | "weight")
            | Location::Member(Location::Member(Location::Root, "sensitivity"), "matrix") => true,
            _ => false,
        })
    }
}
