//! Influence of single nodes: deletion figures equal refits without the node, the penalty held.

use crate::oracle::random::Random;
use crate::problems::{Problem, assert_close, by, config, fit, linear, matrix, polynomial, spectral, warned};
use flankfit_engine::estimation::{
    FitResult, Nodes,
    result::{Influence, Warning},
    spec::{
        Attraction, Count, Criterion, Degree, Estimator, FitSpec, Include, JamesStein, Parameter, PolynomialBasis,
        Regularization, Scaling, Scheme, ShrinkageFactor, Tikhonov,
    },
};
use nalgebra::{DMatrix, DVector, SVD};
use proptest::prelude::*;

fn with_influence(spec: FitSpec) -> FitSpec {
    FitSpec { include: Include { influence: true, residuals: true, ..Include::default() }, ..spec }
}

fn of(result: &FitResult) -> &Influence {
    result.influence.as_ref().unwrap_or_else(|| panic!("{:?}", result.warnings))
}

/// A penalised least-squares problem `‖y − X c‖² + ‖P c − t‖²` and what its solution leaves of the
/// heights, by a QR of the stacked matrix.
struct Penalised {
    x: DMatrix<f64>,
    y: DVector<f64>,
    p: DMatrix<f64>,
    t: DVector<f64>,
}

impl Penalised {
    /// Fitted heights of all nodes, where `without` takes no part.
    fn fitted(&self, without: Option<usize>) -> DVector<f64> {
        let kept: Vec<usize> = (0..self.x.nrows()).filter(|&k| Some(k) != without).collect();
        let (m, rows, n) = (kept.len(), self.p.nrows(), self.x.ncols());
        let stacked =
            DMatrix::from_fn(m + rows, n, |i, j| if i < m { self.x[(kept[i], j)] } else { self.p[(i - m, j)] });
        let heights = DVector::from_fn(m + rows, |i, _| if i < m { self.y[kept[i]] } else { self.t[i - m] });
        let qr = stacked.qr();
        let c = qr.r().solve_upper_triangular(&(qr.q().transpose() * heights)).unwrap();
        &self.x * c
    }
}

/// Columns along the eigenvectors of `x` (in columns of unit length), those with f = 0 left out,
/// and the penalty that makes the filter factors.
fn filtered(x: &DMatrix<f64>, y: &DVector<f64>, factors: &[f64]) -> Penalised {
    let scaled = DMatrix::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)] / x.column(j).norm());
    let svd = SVD::new(scaled.clone(), false, true);
    let v = svd.v_t.unwrap().transpose();
    let mut order: Vec<usize> = (0..x.ncols()).collect();
    order.sort_by(|&i, &j| svd.singular_values[i].total_cmp(&svd.singular_values[j]));
    let kept: Vec<(usize, f64)> = order.into_iter().zip(factors.iter().copied()).filter(|(_, f)| *f > 0.0).collect();
    let columns: Vec<DVector<f64>> = kept.iter().map(|&(i, _)| &scaled * v.column(i)).collect();
    let root = |&(i, f): &(usize, f64)| svd.singular_values[i] * (1.0 / f - 1.0).max(0.0).sqrt();
    Penalised {
        x: DMatrix::from_columns(&columns),
        y: y.clone(),
        p: DMatrix::from_diagonal(&DVector::from_iterator(kept.len(), kept.iter().map(root))),
        t: DVector::zeros(kept.len()),
    }
}

/// Every deletion result, compared with refits.
fn compare(what: &str, result: &FitResult, weight: &[f64], oracle: &Penalised, slack: f64) {
    let found = of(result);
    let (m, all) = (oracle.y.len(), oracle.fitted(None));
    let sigma = result.residuals.sigma.unwrap();
    let total: f64 = found.leverage.iter().sum();
    let size = oracle.y.amax();
    let mut press = 0.0;
    for k in 0..m {
        let without = oracle.fitted(Some(k));
        let deleted = oracle.y[k] - without[k];
        press += deleted * deleted;
        let root = weight[k].sqrt();
        assert_close(
            &format!("{what}: deleted {k}"),
            found.press_residual[k].unwrap() * root,
            deleted,
            slack,
            slack * size,
        );
        let moved = (&all - &without).norm_squared() / (sigma * sigma * total);
        assert_close(
            &format!("{what}: Cook {k}"),
            found.cooks_distance.as_ref().unwrap()[k].unwrap(),
            moved,
            1e-7,
            1e-9,
        );
    }
    assert_close(&format!("{what}: press"), found.press.unwrap(), press, 10.0 * slack, slack * size * size);
}

