//! How far a request is (`Accept: text/event-stream`).

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The `data` of an event `progress`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Progress, example = json!({"progress": 0.25, "remaining_seconds": 12.0}))]
pub struct ProgressBody {
    /// Completed share of the work, from 0 to 1, as reported by the computation.
    pub progress: f64,
    /// Estimated seconds until the response; absent where there is no estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remaining_seconds: Option<f64>,
}

/// Least progress, and least seconds, from which the time left is estimated.
const ESTIMATED_FROM: (f64, f64) = (0.01, 1.0);

impl ProgressBody {
    /// After so many seconds of work.
    pub fn of(progress: f64, seconds: f64) -> Self {
        let is_known = progress >= ESTIMATED_FROM.0 && seconds >= ESTIMATED_FROM.1;
        // to the tenth: more would pretend
        let left = || (10.0 * seconds * (1.0 - progress) / progress).round() / 10.0;
        ProgressBody { progress, remaining_seconds: is_known.then(left) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_estimated_once_there_is_something_to_estimate_from() {
        let left = |progress, seconds| ProgressBody::of(progress, seconds).remaining_seconds;
        assert_eq!((left(0.0, 60.0), left(0.005, 60.0), left(0.5, 0.5)), (None, None, None));
        assert_eq!((left(0.25, 4.0), left(0.3, 1.0), left(1.0, 9.0)), (Some(12.0), Some(2.3), Some(0.0)));
    }
}
