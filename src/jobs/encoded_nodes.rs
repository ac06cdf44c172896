//! Nodes on their way to the store.

use std::{ops::Deref, sync::Arc};

use flankfit_engine::estimation::Nodes;

use super::nodes_codec;

/// Nodes with the bytes that are stored of them, made before the store takes them.
#[derive(Clone, Debug)]
pub struct EncodedNodes {
    nodes: Arc<Nodes>,
    bytes: Arc<[u8]>,
}

impl EncodedNodes {
    /// [`nodes_codec::encode`] of the nodes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

impl From<Arc<Nodes>> for EncodedNodes {
    fn from(nodes: Arc<Nodes>) -> Self {
        let bytes = nodes_codec::encode(&nodes).into();
        EncodedNodes { nodes, bytes }
    }
}

impl Deref for EncodedNodes {
    type Target = Nodes;

    fn deref(&self) -> &Nodes {
        &self.nodes
    }
}
