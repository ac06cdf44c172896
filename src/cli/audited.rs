//! How far an audit is gone through.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
};

use uuid::Uuid;

use crate::jobs::{
    RepositoryFuture, Tenant,
    audit::{Auditor, Chain, Sha256Digest, Verdict, WholeSeal},
};

/// An audit that counts what is asked of it.
pub struct Counted {
    of: Box<dyn Auditor>,
    tenants: AtomicUsize,
    /// Tenants whose chains were asked for.
    begun: AtomicUsize,
    /// The chains of the last of them, and how many of these are verified.
    chains: AtomicUsize,
    verified: AtomicUsize,
}

impl Counted {
    pub fn of(of: Box<dyn Auditor>) -> Self {
        let [tenants, begun, chains, verified] = [const { AtomicUsize::new(0) }; 4];
        Counted { of, tenants, begun, chains, verified }
    }

    /// The part that is gone through, 0 to 1.
    pub fn part(&self) -> f64 {
        let [tenants, begun, chains, verified] =
            [&self.tenants, &self.begun, &self.chains, &self.verified].map(|count| count.load(Relaxed) as f64);
        let before = (begun - 1.0).max(0.0);
        let of_this = (verified / chains.max(1.0)).min(1.0);
        ((before + of_this) / tenants.max(1.0)).min(1.0)
    }
}

impl Auditor for Counted {
    fn tenants(&self) -> RepositoryFuture<'_, BTreeSet<Tenant>> {
        Box::pin(async move {
            let tenants = self.of.tenants().await?;
            self.tenants.store(tenants.len(), Relaxed);
            Ok(tenants)
        })
    }

    fn chains(&self, tenant: Tenant) -> RepositoryFuture<'_, BTreeSet<Uuid>> {
        Box::pin(async move {
            let chains = self.of.chains(tenant).await?;
            self.verified.store(0, Relaxed);
            self.chains.store(chains.len(), Relaxed);
            self.begun.fetch_add(1, Relaxed);
            Ok(chains)
        })
    }

    fn verify(
        &self,
        tenant: Tenant,
        chain: Chain,
        sealed: BTreeMap<u64, Sha256Digest>,
    ) -> RepositoryFuture<'_, Verdict> {
        Box::pin(async move {
            let verdict = self.of.verify(tenant, chain, sealed).await?;
            self.verified.fetch_add(1, Relaxed);
            Ok(verdict)
        })
    }

    fn whole_seals(&self, tenant: Tenant, after: u64, limit: u32) -> RepositoryFuture<'_, Vec<WholeSeal>> {
        self.of.whole_seals(tenant, after, limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::{
        RepositoryError,
        audit::{Evidence, Place, examine},
    };

    /// Two tenants, the second with as many chains as it has.
    struct Two(usize);

    fn tenant(name: &str) -> Tenant {
        Tenant::named(name).unwrap()
    }

    impl Two {
        fn tenants_now<'a>(&self) -> RepositoryFuture<'a, BTreeSet<Tenant>> {
            Box::pin(async { Ok(["one", "two"].map(tenant).into()) })
        }

        fn chains_now<'a>(&self, of: &Tenant) -> RepositoryFuture<'a, BTreeSet<Uuid>> {
            let count = if *of == tenant("two") { self.0 } else { 0 };
            Box::pin(async move { Ok((0..count).map(|n| Uuid::from_u128(n as u128)).collect()) })
        }
    }

    impl Auditor for Two {
        fn tenants(&self) -> RepositoryFuture<'_, BTreeSet<Tenant>> {
            self.tenants_now()
        }

        fn chains(&self, of: Tenant) -> RepositoryFuture<'_, BTreeSet<Uuid>> {
            self.chains_now(&of)
        }

        fn verify(&self, _: Tenant, _: Chain, _: BTreeMap<u64, Sha256Digest>) -> RepositoryFuture<'_, Verdict> {
            Box::pin(async { Ok(Verdict::Intact { entries: 1, head: None }) })
        }

        fn whole_seals(&self, _: Tenant, _: u64, _: u32) -> RepositoryFuture<'_, Vec<WholeSeal>> {
            Box::pin(async { Ok(Vec::new()) })
        }
    }

    /// One chain of the second tenant cannot be read.
    struct Unreadable;

    impl Auditor for Unreadable {
        fn tenants(&self) -> RepositoryFuture<'_, BTreeSet<Tenant>> {
            Two(3).tenants_now()
        }

        fn chains(&self, of: Tenant) -> RepositoryFuture<'_, BTreeSet<Uuid>> {
            Two(3).chains_now(&of)
        }

        fn verify(&self, _: Tenant, chain: Chain, _: BTreeMap<u64, Sha256Digest>) -> RepositoryFuture<'_, Verdict> {
            Box::pin(async move {
                match chain {
                    Chain::Job(job) if job == Uuid::from_u128(1) => Err(RepositoryError::Failed("no number".into())),
                    _ => Ok(Verdict::Intact { entries: 1, head: None }),
                }
            })
        }

        fn whole_seals(&self, _: Tenant, _: u64, _: u32) -> RepositoryFuture<'_, Vec<WholeSeal>> {
            Box::pin(async { Ok(Vec::new()) })
        }
    }

    #[tokio::test]
    async fn what_cannot_be_read_hides_nothing_of_the_rest() {
        let found = examine(&Unreadable, None, &Evidence::default()).await.unwrap().unwrap();
        let place = Place::Chain(Chain::Job(Uuid::from_u128(1)));
        assert_eq!(found.unreadable, [(tenant("two"), place, "no number".to_owned())]);
        assert_eq!((found.chains, found.entries, found.is_intact()), (5, 4, false));
    }

    #[tokio::test]
    async fn chains_count_one_by_one() {
        let audit = Counted::of(Box::new(Two(4)));
        assert_eq!(audit.part(), 0.0);
        audit.tenants().await.unwrap();
        audit.chains(tenant("one")).await.unwrap();
        assert_eq!(audit.part(), 0.0);
        for (verified, part) in [(1, 0.625), (2, 0.75), (3, 0.875), (4, 1.0), (5, 1.0)] {
            if verified == 1 {
                audit.chains(tenant("two")).await.unwrap();
                assert_eq!(audit.part(), 0.5);
            }
            audit.verify(tenant("two"), Chain::Tenant, BTreeMap::new()).await.unwrap();
            assert_eq!(audit.part(), part);
        }
        // the same is found as without counting
        let counted = Counted::of(Box::new(Two(4)));
        let found = examine(&counted, None, &Evidence::default()).await.unwrap();
        assert_eq!(found, examine(&Two(4), None, &Evidence::default()).await.unwrap());
        assert_eq!(counted.part(), 1.0);
    }
}
