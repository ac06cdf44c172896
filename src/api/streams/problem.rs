//! Refusals of streams as problems.

use crate::{
    api::problem::{Problem, ProblemCode},
    jobs::StreamError,
};

impl From<StreamError> for Problem {
    fn from(error: StreamError) -> Self {
        let detail = match error {
            StreamError::Repository(error) => return error.into(),
            StreamError::Damaged(_) => return Problem::internal(error),
            StreamError::BlockTooEarly { sequence, expected } => format!(
                "Block {sequence} came, but the stream expects block {expected} next: send the blocks in between \
                 first."
            ),
            StreamError::BlockChanged { sequence, expected } => format!(
                "Block {sequence} was posted before with other nodes; the stream expects block {expected} next."
            ),
            StreamError::NoNodes => "The stream has no nodes; send nodes before you finish it.".to_owned(),
        };
        Problem::new(ProblemCode::Conflict, detail)
    }
}
