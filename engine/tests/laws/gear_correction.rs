//! Corrections: changes of settings from deviations and a sensitivity matrix.

use flankfit_engine::estimation::FitError;
use flankfit_engine::estimation::result::NormLimitSource;
use flankfit_engine::estimation::spec::{Count, Parameter, Regularization, Scheme};
use flankfit_engine::gear::correction::{Correction, CorrectionSpec, Damping, Setting, Solution};
use flankfit_engine::gear::simulation::case;
use proptest::prelude::*;

pub fn settings(n: usize) -> Vec<Setting> {
    (0..n).map(|j| Setting::free(format!("s{j}"), "µm")).collect()
}

pub fn plain(deviation: Vec<f64>, sensitivity: Vec<f64>, settings: Vec<Setting>) -> CorrectionSpec {
    CorrectionSpec {
        damping: Damping::Given(Regularization::None),
        ..CorrectionSpec::new(deviation, sensitivity, settings)
    }
}

pub fn solve(asked: CorrectionSpec) -> Solution {
    Correction::new(asked).unwrap().solve().unwrap()
}

pub fn changes(solution: &Solution) -> Vec<f64> {
    solution.settings.iter().map(|s| s.change).collect()
}

fn paths(asked: CorrectionSpec) -> Vec<String> {
    Correction::new(asked).unwrap_err().list().iter().map(|fault| fault.path.clone()).collect()
}

pub fn times(j: &[f64], x: &[f64]) -> Vec<f64> {
    j.chunks_exact(x.len()).map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
}

/// Jᵀ W (d + JΔ), by the normal equations' own sums.
fn gradient(j: &[f64], d: &[f64], w: &[f64], x: &[f64]) -> Vec<f64> {
    let left: Vec<f64> = times(j, x).iter().zip(d).map(|(a, b)| a + b).collect();
    (0..x.len()).map(|c| left.iter().enumerate().map(|(k, r)| w[k] * j[k * x.len() + c] * r).sum()).collect()
}

