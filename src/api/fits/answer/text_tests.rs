//! Written answers against their documentation: read into the documented body, they are written
//! again to the same bytes.

use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::api::{
    examples::REQUEST_EXAMPLES,
    fits::{answer::shared_text, reader},
};
use flankfit_engine::estimation::{
    self, FitSpec, Nodes,
    inference::{Inferred, SimultaneousMethod},
    result::{
        Arithmetic, BiasReport, Cause, Choice, Coefficient, CollinearityReport, ColumnCollinearity, ColumnFigures,
        Covariance, EstimableSum, FilterReport, FilteringReport, Interval, IntervalKind as Kind, IterationReport,
        LambdaCurvePoint, LikelihoodReport, LocalSolution, MinimaxReport, NearDependency, NormLimitSource as Limit,
        Numerics, OrthonormalBasis, PerturbationBounds, PerturbationReport, Predictions, RegularizationKind,
        RegularizationReport, RegularizedSpectrum, RidgeTracePoint, RobustReport, Simultaneous, Slopes, SpectrumReport,
        TermKey, Warning,
    },
    spec::{
        Action, Count, Criterion, Degree, Distribution, Domain, Filter, Hampel, Model, NodeUncertainty, Parameter,
        PolynomialBasis, Regularization, Scaling, Scheme, Start, Terms,
    },
};
use flankfit_engine::numerics::distribution::Student;

#[path = "text_tests_constraints.rs"]
mod constraints;
#[path = "text_tests_errors.rs"]
mod errors;
#[path = "text_tests_prior.rs"]
mod prior;
#[path = "text_tests_selection.rs"]
mod selection_made;

