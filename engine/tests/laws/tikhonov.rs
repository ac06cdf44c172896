//! Tikhonov: the solution of (XᵀX + λP) A = XᵀY with P integrated by the power rule, and every
//! figure by its definition.

use crate::oracle::big::Big;
use crate::oracle::design::{Basis, functions, surface};
use crate::oracle::matrix::{Rows, column, dot, doubles, gram, inverse, rows, times, vector};
use crate::oracle::random::Random;
use crate::penalised::{check, check_curve, plus, roughness};
use crate::problems::{
    Problem, Surface, assert_all_close, assert_close, by, config, fit, linear, matrix, polynomial, values, warned,
};
use flankfit_engine::estimation::spec::{
    Criterion, Degree, Domain, FitSpec, Knots, Model, Parameter, PolynomialBasis, Regularization, Scaling, Terms,
    Tikhonov,
};
use flankfit_engine::estimation::{FitError, Nodes, fit as try_fit};
use proptest::prelude::*;

fn tikhonov(order: usize, weights: &[f64], parameter: Parameter) -> Regularization {
    Regularization::Tikhonov(Tikhonov { order, weights: Some(weights.to_vec()), parameter })
}

/// Heights of a line plus a part orthogonal to all columns: shrinking the penalised coefficients
/// costs nothing, so every criterion falls without end, or rises to the end of its range. With a
/// cubic term in the heights each criterion has a minimum.
#[test]
fn a_criterion_without_a_minimum_is_reported() {
    let places: Vec<f64> = (-6..=6).map(f64::from).collect();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    // the part of x⁵ orthogonal to polynomials of degree 3, by Gram–Schmidt
    let mut rest: Vec<f64> = places.iter().map(|x| x.powi(5)).collect();
    let mut known: Vec<Vec<f64>> = Vec::new();
    for degree in 0..4 {
        let mut column: Vec<f64> = places.iter().map(|x| x.powi(degree)).collect();
        for _ in 0..2 {
            for other in &known {
                let share = product(&column, other) / product(other, other);
                column.iter_mut().zip(other).for_each(|(x, y)| *x -= share * y);
            }
        }
        known.push(column);
    }
    for _ in 0..3 {
        for column in &known {
            let share = product(&rest, column) / product(column, column);
            rest.iter_mut().zip(column).for_each(|(x, y)| *x -= share * y);
        }
    }
    let size = product(&rest, &rest).sqrt();
    let heights = |cube: f64| -> Vec<f64> {
        places.iter().zip(&rest).map(|(x, r)| 1.0 + 2.0 * x + cube * x.powi(3) + r / size).collect()
    };
    for criterion in [Criterion::Gcv, Criterion::Reml, Criterion::Press, Criterion::MinMse] {
        for (cube, limit) in [(0.0, true), (0.02, false)] {
            let nodes = Nodes::curve(places.clone(), heights(cube), None).unwrap();
            let mut spec = polynomial(Degree::Both(3), PolynomialBasis::Legendre);
            spec.regularization = tikhonov(2, &[1.0], Parameter::Criterion(criterion));
            let result = fit(&nodes, &spec);
            // PRESS has no minimum in between for these nodes: it falls towards either end
            let limit = limit || criterion == Criterion::Press;
            assert_eq!(warned(&result, "lambda_at_limit"), limit, "{}, {cube}", criterion.name());
            let spec = FitSpec { regularization: tikhonov(2, &[1.0], Parameter::Fixed(1.0)), ..spec };
            assert!(!warned(&fit(&nodes, &spec), "lambda_at_limit"));
        }
    }
}

