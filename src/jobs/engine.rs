//! Computing a fit and writing it down, as the jobs see it. The service's engine runs on the bounded pool of fits.

use std::{future::Future, pin::Pin, sync::Arc};

use super::fit::Figures;
use crate::estimation::{FitError, FitSpec, Nodes};

/// A fit computed and written down.
#[derive(Clone, Debug, PartialEq)]
pub struct Computed {
    /// The specification as a JSON document that [`Engine::read_spec`] reads back.
    pub spec: Arc<str>,
    /// The answer as a JSON document.
    pub result: Arc<str>,
    pub figures: Figures,
}

/// Why nothing was computed.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The queue of fits is full; come back later.
    #[error("every place in the queue of fits is taken")]
    Overloaded,
    /// The computation was lost (a panic in a kernel, a shutdown).
    #[error("the fit was lost: {0}")]
    Lost(String),
}

/// Computes fits, off the async threads.
pub trait Engine: Send + Sync + 'static {
    /// Fits `spec` to `nodes` and writes both the specification and the answer down.
    fn compute(
        &self,
        nodes: Arc<Nodes>,
        spec: Arc<FitSpec>,
    ) -> Pin<Box<dyn Future<Output = Result<Computed, EngineError>> + Send + '_>>;

    /// Reads a specification that [`Engine::compute`] wrote.
    fn read_spec(&self, document: &str) -> Result<FitSpec, EngineError>;

    /// Who computed a written answer, such as `flankfit 0.1.0`.
    fn engine_of(&self, result: &str) -> Option<String>;

    /// The coefficients of a written answer, as JSON.
    fn largest_relative_difference(&self, stored: &str, recomputed: &str) -> Option<f64>;
}
