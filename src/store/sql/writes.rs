//! The writes of callers as data. Each is run by the function of its name, in the file of its
//! table.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    error::Outcome,
    operations,
    write::{Intent, Tx, Write},
};
use crate::{jobs::*, key_operations, repository_operations};

/// Makes a struct of each write.
macro_rules! declare {
    (
        $Trait:ident
        reads { $($(#[$about:meta])* $Read:ident = $read:ident($($of:ident: $what:ty),*) -> $found:ty;)* }
        writes { $($(#[$on:meta])* $Write:ident = $write:ident($($with:ident: $given:ty),*) -> $reply:ty;)* }
    ) => {
        $(
            $(#[$on])*
            pub struct $Write {
                $(pub $with: $given,)*
            }

            impl Write for $Write {
                type Reply = $reply;

                fn intent(&self) -> Intent<'_> {
                    self.described()
                }

                async fn run(&self, tx: &mut Tx<'_>) -> Outcome<$reply> {
                    operations::$write(tx, self).await
                }
            }
        )*
    };
}

repository_operations!(declare);
key_operations!(declare);

/// Describes writes.
macro_rules! intents {
    ($($Write:ident: |$write:ident| $intent:expr;)*) => {
        $(impl $Write {
            fn described(&self) -> Intent<'_> {
                let $write = self;
                $intent
            }
        })*
    };
}

intents! {
    InsertJob: |new| Intent::job(new.job.id).receipt(&new.receipt);
    PatchJob: |of| Intent::job(of.id);
    DeleteJob: |of| Intent::job(of.id);
    PurgeJob: |of| Intent { erases: true, ..Intent::job(of.purge.job) }.receipt(&of.receipt);
    InsertRuns: |new| {
        let bytes = new.runs.iter().flat_map(|run| &run.iterations).map(|iteration| iteration.bytes()).sum();
        let of = new.runs.first().map_or_else(Intent::default, |run| Intent::job(run.job.id));
        of.receipt(&new.receipt).bytes(bytes)
    };
    InsertIteration: |new| {
        Intent::job(new.iteration.job_id).receipt(&new.receipt).bytes(new.iteration.bytes())
    };
    InsertFit: |new| Intent::job(new.job).receipt(&new.receipt).bytes(new.fit.bytes());
    Choose: |of| Intent::job(of.job);
    Decide: |of| Intent::job(of.job);
    Amend: |of| {
        let fit = of.amendment.fit.as_ref().map_or(0, NewFit::bytes);
        Intent::job(of.job).bytes(of.amendment.record.bytes() + fit)
    };
    InsertRecord: |new| Intent::job(new.job).receipt(&new.receipt).bytes(new.record.bytes());
    InsertStream: |new| Intent::job(new.stream.job_id).receipt(&new.receipt);
    InsertBlock: |new| {
        let bytes = new.block.nodes.bytes().len() + new.block.state.as_ref().map_or(0, Vec::len);
        Intent::stream(new.block.stream).bytes(bytes).receipt(&new.receipt)
    };
    FinishStream: |of| {
        let FinishedStream { stream, iteration, .. } = &of.finished;
        Intent::stream(*stream).bytes(iteration.bytes()).receipt(&of.receipt)
    };
    DeleteStream: |of| Intent::stream(of.id);
    KeepMapping: |_of| Intent::default();
    InsertKey: |new| Intent::default().receipt(&new.receipt);
    PatchKey: |_of| Intent::default();
    RotateKey: |of| Intent::default().receipt(&of.receipt);
    RevokeKey: |_of| Intent::default();
    InsertPlant: |new| Intent::default().receipt(&new.receipt);
    PatchPlant: |_of| Intent::default();
}
