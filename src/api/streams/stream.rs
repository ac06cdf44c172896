//! Streams of nodes as they are written and read, and the estimate after a block as JSON.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::listed::ListedStreamBody;
use crate::{
    api::{
        faults::Faults,
        fits::{
            answer::FitResultBody,
            canonical,
            reader::{self, nodes::RawNodes},
            spec::{json, nodes::NodesBody, request::FitSpecBody},
        },
        json::{gather::gathered, members::of_request, raw::Raw, request::request, writer::text_of},
        measurand::axes::MeasurandBody,
        problem::Problem,
        warning::WarningBody,
    },
    jobs::{NewStream, PostedBlock, Stream, StreamDraft, rows::to_hex},
};
use flankfit_engine::{
    estimation::{FitError, Recursive, near},
    words::counted,
};

/// A stream to open: a fit request without nodes. `domain` is required if the basis is mapped to it
/// (Chebyshev, Legendre) or knots are equal spans over it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = NewStream)]
pub struct NewStreamBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub settings: StreamSettings,
}

request! {
    /// How long nodes are remembered, and what they are of.
    #[derive(Default)]
    pub struct StreamSettings as StreamSettingsMembers, read whole {
        flatten forgetting: Forgetting,
        flatten measurand: MeasurandBody,
    }
}

request! {
    /// How long nodes are remembered.
    #[derive(Default)]
    pub struct Forgetting as ForgettingMembers, read whole {
        /// φ in (0, 1], default 1: every counted node multiplies the weights of all before it by φ.
        /// When the stream is finished all nodes count in full.
        #[schema(exclusive_minimum = 0, maximum = 1)]
        optional forgetting_factor: f64,
    }
}

request! {
    /// A block of nodes.
    #[schema(as = StreamBlock)]
    pub struct BlockBody as BlockMembers {
        /// 1 for the first block, then 2, 3 …. A block sent again with the same number and nodes
        /// gets the same response and is not counted twice.
        #[schema(minimum = 1)]
        required sequence: u64,
        /// One or more nodes, of the same kind throughout the stream (scattered nodes and grids
        /// count as one kind).
        required nodes: NodesBody as RawNodes,
    }
}

/// The estimate after a block.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = StreamEstimate)]
pub struct EstimateBody {
    /// Number of the last block, from 1.
    pub sequence: u64,
    /// Nodes posted so far, missing ones included.
    pub node_count: u64,
    /// The fit of all nodes so far, except the parts that need the nodes themselves (`max_abs`,
    /// single residuals, B). Absent, with a warning that gives the reason, while the nodes do not
    /// determine the model.
    #[schema(value_type = Option<FitResultBody<'static>>)]
    pub result: Option<Raw<FitResultBody<'static>>>,
    /// Reason why there is no result yet, or warnings of the result.
    pub warnings: Option<Vec<WarningBody>>,
}

/// A stream.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Stream)]
pub struct StreamBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub stream: ListedStreamBody,
    /// The job that it belongs to.
    pub job_id: Uuid,
    /// Factor of the weights of all earlier nodes at every node; 1 keeps them.
    pub forgetting_factor: f64,
    /// The fit request without nodes, with every default filled in.
    #[schema(value_type = FitSpecBody)]
    pub spec: Raw<FitSpecBody>,
    /// The estimate after the last block.
    #[schema(value_type = Option<FitResultBody<'static>>)]
    pub result: Option<Raw<FitResultBody<'static>>>,
    /// Reason why an open stream has no result yet, or warnings of the result.
    pub warnings: Option<Vec<WarningBody>>,
}

/// State of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StreamStateName {
    Open,
    Finished,
}

impl StreamStateName {
    pub fn of(stream: &Stream) -> Self {
        if stream.iteration.is_some() { StreamStateName::Finished } else { StreamStateName::Open }
    }
}

/// Reads and checks a stream to open.
pub fn read_stream(text: &[u8]) -> Result<StreamDraft, Problem> {
    let (spec, settings) = reader::read_refit::<StreamSettings>(text)?;
    let forgetting_factor = settings.forgetting.forgetting_factor.unwrap_or(1.0);
    let mut faults = Recursive::new(&spec, forgetting_factor).err().map(Faults::from).unwrap_or_default();
    let measurand = settings.measurand.checked_for_stream(&spec);
    let measurand = measurand.map_err(|more| faults.append(more)).unwrap_or_default();
    faults.into_result(()).map_err(Problem::invalid)?;
    let input_sha256 = canonical::stream_sha256(&spec, forgetting_factor);
    Ok(StreamDraft { spec: json::to_json(&spec).into(), forgetting_factor, input_sha256, measurand })
}

