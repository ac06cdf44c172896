//! Plans change no answer: a fit that finds one is, bit by bit, the fit that makes one.

use flankfit_engine::estimation::{
    FitSpec, Nodes, Plans, fit, fit_remembering,
    spec::{Criterion, Degree, Domain, Knots, Model, Parameter, PolynomialBasis, Regularization, Scaling, Terms},
};
use proptest::prelude::*;

fn spec(kind: usize) -> FitSpec {
    let polynomial = |basis, degree| Model::Polynomial { degree, basis, terms: Terms::Tensor };
    let mut spec = FitSpec::new(match kind % 4 {
        0 => polynomial(PolynomialBasis::Monomial, Degree::Both(2)),
        1 => polynomial(PolynomialBasis::Chebyshev, Degree::Each(3, 1)),
        2 => polynomial(PolynomialBasis::Monomial, Degree::Each(1, 3)),
        _ => Model::BSpline { degree: Degree::Both(2), knots: Knots::SpansEach(1, 2), weights: None },
    });
    match kind / 4 % 4 {
        0 => {}
        1 => spec.scaling = Scaling::None,
        2 => spec.regularization = Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Gcv) },
        _ => spec.domain = Some(Domain { u: Some([-1.0, 9.0]), v: Some([-1.0, 9.0]) }),
    }
    spec.include.collinearity = kind / 16 % 2 == 1;
    spec
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Many grids and specs on one set of plans, more of them than are kept, in any order.
    #[test]
    fn found_plans_give_the_same_bits(
        requests in prop::collection::vec((0usize..32, 0usize..3, prop::collection::vec(-1.0f64..1.0, 48)), 1..60),
    ) {
        let plans = Plans::default();
        for (kind, grid, heights) in requests {
            let u: Vec<f64> = (0..6).map(|i| i as f64 + 0.1 * grid as f64).collect();
            let v: Vec<f64> = (0..8).map(|i| i as f64).collect();
            let valid = (grid == 2).then(|| (0..48).map(|i| i != 5).collect());
            let nodes = Nodes::grid(u, v, heights, valid, None).unwrap();
            let spec = spec(kind);
            prop_assert_eq!(fit_remembering(&nodes, &spec, &plans), fit(&nodes, &spec));
        }
    }
}

/// Refusals are not remembered as anything else.
#[test]
fn refusals_are_repeated_from_the_cache() {
    let plans = Plans::default();
    let nodes = Nodes::grid(vec![0.0, 1.0], vec![0.0, 1.0], vec![1.0; 4], None, None).unwrap();
    let spec = spec(0);
    let first = fit_remembering(&nodes, &spec, &plans);
    assert!(first.is_err());
    assert_eq!(fit_remembering(&nodes, &spec, &plans), first);
    assert_eq!(fit(&nodes, &spec), first);
}
