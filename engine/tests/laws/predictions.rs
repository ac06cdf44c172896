//! Covariances, heights, slopes and bands at places, against formulas and by Monte Carlo.

use crate::oracle::random::Random;
use crate::problems::{Problem, assert_close, by, fit, linear, polynomial, spectral};
use flankfit_engine::estimation::Nodes;
use flankfit_engine::estimation::inference::SimultaneousMethod;
use flankfit_engine::estimation::result::{Covariance, Predictions};
use flankfit_engine::estimation::spec::{
    Attraction, Count, Criterion, Degree, Estimator, FitSpec, Include, Kinds, Knots, Model, Parameter, Places,
    PolynomialBasis, Predict, Regularization, Scaling, Scheme, Tikhonov,
};
use nalgebra::DMatrix;

const ALL: Kinds = Kinds { confidence: true, prediction: true, simultaneous: true };

fn at(places: Places) -> Option<Predict> {
    let slopes = !matches!(places, Places::Rows(_));
    Some(Predict { at: places, level: None, kinds: ALL, slopes })
}

fn plain(spec: FitSpec) -> FitSpec {
    FitSpec { regularization: Regularization::None, ..spec }
}

fn full(triangle: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(triangle.len(), triangle.len(), |i, j| triangle[i.max(j)][i.min(j)])
}

fn assert_matrix(what: &str, found: &DMatrix<f64>, want: &DMatrix<f64>, relative: f64) {
    let size = |j: usize| want[(j, j)].abs().sqrt();
    for i in 0..want.nrows() {
        for j in 0..want.ncols() {
            assert_close(what, found[(i, j)], want[(i, j)], 0.0, relative * size(i) * size(j));
        }
    }
}

#[test]
fn covariances_are_those_of_the_normal_equations() {
    let problem = Problem::graded(5, 5, 20, 3.0);
    let x = DMatrix::from_fn(problem.x.len(), 5, |i, j| problem.x[i][j]);
    let inverse = (x.transpose() * &x).try_inverse().unwrap();
    let include = Include { covariance: true, ..Include::default() };
    let kinds = [
        Regularization::None,
        Regularization::Ridge { parameter: Parameter::Fixed(0.01) },
        spectral(Scheme::Exact, Count::Auto, by(Criterion::MinMse)),
        Regularization::TruncatedSvd { rank: 3 },
        Regularization::Tikhonov(Tikhonov { order: 1, weights: None, parameter: Parameter::Fixed(0.1) }),
        Regularization::Attraction(Attraction { target: vec![0.0; 5], parameter: Parameter::Fixed(0.7) }),
    ];
    for regularization in kinds {
        for scaling in [Scaling::UnitLength, Scaling::None] {
            let spec = FitSpec { regularization: regularization.clone(), include, scaling, ..linear() };
            let result = fit(&problem.nodes(), &spec);
            let variance = result.residuals.sigma.unwrap().powi(2);
            let Covariance { coefficients, least_squares } = result.covariance.as_ref().unwrap();
            assert_matrix("least squares", &full(least_squares), &(&inverse * variance), 1e-10);
            for (j, c) in result.coefficients.iter().enumerate() {
                let own = c.error_given_lambda().unwrap();
                assert_close("std_error", coefficients[j][j].sqrt(), own, 1e-9, 1e-12 * variance.sqrt());
                assert_close(
                    "least squares",
                    least_squares[j][j].sqrt(),
                    c.least_squares_std_error.unwrap(),
                    1e-9,
                    0.0,
                );
            }
            // H C Hᵀ with the map H found column by column from fits of the columns themselves
            if matches!(spec.regularization, Regularization::Ridge { .. }) && scaling == Scaling::None {
                let h =
                    (x.transpose() * &x + DMatrix::identity(5, 5) * 0.01).try_inverse().unwrap() * x.transpose() * &x;
                assert_matrix("ridge", &full(coefficients), &(&h * &inverse * h.transpose() * variance), 1e-9);
            }
        }
    }
}

#[test]
fn robust_covariances_have_the_standard_errors() {
    let mut problem = Problem::graded(6, 4, 40, 2.0);
    problem.y[3] += 50.0;
    let include = Include { covariance: true, ..Include::default() };
    for estimator in [Estimator::LeastAbsolute, Estimator::Rank] {
        let spec = plain(FitSpec { estimator, include, ..linear() });
        let result = fit(&problem.nodes(), &spec);
        let covariance = result.covariance.as_ref().unwrap();
        for (j, c) in result.coefficients.iter().enumerate() {
            assert_close("std_error", covariance.coefficients[j][j].sqrt(), c.error_given_lambda().unwrap(), 1e-9, 0.0);
        }
    }
}

