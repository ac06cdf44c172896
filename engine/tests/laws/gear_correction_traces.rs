//! Corrections by traces that have a zero each.

use crate::oracle::random::Random;
use flankfit_engine::estimation::spec::Regularization;
use flankfit_engine::gear::correction::machine::{FlankNode, Machine, Ranges};
use flankfit_engine::gear::correction::{
    Answer, Correction, CorrectionSpec, Damping, Noise, Setting, Solution, Verdict, compare,
};
use flankfit_engine::gear::{Gear, GearData, Hand, Side};

fn plain(deviation: Vec<f64>, sensitivity: Vec<f64>, settings: Vec<Setting>) -> CorrectionSpec {
    CorrectionSpec {
        damping: Damping::Given(Regularization::None),
        response_uncertainty: 0.0,
        ..CorrectionSpec::new(deviation, sensitivity, settings)
    }
}

fn solve(asked: CorrectionSpec) -> Solution {
    Correction::new(asked).unwrap().solve().unwrap()
}

fn settings(n: usize) -> Vec<Setting> {
    (0..n).map(|j| Setting::free(format!("s{j}"), "µm")).collect()
}

/// u, v and the trace of each node, the traces one after the other.
fn nodes(profiles: &[f64], helices: &[f64], count: usize) -> Vec<Node> {
    let along = |k: usize| 2.0 * k as f64 / (count - 1) as f64 - 1.0;
    let profile = |(t, v): (usize, &f64)| (0..count).map(move |k| (along(k), *v, t)).collect::<Vec<_>>();
    let helix = |(t, u): (usize, &f64)| (0..count).map(move |k| (*u, along(k), profiles.len() + t)).collect::<Vec<_>>();
    let profiles_there = profiles.iter().enumerate().flat_map(profile);
    profiles_there.chain(helices.iter().enumerate().flat_map(helix)).collect()
}

/// The same changes, errors and noise as with a constant of its own for each trace, and whatever
/// the zeros are.
#[test]
fn centring_each_trace_is_a_constant_for_each() {
    let mut random = Random::new(3);
    let nodes = nodes(&[-0.6, 0.5], &[-0.4, 0.7], 12);
    let trace: Vec<usize> = nodes.iter().map(|node| node.2 + 7).collect();
    let j: Vec<f64> = nodes.iter().flat_map(|(u, v, _)| [u + 0.2 * v, v - u * u, u * v, 0.1 + v * v]).collect();
    let mut d: Vec<f64> = nodes.iter().map(|(u, v, _)| 4.0 * u - 3.0 * v + 2.0 * u * v + random.normal()).collect();
    d[5] = f64::NAN;
    let weight: Vec<f64> = (0..d.len()).map(|k| (k % 3) as f64).collect();
    let of = |zeros: [f64; 4]| {
        let deviation = d.iter().zip(&nodes).map(|(d, node)| d + zeros[node.2]).collect();
        let asked = plain(deviation, j.clone(), settings(4));
        solve(CorrectionSpec { absolute: false, traces: Some(trace.clone()), weight: Some(weight.clone()), ..asked })
    };
    let (one, other) = (of([0.0; 4]), of([30.0, -12.0, 5.0, 77.0]));
    let constants = |node: &(f64, f64, usize)| (0..4).map(|t| f64::from(u8::from(t == node.2))).collect::<Vec<_>>();
    let whole = j.chunks_exact(4).zip(&nodes).flat_map(|(row, node)| [row.to_vec(), constants(node)].concat());
    let asked = plain(d.clone(), whole.collect(), settings(8));
    let whole = solve(CorrectionSpec { weight: Some(weight.clone()), ..asked });
    for k in 0..4 {
        let (a, b, c) = (&one.settings[k], &other.settings[k], &whole.settings[k]);
        assert!((a.change - b.change).abs() < 1e-9 && (a.change - c.change).abs() < 1e-9, "{a:?} {b:?} {c:?}");
        assert!((a.std_error.unwrap() / c.std_error.unwrap() - 1.0).abs() < 1e-6, "{a:?} {c:?}");
        assert!(!a.undetermined);
    }
    assert_eq!(one.noise.unwrap().freedom, whole.noise.unwrap().freedom);
    assert!((one.noise.unwrap().sigma / whole.noise.unwrap().sigma - 1.0).abs() < 1e-9);
    for (a, b) in
        [(one.predicted.rms_um, other.predicted.rms_um), (one.predicted.rms_before_um, other.predicted.rms_before_um)]
    {
        assert!((a - b).abs() < 1e-9);
    }
    assert!((one.predicted.rms_um - whole.predicted.rms_um).abs() < 1e-9);
}

/// Profile and helix coordinate of a node, each over [-1, 1], and its trace.
type Node = (f64, f64, usize);

fn machine(profiles: &[f64], helices: &[f64]) -> (Vec<Setting>, Vec<f64>, Vec<usize>, Vec<Node>) {
    let gear = Gear::new(GearData {
        teeth: 26,
        normal_module: 2.5,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 24f64.to_radians(),
        hand: Hand::Right,
        profile_shift: 0.3,
        face_width: Some(24.0),
        tip_diameter: None,
        root_diameter: None,
        internal: false,
        tool: None,
    })
    .unwrap();
    let at = |radius: f64| gear.roll_length(2.0 * radius).unwrap();
    let r = gear.reference_radius();
    let ranges = Ranges { profile: [at(r - 1.0), at(r + 2.0)], helix: [-10.0, 10.0] };
    let nodes = nodes(profiles, helices, 15);
    let [low, high] = ranges.profile;
    let place = |(u, v, _): &Node| FlankNode {
        side: Side::Left,
        roll_length: 0.5 * (low + high) + 0.5 * (high - low) * u,
        z: 10.0 * v,
    };
    let places: Vec<FlankNode> = nodes.iter().map(place).collect();
    let found = Machine::FormGrinding.sensitivity(&gear, &places, ranges).unwrap();
    let traces = nodes.iter().map(|node| node.2).collect();
    (found.settings, found.matrix, traces, nodes)
}

