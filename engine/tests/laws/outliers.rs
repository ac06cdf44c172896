//! Gross errors: rates of false alarms and of detection, masking, and the figures of the warning
//! against an independent least-squares solution by QR.
//!
//! `cargo test -p flankfit-engine --test laws outliers -- --nocapture` prints the rates.

use std::f64::consts::TAU;

use crate::oracle::random::Random;
use flankfit_engine::estimation::{
    FitError, FitResult, FitSpec, Nodes, Plans, fit, fit_remembering,
    result::{Outliers, Warning},
    spec::{
        Along, Constraint, ConstraintKind, Correlation, Degree, Errors, Estimator, Filter, FilterAxis, Gaussian, Loss,
        MEstimator, Model, NodeAt, PolynomialBasis, Prior, PriorSpread, Regularization, Terms,
    },
};
use nalgebra::{DMatrix, DVector};

fn polynomial(degree: usize, basis: PolynomialBasis) -> FitSpec {
    let model = Model::Polynomial { degree: Degree::Both(degree), basis, terms: Terms::Tensor };
    FitSpec { regularization: Regularization::None, ..FitSpec::new(model) }
}

fn plain() -> FitSpec {
    polynomial(2, PolynomialBasis::Legendre)
}

fn suspected(result: &FitResult) -> Option<&Outliers> {
    result.warnings.iter().find_map(|warning| match warning {
        Warning::OutliersSuspected(found) => Some(found),
        _ => None,
    })
}

fn indices(result: &FitResult) -> Vec<usize> {
    let mut found: Vec<usize> =
        suspected(result).iter().flat_map(|found| &found.nodes).map(|node| node.index).collect();
    found.sort_unstable();
    found
}

/// A flank of `rows` × `columns` nodes.
#[derive(Clone, Copy)]
struct Flank {
    rows: usize,
    columns: usize,
}

impl Flank {
    fn axes(self) -> [Vec<f64>; 2] {
        let axis = |low: f64, step: f64, count: usize| (0..count).map(|k| low + step * k as f64).collect();
        [axis(6.0, 0.7, self.rows), axis(1.0, 1.6, self.columns)]
    }

    fn count(self) -> usize {
        self.rows * self.columns
    }

    /// Returns heights of a parabolic surface with these errors.
    fn heights(self, errors: &[f64]) -> Vec<f64> {
        let [u, v] = self.axes();
        let clean = |k: usize| {
            let (u, v) = (u[k / self.columns], v[k % self.columns]);
            3.0 - 0.3 * (u - 8.0).powi(2) + 0.02 * (v - 6.0).powi(2) + 0.05 * u * v
        };
        errors.iter().enumerate().map(|(k, error)| clean(k) + error).collect()
    }

    fn grid(self, errors: &[f64]) -> Nodes {
        let [u, v] = self.axes();
        Nodes::grid(u, v, self.heights(errors), None, None).expect("sound nodes")
    }

    fn scattered(self, errors: &[f64], weight: Option<Vec<f64>>) -> Nodes {
        let [u, v] = self.axes();
        let each = |axis: &dyn Fn(usize) -> f64| (0..self.count()).map(axis).collect();
        let (u, v) = (each(&|k| u[k / self.columns]), each(&|k| v[k % self.columns]));
        Nodes::scattered(u, v, self.heights(errors), weight).expect("sound nodes")
    }

    /// Returns the design matrix of products of powers, in the order of the coefficients.
    fn matrix(self) -> DMatrix<f64> {
        let [u, v] = self.axes();
        let scaled = |x: f64, axis: &[f64]| 2.0 * (x - axis[0]) / (axis[axis.len() - 1] - axis[0]) - 1.0;
        DMatrix::from_fn(self.count(), 9, |k, j| {
            scaled(u[k / self.columns], &u).powi(j as i32 / 3) * scaled(v[k % self.columns], &v).powi(j as i32 % 3)
        })
    }
}

const SMALL: Flank = Flank { rows: 5, columns: 9 };
const USUAL: Flank = Flank { rows: 9, columns: 15 };

/// Errors of one kind along the lines of a flank.
fn normal(random: &mut Random, flank: Flank) -> Vec<f64> {
    random.normals(flank.count())
}

fn correlated(random: &mut Random, flank: Flank) -> Vec<f64> {
    (0..flank.rows).flat_map(|_| random.autoregression(flank.columns, 0.6)).collect()
}

fn wavy(random: &mut Random, flank: Flank) -> Vec<f64> {
    let phase = TAU * random.unit();
    let along = |k: usize| 2.0 * TAU * (k % flank.columns) as f64 / (flank.columns - 1) as f64;
    (0..flank.count()).map(|k| random.normal() + (phase + along(k)).sin()).collect()
}

