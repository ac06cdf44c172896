//! Over the teeth: mean, variation and the worst tooth of every figure, and the twist of teeth with
//! several traces.

use super::{
    super::{Kind, Side, tooth::Position},
    Evaluated,
    noise::EstimatedVariance,
    settings::Settings,
};

/// A figure over the teeth, µm.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: f64,
    /// Greatest minus least.
    pub variation: f64,
    /// The tooth with the greatest amount, and its figure; of equal ones the first by name.
    pub worst_tooth: String,
    /// Its figure, with its sign.
    pub worst: f64,
}

/// Figures of one kind of trace on one flank over the teeth. Traces beside the middle
/// ([`Position`]) do not count.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Flank of the teeth.
    pub side: Side,
    /// Profiles or helices.
    pub kind: Kind,
    /// Traces that count.
    pub count: usize,
    /// Slope f_H.
    pub slope: Spread,
    /// Form deviation f_f.
    pub form: Spread,
    /// Total deviation F.
    pub total: Spread,
    /// Crowning C.
    pub crowning: Spread,
    /// Tip relief f_Ko of the traces that have one.
    pub tip_relief: Option<Spread>,
}

/// Twist of a tooth flank: by helices `S = f_Hβ(tip) − f_Hβ(root)`, by profiles `f_Hα(upper) −
/// f_Hα(lower)`, both in the sign of helix slopes and between the sections that were measured
/// (nothing is extended).
#[derive(Clone, Debug, PartialEq)]
pub struct Twist {
    /// The tooth as its traces name it.
    pub tooth: String,
    /// Flank of the tooth.
    pub side: Side,
    /// Which traces it is from.
    pub kind: Kind,
    /// µm.
    pub twist: f64,
    /// Standard error, µm; `None` where that of a slope is not known.
    pub std_error: Option<f64>,
    /// Confidence interval at the level asked for.
    pub interval: Option<[f64; 2]>,
    /// Diameters of the two helices or z of the two profiles, mm, in the order root, tip or lower,
    /// upper; where known.
    pub sections: Option<[f64; 2]>,
}

pub(super) fn summaries(traces: &[Evaluated]) -> Vec<Summary> {
    let mut summaries = Vec::new();
    for kind in [Kind::Profile, Kind::Helix] {
        for side in [Side::Left, Side::Right] {
            let counted: Vec<_> = traces
                .iter()
                .filter(|t| t.kind == kind && t.side == side && t.position == Position::Middle)
                .filter_map(|t| t.values.map(|values| (t.tooth.as_str(), values)))
                .collect();
            let over = |figure: fn(&super::Values) -> f64| {
                Spread::new(counted.iter().map(|(tooth, values)| (*tooth, figure(values))).collect())
            };
            let relieved = counted.iter().filter_map(|(tooth, values)| Some((*tooth, values.tip_relief?)));
            let tip_relief = Spread::new(relieved.collect());
            let spreads = (over(|v| v.slope), over(|v| v.form), over(|v| v.total), over(|v| v.crowning));
            if let (Some(slope), Some(form), Some(total), Some(crowning)) = spreads {
                let count = counted.len();
                summaries.push(Summary { side, kind, count, slope, form, total, crowning, tip_relief });
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
        let key = (Position::split(&trace.tooth).0, trace.side, trace.kind);
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
            t.kind == kind && t.side == side && t.position == position && Position::split(&t.tooth).0 == tooth
        })
    };
    let (from, to) = (at(from)?, at(to)?);
    let (a, b) = (from.values?, to.values?);
    // one twist, whichever traces tell it: that of the helices' slopes
    let of = |kind| settings.sign.of_material(settings.given, kind, side);
    let sign = of(Kind::Helix) * of(kind);
    let twist = sign * (b.slope - a.slope);
    let variance = |values: &super::Values| {
        Some(EstimatedVariance { value: values.slope_std_error?.powi(2), freedom: values.freedom? })
    };
    let variance = variance(&a).zip(variance(&b)).map(|(a, b)| EstimatedVariance::sum([a, b].into_iter()));
    Some(Twist {
        tooth: tooth.to_owned(),
        side,
        kind,
        twist,
        interval: variance.map(|variance| variance.about(twist).interval(settings.level)),
        std_error: a.slope_std_error.zip(b.slope_std_error).map(|(a, b)| a.hypot(b)),
        sections: from.section.zip(to.section).map(|(a, b)| [a, b]),
    })
}
