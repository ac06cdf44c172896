//! Constraints on the shape: that they hold everywhere, that nothing better does, and what is said
//! of errors.

use crate::{
    oracle::random::Random,
    problems::{config, fit},
};
use flankfit_engine::estimation::{
    self, FitError, FitResult, Nodes,
    result::IntervalKind,
    spec::{
        Constraint, ConstraintKind, Criterion, Degree, Domain, Estimator, FilterAxis, FitSpec, Include, Kinds, Knots,
        Model, Parameter, Places, PolynomialBasis, Predict, Prior, PriorSpread, Regularization, Scaling, Terms,
    },
};
use proptest::prelude::*;

const KINDS: [ConstraintKind; 4] =
    [ConstraintKind::Increasing, ConstraintKind::Decreasing, ConstraintKind::Convex, ConstraintKind::Concave];

fn chebyshev(degree: Degree) -> Model {
    Model::Polynomial { degree, basis: PolynomialBasis::Chebyshev, terms: Terms::Tensor }
}

fn splines(degree: usize, spans: usize) -> Model {
    Model::BSpline { degree: Degree::Both(degree), knots: Knots::Spans(spans), weights: None }
}

fn just(kind: ConstraintKind) -> Constraint {
    Constraint { kind, along: None, domain: None }
}

fn spec(model: Model, constraints: Vec<Constraint>) -> FitSpec {
    FitSpec { regularization: Regularization::None, constraints, ..FitSpec::new(model) }
}

fn curve(random: &mut Random, count: usize, shape: impl Fn(f64) -> f64, noise: f64) -> Nodes {
    let x: Vec<f64> = (0..count).map(|k| k as f64 / (count - 1) as f64).collect();
    let y = x.iter().map(|&x| shape(x) + noise * random.normal()).collect();
    Nodes::curve(x, y, None).unwrap()
}

/// Values and slopes of a fit at many places of [0, 1] or of its square.
fn at(nodes: &Nodes, spec: &FitSpec, places: Places) -> (Vec<f64>, Vec<Vec<f64>>) {
    let kinds = Kinds { confidence: false, prediction: false, simultaneous: false };
    let predict = Some(Predict { at: places, level: None, kinds, slopes: true });
    let found = fit(nodes, &FitSpec { predict, ..spec.clone() }).predictions.unwrap();
    (found.value, [found.slope_u, found.slope_v].into_iter().flatten().map(|slopes| slopes.value).collect())
}

fn dense(count: usize) -> Vec<f64> {
    (0..=count).map(|k| k as f64 / count as f64).collect()
}

fn certified(found: &FitResult) {
    let report = found.constraints.as_ref().unwrap();
    assert!(report.constraints.iter().all(|one| one.least_value >= 0.0), "{report:?}");
    assert!(report.rss_bound <= report.rss, "{report:?}");
    assert!(report.rss - report.rss_bound <= 1e-6 * report.rss.max(found.residuals.least_squares_rss), "{report:?}");
    assert!((report.rss - found.residuals.rss).abs() <= 1e-9 * report.rss, "{report:?} {}", found.residuals.rss);
    assert!(report.stationarity < 1e-6 && report.rss >= found.residuals.least_squares_rss * (1.0 - 1e-12));
    for one in &report.constraints {
        assert!(one.active.iter().all(|place| place.multiplier > 0.0), "{report:?}");
    }
    // least squares that meets all of them needs no holding back, any other does
    let met = report.constraints.iter().all(|one| one.least_squares_least_value >= 0.0);
    assert_eq!(report.holds_back(), !met, "{report:?}");
}

