//! Warnings about gears.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    faults::pointer_of,
    params::{Params, quantity},
};
use flankfit_engine::gear::{
    evaluation::{
        Warning,
        warning::{PitchWarning, RunoutWarning, SurfaceFigure, SurfaceWarning, TOO_FEW, helices_turned, undetermined},
    },
    geometry,
    tolerance::{OutOfScope, not_covered},
};

/// Something that the reader must know.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearWarning)]
pub struct NoticeBody {
    /// Stable.
    pub code: String,
    /// JSON Pointer into the request, where it belongs to a place there.
    pub pointer: Option<String>,
    /// In words, with the numbers that matter.
    pub message: String,
    /// What the message speaks of, by names that tell the units: with `code` enough to say it in
    /// another language. Left out where it speaks of nothing, or where the words are the caller's.
    #[schema(value_type = Option<Object>)]
    pub params: Option<Params>,
    /// The part of the answer that warns, as a JSON Pointer; absent where the warning is of the
    /// whole.
    pub at: Option<String>,
}

impl From<&Warning> for NoticeBody {
    fn from(warning: &Warning) -> Self {
        let pointer = warning.path().map(|path| pointer_of(&path));
        let params = Params::from(warning).some();
        NoticeBody { pointer, params, ..NoticeBody::new(warning.code(), &sentence(warning)) }
    }
}

impl From<&geometry::Warning> for NoticeBody {
    fn from(warning: &geometry::Warning) -> Self {
        NoticeBody { params: Params::from(warning).some(), ..NoticeBody::new(warning.code(), warning) }
    }
}

impl From<&RunoutWarning> for NoticeBody {
    fn from(warning: &RunoutWarning) -> Self {
        let message = match warning {
            RunoutWarning::OutsideTheStandard(out) => format!("no class: {}", out_of_scope(out)),
            other => other.to_string(),
        };
        NoticeBody { params: Params::from(warning).some(), ..NoticeBody::new(warning.code(), &message) }
    }
}

impl From<&SurfaceWarning> for NoticeBody {
    fn from(warning: &SurfaceWarning) -> Self {
        let (pointer, params) = (Some(pointer_of(warning.path())), Params::from(warning).some());
        NoticeBody { pointer, params, ..NoticeBody::new(warning.code(), warning) }
    }
}

impl NoticeBody {
    /// A warning about pitches, with the place in the request of what was measured.
    pub fn of_pitch(warning: &PitchWarning, measured: &str) -> Self {
        let message = match warning {
            PitchWarning::OutsideTheStandard(out) => format!("no classes: {}", out_of_scope(out)),
            other => other.to_string(),
        };
        let pointer = warning.is_of_measured().then(|| measured.to_owned());
        let params = Params::from(warning).some();
        NoticeBody { pointer, params, ..NoticeBody::new(warning.code(), &message) }
    }

    /// A warning about the gear as a whole.
    pub fn new(code: &str, message: &impl std::fmt::Display) -> Self {
        NoticeBody { code: code.to_owned(), pointer: None, message: message.to_string(), params: None, at: None }
    }
}

/// The engine's words, but where the contract has names for what they speak of.
fn sentence(warning: &Warning) -> String {
    match warning {
        Warning::OutsideTheStandard(out) => format!("no classes: {}", out_of_scope(out)),
        Warning::FiguresUndetermined { figures, share_zero, flanks } => {
            let why = if *share_zero {
                TOO_FEW
            } else {
                "each trace has a zero of its own (`traces_share_zero` is false), so that only its slope and shape \
                 count"
            };
            undetermined(figures.iter().map(|figure| name(*figure)), why, flanks).to_string()
        }
        Warning::HelixSignDoubtful { flank, apart, turned } => format!(
            "{}; check `deviation_sign`, which says what a positive deviation of a helix means",
            helices_turned(flank, *apart, *turned)
        ),
        other => other.to_string(),
    }
}

/// By the field of a surface.
pub fn name(figure: SurfaceFigure) -> &'static str {
    match figure {
        SurfaceFigure::HelixCrowning => "helix_crowning_um",
        SurfaceFigure::HelixSlope => "helix_slope_um",
        SurfaceFigure::Mean => "mean_um",
        SurfaceFigure::ProfileCrowning => "profile_crowning_um",
        SurfaceFigure::ProfileSlope => "profile_slope_um",
        SurfaceFigure::Twist => "twist_um",
    }
}

/// What lies outside of the scope of the standard, by the fields of a gear.
pub fn out_of_scope(OutOfScope(excesses): &OutOfScope) -> String {
    not_covered(excesses, quantity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_engine::gear::{
        Side,
        evaluation::warning::FlankName,
        tolerance::{Excess, Quantity},
    };

    #[test]
    fn sentences_name_the_fields_of_the_contract() {
        let flank = || FlankName { tooth: "3".to_owned(), side: Side::Right };
        let figures = vec![SurfaceFigure::ProfileSlope, SurfaceFigure::Twist];
        let open = Warning::FiguresUndetermined { figures, share_zero: false, flanks: vec![flank()] };
        assert_eq!(
            NoticeBody::from(&open).message,
            "the traces do not tell profile_slope_um, twist_um of the surface: each trace has a zero of its own \
             (`traces_share_zero` is false), so that only its slope and shape count; slopes without a twist are those \
             in the sections of the traces (tooth 3 right)"
        );
        let turned = NoticeBody::from(&Warning::HelixSignDoubtful { flank: flank(), apart: 2.0, turned: 0.25 });
        assert_eq!(turned.pointer.as_deref(), Some("/evaluation/deviation_sign"));
        assert_eq!(
            turned.message,
            "tooth 3 right: with the helices turned the contradiction falls from 2.00 to 0.25 µm rms; check \
             `deviation_sign`, which says what a positive deviation of a helix means"
        );
        let excess = Excess { quantity: Quantity::FaceWidth, value: 3.0, scope: [4.0, 1200.0] };
        let beyond = NoticeBody::from(&Warning::OutsideTheStandard(OutOfScope(vec![excess])));
        assert_eq!(
            beyond.message,
            "no classes: ISO 1328-1:2013 does not cover this gear: face_width_mm = 3 is not within 4 and 1200"
        );
    }
}