fn curve(noise: f64, seed: u64) -> Nodes {
    let mut random = Random::new(seed);
    let x: Vec<f64> = (0..41).map(|i| 30.0 + 0.1 * f64::from(i)).collect();
    let y = x.iter().map(|x| height(*x) + noise * random.normal()).collect();
    Nodes::curve(x, y, None).unwrap()
}

fn height(x: f64) -> f64 {
    let t = x - 32.0;
    1.0 + 0.5 * t - 0.3 * t * t + 0.05 * t * t * t
}

fn slope(x: f64) -> f64 {
    let t = x - 32.0;
    0.5 - 0.6 * t + 0.15 * t * t
}

fn predicted(nodes: &Nodes, spec: &FitSpec) -> Predictions {
    fit(nodes, spec).predictions.unwrap()
}

#[test]
fn heights_and_slopes_of_an_exact_curve() {
    let places: Vec<f64> = (0..30).map(|i| 29.5 + f64::from(i) * 0.17).collect();
    let bases = [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre];
    let models = bases
        .map(|basis| polynomial(Degree::Both(3), basis))
        .into_iter()
        .chain([FitSpec::new(Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(2), weights: None })]);
    for (number, model) in models.enumerate() {
        let inside: Vec<f64> = places.iter().copied().filter(|x| number < 3 || (30.0..=34.0).contains(x)).collect();
        let spec = FitSpec { predict: at(Places::Curve(inside.clone())), ..plain(model) };
        let found = predicted(&curve(0.0, 1), &spec);
        for (k, &x) in inside.iter().enumerate() {
            assert_close("height", found.value[k], height(x), 1e-12, 1e-12);
            assert_close("slope", found.slope_u.as_ref().unwrap().value[k], slope(x), 1e-11, 1e-11);
        }
        assert!(found.slope_u.is_some() && found.slope_v.is_none());
    }
}

#[test]
fn errors_of_heights_follow_from_the_covariance() {
    let include = Include { covariance: true, ..Include::default() };
    let x = [30.4, 33.3];
    for regularization in [Regularization::None, Regularization::Ridge { parameter: Parameter::Fixed(1e-3) }] {
        for scaling in [Scaling::UnitLength, Scaling::Standardized] {
            let spec = FitSpec {
                include,
                scaling,
                regularization: regularization.clone(),
                predict: at(Places::Curve(x.to_vec())),
                domain: None,
                ..polynomial(Degree::Both(2), PolynomialBasis::Chebyshev)
            };
            let result = fit(&curve(0.01, 3), &spec);
            let covariance = full(&result.covariance.as_ref().unwrap().coefficients);
            let found = result.predictions.as_ref().unwrap();
            for (k, x) in x.iter().enumerate() {
                let t = (x - 32.0) / 2.0;
                let (row, turned) = ([1.0, t, 2.0 * t * t - 1.0], [0.0, 0.5, 2.0 * t]);
                let variance = |row: [f64; 3]| {
                    (0..3)
                        .flat_map(|i| (0..3).map(move |j| (i, j)))
                        .map(|(i, j)| row[i] * row[j] * covariance[(i, j)])
                        .sum::<f64>()
                };
                assert_close("se", found.std_error.as_ref().unwrap()[k], variance(row).sqrt(), 1e-8, 0.0);
                let slopes = found.slope_u.as_ref().unwrap();
                assert_close("slope", slopes.std_error.as_ref().unwrap()[k], variance(turned).sqrt(), 1e-8, 0.0);
                let value: f64 = row.iter().zip(&result.coefficients).map(|(x, c)| x * c.value).sum();
                assert_close("value", found.value[k], value, 1e-10, 0.0);
            }
        }
    }
}

/// Coverage of bands of a curve or surface: each interval by itself, a further measurement, and all
/// of a fine set of places at once.
fn coverage(nodes: impl Fn(u64) -> Nodes, places: &Places, truth: &[f64], spec: &FitSpec, noise: f64) -> [f64; 4] {
    const REPETITIONS: u64 = 1000;
    let spec = FitSpec { predict: at(places.clone()), ..spec.clone() };
    let mut hits = [0usize; 3];
    let mut random = Random::new(99);
    let mut factor = 0.0;
    for seed in 0..REPETITIONS {
        let found = predicted(&nodes(seed), &spec);
        let holds = |band: &[[f64; 2]], k: usize, value: f64| band[k][0] <= value && value <= band[k][1];
        let count = |band: &Vec<[f64; 2]>| (0..truth.len()).filter(|&k| holds(band, k, truth[k])).count();
        hits[0] += count(found.confidence.as_ref().unwrap());
        let again = found.prediction.as_ref().unwrap();
        hits[1] += (0..truth.len()).filter(|&k| holds(again, k, truth[k] + noise * random.normal())).count();
        let everywhere = found.simultaneous.as_ref().unwrap();
        hits[2] += usize::from(count(&everywhere.band) == truth.len());
        factor = everywhere.factor / everywhere.scheffe;
    }
    let each = REPETITIONS as f64 * truth.len() as f64;
    [hits[0] as f64 / each, hits[1] as f64 / each, hits[2] as f64 / REPETITIONS as f64, factor]
}

