//! Intervals of server-sent events, which are no options.

use std::time::Duration;

/// See the module's documentation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    /// Time between two looks at the progress of a request. A problem that is found before the
    /// first is returned as that of a plain request.
    pub look: Duration,
    /// Silence after which a comment keeps proxies from closing the connection.
    pub comment: Duration,
}

impl Default for Pace {
    fn default() -> Self {
        Pace { look: Duration::from_secs(1), comment: Duration::from_secs(10) }
    }
}
