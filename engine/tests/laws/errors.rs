//! Correlated errors and unequal variances: coverage by Monte Carlo, and what reduces to plain
//! fits.

use crate::{oracle::random::Random, problems::fit};
use flankfit_engine::estimation::{
    FitResult, FitSpec, Nodes,
    result::Warning,
    spec::{
        Along, Correlation, Degree, Errors, Kinds, Matern, Model, Places, PolynomialBasis, Predict, Regularization,
        Terms, Variance,
    },
};

fn spec(degree: usize) -> FitSpec {
    let model =
        Model::Polynomial { degree: Degree::Both(degree), basis: PolynomialBasis::Legendre, terms: Terms::Tensor };
    FitSpec { regularization: Regularization::None, ..FitSpec::new(model) }
}

fn correlated(correlation: Correlation, along: Along) -> FitSpec {
    FitSpec { errors: Some(Errors { correlation, along, lines: None }), ..spec(3) }
}

fn axis(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64).collect()
}

/// Intervals of all coefficients that hold 0, the truth, of so many fits.
fn coverage(draws: usize, mut of: impl FnMut() -> FitResult) -> f64 {
    let (mut hits, mut count) = (0, 0);
    for _ in 0..draws {
        for c in of().coefficients {
            let [low, high] = c.interval.unwrap().ends;
            hits += usize::from(low <= 0.0 && 0.0 <= high);
            count += 1;
        }
    }
    hits as f64 / count as f64
}

fn close(a: &FitResult, b: &FitResult, relative: f64) {
    for (a, b) in a.coefficients.iter().zip(&b.coefficients) {
        let ([la, ha], [lb, hb]) = (a.interval.unwrap().ends, b.interval.unwrap().ends);
        let numbers = [
            (a.value, b.value),
            (a.std_error.unwrap(), b.std_error.unwrap()),
            (a.least_squares, b.least_squares),
            (la, lb),
            (ha, hb),
        ];
        for (x, y) in numbers {
            assert!((x - y).abs() <= relative * (y.abs() + b.std_error.unwrap()), "{a:?} {b:?}");
        }
    }
    assert!((a.residuals.rms / b.residuals.rms - 1.0).abs() < relative);
    assert!((a.residuals.max_abs.unwrap() / b.residuals.max_abs.unwrap() - 1.0).abs() < relative);
    assert!((a.residuals.r_squared.unwrap() - b.residuals.r_squared.unwrap()).abs() < relative);
}

#[test]
fn white_parameters_are_a_plain_fit() {
    let mut random = Random::new(31);
    let weight: Vec<f64> = (0..48).map(|_| random.between(0.2, 3.0)).collect();
    let mut z = random.normals(48);
    z[17] = f64::NAN;
    let nodes = Nodes::grid(axis(6), axis(8), z, None, Some(weight)).unwrap();
    let white = [
        Correlation::Ar1 { rho: Some(0.0) },
        Correlation::Ar2 { phi: Some([0.0, 0.0]) },
        Correlation::Matern { parameters: Some(Matern { length: 1e-3, nugget: 0.0 }) },
    ];
    for regularization in [Regularization::None, Regularization::default()] {
        let plain = fit(&nodes, &FitSpec { regularization: regularization.clone(), ..spec(3) });
        for correlation in white {
            for along in [Along::U, Along::V] {
                let asked = FitSpec { regularization: regularization.clone(), ..correlated(correlation, along) };
                let found = fit(&nodes, &asked);
                close(&found, &plain, 1e-10);
                assert!((found.errors.unwrap().effective_count - 47.0).abs() < 1e-9);
            }
        }
    }
    let one = FitSpec { variance: Variance::Groups(vec![4; 48]), ..spec(3) };
    close(&fit(&nodes, &one), &fit(&nodes, &spec(3)), 1e-12);
    let places: Vec<f64> = axis(48).iter().map(|x| x + 1.0).collect();
    let curve = Nodes::curve(places, random.normals(48), None).unwrap();
    let flat = FitSpec { variance: Variance::Power { of: Along::U, exponent: Some(0.0) }, ..spec(3) };
    close(&fit(&curve, &flat), &fit(&curve, &spec(3)), 1e-12);
}

