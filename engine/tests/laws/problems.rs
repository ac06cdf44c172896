//! Problems to fit: measurement matrices of a wanted condition, and surfaces in millimetres.

use crate::oracle::design::{Basis, surface};
use crate::oracle::matrix::{rows, vector};
use crate::oracle::random::Random;
use crate::oracle::spectral::{Columns, Filter, Spectrum};
use flankfit_engine::estimation::spec::{
    Count, Criterion, DEFAULT_CONDITION_LIMIT, Degree, FitSpec, Model, Parameter, PolynomialBasis, Regularization,
    Scaling, Scheme, Terms,
};
use flankfit_engine::estimation::{FitResult, Nodes};
use proptest::test_runner::{Config, RngSeed};

/// The same cases at every run, unless `PROPTEST_RNG_SEED` asks for others.
pub fn config(cases: u32) -> Config {
    let base = Config { cases, failure_persistence: None, ..Config::default() };
    if std::env::var_os("PROPTEST_RNG_SEED").is_some() { base } else { Config { rng_seed: RngSeed::Fixed(52), ..base } }
}

/// A measurement matrix and its heights.
#[derive(Clone, Debug)]
pub struct Problem {
    pub x: Vec<Vec<f64>>,
    pub y: Vec<f64>,
}

impl Problem {
    /// `X = U Σ Vᵀ` with random U and V and singular values graded so that cond(XᵀX) is
    /// 10^`log_condition`; heights of random coefficients with noise.
    pub fn graded(seed: u64, n: usize, extra: usize, log_condition: f64) -> Self {
        Self::of(seed, n, extra, log_condition, false)
    }

    /// The same, with some eigenvalues equal in every third case (their directions are then
    /// anyone's choice).
    pub fn clustered(seed: u64, n: usize, extra: usize, log_condition: f64) -> Self {
        Self::of(seed, n, extra, log_condition, seed.is_multiple_of(3))
    }

    fn of(seed: u64, n: usize, extra: usize, log_condition: f64, clustered: bool) -> Self {
        let mut random = Random::new(seed);
        let m = n + extra;
        let (u, v) = (orthonormal(&mut random, m, n), orthonormal(&mut random, n, n));
        let singular: Vec<f64> = (0..n)
            .map(|i| {
                let place = match (i, clustered) {
                    (0, _) => 0.0,
                    (i, _) if i + 1 == n => 1.0,
                    (_, true) => random.below(3) as f64 / 2.0,
                    (i, false) => (i as f64 + random.between(-0.4, 0.4)) / (n - 1) as f64,
                };
                10f64.powf(-0.5 * log_condition * place)
            })
            .collect();
        // Along the small directions the true components may be as small as the matrix or as large
        // as its inverse.
        let grading = random.between(-1.0, 1.0);
        let size = 10f64.powf(random.between(-2.0, 2.0));
        let truth: Vec<f64> = singular.iter().map(|s| random.normal() * s.powf(grading)).collect();
        let x: Vec<Vec<f64>> = (0..m)
            .map(|k| (0..n).map(|j| (0..n).map(|i| size * u[i][k] * singular[i] * v[i][j]).sum()).collect())
            .collect();
        let noise = 10f64.powf(random.between(-6.0, -1.0));
        let y = (0..m)
            .map(|k| (0..n).map(|i| u[i][k] * singular[i] * truth[i]).sum::<f64>() + noise * random.normal())
            .collect();
        Problem { x, y }
    }

    pub fn nodes(&self) -> Nodes {
        matrix(&self.x, &self.y, None)
    }

    pub fn spectrum(&self, columns: Columns) -> Spectrum {
        Spectrum::new(&rows(&self.x), &vector(&self.y), None, columns)
    }
}

fn orthonormal(random: &mut Random, length: usize, count: usize) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    while basis.len() < count {
        let mut next = random.normals(length);
        for _ in 0..2 {
            for b in &basis {
                let along: f64 = b.iter().zip(&next).map(|(p, q)| p * q).sum();
                next.iter_mut().zip(b).for_each(|(p, q)| *p -= along * q);
            }
            let norm = next.iter().map(|p| p * p).sum::<f64>().sqrt();
            next.iter_mut().for_each(|p| *p /= norm);
        }
        basis.push(next);
    }
    basis
}

pub fn matrix(x: &[Vec<f64>], y: &[f64], weight: Option<Vec<f64>>) -> Nodes {
    Nodes::matrix(x.concat(), x[0].len(), y.to_vec(), None, weight).expect("checked nodes")
}

pub fn fit(nodes: &Nodes, spec: &FitSpec) -> FitResult {
    flankfit_engine::estimation::fit(nodes, spec).unwrap_or_else(|error| panic!("no fit: {error}\n{nodes:?}\n{spec:?}"))
}

pub fn linear() -> FitSpec {
    FitSpec::new(Model::Linear)
}

pub fn polynomial(degree: Degree, basis: PolynomialBasis) -> FitSpec {
    FitSpec::new(Model::Polynomial { degree, basis, terms: Terms::Tensor })
}

pub fn spectral(scheme: Scheme, count: Count, lambda_star: Parameter) -> Regularization {
    Regularization::Spectral { scheme, count, condition_limit: DEFAULT_CONDITION_LIMIT, lambda_star }
}

