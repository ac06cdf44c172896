//! Nodes as bytes, for storing: exactly what was posted, bit by bit.
//!
//! | bytes | meaning |
//! |---|---|
//! | 4 | `FFN1`: magic and version |
//! | 1 | type: 0 curve, 1 scattered, 2 grid, 3 matrix |
//! | 1 | flags: 1 weight, 2 valid, 4 names |
//! | 2 | zero |
//! | 8 × k | counts: curve, scattered m; grid nu, nv; matrix m, n |
//! | 8 × … | doubles, little-endian: x y · u v z · u v z · x y; then the weights |
//! | 1 × … | grid: one byte a node, 1 valid, 0 missing |
//! | … | names: per column its length (4) and its UTF-8 |
//!
//! NaN (a missing node posted as `null`) and −0 keep their bits.

use flankfit_engine::estimation::data::Nodes;

const MAGIC: &[u8; 4] = b"FFN1";
const COUNTS: &str = "the stored counts are impossible";
const WEIGHT: u8 = 1;
const VALID: u8 = 2;
const NAMES: u8 = 4;

/// Nodes, laid out but not copied yet: the part before the doubles, the doubles, and what
/// follows them.
pub struct Layout<'a> {
    pub head: Vec<u8>,
    pub doubles: Vec<&'a [f64]>,
    pub tail: Vec<u8>,
}

pub fn layout(nodes: &Nodes) -> Layout<'_> {
    let (kind, counts, mut doubles): (u8, Vec<usize>, Vec<&[f64]>) = match nodes {
        Nodes::Curve(c) => (0, vec![c.x().len()], vec![c.x(), c.y()]),
        Nodes::Scattered(s) => (1, vec![s.u().len()], vec![s.u(), s.v(), s.z()]),
        Nodes::Grid(g) => (2, vec![g.u().len(), g.v().len()], vec![g.u(), g.v(), g.z()]),
        Nodes::Matrix(m) => (3, vec![m.y().len(), m.columns()], vec![m.x(), m.y()]),
    };
    let weight = match nodes {
        Nodes::Curve(c) => c.weight(),
        Nodes::Scattered(s) => s.weight(),
        Nodes::Grid(g) => g.weight(),
        Nodes::Matrix(m) => m.weight(),
    };
    let (valid, names) = match nodes {
        Nodes::Grid(g) => (g.valid(), None),
        Nodes::Matrix(m) => (None, m.names()),
        _ => (None, None),
    };
    let flag = |there: bool, bit: u8| if there { bit } else { 0 };
    let flags = flag(weight.is_some(), WEIGHT) | flag(valid.is_some(), VALID) | flag(names.is_some(), NAMES);
    let mut head = Vec::with_capacity(8 + 8 * counts.len());
    head.extend_from_slice(MAGIC);
    head.extend_from_slice(&[kind, flags, 0, 0]);
    for count in counts {
        head.extend_from_slice(&(count as u64).to_le_bytes());
    }
    doubles.extend(weight);
    let mut tail: Vec<u8> = valid.into_iter().flatten().map(|&v| u8::from(v)).collect();
    for name in names.into_iter().flatten() {
        tail.extend_from_slice(&(name.len() as u32).to_le_bytes());
        tail.extend_from_slice(name.as_bytes());
    }
    Layout { head, doubles, tail }
}

/// Nodes to bytes.
pub fn encode(nodes: &Nodes) -> Vec<u8> {
    let Layout { head, doubles, tail } = layout(nodes);
    let count: usize = doubles.iter().map(|array| array.len()).sum();
    let mut bytes = Vec::with_capacity(head.len() + 8 * count + tail.len());
    bytes.extend_from_slice(&head);
    for array in doubles {
        push_doubles(&mut bytes, array);
    }
    bytes.extend_from_slice(&tail);
    bytes
}

/// Appends doubles in little-endian order (one copy on the processors this runs on).
fn push_doubles(bytes: &mut Vec<u8>, values: &[f64]) {
    let begin = bytes.len();
    bytes.resize(begin + 8 * values.len(), 0);
    for (place, value) in bytes[begin..].chunks_exact_mut(8).zip(values) {
        place.copy_from_slice(&value.to_le_bytes());
    }
}

