//! Robust estimates against searches through everything: all vertices, all subsets, all pairs; and
//! laws that every such estimator keeps.

use crate::oracle::random::Random;
use flankfit_engine::estimation::{
    FitError, FitResult, FitSpec, Nodes, fit,
    result::LocalSolution,
    spec::{
        Contamination, Degree, Distribution, Estimator, Include, LEstimator, Loss, MEstimator, Model, Parameter,
        PolynomialBasis, QuantileWeights, Regularization, ScaleRule, Scaling, Start, Terms,
    },
};

pub struct Problem {
    pub x: Vec<Vec<f64>>,
    pub y: Vec<f64>,
    pub weight: Option<Vec<f64>>,
}

impl Problem {
    /// A constant and `n − 1` columns; some heights are grossly wrong. `round` leaves integers, so
    /// that much coincides.
    pub fn new(seed: u64, m: usize, n: usize, round: bool) -> Self {
        let mut random = Random::new(seed);
        let mut number = |size: f64| {
            let value = size * random.normal();
            if round { value.round() } else { value }
        };
        let x: Vec<Vec<f64>> =
            (0..m).map(|_| std::iter::once(1.0).chain((1..n).map(|_| number(3.0))).collect()).collect();
        let truth: Vec<f64> = (0..n).map(|_| number(2.0)).collect();
        let y = x
            .iter()
            .enumerate()
            .map(|(k, row)| {
                let gross = if k % 5 == 2 { number(40.0) } else { 0.0 };
                row.iter().zip(&truth).map(|(x, a)| x * a).sum::<f64>() + number(1.0) + gross
            })
            .collect();
        Problem { x, y, weight: None }
    }

    fn nodes(&self) -> Nodes {
        Nodes::matrix(self.x.concat(), self.x[0].len(), self.y.clone(), None, self.weight.clone()).unwrap()
    }

    pub fn fit(&self, estimator: Estimator) -> FitResult {
        self.fit_with(estimator, Regularization::None)
    }

    pub fn fit_with(&self, estimator: Estimator, regularization: Regularization) -> FitResult {
        let include = Include { robust_weights: true, ..Include::default() };
        fit(&self.nodes(), &FitSpec { estimator, regularization, include, ..FitSpec::new(Model::Linear) }).unwrap()
    }

    pub fn residuals(&self, a: &[f64]) -> Vec<f64> {
        let plain = self.x.iter().zip(&self.y).map(|(x, y)| y - x.iter().zip(a).map(|(x, a)| x * a).sum::<f64>());
        match &self.weight {
            Some(w) => plain.zip(w).map(|(r, w)| r * w.sqrt()).collect(),
            None => plain.collect(),
        }
    }

    /// Weighted least squares by normal equations and elimination.
    fn least_squares(&self, weight: &[f64]) -> Option<Vec<f64>> {
        let n = self.x[0].len();
        let sum = |f: &dyn Fn(usize) -> f64| (0..self.y.len()).map(|k| weight[k] * f(k)).sum::<f64>();
        let a = (0..n).map(|i| (0..n).map(|j| sum(&|k| self.x[k][i] * self.x[k][j])).collect()).collect();
        solve(a, (0..n).map(|i| sum(&|k| self.x[k][i] * self.y[k])).collect())
    }
}

/// Gauss with pivoting; `None` when singular.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for i in 0..n {
        let p = (i..n).max_by(|&p, &q| a[p][i].abs().total_cmp(&a[q][i].abs()))?;
        if a[p][i].abs() < 1e-9 {
            return None;
        }
        a.swap(i, p);
        b.swap(i, p);
        for k in i + 1..n {
            let f = a[k][i] / a[i][i];
            for j in i..n {
                a[k][j] -= f * a[i][j];
            }
            b[k] -= f * b[i];
        }
    }
    for i in (0..n).rev() {
        b[i] = (b[i] - (i + 1..n).map(|j| a[i][j] * b[j]).sum::<f64>()) / a[i][i];
    }
    Some(b)
}

