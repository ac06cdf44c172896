//! The interactive documentation at `/docs`, from files inside the program: it works without internet.

use std::sync::Arc;

use axum::{
    Router,
    body::Bytes,
    http::{HeaderValue, header},
    response::{IntoResponse, Redirect, Response},
    routing::get,
};
use utoipa_swagger_ui::Config;

use super::{conditional::content_tag, extract::PathOf, state::AppState};
use crate::api::problem::{Problem, ProblemCode};

pub fn routes() -> Router<AppState> {
    // Without this the page would ask a validator on the internet about the document.
    let config = Arc::new(Config::from("/openapi.json").validator_url("none").display_operation_id(true));
    let index = Arc::clone(&config);
    Router::new()
        .route("/", get(|| async { Redirect::temporary("/docs/") }))
        .route("/docs", get(|| async { Redirect::permanent("/docs/") }))
        .route("/docs/", get(|| async { file("", index) }))
        .route("/docs/{*file}", get(|PathOf(name): PathOf<String>| async move { file(&name, config) }))
}

fn file(name: &str, config: Arc<Config<'static>>) -> Result<Response, Problem> {
    let file = utoipa_swagger_ui::serve(name, config)
        .map_err(Problem::internal)?
        .ok_or_else(|| Problem::new(ProblemCode::NotFound, "The documentation has no such file."))?;
    let tag = content_tag(&file.bytes);
    let mut response = Bytes::from(file.bytes.into_owned()).into_response();
    let headers = response.headers_mut();
    let media = HeaderValue::from_str(&file.content_type).map_err(Problem::internal)?;
    headers.insert(header::CONTENT_TYPE, media);
    // The page and its settings are of this server; all else belongs to a version of the documentation's program.
    if !matches!(name, "" | "index.html" | "swagger-initializer.js") {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("public, max-age=604800"));
    }
    headers.extend(tag.map(|tag| (header::ETAG, tag)));
    if file.gzpipped {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    Ok(response)
}
