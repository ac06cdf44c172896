//! Whoever changes, removes or exchanges a row behind the store's back is found, at the number of
//! the entry that tells of it.

use std::sync::Arc;

use flankfit::jobs::{
    Choice, Decision, DecisionEvent, Event, FinishedStream, JobPatch, NewIteration, Precondition, RecordKind,
    RepositoryError, Resource, Tenant,
    audit::{Chain, Evidence, Head, Verdict, What, examine, new_iteration},
};
use flankfit_engine::estimation::Nodes;
use uuid::Uuid;

use super::{audit::entries, pair::Pair, purges::purged, seals::sealed};
use crate::support::{WHOLE, actor, nodes};

/// An iteration whose fit and whose nodes are no others', by λ* and by how many nodes there are.
fn iteration(pair: &Pair, job: Uuid, lambda_star: f64, more: usize) -> Arc<NewIteration> {
    let mut new = NewIteration::clone(&pair.values.iteration(job));
    new.fit = pair.values.fit(lambda_star);
    if more > 0 {
        let x: Vec<f64> = (0..6 + more).map(|i| i as f64).collect();
        new.nodes = Arc::new(Nodes::scattered(x.clone(), x.clone(), x, None).unwrap()).into();
    } else {
        new.nodes = Arc::new(nodes()).into();
    }
    Arc::new(new)
}

/// A job with something of everything. Its entries: 1 the job, 2 and 3 iterations (λ* 0.25 with 6
/// nodes, 0.5 with 8), 4 a fit (λ* 0.75), 5 a choice, 6 a decision, 7 a record, 8 and 9 streams, 10
/// a block, 11 the second stream's iteration (λ* 0.875 with 9 nodes), 12 a change of the job.
async fn filled(pair: &Pair) -> Uuid {
    let (store, place, none) = (pair.store.clone(), pair.values.clone(), Precondition::None);
    let job = place.stored_job(&store).await.id;
    store.insert_iteration(iteration(pair, job, 0.25, 0), None).await.unwrap();
    store.insert_iteration(iteration(pair, job, 0.5, 2), None).await.unwrap();
    let fit = Arc::new(place.fit(0.75));
    store.insert_fit(job, 1, fit.clone(), None).await.unwrap();
    let event = || Event { reason: Some("slope".to_owned()), by: actor(), created_at: place.now() };
    store.choose(job, 1, Choice { fit_id: fit.id, event: event() }, none.clone()).await.unwrap();
    let decision = DecisionEvent { decision: Decision::Remachine, concession: false, event: event() };
    store.decide(job, 1, decision, none.clone()).await.unwrap();
    store.insert_record(job, 1, place.record(RecordKind::Curve, "lagrange"), None).await.unwrap();
    let streams = [(); 2].map(|()| Arc::new(place.stream(job)));
    for stream in &streams {
        store.insert_stream(stream.clone(), None).await.unwrap();
    }
    store.insert_block(place.block(streams[0].id, 1), None).await.unwrap();
    let finished = FinishedStream { stream: streams[1].id, sequence: 0, iteration: iteration(pair, job, 0.875, 3) };
    store.finish_stream(finished, None).await.unwrap();
    let patch = JobPatch { name: Some("pinion".to_owned()), ..JobPatch::default() };
    store.patch_job(job, patch, none, place.now()).await.unwrap();
    job
}

pub async fn what_is_as_it_was_written_is_intact(pair: &mut Pair) {
    let job = filled(pair).await;
    let told = entries(&pair.store, job).await;
    let head = told.last().unwrap().sha256;
    assert_eq!(
        pair.store.verify_audit(Chain::Job(job)).await.unwrap(),
        Verdict::Intact { entries: 12, head: Some(head) }
    );
    let other = pair.values.stored_job(&pair.store).await.id;
    pair.store.delete_job(other, Precondition::None).await.unwrap();
    let verdict = pair.store.verify_audit(Chain::Job(other)).await.unwrap();
    assert!(matches!(verdict, Verdict::Intact { entries: 2, .. }), "{verdict:?}");
    assert_eq!(pair.store.audit(Chain::Job(other), WHOLE).await.unwrap().items.len(), 2);
}