#[test]
fn residuals_come_back_in_heights() {
    let mut random = Random::new(32);
    let y = random.autoregression(30, 0.7);
    let nodes = Nodes::curve(axis(30), y.clone(), None).unwrap();
    let mut asked = correlated(Correlation::Ar1 { rho: Some(0.7) }, Along::Order);
    asked.include.residuals = true;
    asked.predict = Some(Predict { at: Places::Curve(axis(30)), level: None, kinds: Kinds::default(), slopes: false });
    let found = fit(&nodes, &asked);
    let heights = found.predictions.unwrap().value;
    let left = found.residuals.values.unwrap();
    for ((y, height), left) in y.iter().zip(&heights).zip(&left) {
        assert!((y - height - left).abs() < 1e-12);
    }
    let largest = left.iter().fold(0.0f64, |most, r| most.max(r.abs()));
    assert!((found.residuals.max_abs.unwrap() - largest).abs() < 1e-14);
    assert!(found.warnings.iter().all(|w| w.code() != "correlated_residuals"));
}

/// Lines may come in any order and direction: lines with different names are independent.
#[test]
fn lines_of_scattered_nodes_are_those_of_a_grid() {
    let mut random = Random::new(33);
    let z: Vec<f64> = (0..4).flat_map(|_| random.autoregression(12, 0.8)).collect();
    let grid = Nodes::grid(axis(4), axis(12), z.clone(), None, None).unwrap();
    // node j of every line in turn
    let turn: Vec<(usize, usize)> = (0..12).flat_map(|j| (0..4).map(move |i| (i, j))).collect();
    let u = turn.iter().map(|&(i, _)| i as f64).collect();
    let v = turn.iter().map(|&(_, j)| j as f64).collect();
    let mixed = turn.iter().map(|&(i, j)| z[12 * i + j]).collect();
    let scattered = Nodes::scattered(u, v, mixed, None).unwrap();
    let lines = Some(turn.iter().map(|&(i, _)| 10 - i as i64).collect());
    for correlation in [Correlation::Ar1 { rho: None }, Correlation::Matern { parameters: None }] {
        let on_grid = fit(&grid, &correlated(correlation, Along::V));
        let errors = Some(Errors { correlation, along: Along::Order, lines: lines.clone() });
        let apart = fit(&scattered, &FitSpec { errors, ..spec(3) });
        close(&apart, &on_grid, 1e-8);
    }
}

/// From 250 draws with four coefficients; a coverage is uncertain by 0.01.
#[test]
fn intervals_hold_for_correlated_errors() {
    let asked = correlated(Correlation::Ar1 { rho: None }, Along::Order);
    for (rho, least, most) in [(0.0, 0.93, 0.985), (0.5, 0.94, 0.99), (0.9, 0.93, 0.985)] {
        let mut random = Random::new(34);
        let held = coverage(250, || {
            let nodes = Nodes::curve(axis(60), random.autoregression(60, rho), None).unwrap();
            fit(&nodes, &asked)
        });
        assert!((least..most).contains(&held), "{rho}: {held}");
    }
    let mut random = Random::new(35);
    let plain = coverage(200, || fit(&Nodes::curve(axis(60), random.autoregression(60, 0.9), None).unwrap(), &spec(3)));
    assert!(plain < 0.5, "{plain}");
}

