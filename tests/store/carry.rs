//! Jobs from one database to another and back, by the command line: nothing of them is lost on the
//! way, and what is stored is guarded there as it was here.

use std::{
    fs,
    io::Write as _,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::Arc,
};

use flankfit::jobs::{
    Choice, Clock as _, Decision, DecisionEvent, Event, FinishedStream, Precondition, RecordKind, Repository,
    SystemClock,
    audit::Contents,
    rows::{ENTRIES, OF_JOBS, to_hex},
};
use jiff::SignedDuration;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use sqlx::{AssertSqlSafe, Connection as _, PgConnection};
use uuid::Uuid;

use crate::{
    server::Server,
    support::{Opened, Place, actor, caller, purge_of},
};

/// Runs the program with this input: its success, and its output.
fn flankfit(arguments: &[&str], input: &[u8]) -> (bool, String, String) {
    let mut run = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(arguments)
        .env_clear()
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // one that refuses at once does not read it
    let _left = run.stdin.take().unwrap().write_all(input);
    let run = run.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (run.status.success(), text(run.stdout), text(run.stderr))
}

fn done(arguments: &[&str], input: &[u8]) -> String {
    let (done, printed, errors) = flankfit(arguments, input);
    assert!(done, "{arguments:?}: {errors}");
    printed
}

fn url(file: &Path) -> String {
    format!("sqlite://{}", file.display())
}

fn exported(url: &str) -> String {
    done(&["export", "--database-url", url], &[])
}

fn imported(url: &str, text: &str) -> String {
    done(&["import", "--database-url", url], text.as_bytes())
}

/// Message that refuses a text, and the jobs that are stored all the same.
fn refusal(url: &str, text: &str) -> (String, String) {
    let (done, printed, errors) = flankfit(&["import", "--database-url", url], text.as_bytes());
    assert!(!done, "{printed}");
    (printed, errors)
}

fn stored(new: usize, there: usize) -> String {
    format!("{new} jobs stored, {there} existed already\n")
}

fn verified(url: &str) {
    let said = done(&["audit", "verify", "--database-url", url], &[]);
    assert!(said.starts_with("intact: "), "{said}");
}

/// Stores something in every table.
async fn fill(place: &Place, opened: &Opened) -> Uuid {
    let store: &Arc<dyn Repository> = &opened.repository;
    let mut job = place.job("gear \"\u{1f600}\"\n\u{1}");
    job.tags.insert("é".to_owned(), "\\".to_owned());
    store.insert_job(job.clone(), None).await.unwrap();
    let job = job.id;
    let (first, _) = place.stored_iteration(store, job).await;
    let mut second = place.fit(5e-324);
    second.event.reason = Some("again".to_owned());
    // stored compressed, and in parts once more
    let long = " ".repeat(70_000);
    second.computed.result = format!("{{\"coefficients\":[],{long}\"prior\":{{\"of\":1}}}}").into();
    store.insert_fit(job, 1, Arc::new(second.clone()), None).await.unwrap();
    let event = || Event { reason: Some("so".to_owned()), by: actor(), created_at: place.now() };
    for fit_id in [second.id, first.fit.id] {
        store.choose(job, 1, Choice { fit_id, event: event() }, Precondition::None).await.unwrap();
    }
    for decision in [Decision::Remachine, Decision::Accepted] {
        let decision = DecisionEvent { decision, concession: false, event: event() };
        store.decide(job, 1, decision, Precondition::None).await.unwrap();
    }
    // the evaluation that was made last is not of the last iteration
    place.stored_iteration(store, job).await;
    for (number, class) in [(2, 7), (1, 5)] {
        let mut evaluation = (*place.record(RecordKind::Evaluation, "iso")).clone();
        evaluation.draft.class = Some(class);
        store.insert_record(job, number, Arc::new(evaluation), None).await.unwrap();
    }
    let streams = [0; 3].map(|_| Arc::new(place.stream(job)));
    for stream in &streams {
        store.insert_stream(stream.clone(), None).await.unwrap();
        for sequence in 1..=2 {
            store.insert_block(place.block(stream.id, sequence), None).await.unwrap();
        }
    }
    let finished = FinishedStream { stream: streams[0].id, sequence: 2, iteration: place.iteration(job) };
    store.finish_stream(finished, None).await.unwrap();
    store.delete_stream(streams[1].id, Precondition::None, place.now()).await.unwrap();

    let purged = place.stored_job(store).await.id;
    place.stored_iteration(store, purged).await;
    store.insert_stream(Arc::new(place.stream(purged)), None).await.unwrap();
    store.purge_job(purge_of(place, purged), None).await.unwrap();

    let other = opened.store.of(&caller("other"));
    let gone = place.stored_job(&other).await.id;
    other.delete_job(gone, Precondition::None).await.unwrap();
    let kept = place.stored_job(&other).await.id;
    place.stored_iteration(&other, kept).await;
    job
}

