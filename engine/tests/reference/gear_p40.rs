//! Traces of a real spur gear (z = 52, m_n = 1 mm), 17 of them, and the values that the instrument
//! itself printed for its left flank. The measurement is in `tests/data/p40`: every 12th of the 480
//! samples of a trace, so form and total deviation cannot agree.

use std::{collections::BTreeMap, path::Path};

use flankfit_engine::gear::{
    Gear, GearData, Hand, Kind, Side, Trace,
    evaluation::{
        Evaluation, Posted, Values, evaluate,
        settings::{DeviationSign, HelixSettings, ProfileSettings, Settings, SlopeSign},
    },
};
use serde_json::Value;

/// Slopes agree with the printed ones within this, µm.
const PROFILE: f64 = 0.3;
const HELIX: f64 = 1.1;

fn file(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/p40").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn gear() -> Gear {
    Gear::new(GearData {
        teeth: 52,
        normal_module: 1.0,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        hand: Hand::Right,
        profile_shift: 0.011,
        face_width: Some(15.0),
        tip_diameter: Some(54.0219),
        root_diameter: Some(49.5219),
        internal: false,
        tool: None,
    })
    .expect("the gear exists")
}

/// Column of the deviations in the sign that the instrument's curve file has, or in the DIN sign.
#[derive(Clone, Copy, PartialEq)]
enum Column {
    Printed = 7,
    Din = 8,
}

fn traces(text: &str, column: Column) -> Vec<Trace> {
    let mut traces: Vec<Trace> = Vec::new();
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |k: usize| -> f64 { cells[k].parse().expect("a number") };
        let side = if cells[0] == "left" { Side::Left } else { Side::Right };
        let kind = if cells[2] == "profile" { Kind::Profile } else { Kind::Helix };
        if cells[3] == "0" {
            let section = if kind == Kind::Profile { number(6) } else { number(4) };
            let (at, deviation) = (Vec::new(), Vec::new());
            traces.push(Trace { tooth: cells[1].into(), side, kind, at, section: Some(section), deviation });
        }
        let trace = traces.last_mut().expect("the first sample opens a trace");
        trace.at.push(if kind == Kind::Profile { number(5) } else { number(6) });
        let cell = cells[column as usize];
        trace.deviation.push(if cell.is_empty() { f64::NAN } else { cell.parse().expect("a number") });
    }
    traces
}

/// The ranges that the instrument evaluated.
fn settings(given: DeviationSign) -> Settings {
    Settings {
        profile: Some(ProfileSettings { reference_length: Some(5.5516), ..ProfileSettings::on([50.3, 54.022]) }),
        helix: Some(HelixSettings::on([0.75, 14.25])),
        given,
        sign: SlopeSign::Din,
        ..Settings::default()
    }
}

fn evaluated(traces: &[Trace], settings: &Settings) -> Evaluation {
    let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
    evaluate(&gear(), &posted, settings).expect("the traces are sound")
}

