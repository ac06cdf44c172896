//! Every change, removal, exchange or addition of a row behind the store's back is found. Tables
//! and columns are read from the schema, so a new one is met here first.

use std::{collections::BTreeSet, sync::Arc};

use flankfit::jobs::{
    Choice, Decision, DecisionEvent, Event, FinishedStream, JobPatch, NewIteration, NewPlant, Precondition, RecordKind,
    Rotation, Tenant,
    archive::Key,
    audit::{Contents, Kind, left},
    rows::Row,
};
use flankfit_engine::estimation::Nodes;
use tokio::sync::mpsc;
use uuid::Uuid;

use super::{
    keys::{HOUR, key, plant},
    pair::Pair,
    purges::{self, purged},
};
use crate::support::{actor, intact, sealed, verified};

/// Tables that are no part of any answer of the trace, and are forgotten or made anew.
const OF_OPERATION: [&str; 12] = [
    // of the release after this one, in some tests
    "of_the_next_version",
    "idempotency_keys",
    "job_texts",
    "jobs_text_terms",
    "operations",
    "probe",
    "schema_floor",
    "table_mappings",
    "told",
    "told_until",
    "sqlite_sequence",
    "_sqlx_migrations",
];

/// Columns that no answer shows; and the time of the last use of a key, which is no change of it.
const OF_NO_ANSWER: [(&str, &str); 6] = [
    ("jobs", "doc"),
    ("jobs", "folded"),
    ("jobs", "sort_name"),
    ("api_keys", "last_used_at"),
    ("audit", "changed_by"),
    ("audit_seals", "upto"),
];

/// Something in every table: a job with two iterations, their fits and records, streams that are
/// open and finished, a purged job, a tenant with keys; and all of it sealed.
async fn filled(pair: &Pair) -> Uuid {
    let (store, place, none) = (pair.store.clone(), pair.values.clone(), Precondition::None);
    let job = place.stored_job(&store).await.id;
    for more in [0, 2] {
        let mut new = NewIteration::clone(&place.iteration(job));
        let x: Vec<f64> = (0..6 + more).map(f64::from).collect();
        new.nodes = Arc::new(Nodes::scattered(x.clone(), x.clone(), x, None).unwrap()).into();
        store.insert_iteration(Arc::new(new), None).await.unwrap();
    }
    let mut fit = place.fit(0.75);
    // long enough that parts are stored once more
    let long = " ".repeat(70_000);
    fit.computed.result = format!("{{\"coefficients\":[],{long}\"prior\":{{\"of\":1}}}}").into();
    let fit = Arc::new(fit);
    store.insert_fit(job, 1, fit.clone(), None).await.unwrap();
    let event = |reason: &str| Event { reason: Some(reason.to_owned()), by: actor(), created_at: place.now() };
    store.choose(job, 1, Choice { fit_id: fit.id, event: event("better") }, none.clone()).await.unwrap();
    for decision in [Decision::Remachine, Decision::Accepted] {
        let decision = DecisionEvent { decision, concession: decision == Decision::Accepted, event: event("slope") };
        store.decide(job, 1, decision, none.clone()).await.unwrap();
    }
    store.insert_record(job, 1, place.record(RecordKind::Curve, "lagrange"), None).await.unwrap();
    let mut evaluation = (*place.record(RecordKind::Evaluation, "iso")).clone();
    (evaluation.draft.class, evaluation.draft.measurand) = (Some(6), Some("{}".into()));
    store.insert_record(job, 2, Arc::new(evaluation), None).await.unwrap();
    let [open, ended, gone] = [(); 3].map(|()| Arc::new(place.stream(job)));
    for stream in [&open, &ended, &gone] {
        store.insert_stream(stream.clone(), None).await.unwrap();
        store.insert_block(place.block(stream.id, 1), None).await.unwrap();
    }
    store.insert_block(place.block(open.id, 2), None).await.unwrap();
    let finished = FinishedStream { stream: ended.id, sequence: 1, iteration: place.iteration(job) };
    store.finish_stream(finished, None).await.unwrap();
    store.delete_stream(gone.id, none.clone(), place.now()).await.unwrap();
    let patch = JobPatch { name: Some("pinion".to_owned()), ..JobPatch::default() };
    store.patch_job(job, patch, none, place.now()).await.unwrap();
    let old = purges::filled(pair).await;
    purged(pair, old).await;
    let tenant = Tenant::named("plant-7").unwrap();
    let first = key(&place, &tenant, None);
    let rotation = Rotation { of: first.key.id, old_ends: place.now() + HOUR, new: key(&place, &tenant, None) };
    let new = NewPlant { plant: plant(&place, "plant-7"), key: first };
    pair.keys_of(&Tenant::root()).insert_plant(Arc::new(new), None).await.unwrap();
    let keys = pair.keys_of(&tenant);
    keys.rotate_key(Arc::new(rotation), None).await.unwrap();
    keys.insert_key(Arc::new(key(&place, &tenant, Some("cmm.example"))), None).await.unwrap();
    sealed(&pair.handles[0], place.now()).await;
    intact(&pair.handles[0]).await;
    pair.ground.defenceless().await;
    job
}

