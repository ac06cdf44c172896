//! Optional fields.

use serde::{Deserialize, Deserializer};

/// An optional field is left out or has a value; `null` is refused like any other wrong type.
pub fn present<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}
