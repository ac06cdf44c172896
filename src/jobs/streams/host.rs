//! The surroundings of the use cases of streams: a processor to compute on, and the
//! contract in which specs are stored and blocks answered.

use flankfit_engine::estimation::{FitSpec, Nodes, Recursive};

use crate::jobs::*;

pub trait StreamHost: Send + Sync {
    type Error: From<StreamError> + Send + 'static;

    /// Does processor work. If the future is dropped, the work is cancelled.
    fn compute<T, W>(&self, work: W) -> impl Future<Output = Result<T, Self::Error>> + Send
    where
        T: Send + 'static,
        W: FnOnce() -> Result<T, Self::Error> + Send + 'static;

    /// Reads the spec of a stored stream.
    fn read_spec(stored: &str) -> Result<FitSpec, Self::Error>;

    /// The digest with which the chain over a stream's blocks begins.
    fn first_sha256(spec: &FitSpec, forgetting_factor: f64) -> [u8; 32];

    /// Adds the nodes of a posted block to the estimate of a stream, unless they do not fit it.
    fn add_nodes(estimate: &mut Recursive, measurand: &Measurand, nodes: &Nodes) -> Result<(), Self::Error>;

    /// The answer to the block after which stream and estimate are as given. Processor work.
    fn answer(stream: &Stream, estimate: &Recursive) -> Result<Answer, Self::Error>;
}
