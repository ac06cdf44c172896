//! Warnings of registrations and of corrections.

use crate::api::{params::Params, warning::WarningBody};
use flankfit_engine::gear::warning::{Warning, contradicting, tenth};

impl From<&Warning> for WarningBody {
    fn from(warning: &Warning) -> Self {
        let params = Params::from(warning).some();
        WarningBody { params, ..WarningBody::new(warning.code(), sentence(warning)) }
    }
}

/// The engine's words, but where the contract has names for what they speak of.
fn sentence(warning: &Warning) -> String {
    match warning {
        Warning::ScrewUndetermined => {
            "rotation and axial_shift: a screw motion carries the flanks of a helical gear into themselves, and these \
             points do not tell the two apart. Positions along z (`z_mm`) depend on how their joint effect is split: \
             all of it is taken as rotation, the axial shift is left at 0, and neither has a standard error"
                .to_owned()
        }
        Warning::AxialShiftByModification(shift) => format!(
            "axial_shift: {} µm are determined by the modifications alone, which change along z; deviations of the same \
             shape do the same. Leave it out of the motions to have `z_mm` without it",
            tenth(*shift)
        ),
        Warning::TeethContradict(count) => format!(
            "{} on another, where most others lie on theirs; `tooth` says on which: see `teeth`",
            contradicting(*count)
        ),
        other => other.to_string(),
    }
}