proptest! {
    #![proptest_config(config(24))]

    /// Raw monomials far from 0, whose columns are nearly parallel.
    #[test]
    fn surfaces_in_monomials(
        seed: u64, order in 0usize..4, p in 1usize..4, q in 0usize..4, unit: bool, wu in 0.01f64..10.0,
        wv in 0.0f64..10.0,
        log in -8.0f64..4.0, wide: bool,
    ) {
        prop_assume!(order <= p);
        let surface_of = Surface::new(seed, [2, 2], 0.3, 1e-3);
        let (u, v) = if wide { ([29.0, 36.0], [-1.0, 20.5]) } else { ([30.0, 34.0], [0.0, 20.0]) };
        let terms: Vec<[usize; 2]> = (0..=p).flat_map(|i| (0..=q).map(move |j| [i, j])).collect();
        let x = surface([Basis::Monomial, Basis::Monomial], [p, q], &surface_of.nodes, |_, _| true);
        // the last crossing of the grid ends at 20/6·6, which is 20
        let penalty = roughness(&terms, order, [wu, wv], u, v);
        let mut spec = FitSpec {
            scaling: if unit { Scaling::UnitLength } else { Scaling::None },
            regularization: tikhonov(order, &[wu, wv], Parameter::Fixed(10f64.powf(log))),
            domain: Some(Domain { u: Some(u), v: Some(v) }),
            ..polynomial(Degree::Each(p, q), PolynomialBasis::Monomial)
        };
        let result = fit(&surface_of.scattered(), &spec);
        check(&result, &x, &surface_of.z, &penalty, unit, 1e-9);
        // a grid separates, and gives the same
        spec.include.lambda_curve = p * q < 5;
        let grid = fit(&surface_of.grid(), &spec);
        check(&grid, &x, &surface_of.z, &penalty, unit, 1e-9);
        if spec.include.lambda_curve {
            check_curve(&grid, &x, &surface_of.z, &penalty, unit);
        }
    }

    /// The function is penalised, so the basis makes no difference to it.
    #[test]
    fn the_basis_does_not_matter(seed: u64, order in 0usize..4, log in -6.0f64..2.0, total: bool) {
        let surface_of = Surface::new(seed, [3, 3], 0.3, 1e-3);
        let of = |basis| {
            let terms = if total { Terms::Total } else { Terms::Tensor };
            let mut spec = FitSpec::new(Model::Polynomial { degree: Degree::Both(3), basis, terms });
            spec.regularization = tikhonov(order, &[1.0, 3.0], Parameter::Fixed(10f64.powf(log)));
            spec.include.residuals = true;
            fit(&surface_of.scattered(), &spec)
        };
        let (one, two) = (of(PolynomialBasis::Monomial), of(PolynomialBasis::Legendre));
        let size = surface_of.z.iter().fold(0.0, |m: f64, z| m.max(z.abs()));
        for (a, b) in one.residuals.values.iter().flatten().zip(two.residuals.values.iter().flatten()) {
            assert_close("residual", *a, *b, 0.0, 1e-10 * size);
        }
        assert_all_close("factors", &one.regularization.filter_factors, &two.regularization.filter_factors, 1e-8);
    }

    /// Differences of neighbouring coefficients, of order 0 the ridge of unscaled columns.
    #[test]
    fn linear_models(seed: u64, n in 4usize..9, extra in 1usize..9, log_condition in 1.0f64..9.0, order in 0usize..4,
        unit: bool, log in -6.0f64..2.0) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let x = rows(&problem.x);
        let mut signs = vec![1.0];
        for _ in 0..order {
            let at = |i: usize| signs.get(i).copied().unwrap_or(0.0);
            signs = (0..=signs.len()).map(|i| if i > 0 { at(i - 1) } else { 0.0 } - at(i)).collect();
        }
        let differences: Rows = (0..n - order)
            .map(|row| {
                let at = |j: usize| j.checked_sub(row).and_then(|k| signs.get(k)).copied().unwrap_or(0.0);
                (0..n).map(|j| Big::from(at(j))).collect()
            })
            .collect();
        let weight = 2.5;
        let penalty: Rows = gram(&differences).iter().map(|r| r.iter()
            .map(|x| x * &Big::from(weight)).collect()).collect();
        let lambda = 10f64.powf(log);
        let mut spec = FitSpec {
            scaling: if unit { Scaling::UnitLength } else { Scaling::None },
            regularization: tikhonov(order, &[weight], Parameter::Fixed(lambda)),
            ..linear()
        };
        spec.include.lambda_curve = true;
        let result = fit(&problem.nodes(), &spec);
        check(&result, &x, &problem.y, &penalty, unit, 1e-8);
        check_curve(&result, &x, &problem.y, &penalty, unit);
        if order == 0 {
            let ridge = Regularization::Ridge { parameter: Parameter::Fixed(weight * lambda) };
            let ridge = fit(&problem.nodes(), &FitSpec { scaling: Scaling::None, regularization: ridge, ..linear() });
            let size = values(&ridge).iter().map(|a| a * a).sum::<f64>().sqrt();
            for (a, b) in values(&result).iter().zip(values(&ridge)) {
                assert_close("ridge", *a, b, 0.0, 1e-8 * size);
            }
            // and every criterion that ridge has chooses the same
            for theirs in ridge.regularization.choices.iter().filter(|_| !unit) {
                let Some(own) = result.regularization.choices.iter().find(|c| c.criterion == theirs.criterion) else {
                    continue;
                };
                assert_close("predicted mse", own.predicted_mse.unwrap(), theirs.predicted_mse.unwrap(), 1e-6, 0.0);
                assert_close("rms", own.rms, theirs.rms, 1e-5, 0.0);
            }
        }
    }
}

