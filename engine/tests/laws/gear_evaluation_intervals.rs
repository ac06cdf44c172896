//! Intervals of the figures of flanks and decisions on them, by Monte Carlo.

use flankfit_engine::{
    estimation::{
        FitSpec,
        inference::ConformityVerdict,
        result::IntervalKind,
        spec::{Model, Regularization},
    },
    gear::{
        Kind, ProfileAxis, Side, Trace,
        evaluation::{
            Evaluation, Posted, ToleranceLimits, evaluate,
            flank_surface::{Border, FlankNodes, FlankSurface, SurfaceSettings, flank_surface},
            settings::{HelixReference, HelixSettings, Settings, SlopeSign},
        },
        tolerance::{Characteristic, Tolerances},
    },
};

use super::{
    gear_evaluation::{gear, range, settings, trace},
    gear_evaluation_surface::settings_of,
};
use crate::oracle::random::Random;

/// Three standard errors of a share of 0.95 are 0.021.
const RUNS: usize = 1000;

/// Slopes over the evaluation range, so that they are those of the functions put in.
fn plain() -> Settings {
    let reference = HelixReference::EvaluationRange;
    Settings { helix: Some(HelixSettings { reference, ..HelixSettings::on([1.0, 19.0]) }), ..settings() }
}

fn evaluated(traces: &[Trace], settings: &Settings) -> Evaluation {
    let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
    evaluate(&gear(), &posted, settings).expect("the traces are sound")
}

fn noisy(traces: &[Trace], noise: f64, random: &mut Random) -> Vec<Trace> {
    let mut traces = traces.to_vec();
    traces.iter_mut().flat_map(|trace| &mut trace.deviation).for_each(|d| *d += noise * random.normal());
    traces
}

/// Coverage of the truth by intervals.
fn coverage<const N: usize>(runs: usize, truth: [f64; N], mut draw: impl FnMut() -> [[f64; 2]; N]) -> [f64; N] {
    let mut hits = [0usize; N];
    for _ in 0..runs {
        for ((found, truth), hit) in draw().iter().zip(truth).zip(&mut hits) {
            *hit += usize::from((found[0]..=found[1]).contains(&truth));
        }
    }
    hits.map(|hits| hits as f64 / runs as f64)
}

fn assert_holds(what: &str, covered: &[f64]) {
    assert!(covered.iter().all(|share| (0.93..=0.985).contains(share)), "{what}: {covered:?}");
}

/// Slope and crowning without noise.
fn truth(clean: &Trace, asked: &Settings) -> [f64; 2] {
    let values = evaluated(std::slice::from_ref(clean), asked).traces[0].values.unwrap();
    [values.slope_um, values.crowning_um]
}

fn shape(u: f64) -> f64 {
    3.0 * u - 4.0 * u * u
}

#[test]
fn intervals_of_slope_and_crowning_hold() {
    let (gear, asked) = (gear(), plain());
    for count in [15, 30, 200] {
        let clean = [trace(&gear, Kind::Helix, Side::Left, count, shape)];
        let mut random = Random::new(count as u64);
        let covered = coverage(RUNS, truth(&clean[0], &asked), || {
            let found = evaluated(&noisy(&clean, 0.5, &mut random), &asked).traces.remove(0);
            [found.slope_interval_um.unwrap(), found.crowning_interval_um.unwrap()]
        });
        assert_holds(&format!("{count} samples"), &covered);
    }
}

/// Adds noise of σ 0.5 whose neighbours have the correlation `rho`.
fn correlated(clean: &Trace, rho: f64, random: &mut Random) -> Trace {
    let (mut trace, mut error) = (clean.clone(), 0.5 * random.normal());
    for deviation in &mut trace.deviation {
        *deviation += error;
        error = rho * error + 0.5 * (1.0 - rho * rho).sqrt() * random.normal();
    }
    trace
}

fn is_doubtful(found: &Evaluation) -> bool {
    found.warnings.iter().any(|warning| warning.code() == "correlated_noise")
}

