//! The list of jobs, and how many there are.

use jiff::Timestamp;
use sqlx::{PgConnection, PgPool, Postgres, QueryBuilder};
use uuid::Uuid;

use super::{locate::signed, open::snapshot, time::stamp};
use crate::{
    jobs::{Caller, JobCounts, JobFilter, JobPage, JobPlace, JobQuery, MOST_MACHINES, Tenant},
    store::shared::{
        DayRow, FEW, GetJobCounts, ListJobs, ListedJobRow, MachineRow, MachinesRow, Outcome, Parts, Read, StatusRow,
        counts, job_columns,
    },
};

/// What is searched; where a process of the version before has written the job, in the lower case
/// that the database knows, and without the tags.
macro_rules! searched {
    () => {
        "coalesce(folded, lower(concat(name, E'\\n', part_number, E'\\n', serial_number, E'\\n', machine, E'\\n')))"
    };
}

/// Appends the query for the jobs of the tenant that have parts of a text; it finds all of them if
/// there are few.
fn push_found(sql: &mut QueryBuilder<Postgres>, tenant: &Tenant, parts: &Parts) {
    // after four line ends, as in the index
    let tenant = format!("\n\n\n\n{}", tenant.as_str());
    let all: Vec<String> = match parts {
        Parts::Whole(parts) => parts.iter().cloned().chain([tenant]).collect(),
        Parts::Short(part) => vec![part.clone(), tenant],
    };
    sql.push("SELECT id FROM jobs_with_parts(").push_bind(all).push(", ").push_bind(FEW + 1).push(") AS found (id)");
}

/// Returns whether few jobs have parts of a text.
async fn are_few(db: &mut PgConnection, tenant: &Tenant, parts: &Parts) -> Result<bool, sqlx::Error> {
    let mut sql = QueryBuilder::new("SELECT count(*) FROM (");
    push_found(&mut sql, tenant, parts);
    sql.push(") AS counted");
    Ok(sql.build_query_scalar::<i64>().fetch_one(db).await? <= FEW)
}

/// Restricts jobs to those after the start of the page, and returns their order.
fn push_place(sql: &mut QueryBuilder<Postgres>, place: &JobPlace) -> &'static str {
    match place {
        JobPlace::Changed(place) => {
            let (at, id) = place.unwrap_or((Timestamp::MAX, Uuid::max()));
            sql.push(" AND (changed_at, id) < (").push_bind(stamp(at)).push(", ").push_bind(id).push(")");
            " ORDER BY changed_at DESC, id DESC"
        }
        JobPlace::Name(place) => {
            let (name, id) = place.clone().unwrap_or((String::new(), Uuid::nil()));
            sql.push(" AND (sort_name, id) > (").push_bind(name).push(", ").push_bind(id).push(")");
            " ORDER BY sort_name, id"
        }
        JobPlace::Created(id) => {
            sql.push(" AND id < ").push_bind(id.unwrap_or(Uuid::max()));
            " ORDER BY id DESC"
        }
    }
}

/// Returns the statement of a page of jobs, with one row more than requested, which shows whether
/// there is a next page. `few` are parts that few jobs have. Last iterations are read only for the
/// jobs of the page.
fn page(begin: &str, caller: &Caller, query: &JobQuery, few: Option<&Parts>) -> QueryBuilder<Postgres> {
    let JobFilter { text, status, machine, part_number, class, tag, from, to } = &query.filter;
    let mut sql = QueryBuilder::new(begin);
    sql.push("WITH ");
    if let Some(parts) = few {
        sql.push("found AS MATERIALIZED (");
        push_found(&mut sql, &caller.tenant, parts);
        sql.push("), page AS MATERIALIZED (SELECT id FROM found JOIN jobs USING (id)");
    } else {
        sql.push("page AS MATERIALIZED (SELECT id FROM jobs");
    }
    sql.push(" WHERE tenant = ").push_bind(caller.tenant.as_str().to_owned());
    let equal = [
        (" AND status = ", status.map(|status| status.name().to_owned())),
        (" AND machine = ", machine.clone()),
        (" AND part_number = ", part_number.clone()),
    ];
    for (condition, value) in equal {
        if let Some(value) = value {
            sql.push(condition).push_bind(value);
        }
    }
    // the index contains only this prefix
    for (column, value) in [("machine", machine), ("part_number", part_number)] {
        if let Some(value) = value {
            sql.push(format!(" AND left({column}, 400) = left(")).push_bind(value.clone()).push(", 400)");
        }
    }
    if let Some(from) = from {
        sql.push(" AND changed_at >= ").push_bind(stamp(*from));
    }
    if let Some(to) = to {
        sql.push(" AND changed_at < ").push_bind(stamp(*to));
    }
    if let Some(class) = class {
        sql.push(" AND class = ").push_bind(i64::from(*class));
    }
    if let Some(text) = text {
        sql.push(concat!(" AND strpos(", searched!(), ", ")).push_bind(text.clone()).push(") > 0");
    }
    if let Some(tag) = tag {
        sql.push(" AND EXISTS (SELECT FROM json_each_text(tags::json) AS tag WHERE ").push_bind(tag.clone());
        sql.push(" IN (tag.key, tag.key || ':' || tag.value))");
    }
    let order = push_place(&mut sql, &query.from);
    sql.push(order).push(" LIMIT ").push_bind(i64::from(query.limit) + 1);
    sql.push(concat!(
        ")
         SELECT ",
        job_columns!(),
        ", status, iteration_count, changed_at, class, last_measured_at, flank, left_rank, right_rank, decision,
             rms, condition, flank_figures, sort_name
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
         ) AS chosen ON true",
    ));
    sql.push(order);
    sql
}

impl Read<PgPool> for ListJobs {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<JobPage> {
        let mut db = from.acquire().await?;
        let few = match Parts::of(&self.query.filter) {
            Some(parts) if are_few(&mut db, &caller.tenant, &parts).await? => Some(parts),
            _ => None,
        };
        let mut sql = page("", caller, &self.query, few.as_ref());
        let rows: Vec<ListedJobRow> = sql.build_query_as().fetch_all(&mut *db).await?;
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
            "SELECT count(DISTINCT machine) AS machines, count(*) AS jobs FROM jobs
             WHERE tenant = $1 AND machine IS NOT NULL",
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
