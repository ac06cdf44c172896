//! The canonical form of a request's input and its digest, `provenance.input_sha256`.
//!
//! Two requests that ask for the same thing have the same digest whatever their white space, key order, number
//! spelling or explicit defaults. The form is the concatenation of
//!
//! 1. `flankfit-input-v1\n`;
//! 2. the nodes in the binary form of [`super::nodes_codec`] (which has lengths before everything), in which every
//!    −0 is +0, every NaN is the one with bits `0x7ff8000000000000`, an all-ones weight or all-true mask stands as posted;
//! 3. the spec as the JSON text of [`super::fit_spec_json::to_json`]: every default filled in, keys in the
//!    contract's order, no white space, numbers in their shortest form, −0 as 0.
//!
//! Decisions: `null` and `"valid": false` are different inputs (the second carries a height), as are a weight of
//! ones and no weight.

use sha2::{Digest, Sha256};

use super::{fit_spec_json, nodes_codec};
use crate::estimation::{FitSpec, Nodes};

const TAG: &[u8] = b"flankfit-input-v1\n";

/// SHA-256 of the canonical form, in lower-case hexadecimal.
pub fn input_sha256(nodes: &Nodes, spec: &FitSpec) -> String {
    let mut bytes = nodes_codec::encode(nodes);
    normalize(nodes, &mut bytes);
    let mut digest = Sha256::new();
    digest.update(TAG);
    digest.update(&bytes);
    digest.update(fit_spec_json::to_json(spec).as_bytes());
    hexadecimal(&digest.finalize())
}

/// −0 → +0 and one NaN, in the doubles of encoded nodes.
fn normalize(nodes: &Nodes, bytes: &mut [u8]) {
    let (counts, doubles) = match nodes {
        Nodes::Curve(c) => (1, 2 * c.x.len() + c.weight.as_ref().map_or(0, Vec::len)),
        Nodes::Scattered(s) => (1, 3 * s.u.len() + s.weight.as_ref().map_or(0, Vec::len)),
        Nodes::Grid(g) => (2, g.u.len() + g.v.len() + g.z.len() + g.weight.as_ref().map_or(0, Vec::len)),
        Nodes::Matrix(m) => (2, m.x.len() + m.y.len() + m.weight.as_ref().map_or(0, Vec::len)),
    };
    let begin = 8 + 8 * counts;
    for chunk in bytes[begin..begin + 8 * doubles].as_chunks_mut::<8>().0 {
        let value = f64::from_le_bytes(*chunk);
        if value == 0.0 {
            *chunk = [0; 8];
        } else if value.is_nan() {
            *chunk = 0x7ff8_0000_0000_0000_u64.to_le_bytes();
        }
    }
}

/// Bytes in lower-case hexadecimal.
pub fn hexadecimal(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]).map(|digit| char::from(DIGITS[usize::from(digit)])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::spec::{Degree, Model, PolynomialBasis, Terms};

    fn spec(degree: usize) -> FitSpec {
        FitSpec::new(Model::Polynomial {
            degree: Degree::Both(degree),
            basis: PolynomialBasis::Monomial,
            terms: Terms::Tensor,
        })
    }

    #[test]
    fn signs_of_zero_do_not_matter_and_everything_else_does() {
        let nodes = |x: f64| Nodes::curve(vec![x, 1.0], vec![2.0, 3.0], None).unwrap();
        let digest = input_sha256(&nodes(0.0), &spec(1));
        assert_eq!(digest.len(), 64);
        assert_eq!(digest, input_sha256(&nodes(-0.0), &spec(1)));
        assert_ne!(digest, input_sha256(&nodes(f64::MIN_POSITIVE), &spec(1)));
        assert_ne!(digest, input_sha256(&nodes(0.0), &spec(2)));
        let weighted = Nodes::curve(vec![0.0, 1.0], vec![2.0, 3.0], Some(vec![1.0, 1.0])).unwrap();
        assert_ne!(digest, input_sha256(&weighted, &spec(1)));
    }
}
