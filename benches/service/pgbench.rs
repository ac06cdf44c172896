//! Iterations a second that the store keeps in PostgreSQL, compared with pgbench, which inserts the
//! same rows in groups as large on as many connections:
//!
//!     cargo run --release -p service-benches --example pgbench -- postgres://OWNER@HOST/EMPTY
//!
//! Programs needed in the path: `psql` and `pgbench`. The database is filled with what is measured.

use std::{
    env, fs,
    process::Command,
    sync::Arc,
    time::{Duration, Instant},
};

use flankfit::{
    app::App,
    config::{Authentication, ServeSettings},
    jobs::{
        Caller, Clock, Computed, Ids, Job, JobStatus, Measurand, MeasurementDetails, NewFit, NewIteration, OrderedIds,
        PageRequest, Repository, Store, SystemClock, Tenant, Upkeep,
    },
    store::{PostgresSettings, open_postgres},
};
use load::post;
use serde_json::{Value, json};
use tokio::{
    runtime::Runtime,
    task::{JoinSet, block_in_place},
};

/// Requests under way at a time, over so many jobs.
const REQUESTS: usize = 64;
const JOBS: usize = 16;
/// Connections that write, of ours and of pgbench.
const WRITERS: usize = 4;
const ROUNDS: u32 = 5;
const ROUND: Duration = Duration::from_secs(4);

fn main() {
    let url = env::args().nth(1).expect("the URL of a database");
    let runtime = Runtime::new().expect("threads can be made");
    runtime.block_on(compare(&url));
}

async fn compare(url: &str) {
    let sample = posted(url).await;
    let mut settings = PostgresSettings::of_url(url).expect("a URL of PostgreSQL");
    settings.writers = WRITERS;
    let ids = Arc::new(OrderedIds::new());
    let store = open_postgres(settings, ids.clone(), Arc::new(SystemClock)).await.expect("the store opens");
    let repository = store.of(&caller());
    let work = Arc::new(Work { template: template(&repository, &sample).await, ids, repository });
    let script = env::temp_dir().join(format!("flankfit-{}.sql", std::process::id()));
    fs::write(&script, statements(url, &sample)).expect("the script is written");
    let mut ratios = Vec::new();
    for round in 1..=ROUNDS {
        let before: f64 = number(&psql(url, "SELECT count(DISTINCT changed_by) FROM audit"));
        let (count, seconds) = ours(&work).await;
        let commits = number(&psql(url, "SELECT count(DISTINCT changed_by) FROM audit")) - before;
        let group = (count / commits).round();
        let theirs = group * pgbench(url, script.to_str().expect("text"), group, round);
        let rate = count / seconds;
        ratios.push(rate / theirs);
        println!("{rate:.0} iterations/s in groups of {group}; pgbench {theirs:.0}/s; ratio {:.2}", rate / theirs);
    }
    ratios.sort_by(f64::total_cmp);
    println!("median of the ratios {:.2}", ratios[ratios.len() / 2]);
    let _gone = fs::remove_file(script);
    store.close().await;
}

fn caller() -> Caller {
    Caller { tenant: Tenant::default(), actor: "bench".into(), origin: Default::default() }
}

