//! One trace: slope, form, total deviation and crowning.
//!
//! With `u` the coordinate mapped to [-1, 1] over the evaluation range, δ the deviation about the design (material positive), `δ ≈ p + q u` its
//! least-squares line and `δ ≈ a + b u + c u²` its least-squares parabola over the defined samples of the range:
//!
//! * slope `f_H = q · 2 reference / range` (`b` in place of `q` about the mean parabola, whose chord it is),
//! * form `f_f` = peak to valley of δ about the line or about the parabola,
//! * total `F` = peak to valley of δ,
//! * crowning `C = −c`, the height of the parabola over the middle of its chord; positive where material stands out in the middle.
//!
//! `F` may be smaller than `f_f`, since a least-squares line is not the line of least peak to valley.

use super::{
    Notice,
    settings::{MeanCurve, Settings, Window},
};
use crate::numerics::cancel::Asking;
use crate::{
    estimation::{
        self, FitError, Nodes,
        result::FitResult,
        spec::{Degree, FitSpec, Model, PolynomialBasis, Regularization, Terms},
        words::{Shown, counted},
    },
    gear::{Gear, Trace, trace::Direction},
};

/// Fewest defined samples of the evaluation range.
pub const FEWEST_SAMPLES: usize = 5;
/// Samples this near to the end of a range belong to it, mm: positions are rounded numbers.
pub const EDGE: f64 = 1e-6;

/// How many samples there were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples {
    pub posted: usize,
    /// Of the posted ones, undefined.
    pub undefined: usize,
    /// Defined ones within the evaluation range.
    pub used: usize,
    /// Undefined ones within the evaluation range.
    pub undefined_in_range: usize,
    /// Defined ones outside the evaluation range that plus material was looked for in.
    pub zone: usize,
}

/// The figures of a trace, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    /// f_H, in the sign asked for.
    pub slope: f64,
    /// Standard error of the slope, from the scatter about the mean curve taken for independent noise; none where nothing scatters freely.
    pub slope_std_error: Option<f64>,
    /// f_f.
    pub form: f64,
    /// F.
    pub total: f64,
    /// C.
    pub crowning: f64,
    pub crowning_std_error: Option<f64>,
    /// By how much plus material outside the evaluation range raised the form and the total deviation; 0 where the rule leaves it out.
    pub form_plus_material: f64,
    pub total_plus_material: f64,
}

/// A trace about its design, ready to be evaluated.
pub(super) struct Subject<'a> {
    pub gear: &'a Gear,
    pub trace: &'a Trace,
    pub design: Option<&'a [f64]>,
    pub settings: &'a Settings,
    pub window: &'a Window,
    /// Where the trace stands in the request: `/traces/3`.
    pub pointer: String,
}

/// The samples that count.
struct Taken {
    /// Coordinates mapped to [-1, 1] over the evaluation range, and deviations of material.
    u: Vec<f64>,
    deviation: Vec<f64>,
    /// The same outside of it.
    zone: Vec<[f64; 2]>,
    samples: Samples,
}

