//! Leases of tasks within a transaction that stores something for them.

use std::collections::HashSet;

use jiff::Timestamp;
use sqlx::PgConnection;
use uuid::Uuid;

use super::time::stamp;
use crate::jobs::Lease;

/// What a task that has ended keeps of its request: nothing that is long. Last come its bytes.
macro_rules! without_request {
    () => {
        "lease = NULL, lease_until = NULL, headers = '[]', body = '', \
         bytes = bytes - octet_length(headers) - octet_length(body)"
    };
}
pub(super) use without_request;

/// Locks the tasks of leases; answers the leases that hold until the transaction ends.
pub async fn hold(db: &mut PgConnection, leases: &[Lease]) -> Result<HashSet<Lease>, sqlx::Error> {
    if leases.is_empty() {
        return Ok(HashSet::new());
    }
    let held: Vec<(Uuid, Uuid)> = sqlx::query_as(
        "SELECT id, lease FROM operations WHERE id = ANY($1) AND state = 'running' AND lease IS NOT NULL
         ORDER BY id FOR NO KEY UPDATE",
    )
    .bind(leases.iter().map(|lease| lease.task).collect::<Vec<_>>())
    .fetch_all(db)
    .await?;
    Ok(held.into_iter().map(|(task, id)| Lease { task, id }).filter(|lease| leases.contains(lease)).collect())
}

/// Ends the tasks whose answers are kept under their keys.
pub async fn end_kept(db: &mut PgConnection, ended: &[(Lease, u16, Timestamp)]) -> Result<(), sqlx::Error> {
    for (lease, status, now) in ended {
        sqlx::query(concat!(
            "UPDATE operations SET state = 'succeeded', status = $3, ended_at = $4, progress = 1, ",
            without_request!(),
            " WHERE id = $1 AND lease = $2 AND state = 'running'"
        ))
        .bind(lease.task)
        .bind(lease.id)
        .bind(i64::from(*status))
        .bind(stamp(*now))
        .execute(&mut *db)
        .await?;
    }
    Ok(())
}