/// Returns the share of fits without gross errors that have a warning.
fn false_alarms(flank: Flank, runs: usize, errors: fn(&mut Random, Flank) -> Vec<f64>) -> f64 {
    let (mut random, plans, spec) = (Random::new(405), Plans::default(), plain());
    let alarm = |_: usize| {
        let nodes = flank.grid(&errors(&mut random, flank));
        suspected(&fit_remembering(&nodes, &spec, &plans).expect("a fit")).is_some()
    };
    (0..runs).map(alarm).filter(|alarm| *alarm).count() as f64 / runs as f64
}

#[test]
fn clean_fits_raise_no_alarm() {
    for (name, errors, most) in [
        ("normal", normal as fn(&mut Random, Flank) -> Vec<f64>, 0.002),
        ("AR(0.6)", correlated, 0.01),
        ("wave", wavy, 0.01),
    ] {
        for (flank, runs) in [(SMALL, 10_000), (USUAL, 10_000)] {
            let rate = false_alarms(flank, runs, errors);
            println!("{name}, {} nodes: {rate}", flank.count());
            assert!(rate <= most, "{name}, {} nodes: {rate}", flank.count());
        }
    }
}

/// Returns the share of runs in which exactly the `count` nodes with errors of ±30 σ are named.
fn found(flank: Flank, count: usize, runs: usize) -> f64 {
    let (mut random, plans, spec) = (Random::new(406), Plans::default(), plain());
    let hit = |_: usize| {
        let mut errors = normal(&mut random, flank);
        let mut places: Vec<usize> = (0..flank.count()).collect();
        random.shuffle(&mut places);
        places.truncate(count);
        for &k in &places {
            errors[k] += if random.unit() < 0.5 { 30.0 } else { -30.0 };
        }
        places.sort_unstable();
        let named = indices(&fit_remembering(&flank.grid(&errors), &spec, &plans).expect("a fit"));
        places.iter().all(|k| named.contains(k))
    };
    (0..runs).map(hit).filter(|hit| *hit).count() as f64 / runs as f64
}

#[test]
fn gross_errors_are_found() {
    let rate = found(USUAL, 1, 2_000);
    println!("one in 135: {rate}");
    assert!(rate >= 0.999, "{rate}");
    for (flank, count) in [(SMALL, 2), (SMALL, 3), (USUAL, 2), (USUAL, 3), (USUAL, 10)] {
        let rate = found(flank, count, 500);
        println!("{count} in {}: {rate}", flank.count());
        assert!(rate >= 0.99, "{count} in {}: {rate}", flank.count());
    }
}

/// The figures of the warning agree with least squares without the node.
#[test]
fn figures_are_those_of_the_others() {
    let mut random = Random::new(407);
    for node in [0, 20, 44] {
        let mut errors: Vec<f64> = random.normals(45).iter().map(|e| 0.5 * e).collect();
        errors[node] += 20.0;
        let others: Vec<usize> = (0..45).filter(|k| *k != node).collect();
        let (x, z) = (SMALL.matrix(), DVector::from_vec(SMALL.heights(&errors)));
        let (left_x, left_z) = (x.select_rows(&others), z.select_rows(&others));
        let qr = left_x.clone().qr();
        let c = qr.r().solve_upper_triangular(&(qr.q().transpose() * &left_z)).expect("full rank");
        let sigma = ((&left_z - &left_x * &c).norm_squared() / 35.0).sqrt();
        let off = z[node] - (x.row(node) * &c)[0];
        for nodes in [SMALL.grid(&errors), SMALL.scattered(&errors, None)] {
            let result = fit(&nodes, &plain()).expect("a fit");
            let suspects = suspected(&result).expect("a gross error");
            let [found] = &suspects.nodes[..] else { panic!("{suspects}") };
            assert_eq!(found.index, node);
            let cell = found.row.zip(found.column);
            assert_eq!(cell, matches!(nodes, Nodes::Grid(_)).then_some((node / 9, node % 9)));
            assert!((found.off / off - 1.0).abs() < 1e-9, "{} for {off}", found.off);
            assert!((found.off_sigmas * sigma / off - 1.0).abs() < 1e-9, "{}", found.off_sigmas);
            assert_eq!(found.height, z[node]);
            let without = result.without_suspected.as_ref().expect("the others determine a fit");
            let asked = FitSpec { exclude: vec![NodeAt::Index(node)], ..plain() };
            let excluded = fit(&nodes, &asked).expect("a fit");
            assert_eq!(excluded.coefficients, without.coefficients);
            assert!(suspected(&excluded).is_none());
            for (coefficient, (with, without)) in
                suspects.coefficients.iter().zip(result.coefficients.iter().zip(&without.coefficients))
            {
                assert_eq!((coefficient.value, coefficient.without), (with.value, without.value));
            }
            assert!(suspects.moved().next().is_some() && suspects.to_string().contains(&format!("node {node} ")));
        }
    }
}