/// Nodes of a curve with a wave and noise.
fn wave(seed: u64, m: usize) -> (Vec<f64>, Vec<f64>) {
    let mut random = Random::new(seed);
    let x: Vec<f64> = (0..m).map(|i| 5.0 * i as f64 / (m - 1) as f64).collect();
    let y = x.iter().map(|x| (1.3 * x).sin() + 0.05 * random.normal()).collect();
    (x, y)
}

/// B-splines, whose derivatives are taken here by differences in the oracle's numbers at Gauss
/// points of each span.
#[test]
fn b_splines() {
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.5, 1.5, 3.0, 5.0, 5.0, 5.0, 5.0];
    let (x, y) = wave(4, 30);
    let design: Rows = x.iter().map(|x| functions(Basis::BSpline(&knots), 3, *x)).collect();
    let n = design[0].len();
    let gauss: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    for order in 0..=3usize {
        let h = 2f64.powi(-30);
        let derivative = |x: f64| -> Vec<f64> {
            // central differences of a cubic: exact for orders 2 and 3, and to h² for order 1
            let stencil: &[(f64, f64)] = match order {
                0 => &[(0.0, 1.0)],
                1 => &[(-1.0, -0.5), (1.0, 0.5)],
                2 => &[(-1.0, 1.0), (0.0, -2.0), (1.0, 1.0)],
                _ => &[(-2.0, -0.5), (-1.0, 1.0), (1.0, -1.0), (2.0, 0.5)],
            };
            let step = (0..order).fold(Big::one(), |p, _| &p * &Big::from(h));
            let mut sum = vec![Big::zero(); n];
            for (offset, weight) in stencil {
                for (s, f) in sum.iter_mut().zip(functions(Basis::BSpline(&knots), 3, x + offset * h)) {
                    *s = &*s + &(&f * &Big::from(*weight));
                }
            }
            sum.iter().map(|s| (s / &step).to_f64()).collect()
        };
        let mut penalty: Rows = vec![vec![Big::zero(); n]; n];
        for span in knots.windows(2).filter(|pair| pair[0] < pair[1]) {
            for (place, weight) in gauss {
                // representable offsets, so that differences are taken where they are meant to be
                let at = (0.5 * (span[0] + span[1]) + 0.5 * (span[1] - span[0]) * place) as f32;
                let d = derivative(f64::from(at));
                let weight = 0.5 * (span[1] - span[0]) * weight;
                for (i, row) in penalty.iter_mut().enumerate() {
                    for (j, entry) in row.iter_mut().enumerate() {
                        *entry = &*entry + &Big::from(weight * d[i] * d[j]);
                    }
                }
            }
        }
        let nodes = Nodes::curve(x.clone(), y.clone(), None).expect("checked nodes");
        for lambda in [1e-4, 0.1, 30.0] {
            let spec = FitSpec {
                regularization: tikhonov(order, &[1.0], Parameter::Fixed(lambda)),
                ..FitSpec::new(Model::BSpline {
                    degree: Degree::Both(3),
                    knots: Knots::Curve(knots.to_vec()),
                    weights: None,
                })
            };
            let result = fit(&nodes, &spec);
            let moments: Vec<Big> = (0..n).map(|j| dot(&column(&design, j), &vector(&y))).collect();
            let exact = doubles(&times(&inverse(&plus(&gram(&design), &penalty, lambda)), &moments));
            for (value, exact) in values(&result).iter().zip(&exact) {
                // Gauss places were rounded to single precision above
                assert_close("coefficient", *value, *exact, 1e-5, 1e-6);
            }
            let free = result.regularization.filter_factors.iter().filter(|f| **f == 1.0).count();
            // a double knot leaves second derivatives continuous in pieces only; order 3 sees none
            // of the jumps
            assert!(free >= order, "order {order}: {free} directions are free");
        }
    }
}

