//! Data at the edge of what doubles hold: an answer that is right, or a refusal, never zeros that
//! look like one.

use flankfit_engine::estimation::spec::{
    Degree, FitSpec, Model, Parameter, PolynomialBasis, Regularization, Scaling, Terms,
};
use flankfit_engine::estimation::{FitError, Nodes, fit};

fn polynomial(degree: usize, basis: PolynomialBasis) -> FitSpec {
    FitSpec::new(Model::Polynomial { degree: Degree::Both(degree), basis, terms: Terms::Tensor })
}

/// T₂ is constant on x = ±1: it must not take the slope with it. Two levels, means 2 and 4.5: slope
/// 1.25, RSS 2.5.
#[test]
fn a_column_that_is_constant_in_effect_leaves_the_others_alone() {
    let nodes = Nodes::curve(vec![-1., -1., -1., 1., 1.], vec![1., 2., 3., 5., 4.], None).unwrap();
    for basis in [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre] {
        let mut spec = polynomial(2, basis);
        spec.scaling = Scaling::Standardized;
        spec.regularization = Regularization::Ridge { parameter: Parameter::Fixed(1e-12) };
        let result = fit(&nodes, &spec).unwrap();
        assert!((result.coefficients[1].value - 1.25).abs() < 1e-9, "{basis:?}: {}", result.coefficients[1].value);
        assert!((result.residuals.rss - 2.5).abs() < 1e-9);
        assert_eq!(result.spectrum.rank, 2);
        assert_eq!(result.numerics.correct_digits, 0.0);
    }
}

/// Rank does not depend on how columns are scaled.
#[test]
fn graded_columns_keep_their_rank_without_scaling() {
    let base = [[0.3, 2.0, 1.0], [1.1, -1.0, 2.0], [-0.5, 3.0, -1.0], [0.7, 1.0, 3.0], [0.2, -0.4, 0.9]];
    let grade = [1.0, 1e20, 1e40];
    let x: Vec<f64> = base.iter().flat_map(|row| (0..3).map(move |j| row[j] * grade[j])).collect();
    let y = vec![1., 2., 3., 4., 5.];
    let answer = |scaling| {
        let mut spec = FitSpec::new(Model::Linear);
        spec.scaling = scaling;
        spec.regularization = Regularization::None;
        fit(&Nodes::matrix(x.clone(), 3, y.clone(), None, None).unwrap(), &spec).unwrap()
    };
    let (plain, unit) = (answer(Scaling::None), answer(Scaling::UnitLength));
    assert_eq!((plain.spectrum.rank, unit.spectrum.rank), (3, 3));
    for (a, b) in plain.coefficients.iter().zip(&unit.coefficients) {
        assert!((a.value - b.value).abs() <= 1e-12 * b.value.abs());
    }
}

/// Columns whose squares are no doubles are refused, not taken for 0.
#[test]
fn columns_whose_squares_overflow_or_underflow_are_refused() {
    let huge = Nodes::matrix(vec![1e160, 0., 2e160, 1., 3e160, 4., 4e160, 2.], 2, vec![1., 2., 3., 4.], None, None);
    let mut spec = FitSpec::new(Model::Linear);
    spec.regularization = Regularization::None;
    assert!(matches!(fit(&huge.unwrap(), &spec), Err(FitError::ExceedsDouble(_))));
    let tiny = Nodes::matrix(vec![1e-200, 0., 2e-200, 1., 3e-200, 4.], 2, vec![1., 2., 3.], None, None);
    assert!(matches!(fit(&tiny.unwrap(), &spec), Err(FitError::ExceedsDouble(_))));
    let x: Vec<f64> = (1..=20).map(f64::from).collect();
    let heavy = Nodes::curve(x.clone(), x, Some(vec![1e300; 20]));
    assert!(matches!(fit(&heavy.unwrap(), &polynomial(3, PolynomialBasis::Monomial)), Err(FitError::ExceedsDouble(_))));
}
