//! Everything that there is of the audit, of every tenant, gone through from outside: by whoever
//! may read the database, whether or not a server runs on it.

use std::collections::{BTreeMap, BTreeSet};

use uuid::Uuid;

use super::{
    entry::Chain,
    layout::Sha256Digest,
    seal::{Seal, WholeSeal},
    verify::{Verdict, What},
};
use crate::jobs::{
    callers::Tenant,
    outcome::{RepositoryError, RepositoryFuture},
};

/// Seals that are read at a time.
const SEALS: u32 = 64;

/// Reads the audit of all tenants. Each answer is of one state of the store.
pub trait Auditor: Send + Sync + 'static {
    /// The tenants of whom there is anything.
    fn tenants(&self) -> RepositoryFuture<'_, BTreeSet<Tenant>>;

    /// The keys of the chains of a tenant's jobs: of those that are there and of those that were.
    fn chains(&self, tenant: Tenant) -> RepositoryFuture<'_, BTreeSet<Uuid>>;

    /// Whether a chain and the rows that it tells of are as they were written. `sealed` are digests
    /// by numbers that seals kept elsewhere have; the store's own seals are asked besides.
    fn verify(
        &self,
        tenant: Tenant,
        chain: Chain,
        sealed: BTreeMap<u64, Sha256Digest>,
    ) -> RepositoryFuture<'_, Verdict>;

    /// Some seals of a tenant with their heads, after the one numbered `after`, oldest first.
    fn whole_seals(&self, tenant: Tenant, after: u64, limit: u32) -> RepositoryFuture<'_, Vec<WholeSeal>>;
}

/// Where something is not as it was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Chain(Chain),
    /// The seals of the tenant, which are a chain themselves.
    Seals,
}

/// Something that is not as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    pub tenant: Tenant,
    pub place: Place,
    pub number: u64,
    pub what: What,
}

/// What an examination came to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    pub chains: u64,
    pub entries: u64,
    pub seals: u64,
    /// The first fault of each chain.
    pub faults: Vec<Fault>,
    /// Whether the store contains any chain.
    pub has_chains: bool,
    /// Chains and seals that could not be read, and why.
    pub unreadable: Vec<(Tenant, Place, String)>,
}

/// What is held against the store.
#[derive(Default)]
pub struct Evidence {
    /// Seals that were kept elsewhere, with or without their heads.
    kept: BTreeMap<Tenant, BTreeMap<u64, WholeSeal>>,
    /// The key that all seals must be signed by.
    key: Option<[u8; 32]>,
}

impl Evidence {
    /// Refuses, by its place, a seal that is not as it was made, and one that another of the same
    /// number contradicts: such evidence proves nothing.
    pub fn of(seals: Vec<WholeSeal>, key: Option<[u8; 32]>) -> Result<Self, usize> {
        let mut evidence = Evidence { kept: BTreeMap::new(), key };
        for (place, kept) in seals.into_iter().enumerate() {
            let sound = if kept.heads.is_empty() { kept.seal.is_sound() } else { kept.is_sound() };
            let of_tenant = evidence.kept.entry(kept.seal.tenant.clone()).or_default();
            let other = of_tenant.get(&kept.seal.number).filter(|other| other.seal.sha256 != kept.seal.sha256);
            if !sound || !signed_by(&kept.seal, key) || other.is_some() {
                return Err(place);
            }
            if !kept.heads.is_empty() || !of_tenant.contains_key(&kept.seal.number) {
                of_tenant.insert(kept.seal.number, kept);
            }
        }
        Ok(evidence)
    }

    /// Digests of entries by chains and numbers.
    fn heads(&self, tenant: &Tenant) -> BTreeMap<Uuid, BTreeMap<u64, Sha256Digest>> {
        let mut heads: BTreeMap<Uuid, BTreeMap<u64, Sha256Digest>> = BTreeMap::new();
        for head in self.kept.get(tenant).into_iter().flat_map(BTreeMap::values).flat_map(|kept| &kept.heads) {
            heads.entry(head.chain).or_default().insert(head.number, head.sha256);
        }
        heads
    }
}

fn signed_by(seal: &Seal, key: Option<[u8; 32]>) -> bool {
    key.is_none_or(|key| seal.signed.is_some_and(|signed| signed.public_key == key))
}

