//! Requests that a browser makes for a web page of another site: it may not change anything here,
//! and it may not reach this server under a name of its own.

use super::media_type::essence;
use super::prelude::*;
use crate::config::{Host, Hosts, Origin};

/// Header in which a browser describes the page that makes a request.
const FETCH_SITE: &str = "sec-fetch-site";

/// Refuses a change for a page of another site, and a host that is not this one.
pub fn check(state: &AppState, method: &Method, headers: &HeaderMap) -> Result<(), Problem> {
    if !method.is_safe() && !is_of_this_site(headers, &state.settings.cors_origins) {
        let detail = "A web page of another site requests a change; its origin is not among --cors-origins.";
        return Err(Problem::new(ProblemCode::CrossSite, detail));
    }
    match headers.get(header::HOST) {
        Some(host) if !is_served(state, host) => {
            let detail = "The header `Host` names a host that this server does not serve; --allowed-hosts adds it.";
            Err(Problem::new(ProblemCode::UnknownHost, detail))
        }
        _ => Ok(()),
    }
}

/// A browser sends forms of any page without a preflight, so its `Sec-Fetch-Site` decides. Browsers
/// that do not send that header (older ones, and all if the server has no TLS) send `Origin`. Other
/// clients send neither.
fn is_of_this_site(headers: &HeaderMap, allowed: &[Origin]) -> bool {
    match headers.get(FETCH_SITE) {
        Some(site) => matches!(site.as_bytes(), b"same-origin" | b"none") || names_origin(headers, allowed),
        None => is_own_origin(headers) || names_origin(headers, allowed) || !is_sent_without_preflight(headers),
    }
}

/// Whether the page is of an origin allowed by the settings.
fn names_origin(headers: &HeaderMap, allowed: &[Origin]) -> bool {
    let origin = headers.get(header::ORIGIN).map(HeaderValue::as_bytes);
    allowed.iter().any(|allowed| Some(allowed.as_str().as_bytes()) == origin)
}

/// Whether the page is this server's own, or there is none.
fn is_own_origin(headers: &HeaderMap) -> bool {
    let Some(origin) = headers.get(header::ORIGIN) else { return true };
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok());
    let own = origin.to_str().ok().and_then(|origin| origin.split_once("://")).map(|(_, host)| host);
    own.is_some() && own == host
}

/// Whether a browser sends such a body for a page of any site without a preflight.
fn is_sent_without_preflight(headers: &HeaderMap) -> bool {
    let Some(media) = headers.get(header::CONTENT_TYPE) else { return true };
    let media = media.to_str().map(essence).unwrap_or_default();
    ["multipart/form-data", "application/x-www-form-urlencoded", "text/plain", ""].contains(&media.as_str())
}

/// Whether a page may open a WebSocket, for which browsers send no preflight: its origin is this
/// server's own, or an allowed one.
pub fn may_connect(headers: &HeaderMap, allowed: &[Origin]) -> bool {
    is_own_origin(headers) || names_origin(headers, allowed)
}

fn is_served(state: &AppState, host: &HeaderValue) -> bool {
    let settings = &state.settings;
    let asked = || host.to_str().ok().and_then(Host::read);
    match &settings.allowed_hosts {
        Hosts::Any => true,
        Hosts::Named(hosts) => asked().is_some_and(|asked| hosts.iter().any(|host| host.is(&asked))),
        // where everybody on this machine may ask, a page of a name that leads here must not
        Hosts::Usual if settings.bind.ip().is_loopback() => {
            state.callers.key_required() || asked().is_some_and(|asked| asked.is_this_machine())
        }
        Hosts::Usual => true,
    }
}
