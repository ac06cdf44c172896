//! Slope and crowning over holes: what they answer, how sure they are of it, and when they keep
//! silent.

use crate::gear_evaluation::{gear, near, one, settings, trace};
use crate::oracle::random::Random;
use flankfit_engine::gear::{
    Gear, Kind, Side, Trace,
    evaluation::{
        Evaluated, Evaluation, Posted, evaluate,
        settings::{HelixReference, HelixSettings, MeanCurve, Settings},
    },
};

fn all(gear: &Gear, trace: &Trace, settings: &Settings) -> Evaluation {
    evaluate(gear, &[Posted { trace, design: None }], settings).expect("the trace is sound")
}

fn has(answer: &Evaluation, code: &str) -> bool {
    answer.warnings.iter().any(|warning| warning.code() == code)
}

/// Slopes over the evaluation range.
fn asked(mean: MeanCurve) -> Settings {
    let helix = HelixSettings { reference: HelixReference::EvaluationRange, mean, ..HelixSettings::on([1.0, 19.0]) };
    Settings { helix: Some(helix), ..settings() }
}

/// Slope of the least-squares line over the whole range, height of the least-squares parabola over
/// its chord, and slope of that chord: Legendre's coefficients by Simpson's rule on 4,000 steps,
/// µm.
fn quadrature(shape: impl Fn(f64) -> f64) -> [f64; 3] {
    let steps = 4_000;
    let mut moments = [0.0; 3];
    for k in 0..=steps {
        let u = -1.0 + 2.0 * f64::from(k) / f64::from(steps);
        let weight = if k == 0 || k == steps { 1.0 } else { 2.0 + 2.0 * f64::from(k % 2) };
        let legendre = [1.0, u, 0.5 * (3.0 * u * u - 1.0)];
        for (moment, p) in moments.iter_mut().zip(legendre) {
            *moment += weight * p * shape(u) * 2.0 / f64::from(3 * steps);
        }
    }
    let [_, first, second] = moments;
    [2.0 * 1.5 * first, -1.5 * 2.5 * second, 2.0 * 1.5 * first]
}

/// The trace without samples between two places.
fn holed(whole: &Trace, hole: [f64; 2]) -> Trace {
    let mut trace = whole.clone();
    for (z, d) in trace.at.iter().zip(&mut trace.deviation) {
        let u = (z - 10.0) / 9.0;
        if u > hole[0] && u < hole[1] {
            *d = f64::NAN;
        }
    }
    trace
}

fn figures(answer: &Evaluated) -> Option<[[f64; 2]; 2]> {
    let values = answer.values?;
    Some([[values.slope_um, values.slope_std_error_um?], [values.crowning_um, values.crowning_std_error_um?]])
}

/// Shares of figures within one standard error of the truth, over holes of every width at every
/// place.
struct Coverage {
    estimated: usize,
    silent: usize,
    shares: [f64; 2],
    /// Root mean square of errors over standard errors.
    scores: [f64; 2],
}

fn coverage(
    runs: usize,
    seed: u64,
    widths: [f64; 2],
    shape: impl Fn(&mut Random) -> Box<dyn Fn(f64) -> f64>,
) -> Coverage {
    let (gear, mut random) = (gear(), Random::new(seed));
    let (mut estimated, mut silent, mut hits, mut squares) = (0, 0, [0; 2], [0.0; 2]);
    for run in 0..runs {
        let count = [100, 214, 480][run % 3];
        let mean = [MeanCurve::Line, MeanCurve::Parabola][run % 2];
        let (form, noise) = (shape(&mut random), random.between(0.05, 0.5));
        let mut whole = trace(&gear, Kind::Helix, Side::Left, count, &form);
        whole.deviation.iter_mut().for_each(|d| *d += noise * random.normal());
        let width = 2.0 * random.between(widths[0], widths[1]);
        let from = random.between(-1.1, 1.1 - width);
        let answer = all(&gear, &holed(&whole, [from, from + width]), &asked(mean));
        let truth = quadrature(&form);
        match figures(&answer.traces[0]) {
            Some(found) => {
                estimated += 1;
                for k in 0..2 {
                    let score = (found[k][0] - truth[k]) / found[k][1];
                    hits[k] += usize::from(score.abs() <= 1.0);
                    squares[k] += score * score;
                }
            }
            None => {
                assert!(has(&answer, "hole_in_trace") || has(&answer, "range_not_covered"));
                assert!(answer.traces[0].classes.is_none());
                silent += 1;
            }
        }
    }
    let count = estimated as f64;
    Coverage {
        estimated,
        silent,
        shares: hits.map(|hits| hits as f64 / count),
        scores: squares.map(|sum: f64| (sum / count).sqrt()),
    }
}

/// 0.683 of normal errors lie within one standard error.
#[test]
fn standard_errors_over_holes_hold_on_crowned_traces() {
    let crowned = |random: &mut Random| -> Box<dyn Fn(f64) -> f64> {
        let (slope, crowning) = (random.between(-10.0, 10.0), random.between(-30.0, 30.0));
        Box::new(move |u| 0.5 * slope * u - crowning * u * u)
    };
    let found = coverage(900, 91, [0.05, 0.4], crowned);
    assert!(found.estimated > 400 && found.silent > 200, "{} estimated, {} silent", found.estimated, found.silent);
    // a share of 500 has a standard deviation of 0.021
    assert!(found.shares.iter().all(|share| (0.60..=0.76).contains(share)), "{:?} {:?}", found.shares, found.scores);
}

