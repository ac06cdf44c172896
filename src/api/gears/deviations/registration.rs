//! How a measured part lies in the nominal one.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    faults::{is_within, pointer_of},
    fits::answer::FitResultBody,
    problem::Problem,
    warning::WarningBody,
};
use flankfit_engine::{estimation::FitError, gear::registration::Registration};

/// The motions of the part that were found; the deviations beside them are those of the part
/// carried back.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearRegistration)]
pub struct RegistrationBody<'a> {
    /// How the part was moved, one entry for each motion that was asked for.
    pub motions: Vec<MotionBody>,
    /// z of the point about which the axis tilts.
    pub pivot_z_mm: f64,
    /// Root mean square of the deviations as they were measured.
    pub rms_before_um: f64,
    /// Root mean square of the deviations after the part has been carried back.
    pub rms_after_um: f64,
    /// Steps of linearisation that were made.
    pub iterations: usize,
    /// Whether the last step moved nothing that matters.
    pub converged: bool,
    /// Motions that these points do not tell apart.
    pub indistinguishable: Vec<IndistinguishableBody>,
    /// The last fit, as `POST /v1/fits` answers it: heights are normal deviations in µm.
    pub result: FitResultBody<'a>,
    /// Where motions were taken together in the fit: plain least squares with a column for each
    /// (spectrum, collinearity).
    pub every_motion: Option<FitResultBody<'a>>,
    /// `rotation_modulo_pitch`: no point tells its tooth. `flanks_reassigned`: points lie on other
    /// flanks than were nearest before. Doubts: `flanks_ambiguous`, `teeth_contradict` (points
    /// count on the teeth that they lie on, not on those told), `axial_shift_for_rotation`,
    /// `poor_fit`, `points_misfit`, `points_beyond_flank`, `registration_not_converged`.
    /// `motions_indistinguishable`: rotation and axial shift of a helical part are one motion, and
    /// all of it is taken as rotation; `axial_shift_by_modification`: modifications that change
    /// along z, and they alone, told the two apart.
    pub warnings: Vec<WarningBody>,
}

/// A motion of the part.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = PartMotion)]
pub struct MotionBody {
    /// `x_shift`, `y_shift`, `axial_shift`, `x_tilt`, `y_tilt` or `rotation`.
    pub motion: String,
    /// How far the part was moved, in `unit`.
    pub value: f64,
    /// Where the fit began, 0 but for parts that lie off by more than a tenth of the module:
    /// coefficients of `result`, and what regularisation damps, count from there.
    pub start: f64,
    /// `um` or `urad`.
    pub unit: String,
    /// By the scatter of the points, each by itself: what moves all points of a flank together, as
    /// a pitch deviation does, is not in it (docs/reference/gears.md). Left out where the points do
    /// not determine the motion. Where a regularisation chose its λ* by these points it is too
    /// small, as in any fit.
    pub std_error: Option<f64>,
    /// Sharp bound on what regularisation moved.
    pub bias_bound: Option<f64>,
    /// Whether these points tell it from the other motions at all.
    pub determined: bool,
}

/// What cannot be told apart.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Indistinguishable)]
pub struct IndistinguishableBody {
    /// Motions of a registration, settings of a correction.
    pub names: Vec<String>,
    /// Left out where it is infinite.
    pub condition_index: Option<f64>,
    /// The same in words.
    pub sentence: String,
}

/// A refused registration, by places in the request.
pub fn refused(error: FitError) -> Problem {
    Problem::of_fit(error, |path| match path {
        _ if is_within(path, &["nodes"]) => "/points".to_owned(),
        _ if is_within(path, &["model"]) => "/registration/motions".to_owned(),
        _ => pointer_of(path),
    })
}

impl<'a> RegistrationBody<'a> {
    /// Creates the answer; `digest` is that of the request.
    pub fn new(found: &'a Registration, digest: &str) -> Self {
        let motions = found.motions.iter().map(|moved| MotionBody {
            motion: moved.motion.name().to_owned(),
            value: moved.value,
            start: moved.start,
            unit: if moved.motion.is_angle() { "urad" } else { "um" }.to_owned(),
            std_error: moved.std_error,
            bias_bound: moved.bias_bound,
            determined: moved.determined,
        });
        let indistinguishable = found.indistinguishable.iter().map(|group| IndistinguishableBody {
            names: group.motions.iter().map(|motion| motion.name().to_owned()).collect(),
            condition_index: group.condition_index,
            sentence: group.sentence.clone(),
        });
        RegistrationBody {
            motions: motions.collect(),
            pivot_z_mm: found.pose.pivot,
            rms_before_um: found.rms_before,
            rms_after_um: found.rms_after,
            iterations: found.iterations,
            converged: found.converged,
            indistinguishable: indistinguishable.collect(),
            result: FitResultBody::new(&found.fit, None, digest.to_owned()),
            every_motion: found.every_motion.as_ref().map(|fit| FitResultBody::new(fit, None, digest.to_owned())),
            warnings: found.warnings.iter().map(WarningBody::from).collect(),
        }
    }
}
