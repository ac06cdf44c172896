//! Keys and tenants.

use std::{array::from_fn, sync::Arc};

use flankfit::jobs::{
    ApiKey, Credentials, KeyId, KeyPatch, Keys, NewKey, NewPlant, PageRequest, Plant, PlantPatch, Precondition,
    RepositoryError, Resource, Role, Rotation, San, Stored, Tenant,
};
use jiff::SignedDuration;

use super::pair::Pair;
use crate::support::{Values, WHOLE, receipt};

pub const HOUR: SignedDuration = SignedDuration::from_hours(1);

pub fn key(place: &Values, tenant: &Tenant, san: Option<&str>) -> NewKey {
    let id = KeyId::of(place.id().as_u64_pair().1.rotate_left(17));
    let key = ApiKey {
        id,
        tenant: tenant.clone(),
        name: "grinder \u{1F642}".to_owned(),
        role: san.is_none().then_some(Role::Engineer),
        scopes: Role::Engineer.scopes(),
        san: san.and_then(San::named),
        version: 1,
        created_at: place.now(),
        expires_at: Some(place.now() + HOUR),
        last_used_at: None,
        revoked_at: None,
        replaced_by: None,
    };
    // of two keys never the same
    let sha256 = san.is_none().then(|| from_fn(|k| id.number().to_be_bytes()[k % 8]));
    NewKey { key, sha256 }
}

pub fn plant(place: &Values, name: &str) -> Plant {
    let now = place.now();
    Plant {
        id: place.id(),
        name: Tenant::named(name).unwrap(),
        description: Some("halls A and B".to_owned()),
        suspended: false,
        version: 1,
        created_at: now,
        updated_at: now,
    }
}

async fn stored(keys: &Arc<dyn Keys>, new: NewKey) -> ApiKey {
    let key = new.key.clone();
    assert_eq!(keys.insert_key(Arc::new(new), None).await.unwrap(), Stored { number: 0, version: 1 });
    key
}

fn credentials(pair: &Pair) -> Arc<dyn Credentials> {
    pair.handles[1].credentials()
}

fn refused<T: std::fmt::Debug>(outcome: Result<T, RepositoryError>) -> String {
    outcome.unwrap_err().to_string()
}

pub async fn a_key_is_read_as_it_was_stored(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let keys = pair.keys_of(&tenant);
    assert!(!credentials(pair).has_keys().await.unwrap());
    let new = key(&place, &tenant, None);
    let made = new.key.clone();
    keys.insert_key(Arc::new(new.clone()), Some(receipt("k", "POST /v1/keys"))).await.unwrap();
    assert!(matches!(
        keys.insert_key(Arc::new(key(&place, &tenant, None)), Some(receipt("k", "POST /v1/keys"))).await,
        Err(RepositoryError::KeyTaken)
    ));
    assert!(pair.store.answer("k".to_owned(), "POST /v1/keys".to_owned()).await.unwrap().is_some());
    assert_eq!(keys.key(made.id).await.unwrap(), made);
    let found = credentials(pair).find_key(made.id).await.unwrap().unwrap();
    assert_eq!((found.key.clone(), found.sha256, found.suspended), (made.clone(), new.sha256, false));
    assert!(credentials(pair).find_key(KeyId::of(1)).await.unwrap().is_none());
    assert!(credentials(pair).has_keys().await.unwrap());
    // its uses do not count as changes, and the last one stays
    let (early, late) = (place.now(), place.now());
    for at in [late, early] {
        credentials(pair).note_uses(vec![(made.id, at), (KeyId::of(1), at)]).await.unwrap();
    }
    pair.reopen().await;
    let now = pair.keys_of(&tenant).key(made.id).await.unwrap();
    assert_eq!(now, ApiKey { last_used_at: Some(late), ..made });
}