fn entries(count: usize, size: f64) -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(-size..size, count)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Settings that are off by e, an exact linear response and no noise: −e, and nothing is left.
    #[test]
    fn an_exact_response_is_corrected_in_one_step(j in entries(60, 1.0), e in entries(5, 10.0)) {
        let deviation = times(&j, &e);
        prop_assume!(deviation.iter().any(|d| d.abs() > 1e-3));
        let solution = solve(plain(deviation.clone(), j.clone(), settings(5)));
        prop_assume!(solution.fit.spectrum.condition.unwrap() < 1e6);
        for (change, e) in changes(&solution).iter().zip(&e) {
            prop_assert!((change + e).abs() < 1e-9, "{change} for {e}");
        }
        prop_assert!(solution.predicted.rms_um < 1e-9 && solution.predicted.max_um < 1e-9);
        prop_assert!(solution.settings.iter().all(|s| !s.limited && s.unlimited.is_none()));
        let size = (deviation.iter().map(|d| d * d).sum::<f64>() / 12.0).sqrt();
        prop_assert!((solution.predicted.rms_before_um - size).abs() < 1e-12 * size);
    }

    /// The least-squares correction is linear in the deviations, and so is the prediction.
    #[test]
    fn corrections_superpose(j in entries(40, 1.0), d in entries(10, 5.0), f in entries(10, 5.0), a in -3.0f64..3.0) {
        let sum: Vec<f64> = d.iter().zip(&f).map(|(d, f)| d + a * f).collect();
        let [one, two, both] = [d, f, sum].map(|d| solve(plain(d, j.clone(), settings(4))));
        prop_assume!(one.fit.spectrum.condition.unwrap() < 1e6);
        for k in 0..4 {
            let [x, y, z] = [&one, &two, &both].map(|s| s.settings[k].change);
            prop_assert!((z - x - a * y).abs() < 1e-8 * (1.0 + x.abs() + y.abs()));
        }
        for k in 0..10 {
            let [x, y, z] = [&one, &two, &both].map(|s| s.predicted.deviation_um[k]);
            prop_assert!((z - x - a * y).abs() < 1e-8);
        }
    }

    /// Within limits the answer is the minimum of the weighted sum: the conditions of Karush, Kuhn
    /// and Tucker hold.
    #[test]
    fn limits_hold_with_their_multipliers(
        j in entries(60, 1.0), d in entries(12, 10.0), w in proptest::collection::vec(0.1f64..3.0, 12),
        size in 0.1f64..8.0,
        low in proptest::collection::vec(-1.0f64..0.3, 5), high in proptest::collection::vec(0.3f64..1.0, 5),
    ) {
        let limited: Vec<Setting> = settings(5)
            .into_iter()
            .enumerate()
            .map(|(i, s)| Setting { min: Some(size * low[i]), max: Some(size * high[i]), ..s })
            .collect();
        let spec = plain(d.clone(), j.clone(), limited.clone());
        let solution = solve(CorrectionSpec { weight: Some(w.clone()), ..spec });
        prop_assume!(solution.fit.spectrum.condition.unwrap() < 1e4);
        let x = changes(&solution);
        let gradient = gradient(&j, &d, &w, &x);
        for (i, setting) in solution.settings.iter().enumerate() {
            prop_assert!(limited[i].min.unwrap() <= x[i] && x[i] <= limited[i].max.unwrap());
            if !setting.limited {
                prop_assert!(gradient[i].abs() < 1e-7, "free, gradient {}", gradient[i]);
                prop_assert!(setting.std_error.is_some());
            } else if x[i] == limited[i].min.unwrap() {
                prop_assert!(gradient[i] > -1e-7);
                prop_assert!(setting.std_error.is_none() && setting.bias_bound.is_none());
            } else {
                prop_assert!(x[i] == limited[i].max.unwrap() && gradient[i] < 1e-7);
            }
        }
        let warned = solution.warnings.iter().any(|w| w.code() == "settings_limited");
        prop_assert_eq!(warned, solution.settings.iter().any(|s| s.limited));
        prop_assert!(solution.warnings.iter().all(|w| w.code() != "limits_not_settled"));
    }

    /// A node of weight 2 counts as two nodes of weight 1; weight 0 and an undefined deviation are
    /// as good as no node.
    #[test]
    fn weights_count_nodes_and_undefined_ones_take_no_part(j in entries(40, 1.0), d in entries(10, 5.0)) {
        let mut weight = vec![1.0; 10];
        (weight[2], weight[5]) = (2.0, 0.0);
        let mut undefined = d.clone();
        undefined[7] = f64::NAN;
        let asked = CorrectionSpec { weight: Some(weight), ..plain(undefined, j.clone(), settings(4)) };
        let weighted = Correction::new(asked).unwrap();
        prop_assert_eq!(weighted.counted().len(), 8);
        let weighted = weighted.solve().unwrap();
        prop_assume!(weighted.fit.spectrum.condition.unwrap() < 1e6);
        let kept = [0, 1, 2, 2, 3, 4, 6, 8, 9];
        let rows = kept.iter().flat_map(|&k| j[4 * k..4 * k + 4].to_vec()).collect();
        let repeated = solve(plain(kept.iter().map(|&k| d[k]).collect(), rows, settings(4)));
        for (a, b) in weighted.settings.iter().zip(&repeated.settings) {
            prop_assert!((a.change - b.change).abs() < 1e-8 * (1.0 + b.change.abs()));
        }
        prop_assert!(weighted.predicted.deviation_um[7].is_nan());
        prop_assert!(weighted.predicted.deviation_um[5].is_finite());
        prop_assert!((weighted.predicted.rms_um - repeated.predicted.rms_um).abs() < 1e-9);
    }

    /// Without noise the change misses what is wanted by no more than the bound wherever that has
    /// at most the norm that the bound assumes, of nearly collinear settings as of others.
    #[test]
    fn bounds_hold_for_wanted_changes_within_their_norm(
        j in entries(60, 1.0), wanted in entries(5, 10.0), apart in -6.0f64..0.0,
        limits in proptest::option::of(1.0f64..4.0),
    ) {
        let mut j = j;
        for row in j.chunks_exact_mut(5) {
            row[4] = row[0] - 0.5 * row[1] + 10f64.powf(apart) * row[4];
        }
        let mut settings = settings(5);
        let most: Vec<Option<f64>> =
            wanted.iter().map(|wanted| limits.map(|factor| factor * wanted.abs() + 0.1)).collect();
        for (setting, most) in settings.iter_mut().zip(&most) {
            (setting.min, setting.max) = (most.map(|x| -x), *most);
        }
        let deviation = times(&j, &wanted).iter().map(|d| -d).collect();
        let spec = CorrectionSpec::new(deviation, j.clone(), settings);
        let solution = solve(CorrectionSpec { noise_sigma: Some(1e-6), ..spec });
        prop_assume!(solution.settings.iter().all(|s| !s.limited));
        let bias = &solution.fit.bias;
        let length = |c: usize| j.iter().skip(c).step_by(5).map(|x| x * x).sum::<f64>().sqrt();
        let norm = (0..5).map(|c| (wanted[c] * length(c)).powi(2)).sum::<f64>().sqrt();
        if limits.is_some() {
            prop_assert_eq!(bias.coefficient_norm_limit_source, NormLimitSource::Limits);
            prop_assert!(norm <= bias.coefficient_norm_limit);
        }
        if norm <= bias.coefficient_norm_limit {
            for ((setting, wanted), most) in solution.settings.iter().zip(&wanted).zip(&most) {
                if let Some(most) = most {
                    let farther = setting.change.abs() + most;
                    prop_assert!(setting.bias_bound.unwrap() <= farther * (1.0 + 1e-12), "{setting:?} within {most}");
                }
                let missed = (setting.change - wanted).abs();
                prop_assert!(missed <= setting.bias_bound.unwrap() * (1.0 + 1e-6) + 1e-6, "{missed} {:?}",
                    setting.bias_bound);
            }
        }
    }

    /// Corrections do not depend on the unit that a setting is counted in.
    #[test]
    fn units_of_settings_do_not_matter(seed in 0u64..200, log in proptest::collection::vec(-4.0f64..4.0, 6)) {
        let asked = case::ill_conditioned(seed);
        let deviation = flankfit_engine::gear::simulation::Simulation::new(asked.clone()).unwrap().measure();
        let unit: Vec<f64> = log.iter().map(|x| 10f64.powf(*x)).collect();
        let other = asked.sensitivity.iter().enumerate().map(|(i, x)| x * unit[i % 6]).collect();
        let one = solve(CorrectionSpec::new(deviation.clone(), asked.sensitivity.clone(), asked.settings.clone()));
        let two = solve(CorrectionSpec::new(deviation, other, asked.settings));
        for (k, (a, b)) in one.settings.iter().zip(&two.settings).enumerate() {
            prop_assert!((a.change - b.change * unit[k]).abs() < 1e-6 * (1.0 + a.change.abs()));
        }
    }
}

