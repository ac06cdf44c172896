//! The stored fit whose matrix B another fit takes: found, and what is used of it computed again.

use super::prelude::*;
use crate::{
    api::jobs::fits::{self, Given},
    jobs::{FitRecord, Predecessors, RepositoryError, Resource},
};
use flankfit_engine::estimation::spec::{PieceOf, Regularization, Representative};

const ITERATION: &str = "/regularization/iteration";

/// The stored fit that a spec asks for.
pub fn asked(spec: &FitSpec) -> Option<&PieceOf> {
    match &spec.regularization {
        Regularization::Representative(asked) if asked.of.iteration.is_some() => Some(&asked.of),
        _ => None,
    }
}

/// The spec with the piece that it asks for; unchanged where it asks for none.
pub async fn resolved(context: Context<'_>, job: Uuid, spec: FitSpec) -> Result<FitSpec, Problem> {
    let Some((number, wanted)) = asked(&spec).and_then(|of| Some((of.iteration?, of.fit_id.clone()))) else {
        return Ok(spec);
    };
    let refused = |place: &str, detail: String| Problem::invalid(Faults::one(place, detail));
    let no_iteration = || refused(ITERATION, format!("the job has no iteration {number}"));
    let found = stored_fit(context, job, number, wanted).await;
    let stored = found.map_err(|error| match error {
        RepositoryError::NotFound(Resource::Iteration) => no_iteration(),
        RepositoryError::NotFound(_) => {
            refused("/regularization/fit_id", format!("iteration {number} has no such fit"))
        }
        other => other.into(),
    })?;
    let Some(stored) = stored else { return Err(no_iteration()) };
    let nodes = nodes::stored(context, job, number).await?;
    let id = stored.id;
    let found = context.pool.run(move || fits::piece(&nodes, &stored)).await??;
    let piece = match found {
        Given::Piece(piece) => Ok(piece),
        Given::NotSpectral => Err("is not regularised by a matrix B of its own (`spectral`)"),
        Given::Standardized => Err("has standardised columns, whose matrix B does not apply to the posted ones"),
        Given::NothingRaised => {
            Err("raised no eigenvalue (L = 0): its matrix B is 0, and nothing would be regularised")
        }
    };
    let piece = piece.map_err(|why| refused(ITERATION, format!("the fit of iteration {number} {why}")))?;
    let of = PieceOf { iteration: Some(number), fit_id: Some(id.to_string()) };
    let asked = Representative { of, piece: Some(piece) };
    Ok(FitSpec { regularization: Regularization::Representative(asked), ..spec })
}

/// Moves errors of a piece that came from an iteration to the field that named the iteration.
pub fn refused_by_iteration(problem: Problem) -> Problem {
    problem.moved("/regularization/piece", ITERATION)
}

/// Returns the fit of that id, or the chosen fit without one.
async fn stored_fit(
    context: Context<'_>,
    job: Uuid,
    number: u32,
    wanted: Option<String>,
) -> Result<Option<FitRecord>, RepositoryError> {
    let of = context.jobs.measurand(job, number).await?;
    let id = match wanted.and_then(|id| Uuid::try_parse(&id).ok()) {
        Some(id) => id,
        None => {
            let itself = Predecessors { of, from: number, before: Some(number.saturating_add(1)), most: 1 };
            let Some(standing) = context.jobs.predecessors(job, itself).await?.pop() else { return Ok(None) };
            standing.fit_id
        }
    };
    context.jobs.fit(job, number, id).await.map(Some)
}