/// All ascending choices of `size` numbers below `end`.
fn choices(size: usize, end: usize) -> Vec<Vec<usize>> {
    if size == 0 {
        return vec![Vec::new()];
    }
    let mut out = Vec::new();
    for mut rest in choices(size - 1, end) {
        for k in rest.last().map_or(0, |l| l + 1)..end {
            rest.push(k);
            out.push(rest.clone());
            rest.pop();
        }
    }
    out
}

pub fn values(result: &FitResult) -> Vec<f64> {
    result.coefficients.iter().map(|c| c.value).collect()
}

#[track_caller]
pub fn near(what: &str, got: f64, wanted: f64, tolerance: f64) {
    assert!((got - wanted).abs() <= tolerance * wanted.abs().max(1e-6), "{what}: {got}, not {wanted}");
}

fn check_loss(r: &[f64], tau: f64) -> f64 {
    r.iter().map(|r| r * if *r < 0.0 { tau - 1.0 } else { tau }).sum()
}

#[test]
fn no_vertex_does_better_than_least_absolute_deviations_and_quantiles() {
    for seed in 0..40 {
        let n = 1 + (seed % 4) as usize;
        let mut problem = Problem::new(seed, 6 + (seed % 7) as usize, n, seed % 2 == 0);
        if seed % 3 == 0 {
            problem.weight = Some((0..problem.y.len()).map(|k| 0.5 + k as f64).collect());
        }
        if choices(n, problem.y.len()).iter().all(|c| vertex(&problem, c).is_none()) {
            continue;
        }
        for tau in [0.5, 0.1, 0.8] {
            let least = choices(n, problem.y.len())
                .iter()
                .filter_map(|c| vertex(&problem, c))
                .map(|a| check_loss(&problem.residuals(&a), tau))
                .fold(f64::INFINITY, f64::min);
            let Ok(result) = fit(
                &problem.nodes(),
                &FitSpec {
                    estimator: Estimator::Quantile { tau },
                    regularization: Regularization::None,
                    ..FitSpec::new(Model::Linear)
                },
            ) else {
                assert!(seed % 2 == 0, "integers may depend on each other, others not");
                continue;
            };
            let robust = result.robust.as_ref().unwrap();
            assert!(robust.converged && robust.certificate.unwrap() <= 1.0 + 1e-9, "seed {seed}: {robust:?}");
            near("objective", robust.objective, least, 1e-11);
            near("objective at the answer", check_loss(&problem.residuals(&values(&result)), tau), least, 1e-11);
            for &k in robust.vertex.as_ref().unwrap() {
                assert!(problem.residuals(&values(&result))[k].abs() < 1e-11);
            }
            if tau == 0.5 {
                near("L1", problem.fit(Estimator::LeastAbsolute).robust.unwrap().objective, 2.0 * least, 1e-11);
            }
        }
    }
}

fn vertex(problem: &Problem, nodes: &[usize]) -> Option<Vec<f64>> {
    solve(nodes.iter().map(|&k| problem.x[k].clone()).collect(), nodes.iter().map(|&k| problem.y[k]).collect())
}

#[test]
fn non_unique_solutions_are_reported() {
    // the median of an even number of heights
    let problem = Problem { x: vec![vec![1.0]; 4], y: vec![0.0, 1.0, 3.0, 7.0], weight: None };
    let result = problem.fit(Estimator::LeastAbsolute);
    let robust = result.robust.as_ref().unwrap();
    assert_eq!((robust.unique, robust.objective), (Some(false), 9.0));
    assert!((1.0..=3.0).contains(&values(&result)[0]));
    assert!(result.warnings.iter().any(|w| w.code() == "not_unique"));
    // of an odd number, and with a height three times: degenerate, but unique
    for y in [vec![0.0, 1.0, 5.0], vec![0.0, 2.0, 2.0, 2.0, 9.0]] {
        let problem = Problem { x: vec![vec![1.0]; y.len()], y, weight: None };
        let robust = problem.fit(Estimator::LeastAbsolute).robust.unwrap();
        assert_eq!(robust.unique, Some(true));
    }
}

