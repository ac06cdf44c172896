//! Whether a chain and the rows that it tells of are as they were written.

use std::collections::BTreeMap;

use uuid::Uuid;

use super::{
    changing::LastTold,
    contents::{SALT, with_salt},
    entry::{Action, Chain, Entry, Head},
    found::{Found, Kind},
    layout::Sha256Digest,
    purged::Nameless,
};
use crate::jobs::callers::Tenant;

/// Kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum What {
    /// The entry itself, or it is missing.
    Entry,
    /// Its link to the one before it.
    Link,
    /// A row that it has a digest of; or a row that no entry tells of.
    Content,
    /// A seal has another digest of it.
    Seal,
}

impl What {
    /// The contract's name.
    pub fn name(self) -> &'static str {
        match self {
            What::Entry => "entry",
            What::Link => "link",
            What::Content => "content",
            What::Seal => "seal",
        }
    }
}

/// What was found out of a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Intact {
        entries: u64,
        /// Digest of the last entry; none of a chain without any.
        head: Option<Sha256Digest>,
    },
    /// The first entry that is not as it was written, or whose rows are not.
    Broken { number: u64, what: What },
}

/// A row that an entry tells of.
#[derive(Clone, Copy)]
struct Told {
    digest: Sha256Digest,
    /// What the digest of the row was salted with.
    salt: Option<Sha256Digest>,
    by: u64,
}

impl Told {
    /// Whether the row is the one that was told of.
    fn is(&self, row: &Sha256Digest) -> bool {
        self.digest == with_salt(self.salt.as_ref(), row)
    }
}

/// Goes through a chain.
pub struct Verifier {
    head: Head,
    /// What seals say of it: digests by numbers.
    sealed: BTreeMap<u64, Sha256Digest>,
    job: Option<LastTold>,
    rows: BTreeMap<(u64, Kind), Vec<Told>>,
    streams: BTreeMap<Uuid, Told>,
    blocks: BTreeMap<(Uuid, u64), Told>,
    /// For a tenant: its own row, and its keys by their names.
    tenant: Option<LastTold>,
    keys: BTreeMap<String, LastTold>,
    /// The rows that are older than the chain, or that a purge has left.
    older: Option<Told>,
    /// That of a purge, and the streams that it has left.
    purge: Option<Told>,
    left_streams: Option<Told>,
    /// The purges of a tenant's jobs by their names.
    purges: BTreeMap<String, Told>,
    nameless: Nameless,
    fault: Option<(u64, What)>,
    /// Whether the chain ends where it is broken.
    torn: bool,
}

impl Verifier {
    /// Verifier of a chain, with the digests that seals have of its entries.
    pub fn of(chain: Chain, tenant: &Tenant, sealed: BTreeMap<u64, Sha256Digest>) -> Self {
        Verifier {
            head: Head::before(chain, tenant),
            sealed,
            job: None,
            rows: BTreeMap::new(),
            streams: BTreeMap::new(),
            blocks: BTreeMap::new(),
            tenant: None,
            keys: BTreeMap::new(),
            older: None,
            purge: None,
            left_streams: None,
            purges: BTreeMap::new(),
            nameless: Nameless::default(),
            fault: None,
            torn: false,
        }
    }

    /// The next entry as it is stored; none for one that does not read.
    pub fn entry(&mut self, entry: Option<&Entry>) {
        if self.torn {
            return;
        }
        let number = self.head.number + 1;
        let fault = match entry {
            Some(entry) if entry.number != number => Some(What::Entry),
            // the purge has a digest of what is left of such an entry
            Some(entry) if !entry.is_nameless() && entry.sha256 != entry.digest() => Some(What::Entry),
            Some(entry) if entry.previous != self.head.sha256 => Some(What::Link),
            Some(entry) => {
                let sealed = self.sealed.remove(&number);
                sealed.filter(|sealed| *sealed != entry.sha256).map(|_| What::Seal)
            }
            None => Some(What::Entry),
        };
        if let Some(what) = fault {
            self.note(number, what);
        }
        self.torn |= matches!(fault, Some(What::Entry | What::Link));
        if let Some(entry) = entry.filter(|_| !self.torn) {
            self.head = Head { number, sha256: entry.sha256 };
            self.nameless.entry(entry);
            self.expect(entry);
        }
    }