pub async fn keys_are_changed_rotated_and_revoked(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let keys = pair.keys_of(&tenant);
    let made = stored(&keys, key(&place, &tenant, None)).await;
    let end = place.now() + HOUR * 2;
    let patch = KeyPatch { name: Some("other".to_owned()), expires_at: Some(end) };
    let after = keys.patch_key(made.id, patch.clone(), Precondition::AnyOf(vec![1]), place.now()).await.unwrap();
    assert_eq!(after, ApiKey { name: "other".to_owned(), expires_at: Some(end), version: 2, ..made.clone() });
    let again = keys.patch_key(made.id, patch.clone(), Precondition::None, place.now()).await.unwrap();
    assert_eq!(again.version, 2, "the same once more changes nothing");
    let late = keys.patch_key(made.id, patch.clone(), Precondition::AnyOf(vec![1]), place.now()).await;
    assert!(matches!(late, Err(RepositoryError::VersionMismatch { current: 2 })));

    let ends = place.now() + HOUR;
    let rotation = Rotation { of: made.id, old_ends: ends, new: key(&place, &tenant, None) };
    let new = rotation.new.key.clone();
    keys.rotate_key(Arc::new(rotation), Some(receipt("r", "POST /r"))).await.unwrap();
    let replaced = keys.key(made.id).await.unwrap();
    assert_eq!(
        replaced,
        ApiKey { expires_at: Some(ends), replaced_by: Some(new.id), version: 3, ..after },
        "it says by which it was replaced"
    );
    assert_eq!(keys.key(new.id).await.unwrap(), new);
    // one that ends earlier anyway is not prolonged
    let rotation = Rotation { of: new.id, old_ends: ends + HOUR, new: key(&place, &tenant, None) };
    let last = rotation.new.key.id;
    keys.rotate_key(Arc::new(rotation), None).await.unwrap();
    let found = keys.key(new.id).await.unwrap();
    assert_eq!((found.expires_at, found.replaced_by), (new.expires_at, Some(last)));

    let now = place.now();
    keys.revoke_key(last, now).await.unwrap();
    keys.revoke_key(last, place.now()).await.unwrap();
    let revoked = keys.key(last).await.unwrap();
    assert_eq!((revoked.revoked_at, revoked.version), (Some(now), 2));
    assert!(!credentials(pair).find_key(last).await.unwrap().unwrap().is_valid(now));
    let rotation = Rotation { of: last, old_ends: ends, new: key(&place, &tenant, None) };
    let unborn = rotation.new.key.id;
    assert_eq!(refused(keys.rotate_key(Arc::new(rotation), None).await), "the key is revoked");
    assert_eq!(refused(keys.patch_key(last, patch, Precondition::None, place.now()).await), "the key is revoked");
    assert!(matches!(keys.key(unborn).await, Err(RepositoryError::NotFound(Resource::Key))));
}

/// Whose place another key has taken: a further one would end with it, not when it should.
pub async fn a_replaced_key_is_not_replaced_again(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let keys = pair.keys_of(&tenant);
    let old = stored(&keys, key(&place, &tenant, None)).await;
    let ends = place.now() + HOUR / 2;
    let again = || Rotation { of: old.id, old_ends: ends, new: key(&place, &tenant, None) };
    // of those that ask at once one is heard
    let rotations = [(); 4].map(|()| again());
    let asked = rotations.iter().map(|rotation| keys.rotate_key(Arc::new(rotation.clone()), None));
    let outcomes = futures_util::future::join_all(asked).await;
    assert_eq!(outcomes.iter().filter(|outcome| outcome.is_ok()).count(), 1);
    let replaced = keys.key(old.id).await.unwrap();
    let by = replaced.replaced_by.unwrap();
    let message = format!("key {by} has replaced the key");
    for (rotation, outcome) in rotations.iter().zip(outcomes) {
        let id = rotation.new.key.id;
        assert_eq!((outcome.is_ok(), keys.key(id).await.is_ok()), (id == by, id == by));
        assert!(outcome.err().is_none_or(|error| error.to_string() == message));
    }
    assert_eq!((replaced.expires_at, replaced.version), (Some(ends), 2));
    // it may end earlier, not later
    let patch = |expires_at| KeyPatch { name: None, expires_at: Some(expires_at) };
    let longer = keys.patch_key(old.id, patch(ends + HOUR), Precondition::None, place.now()).await;
    assert_eq!(refused(longer), message);
    let ends = ends - HOUR / 4;
    let patch = KeyPatch { name: Some("old".to_owned()), ..patch(ends) };
    let after = keys.patch_key(old.id, patch, Precondition::None, place.now()).await.unwrap();
    let expected = ApiKey { name: "old".to_owned(), expires_at: Some(ends), version: 3, ..replaced };
    assert_eq!(after, expected);
    // and stays replaced once it has ended
    let mut late = again();
    late.new.key.created_at = ends;
    assert_eq!(refused(keys.rotate_key(Arc::new(late), None).await), message);
    keys.revoke_key(old.id, place.now()).await.unwrap();
    assert_eq!(refused(keys.rotate_key(Arc::new(again()), None).await), message);
    assert_eq!(keys.key(old.id).await.unwrap().replaced_by, Some(by));
}

