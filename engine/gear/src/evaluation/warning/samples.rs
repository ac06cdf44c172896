//! Warnings about the samples of one trace.

use std::fmt;

use super::{
    super::{
        spacing::{LEAST_COVERED, LONGEST_DISTANCE},
        values::{FEWEST_SAMPLES, Suspect, WithoutSuspects},
    },
    hundredth,
};
use crate::warning::tenth;
use flankfit_numerics::{
    warnings,
    words::{Shown, counted, listed},
};

warnings! {
/// Something that the reader must know of a trace. Places and lengths are roll lengths or z, mm;
/// shares are of the evaluation range.
pub enum TraceWarning {
    /// So many samples of the range without a deviation.
    #[error(
        "{} within the evaluation range omitted", counted(*.count, "undefined sample", "undefined samples")
    )]
    "undefined_samples" => UndefinedSamples { count: usize },
    /// Fewer samples than a trace is evaluated from.
    #[error(
        "{} within the evaluation range; a trace needs at least {FEWEST_SAMPLES}",
        counted(*.count, "defined sample", "defined samples")
    )]
    "too_few_samples" => TooFewSamples { count: usize },
    /// Samples at so few places.
    #[error("no mean curve: the samples lie at {} only", counted(*.count, "place", "places"))]
    "no_mean_curve" => NoMeanCurve { count: usize },
    /// Samples that do not reach both ends of the range.
    #[error(
        "defined samples from {} to {} mm do not cover the evaluation range from {} to {} mm: {effect}",
        place(.samples_mm[0]), place(.samples_mm[1]), Shown(.range_mm[0]), Shown(.range_mm[1])
    )]
    "range_not_covered" => RangeNotCovered {
        /// The first and the last.
        samples_mm: [f64; 2],
        /// The evaluation range.
        range_mm: [f64; 2],
        /// Effect on the results.
        #[cfg_attr(feature = "contract", serde(flatten))]
        effect: Effect,
    },
    /// Samples too far apart to show the form; their usual distance.
    #[error(
        "samples are {} mm apart, more than {} % of the evaluation range: form and total deviation may be greater \
         than shown",
        place(*.distance_mm), percent(LONGEST_DISTANCE)
    )]
    "sparse_samples" => SparseSamples { distance_mm: f64 },
    /// Holes within the range.
    #[error(
        "{} without samples within the evaluation range, the longest from {} to {} mm: {effect}",
        counted(*.count, "stretch", "stretches"), place(.longest_mm[0]), place(.longest_mm[1])
    )]
    "hole_in_trace" => HoleInTrace {
        /// How many.
        count: usize,
        /// From and to of the longest.
        longest_mm: [f64; 2],
        /// Effect on the results.
        #[cfg_attr(feature = "contract", serde(flatten))]
        effect: Effect,
    },
    /// Shorter stretches with missing samples.
    #[error(
        "{} % of the evaluation range lie in {} where samples are missing, the longest from {} to {} mm: {effect}",
        percent(*.share), counted(*.count, "stretch", "stretches"), place(.longest_mm[0]), place(.longest_mm[1])
    )]
    "samples_missing" => SamplesMissing {
        /// Share of the range in them.
        share: f64,
        /// How many.
        count: usize,
        /// From and to of the longest.
        longest_mm: [f64; 2],
        /// Effect on the results.
        #[cfg_attr(feature = "contract", serde(flatten))]
        effect: Effect,
    },
    /// Samples that stand far out of their neighbours.
    #[error("{}", outliers(.places, *.more, *.excluded, .without.as_ref()))]
    "outliers_suspected" => OutliersSuspected {
        /// The first places of them.
        places: Vec<Suspect>,
        /// Whether there are more.
        more: bool,
        /// Whether they are left out.
        excluded: bool,
        /// The figures without them, where they count and the samples that are left tell them.
        #[cfg_attr(feature = "contract", serde(skip))]
        without: Option<WithoutSuspects>,
    },
    /// Correlated noise, which the samples do not determine well enough.
    #[error(
        "the noise of neighbouring samples is correlated: {count} samples determine slope and crowning like \
         {} independent ones, and standard errors may be too small by up to a factor of {factor:.1}; treat intervals \
         and conformity as doubtful, and measure the trace again or with more samples",
        .effective.round()
    )]
    "correlated_noise" => CorrelatedNoise {
        /// Samples of the range.
        count: usize,
        /// Independent samples that would determine the slope as well.
        effective: f64,
        /// Factor by which standard errors may be too small.
        factor: f64,
    },
    /// A slope over a hole, whose standard error is not known.
    #[error("the slope has no class: there are too few samples to assess the hole")]
    "slope_class_open" => SlopeClassUnknown,
    /// A slope over a hole, whose standard error covers several classes, µm.
    #[error(
        "the slope has no class: because of the hole it is too uncertain ({} ± {} µm)", hundredth(*.slope_um),
        hundredth(*.std_error_um)
    )]
    "slope_class_open" => SlopeClassOpen { slope_um: f64, std_error_um: f64 },
}
}

