//! The study against plain normal equations, and laws that its results obey.

use super::*;
use flankfit_numerics::{Dd, Rows};

fn setup() -> Setup {
    let x = (0..20)
        .map(|i| {
            let t = 0.5 + 0.1 * f64::from(i);
            vec![1.0, t, t * t]
        })
        .collect();
    Setup {
        x,
        coefficients: vec![1.0, -2.0, 0.5],
        noise_sigma: 0.1,
        levels: vec![0.0, 0.01, 0.3],
        repetitions: 40,
        seed: 11,
        scaling: ColumnScaling::None,
    }
}

fn vectors(rows: &Rows) -> Vec<Vec<f64>> {
    rows.iter().map(<[f64]>::to_vec).collect()
}

/// Changes the rows of a setup.
fn change_rows(setup: &mut Setup, change: impl FnOnce(&mut Vec<Vec<f64>>)) {
    let mut x = vectors(&setup.x);
    change(&mut x);
    setup.x = x.iter().collect();
}

fn study(change: impl FnOnce(&mut Setup)) -> Study {
    let mut setup = setup();
    change(&mut setup);
    Study::new(setup).unwrap()
}

/// (XᵀX)⁻¹Xᵀy and what belongs to it, in double-double by elimination.
struct Plain {
    a: Vec<f64>,
    determinant: f64,
}

fn plain(x: &[Vec<f64>], y: &[f64]) -> Plain {
    let n = x[0].len();
    let dot = |f: &dyn Fn(usize) -> f64, g: &dyn Fn(usize) -> f64| {
        (0..x.len()).fold(Dd::ZERO, |sum, i| sum + Dd::product(f(i), g(i)))
    };
    let mut a: Vec<Vec<Dd>> = (0..n)
        .map(|i| {
            let mut row: Vec<Dd> = (0..n).map(|j| dot(&|k| x[k][i], &|k| x[k][j])).collect();
            row.push(dot(&|k| x[k][i], &|k| y[k]));
            row
        })
        .collect();
    let mut determinant = Dd::ONE;
    for k in 0..n {
        let pivot = a[k].clone();
        determinant *= pivot[k];
        for (i, row) in a.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(&pivot).for_each(|(r, p)| *r -= factor * *p);
            assert!(i != k);
        }
    }
    Plain { a: (0..n).map(|i| (a[i][n] / a[i][i]).to_f64()).collect(), determinant: determinant.to_f64() }
}

/// One repetition, written out: the same draws, the estimate as a difference of vectors.
#[test]
fn a_level_agrees_with_its_definition() {
    let study = study(|s| (s.levels, s.repetitions) = (vec![0.2], 1));
    let result = run(&study).unwrap();
    let mut normals = normal::Normals::new(11, 0);
    let e: Vec<f64> = normals.take(20).iter().map(|g| 0.1 * g).collect();
    let g = normals.take(60);
    let setup = setup();
    let x = vectors(&setup.x);
    let (mean, m) = (|j: usize| x.iter().map(|row| row[j]).sum::<f64>() / 20.0, 20.0);
    let deviation: Vec<f64> =
        (0..3).map(|j| (x.iter().map(|row| (row[j] - mean(j)).powi(2)).sum::<f64>() / m).sqrt()).collect();
    let randomised: Vec<Vec<f64>> = (0..20)
        .map(|i| (0..3).map(|j| x[i][j] + if j == 0 { 0.0 } else { 0.2 * deviation[j] * g[3 * i + j] }).collect())
        .collect();
    let predict = |x: &[Vec<f64>], a: &[f64]| -> Vec<f64> {
        x.iter().map(|row| row.iter().zip(a).map(|(x, a)| x * a).sum()).collect()
    };
    let y: Vec<f64> = predict(&x, &setup.coefficients).iter().zip(&e).map(|(y, e)| y + e).collect();
    let solved = plain(&randomised, &y);
    let close = |got: Option<Summary>, want: f64| {
        let got = got.unwrap().median;
        assert!((got - want).abs() <= 1e-9 * want.abs(), "{got} {want}");
    };
    let results = &result.levels[0].results;
    let squares = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    close(results.bias_norm_squared, squares(&solved.a, &setup.coefficients));
    close(results.rss, squares(&y, &predict(&x, &solved.a)));
    close(result.levels[0].fitted_rss, squares(&y, &predict(&randomised, &solved.a)));
    close(results.log10_determinant, solved.determinant.log10());
    let least_squares = plain(&x, &y);
    let reference = &result.references.least_squares;
    close(reference.bias_norm_squared, squares(&least_squares.a, &setup.coefficients));
    close(reference.rss, squares(&y, &predict(&x, &least_squares.a)));
    close(reference.log10_determinant, least_squares.determinant.log10());
    // ridge with k: (XᵀX + kI) a = Xᵀy is least squares with √k I below
    for choice in &result.references.ridge.choices {
        let k = choice.chosen.lambda_star.unwrap().median;
        let mut below = x.clone();
        (0..3).for_each(|j| below.push((0..3).map(|i| if i == j { k.sqrt() } else { 0.0 }).collect()));
        let mut z = y.clone();
        z.extend([0.0; 3]);
        let ridge = plain(&below, &z);
        close(choice.chosen.results.bias_norm_squared, squares(&ridge.a, &setup.coefficients));
        close(choice.chosen.results.rss, squares(&y, &predict(&x, &ridge.a)));
        close(choice.chosen.results.log10_determinant, ridge.determinant.log10());
    }
    assert_eq!(result.references.ridge.choices.len(), 4, "every criterion but min_condition");
}