proptest! {
    #![proptest_config(config(48))]

    #[test]
    fn deletion_figures_are_refits_with_the_penalty_held(
        seed: u64, n in 2usize..7, extra in 3usize..14, log_condition in 0.0f64..5.0, weighted: bool,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let m = n + extra;
        let mut random = Random::new(seed);
        let weight: Vec<f64> = (0..m).map(|_| if weighted { random.between(0.1, 9.0) } else { 1.0 }).collect();
        let nodes = matrix(&problem.x, &problem.y, weighted.then(|| weight.clone()));
        let x = DMatrix::from_fn(m, n, |i, j| weight[i].sqrt() * problem.x[i][j]);
        let y = DVector::from_fn(m, |i, _| weight[i].sqrt() * problem.y[i]);
        for regularization in [
            Regularization::None,
            spectral(Scheme::FirstOrder, Count::Given(1), by(Criterion::MinMse)),
            spectral(Scheme::Exact, Count::Given(n - 1), by(Criterion::Gcv)),
            Regularization::Ridge { parameter: by(Criterion::MinMse) },
            Regularization::TruncatedSvd { rank: n - 1 },
        ] {
            let what = format!("{regularization:?}");
            let result = fit(&nodes, &with_influence(FitSpec { regularization, ..linear() }));
            let oracle = filtered(&x, &y, &result.regularization.filter_factors);
            compare(&what, &result, &weight, &oracle, 1e-10);
        }
        // towards a target: K = k XᵀX
        let target: Vec<f64> = (0..n).map(|_| random.normal()).collect();
        let attraction =
            Regularization::Attraction(Attraction { target: target.clone(), parameter: Parameter::Fixed(0.7) });
        let result = fit(&nodes, &with_influence(FitSpec { regularization: attraction, ..linear() }));
        let root = 0.7f64.sqrt();
        let toward = root * &x * DVector::from_vec(target);
        let oracle = Penalised { p: root * &x, t: toward, x: x.clone(), y: y.clone() };
        compare("attraction", &result, &weight, &oracle, 1e-10);
        if n >= 3 {
            let shrunk = JamesStein { factor: ShrinkageFactor::JamesStein, positive_part: true, target: None };
            let spec = FitSpec { regularization: Regularization::JamesStein(shrunk), ..linear() };
            let result = fit(&nodes, &with_influence(spec));
            let c = result.regularization.shrinkage_factor.unwrap();
            if c > 1e-3 {
                let p = (1.0 / c - 1.0).sqrt() * &x;
                let oracle = Penalised { t: DVector::zeros(m), p, x: x.clone(), y: y.clone() };
                compare("James-Stein", &result, &weight, &oracle, 1e-10);
            }
        }
        // squared differences of neighbouring coefficients
        let penalty = Tikhonov { order: 1, weights: None, parameter: Parameter::Fixed(1e-3) };
        let result =
            fit(&nodes, &with_influence(FitSpec { regularization: Regularization::Tikhonov(penalty), ..linear() }));
        let p = DMatrix::from_fn(n - 1, n, |i, j| {
            1e-3f64.sqrt() * if j == i { -1.0 } else if j == i + 1 { 1.0 } else { 0.0 }
        });
        compare("Tikhonov", &result, &weight, &Penalised { t: DVector::zeros(n - 1), p, x, y }, 1e-10);
    }
}

