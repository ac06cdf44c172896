//! serde over the cursor, for text that has been checked by the schema of its type (see
//! [`super::check`]). Members that are `null` count as absent.

use std::borrow::Cow;

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeSeed, Error as _, IntoDeserializer, MapAccess, SeqAccess, Visitor, value::CowStrDeserializer},
};

use super::{
    cursor::{Cursor, Token},
    location::Location,
    refusal::Refusal,
    wording::BEYOND,
};
use flankfit_engine::numerics::cancel;

/// Reads well-formed JSON.
pub fn read<'de, T: Deserialize<'de>>(text: &'de [u8]) -> Result<T, Refusal> {
    T::deserialize(Reader { cursor: &mut Cursor::new(text), location: &Location::Root })
}

/// Reads the value at the cursor.
struct Reader<'r, 'de> {
    cursor: &'r mut Cursor<'de>,
    location: &'r Location<'r>,
}

impl<'de> Reader<'_, 'de> {
    fn members<V: Visitor<'de>>(self, first: Option<Cursor<'de>>, visitor: V) -> Result<V::Value, Refusal> {
        let Reader { cursor, location } = self;
        cursor.at += 1;
        let skips_type = first.is_some();
        visitor.visit_map(Members { cursor, location, key: Cow::Borrowed(""), fresh: true, first, skips_type })
    }

    fn entries<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let Reader { cursor, location } = self;
        cursor.at += 1;
        let (mut index, mut ended) = (0, false);
        let entries = Entries { cursor: &mut *cursor, location, index: &mut index, ended: &mut ended };
        let value = visitor.visit_seq(entries)?;
        let taken = index;
        while !ended {
            ended = !next_entry(cursor, index)?;
            if !ended {
                cursor.skip_value()?;
                index += 1;
            }
        }
        if index == taken { Ok(value) } else { Err(Refusal::invalid_length(index, &"fewer entries")) }
    }

    /// A number; −0 is 0.
    fn number<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let (value, text) = self.cursor.number_and_text()?;
        if value.is_infinite() {
            return Err(Refusal::custom(BEYOND));
        }
        let text = std::str::from_utf8(text).unwrap_or_default();
        if let Ok(value) = text.parse() {
            visitor.visit_u64(value)
        } else if let Ok(value) = text.parse() {
            if value == 0 { visitor.visit_u64(0) } else { visitor.visit_i64(value) }
        } else {
            visitor.visit_f64(value + 0.0)
        }
    }
}

impl<'de> Deserializer<'de> for Reader<'_, 'de> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let location = self.location;
        let read = match self.cursor.token()? {
            Token::Object => self.members(None, visitor),
            Token::Array => self.entries(visitor),
            Token::Number => self.number(visitor),
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
        read.map_err(|refusal| refusal.at(location))
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

    /// Begins with the `type` of a union that asks for it, wherever the member is.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        if fields != ["type"] || self.cursor.token()? != Token::Object {
            return self.deserialize_any(visitor);
        }
        let (location, first) = (self.location, self.cursor.member("type"));
        self.members(first, visitor).map_err(|refusal| refusal.at(location))
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Refusal> {
        let location = self.location;
        visitor.visit_newtype_struct(self).map_err(|refusal: Refusal| refusal.at(location))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        let name: CowStrDeserializer<'_, Refusal> = self.cursor.string()?.into_deserializer();
        visitor.visit_enum(name).map_err(|refusal| refusal.at(self.location))
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        self.cursor.skip_value()?;
        visitor.visit_unit()
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map identifier
    }
}

/// Whether another entry follows, at which the cursor is then.
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
    /// Index of the next entry.
    index: &'r mut usize,
    ended: &'r mut bool,
}

impl<'de> SeqAccess<'de> for Entries<'_, 'de> {
    type Error = Refusal;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Refusal> {
        if *self.ended || !next_entry(self.cursor, *self.index)? {
            *self.ended = true;
            return Ok(None);
        }
        let location = Location::Entry(self.location, *self.index);
        *self.index += 1;
        let reader = Reader { cursor: &mut *self.cursor, location: &location };
        seed.deserialize(reader).map(Some).map_err(|refusal| refusal.at(&location))
    }
}

struct Members<'r, 'de> {
    cursor: &'r mut Cursor<'de>,
    location: &'r Location<'r>,
    key: Cow<'de, str>,
    fresh: bool,
    /// The value of `type`, until it is read before all others.
    first: Option<Cursor<'de>>,
    skips_type: bool,
}

impl<'de> MapAccess<'de> for Members<'_, 'de> {
    type Error = Refusal;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Refusal> {
        if self.first.is_some() {
            self.key = Cow::Borrowed("type");
            return seed.deserialize(CowStrDeserializer::<Refusal>::new(self.key.clone())).map(Some);
        }
        loop {
            if self.cursor.takes(b'}') {
                return Ok(None);
            }
            if !std::mem::take(&mut self.fresh) {
                self.cursor.expect(b',', "or `}` after a value")?;
            }
            self.cursor.skip_space();
            cancel::checkpoint();
            self.key = self.cursor.string()?;
            self.cursor.expect(b':', "after a key")?;
            if self.cursor.token()? != Token::Null && !(self.skips_type && self.key == "type") {
                break;
            }
            self.cursor.skip_value()?;
        }
        seed.deserialize(CowStrDeserializer::<Refusal>::new(self.key.clone())).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refusal> {
        let location = Location::Member(self.location, &self.key);
        let mut first = self.first.take();
        let reader = Reader { cursor: first.as_mut().unwrap_or(self.cursor), location: &location };
        seed.deserialize(reader).map_err(|refusal| refusal.at(&location))
    }
}