/// The target need not be 0: it is reached, and the remainder is reported.
#[test]
fn targets_are_reached() {
    let j: Vec<f64> = (0..9).flat_map(|k| [1.0, f64::from(k) - 4.0]).collect();
    let target = times(&j, &[2.0, -0.5]);
    let solution = solve(CorrectionSpec { target: Some(target.clone()), ..plain(vec![0.0; 9], j, settings(2)) });
    assert!((changes(&solution)[0] - 2.0).abs() < 1e-12 && (changes(&solution)[1] + 0.5).abs() < 1e-12);
    assert!(solution.predicted.rms_um < 1e-12 && solution.predicted.rms_before_um > 1.0);
    assert!(solution.predicted.deviation_um.iter().zip(&target).all(|(p, t)| (p - t).abs() < 1e-12));
}

/// The tilt is named together with what it is a mixture of, and λ* keeps its change small.
#[test]
fn settings_that_undecidable_apart_are_named() {
    let asked = case::ill_conditioned(3);
    let deviation = flankfit_engine::gear::simulation::Simulation::new(asked.clone()).unwrap().measure();
    let of = |damping| {
        let asked = CorrectionSpec::new(deviation.clone(), asked.sensitivity.clone(), asked.settings.clone());
        solve(CorrectionSpec { damping, noise_sigma: Some(0.3), ..asked })
    };
    let solution = of(Damping::Uncertainty);
    let [group] = &solution.indistinguishable[..] else { panic!("{:?}", solution.indistinguishable) };
    let mut names = group.names.clone();
    names.sort();
    assert_eq!(names, ["helix_angle", "tilt", "twist"]);
    assert!(group.condition_index.unwrap() > 1e5 && !group.sentence.is_empty());
    let trust = solution.trust.unwrap();
    assert_eq!(trust.damped, 1);
    assert!((trust.from_response - 6.0 * 0.02 * 0.02).abs() < 1e-12);
    assert_eq!(solution.fit.regularization.lambda_star, Some(trust.lambda_star));
    // every error of the response is multiplied with at most 1/√λ*
    for (f, l) in solution.fit.regularization.filter_factors.iter().zip(&solution.fit.spectrum.eigenvalues) {
        assert!(f / l.sqrt() <= trust.gain * (1.0 + 1e-12));
    }
    // a greater r makes the bounds greater in proportion
    let known = CorrectionSpec::new(deviation.clone(), asked.sensitivity.clone(), asked.settings.clone());
    let known = solve(CorrectionSpec { noise_sigma: Some(0.3), coefficient_norm_limit: Some(300.0), ..known });
    let ratio = 300.0 / solution.fit.bias.coefficient_norm_limit;
    for (given, own) in known.settings.iter().zip(&solution.settings) {
        let (given_bound, own_bound) = (given.bias_bound.unwrap(), ratio * own.bias_bound.unwrap());
        assert!(given.change == own.change && (given_bound - own_bound).abs() <= 1e-9 * own_bound);
    }
    let plain = of(Damping::Given(Regularization::None));
    assert!(plain.warnings.iter().any(|w| w.code() == "undamped_correction"));
    assert!(changes(&plain)[5].abs() > 1e3 && changes(&solution).iter().all(|x| x.abs() < 100.0));
    assert!(solution.predicted.rms_um < 1.0);
}

