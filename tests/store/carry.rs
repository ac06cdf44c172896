//! Jobs from one database to another and back, by the command line: nothing of them is lost on the
//! way, and what is stored is guarded there as it was here.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    process::Command,
    sync::Arc,
};

use flankfit::jobs::{
    Choice, Decision, DecisionEvent, Event, FinishedStream, NewTask, Precondition, RecordKind, Repository, Scope,
    Scopes,
    archive::{ArchiveReader, ArchiveWriter, Listed, Row, Section, TABLES, Value},
};
use sqlx::{AssertSqlSafe, Connection as _, PgConnection};
use uuid::Uuid;

use crate::{
    server::Server,
    support::{Opened, Place, actor, archived, caller, purge_of},
};

/// The program, told to do something: whether it did, and what it printed.
fn flankfit(arguments: &[&str]) -> (bool, String) {
    let run = Command::new(env!("CARGO_BIN_EXE_flankfit")).args(arguments).env_clear().output().unwrap();
    let printed = [run.stdout, run.stderr].concat();
    (run.status.success(), String::from_utf8(printed).unwrap())
}

fn done(arguments: &[&str]) -> String {
    let (done, printed) = flankfit(arguments);
    assert!(done, "{arguments:?}: {printed}");
    printed
}

fn refused(arguments: &[&str]) -> String {
    let (done, printed) = flankfit(arguments);
    assert!(!done, "{arguments:?}: {printed}");
    printed
}

fn url(file: &Path) -> String {
    format!("sqlite://{}", file.display())
}

/// What an export of a database has in it, compressed.
fn exported(place: &Place, name: &str, url: &str) -> (PathBuf, Vec<u8>) {
    let file = place.beside(name);
    done(&["export", file.to_str().unwrap(), "--database-url", url]);
    let bytes = fs::read(&file).unwrap();
    (file, bytes)
}

fn task(place: &Place, job: Uuid) -> Arc<NewTask> {
    Arc::new(NewTask {
        id: place.id(),
        scope: Scope::Measure,
        scopes: Scopes::of(&[Scope::Measure]),
        request: "/there".to_owned(),
        job: Some(job),
        key: "k".to_owned(),
        key_scope: "POST /there".to_owned(),
        request_sha256: [9; 32],
        headers: "[]".to_owned(),
        body: vec![0],
        created_at: place.now(),
    })
}

/// Stores something in every table.
async fn fill(place: &Place, opened: &Opened) -> Uuid {
    let store: &Arc<dyn Repository> = &opened.repository;
    let mut job = place.job("gear \"\u{1f600}\"\n\u{1}");
    job.tags.insert("é".to_owned(), "\\".to_owned());
    let job = {
        store.insert_job(job.clone(), None).await.unwrap();
        job.id
    };
    let (first, _) = place.stored_iteration(store, job).await;
    let mut second = place.fit(5e-324);
    // kept compressed, where the store does that
    second.computed.spec = Arc::from(format!("{{\"long\":\"{}\"}}", "é".repeat(20_000)));
    second.event.reason = Some("again".to_owned());
    store.insert_fit(job, 1, Arc::new(second.clone()), None).await.unwrap();
    let event = || Event { reason: Some("so".to_owned()), by: actor(), created_at: place.now() };
    for fit_id in [second.id, first.fit.id] {
        store.choose(job, 1, Choice { fit_id, event: event() }, Precondition::None).await.unwrap();
    }
    for decision in [Decision::Remachine, Decision::Accept] {
        store
            .decide(job, 1, DecisionEvent { decision, concession: false, event: event() }, Precondition::None)
            .await
            .unwrap();
    }
    place.stored_record(store, job).await;
    store.insert_record(job, 1, place.record(RecordKind::Surface, "gregory"), None).await.unwrap();
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
    store.insert_task(task(place, job), 1 << 20).await.unwrap();

    let purged = place.stored_job(store).await.id;
    place.stored_iteration(store, purged).await;
    store.insert_stream(Arc::new(place.stream(purged)), None).await.unwrap();
    let (_, told) = archived(&opened.store, "default", purged).await;
    store.purge_job(purge_of(place, purged, &told), None).await.unwrap();

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

/// What an export says, as text.
fn text(bytes: &[u8]) -> String {
    String::from_utf8(zstd::decode_all(bytes).unwrap()).unwrap()
}

#[tokio::test]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn jobs_go_to_postgresql_and_back_and_are_the_same() {
    let (place, job) = filled().await;
    let here = url(&place.file());
    let (file, first) = exported(&place, "first", &here);
    let told = text(&first);
    for table in TABLES {
        assert!(told.contains(&format!("\n{{\"{}\":", table.name)), "there is no {} in it", table.name);
    }

    let there = Server::shared().database().await;
    assert_eq!(done(&["import", file.to_str().unwrap(), "--database-url", &there]), stored(4, 0));
    let (_, second) = exported(&place, "second", &there);
    assert_eq!(text(&second), told);
    assert_eq!(second, first);
    let back = place.beside("back.db");
    assert_eq!(done(&["copy", "--from", &there, "--to", &url(&back)]), stored(4, 0));
    let (_, third) = exported(&place, "third", &url(&back));
    assert_eq!(third, first);
    // what is there already is left
    assert_eq!(done(&["copy", "--from", &url(&back), "--to", &there]), stored(0, 4));
    assert_eq!(done(&["import", file.to_str().unwrap(), "--database-url", &url(&back)]), stored(0, 4));

    for database in [&here, &there, &url(&back)] {
        let said = done(&["audit", "verify", "--database-url", database]);
        assert!(said.starts_with("intact: "), "{said}");
    }
    // nothing of it can be changed, and what comes next is told as ever
    let mut own = PgConnection::connect(&there).await.unwrap();
    for table in ["iterations", "nodes", "fits", "fit_choices", "decisions", "records", "events", "audit"] {
        let refusal = sqlx::query(AssertSqlSafe(format!("DELETE FROM {table}"))).execute(&mut own).await.unwrap_err();
        assert!(refusal.to_string().contains("append-only"), "{table}: {refusal}");
    }
    let off: i64 = sqlx::query_scalar("SELECT count(*) FROM pg_trigger WHERE NOT tgisinternal AND tgenabled <> 'O'")
        .fetch_one(&mut own)
        .await
        .unwrap();
    assert_eq!(off, 0);
    drop(own);
    goes_on(&place, &back, job).await;
}

