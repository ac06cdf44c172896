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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finished_json_is_written_as_a_raw_value_is() {
        for text in ["{\"a\": [1.50, null]}", "\"ü\\n\"", "1e400"] {
            let raw: Raw<serde_json::Value> = text.into();
            let known: &RawValue = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&[&raw]).unwrap(), format!("[{text}]"));
            assert_eq!(serde_json::to_string(&[known]).unwrap(), format!("[{text}]"));
        }
        let raw: Raw<[f64; 2]> = "[1.50,2]".into();
        assert_eq!(raw.value().unwrap(), [1.5, 2.0]);
        assert_eq!(serde_json::to_value(&raw).unwrap(), serde_json::json!([1.5, 2]));
    }
}