/// The tables that are guarded, with their columns and the types of these.
async fn guarded(pair: &Pair) -> Vec<(String, String, String)> {
    let mut columns = pair.ground.columns().await;
    let is_of_operation = |table: &str| OF_OPERATION.contains(&table) || table.starts_with("jobs_text");
    columns.retain(|(table, column, _)| {
        // of the release after this one, in some tests
        let is_of_the_next = column == "of_the_next" || column == "counted";
        !is_of_the_next && !is_of_operation(table) && !OF_NO_ANSWER.contains(&(table.as_str(), column.as_str()))
    });
    assert!(columns.len() > 120, "{}", columns.len());
    columns
}

async fn tables(pair: &Pair) -> BTreeSet<String> {
    guarded(pair).await.into_iter().map(|(table, _, _)| table).collect()
}

/// Does something to a table, says what is found, and brings the table back.
async fn found(pair: &Pair, table: &str, sql: &str) -> BTreeSet<(String, Kind)> {
    pair.ground.intrude(format!("CREATE TABLE kept_{table} AS SELECT * FROM {table}; {sql}")).await;
    let differences = verified(&pair.handles[0]).await.differences;
    pair.ground.intrude(format!("{}; DROP TABLE kept_{table}", pair.ground.again(table))).await;
    differences.into_iter().map(|difference| (difference.place, difference.kind)).collect()
}

pub async fn every_column_of_every_table_is_guarded(pair: &mut Pair) {
    filled(pair).await;
    let mut unnoticed = Vec::new();
    for (table, column, kind) in guarded(pair).await {
        let changed = pair.ground.changed(&column, &kind);
        let sql = format!("UPDATE {table} SET {column} = {changed}");
        if found(pair, &table, &sql).await.is_empty() {
            unnoticed.push(sql);
        }
    }
    assert_eq!(unnoticed, Vec::<String>::new());
    intact(&pair.handles[1]).await;
}

pub async fn removed_rows_are_detected(pair: &mut Pair) {
    filled(pair).await;
    let mut unnoticed = Vec::new();
    for table in tables(pair).await {
        if found(pair, &table, &format!("DELETE FROM {table}")).await.is_empty() {
            unnoticed.push(table);
        }
    }
    assert_eq!(unnoticed, Vec::<String>::new());
    // the last of several, with what was made of it
    for (table, sql) in [
        ("decisions", "DELETE FROM decisions WHERE position = 2"),
        ("events", "DELETE FROM events WHERE number = (SELECT max(number) FROM events)"),
        ("audit", "DELETE FROM audit WHERE action = 'iteration.decide'"),
        ("audit_chain", "DELETE FROM audit_chain WHERE number > 3"),
        ("audit_chain", "UPDATE audit_chain SET number = 0 WHERE number = 1"),
        ("audit_seals", "UPDATE audit_seals SET signature = sha256"),
    ] {
        assert!(!found(pair, table, sql).await.is_empty(), "{sql}");
    }
    // blocks are taken away, and the stream is called finished
    pair.ground.intrude("CREATE TABLE kept_stream_blocks AS SELECT * FROM stream_blocks".to_owned()).await;
    pair.ground.intrude("DELETE FROM stream_blocks".to_owned()).await;
    assert!(!found(pair, "streams", "UPDATE streams SET iteration = 1 WHERE iteration IS NULL").await.is_empty());
    pair.ground.intrude(pair.ground.again("stream_blocks")).await;
    intact(&pair.handles[0]).await;
}

