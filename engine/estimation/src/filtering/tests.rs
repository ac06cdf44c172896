//! Filters against their definitions, written out the plain way.

use std::f64::consts::{LN_2, PI, TAU};

use proptest::prelude::*;

use super::steps;
use crate::{
    data::Nodes,
    spec::{Action, Filter, FilterAxis, Gaussian, Hampel, Order, Spline},
};

fn gaussian(cutoff: f64, robust: Option<Order>) -> Filter {
    Filter::Gaussian(Gaussian { axis: Some(FilterAxis::U), cutoff, robust })
}

fn spline(cutoff: f64) -> Filter {
    Filter::Spline(Spline { axis: Some(FilterAxis::U), cutoff })
}

fn hampel(action: Action) -> Filter {
    Filter::Hampel(Hampel { window: 7, threshold: 3.0, action, axis: None })
}

/// Filtered heights of a curve.
fn heights(x: &[f64], y: &[f64], filter: Filter) -> Vec<f64> {
    let nodes = Nodes::curve(x.to_vec(), y.to_vec(), None).unwrap();
    match steps::apply(&nodes, &[filter]).unwrap().nodes {
        Nodes::Curve(curve) => curve.y,
        other => panic!("{other:?}"),
    }
}

fn axis(count: usize, step: f64) -> Vec<f64> {
    (0..count).map(|i| i as f64 * step).collect()
}

/// A ladder of uneven steps.
fn uneven(count: usize) -> Vec<f64> {
    let mut x = 0.0;
    (0..count)
        .map(|i| {
            x += 0.04 + 0.03 * (1.7 * i as f64).sin();
            x
        })
        .collect()
}

/// Amplitude that is left of a sine in the middle of a long line.
fn transmission(filter: Filter, wavelength: f64) -> f64 {
    let x = axis(1601, 0.01);
    let y: Vec<f64> = x.iter().map(|x| (TAU * (x - 8.0) / wavelength).cos()).collect();
    heights(&x, &y, filter)[800]
}

#[test]
fn a_wave_of_the_cutoff_is_halved() {
    for filter in [gaussian(0.8, None), gaussian(0.8, Some(Order::Zero)), gaussian(0.8, Some(Order::Two)), spline(0.8)]
    {
        // a lone sine has no peaks: Tukey's weights lower it a little where the filter is robust
        let bound = if matches!(filter, Filter::Gaussian(Gaussian { robust: Some(_), .. })) { 0.06 } else { 1e-9 };
        let kept = transmission(filter, 0.8);
        assert!((kept - 0.5).abs() <= bound, "{filter:?}: {kept}");
    }
}

#[test]
fn transmission_follows_the_standards() {
    let (cutoff, step) = (0.8, 0.01);
    for wavelength in [0.2, 0.4, 1.6, 3.2] {
        let ratio: f64 = cutoff / wavelength;
        let expected = (-LN_2 * ratio * ratio).exp();
        let kept = transmission(gaussian(cutoff, None), wavelength);
        assert!((kept - expected).abs() < 1e-9, "{wavelength}: {kept} {expected}");
        let sines = (PI * step / wavelength).sin() / (PI * step / cutoff).sin();
        let expected = 1.0 / (1.0 + sines.powi(4));
        let kept = transmission(spline(cutoff), wavelength);
        assert!((kept - expected).abs() < 1e-9, "{wavelength}: {kept} {expected}");
    }
}

#[test]
fn the_linear_gaussian_is_the_normalised_weighted_mean() {
    let x = axis(40, 0.1);
    let y: Vec<f64> = x.iter().map(|x| (3.0 * x).sin() + 0.2 * (17.0 * x).cos()).collect();
    let got = heights(&x, &y, gaussian(0.8, None));
    let alpha = (LN_2 / PI).sqrt();
    for k in 0..x.len() {
        let s = |l: usize| (-PI * ((x[l] - x[k]) / (alpha * 0.8)).powi(2)).exp();
        let expected = (0..40).map(|l| s(l) * y[l]).sum::<f64>() / (0..40).map(s).sum::<f64>();
        assert!((got[k] - expected).abs() < 1e-13, "{k}: {} {expected}", got[k]);
    }
}