impl TraceWarning {
    /// Places of outliers that are named.
    pub const NAMED: usize = 5;
}

/// Consequences of missing samples for figures and classes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize), serde(tag = "effect", rename_all = "snake_case"))]
pub enum Effect {
    /// Neither is given.
    Nothing,
    /// Neither is given: too small a share of the range is covered.
    TooLittleCovered {
        /// Share of the range.
        covered: f64,
    },
    /// Neither is given: an end is too far from the samples.
    TooFarToExtend,
    /// Figures exist, but no class.
    NoClass,
    /// Slope and crowning go on to the ends of the range, and there is no class.
    Extended,
    /// Slope and crowning go on across a hole, of a range of which this share is covered; form and
    /// total deviation have no class.
    Bridged {
        /// Share of the range.
        covered: f64,
    },
    /// Form and total deviation may be greater.
    LowerBound,
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Effect::Nothing => f.write_str("no figures and no class are given"),
            Effect::TooLittleCovered { covered } => write!(
                f,
                "no figures and no class are given: {} % of the range is covered, less than {} %",
                percent(*covered),
                percent(LEAST_COVERED)
            ),
            Effect::TooFarToExtend => write!(
                f,
                "no figures and no class are given: results are extended by at most {} % of the range",
                percent(LONGEST_DISTANCE)
            ),
            Effect::NoClass => f.write_str("no class is given"),
            Effect::Extended => {
                f.write_str("slope and crowning use the most likely continuation of the flank, and no class is given")
            }
            Effect::Bridged { covered } => write!(
                f,
                "form and total deviation have no class; slope and crowning use the most likely course of the flank \
                 in between ({} % of the range is covered)",
                percent(*covered)
            ),
            Effect::LowerBound => f.write_str("form and total deviation may be greater than the samples show"),
        }
    }
}

fn outliers(first: &[Suspect], more: bool, excluded: bool, without: Option<&WithoutSuspects>) -> impl fmt::Display {
    let along = |x: f64| Shown((x * 1e3).round() / 1e3);
    let one = move |place: &Suspect| {
        let (from, to, height) = (along(place.from_mm), along(place.to_mm), tenth(place.height_um));
        match (place.samples, place.burr) {
            (1, false) => format!("at {from} mm ({height} µm)"),
            (_, false) => format!("from {from} to {to} mm ({height} µm)"),
            (_, true) => format!(
                "a burr at the end from {from} to {to} mm ({height} µm), which most other traces of the flank do not \
                    have"
            ),
        }
    };
    fmt::from_fn(move |f| {
        let (places, others) = (listed(first.iter().map(one)), if more { " and others" } else { "" });
        let what = if first.iter().any(|place| place.burr) { "dust or a burr" } else { "dust" };
        write!(f, "samples are far from their neighbours, as with {what}: {places}{others}; ")?;
        match (excluded, without) {
            (true, _) => f.write_str("they are omitted"),
            (false, Some(values)) => {
                let [slope, form, total] = [values.slope_um, values.form_um, values.total_um].map(tenth);
                write!(f, "they count. Without them slope {slope}, form {form}, total {total} µm")
            }
            (false, None) => f.write_str("they count"),
        }
    })
}

/// A place along a trace, to a tenth of a µm.
fn place(x: f64) -> Shown {
    Shown((x * 1e4).round() / 1e4)
}

pub(super) fn percent(share: f64) -> Shown {
    Shown((1e3 * share).round() / 10.0)
}
