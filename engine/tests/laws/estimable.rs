//! Sums that are known where coefficients are not, and B as a product, against plain normal
//! equations.

use crate::oracle::random::Random;
use flankfit_engine::estimation::{
    FitResult, FitSpec, Nodes, fit,
    spec::{
        Count, Criterion, Degree, Include, Model, Parameter, PolynomialBasis, Regularization, Scaling, Scheme, Terms,
    },
};

/// An entry of a matrix from rows of X and B.
type Entry<'a> = &'a dyn Fn(&[f64], &[f64], usize, usize) -> f64;

/// Columns of which the second is nearly the first, and the fourth nearly a mixture of the third
/// and the fifth.
fn rows(random: &mut Random) -> Vec<Vec<f64>> {
    (0..30)
        .map(|_| {
            let [a, b, c, d, e] = [(); 5].map(|()| random.normal());
            vec![a, 2.0 * a + 0.01 * b, c, c - 0.5 * d + 0.005 * e, d]
        })
        .collect()
}

fn fitted(x: &[Vec<f64>], y: &[f64]) -> FitResult {
    let include = Include { collinearity: true, ..Include::default() };
    let nodes = Nodes::matrix(x.concat(), x[0].len(), y.to_vec(), None, None).unwrap();
    fit(&nodes, &FitSpec { include, ..FitSpec::new(Model::Linear) }).unwrap()
}

/// (XᵀX)⁻¹ by elimination.
fn inverse(x: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = x[0].len();
    let mut a: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let sums = (0..n).map(|j| x.iter().map(|row| row[i] * row[j]).sum());
            sums.chain((0..n).map(|j| f64::from(u8::from(i == j)))).collect()
        })
        .collect();
    for k in 0..n {
        let pivot = a[k].clone();
        for (i, row) in a.iter_mut().enumerate() {
            let factor = if i == k { (row[k] - 1.0) / pivot[k] } else { row[k] / pivot[k] };
            row.iter_mut().zip(&pivot).for_each(|(r, p)| *r -= factor * p);
        }
    }
    a.into_iter().map(|row| row[n..].to_vec()).collect()
}

#[test]
fn sums_and_their_errors_are_those_of_least_squares() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let x = rows(&mut random);
        let y: Vec<f64> = x.iter().map(|row| row.iter().sum::<f64>() + 0.1 * random.normal()).collect();
        let found = fitted(&x, &y);
        let sums = found.estimable.as_ref().unwrap();
        // of five coefficients two sums are not known
        assert_eq!(sums.len(), 3, "{sums:?}");
        let covariance = inverse(&x);
        let place = |term: &String| found.coefficients.iter().position(|c| c.term == *term).unwrap();
        for sum in sums {
            let mut w = [0.0; 5];
            sum.terms.iter().zip(&sum.weights).for_each(|(term, weight)| w[place(term)] = *weight);
            let value: f64 = found.coefficients.iter().zip(&w).map(|(c, w)| w * c.least_squares).sum();
            assert!((sum.value - value).abs() < 1e-8 * (1.0 + value.abs()), "{} {value}", sum.value);
            let variance: f64 = (0..25).map(|k| w[k / 5] * covariance[k / 5][k % 5] * w[k % 5]).sum();
            let error = found.residuals.sigma.unwrap() * variance.sqrt();
            assert!((sum.std_error.unwrap() / error - 1.0).abs() < 1e-6, "{:?} {error}", sum.std_error);
            // far better known than the coefficients in it
            let worst = sum.terms.iter().map(|t| found.coefficients[place(t)].least_squares_std_error.unwrap());
            assert!(worst.fold(0.0, f64::max) > 10.0 * error, "{sum:?}");
            assert!(sum.weights.contains(&1.0) && (1.0..=30.0).contains(&sum.condition_index));
            assert!(sum.sentence.contains("cannot be separated") && sum.sentence.contains(&sum.terms[0]));
        }
    }
}

