//! Where a page of keys begins: behind a time and, of keys of one time, behind an id. Both stand in
//! a cursor.

use jiff::Timestamp;
use uuid::Uuid;

use crate::jobs::{ApiKey, Cursor, KeyId};

/// The cursor behind a key.
pub fn behind(key: &ApiKey) -> Cursor {
    let time = u64::try_from(key.created_at.as_microsecond()).unwrap_or(0);
    Cursor(Uuid::from_u64_pair(time, key.id.number()))
}

/// What the cursor says: later and greater than every key where there is none.
pub fn place(after: Option<Cursor>) -> (Timestamp, KeyId) {
    let Some(Cursor(place)) = after else { return (Timestamp::MAX, KeyId::of(u64::MAX)) };
    let (time, id) = place.as_u64_pair();
    let time = i64::try_from(time).ok().and_then(|time| Timestamp::from_microsecond(time).ok());
    (time.unwrap_or(Timestamp::UNIX_EPOCH), KeyId::of(id))
}
