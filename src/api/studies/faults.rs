//! The table of studies: which place in a request a field stands at.

use flankfit_engine::estimation::{
    self,
    randomization::{StudyField, StudyReason},
};

use crate::api::{faults::Field, fits::faults::within_nodes};

impl Field<StudyReason> for StudyField {
    fn pointer(&self) -> String {
        match *self {
            StudyField::Matrix => "/x".to_owned(),
            StudyField::Row(index) => format!("/x/{index}"),
            StudyField::Coefficients => "/coefficients".to_owned(),
            StudyField::Coefficient(index) => format!("/coefficients/{index}"),
            StudyField::NoiseSigma => "/noise_sigma".to_owned(),
            StudyField::Levels => "/levels".to_owned(),
            StudyField::Level(index) => format!("/levels/{index}"),
            StudyField::Repetitions => "/repetitions".to_owned(),
        }
    }
}

/// The study's matrix goes through the checks of nodes of type matrix, whose lists stand in the
/// request itself.
pub fn of_matrix(field: &estimation::Field) -> String {
    match within_nodes(field) {
        Some(within) if within.is_empty() => "/x".to_owned(),
        Some(within) => within,
        None => field.pointer(),
    }
}
