//! The second-order surface of each flank with several traces: the figures of
//! [`super::flank_surface`] as far as the traces tell them.
//!
//! A trace has a zero of its own unless the caller says that all share one. Samples count by the
//! length that they stand for, as in the evaluation of a single trace: the mean curve is that over
//! the place.

use std::collections::BTreeMap;

use super::{
    Position, Posted,
    contradiction::{Contradiction, contradiction},
    flank_surface::{EstimatedFigure, Figure, FigureTerms, FlankFigures, Sample, Slopes, TERMS, through},
    flank_traces::{FlankTraces, OneTrace, flank_traces, ranges},
    limits::{Inference, ToleranceLimits, within},
    noise::EstimatedVariance,
    settings::{Settings, Window},
    spacing::Spacing,
    warning::{FlankName, SurfaceFigure, Warning},
};
use crate::{
    Gear, Kind, Side,
    tolerance::{Rounding, Tolerances},
    trace::Direction,
};
use flankfit_estimation::inference::Inferred;
use flankfit_numerics::cancel::{self, Asking};

/// Second-order surface through all traces of a tooth flank, over the evaluation ranges, with
/// slopes extended to their reference lengths, transverse; by plain least squares, every sample
/// weighted by the length that it represents. Each trace has a zero of its own, unless
/// `traces_share_zero`. Standard errors are due to the noise of the samples, as for traces: form
/// that the surface does not follow is not noise.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct TraceSurface {
    /// The tooth of the traces.
    pub tooth: String,
    /// Flank of the tooth.
    pub flank: Side,
    /// Number of traces.
    pub traces: usize,
    /// Samples within the evaluation ranges.
    pub samples: usize,
    /// The named figures.
    #[cfg_attr(feature = "contract", serde(flatten), schema(inline))]
    pub figures: TraceFigures,
    /// Roll lengths of the figures (u = ∓1): the evaluation range, or the measured range if no
    /// range of profiles is given.
    pub roll_length_range_mm: [f64; 2],
    /// Range in z of the figures, likewise.
    pub z_range_mm: [f64; 2],
    /// Root mean square of the residuals of the surface (with the zeros of the traces).
    pub rms_um: f64,
    /// Greatest minus least residual of the surface.
    pub peak_to_valley_um: f64,
}

/// Figures that the traces of a flank have in common, in µm over the evaluation range. A figure
/// that they do not determine is absent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = TraceSurfaceFigures)
)]
pub struct TraceFigures {
    /// Deviation in the middle of the flank; only with `traces_share_zero`.
    #[cfg_attr(feature = "contract", serde(rename = "mean_um"))]
    pub mean: Option<Figure>,
    /// Profile slope from root to tip in the middle of the width (without `twist_um` in the
    /// sections of the profiles); positive where material grows towards the tip.
    #[cfg_attr(feature = "contract", serde(rename = "profile_slope_um"))]
    pub profile_slope: Option<Figure>,
    /// Helix slope over the width half-way between root and tip (without `twist_um` on the
    /// diameters of the helices), in the requested sign.
    #[cfg_attr(feature = "contract", serde(rename = "helix_slope_um"))]
    pub helix_slope: Option<Figure>,
    /// Profile crowning; positive where material protrudes half-way between root and tip.
    #[cfg_attr(feature = "contract", serde(rename = "profile_crowning_um"))]
    pub profile_crowning: Option<Figure>,
    /// Helix crowning; positive where material protrudes half-way between the ends.
    #[cfg_attr(feature = "contract", serde(rename = "helix_crowning_um"))]
    pub helix_crowning: Option<Figure>,
    /// Twist, 4 c_uv of the surface: slope at the tip minus slope at the root of helices over the
    /// **whole** evaluation ranges, from all traces together, with the sign of helix slopes.
    /// `twists` have another figure of that name: the difference of two traces, between the
    /// measured sections.
    #[cfg_attr(feature = "contract", serde(rename = "twist_um"))]
    pub twist: Option<Figure>,
}

