//! An answer as it comes, kept out of the memory that is counted: a long one waits in a file.

use std::io::{Read as _, Seek as _, SeekFrom, Write as _};

use tempfile::SpooledTempFile;

/// Bytes that are held in memory at most.
const SHORT: usize = 1 << 20;

pub struct Spool(SpooledTempFile);

impl Default for Spool {
    fn default() -> Self {
        Spool(SpooledTempFile::new(SHORT))
    }
}

impl Spool {
    pub fn put(&mut self, piece: &[u8]) {
        self.0.write_all(piece).expect("there is room for an answer");
    }

    /// All of it, now in memory.
    pub fn into_bytes(mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.0.seek(SeekFrom::Start(0)).and_then(|_| self.0.read_to_end(&mut bytes)).expect("what was put is read");
        bytes
    }
}