/// Reads a block. Processor work.
pub fn read_block(text: &[u8]) -> Result<PostedBlock, Problem> {
    let mut faults = Faults::default();
    let members: BlockMembers<'_> = of_request(text, &mut faults)?;
    let nodes = RawNodes::required(members.nodes, &mut faults);
    let sequence = members.sequence.required(&mut faults);
    let (Some(nodes), Some(sequence)) = (nodes, sequence) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    if sequence == 0 {
        return Err(Problem::invalid(Faults::one("/sequence", "blocks are numbered from 1")));
    }
    let sha256 = canonical::nodes_sha256(&nodes);
    Ok(PostedBlock { sequence, nodes: Arc::new(nodes), sha256 })
}

/// The result of an estimate as JSON, or why there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum EstimateText {
    Result(String),
    Waiting { code: String, message: String },
}

/// The estimate's result. Processor work.
pub fn estimate_text(estimate: &Recursive, input_sha256: &[u8; 32]) -> Result<EstimateText, Problem> {
    let result = match estimate.result() {
        Ok(Some(result)) => result,
        Ok(None) => {
            let message = match estimate.size() {
                Some(n) => format!(
                    "{} so far, fewer than the {}",
                    counted(estimate.count(), "counted node", "counted nodes"),
                    counted(n, "coefficient", "coefficients")
                ),
                None => "no nodes so far".to_owned(),
            };
            return Ok(EstimateText::Waiting { code: "fewer_nodes_than_coefficients".into(), message });
        }
        Err(error) => return Ok(waiting(error)),
    };
    let shape = near::shape_of(estimate.spec(), &result);
    let digest = to_hex(input_sha256);
    let text = FitResultBody::new(&result, shape.as_ref(), digest).text().map_err(Problem::internal)?;
    Ok(EstimateText::Result(String::from_utf8(text).map_err(Problem::internal)?))
}

/// Nodes that do not allow the fit yet are no fault of their block: the code is that of a warning.
fn waiting(error: FitError) -> EstimateText {
    let code = match &error {
        FitError::ExceedsDouble(_) => Some("exceeds_double"),
        // what a prior needs of the nodes
        FitError::Invalid(faults) => match &*faults.list()[0].path {
            "noise_sigma" => Some("no_degrees_of_freedom"),
            "prior" => Some("rank_deficient"),
            _ => None,
        },
        FitError::RankDeficient { .. } | FitError::NotConverged(_) => None,
    };
    let problem = Problem::from(error);
    let details: Vec<&str> = problem.errors.iter().map(|error| error.detail.as_str()).collect();
    let message = if details.is_empty() { problem.detail } else { details.join("; ") };
    EstimateText::Waiting { code: code.map_or_else(|| problem.code.into_owned(), str::to_owned), message }
}

impl EstimateText {
    /// Returns the result, or the warning in its place.
    fn parts(self) -> (Option<Raw<FitResultBody<'static>>>, Option<Vec<WarningBody>>) {
        match self {
            EstimateText::Result(text) => (Some(text.into()), None),
            EstimateText::Waiting { code, message } => (None, Some(vec![WarningBody::new(code, message)])),
        }
    }
}

/// Returns the answer to a block as JSON.
pub fn answer(sequence: u64, node_count: u64, estimate: EstimateText) -> Vec<u8> {
    let (result, warnings) = estimate.parts();
    gathered(text_of(&EstimateBody { sequence, node_count, result, warnings }).into_bytes())
}

/// Returns a stored stream as JSON; an open one with its estimate.
pub fn stream(stream: &Stream, estimate: Option<EstimateText>) -> Vec<u8> {
    let (result, warnings) = estimate.map(EstimateText::parts).unwrap_or_default();
    let body = StreamBody {
        stream: stream.clone().into(),
        job_id: stream.job_id,
        forgetting_factor: stream.forgetting_factor,
        spec: Arc::clone(&stream.spec).into(),
        result,
        warnings,
    };
    gathered(text_of(&body).into_bytes())
}

/// Returns a new stream as JSON.
pub fn created(new: &NewStream) -> Vec<u8> {
    let opened = Stream {
        id: new.id,
        job_id: new.job_id,
        spec: new.spec.clone(),
        forgetting_factor: new.forgetting_factor,
        sequence: 0,
        node_count: 0,
        input_sha256: new.input_sha256,
        measurand: new.measurand.clone(),
        iteration: None,
        version: 1,
        created_at: new.created_at,
        updated_at: new.created_at,
    };
    stream(&opened, None)
}
