//! Finished JSON within an answer.

use std::{marker::PhantomData, sync::Arc};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::DeserializeOwned, ser::Error};
use serde_json::value::RawValue;

/// JSON text of a `T`, which is written as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Raw<T> {
    text: Arc<str>,
    of: PhantomData<T>,
}

impl<T: DeserializeOwned> Raw<T> {
    /// Returns the value.
    pub fn value(&self) -> serde_json::Result<T> {
        serde_json::from_str(&self.text)
    }
}

impl<T, S: Into<Arc<str>>> From<S> for Raw<T> {
    fn from(text: S) -> Self {
        Raw { text: text.into(), of: PhantomData }
    }
}

impl<T> Serialize for Raw<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serde_json::from_str::<&RawValue>(&self.text).map_err(S::Error::custom)?.serialize(serializer)
    }
}

impl<'de, T> Deserialize<'de> for Raw<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Box::<RawValue>::deserialize(deserializer)?.get().into())
    }
}