/// Bytes to nodes, checked like posted ones.
pub fn decode(bytes: &[u8]) -> Result<Nodes, String> {
    let mut input = Input { bytes };
    let magic: [u8; 4] = input.array()?;
    if &magic != MAGIC {
        return Err(format!("the stored nodes begin with {magic:?}, not with FFN1"));
    }
    let [kind, flags, _, _] = input.array()?;
    let nodes = match kind {
        0 => {
            let m = input.count()?;
            let (x, y) = (input.doubles(m)?, input.doubles(m)?);
            Nodes::curve(x, y, input.weight(flags, m)?)
        }
        1 => {
            let m = input.count()?;
            let (u, v, z) = (input.doubles(m)?, input.doubles(m)?, input.doubles(m)?);
            Nodes::scattered(u, v, z, input.weight(flags, m)?)
        }
        2 => {
            let (nu, nv) = (input.count()?, input.count()?);
            let m = nu.checked_mul(nv).ok_or(COUNTS)?;
            let (u, v, z) = (input.doubles(nu)?, input.doubles(nv)?, input.doubles(m)?);
            let weight = input.weight(flags, m)?;
            let valid = match flags & VALID {
                0 => None,
                _ => Some(input.take(m)?.iter().map(|&byte| byte != 0).collect()),
            };
            Nodes::grid(u, v, z, valid, weight)
        }
        3 => {
            let (m, columns) = (input.count()?, input.count()?);
            let entries = m.checked_mul(columns).ok_or(COUNTS)?;
            let (x, y) = (input.doubles(entries)?, input.doubles(m)?);
            let weight = input.weight(flags, m)?;
            let names = match flags & NAMES {
                0 => None,
                _ => Some((0..columns).map(|_| input.name()).collect::<Result<_, _>>()?),
            };
            Nodes::matrix(x, columns, y, names, weight)
        }
        other => return Err(format!("the stored nodes have the unknown type {other}")),
    };
    match input.bytes.len() {
        0 => nodes.map_err(|faults| format!("the stored nodes are not sound: {faults:?}")),
        rest => Err(format!("{rest} bytes follow the stored nodes")),
    }
}

struct Input<'a> {
    bytes: &'a [u8],
}

impl<'a> Input<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.bytes.split_at_checked(count).ok_or("the stored nodes end too early")?;
        self.bytes = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn count(&mut self) -> Result<usize, String> {
        usize::try_from(u64::from_le_bytes(self.array()?)).map_err(|_| COUNTS.to_owned())
    }

    fn doubles(&mut self, count: usize) -> Result<Vec<f64>, String> {
        let bytes = self.take(count.checked_mul(8).ok_or(COUNTS)?)?;
        Ok(bytes.as_chunks::<8>().0.iter().map(|&chunk| f64::from_le_bytes(chunk)).collect())
    }

    fn weight(&mut self, flags: u8, count: usize) -> Result<Option<Vec<f64>>, String> {
        (flags & WEIGHT != 0).then(|| self.doubles(count)).transpose()
    }

    fn name(&mut self) -> Result<String, String> {
        let length = u32::from_le_bytes(self.array()?) as usize;
        String::from_utf8(self.take(length)?.to_vec()).map_err(|_| "a stored column name is not UTF-8".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn examples() -> Vec<Nodes> {
        vec![
            Nodes::curve(vec![1.0, -0.0], vec![3.0, 1e-308], Some(vec![0.0, 2.0])).unwrap(),
            Nodes::scattered(vec![1.0], vec![2.0], vec![3.0], None).unwrap(),
            Nodes::grid(vec![0.0, 1.0], vec![5.0], vec![f64::NAN, 1.0], Some(vec![true, false]), None).unwrap(),
            Nodes::grid(vec![0.0, 1.0], vec![5.0], vec![2.0, 1.0], None, Some(vec![1.0, 0.5])).unwrap(),
            Nodes::matrix(vec![1.0, 2.0, 3.0, 4.0], 2, vec![5.0, 6.0], Some(vec!["a".into(), "µ".into()]), None)
                .unwrap(),
        ]
    }

    #[test]
    fn nodes_come_back_bit_by_bit() {
        for nodes in examples() {
            let bytes = encode(&nodes);
            // By their bytes: NaN is not equal to itself, and −0 is equal to 0.
            assert_eq!(encode(&decode(&bytes).unwrap()), bytes, "{nodes:?}");
        }
    }

    #[test]
    fn other_bytes_are_refused() {
        for nodes in examples() {
            let bytes = encode(&nodes);
            for cut in 0..bytes.len() {
                assert!(decode(&bytes[..cut]).is_err());
            }
            let mut long = bytes;
            long.push(0);
            assert_eq!(decode(&long), Err("1 bytes follow the stored nodes".to_owned()));
        }
        assert_eq!(decode(b"FFN2....").unwrap_err(), "the stored nodes begin with [70, 70, 78, 50], not with FFN1");
        assert_eq!(decode(b"FFN1\x07\0\0\0").unwrap_err(), "the stored nodes have the unknown type 7");
        let huge = [b"FFN1\x02\0\0\0".as_slice(), &[0xff; 16]].concat();
        assert_eq!(decode(&huge).unwrap_err(), COUNTS);
    }
}
