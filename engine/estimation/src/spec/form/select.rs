use flankfit_numerics::check::Fault;
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::fault;
use crate::spec::{Candidates, Degree, ModelCriterion, TermSearch};

/// Share of the absolute values in the penalty of the elastic net where none is given.
const DEFAULT_ALPHA: f64 = 0.5;

/// Chooses a model: candidates are fitted by plain least squares, and the best one by `criterion`
/// is fitted in place of `model`. Either `degrees` or `terms`. Intervals of the model that is
/// fitted are conditional on the choice (warning `post_selection`).
#[skip_serializing_none]
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"degrees": [4, 4], "criterion": "bic"}))]
pub(in crate::spec) struct Select {
    /// Every degree of the polynomial from 0 up to these is a candidate: `[max_u, max_v]`, or one
    /// for both; one for a curve, and for products of a total degree.
    degrees: Option<Degree>,
    /// Subsets of the model's own terms are candidates (of a linear model: of its columns).
    terms: Option<Terms>,
    /// With `elastic_net` only: share of the absolute values in its penalty, above 0 and at most 1
    /// (the lasso). By default 0.5.
    #[schema(exclusive_minimum = 0, maximum = 1)]
    alpha: Option<f64>,
    /// Criterion of the selection.
    criterion: ModelCriterion,
    /// If true, a product of powers is included only with all its divisors; false is allowed only
    /// for the columns of a linear model.
    #[serde(default = "hierarchical")]
    #[schema(default = true)]
    hierarchical: bool,
}

fn hierarchical() -> bool {
    true
}

/// Search for subsets of terms. `backward`: starting from all terms, removes the term that raises
/// the residual sum of squares least. `elastic_net`: the terms of elastic-net estimates for 100
/// decreasing values of the penalty λ, by coordinate descent; polynomials as Chebyshev polynomials
/// on the box of the nodes, columns in unit variance, the constant unpenalised.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = TermSearch)]
pub(in crate::spec) enum Terms {
    Backward,
    ElasticNet,
}

impl TryFrom<Select> for super::super::Select {
    type Error = Fault;

    fn try_from(Select { degrees, terms, alpha, criterion, hierarchical }: Select) -> Result<Self, Fault> {
        if alpha.is_some() && terms != Some(Terms::ElasticNet) {
            return Err(fault("alpha", "only `elastic_net` takes it"));
        }
        let candidates = match (degrees, terms) {
            (Some(degrees), None) => Candidates::Degrees(degrees),
            (None, Some(Terms::Backward)) => Candidates::Terms(TermSearch::Backward),
            (None, Some(Terms::ElasticNet)) => {
                Candidates::Terms(TermSearch::ElasticNet { alpha: alpha.unwrap_or(DEFAULT_ALPHA) })
            }
            (Some(_), Some(_)) => return Err(fault("terms", "give either `degrees` or `terms`, not both")),
            (None, None) => return Err(fault("", "give `degrees` or `terms`")),
        };
        Ok(Self { candidates, criterion, hierarchical })
    }
}

impl From<super::super::Select> for Select {
    fn from(select: super::super::Select) -> Self {
        let (degrees, terms, alpha) = match select.candidates {
            Candidates::Degrees(degrees) => (Some(degrees), None, None),
            Candidates::Terms(TermSearch::Backward) => (None, Some(Terms::Backward), None),
            Candidates::Terms(TermSearch::ElasticNet { alpha }) => (None, Some(Terms::ElasticNet), Some(alpha)),
        };
        Select { degrees, terms, alpha, criterion: select.criterion, hierarchical: select.hierarchical }
    }
}
