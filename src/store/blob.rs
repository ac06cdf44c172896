//! Nodes as bytes: exact, compact, quick.
//!
//! Byte 0 is the version (1), byte 1 the form, byte 2 the set of optional parts. Then, little-endian: lengths as u32, the numbers as
//! doubles bit for bit (a missing grid node is the NaN it was), `valid` as one byte a node, names as UTF-8 with a u32 length.

use crate::estimation::{Nodes, nodes};

const VERSION: u8 = 1;
const CURVE: u8 = 0;
const SCATTERED: u8 = 1;
const GRID: u8 = 2;
const MATRIX: u8 = 3;
const HAS_WEIGHT: u8 = 1;
const HAS_VALID: u8 = 2;
const HAS_NAMES: u8 = 4;

/// Why bytes are not nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BlobError {
    #[error("stored nodes end after {0} bytes, in the middle of something")]
    Short(usize),
    #[error("stored nodes have version {0}, form {1}")]
    Unknown(u8, u8),
    #[error("stored nodes are followed by {0} stray bytes")]
    Stray(usize),
    #[error("a stored column name is not UTF-8")]
    Name,
    #[error("stored nodes do not pass the checks that posted ones pass")]
    Unchecked,
}

/// Writes nodes.
pub fn encode(nodes: &Nodes) -> Vec<u8> {
    let flag = |there: bool, bit: u8| if there { bit } else { 0 };
    match nodes {
        Nodes::Curve(nodes::Curve { x, y, weight }) => {
            let mut out = Writer::new(CURVE, flag(weight.is_some(), HAS_WEIGHT), x.len() * 3);
            out.length(x.len());
            out.numbers(x).numbers(y).optional(weight);
            out.bytes
        }
        Nodes::Scattered(nodes::Scattered { u, v, z, weight }) => {
            let mut out = Writer::new(SCATTERED, flag(weight.is_some(), HAS_WEIGHT), u.len() * 4);
            out.length(u.len());
            out.numbers(u).numbers(v).numbers(z).optional(weight);
            out.bytes
        }
        Nodes::Grid(nodes::Grid { u, v, z, valid, weight }) => {
            let parts = flag(weight.is_some(), HAS_WEIGHT) | flag(valid.is_some(), HAS_VALID);
            let mut out = Writer::new(GRID, parts, u.len() + v.len() + z.len() * 2);
            out.length(u.len()).length(v.len());
            out.numbers(u).numbers(v).numbers(z).optional(weight);
            if let Some(valid) = valid {
                out.bytes.extend(valid.iter().map(|there| u8::from(*there)));
            }
            out.bytes
        }
        Nodes::Matrix(nodes::Matrix { x, columns, y, names, weight }) => {
            let parts = flag(weight.is_some(), HAS_WEIGHT) | flag(names.is_some(), HAS_NAMES);
            let mut out = Writer::new(MATRIX, parts, x.len() + y.len() * 2);
            out.length(*columns).length(y.len());
            out.numbers(x).numbers(y).optional(weight);
            for name in names.iter().flatten() {
                out.length(name.len()).bytes.extend_from_slice(name.as_bytes());
            }
            out.bytes
        }
    }
}

/// Reads nodes that [`encode`] wrote.
pub fn decode(bytes: &[u8]) -> Result<Nodes, BlobError> {
    let [version, form, parts, rest @ ..] = bytes else { return Err(BlobError::Short(bytes.len())) };
    if *version != VERSION {
        return Err(BlobError::Unknown(*version, *form));
    }
    let mut input = Reader { rest, total: bytes.len() };
    let has = |bit: u8| parts & bit != 0;
    let checked = match *form {
        CURVE => {
            let count = input.length()?;
            let (x, y) = (input.numbers(count)?, input.numbers(count)?);
            Nodes::curve(x, y, input.optional(has(HAS_WEIGHT), count)?)
        }
        SCATTERED => {
            let count = input.length()?;
            let (u, v, z) = (input.numbers(count)?, input.numbers(count)?, input.numbers(count)?);
            Nodes::scattered(u, v, z, input.optional(has(HAS_WEIGHT), count)?)
        }
        GRID => {
            let (rows, columns) = (input.length()?, input.length()?);
            let count = input.product(rows, columns)?;
            let (u, v, z) = (input.numbers(rows)?, input.numbers(columns)?, input.numbers(count)?);
            let weight = input.optional(has(HAS_WEIGHT), count)?;
            let valid =
                if has(HAS_VALID) { Some(input.take(count)?.iter().map(|there| *there != 0).collect()) } else { None };
            Nodes::grid(u, v, z, valid, weight)
        }
        MATRIX => {
            let (columns, rows) = (input.length()?, input.length()?);
            let count = input.product(rows, columns)?;
            let (x, y) = (input.numbers(count)?, input.numbers(rows)?);
            let weight = input.optional(has(HAS_WEIGHT), rows)?;
            let names = if has(HAS_NAMES) {
                Some((0..columns).map(|_| input.name()).collect::<Result<Vec<_>, _>>()?)
            } else {
                None
            };
            Nodes::matrix(x, columns, y, names, weight)
        }
        unknown => return Err(BlobError::Unknown(*version, unknown)),
    };
    if !input.rest.is_empty() {
        return Err(BlobError::Stray(input.rest.len()));
    }
    checked.map_err(|_| BlobError::Unchecked)
}

struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    fn new(form: u8, parts: u8, numbers: usize) -> Self {
        let mut bytes = Vec::with_capacity(16 + numbers * 8);
        bytes.extend_from_slice(&[VERSION, form, parts]);
        Writer { bytes }
    }

    /// Lengths are far below 2³²: a request body is.
    fn length(&mut self, length: usize) -> &mut Self {
        self.bytes.extend_from_slice(&u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes());
        self
    }

    fn numbers(&mut self, numbers: &[f64]) -> &mut Self {
        self.bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        self
    }

    fn optional(&mut self, numbers: &Option<Vec<f64>>) {
        if let Some(numbers) = numbers {
            self.numbers(numbers);
        }
    }
}

struct Reader<'a> {
    rest: &'a [u8],
    total: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], BlobError> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(BlobError::Short(self.total))?;
        self.rest = rest;
        Ok(taken)
    }

    fn length(&mut self) -> Result<usize, BlobError> {
        let bytes = self.take(4)?.first_chunk().copied().ok_or(BlobError::Short(self.total))?;
        usize::try_from(u32::from_le_bytes(bytes)).map_err(|_| BlobError::Short(self.total))
    }

    fn product(&self, rows: usize, columns: usize) -> Result<usize, BlobError> {
        rows.checked_mul(columns).ok_or(BlobError::Short(self.total))
    }

    fn numbers(&mut self, count: usize) -> Result<Vec<f64>, BlobError> {
        let bytes = self.take(self.product(count, 8)?)?;
        Ok(bytes.as_chunks().0.iter().map(|chunk| f64::from_le_bytes(*chunk)).collect())
    }

    fn optional(&mut self, there: bool, count: usize) -> Result<Option<Vec<f64>>, BlobError> {
        if there { self.numbers(count).map(Some) } else { Ok(None) }
    }

    fn name(&mut self) -> Result<String, BlobError> {
        let length = self.length()?;
        String::from_utf8(self.take(length)?.to_vec()).map_err(|_| BlobError::Name)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn bits(nodes: &Nodes) -> String {
        // NaN differs from itself, so compare what is printed and the bytes.
        format!("{nodes:?}")
    }

    fn every_form() -> Vec<Nodes> {
        let weight = Some(vec![1.0, 0.0]);
        vec![
            Nodes::curve(vec![0.1, -0.0], vec![f64::MIN_POSITIVE, 1e308], weight.clone()).unwrap(),
            Nodes::scattered(vec![1.0, 2.0], vec![3.0, 4.0], vec![5.0, 6.0], None).unwrap(),
            Nodes::grid(vec![1.0, 2.0], vec![3.0], vec![f64::NAN, 6.0], Some(vec![false, true]), weight.clone())
                .unwrap(),
            Nodes::grid(vec![1.0, 2.0], vec![3.0], vec![5.0, 6.0], None, None).unwrap(),
            Nodes::matrix(vec![1.0, 2.0, 3.0, 4.0], 2, vec![5.0, 6.0], Some(vec!["a".into(), "µ".into()]), weight)
                .unwrap(),
            Nodes::matrix(vec![1.0, 2.0], 1, vec![5.0, 6.0], None, None).unwrap(),
        ]
    }

    #[test]
    fn every_form_comes_back() {
        for nodes in every_form() {
            let bytes = encode(&nodes);
            let back = decode(&bytes).unwrap();
            assert_eq!(bits(&back), bits(&nodes));
            assert_eq!(encode(&back), bytes);
        }
    }

    #[test]
    fn damaged_bytes_are_refused_without_panic() {
        for nodes in every_form() {
            let bytes = encode(&nodes);
            for end in 0..bytes.len() {
                assert!(decode(&bytes[..end]).is_err());
            }
            let mut longer = bytes.clone();
            longer.push(0);
            assert_eq!(decode(&longer), Err(BlobError::Stray(1)));
        }
        assert_eq!(decode(&[9, 0, 0]), Err(BlobError::Unknown(9, 0)));
        assert_eq!(decode(&[1, 9, 0]), Err(BlobError::Unknown(1, 9)));
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_without_panic(bytes in proptest::collection::vec(any::<u8>(), 0..64)) {
            let _ = decode(&bytes);
        }
    }
}
