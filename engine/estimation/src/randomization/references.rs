//! The estimates with which randomisation is compared: least squares, both spectral schemes, ridge,
//! on X as it is.
//!
//! With `X = U Σ Vᵀ`, `α = VᵀA` and `p = Uᵀe`, least squares has `aᵢ = αᵢ + pᵢ/σᵢ`, a filter f
//! makes `Â = Σ fᵢ aᵢ Vᵢ`, and `‖A − Â‖² = Σ ((1−fᵢ) αᵢ − fᵢ pᵢ/σᵢ)²`: sums over the spectrum, with
//! nothing that cancels.

use nalgebra::DMatrix;

use super::{
    outcome::Outcome,
    result::{LevelOfB, MethodResults, Reference, ReferenceChoice, References, Regularized, Summary},
    setup::Study,
};
use crate::{
    data::{Nodes, Sample},
    design::Design,
    diagnostics::collinearity,
    error::FitError,
    factor::Factor,
    result::Warning,
    selection::{Rule, Search, Spectral, filters},
    spec::{Count, Criterion, DEFAULT_CONDITION_LIMIT, FitSpec, Model, Parameter, Regularization, Scaling, Scheme},
    spectrum::{Directions, ScaledColumns, caller_columns},
};
use flankfit_numerics::{Dd, cancel::Asking, triangular};

/// The spectrum of X and where A lies in it.
pub(super) struct Base {
    pub(super) spectrum: Directions,
    /// U, row by row.
    u: DMatrix<f64>,
    alpha: Vec<f64>,
    pub(super) rows: usize,
    /// σ_signal of each column.
    pub(super) deviation: Vec<f64>,
    variance: f64,
    /// Least and largest |correlation| of two columns that vary.
    pub correlation: Option<[f64; 2]>,
}

impl Base {
    pub(super) fn new(study: &Study) -> Result<Self, FitError> {
        let (m, n) = (study.rows, study.columns);
        let nodes = Nodes::matrix(study.x.clone(), n, vec![0.0; m], None, None);
        let nodes = nodes.map_err(|faults| faults.within("nodes"))?;
        let sample = Sample::new(&nodes);
        let design = Design::new(&nodes, &sample, &FitSpec::new(Model::Linear))?;
        let factor = Factor::new(&design, &sample)?;
        let caller = caller_columns(&factor);
        let weight = m as f64;
        let unit_columns = ScaledColumns::new(&design, &caller, Scaling::UnitLength, weight)?;
        let unit = Directions::new(&factor, &unit_columns, Scaling::UnitLength, None)?;
        let columns = ScaledColumns::new(&design, &caller, Scaling::None, weight)?;
        let spectrum = Directions::new(&factor, &columns, Scaling::None, Some(unit.rank))?;
        let report = collinearity::report(&design, &factor, &caller, &unit, weight, true, &mut Vec::new());
        // a column that does not vary has no correlation with another
        let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
        let correlation = pairs
            .filter(|&(i, j)| study.deviation[i] > 0.0 && study.deviation[j] > 0.0)
            .filter_map(|(i, j)| report.correlation.as_ref().map(|rows| rows[i][j].abs()))
            .fold(None, |seen: Option<[f64; 2]>, r| Some(seen.map_or([r, r], |[a, b]| [a.min(r), b.max(r)])));
        let alpha = (0..n)
            .map(|i| {
                let direction = spectrum.v.column(i);
                let terms = direction.iter().zip(&study.coefficients).map(|(v, a)| Dd::product(*v, *a));
                terms.fold(Dd::ZERO, |sum, term| sum + term).to_f64()
            })
            .collect();
        let u = left_vectors(study, &design, &sample, &factor, &spectrum);
        let variance = study.noise_sigma * study.noise_sigma;
        Ok(Base { spectrum, u, alpha, rows: m, deviation: study.deviation.clone(), variance, correlation })
    }

    pub(super) fn lambda(&self) -> &[f64] {
        &self.spectrum.lambda
    }