/// Standardised columns: the constant is not penalised, and the others as all nodes scaled them.
#[test]
fn standardised_ridge_holds_its_scales() {
    let x: Vec<Vec<f64>> = (0..14).map(|k| vec![1.0, f64::from(k), f64::from(k * k % 7)]).collect();
    let y: Vec<f64> = (0..14).map(|k| f64::from(k * 5 % 11) + 0.3 * f64::from(k)).collect();
    let spec = FitSpec {
        scaling: Scaling::Standardized,
        regularization: Regularization::Ridge { parameter: Parameter::Fixed(2.0) },
        ..linear()
    };
    let result = fit(&matrix(&x, &y, None), &with_influence(spec));
    let deviation = |j: usize| {
        let mean = x.iter().map(|row| row[j]).sum::<f64>() / 14.0;
        (x.iter().map(|row| (row[j] - mean).powi(2)).sum::<f64>() / 14.0).sqrt()
    };
    let p = DMatrix::from_row_slice(2, 3, &[0.0, deviation(1), 0.0, 0.0, 0.0, deviation(2)]) * 2f64.sqrt();
    let x = DMatrix::from_fn(14, 3, |i, j| x[i][j]);
    compare("ridge", &result, &[1.0; 14], &Penalised { x, y: DVector::from_vec(y), p, t: DVector::zeros(2) }, 1e-10);
}

/// A grid with holes: entries are those of the residuals, and the sum of the leverages is n.
#[test]
fn entries_belong_to_the_counted_nodes() {
    let (u, v): (Vec<f64>, Vec<f64>) = ((0..7).map(f64::from).collect(), (0..6).map(f64::from).collect());
    let z: Vec<f64> = (0..42).map(|k| f64::from(k * 17 % 23)).collect();
    let mut valid = vec![true; 42];
    valid[5] = false;
    valid[17] = false;
    let spec = with_influence(FitSpec {
        regularization: Regularization::None,
        ..polynomial(Degree::Each(2, 1), PolynomialBasis::Monomial)
    });
    let holed = fit(&Nodes::grid(u.clone(), v.clone(), z.clone(), Some(valid), None).unwrap(), &spec);
    let found = of(&holed);
    assert_eq!(found.node_indices, holed.residuals.node_indices);
    assert_eq!(found.leverage.len(), 40);
    assert_close("Σh", found.leverage.iter().sum(), 6.0, 1e-13, 0.0);
    let full = fit(&Nodes::grid(u, v, z, None, None).unwrap(), &spec);
    assert_eq!(of(&full).node_indices, None);
    for (k, r) in of(&full).press_residual.iter().enumerate() {
        let own = full.residuals.values.as_ref().unwrap()[k] / (1.0 - of(&full).leverage[k]);
        assert_close("r/(1 − h)", r.unwrap(), own, 1e-12, 0.0);
    }
}

#[test]
fn a_node_that_alone_determines_a_coefficient() {
    // the third column is the fourth node's own
    let x: Vec<Vec<f64>> = (0..6).map(|k| vec![1.0, f64::from(k), f64::from(u8::from(k == 3))]).collect();
    let y = vec![0.1, 0.9, 2.2, 9.0, 3.9, 5.1];
    let plain = FitSpec { regularization: Regularization::None, ..linear() };
    let result = fit(&matrix(&x, &y, None), &with_influence(plain.clone()));
    let found = of(&result);
    assert!((found.leverage[3] - 1.0).abs() < 1e-14);
    assert!(warned(&result, "full_leverage") && found.press.is_none());
    for list in [&found.internally_studentized, &found.externally_studentized, &found.cooks_distance, &found.dffits] {
        let list = list.as_ref().unwrap();
        assert!(list[3].is_none() && (0..6).filter(|k| *k != 3).all(|k| list[k].is_some()));
    }
    assert!(found.press_residual[3].is_none());
    // a penalty determines it, and the σ̂ of the others stays that of all
    let ridge = FitSpec { regularization: Regularization::Ridge { parameter: Parameter::Fixed(0.1) }, ..linear() };
    let result = fit(&matrix(&x, &y, None), &with_influence(ridge));
    let found = of(&result);
    assert!(found.leverage[3] < 0.99 && found.press.is_some());
    let (own, other) = (found.internally_studentized.as_ref().unwrap(), found.externally_studentized.as_ref().unwrap());
    assert_close("σ̂", own[3].unwrap(), other[3].unwrap(), 1e-12, 0.0);
    // as many nodes as coefficients: nothing can be said of any
    let x: Vec<Vec<f64>> = (0..3).map(|k| vec![1.0, f64::from(k), f64::from(k * k)]).collect();
    let result = fit(&matrix(&x, &[1.0, 4.0, 2.0], None), &with_influence(plain.clone()));
    let found = of(&result);
    assert!(found.internally_studentized.is_none() && found.dffits.is_none() && found.press.is_none());
    // one degree of freedom: no σ̂ without a node
    let x: Vec<Vec<f64>> = (0..4).map(|k| vec![1.0, f64::from(k), f64::from(k * k)]).collect();
    let result = fit(&matrix(&x, &[1.0, 4.0, 2.0, 5.0], None), &with_influence(plain));
    let found = of(&result);
    assert!(found.internally_studentized.is_some() && found.externally_studentized.is_none());
}

