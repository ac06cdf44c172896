//! The contract of each operation, checked for every request before its handler: the scope that its
//! caller needs, its query parameters, its media types, and whether it offers progress. Handlers
//! read the values of parameters; where there are several media types they choose.

use std::collections::{HashMap, HashSet};

use axum::{
    extract::{MatchedPath, Query, State},
    http::Uri,
};
use utoipa::openapi::{
    OpenApi as Document, RefOr,
    path::{Operation as Declared, ParameterIn},
};

use super::prelude::*;
use super::{
    accept,
    auth::Principal,
    progress::{self, EVENT_STREAM},
};
use crate::{
    api::{
        faults::Faults,
        json::{location::escape, wording::alternatives},
    },
    http::openapi::scopes,
    jobs::Scope,
};

/// The operations of the contract by their paths.
#[derive(Clone, Debug)]
pub struct Operations(Arc<HashMap<String, Vec<(Method, Operation)>>>);

#[derive(Debug)]
struct Operation {
    /// Scope that its caller needs; none outside of the versioned interface.
    access: Access,
    /// Names of its query parameters.
    parameters: Vec<String>,
    /// Media types of its successful response; empty if that has no body.
    media: Vec<String>,
}

/// Who may ask for an operation.
#[derive(Clone, Copy, Debug)]
enum Access {
    Everybody,
    /// Whoever has the scope; no caller where the document names none.
    Scope(Option<Scope>),
}

/// Refuses a caller who may not ask for the operation, and then what the operation has not got.
pub async fn check(
    State((operations, state)): State<(Operations, AppState)>,
    request: Request,
    next: Next,
) -> Response {
    let path = request.extensions().get::<MatchedPath>();
    let operation = path.and_then(|path| operations.get(path.as_str(), request.method()));
    if let Some(operation) = operation
        && let Err(problem) = operation.access.check(request.extensions().get())
    {
        telemetry::record_authentication("forbidden");
        return problem.into_response();
    }
    let checked = operation.map_or(Ok(()), |operation| operation.check(request.uri(), request.headers()));
    match checked {
        Ok(()) if operation.is_some_and(|operation| operation.shows_progress(&request)) => {
            progress::respond(state, request, next).await
        }
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    }
}

impl Operations {
    pub fn of(document: &Document) -> Self {
        let operations = |path: &str, item: &utoipa::openapi::PathItem| {
            let declared = [
                (Method::GET, &item.get),
                (Method::PUT, &item.put),
                (Method::POST, &item.post),
                (Method::DELETE, &item.delete),
                (Method::PATCH, &item.patch),
            ];
            declared
                .into_iter()
                .filter_map(|(method, one)| Some((method, Operation::of(path, one.as_ref()?))))
                .collect()
        };
        let paths = document.paths.paths.iter().map(|(path, item)| (path.clone(), operations(path, item)));
        Operations(Arc::new(paths.collect()))
    }

    fn get(&self, path: &str, method: &Method) -> Option<&Operation> {
        // HEAD is a GET whose body is not sent
        let method = if method == Method::HEAD { &Method::GET } else { method };
        self.0.get(path)?.iter().find(|(known, _)| known == method).map(|(_, operation)| operation)
    }
}

impl Access {
    fn check(self, principal: Option<&Principal>) -> Result<(), Problem> {
        let detail = match (self, principal) {
            (Access::Everybody, _) => return Ok(()),
            (Access::Scope(Some(scope)), Some(principal)) if principal.scopes.contains(scope) => return Ok(()),
            (Access::Scope(Some(scope)), Some(principal)) => format!(
                "This needs the scope `{}`; this caller has {}.",
                scope.name(),
                principal.scopes.iter().map(|scope| format!("`{}`", scope.name())).collect::<Vec<_>>().join(", ")
            ),
            (Access::Scope(_), _) => "No caller may do this.".to_owned(),
        };
        Err(Problem::lacking_scope(detail))
    }
}

