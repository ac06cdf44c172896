//! Writes: what each is about, and its run inside a transaction.

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    db::Db,
    error::Outcome,
    growing::Growing,
    keys::{OwnedKey, StoredFit},
    queue::{Pending, Queued},
    session::Session,
};
use crate::jobs::{
    Caller, KeyId, Lease, Receipt, Stored, Tenant,
    audit::{Action, By, Contents, Prepared},
};

/// The subject of a write. Two writes of one subject do not run at the same time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Subject {
    Job(Uuid),
    /// A stream, and so its job.
    Stream(Uuid),
    /// No job, or new ones alone.
    #[default]
    Nothing,
}

/// The description of a write, known before it runs.
#[derive(Default)]
pub struct Intent<'a> {
    pub subject: Subject,
    /// The bytes that it adds to the log, roughly.
    pub bytes: usize,
    pub receipt: Option<&'a Receipt>,
    /// The contents of its entries in the audit, as far as they are known before.
    pub entries: Vec<Contents>,
    /// True if nothing that it takes away may be left in a file afterwards.
    pub erases: bool,
}

impl<'a> Intent<'a> {
    /// A change of a job, with one entry.
    pub fn job(job: Uuid, entry: Contents) -> Self {
        Intent { subject: Subject::Job(job), entries: vec![entry], ..Intent::default() }
    }

    /// A change of no job, with one entry.
    pub fn no_job(entry: Contents) -> Self {
        Intent { entries: vec![entry], ..Intent::default() }
    }

    pub fn receipt(self, receipt: &'a Option<Receipt>) -> Self {
        Intent { receipt: receipt.as_ref(), ..self }
    }

    pub fn bytes(self, bytes: usize) -> Self {
        Intent { bytes, ..self }
    }
}

/// A write.
///
/// It looks first and changes last: a refusal comes before its first change, so it leaves nothing
/// to undo in the transaction that it shares with others. It may run more than once, because a
/// transaction that failed may be repeated.
pub trait Write: Send + Sync + Sized + 'static {
    type Reply: Send + 'static;

    fn intent(&self) -> Intent<'_> {
        Intent::default()
    }

    fn run(&self, tx: &mut Tx<'_>) -> impl Future<Output = Outcome<Self::Reply>> + Send;

    /// Returns how it waits: alone, unless it runs together with others of its kind.
    fn queued(pending: Pending<Self>) -> Queued {
        Queued::Single(Box::new(pending))
    }
}

/// Who asks for a write, and what it is about.
#[derive(Debug)]
pub struct Asked {
    pub caller: Caller,
    pub at: Timestamp,
    pub subject: Subject,
    pub bytes: usize,
    pub erases: bool,
    pub key: Option<OwnedKey>,
    /// The lease under which a task asks for it.
    pub lease: Option<Lease>,
    /// The entries that it leaves.
    pub prepared: Vec<Prepared>,
}

impl Asked {
    pub fn of(caller: Caller, at: Timestamp, intent: Intent<'_>, fresh: impl Fn() -> Uuid) -> Self {
        let Intent { subject, bytes, receipt, entries, erases } = intent;
        let key = receipt.map(|receipt| OwnedKey::of(&caller.tenant, receipt));
        let lease = receipt.and_then(|receipt| receipt.request.lease);
        let prepared = entries.into_iter().map(|contents| Prepared { id: fresh(), contents }).collect();
        Asked { caller, at, subject, bytes, erases, key, lease, prepared }
    }

    /// A write of the server itself, which is not audited.
    pub fn of_nobody(subject: Subject, bytes: usize) -> Self {
        let intent = Intent { subject, bytes, ..Intent::default() };
        Asked::of(Caller::nobody(), Timestamp::UNIX_EPOCH, intent, Uuid::nil)
    }

    pub fn by(&self) -> By<'_> {
        By { caller: &self.caller, at: self.at }
    }
}

/// A write inside its transaction.
pub struct Tx<'a> {
    pub session: &'a mut Session,
    pub asked: &'a Asked,
}

impl<'a> Tx<'a> {
    pub fn db(&mut self) -> &mut Db {
        &mut self.session.db
    }

    pub fn by(&self) -> By<'a> {
        self.asked.by()
    }

    pub fn tenant(&self) -> &'a Tenant {
        &self.asked.caller.tenant
    }

    /// Refuses a request whose key has an answer already (its client asked twice, and the other
    /// request was first), and one of a task that another process has by now.
    pub fn refuse_taken(&self) -> Outcome<()> {
        Ok(self.session.keys.refuse_taken(self.asked.key.as_ref(), self.asked.lease)?)
    }

    /// Keeps the answer in the transaction of the change that it describes, and ends the task that
    /// asked for it.
    pub fn keep(&mut self, receipt: &Option<Receipt>, stored: Stored, fit: Option<StoredFit<'_>>, now: Timestamp) {
        self.session.keys.keep(self.tenant(), receipt.as_ref(), stored, fit, now);
    }

    /// Enters a change of a job of the caller, before it is made. The entry is stored with the
    /// others of the transaction.
    pub async fn enter(&mut self, job: Uuid, action: Action, target: String) -> Outcome<()> {
        let (by, prepared) = (self.by(), self.asked.prepared[0].clone());
        self.session.chain(by, job).await?.add(by, prepared, action, target);
        Ok(())
    }

    /// Enters a change of a job, with contents that are known only now.
    pub async fn enter_found(&mut self, job: Uuid, contents: Contents, action: Action, target: String) -> Outcome<()> {
        let (by, prepared) = (self.by(), Prepared { contents, ..self.asked.prepared[0].clone() });
        self.session.chain(by, job).await?.add(by, prepared, action, target);
        Ok(())
    }

    /// Enters a change of a tenant or its keys, with contents that are known only now, if there are
    /// any. `new` is a key that was stored already.
    pub async fn enter_tenant(
        &mut self,
        tenant: &Tenant,
        new: Option<KeyId>,
        contents: Option<Contents>,
        action: Action,
        target: String,
    ) -> Outcome<()> {
        let (by, prepared) = (self.by(), self.asked.prepared[0].clone());
        let prepared = Prepared { contents: contents.unwrap_or(prepared.contents), ..prepared };
        self.tenant_chain(tenant, new).await?.add(by, prepared, action, target);
        Ok(())
    }

    /// Returns the chain of a tenant.
    pub async fn tenant_chain(&mut self, tenant: &Tenant, new: Option<KeyId>) -> Outcome<&mut Growing> {
        self.session.tenant_chain(self.asked.by(), tenant, new).await
    }
}