/// Errors that swing (autoregression of second order), and errors that are smooth over four steps
/// (Matérn's process with smoothness 3/2: white noise twice through the same decay). 150 draws with
/// four coefficients: a coverage is uncertain by 0.012.
#[test]
fn intervals_hold_for_swinging_and_for_smooth_errors() {
    let asked = correlated(Correlation::Ar2 { phi: None }, Along::Order);
    let mut random = Random::new(41);
    let swinging = coverage(150, || {
        let (mut now, mut before) = (0.0, 0.0);
        let all = (0..260).map(|_| {
            (now, before) = (1.1 * now - 0.5 * before + random.normal(), now);
            now
        });
        fit(&Nodes::curve(axis(60), all.skip(200).collect(), None).unwrap(), &asked)
    });
    assert!((0.93..0.999).contains(&swinging), "{swinging}");
    let asked = correlated(Correlation::Matern { parameters: None }, Along::Order);
    let mut random = Random::new(42);
    let (fine, decay) = (40, (-(3f64.sqrt()) / 160.0).exp());
    let smooth = coverage(150, || {
        let (mut once, mut twice) = (0.0, 0.0);
        let all = (0..100 * fine).map(|_| {
            once = decay * once + random.normal();
            twice = decay * twice + once;
            twice
        });
        let y = all.step_by(fine).skip(40).collect();
        fit(&Nodes::curve(axis(60), y, None).unwrap(), &asked)
    });
    assert!((0.92..0.999).contains(&smooth), "{smooth}");
}

/// Noise that is four times as great at one end as at the other.
#[test]
fn intervals_hold_for_unequal_variances() {
    let mut random = Random::new(36);
    let asked = FitSpec { variance: Variance::Hc3, ..spec(3) };
    let held = coverage(1000, || {
        let y = (0..60).map(|i| (1.0 + 3.0 * f64::from(i) / 59.0) * random.normal()).collect();
        fit(&Nodes::curve(axis(60), y, None).unwrap(), &asked)
    });
    assert!((0.935..0.97).contains(&held), "{held}");
    let groups: Vec<i64> = (0..60).map(|i| i / 30).collect();
    let asked = FitSpec { variance: Variance::Groups(groups), ..spec(3) };
    let held = coverage(500, || {
        let y = (0..60).map(|i| if i < 30 { 1.0 } else { 4.0 } * random.normal()).collect();
        fit(&Nodes::curve(axis(60), y, None).unwrap(), &asked)
    });
    assert!((0.925..0.97).contains(&held), "{held}");
}

#[test]
fn incompatible_options_are_refused() {
    let mut random = Random::new(37);
    let curve = Nodes::curve(axis(20), random.normals(20), None).unwrap();
    let grid = Nodes::grid(axis(4), axis(5), random.normals(20), None, None).unwrap();
    let refused = |nodes: &Nodes, spec: &FitSpec, message: &str| {
        let error = flankfit_engine::estimation::fit(nodes, spec).unwrap_err();
        let flankfit_engine::estimation::FitError::Invalid(faults) = error else { panic!("{error}") };
        assert!(faults.to_string().starts_with(message), "{faults}");
    };
    let ar1 = Correlation::Ar1 { rho: Some(0.5) };
    let matern = Correlation::Matern { parameters: None };
    refused(&grid, &correlated(matern, Along::Both), "errors.along: errors along both axes are autoregressions");
    let mut z = random.normals(20);
    z[3] = f64::NAN;
    let holed = Nodes::grid(axis(4), axis(5), z, None, None).unwrap();
    refused(&holed, &correlated(ar1, Along::Both), "errors.along: errors along both axes need every node");
    refused(&curve, &correlated(ar1, Along::V), "errors.along: only nodes of a grid lie on lines along v");
    let walk = Correlation::Ar1 { rho: Some(1.0) };
    refused(&curve, &correlated(walk, Along::Order), "errors.parameters.rho: 1 is not a correlation");
    let both = FitSpec { variance: Variance::Hc3, ..correlated(ar1, Along::Order) };
    refused(&curve, &both, "variance: either correlated errors or unequal variances");
    let specified = FitSpec { variance: Variance::Hc3, noise_sigma: Some(1.0), ..spec(3) };
    refused(&curve, &specified, "noise_sigma: variances are estimated from the residuals");
    let short = FitSpec { variance: Variance::Groups(vec![1]), ..spec(3) };
    refused(&curve, &short, "variance.groups: 1 entry, but there are 20 nodes");
    let at_zero = FitSpec { variance: Variance::Power { of: Along::U, exponent: None }, ..spec(3) };
    refused(&curve, &at_zero, "variance.power_of: a node lies at 0");
}