impl TraceFigures {
    /// Figures that are not determined, other than the mean of traces with zeros of their own.
    fn missing(&self, share_zero: bool) -> Vec<SurfaceFigure> {
        let each = [
            (SurfaceFigure::Mean, self.mean.is_some() || !share_zero),
            (SurfaceFigure::ProfileSlope, self.profile_slope.is_some()),
            (SurfaceFigure::HelixSlope, self.helix_slope.is_some()),
            (SurfaceFigure::ProfileCrowning, self.profile_crowning.is_some()),
            (SurfaceFigure::HelixCrowning, self.helix_crowning.is_some()),
            (SurfaceFigure::Twist, self.twist.is_some()),
        ];
        each.into_iter().filter(|(_, determined)| !determined).map(|(figure, _)| figure).collect()
    }
}

/// Reference lengths and limits of a surface's slopes.
#[derive(Clone, Copy)]
pub(super) struct SlopeLimits<'a> {
    /// The lengths that slopes of profiles and of helices are extended to, mm; `None` where there
    /// are no traces of that kind.
    references: [Option<f64>; 2],
    /// Tolerances of profiles and of helices; `None` where slopes are extended outside the range
    /// that tolerances cover, or where there are none.
    tolerances: [Option<&'a Tolerances>; 2],
    rounding: Rounding,
}

impl<'a> SlopeLimits<'a> {
    /// `foreign` says whose slopes are extended outside the range that tolerances cover.
    pub(super) fn new(
        windows: [Option<&Window>; 2],
        tolerances: Option<&'a Tolerances>,
        foreign: &[Option<Warning>; 2],
        rounding: Rounding,
    ) -> Self {
        let of = |k: usize| tolerances.filter(|_| foreign[k].is_none());
        SlopeLimits {
            references: windows.map(|window| window.map(|window| window.reference)),
            tolerances: [of(0), of(1)],
            rounding,
        }
    }

    /// Returns the factors that extend slopes to their reference lengths; 1 for a kind without
    /// traces of its own.
    fn factors(&self, frame: &Frame) -> [f64; 2] {
        let factor = |k: usize, [low, high]: [f64; 2]| self.references[k].map_or(1.0, |length| length / (high - low));
        [factor(0, frame.roll), factor(1, frame.z)]
    }

    fn of(&self, term: usize, limits: &ToleranceLimits) -> Option<[f64; 2]> {
        let whole = |kind: Kind| {
            let k = usize::from(kind == Kind::Helix);
            self.references[k]?;
            limits.slope_over(kind, 1.0, 1.0, self.tolerances[k], self.rounding)
        };
        match term {
            1 => whole(Kind::Profile),
            2 => whole(Kind::Helix),
            3 => limits.profile_crowning_um,
            4 => limits.twist_um,
            5 => limits.helix_crowning_um,
            _ => None,
        }
    }
}

/// Ranges of u and v of a flank.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Frame {
    roll: [f64; 2],
    z: [f64; 2],
    /// +1 where the tip lies at greater roll lengths.
    outward: f64,
}

impl Frame {
    /// Over the evaluation ranges; where there is none over what the samples span.
    fn new(gear: &Gear, flank: &FlankTraces, settings: &Settings) -> Self {
        let span = |c: usize| {
            let ends = [f64::INFINITY, f64::NEG_INFINITY];
            flank.places.iter().fold(ends, |[low, high], place| [low.min(place[c]), high.max(place[c])])
        };
        let [rolls, helix] = ranges(gear, settings);
        let ascending = |range: Option<[f64; 2]>| range.filter(|[low, high]| high > low);
        Frame {
            roll: ascending(rolls).unwrap_or_else(|| span(0)),
            z: ascending(helix).unwrap_or_else(|| span(1)),
            outward: gear.outward(),
        }
    }

    fn at(&self, [roll, z, _]: [f64; 3]) -> [f64; 2] {
        [self.outward * mapped(roll, self.roll), mapped(z, self.z)]
    }
}

/// 0 where all lie at one place.
fn mapped(x: f64, [low, high]: [f64; 2]) -> f64 {
    if high > low { (2.0 * x - low - high) / (high - low) } else { 0.0 }
}

