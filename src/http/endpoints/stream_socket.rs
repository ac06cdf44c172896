//! `GET /v1/streams/{stream_id}/ws`: blocks and their responses over a WebSocket, for probes that
//! send node by node.
//!
//! Messages are those of `POST /v1/streams/{stream_id}/nodes`, one answer for each, in order; a
//! refusal is the problem that the request would have got, and the connection goes on. One block at
//! a time: who sends faster is slowed down by the connection itself. A client that leaves takes the
//! block that is being worked on along, unless the store has it already.

use axum::extract::ws::{
    CloseFrame, Message, Utf8Bytes, WebSocket, WebSocketUpgrade, close_code, rejection::WebSocketUpgradeRejection,
};

use super::prelude::*;
use super::streams;
use crate::{
    api::streams::stream,
    http::{
        layers::{observe::too_late, sites},
        shutdown::OpenConnection,
    },
    pool,
};

/// Time between two pings.
const PING: Duration = Duration::from_secs(20);
/// Pings that may stay without any sign of life.
const SILENT_PINGS: u32 = 3;
/// Longest message: what has come of one is in memory until it is whole. Larger blocks are posted.
const LONGEST_MESSAGE: usize = 1 << 20;
/// How long a message may wait for a client that does not read.
const SEND: Duration = Duration::from_secs(60);

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(connect_stream))
}

