//! The traces of one tooth flank together: their samples as nodes of a surface.

use std::collections::BTreeMap;

use super::{
    EDGE, Position, Posted,
    noise::{TraceNoise, noise},
    settings::Settings,
    spacing::Spacing,
    warning::Warning,
};
use crate::{Gear, Kind, Side, trace::Direction};
use flankfit_numerics::cancel;

/// Samples of one tooth flank, within the evaluation ranges: what lies outside (the rounding of the
/// tip) is no matter of the flank.
#[derive(Clone, Debug, PartialEq)]
pub struct FlankTraces {
    /// Name of the tooth, without the letter of a trace off the middle.
    pub tooth: String,
    /// Flank of the tooth.
    pub side: Side,
    /// Roll length and z in mm, deviation about the design in µm, transverse, positive where
    /// material protrudes.
    pub places: Vec<[f64; 3]>,
    pub(super) each: Vec<OneTrace>,
}

/// A trace of a flank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OneTrace {
    pub kind: Kind,
    /// Number of the trace, from 0.
    pub number: usize,
    pub samples: usize,
    /// Noise of a sample, µm; `None` where the samples are too few to estimate it.
    pub noise: Option<TraceNoise>,
}

/// Tooth by tooth and flank by flank the traces whose section is known, the flank with most traces
/// first.
pub fn flank_traces(gear: &Gear, posted: &[Posted], settings: &Settings) -> Vec<FlankTraces> {
    let [rolls, helix] = ranges(gear, settings);
    let within = |x: f64, range: Option<[f64; 2]>| range.is_none_or(|[low, high]| low - EDGE <= x && x <= high + EDGE);
    let along = match settings.direction {
        Direction::Transverse => 1.0,
        Direction::Normal => 1.0 / gear.base_helix_angle().cos(),
    };
    let mut flanks: BTreeMap<(&str, Side), FlankTraces> = BTreeMap::new();
    for (number, Posted { trace, design }) in posted.iter().enumerate() {
        cancel::checkpoint();
        let Some(section) = trace.section else { continue };
        let fixed = if trace.kind == Kind::Profile { Some(section) } else { gear.roll_length(section) };
        let Some(fixed) = fixed else { continue };
        let tooth = Position::split(&trace.tooth).0;
        let flank = flanks.entry((tooth, trace.side)).or_insert_with(|| FlankTraces {
            tooth: tooth.to_owned(),
            side: trace.side,
            places: Vec::new(),
            each: Vec::new(),
        });
        let before = flank.places.len();
        let scale = along * settings.given.to_material(trace.kind, trace.side);
        let line = settings.against.line(*design);
        for (k, (&at, &deviation)) in trace.at.iter().zip(&trace.deviation).enumerate() {
            let about = deviation - line.map_or(0.0, |line| line[k]);
            let [roll, z] = if trace.kind == Kind::Profile { [at, fixed] } else { [fixed, at] };
            if within(roll, rolls) && within(z, helix) && about.is_finite() {
                flank.places.push([roll, z, scale * about]);
            }
        }
        let own = &flank.places[before..];
        if !own.is_empty() {
            let noise = trace_noise(own, usize::from(trace.kind == Kind::Helix));
            let trace = OneTrace { kind: trace.kind, number, samples: own.len(), noise };
            flank.each.push(trace);
        }
    }
    let mut flanks: Vec<FlankTraces> = flanks.into_values().filter(|flank| !flank.places.is_empty()).collect();
    flanks.sort_by_key(|flank| std::cmp::Reverse(flank.each.len()));
    flanks
}

/// Evaluation ranges in roll length and z, where they are given.
pub(super) fn ranges(gear: &Gear, settings: &Settings) -> [Option<[f64; 2]>; 2] {
    let rolls = settings.profile.and_then(|asked| {
        let [a, b] = asked.diameters.map(|diameter| gear.roll_length(diameter));
        Some([a?.min(b?), a?.max(b?)])
    });
    [rolls, settings.helix.map(|asked| asked.range)]
}

/// Noise of the samples of one trace, which runs along coordinate `along` of its places.
fn trace_noise(places: &[[f64; 3]], along: usize) -> Option<TraceNoise> {
    let mut each: Vec<[f64; 2]> = places.iter().map(|place| [place[along], place[2]]).collect();
    each.sort_by(cancel::comparing(|a: &[f64; 2], b: &[f64; 2]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))));
    let (low, high) = (each.first()?[0], each.last()?[0]);
    let u: Vec<f64> = each.iter().map(|[x, _]| (2.0 * x - low - high) / (high - low)).collect();
    let deviation: Vec<f64> = each.iter().map(|[_, deviation]| *deviation).collect();
    // a parabola needs three places
    let spacing = (high > low).then(|| Spacing::of(&u)).filter(|spacing| spacing.places >= 3)?;
    noise(&u, &deviation, &spacing).filter(|noise| noise.variance.value.is_finite())
}

impl OneTrace {
    /// Returns the warning that its noise is correlated.
    pub(super) fn warning(&self) -> Option<Warning> {
        let correlation = self.noise?.correlation?;
        Some(Warning::Trace { trace: self.number, warning: correlation.warning(self.samples) })
    }
}

impl FlankTraces {
    /// How many of its traces have samples there.
    pub fn traces(&self) -> usize {
        self.each.len()
    }

    /// How many samples each trace has, in the order of the places.
    pub fn lengths(&self) -> Vec<usize> {
        self.each.iter().map(|trace| trace.samples).collect()
    }

    /// The traces one after the other, each with its places.
    pub(super) fn split(&self) -> impl Iterator<Item = (&OneTrace, &[[f64; 3]])> {
        let ends = self.each.iter().scan(0, |end, trace| {
            *end += trace.samples;
            Some(*end)
        });
        self.each.iter().zip(ends).map(|(trace, end)| (trace, &self.places[end - trace.samples..end]))
    }
}