fn stored(new: usize, there: usize) -> String {
    format!("{new} jobs stored, {there} were there already\n")
}

/// A job that was stored anew takes its next iteration, fit and event.
async fn goes_on(place: &Place, database: &Path, job: Uuid) {
    let opened = place.open_with(flankfit::store::StoreSettings::of_file(database)).await;
    let before = opened.last_event(job).await.unwrap();
    let (_, stored) = place.stored_iteration(&opened.repository, job).await;
    assert_eq!(stored.number, 3);
    opened.insert_fit(job, 1, Arc::new(place.fit(0.5)), None).await.unwrap();
    assert_eq!(opened.last_event(job).await.unwrap(), before + 2);
    opened.close().await;
    assert!(done(&["audit", "verify", "--database-url", &url(database)]).starts_with("intact: "));
}

#[tokio::test]
async fn one_job_is_exported_alone_and_no_file_is_overwritten() {
    let (place, job) = filled().await;
    let (here, id) = (url(&place.file()), job.to_string());
    let file = place.beside("one");
    let name = file.to_str().unwrap();
    assert_eq!(done(&["export", "--job", &id, name, "--database-url", &here]), format!("1 jobs written to {name}\n"));
    assert_eq!(text(&fs::read(&file).unwrap()).matches("{\"section\"").count(), 1);
    let again = refused(&["export", name, "--database-url", &here]);
    assert!(again.contains("exists already"), "{again}");
    let nobody = Uuid::nil().to_string();
    let missing = refused(&["export", "--job", &nobody, place.beside("no").to_str().unwrap(), "--database-url", &here]);
    assert!(missing.contains("there is no job"), "{missing}");
    assert!(!place.beside("no").exists());
    let to = place.beside("new.db");
    assert_eq!(done(&["import", name, "--database-url", &url(&to)]), stored(1, 0));
    let (_, alone) = exported(&place, "alone", &url(&to));
    assert_eq!(alone, fs::read(&file).unwrap());
    goes_on(&place, &to, job).await;
}

/// Whoever takes a database elsewhere takes one file.
#[tokio::test]
async fn the_file_of_a_database_is_whole_when_its_jobs_are_said_to_be_stored() {
    let (place, _) = filled().await;
    let here = url(&place.file());
    let (file, whole) = exported(&place, "whole", &here);
    let (copied, imported) = (place.beside("copied.db"), place.beside("imported.db"));
    assert_eq!(done(&["copy", "--from", &here, "--to", &url(&copied)]), stored(4, 0));
    assert_eq!(done(&["import", file.to_str().unwrap(), "--database-url", &url(&imported)]), stored(4, 0));
    for made in [copied, imported] {
        let log = PathBuf::from(format!("{}-wal", made.display()));
        assert!(!log.exists(), "{}", log.display());
        let name = format!("{}-elsewhere", made.file_stem().unwrap().display());
        let elsewhere = place.beside(&format!("{name}.db"));
        fs::copy(&made, &elsewhere).unwrap();
        let (_, there) = exported(&place, &name, &url(&elsewhere));
        assert_eq!(there, whole);
    }
}

