//! Objects of requests: the members of an object as slices of its text, each read when its turn
//! comes.
//!
//! What is big (points, parameters, grids) goes straight into vectors; what is small is left to
//! serde on its slice. Unknown members, repeated ones and whatever is wrong with each are all
//! refused at once, however long the text is. A known member that is `null` counts as absent.

use std::{marker::PhantomData, sync::Arc};

use serde::Deserialize;

use super::{
    check::read_by,
    compiled::Compiled,
    cursor::{Cursor, Syntax, Token},
    error::{ReadError, malformed},
    location::escape,
    numbers::{read_numbers, read_rows},
    wording::no_such_field,
};
use crate::api::faults::Faults;

/// Outcome of reading a member of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// No member of this name.
    Unknown,
    Once,
    /// The object has had it before.
    Again,
}

impl Taken {
    /// A known member, which the object may have had before.
    pub fn of(again: bool) -> Self {
        if again { Taken::Again } else { Taken::Once }
    }
}

/// The members that an object may have, and what a text has of them.
pub trait Members<'a> {
    /// Creates those of the object at the pointer `at`, none of them read yet.
    fn at(at: &'a str) -> Self;

    /// Takes the value at the cursor as the member `name`.
    fn take(&mut self, name: &str, cursor: &mut Cursor<'a>) -> Result<Taken, Syntax>;

    /// Adds each name, in the order of the declaration, and whether the text has it.
    fn list(&self, names: &mut Vec<(&'static str, bool)>);
}

/// The names that a text has of these members.
pub fn given<'a>(members: &impl Members<'a>) -> Vec<&'static str> {
    let mut names = Vec::new();
    members.list(&mut names);
    names.into_iter().filter(|(_, given)| *given).map(|(name, _)| name).collect()
}

/// The members of a whole request. Unknown and repeated ones are errors, and so is text that is not
/// JSON.
pub fn of_request<'a, M: Members<'a>>(text: &'a [u8], faults: &mut Faults) -> Result<M, ReadError> {
    let mut cursor = Cursor::new(text);
    let mut members = M::at("");
    let walked = walk(&mut cursor, "", &mut members, faults).and_then(|_| cursor.end());
    walked.map_err(|syntax| malformed(text, &syntax))?;
    Ok(members)
}

/// The members of an object within a request, at the pointer `at` and known to be JSON; `None`
/// where it is no object. Unknown and repeated members are errors; the others are read all the
/// same.
pub fn of_object<'a, M: Members<'a>>(slice: &'a [u8], at: &'a str, faults: &mut Faults) -> Option<M> {
    let mut members = M::at(at);
    walk(&mut Cursor::new(slice), at, &mut members, faults).ok()?.then_some(members)
}

/// Whether there was an object.
fn walk<'a, M: Members<'a>>(
    cursor: &mut Cursor<'a>,
    at: &str,
    members: &mut M,
    faults: &mut Faults,
) -> Result<bool, Syntax> {
    match cursor.token()? {
        Token::Object => {}
        other => {
            faults.push(at, format!("expected an object, found {}", other.name()));
            cursor.skip_value()?;
            return Ok(false);
        }
    }
    cursor.object(|cursor, name| {
        if cursor.token()? == Token::Null && names(members).contains(&&*name) {
            return cursor.skip_value().map(drop);
        }
        match members.take(&name, cursor)? {
            Taken::Once => {}
            Taken::Again => faults.push(format!("{at}/{name}"), "the field occurs twice; give it once"),
            Taken::Unknown => {
                faults.push_with(format!("{at}/{}", escape(&name)), || unknown(&name, members));
                cursor.skip_value()?;
            }
        }
        Ok(())
    })?;
    Ok(true)
}

#[cold]
fn unknown<'a>(name: &str, members: &impl Members<'a>) -> String {
    no_such_field(name, &names(members))
}

/// Returns the possible names of these members.
fn names<'a>(members: &impl Members<'a>) -> Vec<&'static str> {
    let mut names = Vec::new();
    members.list(&mut names);
    names.into_iter().map(|(name, _)| name).collect()
}

/// A member of an object that is read as `T`: its text, where the object has it.
pub struct Member<'a, T> {
    name: &'static str,
    /// The object that it belongs to.
    at: &'a str,
    /// Returns the schema of the object.
    schema: fn() -> Arc<Compiled>,
    text: Option<&'a [u8]>,
    read_as: PhantomData<fn() -> T>,
}

impl<'a, T> Member<'a, T> {
    pub fn new(name: &'static str, at: &'a str, schema: fn() -> Arc<Compiled>) -> Self {
        Member { name, at, schema, text: None, read_as: PhantomData }
    }

