//! Compares entries with the rows that they have digests of, and with their places in the chain.

use std::collections::{BTreeMap, BTreeSet};

use uuid::Uuid;

use super::{
    entry::{Action, Entry, Link},
    layout::{Fields, Sha256Digest},
    seal::Seal,
};
use crate::jobs::{
    callers::Tenant,
    rows::{Life, Row, Table, Value},
};

/// Kind of the difference.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize, utoipa::ToSchema,
)]
#[serde(rename_all = "snake_case")]
#[schema(as = AuditDifferenceKind)]
pub enum Kind {
    /// It is not as it was written.
    Changed,
    /// It was there once.
    Missing,
    /// A row that no entry has.
    Unaudited,
    /// It cannot be read.
    Unreadable,
    /// A value that follows from others contradicts them.
    Derived,
    /// A seal has another digest of the entry, or no seal has one.
    Seal,
}

names! {
    Kind {
        Changed "changed", Missing "missing", Unaudited "unaudited", Unreadable "unreadable", Derived "derived",
        Seal "seal",
    }
}

/// Something that is not as it was written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Difference {
    pub tenant: String,
    pub job: Option<Uuid>,
    /// The row by its name, `decisions/3/1`; `entry 17` of the tenant; `seal 5` of the tenant.
    pub place: String,
    pub kind: Kind,
}

/// The digest of all that a purge leaves, row by row in the order of the tables.
pub fn left(salt: &[u8]) -> Fields {
    Fields::default().bytes(salt)
}

/// Name of [`left`] in the entry of a purge. The rows of the other two tables are digested alone.
const LEFT: &str = "left";

/// Compares the entries of a job, or of a tenant's keys, with its rows: first come all entries,
/// then all rows.
#[derive(Default)]
pub struct RowVerifier {
    notes: BTreeMap<String, Vec<(Vec<u8>, Sha256Digest)>>,
    purge: Option<(Vec<u8>, Fields)>,
    deleted: bool,
    deleted_streams: BTreeSet<String>,
    /// Names of rows that were found.
    found: BTreeSet<String>,
    /// Names without their versions, with the versions that were found.
    versions: BTreeMap<String, i64>,
    open_streams: BTreeSet<String>,
    /// Events that follow from other rows, and the number of the last event.
    events: BTreeMap<String, usize>,
    last_event: i64,
    differences: Vec<(String, Kind)>,
}

impl RowVerifier {
    pub fn entry(&mut self, entry: &Entry) {
        let is = |action: Action| *entry.action == *action.name();
        let salt = entry.salt.clone().unwrap_or_default();
        if is(Action::PurgeJob) && self.purge.is_none() {
            // the rows of before have changed; nothing comes after it
            self.notes.clear();
            self.purge = Some((salt.clone(), left(&salt)));
        } else if self.purge.is_some() {
            if is(Action::PurgeJob) {
                self.difference("purges", Kind::Unaudited);
            }
            return;
        }
        self.deleted |= is(Action::DeleteJob);
        if is(Action::DeleteStream) {
            self.deleted_streams.extend(entry.subject.rsplit('/').next().map(str::to_owned));
        }
        for (name, digest) in entry.contents.iter() {
            self.notes.entry(name.to_owned()).or_default().push((salt.clone(), *digest));
        }
    }

    /// Takes a row, those of a job in the order of the tables.
    pub fn row(&mut self, row: &Row) {
        let Row { table, values } = row;
        if let Some((salt, fields)) = self.purge.as_mut().filter(|_| !["jobs", "purges"].contains(&table.name)) {
            *fields = std::mem::take(fields).bytes(&table.digest(salt, values));
            return;
        }
        let name = row.name();
        let is_event = table.name == "events";
        let is_as_noted = self
            .notes
            .get(&name)
            .filter(|_| !self.deleted)
            .map(|notes| notes.iter().all(|(salt, digest)| table.digest(salt, values) == *digest));
        match is_as_noted {
            Some(true) => {
                self.found.insert(name.clone());
            }
            Some(false) => {
                self.found.insert(name.clone());
                self.difference(&name, Kind::Changed);
            }
            None if is_event && self.follows(values) => {}
            None if is_first_tenant(row) => return,
            None => self.difference(&name, Kind::Unaudited),
        }
        if let (Life::Changes, Some((first, version))) = (table.life, name.rsplit_once('/')) {
            self.versions.insert(first.to_owned(), version.parse().unwrap_or_default());
        }
        if is_event {
            self.last_event += 1;
            if row.value("number").integer() != Some(self.last_event) {
                self.difference(&format!("events/{}", self.last_event), Kind::Missing);
                self.last_event = row.value("number").integer().unwrap_or_default();
            }
        }
        self.expect_event(row);
        if table.name == "streams" && row.value("iteration").integer().is_none() {
            self.open_streams.extend(row.value("id").text().map(|id| id.into_owned()));
        }
    }

