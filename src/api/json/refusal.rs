//! Why a value of a request is not taken: the error of [`super::reader`].
//!
//! serde's visitors say what they met and what they wanted; that is kept apart from the location,
//! which is known to whoever reads the value that encloses it.

use std::fmt;

use serde::de::{self, Expected, Unexpected};

use super::{
    cursor::Syntax,
    location::{Location, escape},
    wording::{OBJECT_WANTED, mismatch, no_such_field, one_of, too_short, unknown_name},
};
use crate::api::faults::Fault;

/// What is wrong with a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wrong {
    /// The value itself.
    Value,
    /// A field that is not known.
    Unknown(String),
    /// A field that is not there.
    Missing(&'static str),
    /// A field that stands twice.
    Twice(String),
}

/// A value that is not taken.
#[derive(Clone, Debug)]
pub struct Refusal(Box<Inner>);

#[derive(Clone, Debug)]
struct Inner {
    wrong: Wrong,
    detail: String,
    /// Known from the innermost value on that was being read.
    pointer: Option<String>,
    /// Whether a value was refused that only stands in for a missing one.
    of_stand_in: bool,
}

impl Refusal {
    fn new(wrong: Wrong, detail: String) -> Self {
        Refusal(Box::new(Inner { wrong, detail, pointer: None, of_stand_in: false }))
    }

    /// A value that is wrong in itself.
    pub fn value(detail: impl Into<String>) -> Self {
        Self::new(Wrong::Value, detail.into())
    }

    /// A field that stands twice.
    pub fn twice(key: &str) -> Self {
        Self::new(Wrong::Twice(key.to_owned()), "the field occurs twice; give it once".to_owned())
    }

    /// The same, met at `location` unless it was met deeper.
    pub fn at(mut self, location: &Location) -> Self {
        if self.0.pointer.is_none() {
            let mut pointer = location.pointer();
            let field = match &self.0.wrong {
                Wrong::Value => None,
                Wrong::Unknown(name) | Wrong::Twice(name) => Some(name.as_str()),
                Wrong::Missing(name) => Some(*name),
            };
            if let Some(end) = field.map(|name| format!("/{}", escape(name)))
                && !pointer.ends_with(&end)
            {
                pointer.push_str(&end);
            }
            self.0.pointer = Some(pointer);
        }
        self
    }

    /// The same of the entries of an array: where a field is missed, an object was wanted.
    pub fn of_entries(self) -> Self {
        match self.0.wrong {
            Wrong::Missing(_) if self.0.pointer.is_none() => Self::value(OBJECT_WANTED),
            _ => self,
        }
    }

    /// The same of what stands in for a missing value at `location`.
    pub fn of_stand_in(mut self, location: &Location) -> Self {
        self.0.of_stand_in = true;
        self.0.pointer = Some(location.pointer());
        self
    }

    pub fn wrong(&self) -> &Wrong {
        &self.0.wrong
    }

    /// JSON Pointer below the value that was read.
    pub fn pointer(&self) -> &str {
        self.0.pointer.as_deref().unwrap_or_default()
    }

    pub fn is_of_stand_in(&self) -> bool {
        self.0.of_stand_in
    }

    pub fn into_fault(self) -> Fault {
        let missing = matches!(self.0.wrong, Wrong::Missing(_));
        Fault { pointer: self.0.pointer.unwrap_or_default(), detail: self.0.detail, missing }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.detail)
    }
}

impl std::error::Error for Refusal {}

impl From<Syntax> for Refusal {
    fn from(syntax: Syntax) -> Self {
        Refusal::value(syntax.what)
    }
}

impl de::Error for Refusal {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Refusal::value(message.to_string())
    }

    fn invalid_type(found: Unexpected, expected: &dyn Expected) -> Self {
        Refusal::value(mismatch(found, &expected.to_string()))
    }

    fn invalid_value(found: Unexpected, expected: &dyn Expected) -> Self {
        Refusal::value(mismatch(found, &expected.to_string()))
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        Refusal::value(too_short(length, &expected.to_string()))
    }

    fn unknown_variant(name: &str, known: &'static [&'static str]) -> Self {
        Refusal::value(unknown_name(name, &one_of(known)))
    }

    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::new(Wrong::Unknown(name.to_owned()), no_such_field(name, known))
    }

    fn missing_field(name: &'static str) -> Self {
        Self::new(Wrong::Missing(name), "missing".to_owned())
    }

    fn duplicate_field(name: &'static str) -> Self {
        Refusal::twice(name)
    }
}
