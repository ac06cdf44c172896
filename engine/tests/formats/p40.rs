//! A measured gear: the samples that are published of it, written as a curve file and read back to
//! the same positions and deviations.

use std::path::Path;

use flankfit_engine::{
    formats::klingelnberg::{PositionedTraces, SignConvention, read_curves},
    gear::{Gear, Kind, Side},
};

use super::klingelnberg_file::{self as file, Lines, Style};

const SAMPLES: usize = 480;

/// A published sample.
struct Sample {
    index: usize,
    diameter: f64,
    roll_length: f64,
    z: f64,
    printed: Option<f64>,
    din: Option<f64>,
}

struct Published {
    left: bool,
    tooth: String,
    profile: bool,
    samples: Vec<Sample>,
}

fn published() -> Vec<Published> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/p40/97340-neu_nodes.csv");
    let text = std::fs::read_to_string(path).expect("the published samples");
    let mut traces: Vec<Published> = Vec::new();
    for line in text.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [flank, tooth, kind, index, diameter, roll_length, z, printed, din] = fields[..] else { panic!("{line}") };
        let number = |text: &str| text.parse::<f64>().ok();
        let (left, profile) = (flank == "left", kind == "profile");
        if traces.last().is_none_or(|t| (t.left, t.tooth.as_str(), t.profile) != (left, tooth, profile)) {
            traces.push(Published { left, tooth: tooth.into(), profile, samples: Vec::new() });
        }
        let sample = Sample {
            index: index.parse().unwrap(),
            diameter: number(diameter).unwrap(),
            roll_length: number(roll_length).unwrap(),
            z: number(z).unwrap(),
            printed: number(printed),
            din: number(din),
        };
        traces.last_mut().unwrap().samples.push(sample);
    }
    traces
}

/// The published traces as an instrument would have stored them, samples in between left undefined.
fn stored(traces: &[Published]) -> Vec<u8> {
    let trace = |published: &Published| {
        let mut values = vec![None; SAMPLES];
        for sample in &published.samples {
            values[sample.index] = sample.printed;
        }
        let first = &published.samples[0];
        let rounded = |x: f64| (x * 1000.0).round() / 1000.0;
        let index = match published.tooth.trim_start_matches(|c: char| c.is_ascii_digit()) {
            "f" | "u" => 1,
            "" => 2,
            _ => 3,
        };
        file::Trace {
            tooth: published.tooth.clone(),
            left: published.left,
            profile: published.profile,
            index,
            section: if published.profile { first.z } else { rounded(first.roll_length) },
            values,
        }
    };
    let traces: Vec<file::Trace> = traces.iter().map(trace).collect();
    let mut lines = Lines::new(&Style::default(), "MK");
    lines.gear(&file::Gear::spur(), false).traces(&traces);
    lines.bytes()
}

/// The published traces, the gear of the file, and its traces in a sense.
fn read(sense: SignConvention) -> (Vec<Published>, Gear, PositionedTraces) {
    let published = published();
    let file = read_curves(&stored(&published)).unwrap();
    assert_eq!(file.notes.list(), []);
    let gear = Gear::new(file.header.gear(&mut Default::default()).gear_data().unwrap()).unwrap();
    let placed = file.place(&gear).with_sense(file.signs(), sense);
    (published, gear, placed)
}

#[test]
fn all_samples_come_back_where_they_were_with_the_sign_of_din() {
    let (published, _, placed) = read(SignConvention::Din);
    assert_eq!((published.len(), placed.traces.len(), placed.unplaced.len()), (17, 17, 0));
    for (trace, placed) in published.iter().zip(&placed.traces) {
        let read = &placed.trace;
        assert_eq!(read.tooth, trace.tooth);
        assert_eq!((read.side == Side::Left, read.kind == Kind::Profile), (trace.left, trace.profile));
        assert_eq!((read.at.len(), read.deviation.len()), (SAMPLES, SAMPLES));
        let defined = trace.samples.iter().filter(|sample| sample.printed.is_some()).count();
        assert_eq!(placed.undefined, SAMPLES - defined);
        for sample in &trace.samples {
            // published places are rounded to four and five decimals, diameters to three
            let at = if trace.profile { sample.roll_length } else { sample.z };
            assert!((read.at[sample.index] - at).abs() <= 5.1e-5, "{} {}", read.at[sample.index], at);
            let section = if trace.profile { sample.z } else { sample.diameter };
            assert_eq!(read.section, Some(section));
            let deviation = read.deviation[sample.index];
            assert!(sample.din.map_or(deviation.is_nan(), |din| din == deviation), "{deviation} {:?}", sample.din);
        }
    }
}

#[test]
fn the_rounded_tip_lacks_material_on_both_flanks() {
    let (_, _, placed) = read(SignConvention::Material);
    let profiles: Vec<_> = placed.traces.iter().filter(|placed| placed.trace.kind == Kind::Profile).collect();
    assert_eq!(profiles.len(), 8);
    for placed in profiles {
        let deviation = &placed.trace.deviation;
        assert!(deviation[468] < deviation[456] - 5.0, "{} {}", deviation[456], deviation[468]);
    }
}