proptest! {
    #![proptest_config(config(24))]

    /// Slopes are looked at directly, bends by differences of slopes.
    #[test]
    fn curves_meet_their_constraints_everywhere(
        seed in 0u64..1000, kind in 0usize..4, degree in 2usize..9, spans in 0usize..7,
    ) {
        let random = &mut Random::new(seed);
        let wave = random.between(0.0, 6.0);
        let nodes = curve(random, 40, |x| (wave * x).sin() + x, 0.5);
        let model = if spans == 0 { chebyshev(Degree::Both(degree)) } else { splines(degree.min(4), spans) };
        let spec = spec(model, vec![just(KINDS[kind])]);
        certified(&fit(&nodes, &spec));
        let (_, slopes) = at(&nodes, &spec, Places::Curve(dense(3000)));
        let size = slopes[0].iter().fold(0.0, |most: f64, slope| most.max(slope.abs()));
        let (sign, rounding) = (KINDS[kind].sign(), 1e-13 * size);
        match KINDS[kind].order() {
            1 => prop_assert!(slopes[0].iter().all(|slope| sign * slope >= -rounding)),
            _ => prop_assert!(slopes[0].windows(2).all(|pair| sign * (pair[1] - pair[0]) >= -rounding)),
        }
    }

    #[test]
    fn surfaces_meet_their_constraints_everywhere(
        seed in 0u64..1000, kind in 0usize..4, spline in any::<bool>(), v in any::<bool>(),
    ) {
        let random = &mut Random::new(seed);
        let height = |k: i32| (f64::from(k / 11) * 0.3).sin() + 0.01 * f64::from(k % 11);
        let z = (0..99).map(|k| height(k) + 0.4 * random.normal()).collect();
        let nodes = Nodes::grid(dense(8), dense(10), z, None, None).unwrap();
        let model = if spline { splines(3, 2) } else { chebyshev(Degree::Each(4, 3)) };
        let along = Some(if v { FilterAxis::V } else { FilterAxis::U });
        let spec = spec(model, vec![Constraint { kind: KINDS[kind], along, domain: None }]);
        certified(&fit(&nodes, &spec));
        let line = dense(120);
        let (_, slopes) = at(&nodes, &spec, Places::Grid { u: line.clone(), v: line });
        let slopes = &slopes[usize::from(v)];
        let size = slopes.iter().fold(0.0, |most: f64, slope| most.max(slope.abs()));
        let (sign, rounding) = (KINDS[kind].sign(), 1e-12 * size);
        let step = if v { 1 } else { 121 };
        for k in 0..121 * 121 {
            match KINDS[kind].order() {
                1 => prop_assert!(sign * slopes[k] >= -rounding),
                _ if (if v { k % 121 } else { k / 121 }) < 120 => {
                    prop_assert!(sign * (slopes[k + step] - slopes[k]) >= -rounding, "{k}")
                }
                _ => {}
            }
        }
    }

    /// If the truth meets the constraints, the constrained estimate is nearer to it at the nodes
    /// than least squares is: for every draw, not on average.
    #[test]
    fn no_draw_is_further_from_a_truth_that_meets_them(seed in 0u64..1000, power in 1i32..4) {
        let random = &mut Random::new(seed);
        let truth = |x: f64| 0.3 * x.powi(power);
        let nodes = curve(random, 30, truth, 0.5);
        let plain = spec(chebyshev(Degree::Both(5)), vec![]);
        let kinds = [ConstraintKind::Increasing, ConstraintKind::Convex];
        let held = spec(chebyshev(Degree::Both(5)), kinds.map(just).to_vec());
        let far = |spec: &FitSpec| {
            let (heights, _) = at(&nodes, spec, Places::Curve((0..30).map(|k| f64::from(k) / 29.0).collect()));
            heights.iter().enumerate().map(|(k, h)| (h - truth(k as f64 / 29.0)).powi(2)).sum::<f64>()
        };
        prop_assert!(far(&held) <= far(&plain) * (1.0 + 1e-7));
    }

    #[test]
    fn signs_and_units_change_nothing(seed in 0u64..1000) {
        let random = &mut Random::new(seed);
        let y: Vec<f64> = (0..30).map(|k| (f64::from(k) / 5.0).cos() + 0.3 * random.normal()).collect();
        let x: Vec<f64> = (0..30).map(f64::from).collect();
        let values = |unit: f64, size: f64, kind: ConstraintKind| {
            let x: Vec<f64> = x.iter().map(|x| x * unit).collect();
            let nodes = Nodes::curve(x.clone(), y.iter().map(|y| y * size).collect(), None).unwrap();
            let (values, _) = at(&nodes, &spec(chebyshev(Degree::Both(6)), vec![just(kind)]), Places::Curve(x));
            values.iter().map(|value| value / size).collect::<Vec<f64>>()
        };
        let usual = values(1.0, 1.0, ConstraintKind::Decreasing);
        for other in [values(1e-3, 1e3, ConstraintKind::Decreasing), values(25.4, -2.0, ConstraintKind::Increasing)] {
            prop_assert!(usual.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-6), "{usual:?} {other:?}");
        }
    }
}

