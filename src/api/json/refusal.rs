//! Errors of [`super::reader`]: values that the schema of their type allows and that the type
//! itself refuses.

use std::fmt;

use serde::de::{self, Expected, Unexpected};

use super::{
    cursor::Syntax,
    location::{Location, escape},
    wording::unknown_name,
};
use crate::api::faults::{Fault, Faults, pointer_of};

/// A value that is refused.
#[derive(Clone, Debug)]
pub struct Refusal(Box<Inner>);

#[derive(Clone, Debug)]
struct Inner {
    /// Errors, with pointers from the value that is refused until that value's place is known.
    faults: Vec<Fault>,
    placed: bool,
}

impl Refusal {
    fn new(pointer: String, detail: impl Into<String>, missing: bool) -> Self {
        let faults = vec![Fault { pointer, detail: detail.into(), missing }];
        Refusal(Box::new(Inner { faults, placed: false }))
    }

    /// Places it at `location`, unless it is placed deeper.
    pub fn at(mut self, location: &Location) -> Self {
        if !self.0.placed {
            let place = location.pointer();
            self.0.faults.iter_mut().for_each(|fault| fault.pointer.insert_str(0, &place));
            self.0.placed = true;
        }
        self
    }

    /// Returns the errors, at least one, with their pointers below `pointer`.
    pub fn faults(self, pointer: &str) -> Faults {
        let mut faults = Faults::default();
        self.0.faults.into_iter().for_each(|fault| faults.add(fault));
        faults.within(pointer)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let details: Vec<&str> = self.0.faults.iter().map(|fault| &*fault.detail).collect();
        f.write_str(&details.join("; "))
    }
}

impl std::error::Error for Refusal {}

impl From<Syntax> for Refusal {
    fn from(syntax: Syntax) -> Self {
        Refusal::new(String::new(), syntax.what, false)
    }
}

impl de::Error for Refusal {
    /// A message of the engine has a line for each error, which begins with its path.
    fn custom<T: fmt::Display>(message: T) -> Self {
        let fault = |line: &str| {
            let (path, detail) =
                line.strip_prefix("at `").and_then(|rest| rest.split_once("`: ")).unwrap_or(("", line));
            Fault { pointer: pointer_of(path), detail: detail.to_owned(), missing: false }
        };
        let faults = message.to_string().split('\n').map(fault).collect();
        Refusal(Box::new(Inner { faults, placed: false }))
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
        Refusal::new(String::new(), unknown_name(name, known), false)
    }

    fn duplicate_field(name: &'static str) -> Self {
        Refusal::new(format!("/{}", escape(name)), "the field occurs twice; give it once", false)
    }

    fn missing_field(name: &'static str) -> Self {
        Refusal::new(format!("/{}", escape(name)), "required", true)
    }
}
