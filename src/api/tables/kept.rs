//! Mappings of tables that are kept, to be proposed for the next table of the same instrument and
//! form.

use sha2::{Digest, Sha256};

use super::mapping::{ColumnBody, MappingBody};
use crate::{api::json::writer::text_of, jobs::KeptMapping};
use flankfit_engine::formats::table::{self, Shape};

/// Bytes of a mapping that is kept: some hundred columns.
const LONGEST: usize = 16 << 10;

/// A mapping that came with a table.
pub struct SentMapping {
    shape: Shape,
    /// Without names of columns, which are those of the table.
    text: String,
}

impl SentMapping {
    /// `None` where the next table would not be known by its form, or the mapping is too long.
    pub fn of(content: &[u8], mapping: &MappingBody) -> Option<Self> {
        let bare = |column: &ColumnBody| ColumnBody { name: None, ..column.clone() };
        let columns = mapping.columns.as_ref().map(|columns| columns.iter().map(bare).collect());
        let text = text_of(&MappingBody { columns, ..mapping.clone() });
        let shape = table::shape(content)?;
        (text.len() <= LONGEST).then_some(SentMapping { shape, text })
    }

    /// As it is kept for an instrument.
    pub fn kept(self, instrument: Option<&str>) -> KeptMapping {
        KeptMapping { key: key_of(&self.shape, instrument), mapping: self.text }
    }
}

/// Returns the key of the mapping of a table; `None` if its form is not known.
pub fn key(content: &[u8], instrument: Option<&str>) -> Option<[u8; 32]> {
    Some(key_of(&table::shape(content)?, instrument))
}

fn key_of(shape: &Shape, instrument: Option<&str>) -> [u8; 32] {
    let Shape { separator, decimal, columns, names } = shape;
    Sha256::digest(text_of(&(instrument.unwrap_or_default(), separator, decimal, columns, names))).into()
}

#[cfg(test)]
mod tests {
    use flankfit_engine::formats::table::Meaning;

    use super::*;

    #[test]
    fn tables_of_one_form_have_one_key() {
        let rows = "Tiefe;Ort;Wert\n1,5;2;3\n2,5;2;4\n";
        let of = |table: &str, instrument| key(table.as_bytes(), instrument).unwrap();
        let own = of(rows, Some("P40"));
        assert_eq!(of("Tiefe;Ort;Wert\n7,25;1;3\n", Some("P40")), own);
        for other in
            [rows.replace("Ort", "Platz"), rows.replace(';', "\t"), rows.replace(',', "."), rows.replace("Ort;", "")]
        {
            assert_ne!(of(&other, Some("P40")), own, "{other}");
        }
        assert_ne!(of(rows, None), own);
        assert_ne!(of(rows, Some("P41")), own);
        // rows of a matrix are as long as it has places across
        assert_eq!(of("u\\v;1;2\n1;3;4\n2;3;4\n", None), of("u\\v;1;2;3\n1;3;4;5\n2;3;4;5\n", None));
    }

    #[test]
    fn names_and_long_mappings_are_not_kept() {
        let read = |text: &str| serde_json::from_str::<MappingBody>(text).unwrap();
        let mapping = read(r#"{"decimal":",","columns":[{"name":"Tiefe","meaning":"u"}]}"#);
        let kept = SentMapping::of(b"1;2\n2;3\n", &mapping).unwrap().kept(None);
        assert_eq!(kept.mapping, r#"{"decimal":",","columns":[{"meaning":"u"}]}"#);
        let column = ColumnBody { name: None, meaning: Meaning::Ignore, unit: None };
        let long = MappingBody { columns: Some(vec![column; 1000]), ..MappingBody::default() };
        assert!(SentMapping::of(b"1;2\n2;3\n", &long).is_none());
        assert!(SentMapping::of(b"no table", &mapping).is_none());
    }
}
