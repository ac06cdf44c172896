//! The canonical form of a request's input and its digest, `provenance.input_sha256`.
//!
//! Two requests that ask for the same thing have the same digest whatever their white space, key
//! order, number spelling or explicit defaults. The form is the concatenation of
//!
//! 1. `flankfit-input-v1\n`;
//! 2. the nodes in the binary form of [`crate::jobs::nodes_codec`] (which has lengths before
//!    everything), in which every −0 is +0, every NaN is the one with bits `0x7ff8000000000000`, an
//!    all-ones weight or all-true mask is kept as posted;
//! 3. the spec as the JSON text of [`super::spec::json::to_json`]: every default filled in, keys
//!    in the contract's order, no white space, numbers in their shortest form, −0 as 0; without
//!    `include`, which adds to the answer and changes nothing of it;
//! 4. where earlier iterations are the prior, the nodes of each, oldest first, and after each the
//!    changes that corrections predicted before the next, as nodes too.
//!
//! Decisions: `null` and `"valid": false` are different inputs (the second carries a height), as
//! are a weight of ones and no weight.

use sha2::{Digest, Sha256};

use super::spec::json;
use crate::jobs::{
    nodes_codec::{self, Layout},
    rows::to_hex,
};
use flankfit_engine::{
    estimation::{
        FitSpec, Nodes,
        spec::{Include, Prior},
    },
    numerics::cancel::Asking,
};

const TAG: &[u8] = b"flankfit-input-v1\n";
const STREAM_TAG: &[u8] = b"flankfit-stream-v1\n";

/// Doubles that are brought into their canonical form and hashed at a time: few enough to stay near
/// the processor.
const BLOCK: usize = 512;

/// SHA-256 of the canonical form, in lower-case hexadecimal.
pub fn input_sha256(nodes: &Nodes, spec: &FitSpec) -> String {
    input_sha256_by(nodes, spec, &json::to_json(spec))
}

/// The same where the text of the spec is known.
pub fn input_sha256_by(nodes: &Nodes, spec: &FitSpec, text: &str) -> String {
    let mut digest = Sha256::new();
    digest.update(TAG);
    update(&mut digest, nodes);
    if spec.include == Include::default() {
        digest.update(text.as_bytes());
    } else {
        digest.update(without_include(spec).as_bytes());
    }
    if let Some(Prior::Iterations(chain)) = &spec.prior {
        for one in chain.earlier.iter().flat_map(|earlier| earlier.iter()) {
            update(&mut digest, &one.nodes);
            one.corrections.iter().for_each(|correction| update(&mut digest, &correction.change));
        }
    }
    to_hex(&digest.finalize())
}

fn without_include(spec: &FitSpec) -> String {
    json::to_json(&FitSpec { include: Include::default(), ..spec.clone() })
}

/// Digest of a request as it was posted, where its fit is one of many steps.
pub fn request_sha256(text: &[u8]) -> String {
    to_hex(&Sha256::digest(text))
}

/// SHA-256 of the nodes in their canonical form, by which a repeated block of a stream is known.
pub fn nodes_sha256(nodes: &Nodes) -> [u8; 32] {
    let mut digest = Sha256::new();
    update(&mut digest, nodes);
    digest.finalize().into()
}

/// The start of the chain of digests of a stream: `flankfit-stream-v1\n`, its spec without
/// `include`, and the bits of its forgetting factor. Each block makes it the digest of the one
/// before and the block's.
pub fn stream_sha256(spec: &FitSpec, forgetting_factor: f64) -> [u8; 32] {
    let mut digest = Sha256::new();
    digest.update(STREAM_TAG);
    digest.update(without_include(spec).as_bytes());
    digest.update(forgetting_factor.to_le_bytes());
    digest.finalize().into()
}

fn update(digest: &mut Sha256, nodes: &Nodes) {
    let Layout { head, doubles, tail } = nodes_codec::layout(nodes);
    digest.update(&head);
    let mut block = [0; 8 * BLOCK];
    for values in doubles.into_iter().flat_map(|array| array.chunks(BLOCK)).asking(20 * BLOCK) {
        let bytes = &mut block[..8 * values.len()];
        for (place, value) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(values) {
            *place = canonical(*value);
        }
        digest.update(bytes);
    }
    digest.update(&tail);
}

/// +0 for both zeros and one NaN for all.
fn canonical(value: f64) -> [u8; 8] {
    let value = if value.is_nan() { f64::from_bits(0x7ff8_0000_0000_0000) } else { value + 0.0 };
    value.to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_engine::estimation::spec::{Degree, Model, PolynomialBasis, Terms};

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
        let more = FitSpec { include: Include { residuals: true, ..Include::default() }, ..spec(1) };
        assert_eq!(digest, input_sha256(&nodes(0.0), &more), "what is answered beside does not count");
        let weighted = Nodes::curve(vec![0.0, 1.0], vec![2.0, 3.0], Some(vec![1.0, 1.0])).unwrap();
        assert_ne!(digest, input_sha256(&weighted, &spec(1)));
    }
}