/// Raw powers far from 0: the sums keep their digits where the coefficients have none. Read as it
/// is printed, with the returned coefficients, a sentence is right to less than its own interval.
#[test]
fn sentences_are_true_as_printed() {
    let x: Vec<f64> = (0..41).map(|k| 30.0 + 0.1 * f64::from(k)).collect();
    let mut random = Random::new(5);
    let y: Vec<f64> = x.iter().map(|x| 0.01 * x + 0.001 * random.normal()).collect();
    let nodes = Nodes::curve(x, y, None).unwrap();
    for degree in [2, 3] {
        let include = Include { collinearity: true, ..Include::default() };
        let model =
            Model::Polynomial { degree: Degree::Both(degree), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
        let spec = FitSpec { include, regularization: Regularization::None, ..FitSpec::new(model) };
        let found = fit(&nodes, &spec).unwrap();
        let sums = found.estimable.as_ref().unwrap();
        assert!(!sums.is_empty());
        for sum in sums {
            let (_, equation) = sum.sentence.split_once("is determined: ").unwrap();
            let (left, right) =
                equation.replace('−', "-").split_once(" = ").map(|(l, r)| (l.to_owned(), r.to_owned())).unwrap();
            let (right, level) = right.split_once(" with ").unwrap();
            assert_eq!(level, "95 % confidence");
            let (value, half) = right.split_once(" ± ").unwrap();
            let (mut total, mut sign, mut weight) = (0.0, 1.0, 1.0);
            for word in left.split(' ') {
                match word {
                    "+" => sign = 1.0,
                    "-" => sign = -1.0,
                    _ if word.contains("A[") => {
                        let term = word.trim_start_matches(['-', 'A']).trim_matches(['[', ']']);
                        let own = found.coefficients.iter().find(|c| c.term == term).unwrap().least_squares;
                        total += sign * weight * own;
                        (sign, weight) = (1.0, 1.0);
                    }
                    number => weight = number.parse().unwrap(),
                }
            }
            let (value, half): (f64, f64) = (value.parse().unwrap(), half.parse().unwrap());
            assert!((total - value).abs() < half, "{}: {total}", sum.sentence);
        }
    }
}

#[test]
fn sums_cover_the_truth() {
    let x: Vec<Vec<f64>> = (0..24)
        .map(|i| {
            let t = 30.0 + f64::from(i) / 6.0;
            (0..5).map(|j| t.powi(j)).collect()
        })
        .collect();
    let truth = [3.0, -0.5, 0.02, 0.001, -2e-5];
    let (mut hits, mut all) = (0, 0);
    for seed in 0..150 {
        let mut random = Random::new(7_000 + seed);
        let y: Vec<f64> = x
            .iter()
            .map(|row| row.iter().zip(&truth).map(|(x, a)| x * a).sum::<f64>() + 0.01 * random.normal())
            .collect();
        for sum in fitted(&x, &y).estimable.unwrap() {
            let true_sum: f64 = sum.weights.iter().zip(&truth).map(|(w, a)| w * a).sum();
            let [low, high] = sum.interval.unwrap();
            (hits, all) = (hits + usize::from(low <= true_sum && true_sum <= high), all + 1);
        }
    }
    let share = f64::from(hits as u32) / f64::from(all as u32);
    assert!(all >= 150 && (0.92..0.98).contains(&share), "{share} of {all}");
}

#[test]
fn without_near_dependencies_or_unasked_there_are_none() {
    let mut random = Random::new(3);
    let x: Vec<Vec<f64>> = (0..20).map(|_| random.normals(3)).collect();
    let y = random.normals(20);
    assert!(fitted(&x, &y).estimable.is_none());
    let mut close = x.clone();
    close.iter_mut().for_each(|row| row[1] = row[0] + 1e-3 * row[1]);
    let nodes = Nodes::matrix(close.concat(), 3, y.clone(), None, None).unwrap();
    assert!(fit(&nodes, &FitSpec::new(Model::Linear)).unwrap().estimable.is_none());
    assert_eq!(fitted(&close, &y).estimable.unwrap().len(), 1);
}

/// Eqs. 28, 37, 38, 41, 42, 45 and 46 on matrices formed entry by entry.
#[test]
fn b_agrees_with_its_definition() {
    for (scheme, count) in [(Scheme::FirstOrder, 1), (Scheme::FirstOrder, 2), (Scheme::Exact, 2)] {
        let mut random = Random::new(11);
        let x = rows(&mut random);
        let y = random.normals(30);
        let nodes = Nodes::matrix(x.concat(), 5, y, None, None).unwrap();
        let regularization = Regularization::Spectral {
            scheme,
            count: Count::Given(count),
            condition_limit: 900.0,
            lambda_star: Parameter::Criterion(Criterion::MinCondition),
        };
        let include = Include { matrix_b: true, ..Include::default() };
        let spec = FitSpec { regularization, include, scaling: Scaling::None, ..FitSpec::new(Model::Linear) };
        let found = fit(&nodes, &spec).unwrap();
        let (b, factors) = (found.matrix_b.unwrap(), found.matrix_b_factors.unwrap());
        assert_eq!(factors.products.len(), count);
        for (k, row) in b.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let sum: f64 = factors.products.iter().map(|p| factors.e * p.q[k] * p.s[j]).sum();
                assert!((sum - entry).abs() < 1e-9 * (1.0 + entry.abs()), "{sum} {entry}");
            }
        }
        let gamma = found.regularization.gamma.unwrap();
        if scheme == Scheme::FirstOrder {
            let mu = gamma / (2.0 * factors.products[0].eigenvalue);
            assert!((factors.products[0].mu / mu - 1.0).abs() < 1e-12);
        }
        // Q = XV: as long as √λ; S = μV/e
        for p in &factors.products {
            let squares = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
            assert!((squares(&p.q) / p.eigenvalue - 1.0).abs() < 1e-8);
            assert!((squares(&p.s).sqrt() * factors.e / p.mu - 1.0).abs() < 1e-12);
        }
        let largest = |entry: Entry| {
            let of = |i: usize, j: usize| x.iter().zip(&b).map(|(x, b)| entry(x, b, i, j)).sum::<f64>();
            nalgebra::DMatrix::from_fn(5, 5, of).symmetric_eigen().eigenvalues.max()
        };
        let of_b = largest(&|_, b, i, j| b[i] * b[j]);
        let mixed = largest(&|x, b, i, j| x[i] * b[j] + b[i] * x[j]);
        assert!((factors.largest_eigenvalue / of_b - 1.0).abs() < 1e-8, "{} {of_b}", factors.largest_eigenvalue);
        assert!((factors.mixed_eigenvalue / mixed - 1.0).abs() < 1e-8, "{} {mixed}", factors.mixed_eigenvalue);
        assert!(factors.largest_eigenvalue <= factors.largest_eigenvalue_bound * (1.0 + 1e-12));
        assert!(factors.mixed_eigenvalue <= factors.mixed_eigenvalue_bound * (1.0 + 1e-12));
        assert!((factors.mixed_eigenvalue_bound / gamma - 1.0).abs() < 1e-12);
        // with equality for one eigenvalue (Eqs. 42 and 46)
        if count == 1 {
            assert!((factors.largest_eigenvalue / factors.largest_eigenvalue_bound - 1.0).abs() < 1e-12);
            assert!((factors.mixed_eigenvalue / factors.mixed_eigenvalue_bound - 1.0).abs() < 1e-12);
        }
    }
}
