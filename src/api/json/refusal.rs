//! Errors of [`super::reader`]: values that the schema of their type allows and that the type
//! itself refuses.

use std::fmt;

use serde::de::{self, Expected, Unexpected};

use super::{
    cursor::Syntax,
    location::{Location, escape},
    wording::{one_of, unknown_name},
};
use crate::api::faults::{Fault, pointer_of};

/// A value that is refused.
#[derive(Clone, Debug)]
pub struct Refusal(Box<Inner>);

#[derive(Clone, Debug)]
struct Inner {
    detail: String,
    /// Pointer to the fault, from the value that is refused until that value's place is known.
    pointer: String,
    placed: bool,
    missing: bool,
}

impl Refusal {
    fn new(pointer: String, detail: impl Into<String>, missing: bool) -> Self {
        Refusal(Box::new(Inner { detail: detail.into(), pointer, placed: false, missing }))
    }

    /// Places it at `location`, unless it is placed deeper.
    pub fn at(mut self, location: &Location) -> Self {
        if !self.0.placed {
            self.0.pointer.insert_str(0, &location.pointer());
            self.0.placed = true;
        }
        self
    }

    pub fn into_fault(self) -> Fault {
        let Inner { detail, pointer, placed: _, missing } = *self.0;
        Fault { pointer, detail, missing }
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
        Refusal::new(String::new(), syntax.what, false)
    }
}

impl de::Error for Refusal {
    /// A message of the engine begins with the path of the fault.
    fn custom<T: fmt::Display>(message: T) -> Self {
        let message = message.to_string();
        match message.strip_prefix("at `").and_then(|rest| rest.split_once("`: ")) {
            Some((path, message)) => Refusal::new(pointer_of(path), message, false),
            None => Refusal::new(String::new(), message, false),
        }
    }

    fn invalid_type(found: Unexpected, expected: &dyn Expected) -> Self {
        let found = match found {
            Unexpected::Str(_) => "a string".to_owned(),
            Unexpected::Seq => "an array".to_owned(),
            Unexpected::Map => "an object".to_owned(),
            other => other.to_string(),
        };
        let expected = match &*expected.to_string() {
            "a sequence" => "an array".to_owned(),
            expected => expected.to_owned(),
        };
        Refusal::new(String::new(), format!("expected {expected}, found {found}"), false)
    }

    fn unknown_variant(name: &str, known: &'static [&'static str]) -> Self {
        Refusal::new(String::new(), unknown_name(name, &one_of(known)), false)
    }

    fn duplicate_field(name: &'static str) -> Self {
        Refusal::new(format!("/{}", escape(name)), "the field occurs twice; give it once", false)
    }

    fn missing_field(name: &'static str) -> Self {
        Refusal::new(format!("/{}", escape(name)), "missing", true)
    }
}
