//! The list of jobs, and how many there are.

use jiff::Timestamp;
use sqlx::{QueryBuilder, Sqlite, SqliteConnection, SqlitePool};
use uuid::Uuid;

use super::time;
use crate::{
    jobs::{Caller, JobCounts, JobFilter, JobPage, JobPlace, JobQuery, MOST_MACHINES},
    store::shared::{
        DayRow, FEW, GetJobCounts, ListJobs, ListedJobRow, MachineRow, MachinesRow, Outcome, Parts, Read, StatusRow,
        counts, job_columns,
    },
};

/// Appends the query for the jobs that have parts of a text.
fn push_found(sql: &mut QueryBuilder<Sqlite>, parts: &Parts) {
    match parts {
        Parts::Whole(parts) => {
            let quoted: Vec<String> = parts.iter().map(|part| format!("\"{}\"", part.replace('"', "\"\""))).collect();
            sql.push("SELECT rowid AS seq FROM jobs_text WHERE jobs_text MATCH ").push_bind(quoted.join(" AND "));
        }
        Parts::Short(part) => {
            sql.push("SELECT doc AS seq FROM jobs_text_terms WHERE term >= ").push_bind(part.clone());
            sql.push(" AND term < ").push_bind(format!("{part}{}", char::MAX));
        }
    }
}

/// Returns whether few jobs have parts of a text.
async fn are_few(db: &mut SqliteConnection, parts: &Parts) -> Result<bool, sqlx::Error> {
    let mut sql = QueryBuilder::new("SELECT count(*) FROM (");
    push_found(&mut sql, parts);
    sql.push(" LIMIT ").push_bind(FEW + 1).push(")");
    Ok(sql.build_query_scalar::<i64>().fetch_one(db).await? <= FEW)
}

