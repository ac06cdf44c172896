//! Leases of tasks within a transaction that stores something for them.

use std::collections::HashSet;

use jiff::Timestamp;
use uuid::Uuid;

use super::db::Db;
use crate::jobs::Lease;

/// Takes away what is long from the request of a task that has ended. Last come its bytes.
macro_rules! without_request {
    () => {
        "lease = NULL, lease_until = NULL, headers = '[]', body = coalesce(substr(body, 1, 0), body), \
         bytes = bytes - octet_length(headers) - length(body)"
    };
}
pub(super) use without_request;

/// Locks the tasks of leases; returns the leases that hold until the transaction ends.
pub async fn hold(db: &mut Db, leases: &[Lease]) -> Result<HashSet<Lease>, sqlx::Error> {
    let sql = format!(
        "SELECT id, lease FROM operations WHERE id IN ({{ids}}) AND state = 'running' AND lease IS NOT NULL
         ORDER BY id{}",
        db.locked()
    );
    let held: Vec<(Uuid, Uuid)> = db.of_ids(&sql, leases.iter().map(|lease| lease.task)).await?;
    Ok(held.into_iter().map(|(task, id)| Lease { task, id }).filter(|lease| leases.contains(lease)).collect())
}

/// Ends the tasks whose answers are kept under their keys.
pub async fn end_kept(db: &mut Db, ended: &[(Lease, u16, Timestamp)]) -> Result<(), sqlx::Error> {
    for (lease, status, now) in ended {
        let sql = concat!(
            "UPDATE operations SET state = 'succeeded', status = $3, ended_at = $4, progress = 1, ",
            without_request!(),
            " WHERE id = $1 AND lease = $2 AND state = 'running'"
        );
        db.run(sql, args![lease.task, lease.id, *status, *now]).await?;
    }
    Ok(())
}
