//! Optional fields.

use serde::{Deserialize, Deserializer};

/// An optional field; `null` counts as absent.
pub fn present<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    Option::deserialize(deserializer)
}
