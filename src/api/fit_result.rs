//! The answer to a fit, as it is written.
//!
//! Vectors are moved out of the domain result, never copied. A value that does not exist is left out, a number
//! that is not finite is left out with a warning, and a result that has one where the contract promises a number
//! is refused: there is no `null` and no invented number.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    filters::{self, FilterCollinearity, FilterResult},
    fit_result_parts::*,
    fit_spec::SchemeName,
    problem::{Problem, ProblemCode, ProblemError},
};
use crate::estimation::{FitResult, result, spec};

/// The answer to a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitResult)]
pub struct FitResultBody {
    /// In the order of `powers`, `index` or `column`.
    pub coefficients: Vec<CoefficientBody>,
    /// The box on which mapped bases live; absent for a measurement matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainBody>,
    pub spectrum: SpectrumBody,
    pub regularization: RegularizationResult,
    pub bias: BiasBody,
    pub collinearity: CollinearityBody,
    /// Present when `node_uncertainty` was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub perturbation: Option<PerturbationBody>,
    pub residuals: ResidualsBody,
    /// Condition, bias and error along λ*; present when `lambda_curve` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lambda_curve: Option<Vec<LambdaCurvePointBody>>,
    /// The coefficients along k, ascending from 0; present when `ridge_trace` was included and ridge asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ridge_trace: Option<Vec<RidgeTracePointBody>>,
    /// The rows of B in the caller's columns; present when `matrix_b` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix_b: Option<Vec<Vec<f64>>>,
    /// What each filter changed, in the order applied; present when there were filters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filters: Option<Vec<FilterResult>>,
    /// Present when there were filters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filter_collinearity: Option<FilterCollinearity>,
    pub numerics: NumericsBody,
    pub warnings: Vec<WarningBody>,
    pub provenance: ProvenanceBody,
}

impl FitResultBody {
    /// Takes over a result. `input_sha256` is the digest of [`super::canonical`].
    pub fn new(result: FitResult, input_sha256: String) -> Result<Self, Problem> {
        let mut check = Check::default();
        let (filters, filter_collinearity) = result.filtering.map(|report| filters::answer(&mut check, report)).unzip();
        let body = FitResultBody {
            coefficients: result.coefficients.into_iter().map(|c| coefficient(&mut check, c)).collect(),
            domain: result.domain.map(DomainBody::from),
            spectrum: spectrum(&mut check, result.spectrum),
            regularization: regularization(&mut check, result.regularization),
            bias: bias(&mut check, result.bias),
            collinearity: collinearity(&mut check, Arc::unwrap_or_clone(result.collinearity)),
            perturbation: result.perturbation.map(|p| perturbation(&mut check, p)),
            residuals: residuals(&mut check, result.residuals),
            lambda_curve: result
                .lambda_curve
                .map(|points| points.into_iter().map(|p| lambda_curve_point(&mut check, p)).collect()),
            ridge_trace: result.ridge_trace.map(|points| {
                points
                    .into_iter()
                    .map(|p| RidgeTracePointBody {
                        k: p.k,
                        coefficients: check.numbers("ridge_trace.coefficients", p.coefficients),
                    })
                    .collect()
            }),
            matrix_b: check.rows("matrix_b", result.matrix_b),
            filters,
            filter_collinearity,
            numerics: NumericsBody {
                arithmetic: match result.numerics.arithmetic {
                    result::Arithmetic::Double => ArithmeticName::Double,
                    result::Arithmetic::DoubleDouble => ArithmeticName::DoubleDouble,
                },
                correct_digits: check.number("numerics.correct_digits", result.numerics.correct_digits),
            },
            warnings: result
                .warnings
                .into_iter()
                .map(|w| WarningBody { code: w.code.into(), message: w.message })
                .collect(),
            provenance: ProvenanceBody { engine: super::ENGINE.into(), input_sha256 },
        };
        check.finish(body)
    }

    /// The JSON text.
    pub fn to_json(&self) -> Result<Vec<u8>, serde_json::Error> {
        let n = self.coefficients.len();
        let values =
            self.residuals.values.as_ref().map_or(0, Vec::len) + self.matrix_b.as_ref().map_or(0, |b| b.len() * n);
        // About what the text takes, so that it is laid once: some 20 bytes a number.
        let mut text = Vec::with_capacity(4096 + 22 * (2 * n * n + 24 * n + values));
        serde_json::to_writer(&mut text, self)?;
        Ok(text)
    }
}

/// Watches the numbers that pass.
#[derive(Default)]
pub(super) struct Check {
    left_out: Vec<&'static str>,
    impossible: Option<&'static str>,
}

impl Check {
    /// A number that the contract promises.
    pub fn number(&mut self, name: &'static str, value: f64) -> f64 {
        if !value.is_finite() {
            self.impossible.get_or_insert(name);
        }
        value
    }

