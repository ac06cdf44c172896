//! Confidence intervals: coverage by Monte Carlo, and what they are where formulas are known.

use crate::oracle::coverage::{Design, Truth, designs};
use crate::oracle::random::Random;
use crate::problems::{Problem, assert_close, by, fit, linear, matrix, spectral};
use flankfit_engine::estimation::result::IntervalKind;
use flankfit_engine::estimation::spec::{
    Count, Criterion, Degree, FitSpec, Model, PolynomialBasis, Regularization, Scheme, Terms,
};
use flankfit_engine::estimation::{FitResult, Nodes};

/// Coverage of the truth by each interval of `spec`, in `repetitions` draws of noise `sigma`; and
/// the mean of their widths over those of least squares.
fn coverage(design: &Design, truth: &[f64], sigma: f64, spec: &FitSpec, repetitions: usize) -> (Vec<f64>, f64) {
    let mut random = Random::new(2024);
    let (mut hits, mut width) = (vec![0usize; truth.len()], 0.0);
    for _ in 0..repetitions {
        let y: Vec<f64> = design
            .x
            .iter()
            .map(|row| row.iter().zip(truth).map(|(x, a)| x * a).sum::<f64>() + sigma * random.normal())
            .collect();
        let result = fit(&matrix(&design.x, &y, None), spec);
        for ((c, hit), truth) in result.coefficients.iter().zip(&mut hits).zip(truth) {
            let interval = c.interval.unwrap();
            let [low, high] = interval.ends;
            *hit += usize::from(low <= *truth && *truth <= high);
            width += interval.gain.unwrap_or(1.0);
        }
    }
    let count = (repetitions * truth.len()) as f64;
    (hits.iter().map(|&h| h as f64 / repetitions as f64).collect(), width / count)
}

fn spec(r: Option<f64>) -> FitSpec {
    let regularization = spectral(Scheme::FirstOrder, Count::Auto, by(Criterion::MinMse));
    FitSpec { coefficient_norm_limit: r, regularization, ..linear() }
}

/// 2,000 draws: three standard errors of a coverage are 0.015.
const REPETITIONS: usize = 2000;

#[test]
fn intervals_hold_whatever_the_coefficients_are() {
    for design in &designs()[..5] {
        for truth in [Truth::Smallest, Truth::Largest, Truth::Every] {
            // the smallest direction at about its own noise
            let (r, sigma) = (1.0, design.directions[0].0);
            let coefficients = design.truth(truth, r);
            for limit in [None, Some(r)] {
                let (covered, width) = coverage(design, &coefficients, sigma, &spec(limit), REPETITIONS);
                let mean = covered.iter().sum::<f64>() / covered.len() as f64;
                let least = covered.iter().fold(1.0f64, |least, c| least.min(*c));
                assert!(mean >= 0.94 && least >= 0.93, "{} {truth:?} {limit:?}: {mean} {least}", design.name);
                assert!(limit.is_none() || (0.5..1.0).contains(&width), "{} {truth:?}: width {width}", design.name);
            }
        }
    }
}

#[test]
fn intervals_from_standard_errors_lack_coverage() {
    let design = &designs()[0];
    let truth = design.truth(Truth::Smallest, 1.0);
    let mut random = Random::new(11);
    let mut hits = 0;
    for _ in 0..REPETITIONS {
        let y: Vec<f64> = design
            .x
            .iter()
            .map(|row| {
                row.iter().zip(&truth).map(|(x, a)| x * a).sum::<f64>() + design.directions[0].0 * random.normal()
            })
            .collect();
        let c = &fit(&matrix(&design.x, &y, None), &spec(None)).coefficients[0];
        hits += usize::from((c.value - truth[0]).abs() <= 2.02 * c.error_given_lambda().unwrap());
    }
    assert!((hits as f64) < 0.9 * REPETITIONS as f64, "{hits}");
}

/// Share of draws in which the nodes contradict a norm limit.
fn contradicted(design: &Design, truth: &[f64], sigma: f64, limit: f64, draws: usize) -> f64 {
    let mut random = Random::new(8_150);
    let spec = spec(Some(limit));
    let warned = (0..draws).filter(|_| {
        let y: Vec<f64> = (design.x.iter())
            .map(|row| row.iter().zip(truth).map(|(x, a)| x * a).sum::<f64>() + sigma * random.normal())
            .collect();
        let found = fit(&matrix(&design.x, &y, None), &spec);
        found.warnings.iter().any(|warning| warning.code() == "norm_limit_contradicted")
    });
    warned.count() as f64 / draws as f64
}