/// Tampers, and tells what is found.
async fn found(pair: &mut Pair, job: Uuid, sql: &str) -> Verdict {
    pair.ground.intrude(sql.to_owned()).await;
    pair.store.verify_audit(Chain::Job(job)).await.unwrap()
}

/// Each on a copy of the audit: what one case has done is undone for the next.
pub async fn changed_entries_are_found_at_their_numbers(pair: &mut Pair) {
    let job = filled(pair).await;
    pair.ground.intrude("CREATE TABLE audit_kept AS SELECT * FROM audit".to_owned()).await;
    let cases = [
        ("UPDATE audit SET actor = 'other' WHERE number = 3", 3, What::Entry),
        ("UPDATE audit SET action = 'fit.none' WHERE number = 4", 4, What::Entry),
        ("UPDATE audit SET target = '/v1/jobs' WHERE number = 5", 5, What::Entry),
        ("UPDATE audit SET request_id = 'x' WHERE number = 6", 6, What::Entry),
        ("UPDATE audit SET peer = '' WHERE number = 7", 7, What::Entry),
        ("UPDATE audit SET outcome = 'lost' WHERE number = 12", 12, What::Entry),
        ("UPDATE audit SET contents = previous WHERE number = 8", 8, What::Entry),
        ("UPDATE audit SET previous = sha256 WHERE number = 1", 1, What::Entry),
        ("UPDATE audit SET sha256 = previous WHERE number = 9", 9, What::Entry),
        ("DELETE FROM audit WHERE number = 1", 1, What::Entry),
        ("DELETE FROM audit WHERE number = 10", 10, What::Entry),
        // the last: the job was changed once more than is told
        ("DELETE FROM audit WHERE number = 12", 12, What::Content),
        ("UPDATE audit SET number = 100 + number WHERE number IN (4, 5)", 4, What::Entry),
    ];
    for (sql, number, what) in cases {
        assert_eq!(found(pair, job, sql).await, Verdict::Broken { number, what }, "{sql}");
        pair.ground.intrude("DELETE FROM audit; INSERT INTO audit SELECT * FROM audit_kept".to_owned()).await;
        assert!(matches!(pair.store.verify_audit(Chain::Job(job)).await.unwrap(), Verdict::Intact { entries: 12, .. }));
    }
    // two that have changed places
    let swap = "UPDATE audit SET number = 104 WHERE number = 4; UPDATE audit SET number = 4 WHERE number = 5;
                UPDATE audit SET number = 5 WHERE number = 104";
    assert_eq!(found(pair, job, swap).await, Verdict::Broken { number: 4, what: What::Entry });
}

/// Whatever the last entries told of is there, and told of no more.
pub async fn missing_last_entries_are_found_at_their_numbers(pair: &mut Pair) {
    let job = filled(pair).await;
    pair.ground.intrude("CREATE TABLE audit_kept AS SELECT * FROM audit".to_owned()).await;
    for last in 1..12 {
        let verdict = found(pair, job, &format!("DELETE FROM audit WHERE number > {last}")).await;
        assert_eq!(verdict, Verdict::Broken { number: last + 1, what: What::Content });
        let again = format!("INSERT INTO audit SELECT * FROM audit_kept WHERE number > {last}");
        let verdict = found(pair, job, &again).await;
        assert!(matches!(verdict, Verdict::Intact { entries: 12, .. }), "{verdict:?}");
    }
}

/// What is gone may have been deleted with an entry, which is missing, or without one: by rows
/// alone it is a row of the entry that told of it last. A seal knows better.
pub async fn a_missing_entry_of_what_was_deleted_is_known_by_its_seal(pair: &mut Pair) {
    let (store, place, none) = (pair.store.clone(), pair.values.clone(), Precondition::None);
    let [job, other] = [place.stored_job(&store).await.id, place.stored_job(&store).await.id];
    store.delete_job(job, none.clone()).await.unwrap();
    let stream = Arc::new(place.stream(other));
    store.insert_stream(stream.clone(), None).await.unwrap();
    store.delete_stream(stream.id, none, place.now()).await.unwrap();
    pair.ground.intrude("CREATE TABLE audit_kept AS SELECT * FROM audit".to_owned()).await;
    let missing = "DELETE FROM audit WHERE action IN ('job.delete', 'stream.delete')";
    let content = |number| Verdict::Broken { number, what: What::Content };
    assert_eq!(found(pair, job, missing).await, content(1));
    assert_eq!(found(pair, other, missing).await, content(2));
    pair.ground.intrude("DELETE FROM audit; INSERT INTO audit SELECT * FROM audit_kept".to_owned()).await;
    sealed(pair, 2).await;
    let entry = |number| Verdict::Broken { number, what: What::Entry };
    assert_eq!(found(pair, job, missing).await, entry(2));
    assert_eq!(found(pair, other, missing).await, entry(3));
}

