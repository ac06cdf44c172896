//! Evaluation of measured flanks: `cargo xtask bench gear_evaluation`. A whole gear of 60 teeth
//! (profile and helix of both flanks, 480 samples each), the second-order surface of a flank, and
//! pitch with run-out.

use divan::{Bencher, black_box, counter::ItemsCount};
use flankfit_engine::{
    estimation::{
        FitSpec,
        spec::{Degree, Model, PolynomialBasis, Terms},
    },
    gear::{
        Gear, GearData, Hand, Kind, ProfileAxis, Side, Trace,
        evaluation::{
            Posted, ToleranceLimits, evaluate,
            flank_surface::{Border, FigureTerms, FlankNodes, SurfaceSettings, flank_surface},
            pitch::{PitchMeasured, PitchSettings, pitch},
            runout::{Counting, from_pitches},
            settings::{DeviationSign, HelixSettings, ProfileSettings, Settings, SlopeSign},
        },
        tolerance::Rounding,
        trace::Direction,
    },
};

const TEETH: u32 = 60;
const SAMPLES: usize = 480;

fn gear() -> Gear {
    Gear::new(GearData {
        teeth: TEETH,
        normal_module: 2.0,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 15f64.to_radians(),
        hand: Hand::Right,
        profile_shift: 0.0,
        face_width: Some(20.0),
        tip_diameter: None,
        root_diameter: None,
        internal: false,
        tool: None,
    })
    .expect("the gear exists")
}

/// A deviation without a pattern that would suit the evaluation.
fn deviation(seed: usize, t: f64) -> f64 {
    let s = seed as f64;
    8.0 * t * (0.7 * s).sin() - 5.0 * t * t + 1.5 * (31.0 * t + s).sin() + 0.5 * (170.0 * t + 3.0 * s).cos()
}

fn traces(gear: &Gear) -> Vec<Trace> {
    let roll = |d: f64| gear.roll_length(d).expect("above the base circle");
    let mut traces = Vec::new();
    for tooth in 0..TEETH as usize {
        for side in [Side::Left, Side::Right] {
            for (kind, low, high) in [(Kind::Profile, roll(120.5), roll(128.2)), (Kind::Helix, 0.0, 20.0)] {
                let t = |i: usize| i as f64 / (SAMPLES - 1) as f64;
                traces.push(Trace {
                    tooth: (tooth + 1).to_string(),
                    side,
                    kind,
                    at: (0..SAMPLES).map(|i| low + (high - low) * t(i)).collect(),
                    section: None,
                    deviation: (0..SAMPLES).map(|i| deviation(traces.len(), t(i))).collect(),
                });
            }
        }
    }
    traces
}

#[divan::bench]
fn gear_of_60_teeth_with_480_samples_a_trace(bencher: Bencher) {
    let gear = gear();
    let traces = traces(&gear);
    let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
    let settings = Settings {
        profile: Some(ProfileSettings::on([121.0, 128.0])),
        helix: Some(HelixSettings::on([1.0, 19.0])),
        ..Settings::default()
    };
    bencher
        .counter(ItemsCount::new(traces.len()))
        .bench_local(|| evaluate(&gear, black_box(&posted), &settings).expect("the traces are sound"));
}

#[divan::bench(args = [(5, 9), (50, 100), (1_000, 1_000)], max_time = 3)]
fn flank_surface_of_a_grid(bencher: Bencher, (rows, columns): (usize, usize)) {
    let gear = gear();
    let profile: Vec<f64> = (0..rows).map(|i| 22.0 + 8.0 * i as f64 / rows as f64).collect();
    let z: Vec<f64> = (0..columns).map(|j| 20.0 * j as f64 / columns as f64).collect();
    let heights: Vec<f64> = (0..rows * columns).map(|k| deviation(k / columns, (k % columns) as f64)).collect();
    let model = Model::Polynomial { degree: Degree::Both(2), basis: PolynomialBasis::Monomial, terms: Terms::Total };
    let settings = SurfaceSettings {
        side: Side::Left,
        profile_range: None,
        helix_range: None,
        border: Border { root: 5.0, tip: 5.0, toe: 5.0, heel: 5.0 },
        given: DeviationSign::Material,
        direction: Direction::Transverse,
        terms: FigureTerms::default(),
        sign: SlopeSign::Din,
        limits: ToleranceLimits::default(),
        spec: FitSpec::new(model),
    };
    let axis = ProfileAxis::RollLength;
    let nodes = FlankNodes { axis, profile: &profile, z: &z, deviation: &heights, valid: None, grid: true };
    bencher
        .counter(ItemsCount::new(rows * columns))
        .bench_local(|| flank_surface(&gear, black_box(&nodes), &settings).expect("the nodes are sound"));
}

#[divan::bench]
fn pitch_and_runout_of_60_teeth(bencher: Bencher) {
    let gear = gear();
    let of = |seed: usize| (0..TEETH as usize).map(|i| deviation(seed, i as f64)).collect::<Vec<_>>();
    let measured = [PitchMeasured::Index(of(1)), PitchMeasured::Index(of(2))];
    bencher.bench_local(|| {
        let [left, right] = [(Side::Left, &measured[0]), (Side::Right, &measured[1])].map(|(side, measured)| {
            let settings = PitchSettings { side, diameter: None, sector: None, rounding: Rounding::Rounded };
            pitch(&gear, black_box(measured), &settings).expect("sound")
        });
        from_pitches(&gear, &left, &right, Counting::Clockwise, Rounding::Rounded).expect("sound")
    });
}