#[test]
fn bands_of_a_curve_hold() {
    let places: Vec<f64> = (0..=80).map(|i| 30.0 + 0.05 * f64::from(i)).collect();
    let truth: Vec<f64> = places.iter().map(|x| height(*x)).collect();
    let spec = plain(polynomial(Degree::Both(3), PolynomialBasis::Monomial));
    let [each, again, all, narrower] = coverage(|seed| curve(0.05, seed), &Places::Curve(places), &truth, &spec, 0.05);
    assert!((0.935..0.965).contains(&each) && (0.935..0.965).contains(&again), "{each} {again}");
    assert!((0.935..0.97).contains(&all), "{all}");
    assert!(narrower < 0.95, "the tube is narrower than Scheffé's: {narrower}");
}

fn surface(u: f64, v: f64) -> f64 {
    0.4 + 0.3 * u - 0.2 * v + 0.5 * u * v + 0.1 * u * u * v
}

#[test]
fn bands_of_a_surface_hold() {
    let axis = |n: u32| (0..n).map(|i| f64::from(i) * 2.0 / f64::from(n - 1) - 1.0).collect::<Vec<f64>>();
    let (u, v) = (axis(9), axis(5));
    let nodes = |seed: u64| {
        let mut random = Random::new(seed);
        let z =
            u.iter().flat_map(|&u| axis(5).into_iter().map(move |v| surface(u, v))).map(|z| z + 0.1 * random.normal());
        Nodes::grid(u.clone(), v.clone(), z.collect(), None, None).unwrap()
    };
    let (fine_u, fine_v) = (axis(13), axis(13));
    let truth: Vec<f64> = fine_u.iter().flat_map(|&u| fine_v.iter().map(move |&v| surface(u, v))).collect();
    let places = Places::Grid { u: fine_u.clone(), v: fine_v.clone() };
    let spec = plain(polynomial(Degree::Each(2, 1), PolynomialBasis::Legendre));
    let [each, again, all, narrower] = coverage(nodes, &places, &truth, &spec, 0.1);
    assert!((0.935..0.965).contains(&each) && (0.935..0.965).contains(&again), "{each} {again}");
    assert!((0.935..0.98).contains(&all) && narrower <= 1.0, "{all} {narrower}");
}

#[test]
fn bands_have_coverage_where_a_norm_limit_is_given() {
    let places: Vec<f64> = (0..=20).map(|i| 30.0 + 0.2 * f64::from(i)).collect();
    // all coefficients along the worst determined direction would be the worst case; here a usual
    // one
    let truth: Vec<f64> = places.iter().map(|x| height(*x)).collect();
    let base = polynomial(Degree::Both(3), PolynomialBasis::Chebyshev);
    let norm = {
        let exact = fit(&curve(0.0, 1), &plain(base.clone()));
        let lengths = |k: i32| {
            (0..41).map(|i| (f64::from(k) * (f64::from(i) / 20.0 - 1.0).acos()).cos().powi(2)).sum::<f64>().sqrt()
        };
        exact.coefficients.iter().zip(0..).map(|(c, k)| (c.value * lengths(k)).powi(2)).sum::<f64>().sqrt()
    };
    let spec = FitSpec { coefficient_norm_limit: Some(norm), ..base };
    let [each, again, all, _] = coverage(|seed| curve(0.3, seed), &Places::Curve(places), &truth, &spec, 0.3);
    assert!(each >= 0.94 && again >= 0.94 && all >= 0.94, "{each} {again} {all}");
}

#[test]
fn methods_and_factors() {
    // one coefficient: a constant, whose band is Student's
    let spec = FitSpec {
        predict: at(Places::Curve(vec![30.0, 31.0])),
        ..plain(polynomial(Degree::Both(0), PolynomialBasis::Monomial))
    };
    let found = predicted(&curve(0.1, 5), &spec);
    let simultaneous = found.simultaneous.unwrap();
    for (band, confidence) in simultaneous.band.iter().zip(found.confidence.unwrap()) {
        assert_close("low", band[0], confidence[0], 1e-9, 0.0);
        assert_close("high", band[1], confidence[1], 1e-9, 0.0);
    }
    assert!(simultaneous.factor <= simultaneous.scheffe * (1.0 + 1e-12));
    assert!(matches!(simultaneous.method, SimultaneousMethod::Scheffe | SimultaneousMethod::Tube));
}

