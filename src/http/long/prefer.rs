//! The header `Prefer` (RFC 7240): `respond-async` and `wait`. What is not known there, or does not
//! read, is as if it were not there.

use std::time::Duration;

use axum::http::{HeaderMap, HeaderName, HeaderValue};

static PREFER: HeaderName = HeaderName::from_static("prefer");
pub static APPLIED: HeaderName = HeaderName::from_static("preference-applied");

/// What a client would like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Preference {
    /// An answer at once, which tells where the other one will be.
    pub respond_async: bool,
    /// How long it would wait, in seconds.
    pub wait: Option<u32>,
}

impl Preference {
    /// Returns the value of a preference; of a repeated one the first.
    pub fn of(headers: &HeaderMap) -> Self {
        let mut found = Preference::default();
        let values = headers.get_all(&PREFER).iter().filter_map(|value| value.to_str().ok());
        for preference in values.flat_map(|value| value.split(',')) {
            let said = preference.split(';').next().unwrap_or_default();
            let (name, value) = said.split_once('=').unwrap_or((said, ""));
            let (name, value) = (name.trim(), value.trim().trim_matches('"'));
            if name.eq_ignore_ascii_case("respond-async") {
                found.respond_async = true;
            } else if name.eq_ignore_ascii_case("wait") {
                found.wait = found.wait.or(value.parse().ok());
            }
        }
        found
    }

    /// How long is waited, where a request is answered within `limit`.
    pub fn waiting(self, limit: Duration) -> Option<Duration> {
        // what is left is for the answer
        self.wait.map(|seconds| Duration::from_secs(seconds.into()).min(limit.saturating_sub(MARGIN)))
    }

    /// What is said of a wait.
    pub fn waited(self) -> Option<HeaderValue> {
        HeaderValue::from_str(&format!("wait={}", self.wait?)).ok()
    }
}

/// Between the end of a wait and the end of its request's time.
const MARGIN: Duration = Duration::from_secs(2);

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[&'static str]) -> (bool, Option<u32>) {
        let headers = values.iter().map(|value| (PREFER.clone(), HeaderValue::from_static(value))).collect();
        let Preference { respond_async, wait } = Preference::of(&headers);
        (respond_async, wait)
    }

    #[test]
    fn preferences_are_found_in_every_form_and_what_is_not_known_is_none() {
        assert_eq!(of(&[]), (false, None));
        assert_eq!(of(&["respond-async"]), (true, None));
        assert_eq!(of(&["Respond-Async, wait=10"]), (true, Some(10)));
        assert_eq!(of(&["wait = \"7\"; foo", "respond-async;x=y"]), (true, Some(7)));
        assert_eq!(of(&["wait=1, wait=2"]), (false, Some(1)));
        for nothing in ["", ",", "return=minimal", "respond-asynchronously", "wait", "wait=-1", "wait=1.5"] {
            assert_eq!(of(&[nothing]), (false, None), "{nothing}");
        }
    }

    #[test]
    fn waits_end_before_their_request() {
        let preference = Preference { respond_async: false, wait: Some(60) };
        let within = |limit| preference.waiting(Duration::from_secs(limit)).unwrap().as_secs();
        assert_eq!([within(120), within(62), within(30), within(1)], [60, 60, 28, 0]);
        assert_eq!(Preference::default().waiting(Duration::from_secs(9)), None);
        assert_eq!(preference.waited().unwrap(), "wait=60");
    }
}