/// Restricts jobs to those after the start of the page, and returns their order.
fn push_place(sql: &mut QueryBuilder<Sqlite>, place: &JobPlace) -> &'static str {
    match place {
        JobPlace::Changed(place) => {
            let (at, id) = place.unwrap_or((Timestamp::MAX, Uuid::max()));
            sql.push(" AND (changed_at, id) < (").push_bind(time::to_text(at)).push(", ").push_bind(id).push(")");
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
fn page(begin: &str, caller: &Caller, query: &JobQuery, few: Option<&Parts>) -> QueryBuilder<Sqlite> {
    let JobFilter { text, status, machine, part_number, class, tag, from, to } = &query.filter;
    let mut sql = QueryBuilder::new(begin);
    sql.push("WITH page AS MATERIALIZED (SELECT seq FROM ");
    if let Some(parts) = few {
        sql.push("(SELECT DISTINCT seq FROM (");
        push_found(&mut sql, parts);
        sql.push(")) AS found CROSS JOIN jobs USING (seq)");
    } else {
        sql.push("jobs");
    }
    sql.push(" WHERE tenant = ").push_bind(caller.tenant.as_str().to_owned());
    let equal = [
        (" AND status = ", status.map(|status| status.name().to_owned())),
        (" AND machine = ", machine.clone()),
        (" AND part_number = ", part_number.clone()),
        (" AND changed_at >= ", from.map(time::to_text)),
        (" AND changed_at < ", to.map(time::to_text)),
    ];
    for (condition, value) in equal {
        if let Some(value) = value {
            sql.push(condition).push_bind(value);
        }
    }
    if let Some(class) = class {
        sql.push(" AND class = ").push_bind(*class);
    }
    if let Some(text) = text {
        sql.push(" AND instr(folded, ").push_bind(text.clone()).push(") > 0");
    }
    if let Some(tag) = tag {
        sql.push(" AND EXISTS (SELECT 1 FROM json_each(tags) AS tag WHERE ").push_bind(tag.clone());
        sql.push(" IN (tag.key, tag.key || ':' || tag.value))");
    }
    let order = push_place(&mut sql, &query.from);
    sql.push(order).push(" LIMIT ").push_bind(i64::from(query.limit) + 1);
    sql.push(concat!(
        "), listed AS (
             SELECT jobs.*, (SELECT i.seq FROM iterations i WHERE i.job = jobs.seq AND i.number = iteration_count)
                 AS last
             FROM page CROSS JOIN jobs USING (seq)
         )
         SELECT ",
        job_columns!(),
        ", status, iteration_count, changed_at, class, sort_name,
             (SELECT coalesce(i.measured_at, i.created_at) FROM iterations i WHERE i.seq = last) AS last_measured_at,
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
         FROM listed",
    ));
    sql.push(order);
    sql
}

impl Read<SqlitePool> for ListJobs {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<JobPage> {
        let mut db = from.acquire().await?;
        let few = match Parts::of(&self.query.filter) {
            Some(parts) if are_few(&mut db, &parts).await? => Some(parts),
            _ => None,
        };
        let mut sql = page("", caller, &self.query, few.as_ref());
        let rows: Vec<ListedJobRow> = sql.build_query_as().fetch_all(&mut *db).await?;
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
            "SELECT count(DISTINCT machine) AS machines, count(*) AS jobs FROM jobs
             WHERE tenant = ? AND machine IS NOT NULL",
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

#[cfg(test)]
mod tests {
    use sqlx::Row as _;

    use super::*;
    use crate::{
        jobs::{JobSort, JobStatus, Tenant, folded},
        store::sqlite::StoreSettings,
    };

    /// No list of jobs scans all jobs of a tenant.
    #[tokio::test]
    async fn each_filter_and_each_order_goes_by_an_index() {
        let folder = tempfile::tempdir().unwrap();
        let mut db = StoreSettings::of_file(folder.path().join("jobs.db")).open_writer().await.unwrap();
        let caller = Caller { tenant: Tenant::root(), actor: "test".into(), origin: Default::default() };
        let none = JobFilter::default;
        let text = |text: &str| JobFilter { text: Some(folded(text)), ..none() };
        let cases = [
            (none(), JobSort::Changed, "INDEX jobs_by_change (tenant=?"),
            (none(), JobSort::Name, "INDEX jobs_by_name (tenant=?"),
            (none(), JobSort::Created, "INDEX jobs_of_tenant (tenant=?"),
            (
                JobFilter { machine: Some("M".into()), ..none() },
                JobSort::Changed,
                "jobs_by_machine (tenant=? AND machine=?",
            ),
            (
                JobFilter { part_number: Some("P".into()), ..none() },
                JobSort::Changed,
                "jobs_by_part (tenant=? AND part_number=?",
            ),
            (JobFilter { class: Some(5), ..none() }, JobSort::Changed, "jobs_by_class (tenant=? AND class=?"),
            (
                JobFilter { status: Some(JobStatus::New), ..none() },
                JobSort::Changed,
                "jobs_by_status (tenant=? AND status=?",
            ),
            (text("zzzz"), JobSort::Changed, "jobs_text VIRTUAL TABLE INDEX"),
            (text("zz"), JobSort::Name, "jobs_text_terms VIRTUAL TABLE INDEX"),
            (JobFilter { tag: Some("shift:day".into()), ..none() }, JobSort::Created, "jobs_text VIRTUAL TABLE INDEX"),
        ];
        for (filter, sort, expected) in cases {
            let query = JobQuery { filter, limit: 50, from: JobPlace::beginning(sort) };
            let parts = Parts::of(&query.filter);
            let mut sql = page("EXPLAIN QUERY PLAN ", &caller, &query, parts.as_ref());
            let plan = sql.build().fetch_all(&mut db).await.unwrap();
            let steps: Vec<String> = plan.iter().map(|row| row.get::<String, _>("detail")).collect();
            // up to the page; after it only the jobs of the page are read
            let until = steps.iter().position(|step| step.contains("MATERIALIZE page")).unwrap();
            let page: Vec<&String> = steps[until..].iter().take_while(|step| *step != "SCAN page").collect();
            assert!(page.iter().any(|step| step.contains(expected)), "{query:?}: {steps:#?}");
            assert!(!page.iter().any(|step| *step == "SCAN jobs" || step.starts_with("SCAN jobs USING")), "{steps:#?}");
            let sorts = page.iter().any(|step| step.contains("TEMP B-TREE FOR ORDER BY"));
            assert_eq!(sorts, parts.is_some(), "{query:?}: {steps:#?}");
        }
    }
}
