//! Jobs as they are listed and counted.

use jiff::civil::Date;

use super::job::JobRow;
use crate::{
    jobs::{Decision, JobCounts, JobStatus, ListedJob, RepositoryError},
    store::sql::{
        columns::{Flank, Integer, Moment},
        error::{Outcome, damaged},
    },
};

row! {
    pub struct ListedJobRow {
        @job: JobRow,
        status: JobStatus,
        iteration_count: Integer<u32>,
        changed_at: Moment,
        last_measured_at: Option<Moment>,
        flank: Option<Flank>,
        left_rank: Option<Integer<u8>>,
        right_rank: Option<Integer<u8>>,
        decision: Option<Decision>,
        rms: Option<f64>,
        condition: Option<f64>,
        flank_figures: Option<String>,
        class: Option<Integer<u8>>,
        sort_name: String,
    }
}

impl From<ListedJobRow> for (ListedJob, String) {
    /// With what the job stands at by name.
    fn from(row: ListedJobRow) -> Self {
        let job = ListedJob {
            job: row.job.into(),
            status: row.status,
            iteration_count: row.iteration_count.0,
            changed_at: row.changed_at.0,
            last_measured_at: row.last_measured_at.map(|at| at.0),
            flank: row.flank.map(|Flank(side)| side),
            left: row.left_rank.and_then(|Integer(rank)| JobStatus::of_rank(rank)),
            right: row.right_rank.and_then(|Integer(rank)| JobStatus::of_rank(rank)),
            decision: row.decision,
            rms: row.rms,
            condition: row.condition,
            figures: row.flank_figures.map(Into::into),
            class: row.class.map(|class| class.0),
        };
        (job, row.sort_name)
    }
}

row! {
    pub struct StatusRow {
        status: JobStatus,
        jobs: Integer<u64>,
    }
}

row! {
    pub struct MachineRow {
        machine: String,
        jobs: Integer<u64>,
    }
}

row! {
    /// How many machines there are, and how many jobs have one.
    pub struct MachinesRow {
        machines: Integer<u64>,
        jobs: Integer<u64>,
    }
}

row! {
    /// A day as `2026-11-21`.
    pub struct DayRow {
        day: String,
        jobs: Integer<u64>,
    }
}

/// What was counted.
pub fn counts(
    statuses: Vec<StatusRow>,
    machines: Vec<MachineRow>,
    all: &MachinesRow,
    days: Vec<DayRow>,
) -> Outcome<JobCounts> {
    let day = |row: DayRow| match row.day.parse::<Date>() {
        Ok(day) => Ok((day, row.jobs.0)),
        Err(_) => Err(RepositoryError::Failed(damaged("a day", &row.day))),
    };
    Ok(JobCounts {
        statuses: statuses.into_iter().map(|row| (row.status, row.jobs.0)).collect(),
        machines: machines.into_iter().map(|row| (row.machine, row.jobs.0)).collect(),
        machine_count: all.machines.0,
        with_machine: all.jobs.0,
        days: days.into_iter().map(day).collect::<Result<_, _>>()?,
    })
}
