//! Corrections whose settings have limits, increments or fixed values.

use crate::gear_correction::{changes, plain, settings, solve, times};
use flankfit_engine::estimation::result::NormLimitSource;
use flankfit_engine::gear::correction::{CorrectionSpec, Solution};
use flankfit_engine::gear::simulation::case;

/// Two settings that do exactly the same share the change; a limit on one sends the rest to the
/// other.
#[test]
fn settings_that_do_the_same_share_the_change() {
    let j: Vec<f64> = (0..9).flat_map(|k| [1.0, f64::from(k) - 4.0, f64::from(k) - 4.0]).collect();
    let deviation = times(&j, &[1.0, 3.0, 3.0]);
    let asked = CorrectionSpec::new(deviation, j, settings(3));
    let solution = solve(asked.clone());
    let x = changes(&solution);
    assert!((x[0] + 1.0).abs() < 1e-9 && (x[1] + 3.0).abs() < 1e-9 && (x[2] + 3.0).abs() < 1e-9, "{x:?}");
    assert!(solution.warnings.iter().any(|w| w.code() == "dependent_settings"));
    assert!(
        solution.indistinguishable.iter().any(|g| ["s1", "s2"].iter().all(|name| g.names.iter().any(|n| n == name)))
    );
    let mut limited = asked;
    limited.settings[1].min = Some(-0.5);
    let solution = solve(limited);
    let x = changes(&solution);
    assert!(x[1] == -0.5 && (x[2] + 5.5).abs() < 1e-9, "{x:?}");
    assert!(solution.settings[1].limited);
    assert!(solution.predicted.rms_um < 1e-9);
}

/// Nearly collinear settings within narrow limits: regularised fits settle, and the others make up
/// for what one may not do.
#[test]
fn limits_settle_for_nearly_collinear_settings() {
    for seed in 0..40 {
        let asked = case::ill_conditioned(seed);
        let deviation = flankfit_engine::gear::simulation::Simulation::new(asked.clone()).unwrap().measure();
        let mut correction = CorrectionSpec::new(deviation, asked.sensitivity, asked.settings);
        correction.noise_sigma = Some(0.3);
        let free = solve(correction.clone());
        let most = free.settings.iter().map(|s| s.change.abs()).fold(0.0, f64::max);
        for setting in &mut correction.settings {
            (setting.min, setting.max) = (Some(-0.5 * most), Some(0.5 * most));
        }
        let solution = solve(correction);
        assert!(solution.settings.iter().any(|s| s.limited));
        assert!(solution.settings.iter().all(|s| s.change.abs() <= 0.5 * most));
        assert!(solution.predicted.rms_um < solution.predicted.rms_before_um);
        assert!(solution.warnings.iter().all(|w| w.code() != "limits_not_settled"), "seed {seed}");
    }
}

/// Forty settings, most of them at narrow limits.
#[test]
fn many_settings_at_their_limits_settle() {
    let place = |k: usize, j: usize| ((k * 37 + j * 101 + k * j * 13) % 97) as f64 / 48.0 - 1.0;
    let j: Vec<f64> = (0..120).flat_map(|k| (0..40).map(move |j| place(k, j))).collect();
    let deviation = times(&j, &(0..40).map(|j| f64::from(j) - 19.5).collect::<Vec<f64>>());
    let mut asked = CorrectionSpec::new(deviation, j, settings(40));
    for setting in &mut asked.settings {
        (setting.min, setting.max) = (Some(-5.0), Some(5.0));
    }
    let solution = solve(asked);
    let limited = solution.settings.iter().filter(|s| s.limited).count();
    assert!(limited >= 20 && solution.settings.iter().all(|s| s.change.abs() <= 5.0), "{limited}");
    assert!(solution.predicted.rms_um < solution.predicted.rms_before_um);
}

/// Every setting at a limit is an answer as well.
#[test]
fn all_settings_may_be_at_their_limits() {
    let j: Vec<f64> = (0..9).flat_map(|k| [1.0, f64::from(k) - 4.0]).collect();
    let mut asked = plain(times(&j, &[10.0, 10.0]), j, settings(2));
    for setting in &mut asked.settings {
        (setting.min, setting.max) = (Some(-1.0), Some(1.0));
    }
    let solution = solve(asked);
    assert_eq!(changes(&solution), [-1.0, -1.0]);
    assert!(solution.limited_fit.is_none() && solution.settings.iter().all(|s| s.limited));
    assert!(solution.settings.iter().all(|s| (s.unlimited.unwrap() + 10.0).abs() < 1e-9));
}