/// Heights that alternate, or rise where the model is level, are correlated outside the searched
/// range.
#[test]
fn correlations_at_the_bounds_of_the_search_are_warned_of() {
    let mut random = Random::new(40);
    let asked = spec(0);
    let estimated = Errors { correlation: Correlation::Ar1 { rho: None }, along: Along::Order, lines: None };
    let bound = |y: Vec<f64>| {
        let nodes = Nodes::curve(axis(y.len()), y, None).unwrap();
        let found = fit(&nodes, &FitSpec { errors: Some(estimated.clone()), ..asked.clone() });
        found
            .warnings
            .iter()
            .find_map(|w| if let Warning::CorrelationAtBound { correlation } = w { Some(*correlation) } else { None })
    };
    let turning = (0..60).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 } + 0.05 * random.normal()).collect();
    assert!(bound(turning).is_some_and(|at| (at + 0.6).abs() < 1e-12));
    // a rise that the model lacks, with next to no noise
    let rise = (0..400).map(|k| f64::from(k) / 200.0 + 1e-5 * random.normal()).collect();
    assert!(bound(rise).is_some_and(|at| (at - 0.998).abs() < 1e-12));
    for rho in [0.0, 0.5] {
        assert_eq!(bound(random.autoregression(200, rho)), None, "{rho}");
    }
}

/// With correlation and noise given nothing is estimated: as many coefficients as nodes suffice,
/// and a height at a node has the error of that node.
#[test]
fn known_errors_need_no_residuals() {
    let nodes = Nodes::curve(axis(3), vec![0.8, 1.5, 1.3], None).unwrap();
    let predict = Some(Predict { at: Places::Curve(axis(3)), level: None, kinds: Kinds::default(), slopes: false });
    let known = Correlation::Ar1 { rho: Some(0.5) };
    let errors = Some(Errors { correlation: known, along: Along::Order, lines: None });
    let asked = FitSpec { errors, noise_sigma: Some(0.2), predict, ..spec(2) };
    let found = fit(&nodes, &asked);
    let heights = found.predictions.unwrap();
    for (value, y) in heights.value.iter().zip([0.8, 1.5, 1.3]) {
        assert!((value - y).abs() < 1e-12, "{value} {y}");
    }
    assert!(heights.std_error.unwrap().iter().all(|error| (error - 0.2).abs() < 1e-12));
    let errors = found.errors.unwrap();
    assert_eq!((errors.durbin_watson, errors.ljung_box_lags), (None, 0));
    // without σ there is something to estimate, and nothing to do it from
    let error = flankfit_engine::estimation::fit(&nodes, &FitSpec { noise_sigma: None, ..asked }).unwrap_err();
    assert!(error.to_string().contains("too little to estimate"), "{error}");
}

/// White heights on lines of any number: d is 2, and p is below 0.05 in a twentieth of the draws.
#[test]
fn white_residuals_pass_the_whiteness_test_on_any_lines() {
    let mut random = Random::new(39);
    let asked = FitSpec {
        errors: Some(Errors { correlation: Correlation::Ar1 { rho: Some(0.0) }, along: Along::V, lines: None }),
        ..spec(0)
    };
    for (lines, nodes, lags) in [(40, 2, 1), (20, 5, 4), (1, 60, 10)] {
        let (mut rejected, mut mean) = (0, 0.0);
        for _ in 0..1000 {
            let grid = Nodes::grid(axis(lines), axis(nodes), random.normals(lines * nodes), None, None).unwrap();
            let found = fit(&grid, &asked).errors.unwrap();
            assert_eq!(found.ljung_box_lags, lags);
            let [plain, white] = found.ljung_box_p.unwrap();
            assert!((plain - white).abs() < 1e-9);
            rejected += usize::from(plain < 0.05);
            mean += found.durbin_watson.unwrap()[0] / 1000.0;
        }
        assert!((20..=90).contains(&rejected), "{lines} lines of {nodes}: {rejected} of 1000");
        assert!((1.9..=2.1).contains(&mean), "{lines} lines of {nodes}: {mean}");
    }
}

