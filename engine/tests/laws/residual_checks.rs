//! The checks of residuals: how often they are false, and what they say where they are not.

use crate::{
    oracle::{checked::Checked, random::Random},
    problems::fit,
};
use flankfit_engine::estimation::{
    FitResult, FitSpec, Nodes, Plans, fit_remembering,
    inference::Doubts,
    result::{LargerErrors, MissingShape, ResidualWarning, Warning},
    spec::{
        Along, Correlation, Degree, Errors, Estimator, Loss, MEstimator, Model, PolynomialBasis, Regularization, Terms,
        Variance,
    },
};
use flankfit_engine::gear::evaluation::warning::TraceWarning;

fn spec(degree: Degree) -> FitSpec {
    FitSpec::new(Model::Polynomial { degree, basis: PolynomialBasis::Legendre, terms: Terms::Tensor })
}

fn axis(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64).collect()
}

fn warning(nodes: &Nodes, spec: &FitSpec) -> Option<(Along, f64, f64)> {
    checked(nodes, spec).iter().find_map(|warning| match warning {
        ResidualWarning::CorrelatedResiduals { along: Some(along), factor, p, .. } => Some((*along, *factor, *p)),
        _ => None,
    })
}

/// 1 in 100 for each direction, at whatever leverage: of 3 × 2,000 fits with five directions 100
/// are expected, more than 140 in one of 15,000 runs.
#[test]
fn white_noise_seldom_looks_correlated() {
    let mut random = Random::new(5);
    let mut false_alarms = 0;
    for _ in 0..2_000 {
        let flank = Nodes::grid(axis(5), axis(9), random.normals(45), None, None).unwrap();
        let short = Nodes::curve(axis(10), random.normals(10), None).unwrap();
        let mut z = random.normals(42);
        z[11] = f64::NAN;
        let gaps = Nodes::grid(axis(6), axis(7), z, None, None).unwrap();
        let cases = [(flank, Degree::Both(3)), (short, Degree::Both(3)), (gaps, Degree::Each(2, 3))];
        false_alarms += cases.iter().filter(|(nodes, degree)| warning(nodes, &spec(*degree)).is_some()).count();
    }
    assert!((64..=140).contains(&false_alarms), "{false_alarms}");
}

/// At ρ = 0.8 the standard errors of a cubic at 60 nodes are 3.28 times too small on average
/// (numpy: traces of the exact covariances).
#[test]
fn the_factor_corrects_standard_errors_on_average() {
    let mut random = Random::new(6);
    let mut factors = Vec::new();
    for _ in 0..200 {
        let nodes = Nodes::curve(axis(60), random.autoregression(60, 0.8), None).unwrap();
        factors.extend(warning(&nodes, &spec(Degree::Both(3))).map(|(along, factor, p)| {
            assert!(along == Along::Order && p < 1e-2);
            factor
        }));
    }
    assert!(factors.len() > 180, "{}", factors.len());
    factors.sort_by(f64::total_cmp);
    let median = factors[factors.len() / 2];
    assert!((2.6..4.0).contains(&median), "{median}");
}

#[test]
fn the_direction_is_that_of_the_lines() {
    let mut random = Random::new(7);
    let lines: Vec<Vec<f64>> = (0..12).map(|_| random.autoregression(30, 0.7)).collect();
    let rows = Nodes::grid(axis(12), axis(30), lines.concat(), None, None).unwrap();
    let turned = (0..30).flat_map(|j| lines.iter().map(move |line| line[j])).collect();
    let columns = Nodes::grid(axis(30), axis(12), turned, None, None).unwrap();
    let spec = spec(Degree::Both(2));
    let (along_v, along_u) = (warning(&rows, &spec).unwrap(), warning(&columns, &spec).unwrap());
    assert_eq!((along_v.0, along_u.0), (Along::V, Along::U));
    assert!((along_v.1 - along_u.1).abs() < 1e-6 && (along_v.2 / along_u.2 - 1.0).abs() < 1e-6);
}

/// The same grid in both ways that a fit can take: as axes, and row by row where a weight of 1 is
/// written out.
#[test]
fn both_ways_of_a_grid_say_the_same() {
    let mut random = Random::new(8);
    let z: Vec<f64> = (0..6).flat_map(|_| random.autoregression(20, 0.8)).collect();
    let plain = Nodes::grid(axis(6), axis(20), z.clone(), None, None).unwrap();
    let weighted = Nodes::grid(axis(6), axis(20), z, None, Some(vec![1.0; 120])).unwrap();
    let spec = spec(Degree::Both(2));
    let (a, b) = (warning(&plain, &spec).unwrap(), warning(&weighted, &spec).unwrap());
    assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-6 && (a.2 / b.2 - 1.0).abs() < 1e-6, "{a:?} {b:?}");
}

