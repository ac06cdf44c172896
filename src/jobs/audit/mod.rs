//! The audit: one entry for each change, stored in the same transaction.
//!
//! The entries of a job are a chain: each holds the digest of the one before it, and digests of the
//! rows that its change wrote. So whoever changes, removes or exchanges a row later is found, and
//! so is whoever changes an entry. The chain of a tenant tells of its keys. Seals have the ends of
//! chains, to be kept elsewhere: they convict who writes chains anew. The layout of every digest is
//! in `docs/reference/audit.md`.

mod auditor;
mod changing;
mod contents;
mod digests;
mod entry;
mod found;
mod layout;
mod merkle;
mod purged;
mod seal;
mod signing;
mod verify;

pub use auditor::{Auditor, Evidence, Fault, Findings, Place, examine};
pub use changing::Versioned;
pub use contents::Contents;
pub use digests::{
    block_digest, choice_digest, decision_digest, fit_digest, iteration_digest, job_digest, key_digest, new_iteration,
    nodes_digest, plant_digest, purge_digest, record_digest, stream_digest,
};
pub use entry::{Action, By, Chain, Entry, Head, Prepared};
pub use found::{Found, FoundStream, Kind};
pub use layout::{Sha256Digest, time_text};
pub use purged::{Nameless, purged};
pub use seal::{Seal, SealedHead, Sealing, Unsealed, WholeSeal, root_of, seals};
pub use signing::{Signed, SigningKey, public_key};
pub use verify::{Verdict, Verifier, What};
