//! One trace: slope, form, total deviation and crowning.
//!
//! With `u` the coordinate mapped to [-1, 1] over the evaluation range, δ the deviation about the
//! design (material positive), `δ ≈ p + q u` its least-squares line and `δ ≈ a + b u + c u²` its
//! least-squares parabola over the range, to which every defined sample contributes by the length
//! that it represents ([`super::spacing`]):
//!
//! * slope `f_H = q · 2 reference / range` (`b` in place of `q` about the mean parabola, whose
//!   chord it is),
//! * form `f_f` = peak to valley of δ about the line or about the parabola,
//! * total `F` = peak to valley of δ,
//! * crowning `C = −c`, the height of the parabola over the middle of its chord; positive where
//!   material protrudes in the middle,
//! * tip relief `f_Ko`, the least-squares line of the samples of the relief less the line of the
//!   evaluation range, both at the tip end of the relief.
//!
//! `F` may be smaller than `f_f`, since a least-squares line is not the line of least peak to
//! valley. Standard errors are those of the samples' noise ([`super::noise`]) and of what gaps hide
//! ([`super::gap`]).

use super::{
    coverage,
    gap::mean_curves,
    mean_curve::MeanCurves,
    noise::TraceNoise,
    outliers::burrs::Burr,
    samples::{self, Samples, Taken},
    settings::{MeanCurve, Outliers},
    spacing::Spacing,
    subject::Subject,
    suspects,
    values::{Assessable, FEWEST_SAMPLES, Suspects, Values},
    warning::{TraceWarning, Warning},
};

/// Evaluation of a trace.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outcome {
    pub samples: Samples,
    pub values: Option<Values>,
    pub assessable: Assessable,
    pub suspects: Option<Suspects>,
}

impl Subject<'_> {
    /// The figures, where there are any; warnings say why not.
    pub(super) fn evaluate(&self, burrs: [Option<Burr>; 2], warnings: &mut Vec<Warning>) -> Outcome {
        let (mut all, mut samples) = samples::defined(self);
        let runs = suspects::mark(&mut all, burrs);
        let exclude = self.settings.outliers == Outliers::Exclude;
        samples.excluded = if exclude { all.iter().filter(|s| s.suspect && s.within).count() } else { 0 };
        let taken = Taken::of(&all, exclude);
        (samples.used, samples.zone) = (taken.u.len(), taken.zone.len());
        if samples.undefined_in_range > 0 {
            self.warn(warnings, TraceWarning::UndefinedSamples { count: samples.undefined_in_range });
        }
        let suspects = (!runs.is_empty()).then(|| suspects::suspects(self, &all, &runs, exclude));
        let refused = match (samples.used < FEWEST_SAMPLES, taken.spacing.places < 3) {
            (true, _) => Some(TraceWarning::TooFewSamples { count: samples.used }),
            (false, true) => Some(TraceWarning::NoMeanCurve { count: taken.spacing.places }),
            (false, false) => None,
        };
        if let Some(refused) = refused {
            self.warn(warnings, refused);
            return Outcome { samples, values: None, assessable: Assessable::Nothing, suspects };
        }
        let assessable = coverage::assessable(self, &taken.u, &taken.spacing, warnings);
        if let Some(suspects) = &suspects {
            self.warn(warnings, suspects.warning(exclude));
        }
        let noise = (assessable != Assessable::Nothing).then(|| taken.noise()).flatten();
        if let Some(correlation) = noise.and_then(|noise| noise.correlation) {
            self.warn(warnings, correlation.warning(samples.used));
        }
        Outcome {
            samples,
            values: (assessable != Assessable::Nothing).then(|| self.figures(&taken, noise)),
            assessable,
            suspects,
        }
    }

    /// Returns the figures of samples at three places at least.
    pub(super) fn figures(&self, taken: &Taken, noise: Option<TraceNoise>) -> Values {
        let (trace, window) = (self.trace, self.window);
        let noise = noise.map(|noise| noise.variance);
        let fitted = mean_curves(&taken.u, &taken.deviation, &taken.spacing, noise.map(|noise| noise.value.sqrt()));
        let (mean, sign) =
            (&fitted.curves, self.settings.sign.of_material(self.settings.given, trace.kind, trace.side));
        let extended = window.reference / (0.5 * window.length());
        let [line, chord, curvature] = mean.figures();
        let (slope, k) = match window.mean {
            MeanCurve::Line => (line, 0),
            MeanCurve::Parabola => (chord, 1),
        };
        let about = |u: f64, d: f64| match window.mean {
            MeanCurve::Line => d - mean.line(u),
            MeanCurve::Parabola => d - mean.parabola(u),
        };
        let [form, form_plus_material] = peak_to_valley(taken, window.plus_material.in_form(), about);
        let [total, total_plus_material] = peak_to_valley(taken, window.plus_material.in_total(), |_, d| d);
        let as_given = 1.0 / self.to_material();
        let raised = |by: f64| Some(by).filter(|by| *by > 0.0);
        // + 0.0: −0 is 0
        Values {
            mean_line_um: [-1.0, 1.0].map(|u| as_given * mean.line(u) + 0.0),
            mean_parabola_um: [-1.0, 0.0, 1.0].map(|u| as_given * mean.parabola(u) + 0.0),
            slope_um: sign * window.sense * slope * extended + 0.0,
            slope_std_error_um: fitted.errors.map(|errors| errors[k] * extended),
            form_um: form,
            total_um: total,
            crowning_um: 0.0 - curvature,
            crowning_std_error_um: fitted.errors.map(|errors| errors[2]),
            tip_relief_um: self.tip_relief(&taken.relief, mean),
            freedom: noise.map(|noise| noise.freedom),
            doubts: noise.map_or_else(Default::default, |noise| noise.doubts),
            form_plus_material_um: raised(form_plus_material),
            total_plus_material_um: raised(total_plus_material),
        }
    }
}

impl Subject<'_> {
    /// f_Ko, from the samples of the relief (u, deviation) and the mean curves of the range.
    fn tip_relief(&self, relief: &[[f64; 2]], mean: &MeanCurves) -> Option<f64> {
        let window = self.window;
        let to_u = |roll: f64| (roll - 0.5 * (window.low + window.high)) / (0.5 * window.length());
        let [from, to] = window.tip_relief?.map(to_u);
        // mapped to [-1, 1] over the relief
        let along: Vec<f64> = relief.iter().map(|[u, _]| (2.0 * u - from - to) / (to - from)).collect();
        let spacing = Spacing::of(&along);
        if relief.len() < FEWEST_SAMPLES || spacing.places < 3 || !spacing.determines_figures() {
            return None;
        }
        let deviation: Vec<f64> = relief.iter().map(|[_, deviation]| *deviation).collect();
        let line = MeanCurves::of(&along, &deviation, &spacing.weight);
        let (tip, tip_u) = if window.sense > 0.0 { (1.0, to) } else { (-1.0, from) };
        Some(line.line(tip) - mean.line(tip_u))
    }
}

/// Highest minus lowest of the range, and what samples outside the range add to the highest.
fn peak_to_valley(taken: &Taken, zone: bool, height: impl Fn(f64, f64) -> f64) -> [f64; 2] {
    let heights = taken.u.iter().zip(&taken.deviation).map(|(&u, &d)| height(u, d));
    let (lowest, highest) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
    let beside = taken.zone.iter().map(|&[u, d]| height(u, d)).fold(f64::NEG_INFINITY, f64::max);
    let added = if zone { (beside - highest).max(0.0) } else { 0.0 };
    [highest - lowest + added, added]
}
