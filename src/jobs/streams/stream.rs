//! A stream and its blocks.

use std::sync::Arc;

use flankfit_engine::estimation::Nodes;
use jiff::Timestamp;
use sha2::{Digest, Sha256};
use uuid::Uuid;

use crate::jobs::*;

/// A stream about to be stored.
#[derive(Clone, Debug, PartialEq)]
pub struct NewStream {
    pub id: Uuid,
    pub job_id: Uuid,
    /// Specification of the fit: a JSON document.
    pub spec: Arc<str>,
    /// In (0, 1]; 1 forgets nothing.
    pub forgetting_factor: f64,
    /// Digest of the above, with which the chain over blocks begins.
    pub input_sha256: [u8; 32],
    pub measurand: Measurand,
    pub created_at: Timestamp,
}

/// A stored stream.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    pub id: Uuid,
    pub job_id: Uuid,
    pub spec: Arc<str>,
    pub forgetting_factor: f64,
    /// Number of the last block; 0 before the first.
    pub sequence: u64,
    /// Nodes posted so far, missing ones included.
    pub node_count: u64,
    /// Chain of digests: of the spec, then of every block.
    pub input_sha256: [u8; 32],
    pub measurand: Measurand,
    /// The iteration that it has become.
    pub iteration: Option<u32>,
    /// 1 when created, one more with every block and when it is finished.
    pub version: u64,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
}

impl Stream {
    /// The number of the next block.
    pub fn expected(&self) -> u64 {
        self.sequence + 1
    }

    /// Refuses what a finished stream no longer takes.
    pub fn check_open(&self) -> Result<(), RepositoryError> {
        self.iteration.map_or(Ok(()), |iteration| Err(RepositoryError::StreamFinished { iteration }))
    }

    /// The stream after its next block, but for the time of that.
    pub(super) fn after(&self, sha256: &[u8; 32], posted: usize) -> Self {
        let chain = Sha256::new().chain_update(self.input_sha256).chain_update(sha256);
        Stream {
            sequence: self.expected(),
            node_count: self.node_count + posted as u64,
            input_sha256: chain.finalize().into(),
            version: self.version + 1,
            ..self.clone()
        }
    }
}

/// A block as it was posted.
#[derive(Clone, Debug)]
pub struct PostedBlock {
    /// From 1.
    pub sequence: u64,
    pub nodes: Arc<Nodes>,
    /// Digest of the nodes in their canonical form.
    pub sha256: [u8; 32],
}

/// A block about to be stored.
#[derive(Clone, Debug)]
pub struct NewBlock {
    pub stream: Uuid,
    pub sequence: u64,
    /// Digest of the nodes in their canonical form.
    pub sha256: [u8; 32],
    /// The stream's chain before this block: behind other blocks it is refused.
    pub previous_sha256: [u8; 32],
    /// The stream's chain after this block.
    pub input_sha256: [u8; 32],
    pub nodes: EncodedNodes,
    /// The estimate's numbers after this block, when it is time to write them down.
    pub state: Option<Vec<u8>>,
    pub created_at: Timestamp,
}

/// A stored block.
#[derive(Clone, Debug)]
pub struct Block {
    pub sequence: u64,
    pub sha256: [u8; 32],
    pub nodes: Nodes,
}

/// The estimate's numbers as they were written down last.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamState {
    /// After which block.
    pub sequence: u64,
    pub data: Vec<u8>,
}

/// A stream becoming an iteration: both or neither.
#[derive(Clone, Debug)]
pub struct FinishedStream {
    pub stream: Uuid,
    /// The last block that the iteration holds.
    pub sequence: u64,
    pub iteration: Arc<NewIteration>,
}
