//! Entries, and the chain that they are.

use std::{borrow::Cow, sync::Arc};

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    contents::Contents,
    layout::{Fields, Sha256Digest},
};
use crate::jobs::callers::{Caller, Tenant};

/// What a chain begins with, before the tenant and the job.
const GENESIS: &str = "flankfit audit 1";

/// Whose entries follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Chain {
    Job(Uuid),
    /// Changes of the tenant that are of no job: of its keys, and of itself.
    Tenant,
}

impl Chain {
    /// The key of a chain: the id of its job, or one that no job has.
    pub fn id(self, tenant: &Tenant) -> Uuid {
        match self {
            Chain::Job(job) => job,
            Chain::Tenant => derived(Fields::default().text(GENESIS).text(tenant.as_str()).digest()),
        }
    }

    /// What stands where the first entry has the digest of the one before it.
    pub fn genesis(self, tenant: &Tenant) -> Sha256Digest {
        let job = match self {
            Chain::Job(job) => job.to_string(),
            Chain::Tenant => String::new(),
        };
        Fields::default().text(GENESIS).text(tenant.as_str()).text(&job).digest()
    }
}

/// An id made of a digest. Its version, 8, tells it from those of jobs.
fn derived(digest: Sha256Digest) -> Uuid {
    let (chunks, _) = digest.as_chunks::<16>();
    uuid::Builder::from_custom_bytes(chunks[0]).into_uuid()
}

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Nothing: the rest was there before there were entries.
    Begin,
    CreateJob,
    ChangeJob,
    DeleteJob,
    PurgeJob,
    AddIteration,
    AddFit,
    ChooseFit,
    Decide,
    /// Change of the measurand of its nodes.
    Amend,
    AddRecord,
    OpenStream,
    AddBlock,
    FinishStream,
    DeleteStream,
    CreateKey,
    ChangeKey,
    RotateKey,
    RevokeKey,
    CreateTenant,
    ChangeTenant,
}

impl Action {
    pub fn name(self) -> &'static str {
        match self {
            Action::Begin => "audit.begin",
            Action::CreateJob => "job.create",
            Action::ChangeJob => "job.change",
            Action::DeleteJob => "job.delete",
            Action::PurgeJob => "job.purge",
            Action::AddIteration => "iteration.add",
            Action::AddFit => "fit.add",
            Action::ChooseFit => "fit.choose",
            Action::Decide => "iteration.decide",
            Action::Amend => "iteration.amend",
            Action::AddRecord => "record.add",
            Action::OpenStream => "stream.open",
            Action::AddBlock => "stream.block",
            Action::FinishStream => "stream.finish",
            Action::DeleteStream => "stream.delete",
            Action::CreateKey => "key.create",
            Action::ChangeKey => "key.change",
            Action::RotateKey => "key.rotate",
            Action::RevokeKey => "key.revoke",
            Action::CreateTenant => "tenant.create",
            Action::ChangeTenant => "tenant.change",
        }
    }

    /// What it came to.
    fn outcome(self) -> &'static str {
        match self {
            Action::Begin => "found",
            Action::ChangeJob | Action::ChangeKey | Action::RevokeKey | Action::ChangeTenant => "changed",
            Action::DeleteJob | Action::DeleteStream => "deleted",
            Action::PurgeJob => "purged",
            _ => "stored",
        }
    }
}

/// Who changes something, and when they asked.
#[derive(Clone, Copy, Debug)]
pub struct By<'a> {
    pub caller: &'a Caller,
    pub at: Timestamp,
}

/// What is known of an entry before its change has its turn.
#[derive(Clone, Debug)]
pub struct Prepared {
    pub id: Uuid,
    pub contents: Contents,
}

impl Prepared {
    /// The beginning of the chain of a job, or of a tenant's keys, that are older than the entries.
    pub fn begin(chain: Uuid, contents: Contents) -> Self {
        Prepared { id: derived(Fields::default().text(GENESIS).text(&chain.to_string()).digest()), contents }
    }
}

/// An entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// 1, 2, 3 … within its chain.
    pub number: u64,
    pub id: Uuid,
    pub at: Timestamp,
    /// Empty where a purge took the name away.
    pub actor: Arc<str>,
    pub action: Cow<'static, str>,
    /// Path of the changed resource.
    pub target: String,
    pub request_id: Option<Arc<str>>,
    pub peer: Option<Arc<str>>,
    pub contents: Contents,
    pub outcome: Cow<'static, str>,
    /// Digest of the entry before it.
    pub previous: Sha256Digest,
    pub sha256: Sha256Digest,
}

impl Entry {
    /// Whether a purge took the name away of who made it: then `sha256` tells more than there is.
    pub fn is_nameless(&self) -> bool {
        self.actor.is_empty()
    }

    /// The digest of everything else in it.
    pub fn digest(&self) -> Sha256Digest {
        Fields::default()
            .bytes(&self.previous)
            .number(self.number)
            .text(&self.id.to_string())
            .time(self.at)
            .text(&self.actor)
            .text(&self.action)
            .text(&self.target)
            .maybe(self.request_id.as_deref())
            .maybe(self.peer.as_deref())
            .bytes(self.contents.bytes())
            .text(&self.outcome)
            .digest()
    }
}

/// The last entry of a chain, to which the next one is linked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// 0 before the first.
    pub number: u64,
    pub sha256: Sha256Digest,
}

impl Head {
    /// Before the first entry.
    pub fn before(chain: Chain, tenant: &Tenant) -> Self {
        Head { number: 0, sha256: chain.genesis(tenant) }
    }

    /// The next entry, which is the head from then on.
    pub fn append(&mut self, by: By<'_>, Prepared { id, contents }: Prepared, action: Action, target: String) -> Entry {
        let mut entry = Entry {
            number: self.number + 1,
            id,
            at: by.at,
            actor: by.caller.actor.clone(),
            action: action.name().into(),
            target,
            request_id: by.caller.origin.request_id.clone(),
            peer: by.caller.origin.peer.map(|peer| peer.to_string().into()),
            contents,
            outcome: action.outcome().into(),
            previous: self.sha256,
            sha256: [0; 32],
        };
        entry.sha256 = entry.digest();
        *self = Head { number: entry.number, sha256: entry.sha256 };
        entry
    }
}