/// Autoregressive noise: intervals hold, or a warning says that they may not, and so does the
/// conformity.
#[test]
fn intervals_hold_with_correlated_noise_or_are_doubted() {
    let limits = ToleranceLimits { helix_slope_um: Some([-50.0, 50.0]), ..ToleranceLimits::default() };
    let (gear, asked) = (gear(), Settings { limits: limits.into(), ..plain() });
    for (count, rho, least, doubted) in [
        (120, 0.6, 0.93, [0.0, 0.3]),
        (201, 0.6, 0.93, [0.0, 0.1]),
        (480, 0.6, 0.93, [0.0, 0.1]),
        (480, 0.9, 0.93, [0.5, 1.0]),
        (120, 0.9, 0.75, [0.75, 1.0]),
        (201, 0.9, 0.88, [0.75, 1.0]),
    ] {
        let clean = trace(&gear, Kind::Helix, Side::Left, count, shape);
        let mut random = Random::new(61_900 + count as u64);
        let (mut warned, mut missed) = (0, 0);
        let truth = truth(&clean, &asked);
        let covered = coverage(RUNS, truth, || {
            let found = evaluated(&[correlated(&clean, rho, &mut random)], &asked);
            let intervals = [found.traces[0].slope_interval_um.unwrap(), found.traces[0].crowning_interval_um.unwrap()];
            let holds = (intervals[0][0]..=intervals[0][1]).contains(&truth[0]);
            let reasons = found.traces[0].slope_conformity.unwrap().reasons;
            assert_eq!(reasons.codes().any(|code| code == "correlated_noise"), is_doubtful(&found));
            warned += usize::from(is_doubtful(&found));
            missed += usize::from(!holds && !is_doubtful(&found));
            intervals
        });
        let share = |n: usize| n as f64 / RUNS as f64;
        println!("AR({rho}), {count} samples: {covered:?}, doubted {}, neither {}", share(warned), share(missed));
        assert!(covered.iter().all(|share| *share >= least), "{count} {rho}: {covered:?}");
        assert!((doubted[0]..=doubted[1]).contains(&share(warned)) && share(missed) <= 0.1, "{count} {rho}");
    }
}

/// Waves without noise that a hole divides are no correlated noise; correlated noise with a hole
/// keeps its warning.
#[test]
fn holes_do_not_make_waves_correlated_noise() {
    let (gear, asked, mut random) = (gear(), plain(), Random::new(952));
    for (count, waves) in [(120, 3.0), (214, 5.0), (214, 20.0), (480, 8.0)] {
        for [from, to] in [[0.45, 0.51], [0.2, 0.27]] {
            let holed = |mut trace: Trace| {
                let at = |share: f64| (share * count as f64) as usize;
                trace.deviation[at(from)..at(to)].fill(f64::NAN);
                trace
            };
            let wave = |u: f64| 2.0 * (waves * u + 0.3).sin() + 4.0 * u;
            let clean = trace(&gear, Kind::Helix, Side::Left, count, wave);
            assert!(!is_doubtful(&evaluated(&[holed(clean.clone())], &asked)), "{count} {waves} {from}");
            let doubted = (0..50)
                .filter(|_| is_doubtful(&evaluated(&[holed(correlated(&clean, 0.9, &mut random))], &asked)))
                .count();
            assert!(doubted >= 30, "{count} {waves} {from}: {doubted}");
        }
    }
}