/// The samples of each trace, every one with the length that it represents.
fn samples(flank: &FlankTraces, frame: &Frame) -> Vec<Vec<Sample>> {
    let each = flank.split().map(|(trace, places)| {
        cancel::checkpoint();
        let along = usize::from(trace.kind == Kind::Helix);
        let mut samples: Vec<Sample> = places
            .iter()
            .map(|place| {
                let [u, v] = frame.at(*place);
                Sample { u, v, deviation: place[2], weight: 1.0 }
            })
            .collect();
        let at = |sample: &Sample| if along == 0 { sample.u } else { sample.v };
        samples.sort_by(cancel::comparing(|a: &Sample, b: &Sample| {
            at(a).total_cmp(&at(b)).then(a.deviation.total_cmp(&b.deviation))
        }));
        let places: Vec<f64> = samples.iter().map(at).collect();
        // a lone place represents no length
        let spacing = Spacing::of(&places);
        if spacing.places > 1 {
            samples.iter_mut().zip(spacing.weight).for_each(|(sample, weight)| sample.weight = weight);
        }
        samples
    });
    each.collect()
}

/// A flank's surface with what its residuals say.
struct FittedTraces {
    surface: TraceSurface,
    contradiction: Option<Contradiction>,
}

impl FlankTraces {
    /// `None` where a single trace is all there is: what it shows is its own.
    fn surface(&self, gear: &Gear, settings: &Settings, slopes: &SlopeLimits) -> Option<FittedTraces> {
        if self.each.len() < 2 {
            return None;
        }
        let frame = Frame::new(gear, self, settings);
        let traces = samples(self, &frame);
        let found = through(&traces, settings.traces_share_zero)?;
        let variances = self.noise().map(|pooled| {
            found.variances(&traces, |t| {
                self.each.get(t).and_then(|trace| trace.noise).map_or(pooled, |noise| noise.variance)
            })
        });
        let [profile, helix] =
            [Kind::Profile, Kind::Helix].map(|kind| settings.sign.of_material(settings.given, kind, self.side));
        let figure = |term: usize, factor: f64| {
            let value = factor * found.coefficients[term]?;
            let about = variances.and_then(|all| all[term]).map(|one| one.about(value / factor).scaled(factor));
            let limits = slopes.of(term, &settings.limits.of(self.side));
            let inference = |about: Inferred| Inference::new(&about, settings.level);
            Some(Figure {
                limits,
                within: within(value, limits),
                value,
                std_error: about.map(|about| about.std_error),
                conditional_std_error: None,
                bias_bound: 0.0,
                least_squares: value,
                inference: about.map(inference),
                conformity: about.zip(limits).map(|(about, limits)| about.conformity(limits)),
            })
        };
        let factors = slopes.factors(&frame);
        let figures = TraceFigures {
            mean: figure(0, 1.0),
            profile_slope: figure(1, 2.0 * profile * factors[0]),
            helix_slope: figure(2, 2.0 * helix * factors[1]),
            profile_crowning: figure(3, -1.0),
            helix_crowning: figure(5, -1.0),
            twist: figure(4, 4.0 * helix),
        };
        let left = traces.iter().enumerate().flat_map(|(t, trace)| trace.iter().map(move |sample| (t, sample)));
        let (mut lowest, mut highest, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for (t, sample) in left.asking(20) {
            let left = found.left(t, sample);
            (lowest, highest, sum) = (lowest.min(left), highest.max(left), sum + left * left);
        }
        let kinds: Vec<Kind> = self.each.iter().map(|trace| trace.kind).collect();
        let surface = TraceSurface {
            tooth: self.tooth.clone(),
            flank: self.side,
            traces: self.each.len(),
            samples: self.places.len(),
            figures,
            roll_length_range_mm: frame.roll,
            z_range_mm: frame.z,
            rms_um: (sum / self.places.len() as f64).sqrt(),
            peak_to_valley_um: highest - lowest,
        };
        let contradiction = contradiction(&traces, &kinds, &found, settings.traces_share_zero);
        Some(FittedTraces { surface, contradiction })
    }

    /// Variance of the noise over the traces that tell it, µm².
    fn noise(&self) -> Option<EstimatedVariance> {
        let known = self.each.iter().filter_map(|trace| Some((trace.samples as f64, trace.noise?.variance)));
        let count: f64 = known.clone().map(|(samples, _)| samples).sum();
        let shares =
            known.map(|(samples, variance)| EstimatedVariance { value: samples / count * variance.value, ..variance });
        (count > 0.0).then(|| EstimatedVariance::sum(shares))
    }

    /// Returns the places after the zeros of the traces are subtracted, so that the traces meet in
    /// their second-order surface.
    pub fn levelled(&self, gear: &Gear, settings: &Settings) -> Levelled {
        let frame = Frame::new(gear, self, settings);
        Levelled::new(&self.places, self.lengths(), &samples(self, &frame))
    }
}

/// Places of traces whose separate zeros are subtracted.
#[derive(Clone, Debug, PartialEq)]
pub struct Levelled {
    /// Roll length, z, deviation: one trace after the other.
    pub places: Vec<[f64; 3]>,
    /// The traces.
    pub zeros: OwnZeros,
}

/// Traces with separate zeros, and the terms of the second-order surface that they determine.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnZeros {
    /// Number of places of each trace.
    pub lengths: Vec<usize>,
    /// True if they determine a slope along the profile, and one along the helix.
    pub along: [bool; 2],
    /// True if they determine all terms but the constant.
    pub whole: bool,
}

