//! The list of jobs, and how many there are.

use jiff::Timestamp;
use sqlx::PgPool;
use uuid::Uuid;

use super::{locate::signed, open::snapshot, time::stamp};
use crate::{
    jobs::{Caller, JobCounts, JobFilter, JobPage, JobPlace, JobStatus, MOST_MACHINES},
    store::shared::{
        DayRow, GetJobCounts, ListJobs, ListedJobRow, MachineRow, MachinesRow, Outcome, Read, StatusRow, counts,
        job_columns,
    },
};

/// What is searched; where a process of the version before has written the job, in the lower case
/// that the database knows, and without the tags.
macro_rules! searched {
    () => {
        "coalesce(folded, lower(concat(name, E'\\n', part_number, E'\\n', serial_number, E'\\n', machine, E'\\n')))"
    };
}

/// What jobs are sorted by where it is by name: the first line of what is searched.
macro_rules! sort_name {
    () => {
        concat!("split_part(", searched!(), ", E'\\n', 1) COLLATE \"C\"")
    };
}

/// Reads a page of jobs behind a place ($2 and the id $3) in an order. What is told of their last
/// iterations is read of the jobs of the page alone.
macro_rules! page_of_jobs {
    ($behind:expr, $order:expr) => {
        concat!(
            "WITH page AS MATERIALIZED (
                 SELECT id FROM jobs WHERE tenant = $1 AND ",
            $behind,
            "    AND ($4::text IS NULL OR status = $4) AND ($5::text IS NULL OR machine = $5)
                 AND ($6::text IS NULL OR part_number = $6) AND ($12::bigint IS NULL OR class = $12)
                 AND ($7::timestamptz IS NULL OR changed_at >= $7) AND ($8::timestamptz IS NULL OR changed_at < $8)
                 AND ($9::text IS NULL OR strpos(",
            searched!(),
            ", $9) > 0)
                 AND ($10::text IS NULL OR EXISTS (
                     SELECT FROM json_each_text(tags::json) AS tag
                     WHERE tag.key = $10 OR tag.key || ':' || tag.value = $10))
                 ORDER BY ",
            $order,
            "    LIMIT $11
             )
             SELECT ",
            job_columns!(),
            ", status, iteration_count, changed_at, class, last_measured_at, flank, left_rank, right_rank, decision, rms,
                 condition,
                 flank_figures, ",
            sort_name!(),
            " AS sort_name
             FROM page JOIN jobs USING (id)
             LEFT JOIN LATERAL (
                 SELECT coalesce(measured_at, created_at) AS last_measured_at, flank FROM measured
                 WHERE job = jobs.id AND number = iteration_count
             ) AS last ON true
             LEFT JOIN LATERAL (
                 SELECT min(rank) FILTER (WHERE f.flank = 'left') AS left_rank,
                        min(rank) FILTER (WHERE f.flank = 'right') AS right_rank
                 FROM flanks f WHERE f.job = jobs.id
             ) AS ranks ON true
             LEFT JOIN LATERAL (
                 SELECT decision FROM decisions WHERE job = jobs.id AND number = iteration_count
                 ORDER BY position DESC LIMIT 1
             ) AS decided ON true
             LEFT JOIN LATERAL (
                 SELECT f.rms, f.condition, f.flank_figures
                 FROM fit_choices c JOIN fits f ON f.job = c.job AND f.number = c.number AND f.position = c.fit
                 WHERE c.job = jobs.id AND c.number = iteration_count ORDER BY c.position DESC LIMIT 1
             ) AS chosen ON true
             ORDER BY ",
            $order
        )
    };
}

/// A page in the order of a place.
fn page_in_order_of(place: &JobPlace) -> &'static str {
    match place {
        JobPlace::Changed(_) => {
            page_of_jobs!("(changed_at, id) < ($2::timestamptz, $3)", "changed_at DESC, id DESC")
        }
        JobPlace::Name(_) => {
            page_of_jobs!(concat!("(", sort_name!(), ", id) > ($2::text, $3)"), concat!(sort_name!(), ", id"))
        }
        // the first value is not asked for
        JobPlace::Created(_) => page_of_jobs!("id < $3 AND $2 = ''", "id DESC"),
    }
}

impl Read<PgPool> for ListJobs {
    /// One row more than asked for tells whether there is a next page.
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<JobPage> {
        let JobFilter { text, status, machine, part_number, class, tag, from: since, to } = &self.query.filter;
        let (first, last) = (Uuid::nil(), Uuid::max());
        let query = sqlx::query_as(page_in_order_of(&self.query.from)).bind(caller.tenant.as_str());
        // before the first job without a place
        let query = match &self.query.from {
            JobPlace::Changed(place) => {
                let (at, id) = place.unwrap_or((Timestamp::MAX, last));
                query.bind(stamp(at)).bind(id)
            }
            JobPlace::Name(place) => {
                let (name, id) = place.clone().unwrap_or((String::new(), first));
                query.bind(name).bind(id)
            }
            JobPlace::Created(id) => query.bind("").bind(id.unwrap_or(last)),
        };
        let rows: Vec<ListedJobRow> = query
            .bind(status.map(JobStatus::name))
            .bind(machine.as_deref())
            .bind(part_number.as_deref())
            .bind(since.map(stamp))
            .bind(to.map(stamp))
            .bind(text.as_deref())
            .bind(tag.as_deref())
            .bind(i64::from(self.query.limit) + 1)
            .bind(class.map(i64::from))
            .fetch_all(from)
            .await?;
        Ok(JobPage::of(rows.into_iter().map(Into::into).collect(), &self.query))
    }
}

impl Read<PgPool> for GetJobCounts {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<JobCounts> {
        let mut db = snapshot(from).await?;
        let tenant = caller.tenant.as_str();
        let statuses: Vec<StatusRow> =
            sqlx::query_as("SELECT status, count(*) AS jobs FROM jobs WHERE tenant = $1 GROUP BY status")
                .bind(tenant)
                .fetch_all(&mut *db)
                .await?;
        let machines: Vec<MachineRow> = sqlx::query_as(
            "SELECT machine, count(*) AS jobs FROM jobs WHERE tenant = $1 AND machine IS NOT NULL
             GROUP BY machine ORDER BY jobs DESC, machine COLLATE \"C\" LIMIT $2",
        )
        .bind(tenant)
        .bind(signed(MOST_MACHINES.into()))
        .fetch_all(&mut *db)
        .await?;
        let all: MachinesRow = sqlx::query_as(
            "SELECT count(DISTINCT machine) AS machines, count(machine) AS jobs FROM jobs WHERE tenant = $1",
        )
        .bind(tenant)
        .fetch_one(&mut *db)
        .await?;
        let days: Vec<DayRow> = sqlx::query_as(
            "SELECT to_char(changed_at AT TIME ZONE 'UTC', 'YYYY-MM-DD') AS day, count(*) AS jobs FROM jobs
             WHERE tenant = $1 AND changed_at >= $2 GROUP BY day ORDER BY day",
        )
        .bind(tenant)
        .bind(stamp(self.from))
        .fetch_all(&mut *db)
        .await?;
        counts(statuses, machines, &all, days)
    }
}
