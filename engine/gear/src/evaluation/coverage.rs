//! Coverage of the evaluation range by the samples of a trace, and which figures and classes they
//! determine.

use super::{
    spacing::{LEAST_COVERED, LONGEST_DISTANCE, Spacing},
    subject::Subject,
    values::Assessable,
    warning::{Effect, TraceWarning, Warning},
};

/// Shares are sums of rounded numbers.
const ROUNDING: f64 = 1e-9;

/// Coverage by the samples: whether they reach both ends of the range to one distance of
/// neighbouring samples (they are discrete), leave no hole in it, and cover enough of it.
pub(super) fn assessable(subject: &Subject, u: &[f64], spacing: &Spacing, warnings: &mut Vec<Warning>) -> Assessable {
    let window = subject.window;
    let half = 0.5 * window.length();
    let place = |u: f64| window.low + half * (u + 1.0);
    let reached = spacing.open_end == 0.0;
    let figures = spacing.determines_figures();
    let nothing = match spacing.covered >= LEAST_COVERED {
        true => Effect::Nothing,
        false => Effect::TooLittleCovered { covered: spacing.covered },
    };
    if !reached && let (Some(first), Some(last)) = (u.first(), u.last()) {
        let effect = match figures {
            true => Effect::Extended,
            false if spacing.open_end > LONGEST_DISTANCE => Effect::TooFarToExtend,
            false => Effect::TooLittleCovered { covered: spacing.covered },
        };
        let (samples_mm, range_mm) = ([place(*first), place(*last)], [window.low, window.high]);
        subject.warn(warnings, TraceWarning::RangeNotCovered { samples_mm, range_mm, effect });
    }
    if spacing.is_sparse() {
        subject.warn(warnings, TraceWarning::SparseSamples { distance_mm: half * spacing.usual });
    }
    if !spacing.holes.is_empty() {
        let effect = match (figures, reached) {
            (true, true) => Effect::Bridged { covered: spacing.covered },
            (true, false) => Effect::NoClass,
            (false, _) => nothing,
        };
        let (count, longest_mm) = (spacing.holes.len(), longest(&spacing.holes).map(place));
        subject.warn(warnings, TraceWarning::HoleInTrace { count, longest_mm, effect });
    }
    // one stretch as long as the longest distance may be missing without a word
    let share = spacing.share_missing();
    if share > LONGEST_DISTANCE * (1.0 + ROUNDING) {
        let effect = if figures { Effect::LowerBound } else { nothing };
        let (count, longest_mm) = (spacing.missing.len(), longest(&spacing.missing).map(place));
        subject.warn(warnings, TraceWarning::SamplesMissing { share, count, longest_mm, effect });
    }
    match (figures, reached, spacing.holes.is_empty()) {
        (false, ..) => Assessable::Nothing,
        (true, false, _) => Assessable::Figures,
        (true, true, false) => Assessable::Slope,
        (true, true, true) => Assessable::Everything,
    }
}

fn longest(stretches: &[[f64; 2]]) -> [f64; 2] {
    stretches.iter().copied().fold([0.0, 0.0], |a, b| if b[1] - b[0] > a[1] - a[0] { b } else { a })
}