    /// Passes over the value at the cursor; `true` where there was one before, which stays.
    pub fn take(&mut self, cursor: &mut Cursor<'a>) -> Result<bool, Syntax> {
        let slice = cursor.skip_value()?;
        Ok(self.text.replace(self.text.unwrap_or(slice)).is_some())
    }

    pub fn text(&self) -> Option<&'a [u8]> {
        self.text
    }

    pub fn is_given(&self) -> bool {
        self.text.is_some()
    }

    /// Its name, where the object has it.
    pub fn name_if_given(&self) -> Option<&'static str> {
        self.text.map(|_| self.name)
    }

    /// Its JSON Pointer.
    pub fn pointer(&self) -> String {
        format!("{}/{}", self.at, self.name)
    }

    /// The text, which must be there.
    pub fn required_text(&self, faults: &mut Faults) -> Option<&'a [u8]> {
        if self.text.is_none() {
            faults.push_missing(self.pointer(), "required");
        }
        self.text
    }

    /// Reads a required member with a reader of its own.
    pub fn required_with<U>(
        &self,
        faults: &mut Faults,
        read: impl FnOnce(&'a [u8], &str, &mut Faults) -> Option<U>,
    ) -> Option<U> {
        let text = self.required_text(faults)?;
        read(text, &self.pointer(), faults)
    }

    /// The same where it may be left out; `None` where it is, or where it is refused.
    pub fn optional_with<U>(
        &self,
        faults: &mut Faults,
        read: impl FnOnce(&'a [u8], &str, &mut Faults) -> Option<U>,
    ) -> Option<U> {
        read(self.text?, &self.pointer(), faults)
    }
}

impl<'a, T: Deserialize<'a>> Member<'a, T> {
    /// The value; `None` where there is none or it is refused.
    pub fn read(&self, faults: &mut Faults) -> Option<T> {
        self.optional(faults).flatten()
    }

    /// The value where there is one; `None` where it is refused.
    pub fn optional(&self, faults: &mut Faults) -> Option<Option<T>> {
        match self.text {
            None => Some(None),
            Some(text) => self.checked(text, faults).map(Some),
        }
    }

    /// The value, which must be there.
    pub fn required(&self, faults: &mut Faults) -> Option<T> {
        self.checked(self.required_text(faults)?, faults)
    }

    fn checked(&self, text: &'a [u8], faults: &mut Faults) -> Option<T> {
        let schema = (self.schema)();
        read_by(&schema, schema.member(self.name), text, &self.pointer(), faults)
    }
}

impl Member<'_, Vec<f64>> {
    /// Numbers, which must be there.
    pub fn numbers(&self, faults: &mut Faults) -> Option<Vec<f64>> {
        self.required_with(faults, read_numbers)
    }
}

impl Member<'_, Vec<Vec<f64>>> {
    /// Rows of numbers, which must be there: the numbers end to end and the lengths of the rows.
    pub fn rows(&self, faults: &mut Faults) -> Option<(Vec<f64>, Vec<usize>)> {
        self.required_with(faults, read_rows)
    }
}

/// A member that is read while the cursor passes: one with arrays of numbers that are most of a
/// request.
pub trait ReadInPassing<'a>: Sized {
    fn read(cursor: &mut Cursor<'a>) -> Result<Self, Syntax>;
}

/// No members.
impl<'a> Members<'a> for () {
    fn at(_: &'a str) -> Self {}

    fn take(&mut self, _: &str, _: &mut Cursor<'a>) -> Result<Taken, Syntax> {
        Ok(Taken::Unknown)
    }

    fn list(&self, _: &mut Vec<(&'static str, bool)>) {}
}

/// Declares the members of an object that has those of several.
macro_rules! members_of_several {
    ($($part:ident)+) => {
        impl<'a, $($part: Members<'a>),+> Members<'a> for ($($part,)+) {
            fn at(at: &'a str) -> Self {
                ($($part::at(at),)+)
            }

            #[expect(non_snake_case, reason = "a part is called as its type")]
            fn take(&mut self, name: &str, cursor: &mut Cursor<'a>) -> Result<Taken, Syntax> {
                let ($($part,)+) = self;
                $(
                    let taken = $part.take(name, cursor)?;
                    if taken != Taken::Unknown {
                        return Ok(taken);
                    }
                )+
                Ok(Taken::Unknown)
            }

            #[expect(non_snake_case, reason = "a part is called as its type")]
            fn list(&self, names: &mut Vec<(&'static str, bool)>) {
                let ($($part,)+) = self;
                $($part.list(names);)+
            }
        }
    };
}

members_of_several!(A B);
members_of_several!(A B C);
