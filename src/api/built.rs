//! Answers of requests that can be kept.

/// What was made of a request: the contract's name of the method, and the answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Built {
    pub method: String,
    /// JSON.
    pub result: Vec<u8>,
}
