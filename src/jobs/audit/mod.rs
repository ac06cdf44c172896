//! The audit: one entry for each change, stored in the same transaction, with digests of the rows
//! that the change wrote.
//!
//! Writers do not link their entries, so that they do not wait for each other. Every few seconds a
//! server orders the new entries of each tenant, links them into the tenant's chain, and seals its
//! end. A seal that is kept elsewhere convicts whoever writes a chain anew. The layout of every
//! digest is in `docs/reference/audit.md`.

mod contents;
mod entry;
mod examination;
mod layout;
mod seal;
mod signing;
mod verify;

pub use contents::Contents;
pub use entry::{Action, By, Entry, Link, ListedEntry};
pub use examination::{Auditor, Evidence, Verdict, examine};
pub use layout::{Fields, Sha256Digest, time_text};
pub use seal::{Seal, Sealed, Sealing};
pub use signing::{Signed, SigningKey, public_key};
pub use verify::{ChainVerifier, Difference, Kind, RowVerifier, is_sound, left};