pub fn by(criterion: Criterion) -> Parameter {
    Parameter::Criterion(criterion)
}

pub fn columns(scaling: Scaling) -> Columns {
    match scaling {
        Scaling::UnitLength => Columns::UnitLength,
        Scaling::None => Columns::AsTheyAre,
        Scaling::Standardized => Columns::Standardized(0),
    }
}

pub fn filter(scheme: Scheme, count: usize) -> Filter {
    match scheme {
        Scheme::FirstOrder => Filter::FirstOrder(count),
        Scheme::Exact => Filter::Exact(count),
    }
}

pub fn values(result: &FitResult) -> Vec<f64> {
    result.coefficients.iter().map(|c| c.value).collect()
}

pub fn least_squares_values(result: &FitResult) -> Vec<f64> {
    result.coefficients.iter().map(|c| c.least_squares).collect()
}

pub fn warned(result: &FitResult, code: &str) -> bool {
    result.warnings.iter().any(|w| w.code() == code)
}

/// `|a − b| ≤ relative · max(|a|, |b|) + absolute`.
pub fn close(a: f64, b: f64, relative: f64, absolute: f64) -> bool {
    (a - b).abs() <= relative * a.abs().max(b.abs()) + absolute
}

#[track_caller]
pub fn assert_close(what: &str, a: f64, b: f64, relative: f64, absolute: f64) {
    assert!(close(a, b, relative, absolute), "{what}: {a:e} and {b:e} differ by {:e}", a - b);
}

#[track_caller]
pub fn assert_all_close(what: &str, a: &[f64], b: &[f64], relative: f64) {
    assert_eq!(a.len(), b.len(), "{what}");
    for (i, (p, q)) in a.iter().zip(b).enumerate() {
        assert!(close(*p, *q, relative, 0.0), "{what}[{i}]: {p:e} and {q:e}\n{a:?}\n{b:?}");
    }
}

/// Two results of the same request: every coefficient agrees to a millionth of its standard error,
/// the spectrum and its consequences to `relative`.
#[track_caller]
pub fn assert_same_fit(one: &FitResult, two: &FitResult, relative: f64) {
    assert_eq!(one.coefficients.len(), two.coefficients.len());
    for (a, b) in one.coefficients.iter().zip(&two.coefficients) {
        let noise = 1e-6 * a.least_squares_std_error.unwrap_or(0.0);
        assert_close(&a.term, a.value, b.value, relative, noise);
        assert_close(&a.term, a.least_squares, b.least_squares, relative, noise);
        assert_close(&a.term, a.bias_bound, b.bias_bound, 1e3 * relative, noise);
    }
    assert_all_close("eigenvalues", &one.spectrum.eigenvalues, &two.spectrum.eigenvalues, relative);
    let (a, b) = (&one.regularization, &two.regularization);
    assert_eq!(a.count, b.count);
    assert_all_close("filter factors", &a.filter_factors, &b.filter_factors, 1e3 * relative);
    assert_close("rss", one.residuals.rss, two.residuals.rss, 1e3 * relative, 0.0);
    assert_close("bias", one.bias.norm, two.bias.norm, 1e3 * relative, 1e-9 * one.bias.coefficient_norm_limit);
}

/// A surface over `[30, 30 + 4] × [0, 20]` mm whose coefficients in products of Legendre
/// polynomials decay.
pub struct Surface {
    pub nodes: Vec<[f64; 2]>,
    pub z: Vec<f64>,
    pub u: Vec<f64>,
    pub v: Vec<f64>,
}

impl Surface {
    /// On a grid of 9 × 7 crossings, with noise.
    pub fn new(seed: u64, degree: [usize; 2], decay: f64, noise: f64) -> Self {
        let mut random = Random::new(seed);
        let u: Vec<f64> = (0..9).map(|i| 30.0 + 0.5 * i as f64).collect();
        let v: Vec<f64> = (0..7).map(|j| 20.0 / 6.0 * j as f64).collect();
        let nodes = crate::oracle::design::crossings(&u, &v);
        let bases = [Basis::Legendre([30.0, 34.0]), Basis::Legendre([0.0, 20.0])];
        let columns = surface(bases, degree, &nodes, |_, _| true);
        let terms = (0..=degree[0]).flat_map(|p| (0..=degree[1]).map(move |q| p + q));
        let truth: Vec<f64> = terms.map(|order| 0.02 * decay.powi(order as i32) * random.normal()).collect();
        let z = columns
            .iter()
            .map(|row| row.iter().zip(&truth).map(|(f, c)| f.to_f64() * c).sum::<f64>() + noise * random.normal())
            .collect();
        Surface { nodes, z, u, v }
    }

    pub fn scattered(&self) -> Nodes {
        self.scattered_in(1.0)
    }

    /// In a unit of which `unit` make a millimetre.
    pub fn scattered_in(&self, unit: f64) -> Nodes {
        let axis = |k: usize| self.nodes.iter().map(|n| n[k] * unit).collect();
        Nodes::scattered(axis(0), axis(1), self.z.iter().map(|z| z * unit).collect(), None).expect("checked nodes")
    }

    pub fn grid(&self) -> Nodes {
        Nodes::grid(self.u.clone(), self.v.clone(), self.z.clone(), None, None).expect("checked nodes")
    }
}
