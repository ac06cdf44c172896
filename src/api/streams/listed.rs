//! Streams in a list, and the nodes that were posted to one.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::stream::StreamStateName;
use crate::{
    api::{
        fits::{nodes_text, spec::nodes::NodesBody},
        jobs::amendments::KnownMeasurandBody,
        json::{raw::Raw, text::Moment, writer::text_of},
        problem::Problem,
    },
    jobs::{Block, Stream},
};

/// A stream in a list: without its spec and its estimate.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ListedStream)]
pub struct ListedStreamBody {
    /// UUIDv7.
    pub id: Uuid,
    #[serde(flatten)]
    #[schema(inline)]
    pub measurand: KnownMeasurandBody,
    pub state: StreamStateName,
    /// Number of the last block; 0 before the first.
    pub sequence: u64,
    /// Nodes posted so far, missing ones included.
    pub node_count: u64,
    /// The iteration that the stream has become.
    pub iteration_number: Option<u32>,
    /// Time when the stream was opened.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Time when its last block was stored, or when it was finished.
    #[schema(value_type = String, format = DateTime)]
    pub updated_at: Moment,
}

/// A posted block of a stream.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = PostedStreamBlock)]
pub struct PostedBlockBody {
    /// From 1.
    pub sequence: u64,
    /// The nodes; a missing one is `null`.
    #[schema(value_type = NodesBody)]
    pub nodes: Raw<NodesBody>,
}

/// Blocks of a stream, in order.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = StreamNodes)]
pub struct StreamNodesBody {
    /// Blocks after `after`; empty where there are none, and for a finished stream, whose nodes are
    /// those of its iteration.
    pub items: Vec<PostedBlockBody>,
    /// Number of the stream's last block. While it is greater than that of the last item, request
    /// the blocks after that item.
    pub sequence: u64,
    pub state: StreamStateName,
    /// The iteration that the stream has become.
    pub iteration_number: Option<u32>,
}

impl From<Stream> for ListedStreamBody {
    fn from(stream: Stream) -> Self {
        ListedStreamBody {
            id: stream.id,
            measurand: (&stream.measurand).into(),
            state: StreamStateName::of(&stream),
            sequence: stream.sequence,
            node_count: stream.node_count,
            iteration_number: stream.iteration,
            created_at: Moment(stream.created_at),
            updated_at: Moment(stream.updated_at),
        }
    }
}

/// Returns blocks of a stream as JSON. Processor work.
pub fn blocks(stream: &Stream, blocks: Vec<Block>) -> Result<Vec<u8>, Problem> {
    let mut items = Vec::with_capacity(blocks.len());
    for Block { sequence, nodes, .. } in blocks {
        let text = nodes_text::to_json(Arc::new(nodes)).whole();
        let nodes = String::from_utf8(text).map_err(Problem::internal)?.into();
        items.push(PostedBlockBody { sequence, nodes });
    }
    let body = StreamNodesBody {
        items,
        sequence: stream.sequence,
        state: StreamStateName::of(stream),
        iteration_number: stream.iteration,
    };
    Ok(text_of(&body).into_bytes())
}