/// (I + μQ) w = z with Q = DᵀD of second differences, by elimination.
#[test]
fn the_spline_on_equal_spacing_is_the_standards_system() {
    let (n, step, cutoff) = (30, 0.1, 0.8);
    let x = axis(n, step);
    let z: Vec<f64> = x.iter().map(|x| (2.0 * x).sin() + 0.3 * (23.0 * x).sin()).collect();
    let mu = (1.0 / (2.0 * (PI * step / cutoff).sin())).powi(4);
    let mut a = vec![vec![0.0; n + 1]; n];
    for (i, row) in a.iter_mut().enumerate() {
        row[i] = 1.0;
        row[n] = z[i];
    }
    for k in 0..n - 2 {
        for (i, p) in [1.0, -2.0, 1.0].into_iter().enumerate() {
            for (j, q) in [1.0, -2.0, 1.0].into_iter().enumerate() {
                a[k + i][k + j] += mu * p * q;
            }
        }
    }
    for k in 0..n {
        let pivot = a[k].clone();
        for row in a.iter_mut().skip(k + 1) {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= factor * p);
        }
    }
    let mut w = vec![0.0; n];
    for k in (0..n).rev() {
        w[k] = (a[k][n] - (k + 1..n).map(|j| a[k][j] * w[j]).sum::<f64>()) / a[k][k];
    }
    for (got, expected) in heights(&x, &z, spline(cutoff)).iter().zip(&w) {
        assert!((got - expected).abs() < 1e-12, "{got} {expected}");
    }
}

#[test]
fn a_spline_of_endless_cutoff_is_the_straight_line_of_least_squares() {
    let x = axis(50, 0.1);
    let z: Vec<f64> = (0..50).map(|i| f64::from(i * i % 13)).collect();
    let (mx, mz) = (x.iter().sum::<f64>() / 50.0, z.iter().sum::<f64>() / 50.0);
    let slope = x.iter().zip(&z).map(|(x, z)| (x - mx) * (z - mz)).sum::<f64>()
        / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>();
    for (w, x) in heights(&x, &z, spline(1e6)).iter().zip(&x) {
        assert!((w - (mz + slope * (x - mx))).abs() < 1e-8, "{w}");
    }
}

#[test]
fn constants_lines_and_parabolas_are_kept_to_the_ends() {
    for x in [axis(60, 0.05), uneven(60)] {
        for (y, filter) in [
            (x.iter().map(|_| 3.25).collect::<Vec<f64>>(), gaussian(0.8, None)),
            (x.iter().map(|x| 2.0 - 7.0 * x).collect(), spline(0.8)),
            (x.iter().map(|x| 1.0 - 2.0 * x + 5.0 * x * x).collect(), gaussian(0.8, Some(Order::Two))),
            // whatever the cut-off
            (x.iter().map(|x| 1.0 - 2.0 * x + 5.0 * x * x).collect(), gaussian(500.0, Some(Order::Two))),
        ] {
            for (got, y) in heights(&x, &y, filter).iter().zip(&y) {
                assert!((got - y).abs() <= 1e-9 * (1.0 + y.abs()), "{filter:?}: {got} {y}");
            }
        }
    }
}

#[test]
fn a_robust_filter_does_not_follow_peaks() {
    let x = axis(200, 0.02);
    let smooth: Vec<f64> = x.iter().map(|x| 4.0 * x * x - 3.0 * x).collect();
    let noisy: Vec<f64> = smooth.iter().enumerate().map(|(i, y)| y + 0.01 * (7.3 * (i * i) as f64).sin()).collect();
    let mut peaked = noisy.clone();
    (0..200).step_by(8).for_each(|i| peaked[i] += 5.0);
    let robust = heights(&x, &peaked, gaussian(0.8, Some(Order::Two)));
    let linear = heights(&x, &peaked, gaussian(0.8, None));
    let worst = |z: &[f64]| z.iter().zip(&smooth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst(&robust) < 0.02, "{}", worst(&robust));
    assert!(worst(&linear) > 0.5);
}

