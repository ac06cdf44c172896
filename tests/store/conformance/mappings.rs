//! Mappings of tables are kept by tenant and key, and so many of them.

use flankfit::jobs::{KeptMapping, MOST_MAPPINGS};
use jiff::SignedDuration;

use super::pair::Pair;

fn kept(key: u8, mapping: &str) -> KeptMapping {
    KeptMapping { key: [key; 32], mapping: mapping.to_owned() }
}

pub async fn a_mapping_is_kept_until_another_takes_its_place(pair: &mut Pair) {
    let (store, now) = (pair.store.clone(), pair.values.now());
    assert_eq!(store.mapping([1; 32]).await.unwrap(), None);
    store.keep_mapping(kept(1, r#"{"decimal":","}"#), now).await.unwrap();
    store.keep_mapping(kept(2, r#"{"decimal":"."}"#), now).await.unwrap();
    store.keep_mapping(kept(1, r#"{"header":true}"#), now).await.unwrap();
    pair.reopen().await;
    let store = pair.store.clone();
    assert_eq!(store.mapping([1; 32]).await.unwrap().as_deref(), Some(r#"{"header":true}"#));
    assert_eq!(store.mapping([2; 32]).await.unwrap().as_deref(), Some(r#"{"decimal":"."}"#));
    assert_eq!(store.mapping([3; 32]).await.unwrap(), None);
}

pub async fn mappings_of_a_tenant_are_bounded_and_its_own(pair: &mut Pair) {
    let (store, other, now) = (pair.store.clone(), pair.seen_by("other"), pair.values.now());
    other.keep_mapping(kept(0, r#"{"matrix":true}"#), now).await.unwrap();
    assert_eq!(store.mapping([0; 32]).await.unwrap(), None);
    let at = |second: u8| now + SignedDuration::from_secs(i64::from(second));
    let most = u8::try_from(MOST_MAPPINGS).unwrap();
    for key in 0..most {
        store.keep_mapping(kept(key, "{}"), at(key)).await.unwrap();
    }
    // used again, the first is the newest
    store.keep_mapping(kept(0, "{}"), at(most)).await.unwrap();
    store.keep_mapping(kept(most, "{}"), at(most + 1)).await.unwrap();
    for (key, is_there) in [(0, true), (1, false), (2, true), (most, true)] {
        assert_eq!(store.mapping([key; 32]).await.unwrap().is_some(), is_there, "{key}");
    }
    assert_eq!(other.mapping([0; 32]).await.unwrap().as_deref(), Some(r#"{"matrix":true}"#));
}
