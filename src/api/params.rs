//! What the sentences of warnings speak of, as data: by it a client says them in another language.
//!
//! Everything that a warning of the engine holds stands here under a name, in one place for all of
//! them. Lengths, angles and shares have their units in the names.

mod fits;
mod outliers;

pub use outliers::MovedFigure;

use std::{borrow::Cow, collections::BTreeMap};

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Parameters by their names.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Params(BTreeMap<Cow<'static, str>, Value>);

impl Params {
    /// None at all, to be added to.
    pub fn new() -> Self {
        Params::default()
    }

    /// What is answered: nothing where there are none.
    pub fn some(self) -> Option<Self> {
        Some(self).filter(|Params(all)| !all.is_empty())
    }

    /// Creates parameters from names and values.
    pub fn of<const N: usize>(all: [(&'static str, Value); N]) -> Self {
        all.into_iter().fold(Params::new(), |params, (name, value)| params.with(name, value))
    }

    /// Returns the fields of a warning of the engine; `None` if it has none.
    pub fn of_fields(warning: &impl Serialize) -> Option<Self> {
        let Ok(Value::Object(fields)) = serde_json::to_value(warning) else { return None };
        Params(
            fields
                .into_iter()
                .filter(|(_, value)| !value.is_null())
                .map(|(name, value)| (name.into(), value))
                .collect(),
        )
        .some()
    }

    /// Adds a parameter.
    pub fn add(&mut self, name: &'static str, value: impl Into<Value>) {
        *self = std::mem::take(self).with(name, value);
    }

    fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        let value = value.into();
        // a number that leaves the range of double is none in JSON
        if !value.is_null() {
            self.0.insert(name.into(), value);
        }
        self
    }

    pub fn list<T: Into<Value>>(self, name: &'static str, items: impl IntoIterator<Item = T>) -> Self {
        self.with(name, items.into_iter().map(Into::into).collect::<Vec<Value>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_left_out() {
        assert_eq!(Params::new().some(), None);
        assert_eq!(Params::new().with("factor", f64::INFINITY).some(), None);
        let all = Params::new().with("count", 3_usize).with("share", 0.25).list("terms", ["u", "v"]);
        assert_eq!(serde_json::to_string(&all).unwrap(), r#"{"count":3,"share":0.25,"terms":["u","v"]}"#);
    }
}