#[tokio::test]
async fn a_file_that_is_not_as_it_was_written_stores_nothing() {
    let (place, job) = filled().await;
    let (file, whole) = exported(&place, "whole", &url(&place.file()));
    let told = text(&whole);
    let to = place.beside("new.db");
    let refusal = |bytes: &[u8]| {
        let bad = place.beside("bad");
        fs::write(&bad, bytes).unwrap();
        refused(&["import", bad.to_str().unwrap(), "--database-url", &url(&to)])
    };
    let packed = |text: &str| zstd::encode_all(text.as_bytes(), 3).unwrap();
    for cut in [whole.len() / 2, whole.len() - 1] {
        let said = refusal(&whole[..cut]);
        assert!(said.contains("cut off") || said.contains("was changed"), "{said}");
    }
    let lines: Vec<&str> = told.split_inclusive('\n').collect();
    let said = refusal(&packed(&lines[..lines.len() - 1].concat()));
    assert!(said.contains("cut off"), "{said}");
    let fault = told.find("\"note\":\"first").unwrap();
    let line = told[..fault].matches('\n').count();
    let said = refusal(&packed(&told.replacen("first; cut", "third; cut", 1)));
    assert!(said.contains("was changed"), "{said}");
    let without = [&lines[..line], &lines[line + 1..]].concat().concat();
    assert!(refusal(&packed(&without)).contains("was changed"));
    assert!(refusal(&packed(&format!("{told}\n"))).contains("was changed"));
    assert!(refusal(b"{\"other\":1}\n").contains("no export"));
    assert!(refusal(&packed("{\"flankfit\":\"export\",\"version\":2}\n")).contains("no export"));
    assert!(!to.exists(), "nothing was stored");

    // one that is there and differs is named, and the others are not stored either
    assert_eq!(done(&["import", file.to_str().unwrap(), "--database-url", &url(&to)]), stored(4, 0));
    goes_on(&place, &to, job).await;
    let (_, before) = exported(&place, "before", &url(&to));
    let said = refused(&["import", file.to_str().unwrap(), "--database-url", &url(&to)]);
    assert!(said.contains(&format!("job {job} is there already and differs")), "{said}");
    let (_, after) = exported(&place, "after", &url(&to));
    assert_eq!(after, before);
}

/// Returns the same file with changed rows and recomputed digests.
fn doctored(whole: &[u8], change: impl Fn(&mut Row)) -> Vec<u8> {
    let mut reader = ArchiveReader::begin(whole).unwrap();
    let mut writer = ArchiveWriter::begin(Vec::new()).unwrap();
    let mut current = None;
    while let Some(part) = reader.next_part().unwrap() {
        match part {
            Listed::Section(key) => {
                let (section, first) = Section::begin(&key);
                writer.line(&first).unwrap();
                current = Some(section);
            }
            Listed::Row(mut row) => {
                change(&mut row);
                writer.line(&current.as_mut().unwrap().row(&row)).unwrap();
            }
            Listed::End(_) => writer.end(&current.take().unwrap().end()).unwrap(),
        }
    }
    writer.finish().unwrap()
}

