//! Times as text: RFC 3339 in UTC with six decimals, always 27 characters, so that order in text is
//! order in time.

use jiff::{Timestamp, fmt::temporal::DateTimePrinter};
use sqlx::{Decode, Sqlite, Type, error::BoxDynError, sqlite::SqliteTypeInfo};

use crate::store::shared::{Moment, damaged};

static PRINTER: DateTimePrinter = DateTimePrinter::new().precision(Some(6));

/// `2026-11-21T09:21:33.123456Z`.
pub fn to_text(time: Timestamp) -> String {
    PRINTER.timestamp_to_string(&time)
}

/// The time that [`to_text`] wrote.
fn from_text(text: &str) -> Result<Timestamp, jiff::Error> {
    text.parse()
}

impl Type<Sqlite> for Moment {
    fn type_info() -> SqliteTypeInfo {
        <str as Type<Sqlite>>::type_info()
    }

    fn compatible(found: &SqliteTypeInfo) -> bool {
        <str as Type<Sqlite>>::compatible(found)
    }
}

impl<'r> Decode<'r, Sqlite> for Moment {
    fn decode(value: <Sqlite as sqlx::Database>::ValueRef<'r>) -> Result<Self, BoxDynError> {
        let text = <&str as Decode<'r, Sqlite>>::decode(value)?;
        from_text(text).map(Moment).map_err(|_| damaged("a time", text).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_is_fixed_and_nothing_is_lost() {
        for text in ["1970-01-01T00:00:00.000000Z", "2026-11-21T09:21:33.120000Z", "9999-12-30T22:00:00.999999Z"] {
            assert_eq!(to_text(from_text(text).unwrap()), text);
            assert_eq!(text.len(), 27);
        }
    }
}