async fn filled() -> (Place, Uuid) {
    let place = Place::new();
    let opened = place.open().await;
    let job = fill(&place, &opened).await;
    opened.close().await;
    (place, job)
}

/// This is how a file of SQLite goes to PostgreSQL.
#[tokio::test]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn jobs_go_to_postgresql_and_back_and_are_the_same() {
    let (place, job) = filled().await;
    let first = exported(&url(&place.file()));
    for table in OF_JOBS.iter().chain([ENTRIES]) {
        assert!(first.contains(&format!("\n{{\"{}\":", table.name)), "there is no {} in it", table.name);
    }
    let there = Server::shared().database().await;
    assert_eq!(imported(&there, &first), stored(4, 0));
    assert_eq!(exported(&there), first);
    let back = place.path("back.db");
    assert_eq!(imported(&url(&back), &exported(&there)), stored(4, 0));
    assert!(!PathBuf::from(format!("{}-wal", back.display())).exists(), "all is in one file");
    assert_eq!(exported(&url(&back)), first);
    // what is there already is left
    assert_eq!(imported(&there, &first), stored(0, 4));
    for database in [&url(&place.file()), &there, &url(&back)] {
        verified(database);
    }
    // nothing of it can be changed, and later events follow as usual
    let mut own = PgConnection::connect(&there).await.unwrap();
    for table in ["iterations", "nodes", "fits", "fit_choices", "decisions", "records", "events", "audit"] {
        let refusal = sqlx::query(AssertSqlSafe(format!("DELETE FROM {table}"))).execute(&mut own).await.unwrap_err();
        assert!(refusal.to_string().contains("append-only"), "{table}: {refusal}");
    }
    let off = "SELECT count(*) FROM pg_trigger WHERE NOT tgisinternal AND tgenabled <> 'O'";
    assert_eq!(sqlx::query_scalar::<_, i64>(off).fetch_one(&mut own).await.unwrap(), 0);
    own.close().await.unwrap();
    goes_on(&place, &back, job).await;
}

/// Servers write while an import waits for its input.
#[tokio::test]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn an_import_locks_nothing_while_it_reads() {
    let (place, _) = filled().await;
    let text = exported(&url(&place.file()));
    let there = Server::shared().database().await;
    let mut run = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(["import", "--database-url", &there])
        .env_clear()
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = run.stdin.take().unwrap();
    let (first, rest) = text.split_at(text.find("\n{\"end\":").unwrap());
    input.write_all(first.as_bytes()).unwrap();
    // time in which it would lock the tables
    tokio::time::sleep(std::time::Duration::from_secs(1)).await;
    let mut own = PgConnection::connect(&there).await.unwrap();
    let write = "BEGIN; SET LOCAL lock_timeout = '1ms'; LOCK TABLE iterations, events IN ROW EXCLUSIVE MODE; COMMIT";
    sqlx::raw_sql(write).execute(&mut own).await.unwrap();
    own.close().await.unwrap();
    input.write_all(rest.as_bytes()).unwrap();
    drop(input);
    assert!(run.wait().unwrap().success());
    verified(&there);
}

/// A job that was stored anew takes its next iteration, fit and event.
async fn goes_on(place: &Place, database: &Path, job: Uuid) {
    let opened = place.open_with(flankfit::store::StoreSettings::of_file(database)).await;
    let before = opened.last_event(job).await.unwrap();
    let (_, stored) = place.stored_iteration(&opened.repository, job).await;
    assert_eq!(stored.number, 4);
    opened.insert_fit(job, 1, Arc::new(place.fit(0.5)), None).await.unwrap();
    assert_eq!(opened.last_event(job).await.unwrap(), before + 2);
    opened.close().await;
    verified(&url(database));
}