    /// The first fault is told.
    fn note(&mut self, number: u64, what: What) {
        let fault = (number, what);
        self.fault = Some(self.fault.map_or(fault, |first| first.min(fault)));
    }

    fn expect(&mut self, entry: &Entry) {
        let place = Place::of(&entry.target);
        if *entry.action == *Action::PurgeJob.name() {
            // what was told before is no longer there; what is left is told now
            self.rows.clear();
            self.streams.clear();
            self.blocks.clear();
        }
        let salt = entry.contents.get(SALT).copied();
        for (name, &digest) in entry.contents.iter().filter(|(name, _)| *name != SALT) {
            let told = Told { digest, salt: None, by: entry.number };
            let kind = match name {
                "job" => {
                    self.job = Some(LastTold::told(self.job.as_ref(), digest, entry));
                    continue;
                }
                "found" => {
                    self.older = Some(told);
                    continue;
                }
                "tenant" => {
                    self.tenant = Some(LastTold::told(self.tenant.as_ref(), digest, entry));
                    continue;
                }
                "archive" => continue,
                "entries" => {
                    if self.nameless.digest() != digest {
                        self.note(entry.number, What::Content);
                    }
                    continue;
                }
                "purge" => {
                    self.purge = Some(told);
                    continue;
                }
                "streams" => {
                    self.left_streams = Some(told);
                    continue;
                }
                job if job.starts_with("purge.") => {
                    self.purges.insert(job.to_owned(), told);
                    continue;
                }
                key if key.starts_with("key.") => {
                    let told = LastTold::told(self.keys.get(key), digest, entry);
                    self.keys.insert(key.to_owned(), told);
                    continue;
                }
                "stream" => {
                    self.streams.extend(place.stream.map(|id| (id, told)));
                    continue;
                }
                "block" => {
                    self.blocks.extend(place.stream.zip(place.block).map(|block| (block, told)));
                    continue;
                }
                "iteration" => Kind::Iteration,
                "nodes" => Kind::Nodes,
                "fit" => Kind::Fit,
                "choice" => Kind::Choice,
                "decision" => Kind::Decision,
                _ => Kind::Record,
            };
            self.rows.entry((place.iteration.unwrap_or(0), kind)).or_default().push(Told { salt, ..told });
        }
        if *entry.action == *Action::DeleteStream.name() {
            self.streams.retain(|id, _| Some(*id) != place.stream);
        }
        if *entry.action == *Action::DeleteJob.name() {
            self.job = None;
        }
    }

    /// Compares what was told with what is found.
    pub fn conclude(mut self, found: &Found) -> Verdict {
        let (next, whole) = (self.head.number + 1, !self.torn);
        if let (true, Some(&number)) = (whole, self.sealed.keys().next()) {
            // what is sealed beyond the end was there once, and rows may be as it told
            self.note(number.min(next), What::Entry);
            self.torn = true;
        }
        if let Some(first) = self.nameless.first.filter(|_| whole) {
            // a purge takes the name from every entry: where none has one, its own is missing
            let purged = found.purge.is_some() && self.nameless.count == self.head.number;
            self.note(if purged { next } else { first }, What::Entry);
            self.torn |= purged;
        }
        if self.head.number > 0 {
            self.compare(found);
        } else if found.job.is_some() && found.told_elsewhere {
            // a job from before there were entries has none in any chain
            self.note(next, What::Content);
        }
        match self.fault {
            Some((number, what)) => Verdict::Broken { number, what },
            None => {
                Verdict::Intact { entries: self.head.number, head: (self.head.number > 0).then_some(self.head.sha256) }
            }
        }
    }