#[test]
fn rows_of_a_matrix_are_answered_as_places_of_a_curve() {
    let nodes = curve(0.02, 8);
    let x: Vec<f64> = (0..41).map(|i| 30.0 + 0.1 * f64::from(i)).collect();
    let row = |x: f64| vec![1.0, x, x * x];
    let Nodes::Curve(measured) = &nodes else { panic!("a curve") };
    let matrix = Nodes::matrix(x.iter().flat_map(|x| row(*x)).collect(), 3, measured.y().to_vec(), None, None).unwrap();
    let (places, all) = (vec![30.3, 33.0, 36.0], Kinds { simultaneous: false, ..ALL });
    let asked = |at| Some(Predict { at, level: Some(0.9), kinds: all, slopes: false });
    for (regularization, limit) in [(Regularization::None, None), (by_ridge(), None), (by_ridge(), Some(40.0))] {
        let spec = |model: Model, at| FitSpec {
            regularization: regularization.clone(),
            coefficient_norm_limit: limit,
            predict: asked(at),
            ..FitSpec::new(model)
        };
        let polynomial = polynomial(Degree::Both(2), PolynomialBasis::Monomial).model;
        let of_curve = predicted(&nodes, &spec(polynomial, Places::Curve(places.clone())));
        let rows = Places::Rows(places.iter().map(|x| row(*x)).collect());
        let of_rows = predicted(&matrix, &spec(Model::Linear, rows));
        let near = |what: &str, a: &[f64], b: &[f64]| {
            a.iter().zip(b).for_each(|(a, b)| assert_close(what, *a, *b, 1e-7, 1e-9));
        };
        near("value", &of_rows.value, &of_curve.value);
        near("bias", &of_rows.bias_bound, &of_curve.bias_bound);
        near("error", of_rows.std_error.as_ref().unwrap(), of_curve.std_error.as_ref().unwrap());
        for (a, b) in [(&of_rows.confidence, &of_curve.confidence), (&of_rows.prediction, &of_curve.prediction)] {
            near("band", a.as_ref().unwrap().as_flattened(), b.as_ref().unwrap().as_flattened());
        }
    }
}

fn by_ridge() -> Regularization {
    Regularization::Ridge { parameter: Parameter::Fixed(1e-3) }
}

#[test]
fn bands_of_rows_hold_for_all_rows_at_once() {
    let x: Vec<Vec<f64>> =
        (0..20).map(f64::from).map(|i| vec![1.0, 0.1 * i, (0.7 * i).sin(), (0.3 * i).cos()]).collect();
    let (truth, noise) = ([1.0, -0.5, 2.0, 0.3], 0.4);
    let height = |row: &Vec<f64>| row.iter().zip(&truth).map(|(x, a)| x * a).sum::<f64>();
    let nodes = |seed: u64| {
        let mut random = Random::new(seed);
        let y: Vec<f64> = x.iter().map(|row| height(row) + noise * random.normal()).collect();
        crate::problems::matrix(&x, &y, None)
    };
    for (rows, method) in [(x[3..6].to_vec(), SimultaneousMethod::Bonferroni), (x.clone(), SimultaneousMethod::Scheffe)]
    {
        let asked: Vec<f64> = rows.iter().map(height).collect();
        let [each, again, all, narrower] =
            coverage(nodes, &Places::Rows(rows.clone()), &asked, &plain(linear()), noise);
        assert!((0.935..0.965).contains(&each) && (0.935..0.965).contains(&again), "{each} {again}");
        assert!((0.94..0.995).contains(&all) && narrower <= 1.0, "{all} {narrower}");
        let spec = FitSpec { predict: at(Places::Rows(rows)), ..plain(linear()) };
        assert_eq!(predicted(&nodes(1), &spec).simultaneous.unwrap().method, method);
    }
}

/// About a quantile there is no interval of a further height, and the answer says so.
#[test]
fn a_quantile_has_no_prediction() {
    let kinds = Kinds { confidence: true, prediction: true, simultaneous: false };
    let asked = |estimator: Estimator, kinds: Kinds| {
        let predict = Some(Predict { at: Places::Curve(vec![31.5]), level: None, kinds, slopes: false });
        let line = polynomial(Degree::Both(1), PolynomialBasis::Legendre);
        let spec = FitSpec { estimator, predict, ..plain(line) };
        let found = fit(&curve(0.1, 77), &spec);
        let warned = found.warnings.iter().any(|w| w.code() == "no_prediction_intervals");
        (found.predictions.unwrap().prediction.is_some(), warned)
    };
    assert_eq!(asked(Estimator::Quantile { tau: 0.3 }, kinds), (false, true));
    assert_eq!(asked(Estimator::Quantile { tau: 0.3 }, Kinds { prediction: false, ..kinds }), (false, false));
    assert_eq!(asked(Estimator::LeastAbsolute, kinds), (true, false));
}
