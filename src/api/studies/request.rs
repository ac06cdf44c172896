//! A randomisation study, as it is asked for.

use serde::Deserialize;
use utoipa::ToSchema;

use crate::api::{
    fits::spec::{nodes::NodesBody, request::ModelBody},
    shapes::domain::DomainBody,
};

/// What is randomised: either `x`, or `nodes` with `model`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomizationRequest {
    /// Rows of the measurement matrix.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1)]
    pub x: Option<Vec<Vec<f64>>>,
    /// Nodes at which `model` is evaluated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes: Option<NodesBody>,
    /// With `nodes`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<ModelBody>,
    /// With `nodes`: the box on which mapped bases live.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainBody>,
    /// The true A, one for each column; with `nodes` the least-squares estimate of their heights is
    /// assumed when not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficients: Option<Vec<f64>>,
    /// Deviation of a height; with `nodes` that of their residuals is assumed when not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0)]
    pub noise_sigma: Option<f64>,
    /// k: deviation of the noise that is put on a column over the deviation of the column itself.
    #[schema(min_items = 1, max_items = 200)]
    pub levels: Vec<f64>,
    /// Random matrices for each level. More give smoother figures and take longer.
    #[schema(minimum = 1, maximum = 10000)]
    pub repetitions: usize,
    /// Equal seeds give equal studies. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Columns in which norms and eigenvalues are understood. Default `none`, as they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scaling: Option<StudyScaling>,
}

/// Columns as they are (the paper's), or divided by their lengths and coefficients multiplied by
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StudyScaling {
    None,
    UnitLength,
}
