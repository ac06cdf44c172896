//! Changes of keys and tenants are entered in the chain of the tenant, and whoever changes their
//! rows behind the store's back is found.

use std::sync::Arc;

use flankfit::jobs::{
    Caller, KeyPatch, NewKey, NewPlant, PlantPatch, Precondition, RepositoryError, Rotation, Tenant,
    audit::{Chain, Entry, Head, Verdict, What, key_digest, plant_digest},
};
use tokio::task::JoinSet;

use super::{
    keys::{HOUR, key, plant},
    pair::Pair,
};
use crate::support::{WHOLE, caller, receipt};

/// The entries of a tenant, each checked against its digest and the one before it.
async fn entries(pair: &Pair, tenant: &Tenant) -> Vec<Entry> {
    let entries = pair.seen_by(tenant.as_str()).audit(Chain::Tenant, WHOLE).await.unwrap().items;
    let mut head = Head::before(Chain::Tenant, tenant);
    for entry in &entries {
        assert_eq!((entry.number, entry.previous, entry.sha256), (head.number + 1, head.sha256, entry.digest()));
        head = Head { number: entry.number, sha256: entry.sha256 };
    }
    entries
}

async fn verdict(pair: &Pair, tenant: &Tenant) -> Verdict {
    pair.seen_by(tenant.as_str()).verify_audit(Chain::Tenant).await.unwrap()
}

type Told = (String, String, String, Vec<String>);

fn told(entry: &Entry) -> Told {
    let names = entry.contents.iter().map(|(name, _)| name.to_owned()).collect();
    (entry.action.to_string(), entry.target.clone(), entry.outcome.to_string(), names)
}

fn expected(action: &str, target: String, outcome: &str, names: &[String]) -> Told {
    let mut names = names.to_vec();
    names.sort_unstable();
    (action.to_owned(), target, outcome.to_owned(), names)
}

fn named(new: &NewKey) -> String {
    format!("key.{}", new.key.id)
}

fn path(new: &NewKey) -> String {
    format!("/v1/keys/{}", new.key.id)
}

pub async fn changes_of_keys_and_tenants_are_entered(pair: &mut Pair) {
    let (place, name) = (pair.values.clone(), Tenant::named("plant-7").unwrap());
    let root = pair.keys_of(&Tenant::root());
    let first = NewPlant { plant: plant(&place, "plant-7"), key: key(&place, &name, None) };
    root.insert_plant(Arc::new(first.clone()), None).await.unwrap();
    let tenant = "/v1/tenants/plant-7".to_owned();
    let mut all = vec![expected("tenant.create", tenant.clone(), "stored", &[named(&first.key), "tenant".into()])];

    let keys = pair.keys_of(&name);
    let one = key(&place, &name, None);
    keys.insert_key(Arc::new(one.clone()), Some(receipt("k", "POST /v1/keys"))).await.unwrap();
    all.push(expected("key.create", path(&one), "stored", &[named(&one)]));
    let patch = KeyPatch { name: Some("other".to_owned()), expires_at: None };
    keys.patch_key(one.key.id, patch.clone(), Precondition::None, place.now()).await.unwrap();
    all.push(expected("key.change", path(&one), "changed", &[named(&one)]));
    let rotation = Rotation { of: one.key.id, old_ends: place.now() + HOUR, new: key(&place, &name, None) };
    let two = rotation.new.clone();
    keys.rotate_key(Arc::new(rotation), None).await.unwrap();
    all.push(expected("key.rotate", path(&one), "stored", &[named(&one), named(&two)]));
    keys.revoke_key(one.key.id, place.now()).await.unwrap();
    all.push(expected("key.revoke", path(&one), "changed", &[named(&one)]));
    let (suspended, now) = (PlantPatch { description: None, suspended: Some(true) }, place.now());
    let after = root.patch_plant(name.clone(), suspended.clone(), Precondition::None, now).await.unwrap();
    all.push(expected("tenant.change", tenant, "changed", &["tenant".into()]));
    let entered = entries(pair, &name).await;
    assert_eq!(entered.iter().map(told).collect::<Vec<_>>(), all);
    assert_eq!(entered[1].contents.get(&named(&one)), Some(&key_digest(&one)));
    assert_eq!(entered[5].contents.get("tenant"), Some(&plant_digest(&after)));

    // what is refused, and what changes nothing, is not entered
    let seen = Precondition::AnyOf(vec![77]);
    assert!(matches!(
        keys.insert_key(Arc::new(key(&place, &name, None)), Some(receipt("k", "POST /v1/keys"))).await,
        Err(RepositoryError::KeyTaken)
    ));
    assert!(keys.patch_key(one.key.id, patch, Precondition::None, place.now()).await.is_err());
    assert!(keys.patch_key(two.key.id, KeyPatch::default(), seen, place.now()).await.is_err());
    let late = Rotation { of: one.key.id, old_ends: place.now(), new: key(&place, &name, None) };
    assert!(keys.rotate_key(Arc::new(late), None).await.is_err());
    assert!(root.insert_plant(Arc::new(first), None).await.is_err());
    keys.patch_key(two.key.id, KeyPatch::default(), Precondition::None, place.now()).await.unwrap();
    keys.revoke_key(one.key.id, place.now()).await.unwrap();
    root.patch_plant(name.clone(), suspended, Precondition::None, place.now()).await.unwrap();
    assert_eq!(entries(pair, &name).await, entered);
    // uses are no changes
    pair.handles[0].credentials().note_uses(vec![(two.key.id, place.now())]).await.unwrap();
    let head = entered.last().map(|entry| entry.sha256);
    assert_eq!(verdict(pair, &name).await, Verdict::Intact { entries: 6, head });
    assert_eq!(entries(pair, &Tenant::default()).await, []);
}

