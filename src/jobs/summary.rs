//! Numbers of jobs: by status, by machine, by the week in which they were changed last.

use jiff::{
    Timestamp, ToSpan as _,
    civil::{Date, ISOWeekDate, Weekday},
    tz::TimeZone,
};
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::listing::JobStatus;

/// Machines that are counted apart, those with most jobs first.
pub const MOST_MACHINES: u32 = 100;
/// Weeks that are counted apart, this one included.
pub const MOST_WEEKS: i64 = 53;

/// Counts of a store.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobCounts {
    /// Numbers of jobs by status.
    pub statuses: Vec<(JobStatus, u64)>,
    /// Those with most jobs first, then by name, at most [`MOST_MACHINES`].
    pub machines: Vec<(String, u64)>,
    /// All of them, and the jobs that have one.
    pub machine_count: u64,
    pub with_machine: u64,
    /// Jobs changed last on a day (UTC) from a certain time on, in order.
    pub days: Vec<(Date, u64)>,
}

/// Numbers of jobs.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct JobSummary {
    /// All jobs.
    pub total: u64,
    /// Every status, including those without a job.
    pub by_status: Vec<StatusCount>,
    /// Machines by their jobs, those with most first, at most 100.
    pub by_machine: Vec<MachineCount>,
    /// Machines in addition to those; absent where all are listed.
    pub other_machines: Option<OtherMachines>,
    /// Jobs without a machine.
    pub without_machine: u64,
    /// Weeks of the last changes, oldest first: those of the last 53 weeks, this one included, with
    /// jobs.
    pub by_week: Vec<WeekCount>,
    /// Jobs that were last changed before those 53 weeks.
    pub earlier: u64,
}

/// Jobs of one status.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct StatusCount {
    pub status: JobStatus,
    /// Number of jobs with this status.
    pub count: u64,
}

/// Jobs on one machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct MachineCount {
    /// Name of the machine in the jobs.
    pub machine: String,
    /// Number of jobs on it.
    pub count: u64,
}

/// Machines that are not listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct OtherMachines {
    /// Number of these machines.
    pub machines: u64,
    /// Number of jobs on them.
    pub count: u64,
}

/// Jobs changed last in one week.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct WeekCount {
    /// Year and week of ISO 8601, in UTC.
    #[schema(example = "2026-W47")]
    pub week: String,
    /// Date of its Monday.
    #[schema(value_type = String, format = Date, example = "2026-11-16")]
    pub begins: String,
    /// Number of jobs that were last changed in it.
    pub count: u64,
}

/// When the first of the weeks that are counted apart begins.
pub fn first_week(now: Timestamp) -> Timestamp {
    let today = now.to_zoned(TimeZone::UTC).date();
    let monday = monday(today.iso_week_date());
    let first = monday.checked_sub((MOST_WEEKS - 1).weeks()).unwrap_or(Date::MIN);
    first.to_zoned(TimeZone::UTC).map_or(Timestamp::MIN, |first| first.timestamp())
}

/// Returns the first day of a week.
fn monday(week: ISOWeekDate) -> Date {
    ISOWeekDate::new(week.year(), week.week(), Weekday::Monday).map_or(Date::MIN, |monday| monday.date())
}

impl JobCounts {
    /// Returns their summary.
    pub fn summary(self) -> JobSummary {
        let of = |status| self.statuses.iter().filter(|(found, _)| *found == status).map(|(_, count)| count).sum();
        let by_status: Vec<StatusCount> =
            JobStatus::ALL.into_iter().map(|status| StatusCount { status, count: of(status) }).collect();
        let total = by_status.iter().map(|one| one.count).sum::<u64>();
        let listed = self.machines.iter().map(|(_, count)| count).sum::<u64>();
        let mut by_week: Vec<WeekCount> = Vec::new();
        for (day, count) in &self.days {
            let date = day.iso_week_date();
            let week = format!("{:04}-W{:02}", date.year(), date.week());
            match by_week.last_mut().filter(|last| last.week == week) {
                Some(last) => last.count += count,
                None => by_week.push(WeekCount { week, begins: monday(date).to_string(), count: *count }),
            }
        }
        let counted = by_week.iter().map(|week| week.count).sum::<u64>();
        let machines = self.machine_count.saturating_sub(self.machines.len() as u64);
        JobSummary {
            total,
            by_status,
            other_machines: (machines > 0)
                .then(|| OtherMachines { machines, count: self.with_machine.saturating_sub(listed) }),
            by_machine: self.machines.into_iter().map(|(machine, count)| MachineCount { machine, count }).collect(),
            without_machine: total.saturating_sub(self.with_machine),
            by_week,
            earlier: total.saturating_sub(counted),
        }
    }
}

#[cfg(test)]
mod tests {
    use jiff::civil::date;

    use super::*;

    #[test]
    fn weeks_are_those_of_iso_8601() {
        let counts = JobCounts {
            statuses: vec![(JobStatus::Open, 9), (JobStatus::New, 2)],
            machines: vec![("K300".to_owned(), 4), ("K200".to_owned(), 3)],
            machine_count: 5,
            with_machine: 10,
            // 2026 has 53 weeks: its last one ends on 3 January 2027
            days: vec![(date(2026, 12, 27), 1), (date(2026, 12, 28), 2), (date(2027, 1, 3), 3), (date(2027, 1, 4), 1)],
        };
        let summary = counts.summary();
        let weeks: Vec<_> = summary.by_week.iter().map(|week| (&*week.week, &*week.begins, week.count)).collect();
        assert_eq!(
            weeks,
            [("2026-W52", "2026-12-21", 1), ("2026-W53", "2026-12-28", 5), ("2027-W01", "2027-01-04", 1)]
        );
        assert_eq!((summary.total, summary.earlier, summary.without_machine), (11, 4, 1));
        assert_eq!(summary.other_machines, Some(OtherMachines { machines: 3, count: 3 }));
        assert_eq!(summary.by_status[0], StatusCount { status: JobStatus::New, count: 2 });
        assert_eq!(summary.by_status[4], StatusCount { status: JobStatus::Rejected, count: 0 });
    }

    #[test]
    fn there_are_53_weeks_with_this_one() {
        let now: Timestamp = "2027-01-06T12:00:00Z".parse().unwrap();
        assert_eq!(first_week(now), "2026-01-05T00:00:00Z".parse().unwrap());
        let monday: Timestamp = "2026-11-23T00:00:00Z".parse().unwrap();
        assert_eq!(first_week(monday), "2025-11-24T00:00:00Z".parse().unwrap());
    }
}
