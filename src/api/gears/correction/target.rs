//! Target of a correction.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    faults::Faults,
    gears::{flank_design::DesignBody, requirements::RequirementsBody},
};
use flankfit_engine::gear::{correction::Flank, evaluation::flank_surface::FlankFigures};

/// Target of a correction: a name, or the deviation that is wanted at each node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum TargetBody {
    Named(TargetName),
    Given(TargetDeviationBody),
}

/// Name of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = CorrectionTargetName)]
pub enum TargetName {
    /// The `design` in the job's requirements. The default where the job has one.
    Design,
    /// The middle of the limits that the job's requirements have of each figure, or its class of
    /// slopes; the level of the flank and figures without limits stay as measured. The default
    /// where there is no design, but limits of a crowning or of the twist.
    Limits,
    /// The unmodified flank. The default elsewhere.
    Nominal,
}

/// The wanted deviation at each node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = TargetDeviation)]
pub struct TargetDeviationBody {
    /// µm for each node in the order posted, missing ones too.
    pub deviation_um: Vec<f64>,
}

flankfit_engine::numerics::alternatives!(
    TargetBody as "CorrectionTarget",
    "Target of a correction: a name, or the wanted deviation at each node.",
    TargetName::schema(),
    TargetDeviationBody::schema(),
);

/// Target of a stored correction.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CorrectionAim)]
pub struct AimBody {
    pub kind: AimName,
    /// The wanted deviation at each node in the order posted; absent with `nominal` (0 everywhere).
    /// Present when `nodes` was included.
    pub deviation_um: Option<Vec<f64>>,
}

/// Kind of the target of a correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = CorrectionAimKind)]
pub enum AimName {
    /// The design of the job.
    Design,
    /// The middle of the limits of figures.
    Limits,
    /// The unmodified flank.
    Nominal,
    /// Given with the request.
    Given,
}

impl AimBody {
    /// The unmodified flank.
    pub const NOMINAL: AimBody = AimBody { kind: AimName::Nominal, deviation_um: None };
}

/// A flank, its deviations, and the requirements of its job.
pub struct Wanted<'a> {
    /// The flank that the nodes lie on, with a machine.
    pub flank: Option<&'a Flank>,
    pub deviation: &'a [f64],
    pub weight: Option<&'a [f64]>,
    /// Limits of the figures of the flank.
    pub limits: FlankFigures<[f64; 2]>,
    pub requirements: Option<&'a RequirementsBody>,
}

impl Wanted<'_> {
    /// The target that is asked for, or that of the job.
    pub fn target(&self, asked: Option<TargetBody>, faults: &mut Faults) -> Option<AimBody> {
        const AT: &str = "/target";
        let aim = |kind, deviation| Some(AimBody { kind, deviation_um: Some(deviation) });
        let design = self.requirements.and_then(|requirements| requirements.design.as_ref());
        let name = match asked {
            Some(TargetBody::Given(given)) => return aim(AimName::Given, given.deviation_um),
            Some(TargetBody::Named(TargetName::Nominal)) => return Some(AimBody::NOMINAL),
            Some(TargetBody::Named(name)) => name,
            None => {
                let FlankFigures { profile_crowning, helix_crowning, twist, .. } = self.limits;
                return match self.flank {
                    Some(flank) if let Some(design) = design => {
                        self.designed(flank, design, faults).and_then(|found| aim(AimName::Design, found))
                    }
                    Some(flank) if profile_crowning.or(helix_crowning).or(twist).is_some() => {
                        self.within_limits(flank, faults)
                    }
                    _ => Some(AimBody::NOMINAL),
                };
            }
        };
        let Some(flank) = self.flank else {
            let detail = "the places of the nodes on the flank are known only with a `machine`: send \
                {\"deviation_um\": […]} with a `matrix`";
            faults.push(AT, detail);
            return None;
        };
        match (name, design) {
            (TargetName::Design, Some(design)) => {
                self.designed(flank, design, faults).and_then(|found| aim(AimName::Design, found))
            }
            (TargetName::Design, None) => {
                faults.push(AT, "the requirements of the job have no `design`: PATCH the job, or name another target");
                None
            }
            (TargetName::Limits, _) if self.limits.named().iter().all(|(_, limits)| limits.is_none()) => {
                let detail = "the requirements of the job have no limits of slopes, crownings or twist, and no class: \
                    PATCH the job, or name another target";
                faults.push(AT, detail);
                None
            }
            (TargetName::Limits | TargetName::Nominal, _) => self.within_limits(flank, faults),
        }
    }

    /// Returns the middle of the limits as the target. Nodes that do not determine the figures have
    /// none: the unmodified flank in its place would remove what the limits ask for.
    fn within_limits(&self, flank: &Flank, faults: &mut Faults) -> Option<AimBody> {
        let Some(found) = flank.target_within(self.deviation, self.weight, self.limits) else {
            let detail = "the limits of the job cannot be the target, because the nodes do not determine slopes and \
                crownings over the ranges of the machine: correct the ranges, or send another `target`";
            faults.push("/target", detail);
            return None;
        };
        Some(AimBody { kind: AimName::Limits, deviation_um: Some(found) })
    }

    fn designed(&self, flank: &Flank, design: &DesignBody, faults: &mut Faults) -> Option<Vec<f64>> {
        let refused = |why: String| Faults::one("/target", format!("the design that the job requires: {why}"));
        let first = |faults: &Faults| faults.list().first().map_or_else(String::new, |fault| fault.detail.clone());
        let found = design.on(&flank.gear, flank.side, "").map_err(|found| refused(first(&found)));
        let found = found.and_then(|design| flank.designed(&design).map_err(|found| refused(first(&found.into()))));
        found.map_err(|more| faults.append(more)).ok()
    }
}
