//! The text by which jobs are searched, of jobs that have none: those from before it was kept, and
//! those that a process of the version before has written.

use sqlx::PgConnection;

use super::locate::signed;
use crate::{
    jobs::Job,
    store::shared::{JobRow, job_columns},
};

/// Jobs that are read at a time.
const AT_A_TIME: i64 = 1000;

pub async fn complete(db: &mut PgConnection) -> Result<(), sqlx::Error> {
    loop {
        let jobs: Vec<JobRow> =
            sqlx::query_as(concat!("SELECT ", job_columns!(), " FROM jobs WHERE folded IS NULL LIMIT $1"))
                .bind(AT_A_TIME)
                .fetch_all(&mut *db)
                .await?;
        if jobs.is_empty() {
            return Ok(());
        }
        for job in jobs.into_iter().map(Job::from) {
            // one that somebody changes meanwhile is read again
            sqlx::query("UPDATE jobs SET folded = $1 WHERE id = $2 AND version = $3 AND folded IS NULL")
                .bind(job.searched())
                .bind(job.id)
                .bind(signed(job.version))
                .execute(&mut *db)
                .await?;
        }
    }
}
