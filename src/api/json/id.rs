//! Ids in requests.

use std::fmt;

use serde::{
    Deserializer,
    de::{Error, Visitor},
};
use uuid::Uuid;

/// What ids are.
const FORM: &str = "a UUID such as 0190b0de-0000-7000-8000-000000000000, in quotes";

/// Reads an id.
pub fn id<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Uuid, D::Error> {
    struct Read;

    impl Visitor<'_> for Read {
        type Value = Uuid;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(FORM)
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<Uuid, E> {
            Uuid::try_parse(text).map_err(|_| E::custom(format_args!("expected {FORM}")))
        }
    }

    deserializer.deserialize_str(Read)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::json::reader::read;

    #[derive(Debug, serde::Deserialize)]
    #[serde(transparent)]
    struct Id(#[serde(deserialize_with = "id")] Uuid);

    #[test]
    fn what_is_no_id_is_told_what_ids_are() {
        let said = |text: &str| read::<Id>(text.as_bytes(), None).unwrap_err().to_string();
        assert_eq!(said("5"), format!("expected {FORM}, found 5"));
        assert_eq!(said("\"fit 1\""), format!("expected {FORM}"));
        let Id(read) = read::<Id>(b"\"0190b0de-0000-7000-8000-000000000000\"", None).unwrap();
        assert_eq!(read.get_version_num(), 7);
    }
}