/// Rounding errors are smooth, but not taken for correlated noise.
#[test]
fn exact_heights_are_no_alarm() {
    let y = axis(40).iter().map(|x| 3.0 - 0.25 * x * x).collect();
    assert_eq!(warning(&Nodes::curve(axis(40), y, None).unwrap(), &spec(Degree::Both(2))), None);
}

/// Warnings of the checks of residuals.
fn checked(nodes: &Nodes, spec: &FitSpec) -> Vec<ResidualWarning> {
    let of_residuals = |warning| match warning {
        Warning::Residuals { warning } => Some(warning),
        _ => None,
    };
    fit(nodes, spec).warnings.into_iter().filter_map(of_residuals).collect()
}

/// Number of draws out of `draws` with a warning that `counts`.
fn count(draws: usize, seed: u64, mut warns: impl FnMut(&mut Random) -> bool) -> usize {
    let mut random = Random::new(seed);
    (0..draws).filter(|_| warns(&mut random)).count()
}

fn huber() -> Estimator {
    Estimator::M(MEstimator::new(Loss::HUBER))
}

/// All checks together warn in less than 0.06 of clean fits; of 1,000 at 0.05 more than 75 in one
/// of 3,000 runs. The table of docs/explanation/intervals.md has 5,000 fits of each design and
/// estimator.
#[test]
fn clean_fits_are_seldom_doubted() {
    let [a, _, c, _] = Checked::all();
    for design in [a, c] {
        let huber = FitSpec { estimator: huber(), ..design.spec.clone() };
        for (spec, draws) in [(&design.spec, 1000), (&huber, 400)] {
            let found = count(draws, 21, |random| !checked(&design.white(random).unwrap(), spec).is_empty());
            assert!(found * 1000 <= 75 * draws, "{}: {found} of {draws}", design.name);
        }
    }
}

/// Scattered nodes, and more of them than each is a site of its own.
#[test]
fn cells_of_nodes_are_seldom_doubted() {
    let mut places = Random::new(22);
    for (nodes, draws) in [(60, 600), (900, 400)] {
        let (u, v): (Vec<f64>, Vec<f64>) = (0..nodes).map(|_| (places.unit(), places.unit())).unzip();
        let spec = spec(Degree::Both(3));
        let clean = |random: &mut Random| Nodes::scattered(u.clone(), v.clone(), random.normals(nodes), None).unwrap();
        let found = count(draws, 23, |random| !checked(&clean(random), &spec).is_empty());
        assert!(found * 1000 <= 65 * draws, "{nodes}: {found}");
        let found = count(60, 24, |random| {
            let z = u.iter().map(|u| random.normal() * (0.5 + 2.0 * (u - 0.5).abs())).collect();
            let found = checked(&Nodes::scattered(u.clone(), v.clone(), z, None).unwrap(), &spec);
            found.iter().any(|w| {
                matches!(w, ResidualWarning::UnevenVariance { along: Along::U, larger: LargerErrors::Ends, .. })
            })
        });
        assert!(found >= if nodes == 60 { 3 } else { 58 }, "{nodes}: {found}");
    }
}