/// One span is a polynomial: the same curve and the same λ by every criterion.
#[test]
fn a_single_span_is_a_polynomial() {
    let (x, y) = wave(8, 25);
    let nodes = Nodes::curve(x, y, None).expect("checked nodes");
    for criterion in [Criterion::Gcv, Criterion::Discrepancy, Criterion::LCurve] {
        let regularization = tikhonov(2, &[1.0], by(criterion));
        let spline = Model::BSpline { degree: Degree::Both(5), knots: Knots::Spans(1), weights: None };
        let one = fit(&nodes, &FitSpec { regularization: regularization.clone(), ..FitSpec::new(spline) });
        let basis = PolynomialBasis::Chebyshev;
        let two = fit(&nodes, &FitSpec { regularization, ..polynomial(Degree::Both(5), basis) });
        let (a, b) = (one.regularization.lambda_star.unwrap(), two.regularization.lambda_star.unwrap());
        assert_close(criterion.name(), a, b, 1e-5, 0.0);
        assert_close("rss", one.residuals.rss, two.residuals.rss, 1e-6, 0.0);
    }
}

/// Straight lines have no second derivative: a heavy penalty leaves the line of least squares.
#[test]
fn a_heavy_penalty_leaves_the_unpenalised_part() {
    let (x, y) = wave(2, 20);
    let nodes = Nodes::curve(x, y, None).expect("checked nodes");
    for scaling in [Scaling::UnitLength, Scaling::None, Scaling::Standardized] {
        let spec = FitSpec {
            scaling,
            regularization: tikhonov(2, &[1.0], Parameter::Fixed(1e14)),
            ..polynomial(Degree::Both(5), PolynomialBasis::Legendre)
        };
        let heavy = fit(&nodes, &spec);
        let line =
            FitSpec { regularization: Regularization::None, ..polynomial(Degree::Both(1), PolynomialBasis::Legendre) };
        let line = fit(&nodes, &line);
        for (a, b) in values(&heavy).iter().zip(values(&line)) {
            assert_close("line", *a, b, 1e-9, 1e-12);
        }
        let factors = &heavy.regularization.filter_factors;
        let constant = usize::from(scaling == Scaling::Standardized);
        assert_eq!(factors.len(), 6 - constant);
        assert_eq!(factors.iter().filter(|f| **f == 1.0).count(), 2 - constant);
        let plain = fit(&nodes, &FitSpec { scaling: Scaling::UnitLength, ..spec });
        for (a, b) in heavy.coefficients.iter().zip(&plain.coefficients) {
            assert_close("standard error", a.error_given_lambda().unwrap(), b.error_given_lambda().unwrap(), 1e-8, 0.0);
        }
    }
}

