//! Figures of a flank whose errors are not white.

use flankfit_engine::{
    estimation::{
        FitError, FitSpec,
        inference::ConformityVerdict,
        spec::{Along, Correlation, Errors, Model, Regularization, Variance},
    },
    gear::{
        ProfileAxis,
        evaluation::{
            ToleranceLimits,
            flank_surface::{FlankNodes, FlankSurface, SurfaceSettings, flank_surface},
        },
    },
};

use super::{
    gear_evaluation::{gear, range},
    gear_evaluation_surface::settings_of,
};
use crate::oracle::random::Random;

const PROFILES: usize = 5;
const HELICES: usize = 25;
const RHO: f64 = 0.8;

fn axes() -> (Vec<f64>, Vec<f64>) {
    let [low, high] = range(&gear(), flankfit_engine::gear::Kind::Profile);
    let even = |from: f64, to: f64, count: usize| -> Vec<f64> {
        (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64).collect()
    };
    (even(low, high, PROFILES), even(1.0, 19.0, HELICES))
}

fn plain() -> FitSpec {
    FitSpec { regularization: Regularization::None, ..FitSpec::new(Model::Linear) }
}

fn along(along: Along, rho: Option<f64>) -> FitSpec {
    FitSpec { errors: Some(Errors { correlation: Correlation::Ar1 { rho }, along, lines: None }), ..plain() }
}

fn fitted(deviation: &[f64], grid: bool, settings: &SurfaceSettings) -> Result<FlankSurface, FitError> {
    let (mut profile, mut z) = axes();
    if !grid {
        let places = profile.iter().flat_map(|&p| z.iter().map(move |&z| (p, z)));
        (profile, z) = places.unzip();
    }
    let axis = ProfileAxis::RollLength;
    let nodes = FlankNodes { axis, profile: &profile, z: &z, deviation, valid: None, grid };
    flank_surface(&gear(), &nodes, settings)
}

/// Each profile scanned along the helix, neighbours being alike.
fn scanned(random: &mut Random) -> Vec<f64> {
    (0..PROFILES)
        .flat_map(|_| {
            let mut error = random.normal();
            (0..HELICES)
                .map(|_| {
                    let here = error;
                    error = RHO * error + (1.0 - RHO * RHO).sqrt() * random.normal();
                    here
                })
                .collect::<Vec<f64>>()
        })
        .collect()
}

/// Helix slope and crowning of a flank that has none, and decisions at a limit that the slope of
/// the flank reaches: with the model of the errors they hold, without it they do not.
#[test]
fn figures_and_decisions_take_the_model_of_the_errors() {
    let held = |spec: &FitSpec, draws: usize| {
        let mut random = Random::new(91);
        let limits = ToleranceLimits { helix_slope_um: Some([-1e3, 0.0]), ..ToleranceLimits::default() };
        let asked = settings_of(spec.clone(), limits);
        let (mut hits, mut conforming) = ([0usize; 2], 0usize);
        for _ in 0..draws {
            let found = fitted(&scanned(&mut random), true, &asked).expect("it is fitted");
            for (figure, hits) in [found.helix_slope, found.helix_crowning].iter().zip(&mut hits) {
                let [low, high] = figure.inference.expect("the noise is known").interval;
                *hits += usize::from(low <= 0.0 && 0.0 <= high);
            }
            let slope = found.helix_slope.conformity.expect("there is a limit");
            conforming += usize::from(slope.verdict == ConformityVerdict::Conforms);
        }
        let share = |count: usize| count as f64 / draws as f64;
        (hits.map(share), share(conforming))
    };
    let (intervals, conforming) = held(&along(Along::V, Some(RHO)), 500);
    assert!(intervals.iter().all(|share| (0.93..=0.975).contains(share)), "{intervals:?}");
    assert!((0.03..=0.075).contains(&conforming), "{conforming}");
    let (intervals, conforming) = held(&along(Along::V, None), 80);
    assert!(intervals.iter().all(|share| (0.91..=0.995).contains(share)), "{intervals:?}");
    assert!((0.01..=0.1).contains(&conforming), "{conforming}");
    let (intervals, conforming) = held(&plain(), 300);
    assert!(intervals[0] < 0.6 && conforming > 0.2, "{intervals:?} {conforming}");
}

/// Lines and groups are those of the nodes given, whatever is trimmed.
#[test]
fn lines_and_groups_of_trimmed_nodes_are_left_out() {
    let mut random = Random::new(92);
    let mut deviation = scanned(&mut random);
    let groups: Vec<i64> = (0..deviation.len() as i64).map(|k| k % HELICES as i64 / 9).collect();
    let lines: Vec<i64> = (0..deviation.len() as i64).map(|k| k / HELICES as i64).collect();
    let trimmed = |spec: FitSpec| SurfaceSettings {
        helix_range: Some([5.0, 16.0]),
        ..settings_of(spec, ToleranceLimits::default())
    };
    let grouped = FitSpec { variance: Variance::Groups(groups), ..plain() };
    let of_grid = fitted(&deviation, true, &trimmed(grouped.clone())).expect("it is fitted");
    let scattered = fitted(&deviation, false, &trimmed(grouped.clone())).expect("it is fitted");
    let value = |found: &FlankSurface| found.twist.value;
    assert!((value(&of_grid) - value(&scattered)).abs() < 1e-9);
    assert_eq!(of_grid.result.variance, scattered.result.variance);
    let errors = Errors { correlation: Correlation::Ar1 { rho: Some(RHO) }, along: Along::Order, lines: Some(lines) };
    let lined = FitSpec { errors: Some(errors), ..plain() };
    // a missing node is a step on a grid, and no node of scattered ones
    let of_grid = fitted(&deviation, true, &trimmed(along(Along::V, Some(RHO)))).expect("it is fitted");
    let scattered = fitted(&deviation, false, &trimmed(lined.clone())).expect("it is fitted");
    assert!((value(&of_grid) - value(&scattered)).abs() < 1e-9);
    let refused = |spec: FitSpec| match fitted(&deviation, true, &trimmed(spec)) {
        Err(FitError::Invalid(faults)) => faults.to_string(),
        other => panic!("{other:?}"),
    };
    let short = FitSpec { variance: Variance::Groups(vec![1; 3]), ..plain() };
    let few = format!("variance.groups: 3 entries, but there are {} nodes", PROFILES * HELICES);
    assert_eq!(refused(short), few);
    let power = FitSpec { variance: Variance::Power { of: Along::U, exponent: None }, ..plain() };
    assert!(refused(power).starts_with("variance: the flank's coordinates are mapped"));
    deviation[7] = f64::NAN;
    assert!(fitted(&deviation, true, &trimmed(grouped)).is_ok());
}