/// Laid again, a text costs as much as a twentieth of a small fit.
#[test]
fn the_usual_answer_is_laid_once() {
    for degree in 1..=5 {
        let axis = |count: i32| (0..count).map(f64::from).collect::<Vec<_>>();
        let heights = (0..63).map(|k| f64::from(k * k % 17) / 7.0).collect();
        let nodes = Nodes::grid(axis(7), axis(9), heights, None, None).unwrap();
        let model =
            Model::Polynomial { degree: Degree::Both(degree), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
        for include in [Include::default(), Include { collinearity: true, covariance: true, ..Include::default() }] {
            let spec = FitSpec { include, ..FitSpec::new(model.clone()) };
            let result = estimation::fit(&nodes, &spec).unwrap();
            let text = write(&result, None, "", include).unwrap();
            assert!(text.len() <= room(&result, include), "{degree}: {} of {}", text.len(), room(&result, include));
        }
    }
}

const ALL: Include = Include {
    residuals: true,
    fitted: true,
    collinearity: true,
    lambda_curve: true,
    matrix_b: true,
    ridge_trace: true,
    robust_weights: true,
    peaks: true,
    covariance: true,
    influence: true,
    shape: true,
    representative: true,
    predicted_mse: true,
};

fn agrees(text: &[u8]) {
    let body: FitResultBody = serde_json::from_slice(text).unwrap();
    assert_eq!(String::from_utf8_lossy(&serde_json::to_vec(&body).unwrap()), String::from_utf8_lossy(text));
}

fn regularizations() -> Vec<Regularization> {
    let parameters = Criterion::ALL.map(Parameter::Criterion).into_iter().chain([Parameter::Fixed(1e-4)]);
    let spectral =
        |scheme, count, lambda_star| Regularization::Spectral { scheme, count, condition_limit: 30.0, lambda_star };
    parameters
        .flat_map(|parameter| {
            [
                spectral(Scheme::FirstOrder, Count::Auto, parameter),
                spectral(Scheme::Exact, Count::Given(1), parameter),
                Regularization::Ridge { parameter },
            ]
        })
        .chain([Regularization::None])
        .collect()
}

#[test]
fn answers_to_the_examples_are_as_documented() {
    let examples = REQUEST_EXAMPLES.iter().filter(|example| example.operation_id == "create_fit");
    let mut answers = 0;
    for example in examples {
        let (nodes, spec, ()): (Nodes, FitSpec, _) = reader::read_fit(example.text.as_bytes()).unwrap();
        for regularization in regularizations() {
            for scaling in [Scaling::UnitLength, Scaling::None, Scaling::Standardized] {
                let mut spec = FitSpec { regularization: regularization.clone(), scaling, ..spec.clone() };
                spec.include.residuals = true;
                spec.include.lambda_curve = true;
                spec.include.matrix_b = answers % 2 == 0;
                spec.include.collinearity = answers % 3 == 0;
                spec.node_uncertainty = Some(NodeUncertainty { position: 1e-6, height: 1e-4, kind: None });
                if let Ok(result) = estimation::fit(&nodes, &spec) {
                    agrees(&write(&result, None, "00ff", spec.include).unwrap());
                    answers += 1;
                }
            }
        }
    }
    assert!(answers > 100, "{answers}");
}

/// Makes results of any content, number by number; the number with the index `poisoned` is not
/// finite.
struct Maker {
    state: u64,
    numbers: usize,
    poisoned: usize,
    /// Whether everything that may be missing is there.
    full: bool,
}

impl Maker {
    fn new(seed: u64) -> Self {
        Maker { state: seed, numbers: 0, poisoned: usize::MAX, full: false }
    }

    fn random(&mut self) -> u64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.state ^ (self.state >> 29)
    }

    fn below(&mut self, n: u64) -> usize {
        ((self.random() >> 33) % n) as usize
    }

    fn number(&mut self) -> f64 {
        self.numbers += 1;
        if self.numbers - 1 == self.poisoned {
            return [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][self.below(3)];
        }
        match self.below(4) {
            0 => self.below(1000) as f64 / 8.0,
            1 => -(self.random() as f64) * 1e-20,
            _ => Some(f64::from_bits(self.random())).filter(|x| x.is_finite()).unwrap_or(-0.0),
        }
    }

    fn numbers(&mut self) -> Vec<f64> {
        (0..self.below(4) + usize::from(self.full)).map(|_| self.number()).collect()
    }

    fn pairs(&mut self) -> Vec<[f64; 2]> {
        (0..self.below(3) + usize::from(self.full)).map(|_| [self.number(), self.number()]).collect()
    }

    fn rows(&mut self) -> Vec<Vec<f64>> {
        (0..self.below(3) + usize::from(self.full)).map(|_| self.numbers()).collect()
    }

    fn text(&mut self) -> String {
        (0..self.below(6)).map(|_| ['u', '^', '"', '\\', '\n', 'λ', '\u{1}', '𝒳'][self.below(8)]).collect()
    }

    fn there(&mut self) -> bool {
        self.full || self.below(2) == 0
    }

    fn maybe(&mut self) -> Option<f64> {
        self.there().then(|| self.number())
    }

    fn list<T>(&mut self, mut item: impl FnMut(&mut Self) -> T) -> Vec<T> {
        (0..self.below(3) + usize::from(self.full)).map(|_| item(self)).collect()
    }

    fn criterion(&mut self) -> Option<Criterion> {
        self.there().then(|| Criterion::every().nth(self.below(13)).unwrap())
    }

    fn figures(&mut self) -> ColumnFigures {
        ColumnFigures {
            nodes: self.below(99),
            condition: self.maybe(),
            largest_correlation: self.maybe(),
            largest_vif: self.maybe(),
        }
    }

    fn bounds(&mut self) -> PerturbationBounds {
        PerturbationBounds { square_bound: self.maybe(), first_order_bound: self.maybe() }
    }

    fn choice(&mut self) -> Choice {
        Choice {
            criterion: self.criterion(),
            lambda_star: self.maybe(),
            condition: self.maybe(),
            bias_norm: self.number(),
            predicted_mse: self.maybe(),
            rms: self.number(),
        }
    }

    fn interval(&mut self) -> Interval {
        Interval {
            ends: [self.number(), self.number()],
            kind: [Kind::Student, Kind::LeastSquares, Kind::BiasAware, Kind::Posterior][self.below(4)],
            // not written
            about: Inferred { value: 0.5, std_error: 0.5, bias_bound: 0.5, student: Student::NORMAL },
            least_squares: self.there().then(|| [self.number(), self.number()]),
            gain: self.maybe(),
        }
    }

    fn bias(&mut self) -> BiasReport {
        BiasReport {
            norm: self.number(),
            sharp_bound: self.number(),
            paper_bound: self.maybe(),
            coefficient_norm_limit: self.number(),
            coefficient_norm_limit_source: [
                Limit::Request,
                Limit::Estimate,
                Limit::Heights,
                Limit::Limits,
                Limit::Prior,
            ][self.below(5)],
            upper_confidence: self.maybe(),
            e: self.maybe(),
        }
    }

    fn predictions(&mut self) -> Predictions {
        Predictions {
            place_indices: self.there().then(|| vec![0, 2]),
            level: 0.95,
            value: self.numbers(),
            std_error: self.there().then(|| self.numbers()),
            bias_bound: self.numbers(),
            confidence: self.there().then(|| self.pairs()),
            prediction: self.there().then(|| self.pairs()),
            simultaneous: self.there().then(|| Simultaneous {
                band: self.pairs(),
                factor: self.number(),
                method: [SimultaneousMethod::Scheffe, SimultaneousMethod::Tube, SimultaneousMethod::Bonferroni]
                    [self.below(3)],
                scheffe: self.number(),
            }),
            slopes: (0..self.below(3))
                .map(|_| Slopes {
                    value: self.numbers(),
                    std_error: self.there().then(|| self.numbers()),
                    confidence: self.there().then(|| self.pairs()),
                })
                .collect(),
        }
    }

    fn sums(&mut self) -> Vec<EstimableSum> {
        self.list(|m| EstimableSum {
            terms: vec![m.text()],
            weights: m.numbers(),
            value: m.number(),
            std_error: m.maybe(),
            interval: m.there().then(|| [m.number(), m.number()]),
            condition_index: m.number(),
            sentence: m.text(),
        })
    }

    fn curve_point(&mut self) -> LambdaCurvePoint {
        LambdaCurvePoint {
            lambda_star: self.number(),
            condition: self.maybe(),
            bias_norm: self.number(),
            predicted_mse: self.maybe(),
            rms: self.number(),
            gcv: self.maybe(),
            coefficient_norm: self.number(),
        }
    }

    fn spectrum(&mut self) -> SpectrumReport {
        SpectrumReport {
            eigenvalues: self.numbers(),
            condition: self.maybe(),
            log10_condition: self.maybe(),
            log10_determinant: self.maybe(),
            rank: self.below(40),
            regularized: RegularizedSpectrum {
                eigenvalues: self.numbers(),
                condition: self.maybe(),
                log10_determinant: self.maybe(),
            },
        }
    }

    fn result(&mut self) -> FitResult {
        FitResult {
            coefficients: self.list(|m| Coefficient {
                term: m.text(),
                key: match m.below(3) {
                    0 => TermKey::Powers(vec![m.below(9), m.below(9)]),
                    1 => TermKey::Index(vec![m.below(9)]),
                    _ => TermKey::Column(m.below(1000)),
                },
                value: m.number(),
                std_error: m.maybe(),
                conditional_std_error: m.maybe(),
                least_squares: m.number(),
                least_squares_std_error: m.maybe(),
                bias_bound: m.number(),
                interval: m.there().then(|| m.interval()),
            }),
            // That of a request or of the nodes, which are finite.
            domain: self.there().then(|| Domain { u: Some([0.5, 1e300]), v: self.there().then_some([-1e-5, 0.0]) }),
            spectrum: self.spectrum(),
            regularization: RegularizationReport {
                kind: [
                    RegularizationKind::None,
                    RegularizationKind::Spectral,
                    RegularizationKind::Ridge,
                    RegularizationKind::Tikhonov,
                    RegularizationKind::TruncatedSvd,
                    RegularizationKind::JamesStein,
                    RegularizationKind::Attraction,
                ][self.below(7)],
                scheme: self.there().then(|| [Scheme::FirstOrder, Scheme::Exact][self.below(2)]),
                count: self.there().then(|| self.below(40)),
                lambda_star: self.maybe(),
                rank: self.there().then(|| self.below(40)),
                shrinkage_factor: self.maybe(),
                lambda_star_interval: self.there().then(|| [self.number(), self.number()]),
                gamma: self.maybe(),
                criterion: self.criterion(),
                fixed: self.below(2) == 0,
                filter_factors: self.numbers(),
                matrix_norm_squared: self.maybe(),
                largest_eigenvalue_bound: self.maybe(),
                predicted_mse_corrected: self.maybe(),
                representative: self.there().then(|| self.representative()),
                choices: self.list(Maker::choice),
            },
            bias: self.bias(),
            collinearity: Arc::new(CollinearityReport {
                basis: self.there().then(|| OrthonormalBasis { condition: self.maybe() }),
                columns: self.list(|m| ColumnCollinearity { term: m.text(), vif: m.maybe() }),
                correlation: self.there().then(|| self.rows()),
                variance_proportions: self.there().then(|| self.rows()),
                near_dependencies: self.list(|m| NearDependency {
                    eigenvalue: m.number(),
                    condition_index: m.maybe(),
                    weights: m.numbers(),
                    terms: m.list(Maker::text),
                    cosine: m.maybe(),
                    weight_ratio: m.maybe(),
                    r_squared: m.maybe(),
                    cause: [Cause::Basis, Cause::Nodes][m.below(2)],
                    sentence: m.text(),
                }),
            }),
            perturbation: self
                .there()
                .then(|| PerturbationReport { least_squares: self.bounds(), regularized: self.bounds() }),
            residuals: self.residuals(),
            robust: self.there().then(|| RobustReport {
                converged: self.below(2) == 1,
                iterations: self.below(1_000),
                tolerance_reached: self.maybe(),
                scale: self.maybe(),
                dispersion: self.maybe(),
                objective: self.number(),
                weights: self.numbers(),
                rejected: vec![self.below(9), 12],
                certificate: self.maybe(),
                unique: self.there().then(|| self.below(2) == 1),
                vertex: self.there().then(|| vec![self.below(9), 3]),
                subset_size: self.there().then(|| self.below(99)),
                start: self.there().then_some(Start::LeastTrimmed),
                solution: [LocalSolution::Global, LocalSolution::FromStart, LocalSolution::BestOfMany][self.below(3)],
                minimax: self.there().then(|| MinimaxReport {
                    contamination: self.number(),
                    estimated: self.below(2) == 1,
                    k: self.number(),
                    variance: self.number(),
                }),
                likelihood: self.there().then(|| LikelihoodReport {
                    distribution: Distribution::Laplace,
                    shape: self.maybe(),
                    shape_std_error: self.maybe(),
                    log_likelihood: self.number(),
                }),
                coefficients: self.numbers(),
            }),
            lambda_curve: self.there().then(|| self.list(Maker::curve_point)),
            ridge_trace: self
                .there()
                .then(|| self.list(|m| RidgeTracePoint { k: m.number(), coefficients: m.numbers() })),
            errors: self.there().then(|| self.errors()),
            variance: self.there().then(|| self.variance()),
            positions: self.there().then(|| self.positions()),
            matrix_b: self.there().then(|| self.rows()),
            matrix_b_factors: self.there().then(|| self.factors()),
            representative: self.there().then(|| self.piece()),
            estimable: self.there().then(|| self.sums()),
            filtering: self.there().then(|| self.filtering()),
            influence: self.there().then(|| self.influence()),
            selection: self.there().then(|| self.selection()),
            prior: self.there().then(|| self.prior()),
            constraints: self.there().then(|| self.constraints()),
            covariance: self.there().then(|| Covariance { coefficients: self.rows(), least_squares: self.rows() }),
            predictions: self.there().then(|| self.predictions()),
            sums: None,
            shape: None,
            without_suspected: None,
            numerics: Numerics {
                arithmetic: [Arithmetic::Double, Arithmetic::DoubleDouble][self.below(2)],
                correct_digits: self.number(),
            },
            warnings: self.list(|m| Warning::InfiniteInflation(vec![m.text()])),
        }
    }

    fn filtering(&mut self) -> FilteringReport {
        FilteringReport {
            filters: self.list(|m| FilterReport {
                filter: Filter::Hampel(Hampel { window: 5, threshold: 3.0, action: Action::Remove, axis: None }),
                changed: m.below(9),
                max_change: m.number(),
                rms_change: m.number(),
                peaks: m.there().then(|| vec![m.below(9)]),
                iteration: m.there().then(|| IterationReport { iterations: m.below(99), converged: m.below(2) == 1 }),
            }),
            before: self.figures(),
            after: self.figures(),
        }
    }
}

