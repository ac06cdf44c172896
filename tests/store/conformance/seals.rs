//! Seals have the ends of chains, and convict whoever writes a chain anew.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
    time::{Duration, Instant},
};

use flankfit::jobs::{
    JobPatch, PageRequest, Precondition, Tenant,
    audit::{Chain, Entry, Head, Seal, SealedHead, Sealing, SigningKey, Verdict, What, WholeSeal, root_of},
};
use jiff::{SignedDuration, Timestamp};
use tokio::task::JoinSet;
use uuid::Uuid;

use super::{audit::entries, keys::key as api_key, pair::Pair};
use crate::support::{WHOLE, caller};

/// RFC 8032, section 7.1, test 2.
pub fn key() -> Arc<SigningKey> {
    let secret = "302e020100300506032b6570042204204ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb";
    let bytes = (0..secret.len() / 2).map(|k| u8::from_str_radix(&secret[2 * k..2 * k + 2], 16).unwrap());
    Arc::new(SigningKey::from_pkcs8(&bytes.collect::<Vec<_>>()).unwrap())
}

fn sealing(at: Timestamp) -> Sealing {
    Sealing { at, key: Some(key()), unless_since: Timestamp::MAX }
}

/// Seals until so many heads are sealed: a database may have transactions from before the entries
/// that are to be sealed, in which case they have to end.
pub async fn sealed(pair: &Pair, heads: usize) -> Vec<WholeSeal> {
    // an entry is not sealed while anything older on the server may still be stored
    pair.ground.settled().await;
    let (mut made, begun) = (Vec::new(), Instant::now());
    while made.iter().map(|seal: &WholeSeal| seal.heads.len()).sum::<usize>() < heads {
        assert!(begun.elapsed() < Duration::from_secs(60), "{made:?}");
        let turn = made.len() % 2;
        made.extend(pair.handles[turn].seal_audit(sealing(pair.values.now())).await.unwrap().into_iter().flatten());
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    made
}

fn heads(made: &[WholeSeal]) -> BTreeSet<SealedHead> {
    made.iter().flat_map(|seal| seal.heads.iter().copied()).collect()
}

fn head_of(chain: Uuid, entries: &[Entry]) -> SealedHead {
    let last = entries.last().unwrap();
    SealedHead { chain, number: last.number, sha256: last.sha256 }
}

/// The seals of a tenant, each checked against its digest and the one before it.
async fn seals(pair: &Pair, tenant: &str) -> Vec<Seal> {
    let seals = pair.seen_by(tenant).seals(WHOLE).await.unwrap().items;
    let (mut number, mut previous) = (0, Seal::genesis(&Tenant::named(tenant).unwrap()));
    for seal in &seals {
        assert_eq!((seal.number, seal.previous, seal.sha256), (number + 1, previous, seal.digest()));
        (number, previous) = (seal.number, seal.sha256);
    }
    seals
}

pub async fn seals_have_the_ends_of_chains_that_grew(pair: &mut Pair) {
    let (place, store) = (pair.values.clone(), pair.store.clone());
    let [one, two] = [place.stored_job(&store).await.id, place.stored_job(&store).await.id];
    let other = place.stored_job(&pair.seen_by("other")).await.id;
    let tenant = Tenant::default();
    pair.keys_of(&tenant).insert_key(Arc::new(api_key(&place, &tenant, None)), None).await.unwrap();
    let first = sealed(pair, 4).await;
    assert!(first.iter().all(WholeSeal::is_sound));
    let of_tenant = store.audit(Chain::Tenant, WHOLE).await.unwrap().items;
    let of_other = pair.seen_by("other").audit(Chain::Job(other), WHOLE).await.unwrap().items;
    let expected = [
        head_of(one, &entries(&store, one).await),
        head_of(two, &entries(&store, two).await),
        head_of(other, &of_other),
        head_of(Chain::Tenant.id(&tenant), &of_tenant),
    ];
    assert_eq!(heads(&first), BTreeSet::from(expected));
    for seal in &first {
        let whose = if seal.heads.iter().any(|head| head.chain == other) { "other" } else { "default" };
        assert_eq!(seal.seal.tenant.as_str(), whose);
        assert_eq!(seal.seal.root, root_of(&seal.heads));
        assert!(seal.seal.signed.unwrap().is_of(&seal.seal.sha256));
    }
    // what did not grow is not sealed again, and not before its time
    let nothing = pair.handles[0].seal_audit(sealing(place.now())).await.unwrap().unwrap();
    assert_eq!(nothing, []);
    let patch = JobPatch { name: Some("pinion".to_owned()), ..JobPatch::default() };
    store.patch_job(two, patch, Precondition::None, place.now()).await.unwrap();
    place.stored_iteration(&store, two).await;
    let newest = first.iter().map(|seal| seal.seal.at).max().unwrap();
    let early = Sealing { unless_since: newest - SignedDuration::from_secs(1), ..sealing(place.now()) };
    assert_eq!(pair.handles[0].seal_audit(early).await.unwrap().unwrap(), []);
    let second = sealed(pair, 1).await;
    assert_eq!(heads(&second), BTreeSet::from([head_of(two, &entries(&store, two).await)]));

    let listed = seals(pair, "default").await;
    let made = first.iter().chain(&second).map(|seal| seal.seal.clone()).filter(|seal| seal.tenant == tenant);
    assert_eq!(listed, made.collect::<Vec<_>>());
    assert_eq!(seals(pair, "other").await.len(), 1);
    assert_eq!(seals(pair, "nobody").await, []);
    let page = store.seals(PageRequest { limit: 1, after: None }).await.unwrap();
    assert_eq!(page.items, listed[..1]);
    let next = store.seals(PageRequest { limit: 1, after: page.next }).await.unwrap();
    assert_eq!(next.items, listed[1..2]);
    // a clock that was set back does not turn the order round
    place.stored_iteration(&store, one).await;
    let early = Sealing { at: "2020-01-01T00:00:00Z".parse().unwrap(), key: None, unless_since: Timestamp::MAX };
    let mut third = Vec::new();
    while third.is_empty() {
        third = pair.handles[1].seal_audit(early.clone()).await.unwrap().unwrap();
    }
    assert!(third[0].seal.at > listed[1].at && third[0].seal.signed.is_none() && third[0].is_sound());
    assert_eq!(heads(&third), BTreeSet::from([head_of(one, &entries(&store, one).await)]));
}

/// While others write, whoever seals.
pub async fn every_head_is_sealed_once(pair: &mut Pair) {
    let (place, store) = (pair.values.clone(), pair.store.clone());
    let jobs: Vec<Uuid> = [place.stored_job(&store).await.id, place.stored_job(&store).await.id].into();
    let mut tasks = JoinSet::new();
    for k in 0..120_usize {
        let (place, store, job) = (place.clone(), pair.handles[k % 2].of(&caller("default")), jobs[k / 2 % 2]);
        tasks.spawn(async move { store.insert_iteration(place.iteration(job), None).await.map(drop) });
        let (handle, at) = (pair.handles[k % 2].clone(), pair.values.now());
        if k % 10 == 0 {
            tasks.spawn(async move { handle.seal_audit(sealing(at)).await.map(drop) });
        }
    }
    for outcome in tasks.join_all().await {
        outcome.unwrap();
    }
    let mut last = BTreeMap::new();
    for job in &jobs {
        last.insert(*job, head_of(*job, &entries(&store, *job).await));
    }
    let begun = Instant::now();
    loop {
        pair.handles[0].seal_audit(sealing(place.now())).await.unwrap();
        let sealed = pair.ground.scalar("SELECT count(*) FROM audit_sealed WHERE number = 61").await;
        if sealed == 2 {
            break;
        }
        assert!(begun.elapsed() < Duration::from_secs(60), "{sealed} of 2 ends are sealed");
    }
    let all = pair.ground.scalar("SELECT count(*) FROM audit_sealed").await;
    let heads = pair.ground.scalar("SELECT count(*) FROM (SELECT DISTINCT chain, number FROM audit_sealed) AS h").await;
    assert_eq!(all, heads, "a head was sealed twice");
    let told: u64 = seals(pair, "default").await.iter().map(|seal| seal.heads).sum();
    assert_eq!(told, all as u64);
    assert!(last.values().all(|head| head.number == 61));
}

pub async fn entries_are_unsealed_until_a_seal_holds_them(pair: &mut Pair) {
    let (place, store) = (pair.values.clone(), pair.store.clone());
    let unsealed = async || pair.handles[0].unsealed().await.unwrap();
    let before = unsealed().await;
    assert_eq!(before.oldest, None);
    let job = place.stored_job(&store).await.id;
    let one = unsealed().await;
    let oldest = one.oldest.unwrap();
    assert!(before.next <= oldest && oldest < one.next, "{before:?} {one:?}");
    place.stored_iteration(&store, job).await;
    let two = unsealed().await;
    assert!(two.oldest == Some(oldest) && two.next > one.next, "{one:?} {two:?}");
    sealed(pair, 1).await;
    assert_eq!(unsealed().await.oldest, None);
    place.stored_iteration(&store, job).await;
    let next = unsealed().await.oldest.unwrap();
    assert!(next >= two.next, "{next} {two:?}");
}

/// SQL that writes the chain of a job anew from an entry on, made by somebody else: whoever owns
/// the database can do so, and nothing within the chain tells.
pub fn rewritten(pair: &Pair, job: Uuid, entries: &[Entry], from: u64) -> String {
    let mut head = Head::before(Chain::Job(job), &Tenant::default());
    let mut sql = String::new();
    for entry in entries {
        let mut entry = entry.clone();
        if entry.number >= from {
            (entry.actor, entry.previous) = ("nobody".into(), head.sha256);
            entry.sha256 = entry.digest();
            let [previous, sha256] = [entry.previous, entry.sha256].map(|digest| pair.ground.literal(&digest));
            let chain = pair.ground.id(job);
            sql += &format!(
                "UPDATE audit SET actor = 'nobody', previous = {previous}, sha256 = {sha256}
                 WHERE chain = {chain} AND number = {};",
                entry.number
            );
        }
        head = Head { number: entry.number, sha256: entry.sha256 };
    }
    sql
}

pub async fn a_rewritten_chain_is_convicted_by_its_seals(pair: &mut Pair) {
    let (place, store) = (pair.values.clone(), pair.store.clone());
    let job = place.stored_job(&store).await.id;
    place.stored_iteration(&store, job).await;
    sealed(pair, 1).await;
    place.stored_iteration(&store, job).await;
    place.stored_iteration(&store, job).await;
    let told = entries(&store, job).await;
    let verify = async || store.verify_audit(Chain::Job(job)).await.unwrap();
    let intact = verify().await;
    assert!(matches!(intact, Verdict::Intact { entries: 4, .. }), "{intact:?}");
    // behind the seal nobody knows better yet
    pair.ground.intrude(rewritten(pair, job, &told, 3)).await;
    assert!(matches!(verify().await, Verdict::Intact { entries: 4, .. }));
    pair.ground.intrude(rewritten(pair, job, &told, 1)).await;
    assert_eq!(verify().await, Verdict::Broken { number: 2, what: What::Seal });
    // nor does it help to leave out what was sealed
    pair.ground.intrude("DELETE FROM audit WHERE number > 1".to_owned()).await;
    let shorter = verify().await;
    assert!(matches!(shorter, Verdict::Broken { number: 2, .. }), "{shorter:?}");
}