/// Traces too short for figures of their own count in a surface, whose doubts have a warning; two
/// places determine no noise.
#[test]
fn doubts_of_a_surface_have_their_warning() {
    let limits = ToleranceLimits { helix_slope_um: Some([-50.0, 50.0]), ..ToleranceLimits::default() };
    let (gear, asked) = (gear(), Settings { limits: limits.into(), ..plain() });
    let half = |section: f64, tooth: &str| {
        let mut trace = trace(&gear, Kind::Helix, Side::Left, 120, shape);
        (trace.tooth, trace.section) = (tooth.into(), Some(section));
        trace.at.iter_mut().for_each(|z| *z = 6.0 + 0.3 * *z);
        trace
    };
    let rolls = range(&gear, Kind::Profile);
    let at = |share: f64| gear.diameter(rolls[0] + share * (rolls[1] - rolls[0]));
    let clean = [half(at(0.2), "1f"), half(at(0.8), "1k")];
    let mut random = Random::new(951);
    let mut doubted = 0;
    for _ in 0..40 {
        let found = evaluated(&clean.each_ref().map(|clean| correlated(clean, 0.9, &mut random)), &asked);
        assert!(found.traces.iter().all(|trace| trace.values.is_none()));
        let slope = found.surfaces[0].figures.helix_slope.unwrap().conformity.unwrap();
        let is_doubted = slope.reasons.codes().any(|code| code == "correlated_noise");
        assert_eq!(is_doubted, is_doubtful(&found));
        doubted += usize::from(is_doubted);
    }
    assert!(doubted > 30, "{doubted}");
    let few = clean.each_ref().map(|clean| {
        let mut trace = correlated(clean, 0.0, &mut random);
        trace.at.iter_mut().enumerate().for_each(|(k, z)| *z = if k % 2 == 0 { 6.0 } else { 12.0 });
        trace
    });
    let found = evaluated(&few, &asked);
    assert!(found.surfaces.iter().all(|one| one.figures.helix_slope.is_none_or(|slope| slope.std_error.is_none())));
}

/// Mean width of the slope's interval over that of the true noise, and the share of doubts.
fn widths(count: usize, flank: impl Fn(f64) -> f64 + Copy) -> [f64; 2] {
    let (gear, asked) = (gear(), plain());
    let clean = trace(&gear, Kind::Helix, Side::Left, count, flank);
    let mut random = Random::new(700 + count as u64);
    let (mut width, mut doubts) = (0.0, 0);
    for _ in 0..RUNS {
        let found = evaluated(&[correlated(&clean, 0.0, &mut random)], &asked);
        let [low, high] = found.traces[0].slope_interval_um.unwrap();
        width += 0.5 * (high - low) / RUNS as f64;
        doubts += usize::from(is_doubtful(&found));
    }
    // samples within 1 to 19 mm of 20: the slope over [−1, 1] of independent noise
    let used = evaluated(std::slice::from_ref(&clean), &asked).traces[0].samples.used as f64;
    [width / (1.96 * 0.5 * 2.0 * (3.0 / used).sqrt()), doubts as f64 / RUNS as f64]
}

/// Reliefs, waves and crowning with independent noise are not taken for correlated noise.
#[test]
fn a_smooth_flank_is_not_taken_for_correlated_noise() {
    let relief = |u: f64| shape(u) - 40.0 * (u - 0.6).max(0.0);
    let curved = |u: f64| -100.0 * (u - 0.6).max(0.0).powi(2) - 20.0 * (-0.7 - u).max(0.0);
    let wave = |periods: f64| move |u: f64| 2.0 * (std::f64::consts::PI * periods * u).sin();
    let mut all = Vec::new();
    for count in [120, 200, 480] {
        let found = [widths(count, relief), widths(count, curved), widths(count, wave(3.0)), widths(count, wave(8.0))];
        println!("{count}: {:?}, {found:?}", widths(count, shape));
        all.extend(found);
    }
    assert!(all.iter().all(|[width, doubts]| *width < 3.3 && *doubts <= 0.06), "{all:?}");
    assert!(all.iter().map(|[width, _]| width).sum::<f64>() / all.len() as f64 <= 1.5, "{all:?}");
    let [width, doubts] = widths(200, shape);
    assert!(width < 1.08 && doubts <= 0.002, "{width} {doubts}");
}

/// Over a hole the interval has what the hole may hide: it is wider than without, and holds.
#[test]
fn intervals_over_a_hole_hold() {
    let (gear, asked) = (gear(), plain());
    let hole = |u: f64| if (0.1..0.35).contains(&u) { f64::NAN } else { shape(u) };
    let clean = [trace(&gear, Kind::Helix, Side::Left, 120, hole)];
    let mut random = Random::new(5);
    let whole = trace(&gear, Kind::Helix, Side::Left, 120, shape);
    let covered = coverage(300, truth(&whole, &asked), || {
        let found = evaluated(&noisy(&clean, 0.5, &mut random), &asked).traces.remove(0);
        [found.slope_interval_um.unwrap(), found.crowning_interval_um.unwrap()]
    });
    assert!(covered.iter().all(|share| (0.91..=1.0).contains(share)), "{covered:?}");
}

