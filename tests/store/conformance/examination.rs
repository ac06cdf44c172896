//! The whole audit, gone through from outside: what is found, and by which evidence.

use std::sync::Arc;

use flankfit::jobs::{
    Precondition, Tenant,
    audit::{Chain, Evidence, Fault, Findings, Head, Place, SealedHead, SigningKey, What, WholeSeal, examine, root_of},
};
use uuid::Uuid;

use super::{
    audit::entries,
    keys::key as api_key,
    pair::Pair,
    seals::{key, rewritten, sealed},
};

async fn examined(pair: &Pair, job: Option<Uuid>, evidence: &Evidence) -> Findings {
    let auditor = pair.handles[0].auditor();
    examine(&*auditor, job, evidence).await.unwrap().expect("there is such a job")
}

fn kept(seals: &[WholeSeal]) -> Evidence {
    Evidence::of(seals.to_vec(), None).unwrap()
}

fn fault(place: Place, number: u64, what: What) -> Fault {
    Fault { tenant: Tenant::default(), place, number, what }
}

/// A job with three entries that are sealed.
async fn sealed_job(pair: &Pair) -> (Uuid, Vec<WholeSeal>) {
    let job = pair.values.stored_job(&pair.store).await.id;
    pair.values.stored_iteration(&pair.store, job).await;
    pair.values.stored_iteration(&pair.store, job).await;
    (job, sealed(pair, 1).await)
}

pub async fn all_that_is_as_it_was_written_is_intact(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::named("other").unwrap());
    let (job, mut seals) = sealed_job(pair).await;
    pair.keys_of(&tenant).insert_key(Arc::new(api_key(&place, &tenant, None)), None).await.unwrap();
    let gone = place.stored_job(&pair.seen_by("other")).await.id;
    pair.seen_by("other").delete_job(gone, Precondition::None).await.unwrap();
    seals.extend(sealed(pair, 2).await);
    // one that is in no seal yet
    place.stored_iteration(&pair.store, job).await;
    let found = examined(pair, None, &kept(&seals)).await;
    let count = seals.len() as u64;
    assert_eq!(
        found,
        Findings { chains: 4, entries: 4 + 1 + 2, seals: count, has_chains: true, ..Findings::default() }
    );
    let found = examined(pair, Some(gone), &Evidence::default()).await;
    assert_eq!((found.chains, found.entries, found.faults), (1, 2, vec![]));
    let auditor = pair.handles[1].auditor();
    assert_eq!(examine(&*auditor, Some(place.id()), &Evidence::default()).await.unwrap(), None);
    // all are signed by one key, and by no other
    let signed = seals[0].seal.signed.unwrap().public_key;
    let by = |key| Evidence::of(Vec::new(), Some(key)).unwrap();
    assert_eq!(examined(pair, None, &by(signed)).await.faults, []);
    assert_eq!(examined(pair, Some(job), &by([7; 32])).await.faults, [fault(Place::Seals, 1, What::Seal)]);
}

/// SQL that puts a seal in the place of the first one of the default tenant.
fn replaced(pair: &Pair, WholeSeal { seal, heads }: &WholeSeal) -> String {
    let [root, previous, sha256] = [&seal.root, &seal.previous, &seal.sha256].map(|bytes| pair.ground.literal(bytes));
    let signed = seal.signed.unwrap();
    let [signature, key] = [signed.signature.as_slice(), &signed.public_key].map(|bytes| pair.ground.literal(bytes));
    let head = &heads[0];
    format!(
        "UPDATE audit_seals SET root = {root}, previous = {previous}, sha256 = {sha256}, signature = {signature},
             public_key = {key} WHERE tenant = 'default' AND number = {};
         UPDATE audit_sealed SET number = {}, sha256 = {} WHERE tenant = 'default' AND seal = {}",
        seal.number,
        head.number,
        pair.ground.literal(&head.sha256),
        seal.number,
    )
}