pub async fn ended_keys_stay_ended(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let keys = pair.keys_of(&tenant);
    let made = stored(&keys, key(&place, &tenant, None)).await;
    let end = made.expires_at.unwrap();
    let message = format!("the key ended at {end}");
    for patch in [
        KeyPatch { name: None, expires_at: Some(end + HOUR) },
        KeyPatch { name: Some("other".to_owned()), expires_at: None },
    ] {
        assert_eq!(refused(keys.patch_key(made.id, patch.clone(), Precondition::None, end).await), message);
    }
    let mut rotation = Rotation { of: made.id, old_ends: end + HOUR, new: key(&place, &tenant, None) };
    rotation.new.key.created_at = end;
    assert_eq!(refused(keys.rotate_key(Arc::new(rotation.clone()), None).await), message);
    assert_eq!(keys.keys(WHOLE).await.unwrap().items, std::slice::from_ref(&made));
    // until then it goes on
    let patch = KeyPatch { name: None, expires_at: Some(end + HOUR) };
    let just = end - SignedDuration::from_micros(1);
    let after = keys.patch_key(made.id, patch, Precondition::None, just).await.unwrap();
    assert_eq!(after, ApiKey { expires_at: Some(end + HOUR), version: 2, ..made });
    keys.rotate_key(Arc::new(rotation), None).await.unwrap();
}

pub async fn another_tenants_keys_do_not_exist(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let (keys, root) = (pair.keys_of(&tenant), Tenant::root());
    let made = stored(&keys, key(&place, &tenant, None)).await;
    for other in [Tenant::named("other").unwrap(), root.clone()] {
        let others = pair.keys_of(&other);
        let missing = |outcome: Result<(), RepositoryError>| {
            assert!(matches!(outcome, Err(RepositoryError::NotFound(Resource::Key))), "{outcome:?}");
        };
        missing(others.key(made.id).await.map(drop));
        missing(others.patch_key(made.id, KeyPatch::default(), Precondition::None, place.now()).await.map(drop));
        missing(others.revoke_key(made.id, place.now()).await);
        let rotation = Rotation { of: made.id, old_ends: place.now(), new: key(&place, &other, None) };
        missing(others.rotate_key(Arc::new(rotation), None).await.map(drop));
        assert_eq!(others.keys(WHOLE).await.unwrap().items, []);
    }
    assert_eq!(keys.keys(WHOLE).await.unwrap().items, [made]);
    // a key is its maker's tenant's, whatever it says
    let of_root = pair.keys_of(&root);
    let strange = stored(&of_root, key(&place, &tenant, None)).await;
    assert!(of_root.key(strange.id).await.unwrap().tenant.is_root());
}

pub async fn a_name_of_certificates_is_of_one_key(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let keys = pair.keys_of(&tenant);
    let san = San::named("press7.example").unwrap();
    assert!(credentials(pair).find_certificate(san.clone()).await.unwrap().is_none());
    let first = stored(&keys, key(&place, &tenant, Some("press7.example"))).await;
    let second = || Arc::new(key(&place, &tenant, Some("press7.example")));
    assert!(matches!(keys.insert_key(second(), None).await, Err(RepositoryError::SanTaken)));
    let found = credentials(pair).find_certificate(san.clone()).await.unwrap().unwrap();
    assert_eq!((found.key, found.sha256), (first.clone(), None));
    let rotation = Rotation { of: first.id, old_ends: place.now(), new: key(&place, &tenant, None) };
    assert!(matches!(keys.rotate_key(Arc::new(rotation), None).await, Err(RepositoryError::NoSecret)));
    keys.revoke_key(first.id, place.now()).await.unwrap();
    let found = credentials(pair).find_certificate(san.clone()).await.unwrap().unwrap();
    assert!(found.key.revoked_at.is_some());
    let new = second();
    keys.insert_key(new.clone(), None).await.unwrap();
    assert_eq!(credentials(pair).find_certificate(san).await.unwrap().unwrap().key, new.key);
}

pub async fn keys_come_in_pages_newest_first(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let keys = pair.keys_of(&tenant);
    let now = place.now();
    let mut made = Vec::new();
    for k in 0..7 {
        let mut new = key(&place, &tenant, None);
        // some of one moment, which are distinguished by their ids
        if k < 4 {
            new.key.created_at = now;
        }
        made.push(stored(&keys, new).await);
    }
    made.sort_by_key(|key| std::cmp::Reverse((key.created_at, key.id)));
    let (mut after, mut seen) = (None, Vec::new());
    loop {
        let page = keys.keys(PageRequest { limit: 2, after }).await.unwrap();
        assert!(page.items.len() == 2 || page.next.is_none());
        seen.extend(page.items);
        after = page.next;
        if after.is_none() {
            break;
        }
    }
    assert_eq!(seen, made);
}

