//! Answers that are files.

use super::prelude::*;
use super::{body::Payload, chunked};
use crate::api::{problem::Room, shapes::export::File};

/// The file that `write` makes of a JSON body, to be kept under its name. It is sent as it is made.
pub async fn attachment(
    state: AppState,
    payload: Payload,
    write: impl FnOnce(&[u8], Room) -> Result<File, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    let (limit, mut permit) = (state.settings.body_limit, state.budget.permit());
    let work = move || {
        let text = payload.into_json(limit)?;
        let mut file = write(&text, &mut |bytes| permit.grow_with(text.permit(), bytes))?;
        let first = file.content.next_piece(chunked::PIECE).unwrap_or_default();
        Ok::<_, Problem>((file, first, permit))
    };
    let (File { name, media, content }, first, permit) = state.pool.run(work).await??;
    let mut response = Response::new(chunked::body(state, first, content, permit));
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(media));
    if let Ok(disposition) = HeaderValue::from_str(&format!("attachment; filename=\"{name}\"")) {
        headers.insert(header::CONTENT_DISPOSITION, disposition);
    }
    Ok(response)
}