#[test]
fn intervals_of_twists_and_of_the_surface_of_traces_hold() {
    let (gear, asked) = (gear(), plain());
    let rolls = range(&gear, Kind::Profile);
    let at = |u: f64| gear.diameter(0.5 * (rolls[0] + rolls[1]) + 0.5 * u * (rolls[1] - rolls[0]));
    let material = |u: f64, v: f64| 2.0 * u + 1.0 * v - 3.0 * u * u - 5.0 * v * v + 1.5 * u * v;
    let helix = |u: f64, tooth: &str| Trace {
        tooth: tooth.into(),
        section: Some(at(u)),
        ..trace(&gear, Kind::Helix, Side::Left, 60, |v| material(u, v))
    };
    let profile = Trace { section: Some(10.0), ..trace(&gear, Kind::Profile, Side::Left, 60, |u| material(u, 0.0)) };
    let clean = [helix(-0.8, "1f"), helix(0.8, "1k"), profile];
    // slopes of helices over [−1, 1]: 2 (1 + 1.5 u)
    let truth = [2.0 * 1.5 * 1.6, 4.0, 2.0, 3.0, 5.0, 6.0];
    let sound = evaluated(&clean, &asked).surfaces.remove(0).figures;
    let values = [sound.profile_slope, sound.helix_slope, sound.profile_crowning, sound.helix_crowning, sound.twist];
    for (value, truth) in values.iter().zip(&truth[1..]) {
        assert!((value.unwrap().value.abs() - truth).abs() < 1e-6, "{value:?} {truth}");
    }
    let signs: Vec<f64> = values.iter().map(|value| value.unwrap().value.signum()).collect();
    let twist = evaluated(&clean, &asked).twists[0].twist_um;
    assert!((twist.abs() - truth[0]).abs() < 1e-6);
    let mut random = Random::new(41);
    let mut twists = 0;
    let truth: [f64; 5] = std::array::from_fn(|k| signs[k] * truth[k + 1]);
    let covered = coverage(RUNS, truth, || {
        let found = evaluated(&noisy(&clean, 0.4, &mut random), &asked);
        let [low, high] = found.twists[0].interval_um.unwrap();
        twists += usize::from(low <= twist && twist <= high);
        let f = &found.surfaces[0].figures;
        [f.profile_slope, f.helix_slope, f.profile_crowning, f.helix_crowning, f.twist]
            .map(|figure| figure.unwrap().inference.unwrap().interval)
    });
    assert_holds("surface", &covered);
    assert_holds("twist of two helices", &[twists as f64 / RUNS as f64]);
}

/// Rate of each outcome on the slope of a helix that is `slope`.
fn decisions(slope: f64, limits: ToleranceLimits) -> [f64; 3] {
    let (gear, mut random) = (gear(), Random::new(77));
    let clean = [trace(&gear, Kind::Helix, Side::Left, 40, |u| 0.5 * slope * u)];
    let asked = Settings { limits: limits.into(), sign: SlopeSign::Vdi, ..plain() };
    let mut made = [0usize; 3];
    for _ in 0..RUNS {
        let found = evaluated(&noisy(&clean, 1.0, &mut random), &asked).traces.remove(0);
        let conformity = found.slope_conformity.unwrap();
        assert_eq!(conformity.probability[0], conformity.probability[1]);
        made[conformity.verdict as usize] += 1;
    }
    made.map(|made| made as f64 / RUNS as f64)
}

