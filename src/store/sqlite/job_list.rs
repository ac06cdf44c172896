//! The list of jobs, and how many there are.

use jiff::Timestamp;
use sqlx::SqlitePool;
use uuid::Uuid;

use super::time;
use crate::{
    jobs::{Caller, JobCounts, JobFilter, JobPage, JobPlace, JobStatus, MOST_MACHINES},
    store::shared::{
        DayRow, GetJobCounts, ListJobs, ListedJobRow, MachineRow, MachinesRow, Outcome, Read, StatusRow, counts,
        job_columns,
    },
};

/// What jobs are sorted by where it is by name: the first line of what is searched. (A job that was
/// imported has that text from the next opening on.)
macro_rules! sort_name {
    () => {
        "substr(coalesce(folded, lower(name) || char(10)), 1,
                instr(coalesce(folded, lower(name) || char(10)), char(10)) - 1)"
    };
}

/// Reads a page of jobs behind a place (?2 and the id ?3) in an order. What is told of their last
/// iterations is read of the jobs of the page alone.
macro_rules! page_of_jobs {
    ($behind:expr, $order:expr) => {
        concat!(
            "WITH page AS MATERIALIZED (
                 SELECT seq FROM jobs WHERE tenant = ?1 AND ",
            $behind,
            "    AND (?4 IS NULL OR status = ?4) AND (?5 IS NULL OR machine = ?5)
                 AND (?6 IS NULL OR part_number = ?6) AND (?12 IS NULL OR class = ?12)
                 AND (?7 IS NULL OR changed_at >= ?7) AND (?8 IS NULL OR changed_at < ?8)
                 AND (?9 IS NULL OR instr(coalesce(folded, lower(name)), ?9) > 0)
                 AND (?10 IS NULL OR EXISTS (
                     SELECT 1 FROM json_each(tags) AS tag WHERE tag.key = ?10 OR tag.key || ':' || tag.value = ?10))
                 ORDER BY ",
            $order,
            "    LIMIT ?11
             ), listed AS (
                 SELECT jobs.*, (SELECT i.seq FROM iterations i WHERE i.job = jobs.seq AND i.number = iteration_count)
                     AS last
                 FROM page CROSS JOIN jobs USING (seq)
             )
             SELECT ",
            job_columns!(),
            ", status, iteration_count, changed_at, class, ",
            sort_name!(),
            " AS sort_name,
                 (SELECT coalesce(i.measured_at, i.created_at) FROM iterations i WHERE i.seq = last)
                     AS last_measured_at,
                 (SELECT i.flank FROM measured i WHERE i.seq = last) AS flank,
                 (SELECT min(f.rank) FROM flanks f WHERE f.job = listed.seq AND f.flank = 'left') AS left_rank,
                 (SELECT min(f.rank) FROM flanks f WHERE f.job = listed.seq AND f.flank = 'right') AS right_rank,
                 (SELECT d.decision FROM decisions d WHERE d.iteration = last ORDER BY d.position DESC LIMIT 1)
                     AS decision,
                 (SELECT f.rms FROM fit_choices c JOIN fits f ON f.seq = c.fit WHERE c.iteration = last
                  ORDER BY c.position DESC LIMIT 1) AS rms,
                 (SELECT f.condition FROM fit_choices c JOIN fits f ON f.seq = c.fit WHERE c.iteration = last
                  ORDER BY c.position DESC LIMIT 1) AS condition,
                 (SELECT f.flank_figures FROM fit_choices c JOIN fits f ON f.seq = c.fit WHERE c.iteration = last
                  ORDER BY c.position DESC LIMIT 1) AS flank_figures
             FROM listed ORDER BY ",
            $order
        )
    };
}

/// A page in the order of a place, with the place's values of the statement; without any before the
/// first job.
fn page_at(place: &JobPlace) -> (&'static str, String, Vec<u8>) {
    let (first, last) = (Uuid::nil(), Uuid::max());
    let (sql, key, id) = match place {
        JobPlace::Changed(place) => {
            let (at, id) = place.unwrap_or((Timestamp::MAX, last));
            (page_of_jobs!("(changed_at, id) < (?2, ?3)", "changed_at DESC, id DESC"), time::to_text(at), id)
        }
        JobPlace::Name(place) => {
            let (name, id) = place.clone().unwrap_or((String::new(), first));
            let sql = page_of_jobs!(concat!("(", sort_name!(), ", id) > (?2, ?3)"), concat!(sort_name!(), ", id"));
            (sql, name, id)
        }
        // the first value is not asked for
        JobPlace::Created(id) => (page_of_jobs!("id < ?3 AND ?2 = ''", "id DESC"), String::new(), id.unwrap_or(last)),
    };
    (sql, key, id.as_bytes().to_vec())
}

impl Read<SqlitePool> for ListJobs {
    /// One row more than asked for tells whether there is a next page.
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<JobPage> {
        let JobFilter { text, status, machine, part_number, class, tag, from: since, to } = &self.query.filter;
        let (sql, key, id) = page_at(&self.query.from);
        let rows: Vec<ListedJobRow> = sqlx::query_as(sql)
            .bind(caller.tenant.as_str())
            .bind(key)
            .bind(id)
            .bind(status.map(JobStatus::name))
            .bind(machine.as_deref())
            .bind(part_number.as_deref())
            .bind(since.map(time::to_text))
            .bind(to.map(time::to_text))
            .bind(text.as_deref())
            .bind(tag.as_deref())
            .bind(i64::from(self.query.limit) + 1)
            .bind(*class)
            .fetch_all(from)
            .await?;
        Ok(JobPage::of(rows.into_iter().map(Into::into).collect(), &self.query))
    }
}

impl Read<SqlitePool> for GetJobCounts {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<JobCounts> {
        let mut db = from.begin().await?;
        let tenant = caller.tenant.as_str();
        let statuses: Vec<StatusRow> =
            sqlx::query_as("SELECT status, count(*) AS jobs FROM jobs WHERE tenant = ? GROUP BY status")
                .bind(tenant)
                .fetch_all(&mut *db)
                .await?;
        let machines: Vec<MachineRow> = sqlx::query_as(
            "SELECT machine, count(*) AS jobs FROM jobs WHERE tenant = ? AND machine IS NOT NULL
             GROUP BY machine ORDER BY jobs DESC, machine LIMIT ?",
        )
        .bind(tenant)
        .bind(MOST_MACHINES)
        .fetch_all(&mut *db)
        .await?;
        let all: MachinesRow = sqlx::query_as(
            "SELECT count(DISTINCT machine) AS machines, count(machine) AS jobs FROM jobs WHERE tenant = ?",
        )
        .bind(tenant)
        .fetch_one(&mut *db)
        .await?;
        let days: Vec<DayRow> = sqlx::query_as(
            "SELECT substr(changed_at, 1, 10) AS day, count(*) AS jobs FROM jobs WHERE tenant = ? AND changed_at >= ?
             GROUP BY day ORDER BY day",
        )
        .bind(tenant)
        .bind(time::to_text(self.from))
        .fetch_all(&mut *db)
        .await?;
        counts(statuses, machines, &all, days)
    }
}
