//! What the samples of a trace cover of the evaluation range, and which figures and classes they
//! tell by it.

use super::{
    Notice,
    spacing::{LEAST_COVERED, LONGEST_DISTANCE, Spacing},
    subject::{Assessable, Subject},
};
use crate::fault::words::{Shown, counted};

/// Shares are sums of rounded numbers.
const ROUNDING: f64 = 1e-9;

/// What the samples tell: whether they reach both ends of the range to one distance of neighbouring
/// samples (they are discrete), leave no hole in it, and cover enough of it.
pub(super) fn assessable(subject: &Subject, u: &[f64], spacing: &Spacing, notices: &mut Vec<Notice>) -> Assessable {
    let window = subject.window;
    let half = 0.5 * window.length();
    let place = |u: f64| Shown(((window.low + half * (u + 1.0)) * 1e4).round() / 1e4);
    let percent = |share: f64| Shown((1e3 * share).round() / 10.0);
    let reached = spacing.open_end == 0.0;
    let figures = spacing.tells_figures();
    let too_little =
        format!("{} % of the range are covered, less than {} %", percent(spacing.covered), percent(LEAST_COVERED));
    if !reached && let (Some(first), Some(last)) = (u.first(), u.last()) {
        let why = if figures {
            "slope and crowning are by how the flank most likely goes on, and no class is given".into()
        } else if spacing.open_end <= LONGEST_DISTANCE {
            format!("no figures and no class are given: {too_little}")
        } else {
            format!(
                "no figures and no class are given: nothing is extended beyond {} % of the range",
                percent(LONGEST_DISTANCE)
            )
        };
        let detail = format!(
            "defined samples from {} to {} mm do not cover the evaluation range from {} to {} mm: {why}",
            place(*first),
            place(*last),
            Shown(window.low),
            Shown(window.high)
        );
        subject.note(notices, "range_not_covered", detail);
    }
    if spacing.is_sparse() {
        let detail = format!(
            "samples are {} mm apart, more than {} % of the evaluation range: form and total deviation may be greater \
             than what they show",
            Shown((half * spacing.usual * 1e4).round() / 1e4),
            percent(LONGEST_DISTANCE)
        );
        subject.note(notices, "sparse_samples", detail);
    }
    if !spacing.holes.is_empty() {
        let [from, to] = longest(&spacing.holes);
        let detail = format!(
            "{} without samples within the evaluation range, the longest from {} to {} mm: {}",
            counted(spacing.holes.len(), "stretch", "stretches"),
            place(from),
            place(to),
            match (figures, reached) {
                (true, true) => format!(
                    "form and total deviation have no class; slope and crowning are by how the flank most likely goes \
                     on between ({} % of the range are covered)",
                    percent(spacing.covered)
                ),
                (true, false) => "no class is given".into(),
                (false, _) if spacing.covered >= LEAST_COVERED => "no figures and no class are given".into(),
                (false, _) => format!("no figures and no class are given: {too_little}"),
            }
        );
        subject.note(notices, "hole_in_trace", detail);
    }
    // one stretch as long as the longest distance may be missing without a word
    if spacing.share_missing() > LONGEST_DISTANCE * (1.0 + ROUNDING) {
        let [from, to] = longest(&spacing.missing);
        let detail = format!(
            "{} % of the evaluation range lie in {} where samples are missing, the longest from {} to {} mm: {}",
            percent(spacing.share_missing()),
            counted(spacing.missing.len(), "stretch", "stretches"),
            place(from),
            place(to),
            match (figures, spacing.covered >= LEAST_COVERED) {
                (true, _) => "form and total deviation may be greater than what the samples show".into(),
                (false, true) => "no figures and no class are given".into(),
                (false, false) => format!("no figures and no class are given: {too_little}"),
            }
        );
        subject.note(notices, "samples_missing", detail);
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
