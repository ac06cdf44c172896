//! serde over the cursor: JSON in, whatever a type declares out, refusals as data with their
//! locations.
//!
//! Knows JSON's kinds of values only. What a field may be is said by the visitors of its type; an
//! array is no object, whatever it holds, and a map has each key once.

use std::{borrow::Cow, collections::BTreeSet};

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeSeed, IntoDeserializer, MapAccess, SeqAccess, Visitor, value::CowStrDeserializer},
};

use super::{
    cursor::{Cursor, Token},
    location::Location,
    mended::Mended,
    refusal::Refusal,
    slice::Slice,
    stand_in::StandIn,
    wording::{BEYOND, NAME_WANTED, OBJECT_WANTED, name_wanted, too_long},
};
use flankfit_engine::numerics::cancel;

/// Reads well-formed JSON, as sent or repaired.
pub fn read<'de, T: Deserialize<'de>>(text: &'de [u8], mended: Option<&Mended>) -> Result<T, Refusal> {
    T::deserialize(Reader { cursor: &mut Cursor::new(text), location: &Location::Root, mended })
}

/// Reads the value at the cursor.
struct Reader<'r, 'de> {
    cursor: &'r mut Cursor<'de>,
    location: &'r Location<'r>,
    mended: Option<&'r Mended>,
}

impl<'de> Reader<'_, 'de> {
    fn members<V: Visitor<'de>>(self, visitor: V, once: bool, nulls: Nulls) -> Result<V::Value, Refusal> {
        let Reader { cursor, location, mended } = self;
        cursor.at += 1;
        let seen = (once || mended.is_some()).then(BTreeSet::new);
        let mut missing = mended.map_or(&[][..], |mended| mended.added(location)).iter();
        let members = Members {
            cursor,
            location,
            mended,
            seen,
            nulls,
            key: Cow::Borrowed(""),
            fresh: true,
            missing: &mut missing,
        };
        visitor.visit_map(members).map_err(|refusal| refusal.at(location))
    }

    /// An array; of a `length` where it has a fixed one.
    fn entries<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let Reader { cursor, location, mended } = self;
        cursor.at += 1;
        let (mut index, mut ended) = (0, false);
        let entries = Entries { cursor: &mut *cursor, location, mended, index: &mut index, ended: &mut ended };
        let value = visitor.visit_seq(entries).map_err(|refusal| refusal.of_entries().at(location))?;
        let taken = index;
        while !ended {
            ended = !next_entry(cursor, index)?;
            if !ended {
                cursor.skip_value()?;
                index += 1;
            }
        }
        if index == taken { Ok(value) } else { Err(Refusal::value(too_long(taken, index)).at(location)) }
    }

    fn number<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let (value, text) = self.cursor.number_and_text()?;
        if value.is_infinite() {
            return Err(Refusal::value(BEYOND).at(self.location));
        }
        let negative = text.first() == Some(&b'-');
        let whole = text.iter().all(|byte| byte.is_ascii_digit() || *byte == b'-');
        let text = std::str::from_utf8(text).unwrap_or_default();
        let read = match (negative, whole) {
            (false, true) if let Ok(value) = text.parse() => visitor.visit_u64(value),
            (true, true)
                if value != 0.0
                    && let Ok(value) = text.parse() =>
            {
                visitor.visit_i64(value)
            }
            // the cursor has no −0
            (true, _) if value == 0.0 => visitor.visit_f64(-0.0),
            _ => visitor.visit_f64(value),
        };
        read.map_err(|refusal: Refusal| refusal.at(self.location))
    }
}