/// Settings of a machine are determined where a trace along which they act is there, however many
/// others are.
#[test]
fn settings_are_determined_by_traces_along_which_they_act() {
    let five = [-0.8, -0.4, 0.0, 0.4, 0.8];
    let along = ["profile_angle", "profile_crowning"];
    let across = ["helix_angle", "helix_crowning"];
    for (profiles, helices, determined) in [
        (&five[..], &[][..], along.to_vec()),
        (&[], &five[..], across.to_vec()),
        (&[0.0], &[0.0], [along, across].concat()),
        (&[&five[..], &five, &five].concat(), &[0.0], [along, across].concat()),
    ] {
        let (settings, matrix, traces, nodes) = machine(profiles, helices);
        let deviation = nodes.iter().map(|(u, v, t)| 3.0 * u + 2.0 * v + 10.0 * (*t as f64) + u * u).collect();
        let asked = CorrectionSpec { absolute: false, traces: Some(traces), ..plain(deviation, matrix, settings) };
        let solution = solve(asked);
        for setting in &solution.settings {
            let expected = determined.contains(&setting.name.as_str());
            assert_eq!(setting.undetermined, !expected, "{} with {profiles:?}, {helices:?}", setting.name);
            assert!(expected || setting.change == 0.0 && setting.std_error.is_none());
        }
        let warning = solution.warnings.iter().find(|warning| warning.code() == "undetermined_settings").unwrap();
        assert!(warning.to_string().contains("of a trace"), "{warning}");
    }
}

/// The machine's answer is the same whatever zeros the traces have before and after.
#[test]
fn zeros_of_traces_are_no_answer_of_the_machine() {
    let mut random = Random::new(9);
    let (settings, matrix, traces, nodes) = machine(&[-0.8, 0.0, 0.8], &[-0.7, 0.7]);
    let columns = settings.len();
    let shape: Vec<f64> = nodes.iter().map(|(u, v, _)| 5.0 * u + 4.0 * v - 6.0 * v * v).collect();
    let noise: Vec<[f64; 2]> = nodes.iter().map(|_| [random.normal(), random.normal()].map(|x| 0.2 * x)).collect();
    let mut of = |size: f64| {
        let mut zeros = || (0..5).map(|_| size * random.normal()).collect::<Vec<f64>>();
        let (before, after) = (zeros(), zeros());
        let deviation = (0..nodes.len()).map(|k| shape[k] + noise[k][0] + before[traces[k]]).collect();
        let asked = CorrectionSpec {
            absolute: false,
            traces: Some(traces.clone()),
            noise_sigma: Some(0.2),
            ..CorrectionSpec::new(deviation, matrix.clone(), settings.clone())
        };
        let correction = Correction::new(asked).unwrap();
        let solution = correction.solve().unwrap();
        let change: Vec<f64> = solution.settings.iter().map(|setting| setting.change).collect();
        let moved = |k: usize| (0..columns).map(|j| matrix[k * columns + j] * change[j]).sum::<f64>();
        let measured = (0..nodes.len()).map(|k| shape[k] + moved(k) + noise[k][1] + after[traces[k]]).collect();
        let noise = Noise { sigma: 0.2, freedom: None };
        compare(&correction.comparison(&change, solution.leverage, noise, measured)).unwrap()
    };
    let (still, moved) = (of(0.0), of(25.0));
    assert_eq!(still.verdict, moved.verdict);
    assert_eq!(still.verdict, Verdict::AsPredicted, "{}", still.sentence);
    assert!((still.chi_squared - moved.chi_squared).abs() < 1e-6 * still.chi_squared);
    assert!((still.response_ratio.unwrap() - moved.response_ratio.unwrap()).abs() < 1e-9);
    let rms = |a: &Answer| [a.rms_before_um, a.rms_predicted_um, a.rms_measured_um, a.rms_difference_um];
    assert!(rms(&still).iter().zip(rms(&moved)).all(|(a, b)| (a - b).abs() < 1e-9), "{still:?} {moved:?}");
}

#[test]
fn traces_are_checked() {
    let paths = |asked: CorrectionSpec| -> Vec<String> {
        Correction::new(asked).unwrap_err().list().iter().map(|fault| fault.path.clone()).collect()
    };
    let j: Vec<f64> = (0..8).flat_map(|k| [f64::from(k), f64::from(k * k)]).collect();
    let asked = |traces: Vec<usize>| {
        let deviation = (0..8).map(f64::from).collect();
        CorrectionSpec { absolute: false, traces: Some(traces), ..plain(deviation, j.clone(), settings(2)) }
    };
    assert_eq!(paths(asked(vec![0; 7])), ["trace"]);
    assert_eq!(paths(CorrectionSpec { absolute: true, ..asked(vec![0; 8]) }), ["absolute"]);
    // a zero for each node leaves nothing that separates two settings
    assert_eq!(paths(asked((0..8).collect())), ["sensitivity.settings"]);
    assert!(Correction::new(asked(vec![0, 0, 0, 0, 1, 1, 1, 1])).is_ok());
}