    /// Takes note of the event that a trigger writes with a row. (Those of streams and of the job
    /// itself are in the entries.)
    fn expect_event(&mut self, row: &Row) {
        let is_first = row.value("position").integer() == Some(1);
        let (kind, columns): (_, [&str; 4]) = match row.table.name {
            "iterations" => ("iteration", ["number", "", "", ""]),
            "fits" if !is_first => ("fit", ["number", "position", "", ""]),
            "fit_choices" if !is_first => ("fit", ["number", "fit", "position", ""]),
            "decisions" => ("decision", ["number", "", "position", ""]),
            "records" => ("record", ["number", "", "", "id"]),
            _ => return,
        };
        let text = |name: &str| match name {
            "" => String::new(),
            name => row.value(name).text().unwrap_or_default().into_owned(),
        };
        let columns = columns.map(text).join("|");
        *self.events.entry(format!("{kind}|{columns}|||||{}", text("created_at"))).or_default() += 1;
    }

    /// Returns whether an event is the one of another row.
    fn follows(&mut self, values: &[Value<'_>]) -> bool {
        let texts: Vec<_> = values[1..].iter().map(|value| value.text().unwrap_or_default()).collect();
        let expected = self.events.get_mut(&texts.join("|")).filter(|count| **count > 0);
        expected.map(|count| *count -= 1).is_some()
    }

    /// Notes a difference of a row.
    pub fn difference(&mut self, name: &str, kind: Kind) {
        self.differences.push((name.to_owned(), kind));
    }

    /// Returns the differences, each with the name of its row.
    pub fn conclude(mut self) -> Vec<(String, Kind)> {
        if let Some((_, fields)) = self.purge.take() {
            let digest = fields.digest();
            let as_left = self.notes.remove(LEFT).is_some_and(|notes| notes.iter().all(|(_, told)| *told == digest));
            if !as_left {
                self.difference(LEFT, Kind::Changed);
            }
            if !self.found.iter().any(|name| name.starts_with("purges")) {
                self.difference("purges", Kind::Missing);
            }
            self.versions.clear();
        }
        let notes = std::mem::take(&mut self.notes);
        // of the states of a stream only the last one is there
        let mut last_states: BTreeMap<&str, u64> = BTreeMap::new();
        for (stream, sequence) in notes.keys().filter_map(|name| name.strip_prefix("stream_states/")?.split_once('/')) {
            let last = last_states.entry(stream).or_default();
            *last = sequence.parse::<u64>().unwrap_or_default().max(*last);
        }
        for name in notes.keys().filter(|name| !self.deleted && !self.found.contains(*name)) {
            let (first, last) = name.rsplit_once('/').unwrap_or((name, ""));
            let stream = first.rsplit_once('/').map_or(first, |(_, stream)| stream);
            let is_missing = match Table::named(name.split('/').next().unwrap_or_default()) {
                Some(table) if table.life == Life::Changes => {
                    let found = self.versions.get(first);
                    let version = last.parse().unwrap_or(i64::MAX);
                    let is_deleted =
                        table.name == "streams" && found.is_none() && self.deleted_streams.contains(stream);
                    found.is_none_or(|found| *found < version) && !is_deleted
                }
                Some(table) if table.life == Life::Passes => {
                    let is_last = last_states.get(stream).is_some_and(|sequence| sequence.to_string() == last);
                    self.open_streams.contains(stream) && (table.name == "stream_blocks" || is_last)
                }
                _ => true,
            };
            if is_missing {
                self.differences.push((name.clone(), Kind::Missing));
            }
        }
        for (first, version) in std::mem::take(&mut self.versions) {
            // the schema comes with the first version of this one
            let from = if first == "tenants/default" { 2 } else { 1 };
            let unaudited = (from..version).map(|version| format!("{first}/{version}"));
            let unaudited = unaudited.filter(|name| !notes.contains_key(name)).take(1);
            self.differences.extend(unaudited.map(|name| (name, Kind::Unaudited)));
        }
        let missing = self.events.iter().filter(|(_, count)| **count > 0).take(1);
        self.differences.extend(missing.map(|(event, _)| (format!("events: {event}"), Kind::Missing)));
        self.differences
    }
}

/// Returns whether it is the row that the schema comes with.
fn is_first_tenant(row: &Row) -> bool {
    row.to_line()
        == "{\"tenants\":{\"name\":\"default\",\"version\":1,\"id\":\"00000000-0000-0000-0000-000000000000\",\"suspended\":\
            false,\"created_at\":\"2026-11-23T00:00:00.000000Z\",\"updated_at\":\"2026-11-23T00:00:00.000000Z\"}}\n"
}

/// Signatures that are checked at a stretch, which takes about a millisecond.
const SIGNATURES: u64 = 16;

/// Compares the seals of a tenant with each other, then the entries of its chain with the seals.
pub struct ChainVerifier<'a> {
    /// Seals that were kept elsewhere.
    kept: &'a BTreeMap<u64, Seal>,
    /// The key that all seals must be signed by.
    key: Option<[u8; 32]>,
    /// Count of the seals of the database.
    pub seals: u64,
    /// Number and digest of the last one.
    seal: (u64, Sha256Digest),
    head: Link,
    /// Digests by numbers that seals have.
    sealed: BTreeMap<u64, Sha256Digest>,
    last_sealed: u64,
    differences: Vec<(Option<Uuid>, String, Kind)>,
}