pub async fn exchanged_rows_are_detected(pair: &mut Pair) {
    filled(pair).await;
    for (table, of, column) in [
        ("nodes", "number IN (1, 2)", "number"),
        ("decisions", "number = 1", "position"),
        ("fit_choices", "number = 1", "position"),
        ("fits", "number = 1", "position"),
        ("events", "number IN (1, 2)", "number"),
        ("audit_chain", "number IN (1, 2)", "number"),
    ] {
        let sql = format!(
            "UPDATE {table} SET {column} = {column} + 100 WHERE {of};
             UPDATE {table} SET {column} = 103 - {column} WHERE {column} > 100"
        );
        assert!(!found(pair, table, &sql).await.is_empty(), "{sql}");
    }
    let sql = "UPDATE nodes SET data = (SELECT n.data FROM nodes n WHERE n.number = 1 AND n.job = nodes.job) WHERE number = 2";
    assert!(!found(pair, "nodes", sql).await.is_empty());
    intact(&pair.handles[0]).await;
}

pub async fn rows_inserted_by_hand_are_detected(pair: &mut Pair) {
    let job = filled(pair).await;
    let (own, new) = (pair.ground.id(job), pair.ground.id(pair.values.id()));
    let jobs = "tenant, name, tags, version, created_at, updated_at, changed_at, folded";
    let keys = "tenant, name, role, scopes, version, created_at";
    let tenants = "description, suspended, version, created_at, updated_at";
    let decisions = "job, number, decision, created_at";
    for (table, sql, place) in [
        ("jobs", format!("INSERT INTO jobs (id, {jobs}) SELECT {new}, {jobs} FROM jobs WHERE id = {own}"), "jobs/2"),
        (
            "api_keys",
            format!(
                "INSERT INTO api_keys (id, san, {keys}) SELECT '00000000000000ff', 'x', {keys} FROM api_keys WHERE version = 1 LIMIT 1"
            ),
            "api_keys/00000000000000ff/1",
        ),
        (
            "tenants",
            format!(
                "INSERT INTO tenants (name, id, {tenants})
                 SELECT 'by-hand', {new}, {tenants} FROM tenants WHERE name = 'plant-7'"
            ),
            "tenants/by-hand/1",
        ),
        (
            "decisions",
            format!(
                "INSERT INTO decisions (position, {decisions}) SELECT 3, {decisions} FROM decisions
                     WHERE position = 2 AND job = {own}"
            ),
            "decisions/1/3",
        ),
    ] {
        let found = found(pair, table, &sql).await;
        assert!(found.contains(&(place.to_owned(), Kind::Unaudited)), "{sql}: {found:?}");
    }
    intact(&pair.handles[0]).await;
}

pub async fn one_unreadable_value_hides_nothing(pair: &mut Pair) {
    let job = filled(pair).await;
    let nothing = pair.ground.literal(&[0xff, 0xfe]);
    pair.ground.intrude(format!("UPDATE fits SET result = {nothing} WHERE number = 1 AND position = 1")).await;
    pair.ground.intrude("UPDATE decisions SET reason = 'x' WHERE position = 1".to_owned()).await;
    let differences = verified(&pair.handles[0]).await.differences;
    let of_job =
        |kind| differences.iter().filter(|difference| difference.job == Some(job) && difference.kind == kind).count();
    assert!(of_job(Kind::Unreadable) == 1 && of_job(Kind::Missing) == 1, "{differences:#?}");
    let changed = differences
        .iter()
        .filter(|difference| (difference.place.as_str(), difference.kind) == ("decisions/1/1", Kind::Changed));
    assert_eq!(changed.count(), 1, "{differences:#?}");
}

/// Inserts an entry of the default tenant, after all others.
async fn forged_entry(pair: &Pair, job: Uuid, action: &str, subject: &str, contents: &Contents) {
    let bytes = |bytes: &[u8]| pair.ground.literal(bytes);
    let [id, job] = [Uuid::max(), job].map(|id| pair.ground.id(id));
    let (contents, zeros) = (bytes(contents.bytes()), bytes(&[0; 32]));
    let sql = format!(
        "DELETE FROM audit WHERE id = {id};
         INSERT INTO audit (id, tenant, job, at, actor, action, subject, contents, salt, who)
         VALUES ({id}, 'default', {job}, '2027-01-01T00:00:00.000000Z', 'x', '{action}', '{subject}', {contents},
                 {zeros}, {zeros})"
    );
    pair.ground.intrude(sql).await;
}

