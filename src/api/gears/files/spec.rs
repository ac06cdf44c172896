//! Description of a file.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    faults::Faults,
    gears::{evaluation::request::EvaluationSettingsBody, gear::GearBody},
    json::text::ShortText,
    problem::Problem,
};
use flankfit_engine::{
    formats::gear_file::GearFile,
    gear::{Side, evaluation::settings::DeviationSign},
};

/// Description of a file: the part `spec` of the form.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ImportSpec)]
pub struct ImportSpecBody {
    /// Replaces the job's gear, which takes precedence over that of the file.
    pub gear: Option<GearBody>,
    /// The tooth whose traces become nodes. By default the one with the most of them.
    pub tooth: Option<String>,
    /// The flank whose traces become nodes. Default `left`, where it was measured.
    pub flank: Option<Side>,
    /// Settings of the evaluation of traces. Omitted ranges and reference lengths are those of the
    /// file.
    pub evaluation: Option<EvaluationSettingsBody>,
    /// For a REXS model: the id of the gear whose flanks become nodes. Required if there are
    /// several.
    pub component: Option<String>,
    /// Radius of the probe ball, if the points are its centres.
    pub probe_radius_mm: Option<f64>,
    /// Kept as the iteration's instrument, 1 to 200 characters.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub instrument: Option<ShortText>,
    /// Kept as the iteration's note, 1 to 4000 characters. By default a sentence says what was
    /// imported.
    pub note: Option<String>,
}

impl ImportSpecBody {
    /// Refuses what says nothing about such a file.
    pub fn belongs_to(&self, file: &GearFile) -> Result<(), Problem> {
        let (curves, model, points) = match file {
            GearFile::Curves(_) => (true, false, false),
            GearFile::Model(_) => (false, true, false),
            GearFile::Table(table) => (false, false, table.holds_points()),
            // refused as a whole
            GearFile::Values(_) => (true, true, true),
        };
        let mut faults = Faults::default();
        for (name, given, known, of) in [
            ("evaluation", self.evaluation.is_some(), curves || model, "curves or models"),
            ("component", self.component.is_some(), model, "REXS models"),
            ("probe_radius_mm", self.probe_radius_mm.is_some(), points, "points"),
        ] {
            if given && !known {
                faults.push(format!("/spec/{name}"), format!("it belongs to files of {of}, which this one is not"));
            }
        }
        let sign = self.evaluation.as_ref().and_then(|evaluation| evaluation.deviation_sign);
        if curves && sign.is_some_and(|sign| sign != DeviationSign::Din) {
            let detail = "the file defines the sign of its deviations; they are converted to DIN";
            faults.push("/spec/evaluation/deviation_sign", detail);
        }
        faults.into_result(()).map_err(Problem::invalid)
    }
}
