//! Of evaluations.

use serde_json::{Value, json};

use super::Params;
use flankfit_engine::gear::{
    Kind,
    evaluation::warning::{
        Effect, FlankName, PitchWarning, RunoutWarning, SurfaceWarning, TraceWarning, Warning, share,
    },
};

impl From<&Warning> for Params {
    fn from(warning: &Warning) -> Self {
        let none = Params::new();
        match warning {
            Warning::OutsideTheStandard(out) => out.into(),
            Warning::ForeignReferenceLength { kind, reference, longest } => none
                .with("kind", if *kind == Kind::Profile { "profile" } else { "helix" })
                .with("reference_mm", *reference)
                .with("longest_mm", *longest),
            Warning::NearBaseCircle(roll) => none.with("roll_deg", roll.to_degrees()),
            Warning::Trace { trace, warning } => Params::from(warning).with("trace", *trace),
            Warning::FiguresUndetermined { figures, share_zero, flanks } => none
                .list("figures", figures.iter().map(|figure| crate::api::gears::notice::name(*figure)))
                .with("traces_share_zero", *share_zero)
                .list("flanks", flanks.iter().map(flank)),
            Warning::SurfaceMisfit { flank: of, apart, own } => {
                none.with("flank", flank(of)).with("rms_together_um", *apart).with("rms_own_um", *own)
            }
            Warning::HelixSignDoubtful { flank: of, apart, turned } => {
                none.with("flank", flank(of)).with("rms_um", *apart).with("rms_turned_um", *turned)
            }
            // it holds nothing
            _ => none,
        }
    }
}

impl From<&TraceWarning> for Params {
    fn from(warning: &TraceWarning) -> Self {
        let none = Params::new();
        match warning {
            TraceWarning::UndefinedSamples(count)
            | TraceWarning::TooFewSamples(count)
            | TraceWarning::NoMeanCurve(count) => none.with("count", *count),
            TraceWarning::RangeNotCovered { samples, range, effect: of } => {
                none.range("samples_mm", *samples).range("range_mm", *range).effect(*of)
            }
            TraceWarning::SparseSamples(distance) => none.with("distance_mm", *distance),
            TraceWarning::HoleInTrace { count, longest, effect: of } => {
                none.with("count", *count).range("longest_mm", *longest).effect(*of)
            }
            TraceWarning::SamplesMissing { share, count, longest, effect: of } => {
                none.with("share", *share).with("count", *count).range("longest_mm", *longest).effect(*of)
            }
            TraceWarning::OutliersSuspected { first, more, excluded, .. } => {
                let place = |place: &flankfit_engine::gear::evaluation::Suspect| {
                    json!({"from_mm": place.from, "to_mm": place.to, "samples": place.samples,
                           "height_um": place.height, "burr": place.burr})
                };
                none.list("places", first.iter().map(place)).with("more", *more).with("excluded", *excluded)
            }
            TraceWarning::SlopeClassOpen { slope, std_error } => {
                none.with("slope_um", *slope).with("std_error_um", *std_error)
            }
            // it holds nothing
            _ => none,
        }
    }
}

impl From<&SurfaceWarning> for Params {
    fn from(warning: &SurfaceWarning) -> Self {
        let none = Params::new();
        match *warning {
            SurfaceWarning::RangeNotCovered { reached, range, .. } => {
                none.range("reached_mm", reached).range("range_mm", range).with("covered", share(reached, range))
            }
            SurfaceWarning::BeyondFace { span, face_width } => {
                none.with("span_mm", span).with("face_width_mm", face_width)
            }
            _ => none,
        }
    }
}

impl From<&PitchWarning> for Params {
    fn from(warning: &PitchWarning) -> Self {
        let none = Params::new();
        match warning {
            PitchWarning::PitchesDoNotClose(sum) => none.with("sum_um", *sum),
            PitchWarning::MissingTeeth { missing, teeth } => none.with("missing", *missing).with("teeth", *teeth),
            PitchWarning::OutsideTheStandard(out) => out.into(),
            _ => none,
        }
    }
}

impl From<&RunoutWarning> for Params {
    fn from(warning: &RunoutWarning) -> Self {
        let none = Params::new();
        match warning {
            RunoutWarning::MissingSpaces { missing, spaces } => none.with("missing", *missing).with("spaces", *spaces),
            RunoutWarning::OutsideTheStandard(out) => out.into(),
            _ => none,
        }
    }
}

impl Params {
    /// What becomes of figures and classes.
    fn effect(self, effect: Effect) -> Self {
        match effect {
            Effect::Nothing => self.with("effect", "nothing"),
            Effect::TooLittleCovered(share) => self.with("effect", "too_little_covered").with("covered", share),
            Effect::TooFarToExtend => self.with("effect", "too_far_to_extend"),
            Effect::NoClass => self.with("effect", "no_class"),
            Effect::Extended => self.with("effect", "extended"),
            Effect::Bridged(share) => self.with("effect", "bridged").with("covered", share),
            Effect::LowerBound => self.with("effect", "lower_bound"),
        }
    }
}

fn flank(name: &FlankName) -> Value {
    json!({"tooth": name.tooth, "flank": name.side})
}