/// Returns what verification finds in a job.
async fn differences_of(pair: &Pair, job: Uuid) -> BTreeSet<(String, Kind)> {
    let differences = verified(&pair.handles[0]).await.differences;
    differences
        .into_iter()
        .filter(|difference| difference.job == Some(job))
        .map(|difference| (difference.place, difference.kind))
        .collect()
}

/// An entry of a purge has digests of the rows as they are, so that changes of before count no
/// more.
pub async fn a_forged_purge_hides_nothing(pair: &mut Pair) {
    let job = filled(pair).await;
    let old = purges::filled(pair).await;
    purged(pair, old).await;
    for (job, kind) in [(job, Kind::Missing), (old, Kind::Unaudited)] {
        let own = pair.ground.id(job);
        pair.ground.intrude(format!("UPDATE decisions SET decision = 'rejected' WHERE job = {own}")).await;
        let key = Key { tenant: Tenant::named("default").unwrap(), job };
        let (rows, mut coming) = mpsc::channel::<Row>(8);
        let holdings = pair.handles[0].holdings();
        let digesting = async {
            let (mut digests, mut fields) = (Vec::new(), left(&[0; 32]));
            while let Some(row) = coming.recv().await {
                let digest = row.table.digest(&[0; 32], &row.values);
                match row.table.name {
                    "jobs" | "purges" => digests.push((row.name(), digest)),
                    "audit" => {}
                    _ => fields = fields.bytes(&digest),
                }
            }
            digests.push(("left".to_owned(), fields.digest()));
            Contents::of(digests)
        };
        let (read, contents) = tokio::join!(holdings.read(key, rows), digesting);
        read.unwrap();
        forged_entry(pair, job, "job.purge", "/v1/jobs/x", &contents).await;
        let differences = differences_of(pair, job).await;
        assert!(differences.contains(&("purges".to_owned(), kind)), "{differences:?}");
    }
}

/// An entry of a deletion explains only that the stream is not there.
pub async fn a_forged_deletion_hides_no_rollback(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = filled(pair).await;
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    store.insert_block(place.block(stream.id, 1), None).await.unwrap();
    let [own, id] = [job, stream.id].map(|id| pair.ground.id(id));
    pair.ground.intrude(format!("CREATE TABLE of_before AS SELECT * FROM streams WHERE id = {id}")).await;
    store.insert_block(place.block(stream.id, 2), None).await.unwrap();
    intact(&pair.handles[0]).await;
    let columns = "version, sequence, node_count, input_sha256, updated_at";
    let rollback = format!("UPDATE streams SET ({columns}) = (SELECT {columns} FROM of_before) WHERE id = {id}");
    pair.ground.intrude(rollback).await;
    forged_entry(pair, job, "stream.delete", &format!("/v1/streams/{}", stream.id), &Contents::default()).await;
    let (missing, differences) = (format!("streams/{}/3", stream.id), differences_of(pair, job).await);
    assert!(differences.contains(&(missing, Kind::Missing)), "{differences:?}");
    // nor is a table taken for a stream
    let sql = format!("UPDATE jobs SET version = 1, name = 'wheel', updated_at = created_at WHERE id = {own}");
    pair.ground.intrude(sql).await;
    forged_entry(pair, job, "stream.delete", "/v1/streams/jobs", &Contents::default()).await;
    let differences = differences_of(pair, job).await;
    assert!(differences.contains(&("jobs/2".to_owned(), Kind::Missing)), "{differences:?}");
}

/// The last estimate of a stream is the one that counts.
pub async fn an_older_estimate_is_noticed(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    for sequence in 1..=10 {
        if sequence == 2 {
            pair.ground.intrude("CREATE TABLE of_before AS SELECT * FROM stream_states".to_owned()).await;
        }
        let mut block = (*place.block(stream.id, sequence)).clone();
        block.state = block.state.filter(|_| [1, 2, 10].contains(&sequence));
        store.insert_block(Arc::new(block), None).await.unwrap();
    }
    intact(&pair.handles[0]).await;
    pair.ground
        .intrude("DELETE FROM stream_states; INSERT INTO stream_states SELECT * FROM of_before".to_owned())
        .await;
    let missing = (format!("stream_states/{}/10", stream.id), Kind::Missing);
    assert_eq!(differences_of(pair, job).await, BTreeSet::from([missing]));
}