/// Who owns the database writes the chain anew, and the seals as well: only what was kept elsewhere
/// tells.
pub async fn what_was_kept_elsewhere_convicts(pair: &mut Pair) {
    let (job, seals) = sealed_job(pair).await;
    let [old] = &seals[..] else { panic!("{seals:?}") };
    let told = entries(&pair.store, job).await;
    pair.ground.intrude(rewritten(pair, job, &told, 2)).await;
    let chain = |number| fault(Place::Chain(Chain::Job(job)), number, What::Seal);
    assert_eq!(examined(pair, None, &Evidence::default()).await.faults, [chain(3)]);
    let mut head = Head::before(Chain::Job(job), &Tenant::default());
    for mut entry in told {
        if entry.number >= 2 {
            (entry.actor, entry.previous) = ("nobody".into(), head.sha256);
            entry.sha256 = entry.digest();
        }
        head = Head { number: entry.number, sha256: entry.sha256 };
    }
    let heads = vec![SealedHead { chain: job, number: head.number, sha256: head.sha256 }];
    let own = rcgen_key();
    let forged = WholeSeal::next(Tenant::default(), None, heads, old.seal.at, Some(&own));
    pair.ground.intrude(replaced(pair, &forged)).await;
    assert_eq!(examined(pair, None, &Evidence::default()).await.faults, []);
    let expected = [fault(Place::Seals, 1, What::Seal), chain(3)];
    assert_eq!(examined(pair, None, &kept(&seals)).await.faults, expected);
    assert_eq!(examined(pair, Some(job), &kept(&seals)).await.faults, expected);
    // seals as the interface answers them, without their heads
    let bare = [WholeSeal { heads: Vec::new(), ..old.clone() }];
    assert_eq!(examined(pair, None, &kept(&bare)).await.faults, expected[..1]);
    // the key is another
    let evidence = Evidence::of(Vec::new(), old.seal.signed.map(|signed| signed.public_key)).unwrap();
    assert_eq!(examined(pair, None, &evidence).await.faults, expected[..1]);
    // nothing is left of any of it
    let all = "DELETE FROM audit; DELETE FROM audit_sealed; DELETE FROM audit_seals";
    pair.ground.intrude(all.to_owned()).await;
    let what = What::Entry;
    let expected = [fault(Place::Seals, 1, what), fault(Place::Chain(Chain::Job(job)), 1, what)];
    assert_eq!(examined(pair, None, &kept(&seals)).await.faults, expected);
}

/// Another key than that of the server.
fn rcgen_key() -> SigningKey {
    let pair = rcgen::KeyPair::generate_for(&rcgen::PKCS_ED25519).unwrap();
    SigningKey::from_pkcs8(&pair.serialize_der()).unwrap()
}

pub async fn changed_seals_are_found_at_their_numbers(pair: &mut Pair) {
    let (job, first) = sealed_job(pair).await;
    pair.values.stored_iteration(&pair.store, job).await;
    let second = sealed(pair, 1).await.remove(0);
    let first = first.into_iter().next().unwrap();
    assert_eq!((first.seal.number, second.seal.number), (1, 2));
    let keep = "CREATE TABLE seals_kept AS SELECT * FROM audit_seals;
                CREATE TABLE sealed_kept AS SELECT * FROM audit_sealed";
    pair.ground.intrude(keep.to_owned()).await;
    // one that was made of other heads, by whoever has the key
    let mut other = second.clone();
    other.heads[0].number = 2;
    other.seal.root = root_of(&other.heads);
    other.seal.sha256 = other.seal.digest();
    other.seal.signed = Some(key().sign(&other.seal.sha256));
    let mut unlinked = second.clone();
    unlinked.seal.previous = [1; 32];
    unlinked.seal.sha256 = unlinked.seal.digest();
    unlinked.seal.signed = Some(key().sign(&unlinked.seal.sha256));
    let chain = |number, what| fault(Place::Chain(Chain::Job(job)), number, what);
    let seal = |number, what| fault(Place::Seals, number, what);
    let cases: [(String, Vec<Fault>); 8] = [
        ("UPDATE audit_seals SET root = sha256 WHERE number = 1".into(), vec![seal(1, What::Entry)]),
        ("UPDATE audit_seals SET heads = 7 WHERE number = 2".into(), vec![seal(2, What::Entry)]),
        ("UPDATE audit_seals SET signature = NULL WHERE number = 2".into(), vec![seal(2, What::Seal)]),
        (replaced(pair, &unlinked), vec![seal(2, What::Link)]),
        (
            "UPDATE audit_sealed SET sha256 = (SELECT sha256 FROM sealed_kept WHERE seal = 2) WHERE seal = 1".into(),
            vec![seal(1, What::Content), chain(3, What::Seal)],
        ),
        ("DELETE FROM audit_sealed WHERE seal = 2".into(), vec![seal(2, What::Content)]),
        (
            "DELETE FROM audit_sealed WHERE seal = 1; DELETE FROM audit_seals WHERE number = 1".into(),
            vec![seal(1, What::Entry)],
        ),
        (replaced(pair, &other), vec![chain(2, What::Seal)]),
    ];
    for (sql, expected) in cases {
        pair.ground.intrude(sql.clone()).await;
        assert_eq!(examined(pair, None, &Evidence::default()).await.faults, expected, "{sql}");
        let restore =
            "DELETE FROM audit_sealed; DELETE FROM audit_seals; INSERT INTO audit_seals SELECT * FROM seals_kept;
                       INSERT INTO audit_sealed SELECT * FROM sealed_kept";
        pair.ground.intrude(restore.to_owned()).await;
        assert_eq!(examined(pair, None, &kept(&[first.clone(), second.clone()])).await.faults, []);
    }
    // evidence that is not as it was made, or that contradicts itself, proves nothing
    let mut forged = first.clone();
    forged.heads[0].number += 1;
    assert_eq!(Evidence::of(vec![first.clone(), forged], None).err(), Some(1));
    assert_eq!(Evidence::of(vec![second.clone(), other], None).err(), Some(1));
    assert_eq!(Evidence::of(vec![first], Some([7; 32])).err(), Some(0));
}
