//! Gear jobs as they are written and read.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{
    api::{
        faults::Faults,
        gears::{gear::GearBody, requirements::RequirementsBody},
        json::{
            text::{Moment, ShortText, Tags},
            writer::text_of,
        },
    },
    jobs::{Job, JobDraft, JobGear, JobPatch, JobStatus, Update},
};

/// A job to create.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NewJob, example = json!({
    "name": "Intermediate shaft, batch 7", "part_number": "A-4711", "serial_number": "000123", "machine": "grinder 3",
    "gear": {"teeth": 52, "normal_module_mm": 1.0, "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 0.0,
             "profile_shift_coefficient": 0.0, "face_width_mm": 20.0},
    "tags": {"shift": "night"}
}))]
pub struct NewJobBody {
    /// Name of the job.
    #[schema(value_type = String, min_length = 1, max_length = 200)]
    pub name: ShortText,
    /// Part number on the drawing.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub part_number: Option<ShortText>,
    /// Serial number of this gear.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub serial_number: Option<ShortText>,
    /// The machine that makes it.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub machine: Option<ShortText>,
    /// The gear that corrections and evaluations of the job's iterations refer to.
    pub gear: Option<GearBody>,
    /// Limits and design of its flanks.
    pub requirements: Option<RequirementsBody>,
    /// At most 50, for finding the job.
    #[serde(default)]
    #[schema(value_type = std::collections::BTreeMap<String, String>, required = false)]
    pub tags: Tags,
}

/// A gear job.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Job)]
pub struct JobBody {
    /// UUIDv7: ids in ascending order are jobs in order of creation.
    pub id: Uuid,
    /// Name of the job.
    pub name: String,
    /// Part number on the drawing.
    pub part_number: Option<String>,
    /// Serial number of this gear.
    pub serial_number: Option<String>,
    /// The machine that makes it.
    pub machine: Option<String>,
    pub gear: Option<GearBody>,
    /// Limits and design of its flanks.
    pub requirements: Option<RequirementsBody>,
    /// Names and values for finding the job.
    #[schema(value_type = std::collections::BTreeMap<String, String>)]
    pub tags: Tags,
    pub status: JobStatus,
    /// Time when the job was stored.
    #[schema(value_type = String, format = DateTime, example = "2026-11-21T08:30:00.000000Z")]
    pub created_at: Moment,
    /// Time of the last change.
    #[schema(value_type = String, format = DateTime, example = "2026-11-21T08:30:00.000000Z")]
    pub updated_at: Moment,
    /// Time of the purge of its nodes, results, texts and names; absent without a purge.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub purged_at: Option<Moment>,
}

/// Changes of a job. Fields that are left out stay unchanged.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = JobPatch, example = json!({"machine": "grinder 4", "tags": {"shift": "day"},
    "clear": ["serial_number"]}))]
pub struct JobPatchBody {
    /// The new name.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub name: Option<ShortText>,
    /// The new part number.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub part_number: Option<ShortText>,
    /// The new serial number.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub serial_number: Option<ShortText>,
    /// The new name of the machine.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub machine: Option<ShortText>,
    /// The new gear, which replaces the old one as a whole.
    pub gear: Option<GearBody>,
    /// The new requirements, which replace the old ones as a whole. Earlier results keep the
    /// requirements they were compared with.
    pub requirements: Option<RequirementsBody>,
    /// The new tags, which replace the old ones as a whole; `{}` leaves none.
    #[schema(value_type = std::collections::BTreeMap<String, String>, required = false)]
    pub tags: Option<Tags>,
    /// Fields to remove. A field listed here cannot be given a value in the same request.
    #[serde(default)]
    #[schema(required = false, max_items = 5)]
    pub clear: Vec<ClearableName>,
}

/// An optional field of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = JobOptionalField)]
pub enum ClearableName {
    PartNumber,
    SerialNumber,
    Machine,
    Gear,
    Requirements,
}

impl ClearableName {
    fn name(self) -> &'static str {
        match self {
            ClearableName::PartNumber => "part_number",
            ClearableName::SerialNumber => "serial_number",
            ClearableName::Machine => "machine",
            ClearableName::Gear => "gear",
            ClearableName::Requirements => "requirements",
        }
    }
}

fn check(gear: Option<&GearBody>, requirements: Option<&RequirementsBody>, faults: &mut Faults) {
    let gear = gear.map(|gear| gear.checked("/gear")).transpose().map_err(|found| faults.append(found));
    if let Some(requirements) = requirements {
        requirements.check(gear.ok().flatten().as_ref(), "/requirements", faults);
    }
}

impl TryFrom<NewJobBody> for JobDraft {
    type Error = Faults;

    fn try_from(body: NewJobBody) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        check(body.gear.as_ref(), body.requirements.as_ref(), &mut faults);
        faults.into_result(())?;
        Ok(JobDraft {
            name: body.name.into(),
            part_number: body.part_number.map(String::from),
            serial_number: body.serial_number.map(String::from),
            machine: body.machine.map(String::from),
            gear: body.gear.as_ref().map(text_of).map(JobGear::from),
            requirements: body.requirements.as_ref().map(text_of).map(Into::into),
            tags: body.tags.0,
        })
    }
}

impl TryFrom<JobPatchBody> for JobPatch {
    type Error = Faults;

    fn try_from(body: JobPatchBody) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        check(body.gear.as_ref(), body.requirements.as_ref(), &mut faults);
        let mut update = |name: ClearableName, value: Option<String>| {
            let cleared: Vec<usize> =
                body.clear.iter().enumerate().filter(|(_, cleared)| **cleared == name).map(|(i, _)| i).collect();
            match value {
                Some(value) => {
                    for i in cleared {
                        let detail =
                            format!("`{}` is given a value at the same time; omit one of the two", name.name());
                        faults.push(format!("/clear/{i}"), detail);
                    }
                    Update::Set(value)
                }
                None if cleared.is_empty() => Update::Keep,
                None => Update::Clear,
            }
        };
        let patch = JobPatch {
            name: body.name.map(String::from),
            part_number: update(ClearableName::PartNumber, body.part_number.map(String::from)),
            serial_number: update(ClearableName::SerialNumber, body.serial_number.map(String::from)),
            machine: update(ClearableName::Machine, body.machine.map(String::from)),
            gear: update(ClearableName::Gear, body.gear.as_ref().map(text_of)).map(JobGear::from),
            requirements: update(ClearableName::Requirements, body.requirements.as_ref().map(text_of)).map(Into::into),
            tags: body.tags.map(|tags| tags.0),
        };
        faults.into_result(patch)
    }
}

impl From<Job> for JobBody {
    fn from(job: Job) -> Self {
        let requirements = RequirementsBody::of(&job);
        JobBody {
            id: job.id,
            name: job.name,
            part_number: job.part_number,
            serial_number: job.serial_number,
            machine: job.machine,
            // What is stored was written by `text_of`; were it damaged, the job would still be
            // shown.
            gear: job.gear.and_then(|text| serde_json::from_str(&text).ok()),
            requirements,
            tags: Tags(job.tags),
            status: job.status,
            created_at: Moment(job.created_at),
            updated_at: Moment(job.updated_at),
            purged_at: job.purged_at.map(Moment),
        }
    }
}
