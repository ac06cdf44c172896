//! Numbers of jobs: by status, by machine, by the week in which they were changed last.

use jiff::{
    Timestamp, ToSpan as _,
    civil::{Date, ISOWeekDate, Weekday},
    tz::TimeZone,
};

use super::listing::JobStatus;

/// Machines that are counted apart, those with most jobs first.
pub const MOST_MACHINES: u32 = 100;
/// Weeks that are counted apart, this one included.
pub const MOST_WEEKS: i64 = 53;

/// What a store counts.
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
#[derive(Clone, Debug, PartialEq)]
pub struct JobSummary {
    pub total: u64,
    pub by_status: Vec<(JobStatus, u64)>,
    pub by_machine: Vec<(String, u64)>,
    /// Machines that are not listed, and their jobs.
    pub other_machines: (u64, u64),
    pub without_machine: u64,
    /// Weeks in which some job was changed last, oldest first.
    pub by_week: Vec<(ISOWeekDate, u64)>,
    /// Jobs changed last before those weeks.
    pub earlier: u64,
}

/// When the first of the weeks that are counted apart begins.
pub fn first_week(now: Timestamp) -> Timestamp {
    let today = now.to_zoned(TimeZone::UTC).date();
    let monday = monday(today.iso_week_date());
    let first = monday.checked_sub((MOST_WEEKS - 1).weeks()).unwrap_or(Date::MIN);
    first.to_zoned(TimeZone::UTC).map_or(Timestamp::MIN, |first| first.timestamp())
}

/// The first day of a week.
pub fn monday(week: ISOWeekDate) -> Date {
    ISOWeekDate::new(week.year(), week.week(), Weekday::Monday).map_or(Date::MIN, |monday| monday.date())
}

impl JobCounts {
    /// What is told of them.
    pub fn summary(self) -> JobSummary {
        let of = |status| self.statuses.iter().filter(|(found, _)| *found == status).map(|(_, count)| count).sum();
        let by_status: Vec<(JobStatus, u64)> = JobStatus::ALL.into_iter().map(|status| (status, of(status))).collect();
        let total = by_status.iter().map(|(_, count)| count).sum::<u64>();
        let listed = self.machines.iter().map(|(_, count)| count).sum::<u64>();
        let mut by_week: Vec<(ISOWeekDate, u64)> = Vec::new();
        for (day, count) in &self.days {
            let week = day.iso_week_date();
            match by_week.last_mut().filter(|(last, _)| (last.year(), last.week()) == (week.year(), week.week())) {
                Some((_, jobs)) => *jobs += count,
                None => by_week.push((week, *count)),
            }
        }
        let told = by_week.iter().map(|(_, count)| count).sum::<u64>();
        JobSummary {
            total,
            by_status,
            other_machines: (
                self.machine_count.saturating_sub(self.machines.len() as u64),
                self.with_machine.saturating_sub(listed),
            ),
            by_machine: self.machines,
            without_machine: total.saturating_sub(self.with_machine),
            by_week,
            earlier: total.saturating_sub(told),
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
        let weeks: Vec<_> = summary.by_week.iter().map(|(week, n)| (week.year(), week.week(), *n)).collect();
        assert_eq!(weeks, [(2026, 52, 1), (2026, 53, 5), (2027, 1, 1)]);
        assert_eq!(monday(summary.by_week[1].0), date(2026, 12, 28));
        assert_eq!((summary.total, summary.earlier, summary.without_machine), (11, 4, 1));
        assert_eq!(summary.other_machines, (3, 3));
        assert_eq!(summary.by_status[0], (JobStatus::New, 2));
        assert_eq!(summary.by_status[4], (JobStatus::Rejected, 0));
    }

    #[test]
    fn there_are_53_weeks_with_this_one() {
        let now: Timestamp = "2027-01-06T12:00:00Z".parse().unwrap();
        assert_eq!(first_week(now), "2026-01-05T00:00:00Z".parse().unwrap());
        let monday: Timestamp = "2026-11-23T00:00:00Z".parse().unwrap();
        assert_eq!(first_week(monday), "2025-11-24T00:00:00Z".parse().unwrap());
    }
}