/// Knots without nodes: least squares is not unique, the penalised curve is.
#[test]
fn gaps_are_bridged() {
    let x: Vec<f64> = (0..24).map(|i| f64::from(i) * 0.1 + if i >= 12 { 6.0 } else { 0.0 }).collect();
    let y: Vec<f64> = x.iter().map(|x| 2.0 - 0.5 * x).collect();
    let nodes = Nodes::curve(x, y, None).expect("checked nodes");
    let model = Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(12), weights: None };
    let of = |order, parameter| FitSpec {
        regularization: tikhonov(order, &[1.0], parameter),
        noise_sigma: Some(0.01),
        ..FitSpec::new(model.clone())
    };
    let result = fit(&nodes, &of(2, Parameter::Fixed(1e-3)));
    assert!(warned(&result, "rank_deficient"));
    // a line costs nothing and fits: it is the answer, in the gap as well
    assert!(result.residuals.rss < 1e-18, "{:e}", result.residuals.rss);
    let silent = 15 - result.spectrum.rank;
    assert!(silent > 0);
    assert_eq!(result.regularization.filter_factors.iter().filter(|f| **f == 0.0).count(), silent);
    let slopes: Vec<f64> = values(&result).windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step = slopes[7];
    assert!(slopes[3..11].iter().all(|s| (s - step).abs() < 1e-9), "{slopes:?}");
    assert!(result.spectrum.regularized.condition.is_some());
    for criterion in Criterion::ALL {
        let result = fit(&nodes, &of(2, by(criterion)));
        assert!(result.regularization.lambda_star.is_some(), "{criterion:?}");
        assert_eq!(result.regularization.filter_factors.len(), 15);
    }
}

#[test]
fn invalid_penalties_are_refused() {
    let (x, y) = wave(2, 20);
    let nodes = Nodes::curve(x, y, None).expect("checked nodes");
    let field = |nodes: &Nodes, spec: FitSpec| match try_fit(nodes, &spec) {
        Err(FitError::Invalid(faults)) => faults.list()[0].path.clone(),
        other => panic!("{other:?}"),
    };
    let of = |degree, order, weights: &[f64], scaling| FitSpec {
        scaling,
        regularization: tikhonov(order, weights, by(Criterion::Gcv)),
        ..polynomial(Degree::Both(degree), PolynomialBasis::Chebyshev)
    };
    let unit = Scaling::UnitLength;
    assert_eq!(field(&nodes, of(2, 3, &[1.0], unit)), "regularization.order");
    assert_eq!(field(&nodes, of(4, 4, &[1.0], unit)), "regularization.order");
    assert_eq!(field(&nodes, of(4, 0, &[1.0], Scaling::Standardized)), "regularization.order");
    assert_eq!(field(&nodes, of(4, 2, &[1.0, 1.0], unit)), "regularization.weights");
    assert_eq!(field(&nodes, of(4, 2, &[0.0], unit)), "regularization.weights");
    assert_eq!(field(&nodes, of(4, 2, &[-1.0], unit)), "regularization.weights[0]");
    let problem = Problem::graded(3, 3, 5, 2.0);
    let spec = FitSpec { regularization: tikhonov(3, &[1.0], by(Criterion::Gcv)), ..linear() };
    assert_eq!(field(&problem.nodes(), spec), "regularization.order");
    // order 2 does not see the line that equal columns leave free
    let x: Vec<Vec<f64>> = (0..8).map(|i| vec![f64::from(i), f64::from(i), f64::from(i)]).collect();
    let y: Vec<f64> = (0..8).map(f64::from).collect();
    let spec = FitSpec { regularization: tikhonov(2, &[1.0], Parameter::Fixed(1.0)), ..linear() };
    assert_eq!(field(&matrix(&x, &y, None), spec), "regularization.order");
}
