//! Finished JSON within an answer.

use std::{marker::PhantomData, sync::Arc};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::DeserializeOwned, ser::SerializeStruct};
use serde_json::value::RawValue;

/// Name by which serde_json recognises a [`RawValue`], whose only field is finished JSON. A
/// `RawValue` made of a text reads all of it first, which takes as long as a small fit.
const RAW: &str = "$serde_json::private::RawValue";

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

impl<T> Raw<T> {
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl<T, S: Into<Arc<str>>> From<S> for Raw<T> {
    fn from(text: S) -> Self {
        Raw { text: text.into(), of: PhantomData }
    }
}

impl<T> Serialize for Raw<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut raw = serializer.serialize_struct(RAW, 1)?;
        raw.serialize_field(RAW, &*self.text)?;
        raw.end()
    }
}

impl<'de, T> Deserialize<'de> for Raw<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Box::<RawValue>::deserialize(deserializer)?.get().into())
    }
}