/// That the end of a chain is missing, as its seal tells, hides nothing that is wrong before it.
pub async fn a_fault_before_a_missing_end_is_told_first(pair: &mut Pair) {
    let job = pair.values.stored_job(&pair.store).await.id;
    for lambda_star in [2.0, 3.0, 4.0] {
        pair.store.insert_iteration(iteration(pair, job, lambda_star, 7), None).await.unwrap();
    }
    sealed(pair, 1).await;
    let entry = |number| Verdict::Broken { number, what: What::Entry };
    assert_eq!(found(pair, job, "DELETE FROM audit WHERE number = 4").await, entry(4));
    assert_eq!(found(pair, job, "UPDATE audit SET actor = '' WHERE number = 2").await, entry(2));
    // nobody has purged it, so the names are not gone with a purge
    assert_eq!(found(pair, job, "UPDATE audit SET actor = ''").await, entry(1));
}

/// What an entry told that is missing is not taken for what is older than the chain.
pub async fn a_missing_end_is_told_from_what_is_older(pair: &mut Pair) {
    let job = pair.values.stored_job(&pair.store).await.id;
    pair.store.insert_iteration(iteration(pair, job, 2.0, 7), None).await.unwrap();
    pair.ground.intrude("DELETE FROM audit".to_owned()).await;
    for lambda_star in [4.0, 5.0, 6.0] {
        pair.store.insert_fit(job, 1, Arc::new(pair.values.fit(lambda_star)), None).await.unwrap();
    }
    sealed(pair, 1).await;
    let broken = |number, what| Verdict::Broken { number, what };
    assert_eq!(found(pair, job, "DELETE FROM audit WHERE number = 4").await, broken(4, What::Entry));
    let changed = "UPDATE fits SET rms = 0.5 WHERE lambda_star = 5.0";
    assert_eq!(found(pair, job, changed).await, broken(2, What::Content));
}

