//! A reader of the key fields of quality data, by the published description of the format.

use std::collections::BTreeMap;

/// Fields of a file as a reader sees them: `K2002/3 text` under ("K2002", 3), in the order of the
/// lines.
pub struct File {
    /// Number of characteristics in K0100.
    pub declared: usize,
    fields: BTreeMap<(String, usize), Vec<String>>,
}

impl File {
    pub fn read(bytes: &[u8]) -> File {
        let text = match bytes.strip_prefix(b"\xef\xbb\xbf") {
            Some(rest) => String::from_utf8(rest.to_vec()).unwrap(),
            None => bytes.iter().map(|byte| windows_1252(*byte)).collect(),
        };
        let (mut fields, mut keys, mut declared) = (BTreeMap::<_, Vec<_>>::new(), Vec::new(), None);
        assert!(text.ends_with("\r\n"));
        for line in text.split_terminator("\r\n") {
            assert!(!line.contains(['\r', '\n', '\u{f}', '\u{14}']), "{line:?}");
            let (key, content) = line.split_once(' ').unwrap_or_else(|| panic!("{line:?}"));
            let (key, index) = key.split_once('/').unwrap_or((key, "0"));
            assert!(key.len() == 5 && key.starts_with('K') && key[1..].bytes().all(|c| c.is_ascii_digit()), "{line:?}");
            if key == "K0100" {
                assert!(declared.replace(content.parse().unwrap()).is_none() && keys.is_empty());
            }
            fields.entry((key.to_owned(), index.parse().unwrap())).or_default().push(content.to_owned());
            keys.push(key.to_owned());
        }
        assert!(keys.iter().map(block).is_sorted(), "{keys:?}");
        File { declared: declared.unwrap(), fields }
    }

    /// Content of a field that occurs once, or not at all.
    pub fn one(&self, key: &str, index: usize) -> Option<&str> {
        let all = self.fields.get(&(key.to_owned(), index))?;
        assert_eq!(all.len(), 1, "{key}/{index}");
        Some(&all[0])
    }
}

/// Header, part, characteristics, values.
fn block(key: &String) -> usize {
    match &key[..2] {
        _ if key == "K0100" => 0,
        "K1" => 1,
        "K2" => 2,
        _ => 3,
    }
}

/// The code page by its published table.
fn windows_1252(byte: u8) -> char {
    let upper = [
        (0x80, 0x20AC),
        (0x82, 0x201A),
        (0x83, 0x0192),
        (0x84, 0x201E),
        (0x85, 0x2026),
        (0x86, 0x2020),
        (0x87, 0x2021),
        (0x88, 0x02C6),
        (0x89, 0x2030),
        (0x8A, 0x0160),
        (0x8B, 0x2039),
        (0x8C, 0x0152),
        (0x8E, 0x017D),
        (0x91, 0x2018),
        (0x92, 0x2019),
        (0x93, 0x201C),
        (0x94, 0x201D),
        (0x95, 0x2022),
        (0x96, 0x2013),
        (0x97, 0x2014),
        (0x98, 0x02DC),
        (0x99, 0x2122),
        (0x9A, 0x0161),
        (0x9B, 0x203A),
        (0x9C, 0x0153),
        (0x9E, 0x017E),
        (0x9F, 0x0178),
    ];
    match byte {
        0x80..=0x9F => {
            let (_, code) = upper.iter().find(|(at, _)| *at == byte).unwrap_or_else(|| panic!("{byte:x} is no letter"));
            char::from_u32(*code).unwrap()
        }
        other => char::from(other),
    }
}
