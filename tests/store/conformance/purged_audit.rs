//! What the audit says of a purged job: that it is intact as it is, and what was changed since.

use std::collections::{BTreeMap, BTreeSet};

use flankfit::jobs::audit::{
    Action, Chain, Entry, Verdict, What, choice_digest, decision_digest, iteration_digest, purge_digest,
};

use super::{
    pair::Pair,
    purges::{filled, purged},
};
use crate::support::WHOLE;

async fn entries(pair: &Pair, chain: Chain) -> Vec<Entry> {
    pair.store.audit(chain, WHOLE).await.unwrap().items
}

/// The chains tell of it, and hold.
pub async fn what_was_purged_is_no_break(pair: &mut Pair) {
    let job = filled(pair).await;
    let before = entries(pair, Chain::Job(job)).await;
    let (purge, _) = purged(pair, job).await;
    let told = entries(pair, Chain::Job(job)).await;
    let (last, rest) = told.split_last().unwrap();
    assert_eq!(rest.len(), before.len());
    for (is, was) in rest.iter().zip(&before) {
        // without who it was and without the salt, and with the digest that tells it
        assert!(is.is_nameless() && was.sha256 == was.digest());
        assert_eq!(Entry { actor: was.actor.clone(), contents: was.contents.clone(), ..is.clone() }, *was);
        assert!(was.contents.get("_salt").is_some());
        assert!(is.contents.iter().eq(was.contents.iter().filter(|(name, _)| *name != "_salt")));
    }
    assert_eq!((&*last.action, &*last.outcome, &*last.actor), (Action::PurgeJob.name(), "purged", "test"));
    let names: BTreeMap<&str, _> = last.contents.iter().collect();
    let wanted = ["_salt", "archive", "entries", "found", "job", "purge", "streams"];
    assert_eq!(names.keys().copied().collect::<Vec<_>>(), wanted);
    assert_eq!(*names["archive"], purge.purge.archive_sha256);
    assert_eq!(*names["purge"], purge_digest(job, &purge.purge));
    let count = told.len() as u64;
    let verdict = pair.store.verify_audit(Chain::Job(job)).await.unwrap();
    assert_eq!(verdict, Verdict::Intact { entries: count, head: Some(last.sha256) });
    // the tenant's chain has it as well
    let own = entries(pair, Chain::Tenant).await;
    assert_eq!((own.len(), &*own[0].target, &*own[0].action), (1, &*last.target, "job.purge"));
    assert_eq!(own[0].contents.get(&format!("purge.{job}")), Some(&purge_digest(job, &purge.purge)));
    assert!(matches!(pair.store.verify_audit(Chain::Tenant).await.unwrap(), Verdict::Intact { entries: 1, .. }));
}

/// Who knows who it may have been, and what was decided when, finds out nothing by trying that
/// against the digests that stay.
pub async fn names_cannot_be_tried_after_a_purge(pair: &mut Pair) {
    let job = filled(pair).await;
    let actor = entries(pair, Chain::Job(job)).await[0].actor.clone();
    let mut tried = BTreeSet::new();
    for iteration in pair.store.trace(job, WHOLE).await.unwrap().iterations {
        tried.extend(iteration.decisions.iter().map(decision_digest));
        tried.extend(iteration.choices.iter().map(choice_digest));
        let found = pair.store.iteration(job, iteration.number).await.unwrap();
        let digest = iteration_digest(found.id, &found.measurand, &found.details, found.created_at);
        assert!(found.details.operator.is_some() && tried.insert(digest));
    }
    // two iterations, three choices, a decision
    assert_eq!(tried.len(), 6);
    purged(pair, job).await;
    let left = entries(pair, Chain::Job(job)).await;
    for entry in &left[..left.len() - 1] {
        assert_ne!(Entry { actor: actor.clone(), ..entry.clone() }.digest(), entry.sha256, "{}", entry.action);
        let found = entry.contents.iter().find(|(_, digest)| tried.contains(*digest));
        assert_eq!(found, None, "{}", entry.action);
    }
}

