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
        /// The true A, one for each column; with `nodes` the least-squares estimate of their
        /// heights is assumed when not given.
        optional coefficients: Vec<f64>,
        /// Deviation of a height; with `nodes` that of their residuals is assumed when not given.
        #[schema(minimum = 0)]
        optional noise_sigma: f64,
        /// k: deviation of the noise that is put on a column over the deviation of the column
        /// itself.
        #[schema(min_items = 1, max_items = 200)]
        required levels: Vec<f64>,
        /// Number of random matrices for each level. More give smoother results and take longer.
        #[schema(minimum = 1, maximum = 10000)]
        required repetitions: usize,
        /// Equal seeds give equal studies. Default 0.
        optional seed: u64,
        /// Scaling of the columns for norms and eigenvalues. Default `none`.
        optional scaling: StudyScaling,
    }
}

/// Columns as they are (the paper's), or divided by their lengths and coefficients multiplied by
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StudyScaling {
    None,
    UnitLength,
}