/// Estimates of correlations need neighbours, and those of powers places that differ.
#[test]
fn inestimable_error_parameters_are_refused() {
    let mut random = Random::new(38);
    let refused = |nodes: &Nodes, spec: &FitSpec| match flankfit_engine::estimation::fit(nodes, spec) {
        Err(flankfit_engine::estimation::FitError::Invalid(faults)) => {
            let fault = &faults.list()[0];
            (fault.path.clone(), fault.message.clone())
        }
        other => panic!("{other:?}"),
    };
    let check_refusal = |nodes: &Nodes, spec: &FitSpec, place: &str, begin: &str| {
        let (path, message) = refused(nodes, spec);
        assert!(path == place && message.starts_with(begin), "{path}: {message}");
    };
    let column = Nodes::grid(axis(30), vec![0.0], random.normals(30), None, None).unwrap();
    let line = |k: i64| if k < 4 { k / 2 } else { k };
    let lines: Vec<i64> = (0..30).map(line).collect();
    let (u, v) = (axis(30), vec![0.0; 30]);
    let scattered = Nodes::scattered(u, v, random.normals(30), None).unwrap();
    let model =
        Model::Polynomial { degree: Degree::Each(1, 0), basis: PolynomialBasis::Legendre, terms: Terms::Tensor };
    let of = |correlation: Correlation, along: Along, lines: Option<Vec<i64>>| FitSpec {
        model: model.clone(),
        ..FitSpec { errors: Some(Errors { correlation, along, lines }), ..spec(1) }
    };
    for correlation in
        [Correlation::Ar1 { rho: None }, Correlation::Ar2 { phi: None }, Correlation::Matern { parameters: None }]
    {
        check_refusal(&column, &of(correlation, Along::V, None), "errors.along", "every line has a single node, so");
        let named = of(correlation, Along::Order, Some(lines.clone()));
        let begin = "2 pairs of neighbours are on one line, fewer than 3, so";
        check_refusal(&scattered, &named, "errors.line", begin);
        assert!(fit(&column, &of(correlation, Along::U, None)).errors.is_some());
    }
    // lines of two nodes have one correlation, which is no two parameters
    let pairs = Nodes::grid(axis(15), axis(2), random.normals(30), None, None).unwrap();
    let threes: Vec<i64> = (0..30).map(|k| if k < 6 { k / 3 } else { k / 2 }).collect();
    for correlation in [Correlation::Ar2 { phi: None }, Correlation::Matern { parameters: None }] {
        check_refusal(&pairs, &of(correlation, Along::V, None), "errors.along", "no line has three nodes, so");
        let named = of(correlation, Along::Order, Some(threes.clone()));
        let begin = "2 nodes have two others before on the same line, fewer";
        check_refusal(&scattered, &named, "errors.line", begin);
        assert!(fit(&pairs, &of(correlation, Along::U, None)).errors.is_some());
    }
    assert!(fit(&pairs, &of(Correlation::Ar1 { rho: None }, Along::V, None)).errors.is_some());
    // pairs at several distances determine a length
    let spread: Vec<f64> = (0..30).map(|k| f64::from(k) + if k % 2 == 1 { 0.02 * f64::from(k) } else { 0.0 }).collect();
    let uneven = Nodes::scattered(spread, vec![0.0; 30], random.normals(30), None).unwrap();
    let twos = Some((0..30).map(|k| k / 2).collect());
    assert!(fit(&uneven, &of(Correlation::Matern { parameters: None }, Along::Order, twos)).errors.is_some());
    // given parameters need no neighbours
    let known = fit(&column, &of(Correlation::Ar1 { rho: Some(0.5) }, Along::V, None)).errors.unwrap();
    assert_eq!((known.durbin_watson, known.ljung_box_lags), (None, 0));
    // the same place but for rounding
    for level in [3.0, 7.7e-5, 1e12] {
        for place in [level, level * (1.0 + f64::EPSILON)] {
            let v = (0..30).map(|k| if k == 7 { place } else { level }).collect();
            let nodes = Nodes::scattered(axis(30), v, random.normals(30), None).unwrap();
            let asked =
                FitSpec { model: model.clone(), variance: Variance::Power { of: Along::V, exponent: None }, ..spec(1) };
            check_refusal(&nodes, &asked, "variance.power_of", "the coordinate is the same at every node");
        }
    }
}
