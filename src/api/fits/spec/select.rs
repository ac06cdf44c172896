//! Which of several models is fitted, as it is written.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{json::present::present, shapes::degree::DegreeBody};
use flankfit_engine::estimation::spec::{Candidates, Degree, ModelCriterion, Select, TermSearch};

/// Chooses a model: candidates are looked at by plain least squares, and the best one by
/// `criterion` is fitted in place of `model`. Either `degrees` or `terms`. Intervals of the model
/// that is fitted are conditional on the choice (warning `post_selection`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Select, example = json!({"degrees": [4, 4], "criterion": "bic"}))]
pub struct SelectBody {
    /// Every degree of the polynomial from 0 up to these is looked at: `[max_u, max_v]`, or one for
    /// both; one for a curve, and for products of a total degree.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub degrees: Option<DegreeBody>,
    /// Subsets of the model's own terms are looked at (of a linear model: of its columns).
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub terms: Option<TermSearchName>,
    /// With `elastic_net` only: share of the absolute values in its penalty, above 0 and at most 1
    /// (the lasso). Default 0.5.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0, maximum = 1)]
    pub alpha: Option<f64>,
    /// Criterion of the selection.
    pub criterion: ModelCriterionName,
    /// If true, a product of powers is included only with all its divisors. Default true; false is
    /// allowed only for the columns of a linear model.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub hierarchical: Option<bool>,
}

/// Search for subsets of terms. `backward`: starting from all terms, removes the term that raises
/// the residual sum of squares least. `elastic_net`: the terms of elastic-net estimates for 100
/// decreasing values of the penalty λ, by coordinate descent; polynomials as Chebyshev polynomials
/// on the box of the nodes, columns in unit variance, the constant unpenalised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = TermSearch)]
pub enum TermSearchName {
    Backward,
    ElasticNet,
}

/// Criterion that the chosen model minimises; the number of parameters k counts the coefficients
/// and σ². `aicc`: −2 ln L + 2k + 2k(k + 1)/(m − k − 1); `bic`: −2 ln L + k ln m; `press`: Σ w
/// r²/(1 − h)²; `blocked_cv`: Σ w r² of nodes that are left out in blocks (`folds`); `reml`: −2 ln
/// of the marginal likelihood with Zellner's prior of the coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ModelCriterion)]
pub enum ModelCriterionName {
    Aicc,
    Bic,
    Press,
    BlockedCv,
    Reml,
}

impl From<ModelCriterionName> for ModelCriterion {
    fn from(name: ModelCriterionName) -> Self {
        match name {
            ModelCriterionName::Aicc => ModelCriterion::Aicc,
            ModelCriterionName::Bic => ModelCriterion::Bic,
            ModelCriterionName::Press => ModelCriterion::Press,
            ModelCriterionName::BlockedCv => ModelCriterion::BlockedCv,
            ModelCriterionName::Reml => ModelCriterion::Reml,
        }
    }
}

impl From<ModelCriterion> for ModelCriterionName {
    fn from(criterion: ModelCriterion) -> Self {
        match criterion {
            ModelCriterion::Aicc => ModelCriterionName::Aicc,
            ModelCriterion::Bic => ModelCriterionName::Bic,
            ModelCriterion::Press => ModelCriterionName::Press,
            ModelCriterion::BlockedCv => ModelCriterionName::BlockedCv,
            ModelCriterion::Reml => ModelCriterionName::Reml,
        }
    }
}

impl From<&Select> for SelectBody {
    fn from(select: &Select) -> Self {
        let (degrees, terms, alpha) = match select.candidates {
            Candidates::Degrees(Degree::Both(p)) => (Some(DegreeBody::Both(p)), None, None),
            Candidates::Degrees(Degree::Each(p, q)) => (Some(DegreeBody::Each([p, q])), None, None),
            Candidates::Terms(TermSearch::Backward) => (None, Some(TermSearchName::Backward), None),
            Candidates::Terms(TermSearch::ElasticNet { alpha }) => {
                (None, Some(TermSearchName::ElasticNet), Some(alpha))
            }
        };
        let (criterion, hierarchical) = (select.criterion.into(), Some(select.hierarchical));
        SelectBody { degrees, terms, alpha, criterion, hierarchical }
    }
}
