//! The list of jobs, and how many there are.

use super::{
    db::{Record, Statement},
    prelude::*,
    search::{FEW, Parts},
};

from_row! {
    ListedJob {
        @job, iteration_count, changed_at, last_measured_at, flank, left = "left_status",
        right = "right_status", decision, rms, condition, figures = "flank_figures", class,
    }
}

row! {
    /// A job with its place in the order by name.
    pub struct NamedJob {
        @pub listed: ListedJob,
        pub sort_name: String,
    }
}

/// Appends a table `found` of the jobs that have parts of a text. PostgreSQL finds all of them if
/// there are few.
fn push_found(sql: &mut Statement<'_>, postgres: bool, tenant: &Tenant, parts: &Parts) {
    match parts {
        _ if postgres => {
            let parts = match parts {
                Parts::Whole(parts) => parts.iter().cloned().collect(),
                Parts::Short(part) => vec![part.clone()],
            };
            sql.push("(SELECT id FROM jobs_with_parts(ARRAY[");
            for part in parts {
                sql.bind(part).push(", ");
            }
            // after four line ends, as in the index
            sql.bind(format!("\n\n\n\n{}", tenant.as_str()))
                .push("], ")
                .bind(FEW + 1)
                .push(") AS parts (id)) AS found");
        }
        Parts::Whole(parts) => {
            let quoted: Vec<String> = parts.iter().map(|part| format!("\"{}\"", part.replace('"', "\"\""))).collect();
            sql.push("(SELECT rowid AS doc FROM jobs_text WHERE jobs_text MATCH ").bind(quoted.join(" AND "));
            sql.push(") AS found");
        }
        Parts::Short(part) => {
            sql.push("(SELECT DISTINCT doc FROM jobs_text_terms WHERE term >= ").bind(part.clone());
            sql.push(" AND term < ").bind(format!("{part}{}", char::MAX)).push(") AS found");
        }
    }
}

/// Returns whether few jobs have parts of a text.
async fn are_few(db: &mut Db, tenant: &Tenant, parts: &Parts) -> Result<bool, sqlx::Error> {
    let mut sql = Statement::new("SELECT count(*) FROM (SELECT 1 FROM ");
    push_found(&mut sql, db.is_postgres(), tenant, parts);
    sql.push(" LIMIT ").bind(FEW + 1).push(") AS counted");
    let counted: Vec<(i64,)> = sql.all(db).await?;
    Ok(counted.iter().all(|(count,)| *count <= FEW))
}