#[test]
fn no_subset_has_a_smaller_trimmed_sum() {
    for seed in 0..12 {
        let problem = Problem::new(100 + seed, 9 + (seed % 4) as usize, 2, seed % 3 == 0);
        let m = problem.y.len();
        for coverage in [0.5, 0.75, 1.0] {
            let result = problem.fit(Estimator::LeastTrimmed { coverage, seed: 0 });
            let robust = result.robust.as_ref().unwrap();
            let h = ((coverage * m as f64) as usize).max((m + 3) / 2);
            assert_eq!(robust.subset_size, Some(h));
            assert_eq!(robust.solution, LocalSolution::Global);
            let least = choices(h, m)
                .iter()
                .filter_map(|c| {
                    let mut w = vec![0.0; m];
                    c.iter().for_each(|&k| w[k] = 1.0);
                    let r = problem.residuals(&problem.least_squares(&w)?);
                    Some(c.iter().map(|&k| r[k] * r[k]).sum::<f64>())
                })
                .fold(f64::INFINITY, f64::min);
            near("trimmed sum", robust.objective, least, 1e-9);
            assert_eq!(robust.rejected_count, m - h);
            assert_eq!(robust.weights.as_ref().unwrap().iter().sum::<f64>(), h as f64);
        }
    }
}

#[test]
fn trimmed_squares_find_the_surface_under_forty_percent_of_gross_errors() {
    for (m, seed) in [(60, 0), (400, 1), (4000, 2)] {
        let mut problem = Problem::new(900 + seed, m, 4, false);
        let mut random = Random::new(seed);
        let truth = [1.0, -2.0, 0.5, 3.0];
        for k in 0..m {
            let clean: f64 = problem.x[k].iter().zip(&truth).map(|(x, a)| x * a).sum();
            // gross errors that lie on a surface of their own
            problem.y[k] =
                if k % 5 < 2 { 100.0 - clean + 5.0 * problem.x[k][1] } else { clean } + 0.01 * random.normal();
        }
        for estimator in [
            Estimator::LeastTrimmed { coverage: 0.5, seed: 7 },
            Estimator::M(MEstimator { start: Start::LeastTrimmed, ..MEstimator::new(Loss::TUKEY) }),
        ] {
            let result = problem.fit(estimator);
            for (got, wanted) in values(&result).iter().zip(&truth) {
                assert!((got - wanted).abs() < 0.01, "{m}: {got} {wanted}");
            }
            let rejected = result.robust.as_ref().unwrap().rejected.as_ref().unwrap();
            assert!((0..m).filter(|k| k % 5 < 2).all(|k| rejected.contains(&k)));
            assert_eq!(result, problem.fit(estimator));
        }
    }
}

#[test]
fn the_seed_hardly_moves_trimmed_squares() {
    for (data, (m, n)) in [(40, 8), (45, 12), (80, 6), (200, 12), (600, 8)].into_iter().enumerate() {
        let problem = Problem::new(500 + data as u64, m, n, false);
        let fits: Vec<FitResult> =
            (0..6).map(|seed| problem.fit(Estimator::LeastTrimmed { coverage: 0.75, seed })).collect();
        for j in 0..n {
            let found = fits.iter().map(|fit| fit.coefficients[j].value);
            let spread = found.clone().fold(f64::NEG_INFINITY, f64::max) - found.fold(f64::INFINITY, f64::min);
            let error = fits[0].coefficients[j].std_error.unwrap();
            assert!(spread <= 0.2 * error, "{m} nodes, coefficient {j}: {spread} of {error}");
        }
    }
}

/// `Σ_{i<j} |rᵢ − rⱼ| √12/(2(m + 1))`.
fn dispersion(r: &[f64]) -> f64 {
    let m = r.len();
    let sum: f64 = (0..m).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| (r[i] - r[j]).abs()).sum();
    12f64.sqrt() / (2.0 * (m + 1) as f64) * sum
}

