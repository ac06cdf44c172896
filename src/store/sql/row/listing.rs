//! Jobs as they are listed and counted.

use std::sync::Arc;

use jiff::{Timestamp, civil::Date};

use crate::{
    jobs::{Decision, Job, JobCounts, JobStatus, ListedJob, RepositoryError},
    store::sql::error::{Outcome, damaged},
};
use flankfit_engine::gear::Side;

row! {
    pub struct ListedJobRow {
        @job: Job,
        status: JobStatus,
        iteration_count: u32,
        changed_at: Timestamp,
        last_measured_at: Option<Timestamp>,
        flank: Option<Side>,
        left_rank: Option<u8>,
        right_rank: Option<u8>,
        decision: Option<Decision>,
        rms: Option<f64>,
        condition: Option<f64>,
        flank_figures: Option<Arc<str>>,
        class: Option<u8>,
        sort_name: String,
    }
}

impl From<ListedJobRow> for (ListedJob, String) {
    /// Returns the job and its place in the order by name.
    fn from(row: ListedJobRow) -> Self {
        let job = ListedJob {
            job: row.job,
            status: row.status,
            iteration_count: row.iteration_count,
            changed_at: row.changed_at,
            last_measured_at: row.last_measured_at,
            flank: row.flank,
            left: row.left_rank.and_then(JobStatus::of_rank),
            right: row.right_rank.and_then(JobStatus::of_rank),
            decision: row.decision,
            rms: row.rms,
            condition: row.condition,
            figures: row.flank_figures,
            class: row.class,
        };
        (job, row.sort_name)
    }
}

row! {
    /// How many jobs have something.
    pub struct Count {
        of: String,
        jobs: u64,
    }
}

/// Returns the counts by status, machine and day; `all` are how many machines there are, and how
/// many jobs have one.
pub fn counts(statuses: Vec<Count>, machines: Vec<Count>, all: (u64, u64), days: Vec<Count>) -> Outcome<JobCounts> {
    let unreadable = |what, of: &str| RepositoryError::Failed(damaged(what, of));
    let status = |Count { of, jobs }: Count| match JobStatus::named(&of) {
        Some(status) => Ok((status, jobs)),
        None => Err(unreadable("a status", &of)),
    };
    let day = |Count { of, jobs }: Count| match of.parse::<Date>() {
        Ok(day) => Ok((day, jobs)),
        Err(_) => Err(unreadable("a day", &of)),
    };
    Ok(JobCounts {
        statuses: statuses.into_iter().map(status).collect::<Result<_, _>>()?,
        machines: machines.into_iter().map(|Count { of, jobs }| (of, jobs)).collect(),
        machine_count: all.0,
        with_machine: all.1,
        days: days.into_iter().map(day).collect::<Result<_, _>>()?,
    })
}