impl<'a> ChainVerifier<'a> {
    pub fn new(tenant: &Tenant, kept: &'a BTreeMap<u64, Seal>, key: Option<[u8; 32]>) -> Self {
        ChainVerifier {
            kept,
            key,
            seals: 0,
            seal: (0, Seal::genesis(tenant)),
            head: Link::genesis(tenant),
            sealed: kept.values().map(|seal| (seal.last.number, seal.last.sha256)).collect(),
            last_sealed: 0,
            differences: Vec::new(),
        }
    }

    /// Takes the next seal of the database. Gives other tasks their turn now and then.
    pub async fn seal(&mut self, seal: &Seal) {
        let (last, previous) = self.seal;
        let number = last.saturating_add(1);
        let is_kept = self.kept.get(&seal.number).is_none_or(|kept| kept.sha256 == seal.sha256);
        if seal.number != number {
            self.differences.push((None, format!("seal {number}"), Kind::Missing));
        } else if seal.previous != previous || !seal.is_sound(self.key) || !is_kept {
            self.differences.push((None, format!("seal {number}"), Kind::Changed));
        }
        self.seal = (seal.number, seal.sha256);
        self.sealed.entry(seal.last.number).or_insert(seal.last.sha256);
        self.last_sealed = seal.last.number;
        self.seals += 1;
        if self.seals.is_multiple_of(SIGNATURES) {
            tokio::task::yield_now().await;
        }
    }

    /// Takes the next place with its entry; none if that is missing or unreadable.
    pub fn entry(&mut self, place: Link, entry: Result<&Entry, Kind>, is_purged: bool) {
        let expected = self.head.number.saturating_add(1);
        let name = |number| format!("entry {number}");
        let job = entry.ok().and_then(|entry| entry.job);
        if place.number != expected {
            self.differences.push((None, name(expected), Kind::Missing));
        }
        let difference = entry.map_or_else(Some, |entry| {
            let head = Link { number: place.number.saturating_sub(1), ..self.head };
            // after a missing entry the link cannot be known
            let follows = place.number != expected || head.next(&entry.digest()) == place;
            (!follows || !is_sound(entry, is_purged)).then_some(Kind::Changed)
        });
        let sealed = self.sealed.remove(&place.number);
        let difference = difference.or(sealed.filter(|sealed| *sealed != place.sha256).map(|_| Kind::Seal));
        self.differences.extend(difference.map(|kind| (job, name(place.number), kind)));
        self.head = place;
    }

    /// Returns the differences, each with its job and its place.
    pub fn conclude(mut self) -> Vec<(Option<Uuid>, String, Kind)> {
        let missing = self.kept.keys().next_back().filter(|kept| **kept > self.seal.0);
        self.differences.extend(missing.map(|number| (None, format!("seal {number}"), Kind::Missing)));
        let missing = self.sealed.keys().next_back().filter(|sealed| **sealed > self.head.number);
        self.differences.extend(missing.map(|number| (None, format!("entry {number}"), Kind::Missing)));
        if self.head.number > self.last_sealed {
            self.differences.push((None, format!("entry {}", self.head.number), Kind::Seal));
        }
        self.differences
    }
}

/// Returns whether the actor is the one of the digest; that of a purged job is not known.
pub fn is_sound(entry: &Entry, is_purged: bool) -> bool {
    match entry.digest_of_actor() {
        Some(digest) => digest == entry.who,
        None => is_purged && entry.actor.is_none() && entry.salt.is_none(),
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt as _;
    use jiff::Timestamp;

    use super::*;

    #[test]
    fn many_seals_leave_others_their_turn() {
        let (tenant, kept) = (Tenant::default(), BTreeMap::new());
        let mut chain = ChainVerifier::new(&tenant, &kept, None);
        let seal = Seal::next(&tenant, None, Link::genesis(&tenant), Timestamp::UNIX_EPOCH, None);
        let turns = (0..4 * SIGNATURES).filter(|_| chain.seal(&seal).now_or_never().is_none()).count();
        assert_eq!(turns, 4);
    }
}
