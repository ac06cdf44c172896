//! Slopes, forms and totals of traces, over the teeth and with their classes.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    band::KBandFindingBody, conformity::ConformityBody, figures::TraceFiguresBody, request::EvaluationSettingsBody,
};
use crate::api::{
    gears::{notice::NoticeBody, trace::KindName},
    measurand::side::SideName,
};

/// What traces say.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearEvaluation)]
pub struct EvaluationBody {
    /// In the order in which they were posted.
    pub traces: Vec<EvaluatedTraceBody>,
    /// Over the teeth, by kind and flank.
    pub means: Vec<MeanBody>,
    /// Of teeth with helices near root and tip or with profiles at both ends.
    pub twists: Vec<TwistBody>,
    /// Second-order surfaces of the tooth flanks with two traces or more whose sections are known,
    /// each figure where the traces tell it.
    pub surfaces: Vec<TraceSurfaceBody>,
    /// The coarsest class of all traces, 1 to 11; left out where there is none.
    pub class: Option<u8>,
    /// Whether a trace exceeds even class 11.
    pub beyond_classes: bool,
    /// What the traces were evaluated with, every default written out.
    pub evaluation: EvaluationSettingsBody,
    /// What to know about the answer as a whole; each trace has its own.
    pub warnings: Vec<NoticeBody>,
}

/// A trace, evaluated.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EvaluatedTrace)]
pub struct EvaluatedTraceBody {
    /// As it was posted with the trace.
    pub tooth: String,
    pub flank: SideName,
    pub kind: KindName,
    /// f_Hα or f_Hβ: slope of the least-squares line over the whole evaluation range, extended to
    /// the reference length. A hole is filled with what the flank most likely is there. Left out,
    /// like all figures, where the samples do not reach the ends of the range to 1/20 of it or
    /// cover less than 3/4 of it.
    pub slope_um: Option<f64>,
    /// What noise of the samples makes of the slope; crowning, reliefs and waviness are the flank's
    /// and no noise. It knows of independent noise and of noise that goes together over up to 1/64
    /// of the samples, not of what is the same all along a trace (alignment, drift). Over a hole it
    /// also has what the hole may hide, told from the form beside it. Left out where the samples
    /// are too few to tell it.
    pub slope_std_error_um: Option<f64>,
    /// Confidence interval of the true slope at `level`, `[low, high]`, for the noise that the
    /// standard error knows of (docs/explanation/intervals.md); left out as its standard error is.
    #[schema(min_items = 2, max_items = 2)]
    pub slope_interval_um: Option<[f64; 2]>,
    /// There where the slope has limits (`tolerance_limits`) and an interval, and the samples reach
    /// both ends of the range.
    pub slope_conformity: Option<ConformityBody>,
    /// Whether the slope itself lies within its limits (`tolerance_limits`); there where it has
    /// some and the samples reach both ends of the range.
    pub slope_within: Option<bool>,
    /// f_fα or f_fβ: peak to valley about the mean curve. Like the total it has no interval: the
    /// greatest of many deviations is raised by their noise and no sum of them.
    pub form_um: Option<f64>,
    /// As that of the slope; over a hole it cannot be told.
    pub form_within: Option<bool>,
    /// F_α or F_β: peak to valley about the design.
    pub total_um: Option<f64>,
    /// As that of the form.
    pub total_within: Option<bool>,
    /// Of the mean parabola over its chord; positive where material stands out in the middle.
    pub crowning_um: Option<f64>,
    /// As that of the slope.
    pub crowning_std_error_um: Option<f64>,
    /// As that of the slope.
    #[schema(min_items = 2, max_items = 2)]
    pub crowning_interval_um: Option<[f64; 2]>,
    /// As that of the slope.
    pub crowning_conformity: Option<ConformityBody>,
    /// f_Ko of a profile: the least-squares line of the tip relief at its tip end, above the
    /// extended least-squares line of the evaluation range; negative where material is missing.
    /// There where `tip_relief_diameter_range_mm` is given and the samples cover it.
    pub tip_relief_um: Option<f64>,
    /// Evaluation range: roll lengths of a profile, z of a helix.
    #[schema(min_items = 2, max_items = 2)]
    pub range_mm: Option<[f64; 2]>,
    /// The least-squares line at both ends of the range, as it is drawn over the trace: in the sign
    /// and direction of the posted deviations, about the design line where there is one. Left out
    /// as the figures are.
    #[schema(min_items = 2, max_items = 2)]
    pub mean_line_um: Option<[f64; 2]>,
    /// The least-squares parabola at the start, in the middle and at the end of the range,
    /// likewise.
    #[schema(min_items = 3, max_items = 3)]
    pub mean_parabola_um: Option<[f64; 3]>,
    /// As that of the slope.
    pub crowning_within: Option<bool>,
    /// The design line of the trace: µm for each sample, in the sign and the direction of its
    /// deviations. Left out where nothing of it differs from 0.
    pub design_um: Option<Vec<f64>>,
    /// The bands that the trace must lie in (`k_bands`), and whether it does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub k_bands: Vec<KBandFindingBody>,
    /// By how much material beyond the evaluation range raised the form.
    pub form_plus_material_um: Option<f64>,
    /// By how much material beyond the evaluation range raised the total deviation.
    pub total_plus_material_um: Option<f64>,
    /// By ISO 1328-1:2013; left out where the standard gives none, and where samples do not reach
    /// both ends of the evaluation range. Over a hole, a stretch without samples of more than 1/20
    /// of the range (and of 2.5 usual distances), form and total have none, and the slope has one
    /// where two standard errors up and down have the same.
    pub class: Option<ClassesBody>,
    pub samples: SamplesBody,
    /// Samples that stand far out of their neighbours, as dust does; left out where there are none.
    pub outliers: Option<OutliersBody>,
}