/// The default does not measure itself by the run-away estimate that it is there to avoid: bounds
/// are of the size of settings, and no warning sends the reader back to plain least squares.
#[test]
fn bounds_are_of_the_size_of_settings_and_the_default_does_not_warn_against_itself() {
    for seed in 0..40 {
        let machine = case::ill_conditioned(seed);
        let deviation = flankfit_engine::gear::simulation::Simulation::new(machine.clone()).unwrap().measure();
        let asked = CorrectionSpec::new(deviation, machine.sensitivity.clone(), machine.settings.clone());
        let asked = CorrectionSpec { noise_sigma: Some(0.3), ..asked };
        let own = solve(asked.clone());
        let length = |j: usize| -> f64 {
            let rows = machine.sensitivity.chunks_exact(6).zip(&asked.deviation).filter(|(_, d)| !d.is_nan());
            rows.map(|(row, _)| row[j] * row[j]).sum::<f64>().sqrt()
        };
        // r by its definition: unit columns have Σλ = n, so √n τ is the length of what the settings
        // reach of the deviations
        let square: f64 = asked.deviation.iter().filter(|d| !d.is_nan()).map(|d| d * d).sum();
        let reached = (square - own.fit.residuals.least_squares_rss).sqrt();
        let norm = (0..6).map(|j| (own.settings[j].change * length(j)).powi(2)).sum::<f64>().sqrt();
        let bias = &own.fit.bias;
        assert_eq!(bias.coefficient_norm_limit_source, NormLimitSource::Heights);
        let want = reached.max(norm);
        assert!((bias.coefficient_norm_limit - want).abs() < 1e-6 * want, "{} {want}", bias.coefficient_norm_limit);
        assert!(own.settings.iter().all(|s| s.bias_bound.unwrap() < 100.0), "{seed}: {:?}", own.settings);
        let codes = |s: &Solution| {
            s.fit.warnings.iter().map(|w| w.code()).chain(s.warnings.iter().map(|w| w.code())).collect::<Vec<_>>()
        };
        for code in ["worse_than_least_squares", "norm_limit_contradicted"] {
            assert!(!codes(&own).contains(&code), "{seed}: {:?}", codes(&own));
        }
        // limits of all settings say how far they may have to go
        let mut limited = asked.clone();
        for setting in &mut limited.settings {
            (setting.min, setting.max) = (Some(-200.0), Some(300.0));
        }
        let limited = solve(limited);
        let bias = &limited.fit.bias;
        assert_eq!(bias.coefficient_norm_limit_source, NormLimitSource::Limits);
        let want = (0..6).map(|j| (300.0 * length(j)).powi(2)).sum::<f64>().sqrt();
        assert!((bias.coefficient_norm_limit - want).abs() < 1e-9 * want);
        // a given damping is compared with the service's own
        let lambda_star = Parameter::Fixed(own.trust.unwrap().lambda_star);
        let scheme = Regularization::Spectral {
            scheme: Scheme::Exact,
            count: Count::Given(1),
            condition_limit: 1e12,
            lambda_star,
        };
        let chosen = solve(CorrectionSpec { damping: Damping::Given(scheme), ..asked });
        assert_eq!(chosen.fit.bias.coefficient_norm_limit_source, NormLimitSource::Estimate);
        assert_eq!(changes(&chosen), changes(&own));
    }
}

