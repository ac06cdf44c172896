//! Every criterion for λ*: it chooses what a brute-force search over its definition finds, and the
//! results listed with each choice are those of that λ*.

use crate::oracle::spectral::{Filter, Sums, brute_force_minimum, logarithmic};
use crate::problems::{Problem, assert_close, by, columns, config, filter, fit, linear, spectral, warned};
use flankfit_engine::estimation::FitResult;
use flankfit_engine::estimation::result::Choice;
use flankfit_engine::estimation::spec::{
    ChosenBy, Count, Criterion, FitSpec, Include, Parameter, Regularization, Scaling, Scheme,
};
use proptest::prelude::*;

/// The same for spectral filters and for ridge.
pub struct Trial<'a> {
    pub sums: &'a Sums,
    pub filter: Filter,
    pub range: [f64; 2],
    pub sigma: f64,
}

impl Trial<'_> {
    pub fn check(&self, result: &FitResult) {
        let choices = &result.regularization.choices;
        let plain =
            choices.iter().find(|c| c.criterion == ChosenBy::LeastSquares).expect("least squares stands beside them");
        assert_eq!(plain.bias_norm, 0.0);
        // Nothing filtered: for ridge k = 0, for the others λ* = λ₁.
        let nothing = if self.filter == Filter::Ridge { 0.0 } else { self.sums.lambda[0] };
        self.figures(plain, nothing);
        for criterion in Criterion::ALL {
            let found = choices.iter().find(|c| c.criterion == ChosenBy::Criterion(criterion));
            if criterion == Criterion::MinCondition && self.filter == Filter::Ridge {
                assert!(found.is_none(), "min_condition has no minimiser for ridge");
                continue;
            }
            let choice = found.unwrap_or_else(|| panic!("{} is not among the choices", criterion.name()));
            let t = choice.lambda_star.unwrap_or_else(|| panic!("{} chose no λ*", criterion.name()));
            self.figures(choice, t);
            self.best(criterion, t, result);
        }
    }

    fn figures(&self, choice: &Choice, t: f64) {
        let (sums, filter) = (self.sums, self.filter);
        let condition = match filter {
            Filter::Ridge => (sums.lambda[sums.n() - 1] + t) / (sums.lambda[0] + t),
            _ => sums.condition(filter, t),
        };
        let estimate = sums.a.iter().map(|a| a * a).sum::<f64>().sqrt();
        assert_close("condition", choice.condition.expect("a condition"), condition, 1e-7, 0.0);
        assert_close("bias", choice.bias_norm, sums.bias_norm(filter, t), 1e-6, 1e-10 * estimate);
        let mse = choice.predicted_mse.expect("σ is known");
        assert_close("predicted mse", mse, sums.predicted_mse(filter, t, self.sigma), 1e-6, 0.0);
        let rms = (sums.rss_at(filter, t) / sums.total_weight).sqrt();
        assert_close("rms", choice.rms, rms, 1e-6, 0.0);
    }

    /// Checks that `t` is the criterion's choice.
    fn best(&self, criterion: Criterion, t: f64, result: &FitResult) {
        let (sums, filter, [low, high]) = (self.sums, self.filter, self.range);
        let name = criterion.name();
        assert!(t >= low * (1.0 - 1e-9) && t <= high * (1.0 + 1e-9), "{name}: {t:e} outside {low:e}..{high:e}");
        let minimal = |objective: &dyn Fn(f64) -> f64| {
            let (place, least) = brute_force_minimum(low, high, objective);
            let got = objective(t);
            assert!(got <= least * (1.0 + 1e-7), "{name}: {got:e} at {t:e}, but {least:e} at {place:e}");
        };
        match criterion {
            Criterion::MinMse => minimal(&|t| sums.predicted_mse(filter, t, self.sigma)),
            Criterion::Gcv => minimal(&|t| sums.gcv(filter, t)),
            Criterion::MinCondition => minimal(&|t| sums.condition(filter, t)),
            Criterion::Discrepancy => {
                let (target, lowest, highest) =
                    (sums.m as f64 * self.sigma.powi(2), sums.rss_at(filter, low), sums.rss_at(filter, high));
                if lowest >= target {
                    assert_close("discrepancy at its low end", t, low, 1e-9, 0.0);
                } else if highest < target {
                    assert_close("discrepancy never reached", t, high, 1e-9, 0.0);
                    if result.regularization.criterion == Some(ChosenBy::Criterion(Criterion::Discrepancy)) {
                        assert!(warned(result, "discrepancy_not_reached"), "{:?}", result.warnings);
                    }
                } else {
                    assert_close("discrepancy", sums.rss_at(filter, t), target, 1e-8, 0.0);
                }
            }
            Criterion::LCurve => {
                let curvature = |t: f64| sums.curvature(filter, t);
                let greatest = logarithmic(low, high, 4001).into_iter().map(curvature).fold(f64::MIN, f64::max);
                // At a λᵢ the filters have a kink, where the curvature is that of one side or the
                // other.
                let got = [t * (1.0 - 1e-9), t, t * (1.0 + 1e-9)].map(curvature).into_iter().fold(f64::MIN, f64::max);
                let slack = 1e-3 * greatest.abs() + 1e-9;
                assert!(got >= greatest - slack, "{name}: curvature {got:e} at {t:e}, elsewhere {greatest:e}");
            }
            // closed forms of single kinds, with laws of their own
            Criterion::Hkb | Criterion::Hkb1975 | Criterion::LawlessWang | Criterion::Optimal => {}
            // not among those that are listed with every fit
            Criterion::Reml | Criterion::Press | Criterion::BlockedCv | Criterion::Sure => {}
        }
    }
}

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn choices_are_those_of_a_brute_force_search(
        seed: u64, n in 2usize..9, extra in 1usize..20, log_condition in 1.0f64..12.0,
        exact: bool, unit: bool, count in 1usize..8, known_sigma: bool,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let count = 1 + (count - 1) % (n - 1);
        let scheme = if exact { Scheme::Exact } else { Scheme::FirstOrder };
        let scaling = if unit { Scaling::UnitLength } else { Scaling::None };
        let sums = problem.spectrum(columns(scaling)).sums();
        let noise_sigma = known_sigma.then(|| 1.5 * sums.sigma());
        let trial = Trial {
            sums: &sums,
            filter: filter(scheme, count),
            range: [sums.lambda[0], sums.lambda[n - 1]],
            sigma: noise_sigma.unwrap_or(sums.sigma()),
        };
        for criterion in Criterion::ALL {
            let regularization = spectral(scheme, Count::Given(count), by(criterion));
            let spec = FitSpec { scaling, noise_sigma, regularization, ..linear() };
            let result = fit(&problem.nodes(), &spec);
            trial.check(&result);
            let report = &result.regularization;
            prop_assert_eq!(report.criterion, Some(ChosenBy::Criterion(criterion)));
            let choice = report.choices.iter().find(|c| c.criterion == ChosenBy::Criterion(criterion)).unwrap();
            prop_assert_eq!(choice.lambda_star, report.lambda_star);
            let rounding = 1e-13 * result.bias.coefficient_norm_limit;
            assert_close("bias of the choice", choice.bias_norm, result.bias.norm, 1e-9, rounding);
            let plain = report.choices.iter().find(|c| c.criterion == ChosenBy::LeastSquares).unwrap();
            if choice.predicted_mse > plain.predicted_mse.map(|p| p * (1.0 + 1e-9)) {
                prop_assert!(warned(&result, "worse_than_least_squares"), "{:?}", result.warnings);
            }
        }
    }

    #[test]
    fn the_lambda_curve_is_that_of_the_sums(
        seed: u64, n in 2usize..8, extra in 1usize..12, log_condition in 1.0f64..12.0, which in 0usize..3,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let sums = problem.spectrum(columns(Scaling::UnitLength)).sums();
        let (regularization, filter) = match which {
            0 => (spectral(Scheme::FirstOrder, Count::Given(1), by(Criterion::MinMse)), Filter::FirstOrder(1)),
            1 => (spectral(Scheme::Exact, Count::Given(1), by(Criterion::MinMse)), Filter::Exact(1)),
            _ => (Regularization::Ridge { parameter: by(Criterion::MinMse) }, Filter::Ridge),
        };
        let include = Include { lambda_curve: true, ..Include::default() };
        let result = fit(&problem.nodes(), &FitSpec { include, regularization, ..linear() });
        let curve = result.lambda_curve.as_ref().expect("asked for");
        prop_assert!(curve.len() >= 20 && curve.windows(2).all(|pair| pair[0].lambda_star < pair[1].lambda_star));
        let estimate = sums.a.iter().map(|a| a * a).sum::<f64>().sqrt();
        for point in curve {
            let t = point.lambda_star;
            let factors = sums.factors(filter, t);
            let norm = sums.a.iter().zip(&factors).map(|(a, f)| (a * f).powi(2)).sum::<f64>().sqrt();
            assert_close("norm", point.coefficient_norm, norm, 1e-6, 1e-12 * estimate);
            assert_close("bias", point.bias_norm, sums.bias_norm(filter, t), 1e-6, 1e-10 * estimate);
            assert_close("rms", point.rms, (sums.rss_at(filter, t) / sums.total_weight).sqrt(), 1e-6, 0.0);
            assert_close("gcv", point.gcv.expect("freedom"), sums.gcv(filter, t), 1e-6, 0.0);
            let mse = sums.predicted_mse(filter, t, sums.sigma());
            assert_close("mse", point.predicted_mse.expect("σ"), mse, 1e-6, 0.0);
        }
    }

    #[test]
    fn a_fixed_value_is_taken_as_it_is(seed: u64, n in 2usize..9, log_condition in 1.0f64..12.0, place in 0.0f64..1.0) {
        let problem = Problem::graded(seed, n, 5, log_condition);
        let lambda = problem.spectrum(columns(Scaling::UnitLength)).sums().lambda;
        let t = lambda[0] * (lambda[n - 1] / lambda[0]).powf(place);
        let regularization = spectral(Scheme::FirstOrder, Count::Given(1), Parameter::Fixed(t));
        let report = fit(&problem.nodes(), &FitSpec { regularization, ..linear() }).regularization;
        prop_assert_eq!((report.lambda_star, report.criterion), (Some(t), Some(ChosenBy::Fixed)));
    }
}

proptest! {
    #![proptest_config(config(6))]

    #[test]
    fn choices_with_many_coefficients(seed: u64, n in 10usize..18, log_condition in 8.0f64..12.0, count in 1usize..17) {
        let problem = Problem::graded(seed, n, 9, log_condition);
        let count = 1 + (count - 1) % (n - 1);
        let sums = problem.spectrum(columns(Scaling::UnitLength)).sums();
        let spectral_range = [sums.lambda[0], sums.lambda[n - 1]];
        let ridge_range = [1e-8 * sums.lambda[0], 1e4 * sums.lambda[n - 1]];
        let min_mse = by(Criterion::MinMse);
        for (regularization, filter, range) in [
            (spectral(Scheme::FirstOrder, Count::Given(count), min_mse), Filter::FirstOrder(count), spectral_range),
            (spectral(Scheme::Exact, Count::Given(count), min_mse), Filter::Exact(count), spectral_range),
            (Regularization::Ridge { parameter: min_mse }, Filter::Ridge, ridge_range),
        ] {
            let result = fit(&problem.nodes(), &FitSpec { regularization, ..linear() });
            Trial { sums: &sums, filter, range, sigma: sums.sigma() }.check(&result);
        }
    }
}