/// A file with correct digests is also refused if a value is unreadable, with its place.
#[tokio::test]
async fn what_could_not_be_answered_later_is_not_stored() {
    let (place, _) = filled().await;
    let (_, whole) = exported(&place, "whole", &url(&place.file()));
    let to = place.beside("new.db");
    let text = |text: &str| Value::Text(text.to_owned());
    for (table, column, value) in [
        ("iteration", "axes", text("}{")),
        ("job", "gear", text(r#"{"teeth":2147483648,"normal_module_mm":1.0}"#)),
        ("job", "tags", text("[]")),
        ("job", "requirements", text("{")),
        ("fit", "result", text("[")),
        ("fit", "spec", text("1")),
        ("record", "request", text("\u{0}")),
        ("nodes", "data", Value::Bytes(vec![1])),
        ("nodes", "count", Value::Integer(5)),
        ("block", "data", Value::Bytes(vec![1])),
        ("block", "sequence", Value::Integer(1 << 62)),
        ("stream", "sequence", Value::Integer(-1)),
    ] {
        let bad = place.beside("bad");
        let change = |row: &mut Row| {
            let columns = row.table().columns;
            if row.table().name == table && !row.is_emptied() {
                row.values[columns.iter().position(|known| known.name == column).unwrap()] = value.clone();
            }
        };
        fs::write(&bad, doctored(&whole, change)).unwrap();
        let said = refused(&["import", bad.to_str().unwrap(), "--database-url", &url(&to)]);
        assert!(said.contains("line ") && said.contains(&format!("of `{table}` cannot be read")), "{said}");
        assert!(!to.exists(), "nothing was stored");
    }
    // only a purge leaves empty content
    let empty = doctored(&whole, |row| {
        if let ("block", Some(data)) = (row.table().name, row.values.get_mut(4)) {
            *data = Value::Bytes(Vec::new());
        }
    });
    let bad = place.beside("bad");
    fs::write(&bad, empty).unwrap();
    let said = refused(&["import", bad.to_str().unwrap(), "--database-url", &url(&to)]);
    assert!(said.contains("the job is not purged"), "{said}");
}

#[tokio::test]
async fn what_its_audit_contradicts_is_not_stored() {
    let (place, job) = filled().await;
    let mut own = place.connect().await;
    sqlx::raw_sql("DROP TRIGGER iterations_no_update; UPDATE iterations SET note = 'other'")
        .execute(&mut own)
        .await
        .unwrap();
    own.close().await.unwrap();
    let to = place.beside("new.db");
    let said = refused(&["copy", "--from", &url(&place.file()), "--to", &url(&to)]);
    assert!(said.contains(&job.to_string()) && said.contains("its audit is broken at entry 2: content"), "{said}");
    assert!(!place.beside("new.db-wal").exists(), "what was stored before is in the file");
    let (_, nothing) = exported(&place, "nothing", &url(&to));
    assert!(text(&nothing).contains("\"sections\":0"), "{}", text(&nothing));
}

/// Whatever a command wants of it.
#[tokio::test]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_database_without_a_schema_says_how_it_gets_one() {
    let place = Place::new();
    place.open().await.close().await;
    let server = Server::shared();
    let empty = server.url(&server.copy_of("template1").await);
    let file = place.beside("none");
    for arguments in [
        &["copy", "--from", &url(&place.file()), "--to", &empty][..],
        &["copy", "--from", &empty, "--to", &url(&place.beside("to.db"))],
        &["export", file.to_str().unwrap(), "--database-url", &empty],
        &["audit", "verify", "--database-url", &empty],
    ] {
        let said = refused(arguments);
        assert!(said.contains("does not exist") && said.contains("run `flankfit migrate`"), "{said}");
        // PostgreSQL's own sources are nobody's business
        assert!(!said.contains(" at line ") && said.trim_end().lines().count() == 1, "{said}");
    }
    assert!(!file.exists());
}

/// A column that a migration adds must be taken along.
#[tokio::test]
async fn every_column_of_a_jobs_tables_is_taken_along() {
    let place = Place::new();
    place.open().await.close().await;
    let mut own = place.connect().await;
    let tables = [
        // what the list of jobs goes by is made anew
        ("job", "jobs", "tenant id doc changed_at folded iteration_count status class purged_at"),
        ("iteration", "iterations", "job"),
        ("nodes", "nodes", "job"),
        // parts of the result
        ("fit", "fits", "job coefficients prior"),
        ("choice", "fit_choices", "job"),
        ("decision", "decisions", "job"),
        ("record", "records", "job"),
        ("stream", "streams", "job"),
        ("block", "stream_blocks", ""),
        ("state", "stream_states", ""),
        ("event", "events", "job"),
        ("audit", "audit", "chain tenant changed_by"),
        ("purge", "purges", "job"),
    ];
    assert_eq!(tables.map(|(name, _, _)| name), *TABLES.iter().map(|table| table.name).collect::<Vec<_>>());
    for (table, (_, name, own_to_it)) in TABLES.iter().zip(tables) {
        let there: Vec<String> =
            sqlx::query_scalar("SELECT name FROM pragma_table_info(?)").bind(name).fetch_all(&mut own).await.unwrap();
        let there: BTreeSet<&str> = there.iter().map(String::as_str).collect();
        let named = table.columns.iter().map(|column| column.name).chain(own_to_it.split_whitespace());
        let taken: BTreeSet<&str> = named.collect();
        let missing: Vec<_> = there.difference(&taken).collect();
        assert!(missing.is_empty(), "{name}: {missing:?}");
    }
}