impl Levelled {
    fn new(places: &[[f64; 3]], lengths: Vec<usize>, samples: &[Vec<Sample>]) -> Self {
        let Some(found) = through(samples, false).filter(|_| lengths.len() > 1) else {
            return Levelled { places: places.to_vec(), zeros: OwnZeros { lengths, along: [true; 2], whole: true } };
        };
        let zeros = lengths.iter().zip(&found.zeros).flat_map(|(length, zero)| std::iter::repeat_n(*zero, *length));
        let places = places.iter().zip(zeros).map(|([u, v, deviation], zero)| [*u, *v, deviation - zero]).collect();
        let determined = |term: usize| found.coefficients[term].is_some();
        let along = [determined(1), determined(2)];
        Levelled { places, zeros: OwnZeros { lengths, along, whole: (1..TERMS).all(determined) } }
    }

    /// Subtracts the zeros of traces of `lengths` places each: first and second coordinate and
    /// height, in any units. `weight` has an entry for each place.
    pub fn of_places(places: &[[f64; 3]], weight: &[f64], lengths: Vec<usize>) -> Self {
        let range = |c: usize| {
            places
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], place| [low.min(place[c]), high.max(place[c])])
        };
        let [us, vs] = [range(0), range(1)];
        let sample = |([u, v, deviation], weight): (&[f64; 3], &f64)| Sample {
            u: mapped(*u, us),
            v: mapped(*v, vs),
            deviation: *deviation,
            // another is no weight, and refused with the nodes
            weight: if weight.is_finite() { weight.max(0.0) } else { 0.0 },
        };
        let mut rest = places.iter().zip(weight);
        let samples: Vec<Vec<Sample>> =
            lengths.iter().map(|length| rest.by_ref().take(*length).map(sample).collect()).collect();
        Levelled::new(places, lengths, &samples)
    }
}

/// The surfaces of the flanks with several traces, in the order of teeth, left flanks first, and
/// their warnings.
pub(super) fn surfaces(
    gear: &Gear,
    posted: &[Posted],
    settings: &Settings,
    slopes: &SlopeLimits,
) -> (Vec<TraceSurface>, Vec<Warning>) {
    let flanks = flank_traces(gear, posted, settings);
    let mut found: Vec<FittedTraces> =
        flanks.iter().filter_map(|flank| flank.surface(gear, settings, slopes)).collect();
    let number = |tooth: &str| Position::number(tooth).unwrap_or(u64::MAX);
    found.sort_by(|a, b| {
        let (a, b) = (&a.surface, &b.surface);
        (number(&a.tooth), &a.tooth, a.flank).cmp(&(number(&b.tooth), &b.tooth, b.flank))
    });
    let mut warnings = warnings(&found, settings);
    warnings.extend(
        flanks.iter().filter(|flank| flank.each.len() > 1).flat_map(|flank| &flank.each).filter_map(OneTrace::warning),
    );
    (found.into_iter().map(|found| found.surface).collect(), warnings)
}