/// Stores an iteration of 45 nodes with 16 coefficients at a server and returns the job's id.
async fn posted(url: &str) -> String {
    let settings = ServeSettings {
        bind: ([127, 0, 0, 1], 0).into(),
        database_url: url.to_owned(),
        auth: Authentication::Off,
        ..ServeSettings::default()
    };
    let app = App::start(settings).await.expect("the server starts");
    let address = app.address().expect("it has an address");
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let served = tokio::spawn(app.serve(async {
        let _ = stopped.await;
    }));
    let ask = |path: &str, body: Value| -> Value {
        let (status, answer) = block_in_place(|| load::once(address, &post(path, &body.to_string())));
        assert_eq!(status, 201, "{}", String::from_utf8_lossy(&answer));
        serde_json::from_slice(&answer).expect("JSON")
    };
    let job = ask("/v1/jobs", json!({"name": "sample"}))["id"].as_str().expect("an id").to_owned();
    let u: Vec<f64> = (0..9).map(|i| 30.0 + 0.5 * f64::from(i)).collect();
    let v: Vec<f64> = (0..5).map(|j| 5.0 * f64::from(j)).collect();
    let height = |u: &f64, v: &f64| 0.01 * u - 0.002 * v + 1e-3 * (3.0 * u + v).sin();
    let z: Vec<Vec<f64>> = u.iter().map(|u| v.iter().map(|v| height(u, v)).collect()).collect();
    let nodes = json!({"type": "grid", "u": u, "v": v, "z": z});
    let body = json!({"nodes": nodes, "model": {"type": "polynomial", "degree": [3, 3]}, "instrument": "P40"});
    ask(&format!("/v1/jobs/{job}/iterations"), body);
    let _ = stop.send(());
    let _ = served.await;
    job
}

/// The sample, to be stored again and again.
async fn template(repository: &Arc<dyn Repository>, job: &str) -> NewIteration {
    let job_id = job.parse().expect("an id");
    let stored = repository.iteration(job_id, 1).await.expect("it is stored");
    let nodes = repository.nodes(job_id, 1).await.expect("it is stored");
    let whole = PageRequest { limit: 10, after: None };
    let listed = repository.fits(job_id, 1, whole).await.expect("it is stored").items.remove(0);
    let fit = repository.fit(job_id, 1, listed.id).await.expect("it is stored");
    let computed = Computed { spec: fit.spec, result: fit.result.into(), figures: listed.figures, flank: fit.flank };
    NewIteration {
        id: stored.id,
        job_id,
        measurand: Measurand::default(),
        details: MeasurementDetails { instrument: Some("P40".to_owned()), ..stored.details },
        created_at: stored.created_at,
        nodes: Arc::new(nodes).into(),
        fit: NewFit { id: fit.id, computed, event: fit.event },
        records: Vec::new(),
        expected_gear: None,
    }
}

struct Work {
    template: NewIteration,
    ids: Arc<OrderedIds>,
    repository: Arc<dyn Repository>,
}

/// Number of stored iterations, and the seconds they took.
async fn ours(work: &Arc<Work>) -> (f64, f64) {
    let now = SystemClock.now();
    let mut jobs = Vec::new();
    for _ in 0..JOBS {
        let id = work.ids.fresh(now);
        let (tags, gear, requirements) = Default::default();
        let (part_number, serial_number, machine) = Default::default();
        let job = Job {
            id,
            name: "bench".into(),
            part_number,
            serial_number,
            machine,
            gear,
            requirements,
            tags,
            status: JobStatus::New,
            version: 1,
            created_at: now,
            updated_at: now,
            purged_at: None,
        };
        work.repository.insert_job(job, None).await.expect("the job is stored");
        jobs.push(id);
    }
    let begun = Instant::now();
    let mut writers = JoinSet::new();
    for writer in 0..REQUESTS {
        let (work, job_id) = (work.clone(), jobs[writer % JOBS]);
        writers.spawn(async move {
            let mut stored = 0_u32;
            while begun.elapsed() < ROUND {
                let now = SystemClock.now();
                let mut fit = NewFit { id: work.ids.fresh(now), ..work.template.fit.clone() };
                fit.event.created_at = now;
                let id = work.ids.fresh(now);
                let iteration = NewIteration { id, job_id, fit, created_at: now, ..work.template.clone() };
                work.repository.insert_iteration(Arc::new(iteration), None).await.expect("it is stored");
                stored += 1;
            }
            stored
        });
    }
    let stored: u32 = writers.join_all().await.into_iter().sum();
    (f64::from(stored), begun.elapsed().as_secs_f64())
}

