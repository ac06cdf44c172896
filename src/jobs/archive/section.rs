//! The section of a job: its lines, and their digest.

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use uuid::Uuid;

use super::row::{Row, to_hex};
use crate::jobs::callers::Tenant;

/// Whose section it is.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    pub tenant: Tenant,
    pub job: Uuid,
}

/// What all lines of a section come to, its first with the key.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Digested {
    /// Rows.
    pub rows: u64,
    /// SHA-256 of the lines, in hexadecimal digits.
    pub sha256: String,
}

/// A section whose lines come one after another.
pub struct Section {
    digest: Sha256,
    rows: u64,
}

impl Section {
    /// With its first line.
    pub fn begin(key: &Key) -> (Self, String) {
        let line = format!("{{\"section\":{{\"tenant\":\"{}\",\"job\":\"{}\"}}}}\n", key.tenant.as_str(), key.job);
        (Section { digest: Sha256::new_with_prefix(line.as_bytes()), rows: 0 }, line)
    }

    /// Takes the line of a row.
    pub fn line(&mut self, line: &str) {
        self.rows += 1;
        self.digest.update(line.as_bytes());
    }

    /// Takes a row and gives its line.
    pub fn row(&mut self, row: &Row) -> String {
        let line = row.to_line();
        self.line(&line);
        line
    }

    pub fn end(self) -> Digested {
        Digested { rows: self.rows, sha256: to_hex(&self.digest.finalize()) }
    }
}
