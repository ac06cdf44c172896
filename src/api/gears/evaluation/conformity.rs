//! Limits of figures, and whether figures conform to them, on the wire.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use flankfit_engine::{
    estimation::inference::{Conformity, Decision},
    gear::evaluation::ToleranceLimits,
};

/// What figures must lie within, `[low, high]` in µm and in the sign in which they are answered.
/// Each figure that has limits is answered with its conformity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ToleranceLimits)]
pub struct ToleranceLimitsBody {
    /// Class 1 to 11 of ISO 1328-1:2013: its tolerances bound the slopes that no limits are given
    /// for here (the standard has none of crownings and twist). Over a part of the evaluation range
    /// or of the face width a slope has that share of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 11)]
    pub class: Option<u8>,
    /// Of f_Hα. In evaluations it is that of traces, over the reference length; surfaces have their
    /// share of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub profile_slope_um: Option<[f64; 2]>,
    /// Of f_Hβ, likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub helix_slope_um: Option<[f64; 2]>,
    /// Of C_α.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub profile_crowning_um: Option<[f64; 2]>,
    /// Of C_β.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub helix_crowning_um: Option<[f64; 2]>,
    /// Of the twist of surfaces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub twist_um: Option<[f64; 2]>,
}

impl From<ToleranceLimitsBody> for ToleranceLimits {
    fn from(limits: ToleranceLimitsBody) -> Self {
        ToleranceLimits {
            class: limits.class,
            profile_slope: limits.profile_slope_um,
            helix_slope: limits.helix_slope_um,
            profile_crowning: limits.profile_crowning_um,
            helix_crowning: limits.helix_crowning_um,
            twist: limits.twist_um,
        }
    }
}

/// A figure against its limits, by its standard error (ISO 14253-1): the limits are drawn in by a
/// guard band, so that a part at a limit is found to conform in one measurement of twenty at most.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Conformity)]
pub struct ConformityBody {
    /// The limits that were compared with, µm.
    #[schema(min_items = 2, max_items = 2)]
    pub limits_um: [f64; 2],
    /// Least and greatest probability that the true figure lies within the limits, by Student's
    /// distribution; they differ where the estimate may be biased.
    #[schema(min_items = 2, max_items = 2)]
    pub probability: [f64; 2],
    pub decision: DecisionName,
}

/// What the uncertainty allows to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ConformityDecision)]
pub enum DecisionName {
    /// The probability is 0.95 at least.
    Conforms,
    /// The probability is 0.05 at most.
    DoesNotConform,
    /// Neither.
    CannotBeTold,
}

impl From<Conformity> for ConformityBody {
    fn from(found: Conformity) -> Self {
        ConformityBody {
            limits_um: found.limits,
            probability: found.probability,
            decision: match found.decision {
                Decision::Conforms => DecisionName::Conforms,
                Decision::DoesNotConform => DecisionName::DoesNotConform,
                Decision::CannotBeTold => DecisionName::CannotBeTold,
            },
        }
    }
}
