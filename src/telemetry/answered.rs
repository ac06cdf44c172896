//! Metrics of every request and fit.

use std::time::Duration;

use metrics::{Counter, Histogram, Label};

use super::{AUTHENTICATIONS, FIT_SECONDS, REQUEST_SECONDS, REQUESTS, series::Known};

/// Counts and durations of the requests on one route, by method and status.
type Answers = Vec<((&'static str, u16), (Counter, Histogram))>;

thread_local! {
    static ANSWERS: Known<String, Answers> = Known::default();
    static CALLERS: Known<&'static str, Counter> = Known::default();
    static FITS: Known<&'static str, Histogram> = Known::default();
}

/// Records the response to a request.
pub fn record_answer(method: &'static str, route: &str, status: u16, elapsed: Duration) {
    ANSWERS.with(|answers| {
        answers.with(
            route,
            |_| Answers::new(),
            |answers| {
                let known = answers.iter().position(|(of, _)| *of == (method, status)).unwrap_or_else(|| {
                    answers.push(((method, status), series_of(method, route, status)));
                    answers.len() - 1
                });
                let (_, (count, seconds)) = &answers[known];
                count.increment(1);
                seconds.record(elapsed.as_secs_f64());
            },
        );
    });
}

fn series_of(method: &'static str, route: &str, status: u16) -> (Counter, Histogram) {
    let labels = vec![
        Label::new("method", method),
        Label::new("path", route.to_owned()),
        Label::new("status", status.to_string()),
    ];
    (metrics::counter!(REQUESTS, labels.clone()), metrics::histogram!(REQUEST_SECONDS, labels))
}

/// Notes what the key of a request was.
pub fn record_authentication(outcome: &'static str) {
    let find = |outcome: &&'static str| metrics::counter!(AUTHENTICATIONS, "outcome" => *outcome);
    CALLERS.with(|callers| callers.with(&outcome, find, |count| count.increment(1)));
}

/// Notes how long a fit of `nodes` nodes took.
pub fn record_fit(nodes: usize, elapsed: Duration) {
    let find = |size: &&'static str| metrics::histogram!(FIT_SECONDS, "size" => *size);
    FITS.with(|fits| fits.with(&size_class(nodes), find, |seconds| seconds.record(elapsed.as_secs_f64())));
}

fn size_class(nodes: usize) -> &'static str {
    match nodes {
        0..=100 => "le_100",
        101..=1_000 => "le_1000",
        1_001..=10_000 => "le_10000",
        10_001..=100_000 => "le_100000",
        100_001..=1_000_000 => "le_1000000",
        _ => "gt_1000000",
    }
}
