//! The text by which jobs are searched, of jobs that have none: those from before it was kept.

use sqlx::SqliteConnection;

use super::locate::WithSeq;
use crate::{
    jobs::Job,
    store::shared::{JobRow, job_columns},
};

/// Jobs that are read at a time.
const AT_A_TIME: u32 = 1000;

pub async fn complete(db: &mut SqliteConnection) -> Result<(), sqlx::Error> {
    sqlx::raw_sql("BEGIN IMMEDIATE").execute(&mut *db).await?;
    loop {
        let jobs: Vec<WithSeq<JobRow>> = sqlx::query_as(concat!(
            "SELECT seq, ",
            job_columns!(),
            " FROM jobs INDEXED BY jobs_not_folded WHERE folded IS NULL LIMIT ?"
        ))
        .bind(AT_A_TIME)
        .fetch_all(&mut *db)
        .await?;
        if jobs.is_empty() {
            break;
        }
        for WithSeq { seq, row } in jobs {
            sqlx::query("UPDATE jobs SET folded = ? WHERE seq = ?")
                .bind(Job::from(row).searched())
                .bind(seq)
                .execute(&mut *db)
                .await?;
        }
    }
    sqlx::raw_sql("COMMIT").execute(&mut *db).await?;
    Ok(())
}