    /// ‖A‖².
    pub(super) fn coefficient_norm_squared(&self) -> f64 {
        self.alpha.iter().map(|a| a * a).sum()
    }

    /// |V₁ᵀA|/‖A‖.
    pub(super) fn along_smallest(&self) -> Option<f64> {
        let norm = self.coefficient_norm_squared().sqrt();
        Some(self.alpha[0].abs() / norm).filter(|share| share.is_finite())
    }

    /// Uᵀe; 0 along directions that are numerically zero.
    pub(super) fn project(&self, noise: &[f64]) -> Vec<f64> {
        self.u.column_iter().map(|u| u.iter().zip(noise).map(|(u, e)| u * e).sum()).collect()
    }

    pub(super) fn references(&self, outcomes: &[Outcome], warnings: &mut Vec<Warning>) -> References {
        let least_squares = self.summaries(outcomes, |_| (Rule::None, 0.0));
        let spectral =
            |scheme| self.spectrum.full_rank().then(|| self.reference(outcomes, &usual_regularization(scheme)));
        if !self.spectrum.full_rank() {
            warnings.push(Warning::NoSpectralSchemes { rank: self.spectrum.rank, columns: self.lambda().len() });
        }
        References {
            least_squares,
            spectral_first_order: spectral(Scheme::FirstOrder),
            spectral_exact: spectral(Scheme::Exact),
            ridge: self
                .reference(outcomes, &Regularization::Ridge { parameter: Parameter::Criterion(Criterion::MinMse) }),
        }
    }

    /// The regularising matrix of level k on the same heights.
    pub(super) fn of_level(&self, outcomes: &[Outcome], level: f64) -> Option<LevelOfB> {
        let (_, rule) = Rule::requested(&usual_regularization(Scheme::FirstOrder), self.lambda()).ok()?;
        let lambda_star = self.spectrum.full_rank().then(|| self.lambda_star_of_level(rule, level)).flatten()?;
        Some(LevelOfB { lambda_star, results: self.summaries(outcomes, |_| (rule, lambda_star)) })
    }

    fn reference(&self, outcomes: &[Outcome], regularization: &Regularization) -> Reference {
        let rule = Rule::requested(regularization, self.lambda()).map_or(Rule::None, |(_, rule)| rule);
        let (_, count) = filters::scheme_and_count(rule);
        // what every criterion chooses in every repetition
        let chosen: Vec<Vec<Option<f64>>> = outcomes
            .iter()
            .map(|outcome| {
                if count == Some(0) {
                    return vec![None; Criterion::ALL.len()];
                }
                let a = self.least_squares(outcome);
                let problem = Spectral::new(self.lambda(), &a, Some(self.variance), outcome.rss, self.rows, 0);
                let search = Search::new(&problem, rule);
                Criterion::ALL.iter().map(|c| search.choose(*c).ok().map(|chosen| chosen.lambda_star)).collect()
            })
            .collect();
        let choices = Criterion::ALL
            .iter()
            .enumerate()
            .filter(|(at, _)| count == Some(0) || chosen.iter().all(|choices| choices[*at].is_some()))
            .map(|(at, &criterion)| {
                let parameter = |r: usize| chosen[r][at];
                let chosen = Regularized {
                    lambda_star: Summary::of((0..outcomes.len()).map(|r| parameter(r).unwrap_or(f64::NAN))),
                    noise_to_signal: Summary::of((0..outcomes.len()).map(|r| {
                        parameter(r).and_then(|lambda_star| self.noise_to_signal(rule, lambda_star)).unwrap_or(f64::NAN)
                    })),
                    results: self.summaries(outcomes, |r| match parameter(r) {
                        Some(parameter) => (rule, parameter),
                        None => (Rule::None, 0.0),
                    }),
                };
                ReferenceChoice { criterion, chosen }
            })
            .collect();
        Reference { count, choices }
    }

