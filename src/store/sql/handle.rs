//! A store as one caller sees it: reads go to the readers, writes into the queue, each with its
//! caller.

use std::{any::type_name, sync::Arc, time::Instant};

use futures_util::future::BoxFuture;
use jiff::Timestamp;
use tracing::Instrument as _;
use uuid::Uuid;

use super::{
    api_keys::NoteUses,
    db::Db,
    error::{Outcome, StoreError, failure},
    operations,
    read_turns::{EndsRead, READ_TIME, READING, Watch},
    store::Database,
    write::{Request, Write},
    writes::*,
};
use crate::{
    jobs::{
        audit::{ListedEntry, Seal},
        *,
    },
    key_operations, repository_operations, telemetry,
};
use flankfit_engine::estimation::Nodes;

/// See the module's documentation.
pub struct Handle {
    database: Arc<Database>,
    caller: Caller,
    /// The party whose share its reads use; `None` for the server's own.
    party: Option<Tenant>,
}

/// Returns whether a read is one statement, or several that need not see the same state.
fn needs_no_snapshot(name: &str) -> bool {
    const NAMES: [&str; 3] = [
        "FindCertificate FindKey GetAllEvents GetAnswer GetBlockSha256 GetBlocks GetEvents GetJob GetKey GetLastEvent",
        "GetLastPlace GetMapping GetPlant GetSeals GetStream GetSuccessors HasAllAfter HasKeys",
        "ListJobs ListKeys ListPlants",
    ];
    NAMES.iter().flat_map(|names| names.split(' ')).any(|without| without == name)
}

impl Handle {
    /// The handle of reads and writes that come before it is known who asks.
    pub fn of_nobody(database: Arc<Database>) -> Self {
        Handle { database, caller: Caller::nobody(), party: None }
    }

    pub fn new(database: Arc<Database>, caller: Caller) -> Self {
        let party = Some(caller.tenant.clone());
        Handle { database, caller, party }
    }

    /// Runs a read in its own task, so that it holds its turn until its connection is free even if
    /// nobody waits for it any more.
    fn read<T: Send + 'static>(
        &self,
        name: &'static str,
        read: impl for<'a> Fn(&'a mut Db, &'a Caller) -> BoxFuture<'a, Outcome<T>> + Send + Sync + 'static,
    ) -> RepositoryFuture<'static, T> {
        let (database, caller, party) = (self.database.clone(), self.caller.clone(), self.party.clone());
        let span = telemetry::store_span(database.system(), name);
        let reading = async move {
            let begun = Instant::now();
            let turn = match database.turns.take(&party).await {
                Ok(turn) => turn,
                Err(error) => return traced(Err(error)),
            };
            let watch = Watch::lasting(READ_TIME);
            let _ends_when_left = EndsRead(watch.clone());
            let read = async move {
                let _turn = turn;
                let found = loop {
                    let found = async {
                        let mut db = match needs_no_snapshot(name) {
                            true => database.readers.connection().await?,
                            false => database.readers.snapshot().await?,
                        };
                        read(&mut db, &caller).await
                    };
                    match found.await {
                        Ok(found) => break Ok(found),
                        Err(StoreError::Refused(error)) => break Err(error),
                        Err(StoreError::Broken(error)) if database.reads_again(&error, begun) => {}
                        Err(StoreError::Broken(error)) => break Err(failure(&error)),
                    }
                };
                database.read_seconds.record(begun.elapsed());
                found
            };
            match tokio::spawn(READING.scope(watch, read).in_current_span()).await {
                Ok(found) => traced(found),
                Err(error) => match error.try_into_panic() {
                    Ok(panic) => std::panic::resume_unwind(panic),
                    Err(error) => traced(Err(RepositoryError::Failed(error.to_string()))),
                },
            }
        };
        Box::pin(reading.instrument(span))
    }

    /// The write is in the queue before this returns its future: dropping the future changes
    /// nothing.
    fn write<W: Write>(&self, write: W) -> RepositoryFuture<'static, W::Reply> {
        let database = &self.database;
        let at = database.clock.now();
        let request = Request::of(self.caller.clone(), at, write.intent());
        let span = telemetry::store_span(database.system(), type_name::<W>());
        let writing = database.queue(request.subject).write(request, write);
        Box::pin(async move { traced(writing.await) }.instrument(span))
    }
}

/// Marks the operation's span as failed where the store could not do it. A refusal is a result.
fn traced<T>(outcome: Result<T, RepositoryError>) -> Result<T, RepositoryError> {
    let kind = match &outcome {
        Err(RepositoryError::Overloaded) => "overloaded",
        Err(RepositoryError::Unavailable(_)) => "store_unavailable",
        Err(RepositoryError::OutcomeUnknown(_)) => "outcome_unknown",
        Err(RepositoryError::Failed(_)) => "internal",
        _ => return outcome,
    };
    telemetry::failed(&telemetry::here(), kind);
    outcome
}

/// Makes the methods of a trait of operations.
macro_rules! declare {
    (
        $Trait:ident
        reads { $($(#[$about:meta])* $Read:ident = $read:ident($($of:ident: $what:ty),*) -> $found:ty;)* }
        writes { $($(#[$on:meta])* $Write:ident = $write:ident($($with:ident: $given:ty),*) -> $reply:ty;)* }
    ) => {
        impl $Trait for Handle {
            $(fn $read(&self, $($of: $what),*) -> RepositoryFuture<'static, $found> {
                let values = Arc::new(($($of,)*));
                self.read(stringify!($Read), move |db, caller| {
                    let values = values.clone();
                    Box::pin(async move {
                        let ($($of,)*) = &*values;
                        operations::$read(db, caller, $($of),*).await
                    })
                })
            })*

            $(fn $write(&self, $($with: $given),*) -> RepositoryFuture<'static, $reply> {
                self.write($Write { $($with),* })
            })*
        }
    };
}

repository_operations!(declare);
key_operations!(declare);

impl Credentials for Handle {
    fn find_key(&self, id: KeyId) -> RepositoryFuture<'_, Option<KnownKey>> {
        self.read("FindKey", move |db, _| Box::pin(operations::find_key(db, id)))
    }

    fn find_certificate(&self, san: San) -> RepositoryFuture<'_, Option<KnownKey>> {
        let san = Arc::new(san);
        self.read("FindCertificate", move |db, _| Box::pin(operations::find_certificate(db, san.clone())))
    }

    fn find_tenant(&self, name: Tenant) -> RepositoryFuture<'_, Option<Plant>> {
        let reading = self.plant(name);
        Box::pin(async move {
            match reading.await {
                Ok(plant) => Ok(Some(plant)),
                Err(RepositoryError::NotFound(_)) => Ok(None),
                Err(error) => Err(error),
            }
        })
    }

    fn has_keys(&self) -> RepositoryFuture<'_, bool> {
        self.read("HasKeys", |db, _| Box::pin(operations::has_keys(db)))
    }

    fn note_uses(&self, uses: Vec<(KeyId, Timestamp)>) -> RepositoryFuture<'_, ()> {
        self.write(NoteUses { uses })
    }
}
