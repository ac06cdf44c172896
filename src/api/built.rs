//! Answers of requests that can be kept.

/// Result of a request: the contract's name of the method, and the response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Built {
    pub method: String,
    /// JSON.
    pub result: Vec<u8>,
}
