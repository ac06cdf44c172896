//! The defined samples of a trace, and those of them that count.

use super::{
    noise::{TraceNoise, noise},
    settings::Window,
    spacing::Spacing,
    subject::Subject,
    values::EDGE,
};
use flankfit_numerics::cancel::{self, Asking};

/// Numbers of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = TraceSamples)
)]
pub struct Samples {
    /// All samples of the trace.
    pub posted: usize,
    /// Samples without a deviation.
    pub undefined: usize,
    /// Defined ones within the evaluation range.
    pub used: usize,
    /// Samples without a deviation within the evaluation range.
    pub undefined_in_range: usize,
    /// Defined ones within the evaluation range that were left out as outliers.
    pub excluded: usize,
    /// Defined ones outside the evaluation range that plus material was looked for in.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub zone: usize,
}

/// A defined sample.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub(super) at: f64,
    /// Mapped to [-1, 1] over the evaluation range.
    pub(super) u: f64,
    /// Deviation of material, transverse, about the design.
    pub(super) deviation: f64,
    pub(super) within: bool,
    /// True where it is checked for plus material.
    pub(super) zone: bool,
    /// True in the tip relief.
    pub(super) relief: bool,
    pub(super) suspect: bool,
}

/// The samples that count, in ascending order.
pub(super) struct Taken {
    pub(super) u: Vec<f64>,
    pub(super) deviation: Vec<f64>,
    /// Outside of the range.
    pub(super) zone: Vec<[f64; 2]>,
    /// In the tip relief.
    pub(super) relief: Vec<[f64; 2]>,
    pub(super) spacing: Spacing,
}

/// The defined samples in ascending order, and how many there were.
pub(super) fn defined(subject: &Subject) -> (Vec<Sample>, Samples) {
    let (trace, window, scale) = (subject.trace, subject.window, subject.to_material());
    let mut samples =
        Samples { posted: trace.at.len(), undefined: 0, used: 0, undefined_in_range: 0, excluded: 0, zone: 0 };
    let (middle, half) = (0.5 * (window.low + window.high), 0.5 * window.length());
    let looked_at = window.plus_material.in_form() || window.plus_material.in_total();
    let about = subject.settings.against.line(subject.design);
    let mut all = Vec::with_capacity(trace.at.len());
    for (i, (&at, &given)) in trace.at.iter().zip(&trace.deviation).enumerate().asking(20) {
        let about_line = given - about.map_or(0.0, |line| line[i]);
        let within = is_within(window, at);
        if about_line.is_nan() {
            samples.undefined += 1;
            samples.undefined_in_range += usize::from(within);
        } else {
            let zone = !within && looked_at && at >= window.zone[0] - EDGE && at <= window.zone[1] + EDGE;
            let (u, deviation) = ((at - middle) / half, scale * about_line);
            let relief = window.tip_relief.is_some_and(|[from, to]| at >= from - EDGE && at <= to + EDGE);
            all.push(Sample { at, u, deviation, within, zone, relief, suspect: false });
        }
    }
    // samples at one place in an order of their own, so that theirs in the request makes no
    // difference
    if !all.is_sorted_by(|a, b| a.u < b.u) {
        all.sort_by(cancel::comparing(|a: &Sample, b: &Sample| {
            a.u.total_cmp(&b.u).then(a.deviation.total_cmp(&b.deviation))
        }));
    }
    (all, samples)
}

fn is_within(window: &Window, at: f64) -> bool {
    at >= window.low - EDGE && at <= window.high + EDGE
}

impl Taken {
    pub(super) fn of(all: &[Sample], exclude: bool) -> Self {
        let counts = |sample: &&Sample| !(exclude && sample.suspect);
        let counted = || all.iter().filter(counts);
        let within = || counted().filter(|sample| sample.within);
        let u: Vec<f64> = within().map(|sample| sample.u).collect();
        let below = counted().take_while(|sample| !sample.within && sample.u < 0.0).last();
        let above = counted().rev().take_while(|sample| !sample.within && sample.u > 0.0).last();
        let spacing = Spacing::with_neighbours(&u, [below, above].map(|sample| sample.map(|sample| sample.u)));
        Taken {
            u,
            deviation: within().map(|sample| sample.deviation).collect(),
            zone: counted().filter(|s| s.zone).map(|s| [s.u, s.deviation]).collect(),
            relief: counted().filter(|s| s.relief).map(|s| [s.u, s.deviation]).collect(),
            spacing,
        }
    }

    pub(super) fn noise(&self) -> Option<TraceNoise> {
        noise(&self.u, &self.deviation, &self.spacing)
    }
}
