//! Entries: each is of one change, and stored with it.

use std::{borrow::Cow, sync::Arc};

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    contents::Contents,
    layout::{Fields, Sha256Digest},
};
use crate::jobs::callers::{Caller, Tenant};

/// The kind of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    CreateJob,
    ChangeJob,
    DeleteJob,
    PurgeJob,
    ImportJob,
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

names! {
    Action {
        CreateJob "job.create", ChangeJob "job.change", DeleteJob "job.delete", PurgeJob "job.purge",
        ImportJob "job.import", AddIteration "iteration.add", AddFit "fit.add", ChooseFit "fit.choose",
        Decide "iteration.decide", Amend "iteration.amend", AddRecord "record.add", OpenStream "stream.open",
        AddBlock "stream.block", FinishStream "stream.finish", DeleteStream "stream.delete", CreateKey "key.create",
        ChangeKey "key.change", RotateKey "key.rotate", RevokeKey "key.revoke", CreateTenant "tenant.create",
        ChangeTenant "tenant.change",
    }
}

/// Who changes something, and when they asked.
#[derive(Clone, Copy, Debug)]
pub struct By<'a> {
    pub caller: &'a Caller,
    pub at: Timestamp,
}

/// An entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// UUIDv7.
    pub id: Uuid,
    pub tenant: Tenant,
    /// The job that was changed; none for a change of a key or a tenant.
    pub job: Option<Uuid>,
    pub at: Timestamp,
    /// None once the job is purged.
    pub actor: Option<Arc<str>>,
    pub action: Cow<'static, str>,
    /// Path of the changed resource.
    pub subject: String,
    pub request_id: Option<Arc<str>>,
    pub peer: Option<Arc<str>>,
    /// Digests of the rows as the change left them.
    pub contents: Contents,
    /// Random bytes that the digests begin with, so that nobody finds out by trying what a purged
    /// row contained; none once the job is purged.
    pub salt: Option<Vec<u8>>,
    /// Digest of the actor.
    pub who: Sha256Digest,
}

impl Entry {
    /// Makes an entry without contents; fails where the system has no random numbers.
    pub fn new(
        by: By<'_>,
        tenant: &Tenant,
        job: Option<Uuid>,
        action: Action,
        subject: String,
    ) -> Result<Self, getrandom::Error> {
        let mut random = [0; 42];
        getrandom::fill(&mut random)?;
        let (salt, rest) = random.split_at(32);
        // so that ids of one millisecond ascend too
        let fraction = (by.at.as_microsecond().rem_euclid(1000) * 4).to_be_bytes();
        let mut rest: [u8; 10] = rest.try_into().unwrap_or_default();
        rest[..2].copy_from_slice(&fraction[6..]);
        let milliseconds = by.at.as_millisecond().try_into().unwrap_or_default();
        let id = uuid::Builder::from_unix_timestamp_millis(milliseconds, &rest);
        let mut entry = Entry {
            id: id.into_uuid(),
            tenant: tenant.clone(),
            job,
            at: by.at,
            actor: Some(by.caller.actor.clone()),
            action: action.name().into(),
            subject,
            request_id: by.caller.origin.request_id.clone(),
            peer: by.caller.origin.peer.map(|peer| peer.to_string().into()),
            contents: Contents::default(),
            salt: Some(salt.to_vec()),
            who: [0; 32],
        };
        entry.who = entry.digest_of_actor().unwrap_or_default();
        Ok(entry)
    }

    /// Returns the digest of the actor; none once the job is purged.
    pub fn digest_of_actor(&self) -> Option<Sha256Digest> {
        let (salt, actor) = (self.salt.as_ref()?, self.actor.as_ref()?);
        Some(Fields::default().bytes(salt).text(actor).digest())
    }

    /// Returns the digest of all that stays of it after a purge.
    pub fn digest(&self) -> Sha256Digest {
        Fields::default()
            .text(&self.id.to_string())
            .text(self.tenant.as_str())
            .maybe(self.job.map(|job| job.to_string()).as_deref())
            .time(self.at)
            .text(&self.action)
            .text(&self.subject)
            .maybe(self.request_id.as_deref())
            .maybe(self.peer.as_deref())
            .bytes(self.contents.bytes())
            .bytes(&self.who)
            .digest()
    }
}

/// An entry with its place in the chain of its tenant; none before it is sealed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedEntry {
    pub entry: Entry,
    pub place: Option<Link>,
}

/// A place in the chain of a tenant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// 1, 2, 3 … within the tenant, without gaps; 0 before the first.
    pub number: u64,
    /// Digest of the link before and of the entry.
    pub sha256: Sha256Digest,
}

/// Beginning of the chain of a tenant.
const GENESIS: &str = "flankfit audit 2";

impl Link {
    /// The place before the first entry.
    pub fn genesis(tenant: &Tenant) -> Self {
        Link { number: 0, sha256: Fields::default().text(GENESIS).text(tenant.as_str()).digest() }
    }

    /// Returns the next place, with an entry of this digest.
    pub fn next(&self, entry: &Sha256Digest) -> Self {
        let number = self.number + 1;
        Link { number, sha256: Fields::default().bytes(&self.sha256).number(number).bytes(entry).digest() }
    }
}
