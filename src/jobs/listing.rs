//! The list of jobs: filters, order, and the columns of each job.

use std::{collections::BTreeMap, sync::Arc};

use flankfit_engine::gear::Side;
use jiff::Timestamp;
use uuid::Uuid;

use super::{
    page::{JOBS_BY_CHANGE, JOBS_BY_NAME},
    rows::{of_hex, to_hex},
};
use crate::jobs::*;

/// Status of a flank or a job. A flank (of a tooth) has the status of the latest decision on its
/// newest iteration, `open` without a decision. A job has the first of `rejected`, `remachine`,
/// `open` and `accepted` that one of its measured flanks has; `new` without iterations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobStatus {
    /// Nothing has been measured.
    New,
    /// Without a decision on the newest iteration.
    Open,
    Remachine,
    Accepted,
    Rejected,
}

names! {
    JobStatus { New "new", Open "open", Remachine "remachine", Accepted "accepted", Rejected "rejected" }
    JobSort { Changed "changed", Name "name", Created "created" }
}

/// A job with the status of its last iteration.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedJob {
    pub job: Job,
    pub iteration_count: u32,
    /// When anything of the job was stored last: its data, an iteration, a fit, a choice, a
    /// decision, a record.
    pub changed_at: Timestamp,
    /// When the last iteration was measured, or stored where that is not known.
    pub last_measured_at: Option<Timestamp>,
    /// Flank of the last iteration.
    pub flank: Option<Side>,
    /// Status of the measured left flanks, if there are any.
    pub left: Option<JobStatus>,
    /// Status of the measured right flanks, if there are any.
    pub right: Option<JobStatus>,
    /// The latest decision on the last iteration.
    pub decision: Option<Decision>,
    /// RMS of the chosen fit of the last iteration.
    pub rms: Option<f64>,
    /// Condition of the same fit.
    pub condition: Option<f64>,
    /// The figures of the flank that the same fit is of, a JSON document.
    pub figures: Option<Arc<str>>,
    /// Class of ISO 1328-1 in the job's latest evaluation.
    pub class: Option<u8>,
}

/// Which jobs are wanted: those for which all of this holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobFilter {
    /// Stands in the text of [`Job::searched`], folded as that is.
    pub text: Option<String>,
    pub status: Option<JobStatus>,
    pub machine: Option<String>,
    pub part_number: Option<String>,
    pub class: Option<u8>,
    /// The name of a tag, or name and value with a colon between them.
    pub tag: Option<String>,
    /// Changed at this time or later.
    pub from: Option<Timestamp>,
    /// Changed before this time.
    pub to: Option<Timestamp>,
}

/// Order of the list: `changed`, last changed first; `name`, in alphabetical order ignoring case;
/// `created`, newest first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobSort {
    /// Last changed first.
    #[default]
    Changed,
    /// By name, in whatever letters.
    Name,
    /// Newest first.
    Created,
}

impl JobSort {
    /// Returns the beginning of its cursors: two digits that no other list's begin with.
    fn kind(self) -> &'static str {
        match self {
            JobSort::Changed => JOBS_BY_CHANGE,
            JobSort::Name => JOBS_BY_NAME,
            JobSort::Created => "01",
        }
    }
}

/// How much of which jobs is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobQuery {
    pub filter: JobFilter,
    pub limit: u32,
    pub from: JobPlace,
}

/// The order of a list of jobs, and the job after which it is read: by what it is sorted by as it
/// was when it was listed, so that the place stays when the job is changed or deleted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum JobPlace {
    Changed(Option<(Timestamp, Uuid)>),
    /// The name is folded.
    Name(Option<(String, Uuid)>),
    Created(Option<Uuid>),
}

impl Default for JobPlace {
    fn default() -> Self {
        JobPlace::beginning(JobSort::default())
    }
}

/// Why a text is no place in a list of jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobPlaceError {
    Cursor(CursorError),
    /// It is one of the same list in another order.
    OtherSort(JobSort),
}

impl JobPlace {
    /// Before the first job.
    pub fn beginning(sort: JobSort) -> Self {
        match sort {
            JobSort::Changed => JobPlace::Changed(None),
            JobSort::Name => JobPlace::Name(None),
            JobSort::Created => JobPlace::Created(None),
        }
    }

    /// Behind a job, in the same order.
    fn behind(&self, last: &ListedJob, sort_name: &str) -> JobPlace {
        let id = last.job.id;
        match self {
            JobPlace::Changed(_) => JobPlace::Changed(Some((last.changed_at, id))),
            JobPlace::Name(_) => JobPlace::Name(Some((sort_name.to_owned(), id))),
            JobPlace::Created(_) => JobPlace::Created(Some(id)),
        }
    }

    /// The cursor as it travels: two digits for list and order, the id, and what is sorted by.
    pub fn encode(&self) -> Option<String> {
        Some(match self {
            JobPlace::Changed(place) => {
                let (time, id) = place.as_ref()?;
                // two's complement
                format!("{}{}{:016x}", JobSort::Changed.kind(), id.simple(), time.as_microsecond())
            }
            JobPlace::Name(place) => {
                let (name, id) = place.as_ref()?;
                format!("{}{}{}", JobSort::Name.kind(), id.simple(), to_hex(name.as_bytes()))
            }
            JobPlace::Created(place) => Cursor(*place.as_ref()?).encode(List::Jobs),
        })
    }