/// Standard errors over holes include waves: over many random waves they hold as often as stated.
#[test]
fn standard_errors_over_holes_know_of_waves() {
    let waves = |random: &mut Random| -> Box<dyn Fn(f64) -> f64> {
        let crowning = random.between(-30.0, 30.0);
        let each: Vec<[f64; 3]> =
            (0..6).map(|_| [random.between(3.0, 25.0), random.between(0.0, 6.3), random.between(0.0, 1.5)]).collect();
        Box::new(move |u| each.iter().map(|[w, f, a]| a * (w * u + f).sin()).sum::<f64>() - crowning * u * u)
    };
    let found = coverage(450, 92, [0.06, 0.25], waves);
    assert!(found.estimated > 300, "{} estimated", found.estimated);
    assert!(found.shares.iter().all(|share| (0.58..=0.78).contains(share)), "{:?} {:?}", found.shares, found.scores);
}

/// A trace crowned by 20 µm whose slope is 4 µm: class 5 of the gear. Without the side next to one
/// end a line through the rest rises by twice as much.
#[test]
fn a_hole_does_not_turn_a_crowned_trace() {
    let gear = gear();
    let mut random = Random::new(8);
    let mut whole = trace(&gear, Kind::Profile, Side::Left, 214, |u| 2.0 * u - 10.0 * u * u);
    whole.deviation.iter_mut().for_each(|d| *d += 0.1 * random.normal());
    let untouched = all(&gear, &whole, &settings());
    assert_eq!(untouched.traces[0].classes.as_ref().expect("classes").slope, Some(5));
    let without = |from: usize, to: usize| {
        let mut trace = whole.clone();
        trace.deviation[from..to].fill(f64::NAN);
        all(&gear, &trace, &settings())
    };
    for (from, to) in [(12, 52), (60, 100), (90, 130), (150, 190)] {
        let answer = without(from, to);
        let values = answer.traces[0].values.expect("a fifth of the range is missing");
        let error = values.slope_std_error_um.expect("a standard error");
        assert!(error < 0.2 && (values.slope_um - 4.0).abs() < 3.0 * error, "{from}: {} ± {error}", values.slope_um);
        assert_eq!(answer.traces[0].classes.as_ref().and_then(|c| c.slope), Some(5), "{from}");
        assert!(has(&answer, "hole_in_trace"));
    }
    // 27 % are more than may be missing, however they lie
    for (from, to) in [(12, 66), (80, 134), (140, 194), (160, 214)] {
        let answer = without(from, to);
        assert!(answer.traces[0].values.is_none() && answer.traces[0].classes.is_none() && answer.class.is_none());
        assert!(has(&answer, "hole_in_trace") || has(&answer, "range_not_covered"));
    }
}

/// If the hole may hide another class, there is none, and a warning says so.
#[test]
fn a_slope_that_the_hole_leaves_open_has_no_class() {
    let gear = gear();
    let mut random = Random::new(9);
    // noise of 1 µm at the border of two classes
    let whole = all(&gear, &trace(&gear, Kind::Helix, Side::Left, 214, |u| 3.0 * u), &settings());
    let tolerance = |class| {
        let slopes = (1..4000).map(|k| 0.01 * f64::from(k));
        let of = |slope: f64| {
            let trace = trace(&gear, Kind::Helix, Side::Left, 214, |u| 0.45 * slope * u);
            all(&gear, &trace, &settings()).traces[0].classes.as_ref().and_then(|c| c.slope)
        };
        slopes.step_by(10).take_while(|slope| of(*slope) <= Some(class)).last().expect("a tolerance")
    };
    assert!(whole.traces[0].classes.is_some());
    let border = tolerance(5);
    let mut trace = trace(&gear, Kind::Helix, Side::Left, 214, |u| 0.45 * border * u);
    trace.deviation.iter_mut().for_each(|d| *d += random.normal());
    trace.deviation[150..190].fill(f64::NAN);
    let answer = all(&gear, &trace, &settings());
    assert!(answer.traces[0].values.is_some() && answer.traces[0].classes.is_none());
    let warning = answer.warnings.iter().find(|warning| warning.code() == "slope_class_open").expect("a warning");
    assert_eq!(warning.path().as_deref(), Some("traces[0].deviation_um"));
    assert!(warning.to_string().contains("it is too uncertain"), "{}", warning);
}

/// Ends that are not reached: to a twentieth of the range the figures go on, with errors and
/// without classes.
#[test]
fn figures_are_extended_only_slightly_past_the_samples() {
    let gear = gear();
    let cut = |beyond: f64| {
        let mut trace = trace(&gear, Kind::Helix, Side::Left, 214, |u| 3.0 * u - 20.0 * u * u);
        let mut random = Random::new(3);
        for (z, d) in trace.at.iter().zip(&mut trace.deviation) {
            *d = if (z - 10.0) / 9.0 > beyond { f64::NAN } else { *d + 0.1 * random.normal() };
        }
        all(&gear, &trace, &asked(MeanCurve::Line))
    };
    let short = cut(0.93);
    let values = short.traces[0].values.expect("figures");
    near(values.slope_um, 6.0, 3.0 * values.slope_std_error_um.expect("a standard error"));
    near(values.crowning_um, 20.0, 3.0 * values.crowning_std_error_um.expect("a standard error"));
    assert!(has(&short, "range_not_covered") && short.traces[0].classes.is_none());
    let long = cut(0.85);
    assert!(has(&long, "range_not_covered") && long.traces[0].values.is_none() && long.traces[0].classes.is_none());
    // parabolas have no gap, with and without noise
    let exact = trace(&gear, Kind::Helix, Side::Left, 214, |u| 3.0 * u - 20.0 * u * u);
    let values = one(&gear, &holed(&exact, [0.3, 0.7]), &asked(MeanCurve::Line));
    near(values.slope_um, 6.0, 0.02);
    near(values.crowning_um, 20.0, 1e-9);
}