pub async fn changed_rows_are_found_at_their_numbers(pair: &mut Pair) {
    let swap = |table: &str, column: &str, by: &str, one: &str, two: &str| {
        format!(
            "CREATE TABLE swapped AS SELECT {by} AS k, {column} AS v FROM {table} WHERE {by} IN ({one}, {two});
             UPDATE {table} SET {column} = (SELECT v FROM swapped WHERE k = {two}) WHERE {by} = {one};
             UPDATE {table} SET {column} = (SELECT v FROM swapped WHERE k = {one}) WHERE {by} = {two};
             DROP TABLE swapped"
        )
    };
    let cases = [
        ("UPDATE nodes SET count = 7 WHERE count = 6".to_owned(), 2),
        ("UPDATE nodes SET data = (SELECT data FROM nodes WHERE count = 8) WHERE count = 9".to_owned(), 11),
        ("DELETE FROM nodes WHERE count = 8".to_owned(), 3),
        (swap("nodes", "data", "count", "8", "9"), 3),
        ("UPDATE fits SET rms = 0.125 WHERE lambda_star = 0.5".to_owned(), 3),
        ("UPDATE fits SET reason = 'other' WHERE lambda_star = 0.75".to_owned(), 4),
        ("UPDATE fits SET flank_figures = '{}' WHERE lambda_star = 0.875".to_owned(), 11),
        ("UPDATE fits SET flank_figures = NULL WHERE lambda_star = 0.75".to_owned(), 4),
        ("UPDATE fits SET actor = NULL WHERE lambda_star = 0.75".to_owned(), 4),
        ("UPDATE fit_choices SET actor = 'key-other' WHERE position = 2".to_owned(), 5),
        ("UPDATE decisions SET actor = 'key-other'".to_owned(), 6),
        ("UPDATE records SET actor = 'key-other'".to_owned(), 7),
        ("UPDATE fits SET criterion = 'none' WHERE lambda_star = 0.875".to_owned(), 11),
        ("UPDATE fits SET spec = result WHERE lambda_star = 0.25".to_owned(), 2),
        ("DELETE FROM fits WHERE lambda_star = 0.75".to_owned(), 4),
        ("DELETE FROM fits WHERE lambda_star = 0.5".to_owned(), 3),
        (swap("fits", "result", "lambda_star", "0.5", "0.875"), 3),
        ("UPDATE iterations SET note = 'other' WHERE number = 2".to_owned(), 3),
        ("UPDATE fit_choices SET reason = NULL WHERE position = 2".to_owned(), 5),
        ("UPDATE decisions SET decision = 'accept'".to_owned(), 6),
        ("DELETE FROM decisions".to_owned(), 6),
        ("UPDATE records SET method = 'newton'".to_owned(), 7),
        ("DELETE FROM records".to_owned(), 7),
        ("UPDATE streams SET forgetting_factor = 0.5 WHERE sequence = 1".to_owned(), 8),
        ("DELETE FROM stream_blocks".to_owned(), 10),
        ("UPDATE stream_blocks SET count = 3".to_owned(), 10),
        ("UPDATE jobs SET machine = 'other'".to_owned(), 12),
        ("UPDATE jobs SET requirements = NULL".to_owned(), 12),
    ];
    for (sql, number) in cases {
        // each in a database of its own
        let job = filled(pair).await;
        let verdict = found(pair, job, &sql).await;
        assert_eq!(verdict, Verdict::Broken { number, what: What::Content }, "{sql}");
        pair.ground.intrude(CLEAR.to_owned()).await;
    }
    // rows that no entry tells of
    let job = filled(pair).await;
    let forgotten = "CREATE TABLE kept AS SELECT * FROM audit WHERE number < 7; DELETE FROM audit;
        INSERT INTO audit SELECT * FROM kept; DELETE FROM stream_states; DELETE FROM stream_blocks;
        DELETE FROM streams; UPDATE jobs SET name = 'wheel', version = 1, updated_at = created_at";
    assert_eq!(found(pair, job, forgotten).await, Verdict::Broken { number: 7, what: What::Content });
}