    /// aᵢ.
    fn least_squares(&self, outcome: &Outcome) -> Vec<f64> {
        (0..self.alpha.len())
            .map(|i| {
                let lambda = self.lambda()[i];
                if lambda > 0.0 { self.alpha[i] + outcome.along[i] / lambda.sqrt() } else { 0.0 }
            })
            .collect()
    }

    /// Results of the filter that `rule` gives for repetition r.
    fn summaries(&self, outcomes: &[Outcome], rule: impl Fn(usize) -> (Rule, f64)) -> MethodResults {
        let one = |r: usize| {
            let (outcome, (rule, parameter)) = (&outcomes[r], rule(r));
            let (mut error, mut rss, mut determinant) = (0.0, outcome.rss, 0.0);
            let (mut low, mut high) = (f64::INFINITY, 0.0f64);
            for (i, &lambda) in self.lambda().iter().enumerate() {
                let filtered = rule.at(i, lambda, parameter);
                (low, high) = (low.min(filtered.eigenvalue), high.max(filtered.eigenvalue));
                determinant += libm::log10(filtered.eigenvalue);
                if lambda > 0.0 {
                    let noise = outcome.along[i] / lambda.sqrt();
                    error += (filtered.removed * self.alpha[i] - filtered.factor * noise).powi(2);
                    rss += lambda * (filtered.removed * (self.alpha[i] + noise)).powi(2);
                } else {
                    error += self.alpha[i] * self.alpha[i];
                }
            }
            [high / low, determinant, error, rss]
        };
        let all: Vec<[f64; 4]> = (0..outcomes.len()).map(one).collect();
        let of = |k: usize| Summary::of(all.iter().map(|results| results[k]));
        MethodResults { condition: of(0), log10_determinant: of(1), bias_norm_squared: of(2), rss: of(3) }
    }
}

/// Regularises as many eigenvalues as lie above the usual condition limit, λ* by the default
/// criterion.
fn usual_regularization(scheme: Scheme) -> Regularization {
    Regularization::Spectral {
        scheme,
        count: Count::Auto,
        condition_limit: DEFAULT_CONDITION_LIMIT,
        lambda_star: Parameter::Criterion(Criterion::MinMse),
    }
}

/// U: with `W = Q R` its columns are `W R⁻¹ (image_i/σᵢ)`, formed in double-double; where R is
/// singular, `X Vᵢ/σᵢ` for the numerically nonzero directions.
fn left_vectors(
    study: &Study,
    design: &Design,
    sample: &Sample,
    factor: &Factor,
    spectrum: &Directions,
) -> DMatrix<f64> {
    let n = spectrum.lambda.len();
    let mut solved = vec![vec![Dd::ZERO; n]; n];
    for (i, solved) in solved.iter_mut().enumerate().asking(10 * n * n).filter(|(i, _)| spectrum.lambda[*i] > 0.0) {
        let sigma = spectrum.lambda[i].sqrt();
        solved.iter_mut().zip(spectrum.image.column(i).iter()).for_each(|(to, x)| *to = Dd::from(x / sigma));
        triangular::solve_upper(&factor.r, solved);
    }
    let usable = solved.iter().flatten().all(|x| x.is_finite());
    let mut u = DMatrix::zeros(sample.count(), n);
    let mut row = crate::design::Row::<Dd>::new(design);
    for k in (0..sample.count()).asking(10 * n * n) {
        row.at(design, sample, k);
        for i in (0..n).filter(|i| spectrum.lambda[*i] > 0.0) {
            u[(k, i)] = if usable {
                let terms = row.index.iter().zip(&row.values);
                terms.fold(Dd::ZERO, |sum, (&j, &x)| sum + x * solved[i][j]).to_f64()
            } else {
                let direction = spectrum.v.column(i);
                let terms = study.x[k * n..(k + 1) * n].iter().zip(direction.iter());
                terms.fold(Dd::ZERO, |sum, (&x, &v)| sum + Dd::product(x, v)).to_f64() / spectrum.lambda[i].sqrt()
            };
        }
    }
    u
}