pub async fn tenants_begin_with_a_key(pair: &mut Pair) {
    let (place, root) = (pair.values.clone(), Tenant::root());
    let keys = pair.keys_of(&root);
    let names = |plants: Vec<Plant>| plants.into_iter().map(|plant| plant.name.as_str().to_owned()).collect::<Vec<_>>();
    assert_eq!(names(keys.plants(WHOLE).await.unwrap().items), ["default"]);
    let name = Tenant::named("plant-7").unwrap();
    assert!(matches!(keys.plant(name.clone()).await, Err(RepositoryError::NotFound(Resource::Tenant))));
    let new = || Arc::new(NewPlant { plant: plant(&place, name.as_str()), key: key(&place, &name, None) });
    let first = new();
    keys.insert_plant(first.clone(), Some(receipt("t", "POST /v1/tenants"))).await.unwrap();
    let again = new();
    assert!(matches!(keys.insert_plant(again.clone(), None).await, Err(RepositoryError::TenantExists)));
    assert!(credentials(pair).find_key(again.key.key.id).await.unwrap().is_none());
    assert_eq!(keys.plant(name.clone()).await.unwrap(), first.plant);
    assert_eq!(pair.keys_of(&name).keys(WHOLE).await.unwrap().items, std::slice::from_ref(&first.key.key));
    assert_eq!(names(keys.plants(WHOLE).await.unwrap().items), ["plant-7", "default"]);
    let page = keys.plants(PageRequest { limit: 1, after: None }).await.unwrap();
    let next = keys.plants(PageRequest { limit: 1, after: page.next }).await.unwrap();
    assert_eq!(
        (names(page.items), names(next.items), next.next),
        (vec!["plant-7".into()], vec!["default".into()], None)
    );

    let (patch, now) = (PlantPatch { description: None, suspended: Some(true) }, place.now());
    let after = keys.patch_plant(name.clone(), patch.clone(), Precondition::AnyOf(vec![1]), now).await.unwrap();
    assert_eq!(after, Plant { suspended: true, version: 2, updated_at: now, ..first.plant.clone() });
    let late = keys.patch_plant(name.clone(), patch.clone(), Precondition::AnyOf(vec![1]), now).await;
    assert!(matches!(late, Err(RepositoryError::VersionMismatch { current: 2 })));
    let found = credentials(pair).find_tenant(name.clone()).await.unwrap();
    assert_eq!(found, Some(after), "whoever asks before it is known who asks hears the same");
    assert_eq!(credentials(pair).find_tenant(Tenant::named("nobody").unwrap()).await.unwrap(), None);
    let known = credentials(pair).find_key(first.key.key.id).await.unwrap().unwrap();
    assert!(known.suspended && !known.is_valid(now));
    let nobody = keys.patch_plant(Tenant::named("nobody").unwrap(), patch, Precondition::None, now).await;
    assert!(matches!(nobody, Err(RepositoryError::NotFound(Resource::Tenant))));
}

/// The owner of the database is refused as well.
pub async fn keys_are_immutable(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let keys = pair.keys_of(&tenant);
    let made = stored(&keys, key(&place, &tenant, None)).await;
    let rotation = Rotation { of: made.id, old_ends: place.now(), new: key(&place, &tenant, None) };
    keys.rotate_key(Arc::new(rotation), None).await.unwrap();
    keys.revoke_key(made.id, place.now()).await.unwrap();
    for (sql, message) in [
        ("DELETE FROM api_keys", "keys are kept"),
        ("UPDATE api_keys SET revoked_at = NULL", "a revoked key stays revoked"),
        ("UPDATE api_keys SET replaced_by = NULL", "a replaced key stays replaced"),
        ("UPDATE api_keys SET expires_at = NULL WHERE replaced_by IS NOT NULL", "its end is not put off"),
        ("UPDATE api_keys SET scopes = 'tenants'", "a key stays what it is"),
        ("UPDATE api_keys SET tenant = 'other'", "a key stays what it is"),
    ] {
        let refusal = pair.ground.refusal(sql).await.unwrap_or_default();
        assert!(refusal.contains(message), "{sql}: {refusal}");
    }
}

pub async fn a_key_is_changed_once_from_each_version(pair: &mut Pair) {
    let (place, tenant) = (pair.values.clone(), Tenant::default());
    let made = stored(&pair.keys_of(&tenant), key(&place, &tenant, None)).await;
    let changes = (0..8).map(|k| {
        let (keys, now) = (pair.handles[k % 2].keys(&crate::support::caller("default")), place.now());
        async move {
            let patch = KeyPatch { name: Some(format!("name {k}")), expires_at: None };
            keys.patch_key(made.id, patch, Precondition::AnyOf(vec![1]), now).await
        }
    });
    let outcomes = futures_util::future::join_all(changes).await;
    assert_eq!(outcomes.iter().filter(|outcome| outcome.is_ok()).count(), 1);
    assert_eq!(pair.keys_of(&tenant).key(made.id).await.unwrap().version, 2);
}