/// A tenant that is older than the entries begins with the keys that are found.
pub async fn keys_from_before_begin_the_chain(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let keys = pair.keys_of(&tenant);
    let older = [(); 2].map(|()| key(&place, &tenant, None));
    for new in &older {
        keys.insert_key(Arc::new(new.clone()), None).await.unwrap();
    }
    pair.ground.intrude("DELETE FROM audit".to_owned()).await;
    assert_eq!(verdict(pair, &tenant).await, Verdict::Intact { entries: 0, head: None });
    // a refusal begins nothing
    let seen = Precondition::AnyOf(vec![77]);
    assert!(keys.patch_key(older[0].key.id, KeyPatch::default(), seen, place.now()).await.is_err());
    assert_eq!(entries(pair, &tenant).await, []);
    let new = key(&place, &tenant, None);
    keys.insert_key(Arc::new(new.clone()), None).await.unwrap();
    let entered: Vec<_> = entries(pair, &tenant).await.iter().map(told).collect();
    let begun = expected("audit.begin", "/v1/tenants/default".into(), "found", &older.each_ref().map(named));
    assert_eq!(entered, [begun, expected("key.create", path(&new), "stored", &[named(&new)])]);
    keys.revoke_key(older[1].key.id, place.now()).await.unwrap();
    assert!(matches!(verdict(pair, &tenant).await, Verdict::Intact { entries: 3, .. }));
    let intruded = format!("UPDATE api_keys SET scopes = 'tenants' WHERE id = '{}'", older[0].key.id);
    pair.ground.intrude(intruded).await;
    assert_eq!(verdict(pair, &tenant).await, Verdict::Broken { number: 1, what: What::Content });
}

pub async fn changed_keys_are_found_at_their_numbers(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let keys = pair.keys_of(&tenant);
    // entries 1 and 2 keys, 3 the end of the first, 4 a change of the tenant
    let [one, two] = [(); 2].map(|()| key(&place, &tenant, None));
    for new in [&one, &two] {
        keys.insert_key(Arc::new(new.clone()), None).await.unwrap();
    }
    keys.revoke_key(one.key.id, place.now()).await.unwrap();
    let patch = PlantPatch { description: Some("hall 2".to_owned()), suspended: None };
    pair.keys_of(&Tenant::root()).patch_plant(tenant.clone(), patch, Precondition::None, place.now()).await.unwrap();
    assert!(matches!(verdict(pair, &tenant).await, Verdict::Intact { entries: 4, .. }));
    pair.ground.intrude("CREATE TABLE kept AS SELECT * FROM api_keys".to_owned()).await;
    let of = |new: &NewKey, what: &str| format!("UPDATE api_keys SET {what} WHERE id = '{}'", new.key.id);
    let planted = "INSERT INTO api_keys (id, tenant, name, scopes, san, version, created_at)
                   SELECT '00000000000000ff', tenant, name, scopes, 'cmm7.plant.example', 1, created_at FROM api_keys";
    let cases = [
        (of(&one, "revoked_at = NULL"), 3),
        (of(&two, "sha256 = (SELECT sha256 FROM kept WHERE revoked_at IS NOT NULL)"), 2),
        (of(&two, "scopes = 'tenants'"), 2),
        (of(&two, "expires_at = NULL"), 2),
        (of(&two, "replaced_by = id"), 2),
        (of(&two, "name = 'other'"), 2),
        (of(&two, "tenant = 'other'"), 2),
        (format!("DELETE FROM api_keys WHERE id = '{}'", two.key.id), 2),
        (format!("{planted} LIMIT 1"), 5),
    ];
    for (sql, number) in cases {
        pair.ground.intrude(sql.clone()).await;
        assert_eq!(verdict(pair, &tenant).await, Verdict::Broken { number, what: What::Content }, "{sql}");
        pair.ground.intrude("DELETE FROM api_keys; INSERT INTO api_keys SELECT * FROM kept".to_owned()).await;
        assert!(matches!(verdict(pair, &tenant).await, Verdict::Intact { entries: 4, .. }));
    }
    pair.ground.intrude("UPDATE tenants SET suspended = NOT suspended WHERE name = 'default'".to_owned()).await;
    assert_eq!(verdict(pair, &tenant).await, Verdict::Broken { number: 4, what: What::Content });
}

