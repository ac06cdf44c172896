//! The audit of all tenants, read from outside.

use std::collections::{BTreeMap, BTreeSet};

use uuid::Uuid;

use super::{
    audit_reads,
    db::Pool,
    error::{Outcome, reported},
    row::{SealRow, seal_columns},
};
use crate::jobs::{
    RepositoryFuture, Tenant,
    audit::{Auditor, Chain, Seal, Sha256Digest, Verdict, WholeSeal},
};

/// Reads the audit of a database.
pub struct SqlAuditor(pub(in crate::store) Pool);

impl SqlAuditor {
    async fn read_tenants(&self) -> Outcome<BTreeSet<Tenant>> {
        let sql = "SELECT name FROM tenants UNION SELECT tenant FROM jobs UNION SELECT tenant FROM api_keys
                   UNION SELECT tenant FROM audit UNION SELECT tenant FROM audit_seals";
        Ok(self.0.connection().await?.values(sql, args![]).await?.into_iter().collect())
    }

    async fn read_chains(&self, tenant: &Tenant) -> Outcome<BTreeSet<Uuid>> {
        let sql = "SELECT id FROM jobs WHERE tenant = $1 UNION SELECT chain FROM audit WHERE tenant = $1
                   UNION SELECT chain FROM audit_sealed WHERE tenant = $1";
        Ok(self.0.connection().await?.values(sql, args![tenant]).await?.into_iter().collect())
    }

    async fn verified(&self, tenant: &Tenant, chain: Chain, sealed: BTreeMap<u64, Sha256Digest>) -> Outcome<Verdict> {
        let mut db = self.0.snapshot().await?;
        audit_reads::verify(&mut db, tenant, chain, sealed).await
    }

    async fn read_seals(&self, tenant: &Tenant, after: u64, limit: u32) -> Outcome<Vec<WholeSeal>> {
        let mut db = self.0.snapshot().await?;
        let sql = concat!(
            "SELECT ",
            seal_columns!(),
            " FROM audit_seals WHERE tenant = $1 AND number > $2 ORDER BY number LIMIT $3"
        );
        let rows: Vec<SealRow> = db.all(sql, args![tenant, after, limit]).await?;
        let mut seals = Vec::with_capacity(rows.len());
        for seal in rows.into_iter().map(Seal::from) {
            let sql = "SELECT chain, number, sha256 FROM audit_sealed WHERE tenant = $1 AND seal = $2 ORDER BY chain";
            let heads = db.all(sql, args![tenant, seal.number]).await?;
            seals.push(WholeSeal { seal, heads });
        }
        Ok(seals)
    }
}

impl Auditor for SqlAuditor {
    fn tenants(&self) -> RepositoryFuture<'_, BTreeSet<Tenant>> {
        Box::pin(async move { self.read_tenants().await.map_err(reported) })
    }

    fn chains(&self, tenant: Tenant) -> RepositoryFuture<'_, BTreeSet<Uuid>> {
        Box::pin(async move { self.read_chains(&tenant).await.map_err(reported) })
    }

    fn verify(
        &self,
        tenant: Tenant,
        chain: Chain,
        sealed: BTreeMap<u64, Sha256Digest>,
    ) -> RepositoryFuture<'_, Verdict> {
        Box::pin(async move { self.verified(&tenant, chain, sealed).await.map_err(reported) })
    }

    fn whole_seals(&self, tenant: Tenant, after: u64, limit: u32) -> RepositoryFuture<'_, Vec<WholeSeal>> {
        Box::pin(async move { self.read_seals(&tenant, after, limit).await.map_err(reported) })
    }
}