/// The robust fixed point, checked by its own equations at every node.
#[test]
fn the_robust_filter_ends_where_weights_and_heights_agree() {
    let x = uneven(80);
    let y: Vec<f64> = x
        .iter()
        .enumerate()
        .map(|(i, x)| (1.3 * x).sin() + if i % 9 == 4 { 3.0 } else { 0.05 * (i as f64 * 2.1).sin() })
        .collect();
    let cutoff = 1.0;
    let w = heights(&x, &y, gaussian(cutoff, Some(Order::Two)));
    let mut r: Vec<f64> = y.iter().zip(&w).map(|(y, w)| (y - w).abs()).collect();
    r.sort_by(f64::total_cmp);
    let c = 4.447_806_655_516_806 * 0.5 * (r[39] + r[40]);
    let cell = |l: usize| match l {
        0 => x[1] - x[0],
        79 => x[79] - x[78],
        l => 0.5 * (x[l + 1] - x[l - 1]),
    };
    for k in 0..80 {
        let p = |l: usize| {
            let u = (y[l] - w[l]) / c;
            let delta = if u.abs() < 1.0 { (1.0 - u * u).powi(2) } else { 0.0 };
            (-PI * ((x[l] - x[k]) / (0.730_913_428 * cutoff)).powi(2)).exp() * cell(l) * delta
        };
        // normal equations of the quadratic about x_k: residuals are orthogonal to 1, t, t² under p
        let mut a = [[0.0; 4]; 3];
        for l in 0..80 {
            let t = x[l] - x[k];
            let powers = [1.0, t, t * t];
            for i in 0..3 {
                (0..3).for_each(|j| a[i][j] += p(l) * powers[i] * powers[j]);
                a[i][3] += p(l) * powers[i] * y[l];
            }
        }
        for i in 0..3 {
            for j in i + 1..3 {
                let factor = a[j][i] / a[i][i];
                (0..4).for_each(|m| a[j][m] -= factor * a[i][m]);
            }
        }
        let b2 = a[2][3] / a[2][2];
        let b1 = (a[1][3] - a[1][2] * b2) / a[1][1];
        let b0 = (a[0][3] - a[0][1] * b1 - a[0][2] * b2) / a[0][0];
        assert!((b0 - w[k]).abs() < 1e-5 * c.max(1e-3), "{k}: {b0} {}", w[k]);
    }
}

#[test]
fn missing_nodes_have_no_say_and_stay_missing() {
    let (u, v) = (axis(12, 0.1), axis(9, 0.5));
    let z: Vec<f64> = (0..108).map(|i| 2.0 + if i == 40 { f64::NAN } else { 0.0 }).collect();
    let grid = Nodes::grid(u, v, z, None, None).unwrap();
    for filter in [gaussian(0.5, None), gaussian(0.5, Some(Order::Zero)), spline(0.5)] {
        let Nodes::Grid(out) = steps::apply(&grid, &[filter]).unwrap().nodes else { panic!() };
        assert!(out.z[40].is_nan());
        assert!(out.z.iter().enumerate().all(|(i, z)| i == 40 || (z - 2.0).abs() < 1e-12), "{filter:?}");
    }
}

/// A window has the requested size, but at most that of the grid, and takes no more memory.
#[test]
fn windows_larger_than_the_grid_cover_all_of_it() {
    let (u, v) = (axis(12, 1.0), axis(9, 1.0));
    let z: Vec<f64> = (0..108).map(|i| if i == 40 { 9.0 } else { 0.01 * (i as f64 * 1.3).sin() }).collect();
    let grid = Nodes::grid(u, v, z, None, None).unwrap();
    let peaks = |window| {
        let filter = Filter::Hampel(Hampel { window, threshold: 6.0, action: Action::Replace, axis: None });
        let report = steps::apply(&grid, &[filter]).unwrap().reports.remove(0);
        assert_eq!(report.node_indices.as_deref(), Some(&[40][..]), "{window}");
        report
    };
    let whole = peaks(25);
    for window in [10_000_001, (1 << 32) + 1, usize::MAX] {
        assert_eq!(peaks(window).max_change, whole.max_change);
    }
    let nothing = Filter::Hampel(Hampel { window: 3, threshold: 1e300, action: Action::Replace, axis: None });
    let untouched = steps::apply(&grid, &[nothing]).unwrap().reports.remove(0);
    assert!(untouched.rms_change == 0.0 && untouched.rms_change.is_sign_positive());
}