    fn compare(&mut self, found: &Found) {
        if self.torn && self.nameless.first.is_some() {
            // torn before its purge has told what is left
            return;
        }
        let mut faults: Vec<u64> = Vec::new();
        // rows that no entry tells of would be of the next one
        let next = self.head.number + 1;
        let mut older = Found::default();
        for (&(number, kind), told) in &self.rows {
            let rows = found.rows(number, kind);
            // those that are older than the chain come first
            let before = self.older.map_or(0, |_| rows.len().saturating_sub(told.len()));
            // and behind them, where entries are missing, some of which these told
            let first = if self.torn { 0 } else { before };
            let differing = |before: usize| {
                let differs = |(k, told): &(usize, &Told)| rows.get(before + k).is_none_or(|row| !told.is(row));
                told.iter().enumerate().find(differs).map(|(_, told)| told.by)
            };
            if (first..before).all(|before| differing(before).is_some()) {
                faults.extend(differing(before));
            }
        }
        for (number, kind, rows) in found.iter() {
            let told = self.rows.get(&(number, kind)).map_or(0, Vec::len);
            let untold = &rows[..rows.len().saturating_sub(told)];
            match self.older {
                Some(_) => untold.iter().for_each(|row| older.add(number, kind, *row)),
                None if !untold.is_empty() && !self.torn => faults.push(next),
                None => {}
            }
        }
        if !self.torn {
            faults.extend(self.older.filter(|told| told.digest != older.digest()).map(|told| told.by));
            faults.extend(self.job.and_then(|told| told.fault(found.job.as_ref(), next)));
            faults.extend((self.job.is_none() && found.job.is_some()).then_some(next));
            self.compare_streams(found, &mut faults, next);
            self.compare_keys(found, &mut faults, next);
            self.compare_purges(found, &mut faults, next);
            if faults.is_empty() && found.listed_otherwise {
                // what a job is listed by follows from its rows; these are as they were told
                faults.extend(self.job.map(|told| told.by()));
            }
        }
        if let Some(first) = faults.into_iter().min() {
            self.note(first, What::Content);
        }
    }

    /// A tenant may be older than its chain; its keys begin that.
    fn compare_keys(&self, found: &Found, faults: &mut Vec<u64>, next: u64) {
        faults.extend(self.tenant.and_then(|told| told.fault(found.tenant.as_ref(), next)));
        faults.extend(self.keys.iter().filter_map(|(name, told)| told.fault(found.keys.get(name), next)));
        let untold = found.keys.keys().any(|name| !self.keys.contains_key(name));
        faults.extend(untold.then_some(next));
    }

    /// Of a job its own purge, and the streams that it has left; of a tenant those of its jobs. (A
    /// purged job that came from another database is told of by its own chain alone.)
    fn compare_purges(&self, found: &Found, faults: &mut Vec<u64>, next: u64) {
        faults.extend(self.purge.filter(|told| found.purge != Some(told.digest)).map(|told| told.by));
        faults.extend((self.purge.is_none() && found.purge.is_some()).then_some(next));
        let streams = self.left_streams.filter(|told| found.streams_digest() != told.digest);
        faults.extend(streams.map(|told| told.by));
        let differs = |(name, told): &(&String, &Told)| found.purges.get(*name) != Some(&told.digest);
        faults.extend(self.purges.iter().filter(differs).map(|(_, told)| told.by));
    }

    /// Streams may be older than the chain; blocks are there as long as their stream is open.
    fn compare_streams(&self, found: &Found, faults: &mut Vec<u64>, next: u64) {
        for (id, told) in &self.streams {
            let there = found.streams.get(id).is_some_and(|stream| stream.digest == told.digest);
            faults.extend((!there).then_some(told.by));
        }
        for ((stream, _), told) in
            self.blocks.iter().filter(|(block, told)| found.blocks.get(*block) != Some(&told.digest))
        {
            let open = found.streams.get(stream).is_some_and(|stream| stream.open);
            faults.extend(open.then_some(told.by));
        }
        if self.older.is_none() {
            let untold = found.streams.keys().any(|id| !self.streams.contains_key(id))
                || found.blocks.keys().any(|block| !self.blocks.contains_key(block));
            faults.extend(untold.then_some(next));
        }
    }
}

/// Where the rows of an entry are, by its target.
#[derive(Default)]
struct Place {
    iteration: Option<u64>,
    stream: Option<Uuid>,
    block: Option<u64>,
}

impl Place {
    fn of(target: &str) -> Self {
        let parts: Vec<&str> = target.split('/').collect();
        let after = |name: &str| parts.windows(2).find(|pair| pair[0] == name).map(|pair| pair[1]);
        Place {
            iteration: after("iterations").and_then(|number| number.parse().ok()),
            stream: after("streams").and_then(|id| id.parse().ok()),
            block: after("blocks").and_then(|number| number.parse().ok()),
        }
    }
}