/// Restricts jobs to those after the start of the page, and returns their order.
fn push_place(sql: &mut Statement<'_>, place: &JobPlace) -> &'static str {
    match place {
        JobPlace::Changed(place) => {
            let (at, id) = place.unwrap_or((Timestamp::MAX, Uuid::max()));
            sql.push(" AND (changed_at, id) < (").bind(at).push(", ").bind(id).push(")");
            " ORDER BY changed_at DESC, id DESC"
        }
        JobPlace::Name(place) => {
            let (name, id) = place.clone().unwrap_or((String::new(), Uuid::nil()));
            sql.push(" AND (sort_name, id) > (").bind(name).push(", ").bind(id).push(")");
            " ORDER BY sort_name, id"
        }
        JobPlace::Created(id) => {
            sql.push(" AND id < ").bind(id.unwrap_or(Uuid::max()));
            " ORDER BY id DESC"
        }
    }
}

/// The status of the flanks of one side of a job, by the lowest rank.
macro_rules! status_of {
    ($side:literal) => {
        concat!(
            "CASE (SELECT min(f.rank) FROM flanks f WHERE f.job = listed.id AND f.flank = '",
            $side,
            "') WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' WHEN 4 THEN 'accepted' END"
        )
    };
}

/// The columns of a page. Last iterations are read only for the jobs of the page.
const LISTED: &str = concat!(
    "), listed AS (SELECT jobs.* FROM page CROSS JOIN jobs WHERE jobs.id = page.id)
     SELECT ",
    job_columns!(),
    ", iteration_count, changed_at, class, sort_name,
        (SELECT coalesce(i.measured_at, i.created_at) FROM iterations i
         WHERE i.job = listed.id AND i.number = iteration_count) AS last_measured_at,
        (SELECT i.flank FROM measured i WHERE i.job = listed.id AND i.number = iteration_count) AS flank,
        ",
    status_of!("left"),
    " AS left_status, ",
    status_of!("right"),
    " AS right_status,
        (SELECT d.decision FROM decisions d WHERE d.job = listed.id AND d.number = iteration_count
         ORDER BY d.position DESC LIMIT 1) AS decision,
        chosen.rms AS rms, chosen.condition AS condition, chosen.flank_figures AS flank_figures
     FROM listed
     LEFT JOIN (SELECT job, number, position, rms, condition, flank_figures FROM fits) AS chosen
        ON chosen.job = listed.id AND chosen.number = iteration_count AND chosen.position =
           (SELECT c.fit FROM fit_choices c WHERE c.job = listed.id AND c.number = iteration_count
            ORDER BY c.position DESC LIMIT 1)"
);

/// Returns the statement of a page of jobs, with one row more than requested, which shows whether
/// there is a next page. `few` are parts that few jobs have.
fn page(begin: &str, postgres: bool, caller: &Caller, query: &JobQuery, few: Option<&Parts>) -> Statement<'static> {
    let JobFilter { text, status, machine, part_number, class, tag, from, to } = &query.filter;
    let mut sql = Statement::new(begin);
    sql.push("WITH page AS MATERIALIZED (SELECT jobs.id FROM ");
    match few {
        Some(parts) => {
            push_found(&mut sql, postgres, &caller.tenant, parts);
            sql.push(if postgres { " JOIN jobs USING (id)" } else { " CROSS JOIN jobs USING (doc)" });
        }
        None => {
            sql.push("jobs");
        }
    }
    sql.push(" WHERE tenant = ").bind(caller.tenant.as_str().to_owned());
    let equal: [(&str, Option<Value<'_>>); 6] = [
        (" AND status = ", status.map(|status| status.name().into())),
        (" AND machine = ", machine.clone().map(Into::into)),
        (" AND part_number = ", part_number.clone().map(Into::into)),
        (" AND changed_at >= ", from.map(Into::into)),
        (" AND changed_at < ", to.map(Into::into)),
        (" AND class = ", class.map(Into::into)),
    ];
    for (condition, value) in equal {
        if let Some(value) = value {
            sql.push(condition).bind(value);
        }
    }
    // the index of PostgreSQL contains only this prefix
    for (column, value) in [("machine", machine), ("part_number", part_number)] {
        if let Some(value) = value.clone().filter(|_| postgres) {
            sql.push(&format!(" AND left({column}, 400) = left(")).bind(value).push(", 400)");
        }
    }
    if let Some(text) = text {
        sql.push(if postgres { " AND strpos(folded, " } else { " AND instr(folded, " }).bind(text.clone());
        sql.push(") > 0");
    }
    if let Some(tag) = tag {
        let each = if postgres { "json_each_text(tags::json)" } else { "json_each(tags)" };
        sql.push(" AND EXISTS (SELECT 1 FROM ").push(each).push(" AS tag WHERE ").bind(tag.clone());
        sql.push(" IN (tag.key, tag.key || ':' || tag.value))");
    }
    let order = push_place(&mut sql, &query.from);
    sql.push(order).push(" LIMIT ").bind(i64::from(query.limit) + 1);
    sql.push(LISTED).push(order);
    sql
}

pub async fn jobs(db: &mut Db, caller: &Caller, query: &JobQuery) -> Outcome<JobPage> {
    let few = match Parts::of(&query.filter) {
        Some(parts) if are_few(db, &caller.tenant, &parts).await? => Some(parts),
        _ => None,
    };
    let rows: Vec<NamedJob> = page("", db.is_postgres(), caller, query, few.as_ref()).all(db).await?;
    Ok(JobPage::of(rows.into_iter().map(|row| (row.listed, row.sort_name)).collect(), query))
}

pub async fn job_counts(db: &mut Db, caller: &Caller, from: &Timestamp) -> Outcome<JobCounts> {
    let tenant = &caller.tenant;
    let statuses =
        counts(db, "SELECT status, count(*) FROM jobs WHERE tenant = $1 GROUP BY status", args![tenant]).await?;
    let sql = "SELECT machine, count(*) AS jobs FROM jobs WHERE tenant = $1 AND machine IS NOT NULL
               GROUP BY machine ORDER BY jobs DESC, machine LIMIT $2";
    let machines = counts(db, sql, args![tenant, MOST_MACHINES]).await?;
    let sql = "SELECT count(DISTINCT machine), count(*) FROM jobs
               WHERE tenant = $1 AND machine IS NOT NULL";
    let (machine_count, with_machine) = counts(db, sql, args![tenant]).await?[0];
    let sql = db.pick(
        "SELECT substr(changed_at, 1, 10), count(*) FROM jobs WHERE tenant = $1 AND changed_at >= $2
         GROUP BY 1 ORDER BY 1",
        "SELECT to_char(changed_at AT TIME ZONE 'UTC', 'YYYY-MM-DD'), count(*) FROM jobs
         WHERE tenant = $1 AND changed_at >= $2 GROUP BY 1 ORDER BY 1",
    );
    let days = counts(db, sql, args![tenant, *from]).await?;
    Ok(JobCounts { statuses, machines, machine_count, with_machine, days })
}

/// Returns numbers of jobs, each with what these have.
async fn counts<T: Send + 'static>(db: &mut Db, sql: &'static str, args: &[Value<'_>]) -> Outcome<Vec<(T, u64)>>
where
    (Cell<T>, Cell<u64>): Record,
{
    let rows: Vec<(Cell<T>, Cell<u64>)> = db.all(sql, args).await?;
    Ok(rows.into_iter().map(|(Cell(of), Cell(jobs))| (of, jobs)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        jobs::{JobSort, JobStatus, folded},
        store::StoreSettings,
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
            let sql = page("EXPLAIN QUERY PLAN ", false, &caller, &query, parts.as_ref());
            let steps: Vec<(i64, i64, i64, String)> = sql.all(&mut db).await.unwrap();
            let steps: Vec<String> = steps.into_iter().map(|(_, _, _, step)| step).collect();
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