#[test]
fn no_pair_of_pairs_does_better_than_the_rank_estimate() {
    for seed in 0..30 {
        let mut problem = Problem::new(300 + seed, 7, 3, seed % 2 == 0);
        if seed % 5 == 4 {
            // without a constant in the columns
            problem.x.iter_mut().for_each(|row| {
                row.remove(0);
            });
        }
        let from = if seed % 5 == 4 { 0 } else { 1 };
        let m = problem.y.len();
        let pairs: Vec<(usize, usize)> = (0..m).flat_map(|i| (0..i).map(move |j| (i, j))).collect();
        let mut least = f64::INFINITY;
        for (p, &(i, j)) in pairs.iter().enumerate() {
            for &(k, l) in &pairs[..p] {
                let row = |i: usize, j: usize| (from..from + 2).map(|c| problem.x[i][c] - problem.x[j][c]).collect();
                let right = vec![problem.y[i] - problem.y[j], problem.y[k] - problem.y[l]];
                let Some(a) = solve(vec![row(i, j), row(k, l)], right) else { continue };
                let a = if from == 1 { vec![0.0, a[0], a[1]] } else { a };
                least = least.min(dispersion(&problem.residuals(&a)));
            }
        }
        let spec =
            FitSpec { estimator: Estimator::Rank, regularization: Regularization::None, ..FitSpec::new(Model::Linear) };
        let Ok(result) = fit(&problem.nodes(), &spec) else {
            assert!(seed % 2 == 0);
            continue;
        };
        let robust = result.robust.as_ref().unwrap();
        let mut r = problem.residuals(&values(&result));
        near("dispersion", robust.objective, least, 1e-11);
        near("dispersion at the answer", dispersion(&r), least, 1e-11);
        assert!(robust.converged && robust.certificate.unwrap() <= 1.0 + 1e-9);
        if from == 1 {
            r.sort_by(f64::total_cmp);
            assert!(r[m / 2].abs() < 1e-10, "the median of the residuals is 0");
        }
    }
}

#[test]
fn the_rank_estimate_of_many_nodes_has_no_way_down() {
    for (m, n) in [(300, 4), (5000, 5)] {
        let problem = Problem::new(7, m, n, false);
        let result = problem.fit(Estimator::Rank);
        let robust = result.robust.as_ref().unwrap();
        println!("{m}: {} steps, certificate {:?}", robust.iterations, robust.certificate);
        assert!(robust.converged && robust.certificate.unwrap() <= 1.0 + 1e-8, "{robust:?}");
        let spread = |a: &[f64]| {
            let mut r = problem.residuals(a);
            r.sort_by(f64::total_cmp);
            r.iter().enumerate().map(|(i, r)| (2.0 * i as f64 + 1.0 - m as f64) * r).sum::<f64>()
        };
        let at = values(&result);
        let here = spread(&at);
        let mut random = Random::new(3);
        for step in [1e-2, 1e-4, 1e-6] {
            for _ in 0..50 {
                let moved: Vec<f64> = at.iter().map(|a| a + step * random.normal()).collect();
                assert!(spread(&moved) >= here * (1.0 - 1e-13));
            }
        }
    }
}

#[test]
fn lp_has_no_gradient_and_runs_from_absolute_deviations_to_squares() {
    for seed in 0..10 {
        let problem = Problem::new(500 + seed, 25, 3, false);
        for p in [1.0, 1.02, 1.1, 1.5, 1.9, 2.0] {
            let result = problem.fit(Estimator::Lp { p });
            let robust = result.robust.as_ref().unwrap();
            assert!(robust.converged, "{p}: {robust:?}");
            let r = problem.residuals(&values(&result));
            near("objective", robust.objective, r.iter().map(|r| r.abs().powf(p)).sum(), 1e-9);
            if p >= 1.1 {
                for j in 0..3 {
                    let slope: f64 =
                        r.iter().zip(&problem.x).map(|(r, x)| r.signum() * r.abs().powf(p - 1.0) * x[j]).sum();
                    let size: f64 = r.iter().zip(&problem.x).map(|(r, x)| (r.abs().powf(p - 1.0) * x[j]).abs()).sum();
                    // rounding moves tiny residuals by as much as they are, and for p near 1 these
                    // count
                    let unsure: f64 = r
                        .iter()
                        .zip(&problem.x)
                        .filter(|(r, _)| r.abs() < 1e-9)
                        .map(|(r, x)| (r.abs().powf(p - 1.0) * x[j]).abs())
                        .sum();
                    assert!(slope.abs() < 1e-7 * size + unsure, "p = {p}: {slope} of {size}, {unsure} unsure");
                }
            }
            if p == 2.0 {
                for c in &result.coefficients {
                    near("p = 2", c.value, c.least_squares, 1e-12);
                    near("its error", c.std_error.unwrap(), c.least_squares_std_error.unwrap(), 1e-9);
                }
            }
        }
    }
}