/// A key that was changed more often than is told, and one that nothing is told of.
pub async fn missing_last_entries_of_keys_are_found_at_their_numbers(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::named("plant-7").unwrap());
    let root = pair.keys_of(&Tenant::root());
    // entries: 1 the tenant with its first key, 2 another one, which 3 changes, 4 replaces and 5
    // ends; 6 changes the tenant
    let first = NewPlant { plant: plant(&place, "plant-7"), key: key(&place, &tenant, None) };
    root.insert_plant(Arc::new(first), None).await.unwrap();
    let keys = pair.keys_of(&tenant);
    let one = key(&place, &tenant, None);
    let id = one.key.id;
    keys.insert_key(Arc::new(one), None).await.unwrap();
    let patch = KeyPatch { name: Some("other".to_owned()), expires_at: None };
    keys.patch_key(id, patch, Precondition::None, place.now()).await.unwrap();
    // it ends earlier all the same, and has the key that replaced it
    let rotation = Rotation { of: id, old_ends: place.now() + HOUR * 2, new: key(&place, &tenant, None) };
    keys.rotate_key(Arc::new(rotation), None).await.unwrap();
    keys.revoke_key(id, place.now()).await.unwrap();
    let patch = PlantPatch { description: Some("hall 2".to_owned()), suspended: None };
    root.patch_plant(tenant.clone(), patch, Precondition::None, place.now()).await.unwrap();
    pair.ground.intrude("CREATE TABLE audit_kept AS SELECT * FROM audit".to_owned()).await;
    for last in 1..6 {
        pair.ground.intrude(format!("DELETE FROM audit WHERE number > {last}")).await;
        let missing = Verdict::Broken { number: last + 1, what: What::Content };
        assert_eq!(verdict(pair, &tenant).await, missing);
        let again = format!("INSERT INTO audit SELECT * FROM audit_kept WHERE number > {last}");
        pair.ground.intrude(again).await;
        assert!(matches!(verdict(pair, &tenant).await, Verdict::Intact { entries: 6, .. }));
    }
}

/// At both handles at once.
pub async fn chains_of_keys_have_no_gaps(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let mut tasks = JoinSet::new();
    for k in 0..40 {
        let (keys, new) = (pair.handles[k % 2].keys(&caller("default")), key(&place, &tenant, None));
        let name = Tenant::named(&format!("plant-{k}")).unwrap();
        let caller = Caller { tenant: Tenant::root(), ..caller("default") };
        let (root, first) = (pair.handles[k % 2].keys(&caller), key(&place, &name, None));
        let made = NewPlant { plant: plant(&place, name.as_str()), key: first };
        let now = place.now();
        tasks.spawn(async move {
            let id = new.key.id;
            keys.insert_key(Arc::new(new), None).await?;
            keys.revoke_key(id, now).await?;
            root.insert_plant(Arc::new(made), None).await.map(drop)
        });
    }
    for outcome in tasks.join_all().await {
        outcome.unwrap();
    }
    assert_eq!(entries(pair, &tenant).await.len(), 80);
    assert_eq!(entries(pair, &Tenant::named("plant-39").unwrap()).await.len(), 1);
}