fn warnings(found: &[FittedTraces], settings: &Settings) -> Vec<Warning> {
    let name = |surface: &TraceSurface| FlankName { tooth: surface.tooth.clone(), side: surface.flank };
    let share_zero = settings.traces_share_zero;
    let mut missing: BTreeMap<Vec<SurfaceFigure>, Vec<FlankName>> = BTreeMap::new();
    for surface in found.iter().map(|found| &found.surface) {
        let figures = surface.figures.missing(share_zero);
        if !figures.is_empty() {
            missing.entry(figures).or_default().push(name(surface));
        }
    }
    let undetermined = missing.into_iter().map(|(figures, flanks)| Warning::FiguresUndetermined {
        figures,
        traces_share_zero: share_zero,
        flanks,
    });
    let mut warnings: Vec<Warning> = undetermined.collect();
    for FittedTraces { surface, contradiction } in found {
        let Some(Contradiction { apart, own, turned }) = *contradiction else { continue };
        warnings.push(Warning::SurfaceMisfit { flank: name(surface), rms_together_um: apart, rms_own_um: own });
        let turned = turned.map(|turned| Warning::HelixSignDoubtful {
            flank: name(surface),
            rms_um: apart,
            rms_turned_um: turned,
        });
        warnings.extend(turned);
    }
    warnings
}

/// Returns the figures, slopes by DIN, of nodes that belong to traces with zeros of their own: roll
/// length, z, deviation along the normal (µm, NaN where it takes no part) and the number of the
/// trace. `None` where they determine none.
pub fn figures_of_traces(
    nodes: &[([f64; 3], usize)],
    ranges: [[f64; 2]; 2],
    gear: &Gear,
    side: Side,
    terms: FigureTerms,
) -> Option<FlankFigures<EstimatedFigure>> {
    let frame = Frame { roll: ranges[0], z: ranges[1], outward: gear.outward() };
    let inside = |x: f64, [low, high]: [f64; 2]| x >= low - super::EDGE && x <= high + super::EDGE;
    let mut traces: BTreeMap<usize, Vec<Sample>> = BTreeMap::new();
    for (place, trace) in nodes.iter().asking(20) {
        if !place[2].is_nan() && inside(place[0], frame.roll) && inside(place[1], frame.z) {
            let [u, v] = frame.at(*place);
            traces.entry(*trace).or_default().push(Sample { u, v, deviation: place[2], weight: 1.0 });
        }
    }
    let traces: Vec<Vec<Sample>> = traces.into_values().collect();
    let found = through(&traces, false)?;
    let samples: usize = traces.iter().map(Vec::len).sum();
    let determined = found.coefficients.iter().flatten().count();
    let freedom = samples.saturating_sub(traces.len() + determined);
    let variance = found.rss / freedom.max(1) as f64;
    let noise = EstimatedVariance { value: variance, freedom: freedom as f64, ..EstimatedVariance::default() };
    let errors = found.variances(&traces, |_| noise);
    let scale = terms.factor(gear, Direction::Normal);
    let of = |term: usize, factor: f64| {
        let error = errors[term].map(|variance| variance.value.sqrt());
        Some(EstimatedFigure::new(found.coefficients[term]?, error, freedom, scale * factor))
    };
    let Slopes { factors, .. } = Slopes::of_nodes(gear, terms, ranges);
    Some(FlankFigures {
        profile_slope: of(1, 2.0 * factors[0]),
        helix_slope: of(2, 2.0 * side.sign() * factors[1]),
        profile_crowning: of(3, -1.0),
        helix_crowning: of(5, -1.0),
        twist: of(4, 4.0 * side.sign()),
    })
}
