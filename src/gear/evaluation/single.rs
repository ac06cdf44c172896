//! One trace: slope, form, total deviation and crowning.
//!
//! With `u` the coordinate mapped to [-1, 1] over the evaluation range, δ the deviation about the design (material
//! positive), `δ ≈ p + q u` its least-squares line and `δ ≈ a + b u + c u²` its least-squares parabola over the range,
//! to which every defined sample contributes by the length that it stands for ([`super::spacing`]):
//!
//! * slope `f_H = q · 2 reference / range` (`b` in place of `q` about the mean parabola, whose chord it is),
//! * form `f_f` = peak to valley of δ about the line or about the parabola,
//! * total `F` = peak to valley of δ,
//! * crowning `C = −c`, the height of the parabola over the middle of its chord; positive where material stands out in the middle.
//!
//! `F` may be smaller than `f_f`, since a least-squares line is not the line of least peak to valley. Standard errors
//! are those of the samples' noise ([`super::noise`]).

use super::{
    Notice,
    mean_curve::MeanCurves,
    noise::noise,
    outliers::{Run, outliers},
    settings::{MeanCurve, Outliers, Settings, Window},
    spacing::{LEAST_COVERED, LONGEST_DISTANCE, Spacing},
};
use crate::numerics::cancel::{self, Asking};
use crate::{
    estimation::words::{Shown, counted},
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
    /// Defined ones within the evaluation range that were left out as outliers.
    pub excluded: usize,
    /// Defined ones outside the evaluation range that plus material was looked for in.
    pub zone: usize,
}

/// The figures of a trace, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    /// f_H, in the sign asked for.
    pub slope: f64,
    /// Standard error of the slope, from the noise of the samples; none where they are too few to tell it.
    pub slope_std_error: Option<f64>,
    /// f_f.
    pub form: f64,
    /// F.
    pub total: f64,
    /// C.
    pub crowning: f64,
    pub crowning_std_error: Option<f64>,
    /// By how much plus material outside the evaluation range raised the form and the total deviation; 0 where the rule
    /// leaves it out.
    pub form_plus_material: f64,
    pub total_plus_material: f64,
}

/// Which figures of a trace may have a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    Nothing,
    /// The slope only: over a hole a form may be anything.
    Slope,
    Everything,
}

/// A place that stands out of its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suspect {
    /// Roll lengths or z of its first and last sample, mm.
    pub from: f64,
    pub to: f64,
    pub samples: usize,
    /// How far it stands out at most, µm of material.
    pub height: f64,
}

/// Places that stand out of their neighbours, within what is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspects {
    pub places: Vec<Suspect>,
    /// The figures without them, where they count and are not all that there is.
    pub without: Option<Values>,
}

/// What became of a trace.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outcome {
    pub samples: Samples,
    pub values: Option<Values>,
    pub told: Told,
    pub suspects: Option<Suspects>,
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

/// A defined sample.
#[derive(Clone, Copy)]
struct Sample {
    at: f64,
    /// Mapped to [-1, 1] over the evaluation range.
    u: f64,
    /// Of material, transverse, about the design.
    deviation: f64,
    within: bool,
    /// Whether it is looked at for plus material.
    zone: bool,
    suspect: bool,
}

/// The samples that count, in ascending order.
struct Taken {
    u: Vec<f64>,
    deviation: Vec<f64>,
    /// Outside of the range.
    zone: Vec<[f64; 2]>,
    spacing: Spacing,
}

