//! Two handles on one new store, and values to put into it.

use std::{
    pin::Pin,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
};

use flankfit::jobs::{Caller, Keys, Repository, RepositoryFuture, Store, Tenant};

use uuid::Uuid;

use super::recorder::{Exercised, Turns, Watched};
use crate::support::{Values, caller};

pub type Soon<'a, T> = Pin<Box<dyn Future<Output = T> + 'a>>;

/// A kind of store, with a new and empty one of it.
pub trait Ground {
    /// A handle on the store: another with each call, where a store takes several at a time.
    fn open(&self) -> Soon<'_, Arc<dyn Store>>;

    /// The same of a store that was closed, in which no more than so many writes may wait.
    fn open_narrow(&self, places: usize) -> Soon<'_, Arc<dyn Store>>;

    /// Waits until all handles are closed: the store may be opened again.
    fn closed(&self) -> Soon<'_, ()>;

    /// Waits until every transaction of the server that has begun has ended.
    fn settled(&self) -> Soon<'_, ()>;

    /// Does something that the triggers would refuse, as an intruder does who owns the database.
    fn intrude(&self, sql: String) -> Soon<'_, ()>;

    /// Does something behind the handles' backs, as whoever owns the database; what the database
    /// says against it.
    fn refusal(&self, sql: &'static str) -> Soon<'_, Option<String>>;

    /// True if the database's SQL has TRUNCATE.
    fn truncates(&self) -> bool;

    /// Has the database refuse each new entry of the audit, or take them again.
    fn refuse_entries(&self, refused: bool) -> Soon<'_, ()>;

    /// Takes away the triggers and checks that a forger does not meet either.
    fn defenceless(&self) -> Soon<'_, ()>;

    /// Every column of every table: table, name and type.
    fn columns(&self) -> Soon<'_, Vec<(String, String, String)>>;

    /// SQL that makes another value of a column of a type; of several rows it makes different ones.
    fn changed(&self, column: &str, kind: &str) -> String;

    /// True if a text is anywhere in it.
    fn holds<'a>(&'a self, text: &'a str) -> Soon<'a, bool>;

    /// Statement that restores a table from its copy, `kept_…`.
    fn again(&self, table: &str) -> String {
        // others of jobs are generated
        const JOBS: &str = "id, tenant, name, part_number, serial_number, machine, gear, requirements, tags, version, \
            created_at, updated_at, changed_at, purged_at, iteration_count, status, class, folded";
        let (into, from) = if table == "jobs" { (format!("({JOBS})"), JOBS) } else { (String::new(), "*") };
        format!("DELETE FROM {table}; INSERT INTO {table} {into} SELECT {from} FROM kept_{table}")
    }

    /// Bytes as the database's SQL writes them.
    fn literal(&self, bytes: &[u8]) -> String;

    /// An id as the database's SQL writes it.
    fn id(&self, id: Uuid) -> String;
}

/// See the module's documentation.
pub struct Pair {
    pub ground: Box<dyn Ground>,
    pub handles: [Arc<dyn Store>; 2],
    /// The store as callers of one tenant see it, who have turns at the two handles.
    pub store: Arc<dyn Repository>,
    pub values: Arc<Values>,
    exercised: Arc<Exercised>,
}

impl Pair {
    pub async fn on(ground: impl Ground + 'static, exercised: Arc<Exercised>) -> Self {
        let handles = [ground.open().await, ground.open().await].map(|store| watched(store, &exercised));
        let store = seen_by(&handles, "default", &exercised);
        Pair { ground: Box::new(ground), handles, store, values: Arc::default(), exercised }
    }

    /// The store as callers of a tenant see it.
    pub fn seen_by(&self, tenant: &str) -> Arc<dyn Repository> {
        seen_by(&self.handles, tenant, &self.exercised)
    }

    /// The keys as callers of a tenant see them, who have turns at the two handles.
    pub fn keys_of(&self, tenant: &Tenant) -> Arc<dyn Keys> {
        let caller = Caller { tenant: tenant.clone(), actor: "test".into(), origin: Default::default() };
        let handles = self.handles.each_ref().map(|handle| handle.keys(&caller));
        Arc::new(Turns::<dyn Keys> { handles, next: AtomicUsize::new(0), exercised: self.exercised.clone() })
    }

    pub async fn close(&self) {
        for handle in &self.handles {
            handle.close().await;
        }
        self.ground.closed().await;
    }

    /// Closes the store and opens it again.
    pub async fn reopen(&mut self) {
        self.close().await;
        self.begin([self.ground.open().await, self.ground.open().await]);
    }

    /// The same with one handle, in whose queue there are so many places.
    pub async fn reopen_narrow(&mut self, places: usize) {
        self.close().await;
        let handle = self.ground.open_narrow(places).await;
        self.begin([handle.clone(), handle]);
    }

    fn begin(&mut self, handles: [Arc<dyn Store>; 2]) {
        self.handles = handles.map(|store| watched(store, &self.exercised));
        self.store = self.seen_by("default");
    }
}

fn watched(store: Arc<dyn Store>, exercised: &Arc<Exercised>) -> Arc<dyn Store> {
    Arc::new(Watched { store, exercised: exercised.clone() })
}

fn seen_by(handles: &[Arc<dyn Store>; 2], tenant: &str, exercised: &Arc<Exercised>) -> Arc<dyn Repository> {
    let handles = handles.each_ref().map(|handle| handle.of(&caller(tenant)));
    Arc::new(Turns::<dyn Repository> { handles, next: AtomicUsize::new(0), exercised: exercised.clone() })
}

impl<T: ?Sized + Send + Sync> Turns<T> {
    /// Asks whichever handle has its turn.
    pub fn ask<R: Send + 'static>(
        &self,
        operation: &'static str,
        ask: impl FnOnce(&T) -> RepositoryFuture<'static, R>,
    ) -> RepositoryFuture<'static, R> {
        self.exercised.operation(operation);
        let turn = self.next.fetch_add(1, Ordering::Relaxed);
        let asked = ask(&*self.handles[turn % 2]);
        let exercised = self.exercised.clone();
        Box::pin(async move { asked.await.inspect_err(|error| exercised.error(error)) })
    }
}