proptest! {
    #[test]
    fn any_answer_is_as_documented(seed in any::<u64>()) {
        agrees(&write(&Maker::new(seed).result(), None, "digest", ALL).unwrap());
    }
}

/// What the fit does with a result: the columns' report, which comes first, and then the rest.
fn checked(mut result: FitResult) -> Result<FitResult, estimation::FitError> {
    let report = Arc::unwrap_or_clone(result.collinearity);
    result.collinearity =
        Arc::new(estimation::diagnostics::finite::checked_collinearity(report, &mut result.warnings)?);
    let filtering = result.filtering.take();
    let mut result = estimation::diagnostics::finite::checked(result)?;
    result.filtering = filtering
        .map(|report| estimation::diagnostics::finite::checked_filtering(report, &mut result.warnings))
        .transpose()?;
    Ok(result)
}

#[test]
fn a_shared_report_is_written_once_and_always_the_same() {
    let result = Maker { full: true, ..Maker::new(7) }.result();
    let alone = write(&result, None, "digest", ALL).unwrap();
    assert!(shared_text::find(&result.collinearity, true).is_none(), "nobody else will ask for it");
    let _plan = Arc::clone(&result.collinearity);
    let first = write(&result, None, "digest", ALL).unwrap();
    assert!(shared_text::find(&result.collinearity, true).is_some());
    assert!(shared_text::find(&result.collinearity, false).is_none(), "without the matrices it is another text");
    assert_eq!((write(&result, None, "digest", ALL).unwrap(), first), (alone.clone(), alone));
}

/// The fit's last look finds every number that is not finite: it leaves the number out or refuses,
/// and the writer finds none.
#[test]
fn no_number_that_is_not_finite_reaches_the_writer() {
    let mut whole = Maker { full: true, ..Maker::new(7) };
    assert!(write(&whole.result(), None, "digest", ALL).is_ok());
    let (mut left_out, mut refused) = (0, 0);
    for poisoned in 0..whole.numbers {
        let result = Maker { full: true, poisoned, ..Maker::new(7) }.result();
        assert!(matches!(write(&result, None, "digest", ALL), Err(NotFinite(_))), "{poisoned}");
        match checked(result) {
            Ok(result) => {
                agrees(&write(&result, None, "digest", ALL).unwrap());
                left_out += 1;
            }
            Err(_) => refused += 1,
        }
    }
    assert!(left_out > 20 && refused > 20, "{left_out} {refused}");
}