/// Standard errors hold back too little where they are warned of.
#[test]
fn departures_are_found() {
    let [a, b, c, _] = Checked::all();
    for (design, along_u, least) in [(&a, true, 0.72), (&a, false, 0.78), (&c, true, 0.52), (&c, false, 0.55)] {
        let found = count(500, 25, |random| {
            !checked(&design.correlated(random, 0.6, along_u).unwrap(), &design.spec).is_empty()
        });
        // three standard errors
        assert!(found as f64 / 500.0 > least - 0.06, "{} {along_u}: {found}", design.name);
    }
    for (design, least) in [(&a, 0.6), (&b, 0.95)] {
        let found = count(300, 26, |random| {
            let found = checked(&design.rough_borders(random, 3.5).unwrap(), &design.spec);
            found.iter().any(|w| matches!(w, ResidualWarning::UnevenVariance { factor, .. } if *factor > 1.2))
        });
        assert!(found as f64 / 300.0 > least - 0.08, "{}: {found}", design.name);
    }
    let robust = FitSpec { estimator: huber(), ..b.spec.clone() };
    let found = count(40, 26, |random| !checked(&b.rough_borders(random, 3.5).unwrap(), &robust).is_empty());
    assert!(found >= 24, "{found}");
    // the sandwich needs no warning
    let hc3 = FitSpec { variance: Variance::Hc3, ..b.spec.clone() };
    let found = checked(&b.rough_borders(&mut Random::new(27), 3.5).unwrap(), &hc3);
    assert!(found.iter().all(|warning| !matches!(warning, ResidualWarning::UnevenVariance { .. })));
    let found = count(60, 28, |random| !checked(&c.relieved(random, 15.0, 10.0).unwrap(), &c.spec).is_empty());
    assert_eq!(found, 60);
    let wrong = Some(Errors { correlation: Correlation::Ar1 { rho: None }, along: Along::U, lines: None });
    let wrong = FitSpec { errors: wrong, ..b.spec.clone() };
    let found = count(20, 29, |random| {
        let found = checked(&b.correlated(random, 0.6, false).unwrap(), &wrong);
        found.iter().any(|w| matches!(w, ResidualWarning::CorrelatedResiduals { along: Some(Along::V), .. }))
    });
    assert!(found >= 19, "{found}");
    let tukey = FitSpec { estimator: Estimator::M(MEstimator::new(Loss::TUKEY)), ..b.spec.clone() };
    let found = count(40, 30, |random| {
        let found = checked(&b.cornered(random).unwrap(), &tukey);
        found.iter().any(|w| matches!(w, ResidualWarning::ClusteredLowWeights { residual, .. } if residual.abs() > 2.0))
    });
    assert!(found >= 38, "{found}");
}

/// A cubic surface with a ripple of fourth degree, of an rms of 0.6 at the nodes.
#[test]
fn the_shape_that_a_model_lacks_is_measured() {
    let mut random = Random::new(31);
    let axis: Vec<f64> = (0..15).map(|i| f64::from(i) / 7.0 - 1.0).collect();
    let ripple = |u: f64| (35.0 * u.powi(4) - 30.0 * u.powi(2) + 3.0) / 8.0;
    let (mut sizes, mut factors) = (0.0, 0.0);
    for _ in 0..40 {
        let z = axis.iter().flat_map(|&u| axis.iter().map(move |_| 1.8 * ripple(u))).map(|z| z + random.normal());
        let nodes = Nodes::grid(axis.clone(), axis.clone(), z.collect(), None, None).unwrap();
        let found = checked(&nodes, &spec(Degree::Both(3)));
        let lack = found.iter().find_map(|warning| match warning {
            ResidualWarning::LackOfFit { shape: MissingShape::NextOrder, rms, factor, .. } => Some((*rms, *factor)),
            _ => None,
        });
        let (rms, factor) = lack.unwrap_or_else(|| panic!("{found:?}"));
        (sizes, factors) = (sizes + rms.unwrap() / 40.0, factors + factor / 40.0);
    }
    // 1.8 times the rms of what P₄ has outside cubics on these nodes
    let powers = nalgebra::DMatrix::from_fn(15, 5, |i, j| axis[i].powi(j as i32)).qr().q();
    let left = axis.iter().enumerate().map(|(i, &u)| powers[(i, 4)] * ripple(u)).sum::<f64>() / 15f64.sqrt();
    let truth = 1.8 * left.abs();
    assert!((sizes / truth - 1.0).abs() < 0.1, "{sizes} {truth}");
    let squares = 225.0 * truth * truth;
    let expected = ((16.0 + squares) / (16.0 * (1.0 + squares / 209.0))).sqrt();
    assert!((factors / expected - 1.0).abs() < 0.1, "{factors} {expected}");
}

/// Regularisation and plans change no check of the errors.
#[test]
fn the_checks_are_those_of_least_squares() {
    let [_, b, _, _] = Checked::all();
    let nodes = b.rough_borders(&mut Random::new(32), 4.0).unwrap();
    let plain = checked(&nodes, &b.spec);
    assert!(plain.iter().any(|warning| matches!(warning, ResidualWarning::UnevenVariance { .. })), "{plain:?}");
    let regularized = FitSpec { regularization: Regularization::default(), ..b.spec.clone() };
    assert_eq!(checked(&nodes, &regularized), plain);
    let plans = Plans::default();
    for _ in 0..2 {
        assert_eq!(fit_remembering(&nodes, &b.spec, &plans).unwrap(), fit(&nodes, &b.spec));
    }
}

/// Codes of the reasons to doubt the intervals of a fit, from the first coefficient.
fn doubts(found: &FitResult) -> Vec<&'static str> {
    found.coefficients[0].interval.unwrap().about.doubts.codes().collect()
}