/// Samples that stand out of their neighbours by more than six times the scale (1.4826 × median
/// absolute deviation) of the trace and of their own neighbourhood, and behind which the trace
/// comes back.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TraceOutliers)]
pub struct OutliersBody {
    /// In ascending order.
    pub places: Vec<OutlierPlaceBody>,
    /// Figures without them, where they count (`outliers` of the evaluation is `keep`).
    pub without: Option<WithoutOutliersBody>,
}

/// Neighbouring samples that stand out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = OutlierPlace)]
pub struct OutlierPlaceBody {
    /// Roll length (profiles) or z (helices) of the first sample …
    pub from_mm: f64,
    /// … and of the last.
    pub to_mm: f64,
    /// How many samples stand out there.
    pub samples: usize,
    /// How far they stand out at most, positive where material does.
    pub height_um: f64,
    /// Whether material stands out at an end, as a burr does, where at least half of the other
    /// traces of the same flank and kind have less than half of it; needs three traces.
    #[serde(default)]
    pub burr: bool,
}

/// Figures of a trace without its outliers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FiguresWithoutOutliers)]
pub struct WithoutOutliersBody {
    /// f_Hα or f_Hβ.
    pub slope_um: f64,
    /// f_fα or f_fβ.
    pub form_um: f64,
    /// F_α or F_β.
    pub total_um: f64,
    /// Of the mean parabola without them; positive where material stands out in the middle.
    pub crowning_um: f64,
}

/// Classes 1 to 11 of ISO 1328-1:2013. Left out is what exceeds even class 11: `beyond` names it.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = TraceClasses)]
pub struct ClassesBody {
    /// Of f_Hα or f_Hβ, 1 to 11.
    pub slope: Option<u8>,
    /// Of f_fα or f_fβ, 1 to 11.
    pub form: Option<u8>,
    /// Of F_α or F_β, 1 to 11.
    pub total: Option<u8>,
    /// Names of those that exceed even class 11.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beyond: Vec<String>,
}

/// How many samples there were.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = TraceSamples)]
pub struct SamplesBody {
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
}

/// Figures of one kind of trace on one flank over the teeth.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TraceMeans)]
pub struct MeanBody {
    pub flank: SideName,
    pub kind: KindName,
    /// Traces that count: those without a letter behind the tooth's number.
    pub count: usize,
    pub slope_um: SpreadBody,
    pub form_um: SpreadBody,
    pub total_um: SpreadBody,
    pub crowning_um: SpreadBody,
    /// Of profiles with a tip relief.
    pub tip_relief_um: Option<SpreadBody>,
}

/// A figure over the teeth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Spread)]
pub struct SpreadBody {
    /// Arithmetic mean over the teeth.
    pub mean: f64,
    /// Greatest minus least.
    pub variation: f64,
    /// The greatest amount.
    pub worst: f64,
    /// The tooth of the greatest amount.
    pub worst_tooth: String,
}

/// Twist of a tooth flank from two single traces: f_Hβ near the tip minus f_Hβ near the root
/// (helices), f_Hα at the upper end minus f_Hα at the lower one (profiles), in the sign of helix
/// slopes, between the sections that were measured. It is not extended: sections half the range
/// apart show half of the `twist_um` of a surface, which is that over the whole ranges; and helix
/// slopes here are extended to the reference length.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TraceTwist)]
pub struct TwistBody {
    /// The tooth whose traces they are.
    pub tooth: String,
    pub flank: SideName,
    /// Of which traces it is.
    pub kind: KindName,
    /// Difference of the two `slope_um`, between the two sections; not the figure of the same name
    /// of a surface.
    pub twist_um: f64,
    /// From the standard errors of the two slopes.
    pub std_error_um: Option<f64>,
    /// Confidence interval at `level`, `[low, high]`.
    #[schema(min_items = 2, max_items = 2)]
    pub interval_um: Option<[f64; 2]>,
    /// Diameters of the two helices or z of the two profiles, where known.
    #[schema(min_items = 2, max_items = 2)]
    pub sections_mm: Option<[f64; 2]>,
}

/// The second-order surface through all traces of a tooth flank, over the evaluation ranges, with
/// slopes extended to their reference lengths, transverse; by plain least squares, every sample
/// counting by the length that it stands for. Each trace has a zero of its own, unless
/// `traces_share_zero`.
/// Standard errors are what noise of the samples makes of the figures, as for traces: form that the
/// surface leaves is no noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TraceSurface)]
pub struct TraceSurfaceBody {
    /// The tooth whose traces they are.
    pub tooth: String,
    pub flank: SideName,
    /// How many traces it goes through.
    pub traces: usize,
    /// Samples within the evaluation ranges.
    pub samples: usize,
    #[serde(flatten)]
    #[schema(inline)]
    pub figures: TraceFiguresBody,
    /// Roll lengths that the figures are over: the evaluation range, or what was measured where no
    /// range of profiles is given.
    #[schema(min_items = 2, max_items = 2)]
    pub roll_length_range_mm: [f64; 2],
    /// The same along the width.
    #[schema(min_items = 2, max_items = 2)]
    pub z_range_mm: [f64; 2],
    /// What the surface (with the zeros of the traces) leaves.
    pub rms_um: f64,
    /// Greatest minus least of what the surface leaves.
    pub peak_to_valley_um: f64,
}