impl<'de> Deserializer<'de> for Reader<'_, 'de> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let location = self.location;
        let read = match self.cursor.token()? {
            Token::Object => return self.members(visitor, false, Nulls::Values),
            Token::Array => return self.entries(visitor),
            Token::Number => return self.number(visitor),
            Token::String => match self.cursor.string()? {
                Cow::Borrowed(text) => visitor.visit_borrowed_str(text),
                Cow::Owned(text) => visitor.visit_string(text),
            },
            Token::True | Token::False => {
                let value = self.cursor.peek() == Some(b't');
                self.cursor.skip_value()?;
                visitor.visit_bool(value)
            }
            Token::Null => {
                self.cursor.skip_value()?;
                visitor.visit_unit()
            }
        };
        read.map_err(|refusal: Refusal| refusal.at(location))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        match self.cursor.token()? {
            Token::Null => {
                self.cursor.skip_value()?;
                visitor.visit_none()
            }
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, Refusal> {
        let location = self.location;
        if name == Slice::NAME {
            return visitor.visit_borrowed_bytes(self.cursor.skip_value()?);
        }
        visitor.visit_newtype_struct(self).map_err(|refusal: Refusal| refusal.at(location))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        match self.cursor.token()? {
            Token::Object => self.members(visitor, false, Nulls::AbsentAmong(fields)),
            Token::Array => Err(Refusal::value(OBJECT_WANTED).at(self.location)),
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        match self.cursor.token()? {
            Token::Object => self.members(visitor, true, Nulls::Absent),
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        let name = match self.cursor.token()? {
            Token::String => self.cursor.string()?,
            other => return Err(Refusal::value(name_wanted(names, other.name())).at(self.location)),
        };
        let name: CowStrDeserializer<'_, Refusal> = name.into_deserializer();
        visitor.visit_enum(name).map_err(|refusal| refusal.at(self.location))
    }

    /// The `type` of a union. serde would take a number for the place of a variant in its
    /// declaration, and the first entry of an array for the `type`.
    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        match (self.location, self.cursor.token()?) {
            (Location::Entry(union, _), _) => Err(Refusal::value(OBJECT_WANTED).at(union)),
            (_, Token::String) => self.deserialize_any(visitor),
            _ => Err(Refusal::value(NAME_WANTED).at(self.location)),
        }
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        self.cursor.skip_value()?;
        visitor.visit_unit()
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct
    }
}

/// Whether another entry follows, at which the cursor stands then.
fn next_entry(cursor: &mut Cursor, index: usize) -> Result<bool, Refusal> {
    cancel::every(20, index);
    if cursor.takes(b']') {
        return Ok(false);
    }
    if index > 0 {
        cursor.expect(b',', "or `]` after an array's entry")?;
    }
    cursor.skip_space();
    Ok(true)
}

struct Entries<'r, 'de> {
    cursor: &'r mut Cursor<'de>,
    location: &'r Location<'r>,
    mended: Option<&'r Mended>,
    /// Of the next entry.
    index: &'r mut usize,
    ended: &'r mut bool,
}

impl<'de> SeqAccess<'de> for Entries<'_, 'de> {
    type Error = Refusal;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Refusal> {
        while !*self.ended {
            if !next_entry(self.cursor, *self.index)? {
                *self.ended = true;
                break;
            }
            let location = Location::Entry(self.location, *self.index);
            *self.index += 1;
            if self.mended.is_some_and(|mended| mended.leaves_out(&location)) {
                self.cursor.skip_value()?;
                continue;
            }
            let reader = Reader { cursor: &mut *self.cursor, location: &location, mended: self.mended };
            return seed.deserialize(reader).map(Some).map_err(|refusal| refusal.at(&location));
        }
        Ok(None)
    }
}

/// How members that are `null` are treated.
#[derive(Clone, Copy)]
enum Nulls {
    /// As values, in content that is buffered before its members are known.
    Values,
    /// As absent.
    Absent,
    /// As absent if their names are among these: unknown members are refused, whatever their value.
    AbsentAmong(&'static [&'static str]),
}

struct Members<'r, 'de> {
    cursor: &'r mut Cursor<'de>,
    location: &'r Location<'r>,
    mended: Option<&'r Mended>,
    /// The keys so far, where one that stands twice is refused here.
    seen: Option<BTreeSet<String>>,
    nulls: Nulls,
    key: Cow<'de, str>,
    fresh: bool,
    /// Fields that are to be read although they are not there.
    missing: &'r mut std::slice::Iter<'r, String>,
}

impl<'de> Members<'_, 'de> {
    /// Whether the member at the cursor is `null` and so counts as absent.
    fn is_absent(&mut self) -> Result<bool, Refusal> {
        let counts = match self.nulls {
            Nulls::Values => false,
            Nulls::Absent => true,
            Nulls::AbsentAmong(names) => names.contains(&&*self.key),
        };
        Ok(counts && self.cursor.token()? == Token::Null)
    }

    /// Takes the next key that is to be read.
    fn next_key(&mut self) -> Result<bool, Refusal> {
        loop {
            if self.cursor.takes(b'}') {
                // so that the end is found again
                self.cursor.at -= 1;
                return Ok(false);
            }
            if !std::mem::take(&mut self.fresh) {
                self.cursor.expect(b',', "or `}` after a value")?;
            }
            self.cursor.skip_space();
            cancel::checkpoint();
            self.key = self.cursor.string()?;
            self.cursor.expect(b':', "after a key")?;
            let is_absent = self.is_absent()?;
            let location = Location::Member(self.location, &self.key);
            let twice = self.seen.as_mut().is_some_and(|seen| !seen.insert(self.key.clone().into_owned()));
            match self.mended {
                Some(mended) if twice && mended.has_once(&location) => {}
                _ if twice => return Err(Refusal::twice(&self.key).at(self.location)),
                Some(mended) if mended.leaves_out(&location) => {}
                _ if is_absent => {}
                _ => return Ok(true),
            }
            self.cursor.skip_value()?;
        }
    }
}

impl<'de> MapAccess<'de> for Members<'_, 'de> {
    type Error = Refusal;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Refusal> {
        if !self.next_key()? {
            let Some(missing) = self.missing.as_slice().first() else {
                self.cursor.at += 1;
                return Ok(None);
            };
            self.key = Cow::Owned(missing.clone());
        }
        let key: CowStrDeserializer<'_, Refusal> = self.key.clone().into_deserializer();
        seed.deserialize(key).map(Some).map_err(|refusal| refusal.at(&Location::Member(self.location, &self.key)))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refusal> {
        let location = Location::Member(self.location, &self.key);
        if self.cursor.peek() == Some(b'}') {
            self.missing.next();
            return seed.deserialize(StandIn::default()).map_err(|refusal| refusal.of_stand_in(&location));
        }
        let reader = Reader { cursor: &mut *self.cursor, location: &location, mended: self.mended };
        seed.deserialize(reader).map_err(|refusal| refusal.at(&location))
    }
}