impl Operation {
    fn of(path: &str, declared: &Declared) -> Self {
        let parameters = declared.parameters.iter().flatten().filter_map(|parameter| match parameter {
            RefOr::T(parameter) if parameter.parameter_in == ParameterIn::Query => Some(parameter.name.clone()),
            _ => None,
        });
        let responses = declared.responses.responses.iter();
        let good = responses.filter(|(status, _)| status.starts_with('2'));
        let media = good.flat_map(|(_, response)| match response {
            RefOr::T(response) => response.content.keys().cloned().collect(),
            RefOr::Ref(_) => Vec::new(),
        });
        let access = match path.starts_with("/v1/") {
            true => Access::Scope(scopes::of(declared)),
            false => Access::Everybody,
        };
        Operation { access, parameters: parameters.collect(), media: media.collect() }
    }

    /// Returns whether a POST is to be answered with progress: where the document offers it, and
    /// the client prefers it to the plain answer.
    fn shows_progress(&self, request: &Request) -> bool {
        let [events, json] = [EVENT_STREAM, "application/json"].map(|of| accept::preference(request.headers(), of));
        let offered = self.media.iter().any(|media| media == EVENT_STREAM);
        request.method() == Method::POST && offered && events > json
    }

    fn check(&self, uri: &Uri, headers: &HeaderMap) -> Result<(), Problem> {
        if !uri.query().is_none_or(is_text) {
            let detail = "The query of the URL has bytes that are not UTF-8.";
            return Err(Problem::new(ProblemCode::MalformedRequest, detail));
        }
        self.check_query(uri).map_err(Problem::invalid)?;
        if self.media.is_empty() || self.media.iter().any(|media| accept::preference(headers, media).quality > 0.0) {
            return Ok(());
        }
        let media = alternatives(self.media.iter().map(String::as_str));
        let detail = format!("The response is {media}, which the header `accept` excludes; omit it or send */*.");
        Err(Problem::new(ProblemCode::NotAcceptable, detail))
    }

    fn check_query(&self, uri: &Uri) -> Result<(), Faults> {
        let mut faults = Faults::default();
        let Ok(Query(given)) = Query::<Vec<(String, String)>>::try_from_uri(uri) else { return Ok(()) };
        let mut before = HashSet::new();
        for (name, _) in &given {
            let pointer = || format!("/{}", escape(name));
            if !self.parameters.contains(name) {
                faults.push(pointer(), self.unknown());
            } else if !before.insert(name) {
                faults.push(pointer(), "the query parameter occurs twice; give it once");
            }
        }
        faults.into_result(())
    }

    fn unknown(&self) -> String {
        match self.parameters.is_empty() {
            true => "there is no such query parameter; this operation has none".to_owned(),
            false => {
                let known = alternatives(self.parameters.iter().map(|name| format!("`{name}`")));
                format!("there is no such query parameter; expected {known}")
            }
        }
    }
}

/// Whether a query is UTF-8 after percent-decoding.
fn is_text(query: &str) -> bool {
    let mut bytes = Vec::with_capacity(query.len());
    let mut rest = query.as_bytes();
    while let [first, after @ ..] = rest {
        let encoded = after.get(..2).and_then(|digits| u8::from_str_radix(str::from_utf8(digits).ok()?, 16).ok());
        let (byte, left) = match encoded {
            Some(byte) if *first == b'%' => (byte, &after[2..]),
            _ => (*first, after),
        };
        bytes.push(byte);
        rest = left;
    }
    str::from_utf8(&bytes).is_ok()
}

#[cfg(test)]
mod tests {
    use super::is_text;

    #[test]
    fn bytes_that_are_no_text_are_found() {
        for text in ["", "q=a+b", "q=%C3%A9&%C3%a9=1", "q=%", "q=%f", "q=%zz", "q=%+1", "q=%25ff"] {
            assert!(is_text(text), "{text}");
        }
        for bytes in ["%ff", "q=%C3", "q=%C3&%A9=1", "a=1&%FF=2"] {
            assert!(!is_text(bytes), "{bytes}");
        }
    }
}