#[test]
fn errors_have_the_path_of_their_field() {
    let j = vec![1.0; 8];
    let good = CorrectionSpec::new(vec![1.0; 4], j, settings(2));
    assert_eq!(paths(CorrectionSpec { sensitivity: vec![1.0; 7], ..good.clone() }), ["sensitivity.matrix"]);
    assert_eq!(paths(CorrectionSpec { weight: Some(vec![1.0, -1.0, 1.0, 1.0]), ..good.clone() }), ["weight[1]"]);
    assert_eq!(paths(CorrectionSpec { target: Some(vec![1.0]), ..good.clone() }), ["target.deviation_um"]);
    assert_eq!(paths(CorrectionSpec { noise_sigma: Some(0.0), ..good.clone() }), ["noise_sigma_um"]);
    assert_eq!(
        paths(CorrectionSpec { coefficient_norm_limit: Some(-1.0), ..good.clone() }),
        ["coefficient_norm_limit"]
    );
    assert_eq!(paths(CorrectionSpec { response_uncertainty: f64::NAN, ..good.clone() }), ["response_uncertainty"]);
    assert_eq!(paths(CorrectionSpec { deviation: vec![f64::NAN; 4], ..good.clone() }), ["deviation_um"]);
    // too few nodes: by what leaves them
    let undefined = vec![1.0, f64::NAN, f64::NAN, f64::NAN];
    assert_eq!(paths(CorrectionSpec { deviation: undefined, ..good.clone() }), ["sensitivity.settings"]);
    assert_eq!(paths(CorrectionSpec { weight: Some(vec![0.0; 4]), ..good.clone() }), ["weight"]);
    assert_eq!(paths(CorrectionSpec { weight: Some(vec![0.0, 0.0, 0.0, 1.0]), ..good.clone() }), ["weight"]);
    let mut twice = good.clone();
    twice.settings[1].name = "s0".into();
    assert_eq!(paths(twice), ["sensitivity.settings[1]"]);
    let mut crossed = good.clone();
    (crossed.settings[0].min, crossed.settings[0].max) = (Some(1.0), Some(0.0));
    assert_eq!(paths(crossed), ["limits[0].min"]);
    let setting = |change: fn(&mut Setting)| {
        let mut asked = good.clone();
        change(&mut asked.settings[1]);
        paths(asked)
    };
    assert_eq!(setting(|s| s.increment = Some(0.0)), ["limits[1].increment"]);
    assert_eq!(setting(|s| s.increment = Some(f64::INFINITY)), ["limits[1].increment"]);
    assert_eq!(setting(|s| (s.min, s.max, s.increment) = (Some(0.1), Some(0.9), Some(1.0))), ["limits[1].increment"]);
    assert_eq!(setting(|s| (s.fixed, s.min) = (true, Some(0.0))), ["limits[1].min"]);
    let mut still = good.clone();
    still.settings.iter_mut().for_each(|setting| setting.fixed = true);
    assert_eq!(paths(still), ["limits"]);
    assert_eq!(paths(CorrectionSpec { absolute: false, ..good.clone() }), ["absolute"]);
    let infinite = CorrectionSpec { sensitivity: [1.0, f64::INFINITY].repeat(4), ..good };
    assert_eq!(paths(infinite)[0], "sensitivity.matrix[0][1]");
}