    /// Numbers that the contract promises.
    pub fn numbers(&mut self, name: &'static str, values: Vec<f64>) -> Vec<f64> {
        if values.iter().any(|value| !value.is_finite()) {
            self.impossible.get_or_insert(name);
        }
        values
    }

    /// A number that may be left out.
    pub fn maybe(&mut self, name: &'static str, value: Option<f64>) -> Option<f64> {
        value.filter(|value| {
            if !value.is_finite() && !self.left_out.contains(&name) {
                self.left_out.push(name);
            }
            value.is_finite()
        })
    }

    /// Rows that may be left out.
    pub fn rows(&mut self, name: &'static str, rows: Option<Vec<Vec<f64>>>) -> Option<Vec<Vec<f64>>> {
        rows.filter(|rows| {
            let finite = rows.iter().flatten().all(|value| value.is_finite());
            if !finite {
                self.left_out.push(name);
            }
            finite
        })
    }

    fn finish(self, mut body: FitResultBody) -> Result<FitResultBody, Problem> {
        if let Some(name) = self.impossible {
            return Err(Problem {
                errors: vec![ProblemError { pointer: "/nodes".into(), detail: format!("`{name}` overflows") }],
                ..Problem::new(
                    ProblemCode::InvalidRequest,
                    format!(
                        "The numbers of this fit leave the range of double precision (`{name}`); choose another unit."
                    ),
                )
            });
        }
        for name in self.left_out {
            body.warnings.push(WarningBody {
                code: "not_finite".into(),
                message: format!("`{name}` is not finite in double precision and was left out."),
            });
        }
        Ok(body)
    }
}

fn coefficient(check: &mut Check, c: result::Coefficient) -> CoefficientBody {
    let (powers, index, column) = match c.key {
        result::TermKey::Powers(powers) => (Some(powers), None, None),
        result::TermKey::Index(index) => (None, Some(index), None),
        result::TermKey::Column(column) => (None, None, Some(column)),
    };
    CoefficientBody {
        term: c.term,
        powers,
        index,
        column,
        value: check.number("coefficients.value", c.value),
        std_error: check.maybe("coefficients.std_error", c.std_error),
        least_squares: check.number("coefficients.least_squares", c.least_squares),
        least_squares_std_error: check.maybe("coefficients.least_squares_std_error", c.least_squares_std_error),
        bias_bound: check.number("coefficients.bias_bound", c.bias_bound),
    }
}

fn spectrum(check: &mut Check, s: result::SpectrumReport) -> SpectrumBody {
    SpectrumBody {
        eigenvalues: check.numbers("spectrum.eigenvalues", s.eigenvalues),
        condition: check.maybe("spectrum.condition", s.condition),
        log10_condition: check.maybe("spectrum.log10_condition", s.log10_condition),
        log10_determinant: check.maybe("spectrum.log10_determinant", s.log10_determinant),
        rank: s.rank,
        regularized: RegularizedSpectrumBody {
            eigenvalues: check.numbers("spectrum.regularized.eigenvalues", s.regularized.eigenvalues),
            condition: check.maybe("spectrum.regularized.condition", s.regularized.condition),
            log10_determinant: check.maybe("spectrum.regularized.log10_determinant", s.regularized.log10_determinant),
        },
    }
}

fn regularization(check: &mut Check, r: result::RegularizationReport) -> RegularizationResult {
    RegularizationResult {
        kind: match r.kind {
            result::RegularizationKind::None => RegularizationName::None,
            result::RegularizationKind::Spectral => RegularizationName::Spectral,
            result::RegularizationKind::Ridge => RegularizationName::Ridge,
            result::RegularizationKind::Tikhonov => RegularizationName::Tikhonov,
            result::RegularizationKind::TruncatedSvd => RegularizationName::TruncatedSvd,
            result::RegularizationKind::JamesStein => RegularizationName::JamesStein,
            result::RegularizationKind::Attraction => RegularizationName::Attraction,
        },
        scheme: r.scheme.map(SchemeName::from),
        count: r.count,
        lambda_star: check.maybe("regularization.lambda_star", r.lambda_star),
        rank: r.rank,
        shrinkage_factor: check.maybe("regularization.shrinkage_factor", r.shrinkage_factor),
        lambda_star_interval: r.lambda_star_interval.filter(|ends| ends.iter().all(|end| end.is_finite())),
        gamma: check.maybe("regularization.gamma", r.gamma),
        criterion: if r.fixed { Some(ChosenBy::Fixed) } else { r.criterion.map(ChosenBy::from) },
        filter_factors: check.numbers("regularization.filter_factors", r.filter_factors),
        matrix_norm_squared: check.maybe("regularization.matrix_norm_squared", r.matrix_norm_squared),
        largest_eigenvalue_bound: check.maybe("regularization.largest_eigenvalue_bound", r.largest_eigenvalue_bound),
        choices: r.choices.into_iter().map(|c| choice(check, c)).collect(),
    }
}

