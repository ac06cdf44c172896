//! Answers that are files.

use axum::{
    http::{HeaderValue, header},
    response::{IntoResponse, Response},
};

use crate::api::shapes::export::File;

/// A file to be kept under its name.
pub fn attachment(file: File) -> Response {
    let File { name, media, bytes } = file;
    let mut response = bytes.into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(media));
    if let Ok(disposition) = HeaderValue::from_str(&format!("attachment; filename=\"{name}\"")) {
        headers.insert(header::CONTENT_DISPOSITION, disposition);
    }
    response
}
