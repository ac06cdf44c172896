//! Services that the use cases of streams need: workers of the pool, and the contract.

use super::prelude::*;
use crate::{
    api::{
        fits::{canonical, reader},
        measurand::axes,
        streams::stream,
    },
    jobs::{Measurand, Stream, StreamHost},
};
use flankfit_engine::estimation::{FitSpec, Recursive};

impl StreamHost for AppState {
    type Error = Problem;

    async fn compute<T, W>(&self, work: W) -> Result<T, Problem>
    where
        T: Send + 'static,
        W: FnOnce() -> Result<T, Problem> + Send + 'static,
    {
        self.pool.run(work).await?
    }

    fn read_spec(stored: &str) -> Result<FitSpec, Problem> {
        reader::read_stored(stored).map_err(Problem::internal)
    }

    fn first_sha256(spec: &FitSpec, forgetting_factor: f64) -> [u8; 32] {
        canonical::stream_sha256(spec, forgetting_factor)
    }

    fn add_nodes(estimate: &mut Recursive, measurand: &Measurand, nodes: &Nodes) -> Result<(), Problem> {
        axes::check_block(measurand, nodes).map_err(Problem::invalid)?;
        estimate.push(nodes).map_err(Problem::invalid)
    }

    fn answer(stream: &Stream, estimate: &Recursive) -> Result<Answer, Problem> {
        let estimate = stream::estimate_text(estimate, &stream.input_sha256)?;
        let body = stream::answer(stream.sequence, stream.node_count, estimate);
        Ok(Answer { status: 200, location: None, etag: Some(etag(stream.version)), body })
    }
}
