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
        jobs::iterations::measurand,
        json::{text::Moment, writer::Json},
        measurand::axes::MeasurandBody,
        problem::Problem,
    },
    jobs::{Block, List, Page, Stream},
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
    pub measurand: MeasurandBody,
    pub state: StreamStateName,
    /// Number of the last block; 0 before the first.
    pub sequence: u64,
    /// Nodes posted so far, missing ones included.
    pub node_count: u64,
    /// The iteration that the stream has become.
    pub iteration_number: Option<u32>,
    /// When the stream was opened.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// When its last block was stored, or when it was finished.
    #[schema(value_type = String, format = DateTime)]
    pub updated_at: Moment,
}

/// Some streams of a job, oldest first.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = StreamPage)]
pub struct StreamPageBody {
    /// The streams of this page.
    pub items: Vec<ListedStreamBody>,
    /// Cursor of the next page; absent on the last one.
    pub next_cursor: Option<String>,
}

/// A block of a stream as it was posted.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = PostedStreamBlock)]
pub struct PostedBlockBody {
    /// From 1.
    pub sequence: u64,
    /// The nodes; a missing one is `null`.
    pub nodes: NodesBody,
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

/// A page of streams.
pub fn page(page: &Page<Stream>) -> Vec<u8> {
    let mut json = Json::with_capacity(64 + 512 * page.items.len());
    json.object()
        .list("items", &page.items, |object, stream| {
            object.field("id", &stream.id);
            measurand(object, &stream.measurand);
            object
                .field("state", &StreamStateName::of(stream))
                .field("sequence", &stream.sequence)
                .field("node_count", &stream.node_count)
                .maybe("iteration_number", stream.iteration)
                .field("created_at", &Moment(stream.created_at))
                .field("updated_at", &Moment(stream.updated_at));
        })
        .maybe("next_cursor", page.next.map(|next| next.encode(List::Streams)))
        .end();
    json.into_bytes()
}

/// Blocks of a stream. Processor work.
pub fn blocks(stream: &Stream, blocks: Vec<Block>) -> Result<Vec<u8>, Problem> {
    let mut items = Vec::with_capacity(blocks.len());
    for Block { sequence, nodes, .. } in blocks {
        let text = nodes_text::to_json(Arc::new(nodes)).whole();
        items.push((sequence, String::from_utf8(text).map_err(Problem::internal)?));
    }
    let mut json = Json::with_capacity(128 + items.iter().map(|(_, text)| 32 + text.len()).sum::<usize>());
    json.object()
        .list("items", items, |object, (sequence, nodes)| {
            object.field("sequence", &sequence).raw("nodes", &nodes);
        })
        .field("sequence", &stream.sequence)
        .field("state", &StreamStateName::of(stream))
        .maybe("iteration_number", stream.iteration)
        .end();
    json.finish().map_err(Problem::not_finite)
}
