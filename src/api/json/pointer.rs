//! Places in a request as JSON Pointers (RFC 6901).

/// A key as a part of a JSON Pointer (RFC 6901).
pub fn escape(key: &str) -> String {
    // Keys come from the caller; a long one would only be echoed.
    let short: String = key.chars().take(64).collect();
    short.replace('~', "~0").replace('/', "~1")
}
