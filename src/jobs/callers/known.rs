//! Keys that were lately seen: whoever comes with one is not asked about in the store each time.
//!
//! What the store says of a key holds for a while ([`super::lately`]); then it is asked anew. So a
//! key that is revoked is refused within seconds, at other processes too without a message,
//! and what needs no store outlives it. The same goes for the tenants of tokens.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use jiff::Timestamp;
use tokio::{sync::watch, time::timeout};

use super::{
    lately::Lately,
    secret::{digest, id_of, same},
};
use crate::jobs::*;

/// Between two looks whether a key still lets in whoever is in already.
const LOOK: Duration = Duration::from_secs(5);
/// Between two times that uses are written down.
const USES: Duration = Duration::from_secs(20);
/// Credential of a caller.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Credential {
    Secret(KeyId),
    Certificate(San),
}

/// See the module's documentation.
pub struct KnownKeys {
    store: Arc<dyn Credentials>,
    clock: Arc<dyn Clock>,
    /// Told of every change of keys.
    changes: watch::Receiver<u64>,
    keys: Lately<Credential, Arc<KnownKey>>,
    tenants: Lately<Tenant, Plant>,
    used: Mutex<HashMap<KeyId, Timestamp>>,
}

impl JobService {
    /// The keys of every tenant, as they are when somebody comes with one.
    pub fn known_keys(&self) -> KnownKeys {
        let used = Mutex::default();
        let (store, changes) = (self.store.credentials(), self.key_changes.subscribe());
        let (keys, tenants) = (Lately::new(changes.clone()), Lately::new(changes.clone()));
        let clock = self.clock.clone();
        KnownKeys { store, clock, changes, keys, tenants, used }
    }
}

impl KnownKeys {
    /// The key of which somebody presents the text, if it lets anybody in now.
    pub async fn of_secret(&self, presented: &[u8]) -> Result<Option<Arc<KnownKey>>, RepositoryError> {
        let found = match id_of(presented) {
            Some(id) => self.find(Credential::Secret(id)).await?,
            None => None,
        };
        // A key that does not exist takes the time of one that does.
        let kept = found.as_ref().and_then(|key| key.sha256).unwrap_or([0; 32]);
        let proven = same(&kept, &digest(presented));
        Ok(found.filter(|key| proven && key.sha256.is_some() && key.is_valid(self.clock.now())))
    }

    /// The key of a certificate with these names, in its order; of them the first that lets anybody
    /// in now. The other value is true if there is one at all.
    pub async fn of_certificate(&self, names: &[San]) -> Result<(Option<Arc<KnownKey>>, bool), RepositoryError> {
        let mut registered = false;
        for name in names {
            if let Some(key) = self.find(Credential::Certificate(name.clone())).await? {
                if key.is_valid(self.clock.now()) {
                    return Ok((Some(key), true));
                }
                registered = true;
            }
        }
        Ok((None, registered))
    }

    /// Returns when a key no longer lets anybody in; an error if the store has not confirmed it for
    /// longer than it is held.
    pub async fn ended(&self, key: &KnownKey) -> Result<(), RepositoryError> {
        let credential = match &key.key.san {
            Some(san) => Credential::Certificate(san.clone()),
            None => Credential::Secret(key.key.id),
        };
        let mut changes = self.changes.clone();
        loop {
            let now = self.find(credential.clone()).await?;
            if !now.is_some_and(|now| now.key.id == key.key.id && now.is_valid(self.clock.now())) {
                return Ok(());
            }
            let _told = timeout(LOOK, changes.changed()).await;
        }
    }

    /// Whether a key was ever made. Revoked keys count.
    pub async fn exist(&self) -> Result<bool, RepositoryError> {
        self.store.has_keys().await
    }

    /// Notes that a key has let somebody in.
    pub fn note_use(&self, id: KeyId) {
        self.used.lock().unwrap_or_else(PoisonError::into_inner).insert(id, self.clock.now());
    }

    /// Writes down now and then which keys were used. Never ends.
    pub async fn write_uses(&self) {
        loop {
            tokio::time::sleep(USES).await;
            let uses = std::mem::take(&mut *self.used.lock().unwrap_or_else(PoisonError::into_inner));
            let mut uses: Vec<(KeyId, Timestamp)> = uses.into_iter().collect();
            // in one order, so that no two processes wait for each other
            uses.sort_unstable_by_key(|(id, _)| *id);
            if !uses.is_empty()
                && let Err(error) = self.store.note_uses(uses).await
            {
                tracing::debug!(%error, "the last uses of keys were not written down");
            }
        }
    }

