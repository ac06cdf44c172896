//! Mappings of tables, kept to be proposed again.

use super::prelude::*;

pub async fn mapping(db: &mut Db, caller: &Caller, key: &[u8; 32]) -> Outcome<Option<String>> {
    let sql = "SELECT mapping FROM table_mappings WHERE tenant = $1 AND key = $2";
    Ok(db.first(sql, args![&caller.tenant, key]).await?)
}

pub async fn keep_mapping(tx: &mut Tx<'_>, write: &KeepMapping) -> Outcome<()> {
    let (KeepMapping { kept: KeptMapping { key, mapping }, now }, tenant) = (write, tx.tenant());
    let db = tx.db();
    db.run(
        "INSERT INTO table_mappings (tenant, key, mapping, kept_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (tenant, key) DO UPDATE SET mapping = excluded.mapping, kept_at = excluded.kept_at",
        args![tenant, key, mapping, *now],
    )
    .await?;
    db.run(
        "DELETE FROM table_mappings WHERE tenant = $1 AND key NOT IN
         (SELECT key FROM table_mappings WHERE tenant = $1 ORDER BY kept_at DESC, key LIMIT $2)",
        args![tenant, MOST_MAPPINGS],
    )
    .await?;
    Ok(())
}
