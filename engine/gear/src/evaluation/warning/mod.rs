//! Warnings about an evaluation: data with a stable code and a sentence.

mod samples;
mod surface;

pub use samples::{Effect, TraceWarning};
pub use surface::{SurfaceWarning, share};

use std::fmt;

use super::settings::reference_length;
use crate::{Kind, Side, tolerance::OutOfScope};
use flankfit_estimation::FitError;
use flankfit_numerics::{
    warnings,
    words::{Shown, counted, listed},
};

warnings! {
/// Something that the reader of an evaluation of traces must know. Lengths are mm.
pub enum Warning {
    /// A gear outside the scope of ISO 1328-1.
    #[error("no classes: {0}")]
    "outside_the_standard" => OutsideTheStandard(OutOfScope),
    /// A gear without a face width, by which helices have tolerances.
    #[error("no classes of the helix: tolerances need the face width of the gear")]
    "no_face_width" => NoFaceWidth,
    /// Slopes extended to a length that the gear has not got: tolerances say nothing about them.
    #[error(
        "slopes are extended to {} mm, more than the {} mm of the gear: no classes",
        Shown(*.reference_mm), Shown(*.longest_mm)
    )]
    "foreign_reference_length" => ForeignReferenceLength { kind: Kind, reference_mm: f64, longest_mm: f64 },
    /// A range that begins near the base circle.
    #[error(
        "the evaluation range begins at {}° of roll, close to the base circle, where the involute ends and a small \
         error of diameter is a large error of roll length",
        hundredth(*.roll_deg)
    )]
    "near_base_circle" => NearBaseCircle { roll_deg: f64 },
    /// Something about one trace.
    #[error("{warning}")]
    in warning => Trace {
        /// Number of the trace, from 0.
        trace: usize,
        /// The warning.
        #[cfg_attr(feature = "contract", serde(flatten))]
        warning: TraceWarning,
    },
    /// Figures of surfaces that the traces of these flanks do not determine.
    #[error("{}", undetermined(.figures, *.traces_share_zero, .flanks))]
    "figures_not_determined" => FiguresUndetermined {
        /// Which ones.
        figures: Vec<SurfaceFigure>,
        /// Whether all traces share one zero.
        traces_share_zero: bool,
        /// Names of the flanks.
        flanks: Vec<FlankName>,
    },
    /// Traces that contradict any surface of second order, rms in µm.
    #[error(
        "{flank}: the traces contradict a common surface of second order by {rms_together_um:.2} µm rms, while each \
         deviates by {rms_own_um:.2} µm from its own parabola; check signs, sections and teeth of the traces before \
         using its figures"
    )]
    "surface_misfit" => SurfaceMisfit {
        /// Flank of these traces.
        flank: FlankName,
        /// Rms that they leave together.
        rms_together_um: f64,
        /// Rms that each leaves of a parabola of its own.
        rms_own_um: f64,
    },
    /// Traces that contradict each other less with the helices turned, rms in µm.
    #[error(
        "{flank}: with the sign of the helices reversed the contradiction falls from {rms_um:.2} to \
         {rms_turned_um:.2} µm rms; check `deviation_sign`, the sign of helix deviations"
    )]
    "helix_sign_doubtful" => HelixSignDoubtful { flank: FlankName, rms_um: f64, rms_turned_um: f64 },
}
}

impl Warning {
    /// Path to what it speaks of, where that is one thing.
    pub fn path(&self) -> Option<String> {
        match self {
            Warning::NoFaceWidth => Some("gear.face_width_mm".to_owned()),
            Warning::ForeignReferenceLength { kind, .. } => Some(format!("evaluation.{}", reference_length(*kind))),
            Warning::NearBaseCircle { .. } => Some("evaluation.profile_diameter_range_mm".to_owned()),
            Warning::Trace { trace, .. } => Some(format!("traces[{trace}].deviation_um")),
            Warning::HelixSignDoubtful { .. } => Some("evaluation.deviation_sign".to_owned()),
            Warning::OutsideTheStandard(_) | Warning::FiguresUndetermined { .. } | Warning::SurfaceMisfit { .. } => {
                None
            }
        }
    }
}

warnings! {
/// Something that the reader of pitch deviations must know.
pub enum PitchWarning {
    /// Single pitches whose sum is not 0, µm.
    #[error(
        "the single pitch deviations add up to {} µm around the gear instead of 0; the sum was distributed evenly",
        Shown(*.sum_um)
    )]
    "pitches_do_not_close" => PitchesDoNotClose { sum_um: f64 },
    /// Teeth that were not measured.
    #[error(
        "{} of {teeth} missing: the values of the others are lower bounds for the whole gear; no class is given",
        counted(*.missing, "tooth", "teeth")
    )]
    "missing_teeth" => MissingTeeth { missing: usize, teeth: usize },
    /// A gear outside the scope of ISO 1328-1.
    #[error("no classes: {0}")]
    "outside_the_standard" => OutsideTheStandard(OutOfScope),
}
}

impl PitchWarning {
    /// Says that it speaks of the list of what was measured, not of the gear.
    pub fn is_of_measured(&self) -> bool {
        match self {
            PitchWarning::PitchesDoNotClose { .. } | PitchWarning::MissingTeeth { .. } => true,
            PitchWarning::OutsideTheStandard(_) => false,
        }
    }
}

