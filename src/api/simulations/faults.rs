//! The table of the closed loop: where in a request the fields of a machine stand.

use flankfit_engine::gear::{
    correction::fault::CorrectionField,
    simulation::fault::{MachineField, MachineReason},
};

use crate::api::faults::Field;

impl Field<MachineReason> for MachineField {
    fn pointer(&self) -> String {
        match self {
            MachineField::Settings => "/settings".to_owned(),
            MachineField::Matrix => "/matrix".to_owned(),
            MachineField::Entry { row, column } => format!("/matrix/{row}/{column}"),
            MachineField::SettingErrors => "/setting_error".to_owned(),
            MachineField::SettingError { index } => format!("/setting_error/{index}"),
            MachineField::ResponseNoise => "/response_noise".to_owned(),
            MachineField::ProbeNoise => "/probe_noise_um".to_owned(),
            MachineField::Missing => "/missing".to_owned(),
            // numbers within their limits are out of range only when settings have run away
            MachineField::Changes | MachineField::Change { .. } | MachineField::Corrections => {
                "/corrections".to_owned()
            }
        }
    }
}

/// A correction's matrix and settings stand in no object of their own here.
pub fn correction(field: &CorrectionField) -> String {
    match field {
        CorrectionField::Settings => "/settings".to_owned(),
        CorrectionField::Setting { index } => format!("/settings/{index}"),
        CorrectionField::Matrix => "/matrix".to_owned(),
        CorrectionField::Entry { row, column } => format!("/matrix/{row}/{column}"),
        other => other.pointer(),
    }
}