fn choice(check: &mut Check, c: result::Choice) -> ChoiceBody {
    ChoiceBody {
        criterion: c.criterion.map_or(ChosenBy::LeastSquares, ChosenBy::from),
        lambda_star: check.maybe("regularization.choices.lambda_star", c.lambda_star),
        condition: check.maybe("regularization.choices.condition", c.condition),
        bias_norm: check.number("regularization.choices.bias_norm", c.bias_norm),
        predicted_mse: check.maybe("regularization.choices.predicted_mse", c.predicted_mse),
        rms: check.number("regularization.choices.rms", c.rms),
    }
}

fn bias(check: &mut Check, b: result::BiasReport) -> BiasBody {
    BiasBody {
        norm: check.number("bias.norm", b.norm),
        sharp_bound: check.number("bias.sharp_bound", b.sharp_bound),
        paper_bound: check.maybe("bias.paper_bound", b.paper_bound),
        coefficient_norm_limit: check.number("bias.coefficient_norm_limit", b.coefficient_norm_limit),
        coefficient_norm_limit_source: match b.coefficient_norm_limit_from_request {
            true => LimitSource::Request,
            false => LimitSource::Estimate,
        },
        e: check.maybe("bias.e", b.e),
    }
}

fn collinearity(check: &mut Check, c: result::CollinearityReport) -> CollinearityBody {
    CollinearityBody {
        columns: c
            .columns
            .into_iter()
            .map(|column| ColumnBody { term: column.term, vif: check.maybe("collinearity.columns.vif", column.vif) })
            .collect(),
        correlation: check.rows("collinearity.correlation", c.correlation),
        variance_proportions: check.rows("collinearity.variance_proportions", c.variance_proportions),
        near_dependencies: c
            .near_dependencies
            .into_iter()
            .map(|d| NearDependencyBody {
                eigenvalue: check.number("collinearity.near_dependencies.eigenvalue", d.eigenvalue),
                condition_index: check.maybe("collinearity.near_dependencies.condition_index", d.condition_index),
                weights: check.numbers("collinearity.near_dependencies.weights", d.weights),
                terms: d.terms,
                cosine: check.maybe("collinearity.near_dependencies.cosine", d.cosine),
                weight_ratio: check.maybe("collinearity.near_dependencies.weight_ratio", d.weight_ratio),
                r_squared: check.maybe("collinearity.near_dependencies.r_squared", d.r_squared),
                sentence: d.sentence,
            })
            .collect(),
    }
}

fn perturbation(check: &mut Check, p: result::PerturbationReport) -> PerturbationBody {
    let mut bounds = |b: result::PerturbationBounds| PerturbationBoundsBody {
        square_bound: check.maybe("perturbation.square_bound", b.square_bound),
        first_order_bound: check.maybe("perturbation.first_order_bound", b.first_order_bound),
    };
    PerturbationBody { least_squares: bounds(p.least_squares), regularized: bounds(p.regularized) }
}

fn residuals(check: &mut Check, r: result::ResidualReport) -> ResidualsBody {
    ResidualsBody {
        count: r.count,
        degrees_of_freedom: r.degrees_of_freedom,
        rss: check.number("residuals.rss", r.rss),
        sigma: check.maybe("residuals.sigma", r.sigma),
        rms: check.number("residuals.rms", r.rms),
        max_abs: check.maybe("residuals.max_abs", r.max_abs),
        r_squared: check.maybe("residuals.r_squared", r.r_squared),
        least_squares_rss: check.number("residuals.least_squares_rss", r.least_squares_rss),
        values: r.values.map(|values| check.numbers("residuals.values", values)),
        node_indices: r.node_indices,
    }
}

fn lambda_curve_point(check: &mut Check, p: result::LambdaCurvePoint) -> LambdaCurvePointBody {
    LambdaCurvePointBody {
        lambda_star: check.number("lambda_curve.lambda_star", p.lambda_star),
        condition: check.maybe("lambda_curve.condition", p.condition),
        bias_norm: check.number("lambda_curve.bias_norm", p.bias_norm),
        predicted_mse: check.maybe("lambda_curve.predicted_mse", p.predicted_mse),
        rms: check.number("lambda_curve.rms", p.rms),
        gcv: check.maybe("lambda_curve.gcv", p.gcv),
        coefficient_norm: check.number("lambda_curve.coefficient_norm", p.coefficient_norm),
    }
}

impl From<spec::Domain> for DomainBody {
    fn from(domain: spec::Domain) -> Self {
        DomainBody { u: domain.u, v: domain.v }
    }
}