/// A true limit is contradicted in 0.01 of the draws at most (1,000 draws: three standard errors
/// are 0.009), half of it where that is ten standard errors of the worst direction away.
#[test]
fn true_norm_limits_are_seldom_contradicted_and_half_of_them_mostly() {
    for design in &designs()[..5] {
        for truth in [Truth::Smallest, Truth::Largest, Truth::Every] {
            let coefficients = design.truth(truth, 1.0);
            let share = |noise: f64, limit: f64| {
                contradicted(design, &coefficients, noise * design.directions[0].0, limit, 1_000)
            };
            let level = [0.1, 1.0, 10.0].map(|noise| share(noise, 1.0));
            let power = [0.05, 0.2, 1.0].map(|noise| share(noise, 0.5));
            println!("{} {truth:?}: level {level:?}, power {power:?}", design.name);
            assert!(level.iter().all(|share| *share <= 0.019), "{} {truth:?}: {level:?}", design.name);
            assert!(power[0] > 0.99, "{} {truth:?}: {power:?}", design.name);
        }
    }
}

/// A line through eight nodes: ends from the standard errors and t(0.975; 6) of tables.
#[test]
fn students_intervals_of_a_line() {
    let x = [0.2, 337.4, 118.2, 884.6, 10.1, 226.5, 666.3, 996.3];
    let y: Vec<f64> = x.iter().map(|x| 1.5 + 2.0 * x + if *x > 300.0 { 0.1 } else { -0.1 }).collect();
    let rows: Vec<Vec<f64>> = x.iter().map(|x| vec![1.0, *x]).collect();
    let result = fit(&matrix(&rows, &y, None), &FitSpec { regularization: Regularization::None, ..linear() });
    // t(0.975; 6)
    let t = 2.446_911_851_144_969_2;
    for c in &result.coefficients {
        let interval = c.interval.unwrap();
        assert_eq!((interval.kind, interval.gain), (IntervalKind::Student, None));
        assert_close("low", interval.ends[0], c.value - t * c.std_error.unwrap(), 1e-13, 1e-15);
        assert_close("high", interval.ends[1], c.value + t * c.std_error.unwrap(), 1e-13, 1e-15);
    }
}

/// Norm that deviations of size 1 allow, over √m: 1/√λ₁, as in docs/explanation/intervals.md.
#[test]
fn safe_norm_limits_of_usual_grids() {
    for (rows, columns) in [(5, 7), (5, 9), (9, 5), (9, 15), (20, 30)] {
        let axis = |count: u32| (0..count).map(|k| 2.0 * f64::from(k) / f64::from(count - 1) - 1.0).collect();
        let z = (0..rows * columns).map(|k| f64::from(k * k % 7)).collect();
        let grid = Nodes::grid(axis(rows), axis(columns), z, None, None).unwrap();
        let safe = |degree: Degree, basis: PolynomialBasis, terms: Terms| {
            let model = Model::Polynomial { degree, basis, terms };
            1.0 / fit(&grid, &FitSpec::new(model)).spectrum.eigenvalues[0].sqrt()
        };
        let flank = safe(Degree::Both(2), PolynomialBasis::Monomial, Terms::Total);
        assert!((2.3..2.4).contains(&flank), "{rows} x {columns}: {flank}");
        for basis in [PolynomialBasis::Chebyshev, PolynomialBasis::Legendre] {
            for degree in [Degree::Both(2), Degree::Each(3, 2), Degree::Both(3)] {
                let found = safe(degree, basis, Terms::Tensor);
                assert!((1.05..2.4).contains(&found), "{rows} x {columns}, {degree:?}, {basis:?}: {found}");
            }
        }
    }
}

fn kinds(result: &FitResult) -> Vec<IntervalKind> {
    result.coefficients.iter().map(|c| c.interval.unwrap().kind).collect()
}