/// Whoever changes anything of what is left is found; at the purge's number where it was there
/// before.
pub async fn what_is_changed_after_a_purge_is_found(pair: &mut Pair) {
    let job = filled(pair).await;
    let count = entries(pair, Chain::Job(job)).await.len() as u64 + 1;
    purged(pair, job).await;
    let kept =
        ["iterations", "nodes", "fits", "fit_choices", "decisions", "records", "streams", "jobs", "purges", "audit"];
    let keep: String =
        kept.iter().map(|table| format!("CREATE TABLE kept_{table} AS SELECT * FROM {table};")).collect();
    pair.ground.intrude(keep).await;
    let cases = [
        ("iterations", "UPDATE iterations SET operator = 'x' WHERE number = 1", count, What::Content),
        ("iterations", "UPDATE iterations SET instrument = 'x' WHERE number = 2", count, What::Content),
        ("nodes", "UPDATE nodes SET count = 7", count, What::Content),
        ("fits", "UPDATE fits SET rms = 0.5 WHERE lambda_star = 0.75", count, What::Content),
        ("fits", "UPDATE fits SET spec = result, result = (SELECT sha256 FROM audit LIMIT 1)", count, What::Content),
        ("fit_choices", "UPDATE fit_choices SET reason = 'x' WHERE position = 2", count, What::Content),
        ("decisions", "UPDATE decisions SET decision = 'accept'", count, What::Content),
        ("records", "UPDATE records SET method = 'newton'", count, What::Content),
        ("streams", "UPDATE streams SET forgetting_factor = 0.5 WHERE iteration IS NULL", count, What::Content),
        ("jobs", "UPDATE jobs SET name = 'x'", count, What::Content),
        // where every write looks whether the job takes anything
        ("jobs", "UPDATE jobs SET purged_at = NULL", count, What::Content),
        ("jobs", "UPDATE jobs SET purged_at = created_at", count, What::Content),
        ("purges", "UPDATE purges SET reason = 'x'", count, What::Content),
        ("purges", "DELETE FROM purges", count, What::Content),
        ("audit", "UPDATE audit SET actor = 'x' WHERE number = 2", 2, What::Entry),
        ("audit", "UPDATE audit SET target = '/x' WHERE number = 3", count, What::Content),
        ("audit", "UPDATE audit SET sha256 = previous WHERE number = 3", 4, What::Link),
        ("audit", "UPDATE audit SET peer = 'x' WHERE number = 3", count, What::Content),
        ("audit", "DELETE FROM audit WHERE number = 3", 3, What::Entry),
        ("audit", "DELETE FROM audit WHERE action = 'job.purge'", count, What::Entry),
    ];
    for (table, sql, number, what) in cases {
        pair.ground.intrude(sql.to_owned()).await;
        let verdict = pair.store.verify_audit(Chain::Job(job)).await.unwrap();
        assert_eq!(verdict, Verdict::Broken { number, what }, "{sql}");
        if table == "purges" {
            let verdict = pair.store.verify_audit(Chain::Tenant).await.unwrap();
            assert_eq!(verdict, Verdict::Broken { number: 1, what: What::Content }, "{sql}");
        }
        pair.ground.intrude(pair.ground.again(table)).await;
        let verdict = pair.store.verify_audit(Chain::Job(job)).await.unwrap();
        assert!(matches!(verdict, Verdict::Intact { entries, .. } if entries == count), "{sql}: {verdict:?}");
    }
}

/// A job that says it was purged, and was not, is found as well.
pub async fn a_purge_that_was_none_is_found(pair: &mut Pair) {
    let job = filled(pair).await;
    let count = entries(pair, Chain::Job(job)).await.len() as u64;
    pair.ground.intrude("UPDATE jobs SET purged_at = created_at".to_owned()).await;
    let verdict = pair.store.verify_audit(Chain::Job(job)).await.unwrap();
    assert_eq!(verdict, Verdict::Broken { number: count + 1, what: What::Content });
    pair.ground.intrude("UPDATE jobs SET purged_at = NULL".to_owned()).await;
    let verdict = pair.store.verify_audit(Chain::Job(job)).await.unwrap();
    assert!(matches!(verdict, Verdict::Intact { entries, .. } if entries == count), "{verdict:?}");
}
