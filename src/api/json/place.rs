//! The place in a request that is being read, and places as JSON Pointers (RFC 6901).

use std::fmt::Write as _;

/// A place below which something is read: the steps to it stand on the stack.
#[derive(Clone, Copy, Debug)]
pub enum Place<'p> {
    Root,
    Member(&'p Place<'p>, &'p str),
    Entry(&'p Place<'p>, usize),
}

impl Place<'_> {
    pub fn pointer(&self) -> String {
        let mut text = String::new();
        self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) {
        match self {
            Place::Root => {}
            Place::Member(parent, key) => {
                parent.write(text);
                text.extend(["/", &escape(key)]);
            }
            Place::Entry(parent, index) => {
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