#[test]
fn slopes_are_those_that_the_instrument_printed() {
    let (text, printed) = (file("97340-neu_nodes.csv"), file("97340-neu_printed_results_left.json"));
    let printed: Value = serde_json::from_str(&printed).expect("JSON");
    let traces = traces(&text, Column::Din);
    assert_eq!(traces.len(), 17);
    let answer = evaluated(&traces, &settings(DeviationSign::Din));
    let mut compared = 0;
    for trace in &answer.traces {
        let values = trace.values.expect("every trace is evaluated");
        let (slope, form, total, within) = match trace.kind {
            Kind::Profile => ("f_Halpha", "f_falpha", "F_alpha", PROFILE),
            Kind::Helix => ("f_Hbeta", "f_fbeta", "F_beta", HELIX),
        };
        let side = if trace.flank == Side::Left { "left" } else { "right" };
        let figure = |name: &str| printed[name][side][&trace.tooth].as_f64();
        let shown = |name| figure(name).map_or("-".to_owned(), |f| f.to_string());
        println!(
            "{side} {:>3} {slope:>8} {:7.2} (printed {}) {form} {:6.2} ({}) {total} {:6.2} ({})",
            trace.tooth,
            values.slope_um,
            shown(slope),
            values.form_um,
            shown(form),
            values.total_um,
            shown(total)
        );
        if let Some(printed) = figure(slope) {
            assert!(
                (values.slope_um - printed).abs() <= within,
                "{side} {}: {} {printed}",
                trace.tooth,
                values.slope_um
            );
            compared += 1;
        }
        assert!(values.slope_um.abs() < 60.0 && values.form_um > 0.0 && values.total_um > 0.0, "{trace:?}");
        assert!(values.slope_std_error_um.is_some_and(|e| e > 0.0 && e < 3.0), "{trace:?}");
        // 36 of 40 samples lie in the range, and samples reach outside it on both sides
        assert_eq!(trace.samples.used, 36);
        assert!(trace.classes.is_some());
    }
    assert_eq!(compared, 7);
    // the first sample of each helix was not reached
    let undefined: usize = answer.traces.iter().map(|t| t.samples.undefined).sum();
    assert_eq!(undefined, traces.iter().filter(|t| t.kind == Kind::Helix).count());
    // of two teeth only a cross was measured; no flank contradicts itself
    let said: Vec<_> = answer.warnings.iter().map(|warning| warning.code()).collect();
    // the noise of three traces is correlated
    let noisy = ["correlated_noise"; 3].as_slice();
    assert_eq!(said, [noisy, &["figures_not_determined"]].concat(), "{:?}", answer.warnings);
    let whole = answer.surfaces.iter().filter(|surface| surface.figures.twist.is_some());
    assert_eq!(whole.map(|surface| surface.tooth.as_str()).collect::<Vec<_>>(), ["1", "1"]);
}

/// The instrument's own numbers count clockwise on every trace; read so, the DIN slopes are the
/// same.
#[test]
fn the_sign_of_the_curve_file_leads_to_the_same_slopes() {
    let text = file("97340-neu_nodes.csv");
    let din = evaluated(&traces(&text, Column::Din), &settings(DeviationSign::Din));
    let raw = evaluated(&traces(&text, Column::Printed), &settings(DeviationSign::Clockwise));
    for (a, b) in din.traces.iter().zip(&raw.traces) {
        // lines have the sign of the posted deviations
        let turned = match (a.kind, a.flank) {
            (Kind::Helix, _) | (Kind::Profile, Side::Left) => -1.0,
            (Kind::Profile, Side::Right) => 1.0,
        };
        let as_posted = |v: Values| Values {
            mean_line_um: v.mean_line_um.map(|height| turned * height),
            mean_parabola_um: v.mean_parabola_um.map(|height| turned * height),
            ..v
        };
        assert_eq!((&a.tooth, a.values), (&b.tooth, b.values.map(as_posted)));
    }
    assert_eq!(din.summaries, raw.summaries);
}

/// Means leave out the traces of the twist measurement.
#[test]
fn twist_traces_are_kept_out_of_the_means() {
    let text = file("97340-neu_nodes.csv");
    let answer = evaluated(&traces(&text, Column::Din), &settings(DeviationSign::Din));
    let counts: BTreeMap<_, _> = answer.summaries.iter().map(|s| ((s.kind, s.flank), s.count)).collect();
    assert_eq!(counts[&(Kind::Helix, Side::Left)], 2);
    assert_eq!(counts[&(Kind::Profile, Side::Right)], 3);
    // printed: helices k −6.7 and f 0.8 (S = −7.5), profiles o 0.0 and u 23.8 (−23.8)
    let twist = |kind| answer.twists.iter().find(|t| t.kind == kind && t.flank == Side::Left).expect("tooth 1 has it");
    assert!((twist(Kind::Helix).twist_um + 7.5).abs() < 2.0 * HELIX);
    assert_eq!(twist(Kind::Helix).sections_mm, Some([51.0, 53.0]));
    assert!((twist(Kind::Profile).twist_um + 23.8).abs() < 2.0 * PROFILE);
    assert_eq!(answer.twists.len(), 4);
}
