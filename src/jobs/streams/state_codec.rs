//! The numbers of a recursive estimate as bytes, for the store.
//!
//! `FFS1`, the count of numbers (8 bytes), the numbers (little-endian doubles), then the columns'
//! names as JSON (`null` where there are none). Bytes of another form are not read: the estimate is
//! then made again from the nodes.

use flankfit_engine::estimation::recursive::State;

const MAGIC: &[u8; 4] = b"FFS1";

pub fn encode(state: &State) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(16 + 8 * state.numbers.len());
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&(state.numbers.len() as u64).to_le_bytes());
    bytes.extend(state.numbers.iter().flat_map(|number| number.to_le_bytes()));
    bytes.extend(serde_json::json!(state.names).to_string().into_bytes());
    bytes
}

/// Returns whether bytes are such a state.
pub fn is_state(bytes: &[u8]) -> bool {
    decode(bytes).is_some()
}

/// `None` for bytes that [`encode`] did not write.
pub fn decode(bytes: &[u8]) -> Option<State> {
    let bytes = bytes.strip_prefix(MAGIC)?;
    let (count, bytes) = bytes.split_first_chunk::<8>()?;
    let count = usize::try_from(u64::from_le_bytes(*count)).ok()?;
    let (numbers, names) = bytes.split_at_checked(count.checked_mul(8)?)?;
    let numbers = numbers.as_chunks::<8>().0.iter().map(|&chunk| f64::from_le_bytes(chunk)).collect();
    Some(State { numbers, names: serde_json::from_slice(names).ok()? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_comes_back_and_other_bytes_do_not() {
        for names in [None, Some(vec!["µ".to_owned()])] {
            let state = State { numbers: vec![1.5, -0.0, f64::INFINITY], names };
            let bytes = encode(&state);
            assert_eq!(decode(&bytes), Some(state));
            assert!((0..bytes.len()).all(|cut| decode(&bytes[..cut]).is_none()));
        }
        assert_eq!(decode(b"FFS1\xff\xff\xff\xff\xff\xff\xff\xff"), None);
    }
}
