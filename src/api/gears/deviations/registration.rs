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

/// Motions of the part, with the fit and its warnings.
#[skip_serializing_none]
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = GearRegistration)]
pub struct RegistrationBody<'a> {
    #[serde(flatten)]
    #[schema(inline)]
    pub registration: &'a Registration,
    /// Motions that these points do not distinguish.
    pub indistinguishable: Vec<IndistinguishableBody>,
    /// The last fit, as returned by `POST /v1/fits`: heights are normal deviations in µm.
    pub result: FitResultBody<'a>,
    /// Plain least squares with a column for each motion (spectrum, collinearity), if motions were
    /// taken together in the fit.
    pub every_motion: Option<FitResultBody<'a>>,
    /// `rotation_modulo_pitch`: no point names its tooth. `flanks_reassigned`: points lie on other
    /// flanks than were nearest before. Doubts: `flanks_ambiguous`, `teeth_contradict` (points
    /// count on the teeth that they lie on, not on those given), `axial_shift_for_rotation`,
    /// `poor_fit`, `points_misfit`, `points_outside_flank`, `registration_not_converged`.
    /// `motions_indistinguishable`: rotation and axial shift of a helical part are one motion, and
    /// all of it is taken as rotation; `axial_shift_by_modification`: only modifications that
    /// change along z distinguish the two.
    pub warnings: Vec<WarningBody>,
}

/// Motions or settings that cannot be distinguished.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Indistinguishable)]
pub struct IndistinguishableBody {
    /// Motions of a registration, settings of a correction.
    pub names: Vec<String>,
    /// Absent where it is infinite.
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
        let indistinguishable = found.indistinguishable.iter().map(|group| IndistinguishableBody {
            names: group.motions.iter().map(|motion| motion.name().to_owned()).collect(),
            condition_index: group.condition_index,
            sentence: group.sentence.clone(),
        });
        RegistrationBody {
            registration: found,
            indistinguishable: indistinguishable.collect(),
            result: FitResultBody::new(&found.fit, None, digest.to_owned()),
            every_motion: found.every_motion.as_ref().map(|fit| FitResultBody::new(fit, None, digest.to_owned())),
            warnings: found.warnings.iter().map(WarningBody::from).collect(),
        }
    }
}
