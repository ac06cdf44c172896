//! The entries that writes leave, on their way into a database.

use uuid::Uuid;

use crate::jobs::{
    Tenant,
    audit::{Action, By, Chain, Contents, Entry, Found, Head, Prepared},
};

/// An entry about to be stored.
#[derive(Clone, Debug)]
pub struct NewEntry {
    pub tenant: Tenant,
    /// The key of its chain.
    pub chain: Uuid,
    pub entry: Entry,
}

/// A chain in the transaction that adds to it.
#[derive(Clone, Debug)]
pub struct Growing {
    tenant: Tenant,
    chain: Uuid,
    /// True if a purge may take names out of its entries.
    is_of_job: bool,
    head: Head,
    /// The entries to store.
    pub new: Vec<NewEntry>,
}

impl Growing {
    /// The chain behind its last entry; before the first there is none.
    pub fn from(tenant: &Tenant, chain: Chain, head: Option<Head>) -> Self {
        let head = head.unwrap_or_else(|| Head::before(chain, tenant));
        let is_of_job = matches!(chain, Chain::Job(_));
        Growing { tenant: tenant.clone(), chain: chain.id(tenant), is_of_job, head, new: Vec::new() }
    }

    /// The chain of a job that is older than the entries: it begins with what was found.
    pub fn begin(by: By<'_>, job: Uuid, found: &Found) -> Self {
        let mut chain = Growing::from(&by.caller.tenant, Chain::Job(job), None);
        let own = found.job.map(|job| ("job".to_owned(), job.digest));
        let rows = own.into_iter().chain([("found".to_owned(), found.digest())]);
        let prepared = Prepared::begin(job, Contents::of(rows.collect()));
        chain.add(by, prepared, Action::Begin, target::job(job));
        chain
    }

    /// The chain of a tenant some of whose keys are older than the entries: it begins with what was
    /// found of each.
    pub fn begin_tenant(by: By<'_>, tenant: &Tenant, found: Contents) -> Self {
        let mut chain = Growing::from(tenant, Chain::Tenant, None);
        if found.iter().next().is_some() {
            let prepared = Prepared::begin(chain.chain, found);
            chain.add(by, prepared, Action::Begin, target::tenant(tenant));
        }
        chain
    }

    /// Adds an entry, which is stored with others.
    pub fn enter(&mut self, by: By<'_>, mut prepared: Prepared, action: Action, target: String) -> NewEntry {
        if self.is_of_job {
            match Contents::salt() {
                Ok(salt) => prepared.contents = prepared.contents.salted(&salt),
                // nothing is refused for what matters once the job is purged
                Err(error) => tracing::error!(%error, "an entry of the audit has no salt"),
            }
        }
        let entry = self.head.append(by, prepared, action, target);
        NewEntry { tenant: self.tenant.clone(), chain: self.chain, entry }
    }

    /// Adds an entry.
    pub fn add(&mut self, by: By<'_>, prepared: Prepared, action: Action, target: String) {
        let new = self.enter(by, prepared, action, target);
        self.new.push(new);
    }
}

/// The paths of changed things.
pub mod target {
    use uuid::Uuid;

    use crate::jobs::{KeyId, Tenant};

    pub fn job(job: Uuid) -> String {
        format!("/v1/jobs/{job}")
    }

    pub fn iteration(job: Uuid, number: u32) -> String {
        format!("/v1/jobs/{job}/iterations/{number}")
    }

    pub fn fit(job: Uuid, number: u32, fit: Uuid) -> String {
        format!("/v1/jobs/{job}/iterations/{number}/fits/{fit}")
    }

    pub fn record(job: Uuid, number: u32, record: Uuid) -> String {
        format!("/v1/jobs/{job}/iterations/{number}/records/{record}")
    }

    pub fn key(key: KeyId) -> String {
        format!("/v1/keys/{key}")
    }

    pub fn tenant(name: &Tenant) -> String {
        format!("/v1/tenants/{}", name.as_str())
    }

    pub fn stream(stream: Uuid) -> String {
        format!("/v1/streams/{stream}")
    }

    pub fn block(stream: Uuid, sequence: u64) -> String {
        format!("/v1/streams/{stream}/blocks/{sequence}")
    }
}