/// A transaction of pgbench: the rows of a group of samples, in a job of its client's own.
fn statements(url: &str, sample: &str) -> String {
    let text = |column: &str, table: &str| {
        psql(url, &format!("SELECT quote_nullable({column}) FROM {table} WHERE job = '{sample}' AND number = 1"))
    };
    let job = "(lpad(:round::text, 8, '0') || '-0000-7000-8000-' || lpad(:client_id::text, 12, '0'))::uuid";
    let rows = "FROM generate_series(1, :group::bigint) AS i";
    let fit = [
        "lambda_star",
        "criterion",
        "scheme",
        "count",
        "condition",
        "regularized_condition",
        "bias_norm",
        "bias_sharp_bound",
        "rms",
        "max_abs",
        "spec",
        "result",
        "coefficients",
        "prior",
    ];
    let values: Vec<String> = fit.iter().map(|column| text(column, "fits")).collect();
    format!(
        "BEGIN;
         INSERT INTO jobs (id, tenant, name, tags, version, created_at, updated_at, folded)
             VALUES ({job}, 'default', 'pgbench', '{{}}', 1, now(), now(), 'pgbench') ON CONFLICT DO NOTHING;
         SELECT id FROM jobs WHERE id = {job} FOR NO KEY UPDATE;
         UPDATE jobs SET iteration_count = :last::bigint + :group::bigint, status = 'open',
                         changed_at = greatest(changed_at, now()) WHERE id = {job};
         INSERT INTO iterations (job, number, id, instrument, created_at)
             SELECT {job}, :last::bigint + i, gen_random_uuid(), 'P40', now() {rows};
         INSERT INTO nodes (job, number, count, data)
             SELECT {job}, :last::bigint + i, {}, {}::bytea {rows};
         INSERT INTO fits (job, number, position, id, created_at, {})
             SELECT {job}, :last::bigint + i, 1, gen_random_uuid(), now(), {} {rows};
         INSERT INTO fit_choices (job, number, position, fit, created_at)
             SELECT {job}, :last::bigint + i, 1, 1, now() {rows};
         INSERT INTO audit (id, tenant, job, at, actor, action, subject, request_id, peer, contents, salt, who)
             SELECT gen_random_uuid(), tenant, {job}, now(), actor, action, subject, request_id, peer, contents, salt,
                    who
             FROM (SELECT * FROM audit WHERE job = '{sample}' AND action = 'iteration.add' LIMIT 1) AS sample
                  CROSS JOIN generate_series(1, :group::bigint) AS i;
         COMMIT;
         \\set last :last + :group\n",
        text("count", "nodes"),
        text("data", "nodes"),
        fit.join(", "),
        values.iter().zip(fit).map(|(value, column)| typed(value, column)).collect::<Vec<_>>().join(", "),
    )
}

fn typed(value: &str, column: &str) -> String {
    match column {
        "criterion" | "scheme" => value.to_owned(),
        "spec" | "result" | "coefficients" | "prior" => format!("{value}::bytea"),
        "count" => format!("{value}::bigint"),
        _ => format!("{value}::float8"),
    }
}

/// Transactions a second.
fn pgbench(url: &str, script: &str, group: f64, round: u32) -> f64 {
    let (group, round, writers) = (format!("group={group}"), format!("round={round}"), WRITERS.to_string());
    let seconds = ROUND.as_secs().to_string();
    let arguments = ["-n", "-M", "prepared", "-j", "2", "-c", &writers, "-T", &seconds, "-f", script, "-D", "last=0"];
    let told = said(Command::new("pgbench").args(arguments).args(["-D", &group, "-D", &round, url]));
    let rate = told.lines().find_map(|line| line.strip_prefix("tps = ")).expect("a rate");
    number(rate.split(' ').next().unwrap_or_default())
}

fn psql(url: &str, sql: &str) -> String {
    said(Command::new("psql").args(["-X", "-A", "-t", "-c", sql, url]))
}

fn said(command: &mut Command) -> String {
    let output = command.output().expect("the programs of PostgreSQL are in the path");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).trim_end().to_owned()
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or_else(|_| panic!("{text} is a number"))
}