#[test]
fn reweighting_by_hand_ends_in_the_same_place() {
    for seed in 0..8 {
        let mut problem = Problem::new(700 + seed, 30, 3, false);
        problem.weight = Some((0..30).map(|k| 0.25 + (k % 4) as f64).collect());
        for loss in [Loss::HUBER, Loss::ANDREWS, Loss::Hampel { a: 1.0, b: 2.0, c: 9.0 }, Loss::Tukey { c: 6.0 }] {
            let asked = MEstimator { scale: ScaleRule::Fixed(1.5), ..MEstimator::new(loss) };
            let result = problem.fit(Estimator::M(asked));
            let robust = result.robust.as_ref().unwrap();
            let mut a = problem.least_squares(problem.weight.as_ref().unwrap()).unwrap();
            let mut total = Vec::new();
            for _ in 0..3000 {
                let r = problem.residuals(&a);
                total = r.iter().zip(problem.weight.as_ref().unwrap()).map(|(r, w)| w * loss.weight(r / 1.5)).collect();
                a = problem.least_squares(&total).unwrap();
            }
            for (got, wanted) in values(&result).iter().zip(&a) {
                near("coefficient", *got, *wanted, 1e-9);
            }
            for ((w, omega), node) in
                total.iter().zip(robust.weights.as_ref().unwrap()).zip(problem.weight.as_ref().unwrap())
            {
                assert!((w - node * omega).abs() < 1e-8);
            }
            // regularised: the same as the fit of the weighted nodes
            let weighted = Problem { x: problem.x.clone(), y: problem.y.clone(), weight: Some(total) };
            let parameter = Parameter::Fixed(0.05);
            let ridge = Regularization::Ridge { parameter };
            let together = problem.fit_with(Estimator::M(asked), ridge.clone());
            let apart = weighted.fit_with(Estimator::LeastSquares, ridge);
            for (got, wanted) in values(&together).iter().zip(values(&apart)) {
                near("regularised", *got, wanted, 1e-8);
            }
            for (got, wanted) in together.spectrum.eigenvalues.iter().zip(&apart.spectrum.eigenvalues) {
                near("eigenvalue", *got, *wanted, 1e-8);
            }
            near("bias", together.bias.norm, apart.bias.norm, 1e-7);
        }
    }
}

#[test]
fn every_estimator_is_equivariant_and_reproducible() {
    let problem = Problem::new(42, 40, 3, false);
    let shifted = Problem {
        x: problem.x.clone(),
        y: problem.x.iter().zip(&problem.y).map(|(x, y)| 4.0 * y + 7.0 * x[0] - 3.0 * x[2]).collect(),
        weight: None,
    };
    for estimator in estimators() {
        let (one, other) = (problem.fit(estimator), shifted.fit(estimator));
        assert_eq!(one, problem.fit(estimator));
        for (j, add) in [7.0, 0.0, -3.0].into_iter().enumerate() {
            let (a, b) = (&one.coefficients[j], &other.coefficients[j]);
            assert!((4.0 * a.value + add - b.value).abs() < 1e-6, "{estimator:?}: {} {}", a.value, b.value);
            near("standard error", b.std_error.unwrap(), 4.0 * a.std_error.unwrap(), 1e-6);
        }
        // scaling of columns changes nothing without regularisation, and standardised columns have
        // standard errors too
        for scaling in [Scaling::None, Scaling::Standardized] {
            let spec =
                FitSpec { estimator, scaling, regularization: Regularization::None, ..FitSpec::new(Model::Linear) };
            let again = fit(&problem.nodes(), &spec).unwrap();
            for (a, b) in one.coefficients.iter().zip(&again.coefficients) {
                near("value", b.value, a.value, 1e-9);
                near("standard error", b.std_error.unwrap(), a.std_error.unwrap(), 1e-8);
                near("least squares", b.least_squares, a.least_squares, 1e-9);
            }
        }
    }
}

