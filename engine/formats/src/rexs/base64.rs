//! Coded lists: little-endian numbers in base64, which REXS allows in place of single elements.
//!
//! Read by hand: programs break these lists into lines and pad them or not, which the decoders of
//! the `base64` crate refuse, and a long list must be able to stop when its request is cancelled.

use flankfit_numerics::cancel::Asking;

/// Type of the numbers in the bytes of a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Code {
    Int32,
    Float32,
    Float64,
}

impl Code {
    pub(crate) fn named(name: &str) -> Option<Self> {
        match name {
            "int32" => Some(Code::Int32),
            "float32" => Some(Code::Float32),
            "float64" => Some(Code::Float64),
            _ => None,
        }
    }

    /// The numbers of a text; `None` if it is not base64 or ends within a number.
    pub(crate) fn numbers(self, text: &str) -> Option<Vec<f64>> {
        let bytes = bytes(text)?;
        match self {
            Code::Int32 => each(&bytes, |four| f64::from(i32::from_le_bytes(four))),
            Code::Float32 => each(&bytes, |four| f64::from(f32::from_le_bytes(four))),
            Code::Float64 => each(&bytes, f64::from_le_bytes),
        }
    }
}

fn each<const N: usize>(bytes: &[u8], number: impl Fn([u8; N]) -> f64) -> Option<Vec<f64>> {
    let (whole, rest) = bytes.as_chunks::<N>();
    rest.is_empty().then(|| whole.iter().map(|piece| number(*piece)).collect())
}

/// The bytes of base64 (RFC 4648) with or without padding; white space is passed over.
fn bytes(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut held) = (0u32, 0u32);
    let mut padded = false;
    for byte in text.bytes().asking(2).filter(|b| !b.is_ascii_whitespace()) {
        let six = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' => {
                padded = true;
                continue;
            }
            _ => return None,
        };
        if padded {
            return None;
        }
        bits = (bits << 6 | u32::from(six)) & 0xFFFF;
        held += 6;
        if held >= 8 {
            held -= 8;
            out.push((bits >> held) as u8);
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back() {
        // 1.0 and −2.5, made by another encoder
        assert_eq!(Code::Float64.numbers("AAAAAAAA8D8AAAAAAAAEwA=="), Some(vec![1.0, -2.5]));
        assert_eq!(Code::Float32.numbers("AACAPw AAIMA"), Some(vec![1.0, -2.5]));
        assert_eq!(Code::Int32.numbers("AQAAAP7///8="), Some(vec![1.0, -2.0]));
        assert_eq!(Code::Int32.numbers(""), Some(vec![]));
        assert_eq!(Code::Int32.numbers("AQAA"), None);
        assert_eq!(Code::Float64.numbers("A=B"), None);
        assert_eq!(Code::Float64.numbers("Ä"), None);
    }
}
