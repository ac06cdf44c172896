//! A part of a request that is passed over, to be read on its own.

use std::fmt;

use serde::{
    Deserialize, Deserializer,
    de::{Error, Visitor},
};

/// The text of a value.
#[derive(Clone, Copy, Debug)]
pub struct Slice<'a>(pub &'a [u8]);

impl Slice<'_> {
    /// By which [`super::reader`] knows it.
    pub const NAME: &'static str = "$slice";
}

impl<'de: 'a, 'a> Deserialize<'de> for Slice<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = Slice<'de>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a value")
            }

            fn visit_borrowed_bytes<E: Error>(self, text: &'de [u8]) -> Result<Slice<'de>, E> {
                Ok(Slice(text))
            }
        }

        deserializer.deserialize_newtype_struct(Slice::NAME, Read)
    }
}
