//! A job: one gear (or one batch) on its way to the wanted flank.

use std::{collections::BTreeMap, sync::Arc};

use jiff::Timestamp;
use uuid::Uuid;

use super::{gear::JobGear, listing::JobStatus};

/// A job. Iterations are kept apart: a job may gather many.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    pub id: Uuid,
    pub name: String,
    pub part_number: Option<String>,
    pub serial_number: Option<String>,
    pub machine: Option<String>,
    pub gear: Option<JobGear>,
    /// Requirements on its flanks: a JSON document.
    pub requirements: Option<Arc<str>>,
    pub tags: BTreeMap<String, String>,
    /// That of its measured flanks.
    pub status: JobStatus,
    /// 1 when created, one more with every change.
    pub version: u64,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
    /// When its nodes, results, texts and names were taken away, if they were.
    pub purged_at: Option<Timestamp>,
}

/// Effect of a patch on an optional field.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Update<T> {
    #[default]
    Keep,
    Clear,
    Set(T),
}

impl<T> Update<T> {
    /// The same update of another form of the value.
    pub fn map<U>(self, form: impl FnOnce(T) -> U) -> Update<U> {
        match self {
            Update::Keep => Update::Keep,
            Update::Clear => Update::Clear,
            Update::Set(value) => Update::Set(form(value)),
        }
    }

    fn apply(self, to: &mut Option<T>) {
        match self {
            Update::Keep => {}
            Update::Clear => *to = None,
            Update::Set(value) => *to = Some(value),
        }
    }
}

/// A change of a job's data; what is not named stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobPatch {
    pub name: Option<String>,
    pub part_number: Update<String>,
    pub serial_number: Update<String>,
    pub machine: Update<String>,
    pub gear: Update<JobGear>,
    pub requirements: Update<Arc<str>>,
    pub tags: Option<BTreeMap<String, String>>,
}

impl Job {
    /// The job after `patch`; the version moves on only when something changed.
    pub fn patched(&self, patch: JobPatch, now: Timestamp) -> Job {
        let mut job = self.clone();
        if let Some(name) = patch.name {
            job.name = name;
        }
        patch.part_number.apply(&mut job.part_number);
        patch.serial_number.apply(&mut job.serial_number);
        patch.machine.apply(&mut job.machine);
        patch.gear.apply(&mut job.gear);
        patch.requirements.apply(&mut job.requirements);
        if let Some(tags) = patch.tags {
            job.tags = tags;
        }
        if job != *self {
            job.version += 1;
            // the clock of another server may have been ahead
            job.updated_at = now.max(self.updated_at);
        }
        job
    }

    /// Returns the bytes of its texts.
    pub fn text_length(&self) -> usize {
        let texts = [&self.part_number, &self.serial_number, &self.machine];
        let documents = [self.gear.as_deref(), self.requirements.as_deref()];
        let tags = self.tags.iter().map(|(name, tag)| name.len() + tag.len());
        self.name.len()
            + texts.into_iter().flatten().map(String::len).sum::<usize>()
            + documents.into_iter().flatten().map(str::len).sum::<usize>()
            + tags.sum::<usize>()
    }

    /// The job once it is purged.
    pub fn purged(&self, at: Timestamp) -> Job {
        Job { version: self.version + 1, updated_at: at.max(self.updated_at), purged_at: Some(at), ..self.clone() }
    }
}