/// A setting that is fixed is as good as none: the others make up for it.
#[test]
fn fixed_settings_stay_unchanged() {
    let j: Vec<f64> = (0..9).flat_map(|k| [1.0, f64::from(k) - 4.0, (f64::from(k) - 4.0).powi(2)]).collect();
    let d: Vec<f64> = (0..9).map(|k| (1.3 * f64::from(k)).sin() + 2.0).collect();
    let mut asked = plain(d.clone(), j.clone(), settings(3));
    asked.settings[1].fixed = true;
    let with = solve(asked);
    let left: Vec<f64> = j.chunks_exact(3).flat_map(|row| [row[0], row[2]]).collect();
    let without = solve(plain(d, left, settings(2)));
    assert_eq!((with.settings[1].change, with.settings[1].std_error, with.settings[1].fixed), (0.0, None, true));
    for (a, b) in [0, 2].map(|j| &with.settings[j]).into_iter().zip(&without.settings) {
        assert!(
            (a.change - b.change).abs() < 1e-12 && (a.std_error.unwrap() / b.std_error.unwrap() - 1.0).abs() < 1e-9
        );
    }
    assert_eq!(with.predicted.rms_um, without.predicted.rms_um);
}

/// All pairs of multiples within reach, by trying them: rounding with a new fit of the rest leaves
/// hardly more, rounding each by itself far more.
#[test]
fn rounded_changes_are_nearly_the_best_there_are() {
    let (mut sum, mut best_sum, mut naive_sum) = (0.0, 0.0, 0.0);
    for seed in 0..60u64 {
        let mut random = crate::oracle::random::Random::new(seed);
        // two settings that nearly undo each other, one that is free
        let j: Vec<f64> = (0..20)
            .flat_map(|_| {
                let (a, b) = (random.normal(), random.normal());
                [a, a + 0.3 * b, random.normal()]
            })
            .collect();
        let d: Vec<f64> = times(&j, &[3.0 * random.normal(), 3.0 * random.normal(), 2.0]);
        let steps = [0.5, 0.25];
        let mut asked = plain(d.clone(), j.clone(), settings(3));
        for (setting, step) in asked.settings.iter_mut().zip(steps) {
            (setting.increment, setting.min, setting.max) = (Some(step), Some(-20.0), Some(20.0));
        }
        let solution = solve(asked);
        let x = changes(&solution);
        for (setting, step) in solution.settings.iter().zip(steps) {
            assert!((setting.change / step).fract() == 0.0 && setting.unrounded.is_some());
            assert!(setting.limited || setting.std_error.is_some());
        }
        assert!(solution.settings[2].unrounded.is_none());
        let left = |x: &[f64]| times(&j, x).iter().zip(&d).map(|(a, b)| (a + b).powi(2)).sum::<f64>();
        // the third by its own least squares
        let with = |a: f64, b: f64| {
            let rest: Vec<f64> = times(&j, &[a, b, 0.0]).iter().zip(&d).map(|(a, b)| a + b).collect();
            let (mut over, mut under) = (0.0, 0.0);
            for (row, rest) in j.chunks_exact(3).zip(&rest) {
                (over, under) = (over + row[2] * rest, under + row[2] * row[2]);
            }
            left(&[a, b, -over / under])
        };
        let of = |k: usize| (solution.settings[k].unrounded.unwrap() / steps[k]).round();
        let mut best = f64::INFINITY;
        for p in -8..=8 {
            for q in -8..=8 {
                let (a, b) = ((of(0) + f64::from(p)) * steps[0], (of(1) + f64::from(q)) * steps[1]);
                if a.abs() <= 20.0 && b.abs() <= 20.0 {
                    best = best.min(with(a, b));
                }
            }
        }
        let predicted = solution.predicted.rms_um.powi(2) * 20.0;
        assert!((predicted - left(&x)).abs() < 1e-9 * (1.0 + predicted), "predicted is what the rounded changes leave");
        assert!(left(&x) >= best * (1.0 - 1e-9));
        (sum, best_sum, naive_sum) =
            (sum + left(&x), best_sum + best, naive_sum + with(of(0) * steps[0], of(1) * steps[1]));
    }
    assert!(sum <= 1.1 * best_sum && naive_sum > 1.3 * best_sum, "{sum} {best_sum} {naive_sum}");
}

/// Steps with decimals come back with their decimals, and limits that are multiples can be reached.
#[test]
fn multiples_have_the_digits_of_their_step() {
    let j: Vec<f64> = (0..9).map(|k| f64::from(k) - 4.0).collect();
    let mut asked = plain(times(&j, &[-0.7]), j, settings(1));
    asked.settings[0].increment = Some(0.1);
    assert_eq!(changes(&solve(asked.clone())), [0.7]);
    asked.settings[0].max = Some(0.3);
    let limited = solve(asked);
    assert_eq!((changes(&limited)[0], limited.settings[0].limited), (0.3, true));
}