/// Goes through the audit of a job, or of everything; none for a job that there is not and never
/// was.
pub async fn examine(
    auditor: &dyn Auditor,
    job: Option<Uuid>,
    evidence: &Evidence,
) -> Result<Option<Findings>, RepositoryError> {
    let mut findings = Findings::default();
    let mut tenants = auditor.tenants().await?;
    tenants.extend(evidence.kept.keys().cloned());
    let mut met = job.is_none();
    for tenant in tenants {
        let mut heads = evidence.heads(&tenant);
        let own = Chain::Tenant.id(&tenant);
        let mut chains = auditor.chains(tenant.clone()).await?;
        findings.has_chains |= !chains.is_empty();
        chains.extend(heads.keys());
        chains.remove(&own);
        if let Some(job) = job {
            if !chains.contains(&job) {
                continue;
            }
            (met, chains) = (true, BTreeSet::from([job]));
        }
        match findings.examine_seals(auditor, &tenant, evidence).await {
            Err(RepositoryError::Failed(why)) => findings.unreadable.push((tenant.clone(), Place::Seals, why)),
            examined => examined?,
        }
        let jobs = chains.into_iter().map(|id| (id, Chain::Job(id)));
        let tenants_own = job.is_none().then_some((own, Chain::Tenant));
        for (id, chain) in tenants_own.into_iter().chain(jobs) {
            let sealed = heads.remove(&id).unwrap_or_default();
            findings.chains += 1;
            match auditor.verify(tenant.clone(), chain, sealed).await {
                Ok(Verdict::Intact { entries, .. }) => findings.entries += entries,
                Ok(Verdict::Broken { number, what }) => findings.note(&tenant, Place::Chain(chain), number, what),
                // an unreadable value must not hide faults of the other chains
                Err(RepositoryError::Failed(why)) => {
                    findings.unreadable.push((tenant.clone(), Place::Chain(chain), why))
                }
                Err(error) => return Err(error),
            }
        }
    }
    Ok(met.then_some(findings))
}

impl Findings {
    /// Whether everything was readable and nothing was altered.
    pub fn is_intact(&self) -> bool {
        self.faults.is_empty() && self.unreadable.is_empty()
    }

    /// Whether the store contains nothing that could be verified.
    pub fn holds_nothing(&self) -> bool {
        !self.has_chains && self.seals == 0 && self.unreadable.is_empty()
    }

    /// Whether there is nothing to verify, and no evidence that there ever was.
    pub fn is_empty(&self) -> bool {
        self.holds_nothing() && self.is_intact()
    }

    fn note(&mut self, tenant: &Tenant, place: Place, number: u64, what: What) {
        self.faults.push(Fault { tenant: tenant.clone(), place, number, what });
    }

    /// Goes through the seals of a tenant, up to the first fault.
    async fn examine_seals(
        &mut self,
        auditor: &dyn Auditor,
        tenant: &Tenant,
        evidence: &Evidence,
    ) -> Result<(), RepositoryError> {
        let (mut number, mut previous) = (0, Seal::genesis(tenant));
        let kept = evidence.kept.get(tenant);
        loop {
            let page = auditor.whole_seals(tenant.clone(), number, SEALS).await?;
            let last = page.len() < SEALS as usize;
            for whole in page {
                let seal = &whole.seal;
                let kept = kept.and_then(|kept| kept.get(&(number + 1)));
                let fault = match seal {
                    seal if seal.number != number + 1 || seal.sha256 != seal.digest() => Some(What::Entry),
                    seal if seal.previous != previous => Some(What::Link),
                    _ if !whole.has_its_heads() => Some(What::Content),
                    seal if !seal.is_sound() || !signed_by(seal, evidence.key) => Some(What::Seal),
                    seal => kept.filter(|kept| kept.seal.sha256 != seal.sha256).map(|_| What::Seal),
                };
                if let Some(what) = fault {
                    self.note(tenant, Place::Seals, number + 1, what);
                    return Ok(());
                }
                (number, previous) = (seal.number, seal.sha256);
                self.seals += 1;
            }
            if last {
                break;
            }
        }
        // what was kept elsewhere was there once
        if kept.is_some_and(|kept| kept.keys().next_back().is_some_and(|last| *last > number)) {
            self.note(tenant, Place::Seals, number + 1, What::Entry);
        }
        Ok(())
    }
}