#[test]
fn level_0_is_least_squares() {
    let result = run(&study(|_| ())).unwrap();
    let (level, reference) = (&result.levels[0].results, &result.references.least_squares);
    for (a, b) in [
        (level.condition, reference.condition),
        (level.log10_determinant, reference.log10_determinant),
        (level.bias_norm_squared, reference.bias_norm_squared),
        (level.rss, reference.rss),
    ] {
        let (a, b) = (a.unwrap(), b.unwrap());
        assert!(
            [(a.median, b.median), (a.q1, b.q1), (a.q3, b.q3)].iter().all(|(a, b)| (a - b).abs() <= 1e-8 * b.abs())
        );
    }
}

/// B formed as a matrix from the eigenvectors of XᵀX, its columns measured, and least squares on
/// X + B by normal equations.
#[test]
fn the_matrix_b_of_a_level_has_that_level() {
    let study = study(|s| (s.levels, s.repetitions) = (vec![0.02], 1));
    let result = run(&study).unwrap();
    let found = result.levels[0].matrix_b.as_ref().unwrap();
    let x = setup().x;
    let gram = nalgebra::DMatrix::from_fn(3, 3, |i, j| x.iter().map(|row| row[i] * row[j]).sum::<f64>());
    let eigen = gram.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut b = vec![vec![0.0; 3]; 20];
    for (i, &lambda) in eigen.eigenvalues.iter().enumerate() {
        if largest / lambda > 900.0 && lambda < found.lambda_star {
            let c = (found.lambda_star - lambda) / (2.0 * lambda);
            let v = eigen.eigenvectors.column(i);
            for (b, row) in b.iter_mut().zip(x.iter()) {
                let along: f64 = row.iter().zip(v.iter()).map(|(x, v)| x * v).sum();
                (0..3).for_each(|j| b[j] += c * along * v[j]);
            }
        }
    }
    let mean = |f: &dyn Fn(usize) -> f64| (0..20).map(f).sum::<f64>() / 20.0;
    let squares = [1, 2].map(|j| {
        let middle = mean(&|k| x[k][j]);
        mean(&|k| b[k][j].powi(2)) / mean(&|k| (x[k][j] - middle).powi(2))
    });
    assert!(((0.5 * (squares[0] + squares[1])).sqrt() / 0.02 - 1.0).abs() < 1e-8, "{squares:?}");
    let e: Vec<f64> = normal::Normals::new(11, 0).take(20).iter().map(|g| 0.1 * g).collect();
    let y: Vec<f64> = x.iter().zip(&e).map(|(row, e)| row[0] - 2.0 * row[1] + 0.5 * row[2] + e).collect();
    let regular: Vec<Vec<f64>> = x.iter().zip(&b).map(|(x, b)| x.iter().zip(b).map(|(x, b)| x + b).collect()).collect();
    let solved = plain(&regular, &y);
    let error: f64 = solved.a.iter().zip([1.0, -2.0, 0.5]).map(|(a, b)| (a - b).powi(2)).sum();
    let got = found.results.bias_norm_squared.unwrap().median;
    assert!((got / error - 1.0).abs() < 1e-7, "{got} {error}");
    let determinant = found.results.log10_determinant.unwrap().median;
    assert!((determinant - solved.determinant.log10()).abs() < 1e-8);
    // a reference says the level of its own λ*, which leads back to it
    let choice = &result.references.spectral_first_order.as_ref().unwrap().choices[0];
    let level = choice.chosen.noise_to_signal.unwrap().median;
    let again = run(&self::study(|s| (s.levels, s.repetitions) = (vec![level], 1))).unwrap();
    let lambda_star = again.levels[0].matrix_b.as_ref().unwrap().lambda_star;
    assert!((lambda_star / choice.chosen.lambda_star.unwrap().median - 1.0).abs() < 1e-9);
    assert!(run(&self::study(|s| s.levels = vec![1e9])).unwrap().levels[0].matrix_b.is_none());
}

