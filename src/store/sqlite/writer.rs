//! The task that owns the writing connection.
//!
//! It runs each group of the queue inside one `BEGIN IMMEDIATE … COMMIT`. A write that is refused
//! refuses before it changes anything and spoils nothing. Should the database refuse a group as a
//! whole (a constraint that the checks did not foresee), each of its writes is tried again alone,
//! so that only the guilty one fails.

use std::{
    fs::File,
    time::{Duration, Instant},
};

use super::{
    error::{code, failure},
    in_place::InPlace,
    open::StoreSettings,
};
use crate::{
    jobs::{RepositoryError, Unfit},
    store::sql::{Db, Group, Queued, Session, Waiting, run_group, seconds},
};

/// SQLite's primary codes for data it will not have: constraint, mismatch, too big.
const REFUSING_CODES: [i32; 3] = [19, 20, 18];

/// Returns whether an error may be that of one write of a group: each is then tried alone.
fn refuses(error: &sqlx::Error) -> bool {
    // a write that was refused after its first change
    matches!(error, sqlx::Error::InvalidArgument(_)) || code(error).is_some_and(|code| REFUSING_CODES.contains(&code))
}

/// How long the log waits for readers to be emptied, and when it is tried again.
const ERASE_PATIENCE: &str = "PRAGMA busy_timeout = 1000";
const PATIENCE: &str = "PRAGMA busy_timeout = 10000";
const ERASE_AGAIN: Duration = Duration::from_secs(10);

/// Interval at which the files are checked while nothing is written.
const LOOK: Duration = Duration::from_secs(1);

pub struct Writer {
    settings: StoreSettings,
    session: Session,
    /// Held as long as this writes.
    lock: Option<File>,
    waiting: Waiting,
    commit_seconds: metrics::Histogram,
    files: InPlace,
    /// True if one of the files was found removed or replaced.
    misplaced: bool,
    /// Since when the log has what shall be nowhere any more.
    to_erase: Option<Instant>,
}

impl Writer {
    pub fn new(settings: StoreSettings, db: Db, lock: Option<File>, waiting: Waiting) -> Self {
        let commit_seconds = seconds("commit");
        let files = InPlace::of(&settings.path());
        Writer {
            settings,
            session: Session::of(db),
            lock,
            waiting,
            commit_seconds,
            files,
            misplaced: false,
            to_erase: None,
        }
    }

    /// Writes until everybody who could ask is gone or somebody closes the store.
    pub async fn run(mut self) {
        loop {
            let group = match tokio::time::timeout(LOOK, self.waiting.next_group()).await {
                Ok(Some(group)) => group,
                Ok(None) => break,
                Err(_nothing_came) => {
                    let _told_in_the_log = self.check_files();
                    continue;
                }
            };
            let begun = Instant::now();
            self.serve(group).await;
            self.commit_seconds.record(begun.elapsed());
            if self.to_erase.is_some_and(|tried| tried.elapsed() > ERASE_AGAIN) {
                self.erase().await;
            }
        }
        if self.check_files().is_err() {
            // closing would remove the log by its name, which may now belong to another database
            std::mem::forget(self.session);
        } else if let Err(error) = self.session.db.close().await {
            tracing::warn!(%error, "the database did not close cleanly");
        }
        drop(self.lock);
        self.waiting.closed();
    }

    /// Refuses to continue if the files are no longer those at the path.
    fn check_files(&mut self) -> Result<(), Unfit> {
        let missing = self.files.missing();
        if let Some(file) = missing.filter(|_| !self.misplaced) {
            tracing::error!(
                file = %file.display(),
                "a file of the open database was removed or replaced; nothing is stored any more, since it would be \
                 lost. Stop this server, put the database and its -wal file back together or restore a backup, and \
                 start it again"
            );
        }
        self.misplaced = missing.is_some();
        if self.misplaced { Err(Unfit::Misplaced) } else { Ok(()) }
    }

    /// Runs a group, and if one of its writes is refused by the database, each alone.
    async fn serve(&mut self, group: Group) {
        let Some(group) = self.serve_together(group).await else { return };
        for write in group {
            // alone, a write is answered whatever happens
            let _answered = self.serve_together(vec![write]).await;
        }
    }

    /// Runs a group as one transaction; returns it where each of its writes is to be tried alone.
    async fn serve_together(&mut self, mut group: Group) -> Option<Group> {
        let refuse = |group: Group, why| {
            group.into_iter().for_each(|write| write.end(Some(RepositoryError::Unfit(why))));
        };
        if let Err(why) = self.check_files() {
            refuse(group, why);
            return None;
        }
        let stored = self.transact(&mut group).await;
        if stored.is_ok()
            && let Err(why) = self.check_files()
        {
            refuse(group, why);
            return None;
        }
        if stored.is_ok() && group.iter().any(|write| write.request().erases) {
            self.erase().await;
        }
        match stored {
            Ok(()) => group.into_iter().for_each(|write| write.end(None)),
            Err(error) if group.len() > 1 && refuses(&error) => {
                tracing::error!(%error, requests = group.len(), "a group of writes failed; trying each alone");
                return Some(group);
            }
            Err(error) => {
                tracing::error!(%error, requests = group.len(), "a transaction failed");
                group.into_iter().for_each(|write| write.end(Some(failure(&error))));
            }
        }
        None
    }

    /// Copies the log into the database and empties it: the pages in it are of before. A reader
    /// that still sees one of these is waited for, but not long.
    async fn erase(&mut self) {
        let db = &mut self.session.db;
        let emptied = async {
            db.script(ERASE_PATIENCE).await?;
            db.checkpoint().await
        };
        let emptied = emptied.await;
        let patient = db.script(PATIENCE).await;
        let emptied = emptied.and_then(|emptied| patient.map(|()| emptied)).unwrap_or_else(|error| {
            tracing::warn!(%error, "the log of the database could not be emptied");
            false
        });
        self.to_erase = (!emptied).then(Instant::now);
    }

    /// One transaction. Afterwards it is committed or undone, whatever happened.
    async fn transact(&mut self, group: &mut [Box<dyn Queued>]) -> Result<(), sqlx::Error> {
        let result = run(&mut self.session, group).await;
        if let Err(error) = &result {
            // SQLite undoes some failed transactions itself and then says that there is none: both
            // are fine.
            let undone = self.session.db.run("ROLLBACK", &[]).await;
            let lost = |error: &sqlx::Error| matches!(error, sqlx::Error::WorkerCrashed | sqlx::Error::Io(_));
            if lost(error) || undone.is_err_and(|error| lost(&error)) {
                match self.settings.reopen_writer().await {
                    Ok(db) => {
                        self.session = Session::of(db);
                        self.files = InPlace::of(&self.settings.path());
                    }
                    Err(error) => tracing::error!(%error, "the writing connection was lost and cannot be opened again"),
                }
            }
        }
        result
    }
}

async fn run(session: &mut Session, group: &mut [Box<dyn Queued>]) -> Result<(), sqlx::Error> {
    session.db.run("BEGIN IMMEDIATE", &[]).await?;
    session.lock(group.iter().map(|write| write.request()).collect()).await?;
    run_group(session, group).await?;
    session.finish().await?;
    session.db.run("COMMIT", &[]).await.map(drop)
}
