//! The query of the list of jobs.

use serde::{
    Deserialize,
    de::{DeserializeOwned, value::StrDeserializer},
};
use utoipa::IntoParams;

use super::paging::{UNKNOWN_CURSOR, of_other_list, read_limit};
use crate::{
    api::{
        faults::Faults,
        jobs::job_list,
        json::{
            refusal::Refusal,
            text::{Moment, SHORT, ShortText, Text},
        },
        problem::Problem,
    },
    jobs::{CursorError, JobFilter, JobPlace, JobPlaceError, JobQuery, JobSort, JobStatus, List, folded},
};

/// Which jobs are wanted: those for which all of this holds.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct JobsQuery {
    /// Text that occurs in name, part number, serial number, machine or a tag (as `name:value`), in
    /// upper or lower case.
    #[param(min_length = 1, max_length = 200)]
    q: Option<String>,
    /// Status of the job.
    #[param(inline, value_type = Option<JobStatus>)]
    status: Option<String>,
    /// The whole name of the machine.
    #[param(min_length = 1, max_length = 200)]
    machine: Option<String>,
    /// The whole part number.
    #[param(min_length = 1, max_length = 200)]
    part_number: Option<String>,
    /// Class of ISO 1328-1 in the job's latest evaluation.
    #[param(value_type = Option<u8>, minimum = 1, maximum = 11)]
    class: Option<String>,
    /// The name of a tag, whatever its value, or `name:value`.
    #[param(min_length = 1, max_length = 401)]
    tag: Option<String>,
    /// Changed at this time (`changed_at`) or later.
    #[param(value_type = Option<String>, format = DateTime)]
    from: Option<String>,
    /// Changed before this time, which is later than `from`.
    #[param(value_type = Option<String>, format = DateTime)]
    to: Option<String>,
    /// `changed`, last changed first (default); `name`, in alphabetical order ignoring case;
    /// `created`, newest first.
    #[param(inline, value_type = Option<JobSort>)]
    sort: Option<String>,
    /// Most items on a page.
    #[param(value_type = Option<u32>, minimum = 1, maximum = 200, default = 50)]
    limit: Option<String>,
    /// `next_cursor` of the page before, of the same `sort`.
    cursor: Option<String>,
}

impl JobsQuery {
    /// Checks the query and fills in its defaults.
    pub fn check(self) -> Result<JobQuery, Problem> {
        let mut faults = Faults::default();
        let text = value::<ShortText>("/q", self.q, &mut faults);
        let status = value::<JobStatus>("/status", self.status, &mut faults);
        let machine = value::<ShortText>("/machine", self.machine, &mut faults);
        let part_number = value::<ShortText>("/part_number", self.part_number, &mut faults);
        let class = self.class.map(|text| job_list::class_of(&text)).transpose();
        let class = class.map_err(|why| faults.push("/class", why)).ok().flatten();
        let tag = value::<Text<{ 2 * SHORT + 1 }>>("/tag", self.tag, &mut faults);
        let since = value::<Moment>("/from", self.from, &mut faults);
        let to = value::<Moment>("/to", self.to, &mut faults);
        if let (Some(Moment(since)), Some(Moment(to))) = (since, to)
            && to <= since
        {
            faults.push("/to", "it must be later than `from`; the range includes `from` and excludes `to`");
        }
        let sort: Option<JobSort> = value("/sort", self.sort, &mut faults);
        let limit = read_limit(self.limit.as_deref(), &mut faults);
        let sort = sort.unwrap_or_default();
        let from = match self.cursor.map(|text| JobPlace::decode(&text, sort)) {
            None => JobPlace::beginning(sort),
            Some(Ok(place)) => place,
            Some(Err(error)) => {
                faults.push("/cursor", message_of(error, sort));
                JobPlace::beginning(sort)
            }
        };
        let filter = JobFilter {
            text: text.map(|text| folded(text.as_str())),
            status,
            machine: machine.map(Into::into),
            part_number: part_number.map(Into::into),
            class,
            tag: tag.map(Into::into),
            from: since.map(|Moment(time)| time),
            to: to.map(|Moment(time)| time),
        };
        faults.into_result(JobQuery { filter, limit, from }).map_err(Problem::invalid)
    }
}

/// The value of a parameter, read as the same value in a body is.
fn value<T: DeserializeOwned>(pointer: &str, text: Option<String>, faults: &mut Faults) -> Option<T> {
    match T::deserialize(StrDeserializer::<Refusal>::new(text.as_deref()?)) {
        Ok(value) => Some(value),
        Err(refusal) => {
            faults.push(pointer, refusal.to_string());
            None
        }
    }
}

fn message_of(error: JobPlaceError, sort: JobSort) -> String {
    match error {
        JobPlaceError::Cursor(CursorError::Unknown) => UNKNOWN_CURSOR.to_owned(),
        JobPlaceError::Cursor(CursorError::OtherList(other)) => of_other_list(List::Jobs, other),
        JobPlaceError::OtherSort(other) => format!(
            "it belongs to jobs sorted by `{}`, not by `{}`; use the same `sort` on each page, or omit the cursor",
            other.name(),
            sort.name()
        ),
    }
}
