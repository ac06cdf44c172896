//! The dashboard at `/`: static files in the program, a client of the same interface as any other.
//!
//! Every page of it is the one `index.html`, which the paths of the pages answer; what it loads
//! lies below `/assets/{digest}/`, where the digest is that of all files, so that a browser may
//! keep them for good and never mixes two versions.

pub mod files;

use self::files::Files;
use axum::http::Uri;

use super::prelude::*;
use crate::http::layers::headers::takes_gzip;

/// The paths of the pages, as `web/app/router.js` has them (a test compares the two).
pub const PAGES: &[&str] = &[
    "/",
    "/jobs",
    "/jobs/new",
    "/jobs/{job_id}",
    "/jobs/{job_id}/measure",
    "/jobs/{job_id}/iterations/{number}",
    "/jobs/{job_id}/streams/{stream_id}",
    "/fit",
    "/settings",
    "/jobs/{job_id}/iterations/{number}/lambda",
    "/jobs/{job_id}/iterations/{number}/evaluation",
    "/jobs/{job_id}/iterations/{number}/correction",
    "/jobs/{job_id}/trace",
    "/jobs/{job_id}/report",
    "/jobs/{job_id}/iterations/{number}/statistics",
];

/// Content security policy: a page may load files of this server and use its interface.
const POLICY: HeaderValue = HeaderValue::from_static(
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; worker-src 'self'; \
     base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'; \
     trusted-types assets",
);
/// Every use asks whether the page is still this one.
const NO_CACHE: HeaderValue = HeaderValue::from_static("no-cache");
/// The digest is in the path.
const FOR_GOOD: HeaderValue = HeaderValue::from_static("public, max-age=31536000, immutable");

/// The pages and their files.
pub fn routes(files: &Files) -> Router<AppState> {
    let (of_page, of_asset) = (files.clone(), files.clone());
    let answer = get(|| async move { page(&of_page) });
    let pages = PAGES.iter().fold(Router::new(), |router, path| router.route(path, answer.clone()));
    pages.route(
        "/assets/{digest}/{*file}",
        get(|PathOf((digest, name)): PathOf<(String, String)>, headers: HeaderMap| async move {
            asset(&of_asset, &digest, &name, &headers)
        }),
    )
}

/// Returns the answer to a path that does not exist.
pub fn no_path() -> Problem {
    Problem::new(ProblemCode::NotFound, "No such path; /docs lists all paths.")
}

/// Answers a path that does not exist: a browser gets the page that says so, any other client a
/// problem.
pub async fn not_found(State(state): State<AppState>, uri: Uri, headers: HeaderMap) -> Response {
    let accepted = headers.get(header::ACCEPT).and_then(|accepted| accepted.to_str().ok());
    let is_browser = accepted.is_some_and(|accepted| accepted.contains("text/html"));
    match &state.dashboard {
        Some(files) if is_browser && !uri.path().starts_with("/v1/") => {
            (StatusCode::NOT_FOUND, page(files)).into_response()
        }
        _ => no_path().into_response(),
    }
}

fn page(files: &Files) -> Result<Response, Problem> {
    let text = files.index().map_err(Problem::internal)?;
    let tag = content_tag(text.as_bytes());
    let mut response = text.into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8"));
    headers.insert("cross-origin-opener-policy", HeaderValue::from_static("same-origin"));
    guard(headers, NO_CACHE, tag);
    Ok(response)
}

fn asset(files: &Files, digest: &str, name: &str, headers: &HeaderMap) -> Result<Response, Problem> {
    if digest != files.digest() {
        let detail = "The dashboard has been updated; load the page again.";
        return Err(Problem::new(ProblemCode::NotFound, detail));
    }
    let missing = || Problem::new(ProblemCode::NotFound, "The dashboard has no such file.");
    let file = files.file(name).ok_or_else(missing)?;
    let packed = takes_gzip(headers).then(|| file.packed()).flatten();
    let encoding = packed.is_some().then_some(HeaderValue::from_static("gzip"));
    let tag = content_tag(&file.bytes);
    let mut response = packed.unwrap_or_else(|| file.bytes.clone()).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(file.media));
    if let Some(encoding) = encoding {
        headers.insert(header::CONTENT_ENCODING, encoding);
        headers.insert(header::VARY, HeaderValue::from_static("accept-encoding"));
    }
    guard(headers, if files.may_be_kept() { FOR_GOOD } else { NO_CACHE }, tag);
    Ok(response)
}

/// A worker is under the policy of its own file.
fn guard(headers: &mut HeaderMap, kept: HeaderValue, tag: Option<HeaderValue>) {
    headers.insert(header::CONTENT_SECURITY_POLICY, POLICY);
    headers.insert(header::CACHE_CONTROL, kept);
    headers.extend(tag.map(|tag| (header::ETAG, tag)));
}
