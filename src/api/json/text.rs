//! Texts and times in requests, checked where they are read: what passes is stored and answered as
//! it is.

use std::{
    collections::BTreeMap,
    fmt::{self, Display, Formatter},
};

use jiff::{Timestamp, civil::date, fmt::temporal::DateTimePrinter, tz::TimeZone};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use utoipa::{
    PartialSchema, ToSchema,
    openapi::{
        RefOr,
        schema::{KnownFormat, ObjectBuilder, Schema, SchemaFormat, Type},
    },
};

use crate::jobs::actor;

/// Characters of a name, a number, an operator …
pub const SHORT: usize = 200;
/// Characters of a note or a reason.
pub const LONG: usize = 4000;
/// Tags of a job.
pub const MOST_TAGS: usize = 50;

/// A text of 1 to `MOST` characters that is not only white space. Line breaks, tabs and what sets
/// the direction of text may stand in long texts only, other control characters in none.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Text<const MOST: usize>(String);

/// A name, a number, an operator …
pub type ShortText = Text<SHORT>;
/// A note or a reason.
pub type LongText = Text<LONG>;

impl<const MOST: usize> Text<MOST> {
    /// A text of a program's own, where it keeps to the bounds.
    pub fn new(text: &str) -> Option<Self> {
        let within = !text.trim().is_empty() && text.chars().count() <= MOST;
        (within && control_character(text, MOST > SHORT).is_none()).then(|| Text(text.to_owned()))
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl<const MOST: usize> From<Text<MOST>> for String {
    fn from(text: Text<MOST>) -> Self {
        text.0
    }
}

impl<'de, const MOST: usize> Deserialize<'de> for Text<MOST> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        if text.trim().is_empty() {
            let found = if text.is_empty() { "is empty" } else { "holds only blanks" };
            return Err(D::Error::custom(format_args!("expected a text of 1 to {MOST} characters; this one {found}")));
        }
        let count = text.chars().count();
        if count > MOST {
            return Err(D::Error::custom(format_args!("the text has {count} characters; at most {MOST} are allowed")));
        }
        match control_character(&text, MOST > SHORT) {
            None => Ok(Text(text)),
            Some(refusal) => Err(D::Error::custom(refusal)),
        }
    }
}

impl<const MOST: usize> PartialSchema for Text<MOST> {
    fn schema() -> RefOr<Schema> {
        ObjectBuilder::new().schema_type(Type::String).min_length(Some(1)).max_length(Some(MOST)).into()
    }
}

impl<const MOST: usize> ToSchema for Text<MOST> {}

/// Returns the message for a text with a control character (NUL, line break, escape …), which would
/// spoil lists, tables and logs, or with one that moves others on the screen. `lines` allows line
/// breaks.
pub fn control_character(text: &str, lines: bool) -> Option<String> {
    let wrong = |c: char| match lines {
        true => c.is_control() && !matches!(c, '\n' | '\r' | '\t'),
        false => actor::misleads(c),
    };
    let (place, found) = text.chars().enumerate().find(|(_, c)| wrong(*c))?;
    Some(format!("character {} of the text is the control character U+{:04X}; omit it", place + 1, u32::from(found)))
}

/// The value of a tag.
#[derive(Deserialize)]
#[serde(transparent)]
struct TagValue(#[serde(deserialize_with = "tag_value")] String);

fn tag_value<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    let text = String::deserialize(deserializer)?;
    if text.chars().count() > SHORT {
        return Err(D::Error::custom(format_args!("a tag's value has at most {SHORT} characters")));
    }
    match control_character(&text, false) {
        None => Ok(text),
        Some(refusal) => Err(D::Error::custom(refusal)),
    }
}

/// Names and values, for finding jobs again.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Tags(pub BTreeMap<String, String>);

impl<'de> Deserialize<'de> for Tags {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let tags = BTreeMap::<String, TagValue>::deserialize(deserializer)?;
        if tags.len() > MOST_TAGS {
            return Err(D::Error::custom(format_args!("{} tags; at most {MOST_TAGS} are allowed", tags.len())));
        }
        for name in tags.keys() {
            if name.is_empty() || name.chars().count() > SHORT {
                return Err(D::Error::custom(format_args!("a tag's name has 1 to {SHORT} characters")));
            }
            if let Some(refusal) = control_character(name, false) {
                return Err(D::Error::custom(format_args!("in a tag's name {refusal}")));
            }
        }
        Ok(Tags(tags.into_iter().map(|(name, TagValue(value))| (name, value)).collect()))
    }
}

/// A time: RFC 3339 with any offset when read, in UTC with six decimals when written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moment(pub Timestamp);

static PRINTER: DateTimePrinter = DateTimePrinter::new().precision(Some(6));

impl Display for Moment {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&PRINTER.timestamp_to_string(&self.0))
    }
}

impl Serialize for Moment {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&PRINTER.timestamp_to_string(&self.0))
    }
}

impl PartialSchema for Moment {
    fn schema() -> RefOr<Schema> {
        let format = SchemaFormat::KnownFormat(KnownFormat::DateTime);
        ObjectBuilder::new().schema_type(Type::String).format(Some(format)).into()
    }
}

impl ToSchema for Moment {}

impl<'de> Deserialize<'de> for Moment {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = std::borrow::Cow::<'_, str>::deserialize(deserializer)?;
        let refused = || D::Error::custom("not a time of the form 2026-11-21T08:30:00Z (RFC 3339)");
        // The general parser also takes annotations and other calendars' forms; RFC 3339 has none.
        if text.contains('[') {
            return Err(refused());
        }
        let time: Timestamp = text.parse().map_err(|_| refused())?;
        let year = time.to_zoned(TimeZone::UTC).date();
        if year < date(1, 1, 1) {
            return Err(refused());
        }
        // Whole microseconds are kept, so they are what is answered.
        Timestamp::from_microsecond(time.as_microsecond()).map(Moment).map_err(|_| refused())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read<T: for<'a> Deserialize<'a>>(text: &str) -> Result<T, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }

    #[test]
    fn times_are_written_in_utc_with_six_decimals() {
        let read_and_write = |text: &str| read::<Moment>(text).map(|moment| serde_json::to_string(&moment).unwrap());
        assert_eq!(read_and_write("\"2026-11-21T08:30:00+02:00\"").unwrap(), "\"2026-11-21T06:30:00.000000Z\"");
        assert_eq!(read_and_write("\"2026-11-21T08:30:00.1234567Z\"").unwrap(), "\"2026-11-21T08:30:00.123456Z\"");
        for wrong in ["\"today\"", "\"2026-11-21\"", "\"-000044-03-15T12:00:00Z\"", "5"] {
            assert!(read_and_write(wrong).is_err(), "{wrong}");
        }
    }
}