#[test]
fn peaks_are_replaced_or_removed() {
    let x = axis(30, 1.0);
    let mut y: Vec<f64> = x.iter().map(|x| 0.1 * (x * 1.9).sin()).collect();
    y[12] = 8.0;
    y[20] = -8.0;
    let nodes = Nodes::curve(x, y, None).unwrap();
    for (action, removed) in [(Action::Replace, 0), (Action::Remove, 2)] {
        let applied = steps::apply(&nodes, &[hampel(action)]).unwrap();
        let report = &applied.reports[0];
        assert_eq!((report.node_indices.as_deref(), report.changed, report.removed), (Some(&[12, 20][..]), 2, removed));
        assert!((report.max_change - 8.0).abs() < 0.2 && report.rms_change < report.max_change);
        let Nodes::Curve(curve) = applied.nodes else { panic!() };
        match action {
            Action::Replace => assert!(curve.weight.is_none() && curve.y.iter().all(|y| y.abs() < 0.2)),
            Action::Remove => {
                let left_out: Vec<usize> = (0..30).filter(|&i| curve.weight.as_ref().unwrap()[i] == 0.0).collect();
                assert_eq!(left_out, [12, 20]);
            }
        }
    }
}

#[test]
fn repeated_measurements_share_their_place() {
    // every node twice is every node once
    let x = axis(40, 0.1);
    let y: Vec<f64> = x.iter().map(|x| (5.0 * x).sin()).collect();
    let twice = |v: &[f64]| v.iter().flat_map(|&v| [v, v]).collect::<Vec<f64>>();
    for filter in [gaussian(0.8, None), spline(0.8)] {
        let (once, doubled) = (heights(&x, &y, filter), heights(&twice(&x), &twice(&y), filter));
        assert!(once.iter().enumerate().all(|(i, w)| (w - doubled[2 * i]).abs() < 1e-13), "{filter:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Linear filters are linear, do not care for the order of nodes, and commute with a change of
    /// unit.
    #[test]
    fn linear_filters_are_linear(
        steps in prop::collection::vec(0.02..0.3f64, 12..40),
        scale in 0.1..10.0f64,
        seed in 0u64..1000,
    ) {
        let x: Vec<f64> = steps.iter().scan(0.0, |at, step| { *at += step; Some(*at) }).collect();
        let y = |phase: f64| x.iter().map(|x| (3.0 * x + phase).sin() * (seed as f64).cos()).collect::<Vec<f64>>();
        let (a, b) = (y(0.3), y(1.9));
        let mixed: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 2.0 * a - 0.5 * b).collect();
        for make in [|cutoff| gaussian(cutoff, None), spline] {
            let (fa, fb, fm) = (heights(&x, &a, make(0.9)), heights(&x, &b, make(0.9)), heights(&x, &mixed, make(0.9)));
            for i in 0..x.len() {
                prop_assert!((fm[i] - (2.0 * fa[i] - 0.5 * fb[i])).abs() < 1e-11);
            }
            let scaled: Vec<f64> = x.iter().map(|x| x * scale).collect();
            for (p, q) in heights(&scaled, &a, make(0.9 * scale)).iter().zip(&fa) {
                prop_assert!((p - q).abs() < 1e-11);
            }
            let (mut rx, mut ra) = (x.clone(), a.clone());
            rx.reverse();
            ra.reverse();
            let turned = heights(&rx, &ra, make(0.9));
            prop_assert!(turned.iter().rev().zip(&fa).all(|(p, q)| p == q));
        }
    }

    /// A low-pass keeps heights between the least and the greatest (Gaussian, order 0).
    #[test]
    fn a_weighted_mean_stays_between(y in prop::collection::vec(-5.0..5.0f64, 5..50)) {
        let x = axis(y.len(), 0.1);
        let (low, high) = (y.iter().copied().fold(f64::MAX, f64::min), y.iter().copied().fold(f64::MIN, f64::max));
        for robust in [None, Some(Order::Zero)] {
            let w = heights(&x, &y, gaussian(0.6, robust));
            prop_assert!(w.iter().all(|w| *w >= low - 1e-12 && *w <= high + 1e-12));
        }
    }
}

/// The filtered columns, written out: S by its definition, figures of S X from cosines and
/// correlations.
#[test]
fn the_columns_are_filtered_as_the_heights_are() {
    use crate::spec::{Degree, FitSpec, Model, PolynomialBasis, Terms};

    let x = uneven(50);
    let y: Vec<f64> = x.iter().map(|x| (2.0 * x).sin()).collect();
    let (n, cutoff, alpha) = (x.len(), 1.5, (LN_2 / PI).sqrt());
    let cell = |l: usize| match l {
        0 => x[1] - x[0],
        l if l + 1 == n => x[l] - x[l - 1],
        l => 0.5 * (x[l + 1] - x[l - 1]),
    };
    let smooth = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..n)
            .map(|k| {
                let p = |l: usize| (-PI * ((x[l] - x[k]) / (alpha * cutoff)).powi(2)).exp() * cell(l);
                (0..n).map(|l| p(l) * f(x[l])).sum::<f64>() / (0..n).map(p).sum::<f64>()
            })
            .collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (one, first, second) = (smooth(&|_| 1.0), smooth(&|x| x), smooth(&|x| x * x));
    let nodes = Nodes::curve(x.clone(), y, None).unwrap();
    let report = |degree: usize| {
        let model =
            Model::Polynomial { degree: Degree::Both(degree), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
        let spec = FitSpec { filters: vec![gaussian(cutoff, None)], ..FitSpec::new(model) };
        super::fit(&nodes, &spec).unwrap().filter_collinearity.unwrap()
    };
    // two columns of unit length at the cosine c have the eigenvalues 1 ± c
    let c = dot(&one, &first) / (dot(&one, &one) * dot(&first, &first)).sqrt();
    let line = report(1);
    let condition = line.after.condition.unwrap();
    assert!((condition / ((1.0 + c) / (1.0 - c)) - 1.0).abs() < 1e-9, "{condition}");
    assert!(condition > line.before.condition.unwrap());
    assert_eq!((line.after.largest_correlation, line.after.nodes), (None, 50));
    let centred = |v: &[f64]| v.iter().map(|x| x - v.iter().sum::<f64>() / n as f64).collect::<Vec<f64>>();
    let (p, q) = (centred(&first), centred(&second));
    let r = dot(&p, &q) / (dot(&p, &p) * dot(&q, &q)).sqrt();
    let parabola = report(2).after;
    assert!((parabola.largest_correlation.unwrap() - r.abs()).abs() < 1e-9);
    assert!((parabola.largest_vif.unwrap() * (1.0 - r * r) - 1.0).abs() < 1e-6);
}

/// A full grid goes through its axes, one with a missing node through every column; both are the
/// same map.
#[test]
fn axes_and_columns_agree() {
    use crate::spec::{Degree, FitSpec, Model, PolynomialBasis, Terms};

    let (u, v) = (axis(15, 0.3), axis(12, 0.5));
    let z: Vec<f64> = (0..180).map(|i| (0.7 * f64::from(i)).sin()).collect();
    let along = |axis| Filter::Gaussian(Gaussian { axis: Some(axis), cutoff: 2.0, robust: None });
    for terms in [Terms::Tensor, Terms::Total] {
        let model = Model::Polynomial { degree: Degree::Both(2), basis: PolynomialBasis::Monomial, terms };
        let filters = vec![along(FilterAxis::V), along(FilterAxis::U)];
        let spec = FitSpec { filters, ..FitSpec::new(model) };
        let figures = |weight: Option<Vec<f64>>| {
            let nodes = Nodes::grid(u.clone(), v.clone(), z.clone(), None, weight).unwrap();
            super::fit(&nodes, &spec).unwrap().filter_collinearity.unwrap().after
        };
        // weights, though all 1, part the axes
        let (by_axes, by_columns) = (figures(None), figures(Some(vec![1.0; 180])));
        let close = |a: Option<f64>, b: Option<f64>| (a.unwrap() / b.unwrap() - 1.0).abs() < 1e-8;
        assert!(close(by_axes.condition, by_columns.condition), "{by_axes:?} {by_columns:?}");
        assert!(close(by_axes.largest_correlation, by_columns.largest_correlation));
        assert!(close(by_axes.largest_vif, by_columns.largest_vif), "{by_axes:?} {by_columns:?}");
    }
}
