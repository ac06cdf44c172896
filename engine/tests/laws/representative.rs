//! The matrix B of a representative piece (section 6.3): equal to one's own at the same places,
//! Eq. 29 with an explicit B elsewhere, what is refused.

use crate::{
    oracle::random::Random,
    problems::{config, fit},
};
use flankfit_engine::estimation::{
    self, FitError, FitResult, Nodes, Recursive,
    spec::{
        Count, Criterion, DEFAULT_CONDITION_LIMIT, Degree, FitSpec, Include, Kinds, Model, Parameter, Piece, PieceOf,
        Places, PolynomialBasis, Predict, Regularization, Representative, Scaling, Scheme, Terms,
    },
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

const ALL: Include = Include {
    residuals: true,
    fitted: false,
    collinearity: false,
    lambda_curve: false,
    matrix_b: true,
    ridge_trace: false,
    robust_weights: false,
    peaks: false,
    covariance: true,
    influence: true,
    shape: false,
    representative: true,
    predicted_mse: false,
    enclosure: false,
};

fn powers(degree: usize) -> Model {
    Model::Polynomial { degree: Degree::Both(degree), basis: PolynomialBasis::Monomial, terms: Terms::Tensor }
}

fn by(piece: Piece) -> Regularization {
    let of = PieceOf { iteration: None, fit_id: None };
    Regularization::Representative(Representative { of, piece: Some(Box::new(piece)) })
}

fn own(scheme: Scheme, count: usize, lambda_star: Parameter) -> Regularization {
    let condition_limit = DEFAULT_CONDITION_LIMIT;
    Regularization::Spectral { scheme, count: Count::Given(count), condition_limit, lambda_star }
}

fn nodes(x: &[f64], random: &mut Random) -> Nodes {
    let y = x.iter().map(|x| (3.0 * x).sin() + 0.05 * random.normal()).collect();
    Nodes::curve(x.to_vec(), y, None).unwrap()
}

fn piece(found: &FitResult) -> Piece {
    found.representative.clone().unwrap()
}

fn near(what: &str, a: f64, b: f64, slack: f64) {
    assert!((a - b).abs() <= slack * a.abs().max(b.abs()), "{what}: {a:e} {b:e}");
}

proptest! {
    #![proptest_config(config(32))]

    /// At the places of the piece its B is that of λ* as a given number, whatever the heights.
    #[test]
    fn at_the_same_places_it_is_ones_own(
        seed in 0u64..1000, degree in 3usize..7, count in 1usize..3, exact: bool, unit: bool,
    ) {
        let random = &mut Random::new(seed);
        let x: Vec<f64> = (0..20).map(|k| 1.0 + f64::from(k) / 19.0).collect();
        let scheme = if exact { Scheme::Exact } else { Scheme::FirstOrder };
        let plain = FitSpec {
            scaling: if unit { Scaling::UnitLength } else { Scaling::None },
            include: ALL,
            coefficient_norm_limit: Some(50.0),
            predict: Some(Predict {
                at: Places::Curve(vec![1.05, 1.5, 1.99]), level: None, kinds: Kinds::default(), slopes: true,
            }),
            ..FitSpec::new(powers(degree))
        };
        let regularization = own(scheme, count, Parameter::Criterion(Criterion::Gcv));
        let first = FitSpec { regularization, ..plain.clone() };
        let found = fit(&nodes(&x, random), &first);
        let Some(piece) = found.representative else { return Ok(()) };
        prop_assert_eq!(piece.eigenvalues.len(), count);
        let second = nodes(&x, random);
        let lambda_star = Parameter::Fixed(piece.lambda_star);
        let wanted = fit(&second, &FitSpec { regularization: own(scheme, count, lambda_star), ..plain.clone() });
        let found = fit(&second, &FitSpec { regularization: by(piece), ..plain });
        // V is known to the digits of double, X V to as many less as the condition costs
        let slack = 1e-15 * wanted.spectrum.condition.unwrap().sqrt().max(1e4);
        let size = wanted.coefficients.iter().map(|c| c.value.abs()).fold(0.0, f64::max);
        for (a, b) in found.coefficients.iter().zip(&wanted.coefficients) {
            prop_assert!((a.value - b.value).abs() <= slack * size, "{} {} {slack}", a.value, b.value);
            near("std_error", a.error_given_lambda().unwrap(), b.error_given_lambda().unwrap(), slack);
            near("bias", a.bias_bound, b.bias_bound, slack);
            prop_assert_eq!(a.least_squares, b.least_squares);
            near("interval", a.interval.unwrap().ends[1], b.interval.unwrap().ends[1], 1e-12);
        }
        near("rss", found.residuals.rss, wanted.residuals.rss, 1e-8);
        near("sharp", found.bias.sharp_bound, wanted.bias.sharp_bound, slack);
        near("norm", found.regularization.matrix_norm_squared.unwrap(),
            wanted.regularization.matrix_norm_squared.unwrap(), 1e-6);
        let sorted = |found: &FitResult| {
            let mut all = found.spectrum.regularized.eigenvalues.clone();
            all.sort_by(f64::total_cmp);
            all
        };
        // small eigenvalues are known to the rounding of large ones
        let (found_values, wanted_values) = (sorted(&found), sorted(&wanted));
        let largest = wanted_values.last().copied().unwrap_or(0.0);
        for (a, b) in found_values.into_iter().zip(wanted_values) {
            prop_assert!((a - b).abs() <= 1e-6 * b + 1e-14 * largest, "eigenvalue: {a} {b}");
        }
        prop_assert!(found.regularization.representative.unwrap().alignment > 1.0 - 1e-9);
        let (a, b) = (found.predictions.unwrap(), wanted.predictions.unwrap());
        for k in 0..3 {
            near("height", a.value[k], b.value[k], 1e-8);
            near("error", a.std_error.as_ref().unwrap()[k], b.std_error.as_ref().unwrap()[k], 1e-7);
            near("bias", a.bias_bound[k], b.bias_bound[k], 1e-6);
        }
        let (a, b) = (found.influence.unwrap(), wanted.influence.unwrap());
        for (a, b) in a.leverage.iter().zip(&b.leverage) {
            prop_assert!((a - b).abs() < 1e-7);
        }
    }

    /// Elsewhere: `Â_B = (X̄ᵀX̄)⁻¹X̄ᵀY` with X̄ = X + B and the returned rows of B, its covariance
    /// and its bias.
    #[test]
    fn elsewhere_it_is_equation_29(seed in 0u64..1000, count in 1usize..3) {
        let random = &mut Random::new(seed);
        let x: Vec<f64> = (0..15).map(|k| f64::from(k) / 14.0).collect();
        let plain = FitSpec { include: ALL, ..FitSpec::new(powers(3)) };
        let regularization = own(Scheme::FirstOrder, count, Parameter::Fixed(0.05));
        let piece = piece(&fit(&nodes(&x, random), &FitSpec { regularization, ..plain.clone() }));
        let mut other: Vec<f64> = (0..12).map(|_| random.between(-0.1, 1.2)).collect();
        other.sort_by(f64::total_cmp);
        let second = nodes(&other, random);
        let r = 7.0;
        let spec = FitSpec {
            regularization: by(piece), noise_sigma: Some(0.05), coefficient_norm_limit: Some(r), ..plain
        };
        let found = fit(&second, &spec);
        let n = 4;
        let x = DMatrix::from_fn(12, n, |k, j| other[k].powi(j as i32));
        let b = found.matrix_b.as_ref().unwrap();
        let bar = &x + DMatrix::from_fn(12, n, |k, j| b[k][j]);
        let y = DVector::from_vec(second_heights(&second));
        let solver = (bar.transpose() * &bar).try_inverse().unwrap() * bar.transpose();
        let wanted = &solver * &y;
        let covariance = &solver * solver.transpose() * 0.05f64.powi(2);
        let scale: Vec<f64> = x.column_iter().map(|column| column.norm()).collect();
        for j in 0..n {
            let c = &found.coefficients[j];
            prop_assert!((c.value - wanted[j]).abs() < 1e-7 * wanted.norm(), "{} {}", c.value, wanted[j]);
            near("std_error", c.error_given_lambda().unwrap(), covariance[(j, j)].sqrt(), 1e-7);
            // the bias is (solver X − 1) A: at most r where A has length r in the scaled columns
            let bias: Vec<f64> = (0..n)
                .map(|k| ((&solver * &x)[(j, k)] - f64::from(u8::from(j == k))) / scale[k])
                .collect();
            let sharp = r * bias.iter().map(|b| b * b).sum::<f64>().sqrt();
            near("bias_bound", c.bias_bound, sharp, 1e-6);
        }
        let shrunk = DMatrix::from_fn(12, n, |k, j| bar[(k, j)] / scale[j]);
        let mut values: Vec<f64> = shrunk.svd(false, false).singular_values.iter().map(|s| s * s).collect();
        values.sort_by(f64::total_cmp);
        for (found, wanted) in found.spectrum.regularized.eigenvalues.iter().zip(values) {
            near("eigenvalue", *found, wanted, 1e-7);
        }
        let added = DMatrix::from_fn(12, n, |k, j| b[k][j] / scale[j]).norm_squared();
        near("‖B‖²", found.regularization.matrix_norm_squared.unwrap(), added, 1e-7);
        // a stream of the same nodes, kept as sums
        let mut stream = Recursive::new(&FitSpec { include: Include::default(), ..spec }, 1.0).unwrap();
        stream.push(&second).unwrap();
        let kept = stream.result().unwrap().unwrap();
        for (a, b) in kept.coefficients.iter().zip(&found.coefficients) {
            near("stream", a.value, b.value, 1e-7);
            near("stream", a.error_given_lambda().unwrap(), b.error_given_lambda().unwrap(), 1e-7);
        }
    }
}

fn second_heights(nodes: &Nodes) -> Vec<f64> {
    match nodes {
        Nodes::Curve(curve) => curve.y().to_vec(),
        _ => unreachable!("curves only"),
    }
}

/// A piece whose directions are none of the smallest: it does not serve its purpose, and a warning
/// says so.
#[test]
fn a_piece_of_other_directions_is_warned_of() {
    let random = &mut Random::new(4);
    let x: Vec<f64> = (0..15).map(|k| 5.0 + f64::from(k) / 14.0).collect();
    let plain = FitSpec { include: ALL, ..FitSpec::new(powers(2)) };
    let regularization = own(Scheme::Exact, 1, Parameter::Fixed(1e-3));
    let mut piece = piece(&fit(&nodes(&x, random), &FitSpec { regularization, ..plain.clone() }));
    // about 0 the same powers depend on each other otherwise
    let other: Vec<f64> = x.iter().map(|x| x - 5.5).collect();
    let second = nodes(&other, random);
    let found = fit(&second, &FitSpec { regularization: by(piece.clone()), ..plain.clone() });
    let alignment = found.regularization.representative.as_ref().unwrap().alignment;
    assert!(alignment < 0.9, "{alignment}");
    let warned = |found: &FitResult| found.warnings.iter().any(|warning| warning.code() == "representative_misaligned");
    assert!(warned(&found));
    piece.directions[0] = vec![0.0, 1.0, 0.0];
    assert!(warned(&fit(&second, &FitSpec { regularization: by(piece), ..plain })));
}

#[track_caller]
fn refused(nodes: &Nodes, spec: &FitSpec, message: &str) {
    match estimation::fit(nodes, spec) {
        Err(FitError::Invalid(faults)) => assert!(faults.to_string().starts_with(message), "{faults}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_piece_has_to_be_of_the_model() {
    let random = &mut Random::new(9);
    let x: Vec<f64> = (0..15).map(|k| 1.0 + f64::from(k) / 14.0).collect();
    let (first, second) = (nodes(&x, random), nodes(&x, random));
    let include = Include { representative: true, ..Include::default() };
    let legendre =
        Model::Polynomial { degree: Degree::Both(3), basis: PolynomialBasis::Legendre, terms: Terms::Tensor };
    let of = |model: Model| {
        let regularization = own(Scheme::FirstOrder, 2, Parameter::Fixed(1.5));
        piece(&fit(&first, &FitSpec { regularization, include, ..FitSpec::new(model) }))
    };
    let with = |change: &dyn Fn(&mut Piece)| {
        let mut piece = of(powers(3));
        change(&mut piece);
        FitSpec { regularization: by(piece), ..FitSpec::new(powers(3)) }
    };
    fit(&second, &with(&|_| {}));
    let none = Representative { of: PieceOf { iteration: Some(3), fit_id: None }, piece: None };
    let spec = FitSpec { regularization: Regularization::Representative(none), ..FitSpec::new(powers(3)) };
    refused(&second, &spec, "regularization.iteration: only a fit in a job has iterations");
    let spec = FitSpec { scaling: Scaling::Standardized, ..with(&|_| {}) };
    refused(&second, &spec, "scaling: a representative piece needs columns that are not standardised");
    refused(&second, &with(&|p| p.model = powers(4)), "regularization.piece.model: the piece has another model");
    // a mapped basis is another one on another domain, powers are the same
    fit(&second, &with(&|p| p.domain = None));
    let mut elsewhere = of(legendre.clone());
    elsewhere.domain.as_mut().unwrap().u = Some([1.0, 2.5]);
    let spec = FitSpec { regularization: by(elsewhere), ..FitSpec::new(legendre) };
    refused(&second, &spec, "regularization.piece.domain: the piece has another domain");
    refused(&second, &with(&|p| p.scale.truncate(3)), "regularization.piece.scale: 3 entries; there are 4");
    refused(&second, &with(&|p| p.directions.truncate(1)), "regularization.piece.directions: 1 entry; there are 2");
    refused(
        &second,
        &with(&|p| p.directions[1].push(0.0)),
        "regularization.piece.directions[1]: 5 entries; there are 4",
    );
    let empty = with(&|p| (p.directions, p.eigenvalues) = (vec![], vec![]));
    refused(&second, &empty, "regularization.piece.eigenvalues: from 1 to 4 eigenvalues");
    refused(&second, &with(&|p| p.eigenvalues[1] = 0.0), "regularization.piece.eigenvalues[1]: 0 is not greater");
    refused(&second, &with(&|p| p.scale[2] = -1.0), "regularization.piece.scale[2]: -1 is not greater");
    refused(&second, &with(&|p| p.lambda_star = 0.0), "regularization.piece.lambda_star: 0 is not greater");
    let longer = with(&|p| p.directions[0][0] += 0.1);
    refused(&second, &longer, "regularization.piece.directions[0]: directions are orthonormal");
    // what gives nothing says so
    let ridge = Regularization::Ridge { parameter: Parameter::Fixed(1.0) };
    let found = fit(&first, &FitSpec { regularization: ridge, include, ..FitSpec::new(powers(3)) });
    assert!(found.representative.is_none());
    assert!(found.warnings.iter().any(|warning| warning.code() == "no_representative"));
}