/// Connect to a stream by WebSocket
///
/// Each message is a body of `POST /v1/streams/{stream_id}/nodes` and gets the response of that
/// request. A problem is sent as a JSON message with its `code`, and the connection stays open.
#[utoipa::path(
    get, path = "/v1/streams/{stream_id}/ws", operation_id = "connect_stream", tag = "streams",
    responses(
        (status = 101, description = "A WebSocket. Client: StreamBlock; server: StreamEstimate, or Problem. It is \
            closed when the stream is finished or deleted, when the server stops, and (1008) when the \
            caller's key or token ends."),
        (status = 400, description = "Not a WebSocket request."),
        (status = 403, description = "A web page of an origin that `--cors-origins` does not name."),
        (status = 409, description = "The stream is finished.")
    )
)]
async fn connect_stream(
    state: CallerState,
    PathOf(id): PathOf<Uuid>,
    headers: HeaderMap,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Result<Response, Problem> {
    if !sites::may_connect(&headers, &state.settings.cors_origins) {
        let detail = "Web pages of this origin may not connect: name it in `--cors-origins`.";
        return Err(Problem::new(ProblemCode::Forbidden, detail));
    }
    state.jobs.stream(id).await?.check_open()?;
    let upgrade = upgrade.map_err(|rejection| {
        Problem::new(ProblemCode::MalformedRequest, format!("This path needs WebSocket: {}.", rejection.body_text()))
    })?;
    let open = state.shutdown.register("websocket", state.settings.max_connections)?;
    let limit = state.settings.body_limit.min(LONGEST_MESSAGE);
    Ok(upgrade.max_message_size(limit).max_frame_size(limit).on_upgrade(move |socket| {
        let party = state.principal.party();
        pool::on_behalf_of(party, serve(state, id, socket, open))
    }))
}

/// Why a connection ends.
enum SessionEnd {
    /// The client is gone or does not read.
    Gone,
    /// The client closes, and is owed an answer.
    Left,
    /// We close it.
    Close(u16, &'static str),
}

async fn serve(state: CallerState, id: Uuid, mut socket: WebSocket, _open: OpenConnection) {
    match session(&state, id, &mut socket).await {
        SessionEnd::Gone => {}
        // The answer to a close is made when it is read, and goes out with the next look for a
        // message (RFC 6455, 5.5.1).
        SessionEnd::Left => {
            let _gone = tokio::time::timeout(SEND, socket.recv()).await;
        }
        SessionEnd::Close(code, reason) => {
            let frame = CloseFrame { code, reason: Utf8Bytes::from_static(reason) };
            let _gone = tokio::time::timeout(SEND, socket.send(Message::Close(Some(frame)))).await;
        }
    }
}

async fn session(state: &CallerState, id: Uuid, socket: &mut WebSocket) -> SessionEnd {
    let mut ends = state.jobs.listen_for_stream_ends();
    let mut stopped = std::pin::pin!(state.shutdown.begun());
    let mut refused = state.refused();
    let mut pings = tokio::time::interval_at(tokio::time::Instant::now() + PING, PING);
    let mut silent = 0;
    // what came while a block was worked on
    let mut pending: Option<Message> = None;
    // it may have ended between the upgrade and now
    if let Some(end) = ended(state, id).await {
        return end;
    }
    loop {
        tokio::select! {
            () = &mut stopped => return SessionEnd::Close(close_code::AWAY, "the server stops"),
            problem = &mut refused => return match problem.is(ProblemCode::InvalidKey) {
                true => SessionEnd::Close(close_code::POLICY, "the key or the token cannot be used any more"),
                false => SessionEnd::Close(close_code::AGAIN, "the store cannot be used now"),
            },
            _ = ends.changed() => {
                if let Some(end) = ended(state, id).await {
                    return end;
                }
            }
            _ = pings.tick() => {
                silent += 1;
                if silent > SILENT_PINGS || !send(socket, Message::Ping(Default::default())).await {
                    return SessionEnd::Gone;
                }
            }
            message = received(&mut pending, socket) => {
                silent = 0;
                let text = match message {
                    Some(Ok(Message::Text(text))) => text.as_bytes().to_vec(),
                    Some(Ok(Message::Binary(bytes))) => bytes.to_vec(),
                    Some(Ok(Message::Ping(_) | Message::Pong(_))) => continue,
                    Some(Ok(Message::Close(_))) => return SessionEnd::Left,
                    None => return SessionEnd::Gone,
                    Some(Err(error)) => {
                        tracing::debug!(%error, stream = %id, "WebSocket closed after a read error");
                        return SessionEnd::Close(close_code::SIZE, "a message could not be read, or was too large");
                    }
                };
                let answer = tokio::select! {
                    answer = block(state, id, text) => answer,
                    () = left(socket, &mut pending) => return SessionEnd::Left,
                };
                if !send(socket, Message::Text(answer)).await {
                    return SessionEnd::Gone;
                }
            }
        }
    }
}

/// The message that waits, or the next one.
async fn received(pending: &mut Option<Message>, socket: &mut WebSocket) -> Option<Result<Message, axum::Error>> {
    match pending.take() {
        Some(message) => Some(Ok(message)),
        None => socket.recv().await,
    }
}

/// Ready when the client leaves. One block that it sends ahead is taken, so that its leaving is
/// seen behind it only when that one's turn has come.
async fn left(socket: &mut WebSocket, pending: &mut Option<Message>) {
    loop {
        match socket.recv().await {
            Some(Ok(Message::Ping(_) | Message::Pong(_))) => {}
            Some(Ok(message @ (Message::Text(_) | Message::Binary(_)))) => {
                *pending = Some(message);
                return std::future::pending().await;
            }
            Some(Ok(Message::Close(_)) | Err(_)) | None => return,
        }
    }
}

async fn send(socket: &mut WebSocket, message: Message) -> bool {
    matches!(tokio::time::timeout(SEND, socket.send(message)).await, Ok(Ok(())))
}

/// Whether the stream takes no more nodes.
async fn ended(state: &CallerState, id: Uuid) -> Option<SessionEnd> {
    match state.jobs.stream(id).await {
        Ok(stream) if stream.iteration.is_some() => {
            Some(SessionEnd::Close(close_code::NORMAL, "the stream is finished"))
        }
        Err(RepositoryError::Purged { .. }) => Some(SessionEnd::Close(close_code::NORMAL, "the job is purged")),
        Err(RepositoryError::NotFound(_)) => Some(SessionEnd::Close(close_code::NORMAL, "the stream is deleted")),
        // a store that does not answer now says so at the next block
        Ok(_) | Err(_) => None,
    }
}

/// The answer to one message.
async fn block(state: &CallerState, id: Uuid, text: Vec<u8>) -> Utf8Bytes {
    let outcome = async {
        let permit = state.budget.take(text.len())?;
        let text = WithPermit::new(text, permit);
        let block = state.pool.run(move || stream::read_block(&text)).await??;
        streams::add_block(state, id, block, None).await
    };
    let outcome = tokio::time::timeout(state.settings.request_timeout(), outcome).await;
    let bytes = match outcome.unwrap_or_else(|_elapsed| Err(too_late(state.settings.request_timeout))) {
        Ok(answer) => answer.body,
        Err(mut problem) => {
            if let Some(cause) = problem.cause.take() {
                tracing::error!(stream = %id, code = %problem.code, cause, "problem");
            }
            text_of(&problem).into_bytes()
        }
    };
    // both are JSON, which is UTF-8
    Utf8Bytes::try_from(bytes).unwrap_or_default()
}