#[test]
fn the_sign_of_the_heights_does_not_matter() {
    for (seed, m) in [(42, 40), (43, 41), (44, 17)] {
        let problem = Problem::new(seed, m, 3, false);
        let turned = Problem { x: problem.x.clone(), y: problem.y.iter().map(|y| -y).collect(), weight: None };
        for estimator in estimators().into_iter().filter(|estimator| !matches!(estimator, Estimator::Quantile { .. })) {
            let (one, other) = (problem.fit(estimator), turned.fit(estimator));
            for (a, b) in one.coefficients.iter().zip(&other.coefficients) {
                assert!((a.value + b.value).abs() < 1e-6, "{estimator:?}: {} {}", a.value, b.value);
                assert!(
                    (a.std_error.unwrap() / b.std_error.unwrap() - 1.0).abs() < 1e-6,
                    "{estimator:?}: {:?} {:?}",
                    a.std_error,
                    b.std_error
                );
            }
        }
    }
}

pub fn estimators() -> Vec<Estimator> {
    let m = |loss| Estimator::M(MEstimator::new(loss));
    vec![
        m(Loss::HUBER),
        m(Loss::TUKEY),
        Estimator::LeastAbsolute,
        Estimator::Lp { p: 1.3 },
        Estimator::Quantile { tau: 0.3 },
        Estimator::LeastTrimmed { coverage: 0.7, seed: 1 },
        Estimator::Rank,
        Estimator::NormalScores,
        Estimator::M(MEstimator::minimax(Contamination::Share(0.1))),
        Estimator::M(MEstimator::minimax(Contamination::Estimated)),
        Estimator::L(LEstimator::Trimmed { share: 0.15 }),
        Estimator::L(LEstimator::Winsorized { share: 0.15 }),
        Estimator::L(LEstimator::Quantiles(QuantileWeights::new(&[[0.25, 0.3], [0.5, 0.4], [0.75, 0.3]]).unwrap())),
        Estimator::Likelihood(Distribution::Student { freedom: Some(3.0) }),
        Estimator::Likelihood(Distribution::Student { freedom: None }),
        Estimator::Likelihood(Distribution::Laplace),
        Estimator::Likelihood(Distribution::GeneralizedNormal { exponent: Some(1.4) }),
        Estimator::Likelihood(Distribution::GeneralizedNormal { exponent: None }),
    ]
}

/// A thousand million products in each of its many steps.
#[test]
fn a_search_that_would_take_minutes_is_refused() {
    let axis: Vec<f64> = (0..56).map(f64::from).collect();
    let z = (0..3136).map(|k| f64::from(k * k % 101)).collect();
    let nodes = Nodes::grid(axis.clone(), axis, z, None, None).expect("a grid");
    let model = Model::Polynomial { degree: Degree::Both(23), basis: PolynomialBasis::Chebyshev, terms: Terms::Tensor };
    let estimator = Estimator::LeastTrimmed { coverage: 0.75, seed: 0 };
    let refused = fit(&nodes, &FitSpec { estimator, ..FitSpec::new(model) });
    let Err(FitError::Invalid(faults)) = refused else { panic!("it is taken") };
    let message = &faults.list()[0].message;
    assert!(
        message.starts_with("least trimmed squares of 3136 nodes and 576 coefficients takes too long"),
        "{message}"
    );
}
