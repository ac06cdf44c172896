//! The trace is append-only, whoever holds the connection.

use flankfit::jobs::{Decision, DecisionEvent, Event, Precondition, RecordKind};

use super::{
    pair::Pair,
    purges::{filled, purged},
};
use crate::support::{actor, sealed};

/// Statements that must be refused, for every table of the trace.
const CHANGES: [&str; 20] = [
    "UPDATE iterations SET note = note",
    "DELETE FROM iterations",
    "UPDATE nodes SET data = data",
    "DELETE FROM nodes",
    "UPDATE fits SET result = result",
    "DELETE FROM fits",
    "UPDATE fit_choices SET reason = reason",
    "DELETE FROM fit_choices",
    "UPDATE decisions SET reason = reason",
    "DELETE FROM decisions",
    "UPDATE records SET result = result",
    "DELETE FROM records",
    "UPDATE events SET kind = kind",
    "DELETE FROM events",
    "UPDATE audit SET actor = actor",
    "DELETE FROM audit",
    "UPDATE audit_seals SET at = at",
    "DELETE FROM audit_seals",
    "UPDATE audit_chain SET number = number",
    "DELETE FROM audit_chain",
];

/// The same of what says that a job was purged.
const CHANGES_OF_PURGES: [&str; 2] = ["UPDATE purges SET reason = reason", "DELETE FROM purges"];

/// The same of whole tables, which no trigger of a row sees. (What others refer to goes with these,
/// or not at all.)
const TRUNCATIONS: [(&str, &str); 11] = [
    ("iterations", "TRUNCATE iterations CASCADE"),
    ("nodes", "TRUNCATE nodes"),
    ("fits", "TRUNCATE fits CASCADE"),
    ("fit_choices", "TRUNCATE fit_choices"),
    ("decisions", "TRUNCATE decisions"),
    ("records", "TRUNCATE records"),
    ("events", "TRUNCATE events"),
    ("audit", "TRUNCATE audit CASCADE"),
    ("audit_seals", "TRUNCATE audit_seals"),
    ("audit_chain", "TRUNCATE audit_chain"),
    ("purges", "TRUNCATE purges"),
];

pub async fn the_trace_is_append_only(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    place.stored_iteration(&store, job).await;
    store.insert_record(job, 1, place.record(RecordKind::Curve, "lagrange"), None).await.unwrap();
    let event = Event { reason: Some("slope".to_owned()), by: actor(), created_at: place.now() };
    let decision = DecisionEvent { decision: Decision::Remachine, concession: false, event };
    store.decide(job, 1, decision, Precondition::None).await.unwrap();
    sealed(&pair.handles[0], place.now()).await;
    for sql in CHANGES {
        let refusal = pair.ground.refusal(sql).await;
        assert!(refusal.as_deref().is_some_and(|why| why.contains("append-only")), "{sql}: {refusal:?}");
    }
    // a job that has a trace stays, and stays with its tenant
    assert!(pair.ground.refusal("DELETE FROM jobs").await.is_some());
    assert!(pair.ground.refusal("UPDATE jobs SET tenant = 'other'").await.is_some());
    assert_eq!(pair.ground.refusal("UPDATE jobs SET name = name").await, None);
    let old = filled(pair).await;
    purged(pair, old).await;
    for sql in CHANGES_OF_PURGES {
        let refusal = pair.ground.refusal(sql).await;
        assert!(refusal.as_deref().is_some_and(|why| why.contains("append-only")), "{sql}: {refusal:?}");
    }
    if pair.ground.truncates() {
        for (table, sql) in TRUNCATIONS {
            let refusal = pair.ground.refusal(sql).await;
            let message = format!("{table} is append-only");
            assert!(refusal.as_deref().is_some_and(|why| why.contains(&message)), "{sql}: {refusal:?}");
        }
        for sql in ["TRUNCATE jobs CASCADE", "TRUNCATE api_keys"] {
            assert!(pair.ground.refusal(sql).await.is_some(), "{sql}");
        }
    }
}