/// The paper's figures: an involute section over 30 to 34 mm in micrometres, degree 6.
#[test]
fn the_papers_headline_is_reached_where_the_coefficients_lie_along_v1() {
    // involute of the base circle of 31 teeth, module 2 mm, 20°, from the roots of x(t) = x
    let base = 31.0 * 20f64.to_radians().cos();
    let height = |x: f64| {
        let [t, _] = flankfit_numerics::root::boundary([0.0, 1.0], 0.0, |t| base * (t.cos() + t * t.sin()) < x);
        1000.0 * base * (t.sin() - t * t.cos())
    };
    let xs: Vec<f64> = (0..41).map(|i| 30.0 + 0.1 * f64::from(i)).collect();
    let model = crate::spec::Model::Polynomial {
        degree: crate::spec::Degree::Both(6),
        basis: crate::spec::PolynomialBasis::Monomial,
        terms: crate::spec::Terms::Tensor,
    };
    let nodes = crate::Nodes::curve(xs.clone(), xs.iter().map(|x| height(*x)).collect(), None).unwrap();
    let measured = Measured::new(&nodes, &crate::FitSpec::new(model)).unwrap();
    let setup = Setup {
        x: measured.x,
        coefficients: measured.coefficients,
        noise_sigma: 1.1,
        levels: vec![1e-9, 2e-5],
        repetitions: 100,
        seed: 3,
        scaling: ColumnScaling::UnitLength,
    };
    let found = run(&Study::new(setup).unwrap()).unwrap();
    let optimum = found.optimum.unwrap();
    assert_eq!((optimum.best.level, optimum.plateau, optimum.least_condition.level), (2e-5, [2e-5; 2], 2e-5));
    let ratios = optimum.best;
    assert!((3.8..6.0).contains(&ratios.error_ratio.sqrt()), "{ratios:?}");
    assert!((7e8..1e9).contains(&ratios.condition_ratio.unwrap()), "{ratios:?}");
    assert!((1.2..1.5).contains(&ratios.rss_ratio.unwrap()), "{ratios:?}");
    assert!((0.9997..0.9998).contains(&found.along_smallest.unwrap()));
    // what is left of the error is A itself
    let error = found.levels[1].results.bias_norm_squared.unwrap().median;
    assert!((error / found.coefficient_norm_squared - 1.0).abs() < 1e-2);
}

#[test]
fn the_plateau_ends_where_the_error_leaves_five_percent() {
    let result = run(&study(|s| s.levels = vec![0.3, 0.001, 0.0001, 0.003, 0.01, 1.0])).unwrap();
    let optimum = result.optimum.unwrap();
    let error = |level: f64| {
        let found = result.levels.iter().find(|l| l.level == level).unwrap();
        found.results.bias_norm_squared.unwrap().median.sqrt()
    };
    let ascending = [0.0001, 0.001, 0.003, 0.01, 0.3, 1.0];
    let least = ascending.iter().map(|k| error(*k)).fold(f64::INFINITY, f64::min);
    assert_eq!(error(optimum.best.level), least);
    let [low, high] = optimum.plateau;
    for (at, k) in ascending.iter().enumerate() {
        let on = (low..=high).contains(k);
        let beside = at > 0 && ascending[at - 1] == high || at < 5 && ascending[at + 1] == low;
        assert!(!on || error(*k) <= 1.05 * least, "{k}");
        assert!(!beside || error(*k) > 1.05 * least, "{k}");
    }
    assert!(optimum.least_condition.condition_ratio >= optimum.best.condition_ratio);
}

#[test]
fn equal_seeds_give_equal_studies_whatever_the_threads() {
    let result = run(&study(|_| ())).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| run(&study(|_| ())).unwrap()), result);
    assert_ne!(run(&study(|s| s.seed = 12)).unwrap(), result);
    // further levels and repetitions do not change what the others draw
    let fewer = run(&study(|s| s.levels = vec![0.3])).unwrap();
    assert_eq!(fewer.levels[0], result.levels[2]);
}

#[test]
fn a_study_in_parts_may_be_larger_than_one_at_once() {
    let mut large = setup();
    large.repetitions = 10_001;
    assert!(Study::new(large.clone()).is_err());
    let whole = Study::in_parts(large.clone()).unwrap();
    let last = repetitions(&whole, 9_999..10_001).unwrap();
    assert!(last.len() == 2 && last[0] != last[1] && last.iter().all(|outcome| whole.takes(outcome)));
    // what a repetition draws does not hang on how many there are
    assert_eq!(repetitions(&whole, 37..40).unwrap(), repetitions(&study(|_| ()), 37..40).unwrap());
    assert!(!study(|s| s.levels = vec![0.3]).takes(&last[0]));
    large.repetitions = 10_000_001;
    assert!(Study::in_parts(large).is_err());
}

