//! Results of the evaluation of a trace: figures, and suspected outliers.

use flankfit_estimation::inference::Doubts;

/// Fewest defined samples of the evaluation range.
pub const FEWEST_SAMPLES: usize = 5;
/// Samples this near to the end of a range belong to it, mm: positions are rounded numbers.
pub const EDGE: f64 = 1e-6;

/// Results of a trace. Absent if the samples do not reach the ends of the evaluation range to 1/20
/// of it, or cover less than 3/4 of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Values {
    /// f_Hα or f_Hβ: slope of the least-squares line over the whole evaluation range, extended to
    /// the reference length. A hole is filled with the most likely course of the flank.
    pub slope_um: f64,
    /// Standard error of the slope from the noise of the samples; crowning, reliefs and waviness
    /// count as flank. Covers independent noise and noise whose neighbours are correlated (with the
    /// warning `correlated_noise` where the samples do not determine the correlation), not errors
    /// that are equal along a trace (alignment, drift). Over a hole it includes the uncertainty of
    /// the flank there. Absent if the samples are too few.
    pub slope_std_error_um: Option<f64>,
    /// f_fα or f_fβ: peak to valley about the mean curve. Like the total deviation it has no
    /// interval: noise raises the greatest of many deviations, which is not a sum of them.
    pub form_um: f64,
    /// F_α or F_β: peak to valley about the design.
    pub total_um: f64,
    /// Height of the mean parabola over its chord; positive where material protrudes in the
    /// middle.
    pub crowning_um: f64,
    /// Standard error of the crowning, likewise.
    pub crowning_std_error_um: Option<f64>,
    /// f_Ko of a profile: the least-squares line of the tip relief at its tip end, above the
    /// extended least-squares line of the evaluation range; negative where material is missing.
    /// With `tip_relief_diameter_range_mm`, if the samples cover it.
    pub tip_relief_um: Option<f64>,
    /// Degrees of freedom of the noise that the standard errors are made of.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub freedom: Option<f64>,
    /// Warnings that the noise may be greater.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub doubts: Doubts,
    /// The least-squares line at both ends of the range, in the sign and direction of the posted
    /// deviations, about the design line if there is one.
    pub mean_line_um: [f64; 2],
    /// The least-squares parabola at the start, in the middle and at the end of the range,
    /// likewise.
    pub mean_parabola_um: [f64; 3],
    /// Part of the form deviation that is due to material outside the evaluation range; absent if
    /// there is none.
    pub form_plus_material_um: Option<f64>,
    /// The same part of the total deviation.
    pub total_plus_material_um: Option<f64>,
}

/// Which figures of a trace may have a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assessable {
    /// No class, and no figure either.
    Nothing,
    /// No class, though there are figures: the samples do not reach both ends of the range.
    Figures,
    /// The slope only, where two standard errors up and down have one class: over a hole a form may
    /// be anything.
    Slope,
    /// All classes and figures.
    Everything,
}

/// Neighbouring outliers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = OutlierPlace)
)]
pub struct Suspect {
    /// Roll length (profiles) or z (helices) of the first sample.
    pub from_mm: f64,
    /// Roll length or z of the last sample.
    pub to_mm: f64,
    /// Number of samples.
    pub samples: usize,
    /// Greatest height above the neighbours, positive where material protrudes.
    pub height_um: f64,
    /// True if material protrudes at an end, as a burr does, where at least half of the other
    /// traces of the same flank and kind have less than half of it; needs three traces.
    #[cfg_attr(feature = "contract", serde(default))]
    pub burr: bool,
}

/// Samples that deviate from their neighbours by more than six times the scale (1.4826 × median
/// absolute deviation) of the trace and of their own neighbourhood, and after which the trace
/// returns.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = TraceOutliers)
)]
pub struct Suspects {
    /// In ascending order.
    pub places: Vec<Suspect>,
    /// Results without them, if they count (`outliers` of the evaluation is `keep`) and enough
    /// samples remain.
    pub without: Option<WithoutSuspects>,
}

/// Results of a trace without its outliers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = FiguresWithoutOutliers)
)]
pub struct WithoutSuspects {
    /// f_Hα or f_Hβ.
    pub slope_um: f64,
    /// f_fα or f_fβ.
    pub form_um: f64,
    /// F_α or F_β.
    pub total_um: f64,
    /// Crowning; positive where material protrudes in the middle.
    pub crowning_um: f64,
}

impl From<Values> for WithoutSuspects {
    fn from(Values { slope_um, form_um, total_um, crowning_um, .. }: Values) -> Self {
        WithoutSuspects { slope_um, form_um, total_um, crowning_um }
    }
}