    /// Whether there is such a tenant, and its callers are let in at present.
    pub async fn lets_in(&self, tenant: &Tenant) -> Result<bool, RepositoryError> {
        let ask = || self.store.find_tenant(tenant.clone());
        let plant = self.tenants.find(tenant.clone(), false, ask).await?;
        Ok(plant.is_some_and(|plant| !plant.suspended))
    }

    /// Returns the key of a credential, from the store or as it was lately.
    async fn find(&self, credential: Credential) -> Result<Option<Arc<KnownKey>>, RepositoryError> {
        // ids that nobody has are never the same twice, names of certificates are
        let recurs = matches!(credential, Credential::Certificate(_));
        let ask = || async {
            let asking = match &credential {
                Credential::Secret(id) => self.store.find_key(*id),
                Credential::Certificate(san) => self.store.find_certificate(san.clone()),
            };
            Ok(asking.await?.map(Arc::new))
        };
        self.keys.find(credential.clone(), recurs, ask).await
    }
}

#[cfg(test)]
mod tests {
    use std::{
        sync::atomic::{AtomicBool, AtomicU64, Ordering},
        time::Instant,
    };

    use super::*;
    use crate::jobs::{
        ambient::SystemClock,
        callers::{ApiKey, Role, Secret},
        outcome::RepositoryFuture,
    };

    /// Longer than any test takes.
    const LONG: Duration = Duration::from_secs(3600);
    /// Time to wait for a change, long enough for a busy machine.
    const PATIENCE: Duration = Duration::from_secs(60);

    /// A store of one key that can be away.
    struct OneKey {
        key: Mutex<KnownKey>,
        away: AtomicBool,
        asked: AtomicU64,
    }

    impl Credentials for OneKey {
        fn find_key(&self, id: KeyId) -> RepositoryFuture<'_, Option<KnownKey>> {
            Box::pin(async move {
                self.asked.fetch_add(1, Ordering::Relaxed);
                if self.away.load(Ordering::Relaxed) {
                    return Err(RepositoryError::Unavailable("away".into()));
                }
                Ok(Some(self.key.lock().unwrap().clone()).filter(|known| known.key.id == id))
            })
        }