/// A long result is stored in another form, and what the trace tells of a longer one is kept beside
/// it; it is the same for whoever reads it, and as well guarded.
pub async fn long_results_are_guarded_too(pair: &mut Pair) {
    let job = pair.values.stored_job(&pair.store).await.id;
    let values = |from: u32, count: u32| {
        (from..from + count).map(|i| f64::from(i).sqrt().to_string()).collect::<Vec<_>>().join(",")
    };
    let mut stored = Vec::new();
    for (from, count) in [(1, 600), (100_000, 5_000)] {
        let mut new = NewIteration::clone(&iteration(pair, job, f64::from(from), 0));
        let prior = format!(r#"{{"of":[ {from}]}}"#);
        new.fit.computed.result =
            format!(r#"{{"coefficients":[{from},1.50],"prior":{prior},"values":[{}]}}"#, values(from, count)).into();
        let whole = new.fit.computed.result.text().clone();
        assert!(new.fit.computed.result.bytes().len() < whole.len());
        assert_eq!(new.fit.computed.result.kept_beside().coefficients.is_some(), count > 600);
        let fit = new.fit.id;
        let number = pair.store.insert_iteration(Arc::new(new), None).await.unwrap().number;
        assert_eq!(pair.store.fit(job, number, fit).await.unwrap().result, whole);
        stored.push((format!("[{from},1.50]"), prior));
    }
    let told = pair.store.trace(job, WHOLE).await.unwrap().iterations;
    for ((coefficients, prior), iteration) in stored.iter().zip(&told) {
        let fit = &iteration.fits[0];
        assert_eq!((&fit.coefficients, fit.prior.as_deref()), (coefficients, Some(prior.as_str())));
    }
    let verdict = pair.store.verify_audit(Chain::Job(job)).await.unwrap();
    assert!(matches!(verdict, Verdict::Intact { entries: 3, .. }), "{verdict:?}");
    let undo = "UPDATE fits SET coefficients = v, prior = p FROM kept WHERE fits.lambda_star = kept.l";
    let keep = "CREATE TABLE kept AS SELECT lambda_star AS l, coefficients AS v, prior AS p FROM fits";
    pair.ground.intrude(keep.to_owned()).await;
    for (number, sql) in [
        (2, "UPDATE fits SET coefficients = spec WHERE lambda_star < 2"),
        (3, "UPDATE fits SET coefficients = spec WHERE lambda_star > 2"),
        (3, "UPDATE fits SET prior = NULL WHERE lambda_star > 2"),
    ] {
        assert_eq!(found(pair, job, sql).await, Verdict::Broken { number, what: What::Content }, "{sql}");
        pair.ground.intrude(undo.to_owned()).await;
        assert!(matches!(pair.store.verify_audit(Chain::Job(job)).await.unwrap(), Verdict::Intact { .. }));
    }
    let exchanged = "UPDATE fits SET result = (SELECT result FROM fits WHERE lambda_star < 2) WHERE lambda_star > 2";
    assert_eq!(found(pair, job, exchanged).await, Verdict::Broken { number: 3, what: What::Content });
}

/// Everything, in an order that no reference forbids.
const CLEAR: &str = "DELETE FROM stream_states; DELETE FROM stream_blocks; DELETE FROM streams; DELETE FROM events; \
                     DELETE FROM records; DELETE FROM decisions; DELETE FROM fit_choices; DELETE FROM fits; \
                     DELETE FROM nodes; DELETE FROM iterations; DELETE FROM jobs; DELETE FROM audit";

/// Whoever gives a job to another tenant is found by both.
pub async fn a_job_that_was_given_to_another_tenant_is_found(pair: &mut Pair) {
    let job = filled(pair).await;
    let bare = pair.values.stored_job(&pair.store).await.id;
    let (own, other) = (pair.store.clone(), pair.seen_by("other"));
    let missing = other.verify_audit(Chain::Job(job)).await;
    assert!(matches!(missing, Err(RepositoryError::NotFound(Resource::Job))), "{missing:?}");
    pair.ground.intrude("UPDATE jobs SET tenant = 'other'".to_owned()).await;
    let first = Verdict::Broken { number: 1, what: What::Content };
    // its rows are gone with it: of the first job those of entry 2 are the first
    let second = Verdict::Broken { number: 2, what: What::Content };
    for (job, of_own) in [(job, second), (bare, first)] {
        assert_eq!(own.verify_audit(Chain::Job(job)).await.unwrap(), of_own);
        assert_eq!(other.verify_audit(Chain::Job(job)).await.unwrap(), first, "no entry of this tenant tells of it");
        let auditor = pair.handles[0].auditor();
        let found = examine(&*auditor, Some(job), &Evidence::default()).await.unwrap().unwrap();
        let told: Vec<_> = found.faults.iter().map(|fault| (fault.tenant.as_str(), fault.number, fault.what)).collect();
        let Verdict::Broken { number, what } = of_own else { unreachable!() };
        assert_eq!(told, [("default", number, what), ("other", 1, What::Content)]);
    }
    pair.ground.intrude("UPDATE jobs SET tenant = 'default'".to_owned()).await;
    for (job, count) in [(job, 12), (bare, 1)] {
        let verdict = own.verify_audit(Chain::Job(job)).await.unwrap();
        assert!(matches!(verdict, Verdict::Intact { entries, .. } if entries == count), "{verdict:?}");
    }
}

/// What a job is found by in the list follows from its trace, and so does the time by which it is
/// purged.
pub async fn what_a_job_is_listed_by_is_compared(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = filled(pair).await;
    let decide = async |number| {
        let event = Event { reason: None, by: actor(), created_at: place.now() };
        let decision = DecisionEvent { decision: Decision::Reject, concession: false, event };
        store.decide(job, number, decision, Precondition::None).await.unwrap();
    };
    let intact = async |count: u64, after: &str| {
        let verdict = store.verify_audit(Chain::Job(job)).await.unwrap();
        assert!(matches!(verdict, Verdict::Intact { entries, .. } if entries == count), "{after}: {verdict:?}");
    };
    for (count, status) in [(12, "open"), (14, "rejected")] {
        if count == 14 {
            // the first of them is none on the gear as it is
            decide(1).await;
            decide(3).await;
        }
        intact(count, status).await;
        let keep = "CREATE TABLE kept AS SELECT iteration_count, status, changed_at FROM jobs";
        pair.ground.intrude(keep.to_owned()).await;
        for change in [
            "iteration_count = 2",
            "iteration_count = 4",
            "status = 'accepted'",
            "status = 'new'",
            "changed_at = created_at",
        ] {
            let verdict = found(pair, job, &format!("UPDATE jobs SET {change}")).await;
            assert_eq!(verdict, Verdict::Broken { number: 12, what: What::Content }, "{change}");
            let undo = "UPDATE jobs SET iteration_count = kept.iteration_count, status = kept.status,
                                        changed_at = kept.changed_at FROM kept";
            pair.ground.intrude(undo.to_owned()).await;
            intact(count, change).await;
        }
        pair.ground.intrude("DROP TABLE kept".to_owned()).await;
    }
}

/// What was found at its first change is held against one digest, what came later row by row.
pub async fn a_job_from_before_is_verified_too(pair: &mut Pair) {
    let job = filled(pair).await;
    pair.ground.intrude("DELETE FROM audit".to_owned()).await;
    assert_eq!(pair.store.verify_audit(Chain::Job(job)).await.unwrap(), Verdict::Intact { entries: 0, head: None });
    pair.store.insert_iteration(iteration(pair, job, 2.0, 7), None).await.unwrap();
    pair.store.insert_fit(job, 1, Arc::new(pair.values.fit(4.0)), None).await.unwrap();
    let verdict = pair.store.verify_audit(Chain::Job(job)).await.unwrap();
    assert!(matches!(verdict, Verdict::Intact { entries: 3, .. }), "{verdict:?}");
    let broken = |number| Verdict::Broken { number, what: What::Content };
    assert_eq!(found(pair, job, "UPDATE fits SET rms = 0.5 WHERE lambda_star = 4.0").await, broken(3));
    assert_eq!(found(pair, job, "UPDATE nodes SET count = 99 WHERE count = 13").await, broken(2));
    assert_eq!(found(pair, job, "UPDATE fits SET rms = 0.5 WHERE lambda_star = 0.25").await, broken(1));
}

/// Entries from before there were salts have the digests themselves.
pub async fn a_chain_that_began_without_salts_is_verified_too(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let (first, _) = place.stored_iteration(&store, job).await;
    place.stored_iteration(&store, job).await;
    let mut told = entries(&store, job).await;
    told[1].contents = new_iteration(&first);
    let (mut head, mut sql) = (Head::before(Chain::Job(job), &Tenant::default()), String::new());
    for entry in &mut told {
        entry.previous = head.sha256;
        entry.sha256 = entry.digest();
        head = Head { number: entry.number, sha256: entry.sha256 };
        let [contents, previous, sha256] =
            [entry.contents.bytes(), &entry.previous, &entry.sha256].map(|bytes| pair.ground.literal(bytes));
        sql += &format!(
            "UPDATE audit SET contents = {contents}, previous = {previous}, sha256 = {sha256}
             WHERE chain = {} AND number = {};",
            pair.ground.id(job),
            entry.number
        );
    }
    pair.ground.intrude(sql).await;
    let verify = async || store.verify_audit(Chain::Job(job)).await.unwrap();
    assert_eq!(verify().await, Verdict::Intact { entries: 3, head: Some(head.sha256) });
    for number in [1, 2] {
        let sql = |note: &str| format!("UPDATE iterations SET note = {note} WHERE number = {number}");
        pair.ground.intrude(format!("CREATE TABLE kept{number} AS SELECT note, number FROM iterations")).await;
        pair.ground.intrude(sql("'another'")).await;
        assert_eq!(verify().await, Verdict::Broken { number: number + 1, what: What::Content });
        pair.ground.intrude(sql(&format!("(SELECT note FROM kept{number} WHERE number = {number})"))).await;
    }
    purged(pair, job).await;
    assert!(matches!(verify().await, Verdict::Intact { entries: 4, .. }));
}
