//! What is said of samples that stand out of their neighbours ([`super::outliers`]).

use super::{
    outliers::{Run, outliers},
    samples::{Sample, Taken},
    subject::Subject,
    values::{FEWEST_SAMPLES, Suspect, Suspects},
    warning::TraceWarning,
};

/// Marks what stands out of its neighbours; the places of it that count otherwise.
pub(super) fn mark(all: &mut [Sample]) -> Vec<Run> {
    let column = |of: fn(&Sample) -> f64| all.iter().map(of).collect::<Vec<f64>>();
    let mut runs = outliers(&column(|s| s.at), &column(|s| s.deviation));
    runs.retain(|run| all[run.from..run.to].iter().any(|s| s.within || s.zone));
    for run in &runs {
        all[run.from..run.to].iter_mut().for_each(|sample| sample.suspect = true);
    }
    runs
}

/// The marked places, with the figures without them where they are not `excluded` anyway.
pub(super) fn suspects(subject: &Subject, all: &[Sample], runs: &[Run], excluded: bool) -> Suspects {
    let place = |run: &Run| Suspect {
        from: all[run.from].at,
        to: all[run.to - 1].at,
        samples: run.to - run.from,
        height: run.height,
    };
    let places = runs.iter().map(place).collect();
    let without = (!excluded).then(|| Taken::of(all, true));
    let told =
        |taken: &Taken| taken.u.len() >= FEWEST_SAMPLES && taken.spacing.places > 2 && taken.spacing.tells_figures();
    Suspects { places, without: without.filter(told).map(|taken| subject.figures(&taken)) }
}

impl Suspects {
    /// What is to be said of them.
    pub(super) fn warning(&self, excluded: bool) -> TraceWarning {
        let first = self.places.iter().take(TraceWarning::NAMED).copied().collect();
        let more = self.places.len() > TraceWarning::NAMED;
        TraceWarning::OutliersSuspected { first, more, excluded, without: self.without }
    }
}
