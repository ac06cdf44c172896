//! The audit of a job, of a tenant, or of all tenants, gone through from outside: by whoever may
//! read the database, whether or not a server runs on it.

use std::collections::{BTreeMap, BTreeSet};

use uuid::Uuid;

use super::{
    seal::Seal,
    verify::{Difference, Kind},
};
use crate::jobs::{
    callers::Tenant,
    outcome::{RepositoryError, RepositoryFuture},
};

/// Reads the audit of all tenants. Each answer is of one state of the store.
pub trait Auditor: Send + Sync + 'static {
    /// The names of tenants of which there is anything.
    fn tenants(&self) -> RepositoryFuture<'_, BTreeSet<String>>;

    /// The jobs of a tenant: those that exist and those that have entries.
    fn jobs(&self, tenant: Tenant) -> RepositoryFuture<'_, BTreeSet<Uuid>>;

    /// Verifies the rows of a job and the places of its entries.
    fn job(&self, tenant: Tenant, job: Uuid) -> RepositoryFuture<'_, Verdict>;

    /// Verifies the chain of a tenant, its seals, and its keys. `kept` are seals by numbers that
    /// were kept elsewhere; every seal must be signed by `key` if there is one.
    fn chain(&self, tenant: Tenant, kept: BTreeMap<u64, Seal>, key: Option<[u8; 32]>) -> RepositoryFuture<'_, Verdict>;
}

/// Result of a verification.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    pub jobs: u64,
    pub entries: u64,
    /// Entries that are in no seal yet: these are verified against their rows only.
    pub unsealed: u64,
    pub seals: u64,
    pub differences: BTreeSet<Difference>,
}

impl Verdict {
    /// Returns whether there is nothing to verify.
    pub fn is_empty(&self) -> bool {
        (self.jobs, self.entries, self.seals) == (0, 0, 0)
    }

    fn add(&mut self, of: Verdict) {
        self.jobs += of.jobs;
        self.seals += of.seals;
        self.entries += of.entries;
        self.unsealed += of.unsealed;
        self.differences.extend(of.differences);
    }

    /// Adds what was found, or that it cannot be read: that must not hide the rest.
    fn note(
        &mut self,
        found: Result<Verdict, RepositoryError>,
        tenant: &str,
        job: Option<Uuid>,
    ) -> Result<(), RepositoryError> {
        match found {
            Ok(found) => self.add(found),
            Err(RepositoryError::Failed(place)) => {
                self.differences.insert(Difference { tenant: tenant.to_owned(), job, place, kind: Kind::Unreadable });
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }
}

/// Evidence that the store is compared with.
#[derive(Default)]
pub struct Evidence {
    /// Seals that were kept elsewhere.
    kept: BTreeMap<Tenant, BTreeMap<u64, Seal>>,
    /// The key that all seals must be signed by.
    key: Option<[u8; 32]>,
}

impl Evidence {
    /// Refuses, by its place, a seal that is not as it was made, and one that another of the same
    /// number contradicts: such evidence proves nothing.
    pub fn of(seals: Vec<Seal>, key: Option<[u8; 32]>) -> Result<Self, usize> {
        let mut kept: BTreeMap<Tenant, BTreeMap<u64, Seal>> = BTreeMap::new();
        for (place, seal) in seals.into_iter().enumerate() {
            let of_tenant = kept.entry(seal.tenant.clone()).or_default();
            let contradicts = of_tenant.get(&seal.number).is_some_and(|other| other.sha256 != seal.sha256);
            if !seal.is_sound(key) || contradicts {
                return Err(place);
            }
            of_tenant.insert(seal.number, seal);
        }
        Ok(Evidence { kept, key })
    }
}

/// Goes through the audit of a job, of a tenant, or of everything. `step` is called with the part
/// of it that is done, 0 to 1.
pub async fn examine(
    auditor: &dyn Auditor,
    tenant: Option<&Tenant>,
    job: Option<Uuid>,
    evidence: &Evidence,
    step: &(dyn Fn(f64) + Sync),
) -> Result<Verdict, RepositoryError> {
    let mut verdict = Verdict::default();
    let mut tenants = match tenant {
        Some(tenant) => BTreeSet::from([tenant.as_str().to_owned()]),
        None => auditor.tenants().await?,
    };
    tenants.extend(evidence.kept.keys().map(|tenant| tenant.as_str().to_owned()));
    let count = tenants.len() as f64;
    for (k, name) in tenants.into_iter().enumerate() {
        let Some(tenant) = Tenant::kept(&name) else {
            let place = "the name of the tenant".to_owned();
            verdict.differences.insert(Difference { tenant: name, job: None, place, kind: Kind::Unreadable });
            continue;
        };
        let kept = evidence.kept.get(&tenant).cloned().unwrap_or_default();
        let mut jobs = auditor.jobs(tenant.clone()).await?;
        if let Some(job) = job {
            jobs.retain(|own| *own == job);
        }
        if job.is_none() || !kept.is_empty() {
            let found = auditor.chain(tenant.clone(), kept, evidence.key).await;
            verdict.note(found, &name, None)?;
        }
        let of_tenant = jobs.len() as f64;
        for (j, job) in jobs.into_iter().enumerate() {
            let found = auditor.job(tenant.clone(), job).await;
            verdict.note(found, &name, Some(job))?;
            step((k as f64 + (j + 1) as f64 / of_tenant) / count);
        }
    }
    Ok(verdict)
}
