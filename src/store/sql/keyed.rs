//! The place at which a page of keys begins: after a time and, for keys of one time, after an id.
//! A cursor has both.

use jiff::Timestamp;
use uuid::Uuid;

use crate::jobs::{ApiKey, Cursor, KeyId};

/// Returns the cursor after a key.
pub fn behind(key: &ApiKey) -> Cursor {
    let time = u64::try_from(key.created_at.as_microsecond()).unwrap_or(0);
    Cursor(Uuid::from_u64_pair(time, key.id.number()))
}

/// Returns time and id of a cursor; without one, later and greater than every key.
pub fn place(after: Option<Cursor>) -> (Timestamp, KeyId) {
    let Some(Cursor(place)) = after else { return (Timestamp::MAX, KeyId::of(u64::MAX)) };
    let (time, id) = place.as_u64_pair();
    let time = i64::try_from(time).ok().and_then(|time| Timestamp::from_microsecond(time).ok());
    (time.unwrap_or(Timestamp::UNIX_EPOCH), KeyId::of(id))
}
