//! Writes: what each is about, and its run inside a transaction.

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    audit::Draft,
    db::Db,
    error::Outcome,
    keys::{OwnedKey, StoredFit},
    session::Session,
};
use crate::jobs::{
    Caller, Receipt, Stored, Tenant,
    audit::{Action, By},
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
    /// True if nothing that it takes away may be left in a file afterwards.
    pub erases: bool,
}

impl<'a> Intent<'a> {
    /// A change of a job.
    pub fn job(job: Uuid) -> Self {
        Intent { subject: Subject::Job(job), ..Intent::default() }
    }

    /// A change of a stream.
    pub fn stream(stream: Uuid) -> Self {
        Intent { subject: Subject::Stream(stream), ..Intent::default() }
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
}

/// Who asks for a write, and what it is about.
#[derive(Debug)]
pub struct Request {
    pub caller: Caller,
    pub at: Timestamp,
    pub subject: Subject,
    pub bytes: usize,
    pub erases: bool,
    pub key: Option<OwnedKey>,
}

impl Request {
    pub fn of(caller: Caller, at: Timestamp, intent: Intent<'_>) -> Self {
        let Intent { subject, bytes, receipt, erases } = intent;
        let key = receipt.map(|receipt| OwnedKey::of(&caller.tenant, receipt));
        Request { caller, at, subject, bytes, erases, key }
    }

    /// A write of the server itself, which is not audited.
    pub fn of_nobody(subject: Subject, bytes: usize) -> Self {
        let intent = Intent { subject, bytes, ..Intent::default() };
        Request::of(Caller::nobody(), Timestamp::UNIX_EPOCH, intent)
    }

    pub fn by(&self) -> By<'_> {
        By { caller: &self.caller, at: self.at }
    }
}

/// A write inside its transaction.
pub struct Tx<'a> {
    pub session: &'a mut Session,
    pub request: &'a Request,
}

impl<'a> Tx<'a> {
    pub fn db(&mut self) -> &mut Db {
        &mut self.session.db
    }

    pub fn by(&self) -> By<'a> {
        self.request.by()
    }

    pub fn tenant(&self) -> &'a Tenant {
        &self.request.caller.tenant
    }

    /// Refuses a request whose key has an answer already (its client asked twice, and the other
    /// request was first).
    pub fn refuse_taken(&self) -> Outcome<()> {
        Ok(self.session.keys.refuse_taken(self.request.key.as_ref())?)
    }

    /// Keeps the response in the transaction of the change that it describes.
    pub fn keep(
        &mut self,
        receipt: &Option<Receipt>,
        stored: Stored,
        fit: Option<StoredFit<'_>>,
        now: Timestamp,
    ) -> Stored {
        let about = match self.request.subject {
            Subject::Job(id) | Subject::Stream(id) => Some(id),
            Subject::Nothing => None,
        };
        self.session.keys.keep(self.tenant(), receipt.as_ref(), about, stored, fit, now);
        stored
    }

    /// Begins the entry of a change of a job of the caller.
    pub fn draft(&self, job: Uuid, action: Action, subject: String) -> Outcome<Draft> {
        Draft::new(self.by(), self.tenant(), Some(job), action, subject)
    }

    /// Begins the entry of a change of a tenant or its keys.
    pub fn draft_of(&self, tenant: &Tenant, action: Action, subject: String) -> Outcome<Draft> {
        Draft::new(self.by(), tenant, None, action, subject)
    }

    /// Enters a change that was made. The entry is stored with the others of the transaction.
    pub fn enter(&mut self, entry: Draft) {
        self.session.entries.push(entry);
    }
}