impl Subject<'_> {
    /// The figures, where there are any; notices say why not.
    pub fn evaluate(&self, notices: &mut Vec<Notice>) -> Outcome {
        let (mut all, mut samples) = self.samples();
        let runs = self.suspect(&mut all);
        let exclude = self.settings.outliers == Outliers::Exclude;
        samples.excluded = if exclude { all.iter().filter(|s| s.suspect && s.within).count() } else { 0 };
        let taken = Taken::of(&all, exclude);
        (samples.used, samples.zone) = (taken.u.len(), taken.zone.len());
        if samples.undefined_in_range > 0 {
            let undefined = counted(samples.undefined_in_range, "undefined sample", "undefined samples");
            self.note(notices, "undefined_samples", format!("{undefined} within the evaluation range left out"));
        }
        let suspects = (!runs.is_empty()).then(|| self.suspects(&all, &runs, exclude));
        let refused = match (samples.used < FEWEST_SAMPLES, taken.spacing.places < 3) {
            (true, _) => {
                let used = counted(samples.used, "defined sample", "defined samples");
                let why = format!("{used} within the evaluation range; a trace is evaluated from {FEWEST_SAMPLES} on");
                Some(("too_few_samples", why))
            }
            (false, true) => {
                let places = counted(taken.spacing.places, "place", "places");
                Some(("no_mean_curve", format!("no mean curve: the samples lie at {places} only")))
            }
            (false, false) => None,
        };
        if let Some((code, detail)) = refused {
            self.note(notices, code, detail);
            return Outcome { samples, values: None, told: Told::Nothing, suspects };
        }
        let values = self.figures(&taken);
        let told = self.told(&all, &taken.spacing, notices);
        if let Some(suspects) = &suspects {
            self.note(notices, "outliers_suspected", self.suspicion(suspects, exclude));
        }
        Outcome { samples, values: Some(values), told, suspects }
    }

    fn note(&self, notices: &mut Vec<Notice>, code: &'static str, message: String) {
        notices.push(Notice { code, pointer: Some(format!("{}/deviation_um", self.pointer)), message });
    }

    /// The defined samples in ascending order, and how many there were.
    fn samples(&self) -> (Vec<Sample>, Samples) {
        let (trace, window) = (self.trace, self.window);
        let scale = self.settings.given.to_material(trace.kind, trace.side)
            * match self.settings.direction {
                Direction::Transverse => 1.0,
                Direction::Normal => 1.0 / self.gear.base_helix_angle().cos(),
            };
        let mut samples =
            Samples { posted: trace.at.len(), undefined: 0, used: 0, undefined_in_range: 0, excluded: 0, zone: 0 };
        let (middle, half) = (0.5 * (window.low + window.high), 0.5 * window.length());
        let looked_at = window.plus_material.in_form() || window.plus_material.in_total();
        let mut all = Vec::with_capacity(trace.at.len());
        for (i, (&at, &given)) in trace.at.iter().zip(&trace.deviation).enumerate().asking(20) {
            let about_design = given - self.design.map_or(0.0, |design| design[i]);
            let within = at >= window.low - EDGE && at <= window.high + EDGE;
            if about_design.is_nan() {
                samples.undefined += 1;
                samples.undefined_in_range += usize::from(within);
            } else {
                let zone = !within && looked_at && at >= window.zone[0] - EDGE && at <= window.zone[1] + EDGE;
                let (u, deviation) = ((at - middle) / half, scale * about_design);
                all.push(Sample { at, u, deviation, within, zone, suspect: false });
            }
        }
        // samples at one place in an order of their own, so that theirs in the request makes no difference
        if !all.is_sorted_by(|a, b| a.u < b.u) {
            all.sort_by(cancel::comparing(|a: &Sample, b: &Sample| {
                a.u.total_cmp(&b.u).then(a.deviation.total_cmp(&b.deviation))
            }));
        }
        (all, samples)
    }

    /// Marks what stands out of its neighbours; the places of it that count otherwise.
    fn suspect(&self, all: &mut [Sample]) -> Vec<Run> {
        let column = |of: fn(&Sample) -> f64| all.iter().map(of).collect::<Vec<f64>>();
        let mut runs = outliers(&column(|s| s.at), &column(|s| s.deviation));
        runs.retain(|run| all[run.from..run.to].iter().any(|s| s.within || s.zone));
        for run in &runs {
            all[run.from..run.to].iter_mut().for_each(|sample| sample.suspect = true);
        }
        runs
    }

    fn suspects(&self, all: &[Sample], runs: &[Run], excluded: bool) -> Suspects {
        let place = |run: &Run| Suspect {
            from: all[run.from].at,
            to: all[run.to - 1].at,
            samples: run.to - run.from,
            height: run.height,
        };
        let places = runs.iter().map(place).collect();
        let without = (!excluded).then(|| Taken::of(all, true));
        let without = without.filter(|taken| taken.u.len() >= FEWEST_SAMPLES && taken.spacing.places > 2);
        Suspects { places, without: without.map(|taken| self.figures(&taken)) }
    }

    fn suspicion(&self, suspects: &Suspects, excluded: bool) -> String {
        const NAMED: usize = 5;
        // to a µm along and to a tenth of a µm across
        let along = |x: f64| Shown((x * 1e3).round() / 1e3);
        let across = |x: f64| Shown((x * 10.0).round() / 10.0);
        let one = |p: &Suspect| match p.samples {
            1 => format!("at {} mm ({} µm)", along(p.from), across(p.height)),
            _ => format!("from {} to {} mm ({} µm)", along(p.from), along(p.to), across(p.height)),
        };
        let mut places = suspects.places.iter().take(NAMED).map(one).collect::<Vec<_>>().join(", ");
        if suspects.places.len() > NAMED {
            places.push_str(" and others");
        }
        let found = format!("samples stand far out of their neighbours, as dust does: {places}");
        match (excluded, suspects.without) {
            (true, _) => format!("{found}; they are left out"),
            (false, Some(w)) => format!(
                "{found}; they count. Without them slope {}, form {}, total {} µm",
                across(w.slope),
                across(w.form),
                across(w.total)
            ),
            (false, None) => format!("{found}; they count"),
        }
    }

    /// What the samples tell: whether they reach both ends of the range to one distance of neighbouring samples (they
    /// are discrete), and leave no hole in it.
    fn told(&self, all: &[Sample], spacing: &Spacing, notices: &mut Vec<Notice>) -> Told {
        let window = self.window;
        let (least, most) = all.first().zip(all.last()).map_or((f64::NAN, f64::NAN), |(a, b)| (a.at, b.at));
        let half = 0.5 * window.length();
        let open = EDGE + half * spacing.usual;
        if !(least <= window.low + open && most >= window.high - open) {
            let detail = format!(
                "defined samples from {} to {} mm do not cover the evaluation range from {} to {} mm: the figures are those of the part \
                 measured, and no class is given",
                Shown(least),
                Shown(most),
                Shown(window.low),
                Shown(window.high)
            );
            self.note(notices, "range_not_covered", detail);
            return Told::Nothing;
        }
        if spacing.is_sparse() {
            let detail = format!(
                "samples are {} mm apart, more than {} % of the evaluation range: form and total deviation may be greater than what they show",
                Shown((half * spacing.usual * 1e4).round() / 1e4),
                Shown(100.0 * LONGEST_DISTANCE)
            );
            self.note(notices, "sparse_samples", detail);
        }
        if spacing.holes.is_empty() {
            return Told::Everything;
        }
        let longest =
            spacing.holes.iter().copied().fold([0.0, 0.0], |a, b| if b[1] - b[0] > a[1] - a[0] { b } else { a });
        let place = |u: f64| Shown(((window.low + half * (u + 1.0)) * 1e4).round() / 1e4);
        let covered = spacing.covered >= LEAST_COVERED;
        let detail = format!(
            "{} without samples within the evaluation range, the longest from {} to {} mm; {} % of the range are covered: {}",
            counted(spacing.holes.len(), "stretch", "stretches"),
            place(longest[0]),
            place(longest[1]),
            Shown((1e2 * spacing.covered).round()),
            if covered { "form and total deviation have no class" } else { "no class is given" }
        );
        self.note(notices, "hole_in_trace", detail);
        if covered { Told::Slope } else { Told::Nothing }
    }

    /// Of samples at three places at least.
    fn figures(&self, taken: &Taken) -> Values {
        let (trace, window) = (self.trace, self.window);
        let mean = MeanCurves::of(&taken.u, &taken.deviation, &taken.spacing.weight);
        let noise = noise(&taken.u, &taken.deviation, &taken.spacing);
        let sign = self.settings.sign.of_material(self.settings.given, trace.kind, trace.side);
        let extended = window.reference / (0.5 * window.length());
        let [slope, slope_noise] = match window.mean {
            MeanCurve::Line => mean.line_slope(),
            MeanCurve::Parabola => mean.chord_slope(),
        };
        let [curvature, curvature_noise] = mean.curvature();
        let about = |u: f64, d: f64| match window.mean {
            MeanCurve::Line => d - mean.line(u),
            MeanCurve::Parabola => d - mean.parabola(u),
        };
        let [form, form_plus_material] = peak_to_valley(taken, window.plus_material.in_form(), about);
        let [total, total_plus_material] = peak_to_valley(taken, window.plus_material.in_total(), |_, d| d);
        Values {
            slope: sign * window.sense * slope * extended,
            slope_std_error: noise.map(|noise| noise * slope_noise * extended),
            form,
            total,
            crowning: -curvature,
            crowning_std_error: noise.map(|noise| noise * curvature_noise),
            form_plus_material,
            total_plus_material,
        }
    }
}

impl Taken {
    fn of(all: &[Sample], exclude: bool) -> Self {
        let counts = |sample: &&Sample| !(exclude && sample.suspect);
        let within = || all.iter().filter(counts).filter(|sample| sample.within);
        let u: Vec<f64> = within().map(|sample| sample.u).collect();
        let spacing = Spacing::of(&u);
        Taken {
            u,
            deviation: within().map(|sample| sample.deviation).collect(),
            zone: all.iter().filter(counts).filter(|s| s.zone).map(|s| [s.u, s.deviation]).collect(),
            spacing,
        }
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
