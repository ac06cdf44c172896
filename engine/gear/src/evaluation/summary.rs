//! Over the teeth: mean, variation and the worst tooth of every figure, and the twist of teeth with
//! several traces.

use super::{
    super::{Kind, Side, tooth::Position},
    Evaluated,
    noise::EstimatedVariance,
    settings::Settings,
};

/// A gear figure over the teeth.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct Spread {
    /// Arithmetic mean over the teeth.
    pub mean: f64,
    /// Greatest minus least.
    pub variation: f64,
    /// The figure of the greatest amount, with its sign.
    pub worst: f64,
    /// The tooth of the greatest amount; of equal ones the first by name.
    pub worst_tooth: String,
}

/// Figures of one kind of trace on one flank over the teeth.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = TraceMeans)
)]
pub struct Summary {
    /// Flank of the teeth.
    pub flank: Side,
    /// Profiles or helices.
    pub kind: Kind,
    /// Number of traces that count: those without a letter after the tooth's number.
    pub count: usize,
    /// Slope f_H.
    pub slope_um: Spread,
    /// Form deviation f_f.
    pub form_um: Spread,
    /// Total deviation F.
    pub total_um: Spread,
    /// Crowning C.
    pub crowning_um: Spread,
    /// Tip relief f_Ko of the profiles that have one.
    pub tip_relief_um: Option<Spread>,
}

/// Twist of a tooth flank from two single traces: f_Hβ near the tip minus f_Hβ near the root
/// (helices), f_Hα at the upper end minus f_Hα at the lower one (profiles), in the sign of helix
/// slopes, between the measured sections. It is not extended: sections half the range apart show
/// half of the `twist_um` of a surface, which is that over the whole ranges; and helix slopes here
/// are extended to the reference length.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = TraceTwist)
)]
pub struct Twist {
    /// The tooth of the traces.
    pub tooth: String,
    /// Flank of the tooth.
    pub flank: Side,
    /// Kind of the traces.
    pub kind: Kind,
    /// Difference of the two `slope_um`, between the two sections; not the figure of the same name
    /// of a surface.
    pub twist_um: f64,
    /// Standard error, from those of the two slopes.
    pub std_error_um: Option<f64>,
    /// Confidence interval at `level`, `[low, high]`.
    pub interval_um: Option<[f64; 2]>,
    /// Diameters of the two helices (root, tip) or z of the two profiles (lower, upper), if known.
    pub sections_mm: Option<[f64; 2]>,
}

pub(super) fn summaries(traces: &[Evaluated]) -> Vec<Summary> {
    let mut summaries = Vec::new();
    for kind in [Kind::Profile, Kind::Helix] {
        for side in [Side::Left, Side::Right] {
            let counted: Vec<_> = traces
                .iter()
                .filter(|t| t.kind == kind && t.flank == side && t.position == Position::Middle)
                .filter_map(|t| t.values.map(|values| (t.tooth.as_str(), values)))
                .collect();
            let over = |figure: fn(&super::Values) -> f64| {
                Spread::new(counted.iter().map(|(tooth, values)| (*tooth, figure(values))).collect())
            };
            let relieved = counted.iter().filter_map(|(tooth, values)| Some((*tooth, values.tip_relief_um?)));
            let tip_relief_um = Spread::new(relieved.collect());
            let spreads = (over(|v| v.slope_um), over(|v| v.form_um), over(|v| v.total_um), over(|v| v.crowning_um));
            if let (Some(slope_um), Some(form_um), Some(total_um), Some(crowning_um)) = spreads {
                let (flank, count) = (side, counted.len());
                summaries.push(Summary { flank, kind, count, slope_um, form_um, total_um, crowning_um, tip_relief_um });
            }
        }
    }
    summaries
}

impl Spread {
    /// `None` of no figures. The order of the teeth makes no difference, not in the last bit
    /// either.
    fn new(mut figures: Vec<(&str, f64)>) -> Option<Self> {
        figures.sort_by(|a, b| a.1.total_cmp(&b.1).then_with(|| a.0.cmp(b.0)));
        let (least, greatest) = (figures.first()?.1, figures.last()?.1);
        let mean = figures.iter().map(|f| f.1).sum::<f64>() / figures.len() as f64;
        let worst = figures.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()).then_with(|| b.0.cmp(a.0)))?;
        Some(Spread { mean, variation: greatest - least, worst_tooth: worst.0.to_owned(), worst: worst.1 })
    }
}

/// In the order in which teeth first appear. Of several traces at the same position the first
/// counts.
pub(super) fn twists(traces: &[Evaluated], settings: &Settings) -> Vec<Twist> {
    let mut seen: Vec<(&str, Side, Kind)> = Vec::new();
    for trace in traces {
        let key = (Position::split(&trace.tooth).0, trace.flank, trace.kind);
        if trace.position != Position::Middle && !seen.contains(&key) {
            seen.push(key);
        }
    }
    seen.into_iter().filter_map(|key| twist(traces, settings, key)).collect()
}

fn twist(traces: &[Evaluated], settings: &Settings, (tooth, side, kind): (&str, Side, Kind)) -> Option<Twist> {
    let [from, to] = match kind {
        Kind::Helix => [Position::Root, Position::Tip],
        Kind::Profile => [Position::Lower, Position::Upper],
    };
    let at = |position| {
        traces.iter().find(|t| {
            t.kind == kind && t.flank == side && t.position == position && Position::split(&t.tooth).0 == tooth
        })
    };
    let (from, to) = (at(from)?, at(to)?);
    let (a, b) = (from.values?, to.values?);
    // one twist, whichever traces tell it: that of the helices' slopes
    let of = |kind| settings.sign.of_material(settings.given, kind, side);
    let sign = of(Kind::Helix) * of(kind);
    let twist = sign * (b.slope_um - a.slope_um);
    let variance = |values: &super::Values| {
        Some(EstimatedVariance {
            value: values.slope_std_error_um?.powi(2),
            freedom: values.freedom?,
            doubts: values.doubts,
        })
    };
    let variance = variance(&a).zip(variance(&b)).map(|(a, b)| EstimatedVariance::sum([a, b].into_iter()));
    Some(Twist {
        tooth: tooth.to_owned(),
        flank: side,
        kind,
        twist_um: twist,
        interval_um: variance.map(|variance| variance.about(twist).interval(settings.level)),
        std_error_um: a.slope_std_error_um.zip(b.slope_std_error_um).map(|(a, b)| a.hypot(b)),
        sections_mm: from.section.zip(to.section).map(|(a, b)| [a, b]),
    })
}