/// A regularisation that the service refuses is refused here.
#[test]
fn the_services_refusals_come_through() {
    let j: Vec<f64> = (0..9).flat_map(|k| [1.0, f64::from(k)]).collect();
    let asked = CorrectionSpec::new(vec![1.0; 9], j, settings(2));
    let damping = Damping::Given(Regularization::TruncatedSvd { rank: 7 });
    let error = Correction::new(CorrectionSpec { damping, ..asked }).unwrap().solve().unwrap_err();
    assert!(matches!(error, FitError::Invalid(_)));
}

/// A setting without effect at the nodes is undetermined, and the others are what they are without
/// it.
#[test]
fn a_setting_without_effect_is_undetermined() {
    let d: Vec<f64> = (0..9).map(|k| 0.7 * f64::from(k) + (1.3 * f64::from(k)).sin()).collect();
    let matrix = |columns: usize| -> Vec<f64> {
        (0..9).flat_map(|k| [f64::from(k), (f64::from(k) - 4.0).powi(2), 0.0].into_iter().take(columns)).collect()
    };
    for absolute in [true, false] {
        let of = |columns| solve(CorrectionSpec { absolute, ..plain(d.clone(), matrix(columns), settings(columns)) });
        let (without, with) = (of(2), of(3));
        assert_eq!(with.settings[..2], without.settings[..]);
        assert!(with.settings[2].undetermined && with.settings[2].change == 0.0);
        let warning = with.warnings.iter().find(|warning| warning.code() == "undetermined_settings").unwrap();
        assert_eq!(warning.to_string(), "`s2`: at these nodes it has no independent effect; it is not changed");
    }
    let nothing = CorrectionSpec { absolute: true, ..plain(d, vec![0.0; 9], settings(1)) };
    let faults = Correction::new(nothing).unwrap_err();
    assert!(faults.to_string().contains("no setting that may be changed has an effect"), "{faults}");
}

/// Deviations without a datum: what they have in common changes nothing, and a setting that changes
/// all nodes alike is left alone.
#[test]
fn without_a_datum_a_common_offset_is_no_deviation() {
    let j: Vec<f64> = (0..9).flat_map(|k| [1.0, f64::from(k), (f64::from(k) - 4.0).powi(2)]).collect();
    let d: Vec<f64> = (0..9).map(|k| 0.7 * f64::from(k) + (1.3 * f64::from(k)).sin()).collect();
    let of = |level: f64| {
        let deviation = d.iter().map(|d| d + level).collect();
        let asked = CorrectionSpec {
            weight: Some((0..9).map(|k| f64::from(k % 3 + 1)).collect()),
            response_uncertainty: 0.0,
            ..plain(deviation, j.clone(), settings(3))
        };
        solve(CorrectionSpec { absolute: false, ..asked })
    };
    let (one, other) = (of(0.0), of(50.0));
    assert!(one.settings[0].undetermined && one.settings[0].change == 0.0 && one.settings[0].std_error.is_none());
    assert!(one.warnings.iter().any(|w| w.code() == "undetermined_settings" && w.to_string().contains("`s0`")));
    // the same as with a constant of its own, which is what is left aside
    let asked = CorrectionSpec {
        weight: Some((0..9).map(|k| f64::from(k % 3 + 1)).collect()),
        response_uncertainty: 0.0,
        ..plain(d.clone(), j.clone(), settings(3))
    };
    let whole = solve(asked);
    for k in [1, 2] {
        let (a, b, c) = (&one.settings[k], &other.settings[k], &whole.settings[k]);
        assert!((a.change - b.change).abs() < 1e-9 && (a.change - c.change).abs() < 1e-9);
        assert!((a.std_error.unwrap() / c.std_error.unwrap() - 1.0).abs() < 1e-6, "{a:?} {c:?}");
    }
    assert!(
        (one.predicted.rms_um - whole.predicted.rms_um).abs() < 1e-9
            && (one.predicted.rms_um - other.predicted.rms_um).abs() < 1e-9
    );
    assert_eq!(one.noise.unwrap().freedom, Some(6));
}