impl Subject<'_> {
    /// The figures, where there are any; whether the samples reach both ends of the range; notices say why not.
    pub fn evaluate(&self, notices: &mut Vec<Notice>) -> (Samples, Option<Values>, bool) {
        let taken = self.take();
        let samples = taken.samples;
        if samples.undefined_in_range > 0 {
            let undefined = counted(samples.undefined_in_range, "undefined sample", "undefined samples");
            self.note(notices, "undefined_samples", format!("{undefined} within the evaluation range left out"));
        }
        if samples.used < FEWEST_SAMPLES {
            let used = counted(samples.used, "defined sample", "defined samples");
            let detail = format!("{used} within the evaluation range; a trace is evaluated from {FEWEST_SAMPLES} on");
            self.note(notices, "too_few_samples", detail);
            return (samples, None, false);
        }
        let covers = self.covers(samples.used, notices);
        match self.figures(&taken) {
            Ok(values) => (samples, Some(values), covers),
            Err(error) => {
                let detail = format!("no mean curve: {}", reason(&error));
                self.note(notices, "no_mean_curve", detail);
                (samples, None, covers)
            }
        }
    }

    fn note(&self, notices: &mut Vec<Notice>, code: &'static str, message: String) {
        notices.push(Notice { code, pointer: Some(format!("{}/deviation_um", self.pointer)), message });
    }

    fn take(&self) -> Taken {
        let (trace, window) = (self.trace, self.window);
        let scale = self.settings.given.to_material(trace.kind, trace.side)
            * match self.settings.direction {
                Direction::Transverse => 1.0,
                Direction::Normal => 1.0 / self.gear.base_helix_angle().cos(),
            };
        let mut samples = Samples { posted: trace.at.len(), undefined: 0, used: 0, undefined_in_range: 0, zone: 0 };
        let (mut u, mut deviation, mut zone) = (Vec::new(), Vec::new(), Vec::new());
        let (middle, half) = (0.5 * (window.low + window.high), 0.5 * window.length());
        let looked_at = window.plus_material.in_form() || window.plus_material.in_total();
        for (i, (&at, &given)) in trace.at.iter().zip(&trace.deviation).enumerate().asking(20) {
            let about_design = given - self.design.map_or(0.0, |design| design[i]);
            let within = at >= window.low - EDGE && at <= window.high + EDGE;
            if about_design.is_nan() {
                samples.undefined += 1;
                samples.undefined_in_range += usize::from(within);
            } else if within {
                u.push((at - middle) / half);
                deviation.push(scale * about_design);
            } else if looked_at && at >= window.zone[0] - EDGE && at <= window.zone[1] + EDGE {
                zone.push([(at - middle) / half, scale * about_design]);
            }
        }
        (samples.used, samples.zone) = (u.len(), zone.len());
        Taken { u, deviation, zone, samples }
    }

    /// Whether defined samples reach both ends of the range, to one distance of neighbouring samples (they are discrete).
    fn covers(&self, used: usize, notices: &mut Vec<Notice>) -> bool {
        let window = self.window;
        let defined = self.trace.at.iter().zip(&self.trace.deviation).filter(|(_, d)| !d.is_nan());
        let (least, most) = defined.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (&at, _)| (a.min(at), b.max(at)));
        let within = most.min(window.high) - least.max(window.low);
        let open = EDGE + within.max(0.0) / (used.max(2) - 1) as f64;
        if least <= window.low + open && most >= window.high - open {
            return true;
        }
        let detail = format!(
            "defined samples from {} to {} mm do not cover the evaluation range from {} to {} mm: the figures are those of the part \
             measured, and no class is given",
            Shown(least),
            Shown(most),
            Shown(window.low),
            Shown(window.high)
        );
        self.note(notices, "range_not_covered", detail);
        false
    }

    fn figures(&self, taken: &Taken) -> Result<Values, FitError> {
        let (trace, window) = (self.trace, self.window);
        let parabola = polynomial(taken, 2)?;
        let mean = match window.mean {
            MeanCurve::Line => polynomial(taken, 1)?,
            MeanCurve::Parabola => parabola.clone(),
        };
        let sign = self.settings.sign.of_material(self.settings.given, trace.kind, trace.side);
        let extended = window.reference / (0.5 * window.length());
        let coefficient = |fit: &FitResult, k: usize| fit.coefficients[k].value;
        let error = |fit: &FitResult, k: usize| fit.coefficients[k].std_error;
        let curve = |u: f64| mean.coefficients.iter().rev().fold(0.0, |sum, c| sum * u + c.value);
        let [form, form_plus_material] = peak_to_valley(taken, window.plus_material.in_form(), |u, d| d - curve(u));
        let [total, total_plus_material] = peak_to_valley(taken, window.plus_material.in_total(), |_, d| d);
        Ok(Values {
            slope: sign * window.sense * coefficient(&mean, 1) * extended,
            slope_std_error: error(&mean, 1).map(|e| e * extended),
            form,
            total,
            crowning: -coefficient(&parabola, 2),
            crowning_std_error: error(&parabola, 2),
            form_plus_material,
            total_plus_material,
        })
    }
}

/// Highest minus lowest of the range, and what samples beside the range add to the highest.
fn peak_to_valley(taken: &Taken, zone: bool, height: impl Fn(f64, f64) -> f64) -> [f64; 2] {
    let heights = taken.u.iter().zip(&taken.deviation).map(|(&u, &d)| height(u, d));
    let (lowest, highest) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
    let beside = taken.zone.iter().map(|&[u, d]| height(u, d)).fold(f64::NEG_INFINITY, f64::max);
    let added = if zone { (beside - highest).max(0.0) } else { 0.0 };
    [highest - lowest + added, added]
}

/// Coefficients of 1, u, u² by plain least squares.
fn polynomial(taken: &Taken, degree: usize) -> Result<FitResult, FitError> {
    let model =
        Model::Polynomial { degree: Degree::Both(degree), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
    let spec = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
    let nodes = Nodes::curve(taken.u.clone(), taken.deviation.clone(), None)?;
    let fit = estimation::fit(&nodes, &spec)?;
    if fit.spectrum.rank < degree + 1 {
        let terms = fit.coefficients.iter().map(|c| c.term.clone()).collect();
        return Err(FitError::RankDeficient { rank: fit.spectrum.rank, columns: degree + 1, terms });
    }
    Ok(fit)
}

fn reason(error: &FitError) -> String {
    match error {
        FitError::Invalid(faults) => {
            faults.list().first().map_or_else(|| error.to_string(), |fault| fault.detail.clone())
        }
        FitError::RankDeficient { rank, .. } => {
            format!("the samples lie at {} only", counted(*rank, "place", "places"))
        }
        FitError::NotConverged(_) => error.to_string(),
    }
}
