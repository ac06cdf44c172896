//! Execution of fit requests: a short one on the thread that serves its connection, any other on
//! the pool.
//!
//! Handing work to another thread and its result back costs two wakings, about as much as a small
//! fit itself. A small one is therefore done at once if the pool has a worker to spare, whose place
//! it takes meanwhile, or if no other small one runs while all workers are busy, so that no more
//! fits run than there are workers and one. Else it waits its turn on the pool like all others, or
//! is refused.

use serde::de::DeserializeOwned;
use utoipa::ToSchema;

use super::{
    body::{Media, Payload, unsupported},
    multipart,
};
use crate::{
    api::{
        json::{request::ReadWhole, value},
        problem::{Problem, Room},
        tables::kept::SentMapping,
    },
    http::state::AppState,
    telemetry,
    usecases::budget::WithPermit,
};
use flankfit_engine::estimation::{self, FitSpec, Nodes};

/// Longest body that is read on a thread that serves connections: some tens of microseconds.
const SHORT_BODY: usize = 64 << 10;

/// Reads a fit request in either form and does `work` with it, and with the mapping of its table.
/// What comes of it has the permit for the request's nodes.
pub async fn read_fit_and<E, T>(
    state: &AppState,
    payload: Payload,
    work: impl FnOnce(Nodes, FitSpec, E, Option<SentMapping>) -> Result<T, Problem> + Send + 'static,
) -> Result<WithPermit<T>, Problem>
where
    E: ReadWhole + Send + 'static,
    T: Send + 'static,
{
    let limit = state.settings.body_limit;
    if payload.is_plain_json(SHORT_BODY)
        && let Some(slot) = state.pool.try_slot()
    {
        let ((nodes, spec, extra, sent), permit) = multipart::read_fit::<E>(payload, limit)?.into_parts();
        if estimation::is_short(&nodes, &spec) {
            let work = || Ok(WithPermit::new(work(nodes, spec, extra, sent)?, permit));
            return telemetry::compute_span(&telemetry::here()).in_scope(work);
        }
        drop(slot);
        return state.pool.run(move || Ok(WithPermit::new(work(nodes, spec, extra, sent)?, permit))).await?;
    }
    state
        .pool
        .run(move || {
            let ((nodes, spec, extra, sent), permit) = multipart::read_fit::<E>(payload, limit)?.into_parts();
            Ok(WithPermit::new(work(nodes, spec, extra, sent)?, permit))
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

/// Does `work` with a JSON body on the pool if the budget allows for the result, which is charged
/// to it until it has been sent.
pub async fn read_json_in_room(
    state: &AppState,
    payload: Payload,
    work: impl FnOnce(&[u8], Room) -> Result<Vec<u8>, Problem> + Send + 'static,
) -> Result<WithPermit<Vec<u8>>, Problem> {
    let (limit, mut permit) = (state.settings.body_limit, state.budget.permit());
    let work = move || {
        let text = payload.into_json(limit)?;
        let answer = work(&text, &mut |bytes| permit.grow_with(text.permit(), bytes))?;
        Ok(WithPermit::new(answer, permit))
    };
    state.pool.run(work).await?
}

/// Longest body that is read where it has arrived, if nothing long is done with it.
const SMALL_JSON: usize = 16 << 10;

/// Reads a JSON body with which nothing long is done: a short plain one here, any other on the
/// pool.
pub async fn read_small_json<T: Send + 'static>(
    state: &AppState,
    payload: Payload,
    limit: usize,
    read: impl FnOnce(&[u8]) -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    if payload.is_plain_json(SMALL_JSON) {
        return read(&payload.into_json(limit)?);
    }
    state.pool.run(move || read(&payload.into_json(limit)?)).await?
}

/// Reads a JSON body with which nothing long is done, as long as any body may be.
pub async fn read_small<T: DeserializeOwned + ToSchema + Send + 'static>(
    state: &AppState,
    payload: Payload,
) -> Result<T, Problem> {
    read_small_json(state, payload, state.settings.body_limit, |text| Ok(value::read_json(text)?)).await
}

/// Reads a small JSON body that may be left out, on the pool.
pub async fn read_optional_json<T>(state: &AppState, payload: Payload) -> Result<T, Problem>
where
    T: DeserializeOwned + ToSchema + Default + Send + 'static,
{
    let limit = state.settings.body_limit;
    let read = move || {
        let (media, text) = (payload.media().clone(), payload.into_bytes(limit)?);
        if text.trim_ascii().is_empty() {
            return Ok(T::default());
        }
        match media {
            Media::Json => Ok(value::read_json(&text)?),
            Media::Multipart(other) | Media::Other(other) => Err(unsupported(&other, "application/json")),
        }
    };
    state.pool.run(read).await?
}
