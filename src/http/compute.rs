//! Where a fit request is worked on: a short one here, on the thread that serves its connection, any other on the pool.
//!
//! Handing work to another thread and its answer back costs two wakings, about as much as a small fit itself. A small one is
//! therefore done at once if the pool has a worker to spare, whose place it takes meanwhile, so that no more fits run than there
//! are workers. When none is to spare it waits its turn on the pool like all others, or is refused.

use super::{body::Payload, multipart, state::AppState};
use crate::{
    api::{problem::Problem, reader::Extra},
    estimation::{self, FitSpec, Nodes},
};

/// Longest body that is read on a thread that serves connections: some tens of microseconds.
const SHORT_BODY: usize = 64 << 10;

/// Reads a fit request in either form and does `work` with it.
pub async fn read_and<E, T>(
    state: &AppState,
    payload: Payload,
    work: impl FnOnce(Nodes, FitSpec, E) -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem>
where
    E: Extra + Send + 'static,
    T: Send + 'static,
{
    let limit = state.settings.body_limit;
    if payload.is_plain_json(SHORT_BODY)
        && let Some(place) = state.pool.place()
    {
        let (nodes, spec, extra) = multipart::read_fit::<E>(payload, limit)?;
        if estimation::is_short(&nodes, &spec) {
            return work(nodes, spec, extra);
        }
        drop(place);
        return state.pool.run(move || work(nodes, spec, extra)).await?;
    }
    state
        .pool
        .run(move || {
            let (nodes, spec, extra) = multipart::read_fit::<E>(payload, limit)?;
            work(nodes, spec, extra)
        })
        .await?
}

/// Does `work` with a JSON body on the pool.
pub async fn read_json<T: Send + 'static>(
    state: &AppState,
    payload: Payload,
    work: impl FnOnce(&[u8]) -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let limit = state.settings.body_limit;
    state.pool.run(move || work(&payload.into_json(limit)?)).await?
}
