//! A part that many results share.

use std::ops::Deref;

/// A part of results that is computed once for many of them. With the feature `contract` its JSON
/// text is also written once.
#[derive(Debug)]
pub struct Shared<T> {
    value: T,
    #[cfg(feature = "contract")]
    text: std::sync::OnceLock<Box<serde_json::value::RawValue>>,
}

impl<T> From<T> for Shared<T> {
    fn from(value: T) -> Self {
        Shared {
            value,
            #[cfg(feature = "contract")]
            text: Default::default(),
        }
    }
}

impl<T> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T: Clone> Clone for Shared<T> {
    fn clone(&self) -> Self {
        self.value.clone().into()
    }
}

impl<T: PartialEq> PartialEq for Shared<T> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

#[cfg(feature = "contract")]
impl<T: serde::Serialize> serde::Serialize for Shared<T> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if let Some(text) = self.text.get() {
            return text.serialize(serializer);
        }
        let text = serde_json::value::to_raw_value(&self.value).map_err(serde::ser::Error::custom)?;
        self.text.get_or_init(|| text).serialize(serializer)
    }
}

#[cfg(feature = "contract")]
impl<'de, T: serde::Deserialize<'de>> serde::Deserialize<'de> for Shared<T> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::deserialize(deserializer).map(Shared::from)
    }
}