#[tokio::test]
async fn one_job_is_exported_alone_and_no_file_is_overwritten() {
    let (place, job) = filled().await;
    let (here, id) = (url(&place.file()), job.to_string());
    let file = place.path("one");
    let name = file.to_str().unwrap();
    let export = ["export", "--job", &id, name, "--database-url", &here];
    assert_eq!(done(&export, &[]), format!("1 jobs written to {name}\n"));
    let text = fs::read_to_string(&file).unwrap();
    assert_eq!(text.matches("{\"job\":").count(), 1);
    assert!(text.ends_with("{\"archive\":{\"jobs\":1}}\n"));
    let (_, _, again) = flankfit(&export, &[]);
    assert!(again.contains("exists already"), "{again}");
    let nobody = Uuid::nil().to_string();
    let (done_it, _, missing) = flankfit(&["export", "--job", &nobody, "--database-url", &here], &[]);
    assert!(!done_it && missing.contains("there is no job"), "{missing}");
    let to = place.path("new.db");
    assert_eq!(done(&["import", name, "--database-url", &url(&to)], &[]), stored(1, 0));
    assert_eq!(exported(&url(&to)), text);
    goes_on(&place, &to, job).await;
}

#[tokio::test]
async fn truncated_or_altered_jobs_are_not_stored() {
    let (place, job) = filled().await;
    let whole = exported(&url(&place.file()));
    let lines: Vec<&str> = whole.split_inclusive('\n').collect();
    let to = url(&place.path("new.db"));
    // cut off within a line, and behind one; the jobs before that are stored
    for cut in [whole.len() - 1, lines[..lines.len() - 1].concat().len()] {
        let (_, errors) = refusal(&to, &whole[..cut]);
        assert!(errors.contains("cut off"), "{errors}");
    }
    assert_eq!(imported(&to, &whole), stored(0, 4));
    // one job alone is refused, with its line
    let to = url(&place.path("another.db"));
    let (printed, errors) = refusal(&to, &whole.replacen("first; cut", "third; cut", 1));
    assert_eq!(printed, stored(3, 0));
    assert!(errors.contains(&format!("job {job}: the job has changed since it was written")), "{errors}");
    let (_, errors) = refusal(&to, "{\"other\":1}\n");
    assert!(errors.contains("line 1: it does not begin a job"), "{errors}");
    // one that exists and differs
    assert_eq!(imported(&to, &whole), stored(1, 3));
    let opened = place.open_with(flankfit::store::StoreSettings::of_file(place.path("another.db"))).await;
    place.stored_iteration(&opened.repository, job).await;
    opened.close().await;
    let before = exported(&to);
    let (_, errors) = refusal(&to, &whole);
    assert!(errors.contains(&format!("job {job} exists and differs")), "{errors}");
    assert_eq!(exported(&to), before);
}

/// The same archive with changed rows, and digests and entries that agree with them, as a forger
/// makes it.
fn doctored(whole: &str, change: impl Fn(&str, &mut Value)) -> String {
    let (mut text, mut section) = (String::new(), String::new());
    for line in whole.lines() {
        let mut row: Value = serde_json::from_str(line).unwrap();
        let (name, columns) = row.as_object_mut().unwrap().iter_mut().next().unwrap();
        match name.as_str() {
            "end" => {
                columns["sha256"] = to_hex(&Sha256::digest(&section)).into();
                columns["rows"] = (section.lines().count() - 1).into();
                text += &format!("{section}{row}\n");
                section.clear();
            }
            "archive" => text += &format!("{row}\n"),
            name => {
                change(name, columns);
                if !columns.is_null() {
                    section += &format!("{row}\n");
                }
            }
        }
    }
    text
}

/// An archive with correct digests is also refused if a value cannot be read, with its place.
#[tokio::test]
async fn unreadable_values_are_not_stored() {
    let (place, job) = filled().await;
    let whole = exported(&url(&place.file()));
    let unfit = "{\"teeth\":2147483648,\"normal_module_mm\":1.0}";
    for (table, column, value) in [
        ("iterations", "axes", json!("}{")),
        ("jobs", "gear", json!(unfit)),
        ("jobs", "tags", json!("[]")),
        ("jobs", "requirements", json!("{")),
        ("jobs", "created_at", json!("yesterday")),
        ("fits", "result", json!("[")),
        ("fits", "spec", json!("{}")),
        ("fits", "coefficients", json!("[1]")),
        ("fits", "criterion", json!("mine")),
        ("records", "request", json!("\u{0}")),
        ("nodes", "data", json!("01")),
        ("nodes", "count", json!(5)),
        ("stream_blocks", "data", json!("01")),
        ("stream_blocks", "sequence", json!(1_u64 << 62)),
        ("stream_states", "data", json!("01")),
        ("streams", "sequence", json!(-1)),
        ("streams", "spec", json!("1")),
        ("audit", "contents", json!("01")),
    ] {
        let bad = doctored(&whole, |name, columns| {
            if name == table && columns.get("spec").is_none_or(|spec| spec != "") {
                columns[column] = value.clone();
            }
        });
        let (printed, errors) = refusal(&url(&place.path(&format!("{table}-{column}.db"))), &bad);
        let line = 1 + bad.lines().position(|line| line.starts_with(&format!("{{\"{table}\":"))).unwrap();
        assert!(errors.contains(&format!("`{column}`")) || errors.contains("`coefficients` is not"), "{errors}");
        assert!(errors.contains(&format!("line {line}, job ")) || table == "jobs", "{table} {column} {line}: {errors}");
        assert!(errors.contains(&job.to_string()), "{errors}");
        assert!(!printed.starts_with("4 jobs stored"), "{printed}");
    }
}

