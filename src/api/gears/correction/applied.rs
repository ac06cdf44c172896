//! The changes that were entered on the machine in place of those of a correction.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::result::CorrectionResultBody;
use crate::{
    api::{
        faults::Faults,
        json::{
            location::escape,
            text::{LongText, Moment},
            writer,
        },
        problem::Problem,
    },
    jobs::{Record, RecordDraft, RecordKind},
};
use flankfit_engine::gear::correction::Change;

/// Greatest change of a setting, in its unit: far above any machine, and small enough to be
/// squared.
const MOST_CHANGE: f64 = 1e12;

/// Changes that were entered on the machine after a correction.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = AppliedRequest)]
pub struct AppliedRequestBody {
    /// The change of each setting in its unit, by the names of the correction; 0 for an unchanged
    /// setting. A setting that is not named was changed as proposed.
    pub settings: BTreeMap<String, f64>,
    /// Note, such as the reason why the settings differ from the correction. May have line breaks.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
    pub note: Option<LongText>,
}

/// Changes that were entered on the machine, with time and actor.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AppliedChanges)]
pub struct AppliedChangesBody {
    /// UUIDv7 of the record.
    pub id: Uuid,
    /// When it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Actor of the caller who entered them; absent where no key was required.
    pub by: Option<String>,
    /// Every setting of the correction, in its order.
    pub settings: Vec<AppliedChangeBody>,
    /// Note on the changes.
    pub note: Option<String>,
}

/// The change of a setting that was entered, and the proposed one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AppliedChange)]
pub struct AppliedChangeBody {
    /// The setting.
    pub name: String,
    /// Unit of the change.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// The change that was entered.
    pub change: f64,
    /// The change of the correction.
    pub proposed: f64,
}

/// The result of a record of applied changes.
#[skip_serializing_none]
#[derive(Serialize, Deserialize)]
struct AppliedResult {
    /// The record of the correction.
    correction_id: Uuid,
    /// The iteration that the correction is kept with.
    iteration: u32,
    settings: Vec<AppliedChangeBody>,
    note: Option<String>,
}

/// Returns the record of what was entered after `correction`, which is stored with the iteration
/// numbered `iteration`. Pointers of errors begin with `at`.
pub fn draft(
    asked: &AppliedRequestBody,
    correction: &Record,
    iteration: u32,
    at: &str,
) -> Result<RecordDraft, Problem> {
    let proposed = CorrectionResultBody::of(correction)?;
    let mut faults = Faults::default();
    for (name, change) in &asked.settings {
        let pointer = format!("{at}/settings/{}", escape(name));
        if !proposed.settings.iter().any(|setting| setting.name == *name) {
            let names: Vec<String> = proposed.settings.iter().map(|setting| format!("`{}`", setting.name)).collect();
            faults.push(pointer, format!("the correction has no such setting; it has {}", names.join(", ")));
        } else if change.abs() > MOST_CHANGE {
            faults.push(pointer, format!("a change lies between {:e} and {MOST_CHANGE:e}", -MOST_CHANGE));
        }
    }
    faults.into_result(()).map_err(Problem::invalid)?;
    let entered = |setting: Change| AppliedChangeBody {
        change: asked.settings.get(&setting.name).copied().unwrap_or(setting.change),
        proposed: setting.change,
        name: setting.name,
        unit: setting.unit,
    };
    let result = AppliedResult {
        correction_id: correction.id,
        iteration,
        settings: proposed.settings.into_iter().map(entered).collect(),
        note: asked.note.clone().map(String::from),
    };
    Ok(RecordDraft {
        kind: RecordKind::Applied,
        method: correction.draft.method.clone(),
        request: writer::text_of(asked).into(),
        result: writer::text_of(&result).into(),
        gear: None,
        class: None,
        measurand: None,
    })
}

/// Returns the changes of a record that is about to be stored if it is of the correction
/// `correction`.
pub fn entered_of(correction: Uuid, draft: &RecordDraft) -> Result<Option<Vec<f64>>, Problem> {
    let result: AppliedResult = serde_json::from_str(&draft.result).map_err(Problem::internal)?;
    let of_it = result.correction_id == correction;
    Ok(of_it.then(|| result.settings.iter().map(|setting| setting.change).collect()))
}

/// Returns what the record says if it is of the correction `correction`.
pub fn entered_after(correction: Uuid, record: &Record) -> Result<Option<AppliedChangesBody>, Problem> {
    let result: AppliedResult = serde_json::from_str(&record.draft.result).map_err(Problem::internal)?;
    Ok((result.correction_id == correction).then(|| AppliedChangesBody {
        id: record.id,
        created_at: Moment(record.created_at),
        by: record.by.as_deref().map(str::to_owned),
        settings: result.settings,
        note: result.note,
    }))
}