#[test]
fn interval_kinds_name_their_basis() {
    let problem = Problem::graded(3, 5, 12, 6.0);
    let of = |spec: &FitSpec| fit(&problem.nodes(), spec);
    assert!(kinds(&of(&spec(None))).iter().all(|kind| *kind == IntervalKind::LeastSquares));
    let tight = of(&spec(Some(1e-6)));
    assert!(kinds(&tight).iter().all(|kind| *kind == IntervalKind::BiasAware));
    // so small a limit says more than the nodes: the interval is ± what it allows
    for c in &tight.coefficients {
        let [low, high] = c.interval.unwrap().ends;
        assert!(high - low <= 2.1 * c.interval.unwrap().gain.unwrap() * c.least_squares_std_error.unwrap() * 2.2);
        assert!((low + high).abs() <= 0.5 * (high - low), "{low} {high}");
    }
    // a limit far above what the noise allows has no effect
    let loose = of(&spec(Some(1e12)));
    for (c, plain) in loose.coefficients.iter().zip(&of(&spec(None)).coefficients) {
        assert_close("gain", c.interval.unwrap().gain.unwrap(), 1.0, 1e-6, 0.0);
        assert_close("low", c.interval.unwrap().ends[0], plain.interval.unwrap().ends[0], 1e-4, 1e-9);
    }
    let wide = of(&FitSpec { level: 0.999, ..spec(None) });
    let narrow = of(&FitSpec { level: 0.6, ..spec(None) });
    for (wide, narrow) in wide.coefficients.iter().zip(&narrow.coefficients) {
        let ([a, b], [c, d]) = (wide.interval.unwrap().ends, narrow.interval.unwrap().ends);
        assert!(a < c && d < b);
    }
    // σ known: normal quantiles of that σ
    let known = of(&FitSpec { noise_sigma: Some(0.5), regularization: Regularization::None, ..linear() });
    let plain = of(&FitSpec { regularization: Regularization::None, ..linear() });
    let sigma = plain.residuals.sigma.unwrap();
    for (known, plain) in known.coefficients.iter().zip(&plain.coefficients) {
        let [low, high] = known.interval.unwrap().ends;
        let want = 2.0 * 1.959_963_984_540_054 * 0.5 / sigma * plain.std_error.unwrap();
        assert_close("width", high - low, want, 1e-9, 0.0);
    }
}

/// The linear expansion of the norm: right where noise is small, 0.86 at worst elsewhere.
#[test]
fn the_upper_confidence_limit_of_the_norm_is_shown_with_its_estimate() {
    let design = &designs()[0];
    for (truth, noise, least) in [(Truth::Smallest, 0.1, 0.93), (Truth::Every, 0.5, 0.83), (Truth::Every, 2.0, 0.93)] {
        let (coefficients, sigma) = (design.truth(truth, 1.0), noise * design.directions[0].0);
        let mut random = Random::new(5);
        let mut hits = 0usize;
        for _ in 0..REPETITIONS {
            let heights = design.x.iter().map(|row| row.iter().zip(&coefficients).map(|(x, a)| x * a).sum::<f64>());
            let y: Vec<f64> = heights.map(|height| height + sigma * random.normal()).collect();
            let bias = fit(&matrix(&design.x, &y, None), &spec(None)).bias;
            let upper = bias.upper_confidence.unwrap();
            assert!(upper > bias.coefficient_norm_limit);
            hits += usize::from(upper >= 1.0);
        }
        let covered = hits as f64 / REPETITIONS as f64;
        assert!(covered >= least, "{truth:?} {noise}: {covered}");
    }
}

#[test]
fn norms_indistinguishable_from_noise_are_warned_of() {
    let design = &designs()[0];
    let warned = |truth: Truth, noise: f64, spec: &FitSpec| {
        let (coefficients, mut random) = (design.truth(truth, 1.0), Random::new(3));
        let sigma = noise * design.directions[0].0;
        let heights = design.x.iter().map(|row| row.iter().zip(&coefficients).map(|(x, a)| x * a).sum::<f64>());
        let y: Vec<f64> = heights.map(|height| height + sigma * random.normal()).collect();
        let result = fit(&matrix(&design.x, &y, None), spec);
        (crate::problems::warned(&result, "norm_limit_is_estimate"), result.bias.upper_confidence.is_some())
    };
    assert_eq!(warned(Truth::Largest, 3.0, &spec(None)), (true, true));
    assert_eq!(warned(Truth::Smallest, 0.05, &spec(None)), (false, true));
    // given, or nothing to bound
    assert_eq!(warned(Truth::Largest, 3.0, &spec(Some(1.0))), (false, false));
    let plain = FitSpec { regularization: Regularization::None, ..spec(None) };
    assert_eq!(warned(Truth::Largest, 3.0, &plain), (false, false));
}