    /// The place of that text, if it is one of this order.
    pub fn decode(text: &str, sort: JobSort) -> Result<Self, JobPlaceError> {
        let unknown = JobPlaceError::Cursor(CursorError::Unknown);
        let (kind, rest) = text.split_at_checked(2).ok_or(unknown)?;
        let Some(of) = JobSort::ALL.into_iter().find(|sort| sort.kind() == kind) else {
            // perhaps of another list
            return Err(JobPlaceError::Cursor(Cursor::decode(text, List::Jobs).err().unwrap_or(CursorError::Unknown)));
        };
        let (id, key) = rest.split_at_checked(32).ok_or(unknown)?;
        let id = Uuid::try_parse(id).map_err(|_| unknown)?;
        let place = match of {
            JobSort::Changed => {
                // parsing alone would take a sign
                let digits = key.len() == 16 && key.bytes().all(|digit| digit.is_ascii_hexdigit());
                let micros = digits.then(|| u64::from_str_radix(key, 16).ok()).flatten().ok_or(unknown)?;
                let time = Timestamp::from_microsecond(micros.cast_signed()).map_err(|_| unknown)?;
                JobPlace::Changed(Some((time, id)))
            }
            JobSort::Name => JobPlace::Name(Some((text_of_hex(key).ok_or(unknown)?, id))),
            JobSort::Created if key.is_empty() => JobPlace::Created(Some(id)),
            JobSort::Created => return Err(unknown),
        };
        if of == sort { Ok(place) } else { Err(JobPlaceError::OtherSort(of)) }
    }
}

fn text_of_hex(digits: &str) -> Option<String> {
    // a name has no control characters
    String::from_utf8(of_hex(digits)?).ok().filter(|text| !text.chars().any(char::is_control))
}

/// Some jobs, and where to go on.
#[derive(Clone, Debug, PartialEq)]
pub struct JobPage {
    pub items: Vec<ListedJob>,
    pub next: Option<JobPlace>,
}

impl JobPage {
    /// Makes a page of jobs, each with its sort name. One job more than requested shows that
    /// there is a next page.
    pub fn of(mut jobs: Vec<(ListedJob, String)>, query: &JobQuery) -> Self {
        let limit = usize::try_from(query.limit).unwrap_or(usize::MAX);
        let more = jobs.len() > limit;
        jobs.truncate(limit);
        let next = jobs.last().filter(|_| more).map(|(job, sort_name)| query.from.behind(job, sort_name));
        JobPage { items: jobs.into_iter().map(|(job, _)| job).collect(), next }
    }
}

impl Job {
    /// Returns the text that is searched, folded: name, part number, serial number, machine and
    /// tags, each with a line end behind it. (None of them has one within.)
    pub fn searched(&self) -> String {
        let others = [&self.part_number, &self.serial_number, &self.machine].map(Option::as_deref);
        let [part_number, serial_number, machine] = others;
        searched_text([Some(&self.name), part_number, serial_number, machine], &self.tags)
    }
}

/// Returns the text of [`Job::searched`] of name, part number, serial number and machine, and of
/// tags.
pub fn searched_text(fields: [Option<&str>; 4], tags: &BTreeMap<String, String>) -> String {
    let mut text = String::new();
    for field in fields {
        text.push_str(field.unwrap_or_default());
        text.push('\n');
    }
    for (name, value) in tags {
        text.extend([name, ":", value, "\n"]);
    }
    folded(&text)
}

/// A text without the difference of upper and lower case, letter by letter, so that a part of a
/// text is a part of it folded.
pub fn folded(text: &str) -> String {
    text.chars().flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_travels_within_its_order() {
        let id = Uuid::from_u128(0x0123_4567_89ab);
        let time = Timestamp::from_microsecond(-5).unwrap();
        let places = [
            (JobSort::Changed, JobPlace::Changed(Some((time, id)))),
            (JobSort::Name, JobPlace::Name(Some(("wälz 7".to_owned(), id)))),
            (JobSort::Created, JobPlace::Created(Some(id))),
        ];
        for (sort, place) in &places {
            let text = place.encode().unwrap();
            assert_eq!(JobPlace::decode(&text, *sort).as_ref(), Ok(place), "{text}");
            for other in JobSort::ALL.into_iter().filter(|other| other != sort) {
                assert_eq!(JobPlace::decode(&text, other), Err(JobPlaceError::OtherSort(*sort)));
            }
            assert_eq!(JobPlace::beginning(*sort).encode(), None);
        }
        let of_fits = Cursor(id).encode(List::Fits);
        let other = Err(JobPlaceError::Cursor(CursorError::OtherList(List::Fits)));
        assert_eq!(JobPlace::decode(&of_fits, JobSort::Changed), other);
        let simple = id.simple();
        for text in [
            String::new(),
            "0é".to_owned(),
            format!("0b{simple}"),
            format!("0b{simple}00000000000000"),
            format!("0b{simple}7fffffffffffffff"),
            format!("0b{simple}+00000000000000f"),
            format!("0c{simple}0"),
            format!("0c{simple}ff"),
            format!("0c{simple}+a"),
            format!("0c{simple}0a"),
            format!("01{simple}00"),
            format!("01{id}"),
        ] {
            let unknown = Err(JobPlaceError::Cursor(CursorError::Unknown));
            assert_eq!(JobPlace::decode(&text, JobSort::Changed), unknown, "{text}");
        }
    }

    #[test]
    fn a_part_of_a_text_is_a_part_of_it_folded() {
        for (text, part) in [("Wälzfräse", "WÄLZ"), ("ΟΔΟΣ", "οδοσ"), ("İstanbul 7", "STANBUL"), ("A-4711", "a-47")]
        {
            assert!(folded(text).contains(&folded(part)), "{text} {part}");
        }
    }
}
