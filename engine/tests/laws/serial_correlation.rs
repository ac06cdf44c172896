//! The warning of correlated residuals: how often it is false, and what it says where it is not.

use crate::{oracle::random::Random, problems::fit};
use flankfit_engine::estimation::{
    FitSpec, Nodes,
    result::Warning,
    spec::{Along, Degree, Model, PolynomialBasis, Terms},
};

fn spec(degree: Degree) -> FitSpec {
    FitSpec::new(Model::Polynomial { degree, basis: PolynomialBasis::Legendre, terms: Terms::Tensor })
}

fn axis(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64).collect()
}

fn warning(nodes: &Nodes, spec: &FitSpec) -> Option<(Along, f64, f64)> {
    fit(nodes, spec).warnings.iter().find_map(|warning| match warning {
        Warning::CorrelatedResiduals { along, factor, p, .. } => Some((*along, *factor, *p)),
        _ => None,
    })
}

/// 1 in 1,000, at whatever leverage: of 3 × 2,000 fits 6 are expected, more than 16 in one of 8,000
/// runs.
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
    assert!(false_alarms <= 16, "{false_alarms}");
}

/// At ρ = 0.8 the standard errors of a cubic at 60 nodes are 3.28 times too small on average
/// (numpy: traces of the exact covariances).
#[test]
fn the_factor_is_about_what_standard_errors_lack() {
    let mut random = Random::new(6);
    let mut factors = Vec::new();
    for _ in 0..200 {
        let nodes = Nodes::curve(axis(60), random.autoregression(60, 0.8), None).unwrap();
        factors.extend(warning(&nodes, &spec(Degree::Both(3))).map(|(along, factor, p)| {
            assert!(along == Along::Order && p < 1e-3);
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