/// A bound from limits does not exceed them: two settings that are nearly indistinguishable, one of
/// which may go far and the other may not.
#[test]
fn a_bound_from_limits_does_not_exceed_them() {
    let j: Vec<f64> = (0..12).flat_map(|k| [f64::from(k), f64::from(k) + 1e-4 * f64::from(k * k % 7)]).collect();
    let deviation = times(&j, &[-3.0, 2.0]);
    let with = |limits: [[f64; 2]; 2], given: Option<f64>| {
        let mut settings = settings(2);
        for (setting, [min, max]) in settings.iter_mut().zip(limits) {
            (setting.min, setting.max) = (Some(min), Some(max));
        }
        let asked = CorrectionSpec::new(deviation.clone(), j.clone(), settings);
        solve(CorrectionSpec { noise_sigma: Some(0.1), coefficient_norm_limit: given, ..asked })
    };
    let solution = with([[-10.0, 10.0], [-200.0, 300.0]], None);
    let [narrow, wide] = &solution.settings[..] else { panic!("two settings") };
    assert_eq!(solution.fit.bias.coefficient_norm_limit_source, NormLimitSource::Limits);
    assert!(solution.fit.coefficients[0].bias_bound > 100.0, "the ball alone: {:?}", solution.fit.coefficients[0]);
    assert_eq!(narrow.bias_bound, Some(10.0 + narrow.change.abs()));
    assert!(wide.bias_bound.unwrap() <= 300.0 - wide.change);
    // a norm that the caller gives says nothing of the limits
    let given = with([[-10.0, 10.0], [-200.0, 300.0]], Some(1e4));
    assert_eq!(given.settings[0].bias_bound, Some(given.fit.coefficients[0].bias_bound));
}

/// A setting that the deviations say nothing about keeps to its limits all the same, and the answer
/// says what became of them.
#[test]
fn limits_of_undetermined_settings_are_kept() {
    let j: Vec<f64> = (0..9).flat_map(|k| [1.0 + 0.01 * f64::from(k % 3), f64::from(k), f64::from(k * k)]).collect();
    let d: Vec<f64> =
        (0..9).map(|k| 0.7 * f64::from(k) + 0.1 * f64::from(k * k) + (1.3 * f64::from(k)).sin()).collect();
    let with = |min: Option<f64>, max: Option<f64>, increment: Option<f64>| {
        let mut settings = settings(3);
        (settings[0].min, settings[0].max, settings[0].increment) = (min, max, increment);
        settings[1].increment = increment;
        solve(CorrectionSpec { absolute: false, ..plain(d.clone(), j.clone(), settings) })
    };
    let codes = |s: &Solution| s.warnings.iter().map(|w| w.code()).collect::<Vec<_>>();
    let free = with(None, None, None);
    assert_eq!(codes(&free), ["undetermined_settings"]);
    for (min, max, increment) in [(Some(-1.0), Some(2.0), None), (None, Some(3.0), None), (None, None, Some(0.25))] {
        let unused = with(min, max, increment);
        assert_eq!(unused.settings[0].change, 0.0);
        assert_eq!(codes(&unused), ["undetermined_settings", "limits_without_effect"]);
        assert!(unused.warnings[1].to_string().contains("`s0`") && !unused.warnings[1].to_string().contains("`s1`"));
    }
    for (min, max, increment, want) in
        [(Some(2.0), None, None, 2.0), (Some(2.0), Some(7.0), Some(1.5), 3.0), (Some(-9.0), Some(-4.0), None, -4.0)]
    {
        let moved = with(min, max, increment);
        let setting = &moved.settings[0];
        assert_eq!((setting.change, setting.limited, setting.undetermined), (want, true, true));
        assert_eq!((setting.unlimited, setting.std_error, setting.bias_bound), (Some(0.0), None, None));
        assert_eq!(codes(&moved), ["undetermined_settings_moved"]);
        // what it does to the nodes is reckoned with: the others are the least squares of what it
        // leaves
        if increment.is_none() {
            let level: Vec<f64> = times(&j, &changes(&moved)).iter().zip(&d).map(|(c, d)| c + d).collect();
            let mean = level.iter().sum::<f64>() / 9.0;
            for c in [1, 2] {
                let middle = (0..9).map(|k| j[3 * k + c]).sum::<f64>() / 9.0;
                let slope: f64 = (0..9).map(|k| (j[3 * k + c] - middle) * (level[k] - mean)).sum();
                assert!(slope.abs() < 1e-9, "{c}: {slope}");
            }
            let rms = (level.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 9.0).sqrt();
            assert!((moved.predicted.rms_um - rms).abs() < 1e-9);
        } else {
            let steps = moved.settings[1].change / 1.5;
            assert!((steps - steps.round()).abs() < 1e-12, "{steps}");
        }
    }
}
