//! Jobs in PostgreSQL, for several processes at a time.
//!
//! **Writers.** Writes go by their job to one of a few tasks (`writer`), each with a connection of
//! its own. Writes that wait there together share one transaction and so one sync. It locks the
//! rows of its jobs in ascending order, then claims its idempotency keys in ascending order, and
//! only then reads: numbers, positions and versions that were read stay the same until it commits,
//! and no two transactions wait for each other.
//!
//! **A lost COMMIT is settled.** Each transaction first takes a lock of its own and last stores the
//! entries of the audit. Where the connection was lost before the answer to COMMIT, the repetition
//! takes the same lock: it waits for the end of the first transaction, and finds its entries there,
//! or not.
//!
//! **Readers.** Reads come from a pool of connections; one that asks more than once does so in one
//! read-only transaction of the level REPEATABLE READ.
//!
//! **Wakes.** After its commits a process notifies the others of the changes (`wakes`).

mod error;
mod message;
mod migrate;
mod open;
mod settings;
mod wakes;
mod writer;

pub use error::{PostgresError, failure, is_lost};
pub use migrate::{migrate, postgres_migrations, unfit};
pub use open::{begin, open_postgres, postgres_auditor, postgres_holdings, snapshot};
pub use settings::{Migrate, PostgresSettings};
pub use wakes::Notifications;