/// An archive whose decision was turned, with or without its entries.
#[tokio::test]
async fn archives_that_contradict_their_audit_are_not_stored() {
    let (place, job) = filled().await;
    let whole = exported(&url(&place.file()));
    let turn = |name: &str, columns: &mut Value| {
        if name == "decisions" && columns["position"] == 2 {
            columns["decision"] = json!("rejected");
        }
    };
    for (text, why) in [
        (doctored(&whole, turn), "decisions/1/2 is changed"),
        (
            doctored(&whole, |name, columns| {
                turn(name, columns);
                if name == "audit" {
                    *columns = Value::Null;
                }
            }),
            "is unaudited",
        ),
        (
            doctored(&whole, |name, columns| {
                if name == "audit" {
                    columns["contents"] = to_hex(Contents::default().bytes()).into();
                }
            }),
            "is unaudited",
        ),
    ] {
        let to = url(&place.path(&format!("{}.db", text.len())));
        let (_, errors) = refusal(&to, &text);
        assert!(errors.contains(&job.to_string()) && errors.contains(why), "{errors}");
        verified(&to);
    }
}

/// Whatever a command wants of it.
#[tokio::test]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_database_without_a_schema_is_refused_with_advice() {
    let server = Server::shared();
    let empty = server.url(&server.copy_of("template1").await);
    let none = b"{\"job\":{\"tenant\":\"default\",\"job\":\"0190b0de-0000-7000-8000-000000000000\"}}\n";
    for arguments in [&["export"][..], &["import"], &["audit", "verify"], &["purge", "--older-than", "1"]] {
        let (done, _, errors) = flankfit(&[arguments, &["--database-url", &empty]].concat(), none);
        assert!(!done && errors.contains("run `flankfit migrate`"), "{arguments:?}: {errors}");
        // PostgreSQL's own sources are nobody's business
        assert!(!errors.contains(" at line ") && errors.trim_end().lines().count() == 1, "{errors}");
    }
}

/// A timer purges what nobody has touched for long, while a server has the database open.
#[tokio::test]
async fn old_jobs_are_purged_while_a_server_runs() {
    let place = Place::new();
    let opened = place.open().await;
    let recent = |days: i64| SystemClock.now() - SignedDuration::from_hours(24 * days);
    let mut jobs = Vec::new();
    for days in [400, 20] {
        let mut job = place.job("wheel");
        (job.created_at, job.updated_at) = (recent(days), recent(days));
        opened.insert_job(job.clone(), None).await.unwrap();
        jobs.push(job.id);
    }
    let here = url(&place.file());
    let purge = ["purge", "--older-than", "365", "--database-url", &here];
    assert_eq!(done(&purge, &[]), "1 jobs purged\n");
    assert_eq!(done(&purge, &[]), "0 jobs purged\n");
    assert!(opened.job(jobs[0]).await.unwrap().purged_at.is_some());
    assert!(opened.job(jobs[1]).await.unwrap().purged_at.is_none());
    // the server goes on
    place.stored_iteration(&opened.repository, jobs[1]).await;
    opened.close().await;
    verified(&here);
    let (done, _, errors) = flankfit(&["purge", "--older-than", "0", "--database-url", &here], &[]);
    assert!(!done && errors.contains("whole number from 1"), "{errors}");
    let (done, _, errors) = flankfit(&["purge", "--older-than", "1", "--database-url", "sqlite:///nowhere.db"], &[]);
    assert!(!done && errors.contains("there is no database at"), "{errors}");
}
