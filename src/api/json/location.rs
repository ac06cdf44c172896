//! The location in a request that is being read, as a JSON Pointer (RFC 6901).

use std::fmt::Write as _;

/// A location below which something is read: the steps to it stand on the stack.
#[derive(Clone, Copy, Debug)]
pub enum Location<'p> {
    Root,
    Member(&'p Location<'p>, &'p str),
    Entry(&'p Location<'p>, usize),
}

impl Location<'_> {
    pub fn pointer(&self) -> String {
        let mut text = String::new();
        self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) {
        match self {
            Location::Root => {}
            Location::Member(parent, key) => {
                parent.write(text);
                text.extend(["/", &escape(key)]);
            }
            Location::Entry(parent, index) => {
                parent.write(text);
                // Writing to a string cannot fail.
                let _ = write!(text, "/{index}");
            }
        }
    }
}

/// A key as a part of a JSON Pointer.
pub fn escape(key: &str) -> String {
    // Keys come from the caller; a long one would only be echoed.
    let short: String = key.chars().take(64).collect();
    short.replace('~', "~0").replace('/', "~1")
}