        fn find_certificate(&self, _san: San) -> RepositoryFuture<'_, Option<KnownKey>> {
            Box::pin(async { Ok(None) })
        }

        fn find_tenant(&self, name: Tenant) -> RepositoryFuture<'_, Option<Plant>> {
            Box::pin(async move {
                self.asked.fetch_add(1, Ordering::Relaxed);
                if self.away.load(Ordering::Relaxed) {
                    return Err(RepositoryError::Unavailable("away".into()));
                }
                let (id, now) = (uuid::Uuid::nil(), SystemClock.now());
                let suspended = self.key.lock().unwrap().suspended;
                let (created_at, updated_at, description) = (now, now, None);
                let plant = Plant { id, name, description, suspended, version: 1, created_at, updated_at };
                Ok(Some(plant).filter(|plant| plant.name == Tenant::default()))
            })
        }

        fn has_keys(&self) -> RepositoryFuture<'_, bool> {
            Box::pin(async { Ok(true) })
        }

        fn note_uses(&self, _uses: Vec<(KeyId, Timestamp)>) -> RepositoryFuture<'_, ()> {
            Box::pin(async { Ok(()) })
        }
    }

    impl OneKey {
        fn revoke(&self) {
            self.key.lock().unwrap().key.revoked_at = Some(SystemClock.now());
        }

        fn asked(&self) -> u64 {
            self.asked.load(Ordering::Relaxed)
        }
    }

    /// Makes a store with one key; `held` is how long its key is valid while it is away.
    fn one_key(held: Duration) -> (Arc<OneKey>, KnownKeys, watch::Sender<u64>, Secret) {
        let (id, secret) = Secret::generate().unwrap();
        let key = ApiKey {
            id,
            tenant: Tenant::default(),
            name: "key".into(),
            role: Some(Role::Reader),
            scopes: Role::Reader.scopes(),
            san: None,
            version: 1,
            created_at: SystemClock.now(),
            expires_at: None,
            last_used_at: None,
            revoked_at: None,
            replaced_by: None,
        };
        let key = KnownKey { key, sha256: Some(secret.sha256()), suspended: false };
        let store = Arc::new(OneKey { key: Mutex::new(key), away: AtomicBool::default(), asked: AtomicU64::default() });
        let (told, changes) = watch::channel(0);
        let used = Mutex::default();
        let clock = Arc::new(SystemClock);
        let (mut keys, mut tenants) = (Lately::new(changes.clone()), Lately::new(changes.clone()));
        let fresh = Duration::from_millis(50);
        (keys.fresh, keys.held, tenants.fresh, tenants.held) = (fresh, held, fresh, held);
        let known = KnownKeys { store: store.clone(), clock, changes, keys, tenants, used };
        (store, known, told, secret)
    }

    async fn lets_in(known: &KnownKeys, secret: &Secret) -> Option<bool> {
        known.of_secret(secret.expose().as_bytes()).await.ok().map(|key| key.is_some())
    }

    #[tokio::test]
    async fn a_key_is_reread_at_intervals_and_after_every_change() {
        let (store, known, told, secret) = one_key(LONG);
        for _ in 0..100 {
            assert_eq!(lets_in(&known, &secret).await, Some(true));
        }
        assert!(store.asked() < 50, "{}", store.asked());
        // with a message of the change, it is refused at once
        store.revoke();
        told.send_modify(|changes| *changes += 1);
        assert_eq!(lets_in(&known, &secret).await, Some(false));
        // and without one, soon
        let (store, known, _told, secret) = one_key(LONG);
        assert_eq!(lets_in(&known, &secret).await, Some(true));
        store.revoke();
        let began = Instant::now();
        while lets_in(&known, &secret).await == Some(true) {
            assert!(began.elapsed() < PATIENCE, "it lets somebody in for ever");
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    }

    #[tokio::test]
    async fn a_key_once_seen_outlives_the_store_for_a_while() {
        let held = Duration::from_millis(400);
        let (store, known, _told, secret) = one_key(held);
        // before it is seen: the machine may pause behind that, and the time is up earlier then
        let seen = Instant::now();
        assert_eq!(lets_in(&known, &secret).await, Some(true));
        store.away.store(true, Ordering::Relaxed);
        while lets_in(&known, &secret).await == Some(true) {
            assert!(seen.elapsed() < PATIENCE, "it lets somebody in for ever");
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        assert!(seen.elapsed() >= held);
        assert_eq!(lets_in(&known, &secret).await, None, "nobody knows");
        // whoever comes for the first time meanwhile is not known
        let (_, stranger) = Secret::generate().unwrap();
        assert_eq!(lets_in(&known, &stranger).await, None);
        store.away.store(false, Ordering::Relaxed);
        assert_eq!(lets_in(&known, &secret).await, Some(true));
        assert_eq!(lets_in(&known, &stranger).await, Some(false));
    }

    /// The key may be a good one: the store is the reason.
    #[tokio::test]
    async fn ended_fails_while_the_store_is_unavailable() {
        let (store, known, told, secret) = one_key(Duration::from_millis(100));
        let key = known.of_secret(secret.expose().as_bytes()).await.unwrap().unwrap();
        store.away.store(true, Ordering::Relaxed);
        let ringing = async {
            loop {
                tokio::time::sleep(Duration::from_millis(20)).await;
                told.send_modify(|changes| *changes += 1);
            }
        };
        let ended = tokio::select! {
            ended = known.ended(&key) => ended,
            () = ringing => unreachable!("it never ends"),
        };
        assert!(matches!(ended, Err(RepositoryError::Unavailable(_))), "{ended:?}");
    }

    #[tokio::test]
    async fn tenants_of_tokens_are_known_as_keys_are() {
        let (store, known, told, _) = one_key(LONG);
        let (own, other) = (Tenant::default(), Tenant::named("other").unwrap());
        for _ in 0..100 {
            assert!(known.lets_in(&own).await.unwrap());
        }
        assert!(store.asked() < 50, "{}", store.asked());
        assert!(!known.lets_in(&other).await.unwrap());
        store.away.store(true, Ordering::Relaxed);
        tokio::time::sleep(Duration::from_millis(60)).await;
        assert!(known.lets_in(&own).await.unwrap(), "it was seen");
        assert!(known.lets_in(&other).await.is_err(), "nobody knows");
        store.away.store(false, Ordering::Relaxed);
        store.key.lock().unwrap().suspended = true;
        told.send_modify(|changes| *changes += 1);
        assert!(!known.lets_in(&own).await.unwrap());
    }
}