/// Columns so close that doubles cannot hold their difference from dependence to any digit.
#[test]
fn near_dependence_keeps_its_digits() {
    let x: Vec<Vec<f64>> = (0..12)
        .map(|i| {
            let t = f64::from(i) - 5.5;
            vec![t, t + 1e-9 * f64::from(i % 3 - 1)]
        })
        .collect();
    let a = vec![1.0, 1.0];
    let result = run(&study(|s| {
        (s.x, s.coefficients, s.levels, s.repetitions) = (x.iter().collect(), a.clone(), vec![0.0], 3);
    }))
    .unwrap();
    // in double-double: det and trace of XᵀX
    let dot = |i: usize, j: usize| x.iter().fold(Dd::ZERO, |sum, row| sum + Dd::product(row[i], row[j]));
    let determinant = (dot(0, 0) * dot(1, 1) - dot(0, 1) * dot(0, 1)).to_f64();
    let trace = (dot(0, 0) + dot(1, 1)).to_f64();
    let condition = trace * trace / determinant;
    let got = result.levels[0].results.condition.unwrap().median;
    assert!((got / condition - 1.0).abs() < 1e-9, "{got:e} {condition:e}");
    let base = result.references.least_squares.condition.unwrap().median;
    assert!((base / condition - 1.0).abs() < 1e-9, "{base:e} {condition:e}");
    let (level, reference) = (&result.levels[0].results, &result.references.least_squares);
    let (p, q) = (level.bias_norm_squared.unwrap().median, reference.bias_norm_squared.unwrap().median);
    assert!((p / q - 1.0).abs() < 1e-8, "{p:e} {q:e}");
    assert!(result.along_smallest.unwrap() < 1e-8 && result.smallest_correlation.unwrap() > 0.999_999);
}

#[test]
fn dependent_columns_are_reported() {
    let result = run(&study(|s| change_rows(s, |x| x.iter_mut().for_each(|row| row[2] = 2.0 * row[1])))).unwrap();
    assert!(result.references.spectral_exact.is_none() && result.references.least_squares.condition.is_none());
    assert!(result.levels[0].results.condition.is_none() && result.levels[2].results.condition.is_some());
    assert!(result.references.least_squares.bias_norm_squared.is_some());
    let codes: Vec<_> = result.warnings.iter().map(|w| w.code()).collect();
    assert_eq!(codes, ["dependent_columns", "rank_deficient"]);
}

#[test]
fn unit_length_takes_units_away() {
    let scaled = |factor: f64| {
        run(&study(|s| {
            s.scaling = ColumnScaling::UnitLength;
            change_rows(s, |x| x.iter_mut().for_each(|row| row[2] *= factor));
            s.coefficients[2] /= factor;
        }))
        .unwrap()
    };
    let (a, b) = (scaled(1.0), scaled(1024.0));
    let median = |r: &StudyResult| r.levels[2].results.bias_norm_squared.unwrap().median;
    assert!((median(&a) / median(&b) - 1.0).abs() < 1e-9);
}

/// In unit columns a coefficient is as long as its column was: what leaves double precision by that
/// is the column's fault, and a coefficient's own is its own.
#[test]
fn overflow_from_column_lengths_is_reported_at_x() {
    let fields = |change: fn(&mut Setup)| -> Vec<String> {
        let mut setup = setup();
        setup.scaling = ColumnScaling::UnitLength;
        change(&mut setup);
        Study::new(setup).unwrap_err().list().iter().map(|fault| fault.path.clone()).collect()
    };
    assert_eq!(fields(|s| change_rows(s, |x| x[0][0] = 1e300)), ["x"]);
    assert_eq!(fields(|s| s.coefficients[1] = 1e200), ["coefficients[1]"]);
}

#[test]
fn impossible_studies_are_refused_by_field() {
    type Change = fn(&mut Setup);
    let cases: [(Change, &str); 10] = [
        (|s| s.x = Rows::default(), "x"),
        (|s| change_rows(s, |x| x[4] = vec![1.0]), "x[4]"),
        (|s| change_rows(s, |x| x.truncate(2)), "x"),
        (|s| s.coefficients = vec![1.0], "coefficients"),
        (|s| s.noise_sigma = -1.0, "noise_sigma"),
        (|s| s.levels.clear(), "levels"),
        (|s| s.levels[1] = -0.1, "levels[1]"),
        (|s| s.repetitions = 0, "repetitions"),
        (|s| s.repetitions = 10_001, "repetitions"),
        (|s| (s.repetitions, s.x) = (10_000, vec![[1.0, 2.0, 3.0]; 1200].iter().collect()), "repetitions"),
    ];
    for (change, field) in cases {
        let mut setup = setup();
        change(&mut setup);
        let faults = Study::new(setup).unwrap_err();
        assert_eq!(faults.list()[0].path, field);
    }
}
