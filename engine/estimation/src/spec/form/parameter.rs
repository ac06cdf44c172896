use std::borrow::Cow;

use flankfit_numerics::{check::Fault, contract::names};
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::{ToSchema, openapi::schema::ObjectBuilder};

use super::fault;
use crate::spec::Criterion;

const FIXED: &str = "fixed";

/// Choice of λ* (spectral), k (ridge, attraction) or λ (Tikhonov).
#[skip_serializing_none]
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::spec) struct Parameter {
    /// Criterion that chooses the value; `fixed` takes `value`.
    #[schema(schema_with = criteria)]
    criterion: Cow<'static, str>,
    /// The value itself, in the scaled columns; with criterion `fixed` and only then.
    #[schema(exclusive_minimum = 0)]
    value: Option<f64>,
}

fn criteria() -> ObjectBuilder {
    names(Criterion::every().map(Criterion::name).chain([FIXED])).description(Some(
        "Criterion that chooses the value; `fixed` takes `value`. `hkb`: (p−2) σ²/‖Â‖² (Hoerl, Kennard and \
             Baldwin, the modified form), `hkb_1975`: p σ²/‖Â‖², `lawless_wang`: (p−2) σ² λ̄/Σλᵢaᵢ², of ridge only. \
             `optimal`: the explicit minimiser of the predicted mean squared error, of attraction only. `reml`: \
             greatest restricted likelihood, the penalty read as a prior of the coefficients. `press`: least sum of \
             squared leave-one-out residuals; `blocked_cv`: of nodes left out in blocks (`folds`). `sure`: Stein's \
             unbiased estimate of the risk of the fitted heights, RSS + 2σ² Σf.",
    ))
}

impl TryFrom<Parameter> for super::super::Parameter {
    type Error = Fault;

    fn try_from(Parameter { criterion, value }: Parameter) -> Result<Self, Fault> {
        match (Criterion::every().find(|known| known.name() == criterion), value) {
            (Some(criterion), None) => Ok(Self::Criterion(criterion)),
            (Some(_), Some(_)) => Err(fault("value", "only the criterion `fixed` takes a value")),
            (None, _) if criterion != FIXED => Err(fault("criterion", "the criterion is not known")),
            (None, Some(value)) => Ok(Self::Fixed(value)),
            (None, None) => Err(fault("value", "missing; the criterion `fixed` needs it")),
        }
    }
}

impl From<super::super::Parameter> for Parameter {
    fn from(parameter: super::super::Parameter) -> Self {
        match parameter {
            super::super::Parameter::Criterion(criterion) => {
                Parameter { criterion: criterion.name().into(), value: None }
            }
            super::super::Parameter::Fixed(value) => Parameter { criterion: FIXED.into(), value: Some(value) },
        }
    }
}
