//! How digests are made: of fields, each behind its length.

use jiff::{Timestamp, fmt::temporal::DateTimePrinter};
use sha2::{Digest as _, Sha256};

/// SHA-256.
pub type Sha256Digest = [u8; 32];

/// Length of a field that is absent.
const ABSENT: u64 = u64::MAX;

static PRINTER: DateTimePrinter = DateTimePrinter::new().precision(Some(6));

/// Returns a time as RFC 3339 in UTC with six decimals, `2026-11-21T09:21:33.123456Z`: always 27
/// characters, so that the order of texts is the order of times.
pub fn time_text(time: Timestamp) -> String {
    PRINTER.timestamp_to_string(&time)
}

/// The digest of fields. Each comes after its length in 8 bytes, the most significant first.
#[derive(Default)]
pub struct Fields(Sha256);

impl Fields {
    pub fn bytes(mut self, field: &[u8]) -> Self {
        self.0.update((field.len() as u64).to_be_bytes());
        self.0.update(field);
        self
    }

    pub fn text(self, field: &str) -> Self {
        self.bytes(field.as_bytes())
    }

    pub fn number(self, field: u64) -> Self {
        self.text(&field.to_string())
    }

    pub fn time(self, field: Timestamp) -> Self {
        self.text(&time_text(field))
    }

    pub fn maybe(mut self, field: Option<&str>) -> Self {
        match field {
            Some(text) => self.text(text),
            None => {
                self.0.update(ABSENT.to_be_bytes());
                self
            }
        }
    }

    pub fn digest(self) -> Sha256Digest {
        self.0.finalize().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_of_times_is_fixed_and_nothing_is_lost() {
        for text in ["1970-01-01T00:00:00.000000Z", "2026-11-21T09:21:33.120000Z", "9999-12-30T22:00:00.999999Z"] {
            assert_eq!((time_text(text.parse().unwrap()).as_str(), text.len()), (text, 27));
        }
    }

    #[test]
    fn fields_are_distinguished_by_their_lengths() {
        let of =
            |fields: &[Option<&str>]| fields.iter().fold(Fields::default(), |all, field| all.maybe(*field)).digest();
        let all =
            [of(&[Some("ab"), Some("c")]), of(&[Some("a"), Some("bc")]), of(&[Some("abc")]), of(&[Some("abc"), None])];
        for (k, one) in all.iter().enumerate() {
            assert!(all[k + 1..].iter().all(|other| other != one));
        }
        // 8 bytes of length, then the field
        let plain: Sha256Digest = Sha256::digest(b"\0\0\0\0\0\0\0\x02ab\xff\xff\xff\xff\xff\xff\xff\xff").into();
        assert_eq!(of(&[Some("ab"), None]), plain);
    }
}
