//! A randomisation study, as it is asked for.

use serde::Deserialize;
use utoipa::ToSchema;

use crate::api::{
    fits::{reader::nodes::RawNodes, spec::nodes::NodesBody},
    json::request::request,
};
use flankfit_engine::estimation::spec::{Domain, Model};

request! {
    /// The matrix to randomise: either `x`, or `nodes` with `model`.
    #[serde(deny_unknown_fields)]
    pub struct RandomizationRequest as RandomizationMembers {
        /// Rows of the measurement matrix.
        #[schema(min_items = 1)]
        optional x: Vec<Vec<f64>>,
        /// Nodes at which `model` is evaluated.
        optional nodes: NodesBody as RawNodes,
        /// With `nodes`: the model.
        optional model: Model,
        /// With `nodes`: the box of the mapped basis functions.
        optional domain: Domain,
        /// The true A, one for each column; with `nodes` by default the least-squares estimate from
        /// their heights.
        optional coefficients: Vec<f64>,
        /// Standard deviation of a height; with `nodes` by default that of their residuals.
        #[schema(minimum = 0)]
        optional noise_sigma: f64,
        /// k: standard deviation of the noise added to a column, divided by that of the column.
        #[schema(min_items = 1, max_items = 200)]
        required levels: Vec<f64>,
        /// Number of random matrices for each level. More give smoother results and take longer.
        #[schema(minimum = 1, maximum = 10000)]
        required repetitions: usize,
        /// The same seed gives the same study. Default 0.
        optional seed: u64,
        /// Scaling of the columns for norms and eigenvalues. Default `none`.
        optional scaling: StudyScaling,
    }
}

/// Columns as they are (as in the paper), or divided by their lengths, with coefficients multiplied
/// by them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StudyScaling {
    None,
    UnitLength,
}