#[test]
fn inactive_constraints_leave_least_squares_unchanged() {
    let nodes = curve(&mut Random::new(3), 30, |x| x + x * x, 0.01);
    for scaling in [Scaling::UnitLength, Scaling::None, Scaling::Standardized] {
        let plain = FitSpec { scaling, ..spec(chebyshev(Degree::Both(2)), vec![]) };
        let kinds = [ConstraintKind::Increasing, ConstraintKind::Convex];
        let held = FitSpec { constraints: kinds.map(just).to_vec(), ..plain.clone() };
        let (plain, held) = (fit(&nodes, &plain), fit(&nodes, &held));
        certified(&held);
        for (a, b) in plain.coefficients.iter().zip(&held.coefficients) {
            assert_eq!((a.value, &a.interval), (b.value, &b.interval));
            assert!((a.std_error.unwrap() / b.std_error.unwrap() - 1.0).abs() < 1e-12);
        }
        assert_eq!(held.warnings, plain.warnings);
        assert_eq!(held.coefficients[0].interval.unwrap().kind, IntervalKind::Student);
    }
}

/// With slopes allowed down to −ε everywhere, Σ w r² falls by ε Σ multiplier: adding ε x to the
/// heights has the same effect.
#[test]
fn multipliers_are_the_cost_of_the_constraints() {
    let rss = |tilt: f64| {
        let nodes = curve(&mut Random::new(11), 30, |x| (5.0 * x).sin() + tilt * x, 0.2);
        fit(&nodes, &spec(chebyshev(Degree::Both(6)), vec![just(ConstraintKind::Increasing)])).constraints.unwrap()
    };
    let report = rss(0.0);
    let total: f64 = report.constraints[0].active.iter().map(|place| place.multiplier).sum();
    let fall = (rss(-1e-4).rss - rss(1e-4).rss) / 2e-4;
    assert!((fall / total - 1.0).abs() < 1e-4, "{fall} {total}");
}