/// A part at its limit is found to conform, or not to, in one measurement of twenty each.
#[test]
fn a_part_at_its_limit_rarely_conforms() {
    let limits = ToleranceLimits { helix_slope_um: Some([-50.0, 6.0]), ..ToleranceLimits::default() };
    let order = [ConformityVerdict::Conforms, ConformityVerdict::Undecidable, ConformityVerdict::DoesNotConform];
    assert_eq!(order.map(|outcome| outcome as usize), [0, 1, 2]);
    let [conforms, open, not] = decisions(6.0, limits);
    assert!((0.02..=0.071).contains(&conforms) && (0.02..=0.071).contains(&not), "{conforms} {not} {open}");
    let [conforms, _, not] = decisions(3.0, limits);
    assert!(conforms > 0.95 && not == 0.0, "{conforms} {not}");
    let [conforms, _, not] = decisions(9.0, limits);
    assert!(conforms == 0.0 && not > 0.95, "{conforms} {not}");
    // by the class: at f_HβT of class 4
    let class = ToleranceLimits { class: Some(4), ..ToleranceLimits::default() };
    let tolerance = Tolerances::new(&gear()).unwrap().rounded(Characteristic::HelixSlope, 4).unwrap();
    let [conforms, _, not] = decisions(tolerance, class);
    assert!((0.02..=0.071).contains(&conforms) && (0.02..=0.071).contains(&not), "{conforms} {not}");
}

struct Grid {
    profile: Vec<f64>,
    z: Vec<f64>,
    deviation: Vec<f64>,
}

/// Five by nine nodes.
fn grid(mut of: impl FnMut(f64, f64) -> f64) -> Grid {
    let t = |i: usize, n: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    Grid {
        profile: (0..5).map(|i| 22.0 + 4.0 * t(i, 5)).collect(),
        z: (0..9).map(|j| 10.0 + 9.0 * t(j, 9)).collect(),
        deviation: (0..45).map(|k| of(t(k / 9, 5), t(k % 9, 9))).collect(),
    }
}

fn fitted(grid: &Grid, settings: &SurfaceSettings) -> FlankSurface {
    let Grid { profile, z, deviation } = grid;
    let axis = ProfileAxis::RollLength;
    let nodes = FlankNodes { axis, profile, z, deviation, valid: None, grid: true };
    flank_surface(&gear(), &nodes, settings).expect("the nodes are sound")
}

const COEFFICIENTS: [f64; 6] = [1.0, 2.0, -1.0, -3.0, 1.5, -5.0];

fn terms(u: f64, v: f64) -> [f64; 6] {
    [1.0, u, v, u * u, u * v, v * v]
}

#[test]
fn intervals_of_the_surface_of_a_flank_hold() {
    let height = |u: f64, v: f64| terms(u, v).iter().zip(COEFFICIENTS).map(|(x, c)| x * c).sum::<f64>();
    let norm = {
        let length = |k: usize| grid(|u, v| terms(u, v)[k].powi(2)).deviation.iter().sum::<f64>();
        (0..6).map(|k| length(k) * COEFFICIENTS[k].powi(2)).sum::<f64>().sqrt()
    };
    let base = FitSpec::new(Model::Linear);
    let plain = FitSpec { regularization: Regularization::None, ..base.clone() };
    let limited = FitSpec { coefficient_norm_limit: Some(norm), ..base.clone() };
    let ridge = Regularization::Ridge { parameter: flankfit_engine::estimation::spec::Parameter::Fixed(0.3) };
    let regularized = FitSpec { regularization: ridge, ..base };
    let truth = [4.0, -2.0, 3.0, 5.0, 6.0];
    for (spec, kind) in
        [(plain, IntervalKind::Student), (regularized, IntervalKind::LeastSquares), (limited, IntervalKind::BiasAware)]
    {
        let asked = settings_of(spec, ToleranceLimits::default());
        let mut random = Random::new(13);
        let covered = coverage(RUNS, truth, || {
            let measured = grid(|u, v| height(u, v) + 3.0 * random.normal());
            let s = fitted(&measured, &asked);
            let found = [s.profile_slope, s.helix_slope, s.profile_crowning, s.helix_crowning, s.twist];
            let found = found.map(|figure| figure.inference.unwrap());
            assert!(found.iter().all(|one| one.kind == kind || kind == IntervalKind::BiasAware));
            found.map(|one| one.interval)
        });
        // what a norm limit wins may hold more often than it says
        let most = if kind == IntervalKind::BiasAware { 1.0 } else { 0.972 };
        assert!(covered.iter().all(|share| (0.93..=most).contains(share)), "{kind:?}: {covered:?}");
    }
}

