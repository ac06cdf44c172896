//! Fields beside those that every request of a kind has.

use serde::de::DeserializeOwned;

/// Fields that a request has beside those of a fit, such as an iteration's `operator`.
///
/// Deserialised from an object that holds only [`Extra::KEYS`]; optional fields should be
/// `#[serde(default)]`. Unknown keys of the request are refused before.
pub trait Extra: DeserializeOwned {
    /// The keys at the top level of the request.
    const KEYS: &'static [&'static str];
}

/// No further fields.
#[derive(Clone, Copy, Debug, Default, serde::Deserialize)]
pub struct NoExtra {}

impl Extra for NoExtra {
    const KEYS: &'static [&'static str] = &[];
}