/// One check below 0.001, or two below 0.01: of 1,000 clean fits of each design 6 are expected,
/// more than 16 in one of 3,000 runs.
#[test]
fn clean_fits_are_seldom_doubtful() {
    for design in Checked::all() {
        let plans = Plans::default();
        let doubted = count(1_000, 41, |random| {
            !doubts(&fit_remembering(&design.white(random).unwrap(), &design.spec, &plans).unwrap()).is_empty()
        });
        assert!(doubted <= 16, "{}: {doubted}", design.name);
    }
}

/// Reasons to doubt a conformity are codes of warnings.
#[test]
fn every_reason_to_doubt_is_the_code_of_a_warning() {
    let published = [Warning::CODES, ResidualWarning::CODES, TraceWarning::CODES].concat();
    let unknown: Vec<&str> = Doubts::CODES.into_iter().filter(|code| !published.contains(code)).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}

#[test]
fn contradicted_assumptions_are_reasons_to_doubt() {
    let [a, b, c, _] = Checked::all();
    let relief = |random: &mut Random| doubts(&fit(&c.relieved(random, 15.0, 10.0).unwrap(), &c.spec));
    assert!(count(100, 42, |random| relief(random).contains(&"lack_of_fit")) >= 99);
    let rough = |random: &mut Random| doubts(&fit(&b.rough_borders(random, 3.5).unwrap(), &b.spec));
    assert!(count(100, 43, |random| rough(random).contains(&"uneven_variance")) >= 90);
    // a single check between 0.001 and 0.01 warns, but is no reason
    let mut random = Random::new(44);
    let alone = (0..4_000).find_map(|_| {
        let found = fit(&a.white(&mut random).unwrap(), &a.spec);
        let warned = found.warnings.len() == 1 && matches!(found.warnings[0], Warning::Residuals { .. });
        (warned && found.warnings[0].code() == "correlated_residuals" && doubts(&found).is_empty()).then_some(())
    });
    assert!(alone.is_some());
}

/// A model of the errors that the residuals bear out leaves no doubt.
#[test]
fn a_direction_that_is_left_out_is_found() {
    let [_, b, ..] = Checked::all();
    let errors = Some(Errors { correlation: Correlation::Ar1 { rho: None }, along: Along::Order, lines: None });
    let spec = FitSpec { errors, ..b.spec.clone() };
    let mut random = Random::new(45);
    type Draw<'a> = &'a dyn Fn(&mut Random) -> Nodes;
    let cases: [(Along, Draw); 3] = [
        (Along::U, &|random| b.correlated(random, 0.6, true).unwrap()),
        (Along::V, &|random| b.correlated(random, 0.6, false).unwrap()),
        (Along::Both, &|random| b.correlated_both(random, [0.5, 0.5]).unwrap()),
    ];
    for (along, draw) in cases {
        let (mut chosen, mut held, mut all) = (0, 0, 0);
        for _ in 0..60 {
            let found = fit(&draw(&mut random), &spec);
            chosen += usize::from(found.errors.as_ref().unwrap().along == along);
            for coefficient in &found.coefficients {
                let [low, high] = coefficient.interval.unwrap().ends;
                held += usize::from(low <= 0.0 && 0.0 <= high);
                all += 1;
            }
        }
        let coverage = held as f64 / all as f64;
        assert!(chosen >= 55 && coverage > 0.91, "{along:?}: {chosen} of 60, {coverage}");
    }
}

/// Scattered nodes have neighbours too: a hidden wave of short length is found, white noise is not.
#[test]
fn neighbours_of_scattered_nodes_are_compared() {
    let correlated = |random: &mut Random, wave: f64| {
        let [u, v] = [0, 1].map(|_| (0..120).map(|_| random.between(0.0, 10.0)).collect::<Vec<f64>>());
        let phases = [0, 1].map(|_| random.between(0.0, 6.3));
        let height = |(u, v): (&f64, &f64)| wave * ((1.5 * u + phases[0]).sin() + (1.5 * v + phases[1]).sin());
        let z = u.iter().zip(&v).map(height).zip(random.normals(120)).map(|(z, noise)| z + noise).collect();
        let nodes = Nodes::scattered(u, v, z, None).unwrap();
        checked(&nodes, &spec(Degree::Both(2)))
            .iter()
            .any(|w| matches!(w, ResidualWarning::CorrelatedResiduals { along: None, .. }))
    };
    let false_alarms = count(1_000, 46, |random| correlated(random, 0.0));
    assert!((2..=20).contains(&false_alarms), "{false_alarms}");
    let found = count(100, 47, |random| correlated(random, 1.0));
    assert!(found >= 80, "{found}");
}