/// With a bias the probability is a range, and a twist at its limit still conforms in at most one
/// measurement of twenty.
#[test]
fn decisions_on_biased_figures_are_no_bolder() {
    let length = |k: usize| grid(|u, v| terms(u, v)[k].powi(2)).deviation.iter().sum::<f64>();
    // nearly all of the norm is in the twist; were it all, a limit given exactly would prove alone
    // that the twist is no greater than what it is
    let (c, norm) = (2.0, 1.02 * 2.0 * length(4).sqrt());
    let spec = FitSpec { coefficient_norm_limit: Some(norm), ..FitSpec::new(Model::Linear) };
    let limits = ToleranceLimits { twist_um: Some([-60.0, 4.0 * c]), ..ToleranceLimits::default() };
    let asked = settings_of(spec, limits);
    let mut random = Random::new(3);
    let (mut conforms, mut apart) = (0, 0);
    for _ in 0..RUNS {
        let measured = grid(|u, v| c * u * v + 3.0 * random.normal());
        let found = fitted(&measured, &asked).twist.conformity.unwrap();
        assert!(found.probability[0] <= found.probability[1]);
        apart += usize::from(found.probability[0] < found.probability[1]);
        conforms += usize::from(found.verdict == ConformityVerdict::Conforms);
    }
    assert!(apart > RUNS / 2 && conforms as f64 <= 0.07 * RUNS as f64, "{apart} {conforms}");
}

#[test]
fn slopes_over_a_part_of_the_flank_have_their_share_of_a_class() {
    let limits = ToleranceLimits { class: Some(6), ..ToleranceLimits::default() };
    let mut asked = settings_of(FitSpec::new(Model::Linear), limits);
    asked.border = Border { root: 25.0, tip: 25.0, toe: 0.0, heel: 0.0 };
    let mut random = Random::new(3);
    let s = fitted(&grid(|u, v| u + v + 0.1 * random.normal()), &asked);
    let tolerances = Tolerances::new(&gear()).unwrap();
    let of = |characteristic| tolerances.rounded(characteristic, 6).unwrap();
    let high = |figure: flankfit_engine::gear::evaluation::flank_surface::Figure| figure.conformity.unwrap().limits[1];
    assert!((high(s.profile_slope) - 0.5 * of(Characteristic::ProfileSlope)).abs() < 1e-9);
    let width = gear().data().face_width.unwrap();
    assert!((high(s.helix_slope) - 18.0 / width * of(Characteristic::HelixSlope)).abs() < 1e-9);
    assert!(s.twist.conformity.is_none());
}

#[test]
fn limits_and_levels_that_there_are_not_are_refused() {
    let clean = [trace(&gear(), Kind::Helix, Side::Left, 40, shape)];
    let refused = |settings: Settings| {
        let posted: Vec<Posted> = clean.iter().map(|trace| Posted { trace, design: None }).collect();
        let faults = evaluate(&gear(), &posted, &settings).unwrap_err();
        let fault = &faults.list()[0];
        (fault.path.clone(), fault.message.clone())
    };
    let limits = |limits: ToleranceLimits| Settings { limits: limits.into(), ..settings() };
    let none = ToleranceLimits::default();
    let turned = refused(limits(ToleranceLimits { twist_um: Some([2.0, -2.0]), ..none }));
    assert_eq!(turned.0, "evaluation.tolerance_limits.left.twist_um");
    assert!(turned.1.starts_with("2 to -2 µm is not a range"), "{}", turned.1);
    let class = refused(limits(ToleranceLimits { class: Some(12), ..none }));
    assert_eq!(class.0, "evaluation.tolerance_limits.class");
    let level = refused(Settings { level: 1.0, ..settings() });
    assert_eq!(level.0, "evaluation.level");
    assert!(level.1.starts_with("1 is not a level"), "{}", level.1);
}
