//! Finished JSON within an answer.

use std::marker::PhantomData;

use serde::{Deserialize, Deserializer, Serialize, Serializer, ser::Error};
use serde_json::value::RawValue;

/// JSON text of a `T`, which is written as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Raw<T> {
    text: String,
    of: PhantomData<T>,
}

impl<T, S: Into<String>> From<S> for Raw<T> {
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
