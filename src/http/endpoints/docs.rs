//! The interactive documentation at `/docs`, from files inside the program: it works without
//! internet.

use std::io::Read;

use axum::response::Redirect;
use utoipa_swagger_ui::Config;

use super::prelude::*;
use crate::http::layers::headers::takes_gzip;

pub fn routes() -> Router<AppState> {
    // Without this the page would ask a validator on the internet about the document.
    let config = Arc::new(Config::from("/openapi.json").validator_url("none").display_operation_id(true));
    let index = Arc::clone(&config);
    Router::new()
        .route("/docs", get(|| async { Redirect::permanent("/docs/") }))
        .route("/docs/", get(|headers: HeaderMap| async move { file("", &headers, index) }))
        .route(
            "/docs/{*file}",
            get(|PathOf(name): PathOf<String>, headers: HeaderMap| async move { file(&name, &headers, config) }),
        )
}

/// Shows the documentation at `/` if there is no dashboard.
pub fn at_root() -> Router<AppState> {
    Router::new().route("/", get(|| async { Redirect::temporary("/docs/") }))
}

/// The files lie in the program as gzip, and go out so to clients that take it.
fn file(name: &str, headers: &HeaderMap, config: Arc<Config<'static>>) -> Result<Response, Problem> {
    let file = utoipa_swagger_ui::serve(name, config)
        .map_err(Problem::internal)?
        .ok_or_else(|| Problem::new(ProblemCode::NotFound, "The documentation has no such file."))?;
    let tag = content_tag(&file.bytes);
    let packed = file.gzpipped && takes_gzip(headers);
    let bytes = match file.gzpipped && !packed {
        true => unpacked(&file.bytes).map_err(Problem::internal)?,
        false => file.bytes.into_owned(),
    };
    let mut response = Bytes::from(bytes).into_response();
    let headers = response.headers_mut();
    let media = HeaderValue::from_str(&file.content_type).map_err(Problem::internal)?;
    headers.insert(header::CONTENT_TYPE, media);
    // The page and its settings are of this server; all else belongs to a version of the
    // documentation's program.
    if !matches!(name, "" | "index.html" | "swagger-initializer.js") {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("public, max-age=604800"));
    }
    headers.extend(tag.map(|tag| (header::ETAG, tag)));
    if packed {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
        headers.insert(header::VARY, HeaderValue::from_static("accept-encoding"));
    }
    Ok(response)
}

fn unpacked(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut text = Vec::new();
    flate2::bufread::GzDecoder::new(bytes).read_to_end(&mut text)?;
    Ok(text)
}
