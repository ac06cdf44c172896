//! The audit of all tenants, read from outside.

use std::collections::{BTreeMap, BTreeSet};

use sqlx::SqlitePool;
use uuid::Uuid;

use super::{
    audit_reads,
    error::{OpenError, failure},
    locate::signed,
    open::StoreSettings,
};
use crate::{
    jobs::{
        RepositoryError, RepositoryFuture, Tenant,
        audit::{Auditor, Chain, Seal, Sha256Digest, Verdict, WholeSeal},
    },
    store::shared::{Outcome, SealRow, SealedHeadRow, StoreError, seal_columns},
};

/// Reads the audit of a database.
pub struct SqliteAuditor(pub(super) SqlitePool);

impl SqliteAuditor {
    /// Opens an existing database that a server may have open; nothing is written.
    pub async fn open(settings: &StoreSettings) -> Result<Self, OpenError> {
        settings.must_exist()?;
        Ok(SqliteAuditor(settings.open_aside().await?))
    }

    async fn read_tenants(&self) -> Outcome<BTreeSet<Tenant>> {
        let names: Vec<Tenant> = sqlx::query_scalar(
            "SELECT name FROM tenants UNION SELECT tenant FROM jobs UNION SELECT tenant FROM api_keys
             UNION SELECT tenant FROM audit UNION SELECT tenant FROM audit_seals",
        )
        .fetch_all(&self.0)
        .await?;
        Ok(names.into_iter().collect())
    }

    async fn read_chains(&self, tenant: &Tenant) -> Outcome<BTreeSet<Uuid>> {
        let chains: Vec<Uuid> = sqlx::query_scalar(
            "SELECT id FROM jobs WHERE tenant = ?1 UNION SELECT chain FROM audit WHERE tenant = ?1
             UNION SELECT chain FROM audit_sealed WHERE tenant = ?1",
        )
        .bind(tenant.as_str())
        .fetch_all(&self.0)
        .await?;
        Ok(chains.into_iter().collect())
    }

    async fn verified(&self, tenant: &Tenant, chain: Chain, sealed: BTreeMap<u64, Sha256Digest>) -> Outcome<Verdict> {
        let mut db = self.0.begin().await?;
        audit_reads::verify(&mut db, tenant, chain, sealed).await
    }

    async fn read_seals(&self, tenant: &Tenant, after: u64, limit: u32) -> Outcome<Vec<WholeSeal>> {
        let mut db = self.0.begin().await?;
        let rows: Vec<SealRow> = sqlx::query_as(concat!(
            "SELECT ",
            seal_columns!(),
            " FROM audit_seals WHERE tenant = ? AND number > ? ORDER BY number LIMIT ?"
        ))
        .bind(tenant.as_str())
        .bind(signed(after))
        .bind(i64::from(limit))
        .fetch_all(&mut *db)
        .await?;
        let mut seals = Vec::with_capacity(rows.len());
        for row in rows {
            let seal = Seal::from(row);
            let heads: Vec<SealedHeadRow> = sqlx::query_as(
                "SELECT chain, number, sha256 FROM audit_sealed WHERE tenant = ? AND seal = ? ORDER BY chain",
            )
            .bind(tenant.as_str())
            .bind(signed(seal.number))
            .fetch_all(&mut *db)
            .await?;
            seals.push(WholeSeal { seal, heads: heads.into_iter().map(Into::into).collect() });
        }
        Ok(seals)
    }
}

/// What could not be read.
fn told(error: StoreError) -> RepositoryError {
    match error {
        StoreError::Refused(error) => error,
        StoreError::Broken(error) => failure(&error),
    }
}

impl Auditor for SqliteAuditor {
    fn tenants(&self) -> RepositoryFuture<'_, BTreeSet<Tenant>> {
        Box::pin(async move { self.read_tenants().await.map_err(told) })
    }

    fn chains(&self, tenant: Tenant) -> RepositoryFuture<'_, BTreeSet<Uuid>> {
        Box::pin(async move { self.read_chains(&tenant).await.map_err(told) })
    }

    fn verify(
        &self,
        tenant: Tenant,
        chain: Chain,
        sealed: BTreeMap<u64, Sha256Digest>,
    ) -> RepositoryFuture<'_, Verdict> {
        Box::pin(async move { self.verified(&tenant, chain, sealed).await.map_err(told) })
    }

    fn whole_seals(&self, tenant: Tenant, after: u64, limit: u32) -> RepositoryFuture<'_, Vec<WholeSeal>> {
        Box::pin(async move { self.read_seals(&tenant, after, limit).await.map_err(told) })
    }
}
