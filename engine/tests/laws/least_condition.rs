//! Eq. 49: no λ* on a fine grid has a smaller condition than the closed form, and its plateau is
//! the whole plateau.

use crate::oracle::spectral::{Filter, Sums, logarithmic};
use crate::problems::{Problem, assert_close, by, close, config, filter, fit, linear, spectral};
use flankfit_engine::estimation::spec::{ChosenBy, Count, Criterion, FitSpec, Scaling, Scheme};
use proptest::prelude::*;

/// The interval of minimisers found by trying: the grid points within a hair of the least
/// condition.
fn tried(sums: &Sums, filter: Filter) -> (f64, f64, f64) {
    let grid = logarithmic(sums.lambda[0], sums.lambda[sums.n() - 1], 20_001);
    let conditions: Vec<f64> = grid.iter().map(|t| sums.condition(filter, *t)).collect();
    let least = conditions.iter().copied().fold(f64::INFINITY, f64::min);
    let near = |c: &f64| *c <= least * (1.0 + 1e-10);
    let first = conditions.iter().position(near).expect("a minimum");
    let last = conditions.iter().rposition(near).expect("a minimum");
    (least, grid[first], grid[last])
}

proptest! {
    #![proptest_config(config(160))]

    #[test]
    fn no_other_lambda_has_a_smaller_condition(
        seed: u64, n in 2usize..9, extra in 0usize..10, log_condition in 0.1f64..12.0,
        exact: bool, count in 1usize..8,
    ) {
        let problem = Problem::clustered(seed, n, extra, log_condition);
        let count = 1 + (count - 1) % (n - 1);
        let scheme = if exact { Scheme::Exact } else { Scheme::FirstOrder };
        let regularization = spectral(scheme, Count::Given(count), by(Criterion::MinCondition));
        let result = fit(&problem.nodes(), &FitSpec { scaling: Scaling::None, regularization, ..linear() });
        let report = &result.regularization;
        prop_assert_eq!(report.criterion, Some(ChosenBy::Criterion(Criterion::MinCondition)));

        // The reported spectrum, so that only Eq. 49 is on trial here.
        let lambda = result.spectrum.eigenvalues.clone();
        let sums = Sums { a: vec![0.0; n], lambda, rss: 1.0, m: n + 1, total_weight: 1.0, unpenalised: 0 };
        let filter = filter(scheme, count);
        let chosen = report.lambda_star.unwrap();
        let (least, first, last) = tried(&sums, filter);
        let condition = sums.condition(filter, chosen);
        prop_assert!(condition <= least * (1.0 + 1e-9),
            "condition {condition:e} at {chosen:e}, {least:e} at {first:e}");
        assert_close("condition", result.spectrum.regularized.condition.unwrap(), condition, 1e-9, 0.0);

        let step = (sums.lambda[n - 1] / sums.lambda[0]).powf(1.0 / 20_000.0);
        // Between eigenvalues equal to rounding the least minimiser is anyone's choice.
        let tied = sums.lambda[count - 1] * (1.0 + 1e-9) > sums.lambda[count];
        prop_assert!(tied || chosen <= first * step * (1.0 + 1e-9), "{chosen:e} is not the least minimiser, {first:e} \
            is");
        match report.lambda_star_interval {
            Some([low, high]) => {
                assert_close("low end", low, chosen, 1e-12, 0.0);
                prop_assert!(high >= low);
                for inside in [(low * high).sqrt(), high] {
                    prop_assert!(close(sums.condition(filter, inside), condition, 1e-9, 0.0));
                }
                prop_assert!(high * step * (1.0 + 1e-9) >= last, "the plateau ends at {last:e}, not at {high:e}");
                let beyond = sums.condition(filter, high * 1.001);
                prop_assert!(beyond > condition * (1.0 + 1e-9) || high * 1.001 > sums.lambda[n - 1]);
            }
            None => prop_assert!(last <= chosen * step * step, "a plateau from {first:e} to {last:e} is not reported"),
        }
    }
}