/// With the active places held, the estimate is one of least squares: of a straight line through a
/// mean, where a tilt is not allowed.
#[test]
fn errors_are_those_with_the_active_places_held() {
    let y = vec![5.0, 3.5, 4.0, 2.5, 2.0, 1.0];
    let nodes = Nodes::curve((0..6).map(f64::from).collect(), y, None).unwrap();
    let model = Model::Polynomial { degree: Degree::Both(1), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
    let include = Include { covariance: true, ..Include::default() };
    let found = fit(&nodes, &FitSpec { include, ..spec(model, vec![just(ConstraintKind::Increasing)]) });
    let [level, slope] = &found.coefficients[..] else { panic!() };
    assert!((level.value - 3.0).abs() < 1e-7 && (0.0..1e-7).contains(&slope.value), "{level:?} {slope:?}");
    let sigma = found.residuals.sigma.unwrap();
    assert!((level.std_error.unwrap() - sigma / 6f64.sqrt()).abs() < 1e-12);
    assert!(slope.std_error.unwrap() < 1e-12 * sigma);
    assert_eq!(slope.interval.unwrap().kind, IntervalKind::LeastSquares);
    // σ̂ is that of least squares, and what bounds the bias knows no more of the truth
    assert!((slope.bias_bound - slope.least_squares_std_error.unwrap() * 2f64.sqrt()).abs() < 1e-12);
    let codes: Vec<_> = found.warnings.iter().map(|warning| warning.code()).collect();
    assert_eq!(codes, ["constraints_active"]);
    assert_eq!(found.regularization.filter_factors, [0.0, 1.0]);
    assert_eq!(found.constraints.unwrap().constraints[0].active.len(), 1);
}

/// A truth on the edge of what is allowed (a level), at which naive intervals fail most: the
/// returned ones hold, and the constrained estimate lies nearer in the mean by half.
#[test]
fn intervals_hold_where_the_constraint_binds() {
    let (draws, mut random) = (400, Random::new(5));
    let (mut hits, mut naive, mut count) = (0u32, 0u32, 0u32);
    let (mut error, mut plain_error) = (0.0, 0.0);
    for _ in 0..draws {
        let nodes = curve(&mut random, 25, |_| 1.0, 0.2);
        let found = fit(&nodes, &spec(chebyshev(Degree::Both(3)), vec![just(ConstraintKind::Increasing)]));
        for (j, c) in found.coefficients.iter().enumerate() {
            let truth = f64::from(u8::from(j == 0));
            let [low, high] = c.interval.unwrap().ends;
            let inside = |middle: f64, half: f64| (middle - half..=middle + half).contains(&truth);
            hits += u32::from(low <= truth && truth <= high);
            let t = 0.5 * (high - low) / c.least_squares_std_error.unwrap();
            naive += u32::from(inside(c.value, t * c.std_error.unwrap()));
            count += 1;
            error += (c.value - truth).powi(2);
            plain_error += (c.least_squares - truth).powi(2);
        }
    }
    let (hits, naive) = (f64::from(hits) / f64::from(count), f64::from(naive) / f64::from(count));
    assert!((0.93..0.97).contains(&hits), "{hits}");
    assert!(naive < hits - 0.04, "{naive} {hits}");
    assert!(error < 0.5 * plain_error, "{error} {plain_error}");
}

/// A given limit of the norm shortens intervals as without constraints: they are about least
/// squares that nothing constrains, filtered.
#[test]
fn norm_limits_shorten_intervals_as_without_constraints() {
    let mut random = Random::new(9);
    let nodes = curve(&mut random, 25, |_| 0.0, 0.2);
    let limited =
        |constraints| FitSpec { coefficient_norm_limit: Some(0.5), ..spec(chebyshev(Degree::Both(3)), constraints) };
    let (free, held) = (fit(&nodes, &limited(vec![])), fit(&nodes, &limited(vec![just(ConstraintKind::Increasing)])));
    assert!(held.warnings.iter().any(|warning| warning.code() == "constraints_active"));
    for (free, held) in free.coefficients.iter().zip(&held.coefficients) {
        let (free, held) = (free.interval.unwrap(), held.interval.unwrap());
        assert_eq!((held.kind, held.ends), (IntervalKind::BiasAware, free.ends));
    }
}

/// A slope that the constraint holds at 0 is determined by it alone.
#[test]
fn active_constraints_leave_no_standard_error() {
    let nodes = curve(&mut Random::new(10), 25, |x| -x, 0.1);
    let found = fit(&nodes, &spec(chebyshev(Degree::Both(1)), vec![just(ConstraintKind::Increasing)]));
    let slope = &found.coefficients[1];
    assert!(slope.value.abs() < 1e-9 && slope.std_error.unwrap() < 1e-12, "{slope:?}");
    assert!(slope.least_squares_std_error.unwrap() > 0.01 && slope.interval.unwrap().ends[1] < -0.3, "{slope:?}");
}

#[track_caller]
fn refused(nodes: &Nodes, spec: &FitSpec, message: &str) {
    match estimation::fit(nodes, spec) {
        Err(FitError::Invalid(faults)) => assert!(faults.to_string().starts_with(message), "{faults}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn infeasible_or_unsupported_constraints_are_refused() {
    use ConstraintKind::*;
    let nodes = curve(&mut Random::new(2), 30, |x| -(x - 0.5).abs(), 0.05);
    let rising = || vec![just(Increasing)];
    let cubic = || chebyshev(Degree::Both(3));
    let plain = || spec(cubic(), rising());
    let within = |kind, low, high| Constraint { domain: Some(Domain { u: Some([low, high]), v: None }), ..just(kind) };
    let ridge = Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Gcv) };
    let prior = Prior::Given { mean: vec![0.0; 4], spread: PriorSpread::StdError(vec![1.0; 4]) };
    let of = |constraints| spec(cubic(), constraints);
    refused(
        &nodes,
        &FitSpec { regularization: ridge, ..plain() },
        "regularization: `constraints` exclude regularisation",
    );
    refused(
        &nodes,
        &FitSpec { estimator: Estimator::Rank, ..plain() },
        "estimator: `constraints` are for the estimator `least_squares`",
    );
    refused(
        &nodes,
        &FitSpec { prior: Some(prior), ..plain() },
        "constraints: `prior` and `constraints` exclude each other",
    );
    let opposite = "constraints[1]: this is the opposite of constraint 0";
    refused(&nodes, &of(vec![just(Increasing), just(Decreasing)]), opposite);
    let touching = vec![within(Convex, 0.0, 0.5), within(Concave, 0.5, 1.0)];
    refused(&nodes, &of(touching), opposite);
    let apart = vec![within(Increasing, 0.0, 0.4), within(Decreasing, 0.6, 1.0)];
    certified(&fit(&nodes, &of(apart.clone())));
    // rises, then falls, and is convex all the while
    let three = [apart, vec![just(Convex)]].concat();
    refused(&nodes, &of(three), "constraints: no function of the model meets all of these");
    let along = |axis| vec![Constraint { along: Some(axis), ..just(Increasing) }];
    refused(&nodes, &of(along(FilterAxis::V)), "constraints[0].along: a curve has no v");
    let range = |low, high| of(vec![within(Increasing, low, high)]);
    refused(&nodes, &range(0.5, 0.5), "constraints[0].domain.u: [0.5, 0.5] is not a range");
    let outside = "constraints[0].domain.u: [0.5, 1.5] extends outside the domain of the fit, [0, 1]";
    refused(&nodes, &range(0.5, 1.5), outside);
    let straight = spec(chebyshev(Degree::Both(1)), vec![just(Convex)]);
    refused(&nodes, &straight, "constraints[0]: the model has degree 1 along u: derivatives of order 2");
    let knots = vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0];
    let kinked = |kind| {
        let model = Model::BSpline { degree: Degree::Both(2), knots: Knots::Curve(knots.clone()), weights: None };
        spec(model, vec![just(kind)])
    };
    certified(&fit(&nodes, &kinked(Increasing)));
    refused(&nodes, &kinked(Convex), "constraints[0]: the knot 0.5 occurs 2 times");
    let weights = Some(vec![1.0, 2.0, 1.0, 1.0, 1.0]);
    let rational = Model::BSpline { degree: Degree::Both(2), knots: Knots::Curve(knots.clone()), weights };
    refused(&nodes, &spec(rational, rising()), "constraints: derivatives of NURBS");
    let matrix = Nodes::matrix(vec![1.0, 2.0, 4.0], 1, vec![1.0, 2.0, 3.0], None, None).unwrap();
    refused(&matrix, &spec(Model::Linear, rising()), "constraints: a measurement matrix is not a function");
    let grid = Nodes::grid(dense(4), dense(4), vec![0.0; 25], None, None).unwrap();
    refused(&grid, &plain(), "constraints[0].along: missing");
    let four = Nodes::curve(vec![0.0, 1.0, 2.0, 3.0], vec![3.0, 1.0, 2.0, 4.0], None).unwrap();
    refused(&four, &plain(), "noise_sigma: there are as many coefficients as nodes");
    certified(&fit(&four, &FitSpec { noise_sigma: Some(0.1), ..plain() }));
    let big = Nodes::grid(dense(24), dense(24), vec![0.0; 625], None, None).unwrap();
    let many = spec(splines(3, 18), along(FilterAxis::U));
    refused(&big, &many, "constraints: constraints are for at most 400 coefficients, this model has 441");
}
