//! Forwards events of other processes to the listeners of this one.

use std::{collections::HashMap, time::Duration};

use uuid::Uuid;

use super::{callers::Owned, repository::Wakes, service::JobService};

/// Time between two looks for events without a message.
const LOOK: Duration = Duration::from_secs(2);

impl JobService {
    /// Something happened to a job: who listens here or at another process is woken.
    pub(super) fn announce(&self, job: &Owned) {
        self.notifier.notify(job);
        if let Some(wakes) = &self.wakes {
            wakes.send(Wake::Job(job.clone()));
        }
    }

    /// Some stream was finished or deleted.
    pub(super) fn announce_stream_end(&self) {
        self.cache.announce_end();
        if let Some(wakes) = &self.wakes {
            wakes.send(Wake::StreamEnd);
        }
    }

    /// Some key or some tenant was changed.
    pub(super) fn announce_keys(&self) {
        self.keys_changed();
        if let Some(wakes) = &self.wakes {
            wakes.send(Wake::Keys);
        }
    }

    fn keys_changed(&self) {
        self.key_changes.send_modify(|changes| *changes += 1);
    }

    /// Receives messages of other processes, and sends them. It ends only where the store is this
    /// process's alone.
    pub async fn follow_others(&self) {
        if let Some(wakes) = &self.wakes {
            let ring = |wake| self.ring(wake);
            tokio::join!(wakes.pass_on(&ring), self.look(&**wakes));
        }
    }

    fn ring(&self, wake: Wake) {
        match wake {
            Wake::Job(job) => self.notifier.notify(&job),
            Wake::StreamEnd => self.cache.announce_end(),
            Wake::Keys => self.keys_changed(),
            Wake::Anything => {
                self.keys_changed();
                self.notifier.notify_all();
                self.cache.announce_end();
            }
        }
    }

    /// Looks now and then whether something happened to the jobs that somebody listens to.
    async fn look(&self, wakes: &dyn Wakes) {
        let mut known: HashMap<Uuid, u64> = HashMap::new();
        loop {
            tokio::time::sleep(LOOK).await;
            let listened = self.notifier.listened();
            if listened.is_empty() {
                known.clear();
                continue;
            }
            match wakes.last_events(listened.iter().map(|job| job.id).collect()).await {
                Ok(last) => {
                    let last: HashMap<Uuid, u64> = last.into_iter().collect();
                    let changed = listened.iter().filter(|job| last.get(&job.id) != known.get(&job.id));
                    changed.for_each(|job| self.notifier.notify(job));
                    known = last;
                }
                Err(error) => tracing::debug!(%error, "the last events of jobs could not be read"),
            }
        }
    }
}

/// A signal that others may wait for. It carries no data: its listeners look into the store,
/// so a wake that is lost costs time, and one too many a look.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Wake {
    /// Something happened to a job.
    Job(Owned),
    /// Some stream was finished or deleted.
    StreamEnd,
    /// Some key or some tenant was changed.
    Keys,
    /// Nothing was heard for a while, and anything may have happened.
    Anything,
}