/// Without one node the others lie on the line: how far it lies from them is not measured in units
/// of a σ̂ that is rounding.
#[test]
fn an_exact_fit_of_the_others_has_no_spread() {
    let x: Vec<Vec<f64>> = (0..4).map(|k| vec![1.0, f64::from(k)]).collect();
    let plain = FitSpec { regularization: Regularization::None, ..linear() };
    for weight in [1.0, 1e-200] {
        let nodes = matrix(&x, &[2.0, 3.0, 4.0, 7.0], Some(vec![weight; 4]));
        let result = fit(&nodes, &with_influence(plain.clone()));
        let found = of(&result);
        for list in [&found.externally_studentized, &found.dffits] {
            let list = list.as_ref().unwrap();
            assert!(list[3].is_none() && list[..3].iter().all(Option::is_some), "{list:?}");
        }
        let named = Warning::NoNoiseWithout { nodes: vec![3], count: 1 };
        assert!(result.warnings.contains(&named), "{:?}", result.warnings);
        assert!(found.leverage.iter().all(|h| *h <= 1.0));
    }
}

/// A node that alone is off is named, since its own figures are null; and so it is said where
/// every height is fitted exactly.
#[test]
fn figures_without_any_noise_are_warned_of() {
    let x: Vec<Vec<f64>> = (0..10).map(|k| vec![1.0, f64::from(k)]).collect();
    let plain = FitSpec { regularization: Regularization::None, ..linear() };
    let mut y = vec![0.0; 10];
    let result = fit(&matrix(&x, &y, None), &with_influence(plain.clone()));
    let warning = |result: &FitResult| {
        let mut of = result.warnings.iter().filter(|w| w.code() == "no_noise_without");
        of.next().map(|w| w.to_string())
    };
    assert!(warning(&result).unwrap().starts_with("every height is fitted exactly"), "{:?}", result.warnings);
    let found = of(&result);
    for list in [&found.internally_studentized, &found.externally_studentized, &found.cooks_distance, &found.dffits] {
        assert!(list.as_ref().unwrap().iter().all(Option::is_none), "{list:?}");
    }
    y[4] = 5.0;
    let result = fit(&matrix(&x, &y, None), &with_influence(plain.clone()));
    assert!(warning(&result).unwrap().starts_with("without 1 node (node 4) the others"), "{:?}", result.warnings);
    let found = of(&result);
    assert!(found.externally_studentized.as_ref().unwrap()[4].is_none() && found.press_residual[4].is_some());
    y[7] = -0.01;
    let result = fit(&matrix(&x, &y, None), &with_influence(plain));
    assert!(warning(&result).is_none() && of(&result).dffits.as_ref().unwrap()[4].is_some());
}

#[test]
fn missing_influences_are_warned_of() {
    let x: Vec<Vec<f64>> = (0..9).map(|k| vec![1.0, f64::from(k), 2.0 * f64::from(k)]).collect();
    let y: Vec<f64> = (0..9).map(|k| f64::from(k * 4 % 7)).collect();
    let dependent = FitSpec { regularization: Regularization::TruncatedSvd { rank: 2 }, ..linear() };
    let result = fit(&matrix(&x, &y, None), &with_influence(dependent));
    assert!(result.influence.is_none() && warned(&result, "no_influence"));
    let x: Vec<Vec<f64>> = (0..9).map(|k| vec![1.0, f64::from(k)]).collect();
    let robust = FitSpec { estimator: Estimator::LeastAbsolute, regularization: Regularization::None, ..linear() };
    let result = fit(&matrix(&x, &y, None), &with_influence(robust));
    assert!(result.influence.is_none() && warned(&result, "no_influence"));
}