warnings! {
/// Something that the reader of a run-out must know.
pub enum RunoutWarning {
    /// Tooth spaces without a reading.
    #[error(
        "{} of {spaces} missing: the run-out of the others is a lower bound for the whole gear; no class is given",
        counted(*.missing, "tooth space", "tooth spaces")
    )]
    "missing_teeth" => MissingSpaces { missing: usize, spaces: usize },
    /// A gear outside the scope of ISO 1328-1.
    #[error("no class: {0}")]
    "outside_the_standard" => OutsideTheStandard(OutOfScope),
    /// Readings without a first harmonic, and why.
    #[error("no eccentricity: {}", reason(.error))]
    #[cfg_attr(feature = "contract", serde(skip))]
    "no_eccentricity" => NoEccentricity { error: FitError },
}
}

/// A figure of the second-order surface of a flank. Their order is that in which warnings stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "contract", derive(serde::Serialize))]
pub enum SurfaceFigure {
    /// −c_vv.
    #[cfg_attr(feature = "contract", serde(rename = "helix_crowning_um"))]
    HelixCrowning,
    /// 2 c_v.
    #[cfg_attr(feature = "contract", serde(rename = "helix_slope_um"))]
    HelixSlope,
    /// c.
    #[cfg_attr(feature = "contract", serde(rename = "mean_um"))]
    Mean,
    /// −c_uu.
    #[cfg_attr(feature = "contract", serde(rename = "profile_crowning_um"))]
    ProfileCrowning,
    /// 2 c_u.
    #[cfg_attr(feature = "contract", serde(rename = "profile_slope_um"))]
    ProfileSlope,
    /// 4 c_uv.
    #[cfg_attr(feature = "contract", serde(rename = "twist_um"))]
    Twist,
}

impl fmt::Display for SurfaceFigure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SurfaceFigure::HelixCrowning => "helix_crowning_um",
            SurfaceFigure::HelixSlope => "helix_slope_um",
            SurfaceFigure::Mean => "mean_um",
            SurfaceFigure::ProfileCrowning => "profile_crowning_um",
            SurfaceFigure::ProfileSlope => "profile_slope_um",
            SurfaceFigure::Twist => "twist_um",
        })
    }
}

/// A flank of a tooth.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize))]
pub struct FlankName {
    /// The tooth as its traces name it.
    pub tooth: String,
    /// Flank of the tooth.
    #[cfg_attr(feature = "contract", serde(rename = "flank"))]
    pub side: Side,
}

impl fmt::Display for FlankName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const LONGEST: usize = 20;
        let side = if self.side == Side::Left { "left" } else { "right" };
        let end = self.tooth.char_indices().nth(LONGEST).map_or(self.tooth.len(), |(end, _)| end);
        write!(f, "tooth {} {side}", &self.tooth[..end])
    }
}

/// The sentence about figures that are not determined.
fn undetermined(figures: &[SurfaceFigure], share_zero: bool, flanks: &[FlankName]) -> impl fmt::Display {
    const NAMED: usize = 5;
    let why = match share_zero {
        true => "too few traces, or all along one line",
        false => "each trace has a zero of its own (`traces_share_zero` is false), so only its slope and shape count",
    };
    fmt::from_fn(move |f| {
        let (figures, first) = (listed(figures), listed(&flanks[..flanks.len().min(NAMED)]));
        write!(
            f,
            "the traces do not determine {figures} of the surface: {why}; slopes without a twist are those in the \
             sections of the traces ({first}"
        )?;
        match flanks.len().saturating_sub(NAMED) {
            0 => f.write_str(")"),
            more => write!(f, ", {more} more)"),
        }
    })
}

fn reason(error: &FitError) -> String {
    error.faults().map_or_else(|| error.to_string(), |faults| faults.list()[0].message.clone())
}

fn hundredth(x: f64) -> Shown {
    Shown((x * 100.0).round() / 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_flanks_figures_and_places() {
        let flank = |tooth: &str| FlankName { tooth: tooth.to_owned(), side: Side::Left };
        let flanks: Vec<FlankName> = (1..=7).map(|tooth: u32| flank(&tooth.to_string())).collect();
        let figures = vec![SurfaceFigure::Mean, SurfaceFigure::Twist];
        let open = Warning::FiguresUndetermined { figures, traces_share_zero: true, flanks };
        assert_eq!(
            open.to_string(),
            "the traces do not determine mean_um, twist_um of the surface: too few traces, or all along one line; \
             slopes without a twist are those in the sections of the traces (tooth 1 left, tooth 2 left, tooth 3 \
             left, tooth 4 left, tooth 5 left, 2 more)"
        );
        assert_eq!((open.code(), open.path()), ("figures_not_determined", None));
        assert_eq!(flank(&"é".repeat(30)).to_string(), format!("tooth {} left", "é".repeat(20)));
        let turned = Warning::HelixSignDoubtful { flank: flank("3"), rms_um: 2.346, rms_turned_um: 0.1 };
        assert!(turned.to_string().starts_with(
            "tooth 3 left: with the sign of the helices reversed the contradiction \
                falls from 2.35"
        ));
        let near = Warning::NearBaseCircle { roll_deg: 0.05_f64.to_degrees() };
        assert!(near.to_string().contains("2.86° of roll"), "{near}");
        let hole = TraceWarning::HoleInTrace {
            count: 1,
            longest_mm: [1.00004, 2.0],
            effect: Effect::Bridged { covered: 0.91234 },
        };
        assert_eq!(
            hole.to_string(),
            "1 stretch without samples within the evaluation range, the longest from 1 to 2 mm: form and total \
             deviation have no class; slope and crowning use the most likely course of the flank in between (91.2 % \
             of the range is covered)"
        );
    }
}