/// A node of low weight may deviate far without being suspected.
#[test]
fn weights_are_honoured() {
    let mut errors = Random::new(408).normals(45);
    errors[17] += 40.0;
    let weight = (0..45).map(|k| if k == 17 { 1.0 / 1600.0 } else { 1.0 }).collect();
    assert_eq!(indices(&fit(&SMALL.scattered(&errors, None), &plain()).expect("a fit")), [17]);
    assert!(suspected(&fit(&SMALL.scattered(&errors, Some(weight)), &plain()).expect("a fit")).is_none());
}

#[test]
fn rounding_is_no_gross_error() {
    for degree in 2..6 {
        for basis in [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre] {
            let flank = Flank { rows: 11, columns: 13 };
            let exact = vec![0.0; flank.count()];
            for nodes in [flank.grid(&exact), flank.scattered(&exact, None)] {
                let result = fit(&nodes, &polynomial(degree, basis)).expect("a fit");
                assert!(suspected(&result).is_none(), "{degree} {basis:?}: {:?}", result.warnings);
            }
            // against rounding errors alone, every deviation is significant
            let mut one_off = exact.clone();
            one_off[60] = 1e-3;
            assert_eq!(indices(&fit(&flank.grid(&one_off), &polynomial(degree, basis)).expect("a fit")), [60]);
        }
    }
}

/// Regularisation, a prior and correlated errors do not change the suspected nodes: they are those
/// of plain least squares. Robust fits have no test.
#[test]
fn every_fit_but_a_robust_one_tests_its_nodes() {
    let mut errors = Random::new(409).normals(135);
    errors[70] += 30.0;
    let nodes = USUAL.grid(&errors);
    let prior = Prior::Given { mean: vec![0.0; 9], spread: PriorSpread::StdError(vec![10.0; 9]) };
    let ar = Errors { correlation: Correlation::Ar1 { rho: Some(0.3) }, along: Along::V, lines: None };
    let concave = Constraint { kind: ConstraintKind::Concave, along: Some(FilterAxis::V), domain: None };
    let smooth = Filter::Gaussian(Gaussian { axis: Some(FilterAxis::V), cutoff: 5.0, robust: None });
    for spec in [
        FitSpec { regularization: Regularization::default(), ..plain() },
        FitSpec { prior: Some(prior), ..plain() },
        FitSpec { errors: Some(ar), ..plain() },
        FitSpec { filters: vec![smooth], ..plain() },
        FitSpec { constraints: vec![concave], ..plain() },
    ] {
        assert_eq!(indices(&fit(&nodes, &spec).expect("a fit")), [70], "{spec:?}");
    }
    let robust = Estimator::M(MEstimator::new(Loss::HUBER));
    assert!(suspected(&fit(&nodes, &FitSpec { estimator: robust, ..plain() }).expect("a fit")).is_none());
}

/// Excluding a node gives the same fit as a missing node.
#[test]
fn an_excluded_node_is_a_missing_one() {
    let errors = Random::new(410).normals(45);
    let excluding = |exclude: Vec<NodeAt>| FitSpec { exclude, ..plain() };
    let [u, v] = SMALL.axes();
    let mut z = SMALL.heights(&errors);
    (z[13], z[30]) = (f64::NAN, f64::NAN);
    let missing = fit(&Nodes::grid(u, v, z, None, None).expect("sound nodes"), &plain()).expect("a fit");
    let named = vec![NodeAt::Cell { row: 1, column: 4 }, NodeAt::Index(30)];
    assert_eq!(fit(&SMALL.grid(&errors), &excluding(named.clone())).expect("a fit"), missing);
    let scattered = fit(&SMALL.scattered(&errors, None), &excluding(vec![NodeAt::Index(13), NodeAt::Index(30)]));
    for (a, b) in scattered.expect("a fit").coefficients.iter().zip(&missing.coefficients) {
        assert!((a.value - b.value).abs() < 1e-10);
    }
    let excluded = |nodes: &Nodes, exclude: Vec<NodeAt>| match fit(nodes, &excluding(exclude)) {
        Err(FitError::Invalid(faults)) => faults.to_string(),
        other => panic!("{other:?}"),
    };
    let beyond = vec![NodeAt::Cell { row: 5, column: 0 }, NodeAt::Index(45), NodeAt::Index(3), named[0], named[0]];
    assert_eq!(
        excluded(&SMALL.grid(&errors), beyond),
        "exclude[0]: the grid has 5 rows and 9 columns, which count from 0; exclude[1]: there is no such node: 45 \
         were posted, and indices count from 0; exclude[4]: this node is already excluded by entry 3: name it once"
    );
    let cell = excluded(&SMALL.scattered(&errors, None), vec![named[0]]);
    assert_eq!(cell, "exclude[0]: only nodes of a grid have a row and a column: give the index of the node");
    let most = excluded(&SMALL.grid(&errors), (0..37).map(NodeAt::Index).collect());
    assert_eq!(most, "exclude: 8 nodes are left for 9 coefficients: exclude fewer, or lower the degree");
    let all = excluded(&SMALL.grid(&errors), (0..45).map(NodeAt::Index).collect());
    assert_eq!(all, "exclude: no node is left: exclude fewer");
}
